//! Ritz values of an iteration: which have converged, and whether they contain the wanted modes.

use super::pencil::Pencil;
use super::{LinalgError, RealMatrix};

/// Eigenvalues nearer than this part are not parted by a limit.
const MIN_RELATIVE_GAP: f64 = 1e-5;

/// Eigenvalues below this part of the shift are 0 but for rounding: with rigid-body modes the shift
/// is the first elastic eigenvalue, without them far below it.
const MAX_RIGID_OVER_SHIFT: f64 = 1e-3;

/// The remaining search.
#[derive(Clone, Copy)]
pub(super) enum Goal {
    Lowest(usize),
    /// The count of eigenvalues below a limit is known.
    Below {
        limit: f64,
        count: usize,
    },
}

impl Goal {
    pub fn counted(pencil: &Pencil, limit: f64) -> Result<Self, LinalgError> {
        let count = pencil.count_below(limit)?;
        Ok(Goal::Below { limit, count })
    }
}

/// The part of the spectrum that the iteration has found.
pub(super) struct Ritz {
    /// Estimates of omega², ascending.
    pub lambda: Vec<f64>,
    /// Coefficients over the basis, in the same order.
    pub coefficients: RealMatrix,
    /// How many of the first are converged without a gap.
    pub converged: usize,
    /// The shift with which they were found.
    pub shift: f64,
}

impl Ritz {
    /// Where eigenvalues under the shift are rigid-body modes, the first elastic one of them as a
    /// shift.
    pub fn shift_past_rigid(&self) -> Option<f64> {
        let rigid = self.lambda.first().is_some_and(|first| *first < self.shift);
        let past = |lambda: &&f64| **lambda > 1e3 * self.shift;
        let elastic = self.lambda.iter().find(past);
        elastic.filter(|_| rigid).copied()
    }

    /// Of a whole spectrum, how many belong to the goal.
    pub fn count_for_goal(&self, goal: &Goal) -> usize {
        match *goal {
            Goal::Below { limit, .. } => self.lambda.partition_point(|value| *value < limit),
            Goal::Lowest(count) => self
                .count_to_gap(count, self.lambda.len())
                .unwrap_or(self.lambda.len()),
        }
    }

    /// The least number of modes from `count` on after which the next of the first `known` is
    /// parted by a gap. Rigid-body modes, at 0 but for rounding, are one root.
    fn count_to_gap(&self, count: usize, known: usize) -> Option<usize> {
        let parted = |&j: &usize| {
            let (last, next) = (self.lambda[j - 1], self.lambda[j]);
            next > MAX_RIGID_OVER_SHIFT * self.shift && next - last > MIN_RELATIVE_GAP * next.abs()
        };
        (count.max(1)..known).find(parted)
    }

    /// Number of modes and the limit, once as many are converged as are counted below it. Counts
    /// when that is due.
    pub fn count_when_complete(
        &self,
        pencil: &Pencil,
        goal: &mut Goal,
    ) -> Result<Option<(usize, f64)>, LinalgError> {
        if let Goal::Lowest(count) = *goal {
            let Some(parted) = self.count_to_gap(count, self.converged) else {
                return Ok(None);
            };
            let limit = 0.5 * (self.lambda[parted - 1] + self.lambda[parted]);
            *goal = Goal::counted(pencil, limit)?;
        }
        let Goal::Below { limit, count } = *goal else {
            return Ok(None);
        };
        let found = self.converged_below(limit);
        match found.cmp(&count) {
            std::cmp::Ordering::Less => Ok(None),
            std::cmp::Ordering::Equal => Ok(Some((count, limit))),
            std::cmp::Ordering::Greater => Err(LinalgError::ModesMissing {
                found,
                needed: count,
            }),
        }
    }

    fn converged_below(&self, limit: f64) -> usize {
        self.lambda[..self.converged].partition_point(|value| *value < limit)
    }
}
