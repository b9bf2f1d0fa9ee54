//! `modalign check` of an `update.json`: its parameters, and how well the updated model fits.

use serde::Deserialize;

use crate::scene::{AllowedChange, Change, Measure, UncertainValue, relative_change, std_change};

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
    "parameters.updated",
    "parameters.std",
    "after.paired",
    "degrees_of_freedom",
    "reduced_chi_square",
];

/// The compared parts of an `update.json`.
#[derive(Deserialize)]
pub(super) struct UpdateResult {
    parameters: Vec<UpdatedParameter>,
    stop_reason: String,
    after: UpdatedFit,
    degrees_of_freedom: f64,
    reduced_chi_square: f64,
    fits: bool,
}

#[derive(Deserialize)]
struct UpdatedParameter {
    name: String,
    updated: f64,
    std: f64,
    verdict: String,
}

#[derive(Deserialize)]
struct UpdatedFit {
    paired: usize,
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
        match self.reduced_chi_square >= 0.0 {
            true => Ok(()),
            false => Err(format!(
                "reduced_chi_square: got {}, expected 0 or more",
                self.reduced_chi_square
            )),
        }
    }
}

/// Changes of every parameter of the baseline, and of the fit.
pub(super) fn update_changes(now: &UpdateResult, before: &UpdateResult) -> Vec<Change> {
    let mut changes = parameter_changes(&now.parameters, &before.parameters);
    changes.extend(fit_changes(now, before));
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
fn fit_changes(now: &UpdateResult, before: &UpdateResult) -> [Change; 5] {
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
