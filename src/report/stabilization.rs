//! The stabilisation diagram as a table.

use crate::identify::PoleAtOrder;

use super::{Block, Cell, Column, Table};

/// Poles of all model orders: frequency, damping and what became of each.
pub fn stabilization_block(test: &str, poles: &[PoleAtOrder]) -> Block {
    let columns = vec![
        Column::number("order"),
        Column::number("f (Hz)"),
        Column::number("damping (%)"),
        Column::text("status"),
    ];
    let row = |point: &PoleAtOrder| {
        vec![
            Cell::text(point.order.to_string()),
            Cell::number(Some(point.pole.natural_frequency_hz()), 3),
            Cell::number(Some(100.0 * point.pole.damping_ratio()), 4),
            Cell::text(point.status.name()),
        ]
    };
    Block::Table(Table {
        caption: format!("Poles of all model orders: {test}"),
        columns,
        rows: poles.iter().map(row).collect(),
        footnotes: vec![
            "alone: stays over fewer than three orders; stable: over more, but no mode was made of it; chosen: a mode's.".to_owned(),
        ],
    })
}
