//! The claims of a publication are `[[claim]]`s of an `expected.toml`.

use serde::Deserialize;

use crate::correlate::published::{
    Claim, Digits, ErrorClaim, ErrorUnit, PublishedComparison, QuantityClaim, Relation, RootSide,
    Statement,
};
use crate::theory::Support;

use super::SceneError;
use super::error::value_error;

/// A claim as typed; each kind needs some of the keys and admits no other.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ClaimTable {
    text: String,
    kind: String,
    test: Option<String>,
    row: Option<String>,
    rows: Option<Vec<String>>,
    quantity: Option<String>,
    support: Option<Support>,
    value: Option<f64>,
    decimals: Option<usize>,
    significant: Option<usize>,
    model: Option<String>,
    remark: Option<String>,
}

/// The kinds of claim, each with the keys that it needs besides `text`; it admits these, `remark`,
/// one of `decimals` and `significant`, and `model` where it needs a `quantity`.
pub(super) const KINDS: &[(&str, &[&str])] = &[
    ("largest-error-hz", &["test", "row", "value"]),
    ("largest-error-percent", &["test", "row", "value"]),
    ("error-hz", &["test", "row", "value"]),
    ("error-percent", &["test", "row", "value"]),
    ("missed", &["test", "rows"]),
    ("single-roots", &["value"]),
    ("model-single-roots", &["value"]),
    ("total-roots", &["value"]),
    ("model-total-roots", &["value"]),
    ("multiplicity", &["row", "value"]),
    ("model-multiplicity", &["row", "value"]),
    ("theory-column", &[]),
    ("frequency-hz", &["row", "value"]),
    ("quantity", &["quantity", "value"]),
    ("quantity-above", &["quantity", "value"]),
    ("quantity-below", &["quantity", "value"]),
    ("figure", &["quantity"]),
    ("same-support", &["support"]),
    ("not-checkable", &["remark"]),
];

/// Every test and row that a claim names is in the tables.
pub(super) fn check_names(
    claim: &Claim,
    table: &PublishedComparison,
    root_labels: &[String],
    path: &str,
) -> Result<(), SceneError> {
    let key = |name: &str| format!("[[claim]] {:?} {name}", claim.text);
    let test = |name| check_one_of(name, table.tests.iter(), path, &key("test"));
    let row = |label| {
        let labels = table.row.iter().map(|row| &row.label);
        check_one_of(label, labels, path, &key("row"))
    };
    match &claim.statement {
        Statement::LargestError(error) | Statement::ErrorAt(error) => {
            test(&error.test).and_then(|()| row(&error.row))
        }
        Statement::Missed { test: t, rows } => {
            test(t).and_then(|()| rows.iter().try_for_each(|label| row(label)))
        }
        Statement::Multiplicity { row, .. } | Statement::Frequency { row, .. } => {
            check_one_of(row, root_labels.iter(), path, &key("row"))
        }
        _ => Ok(()),
    }
}

/// Maximum number of decimals of a published value: an `f64` of ordinary size holds no more.
const MAX_DECIMALS: usize = 15;

/// The claim that a table means.
pub(super) fn claim(typed: &ClaimTable, path: &str) -> Result<Claim, SceneError> {
    let key = |name: &str| format!("[[claim]] {:?} {name}", typed.text);
    let known = KINDS.iter().find(|(name, _)| *name == typed.kind);
    let (_, needed) = known.ok_or_else(|| {
        let names: Vec<&str> = KINDS.iter().map(|(name, _)| *name).collect();
        let expected = format!("one of {names:?}");
        value_error(path, &key("kind"), &format!("{:?}", typed.kind), &expected)
    })?;
    let given = [
        ("test", typed.test.is_some()),
        ("row", typed.row.is_some()),
        ("rows", typed.rows.is_some()),
        ("quantity", typed.quantity.is_some()),
        ("support", typed.support.is_some()),
        ("value", typed.value.is_some()),
        // These two are free for those that do not need them.
        ("model", typed.model.is_some() && typed.quantity.is_none()),
        (
            "remark",
            needed.contains(&"remark") && typed.remark.is_some(),
        ),
    ];
    for (name, is_given) in given {
        if is_given != needed.contains(&name) {
            let got = if is_given { "a value" } else { "none" };
            let expected = format!("{needed:?} for {:?}, and no other", typed.kind);
            return Err(value_error(path, &key(name), got, &expected));
        }
    }
    if let Some(got) = typed.value.filter(|value| !value.is_finite()) {
        let got = got.to_string();
        return Err(value_error(path, &key("value"), &got, "a finite number"));
    }
    let digits = digits(typed, path)?;
    if let Some(value) = typed.value
        && digits.text(value).parse() != Ok(value)
    {
        let expected = match digits {
            Digits::Decimals(decimals) => format!("no more than the {decimals} `decimals` stated"),
            Digits::Significant(all) => {
                format!("no more than the {all} `significant` digits stated")
            }
        };
        let got = value.to_string();
        return Err(value_error(path, &key("value"), &got, &expected));
    }
    Ok(Claim {
        text: typed.text.clone(),
        statement: statement(typed),
        digits,
        remark: typed.remark.clone(),
    })
}

/// Digits as stated; none after the point when nothing is.
fn digits(typed: &ClaimTable, path: &str) -> Result<Digits, SceneError> {
    let key = |name: &str| format!("[[claim]] {:?} {name}", typed.text);
    match (typed.decimals, typed.significant) {
        (Some(_), Some(_)) => {
            let got = "`significant` beside `decimals`";
            Err(value_error(path, &key("decimals"), got, "one of them"))
        }
        (Some(got), None) if got > MAX_DECIMALS => {
            let (got, expected) = (got.to_string(), format!("0 to {MAX_DECIMALS}"));
            Err(value_error(path, &key("decimals"), &got, &expected))
        }
        (None, Some(got)) if !(1..=MAX_DECIMALS).contains(&got) => {
            let (got, expected) = (got.to_string(), format!("1 to {MAX_DECIMALS}"));
            Err(value_error(path, &key("significant"), &got, &expected))
        }
        (None, Some(all)) => Ok(Digits::Significant(all)),
        (decimals, None) => Ok(Digits::Decimals(decimals.unwrap_or(0))),
    }
}

/// Statement of a claim whose keys are complete.
fn statement(typed: &ClaimTable) -> Statement {
    let row = typed.row.clone().unwrap_or_default();
    let value = typed.value.unwrap_or_default();
    let test = typed.test.clone().unwrap_or_default();
    let (side, kind) = match typed.kind.strip_prefix("model-") {
        Some(kind) => (RootSide::Model, kind),
        None => (RootSide::Printed, typed.kind.as_str()),
    };
    let error = |unit| ErrorClaim {
        unit,
        test: test.clone(),
        row: row.clone(),
        value,
    };
    let quantity = |relation| {
        Statement::Quantity(QuantityClaim {
            model: typed.model.clone(),
            quantity: typed.quantity.clone().unwrap_or_default(),
            relation,
        })
    };
    if let Some(test) = typed.support {
        return Statement::SameSupport { test };
    }
    match kind {
        "largest-error-hz" => Statement::LargestError(error(ErrorUnit::Hz)),
        "largest-error-percent" => Statement::LargestError(error(ErrorUnit::Percent)),
        "error-hz" => Statement::ErrorAt(error(ErrorUnit::Hz)),
        "error-percent" => Statement::ErrorAt(error(ErrorUnit::Percent)),
        "missed" => Statement::Missed {
            test,
            rows: typed.rows.clone().unwrap_or_default(),
        },
        "single-roots" => Statement::SingleRoots { side, value },
        "total-roots" => Statement::TotalRoots { side, value },
        "multiplicity" => Statement::Multiplicity { side, row, value },
        "frequency-hz" => Statement::Frequency { row, hz: value },
        "quantity" => quantity(Relation::Equal(value)),
        "quantity-above" => quantity(Relation::Above(value)),
        "quantity-below" => quantity(Relation::Below(value)),
        "figure" => quantity(Relation::Unstated),
        "not-checkable" => Statement::NotCheckable,
        _ => Statement::TheoryColumn,
    }
}

pub(super) fn check_one_of<'a>(
    name: &str,
    known: impl Iterator<Item = &'a String>,
    path: &str,
    key: &str,
) -> Result<(), SceneError> {
    let known: Vec<&String> = known.collect();
    if known.iter().any(|candidate| *candidate == name) {
        return Ok(());
    }
    let expected = format!("one of {known:?}");
    Err(value_error(path, key, &format!("{name:?}"), &expected))
}
