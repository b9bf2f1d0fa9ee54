//! The only place that names a matrix crate. Everything runs on the calling thread, as callers parallelise over problems, but
//! products that say otherwise.

mod lanczos;
mod products;
mod ritz;
mod sparse;
#[cfg(test)]
mod sparse_tests;
mod vectorised;

use faer::linalg::solvers::{Solve, SolveLstsq};
use faer::{Mat, Side, c64};
use num_complex::Complex64;

pub use lanczos::{SparseModes, Wanted, sparse_modes};
pub use products::{add_square, adjoint_product, by_column, less_product};
pub use sparse::SparseMatrix;
pub use vectorised::vectorised;

/// Vector of three, for positions and directions.
pub type Vector3 = nalgebra::Vector3<f64>;
/// Matrix of three by three, for rotations.
pub type Matrix3 = nalgebra::Matrix3<f64>;
/// Dense real matrix.
pub type RealMatrix = Mat<f64>;
/// Dense complex matrix.
pub type ComplexMatrix = Mat<c64>;
/// Rows or columns of one.
pub type ComplexView<'a> = faer::MatRef<'a, c64>;

/// Why a matrix problem has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LinalgError {
    /// A mass matrix that is not positive definite.
    #[error(
        "mass matrix of {size} coordinates is not positive definite, expected every coordinate to carry mass"
    )]
    MassNotPositiveDefinite {
        /// Its size.
        size: usize,
    },
    /// A matrix that must be positive definite.
    #[error("a matrix of size {size} is not positive definite to working precision")]
    NotPositiveDefinite {
        /// Its size.
        size: usize,
    },
    /// An entry beyond the edge of a matrix.
    #[error("got an entry at row {row}, column {column} (from 0), expected both below {size}")]
    OutsideMatrix {
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        column: usize,
        /// Rows and columns of the matrix.
        size: usize,
    },
    /// More modes than can be computed.
    #[error(
        "got {got} modes that are asked for, expected at most {most}: a narrower band or a smaller count"
    )]
    TooManyModes {
        /// Asked for.
        got: usize,
        /// The most.
        most: usize,
    },
    /// Another number of modes than are counted by inertia.
    #[error(
        "got {found} converged modes, expected {needed} by the count of eigenvalues below the limit"
    )]
    ModesMissing {
        /// Converged.
        found: usize,
        /// Counted.
        needed: usize,
    },
    /// An iteration that did not converge.
    #[error("{what} of a {rows} x {columns} matrix did not converge")]
    NotConverged {
        /// Which decomposition.
        what: &'static str,
        /// Rows.
        rows: usize,
        /// Columns.
        columns: usize,
    },
}

/// Eigenvalues and vectors of `K phi = omega^2 M phi`.
#[derive(Clone, Debug)]
pub struct SymmetricModes {
    /// Eigenvalues omega², ascending, (rad/s)².
    pub omega_squared: Vec<f64>,
    /// Mass-normalised vectors, one per column, `phi^T M phi = I`.
    pub vectors: RealMatrix,
}

/// All modes of the symmetric pair (K, M), M positive definite: Cholesky of M, reduction to standard form.
///
/// `M = L L^T`, `A = L^-1 K L^-T = Q Lambda Q^T`, `phi = L^-T Q`.
///
/// # Errors
/// [`LinalgError::MassNotPositiveDefinite`]; [`LinalgError::NotConverged`].
///
/// # Reference
/// Golub and Van Loan (2013), Matrix Computations, 4th ed., algorithm 8.7.1.
pub fn symmetric_modes(
    stiffness: &RealMatrix,
    mass: &RealMatrix,
) -> Result<SymmetricModes, LinalgError> {
    let n = mass.nrows();
    // The solver's workspace of an empty matrix would be of size n − 1.
    if n == 0 {
        return Ok(SymmetricModes {
            omega_squared: Vec::new(),
            vectors: Mat::zeros(0, 0),
        });
    }
    let cholesky = mass
        .llt(Side::Lower)
        .map_err(|_| LinalgError::MassNotPositiveDefinite { size: n })?;
    let lower = cholesky.L();
    let solve = |rhs: &mut RealMatrix| {
        faer::linalg::triangular_solve::solve_lower_triangular_in_place(
            lower,
            rhs.as_mut(),
            faer::Par::Seq,
        );
    };
    let mut half = stiffness.clone();
    solve(&mut half);
    let mut reduced = half.transpose().to_owned();
    solve(&mut reduced);
    let symmetric = Mat::from_fn(n, n, |i, j| 0.5 * (reduced[(i, j)] + reduced[(j, i)]));
    let decomposition =
        symmetric
            .self_adjoint_eigen(Side::Lower)
            .map_err(|_| LinalgError::NotConverged {
                what: "symmetric eigenvalue iteration",
                rows: n,
                columns: n,
            })?;
    let mut vectors = decomposition.U().to_owned();
    faer::linalg::triangular_solve::solve_upper_triangular_in_place(
        lower.transpose(),
        vectors.as_mut(),
        faer::Par::Seq,
    );
    let omega_squared = decomposition.S().column_vector().iter().copied().collect();
    Ok(SymmetricModes {
        omega_squared,
        vectors,
    })
}

/// Complex least squares `min |A x - b|` by QR; `A` is tall with full column rank, `b` has one column per right-hand side.
pub fn least_squares(a: &ComplexMatrix, b: &ComplexMatrix) -> ComplexMatrix {
    a.qr().solve_lstsq(b)
}

/// Real least squares `min |A x - b|` by QR; `A` is tall with full column rank.
pub fn least_squares_real(a: &RealMatrix, b: &[f64]) -> Vec<f64> {
    let rhs = Mat::from_fn(b.len(), 1, |i, _| b[i]);
    a.qr().solve_lstsq(&rhs).col(0).iter().copied().collect()
}

/// `A^-1 B` of a symmetric positive definite matrix, by Cholesky.
///
/// # Errors
/// [`LinalgError::NotPositiveDefinite`].
pub fn solve_definite(a: &RealMatrix, b: &RealMatrix) -> Result<RealMatrix, LinalgError> {
    let factor = a.llt(Side::Lower);
    let factor = factor.map_err(|_| LinalgError::NotPositiveDefinite { size: a.nrows() })?;
    Ok(factor.solve(b))
}

/// Lower Cholesky factor `L` of a Hermitian positive definite matrix, `A = L Lᴴ`.
///
/// # Errors
/// [`LinalgError::NotPositiveDefinite`].
pub fn cholesky(a: &ComplexMatrix) -> Result<ComplexMatrix, LinalgError> {
    let factor = a.llt(Side::Lower);
    let factor = factor.map_err(|_| LinalgError::NotPositiveDefinite { size: a.nrows() })?;
    Ok(factor.L().to_owned())
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

/// Eigenvalues of a general complex matrix, in no stated order.
///
/// # Errors
/// [`LinalgError::NotConverged`].
pub fn complex_eigenvalues(a: &ComplexMatrix) -> Result<Vec<Complex64>, LinalgError> {
    a.eigenvalues().map_err(|_| LinalgError::NotConverged {
        what: "general eigenvalue iteration",
        rows: a.nrows(),
        columns: a.ncols(),
    })
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
pub fn thin_qr(a: &ComplexMatrix) -> ThinQr {
    let qr = a.qr();
    ThinQr {
        q: qr.compute_thin_Q(),
        r: qr.thin_R().to_owned(),
    }
}

/// The triangle `R` of `A = Q R` of a tall real matrix: `|R x| = |A x|` for every `x`.
pub fn upper_triangle(a: &RealMatrix) -> RealMatrix {
    a.qr().thin_R().to_owned()
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

/// Inverse of a Hermitian positive definite matrix, scaled to a unit diagonal for the factorisation; `None` when it is not
/// definite to working precision.
pub fn inverse_hermitian(a: &ComplexMatrix) -> Option<ComplexMatrix> {
    inverse_with_ridge(a, 0.0)
}

/// As [`inverse_hermitian`], with the least ridge on the unit diagonal, up to 1e-6, that makes it definite: what is not
/// determined gets large numbers, and the rest stays what it is.
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
        let own = if i == j { ridge } else { 0.0 };
        a[(i, j)] * (scale[i] * scale[j]) + own
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

/// Singular values of a complex matrix, descending.
///
/// # Errors
/// [`LinalgError::NotConverged`].
pub fn singular_values(a: &ComplexMatrix) -> Result<Vec<f64>, LinalgError> {
    a.singular_values().map_err(|_| LinalgError::NotConverged {
        what: "singular value iteration",
        rows: a.nrows(),
        columns: a.ncols(),
    })
}

/// A complex matrix as `U S V^H`.
#[derive(Clone, Debug)]
pub struct SingularVectors {
    /// Left vectors `U`, one per column.
    pub left: ComplexMatrix,
    /// Singular values, descending.
    pub values: Vec<f64>,
    /// Right vectors `V`, one per column.
    pub right: ComplexMatrix,
}

impl SingularVectors {
    /// The nearest matrix of a rank: `Σ_{j < rank} u_j s_j v_j^H`.
    pub fn truncated(&self, rank: usize) -> ComplexMatrix {
        let (rows, columns) = (self.left.nrows(), self.right.nrows());
        let rank = rank.min(self.values.len());
        let scaled = Mat::from_fn(rows, rank, |i, j| self.left[(i, j)] * self.values[j]);
        let right = Mat::from_fn(columns, rank, |i, j| self.right[(i, j)]);
        scaled * right.adjoint()
    }
}

/// Singular values of a complex matrix with as many vectors as it has values.
///
/// # Errors
/// [`LinalgError::NotConverged`].
pub fn singular_vectors(a: &ComplexMatrix) -> Result<SingularVectors, LinalgError> {
    let svd = a.thin_svd().map_err(|_| LinalgError::NotConverged {
        what: "singular value iteration",
        rows: a.nrows(),
        columns: a.ncols(),
    })?;
    Ok(SingularVectors {
        left: svd.U().to_owned(),
        values: svd.S().column_vector().iter().map(|s| s.re).collect(),
        right: svd.V().to_owned(),
    })
}

/// Singular values of a tall real matrix, descending, and its right vectors, one per column.
///
/// # Errors
/// [`LinalgError::NotConverged`].
pub fn right_singular_vectors(a: &RealMatrix) -> Result<(Vec<f64>, RealMatrix), LinalgError> {
    let svd = a.thin_svd().map_err(|_| LinalgError::NotConverged {
        what: "singular value iteration",
        rows: a.nrows(),
        columns: a.ncols(),
    })?;
    let values = svd.S().column_vector().iter().copied().collect();
    Ok((values, svd.V().to_owned()))
}

/// Eigenvalues and right eigenvectors of a general real matrix.
#[derive(Clone, Debug)]
pub struct GeneralModes {
    /// Eigenvalues, in no stated order; complex ones in conjugate pairs.
    pub values: Vec<Complex64>,
    /// Vectors, one per column in the order of the values, of any scale.
    pub vectors: ComplexMatrix,
}

/// All eigenvalues and right eigenvectors of `A x = lambda x` for a general real square matrix.
///
/// The vectors of a repeated eigenvalue span its eigenspace, but are no particular basis of it.
///
/// # Errors
/// [`LinalgError::NotConverged`].
///
/// # Reference
/// Golub and Van Loan (2013), Matrix Computations, 4th ed., algorithm 7.5.2 (QR iteration with two implicit shifts).
pub fn general_modes(a: &RealMatrix) -> Result<GeneralModes, LinalgError> {
    let decomposition = a.eigen().map_err(|_| LinalgError::NotConverged {
        what: "general eigenvalue iteration",
        rows: a.nrows(),
        columns: a.ncols(),
    })?;
    Ok(GeneralModes {
        values: decomposition.S().column_vector().iter().copied().collect(),
        vectors: decomposition.U().to_owned(),
    })
}

/// Complex matrix from a function of row and column.
pub fn complex_matrix(
    rows: usize,
    columns: usize,
    f: impl FnMut(usize, usize) -> Complex64,
) -> ComplexMatrix {
    Mat::from_fn(rows, columns, f)
}

/// Real matrix from a function of row and column.
pub fn real_matrix(rows: usize, columns: usize, f: impl FnMut(usize, usize) -> f64) -> RealMatrix {
    Mat::from_fn(rows, columns, f)
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
        let x = least_squares(&a, &b);
        assert!((x[(0, 0)] - (2.0 + i)).norm() < 1e-13 && (x[(1, 0)] - (3.0 - i)).norm() < 1e-13);
    }
}
