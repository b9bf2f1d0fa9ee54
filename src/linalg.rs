//! The only place that names a matrix crate. Everything runs on the calling thread, as callers
//! parallelise over problems, but products that say otherwise.

mod compensated;
mod error;
#[cfg(feature = "faults")]
#[doc(hidden)]
pub mod faults;
mod general;
mod lanczos;
mod low_modes;
#[cfg(test)]
mod low_modes_tests;
mod matrix;
mod order;
mod pencil;
mod products;
mod ritz;
mod scale;
mod scaled_pair;
mod semidefinite;
mod sparse;
mod sparse_modes;
#[cfg(test)]
mod sparse_tests;
mod split_mix;
mod svd;
mod symmetric;
mod symmetric_solvers;
mod vectorised;
pub mod verify;

use faer::linalg::solvers::{Solve, SolveLstsq};
use faer::{Mat, Side};
use num_complex::Complex64;

pub use compensated::{QuadraticForm, rayleigh_quotients};
pub use error::LinalgError;
pub use general::{GeneralModes, complex_eigenvalues, general_modes};
pub use lanczos::{Wanted, sparse_modes};
pub use matrix::{
    ComplexMatrix, ComplexView, Matrix3, RealMatrix, Vector3, complex_matrix, not_a_number,
    real_matrix,
};
pub use order::{sort_ascending_by, sort_descending_by};
pub use products::{
    Append, Fill, RowProduct, StackedPart, add_square, adjoint_product, adjoint_product_from,
    for_each_column, stacked_difference, subtract_product, subtract_row_products,
};
pub use scaled_pair::SymmetricModes;
pub use semidefinite::{
    negative_dimension, null_dimension, null_limit, null_vector, principal_block,
    solve_sparse_definite,
};
pub use sparse::{SparseMatrix, sparse_rayleigh_quotient};
pub use sparse_modes::SparseModes;
pub use svd::{SingularVectors, right_singular_vectors, singular_values, singular_vectors};
pub use symmetric::{symmetric_eigen, symmetric_modes};
pub use symmetric_solvers::SymmetricEigen;
pub use vectorised::vectorised;

/// Complex least squares `min |A x - b|` by QR; `A` is tall with full column rank, `b` has one
/// column per right-hand side.
///
/// # Errors
/// [`LinalgError::Inaccurate`], also for columns that depend on each other to working precision.
pub fn least_squares(a: &ComplexMatrix, b: &ComplexMatrix) -> Result<ComplexMatrix, LinalgError> {
    #[cfg(feature = "faults")]
    faults::call("least squares")?;
    let x = a.qr().solve_lstsq(b);
    verify::least_squares(a.as_ref(), b.as_ref(), x.as_ref())?;
    Ok(x)
}

/// Real least squares `min |A x - b|` by QR; `A` is tall with full column rank.
///
/// # Errors
/// [`LinalgError::Inaccurate`], also for columns that depend on each other to working precision.
pub fn least_squares_real(a: &RealMatrix, b: &[f64]) -> Result<Vec<f64>, LinalgError> {
    #[cfg(feature = "faults")]
    faults::call("least squares")?;
    let rhs = Mat::from_fn(b.len(), 1, |i, _| b[i]);
    let x = a.qr().solve_lstsq(&rhs);
    verify::least_squares(a.as_ref(), rhs.as_ref(), x.as_ref())?;
    Ok(x.col(0).iter().copied().collect())
}

/// `A^-1 B` of a general square matrix by LU with partial pivoting and one step of iterative
/// refinement, which makes the error of each row relative to the entries of that row.
///
/// # Errors
/// [`LinalgError::Inaccurate`], also for a matrix that is singular to working precision.
///
/// # Reference
/// Higham (2002), Accuracy and Stability of Numerical Algorithms, 2nd ed., theorem 12.3.
pub fn solve_square(a: &ComplexMatrix, b: &ComplexMatrix) -> Result<ComplexMatrix, LinalgError> {
    #[cfg(feature = "faults")]
    faults::call("solution of linear equations")?;
    let lu = a.partial_piv_lu();
    let first = lu.solve(b);
    let x = &first + lu.solve(b - a * &first);
    verify::square_solution(a, b, &x)?;
    Ok(x)
}

/// `A^-1 B` of a symmetric positive definite matrix, by Cholesky.
///
/// # Errors
/// [`LinalgError::NotPositiveDefinite`]; [`LinalgError::Inaccurate`].
pub fn solve_definite(a: &RealMatrix, b: &RealMatrix) -> Result<RealMatrix, LinalgError> {
    #[cfg(feature = "faults")]
    faults::call("solution by Cholesky")?;
    let factor = a.llt(Side::Lower);
    let factor = factor.map_err(|_| LinalgError::NotPositiveDefinite { size: a.nrows() })?;
    let x = factor.solve(b);
    verify::definite_solution(a, b, &x)?;
    Ok(x)
}

/// Lower Cholesky factor `L` of a Hermitian positive definite matrix of which the lower triangle
/// counts, `A = L Lᴴ`.
///
/// # Errors
/// [`LinalgError::NotPositiveDefinite`]; [`LinalgError::Inaccurate`].
pub fn cholesky(a: &ComplexMatrix) -> Result<ComplexMatrix, LinalgError> {
    #[cfg(feature = "faults")]
    faults::call("Cholesky factor")?;
    let n = a.nrows();
    let real_diagonal = complex_matrix(n, n, |i, j| match i == j {
        true => a[(i, i)].re.into(),
        false => a[(i, j)],
    });
    let factor = real_diagonal.llt(Side::Lower);
    let factor = factor.map_err(|_| LinalgError::NotPositiveDefinite { size: n })?;
    let lower = factor.L().to_owned();
    if verify::cholesky(a.as_ref(), lower.as_ref()).is_ok() {
        return Ok(lower);
    }
    let lower = cholesky_with_real_pivots(a)?;
    verify::cholesky(a.as_ref(), lower.as_ref())?;
    Ok(lower)
}

/// Column by column. The factor of faer 0.24.4 keeps rounding in the imaginary parts of its pivots,
/// which grows with the condition of the matrix: an error of 1e-12 of the diagonal at a condition
/// of 1e12.
fn cholesky_with_real_pivots(a: &ComplexMatrix) -> Result<ComplexMatrix, LinalgError> {
    let n = a.nrows();
    let mut lower = complex_matrix(n, n, |i, j| match i >= j {
        true => a[(i, j)],
        false => Complex64::ZERO,
    });
    for j in 0..n {
        for k in 0..j {
            let factor = lower[(j, k)].conj();
            for i in j..n {
                let term = lower[(i, k)] * factor;
                lower[(i, j)] -= term;
            }
        }
        let pivot = lower[(j, j)].re;
        if !(pivot > 0.0 && pivot.is_finite()) {
            return Err(LinalgError::NotPositiveDefinite { size: n });
        }
        let root = pivot.sqrt();
        lower[(j, j)] = root.into();
        (j + 1..n).for_each(|i| lower[(i, j)] /= root);
    }
    Ok(lower)
}

/// `L⁻¹ B` of a lower triangular matrix.
pub fn solve_lower(lower: &ComplexMatrix, right: &ComplexMatrix) -> ComplexMatrix {
    let mut solution = right.clone();
    let (left, out) = (lower.as_ref(), solution.as_mut());
    faer::linalg::triangular_solve::solve_lower_triangular_in_place(left, out, faer::Par::Seq);
    solution
}

/// `L⁻ᴴ B` of a lower triangular matrix.
pub fn solve_lower_adjoint(lower: &ComplexMatrix, right: &ComplexMatrix) -> ComplexMatrix {
    let mut solution = right.clone();
    let (left, out) = (lower.adjoint(), solution.as_mut());
    faer::linalg::triangular_solve::solve_upper_triangular_in_place(left, out, faer::Par::Seq);
    solution
}

/// A tall complex matrix as `Q R` with orthonormal columns and a triangle.
#[derive(Clone, Debug)]
pub struct ThinQr {
    /// Orthonormal columns.
    pub q: ComplexMatrix,
    /// Upper triangle.
    pub r: ComplexMatrix,
}

/// `A = Q R` of a tall matrix by Householder reflections.
///
/// # Errors
/// [`LinalgError::Inaccurate`].
pub fn thin_qr(a: &ComplexMatrix) -> Result<ThinQr, LinalgError> {
    #[cfg(feature = "faults")]
    faults::call("QR decomposition")?;
    let qr = a.qr();
    let (q, r) = (qr.compute_thin_Q(), qr.thin_R().to_owned());
    verify::thin_qr(a.as_ref(), q.as_ref(), r.as_ref())?;
    Ok(ThinQr { q, r })
}

impl ThinQr {
    /// [`thin_qr`] where an error cannot be passed on: numbers that are not numbers where it fails,
    /// never wrong ones.
    pub fn or_not_a_number(a: &ComplexMatrix) -> Self {
        thin_qr(a).unwrap_or_else(|_| Self {
            q: not_a_number(a.nrows(), a.ncols().min(a.nrows())),
            r: not_a_number(a.ncols().min(a.nrows()), a.ncols()),
        })
    }
}

/// The triangle `R` of `A = Q R` of a tall real matrix: `|R x| = |A x|` for every `x`.
///
/// # Errors
/// [`LinalgError::Inaccurate`].
pub fn upper_triangle(a: &RealMatrix) -> Result<RealMatrix, LinalgError> {
    let qr = a.qr();
    let triangle = qr.thin_R().to_owned();
    // The Gram matrix RᵀR = AᵀA says nothing of pivots below 1e-8 of the norm: Q is needed.
    verify::thin_qr(a.as_ref(), qr.compute_thin_Q().as_ref(), triangle.as_ref())?;
    Ok(triangle)
}

/// Inverse of an upper triangle; not finite where a diagonal vanishes.
pub fn inverse_upper(upper: &ComplexMatrix) -> ComplexMatrix {
    let n = upper.ncols();
    let mut inverse = complex_matrix(n, n, |i, j| {
        if i == j {
            Complex64::ONE
        } else {
            Complex64::ZERO
        }
    });
    let (left, out) = (upper.get(..n, ..n), inverse.as_mut());
    faer::linalg::triangular_solve::solve_upper_triangular_in_place(left, out, faer::Par::Seq);
    inverse
}

/// Inverse of a Hermitian positive definite matrix, scaled to a unit diagonal for the
/// factorisation; `None` when it is not definite to working precision.
pub fn inverse_hermitian(a: &ComplexMatrix) -> Option<ComplexMatrix> {
    inverse_with_ridge(a, 0.0)
}

/// As [`inverse_hermitian`], with the least ridge on the unit diagonal, up to 1e-6, that makes it
/// definite: what is not determined gets large numbers, and the rest stays what it is.
pub fn inverse_hermitian_raised(a: &ComplexMatrix) -> Option<ComplexMatrix> {
    let ridges = [0.0, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6];
    ridges
        .into_iter()
        .find_map(|ridge| inverse_with_ridge(a, ridge))
}

fn inverse_with_ridge(a: &ComplexMatrix, ridge: f64) -> Option<ComplexMatrix> {
    let n = a.nrows();
    let scale: Vec<f64> = (0..n)
        .map(|i| a[(i, i)].re.max(f64::MIN_POSITIVE).sqrt().recip())
        .collect();
    let lower = cholesky(&complex_matrix(n, n, |i, j| {
        let added = if i == j { ridge } else { 0.0 };
        a[(i, j)] * (scale[i] * scale[j]) + added
    }))
    .ok()?;
    let identity = complex_matrix(n, n, |i, j| {
        if i == j {
            Complex64::ONE
        } else {
            Complex64::ZERO
        }
    });
    let half = solve_lower(&lower, &identity);
    let inverse = half.adjoint() * &half;
    Some(complex_matrix(n, n, |i, j| {
        inverse[(i, j)] * (scale[i] * scale[j])
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_masses_on_three_springs_have_their_textbook_roots() {
        let k = real_matrix(2, 2, |i, j| if i == j { 2.0 } else { -1.0 });
        let m = real_matrix(2, 2, |i, j| if i == j { 0.5 } else { 0.0 });
        let modes = symmetric_modes(&k, &m).unwrap();
        assert!(
            (modes.omega_squared[0] - 2.0).abs() < 1e-13
                && (modes.omega_squared[1] - 6.0).abs() < 1e-13
        );
        let modal_mass: f64 = (0..2).map(|i| 0.5 * modes.vectors[(i, 0)].powi(2)).sum();
        assert!((modal_mass - 1.0).abs() < 1e-13);
    }

    #[test]
    fn a_model_without_coordinates_has_no_modes() {
        let none = real_matrix(0, 0, |_, _| 0.0);
        let modes = symmetric_modes(&none, &none).unwrap();
        assert!(modes.omega_squared.is_empty() && modes.vectors.ncols() == 0);
    }

    #[test]
    fn a_general_matrix_times_its_vectors_is_its_vectors_times_its_values() {
        // The companion matrix of (x^2 + 2 x + 10)(x + 3).
        let rows = [[-5.0, -16.0, -30.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let modes = general_modes(&real_matrix(3, 3, |i, j| rows[i][j])).unwrap();
        for (j, lambda) in modes.values.iter().enumerate() {
            for (i, row) in rows.iter().enumerate() {
                let product: Complex64 = (0..3).map(|k| row[k] * modes.vectors[(k, j)]).sum();
                assert!((product - lambda * modes.vectors[(i, j)]).norm() < 1e-12);
            }
        }
        for root in [(-1.0, 3.0), (-1.0, -3.0), (-3.0, 0.0)] {
            let root = Complex64::new(root.0, root.1);
            assert!(modes.values.iter().any(|v| (v - root).norm() < 1e-12));
        }
    }

    #[test]
    fn a_massless_coordinate_is_an_error() {
        let k = real_matrix(1, 1, |_, _| 1.0);
        let m = real_matrix(1, 1, |_, _| 0.0);
        assert!(matches!(
            symmetric_modes(&k, &m),
            Err(LinalgError::MassNotPositiveDefinite { size: 1 })
        ));
    }

    #[test]
    fn singular_vectors_give_the_matrix_back_and_cut_to_its_rank() {
        let value = |r: usize, c: usize| Complex64::new(r as f64 - 1.5, (c * c) as f64);
        let a = complex_matrix(4, 3, value);
        let svd = singular_vectors(&a).unwrap();
        let plain = singular_values(&a).unwrap();
        let difference = |b: &ComplexMatrix| {
            let places = (0..4).flat_map(|r| (0..3).map(move |c| (r, c)));
            let square = |p: (usize, usize)| (a[p] - b[p]).norm_sqr();
            places.map(square).sum::<f64>().sqrt()
        };
        // What a cut leaves out is the root of the sum of the squared values beyond it.
        assert!(difference(&svd.truncated(3)) < 1e-13);
        let beyond = plain[1].hypot(plain[2]);
        assert!((difference(&svd.truncated(1)) - beyond).abs() < 1e-13);
        assert!((svd.values[0] - plain[0]).abs() < 1e-13);
    }

    #[test]
    fn least_squares_recovers_an_exact_solution() {
        let i = Complex64::I;
        let a = complex_matrix(
            5,
            2,
            |r, c| if c == 0 { Complex64::ONE } else { i * r as f64 },
        );
        let b = complex_matrix(5, 1, |r, _| 2.0 + i + (3.0 - i) * i * r as f64);
        let x = least_squares(&a, &b).unwrap();
        assert!((x[(0, 0)] - (2.0 + i)).norm() < 1e-13 && (x[(1, 0)] - (3.0 - i)).norm() < 1e-13);
    }
}
