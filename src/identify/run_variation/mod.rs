//! Run variation: natural frequencies that shift between measurement runs, by the mass of a roving
//! sensor or because the structure changed during the test.
//!
//! Fitted with one frequency for all runs, such a mode has the residual of two close modes, and
//! further poles fit it down to the noise. Here every run has its individual pole,
//!
//! ```text
//! H_f = A_f/(iω − λ − (κ + i) δ_r) + …      f in run r,
//! ```
//!
//! or two of them where two modes are close; the decay rates of all runs lie on one straight line
//! over frequency. The Bayesian information criterion compares these with the poles of the fit. The
//! number of poles that stand for one mode is not given: the grouping of the poles that results in
//! the fewest modes is taken. Where the individual poles win, each FRF is aligned to their mean:
//! the difference of both profiles is added to it, and all further steps see one pole. The runs are
//! merged as samples of one mode: the mean weights each run by its variance and the scatter between
//! runs (Paule and Mandel 1982, Journal of Research of the NBS 87). The shift of each run is shrunk
//! by the ratio of the scatter to scatter and variance.

use std::f64::consts::TAU;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::frf::{Function, measurement_runs};
use crate::modal::Pole;

use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::model_pole::ModelPole;
use crate::identify::estimator::Candidate;
use crate::identify::fit::fit_data::FitData;
use crate::linalg::{sort_ascending_by, sort_descending_by};

pub(in crate::identify) mod loaded_shapes;
mod model_selection;
mod pole_shift;
mod resonance;
mod run_fit;
pub(in crate::identify) mod run_means;
pub(in crate::identify) mod separate_responses;
mod shift_decision;
mod shifted_mode;
pub(in crate::identify) mod within_runs;
#[cfg(test)]
mod within_runs_tests;

use pole_shift::{Fitted, Poles};
use resonance::Resonance;
use run_means::RunMean;
use shift_decision::{MAX_SHIFT_FRACTION, Screening, ShiftDecision};
use shifted_mode::{MATCH_BANDWIDTHS, ShiftedMode};

/// Groupings of the poles around a strong one: maximum distance in half-power bandwidths and as a
/// fraction of the frequency. The poles of a group may stand for one mode, or for two that shift
/// together.
const GROUP_BANDWIDTHS_AND_FRACTIONS: [(f64, f64); 3] = [
    (MATCH_BANDWIDTHS, 0.0),
    (2.5, 0.0),
    (2.5, MAX_SHIFT_FRACTION),
];
/// Maximum number of alignments of the runs.
const MAX_ROUNDS: usize = 5;
/// Maximum fits of every resonance; later ones use the shifted poles of the others.
const MAX_SWEEPS: usize = 3;
/// Minimum number of runs: fewer may share a profile of shifts by chance.
const MIN_RUNS: usize = 4;
/// Minimum fraction of the scatter of all modes that one cause must explain.
const MIN_EXPLAINED_FRACTION: f64 = 0.8;
/// Minimum number of modes that shift without a common cause, and minimum fraction of all decided
/// resonances: pairs of close modes, of which each looks like one shifted mode, are fewer.
const MIN_INDEPENDENT_MODES: usize = 3;
const MIN_INDEPENDENT_FRACTION: f64 = 0.7;
/// Minimum distance of an outlying run from the mean, standard deviations.
const OUTLYING_STDS: f64 = 5.0;

/// Measurement runs of the FRFs, and the modes with a frequency that shifts between them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::identify) struct RunShifts {
    runs: Vec<Vec<usize>>,
    /// Whether a run is a position of a sensor rather than an excitation point.
    roving_sensor: bool,
    /// FRFs at the position of the sensor in each run; empty where no sensor is moved, or it has
    /// several axes.
    positions: Vec<Vec<usize>>,
    /// Degrees of freedom of shapes and of participation factors.
    factors: usize,
    modes: Vec<ShiftedMode>,
    /// Number of modes of all groups of poles, unshifted ones included, and the decrease of the
    /// criterion, when the shifted modes were last updated.
    all_modes: usize,
    gain: f64,
    rounds: usize,
}

/// Shifted modes by one grouping of the poles.
#[derive(Default)]
struct Grouping {
    shifted: Vec<ShiftedMode>,
    /// Number of modes of all groups, unshifted ones included.
    modes: usize,
    /// Decrease of the criterion by the shifted modes.
    gain: f64,
}

/// A run whose frequency of a mode is outlying.
pub(in crate::identify) struct OutlyingRun {
    /// Index of its FRF with the largest residue.
    pub function: usize,
    /// Frequency of the mode, rad/s.
    pub omega: f64,
    /// Shift and limit, over the frequency.
    pub shift: f64,
    pub limit: f64,
}

impl RunShifts {
    /// Runs of the FRFs, without shifted modes.
    pub fn none(functions: &[Function]) -> Self {
        // All directions at one point are one run: bending in two planes is no shift.
        let (_, roving_sensor) = measurement_runs(functions);
        let runs = separate_responses::by_point(functions);
        let frf_matrix = FrfMatrix::new(functions);
        let response = |f: &usize| &functions[*f].response;
        let has_one_axis = |run: &Vec<usize>| run.iter().all(|f| response(f) == response(&run[0]));
        let are_positions = roving_sensor && runs.iter().all(has_one_axis);
        Self {
            positions: if are_positions {
                runs.clone()
            } else {
                Vec::new()
            },
            runs,
            roving_sensor,
            factors: frf_matrix.outputs.len() + frf_matrix.inputs,
            ..Self::default()
        }
    }

    /// Each FRF as a run, without shifted modes; `None` where the runs are single FRFs already, or
    /// no shifts are searched.
    pub fn by_function(&self) -> Option<Self> {
        let functions: usize = self.runs.iter().map(Vec::len).sum();
        let runs: Vec<Vec<usize>> = (0..functions).map(|function| vec![function]).collect();
        let position = |f: usize| self.positions.iter().find(|position| position.contains(&f));
        let positions = (0..functions).filter_map(position).cloned();
        (self.runs.len() < functions && self.rounds < MAX_ROUNDS).then(|| Self {
            runs,
            positions: positions.collect(),
            factors: self.factors,
            ..Self::default()
        })
    }

    /// The same shifts for a fit that does not search them again.
    ///
    /// A fit under another line shape then takes one alignment of the runs rather than all: where
    /// frequencies shift between hits, these took most of the time.
    pub fn as_found(&self) -> Self {
        Self {
            rounds: MAX_ROUNDS,
            ..self.clone()
        }
    }

    /// Aligns every FRF to the mean of the runs.
    pub fn align_runs(&self, data: &mut FitData) {
        if self.modes.is_empty() {
            return;
        }
        for (run, functions) in self.runs.iter().enumerate() {
            for f in functions {
                let line_shape = data.frfs.line_shape;
                data.correct(*f, |omega| {
                    let correction =
                        |mode: &ShiftedMode| mode.correction(line_shape, *f, run, omega);
                    self.modes.iter().map(correction).sum()
                });
            }
        }
    }

    /// Updates the shifted modes from a fit of the FRFs as aligned now. Returns whether anything
    /// changed.
    pub fn update_from_fit(&mut self, data: &FitData, model_poles: &[ModelPole]) -> bool {
        if self.rounds == MAX_ROUNDS || self.runs.len() < MIN_RUNS {
            return false;
        }
        self.rounds += 1;
        let best = self.best_grouping(data, model_poles);
        let now = Self {
            modes: best.shifted,
            all_modes: best.modes,
            gain: best.gain,
            ..self.clone()
        };
        let changed = !now.agrees_with(self);
        *self = now;
        changed
    }

    /// Whether others are of the same runs, with the same modes and with shifts that are equal to
    /// within the convergence limit of these.
    pub fn agrees_with(&self, other: &Self) -> bool {
        let same = |(now, before): (&ShiftedMode, &ShiftedMode)| now.is_converged(before);
        self.runs == other.runs
            && self.modes.len() == other.modes.len()
            && self.modes.iter().zip(&other.modes).all(same)
    }

    /// Whether these shifts leave fewer modes than others, or as many with a larger gain.
    pub fn is_better_than(&self, other: &Self) -> bool {
        self.all_modes < other.all_modes
            || self.all_modes == other.all_modes && self.gain > other.gain
    }

    /// Whether any mode shifts between runs.
    pub fn any(&self) -> bool {
        !self.modes.is_empty()
    }

    /// Whether a pole lies in the resonance of a shifted mode.
    pub fn contains_pole(&self, lambda: Complex64) -> bool {
        self.modes.iter().any(|mode| mode.contains_pole(lambda))
    }

    /// The shifted mode of a pole.
    pub fn of(&self, lambda: Complex64) -> Option<&ShiftedMode> {
        let distance = |mode: &&ShiftedMode| (mode.lambda.im - lambda.im).abs();
        let nearest = self
            .modes
            .iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        nearest.contains_pole(lambda).then_some(nearest)
    }

    /// Runs of the FRFs, by their numbers in the set.
    pub fn runs(&self) -> &[Vec<usize>] {
        &self.runs
    }

    /// Corrected shift of each run in the resonance of a pole, rad/s.
    pub fn shifts_of(&self, lambda: Complex64) -> Option<&[Complex64]> {
        self.of(lambda).map(|mode| mode.shifts.as_slice())
    }

    /// A mode at its mean over the runs, with the standard deviation of that mean; its damping has
    /// that of the mean frequency and of the decay rate common to all runs.
    /// `band_deviation`: standard deviation of the pole by narrower bands, rad/s.
    pub fn merged(&self, mode: Candidate, mean: Option<RunMean>, band_deviation: f64) -> Candidate {
        let lambda = mode.pole.lambda;
        let decay_std = self.of(lambda).map_or(0.0, |moving| moving.decay_std);
        let decay_std = mean.map_or(decay_std, |mean| decay_std.max(mean.decay_std));
        let damping_std = decay_std * lambda.im / lambda.norm_sqr();
        let damping_std = mode.damping_std.map(|std| std.max(damping_std));
        let Some(RunMean { shift, std, .. }) = mean else {
            return Candidate {
                damping_std,
                ..mode
            };
        };
        let pole = Pole {
            lambda: lambda + Complex64::new(0.0, shift),
        };
        // The damping ratio is the decay rate over the mean frequency.
        let by_frequency = pole.damping_ratio() * std / lambda.norm();
        Candidate {
            pole,
            frequency_std_hz: Some(std.hypot(band_deviation) / TAU),
            frequency_damping_correlation: None,
            damping_std: damping_std.map(|std| std.hypot(by_frequency)),
            ..mode
        }
    }

    /// The outlying run farthest from the mean of a mode, in half-power bandwidths.
    pub fn outlying_run(&self) -> Option<OutlyingRun> {
        let widths =
            |(mode, run): &(&ShiftedMode, usize)| mode.shifts[*run].im.abs() / mode.lambda.re.abs();
        let all = self
            .modes
            .iter()
            .flat_map(|mode| (0..self.runs.len()).map(move |run| (mode, run)));
        let away = |(mode, run): &(&ShiftedMode, usize)| {
            mode.shifts[*run].im.abs() > OUTLYING_STDS * mode.stds[*run]
        };
        let (mode, run) = all
            .filter(away)
            .max_by(|a, b| widths(a).total_cmp(&widths(b)))?;
        let size = |f: &&usize| mode.residues[**f].norm_sqr();
        let function = *self.runs[run]
            .iter()
            .max_by(|a, b| size(a).total_cmp(&size(b)))?;
        Some(OutlyingRun {
            function,
            omega: mode.lambda.im,
            shift: mode.shifts[run].im / mode.lambda.im,
            limit: OUTLYING_STDS * mode.stds[run] / mode.lambda.im,
        })
    }

    /// Shifted modes by the grouping of poles with the fewest modes, and of several such groupings
    /// the one with the largest gain.
    fn best_grouping(&self, data: &FitData, model_poles: &[ModelPole]) -> Grouping {
        let mut groupings: Vec<Vec<Vec<usize>>> = GROUP_BANDWIDTHS_AND_FRACTIONS
            .map(|(bandwidths, fraction)| groups(model_poles, bandwidths, fraction))
            .into();
        groupings.dedup();
        let alternatives = groupings.into_iter();
        let alternatives =
            alternatives.map(|groups| self.modes_of_grouping(groups, data, model_poles));
        let better =
            |a: &Grouping, b: &Grouping| b.modes < a.modes || b.modes == a.modes && b.gain > a.gain;
        let best = alternatives.reduce(|a, b| if better(&a, &b) { b } else { a });
        let mut best = best.unwrap_or_default();
        sort_ascending_by(&mut best.shifted, |pole| pole.lambda.im);
        best
    }

    /// Shifted modes by one grouping of the poles, and the gain of the criterion: none unless half
    /// of the decidable resonances shift, and one cause explains the shifts.
    fn modes_of_grouping(
        &self,
        groups: Vec<Vec<usize>>,
        data: &FitData,
        model_poles: &[ModelPole],
    ) -> Grouping {
        let group_modes: Vec<Vec<&ShiftedMode>> = self.modes_by_group(&groups, model_poles);
        let resonance =
            |group: &Vec<usize>| Resonance::new(data, model_poles, group, &self.runs, &self.modes);
        let resonances: Vec<Option<Resonance>> = groups.par_iter().map(resonance).collect();
        let screen = |(modes, resonance): (&Vec<&ShiftedMode>, &Option<Resonance>)| match resonance
        {
            _ if !modes.is_empty() => Screening::Candidate,
            Some(resonance) => resonance.screen(&self.runs),
            None => Screening::Undecided,
        };
        let screenings = group_modes.par_iter().zip(&resonances);
        let screenings: Vec<Screening> = screenings.map(screen).collect();
        if !screenings.contains(&Screening::Candidate) {
            return Grouping {
                shifted: self.modes.clone(),
                modes: model_poles.len(),
                gain: 0.0,
            };
        }
        let previous_poles = |group_modes: &Vec<&ShiftedMode>| {
            let poles: Poles = group_modes.iter().map(|mode| mode.poles()).collect();
            (!poles.is_empty()).then_some(poles)
        };
        let mut poles: Vec<Option<Poles>> = group_modes.iter().map(previous_poles).collect();
        let mut fitted: Vec<Option<Fitted>> = Vec::new();
        for _ in 0..MAX_SWEEPS {
            let fit = |index: usize| {
                let resonance = resonances[index].as_ref();
                let resonance = resonance.filter(|_| screenings[index] == Screening::Candidate)?;
                let other_poles =
                    |run| poles_of_other_groups(model_poles, &groups, &poles, index, run);
                let one = |only: usize| vec![vec![model_poles[only].lambda; self.runs.len()]];
                match (&poles[index], &groups[index][..]) {
                    (Some(poles), _) => {
                        resonance.fit_poles(&resonance.runs(&self.runs, other_poles), poles.clone())
                    }
                    (None, [only]) => {
                        resonance.fit_poles(&resonance.runs(&self.runs, other_poles), one(*only))
                    }
                    (None, _) => resonance.search_poles(&self.runs, other_poles),
                }
            };
            fitted = (0..groups.len()).into_par_iter().map(fit).collect();
            let moved =
                |(shifted, group_modes): (&Option<Fitted>, &Vec<&ShiftedMode>)| match shifted {
                    Some(shifted) => Some(
                        shifted
                            .tracks
                            .iter()
                            .map(|track| track.poles.clone())
                            .collect(),
                    ),
                    None => previous_poles(group_modes),
                };
            poles = fitted.iter().zip(&group_modes).map(moved).collect();
        }
        // Decisions of the resonances with enough runs.
        let judge = |index: usize| match (&resonances[index], screenings[index]) {
            (_, Screening::Undecided) => None,
            (_, Screening::Unshifted) => Some(Vec::new()),
            (Some(resonance), Screening::Candidate) => resonance.decide(
                fitted[index].as_ref(),
                &self.runs,
                self.factors,
                &group_modes[index],
                index,
            ),
            (None, Screening::Candidate) => {
                ShiftDecision::from_known_modes(group_modes[index].iter().copied(), index)
            }
        };
        let decisions: Vec<Option<Vec<ShiftDecision>>> = (0..groups.len()).map(judge).collect();
        let all: Vec<&ShiftDecision> = decisions.iter().flatten().flatten().collect();
        let is_inconclusive = all
            .iter()
            .all(|decision| decision.group == all[0].group && !decision.is_conclusive);
        let decided = decisions.iter().flatten().count();
        let agreeing = match is_inconclusive {
            true => Vec::new(),
            false => self.modes_with_common_cause(all.clone()),
        };
        let agreeing = match independently_shifted(&all, decided) {
            Some(modes) if modes.len() > agreeing.len() => modes,
            _ => agreeing,
        };
        let is_shifted = |accepted: &[&ShiftDecision], index: usize| {
            accepted.iter().any(|decision| decision.group == index)
        };
        let indices = 0..groups.len();
        let agree = indices
            .filter(|index| is_shifted(&agreeing, *index))
            .count();
        let accepted = match agree > 0 && 2 * agree >= decided {
            true => agreeing,
            // Modes that were shifted before do not depend on further candidates.
            false => self.modes_with_common_cause(
                all.into_iter()
                    .filter(|decision| decision.was_shifted)
                    .collect(),
            ),
        };
        let unshifted = (0..groups.len()).filter(|index| !is_shifted(&accepted, *index));
        let unshifted: usize = unshifted.map(|index| groups[index].len()).sum();
        Grouping {
            modes: unshifted + accepted.len(),
            gain: accepted.iter().map(|decision| decision.gain).sum(),
            shifted: accepted
                .iter()
                .map(|decision| decision.mode.clone())
                .collect(),
        }
    }

    /// Previous shifted modes of each group: those to which one of its poles is nearest.
    fn modes_by_group(
        &self,
        groups: &[Vec<usize>],
        model_poles: &[ModelPole],
    ) -> Vec<Vec<&ShiftedMode>> {
        let mut group_modes = vec![Vec::new(); groups.len()];
        for mode in &self.modes {
            let near = |j: &usize| (model_poles[*j].lambda.im - mode.lambda.im).abs();
            let distance = |index: &usize| {
                let distances = groups[*index].iter().map(near);
                distances.fold(f64::INFINITY, f64::min)
            };
            let nearest = (0..groups.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
            let within = |index: &usize| {
                groups[*index]
                    .iter()
                    .any(|j| mode.contains_pole(model_poles[*j].lambda))
            };
            if let Some(index) = nearest.filter(within) {
                group_modes[index].push(mode);
            }
        }
        group_modes
    }

    /// Modes whose shifts have one cause: a structure that changes between runs shifts all modes
    /// together, and the mass of a sensor lowers the frequency of a mode in proportion to the
    /// squared motion of its point. Pairs of close modes, which look like one shifted mode, do
    /// neither.
    fn modes_with_common_cause<'a>(
        &self,
        decisions: Vec<&'a ShiftDecision>,
    ) -> Vec<&'a ShiftDecision> {
        let together = explained_by_one_cause(decisions.clone(), mean_correlation);
        if !self.roving_sensor {
            return together;
        }
        let by_mass = explained_by_one_cause(decisions, |decisions| {
            let fractions = decisions
                .iter()
                .map(|decision| explained_by_mass(&decision.mode, &self.runs));
            fractions.collect()
        });
        let gain = |decisions: &[&ShiftDecision]| {
            decisions.iter().map(|decision| decision.gain).sum::<f64>()
        };
        match (together.len(), gain(&together)) < (by_mass.len(), gain(&by_mass)) {
            true => by_mass,
            false => together,
        }
    }
}

/// Modes that shift without a common cause (a joint that settles, a support that is moved): those
/// that are conclusive without others, where they are nearly all decided resonances. Pairs of close
/// modes are few.
fn independently_shifted<'a>(
    decisions: &[&'a ShiftDecision],
    decided: usize,
) -> Option<Vec<&'a ShiftDecision>> {
    let conclusive = decisions.iter().filter(|decision| decision.is_conclusive);
    let modes: Vec<&ShiftDecision> = conclusive.copied().collect();
    let mut groups: Vec<usize> = modes.iter().map(|decision| decision.group).collect();
    groups.sort_unstable();
    groups.dedup();
    let fraction = groups.len() as f64 / decided.max(1) as f64;
    (groups.len() >= MIN_INDEPENDENT_MODES && fraction >= MIN_INDEPENDENT_FRACTION).then_some(modes)
}

/// Modes of whose total scatter one cause explains the minimum fraction; groups with the least
/// explained scatter are removed.
fn explained_by_one_cause(
    mut decisions: Vec<&ShiftDecision>,
    explained: impl Fn(&[&ShiftDecision]) -> Vec<f64>,
) -> Vec<&ShiftDecision> {
    while !decisions.is_empty() {
        let fractions = explained(&decisions);
        if fractions.iter().sum::<f64>() > MIN_EXPLAINED_FRACTION * fractions.len() as f64 {
            break;
        }
        let weakest = (0..fractions.len()).min_by(|a, b| fractions[*a].total_cmp(&fractions[*b]));
        let group = decisions[weakest.unwrap_or(0)].group;
        decisions.retain(|decision| decision.group != group);
    }
    decisions
}

/// Mean correlation of the shifts of each mode with those of other resonances; 0 where there are
/// none.
fn mean_correlation(decisions: &[&ShiftDecision]) -> Vec<f64> {
    // Vectors of length 1, or 0 for an unshifted mode.
    let direction = |decision: &&ShiftDecision| -> Vec<f64> {
        let shift = |run: usize| {
            let (shift, squares) = decision.mode.centred_shift(run);
            if squares > 0.0 {
                shift / squares.sqrt()
            } else {
                0.0
            }
        };
        (0..decision.mode.shifts.len()).map(shift).collect()
    };
    let directions: Vec<Vec<f64>> = decisions.iter().map(direction).collect();
    let mean = |index: usize| {
        let others =
            (0..decisions.len()).filter(|other| decisions[*other].group != decisions[index].group);
        let product = |other: usize| -> f64 {
            let pairs = directions[index].iter().zip(&directions[other]);
            pairs.map(|(a, b)| a * b).sum()
        };
        let products: Vec<f64> = others.map(product).collect();
        products.iter().sum::<f64>() / products.len().max(1) as f64
    };
    (0..decisions.len()).map(mean).collect()
}

/// Fraction of the scatter of a mode that shifts `d = −b |A|²` with b > 0 explain, with the
/// residues A of the run.
fn explained_by_mass(mode: &ShiftedMode, runs: &[Vec<usize>]) -> f64 {
    let power = |run: &Vec<usize>| {
        let squares = run.iter().map(|f| mode.residues[*f].norm_sqr());
        squares.sum::<f64>() / run.len().max(1) as f64
    };
    let powers: Vec<f64> = runs.iter().map(power).collect();
    let mean = powers.iter().sum::<f64>() / powers.len() as f64;
    let (mut cross, mut square, mut all) = (0.0, 0.0, 0.0);
    for (run, power) in powers.iter().enumerate() {
        let (shift, squares) = mode.centred_shift(run);
        cross -= shift * (power - mean);
        square += (power - mean).powi(2);
        all = squares;
    }
    if cross > 0.0 && square * all > 0.0 {
        cross * cross / (square * all)
    } else {
        0.0
    }
}

/// Groups of the poles around each strong one, within a number of half-power bandwidths or a
/// fraction of the frequency, the strong one first.
fn groups(model_poles: &[ModelPole], bandwidths: f64, fraction: f64) -> Vec<Vec<usize>> {
    let strength = |j: &usize| model_poles[*j].quality.significance();
    let mut order: Vec<usize> = (0..model_poles.len()).collect();
    sort_descending_by(&mut order, strength);
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for j in order {
        let same = |group: &&mut Vec<usize>| {
            let strong = &model_poles[group[0]];
            let reach = (bandwidths * strong.width()).max(fraction * strong.lambda.im);
            (model_poles[j].lambda.im - strong.lambda.im).abs() < reach
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.push(j),
            None => groups.push(vec![j]),
        }
    }
    groups
}

/// Poles of the other groups in a run: shifted where that is estimated, else the poles of the fit.
fn poles_of_other_groups(
    model_poles: &[ModelPole],
    groups: &[Vec<usize>],
    shifted: &[Option<Poles>],
    excluded: usize,
    run: usize,
) -> Vec<Complex64> {
    let others = (0..groups.len()).filter(|group| *group != excluded);
    let poles = |index: usize| -> Vec<Complex64> {
        match &shifted[index] {
            Some(poles) => poles.iter().map(|poles| poles[run]).collect(),
            None => groups[index]
                .iter()
                .map(|j| model_poles[*j].lambda)
                .collect(),
        }
    };
    others.flat_map(poles).collect()
}

#[cfg(test)]
mod halves_tests;
#[cfg(test)]
mod merged_tests;
#[cfg(test)]
mod tests;
