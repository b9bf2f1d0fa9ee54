//! `report.json`, schema `modalign-report/1`, holds all contents of the HTML page of a run, from
//! which the page can be rebuilt.

use serde::{Deserialize, Serialize};

use crate::finding::Finding;
use crate::io::IoError;
use crate::scene::{Figures, Provenance};

use super::super::{Block, Cell};
use super::schema::{check_schema, parsed};

/// The schema of [`RunReport`].
pub const REPORT_SCHEMA: &str = "modalign-report/1";

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
    serde_json::to_string(report).unwrap_or_default() + "\n"
}

/// Reads `report.json`.
///
/// # Errors
/// [`IoError::Json`] with the path as given, line and column, or another schema.
pub fn report_from_json(text: &str, path: &str) -> Result<RunReport, IoError> {
    let report: RunReport = parsed(text, path, EXPECTED_SCHEMA)?;
    check_schema(&report.schema, path, EXPECTED_SCHEMA)?;
    Ok(report)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Column, Table};

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
}
