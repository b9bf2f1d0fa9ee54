//! Poles that a writer states in another convention than that of the format are recognised from
//! all modes of a file: decay rates in place of real parts, damping in percent, modes without
//! frequency.
//!
//! A mode with a [`ModeNote`](super::mode_note::ModeNote) of its pole is as modalign wrote it.

use std::collections::BTreeMap;

use super::rigid_shape::are_rigid;
use super::{RawMode, Root};
use crate::finding::Code;
use crate::io::formats::damping_ratios::large_ratios;
use crate::io::formats::uff::fields::{FieldError, Position};

/// What was observed on modes, at the first of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::io::formats::uff) struct Observed {
    pub at: Position,
    pub code: Code,
    /// Number of modes, or the largest damping ratio.
    pub value: f64,
}

/// Removes the modes without a frequency, each as an error. Modes at 0 Hz are rigid-body modes
/// where another mode of the file has a frequency, or where the positions of their nodes show it.
pub(in crate::io::formats::uff) fn remove_without_frequency(
    modes: &mut Vec<RawMode>,
    positions: &BTreeMap<i64, [f64; 3]>,
) -> Vec<FieldError> {
    let is_stated = |mode: &RawMode| mode.root.frequency_hz() > 0.0 || mode.note().is_some();
    if modes.iter().any(is_stated) || are_rigid(modes, positions) {
        return Vec::new();
    }
    let error = |mode: RawMode| FieldError {
        at: mode.at,
        what: "frequency of a mode",
        got: "0 Hz and an eigenvalue of 0, as in every mode of the file".to_owned(),
        expected: "a frequency or an eigenvalue; export the modes with their frequencies"
            .to_owned(),
    };
    std::mem::take(modes).into_iter().map(error).collect()
}

/// Turns the poles of other conventions into those of the format.
pub(in crate::io::formats::uff) fn correct(modes: &mut [RawMode]) -> Vec<Observed> {
    let mut observed = correct_real_parts(modes);
    observed.extend(correct_percent(modes));
    observed
}

/// Reverses real parts that are decay rates, and reports modes with negative damping.
fn correct_real_parts(modes: &mut [RawMode]) -> Vec<Observed> {
    let real_part = |mode: &RawMode| match mode.root {
        Root::Complex { lambda, .. } => lambda.re,
        Root::Normal { .. } => 0.0,
    };
    let are_all_positive = modes.iter().all(|mode| real_part(mode) >= 0.0);
    let (mut reversed, mut unstable) = (Vec::new(), Vec::new());
    let has_negative_damping = |mode: &RawMode| {
        let ratio = mode.root.damping_ratio();
        mode.note().is_none() && ratio.is_some_and(|ratio| ratio < 0.0)
    };
    for mode in modes.iter_mut().filter(|mode| has_negative_damping(mode)) {
        let field = mode.damping_field;
        match &mut mode.root {
            Root::Complex { lambda, .. } if field > 0.0 || (are_all_positive && field == 0.0) => {
                lambda.re = -lambda.re;
                reversed.push(mode.at);
            }
            _ => unstable.push(mode.at),
        }
    }
    let observed = [
        (Code::DecayRateSign, reversed),
        (Code::NegativeDamping, unstable),
    ];
    let observed = observed.into_iter().filter_map(|(code, modes)| {
        let at = *modes.first()?;
        let value = modes.len() as f64;
        Some(Observed { at, code, value })
    });
    observed.collect()
}

/// Divides damping ratios in percent by 100, and reports those that may be percent.
fn correct_percent(modes: &mut [RawMode]) -> Option<Observed> {
    let is_normal =
        |mode: &RawMode| matches!(mode.root, Root::Normal { .. }) && mode.note().is_none();
    let ratio = |mode: &RawMode| mode.root.damping_ratio();
    let normal = || modes.iter().filter(|mode| is_normal(mode));
    let at = normal().find(|mode| ratio(mode).is_some())?.at;
    let large = large_ratios(normal().filter_map(ratio))?;
    for mode in modes
        .iter_mut()
        .filter(|mode| large.are_percent() && is_normal(mode))
    {
        if let Root::Normal {
            viscous,
            hysteretic,
            ..
        } = &mut mode.root
        {
            *viscous /= 100.0;
            *hysteretic /= 100.0;
        }
    }
    Some(Observed {
        at,
        code: large.code,
        value: large.largest,
    })
}
