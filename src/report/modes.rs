//! The mode tables list identified modes with their uncertainty and complexity, natural frequencies
//! of a model, energies and sensitivities.

use crate::axis::Band;
use crate::linalg::sort_descending_by;
use crate::modal::{ModalModel, Mode};
use crate::theory::{ModelRoot, ParameterSpec, RootSensitivity};

use super::{Block, Cell, Column, Table};

/// Identified modes of a test: frequency and damping with standard deviations, complexity, method.
pub fn modes_block(test: &str, model: &ModalModel) -> Block {
    let biased = model.modes.iter().any(|m| m.frequency_bias_hz.is_some());
    let mut columns = vec![
        Column::number("mode"),
        Column::number("f (Hz)"),
        Column::number("std f (Hz)"),
        Column::number("damping (%)"),
        Column::number("std damping (%)"),
    ];
    if biased {
        columns.push(Column::number("f error by out-of-band modes (Hz)"));
        columns.push(Column::number("damping error by out-of-band modes (%)"));
    }
    columns.extend([
        Column::number("MPC"),
        Column::number("MPD (°)"),
        Column::number("mean phase (°)"),
        Column::number("overlap"),
        Column::number("lines in −3 dB band"),
        Column::number("DOFs"),
        Column::text("method"),
        Column::text("quality"),
        Column::text("quality of f"),
        Column::text("quality of damping"),
        Column::text("quality of shape"),
        Column::text("remark"),
    ]);
    let percent = |fraction: Option<f64>| fraction.map(|value| 100.0 * value);
    let row = |(index, mode): (usize, &Mode)| {
        let mut cells = vec![
            Cell::text((index + 1).to_string()),
            Cell::number(Some(mode.frequency_hz), 3),
            Cell::std(mode.frequency_std_hz, 4),
            Cell::number(percent(mode.damping_ratio), 4),
            Cell::std(percent(mode.damping_std), 4),
        ];
        if biased {
            cells.push(Cell::std(mode.frequency_bias_hz, 4));
            cells.push(Cell::std(percent(mode.damping_bias), 4));
        }
        cells.extend([
            Cell::mac(mode.mpc, 4),
            Cell::number(mode.mean_phase_deviation_rad.map(f64::to_degrees), 1),
            Cell::number(mode.mean_phase_rad.map(f64::to_degrees), 1),
            Cell::number(mode.modal_overlap, 3),
            Cell::number(mode.half_power_lines, 1),
            Cell::text(mode.shape.len().to_string()),
            mode.method.clone().map_or(Cell::Missing, Cell::Text),
        ]);
        cells.extend(quality_cells(mode));
        cells.push(Cell::text(remarks(model, mode)));
        cells
    };
    let mut footnotes =
        vec![
            "f: natural frequency |λ|/2π; std: one standard deviation, in the unit of its column.".to_owned(),
            "MPC: 1 for a shape on one line of the complex plane, 0 for a circle; mean phase: ½ arg Σφ²; MPD: mean angle from it, weighted by |φ|.".to_owned(),
            "quality: whether it is a mode of the structure; quality of f, of damping, of shape: what these are worth (—: not assessed).".to_owned(),
            "overlap: half-power bandwidth 2ζf over the mean distance to the neighbouring modes; lines in −3 dB band: frequency lines across the half-power bandwidth as measured.".to_owned(),
        ];
    if biased {
        footnotes.push("Error by out-of-band modes: magnitude as estimated from the data; —: not estimated, contained in the standard deviation.".to_owned());
    }
    if let Some(band) = model.band {
        footnotes.push(format!(
            "Band searched: {} to {} Hz.",
            round_to_six_digits(band.lo_hz),
            round_to_six_digits(band.hi_hz)
        ));
    }
    if let Some(decay) = model.added_damping_rad_s.filter(|decay| *decay > 0.0) {
        footnotes.push(format!(
            "The {} rad/s of the exponential window are subtracted from the decay rate of every pole.",
            round_to_six_digits(decay)
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

/// Modes of a model, or the true modes of a synthetic test.
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
        footnotes.push("Modes of one group are a repeated root.".to_owned());
    }
    footnotes.extend(synthetic_note(model));
    Block::Table(Table {
        caption: caption.to_owned(),
        columns,
        rows: model.modes.iter().enumerate().map(row).collect(),
        footnotes,
    })
}

/// Labels of the roots of a model as the rows of the comparison table have them: `f1` for the first
/// elastic root, or with another number where a paper counts otherwise.
pub(super) fn root_labels(roots: &[ModelRoot], first_root: usize) -> Vec<String> {
    let mut number = first_root;
    let label = |root: &ModelRoot| {
        if root.omega_rad_s <= 0.0 {
            return "rigid body".to_owned();
        }
        number += 1;
        format!("f{}", number - 1)
    };
    roots.iter().map(label).collect()
}

/// Distinct natural frequencies of a model inside a band: label, multiplicity, frequency, class,
/// and the bodies with the largest kinetic energy.
pub fn roots_block(
    caption: &str,
    roots: &[ModelRoot],
    first_root: usize,
    band: Option<Band>,
) -> Block {
    let inside = |root: &&ModelRoot| {
        let hz = root.omega_rad_s / std::f64::consts::TAU;
        band.is_none_or(|band| band.contains(hz))
    };
    let row = |(label, root): (String, &ModelRoot)| {
        vec![
            Cell::text(label),
            Cell::text(root.modes.len().to_string()),
            Cell::number(Some(root.omega_rad_s / std::f64::consts::TAU), 6),
            Cell::number(Some(root.omega_rad_s), 6),
            root.class.clone().map_or(Cell::Missing, Cell::Text),
            Cell::text(largest_energy_fractions(root)),
        ]
    };
    Block::Table(Table {
        caption: caption.to_owned(),
        columns: vec![
            Column::text("mode"),
            Column::number("multiplicity"),
            Column::number("f (Hz)"),
            Column::number("omega (rad/s)"),
            Column::text("class"),
            Column::text("kinetic energy"),
        ],
        rows: root_labels(roots, first_root)
            .into_iter()
            .zip(roots)
            .filter(|(_, root)| inside(root))
            .map(row)
            .collect(),
        footnotes: vec![
            "Kinetic energy: the largest fractions by body; bodies of the same kind are summed."
                .to_owned(),
        ],
    })
}

/// Energy fractions of each natural frequency inside a band, percent: a column for every body and
/// for every name of springs or groups. Of more than forty bodies, the twenty with the largest
/// fractions have columns, and one column holds the others. `None` without natural frequencies.
pub fn energies_block(
    caption: &str,
    roots: &[ModelRoot],
    first_root: usize,
    band: Option<Band>,
) -> Option<Block> {
    let hz = |root: &ModelRoot| root.omega_rad_s / std::f64::consts::TAU;
    let inside = |root: &&ModelRoot| band.is_none_or(|band| band.contains(hz(root)));
    let strained = roots.iter().find(|root| !root.strain_energy.is_empty());
    let springs = strained.map_or(&[][..], |root| &root.strain_energy);
    let bodies = &roots.first()?.kinetic_energy;
    let shown: Vec<&ModelRoot> = roots.iter().filter(inside).collect();
    let kinds = [
        ("T", bodies.as_slice(), largest_bodies(&shown, bodies.len())),
        ("U", springs, (0..springs.len()).collect()),
    ];
    let mut columns = vec![Column::text("mode"), Column::number("f (Hz)")];
    for (kind, names, indices) in &kinds {
        let heads = indices
            .iter()
            .map(|&i| format!("{kind} {} (%)", names[i].0));
        let others = (indices.len() < names.len()).then(|| format!("{kind} others (%)"));
        columns.extend(heads.chain(others).map(Column::number));
    }
    let [(_, _, shown_bodies), (_, _, shown_springs)] = &kinds;
    let percent = |shares: &[(String, f64)], indices: &[usize], all: usize| -> Vec<Cell> {
        let share = |i: usize| shares.get(i).map(|(_, share)| 100.0 * share.max(0.0));
        let sum: f64 = indices.iter().filter_map(|&i| share(i)).sum();
        let others = (indices.len() < all).then(|| Cell::number(Some((100.0 - sum).max(0.0)), 3));
        let cells = indices.iter().map(|&i| Cell::number(share(i), 3));
        cells.chain(others).collect()
    };
    let row = |(label, root): (String, &ModelRoot)| {
        let mut cells = vec![Cell::text(label), Cell::number(Some(hz(root)), 4)];
        cells.extend(percent(&root.kinetic_energy, shown_bodies, bodies.len()));
        cells.extend(percent(&root.strain_energy, shown_springs, springs.len()));
        cells
    };
    Some(Block::Table(Table {
        caption: caption.to_owned(),
        columns,
        rows: root_labels(roots, first_root)
            .into_iter()
            .zip(roots)
            .filter(|(_, root)| inside(root))
            .map(row)
            .collect(),
        footnotes: vec![
            "T: fraction of the kinetic energy by body; U: fraction of the strain energy by spring or group of matrices; mean over the modes of a repeated root. For a spring of stiffness k, or a group that k scales: df/f = U/2 dk/k where k scales stiffness alone.".to_owned(),
        ],
    }))
}

/// Up to this number of bodies, each has a column.
const MAX_BODY_COLUMNS: usize = 40;
/// Columns of the bodies with the largest fractions, where there are more bodies than that.
const LARGEST_BODY_COLUMNS: usize = 20;

/// Indices, ascending, of the bodies that have columns.
fn largest_bodies(roots: &[&ModelRoot], count: usize) -> Vec<usize> {
    let mut indices: Vec<usize> = (0..count).collect();
    if count > MAX_BODY_COLUMNS {
        let largest = |i: &usize| {
            let shares = roots.iter().map(|root| root.kinetic_energy[*i].1);
            shares.fold(0.0, f64::max)
        };
        sort_descending_by(&mut indices, largest);
        indices.truncate(LARGEST_BODY_COLUMNS);
        indices.sort_unstable();
    }
    indices
}

/// Relative sensitivity of each natural frequency above 0 inside a band to every parameter: a row
/// for each parameter, with a dash where its value is 0.
pub fn sensitivities_block(
    caption: &str,
    parameters: &[(ParameterSpec, f64)],
    roots: &[RootSensitivity],
    band: Option<Band>,
) -> Block {
    let hz = |root: &RootSensitivity| root.omega_rad_s / std::f64::consts::TAU;
    let inside = |root: &&RootSensitivity| band.is_none_or(|band| band.contains(hz(root)));
    let elastic = roots.iter().filter(|root| root.omega_rad_s > 0.0);
    let shown: Vec<&RootSensitivity> = elastic.filter(inside).collect();
    let mut columns = vec![Column::text("parameter")];
    let head = |root: &&RootSensitivity| {
        Column::number(format!(
            "{} Hz",
            Cell::measured(Some(hz(root)), None).display()
        ))
    };
    columns.extend(shown.iter().map(head));
    let row = |(j, (spec, value)): (usize, &(ParameterSpec, f64))| {
        let cell = |root: &&RootSensitivity| {
            let scaled = root.scaled(j, *value).filter(|_| value.abs() > 0.0);
            Cell::signed(scaled, 6)
        };
        let name = Cell::text(&spec.name);
        std::iter::once(name)
            .chain(shown.iter().map(cell))
            .collect()
    };
    Block::Table(Table {
        caption: caption.to_owned(),
        columns,
        rows: parameters.iter().enumerate().map(row).collect(),
        footnotes: vec![
            "(df/f)/(dp/p), in closed form from the derivatives of the matrices; mean over the branches of a repeated root. —: the parameter is 0, or an integer, which has no derivative.".to_owned(),
        ],
    })
}

/// Number of bodies named for each natural frequency.
const MAX_NAMED_BODIES: usize = 3;

/// The largest fractions of the kinetic energy, as `planet-disc 0.62, ball 0.30`, without those
/// that print as 0.00.
pub(super) fn largest_energy_fractions(root: &ModelRoot) -> String {
    let shares = root.energy_by_kind();
    let texts = shares.iter().filter(|(_, share)| *share >= 0.005);
    let texts: Vec<String> = texts
        .take(MAX_NAMED_BODIES)
        .map(|(body, share)| format!("{body} {share:.2}"))
        .collect();
    texts.join(", ")
}

/// Grades of a mode: its verdict, and those of frequency, damping and shape.
fn quality_cells(mode: &Mode) -> [Cell; 4] {
    let quality = mode.quality.as_ref();
    let grades = [
        quality.map(|quality| quality.verdict),
        quality.and_then(|quality| quality.frequency),
        quality.and_then(|quality| quality.damping),
        quality.and_then(|quality| quality.shape),
    ];
    grades.map(|grade| grade.map_or(Cell::Missing, |grade| Cell::text(grade.name())))
}

/// Codes of the warnings that belong to one mode.
pub(super) fn remarks(model: &ModalModel, mode: &Mode) -> String {
    use crate::finding::{Location, Severity};
    let belongs = |location: &Location| matches!(location, Location::Mode(hz) if (hz - mode.frequency_hz).abs() <= 1e-9 * mode.frequency_hz);
    let warnings = model
        .findings
        .iter()
        .filter(|f| f.severity > Severity::Info && belongs(&f.location));
    let mut names: Vec<String> = warnings.map(|finding| finding.code.name()).collect();
    names.sort();
    names.dedup();
    names.join(", ")
}

pub(super) fn synthetic_note(model: &ModalModel) -> Option<String> {
    let synthetic = model
        .findings
        .iter()
        .any(|finding| finding.code == crate::finding::Code::Synthetic);
    synthetic.then(|| "Synthetic: computed from a model, not measured.".to_owned())
}

fn round_to_six_digits(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
