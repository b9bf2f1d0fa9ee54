//! Eigenvalues of general matrices.
//!
//! The eigenvectors that faer 0.24.4 gives for real matrices are wrong where entries are of order
//! 1e-15 and less, and where they span many decades, as in a state matrix: there the matrix is
//! solved as a complex one. Vectors of a defective matrix are not finite: it is solved again with
//! entries changed by roundoff.

use faer::Mat;
use faer::c64;
use num_complex::Complex64;

use super::scale::power_of_two;
use super::split_mix::SplitMix;
use super::{ComplexMatrix, LinalgError, RealMatrix, verify};

/// Eigenvalues and right eigenvectors of a general real matrix.
#[derive(Clone, Debug)]
pub struct GeneralModes {
    /// Eigenvalues, in no stated order; complex ones in conjugate pairs.
    pub values: Vec<Complex64>,
    /// Vectors, one per column in the order of the values, of any scale.
    pub vectors: ComplexMatrix,
}

/// Eigenvalues of a general complex matrix, in no stated order.
///
/// The vectors are computed as well: without them no eigenvalue can be checked.
///
/// # Errors
/// [`LinalgError::NotConverged`]; [`LinalgError::Inaccurate`].
pub fn complex_eigenvalues(a: &ComplexMatrix) -> Result<Vec<Complex64>, LinalgError> {
    #[cfg(feature = "faults")]
    super::faults::call("eigenvalues of a general matrix")?;
    let factor = power_of_two(a.as_ref());
    let scaled = Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * factor);
    Ok(complex_modes(&scaled)?.divided(factor).values)
}

/// All eigenvalues and right eigenvectors of `A x = lambda x` for a general real square matrix.
///
/// The vectors of a repeated eigenvalue span its eigenspace, but are no particular basis of it.
///
/// # Errors
/// [`LinalgError::NotConverged`]; [`LinalgError::Inaccurate`].
///
/// # Reference
/// Golub and Van Loan (2013), Matrix Computations, 4th ed., algorithm 7.5.2 (QR iteration with two
/// implicit shifts).
pub fn general_modes(a: &RealMatrix) -> Result<GeneralModes, LinalgError> {
    #[cfg(feature = "faults")]
    super::faults::call("eigenvalues of a general matrix")?;
    let factor = power_of_two(a.as_ref());
    let scaled = Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * factor);
    let modes = real_modes(&scaled).or_else(|_| {
        let complex = Mat::from_fn(a.nrows(), a.ncols(), |i, j| c64::new(scaled[(i, j)], 0.0));
        complex_modes(&complex)
    })?;
    Ok(modes.divided(factor))
}

impl GeneralModes {
    fn divided(mut self, factor: f64) -> Self {
        self.values.iter_mut().for_each(|value| *value /= factor);
        self
    }
}

fn real_modes(a: &RealMatrix) -> Result<GeneralModes, LinalgError> {
    let eigen = a.eigen().map_err(|_| not_converged(a.nrows()))?;
    let values: Vec<c64> = eigen.S().column_vector().iter().copied().collect();
    verify::general_eigen(a.as_ref(), &values, eigen.U())?;
    Ok(GeneralModes {
        values,
        vectors: eigen.U().to_owned(),
    })
}

fn complex_modes(a: &ComplexMatrix) -> Result<GeneralModes, LinalgError> {
    complex_modes_near(a, a).or_else(|_| {
        let mut random = SplitMix(2);
        let mut part = || f64::EPSILON * random.next();
        let near = Mat::from_fn(a.nrows(), a.ncols(), |i, j| {
            a[(i, j)] + c64::new(part(), part())
        });
        complex_modes_near(a, &near)
    })
}

/// Modes of a matrix that differs from A by roundoff, checked with A.
fn complex_modes_near(
    a: &ComplexMatrix,
    near: &ComplexMatrix,
) -> Result<GeneralModes, LinalgError> {
    let eigen = near.eigen().map_err(|_| not_converged(a.nrows()))?;
    let values: Vec<c64> = eigen.S().column_vector().iter().copied().collect();
    verify::general_eigen(a.as_ref(), &values, eigen.U())?;
    Ok(GeneralModes {
        values,
        vectors: eigen.U().to_owned(),
    })
}

fn not_converged(size: usize) -> LinalgError {
    LinalgError::NotConverged {
        what: "general eigenvalue iteration",
        rows: size,
        columns: size,
    }
}
