//! A drawn structure: its modes at all points where it could be hit or measured.

use num_complex::Complex64;
use rand_chacha::ChaCha8Rng;

use modalign::linalg::real_matrix;
use modalign::theory::{
    Coordinate, ModeOptions, Motion, SystemMatrices, TheoryModes, modes_of_matrices,
};

use super::error::PopulationError;
use super::span::Span;

/// Most modes that a structure brings and a test may want: what the elements of a beam and the
/// products of a plate hold to 1e-3 of their frequency.
pub(super) const MAX_MODES: usize = 12;

/// One mode at the points of its structure, in their order.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DrawnMode {
    pub frequency_hz: f64,
    /// `None` for a rigid-body mode.
    pub damping_ratio: Option<f64>,
    pub shape: Vec<Complex64>,
    /// Modes of one repeated root share a number.
    pub group: Option<u32>,
    /// The two modes of a close pair share a number.
    pub pair: Option<u32>,
}

/// How the residues follow from the shapes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shapes {
    /// Real, of unit modal mass: `A = phi phi^T / (2 i omega_d)`.
    Real,
    /// Complex, `A = phi phi^T`.
    Complex,
}

/// A drawn structure.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Structure {
    pub modes: Vec<DrawnMode>,
    pub shapes: Shapes,
    /// A point that has to be hit, from 0.
    pub reference: Option<usize>,
}

impl Structure {
    /// A structure of real shapes that may be hit anywhere.
    pub fn real(modes: Vec<DrawnMode>) -> Self {
        Self {
            modes,
            shapes: Shapes::Real,
            reference: None,
        }
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.modes.first().map_or(0, |mode| mode.shape.len())
    }
}

/// An elastic mode with a real shape.
pub(super) fn elastic(frequency_hz: f64, damping_ratio: f64, shape: Vec<f64>) -> DrawnMode {
    DrawnMode {
        frequency_hz,
        damping_ratio: Some(damping_ratio),
        shape: shape.into_iter().map(Complex64::from).collect(),
        group: None,
        pair: None,
    }
}

/// Undamped modes with a damping ratio drawn for every elastic root, log-uniform; a repeated root
/// has one ratio.
pub(super) fn damped(
    theory: &TheoryModes,
    damping_ratio: Span,
    shape: impl Fn(usize) -> Vec<f64>,
    random: &mut ChaCha8Rng,
) -> Vec<DrawnMode> {
    let mut modes: Vec<DrawnMode> = Vec::with_capacity(theory.omega_rad_s.len());
    for (j, mode) in theory.model.modes.iter().enumerate() {
        let before = modes.last();
        let same = before.filter(|last| mode.group.is_some() && last.group == mode.group);
        let ratio = match same.and_then(|last| last.damping_ratio) {
            Some(ratio) => ratio,
            None => damping_ratio.log_uniform(random),
        };
        modes.push(DrawnMode {
            damping_ratio: (j >= theory.rigid).then_some(ratio),
            group: mode.group.filter(|_| j >= theory.rigid),
            ..elastic(mode.frequency_hz, ratio, shape(j))
        });
    }
    modes
}

/// Masses in a row; spring `i` ties mass `i` to the one before it, the first and the last spring
/// tie to the ground.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    pub mass_kg: Vec<f64>,
    /// One more than there are masses; 0 where an end is free.
    pub stiffness_n_per_m: Vec<f64>,
}

impl Row {
    /// Draws a row of `n` masses with both ends held, masses and springs log-uniform.
    pub fn draw(n: usize, mass_kg: Span, stiffness: Span, random: &mut ChaCha8Rng) -> Self {
        let mut many = |span: Span, n| (0..n).map(|_| span.log_uniform(random)).collect();
        Self {
            mass_kg: many(mass_kg, n),
            stiffness_n_per_m: many(stiffness, n + 1),
        }
    }

    /// Its undamped matrices.
    pub fn matrices(&self) -> SystemMatrices {
        let (n, k) = (self.mass_kg.len(), &self.stiffness_n_per_m);
        SystemMatrices {
            mass: real_matrix(n, n, |i, j| if i == j { self.mass_kg[i] } else { 0.0 }),
            damping: None,
            stiffness: real_matrix(n, n, |i, j| match i.abs_diff(j) {
                0 => k[i] + k[i + 1],
                1 => -k[i.max(j)],
                _ => 0.0,
            }),
            coordinates: (0..n).map(coordinate).collect(),
            springs: Vec::new(),
        }
    }

    /// Its undamped modes.
    ///
    /// # Errors
    /// [`PopulationError::Theory`].
    pub fn modes(&self) -> Result<TheoryModes, PopulationError> {
        Ok(modes_of_matrices(
            &self.matrices(),
            &ModeOptions::default(),
        )?)
    }
}

/// The coordinate of mass `i` of a row.
pub(super) fn coordinate(i: usize) -> Coordinate {
    Coordinate {
        name: format!("x{i}"),
        body: format!("mass {i}"),
        motion: Motion::Translation,
        axis: [0.0, 0.0, 1.0],
        at_m: [i as f64, 0.0, 0.0],
    }
}

/// Column `j` of the vectors: the shape at every coordinate.
pub(super) fn column(modes: &TheoryModes, j: usize) -> Vec<f64> {
    (0..modes.vectors.nrows())
        .map(|i| modes.vectors[(i, j)])
        .collect()
}
