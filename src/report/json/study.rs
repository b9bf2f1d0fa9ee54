//! `speed-accuracy.json`, `breakdown.json` and `order.json` hold the results of studies.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use crate::io::IoError;
use crate::printable::printable_json;
use crate::study::breakdown::{SliceResult, Stability, UserMode, breakdown_verdict};
use crate::study::{
    LowestOrder, ModeNeeds, ParameterNeeds, SceneNeeds, SpeedAccuracy, TestNeeds, TestStudy,
    TheoryNeeds, TriedOrder, method_sentences, method_verdicts, recommendations, summarise_needs,
};

use super::super::{
    Block, Cell, Table, order_blocks, order_table, speed_accuracy_blocks, speed_accuracy_table,
    times_table,
};
use super::Section;
use super::schema::{check_schema, parsed};

/// The schema of a study of speed and accuracy.
pub const SPEED_ACCURACY_SCHEMA: &str = "modalign-speed-accuracy/1";

/// The schema of a study of model orders.
pub const ORDER_SCHEMA: &str = "modalign-order/1";

/// The schema of [`BreakdownFile`].
pub const BREAKDOWN_SCHEMA: &str = "modalign-breakdown/1";

/// A study of model orders as JSON: `rows` as `order.csv`, `tables` as they are printed.
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
        "verdict": method_sentences(needs),
        "answers": summarise_needs(needs),
        "tables": Section::new("order", printed).blocks,
    });
    format!("{value:#}\n")
}

fn test_needs(test_needs: &TestNeeds) -> Value {
    let inputs = test_needs.inputs.iter();
    let inputs = inputs.map(|file| json!({"path": file.path, "sha256": file.sha256}));
    let tried = |tried: &TriedOrder| json!({"order": tried.order, "missed": tried.missed, "spurious": tried.spurious});
    let order = |method: &LowestOrder| {
        json!({
            "method": method.method,
            "lowest": method.lowest(),
            "own": method.chosen.as_ref().map(tried),
            "tried": method.tried.iter().map(tried).collect::<Vec<_>>(),
        })
    };
    let mode = |mode: &ModeNeeds| {
        let single = mode.single.iter().map(|single| {
            json!({
                "method": single.method,
                "frequency_error": single.errors.map(|errors| errors[0]),
                "damping_error": single.errors.map(|errors| errors[1]),
                "enough": single.is_sufficient,
            })
        });
        json!({
            "frequency_hz": mode.frequency_hz,
            "damping_ratio": mode.damping_ratio,
            "simplest": mode.simplest(),
            "single": single.collect::<Vec<_>>(),
        })
    };
    json!({
        "name": test_needs.name,
        "inputs": inputs.collect::<Vec<_>>(),
        "synthetic": test_needs.synthetic,
        "band_hz": [test_needs.band.lo_hz, test_needs.band.hi_hz],
        "warnings": test_needs.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "noise_stated": test_needs.support.noise_stated,
        "modes": test_needs.modes,
        "modes_without_damping": test_needs.undamped,
        "identified_roots": test_needs.support.identified,
        "roots_by_bic": test_needs.support.by_bic(),
        "roots_by_prediction": test_needs.support.by_prediction(),
        "roots_by_rest": test_needs.support.by_residual(),
        "functions": test_needs.support.functions,
        "lines": test_needs.support.lines,
        "stretch": test_needs.support.segment_lines,
        "orders": test_needs.orders.iter().map(order).collect::<Vec<_>>(),
        "single": test_needs.single.iter().map(mode).collect::<Vec<_>>(),
        "notes": test_needs.notes,
    })
}

fn theory_needs(theory_needs: &TheoryNeeds) -> Value {
    match theory_needs {
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

fn parameter_needs(parameter_needs: &ParameterNeeds) -> Value {
    let [none, needed, all] = parameter_needs.chi_square;
    json!({
        "free": parameter_needs.free,
        "needed": parameter_needs.needed,
        "not_supported": parameter_needs.not_supported,
        "chi_square": {"none": none, "needed": needed, "all": all},
        "residuals": parameter_needs.data,
        "explains": parameter_needs.explains,
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
        "verdict": method_verdicts(study),
        "lessons": recommendations(study),
        "tables": Section::new("methods", printed).blocks,
    });
    format!("{value:#}\n")
}

/// Properties of a test. Standard deviations are rms and relative; they limit the accuracy of
/// errors against the refined solution.
fn test(study: &TestStudy) -> Value {
    let inputs = study.inputs.iter();
    let inputs = inputs.map(|file| json!({"path": file.path, "sha256": file.sha256}));
    json!({
        "name": study.name,
        "inputs": inputs.collect::<Vec<_>>(),
        "functions": study.functions,
        "lines": study.lines,
        "refined_modes": study.refined_modes,
        "refined_frequency_std": study.frequency_std,
        "refined_damping_std": study.damping_std,
        "twin_of_truth": study.twin_of_truth,
        "twin_modes": study.twin_modes,
        "twin_step_hz": study.twin_step_hz,
        "notes": study.notes,
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
        Cell::Number { value, .. } | Cell::Correlation { value, .. } | Cell::Normalised(value) => {
            json!(value)
        }
        Cell::Missing => Value::Null,
    }
}

/// Reads `speed-accuracy.json`.
///
/// # Errors
/// [`IoError::Json`] with the path as given, line and column, or another schema.
pub fn speed_accuracy_from_json(text: &str, path: &str) -> Result<Value, IoError> {
    let value: Value = parsed(text, path, SPEED_ACCURACY_EXPECTED)?;
    let schema = value["schema"].as_str().unwrap_or_default();
    check_schema(schema, path, SPEED_ACCURACY_EXPECTED)?;
    Ok(value)
}

/// Reads `order.json`.
///
/// # Errors
/// [`IoError::Json`] with the path as given, line and column, or another schema.
pub fn order_from_json(text: &str, path: &str) -> Result<Value, IoError> {
    let value: Value = parsed(text, path, ORDER_EXPECTED)?;
    let schema = value["schema"].as_str().unwrap_or_default();
    check_schema(schema, path, ORDER_EXPECTED)?;
    Ok(value)
}

/// `breakdown.json`: all cells, stability curves and user modes; no times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BreakdownFile {
    /// [`BREAKDOWN_SCHEMA`].
    pub schema: String,
    /// Title of the scene whose modes are shown; `None` where they are of no scene.
    pub title: Option<String>,
    /// The slices.
    pub slices: Vec<SliceResult>,
    /// The modes that are shown in them.
    #[serde(rename = "own_modes")]
    pub user_modes: Vec<UserMode>,
    /// Digits lost by order.
    pub stability: Option<Stability>,
}

/// `breakdown.json`, with the verdict that follows from the cells.
pub fn breakdown_to_json(file: &BreakdownFile) -> String {
    #[derive(Serialize)]
    struct Written<'f> {
        #[serde(flatten)]
        file: &'f BreakdownFile,
        verdict: Vec<String>,
    }
    let verdict = breakdown_verdict(&file.slices, &file.user_modes);
    let written = Written {
        file,
        verdict: verdict.into_iter().collect(),
    };
    printable_json(serde_json::to_string(&written).unwrap_or_default()) + "\n"
}

/// Reads `breakdown.json`.
///
/// # Errors
/// [`IoError::Json`] with the path as given, line and column, or another schema.
pub fn breakdown_from_json(text: &str, path: &str) -> Result<BreakdownFile, IoError> {
    let file: BreakdownFile = parsed(text, path, BREAKDOWN_EXPECTED)?;
    check_schema(&file.schema, path, BREAKDOWN_EXPECTED)?;
    Ok(file)
}

const ORDER_EXPECTED: &str = "schema modalign-order/1";
const SPEED_ACCURACY_EXPECTED: &str = "schema modalign-speed-accuracy/1";
const BREAKDOWN_EXPECTED: &str = "schema modalign-breakdown/1";
