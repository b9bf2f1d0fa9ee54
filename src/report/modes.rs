//! Modes as a table.

use crate::modal::{ModalModel, Mode};

use super::{Block, Cell, Column, Table};

/// Identified modes of a test: frequency and damping with their deviations, complexity, method.
pub fn modes_block(test: &str, model: &ModalModel) -> Block {
    let columns = vec![
        Column::number("mode"),
        Column::number("f (Hz)"),
        Column::number("std f (Hz)"),
        Column::number("damping (%)"),
        Column::number("std damping (%)"),
        Column::number("MPC"),
        Column::number("DOFs"),
        Column::text("method"),
        Column::text("remark"),
    ];
    let percent = |fraction: Option<f64>| fraction.map(|value| 100.0 * value);
    let row = |(index, mode): (usize, &Mode)| {
        vec![
            Cell::text((index + 1).to_string()),
            Cell::number(Some(mode.frequency_hz), 3),
            Cell::number(mode.frequency_std_hz, 4),
            Cell::number(percent(mode.damping_ratio), 4),
            Cell::number(percent(mode.damping_std), 4),
            Cell::number(mode.mpc, 4),
            Cell::text(mode.shape.len().to_string()),
            mode.method.clone().map_or(Cell::Missing, Cell::Text),
            Cell::text(remarks(model, mode)),
        ]
    };
    let mut footnotes =
        vec!["f: natural frequency |λ|/2π; std: one standard deviation.".to_owned()];
    if let Some(band) = model.band {
        footnotes.push(format!(
            "Band searched: {} to {} Hz.",
            short(band.lo_hz),
            short(band.hi_hz)
        ));
    }
    if let Some(decay) = model.added_damping_rad_s.filter(|decay| *decay > 0.0) {
        footnotes.push(format!(
            "The exponential window's {} rad/s are taken out of every pole.",
            short(decay)
        ));
    }
    footnotes.extend(synthetic_note(model));
    Block::Table(Table {
        caption: format!("Identified modes: {test}"),
        columns,
        rows: model.modes.iter().enumerate().map(row).collect(),
        footnotes,
    })
}

/// Modes of a model or a truth.
pub fn theory_block(caption: &str, model: &ModalModel) -> Block {
    let columns = vec![
        Column::number("mode"),
        Column::number("f (Hz)"),
        Column::number("omega (rad/s)"),
        Column::number("damping (%)"),
        Column::number("group"),
    ];
    let row = |(index, mode): (usize, &Mode)| {
        vec![
            Cell::text((index + 1).to_string()),
            Cell::number(Some(mode.frequency_hz), 6),
            Cell::number(Some(std::f64::consts::TAU * mode.frequency_hz), 6),
            Cell::number(mode.damping_ratio.map(|zeta| 100.0 * zeta), 4),
            mode.group
                .map_or(Cell::Missing, |group| Cell::text(group.to_string())),
        ]
    };
    let mut footnotes = Vec::new();
    if model.modes.iter().any(|mode| mode.group.is_some()) {
        footnotes.push("Modes of one group are one repeated root.".to_owned());
    }
    footnotes.extend(synthetic_note(model));
    Block::Table(Table {
        caption: caption.to_owned(),
        columns,
        rows: model.modes.iter().enumerate().map(row).collect(),
        footnotes,
    })
}

/// Codes of the warnings that belong to one mode.
fn remarks(model: &ModalModel, mode: &Mode) -> String {
    use crate::finding::{Place, Severity};
    let belongs = |place: &Place| matches!(place, Place::Mode(hz) if (hz - mode.frequency_hz).abs() <= 1e-9 * mode.frequency_hz);
    let warnings = model
        .findings
        .iter()
        .filter(|f| f.severity > Severity::Info && belongs(&f.place));
    let mut names: Vec<String> = warnings.map(|finding| finding.code.name()).collect();
    names.sort();
    names.dedup();
    names.join(", ")
}

fn synthetic_note(model: &ModalModel) -> Option<String> {
    let synthetic = model
        .findings
        .iter()
        .any(|finding| finding.code == crate::finding::Code::Synthetic);
    synthetic.then(|| "Synthetic: computed from a model, nobody measured it.".to_owned())
}

/// Six significant digits without trailing zeros.
fn short(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
