//! Published results of a machine are read from `expected.toml` in the folder of a scene and
//! checked.
//!
//! Natural frequencies are `[[root]]`s, a comparison of theory and tests is `[comparison]`, and
//! the claims of the text are `[[claim]]`s. Every name in a claim or a row must exist: otherwise a
//! claim about a missing test would look like one that cannot be confirmed.

use std::path::Path;

use serde::Deserialize;

use crate::correlate::published::{
    Claim, ClaimVerdict, Evidence, MatchOptions, ModelQuantities, PublishedComparison,
    PublishedRoot, RecomputedTable, RootMatch, audit, match_roots, recompute,
};
use crate::theory::{ModelRoot, Support};

use super::SceneError;
use super::error::value_error;
use super::faults::{Faults, parse_checked};
use super::published_claims::{ClaimTable, check_names, check_one_of, claim};
use super::toml_text::{check_schema, read_text};

/// The schema text of published results.
pub const EXPECTED_SCHEMA: &str = "modalign-expected/1";

/// Source of published results.
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
    /// Source.
    pub source: Source,
    /// Natural frequencies.
    pub roots: Vec<PublishedRoot>,
    /// Options of matching these to the model's.
    pub matching: MatchOptions,
    /// Theory and tests compared; `None` where the publication has no such table.
    pub comparison: Option<PublishedComparison>,
    /// Claims of the text.
    pub claims: Vec<Claim>,
}

/// Published results compared with a model and with one another.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpectedResult {
    /// Source.
    pub source: Source,
    /// Natural frequencies against the model's; `None` where none are printed or there is no model.
    pub roots: Option<RootMatch>,
    /// The comparison, recomputed.
    pub comparison: Option<RecomputedTable>,
    /// Verdicts on the claims.
    pub verdicts: Vec<ClaimVerdict>,
    /// The quantities of every model that a claim names.
    pub quantities: Vec<ModelQuantities>,
}

impl Expected {
    /// Compares the results with the roots of a model, the quantities of the models that claims
    /// name and the support of the model; without a model they are only compared with one another.
    pub fn compare(
        &self,
        model: Option<&[ModelRoot]>,
        quantities: Vec<ModelQuantities>,
        support: Option<Support>,
    ) -> ExpectedResult {
        let table = self.comparison.clone().unwrap_or_default();
        let matched = (!self.roots.is_empty())
            .then(|| match_roots(model.unwrap_or_default(), &self.roots, &self.matching));
        let published: Vec<&PublishedRoot> = self.roots.iter().collect();
        let evidence = Evidence {
            roots: matched.as_ref(),
            quantities: &quantities,
            support,
        };
        let verdicts = audit(&table, &evidence, &self.claims);
        ExpectedResult {
            source: self.source.clone(),
            verdicts,
            quantities,
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
    root: Vec<RootTable>,
    comparison: Option<PublishedComparison>,
    #[serde(default)]
    claim: Vec<ClaimTable>,
}

/// A root as typed.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RootTable {
    label: String,
    omega_rad_s: Option<f64>,
    frequency_hz: Option<f64>,
    multiplicity: Option<usize>,
    class: Option<String>,
    #[serde(default)]
    calibrated: bool,
}

impl RootTable {
    fn root(self, path: &str) -> Result<PublishedRoot, SceneError> {
        let (omega_rad_s, printed_hz) = match (self.omega_rad_s, self.frequency_hz) {
            (Some(omega), None) => (omega, None),
            (None, Some(hz)) => (std::f64::consts::TAU * hz, Some(hz)),
            _ => {
                let key = format!("[[root]] {:?}", self.label);
                let got = "none or both of `omega_rad_s` and `frequency_hz`";
                return Err(value_error(path, &key, got, "one of them, as printed"));
            }
        };
        Ok(PublishedRoot {
            omega_rad_s,
            printed_hz,
            label: self.label,
            multiplicity: self.multiplicity.unwrap_or(1),
            class: self.class,
            calibrated: self.calibrated,
        })
    }
}

/// The published results in a scene's folder, if it has any.
pub(super) fn published_results(folder: &Path) -> Result<Option<Expected>, SceneError> {
    let path = folder.join("expected.toml");
    // A link to a file that is not there is an error, as is an unreadable file.
    let entry = path.symlink_metadata();
    if entry.is_err_and(|error| error.kind() == std::io::ErrorKind::NotFound) {
        return Ok(None);
    }
    if is_template(&read_text(&path)?) {
        return Ok(None);
    }
    load_expected(&path).map(Some)
}

/// Whether a text has comments alone. An empty one is no template but a file without its content.
fn is_template(text: &str) -> bool {
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let first = lines.next();
    first.is_some_and(|line| line.starts_with('#')) && lines.all(|line| line.starts_with('#'))
}

/// Reads an `expected.toml`.
///
/// # Errors
/// [`SceneError`] with file, line and column, or the key that cannot be meant.
pub fn load_expected(path: &Path) -> Result<Expected, SceneError> {
    let name = path.display().to_string();
    let check = |file: ExpectedFile, _| checked_results(file, &name);
    parse_checked(&read_text(path)?, &name, check)
}

fn checked_results(file: ExpectedFile, name: &str) -> Result<Expected, SceneError> {
    let mut faults = Faults::default();
    faults.take(check_schema(&file.schema, EXPECTED_SCHEMA, name));
    let mut matching = MatchOptions::default();
    if let Some(gate) = file.max_frequency_error {
        if !(gate.is_finite() && gate > 0.0) {
            let (key, got) = ("max_frequency_error", gate.to_string());
            faults.add(value_error(name, key, &got, "a fraction above 0"));
        }
        matching.max_frequency_error = gate;
    }
    let (tables, claim_tables) = (file.root, file.claim);
    let is_empty = tables.is_empty() && claim_tables.is_empty();
    let root_labels: Vec<String> = tables.iter().map(|root| root.label.clone()).collect();
    let roots = tables.into_iter();
    let roots: Vec<PublishedRoot> = roots
        .filter_map(|root| faults.take(root.root(name)))
        .collect();
    check_roots(&roots, name, &mut faults);
    let table = file.comparison.unwrap_or_default();
    check_comparison(&table, &root_labels, name, &mut faults);
    let mut claims = Vec::with_capacity(claim_tables.len());
    for typed in &claim_tables {
        let Some(claim) = faults.take(claim(typed, name)) else {
            continue;
        };
        faults.take(check_names(&claim, &table, &root_labels, name));
        claims.push(claim);
    }
    if is_empty && table.row.is_empty() {
        let (key, got) = ("published results", "none");
        let expected = "a [[root]], a [[comparison.row]] or a [[claim]]";
        faults.add(value_error(name, key, got, expected));
    }
    faults.into_result()?;
    Ok(Expected {
        source: file.source,
        roots,
        matching,
        comparison: (!table.row.is_empty()).then_some(table),
        claims,
    })
}

fn check_roots(roots: &[PublishedRoot], path: &str, faults: &mut Faults<SceneError>) {
    for (index, root) in roots.iter().enumerate() {
        let key = |name: &str| format!("[[root]] {:?} {name}", root.label);
        if roots[..index].iter().any(|other| other.label == root.label) {
            faults.add(duplicate_error(path, &key("label")));
        }
        if !(root.omega_rad_s.is_finite() && root.omega_rad_s >= 0.0) {
            let (name, got) = match root.printed_hz {
                Some(hz) => ("frequency_hz", hz.to_string()),
                None => ("omega_rad_s", root.omega_rad_s.to_string()),
            };
            faults.add(value_error(path, &key(name), &got, "0 or more"));
        }
        if root.multiplicity == 0 {
            faults.add(value_error(path, &key("multiplicity"), "0", "1 or more"));
        }
    }
}

fn check_comparison(
    table: &PublishedComparison,
    root_labels: &[String],
    path: &str,
    faults: &mut Faults<SceneError>,
) {
    let tests = &table.tests;
    for test in (1..tests.len()).filter(|i| tests[..*i].contains(&tests[*i])) {
        let key = format!("[comparison] tests {:?}", tests[test]);
        faults.add(duplicate_error(path, &key));
    }
    for (index, row) in table.row.iter().enumerate() {
        let key = |name: &str| format!("[[comparison.row]] {:?} {name}", row.label);
        let mut earlier = table.row[..index].iter();
        if earlier.any(|other| other.label == row.label) {
            faults.add(duplicate_error(path, &key("label")));
        }
        if let Some(label) = &row.root {
            faults.take(check_one_of(label, root_labels.iter(), path, &key("root")));
        }
        faults.take(check_frequency(row.theory_hz, path, &key("theory_hz")));
        for (test, hz) in &row.tests {
            faults.take(check_one_of(test, tests.iter(), path, &key("tests")));
            let key = key(&format!("tests {test:?}"));
            faults.take(check_frequency(*hz, path, &key));
        }
    }
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

fn duplicate_error(path: &str, key: &str) -> SceneError {
    value_error(path, key, "the same name twice", "each one once")
}
