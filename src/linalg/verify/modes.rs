//! Checks of natural frequencies and of the sparse factors behind them.

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, Mat, Par, Side};

use super::super::low_modes::{Level, LowModes};
use super::super::scaled_pair::{ScaledPair, SymmetricModes};
use super::super::sparse::{SparseMatrix, sparse_rayleigh_quotient};
use super::super::sparse_modes::SparseModes;
use super::super::{LinalgError, RealMatrix};
use super::{Check, RANDOM_VECTORS, backward_limit, larger, largest, norm_of_row, weighted_signs};

/// Lowest modes whose number is compared with the inertia, where there are as many.
const COUNTED_MODES: usize = 30;
/// Limit of the residual of a solution with a sparse factor over `(n + 10) eps` and the largest
/// entry of the solution, both scaled by the root of the diagonal. Larger: a pivot off by a hundred
/// of its roundings, `n eps`, is not found (`factors_broken_on_purpose_are_caught`). Smaller: right
/// factors fail; the largest figure of 79 was 0.25.
pub(in crate::linalg) const MAX_CHOLESKY_ERROR: f64 = 20.0;
/// The same of a factor that counts eigenvalues, which is pivoted within its blocks alone: the
/// largest figure of 140 right factors was 1.1. Larger: as above, figures from 650 up are of broken
/// factors. What fails is factored again beside the shift.
pub(in crate::linalg) const MAX_INERTIA_ERROR: f64 = 50.0;
/// Limit of `|Phi^T M Phi z - z|` of sparse modes, largest entry. Larger: vectors off by 1e-9 pass.
/// Smaller: right modes fail; the largest figure of 209 was 2e-14.
const MAX_SPARSE_ORTHONORMALITY_ERROR: f64 = 1e-9;
/// Limits of a low omega² against the Rayleigh quotient of its vector, as a part of it and over its
/// rounding bound. Larger: an omega² off by 1e-6, or by 100 rounding bounds, is not found
/// (`modes_broken_on_purpose_are_caught`). Smaller: right modes fail; their largest figure was
/// 0.005 of it.
const MAX_QUOTIENT_ERROR: [f64; 2] = [1e-7, 30.0];
/// Part of the largest omega² up to which each mode is compared with its Rayleigh quotient.
/// Smaller: an error of 1e-6 in a mode above it is less than
/// [`MAX_BACKWARD_ERROR`](super::MAX_BACKWARD_ERROR) allows with 2,000 coordinates (4e-4). Larger:
/// time without use.
const MAX_QUOTIENT_MODE_OVER_LARGEST: f64 = 1e-3;
/// Limits of `|phi - (omega^2 + s) (K + s M)^-1 M phi|` in the norm of the mass, as a number and
/// over the rounding bound of `omega^2 + s`. Larger: a mode in the place of another passes where
/// their frequencies are close. Smaller: right modes fail; sums of them reached 0.005 of these
/// limits.
const MAX_INVERSE_ERROR: [f64; 2] = [1e-6, 1e3];
/// Limit of the sum of these differences with random signs, each over its limit: a mode at its
/// limit is found beside others.
const MAX_SUM_OF_MODES: f64 = 0.5;
/// Part of an omega² that it must be above the one before, for the modes to be counted between
/// them.
const MIN_RELATIVE_GAP: f64 = 1e-4;

/// Checks the modes of a symmetric pair (K, M).
///
/// - All vectors: `Phi^T M Phi = I`.
/// - Modes from 1e-5 of the largest omega² up: `K Phi = M Phi Omega^2`, relative to that omega².
/// - Modes below it: omega² equals the Rayleigh quotient of its vector, and `(K + s M)^-1 M phi =
///   phi / (omega^2 + s)` with a Cholesky factor of `K + s M`; relative to each `omega^2 + s`, as a
///   residual relative to the norm of K says nothing of them.
/// - The number of the lowest modes is the number of negative eigenvalues of `K - sigma M`, sigma
///   between the last of them and the next mode: `K - sigma M + M Phi D Phi^T M` with a positive D
///   that moves these modes above sigma has a Cholesky factor only if there is no other.
///
/// # Errors
/// [`LinalgError::Inaccurate`]; [`LinalgError::ModesMissing`].
pub fn symmetric_modes(
    stiffness: &RealMatrix,
    mass: &RealMatrix,
    modes: &SymmetricModes,
) -> Result<(), LinalgError> {
    let pair = ScaledPair::new(stiffness, mass);
    let modes = pair.scaled(modes.clone());
    let mut low = LowModes::new(&pair, &modes.omega_squared);
    low.prepare(&modes)?;
    scaled_modes(&pair, &modes, &low)
}

/// [`symmetric_modes`] of a pair brought to order one, with the factor of its shifted stiffness.
pub(in crate::linalg) fn scaled_modes(
    pair: &ScaledPair,
    modes: &SymmetricModes,
    low: &LowModes<'_>,
) -> Result<(), LinalgError> {
    let check = Check::new("natural frequencies", pair.mass.as_ref());
    let n = pair.mass.nrows();
    check.complete(modes.omega_squared.len(), modes.vectors.as_ref())?;
    let falls = modes.omega_squared.windows(2).map(|pair| pair[0] - pair[1]);
    check.below(falls.fold(0.0, larger), 0.0)?;
    let z = weighted_signs::<f64>(n, |_| 1.0);
    let moved = pair.mass_times((&modes.vectors * &z).as_ref());
    let back = modes.vectors.transpose() * &moved - &z;
    check.below(
        largest(&back),
        backward_limit(n) * largest_diagonal_form(pair, modes),
    )?;
    upper_residual(&check, pair, modes, low.count())?;
    check_quotients(&check, pair, modes, low.count())?;
    lower_residuals(&check, pair, modes, low)?;
    check_count(pair, modes, low.count())
}

/// Largest `phi^T diag(M) phi` of modes with `phi^T M phi = 1`, at least 1: the terms whose
/// difference is the modal mass, as of masses between nodes.
fn largest_diagonal_form(pair: &ScaledPair, modes: &SymmetricModes) -> f64 {
    let form = |j: usize| {
        let entries = modes.vectors.col(j).iter().enumerate();
        entries.map(|(i, phi)| pair.mass[(i, i)] * phi * phi).sum()
    };
    (0..modes.vectors.ncols()).map(form).fold(1.0, larger)
}

/// `K Phi z - M Phi Omega^2 z` of the modes from `first` on, each row over the root of its mass.
fn upper_residual(
    check: &Check,
    pair: &ScaledPair,
    modes: &SymmetricModes,
    first: usize,
) -> Result<(), LinalgError> {
    let n = pair.mass.nrows();
    let mut z = weighted_signs::<f64>(n, |_| 1.0);
    z.subrows_mut(0, first).fill(0.0);
    let weighted = Mat::from_fn(n, RANDOM_VECTORS, |i, j| modes.omega_squared[i] * z[(i, j)]);
    let forces = pair.stiffness_times((&modes.vectors * &z).as_ref());
    let residual = forces - pair.mass_times((&modes.vectors * weighted).as_ref());
    let scaled = |i: usize, j: usize| residual[(i, j)] / pair.mass[(i, i)].sqrt();
    let size = modes.omega_squared.iter();
    let size = size.fold(0.0, |a: f64, b| a.max(b.abs()));
    let got = largest(&Mat::from_fn(n, RANDOM_VECTORS, scaled));
    check.below(got, backward_limit(n) * size)
}

/// Each mode from `first` on, up to [`MAX_QUOTIENT_MODE_OVER_LARGEST`], against its Rayleigh
/// quotient: an error of 1e-6 is too small a part of the largest omega² for [`upper_residual`].
fn check_quotients(
    check: &Check,
    pair: &ScaledPair,
    modes: &SymmetricModes,
    first: usize,
) -> Result<(), LinalgError> {
    let largest = modes.omega_squared.last().copied().unwrap_or(0.0);
    let up_to = |limit: f64| modes.omega_squared.partition_point(|value| *value <= limit);
    let first = first.max(up_to(-MAX_QUOTIENT_MODE_OVER_LARGEST * largest));
    let end = up_to(MAX_QUOTIENT_MODE_OVER_LARGEST * largest);
    if end <= first {
        return Ok(());
    }
    let vectors = modes.vectors.subcols(first, end - first);
    let forces = pair.stiffness_times(vectors);
    for j in 0..end - first {
        let omega_squared = modes.omega_squared[first + j];
        let quotient = vectors.col(j).transpose() * forces.col(j);
        let limit = (MAX_QUOTIENT_ERROR[0] * omega_squared.abs()).max(f64::EPSILON * largest);
        check.below((quotient - omega_squared).abs(), limit)?;
    }
    Ok(())
}

/// Each of the lowest modes against its Rayleigh quotient, and sums of them with random signs, each
/// over its limit, against one more step of shift and invert with the shift of their level.
fn lower_residuals(
    check: &Check,
    pair: &ScaledPair,
    modes: &SymmetricModes,
    low: &LowModes<'_>,
) -> Result<(), LinalgError> {
    for (place, level) in low.levels.iter().enumerate() {
        let first = low.levels.get(place + 1).map_or(0, |next| next.count);
        level_residuals(check, pair, modes, level, first)?;
    }
    Ok(())
}

/// The same of the modes of one level from `first` on.
fn level_residuals(
    check: &Check,
    pair: &ScaledPair,
    modes: &SymmetricModes,
    level: &Level,
    first: usize,
) -> Result<(), LinalgError> {
    let count = level.count - first;
    let vectors = modes.vectors.subcols(first, count);
    let shifted = |j: usize| modes.omega_squared[first + j] + level.shift;
    let forces = pair.stiffness_times(vectors);
    let mut limits = Vec::with_capacity(count);
    for j in 0..count {
        let (omega_squared, rounding) = (modes.omega_squared[first + j], modes.rounding[first + j]);
        let quotient = vectors.col(j).transpose() * forces.col(j);
        let limit =
            (MAX_QUOTIENT_ERROR[0] * omega_squared.abs()).max(MAX_QUOTIENT_ERROR[1] * rounding);
        check.below((quotient - omega_squared).abs(), limit)?;
        limits.push(MAX_INVERSE_ERROR[0].max(MAX_INVERSE_ERROR[1] * rounding / shifted(j)));
    }
    let z = weighted_signs::<f64>(count, |j| limits[j]);
    let weighted = Mat::from_fn(count, RANDOM_VECTORS, |i, j| shifted(i) * z[(i, j)]);
    let image = level.solve(&pair.mass_times((vectors * weighted).as_ref()));
    let difference = vectors * z - image;
    let moved = pair.mass_times(difference.as_ref());
    for probe in 0..RANDOM_VECTORS {
        let energy = difference.col(probe).transpose() * moved.col(probe);
        check.below(energy.abs().sqrt(), MAX_SUM_OF_MODES)?;
    }
    Ok(())
}

/// The number of the lowest modes against the inertia of `K - sigma M`.
fn check_count(pair: &ScaledPair, modes: &SymmetricModes, low: usize) -> Result<(), LinalgError> {
    let n = modes.omega_squared.len();
    let Some(counted) = count_to_gap(&modes.omega_squared, low.max(COUNTED_MODES.min(n))) else {
        // Where all modes are counted, or nothing separates them, that the vectors are complete is
        // the proof.
        return Ok(());
    };
    let next = modes.omega_squared[counted];
    let sigma = 0.5 * (modes.omega_squared[counted - 1] + next);
    let moved = pair.mass_times(modes.vectors.subcols(0, counted));
    let raised = Mat::from_fn(n, counted, |i, j| {
        moved[(i, j)] * (next - modes.omega_squared[j])
    });
    let mut shifted = Mat::from_fn(n, n, |i, j| {
        pair.stiffness[(i, j)] - sigma * pair.mass[(i, j)]
    });
    let rectangular = BlockStructure::Rectangular;
    matmul(
        shifted.as_mut(),
        BlockStructure::TriangularLower,
        Accum::Add,
        raised.as_ref(),
        rectangular,
        moved.transpose(),
        rectangular,
        1.0,
        Par::Seq,
    );
    match shifted.llt(Side::Lower) {
        Ok(_) => Ok(()),
        Err(_) => Err(LinalgError::ModesMissing {
            found: counted,
            needed: counted + 1,
        }),
    }
}

/// The least number of modes, from `first` on, after which the next one is above a gap.
fn count_to_gap(omega_squared: &[f64], first: usize) -> Option<usize> {
    let is_gap = |&j: &usize| {
        omega_squared[j] - omega_squared[j - 1] > MIN_RELATIVE_GAP * omega_squared[j].abs()
    };
    (first.max(1)..omega_squared.len()).find(is_gap)
}

/// Checks a factor of a sparse matrix by a solution: `A x = b` for `b = A z` of signs z over the
/// root of a diagonal, each row relative to that diagonal. It is the sum of the terms of the
/// diagonal of A, as `k_ii - sigma m_ii` may vanish.
///
/// # Errors
/// [`LinalgError::Inaccurate`].
pub(in crate::linalg) fn sparse_factor(
    limit: f64,
    a: &SparseMatrix,
    diagonal: &[f64],
    solve: impl Fn(&mut RealMatrix),
) -> Result<(), LinalgError> {
    let size = a.size();
    let check = Check {
        what: "sparse factor",
        rows: size,
        columns: size,
    };
    let root: Vec<f64> = diagonal.iter().map(|value| value.sqrt()).collect();
    let right = a.multiply(&weighted_signs::<f64>(size, |i| root[i]));
    let mut x = right.clone();
    solve(&mut x);
    let residual = right - a.multiply(&x);
    let rows = |of: &RealMatrix, power: i32| {
        let rows = (0..size).filter(|&i| root[i] > 0.0);
        rows.map(|i| norm_of_row(of, i) * root[i].powi(power))
            .fold(0.0, larger)
    };
    let limit = limit * (size as f64 + 10.0) * f64::EPSILON;
    check.below(rows(&residual, -1), limit * rows(&x, 1))
}

/// Checks modes of a sparse pair with a solver of `(K + s M) x = b`.
///
/// `Phi^T M Phi = I`, each omega² against the Rayleigh quotient of its vector, and `Phi = (K + s
/// M)^-1 M Phi (Omega^2 + s)`; that none is missing is proved by the count that the solver ends
/// with.
///
/// # Errors
/// [`LinalgError::Inaccurate`].
pub(in crate::linalg) fn sparse_modes(
    stiffness: &SparseMatrix,
    mass: &SparseMatrix,
    modes: &SparseModes,
    shift: f64,
    solve: impl Fn(&mut RealMatrix),
) -> Result<(), LinalgError> {
    let (n, count) = (mass.size(), modes.omega_squared.len());
    let check = Check {
        what: "natural frequencies",
        rows: n,
        columns: n,
    };
    let mut limits = Vec::with_capacity(count);
    for (j, &omega_squared) in modes.omega_squared.iter().enumerate() {
        let x: Vec<f64> = modes.vectors.col(j).iter().copied().collect();
        let (quotient, _) = sparse_rayleigh_quotient(stiffness, mass, &x);
        let rounding = modes.rounding[j];
        let nearest =
            (MAX_QUOTIENT_ERROR[0] * omega_squared.abs()).max(MAX_QUOTIENT_ERROR[1] * rounding);
        check.below((quotient - omega_squared).abs(), nearest)?;
        limits.push(
            MAX_INVERSE_ERROR[0].max(MAX_INVERSE_ERROR[1] * rounding / (omega_squared + shift)),
        );
    }
    let z = weighted_signs::<f64>(count, |_| 1.0);
    let moved = mass.multiply(&(&modes.vectors * &z));
    let back = modes.vectors.transpose() * &moved - &z;
    check.below(largest(&back), MAX_SPARSE_ORTHONORMALITY_ERROR)?;
    // Each mode over its limit, so that the loose limit of one hides no error of another.
    let over = Mat::from_fn(count, RANDOM_VECTORS, |i, j| z[(i, j)] / limits[i]);
    let weighted = Mat::from_fn(count, RANDOM_VECTORS, |i, j| {
        (modes.omega_squared[i] + shift) * over[(i, j)]
    });
    let mut image = mass.multiply(&(&modes.vectors * weighted));
    solve(&mut image);
    let difference = &modes.vectors * over - image;
    let moved = mass.multiply(&difference);
    for probe in 0..RANDOM_VECTORS {
        let energy = difference.col(probe).transpose() * moved.col(probe);
        check.below(energy.abs().sqrt(), MAX_SUM_OF_MODES)?;
    }
    Ok(())
}
