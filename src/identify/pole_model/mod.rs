//! The poles of a fit, with the tests that keep or remove them, and the candidates and findings
//! that follow.
//!
//! The estimators of rising model order and the maximum likelihood method fit residues or poles
//! here and decide by the same tests which poles are modes. How a method finds its poles is not
//! known here.
//!
//! Terms: *modal contribution*, the fraction of the response energy near a pole that this pole
//! explains; *spurious pole*, a pole of the mathematical model that is no mode of the structure;
//! *multiplicity*, the number of modes that share a pole.

use std::f64::consts::TAU;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::axis::Band;
use crate::frf::FrfSet;

use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::peak_detection::DetectedPeaks;
use crate::identify::data::residual::{PredictedResponse, Residual};
use crate::identify::estimator::{Candidate, MethodOptions, PoleAtOrder, PoleTable};
use crate::identify::fit::block_descent::{Convergence, MANY_POLES, mark_unconverged, refine};
use crate::identify::fit::compressed_band::CompressedBand;
use crate::identify::fit::fit_data::FitData;
use crate::identify::run_variation::RunShifts;
use crate::identify::run_variation::loaded_shapes::{MAX_SHAPE_CHANGE, Unloaded};
use crate::identify::run_variation::run_means::{RunMean, RunMeans};
use crate::linalg::{sort_ascending_by, sort_descending_by};

pub(in crate::identify) mod acceptance;
pub(in crate::identify) mod findings;
pub(in crate::identify) mod merge;
#[cfg(test)]
mod merge_tests;
mod misfit;
pub(in crate::identify) mod multiplicity;
mod narrower_bands;
pub(in crate::identify) mod pole_metrics;
mod sample;
mod snapshot;
mod spurious_poles;

use acceptance::{AcceptanceTest, PoleEdit};
use findings::{Dropped, FindingContext, is_mains_hum};
use narrower_bands::NarrowerBands;
use pole_metrics::{PoleMetrics, candidate, pole_metrics};

/// Margin beyond the first and last line in which poles may lie, over the range of the lines.
const POLE_MARGIN_OVER_BAND: f64 = 0.05;
/// Maximum rounds of pruning after each refinement.
const MAX_PRUNINGS: usize = 12;
/// Maximum number of coarse refinements of many poles between two prunings after which some have
/// not settled: with the first, as many sweeps as of few. Larger: data of no linear structure take
/// longer. Smaller: two poles that are still moving apart are joined.
const MAX_UNSETTLED: usize = 4;
/// Relative change of a variance below which it is unchanged.
const MAX_VARIANCE_CHANGE: f64 = 0.1;
/// Separation from the nearest pole, in sums of half-power bandwidths, above which a pole is
/// isolated.
const ISOLATED_BANDWIDTHS: f64 = 1.0;

/// Poles, data and noise model of a fit in progress.
pub(in crate::identify) struct PoleModel {
    pub data: FitData,
    pub frf_matrix: FrfMatrix,
    pub options: MethodOptions,
    pub poles: Vec<ModelPole>,
    pub dropped: Vec<Dropped>,
    /// Number of poles when their phases were found to be scattered.
    pub scattered: Option<usize>,
    /// Modes whose frequency shifts between runs.
    pub run_shifts: RunShifts,
    /// Poles of all model orders.
    pub stabilization: Vec<PoleAtOrder>,
    /// Whether poles are fixed and residues alone are fitted.
    pub fixed: bool,
    /// Compressed bands of the last refinement.
    compressed_bands: Vec<CompressedBand>,
}

impl PoleModel {
    pub fn new(data: FitData, frf_matrix: FrfMatrix, options: MethodOptions) -> Self {
        Self {
            data,
            frf_matrix,
            options,
            poles: Vec::new(),
            dropped: Vec::new(),
            scattered: None,
            run_shifts: RunShifts::default(),
            stabilization: Vec::new(),
            fixed: false,
            compressed_bands: Vec::new(),
        }
    }

    /// Range of the frequencies of poles, rad/s.
    pub fn limits(&self) -> [f64; 2] {
        let outside = POLE_MARGIN_OVER_BAND * self.data.frfs.range();
        let (first, last) = (
            self.data.frfs.omega[0],
            self.data.frfs.omega[self.data.frfs.lines() - 1],
        );
        [(first - outside).max(0.5 * first), last + outside]
    }

    pub fn refine(&mut self, stop: Convergence) {
        let stop = if self.fixed {
            Convergence::Residues
        } else {
            stop
        };
        let (poles, limits) = (std::mem::take(&mut self.poles), self.limits());
        self.poles = refine(
            &self.data,
            &self.frf_matrix,
            &mut self.compressed_bands,
            poles,
            limits,
            stop,
        );
    }

    /// Fits the residues of all poles and removes no pole. Modes with an identical pole become one
    /// repeated pole; close poles remain separate.
    pub fn residues(&mut self) {
        for i in 0..self.poles.len() {
            for j in i + 1..self.poles.len() {
                let same = self.poles[i].lambda == self.poles[j].lambda;
                if same && !self.poles[j].parts.is_empty() {
                    self.apply(PoleEdit::Merge(i, j));
                }
            }
        }
        self.poles.retain(|pole| !pole.parts.is_empty());
        mark_unconverged(&mut self.poles);
        self.refine(Convergence::Residues);
    }

    /// Refines and removes poles until all remaining poles are accepted.
    pub fn refine_and_prune(&mut self, stop: Convergence) {
        self.refine(stop);
        let (mut prunings, mut unsettled) = (0, 0);
        while prunings < MAX_PRUNINGS {
            let mut required_edits = self.acceptance_test().required_edits(&self.poles);
            let is_early = self.poles.len() > MANY_POLES
                && unsettled < MAX_UNSETTLED
                && !self.poles.iter().all(ModelPole::has_settled);
            if is_early {
                unsettled += 1;
                // Two poles that still move may separate.
                required_edits.retain(PoleEdit::is_removal_of_noise);
            } else if required_edits.is_empty() {
                break;
            }
            if !required_edits.is_empty() {
                (prunings, unsettled) = (prunings + 1, 0);
                for change in required_edits {
                    self.apply(change);
                }
                self.poles.retain(|pole| !pole.parts.is_empty());
                mark_unconverged(&mut self.poles);
            }
            self.refine(stop);
        }
    }

    /// Applies an edit. A removed pole loses its participation factors; the caller removes it from
    /// the list.
    pub fn apply(&mut self, change: PoleEdit) {
        match change {
            PoleEdit::Remove(j, reason) => {
                let lambda = self.poles[j].lambda;
                self.dropped.push(Dropped { lambda, reason });
                self.poles[j].parts.clear();
            }
            PoleEdit::Merge(i, j) => {
                let parts = std::mem::take(&mut self.poles[j].parts);
                let other = self.poles[j].lambda;
                self.poles[i].lambda = 0.5 * (self.poles[i].lambda + other);
                self.poles[i].suspect &= self.poles[j].suspect;
                self.poles[i].join(parts);
            }
            PoleEdit::ReduceMultiplicity(j, count) => self.poles[j].keep_strongest(count),
        }
    }

    fn acceptance_test(&self) -> AcceptanceTest<'_> {
        AcceptanceTest {
            frf_matrix: &self.frf_matrix,
            false_alarm_probability: self.options.false_alarm_probability,
            lines: self.data.frfs.lines(),
            step: self.data.frfs.step,
        }
    }

    pub fn pole_metrics(&self) -> Vec<PoleMetrics> {
        let mut all = pole_metrics(&self.data, &self.frf_matrix, &self.poles);
        for (metrics, pole) in all.iter_mut().zip(&self.poles) {
            metrics.has_shifts = self.run_shifts.contains_pole(pole.lambda);
        }
        all
    }

    /// Estimates the noise variance (where the data state none) and the line correlation from the
    /// residual. Returns whether the level of an FRF or the correlation changed.
    pub fn estimate_noise(&mut self) -> bool {
        mark_unconverged(&mut self.poles);
        // They are of the noise before.
        self.compressed_bands.clear();
        let (levels, correlation) = (self.levels(), self.data.noise.line_correlation.clone());
        let mut residual = self.residual();
        self.data.estimate_noise(&mut residual);
        self.data
            .noise
            .estimate_force_noise(&self.data.frfs, &residual);
        let changed =
            |(before, now): (&f64, &f64)| (now / before - 1.0).abs() > MAX_VARIANCE_CHANGE;
        self.data.noise.line_correlation != correlation
            || levels.iter().zip(&self.levels()).any(changed)
    }

    /// Mean noise variance of each FRF.
    fn levels(&self) -> Vec<f64> {
        let level = |f: usize| self.data.noise.mean_variance(f, 0..self.data.frfs.lines());
        (0..self.data.frfs.functions())
            .into_par_iter()
            .map(level)
            .collect()
    }

    /// Residual of the poles and the out-of-band terms.
    pub fn residual(&self) -> Residual {
        self.data.residual(&self.poles)
    }

    /// Standard deviations of real and imaginary part of the residues of a pole, from the noise of
    /// each FRF and its line correlation. An error of the pole changes all residues of an isolated
    /// mode by one factor, but mixes the residues of overlapping modes: `None` for those, and for a
    /// repeated pole.
    fn residue_stds(&self, pole: &ModelPole, metrics: &PoleMetrics) -> Option<Vec<f64>> {
        let modes = self.poles.iter().filter(|other| !other.is_companion);
        let near = modes.filter(|other| pole.separation(other) < ISOLATED_BANDWIDTHS);
        if pole.multiplicity() > 1 || near.count() > 1 {
            return None;
        }
        let correlation_factor = self
            .data
            .noise
            .line_correlation
            .amplitude_noise_factor(pole.decay(), self.data.frfs.step);
        let factor = metrics.inflation() * (0.5 * correlation_factor).sqrt();
        let stds = pole.residue_variances.iter().map(|v| factor * v.sqrt());
        Some(stds.collect())
    }

    /// Receptance of each FRF at the frequency of a pole, as fitted without it.
    fn without_pole<'a>(
        &'a self,
        described: &PredictedResponse,
        pole: &'a ModelPole,
    ) -> impl Fn(usize) -> Complex64 + use<'a> {
        let frfs = &self.data.frfs;
        let distance = |k: &usize| (frfs.omega[*k] - pole.lambda.im).abs();
        let lines = 0..frfs.lines();
        let line = lines.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let line = line.unwrap_or(0);
        let residual = described.residual(line..line + 1);
        let profile = |lambda| frfs.line_shape.pole(frfs.omega[line], lambda);
        let (of_pole, of_conjugate) = (profile(pole.lambda), profile(pole.lambda.conj()));
        move |f| {
            let fitted =
                frfs.values.at(f, line) - residual.at(f, line) * self.data.noise.std(f, line);
            let residue = pole.residues[f];
            fitted - residue * of_pole - residue.conj() * of_conjugate
        }
    }

    /// The table of candidates in a band, with findings. `companions`: poles of modes that have
    /// companions, and how large these are.
    pub fn table(
        &self,
        set: &FrfSet,
        band: Band,
        found: &DetectedPeaks,
        companions: &[(Complex64, f64)],
    ) -> PoleTable {
        let described = self.data.predict(&self.poles);
        let is_in_band = |pole: &ModelPole| {
            let hz = pole.lambda.norm() / TAU;
            !pole.is_companion && hz >= band.lo_hz && hz <= band.hi_hz
        };
        let is_hum =
            |pole: &ModelPole| is_mains_hum(pole, set.added_damping_rad_s, self.data.frfs.step);
        let is_mode = |pole: &ModelPole| is_in_band(pole) && !is_hum(pole);
        let hum: Vec<&ModelPole> = self
            .poles
            .iter()
            .filter(|pole| is_in_band(pole) && is_hum(pole))
            .collect();
        let mut pole_metrics = self.pole_metrics();
        let narrower_bands = NarrowerBands::new(&self.data, &self.poles, &described);
        let with_standing = self.poles.par_iter().zip(&mut pole_metrics);
        let modes = with_standing.filter(|(pole, _)| is_mode(pole));
        modes.for_each(|(pole, metrics)| metrics.band_deviation = narrower_bands.deviation(pole));
        let modes = self.poles.iter().zip(&pole_metrics);
        let mut kept: Vec<(&ModelPole, &PoleMetrics)> =
            modes.filter(|(pole, _)| is_mode(pole)).collect();
        if let Some(most) = self.options.max_modes {
            let worth = |(pole, _): &(&ModelPole, &PoleMetrics)| pole.quality.significance();
            sort_descending_by(&mut kept, worth);
            kept.truncate(most);
            sort_ascending_by(&mut kept, |entry| entry.0.lambda.im);
        }
        let run_means = RunMeans::new(&self.data, &self.poles, &described, self.run_shifts.runs());
        let mean = |pole: &ModelPole| {
            let known_shifts = self.run_shifts.shifts_of(pole.lambda);
            let mean = run_means.as_ref()?.of(pole, known_shifts)?;
            // Poles of another method, or of the user, stay where they are.
            let RunMean { shift, std, .. } = mean;
            Some(match self.fixed {
                true => RunMean {
                    shift: 0.0,
                    std: std.hypot(shift),
                    ..mean
                },
                false => mean,
            })
        };
        let means: Vec<Option<RunMean>> = kept.par_iter().map(|(pole, _)| mean(pole)).collect();
        let unloaded = |(pole, _): &(&ModelPole, &PoleMetrics)| {
            let remaining = self.without_pole(&described, pole);
            let shifts = &self.run_shifts;
            shifts.unloaded(pole, &self.poles, &self.frf_matrix, remaining)
        };
        let unloaded: Vec<Option<Unloaded>> = kept.iter().map(unloaded).collect();
        let evidence = FindingContext {
            set,
            data: &self.data,
            described,
            band,
            found,
            kept: &kept,
            means: &means,
            unloaded: &unloaded,
            hum: &hum,
            dropped: &self.dropped,
            scattered: self.scattered,
            run_shifts: &self.run_shifts,
            companions,
        };
        let candidate = |index: usize| {
            let (pole, metrics) = kept[index];
            let merged = self.run_shifts.merged(
                candidate(pole, metrics),
                means[index],
                metrics.band_deviation,
            );
            let residue_stds = self.residue_stds(pole, metrics);
            match &unloaded[index] {
                Some(unloaded) => Candidate {
                    // Those of the measured residues: of a large correction they are not known.
                    residue_stds: residue_stds.filter(|_| unloaded.change <= MAX_SHAPE_CHANGE),
                    residues: Some(unloaded.residues.clone()),
                    multiplicity: unloaded.multiplicity,
                    ..merged
                },
                None => Candidate {
                    residue_stds,
                    ..merged
                },
            }
        };
        PoleTable {
            candidates: (0..kept.len()).map(candidate).collect(),
            findings: evidence.findings(),
            stabilization: self.stabilization.clone(),
        }
    }
}
