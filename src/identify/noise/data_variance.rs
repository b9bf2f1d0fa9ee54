//! The data give the noise variance of a measured FRF at every line, before any fit, from the best
//! source available.
//!
//! In this order: the variances supplied with the data; coherence and number of averages (two or
//! more), `var H = |H|² (1 − γ²)/(γ² (n − 1))` as in [`frf`](crate::frf); else the second
//! differences of the data, and later the residual of a fit. Variances of a few averages scatter
//! widely, and one that is too small by chance makes noise look significant: therefore they are
//! smoothed over the lines ([`variance_model`](crate::identify::noise::variance_model)).

use std::collections::BTreeMap;
use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::dof::Dof;
use crate::frf::{FrfSet, Function, variance_from_coherence};

use crate::identify::noise::force_noise::common_fraction_from_variances;
use crate::identify::noise::variance_model::{self, SmoothedVariance, VarianceSamples};

/// Half width of a running median, lines, and evaluations per half width.
const MEDIAN_HALF_WIDTH_LINES: usize = 64;
const EVALUATIONS_PER_HALF_WIDTH: usize = 2;
/// Half width for the level of correlated noise, as a fraction of all lines.
const LEVEL_HALF_WIDTHS_PER_BAND: usize = 16;
/// Lines of white noise whose second differences have the information of one: 1 + 2 (4² + 1²)/6².
const DIFFERENCES_PER_EFFECTIVE_LINE: f64 = 35.0 / 18.0;
/// Minimum of a variance over the mean square, so that data without noise can be divided by it.
const MIN_VARIANCE_OVER_POWER: f64 = 1e-24;

/// Variances of one FRF.
pub(in crate::identify) struct Noise {
    /// E|H − E H|² at every line, in the squared unit of the FRF.
    pub variance: Vec<f64>,
    /// Fraction proportional to |H|²; empty where it is not estimated.
    pub force_fraction: Vec<f64>,
    /// Whether the data supply them (variance or coherence).
    pub measured: bool,
    /// Common fraction of the force noise of its reference, as estimated from the variances.
    pub common_fraction: f64,
}

/// Variances of all FRFs of a set on a range of lines, each converted with its number: those of one
/// reference are held at a time.
pub(in crate::identify) fn noise_of_set<T: Clone + Send + Sync>(
    set: &FrfSet,
    lines: &Range<usize>,
    convert: impl Fn(usize, Noise) -> T + Sync,
) -> Vec<T> {
    let raised = |i: usize, mut noise: Noise| {
        let values = set.values(i)[lines.clone()].iter();
        raise_to_minimum(&mut noise.variance, values.map(Complex64::norm_sqr));
        convert(i, noise)
    };
    let mut references: BTreeMap<&Dof, Vec<usize>> = BTreeMap::new();
    for (i, function) in set.functions().iter().enumerate() {
        references.entry(&function.reference).or_default().push(i);
    }
    let mut measured = BTreeMap::new();
    for group in references.into_values() {
        let with_samples = group
            .into_par_iter()
            .filter_map(|i| Some((i, estimated(set, i, lines.clone())?)));
        let (group, samples): (Vec<usize>, Vec<VarianceSamples>) = with_samples.unzip();
        if samples.is_empty() {
            continue;
        }
        let smooth = variance_model::smooth(&samples[..], |_, smooth| smooth);
        let samples: Vec<&VarianceSamples> = samples.iter().collect();
        let common_fraction = common_fraction_from_variances(&samples, &smooth);
        let noise = |(i, smooth): (&usize, SmoothedVariance)| {
            let noise = Noise {
                variance: smooth.variance,
                force_fraction: smooth.force_fraction,
                measured: true,
                common_fraction,
            };
            (*i, raised(*i, noise))
        };
        measured.par_extend(group.par_iter().zip(smooth).map(noise));
    }
    let of_function = |i: usize| {
        let measured: Option<&T> = measured.get(&i);
        measured.cloned().unwrap_or_else(|| {
            let values = &set.values(i)[lines.clone()];
            let noise = Noise {
                variance: NoiseSquares::of_second_differences(values).variance(),
                force_fraction: Vec::new(),
                measured: false,
                common_fraction: 0.0,
            };
            raised(i, noise)
        })
    };
    (0..set.len()).into_par_iter().map(of_function).collect()
}

/// The variances that the data supply for an FRF; `None` without them, and without coherence and
/// number of averages.
fn estimated(set: &FrfSet, i: usize, lines: Range<usize>) -> Option<VarianceSamples> {
    let values = &set.values(i)[lines.clone()];
    let Function {
        averages,
        variance_dof,
        ..
    } = set.functions()[i];
    let variance = match (set.variance(i), set.coherence(i), averages) {
        (Some(variance), _, _) => variance[lines].to_vec(),
        (None, Some(coherence), Some(n)) if n >= 2 => {
            variance_from_coherence(values, &coherence[lines], n)
        }
        _ => return None,
    };
    let by_averages = averages.filter(|n| *n >= 2).map(|n| 2.0 * f64::from(n - 1));
    Some(VarianceSamples {
        variance,
        power: values.iter().map(Complex64::norm_sqr).collect(),
        degrees_of_freedom: variance_dof.or(by_averages),
        lines_per_effective_line: 1.0,
        response_noise: None,
    })
}

/// Squares whose running median is the variance of the noise.
pub(in crate::identify) struct NoiseSquares {
    pub values: Vec<f64>,
    half_width: usize,
    /// Lines of white noise whose second differences have the information of one; `None` for the
    /// squares of a level.
    pub differences_per_effective_line: Option<f64>,
}

impl NoiseSquares {
    /// White noise of variance `v` on a smooth function: the second difference `h₋ − 2h + h₊` has
    /// variance `6v`, and the median of its squared magnitude is `6v ln 2`. Resonances take few
    /// lines and do not move the median.
    pub fn of_second_differences(values: &[Complex64]) -> Self {
        let scale = (6.0 * std::f64::consts::LN_2).recip();
        let square =
            |k: usize| (values[k - 1] - 2.0 * values[k] + values[k + 1]).norm_sqr() * scale;
        let last = values.len() - 2;
        // The first and the last line have the squares of their neighbours.
        let squares = (0..values.len()).map(|k| square(k.clamp(1, last)));
        Self {
            values: squares.collect(),
            half_width: MEDIAN_HALF_WIDTH_LINES,
            differences_per_effective_line: Some(DIFFERENCES_PER_EFFECTIVE_LINE),
        }
    }

    /// Noise of variance `v`: the median of its squared magnitude is `v ln 2`.
    pub fn of_level(squares: &[f64]) -> Self {
        let scaled = squares.iter().map(|square| square / std::f64::consts::LN_2);
        Self {
            values: scaled.collect(),
            half_width: MEDIAN_HALF_WIDTH_LINES.max(squares.len() / LEVEL_HALF_WIDTHS_PER_BAND),
            differences_per_effective_line: None,
        }
    }

    /// Noise variance: the running median of the squares.
    pub fn variance(&self) -> Vec<f64> {
        running_median(&self.values, self.half_width)
    }

    /// Response noise `a` for a given force noise `f`, where the squares estimate `a + f`: the
    /// running median of the squares minus `f`.
    pub fn response_noise(&self, force: impl Iterator<Item = f64>) -> Vec<f64> {
        let excess = self.values.iter().zip(force);
        let excess: Vec<f64> = excess.map(|(square, force)| square - force).collect();
        running_median(&excess, self.half_width)
    }
}

/// Raises variances to the rounding error of the given power at each line.
pub(in crate::identify) fn raise_to_minimum(
    variance: &mut [f64],
    power: impl Iterator<Item = f64>,
) {
    let mean_square = power.sum::<f64>() / variance.len() as f64;
    let floor = if mean_square > 0.0 {
        MIN_VARIANCE_OVER_POWER * mean_square
    } else {
        1.0
    };
    variance.iter_mut().for_each(|v| *v = v.max(floor));
}

/// Median over `±half_width` lines, evaluated twice in a half width and linear between.
fn running_median(values: &[f64], half_width: usize) -> Vec<f64> {
    let (last, every) = (values.len() - 1, half_width / EVALUATIONS_PER_HALF_WIDTH);
    let mut values_around = Vec::with_capacity(2 * half_width + 1);
    let mut median = |centre: usize| {
        values_around.clear();
        values_around.extend_from_slice(
            &values[centre.saturating_sub(half_width)..(centre + half_width + 1).min(values.len())],
        );
        let middle = values_around.len() / 2;
        *values_around
            .select_nth_unstable_by(middle, f64::total_cmp)
            .1
    };
    let medians: Vec<f64> = (0..=last.div_ceil(every))
        .map(|hop| median((hop * every).min(last)))
        .collect();
    let between = |k: usize| {
        let hop = k / every;
        let Some(next) = medians.get(hop + 1) else {
            return medians[hop];
        };
        let distance = every.min(last - hop * every) as f64;
        medians[hop] + (k % every) as f64 / distance * (next - medians[hop])
    };
    (0..values.len()).map(between).collect()
}

#[cfg(test)]
mod tests {
    use crate::identify::noise::data_variance::*;
    use crate::identify::synthetic::white_noise;

    #[test]
    fn second_differences_return_the_variance_of_white_noise_under_a_resonance() {
        let noise = white_noise(4000, 0.25, 7);
        let line = |k: usize| 50.0 / Complex64::new(3.0, k as f64 - 2000.0);
        let values: Vec<Complex64> = (0..4000).map(|k| line(k) + noise[k]).collect();
        let estimate = NoiseSquares::of_second_differences(&values).variance();
        let mean = estimate.iter().sum::<f64>() / 4000.0;
        // 129 differences per median, 126 medians that overlap: the mean is known to about 3 %.
        assert!((mean / 0.25 - 1.0).abs() < 0.06, "{mean}");
        assert!(estimate[2000] < 0.5);
    }

    #[test]
    fn running_median_of_a_straight_line_is_the_line() {
        // Away from the ends the number of lines is equal on both sides; near the end the median is
        // over the remaining lines.
        let rising: Vec<f64> = (0..395).map(|k| 2.0 * k as f64).collect();
        let medians = running_median(&rising, 40);
        for k in 40..=340 {
            assert!(
                (medians[k] - rising[k]).abs() < 1e-12,
                "{k}: {}",
                medians[k]
            );
        }
        let median_from = |first: usize| 2.0 * (first + (395 - first) / 2) as f64;
        for (k, median) in medians.iter().enumerate().skip(360) {
            // Medians at 360, 380 and 394.
            let (at, next) = if k < 380 { (360, 380) } else { (380, 394) };
            let fraction = (k - at) as f64 / (next - at) as f64;
            let (here, then) = (median_from(at - 40), median_from(next - 40));
            let expected = here + fraction * (then - here);
            assert!((median - expected).abs() < 1e-12, "{k}: {median}");
        }
        // One value among 81 does not count.
        let mut outlier = rising.clone();
        outlier[200] = 1e9;
        let shift = running_median(&outlier, 40)[200] - rising[200];
        assert!((0.0..=2.0).contains(&shift), "{shift}");
    }
}
