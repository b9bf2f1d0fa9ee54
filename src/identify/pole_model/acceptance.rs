//! The acceptance test of poles checks significance above the noise, standard deviation of the
//! pole, separation from stronger poles, and bandwidth; a pole that fails is dropped, joined with
//! its neighbour, or reduced in multiplicity.

use std::f64::consts::TAU;

use crate::modal::mac;

use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::model_pole::{ModelPole, is_resonance};
use crate::identify::fit::detection_threshold::{modes_above_noise, significance};
use crate::identify::pole_model::findings::DropReason;
use crate::linalg::sort_ascending_by;

/// Number of independent resonance widths at each frequency line: trials of noise for the
/// false-alarm probability.
const WIDTHS_PER_LINE: f64 = 16.0;
/// Maximum half-power bandwidth over the band; wider poles are out-of-band terms.
pub(in crate::identify) const MAX_BANDWIDTH_OVER_BAND: f64 = 0.5;
/// Minimum half-power bandwidth, frequency lines; a narrower pole fits a single line.
const MIN_WIDTH_LINES: f64 = 0.01;
/// Maximum standard deviation of a pole over its decay rate; above it the pole is undetermined.
pub(in crate::identify) const MAX_POLE_STD_OVER_DECAY_RATE: f64 = 0.2;
/// Maximum Gauss-Newton offset from the maximum of the likelihood over the decay rate; above it the
/// pole of another method does not fit the data, unless it is the column of a peak.
const MAX_OFFSET_OVER_DECAY_RATE: f64 = 0.15;
/// Minimum separation of two poles, in standard deviations of their distance.
const MIN_SEPARATION_STDS: f64 = 2.0;
/// MAC of participation factors below which inseparable poles may be two modes of one repeated
/// pole.
const MAX_MAC_INDEPENDENT: f64 = 0.95;

/// Edit of the pole list that a pole requires.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) enum PoleEdit {
    /// Removes the pole.
    Remove(usize, DropReason),
    /// Merges the second pole into the first, as a repeated pole.
    Merge(usize, usize),
    /// Reduces the multiplicity of a pole to a number of modes.
    ReduceMultiplicity(usize, usize),
}

impl PoleEdit {
    /// Whether it removes a pole that the data do not need wherever its neighbours move.
    pub fn is_removal_of_noise(&self) -> bool {
        match self {
            Self::Remove(_, reason) => !matches!(reason, DropReason::NotSeparable(_)),
            Self::Merge(..) | Self::ReduceMultiplicity(..) => false,
        }
    }
}

/// Limits of the acceptance test.
pub(in crate::identify) struct AcceptanceTest<'a> {
    /// Outputs and inputs of the FRF matrix.
    pub frf_matrix: &'a FrfMatrix,
    /// False-alarm probability in the whole band.
    pub false_alarm_probability: f64,
    /// Number of frequency lines.
    pub lines: usize,
    /// Spacing of the frequency lines, rad/s.
    pub step: f64,
}

impl AcceptanceTest<'_> {
    /// Required edits, at most one of poles within a half-power bandwidth of each other.
    pub fn required_edits(&self, poles: &[ModelPole]) -> Vec<PoleEdit> {
        let mut order: Vec<usize> = (0..poles.len()).collect();
        sort_ascending_by(&mut order, |j| poles[*j].quality.significance());
        let mut changes: Vec<PoleEdit> = Vec::new();
        let mut touched: Vec<usize> = Vec::new();
        for j in order {
            let leans = |other: &usize| poles[j].separation(&poles[*other]) < 1.0;
            if touched.iter().any(leans) {
                continue;
            }
            if let Some(change) = self.required_edit(poles, j) {
                touched.push(j);
                changes.push(change);
            }
        }
        changes
    }

    fn required_edit(&self, poles: &[ModelPole], j: usize) -> Option<PoleEdit> {
        let (pole, quality) = (&poles[j], &poles[j].quality);
        let false_alarm_probability =
            self.false_alarm_probability / (WIDTHS_PER_LINE * self.lines as f64);
        let (significance, limit) = significance(pole, self.frf_matrix, false_alarm_probability);
        if significance <= limit && pole.multiplicity() > 1 {
            let modes = modes_above_noise(pole, self.frf_matrix, false_alarm_probability);
            return Some(PoleEdit::ReduceMultiplicity(j, modes.max(1)));
        }
        if significance <= limit {
            return Some(remove_or_reduce(
                poles,
                j,
                DropReason::BelowNoise(significance, limit),
            ));
        }
        if let Some(edit) = merge_or_remove(poles, self.frf_matrix.inputs, j) {
            return Some(edit);
        }
        let width = pole.width();
        let widest = MAX_BANDWIDTH_OVER_BAND * self.step * self.lines.saturating_sub(1) as f64;
        // The bias of a method with fixed poles is not limited by the noise: the single pole of a
        // peak's column has a larger standard deviation instead.
        let is_limited = !pole.is_peak_column || pole.multiplicity() > 1;
        let limit = |ratio: f64| match is_limited {
            true => ratio * pole.decay(),
            false => f64::INFINITY,
        };
        let reason = if quality.pole_std >= limit(MAX_POLE_STD_OVER_DECAY_RATE) {
            DropReason::PoleUndetermined(quality.pole_std / pole.decay())
        } else if quality.offset.norm() >= limit(MAX_OFFSET_OVER_DECAY_RATE) {
            DropReason::PoleUndetermined(quality.offset.norm() / pole.decay())
        } else if !is_resonance(pole.lambda)
            || width >= widest
            || width <= MIN_WIDTH_LINES * self.step
        {
            DropReason::NotResonant(width / TAU)
        } else {
            return None;
        };
        Some(remove_or_reduce(poles, j, reason))
    }
}

/// Edit that reduces the multiplicity of a pole by one, or removes a single pole.
pub(in crate::identify) fn remove_or_reduce(
    poles: &[ModelPole],
    j: usize,
    reason: DropReason,
) -> PoleEdit {
    if poles[j].multiplicity() > 1 {
        PoleEdit::ReduceMultiplicity(j, poles[j].multiplicity() - 1)
    } else {
        PoleEdit::Remove(j, reason)
    }
}

/// Edit for a pole that is inseparable from a stronger one: a merge into a repeated pole where the
/// participation factors differ, else a removal.
fn merge_or_remove(poles: &[ModelPole], inputs: usize, j: usize) -> Option<PoleEdit> {
    let near = |i: &usize| {
        let (a, b) = (&poles[*i], &poles[j]);
        let (p, q) = (a.quality.pole_error(), b.quality.pole_error());
        let apart = (a.lambda - b.lambda).norm();
        // Two peaks are two modes, and the column of a peak is no part of another pole.
        let stronger = match (a.is_peak_column, b.is_peak_column) {
            (true, false) => true,
            (_, true) => false,
            (false, false) => a.quality.significance() >= b.quality.significance(),
        };
        let is_inseparable =
            apart < 2.0 * a.decay().max(b.decay()) && apart < MIN_SEPARATION_STDS * p.hypot(q);
        *i != j && stronger && is_inseparable && (a.pair.is_none() || a.pair != b.pair)
    };
    let distance = |i: &usize| (poles[*i].lambda - poles[j].lambda).norm();
    let i = (0..poles.len())
        .filter(near)
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    let (a, b) = (&poles[i], &poles[j]);
    let modes = a.multiplicity() + b.multiplicity();
    let max_mac = a
        .parts
        .iter()
        .flat_map(|p| b.parts.iter().map(move |q| mac(p, q)));
    let max_mac = max_mac.flatten().fold(0.0, f64::max);
    Some(if modes <= inputs && max_mac < MAX_MAC_INDEPENDENT {
        PoleEdit::Merge(i, j)
    } else {
        let deviation = a.quality.pole_error().hypot(b.quality.pole_error());
        remove_or_reduce(poles, j, DropReason::NotSeparable(distance(&i) / deviation))
    })
}
