//! Design finds the smallest changes of parameters that move natural frequencies to stated targets.
//!
//! With `z` the changes of the free parameters on the scale of their priors, it minimises `sum z^2`
//! so that each target is met and each parameter stays between its bounds. Each step solves this
//! problem with the targets linearised in the logarithm of the frequencies; the model is then
//! solved again, its modes tracked from the initial values, and a line search on the cost with the
//! exact penalty of the violated targets accepts the step. The least cost over several starts is
//! the proposal.
//!
//! # Reference
//! Avitabile (2003), Twenty years of structural dynamic modification: a review, Sound and Vibration
//! 37(1), 14; Mottershead and Ram (2006), Inverse eigenvalue problems in vibration absorption:
//! passive modification and active control, Mechanical Systems and Signal Processing 20, 5; Nocedal
//! and Wright (2006), Numerical Optimization, 2nd ed., chapter 18 (sequential quadratic
//! programming) and section 17.3 (augmented Lagrangian).

use std::f64::consts::TAU;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::axis::Band;
use crate::linalg::real_matrix;
use crate::theory::{RootState, TheoreticalModel, TheoryError, TrackedModes, frequency_slopes};

use super::bounded::bounded_least_squares;
use super::parameter::free_parameters;
use super::{FreeParameter, ParameterChoice, UpdateError, UpdateOptions};

/// Maximum violation of the logarithm of a frequency that counts as met.
const MAX_VIOLATION: f64 = 1e-9;
/// Maximum number of steps from one start; a start of the four transmissions takes up to 20.
const MAX_STEPS: usize = 60;
/// Halvings of a step before the iteration ends.
const MAX_HALVINGS: usize = 14;
/// Smallest step, in `z`.
const MIN_STEP: f64 = 1e-11;
/// Smallest part of the predicted decrease that a step must have.
const MIN_DECREASE: f64 = 1e-4;
/// Weight of the linearised targets against the cost, and number of corrections of the multipliers.
/// Larger: rounding. Smaller: more corrections.
const PENALTY: f64 = 1e6;
const CORRECTIONS: usize = 6;
/// Penalty of a violated target over its multiplier, above 1 for an exact penalty.
const PENALTY_OVER_MULTIPLIER: f64 = 1.5;
/// Number of starts at the best changes of a single parameter, and of those that are drawn between
/// the bounds.
const SINGLE_STARTS: usize = 2;
const DRAWN_STARTS: usize = 5;
/// Seed of these starts.
const SEED: u64 = 1;
/// Bounds of a parameter without stated ones, as factors of its value.
const DEFAULT_FACTORS: [f64; 2] = [0.5, 2.0];

/// What a natural frequency has to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// At least this, Hz.
    Above(f64),
    /// At most this, Hz.
    Below(f64),
    /// This, Hz.
    Equal(f64),
    /// Outside this band.
    Outside(Band),
}

/// A target for the modes of a root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrequencyTarget {
    /// Number of the root of the initial model, counted from 0 for the lowest.
    pub root: usize,
    /// Goal.
    pub goal: Goal,
}

/// A natural frequency before and after a proposed change.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignMode {
    /// Number of the root of the initial model.
    pub root: usize,
    /// Number of modes.
    pub multiplicity: usize,
    /// Frequency of the initial model, Hz.
    pub before_hz: f64,
    /// Frequency of first order in the changes of the parameters, Hz.
    pub first_order_hz: f64,
    /// Frequency of the changed model, Hz.
    pub after_hz: f64,
}

/// A proposed change of parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposal {
    /// The change of each free parameter on the scale of its prior.
    pub z: Vec<f64>,
    /// Values of the free parameters.
    pub free_values: Vec<f64>,
    /// Values of all parameters of the model.
    pub values: Vec<f64>,
    /// `sum z^2`.
    pub cost: f64,
    /// Whether all targets are met.
    pub is_met: bool,
    /// Largest violation of a target, as a part of its frequency; 0 where all are met.
    pub violation: f64,
    /// Natural frequencies, in the order of the initial model.
    pub modes: Vec<DesignMode>,
}

/// The proposals for some targets.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    /// Each parameter alone, by its index among the free ones: those that meet the targets by their
    /// cost, then the others by their violation.
    pub single: Vec<(usize, Proposal)>,
    /// All free parameters together.
    pub combined: Proposal,
}

/// The parameters that a design may change. A log-normal prior of deviation 1 is the logarithm of
/// the ratio. Bounds that neither the choice states are half the value and twice the value.
///
/// # Errors
/// Those of a free parameter.
pub fn design_parameters(
    model: &dyn TheoreticalModel,
    values: &[f64],
    choices: &[ParameterChoice],
    prior_std: f64,
) -> Result<Vec<FreeParameter>, UpdateError> {
    let options = UpdateOptions {
        prior_std,
        ..UpdateOptions::default()
    };
    let bounded = |choice: &ParameterChoice| {
        let specs = model.parameters().iter();
        let mut named = specs.zip(values).filter(|(s, _)| s.name == choice.name);
        let value = named.next().map_or(0.0, |(_, value)| *value);
        let ends = DEFAULT_FACTORS.map(|factor| factor * value);
        let [lower, upper] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        let stated = |bound: Option<f64>, default: f64| match value == 0.0 {
            true => bound,
            false => bound.or(Some(default)),
        };
        ParameterChoice {
            lower: stated(choice.lower, lower),
            upper: stated(choice.upper, upper),
            ..choice.clone()
        }
    };
    let bounded: Vec<ParameterChoice> = choices.iter().map(bounded).collect();
    free_parameters(model, values, &bounded, &options)
}

/// The smallest changes of the free parameters that meet all targets, of each alone and of all
/// together; in the caller's pool, with the same result for any number of threads.
///
/// # Errors
/// Those of the initial model; [`UpdateError::Linalg`].
pub fn design(
    model: &dyn TheoreticalModel,
    values: &[f64],
    free: &[FreeParameter],
    targets: &[FrequencyTarget],
    band: Option<Band>,
) -> Result<Design, UpdateError> {
    let mut branches: Vec<Vec<Limit>> = vec![Vec::new()];
    for target in targets {
        let limits = Limit::alternatives(target);
        let longer = |branch: &Vec<Limit>| {
            let branch = branch.clone();
            let with = move |limit: &Limit| branch.iter().copied().chain([*limit]).collect();
            limits.iter().map(with).collect::<Vec<Vec<Limit>>>()
        };
        branches = branches.iter().flat_map(longer).collect();
    }
    let problem = Problem {
        model,
        values,
        free,
        band,
    };
    let roots: Vec<usize> = targets.iter().map(|target| target.root).collect();
    let initial = problem.initial(&roots)?;
    let n = free.len();
    let alone = |j: usize| {
        let (lower, upper) = free[j].bounds();
        let start = |z: f64| {
            let mut start = vec![0.0; n];
            start[j] = z;
            start
        };
        let near = problem.best(&initial, &branches, &[j], &[start(0.0)])?;
        if near.violation <= MAX_VIOLATION {
            return Ok(near);
        }
        let far = problem.best(&initial, &branches, &[j], &[start(lower), start(upper)])?;
        Ok(if far.rank() < near.rank() { far } else { near })
    };
    let ends: Result<Vec<End>, UpdateError> = (0..n).into_par_iter().map(alone).collect();
    let mut single: Vec<(usize, End)> = ends?.into_iter().enumerate().collect();
    single.sort_by(|a, b| a.1.rank().total_cmp(&b.1.rank()));
    let mut starts = vec![vec![0.0; n]];
    let best = single.iter().take(SINGLE_STARTS);
    starts.extend(best.map(|(_, end)| end.point.z.clone()));
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    for _ in 0..DRAWN_STARTS {
        let one = free.iter().map(|parameter| {
            let (lower, upper) = parameter.bounds();
            random.random_range(lower..=upper)
        });
        starts.push(one.collect());
    }
    let all: Vec<usize> = (0..n).collect();
    let mut combined = problem.best(&initial, &branches, &all, &starts)?;
    if let Some((_, best)) = single.first().filter(|(_, e)| e.rank() < combined.rank()) {
        combined = best.clone();
    }
    let from = Some(&initial.point);
    let proposal = |(j, end): &(usize, End)| Ok((*j, problem.proposal(&initial, end, from)?));
    let single = single.par_iter().map(proposal);
    Ok(Design {
        combined: problem.proposal(&initial, &combined, None)?,
        single: single.collect::<Result<_, UpdateError>>()?,
    })
}

/// A bound of the frequencies of a root.
#[derive(Clone, Copy, Debug)]
struct Limit {
    root: usize,
    hz: f64,
    /// 1 for a lower bound, -1 for an upper one, 0 for both.
    side: f64,
}

impl Limit {
    /// The limits of which one has to be met.
    fn alternatives(target: &FrequencyTarget) -> Vec<Self> {
        let limit = |hz, side| Self {
            root: target.root,
            hz,
            side,
        };
        match target.goal {
            Goal::Above(hz) => vec![limit(hz, 1.0)],
            Goal::Below(hz) => vec![limit(hz, -1.0)],
            Goal::Equal(hz) => vec![limit(hz, 0.0)],
            Goal::Outside(band) => vec![limit(band.hi_hz, 1.0), limit(band.lo_hz, -1.0)],
        }
    }

    /// Violation by a frequency, of its logarithm.
    fn violation(&self, log_excess: f64) -> f64 {
        match self.side {
            0.0 => log_excess.abs(),
            side => (-side * log_excess).max(0.0),
        }
    }
}

/// The model at a point.
#[derive(Clone, Debug)]
struct Point {
    z: Vec<f64>,
    values: Vec<f64>,
    tracked: TrackedModes,
    roots: Vec<[RootState; 2]>,
}

impl Point {
    fn cost(&self) -> f64 {
        self.z.iter().map(|z| z * z).sum()
    }

    /// Each limit with the index of each root that it bounds, and the logarithm of the frequency
    /// over the limit.
    fn excesses<'a>(
        &'a self,
        limits: &'a [Limit],
    ) -> impl Iterator<Item = (&'a Limit, usize, f64)> + 'a {
        limits.iter().flat_map(move |limit| {
            let states = self.roots.iter().enumerate();
            let of_root = states.filter(|(_, [before, _])| before.root == limit.root);
            of_root
                .map(move |(k, [_, after])| (limit, k, (after.omega_rad_s / (TAU * limit.hz)).ln()))
        })
    }

    fn violations(&self, limits: &[Limit]) -> Vec<f64> {
        let all = self.excesses(limits);
        all.map(|(limit, _, excess)| limit.violation(excess))
            .collect()
    }
}

/// End of the iteration from one start.
#[derive(Clone, Debug)]
struct End {
    point: Point,
    limits: Vec<Limit>,
    /// Largest violation.
    violation: f64,
}

impl End {
    fn new(point: Point, limits: &[Limit]) -> Self {
        Self {
            violation: point.violations(limits).into_iter().fold(0.0, f64::max),
            limits: limits.to_vec(),
            point,
        }
    }

    /// Below 1 where the targets are met, by the cost; from 1 on by the violation.
    fn rank(&self) -> f64 {
        match self.violation <= MAX_VIOLATION {
            true => 1.0 - 1.0 / (1.0 + self.point.cost()),
            false => 1.0 + self.violation,
        }
    }
}

/// The initial model with the derivatives of its frequencies by `z` and by the values.
struct Initial {
    point: Point,
    slopes_by_value: Vec<Vec<f64>>,
}

struct Problem<'a> {
    model: &'a dyn TheoreticalModel,
    values: &'a [f64],
    free: &'a [FreeParameter],
    band: Option<Band>,
}

impl Problem<'_> {
    fn initial(&self, watched: &[usize]) -> Result<Initial, UpdateError> {
        let mut point = self.point(&vec![0.0; self.free.len()], None)?;
        point.tracked = point.tracked.watching(watched);
        let states: Vec<&RootState> = point.roots.iter().map(|[_, after]| after).collect();
        let slopes_by_value = self.slopes(&point.values, &states)?;
        Ok(Initial {
            point,
            slopes_by_value,
        })
    }

    /// The model at a point, its modes tracked from another point, or from the initial values.
    fn point(&self, z: &[f64], from: Option<&Point>) -> Result<Point, UpdateError> {
        let mut values = self.values.to_vec();
        for (parameter, &z) in self.free.iter().zip(z) {
            values[parameter.index] = parameter.value(z);
        }
        let tracked = match from {
            Some(from) => from.tracked.track_on(self.model, &values)?,
            None => TrackedModes::new(self.model, self.values, &values, self.band)?,
        };
        Ok(Point {
            roots: tracked.roots(),
            z: z.to_vec(),
            values,
            tracked,
        })
    }

    /// Derivatives of the frequencies by the free values, (rad/s) per unit.
    fn slopes(&self, values: &[f64], states: &[&RootState]) -> Result<Vec<Vec<f64>>, UpdateError> {
        let by: Vec<usize> = self.free.iter().map(|parameter| parameter.index).collect();
        Ok(frequency_slopes(self.model, values, &by, states)?)
    }

    /// The best end over all branches and starts.
    fn best(
        &self,
        initial: &Initial,
        branches: &[Vec<Limit>],
        active: &[usize],
        starts: &[Vec<f64>],
    ) -> Result<End, UpdateError> {
        let runs: Vec<(&Vec<Limit>, &Vec<f64>)> = branches
            .iter()
            .flat_map(|branch| starts.iter().map(move |start| (branch, start)))
            .collect();
        let run =
            |(limits, start): &(&Vec<Limit>, &Vec<f64>)| self.solve(initial, limits, active, start);
        let ends: Result<Vec<Option<End>>, UpdateError> = runs.par_iter().map(run).collect();
        let best = ends?.into_iter().flatten();
        let best = best.min_by(|a, b| a.rank().total_cmp(&b.rank()));
        Ok(best.unwrap_or_else(|| End {
            point: initial.point.clone(),
            limits: Vec::new(),
            violation: f64::INFINITY,
        }))
    }

    /// Sequential quadratic programming from one start; `None` where the model cannot be solved or
    /// its modes not tracked there.
    fn solve(
        &self,
        initial: &Initial,
        limits: &[Limit],
        active: &[usize],
        start: &[f64],
    ) -> Result<Option<End>, UpdateError> {
        let Some(mut point) = unless_theory_error(self.point(start, Some(&initial.point)))? else {
            return Ok(None);
        };
        let mut penalty = 0.0;
        for _ in 0..MAX_STEPS {
            let step = self.step(&point, limits, active)?;
            penalty = step.penalty.max(penalty);
            let size = step.z.iter().zip(&point.z).map(|(a, b)| (a - b).abs());
            if size.fold(0.0, f64::max) <= MIN_STEP {
                break;
            }
            let merit =
                |cost: f64, violations: &[f64]| cost + penalty * violations.iter().sum::<f64>();
            let now = merit(point.cost(), &point.violations(limits));
            let goal: f64 = step.z.iter().map(|z| z * z).sum();
            let predicted = now - merit(goal, &step.violations);
            let mut part = 1.0;
            let mut next = None;
            for _ in 0..MAX_HALVINGS {
                let z = point.z.iter().zip(&step.z);
                let z: Vec<f64> = z.map(|(a, b)| a + part * (b - a)).collect();
                let found = unless_theory_error(self.point(&z, Some(&point)))?.filter(|found| {
                    let merit = merit(found.cost(), &found.violations(limits));
                    merit < now - MIN_DECREASE * part * predicted.max(0.0)
                });
                if found.is_some() {
                    next = found;
                    break;
                }
                part *= 0.5;
            }
            let Some(next) = next else { break };
            point = next;
        }
        Ok(Some(End::new(point, limits)))
    }

    /// The least cost with the targets linearised at a point, by the method of multipliers over a
    /// bounded least-squares problem in `z` and a slack for each inequality.
    fn step(&self, point: &Point, limits: &[Limit], active: &[usize]) -> Result<Step, UpdateError> {
        let states: Vec<&RootState> = point.roots.iter().map(|[_, after]| after).collect();
        let bounded: Vec<(&Limit, usize, f64)> = point.excesses(limits).collect();
        let of_limits: Vec<&RootState> = bounded.iter().map(|(_, k, _)| states[*k]).collect();
        let slopes = self.slopes(&point.values, &of_limits)?;
        let mut rows: Vec<Row> = Vec::new();
        for ((limit, k, excess), slopes) in bounded.iter().zip(&slopes) {
            let by_z = active.iter().map(|&j| {
                let parameter = &self.free[j];
                let slope = parameter.slope(point.values[parameter.index]);
                slopes[j] * slope / states[*k].omega_rad_s
            });
            let by_z: Vec<f64> = by_z.collect();
            let size = by_z.iter().map(|a| a * a).sum::<f64>().sqrt();
            let there: f64 = by_z.iter().zip(active).map(|(a, &j)| a * point.z[j]).sum();
            rows.push(Row {
                by_z: by_z
                    .iter()
                    .map(|a| a / size.max(f64::MIN_POSITIVE))
                    .collect(),
                goal: (there - excess) / size.max(f64::MIN_POSITIVE),
                size,
                limit: **limit,
            });
        }
        let seen: Vec<&Row> = rows.iter().filter(|row| row.size > MIN_STEP).collect();
        let n = active.len();
        let mut bounds: Vec<(f64, f64)> = active.iter().map(|&j| self.free[j].bounds()).collect();
        let slack = |row: &&Row| match row.limit.side {
            0.0 => None,
            1.0 => Some((0.0, f64::INFINITY)),
            _ => Some((f64::NEG_INFINITY, 0.0)),
        };
        bounds.extend(seen.iter().filter_map(slack));
        let weight = PENALTY.sqrt();
        let mut slack_index = n;
        let mut columns = vec![None; seen.len()];
        for (column, row) in columns.iter_mut().zip(&seen) {
            if row.limit.side != 0.0 {
                *column = Some(slack_index);
                slack_index += 1;
            }
        }
        let a = real_matrix(n + seen.len(), slack_index, |i, j| match i.checked_sub(n) {
            None if i == j => 1.0,
            None => 0.0,
            Some(k) if j < n => weight * seen[k].by_z[j],
            Some(k) if columns[k] == Some(j) => -weight,
            Some(_) => 0.0,
        });
        let mut multipliers = vec![0.0; seen.len()];
        let mut x = vec![0.0; slack_index];
        for _ in 0..CORRECTIONS {
            let mut b = vec![0.0; n];
            let goals = seen.iter().zip(&multipliers);
            b.extend(goals.map(|(row, m)| weight * (row.goal - m / PENALTY)));
            x = bounded_least_squares(&a, &b, &bounds)?;
            for (k, row) in seen.iter().enumerate() {
                let reached: f64 = row.by_z.iter().zip(&x).map(|(a, z)| a * z).sum();
                let slack = columns[k].map_or(0.0, |column| x[column]);
                multipliers[k] += PENALTY * (reached - slack - row.goal);
            }
        }
        let penalties = seen.iter().zip(&multipliers);
        let penalties =
            penalties.map(|(row, m)| 2.0 * PENALTY_OVER_MULTIPLIER * m.abs() / row.size);
        let mut z = point.z.clone();
        for (&j, x) in active.iter().zip(&x) {
            z[j] = *x;
        }
        let violation = |row: &Row| {
            let reached: f64 = row.by_z.iter().zip(&x).map(|(a, z)| a * z).sum();
            row.limit.violation(row.size * (reached - row.goal))
        };
        Ok(Step {
            violations: rows.iter().map(violation).collect(),
            penalty: penalties.fold(0.0, f64::max),
            z,
        })
    }

    /// The proposal, its modes tracked anew along the straight path: from another point, or from
    /// the initial values with regard to all crossings.
    fn proposal(
        &self,
        initial: &Initial,
        end: &End,
        from: Option<&Point>,
    ) -> Result<Proposal, UpdateError> {
        let tracked = unless_theory_error(self.point(&end.point.z, from))?;
        let end = match tracked {
            Some(point) if !end.limits.is_empty() => End::new(point, &end.limits),
            _ => end.clone(),
        };
        let point = &end.point;
        let changes = self
            .free
            .iter()
            .map(|parameter| point.values[parameter.index] - self.values[parameter.index]);
        let changes: Vec<f64> = changes.collect();
        let mode = |[before, after]: &[RootState; 2]| {
            let first = initial.point.roots.iter();
            let place = first.clone().position(|[b, _]| b.root == before.root);
            let slopes = place.map(|k| &initial.slopes_by_value[k]);
            let change: f64 = slopes.map_or(0.0, |slopes| {
                slopes.iter().zip(&changes).map(|(g, d)| g * d).sum()
            });
            DesignMode {
                root: before.root,
                multiplicity: after.vectors.ncols(),
                before_hz: before.omega_rad_s / TAU,
                first_order_hz: (before.omega_rad_s + change) / TAU,
                after_hz: after.omega_rad_s / TAU,
            }
        };
        Ok(Proposal {
            z: point.z.clone(),
            free_values: self.free.iter().map(|p| point.values[p.index]).collect(),
            values: point.values.clone(),
            cost: point.cost(),
            is_met: end.violation <= MAX_VIOLATION,
            violation: match end.violation <= MAX_VIOLATION {
                true => 0.0,
                false => 1.0 - (-end.violation).exp(),
            },
            modes: point.roots.iter().map(mode).collect(),
        })
    }
}

/// A linearised target, over the length of its row.
struct Row {
    by_z: Vec<f64>,
    goal: f64,
    size: f64,
    limit: Limit,
}

/// The solution of the linearised problem.
struct Step {
    z: Vec<f64>,
    violations: Vec<f64>,
    penalty: f64,
}

/// `None` where the model cannot be solved.
fn unless_theory_error(point: Result<Point, UpdateError>) -> Result<Option<Point>, UpdateError> {
    match point {
        Ok(point) => Ok(Some(point)),
        Err(UpdateError::Theory(TheoryError::Linalg(error))) => {
            Err(UpdateError::Theory(TheoryError::Linalg(error)))
        }
        Err(UpdateError::Theory(_)) => Ok(None),
        Err(error) => Err(error),
    }
}
