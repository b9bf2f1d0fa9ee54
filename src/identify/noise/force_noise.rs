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
use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::residual::Residual;
use crate::identify::noise::input_variance::Noise;
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
/// Maximum number of lines of a pole that are compared.
const MAX_COMPARED_LINES: usize = 64;
/// Minimum force fraction of a variance for which the scatter of the variance is that of the force
/// noise.
const MIN_FORCE_FRACTION: f64 = 0.9;
/// Minimum common fraction that is significant, standard deviations.
const MIN_FRACTION_STDS: f64 = 3.0;
/// Minimum number of pairs of FRFs and lines that the scatter is estimated from.
const MIN_PAIRS: f64 = 20.0;
/// Half-power bandwidths on either side in which a pole is compared with the response.
const COMPARED_BANDWIDTHS: f64 = 2.0;

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
    /// Estimate from the variances, before any residual exists, with the line correlation of a
    /// stated window.
    pub fn from_variances(
        functions: &[Function],
        noise: &[Noise],
        window: &LineCorrelation,
    ) -> Self {
        let mut groups: BTreeMap<&Dof, Vec<usize>> = BTreeMap::new();
        for (number, function) in functions.iter().enumerate() {
            groups.entry(&function.reference).or_default().push(number);
        }
        let groups: Vec<Vec<usize>> = groups.into_values().collect();
        let fraction_from_variances: Vec<f64> =
            groups.iter().map(|group| noise[group[0]].shared).collect();
        Self {
            variance_ratio: Vec::new(),
            common_fraction: fraction_from_variances.clone(),
            fraction_from_variances,
            line_correlation: window.clone(),
            window: window.clone(),
            groups,
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

    /// Line correlation of the force noise.
    pub fn along(&self) -> &LineCorrelation {
        &self.line_correlation
    }

    /// Estimate from the residual of a fit on all lines.
    pub fn estimated_from(&self, data: &BandFrfs, rest: &Residual) -> Self {
        let response = ModelResponse { data, rest };
        let groups: Vec<Vec<ResponseLine>> = self
            .groups
            .iter()
            .map(|group| per_segment(&rest.lines, |lines| response.lines(group, lines)))
            .collect();
        let line_ratio = data.correlation.alike();
        let common_fraction: Vec<f64> = (groups.iter().zip(&self.fraction_from_variances))
            .map(|(lines, minimum)| common_fraction_of_lines(lines, line_ratio).max(*minimum))
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
                line_correlation: data.correlation.clone(),
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
        let strongest = candidates.max_by(|a, b| a.alike().total_cmp(&b.alike()));
        Self {
            line_correlation: strongest.unwrap_or_else(|| data.correlation.clone()),
            variance_ratio,
            common_fraction,
            ..self.clone()
        }
    }

    /// Factor by which noise raises the strength of a pole where there is no mode: the component of
    /// the pole along the response of the other poles counts as force noise.
    pub fn amplitude_noise_factor(&self, data: &BandFrfs, root: &ModelPole) -> f64 {
        let response_factor = data
            .correlation
            .amplitude_noise_factor(root.decay(), data.step);
        if self.variance_ratio.is_empty() {
            return response_factor;
        }
        let force_factor = self
            .line_correlation
            .amplitude_noise_factor(root.decay(), data.step);
        let parts = self.energy_splits(data, root, 1, |k, f| {
            data.values[f][k] - contribution(data, root, (k, f))
        });
        let across: f64 = parts.iter().map(|part| part.across).sum();
        let whole: f64 = parts.iter().map(|part| part.across + part.along).sum();
        let along: f64 = parts.iter().map(|part| part.along / part.excess).sum();
        ratio_of_at_least_one(whole, across / response_factor + along / force_factor)
            .unwrap_or(response_factor)
    }

    /// Factor of the variance of a pole over that in white noise that is independent between FRFs.
    pub fn pole_noise_factor(&self, data: &BandFrfs, root: &ModelPole) -> f64 {
        let response_factor = data.correlation.pole_noise_factor(root.decay(), data.step);
        if self.variance_ratio.is_empty() {
            return response_factor;
        }
        let force_factor = self
            .line_correlation
            .pole_noise_factor(root.decay(), data.step);
        let parts = self.energy_splits(data, root, 2, |k, f| data.values[f][k]);
        let across: f64 = parts.iter().map(|part| part.across).sum();
        let whole: f64 = parts.iter().map(|part| part.across + part.along).sum();
        let along: f64 = parts.iter().map(|part| part.along * part.excess).sum();
        ratio_of_at_least_one(response_factor * across + force_factor * along, whole)
            .unwrap_or(response_factor)
    }

    /// Energy at one line of a value per FRF, with its component along the response divided by the
    /// variance ratio, so that independent noise of the same energy has the same significance.
    pub fn held(
        &self,
        (data, rest): (&BandFrfs, &Residual),
        line: usize,
        value: impl Fn(usize) -> Complex64,
    ) -> f64 {
        if self.variance_ratio.is_empty() {
            let of = |f: &usize| value(*f).norm_sqr();
            return self.groups.iter().flatten().map(of).sum();
        }
        let response = ModelResponse { data, rest };
        let of = |(number, group): (usize, &Vec<usize>)| {
            let part = split_by_direction(group, &value, |f| response.over_noise(f, line));
            part.across + part.along / self.at(number, line)
        };
        self.groups.iter().enumerate().map(of).sum()
    }

    /// The same energy of the residual, at each of its lines.
    pub fn held_by_line(&self, data: &BandFrfs, rest: &Residual) -> Vec<f64> {
        per_segment(&rest.lines, |lines| {
            if self.variance_ratio.is_empty() {
                let mut power = vec![0.0; lines.len()];
                for f in 0..data.functions() {
                    for (sum, value) in power.iter_mut().zip(rest.of(f, lines.clone())) {
                        *sum += value.norm_sqr();
                    }
                }
                return power;
            }
            let at = |k: usize| self.held((data, rest), k, |f| rest.at(f, k));
            lines.map(at).collect()
        })
    }

    fn at(&self, group: usize, line: usize) -> f64 {
        let ratios = self.variance_ratio.get(group);
        ratios.map_or(1.0, |ratios| ratios[line])
    }

    /// `1/(s − λ)` of a pole to a power on its lines, split into components along the response and
    /// across it, by reference and line.
    fn energy_splits(
        &self,
        data: &BandFrfs,
        root: &ModelPole,
        power: usize,
        response: impl Fn(usize, usize) -> Complex64,
    ) -> Vec<EnergySplit> {
        let mut parts = Vec::new();
        let lines = data.lines_around(root.lambda, COMPARED_BANDWIDTHS);
        let stride = lines.len().div_ceil(MAX_COMPARED_LINES);
        for k in lines.step_by(stride) {
            let at = (data.omega[k], root.lambda);
            let line_shape = data.line_shape.power(root.decay(), at, power);
            for (number, group) in self.groups.iter().enumerate() {
                let amplitude = |f: usize| root.residues[f] * line_shape / data.deviation(f, k);
                let part =
                    split_by_direction(group, amplitude, |f| response(k, f) / data.deviation(f, k));
                let excess = self.at(number, k);
                // Independent noise has no preferred direction.
                parts.push(match excess > 1.0 {
                    true => EnergySplit { excess, ..part },
                    false => EnergySplit {
                        along: 0.0,
                        across: part.across + part.along,
                        excess,
                    },
                });
            }
        }
        parts
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

fn ratio_of_at_least_one(above: f64, below: f64) -> Option<f64> {
    let ratio = above / below;
    (ratio.is_finite() && ratio > 0.0).then_some(ratio.max(1.0))
}

/// Contribution of a pole to an FRF at a line, with its conjugate.
fn contribution(data: &BandFrfs, root: &ModelPole, (k, f): (usize, usize)) -> Complex64 {
    let pole = |lambda| data.line_shape.pole(data.omega[k], lambda);
    let residue = root.residues[f];
    residue * pole(root.lambda) + residue.conj() * pole(root.lambda.conj())
}

/// Energies at one line of one reference, along the response and across it.
struct EnergySplit {
    along: f64,
    across: f64,
    excess: f64,
}

fn split_by_direction(
    group: &[usize],
    value: impl Fn(usize) -> Complex64,
    response: impl Fn(usize) -> Complex64,
) -> EnergySplit {
    let (mut product, mut square, mut whole) = (Complex64::ZERO, 0.0, 0.0);
    for &f in group {
        let (u, h) = (value(f), response(f));
        product += h.conj() * u;
        square += h.norm_sqr();
        whole += u.norm_sqr();
    }
    let along = if square > 0.0 {
        (product.norm_sqr() / square).min(whole)
    } else {
        0.0
    };
    EnergySplit {
        along,
        across: whole - along,
        excess: 1.0,
    }
}

/// Response of the model, over the noise of every FRF.
struct ModelResponse<'a> {
    data: &'a BandFrfs,
    rest: &'a Residual,
}

impl ModelResponse<'_> {
    /// Measured value minus residual: noise common to both would look like force noise.
    fn over_noise(&self, f: usize, k: usize) -> Complex64 {
        self.data.values[f][k] / self.data.deviation(f, k) - self.rest.at(f, k)
    }

    fn lines(&self, group: &[usize], lines: Range<usize>) -> Vec<ResponseLine> {
        let mut sums = vec![Sums::default(); lines.len()];
        for &f in group {
            let rest = self.rest.of(f, lines.clone());
            let values = &self.data.values[f][lines.clone()];
            let variance = &self.data.variance[f][lines.clone()];
            let force_fraction = &self.data.force_fraction[f][lines.clone()];
            let frf_lines = values.iter().zip(variance).zip(rest).zip(force_fraction);
            for (sum, (((value, variance), rest), fraction)) in sums.iter_mut().zip(frf_lines) {
                let h = value / variance.sqrt() - rest;
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
fn per_segment<T: Send>(
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
/// likelihood for exponential variables, of which `line_ratio` have the information of one; 0
/// where the score is not significant. Sensors that were moved share it with some others only.
fn common_fraction_of_lines(lines: &[ResponseLine], line_ratio: f64) -> f64 {
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
    if first <= MIN_SCORE_STDS * (line_ratio * information).sqrt() {
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
