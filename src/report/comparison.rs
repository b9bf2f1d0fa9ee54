//! The comparison blocks list the pairs of test and model modes, their frequency errors, MAC and
//! verdicts.

use crate::correlate::{
    Basis, ComparisonTable, ErrorReference, Footnote, Row, Status, TestCell, TestSummary,
};
use crate::scene::{LimitCheck, Theory};
use crate::theory::{ParameterSpec, ParameterStatus};

use super::table::significant;
use super::verdict::Verdict;
use super::{Block, Cell, Column, Table};

/// A group of tests with a comparison table.
#[derive(Clone, Copy, Debug)]
pub struct TableGroup<'a> {
    /// Caption.
    pub caption: &'a str,
    /// Names of its tests, in the order of their columns.
    pub tests: &'a [String],
    /// Further footnotes.
    pub notes: &'a [String],
}

impl<'a> TableGroup<'a> {
    /// The group of all tests.
    pub(super) fn of_all(tests: &'a [String]) -> Self {
        Self {
            caption: "Theory and test compared",
            tests,
            notes: &[],
        }
    }
}

/// The tables of a validation section, their summary, and what the model assumes. One test has all
/// its columns; several in one table have frequency, error and verdict each.
pub fn comparison_blocks(
    table: &ComparisonTable,
    groups: &[TableGroup<'_>],
    theory: &Theory,
) -> Vec<Block> {
    let tables = groups.iter().map(|group| {
        let group_table = TestGroupTable {
            table,
            tests: group.tests.iter().map(String::as_str).collect(),
        };
        let mut table = group_table.table(group.caption, theory);
        table.footnotes.extend_from_slice(group.notes);
        Block::Table(table)
    });
    let mut blocks: Vec<Block> = tables.collect();
    blocks.extend(headlines(table));
    blocks.push(Block::Table(summary_table(table)));
    blocks.extend(parameters_block(&theory.parameters));
    blocks
}

/// The comparison with all tests in one table.
pub fn comparison_of_all_tests(table: &ComparisonTable, theory: &Theory) -> Vec<Block> {
    let tests = all_tests(table);
    comparison_blocks(table, &[TableGroup::of_all(&tests)], theory)
}

/// Names of all tests.
pub(super) fn all_tests(table: &ComparisonTable) -> Vec<String> {
    table.summary.iter().map(|s| s.test.clone()).collect()
}

/// The pairs of every test, a paragraph each.
pub(super) fn headlines(table: &ComparisonTable) -> impl Iterator<Item = Block> {
    let named = table.summary.len() > 1;
    let tests = table.summary.iter();
    tests.map(move |test| Block::Text(headline(test, named)))
}

pub(super) fn error_head(reference: ErrorReference) -> &'static str {
    match reference {
        ErrorReference::Theory => "(test−theory)/theory (%)",
        ErrorReference::Test => "(theory−test)/test (%)",
    }
}

/// `f6`, or `f6 (4-fold)` for a repeated root.
pub(super) fn label_with_multiplicity(row: &Row) -> String {
    match row.theory.as_ref().map_or(1, |theory| theory.modes.len()) {
        1 => row.label.clone(),
        multiplicity => format!("{} ({multiplicity}-fold)", row.label),
    }
}

/// The rows and columns of a group of tests.
struct TestGroupTable<'a> {
    table: &'a ComparisonTable,
    tests: Vec<&'a str>,
}

impl TestGroupTable<'_> {
    fn table(&self, caption: &str, theory: &Theory) -> Table {
        let (rows, outside): (Vec<&Row>, Vec<&Row>) =
            self.rows().partition(|row| !self.is_outside_band(row));
        let mut body: Vec<Vec<Cell>> = rows.iter().map(|row| self.row_cells(row)).collect();
        if !self.is_single_test() {
            body.extend(self.closing_rows());
        }
        let mut footnotes =
            vec!["—: no partner, or unknown. MAC = |a^H b|²/(a^H a · b^H b).".to_owned()];
        let applies = |note: &&Footnote| note.test().is_none_or(|test| self.tests.contains(&test));
        let notes = self.table.footnotes.iter().filter(applies);
        footnotes.extend(notes.map(ToString::to_string));
        if !outside.is_empty() {
            let labels: Vec<&str> = outside.iter().map(|row| row.label.as_str()).collect();
            let labels = labels.join(", ");
            footnotes.push(format!("Outside the band of every test here: {labels}."));
        }
        footnotes.extend(self.reasons(&rows));
        footnotes.extend(theory_sources(theory));
        Table {
            caption: caption.to_owned(),
            columns: self.columns(),
            rows: body,
            footnotes,
        }
    }

    fn is_single_test(&self) -> bool {
        self.tests.len() == 1
    }

    /// Whether any frequency of these tests has a standard deviation, so that its error can be
    /// normalised.
    fn has_normalised_errors(&self) -> bool {
        let mut cells = self.table.rows.iter().flat_map(|row| self.cells(row));
        cells.any(|cell| cell.normalised_error.is_some())
    }

    /// Rows of the model's natural frequencies, and of the unmatched modes of these tests.
    fn rows(&self) -> impl Iterator<Item = &Row> {
        let is_shown = |row: &&Row| row.theory.is_some() || self.cells(row).next().is_some();
        self.table.rows.iter().filter(is_shown)
    }

    fn cells<'r>(&'r self, row: &'r Row) -> impl Iterator<Item = &'r TestCell> {
        let of_these_tests = |cell: &&TestCell| self.tests.contains(&cell.test.as_str());
        row.tests.iter().filter(of_these_tests)
    }

    fn is_outside_band(&self, row: &Row) -> bool {
        self.cells(row)
            .all(|cell| cell.status == Status::OutsideBand)
    }

    fn columns(&self) -> Vec<Column> {
        let head = error_head(self.table.error_reference);
        let mut columns = vec![Column::text("mode"), Column::number("theory (Hz)")];
        if self.is_single_test() {
            columns.extend(["test (Hz)", "std (Hz)", head].map(Column::number));
            if self.has_normalised_errors() {
                columns.push(Column::number("normalised deviation"));
            }
            columns.extend(["damping (%)", "MAC", "chance level"].map(Column::number));
            columns.extend(["basis", "verdict"].map(Column::text));
            return columns;
        }
        for test in &self.tests {
            columns.push(Column::number(format!("{test}\n(Hz)")));
            columns.push(Column::number(format!("{test}\nerror (Hz)")));
            columns.push(Column::number(format!("{test}\nerror (%)")));
            columns.push(Column::text(format!("{test}\nbasis")));
            columns.push(Column::text(format!("{test}\nverdict")));
        }
        columns
    }

    /// The cells of a row for every test; missing where a test has no entry.
    fn row_cells(&self, row: &Row) -> Vec<Cell> {
        let mut cells = vec![
            Cell::text(label_with_multiplicity(row)),
            Cell::number(row.theory.as_ref().map(|theory| theory.hz), 2),
        ];
        let (test_cells, width): (fn(&TestCell) -> Vec<Cell>, usize) =
            match (self.is_single_test(), self.has_normalised_errors()) {
                (true, true) => (normalised_cells, 9),
                (true, false) => (full_cells, 8),
                (false, _) => (short_cells, 5),
            };
        for test in &self.tests {
            let cell = row.tests.iter().find(|cell| cell.test == *test);
            cells.extend(cell.map_or_else(|| vec![Cell::Missing; width], test_cells));
        }
        cells
    }

    /// Largest, mean and root mean square error of every test.
    fn closing_rows(&self) -> [Vec<Cell>; 3] {
        let row = |name: &str, of: fn(&TestSummary) -> [Option<f64>; 2]| {
            let mut cells = vec![Cell::text(name), Cell::Missing];
            for test in &self.tests {
                let summary = self
                    .table
                    .summary
                    .iter()
                    .find(|summary| summary.test == *test);
                let [hz, percent] = summary.map_or([None, None], of);
                cells.extend([
                    Cell::Missing,
                    Cell::number(hz, 2),
                    Cell::number(percent, 3),
                    Cell::Missing,
                    Cell::Missing,
                ]);
            }
            cells
        };
        [
            row("max |error|", |s| [s.max_error_hz, s.max_error_percent]),
            row("mean |error|", |s| [s.mean_error_hz, s.mean_error_percent]),
            row("rms error", |s| [None, s.rms_error_percent]),
        ]
    }

    /// The reasons of the verdicts, each with its test and rows.
    fn reasons(&self, rows: &[&Row]) -> Vec<String> {
        let mut listed_reasons: Vec<(&str, &str, Vec<&str>)> = Vec::new();
        for row in rows {
            for cell in self.cells(row) {
                for reason in &cell.reasons {
                    let entry = listed_reasons
                        .iter_mut()
                        .find(|(test, listed, _)| *test == cell.test && listed == reason);
                    match entry {
                        Some((_, _, labels)) => labels.push(&row.label),
                        None => listed_reasons.push((&cell.test, reason, vec![&row.label])),
                    }
                }
            }
        }
        let line = |(test, reason, labels): (&str, &str, Vec<&str>)| {
            format!("{}, {test}: {reason}.", labels.join(" "))
        };
        listed_reasons.into_iter().map(line).collect()
    }
}

/// Whether a parameter differs from its nominal value, to which its status refers.
fn is_set(spec: &ParameterSpec, value: f64) -> bool {
    value.to_bits() != spec.nominal.to_bits()
}

/// Footnotes on the sources of the theory: parameters by status, and assumptions.
pub(super) fn theory_sources(theory: &Theory) -> Vec<String> {
    let named = |of: &dyn Fn(&ParameterSpec, bool) -> bool| -> Vec<&str> {
        let parameters = theory.parameters.iter();
        parameters
            .filter(|(spec, value)| of(spec, is_set(spec, *value)))
            .map(|(spec, _)| spec.name.as_str())
            .collect()
    };
    let nominal = |status| named(&|spec, set| spec.status == status && !set);
    let mut notes = Vec::new();
    if !theory.parameters.is_empty() {
        let list = |names: Vec<&str>| match names.as_slice() {
            [] => "none".to_owned(),
            _ => names.join(", "),
        };
        notes.push(format!(
            "Parameters of the theory: {} printed; inferred: {}; assumed: {}.",
            nominal(ParameterStatus::Printed).len(),
            list(nominal(ParameterStatus::Inferred)),
            list(nominal(ParameterStatus::Assumed)),
        ));
        let set = named(&|_, set| set);
        if !set.is_empty() {
            notes.push(format!(
                "Set to other values than those: {}.",
                set.join(", ")
            ));
        }
    }
    let assumptions = theory.assumptions.iter();
    notes.extend(assumptions.map(|a| format!("Assumed, {}: {}.", a.about, a.statement)));
    notes
}

fn full_cells(cell: &TestCell) -> Vec<Cell> {
    vec![
        Cell::number(cell.hz, 2),
        Cell::std(cell.hz_std, 3),
        Cell::signed(cell.error_percent, 3),
        Cell::number(cell.damping_ratio.map(|zeta| 100.0 * zeta), 3),
        Cell::mac(cell.mac, 4),
        Cell::number(cell.chance_level.map(|level| level.mac), 3),
        basis_cell(cell),
        Cell::text(verdict(cell).text()),
    ]
}

fn normalised_cells(cell: &TestCell) -> Vec<Cell> {
    let mut cells = full_cells(cell);
    cells.insert(
        3,
        cell.normalised_error
            .map_or(Cell::Missing, Cell::Normalised),
    );
    cells
}

fn short_cells(cell: &TestCell) -> Vec<Cell> {
    vec![
        Cell::number(cell.hz, 2),
        Cell::signed(cell.error_hz, 2),
        Cell::signed(cell.error_percent, 3),
        basis_cell(cell),
        Cell::text(verdict(cell).text()),
    ]
}

/// The evidence of a pair, in the words of `comparison.json`; missing without a partner.
fn basis_cell(cell: &TestCell) -> Cell {
    cell.basis.map_or(Cell::Missing, |basis| {
        Cell::text(match basis {
            Basis::Shape => "shape",
            Basis::Frequency => "frequency",
        })
    })
}

/// The verdict on a pair. `comparison.json` keeps shorter codes, and states in `judged` whether
/// the observability of an unmatched mode is known.
fn verdict(cell: &TestCell) -> Verdict {
    match cell.status {
        _ if !cell.is_status_certain() => Verdict::UnmatchedUnknown,
        Status::Paired => Verdict::Paired,
        Status::Ambiguous => Verdict::Ambiguous,
        Status::MissedExpected => Verdict::UnmatchedNearPair,
        Status::MissedUnexpected => Verdict::UnmatchedObservable,
        Status::NotObservable => Verdict::NotObservable,
        Status::OutsideBand => Verdict::OutsideBand,
        Status::Extra => Verdict::UnmatchedTestMode,
    }
}

/// Pairs of a test by the evidence on which they rest: `12 paired: 9 by shape, 3 by frequency
/// alone; 2 ambiguous`.
pub(super) fn headline(test: &TestSummary, named: bool) -> String {
    let name = if named {
        format!("{}: ", test.test)
    } else {
        String::new()
    };
    let (shape, frequency) = (test.paired_by_shape, test.paired_by_frequency);
    let ambiguous = match test.ambiguous {
        0 => String::new(),
        count => format!("; {count} ambiguous"),
    };
    let all = shape + frequency;
    format!("{name}{all} paired: {shape} by shape, {frequency} by frequency alone{ambiguous}")
}

fn summary_table(table: &ComparisonTable) -> Table {
    let heads = [
        "paired",
        "by shape",
        "by frequency alone",
        "missed",
        "not observable",
        "unmatched test modes",
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
            count(summary.paired_by_shape),
            count(summary.paired_by_frequency),
            count(summary.missed),
            count(summary.not_observable),
            count(summary.extra),
            count(summary.ambiguous),
            Cell::number(summary.max_error_percent, 3),
            Cell::number(summary.mean_error_percent, 3),
            Cell::number(summary.rms_error_percent, 3),
            Cell::mac(summary.min_mac, 4),
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

/// Printed digits of a parameter: the stated value has fewer, an updated one more.
const MAX_PARAMETER_DIGITS: usize = 8;

/// The model's parameters with the values used and their sources; `None` for a model without
/// parameters.
pub fn parameters_block(parameters: &[(ParameterSpec, f64)]) -> Option<Block> {
    let status = |status: ParameterStatus| match status {
        ParameterStatus::Printed => "printed",
        ParameterStatus::Inferred => "inferred",
        ParameterStatus::Assumed => "assumed",
    };
    let row = |(spec, value): &(ParameterSpec, f64)| {
        vec![
            Cell::text(&spec.name),
            Cell::text(significant(*value, MAX_PARAMETER_DIGITS)),
            Cell::text(&spec.unit),
            Cell::text(if is_set(spec, *value) {
                format!(
                    "set ({} {})",
                    status(spec.status),
                    significant(spec.nominal, MAX_PARAMETER_DIGITS)
                )
            } else {
                status(spec.status).to_owned()
            }),
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
            Cell::text(Verdict::of_limit(check.is_met()).text()),
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
