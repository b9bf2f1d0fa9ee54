//! The support of a model, as its matrices show it, and its modes without the stiffness to ground.

use std::f64::consts::TAU;

use crate::linalg::{RealMatrix, real_matrix};

use super::system::System;
use super::{
    Coordinate, ModeOptions, Motion, Spring, Support, SystemMatrices, TheoreticalModel,
    TheoryError, TheoryModes, modes_of_matrices,
};

/// Force of a rigid translation on a coordinate over the sum of the magnitudes of its terms, above
/// which the translation strains the model.
///
/// Larger, from about 1e-5: a bearing at one node of a stiff mesh is taken for no support. Smaller,
/// below 1e-9: matrices that another program wrote with nine digits are taken for supported. Test
/// `rounded_matrices_are_free_and_a_soft_bearing_is_a_support`.
const MIN_STRAINING_FORCE_RATIO: f64 = 1e-8;

/// Squared mass-weighted correlation of a mode with the modes of one root above which they are
/// counterparts. No two roots can exceed one half; below it a mode without a counterpart would get
/// one. Test `mode_without_counterpart_is_left_open`.
const MIN_COUNTERPART_CORRELATION: f64 = 0.5;

/// The support of a model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModelSupport {
    /// As the model states it.
    pub stated: Option<Support>,
    /// As the matrices show it: [`Support::Suspended`] or [`Support::Fixed`]; `None` for a model
    /// without translations and without a spring to ground.
    pub derived: Option<Support>,
    /// Highest frequency of a rigid translation of the whole model on its support, in Hz, by
    /// Rayleigh's quotient; `None` where the model has no translation.
    pub translation_hz: Option<f64>,
}

impl ModelSupport {
    /// The stated support, else the derived one.
    pub fn support(&self) -> Option<Support> {
        self.stated.or(self.derived)
    }
}

/// An elastic mode of a model with and without its stiffness to ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReleasedMode {
    /// With the stiffness, Hz.
    pub held_hz: f64,
    /// Without it, Hz: the root whose modes have most of the shape; `None` where none has half.
    pub free_hz: Option<f64>,
}

/// The support that a model states and the one that its matrices show.
///
/// A model is supported where a translation of all its bodies strains it, or where a spring ends
/// at one body alone. Zeros among its roots do not tell: the mechanism of a transmission moves
/// freely on fixed bearings.
///
/// # Errors
/// As [`TheoreticalModel::assemble`].
pub fn model_support(
    model: &dyn TheoreticalModel,
    values: &[f64],
) -> Result<ModelSupport, TheoryError> {
    let system = System::of(model, values)?;
    let (coordinates, springs) = match &system {
        System::Full(matrices) => (&matrices.coordinates, matrices.springs.as_slice()),
        System::Sparse(sparse) => (&sparse.coordinates, &[][..]),
    };
    let translations = translations(&system, coordinates);
    let is_strained = translations.iter().any(|translation| translation.strains);
    let to_ground = springs.iter().any(|s| is_to_ground(s, coordinates));
    let derived = if is_strained || to_ground {
        Some(Support::Fixed)
    } else if translations.is_empty() {
        None
    } else {
        Some(Support::Suspended)
    };
    let frequencies = translations.iter().filter_map(|translation| translation.hz);
    Ok(ModelSupport {
        stated: model.support(),
        derived,
        translation_hz: frequencies.reduce(f64::max),
    })
}

/// The elastic modes of a model, each with its frequency without the stiffness to ground.
///
/// `None` where the stiffness to ground is unknown, or where the model is not free without it.
///
/// # Errors
/// As [`TheoreticalModel::assemble`] and [`modes_of_matrices`].
pub fn released_modes(
    model: &dyn TheoreticalModel,
    values: &[f64],
) -> Result<Option<Vec<ReleasedMode>>, TheoryError> {
    let System::Full(held) = System::of(model, values)? else {
        return Ok(None);
    };
    // Subtracting the springs from K would leave its rounding, which may be negative.
    let stiffness = match model.stiffness_without_ground(values)? {
        Some(stiffness) => stiffness,
        None if held.springs.is_empty() => return Ok(None),
        None => stiffness_of_inner_springs(&held),
    };
    let free = SystemMatrices {
        stiffness,
        ..held.clone()
    };
    let free_system = System::Full(free.clone());
    let translations = translations(&free_system, &free.coordinates);
    if translations.is_empty() || translations.iter().any(|translation| translation.strains) {
        return Ok(None);
    }
    let options = ModeOptions::default();
    let (on_ground, released) = (
        modes_of_matrices(&held, &options)?,
        modes_of_matrices(&free, &options)?,
    );
    let projections = on_ground.vectors.transpose() * (&held.mass * &released.vectors);
    let elastic = on_ground.rigid..on_ground.omega_rad_s.len();
    let mode = |mode: usize| ReleasedMode {
        held_hz: on_ground.omega_rad_s[mode] / TAU,
        free_hz: counterpart_hz(&released, |j| projections[(mode, j)]),
    };
    Ok(Some(elastic.map(mode).collect()))
}

/// Frequency of the root whose modes together have most of a shape, where that is more than half.
fn counterpart_hz(modes: &TheoryModes, projection: impl Fn(usize) -> f64) -> Option<f64> {
    let root_of = |j: usize| modes.model.modes[j].group;
    let count = modes.omega_rad_s.len();
    let is_of_root =
        |j: usize, k: usize| j == k || root_of(j).is_some() && root_of(j) == root_of(k);
    let is_rigid = |j: usize| j < modes.rigid;
    let correlation = |j: usize| -> f64 {
        let of_root = (0..count).filter(|k| is_of_root(j, *k) || is_rigid(j) && is_rigid(*k));
        of_root.map(|k| projection(k).powi(2)).sum()
    };
    let best = (0..count).max_by(|a, b| correlation(*a).total_cmp(&correlation(*b)))?;
    (correlation(best) > MIN_COUNTERPART_CORRELATION).then(|| modes.omega_rad_s[best] / TAU)
}

/// A rigid translation of the whole model along an axis.
struct Translation {
    /// Whether it strains the model.
    strains: bool,
    /// Rayleigh's quotient as a frequency; `None` where no mass moves.
    hz: Option<f64>,
}

/// The translations along x, y and z that move a coordinate.
fn translations(system: &System, coordinates: &[Coordinate]) -> Vec<Translation> {
    let along = |axis: usize| {
        let motion = |coordinate: &Coordinate| match coordinate.motion {
            Motion::Translation => coordinate.axis[axis],
            Motion::Rotation | Motion::Arc => 0.0,
        };
        let x = real_matrix(coordinates.len(), 1, |i, _| motion(&coordinates[i]));
        (x.norm_max() > 0.0).then(|| translation(system, &x))
    };
    (0..3).filter_map(along).collect()
}

fn translation(system: &System, x: &RealMatrix) -> Translation {
    let (forces, terms) = (system.stiffness(x), system.stiffness_terms(x));
    let momentum = system.mass(x);
    let rows = 0..x.nrows();
    let strained = |i: usize| forces[(i, 0)].abs() > MIN_STRAINING_FORCE_RATIO * terms[(i, 0)];
    let with_x = |y: &RealMatrix| -> f64 { rows.clone().map(|i| x[(i, 0)] * y[(i, 0)]).sum() };
    let (stiffness, mass) = (with_x(&forces), with_x(&momentum));
    let strains = rows.clone().any(strained);
    let omega_squared = if strains {
        stiffness.max(0.0) / mass
    } else {
        0.0
    };
    Translation {
        strains,
        hz: (mass > 0.0).then(|| omega_squared.sqrt() / TAU),
    }
}

/// Whether a spring ends at one body alone: its other end is the ground.
fn is_to_ground(spring: &Spring, coordinates: &[Coordinate]) -> bool {
    let moved = spring.row.iter().zip(coordinates);
    let mut bodies = moved
        .filter(|(part, _)| part.abs() > 0.0)
        .map(|(_, c)| &c.body);
    let first = bodies.next();
    spring.stiffness.abs() > 0.0 && first.is_some_and(|first| bodies.all(|body| body == first))
}

/// The part of K of the springs between bodies.
fn stiffness_of_inner_springs(matrices: &SystemMatrices) -> RealMatrix {
    let springs = matrices.springs.iter();
    let springs: Vec<&Spring> = springs
        .filter(|spring| !is_to_ground(spring, &matrices.coordinates))
        .collect();
    let size = matrices.coordinates.len();
    real_matrix(size, size, |i, j| {
        let part = |spring: &&Spring| spring.stiffness * spring.row[i] * spring.row[j];
        springs.iter().map(part).sum()
    })
}
