//! The lowest modes of a dense pair by shift and invert.
//!
//! The eigenvalues of `(K + s M)^-1 M` are `1 / (omega^2 + s)`: the lowest modes are its largest eigenvalues, and their
//! errors are relative to themselves. Divide and conquer of the whole matrix gives the subspace of these modes (its error
//! there is `eps` over [`GRADED`]); one product with the inverse, a Rayleigh-Ritz step in the subspace and Rayleigh
//! quotients in compensated arithmetic give the modes.
//!
//! # Reference
//! Parlett (1998), The Symmetric Eigenvalue Problem, chapters 11 and 15.

use faer::linalg::solvers::{Llt, Solve};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par, Side};

use super::symmetric::{ScaledPair, SymmetricModes, divide_and_conquer};
use super::{LinalgError, RealMatrix};

/// Modes whose omega² is below this part of the largest are computed by shift and invert. Larger: time without use
/// (a beam of 500 elements has 56 such modes of 1,002). Smaller: the error of divide and conquer, up to 10 eps of the
/// largest omega², exceeds 1e-9 of the omega² of modes that are not computed again.
const GRADED: f64 = 1e-5;
/// Part of an omega² that it must be above the one before, for the two to be computed in different ways. Smaller: a repeated root,
/// known to 2e-10 there, is divided, and its values do not ascend. Larger: modes of a dense spectrum are computed again without use.
const GAP: f64 = 1e-8;
/// The shift as a part of the largest omega². Larger: modes far below it are not separated from each other. Smaller: the
/// modes just below [`GRADED`] are not, as the error of a Ritz vector is eps times their omega² over the shift.
const SHIFT: f64 = 1e-12;
/// Modes with `omega^2 + s` up to this many shifts get one more product with the inverse by themselves: the Ritz step leaves rounding
/// of the size of the vectors everywhere, and in the highest modes, which the inverse takes away, its energy is `(n eps)^2` of the
/// largest omega². Larger: such a product brings rounding of the lowest modes into higher ones, by the ratio of their
/// `omega^2 + s`. Smaller: rolling balls of the cycloid ball drive are not at 0.
pub(super) const NEAR_SHIFT: f64 = 10.0;
/// Factors of [`SHIFT`] that are tried until `K + s M` is positive definite to working precision; a matrix for which none
/// suffices is indefinite, and what is relative to its small eigenvalues has no meaning.
const SHIFT_FACTORS: [f64; 3] = [1.0, 1e2, 1e4];

/// Shift and invert for the lowest modes of a pair.
pub(super) struct LowModes<'a> {
    pair: &'a ScaledPair,
    /// Number of modes below [`GRADED`]; 0 where K is indefinite.
    pub count: usize,
    shifted: Option<Shifted>,
}

/// Cholesky factor of `K + s M`.
struct Shifted {
    shift: f64,
    factor: Llt<f64>,
}

impl<'a> LowModes<'a> {
    /// Prepared for a pair whose omega² are these, ascending.
    pub fn new(pair: &'a ScaledPair, omega_squared: &[f64]) -> Self {
        let largest = omega_squared.last().copied().unwrap_or(0.0);
        let mut count = omega_squared.partition_point(|value| *value <= GRADED * largest);
        let is_near = |j: usize| omega_squared[j] - omega_squared[j - 1] <= GAP * omega_squared[j];
        while count > 0 && count < omega_squared.len() && is_near(count) {
            count += 1;
        }
        let shifted = (count > 0 && largest > 0.0)
            .then(|| Shifted::new(pair, largest))
            .flatten();
        Self {
            pair,
            count: if shifted.is_some() { count } else { 0 },
            shifted,
        }
    }

    /// Replaces the lowest modes by those of one step of shift and invert.
    ///
    /// # Errors
    /// [`LinalgError::NotConverged`]; [`LinalgError::Inaccurate`] for vectors that do not stay independent.
    pub fn refine(&self, modes: &mut SymmetricModes) -> Result<(), LinalgError> {
        let Some(shift) = self.shift() else {
            return Ok(());
        };
        let moved = self.pair.momenta(modes.vectors.subcols(0, self.count));
        let image = self.solve(&moved);
        let projected = moved.transpose() * &image;
        let ritz = divide_and_conquer(&projected)?;
        // The largest eigenvalues of the inverse are the lowest omega^2.
        let last = self.count - 1;
        let scaled = |i: usize, j: usize| ritz.vectors[(i, last - j)] / ritz.values[last - j];
        let mut vectors = image * Mat::from_fn(self.count, self.count, scaled);
        let is_near = |&j: &usize| NEAR_SHIFT * shift * ritz.values[last - j] >= 1.0;
        let near = (0..self.count).take_while(is_near).count();
        if near > 0 {
            let smooth = self.solve(&self.pair.momenta(vectors.subcols(0, near)));
            let smooth = Mat::from_fn(smooth.nrows(), near, |i, j| {
                smooth[(i, j)] / ritz.values[last - j]
            });
            vectors.subcols_mut(0, near).copy_from(smooth);
        }
        let moved = self.pair.momenta(vectors.as_ref());
        self.take(modes, &orthonormal(vectors, moved)?);
        Ok(())
    }

    /// The shift s; none where no mode is computed by shift and invert.
    pub fn shift(&self) -> Option<f64> {
        self.shifted.as_ref().map(|shifted| shifted.shift)
    }

    /// `(K + s M)^-1 B`; B itself without a shift.
    pub fn solve(&self, right: &RealMatrix) -> RealMatrix {
        match &self.shifted {
            Some(Shifted { factor, .. }) => factor.solve(right),
            None => right.clone(),
        }
    }

    /// Puts vectors in the place of the lowest, with their Rayleigh quotients in ascending order, and takes their
    /// components out of the others.
    fn take(&self, modes: &mut SymmetricModes, [low, moved]: &[RealMatrix; 2]) {
        let n = low.nrows();
        let strain = self.pair.strains(low);
        // M is definite: its forms are no small differences of large terms.
        let kinetic = |j: usize| low.col(j).transpose() * moved.col(j);
        let kinetic: Vec<f64> = (0..self.count).map(kinetic).collect();
        let quotient = |j: usize| strain[j].value / kinetic[j];
        let mut order: Vec<usize> = (0..self.count).collect();
        order.sort_by(|&a, &b| quotient(a).total_cmp(&quotient(b)));
        let along = moved.transpose() * modes.vectors.subcols(self.count, n - self.count);
        let mut others = modes.vectors.subcols_mut(self.count, n - self.count);
        others -= low * along;
        for (j, &from) in order.iter().enumerate() {
            let norm = kinetic[from].sqrt();
            modes.omega_squared[j] = quotient(from);
            modes.rounding[j] = f64::EPSILON * strain[from].magnitude / kinetic[from];
            for i in 0..n {
                modes.vectors[(i, j)] = low[(i, from)] / norm;
            }
        }
    }
}

impl Shifted {
    fn new(pair: &ScaledPair, largest: f64) -> Option<Self> {
        let n = pair.mass.nrows();
        SHIFT_FACTORS.into_iter().find_map(|factor| {
            let shift = factor * SHIFT * largest;
            let entry = |i: usize, j: usize| pair.stiffness[(i, j)] + shift * pair.mass[(i, j)];
            let factor = Mat::from_fn(n, n, entry).llt(Side::Lower).ok()?;
            Some(Self { shift, factor })
        })
    }
}

/// Vectors X made orthonormal with respect to the mass, `moved` being `M X`, each changed by those before it alone:
/// `X^T M X = L L^T`, `X L^-T` and `M X L^-T`.
///
/// # Errors
/// [`LinalgError::NotPositiveDefinite`] for vectors that do not stay independent.
pub(super) fn orthonormal(
    vectors: RealMatrix,
    moved: RealMatrix,
) -> Result<[RealMatrix; 2], LinalgError> {
    let gram = vectors.transpose() * &moved;
    let factor = gram.llt(Side::Lower);
    let factor = factor.map_err(|_| LinalgError::NotPositiveDefinite { size: gram.nrows() })?;
    Ok([vectors, moved].map(|x| {
        let mut transposed = x.transpose().to_owned();
        solve_lower_triangular_in_place(factor.L(), transposed.as_mut(), Par::Seq);
        transposed.transpose().to_owned()
    }))
}
