//! The comparison table has one row for each root of the theory and one cell for each test, as in
//! `comparison.json`.
//!
//! Missing numbers are `None`; the report formats the numbers.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use crate::linalg::sort_ascending_by;
use crate::modal::ModalModel;

use super::footnote::{Footnote, footnotes};
use super::model_roots::{Root, check_model, elastic_roots};
use super::table_cell::{TestColumn, mean};
use super::table_row::{PairedTest, Row, Status, TestCell, TheoryCell};
use super::{Basis, CorrelateError, ErrorReference, PairOptions};

/// One theory against one or more tests.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparisonTable {
    /// Reference of the relative errors.
    pub error_reference: ErrorReference,
    /// Rows `f1, f2, ...` of the theory's elastic roots by frequency, then `x1, x2, ...` of test
    /// modes without a partner.
    pub rows: Vec<Row>,
    /// One summary for each test, in their order.
    pub summary: Vec<TestSummary>,
    /// Smallest number of degrees of freedom that a test's MAC rests on; 0 when one has no shapes
    /// in common.
    pub dofs_used: usize,
    /// Footnotes of the table.
    pub footnotes: Vec<Footnote>,
}

/// Summary of one test; also an entry of `summary.tests` in `comparison.json`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct TestSummary {
    /// Name of the test.
    pub test: String,
    /// Roots that are paired, by shape and by frequency, without the ambiguous ones.
    pub paired: usize,
    /// Roots that are paired by frequency and shape.
    #[serde(default)]
    pub paired_by_shape: usize,
    /// Roots that are paired by frequency alone.
    #[serde(default)]
    pub paired_by_frequency: usize,
    /// Roots with an ambiguous partner, in addition to the paired ones.
    pub ambiguous: usize,
    /// Ambiguous roots whose MAC is below the chance level for independent shapes.
    #[serde(default)]
    pub uncorrelated: usize,
    /// Roots without a partner inside the band, without those that were not observable.
    pub missed: usize,
    /// Missed roots of unknown observability.
    #[serde(default)]
    pub not_judged: usize,
    /// Roots without a partner inside the band that were not observable.
    #[serde(default)]
    pub not_observable: usize,
    /// Roots without a partner outside the band.
    pub outside_band: usize,
    /// Test modes without a partner.
    pub extra: usize,
    /// Largest |frequency error| over the paired and the ambiguous roots, Hz.
    #[serde(default)]
    pub max_error_hz: Option<f64>,
    /// Mean |frequency error|, Hz.
    #[serde(default)]
    pub mean_error_hz: Option<f64>,
    /// Largest |frequency error| over the paired and the ambiguous roots, percent.
    pub max_error_percent: Option<f64>,
    /// Mean |frequency error|, percent.
    pub mean_error_percent: Option<f64>,
    /// Root mean square of the frequency error, percent.
    pub rms_error_percent: Option<f64>,
    /// Smallest MAC of a pair, ambiguous ones included.
    pub min_mac: Option<f64>,
    /// Degrees of freedom that the MAC rests on.
    pub dofs_used: usize,
}

/// The table of one theory and several tests that were paired with it.
///
/// A root without a partner is, in this order:
///
/// - `outside-band` when the test states a band that does not contain it;
/// - `not-observable` when [`super::observability`] says that the test could not have detected it;
/// - `missed-expected` when a paired root lies within one half-power bandwidth `2 zeta f` of it,
///   whose peak covers both (also when the noise is not known: the root is then not observable or
///   covered);
/// - `missed-unexpected` else; [`TestCell::is_status_certain`] says whether the observability is
///   known.
///
/// # Errors
/// [`CorrelateError::Option`], [`CorrelateError::Frequency`], [`CorrelateError::ShapeValue`],
/// [`CorrelateError::DuplicateTest`], [`CorrelateError::OtherPairing`].
pub fn compare(
    theory: &ModalModel,
    tests: &[PairedTest<'_>],
    options: &PairOptions,
) -> Result<ComparisonTable, CorrelateError> {
    check_tests(theory, tests, options)?;
    let roots = elastic_roots(theory);
    let reference = options.error_reference;
    let column = |test| TestColumn::new(theory, test, &roots);
    let columns: Vec<TestColumn<'_>> = tests.iter().map(column).collect();
    let row = |(number, root): (usize, &Root)| Row {
        label: format!("f{}", number + 1),
        theory: Some(TheoryCell {
            modes: root.modes.iter().map(|j| j + 1).collect(),
            hz: root.hz,
        }),
        tests: columns
            .iter()
            .map(|column| column.cell(number, options))
            .collect(),
    };
    let mut rows: Vec<Row> = roots.iter().enumerate().map(row).collect();
    rows.extend(extra_rows(tests));
    let of_test = |test: &PairedTest<'_>| summarise(test, &rows);
    Ok(ComparisonTable {
        error_reference: reference,
        summary: tests.iter().map(of_test).collect(),
        dofs_used: tests.iter().map(|t| t.pairing.map.len()).min().unwrap_or(0),
        footnotes: footnotes(tests, &rows, reference),
        rows,
    })
}

fn check_tests(
    theory: &ModalModel,
    tests: &[PairedTest<'_>],
    options: &PairOptions,
) -> Result<(), CorrelateError> {
    options.validate()?;
    check_model("theory", theory)?;
    let mut names = BTreeSet::new();
    for test in tests {
        check_model("test", test.model)?;
        let name = test.name.to_owned();
        if !names.insert(test.name) {
            return Err(CorrelateError::DuplicateTest { name });
        }
        let got = (test.pairing.mac.len(), test.pairing.theory_modes);
        let expected = (test.model.modes.len(), theory.modes.len());
        if got != expected {
            return Err(CorrelateError::OtherPairing {
                test: name,
                got_test: got.0,
                got_theory: got.1,
                expected_test: expected.0,
                expected_theory: expected.1,
            });
        }
    }
    Ok(())
}

impl ComparisonTable {
    /// Whether no mode of any test has a partner, an ambiguous one included: nothing is compared.
    pub fn is_empty(&self) -> bool {
        let mut tests = self.summary.iter();
        !self.summary.is_empty() && tests.all(|test| test.paired == 0 && test.ambiguous == 0)
    }

    /// The same table with its first root labelled `f<first>`: where a paper counts the root at 0
    /// Hz, 2.
    pub fn labelled_from(mut self, first: usize) -> Self {
        let roots = self.rows.iter_mut().filter(|row| row.theory.is_some());
        for (number, row) in (first..).zip(roots) {
            row.label = format!("f{number}");
        }
        self
    }
}

/// Rows of the test modes without a partner, of all tests together by frequency.
fn extra_rows(tests: &[PairedTest<'_>]) -> Vec<Row> {
    let of_test = |test: &PairedTest<'_>| {
        let cell = |&i: &usize| test.modes_cell(&[i], Status::Extra);
        let cells: Vec<TestCell> = test.pairing.unpaired_test.iter().map(cell).collect();
        cells
    };
    let mut cells: Vec<TestCell> = tests.iter().flat_map(of_test).collect();
    let hz = |cell: &TestCell| cell.hz.unwrap_or(f64::INFINITY);
    sort_ascending_by(&mut cells, hz);
    let row = |(number, cell): (usize, TestCell)| Row {
        label: format!("x{number}"),
        theory: None,
        tests: vec![cell],
    };
    (1..).zip(cells).map(row).collect()
}

fn summarise(test: &PairedTest<'_>, rows: &[Row]) -> TestSummary {
    let all = rows.iter().flat_map(|row| &row.tests);
    let cells = all.filter(|cell| cell.test == test.name);
    let cells: Vec<SummedCell> = cells.map(SummedCell::from).collect();
    summary_of_cells(test.name, test.pairing.map.len(), &cells)
}

/// The part of a cell that the summary of its test contains.
#[derive(Clone, Copy, Debug)]
pub struct SummedCell {
    /// Status of the root in the test.
    pub status: Status,
    /// Whether the status is certain.
    pub is_status_certain: bool,
    /// Evidence on which a pair rests.
    pub basis: Option<Basis>,
    /// Whether the MAC of a pair is below its chance level.
    pub uncorrelated: bool,
    /// Frequency error, percent.
    pub error_percent: Option<f64>,
    /// Frequency error, Hz.
    pub error_hz: Option<f64>,
    /// MAC.
    pub mac: Option<f64>,
}

impl From<&TestCell> for SummedCell {
    fn from(cell: &TestCell) -> Self {
        Self {
            status: cell.status,
            is_status_certain: cell.is_status_certain(),
            basis: cell.basis,
            uncorrelated: cell.uncorrelated,
            error_percent: cell.error_percent,
            error_hz: cell.error_hz,
            mac: cell.mac,
        }
    }
}

/// The summary of a test by its cells.
pub fn summary_of_cells(test: &str, dofs_used: usize, cells: &[SummedCell]) -> TestSummary {
    let cells = || cells.iter();
    let count = |status| cells().filter(|cell| cell.status == status).count();
    let on = |basis| {
        let paired = cells().filter(|cell| cell.status == Status::Paired);
        paired.filter(|cell| cell.basis == Some(basis)).count()
    };
    let errors: Vec<f64> = cells().filter_map(|cell| cell.error_percent).collect();
    let magnitudes = || errors.iter().map(|error| error.abs());
    let hz = || cells().filter_map(|cell| cell.error_hz).map(f64::abs);
    let squares = errors.iter().map(|error| error * error).collect();
    TestSummary {
        test: test.to_owned(),
        paired: count(Status::Paired),
        paired_by_shape: on(Basis::Shape),
        paired_by_frequency: on(Basis::Frequency),
        ambiguous: count(Status::Ambiguous),
        uncorrelated: cells().filter(|cell| cell.uncorrelated).count(),
        missed: count(Status::MissedExpected) + count(Status::MissedUnexpected),
        not_judged: cells().filter(|cell| !cell.is_status_certain).count(),
        not_observable: count(Status::NotObservable),
        outside_band: count(Status::OutsideBand),
        extra: count(Status::Extra),
        max_error_hz: hz().reduce(f64::max),
        mean_error_hz: mean(hz().collect()),
        max_error_percent: magnitudes().reduce(f64::max),
        mean_error_percent: mean(magnitudes().collect()),
        rms_error_percent: mean(squares).map(f64::sqrt),
        min_mac: cells().filter_map(|cell| cell.mac).reduce(f64::min),
        dofs_used,
    }
}
