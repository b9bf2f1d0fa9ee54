//! Eigenvalues of symmetric matrices and of symmetric pairs (K, M), each result checked before it
//! is returned.
//!
//! Divide and conquer leaves an error of a few units of roundoff of the *largest* eigenvalue in
//! every eigenvalue. In a slender structure the lowest is 1e-11 of the largest and less, so the
//! lowest modes of a pair are computed a second time by shift and invert (`low_modes`), whose error
//! is relative to each eigenvalue.

use faer::linalg::solvers::Llt;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Mat, Par, Side};

use super::low_modes::LowModes;
use super::scaled_pair::{ScaledPair, SymmetricModes};
use super::sort_ascending_by;
use super::symmetric_solvers::{
    Solver, SymmetricEigen, divide_and_conquer, not_converged, qr_iteration,
};
use super::{LinalgError, RealMatrix, SparseMatrix, verify};

/// All eigenvalues and vectors of a symmetric matrix, of which the lower triangle counts.
///
/// The error of an eigenvalue is relative to the largest one, as that of every method which works
/// with orthogonal transformations of the whole matrix. By divide and conquer; where its result
/// fails the check, by QR iteration.
///
/// # Errors
/// [`LinalgError::NotConverged`]; [`LinalgError::Inaccurate`].
///
/// # Reference
/// Golub and Van Loan (2013), Matrix Computations, 4th ed., section 8.4 (divide and conquer).
pub fn symmetric_eigen(a: &RealMatrix) -> Result<SymmetricEigen, LinalgError> {
    #[cfg(feature = "faults")]
    super::faults::call("symmetric eigenvalues")?;
    let checked = |eigen: SymmetricEigen| verify::symmetric_eigen(a, &eigen).map(|()| eigen);
    divide_and_conquer(a)
        .and_then(checked)
        .or_else(|_| qr_iteration(a).and_then(checked))
}

/// All modes of the symmetric pair (K, M), M positive definite: Cholesky of M, reduction to
/// standard form, and shift and invert for the lowest.
///
/// `M = L L^T`, `A = L^-1 K L^-T = Q Lambda Q^T`, `phi = L^-T Q`. Where K is positive semidefinite,
/// each omega² below 1e-5 of the largest is the Rayleigh quotient, in compensated where its terms
/// cancel, of a vector that was found with `(K + s M)^-1`. The result is checked as
/// [`verify::symmetric_modes`] says; what fails is computed again with the QR iteration in place of
/// divide and conquer.
///
/// # Errors
/// [`LinalgError::MassNotPositiveDefinite`]; [`LinalgError::NotConverged`];
/// [`LinalgError::Inaccurate`] or [`LinalgError::ModesMissing`] with the figures that failed.
///
/// # Reference
/// Golub and Van Loan (2013), Matrix Computations, 4th ed., algorithm 8.7.1; Parlett (1998), The
/// Symmetric Eigenvalue Problem, chapter 15.
pub fn symmetric_modes(
    stiffness: &RealMatrix,
    mass: &RealMatrix,
) -> Result<SymmetricModes, LinalgError> {
    modes_by_solvers(stiffness, mass, &[divide_and_conquer, qr_iteration])
}

impl SymmetricModes {
    /// Puts the Rayleigh quotients of the modes from `first` on in the place of their eigenvalues,
    /// in ascending order: the error of a quotient is the square of that of its vector, where
    /// reduction by a mass matrix of condition 100 leaves 1e-11 in the eigenvalue of a mode at a
    /// thousandth of the largest.
    fn replace_by_quotients(&mut self, pair: &ScaledPair, first: usize) {
        let n = self.vectors.nrows();
        let upper = self.vectors.subcols(first, n - first);
        let forces = pair.stiffness_times(upper);
        let quotient = |j: usize| upper.col(j).transpose() * forces.col(j);
        let values: Vec<f64> = (0..n - first).map(quotient).collect();
        let mut order: Vec<usize> = (0..n - first).collect();
        sort_ascending_by(&mut order, |&index| values[index]);
        let sorted = Mat::from_fn(n, n - first, |i, j| upper[(i, order[j])]);
        self.vectors.subcols_mut(first, n - first).copy_from(sorted);
        for (place, &j) in order.iter().enumerate() {
            self.omega_squared[first + place] = values[j];
        }
    }
}

/// [`symmetric_modes`] by the first of these solvers of the reduced problem whose result passes the
/// check.
pub(super) fn modes_by_solvers(
    stiffness: &RealMatrix,
    mass: &RealMatrix,
    solvers: &[Solver],
) -> Result<SymmetricModes, LinalgError> {
    // The solver's workspace of an empty matrix would be of size n − 1.
    if mass.nrows() == 0 {
        return Ok(SymmetricModes {
            omega_squared: Vec::new(),
            vectors: Mat::zeros(0, 0),
            rounding: Vec::new(),
        });
    }
    let pair = ScaledPair::new(stiffness, mass);
    let reduced = StandardForm::new(&pair)?;
    let mut failure = None;
    for solver in solvers {
        match checked_modes(&pair, &reduced, *solver) {
            Ok(modes) => return Ok(pair.unscaled(modes)),
            Err(error) => failure = Some(error),
        }
    }
    Err(failure.unwrap_or(not_converged(mass.nrows())))
}

fn checked_modes(
    pair: &ScaledPair,
    reduced: &StandardForm,
    solver: Solver,
) -> Result<SymmetricModes, LinalgError> {
    let mut modes = reduced.modes(solver(&reduced.matrix)?);
    let mut low = LowModes::new(pair, &modes.omega_squared);
    low.refine(&mut modes)?;
    modes.replace_by_quotients(pair, low.count());
    verify::scaled_modes(pair, &modes, &low)?;
    Ok(modes)
}

/// The pair in standard form: `M = L L^T`, `A = L^-1 K L^-T`.
struct StandardForm {
    mass: MassFactor,
    matrix: RealMatrix,
}

/// L.
enum MassFactor {
    /// Roots of a diagonal mass matrix.
    Diagonal(Vec<f64>),
    Full(Llt<f64>),
}

impl StandardForm {
    fn new(pair: &ScaledPair) -> Result<Self, LinalgError> {
        let (k, m) = (&pair.stiffness, &pair.mass);
        let n = m.nrows();
        let not_definite = LinalgError::MassNotPositiveDefinite { size: n };
        if pair.sparse_mass.as_ref().is_some_and(is_diagonal) {
            let roots: Vec<f64> = (0..n).map(|i| m[(i, i)].sqrt()).collect();
            if !roots.iter().all(|root| *root > 0.0) {
                return Err(not_definite);
            }
            let scaled = |i: usize, j: usize| 0.5 * (k[(i, j)] + k[(j, i)]) / (roots[i] * roots[j]);
            return Ok(Self {
                matrix: Mat::from_fn(n, n, scaled),
                mass: MassFactor::Diagonal(roots),
            });
        }
        let mass = m.llt(Side::Lower).map_err(|_| not_definite)?;
        let mut half = k.clone();
        solve_lower_triangular_in_place(mass.L(), half.as_mut(), Par::Seq);
        let mut matrix = half.transpose().to_owned();
        solve_lower_triangular_in_place(mass.L(), matrix.as_mut(), Par::Seq);
        let mean = |i: usize, j: usize| 0.5 * (matrix[(i, j)] + matrix[(j, i)]);
        let matrix = Mat::from_fn(n, n, mean);
        Ok(Self {
            mass: MassFactor::Full(mass),
            matrix,
        })
    }

    /// `phi = L^-T q`.
    fn modes(&self, eigen: SymmetricEigen) -> SymmetricModes {
        let mut vectors = eigen.vectors;
        match &self.mass {
            MassFactor::Diagonal(roots) => {
                for column in vectors.col_iter_mut() {
                    let entries = column.iter_mut().zip(roots);
                    entries.for_each(|(entry, root)| *entry /= root);
                }
            }
            MassFactor::Full(factor) => {
                let upper = factor.L().transpose();
                solve_upper_triangular_in_place(upper, vectors.as_mut(), Par::Seq);
            }
        }
        let largest = eigen.values.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let rounding = vec![f64::EPSILON * largest; eigen.values.len()];
        SymmetricModes {
            omega_squared: eigen.values,
            vectors,
            rounding,
        }
    }
}

fn is_diagonal(a: &SparseMatrix) -> bool {
    a.entries().all(|(i, j, _)| i == j)
}

#[cfg(test)]
mod tests {
    use super::super::real_matrix;
    use super::super::scale::scaled;
    use super::*;

    /// Divide and conquer as faer has it: wrong above 128 coordinates for entries of other orders
    /// than one.
    fn unscaled(a: &RealMatrix) -> Result<SymmetricEigen, LinalgError> {
        let large = scaled(a, 1e12);
        let eigen = large.self_adjoint_eigen(Side::Lower);
        let eigen = eigen.map_err(|_| not_converged(a.nrows()))?;
        Ok(SymmetricEigen {
            values: eigen.S().column_vector().iter().map(|s| s / 1e12).collect(),
            vectors: eigen.U().to_owned(),
        })
    }

    /// A chain of unit masses, both ends held.
    fn chain(n: usize) -> (RealMatrix, RealMatrix) {
        let k = real_matrix(n, n, |i, j| match i.abs_diff(j) {
            0 => 2.0,
            1 => -1.0,
            _ => 0.0,
        });
        (k, real_matrix(n, n, |i, j| f64::from(u8::from(i == j))))
    }

    #[test]
    fn a_wrong_solver_result_is_replaced_by_the_next_solver_or_is_an_error() {
        let (k, m) = chain(200);
        let failed = modes_by_solvers(&k, &m, &[unscaled]).unwrap_err();
        let LinalgError::Inaccurate { got, limit, .. } = failed else {
            panic!("{failed}");
        };
        assert!(got > limit);
        let modes = modes_by_solvers(&k, &m, &[unscaled, qr_iteration]).unwrap();
        for (j, value) in modes.omega_squared.iter().enumerate() {
            let angle = std::f64::consts::PI * (j as f64 + 1.0) / 402.0;
            let exact = (2.0 * angle.sin()).powi(2);
            assert!((value / exact - 1.0).abs() < 1e-10, "{j}: {value} {exact}");
        }
    }

    #[test]
    fn rounding_of_the_stiffness_is_bounded_for_the_lowest_modes() {
        // Two masses on a stiff spring, the first held by a soft one: the lower mode moves both
        // alike.
        let (soft, stiff) = (1.0, 1e9);
        let k = real_matrix(2, 2, |i, j| match (i, j) {
            (0, 0) => stiff + soft,
            (1, 1) => stiff,
            _ => -stiff,
        });
        let (_, m) = chain(2);
        let modes = symmetric_modes(&k, &m).unwrap();
        // phi = [1, 1] / sqrt(2): the four entries of 1e9 add up to 2e9.
        assert!((modes.omega_squared[0] / (0.5 * soft) - 1.0).abs() < 1e-8);
        assert!((modes.rounding[0] / (2.0 * f64::EPSILON * stiff) - 1.0).abs() < 1e-6);
    }
}
