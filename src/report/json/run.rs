//! `report.json`, schema `modalign-report/1`, holds all contents of the HTML page of a run, from
//! which the page can be rebuilt.

use serde::{Deserialize, Serialize};

use crate::finding::Finding;
use crate::io::IoError;
use crate::printable::printable_json;
use crate::scene::{Figures, Provenance};

use super::super::{Block, Cell};
use super::run_check::{Fault, check_figures, check_hashes, check_table};
use super::schema::{check_schema, parsed};

/// The schema of [`RunReport`].
pub const REPORT_SCHEMA: &str = "modalign-report/1";
/// The file of a folder of results from which its page is built.
pub const REPORT_FILE: &str = "report.json";

const EXPECTED_SCHEMA: &str = "schema modalign-report/1";

/// Tables and figures of a run, in English; pages translate them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunReport {
    /// [`REPORT_SCHEMA`].
    pub schema: String,
    /// Title of the scene.
    pub title: String,
    /// Tables by tab.
    pub sections: Vec<Section>,
    /// Findings by test.
    pub findings: Vec<(String, Vec<Finding>)>,
    /// Stated limits and whether they are met.
    pub limits: Vec<(String, bool)>,
    /// What to do next, as the screen of the run says it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub next: Option<String>,
    /// Figures.
    pub figures: Figures,
    /// Inputs and program version.
    pub provenance: Provenance,
}

/// The blocks of one tab.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Section {
    /// `comparison`, `modes`, `energies`, `published` or `hits`.
    pub id: String,
    /// Its blocks.
    pub blocks: Vec<Block>,
}

impl Section {
    /// Blocks of a tab; numbers that JSON cannot hold stand as text.
    pub fn new(id: &str, mut blocks: Vec<Block>) -> Self {
        for block in &mut blocks {
            let Block::Table(table) = block else { continue };
            for cell in table.rows.iter_mut().flatten() {
                let text = cell.display();
                match cell {
                    Cell::Number { value, .. }
                    | Cell::Correlation { value, .. }
                    | Cell::Normalised(value)
                        if !value.is_finite() =>
                    {
                        *cell = Cell::Text(text);
                    }
                    _ => {}
                }
            }
        }
        Self {
            id: id.to_owned(),
            blocks,
        }
    }
}

/// `report.json`.
pub fn report_to_json(report: &RunReport) -> String {
    printable_json(serde_json::to_string(report).unwrap_or_default()) + "\n"
}

/// Reads `report.json`.
///
/// # Errors
/// [`IoError::Json`] with the path as given, line and column, another schema, or the key of a value
/// that no page can be drawn from.
pub fn report_from_json(text: &str, path: &str) -> Result<RunReport, IoError> {
    let report: RunReport = parsed(text, path, EXPECTED_SCHEMA)?;
    check_schema(&report.schema, path, EXPECTED_SCHEMA)?;
    check(&report).map_err(|fault| IoError::Json {
        path: path.to_owned(),
        line: 1,
        column: 1,
        got: format!("{}: {}", fault.key, fault.got),
        expected: fault.expected,
    })?;
    Ok(report)
}

/// Checks the values that a page is drawn from.
fn check(report: &RunReport) -> Result<(), Fault> {
    for (index, section) in report.sections.iter().enumerate() {
        for (number, block) in section.blocks.iter().enumerate() {
            let Block::Table(table) = block else { continue };
            let key = format!("sections[{index}].blocks[{number}]");
            check_table(table).map_err(|fault| fault.inside(&key))?;
        }
    }
    check_figures(&report.figures)?;
    check_hashes(&report.provenance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Column, Table};
    use crate::scene::StabilizationFigure;
    use serde_json::{Value, json};

    #[test]
    fn report_is_read_as_written() {
        let number = |value| Cell::number(Some(value), 2);
        let table = Table {
            caption: "Modes".to_owned(),
            columns: vec![Column::number("f (Hz)")],
            rows: vec![
                vec![number(1.0 / 3.0)],
                vec![Cell::Missing],
                vec![number(f64::NAN)],
            ],
            footnotes: vec!["as is".to_owned()],
        };
        let report = RunReport {
            schema: REPORT_SCHEMA.to_owned(),
            title: "bar".to_owned(),
            sections: vec![Section::new("modes", vec![Block::Table(table)])],
            findings: Vec::new(),
            limits: vec![("min MAC".to_owned(), false)],
            next: Some("Next, a test.".to_owned()),
            figures: Figures::default(),
            provenance: Provenance::default(),
        };
        let text = report_to_json(&report);
        assert_eq!(report_from_json(&text, "r.json").unwrap(), report);
        let other = text.replace("modalign-report/1", "modalign-report/9");
        let message = report_from_json(&other, "r.json").unwrap_err().to_string();
        assert!(message.contains("modalign-report/9"), "{message}");
        assert!(report_from_json("{", "r.json").is_err());
    }

    /// A report with a value of each kind that is checked.
    fn drawn_report() -> Value {
        let shape = json!({ "hz": 1.0, "re": [1.0, null], "im": [] });
        let hash = "0123456789abcdef".repeat(4);
        let poles = StabilizationFigure {
            order: vec![2, 4],
            hz: vec![1.0, 1.0],
            damping: vec![0.1, 0.1],
            status: vec![0, 2],
            ..StabilizationFigure::default()
        };
        json!({
            "schema": REPORT_SCHEMA,
            "title": "bar",
            "sections": [{ "id": "modes", "blocks": [{ "Table": {
                "caption": "Modes",
                "columns": [{ "head": "f", "align": "Right" }],
                "rows": [
                    [{ "Number": { "value": 1.0, "decimals": 2, "signed": false } }],
                    [{ "Correlation": { "value": 0.5, "decimals": 3 } }],
                ],
                "footnotes": [],
            } }] }],
            "findings": [],
            "limits": [],
            "figures": {
                "overview": null,
                "energies": [],
                "theory": { "nodes": [], "hz": [1.0], "modes": [[]] },
                "tests": [{
                    "name": "hammer", "frf_file": null, "modes": [],
                    "frfs": {
                        "start_hz": 0.0, "step_hz": 1.0, "band_hz": [0.0, 1.0], "functions": 1,
                        "whole_lines": 2, "curves": [{
                            "response": "1:+Z", "reference": "1:+Z", "kind": "receptance",
                            "unit": "m/N", "lines": [0, 1], "magnitude": [1.0, 2.0],
                            "phase_deg": [0.0, 1.0], "fit_magnitude": [null, 1.0],
                            "fit_phase_deg": [null, 1.0], "coherence": [],
                        }],
                    },
                    "stabilization": poles,
                    "circles": [],
                    "mac": {
                        "test_hz": [1.0], "theory_hz": [1.0], "theory_modes": [1], "still": 0,
                        "mac": [[0.9]], "dofs": 2, "pairs": [[0, 0]],
                    },
                    "shapes": {
                        "points": [
                            { "name": "1", "at_m": [0.0, 0.0, 0.0], "body": null },
                            { "name": "2", "at_m": [1.0, 0.0, 0.0], "body": null },
                        ],
                        "in_a_row": false, "not_drawn": 0, "lines": [[0, 1]],
                        "readings": [
                            { "dof": "1:+Z", "point": 0, "direction": [0.0, 0.0, 1.0] },
                            { "dof": "2:+Z", "point": 1, "direction": [0.0, 0.0, 1.0] },
                        ],
                        "test": [shape], "theory": [shape],
                        "partners": [{
                            "modes": [[0, 1.0, 0.0]], "mac": 0.9, "error_percent": 0.1,
                        }],
                    },
                }],
            },
            "provenance": {
                "producer": "modalign", "model": null, "seeds": [], "searched": [],
                "stated": [{ "path": "scene.toml", "sha256": hash, "text": null }],
                "inputs": [["hammer", "hits.uff", hash]],
            },
        })
    }

    #[test]
    fn values_that_no_page_can_be_drawn_from_are_refused_with_their_key() {
        let read = |report: &Value| report_from_json(&report.to_string(), "report.json");
        read(&drawn_report()).unwrap();
        let (table, test) = ("/sections/0/blocks/0/Table", "/figures/tests/0");
        for (path, value, key) in [
            (
                format!("{table}/rows/0/0/Number/decimals"),
                json!(70_000),
                "rows[0].decimals",
            ),
            (
                format!("{table}/rows/1/0/Correlation/decimals"),
                json!(18),
                "rows[1].decimals",
            ),
            (
                format!("{table}/rows/0"),
                json!(["Missing", "Missing"]),
                "rows[0]",
            ),
            (
                format!("{test}/frfs/curves/0/phase_deg"),
                json!([0.0]),
                "frfs.curves.phase_deg",
            ),
            (
                format!("{test}/frfs/curves/0/coherence"),
                json!([1.0]),
                "frfs.curves.coherence",
            ),
            (
                format!("{test}/stabilization/order"),
                json!([2]),
                "stabilization.order",
            ),
            (
                format!("{test}/stabilization/hz"),
                json!([1.0]),
                "stabilization.order",
            ),
            (
                format!("{test}/stabilization/status"),
                json!([0, 3]),
                "stabilization.status",
            ),
            (format!("{test}/mac/mac"), json!([[]]), "mac.mac"),
            (format!("{test}/mac/pairs/0/1"), json!(1), "mac.pairs"),
            (format!("{test}/shapes/lines/0/1"), json!(2), "shapes.lines"),
            (
                format!("{test}/shapes/readings/0/point"),
                json!(100_000_000),
                "readings.point",
            ),
            (
                format!("{test}/shapes/test/0/re"),
                json!([1.0]),
                "shapes.test.re",
            ),
            (
                format!("{test}/shapes/theory/0/im"),
                json!([1.0]),
                "shapes.theory.im",
            ),
            (
                format!("{test}/shapes/partners/0/modes/0/0"),
                json!(1),
                "partners.modes",
            ),
            (
                "/figures/theory/modes".to_owned(),
                json!([[1.0]]),
                "figures.theory.modes",
            ),
            (
                "/provenance/stated/0/sha256".to_owned(),
                json!("<img src=x onerror=alert(1)>"),
                "provenance.stated",
            ),
            (
                "/provenance/inputs/0/2".to_owned(),
                json!(""),
                "provenance.inputs",
            ),
        ] {
            let mut file = drawn_report();
            *file.pointer_mut(&path).unwrap() = value;
            let error = read(&file).unwrap_err().to_string();
            assert!(
                error.starts_with("report.json") && error.contains(key),
                "{path}: {error}"
            );
        }
    }
}
