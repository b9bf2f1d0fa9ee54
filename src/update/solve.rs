//! Solving an update runs the trust-region method from one or several starts.
//!
//! Where a misfit remains, `shape_continuation` tries from the same start in other ways.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::shape_continuation::{with_pairs_of_the_model, with_pairs_of_the_start};
use super::trust_region::{MIN_RELATIVE_DECREASE, Solution, has_misfit, solve_from};
use super::{UpdateError, UpdateProblem};

/// Largest distance of a drawn start, in prior deviations.
const MAX_START_PRIOR_STDS: f64 = 3.0;
/// Largest difference of a parameter between equal optima, in posterior deviations.
pub(super) const MAX_OPTIMUM_DIFFERENCE: f64 = 0.1;

/// The solutions from several starts.
#[derive(Clone, Debug)]
pub struct MultiStart {
    /// The solution with the smallest objective; the first of equals.
    pub best: Solution,
    /// Objective from every start; `None` where the model has no modes at the start, or no
    /// derivatives on the way.
    pub objectives: Vec<Option<f64>>,
    /// `z` from every start.
    pub ends: Vec<Option<Vec<f64>>>,
}

/// Lowest objective from one start.
///
/// # Errors
/// Those of [`UpdateProblem::start`] at the start, [`UpdateError::Linalg`] and
/// [`UpdateError::Derivative`] on the way.
pub fn solve(problem: &UpdateProblem<'_>, z: &[f64]) -> Result<Solution, UpdateError> {
    let start = problem.start(z)?;
    let mut best = solve_from(problem, start.clone())?;
    for way in [with_pairs_of_the_start, with_pairs_of_the_model] {
        if !has_misfit(problem, &best.at) {
            break;
        }
        let found = way(problem, &start)?;
        let least = MIN_RELATIVE_DECREASE * best.at.objective().max(1.0);
        let lower = |solution: &Solution| solution.at.objective() < best.at.objective() - least;
        if let Some(lower_optimum) = found.filter(lower) {
            best = lower_optimum;
        }
    }
    Ok(best)
}

/// Solves from the initial model and from points that are drawn evenly between the bounds, at most
/// three prior deviations away; in the caller's pool, with the same result for any number of
/// threads.
///
/// # Errors
/// As [`solve`] from the first start; of the others only [`UpdateError::Linalg`] and the like are
/// errors, and a start from which the model cannot be built or differentiated counts as one that
/// ended nowhere.
pub fn solve_from_starts(problem: &UpdateProblem<'_>) -> Result<MultiStart, UpdateError> {
    let starts = starts(problem);
    let from = |z: &Vec<f64>| solve(problem, z);
    let mut ends: Vec<Result<Solution, UpdateError>> = starts.par_iter().map(from).collect();
    let first = ends.remove(0)?;
    let mut found: Vec<Option<Solution>> = vec![Some(first)];
    for end in ends {
        found.push(match end {
            Ok(solution) => Some(solution),
            Err(UpdateError::Theory(_) | UpdateError::Derivative { .. }) => None,
            Err(error) => return Err(error),
        });
    }
    let objectives: Vec<Option<f64>> = found
        .iter()
        .map(|end| end.as_ref().map(|solution| solution.at.objective()))
        .collect();
    let all_ends = found
        .iter()
        .map(|end| end.as_ref().map(|solution| solution.at.z.clone()));
    let all_ends = all_ends.collect();
    let best = found
        .into_iter()
        .flatten()
        .min_by(|a, b| a.at.objective().total_cmp(&b.at.objective()));
    Ok(MultiStart {
        best: best.expect("the first start has an end"),
        objectives,
        ends: all_ends,
    })
}

/// The starts in `z`, the first at 0.
fn starts(problem: &UpdateProblem<'_>) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(problem.options.seed);
    let mut all = vec![vec![0.0; problem.free.len()]];
    for _ in 1..problem.options.starts {
        let one = problem.free.iter().map(|parameter| {
            let (lower, upper) = parameter.bounds();
            random.random_range(lower.max(-MAX_START_PRIOR_STDS)..=upper.min(MAX_START_PRIOR_STDS))
        });
        all.push(one.collect());
    }
    all
}
