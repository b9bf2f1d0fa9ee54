//! Poles that a writer states in another convention than that of the format are recognised from
//! all modes of a file: decay rates in place of real parts, damping in percent, modes without
//! frequency.
//!
//! A mode with a [`ModeNote`](super::mode_note::ModeNote) of its pole is as modalign wrote it.

use super::{RawMode, Root};
use crate::finding::Code;
use crate::io::formats::uff::fields::{FieldError, Position};

/// Minimum damping ratio that shows percent: such a mode, as a fraction, does not vibrate. With a
/// larger value a file of modes of 1 % stays at 100 %
/// (`damping_in_percent_is_divided_by_a_hundred`); with 0.5 the ratios of heavily damped modes are
/// divided by 100 (`damping_that_may_be_either_is_kept_and_reported`).
const MIN_RATIO_ABOVE_FRACTIONS: f64 = 1.0;
/// Damping ratio that is impossible as percent, too.
const MIN_RATIO_ABOVE_PERCENT: f64 = 100.0;
/// Minimum of all damping ratios of a file in percent: 0.05 % is less than that of a built
/// structure. With 0.01 the fractions beside one overdamped mode are divided by 100
/// (`damping_that_may_be_either_is_kept_and_reported`); with 0.5 a file of modes from 0.2 to 1.2 %
/// is not (`percent_of_a_lightly_damped_structure_is_recognised`).
const MIN_RATIO_IN_PERCENT: f64 = 0.05;
/// Damping ratio that modes of a structure exceed here and there, but not all of them. With 0.5
/// modes of 0.3 to 0.8 % pass for 30 to 80 % without a warning
/// (`damping_that_may_be_either_is_kept_and_reported`); with 0.05 modes on rubber mounts, of 10 and
/// 15 %, are reported (`plausible_and_unknown_damping_is_not_reported`).
const MAX_RATIO_OF_ALL_MODES: f64 = 0.2;

/// What was observed on modes, at the first of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::io::formats::uff) struct Observed {
    pub at: Position,
    pub code: Code,
    /// Number of modes, or the largest damping ratio.
    pub value: f64,
}

/// Removes the modes without a frequency, each as an error. Modes at 0 Hz are rigid-body modes
/// where another mode of the file has a frequency.
pub(in crate::io::formats::uff) fn remove_without_frequency(
    modes: &mut Vec<RawMode>,
) -> Vec<FieldError> {
    let is_stated = |mode: &RawMode| mode.root.frequency_hz() > 0.0 || mode.note().is_some();
    if modes.iter().any(is_stated) {
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
    let ratio = |mode: &RawMode| mode.root.damping_ratio().map(f64::abs);
    let normal = || modes.iter().filter(|mode| is_normal(mode));
    let ratios = || normal().filter_map(ratio);
    let smallest = ratios().fold(f64::INFINITY, f64::min);
    let largest = ratios().fold(0.0, f64::max);
    let at = normal().find(|mode| ratio(mode).is_some())?.at;
    let exceeds = largest >= MIN_RATIO_ABOVE_FRACTIONS;
    let is_percent =
        exceeds && largest < MIN_RATIO_ABOVE_PERCENT && smallest >= MIN_RATIO_IN_PERCENT;
    let code = match (is_percent, exceeds || smallest > MAX_RATIO_OF_ALL_MODES) {
        (true, _) => Code::DampingInPercent,
        (false, true) => Code::DampingImplausible,
        (false, false) => return None,
    };
    for mode in modes
        .iter_mut()
        .filter(|mode| is_percent && is_normal(mode))
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
    let value = largest;
    Some(Observed { at, code, value })
}
