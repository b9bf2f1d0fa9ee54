//! The metrics of a pole describe the data around it (reduced chi-square, modal contribution,
//! scatter of phases); the criteria of spurious poles follow from them.

use std::f64::consts::TAU;
use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;
use statrs::distribution::{Beta, ContinuousCDF};

use crate::linalg::{self, ComplexMatrix};
use crate::modal::{Pole, mac};

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::residual::{PredictedResponse, Residual};
use crate::identify::estimator::{Candidate, Evidence};
use crate::identify::fit::fit_data::FitData;

/// Half-width of the lines on which the chi-square is measured, half-power bandwidths.
const CHI_SQUARE_BANDWIDTHS: f64 = 1.0;

/// Reduced chi-square above which the model misfits the data.
pub(in crate::identify) const MAX_CHI_SQUARE: f64 = 4.0;
const STRICT_CHI_SQUARE: f64 = 2.0;
/// Minimum modal contribution of a pole where the model misfits the data.
pub(in crate::identify) const MIN_CONTRIBUTION_WITH_MISFIT: f64 = 0.2;
/// Modal contribution above which a pole is a dominant mode.
const DOMINANT_CONTRIBUTION: f64 = 0.5;
/// Contribution over the misfit above which the misfit cannot be what a pole describes, in data of
/// negligible noise: without this limit such data, whose small misfit is far above their noise,
/// lose modes (`a_noise_free_hit_shows_all_modes`).
const SUFFICIENT_CONTRIBUTION_OVER_MISFIT: f64 = 10.0;
/// Separation, in sums of half-power bandwidths, below which two poles are neighbours.
const NEIGHBOUR_BANDWIDTHS: f64 = 4.0;
/// Distance, in half-power bandwidths of the other pole, below which a pole lies inside its
/// resonance, and maximum ratio of their bandwidths.
const MAX_DISTANCE_BANDWIDTHS: f64 = 2.0;
const MAX_WIDTH_RATIO: f64 = 2.0;
/// MAC above which a pole repeats the shape of its neighbour.
const MIN_MAC_SAME_SHAPE: f64 = 0.7;
/// Minimum modal contribution of any pole: a smaller one is below the nonlinearity of structures
/// and the errors of their model.
pub(in crate::identify) const MIN_CONTRIBUTION_LINEARITY: f64 = 3e-4;
/// Minimum modal contribution of the weakest mode of a repeated pole: unequal poles of the modes
/// produce such a term as well; and where frequencies shift between runs, so do the shapes of the
/// runs, as of a structure that a roving sensor loads (`roving sensor with mass` of the families of
/// imperfect data).
const MIN_CONTRIBUTION_REPEATED: f64 = 1e-2;
const MIN_CONTRIBUTION_REPEATED_SHIFTED: f64 = 5e-2;
/// Where a mode shifts between runs: minimum modal contribution of a pole beside a stronger one,
/// and separation from it, in sums of half-power bandwidths. The error of the estimated shifts of a
/// mode is such a pole. Smaller: 8 false modes in 12 draws of small shifts (2 with these limits;
/// `shift between runs, small` of the families of imperfect data). Larger: at 0.5 and 0.7 one of
/// two close modes is lost (`two_close_modes_that_drift_together_are_two_modes`).
const MIN_CONTRIBUTION_BESIDE_STRONGER: f64 = 6e-2;
const MAX_SEPARATION_BESIDE_STRONGER: f64 = 0.15;
/// Contribution of a ghost over that of the mode whose shape it repeats within its resonance:
/// errors of the force produce such poles.
const GHOST_CONTRIBUTION: f64 = 3e-2;
/// False-alarm probability of the test for a repeated shape or participation factor.
const FALSE_ALARM_PROBABILITY: f64 = 0.01;
/// Maximum phase difference, rad, of the residues of a mode from those of normal modes and of its
/// neighbour, in addition to the effect of noise.
pub(in crate::identify) const MAX_PHASE_DIFFERENCE_RAD: f64 = 0.7;

/// Part of the residues in phase less that in quadrature: minimum of a real shape, and maximum of a
/// shape that is hardly more in phase than in quadrature.
const MIN_REALNESS_STRONGEST: f64 = 0.8;
const MAX_REALNESS_SCATTERED: f64 = 0.5;
/// Scattered phases: minimum fraction of poles with such shapes (one in this number), and minimum
/// number.
const SCATTERED_ONE_IN: usize = 4;
const MIN_SCATTERED_POLES: usize = 3;
/// Minimum number of FRFs at which a random shape is unlikely to be real.
const MIN_FRFS_PHASE: usize = 3;

/// Metrics of a pole in the data around it.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct PoleMetrics {
    /// Mean square of the residual over the noise on the lines of the pole; 1 where noise is all.
    pub reduced_chi_square: f64,
    /// Modal contribution: square root of the energy that this pole alone explains, with all other
    /// residues fitted, over that of the response on the lines of the pole.
    pub contribution: f64,
    /// Square root of the energy of the residual beyond the noise over that of the response on the
    /// lines of the pole.
    pub misfit: f64,
    /// Minimum contribution of a mode here beside the ghosts that errors of the force or of a
    /// sensor produce; 0 where it repeats no other shape.
    pub ghost_limit: f64,
    /// Whether the misfit of any model is far above the noise: the chi-square then says nothing.
    pub is_noise_below_misfit: bool,
    /// Whether its frequency shifts between runs.
    pub has_shifts: bool,
    /// Standard deviation of each part of the pole by narrower bands, rad/s, where they move it by
    /// more than noise (`narrower_bands`); 0 before the fit is complete.
    pub band_deviation: f64,
}

/// Metrics of each pole.
pub(in crate::identify) fn pole_metrics(
    data: &FitData,
    frf_matrix: &FrfMatrix,
    poles: &[ModelPole],
) -> Vec<PoleMetrics> {
    let described = data.predict(poles);
    let metrics = |pole: &ModelPole| {
        let lines = lines_of_pole(&data.frfs, pole);
        let of = |f: usize| {
            let values = data.frfs.values.of(f, lines.clone());
            let variances = data.noise.by_frf[f].variances(lines.clone());
            let powers = values.iter().zip(variances).map(|(h, v)| h.norm_sqr() / v);
            powers.sum::<f64>()
        };
        let whole: f64 = (0..data.frfs.functions()).map(of).sum();
        let reduced_chi_square = residual_chi_square(data, &described, pole);
        let values = (lines.len() * data.frfs.functions()) as f64;
        PoleMetrics {
            reduced_chi_square,
            misfit: ((reduced_chi_square - 1.0).max(0.0) * values / whole).sqrt(),
            contribution: (0.5 * pole.quality.significance().max(0.0) / whole).sqrt(),
            ghost_limit: 0.0,
            is_noise_below_misfit: data.noise.is_raised_to_misfit(),
            has_shifts: false,
            band_deviation: 0.0,
        }
    };
    let mut pole_metrics: Vec<PoleMetrics> = poles.par_iter().map(metrics).collect();
    let ghost_limit = |j: usize| {
        let least = |i: usize| GHOST_CONTRIBUTION * pole_metrics[i].contribution;
        let repeated = |i: &usize| {
            let (weak, other) = (&poles[j], &poles[*i]);
            let weaker = pole_metrics[j].contribution < least(*i) && inside_bandwidth(weak, other);
            weaker
                && (same_shape(weak, other) || same_shape_or_participation(frf_matrix, weak, other))
        };
        let others = (0..poles.len()).filter(repeated).map(least);
        others.fold(0.0, f64::max)
    };
    let ghost_limits: Vec<f64> = (0..poles.len()).into_par_iter().map(ghost_limit).collect();
    for (metrics, ghost_limit) in pole_metrics.iter_mut().zip(ghost_limits) {
        metrics.ghost_limit = ghost_limit;
    }
    pole_metrics
}

/// Whether a pole lies inside the resonance of another and is no wider than it by more than a
/// factor.
fn inside_bandwidth(pole: &ModelPole, other: &ModelPole) -> bool {
    let distance = (pole.lambda.im - other.lambda.im).abs();
    distance < MAX_DISTANCE_BANDWIDTHS * other.width()
        && pole.width() < MAX_WIDTH_RATIO * other.width()
}

fn same_shape(pole: &ModelPole, other: &ModelPole) -> bool {
    mac(&pole.residues, &other.residues) > Some(MIN_MAC_SAME_SHAPE)
}

/// Whether a single pole has the shape or the participation factors of another pole. An error of
/// the channels on one side (outputs or inputs) leaves the factors of the other side unchanged.
///
/// The fraction of a random vector of n values within the span of m others has a beta distribution
/// of m and n − m. Only a fraction above its quantile is significant.
fn same_shape_or_participation(
    frf_matrix: &FrfMatrix,
    pole: &ModelPole,
    other: &ModelPole,
) -> bool {
    if frf_matrix.inputs < 2 || pole.multiplicity() > 1 {
        return false;
    }
    let of = |pole: &ModelPole| linalg::singular_vectors(&frf_matrix.matrix(|f| pole.residues[f]));
    let (Ok(vectors), Ok(other_vectors)) = (of(pole), of(other)) else {
        return false;
    };
    let modes = other.multiplicity();
    let within = |vector: &ComplexMatrix, others: &ComplexMatrix| {
        let values = vector.nrows();
        if values <= modes {
            return false;
        }
        let product = |m: usize| -> Complex64 {
            let terms = (0..values).map(|i| others[(i, m)].conj() * vector[(i, 0)]);
            terms.sum()
        };
        let part: f64 = (0..modes).map(|m| product(m).norm_sqr()).sum();
        let distribution = Beta::new(modes as f64, (values - modes) as f64);
        let limit =
            distribution.map_or(1.0, |beta| beta.inverse_cdf(1.0 - FALSE_ALARM_PROBABILITY));
        part > limit.max(MIN_MAC_SAME_SHAPE)
    };
    within(&vectors.left, &other_vectors.left) || within(&vectors.right, &other_vectors.right)
}

/// Reduced chi-square of the residual of a model on the lines of a pole.
pub(in crate::identify) fn residual_chi_square(
    data: &FitData,
    described: &PredictedResponse,
    pole: &ModelPole,
) -> f64 {
    reduced_chi_square(
        data,
        &described.residual(lines_of_pole(&data.frfs, pole)),
        pole,
    )
}

/// Reduced chi-square of a given residual on the lines of a pole, without the force noise that FRFs
/// have in common.
pub(in crate::identify) fn reduced_chi_square(
    data: &FitData,
    residual: &Residual,
    pole: &ModelPole,
) -> f64 {
    let lines = lines_of_pole(&data.frfs, pole);
    let values = (lines.len() * data.frfs.functions()) as f64;
    let energy = |k: usize| {
        data.noise
            .noise_weighted_energy(&data.frfs, residual, k, |f| residual.at(f, k))
    };
    lines.map(energy).sum::<f64>() / values
}

/// Reduced chi-square of each FRF, force noise included.
pub(in crate::identify) fn reduced_chi_square_by_frf(
    data: &BandFrfs,
    residual: &Residual,
    pole: &ModelPole,
) -> Vec<f64> {
    let lines = lines_of_pole(data, pole);
    let of = |f: usize| {
        let squares = lines.clone().map(|k| residual.at(f, k).norm_sqr());
        squares.sum::<f64>() / lines.len() as f64
    };
    (0..data.functions()).map(of).collect()
}

/// Lines of a pole on which its reduced chi-square is measured.
pub(in crate::identify) fn lines_of_pole(data: &BandFrfs, pole: &ModelPole) -> Range<usize> {
    data.lines_around(pole.lambda, CHI_SQUARE_BANDWIDTHS)
}

/// Reason to reject a pole as spurious although it is above the noise.
///
/// A response that the model does not contain (a resonance that shifts between hits, a truncated
/// record, a rattle) is fitted by poles near the modes. These have a low contribution where the
/// model misfits the data or many phases are arbitrary; or they repeat the shape of a strong
/// neighbour with the phase of no normal mode; or their contribution is below the linearity of any
/// structure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) enum Rejection {
    /// Modal contribution, where the model misfits the data.
    LowContribution(f64),
    /// Phase difference from normal modes, rad.
    WrongPhase(f64),
    /// Modal contribution and its limit by the linearity of structures or by the errors of forces.
    BelowLinearity(f64, f64),
}

impl PoleMetrics {
    /// Factor of the standard deviations of the fit: a residual above the noise counts as noise.
    pub fn inflation(&self) -> f64 {
        if self.reduced_chi_square > STRICT_CHI_SQUARE {
            self.reduced_chi_square.sqrt()
        } else {
            1.0
        }
    }

    /// Contribution and misfit, as evidence that it is a mode.
    pub fn evidence(&self) -> Evidence {
        Evidence {
            contribution: self.contribution,
            misfit: self.misfit,
        }
    }

    /// Standard deviation of real and imaginary part of the pole, rad/s, with the effect of misfit
    /// and of narrower bands.
    pub fn pole_std(&self, pole: &ModelPole) -> f64 {
        (pole.quality.pole_std * self.inflation()).hypot(self.band_deviation)
    }
}

impl Rejection {
    /// Whether misfit of the model is the cause.
    pub fn is_misfit(&self) -> bool {
        !matches!(self, Self::BelowLinearity(..))
    }
}

/// Strictness of the rejection of poles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::identify) enum RejectionPolicy {
    /// The model fits the data: a pole above the noise is a mode unless a strong criterion rejects
    /// it.
    Standard,
    /// The model misfits the data at several poles.
    Strict,
    /// The model fits the data with poles of arbitrary phases ([`phases_scatter`]).
    ScatteredPhases,
}

/// Reason to reject a pole, if there is one.
pub(in crate::identify) fn rejection_reason(
    poles: &[ModelPole],
    pole_metrics: &[PoleMetrics],
    j: usize,
    policy: RejectionPolicy,
) -> Option<Rejection> {
    let (pole, metrics) = (&poles[j], &pole_metrics[j]);
    let strict = policy == RejectionPolicy::Strict;
    let least = match (pole.multiplicity() > 1, metrics.has_shifts) {
        (true, true) => MIN_CONTRIBUTION_REPEATED_SHIFTED,
        (true, false) => MIN_CONTRIBUTION_REPEATED,
        (false, _) => MIN_CONTRIBUTION_LINEARITY,
    };
    if metrics.contribution < least {
        return Some(Rejection::BelowLinearity(metrics.contribution, least));
    }
    let is_stronger = |i: usize| {
        pole_metrics[i].contribution > metrics.contribution
            && pole.separation(&poles[i]) < MAX_SEPARATION_BESIDE_STRONGER
    };
    let limit = MIN_CONTRIBUTION_BESIDE_STRONGER;
    let any_shifts = pole_metrics.iter().any(|metrics| metrics.has_shifts);
    if any_shifts && metrics.contribution < limit && (0..poles.len()).any(is_stronger) {
        return Some(Rejection::BelowLinearity(metrics.contribution, limit));
    }
    let most = if strict {
        STRICT_CHI_SQUARE
    } else {
        MAX_CHI_SQUARE
    };
    let limit = match policy {
        RejectionPolicy::ScatteredPhases => MIN_CONTRIBUTION_WITH_MISFIT,
        _ if metrics.reduced_chi_square <= most => 0.0,
        _ if metrics.is_noise_below_misfit => {
            MIN_CONTRIBUTION_WITH_MISFIT.min(SUFFICIENT_CONTRIBUTION_OVER_MISFIT * metrics.misfit)
        }
        _ => MIN_CONTRIBUTION_WITH_MISFIT,
    };
    if metrics.contribution < limit {
        return Some(Rejection::LowContribution(metrics.contribution));
    }
    let distance = |i: &usize| pole.separation(&poles[*i]);
    if metrics.contribution < metrics.ghost_limit {
        return Some(Rejection::BelowLinearity(
            metrics.contribution,
            metrics.ghost_limit,
        ));
    }
    let strong = |i: &usize| *i != j && pole_metrics[*i].contribution >= DOMINANT_CONTRIBUTION;
    let nearest = (0..poles.len())
        .filter(strong)
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    let repeats = distance(&nearest) < NEIGHBOUR_BANDWIDTHS && same_shape(pole, &poles[nearest]);
    if metrics.contribution >= DOMINANT_CONTRIBUTION || !(strict || repeats) {
        return None;
    }
    let (phase, other) = (residue_phase(pole), residue_phase(&poles[nearest]));
    // A delay of a channel rotates both.
    let apart = phase_between(phase, other).min(phase_between(phase, 0.0));
    (apart > MAX_PHASE_DIFFERENCE_RAD + phase_std(pole, metrics))
        .then_some(Rejection::WrongPhase(apart))
}

/// The pole with which the phase of a pole is compared: the nearest dominant mode, else the
/// strongest pole.
fn reference(poles: &[ModelPole], pole_metrics: &[PoleMetrics], j: usize) -> Option<usize> {
    let others = || (0..poles.len()).filter(|i| *i != j);
    let distance = |i: &usize| poles[j].separation(&poles[*i]);
    let strength = |i: &usize| poles[*i].quality.significance();
    others()
        .filter(|i| pole_metrics[*i].contribution >= DOMINANT_CONTRIBUTION)
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .or_else(|| others().max_by(|a, b| strength(a).total_cmp(&strength(b))))
}

/// Standard deviation of the phase of a pole, rad, with misfit as noise.
fn phase_std(pole: &ModelPole, metrics: &PoleMetrics) -> f64 {
    pole.quality.pole_std * metrics.reduced_chi_square.max(1.0).sqrt() / pole.decay()
}

/// Whether many poles are no modes of one structure: the strongest has a real shape, and a quarter
/// of all are no dominant modes and have shapes as much in quadrature as in phase with normal modes
/// and with the nearest dominant mode (the strongest pole where there is none).
///
/// With enough poles a model fits any smooth profile down to the noise. The residual does not show
/// such poles as spurious, but the arbitrary phases of their shapes do. With one or two FRFs every
/// shape is nearly real: only shapes more in quadrature than in phase count there.
pub(in crate::identify) fn phases_scatter(
    poles: &[ModelPole],
    pole_metrics: &[PoleMetrics],
) -> bool {
    let strength = |pole: &&ModelPole| pole.quality.significance();
    let strongest = poles
        .iter()
        .max_by(|a, b| strength(a).total_cmp(&strength(b)));
    let Some(strongest) = strongest else {
        return false;
    };
    if in_phase(strongest, residue_phase(strongest)) < MIN_REALNESS_STRONGEST {
        return false;
    }
    let few = strongest.residues.len() < MIN_FRFS_PHASE;
    let limit = if few { 0.0 } else { MAX_REALNESS_SCATTERED };
    let scattered = |j: &usize| {
        let (pole, metrics) = (&poles[*j], &pole_metrics[*j]);
        let other = reference(poles, pole_metrics, *j).map_or(0.0, |i| residue_phase(&poles[i]));
        let most = in_phase(pole, other).max(in_phase(pole, 0.0));
        // cos 2φ moves by 2 for each radian at most.
        metrics.contribution < DOMINANT_CONTRIBUTION
            && most + 2.0 * phase_std(pole, metrics) < limit
    };
    let count = (0..poles.len()).filter(scattered).count();
    count >= MIN_SCATTERED_POLES.max(poles.len().div_ceil(SCATTERED_ONE_IN))
}

/// Part of the residues of a pole in phase with normal modes rotated by `phase`, less the part in
/// quadrature: `−Re Σ a² e^(−2iφ) / Σ |a|²`.
fn in_phase(pole: &ModelPole, phase: f64) -> f64 {
    let turn = Complex64::from_polar(1.0, -2.0 * phase);
    let squares: Complex64 = pole.residues.iter().map(|a| a * a * turn).sum();
    -squares.re / pole.residues.iter().map(Complex64::norm_sqr).sum::<f64>()
}

/// A pole as a candidate.
///
/// Errors of real and imaginary part of λ have one standard deviation and are independent, and so
/// are those of frequency and damping: `σ_f = σ_λ/2π`, `σ_ζ = σ_λ √(1 − ζ²)/|λ|`.
pub(in crate::identify) fn candidate(pole: &ModelPole, metrics: &PoleMetrics) -> Candidate {
    let std = metrics.pole_std(pole);
    let (bias, along) = (pole.quality.bias, pole.lambda / pole.lambda.norm());
    Candidate {
        order: None,
        pole: Pole {
            lambda: pole.lambda,
        },
        participation: None,
        frequency_damping_correlation: Some(0.0),
        residues: Some(pole.residues.clone()),
        residue_stds: None,
        multiplicity: pole.multiplicity(),
        frequency_std_hz: Some(std / TAU),
        damping_std: Some(std * pole.lambda.im / pole.lambda.norm_sqr()),
        frequency_bias_hz: bias.map(|bias| (bias * along.conj()).re.abs() / TAU),
        damping_bias: bias.map(|bias| {
            let across = (bias * along.conj()).im.abs();
            across * pole.lambda.im / pole.lambda.norm_sqr()
        }),
        evidence: Some(metrics.evidence()),
        quality: None,
    }
}

/// Phase of all residues together, rad, modulo π: 0 for real modes.
fn residue_phase(pole: &ModelPole) -> f64 {
    let squares: Complex64 = pole.residues.iter().map(|a| a * a).sum();
    0.5 * (-squares).arg()
}

/// Distance of two phases modulo π, rad.
fn phase_between(a: f64, b: f64) -> f64 {
    let pi = std::f64::consts::PI;
    let apart = (a - b).rem_euclid(pi);
    apart.min(pi - apart)
}
