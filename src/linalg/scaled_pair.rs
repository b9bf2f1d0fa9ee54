//! A dense pair (K, M) is scaled to entries of order one, and its modes scaled back.

use faer::{Mat, MatRef};

use super::compensated::{QuadraticForm, plain_forms, quadratic_forms};
use super::scale::{power_of_four, power_of_two, scaled};
use super::{RealMatrix, SparseMatrix};

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
    pub sparse_mass: Option<SparseMatrix>,
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
    pub fn unscaled(&self, modes: SymmetricModes) -> SymmetricModes {
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
