//! The test whether an individual pole in every run fits a resonance better than several poles
//! common to all runs.

use std::rc::Rc;

use num_complex::Complex64;

use crate::linalg;

use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::residual::{pole_columns, residues};
use crate::identify::noise::band_profile::BandProfile;
use crate::identify::run_variation::model_selection::{Criterion, between_runs};
use crate::identify::run_variation::pole_shift::{Fitted, Track};
use crate::identify::run_variation::resonance::Resonance;
use crate::identify::run_variation::run_fit::{Run, Step, without};
use crate::identify::run_variation::shifted_mode::ShiftedMode;
use crate::linalg::sort_descending_by;

/// Maximum shift of a run, half-power bandwidths or fraction of the frequency.
///
/// A sensor of 1 % of the mass lowers a frequency by `0.005 φ²`, 4.5 % where the point moves three
/// times as far as the root mean square. Larger: more neighbouring modes are tried as one, and 0.1
/// finds no more. Smaller, at 0.02: the run of such a point adds one or two false modes. Test:
/// `a_heavy_roving_sensor_at_a_point_of_large_motion_makes_no_further_mode`.
const MAX_SHIFT_BANDWIDTHS: f64 = 1.0;
pub(super) const MAX_SHIFT_FRACTION: f64 = 0.05;
/// Minimum scatter between runs, half-power bandwidths: force noise that is correlated between
/// lines causes as much.
const MIN_SCATTER_BANDWIDTHS: f64 = 0.005;
/// Residual energy by rounding over the energy of the values.
const ROUND_OFF_ENERGY: f64 = 1e-14;
/// Standard deviation of the frequency of a run, half-power bandwidths, below which the run decides
/// whether the mode shifts.
const MAX_FREQUENCY_STD_BANDWIDTHS: f64 = 0.1;
/// Residual energy with shifted poles over that of common poles or noise, above which the previous
/// shifts are retained.
const MAX_RESIDUAL_RATIO: f64 = 2.0;
/// Fraction of the decrease that the criterion requires, above which a single pole is a candidate
/// for shifts.
const MIN_CRITERION_FRACTION: f64 = 0.3;
/// Minimum distance of the outermost poles of a group, half-power bandwidths, at which they are
/// separate; and the fraction of half the distance of two poles within which a run has the pole of
/// one.
const MIN_GROUP_SPAN_BANDWIDTHS: f64 = 0.8;
const MAX_DISTANCE_FRACTION: f64 = 0.05;
/// Number of runs with the largest response that screen a resonance of several poles, where there
/// are more than twice as many.
const SCREENED_RUNS: usize = 6;

/// Decision that a mode shifts between runs.
pub(super) struct ShiftDecision {
    pub mode: ShiftedMode,
    /// Index of its group of poles.
    pub group: usize,
    /// Whether the evidence suffices without any other mode.
    pub is_conclusive: bool,
    /// Whether the mode was shifted before.
    pub was_shifted: bool,
    /// Decrease of the criterion.
    pub gain: f64,
}

impl ShiftDecision {
    /// Decisions for modes that were shifted before.
    pub fn from_known_modes<'a>(
        modes: impl IntoIterator<Item = &'a ShiftedMode>,
        group: usize,
    ) -> Option<Vec<Self>> {
        let decision = |mode: &ShiftedMode| Self {
            mode: mode.clone(),
            group,
            is_conclusive: true,
            was_shifted: true,
            gain: 0.0,
        };
        let decisions: Vec<Self> = modes.into_iter().map(decision).collect();
        (!decisions.is_empty()).then_some(decisions)
    }
}

/// Result of the screening of a resonance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Screening {
    /// Too few runs decide.
    Undecided,
    /// The pole is the same in all runs.
    Unshifted,
    /// The pole may shift between runs.
    Candidate,
}

impl Resonance<'_> {
    /// Screens the resonance by one Gauss-Newton step of an individual pole in every run; for a
    /// group of several poles, by fits of a few runs.
    pub fn screen(&self, runs: &[Vec<usize>]) -> Screening {
        let [model_pole] = self.group[..] else {
            return self.screen_strongest_runs(runs);
        };
        let functions: Vec<usize> = (0..self.functions()).collect();
        let others = Rc::new(self.basis(&self.others));
        let run = Run::new(self, &self.aligned, &functions, others);
        let fit = run.fit_amplitudes(&[model_pole.lambda]);
        let run_step = |run: &Vec<usize>| fit.steps(run.iter().copied())[0];
        let steps: Vec<Step> = runs.iter().map(run_step).collect();
        let values = (self.omega.len() * functions.len()) as f64;
        let correlation_factor = self
            .data
            .noise
            .pole_noise_factor(&self.data.frfs, model_pole);
        let noise = correlation_factor * (fit.without_derivative() / values).min(1.0);
        let variances = steps.iter().map(|step| 0.5 / step.weight);
        if !has_enough_runs(
            variances,
            self.max_frequency_variance(model_pole.decay(), noise),
        ) {
            return Screening::Undecided;
        }
        let gained = steps
            .iter()
            .map(|step| step.weight * step.change.im.powi(2));
        let wanted = runs.len() as f64 * (2.0 * values / correlation_factor).ln();
        match 2.0 * gained.sum::<f64>() / noise > MIN_CRITERION_FRACTION * wanted {
            true => Screening::Candidate,
            false => Screening::Unshifted,
        }
    }

    /// Screens the resonance by fits of the runs with the largest response.
    fn screen_strongest_runs(&self, runs: &[Vec<usize>]) -> Screening {
        if runs.len() <= 2 * SCREENED_RUNS {
            return Screening::Candidate;
        }
        let power = |run: &Vec<usize>| -> f64 {
            let powers = run.iter().map(|f| self.aligned.col(*f).squared_norm_l2());
            powers.sum()
        };
        let mut order: Vec<(f64, &Vec<usize>)> = runs.iter().map(|run| (power(run), run)).collect();
        sort_descending_by(&mut order, |(power, _)| *power);
        let strongest: Vec<Vec<usize>> = (order.into_iter().take(SCREENED_RUNS))
            .map(|(_, run)| run.clone())
            .collect();
        let Some(fitted) = self.search_poles(&strongest, |_| self.others.clone()) else {
            return Screening::Unshifted;
        };
        let group_residual_energy = self.group_residual_energy(&strongest);
        let criterion = self.criterion(
            &strongest,
            group_residual_energy.min(fitted.residual_energy),
        );
        match criterion.of_runs(&fitted)
            < criterion.of_common_poles(group_residual_energy, self.group.len())
        {
            true => Screening::Candidate,
            false => Screening::Unshifted,
        }
    }

    /// Fits one pole or two in every run from all initial poles, and takes the better fit.
    pub fn search_poles(
        &self,
        runs: &[Vec<usize>],
        other_poles: impl Fn(usize) -> Vec<Complex64>,
    ) -> Option<Fitted> {
        let run_data = self.runs(runs, other_poles);
        let mut initial_poles = self.initial_poles(&run_data);
        initial_poles.push(vec![vec![self.strong(); runs.len()]]);
        let fits = initial_poles.into_iter();
        let fits: Vec<Fitted> = fits
            .filter_map(|poles| self.fit_poles(&run_data, poles))
            .collect();
        let least = fits
            .iter()
            .map(|fit| fit.residual_energy)
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

    /// Modes of the fitted poles in noise of a given variance; `None` where too few runs decide,
    /// empty where the shifts are too small, too large or lead into another resonance.
    fn modes(&self, fitted: &Fitted, noise: f64) -> Option<Vec<ShiftedMode>> {
        let merged = |track: &Track| self.merged(track, noise);
        let modes: Vec<ShiftedMode> = fitted.tracks.iter().map(merged).collect();
        let pairs = || fitted.tracks.iter().zip(&modes);
        let most = |mode: &ShiftedMode| self.max_frequency_variance(-mode.lambda.re, noise);
        let is_determined = |(track, mode): (&Track, &ShiftedMode)| {
            has_enough_runs(track.variances.iter().copied(), most(mode))
        };
        if !pairs().all(is_determined) {
            return None;
        }
        let is_too_large = |(track, mode): (&Track, &ShiftedMode)| {
            let farthest = (MAX_SHIFT_BANDWIDTHS * -2.0 * mode.lambda.re)
                .max(MAX_SHIFT_FRACTION * mode.lambda.im);
            let mut shifts = mode.shifts.iter().zip(&track.variances);
            shifts.any(|(shift, v)| *v < most(mode) && shift.im.abs() > farthest)
        };
        let is_negligible =
            |mode: &ShiftedMode| mode.scatter < MIN_SCATTER_BANDWIDTHS * -2.0 * mode.lambda.re;
        let is_in_other_group = |mode: &ShiftedMode| !self.is_nearest_group(mode.lambda);
        let none = modes.iter().all(is_negligible)
            || modes.iter().any(is_in_other_group)
            || pairs().any(is_too_large);
        Some(if none { Vec::new() } else { modes })
    }

    /// Whether a pole is nearer to a pole of the group than to all others.
    fn is_nearest_group(&self, lambda: Complex64) -> bool {
        let distance = |other: Complex64| (other.im - lambda.im).abs();
        let distances = self
            .group
            .iter()
            .map(|model_pole| distance(model_pole.lambda));
        let nearest = distances.fold(f64::INFINITY, f64::min);
        self.others.iter().all(|other| distance(*other) >= nearest)
    }

    /// Residual energy `Σ|r|²` of some runs with common poles and free residues.
    fn group_residual_energy(&self, runs: &[Vec<usize>]) -> f64 {
        let group_poles = self.group.iter().map(|model_pole| model_pole.lambda);
        let all: Vec<Complex64> = group_poles.chain(self.others.iter().copied()).collect();
        let functions: Vec<usize> = runs.iter().flatten().copied().collect();
        let values = linalg::complex_matrix(self.omega.len(), functions.len(), |k, index| {
            self.aligned[(k, functions[index])]
        });
        without(&self.basis(&all), &values).squared_norm_l2()
    }

    /// Criterion for some runs; the noise variance is estimated from the residual of their best fit
    /// where the data state none.
    fn criterion(&self, runs: &[Vec<usize>], residual_energy: f64) -> Criterion {
        let functions = runs.iter().map(Vec::len).sum();
        let values = (self.omega.len() * functions) as f64;
        let correlation_factor = self
            .data
            .noise
            .pole_noise_factor(&self.data.frfs, self.group[0]);
        let rounding = ROUND_OFF_ENERGY * self.aligned.squared_norm_l2();
        let residual_energy = residual_energy.max(rounding).max(f64::MIN_POSITIVE);
        Criterion {
            noise: correlation_factor * (residual_energy / values).min(1.0),
            numbers: 2.0 * values / correlation_factor,
            functions,
            runs: runs.len(),
        }
    }

    /// Variance of a frequency in noise of unit variance, below which a run decides whether the
    /// mode shifts.
    fn max_frequency_variance(&self, decay: f64, noise: f64) -> f64 {
        (MAX_FREQUENCY_STD_BANDWIDTHS * 2.0 * decay).powi(2) / noise
    }

    /// Decides which modes shift, `previous` ones included; `None` where too few runs decide.
    pub fn decide(
        &self,
        fitted: Option<&Fitted>,
        runs: &[Vec<usize>],
        factors: usize,
        previous: &[&ShiftedMode],
        group: usize,
    ) -> Option<Vec<ShiftDecision>> {
        let from_known_modes = || ShiftDecision::from_known_modes(previous.iter().copied(), group);
        let Some(fitted) = fitted else {
            return from_known_modes();
        };
        let group_residual_energy = self.group_residual_energy(runs);
        let criterion = self.criterion(runs, group_residual_energy.min(fitted.residual_energy));
        let modes = match self.modes(fitted, criterion.noise) {
            Some(modes) => modes,
            None if previous.is_empty() => return None,
            None => return from_known_modes(),
        };
        if modes.is_empty() {
            return Some(Vec::new());
        }
        let of_runs = criterion.of_runs(fitted);
        let of_common_poles = criterion.of_common_poles(group_residual_energy, self.group.len());
        if !previous.is_empty() {
            // Aligned, each is one pole, unless it never was one mode.
            if self.group.len() > previous.len() && of_runs >= of_common_poles {
                return Some(Vec::new());
            }
            let values = (self.omega.len() * self.functions()) as f64;
            return match fitted.residual_energy
                < MAX_RESIDUAL_RATIO * group_residual_energy.max(values)
            {
                true => ShiftDecision::from_known_modes(&modes, group),
                false => from_known_modes(),
            };
        }
        if of_runs >= of_common_poles || self.runs_coincide_with_poles(fitted, &modes) {
            return Some(Vec::new());
        }
        // Residues as products of shapes and participation factors.
        let of_group: usize = self
            .group
            .iter()
            .map(|model_pole| model_pole.multiplicity())
            .sum();
        let of_products = criterion.of(self.residual_energy_as_fitted(), 2 * of_group * factors);
        let gain = (of_common_poles - of_runs) / modes.len() as f64;
        let decision = |mode: ShiftedMode| ShiftDecision {
            is_conclusive: of_runs < of_products,
            was_shifted: false,
            mode,
            group,
            gain,
        };
        Some(modes.into_iter().map(decision).collect())
    }

    /// Whether the poles of the runs coincide with separate poles of the group: modes that each
    /// respond in separate runs look like that, whereas a shifted mode would have to stop at these
    /// poles.
    fn runs_coincide_with_poles(&self, fitted: &Fitted, modes: &[ShiftedMode]) -> bool {
        let (lo, hi) = self.span();
        let gap = (hi - lo) / (self.group.len().max(2) - 1) as f64;
        let chosen = |(track, mode): (&Track, &ShiftedMode)| {
            let distance = |pole: &Complex64| {
                let model_poles = self
                    .group
                    .iter()
                    .map(|model_pole| (model_pole.lambda.im - pole.im).abs());
                model_poles.fold(f64::INFINITY, f64::min)
            };
            let mut distances: Vec<f64> = track.poles.iter().map(distance).collect();
            distances.sort_by(f64::total_cmp);
            let wide = hi - lo > MIN_GROUP_SPAN_BANDWIDTHS * -2.0 * mode.lambda.re;
            wide && distances[distances.len() / 2] < MAX_DISTANCE_FRACTION * 0.5 * gap
        };
        fitted.tracks.iter().zip(modes).any(chosen)
    }

    /// Residual energy `Σ|r|²` of the poles of the group as fitted; other poles and out-of-band
    /// terms are fitted here.
    fn residual_energy_as_fitted(&self) -> f64 {
        let group_poles: Vec<ModelPole> = self
            .group
            .iter()
            .map(|model_pole| (*model_pole).clone())
            .collect();
        let explained = pole_columns(self.data.frfs.line_shape, &self.omega, &group_poles)
            * residues(&group_poles, self.data.frfs.functions());
        let BandProfile {
            noise_profile,
            level,
        } = &self.profile;
        let (lines, functions) = (self.omega.len(), self.data.frfs.functions());
        let residual = linalg::complex_matrix(lines, functions, |k, f| {
            self.aligned[(k, f)] - explained[(k, f)] / (noise_profile[k] * level[f])
        });
        without(&self.basis(&self.others), &residual).squared_norm_l2()
    }

    /// Merges the runs as samples of one mode, in noise of a given variance.
    fn merged(&self, fitted: &Track, noise: f64) -> ShiftedMode {
        let variances: Vec<f64> = fitted.variances.iter().map(|v| v * noise).collect();
        let omegas: Vec<f64> = fitted.poles.iter().map(|pole| pole.im).collect();
        let between = between_runs(&omegas, &variances);
        let weight = |v: &f64| 1.0 / (between + v);
        let weights: f64 = variances.iter().map(weight).sum();
        let weighted = fitted.poles.iter().zip(&variances);
        let weighted = weighted.map(|(pole, v)| pole * weight(v));
        let lambda = weighted.sum::<Complex64>() / weights;
        let direction = Complex64::new(fitted.slope, 1.0);
        let shrunk_shift =
            |(omega, v): (&f64, &f64)| direction * (omega - lambda.im) * between * weight(v);
        let residues = fitted.amplitudes.iter().zip(&self.profile.level);
        let information: f64 = variances.iter().map(|v| v.recip()).sum();
        ShiftedMode {
            lambda,
            scatter: between.sqrt(),
            decay_std: information.recip().sqrt(),
            shifts: omegas.iter().zip(&variances).map(shrunk_shift).collect(),
            stds: variances.iter().map(|v| v.sqrt()).collect(),
            residues: residues.map(|(a, level)| a * level).collect(),
        }
    }
}

/// Whether the frequency of enough runs has at most this variance.
fn has_enough_runs(variances: impl ExactSizeIterator<Item = f64>, most: f64) -> bool {
    let runs = variances.len();
    variances.filter(|v| *v < most).count() >= 2.max(runs / 2)
}
