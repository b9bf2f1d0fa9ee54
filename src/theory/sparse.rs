//! The lowest modes of models with sparse matrices, with a count that proves that none is missing.

use std::f64::consts::TAU;

use crate::finding::{Code, Finding, Location, Severity};
use crate::linalg::{self, RealMatrix, SparseMatrix, SparseModes, Wanted};

use super::eigen::{Root, Solution, check_damping_ratio, check_entries, sizes};
use super::{Condensation, Coordinate, ModeOptions, TheoryError, TheoryModes};

/// Number of modes that are computed where neither a band nor a number is specified.
pub(super) const DEFAULT_MODES: usize = 30;
/// Maximum number of modes that are computed: beyond it full matrices cost less.
const MAX_MODES: usize = 2000;
/// A band's end is put up by this part, so that a mode at the end itself is counted for sure.
const BEYOND_END: f64 = 1e-6;

/// Matrices of `M x'' + C x' + K x = f` without their zeros, symmetric, of one size.
#[derive(Clone, Debug)]
pub struct SparseSystem {
    /// Mass, positive semidefinite.
    pub mass: SparseMatrix,
    /// Viscous damping; `None` for an undamped model.
    pub damping: Option<SparseMatrix>,
    /// Stiffness, positive semidefinite.
    pub stiffness: SparseMatrix,
    /// The coordinates, in the order of rows and columns.
    pub coordinates: Vec<Coordinate>,
}

/// Derivative of sparse matrices by one parameter.
#[derive(Clone, Debug)]
pub struct SparseDerivative {
    /// dM/dp.
    pub mass: SparseMatrix,
    /// dK/dp.
    pub stiffness: SparseMatrix,
}

/// The lowest modes of sparse matrices, with empty shapes: all coordinates are in
/// [`TheoryModes::vectors`].
///
/// With a band all modes up to its end, else as many as the options ask for, else the lowest
/// thirty; none of them is missing ([`crate::linalg::sparse_modes`]). A finding says up to which
/// frequency they were counted. Rigid-body modes, repeated roots, damping and the bound of rounding
/// are those of [`super::modes_of_matrices`]. Motions without mass are condensed statically there
/// as here.
///
/// # Errors
/// [`TheoryError::DampingRatio`], [`TheoryError::Mass`], [`TheoryError::MatrixSize`],
/// [`TheoryError::MatrixEntry`], [`TheoryError::NegativeStiffness`], [`TheoryError::Linalg`].
pub fn modes_of_sparse(
    system: &SparseSystem,
    options: &ModeOptions,
) -> Result<TheoryModes, TheoryError> {
    if let Some(got) = options.damping_ratio {
        check_damping_ratio(got)?;
    }
    check_system(system)?;
    let wanted = match (options.band, options.count) {
        (Some(band), _) => Wanted::Below(((1.0 + BEYOND_END) * TAU * band.hi_hz).powi(2)),
        (None, Some(count)) => Wanted::Lowest(count.max(1)),
        (None, None) => Wanted::Lowest(DEFAULT_MODES),
    };
    let stiffness = || Ok(system.stiffness.clone());
    let condensation = Condensation::of(&system.mass, stiffness, &system.coordinates)?;
    let raw = match &condensation {
        None => linalg::sparse_modes(&system.stiffness, &system.mass, wanted, MAX_MODES)?,
        Some(condensation) => {
            condensation.lowest_modes(&system.stiffness, &system.mass, wanted, MAX_MODES)?
        }
    };
    let solution = solution(system, &raw)?;
    if let Some((condensation, c)) = condensation.as_ref().zip(system.damping.as_ref()) {
        let forces = c.multiply(&solution.vectors);
        let magnitudes = magnitudes(c)?.multiply(&sizes(&solution.vectors));
        condensation.check_undamped(&forces, &magnitudes, &system.coordinates)?;
    }
    let damping = |j: usize| {
        let c = system.damping.as_ref()?;
        let energy = c.quadratic_form(&column(&solution.vectors, j));
        Some(energy.value / (2.0 * solution.omega_rad_s[j]))
    };
    let moved = |vectors: &RealMatrix| system.mass.multiply(vectors);
    let mut result = solution.kept(options, &damping, &moved);
    result.coordinates = system.coordinates.clone();
    let location = Location::Whole;
    let finding = Finding::new(Severity::Info, Code::LowestModesAlone, location);
    result.model.findings.extend(
        raw.counted_below
            .map(|limit| finding.value(limit.max(0.0).sqrt() / TAU, "Hz")),
    );
    let condensed = condensation.as_ref().map(Condensation::finding);
    result.model.findings.extend(condensed);
    Ok(result)
}

/// Magnitudes of the entries.
fn magnitudes(of: &SparseMatrix) -> Result<SparseMatrix, TheoryError> {
    let entries: Vec<_> = of.entries().map(|(i, j, v)| (i, j, v.abs())).collect();
    Ok(SparseMatrix::from_entries(of.size(), &entries)?)
}

fn check_system(system: &SparseSystem) -> Result<(), TheoryError> {
    let size = system.coordinates.len();
    check_symmetric("mass", &system.mass, size)?;
    check_symmetric("stiffness", &system.stiffness, size)?;
    system
        .damping
        .as_ref()
        .map_or(Ok(()), |c| check_symmetric("damping", c, size))
}

fn column(vectors: &RealMatrix, j: usize) -> Vec<f64> {
    vectors.col(j).iter().copied().collect()
}

fn solution(system: &SparseSystem, raw: &SparseModes) -> Result<Solution, TheoryError> {
    let pairs = raw.omega_squared.iter().zip(&raw.rounding);
    let size = raw.vectors.nrows();
    let roots = pairs.map(|(&value, &rounding)| Root::new(value, rounding, size));
    let roots = roots.collect::<Result<Vec<_>, _>>()?;
    let inverse_mass = |i: usize| 1.0 / system.mass.get(i, i);
    let total: Vec<f64> = (0..system.mass.size()).map(inverse_mass).collect();
    Ok(Solution::arranged(&raw.vectors, &roots, &total))
}

/// Finite entries, each equal to its mirror image up to the rounding of a sum.
pub(super) fn check_symmetric(
    name: &'static str,
    matrix: &SparseMatrix,
    expected: usize,
) -> Result<(), TheoryError> {
    let size = matrix.size();
    let places = matrix.entries().map(|(row, column, _)| (row, column));
    check_entries(name, expected, size, size, places, |i, j| matrix.get(i, j))
}
