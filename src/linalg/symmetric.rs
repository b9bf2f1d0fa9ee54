//! Eigenvalues of symmetric matrices and of symmetric pairs (K, M), each result checked before it
//! is returned.
//!
//! Divide and conquer leaves an error of a few units of roundoff of the *largest* eigenvalue in
//! every eigenvalue. In a slender structure the lowest is 1e-11 of the largest and less, so the
//! lowest modes of a pair are computed a second time by shift and invert (`low_modes`), whose error
//! is relative to each eigenvalue.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{
    ComputeEigenvectors, SelfAdjointEvdParams, self_adjoint_evd, self_adjoint_evd_scratch,
};
use faer::linalg::solvers::Llt;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Auto, Mat, MatRef, Par, Side};

use super::compensated::{QuadraticForm, plain_forms, quadratic_forms};
use super::low_modes::LowModes;
use super::scale::{power_of_four, power_of_two};
use super::{LinalgError, RealMatrix, SparseMatrix, verify};

/// Largest bound of the relative rounding of a quadratic form that is summed in the working
/// precision. Larger: the error of a mode comes near the 1e-9 that it may have. Smaller: time
/// without use; graded matrices have no terms that cancel.
const MAX_PLAIN_ERROR: f64 = 1e-10;

/// Eigenvalues and vectors of `K phi = omega^2 M phi`.
#[derive(Clone, Debug)]
pub struct SymmetricModes {
    /// Eigenvalues omega², ascending, (rad/s)².
    pub omega_squared: Vec<f64>,
    /// Mass-normalised vectors, one per column, `phi^T M phi = I`.
    pub vectors: RealMatrix,
    /// Bound of the change of each omega² by rounding of the entries of K, `eps |phi|^T |K| |phi|`,
    /// (rad/s)²: computed for the modes whose omega² is below 1e-5 of the largest, where it may
    /// matter; for the others `eps` times the largest omega².
    pub rounding: Vec<f64>,
}

/// Eigenvalues and vectors of a symmetric matrix, `A = Q diag(lambda) Q^T`.
#[derive(Clone, Debug)]
pub struct SymmetricEigen {
    /// Eigenvalues, ascending.
    pub values: Vec<f64>,
    /// Orthonormal vectors, one per column.
    pub vectors: RealMatrix,
}

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
    #[cfg(test)]
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
    modes_by(stiffness, mass, &[divide_and_conquer, qr_iteration])
}

impl SymmetricModes {
    /// Puts the Rayleigh quotients of the modes from `first` on in the place of their eigenvalues,
    /// in ascending order: the error of a quotient is the square of that of its vector, where
    /// reduction by a mass matrix of condition 100 leaves 1e-11 in the eigenvalue of a mode at a
    /// thousandth of the largest.
    fn take_quotients(&mut self, pair: &ScaledPair, first: usize) {
        let n = self.vectors.nrows();
        let upper = self.vectors.subcols(first, n - first);
        let forces = pair.stiffness_times(upper);
        let quotient = |j: usize| upper.col(j).transpose() * forces.col(j);
        let values: Vec<f64> = (0..n - first).map(quotient).collect();
        let mut order: Vec<usize> = (0..n - first).collect();
        order.sort_by(|&i, &j| values[i].total_cmp(&values[j]));
        let sorted = Mat::from_fn(n, n - first, |i, j| upper[(i, order[j])]);
        self.vectors.subcols_mut(first, n - first).copy_from(sorted);
        for (place, &j) in order.iter().enumerate() {
            self.omega_squared[first + place] = values[j];
        }
    }
}

/// A solver of the standard problem.
pub(super) type Solver = fn(&RealMatrix) -> Result<SymmetricEigen, LinalgError>;

/// [`symmetric_modes`] by the first of these solvers of the reduced problem whose result passes the
/// check.
pub(super) fn modes_by(
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
    let reduced = Reduced::new(&pair)?;
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
    reduced: &Reduced,
    solver: Solver,
) -> Result<SymmetricModes, LinalgError> {
    let mut modes = reduced.modes(solver(&reduced.matrix)?);
    let mut low = LowModes::new(pair, &modes.omega_squared);
    low.refine(&mut modes)?;
    modes.take_quotients(pair, low.count());
    verify::scaled_modes(pair, &modes, &low)?;
    Ok(modes)
}

/// Most entries that are not zero, as a part of all, of a matrix whose products skip its zeros.
/// Larger: a product with a full matrix is faster. Smaller: time without use.
const MAX_FILL: f64 = 0.05;

/// A pair brought to entries of order one by powers of two.
pub(super) struct ScaledPair {
    pub stiffness: RealMatrix,
    pub mass: RealMatrix,
    stiffness_factor: f64,
    mass_factor: f64,
    /// Where most entries are zero.
    sparse_stiffness: Option<SparseMatrix>,
    sparse_mass: Option<SparseMatrix>,
}

impl ScaledPair {
    pub fn new(stiffness: &RealMatrix, mass: &RealMatrix) -> Self {
        let stiffness_factor = power_of_two(stiffness.as_ref());
        let mass_factor = power_of_four(mass.as_ref());
        let (stiffness, mass) = (
            scaled(stiffness, stiffness_factor),
            scaled(mass, mass_factor),
        );
        Self {
            sparse_stiffness: without_zeros(&stiffness),
            sparse_mass: without_zeros(&mass),
            stiffness,
            mass,
            stiffness_factor,
            mass_factor,
        }
    }

    /// `K X`.
    pub fn stiffness_times(&self, x: MatRef<'_, f64>) -> RealMatrix {
        match &self.sparse_stiffness {
            Some(sparse) => sparse.multiply(&x.to_owned()),
            None => &self.stiffness * x,
        }
    }

    /// `M X`.
    pub fn mass_times(&self, x: MatRef<'_, f64>) -> RealMatrix {
        match &self.sparse_mass {
            Some(sparse) => sparse.multiply(&x.to_owned()),
            None => &self.mass * x,
        }
    }

    /// `x^T K x` of every column, with a rounding that is small beside that of the entries of K, or
    /// beside 1e-10 of the form.
    pub fn stiffness_forms(&self, x: &RealMatrix) -> Vec<QuadraticForm> {
        if let Some(sparse) = &self.sparse_stiffness {
            let column = |j: usize| sparse.quadratic_form(x.col_as_slice(j));
            return (0..x.ncols()).map(column).collect();
        }
        let (mut forms, bound) = plain_forms(&self.stiffness, x);
        let cancels = |&j: &usize| bound * forms[j].magnitude > MAX_PLAIN_ERROR * forms[j].value;
        let cancelling: Vec<usize> = (0..x.ncols()).filter(cancels).collect();
        let chosen = Mat::from_fn(x.nrows(), cancelling.len(), |i, j| x[(i, cancelling[j])]);
        let exact = quadratic_forms(self.stiffness.as_ref(), chosen.as_ref());
        for (j, form) in cancelling.into_iter().zip(exact) {
            forms[j] = form;
        }
        forms
    }

    /// Modes of the scaled pair as those of the pair.
    fn unscaled(&self, modes: SymmetricModes) -> SymmetricModes {
        self.converted(
            modes,
            self.mass_factor / self.stiffness_factor,
            self.mass_factor.sqrt(),
        )
    }

    /// Modes of the pair as those of the scaled pair.
    pub fn scaled(&self, modes: SymmetricModes) -> SymmetricModes {
        let omega_squared = self.stiffness_factor / self.mass_factor;
        self.converted(modes, omega_squared, self.mass_factor.sqrt().recip())
    }

    fn converted(
        &self,
        mut modes: SymmetricModes,
        omega_squared: f64,
        vectors: f64,
    ) -> SymmetricModes {
        for values in [&mut modes.omega_squared, &mut modes.rounding] {
            values.iter_mut().for_each(|value| *value *= omega_squared);
        }
        modes.vectors = scaled(&modes.vectors, vectors);
        modes
    }
}

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
fn qr_iteration(a: &RealMatrix) -> Result<SymmetricEigen, LinalgError> {
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

fn not_converged(n: usize) -> LinalgError {
    LinalgError::NotConverged {
        what: "symmetric eigenvalue iteration",
        rows: n,
        columns: n,
    }
}

/// The pair in standard form: `M = L L^T`, `A = L^-1 K L^-T`.
struct Reduced {
    mass: MassFactor,
    matrix: RealMatrix,
}

/// L.
enum MassFactor {
    /// Roots of a diagonal mass matrix.
    Diagonal(Vec<f64>),
    Full(Llt<f64>),
}

impl Reduced {
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

/// A matrix without its zeros, where these are nearly all of it.
fn without_zeros(a: &RealMatrix) -> Option<SparseMatrix> {
    let n = a.nrows();
    // What is not a number is no zero.
    let column = |j: usize| {
        let entries = a.col_as_slice(j).iter().enumerate();
        entries.filter(|(_, value)| value.is_nan() || value.abs() > 0.0)
    };
    let count: usize = (0..n).map(|j| column(j).count()).sum();
    if count as f64 > MAX_FILL * (n * n) as f64 {
        return None;
    }
    let entries = (0..n).flat_map(|j| column(j).map(move |(i, &value)| (i, j, value)));
    SparseMatrix::from_entries(n, &entries.collect::<Vec<_>>()).ok()
}

fn scaled(a: &RealMatrix, factor: f64) -> RealMatrix {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * factor)
}

#[cfg(test)]
mod tests {
    use super::super::real_matrix;
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
        let failed = modes_by(&k, &m, &[unscaled]).unwrap_err();
        let LinalgError::Inaccurate { got, limit, .. } = failed else {
            panic!("{failed}");
        };
        assert!(got > limit);
        let modes = modes_by(&k, &m, &[unscaled, qr_iteration]).unwrap();
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
