//! Poles that move from run to run: by the mass of a roving sensor, or because the structure changed while it was measured.
//!
//! Fitted with one frequency for all runs, such a mode leaves over what two close modes would leave, and further roots describe it down to
//! the noise. Here every run has a pole of its own,
//!
//! ```text
//! H_f = A_f/(iω − λ − (κ + i) δ_r) + …      f in run r,
//! ```
//!
//! its decay rate on one straight line over its frequency for all runs, and is held against the roots that the fit has there by the
//! Bayesian information criterion. Where it wins, each function is brought to the mean of the runs: the difference of both courses, a
//! small one, is added to it, and all that follows sees one pole. The runs are merged as samples of one mode: the mean weights each by
//! its own variance and the scatter between runs (Paule and Mandel 1982, Journal of Research of the NBS 87), and so much of a run's
//! shift is believed as its variance leaves beside that scatter.

use std::f64::consts::TAU;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::frf::{Function, runs};

use super::Candidate;
use super::far::Rest;
use super::receptance::Receptances;
use super::roots::Root;
use super::sides::Sides;

mod resonance;
mod run;

use resonance::{FirstLook, Fitted, Resonance, Told};

/// Roots within so many half-power widths of a strong one may stand for the same mode.
const SAME: f64 = 1.0;
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
#[derive(Clone, Default)]
pub(super) struct Moved {
    runs: Vec<Vec<usize>>,
    /// Whether a run is a position of a sensor, not a hit point.
    roving_sensor: bool,
    /// Degrees of freedom of shapes and of participation factors.
    factors: usize,
    modes: Vec<Moving>,
    rounds: usize,
}

/// One mode with a pole of its own in every run.
#[derive(Clone, Debug)]
pub(super) struct Moving {
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

/// A run that is away from the others.
pub(super) struct Away {
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
                data.correct(*f, |omega| {
                    let own = |mode: &Moving| mode.correction((*f, run), omega);
                    self.modes.iter().map(own).sum()
                });
            }
        }
    }

    /// Takes in what a fit of the functions as they are now brought together tells; whether that changed anything.
    pub fn told_by(&mut self, data: &Receptances, fit: (&[Root], &Rest)) -> bool {
        if self.rounds == ROUNDS || self.runs.len() < FEWEST_RUNS {
            return false;
        }
        self.rounds += 1;
        let modes = self.moving(data, fit);
        let same = |(now, before): (&Moving, &Moving)| now.stays(before);
        let told = modes.len() != self.modes.len() || !modes.iter().zip(&self.modes).all(same);
        self.modes = modes;
        told
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

    /// A mode with the deviations that the merging of runs adds: of the frequency that between runs, of
    /// damping at least that of the decay rate that all runs share.
    pub fn merged(&self, mode: Candidate) -> Candidate {
        let lambda = mode.pole.lambda;
        let Some(moving) = self.of(lambda) else {
            return mode;
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

    /// The modes that move, as far as runs are known to disagree: where half of the resonances that could tell it say so, and what moves
    /// them has one cause.
    fn moving(&self, data: &Receptances, (roots, rest): (&[Root], &Rest)) -> Vec<Moving> {
        let groups = groups(roots);
        let owners: Vec<Option<&Moving>> = self.owned(&groups, roots);
        let resonance = |group: &Vec<usize>| Resonance::new(data, (roots, group), (rest, self));
        let resonances: Vec<Option<Resonance>> = groups.par_iter().map(resonance).collect();
        let look = |(known, own): (&Option<&Moving>, &Option<Resonance>)| match known {
            Some(_) => FirstLook::Worthwhile,
            None => match own {
                Some(own) => own.first_look(&self.runs),
                None => FirstLook::Unclear,
            },
        };
        let looks: Vec<FirstLook> = owners.iter().zip(&resonances).map(look).collect();
        if !looks.contains(&FirstLook::Worthwhile) {
            return self.modes.clone();
        }
        let start = |known: &Option<&Moving>| known.map(Moving::poles);
        let mut poles: Vec<Option<Vec<Complex64>>> = owners.iter().map(start).collect();
        let mut fitted: Vec<Option<Fitted>> = Vec::new();
        for _ in 0..SWEEPS {
            let fit = |place: usize| {
                let own = resonances[place].as_ref();
                let own = own.filter(|_| looks[place] == FirstLook::Worthwhile)?;
                let beside = |run| poles_beside(roots, (&groups, &poles), (place, run));
                own.fitted(&self.runs, poles[place].clone(), beside)
            };
            fitted = (0..groups.len()).into_par_iter().map(fit).collect();
            let moved = |(own, known): (&Option<Fitted>, &Option<&Moving>)| match own {
                Some(own) => Some(own.poles.clone()),
                None => start(known),
            };
            poles = fitted.iter().zip(&owners).map(moved).collect();
        }
        // Of those that could tell it, what they tell.
        let judge = |place: usize| match (&resonances[place], looks[place]) {
            (_, FirstLook::Unclear) => None,
            (_, FirstLook::Still) => Some(None),
            (Some(own), FirstLook::Worthwhile) => own.judged(
                fitted[place].as_ref(),
                (&self.runs, self.factors),
                owners[place],
            ),
            (None, FirstLook::Worthwhile) => Told::as_known(owners[place]),
        };
        let told: Vec<Option<Told>> = (0..groups.len()).filter_map(judge).collect();
        let clear = told.len();
        let told: Vec<Told> = told.into_iter().flatten().collect();
        let doubt = told.len() == 1 && !told[0].alone;
        let modes =
            |told: &[Told]| -> Vec<Moving> { told.iter().map(|told| told.mode.clone()).collect() };
        let mut moving = modes(&told);
        if doubt || 2 * moving.len() < clear || !self.agree(&moving) {
            // What is known already does not hang on what more was tried.
            let known: Vec<Told> = told.into_iter().filter(|told| told.known).collect();
            moving = modes(&known);
            if !self.agree(&moving) {
                return Vec::new();
            }
        }
        moving.sort_by(|a, b| a.lambda.im.total_cmp(&b.lambda.im));
        moving
    }

    /// The known mode of each group: that of its strong root, where no other group is nearer.
    fn owned(&self, groups: &[Vec<usize>], roots: &[Root]) -> Vec<Option<&Moving>> {
        let mut owners = vec![None; groups.len()];
        for mode in &self.modes {
            let distance =
                |place: &usize| (roots[groups[*place][0]].lambda.im - mode.lambda.im).abs();
            let nearest = (0..groups.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
            let within = |place: &usize| mode.holds(roots[groups[*place][0]].lambda);
            if let Some(place) = nearest.filter(within) {
                owners[place] = Some(mode);
            }
        }
        owners
    }

    /// Whether the shifts of some modes have one cause: a state of the structure that changes from run to run moves all modes together, and
    /// the mass of a sensor lowers a mode by so much as its point moves in it. Pairs of close modes, which look as if one of them moved,
    /// do neither.
    fn agree(&self, modes: &[Moving]) -> bool {
        moved_together(modes) > ONE_CAUSE
            || self.roving_sensor && moved_by_mass(modes, &self.runs) > ONE_CAUSE
    }
}

/// Mean correlation of the shifts of two modes over the runs; 0 for one mode.
fn moved_together(modes: &[Moving]) -> f64 {
    let (runs, count) = (
        modes.first().map_or(0, |mode| mode.shifts.len()),
        modes.len() as f64,
    );
    if modes.len() < 2 {
        return 0.0;
    }
    let sum = |run: usize| {
        let own = modes.iter().map(|mode| mode.centred(run));
        own.map(|(shift, squares)| shift / squares.sqrt())
            .sum::<f64>()
    };
    // The square of the sum of vectors of length 1.
    let square: f64 = (0..runs).map(|run| sum(run).powi(2)).sum();
    (square - count) / (count * (count - 1.0))
}

/// Part of the scatter that shifts `d = −b |A|²` with one b > 0 for each mode explain, A the residues of the run.
fn moved_by_mass(modes: &[Moving], runs: &[Vec<usize>]) -> f64 {
    let explained = |mode: &Moving| {
        let power = |run: &Vec<usize>| {
            let own = run.iter().map(|f| mode.residues[*f].norm_sqr());
            own.sum::<f64>() / run.len().max(1) as f64
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
        if cross > 0.0 {
            cross * cross / (square * all)
        } else {
            0.0
        }
    };
    modes.iter().map(explained).sum::<f64>() / modes.len().max(1) as f64
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
    fn correction(&self, (f, run): (usize, usize), omega: f64) -> Complex64 {
        let (a, lambda) = (self.residues[f], self.lambda);
        let own = lambda + self.shifts[run];
        a * (pole(omega, lambda) - pole(omega, own))
            + a.conj() * (pole(omega, lambda.conj()) - pole(omega, own.conj()))
    }
}

/// Roots around each strong one, the strong one first.
fn groups(roots: &[Root]) -> Vec<Vec<usize>> {
    let strength = |j: &usize| roots[*j].quality.significance();
    let mut order: Vec<usize> = (0..roots.len()).collect();
    order.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for j in order {
        let same = |group: &&mut Vec<usize>| {
            let strong = &roots[group[0]];
            (roots[j].lambda.im - strong.lambda.im).abs() < SAME * strong.width()
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
    (groups, moved): (&[Vec<usize>], &[Option<Vec<Complex64>>]),
    (own, run): (usize, usize),
) -> Vec<Complex64> {
    let others = (0..groups.len()).filter(|place| *place != own);
    let poles = |place: usize| match &moved[place] {
        Some(poles) => vec![poles[run]],
        None => groups[place].iter().map(|j| roots[*j].lambda).collect(),
    };
    others.flat_map(poles).collect()
}

fn pole(omega: f64, lambda: Complex64) -> Complex64 {
    (Complex64::new(0.0, omega) - lambda).inv()
}

#[cfg(test)]
mod tests;
