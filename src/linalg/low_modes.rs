//! The lowest modes of a dense pair by shift and invert.
//!
//! The eigenvalues of `(K + s M)^-1 M` are `1 / (omega^2 + s)`: the lowest modes are its largest
//! eigenvalues, and their errors are relative to themselves. Divide and conquer of the whole matrix
//! gives the subspace of these modes (its error there is `eps` over [`MAX_LOW_OVER_LARGEST`]); one
//! product with the inverse, a Rayleigh-Ritz step in the subspace and Rayleigh quotients,
//! compensated where their terms cancel, give the modes.
//!
//! Modes far below s are not separated from each other. Where there are such, as with rigid springs
//! or tiny masses, they are computed again with a smaller shift, level by level.
//!
//! # Reference
//! Parlett (1998), The Symmetric Eigenvalue Problem, chapters 11 and 15.

use faer::linalg::solvers::{Llt, Solve};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par, Side};

use super::scaled_pair::{ScaledPair, SymmetricModes};
use super::sort_ascending_by;
use super::symmetric_solvers::divide_and_conquer;
use super::{LinalgError, RealMatrix};

/// Modes whose omega² is below this part of the largest are computed by shift and invert. Larger:
/// time without use (a beam of 500 elements has 56 such modes of 1,002). Smaller: the error of
/// divide and conquer, up to 10 eps of the largest omega², exceeds 1e-9 of the omega² of modes that
/// are not computed again.
const MAX_LOW_OVER_LARGEST: f64 = 1e-5;
/// Part of an omega² that it must be above the one before, for the two to be computed in different
/// ways. Smaller: a repeated root, known to 2e-10 there, is divided, and its values do not ascend.
/// Larger: modes of a dense spectrum are computed again without use.
const MIN_RELATIVE_GAP: f64 = 1e-8;
/// The shift as a part of the largest omega². Larger: modes far below it are not separated from
/// each other. Smaller: the modes just below [`MAX_LOW_OVER_LARGEST`] are not, as the error of a
/// Ritz vector is eps times their omega² over the shift.
const SHIFT_OVER_LARGEST: f64 = 1e-12;
/// Modes with `omega^2 + s` up to this many shifts get one more product with the inverse by
/// themselves: the Ritz step leaves rounding of the size of the vectors everywhere, and in the
/// highest modes, which the inverse takes away, its energy is `(n eps)^2` of the largest omega².
/// Larger: such a product brings rounding of the lowest modes into higher ones, by the ratio of
/// their `omega^2 + s`. Smaller: rolling balls of the cycloid ball drive are not at 0.
pub(super) const MAX_NEAR_OVER_SHIFT: f64 = 10.0;
/// Factors of [`SHIFT_OVER_LARGEST`] that are tried until `K + s M` is positive definite to working
/// precision; a matrix for which none suffices is indefinite, and what is relative to its small
/// eigenvalues has no meaning.
const SHIFT_FACTORS: [f64; 3] = [1.0, 1e2, 1e4];

/// Part of the shift below which modes are computed with a smaller one: the part of one in another
/// is `n eps` over it. Larger: time without use, and smaller shifts nearer to the rounding of K.
/// Smaller: the lowest modes of a structure on springs 1e20 times as stiff are mixed, without a
/// word (`modes_beside_rigid_springs_are_those_of_fixed_coordinates`).
pub(super) const MAX_UNSEPARATED_OVER_SHIFT: f64 = 1e-4;
/// The same below which modes that no smaller shift separates are an error: their parts in each
/// other reach 1e-6.
pub(super) const MAX_MIXED_OVER_SHIFT: f64 = 1e-8;
/// Rounding bounds of an omega² up to which it may be 0: no shift separates such modes. Smaller:
/// rigid-body modes, up to 4 bounds, are computed with shifts of which none is definite. Larger:
/// modes on a soft suspension are not separated.
pub(super) const ZERO_ROUNDINGS: f64 = 10.0;
/// Smallest shift over the rounding bounds of the modes that it is for. Smaller: rounding of K
/// shows in the vectors, and bars on suspensions fail their check
/// (`soft_suspensions_are_exact_down_to_rounding_and_not_rigid_body_modes`).
pub(super) const MIN_SHIFT_ROUNDINGS: f64 = 1e6;
/// Smallest shift over the largest omega² that it is for, as of the first shift. Smaller: one
/// solution puts rounding of the lowest mode into the highest
/// (`rigid_body_modes_beside_a_tiny_mass_pass_their_checks`).
pub(super) const MIN_SHIFT_OVER_HIGHEST: f64 = SHIFT_OVER_LARGEST / MAX_LOW_OVER_LARGEST;
/// Largest smaller shift over the one before. Larger: time without use. Smaller: modes of soft
/// suspensions are an error.
pub(super) const MAX_NEXT_SHIFT: f64 = 1e-2;

/// Shift and invert for the lowest modes of a pair.
pub(super) struct LowModes<'a> {
    pair: &'a ScaledPair,
    /// By descending shift, each for fewer of the lowest modes; none where K is indefinite.
    pub levels: Vec<Level>,
}

/// The lowest modes that are computed with one shift.
pub(super) struct Level {
    /// Their number.
    pub count: usize,
    /// The shift s.
    pub shift: f64,
    /// Cholesky factor of `K + s M`.
    factor: Llt<f64>,
}

impl<'a> LowModes<'a> {
    /// Prepared for a pair whose omega² are these, ascending.
    pub fn new(pair: &'a ScaledPair, omega_squared: &[f64]) -> Self {
        let largest = omega_squared.last().copied().unwrap_or(0.0);
        let count = count_below(omega_squared, MAX_LOW_OVER_LARGEST * largest);
        let level = (count > 0 && largest > 0.0)
            .then(|| Level::new(pair, count, SHIFT_OVER_LARGEST * largest))
            .flatten();
        Self {
            pair,
            levels: level.into_iter().collect(),
        }
    }

    /// Number of modes below [`MAX_LOW_OVER_LARGEST`]; 0 where K is indefinite.
    pub fn count(&self) -> usize {
        self.levels.first().map_or(0, |level| level.count)
    }

    /// Replaces the lowest modes by those of one step of shift and invert, and those far below the
    /// shift again by those of a smaller one.
    ///
    /// # Errors
    /// [`LinalgError::NotConverged`]; [`LinalgError::Inaccurate`] for vectors that do not stay
    /// independent, and for modes that no shift separates.
    pub fn refine(&mut self, modes: &mut SymmetricModes) -> Result<(), LinalgError> {
        if let Some(level) = self.levels.first() {
            self.refine_level(level, modes)?;
        }
        while let Some(level) = self.next_level(modes)? {
            self.refine_level(&level, modes)?;
            self.levels.push(level);
        }
        Ok(())
    }

    /// The same levels for modes that were refined.
    ///
    /// # Errors
    /// [`LinalgError::Inaccurate`] for modes that no shift separates.
    pub fn prepare(&mut self, modes: &SymmetricModes) -> Result<(), LinalgError> {
        while let Some(level) = self.next_level(modes)? {
            self.levels.push(level);
        }
        Ok(())
    }

    /// A smaller shift, where modes that are not 0 lie far below the last, and far enough above the
    /// rounding of K. None for a stiffness that is not semidefinite: no shift makes it definite.
    fn next_level(&self, modes: &SymmetricModes) -> Result<Option<Level>, LinalgError> {
        let Some(last) = self.levels.last() else {
            return Ok(None);
        };
        let omega_squared = &modes.omega_squared[..last.count];
        let count = count_below(omega_squared, MAX_UNSEPARATED_OVER_SHIFT * last.shift);
        let zero = |j: usize| ZERO_ROUNDINGS * modes.rounding[j];
        let is_indefinite = (0..count).any(|j| omega_squared[j] < -zero(j));
        let lowest = (0..count).find(|j| omega_squared[*j] > zero(*j));
        let Some(lowest) = lowest.filter(|_| !is_indefinite) else {
            return Ok(None);
        };
        let rounding = modes.rounding[..count]
            .iter()
            .fold(0.0, |a: f64, b| a.max(*b));
        let highest = omega_squared[count - 1];
        let shift = (MIN_SHIFT_OVER_HIGHEST * highest).max(MIN_SHIFT_ROUNDINGS * rounding);
        let level = (shift <= MAX_NEXT_SHIFT * last.shift)
            .then(|| Level::new(self.pair, count, shift))
            .flatten()
            .filter(|level| level.shift <= MAX_NEXT_SHIFT * last.shift);
        let over_lowest = last.shift / omega_squared[lowest];
        if level.is_some() || over_lowest < MAX_MIXED_OVER_SHIFT.recip() {
            return Ok(level);
        }
        let n = self.pair.mass.nrows();
        Err(LinalgError::Inaccurate {
            what: "natural frequencies",
            rows: n,
            columns: n,
            got: over_lowest,
            limit: MAX_MIXED_OVER_SHIFT.recip(),
        })
    }

    fn refine_level(&self, level: &Level, modes: &mut SymmetricModes) -> Result<(), LinalgError> {
        let moved = self.pair.mass_times(modes.vectors.subcols(0, level.count));
        let image = level.solve(&moved);
        let projected = moved.transpose() * &image;
        let ritz = divide_and_conquer(&projected)?;
        // The largest eigenvalues of the inverse are the lowest omega^2.
        let last = level.count - 1;
        let scaled = |i: usize, j: usize| ritz.vectors[(i, last - j)] / ritz.values[last - j];
        let mut vectors = image * Mat::from_fn(level.count, level.count, scaled);
        let is_near = |&j: &usize| MAX_NEAR_OVER_SHIFT * level.shift * ritz.values[last - j] >= 1.0;
        let near = (0..level.count).take_while(is_near).count();
        if near > 0 {
            let smooth = level.solve(&self.pair.mass_times(vectors.subcols(0, near)));
            let smooth = Mat::from_fn(smooth.nrows(), near, |i, j| {
                smooth[(i, j)] / ritz.values[last - j]
            });
            vectors.subcols_mut(0, near).copy_from(smooth);
        }
        let moved = self.pair.mass_times(vectors.as_ref());
        self.replace_lowest(modes, level.count, &orthonormal(vectors, moved)?);
        Ok(())
    }

    /// Puts vectors in the place of the lowest, with their Rayleigh quotients in ascending order,
    /// and takes their components out of the others.
    fn replace_lowest(
        &self,
        modes: &mut SymmetricModes,
        count: usize,
        [low, moved]: &[RealMatrix; 2],
    ) {
        let n = low.nrows();
        let strain = self.pair.stiffness_forms(low);
        // M is definite: its forms are no small differences of large terms.
        let kinetic = |j: usize| low.col(j).transpose() * moved.col(j);
        let kinetic: Vec<f64> = (0..count).map(kinetic).collect();
        let quotient = |j: usize| strain[j].value / kinetic[j];
        let mut order: Vec<usize> = (0..count).collect();
        sort_ascending_by(&mut order, |&column| quotient(column));
        let along = moved.transpose() * modes.vectors.subcols(count, n - count);
        let mut others = modes.vectors.subcols_mut(count, n - count);
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

impl Level {
    /// With this shift, or a larger one with which `K + s M` is positive definite.
    fn new(pair: &ScaledPair, count: usize, shift: f64) -> Option<Self> {
        let n = pair.mass.nrows();
        SHIFT_FACTORS.into_iter().find_map(|factor| {
            let shift = factor * shift;
            let entry = |i: usize, j: usize| pair.stiffness[(i, j)] + shift * pair.mass[(i, j)];
            let factor = Mat::from_fn(n, n, entry).llt(Side::Lower).ok()?;
            Some(Self {
                count,
                shift,
                factor,
            })
        })
    }

    /// `(K + s M)^-1 B`.
    pub fn solve(&self, right: &RealMatrix) -> RealMatrix {
        self.factor.solve(right)
    }
}

/// Number of the lowest omega² up to a limit, with those that are one root with the last of them.
fn count_below(omega_squared: &[f64], limit: f64) -> usize {
    let mut count = omega_squared.partition_point(|value| *value <= limit);
    let is_near =
        |j: usize| omega_squared[j] - omega_squared[j - 1] <= MIN_RELATIVE_GAP * omega_squared[j];
    while count > 0 && count < omega_squared.len() && is_near(count) {
        count += 1;
    }
    count
}

/// Vectors X made orthonormal with respect to the mass, `moved` being `M X`, each changed by those
/// before it alone: `X^T M X = L L^T`, `X L^-T` and `M X L^-T`.
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
