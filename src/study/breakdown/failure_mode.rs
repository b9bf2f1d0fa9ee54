//! A failure mode names the first error by which a method misses the stated error in a draw.

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::correlate::subspace_mac;
use crate::dof::Dof;
use crate::modal::{ModalModel, Mode, mac};

/// Largest errors of a method that count as success.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StatedError {
    /// Error of a frequency, as a share of the half-power width of its mode.
    pub frequency_widths: f64,
    /// Error of a frequency in percent, an additional limit.
    pub frequency_percent: Option<f64>,
    /// Error of a damping ratio, percent.
    pub damping_percent: f64,
    /// Smallest MAC of a shape.
    pub mac: f64,
    /// Error of the size of the residues of a mode, percent; not checked without it.
    pub residue_percent: Option<f64>,
}

impl Default for StatedError {
    /// A tenth of the half-power width, 10 % of the damping ratio, a MAC of 0.9, 20 % of the
    /// residues.
    fn default() -> Self {
        Self {
            frequency_widths: 0.1,
            frequency_percent: None,
            damping_percent: 10.0,
            mac: 0.9,
            residue_percent: Some(20.0),
        }
    }
}

/// Error of a method in a draw; of several the first in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FailureMode {
    /// The method or the estimation of FRFs ended with an error.
    NoAnswer,
    /// Two modes are identified as one.
    Merged,
    /// A mode is missing.
    Missed,
    /// A found mode is spurious.
    Invented,
    /// A frequency is off.
    Frequency,
    /// A damping ratio is too high.
    DampingHigh,
    /// A damping ratio is too low.
    DampingLow,
    /// A shape is wrong.
    Shape,
    /// Residues are too small.
    ResidueSmall,
    /// Residues are too large.
    ResidueLarge,
}

/// All failure modes in their order.
pub const FAILURE_MODES: [FailureMode; 10] = [
    FailureMode::NoAnswer,
    FailureMode::Merged,
    FailureMode::Missed,
    FailureMode::Invented,
    FailureMode::Frequency,
    FailureMode::DampingHigh,
    FailureMode::DampingLow,
    FailureMode::Shape,
    FailureMode::ResidueSmall,
    FailureMode::ResidueLarge,
];

impl FailureMode {
    /// Its name in CSV.
    pub fn name(self) -> &'static str {
        match self {
            FailureMode::NoAnswer => "no-answer",
            FailureMode::Merged => "merged",
            FailureMode::Missed => "missed",
            FailureMode::Invented => "invented",
            FailureMode::Frequency => "frequency",
            FailureMode::DampingHigh => "damping-high",
            FailureMode::DampingLow => "damping-low",
            FailureMode::Shape => "shape",
            FailureMode::ResidueSmall => "residue-small",
            FailureMode::ResidueLarge => "residue-large",
        }
    }

    /// Its description for tables and figures.
    pub fn sentence(self) -> &'static str {
        match self {
            FailureMode::NoAnswer => "no answer",
            FailureMode::Merged => "the pair identified as one mode",
            FailureMode::Missed => "a mode missed",
            FailureMode::Invented => "a mode invented",
            FailureMode::Frequency => "a frequency off",
            FailureMode::DampingHigh => "damping too high",
            FailureMode::DampingLow => "damping too low",
            FailureMode::Shape => "a shape wrong",
            FailureMode::ResidueSmall => "residues too small",
            FailureMode::ResidueLarge => "residues too large",
        }
    }

    /// Its place in [`FAILURE_MODES`].
    pub fn index(self) -> usize {
        self as usize
    }
}

/// Largest distance of a found mode from its true one, in half-power bandwidths of the true one.
const MATCH_BANDWIDTHS: f64 = 1.0;

/// Largest distance, in half-power bandwidths, of a missing mode that counts as merged with a found
/// one: within it both form one peak.
const MERGE_BANDWIDTHS: f64 = 2.0;

/// The first error of the modes of a method, shapes compared at the responses; `None` where all
/// true modes are found to the stated error and no other.
pub fn first_failure(
    truth: &ModalModel,
    found: &ModalModel,
    responses: &[Dof],
    stated: &StatedError,
) -> Option<FailureMode> {
    let partners = partners(&truth.modes, &found.modes);
    if let Some(missed) = partners.iter().position(Option::is_none) {
        return Some(missing(truth, found, &partners, missed));
    }
    if found.modes.len() > truth.modes.len() {
        return Some(FailureMode::Invented);
    }
    let pairs = || {
        let all = truth.modes.iter().zip(&partners);
        all.filter_map(|(expected, partner)| Some((expected, &found.modes[(*partner)?])))
    };
    let frequency = pairs().any(|(expected, mode)| is_frequency_off(expected, mode, stated));
    let damping = pairs().find_map(|(expected, mode)| damping_failure(expected, mode, stated));
    let shape = pairs().any(|(expected, mode)| {
        let mac = shape_mac(expected, mode, &found.modes, responses);
        mac.is_none_or(|mac| mac < stated.mac)
    });
    let residue =
        pairs().find_map(|(expected, mode)| residue_failure(expected, mode, &found.modes, stated));
    frequency
        .then_some(FailureMode::Frequency)
        .or(damping)
        .or(shape.then_some(FailureMode::Shape))
        .or(residue)
}

fn width_hz(mode: &Mode) -> f64 {
    2.0 * mode.damping_ratio.unwrap_or(0.0) * mode.frequency_hz
}

/// Number of the found mode of every true one, the nearest pairs first.
fn partners(truth: &[Mode], found: &[Mode]) -> Vec<Option<usize>> {
    let distance = |r: usize, f: usize| (truth[r].frequency_hz - found[f].frequency_hz).abs();
    let mut near: Vec<(f64, usize, usize)> = Vec::new();
    for (r, expected) in truth.iter().enumerate() {
        let tolerance_hz = MATCH_BANDWIDTHS * width_hz(expected);
        let inside = (0..found.len()).filter(|f| distance(r, *f) <= tolerance_hz);
        near.extend(inside.map(|f| (distance(r, f), r, f)));
    }
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut partners = vec![None; truth.len()];
    let mut taken = vec![false; found.len()];
    for (_, r, f) in near {
        if partners[r].is_none() && !taken[f] {
            partners[r] = Some(f);
            taken[f] = true;
        }
    }
    partners
}

/// A missing mode near the found partner of a neighbour is merged with that neighbour.
fn missing(
    truth: &ModalModel,
    found: &ModalModel,
    partners: &[Option<usize>],
    missed: usize,
) -> FailureMode {
    let missed_mode = &truth.modes[missed];
    let covers = |r: usize, f: usize| {
        let (other, found) = (&truth.modes[r], &found.modes[f]);
        let apart = (missed_mode.frequency_hz - other.frequency_hz).abs();
        apart
            <= MERGE_BANDWIDTHS
                * width_hz(missed_mode)
                    .max(width_hz(other))
                    .max(width_hz(found))
    };
    let neighbours = partners.iter().enumerate();
    let merged = neighbours.filter_map(|(r, f)| Some((r, (*f)?)));
    match merged.into_iter().any(|(r, f)| covers(r, f)) {
        true => FailureMode::Merged,
        false => FailureMode::Missed,
    }
}

fn is_frequency_off(expected: &Mode, found: &Mode, stated: &StatedError) -> bool {
    let error = (found.frequency_hz - expected.frequency_hz).abs();
    let percent = stated.frequency_percent.unwrap_or(f64::INFINITY);
    error > stated.frequency_widths * width_hz(expected)
        || error > 0.01 * percent * expected.frequency_hz
}

fn damping_failure(expected: &Mode, found: &Mode, stated: &StatedError) -> Option<FailureMode> {
    let (truth, found) = (expected.damping_ratio?, found.damping_ratio.unwrap_or(0.0));
    let error = found / truth - 1.0;
    let limit = 0.01 * stated.damping_percent;
    match error {
        _ if error > limit => Some(FailureMode::DampingHigh),
        _ if error < -limit => Some(FailureMode::DampingLow),
        _ => None,
    }
}

/// The modes of the root of a found mode, that mode included.
fn group<'a>(found: &'a Mode, all: &'a [Mode]) -> Vec<&'a Mode> {
    match found.group {
        Some(_) => all
            .iter()
            .filter(|mode| mode.group == found.group)
            .collect(),
        None => vec![found],
    }
}

/// MAC with the found shape, or with the span of the shapes of its repeated root.
fn shape_mac(expected: &Mode, found: &Mode, all: &[Mode], responses: &[Dof]) -> Option<f64> {
    let at = |mode: &Mode| -> Option<Vec<Complex64>> {
        let values = responses.iter().map(|dof| mode.shape.along_positive(dof));
        values.collect()
    };
    let truth = at(expected)?;
    let span: Option<Vec<Vec<Complex64>>> = group(found, all).into_iter().map(at).collect();
    match span?.as_slice() {
        [one] => mac(&truth, one),
        several => subspace_mac(&truth, several),
    }
}

/// Compares the root of the sum of squares over the FRFs. Residues of a repeated root belong to all
/// its modes and are not compared.
fn residue_failure(
    expected: &Mode,
    found: &Mode,
    all: &[Mode],
    stated: &StatedError,
) -> Option<FailureMode> {
    let limit = 0.01 * stated.residue_percent?;
    if group(found, all).len() > 1 {
        return None;
    }
    let size = |mode: &Mode| {
        let squares = mode.residues.values().map(Complex64::norm_sqr);
        squares.sum::<f64>().sqrt()
    };
    match size(found) / size(expected) - 1.0 {
        error if error > limit => Some(FailureMode::ResidueLarge),
        error if error < -limit => Some(FailureMode::ResidueSmall),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::Case;
    use super::*;

    fn truth() -> ModalModel {
        Case::default().truth(0.0, 1.0).unwrap().model
    }

    fn failure_of(change: impl Fn(&mut Vec<Mode>)) -> Option<FailureMode> {
        let (truth, mut found) = (truth(), truth());
        change(&mut found.modes);
        let responses = Case::default().responses();
        first_failure(&truth, &found, &responses, &StatedError::default())
    }

    #[test]
    fn each_error_of_a_mode_has_its_failure_mode() {
        assert_eq!(failure_of(|_| ()), None);
        assert_eq!(failure_of(|m| drop(m.pop())), Some(FailureMode::Missed));
        assert_eq!(
            failure_of(|m| m.push(m[0].clone())),
            Some(FailureMode::Invented)
        );
        assert_eq!(
            failure_of(|m| m[1].frequency_hz += 0.3),
            Some(FailureMode::Frequency)
        );
        let damped = |factor: f64| failure_of(|m| m[0].damping_ratio = Some(0.01 * factor));
        assert_eq!(damped(1.09), None);
        assert_eq!(damped(1.2), Some(FailureMode::DampingHigh));
        assert_eq!(damped(0.8), Some(FailureMode::DampingLow));
        let swapped = failure_of(|m| m[0].shape = m[1].shape.clone());
        assert_eq!(swapped, Some(FailureMode::Shape));
        let sized =
            |factor: f64| failure_of(|m| m[2].residues.values_mut().for_each(|a| *a *= factor));
        assert_eq!(sized(0.85), None);
        assert_eq!(sized(0.7), Some(FailureMode::ResidueSmall));
        assert_eq!(sized(1.5), Some(FailureMode::ResidueLarge));
    }

    #[test]
    fn one_mode_in_place_of_a_close_pair_is_merged() {
        let close = Case::default().with(super::super::Factor::Separation, 0.6);
        let truth = close.truth(0.0, 1.0).unwrap().model;
        let mut found = truth.clone();
        found.modes.remove(1);
        let responses = close.responses();
        let merged = first_failure(&truth, &found, &responses, &StatedError::default());
        assert_eq!(merged, Some(FailureMode::Merged));
    }

    #[test]
    fn failure_modes_are_in_the_order_of_their_index() {
        for (index, failure) in FAILURE_MODES.iter().enumerate() {
            assert_eq!(failure.index(), index);
        }
    }
}
