//! Modes out, as dataset 55 (field table: `dataset_55`), in SI units.
//!
//! A mode whose damping, modal A or B is known or whose shape is complex is written as a complex
//! eigenvalue with complex values, any other as a normal mode with real ones. Modal A that is not
//! known follows from the modal mass m as 2iω_d m and modal B as −λA; what is unknown is 0. Numbers
//! have the six digits of E13.5, the widest that other readers take; the last of the five ID lines
//! keep frequency, damping and modal mass to the last digit ([`ModeNote`]), the first the title of
//! the mode, or of the file.
//!
//! A node has three values, or six when a rotation is known, or one where all are scalars. Those
//! that are not known have to be 0; the note says so. At nodes with a local displacement system the
//! values are turned back into it. Left out with a finding: values at points that are no node
//! number, scalars beside directions and repeated measurements; standard deviations, residues,
//! method and order.

use std::collections::BTreeMap;
use std::io::Write;
use std::ops::Range;

use num_complex::Complex64;

use super::mode_note::ModeNote;
use super::{ALONG, Frames, KINDS, Root};
use crate::dof::{Axis, Dof};
use crate::finding::Finding;
use crate::geometry::Geometry;
use crate::io::formats::dropped_content::DroppedContent;
use crate::io::formats::uff::fields::fixed_columns::{fortran, line_text};
use crate::io::formats::uff::geometry::write::{frames, node_label};
use crate::io::{IoError, ModeEntry};
use crate::linalg::Vector3;
use crate::modal::{Mode, Pole};

/// Part of a vector that is rounding of its turn.
const ROUNDING: f64 = 1e-12;

/// Values of a node along [`Axis::ALL`]: scalar, X, Y, Z, RX, RY, RZ; `None` where nothing is
/// known.
type Row = [Option<Complex64>; 7];
/// Values of a mode by node.
type Rows = BTreeMap<i64, Row>;

/// Writes the modes; see the module head. `title` names modes without a title.
///
/// # Errors
/// [`IoError::System`] when writing fails.
pub(in crate::io::formats::uff) fn write_modes(
    out: &mut dyn Write,
    modes: &[ModeEntry],
    geometry: &Geometry,
    title: &str,
    path: &str,
) -> Result<Vec<Finding>, IoError> {
    let mut lost = DroppedContent::default();
    let finite = |entry: &&ModeEntry| {
        let damping = entry.mode.damping_ratio;
        entry.mode.frequency_hz.is_finite() && damping.is_none_or(f64::is_finite)
    };
    let written: Vec<&ModeEntry> = modes.iter().filter(finite).collect();
    lost.add("modes without a frequency", modes.len() - written.len());
    let shapes: Vec<Rows> = written
        .iter()
        .map(|entry| rows(&entry.mode, &mut lost))
        .collect();
    let unmeasured: Vec<bool> = shapes.iter().map(lacks_directions).collect();
    let filled = shapes
        .iter()
        .zip(&unmeasured)
        .filter(|(_, is_filled)| **is_filled);
    count_zeros(&filled.map(|(rows, _)| rows).collect::<Vec<_>>(), &mut lost);
    let frames = frames(geometry);
    for (i, (entry, rows)) in written.iter().zip(shapes).enumerate() {
        let rows = in_local_systems(rows, &frames, &mut lost);
        let note = ModeNote::of(&entry.mode, unmeasured[i]);
        let id_lines = id_lines(entry, note, title, &mut lost);
        let text = dataset(i + 1, entry, &rows, &id_lines, &mut lost);
        out.write_all(text.as_bytes())
            .map_err(|source| IoError::System {
                path: path.to_owned(),
                action: "write",
                source,
            })?;
    }
    Ok(lost.findings())
}

/// Values that a row of the dataset has of each node.
fn columns(rows: &Rows) -> Range<usize> {
    let any = |range: Range<usize>| {
        let mut all = rows.values().flat_map(|row| &row[range.clone()]);
        all.any(Option::is_some)
    };
    match (any(4..7), any(1..4), any(0..1)) {
        (true, ..) => 1..7,
        (false, false, true) => 0..1,
        _ => 1..4,
    }
}

/// Whether a direction of a node has to be filled with 0.
fn lacks_directions(rows: &Rows) -> bool {
    let columns = columns(rows);
    let mut all = rows.values().flat_map(|row| &row[columns.clone()]);
    all.any(Option::is_none)
}

/// Values of a shape along the positive axes, by node.
fn rows(mode: &Mode, lost: &mut DroppedContent) -> Rows {
    let mut rows = Rows::new();
    let place = |dof: &Dof| {
        let column = Axis::ALL.iter().position(|axis| *axis == dof.axis())?;
        Some((node_label(dof.point())?, column))
    };
    for (dof, value) in mode.shape.iter() {
        let there = lost.or_add("shape values without node number", place(dof));
        let Some((node, column)) = there else {
            continue;
        };
        let row = rows.entry(node).or_default();
        let value = value * dof.sign();
        if row[column].is_some() || dof.repeat() > 1 {
            lost.add("shape values of repeated measurements", 1);
        } else if !value.is_finite() {
            lost.add("shape values that are not finite", 1);
        } else {
            row[column] = Some(value);
        }
    }
    if columns(&rows).start > 0 {
        let scalars = rows.values_mut().filter_map(|row| row[0].take());
        lost.add("scalar shape values beside directions", scalars.count());
    }
    rows.retain(|_, row| row.iter().any(Option::is_some));
    rows
}

/// Counts what a reader of modes that lack directions cannot tell from one that was never measured,
/// and the other way about.
fn count_zeros(shapes: &[&Rows], lost: &mut DroppedContent) {
    let mut known: BTreeMap<(i64, usize), bool> = BTreeMap::new();
    for (node, row) in shapes.iter().copied().flatten() {
        for (column, value) in row.iter().enumerate() {
            if let Some(value) = value {
                *known.entry((*node, column)).or_default() |= value.norm() > 0.0;
            }
        }
    }
    let still = known.values().filter(|moving| !**moving).count();
    lost.add("degrees of freedom that are 0 in every mode", still);
    let rows = shapes.iter().copied().flatten();
    let missing = rows.map(|(node, row)| {
        let absent =
            |column: &usize| row[*column].is_none() && known.get(&(*node, *column)) == Some(&true);
        (0..7).filter(absent).count()
    });
    lost.add("missing shape values, written as 0", missing.sum());
}

/// Values turned into the displacement systems of their nodes; a node where that takes values that
/// are not known is left out.
fn in_local_systems(rows: Rows, frames: &Frames, lost: &mut DroppedContent) -> Rows {
    let turn = |(node, row): (i64, Row)| match frames.get(&node) {
        None => Some((node, row)),
        Some(frame) => {
            let what = "nodes with a local system and some directions alone";
            lost.or_add(what, local(&row, frame).map(|row| (node, row)))
        }
    };
    rows.into_iter().filter_map(turn).collect()
}

/// Values along the local directions `frame` of a row of global ones.
fn local(row: &Row, frame: &[Vector3; 3]) -> Option<Row> {
    let mut out = Row::default();
    out[0] = row[0];
    for (first, _) in [1, 4].into_iter().zip(KINDS) {
        let global = &row[first..first + 3];
        let size: f64 = global.iter().flatten().map(|v| v.norm()).sum();
        for (i, direction) in frame.iter().enumerate() {
            let along = |j: &usize| direction[*j].abs() > ALONG;
            let known = |j: &usize| global[*j].is_some();
            let terms = (0..3).filter(along).filter(known);
            let value: Complex64 = terms.filter_map(|j| Some(global[j]? * direction[j])).sum();
            if value.norm() <= ROUNDING * size {
                out[first + i] = global.iter().any(Option::is_some).then(Complex64::default);
            } else if (0..3).filter(along).all(|j| known(&j)) {
                out[first + i] = Some(value);
            } else {
                return None;
            }
        }
    }
    Some(out)
}

fn dataset(
    number: usize,
    entry: &ModeEntry,
    rows: &Rows,
    id_lines: &str,
    lost: &mut DroppedContent,
) -> String {
    let mode = &entry.mode;
    let values = || rows.values().flatten().flatten();
    let complex = mode.damping_ratio.is_some()
        || entry.modal_a.or(entry.modal_b).is_some()
        || values().any(|value| value.im != 0.0);
    let columns = columns(rows);
    let per_node = columns.len();
    let (root, reals) = root(entry, complex);
    count_lost(entry, root.as_ref(), lost);

    let mut text = String::from("    -1\n    55\n");
    text.push_str(id_lines);
    let (analysis, data_type) = if complex { (3, 5) } else { (2, 2) };
    let characteristic = per_node / 3 + 1;
    text.push_str(&format!(
        "{:>10}{analysis:>10}{characteristic:>10}{:>10}{data_type:>10}{per_node:>10}\n",
        1, 8
    ));
    text.push_str(&format!(
        "{:>10}{:>10}{:>10}{number:>10}\n",
        2,
        reals.len(),
        1
    ));
    text.push_str(&real_rows(&reals));
    for (node, row) in rows {
        text.push_str(&format!("{node:>10}\n"));
        let filled = row[columns.clone()]
            .iter()
            .map(|value| value.unwrap_or_default());
        let parts = filled.flat_map(|value| [Some(value.re), complex.then_some(value.im)]);
        text.push_str(&real_rows(&parts.flatten().collect::<Vec<f64>>()));
    }
    text.push_str("    -1\n");
    text
}

/// The pole as a reader will find it, and record 8.
fn root(entry: &ModeEntry, complex: bool) -> (Option<Root>, Vec<f64>) {
    let mode = &entry.mode;
    if !complex {
        let reals = vec![
            mode.frequency_hz,
            mode.modal_mass_kg.unwrap_or(0.0),
            0.0,
            0.0,
        ];
        return (Root::normal(&reals), reals);
    }
    let zeta = mode.damping_ratio.unwrap_or(0.0);
    let lambda = Pole::from_frequency(mode.frequency_hz, zeta).lambda;
    let from_mass = |mass: f64| Complex64::new(0.0, 2.0 * lambda.im * mass);
    let modal_a = entry.modal_a.or(mode.modal_mass_kg.map(from_mass));
    let modal_b = entry.modal_b.or(modal_a.map(|a| -lambda * a));
    let numbers = [
        lambda,
        modal_a.unwrap_or_default(),
        modal_b.unwrap_or_default(),
    ];
    let reals: Vec<f64> = numbers.iter().flat_map(|v| [v.re, v.im]).collect();
    (Root::complex(&reals), reals)
}

/// Counts the properties of a mode that dataset 55 has no field for.
fn count_lost(entry: &ModeEntry, root: Option<&Root>, lost: &mut DroppedContent) {
    let mode = &entry.mode;
    let agrees = |mass: f64| {
        let read = root.and_then(Root::modal_mass);
        read.is_some_and(|read| (read - mass).abs() <= 1e-9 * mass.abs())
    };
    let stds = [
        mode.frequency_std_hz,
        mode.damping_std,
        mode.frequency_damping_correlation,
    ];
    let several = mode.shape_std.as_ref().map_or(0, BTreeMap::len);
    let numbers = stds.iter().flatten().count() + several;
    lost.add(
        "modal masses",
        usize::from(mode.modal_mass_kg.is_some_and(|mass| !agrees(mass))),
    );
    lost.add("standard deviations of modes", numbers);
    let bias = mode.frequency_bias_hz.or(mode.damping_bias);
    lost.add(
        "biases of frequency and damping",
        usize::from(bias.is_some()),
    );
    lost.add("residues of modes", mode.residues.len());
    lost.add("shapes of other quantities", mode.other_shapes.len());
    lost.add(
        "phase collinearity of modes",
        usize::from(mode.mpc.is_some()),
    );
    let method = mode.method.is_some() || mode.order.is_some();
    lost.add("method and order of modes", usize::from(method));
}

/// Five ID lines: title lines first, the note last.
fn id_lines(entry: &ModeEntry, note: ModeNote, title: &str, lost: &mut DroppedContent) -> String {
    let note = note.to_lines();
    let room = 5usize.saturating_sub(note.len());
    let of_file = [title.to_owned()];
    let titles = if entry.title.is_empty() {
        &of_file[..]
    } else {
        &entry.title[..]
    };
    lost.add("title lines of modes", titles.len().saturating_sub(room));
    let mut lines: Vec<String> = titles
        .iter()
        .take(room)
        .map(|title| line_text(title))
        .collect();
    lines.resize(room, String::new());
    lines.extend(note);
    let filled = lines
        .iter()
        .map(|line| if line.is_empty() { "NONE" } else { line });
    filled.flat_map(|line| [line, "\n"]).collect()
}

/// Rows of 6 E13.5.
fn real_rows(numbers: &[f64]) -> String {
    let mut text = String::new();
    for row in numbers.chunks(6) {
        text.extend(
            row.iter()
                .map(|number| format!("{:>13}", fortran(*number, 5))),
        );
        text.push('\n');
    }
    text
}
