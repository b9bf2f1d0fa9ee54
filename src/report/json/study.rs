//! `speed-accuracy.json`: the tables of a study as rows of named values, and what they teach.

use serde_json::{Map, Value, json};

use crate::study::{SpeedAccuracy, lessons};

use super::super::{Block, Cell, Table, speed_accuracy_table, times_table};

/// The schema text.
pub const SPEED_ACCURACY_SCHEMA: &str = "modalign-speed-accuracy/1";

/// The study as JSON: `rows` as `speed-accuracy.csv`, `times` as `times.csv`.
pub fn speed_accuracy_to_json(study: &SpeedAccuracy) -> String {
    let rows = |block: Block| match block {
        Block::Table(table) => rows(&table),
        _ => Value::Null,
    };
    let value = json!({
        "schema": SPEED_ACCURACY_SCHEMA,
        "title": study.title,
        "rows": rows(speed_accuracy_table(study)),
        "times": rows(times_table(study)),
        "lessons": lessons(study),
    });
    format!("{value:#}\n")
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
