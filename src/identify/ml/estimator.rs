//! The maximum likelihood method refines initial poles of the polyreference LSCF and keeps as many
//! modes as the data support.
//!
//! 1. Poles that are stable over the orders of the LSCF are the initial poles. The number of
//!    detected peaks sets the maximum order, and the lower segments of a wide band are estimated
//!    separately. With several references, and where the residual of these poles exceeds the
//!    noise, the FRFs are also fitted as outputs of one input, which gives the poles and the
//!    multiplicity of each ([`multiplicity`](crate::identify::pole_model::multiplicity)).
//! 2. All poles move to the maximum of the likelihood
//!    ([`refine`](crate::identify::fit::block_descent)).
//! 3. A pole is kept when it is above the noise (chi-squared test of its amplitude with all else
//!    fitted), when its standard deviation is below a fifth of its decay rate, and when its
//!    distance from its neighbours is at least two standard deviations of that distance. Two
//!    inseparable poles with different participation factors are one repeated pole
//!    ([`acceptance`](crate::identify::pole_model::acceptance)).
//! 4. Noise that is correlated between frequency lines looks like modes. The correlation is
//!    estimated from the residual, where that is noise, and raises limits and standard deviations
//!    ([`line_correlation`](crate::identify::noise::line_correlation)). Where the data have no
//!    variances and most of the noise is correlated, the noise variance is estimated from the
//!    level of the residual, and poles that were fitted to noise are removed.
//! 5. The residual is searched for peaks above the noise. A trial pole there must pass the same
//!    tests and lower the residual. Without such peaks, each pole is tested for being a close pair
//!    ([`close_pole_test`](crate::identify::ml::close_pole_test)). Where a trial pole hardly
//!    lowers the residual, the criteria of step 7 apply to it at once.
//! 6. Out-of-band terms that the data do not need are removed.
//! 7. Spurious poles above the noise are rejected: poles of a low modal contribution where the
//!    model misfits the data or many phases are arbitrary, and poles that repeat the shape of a
//!    strong neighbour with the phase of no normal mode
//!    ([`pole_metrics`](crate::identify::pole_model::pole_metrics)). The misfit near a mode
//!    enlarges its standard deviations.
//!
//! Where the file states a window for steady excitation, each pole has the line shape of that
//! window ([`line_shape`](crate::identify::data::line_shape)). Where it states none, close poles
//! that the line shape of a Hann or flat top window explains are merged
//! ([`leakage`](crate::identify::ml::leakage)).
//!
//! Guard lines on both sides of the band are fitted where the data have them, so that a mode
//! outside the band does not bias one inside. Without variances in the data, the noise is
//! estimated from the residual ([`noise`](crate::identify::noise::data_variance)).

use crate::axis::Band;
use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::FrfSet;

use crate::identify::data::detection_spectrum::DetectionSpectrum;
use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::line_shape::LineShape;
use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::peak_detection::{self, DetectedPeaks};
use crate::identify::error::IdentifyError;
use crate::identify::estimator::{MethodOptions, PoleEstimator, PoleTable};
use crate::identify::fit::block_descent::Convergence;
use crate::identify::fit::fit_data::FitData;
use crate::identify::fit::pole_covariance::add_noise_model_uncertainty;
use crate::identify::mdof::lscf::LeastSquaresComplexFrequency;
use crate::identify::mdof::stabilization::{MultiModeMethod, model_poles, set_orders, stabilise};
use crate::identify::method::{Method, Outcome};
use crate::identify::ml::amplitude_dependence::strongest_companions;
use crate::identify::ml::trial_poles::MIN_RESIDUAL_GAIN;
use crate::identify::noise::model::NoiseModel;
use crate::identify::pole_model::PoleModel;
use crate::identify::pole_model::merge::Merged;
use crate::identify::pole_model::multiplicity::{complete_multiplicities, distinct_poles};
use crate::identify::run_variation::RunShifts;

/// Maximum rounds of the search of the residual.
const MAX_SEARCHES: usize = 4;
/// Maximum alignments of the runs before poles are added to the stable ones.
const MAX_INITIAL_ROUNDS: usize = 2;
/// Relative residual of poles without the line shape of a stated window, over that with it, below
/// which the data contradict the window. Larger: more poles imitate the line shape of one (0.7 and
/// more under a true window). Smaller: in noise of a hundredth of the peaks a window that was
/// stated in error is believed. Tests: `a_window_that_the_data_contradict_is_not_used`,
/// `damping_under_a_stated_hann_window_is_unbiased_and_within_its_deviation`.
const MAX_CONTRADICTING_RATIO: f64 = 0.25;

/// The maximum likelihood method.
pub(in crate::identify) struct MaximumLikelihood {
    /// Options of the run.
    pub options: MethodOptions,
}

impl PoleEstimator for MaximumLikelihood {
    fn name(&self) -> &'static str {
        "ml"
    }

    fn estimate(&self, set: &FrfSet, band: Band) -> Result<PoleTable, IdentifyError> {
        Ok(self.outcome(set, band)?.table)
    }
}

impl Method for MaximumLikelihood {
    fn outcome(&self, set: &FrfSet, band: Band) -> Result<Outcome, IdentifyError> {
        let shape = LineShape::of(set);
        let unshifted = RunShifts::none(set.functions());
        let (mut fit, found) = self.fitted(set, band, shape, unshifted.clone())?;
        let split = self.check_leakage(set, band, &mut fit)?;
        let merged = fit.merge_same_shapes();
        // Poles of leakage or of smoothed values are no companions.
        if !shape.is_smoothed() && !fit.may_have_leakage() && merged.is_empty() {
            fit.add_companions();
        }
        let splits = fit.split_findings(&split, band);
        let plain = match shape.is_smoothed() {
            true => Some(self.fitted(set, band, LineShape::EXACT, unshifted)?),
            false => None,
        };
        let contradicts = |(unsmoothed, _): &(PoleModel, DetectedPeaks)| {
            unsmoothed.relative_residual() < MAX_CONTRADICTING_RATIO * fit.relative_residual()
        };
        let (mut table, run_shifts) = match plain.filter(contradicts) {
            Some((mut plain, found)) => {
                plain.data.frfs.leakage = None;
                let mut table = plain.table(set, band, &found, &[]);
                let code = Code::WindowContradicted;
                let finding = Finding::new(Severity::Warning, code, Location::Whole);
                table.findings.push(finding);
                (table, plain.run_shifts)
            }
            None => {
                let companions = strongest_companions(&fit.poles);
                let mut table = fit.table(set, band, &found, &companions);
                table.findings.extend(splits);
                let added = set.added_damping_rad_s;
                let finding = |merged: &Merged| merged.finding(&table.candidates, added);
                let merged: Vec<Finding> = merged.iter().filter_map(finding).collect();
                table.findings.extend(merged);
                (table, fit.run_shifts)
            }
        };
        set_orders(&mut table);
        Ok(Outcome { table, run_shifts })
    }
}

impl MaximumLikelihood {
    /// Fits poles with a line shape, including the rejection of spurious poles and the final
    /// refinement. `shifts`: those of the runs at the beginning.
    pub(in crate::identify) fn fitted(
        &self,
        set: &FrfSet,
        band: Band,
        shape: LineShape,
        shifts: RunShifts,
    ) -> Result<(PoleModel, DetectedPeaks), IdentifyError> {
        let (mut fit, found) = self.merged(set, band, shape, shifts)?;
        fit.reduce_out_of_band_terms();
        fit.complete();
        Ok((fit, found))
    }

    /// Fits the initial poles to the measured runs, and again to aligned runs where a frequency
    /// varies between runs. Returns the fit with the fewest poles at the shifted modes; of several
    /// such fits the latest.
    fn merged(
        &self,
        set: &FrfSet,
        band: Band,
        shape: LineShape,
        mut moved: RunShifts,
    ) -> Result<(PoleModel, DetectedPeaks), IdentifyError> {
        let mut fits: Vec<(PoleModel, DetectedPeaks)> = Vec::new();
        let mut initial_rounds = 0;
        loop {
            let mut data = FitData::guarded(set, band)?;
            data.set_line_shape(shape);
            moved.align_runs(&mut data);
            let aligned = moved.clone();
            let frf_matrix = FrfMatrix::new(set.functions());
            let frf_matrix = if frf_matrix.is_complete() {
                frf_matrix
            } else {
                frf_matrix.as_one_input()
            };
            let indicator = DetectionSpectrum::new(&data.frfs, data.noise.stated_noise());
            let found = peak_detection::search(
                &data.frfs,
                &data.noise.by_frf,
                &indicator,
                self.options.false_alarm_probability,
            );
            let mut fit = PoleModel::new(data, frf_matrix, self.options);
            let initial_poles = fit.fit_stable_poles(&found)?;
            // Shifts that are corrected now need no further poles to imitate them.
            if initial_rounds < MAX_INITIAL_ROUNDS {
                initial_rounds += 1;
                let by_function = moved.by_function().filter(|_| !moved.any());
                let changed = moved.update_from_fit(&fit.data, &fit.poles);
                // References that were hit on other days have other frequencies at one point.
                let by_function = by_function.filter(|_| fit.has_unexplained_residual());
                if let Some(mut by_function) = by_function
                    && by_function.update_from_fit(&fit.data, &fit.poles)
                    && (!changed || by_function.is_better_than(&moved))
                {
                    moved = by_function;
                    continue;
                }
                if changed {
                    continue;
                }
            }
            fit.fit_further_poles(&found, initial_poles)?;
            fit.run_shifts = aligned;
            let changed = moved.update_from_fit(&fit.data, &fit.poles);
            fits.push((fit, found));
            // A shift may be found in the runs as measured and not in the aligned ones. Shifts that
            // agree with those of an earlier fit would repeat it.
            let mut earlier = fits.iter().map(|(fit, _)| &fit.run_shifts);
            if !changed || earlier.any(|shifts| moved.agrees_with(shifts)) {
                break;
            }
        }
        let moves = |pole: &&ModelPole| {
            fits.iter()
                .any(|(fit, _)| fit.run_shifts.contains_pole(pole.lambda))
        };
        let needed = |(fit, _): &(PoleModel, DetectedPeaks)| fit.poles.iter().filter(moves).count();
        let fewest = (0..fits.len())
            .rev()
            .min_by_key(|index| needed(&fits[*index]));
        Ok(fits.swap_remove(fewest.unwrap_or(0)))
    }
}

/// Stable poles of the LSCF, and the state before they were fitted.
struct InitialPoles {
    poles: Vec<ModelPole>,
    /// Noise before, where there are several inputs.
    noise: Option<NoiseModel>,
    /// Whether the noise changed since the poles were last tested.
    noise_changed: bool,
}

impl PoleModel {
    /// Fits the stable poles of the LSCF.
    fn fit_stable_poles(&mut self, found: &DetectedPeaks) -> Result<InitialPoles, IdentifyError> {
        let poles = self.stable_poles(&self.lscf(), found)?;
        if self.data.noise.may_be_below_misfit(&self.data.frfs) {
            self.poles = poles.clone();
            self.residues();
            let misfit = self.residual();
            self.data.raise_noise_to_misfit(&misfit);
        }
        let noise = (self.frf_matrix.inputs > 1).then(|| self.data.noise.clone());
        self.poles = poles.clone();
        Ok(InitialPoles {
            noise_changed: self.refine_with_noise_update(),
            poles,
            noise,
        })
    }

    /// Adds poles at the peaks of the residual of the stable poles.
    ///
    /// Many references allow few orders, and a repeated pole then appears as fewer poles than it
    /// has modes. Where the residual of the poles of all references exceeds the noise, the FRFs are
    /// also fitted as outputs of one input.
    fn fit_further_poles(
        &mut self,
        found: &DetectedPeaks,
        initial: InitialPoles,
    ) -> Result<(), IdentifyError> {
        let mut changed = initial.noise_changed;
        if let Some(noise) = initial.noise {
            if !self.has_unexplained_residual() {
                return Ok(());
            }
            // The residual of so few poles overestimates the noise.
            self.data.set_noise(noise);
            self.estimate_per_frf(&self.lscf(), found, initial.poles)?;
            changed = self.refine_with_noise_update();
        }
        self.search_rounds(changed);
        Ok(())
    }

    fn lscf(&self) -> LeastSquaresComplexFrequency {
        LeastSquaresComplexFrequency {
            max_order: self.options.max_order,
        }
    }

    /// Estimates poles from the FRFs as outputs of one input, and the multiplicity of each from its
    /// residues ([`multiplicity`](crate::identify::pole_model::multiplicity)).
    fn estimate_per_frf(
        &mut self,
        lscf: &LeastSquaresComplexFrequency,
        found: &DetectedPeaks,
        by_inputs: Vec<ModelPole>,
    ) -> Result<(), IdentifyError> {
        let one = self.frf_matrix.as_one_input();
        let frf_matrix = std::mem::replace(&mut self.frf_matrix, one);
        self.poles = distinct_poles(&[by_inputs.clone(), self.stable_poles(lscf, found)?].concat());
        self.refine_and_prune(Convergence::Coarse);
        if !self.data.noise.is_stated() {
            self.estimate_noise();
            self.refine_and_prune(Convergence::Coarse);
        }
        let pole_metrics = self.pole_metrics();
        let free = std::mem::take(&mut self.poles);
        self.dropped.clear();
        self.frf_matrix = frf_matrix;
        let false_alarm_probability =
            self.options.false_alarm_probability / self.data.frfs.lines() as f64;
        self.poles = complete_multiplicities(
            &self.data,
            &self.frf_matrix,
            by_inputs,
            &free,
            &pole_metrics,
            false_alarm_probability,
        );
        Ok(())
    }

    /// Refines the poles and estimates the noise anew until no more poles are removed. Returns
    /// whether the noise changed: noise that was estimated with poles that are now removed is out
    /// of date.
    fn refine_with_noise_update(&mut self) -> bool {
        self.refine_and_prune(Convergence::Coarse);
        loop {
            let before = self.poles.len();
            let changed = self.reestimate_noise_and_prune();
            if self.poles.len() == before {
                return changed;
            }
        }
    }

    /// Rejects spurious poles and refines the others to convergence, with their standard
    /// deviations.
    pub fn complete(&mut self) {
        self.reject_spurious_poles();
        self.refine_and_prune(Convergence::Fine);
        self.add_out_of_band_uncertainty();
        add_noise_model_uncertainty(&self.data, &mut self.poles);
    }

    pub fn reestimate_noise_and_prune(&mut self) -> bool {
        let changed = self.estimate_noise();
        self.refine_and_prune(Convergence::ResidualTest);
        changed
    }

    /// Searches the residual until it has no more peaks; `changed`: whether the noise changed since
    /// the poles were last tested.
    fn search_rounds(&mut self, mut changed: bool) {
        for _ in 0..MAX_SEARCHES {
            let before = self.poles.clone();
            let gain = self.search();
            let worthwhile = gain.is_some_and(|gain| gain >= MIN_RESIDUAL_GAIN);
            // The correlation of the noise is detected once at most.
            if !worthwhile && self.detect_correlated_noise() {
                return self.search_rounds(true);
            }
            // The same poles give the same noise.
            if gain.is_none() && !changed && self.poles == before {
                break;
            }
            // Where more poles still give reasons for rejection and lower the residual little,
            // further poles would not be modes.
            let last =
                gain.is_none() || !worthwhile && self.model_misses_data(&self.rejection_reasons());
            changed = self.reestimate_noise_and_prune();
            if last {
                break;
            }
        }
    }

    fn stable_poles(
        &mut self,
        method: &dyn MultiModeMethod,
        found: &DetectedPeaks,
    ) -> Result<Vec<ModelPole>, IdentifyError> {
        let limits = self.limits();
        let stabilisation = stabilise(method, &self.data, &self.frf_matrix, found, limits, &[])?;
        self.stabilization.extend(stabilisation.poles);
        Ok(model_poles(
            &stabilisation.initial_poles,
            self.data.frfs.functions(),
        ))
    }

    /// Mean over the FRFs of the residual energy over the FRF energy, each summed over the lines.
    pub fn relative_residual(&self) -> f64 {
        let normalised = self.residual();
        let of = |f: usize| {
            let residual =
                |k: usize| normalised.at(f, k).norm_sqr() * self.data.noise.by_frf[f].variance(k);
            let lines = 0..self.data.frfs.lines();
            let residual: f64 = lines.clone().map(residual).sum();
            residual
                / lines
                    .map(|k| self.data.frfs.values.at(f, k).norm_sqr())
                    .sum::<f64>()
        };
        (0..self.data.frfs.functions()).map(of).sum::<f64>() / self.data.frfs.functions() as f64
    }
}
