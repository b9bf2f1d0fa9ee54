//! Damping ratios that a file states in percent, or below zero, are recognised from all modes of
//! it, whatever its format.

use crate::finding::{Code, Finding, Location, Severity};
use crate::modal::Mode;

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

/// Ratios that are, or may be, percent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LargeRatios {
    /// [`Code::DampingInPercent`] where they are, else [`Code::DampingImplausible`].
    pub code: Code,
    /// The largest of them.
    pub largest: f64,
}

impl LargeRatios {
    /// Whether the ratios are to be divided by 100.
    pub fn are_percent(self) -> bool {
        self.code == Code::DampingInPercent
    }
}

/// Whether the ratios of a file are percent, or may be.
pub(super) fn large_ratios(ratios: impl Iterator<Item = f64>) -> Option<LargeRatios> {
    let limits = |(smallest, largest): (f64, f64), ratio: f64| {
        (smallest.min(ratio.abs()), largest.max(ratio.abs()))
    };
    let (smallest, largest) = ratios.fold((f64::INFINITY, 0.0), limits);
    if smallest.is_infinite() {
        return None;
    }
    let exceeds = largest >= MIN_RATIO_ABOVE_FRACTIONS;
    let is_percent =
        exceeds && largest < MIN_RATIO_ABOVE_PERCENT && smallest >= MIN_RATIO_IN_PERCENT;
    let code = match (is_percent, exceeds || smallest > MAX_RATIO_OF_ALL_MODES) {
        (true, _) => Code::DampingInPercent,
        (false, true) => Code::DampingImplausible,
        (false, false) => return None,
    };
    Some(LargeRatios { code, largest })
}

/// A mode whose damping ratio is as its file states it.
pub(super) struct StatedMode<'a> {
    pub mode: &'a mut Mode,
    /// Line (from 1) of the mode, for text.
    pub line: Option<u64>,
}

/// Divides damping ratios in percent by 100, and reports them, those that may be percent and
/// negative ones.
pub(super) fn correct_damping_ratios(modes: &mut [StatedMode<'_>], path: &str) -> Vec<Finding> {
    let finding = |code, mode: &StatedMode<'_>, value, unit: &'static str| {
        let location = Location::File {
            path: path.to_owned(),
            line: mode.line,
            byte: None,
        };
        Finding::new(Severity::Warning, code, location).value(value, unit)
    };
    let mut findings = Vec::new();
    let is_negative = |mode: &&StatedMode<'_>| mode.mode.damping_ratio.is_some_and(|r| r < 0.0);
    if let Some(first) = modes.iter().find(is_negative) {
        let count = modes.iter().filter(is_negative).count();
        findings.push(finding(Code::NegativeDamping, first, count as f64, "modes"));
    }
    let Some(large) = large_ratios(modes.iter().filter_map(|mode| mode.mode.damping_ratio)) else {
        return findings;
    };
    let is_stated = |mode: &&StatedMode<'_>| mode.mode.damping_ratio.is_some();
    if let Some(first) = modes.iter().find(is_stated) {
        findings.push(finding(large.code, first, large.largest, ""));
    }
    if large.are_percent() {
        for StatedMode { mode, .. } in modes {
            for value in [
                &mut mode.damping_ratio,
                &mut mode.damping_std,
                &mut mode.damping_bias,
            ] {
                *value = value.map(|value| value / 100.0);
            }
        }
    }
    findings
}
