//! How a root stands in the data around it: what the model misses there, and how much of the
//! response is the root's own.

use std::f64::consts::TAU;
use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;
use statrs::distribution::{Beta, ContinuousCDF};

use crate::linalg::{self, ComplexMatrix};
use crate::modal::{Pole, mac};

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::frf_matrix::Sides;
use crate::identify::data::model_pole::Root;
use crate::identify::data::residual::{Described, Rest};
use crate::identify::estimator::Candidate;
use crate::identify::fit::block_descent::apart;

/// Lines on either side of a root that are its own: half-power widths, and fewest.
const OWN: f64 = 1.0;
const FEWEST_OWN: usize = 3;

/// Misfit above which the model misses the data.
pub(in crate::identify) const MOST_MISFIT: f64 = 4.0;
const STRICT_MISFIT: f64 = 2.0;
/// Least share of the response of a root where the model misses the data.
pub(in crate::identify) const LEAST_SHARE: f64 = 0.2;
/// Share of the response from which a root is a mode of its own.
const OWN_MODE: f64 = 0.5;
/// Sums of half-power widths within which a root lies beside another.
const BESIDE: f64 = 4.0;
/// Half-power widths within which it lies in the other's resonance, and how much wider it may be.
const WITHIN: f64 = 2.0;
const WIDER: f64 = 2.0;
/// Modal assurance criterion above which a root repeats the shape of its neighbour.
const SAME_SHAPE: f64 = 0.7;
/// Least share of the response anywhere: what is less is beyond the linearity of a structure and of
/// its model.
pub(in crate::identify) const LINEAR: f64 = 3e-4;
/// The same for the weakest of several modes of one root, which the differences between poles make
/// as well.
const REPEATED: f64 = 1e-2;
/// Share relative to that of a mode whose shape is repeated within its resonance, which errors of
/// the force make as well.
const ECHO: f64 = 3e-2;
/// Probability that a shape is repeated on one side by chance.
const BY_CHANCE: f64 = 0.01;
/// Phase, rad, by which the residues of a mode may differ from those of real modes and of its
/// neighbour, besides what noise does.
pub(in crate::identify) const MOST_PHASE: f64 = 0.7;

/// Parts in phase less those in quadrature: of a real shape at least, and of one that is hardly
/// more in phase than in quadrature.
const REAL: f64 = 0.8;
const HALF_REAL: f64 = 0.5;
/// Roots of such shapes from which on many are no modes: one in so many, and fewest.
const SCATTERED: usize = 4;
const FEWEST_SCATTERED: usize = 3;
/// Functions from which on a random shape is not real by chance.
const FEWEST_FUNCTIONS: usize = 3;

/// A root in the data around it.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct Standing {
    /// Mean square of what the model leaves over on the root's own lines, over that of the noise: 1
    /// where noise is all.
    pub misfit: f64,
    /// Share of the response on the root's own lines that nothing but this root explains: the root
    /// of its energy with all other residues fitted, over that of the response.
    pub share: f64,
    /// Least share that errors of the force or of a sensor beside it leave to a mode here; 0 where
    /// it repeats no other's shape.
    pub echo: f64,
    /// Standard deviation of each part of the pole by narrower bands, rad/s, where they move it by
    /// more than noise ([`NarrowerBands`](crate::identify::ml::narrower_bands::NarrowerBands)); 0 before the fit
    /// is complete.
    pub band_deviation: f64,
}

/// Of each root.
pub(in crate::identify) fn standings(
    (data, sides): (&Receptances, &Sides),
    roots: &[Root],
) -> Vec<Standing> {
    let described = data.far().beside(data, roots);
    let standing = |root: &Root| {
        let lines = own_lines(data, root);
        let of = |f: usize| {
            let power = |k: usize| data.values[f][k].norm_sqr() / data.variance[f][k];
            lines.clone().map(power).sum::<f64>()
        };
        let whole: f64 = (0..data.functions()).map(of).sum();
        Standing {
            misfit: missed(data, &described, root),
            share: (0.5 * root.quality.significance().max(0.0) / whole).sqrt(),
            echo: 0.0,
            band_deviation: 0.0,
        }
    };
    let mut standings: Vec<Standing> = roots.par_iter().map(standing).collect();
    let echo = |j: usize| {
        let least = |i: usize| ECHO * standings[i].share;
        let repeated = |i: &usize| {
            let (weak, other) = (&roots[j], &roots[*i]);
            let weaker = standings[j].share < least(*i) && lies_within(weak, other);
            weaker && (repeats_shape(weak, other) || repeats_side(sides, weak, other))
        };
        let others = (0..roots.len()).filter(repeated).map(least);
        others.fold(0.0, f64::max)
    };
    let echoes: Vec<f64> = (0..roots.len()).into_par_iter().map(echo).collect();
    for (standing, echo) in standings.iter_mut().zip(echoes) {
        standing.echo = echo;
    }
    standings
}

/// Whether a root responds where another does and hardly elsewhere.
fn lies_within(root: &Root, other: &Root) -> bool {
    let distance = (root.lambda.im - other.lambda.im).abs();
    distance < WITHIN * other.width() && root.width() < WIDER * other.width()
}

fn repeats_shape(root: &Root, other: &Root) -> bool {
    mac(&root.residues, &other.residues) > Some(SAME_SHAPE)
}

/// Whether a root of one mode has shape values, or participation factors, among those of another
/// root: an error of the channels of one side leaves the other side's factors as they are.
///
/// The part of a random vector of n values that lies among m others is a beta variable of m and n −
/// m: only what exceeds its quantile says anything.
fn repeats_side(sides: &Sides, root: &Root, other: &Root) -> bool {
    if sides.inputs < 2 || root.multiplicity() > 1 {
        return false;
    }
    let of = |root: &Root| linalg::singular_vectors(&sides.matrix(|f| root.residues[f]));
    let (Ok(vectors), Ok(other_vectors)) = (of(root), of(other)) else {
        return false;
    };
    let modes = other.multiplicity();
    let within = |vector: &ComplexMatrix, others: &ComplexMatrix| {
        let values = vector.nrows();
        if values <= modes {
            return false;
        }
        let product = |m: usize| -> Complex64 {
            let terms = (0..values).map(|i| others[(i, m)].conj() * vector[(i, 0)]);
            terms.sum()
        };
        let part: f64 = (0..modes).map(|m| product(m).norm_sqr()).sum();
        let chance = Beta::new(modes as f64, (values - modes) as f64);
        let limit = chance.map_or(1.0, |beta| beta.inverse_cdf(1.0 - BY_CHANCE));
        part > limit.max(SAME_SHAPE)
    };
    within(&vectors.left, &other_vectors.left) || within(&vectors.right, &other_vectors.right)
}

/// Mean square of what a model leaves over (over the noise) on the own lines of a root.
pub(in crate::identify) fn missed(data: &Receptances, described: &Described, root: &Root) -> f64 {
    misfit(data, &described.left_over(own_lines(data, root)), root)
}

/// The same of what is left over, on those lines at least.
pub(in crate::identify) fn misfit(data: &Receptances, rest: &Rest, root: &Root) -> f64 {
    let lines = own_lines(data, root);
    let values = (lines.len() * data.functions()) as f64;
    let held = |k: usize| data.shared.held((data, rest), k, |f| rest.at(f, k));
    lines.map(held).sum::<f64>() / values
}

/// The same of each function, without the noise that functions share.
pub(in crate::identify) fn misfit_by_function(
    data: &Receptances,
    rest: &Rest,
    root: &Root,
) -> Vec<f64> {
    let lines = own_lines(data, root);
    let of = |f: usize| {
        let squares = lines.clone().map(|k| rest.at(f, k).norm_sqr());
        squares.sum::<f64>() / lines.len() as f64
    };
    (0..data.functions()).map(of).collect()
}

/// Lines of a root on which its misfit is measured.
pub(in crate::identify) fn own_lines(data: &Receptances, root: &Root) -> Range<usize> {
    lines_around(data, root, OWN)
}

/// Lines within so many half-power widths of a root, and a few at least.
pub(in crate::identify) fn lines_around(
    data: &Receptances,
    root: &Root,
    widths: f64,
) -> Range<usize> {
    let side = (widths * root.width() / data.step).round() as usize;
    let side = side.max(FEWEST_OWN);
    let top = data.line_of(root.lambda);
    top.saturating_sub(side)..(top + side + 1).min(data.lines())
}

/// Why a root is no mode although it is above the noise.
///
/// What a model does not describe (a resonance that moves from hit to hit, a record that was cut, a
/// rattle) is fitted by roots beside the modes. They explain little of the response where the model
/// misses the data or many have arbitrary phases; or they repeat the shape of a strong neighbour
/// with another phase than modes have; or they explain so little that no structure is linear enough
/// for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) enum Doubt {
    /// Share of the response, where the model misses the data.
    Share(f64),
    /// Phase against real modes, rad.
    Phase(f64),
    /// Share of the response and the limit that it does not reach: that to which structures are
    /// linear, or forces are known.
    Tiny(f64, f64),
}

impl Standing {
    /// What the deviations of a fit must be multiplied with: where the model misses the data, what
    /// it misses counts as noise.
    pub fn inflation(&self) -> f64 {
        if self.misfit > STRICT_MISFIT {
            self.misfit.sqrt()
        } else {
            1.0
        }
    }

    /// Standard deviation of each part of the pole, rad/s, with what the model misses.
    pub fn pole_std(&self, root: &Root) -> f64 {
        (root.quality.pole_std * self.inflation()).hypot(self.band_deviation)
    }
}

impl Doubt {
    /// Whether it comes from what the model does not describe.
    pub fn is_misfit(&self) -> bool {
        !matches!(self, Self::Tiny(..))
    }
}

/// How much is held against a root.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::identify) enum Scrutiny {
    /// The model describes the data: what is above the noise is a mode unless much speaks against
    /// it.
    Mild,
    /// The model misses the data in several places.
    Strict,
    /// It describes them with roots of arbitrary phases ([`phases_scatter`]).
    Scattered,
}

/// What speaks against a root.
pub(in crate::identify) fn doubt(
    roots: &[Root],
    standings: &[Standing],
    (j, scrutiny): (usize, Scrutiny),
) -> Option<Doubt> {
    let (root, metrics) = (&roots[j], &standings[j]);
    let strict = scrutiny == Scrutiny::Strict;
    let least = if root.multiplicity() > 1 {
        REPEATED
    } else {
        LINEAR
    };
    if metrics.share < least {
        return Some(Doubt::Tiny(metrics.share, least));
    }
    let most = if strict { STRICT_MISFIT } else { MOST_MISFIT };
    let misses = metrics.misfit > most || scrutiny == Scrutiny::Scattered;
    if misses && metrics.share < LEAST_SHARE {
        return Some(Doubt::Share(metrics.share));
    }
    let distance = |i: &usize| apart(root, &roots[*i]);
    if metrics.share < metrics.echo {
        return Some(Doubt::Tiny(metrics.share, metrics.echo));
    }
    let strong = |i: &usize| *i != j && standings[*i].share >= OWN_MODE;
    let nearest = (0..roots.len())
        .filter(strong)
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    let repeats = distance(&nearest) < BESIDE && repeats_shape(root, &roots[nearest]);
    if metrics.share >= OWN_MODE || !(strict || repeats) {
        return None;
    }
    let (phase, other) = (residue_phase(root), residue_phase(&roots[nearest]));
    // A delay of a channel turns both.
    let apart = phase_between(phase, other).min(phase_between(phase, 0.0));
    (apart > MOST_PHASE + unknown(root, metrics)).then_some(Doubt::Phase(apart))
}

/// The root whose phase a root's is held against: the nearest of those that are modes of their own,
/// else the strongest.
fn reference(roots: &[Root], standings: &[Standing], j: usize) -> Option<usize> {
    let others = || (0..roots.len()).filter(|i| *i != j);
    let distance = |i: &usize| apart(&roots[j], &roots[*i]);
    let strength = |i: &usize| roots[*i].quality.significance();
    others()
        .filter(|i| standings[*i].share >= OWN_MODE)
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .or_else(|| others().max_by(|a, b| strength(a).total_cmp(&strength(b))))
}

/// Deviation of a root's phase, rad, with what the model misses as noise.
fn unknown(root: &Root, metrics: &Standing) -> f64 {
    root.quality.pole_std * metrics.misfit.max(1.0).sqrt() / root.decay()
}

/// Whether many roots are no modes of one structure: the strongest has a real shape, and a quarter
/// of all are no modes of their own and have shapes as much in quadrature as in phase with real
/// modes and with the nearest mode of its own, or the strongest root where none is.
///
/// So many roots can describe any smooth course that modes do not, down to the noise: what speaks
/// against them is not what they leave over but that the phases of their shapes are arbitrary. Of
/// one or two functions every shape is nearly real: only what is more in quadrature than in phase
/// counts there.
pub(in crate::identify) fn phases_scatter(roots: &[Root], standings: &[Standing]) -> bool {
    let strength = |root: &&Root| root.quality.significance();
    let strongest = roots
        .iter()
        .max_by(|a, b| strength(a).total_cmp(&strength(b)));
    let Some(strongest) = strongest else {
        return false;
    };
    if in_phase(strongest, residue_phase(strongest)) < REAL {
        return false;
    }
    let few = strongest.residues.len() < FEWEST_FUNCTIONS;
    let limit = if few { 0.0 } else { HALF_REAL };
    let scattered = |j: &usize| {
        let (root, metrics) = (&roots[*j], &standings[*j]);
        let other = reference(roots, standings, *j).map_or(0.0, |i| residue_phase(&roots[i]));
        let most = in_phase(root, other).max(in_phase(root, 0.0));
        // cos 2φ moves by 2 for each radian at most.
        metrics.share < OWN_MODE && most + 2.0 * unknown(root, metrics) < limit
    };
    let count = (0..roots.len()).filter(scattered).count();
    count >= FEWEST_SCATTERED.max(roots.len().div_ceil(SCATTERED))
}

/// Part of a root's residues in phase with real modes turned by `phase`, less the part in
/// quadrature: `−Re Σ a² e^(−2iφ) / Σ |a|²`.
fn in_phase(root: &Root, phase: f64) -> f64 {
    let turn = Complex64::from_polar(1.0, -2.0 * phase);
    let squares: Complex64 = root.residues.iter().map(|a| a * a * turn).sum();
    -squares.re / root.residues.iter().map(Complex64::norm_sqr).sum::<f64>()
}

/// A root as a candidate.
///
/// Errors of real and imaginary part of λ have one deviation and are independent, so that those of
/// frequency and damping are too: `σ_f = σ_λ/2π`, `σ_ζ = σ_λ √(1 − ζ²)/|λ|`.
pub(in crate::identify) fn candidate(root: &Root, standing: &Standing) -> Candidate {
    let std = standing.pole_std(root);
    let (bias, along) = (root.quality.bias, root.lambda / root.lambda.norm());
    Candidate {
        order: None,
        pole: Pole {
            lambda: root.lambda,
        },
        participation: None,
        frequency_damping_correlation: Some(0.0),
        residues: Some(root.residues.clone()),
        residue_stds: None,
        multiplicity: root.multiplicity(),
        frequency_std_hz: Some(std / TAU),
        damping_std: Some(std * root.lambda.im / root.lambda.norm_sqr()),
        frequency_bias_hz: bias.map(|bias| (bias * along.conj()).re.abs() / TAU),
        damping_bias: bias.map(|bias| {
            let across = (bias * along.conj()).im.abs();
            across * root.lambda.im / root.lambda.norm_sqr()
        }),
        quality: None,
    }
}

/// Phase of all residues together, rad, modulo π: 0 for real modes.
fn residue_phase(root: &Root) -> f64 {
    let squares: Complex64 = root.residues.iter().map(|a| a * a).sum();
    0.5 * (-squares).arg()
}

/// Distance of two phases modulo π, rad.
fn phase_between(a: f64, b: f64) -> f64 {
    let pi = std::f64::consts::PI;
    let apart = (a - b).rem_euclid(pi);
    apart.min(pi - apart)
}
