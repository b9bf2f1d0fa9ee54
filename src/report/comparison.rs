//! The comparison table as blocks.

use crate::correlate::{ComparisonTable, ErrorReference, Row, Status, TestCell, TestSummary};
use crate::scene::{LimitCheck, Theory};
use crate::theory::{ParameterSpec, ParameterStatus};

use super::{Block, Cell, Column, Table};

/// The table of a validation section, its summary, and what the model assumes.
pub fn comparison_blocks(
    table: &ComparisonTable,
    caption: Option<&str>,
    theory: &Theory,
) -> Vec<Block> {
    let mut blocks = vec![
        Block::Table(comparison_table(table, caption, theory)),
        Block::Table(summary_table(table)),
    ];
    blocks.extend(parameters_block(&theory.parameters));
    blocks
}

/// Columns of one test.
const TEST_COLUMNS: usize = 6;

fn error_head(reference: ErrorReference) -> &'static str {
    match reference {
        ErrorReference::Theory => "(test−theory)/theory (%)",
        ErrorReference::Test => "(theory−test)/test (%)",
    }
}

fn comparison_table(table: &ComparisonTable, caption: Option<&str>, theory: &Theory) -> Table {
    let tests: Vec<&str> = table
        .summary
        .iter()
        .map(|summary| summary.test.as_str())
        .collect();
    let prefix = |test: &str| {
        if tests.len() > 1 {
            format!("{test}: ")
        } else {
            String::new()
        }
    };
    let mut columns = vec![Column::text("mode"), Column::number("theory (Hz)")];
    for test in &tests {
        let name = prefix(test);
        columns.push(Column::number(format!("{name}test (Hz)")));
        columns.push(Column::number(format!("{name}std (Hz)")));
        columns.push(Column::number(format!(
            "{name}{}",
            error_head(table.error_reference)
        )));
        columns.push(Column::number(format!("{name}damping (%)")));
        columns.push(Column::number(format!("{name}MAC")));
        columns.push(Column::text(format!("{name}verdict")));
    }
    let mut footnotes =
        vec!["—: no partner, or not known. MAC = |a^H b|²/(a^H a · b^H b).".to_owned()];
    footnotes.extend(table.footnotes.iter().map(ToString::to_string));
    footnotes.extend(reasons(table));
    footnotes.extend(
        theory
            .assumptions
            .iter()
            .map(|a| format!("Assumed, {}: {}.", a.about, a.statement)),
    );
    Table {
        caption: caption.map_or_else(|| "Theory and test compared".to_owned(), str::to_owned),
        columns,
        rows: table
            .rows
            .iter()
            .map(|row| row_cells(row, &tests))
            .collect(),
        footnotes,
    }
}

/// A cell for every test, empty where the row has none of it.
fn row_cells(row: &Row, tests: &[&str]) -> Vec<Cell> {
    let multiplicity = row.theory.as_ref().map_or(1, |theory| theory.modes.len());
    let label = if multiplicity > 1 {
        format!("{} ({multiplicity}-fold)", row.label)
    } else {
        row.label.clone()
    };
    let mut cells = vec![
        Cell::text(label),
        Cell::number(row.theory.as_ref().map(|theory| theory.hz), 2),
    ];
    for test in tests {
        let own = row.tests.iter().find(|cell| cell.test == *test);
        cells.extend(own.map_or_else(|| vec![Cell::Missing; TEST_COLUMNS], test_cells));
    }
    cells
}

fn test_cells(cell: &TestCell) -> Vec<Cell> {
    vec![
        Cell::number(cell.hz, 2),
        Cell::number(cell.hz_std, 3),
        Cell::signed(cell.error_percent, 3),
        Cell::number(cell.damping_ratio.map(|zeta| 100.0 * zeta), 3),
        Cell::number(cell.mac, 4),
        Cell::text(status_text(cell.status)),
    ]
}

/// The verdict as printed; the same words as in `comparison.json`.
fn status_text(status: Status) -> &'static str {
    match status {
        Status::Paired => "paired",
        Status::Ambiguous => "ambiguous",
        Status::MissedExpected => "missed-expected",
        Status::MissedUnexpected => "missed-unexpected",
        Status::NotObservable => "not-observable",
        Status::OutsideBand => "outside-band",
        Status::Extra => "extra",
    }
}

/// One line for each row whose verdict has a reason.
fn reasons(table: &ComparisonTable) -> Vec<String> {
    let of_row = |row: &Row| {
        let label = row.label.clone();
        let told = row.tests.iter().filter_map(move |cell| {
            let reason = cell.reason.as_ref()?;
            Some(format!("{label}, {}: {reason}.", cell.test))
        });
        told.collect::<Vec<_>>()
    };
    table.rows.iter().flat_map(of_row).collect()
}

fn summary_table(table: &ComparisonTable) -> Table {
    let heads = [
        "paired",
        "missed",
        "extra",
        "ambiguous",
        "max |error| (%)",
        "mean |error| (%)",
        "rms error (%)",
        "min MAC",
        "DOFs used",
    ];
    let count = |n: usize| Cell::text(n.to_string());
    let row = |summary: &TestSummary| {
        vec![
            Cell::text(&summary.test),
            count(summary.paired),
            count(summary.missed),
            count(summary.extra),
            count(summary.ambiguous),
            Cell::number(summary.max_error_percent, 3),
            Cell::number(summary.mean_error_percent, 3),
            Cell::number(summary.rms_error_percent, 3),
            Cell::number(summary.min_mac, 4),
            count(summary.dofs_used),
        ]
    };
    Table {
        caption: "Summary".to_owned(),
        columns: std::iter::once(Column::text("test"))
            .chain(heads.map(Column::number))
            .collect(),
        rows: table.summary.iter().map(row).collect(),
        footnotes: Vec::new(),
    }
}

/// The model's parameters with the values used and where they come from; `None` for a model without any.
pub fn parameters_block(parameters: &[(ParameterSpec, f64)]) -> Option<Block> {
    let status = |status: ParameterStatus| match status {
        ParameterStatus::Printed => "printed",
        ParameterStatus::Inferred => "inferred",
        ParameterStatus::Assumed => "assumed",
    };
    let row = |(spec, value): &(ParameterSpec, f64)| {
        vec![
            Cell::text(&spec.name),
            Cell::text(plain(*value)),
            Cell::text(&spec.unit),
            Cell::text(status(spec.status)),
        ]
    };
    (!parameters.is_empty()).then(|| {
        Block::Table(Table {
            caption: "Parameters of the model".to_owned(),
            columns: vec![
                Column::text("name"),
                Column::number("value"),
                Column::text("unit"),
                Column::text("status"),
            ],
            rows: parameters.iter().map(row).collect(),
            footnotes: Vec::new(),
        })
    })
}

/// As short as it is exact: plain between 0.001 and a million, else with an exponent.
fn plain(value: f64) -> String {
    let plain = value == 0.0 || (1e-3..1e6).contains(&value.abs());
    if plain {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

/// The limits and whether each is met; `None` when there is none.
pub fn limits_block(checks: &[LimitCheck]) -> Option<Block> {
    let row = |check: &LimitCheck| {
        vec![
            Cell::text(&check.what),
            check.value.map_or(Cell::Missing, |value| {
                // A count is a whole number.
                let decimals = if value.fract().abs() < f64::EPSILON {
                    0
                } else {
                    4
                };
                Cell::number(Some(value), decimals)
            }),
            Cell::text(format!(
                "{} {}",
                if check.upper { "at most" } else { "at least" },
                check.limit
            )),
            Cell::text(if check.met() { "met" } else { "MISSED" }),
        ]
    };
    (!checks.is_empty()).then(|| {
        Block::Table(Table {
            caption: "Limits".to_owned(),
            columns: vec![
                Column::text("what"),
                Column::number("value"),
                Column::text("limit"),
                Column::text("verdict"),
            ],
            rows: checks.iter().map(row).collect(),
            footnotes: Vec::new(),
        })
    })
}
