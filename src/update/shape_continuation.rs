//! Graduated weights of shapes restart an update that ends with a misfit: frequencies first, then
//! the pairs of the initial model.
//!
//! Shapes make the objective rough: far from the optimum a mode may look like another, and the
//! iteration ends at a local optimum or at bounds. Frequencies are smooth. Here shapes begin with
//! little weight, which grows to what they have; with the pairs of the start, and with those of the
//! initial model, followed by shape along the line from there to the start.
//!
//! # Reference
//! Blake and Zisserman (1987), Visual Reconstruction, chapter 7 (graduated non-convexity).

use super::trust_region::{Solution, solve_from};
use super::{Evaluation, UpdateError, UpdateProblem};

/// Weights of shapes, one after the other, before the stated weight.
const WEIGHTS: [f64; 3] = [0.01, 0.1, 0.4];
/// Number of steps on the line from the initial model to a start.
const STEPS: usize = 20;

/// The solution from the root pairs of the start.
pub(super) fn with_pairs_of_the_start(
    problem: &UpdateProblem<'_>,
    start: &Evaluation,
) -> Result<Option<Solution>, UpdateError> {
    graduated(problem, start)
}

/// The solution with the root pairs of the initial model, followed by shape; `None` where its modes
/// cannot be followed, or these are the root pairs of the start. The numbers of the modes do not
/// identify them: modes that the test does not see cross those that it does.
pub(super) fn with_pairs_of_the_model(
    problem: &UpdateProblem<'_>,
    start: &Evaluation,
) -> Result<Option<Solution>, UpdateError> {
    let mut at = problem.start(&vec![0.0; start.z.len()])?;
    for step in 1..=STEPS {
        let part = step as f64 / STEPS as f64;
        let z: Vec<f64> = start.z.iter().map(|z| part * z).collect();
        match problem.follow(&z, &at)? {
            Some(next) => at = next,
            None => return Ok(None),
        }
    }
    if at.root_pairs == start.root_pairs {
        return Ok(None);
    }
    graduated(problem, &at)
}

fn graduated(
    problem: &UpdateProblem<'_>,
    start: &Evaluation,
) -> Result<Option<Solution>, UpdateError> {
    if problem.targets.iter().all(|target| target.shapes.is_none()) {
        return Ok(None);
    }
    let (mut z, mut root_pairs) = (start.z.clone(), start.root_pairs.clone());
    for weight in WEIGHTS {
        let reweighted = problem.with_shape_weight(weight);
        let end = solve_from(&reweighted, reweighted.at_root_pairs(&z, root_pairs)?)?;
        (z, root_pairs) = (end.at.z, end.at.root_pairs);
    }
    solve_from(problem, problem.at_root_pairs(&z, root_pairs)?).map(Some)
}
