//! The estimator of the multi-mode methods takes the poles that are stable over model orders, fits
//! their residues, and keeps as many modes as the data support. It also fits residues at
//! prescribed poles.
//!
//! 1. The poles that are stable while the order rises
//!    ([`stabilization`](crate::identify::mdof::stabilization)).
//! 2. Residues of all of them by weighted linear least squares, with upper and lower residuals
//!    (LSFD): the linear part of the maximum likelihood fit
//!    ([`gauss_newton`](crate::identify::fit::gauss_newton)) at the poles of the method. Where the
//!    method gives no participation factors, these follow from the residues
//!    ([`multiplicity`](crate::identify::pole_model::multiplicity)).
//! 3. A pole is kept as a mode when its contribution is above the noise, when it is separated from
//!    its neighbours, and when it passes the tests of the maximum likelihood method. A column that
//!    stands on a peak ([`peak_columns`](crate::identify::mdof::peak_columns)) is kept whatever the
//!    error of its pole.
//!
//! The stated standard deviation joins the Cramér-Rao bound with the distance of the pole from the
//! maximum of the likelihood, by one Gauss-Newton step: the error of the method, which for these
//! methods is not small compared with the bound.
//!
//! Reference: Guillaume, Verboven and Vanlanduit (1998), Frequency-domain maximum likelihood
//! identification of modal parameters with confidence intervals, ISMA 23 (least-squares frequency
//! domain residues).

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::axis::Band;
use crate::frf::FrfSet;

use crate::identify::data::detection_spectrum::DetectionSpectrum;
use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::line_shape::LineShape;
use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::peak_detection::{self, DetectedPeaks};
use crate::identify::error::IdentifyError;
use crate::identify::estimator::{Candidate, MethodOptions, PoleEstimator, PoleTable};
use crate::identify::fit::block_descent::Convergence;
use crate::identify::fit::fit_data::FitData;
use crate::identify::mdof::peak_columns::{mark_columns, peak_columns};
use crate::identify::mdof::pole_tracks::StablePole;
use crate::identify::mdof::stabilization::{MultiModeMethod, model_poles, stabilise_weighted};
use crate::identify::method::Method;
use crate::identify::pole_model::PoleModel;
use crate::identify::pole_model::multiplicity::{complete_multiplicities, strongest};
use crate::identify::run_variation::RunShifts;

/// A multi-mode method as an estimator.
pub(in crate::identify) struct MultiModeEstimator<M> {
    /// Method that gives the poles of an order.
    pub method: M,
    /// Options of the run.
    pub options: MethodOptions,
}

impl<M: MultiModeMethod> PoleEstimator for MultiModeEstimator<M> {
    fn name(&self) -> &'static str {
        self.method.name()
    }

    fn estimate(&self, set: &FrfSet, band: Band) -> Result<PoleTable, IdentifyError> {
        let data = FitData::guarded(set, band)?;
        let frf_matrix = FrfMatrix::new(set.functions());
        let has_participation = frf_matrix.is_complete() && frf_matrix.inputs > 1;
        let single_input = frf_matrix.as_one_input();
        let is_scalar = !has_participation || !self.method.gives_participation();
        let indicator = DetectionSpectrum::new(&data.frfs, data.noise.stated_noise());
        let found = peak_detection::search(
            &data.frfs,
            &data.noise.by_frf,
            &indicator,
            self.options.false_alarm_probability,
        );
        let mut fit = PoleModel::new(
            data,
            if is_scalar {
                single_input
            } else {
                frf_matrix.clone()
            },
            self.options,
        );
        fit.fixed = true;
        let limits = fit.limits();
        let stable = stabilise_weighted(&self.method, &fit.data, &fit.frf_matrix, &found, limits)?;
        let peaks = found.of_any_direction().into_iter();
        let peaks: Vec<f64> = peaks.map(|peak| fit.data.frfs.omega[peak.line]).collect();
        let columns = peak_columns(&stable.initial_poles, &peaks, fit.data.frfs.step);
        fit.poles = model_poles(&stable.initial_poles, fit.data.frfs.functions());
        mark_columns(&mut fit.poles, &columns);
        fit.refine_and_prune(Convergence::Coarse);
        fit.estimate_noise();
        if has_participation && is_scalar {
            let free = assign_participation(&mut fit, frf_matrix);
            let columns: Vec<ModelPole> = free
                .into_iter()
                .filter(|pole| pole.is_peak_column)
                .collect();
            restore(&mut fit, columns.iter())?;
            let columns: Vec<Complex64> = columns.iter().map(|pole| pole.lambda).collect();
            mark_columns(&mut fit.poles, &columns);
        }
        fit.refine_and_prune(Convergence::Coarse);
        fit.estimate_noise();
        fit.refine_and_prune(Convergence::Coarse);
        fit.reject_spurious_poles();
        let mut table = fit.table(set, band, &found, &[]);
        let references = set.references().len();
        for candidate in &mut table.candidates {
            complete(candidate, &stable.initial_poles, &fit, references);
        }
        table.stabilization = stable.poles;
        Ok(table)
    }
}

impl<M: MultiModeMethod> Method for MultiModeEstimator<M> {}

/// The modes of given poles, rad/s, in runs aligned by given frequency shifts: residues and
/// standard deviations are estimated, and no pole is removed.
///
/// # Errors
/// [`IdentifyError`] when the band does not fit the set.
pub(in crate::identify) fn fit_at_poles(
    set: &FrfSet,
    band: Band,
    poles: &[Complex64],
    run_shifts: RunShifts,
) -> Result<PoleTable, IdentifyError> {
    let mut data = FitData::guarded(set, band)?;
    run_shifts.align_runs(&mut data);
    let frf_matrix = FrfMatrix::new(set.functions());
    let has_participation = frf_matrix.is_complete() && frf_matrix.inputs > 1;
    let functions = data.frfs.functions();
    let mut fit = PoleModel::new(data, frf_matrix.as_one_input(), MethodOptions::default());
    fit.fixed = true;
    fit.run_shifts = run_shifts;
    let single_pole = |pole: &Complex64| ModelPole::single(*pole, &[Complex64::ONE], functions);
    fit.poles = poles.iter().map(single_pole).collect();
    fit.residues();
    fit.estimate_noise();
    if has_participation {
        let free = assign_participation(&mut fit, frf_matrix);
        restore(&mut fit, free.iter())?;
    }
    fit.residues();
    let mut table = fit.table(set, band, &DetectedPeaks::default(), &[]);
    let references = set.references().len();
    for candidate in &mut table.candidates {
        complete(candidate, &[], &fit, references);
    }
    Ok(table)
}

/// Adds the evidence of the data to candidates of a method that fits each resonance alone: the
/// residues of all are fitted together.
///
/// # Errors
/// [`IdentifyError`] when the band does not fit the set.
pub(in crate::identify) fn add_evidence(
    set: &FrfSet,
    band: Band,
    candidates: &mut [Candidate],
) -> Result<(), IdentifyError> {
    let mut data = FitData::guarded(set, band)?;
    data.set_line_shape(LineShape::of(set));
    let frf_matrix = FrfMatrix::new(set.functions()).as_one_input();
    let functions = data.frfs.functions();
    let mut fit = PoleModel::new(data, frf_matrix, MethodOptions::default());
    fit.fixed = true;
    let poles = candidates.iter().map(|candidate| candidate.pole.lambda);
    let damped = poles.filter(|lambda| lambda.re < 0.0);
    fit.poles = damped
        .map(|lambda| ModelPole::single(lambda, &[Complex64::ONE], functions))
        .collect();
    fit.residues();
    fit.estimate_noise();
    fit.residues();
    let metrics = fit.pole_metrics();
    for candidate in candidates
        .iter_mut()
        .filter(|candidate| candidate.evidence.is_none())
    {
        let lambda = candidate.pole.lambda;
        let at = fit.poles.iter().position(|pole| pole.lambda == lambda);
        candidate.evidence = at.map(|j| metrics[j].evidence());
    }
    Ok(())
}

/// Replaces poles with free residues by poles with participation factors, as many as the residues
/// show. Returns the replaced poles.
fn assign_participation(fit: &mut PoleModel, frf_matrix: FrfMatrix) -> Vec<ModelPole> {
    let pole_metrics = fit.pole_metrics();
    let free = std::mem::take(&mut fit.poles);
    let chance = fit.options.false_alarm_probability / fit.data.frfs.lines() as f64;
    fit.frf_matrix = frf_matrix;
    fit.poles = complete_multiplicities(
        &fit.data,
        &fit.frf_matrix,
        Vec::new(),
        &free,
        &pole_metrics,
        chance,
    );
    free
}

/// Restores free poles that lost all modes to the noise, with the participation factors of their
/// strongest rank-one term.
fn restore<'a>(
    fit: &mut PoleModel,
    free: impl Iterator<Item = &'a ModelPole>,
) -> Result<(), IdentifyError> {
    for pole in free {
        if !fit.poles.iter().any(|fitted| fitted.lambda == pole.lambda) {
            fit.poles.push(strongest(&fit.frf_matrix, pole)?);
        }
    }
    Ok(())
}

/// Completes a candidate with the order of the nearest stable pole, the error of the method in its
/// standard deviations, and participation factors, where the inputs of the fit are the references.
fn complete(
    candidate: &mut Candidate,
    stable_poles: &[StablePole],
    fit: &PoleModel,
    references: usize,
) {
    let lambda = candidate.pole.lambda;
    let distance = |seed: &&StablePole| (seed.pole.lambda - lambda).norm();
    let nearest = stable_poles
        .iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)));
    candidate.order = nearest.map(|seed| seed.order);
    let Some(model_pole) = fit
        .poles
        .iter()
        .find(|model_pole| model_pole.lambda == lambda)
    else {
        return;
    };
    // Real and imaginary part of the offset have half of its square each.
    let offset = model_pole.quality.offset.norm() * std::f64::consts::FRAC_1_SQRT_2;
    let joined = |std: Option<f64>, error: f64| std.map(|std| std.hypot(error));
    candidate.frequency_std_hz = joined(candidate.frequency_std_hz, offset / TAU);
    candidate.damping_std = joined(candidate.damping_std, offset / lambda.norm());
    let single = model_pole.multiplicity() == 1 && model_pole.parts[0].len() == references;
    candidate.participation = single.then(|| model_pole.parts[0].clone());
}
