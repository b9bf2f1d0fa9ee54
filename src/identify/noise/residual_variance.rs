//! The estimator of the noise variance of each FRF separates response noise and force noise in the
//! residual of the current fit.
//!
//! Model: `v = a + b |H|²` ([`variance_model`](crate::identify::noise::variance_model)). `a` is the
//! response noise of one FRF; `b` is the force noise, common to all FRFs of one reference.
//!
//! - `a`: the variance supplied with the data; else the second differences of the residual, which a
//!   missing mode hardly changes; else the level of the residual.
//! - `b` between resonances, where it may exceed `a`: from second differences, jointly with `a`,
//!   because a missing mode adds little to them there.
//! - `b` at resonances: from the residual itself, with `a` fixed.

use num_complex::Complex64;
use rayon::prelude::*;

use crate::identify::noise::data_variance::{NoiseSquares, raise_to_minimum};
use crate::identify::noise::variance_model::{self, SmoothedVariance, VarianceSamples};

/// Number of estimates of the response noise with the force noise subtracted, and its minimum over
/// the estimate without: medians of some hundred lines scatter no more.
const JOINT_ESTIMATES: usize = 2;
const MIN_RESPONSE_NOISE_RATIO: f64 = 0.1;
/// Maximum power of a line outside resonances, over the median.
const MAX_POWER_OVER_MEDIAN: f64 = 30.0;
/// Maximum mean square of the logarithm of variances over their common profile: for running medians
/// of white noise it is 0.023 (simulated).
const MAX_LOG_SCATTER: f64 = 0.035;
/// Lines whose sums fit into the nearest cache.
const CACHE_LINES: usize = 1024;

/// Residual of one FRF, from which its noise is estimated.
pub(in crate::identify) struct ResidualVariance {
    /// Squared residual at every line, with |H|² as measured and the variance of the response
    /// noise.
    samples: VarianceSamples,
    /// Squares that estimate the response noise, where the data supply no variance.
    squares: Option<NoiseSquares>,
    /// |H|² of the fit alone, which contains no noise of the line.
    fitted: Vec<f64>,
}

/// Source of the response noise of an FRF.
pub(in crate::identify) enum ResponseVariance {
    /// Variances supplied with the data.
    Stated(Vec<f64>),
    /// Second differences of the residual; with the mean square of those of unit noise, 6 for white
    /// noise.
    SecondDifferences(f64),
    /// The level of the residual.
    Level,
}

impl ResidualVariance {
    /// Residual of H with its source of response noise; `lines_per_effective_line` lines have the
    /// information of one.
    pub fn new(
        values: &[Complex64],
        residual: &[Complex64],
        source: ResponseVariance,
        lines_per_effective_line: f64,
    ) -> Self {
        let power = values.iter().map(Complex64::norm_sqr).collect();
        let fit = values.iter().zip(residual);
        let fitted = fit.map(|(h, residual)| (h - residual).norm_sqr()).collect();
        let energy: Vec<f64> = residual.iter().map(Complex64::norm_sqr).collect();
        let (response_noise, squares) = match source {
            ResponseVariance::Stated(variance) => (variance, None),
            ResponseVariance::SecondDifferences(of_unit) => {
                let mut squares = NoiseSquares::of_second_differences(residual);
                squares.values.iter_mut().for_each(|v| *v *= 6.0 / of_unit);
                (squares.variance(), Some(squares))
            }
            ResponseVariance::Level => {
                let squares = NoiseSquares::of_level(&energy);
                (squares.variance(), Some(squares))
            }
        };
        let mut new = Self {
            samples: VarianceSamples {
                variance: energy,
                power,
                degrees_of_freedom: Some(2.0),
                lines_per_effective_line,
                response_noise: None,
            },
            squares,
            fitted,
        };
        new.set_response_noise(response_noise);
        new
    }

    /// Second differences on some lines, over the response noise as estimated before: response
    /// noise is the slowly varying part.
    fn differences_at(&self, lines: &[usize]) -> Option<VarianceSamples> {
        let squares = self.squares.as_ref()?;
        let response_noise = self.samples.response_noise.as_ref()?;
        let mean = |k: &usize| std::f64::consts::LN_2 * squares.values[*k] / response_noise[*k];
        let power = |k: &usize| self.fitted[*k] / response_noise[*k];
        Some(VarianceSamples {
            variance: lines.iter().map(mean).collect(),
            power: lines.iter().map(power).collect(),
            degrees_of_freedom: Some(2.0),
            lines_per_effective_line: self.samples.lines_per_effective_line
                * squares.differences_per_effective_line?,
            response_noise: None,
        })
    }

    fn difference_squares(&self) -> Option<&NoiseSquares> {
        let squares = self.squares.as_ref();
        squares.filter(|squares| squares.differences_per_effective_line.is_some())
    }

    /// Estimates the response noise with the given force noise, a fraction of |H|², subtracted.
    fn estimate_with_force_noise(&mut self, force_noise_coefficient: &[f64]) {
        let Some(squares) = self.difference_squares() else {
            return;
        };
        let force = self
            .fitted
            .iter()
            .zip(force_noise_coefficient)
            .map(|(p, b)| b * p);
        let estimates = squares
            .response_noise(force)
            .into_iter()
            .zip(squares.variance());
        let raised = estimates.map(|(v, without)| v.max(MIN_RESPONSE_NOISE_RATIO * without));
        self.set_response_noise(raised.collect());
    }

    /// Raises variances to the sum of response noise and given force noise.
    fn raise_to_joint_estimate(
        &self,
        smooth: &mut SmoothedVariance,
        force_noise_coefficient: &[f64],
    ) {
        let (Some(response_noise), Some(_)) =
            (&self.samples.response_noise, self.difference_squares())
        else {
            return;
        };
        for (k, b) in force_noise_coefficient.iter().enumerate() {
            let minimum = response_noise[k] + b * self.fitted[k];
            if smooth.variance[k] < minimum {
                smooth.variance[k] = minimum;
                smooth.force_fraction[k] = 1.0 - response_noise[k] / minimum;
            }
        }
    }

    /// Sets the variance of the response noise, raised to the minimum where the data supply none.
    fn set_response_noise(&mut self, mut variance: Vec<f64>) {
        if self.squares.is_some() {
            raise_to_minimum(&mut variance, self.samples.power.iter().copied());
        }
        self.samples.response_noise = Some(variance);
    }
}

/// Estimates the variances of the FRFs of one reference from the residual of a fit.
///
/// The response noise is supplied with the data; else it is constant over the lines, estimated from
/// second differences, which the residual of a missing mode hardly changes, or from the level where
/// correlated noise makes second differences small. Force noise under a window is smooth over the
/// lines and proportional to |H|²; the residual in all resonances together determines it better
/// than the variances of a few impacts do.
pub(in crate::identify) fn estimate_variances(
    mut functions: Vec<ResidualVariance>,
) -> Vec<SmoothedVariance> {
    let mut force_noise_coefficient = Vec::new();
    for _ in 0..JOINT_ESTIMATES {
        let estimate = force_noise_outside_resonances(&functions);
        if estimate.iter().all(|b| *b <= 0.0) {
            break;
        }
        force_noise_coefficient = estimate;
        functions
            .par_iter_mut()
            .for_each(|frf| frf.estimate_with_force_noise(&force_noise_coefficient));
    }
    let unstated = functions.iter_mut().filter(|frf| frf.squares.is_some());
    share_profile(
        unstated
            .filter_map(|frf| frf.samples.response_noise.as_mut())
            .collect(),
    );
    let samples: Vec<&VarianceSamples> = functions.iter().map(|frf| &frf.samples).collect();
    let mut smooth = variance_model::smooth(&samples);
    let pairs = smooth.par_iter_mut().zip(&functions);
    pairs.for_each(|(smooth, frf)| frf.raise_to_joint_estimate(smooth, &force_noise_coefficient));
    smooth
}

/// Force noise coefficient b at every line, from second differences outside resonances: a missing
/// mode adds little to these there, and much within its resonance.
fn force_noise_outside_resonances(functions: &[ResidualVariance]) -> Vec<f64> {
    let differences = functions
        .iter()
        .filter(|frf| frf.difference_squares().is_some());
    let powers: Vec<&[f64]> = differences.map(|frf| &frf.fitted[..]).collect();
    let Some(lines) = powers.first().map(|power| power.len()) else {
        return Vec::new();
    };
    let mut whole = vec![0.0; lines];
    for power in powers {
        let level = power.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        let sums = whole.iter_mut().zip(power);
        sums.for_each(|(sum, p)| *sum += p / level);
    }
    let mut sorted = whole.clone();
    let max_power =
        MAX_POWER_OVER_MEDIAN * *sorted.select_nth_unstable_by(lines / 2, f64::total_cmp).1;
    let outside: Vec<usize> = (0..lines).filter(|k| whole[*k] <= max_power).collect();
    let Some(last) = outside.len().checked_sub(1) else {
        return Vec::new();
    };
    let samples: Vec<VarianceSamples> = functions
        .par_iter()
        .filter_map(|frf| frf.differences_at(&outside))
        .collect();
    let force_noise_coefficient =
        variance_model::force_noise_coefficient(&samples.iter().collect::<Vec<_>>());
    let next = |k: usize| outside.partition_point(|line| *line < k).min(last);
    (0..lines)
        .map(|k| force_noise_coefficient[next(k)])
        .collect()
}

/// Sets variances that differ from a common profile only by the scatter of such estimates to that
/// profile, with a level per FRF: the scatter of each FRF would otherwise look like force noise
/// where there are many.
fn share_profile(mut frfs: Vec<&mut Vec<f64>>) {
    let lines = frfs.first().map_or(0, |values| values.len());
    let levels: Vec<f64> = frfs
        .par_iter()
        .map(|values| values.iter().sum::<f64>() / lines as f64)
        .collect();
    let mut profile = vec![0.0; lines];
    let pieces = profile.par_chunks_mut(CACHE_LINES).enumerate();
    pieces.for_each(|(number, sums)| {
        let first = number * CACHE_LINES;
        for (values, level) in frfs.iter().zip(&levels) {
            let weight = (level * levels.len() as f64).recip();
            for (sum, v) in sums.iter_mut().zip(&values[first..]) {
                *sum += v * weight;
            }
        }
    });
    let profile = &profile;
    frfs.par_iter_mut().zip(levels).for_each(|(values, level)| {
        let log_ratio = |(v, c): (&f64, &f64)| (v / (level * c)).ln().powi(2);
        let scatter = values.iter().zip(profile).map(log_ratio).sum::<f64>() / lines as f64;
        if scatter <= MAX_LOG_SCATTER {
            for (v, c) in values.iter_mut().zip(profile) {
                *v = level * c;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use crate::identify::noise::residual_variance::*;
    use crate::identify::synthetic::white_noise;

    #[test]
    fn residual_gives_force_noise_in_addition_to_response_noise() {
        // Resonances 20 lines wide; response noise of variance 1e-6, and force noise of 1 % of the
        // response, constant over 40 lines.
        let line = |k: usize, at: f64| 10.0 / Complex64::new(10.0, k as f64 - at);
        let clean = |k: usize| (0..8).map(|n| line(k, 250.0 + 500.0 * n as f64)).sum();
        let values: Vec<Complex64> = (0..4000).map(clean).collect();
        let white = white_noise(4040, 1e-4 / 40.0, 3);
        let force = |k: usize| white[k..k + 40].iter().sum::<Complex64>();
        let functions: Vec<_> = (0..6)
            .map(|f| {
                let response = white_noise(4000, 1e-6, 10 + f);
                let rest = (0..4000).map(|k| response[k] + force(k) * values[k]);
                ResidualVariance::new(
                    &values,
                    &rest.collect::<Vec<_>>(),
                    ResponseVariance::SecondDifferences(6.0),
                    1.0,
                )
            })
            .collect();
        let smoothed = estimate_variances(functions);
        let between = smoothed.iter().map(|frf| frf.variance[500]).sum::<f64>() / 6.0;
        assert!((between / 1.05e-6 - 1.0).abs() < 0.15, "{between}");
        // Half a dozen independent errors within each of eight resonances: their mean square is
        // known to a sixth.
        let tops = (0..8).map(|n| smoothed[0].variance[250 + 500 * n]);
        let top = tops.sum::<f64>() / 8.0;
        assert!((top / 1.01e-4 - 1.0).abs() < 0.5, "{top}");
        assert!(smoothed[0].force_fraction[250] > 0.9 && smoothed[0].force_fraction[500] < 0.2);
    }

    #[test]
    fn residual_adds_force_noise_to_stated_variances() {
        // Stated: 1e-6 at every line. Of the six, one response has ten times that, stated as well.
        let line = |k: usize, at: f64| 10.0 / Complex64::new(10.0, k as f64 - at);
        let clean = |k: usize| (0..8).map(|n| line(k, 250.0 + 500.0 * n as f64)).sum();
        let values: Vec<Complex64> = (0..4000).map(clean).collect();
        let estimates = |force_fraction: f64| {
            let force = white_noise(4000, force_fraction, 3);
            let residual = |f: u64| {
                let stated = if f == 5 { 1e-5 } else { 1e-6 };
                let response = white_noise(4000, stated, 10 + f);
                let rest = (0..4000).map(|k| response[k] + force[k] * values[k]);
                let stated = ResponseVariance::Stated(vec![stated; 4000]);
                ResidualVariance::new(&values, &rest.collect::<Vec<_>>(), stated, 1.0)
            };
            estimate_variances((0..6).map(residual).collect())
        };
        let top = |frf: &SmoothedVariance| {
            let tops = (0..8).flat_map(|n| 240 + 500 * n..260 + 500 * n);
            tops.map(|k| frf.variance[k] / values[k].norm_sqr())
                .sum::<f64>()
                / 160.0
        };
        let with = estimates(1e-4);
        // 160 lines, each an independent sample of the force: their mean square to 8 %, four times.
        assert!(
            (top(&with[0]) / 1.01e-4 - 1.0).abs() < 0.3,
            "{}",
            top(&with[0])
        );
        // Half-way between two resonances the force adds 2 % at most.
        assert!((with[0].variance[500] / 1.05e-6 - 1.0).abs() < 0.15);
        assert!((with[5].variance[500] / 1.005e-5 - 1.0).abs() < 0.15);
        assert!(with[0].force_fraction[250] > 0.9 && with[0].force_fraction[500] < 0.2);
        // Where the data contain the stated variances alone, the estimate is the stated one.
        let without = estimates(1e-12);
        assert!(
            (top(&without[0]) / 1e-6 - 1.0).abs() < 1.0,
            "{}",
            top(&without[0])
        );
        assert!((without[5].variance[500] / 1e-5 - 1.0).abs() < 0.15);
    }

    #[test]
    fn force_noise_outside_resonances_is_not_estimated_as_response_noise() {
        // Force noise of 1 % of the response, far above the response noise between resonances of
        // ten lines; antiresonances where the signs of the FRFs place them. The ninth FRF is hardly
        // more than noise.
        let resonance = |k: usize, at: f64| 5.0 / Complex64::new(5.0, k as f64 - at);
        let sign = |f: usize, n: usize| if (f >> (n % 3)) & 1 == 0 { 1.0 } else { -1.0 };
        let value = |f: usize, k: usize| -> Complex64 {
            let at = |n: usize| 250.0 + 500.0 * n as f64;
            (0..8).map(|n| sign(f, n) * resonance(k, at(n))).sum()
        };
        let of_force = 1e-4;
        let mut truth = Vec::new();
        let functions = (0..9).map(|f| {
            let of_response = if f < 8 { 1e-11 } else { 1.0 };
            let scale = if f < 8 { 1.0 } else { 1e-3 };
            let values: Vec<Complex64> = (0..4000).map(|k| scale * value(f, k)).collect();
            let seed = f as u64;
            let force = white_noise(4000, of_force, 100 + seed);
            let response = white_noise(4000, of_response, 200 + seed);
            let rest: Vec<Complex64> = (0..4000)
                .map(|k| response[k] + force[k] * values[k])
                .collect();
            let variance = values.iter().map(|h| of_response + of_force * h.norm_sqr());
            truth.push(variance.collect::<Vec<f64>>());
            let measured: Vec<Complex64> = values.iter().zip(&rest).map(|(h, e)| h + e).collect();
            ResidualVariance::new(
                &measured,
                &rest,
                ResponseVariance::SecondDifferences(6.0),
                1.0,
            )
        });
        let estimates = estimate_variances(functions.collect());
        for (estimate, truth) in estimates.iter().zip(&truth) {
            let pairs = estimate.variance.iter().zip(truth);
            let log_ratios = pairs.map(|(v, expected)| (v / expected).ln());
            let (sum, squares) = log_ratios.fold((0.0, 0.0), |(a, b), x| (a + x, b + x * x));
            assert!(sum.abs() < 0.1 * 4000.0, "{}", sum / 4000.0);
            let deviation = (squares / 4000.0).sqrt();
            assert!(deviation < 0.3, "{deviation}");
        }
    }
}
