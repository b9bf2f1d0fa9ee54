//! Static condensation yields the lowest modes of sparse models with motions without mass.

use crate::linalg::{self, SparseMatrix, SparseModes, Wanted, real_matrix};

use super::few_masses;
use super::{Condensation, MassError, TheoryError};

/// Minimum `phi^T M phi` over `phi^T (M + tau K) phi` of a mode: rounding of a massless motion,
/// `1/(1 + tau lambda)` of others, which is not below 1e-5 where coordinates do not share their
/// mass. Where fewer modes are left than there must be, an error says so. Test:
/// `all_finite_modes_of_a_small_sparse_model_are_found`.
const CARRIES_MASS: f64 = 1e-9;

impl Condensation {
    /// The lowest modes of sparse matrices, over all coordinates.
    ///
    /// With `tau > 0` the pair `(K, M + tau K)` has the vectors of `(K, M)`, and the eigenvalues
    /// `mu = lambda/(1 + tau lambda)` in the same order; of every massless motion `1/tau`. `M + tau
    /// K` is positive definite where `K_oo` is, and as sparse as `K`; `K_c`, which is full for a
    /// frame, is not made. `tau` is the least `M_ii/K_ii`, so that `1/tau` is about the highest
    /// eigenvalue. Massless motions then follow the others once more.
    ///
    /// Where few motions carry mass, `K_c` is made and all its modes are computed ([`few_masses`]).
    ///
    /// # Errors
    /// [`TheoryError::Linalg`]; [`MassError::Indistinct`].
    ///
    /// # Reference
    /// Ericsson and Ruhe (1980), The spectral transformation Lanczos method, Mathematics of
    /// Computation 35, 1251.
    pub(super) fn lowest_modes(
        &self,
        stiffness: &SparseMatrix,
        mass: &SparseMatrix,
        wanted: Wanted,
        most: usize,
    ) -> Result<SparseModes, TheoryError> {
        if self.division.massive.len() <= few_masses::MAX_MASSIVE_MOTIONS {
            return few_masses::lowest_modes(self, stiffness, mass, wanted, most);
        }
        let tau = least_ratio(mass, stiffness);
        let raised = SparseMatrix::weighted_sum(self.size, &[(1.0, mass), (tau, stiffness)])?;
        let wanted = match wanted {
            Wanted::Lowest(count) => Wanted::Lowest(count.min(self.division.massive.len())),
            Wanted::Below(limit) => Wanted::Below(limit / (1.0 + tau * limit)),
        };
        let raw = linalg::sparse_modes(stiffness, &raised, wanted, most)?;
        let vectors = &raw.vectors - self.relax(&stiffness.multiply(&raw.vectors))?;
        let moved = mass.multiply(&vectors);
        let square = |j: usize| -> f64 {
            let rows = 0..self.size;
            rows.map(|i| vectors[(i, j)] * moved[(i, j)]).sum()
        };
        let squares: Vec<f64> = (0..vectors.ncols()).map(square).collect();
        let kept: Vec<usize> = (0..squares.len())
            .filter(|&j| squares[j] > CARRIES_MASS)
            .collect();
        let needed = match wanted {
            Wanted::Lowest(count) => count,
            Wanted::Below(_) => squares.len().min(self.division.massive.len()),
        };
        if kept.len() < needed {
            let found = kept.len();
            return Err(MassError::Indistinct { found, needed }.into());
        }
        let root = |mu: f64| mu / (1.0 - tau * mu);
        let vectors = real_matrix(self.size, kept.len(), |i, j| {
            vectors[(i, kept[j])] / squares[kept[j]].sqrt()
        });
        let quotient = |j: usize| {
            let x: Vec<f64> = vectors.col(j).iter().copied().collect();
            linalg::sparse_rayleigh_quotient(stiffness, mass, &x)
        };
        let (omega_squared, rounding) = (0..kept.len()).map(quotient).unzip();
        Ok(SparseModes {
            omega_squared,
            vectors,
            rounding,
            counted_below: raw.counted_below.filter(|mu| tau * mu < 1.0).map(root),
            solves: raw.solves,
        })
    }
}

/// The least `M_ii/K_ii` of coordinates with both, s²; 1 where there is none.
fn least_ratio(mass: &SparseMatrix, stiffness: &SparseMatrix) -> f64 {
    let ratios = (0..mass.size()).map(|i| mass.get(i, i) / stiffness.get(i, i));
    let least = ratios
        .filter(|ratio| *ratio > 0.0 && ratio.is_finite())
        .fold(f64::MAX, f64::min);
    if least < f64::MAX { least } else { 1.0 }
}
