//! `comparison.json`, schema `modalign-comparison/1`, holds the pairs of test and model modes.

use std::collections::BTreeSet;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::correlate::measures::{Measures, ReversedSensor};
use crate::correlate::{
    Alignment, Basis, ComparisonTable, Row, Status, SummedCell, TestCell, TestSummary, TheoryCell,
    summary_of_cells,
};
use crate::scene::{LimitCheck, PlacedTest, SceneResult};

use super::measures::{measures_value, reversed_value};
use super::placement::{limits_value, placements_value};
use super::schema::json_text;
use super::states::states_value;

/// The schema text.
pub const COMPARISON_SCHEMA: &str = "modalign-comparison/1";

/// Why a text is not a `comparison.json` or an `update.json`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum JsonError {
    /// It does not parse or misses a key.
    #[error("line {line}, column {column}: {message}")]
    Parse {
        /// Line from 1.
        line: usize,
        /// Column from 1.
        column: usize,
        /// What was found and expected.
        message: String,
    },
    /// Another schema.
    #[error("got schema {got:?}, expected {expected:?}")]
    Schema {
        /// The text found.
        got: String,
        /// The one of the file that was asked for.
        expected: &'static str,
    },
    /// A value that contradicts others or cannot be meant.
    #[error("{key}: got {got}, expected {expected}")]
    Value {
        /// The key, with its row and test.
        key: String,
        /// The value found.
        got: String,
        /// The accepted ones.
        expected: String,
    },
}

impl JsonError {
    fn value(key: &str, got: impl ToString, expected: impl ToString) -> Self {
        JsonError::Value {
            key: key.to_owned(),
            got: got.to_string(),
            expected: expected.to_string(),
        }
    }
}

/// The file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ComparisonFile {
    /// [`COMPARISON_SCHEMA`].
    pub schema: String,
    /// `theory` or `test`.
    pub error_reference: String,
    /// Rows of the table.
    pub rows: Vec<RowFile>,
    /// Totals over all rows, for each test.
    pub summary: SummaryFile,
    /// Correlation measures, if requested: an object for each test.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub measures: Option<Value>,
    /// Sign-reversed sensors, if any: an object for each test.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reversed_sensors: Option<Value>,
    /// The frame that was fitted to the points of the first test.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alignment: Option<Value>,
    /// Recommended excitation points and sensors, if a scene requests them: an object for each
    /// test.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub placements: Option<Value>,
    /// Limits that a scene states: an object for each, with `met`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<Value>,
    /// Supports and states that a scene and its model state: `tests`, an object for each with what
    /// is stated, and the `support` of the `model`, `stated` and `derived` from its matrices.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub states: Option<Value>,
    /// What to do next after the run of a scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub next: Option<String>,
}

/// One row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RowFile {
    /// `f6`.
    pub label: String,
    /// The model's mode or cluster; `null` for an unmatched test mode.
    pub theory: Option<TheoryFile>,
    /// One field per test.
    pub tests: Vec<TestFile>,
}

/// The model's side of a row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TheoryFile {
    /// Mode numbers from 1; several for a repeated root.
    pub modes: Vec<usize>,
    /// Frequency.
    pub hz: f64,
}

/// One test's side of a row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TestFile {
    /// Name of the test.
    pub test: String,
    /// Mode numbers of the test from 1.
    pub modes: Vec<usize>,
    /// Frequency.
    pub hz: Option<f64>,
    /// Its standard deviation.
    pub hz_std: Option<f64>,
    /// Frequency error.
    pub error_percent: Option<f64>,
    /// The same difference, Hz.
    #[serde(default)]
    pub error_hz: Option<f64>,
    /// `(test - theory)/std` by the standard deviation of the test's frequency.
    #[serde(default)]
    pub normalised_error: Option<f64>,
    /// Damping, a fraction.
    pub damping_ratio: Option<f64>,
    /// Its standard deviation.
    #[serde(default)]
    pub damping_std: Option<f64>,
    /// MAC.
    pub mac: Option<f64>,
    /// Evidence on which a pair rests: `shape` (and frequency) or `frequency` alone; absent without
    /// a partner.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub basis: Option<Basis>,
    /// Chance level for independent shapes that the MAC of a pair by shape reaches; absent
    /// elsewhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chance_level: Option<f64>,
    /// Principal angles of a cluster, degrees.
    pub angles_deg: Option<Vec<f64>>,
    /// Verdict on the pairing of the mode.
    pub status: Status,
    /// `false` for an unmatched mode of the model whose observability in the test is unknown;
    /// absent otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub judged: Option<bool>,
    /// Why.
    pub reason: Option<String>,
}

/// Totals over all rows. For each test: numbers of `paired` roots (sum of `paired_by_shape` and
/// `paired_by_frequency`), of `ambiguous` ones (including `uncorrelated` ones, with a MAC below the
/// chance level) and of `missed` ones, and the errors of paired roots.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SummaryFile {
    /// One entry per test.
    pub tests: Vec<TestSummary>,
}

/// The text of `comparison.json`, ending in a newline.
pub fn comparison_to_json(table: &ComparisonTable) -> String {
    comparison_with(table, &ExtraResults::default())
}

/// Results that the file contains in addition to the table.
#[derive(Clone, Copy, Debug, Default)]
pub struct ExtraResults<'a> {
    /// Measures of tests, by name.
    pub measures: &'a [(String, Measures)],
    /// Reversed sensors of tests, by name.
    pub reversed: &'a [(String, Vec<ReversedSensor>)],
    /// The frame that was fitted to the points of the first test.
    pub alignment: Option<&'a Alignment>,
    /// Recommended points of tests.
    pub placements: &'a [PlacedTest],
    /// Limits with the values compared.
    pub limits: &'a [LimitCheck],
    /// The result of the scene, for the states of its tests and the support of its model.
    pub states: Option<&'a SceneResult>,
    /// What to do next.
    pub next: Option<&'a str>,
}

/// The text of `comparison.json` with further results beside the rows; each kind of result has a
/// key, which is absent where there is none.
pub fn comparison_with(table: &ComparisonTable, extra: &ExtraResults<'_>) -> String {
    let alignment = extra.alignment.map(serde_json::to_value);
    let file = ComparisonFile {
        schema: COMPARISON_SCHEMA.to_owned(),
        error_reference: table.error_reference.name().to_owned(),
        rows: table.rows.iter().map(row_file).collect(),
        summary: SummaryFile {
            tests: table.summary.clone(),
        },
        measures: (!extra.measures.is_empty()).then(|| measures_value(extra.measures)),
        reversed_sensors: reversed_value(extra.reversed),
        alignment: alignment.and_then(Result::ok),
        placements: placements_value(extra.placements),
        limits: limits_value(extra.limits),
        states: extra.states.and_then(states_value),
        next: extra.next.map(str::to_owned),
    };
    json_text(&file)
}

/// Reads `comparison.json`.
///
/// # Errors
/// [`JsonError`] with line and column, the schema that was found, rows or tests of the same name,
/// or a standard deviation below 0.
pub fn comparison_from_json(text: &str) -> Result<ComparisonFile, JsonError> {
    let mut file: ComparisonFile = parsed(text)?;
    if file.schema == COMPARISON_SCHEMA {
        check_names(&file)?;
        if !["theory", "test"].contains(&file.error_reference.as_str()) {
            let got = format!("{:?}", file.error_reference);
            return Err(JsonError::value(
                "error_reference",
                got,
                "\"theory\" or \"test\"",
            ));
        }
        for row in &file.rows {
            for cell in &row.tests {
                check_stds(row, cell)?;
            }
        }
        count_pairs(&mut file);
        return Ok(file);
    }
    Err(JsonError::Schema {
        got: file.schema,
        expected: COMPARISON_SCHEMA,
    })
}

/// Counts the pairs of each test by its rows: in files of earlier versions `paired` holds the
/// ambiguous ones, too.
fn count_pairs(file: &mut ComparisonFile) {
    for test in &mut file.summary.tests {
        let cells = file.rows.iter().flat_map(|row| &row.tests);
        let paired = cells.filter(|cell| cell.test == test.test && cell.status == Status::Paired);
        test.paired = paired.count();
    }
}

/// Checks that each row has another label, and each test of a row or of the summary another name.
fn check_names(file: &ComparisonFile) -> Result<(), JsonError> {
    let labels = file.rows.iter().map(|row| row.label.as_str());
    check_distinct("rows label", labels)?;
    for row in &file.rows {
        let tests = row.tests.iter().map(|cell| cell.test.as_str());
        check_distinct(&format!("rows {:?} tests", row.label), tests)?;
    }
    let tests = file.summary.tests.iter().map(|test| test.test.as_str());
    check_distinct("summary tests", tests)
}

fn check_distinct<'a>(key: &str, names: impl Iterator<Item = &'a str>) -> Result<(), JsonError> {
    let mut seen = BTreeSet::new();
    for name in names {
        if !seen.insert(name) {
            return Err(JsonError::value(
                key,
                format!("{name:?} twice"),
                "each name once",
            ));
        }
    }
    Ok(())
}

fn cell_key(row: &RowFile, cell: &TestFile, key: &str) -> String {
    format!("rows {:?} test {:?} {key}", row.label, cell.test)
}

fn check_stds(row: &RowFile, cell: &TestFile) -> Result<(), JsonError> {
    for (key, std) in [("hz_std", cell.hz_std), ("damping_std", cell.damping_std)] {
        if let Some(std) = std.filter(|std| *std < 0.0) {
            return Err(JsonError::value(
                &cell_key(row, cell, key),
                std,
                "0 or more",
            ));
        }
    }
    Ok(())
}

/// Relative difference of two numbers that are equal but for rounding.
const ROUNDING: f64 = 1e-9;

fn are_equal(one: f64, other: f64) -> bool {
    (one - other).abs() <= ROUNDING * one.abs().max(other.abs())
}

impl ComparisonFile {
    /// Checks that the summary of each test is that of its rows, and the error of each pair that
    /// of its frequencies.
    ///
    /// # Errors
    /// [`JsonError::Value`] with the key of the first value that contradicts the others.
    pub fn check_summary(&self) -> Result<(), JsonError> {
        for row in &self.rows {
            for cell in &row.tests {
                self.check_error(row, cell)?;
                if !self.summary.tests.iter().any(|test| test.test == cell.test) {
                    let got = format!("no test {:?}", cell.test);
                    let expected = format!("the tests of row {:?}", row.label);
                    return Err(JsonError::value("summary tests", got, expected));
                }
            }
        }
        self.summary
            .tests
            .iter()
            .try_for_each(|test| self.check_test(test))
    }

    fn check_test(&self, stated: &TestSummary) -> Result<(), JsonError> {
        let all = self.rows.iter().flat_map(|row| &row.tests);
        let cells: Vec<&TestFile> = all.filter(|cell| cell.test == stated.test).collect();
        let summed: Vec<SummedCell> = cells.iter().map(|cell| summed_cell(cell)).collect();
        let by_rows = summary_of_cells(&stated.test, stated.dofs_used, &summed);
        let (stated_values, by_rows) = (json_values(stated), json_values(&by_rows));
        // The chance level of a repeated root is that of one of its modes.
        let has_repeated = cells.iter().any(|cell| cell.modes.len() > 1);
        for (key, got) in &stated_values {
            let expected = by_rows.get(key).unwrap_or(&Value::Null);
            let is_equal = match (got.as_f64(), expected.as_f64()) {
                (Some(got), Some(_)) if key == "uncorrelated" && has_repeated => {
                    got <= stated.ambiguous as f64
                }
                (Some(got), Some(expected)) => are_equal(got, expected),
                _ => got == expected,
            };
            if !is_equal {
                let key = format!("summary test {:?} {key}", stated.test);
                return Err(JsonError::value(
                    &key,
                    got,
                    format!("{expected}, as in the rows"),
                ));
            }
        }
        Ok(())
    }

    /// The error of a pair: of one mode that of its frequency; of a repeated root the largest one,
    /// at least that of the mean.
    fn check_error(&self, row: &RowFile, cell: &TestFile) -> Result<(), JsonError> {
        let is_pair = matches!(cell.status, Status::Paired | Status::Ambiguous);
        let key = |name: &str| cell_key(row, cell, name);
        let Some((theory, hz)) = row.theory.as_ref().zip(cell.hz).filter(|_| is_pair) else {
            return match is_pair {
                true => Err(JsonError::value(&key("hz"), "none", "frequencies of both")),
                false => Ok(()),
            };
        };
        let (error_hz, reference) = match self.error_reference.as_str() {
            "test" => (theory.hz - hz, hz),
            _ => (hz - theory.hz, theory.hz),
        };
        let error_percent = 100.0 * error_hz / reference;
        let values = [
            (
                "error_percent",
                cell.error_percent,
                error_percent,
                reference / 100.0,
            ),
            // Files of earlier versions do not have it.
            ("error_hz", cell.error_hz.or(Some(error_hz)), error_hz, 1.0),
        ];
        for (name, stated, computed, unit_hz) in values {
            // The difference of the frequencies is as exact as these.
            let is_right = |stated: f64| match cell.modes.len() {
                0 | 1 => (stated - computed).abs() * unit_hz <= ROUNDING * reference,
                _ if self.error_reference == "test" => true,
                _ => (stated.abs() - computed.abs()) * unit_hz >= -ROUNDING * reference,
            };
            if !stated.is_some_and(is_right) {
                let got = stated.map_or("none".to_owned(), |stated| stated.to_string());
                let expected = format!("{computed}, by the frequencies");
                return Err(JsonError::value(&key(name), got, expected));
            }
        }
        Ok(())
    }
}

fn summed_cell(cell: &TestFile) -> SummedCell {
    let is_below = |(mac, level): (f64, f64)| mac < level;
    SummedCell {
        status: cell.status,
        is_status_certain: cell.judged != Some(false),
        basis: cell.basis,
        uncorrelated: cell.mac.zip(cell.chance_level).is_some_and(is_below),
        error_percent: cell.error_percent,
        error_hz: cell.error_hz,
        mac: cell.mac,
    }
}

/// The values of a summary by key.
fn json_values(summary: &TestSummary) -> serde_json::Map<String, Value> {
    match serde_json::to_value(summary) {
        Ok(Value::Object(values)) => values,
        _ => serde_json::Map::new(),
    }
}

/// A file of any schema.
pub(super) fn parsed<T: DeserializeOwned>(text: &str) -> Result<T, JsonError> {
    serde_json::from_str(text).map_err(|error| JsonError::Parse {
        line: error.line(),
        column: error.column(),
        message: error.to_string(),
    })
}

fn row_file(row: &Row) -> RowFile {
    let theory = |cell: &TheoryCell| TheoryFile {
        modes: cell.modes.clone(),
        hz: cell.hz,
    };
    RowFile {
        label: row.label.clone(),
        theory: row.theory.as_ref().map(theory),
        tests: row.tests.iter().map(test_file).collect(),
    }
}

fn test_file(cell: &TestCell) -> TestFile {
    TestFile {
        test: cell.test.clone(),
        modes: cell.modes.clone(),
        hz: cell.hz,
        hz_std: cell.hz_std,
        error_percent: cell.error_percent,
        error_hz: cell.error_hz,
        normalised_error: cell.normalised_error,
        damping_ratio: cell.damping_ratio,
        damping_std: cell.damping_std,
        mac: cell.mac,
        basis: cell.basis,
        chance_level: cell.chance_level.map(|level| level.mac),
        angles_deg: cell.angles_deg.clone(),
        status: cell.status,
        judged: (!cell.is_status_certain()).then_some(false),
        reason: (!cell.reasons.is_empty()).then(|| cell.reasons.join("; ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_of_older_file_are_counted_from_its_rows() {
        let cell = |status: &str| {
            serde_json::json!({"test": "t", "modes": [1], "hz": 1.0, "hz_std": null, "error_percent": 0.0,
                "damping_ratio": null, "mac": null, "angles_deg": null, "status": status, "reason": null})
        };
        let row = |label: &str, status: &str| serde_json::json!({"label": label, "theory": null, "tests": [cell(status)]});
        // Files of earlier versions count the ambiguous pair, too.
        let summary = serde_json::json!({"test": "t", "paired": 3, "ambiguous": 1, "missed": 0, "outside_band": 0, "extra": 0,
            "max_error_percent": null, "mean_error_percent": null, "rms_error_percent": null, "min_mac": null, "dofs_used": 0});
        let file = serde_json::json!({"schema": COMPARISON_SCHEMA, "error_reference": "theory",
            "rows": [row("f1", "paired"), row("f2", "ambiguous"), row("f3", "paired")], "summary": {"tests": [summary]}});
        let file = comparison_from_json(&file.to_string()).expect("a file of this schema");
        let summary = &file.summary.tests[0];
        assert_eq!((summary.paired, summary.ambiguous), (2, 1));
    }
}
