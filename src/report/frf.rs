//! FRFs as a table of what was estimated.

use crate::axis::Band;
use crate::frf::FrfSet;

use super::{Block, Cell, Column, Table};

/// One row per function, with the median coherence over the usable band.
pub fn frf_block(set: &FrfSet, usable: Band, hits: usize) -> Block {
    let lines = set.axis().lines(&usable);
    let row = |index: usize| {
        let function = &set.functions()[index];
        vec![
            Cell::text(function.response.to_string()),
            Cell::text(function.reference.to_string()),
            Cell::text(function.kind.to_string()),
            Cell::text(function.kind.si_unit()),
            function
                .averages
                .map_or(Cell::Missing, |n| Cell::text(n.to_string())),
            function
                .estimator
                .map_or(Cell::Missing, |estimator| Cell::text(estimator.name())),
            Cell::number(
                set.coherence(index)
                    .and_then(|values| median(&values[lines.clone()])),
                4,
            ),
        ]
    };
    let heads = [
        "response",
        "reference",
        "kind",
        "unit",
        "averages",
        "estimator",
    ];
    Block::Table(Table {
        caption: format!("{} FRFs from {hits} hits", set.len()),
        columns: heads
            .map(Column::text)
            .into_iter()
            .chain([Column::number("median coherence")])
            .collect(),
        rows: (0..set.len()).map(row).collect(),
        footnotes: vec![format!(
            "{} lines by {:.6} Hz; usable band {:.2} to {:.2} Hz (force within 20 dB, below 0.4 of the sampling rate).",
            set.axis().len,
            set.axis().step_hz,
            usable.lo_hz,
            usable.hi_hz
        )],
    })
}

fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}
