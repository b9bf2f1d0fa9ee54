//! The result of an update holds the multi-start solution, identifiability, and parameters kept
//! where the data do not determine them.

use crate::linalg::{RealMatrix, real_matrix, sort_ascending_by};
use crate::theory::ParameterStatus;

use super::alternatives::{
    Alternative, MAX_OBJECTIVE_DIFFERENCE, MIN_DIFFERENCE_STDS, alternatives,
};
use super::contribution::{Contradiction, Contribution, contradiction, contributions};
use super::evaluate::max_chi_square;
use super::history::{Iteration, PairingChange, StopReason};
use super::identifiability::{
    Combination, Identifiability, MAX_POSTERIOR_OVER_PRIOR, ParameterVerdict, TWO_SIDED_95,
};
use super::model_error::{Grown, ModelError, ResidualKind, UnpredictedMode, grow};
use super::scatter::Scatter;
use super::solve::{MAX_OPTIMUM_DIFFERENCE, MultiStart, solve, solve_from_starts};
use super::trust_region::Solution;
use super::{Evaluation, ReversedSensors, ShapeWeights, UpdateError, UpdateProblem};

/// Largest distance of a parameter at its bound, in prior deviations.
const MAX_DISTANCE_FROM_BOUND: f64 = 1e-6;
/// Largest difference of the objective at the end of a start that may lead to an alternative.
const MAX_END_DIFFERENCE: f64 = 2.0 * MAX_OBJECTIVE_DIFFERENCE;
/// Fewest degrees of freedom from which a model error supports a verdict.
///
/// Larger (6): 8 of 130 parameters of a coarse model have a verdict in place of 114. Smaller (1.5):
/// 21 of 129 parameters are identified within model error although the sensors are mirrored, in
/// place of 14. Test: `verdicts_on_parameters_have_grounds` of the population.
const MIN_MODEL_ERROR_FREEDOM: f64 = 3.0;
/// Fewest starts that ended from which the lowest optimum is expected to be reached twice.
///
/// Larger (7): an update from six starts, five of which end elsewhere, identifies all parameters.
/// Smaller (2): one from two starts, one of which ends elsewhere, identifies none. Test:
/// `one_of_many_starts_at_the_lowest_optimum_identifies_nothing`.
const MIN_STARTS_TO_COMPARE: usize = 5;
/// Number of fits to FRFs, each with the damping at the frequencies of the fit before.
const FRF_ROUNDS: usize = 2;

/// A parameter before and after.
#[derive(Clone, Debug, PartialEq)]
pub struct UpdatedParameter {
    /// Name.
    pub name: String,
    /// The configuration that has it, where the first one does not.
    pub configuration: Option<String>,
    /// Unit.
    pub unit: String,
    /// Source of the model's value.
    pub status: ParameterStatus,
    /// Value at the start.
    pub initial: f64,
    /// Value at the end.
    pub updated: f64,
    /// Its posterior deviation, with all free parameters uncertain. Where noise does not explain
    /// the residuals, their deviations are taken as grown by [`ModelError::growth`], and it is at
    /// least the jackknife deviation over the modes. An estimate of the growth from few residuals
    /// widens it by the ratio of Student's distribution to the normal one.
    pub std: f64,
    /// 95 % interval; not symmetric for a log-normal prior.
    pub interval_95: (f64, f64),
    /// Prior deviation.
    pub prior_std: f64,
    /// Lower bound; `None` without one.
    pub lower: Option<f64>,
    /// Upper bound; `None` without one.
    pub upper: Option<f64>,
    /// Posterior over prior deviation on the scale of the prior.
    pub posterior_over_prior: f64,
    /// What the data say about it.
    pub verdict: ParameterVerdict,
    /// Whether it was held where it started, because the test does not see it.
    pub held: bool,
}

/// One measured root against the model.
#[derive(Clone, Debug, PartialEq)]
pub struct FitRow {
    /// Label of the target.
    pub label: String,
    /// Measured frequency, Hz.
    pub test_hz: f64,
    /// Deviation that its residual is divided by, Hz.
    pub test_std_hz: f64,
    /// The model's; `None` without a partner.
    pub model_hz: Option<f64>,
    /// Deviation of the model's from the uncertain parameters, Hz.
    pub model_std_hz: Option<f64>,
    /// Error of frequency by the reference of the pairing options, percent.
    pub error_percent: Option<f64>,
    /// Weighted MAC.
    pub mac: Option<f64>,
    /// Source of the deviations of its shape; `None` where shapes take no part.
    pub shape_weights: Option<ShapeWeights>,
}

/// The model against all targets.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// One row for each target.
    pub rows: Vec<FitRow>,
    /// `sum r^2` of the data.
    pub chi_square: f64,
    /// Number of independent residuals.
    pub data_count: usize,
    /// Root mean square of the frequency errors, percent.
    pub rms_percent: Option<f64>,
    /// The largest of them in magnitude, percent.
    pub largest_percent: Option<f64>,
}

impl Fit {
    /// Number of targets that have a partner in the model; the errors are theirs.
    pub fn paired(&self) -> usize {
        let rows = self.rows.iter();
        rows.filter(|row| row.model_hz.is_some()).count()
    }
}

/// The FRFs that were compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrfCount {
    /// Functions with both ends at sensors of the model and a line that counts.
    pub compared: usize,
    /// All functions of the tests.
    pub given: usize,
    /// Lines that count, of all functions.
    pub lines: usize,
}

/// How the starts ended; those of the modes, where FRFs were compared: these are fitted from the
/// best end alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Starts {
    /// Number of starts.
    pub count: usize,
    /// Number of starts that ended at the best optimum.
    pub reached: usize,
    /// Number of starts that could not be built or solved.
    pub failed: usize,
    /// Seed.
    pub seed: u64,
    /// Objective of the best optimum with the stated deviations; that of modes, where FRFs were
    /// compared.
    pub lowest_objective: f64,
    /// Where the others ended, lowest objective first.
    pub others: Vec<OtherOptimum>,
}

impl Starts {
    /// Whether one start alone ended at the best optimum, of enough to know better: there may be a
    /// lower one.
    pub fn is_scattered(&self) -> bool {
        self.count - self.failed >= MIN_STARTS_TO_COMPARE && self.reached == 1
    }
}

/// Where some starts ended, above the best optimum.
#[derive(Clone, Debug, PartialEq)]
pub struct OtherOptimum {
    /// Objective; that of modes, where FRFs were compared.
    pub objective: f64,
    /// Number of starts that ended there.
    pub count: usize,
    /// Values of the free parameters.
    pub values: Vec<f64>,
}

/// The result of updating.
#[derive(Clone, Debug)]
pub struct UpdateResult {
    /// The free parameters.
    pub parameters: Vec<UpdatedParameter>,
    /// Correlation of the posterior errors of the free parameters.
    pub correlation: Vec<Vec<f64>>,
    /// Identifiable combinations, the best determined first.
    pub combinations: Vec<Combination>,
    /// All parameters of the model after, of the first configuration.
    pub values: Vec<f64>,
    /// The same of each configuration.
    pub configuration_values: Vec<Vec<f64>>,
    /// Why the best start ended.
    pub stop_reason: StopReason,
    /// Every step from the best start; then those with the unseen parameters held.
    pub history: Vec<Iteration>,
    /// Measured roots whose partner changed during the iteration.
    pub pairing_changes: Vec<PairingChange>,
    /// How the starts ended.
    pub starts: Starts,
    /// The model as it stood.
    pub before: Fit,
    /// The model after.
    pub after: Fit,
    /// Test modes without a partner in the model at the start: label and frequency, Hz.
    pub left_out: Vec<(String, f64)>,
    /// Sensors with the opposite sign of the model as it stood, of each test that has some; their
    /// values took no part.
    pub reversed: Vec<ReversedSensors>,
    /// The FRFs that were compared; `None` where modes were.
    pub frfs: Option<FrfCount>,
    /// Number of parameters that the data determine with the stated deviations.
    pub determined: f64,
    /// Model error of each kind of residuals.
    pub model_errors: Vec<ModelError>,
    /// Modes that the others do not predict.
    pub unpredicted: Vec<UnpredictedMode>,
    /// What each configuration contributes; none where there is one configuration.
    pub contributions: Vec<Contribution>,
    /// The shared parameter that contradicts most between configurations.
    pub contradiction: Option<Contradiction>,
    /// Scatter of the frequencies between tests of one configuration, where it was requested and
    /// can be estimated.
    pub scatter: Option<Scatter>,
    /// Other optima of about the same objective.
    pub alternatives: Vec<Alternative>,
}

impl UpdateResult {
    /// `nu = N - sum s^2/(1 + s^2)`: residuals of data less the combinations of parameters that
    /// they determine with the stated deviations, at least 1.
    pub fn degrees_of_freedom(&self) -> f64 {
        (self.after.data_count as f64 - self.determined).max(1.0)
    }

    /// `chi^2/nu` of the model after; about 1 where it fits.
    pub fn reduced_chi_square(&self) -> f64 {
        self.after.chi_square / self.degrees_of_freedom()
    }

    /// The largest `chi^2/nu` that noise alone explains, `1 + 2 sqrt(2/nu)`.
    pub fn largest_reduced_chi_square(&self) -> f64 {
        let nu = self.degrees_of_freedom();
        max_chi_square(nu) / nu
    }

    /// `chi^2/nu` of the kind of residuals that exceeds its limit most, with the limit and the
    /// kind; of all residuals where none exceeds it more than these.
    pub fn worst_reduced_chi_square(&self) -> (f64, f64, Option<ResidualKind>) {
        let over = |(value, limit, _): &(f64, f64, Option<ResidualKind>)| value / limit;
        let kinds = self.model_errors.iter();
        let kinds = kinds.map(|error| {
            let limit = error.largest_reduced_chi_square;
            (error.reduced_chi_square, limit, Some(error.kind))
        });
        let (value, limit) = (self.reduced_chi_square(), self.largest_reduced_chi_square());
        kinds.fold((value, limit, None), |worst, kind| {
            if over(&kind) > over(&worst) {
                kind
            } else {
                worst
            }
        })
    }

    /// Whether the model after fits the test within the stated uncertainties.
    pub fn fits(&self) -> bool {
        let grown = self.model_errors.iter().any(|error| error.growth > 1.0);
        !grown && self.reduced_chi_square() <= self.largest_reduced_chi_square()
    }
}

/// Updates a model: the best of several starts. A parameter that the test does not see returns to
/// its initial value and is held there while the others are solved again.
///
/// # Errors
/// As [`solve_from_starts`].
pub fn update(problem: &UpdateProblem<'_>) -> Result<UpdateResult, UpdateError> {
    let result = update_to_all(problem)?;
    if result.fits() {
        return Ok(result);
    }
    // A mode of the mount may be the nearest free one to a mode of the model.
    let Some(near) = problem.without_far() else {
        return Ok(result);
    };
    let without = update_to_all(&near)?;
    Ok(if without.fits() { without } else { result })
}

fn update_to_all(problem: &UpdateProblem<'_>) -> Result<UpdateResult, UpdateError> {
    let found = solve_from_starts(problem)?;
    let starts = starts(problem, &found)?;
    let ends = near_ends(problem, &found);
    if problem.options.residuals.of_frfs() && !problem.compares_frfs {
        return update_to_frfs(problem, found.best, starts, &ends);
    }
    summarise(problem, found.best, starts, &ends)
}

/// The ends of the starts whose objective, less that of the best, may be that of an alternative
/// with the deviations that the residuals of the best support.
fn near_ends(problem: &UpdateProblem<'_>, found: &MultiStart) -> Vec<Vec<f64>> {
    let best = &found.best.at;
    let nu = problem.data_count(best).saturating_sub(problem.free.len());
    let growth = (best.chi_square() / nu.max(1) as f64).max(1.0);
    let near = |objective: f64| objective - best.objective() <= growth * MAX_END_DIFFERENCE;
    let ends = found.objectives.iter().zip(&found.ends);
    let ends = ends.filter(|(objective, _)| objective.is_some_and(near));
    ends.filter_map(|(_, end)| end.clone()).collect()
}

/// Continues from the solution for modes with FRFs for residuals: twice, the second time with the
/// damping at the frequencies that the first time found.
fn update_to_frfs(
    problem: &UpdateProblem<'_>,
    mut best: Solution,
    starts: Starts,
    ends: &[Vec<f64>],
) -> Result<UpdateResult, UpdateError> {
    let mut with_frfs = problem.with_frfs(&best.at)?;
    for round in 0..FRF_ROUNDS {
        if round > 0 {
            with_frfs = problem.with_frfs(&best.at)?;
        }
        let mut next = solve(&with_frfs, &best.at.z)?;
        next.history.splice(..0, best.history);
        next.pairing_changes.splice(..0, best.pairing_changes);
        best = next;
    }
    summarise(&with_frfs, best, starts, ends)
}

fn summarise(
    problem: &UpdateProblem<'_>,
    best: Solution,
    starts: Starts,
    ends: &[Vec<f64>],
) -> Result<UpdateResult, UpdateError> {
    let contradiction = contradiction(problem, &best)?;
    let grown = grow(problem, best)?;
    let student_factor = grown.student_factor();
    let freedom = grown.freedom();
    let Grown {
        problem: weighted,
        solution: best,
        errors,
        unpredicted,
        determined,
        jackknife,
        ..
    } = grown;
    let seen = Identifiability::new(&data_jacobian(&weighted, &best), &problem.free)?;
    let widened = |known: &Identifiability| -> Vec<f64> {
        let ratios = known.ratio.iter().zip(&jackknife);
        ratios
            .map(|(ratio, jackknife)| student_factor * ratio.max(*jackknife))
            .collect()
    };
    let stds = widened(&seen);
    let alternatives = alternatives(&weighted, &best, ends, &stds)?;
    let kept: Vec<usize> = (0..problem.free.len()).filter(|&j| seen.seen(j)).collect();
    let best_z = best.at.z.clone();
    let (at, history, changes, stop_reason) = if kept.is_empty() {
        unchanged(&weighted)?
    } else if kept.len() < problem.free.len() {
        solve_with_unseen_held(&weighted, &kept, best)?
    } else {
        (
            best.at,
            best.history,
            best.pairing_changes,
            best.stop_reason,
        )
    };
    let jacobian = weighted.jacobian(&at)?;
    let data = data_rows(&weighted, &jacobian, at.data_rows);
    let known = Identifiability::new(&data, &problem.free)?;
    let widen = |j: usize, ratio: f64| student_factor * ratio.max(jackknife[j]);
    let before = problem.start(&vec![0.0; problem.free.len()])?;
    let at = problem.at_root_pairs(&at.z, at.root_pairs)?;
    let after = fit(problem, &at, Some(&known))?;
    let ratio = widened(&known);
    let is_ambiguous = |j: usize| {
        let mut others = alternatives.iter();
        others.any(|(_, z)| (z[j] - best_z[j]).abs() > MIN_DIFFERENCE_STDS * ratio[j])
    };
    let is_alone = starts.is_scattered();
    let judged = Judged {
        known: &known,
        kept: &kept,
        ratio: &ratio,
        is_supported: contradiction.is_none()
            && !is_alone
            && unpredicted.is_empty()
            && after.paired() == after.rows.len(),
        model_error: freedom,
        ambiguous: (0..problem.free.len()).map(is_ambiguous).collect(),
    };
    Ok(UpdateResult {
        contributions: contributions(problem, &at, &data, widen)?,
        contradiction,
        scatter: problem.scatter,
        parameters: parameters(problem, &at, &judged),
        correlation: (0..problem.free.len())
            .map(|i| {
                (0..problem.free.len())
                    .map(|j| known.correlation(i, j))
                    .collect()
            })
            .collect(),
        combinations: known.combinations.clone(),
        values: at.values().to_vec(),
        configuration_values: at.states.iter().map(|state| state.values.clone()).collect(),
        stop_reason,
        history,
        pairing_changes: changes,
        starts,
        before: fit(problem, &before, None)?,
        after,
        left_out: problem.left_out.clone(),
        reversed: (problem.reversed.iter())
            .filter(|reversed| !reversed.dofs.is_empty())
            .cloned()
            .collect(),
        frfs: problem.frf_count(),
        determined,
        model_errors: errors,
        unpredicted,
        alternatives: alternatives.into_iter().map(|(other, _)| other).collect(),
    })
}

type Ended = (Evaluation, Vec<Iteration>, Vec<PairingChange>, StopReason);

/// The model at its initial values.
fn unchanged(problem: &UpdateProblem<'_>) -> Result<Ended, UpdateError> {
    let at = problem.start(&vec![0.0; problem.free.len()])?;
    Ok((at, Vec::new(), Vec::new(), StopReason::NothingSeen))
}

/// Solves for the seen parameters from the solution, the others held at their initial values.
fn solve_with_unseen_held(
    problem: &UpdateProblem<'_>,
    kept: &[usize],
    best: Solution,
) -> Result<Ended, UpdateError> {
    let part = problem.with_free(kept);
    let z: Vec<f64> = kept.iter().map(|&j| best.at.z[j]).collect();
    let solution = solve(&part, &z)?;
    let mut whole = vec![0.0; problem.free.len()];
    for (&j, &z) in kept.iter().zip(&solution.at.z) {
        whole[j] = z;
    }
    let at = problem.at_root_pairs(&whole, solution.at.root_pairs)?;
    let mut history = best.history;
    for mut step in solution.history {
        let mut values: Vec<f64> = problem
            .free
            .iter()
            .map(|parameter| parameter.initial)
            .collect();
        for (&j, value) in kept.iter().zip(&step.values) {
            values[j] = *value;
        }
        step.values = values;
        history.push(step);
    }
    let mut changes = best.pairing_changes;
    changes.extend(solution.pairing_changes);
    Ok((at, history, changes, solution.stop_reason))
}

/// The derivatives of the data's residuals, with the deviations that belong to a prior of weight 1.
fn data_jacobian(problem: &UpdateProblem<'_>, solution: &Solution) -> RealMatrix {
    data_rows(problem, &solution.jacobian, solution.at.data_rows)
}

fn data_rows(problem: &UpdateProblem<'_>, jacobian: &RealMatrix, rows: usize) -> RealMatrix {
    real_matrix(rows, jacobian.ncols(), |i, j| {
        jacobian[(i, j)] / problem.prior_weight
    })
}

/// The ends of all starts, grouped by optimum: an end belongs to the best optimum when no parameter
/// differs from it by more than a tenth of its posterior deviation.
fn starts(problem: &UpdateProblem<'_>, found: &MultiStart) -> Result<Starts, UpdateError> {
    let known = Identifiability::new(&data_jacobian(problem, &found.best), &problem.free)?;
    let near = |a: &[f64], b: &[f64]| {
        let mut pairs = a.iter().zip(b).zip(&known.ratio);
        pairs.all(|((a, b), std)| (a - b).abs() <= MAX_OPTIMUM_DIFFERENCE * std)
    };
    let values = |z: &[f64]| -> Vec<f64> {
        let free = problem.free.iter().zip(z);
        free.map(|(parameter, z)| parameter.value(*z)).collect()
    };
    let mut ends: Vec<(f64, &Vec<f64>)> = found
        .objectives
        .iter()
        .zip(&found.ends)
        .filter_map(|(objective, z)| Some(((*objective)?, z.as_ref()?)))
        .collect();
    let count = ends.len();
    ends.retain(|(_, z)| !near(z, &found.best.at.z));
    let reached = count - ends.len();
    sort_ascending_by(&mut ends, |end| end.0);
    let mut others: Vec<(&Vec<f64>, OtherOptimum)> = Vec::new();
    for (objective, z) in ends {
        match others.iter_mut().find(|(known, _)| near(known, z)) {
            Some((_, optimum)) => optimum.count += 1,
            None => {
                let values = values(z);
                others.push((
                    z,
                    OtherOptimum {
                        objective,
                        count: 1,
                        values,
                    },
                ));
            }
        }
    }
    Ok(Starts {
        count: found.ends.len(),
        reached,
        failed: found.ends.len() - count,
        seed: problem.options.seed,
        lowest_objective: found.best.at.objective(),
        others: others.into_iter().map(|(_, optimum)| optimum).collect(),
    })
}

/// What the verdicts on the parameters follow from.
pub(super) struct Judged<'a> {
    pub known: &'a Identifiability,
    /// Parameters that the test sees.
    pub kept: &'a [usize],
    /// Posterior over prior deviation of each parameter.
    pub ratio: &'a [f64],
    /// Whether all modes count and each is predicted by the others.
    pub is_supported: bool,
    /// Degrees of freedom of the model error; `None` where noise explains the residuals.
    pub model_error: Option<f64>,
    /// Whether an alternative has another value, by parameter.
    pub ambiguous: Vec<bool>,
}

impl Judged<'_> {
    /// The verdict on a parameter that is at a bound or between its bounds.
    pub fn verdict(&self, j: usize, at_bound: bool) -> ParameterVerdict {
        if at_bound && self.known.seen(j) {
            ParameterVerdict::AtBound
        } else if self.ratio[j] > MAX_POSTERIOR_OVER_PRIOR {
            ParameterVerdict::NotSupported
        } else if self.ambiguous[j] {
            ParameterVerdict::Ambiguous
        } else if !self.is_supported {
            ParameterVerdict::NotSupported
        } else {
            match self.model_error {
                None => ParameterVerdict::Identified,
                Some(nu) if nu >= MIN_MODEL_ERROR_FREEDOM => {
                    ParameterVerdict::IdentifiedWithinModelError
                }
                Some(_) => ParameterVerdict::NotSupported,
            }
        }
    }
}

fn parameters(
    problem: &UpdateProblem<'_>,
    at: &Evaluation,
    judged: &Judged<'_>,
) -> Vec<UpdatedParameter> {
    let finite = |value: f64| value.is_finite().then_some(value);
    let parameters = problem.free.iter().enumerate().map(|(j, parameter)| {
        let z = at.z[j];
        let (lower, upper) = parameter.bounds();
        let at_bound = z - lower < MAX_DISTANCE_FROM_BOUND || upper - z < MAX_DISTANCE_FROM_BOUND;
        let updated = parameter.value(z);
        let held = !judged.kept.contains(&j);
        let ratio = judged.ratio[j];
        let reach = TWO_SIDED_95 * ratio;
        UpdatedParameter {
            name: parameter.name.clone(),
            configuration: parameter.configuration.clone(),
            unit: parameter.unit.clone(),
            status: parameter.status,
            initial: parameter.initial,
            updated,
            std: parameter.slope(updated) * ratio,
            interval_95: (parameter.value(z - reach), parameter.value(z + reach)),
            prior_std: parameter.prior_std(),
            lower: finite(parameter.lower),
            upper: finite(parameter.upper),
            posterior_over_prior: ratio,
            verdict: judged.verdict(j, at_bound && !held),
            held,
        }
    });
    parameters.collect()
}

/// The model at a point against the targets; with the covariance of the parameters, the standard
/// deviations of its frequencies, too.
pub(super) fn fit(
    problem: &UpdateProblem<'_>,
    at: &Evaluation,
    known: Option<&Identifiability>,
) -> Result<Fit, UpdateError> {
    let stds = match known {
        Some(known) => frequency_stds(problem, at, known)?,
        None => vec![None; problem.targets.len()],
    };
    let fits = problem.fits(at);
    let reference = problem.options.pair.error_reference;
    let rows: Vec<FitRow> = problem
        .targets
        .iter()
        .zip(fits)
        .zip(stds)
        .map(|((target, fit), model_std_hz)| FitRow {
            label: target.label.clone(),
            test_hz: target.hz,
            test_std_hz: target.relative_std * target.hz,
            model_hz: fit.map(|(hz, _)| hz),
            model_std_hz,
            error_percent: fit.map(|(hz, _)| 100.0 * reference.error(target.hz, hz)),
            mac: fit.and_then(|(_, mac)| mac),
            shape_weights: target.shape_weights,
        })
        .collect();
    let errors: Vec<f64> = rows.iter().filter_map(|row| row.error_percent).collect();
    let squares: f64 = errors.iter().map(|e| e * e).sum();
    Ok(Fit {
        chi_square: at.chi_square(),
        data_count: problem.data_count(at),
        rms_percent: (!errors.is_empty()).then(|| (squares / errors.len() as f64).sqrt()),
        largest_percent: errors.iter().map(|e| e.abs()).reduce(f64::max),
        rows,
    })
}

/// `sqrt(g^T C g)` of the frequency of each target, `g` its derivatives by `z`.
fn frequency_stds(
    problem: &UpdateProblem<'_>,
    at: &Evaluation,
    known: &Identifiability,
) -> Result<Vec<Option<f64>>, UpdateError> {
    let n = problem.free.len();
    let mut slopes: Vec<Option<Vec<f64>>> = vec![None; problem.targets.len()];
    let residuals = problem.residuals(at);
    let by = problem.derivatives(at, &residuals)?;
    for (j, (by, slope)) in by.iter().enumerate() {
        for ((root_pair, residual), derivatives) in at.root_pairs.iter().zip(&residuals).zip(by) {
            let hz = residual.frequency_derivatives_hz(derivatives);
            for (&target, hz) in root_pair.targets.iter().zip(hz) {
                slopes[target].get_or_insert_with(|| vec![0.0; n])[j] = hz * slope;
            }
        }
    }
    let variance = |g: &Vec<f64>| -> f64 {
        let row = |i: usize| (0..n).map(|j| known.covariance[(i, j)] * g[j]).sum::<f64>();
        (0..n).map(|i| g[i] * row(i)).sum()
    };
    let std = |g: Option<Vec<f64>>| g.map(|g| variance(&g).max(0.0).sqrt());
    Ok(slopes.into_iter().map(std).collect())
}
