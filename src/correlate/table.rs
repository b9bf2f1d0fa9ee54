//! The comparison table: one row for each root of the theory, one cell for each test, as `comparison.json` holds it.
//!
//! Numbers stay numbers and missing ones stay `None`; how they look is for the report.

use std::collections::BTreeSet;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::modal::{ModalModel, Mode};

use super::roots::{Root, check_model, elastic_roots};
use super::{CorrelateError, ErrorReference, Pair, PairOptions, Pairing, Rival, Verdict};

/// One test of a comparison, already paired with the theory.
#[derive(Clone, Copy, Debug)]
pub struct PairedTest<'a> {
    /// Name, as it heads its columns.
    pub name: &'a str,
    /// Its modes.
    pub model: &'a ModalModel,
    /// Its pairing with the theory of the comparison.
    pub pairing: &'a Pairing,
}

/// One theory against one or more tests.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparisonTable {
    /// What the errors are a part of.
    pub error_reference: ErrorReference,
    /// Rows `f1, f2, ...` of the theory's elastic roots by frequency, then `x1, x2, ...` of test modes without a partner.
    pub rows: Vec<Row>,
    /// One summary for each test, in their order.
    pub summary: Vec<TestSummary>,
    /// Smallest number of degrees of freedom that a test's MAC rests on; 0 when one has no shapes in common.
    pub dofs_used: usize,
    /// What has to be said under the table.
    pub footnotes: Vec<Footnote>,
}

/// One row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// `f1`, `f2`, ... or `x1`, `x2`, ...
    pub label: String,
    /// The root of the theory; `None` for a test mode without a partner.
    pub theory: Option<TheoryCell>,
    /// For a root a cell of every test, in their order; for an extra mode one cell of its test.
    pub tests: Vec<TestCell>,
}

/// The theory's side of a row.
#[derive(Clone, Debug, PartialEq)]
pub struct TheoryCell {
    /// Numbers, from 1, of the modes in the theory's list (rigid-body modes counted); several for a repeated root.
    pub modes: Vec<usize>,
    /// Their mean frequency, Hz.
    pub hz: f64,
}

/// A test's side of a row. Where several test modes belong to a repeated root, numbers are means over them.
#[derive(Clone, Debug, PartialEq)]
pub struct TestCell {
    /// Name of the test.
    pub test: String,
    /// Numbers of its modes, from 1; empty for a missed one.
    pub modes: Vec<usize>,
    /// Frequency, Hz.
    pub hz: Option<f64>,
    /// Standard deviation of that, Hz; of a mean as if its modes' errors were independent.
    pub hz_std: Option<f64>,
    /// Signed frequency error by the table's reference, percent.
    pub error_percent: Option<f64>,
    /// The same difference, Hz.
    pub error_hz: Option<f64>,
    /// Damping ratio, a fraction.
    pub damping_ratio: Option<f64>,
    /// Standard deviation of that, as for the frequency.
    pub damping_std: Option<f64>,
    /// MAC; with the subspace of a repeated root, and then the smallest of its test modes.
    pub mac: Option<f64>,
    /// Principal angles between the test modes and a repeated root, degrees.
    pub angles_deg: Option<Vec<f64>>,
    /// What became of it.
    pub status: Status,
    /// Why, where the status needs a reason.
    pub reason: Option<String>,
}

/// What became of a theory root in a test, or of a test mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// Paired.
    Paired,
    /// Paired, with another partner as good.
    Ambiguous,
    /// Not found, and it could not have been.
    MissedExpected,
    /// Not found, though inside the band.
    MissedUnexpected,
    /// Not to be seen with these sensors and hits.
    NotObservable,
    /// Outside the band that the test searched.
    OutsideBand,
    /// A test mode without a partner in the theory.
    Extra,
}

/// A sentence under the table.
#[derive(Clone, Debug, PartialEq)]
pub enum Footnote {
    /// What the errors are a part of.
    Error(ErrorReference),
    /// MAC of test shapes as identified.
    ComplexShapesAsTheyAre,
    /// MAC with the subspace of a repeated root.
    RepeatedRoots,
    /// Number of theory modes at 0 Hz, which have no row.
    RigidBodyModesLeftOut(usize),
    /// A test, by name, whose modes were paired by frequency alone.
    FrequencyAlone(String),
    /// Missed roots were not judged for being observable.
    ObservabilityNotJudged,
}

impl fmt::Display for Footnote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Footnote::Error(ErrorReference::Theory) => {
                f.write_str("Error = (test - theory)/theory.")
            }
            Footnote::Error(ErrorReference::Test) => f.write_str("Error = (theory - test)/test."),
            Footnote::ComplexShapesAsTheyAre => {
                f.write_str("MAC of the test shapes as identified; they were not made real first.")
            }
            Footnote::RepeatedRoots => f.write_str(
                "A row of several theory modes is a repeated root; its MAC is that with their subspace.",
            ),
            Footnote::RigidBodyModesLeftOut(count) => {
                write!(f, "Rigid-body modes of the theory at 0 Hz have no row: {count}.")
            }
            Footnote::FrequencyAlone(test) => write!(
                f,
                "{test}: paired by frequency alone where no shapes could be compared."
            ),
            Footnote::ObservabilityNotJudged => f.write_str(
                "Whether a missed mode could have been observed was not judged.",
            ),
        }
    }
}

/// How one test fared.
#[derive(Clone, Debug, PartialEq)]
pub struct TestSummary {
    /// Name of the test.
    pub test: String,
    /// Roots with a partner, ambiguous ones included.
    pub paired: usize,
    /// Those of them that are ambiguous.
    pub ambiguous: usize,
    /// Roots without a partner inside the band.
    pub missed: usize,
    /// Roots without a partner outside the band.
    pub outside_band: usize,
    /// Test modes without a partner.
    pub extra: usize,
    /// Largest |frequency error| over the paired roots, percent.
    pub max_error_percent: Option<f64>,
    /// Mean |frequency error|, percent.
    pub mean_error_percent: Option<f64>,
    /// Root mean square of the frequency error, percent.
    pub rms_error_percent: Option<f64>,
    /// Smallest MAC of a pair.
    pub min_mac: Option<f64>,
    /// Degrees of freedom that the MAC rests on.
    pub dofs_used: usize,
}

/// The table of one theory and several tests that were paired with it.
///
/// A root without a partner is `outside-band` when the test states a band that does not hold it, else
/// `missed-unexpected`: whether it could have been observed is not judged here.
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
    let row = |(number, root): (usize, &Root)| Row {
        label: format!("f{number}"),
        theory: Some(TheoryCell {
            modes: root.modes.iter().map(|j| j + 1).collect(),
            hz: root.hz,
        }),
        tests: tests.iter().map(|test| test.cell(root, options)).collect(),
    };
    let mut rows: Vec<Row> = (1..).zip(&roots).map(row).collect();
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

impl PairedTest<'_> {
    fn cell(&self, root: &Root, options: &PairOptions) -> TestCell {
        let pairs = self.pairing.pairs.iter();
        match pairs.into_iter().find(|pair| pair.theory == root.modes) {
            Some(pair) => self.paired_cell(pair, root, options.error_reference),
            None => self.missed_cell(root, options),
        }
    }

    fn paired_cell(&self, pair: &Pair, root: &Root, reference: ErrorReference) -> TestCell {
        let indices: Vec<usize> = pair.partners.iter().map(|partner| partner.test).collect();
        let macs = pair.partners.iter().filter_map(|partner| partner.mac);
        let cell = self.modes_cell(&indices, Status::Paired);
        let doubt = pair
            .partners
            .iter()
            .find_map(|partner| self.doubt(&partner.verdict));
        let (found, expected) = (indices.len(), root.modes.len());
        let part = (found < expected)
            .then(|| format!("{found} of the {expected} modes of a repeated root"));
        let blind = pair.partners.iter().all(|partner| partner.mac.is_none());
        let blind =
            blind.then(|| "paired by frequency alone: no shapes could be compared".to_owned());
        let reasons: Vec<String> = doubt.iter().chain(&part).chain(&blind).cloned().collect();
        TestCell {
            error_percent: cell.hz.map(|hz| 100.0 * reference.error(hz, root.hz)),
            error_hz: cell.hz.map(|hz| match reference {
                ErrorReference::Theory => hz - root.hz,
                ErrorReference::Test => root.hz - hz,
            }),
            mac: macs.reduce(f64::min),
            angles_deg: pair.angles_deg.clone(),
            status: if doubt.is_some() {
                Status::Ambiguous
            } else {
                Status::Paired
            },
            reason: (!reasons.is_empty()).then(|| reasons.join("; ")),
            ..cell
        }
    }

    fn doubt(&self, verdict: &Verdict) -> Option<String> {
        let Verdict::Ambiguous {
            rival,
            cost_difference,
        } = verdict
        else {
            return None;
        };
        let who = match rival {
            Rival::Theory(modes) => {
                let numbers: Vec<String> = modes.iter().map(|j| (j + 1).to_string()).collect();
                format!("theory mode {}", numbers.join(", "))
            }
            Rival::Test(i) => {
                let hz = self.model.modes[*i].frequency_hz;
                format!("test mode {} at {hz:.2} Hz", i + 1)
            }
        };
        Some(format!("{who} fits as well (cost {cost_difference:+.3})"))
    }

    fn missed_cell(&self, root: &Root, options: &PairOptions) -> TestCell {
        let band = self.model.band;
        if let Some(band) = band.filter(|band| !band.contains(root.hz)) {
            let (lo, hi) = (band.lo_hz, band.hi_hz);
            let reason = Some(format!("the test searched {lo} to {hi} Hz"));
            return TestCell {
                reason,
                ..self.modes_cell(&[], Status::OutsideBand)
            };
        }
        let unpaired = self.pairing.unpaired_theory.iter();
        let own = unpaired
            .into_iter()
            .find(|other| other.theory == root.modes);
        let refused = own.and_then(|own| own.near_miss.as_ref()).map(|miss| {
            let hz = self.model.modes[miss.test].frequency_hz;
            let (number, mac, gate) = (miss.test + 1, miss.mac, options.min_mac);
            format!("test mode {number} at {hz:.2} Hz has a MAC of {mac:.3}, below {gate}")
        });
        let no_band = band.is_none().then(|| "the test states no band".to_owned());
        let judged = Some("observability was not judged".to_owned());
        let reasons: Vec<String> = [refused, no_band, judged].into_iter().flatten().collect();
        TestCell {
            reason: Some(reasons.join("; ")),
            ..self.modes_cell(&[], Status::MissedUnexpected)
        }
    }

    /// What the test knows of some of its modes, without a comparison.
    fn modes_cell(&self, indices: &[usize], status: Status) -> TestCell {
        let modes: Vec<&Mode> = indices.iter().map(|&i| &self.model.modes[i]).collect();
        let collect = |value: fn(&Mode) -> Option<f64>| -> Option<Vec<f64>> {
            modes.iter().map(|mode| value(mode)).collect()
        };
        TestCell {
            test: self.name.to_owned(),
            modes: indices.iter().map(|i| i + 1).collect(),
            hz: collect(|mode| Some(mode.frequency_hz)).and_then(mean),
            hz_std: collect(|mode| mode.frequency_std_hz).and_then(std_of_mean),
            error_percent: None,
            error_hz: None,
            damping_ratio: collect(|mode| mode.damping_ratio).and_then(mean),
            damping_std: collect(|mode| mode.damping_std).and_then(std_of_mean),
            mac: None,
            angles_deg: None,
            status,
            reason: None,
        }
    }
}

fn mean(values: Vec<f64>) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn std_of_mean(values: Vec<f64>) -> Option<f64> {
    let squares: f64 = values.iter().map(|v| v * v).sum();
    (!values.is_empty()).then(|| squares.sqrt() / values.len() as f64)
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
    cells.sort_by(|a, b| hz(a).total_cmp(&hz(b)));
    let row = |(number, cell): (usize, TestCell)| Row {
        label: format!("x{number}"),
        theory: None,
        tests: vec![cell],
    };
    (1..).zip(cells).map(row).collect()
}

fn summarise(test: &PairedTest<'_>, rows: &[Row]) -> TestSummary {
    let cells = || {
        let all = rows.iter().flat_map(|row| &row.tests);
        all.filter(|cell| cell.test == test.name)
    };
    let count = |status| cells().filter(|cell| cell.status == status).count();
    let errors: Vec<f64> = cells().filter_map(|cell| cell.error_percent).collect();
    let magnitudes = || errors.iter().map(|error| error.abs());
    let squares = errors.iter().map(|error| error * error).collect();
    TestSummary {
        test: test.name.to_owned(),
        paired: count(Status::Paired) + count(Status::Ambiguous),
        ambiguous: count(Status::Ambiguous),
        missed: count(Status::MissedExpected) + count(Status::MissedUnexpected),
        outside_band: count(Status::OutsideBand),
        extra: count(Status::Extra),
        max_error_percent: magnitudes().reduce(f64::max),
        mean_error_percent: mean(magnitudes().collect()),
        rms_error_percent: mean(squares).map(f64::sqrt),
        min_mac: cells().filter_map(|cell| cell.mac).reduce(f64::min),
        dofs_used: test.pairing.map.len(),
    }
}

fn footnotes(tests: &[PairedTest<'_>], rows: &[Row], reference: ErrorReference) -> Vec<Footnote> {
    let cells = || rows.iter().flat_map(|row| &row.tests);
    let repeated = |row: &&Row| row.theory.as_ref().is_some_and(|t| t.modes.len() > 1);
    let mut notes = vec![Footnote::Error(reference)];
    if cells().any(|cell| cell.mac.is_some()) {
        notes.push(Footnote::ComplexShapesAsTheyAre);
    }
    if rows
        .iter()
        .filter(repeated)
        .flat_map(|row| &row.tests)
        .any(|cell| cell.mac.is_some())
    {
        notes.push(Footnote::RepeatedRoots);
    }
    let rigid = tests.first().map_or(0, |test| test.pairing.rigid_theory);
    if rigid > 0 {
        notes.push(Footnote::RigidBodyModesLeftOut(rigid));
    }
    for test in tests {
        let partners = test.pairing.pairs.iter().flat_map(|pair| &pair.partners);
        if partners.into_iter().any(|partner| partner.mac.is_none()) {
            notes.push(Footnote::FrequencyAlone(test.name.to_owned()));
        }
    }
    if cells().any(|cell| cell.status == Status::MissedUnexpected) {
        notes.push(Footnote::ObservabilityNotJudged);
    }
    notes
}
