//! One resonance of which every run has a pole of its own, and whether that describes the data
//! better than several roots for all runs.

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix, ThinQr};

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::model_pole::Root;
use crate::identify::data::out_of_band_basis::Background;
use crate::identify::data::residual::{courses, residues};
use crate::identify::ml::pole_metrics::lines_around;
use crate::identify::noise::band_profile::Profile;
use crate::identify::run_variation::model_selection::{Criterion, between_runs};
use crate::identify::run_variation::pole_shift::{Fitted, Track};
use crate::identify::run_variation::run_fit::{Run, Step, without};
use crate::identify::run_variation::{Moved, Moving};

/// Half-power widths on either side in which a pole is looked at.
const REACH: f64 = 3.0;
/// Lines on either side, at least: a narrow resonance is told by the lines of its flanks as well.
const SIDE: f64 = 10.0;
/// Largest shift of a run, half-power widths or part of the frequency: the mass of a sensor or a
/// drift moves no mode farther, but two modes look so.
const MOST_SHIFT: f64 = 1.0;
pub(super) const MOST_PART: f64 = 0.02;
/// Least scatter between runs, half-power widths: noise of the force that neighbouring lines share
/// makes as much.
const LEAST_SCATTER: f64 = 0.005;
/// Energy that rounding leaves over.
const ROUNDING: f64 = 1e-14;
/// Deviation of the frequency of a run, half-power widths, up to which the run says whether it
/// moved.
const CLEAR: f64 = 0.1;
/// What a known mode leaves over, over what roots leave or noise, from which on it is not told
/// anew.
const POOR: f64 = 2.0;
/// Part of what the criterion asks for, from which on a single root is looked at.
const ENOUGH: f64 = 0.3;
/// Half-power widths between the outermost roots of a group from which on they lie apart, and the
/// part of half the distance of two within which a run has the pole of one.
const LYING_APART: f64 = 0.8;
const CHOSEN: f64 = 0.05;
/// Runs with the largest response in a resonance of several roots, which are asked first where
/// there are more than twice as many.
const STRONGEST: usize = 6;
/// Step that ends the turns, decay rates.
pub(super) const STILL: f64 = 1e-6;

/// The lines around a strong root and the roots of its group, without what roots farther away
/// explain.
pub(super) struct Resonance<'a> {
    pub(super) data: &'a Receptances,
    pub(super) omega: Vec<f64>,
    pub(super) profile: Profile,
    /// Over the noise, as runs are brought together: lines × functions.
    straight: ComplexMatrix,
    /// The same as measured.
    values: ComplexMatrix,
    /// Of what lies farther away, with a curvature: lines × columns.
    background: ComplexMatrix,
    group: Vec<&'a Root>,
    /// All other roots.
    others: Vec<Complex64>,
}

/// A mode that moves.
pub(super) struct Told {
    pub mode: Moving,
    /// Which group of roots it stands for.
    pub group: usize,
    /// Whether it says so beyond doubt, were it the only one.
    pub alone: bool,
    /// Whether it was known before.
    pub known: bool,
    /// By how much the criterion speaks for it.
    pub gain: f64,
}

impl Told {
    /// What is known already.
    pub fn as_known<'a>(
        known: impl IntoIterator<Item = &'a Moving>,
        group: usize,
    ) -> Option<Vec<Self>> {
        let decision = |mode: &Moving| Self {
            mode: mode.clone(),
            group,
            alone: true,
            known: true,
            gain: 0.0,
        };
        let decisions: Vec<Self> = known.into_iter().map(decision).collect();
        (!decisions.is_empty()).then_some(decisions)
    }
}

/// What one look at a resonance says of its pole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FirstLook {
    /// Too few runs can tell.
    Unclear,
    /// It is the same in all runs.
    Still,
    /// It may move.
    Worthwhile,
}

impl<'a> Resonance<'a> {
    /// `None` where too few lines tell the roots around apart.
    pub fn new(
        data: &'a Receptances,
        (roots, group): (&'a [Root], &[usize]),
        moved: &Moved,
    ) -> Option<Self> {
        let strong = &roots[group[0]];
        let distance = |j: &usize| (roots[*j].lambda.im - strong.lambda.im).abs();
        let farthest = group.iter().map(distance).fold(0.0, f64::max) / strong.width();
        let side = farthest + REACH.max(SIDE * data.step / strong.width());
        let lines = lines_around(data, strong, side);
        let omega = data.omega[lines.clone()].to_vec();
        let near = |lambda: Complex64| beside(&omega, lambda);
        let (roots_near, far): (Vec<Root>, Vec<Root>) =
            roots.iter().cloned().partition(|root| near(root.lambda));
        let background = Background::new(&data.omega, &lines, data.outside());
        let middle = 0.5 * omega.len() as f64;
        let columns = background.columns();
        let background = linalg::complex_matrix(omega.len(), columns + 1, |k, column| {
            if column == columns {
                Complex64::from((k as f64 / middle - 1.0).powi(2))
            } else {
                background.value(column, &omega, k)
            }
        });
        // The background, the pole with its derivative, and as many rows again to tell a misfit.
        if omega.len() < 2 * (roots_near.len() + background.ncols() + 2) {
            return None;
        }
        let profile = Profile::new(data, lines.clone());
        let over = |k: usize, f: usize| profile.course[k] * profile.level[f];
        let explained = courses(data.line_shape, &omega, &far) * residues(&far, data.functions());
        let straight = linalg::complex_matrix(omega.len(), data.functions(), |k, f| {
            let value = data.values[f][lines.start + k] - explained[(k, f)];
            value / over(k, f)
        });
        let modes_near: Vec<&Moving> = (moved.modes.iter())
            .filter(|mode| near(mode.lambda))
            .collect();
        let mut values = straight.clone();
        for (run, functions) in moved.runs.iter().enumerate() {
            for (f, k) in functions
                .iter()
                .flat_map(|f| (0..omega.len()).map(move |k| (*f, k)))
            {
                let corrections = modes_near
                    .iter()
                    .map(|mode| mode.correction(data.line_shape, (f, run), omega[k]));
                values[(k, f)] -= corrections.sum::<Complex64>() / over(k, f);
            }
        }
        let other = |j: &usize| !group.contains(j);
        Some(Self {
            straight,
            values,
            group: group.iter().map(|j| &roots[*j]).collect(),
            others: (0..roots.len())
                .filter(other)
                .map(|j| roots[j].lambda)
                .collect(),
            data,
            omega,
            profile,
            background,
        })
    }

    /// An orthonormal basis of the background and the courses of those poles that are near, over
    /// the course of the noise.
    pub(super) fn basis(&self, poles: &[Complex64]) -> ComplexMatrix {
        let near: Vec<Complex64> = (poles.iter().copied())
            .filter(|lambda| beside(&self.omega, *lambda))
            .collect();
        let columns = near.len() + self.background.ncols();
        let columns = linalg::complex_matrix(self.omega.len(), columns, |k, column| {
            let value = match near.get(column) {
                Some(lambda) => self.data.line_shape.pole(self.omega[k], *lambda) * lambda.re,
                None => self.background[(k, column - near.len())],
            };
            value / self.profile.course[k]
        });
        ThinQr::or_not_a_number(&columns).q
    }

    /// Of the strong root.
    pub fn strong(&self) -> Complex64 {
        self.group[0].lambda
    }

    /// Lowest and highest root, rad/s.
    pub fn span(&self) -> (f64, f64) {
        let frequencies = self.group.iter().map(|root| root.lambda.im);
        frequencies.fold((f64::INFINITY, 0.0), |(lo, hi), at| {
            (at.min(lo), at.max(hi))
        })
    }

    pub fn functions(&self) -> usize {
        self.data.functions()
    }

    /// As measured, over the noise: lines × functions.
    pub fn values(&self) -> &ComplexMatrix {
        &self.values
    }

    /// What one step tells of a pole of its own in every run; where several roots are, a few runs
    /// are tried.
    pub fn first_look(&self, runs: &[Vec<usize>]) -> FirstLook {
        let [root] = self.group[..] else {
            return self.look_at_strongest(runs);
        };
        let functions: Vec<usize> = (0..self.functions()).collect();
        let run = Run::new(self, (&self.straight, &functions), &self.others);
        let look = run.look(&[root.lambda]);
        let run_step = |run: &Vec<usize>| look.steps(run.iter().copied())[0];
        let steps: Vec<Step> = runs.iter().map(run_step).collect();
        let values = (self.omega.len() * functions.len()) as f64;
        let correlation_factor = self.data.shared.of_pole(self.data, root);
        let noise = correlation_factor * (look.without_derivative() / values).min(1.0);
        let variances = steps.iter().map(|step| 0.5 / step.weight);
        if !tells(variances, self.clear(root.decay(), noise)) {
            return FirstLook::Unclear;
        }
        let gained = steps
            .iter()
            .map(|step| step.weight * step.change.im.powi(2));
        let wanted = runs.len() as f64 * (2.0 * values / correlation_factor).ln();
        match 2.0 * gained.sum::<f64>() / noise > ENOUGH * wanted {
            true => FirstLook::Worthwhile,
            false => FirstLook::Still,
        }
    }

    /// Whether the runs with the largest response speak for poles that move.
    fn look_at_strongest(&self, runs: &[Vec<usize>]) -> FirstLook {
        if runs.len() <= 2 * STRONGEST {
            return FirstLook::Worthwhile;
        }
        let power = |run: &Vec<usize>| -> f64 {
            let powers = run.iter().map(|f| self.straight.col(*f).squared_norm_l2());
            powers.sum()
        };
        let mut order: Vec<(f64, &Vec<usize>)> = runs.iter().map(|run| (power(run), run)).collect();
        order.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        let strongest: Vec<Vec<usize>> = (order.into_iter().take(STRONGEST))
            .map(|(_, run)| run.clone())
            .collect();
        let Some(fitted) = self.searched(&strongest, |_| self.others.clone()) else {
            return FirstLook::Still;
        };
        let group_residual_energy = self.group_residual_energy(&strongest);
        let criterion = self.criterion(&strongest, group_residual_energy.min(fitted.left));
        match criterion.of_runs(&fitted)
            < criterion.of_roots(group_residual_energy, self.group.len())
        {
            true => FirstLook::Worthwhile,
            false => FirstLook::Still,
        }
    }

    /// One pole or two in every run, whichever describes them better of those that may be, found
    /// wherever they are.
    pub fn searched(
        &self,
        runs: &[Vec<usize>],
        beside: impl Fn(usize) -> Vec<Complex64>,
    ) -> Option<Fitted> {
        let run_data = self.runs(runs, beside);
        let mut beginnings = self.beginnings(&run_data);
        beginnings.push(vec![vec![self.strong(); runs.len()]]);
        let fits = beginnings.into_iter();
        let fits: Vec<Fitted> = fits
            .filter_map(|poles| self.fitted(&run_data, poles))
            .collect();
        let least = fits
            .iter()
            .map(|fit| fit.left)
            .fold(f64::INFINITY, f64::min);
        let criterion = self.criterion(runs, least);
        let rank = |fit: &Fitted| {
            let modes = self.modes(fit, criterion.noise);
            (
                modes.is_none_or(|modes| modes.is_empty()),
                criterion.of_runs(fit),
            )
        };
        let ranked = fits.into_iter().map(|fit| (rank(&fit), fit));
        let best =
            ranked.min_by(|((a, score), _), ((b, other), _)| a.cmp(b).then(score.total_cmp(other)));
        best.map(|(_, fit)| fit)
    }

    /// The modes of such poles in noise of some variance; `None` where too few runs could tell how
    /// they move, none where they hardly move, or too far, or into another resonance.
    fn modes(&self, fitted: &Fitted, noise: f64) -> Option<Vec<Moving>> {
        let merged = |track: &Track| self.merged(track, noise);
        let modes: Vec<Moving> = fitted.tracks.iter().map(merged).collect();
        let pairs = || fitted.tracks.iter().zip(&modes);
        let most = |mode: &Moving| self.clear(-mode.lambda.re, noise);
        let clear =
            |(track, mode): (&Track, &Moving)| tells(track.variances.iter().copied(), most(mode));
        if !pairs().all(clear) {
            return None;
        }
        let far = |(track, mode): (&Track, &Moving)| {
            let farthest = (MOST_SHIFT * -2.0 * mode.lambda.re).max(MOST_PART * mode.lambda.im);
            let mut shifts = mode.shifts.iter().zip(&track.variances);
            shifts.any(|(shift, v)| *v < most(mode) && shift.im.abs() > farthest)
        };
        let little = |mode: &Moving| mode.scatter < LEAST_SCATTER * -2.0 * mode.lambda.re;
        let astray = |mode: &Moving| !self.owns(mode.lambda);
        let none = modes.iter().all(little) || modes.iter().any(astray) || pairs().any(far);
        Some(if none { Vec::new() } else { modes })
    }

    /// Whether a pole is nearer to a root of the group than to all others.
    fn owns(&self, lambda: Complex64) -> bool {
        let distance = |other: Complex64| (other.im - lambda.im).abs();
        let distances = self.group.iter().map(|root| distance(root.lambda));
        let nearest = distances.fold(f64::INFINITY, f64::min);
        self.others.iter().all(|other| distance(*other) >= nearest)
    }

    /// `Σ|rest|²` of some runs that the roots leave over with residues of their own.
    fn group_residual_energy(&self, runs: &[Vec<usize>]) -> f64 {
        let group_poles = self.group.iter().map(|root| root.lambda);
        let all: Vec<Complex64> = group_poles.chain(self.others.iter().copied()).collect();
        let functions: Vec<usize> = runs.iter().flatten().copied().collect();
        let values = linalg::complex_matrix(self.omega.len(), functions.len(), |k, index| {
            self.straight[(k, functions[index])]
        });
        without(&self.basis(&all), &values).squared_norm_l2()
    }

    /// What the best description of some runs leaves over tells the noise where the data do not
    /// state it.
    fn criterion(&self, runs: &[Vec<usize>], left: f64) -> Criterion {
        let functions = runs.iter().map(Vec::len).sum();
        let values = (self.omega.len() * functions) as f64;
        let correlation_factor = self.data.shared.of_pole(self.data, self.group[0]);
        let rounding = ROUNDING * self.straight.squared_norm_l2();
        let left = left.max(rounding).max(f64::MIN_POSITIVE);
        Criterion {
            noise: correlation_factor * (left / values).min(1.0),
            numbers: 2.0 * values / correlation_factor,
            functions,
            runs: runs.len(),
        }
    }

    /// Variance of a frequency in noise of unit variance up to which a run says whether it moved.
    fn clear(&self, decay: f64, noise: f64) -> f64 {
        (CLEAR * 2.0 * decay).powi(2) / noise
    }

    /// The modes, where their poles move or are `known` to; `None` where too few runs could tell
    /// it.
    pub fn judged(
        &self,
        fitted: Option<&Fitted>,
        (runs, factors): (&[Vec<usize>], usize),
        (known, group): (&[&Moving], usize),
    ) -> Option<Vec<Told>> {
        let as_known = || Told::as_known(known.iter().copied(), group);
        let Some(fitted) = fitted else {
            return as_known();
        };
        let group_residual_energy = self.group_residual_energy(runs);
        let criterion = self.criterion(runs, group_residual_energy.min(fitted.left));
        let modes = match self.modes(fitted, criterion.noise) {
            Some(modes) => modes,
            None if known.is_empty() => return None,
            None => return as_known(),
        };
        if modes.is_empty() {
            return Some(Vec::new());
        }
        let of_runs = criterion.of_runs(fitted);
        let of_roots = criterion.of_roots(group_residual_energy, self.group.len());
        if !known.is_empty() {
            // Brought together each is one root, unless it never was one mode.
            if self.group.len() > known.len() && of_runs >= of_roots {
                return Some(Vec::new());
            }
            let values = (self.omega.len() * self.functions()) as f64;
            return match fitted.left < POOR * group_residual_energy.max(values) {
                true => Told::as_known(&modes, group),
                false => as_known(),
            };
        }
        if of_runs >= of_roots || self.runs_choose_roots(fitted, &modes) {
            return Some(Vec::new());
        }
        // As products of shapes and participation factors.
        let of_group: usize = self.group.iter().map(|root| root.multiplicity()).sum();
        let of_products = criterion.of(self.left_by_roots(), 2 * of_group * factors);
        let gain = (of_roots - of_runs) / modes.len() as f64;
        let decision = |mode: Moving| Told {
            alone: of_runs < of_products,
            known: false,
            mode,
            group,
            gain,
        };
        Some(modes.into_iter().map(decision).collect())
    }

    /// Whether the runs have their poles where the roots are that lie apart: modes that each
    /// respond in some of the runs alone look so, and what moves would have to stop there.
    fn runs_choose_roots(&self, fitted: &Fitted, modes: &[Moving]) -> bool {
        let (lo, hi) = self.span();
        let gap = (hi - lo) / (self.group.len().max(2) - 1) as f64;
        let chosen = |(track, mode): (&Track, &Moving)| {
            let distance = |pole: &Complex64| {
                let roots = self
                    .group
                    .iter()
                    .map(|root| (root.lambda.im - pole.im).abs());
                roots.fold(f64::INFINITY, f64::min)
            };
            let mut distances: Vec<f64> = track.poles.iter().map(distance).collect();
            distances.sort_by(f64::total_cmp);
            let wide = hi - lo > LYING_APART * -2.0 * mode.lambda.re;
            wide && distances[distances.len() / 2] < CHOSEN * 0.5 * gap
        };
        fitted.tracks.iter().zip(modes).any(chosen)
    }

    /// `Σ|rest|²` of the roots of the group as they were fitted, beside others and background
    /// fitted here.
    fn left_by_roots(&self) -> f64 {
        let group_poles: Vec<Root> = self.group.iter().map(|root| (*root).clone()).collect();
        let explained = courses(self.data.line_shape, &self.omega, &group_poles)
            * residues(&group_poles, self.data.functions());
        let Profile { course, level } = &self.profile;
        let (lines, functions) = (self.omega.len(), self.data.functions());
        let rest = linalg::complex_matrix(lines, functions, |k, f| {
            self.straight[(k, f)] - explained[(k, f)] / (course[k] * level[f])
        });
        without(&self.basis(&self.others), &rest).squared_norm_l2()
    }

    /// The runs as samples of one mode, in noise of this variance.
    fn merged(&self, fitted: &Track, noise: f64) -> Moving {
        let variances: Vec<f64> = fitted.variances.iter().map(|v| v * noise).collect();
        let omegas: Vec<f64> = fitted.poles.iter().map(|pole| pole.im).collect();
        let between = between_runs(&omegas, &variances);
        let weight = |v: &f64| 1.0 / (between + v);
        let weights: f64 = variances.iter().map(weight).sum();
        let weighted = fitted.poles.iter().zip(&variances);
        let weighted = weighted.map(|(pole, v)| pole * weight(v));
        let lambda = weighted.sum::<Complex64>() / weights;
        let direction = Complex64::new(fitted.slope, 1.0);
        let believed =
            |(omega, v): (&f64, &f64)| direction * (omega - lambda.im) * between * weight(v);
        let residues = fitted.amplitudes.iter().zip(&self.profile.level);
        let known: f64 = variances.iter().map(|v| v.recip()).sum();
        Moving {
            lambda,
            scatter: between.sqrt(),
            decay_std: known.recip().sqrt(),
            shifts: omegas.iter().zip(&variances).map(believed).collect(),
            stds: variances.iter().map(|v| v.sqrt()).collect(),
            residues: residues.map(|(a, level)| a * level).collect(),
        }
    }
}

/// Whether enough runs know their frequency to this variance.
fn tells(variances: impl ExactSizeIterator<Item = f64>, most: f64) -> bool {
    let runs = variances.len();
    variances.filter(|v| *v < most).count() >= 2.max(runs / 2)
}

/// Whether a pole lies within some lines, or so near that it is more than the background there.
fn beside(omega: &[f64], lambda: Complex64) -> bool {
    let (lo, hi) = (omega[0], omega[omega.len() - 1]);
    let reach = (hi - lo).max(-2.0 * REACH * lambda.re);
    lambda.im > lo - reach && lambda.im < hi + reach
}
