//! `speed-accuracy.json`, `breakdown.json` and `order.json`: what studies come to, for programs and
//! for the page of a run.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use crate::io::IoError;
use crate::study::breakdown::{OwnMode, SliceResult, Stability};
use crate::study::{
    LowestOrder, ModeNeeds, OrderTried, ParameterNeeds, SceneNeeds, SpeedAccuracy, TestNeeds,
    TestStudy, TheoryNeeds, answers, lessons,
};

use super::super::{
    Block, Cell, Table, order_blocks, order_table, speed_accuracy_blocks, speed_accuracy_table,
    times_table,
};
use super::Section;

/// The schema text of a study of speed and accuracy.
pub const SPEED_ACCURACY_SCHEMA: &str = "modalign-speed-accuracy/1";

/// The schema text of what a scene needs.
pub const ORDER_SCHEMA: &str = "modalign-order/1";

/// The schema of [`BreakdownFile`].
pub const BREAKDOWN_SCHEMA: &str = "modalign-breakdown/1";

/// What a scene needs as JSON: `rows` as `order.csv`, `tables` as they are printed.
pub fn order_to_json(needs: &SceneNeeds) -> String {
    let mut printed = order_blocks(needs);
    printed.retain(|block| matches!(block, Block::Table(_)));
    let Block::Table(table) = order_table(needs) else {
        return String::new();
    };
    let value = json!({
        "schema": ORDER_SCHEMA,
        "title": needs.title,
        "frequency_percent": needs.options.frequency_percent,
        "damping_percent": needs.options.damping_percent,
        "theory_percent": needs.options.theory_percent,
        "tests": needs.tests.iter().map(test_needs).collect::<Vec<_>>(),
        "failed": needs.failed.iter().map(|(name, reason)| json!({"name": name, "reason": reason})).collect::<Vec<_>>(),
        "theory": needs.theory.as_ref().map_or_else(|reason| json!({"reason": reason}), theory_needs),
        "parameters": needs.parameters.as_ref().map_or_else(|reason| json!({"reason": reason}), parameter_needs),
        "rows": rows(&table),
        "answers": answers(needs),
        "tables": Section::new("order", printed).blocks,
    });
    format!("{value:#}\n")
}

fn test_needs(own: &TestNeeds) -> Value {
    let inputs = own.inputs.iter();
    let inputs = inputs.map(|file| json!({"path": file.path, "sha256": file.sha256}));
    let tried = |own: &OrderTried| json!({"order": own.order, "missed": own.missed, "spurious": own.spurious});
    let order = |own: &LowestOrder| {
        json!({
            "method": own.method,
            "lowest": own.lowest(),
            "own": own.own.as_ref().map(tried),
            "tried": own.tried.iter().map(tried).collect::<Vec<_>>(),
        })
    };
    let mode = |own: &ModeNeeds| {
        let single = own.single.iter().map(|own| {
            json!({
                "method": own.method,
                "frequency_error": own.errors.map(|errors| errors[0]),
                "damping_error": own.errors.map(|errors| errors[1]),
                "enough": own.enough,
            })
        });
        json!({
            "frequency_hz": own.frequency_hz,
            "damping_ratio": own.damping_ratio,
            "simplest": own.simplest(),
            "single": single.collect::<Vec<_>>(),
        })
    };
    json!({
        "name": own.name,
        "inputs": inputs.collect::<Vec<_>>(),
        "synthetic": own.synthetic,
        "band_hz": [own.band.lo_hz, own.band.hi_hz],
        "warnings": own.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "noise_stated": own.support.noise_stated,
        "modes": own.modes,
        "modes_without_damping": own.undamped,
        "identified_roots": own.support.identified,
        "roots_by_bic": own.support.by_bic(),
        "roots_by_prediction": own.support.by_prediction(),
        "roots_by_rest": own.support.by_rest(),
        "functions": own.support.functions,
        "lines": own.support.lines,
        "stretch": own.support.stretch,
        "orders": own.orders.iter().map(order).collect::<Vec<_>>(),
        "single": own.single.iter().map(mode).collect::<Vec<_>>(),
        "notes": own.notes,
    })
}

fn theory_needs(own: &TheoryNeeds) -> Value {
    match own {
        TheoryNeeds::Coordinates {
            model,
            up_to_hz,
            roots,
            simplest,
            needed,
            whole,
        } => json!({
            "model": model,
            "up_to_hz": up_to_hz,
            "roots": roots,
            "simplest": simplest,
            "coordinates": needed,
            "coordinates_of_the_whole": whole,
        }),
        TheoryNeeds::Details {
            model,
            signals,
            whole,
        } => {
            let signals = signals.iter();
            let signals = signals.map(|(name, detail)| json!({"signal": name, "simplest": detail}));
            json!({"model": model, "most_detailed": whole, "signals": signals.collect::<Vec<_>>()})
        }
    }
}

fn parameter_needs(own: &ParameterNeeds) -> Value {
    let [none, needed, all] = own.chi_square;
    json!({
        "free": own.free,
        "needed": own.needed,
        "not_supported": own.not_supported,
        "chi_square": {"none": none, "needed": needed, "all": all},
        "residuals": own.data,
        "explains": own.explains,
    })
}

/// The study as JSON: `rows` as `speed-accuracy.csv`, `times` as `speed-accuracy-times.csv`,
/// `tables` as they are printed.
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

/// What is known of a test beside its rows. Deviations are rms and relative: no error against the
/// refined solution is known better.
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

/// Reads `order.json`.
///
/// # Errors
/// [`IoError::Json`] with the path as given, line and column, or another schema.
pub fn order_from_json(text: &str, path: &str) -> Result<Value, IoError> {
    let value: Value = parsed(text, (path, ORDER_EXPECTED))?;
    let schema = value["schema"].as_str().unwrap_or_default();
    of_schema(schema, ORDER_SCHEMA, (path, ORDER_EXPECTED))?;
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

const ORDER_EXPECTED: &str = "schema modalign-order/1";
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
