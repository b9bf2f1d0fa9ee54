//! The model of noise variances over the lines, response noise plus force noise times |H|², is
//! fitted to scattered variances by maximum likelihood.
//!
//! An FRF from impacts has the variance `(S_nn + |H|² S_mm)/S_ff` with noise `n` of the response
//! and `m` of the force (Bendat and Piersol 1980): `v = a + b p`, `p = |H|²`, which in a resonance
//! of few lines rises far above its neighbourhood. `a` belongs to one FRF and is constant over a
//! few dozen lines; `b` is common to a reference and constant over hundreds. Variances estimated
//! with `ν` degrees of freedom are gamma variables, of the log-likelihood `(ν/2) Σ (−ln(a + b p) −
//! v/(a + b p))` except for a constant. Windows correlate the scatter of neighbouring lines, so
//! that an estimate of b from a few dozen lines of few impacts would be random.

use std::ops::Range;

use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::linalg::{sort_descending_by, vectorised};

/// Lines of a block with one `a`, and further lines on either side that it is estimated from.
const BLOCK_LINES: usize = 16;
const MARGIN_LINES: usize = 24;
/// Minimum length of a segment with one `b`, lines, and maximum number of segments.
const MIN_SEGMENT_LINES: usize = 256;
const MAX_SEGMENTS: usize = 16;
/// Iterations of the weights for `a`.
const WEIGHT_ITERATIONS: usize = 3;
/// Number of trial values of b, from that of force noise alone downwards, and their ratio.
const TRIAL_VALUES: usize = 12;
const TRIAL_RATIO: f64 = 2.5;
/// Part of the FRFs, one in this number, whose b of force noise alone is below the highest trial
/// value. With the largest b of all FRFs, sensors at rest hide the force noise of the others
/// (`force_noise_is_found_beside_frfs_without_response`).
const STRONGEST_ONE_IN: usize = 10;
/// Steps of the golden-section search between two of them.
const SEARCH_STEPS: usize = 10;
const GOLDEN_SECTION: f64 = 0.618_033_988_749_895;
/// Number of FRFs that exclude values of b before all are tried: those that determine b best.
///
/// A value that is less likely than none in them, by [`MIN_LIKELIHOOD_GAIN`], is no maximum of all,
/// as b is common. More: a large set takes longer; fewer: more values are tried in all. Test:
/// `force_noise_is_found_beside_frfs_without_response`.
const EXCLUDING_FRFS: usize = 64;
/// Maximum b that a residual may give: 5 % of the response. A pole that shifts from FRF to FRF
/// leaves a larger residual in its resonance, which is no noise.
const MAX_RESIDUAL_COEFFICIENT: f64 = 2.5e-3;
/// Minimum gain of the log-likelihood by b.
const MIN_LIKELIHOOD_GAIN: f64 = 10.0;
/// False-alarm probability for a line with more noise than its neighbours, such as that of the
/// mains.
const OUTLIER_PROBABILITY: f64 = 1e-6;
/// Degrees of freedom where the data state none: those of three averages.
const DEFAULT_FREEDOM: f64 = 4.0;
/// Maximum degrees of freedom: with more, variances hardly scatter.
const MAX_FREEDOM: f64 = 1e4;
/// Minimum `a` over the median variance: smaller values are rounding and zeros.
const MIN_RESPONSE_NOISE_RATIO: f64 = 1e-6;

/// Variances of one FRF as they are estimated, with their scatter.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct VarianceSamples {
    /// v at every line.
    pub variance: Vec<f64>,
    /// |H|² at every line.
    pub power: Vec<f64>,
    /// ν, where it is specified.
    pub degrees_of_freedom: Option<f64>,
    /// Number of lines with the information of one.
    pub lines_per_effective_line: f64,
    /// `a` at every line, where it is estimated elsewhere; an outlier is then not noise.
    pub response_noise: Option<Vec<f64>>,
}

/// Variances without their scatter.
#[derive(Clone, Debug, PartialEq, Default)]
pub(in crate::identify) struct SmoothedVariance {
    /// a + b p at every line.
    pub variance: Vec<f64>,
    /// Force noise b p as a fraction of it.
    pub force_fraction: Vec<f64>,
}

/// Variances of the FRFs of one reference, which are read on the lines where they are needed: those
/// of all lines would take several times the memory of the FRFs.
pub(in crate::identify) trait EstimatedVariances: Sync {
    /// Number of FRFs.
    fn functions(&self) -> usize;

    /// Number of lines of each.
    fn lines(&self) -> usize;

    /// Variances of an FRF on a range of lines.
    fn samples(&self, function: usize, lines: Range<usize>) -> VarianceSamples;
}

impl EstimatedVariances for [VarianceSamples] {
    fn functions(&self) -> usize {
        self.len()
    }

    fn lines(&self) -> usize {
        self.first().map_or(0, |frf| frf.variance.len())
    }

    fn samples(&self, function: usize, lines: Range<usize>) -> VarianceSamples {
        let frf = &self[function];
        VarianceSamples {
            variance: frf.variance[lines.clone()].to_vec(),
            power: frf.power[lines.clone()].to_vec(),
            response_noise: frf.response_noise.as_ref().map(|a| a[lines].to_vec()),
            ..*frf
        }
    }
}

/// Smooths the variances of all FRFs of one reference over the lines and converts those of each,
/// with its number; a variance far above its neighbours is unchanged.
pub(in crate::identify) fn smooth<T: Send>(
    variances: &(impl EstimatedVariances + ?Sized),
    convert: impl Fn(usize, SmoothedVariance) -> T + Sync,
) -> Vec<T> {
    let (functions, lines) = (variances.functions(), variances.lines());
    let segments = segments(lines);
    let first_line = |f: usize| variances.samples(f, 0..lines.min(1));
    let is_residual = (0..functions).any(|f| first_line(f).response_noise.is_some());
    let limit = if is_residual {
        MAX_RESIDUAL_COEFFICIENT
    } else {
        f64::INFINITY
    };
    let force_noise_coefficient = per_segment(variances, &segments, limit);
    let smoothed = |f: usize| {
        let frf = variances.samples(f, 0..lines);
        convert(f, frf.smoothed(&segments, &force_noise_coefficient))
    };
    (0..functions).into_par_iter().map(smoothed).collect()
}

/// b at every line, from all FRFs of one reference, limited as for a residual.
pub(in crate::identify) fn force_noise_coefficient(
    variances: &(impl EstimatedVariances + ?Sized),
) -> Vec<f64> {
    let lines = variances.lines();
    let coefficients = per_segment(variances, &segments(lines), MAX_RESIDUAL_COEFFICIENT);
    let position = |k: usize| (k as f64 + 0.5) / lines as f64;
    (0..lines)
        .map(|k| interpolate(&coefficients, position(k)))
        .collect()
}

/// Segments of lines with one b.
fn segments(lines: usize) -> Vec<Range<usize>> {
    let count = (lines / MIN_SEGMENT_LINES).clamp(1, MAX_SEGMENTS);
    let edge = |n: usize| n * lines / count;
    (0..count).map(|n| edge(n)..edge(n + 1)).collect()
}

/// Linear interpolation of one value per segment between the middles of the segments.
fn interpolate(values: &[f64], position: f64) -> f64 {
    let at = (position * values.len() as f64 - 0.5).clamp(0.0, (values.len() - 1) as f64);
    let first = at.floor() as usize;
    let next = (first + 1).min(values.len() - 1);
    values[first] + (at - first as f64) * (values[next] - values[first])
}

/// b of every segment. Force noise does not end with a segment: one without a significant estimate
/// takes that of the nearest segment with one, unless its likelihood contradicts it.
fn per_segment(
    variances: &(impl EstimatedVariances + ?Sized),
    segments: &[Range<usize>],
    limit: f64,
) -> Vec<f64> {
    let likeliest = |lines: &Range<usize>| {
        SegmentVariances::new(variances, lines.clone()).likeliest_coefficient(limit)
    };
    let estimates: Vec<Option<f64>> = segments.par_iter().map(likeliest).collect();
    let completed = |n: usize| {
        estimates[n].or_else(|| {
            let others = (0..estimates.len()).filter_map(|m| Some((m.abs_diff(n), estimates[m]?)));
            let (_, nearest) = others.min_by_key(|(distance, _)| *distance)?;
            let segment = SegmentVariances::new(variances, segments[n].clone());
            let likelihood = segment.likelihoods(&[0.0, nearest]);
            (likelihood[1] > likelihood[0] - MIN_LIKELIHOOD_GAIN).then_some(nearest)
        })
    };
    (0..estimates.len())
        .into_par_iter()
        .map(|n| completed(n).unwrap_or(0.0))
        .collect()
}

/// Variances of all FRFs of a reference on the lines of a segment.
struct SegmentVariances {
    frfs: Vec<VarianceSamples>,
    medians: Vec<f64>,
    max_ratios: Vec<f64>,
}

impl SegmentVariances {
    fn new(variances: &(impl EstimatedVariances + ?Sized), lines: Range<usize>) -> Self {
        let functions = 0..variances.functions();
        let frfs: Vec<VarianceSamples> = functions
            .map(|f| variances.samples(f, lines.clone()))
            .collect();
        // With a stated response noise no median is needed.
        let median = |frf: &VarianceSamples| match frf.response_noise {
            Some(_) => 0.0,
            None => frf.median(0..lines.len()),
        };
        Self {
            medians: frfs.iter().map(median).collect(),
            max_ratios: max_outlier_ratios(&frfs),
            frfs,
        }
    }

    /// Log-likelihood of every trial value of b.
    fn likelihoods(&self, tried: &[f64]) -> Vec<f64> {
        self.likelihoods_in(0..self.frfs.len(), tried)
    }

    /// The same in some of the FRFs.
    fn likelihoods_in(&self, frfs: impl Iterator<Item = usize>, tried: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; tried.len()];
        for f in frfs {
            let terms = self.frfs[f].likelihoods(self.medians[f], tried, self.max_ratios[f]);
            sums.iter_mut()
                .zip(terms)
                .for_each(|(sum, term)| *sum += term);
        }
        sums
    }

    /// Trial values that the FRFs with the most information do not exclude.
    fn not_excluded(&self, tried: Vec<f64>) -> Vec<f64> {
        if self.frfs.len() <= EXCLUDING_FRFS {
            return tried;
        }
        let mut best: Vec<usize> = (0..self.frfs.len()).collect();
        sort_descending_by(&mut best, |f| self.frfs[*f].information());
        best.truncate(EXCLUDING_FRFS);
        let likelihood = self.likelihoods_in(best.into_iter(), &tried);
        let limit = likelihood[0] - MIN_LIKELIHOOD_GAIN;
        let with_likelihood = tried.into_iter().zip(likelihood);
        let kept = with_likelihood.filter(|(_, likelihood)| *likelihood >= limit);
        kept.map(|(b, _)| b).collect()
    }

    /// The b of the largest likelihood, where it is significant and below a limit.
    fn likeliest_coefficient(&self, limit: f64) -> Option<f64> {
        let mean = |frf: &VarianceSamples| {
            frf.variance.iter().sum::<f64>() / frf.power.iter().sum::<f64>()
        };
        // Force noise alone in the FRFs of the strongest response over their noise: b is common,
        // and a response near 0 would allow any b.
        let means = self.frfs.iter().map(mean);
        let mut means: Vec<f64> = means.filter(|b| b.is_finite() && *b > 0.0).collect();
        means.sort_by(f64::total_cmp);
        let max_coefficient = means.get(means.len() / STRONGEST_ONE_IN)?.min(limit);
        let tried = (0..TRIAL_VALUES)
            .map(|step| max_coefficient * TRIAL_RATIO * TRIAL_RATIO.powi(-(step as i32)));
        let tried: Vec<f64> = std::iter::once(0.0).chain(tried).collect();
        let tried = self.not_excluded(tried);
        let likelihood = self.likelihoods(&tried);
        let best = (1..tried.len()).max_by(|a, b| likelihood[*a].total_cmp(&likelihood[*b]))?;
        // The maximum between two trial values may have twice the gain.
        if likelihood[best] <= likelihood[0] + 0.5 * MIN_LIKELIHOOD_GAIN {
            return None;
        }
        let (mut low, mut high) = (tried[best] / TRIAL_RATIO, tried[best] * TRIAL_RATIO);
        let step = |low: f64, high: f64| GOLDEN_SECTION * (high - low);
        let mut inner = [high - step(low, high), low + step(low, high)];
        let mut of_inner = self.likelihoods(&inner);
        for _ in 1..SEARCH_STEPS {
            let replaced = if of_inner[0] < of_inner[1] {
                low = inner[0];
                inner = [inner[1], low + step(low, high)];
                of_inner.swap(0, 1);
                1
            } else {
                high = inner[1];
                inner = [high - step(low, high), inner[0]];
                of_inner.swap(0, 1);
                0
            };
            of_inner[replaced] = self.likelihoods(&inner[replaced..=replaced])[0];
        }
        let better = usize::from(of_inner[1] > of_inner[0]);
        let (b, gain) = (inner[better], of_inner[better] - likelihood[0]);
        (gain > MIN_LIKELIHOOD_GAIN && b <= limit).then_some(b)
    }
}

/// Maximum outlier ratio of each FRF: a quantile takes longer than a pass over a segment.
fn max_outlier_ratios(frfs: &[VarianceSamples]) -> Vec<f64> {
    let mut last: Option<(f64, f64)> = None;
    let ratio = |frf: &VarianceSamples| {
        let freedom = frf.freedom();
        let known = last.filter(|(of, _)| of.to_bits() == freedom.to_bits());
        let (_, ratio) = *last.insert(known.unwrap_or_else(|| (freedom, frf.max_outlier_ratio())));
        ratio
    };
    frfs.iter().map(ratio).collect()
}

impl VarianceSamples {
    /// Variances without their scatter, with b of each segment.
    fn smoothed(
        &self,
        segments: &[Range<usize>],
        force_noise_coefficient: &[f64],
    ) -> SmoothedVariance {
        let lines = self.variance.len();
        let max_ratio = self.max_outlier_ratio();
        let segment_level = |(lines, b): (&Range<usize>, &f64)| {
            self.mean_response_noise(lines.clone(), *b, max_ratio)
        };
        let of_response: Vec<f64> = segments
            .iter()
            .zip(force_noise_coefficient)
            .map(segment_level)
            .collect();
        let mut smooth = SmoothedVariance {
            variance: Vec::with_capacity(lines),
            force_fraction: Vec::with_capacity(lines),
        };
        for start in (0..lines).step_by(BLOCK_LINES) {
            let block = start..(start + BLOCK_LINES).min(lines);
            let around = start.saturating_sub(MARGIN_LINES)..(block.end + MARGIN_LINES).min(lines);
            let position = (block.start as f64 + 0.5 * BLOCK_LINES as f64) / lines as f64;
            let (b, response) = (
                interpolate(force_noise_coefficient, position),
                interpolate(&of_response, position),
            );
            let fraction = |force: f64, response: f64| {
                let ratio = force / (response + force);
                if ratio.is_finite() { ratio } else { 0.0 }
            };
            let force = self.power[block.clone()].iter().map(|p| b * p);
            if let Some(stated) = &self.response_noise {
                for (a, force) in stated[block].iter().zip(force) {
                    smooth.variance.push(a + force);
                    smooth.force_fraction.push(fraction(force, *a));
                }
                continue;
            }
            let a = self.mean_response_noise(around, b, max_ratio);
            for (estimate, force) in self.variance[block].iter().zip(force) {
                let is_outlier = *estimate > max_ratio * (a + force);
                smooth
                    .variance
                    .push(if is_outlier { *estimate } else { a + force });
                // Of a few dozen lines, `a` absorbs the random error of b.
                let force_fraction = fraction(force, response);
                smooth
                    .force_fraction
                    .push(if is_outlier { 0.0 } else { force_fraction });
            }
        }
        smooth
    }

    fn freedom(&self) -> f64 {
        let stated = self.degrees_of_freedom.filter(|freedom| *freedom > 0.0);
        stated.unwrap_or(DEFAULT_FREEDOM).clamp(1.0, MAX_FREEDOM)
    }

    /// Ratio of a variance to its expectation above which the line is an outlier.
    fn max_outlier_ratio(&self) -> f64 {
        let quantile = ChiSquared::new(self.freedom());
        quantile.map_or(f64::INFINITY, |chi| {
            chi.inverse_cdf(1.0 - OUTLIER_PROBABILITY) / self.freedom()
        })
    }

    /// Information on b where there is little of it, `Σ p²/v²` with the mean of v.
    fn information(&self) -> f64 {
        let squares: f64 = self.power.iter().map(|p| p * p).sum();
        let variance: f64 = self.variance.iter().sum();
        squares / (variance / self.variance.len() as f64).powi(2)
    }

    /// `a` of some lines for a given b: the mean of the variances minus force noise, weighted by
    /// their expectation, without outliers.
    fn mean_response_noise(&self, lines: Range<usize>, b: f64, max_ratio: f64) -> f64 {
        if let Some(response_noise) = &self.response_noise {
            return response_noise[lines.clone()].iter().sum::<f64>() / lines.len() as f64;
        }
        let median = self.median(lines.clone());
        self.mean_from_median(median, lines, b, max_ratio)
    }

    /// Median of the variances of some lines.
    fn median(&self, lines: Range<usize>) -> f64 {
        let mut sorted = self.variance[lines].to_vec();
        let middle = sorted.len() / 2;
        *sorted.select_nth_unstable_by(middle, f64::total_cmp).1
    }

    fn mean_from_median(&self, median: f64, lines: Range<usize>, b: f64, max_ratio: f64) -> f64 {
        let (variance, power) = (&self.variance[lines.clone()], &self.power[lines]);
        let minimum = MIN_RESPONSE_NOISE_RATIO * median;
        vectorised(
            #[inline(always)]
            || {
                let mut a = median;
                for _ in 0..WEIGHT_ITERATIONS {
                    let mean = weighted_mean(variance, power, a, b, max_ratio);
                    a = mean.map_or(a, |mean| mean.max(minimum));
                }
                a
            },
        )
    }

    /// Log-likelihood of every trial value of b, with the median of the variances.
    fn likelihoods(&self, median: f64, tried: &[f64], max_ratio: f64) -> Vec<f64> {
        let (variance, power) = (&self.variance, &self.power);
        let of = |b: &f64| {
            let sum = if let Some(noise) = &self.response_noise {
                deviance(noise, variance, power, *b, max_ratio)
            } else {
                let mean = self.mean_from_median(median, 0..variance.len(), *b, max_ratio);
                deviance(&vec![mean; variance.len()], variance, power, *b, max_ratio)
            };
            -0.5 * self.freedom() / self.lines_per_effective_line * sum
        };
        tried.iter().map(of).collect()
    }
}

/// Lines that are processed at once, and number of factors before the product of their mantissas
/// could overflow.
const LANES: usize = 8;
const FACTORS: usize = 256;

/// `Σ ln(a + b p) + min(v/(a + b p), max_ratio)` over lines of a, v and p; 0 where all a are 0: the
/// response noise is then undetermined.
///
/// The sum of logarithms is that of a product, kept as mantissas and exponents: a logarithm for
/// each would be most of the work of an identification of many FRFs.
fn deviance(response: &[f64], variance: &[f64], power: &[f64], b: f64, max_ratio: f64) -> f64 {
    if !response.iter().any(|a| *a > 0.0) {
        return 0.0;
    }
    vectorised(
        #[inline(always)]
        || sum_of_deviances(response, variance, power, b, max_ratio),
    )
}

#[inline(always)]
fn sum_of_deviances(
    response: &[f64],
    variance: &[f64],
    power: &[f64],
    b: f64,
    max_ratio: f64,
) -> f64 {
    let mut total = 0.0;
    for start in (0..response.len()).step_by(LANES * FACTORS) {
        let lines = start..(start + LANES * FACTORS).min(response.len());
        let mut sums = Lanes::new();
        let (response, last_response) = response[lines.clone()].as_chunks::<LANES>();
        let (variance, last_variance) = variance[lines.clone()].as_chunks::<LANES>();
        let (power, last_power) = power[lines].as_chunks::<LANES>();
        for ((response, variance), power) in response.iter().zip(variance).zip(power) {
            for lane in 0..LANES {
                sums.add(
                    lane,
                    response[lane] + b * power[lane],
                    variance[lane],
                    max_ratio,
                );
            }
        }
        for lane in 0..last_response.len() {
            let expected = last_response[lane] + b * last_power[lane];
            sums.add(lane, expected, last_variance[lane], max_ratio);
        }
        total += sums.total();
    }
    total
}

/// Mean of `v - b p` over the lines of v and p with the weights `1/(a + b p)²`, without lines whose
/// v exceeds `max_ratio (a + b p)`; `None` where no line is left.
#[inline(always)]
fn weighted_mean(variance: &[f64], power: &[f64], a: f64, b: f64, max_ratio: f64) -> Option<f64> {
    let mut sums = WeightedSums {
        values: [0.0; LANES],
        weights: [0.0; LANES],
    };
    let (variance, last_variance) = variance.as_chunks::<LANES>();
    let (power, last_power) = power.as_chunks::<LANES>();
    for (variance, power) in variance.iter().zip(power) {
        for lane in 0..LANES {
            sums.add(lane, a, variance[lane], b * power[lane], max_ratio);
        }
    }
    for lane in 0..last_variance.len() {
        sums.add(
            lane,
            a,
            last_variance[lane],
            b * last_power[lane],
            max_ratio,
        );
    }
    let weights: f64 = sums.weights.iter().sum();
    (weights > 0.0).then(|| sums.values.iter().sum::<f64>() / weights)
}

/// Sums of a weighted mean, lane by lane, with the weights times a².
struct WeightedSums {
    values: [f64; LANES],
    weights: [f64; LANES],
}

impl WeightedSums {
    #[inline(always)]
    fn add(&mut self, lane: usize, a: f64, variance: f64, force: f64, max_ratio: f64) {
        let expected = a + force;
        let is_noise = expected > 0.0 && variance <= max_ratio * expected;
        let ratio = a / expected;
        let weight = if is_noise { ratio * ratio } else { 0.0 };
        let value = if is_noise { variance - force } else { 0.0 };
        self.values[lane] += weight * value;
        self.weights[lane] += weight;
    }
}

/// Sums of logarithms and ratios, lane by lane.
struct Lanes {
    mantissas: [f64; LANES],
    exponents: [i64; LANES],
    ratios: [f64; LANES],
}

impl Lanes {
    fn new() -> Self {
        Self {
            mantissas: [1.0; LANES],
            exponents: [0; LANES],
            ratios: [0.0; LANES],
        }
    }

    #[inline(always)]
    fn add(&mut self, lane: usize, expected: f64, variance: f64, max_ratio: f64) {
        let expected = expected.max(f64::MIN_POSITIVE);
        let (mantissa, exponent) = mantissa_and_exponent(expected);
        self.mantissas[lane] *= mantissa;
        self.exponents[lane] += exponent;
        self.ratios[lane] += (variance / expected).min(max_ratio);
    }

    fn total(&self) -> f64 {
        let exponent: i64 = self.exponents.iter().sum();
        let logarithm: f64 = self.mantissas.iter().map(|m| m.ln()).sum();
        logarithm + std::f64::consts::LN_2 * exponent as f64 + self.ratios.iter().sum::<f64>()
    }
}

/// A positive normal number as `m 2^e`, m from 1 up to 2.
#[inline(always)]
fn mantissa_and_exponent(value: f64) -> (f64, i64) {
    const MANTISSA: u64 = (1 << 52) - 1;
    let bits = value.to_bits();
    let one = 1.0f64.to_bits();
    (
        f64::from_bits(bits & MANTISSA | one),
        (bits >> 52) as i64 - 1023,
    )
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::Distribution;

    use crate::identify::noise::variance_model::*;

    const LINES: usize = 400;

    /// A resonance of `width` lines at line 200 with the height 1.
    fn resonance(width: f64) -> Vec<Complex64> {
        let line = |k: usize| 0.5 * width / Complex64::new(0.5 * width, k as f64 - 200.2);
        (0..LINES).map(line).collect()
    }

    /// Variances as they are estimated from ν degrees of freedom.
    fn estimated(truth: &[f64], freedom: f64, seed: u64) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let scatter = rand_distr::ChiSquared::new(freedom).unwrap();
        let draw = |v: &f64| v * scatter.sample(&mut random) / freedom;
        truth.iter().map(draw).collect()
    }

    fn smoothed(
        variance: &[f64],
        values: &[Complex64],
        degrees_of_freedom: Option<f64>,
    ) -> SmoothedVariance {
        let samples = VarianceSamples {
            variance: variance.to_vec(),
            power: values.iter().map(Complex64::norm_sqr).collect(),
            degrees_of_freedom,
            lines_per_effective_line: 1.0,
            response_noise: None,
        };
        smooth(&[samples][..], |_, smooth| smooth).remove(0)
    }

    #[test]
    fn constant_variances_are_smoothed_to_their_mean() {
        let truth = vec![3.0; LINES];
        let same = smoothed(&truth, &resonance(2.0), None).variance;
        assert!(same.iter().all(|v| (v / 3.0 - 1.0).abs() < 1e-12));
        // 64 lines of 4 degrees of freedom: 9 %, and sometimes a resonance above it at random.
        let mut squares = 0.0;
        for seed in 0..20 {
            let smooth = smoothed(&estimated(&truth, 4.0, seed), &resonance(2.0), Some(4.0));
            let variance = smooth.variance;
            squares += variance
                .iter()
                .map(|v| (v / 3.0 - 1.0).powi(2))
                .sum::<f64>();
        }
        let deviation = (squares / (20 * LINES) as f64).sqrt();
        assert!(deviation < 0.12, "{deviation}");
    }

    #[test]
    fn force_noise_is_estimated_at_a_resonance_of_few_lines() {
        let values = resonance(2.0);
        let truth: Vec<f64> = values.iter().map(|h| 1e-4 + 0.01 * h.norm_sqr()).collect();
        let exact = smoothed(&truth, &values, None);
        assert!(exact.force_fraction[200] > 0.98 && exact.force_fraction[0] < 1e-2);
        // Away from the resonance its skirt is too small to be estimated.
        for (k, (estimate, expected)) in exact.variance.iter().zip(&truth).enumerate() {
            let tolerance = if k.abs_diff(200) < 8 { 0.02 } else { 0.05 };
            assert!(
                (estimate / expected - 1.0).abs() < tolerance,
                "{estimate} {expected}"
            );
        }
        let mut peak = 0.0;
        for seed in 0..200 {
            let smooth = smoothed(&estimated(&truth, 4.0, seed), &values, Some(4.0));
            peak += smooth.variance[200] / truth[200] / 200.0;
        }
        // Some four lines of the resonance determine its height to a third: their mean to 3 %.
        assert!((0.85..1.1).contains(&peak), "{peak}");
    }

    #[test]
    fn force_noise_is_found_beside_frfs_without_response() {
        // Two of three FRFs have no response, and all together just show the force noise.
        let coefficient = 1.5e-5;
        let samples = |f: u64| {
            let values = resonance(20.0);
            let scale = if f.is_multiple_of(3) { 1.0 } else { 1e-6 };
            let power: Vec<f64> = values.iter().map(|h| scale * h.norm_sqr()).collect();
            let truth: Vec<f64> = power.iter().map(|p| 1e-4 + coefficient * p).collect();
            VarianceSamples {
                variance: estimated(&truth, 4.0, f),
                power,
                degrees_of_freedom: Some(4.0),
                lines_per_effective_line: 1.0,
                response_noise: Some(vec![1e-4; LINES]),
            }
        };
        let mut found = 0;
        for draw in 0..8 {
            let all: Vec<VarianceSamples> = (0..384).map(|f| samples(1000 * draw + f)).collect();
            let b = per_segment(&all[..], &segments(LINES), f64::INFINITY)[0];
            found += usize::from((b / coefficient - 1.0).abs() < 0.5);
        }
        assert!(found >= 7, "{found} of 8");
    }

    #[test]
    fn sum_of_logarithms_equals_the_logarithm_of_the_product() {
        // More lines than one product holds, over the whole range of exponents, and a remainder
        // after the last full set of lanes.
        let count = 2 * LANES * FACTORS + 3;
        let response: Vec<f64> = (0..count)
            .map(|k| 10f64.powf(0.03 * (k as f64 - 4000.0)))
            .collect();
        let (variance, power) = (
            vec![1.0; count],
            response.iter().map(|a| 2.0 * a).collect::<Vec<_>>(),
        );
        let expected = |a: &f64| (1.2 * a).ln() + (1.0 / (1.2 * a)).min(3.0);
        let sum: f64 = response.iter().map(expected).sum();
        let computed = deviance(&response, &variance, &power, 0.1, 3.0);
        // 8195 terms of up to 300 each.
        assert!((computed - sum).abs() < 1e-9, "{computed} {sum}");
        assert!(deviance(&[0.0], &[1.0], &[1.0], 0.1, 3.0).abs() < f64::MIN_POSITIVE);
    }

    #[test]
    fn a_mains_line_keeps_its_variance_and_does_not_change_its_neighbours() {
        let mut variance = vec![1.0; LINES];
        variance[100] = 1e4;
        let smooth = smoothed(&variance, &resonance(2.0), Some(4.0)).variance;
        assert!((smooth[100] - 1e4).abs() < 1e-9);
        assert!(
            smooth[99] < 1.5 && smooth[101] < 1.5,
            "{} {}",
            smooth[99],
            smooth[101]
        );
    }
}
