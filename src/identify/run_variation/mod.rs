//! Poles that move from run to run: by the mass of a roving sensor, or because the structure
//! changed while it was measured.
//!
//! Fitted with one frequency for all runs, such a mode leaves over what two close modes would
//! leave, and further roots describe it down to the noise. Here every run has a pole of its own,
//!
//! ```text
//! H_f = A_f/(iω − λ − (κ + i) δ_r) + …      f in run r,
//! ```
//!
//! or two of them where two modes are close, its decay rate on one straight line over its frequency
//! for all runs. These are held against the roots that the fit has there by the Bayesian
//! information criterion; how many of the roots stand for one mode is not known before, and that
//! grouping of them counts which leaves the fewest modes. Where runs win, each function is brought
//! to their mean: the difference of both courses is added to it, and all that follows sees one
//! pole. The runs are merged as samples of one mode: the mean weights each by its own variance and
//! the scatter between runs (Paule and Mandel 1982, Journal of Research of the NBS 87), and so much
//! of a run's shift is believed as its variance leaves beside that scatter.

use std::f64::consts::TAU;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::frf::{Function, runs};

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::frf_matrix::Sides;
use crate::identify::data::line_shape::LineShape;
use crate::identify::data::model_pole::Root;
use crate::identify::estimator::Candidate;

mod model_selection;
mod pole_shift;
mod resonance;
mod run_fit;
pub(in crate::identify) mod separate_responses;

use pole_shift::{Fitted, Poles};
use resonance::{FirstLook, MOST_PART, Resonance, Told};

/// A root within so many half-power widths of where a mode is may be its own.
const SAME: f64 = 1.0;
/// Roots within so many half-power widths, or such a part of the frequency, of a strong one may
/// stand for the same mode or for two that move together.
const REACHES: [(f64, f64); 3] = [(SAME, 0.0), (2.5, 0.0), (2.5, MOST_PART)];
/// Times that the runs are brought together, at most.
const ROUNDS: usize = 3;
/// A pole that moved by less than this part of the scatter stays.
const SETTLED: f64 = 0.01;
/// Times that every resonance is fitted, the later ones beside the others as they move.
const SWEEPS: usize = 3;
/// Runs at which a common course can be told from chance.
const FEWEST_RUNS: usize = 4;
/// Part of the scatter of all modes that one cause must explain.
const ONE_CAUSE: f64 = 0.8;
/// Deviations by which a run is away from the mean of all.
const AWAY: f64 = 5.0;

/// How the functions fall into runs, and the modes that are known to move from one to another.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::identify) struct Moved {
    runs: Vec<Vec<usize>>,
    /// Whether a run is a position of a sensor, not a hit point.
    roving_sensor: bool,
    /// Degrees of freedom of shapes and of participation factors.
    factors: usize,
    modes: Vec<Moving>,
    rounds: usize,
}

/// One mode with a pole of its own in every run.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct Moving {
    /// Mean of the runs, rad/s.
    pub lambda: Complex64,
    /// Standard deviation of the frequency between runs, rad/s.
    pub scatter: f64,
    /// Standard deviation of the decay rate at the mean, rad/s.
    pub decay_std: f64,
    /// Pole of each run less the mean, rad/s, as far as it is believed.
    shifts: Vec<Complex64>,
    /// Standard deviation of the frequency of each run by its noise, rad/s.
    stds: Vec<f64>,
    /// Residue of each function, m/(N s).
    residues: Vec<Complex64>,
}

/// The modes that move by one grouping of the roots.
struct Way {
    moving: Vec<Moving>,
    /// Modes of all groups, those of roots that do not move among them.
    left: usize,
    /// By how much the criterion speaks for those that move.
    gain: f64,
}

/// A run that is away from the others.
pub(in crate::identify) struct Away {
    /// Its function with the largest residue.
    pub function: usize,
    /// Shift and limit, over the frequency.
    pub shift: f64,
    pub limit: f64,
}

impl Moved {
    /// Before anything is known.
    pub fn none(functions: &[Function]) -> Self {
        let (runs, roving_sensor) = runs(functions);
        let sides = Sides::new(functions);
        Self {
            runs,
            roving_sensor,
            factors: sides.outputs.len() + sides.inputs,
            ..Self::default()
        }
    }

    /// Brings every function to the mean of the runs.
    pub fn straighten(&self, data: &mut Receptances) {
        if self.modes.is_empty() {
            return;
        }
        for (run, functions) in self.runs.iter().enumerate() {
            for f in functions {
                let line_shape = data.line_shape;
                data.correct(*f, |omega| {
                    let correction = |mode: &Moving| mode.correction(line_shape, (*f, run), omega);
                    self.modes.iter().map(correction).sum()
                });
            }
        }
    }

    /// Takes in what a fit of the functions as they are now brought together tells; whether that
    /// changed anything.
    pub fn told_by(&mut self, data: &Receptances, roots: &[Root]) -> bool {
        if self.rounds == ROUNDS || self.runs.len() < FEWEST_RUNS {
            return false;
        }
        self.rounds += 1;
        let modes = self.moving(data, roots);
        let same = |(now, before): (&Moving, &Moving)| now.stays(before);
        let changed = modes.len() != self.modes.len() || !modes.iter().zip(&self.modes).all(same);
        self.modes = modes;
        changed
    }

    /// Whether runs disagree.
    pub fn any(&self) -> bool {
        !self.modes.is_empty()
    }

    /// Whether a pole lies in the resonance of a mode that moves.
    pub fn holds(&self, lambda: Complex64) -> bool {
        self.modes.iter().any(|mode| mode.holds(lambda))
    }

    /// The mode of a pole that moves.
    pub fn of(&self, lambda: Complex64) -> Option<&Moving> {
        let distance = |mode: &&Moving| (mode.lambda.im - lambda.im).abs();
        let nearest = self
            .modes
            .iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        nearest.holds(lambda).then_some(nearest)
    }

    /// A mode with the deviations that the merging of runs adds: of the frequency that between
    /// runs, of damping at least that of the decay rate that all runs share. One that was not
    /// merged beside others that were, and that the model misses, may move as much as they do.
    pub fn merged(&self, mode: Candidate, missed: bool) -> Candidate {
        let lambda = mode.pole.lambda;
        let Some(moving) = self.of(lambda) else {
            let usual = if missed { self.usual_scatter() } else { 0.0 };
            let std = mode.frequency_std_hz;
            return Candidate {
                frequency_std_hz: std.map(|std| std.hypot(usual * lambda.norm() / TAU)),
                ..mode
            };
        };
        let damping = moving.decay_std * lambda.im / lambda.norm_sqr();
        Candidate {
            frequency_std_hz: mode
                .frequency_std_hz
                .map(|std| std.hypot(moving.scatter / TAU)),
            damping_std: mode.damping_std.map(|std| std.max(damping)),
            ..mode
        }
    }

    /// Median of the scatter of those that move over their frequencies; 0 where none does.
    fn usual_scatter(&self) -> f64 {
        let ratios = self.modes.iter().map(|mode| mode.scatter / mode.lambda.im);
        let mut parts: Vec<f64> = ratios.collect();
        parts.sort_by(f64::total_cmp);
        parts.get(parts.len() / 2).copied().unwrap_or(0.0)
    }

    /// The run that is farthest from the mean of a mode, in half-power widths.
    pub fn farthest(&self) -> Option<Away> {
        let widths =
            |(mode, run): &(&Moving, usize)| mode.shifts[*run].im.abs() / mode.lambda.re.abs();
        let all = self
            .modes
            .iter()
            .flat_map(|mode| (0..self.runs.len()).map(move |run| (mode, run)));
        let away =
            |(mode, run): &(&Moving, usize)| mode.shifts[*run].im.abs() > AWAY * mode.stds[*run];
        let (mode, run) = all
            .filter(away)
            .max_by(|a, b| widths(a).total_cmp(&widths(b)))?;
        let size = |f: &&usize| mode.residues[**f].norm_sqr();
        let function = *self.runs[run]
            .iter()
            .max_by(|a, b| size(a).total_cmp(&size(b)))?;
        Some(Away {
            function,
            shift: mode.shifts[run].im / mode.lambda.im,
            limit: AWAY * mode.stds[run] / mode.lambda.im,
        })
    }

    /// The modes that move, as far as runs are known to disagree, by that grouping of roots which
    /// leaves the fewest modes, and of several that for which most speaks.
    fn moving(&self, data: &Receptances, roots: &[Root]) -> Vec<Moving> {
        let mut groupings: Vec<Vec<Vec<usize>>> = REACHES.map(|reach| groups(roots, reach)).into();
        groupings.dedup();
        let ways = groupings.into_iter();
        let ways = ways.map(|groups| self.moving_by(groups, data, roots));
        let better = |a: &Way, b: &Way| b.left < a.left || b.left == a.left && b.gain > a.gain;
        let best = ways.reduce(|a, b| if better(&a, &b) { b } else { a });
        let mut moving = best.map_or_else(Vec::new, |way| way.moving);
        moving.sort_by(|a, b| a.lambda.im.total_cmp(&b.lambda.im));
        moving
    }

    /// The modes that move, by one grouping of the roots, and how much speaks for them: where half
    /// of the resonances that could tell it say so, and what moves them has one cause.
    fn moving_by(&self, groups: Vec<Vec<usize>>, data: &Receptances, roots: &[Root]) -> Way {
        let group_modes: Vec<Vec<&Moving>> = self.owned(&groups, roots);
        let resonance = |group: &Vec<usize>| Resonance::new(data, (roots, group), self);
        let resonances: Vec<Option<Resonance>> = groups.par_iter().map(resonance).collect();
        let look = |(modes, resonance): (&Vec<&Moving>, &Option<Resonance>)| match resonance {
            _ if !modes.is_empty() => FirstLook::Worthwhile,
            Some(resonance) => resonance.first_look(&self.runs),
            None => FirstLook::Unclear,
        };
        let looks = group_modes.par_iter().zip(&resonances);
        let looks: Vec<FirstLook> = looks.map(look).collect();
        if !looks.contains(&FirstLook::Worthwhile) {
            return Way {
                moving: self.modes.clone(),
                left: roots.len(),
                gain: 0.0,
            };
        }
        let known = |group_modes: &Vec<&Moving>| {
            let poles: Poles = group_modes.iter().map(|mode| mode.poles()).collect();
            (!poles.is_empty()).then_some(poles)
        };
        let mut poles: Vec<Option<Poles>> = group_modes.iter().map(known).collect();
        let mut fitted: Vec<Option<Fitted>> = Vec::new();
        for _ in 0..SWEEPS {
            let fit = |index: usize| {
                let resonance = resonances[index].as_ref();
                let resonance = resonance.filter(|_| looks[index] == FirstLook::Worthwhile)?;
                let beside = |run| poles_beside(roots, (&groups, &poles), (index, run));
                let one = |root: usize| vec![vec![roots[root].lambda; self.runs.len()]];
                match (&poles[index], &groups[index][..]) {
                    (Some(poles), _) => {
                        resonance.fitted(&resonance.runs(&self.runs, beside), poles.clone())
                    }
                    (None, [root]) => {
                        resonance.fitted(&resonance.runs(&self.runs, beside), one(*root))
                    }
                    (None, _) => resonance.searched(&self.runs, beside),
                }
            };
            fitted = (0..groups.len()).into_par_iter().map(fit).collect();
            let moved = |(shifted, group_modes): (&Option<Fitted>, &Vec<&Moving>)| match shifted {
                Some(shifted) => Some(
                    shifted
                        .tracks
                        .iter()
                        .map(|track| track.poles.clone())
                        .collect(),
                ),
                None => known(group_modes),
            };
            poles = fitted.iter().zip(&group_modes).map(moved).collect();
        }
        // Of those that could tell it, what they tell.
        let judge = |index: usize| match (&resonances[index], looks[index]) {
            (_, FirstLook::Unclear) => None,
            (_, FirstLook::Still) => Some(Vec::new()),
            (Some(resonance), FirstLook::Worthwhile) => resonance.judged(
                fitted[index].as_ref(),
                (&self.runs, self.factors),
                (&group_modes[index], index),
            ),
            (None, FirstLook::Worthwhile) => {
                Told::as_known(group_modes[index].iter().copied(), index)
            }
        };
        let decisions: Vec<Option<Vec<Told>>> = (0..groups.len()).map(judge).collect();
        let all: Vec<&Told> = decisions.iter().flatten().flatten().collect();
        let doubt = all
            .iter()
            .all(|decision| decision.group == all[0].group && !decision.alone);
        let agreeing = self.agreeing(if doubt { Vec::new() } else { all.clone() });
        let moves =
            |taken: &[&Told], index: usize| taken.iter().any(|decision| decision.group == index);
        let indices = 0..groups.len();
        let agree = indices.filter(|index| moves(&agreeing, *index)).count();
        let taken = match agree > 0 && 2 * agree >= decisions.iter().flatten().count() {
            true => agreeing,
            // What is known already does not hang on what more was tried.
            false => self.agreeing(all.into_iter().filter(|decision| decision.known).collect()),
        };
        let stay = (0..groups.len()).filter(|index| !moves(&taken, *index));
        let stay: usize = stay.map(|index| groups[index].len()).sum();
        Way {
            left: stay + taken.len(),
            gain: taken.iter().map(|decision| decision.gain).sum(),
            moving: taken.iter().map(|decision| decision.mode.clone()).collect(),
        }
    }

    /// The known modes of each group: those to which one of its roots is the nearest of all.
    fn owned(&self, groups: &[Vec<usize>], roots: &[Root]) -> Vec<Vec<&Moving>> {
        let mut group_modes = vec![Vec::new(); groups.len()];
        for mode in &self.modes {
            let near = |j: &usize| (roots[*j].lambda.im - mode.lambda.im).abs();
            let distance = |index: &usize| {
                let distances = groups[*index].iter().map(near);
                distances.fold(f64::INFINITY, f64::min)
            };
            let nearest = (0..groups.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
            let within =
                |index: &usize| groups[*index].iter().any(|j| mode.holds(roots[*j].lambda));
            if let Some(index) = nearest.filter(within) {
                group_modes[index].push(mode);
            }
        }
        group_modes
    }

    /// The modes whose shifts have one cause: a state of the structure that changes from run to run
    /// moves all modes together, and the mass of a sensor lowers a mode by so much as its point
    /// moves in it. Pairs of close modes, which look as if one of them moved, do neither.
    fn agreeing<'a>(&self, decisions: Vec<&'a Told>) -> Vec<&'a Told> {
        let together = of_one_cause(decisions.clone(), together);
        if !self.roving_sensor {
            return together;
        }
        let by_mass = of_one_cause(decisions, |decisions| {
            let parts = decisions
                .iter()
                .map(|decision| moved_by_mass(&decision.mode, &self.runs));
            parts.collect()
        });
        let gain =
            |decisions: &[&Told]| decisions.iter().map(|decision| decision.gain).sum::<f64>();
        match (together.len(), gain(&together)) < (by_mass.len(), gain(&by_mass)) {
            true => by_mass,
            false => together,
        }
    }
}

/// Those modes that one cause explains, so much of the scatter of all, without the groups of the
/// least explained ones.
fn of_one_cause(mut decisions: Vec<&Told>, explained: impl Fn(&[&Told]) -> Vec<f64>) -> Vec<&Told> {
    while !decisions.is_empty() {
        let parts = explained(&decisions);
        if parts.iter().sum::<f64>() > ONE_CAUSE * parts.len() as f64 {
            break;
        }
        let least = (0..parts.len()).min_by(|a, b| parts[*a].total_cmp(&parts[*b]));
        let group = decisions[least.unwrap_or(0)].group;
        decisions.retain(|decision| decision.group != group);
    }
    decisions
}

/// Mean correlation of the shifts of each mode with those of other resonances; 0 where there are
/// none.
fn together(decisions: &[&Told]) -> Vec<f64> {
    // Vectors of length 1, or 0 where a mode stays.
    let direction = |decision: &&Told| -> Vec<f64> {
        let shift = |run: usize| {
            let (shift, squares) = decision.mode.centred(run);
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

/// Part of the scatter of a mode that shifts `d = −b |A|²` with b > 0 explain, A the residues of
/// the run.
fn moved_by_mass(mode: &Moving, runs: &[Vec<usize>]) -> f64 {
    let power = |run: &Vec<usize>| {
        let squares = run.iter().map(|f| mode.residues[*f].norm_sqr());
        squares.sum::<f64>() / run.len().max(1) as f64
    };
    let powers: Vec<f64> = runs.iter().map(power).collect();
    let mean = powers.iter().sum::<f64>() / powers.len() as f64;
    let (mut cross, mut square, mut all) = (0.0, 0.0, 0.0);
    for (run, power) in powers.iter().enumerate() {
        let (shift, squares) = mode.centred(run);
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

impl Moving {
    /// Frequency of a run less the mean of all, and the sum of the squares of all.
    fn centred(&self, run: usize) -> (f64, f64) {
        let count = self.shifts.len() as f64;
        let mean = self.shifts.iter().map(|shift| shift.im).sum::<f64>() / count;
        let squares = self
            .shifts
            .iter()
            .map(|shift| (shift.im - mean).powi(2))
            .sum();
        (self.shifts[run].im - mean, squares)
    }

    /// Whether a pole may stand for it.
    fn holds(&self, lambda: Complex64) -> bool {
        (self.lambda.im - lambda.im).abs() < -2.0 * SAME * self.lambda.re
    }

    /// In each run.
    fn poles(&self) -> Vec<Complex64> {
        self.shifts
            .iter()
            .map(|shift| self.lambda + shift)
            .collect()
    }

    /// Whether it is where it was, as far as it matters.
    fn stays(&self, before: &Self) -> bool {
        let near =
            |(now, then): (Complex64, Complex64)| (now - then).norm() <= SETTLED * self.scatter;
        self.poles().into_iter().zip(before.poles()).all(near)
    }

    /// What brings a function of a run from its own pole to the mean, at one frequency, rad/s.
    fn correction(&self, shape: LineShape, (f, run): (usize, usize), omega: f64) -> Complex64 {
        let pole = |lambda: Complex64| shape.pole(omega, lambda);
        let (a, lambda) = (self.residues[f], self.lambda);
        let run_pole = lambda + self.shifts[run];
        a * (pole(lambda) - pole(run_pole))
            + a.conj() * (pole(lambda.conj()) - pole(run_pole.conj()))
    }
}

/// Roots around each strong one within so many half-power widths or such a part of the frequency,
/// the strong one first.
fn groups(roots: &[Root], (widths, part): (f64, f64)) -> Vec<Vec<usize>> {
    let strength = |j: &usize| roots[*j].quality.significance();
    let mut order: Vec<usize> = (0..roots.len()).collect();
    order.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for j in order {
        let same = |group: &&mut Vec<usize>| {
            let strong = &roots[group[0]];
            let reach = (widths * strong.width()).max(part * strong.lambda.im);
            (roots[j].lambda.im - strong.lambda.im).abs() < reach
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.push(j),
            None => groups.push(vec![j]),
        }
    }
    groups
}

/// Poles of the other groups in a run: as that group moves, or its roots where that is not known.
fn poles_beside(
    roots: &[Root],
    (groups, moved): (&[Vec<usize>], &[Option<Poles>]),
    (excluded, run): (usize, usize),
) -> Vec<Complex64> {
    let others = (0..groups.len()).filter(|group| *group != excluded);
    let poles = |index: usize| -> Vec<Complex64> {
        match &moved[index] {
            Some(poles) => poles.iter().map(|poles| poles[run]).collect(),
            None => groups[index].iter().map(|j| roots[*j].lambda).collect(),
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
