//! Noise model of receptances and its estimate from the residual of a fit.

use num_complex::Complex64;
use rayon::prelude::*;

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::residual::Rest;
use crate::identify::noise::force_noise::Shared;
use crate::identify::noise::line_correlation::Correlation;
use crate::identify::noise::residual_variance::{self, LeftOver, Source};
use crate::identify::noise::variance_model::Smooth;

/// Minimum number of FRFs whose profiles separate correlated noise from modes.
const MIN_FRFS: usize = 3;
/// Mean power of the residual above which it is more than noise.
const MAX_NOISE_POWER: f64 = 2.0;

/// Statistic of the residual from which noise variances are estimated when the data supply none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::identify) enum ToldFrom {
    /// Second differences: the noise is independent between frequency lines.
    Differences,
    /// Residual level: the noise is correlated between frequency lines.
    LevelOfNoise,
    /// Residual level including misfit: no small number of modes describes the data.
    LevelOfMisfit,
}

/// Noise model at some stage of an identification.
pub(in crate::identify) struct KnownNoise {
    variance: Vec<Vec<f64>>,
    by_force: Vec<Vec<f64>>,
    correlation: Correlation,
    shared: Shared,
    told_from: ToldFrom,
}

impl Receptances {
    /// Whether the noise is correlated between frequency lines although the data state no window;
    /// with its decay rate over the record, 1/s, where it decays.
    pub fn unstated_decay(&self) -> Option<Option<f64>> {
        let shared =
            self.told_from == ToldFrom::LevelOfNoise && self.correlation.differences_hold_little();
        shared.then(|| self.correlation.decay(self.step))
    }

    /// Estimates the noise of all FRFs and its line correlation from the residual of a fit, and
    /// divides the residual by that noise. To variances supplied with the data it adds force noise
    /// that they do not contain.
    pub fn tell_noise(&mut self, rest: &mut Rest) {
        self.estimate_noise(rest);
        if let Some(correlation) = Correlation::of_rest(rest) {
            self.correlation = correlation;
        }
    }

    /// Whether a residual above the second differences is correlated noise: each FRF has an
    /// independent profile, with strong correlation of adjacent lines and none of distant ones.
    /// Missing modes leave the same profile in all FRFs. The level of the residual then estimates
    /// the noise. Records under an unreported window have such noise.
    pub fn lines_share_noise(&mut self, rest: &mut Rest) -> bool {
        let stated = self.stated.iter().any(Option::is_some);
        let too_few_frfs = self.functions() < MIN_FRFS;
        let more_than_noise = rest.mean_power() > MAX_NOISE_POWER;
        let small_differences = self.correlation.differences_hold_little();
        if self.told_from != ToldFrom::Differences
            || stated
            || too_few_frfs
            || !more_than_noise && !small_differences
        {
            return false;
        }
        let before = (self.noise(), self.variance.clone());
        self.told_from = ToldFrom::LevelOfNoise;
        self.estimate_noise(rest);
        if let Some(correlation) = Correlation::of_own_noise(rest) {
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
        if self.told_from == ToldFrom::Differences {
            self.told_from = ToldFrom::LevelOfMisfit;
        }
    }

    fn estimate_noise(&mut self, rest: &mut Rest) {
        let difference_square = self.correlation.of_second_difference();
        let line_ratio = self.correlation.alike();
        let mut now = vec![Smooth::default(); self.functions()];
        for group in self.shared.groups() {
            let residual = |f: &usize| self.left_over(*f, rest, (difference_square, line_ratio));
            let smoothed = residual_variance::of_rest(group.par_iter().map(residual).collect());
            let scaled = |(f, smoothed): (&usize, Smooth)| (*f, self.as_receptance(*f, smoothed));
            let scaled: Vec<(usize, Smooth)> = group.par_iter().zip(smoothed).map(scaled).collect();
            for (f, smoothed) in scaled {
                now[f] = smoothed;
            }
        }
        let (now, by_force) = now
            .into_iter()
            .map(|smoothed| (smoothed.variance, smoothed.by_force))
            .unzip();
        let before = std::mem::replace(&mut self.variance, now);
        self.by_force = by_force;
        self.raise_variances();
        rest.over(&before, &self.variance);
        self.renew();
    }

    /// Copy of the noise model.
    pub fn noise(&self) -> KnownNoise {
        KnownNoise {
            variance: self.variance.clone(),
            by_force: self.by_force.clone(),
            correlation: self.correlation.clone(),
            shared: self.shared.clone(),
            told_from: self.told_from,
        }
    }

    /// Restores a noise model.
    pub fn set_noise(&mut self, snapshot: KnownNoise) {
        self.variance = snapshot.variance;
        self.by_force = snapshot.by_force;
        self.correlation = snapshot.correlation;
        self.shared = snapshot.shared;
        self.told_from = snapshot.told_from;
        self.renew();
    }

    /// Residual of FRF f, in its measured quantity.
    fn left_over(
        &self,
        f: usize,
        rest: &Rest,
        (difference_square, line_ratio): (f64, f64),
    ) -> LeftOver {
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
                Source::Stated(variances.map(squared).collect())
            }
            None if self.told_from == ToldFrom::Differences => {
                Source::SecondDifferences(difference_square)
            }
            None => Source::Level,
        };
        let measured: Vec<Complex64> = values.map(|(h, s)| h * s).collect();
        LeftOver::new(&measured, &residual, (source, line_ratio))
    }

    /// Variances of the receptance f from those of its measured quantity.
    fn as_receptance(&self, f: usize, measured: Smooth) -> Smooth {
        let variance = measured.variance.iter().zip(self.measured_scale[f].iter());
        let variance: Vec<f64> = variance.map(|(v, s)| v / (s * s)).collect();
        Smooth {
            by_force: match &self.stated[f] {
                Some(stated) => force_part(stated, &variance),
                None => measured.by_force,
            },
            variance,
        }
    }
}

/// Force fraction of increased variances, where the increase over the stated variance is response
/// noise.
fn force_part(stated: &Smooth, variance: &[f64]) -> Vec<f64> {
    let variances = stated.variance.iter().zip(&stated.by_force).zip(variance);
    variances
        .map(|((before, fraction), v)| 1.0 - (1.0 - fraction) * before / v)
        .collect()
}
