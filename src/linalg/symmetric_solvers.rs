//! Divide and conquer and QR iteration solve the eigenvalue problem of a symmetric matrix; their
//! results are not checked here.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{
    ComputeEigenvectors, SelfAdjointEvdParams, self_adjoint_evd, self_adjoint_evd_scratch,
};
use faer::{Auto, Mat, Par, Side};

use super::scale::{power_of_two, scaled};
use super::{LinalgError, RealMatrix};

/// Eigenvalues and vectors of a symmetric matrix, `A = Q diag(lambda) Q^T`.
#[derive(Clone, Debug)]
pub struct SymmetricEigen {
    /// Eigenvalues, ascending.
    pub values: Vec<f64>,
    /// Orthonormal vectors, one per column.
    pub vectors: RealMatrix,
}

/// A solver of the standard problem.
pub(super) type Solver = fn(&RealMatrix) -> Result<SymmetricEigen, LinalgError>;

/// Divide and conquer of a matrix brought to entries of order one.
pub(super) fn divide_and_conquer(a: &RealMatrix) -> Result<SymmetricEigen, LinalgError> {
    let n = a.nrows();
    if n == 0 {
        return Ok(SymmetricEigen {
            values: Vec::new(),
            vectors: Mat::zeros(0, 0),
        });
    }
    let factor = power_of_two(a.as_ref());
    let eigen = scaled(a, factor).self_adjoint_eigen(Side::Lower);
    let eigen = eigen.map_err(|_| not_converged(n))?;
    let values = eigen.S().column_vector().iter();
    Ok(SymmetricEigen {
        values: values.map(|value| value / factor).collect(),
        vectors: eigen.U().to_owned(),
    })
}

/// Implicit QR iteration of the tridiagonal matrix, several times slower than divide and conquer.
pub(super) fn qr_iteration(a: &RealMatrix) -> Result<SymmetricEigen, LinalgError> {
    let n = a.nrows();
    if n == 0 {
        return divide_and_conquer(a);
    }
    let factor = power_of_two(a.as_ref());
    let scaled = scaled(a, factor);
    let params = SelfAdjointEvdParams {
        recursion_threshold: usize::MAX,
        ..<SelfAdjointEvdParams as Auto<f64>>::auto()
    };
    let (with_vectors, par) = (ComputeEigenvectors::Yes, Par::Seq);
    let scratch = self_adjoint_evd_scratch::<f64>(n, with_vectors, par, params.into());
    let (mut values, mut vectors) = (Diag::zeros(n), Mat::zeros(n, n));
    let mut memory = MemBuffer::new(scratch);
    let stack = MemStack::new(&mut memory);
    let (s, u) = (values.as_mut(), Some(vectors.as_mut()));
    self_adjoint_evd(scaled.as_ref(), s, u, par, stack, params.into())
        .map_err(|_| not_converged(n))?;
    let values = values.column_vector().iter().map(|value| value / factor);
    Ok(SymmetricEigen {
        values: values.collect(),
        vectors,
    })
}

pub(super) fn not_converged(n: usize) -> LinalgError {
    LinalgError::NotConverged {
        what: "symmetric eigenvalue iteration",
        rows: n,
        columns: n,
    }
}
