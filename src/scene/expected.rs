//! `expected.toml` beside a scene: what a publication printed about the machine, read and checked.
//!
//! Natural frequencies are `[[root]]`s, a comparison of theory and tests is `[comparison]`, and what the text says of both
//! is a list of `[[claim]]`s. Names that a claim or a row uses must be there: a claim about a test that the table does not
//! have would otherwise look like one that cannot be confirmed.

use std::path::Path;

use serde::Deserialize;

use crate::correlate::published::{
    Claim, ErrorClaim, ErrorUnit, MatchOptions, PublishedComparison, PublishedRoot,
    RecomputedTable, RootMatch, RootSide, Statement, Verdict, audit, match_roots, recompute,
};
use crate::theory::ModelRoot;

use super::SceneError;
use super::model::{check_schema, value_error};
use super::toml_text::{parse, read_text};

/// The schema text of published results.
pub const EXPECTED_SCHEMA: &str = "modalign-expected/1";

/// Where published results come from.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// Authors, as one text.
    pub authors: String,
    /// Title, with the place in it.
    pub paper: String,
    /// Journal; `None` for a book.
    pub journal: Option<String>,
    /// Year.
    pub year: i32,
    /// Digital object identifier.
    pub doi: Option<String>,
}

/// Published results.
#[derive(Clone, Debug, PartialEq)]
pub struct Expected {
    /// Where they come from.
    pub source: Source,
    /// Natural frequencies.
    pub roots: Vec<PublishedRoot>,
    /// How these find the model's.
    pub matching: MatchOptions,
    /// Theory and tests compared; `None` where the publication has no such table.
    pub comparison: Option<PublishedComparison>,
    /// What the text says.
    pub claims: Vec<Claim>,
}

/// Published results held against a model and against themselves.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpectedResult {
    /// Where they come from.
    pub source: Source,
    /// Natural frequencies against the model's; `None` where none are printed or there is no model.
    pub roots: Option<RootMatch>,
    /// The comparison, recomputed.
    pub comparison: Option<RecomputedTable>,
    /// What became of the claims.
    pub verdicts: Vec<Verdict>,
}

impl Expected {
    /// Holds the results against the roots of a model; without a model they are only held against one another.
    pub fn judge(&self, model: Option<&[ModelRoot]>) -> ExpectedResult {
        let table = self.comparison.clone().unwrap_or_default();
        let matched = (!self.roots.is_empty())
            .then(|| match_roots(model.unwrap_or_default(), &self.roots, &self.matching));
        let published: Vec<&PublishedRoot> = self.roots.iter().collect();
        ExpectedResult {
            source: self.source.clone(),
            verdicts: audit(&table, matched.as_ref(), &self.claims),
            comparison: self
                .comparison
                .as_ref()
                .map(|table| recompute(table, &published)),
            roots: matched.filter(|_| model.is_some()),
        }
    }
}

/// The file as typed.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ExpectedFile {
    schema: String,
    source: Source,
    max_frequency_error: Option<f64>,
    #[serde(default)]
    root: Vec<PublishedRoot>,
    comparison: Option<PublishedComparison>,
    #[serde(default)]
    claim: Vec<ClaimTable>,
}

/// A claim as typed; each kind needs some of the keys and admits no other.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ClaimTable {
    text: String,
    kind: String,
    test: Option<String>,
    row: Option<String>,
    rows: Option<Vec<String>>,
    value: Option<f64>,
    decimals: Option<usize>,
}

/// The kinds of claim, each with the keys that it needs besides `text`; it admits these and `decimals`.
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
];

/// The published results in a scene's folder, if it has any.
pub(super) fn beside(folder: &Path) -> Result<Option<Expected>, SceneError> {
    let path = folder.join("expected.toml");
    path.exists().then(|| load_expected(&path)).transpose()
}

/// Reads an `expected.toml`.
///
/// # Errors
/// [`SceneError`] with file, line and column, or the key that cannot be meant.
pub fn load_expected(path: &Path) -> Result<Expected, SceneError> {
    let name = path.display().to_string();
    let file: ExpectedFile = parse(&read_text(path)?, &name)?;
    check_schema(&file.schema, EXPECTED_SCHEMA, &name)?;
    let mut matching = MatchOptions::default();
    if let Some(gate) = file.max_frequency_error {
        if !(gate.is_finite() && gate > 0.0) {
            let got = gate.to_string();
            return Err(value_error(
                &name,
                "max_frequency_error",
                &got,
                "a fraction above 0",
            ));
        }
        matching.max_frequency_error = gate;
    }
    check_roots(&file.root, &name)?;
    let mut claims = Vec::with_capacity(file.claim.len());
    let table = file.comparison.unwrap_or_default();
    check_comparison(&table, &file.root, &name)?;
    for typed in &file.claim {
        let claim = claim(typed, &name)?;
        check_names(&claim, &table, &file.root, &name)?;
        claims.push(claim);
    }
    Ok(Expected {
        source: file.source,
        roots: file.root,
        matching,
        comparison: (!table.row.is_empty()).then_some(table),
        claims,
    })
}

fn check_roots(roots: &[PublishedRoot], path: &str) -> Result<(), SceneError> {
    for (index, root) in roots.iter().enumerate() {
        let key = |name: &str| format!("[[root]] {:?} {name}", root.label);
        if roots[..index].iter().any(|other| other.label == root.label) {
            return Err(twice(path, &key("label")));
        }
        if !(root.omega_rad_s.is_finite() && root.omega_rad_s >= 0.0) {
            let got = root.omega_rad_s.to_string();
            return Err(value_error(
                path,
                &key("omega_rad_s"),
                &got,
                "0 rad/s or more",
            ));
        }
        if root.multiplicity == 0 {
            return Err(value_error(path, &key("multiplicity"), "0", "1 or more"));
        }
    }
    Ok(())
}

fn check_comparison(
    table: &PublishedComparison,
    roots: &[PublishedRoot],
    path: &str,
) -> Result<(), SceneError> {
    if let Some(test) =
        (1..table.tests.len()).find(|i| table.tests[..*i].contains(&table.tests[*i]))
    {
        return Err(twice(
            path,
            &format!("[comparison] tests {:?}", table.tests[test]),
        ));
    }
    for (index, row) in table.row.iter().enumerate() {
        let key = |name: &str| format!("[[comparison.row]] {:?} {name}", row.label);
        if table.row[..index]
            .iter()
            .any(|other| other.label == row.label)
        {
            return Err(twice(path, &key("label")));
        }
        if let Some(label) = &row.root {
            check_one_of(
                label,
                roots.iter().map(|root| &root.label),
                path,
                &key("root"),
            )?;
        }
        check_frequency(row.theory_hz, path, &key("theory_hz"))?;
        for (test, hz) in &row.tests {
            check_one_of(test, table.tests.iter(), path, &key("tests"))?;
            check_frequency(*hz, path, &key(&format!("tests {test:?}")))?;
        }
    }
    Ok(())
}

fn check_frequency(hz: f64, path: &str, key: &str) -> Result<(), SceneError> {
    if hz.is_finite() && hz > 0.0 {
        return Ok(());
    }
    Err(value_error(
        path,
        key,
        &hz.to_string(),
        "a frequency above 0 Hz",
    ))
}

fn twice(path: &str, key: &str) -> SceneError {
    value_error(path, key, "the same name twice", "each one once")
}

fn check_one_of<'a>(
    name: &str,
    known: impl Iterator<Item = &'a String>,
    path: &str,
    key: &str,
) -> Result<(), SceneError> {
    let known: Vec<&String> = known.collect();
    if known.iter().any(|own| *own == name) {
        return Ok(());
    }
    let expected = format!("one of {known:?}");
    Err(value_error(path, key, &format!("{name:?}"), &expected))
}

/// Every test and row that a claim names is in the tables.
fn check_names(
    claim: &Claim,
    table: &PublishedComparison,
    roots: &[PublishedRoot],
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
        Statement::Multiplicity { row, .. } => {
            check_one_of(row, roots.iter().map(|root| &root.label), path, &key("row"))
        }
        _ => Ok(()),
    }
}

/// More digits after the point than this no `f64` holds of a number of ordinary size.
const MOST_DECIMALS: usize = 15;

/// The claim that a table means.
fn claim(typed: &ClaimTable, path: &str) -> Result<Claim, SceneError> {
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
        ("value", typed.value.is_some()),
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
    if let Some(got) = typed.decimals.filter(|decimals| *decimals > MOST_DECIMALS) {
        let (got, expected) = (got.to_string(), format!("0 to {MOST_DECIMALS}"));
        return Err(value_error(path, &key("decimals"), &got, &expected));
    }
    let decimals = typed.decimals.unwrap_or(0);
    if let Some(value) = typed.value.filter(|value| !has_decimals(*value, decimals)) {
        let expected = format!("no more than the {decimals} `decimals` stated");
        return Err(value_error(
            path,
            &key("value"),
            &value.to_string(),
            &expected,
        ));
    }
    Ok(Claim {
        text: typed.text.clone(),
        statement: statement(typed),
        decimals,
    })
}

/// Whether a number as written has no more digits after the point than these.
fn has_decimals(value: f64, decimals: usize) -> bool {
    format!("{value:.decimals$}").parse() == Ok(value)
}

/// What a claim says, once its keys are known to be there.
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
        _ => Statement::TheoryColumn,
    }
}
