//! `modalign check` of an `update.json`: its parameters, and how well the updated model fits.

use serde::Deserialize;

use crate::scene::{
    AllowedChange, Change, MAX_FREQUENCY_CHANGE_PERCENT, MAX_MAC_CHANGE, Measure, UncertainValue,
    relative_change, std_change,
};

/// Allowed change of a parameter: by its posterior standard deviations; none for a value of 0.
const PARAMETER_CHANGE: AllowedChange = AllowedChange {
    percent: None,
    unstated_percent: 0.0,
    floor: 0.0,
};

/// Maximum change of the degrees of freedom, residuals less the identified combinations of
/// parameters. Larger: the loss of a residual passes. Smaller: another recording fails, whose
/// combinations are identified a little better or worse.
const MAX_DEGREES_OF_FREEDOM_CHANGE: f64 = 0.5;

/// Keys whose values are compared with the baseline.
pub(super) const COMPARED_KEYS: &[&str] = &[
    "parameters.unit",
    "parameters.status",
    "parameters.initial",
    "parameters.updated",
    "parameters.std",
    "parameters.prior_std",
    "parameters.lower",
    "parameters.upper",
    "parameters.held",
    "residuals",
    "after.paired",
    "after.chi_square",
    "after.rms_percent",
    "after.largest_percent",
    "after.rows",
    "assumed",
    "degrees_of_freedom",
    "reduced_chi_square",
];

/// The compared parts of an `update.json`.
#[derive(Deserialize)]
pub(super) struct UpdateResult {
    parameters: Vec<UpdatedParameter>,
    #[serde(default = "of_modes")]
    residuals: String,
    stop_reason: String,
    after: UpdatedFit,
    degrees_of_freedom: f64,
    reduced_chi_square: f64,
    fits: bool,
    #[serde(default)]
    assumed: Assumed,
}

/// The residuals of files that do not state them.
fn of_modes() -> String {
    "modes".to_owned()
}

#[derive(Deserialize)]
struct UpdatedParameter {
    name: String,
    updated: f64,
    std: f64,
    verdict: String,
    /// What the scene and its model state.
    #[serde(flatten)]
    stated: StatedParameter,
}

#[derive(Deserialize, PartialEq)]
struct StatedParameter {
    unit: String,
    status: String,
    initial: f64,
    prior_std: Option<f64>,
    lower: Option<f64>,
    upper: Option<f64>,
    held: Option<bool>,
}

#[derive(Deserialize)]
struct UpdatedFit {
    paired: usize,
    chi_square: f64,
    rms_percent: Option<f64>,
    largest_percent: Option<f64>,
    #[serde(default)]
    rows: Vec<UpdatedRow>,
}

#[derive(Deserialize)]
struct UpdatedRow {
    label: String,
    test_hz: f64,
    test_std_hz: f64,
    model_hz: Option<f64>,
    model_std_hz: Option<f64>,
    error_percent: Option<f64>,
    mac: Option<f64>,
}

impl UpdatedRow {
    fn test(&self) -> UncertainValue {
        UncertainValue {
            value: self.test_hz,
            std: Some(self.test_std_hz),
        }
    }

    fn model(&self) -> Option<UncertainValue> {
        let std = self.model_std_hz;
        self.model_hz.map(|value| UncertainValue { value, std })
    }
}

/// Relative difference of two numbers that are equal but for rounding.
const ROUNDING: f64 = 1e-6;

fn are_equal(one: f64, other: f64) -> bool {
    (one - other).abs() <= ROUNDING * one.abs().max(other.abs())
}

impl UpdatedFit {
    /// Says which value contradicts the others.
    fn check(&self) -> Result<(), String> {
        let contradiction = |key: String, got: Option<f64>, expected: f64| {
            let got = got.map_or("none".to_owned(), |got| got.to_string());
            Err(format!(
                "after {key}: got {got}, expected {expected}, by the frequencies"
            ))
        };
        let mut errors = Vec::new();
        for row in self.rows.iter() {
            let Some(model_hz) = row.model_hz else {
                continue;
            };
            let difference = 100.0 * (row.test_hz - model_hz);
            // Over the model's frequency, or over the test's with the opposite sign.
            let [error, of_test] = [difference / model_hz, -difference / row.test_hz];
            let rounding = 100.0 * ROUNDING;
            let is = |stated: f64| {
                [error, of_test]
                    .iter()
                    .any(|error| (stated - error).abs() <= rounding)
            };
            match row.error_percent {
                Some(stated) if is(stated) => errors.push(stated),
                stated => {
                    let key = format!("rows {:?} error_percent", row.label);
                    return contradiction(key, stated, error);
                }
            }
        }
        if errors.is_empty() {
            return Ok(());
        }
        let squares: f64 = errors.iter().map(|error| error * error).sum();
        let rms = (squares / errors.len() as f64).sqrt();
        let largest = errors.iter().map(|error| error.abs()).fold(0.0, f64::max);
        for (key, stated, computed) in [
            ("rms_percent", self.rms_percent, rms),
            ("largest_percent", self.largest_percent, largest),
        ] {
            if !stated.is_some_and(|stated| are_equal(stated, computed)) {
                return contradiction(key.to_owned(), stated, computed);
            }
        }
        Ok(())
    }
}

/// What an update assumes beside the tests.
#[derive(Deserialize, PartialEq, Default)]
#[serde(default)]
struct Assumed {
    frequency_floor: Option<f64>,
    shape_floor: Option<f64>,
    shape_std: Option<f64>,
    frf_floor: Option<f64>,
    prior_std: Option<f64>,
}

impl UpdatedParameter {
    fn uncertain_value(&self) -> UncertainValue {
        UncertainValue {
            value: self.updated,
            std: Some(self.std),
        }
    }
}

impl UpdateResult {
    /// Says which value cannot be meant, with the accepted ones.
    pub(super) fn check(&self) -> Result<(), String> {
        let above_zero = |key: &str, value: f64| match value > 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(format!("{key}: got {value}, expected a number above 0")),
        };
        for (index, parameter) in self.parameters.iter().enumerate() {
            let UpdatedParameter { name, std, .. } = parameter;
            above_zero(&format!("parameters {name:?} std"), *std)?;
            let StatedParameter { lower, upper, .. } = parameter.stated;
            let (lower, upper) = (lower.unwrap_or(f64::MIN), upper.unwrap_or(f64::MAX));
            if !(lower..=upper).contains(&parameter.updated) {
                return Err(format!(
                    "parameters {name:?} updated: got {}, expected {lower} to {upper}",
                    parameter.updated
                ));
            }
            if self.parameters[..index]
                .iter()
                .any(|other| other.name == *name)
            {
                return Err(format!(
                    "parameters: got {name:?} twice, expected each one once"
                ));
            }
        }
        above_zero("degrees_of_freedom", self.degrees_of_freedom)?;
        let reduced = self.after.chi_square / self.degrees_of_freedom;
        if !(reduced >= 0.0 && are_equal(self.reduced_chi_square, reduced)) {
            return Err(format!(
                "reduced_chi_square: got {}, expected {reduced}, chi_square over degrees_of_freedom",
                self.reduced_chi_square
            ));
        }
        self.after.check()
    }
}

/// Changes of every parameter of the baseline, and of the fit.
pub(super) fn update_changes(now: &UpdateResult, before: &UpdateResult) -> Vec<Change> {
    let mut changes = parameter_changes(&now.parameters, &before.parameters);
    changes.extend(fit_changes(now, before));
    changes.extend(row_changes(&now.after.rows, &before.after.rows));
    changes
}

/// Allowed change of a frequency of the test or of the updated model.
const FREQUENCY_CHANGE: AllowedChange = AllowedChange {
    percent: None,
    unstated_percent: MAX_FREQUENCY_CHANGE_PERCENT,
    floor: 1e-4,
};

/// Frequencies and MAC of each compared mode.
fn row_changes(now: &[UpdatedRow], before: &[UpdatedRow]) -> Vec<Change> {
    let mut changes = Vec::new();
    for old in before {
        let mut push = |what: &str, measure| {
            changes.push(Change {
                row: format!("mode {}", old.label),
                what: what.to_owned(),
                measure,
            });
        };
        let new = now.iter().find(|row| row.label == old.label);
        let test = relative_change(new.map(UpdatedRow::test), old.test(), FREQUENCY_CHANGE);
        push("frequency change of the test (%)", test);
        if let Some(model) = old.model() {
            let new = new.and_then(UpdatedRow::model);
            let measure = relative_change(new, model, FREQUENCY_CHANGE);
            push("frequency change of the model (%)", measure);
        }
        if let Some(mac) = old.mac {
            let change = new.and_then(|row| row.mac).map(|new| (new - mac).abs());
            push("MAC change", Measure::AtMost(change, MAX_MAC_CHANGE));
        }
    }
    changes
}

/// Every parameter of the baseline: its value by both posterior deviations, the deviation itself,
/// and its verdict.
fn parameter_changes(now: &[UpdatedParameter], before: &[UpdatedParameter]) -> Vec<Change> {
    let has =
        |all: &[UpdatedParameter], name: &str| all.iter().any(|parameter| parameter.name == name);
    let change = |name: &str, what: &str, measure| Change {
        row: format!("parameter {name}"),
        what: what.to_owned(),
        measure,
    };
    let mut changes = Vec::new();
    for old in before {
        let new = now.iter().find(|parameter| parameter.name == old.name);
        let changed = new.map(|new| f64::from(u8::from(new.verdict != old.verdict)));
        let verdict = Measure::AtMost(changed, 0.0);
        changes.push(change(&old.name, "verdict changed", verdict));
        let changed = new.map(|new| f64::from(u8::from(new.stated != old.stated)));
        let stated = Measure::AtMost(changed, 0.0);
        changes.push(change(
            &old.name,
            "unit, initial value, prior or bounds changed",
            stated,
        ));
        let (new, old_value) = (
            new.map(UpdatedParameter::uncertain_value),
            old.uncertain_value(),
        );
        let value = relative_change(new, old_value, PARAMETER_CHANGE);
        changes.push(change(&old.name, "value change (%)", value));
        let std = std_change(new, old_value, PARAMETER_CHANGE.floor);
        changes.extend(std.map(|std| change(&old.name, "std change (factor)", std)));
    }
    let added = now.iter().filter(|parameter| !has(before, &parameter.name));
    changes.extend(added.map(|parameter| {
        let measure = Measure::AtLeast(0.0, 1.0);
        change(&parameter.name, "in the baseline", measure)
    }));
    changes
}

/// The stop reason and whether the model fits must be those of the baseline, and the reduced
/// chi-square may differ from it as between two tests of the same model.
fn fit_changes(now: &UpdateResult, before: &UpdateResult) -> [Change; 7] {
    let change = |what: &str, measure| Change {
        row: "fit".to_owned(),
        what: what.to_owned(),
        measure,
    };
    let changed = |changed: bool| Measure::AtMost(Some(f64::from(u8::from(changed))), 0.0);
    let difference = |new: f64, old: f64, most| Measure::AtMost(Some((new - old).abs()), most);
    [
        change(
            "stop reason changed",
            changed(now.stop_reason != before.stop_reason),
        ),
        change("verdict changed", changed(now.fits != before.fits)),
        change(
            "assumptions changed",
            changed(now.assumed != before.assumed),
        ),
        change(
            "kind of residuals changed",
            changed(now.residuals != before.residuals),
        ),
        change(
            "change of paired modes",
            difference(now.after.paired as f64, before.after.paired as f64, 0.0),
        ),
        change(
            "change of degrees of freedom",
            difference(
                now.degrees_of_freedom,
                before.degrees_of_freedom,
                MAX_DEGREES_OF_FREEDOM_CHANGE,
            ),
        ),
        change(
            "reduced chi-square change (factor)",
            Measure::VarianceRatio {
                now: now.reduced_chi_square,
                before: before.reduced_chi_square,
                degrees: before.degrees_of_freedom,
            },
        ),
    ]
}
