//! Singular values and vectors.
//!
//! Divide and conquer of faer 0.24.4 (128 columns and more) fails where many singular values are
//! equal: the residual of a discrete Fourier matrix of 200 columns is 1e-5 of its norm. Each result
//! is checked; what fails is computed again by implicit QR iteration.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::svd::{ComputeSvdVectors, SvdParams, svd, svd_scratch};
use faer::traits::ComplexField;
use faer::traits::ext::ComplexFieldExt;
use faer::{Auto, Mat, Par};

use super::scale::power_of_two;
use super::{ComplexMatrix, LinalgError, RealMatrix, verify};

/// Singular values of a complex matrix, descending.
///
/// The vectors are computed as well: without them no singular value can be checked.
///
/// # Errors
/// [`LinalgError::NotConverged`]; [`LinalgError::Inaccurate`].
pub fn singular_values(a: &ComplexMatrix) -> Result<Vec<f64>, LinalgError> {
    #[cfg(feature = "faults")]
    super::faults::call("singular values")?;
    Ok(singular_vectors(a)?.values)
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
/// [`LinalgError::NotConverged`]; [`LinalgError::Inaccurate`].
///
/// # Reference
/// Golub and Van Loan (2013), Matrix Computations, 4th ed., section 8.6.
pub fn singular_vectors(a: &ComplexMatrix) -> Result<SingularVectors, LinalgError> {
    #[cfg(feature = "faults")]
    super::faults::call("singular values")?;
    let Svd { u, values, v } = checked_svd(a)?;
    Ok(SingularVectors {
        left: u,
        values,
        right: v,
    })
}

/// Singular values of a tall real matrix, descending, and its right vectors, one per column.
///
/// # Errors
/// [`LinalgError::NotConverged`]; [`LinalgError::Inaccurate`].
pub fn right_singular_vectors(a: &RealMatrix) -> Result<(Vec<f64>, RealMatrix), LinalgError> {
    #[cfg(feature = "faults")]
    super::faults::call("singular values")?;
    let Svd { values, v, .. } = checked_svd(a)?;
    Ok((values, v))
}

/// `A = U S V^H`.
struct Svd<T: ComplexField> {
    u: Mat<T>,
    values: Vec<f64>,
    v: Mat<T>,
}

/// By divide and conquer, else by QR iteration, whichever passes the check.
fn checked_svd<T: ComplexField<Real = f64>>(a: &Mat<T>) -> Result<Svd<T>, LinalgError> {
    let factor = power_of_two(a.as_ref());
    let mut params: SvdParams = Auto::<T>::auto();
    let mut solved = scaled_svd(a, factor, params).and_then(|svd| svd.verified(a));
    if solved.is_err() && a.nrows().min(a.ncols()) >= params.recursion_threshold {
        params.recursion_threshold = usize::MAX;
        solved = scaled_svd(a, factor, params).and_then(|svd| svd.verified(a));
    }
    solved
}

impl<T: ComplexField<Real = f64>> Svd<T> {
    fn verified(self, a: &Mat<T>) -> Result<Self, LinalgError> {
        verify::singular_vectors(a.as_ref(), self.u.as_ref(), &self.values, self.v.as_ref())?;
        Ok(self)
    }
}

fn scaled_svd<T: ComplexField<Real = f64>>(
    a: &Mat<T>,
    factor: f64,
    params: SvdParams,
) -> Result<Svd<T>, LinalgError> {
    let (rows, columns) = a.shape();
    let count = rows.min(columns);
    let scaled = Mat::from_fn(rows, columns, |i, j| a[(i, j)].mul_real(factor));
    let (thin, par) = (ComputeSvdVectors::Thin, Par::Seq);
    let scratch = svd_scratch::<T>(rows, columns, thin, thin, par, params.into());
    let mut s = Diag::<T>::zeros(count);
    let (mut u, mut v) = (Mat::zeros(rows, count), Mat::zeros(columns, count));
    let mut memory = MemBuffer::new(scratch);
    let stack = MemStack::new(&mut memory);
    let out = (s.as_mut(), Some(u.as_mut()), Some(v.as_mut()));
    svd(
        scaled.as_ref(),
        out.0,
        out.1,
        out.2,
        par,
        stack,
        params.into(),
    )
    .map_err(|_| LinalgError::NotConverged {
        what: "singular value iteration",
        rows,
        columns,
    })?;
    let values = s.column_vector().iter();
    Ok(Svd {
        u,
        values: values.map(|s| s.real() / factor).collect(),
        v,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::split_mix::SplitMix;

    #[test]
    fn columns_that_depend_on_each_other_have_singular_values() {
        let mut random = SplitMix(3);
        let mut next = || random.next();
        for (rows, columns, rank) in [(30, 6, 3), (72, 3, 2), (100, 12, 6), (300, 3, 2)] {
            for draw in 0..500 {
                let rounding = [0.0, 1e-15, 1e-13, 1e-12, 1e-11][draw % 5];
                // Frequencies depend more on a parameter than the components of shapes.
                let size = |i: usize| if i.is_multiple_of(12) { 50.0 } else { 3.0 };
                let factors = RealMatrix::from_fn(rank, columns, |k, j| match j < rank {
                    true => f64::from(j == k),
                    false => next(),
                });
                let independent = RealMatrix::from_fn(rows, rank, |i, _| size(i) * next());
                let mut a = independent * factors;
                for j in rank..columns {
                    (0..rows).for_each(|i| a[(i, j)] += rounding * next());
                }
                let (values, _) = right_singular_vectors(&a).expect("passes the check");
                assert!(values[rank] < 1e-10 * values[0], "{values:?}");
            }
        }
    }
}
