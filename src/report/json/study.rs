//! `speed-accuracy.json` and `breakdown.json`: what studies come to, for programs and for the page of a run.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use crate::io::IoError;
use crate::study::breakdown::{OwnMode, SliceResult, Stability};
use crate::study::{SpeedAccuracy, TestStudy, lessons};

use super::super::{Block, Cell, Table, speed_accuracy_blocks, speed_accuracy_table, times_table};
use super::Section;

/// The schema text of a study of speed and accuracy.
pub const SPEED_ACCURACY_SCHEMA: &str = "modalign-speed-accuracy/1";

/// The schema of [`BreakdownFile`].
pub const BREAKDOWN_SCHEMA: &str = "modalign-breakdown/1";

/// The study as JSON: `rows` as `speed-accuracy.csv`, `times` as `speed-accuracy-times.csv`, `tables` as they are printed.
pub fn speed_accuracy_to_json(study: &SpeedAccuracy) -> String {
    let rows = |block: Block| match block {
        Block::Table(table) => rows(&table),
        _ => Value::Null,
    };
    let mut printed = speed_accuracy_blocks(study);
    printed.retain(|block| matches!(block, Block::Table(_)));
    let value = json!({
        "schema": SPEED_ACCURACY_SCHEMA,
        "title": study.title,
        "compared_at_snr_db": study.options.middle_snr_db(),
        "tests": study.tests.iter().map(test).collect::<Vec<_>>(),
        "rows": rows(speed_accuracy_table(study)),
        "times": rows(times_table(study)),
        "lessons": lessons(study),
        "tables": Section::new("methods", printed).blocks,
    });
    format!("{value:#}\n")
}

/// What is known of a test beside its rows. Deviations are rms and relative: no error against the refined solution is known better.
fn test(own: &TestStudy) -> Value {
    let inputs = own.inputs.iter();
    let inputs = inputs.map(|file| json!({"path": file.path, "sha256": file.sha256}));
    json!({
        "name": own.name,
        "inputs": inputs.collect::<Vec<_>>(),
        "functions": own.functions,
        "lines": own.lines,
        "refined_modes": own.refined_modes,
        "refined_frequency_std": own.frequency_std,
        "refined_damping_std": own.damping_std,
        "twin_of_truth": own.twin_of_truth,
        "twin_modes": own.twin_modes,
        "twin_step_hz": own.twin_step_hz,
        "notes": own.notes,
    })
}

/// Each row of a table as an object by the heads of its columns.
fn rows(table: &Table) -> Value {
    let heads = || table.columns.iter().map(|column| column.head.clone());
    let object = |row: &Vec<Cell>| -> Value {
        let pairs: Map<String, Value> = heads().zip(row.iter().map(value)).collect();
        Value::Object(pairs)
    };
    table.rows.iter().map(object).collect()
}

fn value(cell: &Cell) -> Value {
    match cell {
        Cell::Text(text) => json!(text),
        Cell::Number { value, .. } => json!(value),
        Cell::Missing => Value::Null,
    }
}

/// Reads `speed-accuracy.json`.
///
/// # Errors
/// [`IoError::Json`] with the path as given, line and column, or another schema.
pub fn speed_accuracy_from_json(text: &str, path: &str) -> Result<Value, IoError> {
    let value: Value = parsed(text, (path, SPEED_ACCURACY_EXPECTED))?;
    let schema = value["schema"].as_str().unwrap_or_default();
    of_schema(
        schema,
        SPEED_ACCURACY_SCHEMA,
        (path, SPEED_ACCURACY_EXPECTED),
    )?;
    Ok(value)
}

/// `breakdown.json`: all cells and courses, and the modes that are shown in them; no times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BreakdownFile {
    /// [`BREAKDOWN_SCHEMA`].
    pub schema: String,
    /// Title of the scene whose modes are shown; `None` where they are of no scene.
    pub title: Option<String>,
    /// The slices.
    pub slices: Vec<SliceResult>,
    /// The modes that are shown in them.
    pub own_modes: Vec<OwnMode>,
    /// Digits lost by order.
    pub stability: Option<Stability>,
}

/// `breakdown.json`.
pub fn breakdown_to_json(own: &BreakdownFile) -> String {
    serde_json::to_string(own).unwrap_or_default() + "\n"
}

/// Reads `breakdown.json`.
///
/// # Errors
/// [`IoError::Json`] with the path as given, line and column, or another schema.
pub fn breakdown_from_json(text: &str, path: &str) -> Result<BreakdownFile, IoError> {
    let own: BreakdownFile = parsed(text, (path, BREAKDOWN_EXPECTED))?;
    of_schema(&own.schema, BREAKDOWN_SCHEMA, (path, BREAKDOWN_EXPECTED))?;
    Ok(own)
}

const SPEED_ACCURACY_EXPECTED: &str = "schema modalign-speed-accuracy/1";
const BREAKDOWN_EXPECTED: &str = "schema modalign-breakdown/1";

fn parsed<T: for<'a> Deserialize<'a>>(
    text: &str,
    (path, expected): (&str, &'static str),
) -> Result<T, IoError> {
    serde_json::from_str(text).map_err(|error| IoError::Json {
        path: path.to_owned(),
        line: error.line(),
        column: error.column(),
        got: error.to_string(),
        expected,
    })
}

fn of_schema(
    got: &str,
    wanted: &str,
    (path, expected): (&str, &'static str),
) -> Result<(), IoError> {
    match got == wanted {
        true => Ok(()),
        false => Err(IoError::Json {
            path: path.to_owned(),
            line: 1,
            column: 1,
            got: format!("schema {got:?}"),
            expected,
        }),
    }
}
