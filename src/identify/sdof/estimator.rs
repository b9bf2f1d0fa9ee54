//! The common run of the single-mode methods: search peaks, take each out of its surroundings, fit
//! it alone, repeat.
//!
//! A single-mode method sees one resonance in a window of lines. Neighbours tilt what it sees: of a
//! mode ten half-power widths away, 5 % of the peak. The first look reads each pole off the
//! measured indicator. Every pass then solves for the residues of all poles, subtracts from every
//! function the contributions of all other modes and the conjugate of the mode's own, and fits
//! again (the classical refinement of single-mode curve fitting, Ewins 2000, section 4.4). A method
//! brings no more than [`SingleModeMethod::fit`].

use std::f64::consts::TAU;
use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::axis::Band;
use crate::frf::FrfSet;
use crate::modal::Pole;

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::detection_spectrum::Indicator;
use crate::identify::data::peak_detection::{self, Found, Peak};
use crate::identify::error::IdentifyError;
use crate::identify::estimator::{Candidate, MethodOptions, PoleEstimator, PoleTable};
use crate::identify::fit::residues;
use crate::identify::sdof::findings;
use crate::identify::sdof::repeated_poles::PairTable;
use crate::identify::sdof::weighted_mean::weighted_mean;

/// Passes with the neighbours taken out.
const PASSES: usize = 5;
/// Half of the window for residues, in half-power widths: wide enough to tell the skirts from the
/// constant.
pub(in crate::identify) const RESIDUE_REACH: f64 = 2.5;
/// Fewest lines on either side of the resonance for residues.
pub(in crate::identify) const RESIDUE_SIDE: usize = 6;

/// One resonance, alone, in a window of lines.
pub(in crate::identify) struct Isolated<'a> {
    /// Lines of the window, rad/s.
    pub omega: &'a [f64],
    /// Receptance without what other poles put there, m/N, by function.
    pub values: Vec<Vec<Complex64>>,
    /// Noise variance of each function in the window, (m/N)².
    pub variance: Vec<f64>,
    /// The pole of the pass before, rad/s.
    pub lambda: Complex64,
}

/// What a method says of one resonance.
#[derive(Clone, Copy, Debug)]
pub(in crate::identify) struct SingleModeFit {
    /// Pole as in the data, rad/s.
    pub lambda: Complex64,
    /// Standard deviation of Im λ, rad/s.
    pub omega_std_rad_s: Option<f64>,
    /// Standard deviation of −Re λ, rad/s.
    pub decay_std_rad_s: Option<f64>,
    /// Relative standard deviation of the damping surface.
    pub spread: Option<f64>,
    /// Whether a half-power point was missing.
    pub one_sided: bool,
}

/// What one function by itself says of a resonance.
pub(in crate::identify) struct OwnFit {
    /// Its say in the mean: power of the resonance over the noise.
    pub weight: f64,
    /// Pole as in the data, rad/s.
    pub lambda: Complex64,
    /// What the function leaves of the method's own measure of a good fit.
    pub spread: f64,
}

impl SingleModeFit {
    /// The weighted mean over the functions that could be fitted; `None` where none could.
    pub fn of_functions(
        isolated: &Isolated,
        own: fn(&Isolated, usize) -> Option<OwnFit>,
    ) -> Option<Self> {
        let fits: Vec<OwnFit> = (0..isolated.values.len())
            .filter_map(|f| own(isolated, f))
            .collect();
        let mean = |value: fn(&OwnFit) -> f64| {
            let pairs: Vec<(f64, f64)> = fits.iter().map(|fit| (fit.weight, value(fit))).collect();
            weighted_mean(&pairs)
        };
        let (omega, decay) = (mean(|fit| fit.lambda.im)?, mean(|fit| -fit.lambda.re)?);
        Some(Self {
            lambda: Complex64::new(-decay.mean, omega.mean),
            omega_std_rad_s: omega.std,
            decay_std_rad_s: decay.std,
            spread: mean(|fit| fit.spread).map(|spread| spread.mean),
            one_sided: false,
        })
    }
}

/// A method that looks at one resonance at a time.
pub(in crate::identify) trait SingleModeMethod: Send + Sync {
    /// Its name.
    fn name(&self) -> &'static str;
    /// Half of its window in half-power widths, and the fewest lines on either side.
    fn window(&self) -> (f64, usize);
    /// The pole of an isolated resonance; `None` when there is none to be seen.
    fn fit(&self, isolated: &Isolated) -> Option<SingleModeFit>;
}

/// A single-mode method as an estimator.
pub(in crate::identify) struct SingleModeEstimator<M> {
    /// How one resonance is fitted.
    pub method: M,
    /// Options of the run.
    pub options: MethodOptions,
}

/// One mode on its way through the passes.
#[derive(Clone, Debug)]
pub(in crate::identify) struct Resonance {
    /// The pole of the first look, rad/s.
    pub first: Complex64,
    /// The pole now, rad/s.
    pub lambda: Complex64,
    /// What the method said last.
    pub fit: Option<SingleModeFit>,
    /// Lines for residues and checks.
    pub lines: Range<usize>,
}

impl<M: SingleModeMethod> PoleEstimator for SingleModeEstimator<M> {
    fn name(&self) -> &'static str {
        self.method.name()
    }

    fn estimate(&self, set: &FrfSet, band: Band) -> Result<PoleTable, IdentifyError> {
        let data = Receptances::new(set, band)?;
        let indicator = Indicator::new(&data);
        let mut found =
            peak_detection::search(&data, &indicator, self.options.false_alarm_probability);
        let (resonances, residues) = loop {
            let (resonances, residues) = self.passes(&data, first_look(&data, &indicator, &found));
            let fitted = |mode: usize| resonances[mode].fit.is_some();
            if !peak_detection::drop_humps(&mut found, (&data, &indicator), fitted) {
                break (resonances, residues);
            }
        };
        let table = PairTable::complete(set.functions());
        let fitted = (resonances.as_slice(), residues.as_slice());
        let valid = set.valid_band;
        let highest_rad_s = valid.map_or(f64::INFINITY, |band| TAU * band.hi_hz);
        let table = (table.as_ref(), highest_rad_s);
        let verdicts = findings::verdicts(&data, &found, fitted, table)?;
        let context = findings::Context {
            set,
            data: &data,
            found: &found,
            resonances: &resonances,
            verdicts: &verdicts,
        };
        let modes = strongest(&found, self.options.max_modes);
        let findings = findings::findings(&context, &modes);
        let candidate = |mode: &usize| candidate(&resonances[*mode], &verdicts[*mode]);
        let candidates = modes.iter().map(candidate).collect();
        Ok(PoleTable {
            candidates,
            findings,
            ..PoleTable::default()
        })
    }
}

impl<M: SingleModeMethod> SingleModeEstimator<M> {
    fn passes(
        &self,
        data: &Receptances,
        mut resonances: Vec<Resonance>,
    ) -> (Vec<Resonance>, Vec<Vec<Complex64>>) {
        for _ in 0..PASSES {
            let (poles, residues) = solve(data, &mut resonances);
            resonances = (0..resonances.len())
                .into_par_iter()
                .map(|j| self.refit(data, (&poles, &residues), &resonances, j))
                .collect();
        }
        let (_, residues) = solve(data, &mut resonances);
        (resonances, residues)
    }

    fn refit(
        &self,
        data: &Receptances,
        (poles, residues): (&[Complex64], &[Vec<Complex64>]),
        resonances: &[Resonance],
        mode: usize,
    ) -> Resonance {
        let mut resonance = resonances[mode].clone();
        let lines = window(data, poles, mode, self.method.window());
        let isolated = Isolated {
            omega: &data.omega[lines.clone()],
            values: residues::remainder(data, poles, residues, (&[mode], lines.clone())),
            variance: (0..data.functions())
                .map(|f| data.mean_variance(f, lines.clone()))
                .collect(),
            lambda: resonance.lambda,
        };
        let first: Vec<Complex64> = resonances.iter().map(|r| r.first).collect();
        resonance.fit = self
            .method
            .fit(&isolated)
            .filter(|fit| plausible(&first, mode, data.step, fit));
        if let Some(fit) = resonance.fit {
            resonance.lambda = fit.lambda;
        }
        resonance
    }
}

/// A fit must stay at its peak: within the half-power band of the first look, nearer to it than to
/// any other peak, and within a factor of five in damping.
fn plausible(first: &[Complex64], mode: usize, step: f64, fit: &SingleModeFit) -> bool {
    let own = first[mode];
    let shift = (fit.lambda.im - own.im).abs();
    let others = first.iter().enumerate().filter(|(j, _)| *j != mode);
    let gaps = others.map(|(_, other)| 0.45 * (other.im - own.im).abs());
    let ratio = fit.lambda.re / own.re;
    shift <= gaps.fold(own.re.abs() + step, f64::min) && ratio > 0.2 && ratio < 5.0
}

fn solve(
    data: &Receptances,
    resonances: &mut [Resonance],
) -> (Vec<Complex64>, Vec<Vec<Complex64>>) {
    let poles: Vec<Complex64> = resonances.iter().map(|r| r.lambda).collect();
    for (j, resonance) in resonances.iter_mut().enumerate() {
        resonance.lines = window(data, &poles, j, (RESIDUE_REACH, RESIDUE_SIDE));
    }
    let windows: Vec<Range<usize>> = resonances.iter().map(|r| r.lines.clone()).collect();
    let residues = residues::residues(data, &poles, &windows);
    (poles, residues)
}

/// The modes to report, by number: those of the highest peaks when there is a most.
fn strongest(found: &Found, most: Option<usize>) -> Vec<usize> {
    let power = |mode: &usize| found.peaks[*mode].power;
    let mut modes: Vec<usize> = (0..found.peaks.len()).collect();
    if let Some(most) = most {
        modes.sort_by(|a, b| power(b).total_cmp(&power(a)));
        modes.truncate(most);
        modes.sort_unstable();
    }
    modes
}

fn first_look(data: &Receptances, indicator: &Indicator, found: &Found) -> Vec<Resonance> {
    let resonance = |peak: &Peak| {
        let first = peak_detection::first_pole(data, indicator, found, peak);
        Resonance {
            first,
            lambda: first,
            fit: None,
            lines: 0..0,
        }
    };
    found.peaks.iter().map(resonance).collect()
}

/// Lines around a mode: some half-power widths on either side, but not past the middle to a
/// neighbour; never fewer than a count on either side, except at the ends of the band, where the
/// other side is given them.
fn window(
    data: &Receptances,
    poles: &[Complex64],
    mode: usize,
    (reach, fewest): (f64, usize),
) -> Range<usize> {
    let lambda = poles[mode];
    let others = poles.iter().enumerate().filter(|(j, _)| *j != mode);
    let gap = |(_, other): (usize, &Complex64)| 0.5 * (other.im - lambda.im).abs();
    let reach = others
        .map(gap)
        .fold(reach * 2.0 * lambda.re.abs(), f64::min);
    let side = ((reach / data.step).ceil() as usize).max(fewest);
    let top = ((lambda.im - data.omega[0]) / data.step).round().max(0.0) as usize;
    let top = top.min(data.lines() - 1);
    let start = top.saturating_sub(side);
    let end = (top + side + 1).min(data.lines());
    let missing = (2 * fewest + 1).saturating_sub(end - start);
    let end = if start == 0 {
        (end + missing).min(data.lines())
    } else {
        end
    };
    start.saturating_sub(if start > 0 { missing } else { 0 })..end
}

fn candidate(resonance: &Resonance, verdict: &findings::Verdict) -> Candidate {
    let norm = resonance.lambda.norm();
    let fit = resonance.fit;
    let hz = |rad_s: f64| rad_s / std::f64::consts::TAU;
    Candidate {
        order: None,
        pole: Pole {
            lambda: resonance.lambda,
        },
        participation: None,
        frequency_damping_correlation: None,
        frequency_bias_hz: None,
        damping_bias: None,
        residues: Some(verdict.residues.clone()),
        residue_stds: None,
        multiplicity: verdict.multiplicity,
        frequency_std_hz: fit.and_then(|fit| fit.omega_std_rad_s).map(hz),
        damping_std: fit
            .and_then(|fit| fit.decay_std_rad_s)
            .map(|std| std / norm),
        quality: fit.and_then(|fit| fit.spread),
    }
}
