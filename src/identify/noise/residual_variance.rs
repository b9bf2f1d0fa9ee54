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

use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::identify::noise::data_variance::{NoiseSquares, raise_to_minimum};
use crate::identify::noise::variance_model::{
    self, EstimatedVariances, SmoothedVariance, VarianceSamples,
};

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

/// Residual of the FRFs of one reference, which is read on the lines where it is needed, in the
/// measured quantity.
pub(in crate::identify) trait ReferenceResidual: Sync {
    /// Number of FRFs.
    fn functions(&self) -> usize;

    /// Number of lines of each, three at least.
    fn lines(&self) -> usize;

    /// Measured values of an FRF on a range of lines.
    fn values(&self, function: usize, lines: Range<usize>) -> Vec<Complex64>;

    /// Residual of an FRF on a range of lines.
    fn residual(&self, function: usize, lines: Range<usize>) -> Vec<Complex64>;

    /// Source of the response noise of an FRF.
    fn source(&self, function: usize) -> ResponseVariance;

    /// Variance of the response noise of an FRF as supplied with the data; `None` where that is not
    /// its source.
    fn stated(&self, function: usize) -> Option<Vec<f64>>;

    /// Number of lines with the information of one.
    fn lines_per_effective_line(&self) -> f64;
}

/// Source of the response noise of an FRF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) enum ResponseVariance {
    /// Variances supplied with the data.
    Stated,
    /// Second differences of the residual; with the mean square of those of unit noise, 6 for white
    /// noise.
    SecondDifferences(f64),
    /// The level of the residual.
    Level,
}

/// Residual of the FRFs of a reference with their response noise.
struct NoiseEstimate<'a, R: ?Sized> {
    residual: &'a R,
    /// Response noise of each FRF by line.
    response_noise: Vec<Vec<f64>>,
}

/// Estimates the variances of the FRFs of one reference from the residual of a fit, and converts
/// those of each, with its number.
///
/// The response noise is supplied with the data; else it is constant over the lines, estimated from
/// second differences, which the residual of a missing mode hardly changes, or from the level where
/// correlated noise makes second differences small. Force noise under a window is smooth over the
/// lines and proportional to |H|²; the residual in all resonances together determines it better
/// than the variances of a few impacts do.
pub(in crate::identify) fn estimate_variances<T: Send>(
    residual: &(impl ReferenceResidual + ?Sized),
    convert: impl Fn(usize, SmoothedVariance) -> T + Sync,
) -> Vec<T> {
    let mut estimate = NoiseEstimate::new(residual);
    let mut force_noise_coefficient = Vec::new();
    for _ in 0..JOINT_ESTIMATES {
        let coefficient = estimate.force_noise_outside_resonances();
        if coefficient.iter().all(|b| *b <= 0.0) {
            break;
        }
        force_noise_coefficient = coefficient;
        estimate.subtract_force_noise(&force_noise_coefficient);
    }
    let unstated = estimate.response_noise.iter_mut().enumerate();
    let unstated = unstated.filter(|(f, _)| residual.source(*f) != ResponseVariance::Stated);
    share_profile(unstated.map(|(_, noise)| noise).collect());
    variance_model::smooth(&estimate, |f, mut smooth| {
        estimate.raise_to_joint_estimate(f, &mut smooth, &force_noise_coefficient);
        convert(f, smooth)
    })
}

impl<'a, R: ReferenceResidual + ?Sized> NoiseEstimate<'a, R> {
    /// Response noise of the FRFs where there is no force noise.
    fn new(residual: &'a R) -> Self {
        let of_squares = |f: usize, squares: NoiseSquares| {
            let mut variance = squares.variance();
            raise(residual, f, &mut variance);
            variance
        };
        let response_noise = |f: usize| match residual.source(f) {
            ResponseVariance::Stated => residual.stated(f).unwrap_or_default(),
            ResponseVariance::SecondDifferences(of_unit) => {
                of_squares(f, second_differences(&all_of(residual, f), of_unit))
            }
            ResponseVariance::Level => {
                let energy = all_of(residual, f);
                let energy: Vec<f64> = energy.iter().map(Complex64::norm_sqr).collect();
                of_squares(f, NoiseSquares::of_level(&energy))
            }
        };
        let functions = (0..residual.functions()).into_par_iter();
        Self {
            residual,
            response_noise: functions.map(response_noise).collect(),
        }
    }

    /// Mean square of the second differences of unit noise, where the response noise of an FRF is
    /// estimated from them.
    fn differences_of_unit(&self, function: usize) -> Option<f64> {
        match self.residual.source(function) {
            ResponseVariance::SecondDifferences(of_unit) => Some(of_unit),
            ResponseVariance::Stated | ResponseVariance::Level => None,
        }
    }

    /// |H|² of the fit alone, which contains no noise of the line.
    fn fitted(&self, function: usize, lines: Range<usize>) -> Vec<f64> {
        let values = self.residual.values(function, lines.clone());
        let fit = values.iter().zip(self.residual.residual(function, lines));
        fit.map(|(h, residual)| (h - residual).norm_sqr()).collect()
    }

    /// Force noise coefficient b at every line, from second differences outside resonances: a
    /// missing mode adds little to these there, and much within its resonance.
    fn force_noise_outside_resonances(&self) -> Vec<f64> {
        let functions = 0..self.residual.functions();
        let functions: Vec<usize> = functions
            .filter(|f| self.differences_of_unit(*f).is_some())
            .collect();
        if functions.is_empty() {
            return Vec::new();
        }
        let lines = self.residual.lines();
        let level = |f: &usize| self.fitted(*f, 0..lines).iter().sum::<f64>();
        let levels: Vec<f64> = functions.par_iter().map(level).collect();
        let mut whole = vec![0.0; lines];
        let pieces = whole.par_chunks_mut(CACHE_LINES).enumerate();
        pieces.for_each(|(number, sums)| {
            let first = number * CACHE_LINES;
            for (f, level) in functions.iter().zip(&levels) {
                let level = level.max(f64::MIN_POSITIVE);
                let power = self.fitted(*f, first..first + sums.len());
                let sums = sums.iter_mut().zip(power);
                sums.for_each(|(sum, p)| *sum += p / level);
            }
        });
        let mut sorted = whole.clone();
        let max_power =
            MAX_POWER_OVER_MEDIAN * *sorted.select_nth_unstable_by(lines / 2, f64::total_cmp).1;
        let outside: Vec<usize> = (0..lines).filter(|k| whole[*k] <= max_power).collect();
        let Some(last) = outside.len().checked_sub(1) else {
            return Vec::new();
        };
        let force_noise_coefficient = variance_model::force_noise_coefficient(&Differences {
            estimate: self,
            functions: &functions,
            lines: &outside,
        });
        let next = |k: usize| outside.partition_point(|line| *line < k).min(last);
        (0..lines)
            .map(|k| force_noise_coefficient[next(k)])
            .collect()
    }

    /// Estimates the response noise with the given force noise, a fraction of |H|², subtracted.
    fn subtract_force_noise(&mut self, force_noise_coefficient: &[f64]) {
        let lines = 0..self.residual.lines();
        let estimate = |f: usize| {
            let of_unit = self.differences_of_unit(f)?;
            let squares = second_differences(&all_of(self.residual, f), of_unit);
            let fitted = self.fitted(f, lines.clone());
            let force = fitted.iter().zip(force_noise_coefficient);
            let estimates = squares
                .response_noise(force.map(|(p, b)| b * p))
                .into_iter()
                .zip(squares.variance());
            let raised = estimates.map(|(v, without)| v.max(MIN_RESPONSE_NOISE_RATIO * without));
            let mut raised: Vec<f64> = raised.collect();
            raise(self.residual, f, &mut raised);
            Some(raised)
        };
        let functions = (0..self.residual.functions()).into_par_iter();
        let estimates: Vec<Option<Vec<f64>>> = functions.map(estimate).collect();
        for (noise, estimate) in self.response_noise.iter_mut().zip(estimates) {
            if let Some(estimate) = estimate {
                *noise = estimate;
            }
        }
    }

    /// Raises variances to the sum of response noise and given force noise.
    fn raise_to_joint_estimate(
        &self,
        function: usize,
        smooth: &mut SmoothedVariance,
        force_noise_coefficient: &[f64],
    ) {
        if force_noise_coefficient.is_empty() || self.differences_of_unit(function).is_none() {
            return;
        }
        let response_noise = &self.response_noise[function];
        let fitted = self.fitted(function, 0..self.residual.lines());
        for (k, b) in force_noise_coefficient.iter().enumerate() {
            let minimum = response_noise[k] + b * fitted[k];
            if smooth.variance[k] < minimum {
                smooth.variance[k] = minimum;
                smooth.force_fraction[k] = 1.0 - response_noise[k] / minimum;
            }
        }
    }
}

/// Squared residual at every line, with |H|² as measured and the variance of the response noise.
impl<R: ReferenceResidual + ?Sized> EstimatedVariances for NoiseEstimate<'_, R> {
    fn functions(&self) -> usize {
        self.residual.functions()
    }

    fn lines(&self) -> usize {
        self.residual.lines()
    }

    fn samples(&self, function: usize, lines: Range<usize>) -> VarianceSamples {
        let squares = |values: Vec<Complex64>| values.iter().map(Complex64::norm_sqr).collect();
        VarianceSamples {
            variance: squares(self.residual.residual(function, lines.clone())),
            power: squares(self.residual.values(function, lines.clone())),
            degrees_of_freedom: Some(2.0),
            lines_per_effective_line: self.residual.lines_per_effective_line(),
            response_noise: Some(self.response_noise[function][lines].to_vec()),
        }
    }
}

/// Second differences on some lines, over the response noise as estimated before: response noise is
/// the slowly varying part.
struct Differences<'a, R: ?Sized> {
    estimate: &'a NoiseEstimate<'a, R>,
    functions: &'a [usize],
    /// Ascending.
    lines: &'a [usize],
}

impl<R: ReferenceResidual + ?Sized> EstimatedVariances for Differences<'_, R> {
    fn functions(&self) -> usize {
        self.functions.len()
    }

    fn lines(&self) -> usize {
        self.lines.len()
    }

    fn samples(&self, function: usize, lines: Range<usize>) -> VarianceSamples {
        let f = self.functions[function];
        let (estimate, all) = (self.estimate, self.estimate.residual.lines());
        let lines = &self.lines[lines];
        let span = lines
            .first()
            .map_or(0..0, |first| *first..lines[lines.len() - 1] + 1);
        let of_unit = estimate.differences_of_unit(f).unwrap_or(f64::INFINITY);
        // With a neighbour on either side, and three lines at least.
        let start = span.start.saturating_sub(1).min(all - 3);
        let end = (span.end + 1).max(start + 3).min(all);
        let residual = estimate.residual.residual(f, start..end);
        let squares = second_differences(&residual, of_unit);
        let fitted = estimate.fitted(f, span.clone());
        let response_noise = &estimate.response_noise[f];
        let mean =
            |k: &usize| std::f64::consts::LN_2 * squares.values[*k - start] / response_noise[*k];
        let power = |k: &usize| fitted[*k - span.start] / response_noise[*k];
        let differences_per_line = squares.differences_per_effective_line.unwrap_or(1.0);
        VarianceSamples {
            variance: lines.iter().map(mean).collect(),
            power: lines.iter().map(power).collect(),
            degrees_of_freedom: Some(2.0),
            lines_per_effective_line: estimate.residual.lines_per_effective_line()
                * differences_per_line,
            response_noise: None,
        }
    }
}

/// Raises variances of the response noise of an FRF to the rounding error of its values.
fn raise(residual: &(impl ReferenceResidual + ?Sized), function: usize, variance: &mut [f64]) {
    let values = residual.values(function, 0..residual.lines());
    raise_to_minimum(variance, values.iter().map(Complex64::norm_sqr));
}

/// Residual of an FRF on all lines.
fn all_of(residual: &(impl ReferenceResidual + ?Sized), function: usize) -> Vec<Complex64> {
    residual.residual(function, 0..residual.lines())
}

/// Squared second differences of a residual; `of_unit` is the mean square of those of unit noise.
fn second_differences(residual: &[Complex64], of_unit: f64) -> NoiseSquares {
    let mut squares = NoiseSquares::of_second_differences(residual);
    squares.values.iter_mut().for_each(|v| *v *= 6.0 / of_unit);
    squares
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

    /// FRFs as measured, with their residuals and the variance of all responses, where it is
    /// stated.
    #[derive(Default)]
    struct Reference {
        values: Vec<Vec<Complex64>>,
        residuals: Vec<Vec<Complex64>>,
        stated: Vec<f64>,
    }

    impl ReferenceResidual for Reference {
        fn functions(&self) -> usize {
            self.values.len()
        }

        fn lines(&self) -> usize {
            self.values[0].len()
        }

        fn values(&self, function: usize, lines: Range<usize>) -> Vec<Complex64> {
            self.values[function][lines].to_vec()
        }

        fn residual(&self, function: usize, lines: Range<usize>) -> Vec<Complex64> {
            self.residuals[function][lines].to_vec()
        }

        fn source(&self, function: usize) -> ResponseVariance {
            match self.stated.get(function) {
                Some(_) => ResponseVariance::Stated,
                None => ResponseVariance::SecondDifferences(6.0),
            }
        }

        fn stated(&self, function: usize) -> Option<Vec<f64>> {
            let stated = self.stated.get(function)?;
            Some(vec![*stated; self.lines()])
        }

        fn lines_per_effective_line(&self) -> f64 {
            1.0
        }
    }

    fn estimates(reference: &Reference) -> Vec<SmoothedVariance> {
        estimate_variances(reference, |_, smooth| smooth)
    }

    #[test]
    fn residual_gives_force_noise_in_addition_to_response_noise() {
        // Resonances 20 lines wide; response noise of variance 1e-6, and force noise of 1 % of the
        // response, constant over 40 lines.
        let line = |k: usize, at: f64| 10.0 / Complex64::new(10.0, k as f64 - at);
        let clean = |k: usize| (0..8).map(|n| line(k, 250.0 + 500.0 * n as f64)).sum();
        let values: Vec<Complex64> = (0..4000).map(clean).collect();
        let white = white_noise(4040, 1e-4 / 40.0, 3);
        let force = |k: usize| white[k..k + 40].iter().sum::<Complex64>();
        let residual = |f: u64| {
            let response = white_noise(4000, 1e-6, 10 + f);
            let rest = (0..4000).map(|k| response[k] + force(k) * values[k]);
            rest.collect()
        };
        let smoothed = estimates(&Reference {
            values: vec![values.clone(); 6],
            residuals: (0..6).map(residual).collect(),
            stated: Vec::new(),
        });
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
            let stated = |f: u64| if f == 5 { 1e-5 } else { 1e-6 };
            let residual = |f: u64| {
                let response = white_noise(4000, stated(f), 10 + f);
                let rest = (0..4000).map(|k| response[k] + force[k] * values[k]);
                rest.collect()
            };
            estimates(&Reference {
                values: vec![values.clone(); 6],
                residuals: (0..6).map(residual).collect(),
                stated: (0..6).map(stated).collect(),
            })
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
        let mut reference = Reference::default();
        for f in 0..9 {
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
            reference.values.push(measured);
            reference.residuals.push(rest);
        }
        let estimates = estimates(&reference);
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
