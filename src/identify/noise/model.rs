//! Noise model of receptances and its estimate from the residual of a fit.

use num_complex::Complex64;
use rayon::prelude::*;

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::residual::Residual;
use crate::identify::noise::force_noise::ForceNoise;
use crate::identify::noise::line_correlation::LineCorrelation;
use crate::identify::noise::residual_variance::{self, ResidualVariance, ResponseVariance};
use crate::identify::noise::variance_model::SmoothedVariance;

/// Minimum number of FRFs whose profiles separate correlated noise from modes.
const MIN_FRFS: usize = 3;
/// Mean power of the residual above which it is more than noise.
const MAX_NOISE_POWER: f64 = 2.0;

/// Statistic of the residual from which noise variances are estimated when the data supply none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::identify) enum VarianceSource {
    /// Second differences: the noise is independent between frequency lines.
    SecondDifferences,
    /// Residual level: the noise is correlated between frequency lines.
    Level,
    /// Residual level including misfit: no small number of modes describes the data.
    LevelWithMisfit,
}

/// Noise model at some stage of an identification.
pub(in crate::identify) struct NoiseSnapshot {
    variance: Vec<Vec<f64>>,
    force_fraction: Vec<Vec<f64>>,
    correlation: LineCorrelation,
    shared: ForceNoise,
    variance_source: VarianceSource,
}

impl BandFrfs {
    /// Whether the noise is correlated between frequency lines although the data state no window;
    /// with its decay rate over the record, 1/s, where it decays.
    pub fn unreported_window_decay(&self) -> Option<Option<f64>> {
        let shared = self.variance_source == VarianceSource::Level
            && self.correlation.has_small_second_differences();
        shared.then(|| self.correlation.decay(self.step))
    }

    /// Estimates the noise of all FRFs and its line correlation from the residual of a fit, and
    /// divides the residual by that noise. To variances supplied with the data it adds force noise
    /// that they do not contain.
    pub fn estimate_noise_and_correlation(&mut self, rest: &mut Residual) {
        self.estimate_noise(rest);
        if let Some(correlation) = LineCorrelation::from_residual(rest) {
            self.correlation = correlation;
        }
    }

    /// Whether a residual above the second differences is correlated noise: each FRF has an
    /// independent profile, with strong correlation of adjacent lines and none of distant ones.
    /// Missing modes leave the same profile in all FRFs. The level of the residual then estimates
    /// the noise. Records under an unreported window have such noise.
    pub fn detect_correlated_noise(&mut self, rest: &mut Residual) -> bool {
        let stated = self.stated.iter().any(Option::is_some);
        let too_few_frfs = self.functions() < MIN_FRFS;
        let more_than_noise = rest.mean_power() > MAX_NOISE_POWER;
        let small_differences = self.correlation.has_small_second_differences();
        if self.variance_source != VarianceSource::SecondDifferences
            || stated
            || too_few_frfs
            || !more_than_noise && !small_differences
        {
            return false;
        }
        let before = (self.noise(), self.variance.clone());
        self.variance_source = VarianceSource::Level;
        self.estimate_noise(rest);
        if let Some(correlation) = LineCorrelation::of_correlated_noise(rest) {
            self.correlation = correlation;
            self.estimate_noise(rest);
            return true;
        }
        let (noise, variance) = before;
        rest.over(&self.variance, &variance);
        self.set_noise(noise);
        false
    }

    /// Counts the whole residual as noise from now on, where the data have no variances.
    pub fn count_misfit_as_noise(&mut self) {
        // The level of correlated noise contains the misfit already.
        if self.variance_source == VarianceSource::SecondDifferences {
            self.variance_source = VarianceSource::LevelWithMisfit;
        }
    }

    fn estimate_noise(&mut self, rest: &mut Residual) {
        let difference_square = self.correlation.second_difference_square();
        let line_ratio = self.correlation.alike();
        let mut now = vec![SmoothedVariance::default(); self.functions()];
        for group in self.shared.groups() {
            let residual =
                |f: &usize| self.residual_of_frf(*f, rest, (difference_square, line_ratio));
            let smoothed =
                residual_variance::estimate_variances(group.par_iter().map(residual).collect());
            let scaled =
                |(f, smoothed): (&usize, SmoothedVariance)| (*f, self.as_receptance(*f, smoothed));
            let scaled: Vec<(usize, SmoothedVariance)> =
                group.par_iter().zip(smoothed).map(scaled).collect();
            for (f, smoothed) in scaled {
                now[f] = smoothed;
            }
        }
        let (now, force_fraction) = now
            .into_iter()
            .map(|smoothed| (smoothed.variance, smoothed.force_fraction))
            .unzip();
        let before = std::mem::replace(&mut self.variance, now);
        self.force_fraction = force_fraction;
        self.raise_to_dynamic_range();
        rest.over(&before, &self.variance);
        self.invalidate();
    }

    /// Copy of the noise model.
    pub fn noise(&self) -> NoiseSnapshot {
        NoiseSnapshot {
            variance: self.variance.clone(),
            force_fraction: self.force_fraction.clone(),
            correlation: self.correlation.clone(),
            shared: self.shared.clone(),
            variance_source: self.variance_source,
        }
    }

    /// Restores a noise model.
    pub fn set_noise(&mut self, snapshot: NoiseSnapshot) {
        self.variance = snapshot.variance;
        self.force_fraction = snapshot.force_fraction;
        self.correlation = snapshot.correlation;
        self.shared = snapshot.shared;
        self.variance_source = snapshot.variance_source;
        self.invalidate();
    }

    /// Residual of FRF f, in its measured quantity.
    fn residual_of_frf(
        &self,
        f: usize,
        rest: &Residual,
        (difference_square, line_ratio): (f64, f64),
    ) -> ResidualVariance {
        let scale = &self.measured_scale[f];
        let values = self.values[f].iter().zip(scale.iter());
        let deviations = self.variance[f].iter().zip(scale.iter());
        let residual = rest.of(f, 0..self.lines()).iter().zip(deviations);
        let residual: Vec<Complex64> = residual
            .map(|(rest, (v, s))| rest * (v.sqrt() * s))
            .collect();
        let squared = |(v, s): (&f64, &f64)| v * s * s;
        let source = match &self.stated[f] {
            Some(stated) => {
                let variances = stated.variance.iter().zip(scale.iter());
                ResponseVariance::Stated(variances.map(squared).collect())
            }
            None if self.variance_source == VarianceSource::SecondDifferences => {
                ResponseVariance::SecondDifferences(difference_square)
            }
            None => ResponseVariance::Level,
        };
        let measured: Vec<Complex64> = values.map(|(h, s)| h * s).collect();
        ResidualVariance::new(&measured, &residual, (source, line_ratio))
    }

    /// Variances of the receptance f from those of its measured quantity.
    fn as_receptance(&self, f: usize, measured: SmoothedVariance) -> SmoothedVariance {
        let variance = measured.variance.iter().zip(self.measured_scale[f].iter());
        let variance: Vec<f64> = variance.map(|(v, s)| v / (s * s)).collect();
        SmoothedVariance {
            force_fraction: match &self.stated[f] {
                Some(stated) => force_fraction_of_raised_variances(stated, &variance),
                None => measured.force_fraction,
            },
            variance,
        }
    }
}

/// Force fraction of increased variances, where the increase over the stated variance is response
/// noise.
fn force_fraction_of_raised_variances(stated: &SmoothedVariance, variance: &[f64]) -> Vec<f64> {
    let variances = stated
        .variance
        .iter()
        .zip(&stated.force_fraction)
        .zip(variance);
    variances
        .map(|((before, fraction), v)| 1.0 - (1.0 - fraction) * before / v)
        .collect()
}
