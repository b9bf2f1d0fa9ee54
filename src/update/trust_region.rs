//! A bounded Gauss-Newton method with a trust region solves the update from one start.
//!
//! Each step solves `min |J s + r|` with `s` in the box where the linear model is trusted and the
//! parameters stay between their bounds; the box grows where the model predicts the decrease and
//! shrinks where it does not. The prior's rows give `J` full column rank. When no step is left and
//! a misfit remains, test and model are paired again at the result; where the iteration from there
//! ends lower, that is taken.
//!
//! # Reference
//! Conn, Gould and Toint (2000), Trust-Region Methods, chapters 6 and 12 (box-shaped regions and
//! bounds).

use crate::linalg::{RealMatrix, real_matrix, upper_triangle};

use super::bounded::bounded_least_squares;
use super::evaluate::max_chi_square;
use super::history::{Iteration, PairingChange, StopReason};
use super::{Evaluation, Residuals, RootPair, UpdateError, UpdateProblem};

/// Smallest decrease of the objective that counts, as a part of it (of 1 where it is less): a
/// smaller one moves no parameter by more than a ten-thousandth of its posterior deviation.
pub(super) const MIN_RELATIVE_DECREASE: f64 = 1e-8;
/// Smallest radius: below it a step is as small as the rounding of `z`.
const MIN_TRUST_RADIUS: f64 = 1e-9;
/// Smallest ratio of decrease to predicted decrease at which the box does not shrink.
const MIN_DECREASE_TO_KEEP_RADIUS: f64 = 0.25;
/// Smallest such ratio at which the box grows.
const MIN_DECREASE_TO_GROW_RADIUS: f64 = 0.75;
/// Largest radius of the box, in first steps.
const MAX_RADIUS_FIRST_STEPS: f64 = 10.0;
/// Largest number of pairings from one start.
const MAX_PAIRINGS: usize = 10;

/// End of the iteration from one start.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The model there.
    pub at: Evaluation,
    /// Derivatives of the residuals there.
    pub jacobian: RealMatrix,
    /// Every step.
    pub history: Vec<Iteration>,
    /// Measured roots whose partner changed during the iteration.
    pub pairing_changes: Vec<PairingChange>,
    /// Why the iteration ended.
    pub stop_reason: StopReason,
}

/// Whether the residuals of modes are larger than noise explains.
pub(super) fn has_misfit(problem: &UpdateProblem<'_>, at: &Evaluation) -> bool {
    let of_modes = problem.options.residuals != Residuals::ModalDynamic && !problem.compares_frfs;
    let free = problem.free.len();
    let nu = problem.data_count(at).saturating_sub(free).max(1) as f64;
    of_modes && at.chi_square() > max_chi_square(nu)
}

/// The lowest objective from a point with its root pairs, and with those of a new pairing at the
/// end of that.
pub(super) fn solve_from(
    problem: &UpdateProblem<'_>,
    at: Evaluation,
) -> Result<Solution, UpdateError> {
    let mut run = Run::new(problem, at)?;
    let mut stop_reason = run.descend()?;
    for _ in 1..MAX_PAIRINGS {
        if !has_misfit(problem, &run.at) {
            break;
        }
        let Some((other, reason)) = run.paired_anew()? else {
            break;
        };
        (run, stop_reason) = (other, reason);
    }
    Ok(Solution {
        at: run.at,
        jacobian: run.jacobian,
        history: run.history,
        pairing_changes: run.pairing_changes,
        stop_reason,
    })
}

struct Run<'a, 'b> {
    problem: &'a UpdateProblem<'b>,
    at: Evaluation,
    jacobian: RealMatrix,
    /// The triangle of `[J r]`, which has the norms of the linear model, and few rows.
    triangle: RealMatrix,
    history: Vec<Iteration>,
    pairing_changes: Vec<PairingChange>,
}

/// Derivatives of the residuals, and the triangle of `[J r]`.
fn linearised(
    problem: &UpdateProblem<'_>,
    at: &Evaluation,
) -> Result<(RealMatrix, RealMatrix), UpdateError> {
    let jacobian = problem.jacobian(at)?;
    let (rows, n) = (jacobian.nrows(), jacobian.ncols());
    let all = real_matrix(rows.max(n + 1), n + 1, |i, j| match i {
        i if i >= rows => 0.0,
        i if j < n => jacobian[(i, j)],
        i => at.residual[i],
    });
    Ok((jacobian, upper_triangle(&all)?))
}

impl<'a, 'b> Run<'a, 'b> {
    fn new(problem: &'a UpdateProblem<'b>, at: Evaluation) -> Result<Self, UpdateError> {
        let (jacobian, triangle) = linearised(problem, &at)?;
        Ok(Self {
            problem,
            at,
            jacobian,
            triangle,
            history: Vec::new(),
            pairing_changes: Vec::new(),
        })
    }

    fn move_to(&mut self, at: Evaluation) -> Result<(), UpdateError> {
        (self.jacobian, self.triangle) = linearised(self.problem, &at)?;
        self.at = at;
        Ok(())
    }

    /// Iterates until a reason to stop.
    fn descend(&mut self) -> Result<StopReason, UpdateError> {
        let mut radius = 1.0;
        while self.history.len() < self.problem.options.max_iterations {
            let (step, after) = self.step(radius)?;
            let predicted = self.at.objective() - after;
            if predicted <= MIN_RELATIVE_DECREASE * self.at.objective().max(1.0) {
                return Ok(StopReason::NoDecrease);
            }
            let z: Vec<f64> = self.at.z.iter().zip(&step).map(|(z, s)| z + s).collect();
            let next = self.problem.follow(&z, &self.at)?;
            let share = next.as_ref().map_or(f64::NEG_INFINITY, |next| {
                (self.at.objective() - next.objective()) / predicted
            });
            if share < MIN_DECREASE_TO_KEEP_RADIUS {
                radius *= 0.25;
            } else if share > MIN_DECREASE_TO_GROW_RADIUS {
                radius = (2.0 * radius).min(MAX_RADIUS_FIRST_STEPS);
            }
            let accepted = next.filter(|_| share > 0.0);
            let taken = accepted.is_some();
            if let Some(next) = accepted {
                let root_pairs = std::mem::take(&mut self.at.root_pairs);
                self.move_to(next)?;
                self.note_changes(&root_pairs, true);
            }
            self.record(radius, taken);
            if radius < MIN_TRUST_RADIUS {
                return Ok(StopReason::SmallStep);
            }
        }
        Ok(StopReason::IterationLimit)
    }

    /// The step of the linear model inside the box and the bounds, and the objective that the model
    /// predicts after it.
    fn step(&self, radius: f64) -> Result<(Vec<f64>, f64), UpdateError> {
        let bounds: Vec<(f64, f64)> = self
            .problem
            .free
            .iter()
            .zip(&self.at.z)
            .map(|(parameter, z)| {
                let (lower, upper) = parameter.bounds();
                let most = radius * parameter.first_step();
                // Rounding may put z a little outside.
                ((lower - z).clamp(-most, 0.0), (upper - z).clamp(0.0, most))
            })
            .collect();
        let small = &self.triangle;
        let n = small.ncols() - 1;
        let against: Vec<f64> = (0..small.nrows()).map(|i| -small[(i, n)]).collect();
        let columns = real_matrix(small.nrows(), n, |i, j| small[(i, j)]);
        let step = bounded_least_squares(&columns, &against, &bounds)?;
        let row = |i: usize| {
            let parts = step.iter().enumerate().map(|(k, s)| columns[(i, k)] * s);
            parts.sum::<f64>() - against[i]
        };
        let predicted = (0..small.nrows()).map(|i| row(i).powi(2)).sum();
        Ok((step, predicted))
    }

    /// The iteration from the result with test and model paired again; `None` unless that is
    /// another pairing and ends lower.
    fn paired_anew(&self) -> Result<Option<(Self, StopReason)>, UpdateError> {
        let paired = self.problem.start(&self.at.z)?;
        if paired.root_pairs == self.at.root_pairs {
            return Ok(None);
        }
        let mut other = Self::new(self.problem, paired)?;
        other.history.clone_from(&self.history);
        other.pairing_changes.clone_from(&self.pairing_changes);
        other.note_changes(&self.at.root_pairs, false);
        let reason = other.descend()?;
        let least = MIN_RELATIVE_DECREASE * self.at.objective().max(1.0);
        let lower = other.at.objective() < self.at.objective() - least;
        Ok(lower.then_some((other, reason)))
    }

    /// Records the targets whose partners differ from those of the root pairs before.
    fn note_changes(&mut self, before: &[RootPair], followed: bool) {
        let numbers = |root_pairs: &[RootPair], target: usize| -> Vec<usize> {
            let root_pairs_of = root_pairs
                .iter()
                .filter(|root_pair| root_pair.targets.contains(&target));
            root_pairs_of
                .flat_map(|root_pair| root_pair.modes.iter().map(|mode| mode + 1))
                .collect()
        };
        for (t, target) in self.problem.targets.iter().enumerate() {
            let (from, to) = (numbers(before, t), numbers(&self.at.root_pairs, t));
            if from != to {
                self.pairing_changes.push(PairingChange {
                    label: target.label.clone(),
                    after_iterations: self.history.len(),
                    from,
                    to,
                    followed,
                });
            }
        }
    }

    fn record(&mut self, radius: f64, accepted: bool) {
        let free = self.problem.free.iter().zip(&self.at.z);
        self.history.push(Iteration {
            objective: self.at.objective(),
            chi_square: self.at.chi_square(),
            values: free.map(|(parameter, z)| parameter.value(*z)).collect(),
            radius,
            accepted,
        });
    }
}
