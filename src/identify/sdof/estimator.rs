//! The estimator of the single-mode methods detects peaks, isolates each resonance, fits it, and
//! repeats.
//!
//! A single-mode method fits one resonance in a window of frequency lines. Neighbouring modes bias
//! the fit: a mode ten half-power bandwidths away contributes 5 % of the peak. The initial poles
//! come from the peaks of the detection spectrum. Every pass solves for the residues of all poles,
//! subtracts from every FRF the contributions of all other modes and the conjugate pole of the
//! mode, and fits again (the classical refinement of single-mode curve fitting, Ewins 2000, section
//! 4.4). A method implements [`SingleModeMethod`].

use std::f64::consts::TAU;
use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::axis::Band;
use crate::frf::FrfSet;
use crate::modal::Pole;

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::detection_spectrum::DetectionSpectrum;
use crate::identify::data::peak_detection::{self, DetectedPeaks, Peak};
use crate::identify::error::IdentifyError;
use crate::identify::estimator::{Candidate, MethodOptions, PoleEstimator, PoleTable};
use crate::identify::fit::fit_data::FitData;
use crate::identify::fit::residues;
use crate::identify::method::Method;
use crate::identify::sdof::findings;
use crate::identify::sdof::repeated_poles::PairTable;
use crate::identify::sdof::single_mode_method::{
    Isolated, MIN_RESIDUE_SIDE_LINES, RESIDUE_HALF_WINDOW_BANDWIDTHS, Resonance, SingleModeFit,
    SingleModeMethod,
};
use crate::linalg::sort_descending_by;

/// Fits of every resonance with the other modes subtracted.
const REFINEMENT_PASSES: usize = 5;

/// A single-mode method as an estimator.
pub(in crate::identify) struct SingleModeEstimator<M> {
    /// How one resonance is fitted.
    pub method: M,
    /// Options of the run.
    pub options: MethodOptions,
}

impl<M: SingleModeMethod> PoleEstimator for SingleModeEstimator<M> {
    fn name(&self) -> &'static str {
        self.method.name()
    }

    fn estimate(&self, set: &FrfSet, band: Band) -> Result<PoleTable, IdentifyError> {
        let data = FitData::new(set, band)?;
        let frfs = &data.frfs;
        let indicator = DetectionSpectrum::new(frfs, data.noise.stated_noise());
        let mut found = peak_detection::search(
            frfs,
            &data.noise.by_frf,
            &indicator,
            self.options.false_alarm_probability,
        );
        let (resonances, residues) = loop {
            let (resonances, residues) =
                self.run_passes(&data, initial_resonances(frfs, &indicator, &found));
            let fitted = |mode: usize| resonances[mode].fit.is_some();
            if !peak_detection::reject_background_maxima(&mut found, frfs, &indicator, fitted) {
                break (resonances, residues);
            }
        };
        let table = PairTable::complete(set.functions());
        let valid = set.valid_band;
        let highest_rad_s = valid.map_or(f64::INFINITY, |band| TAU * band.hi_hz);
        let table = table.as_ref();
        let verdicts =
            findings::verdicts(&data, &found, &resonances, &residues, table, highest_rad_s)?;
        let context = findings::Context {
            set,
            data: frfs,
            found: &found,
            resonances: &resonances,
            verdicts: &verdicts,
        };
        let modes = strongest_modes(&found, self.options.max_modes);
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

impl<M: SingleModeMethod> Method for SingleModeEstimator<M> {}

impl<M: SingleModeMethod> SingleModeEstimator<M> {
    fn run_passes(
        &self,
        data: &FitData,
        mut resonances: Vec<Resonance>,
    ) -> (Vec<Resonance>, Vec<Vec<Complex64>>) {
        for _ in 0..REFINEMENT_PASSES {
            let (poles, residues) = update_residues(&data.frfs, &mut resonances);
            resonances = (0..resonances.len())
                .into_par_iter()
                .map(|j| self.refit(data, &poles, &residues, &resonances, j))
                .collect();
        }
        let (_, residues) = update_residues(&data.frfs, &mut resonances);
        (resonances, residues)
    }

    fn refit(
        &self,
        data: &FitData,
        poles: &[Complex64],
        residues: &[Vec<Complex64>],
        resonances: &[Resonance],
        mode: usize,
    ) -> Resonance {
        let mut resonance = resonances[mode].clone();
        let (half_bandwidths, min_side_lines) = self.method.window();
        let lines = window(&data.frfs, poles, mode, half_bandwidths, min_side_lines);
        let isolated = Isolated {
            omega: &data.frfs.omega[lines.clone()],
            values: residues::remainder(&data.frfs, poles, residues, &[mode], lines.clone()),
            variance: (0..data.frfs.functions())
                .map(|f| data.noise.mean_variance(f, lines.clone()))
                .collect(),
            lambda: resonance.lambda,
        };
        let initial: Vec<Complex64> = resonances.iter().map(|r| r.initial).collect();
        resonance.fit = self
            .method
            .fit(&isolated)
            .filter(|fit| plausible(&initial, mode, data.frfs.step, fit));
        if let Some(fit) = resonance.fit {
            resonance.lambda = fit.lambda;
        }
        resonance
    }
}

/// Whether a fit stays at its peak: within the half-power band of the initial pole, nearer to it
/// than to any other peak, and within a factor of five in damping.
fn plausible(initial_poles: &[Complex64], mode: usize, step: f64, fit: &SingleModeFit) -> bool {
    let initial_pole = initial_poles[mode];
    let shift = (fit.lambda.im - initial_pole.im).abs();
    let others = initial_poles.iter().enumerate().filter(|(j, _)| *j != mode);
    let gaps = others.map(|(_, other)| 0.45 * (other.im - initial_pole.im).abs());
    let ratio = fit.lambda.re / initial_pole.re;
    shift <= gaps.fold(initial_pole.re.abs() + step, f64::min) && ratio > 0.2 && ratio < 5.0
}

fn update_residues(
    data: &BandFrfs,
    resonances: &mut [Resonance],
) -> (Vec<Complex64>, Vec<Vec<Complex64>>) {
    let poles: Vec<Complex64> = resonances.iter().map(|r| r.lambda).collect();
    for (j, resonance) in resonances.iter_mut().enumerate() {
        resonance.lines = window(
            data,
            &poles,
            j,
            RESIDUE_HALF_WINDOW_BANDWIDTHS,
            MIN_RESIDUE_SIDE_LINES,
        );
    }
    let windows: Vec<Range<usize>> = resonances.iter().map(|r| r.lines.clone()).collect();
    let residues = residues::residues(data, &poles, &windows);
    (poles, residues)
}

/// Indices of the modes to report: those of the highest peaks when their number is limited.
fn strongest_modes(found: &DetectedPeaks, max_modes: Option<usize>) -> Vec<usize> {
    let power = |mode: &usize| found.peaks[*mode].power;
    let mut modes: Vec<usize> = (0..found.peaks.len()).collect();
    if let Some(max_modes) = max_modes {
        sort_descending_by(&mut modes, power);
        modes.truncate(max_modes);
        modes.sort_unstable();
    }
    modes
}

fn initial_resonances(
    data: &BandFrfs,
    indicator: &DetectionSpectrum,
    found: &DetectedPeaks,
) -> Vec<Resonance> {
    let resonance = |peak: &Peak| {
        let initial = peak_detection::first_pole(data, indicator, found, peak);
        Resonance {
            initial,
            lambda: initial,
            fit: None,
            lines: 0..0,
        }
    };
    found.peaks.iter().map(resonance).collect()
}

/// Lines around a mode: some half-power bandwidths on either side, but not past the middle to a
/// neighbour. Either side has a minimum number of lines; at an end of the band the other side makes
/// up for the missing ones.
fn window(
    data: &BandFrfs,
    poles: &[Complex64],
    mode: usize,
    half_bandwidths: f64,
    min_side_lines: usize,
) -> Range<usize> {
    let lambda = poles[mode];
    let others = poles.iter().enumerate().filter(|(j, _)| *j != mode);
    let gap = |(_, other): (usize, &Complex64)| 0.5 * (other.im - lambda.im).abs();
    let half_width = others
        .map(gap)
        .fold(half_bandwidths * 2.0 * lambda.re.abs(), f64::min);
    let side = ((half_width / data.step).ceil() as usize).max(min_side_lines);
    let top = ((lambda.im - data.omega[0]) / data.step).round().max(0.0) as usize;
    let top = top.min(data.lines() - 1);
    let start = top.saturating_sub(side);
    let end = (top + side + 1).min(data.lines());
    let missing = (2 * min_side_lines + 1).saturating_sub(end - start);
    let end = if start == 0 {
        (end + missing).min(data.lines())
    } else {
        end
    };
    start.saturating_sub(if start > 0 { missing } else { 0 })..end
}

fn candidate(resonance: &Resonance, verdict: &findings::SdofVerdict) -> Candidate {
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
        evidence: None,
        quality: fit.and_then(|fit| fit.spread),
    }
}
