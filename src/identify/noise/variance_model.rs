//! The course of variances over the lines: noise of the responses, and noise of the force
//! times |H|².
//!
//! An FRF from hits has the variance `(S_nn + |H|² S_mm)/S_ff` with noise `n` of the response and
//! `m` of the force (Bendat and Piersol 1980): `v = a + b p`, `p = |H|²`, which in a resonance of
//! few lines rises far above its neighbourhood. `a` is each function's own and even over a few
//! dozen lines; `b` is that of a hit point and even over hundreds. Variances told from `ν` degrees
//! of freedom are gamma variables, of the likelihood `(ν/2) Σ (−ln(a + b p) − v/(a + b p))` but for
//! a constant. Windows let neighbouring lines scatter together, so that b, told from a few dozen
//! lines of few hits, would be a matter of chance.

use std::ops::Range;

use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::linalg::vectorised;

/// Lines that one `a` holds for, and further lines on either side that it is told from.
const OWN: usize = 16;
const BESIDE: usize = 24;
/// Stretches that one `b` is told from: no shorter than this, and no more than so many.
const LONG: usize = 256;
const STRETCHES: usize = 16;
/// Rounds of weighting for `a`.
const ROUNDS: usize = 3;
/// Values of b that are tried: from that of noise of the force alone downwards, each so much below
/// the last.
const TRIED: usize = 12;
const RATIO: f64 = 2.5;
/// Steps between two of them, each of which leaves two thirds.
const THIRDS: usize = 12;
/// Largest b that what a fit leaves over may tell: 5 % of the response. A pole that moves from
/// function to function leaves over more in its resonance, and that is no noise.
const MOST_LEFT_OVER: f64 = 2.5e-3;
/// Logarithm of the likelihood that b must gain over none.
const GAIN: f64 = 10.0;
/// Probability of a variance so far above the course that the line is noisier than its neighbours,
/// as that of the mains is.
const BY_CHANCE: f64 = 1e-6;
/// Degrees of freedom where the data do not state them: those of three averages.
const UNSTATED: f64 = 4.0;
/// Degrees of freedom beyond which variances hardly scatter.
const KNOWN: f64 = 1e4;
/// Least part of the course over the mean: below it lie rounding and zeros.
const LEAST: f64 = 1e-6;

/// Variances of one function as they are estimated.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct Estimated {
    /// v at every line.
    pub variance: Vec<f64>,
    /// |H|² at every line.
    pub power: Vec<f64>,
    /// ν, where it is known.
    pub degrees_of_freedom: Option<f64>,
    /// Lines that count for one.
    pub alike: f64,
    /// `a` at every line, where something else tells it; what stands out is then not noise.
    pub own: Option<Vec<f64>>,
}

/// Variances without their scatter.
#[derive(Clone, Debug, PartialEq, Default)]
pub(in crate::identify) struct Smooth {
    /// a + b p at every line.
    pub variance: Vec<f64>,
    /// The part of it that is b p: noise of the force.
    pub by_force: Vec<f64>,
}

/// The course of the variances of all functions of one hit point; a variance that is far above its
/// neighbours stays as it is.
pub(in crate::identify) fn smooth(functions: &[&Estimated]) -> Vec<Smooth> {
    let lines = functions
        .iter()
        .map(|own| own.variance.len())
        .max()
        .unwrap_or(0);
    let stretches = stretches(lines);
    let left_over = functions.iter().any(|own| own.own.is_some());
    let limit = if left_over {
        MOST_LEFT_OVER
    } else {
        f64::INFINITY
    };
    let by_power = by_stretch(functions, &stretches, limit);
    let course = |own: &&Estimated| {
        let most = own.most();
        let long = |(lines, b): (&Range<usize>, &f64)| own.even(lines.clone(), *b, most);
        let of_response: Vec<f64> = stretches.iter().zip(&by_power).map(long).collect();
        let mut smooth = Smooth {
            variance: Vec::with_capacity(lines),
            by_force: Vec::with_capacity(lines),
        };
        for start in (0..own.variance.len()).step_by(OWN) {
            let block = start..(start + OWN).min(own.variance.len());
            let near = start.saturating_sub(BESIDE)..(block.end + BESIDE).min(own.variance.len());
            let place = (block.start as f64 + 0.5 * OWN as f64) / lines as f64;
            let (b, response) = (between(&by_power, place), between(&of_response, place));
            let share = |force: f64, response: f64| {
                let share = force / (response + force);
                if share.is_finite() { share } else { 0.0 }
            };
            let force = own.power[block.clone()].iter().map(|p| b * p);
            if let Some(stated) = &own.own {
                for (a, force) in stated[block].iter().zip(force) {
                    smooth.variance.push(a + force);
                    smooth.by_force.push(share(force, *a));
                }
                continue;
            }
            let a = own.even(near, b, most);
            for (told, force) in own.variance[block].iter().zip(force) {
                let outstanding = *told > most * (a + force);
                smooth
                    .variance
                    .push(if outstanding { *told } else { a + force });
                // Of a few dozen lines, `a` takes what b misses by chance.
                let by_force = share(force, response);
                smooth
                    .by_force
                    .push(if outstanding { 0.0 } else { by_force });
            }
        }
        smooth
    };
    functions.par_iter().map(course).collect()
}

/// b at every line, of all functions of one hit point; no more than what a fit leaves over may
/// tell.
pub(in crate::identify) fn by_power(functions: &[&Estimated]) -> Vec<f64> {
    let lines = functions.first().map_or(0, |own| own.variance.len());
    let told = by_stretch(functions, &stretches(lines), MOST_LEFT_OVER);
    let place = |k: usize| (k as f64 + 0.5) / lines as f64;
    (0..lines).map(|k| between(&told, place(k))).collect()
}

/// Lines that one b holds for.
fn stretches(lines: usize) -> Vec<Range<usize>> {
    let count = (lines / LONG).clamp(1, STRETCHES);
    let edge = |n: usize| n * lines / count;
    (0..count).map(|n| edge(n)..edge(n + 1)).collect()
}

/// A value per stretch, straight between their middles.
fn between(values: &[f64], place: f64) -> f64 {
    let at = (place * values.len() as f64 - 0.5).clamp(0.0, (values.len() - 1) as f64);
    let first = at.floor() as usize;
    let next = (first + 1).min(values.len() - 1);
    values[first] + (at - first as f64) * (values[next] - values[first])
}

/// b of every stretch. The noise of a force does not end with a stretch: one that says nothing has
/// that of the nearest that does, unless it speaks against that.
fn by_stretch(functions: &[&Estimated], stretches: &[Range<usize>], limit: f64) -> Vec<f64> {
    let most: Vec<f64> = functions.iter().map(|own| own.most()).collect();
    let likelihoods = |n: usize, tried: &[f64]| -> Vec<f64> {
        let mut sums = vec![0.0; tried.len()];
        for (own, most) in functions.iter().zip(&most) {
            let told = own.likelihoods(stretches[n].clone(), tried, *most);
            sums.iter_mut()
                .zip(told)
                .for_each(|(sum, told)| *sum += told);
        }
        sums
    };
    let mean = |n: usize, own: &&Estimated| {
        let sum = |values: &[f64]| values[stretches[n].clone()].iter().sum::<f64>();
        sum(&own.variance) / sum(&own.power)
    };
    let likeliest = |n: usize| -> Option<f64> {
        let means = functions.iter().map(|own| mean(n, own));
        let most = means.filter(|b| b.is_finite()).fold(0.0, f64::max);
        let most = most.min(limit);
        let tried = (0..TRIED).map(|step| most * RATIO * RATIO.powi(-(step as i32)));
        let tried: Vec<f64> = std::iter::once(0.0).chain(tried).collect();
        let told = likelihoods(n, &tried);
        let best = (1..tried.len()).max_by(|a, b| told[*a].total_cmp(&told[*b]))?;
        // Between two that are tried there may be twice the gain.
        if told[best] <= told[0] + 0.5 * GAIN {
            return None;
        }
        let (mut low, mut high) = (tried[best] / RATIO, tried[best] * RATIO);
        for _ in 0..THIRDS {
            let third = (high - low) / 3.0;
            let told = likelihoods(n, &[low + third, high - third]);
            if told[0] < told[1] {
                low += third;
            } else {
                high -= third;
            }
        }
        let b = 0.5 * (low + high);
        let gain = likelihoods(n, &[b])[0] - told[0];
        (gain > GAIN && b <= limit).then_some(b)
    };
    let told: Vec<Option<f64>> = (0..stretches.len())
        .into_par_iter()
        .map(likeliest)
        .collect();
    let filled = |n: usize| {
        told[n].or_else(|| {
            let others = (0..told.len()).filter_map(|m| Some((m.abs_diff(n), told[m]?)));
            let (_, near) = others.min_by_key(|(distance, _)| *distance)?;
            let told = likelihoods(n, &[0.0, near]);
            (told[1] > told[0] - GAIN).then_some(near)
        })
    };
    (0..told.len())
        .into_par_iter()
        .map(|n| filled(n).unwrap_or(0.0))
        .collect()
}

impl Estimated {
    fn freedom(&self) -> f64 {
        let stated = self.degrees_of_freedom.filter(|freedom| *freedom > 0.0);
        stated.unwrap_or(UNSTATED).clamp(1.0, KNOWN)
    }

    /// Factor by which a variance exceeds its expectation only when the line is another's.
    fn most(&self) -> f64 {
        let quantile = ChiSquared::new(self.freedom());
        quantile.map_or(f64::INFINITY, |chi| {
            chi.inverse_cdf(1.0 - BY_CHANCE) / self.freedom()
        })
    }

    /// `a` of some lines beside a b: the mean of what is left, lines by their expectation, without
    /// those that are another's.
    fn even(&self, lines: Range<usize>, b: f64, most: f64) -> f64 {
        if let Some(own) = &self.own {
            return own[lines.clone()].iter().sum::<f64>() / lines.len() as f64;
        }
        let (variance, power) = (&self.variance[lines.clone()], &self.power[lines]);
        let mut sorted = variance.to_vec();
        let middle = sorted.len() / 2;
        let median = *sorted.select_nth_unstable_by(middle, f64::total_cmp).1;
        let least = LEAST * median;
        let mut a = median;
        for _ in 0..ROUNDS {
            let (mut sum, mut weights) = (0.0, 0.0);
            for (v, p) in variance.iter().zip(power) {
                let expected = a + b * p;
                if expected > 0.0 && *v <= most * expected {
                    let weight = (median / expected).powi(2);
                    sum += weight * (v - b * p);
                    weights += weight;
                }
            }
            a = if weights > 0.0 {
                (sum / weights).max(least)
            } else {
                a
            };
        }
        a
    }

    /// Of every b that is tried.
    fn likelihoods(&self, lines: Range<usize>, tried: &[f64], most: f64) -> Vec<f64> {
        let (variance, power) = (&self.variance[lines.clone()], &self.power[lines.clone()]);
        let even = |b: f64| vec![self.even(lines.clone(), b, most); variance.len()];
        let of = |b: &f64| {
            let own = self.own.as_ref().map(|own| &own[lines.clone()]);
            let sum = match own {
                Some(own) => deviance((own, variance, power), *b, most),
                None => deviance((&even(*b), variance, power), *b, most),
            };
            -0.5 * self.freedom() / self.alike * sum
        };
        tried.iter().map(of).collect()
    }
}

/// Lines that are reckoned with at once, and so often before the product of their mantissas could
/// overflow.
const LANES: usize = 8;
const FACTORS: usize = 256;

/// `Σ ln(a + b p) + min(v/(a + b p), most)` over lines of a, v and p; 0 where all a are 0: nothing
/// is known of such noise.
///
/// The sum of logarithms is that of a product, kept as mantissas and exponents: a logarithm for
/// each would be most of the work of an identification of many functions.
fn deviance((own, variance, power): (&[f64], &[f64], &[f64]), b: f64, most: f64) -> f64 {
    if !own.iter().any(|a| *a > 0.0) {
        return 0.0;
    }
    vectorised(
        #[inline(always)]
        || sum_of_deviances((own, variance, power), b, most),
    )
}

#[inline(always)]
fn sum_of_deviances((own, variance, power): (&[f64], &[f64], &[f64]), b: f64, most: f64) -> f64 {
    let mut total = 0.0;
    for start in (0..own.len()).step_by(LANES * FACTORS) {
        let lines = start..(start + LANES * FACTORS).min(own.len());
        let mut sums = Lanes::new();
        let (own, last_own) = own[lines.clone()].as_chunks::<LANES>();
        let (variance, last_variance) = variance[lines.clone()].as_chunks::<LANES>();
        let (power, last_power) = power[lines].as_chunks::<LANES>();
        for ((own, variance), power) in own.iter().zip(variance).zip(power) {
            for lane in 0..LANES {
                sums.add(lane, own[lane] + b * power[lane], (variance[lane], most));
            }
        }
        for lane in 0..last_own.len() {
            let expected = last_own[lane] + b * last_power[lane];
            sums.add(lane, expected, (last_variance[lane], most));
        }
        total += sums.total();
    }
    total
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
    fn add(&mut self, lane: usize, expected: f64, (variance, most): (f64, f64)) {
        let expected = expected.max(f64::MIN_POSITIVE);
        let (mantissa, exponent) = parts(expected);
        self.mantissas[lane] *= mantissa;
        self.exponents[lane] += exponent;
        self.ratios[lane] += (variance / expected).min(most);
    }

    fn total(&self) -> f64 {
        let exponent: i64 = self.exponents.iter().sum();
        let logarithm: f64 = self.mantissas.iter().map(|m| m.ln()).sum();
        logarithm + std::f64::consts::LN_2 * exponent as f64 + self.ratios.iter().sum::<f64>()
    }
}

/// A positive normal number as `m 2^e`, m from 1 up to 2.
#[inline(always)]
fn parts(value: f64) -> (f64, i64) {
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

    /// A resonance of so many lines at line 200 with the height 1.
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

    fn course(variance: &[f64], values: &[Complex64], degrees_of_freedom: Option<f64>) -> Smooth {
        let own = Estimated {
            variance: variance.to_vec(),
            power: values.iter().map(Complex64::norm_sqr).collect(),
            degrees_of_freedom,
            alike: 1.0,
            own: None,
        };
        smooth(&[&own]).remove(0)
    }

    #[test]
    fn even_variances_come_back_without_their_scatter() {
        let truth = vec![3.0; LINES];
        let same = course(&truth, &resonance(2.0), None).variance;
        assert!(same.iter().all(|v| (v / 3.0 - 1.0).abs() < 1e-12));
        // 64 lines of 4 degrees of freedom: 9 %, and now and then a resonance that stands over it
        // by chance.
        let mut squares = 0.0;
        for seed in 0..20 {
            let told = course(&estimated(&truth, 4.0, seed), &resonance(2.0), Some(4.0));
            let told = told.variance;
            squares += told.iter().map(|v| (v / 3.0 - 1.0).powi(2)).sum::<f64>();
        }
        let deviation = (squares / (20 * LINES) as f64).sqrt();
        assert!(deviation < 0.12, "{deviation}");
    }

    #[test]
    fn noise_of_the_force_stands_over_a_resonance_of_few_lines() {
        let values = resonance(2.0);
        let truth: Vec<f64> = values.iter().map(|h| 1e-4 + 0.01 * h.norm_sqr()).collect();
        let exact = course(&truth, &values, None);
        assert!(exact.by_force[200] > 0.98 && exact.by_force[0] < 1e-2);
        // Away from the resonance its skirt is too little to be told.
        for (k, (told, expected)) in exact.variance.iter().zip(&truth).enumerate() {
            let most = if k.abs_diff(200) < 8 { 0.02 } else { 0.05 };
            assert!((told / expected - 1.0).abs() < most, "{told} {expected}");
        }
        let mut peak = 0.0;
        for seed in 0..200 {
            let told = course(&estimated(&truth, 4.0, seed), &values, Some(4.0));
            peak += told.variance[200] / truth[200] / 200.0;
        }
        // Some four lines of the resonance tell its height to a third: their mean to 3 %.
        assert!((0.85..1.1).contains(&peak), "{peak}");
    }

    #[test]
    fn the_sum_of_logarithms_is_that_of_a_product() {
        // More lines than one product holds, over the whole range of exponents, and a rest behind
        // the lanes.
        let count = 2 * LANES * FACTORS + 3;
        let own: Vec<f64> = (0..count)
            .map(|k| 10f64.powf(0.03 * (k as f64 - 4000.0)))
            .collect();
        let (variance, power) = (
            vec![1.0; count],
            own.iter().map(|a| 2.0 * a).collect::<Vec<_>>(),
        );
        let expected = |a: &f64| (1.2 * a).ln() + (1.0 / (1.2 * a)).min(3.0);
        let sum: f64 = own.iter().map(expected).sum();
        let told = deviance((&own, &variance, &power), 0.1, 3.0);
        // 8195 terms of up to 300 each.
        assert!((told - sum).abs() < 1e-9, "{told} {sum}");
        assert!(deviance((&[0.0], &[1.0], &[1.0]), 0.1, 3.0).abs() < f64::MIN_POSITIVE);
    }

    #[test]
    fn a_line_of_the_mains_stays_noisy_and_leaves_its_neighbours_alone() {
        let mut variance = vec![1.0; LINES];
        variance[100] = 1e4;
        let told = course(&variance, &resonance(2.0), Some(4.0)).variance;
        assert!((told[100] - 1e4).abs() < 1e-9);
        assert!(
            told[99] < 1.5 && told[101] < 1.5,
            "{} {}",
            told[99],
            told[101]
        );
    }
}
