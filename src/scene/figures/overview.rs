//! Summary of a comparison: number of paired modes, frequency differences, unmatched modes, and
//! common bias of the model.

use serde::{Deserialize, Serialize};

use crate::correlate::{ComparisonTable, ErrorReference, Row, Status, TestCell, TestSummary};

use super::rounding::rounded;

/// Minimum number of pairs from which a common bias of the model is estimated.
const MIN_LEANING_ROWS: usize = 3;

/// Contents of the first screen of a report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Overview {
    /// Result of each test.
    pub tests: Vec<TestSummary>,
    /// Whether errors are a part of the theory's frequency (else of the test's).
    pub of_theory: bool,
    /// Every root with the cell of each test, then test modes without a partner.
    pub rows: Vec<OverviewRow>,
    /// One factor on all stiffnesses that would bring the mean frequency of all pairs to the tests:
    /// the square of the mean ratio of test to theory. `None` unless the pairs, three or more, are
    /// all off to one side, and their mean by more than twice its standard deviation.
    pub stiffness_factor: Option<f64>,
    /// Whether the theory has parameters that an update could change.
    #[serde(default)]
    pub updatable: bool,
}

/// A root of the theory, or a test mode without a partner.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OverviewRow {
    /// `f1`, `f2`, ... or `x1`, `x2`, ...
    pub label: String,
    /// The theory's frequency, Hz.
    pub theory_hz: Option<f64>,
    /// Number of modes that share it.
    pub multiplicity: usize,
    /// A cell of each test that has one.
    pub cells: Vec<OverviewCell>,
}

/// Test mode of a root.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OverviewCell {
    /// Name of the test.
    pub test: String,
    /// Its frequency, Hz.
    pub hz: Option<f64>,
    /// Signed error, percent.
    pub error_percent: Option<f64>,
    /// Standard deviation of that from the test's frequency, percent.
    pub error_std_percent: Option<f64>,
    /// MAC.
    pub mac: Option<f64>,
    /// Verdict.
    pub status: Status,
    /// Why.
    pub reasons: Vec<String>,
    /// An unmatched model mode of unknown observability.
    #[serde(default)]
    pub not_judged: bool,
}

pub(super) fn overview(table: &ComparisonTable, updatable: bool) -> Overview {
    let rows = table.rows.iter().map(row).collect();
    Overview {
        tests: table.summary.clone(),
        of_theory: table.error_reference == ErrorReference::Theory,
        rows,
        stiffness_factor: stiffness_factor(table),
        updatable,
    }
}

fn row(row: &Row) -> OverviewRow {
    let theory_hz = row.theory.as_ref().map(|root| root.hz);
    OverviewRow {
        label: row.label.clone(),
        theory_hz: theory_hz.map(|hz| rounded(hz, 9)),
        multiplicity: row.theory.as_ref().map_or(1, |root| root.modes.len()),
        cells: row
            .tests
            .iter()
            .map(|cell| cell_of_test(cell, theory_hz))
            .collect(),
    }
}

fn cell_of_test(cell: &TestCell, theory_hz: Option<f64>) -> OverviewCell {
    let reference_hz = theory_hz.or(cell.hz);
    let relative = |hz: f64| {
        reference_hz
            .filter(|hz_of_reference| *hz_of_reference > 0.0)
            .map(|hz_of_reference| 100.0 * hz / hz_of_reference)
    };
    OverviewCell {
        test: cell.test.clone(),
        hz: cell.hz.map(|hz| rounded(hz, 9)),
        error_percent: cell.error_percent.map(|error| rounded(error, 5)),
        error_std_percent: cell.hz_std.and_then(relative).map(|std| rounded(std, 3)),
        mac: cell.mac.map(|mac| rounded(mac, 4)),
        status: cell.status,
        reasons: cell.reasons.clone(),
        not_judged: !cell.is_status_certain(),
    }
}

/// The square of the mean ratio of test to theory over all pairs, where all lie on one side of 1
/// and the mean is off by more than twice its standard deviation: the larger of that from the
/// tests' frequencies and that from the scatter of the pairs.
pub fn stiffness_factor(table: &ComparisonTable) -> Option<f64> {
    let (mut ratios, mut variance) = (Vec::new(), 0.0);
    for row in &table.rows {
        let Some(theory) = &row.theory else { continue };
        for cell in row.tests.iter().filter(|cell| cell.error_percent.is_some()) {
            let Some(hz) = cell.hz else { continue };
            ratios.push(hz / theory.hz);
            variance += (cell.hz_std.unwrap_or(0.0) / theory.hz).powi(2);
        }
    }
    if ratios.len() < MIN_LEANING_ROWS {
        return None;
    }
    let one_side = ratios.iter().all(|r| *r > 1.0) || ratios.iter().all(|r| *r < 1.0);
    let count = ratios.len() as f64;
    let mean = ratios.iter().sum::<f64>() / count;
    let squares: f64 = ratios.iter().map(|r| (r - mean).powi(2)).sum();
    let scatter = squares / (count * (count - 1.0));
    let std = scatter.max(variance / (count * count)).sqrt();
    (one_side && (mean - 1.0).abs() > 2.0 * std).then(|| rounded(mean * mean, 4))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlate::TheoryCell;

    fn table(pairs: &[(f64, f64)]) -> ComparisonTable {
        let cell = |hz: f64| TestCell {
            test: "bar".to_owned(),
            modes: vec![1],
            hz: Some(hz),
            hz_std: Some(0.5),
            error_percent: Some(1.0),
            error_hz: None,
            normalised_error: None,
            damping_ratio: None,
            damping_std: None,
            mac: Some(0.987_654),
            basis: None,
            chance_level: None,
            uncorrelated: false,
            angles_deg: None,
            status: Status::Paired,
            doubts: Vec::new(),
            reasons: Vec::new(),
            observability: None,
        };
        let row = |(theory, test): &(f64, f64)| Row {
            label: "f1".to_owned(),
            theory: Some(TheoryCell {
                modes: vec![1],
                hz: *theory,
            }),
            tests: vec![cell(*test)],
        };
        ComparisonTable {
            error_reference: ErrorReference::Theory,
            rows: pairs.iter().map(row).collect(),
            summary: Vec::new(),
            dofs_used: 3,
            footnotes: Vec::new(),
        }
    }

    #[test]
    fn a_common_frequency_factor_is_given_only_for_a_biased_model() {
        let leaning = overview(
            &table(&[(100.0, 97.0), (200.0, 196.0), (400.0, 396.0)]),
            true,
        );
        let factor = ((0.97f64 + 0.98 + 0.99) / 3.0).powi(2);
        assert!((leaning.stiffness_factor.unwrap() - factor).abs() < 1e-4);
        let cell = &leaning.rows[1].cells[0];
        assert_eq!(
            (cell.mac, cell.error_std_percent),
            (Some(0.9877), Some(0.25))
        );
        for pairs in [
            &[(100.0, 97.0), (200.0, 196.0), (400.0, 404.0)][..],
            &[(100.0, 97.0), (200.0, 196.0)],
            // Off by 0.06 % in the mean, of which 0.19 % are the deviation.
            &[(100.0, 99.9), (200.0, 199.9), (400.0, 399.9)],
        ] {
            assert_eq!(overview(&table(pairs), true).stiffness_factor, None);
        }
    }
}
