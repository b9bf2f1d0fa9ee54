//! Order selection: how many poles the data support, by BIC and by prediction of held-out lines.
//!
//! Over the noise of each FRF (level × profile, as the fit weights it), the lines are out-of-band
//! terms + poles + noise. The out-of-band terms are constant, slope and poles clustered towards the
//! ends of the band, so that modes outside it count as no pole. Poles are added one by one: the
//! identified ones, then the other stable poles, each time the one that explains most of the
//! residual, with all amplitudes fitted again (orthogonal least squares: Chen, Billings and Luo
//! 1989, International Journal of Control 50). With `q` the profile `1/(iω − λ)` of a pole after
//! orthogonalisation to the others, of length 1, FRF f gains
//!
//! `g_f = 2 |qᴴe_f|² / Σ_k |q_k|² var_fk`, chi-squared with two degrees of freedom where there is
//! no such pole,
//!
//! raised for line correlation. An FRF contains the pole where the gain exceeds its cost, so that
//! one pole changes `BIC = −2 ln L + k ln N` by `2 ln N − Σ_f max(0, g_f − 2 ln N)`, with `N`
//! independent real numbers of the data (Schwarz 1978, Annals of Statistics 6). Held-out lines T
//! are predicted with errors `(1 − H)⁻¹ e` of covariance `C = (1 − H)⁻¹`, with the residual `e` and
//! the hat matrix `H` on them (Allen 1974, Technometrics 16). Of T only n lines S in the middle are
//! scored, as lines correlated with the fitted ones predict themselves (hv-block: Racine 2000,
//! Journal of Econometrics 99), by their predictive density: `−ln p = n ln π + x_SᴴC_SS⁻¹x_S + ln
//! det C_SS` with `x = Ce` (Geisser and Eddy 1979, Journal of the American Statistical Association
//! 74). Too few poles leave a large e, too many predict with large covariances. The poles keep
//! their values from the fit to all lines.

use std::cmp::Reverse;
use std::ops::Range;

use num_complex::Complex64;

use crate::axis::Band;
use crate::frf::FrfSet;
use crate::linalg::{self, ComplexMatrix};
use crate::modal::Pole;

use crate::identify::Identification;
use crate::identify::data::out_of_band_basis::{OutOfBandBasis, OutOfBandTerms};
use crate::identify::data::residual::Residual;
use crate::identify::error::IdentifyError;
use crate::identify::estimator::PoleStatus;
use crate::identify::fit::fit_data::FitData;
use crate::identify::noise::band_profile::BandProfile;

/// Minimum length of a profile after orthogonalisation, over its length before.
const MIN_PROFILE_LENGTH: f64 = 1e-6;
/// Other stable poles that are tried for each identified pole, and their minimum.
const OTHERS_PER_POLE: usize = 1;
const MIN_OTHERS: usize = 4;
/// Maximum length of a held-out segment, lines.
const MAX_SEGMENT_LINES: usize = 8;
/// Maximum mean leverage of the out-of-band terms on a segment that is predicted: above it, at the
/// ends of the band, nothing else predicts the segment.
const MAX_BACKGROUND_LEVERAGE: f64 = 0.5;
/// Minimum number of segments for a standard error.
const MIN_SEGMENTS: usize = 8;
/// Maximum mean square of the residual of a selected model, over the minimum of all.
const MAX_RESIDUAL_RATIO: f64 = 1.1;

/// Predictive score of held-out values: `−ln p − ln π` of each, 1 for noise that is predicted
/// without error. Lines at the ends of the band with a high leverage of the out-of-band terms do
/// not count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictiveScore {
    /// Mean.
    pub mean: f64,
    /// Standard error of its difference from the minimum, by the scatter of the differences over
    /// segments.
    pub std: f64,
}

/// Quality of the model of the first poles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrderStep {
    /// The last of them; `None` for the out-of-band terms alone.
    pub pole: Option<Pole>,
    /// Whether that pole was identified, and is not just a stable pole.
    pub identified: bool,
    /// Number of FRFs that contain it.
    pub holding: usize,
    /// BIC minus that of the out-of-band terms alone.
    pub bic: f64,
    /// Score of held-out lines; `None` where a pole depends on the held-out lines alone, or where
    /// too few lines are predicted.
    pub predicted: Option<PredictiveScore>,
    /// Reduced chi-square: mean square of the residual per degree of freedom. Below 1 where force
    /// noise is correlated between lines: the fit absorbs part of it.
    pub rest: f64,
}

/// Result of the order selection.
#[derive(Clone, Debug, PartialEq)]
pub struct OrderSelection {
    /// Number of FRFs.
    pub functions: usize,
    /// Number of lines.
    pub lines: usize,
    /// Number of lines that are predicted together; above 1, as many on either side are held out.
    pub segment_lines: usize,
    /// Whether the data supply the noise of every FRF; else it is estimated from the residual.
    pub noise_stated: bool,
    /// Number of identified poles; a repeated one counts once.
    pub identified: usize,
    /// Models with no pole, one, two, ...
    pub tried: Vec<OrderStep>,
}

impl OrderSelection {
    /// Number of poles with the minimum BIC.
    pub fn by_bic(&self) -> usize {
        let all = self.tried.iter().enumerate();
        let minimum = all.min_by(|a, b| a.1.bic.total_cmp(&b.1.bic));
        minimum.map_or(0, |(count, _)| count)
    }

    /// Minimum number of poles whose prediction of held-out lines is as good as the best, within
    /// one standard error (Breiman, Friedman, Olshen and Stone 1984, Classification and Regression
    /// Trees, 3.4.3); `None` where too few lines can be predicted.
    pub fn by_prediction(&self) -> Option<usize> {
        let scores = self.tried.iter().filter_map(|step| step.predicted);
        let minimum = scores.map(|score| score.mean).reduce(f64::min)?;
        let as_good = |step: &OrderStep| {
            let score = step.predicted;
            score.is_some_and(|score| score.mean - minimum <= score.std)
        };
        self.tried.iter().position(as_good)
    }

    /// Minimum number of poles whose residual is at most a tenth above that of any number up to the
    /// one with the minimum BIC.
    pub fn by_residual(&self) -> usize {
        let minimum = self
            .tried
            .iter()
            .take(self.by_bic() + 1)
            .map(|step| step.rest);
        let minimum = minimum.fold(f64::INFINITY, f64::min);
        let small = |step: &OrderStep| step.rest <= MAX_RESIDUAL_RATIO * minimum;
        self.tried.iter().position(small).unwrap_or(0)
    }
}

/// Order selection for a set: the poles of an identification in a band, then the other stable poles
/// of its stabilization diagram.
///
/// # Errors
/// [`IdentifyError`] when set and band do not match.
pub fn support(
    set: &FrfSet,
    band: Band,
    identification: &Identification,
) -> Result<OrderSelection, IdentifyError> {
    let mut data = FitData::new(set, band)?;
    let identified = identified_poles(identification, set.added_damping_rad_s);
    let others = other_stable_poles(identification, set.added_damping_rad_s, band, &identified);
    // The residual of the identified poles gives the noise level and its line correlation.
    let mut first = Fitted::new(&data);
    for lambda in &identified {
        first.add_pole(Candidate::of(*lambda, &first));
    }
    let mut rest = Residual::of_all(&first.over_noise());
    data.estimate_noise(&mut rest);
    data.detect_correlated_noise(&mut rest);
    let mut fitted = Fitted::new(&data);
    let mut tried = vec![fitted.order_step(None)];
    let mut scores = vec![fitted.scores()];
    for (identified, all) in [(true, &identified), (false, &others)] {
        let mut candidates: Vec<Candidate> = all
            .iter()
            .map(|pole| Candidate::of(*pole, &fitted))
            .collect();
        while let Some((candidate, gains)) = fitted.take_best_candidate(&mut candidates) {
            let lambda = candidate.lambda;
            fitted.add_pole(candidate);
            fitted.apply_gains(&gains);
            let lambda = lambda + set.added_damping_rad_s;
            tried.push(fitted.order_step(Some((Pole { lambda }, identified, &gains))));
            scores.push(fitted.scores());
        }
    }
    for (tried, predicted) in tried.iter_mut().zip(predictive_scores(&scores)) {
        tried.predicted = predicted;
    }
    Ok(OrderSelection {
        functions: data.frfs.functions(),
        lines: data.frfs.lines(),
        segment_lines: fitted.segment_lines,
        noise_stated: data.noise.is_stated(),
        identified: tried.iter().filter(|step| step.identified).count(),
        tried,
    })
}

/// Means of `−ln p − ln π`, with the standard error of each difference from the minimum.
fn predictive_scores(scores: &[Option<Vec<f64>>]) -> Vec<Option<PredictiveScore>> {
    let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
    let valid = scores.iter().flatten();
    let minimum = valid.min_by(|a, b| mean(a).total_cmp(&mean(b)));
    let summary = |score: &Option<Vec<f64>>| {
        let (score, minimum) = (score.as_ref()?, minimum?);
        let differences: Vec<f64> = score.iter().zip(minimum).map(|(a, b)| a - b).collect();
        let (count, middle) = (score.len() as f64, mean(&differences));
        let square: f64 = differences.iter().map(|d| (d - middle).powi(2)).sum();
        (score.len() >= MIN_SEGMENTS).then(|| PredictiveScore {
            mean: mean(score),
            std: (square / (count - 1.0) / count).sqrt(),
        })
    };
    scores.iter().map(summary).collect()
}

/// Poles of the identified modes with the damping of the data, each once.
fn identified_poles(identification: &Identification, added_damping_rad_s: f64) -> Vec<Complex64> {
    let mut all: Vec<Complex64> = Vec::new();
    for pole in identification
        .model
        .modes
        .iter()
        .filter_map(|mode| mode.pole())
    {
        let lambda = pole.lambda - added_damping_rad_s;
        if !all.contains(&lambda) {
            all.push(lambda);
        }
    }
    all
}

/// Stable poles that became no mode, with the damping of the data, from the highest orders down,
/// each at least a decay rate from the others and from the identified poles.
fn other_stable_poles(
    identification: &Identification,
    added_damping_rad_s: f64,
    band: Band,
    identified: &[Complex64],
) -> Vec<Complex64> {
    let stable = identification.stabilization.iter();
    let mut stable: Vec<_> = stable
        .filter(|point| point.status == PoleStatus::Stable)
        .filter(|point| {
            point.pole.lambda.re < 0.0 && band.contains(point.pole.natural_frequency_hz())
        })
        .collect();
    stable.sort_by_key(|point| Reverse(point.order));
    let max_others = (OTHERS_PER_POLE * identified.len()).max(MIN_OTHERS);
    let mut chosen: Vec<Complex64> = Vec::new();
    for point in stable {
        let lambda = point.pole.lambda - added_damping_rad_s;
        let near =
            |other: &Complex64| (other - lambda).norm() < lambda.re.abs().max(other.re.abs());
        if chosen.len() < max_others && !identified.iter().chain(&chosen).any(near) {
            chosen.push(lambda);
        }
    }
    chosen
}

/// Frequency profile of a candidate pole, orthogonal to the fitted columns, of length 1.
struct Candidate {
    lambda: Complex64,
    /// One column.
    values: ComplexMatrix,
    /// Length before normalisation, over that before orthogonalisation.
    length: f64,
}

impl Candidate {
    fn of(lambda: Complex64, fitted: &Fitted) -> Self {
        let value = |k: usize, _| {
            (Complex64::new(0.0, fitted.data.frfs.omega[k]) - lambda).inv()
                / fitted.noise_profile[k]
        };
        let mut candidate = Self {
            lambda,
            values: linalg::complex_matrix(fitted.data.frfs.lines(), 1, value),
            length: 1.0,
        };
        candidate.normalise();
        candidate.length = 1.0;
        candidate.orthogonalise(&fitted.basis);
        candidate
    }

    fn normalise(&mut self) {
        let length = self.values.norm_l2();
        if length > 0.0 {
            self.length *= length;
            linalg::for_each_column(&mut self.values, |_, column| {
                column.iter_mut().for_each(|value| *value /= length);
            });
        }
    }

    /// Twice, as one pass leaves rounding errors of a nearly dependent profile.
    fn orthogonalise(&mut self, basis: &ComplexMatrix) {
        for _ in 0..2 {
            let components = linalg::adjoint_product(basis, self.values.as_ref());
            self.values = linalg::subtract_product(self.values.as_ref(), basis, &components);
            self.normalise();
        }
    }
}

/// Fit of out-of-band terms and poles to all lines.
struct Fitted<'a> {
    data: &'a FitData,
    /// Relative profile of the noise over the lines.
    noise_profile: Vec<f64>,
    /// Variance of every value over that of level and profile: by FRF and line.
    ratio: Vec<Vec<f64>>,
    /// Orthonormal columns over the noise: lines × columns.
    basis: ComplexMatrix,
    /// Residual, over level and profile: lines × FRFs.
    rest: ComplexMatrix,
    /// Degrees of freedom of the columns in lines of noise: 1 each where noise is white.
    used_freedom: f64,
    segment_lines: usize,
    /// Segments that are predicted.
    segments: Vec<Range<usize>>,
    /// ln N.
    ln_count: f64,
    bic: f64,
}

impl<'a> Fitted<'a> {
    fn new(data: &'a FitData) -> Self {
        let (lines, functions) = (data.frfs.lines(), data.frfs.functions());
        let BandProfile {
            level,
            noise_profile,
        } = BandProfile::new(&data.noise, 0..lines);
        let background =
            OutOfBandBasis::new(&data.frfs.omega, &(0..lines), &OutOfBandTerms::Anywhere);
        let ratio = |f: usize| {
            let pairs = data.noise.by_frf[f].variances(0..lines).zip(&noise_profile);
            let ratios = pairs.map(|(v, c)| v / (level[f] * c).powi(2));
            ratios.collect::<Vec<f64>>()
        };
        let value = |k: usize, f: usize| data.frfs.values.at(f, k) / (level[f] * noise_profile[k]);
        let lines_per_effective_line = data.noise.line_correlation.lines_per_effective_line();
        let segment_lines = (lines_per_effective_line.round() as usize).clamp(1, MAX_SEGMENT_LINES);
        let mut fitted = Self {
            ratio: (0..functions).map(ratio).collect(),
            basis: linalg::complex_matrix(lines, 0, |_, _| Complex64::ZERO),
            rest: linalg::complex_matrix(lines, functions, value),
            used_freedom: 0.0,
            segment_lines,
            segments: Vec::new(),
            ln_count: (2.0 * (lines * functions) as f64 / lines_per_effective_line).ln(),
            bic: 0.0,
            data,
            noise_profile,
        };
        let basis = background.basis(&data.frfs.omega, &fitted.noise_profile);
        fitted.add(&basis, lines_per_effective_line);
        let all = (0..lines).step_by(segment_lines);
        let all = all.map(|k| k..(k + segment_lines).min(lines));
        let leverage = |segment: &Range<usize>, hat: &ComplexMatrix| {
            let diagonal = (0..hat.nrows()).map(|k| hat[(k, k)].re);
            diagonal.sum::<f64>() / segment.len() as f64
        };
        fitted.segments = all
            .filter(|lines| leverage(lines, &fitted.hat(lines)) < MAX_BACKGROUND_LEVERAGE)
            .collect();
        fitted
    }

    /// Hat matrix `H` of some lines.
    fn hat(&self, lines: &Range<usize>) -> ComplexMatrix {
        let rows = self.basis.subrows(lines.start, lines.len());
        rows * rows.adjoint()
    }

    /// Adds columns to the fit, each with the degrees of freedom of `noise_factor` lines.
    fn add(&mut self, columns: &ComplexMatrix, noise_factor: f64) {
        let amplitudes = linalg::adjoint_product(columns, self.rest.as_ref());
        self.rest = linalg::subtract_product(self.rest.as_ref(), columns, &amplitudes);
        self.used_freedom += noise_factor * columns.ncols() as f64;
        let first = self.basis.ncols();
        let column = |k: usize, c: usize| match c.checked_sub(first) {
            None => self.basis[(k, c)],
            Some(c) => columns[(k, c)],
        };
        self.basis = linalg::complex_matrix(columns.nrows(), first + columns.ncols(), column);
    }

    /// Adds a pole, unless its profile is a combination of those already fitted.
    fn add_pole(&mut self, mut candidate: Candidate) {
        candidate.orthogonalise(&self.basis);
        if candidate.length > MIN_PROFILE_LENGTH {
            self.add(&candidate.values, self.noise_factor(candidate.lambda));
        }
    }

    /// Removes the candidate that lowers BIC most from the list; returns it with its gains by FRF.
    fn take_best_candidate(
        &self,
        candidates: &mut Vec<Candidate>,
    ) -> Option<(Candidate, Vec<f64>)> {
        for candidate in candidates.iter_mut() {
            candidate.orthogonalise(&self.basis);
        }
        candidates.retain(|candidate| candidate.length > MIN_PROFILE_LENGTH);
        let gains: Vec<Vec<f64>> = candidates.iter().map(|pole| self.gains(pole)).collect();
        let decrease = |index: &usize| self.bic_decrease(&gains[*index]);
        let best = (0..candidates.len()).max_by(|a, b| decrease(a).total_cmp(&decrease(b)))?;
        Some((candidates.swap_remove(best), gains[best].clone()))
    }

    /// `g_f` of every FRF.
    fn gains(&self, candidate: &Candidate) -> Vec<f64> {
        let amplitudes = linalg::adjoint_product(&candidate.values, self.rest.as_ref());
        let noise_factor = self.noise_factor(candidate.lambda);
        let gain = |f: usize| {
            let terms = candidate.values.col_as_slice(0).iter().zip(&self.ratio[f]);
            let variance: f64 = terms.map(|(q, ratio)| q.norm_sqr() * ratio).sum();
            2.0 * amplitudes[(0, f)].norm_sqr() / (noise_factor * variance)
        };
        (0..self.data.frfs.functions()).map(gain).collect()
    }

    /// Variance of the amplitude of a pole over that in white noise.
    fn noise_factor(&self, lambda: Complex64) -> f64 {
        let correlation = &self.data.noise.line_correlation;
        correlation.amplitude_noise_factor(-lambda.re, self.data.frfs.step)
    }

    /// Decrease of BIC by a pole with these gains.
    fn bic_decrease(&self, gains: &[f64]) -> f64 {
        let net = gains
            .iter()
            .map(|gain| (gain - 2.0 * self.ln_count).max(0.0));
        net.sum::<f64>() - 2.0 * self.ln_count
    }

    fn apply_gains(&mut self, gains: &[f64]) {
        self.bic -= self.bic_decrease(gains);
    }

    fn order_step(&self, last: Option<(Pole, bool, &[f64])>) -> OrderStep {
        let free = (self.rest.nrows() as f64 - self.used_freedom).max(1.0);
        let energy = self.over_noise().squared_norm_l2();
        let contains_pole = |gain: &&f64| **gain > 2.0 * self.ln_count;
        OrderStep {
            pole: last.map(|(pole, _, _)| pole),
            identified: last.is_some_and(|(_, identified, _)| identified),
            holding: last.map_or(0, |(_, _, gains)| {
                gains.iter().filter(contains_pole).count()
            }),
            bic: self.bic,
            predicted: None,
            rest: energy / (free * self.rest.ncols() as f64),
        }
    }

    /// Residual over the noise of each value.
    fn over_noise(&self) -> ComplexMatrix {
        let mut values = self.rest.clone();
        linalg::for_each_column(&mut values, |f, column| {
            for (value, ratio) in column.iter_mut().zip(&self.ratio[f]) {
                *value /= ratio.sqrt();
            }
        });
        values
    }

    /// `−ln p − ln π` for each value of every segment, predicted from the lines outside it and
    /// outside the neighbours whose noise is correlated with it.
    fn scores(&self) -> Option<Vec<f64>> {
        let residual = self.over_noise();
        let guard = if self.segment_lines > 1 {
            self.segment_lines
        } else {
            0
        };
        let score = |segment: &Range<usize>| {
            let start = segment.start.saturating_sub(guard);
            let out = start..(segment.end + guard).min(residual.nrows());
            let hat = self.hat(&out);
            let identity = |r: usize, c: usize| Complex64::from(f64::from(u8::from(r == c)));
            let precision =
                linalg::complex_matrix(out.len(), out.len(), |r, c| identity(r, c) - hat[(r, c)]);
            let covariance = linalg::inverse_hermitian(&precision)?;
            let errors = &covariance * residual.subrows(out.start, out.len());
            let (first, size) = (segment.start - out.start, segment.len());
            let errors = errors.subrows(first, size);
            let element = |r: usize, c: usize| covariance[(first + r, first + c)];
            let covariance = linalg::complex_matrix(size, size, element);
            let weighted = linalg::inverse_hermitian(&covariance)? * errors;
            let functions = weighted.ncols();
            let square = |f: usize| -> f64 {
                (0..size)
                    .map(|k| (errors[(k, f)].conj() * weighted[(k, f)]).re)
                    .sum()
            };
            let mean = (0..functions).map(square).sum::<f64>() / functions as f64;
            let score = (mean + covariance.determinant().re.ln()) / size as f64;
            score.is_finite().then_some(score)
        };
        self.segments.iter().map(score).collect()
    }
}
