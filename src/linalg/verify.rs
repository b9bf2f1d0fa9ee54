//! Checks of decompositions, each independent of how the decomposition was computed.
//!
//! A product of factors is compared with its matrix by two vectors of random signs: `A z` and `Q (R
//! z)` cost `O(n^2)`, and an error in any column shows in them. Every limit stands above the
//! largest figure of right results for the matrices of `tests/suite/linear_algebra.rs`, and below
//! what the results broken on purpose there cause.
//!
//! # Reference
//! Freivalds (1979), Fast probabilistic algorithms, MFCS (products by random vectors); Higham
//! (2002), Accuracy and Stability of Numerical Algorithms, 2nd ed., chapters 7, 10, 19 and 20
//! (backward errors); Parlett (1998), The Symmetric Eigenvalue Problem, chapters 3 and 10 (inertia,
//! residual bounds).

mod modes;

use std::cmp::Ordering;

use faer::traits::ComplexField;
use faer::traits::ext::ComplexFieldExt;
use faer::{Mat, MatRef, c64};

use super::split_mix::SplitMix;
use super::symmetric_solvers::SymmetricEigen;
use super::{ComplexMatrix, LinalgError, RealMatrix, real_matrix};

pub use modes::symmetric_modes;
pub(super) use modes::{
    MAX_CHOLESKY_ERROR, MAX_INERTIA_ERROR, scaled_modes, sparse_factor, sparse_modes,
};

/// Vectors of random signs of one check.
const RANDOM_VECTORS: usize = 2;
/// Limit of a backward error over `(n + 10) eps`; for QR, whose rows may span decades, over `(m
/// n + 10) eps`. Larger: an entry off by a hundred of these is not found. Smaller: right results
/// fail; the largest figures are a third of it.
const MAX_BACKWARD_ERROR: f64 = 20.0;
/// The same of singular values, over `(m + n + 10) eps`. QR iteration converges slowly where
/// columns depend on each other, and reaches 33 there; of other matrices it reaches 7. Smaller:
/// sensitivities to dependent parameters are refused. Larger: errors of 1e-12 of the largest value,
/// below which nothing here distinguishes values, are not found. Test:
/// `columns_that_depend_on_each_other_have_singular_values`.
const MAX_SINGULAR_VALUE_ERROR: f64 = 100.0;

/// Checks eigenvalues and vectors of a symmetric matrix: `Q^T Q = I` and `A Q = Q Lambda`, which
/// together prove that no eigenvalue is missing.
///
/// # Errors
/// [`LinalgError::Inaccurate`].
pub fn symmetric_eigen(a: &RealMatrix, eigen: &SymmetricEigen) -> Result<(), LinalgError> {
    let check = Check::new("symmetric eigenvalues", a.as_ref());
    let (n, a) = (a.nrows(), hermitian(a.as_ref()));
    check.complete(eigen.values.len(), eigen.vectors.as_ref())?;
    let z = weighted_signs::<f64>(n, |_| 1.0);
    let product = &eigen.vectors * &z;
    let back = eigen.vectors.transpose() * &product - &z;
    check.below(largest(&back), backward_limit(n))?;
    let weighted = Mat::from_fn(n, RANDOM_VECTORS, |i, j| eigen.values[i] * z[(i, j)]);
    let residual = &a * &product - &eigen.vectors * weighted;
    let size = eigen
        .values
        .iter()
        .map(|value| value.abs())
        .fold(0.0, larger);
    check.below(length(&residual), backward_limit(n) * size)
}

/// Checks `A = Q R`, relative to each column of A, and `Q^H Q = I`.
///
/// # Errors
/// [`LinalgError::Inaccurate`].
pub fn thin_qr<T: ComplexField<Real = f64>>(
    a: MatRef<'_, T>,
    q: MatRef<'_, T>,
    r: MatRef<'_, T>,
) -> Result<(), LinalgError> {
    let check = Check::new("QR decomposition", a);
    let n = a.ncols();
    let z = weighted_signs::<T>(n, |j| a.col(j).norm_l2());
    let residual = a * &z - q * (r * &z);
    check.below(length(&residual), backward_limit(a.nrows() * n))?;
    orthonormal(&check, q)
}

/// Checks least squares: the residual is orthogonal to the columns of A, relative to the terms of
/// `A X` and B.
///
/// # Errors
/// [`LinalgError::Inaccurate`].
pub fn least_squares<T: ComplexField<Real = f64>>(
    a: MatRef<'_, T>,
    b: MatRef<'_, T>,
    x: MatRef<'_, T>,
) -> Result<(), LinalgError> {
    let check = Check::new("least squares", a);
    let weights: Vec<f64> = b.col_iter().map(|column| column.norm_l2()).collect();
    let z = weighted_signs::<T>(b.ncols(), |k| weights[k]);
    let along = a.adjoint() * (b * &z - a * (x * &z));
    let norms: Vec<f64> = a.col_iter().map(|column| column.norm_l2()).collect();
    // Terms of all right-hand sides without signs, as these may cancel: each side has the length 1.
    let used = (0..b.ncols()).filter(|&k| weights[k] > 0.0);
    let terms = |k: usize| {
        let terms = norms
            .iter()
            .enumerate()
            .map(|(j, norm)| norm * abs(&x[(j, k)]));
        1.0 + terms.sum::<f64>() / weights[k]
    };
    let size: f64 = used.map(terms).sum();
    for (j, norm) in norms.iter().enumerate() {
        let limit = backward_limit(a.nrows() * a.ncols()) * norm * size;
        check.below(norm_of_row(&along, j), limit)?;
    }
    Ok(())
}

/// Checks `A = L L^H` of a matrix of which the lower triangle counts, relative to its diagonal.
///
/// # Errors
/// [`LinalgError::Inaccurate`].
pub fn cholesky<T: ComplexField<Real = f64>>(
    a: MatRef<'_, T>,
    lower: MatRef<'_, T>,
) -> Result<(), LinalgError> {
    let check = Check::new("Cholesky factor", a);
    let (n, a) = (a.nrows(), hermitian(a));
    let root = |i: usize| abs(&a[(i, i)]).sqrt();
    let z = weighted_signs::<T>(n, root);
    let residual = &a * &z - lower * (lower.adjoint() * &z);
    let rows = (0..n).filter(|&i| root(i) > 0.0);
    let rows = rows.map(|i| norm_of_row(&residual, i) / root(i));
    check.below(rows.fold(0.0, larger), backward_limit(n))
}

/// Checks `A X = B` of a general square matrix, row by row relative to `|A| |X| + |B|`.
///
/// # Errors
/// [`LinalgError::Inaccurate`].
pub fn square_solution(
    a: &ComplexMatrix,
    b: &ComplexMatrix,
    x: &ComplexMatrix,
) -> Result<(), LinalgError> {
    let check = Check::new("solution of linear equations", a.as_ref());
    let residual = b - a * x;
    let magnitudes = |m: &ComplexMatrix| real_matrix(m.nrows(), m.ncols(), |i, j| m[(i, j)].norm());
    let terms = magnitudes(a) * magnitudes(x);
    for k in 0..b.ncols() {
        for i in 0..a.nrows() {
            let limit = backward_limit(a.nrows()) * (terms[(i, k)] + b[(i, k)].norm());
            check.below(residual[(i, k)].norm(), limit)?;
        }
    }
    Ok(())
}

/// Checks `A X = B` of a positive definite A of which the lower triangle counts, relative to its
/// diagonal.
///
/// # Errors
/// [`LinalgError::Inaccurate`].
pub fn definite_solution(
    a: &RealMatrix,
    b: &RealMatrix,
    x: &RealMatrix,
) -> Result<(), LinalgError> {
    let check = Check::new("solution by Cholesky", a.as_ref());
    let a = hermitian(a.as_ref());
    let root = |i: usize| a[(i, i)].abs().sqrt();
    let residual = b - &a * x;
    for k in 0..b.ncols() {
        let terms: f64 = (0..a.nrows()).map(|j| root(j) * x[(j, k)].abs()).sum();
        for i in 0..a.nrows() {
            let limit = backward_limit(a.nrows()) * (root(i) * terms + b[(i, k)].abs());
            check.below(residual[(i, k)].abs(), limit)?;
        }
    }
    Ok(())
}

/// Checks `A V = U S`, `A^H U = V S` and that U and V are orthonormal.
///
/// # Errors
/// [`LinalgError::Inaccurate`].
pub fn singular_vectors<T: ComplexField<Real = f64>>(
    a: MatRef<'_, T>,
    u: MatRef<'_, T>,
    values: &[f64],
    v: MatRef<'_, T>,
) -> Result<(), LinalgError> {
    let check = Check::new("singular values", a);
    let k = values.len();
    let z = weighted_signs::<T>(k, |_| 1.0);
    let weighted = Mat::from_fn(k, RANDOM_VECTORS, |i, j| z[(i, j)].mul_real(&values[i]));
    let limit =
        MAX_SINGULAR_VALUE_ERROR / MAX_BACKWARD_ERROR * backward_limit(a.nrows() + a.ncols());
    let limit = limit * values.first().copied().unwrap_or(0.0);
    check.below(length(&(a * (v * &z) - u * &weighted)), limit)?;
    check.below(length(&(a.adjoint() * (u * &z) - v * &weighted)), limit)?;
    orthonormal(&check, u)?;
    orthonormal(&check, v)
}

/// Checks eigenvalues and right eigenvectors of a general matrix: `A X = X Lambda`, relative to the
/// norm of A, and that the values add up to the trace.
///
/// # Errors
/// [`LinalgError::Inaccurate`].
pub fn general_eigen<T: ComplexField<Real = f64>>(
    a: MatRef<'_, T>,
    values: &[c64],
    vectors: MatRef<'_, c64>,
) -> Result<(), LinalgError> {
    let check = Check::new("eigenvalues of a general matrix", a);
    let n = a.nrows();
    let complex = Mat::from_fn(n, n, |i, j| c64::new(a[(i, j)].real(), a[(i, j)].imag()));
    let z = weighted_signs::<c64>(n, |j| vectors.col(j).norm_l2());
    let weighted = Mat::from_fn(n, RANDOM_VECTORS, |i, j| values[i] * z[(i, j)]);
    let limit = backward_limit(n) * a.norm_l2();
    let residual = &complex * (vectors * &z) - vectors * weighted;
    check.below(length(&residual), limit)?;
    let trace: c64 = (0..n).map(|i| complex[(i, i)]).sum();
    let sum: c64 = values.iter().sum();
    check.below((sum - trace).norm(), limit)
}

fn orthonormal<T: ComplexField<Real = f64>>(
    check: &Check,
    q: MatRef<'_, T>,
) -> Result<(), LinalgError> {
    let z = weighted_signs::<T>(q.ncols(), |_| 1.0);
    let difference = q.adjoint() * (q * &z) - &z;
    check.below(largest(&difference), backward_limit(q.nrows() * q.ncols()))
}

/// The checked operation, for the error.
struct Check {
    what: &'static str,
    rows: usize,
    columns: usize,
}

impl Check {
    fn new<T>(what: &'static str, a: MatRef<'_, T>) -> Self {
        Self {
            what,
            rows: a.nrows(),
            columns: a.ncols(),
        }
    }

    /// An error unless `got <= limit`; a figure that is not a number fails.
    fn below(&self, got: f64, limit: f64) -> Result<(), LinalgError> {
        if got <= limit {
            return Ok(());
        }
        Err(LinalgError::Inaccurate {
            what: self.what,
            rows: self.rows,
            columns: self.columns,
            got,
            limit,
        })
    }

    /// As many values and vectors as the matrix has rows.
    fn complete(&self, values: usize, vectors: MatRef<'_, f64>) -> Result<(), LinalgError> {
        let needed = self.rows;
        let found = values.min(vectors.ncols());
        if found == needed && vectors.nrows() == needed {
            return Ok(());
        }
        Err(LinalgError::ModesMissing { found, needed })
    }
}

/// The whole of a matrix of which the lower triangle counts.
fn hermitian<T: ComplexField<Real = f64>>(a: MatRef<'_, T>) -> Mat<T> {
    Mat::from_fn(a.nrows(), a.nrows(), |i, j| {
        match i.cmp(&j) {
            Ordering::Greater => a[(i, j)].clone(),
            Ordering::Less => a[(j, i)].conj(),
            // The imaginary part of the diagonal does not count either.
            Ordering::Equal => T::from_f64_impl(a[(i, i)].real()),
        }
    })
}

/// Largest backward error of a decomposition of `n` columns.
fn backward_limit(n: usize) -> f64 {
    MAX_BACKWARD_ERROR * f64::EPSILON * (n as f64 + 10.0)
}

/// Largest entry; not a number where an entry is none.
fn largest<T: ComplexField<Real = f64>>(a: &Mat<T>) -> f64 {
    if a.is_all_finite() {
        a.norm_max()
    } else {
        f64::NAN
    }
}

/// Root of the sum of squares; not a number where an entry is none.
fn length<T: ComplexField<Real = f64>>(a: &Mat<T>) -> f64 {
    if a.is_all_finite() {
        a.norm_l2()
    } else {
        f64::NAN
    }
}

fn norm_of_row<T: ComplexField<Real = f64>>(a: &Mat<T>, row: usize) -> f64 {
    (0..a.ncols()).map(|j| abs(&a[(row, j)])).fold(0.0, larger)
}

/// The larger of two numbers; not a number where one is none.
fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

fn abs<T: ComplexField<Real = f64>>(value: &T) -> f64 {
    value.real().hypot(value.imag())
}

/// Vectors of 1 and -1 without a pattern, each entry over a weight; 0 where the weight is 0.
fn weighted_signs<T: ComplexField<Real = f64>>(n: usize, weight: impl Fn(usize) -> f64) -> Mat<T> {
    let mut random = SplitMix(1);
    let scale: Vec<f64> = (0..n)
        .map(weight)
        .map(|weight| if weight > 0.0 { weight.recip() } else { 0.0 })
        .collect();
    let mut z = Mat::zeros(n, RANDOM_VECTORS);
    for (i, scale) in scale.iter().enumerate() {
        for j in 0..RANDOM_VECTORS {
            z[(i, j)] = T::from_f64_impl(if random.next() < 0.0 { -scale } else { *scale });
        }
    }
    z
}
