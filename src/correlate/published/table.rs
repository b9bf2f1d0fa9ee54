//! The recomputed table holds a published comparison of theory and tests with its errors computed
//! anew.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::correlate::ErrorReference;

use super::roots::{PublishedRoot, frequency_hz};

/// A table of theoretical and measured frequencies, as printed.
#[derive(Clone, Debug, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PublishedComparison {
    /// Names of the tests, in the order of the columns.
    #[serde(default)]
    pub tests: Vec<String>,
    /// Reference of the relative errors.
    #[serde(default)]
    pub error_reference: ErrorReference,
    /// Rows, in their order.
    #[serde(default)]
    pub row: Vec<PublishedRow>,
}

/// One row, as printed.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PublishedRow {
    /// Label, as printed.
    pub label: String,
    /// Label of the published root that the theory's frequency is, where it is one.
    pub root: Option<String>,
    /// The theory's frequency, Hz.
    pub theory_hz: f64,
    /// Measured frequency by test, Hz; a test that is absent missed it.
    #[serde(default)]
    pub tests: BTreeMap<String, f64>,
}

/// A published comparison with its errors.
#[derive(Clone, Debug, PartialEq)]
pub struct RecomputedTable {
    /// Reference of the relative errors.
    pub error_reference: ErrorReference,
    /// Rows, in their order.
    pub rows: Vec<RecomputedRow>,
    /// Errors over the rows of each test, in the order of the columns.
    pub tests: Vec<TestErrors>,
}

/// One row with its errors.
#[derive(Clone, Debug, PartialEq)]
pub struct RecomputedRow {
    /// Label.
    pub label: String,
    /// The theory's frequency as printed, Hz.
    pub theory_hz: f64,
    /// Frequency of the published root of this row, Hz; `None` where the row names none, or it is
    /// not printed.
    pub root_hz: Option<f64>,
    /// A cell for every test, in the order of the columns; `None` where it missed the frequency.
    pub tests: Vec<Option<ErrorCell>>,
}

/// One test in one row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorCell {
    /// Measured frequency as printed, Hz.
    pub hz: f64,
    /// Signed error, Hz.
    pub error_hz: f64,
    /// Signed error, percent of the reference.
    pub error_percent: f64,
}

/// Errors of one test over its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct TestErrors {
    /// Name of the test.
    pub test: String,
    /// Largest magnitude in Hz; `None` for a test without a frequency.
    pub largest_hz: Option<Largest>,
    /// Largest magnitude in percent.
    pub largest_percent: Option<Largest>,
    /// Mean magnitude, percent.
    pub mean_percent: Option<f64>,
    /// Labels of the rows that it missed.
    pub missed: Vec<String>,
}

/// A largest magnitude and where it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Largest {
    /// The magnitude.
    pub value: f64,
    /// Labels of the rows that have it; more than one when they share it.
    pub rows: Vec<String>,
}

/// Computes the errors of a printed comparison; a row names a published root by its label.
///
/// By the theory `(test − theory)/theory`, by the test `(theory − test)/test`, in percent; in Hz
/// the numerator alone.
pub fn recompute(table: &PublishedComparison, roots: &[&PublishedRoot]) -> RecomputedTable {
    let rows: Vec<RecomputedRow> = table
        .row
        .iter()
        .map(|row| recomputed_row(table, row, roots))
        .collect();
    let tests = (0..table.tests.len())
        .map(|column| test_errors(&table.tests[column], column, &rows))
        .collect();
    RecomputedTable {
        error_reference: table.error_reference,
        rows,
        tests,
    }
}

fn recomputed_row(
    table: &PublishedComparison,
    row: &PublishedRow,
    roots: &[&PublishedRoot],
) -> RecomputedRow {
    let matched = roots
        .iter()
        .find(|root| row.root.as_ref() == Some(&root.label));
    let cell = |test: &String| {
        let hz = *row.tests.get(test)?;
        Some(error_cell(table.error_reference, hz, row.theory_hz))
    };
    RecomputedRow {
        label: row.label.clone(),
        theory_hz: row.theory_hz,
        root_hz: matched.map(|root| frequency_hz(root.omega_rad_s)),
        tests: table.tests.iter().map(cell).collect(),
    }
}

fn error_cell(reference: ErrorReference, hz: f64, theory_hz: f64) -> ErrorCell {
    ErrorCell {
        hz,
        error_hz: match reference {
            ErrorReference::Theory => hz - theory_hz,
            ErrorReference::Test => theory_hz - hz,
        },
        error_percent: 100.0 * reference.error(hz, theory_hz),
    }
}

fn test_errors(test: &str, column: usize, rows: &[RecomputedRow]) -> TestErrors {
    let found: Vec<(&str, ErrorCell)> = rows
        .iter()
        .filter_map(|row| Some((row.label.as_str(), row.tests[column]?)))
        .collect();
    let magnitudes = |of: fn(&ErrorCell) -> f64| -> Vec<(&str, f64)> {
        let entries = found.iter();
        entries
            .map(|(label, cell)| (*label, of(cell).abs()))
            .collect()
    };
    let percent = magnitudes(|cell| cell.error_percent);
    let sum: f64 = percent.iter().map(|(_, value)| value).sum();
    let missed = rows.iter().filter(|row| row.tests[column].is_none());
    TestErrors {
        test: test.to_owned(),
        largest_hz: largest(&magnitudes(|cell| cell.error_hz)),
        mean_percent: (!percent.is_empty()).then(|| sum / percent.len() as f64),
        largest_percent: largest(&percent),
        missed: missed.map(|row| row.label.clone()).collect(),
    }
}

/// The largest value with every row that has it, to the rounding of the arithmetic.
fn largest(values: &[(&str, f64)]) -> Option<Largest> {
    let value = values.iter().map(|(_, value)| *value).reduce(f64::max)?;
    let same = |other: f64| value - other <= 8.0 * f64::EPSILON * value;
    let rows = values.iter().filter(|(_, other)| same(*other));
    Some(Largest {
        value,
        rows: rows.map(|(label, _)| (*label).to_owned()).collect(),
    })
}
