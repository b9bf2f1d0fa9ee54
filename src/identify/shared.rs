//! Noise that the functions of one hit point share: that of the force.
//!
//! All responses to the same hits are divided by the same force, so that its noise makes an error `e H` in the direction of the
//! response H itself: one random number per line and hit point instead of one per function. With `h = H/σ` over the noise of every
//! function and `p_f` the part of its variance that goes with |H|², what is left over has along `h/|h|` the mean square
//!
//! ```text
//! g = 1 + Σ p_f − Σ p_f |h_f|²/|h|²
//! ```
//!
//! where that part is shared, and 1 where functions err each by itself, as those of a roving sensor do. What is left over tells how
//! much of it is.
//! The part of a root in that direction is held against such noise, the rest of it against noise that is the functions' own.

use std::collections::BTreeMap;
use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::dof::Dof;
use crate::frf::Function;

use super::correlation::Correlation;
use super::far::Rest;
use super::receptance::Receptances;
use super::roots::Root;
use super::standing::lines_around;

/// Deviations of the score from which on noise is said to be shared.
const SHARED: f64 = 4.0;
/// Power of what is left over at one line, per function, from which on it is more than noise of any kind.
const MOST_POWER: f64 = 6.0;
/// Excess from which on a line says how shared noise hangs together over the lines.
const MOSTLY: f64 = 2.0;
/// Steps of halving for the part that is shared.
const HALVINGS: usize = 20;
/// Lines of a root that are compared: more tell no more.
const MOST_LINES: usize = 64;
/// Half-power widths on either side in which a root is compared with the response.
const REACH: f64 = 2.0;

/// How far functions of one hit point err together.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Shared {
    /// Numbers of the functions of each hit point.
    groups: Vec<Vec<usize>>,
    /// g of each hit point and line; empty where it is 1 everywhere.
    excess: Vec<Vec<f64>>,
    /// How noise in the direction of the response hangs together over the lines.
    along: Correlation,
}

impl Shared {
    /// Nothing known yet of the functions of a set.
    pub fn unknown(functions: &[Function]) -> Self {
        let mut groups: BTreeMap<&Dof, Vec<usize>> = BTreeMap::new();
        for (number, function) in functions.iter().enumerate() {
            groups.entry(&function.reference).or_default().push(number);
        }
        Self {
            groups: groups.into_values().collect(),
            excess: Vec::new(),
            along: Correlation::WHITE,
        }
    }

    /// Numbers of the functions of each hit point.
    pub fn groups(&self) -> &[Vec<usize>] {
        &self.groups
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
        let excess = groups.iter().map(|lines| {
            let part = shared_part(lines, alike);
            let of = |line: &Line| 1.0 + part * (line.excess - 1.0);
            lines.iter().map(of).collect()
        });
        let excess: Vec<Vec<f64>> = excess.collect();
        if excess.iter().flatten().all(|g| *g <= 1.0) {
            return Self {
                excess: Vec::new(),
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
        Self {
            groups: self.groups.clone(),
            along: Correlation::of_phases(&along.collect::<Vec<_>>())
                .unwrap_or_else(|| data.correlation.clone()),
            excess,
        }
    }

    /// Factor by which noise raises the strength of a root where there is no mode: what of the root could be the force's error of the
    /// other roots' response counts as that.
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

    /// Factor of the variance of a root's pole over that of white noise that is every function's own.
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

    /// What of a value per function lies along the response and across it, at one line, as if all noise were the functions' own.
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

    /// A root's `1/(s − λ)` to a power on its lines, along the response and across it, by hit point and line.
    fn parts(
        &self,
        data: &Receptances,
        root: &Root,
        power: i32,
        response: impl Fn(usize, usize) -> Complex64,
    ) -> Vec<Part> {
        let mut parts = Vec::new();
        let lines = lines_around(data, root, REACH);
        let stride = lines.len().div_ceil(MOST_LINES);
        for k in lines.step_by(stride) {
            let course =
                (root.decay() / (Complex64::new(0.0, data.omega[k]) - root.lambda)).powi(power);
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

fn ratio(above: f64, below: f64) -> Option<f64> {
    let ratio = above / below;
    (ratio.is_finite() && ratio > 0.0).then_some(ratio.max(1.0))
}

/// What a root makes of a function at a line, its conjugate included.
fn contribution(data: &Receptances, root: &Root, (k, f): (usize, usize)) -> Complex64 {
    let s = Complex64::new(0.0, data.omega[k]);
    let residue = root.residues[f];
    residue / (s - root.lambda) + residue.conj() / (s - root.lambda.conj())
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

/// The part c of the force's noise that functions share, with `1 + c (g − 1)` of the greatest likelihood of exponential variables of
/// which so many count for one; 0 where the score does not stand out. Sensors that were moved share it with some others only.
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
mod tests {
    use super::*;
    use crate::identify::synthetic::white_noise;

    fn lines(excess: f64, variance: f64, seed: u64) -> Vec<Line> {
        let along = white_noise(400, variance, seed);
        let line = |along| Line {
            along,
            excess,
            noise: true,
        };
        along.into_iter().map(line).collect()
    }

    #[test]
    fn noise_along_the_response_is_shared_when_it_is_larger_there() {
        for seed in 0..20 {
            // 400 squares of one exponential variable each tell their mean to 5 %.
            assert!(shared_part(&lines(3.0, 3.0, seed), 1.0) > 0.7);
            assert!((shared_part(&lines(5.0, 3.0, seed), 1.0) - 0.5).abs() < 0.2);
            assert!(shared_part(&lines(3.0, 1.0, seed), 1.0) <= 0.0);
            // Functions without noise of the force have nothing to share.
            assert!(shared_part(&lines(1.0, 1.0, seed), 1.0) <= 0.0);
        }
    }

    #[test]
    fn energies_along_and_across_the_response_add_up() {
        let response = [
            Complex64::new(1.0, 1.0),
            Complex64::new(0.0, -2.0),
            Complex64::ONE,
        ];
        let of = |own: &dyn Fn(usize) -> Complex64| split(&[0, 1, 2], own, |f| response[f]);
        let same = of(&|f| Complex64::new(0.0, 3.0) * response[f]);
        assert!((same.along - 63.0).abs() < 1e-12 && same.across.abs() < 1e-12);
        let other = of(&|f| if f == 2 { 7.0.into() } else { Complex64::ZERO });
        assert!((other.along - 7.0).abs() < 1e-12 && (other.across - 42.0).abs() < 1e-12);
    }
}
