//! Noise that the functions of one hit point share: that of the force.
//!
//! All responses to the same hits are divided by the same force, so that its noise makes an error
//! `e H` in the direction of the response H itself: one random number per line and hit point
//! instead of one per function. With `h = H/σ` over the noise of every function and `p_f` the part
//! of its variance that goes with |H|², what is left over has along `h/|h|` the mean square
//!
//! ```text
//! g = 1 + Σ p_f − Σ p_f |h_f|²/|h|²
//! ```
//!
//! where that part is shared, and 1 where functions err each by itself, as those of a roving sensor
//! do. What is left over tells how much of it is. The part of a root in that direction is held
//! against such noise, the rest of it against noise that is the functions' own.

use std::collections::BTreeMap;
use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::dof::Dof;
use crate::frf::Function;

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::model_pole::Root;
use crate::identify::data::residual::Rest;
use crate::identify::ml::pole_metrics::lines_around;
use crate::identify::noise::input_variance::Noise;
use crate::identify::noise::line_correlation::Correlation;
use crate::identify::noise::variance_model::{Estimated, Smooth};

/// Deviations of the score from which on noise is said to be shared.
const SHARED: f64 = 4.0;
/// Power of what is left over at one line, per function, from which on it is more than noise of any
/// kind.
const MOST_POWER: f64 = 6.0;
/// Excess from which on a line says how shared noise hangs together over the lines.
const MOSTLY: f64 = 2.0;
/// Steps of halving for the part that is shared.
const HALVINGS: usize = 20;
/// Lines of a root that are compared: more tell no more.
const MOST_LINES: usize = 64;
/// Part of a variance that the force makes from which on the scatter of the variance is that of the
/// force's noise.
const MOSTLY_FORCE: f64 = 0.9;
/// Deviations of it from which on it is more than chance.
const CERTAIN: f64 = 3.0;
/// Pairs of functions and lines from which on their scatter tells something.
const FEWEST_PAIRS: f64 = 20.0;
/// Half-power widths on either side in which a root is compared with the response.
const REACH: f64 = 2.0;

/// How far functions of one hit point err together.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct Shared {
    /// Numbers of the functions of each hit point.
    groups: Vec<Vec<usize>>,
    /// g of each hit point and line; empty where it is 1 everywhere.
    excess: Vec<Vec<f64>>,
    /// Part of the force's noise that the functions of each hit point share, and what of it their
    /// variances told.
    part: Vec<f64>,
    told: Vec<f64>,
    /// How noise in the direction of the response hangs together over the lines, and how a known
    /// window makes it.
    along: Correlation,
    window: Correlation,
}

impl Shared {
    /// As far as the variances tell, in noise that hangs together over the lines as a known window
    /// makes it, before a fit leaves anything over.
    pub fn of_variances(functions: &[Function], noise: &[Noise], window: &Correlation) -> Self {
        let mut groups: BTreeMap<&Dof, Vec<usize>> = BTreeMap::new();
        for (number, function) in functions.iter().enumerate() {
            groups.entry(&function.reference).or_default().push(number);
        }
        let groups: Vec<Vec<usize>> = groups.into_values().collect();
        let told: Vec<f64> = groups.iter().map(|group| noise[group[0]].shared).collect();
        Self {
            excess: Vec::new(),
            part: told.clone(),
            told,
            along: window.clone(),
            window: window.clone(),
            groups,
        }
    }

    /// Numbers of the functions of each hit point.
    pub fn groups(&self) -> &[Vec<usize>] {
        &self.groups
    }

    /// Numbers of the functions of each hit point, with the part of the force's noise that they
    /// share.
    pub fn parts_of_groups(&self) -> impl Iterator<Item = (&[usize], f64)> {
        let groups = self.groups.iter().zip(&self.part);
        groups.map(|(group, part)| (&group[..], *part))
    }

    /// How the force's noise hangs together over the lines.
    pub fn along(&self) -> &Correlation {
        &self.along
    }

    /// From what a fit leaves over of all lines.
    pub fn of_rest(&self, data: &Receptances, rest: &Rest) -> Self {
        let response = Response { data, rest };
        let groups: Vec<Vec<Line>> = self
            .groups
            .iter()
            .map(|group| by_stretch(&rest.lines, |lines| response.lines(group, lines)))
            .collect();
        let alike = data.correlation.alike();
        let part: Vec<f64> = (groups.iter().zip(&self.told))
            .map(|(lines, told)| shared_part(lines, alike).max(*told))
            .collect();
        let excess = groups.iter().zip(&part).map(|(lines, part)| {
            let of = |line: &Line| 1.0 + part * (line.excess - 1.0);
            lines.iter().map(of).collect()
        });
        let excess: Vec<Vec<f64>> = excess.collect();
        if excess.iter().flatten().all(|g| *g <= 1.0) {
            return Self {
                excess: Vec::new(),
                part,
                along: data.correlation.clone(),
                ..self.clone()
            };
        }
        let along = groups.iter().zip(&excess).map(|(lines, excess)| {
            let own = lines.iter().zip(excess);
            let own = own.map(|(line, g)| match line.noise && *g > MOSTLY {
                true => line.along / line.along.norm().max(f64::MIN_POSITIVE),
                false => Complex64::ZERO,
            });
            own.collect::<Vec<_>>()
        });
        // A fit takes in much of what hangs together: a window that is known tells it better, where
        // a force window does not make it more.
        let along = Correlation::of_phases(&along.collect::<Vec<_>>());
        let known = (self.window != Correlation::WHITE).then(|| self.window.clone());
        let along = known.into_iter().chain(along);
        let along = along.max_by(|a, b| a.alike().total_cmp(&b.alike()));
        Self {
            along: along.unwrap_or_else(|| data.correlation.clone()),
            excess,
            part,
            ..self.clone()
        }
    }

    /// Factor by which noise raises the strength of a root where there is no mode: what of the root
    /// could be the force's error of the other roots' response counts as that.
    pub fn of_amplitude(&self, data: &Receptances, root: &Root) -> f64 {
        let own = data.correlation.of_amplitude(root.decay(), data.step);
        if self.excess.is_empty() {
            return own;
        }
        let along = self.along.of_amplitude(root.decay(), data.step);
        let parts = self.parts(data, root, 1, |k, f| {
            data.values[f][k] - contribution(data, root, (k, f))
        });
        let by_itself: f64 = parts.iter().map(|part| part.across).sum();
        let whole: f64 = parts.iter().map(|part| part.across + part.along).sum();
        let held: f64 = parts.iter().map(|part| part.along / part.excess).sum();
        ratio(whole, by_itself / own + held / along).unwrap_or(own)
    }

    /// Factor of the variance of a root's pole over that of white noise that is every function's
    /// own.
    pub fn of_pole(&self, data: &Receptances, root: &Root) -> f64 {
        let own = data.correlation.of_pole(root.decay(), data.step);
        if self.excess.is_empty() {
            return own;
        }
        let along = self.along.of_pole(root.decay(), data.step);
        let parts = self.parts(data, root, 2, |k, f| data.values[f][k]);
        let by_itself: f64 = parts.iter().map(|part| part.across).sum();
        let whole: f64 = parts.iter().map(|part| part.across + part.along).sum();
        let raised: f64 = parts.iter().map(|part| part.along * part.excess).sum();
        ratio(own * by_itself + along * raised, whole).unwrap_or(own)
    }

    /// What of a value per function lies along the response and across it, at one line, as if all
    /// noise were the functions' own.
    pub fn held(
        &self,
        (data, rest): (&Receptances, &Rest),
        line: usize,
        value: impl Fn(usize) -> Complex64,
    ) -> f64 {
        if self.excess.is_empty() {
            let of = |f: &usize| value(*f).norm_sqr();
            return self.groups.iter().flatten().map(of).sum();
        }
        let response = Response { data, rest };
        let of = |(number, group): (usize, &Vec<usize>)| {
            let part = split(group, &value, |f| response.over_noise(f, line));
            part.across + part.along / self.at(number, line)
        };
        self.groups.iter().enumerate().map(of).sum()
    }

    /// The same of what is left over, at each of its lines.
    pub fn held_by_line(&self, data: &Receptances, rest: &Rest) -> Vec<f64> {
        by_stretch(&rest.lines, |lines| {
            if self.excess.is_empty() {
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
        self.excess.get(group).map_or(1.0, |own| own[line])
    }

    /// A root's `1/(s − λ)` to a power on its lines, along the response and across it, by hit point
    /// and line.
    fn parts(
        &self,
        data: &Receptances,
        root: &Root,
        power: usize,
        response: impl Fn(usize, usize) -> Complex64,
    ) -> Vec<Part> {
        let mut parts = Vec::new();
        let lines = lines_around(data, root, REACH);
        let stride = lines.len().div_ceil(MOST_LINES);
        for k in lines.step_by(stride) {
            let at = (data.omega[k], root.lambda);
            let course = data.line_shape.power(root.decay(), at, power);
            for (number, group) in self.groups.iter().enumerate() {
                let own = |f: usize| root.residues[f] * course / data.deviation(f, k);
                let part = split(group, own, |f| response(k, f) / data.deviation(f, k));
                let excess = self.at(number, k);
                // Noise that is not shared has no direction of its own.
                parts.push(match excess > 1.0 {
                    true => Part { excess, ..part },
                    false => Part {
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

/// The part of the force's noise that functions of one hit point share, from how their variances
/// scatter where the force makes nearly all of them: functions of the same hits have the same
/// errors, so that `v/|H|²` scatters over the lines, but not from one to the other. Its logarithm
/// from `ν` degrees of freedom each has the variance ψ′(ν/2) where they err each by itself.
pub(in crate::identify) fn told_by_variances(estimated: &[&Estimated], smooth: &[Smooth]) -> f64 {
    let stated = |own: &&Estimated| own.degrees_of_freedom.filter(|v| *v > 0.0 && v.is_finite());
    let freedom = estimated.iter().map(stated);
    let Some(freedom) = freedom.reduce(|a, b| Some(a?.min(b?))).flatten() else {
        return 0.0;
    };
    let lines = estimated.iter().map(|own| own.variance.len()).min();
    let (mut squares, mut pairs) = (0.0, 0.0);
    for k in 0..lines.unwrap_or(0) {
        let by_force = estimated.iter().zip(smooth);
        let by_force = by_force.filter(|(_, smooth)| smooth.by_force[k] > MOSTLY_FORCE);
        let logs: Vec<f64> = by_force
            .map(|(own, _)| (own.variance[k] / own.power[k]).ln())
            .filter(|log| log.is_finite())
            .collect();
        let mean = logs.iter().sum::<f64>() / logs.len().max(1) as f64;
        squares += logs.iter().map(|log| (log - mean).powi(2)).sum::<f64>();
        pairs += (logs.len() as f64 - 1.0).max(0.0);
    }
    if pairs < FEWEST_PAIRS {
        return 0.0;
    }
    let part = 1.0 - squares / pairs / trigamma(0.5 * freedom);
    // The square of such a logarithm has three times the square of its mean as its variance, about.
    if part > CERTAIN * (3.0 / pairs).sqrt() {
        part.min(1.0)
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

fn ratio(above: f64, below: f64) -> Option<f64> {
    let ratio = above / below;
    (ratio.is_finite() && ratio > 0.0).then_some(ratio.max(1.0))
}

/// What a root makes of a function at a line, its conjugate included.
fn contribution(data: &Receptances, root: &Root, (k, f): (usize, usize)) -> Complex64 {
    let pole = |lambda| data.line_shape.pole(data.omega[k], lambda);
    let residue = root.residues[f];
    residue * pole(root.lambda) + residue.conj() * pole(root.lambda.conj())
}

/// Energies of one line of one hit point.
struct Part {
    along: f64,
    across: f64,
    excess: f64,
}

fn split(
    group: &[usize],
    own: impl Fn(usize) -> Complex64,
    response: impl Fn(usize) -> Complex64,
) -> Part {
    let (mut product, mut square, mut whole) = (Complex64::ZERO, 0.0, 0.0);
    for &f in group {
        let (u, h) = (own(f), response(f));
        product += h.conj() * u;
        square += h.norm_sqr();
        whole += u.norm_sqr();
    }
    let along = if square > 0.0 {
        (product.norm_sqr() / square).min(whole)
    } else {
        0.0
    };
    Part {
        along,
        across: whole - along,
        excess: 1.0,
    }
}

/// The response of the model, over the noise of every function.
struct Response<'a> {
    data: &'a Receptances,
    rest: &'a Rest,
}

impl Response<'_> {
    /// What is measured without what is left over: noise that both hold would look shared.
    fn over_noise(&self, f: usize, k: usize) -> Complex64 {
        self.data.values[f][k] / self.data.deviation(f, k) - self.rest.at(f, k)
    }

    fn lines(&self, group: &[usize], lines: Range<usize>) -> Vec<Line> {
        let mut sums = vec![Sums::default(); lines.len()];
        for &f in group {
            let rest = self.rest.of(f, lines.clone());
            let values = &self.data.values[f][lines.clone()];
            let variance = &self.data.variance[f][lines.clone()];
            let by_force = &self.data.by_force[f][lines.clone()];
            let own = values.iter().zip(variance).zip(rest).zip(by_force);
            for (sum, (((value, variance), rest), part)) in sums.iter_mut().zip(own) {
                let h = value / variance.sqrt() - rest;
                sum.product += h.conj() * rest;
                sum.square += h.norm_sqr();
                sum.power += rest.norm_sqr();
                sum.by_force += part;
                sum.counted += part * h.norm_sqr();
            }
        }
        let most = MOST_POWER * group.len() as f64;
        sums.iter().map(|sum| sum.line(most)).collect()
    }
}

/// Lines that one thread looks at.
const STRETCH: usize = 256;

/// Something of every line, stretches of them in parallel.
fn by_stretch<T: Send>(lines: &Range<usize>, of: impl Fn(Range<usize>) -> Vec<T> + Sync) -> Vec<T> {
    let own = |number: usize| {
        let start = lines.start + number * STRETCH;
        of(start..(start + STRETCH).min(lines.end))
    };
    let parts = (0..lines.len().div_ceil(STRETCH)).into_par_iter().map(own);
    parts.collect::<Vec<_>>().into_iter().flatten().collect()
}

/// Sums over the functions of a hit point at one line.
#[derive(Clone, Default)]
struct Sums {
    /// Of what is left over along the response, and of the response, over the noise.
    product: Complex64,
    square: f64,
    /// Of what is left over.
    power: f64,
    /// Of the part that the force makes, and of that times the response.
    by_force: f64,
    counted: f64,
}

impl Sums {
    fn line(&self, most: f64) -> Line {
        if self.square > 0.0 {
            Line {
                along: self.product / self.square.sqrt(),
                excess: 1.0 + (self.by_force - self.counted / self.square).max(0.0),
                noise: self.power < most,
            }
        } else {
            Line {
                along: Complex64::ZERO,
                excess: 1.0,
                noise: false,
            }
        }
    }
}

/// What is left over along the response at one line.
struct Line {
    along: Complex64,
    /// g where noise is shared.
    excess: f64,
    /// Whether it may be noise.
    noise: bool,
}

/// The part c of the force's noise that functions share, with `1 + c (g − 1)` of the greatest
/// likelihood of exponential variables of which so many count for one; 0 where the score does not
/// stand out. Sensors that were moved share it with some others only.
fn shared_part(lines: &[Line], alike: f64) -> f64 {
    let score = |part: f64| {
        let (mut score, mut information) = (0.0, 0.0);
        for line in lines.iter().filter(|line| line.noise) {
            let mean = 1.0 + part * (line.excess - 1.0);
            let weight = (line.excess - 1.0) / mean;
            score += weight * (line.along.norm_sqr() / mean - 1.0);
            information += weight * weight;
        }
        (score, information)
    };
    let (first, information) = score(0.0);
    if first <= SHARED * (alike * information).sqrt() {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    if score(high).0 >= 0.0 {
        return high;
    }
    for _ in 0..HALVINGS {
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
