//! A bounded Gauss-Newton method with a trust region solves the update from one start.
//!
//! Each step solves `min |J s + r|` with `s` in the box where the linear model is trusted and the
//! parameters stay between their bounds; the box grows where the model foretells the decrease and
//! shrinks where it does not. The prior's rows give `J` full column rank. When no step is left and
//! a misfit remains, test and model are paired anew at the result; where the iteration from there
//! ends lower, that is taken.
//!
//! # Reference
//! Conn, Gould and Toint (2000), Trust-Region Methods, chapters 6 and 12 (box-shaped regions and
//! bounds).

use crate::linalg::{RealMatrix, real_matrix, upper_triangle};

use super::bounded::bounded_least_squares;
use super::evaluate::largest_chi_square;
use super::history::{Iteration, PairingChange, StopReason};
use super::{Evaluation, Link, Residuals, UpdateError, UpdateProblem};

/// A decrease below this part of the objective (of 1 where it is less) says nothing: it moves no
/// parameter by more than a ten-thousandth of its posterior deviation.
pub(super) const MIN_RELATIVE_DECREASE: f64 = 1e-8;
/// A radius below this is as small as rounding of `z` allows.
const MIN_TRUST_RADIUS: f64 = 1e-9;
/// Share of the predicted decrease below which the box shrinks.
const POOR: f64 = 0.25;
/// Share above which it grows.
const GOOD: f64 = 0.75;
/// Largest radius, in first steps.
const LARGEST_RADIUS: f64 = 10.0;
/// How often test and model may be paired anew from one start.
const PAIRINGS: usize = 10;

/// Where the iteration from one start ended.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The model there.
    pub at: Evaluation,
    /// Derivatives of the residuals there.
    pub jacobian: RealMatrix,
    /// Every step.
    pub history: Vec<Iteration>,
    /// Measured roots that met other modes on the way.
    pub pairing_changes: Vec<PairingChange>,
    /// Why it ended.
    pub stop_reason: StopReason,
}

/// Whether residuals of modes end above what noise explains.
pub(super) fn leaves_a_misfit(problem: &UpdateProblem<'_>, at: &Evaluation) -> bool {
    let of_modes = problem.options.residuals != Residuals::ModalDynamic && !problem.compares_frfs;
    let free = problem.free.len();
    let nu = problem.data_count(at).saturating_sub(free).max(1) as f64;
    of_modes && at.chi_square() > largest_chi_square(nu)
}

/// The lowest objective from a point with its pairs, and with those that test and model have where
/// that ends.
pub(super) fn solve_from(
    problem: &UpdateProblem<'_>,
    at: Evaluation,
) -> Result<Solution, UpdateError> {
    let mut run = Run::new(problem, at)?;
    let mut stop_reason = run.descend()?;
    for _ in 1..PAIRINGS {
        if !leaves_a_misfit(problem, &run.at) {
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

    /// Steps until one of the reasons to stop.
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
            if share < POOR {
                radius *= 0.25;
            } else if share > GOOD {
                radius = (2.0 * radius).min(LARGEST_RADIUS);
            }
            let accepted = next.filter(|_| share > 0.0);
            let taken = accepted.is_some();
            if let Some(next) = accepted {
                let links = std::mem::take(&mut self.at.links);
                self.move_to(next)?;
                self.note_changes(&links, true);
            }
            self.record(radius, taken);
            if radius < MIN_TRUST_RADIUS {
                return Ok(StopReason::SmallStep);
            }
        }
        Ok(StopReason::IterationLimit)
    }

    /// The step of the linear model inside the box and the bounds, and the objective that the model
    /// foretells after it.
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

    /// From the result with test and model paired anew there; `None` unless that is another pairing
    /// and ends lower.
    fn paired_anew(&self) -> Result<Option<(Self, StopReason)>, UpdateError> {
        let paired = self.problem.start(&self.at.z)?;
        if paired.links == self.at.links {
            return Ok(None);
        }
        let mut other = Self::new(self.problem, paired)?;
        other.history.clone_from(&self.history);
        other.pairing_changes.clone_from(&self.pairing_changes);
        other.note_changes(&self.at.links, false);
        let reason = other.descend()?;
        let least = MIN_RELATIVE_DECREASE * self.at.objective().max(1.0);
        let lower = other.at.objective() < self.at.objective() - least;
        Ok(lower.then_some((other, reason)))
    }

    /// Notes what meets other modes than by the links before.
    fn note_changes(&mut self, before: &[Link], followed: bool) {
        let numbers = |links: &[Link], target: usize| -> Vec<usize> {
            let links_of = links.iter().filter(|link| link.targets.contains(&target));
            links_of
                .flat_map(|link| link.modes.iter().map(|mode| mode + 1))
                .collect()
        };
        for (t, target) in self.problem.targets.iter().enumerate() {
            let (from, to) = (numbers(before, t), numbers(&self.at.links, t));
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
        let free = self.problem.free.iter();
        self.history.push(Iteration {
            objective: self.at.objective(),
            chi_square: self.at.chi_square(),
            values: free
                .map(|parameter| self.at.values[parameter.index])
                .collect(),
            radius,
            accepted,
        });
    }
}
