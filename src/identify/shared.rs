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
//! where that part is shared, and 1 where functions err each by itself, as those of a roving sensor do. What is left over tells which.
//! The part of a root in that direction is held against such noise, the rest of it against noise that is the functions' own.

use std::collections::BTreeMap;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::dof::Dof;
use crate::frf::Function;
use crate::linalg::ComplexMatrix;

use super::correlation::Correlation;
use super::receptance::Receptances;
use super::roots::Root;
use super::standing::lines_around;

/// Deviations of the score from which on noise is said to be shared.
const SHARED: f64 = 4.0;
/// Power of what is left over at one line, per function, from which on it is more than noise of any kind.
const MOST_POWER: f64 = 6.0;
/// Excess from which on a line says how shared noise hangs together over the lines.
const MOSTLY: f64 = 2.0;
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

    /// From what a fit leaves over, over the noise: lines × functions.
    pub fn of_rest(&self, data: &Receptances, rest: &ComplexMatrix) -> Self {
        let response = Response { data, rest };
        let of_group = |group: &Vec<usize>| -> Vec<Line> {
            (0..data.lines()).map(|k| response.line(group, k)).collect()
        };
        let groups: Vec<Vec<Line>> = self.groups.par_iter().map(of_group).collect();
        let alike = data.correlation.alike();
        let excess = groups.iter().map(|lines| match are_shared(lines, alike) {
            true => lines.iter().map(|line| line.excess).collect(),
            false => vec![1.0; lines.len()],
        });
        let excess: Vec<Vec<f64>> = excess.collect();
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
            along: Correlation::of_phases(&along.collect::<Vec<_>>()),
            excess,
        }
    }

    /// Factor by which noise raises the strength of a root where there is no mode: what of the root could be the force's error of the
    /// other roots' response counts as that.
    pub fn of_amplitude(&self, data: &Receptances, root: &Root) -> f64 {
        let own = data.correlation.of_amplitude(root.decay(), data.step);
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
        (data, rest): (&Receptances, &ComplexMatrix),
        line: usize,
        value: impl Fn(usize) -> Complex64,
    ) -> f64 {
        let response = Response { data, rest };
        let of = |(number, group): (usize, &Vec<usize>)| {
            let part = split(group, &value, |f| response.over_noise(f, line));
            part.across + part.along / self.at(number, line)
        };
        self.groups.iter().enumerate().map(of).sum()
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
        for k in lines_around(data, root, REACH) {
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
    rest: &'a ComplexMatrix,
}

impl Response<'_> {
    /// What is measured without what is left over: noise that both hold would look shared.
    fn over_noise(&self, f: usize, k: usize) -> Complex64 {
        self.data.values[f][k] / self.data.deviation(f, k) - self.rest[(k, f)]
    }

    fn line(&self, group: &[usize], k: usize) -> Line {
        let (mut product, mut square, mut power) = (Complex64::ZERO, 0.0, 0.0);
        let (mut by_force, mut counted) = (0.0, 0.0);
        for &f in group {
            let h = self.over_noise(f, k);
            let part = self.data.by_force[f][k];
            product += h.conj() * self.rest[(k, f)];
            square += h.norm_sqr();
            power += self.rest[(k, f)].norm_sqr();
            by_force += part;
            counted += part * h.norm_sqr();
        }
        if square > 0.0 {
            Line {
                along: product / square.sqrt(),
                excess: 1.0 + (by_force - counted / square).max(0.0),
                noise: power < MOST_POWER * group.len() as f64,
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

/// Whether what is left over is larger along the response where the force is what makes noise: the score of exponential variables, of
/// which so many count for one.
fn are_shared(lines: &[Line], alike: f64) -> bool {
    let (mut score, mut information) = (0.0, 0.0);
    for line in lines.iter().filter(|line| line.noise) {
        let weight = line.excess - 1.0;
        score += weight * (line.along.norm_sqr() - 1.0);
        information += weight * weight;
    }
    score > SHARED * (alike * information).sqrt()
}
