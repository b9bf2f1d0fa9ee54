//! The update tab shows the tables of an update, from its `update.json`.

use serde_json::Value;

use super::super::texts::{TEXTS, Text, labels_of, translate};
use super::super::update::MAC_OF_AN_UPDATE;
use super::super::{Block, Cell, Column, Language, Table};
use super::markup::{escape, fragment};
use super::numbers::{four_digits, two_digits};
use crate::scene::Figures;
use crate::update::{StopReason, measured_mode};

/// Maximum number of single parameter changes in the table; `update.json` has all.
const MAX_LISTED_CHANGES: usize = 10;

/// Maximum relative difference of two written values of one test frequency.
const TEST_FREQUENCY_TOLERANCE: f64 = 1e-6;

/// Maximum relative difference of two written values of one model frequency: a comparison states
/// the mean of modes that are repeated within rounding.
const MODEL_FREQUENCY_TOLERANCE: f64 = 1e-3;

/// Whether an update does not explain the test or did not converge.
pub(super) fn has_failed(updated: &Value) -> bool {
    let stopped = stop_reason(updated).is_some_and(|reason| !reason.converged());
    updated["fits"].as_bool() == Some(false) || stopped
}

fn stop_reason(updated: &Value) -> Option<StopReason> {
    serde_json::from_str(&updated["stop_reason"].to_string()).ok()
}

/// Goodness of fit of an update, its frequency errors, and its convergence; `None` without the
/// field `fits`.
pub(super) fn verdict_line(updated: &Value, language: Language) -> Option<String> {
    let fits = updated["fits"].as_bool()?;
    let text = match fits {
        true => &TEXTS.page.update_explains,
        false => &TEXTS.page.update_does_not_explain,
    };
    let number = |value: Option<f64>| match value {
        Some(value) if value < 0.1 => two_digits(value),
        Some(value) => format!("{value:.2}"),
        None => "—".to_owned(),
    };
    let freedom = updated["degrees_of_freedom"].as_f64();
    let expected_maximum = freedom.filter(|nu| *nu > 0.0);
    let expected_maximum = expected_maximum.map(|nu| 1.0 + 2.0 * (2.0 / nu).sqrt());
    let values = [
        number(updated["reduced_chi_square"].as_f64()),
        number(expected_maximum),
    ];
    let mut line = text.filled(language, &values);
    let errors = ["before", "after"].map(|fit| updated[fit]["rms_percent"].as_f64());
    if errors.iter().all(Option::is_some) {
        let text = &TEXTS.page.rms_before_and_after;
        line += &text.filled(language, &errors.map(number));
    }
    if let Some(reason) = stop_reason(updated) {
        let reason = translate(TEXTS.stop_reasons, language, reason.sentence());
        line += &TEXTS.page.further_sentence.filled(language, &[reason]);
    }
    let starts = &updated["starts"];
    if let [Some(count), Some(reached)] = ["count", "reached"].map(|key| starts[key].as_u64()) {
        let text = &TEXTS.page.starts_at_this_optimum;
        line += &text.filled(language, &[reached.to_string(), count.to_string()]);
    }
    Some(line)
}

/// Whether an update can belong to the tests and the model of a run.
///
/// Each row `test f3` of the update has to state the frequency of that test mode, or the mean of a
/// group that begins with it; published frequencies are not checked. Its model frequency before the
/// update has to be one of the run's model, if it lies within their range.
pub(super) fn belongs_to_run(updated: &Value, figures: &Figures) -> bool {
    let rows = updated["before"]["rows"].as_array();
    let model_frequencies = figures.overview.iter().flat_map(|overview| &overview.rows);
    let model_frequencies: Vec<f64> = model_frequencies.filter_map(|row| row.theory_hz).collect();
    let of_model = |hz: f64| {
        let inside = model_frequencies.iter().any(|frequency| *frequency <= hz)
            && model_frequencies.iter().any(|frequency| *frequency >= hz);
        !inside
            || model_frequencies
                .iter()
                .any(|frequency| (frequency - hz).abs() <= MODEL_FREQUENCY_TOLERANCE * hz)
    };
    let others = tests_of_other_configurations(updated);
    let is_other = |row: &Value| {
        let label = row["label"].as_str().unwrap_or_default();
        let test = label.rsplit_once(" f").map(|(test, _)| test);
        test.is_some_and(|test| others.contains(&test))
    };
    let rows = rows.into_iter().flatten().filter(|row| !is_other(row));
    rows.into_iter().all(|row| {
        if row["model_hz"].as_f64().is_some_and(|hz| !of_model(hz)) {
            return false;
        }
        let label = row["label"].as_str().unwrap_or_default();
        let Some((test, number)) = label.rsplit_once(" f") else {
            return true;
        };
        let (Ok(number), Some(hz)) = (number.parse::<usize>(), row["test_hz"].as_f64()) else {
            return true;
        };
        let Some(test) = figures
            .tests
            .iter()
            .find(|candidate| candidate.name == test)
        else {
            return test == "published";
        };
        let mut sum = 0.0;
        let group = test.modes.iter().skip(number.max(1) - 1);
        let mut means = group.zip(1..).map(|(mode, count)| {
            sum += mode.hz;
            sum / f64::from(count)
        });
        means.any(|mean| (mean - hz).abs() <= TEST_FREQUENCY_TOLERANCE * hz)
    })
}

/// Tests of the configurations that a run of the base does not have.
fn tests_of_other_configurations(updated: &Value) -> Vec<&str> {
    let configurations = updated["configurations"].as_array().into_iter().flatten();
    let tests = configurations
        .skip(1)
        .filter_map(|configuration| configuration["tests"].as_array());
    tests.flatten().filter_map(Value::as_str).collect()
}

/// What each configuration contributes to the update.
fn contributions_table(updated: &Value, language: Language) -> Option<Block> {
    let heading = |key: &str| {
        let mut all = TEXTS.headings.iter();
        let found = all.find(|(known, _)| *known == key);
        found.map_or("", |(_, text)| text.in_language(language))
    };
    let configurations = updated["configurations"].as_array()?;
    let row = |configuration: &Value| {
        let count = |key: &str| Cell::number(configuration[key].as_f64(), 0);
        vec![
            configuration["configuration"]
                .as_str()
                .map_or(Cell::Missing, Cell::text),
            count("paired"),
            count("residuals"),
            Cell::number(configuration["chi_square"].as_f64(), 1),
        ]
    };
    let numbers = ["modes", "residual_count"].map(heading);
    let numbers = numbers.into_iter().chain(["χ²"]).map(Column::number);
    Some(Block::Table(Table {
        caption: heading("contribution_of_configurations").to_owned(),
        columns: std::iter::once(Column::text(heading("configuration")))
            .chain(numbers)
            .collect(),
        rows: configurations.iter().map(row).collect(),
        footnotes: Vec::new(),
    }))
}

/// The verdict above the tables of the tab.
pub(super) fn verdict_paragraph(updated: &Value, language: Language) -> String {
    let class = match has_failed(updated) {
        true => "bad",
        false => "good",
    };
    let line = verdict_line(updated, language);
    line.map_or_else(String::new, |line| {
        format!("<p class=\"verdict {class}\">{}</p>\n", escape(&line))
    })
}

/// Identifiable combinations, and the parameter changes that explain the residual, where the update
/// has them.
pub(super) fn identifiability_tables(updated: &Value, language: Language) -> String {
    let texts = &TEXTS.page;
    let w = |text: &'static Text| text.in_language(language);
    let mut blocks: Vec<Block> = contributions_table(updated, language).into_iter().collect();
    let combinations = updated["combinations"].as_array();
    let combinations = combinations.into_iter().flatten();
    let combinations: Vec<Vec<Cell>> = combinations
        .filter_map(|combination| Some(vec![Cell::text(combination["text"].as_str()?)]))
        .collect();
    if !combinations.is_empty() {
        blocks.push(Block::Table(Table {
            caption: w(&texts.identifiable_combinations).to_owned(),
            columns: vec![Column::text(w(&texts.combination))],
            rows: combinations,
            footnotes: Vec::new(),
        }));
    }
    let explanation = &updated["explanation"];
    if explanation.is_object() {
        let single = explanation["single"].as_array();
        let single = single.into_iter().flatten().take(MAX_LISTED_CHANGES);
        let all = std::iter::once(&explanation["none"]).chain(single);
        let columns = [
            w(&texts.rms_error_percent),
            w(&texts.largest_error_percent),
            "χ²",
            "BIC",
        ];
        let proposed = &explanation["proposed"];
        let text = match proposed["explains"].as_bool() == Some(true) {
            true => &texts.smallest_explaining_set,
            false => &texts.no_explaining_set,
        };
        blocks.push(Block::Table(Table {
            caption: w(&texts.single_changes).to_owned(),
            columns: std::iter::once(Column::text(w(&texts.parameter)))
                .chain(columns.map(Column::number))
                .collect(),
            rows: all
                .map(|candidate| change_row(candidate, language))
                .collect(),
            footnotes: vec![text.filled(language, &[parameter_names(proposed, language)])],
        }));
    }
    fragment(&blocks, language)
}

fn parameter_names(candidate: &Value, language: Language) -> String {
    let names = candidate["parameters"].as_array().into_iter().flatten();
    let names: Vec<&str> = names.filter_map(Value::as_str).collect();
    match names.is_empty() {
        true => TEXTS.page.no_change.in_language(language).to_owned(),
        false => names.join(", "),
    }
}

fn change_row(candidate: &Value, language: Language) -> Vec<Cell> {
    let number = |key: &str, decimals| Cell::number(candidate[key].as_f64(), decimals);
    vec![
        Cell::text(parameter_names(candidate, language)),
        number("rms_percent", 3),
        number("largest_percent", 3),
        number("chi_square", 1),
        number("bic", 1),
    ]
}

/// Translated verdict on a parameter; a text that is none stays as it is.
fn verdict_cell(verdict: &Value, language: Language) -> Cell {
    let text = verdict.as_str();
    let translated = text.map(|text| translate(labels_of("verdict"), language, text));
    translated.map_or(Cell::Missing, Cell::text)
}

/// Parameters before and after with their verdicts, frequencies before and after.
pub(super) fn tables(updated: &Value, language: Language) -> String {
    let texts = &TEXTS.page;
    let w = |text: &'static Text| text.in_language(language);
    let items = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let text = |row: &Value, key: &str| row[key].as_str().map_or(Cell::Missing, Cell::text);
    let number = |row: &Value, key: &str| {
        row[key]
            .as_f64()
            .map_or(Cell::Missing, |v| Cell::text(four_digits(v)))
    };
    let parameter = |row: &Value| {
        let change = row["initial"].as_f64().zip(row["updated"].as_f64());
        let change = change.filter(|(before, _)| *before != 0.0);
        vec![
            text(row, "name"),
            text(row, "unit"),
            number(row, "initial"),
            number(row, "updated"),
            number(row, "std"),
            Cell::signed(
                change.map(|(before, after)| 100.0 * (after / before - 1.0)),
                2,
            ),
            verdict_cell(&row["verdict"], language),
        ]
    };
    let columns = |texts: &[&'static Text], numbers: &[&'static Text]| -> Vec<Column> {
        let texts = texts.iter().map(|head| Column::text(w(head)));
        texts
            .chain(numbers.iter().map(|head| Column::number(w(head))))
            .collect()
    };
    let mut of_parameters = columns(
        &[&texts.parameter, &texts.unit],
        &[
            &texts.before,
            &texts.after,
            &texts.std,
            &texts.change_percent,
        ],
    );
    of_parameters.push(Column::text(w(&texts.verdict)));
    let before = items(&updated["before"]["rows"]);
    let after = items(&updated["after"]["rows"]);
    let fit = |(before, after): (&Value, &Value)| {
        let value = |row: &Value, key: &str| row[key].as_f64();
        vec![
            Cell::text(measured_mode(after["label"].as_str().unwrap_or_default())),
            Cell::number(value(after, "test_hz"), 2),
            Cell::number(value(before, "model_hz"), 2),
            Cell::number(value(after, "model_hz"), 2),
            Cell::signed(value(before, "error_percent"), 3),
            Cell::signed(value(after, "error_percent"), 3),
            Cell::number(value(before, "mac"), 3),
            Cell::number(value(after, "mac"), 3),
        ]
    };
    let has_mac = after.iter().any(|row| row["mac"].is_number());
    let macs = has_mac.then(|| language.translated_text(MAC_OF_AN_UPDATE.to_owned()));
    let mut of_fits = columns(&[&texts.mode], &[&texts.test_hz]);
    for when in [&texts.before, &texts.after] {
        let head = format!("{}\n{}", w(&texts.model_hz), w(when));
        of_fits.push(Column::number(head));
    }
    of_fits.extend(columns(
        &[],
        &[
            &texts.error_before_percent,
            &texts.error_after_percent,
            &texts.mac_before,
            &texts.mac_after,
        ],
    ));
    fragment(
        &[
            Block::Table(Table {
                caption: w(&texts.updated_parameters).to_owned(),
                columns: of_parameters,
                rows: items(&updated["parameters"])
                    .iter()
                    .map(parameter)
                    .collect(),
                footnotes: Vec::new(),
            }),
            Block::Table(Table {
                caption: w(&texts.frequencies_before_and_after).to_owned(),
                columns: of_fits,
                rows: before.iter().zip(&after).map(fit).collect(),
                footnotes: macs.into_iter().collect(),
            }),
        ],
        language,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{ModeMark, Overview, OverviewRow, TestFigures};

    fn value(text: &str) -> Value {
        serde_json::from_str(text).unwrap()
    }

    #[test]
    fn the_verdict_states_fit_errors_and_convergence() {
        let updated = value(
            r#"{"fits": false, "reduced_chi_square": 40.0, "degrees_of_freedom": 8.0, "stop_reason": "iteration-limit", "starts": {"count": 5, "reached": 2}, "before": {"rms_percent": 2.934}, "after": {"rms_percent": 0.00112}}"#,
        );
        let line = verdict_line(&updated, Language::English).unwrap();
        for part in [
            "does not explain",
            "40.00",
            "2.00",
            "Not converged",
            "2 of 5",
            "2.93 % before, 0.0011 % after",
        ] {
            assert!(line.contains(part), "{part}: {line}");
        }
        assert!(
            has_failed(&updated)
                && verdict_paragraph(&updated, Language::English).contains("verdict bad")
        );
        assert!(!has_failed(&value(
            r#"{"fits": true, "stop_reason": "no-decrease"}"#
        )));
        assert!(has_failed(&value(
            r#"{"fits": true, "stop_reason": "iteration-limit"}"#
        )));
    }

    #[test]
    fn an_update_of_another_run_is_detected_by_its_frequencies() {
        let mode = |hz| ModeMark {
            hz,
            hz_std: None,
            damping_ratio: None,
            damping_std: None,
            mpc: None,
        };
        let root = |hz| OverviewRow {
            label: String::new(),
            theory_hz: Some(hz),
            multiplicity: 1,
            cells: Vec::new(),
        };
        let figures = Figures {
            overview: Some(Overview {
                tests: Vec::new(),
                of_theory: true,
                rows: vec![root(11.0), root(21.0)],
                stiffness_factor: None,
                error_range: None,
                one_sided: None,
            }),
            tests: vec![TestFigures {
                name: "a f".to_owned(),
                modes: vec![mode(10.0), mode(20.0), mode(20.2)],
                ..TestFigures::default()
            }],
            ..Figures::default()
        };
        let row = |label: &str, hz: f64| {
            let rows = serde_json::json!([{"label": label, "test_hz": hz}]);
            belongs_to_run(&serde_json::json!({"before": {"rows": rows}}), &figures)
        };
        assert!(row("a f f1", 10.0) && row("a f f2", 20.1) && row("published f1", 7.0));
        assert!(!row("a f f1", 10.01) && !row("a f f2", 10.0) && !row("b f1", 10.0));
        assert!(belongs_to_run(&value("{}"), &figures));
        let partner = |hz: f64| {
            let rows = serde_json::json!([{"label": "a f f1", "test_hz": 10.0, "model_hz": hz}]);
            belongs_to_run(&serde_json::json!({"before": {"rows": rows}}), &figures)
        };
        assert!(partner(11.0) && partner(30.0) && !partner(12.0));
        let of_part = |tests: &str| {
            let updated = serde_json::json!({
                "before": {"rows": [{"label": "part f1", "test_hz": 10.0, "model_hz": 12.0}]},
                "configurations": [{"tests": ["a f"]}, {"tests": [tests]}],
            });
            belongs_to_run(&updated, &figures)
        };
        assert!(of_part("part") && !of_part("other"));
    }
}
