//! Which roots of a fit are no modes of their own: what noise makes, what is not known, what cannot
//! be told from another.

use std::f64::consts::TAU;

use crate::modal::mac;

use crate::identify::data::frf_matrix::Sides;
use crate::identify::data::model_pole::{Root, resonates};
use crate::identify::fit::block_descent::apart;
use crate::identify::fit::detection_threshold::{modes_above_noise, significance};
use crate::identify::ml::findings::Reason;

/// Widths of resonances that differ for noise, at each line.
const WIDTHS: f64 = 16.0;
/// Widest root as a share of the band; what is wider is background.
pub(in crate::identify) const WIDEST: f64 = 0.5;
/// Narrowest half-power width, lines: what is narrower is a single line.
const NARROWEST: f64 = 0.01;
/// Deviation of a pole over its decay rate that is still a pole.
pub(in crate::identify) const KNOWN: f64 = 0.2;
/// Distance to the maximum of the likelihood over the decay rate from which on a pole of a method
/// is none of the data's.
const MOST_OFFSET: f64 = 0.15;
/// Deviations by which two roots must be apart.
const TOLD_APART: f64 = 2.0;
/// Participation factors less alike than this can be two modes of one root.
const INDEPENDENT: f64 = 0.95;

/// What must become of a root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) enum Change {
    /// It goes.
    Drop(usize, Reason),
    /// The second becomes part of the first.
    Join(usize, usize),
    /// It has so many modes only.
    FewerParts(usize, usize),
}

/// What a root is held to.
pub(in crate::identify) struct Judge<'a> {
    /// Outputs and inputs.
    pub sides: &'a Sides,
    /// Chance of a false alarm in the whole band.
    pub false_alarm_probability: f64,
    /// Number of lines.
    pub lines: usize,
    /// Their spacing, rad/s.
    pub step: f64,
}

impl Judge<'_> {
    /// What must change, at most one thing for roots that lean on each other.
    pub fn unfit(&self, roots: &[Root]) -> Vec<Change> {
        let mut order: Vec<usize> = (0..roots.len()).collect();
        order.sort_by(|a, b| {
            let worth = |j: &usize| roots[*j].quality.significance();
            worth(a).total_cmp(&worth(b))
        });
        let mut changes: Vec<Change> = Vec::new();
        let mut touched: Vec<usize> = Vec::new();
        for j in order {
            let leans = |other: &usize| apart(&roots[j], &roots[*other]) < 1.0;
            if touched.iter().any(leans) {
                continue;
            }
            if let Some(change) = self.change_of(roots, j) {
                touched.push(j);
                changes.push(change);
            }
        }
        changes
    }

    fn change_of(&self, roots: &[Root], j: usize) -> Option<Change> {
        let (root, quality) = (&roots[j], &roots[j].quality);
        let chance = self.false_alarm_probability / (WIDTHS * self.lines as f64);
        let (significance, limit) = significance(root, self.sides, chance);
        if significance <= limit && root.multiplicity() > 1 {
            let modes = modes_above_noise(root, self.sides, chance);
            return Some(Change::FewerParts(j, modes.max(1)));
        }
        if significance <= limit {
            return Some(less(roots, j, Reason::Noise(significance, limit)));
        }
        if let Some(twin) = twin(roots, self.sides.inputs, j) {
            return Some(twin);
        }
        let width = root.width();
        let widest = WIDEST * self.step * self.lines.saturating_sub(1) as f64;
        let reason = if quality.pole_std >= KNOWN * root.decay() {
            Reason::Unknown(quality.pole_std / root.decay())
        } else if quality.offset.norm() >= MOST_OFFSET * root.decay() {
            Reason::Unknown(quality.offset.norm() / root.decay())
        } else if !resonates(root.lambda) || width >= widest || width <= NARROWEST * self.step {
            Reason::Width(width / TAU)
        } else {
            return None;
        };
        Some(less(roots, j, reason))
    }
}

/// A root with one mode less.
pub(in crate::identify) fn less(roots: &[Root], j: usize, reason: Reason) -> Change {
    if roots[j].multiplicity() > 1 {
        Change::FewerParts(j, roots[j].multiplicity() - 1)
    } else {
        Change::Drop(j, reason)
    }
}

/// What becomes of a root that cannot be told from a stronger one.
fn twin(roots: &[Root], inputs: usize, j: usize) -> Option<Change> {
    let near = |i: &usize| {
        let (a, b) = (&roots[*i], &roots[j]);
        let (p, q) = (a.quality.pole_error(), b.quality.pole_error());
        let apart = (a.lambda - b.lambda).norm();
        let stronger = a.quality.significance() >= b.quality.significance();
        let beside = apart < 2.0 * a.decay().max(b.decay()) && apart < TOLD_APART * p.hypot(q);
        *i != j && stronger && beside && (a.pair.is_none() || a.pair != b.pair)
    };
    let distance = |i: &usize| (roots[*i].lambda - roots[j].lambda).norm();
    let i = (0..roots.len())
        .filter(near)
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    let (a, b) = (&roots[i], &roots[j]);
    let modes = a.multiplicity() + b.multiplicity();
    let alike = a
        .parts
        .iter()
        .flat_map(|p| b.parts.iter().map(move |q| mac(p, q)));
    let alike = alike.flatten().fold(0.0, f64::max);
    Some(if modes <= inputs && alike < INDEPENDENT {
        Change::Join(i, j)
    } else {
        let deviation = a.quality.pole_error().hypot(b.quality.pole_error());
        less(roots, j, Reason::Twin(distance(&i) / deviation))
    })
}
