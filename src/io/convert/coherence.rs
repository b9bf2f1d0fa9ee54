//! Coherence as files hold it: values outside 0 to 1 are ignored, for the FRF beside them does not
//! need it.

use crate::axis::FrequencyAxis;
use crate::finding::{Code, Finding, Location, Severity};

/// Excess over 1, or below 0, by which a coherence is rounded: single precision and printed digits.
/// Larger: 1.00001 of a wrong average counts as a coherence of 1, a noise-free line. Smaller: files
/// of single precision are full of findings (`rounded_coherence_is_no_finding`).
const ROUNDING: f64 = 1e-6;
/// Fraction of invalid lines above which no line is used. Larger: the few lines below 1 % of a
/// coherence in percent are taken for a noisy measurement. Smaller: a set whose lower lines alone
/// are invalid loses its variance (`coherence_in_percent_is_not_used`).
const MAX_INVALID_FRACTION: f64 = 0.5;

/// A coherence of which the invalid values are replaced.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::io) struct ValidCoherence {
    /// The coherence; `None` where most of it is invalid.
    pub values: Option<Vec<f64>>,
    /// The finding about ignored values, without a place.
    pub finding: Option<Finding>,
}

/// Replaces each invalid value by the mean of the nearest valid lines on both sides.
pub(in crate::io) fn valid_coherence(axis: &FrequencyAxis, values: Vec<f64>) -> ValidCoherence {
    let is_valid = |value: &f64| (-ROUNDING..=1.0 + ROUNDING).contains(value);
    let invalid: Vec<usize> = (0..values.len())
        .filter(|line| !is_valid(&values[*line]))
        .collect();
    let finding = (!invalid.is_empty()).then(|| ignored(axis, &values, &invalid));
    if invalid.len() as f64 > MAX_INVALID_FRACTION * values.len() as f64 {
        let values = None;
        return ValidCoherence { values, finding };
    }
    let nearest = |line: usize| {
        let before = values[..line].iter().rev().find(|value| is_valid(value));
        let behind = values[line..].iter().find(|value| is_valid(value));
        match (before, behind) {
            (Some(before), Some(behind)) => 0.5 * (before + behind),
            (Some(only), None) | (None, Some(only)) => *only,
            (None, None) => 0.0,
        }
    };
    let filled = |(line, value): (usize, &f64)| match is_valid(value) {
        true => value.clamp(0.0, 1.0),
        false => nearest(line).clamp(0.0, 1.0),
    };
    let values = Some(values.iter().enumerate().map(filled).collect());
    ValidCoherence { values, finding }
}

/// How many lines, which, and the largest value; no more than an info where 0 Hz alone is invalid.
fn ignored(axis: &FrequencyAxis, values: &[f64], invalid: &[usize]) -> Finding {
    let (first, last) = (invalid[0], invalid[invalid.len() - 1]);
    let severity = match axis.hz(last) > 0.0 {
        true => Severity::Warning,
        false => Severity::Info,
    };
    let largest = invalid.iter().map(|line| values[*line]);
    let largest = largest.filter(|value| value.is_finite());
    let finding = Finding::new(severity, Code::CoherenceInvalid, Location::Whole);
    let finding = match largest.max_by(f64::total_cmp) {
        Some(largest) => finding.value(largest, ""),
        None => finding,
    };
    let lines = match invalid.len() {
        1 => format!("1 of {} lines, at {} Hz", values.len(), axis.hz(first)),
        count => format!(
            "{count} of {} lines, from {} to {} Hz",
            values.len(),
            axis.hz(first),
            axis.hz(last)
        ),
    };
    finding.detail(lines)
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXIS: FrequencyAxis = FrequencyAxis {
        start_hz: 0.0,
        step_hz: 0.5,
        len: 5,
    };

    #[test]
    fn invalid_coherence_is_replaced_from_the_nearest_lines() {
        let found = valid_coherence(&AXIS, vec![1.246, 0.9, f64::NAN, 0.7, 0.8]);
        let expected = [0.9, 0.9, 0.8, 0.7, 0.8];
        let values = found.values.unwrap();
        let errors = values
            .iter()
            .zip(expected)
            .map(|(value, other)| value - other);
        assert!(
            errors.map(f64::abs).all(|error| error < 1e-15),
            "{values:?}"
        );
        let finding = found.finding.unwrap();
        assert_eq!(finding.severity, Severity::Warning);
        assert_eq!(finding.value, Some(1.246));
        let detail = finding.detail.unwrap();
        assert_eq!(detail, "2 of 5 lines, from 0 to 1 Hz");
    }

    #[test]
    fn invalid_coherence_at_0_hz_alone_is_an_info() {
        let found = valid_coherence(&AXIS, vec![1.246, 0.9, 0.9, 0.7, 0.8]);
        let finding = found.finding.unwrap();
        assert_eq!(finding.severity, Severity::Info);
        assert_eq!(finding.detail.unwrap(), "1 of 5 lines, at 0 Hz");
    }

    #[test]
    fn rounded_coherence_is_no_finding() {
        let found = valid_coherence(&AXIS, vec![1.000_000_1, -1e-7, 0.9, 0.7, 0.8]);
        assert_eq!(found.finding, None);
        assert_eq!(found.values.unwrap(), [1.0, 0.0, 0.9, 0.7, 0.8]);
    }

    #[test]
    fn coherence_in_percent_is_not_used() {
        let found = valid_coherence(&AXIS, vec![0.4, 99.0, 98.5, 97.0, 99.9]);
        assert_eq!(found.values, None);
        assert_eq!(found.finding.unwrap().value, Some(99.9));
        // Lines below the range of a sensor alone are replaced.
        let found = valid_coherence(&AXIS, vec![-1.0, -1.0, 0.9, 0.9, 0.9]);
        assert_eq!(found.values.unwrap(), [0.9; 5]);
    }
}
