//! Observability assesses whether a test can detect a root of the theory with its sensors,
//! excitation points and noise.
//!
//! The assessment needs shapes of the theory at the points of the test. Where noise, damping or
//! modal mass is not known, the observability is unknown, and an unknown observability never
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

/// Maximum strength of a root at a pair with a node, over the product of the largest values of any
/// mode at its response and at its reference.
///
/// An eigenvector is known to about 1e-14 of its largest component, five decades below. At equal
/// damping the peaks of two accelerances are as far apart as their strengths, here 180 dB, while a
/// converter of 24 bits spans 144 dB.
pub(super) const NODE_FRACTION_OF_LARGEST: f64 = 1e-9;

/// Minimum height of a detectable peak over the noise, dB.
pub const MIN_PEAK_OVER_NOISE_DB: f64 = 10.0;

/// Maximum standard deviation of a natural frequency, over the spacing to the nearest root.
pub const MAX_FREQUENCY_STD_OVER_SPACING: f64 = 0.25;

/// Observability of one elastic root of the theory by a test.
#[derive(Clone, Debug, PartialEq)]
pub struct Observability {
    /// (response, reference) pairs of the test.
    pub pairs: usize,
    /// Pairs at which the theory has shape values.
    pub pairs_in_theory: usize,
    /// Whether every pair has a node of the root.
    pub at_nodes: bool,
    /// Damping ratio that was used; `None` when neither test nor theory has one.
    pub damping: Option<RootDamping>,
    /// Distance to the nearest other elastic root, Hz; `None` for an only one.
    pub spacing_hz: Option<f64>,
    /// The peak over the noise, or why it was not assessed.
    pub noise: Result<PeakDetectability, NotAssessed>,
}

/// The damping ratio of a root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RootDamping {
    /// A fraction.
    pub ratio: f64,
    /// Whether it is the median of the test's modes, because the theory has none.
    pub from_test: bool,
}

/// The peak of a root over the noise of the FRFs.
#[derive(Clone, Debug, PartialEq)]
pub struct PeakDetectability {
    /// (response, reference) with the highest peak over the noise.
    pub best_pair: (Dof, Dof),
    /// Peak over the root mean square of the noise there, dB; infinite without noise.
    pub peak_over_noise_db: f64,
    /// Cramér-Rao bound of the standard deviation of the natural frequency from all pairs, Hz.
    pub frequency_std_hz: f64,
    /// Whether noise and strength are known at every pair, so that no pair can have a higher peak.
    pub complete: bool,
}

/// Reason why a root was not compared with the noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotAssessed {
    /// The theory has no modal mass.
    ModalMass,
    /// Neither the theory nor the test has a damping ratio.
    DampingRatio,
    /// The test has no function with a variance at the root.
    Variance,
}

impl fmt::Display for NotAssessed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            NotAssessed::ModalMass => "the model has no modal mass",
            NotAssessed::DampingRatio => "no damping ratio is known",
            NotAssessed::Variance => "the test has no FRF with a variance there",
        })
    }
}

impl Observability {
    /// Whether the test could have detected the root: at one pair its peak is 10 dB above the
    /// noise, and the Cramér-Rao bound of its frequency is below a quarter of the spacing to the
    /// nearest root. `None` when that is not known.
    pub fn observable(&self) -> Option<bool> {
        if self.at_nodes {
            return Some(false);
        }
        let noise = self.noise.as_ref().ok()?;
        let seen =
            noise.peak_over_noise_db >= MIN_PEAK_OVER_NOISE_DB && self.separates_roots(noise);
        (seen || noise.complete).then_some(seen)
    }

    fn separates_roots(&self, noise: &PeakDetectability) -> bool {
        self.spacing_hz
            .is_none_or(|spacing| noise.frequency_std_hz < MAX_FREQUENCY_STD_OVER_SPACING * spacing)
    }

    /// The numbers behind [`Self::observable`], as a clause.
    pub(super) fn reason(&self) -> String {
        if self.at_nodes {
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
        let peak = format!(
            "from {reference} to {response} its peak would stand {db:.1} dB over the noise"
        );
        let mut text = match self.spacing_hz {
            _ if db < MIN_PEAK_OVER_NOISE_DB => {
                format!("{peak}, {MIN_PEAK_OVER_NOISE_DB} dB are needed")
            }
            Some(spacing) if !self.separates_roots(noise) => format!(
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

/// Observability of every elastic root, in ascending frequency; `None` where the test has no
/// (response, reference) pairs, or the theory no shape at any of them.
///
/// Pairs are those of the test's FRFs when there are any, else those of the residues of its modes.
/// The strength of a root at a pair is `g = sum phi_response phi_reference / m` over its modes,
/// with modal masses `m`; for a repeated root it does not depend on the basis. Its receptance
/// `g/(w^2 - omega^2 + 2 i zeta w omega)` has the peak `|g|/(2 zeta w^2)`, times `w` for a mobility
/// and `w^2` for an accelerance. An exponential window that is still in the values adds its decay
/// rate `a`: the peak is then `|g|/(2 w delta)` with `delta = zeta w + a`. The noise is the
/// root mean square of the variance on the lines within `w ± delta`, at least the nearest line.
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
    let model = ObservabilityModel::new(theory, test, frfs);
    (0..model.roots.len()).map(|r| model.assess(r)).collect()
}

/// A test and a theory with the quantities that all roots have in common.
pub(super) struct ObservabilityModel<'a> {
    pub theory: &'a ModalModel,
    pub frfs: &'a [FrfSet],
    /// The elastic roots, ascending.
    pub roots: Vec<Root>,
    /// In ascending order.
    pairs: Vec<(Dof, Dof)>,
    test_damping: Option<f64>,
    /// Maximum strength of a root at a node, for every pair.
    node_limits: Vec<f64>,
}

impl<'a> ObservabilityModel<'a> {
    pub fn new(theory: &'a ModalModel, test: &ModalModel, frfs: &'a [FrfSet]) -> Self {
        let roots = elastic_roots(theory);
        let pairs = dof_pairs(test, frfs);
        let largest = |dof: &Dof| largest_value(theory, dof);
        let scales: BTreeMap<&Dof, f64> = pairs
            .iter()
            .flat_map(|(response, reference)| [response, reference])
            .map(|dof| (dof, largest(dof)))
            .collect();
        let limit = |(response, reference): &(Dof, Dof)| {
            NODE_FRACTION_OF_LARGEST * scales[response] * scales[reference]
        };
        Self {
            node_limits: pairs.iter().map(limit).collect(),
            test_damping: median(test.modes.iter().filter_map(positive_damping).collect()),
            theory,
            frfs,
            roots,
            pairs,
        }
    }

    /// The largest mass-normalised value of any mode at a point.
    pub fn largest(&self, dof: &Dof) -> f64 {
        largest_value(self.theory, dof)
    }

    fn assess(&self, r: usize) -> Option<Observability> {
        let root = &self.roots[r];
        let of_pair = |pair| strength(self.theory, &root.modes, pair);
        let strengths: Vec<Option<f64>> = self.pairs.iter().map(of_pair).collect();
        let known = strengths.iter().flatten().count();
        if known == 0 {
            return None;
        }
        let at_node = |(g, limit): (&Option<f64>, &f64)| g.is_some_and(|g| g <= *limit);
        let damping = self.damping(root);
        Some(Observability {
            pairs: self.pairs.len(),
            pairs_in_theory: known,
            at_nodes: strengths.iter().zip(&self.node_limits).all(at_node),
            damping,
            spacing_hz: self.spacing_hz(r),
            noise: self.peak_detectability(root, damping),
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

    /// Whether a pair has a node of the root with this strength.
    fn is_at_node(&self, pair: &(Dof, Dof), strength: f64) -> bool {
        let at = self.pairs.binary_search(pair);
        at.is_ok_and(|at| strength <= self.node_limits[at])
    }

    /// Distance of a root to the nearest other, Hz.
    pub fn spacing_hz(&self, r: usize) -> Option<f64> {
        let others = (0..self.roots.len()).filter(|&other| other != r);
        others
            .map(|other| (self.roots[other].hz - self.roots[r].hz).abs())
            .min_by(f64::total_cmp)
    }

    fn peak_detectability(
        &self,
        root: &Root,
        damping: Option<RootDamping>,
    ) -> Result<PeakDetectability, NotAssessed> {
        let masses = root.modes.iter().map(|&j| &self.theory.modes[j]);
        if masses.map(modal_mass_kg).any(|mass| mass.is_none()) {
            return Err(NotAssessed::ModalMass);
        }
        let ratio = damping.ok_or(NotAssessed::DampingRatio)?.ratio;
        let mut best: Option<(f64, (Dof, Dof))> = None;
        let (mut per_variance, mut complete) = (0.0, true);
        for set in self.frfs {
            let peak = Peak::new(root.hz, ratio, set);
            for (i, function) in set.functions().iter().enumerate() {
                let pair = (function.response.clone(), function.reference.clone());
                let strength = strength(self.theory, &root.modes, &pair);
                let squared = strength.and_then(|g| peak.over_noise_squared(set, i, g));
                let Some(squared) = squared else {
                    complete &= strength.is_some_and(|g| self.is_at_node(&pair, g));
                    continue;
                };
                per_variance += squared / peak.variance_of_unit_peak();
                if best.as_ref().is_none_or(|(highest, _)| squared > *highest) {
                    best = Some((squared, pair));
                }
            }
        }
        let (highest, best_pair) = best.ok_or(NotAssessed::Variance)?;
        Ok(PeakDetectability {
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
        // Of a root at a node there is no peak even where the noise is zero.
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

/// (response, reference) pairs of the FRFs, else of the residues of the test's modes, ascending.
fn dof_pairs(test: &ModalModel, frfs: &[FrfSet]) -> Vec<(Dof, Dof)> {
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
/// has no value. An unknown modal mass counts as 1: such a strength shows only whether the pair has
/// a node.
fn strength(
    theory: &ModalModel,
    modes: &[usize],
    (response, reference): &(Dof, Dof),
) -> Option<f64> {
    let of_mode = |&j: &usize| {
        let mode = &theory.modes[j];
        let product = theory_value(&mode.shape, response)? * theory_value(&mode.shape, reference)?;
        Some(product / modal_mass_kg(mode).unwrap_or(1.0))
    };
    let sum: Option<Complex64> = modes.iter().map(of_mode).sum();
    sum.filter(|_| !modes.is_empty()).map(Complex64::norm)
}

/// Component of a theory shape at a sensor (or hit) of the test: matched by point and axis, with
/// both signs, repeated measurements like the first.
fn theory_value(shape: &ModeShape, dof: &Dof) -> Option<Complex64> {
    let same = |candidate: &Dof| candidate.point() == dof.point() && candidate.axis() == dof.axis();
    let found = shape.iter().find(|(candidate, _)| same(candidate));
    found.map(|(candidate, value)| value * candidate.sign() * dof.sign())
}

/// The largest value of any mode at a point, over the square root of its modal mass, 1/√kg for a
/// translation; an unknown mass counts as 1.
fn largest_value(theory: &ModalModel, dof: &Dof) -> f64 {
    let of = |mode: &Mode| {
        let mass = modal_mass_kg(mode).unwrap_or(1.0);
        theory_value(&mode.shape, dof).map(|value| value.norm() / mass.sqrt())
    };
    theory.modes.iter().filter_map(of).fold(0.0, f64::max)
}

/// Component of a mode at a point over the square root of its modal mass, 1/√kg for a translation;
/// `None` without a shape there.
pub(super) fn mass_normalised_value(
    mode: &Mode,
    dof: &Dof,
) -> Result<Option<Complex64>, NotAssessed> {
    let mass = modal_mass_kg(mode).ok_or(NotAssessed::ModalMass)?;
    Ok(theory_value(&mode.shape, dof).map(|value| value / mass.sqrt()))
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
