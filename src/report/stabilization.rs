//! The stabilization table lists the poles of all model orders.

use crate::identify::PoleAtOrder;

use super::{Block, Cell, Column, Table};

/// Poles of all model orders with frequency, damping and status.
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
            "alone: unstable, recurs over fewer than three orders; stable: recurs over more, but not selected as a mode; chosen: selected as a mode.".to_owned(),
        ],
    })
}
