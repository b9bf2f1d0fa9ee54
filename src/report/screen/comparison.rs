//! The comparison on the screen: counts and errors by test, and the modes of all tests side by
//! side.

use std::collections::BTreeSet;

use crate::correlate::{
    Basis, ComparisonTable, ErrorReference, Row, Status, TestCell, TestSummary,
};
use crate::report::comparison::label_with_multiplicity;
use crate::report::terminal::table_width;
use crate::report::{Block, Cell, Column, Table};

use super::sentences::unseen_modes;
use super::{MAC_DECIMALS, MAX_ROWS, counted, fitted, without_empty_columns};

/// Maximum number of reasons of unmatched and ambiguous modes of one test on the screen.
const MAX_REASONS: usize = 2;
/// The same of several tests, whose table takes more lines.
const MAX_REASONS_OF_SEVERAL_TESTS: usize = 1;
/// The names of tests in the first column have at most the width of the screen over this.
const SCREEN_OVER_NAME_WIDTH: usize = 5;
/// Width at which the name of a test is wrapped in a head.
const NAME_WIDTH: usize = 10;

/// Counts and errors of every test; the modes with their errors, MAC and verdicts; and why a mode
/// is unmatched or ambiguous.
pub fn comparison_screen(table: &ComparisonTable, width: usize) -> Vec<Block> {
    let mut blocks = Vec::new();
    blocks.extend((table.summary.len() == 1).then(|| counts_block(table, width)));
    blocks.extend(comparison_tables(table, width, MAX_ROWS, usize::MAX));
    blocks.extend(empty_band_block(table));
    let mut last: Vec<String> = unseen_modes("Model modes", table).into_iter().collect();
    last.extend(reasons(table));
    blocks.extend((!last.is_empty()).then(|| Block::Text(last.join("\n"))));
    blocks
}

/// Counts and errors of every test.
pub fn counts_block(table: &ComparisonTable, width: usize) -> Block {
    Block::Table(counts_table(table, width))
}

/// The modes, at most so many and of so many tests, several tests with the counts and errors of
/// each as closing rows; those of every test in a table where tests are omitted.
pub(super) fn comparison_tables(
    table: &ComparisonTable,
    width: usize,
    most: usize,
    most_tests: usize,
) -> Vec<Block> {
    let mut tests: Vec<&str> = table.summary.iter().map(|s| s.test.as_str()).collect();
    let several = tests.len() > 1;
    let omitted = tests.len().saturating_sub(most_tests);
    if omitted > 0 {
        let size = |test: &str| largest_error(table, test).map_or(0.0, |(_, error)| error.abs());
        tests.sort_by(|a, b| size(b).total_cmp(&size(a)));
        tests.truncate(most_tests);
    }
    let mut blocks = Vec::new();
    blocks.extend((omitted > 0).then(|| counts_block(table, width)));
    blocks.extend(no_pair_block(table));
    let form = Form::Screen;
    let tables = ModeTables {
        table,
        width,
        form,
        most,
    };
    let mut tables = tables.of(&tests);
    let has_error = |test: &str| largest_error(table, test).is_some();
    if let ([test], [only], true) = (tests.as_slice(), tables.as_mut_slice(), several)
        && has_error(test)
    {
        only.caption = format!("Modes of {test}, the test with the largest error");
    }
    blocks.extend(tables.into_iter().map(Block::Table));
    let omitted = (omitted > 0).then(|| {
        let tests = counted(omitted, "further test");
        Block::Text(format!("Modes of {tests}: --full."))
    });
    blocks.extend(omitted);
    blocks
}

/// The reason of exit code 1 where no mode of any test is paired.
fn no_pair_block(table: &ComparisonTable) -> Option<Block> {
    let text =
        "No mode of a test has a partner in the model, so that nothing is compared: exit code 1.";
    table.is_empty().then(|| Block::Text(text.to_owned()))
}

/// A warning where no natural frequency of the model lies in the band of any test.
fn empty_band_block(table: &ComparisonTable) -> Option<Block> {
    let theory = table.rows.iter().filter(|row| row.theory.is_some());
    let cells = theory.clone().flat_map(|row| &row.tests);
    let lowest = theory
        .filter_map(|row| Some(row.theory.as_ref()?.hz))
        .reduce(f64::min)?;
    let is_empty = cells
        .into_iter()
        .all(|cell| cell.status == Status::OutsideBand);
    is_empty.then(|| {
        Block::Text(format!(
            "No mode of the model lies in the band of a test; its lowest is at {lowest:.2} Hz. Bands are in Hz."
        ))
    })
}

/// Modes and pairs in numbers, a row for each test.
pub(super) fn counts_table(table: &ComparisonTable, width: usize) -> Table {
    let heads = [
        "model\nmodes",
        "paired",
        "by\nshape",
        "by fre-\nquency",
        "ambi-\nguous",
        "un-\nmatched",
        "not ob-\nservable",
        "unmatched\ntest modes",
        "rms\nerror (%)",
        "largest\nerror (%)",
        "worst\nmode",
        "lowest\nMAC",
    ];
    let row = |summary: &TestSummary| {
        let in_band = modes_in_band(summary);
        let largest = largest_error(table, &summary.test);
        let mut cells = vec![Cell::text(wrapped(
            &summary.test,
            width / SCREEN_OVER_NAME_WIDTH,
        ))];
        cells.extend(
            [
                in_band,
                summary.paired,
                summary.paired_by_shape,
                summary.paired_by_frequency,
                summary.ambiguous,
                summary.missed,
                summary.not_observable,
                summary.extra,
            ]
            .map(|count| Cell::text(count.to_string())),
        );
        cells.extend([
            Cell::number(summary.rms_error_percent, 3),
            Cell::signed(largest.map(|(_, percent)| percent), 3),
            largest.map_or(Cell::Missing, |(label, _)| Cell::text(label)),
            Cell::mac(summary.min_mac, MAC_DECIMALS),
        ]);
        cells
    };
    let columns = std::iter::once(Column::text("test")).chain(heads.map(Column::number));
    let note = "Model modes: those in the band of the test. Errors and MAC: of paired and ambiguous modes.";
    let table = Table {
        columns: columns.collect(),
        rows: table.summary.iter().map(row).collect(),
        footnotes: vec![note.to_owned()],
        ..Table::default()
    };
    let table = without_empty_columns(
        table,
        &[
            "ambi-\nguous",
            "not ob-\nservable",
            "unmatched\ntest modes",
            "lowest\nMAC",
        ],
    );
    let omissible = [
        "by fre-\nquency",
        "worst\nmode",
        "not ob-\nservable",
        "by\nshape",
    ];
    fitted(table, &omissible, width)
}

/// Number of model modes in the band of a test.
pub(super) fn modes_in_band(summary: &TestSummary) -> usize {
    summary.paired + summary.ambiguous + summary.missed + summary.not_observable
}

/// The largest error of a test, percent, with the label of its mode.
fn largest_error<'a>(table: &'a ComparisonTable, test: &str) -> Option<(&'a str, f64)> {
    let error = |row: &'a Row| {
        let cell = row.tests.iter().find(|cell| cell.test == test)?;
        Some((row.label.as_str(), cell.error_percent?))
    };
    let errors = table.rows.iter().filter_map(error);
    errors.max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()))
}

/// Where a table of modes is shown.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Form {
    /// On a screen, which has room for some rows.
    Screen,
    /// On the pages of a document, with all rows; every column has the name of its test.
    Page,
}

/// Tables of modes that fit the width, characters.
pub(super) struct ModeTables<'a> {
    pub(super) table: &'a ComparisonTable,
    pub(super) width: usize,
    pub(super) form: Form,
    /// Maximum number of modes.
    pub(super) most: usize,
}

impl ModeTables<'_> {
    /// One table of all tests with as many columns of each as fit; where the errors alone do not
    /// fit, tables of fewer tests.
    pub(super) fn of(&self, tests: &[&str]) -> Vec<Table> {
        match tests {
            [test] => vec![self.of_one(test)],
            _ => self.of_several(tests),
        }
    }

    fn of_several(&self, tests: &[&str]) -> Vec<Table> {
        let details = [
            &[Detail::Frequency, Detail::Error, Detail::Mac][..],
            &[Detail::Error, Detail::Mac],
            &[Detail::Error],
        ];
        let fits = |details: &&[Detail]| {
            let table = self.side_by_side(tests, details, Form::Screen);
            tests.len() == 1 || table_width(&table) <= self.width
        };
        details.into_iter().find(fits).map_or_else(
            || {
                let (left, right) = tests.split_at(tests.len() / 2);
                let halves = [left, right].into_iter();
                halves
                    .filter(|half| !half.is_empty())
                    .flat_map(|half| self.of_several(half))
                    .collect()
            },
            |details| vec![self.side_by_side(tests, details, self.form)],
        )
    }

    /// The modes of one test: the columns of a comparison in a paper, and the verdict.
    fn of_one(&self, test: &str) -> Table {
        let (shown, omitted) = self.rows(&[test]);
        let row = |row: &&Row| {
            let cell = row.tests.iter().find(|cell| cell.test == test);
            let theory = row.theory.as_ref().map(|theory| theory.hz);
            let mut cells = vec![
                Cell::text(label_with_multiplicity(row)),
                Cell::measured(theory, None),
            ];
            cells.extend(cell.map_or([const { Cell::Missing }; 6], |cell| {
                let percent = |ratio: Option<f64>| ratio.map(|ratio| 100.0 * ratio);
                [
                    Cell::measured(cell.hz, cell.hz_std),
                    Cell::std(cell.hz_std, 0),
                    Cell::signed(cell.error_percent, 3),
                    Cell::damping(percent(cell.damping_ratio), percent(cell.damping_std)),
                    Cell::mac(cell.mac, MAC_DECIMALS),
                    Cell::text(verdict_with_doubt(cell)),
                ]
            }));
            cells
        };
        let numbers = [
            "theory (Hz)",
            "test (Hz)",
            "std (Hz)",
            "error (%)",
            "damping (%)",
            "MAC",
        ];
        let mut columns = vec![Column::text("mode")];
        columns.extend(numbers.map(Column::number));
        columns.push(Column::text("verdict"));
        let table = Table {
            columns,
            rows: shown.iter().map(row).collect(),
            footnotes: std::iter::once(self.error_definition().to_owned())
                .chain(omitted)
                .collect(),
            ..Table::default()
        };
        let table = without_empty_columns(table, &["std (Hz)", "damping (%)", "MAC"]);
        let mut table = fitted(table, &["damping (%)", "std (Hz)"], self.width);
        if table_width(&table) > self.width {
            for cell in table.rows.iter_mut().filter_map(|row| row.last_mut()) {
                if let Cell::Text(verdict) = cell {
                    *verdict = verdict.replace("; ", ";\n");
                }
            }
        }
        table
    }

    fn error_definition(&self) -> &'static str {
        match self.table.error_reference {
            ErrorReference::Theory => "Error = (test - theory)/theory.",
            ErrorReference::Test => "Error = (theory - test)/test.",
        }
    }

    fn side_by_side(&self, tests: &[&str], details: &[Detail], form: Form) -> Table {
        let (shown, omitted) = self.rows(tests);
        let theory_head = match form {
            Form::Screen => "theory\n(Hz)",
            Form::Page => "theory (Hz)",
        };
        let mut columns = vec![Column::text("mode"), Column::number(theory_head)];
        let has_mac = details.contains(&Detail::Mac) && has_macs(&shown, tests);
        let mut closing = closing_labels(has_mac, form);
        let mut rows: Vec<Vec<Cell>> = shown
            .iter()
            .map(|row| {
                let theory = row.theory.as_ref().map(|theory| theory.hz);
                vec![
                    Cell::text(label_with_multiplicity(row)),
                    Cell::measured(theory, None),
                ]
            })
            .collect();
        for test in tests {
            let cells: Vec<Option<&TestCell>> = shown
                .iter()
                .map(|row| row.tests.iter().find(|cell| cell.test == *test))
                .collect();
            let marks = cells.iter().flatten().map(|cell| mark_text(cell));
            let of_pairs = marks.zip(cells.iter().flatten());
            let of_pairs = of_pairs.filter(|(_, cell)| cell.error_percent.is_some());
            let mark_width = of_pairs.map(|(text, _)| text.len()).max().unwrap_or(0);
            let has_mac = cells.iter().flatten().any(|cell| cell.mac.is_some());
            let details = details.iter().filter(|d| has_mac || **d != Detail::Mac);
            for (number, detail) in details.enumerate() {
                let head = match (form, number) {
                    (Form::Page, _) => format!("{test}\n{}", detail.head()),
                    (Form::Screen, 0) => {
                        format!("{}\n{}", wrapped(test, NAME_WIDTH), detail.head())
                    }
                    (Form::Screen, _) => detail.head().to_owned(),
                };
                columns.push(Column::number(head));
                for (row, cell) in rows.iter_mut().zip(&cells) {
                    row.push(cell.map_or(Cell::Missing, |cell| detail.cell(cell, mark_width)));
                }
                let summary = self.table.summary.iter().find(|s| s.test == *test);
                let values = summary.map(|summary| detail.closing(summary, mark_width));
                for (row, value) in closing.iter_mut().zip(values.into_iter().flatten()) {
                    row.push(value);
                }
            }
        }
        rows.extend(closing);
        let cells = shown.iter().flat_map(|row| &row.tests);
        let cells: Vec<&TestCell> = cells.filter(|cell| tests.contains(&&*cell.test)).collect();
        let marks = MARKS
            .iter()
            .filter(|mark| cells.iter().any(|cell| (mark.applies)(cell)));
        let doubts = cells.iter().flat_map(|cell| &cell.doubts);
        let doubts: BTreeSet<String> = doubts.map(|code| code.name()).collect();
        let doubts = doubts.into_iter().collect::<Vec<_>>().join(", ");
        let meanings: Vec<String> = marks
            .map(|mark| match mark.text {
                DOUBTFUL => format!(" {DOUBTFUL}: {} ({doubts}).", mark.meaning),
                text => format!(" {text}: {}.", mark.meaning),
            })
            .collect();
        let is_weak = |cell: &&TestCell| cell.basis == Some(Basis::Frequency) && cell.mac.is_some();
        let weak = match cells.iter().copied().any(|cell| is_weak(&cell)) {
            true => " A MAC beside ~ is of too few DOFs to be evidence.",
            false => "",
        };
        let definitions = format!("{}{}{weak}", self.error_definition(), meanings.concat());
        Table {
            columns,
            rows,
            footnotes: std::iter::once(definitions).chain(omitted).collect(),
            ..Table::default()
        }
    }

    /// The rows with a mode of one of the tests in its band. Of many, those are omitted that say
    /// least, which a sentence counts: not observable modes, then pairs with the smallest errors.
    fn rows(&self, tests: &[&str]) -> (Vec<&Row>, Option<String>) {
        let cells = |row: &Row| -> Vec<f64> {
            let cells = row.tests.iter();
            let cells = cells.filter(|cell| tests.contains(&&*cell.test));
            cells
                .filter(|cell| cell.status != Status::OutsideBand)
                .map(importance)
                .collect()
        };
        let all = self.table.rows.iter();
        let mut all: Vec<(f64, &Row)> = all
            .filter_map(|row| Some((cells(row).into_iter().reduce(f64::max)?, row)))
            .collect();
        let most = self.most;
        let omitted = all.len().saturating_sub(most);
        let mut order: Vec<usize> = (0..all.len()).collect();
        order.sort_by(|&a, &b| all[b].0.total_cmp(&all[a].0));
        let kept: BTreeSet<usize> = order.into_iter().take(most).collect();
        let mut index = 0..;
        all.retain(|_| index.next().is_some_and(|index| kept.contains(&index)));
        let sentence = (omitted > 0).then(|| {
            let modes = counted(omitted, "further mode");
            format!("{modes}, those with the smallest errors first: --full.")
        });
        (all.into_iter().map(|(_, row)| row).collect(), sentence)
    }
}

/// Importance of a cell for a reader: of a pair the magnitude of its error; infinite where the cell
/// says more than an error.
fn importance(cell: &TestCell) -> f64 {
    match cell.status {
        Status::OutsideBand | Status::NotObservable => 0.0,
        Status::Paired => cell.error_percent.map_or(0.0, f64::abs),
        _ => f64::INFINITY,
    }
}

/// Whether a row has a MAC of one of the tests.
fn has_macs(rows: &[&Row], tests: &[&str]) -> bool {
    let mut cells = rows.iter().flat_map(|row| &row.tests);
    cells.any(|cell| tests.contains(&&*cell.test) && cell.mac.is_some())
}

/// The labels of the closing rows with a blank below the frequency of the model: pairs of modes in
/// the band, and rms error with the smallest MAC. Pages have them in the table of counts.
fn closing_labels(has_mac: bool, form: Form) -> Vec<Vec<Cell>> {
    let errors = match has_mac {
        true => "rms, min MAC",
        false => "rms error",
    };
    let labels = match form {
        Form::Screen => &["paired", errors][..],
        Form::Page => &[],
    };
    let row = |label: &&str| vec![Cell::text(*label), Cell::text("")];
    labels.iter().map(row).collect()
}

/// What a table of several tests holds of each.
#[derive(Clone, Copy, PartialEq)]
enum Detail {
    Frequency,
    Error,
    Mac,
}

impl Detail {
    fn head(self) -> &'static str {
        match self {
            Detail::Frequency => "(Hz)",
            Detail::Error => "error (%)",
            Detail::Mac => "MAC",
        }
    }

    /// `mark_width`: characters of the longest marks of a pair of the test.
    fn cell(self, cell: &TestCell, mark_width: usize) -> Cell {
        match self {
            Detail::Frequency => Cell::measured(cell.hz, cell.hz_std),
            Detail::Error => Cell::text(marked_error(cell, mark_width)),
            Detail::Mac => Cell::mac(cell.mac, MAC_DECIMALS),
        }
    }

    /// The values of the closing rows: counts, then errors.
    fn closing(self, summary: &TestSummary, mark_width: usize) -> [Cell; 2] {
        let blank = || Cell::text("");
        // Below the errors, behind which the marks stand.
        let aligned = |text: String| match mark_width {
            0 => Cell::text(text),
            _ => Cell::text(format!("{text} {:mark_width$}", "")),
        };
        match self {
            Detail::Frequency => [blank(), blank()],
            Detail::Error => {
                let rms = Cell::number(summary.rms_error_percent, 3).display();
                let paired = format!("{}/{}", summary.paired, modes_in_band(summary));
                [aligned(paired), aligned(rms)]
            }
            Detail::Mac => [blank(), Cell::mac(summary.min_mac, MAC_DECIMALS)],
        }
    }
}

/// The error of a pair with its marks, or the mark of an unmatched mode.
fn marked_error(cell: &TestCell, mark_width: usize) -> String {
    let text = mark_text(cell);
    let error = Cell::signed(cell.error_percent, 3).display();
    match (cell.error_percent, mark_width) {
        (Some(_), 0) => error,
        (Some(_), _) => format!("{error} {text:<mark_width$}"),
        (None, _) if text.is_empty() => error,
        (None, _) => text,
    }
}

fn mark_text(cell: &TestCell) -> String {
    let marks = MARKS.iter().filter(|mark| (mark.applies)(cell));
    marks.map(|mark| mark.text).collect()
}

/// A mark of a pair, or a word in the place of the error of an unmatched mode.
struct Mark {
    text: &'static str,
    meaning: &'static str,
    applies: fn(&TestCell) -> bool,
}

/// The mark of a doubtful mode.
const DOUBTFUL: &str = "!";

const MARKS: &[Mark] = &[
    Mark {
        text: "~",
        meaning: "paired by frequency alone",
        applies: |cell| cell.basis == Some(Basis::Frequency),
    },
    Mark {
        text: "?",
        meaning: "ambiguous",
        applies: |cell| cell.status == Status::Ambiguous,
    },
    Mark {
        text: DOUBTFUL,
        meaning: "doubtful mode",
        applies: |cell| !cell.doubts.is_empty() && cell.basis.is_some(),
    },
    Mark {
        text: "unmatched",
        meaning: "no partner, should have been seen",
        applies: |cell| cell.status == Status::MissedUnexpected && cell.is_status_certain(),
    },
    Mark {
        text: "unknown",
        meaning: "unmatched, observability unknown",
        applies: |cell| !cell.is_status_certain(),
    },
    Mark {
        text: "near",
        meaning: "unmatched, near a paired mode",
        applies: |cell| cell.status == Status::MissedExpected,
    },
    Mark {
        text: "not obs.",
        meaning: "not observable at these points",
        applies: |cell| cell.status == Status::NotObservable,
    },
    Mark {
        text: "test only",
        meaning: "unmatched test mode",
        applies: |cell| cell.status == Status::Extra,
    },
];

/// The verdict on a mode of one test, and whether the mode itself is doubtful.
fn verdict_with_doubt(cell: &TestCell) -> String {
    match cell.doubts.first() {
        None => verdict(cell).to_owned(),
        Some(code) => format!("{}; doubtful: {}", verdict(cell), code.name()),
    }
}

/// The verdict on a mode of one test.
fn verdict(cell: &TestCell) -> &'static str {
    match (cell.status, cell.basis) {
        (Status::MissedUnexpected, _) if !cell.is_status_certain() => {
            "unmatched, observability unknown"
        }
        (Status::Paired, Some(Basis::Frequency)) => "paired by frequency",
        (Status::Paired, _) => "paired by shape",
        (Status::Ambiguous, _) => "ambiguous",
        (Status::MissedExpected, _) => "near a paired mode",
        (Status::MissedUnexpected, _) => "should have been seen",
        (Status::NotObservable, _) => "not observable",
        (Status::OutsideBand, _) => "outside the band",
        (Status::Extra, _) => "unmatched test mode",
    }
}

/// Why modes are unmatched or ambiguous, the unmatched first.
pub(super) fn reasons(table: &ComparisonTable) -> Vec<String> {
    let of_status = |status: Status| {
        let cells = table
            .rows
            .iter()
            .flat_map(|row| row.tests.iter().map(move |cell| (row, cell)));
        let of_status = cells.filter(move |(_, cell)| cell.status == status);
        of_status.filter_map(|(row, cell)| {
            let reason = cell.reasons.first()?;
            let test = if table.summary.len() > 1 {
                format!(", {}", cell.test)
            } else {
                String::new()
            };
            Some(format!("{}{test}: {reason}.", row.label))
        })
    };
    let statuses = [Status::MissedUnexpected, Status::Extra, Status::Ambiguous];
    let mut all: Vec<String> = statuses.into_iter().flat_map(of_status).collect();
    all.truncate(match table.summary.len() {
        0 | 1 => MAX_REASONS,
        _ => MAX_REASONS_OF_SEVERAL_TESTS,
    });
    all
}

/// A name in lines of at most this width.
fn wrapped(name: &str, width: usize) -> String {
    textwrap::fill(name, width)
}
