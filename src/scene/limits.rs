//! A result is checked against stated limits.

use serde::{Deserialize, Serialize};

use crate::correlate::TestSummary;

/// Absolute limits; `None` is not checked.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Limits {
    /// Largest |frequency error| of a paired mode, percent.
    pub max_frequency_error_percent: Option<f64>,
    /// Smallest MAC of a paired mode.
    pub min_mac: Option<f64>,
    /// Smallest number of paired modes, per test; ambiguous ones count, but not those whose MAC is
    /// below the chance level.
    pub min_paired: Option<usize>,
    /// Largest number of theory modes in the band without partner, per test, with those of unknown
    /// observability.
    pub max_missed: Option<usize>,
    /// Largest number of theory modes in the band that the test could not have detected, per test.
    pub max_not_observable: Option<usize>,
    /// Largest number of test modes without partner, per test.
    pub max_extra: Option<usize>,
    /// Largest number of ambiguous pairings, per test.
    pub max_ambiguous: Option<usize>,
    /// Modes that must be there, for `modes.json`.
    pub mode: Vec<ModeLimit>,
}

/// A mode that a test must find.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModeLimit {
    /// Its frequency, Hz.
    pub frequency_hz: f64,
    /// Largest |frequency error|, percent.
    pub max_frequency_error_percent: f64,
    /// Its damping ratio.
    pub damping_ratio: Option<f64>,
    /// Largest |damping error|, percent of `damping_ratio`.
    pub max_damping_error_percent: Option<f64>,
}

/// One limit with the value that it is checked against.
#[derive(Clone, Debug, PartialEq)]
pub struct LimitCheck {
    /// The checked quantity, with the test or the row.
    pub what: String,
    /// The value; `None` when the result does not have it, so that the limit is missed.
    pub value: Option<f64>,
    /// The limit.
    pub limit: f64,
    /// Whether the value may not exceed the limit (else it may not fall below).
    pub upper: bool,
}

impl LimitCheck {
    /// Whether the limit is met.
    pub fn is_met(&self) -> bool {
        self.value.is_some_and(|value| {
            if self.upper {
                value <= self.limit
            } else {
                value >= self.limit
            }
        })
    }
}

/// A file with `[limits]`, such as a scene, whose other tables are ignored.
#[derive(Clone, Debug, Deserialize)]
pub struct LimitsFile {
    /// The limits.
    pub limits: Limits,
}

/// Checks every stated absolute limit on a comparison for every test.
pub fn check_comparison(limits: &Limits, tests: &[TestSummary]) -> Vec<LimitCheck> {
    let mut checks = Vec::new();
    for test in tests {
        let count = |n: usize| Some(n as f64);
        let missed = match test.not_judged {
            0 => "missed modes".to_owned(),
            n => format!("missed modes ({n} of them not judged)"),
        };
        let paired = paired_label(test);
        let rows = [
            (
                "largest |frequency error| (%)",
                test.max_error_percent,
                limits.max_frequency_error_percent,
                true,
            ),
            ("smallest MAC", test.min_mac, limits.min_mac, false),
            (
                paired.as_str(),
                count(test.paired + supported_pairs(test)),
                limits.min_paired.map(|n| n as f64),
                false,
            ),
            (
                missed.as_str(),
                count(test.missed),
                limits.max_missed.map(|n| n as f64),
                true,
            ),
            (
                "not observable modes",
                count(test.not_observable),
                limits.max_not_observable.map(|n| n as f64),
                true,
            ),
            (
                "extra modes",
                count(test.extra),
                limits.max_extra.map(|n| n as f64),
                true,
            ),
            (
                "ambiguous pairs",
                count(test.ambiguous),
                limits.max_ambiguous.map(|n| n as f64),
                true,
            ),
        ];
        for (what, value, limit, upper) in rows {
            checks.extend(limit.map(|limit| LimitCheck {
                what: format!("{}: {what}", test.test),
                value,
                limit,
                upper,
            }));
        }
    }
    checks
}

/// Ambiguous pairs whose MAC reaches the chance level.
fn supported_pairs(test: &TestSummary) -> usize {
    test.ambiguous.saturating_sub(test.uncorrelated)
}

/// The pairs that count for `min_paired`, by their evidence where it is not the shape of all:
/// ambiguous ones count, but not those whose MAC is below the chance level.
fn paired_label(test: &TestSummary) -> String {
    let parts = [
        (test.paired_by_frequency, "by frequency alone"),
        (supported_pairs(test), "ambiguous"),
    ];
    let parts = parts.iter().filter(|(count, _)| *count > 0);
    let parts: Vec<String> = parts.map(|(n, what)| format!("{n} {what}")).collect();
    if parts.is_empty() {
        "paired modes".to_owned()
    } else {
        format!("paired modes ({} of them)", parts.join(", "))
    }
}

/// Checks every stated mode against the nearest identified mode in frequency, each used once.
pub fn check_modes(limits: &Limits, found: &[(f64, Option<f64>)]) -> Vec<LimitCheck> {
    let mut free: Vec<&(f64, Option<f64>)> = found.iter().collect();
    let mut checks = Vec::new();
    for mode in &limits.mode {
        let distance = |hz: f64| (hz - mode.frequency_hz).abs();
        let nearest =
            (0..free.len()).min_by(|a, b| distance(free[*a].0).total_cmp(&distance(free[*b].0)));
        let within = |index: &usize| {
            percent(free[*index].0, mode.frequency_hz) <= mode.max_frequency_error_percent
        };
        let matched = nearest.filter(within).map(|index| free.remove(index));
        let name = format!("mode at {} Hz", mode.frequency_hz);
        let value = matched.map(|found| percent(found.0, mode.frequency_hz));
        let frequency = format!("{name}: |frequency error| (%)");
        checks.push(LimitCheck {
            what: frequency,
            value,
            limit: mode.max_frequency_error_percent,
            upper: true,
        });
        if let (Some(zeta), Some(limit)) = (mode.damping_ratio, mode.max_damping_error_percent) {
            let value = matched
                .and_then(|found| found.1)
                .map(|found| percent(found, zeta));
            checks.push(LimitCheck {
                what: format!("{name}: |damping error| (%)"),
                value,
                limit,
                upper: true,
            });
        }
    }
    let extra = limits.max_extra.filter(|_| !limits.mode.is_empty());
    let extra_count = free.len() as f64;
    checks.extend(extra.map(|limit| LimitCheck {
        what: "extra modes".to_owned(),
        value: Some(extra_count),
        limit: limit as f64,
        upper: true,
    }));
    checks
}

/// |difference| of a value to a reference, percent of the reference; 0 for equal values.
pub fn percent(value: f64, reference: f64) -> f64 {
    let difference = (value - reference).abs();
    if difference == 0.0 {
        0.0
    } else {
        100.0 * difference / reference.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures() -> TestSummary {
        TestSummary {
            test: "hammer".to_owned(),
            paired: 4,
            missed: 1,
            not_observable: 0,
            outside_band: 0,
            extra: 0,
            ambiguous: 0,
            max_error_percent: Some(2.0),
            mean_error_percent: Some(1.0),
            rms_error_percent: Some(1.5),
            min_mac: Some(0.96),
            dofs_used: 11,
            ..TestSummary::default()
        }
    }

    #[test]
    fn each_stated_limit_is_met_at_its_value_and_missed_beyond() {
        let limits = |percent, mac, missed| Limits {
            max_frequency_error_percent: Some(percent),
            min_mac: Some(mac),
            max_missed: Some(missed),
            ..Limits::default()
        };
        let met = |limits: &Limits| {
            check_comparison(limits, &[figures()])
                .iter()
                .map(LimitCheck::is_met)
                .collect::<Vec<_>>()
        };
        assert_eq!(met(&limits(2.0, 0.96, 1)), [true, true, true]);
        assert_eq!(met(&limits(1.999, 0.961, 0)), [false, false, false]);
        assert!(met(&Limits::default()).is_empty());
    }

    #[test]
    fn ambiguous_pairs_count_as_paired_unless_their_mac_is_below_the_chance_level() {
        let limits = Limits {
            min_paired: Some(6),
            ..Limits::default()
        };
        let check = |ambiguous, uncorrelated| {
            let test = TestSummary {
                ambiguous,
                uncorrelated,
                ..figures()
            };
            check_comparison(&limits, &[test])[0].clone()
        };
        assert_eq!((check(2, 0).value, check(2, 0).is_met()), (Some(6.0), true));
        assert_eq!(
            (check(2, 1).value, check(2, 1).is_met()),
            (Some(5.0), false)
        );
        assert_eq!(
            check(2, 1).what,
            "hammer: paired modes (1 ambiguous of them)"
        );
        assert_eq!(check(2, 2).value, Some(4.0));
    }

    #[test]
    fn missed_modes_of_unknown_observability_are_counted_in_the_limit() {
        let limits = Limits {
            max_missed: Some(1),
            ..Limits::default()
        };
        let label = |not_judged| {
            let test = TestSummary {
                not_judged,
                ..figures()
            };
            check_comparison(&limits, &[test])[0].what.clone()
        };
        assert_eq!(label(0), "hammer: missed modes");
        assert_eq!(label(1), "hammer: missed modes (1 of them not judged)");
    }

    #[test]
    fn a_missing_value_fails_its_limit() {
        let none = TestSummary {
            max_error_percent: None,
            ..figures()
        };
        let limits = Limits {
            max_frequency_error_percent: Some(100.0),
            ..Limits::default()
        };
        assert!(!check_comparison(&limits, &[none])[0].is_met());
    }

    #[test]
    fn a_stated_mode_is_found_within_its_tolerance_or_missed() {
        let mode = |hz, tolerance| ModeLimit {
            frequency_hz: hz,
            max_frequency_error_percent: tolerance,
            damping_ratio: Some(0.01),
            max_damping_error_percent: Some(10.0),
        };
        let limits = Limits {
            mode: vec![mode(100.0, 0.5), mode(200.0, 0.5)],
            max_extra: Some(0),
            ..Limits::default()
        };
        let met = |found: &[(f64, Option<f64>)]| {
            check_modes(&limits, found)
                .iter()
                .map(LimitCheck::is_met)
                .collect::<Vec<_>>()
        };
        assert_eq!(
            met(&[(100.4, Some(0.0105)), (199.2, Some(0.0085))]),
            [true, true, true, false, true]
        );
        assert_eq!(
            met(&[(100.6, Some(0.01)), (200.0, None), (300.0, None)]),
            [false, false, true, false, false]
        );
    }
}
