//! Force noise: noise common to the FRFs of one reference.
//!
//! All responses to the same impacts are divided by the same force, so that its noise makes an
//! error `e H` in the direction of the response H itself: one random number per line and reference
//! instead of one per FRF. With `h = H/σ` over the noise of every FRF and `p_f` the fraction of its
//! variance that is proportional to |H|², the residual has along `h/|h|` the mean square
//!
//! ```text
//! g = 1 + Σ p_f − Σ p_f |h_f|²/|h|²
//! ```
//!
//! where that fraction is common, and 1 where the errors of the FRFs are independent, as those of a
//! roving sensor are. The residual determines how much of the fraction is common. The component of
//! a pole in that direction is compared with this noise, the other components with independent
//! noise.

use std::collections::BTreeMap;
use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::dof::Dof;
use crate::frf::Function;

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::line_noise::LineNoise;
use crate::identify::data::residual::Residual;
use crate::identify::noise::line_correlation::LineCorrelation;
use crate::identify::noise::variance_model::{SmoothedVariance, VarianceSamples};

/// Minimum score for common noise, standard deviations.
const MIN_SCORE_STDS: f64 = 4.0;
/// Maximum power of the residual at one line, per FRF, that noise explains.
const MAX_NOISE_POWER: f64 = 6.0;
/// Minimum variance ratio of a line that the line correlation of force noise is estimated from.
const MIN_VARIANCE_RATIO: f64 = 2.0;
/// Bisection steps for the common fraction.
const BISECTION_STEPS: usize = 20;
/// Minimum force fraction of a variance for which the scatter of the variance is that of the force
/// noise.
const MIN_FORCE_FRACTION: f64 = 0.9;
/// Minimum common fraction that is significant, standard deviations.
const MIN_FRACTION_STDS: f64 = 3.0;
/// Minimum number of pairs of FRFs and lines that the scatter is estimated from.
const MIN_PAIRS: f64 = 20.0;

/// Force noise of the FRFs of each reference.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct ForceNoise {
    /// Numbers of the FRFs of each reference.
    groups: Vec<Vec<usize>>,
    /// g of each reference and line; empty where it is 1 everywhere.
    variance_ratio: Vec<Vec<f64>>,
    /// Fraction of the force noise that the FRFs of each reference have in common, and its estimate
    /// from their variances alone.
    common_fraction: Vec<f64>,
    fraction_from_variances: Vec<f64>,
    /// Line correlation of the noise in the direction of the response, and that of a stated window.
    line_correlation: LineCorrelation,
    window: LineCorrelation,
}

impl ForceNoise {
    /// Estimate before any residual exists: the common fraction at each FRF, from the variances,
    /// and the line correlation of a stated window.
    pub fn from_variances(
        functions: &[Function],
        common_fraction: impl Fn(usize) -> f64,
        window: &LineCorrelation,
    ) -> Self {
        let mut groups: BTreeMap<&Dof, Vec<usize>> = BTreeMap::new();
        for (number, function) in functions.iter().enumerate() {
            groups.entry(&function.reference).or_default().push(number);
        }
        let groups: Vec<Vec<usize>> = groups.into_values().collect();
        let fraction_from_variances: Vec<f64> = groups
            .iter()
            .map(|group| common_fraction(group[0]))
            .collect();
        Self {
            variance_ratio: Vec::new(),
            common_fraction: fraction_from_variances.clone(),
            fraction_from_variances,
            line_correlation: window.clone(),
            window: window.clone(),
            groups,
        }
    }

    /// That of some of the FRFs, by their numbers, as if no noise were common: g depends on all.
    pub fn sample(&self, functions: &[usize]) -> Self {
        let of_group = |group: &Vec<usize>| -> Vec<usize> {
            let is_of = |place: &usize| group.contains(&functions[*place]);
            (0..functions.len()).filter(is_of).collect()
        };
        Self {
            groups: self.groups.iter().map(of_group).collect(),
            variance_ratio: Vec::new(),
            ..self.clone()
        }
    }

    /// Numbers of the FRFs of each reference.
    pub fn groups(&self) -> &[Vec<usize>] {
        &self.groups
    }

    /// Numbers of the FRFs of each reference, with the common fraction of their force noise.
    pub fn common_fractions(&self) -> impl Iterator<Item = (&[usize], f64)> {
        let groups = self.groups.iter().zip(&self.common_fraction);
        groups.map(|(group, fraction)| (&group[..], *fraction))
    }

    /// Whether the FRFs of any reference have force noise in common.
    pub fn is_common(&self) -> bool {
        !self.variance_ratio.is_empty()
    }

    /// g of a reference at a line.
    pub fn variance_ratio(&self, group: usize, line: usize) -> f64 {
        let ratios = self.variance_ratio.get(group);
        ratios.map_or(1.0, |ratios| ratios[line])
    }

    /// Line correlation of the force noise.
    pub fn line_correlation(&self) -> &LineCorrelation {
        &self.line_correlation
    }

    /// Estimate from the residual of a fit on all lines, with the noise of each FRF, and the line
    /// correlation of the response noise.
    pub fn estimated_from(
        &self,
        rest: &Residual,
        frfs: &BandFrfs,
        noise: &[LineNoise],
        response_correlation: &LineCorrelation,
    ) -> Self {
        let response = ModelResponse { rest, frfs, noise };
        let groups: Vec<Vec<ResponseLine>> = self
            .groups
            .iter()
            .map(|group| per_segment(&rest.lines, |lines| response.lines(group, lines)))
            .collect();
        let lines_per_effective_line = response_correlation.lines_per_effective_line();
        let common_fraction: Vec<f64> = (groups.iter().zip(&self.fraction_from_variances))
            .map(|(lines, minimum)| {
                common_fraction_of_lines(lines, lines_per_effective_line).max(*minimum)
            })
            .collect();
        let variance_ratio = groups
            .iter()
            .zip(&common_fraction)
            .map(|(lines, fraction)| {
                let ratio = |line: &ResponseLine| 1.0 + fraction * (line.excess - 1.0);
                lines.iter().map(ratio).collect()
            });
        let variance_ratio: Vec<Vec<f64>> = variance_ratio.collect();
        if variance_ratio.iter().flatten().all(|g| *g <= 1.0) {
            return Self {
                variance_ratio: Vec::new(),
                common_fraction,
                line_correlation: response_correlation.clone(),
                ..self.clone()
            };
        }
        let phases = groups.iter().zip(&variance_ratio).map(|(lines, ratios)| {
            let pairs = lines.iter().zip(ratios);
            let phases = pairs.map(|(line, g)| match line.noise && *g > MIN_VARIANCE_RATIO {
                true => line.along / line.along.norm().max(f64::MIN_POSITIVE),
                false => Complex64::ZERO,
            });
            phases.collect::<Vec<_>>()
        });
        // A fit absorbs much of correlated noise: the correlation of a stated window is more
        // accurate, unless a force window makes the correlation stronger.
        let estimate = LineCorrelation::from_phases(&phases.collect::<Vec<_>>());
        let stated = (self.window != LineCorrelation::WHITE).then(|| self.window.clone());
        let candidates = stated.into_iter().chain(estimate);
        let strongest = candidates.max_by(|a, b| {
            a.lines_per_effective_line()
                .total_cmp(&b.lines_per_effective_line())
        });
        Self {
            line_correlation: strongest.unwrap_or_else(|| response_correlation.clone()),
            variance_ratio,
            common_fraction,
            ..self.clone()
        }
    }
}

/// Estimates the common fraction of the force noise of one reference from the scatter of the
/// variances, where the force makes nearly all of them: FRFs of the same impacts have the same
/// errors, so that `v/|H|²` scatters over the lines, but not from FRF to FRF. Its logarithm from
/// `ν` degrees of freedom has the variance ψ′(ν/2) where the errors are independent.
pub(in crate::identify) fn common_fraction_from_variances(
    estimated: &[&VarianceSamples],
    smooth: &[SmoothedVariance],
) -> f64 {
    let stated = |samples: &&VarianceSamples| {
        samples
            .degrees_of_freedom
            .filter(|v| *v > 0.0 && v.is_finite())
    };
    let freedom = estimated.iter().map(stated);
    let Some(freedom) = freedom.reduce(|a, b| Some(a?.min(b?))).flatten() else {
        return 0.0;
    };
    let lines = estimated.iter().map(|samples| samples.variance.len()).min();
    let (mut squares, mut pairs) = (0.0, 0.0);
    for k in 0..lines.unwrap_or(0) {
        let force_fraction = estimated.iter().zip(smooth);
        let force_fraction =
            force_fraction.filter(|(_, smooth)| smooth.force_fraction[k] > MIN_FORCE_FRACTION);
        let logs: Vec<f64> = force_fraction
            .map(|(samples, _)| (samples.variance[k] / samples.power[k]).ln())
            .filter(|log| log.is_finite())
            .collect();
        let mean = logs.iter().sum::<f64>() / logs.len().max(1) as f64;
        squares += logs.iter().map(|log| (log - mean).powi(2)).sum::<f64>();
        pairs += (logs.len() as f64 - 1.0).max(0.0);
    }
    if pairs < MIN_PAIRS {
        return 0.0;
    }
    let fraction = 1.0 - squares / pairs / trigamma(0.5 * freedom);
    // The variance of the square of such a logarithm is about three times its squared mean.
    if fraction > MIN_FRACTION_STDS * (3.0 / pairs).sqrt() {
        fraction.min(1.0)
    } else {
        0.0
    }
}

/// ψ′(x) of x > 0, by recurrence to where three terms of its series are exact to 1e-5.
fn trigamma(mut x: f64) -> f64 {
    let mut below = 0.0;
    while x < 6.0 {
        below += (x * x).recip();
        x += 1.0;
    }
    let inverse = x.recip();
    below + inverse + 0.5 * inverse.powi(2) + inverse.powi(3) / 6.0
}

/// Response of the model, over the noise of every FRF.
struct ModelResponse<'a> {
    rest: &'a Residual,
    frfs: &'a BandFrfs,
    noise: &'a [LineNoise],
}

impl ModelResponse<'_> {
    fn lines(&self, group: &[usize], lines: Range<usize>) -> Vec<ResponseLine> {
        let mut sums = vec![Sums::default(); lines.len()];
        for &f in group {
            let rest = self.rest.of(f, lines.clone());
            let values = self.frfs.values.of(f, lines.clone());
            let stds = self.noise[f].stds(lines.clone());
            let force_fraction = self.noise[f].force_fractions(lines.clone());
            let frf_lines = values.iter().zip(stds).zip(rest).enumerate();
            for (sum, (k, ((value, std), rest))) in sums.iter_mut().zip(frf_lines) {
                // Noise common to response and residual would look like force noise.
                let h = value / std - rest;
                let fraction = force_fraction.map_or(0.0, |fractions| f64::from(fractions[k]));
                sum.product += h.conj() * rest;
                sum.square += h.norm_sqr();
                sum.power += rest.norm_sqr();
                sum.force_fraction += fraction;
                sum.counted += fraction * h.norm_sqr();
            }
        }
        let max_power = MAX_NOISE_POWER * group.len() as f64;
        sums.iter().map(|sum| sum.line(max_power)).collect()
    }
}

/// Lines of a segment that one thread processes.
const SEGMENT_LINES: usize = 256;

/// Values of every line, with segments of lines in parallel.
pub(super) fn per_segment<T: Send>(
    lines: &Range<usize>,
    of: impl Fn(Range<usize>) -> Vec<T> + Sync,
) -> Vec<T> {
    let segment = |number: usize| {
        let start = lines.start + number * SEGMENT_LINES;
        of(start..(start + SEGMENT_LINES).min(lines.end))
    };
    let values = (0..lines.len().div_ceil(SEGMENT_LINES))
        .into_par_iter()
        .map(segment);
    values.collect::<Vec<_>>().into_iter().flatten().collect()
}

/// Sums over the FRFs of a reference at one line.
#[derive(Clone, Default)]
struct Sums {
    /// Product of residual and response, and squared response, over the noise.
    product: Complex64,
    square: f64,
    /// Power of the residual.
    power: f64,
    /// Force fraction, and its product with the squared response.
    force_fraction: f64,
    counted: f64,
}

impl Sums {
    fn line(&self, max_power: f64) -> ResponseLine {
        if self.square > 0.0 {
            ResponseLine {
                along: self.product / self.square.sqrt(),
                excess: 1.0 + (self.force_fraction - self.counted / self.square).max(0.0),
                noise: self.power < max_power,
            }
        } else {
            ResponseLine {
                along: Complex64::ZERO,
                excess: 1.0,
                noise: false,
            }
        }
    }
}

/// Component of the residual along the response at one line.
struct ResponseLine {
    along: Complex64,
    /// g for a common fraction of 1.
    excess: f64,
    /// Whether noise explains its power.
    noise: bool,
}

/// Fraction c of the force noise that the FRFs have in common: `1 + c (g − 1)` of maximum
/// likelihood for exponential variables, of which `lines_per_effective_line` have the information
/// of one; 0 where the score is not significant. Sensors that were moved share it with some others
/// only.
fn common_fraction_of_lines(lines: &[ResponseLine], lines_per_effective_line: f64) -> f64 {
    let score = |fraction: f64| {
        let (mut score, mut information) = (0.0, 0.0);
        for line in lines.iter().filter(|line| line.noise) {
            let mean = 1.0 + fraction * (line.excess - 1.0);
            let weight = (line.excess - 1.0) / mean;
            score += weight * (line.along.norm_sqr() / mean - 1.0);
            information += weight * weight;
        }
        (score, information)
    };
    let (first, information) = score(0.0);
    if first <= MIN_SCORE_STDS * (lines_per_effective_line * information).sqrt() {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    if score(high).0 >= 0.0 {
        return high;
    }
    for _ in 0..BISECTION_STEPS {
        let middle = 0.5 * (low + high);
        if score(middle).0 > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
#[path = "force_noise_tests.rs"]
mod tests;
