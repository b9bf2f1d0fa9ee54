//! The noise model holds the state of the noise in a fit: variances, force noise and line
//! correlation. A fit updates it from its residual, saves it before a trial, and restores it after
//! a rejected one.

use std::ops::Range;
use std::sync::Arc;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::frf::FrfSet;

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::line_noise::LineNoise;
use crate::identify::data::residual::Residual;
use crate::identify::noise::data_variance::{self, Noise};
use crate::identify::noise::force_noise::ForceNoise;
use crate::identify::noise::line_correlation::{LineCorrelation, median};
use crate::identify::noise::residual_variance::{
    ReferenceResidual, ResponseVariance, estimate_variances,
};
use crate::identify::noise::variance_model::SmoothedVariance;

/// Minimum number of FRFs whose profiles separate correlated noise from modes.
const MIN_FRFS: usize = 3;
/// Mean power of the residual above which it is more than noise.
const MAX_NOISE_POWER: f64 = 2.0;
/// Minimum noise of an FRF over the largest response: a dynamic range beyond that of any converter
/// (a 24-bit converter has 6e-8).
const MIN_NOISE_OVER_RESPONSE: f64 = 1e-8;
/// Noise over the response of an FRF below which the misfit of any model may exceed it.
const NEGLIGIBLE_NOISE_OVER_RESPONSE: f64 = 1e-5;
/// Minimum of such noise over the misfit of the initial poles.
///
/// Without noise, second differences are those of the response, smallest far from resonances: the
/// fit then follows a smooth misfit there (filters, aliases) with its poles and loses modes.
/// Larger: modes weaker than the misfit are not found. Test:
/// `aliases_near_the_band_edge_draw_no_pole_away`.
const MIN_NOISE_OVER_MISFIT: f64 = 0.03;

/// Maximum relative rounding of a variance whose standard deviation is held in single precision,
/// which is 1.2e-7. Smaller, at 0: noise at its minimum is not recognised as such.
const MAX_RELATIVE_ROUNDING: f64 = 1e-6;

/// Statistic of the residual from which noise variances are estimated when the data supply none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum VarianceSource {
    /// Second differences: the noise is independent between frequency lines.
    SecondDifferences,
    /// Residual level: the noise is correlated between frequency lines.
    Level,
    /// Residual level including misfit: no small number of modes describes the data.
    LevelWithMisfit,
}

/// Noise model of the FRFs of a band.
#[derive(Clone)]
pub(in crate::identify) struct NoiseModel {
    /// Noise of each FRF by line: the variance E|H − E H|², positive, and the fraction of it that
    /// is force noise, as far as it is estimated.
    pub by_frf: Vec<LineNoise>,
    /// Line correlation of the noise, as far as it is estimated.
    pub line_correlation: LineCorrelation,
    /// Force noise common to the FRFs of one reference, as far as it is estimated.
    pub force_noise: ForceNoise,
    /// Noise of each FRF as supplied with the data, where it was.
    stated: Vec<Option<LineNoise>>,
    /// Statistic that estimates the noise where the data have no variances.
    variance_source: VarianceSource,
    /// Minimum variance of each FRF, in its measured quantity.
    min_variances: Vec<f64>,
    /// Whether a minimum is that of the misfit.
    is_raised_to_misfit: bool,
    /// Whether the variances include the line correlation, as those of interpolated lines do.
    includes_correlation: bool,
}

/// Noise of an FRF before any residual exists.
#[derive(Clone)]
struct DataNoise {
    by_line: LineNoise,
    is_stated: bool,
    /// Common fraction of the force noise of its reference.
    common_fraction: f64,
}

impl NoiseModel {
    /// Noise of a set on the lines of a band, before any residual exists.
    pub fn new(set: &FrfSet, frfs: &BandFrfs) -> Self {
        let window = LineCorrelation::of_window(set.added_damping_rad_s, frfs.step, frfs.lines());
        let of_receptance = |f: usize, noise: Noise| {
            let variance = noise.variance.iter().zip(frfs.measured_scale[f].iter());
            let variance: Vec<f64> = variance.map(|(v, s)| v / (s * s)).collect();
            DataNoise {
                by_line: LineNoise::new(&variance, &noise.force_fraction),
                is_stated: noise.measured,
                common_fraction: noise.common_fraction,
            }
        };
        let noise = data_variance::noise_of_set(set, &frfs.lines_of_set, of_receptance);
        let common_fraction = |f: usize| noise[f].common_fraction;
        let force_noise = ForceNoise::from_variances(set.functions(), common_fraction, &window);
        let stated = |noise: &DataNoise| noise.is_stated.then(|| noise.by_line.clone());
        let stated = noise.iter().map(stated).collect();
        let mut model = Self {
            by_frf: noise.into_iter().map(|noise| noise.by_line).collect(),
            line_correlation: window,
            force_noise,
            stated,
            variance_source: VarianceSource::SecondDifferences,
            min_variances: min_variances(frfs),
            is_raised_to_misfit: false,
            includes_correlation: set.is_interpolated,
        };
        model.raise_to_dynamic_range(frfs);
        model
    }

    /// The noise of some of the FRFs, by their numbers.
    pub fn sample(&self, functions: &[usize]) -> Self {
        Self {
            by_frf: functions.iter().map(|f| self.by_frf[*f].clone()).collect(),
            line_correlation: self.line_correlation.clone(),
            force_noise: self.force_noise.sample(functions),
            stated: functions.iter().map(|f| self.stated[*f].clone()).collect(),
            variance_source: self.variance_source,
            min_variances: functions.iter().map(|f| self.min_variances[*f]).collect(),
            is_raised_to_misfit: self.is_raised_to_misfit,
            includes_correlation: self.includes_correlation,
        }
    }

    /// Whether the data supply the variances of all FRFs.
    pub fn is_stated(&self) -> bool {
        self.stated.iter().all(Option::is_some)
    }

    /// The noise of each FRF, where the data supply that of all FRFs.
    pub fn stated_noise(&self) -> Option<&[LineNoise]> {
        self.is_stated().then_some(&self.by_frf)
    }

    /// Standard deviation of the noise of an FRF at one line, m/N.
    pub fn std(&self, function: usize, line: usize) -> f64 {
        self.by_frf[function].std(line)
    }

    /// Mean variance of an FRF over some lines, (m/N)².
    pub fn mean_variance(&self, function: usize, lines: Range<usize>) -> f64 {
        self.by_frf[function].mean_variance(lines)
    }

    /// Whether the noise is correlated between frequency lines although the data state no window;
    /// with its decay rate over the record, 1/s, where it decays; `step` is the spacing of the
    /// lines, rad/s.
    pub fn unreported_window_decay(&self, step: f64) -> Option<Option<f64>> {
        let is_correlated = self.variance_source == VarianceSource::Level
            && self.line_correlation.has_small_second_differences();
        is_correlated.then(|| self.line_correlation.decay(step))
    }

    /// Estimates the noise of all FRFs and its line correlation from the residual of a fit, and
    /// divides the residual by that noise. To variances supplied with the data it adds force noise
    /// that they do not contain.
    pub fn estimate_variance_and_correlation(&mut self, frfs: &BandFrfs, rest: &mut Residual) {
        self.estimate_variance(frfs, rest);
        if self.includes_correlation {
            return;
        }
        if let Some(correlation) = LineCorrelation::from_residual(rest) {
            self.line_correlation = correlation;
        }
    }

    /// Estimates the force noise from the residual of a fit.
    pub fn estimate_force_noise(&mut self, frfs: &BandFrfs, rest: &Residual) {
        self.force_noise =
            self.force_noise
                .estimated_from(rest, frfs, &self.by_frf, &self.line_correlation);
    }

    /// Whether a residual above the second differences is correlated noise: each FRF has an
    /// independent profile, with strong correlation of adjacent lines and none of distant ones.
    /// Missing modes leave the same profile in all FRFs. The level of the residual then estimates
    /// the noise. Records under an unreported window have such noise.
    pub fn detect_correlated_noise(&mut self, frfs: &BandFrfs, rest: &mut Residual) -> bool {
        let stated = self.stated.iter().any(Option::is_some);
        let too_few_frfs = frfs.functions() < MIN_FRFS;
        let more_than_noise = rest.mean_power() > MAX_NOISE_POWER;
        let small_differences = self.line_correlation.has_small_second_differences();
        if self.variance_source != VarianceSource::SecondDifferences
            || stated
            || too_few_frfs
            || !more_than_noise && !small_differences
        {
            return false;
        }
        let before = self.clone();
        self.variance_source = VarianceSource::Level;
        self.estimate_variance(frfs, rest);
        if let Some(correlation) = LineCorrelation::of_correlated_noise(rest) {
            self.line_correlation = correlation;
            self.estimate_variance(frfs, rest);
            return true;
        }
        rest.rescale(&self.by_frf, &before.by_frf);
        *self = before;
        false
    }

    /// Counts the whole residual as noise from now on, where the data have no variances.
    pub fn count_misfit_as_noise(&mut self) {
        // The level of correlated noise contains the misfit already.
        if self.variance_source == VarianceSource::SecondDifferences {
            self.variance_source = VarianceSource::LevelWithMisfit;
        }
    }

    fn estimate_variance(&mut self, frfs: &BandFrfs, rest: &mut Residual) {
        let mut now = self.by_frf.clone();
        for group in self.force_noise.groups() {
            let residual = ResidualOfGroup {
                model: self,
                frfs,
                rest,
                group,
                lines_per_effective_line: self.line_correlation.lines_per_effective_line(),
            };
            let scaled = |index: usize, smoothed: SmoothedVariance| {
                let f = group[index];
                self.as_receptance(f, &frfs.measured_scale[f], smoothed)
            };
            let estimates = estimate_variances(&residual, scaled);
            for (f, noise) in group.iter().zip(estimates) {
                now[*f] = noise;
            }
        }
        let before = std::mem::replace(&mut self.by_frf, now);
        self.raise_to_dynamic_range(frfs);
        rest.rescale(&before, &self.by_frf);
    }

    /// Raises every variance to [`MIN_NOISE_OVER_RESPONSE`] of the strongest response: a far weaker
    /// FRF (in a direction that symmetry keeps at rest) is no response, whatever its variance. The
    /// minimum is constant over the lines in the measured quantity, as noise is.
    fn raise_to_dynamic_range(&mut self, frfs: &BandFrfs) {
        let (min_variances, scales) = (&self.min_variances, &frfs.measured_scale);
        let raise = |(f, noise): (usize, &mut LineNoise)| {
            noise.raise(scales[f].iter().map(|s| min_variances[f] / (s * s)));
        };
        self.by_frf.par_iter_mut().enumerate().for_each(raise);
    }

    /// Whether the noise is so low that the misfit of a good model can be larger, in all FRFs whose
    /// noise is above the minimum.
    pub fn may_be_below_misfit(&self, frfs: &BandFrfs) -> bool {
        let is_low = |f: usize| {
            let scales = frfs.measured_scale[f].iter();
            let values = frfs.values.all_of(f);
            let power = values.iter().zip(scales.clone());
            let power: f64 = power.map(|(h, s)| h.norm_sqr() * s * s).sum();
            let noise = self.by_frf[f].variances(0..frfs.lines()).zip(scales);
            let noise = median(noise.map(|(v, s)| v * s * s).collect());
            let limit = NEGLIGIBLE_NOISE_OVER_RESPONSE.powi(2) * power / frfs.lines() as f64;
            noise <= (1.0 + MAX_RELATIVE_ROUNDING) * self.min_variances[f] || noise < limit
        };
        (0..frfs.functions()).all(is_low)
    }

    /// Whether the noise was raised to a fraction of the misfit.
    pub fn is_raised_to_misfit(&self) -> bool {
        self.is_raised_to_misfit
    }

    /// Raises the minimum of the noise of each FRF to a fraction of its misfit, constant over the
    /// lines in the measured quantity: of the median of the squared residual.
    pub fn raise_to_misfit(&mut self, frfs: &BandFrfs, rest: &Residual) {
        for f in 0..frfs.functions() {
            let residual = rest.of(f, 0..frfs.lines());
            let variances = self.by_frf[f].variances(0..frfs.lines());
            let scales = variances.zip(frfs.measured_scale[f].iter());
            let squares = residual
                .zip(scales)
                .map(|(r, (v, s))| r.norm_sqr() * v * s * s);
            let misfit = median(squares.collect()) / std::f64::consts::LN_2;
            let floor = MIN_NOISE_OVER_MISFIT.powi(2) * misfit;
            self.is_raised_to_misfit |= floor > self.min_variances[f];
            self.min_variances[f] = self.min_variances[f].max(floor);
        }
        self.raise_to_dynamic_range(frfs);
    }

    /// Noise of the receptance f from that of its measured quantity.
    fn as_receptance(&self, f: usize, scale: &[f64], measured: SmoothedVariance) -> LineNoise {
        let variance = measured.variance.iter().zip(scale);
        let variance: Vec<f64> = variance.map(|(v, s)| v / (s * s)).collect();
        match &self.stated[f] {
            Some(stated) => {
                let force_fraction = force_fraction_of_raised_variances(stated, &variance);
                LineNoise::new(&variance, &force_fraction)
            }
            None => LineNoise::new(&variance, &measured.force_fraction),
        }
    }
}

/// Residual of the FRFs of one reference, over the noise as estimated before.
struct ResidualOfGroup<'a> {
    model: &'a NoiseModel,
    frfs: &'a BandFrfs,
    rest: &'a Residual,
    group: &'a [usize],
    lines_per_effective_line: f64,
}

impl ReferenceResidual for ResidualOfGroup<'_> {
    fn functions(&self) -> usize {
        self.group.len()
    }

    fn lines(&self) -> usize {
        self.frfs.lines()
    }

    fn values(&self, function: usize, lines: Range<usize>) -> Vec<Complex64> {
        let f = self.group[function];
        let values = self.frfs.values.of(f, lines.clone());
        let values = values.iter().zip(&self.frfs.measured_scale[f][lines]);
        values.map(|(h, s)| h * s).collect()
    }

    fn residual(&self, function: usize, lines: Range<usize>) -> Vec<Complex64> {
        let f = self.group[function];
        let stds = self.model.by_frf[f].stds(lines.clone());
        let stds = stds.zip(&self.frfs.measured_scale[f][lines.clone()]);
        let residual = self.rest.of(f, lines).zip(stds);
        residual.map(|(rest, (std, s))| rest * (std * s)).collect()
    }

    fn source(&self, function: usize) -> ResponseVariance {
        match &self.model.stated[self.group[function]] {
            Some(_) => ResponseVariance::Stated,
            None if self.model.variance_source == VarianceSource::SecondDifferences => {
                let of_unit = self.model.line_correlation.second_difference_square();
                ResponseVariance::SecondDifferences(of_unit)
            }
            None => ResponseVariance::Level,
        }
    }

    fn stated(&self, function: usize) -> Option<Vec<f64>> {
        let f = self.group[function];
        let stated = self.model.stated[f].as_ref()?;
        let scale = self.frfs.measured_scale[f].iter();
        let variances = stated.variances(0..self.lines()).zip(scale);
        Some(variances.map(|(v, s)| v * s * s).collect())
    }

    fn lines_per_effective_line(&self) -> f64 {
        self.lines_per_effective_line
    }
}

/// Minimum variance of each FRF, in its measured quantity.
fn min_variances(frfs: &BandFrfs) -> Vec<f64> {
    let mut strongest = vec![0.0f64; frfs.lines()];
    for f in 0..frfs.functions() {
        let values = frfs.values.all_of(f);
        for (largest, h) in strongest.iter_mut().zip(values.iter()) {
            *largest = largest.max(h.norm_sqr());
        }
    }
    let floor = |scale: &Arc<Vec<f64>>| {
        let powers = strongest.iter().zip(scale.iter()).map(|(p, s)| p * s * s);
        MIN_NOISE_OVER_RESPONSE * MIN_NOISE_OVER_RESPONSE * powers.sum::<f64>()
            / frfs.lines() as f64
    };
    frfs.measured_scale.par_iter().map(floor).collect()
}

/// Force fraction of increased variances, where the increase over the stated variance is response
/// noise.
fn force_fraction_of_raised_variances(stated: &LineNoise, variance: &[f64]) -> Vec<f64> {
    let lines = 0..variance.len();
    let fractions = stated.force_fractions(lines.clone());
    let raised = |((k, before), v): ((usize, f64), &f64)| {
        let fraction = fractions.map_or(0.0, |fractions| f64::from(fractions[k]));
        1.0 - (1.0 - fraction) * before / v
    };
    let variances = stated.variances(lines).enumerate().zip(variance);
    variances.map(raised).collect()
}
