//! The noise variance of a measured function, line by line, from the best source there is.
//!
//! In this order: the variances that came with the data; coherence and number of averages (two or
//! more), `var H = |H|² (1 − γ²)/(γ² (n − 1))` as in [`frf`](crate::frf); else the data alone, and
//! then what a fit leaves over of them. Variances of a few averages scatter widely, and a value
//! that is small by chance makes noise look like a signal: their course over the lines counts
//! ([`noise_course`](crate::identify::noise::variance_model)).

use std::collections::BTreeMap;
use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::dof::Dof;
use crate::frf::{FrfSet, Function, variance_from_coherence};

use crate::identify::noise::force_noise::told_by_variances;
use crate::identify::noise::variance_model::{self, Estimated, Smooth};

/// Lines on either side that a running median looks at, and lines between two evaluations of it.
const REACH: usize = 64;
const HOPS_PER_REACH: usize = 2;
/// The same of a level that lines share, as a part of all.
const LEVEL_REACH: usize = 16;
/// Lines of white noise whose second differences tell as much as one: 1 + 2 (4² + 1²)/6².
const DIFFERENCES_ALIKE: f64 = 35.0 / 18.0;
/// Relative floor of a variance, so that data without any noise can still be divided by it.
const FLOOR: f64 = 1e-24;

/// Variances of one function.
pub(in crate::identify) struct Noise {
    /// E|H − E H|² at every line, in the squared unit of the function.
    pub variance: Vec<f64>,
    /// Part of it that goes with |H|²; 0 where it is not known.
    pub by_force: Vec<f64>,
    /// Whether the data brought them (variance or coherence).
    pub measured: bool,
    /// Part of the force's noise that the functions of its hit point share, as far as their
    /// variances tell.
    pub shared: f64,
}

/// Variances of all functions of a set on some lines.
pub(in crate::identify) fn of_set(set: &FrfSet, lines: &Range<usize>) -> Vec<Noise> {
    let estimated: Vec<Option<Estimated>> = (0..set.len())
        .map(|i| estimated(set, i, lines.clone()))
        .collect();
    let mut hits: BTreeMap<&Dof, Vec<usize>> = BTreeMap::new();
    for (i, function) in set.functions().iter().enumerate() {
        if estimated[i].is_some() {
            hits.entry(&function.reference).or_default().push(i);
        }
    }
    let mut measured = BTreeMap::new();
    for group in hits.into_values() {
        let own: Vec<&Estimated> = group
            .iter()
            .filter_map(|i| estimated[*i].as_ref())
            .collect();
        let smooth = variance_model::smooth(&own);
        let shared = told_by_variances(&own, &smooth);
        let told = smooth.into_iter().map(|own| (own, shared));
        measured.extend(group.into_iter().zip(told));
    }
    let of_function = |i: usize| {
        let values = &set.values(i)[lines.clone()];
        let told: Option<&(Smooth, f64)> = measured.get(&i);
        let mut own = told.map_or_else(
            || Smooth {
                variance: Squares::of_second_differences(values).variance(),
                by_force: vec![0.0; values.len()],
            },
            |(own, _)| own.clone(),
        );
        raise_to_floor(&mut own.variance, values.iter().map(Complex64::norm_sqr));
        Noise {
            variance: own.variance,
            by_force: own.by_force,
            measured: told.is_some(),
            shared: told.map_or(0.0, |(_, shared)| *shared),
        }
    };
    (0..set.len()).into_par_iter().map(of_function).collect()
}

/// The variances that the data bring of a function.
fn estimated(set: &FrfSet, i: usize, lines: Range<usize>) -> Option<Estimated> {
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
    Some(Estimated {
        variance,
        power: values.iter().map(Complex64::norm_sqr).collect(),
        degrees_of_freedom: variance_dof.or(by_averages),
        alike: 1.0,
        own: None,
    })
}

/// Squares of which a running median is the variance of noise.
pub(in crate::identify) struct Squares {
    pub values: Vec<f64>,
    reach: usize,
    /// Lines of white noise whose second differences tell as much as one; `None` where the squares
    /// are those of a level.
    pub differences_alike: Option<f64>,
}

impl Squares {
    /// White noise of variance `v` on a smooth function: the second difference `h₋ − 2h + h₊` has
    /// variance `6v`, and the median of its squared magnitude is `6v ln 2`. Resonances take few
    /// lines and do not move the median.
    pub fn of_second_differences(values: &[Complex64]) -> Self {
        let scale = (6.0 * std::f64::consts::LN_2).recip();
        let square =
            |k: usize| (values[k - 1] - 2.0 * values[k] + values[k + 1]).norm_sqr() * scale;
        let last = values.len() - 2;
        // The first and the last line have those of their neighbours.
        let own = (0..values.len()).map(|k| square(k.clamp(1, last)));
        Self {
            values: own.collect(),
            reach: REACH,
            differences_alike: Some(DIFFERENCES_ALIKE),
        }
    }

    /// Noise of variance `v`: the median of its squared magnitude is `v ln 2`.
    pub fn of_level(squares: &[f64]) -> Self {
        let own = squares.iter().map(|square| square / std::f64::consts::LN_2);
        Self {
            values: own.collect(),
            reach: REACH.max(squares.len() / LEVEL_REACH),
            differences_alike: None,
        }
    }

    pub fn variance(&self) -> Vec<f64> {
        running_median(&self.values, self.reach)
    }

    /// The variance `a` beside so much of the force, where the squares tell `a + f`: the median of
    /// what they exceed `f` by.
    pub fn beside(&self, force: impl Iterator<Item = f64>) -> Vec<f64> {
        let over = self.values.iter().zip(force);
        let over: Vec<f64> = over.map(|(square, force)| square - force).collect();
        running_median(&over, self.reach)
    }
}

/// Raises variances to what rounding leaves of so much power at each line.
pub(in crate::identify) fn raise_to_floor(variance: &mut [f64], power: impl Iterator<Item = f64>) {
    let mean_square = power.sum::<f64>() / variance.len() as f64;
    let floor = if mean_square > 0.0 {
        FLOOR * mean_square
    } else {
        1.0
    };
    variance.iter_mut().for_each(|v| *v = v.max(floor));
}

/// Median over `±reach` lines, evaluated twice in a reach and straight between.
fn running_median(values: &[f64], reach: usize) -> Vec<f64> {
    let (last, every) = (values.len() - 1, reach / HOPS_PER_REACH);
    let mut near = Vec::with_capacity(2 * reach + 1);
    let mut median = |centre: usize| {
        near.clear();
        near.extend_from_slice(
            &values[centre.saturating_sub(reach)..(centre + reach + 1).min(values.len())],
        );
        let middle = near.len() / 2;
        *near.select_nth_unstable_by(middle, f64::total_cmp).1
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
    use crate::identify::noise::input_variance::*;
    use crate::identify::synthetic::white_noise;

    #[test]
    fn second_differences_return_the_variance_of_white_noise_under_a_resonance() {
        let noise = white_noise(4000, 0.25, 7);
        let line = |k: usize| 50.0 / Complex64::new(3.0, k as f64 - 2000.0);
        let values: Vec<Complex64> = (0..4000).map(|k| line(k) + noise[k]).collect();
        let estimate = Squares::of_second_differences(&values).variance();
        let mean = estimate.iter().sum::<f64>() / 4000.0;
        // 129 differences per median, 126 medians that overlap: the mean is known to about 3 %.
        assert!((mean / 0.25 - 1.0).abs() < 0.06, "{mean}");
        assert!(estimate[2000] < 0.5);
    }

    #[test]
    fn a_running_median_of_what_rises_evenly_is_the_line_itself() {
        // Away from the ends, where as many lines lie on either side; from there on half of those
        // that are left.
        let rising: Vec<f64> = (0..395).map(|k| 2.0 * k as f64).collect();
        let told = running_median(&rising, 40);
        for k in 40..=340 {
            assert!((told[k] - rising[k]).abs() < 1e-12, "{k}: {}", told[k]);
        }
        let median_from = |first: usize| 2.0 * (first + (395 - first) / 2) as f64;
        for (k, told) in told.iter().enumerate().skip(360) {
            // Medians at 360, 380 and 394.
            let (at, next) = if k < 380 { (360, 380) } else { (380, 394) };
            let part = (k - at) as f64 / (next - at) as f64;
            let (own, then) = (median_from(at - 40), median_from(next - 40));
            let expected = own + part * (then - own);
            assert!((told - expected).abs() < 1e-12, "{k}: {told}");
        }
        // One value among 81 does not count.
        let mut outlier = rising.clone();
        outlier[200] = 1e9;
        let away = running_median(&outlier, 40)[200] - rising[200];
        assert!((0.0..=2.0).contains(&away), "{away}");
    }
}
