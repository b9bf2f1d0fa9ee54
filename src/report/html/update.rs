//! The tables of an update, from its `update.json`.

use serde_json::Value;

use super::super::{Block, Cell, Column, Language, Table};
use super::fragment;
use super::summary::short;
use super::words::word;

/// What the data say of a parameter, in a language.
fn verdict(own: Option<&str>, language: Language) -> Cell {
    let known = ["identified", "at bound", "not supported by the data"];
    match known.iter().find(|word| Some(**word) == own) {
        Some(known) => Cell::text(word(language, known)),
        None => own.map_or(Cell::Missing, Cell::text),
    }
}

/// Parameters before and after with their verdicts, frequencies before and after.
pub(super) fn tables(updated: &Value, language: Language) -> String {
    let w = |text| word(language, text);
    let items = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let text = |own: &Value, key: &str| own[key].as_str().map_or(Cell::Missing, Cell::text);
    let number = |own: &Value, key: &str| {
        own[key]
            .as_f64()
            .map_or(Cell::Missing, |v| Cell::text(short(v)))
    };
    let parameter = |own: &Value| {
        let change = own["initial"].as_f64().zip(own["updated"].as_f64());
        let change = change.filter(|(before, _)| *before != 0.0);
        vec![
            text(own, "name"),
            text(own, "unit"),
            number(own, "initial"),
            number(own, "updated"),
            number(own, "std"),
            Cell::signed(
                change.map(|(before, after)| 100.0 * (after / before - 1.0)),
                2,
            ),
            verdict(own["verdict"].as_str(), language),
        ]
    };
    let columns = |texts: &[&'static str], numbers: &[&'static str]| -> Vec<Column> {
        let texts = texts.iter().map(|head| Column::text(w(head)));
        texts
            .chain(numbers.iter().map(|head| Column::number(w(head))))
            .collect()
    };
    let mut of_parameters = columns(
        &["parameter", "unit"],
        &["before", "after", "std", "change (%)"],
    );
    of_parameters.push(Column::text(w("verdict")));
    let before = items(&updated["before"]["rows"]);
    let after = items(&updated["after"]["rows"]);
    let fit = |(before, after): (&Value, &Value)| {
        let value = |own: &Value, key: &str| own[key].as_f64();
        vec![
            text(after, "label"),
            Cell::number(value(after, "test_hz"), 2),
            Cell::number(value(before, "model_hz"), 2),
            Cell::number(value(after, "model_hz"), 2),
            Cell::signed(value(before, "error_percent"), 3),
            Cell::signed(value(after, "error_percent"), 3),
            Cell::number(value(after, "mac"), 3),
        ]
    };
    let mut of_fits = columns(&["mode"], &["test (Hz)"]);
    for when in ["before", "after"] {
        of_fits.push(Column::number(format!("{}\n{}", w("model (Hz)"), w(when))));
    }
    of_fits.extend(columns(
        &[],
        &["error before (%)", "error after (%)", "MAC"],
    ));
    fragment(&[
        Block::Table(Table {
            caption: w("Parameters of the model, updated").to_owned(),
            columns: of_parameters,
            rows: items(&updated["parameters"])
                .iter()
                .map(parameter)
                .collect(),
            footnotes: Vec::new(),
        }),
        Block::Table(Table {
            caption: w("Frequencies before and after").to_owned(),
            columns: of_fits,
            rows: before.iter().zip(&after).map(fit).collect(),
            footnotes: Vec::new(),
        }),
    ])
}
