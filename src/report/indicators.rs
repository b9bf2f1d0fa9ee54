//! The indicator table lists the mode indicator functions by frequency line.

use crate::identify::Indicators;

use super::{Block, Cell, Column, Table};

/// Definitions of the columns of [`indicators_block`].
pub const INDICATOR_DEFINITIONS: &str = "Mode indicator functions, R the receptances as a matrix of responses x references. Sum of FRFs: sum of omega |R|, peaks at modes. NMIF: 1 - sum(|Re R| |R|)/sum(|R|^2), near 1 at modes. CMIF: singular values of omega R, peak at modes, several at a repeated root. MvMIF: eigenvalues of Re R'Re R against Re R'Re R + Im R'Im R, fall at modes, several at a repeated root.";

/// A row for each line: sum of FRFs, NMIF, every CMIF and MvMIF.
pub fn indicators_block(test: &str, indicators: &Indicators) -> Block {
    let values = indicators.cmif.first().map_or(0, Vec::len);
    let mvmif_count = indicators
        .mvmif
        .iter()
        .flatten()
        .map(Vec::len)
        .max()
        .unwrap_or(0);
    let mut columns = vec![
        Column::number("f (Hz)"),
        Column::number("sum of FRFs (m/(N s))"),
        Column::number("NMIF"),
    ];
    columns.extend((1..=values).map(|j| Column::number(format!("CMIF {j} (m/(N s))"))));
    columns.extend((1..=mvmif_count).map(|j| Column::number(format!("MvMIF {j}"))));
    let row = |k: usize| {
        let mut cells = vec![
            Cell::number(Some(indicators.frequency_hz[k]), 4),
            Cell::number(Some(indicators.sum_of_frfs[k]), 6),
            Cell::number(indicators.nmif[k], 6),
        ];
        let cmif = indicators.cmif[k].iter();
        cells.extend(cmif.map(|value| Cell::number(Some(*value), 6)));
        let mvmif = |j: usize| {
            indicators.mvmif[k]
                .as_ref()
                .and_then(|values| values.get(j).copied())
        };
        cells.extend((0..mvmif_count).map(|j| Cell::number(mvmif(j), 6)));
        cells
    };
    Block::Table(Table {
        caption: format!("Mode indicator functions: {test}"),
        columns,
        rows: (0..indicators.frequency_hz.len()).map(row).collect(),
        footnotes: vec![INDICATOR_DEFINITIONS.to_owned()],
    })
}
