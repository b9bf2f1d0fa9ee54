//! A mode as datasets 55 and 2414 give it, and what becomes of it at the end of a file, when units,
//! nodes and coordinate systems are known.
//!
//! **Pole.** The natural frequency is |λ|/2π of the eigenvalue, the damping ratio −Re λ/|λ|; a
//! conjugate pole (Im λ < 0) is turned to the positive one with its shape. A normal mode has its
//! frequency, and as damping ratio the viscous one, else half the hysteretic one; both 0 is
//! unknown. Writers that state decay rates or percent are recognised from all modes of the file
//! (`conventions`).
//!
//! **Degrees of freedom.** A row has values for all directions of a node. 0 is a value, as at the
//! supports of a computed shape, and stays; but measurement systems fill what was not measured with
//! zeros. Where ID lines or title name one, or a [`ModeNote`] says so, a direction that is exactly
//! zero in every such mode of the file is left out, with a finding; of all other files a comparison
//! decides (`ModalModel::unmeasured_dofs`). At a node with a local displacement system this is
//! decided in the local directions; a global direction is claimed where one of the measured local
//! ones has a part along it (more than 1e-6 of it). In other files it is else exactly 0.
//!
//! **Units.** SI value = file value / length factor of dataset 164 for translations; rotations are
//! in rad. Modal A, B and mass, which have the units of (shape)²/residue and (shape)² mass, are
//! divided by length and force factor; they are known only with dataset 164 or a [`ModeNote`], and
//! only for a displacement shape, and else left out with a finding.
//!
//! **Scale.** A shape keeps the scale of the file. One that is given as velocity or acceleration is
//! not divided by λ or λ²: its scale is arbitrary, no comparison of shapes sees the factor, and to
//! which of them modal A belongs differs from writer to writer. Complex modes state modal A
//! (residue φφᵀ/A); modal mass is A/(2iω_d) where that is real.

pub(super) mod conventions;
pub(super) mod dataset_2414;
pub(super) mod dataset_55;
mod mode_note;
mod node_data;
mod rigid_shape;
pub(super) mod write;

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

use num_complex::Complex64;

use super::dataset_164::Units;
use super::fields::{Line, Position, text_or_none};
use crate::dof::{Axis, Dof};
use crate::io::ModeEntry;
use crate::linalg::Vector3;
use crate::modal::{Mode, ModeShape, Pole, Scaling};
use mode_note::{ModeNote, is_note};
use node_data::Definition;

/// Half a unit of the sixth digit, and a little more for the rounding of what it is compared with.
const PRINTED: f64 = 5.1e-6;
/// A modal mass that is known from numbers of six digits.
const DERIVED: f64 = 2e-5;
/// Imaginary part of a modal mass from modal A that is still rounding.
const REAL_MASS: f64 = 1e-4;
/// A part of a direction that is not rounding of its printed axes.
pub(super) const ALONG: f64 = 1e-6;

/// The pole of a mode as a file states it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Root {
    Normal {
        frequency_hz: f64,
        modal_mass: f64,
        viscous: f64,
        hysteretic: f64,
    },
    Complex {
        lambda: Complex64,
        modal_a: Complex64,
        modal_b: Complex64,
    },
}

impl Root {
    /// From frequency, modal mass, viscous and hysteretic damping ratio; of which all but the
    /// frequency may be missing and are 0 then.
    pub fn normal(reals: &[f64]) -> Option<Self> {
        let real = |i: usize| reals.get(i).copied().unwrap_or(0.0);
        Some(Root::Normal {
            frequency_hz: reals.first()?.abs(),
            modal_mass: real(1),
            viscous: real(2),
            hysteretic: real(3),
        })
    }

    /// From λ, modal A and modal B, each with real and imaginary part; of which all but λ may be
    /// missing and are 0 then.
    pub fn complex(reals: &[f64]) -> Option<Self> {
        let real = |i: usize| reals.get(i).copied().unwrap_or(0.0);
        let number = |i: usize| Complex64::new(real(i), real(i + 1));
        (reals.len() >= 2).then(|| Root::Complex {
            lambda: number(0),
            modal_a: number(2),
            modal_b: number(4),
        })
    }

    /// Natural frequency, Hz.
    pub fn frequency_hz(&self) -> f64 {
        match *self {
            Root::Normal { frequency_hz, .. } => frequency_hz,
            Root::Complex { lambda, .. } => lambda.norm() / TAU,
        }
    }

    /// Damping ratio; `None` where nothing or 0 is said of a normal mode, or of a pole at the
    /// origin.
    pub fn damping_ratio(&self) -> Option<f64> {
        match *self {
            Root::Normal {
                viscous,
                hysteretic,
                ..
            } => Some(viscous)
                .filter(|ratio| *ratio != 0.0)
                .or(Some(hysteretic / 2.0).filter(|ratio| *ratio != 0.0)),
            Root::Complex { lambda, .. } => {
                Some(Pole { lambda }.damping_ratio()).filter(|_| lambda.norm() > 0.0)
            }
        }
    }

    /// Modal mass in file units; `None` where it is 0 or does not follow from modal A.
    pub fn modal_mass(&self) -> Option<f64> {
        match *self {
            Root::Normal { modal_mass, .. } => Some(modal_mass).filter(|mass| *mass != 0.0),
            Root::Complex {
                lambda, modal_a, ..
            } => {
                let mass = modal_a / Complex64::new(0.0, 2.0 * lambda.im);
                let real = mass.im.abs() <= REAL_MASS * mass.re;
                (real && mass.re > 0.0 && mass.re.is_finite()).then_some(mass.re)
            }
        }
    }

    /// Whether a note belongs to this pole: the frequency and damping that it keeps are printed
    /// like this.
    pub fn agrees(&self, note: &ModeNote) -> bool {
        let Some(frequency_hz) = note.frequency_hz else {
            return false;
        };
        match *self {
            Root::Normal {
                frequency_hz: printed_hz,
                ..
            } => near(frequency_hz, printed_hz),
            Root::Complex { lambda, .. } => {
                let zeta = note.damping_ratio.flatten().unwrap_or(0.0);
                let kept = Pole::from_frequency(frequency_hz, zeta).lambda;
                near(kept.re, lambda.re) && near(kept.im, lambda.im.abs())
            }
        }
    }
}

fn near(kept: f64, printed: f64) -> bool {
    (kept - printed).abs() <= PRINTED * printed.abs()
}

/// A mode before units and coordinate systems.
#[derive(Clone, Debug)]
pub(super) struct RawMode {
    pub at: Position,
    pub title: Vec<String>,
    pub note: ModeNote,
    pub root: Root,
    /// Viscous damping ratio that is stated beside an eigenvalue; 0 for none.
    pub damping_field: f64,
    pub definition: Definition,
    pub nodes: Vec<i64>,
    /// [`Definition::per_node`] values of each node.
    pub values: Vec<Complex64>,
}

/// ID lines without empty ones, `NONE` in any case and notes.
pub(super) fn titles(lines: &[&Line]) -> Vec<String> {
    lines
        .iter()
        .map(|line| text_or_none(&line.bytes))
        .filter(|line| !line.is_empty() && !line.eq_ignore_ascii_case("NONE"))
        .filter(|line| !is_note(line))
        .collect()
}

/// Axes of the values of a node.
fn axes(per_node: usize) -> &'static [Axis] {
    match per_node {
        1 => &Axis::ALL[..1],
        _ => &Axis::ALL[1..=per_node.min(6)],
    }
}

/// Measurement systems that fill with zeros, as words of a line in lower case.
const MEASUREMENT_SYSTEMS: [&str; 3] = ["testlab", "lms", "simcenter"];
/// Programs of the same makers that compute shapes.
const THEORY_PROGRAMS: [&str; 6] = [
    "virtual.lab",
    "virtual lab",
    "nastran",
    "femap",
    "samcef",
    "simcenter 3d",
];

/// Whether a line of text names a measurement system that fills what was not measured with zeros.
pub(super) fn names_measurement_system(line: &str) -> bool {
    let line = line.to_lowercase().replace("test.lab", "testlab");
    let mut words = line.split(|c: char| !c.is_alphanumeric());
    words.any(|word| MEASUREMENT_SYSTEMS.contains(&word))
        && !THEORY_PROGRAMS.iter().any(|name| line.contains(name))
}

/// Directions that are not zero in every mode, by node, and how many others there are.
#[derive(Clone, Debug, Default)]
pub(super) struct Measured {
    pub directions: BTreeMap<i64, BTreeSet<Axis>>,
    pub left_out: usize,
}

/// Finds the directions that are not zero in every one of some modes.
pub(super) fn measured<'a>(modes: impl Iterator<Item = &'a RawMode>) -> Measured {
    let mut moves: BTreeMap<(i64, Axis), bool> = BTreeMap::new();
    for mode in modes {
        let axes = axes(mode.definition.per_node);
        for (node, row) in mode.nodes.iter().zip(mode.values.chunks_exact(axes.len())) {
            for (axis, value) in axes.iter().zip(row) {
                *moves.entry((*node, *axis)).or_default() |= value.norm() > 0.0;
            }
        }
    }
    let mut measured = Measured::default();
    for ((node, axis), moves) in moves {
        if moves {
            measured.directions.entry(node).or_default().insert(axis);
        } else {
            measured.left_out += 1;
        }
    }
    measured
}

/// What a direction means that is 0 in every mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Zeros {
    /// It may have been measured, and is kept.
    Values,
    /// It was not measured, and is left out.
    Unmeasured,
}

/// Unit vectors of the displacement directions of nodes that do not count them in the global frame.
pub(super) type Frames = BTreeMap<i64, [Vector3; 3]>;

impl RawMode {
    /// Whether zeros stand for unmeasured directions: as the note of modalign says, else where the
    /// mode's lines or the file's title name a measurement system.
    pub fn is_filled(&self, title_names_system: bool) -> bool {
        let ours = self.note.frequency_hz.is_some();
        let named = || self.title.iter().any(|line| names_measurement_system(line));
        self.note.zeros_unmeasured || (!ours && (title_names_system || named()))
    }

    /// The note of modalign, where it belongs to this pole.
    fn note(&self) -> Option<&ModeNote> {
        Some(&self.note).filter(|note| self.root.agrees(note))
    }

    /// The modal mass of the note of modalign, where it belongs to the printed one.
    fn noted_mass(&self, units: Option<&Units>) -> Option<f64> {
        let mass = self.root.modal_mass().map(|mass| mass * to_si(units))?;
        let noted = self.note()?.modal_mass_kg?;
        ((noted - mass).abs() <= DERIVED * mass.abs()).then_some(noted)
    }

    /// Whether modal mass, A and B have a unit.
    fn scale_is_known(&self, units: Option<&Units>) -> bool {
        let displacement = matches!(self.definition.quantity, 0 | 1 | 8);
        displacement && (units.is_some() || self.noted_mass(units).is_some())
    }

    /// Whether modal mass, A or B are stated and have no unit.
    pub fn loses_scale(&self, units: Option<&Units>) -> bool {
        let stated = match self.root {
            Root::Normal { modal_mass, .. } => modal_mass != 0.0,
            Root::Complex {
                modal_a, modal_b, ..
            } => modal_a.norm() > 0.0 || modal_b.norm() > 0.0,
        };
        stated && !self.scale_is_known(units)
    }

    /// The mode in SI units and in the global frame, of the measured directions alone where zeros
    /// stand for unmeasured ones.
    pub fn entry(
        &self,
        units: Option<&Units>,
        measured: &Measured,
        zeros: Zeros,
        frames: &Frames,
    ) -> ModeEntry {
        let note = self.note();
        let frequency = note.and_then(|note| note.frequency_hz);
        let damping = note.and_then(|note| note.damping_ratio);
        let length = units.map_or(1.0, |units| units.length);
        let shape = self.shape(length, measured, zeros, frames);
        let mut mode = Mode::new(
            frequency.unwrap_or_else(|| self.root.frequency_hz()),
            damping.unwrap_or_else(|| self.root.damping_ratio()),
            shape,
            Scaling::Unknown,
        );
        mode.group = note.and_then(|note| note.group);
        self.set_mass(&mut mode, units, note);
        let mut entry = ModeEntry::new(mode);
        entry.title.clone_from(&self.title);
        entry.line = self.at.line;
        if let Root::Complex {
            lambda,
            modal_a,
            modal_b,
        } = self.root
            && self.scale_is_known(units)
        {
            let to_si = to_si(units);
            let turned = |value: Complex64| if lambda.im < 0.0 { value.conj() } else { value };
            let known = |value: Complex64| Some(turned(value * to_si)).filter(|v| v.norm() > 0.0);
            entry.modal_a = known(modal_a);
            entry.modal_b = known(modal_b);
        }
        entry
    }

    fn set_mass(&self, mode: &mut Mode, units: Option<&Units>, note: Option<&ModeNote>) {
        let mass = self.root.modal_mass().map(|mass| mass * to_si(units));
        let stated = mass.filter(|_| self.scale_is_known(units));
        mode.modal_mass_kg = self.noted_mass(units).or(stated);
        let unit = mode
            .modal_mass_kg
            .is_some_and(|mass| (mass - 1.0).abs() <= DERIVED);
        mode.scaling = match note.and_then(|note| note.scaling) {
            Some(scaling) => scaling,
            None if unit => Scaling::UnitModalMass,
            None => Scaling::Unknown,
        };
    }

    fn shape(&self, length: f64, measured: &Measured, zeros: Zeros, frames: &Frames) -> ModeShape {
        let axes = axes(self.definition.per_node);
        let conjugate = matches!(self.root, Root::Complex { lambda, .. } if lambda.im < 0.0);
        let mut shape: Vec<(Dof, Complex64)> = Vec::new();
        for (node, row) in self.nodes.iter().zip(self.values.chunks_exact(axes.len())) {
            let is_known = |axis: &Axis| {
                let directions = measured.directions.get(node);
                directions.is_some_and(|directions| directions.contains(axis))
            };
            let known = axes.iter().zip(row).filter(|(axis, _)| is_known(axis));
            let known: Vec<(Axis, Complex64)> = known.map(|(axis, v)| (*axis, *v)).collect();
            let mut global = match frames.get(node) {
                Some(frame) => turned(&known, frame),
                None => known,
            };
            if zeros == Zeros::Values {
                let others = axes.iter().filter(|axis| !has_axis(&global, **axis));
                let others: Vec<(Axis, Complex64)> =
                    others.map(|axis| (*axis, Complex64::ZERO)).collect();
                global.extend(others);
            }
            for (axis, value) in global {
                let value = if conjugate { value.conj() } else { value };
                let translation = axis.unit_vector().is_some() && !axis.is_rotation();
                let value = if translation { value / length } else { value };
                let dof = Dof::new(&node.to_string(), axis, false).ok();
                shape.extend(dof.map(|dof| (dof, value)));
            }
        }
        ModeShape::new(shape)
    }
}

fn has_axis(values: &[(Axis, Complex64)], axis: Axis) -> bool {
    values.iter().any(|(other, _)| *other == axis)
}

/// SI value of modal A, B or mass over the file's.
fn to_si(units: Option<&Units>) -> f64 {
    units.map_or(1.0, |units| 1.0 / (units.length * units.force))
}

/// Translations, then rotations.
pub(super) const KINDS: [&[Axis; 3]; 2] = [
    &[Axis::X, Axis::Y, Axis::Z],
    &[Axis::RX, Axis::RY, Axis::RZ],
];

/// Values along local directions, whose unit vectors are `frame`, as values along the global axes
/// that they reach.
fn turned(local: &[(Axis, Complex64)], frame: &[Vector3; 3]) -> Vec<(Axis, Complex64)> {
    let scalars = local.iter().filter(|(axis, _)| *axis == Axis::S);
    let mut global: Vec<(Axis, Complex64)> = scalars.copied().collect();
    for kind in KINDS {
        let components = local.iter().filter_map(|(axis, value)| {
            let direction = kind.iter().position(|axis_of_kind| axis_of_kind == axis)?;
            Some((frame[direction], *value))
        });
        let components: Vec<(Vector3, Complex64)> = components.collect();
        for (j, axis) in kind.iter().enumerate() {
            if components
                .iter()
                .any(|(direction, _)| direction[j].abs() > ALONG)
            {
                let sum = components
                    .iter()
                    .map(|(direction, value)| value * direction[j])
                    .sum();
                global.push((*axis, sum));
            }
        }
    }
    global
}
