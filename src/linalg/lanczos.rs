//! The lowest modes of a sparse symmetric pair: block Lanczos on the shifted and inverted pair,
//! held to a count.
//!
//! `(K + s M)^-1 M phi = theta phi` with `theta = 1 / (omega^2 + s)` is self-adjoint in the inner
//! product of M; its largest eigenvalues are the lowest modes. A block finds as many modes of a
//! repeated root as it is wide, and rounding brings in the others one by one; how many there are
//! below a limit is counted by the inertia of `K - limit M`, and the iteration goes on, with new
//! vectors where its space is exhausted, until all are there.
//!
//! # Reference
//! Grimes, Lewis and Simon (1994), A shifted block Lanczos algorithm for solving sparse symmetric
//! generalized eigenproblems, SIAM Journal on Matrix Analysis and Applications 15, 228; Ericsson
//! and Ruhe (1980), The spectral transformation Lanczos method, Mathematics of Computation
//! 35, 1251.

use faer::Mat;

use super::low_modes::{
    MAX_MIXED_OVER_SHIFT, MAX_NEAR_OVER_SHIFT, MAX_NEXT_SHIFT, MAX_UNSEPARATED_OVER_SHIFT,
    MIN_SHIFT_OVER_HIGHEST, MIN_SHIFT_ROUNDINGS, ZERO_ROUNDINGS, orthonormal,
};
use super::pencil::{Cholesky, Pencil};
use super::ritz::{Goal, Ritz};
use super::sparse::{SparseMatrix, sparse_rayleigh_quotient};
use super::sparse_modes::SparseModes;
use super::split_mix::SplitMix;
use super::{LinalgError, RealMatrix, SymmetricEigen, symmetric_eigen, verify};

/// Width of the block: two and more see the double roots of symmetric structures at once; one to
/// four take about as long, eight longer.
const BLOCK_WIDTH: usize = 4;
/// A pair is converged when its residual is below this part of its theta; the error of theta is the
/// square of it.
const MAX_RESIDUAL_OVER_THETA: f64 = 1e-11;
/// A vector depends on the others when orthogonalisation reduces its norm below this fraction.
const MIN_NORM_RATIO: f64 = 1e-12;
/// The first shift as a part of the least `K_ii / M_ii`, which no lowest eigenvalue exceeds.
const FIRST_SHIFT_OVER_RATIO: f64 = 1e-9;
/// Difference of a Ritz value from the Rayleigh quotient of its vector, as a part of the shifted
/// eigenvalue and over the bound of rounding, beyond which the iteration is not to be trusted.
const MAX_RITZ_ERROR: f64 = 1e-7;
const MAX_RITZ_ROUNDINGS: f64 = 100.0;
/// Part of a limit by which roots may exceed it. Smaller: of a repeated root at the limit a part is
/// counted (`a_repeated_root_at_the_limit_is_counted_whole`). Larger: modes beyond a band are in
/// it.
const LIMIT_TOLERANCE: f64 = 1e-9;
/// Steps of a hundredfold shift before a stiffness counts as not positive semidefinite.
const SHIFT_TRIES: usize = 6;

/// Which modes of a sparse pair are wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wanted {
    /// So many of the lowest, and the others of the last one's repeated root.
    Lowest(usize),
    /// All with omega² below this, (rad/s)².
    Below(f64),
}

/// The lowest modes of a sparse symmetric pair, M positive definite and K positive semidefinite;
/// only the lower triangles are factored, both must be given.
///
/// The vectors are exact to about 1e-11 over the relative gap of their root to the next; the number
/// of modes is that of the eigenvalues below a limit by inertia ([`SparseModes::counted_below`]).
///
/// # Errors
/// [`LinalgError::MassNotPositiveDefinite`]; [`LinalgError::NotPositiveDefinite`] for a stiffness
/// that is not semidefinite; [`LinalgError::TooManyModes`] when more than `most` are wanted;
/// [`LinalgError::ModesMissing`] when the iteration does not find as many as are counted.
pub fn sparse_modes(
    stiffness: &SparseMatrix,
    mass: &SparseMatrix,
    wanted: Wanted,
    most: usize,
) -> Result<SparseModes, LinalgError> {
    let pencil = Pencil::new(stiffness, mass)?;
    let size = mass.size();
    pencil
        .cholesky(0.0, -1.0)
        .map_err(|_| LinalgError::MassNotPositiveDefinite { size })?;
    let mut goal = match wanted {
        Wanted::Lowest(count) => Goal::Lowest(count.min(size)),
        // A root at the limit is in the band, whole: rounding would count part of a repeated one.
        Wanted::Below(limit) => Goal::counted(&pencil, limit * (1.0 + LIMIT_TOLERANCE))?,
    };
    let got = match goal {
        Goal::Lowest(count) | Goal::Below { count, .. } => count,
    };
    if got > most {
        return Err(LinalgError::TooManyModes { got, most });
    }
    let (shift, factor) = first_factor(&pencil, stiffness, mass)?;
    let mut run = Run::new(&factor, mass, shift);
    let first = run.run_to_goal(&pencil, &mut goal, true)?;
    let (mut shift, mut modes) = match first.better_shift {
        None => (shift, run.checked_modes(stiffness, first.found)?),
        Some(elastic) => (
            elastic,
            modes_with_shift(elastic, &pencil, stiffness, mass, &mut goal)?,
        ),
    };
    while let Some((smaller, lowest)) = smaller_shift(&modes, shift) {
        match modes_with_shift(smaller, &pencil, stiffness, mass, &mut goal) {
            Ok(separated) => (shift, modes) = (smaller, separated),
            Err(error) if lowest < MAX_MIXED_OVER_SHIFT * shift => return Err(error),
            Err(_) => break,
        }
    }
    if let (Wanted::Below(limit), true) = (wanted, modes.counted_below.is_some()) {
        modes.counted_below = Some(limit);
    }
    Ok(modes)
}

/// The modes with one shift.
fn modes_with_shift(
    shift: f64,
    pencil: &Pencil,
    stiffness: &SparseMatrix,
    mass: &SparseMatrix,
    goal: &mut Goal,
) -> Result<SparseModes, LinalgError> {
    let factor = pencil.cholesky(1.0, -shift)?;
    let mut run = Run::new(&factor, mass, shift);
    let ended = run.run_to_goal(pencil, goal, false)?;
    run.checked_modes(stiffness, ended.found)
}

/// A smaller shift for all modes, where modes that are not 0 lie far below this one, with the
/// lowest of these.
fn smaller_shift(modes: &SparseModes, shift: f64) -> Option<(f64, f64)> {
    let pairs = || modes.omega_squared.iter().zip(&modes.rounding);
    let is_low = |pair: &(&f64, &f64)| *pair.0 < MAX_UNSEPARATED_OVER_SHIFT * shift;
    let is_elastic = |pair: &(&f64, &f64)| *pair.0 > ZERO_ROUNDINGS * *pair.1;
    let lowest = *pairs().filter(is_low).find(is_elastic)?.0;
    let rounding = pairs()
        .filter(is_low)
        .fold(0.0, |a: f64, pair| a.max(*pair.1));
    let highest = modes.omega_squared.last().copied().unwrap_or(0.0);
    let smaller = lowest
        .max(MIN_SHIFT_ROUNDINGS * rounding)
        .max(MIN_SHIFT_OVER_HIGHEST * highest);
    (smaller <= MAX_NEXT_SHIFT * shift).then_some((smaller, lowest))
}

/// The least shift with which the stiffness is positive definite to working precision, with its
/// factor.
fn first_factor<'a>(
    pencil: &'a Pencil,
    stiffness: &SparseMatrix,
    mass: &SparseMatrix,
) -> Result<(f64, Cholesky<'a>), LinalgError> {
    let ratios = (0..mass.size()).map(|i| stiffness.get(i, i) / mass.get(i, i));
    let least = ratios.filter(|ratio| *ratio > 0.0).fold(f64::MAX, f64::min);
    let mut shift = if least < f64::MAX {
        FIRST_SHIFT_OVER_RATIO * least
    } else {
        1.0
    };
    for _ in 1..SHIFT_TRIES {
        if let Ok(factor) = pencil.cholesky(1.0, -shift) {
            return Ok((shift, factor));
        }
        shift *= 100.0;
    }
    Ok((shift, pencil.cholesky(1.0, -shift)?))
}

/// How a run ended.
struct RunResult {
    found: SparseModes,
    /// A shift with which the elastic modes are exact, where rigid-body modes hide them; nothing is
    /// found then.
    better_shift: Option<f64>,
}

/// The iteration with one factor.
struct Run<'a> {
    factor: &'a Cholesky<'a>,
    mass: &'a SparseMatrix,
    shift: f64,
    /// The basis, orthonormal with respect to the mass: the first `filled` columns.
    basis: RealMatrix,
    filled: usize,
    /// `V^T M (K + s M)^-1 M V`.
    projected: RealMatrix,
    /// The next block, and what it takes of the last one: `(K + s M)^-1 M Q_last = V C + Q_next R`.
    next: RealMatrix,
    remainder: RealMatrix,
    random: SplitMix,
}

impl<'a> Run<'a> {
    fn new(factor: &'a Cholesky<'a>, mass: &'a SparseMatrix, shift: f64) -> Self {
        let n = mass.size();
        let mut run = Self {
            factor,
            mass,
            shift,
            basis: Mat::zeros(n, 64.min(n)),
            filled: 0,
            projected: Mat::zeros(0, 0),
            next: Mat::zeros(n, 0),
            remainder: Mat::zeros(0, 0),
            random: SplitMix(0),
        };
        run.add_random_vectors(BLOCK_WIDTH.min(n));
        run
    }

    fn run_to_goal(
        &mut self,
        pencil: &Pencil,
        goal: &mut Goal,
        first: bool,
    ) -> Result<RunResult, LinalgError> {
        let size = self.mass.size();
        let mut looked = 0;
        loop {
            self.step();
            let finished = self.filled == size || self.next.ncols() == 0;
            let needed = match *goal {
                Goal::Lowest(count) | Goal::Below { count, .. } => count,
            };
            let early =
                first && self.filled < size && looked == 0 && self.filled >= 5 * BLOCK_WIDTH;
            let due = self.filled >= needed && self.filled >= looked + looked / 20 + BLOCK_WIDTH;
            if !(finished || early || due) {
                continue;
            }
            looked = self.filled;
            let ritz = self.ritz()?;
            if let Some(shift) = ritz.shift_past_rigid().filter(|_| first) {
                return Ok(RunResult {
                    better_shift: Some(shift),
                    found: self.modes(&ritz, 0, None),
                });
            }
            if self.filled == size {
                return Ok(RunResult {
                    better_shift: None,
                    found: self.modes(&ritz, ritz.count_for_goal(goal), None),
                });
            }
            if let Some((count, limit)) = ritz.count_when_complete(pencil, goal)? {
                return Ok(RunResult {
                    better_shift: None,
                    found: self.modes(&ritz, count, Some(limit)),
                });
            }
            if self.filled >= self.max_vectors(needed) {
                let found = ritz.converged;
                return Err(LinalgError::ModesMissing { found, needed });
            }
            if self.next.ncols() == 0 {
                self.add_random_vectors(BLOCK_WIDTH);
            }
        }
    }

    /// Vectors that are kept at most: many times what a converging iteration needs.
    fn max_vectors(&self, needed: usize) -> usize {
        (20 * needed + 400).min(self.mass.size())
    }

    /// Takes the next block into the basis and applies the operator to it.
    fn step(&mut self) {
        let block = std::mem::replace(&mut self.next, Mat::zeros(0, 0));
        let (first, width) = (self.filled, block.ncols());
        self.reserve(first + width);
        self.basis
            .subcols_mut(first, width)
            .copy_from(block.as_ref());
        self.filled += width;
        let mut image = self.mass.multiply(&block);
        self.factor.solve(&mut image);
        let before = self.norms(&image);
        let along = self.project_out(&mut image);
        for j in 0..width {
            for i in 0..self.filled {
                self.projected[(i, first + j)] = along[(i, j)];
                self.projected[(first + j, i)] = along[(i, j)];
            }
        }
        (self.next, self.remainder) = self.orthonormal(image, &before);
    }

    /// Room for so many vectors.
    fn reserve(&mut self, vectors: usize) {
        let (n, have) = (self.mass.size(), self.basis.ncols());
        if vectors > have {
            let mut larger = Mat::zeros(n, (2 * have).max(vectors).min(n));
            larger.subcols_mut(0, have).copy_from(self.basis.as_ref());
            self.basis = larger;
        }
        let have = self.projected.nrows();
        if vectors > have {
            let room = self.basis.ncols();
            let old = std::mem::replace(&mut self.projected, Mat::zeros(room, room));
            self.projected
                .submatrix_mut(0, 0, have, have)
                .copy_from(old.as_ref());
        }
    }

    /// Norms of columns in the inner product of the mass.
    fn norms(&self, block: &RealMatrix) -> Vec<f64> {
        let moved = self.mass.multiply(block);
        let square = |j: usize| dot(block, j, &moved, j);
        (0..block.ncols())
            .map(|j| square(j).max(0.0).sqrt())
            .collect()
    }

    /// Takes the parts along the basis out of a block, twice, so that the rounding of the first
    /// time goes as well.
    fn project_out(&self, block: &mut RealMatrix) -> RealMatrix {
        let basis = self.basis.subcols(0, self.filled);
        let mut total = Mat::zeros(self.filled, block.ncols());
        for _ in 0..2 {
            let along = basis.transpose() * self.mass.multiply(block);
            *block -= basis * &along;
            total += along;
        }
        total
    }

    /// `block = Q R` with `Q^T M Q = I`; columns that depend on those before, or were such before
    /// the projection, are left out of Q.
    fn orthonormal(&self, mut block: RealMatrix, before: &[f64]) -> (RealMatrix, RealMatrix) {
        let width = block.ncols();
        let mut moved = self.mass.multiply(&block);
        let mut r = Mat::zeros(width, width);
        let mut kept: Vec<usize> = Vec::new();
        for j in 0..width {
            for _ in 0..2 {
                for (row, &i) in kept.iter().enumerate() {
                    let part = dot(&block, i, &moved, j);
                    r[(row, j)] += part;
                    subtract(&mut block, j, i, part);
                    subtract(&mut moved, j, i, part);
                }
            }
            let norm = dot(&block, j, &moved, j).max(0.0).sqrt();
            if norm > MIN_NORM_RATIO * before[j] {
                r[(kept.len(), j)] = norm;
                scale(&mut block, j, 1.0 / norm);
                scale(&mut moved, j, 1.0 / norm);
                kept.push(j);
            }
        }
        let q = Mat::from_fn(block.nrows(), kept.len(), |i, j| block[(i, kept[j])]);
        let r = Mat::from_fn(kept.len(), width, |i, j| r[(i, j)]);
        (q, r)
    }

    /// New directions beside the next block.
    fn add_random_vectors(&mut self, count: usize) {
        let n = self.mass.size();
        let count = count.min(n - self.filled - self.next.ncols());
        let kept = self.next.ncols();
        let mut fresh = Mat::from_fn(n, count, |_, _| 0.0);
        for (i, j) in (0..count).flat_map(|j| (0..n).map(move |i| (i, j))) {
            fresh[(i, j)] = self.random.next();
        }
        fresh = self.mass.multiply(&fresh);
        self.factor.solve(&mut fresh);
        self.project_out(&mut fresh);
        let all = Mat::from_fn(n, kept + count, |i, j| {
            if j < kept {
                self.next[(i, j)]
            } else {
                fresh[(i, j - kept)]
            }
        });
        let before = self.norms(&all);
        let (next, _) = self.orthonormal(all, &before);
        // The first columns stand as they were, so that the remainder only gets rows of zeros.
        self.remainder = Mat::from_fn(next.ncols(), self.remainder.ncols(), |i, j| {
            if i < self.remainder.nrows() {
                self.remainder[(i, j)]
            } else {
                0.0
            }
        });
        self.next = next;
    }

    fn ritz(&self) -> Result<Ritz, LinalgError> {
        let m = self.filled;
        let symmetric = Mat::from_fn(m, m, |i, j| {
            0.5 * (self.projected[(i, j)] + self.projected[(j, i)])
        });
        let SymmetricEigen {
            values: theta,
            vectors,
        } = symmetric_eigen(&symmetric)?;
        let coefficients = Mat::from_fn(m, m, |i, j| vectors[(i, m - 1 - j)]);
        let width = self.remainder.ncols();
        let last = coefficients.subrows(m - width, width);
        let residuals = &self.remainder * last;
        let largest = theta.last().copied().unwrap_or(0.0);
        let converged = (0..m).take_while(|&j| {
            let ritz = theta[m - 1 - j];
            let column = (0..residuals.nrows()).map(|i| residuals[(i, j)].powi(2));
            // Theta is not known better than the rounding of the largest.
            ritz > 0.0
                && column.sum::<f64>().sqrt()
                    <= (MAX_RESIDUAL_OVER_THETA * ritz).max(f64::EPSILON * largest)
        });
        Ok(Ritz {
            converged: converged.count(),
            lambda: (0..m)
                .map(|j| 1.0 / theta[m - 1 - j] - self.shift)
                .collect(),
            coefficients,
            shift: self.shift,
        })
    }

    fn modes(&self, ritz: &Ritz, count: usize, counted_below: Option<f64>) -> SparseModes {
        let basis = self.basis.subcols(0, self.filled);
        SparseModes {
            omega_squared: ritz.lambda[..count].to_vec(),
            vectors: basis * ritz.coefficients.subcols(0, count),
            rounding: Vec::new(),
            counted_below,
            solves: self.filled,
        }
    }

    /// The modes with Rayleigh quotients in compensated arithmetic and their rounding, checked.
    fn checked_modes(
        &self,
        stiffness: &SparseMatrix,
        mut found: SparseModes,
    ) -> Result<SparseModes, LinalgError> {
        // As among the lowest modes of a dense pair.
        let is_near =
            |omega_squared: &f64| omega_squared + self.shift <= MAX_NEAR_OVER_SHIFT * self.shift;
        let near = found.omega_squared.partition_point(is_near);
        let mut smooth = self
            .mass
            .multiply(&found.vectors.subcols(0, near).to_owned());
        self.factor.solve(&mut smooth);
        let moved = self.mass.multiply(&smooth);
        let [smooth, _] = orthonormal(smooth, moved)?;
        found.vectors.subcols_mut(0, near).copy_from(smooth);
        for (j, omega_squared) in found.omega_squared.iter_mut().enumerate() {
            let x: Vec<f64> = found.vectors.col(j).iter().copied().collect();
            let (quotient, rounding) = sparse_rayleigh_quotient(stiffness, self.mass, &x);
            let limit =
                MAX_RITZ_ERROR * (quotient.abs() + self.shift) + MAX_RITZ_ROUNDINGS * rounding;
            if (quotient - *omega_squared).abs() > limit {
                return Err(LinalgError::Inaccurate {
                    what: "natural frequencies",
                    rows: self.mass.size(),
                    columns: self.mass.size(),
                    got: (quotient - *omega_squared).abs(),
                    limit,
                });
            }
            *omega_squared = quotient;
            found.rounding.push(rounding);
        }
        let solve = |x: &mut RealMatrix| self.factor.solve(x);
        verify::sparse_modes(stiffness, self.mass, &found, self.shift, solve)?;
        Ok(found)
    }
}

fn dot(a: &RealMatrix, i: usize, b: &RealMatrix, j: usize) -> f64 {
    let pairs = a.col(i).iter().zip(b.col(j).iter());
    pairs.map(|(x, y)| x * y).sum()
}

fn subtract(a: &mut RealMatrix, j: usize, i: usize, factor: f64) {
    for row in 0..a.nrows() {
        let part = a[(row, i)];
        a[(row, j)] -= factor * part;
    }
}

fn scale(a: &mut RealMatrix, j: usize, factor: f64) {
    a.col_mut(j).iter_mut().for_each(|value| *value *= factor);
}
