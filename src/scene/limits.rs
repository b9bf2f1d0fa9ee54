//! A result is checked against stated limits.

use serde::{Deserialize, Serialize};
use toml::de::DeTable;

use crate::correlate::TestSummary;

use super::error::{SceneError, value_error};
use super::faults::Faults;
use super::toml_text::parse;

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

/// A result that decides limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitedResult {
    /// A comparison of tests with a model.
    Comparison,
    /// The modes of tests, which decide `[[limits.mode]]`, with `max_extra`.
    Modes,
}

/// Whether and by which results the limits are decided.
#[derive(Clone, Copy, Debug)]
pub struct LimitsUse<'a> {
    /// The results at hand.
    pub decided_by: &'a [LimitedResult],
    /// They in words, such as `a scene without [model]`.
    pub result: &'a str,
    /// The accepted limits, or what to do about the others.
    pub expected: &'a str,
}

impl Limits {
    /// Checks that a result can miss each limit by its value, and that a result decides it.
    ///
    /// # Errors
    /// [`SceneError::Value`] with the keys of the limits.
    pub fn check(&self, used: LimitsUse<'_>, path: &str) -> Result<(), SceneError> {
        let table = |key: &str| format!("[limits] {key}");
        let mut faults = Faults::default();
        let percent = "max_frequency_error_percent";
        let stated = self.max_frequency_error_percent;
        faults.take(check_percent(stated, path, &table(percent)));
        let is_mac = |mac: f64| (0.0..=1.0).contains(&mac);
        faults.take(check_value(
            self.min_mac,
            is_mac,
            path,
            &table("min_mac"),
            "a MAC from 0 to 1",
        ));
        for (number, mode) in (1..).zip(&self.mode) {
            faults.take(mode.check(path, &format!("[[limits.mode]] {number}")));
        }
        let undecided = self.undecided(used.decided_by);
        if !undecided.is_empty() {
            let got = format!("limits that {} does not decide", used.result);
            let keys = undecided.join(", ");
            faults.add(value_error(path, &keys, &got, used.expected));
        }
        faults.into_result()
    }

    /// Keys of the stated limits that no result of these kinds decides.
    fn undecided(&self, by: &[LimitedResult]) -> Vec<&'static str> {
        let compared = by.contains(&LimitedResult::Comparison);
        let modes = by.contains(&LimitedResult::Modes);
        let has_mode = !self.mode.is_empty();
        let limits = [
            (
                "[limits] max_frequency_error_percent",
                self.max_frequency_error_percent.is_some(),
                compared,
            ),
            ("[limits] min_mac", self.min_mac.is_some(), compared),
            ("[limits] min_paired", self.min_paired.is_some(), compared),
            ("[limits] max_missed", self.max_missed.is_some(), compared),
            (
                "[limits] max_not_observable",
                self.max_not_observable.is_some(),
                compared,
            ),
            (
                "[limits] max_extra",
                self.max_extra.is_some(),
                compared || (modes && has_mode),
            ),
            (
                "[limits] max_ambiguous",
                self.max_ambiguous.is_some(),
                compared,
            ),
            ("[[limits.mode]]", has_mode, modes),
        ];
        let undecided = limits
            .iter()
            .filter(|(_, stated, decided)| *stated && !decided);
        undecided.map(|(key, ..)| *key).collect()
    }
}

impl ModeLimit {
    fn check(&self, path: &str, table: &str) -> Result<(), SceneError> {
        let key = |name: &str| format!("{table} {name}");
        let is_positive = |value: f64| value.is_finite() && value > 0.0;
        let (hz, ratio) = ("a finite frequency above 0 Hz", "a finite ratio above 0");
        let mut faults = Faults::default();
        let mut check = |value, name: &str, expected| {
            faults.take(check_value(value, is_positive, path, &key(name), expected));
        };
        check(Some(self.frequency_hz), "frequency_hz", hz);
        check(self.damping_ratio, "damping_ratio", ratio);
        let percent = key("max_frequency_error_percent");
        let stated = Some(self.max_frequency_error_percent);
        faults.take(check_percent(stated, path, &percent));
        let percent = key("max_damping_error_percent");
        faults.take(check_percent(
            self.max_damping_error_percent,
            path,
            &percent,
        ));
        let got = match (self.damping_ratio, self.max_damping_error_percent) {
            (Some(_), None) => Some("`damping_ratio` without `max_damping_error_percent`"),
            (None, Some(_)) => Some("`max_damping_error_percent` without `damping_ratio`"),
            _ => None,
        };
        if let Some(got) = got {
            faults.add(value_error(path, table, got, "both, or none"));
        }
        faults.into_result()
    }
}

fn check_percent(value: Option<f64>, path: &str, key: &str) -> Result<(), SceneError> {
    let is_percent = |value: f64| value.is_finite() && value >= 0.0;
    check_value(
        value,
        is_percent,
        path,
        key,
        "a finite percentage, 0 or more",
    )
}

/// Checks the value of a limit that is stated.
fn check_value(
    value: Option<f64>,
    is_valid: impl Fn(f64) -> bool,
    path: &str,
    key: &str,
    expected: &str,
) -> Result<(), SceneError> {
    match value.filter(|value| !is_valid(*value)) {
        None => Ok(()),
        Some(value) => Err(value_error(path, key, &value.to_string(), expected)),
    }
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
#[derive(Deserialize)]
struct LimitsFile {
    limits: Option<Limits>,
}

/// The error of a file without a table of limits.
fn no_limits(text: &str, path: &str) -> SceneError {
    let is_remark = |line: &str| {
        let remark = line.trim_start().strip_prefix('#');
        remark.is_some_and(|remark| remark.trim().starts_with("[limits"))
    };
    let got = match text.lines().any(is_remark) {
        true => "a table that is commented out",
        false => "no such table",
    };
    let expected = "the line `[limits]` and a line for each limit, such as `min_mac = 0.9` or \
                    `max_frequency_error_percent = 5.0`";
    value_error(path, "[limits]", got, expected)
}

/// The limits of a file with `[limits]`, such as a scene, for these results.
///
/// # Errors
/// [`SceneError`] with the place in the file, or as [`Limits::check`].
pub fn limits_from_toml(text: &str, path: &str, used: LimitsUse<'_>) -> Result<Limits, SceneError> {
    let limits = parse::<LimitsFile>(text, path)?.limits;
    // A limit above the head of its table is a key of the document.
    let keys = DeTable::parse(text).map(|table| table.into_inner());
    for key in keys.iter().flat_map(|table| table.keys()) {
        let key = key.get_ref();
        let is_limit = key == "mode" || key.starts_with("min_") || key.starts_with("max_");
        if is_limit {
            let got = "a limit outside of the table [limits]";
            return Err(value_error(path, key, got, "it below the line [limits]"));
        }
    }
    let limits = limits.ok_or_else(|| no_limits(text, path))?;
    let mut faults = Faults::default();
    faults.take(limits.check(used, path));
    faults.located(path, text).into_result().map(|()| limits)
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

    const COMPARED: LimitsUse<'_> = LimitsUse {
        decided_by: &[LimitedResult::Comparison],
        result: "a comparison.json",
        expected: "limits on a comparison",
    };
    const MODES: LimitsUse<'_> = LimitsUse {
        decided_by: &[LimitedResult::Modes],
        result: "a modes.json",
        expected: "[[limits.mode]]",
    };

    /// Asserts that a text of limits is refused with the key, the value got and the file.
    fn assert_refused(text: &str, used: LimitsUse<'_>, parts: &[&str]) {
        let error = limits_from_toml(text, "l.toml", used).unwrap_err();
        let error = error.to_string();
        let named = parts.iter().all(|part| error.contains(part));
        assert!(named && error.starts_with("l.toml:"), "{text}: {error}");
    }

    #[test]
    fn limits_that_no_result_misses_are_refused() {
        for (limit, key) in [
            (
                "max_frequency_error_percent = inf",
                "max_frequency_error_percent",
            ),
            (
                "max_frequency_error_percent = nan",
                "max_frequency_error_percent",
            ),
            (
                "max_frequency_error_percent = -1",
                "max_frequency_error_percent",
            ),
            ("min_mac = -0.5", "min_mac"),
            ("min_mac = nan", "min_mac"),
            ("min_mac = 1.01", "min_mac"),
        ] {
            let value = limit.rsplit(' ').next().unwrap();
            let got = format!("got {}", value.replace("nan", "NaN"));
            let text = format!("[limits]\n{limit}\n");
            assert_refused(&text, COMPARED, &[key, &got]);
        }
        let text = "[limits]\nmin_mac = 1\nmax_frequency_error_percent = 0\n";
        assert!(limits_from_toml(text, "l.toml", COMPARED).is_ok());
    }

    #[test]
    fn limits_of_a_mode_are_finite_and_those_of_damping_complete() {
        let mode = |keys: &str| format!("[[limits.mode]]\nfrequency_hz = 100\n{keys}\n");
        let percent = "max_frequency_error_percent = 1\n";
        for (keys, key) in [
            (
                "max_frequency_error_percent = inf",
                "max_frequency_error_percent",
            ),
            (
                "max_frequency_error_percent = -1",
                "max_frequency_error_percent",
            ),
            (
                &format!("{percent}damping_ratio = 0.01"),
                "without `max_damping",
            ),
            (
                &format!("{percent}max_damping_error_percent = 5"),
                "without `damping_ratio`",
            ),
            (
                &format!("{percent}damping_ratio = 0\nmax_damping_error_percent = 5"),
                "damping_ratio",
            ),
            (
                &format!("{percent}damping_ratio = 0.01\nmax_damping_error_percent = inf"),
                "max_damping_error_percent",
            ),
        ] {
            assert_refused(&mode(keys), MODES, &["[[limits.mode]] 1", key]);
        }
        let nan = mode(percent).replace("100", "nan");
        assert_refused(&nan, MODES, &["[[limits.mode]] 1 frequency_hz", "got NaN"]);
        let whole = format!("{percent}damping_ratio = 0.01\nmax_damping_error_percent = 5");
        assert!(limits_from_toml(&mode(&whole), "l.toml", MODES).is_ok());
    }

    #[test]
    fn limits_that_a_result_does_not_decide_are_named() {
        let mode = "[[limits.mode]]\nfrequency_hz = 100\nmax_frequency_error_percent = 1\n";
        let both = format!("[limits]\nmin_mac = 0.9\nmax_extra = 0\n{mode}");
        assert_refused(&both, COMPARED, &["[[limits.mode]]", "a comparison.json"]);
        assert_refused(&both, MODES, &["[limits] min_mac", "a modes.json"]);
        assert_refused("[limits]\nmax_extra = 0\n", MODES, &["[limits] max_extra"]);
        let neither = LimitsUse {
            decided_by: &[],
            ..MODES
        };
        let names = ["[limits] min_mac", "[limits] max_extra", "[[limits.mode]]"];
        assert_refused(&both, neither, &names);
        let extra = format!("[limits]\nmax_extra = 0\n{mode}");
        assert!(limits_from_toml(&extra, "l.toml", MODES).is_ok());
        let outside = "min_mac = 0.9\n[limits]\nmax_missed = 0\n";
        assert_refused(outside, COMPARED, &["min_mac", "outside of the table"]);
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
