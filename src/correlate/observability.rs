//! Observability assesses whether a test can detect a root of the theory with its sensors,
//! excitation points and noise.
//!
//! A judgement needs shapes of the theory at the points of the test. What the test does not say
//! (noise, damping) or the theory does not (modal mass) is left open, and an open question never
//! excuses a missed root.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{PI, TAU};
use std::fmt;

use num_complex::Complex64;

use crate::axis::Band;
use crate::dof::Dof;
use crate::frf::FrfSet;
use crate::modal::{ModalModel, Mode, ModeShape, Scaling};

use super::model_roots::{Root, elastic_roots};

/// Maximum strength of a root at a pair that counts as a node, over the product of the largest
/// values of any mode at its response and at its reference.
///
/// An eigenvector is known to about 1e-14 of its largest component, five decades below. At equal
/// damping the peaks of two accelerances are as far apart as their strengths, here 180 dB, while a
/// converter of 24 bits spans 144 dB.
pub(super) const NODE_FRACTION_OF_LARGEST: f64 = 1e-9;

/// Minimum height of a detectable peak over the noise, dB.
pub const PEAK_OVER_NOISE_DB: f64 = 10.0;

/// Largest standard deviation of a natural frequency, as a part of the spacing to the nearest root.
pub const LARGEST_STD_OF_SPACING: f64 = 0.25;

/// Observability of one elastic root of the theory by a test.
#[derive(Clone, Debug, PartialEq)]
pub struct Observability {
    /// (response, reference) pairs of the test.
    pub pairs: usize,
    /// Those of them at which the theory has shape values.
    pub pairs_in_theory: usize,
    /// Whether every sensor or hit stands still: no pair sees the root.
    pub still: bool,
    /// Damping ratio that was used; `None` when neither side knows one.
    pub damping: Option<RootDamping>,
    /// Distance to the nearest other elastic root, Hz; `None` for an only one.
    pub spacing_hz: Option<f64>,
    /// The peak against the noise, or why that is not known.
    pub noise: Result<AgainstNoise, NotJudged>,
}

/// The damping ratio of a root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RootDamping {
    /// A fraction.
    pub ratio: f64,
    /// Whether it is the median of the test's modes, because the theory has none.
    pub from_test: bool,
}

/// A root's peak against the noise of the functions.
#[derive(Clone, Debug, PartialEq)]
pub struct AgainstNoise {
    /// (response, reference) at which the peak stands highest over the noise.
    pub best_pair: (Dof, Dof),
    /// Peak over the root mean square of the noise there, dB; infinite without noise.
    pub peak_over_noise_db: f64,
    /// Smallest standard deviation (Cramér-Rao) with which all pairs together can know the natural
    /// frequency, Hz.
    pub frequency_std_hz: f64,
    /// Whether noise and strength were known at every pair, so that no other pair can see more.
    pub complete: bool,
}

/// Reason why a root was not compared with the noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotJudged {
    /// The theory has no modal mass.
    ModalMass,
    /// Neither the theory nor the test has a damping ratio.
    DampingRatio,
    /// The test has no function with a variance at the root.
    Variance,
}

impl fmt::Display for NotJudged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            NotJudged::ModalMass => "the model has no modal mass",
            NotJudged::DampingRatio => "no damping ratio is known",
            NotJudged::Variance => "the test has no FRF with a variance there",
        })
    }
}

impl Observability {
    /// Whether the test could have seen the root: at one pair its peak stands 10 dB over the noise,
    /// and the Cramér-Rao deviation of its frequency is under a quarter of the spacing to the
    /// nearest root. `None` when that is not known.
    pub fn observable(&self) -> Option<bool> {
        if self.still {
            return Some(false);
        }
        let noise = self.noise.as_ref().ok()?;
        let seen = noise.peak_over_noise_db >= PEAK_OVER_NOISE_DB && self.tells_apart(noise);
        (seen || noise.complete).then_some(seen)
    }

    fn tells_apart(&self, noise: &AgainstNoise) -> bool {
        self.spacing_hz
            .is_none_or(|spacing| noise.frequency_std_hz < LARGEST_STD_OF_SPACING * spacing)
    }

    /// The numbers behind [`Self::observable`], as a clause.
    pub(super) fn reason(&self) -> String {
        if self.still {
            return "every sensor or hit stands still in this root".to_owned();
        }
        let noise = match &self.noise {
            Ok(noise) => noise,
            Err(why) => {
                return format!("not judged against noise: {why}");
            }
        };
        let (response, reference) = &noise.best_pair;
        let (db, std) = (noise.peak_over_noise_db, noise.frequency_std_hz);
        let peak =
            format!("its peak would stand {db:.1} dB over the noise at {response}|{reference}");
        let mut text = match self.spacing_hz {
            _ if db < PEAK_OVER_NOISE_DB => format!("{peak}, {PEAK_OVER_NOISE_DB} dB are needed"),
            Some(spacing) if !self.tells_apart(noise) => format!(
                "its frequency could be known to {std:.3} Hz at best, a quarter of the {spacing:.3} Hz to the next root is needed"
            ),
            _ => peak,
        };
        if self.observable().is_none() {
            text += "; not every pair of the test could be judged";
        }
        text
    }
}

/// Observability of every elastic root, in ascending frequency of the roots; `None` where
/// nothing is known: the test has no (response, reference) pairs, or the theory no shape at any of
/// them.
///
/// Pairs are those of the test's FRFs when there are any, else those of the residues of its modes.
/// The strength of a root at a pair is `g = sum phi_response phi_reference / m` over its modes,
/// with modal masses `m`; for a repeated root it does not depend on the basis. Its receptance
/// `g/(w^2 - omega^2 + 2 i zeta w omega)` has the peak `|g|/(2 zeta w^2)`, times `w` for a mobility
/// and `w^2` for an accelerance. An exponential window that is still in the values adds its decay
/// rate `a`: the peak is then `|g|/(2 w delta)` with `delta = zeta w + a`. The noise beside it is
/// the root mean square of the variance on the lines within `w ± delta`, at least the nearest line.
///
/// The bound on the frequency: `A/(i omega - lambda)` with unknown complex `A` in complex noise of
/// variance `sigma^2` per line, white over the peak, lines `dw` apart. The Fisher information of
/// `Im lambda` is `(2/sigma^2) |A|^2 (b - |c|^2/a)` with `a = pi/delta`, `b = pi/(2 delta^3)`, `c =
/// pi/(2 delta^2)` (all over `dw`) the integrals of the products of `1/(i omega - lambda)` and its
/// square, so that `var(Im lambda) >= 2 sigma^2 dw delta^3/(pi |A|^2) = 2 dw delta/(pi rho^2)` with
/// `rho = |A|/(delta sigma)` the peak over the noise. `Re lambda` has the same variance and is
/// uncorrelated, so that `|lambda|`, the natural frequency, has it too. Pairs share `lambda` and
/// add their information. Lines have to lie closer than about `2 delta`; those of a windowed record
/// are taken for independent.
///
/// # Reference
/// Kay (1993), Fundamentals of Statistical Signal Processing: Estimation Theory, sections 3.7 and
/// 15.7 (Fisher information of complex data); Ewins (2000), Modal Testing, 2nd ed., section 2.4
/// (receptance of a mode).
pub fn observability(
    theory: &ModalModel,
    test: &ModalModel,
    frfs: &[FrfSet],
) -> Vec<Option<Observability>> {
    let sight = Sight::new(theory, test, frfs);
    (0..sight.roots.len()).map(|r| sight.judge(r)).collect()
}

pub(super) struct Sight<'a> {
    pub theory: &'a ModalModel,
    pub frfs: &'a [FrfSet],
    /// The elastic roots, ascending.
    pub roots: Vec<Root>,
    /// In ascending order.
    pairs: Vec<(Dof, Dof)>,
    test_damping: Option<f64>,
    /// Strength up to which a root stands still, at every pair.
    still: Vec<f64>,
}

impl<'a> Sight<'a> {
    pub fn new(theory: &'a ModalModel, test: &ModalModel, frfs: &'a [FrfSet]) -> Self {
        let roots = elastic_roots(theory);
        let pairs = pairs(test, frfs);
        let largest = |dof: &Dof| largest(theory, dof);
        let scales: BTreeMap<&Dof, f64> = pairs
            .iter()
            .flat_map(|(response, reference)| [response, reference])
            .map(|dof| (dof, largest(dof)))
            .collect();
        let limit = |(response, reference): &(Dof, Dof)| {
            NODE_FRACTION_OF_LARGEST * scales[response] * scales[reference]
        };
        Self {
            still: pairs.iter().map(limit).collect(),
            test_damping: median(test.modes.iter().filter_map(positive_damping).collect()),
            theory,
            frfs,
            roots,
            pairs,
        }
    }

    /// The most that any mode has at a point.
    pub fn largest(&self, dof: &Dof) -> f64 {
        largest(self.theory, dof)
    }

    fn judge(&self, r: usize) -> Option<Observability> {
        let root = &self.roots[r];
        let of_pair = |pair| strength(self.theory, &root.modes, pair);
        let strengths: Vec<Option<f64>> = self.pairs.iter().map(of_pair).collect();
        let known = strengths.iter().flatten().count();
        if known == 0 {
            return None;
        }
        let still = |(g, limit): (&Option<f64>, &f64)| g.is_some_and(|g| g <= *limit);
        let damping = self.damping(root);
        Some(Observability {
            pairs: self.pairs.len(),
            pairs_in_theory: known,
            still: strengths.iter().zip(&self.still).all(still),
            damping,
            spacing_hz: self.spacing_hz(r),
            noise: self.against_noise(root, damping),
        })
    }

    /// The damping ratio of the theory where it states one, else that of the test.
    pub fn damping(&self, root: &Root) -> Option<RootDamping> {
        let modes = root.modes.iter();
        let ratios: Option<Vec<f64>> = modes
            .map(|&j| positive_damping(&self.theory.modes[j]))
            .collect();
        let mean = ratios.map(|ratios| ratios.iter().sum::<f64>() / ratios.len() as f64);
        let ratio = mean.or(self.test_damping)?;
        Some(RootDamping {
            ratio,
            from_test: mean.is_none(),
        })
    }

    fn stands_still(&self, pair: &(Dof, Dof), strength: f64) -> bool {
        let at = self.pairs.binary_search(pair);
        at.is_ok_and(|at| strength <= self.still[at])
    }

    /// Distance of a root to the nearest other, Hz.
    pub fn spacing_hz(&self, r: usize) -> Option<f64> {
        let others = (0..self.roots.len()).filter(|&other| other != r);
        others
            .map(|other| (self.roots[other].hz - self.roots[r].hz).abs())
            .min_by(f64::total_cmp)
    }

    fn against_noise(
        &self,
        root: &Root,
        damping: Option<RootDamping>,
    ) -> Result<AgainstNoise, NotJudged> {
        let masses = root.modes.iter().map(|&j| &self.theory.modes[j]);
        if masses.map(modal_mass_kg).any(|mass| mass.is_none()) {
            return Err(NotJudged::ModalMass);
        }
        let ratio = damping.ok_or(NotJudged::DampingRatio)?.ratio;
        let mut best: Option<(f64, (Dof, Dof))> = None;
        let (mut per_variance, mut complete) = (0.0, true);
        for set in self.frfs {
            let peak = Peak::new(root.hz, ratio, set);
            for (i, function) in set.functions().iter().enumerate() {
                let pair = (function.response.clone(), function.reference.clone());
                let strength = strength(self.theory, &root.modes, &pair);
                let squared = strength.and_then(|g| peak.over_noise_squared(set, i, g));
                let Some(squared) = squared else {
                    complete &= strength.is_some_and(|g| self.stands_still(&pair, g));
                    continue;
                };
                per_variance += squared / peak.variance_of_unit_peak();
                if best.as_ref().is_none_or(|(highest, _)| squared > *highest) {
                    best = Some((squared, pair));
                }
            }
        }
        let (highest, best_pair) = best.ok_or(NotJudged::Variance)?;
        Ok(AgainstNoise {
            best_pair,
            peak_over_noise_db: 10.0 * highest.log10(),
            frequency_std_hz: per_variance.sqrt().recip() / TAU,
            complete,
        })
    }
}

/// The peak of a root as the functions of one set show it.
pub(super) struct Peak {
    hz: f64,
    /// Natural frequency, rad/s.
    omega: f64,
    /// Decay rate in the values, rad/s.
    delta: f64,
    /// Spacing of the lines, rad/s.
    step: f64,
}

impl Peak {
    pub fn new(hz: f64, damping_ratio: f64, set: &FrfSet) -> Self {
        let omega = TAU * hz;
        Self {
            hz,
            omega,
            delta: damping_ratio * omega + set.added_damping_rad_s,
            step: TAU * set.axis().step_hz,
        }
    }

    /// Square of the peak of a root of strength `g` over the noise of function `i`; `None` where
    /// that is not known.
    fn over_noise_squared(&self, set: &FrfSet, i: usize, g: f64) -> Option<f64> {
        let noise = self.noise_squared(set, i)?;
        let peak = self.height_squared(set, i, g);
        // A root that stands still does not rise over the absence of noise.
        Some(if peak > 0.0 { peak / noise } else { 0.0 })
    }

    /// Square of the peak of a root of strength `g` in function `i`, in the unit of its kind
    /// squared.
    pub fn height_squared(&self, set: &FrfSet, i: usize, g: f64) -> f64 {
        let s = Complex64::new(set.added_damping_rad_s, self.omega);
        let order = set.functions()[i].kind.derivative_order();
        (g / (2.0 * self.omega * self.delta) * s.norm().powi(order)).powi(2)
    }

    /// Mean variance of function `i` on the half-power lines, in the unit of its kind squared.
    pub fn noise_squared(&self, set: &FrfSet, i: usize) -> Option<f64> {
        let (axis, half_hz) = (set.axis(), self.delta / TAU);
        let band = Band::new((self.hz - half_hz).max(0.0), self.hz + half_hz);
        let inside = band.map_or(0..0, |band| axis.lines(&band));
        let lines = match axis.nearest(self.hz) {
            Some(nearest) if inside.is_empty() => nearest..nearest + 1,
            _ => inside,
        };
        let variance = &set.variance(i)?[lines];
        let legal = variance.iter().all(|v| v.is_finite() && *v >= 0.0);
        (legal && !variance.is_empty())
            .then(|| variance.iter().sum::<f64>() / variance.len() as f64)
    }

    /// Smallest variance of the natural frequency for a peak as high as the noise, (rad/s)^2.
    pub fn variance_of_unit_peak(&self) -> f64 {
        2.0 * self.step * self.delta / PI
    }
}

fn pairs(test: &ModalModel, frfs: &[FrfSet]) -> Vec<(Dof, Dof)> {
    let functions = frfs.iter().flat_map(FrfSet::functions);
    let measured = functions.map(|f| (f.response.clone(), f.reference.clone()));
    let mut found: BTreeSet<(Dof, Dof)> = measured.collect();
    if found.is_empty() {
        let residues = test.modes.iter().flat_map(|mode| mode.residues.keys());
        found = residues.cloned().collect();
    }
    found.into_iter().collect()
}

/// `|sum phi_response phi_reference / m|` over some modes, 1/kg for translations; `None` where one
/// has no value. An unknown modal mass counts as 1: such a strength
/// shows only whether a root responds at all.
fn strength(
    theory: &ModalModel,
    modes: &[usize],
    (response, reference): &(Dof, Dof),
) -> Option<f64> {
    let of_mode = |&j: &usize| {
        let mode = &theory.modes[j];
        let product = reading(&mode.shape, response)? * reading(&mode.shape, reference)?;
        Some(product / modal_mass_kg(mode).unwrap_or(1.0))
    };
    let sum: Option<Complex64> = modes.iter().map(of_mode).sum();
    sum.filter(|_| !modes.is_empty()).map(Complex64::norm)
}

/// Component of a theory shape at a sensor (or hit) of the test: matched by point and axis, with
/// both signs, repeated measurements like the first.
fn reading(shape: &ModeShape, dof: &Dof) -> Option<Complex64> {
    let same = |candidate: &Dof| candidate.point() == dof.point() && candidate.axis() == dof.axis();
    let found = shape.iter().find(|(candidate, _)| same(candidate));
    found.map(|(candidate, value)| value * candidate.sign() * dof.sign())
}

/// The most that any mode has at a point over the square root of its modal mass, 1/√kg for a
/// translation; where a mass is not known, it counts as 1.
fn largest(theory: &ModalModel, dof: &Dof) -> f64 {
    let of = |mode: &Mode| {
        let mass = modal_mass_kg(mode).unwrap_or(1.0);
        reading(&mode.shape, dof).map(|value| value.norm() / mass.sqrt())
    };
    theory.modes.iter().filter_map(of).fold(0.0, f64::max)
}

/// Component of a mode at a point over the square root of its modal mass, 1/√kg for a translation;
/// `None` without a shape there.
pub(super) fn over_root_mass(mode: &Mode, dof: &Dof) -> Result<Option<Complex64>, NotJudged> {
    let mass = modal_mass_kg(mode).ok_or(NotJudged::ModalMass)?;
    Ok(reading(&mode.shape, dof).map(|value| value / mass.sqrt()))
}

/// Modal mass, kg for a translation; `None` where it is not known.
pub(super) fn modal_mass_kg(mode: &Mode) -> Option<f64> {
    let unit = (mode.scaling == Scaling::UnitModalMass).then_some(1.0);
    let mass = mode.modal_mass_kg.or(unit);
    mass.filter(|mass| mass.is_finite() && *mass > 0.0)
}

fn positive_damping(mode: &Mode) -> Option<f64> {
    mode.damping_ratio
        .filter(|ratio| ratio.is_finite() && *ratio > 0.0)
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let upper = values.len() / 2;
    let lower = values.len().checked_sub(1)? / 2;
    Some(0.5 * (values[lower] + values[upper]))
}
