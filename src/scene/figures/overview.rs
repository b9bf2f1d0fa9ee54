//! Summary of a comparison: number of paired modes, frequency differences, unmatched modes, and
//! common bias of the model.

use serde::{Deserialize, Serialize};

use crate::correlate::{ComparisonTable, ErrorReference, Row, Status, TestCell, TestSummary};

use super::rounding::rounded;

/// Minimum number of pairs from which a common bias of the model is estimated.
const MIN_LEANING_ROWS: usize = 3;

/// Maximum standard deviation of the errors over the magnitude of their mean from which one factor
/// is given: it then removes two thirds of the root mean square. Larger, at 1: errors that grow
/// from 1 to 12 % have a factor that leaves 6 % at both ends. Smaller, at 0.1: errors of 3 % with a
/// scatter of 0.4 % have none. Tests `a_common_frequency_factor_is_given_only_for_a_biased_model`
/// and `errors_that_grow_with_frequency_have_no_common_factor`.
const MAX_SPREAD_OVER_MEAN_ERROR: f64 = 1.0 / 3.0;

/// Minimum rank correlation of errors and frequencies that is a trend. Larger, at 0.95: one mode
/// out of order hides the growth over five. Smaller, at 0.4: three of ten modes out of order pass
/// for a trend. Test `errors_that_grow_with_frequency_have_no_common_factor`.
const MIN_RANK_CORRELATION: f64 = 0.7;

/// Maximum probability, of both sides, of signs that count as one-sided. Larger, at 0.2: two modes
/// of ten on the other side lean. Smaller, at 0.01: one of ten hides the lean of nine. Test
/// `most_modes_on_one_side_are_a_lean_by_the_sign_test`.
const MAX_PROBABILITY_OF_SIGNS: f64 = 0.05;

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
    /// all off to one side, their mean by more than twice its standard deviation, and alike enough
    /// that one factor removes them.
    pub stiffness_factor: Option<f64>,
    /// The errors of a model that is off to one side where no single factor removes them.
    #[serde(default)]
    pub error_range: Option<ErrorRange>,
    /// The modes of a model of which most, but not all, are off to one side.
    #[serde(default)]
    pub one_sided: Option<OneSidedModes>,
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

pub(super) fn overview(table: &ComparisonTable) -> Overview {
    let rows = table.rows.iter().map(row).collect();
    let common = common_error(table);
    Overview {
        tests: table.summary.clone(),
        of_theory: table.error_reference == ErrorReference::Theory,
        rows,
        stiffness_factor: match &common {
            Some(CommonError::Factor(factor)) => Some(*factor),
            _ => None,
        },
        error_range: match &common {
            Some(CommonError::Range(range)) => Some(range.clone()),
            _ => None,
        },
        one_sided: match common {
            Some(CommonError::OneSided(modes)) => Some(modes),
            _ => None,
        },
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

/// How a model is off whose pairs are all off to one side.
#[derive(Clone, Debug, PartialEq)]
pub enum CommonError {
    /// One factor on all stiffnesses, the square of the mean ratio of test to theory, removes most
    /// of the errors.
    Factor(f64),
    /// The errors differ too much for one factor.
    Range(ErrorRange),
    /// Most modes, but not all, are off to one side.
    OneSided(OneSidedModes),
}

/// Modes of which most are off to one side.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OneSidedModes {
    /// Whether the frequencies of the test lie below those of the theory.
    pub test_is_lower: bool,
    /// Modes on that side.
    pub count: usize,
    /// All modes with a pair.
    pub modes: usize,
    /// Mean error of the modes, percent of the theory's frequency.
    pub mean_percent: f64,
}

/// Frequency errors between two modes: of the lowest and the highest frequency where the errors
/// grow or fall with it, else of the smallest and the largest magnitude.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorRange {
    /// Course of the magnitude of the errors over frequency.
    pub trend: ErrorTrend,
    /// Whether the frequencies of the test lie below those of the theory.
    pub test_is_lower: bool,
    /// Label of the first mode.
    pub first: String,
    /// Its error, percent.
    pub first_percent: f64,
    /// Label of the last mode.
    pub last: String,
    /// Its error, percent.
    pub last_percent: f64,
}

/// Course of the magnitude of errors over frequency.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ErrorTrend {
    /// They grow with frequency.
    Grows,
    /// They fall with frequency.
    Falls,
    /// They have no course.
    Scatters,
}

/// Minimum error at the end with the larger one over the largest error, for a trend. Larger, at 1:
/// a mode 1 % beyond the end hides the trend. Smaller, at 0.3: errors that rise from 5 to 16 % and
/// then fall to 0 pass for falling. Test `errors_that_rise_and_fall_have_no_trend`.
const MIN_END_OVER_LARGEST_ERROR: f64 = 0.8;

/// A pair of root and test mode.
struct PairedFrequency<'t> {
    label: &'t str,
    theory_hz: f64,
    ratio: f64,
    error_percent: f64,
    std: f64,
}

/// How the model is off where the mean ratio of test to theory is off by more than twice its
/// standard deviation from those of the tests' frequencies, and all pairs, three or more, lie on
/// one side, or so many modes that the sign test rejects signs by chance.
pub fn common_error(table: &ComparisonTable) -> Option<CommonError> {
    let mut pairs: Vec<PairedFrequency> = Vec::new();
    for row in &table.rows {
        let Some(theory) = &row.theory else { continue };
        let of_cell = row.tests.iter().filter_map(|cell| {
            Some(PairedFrequency {
                label: &row.label,
                theory_hz: theory.hz,
                ratio: cell.hz? / theory.hz,
                error_percent: cell.error_percent?,
                std: cell.hz_std.unwrap_or(0.0) / theory.hz,
            })
        });
        pairs.extend(of_cell);
    }
    if pairs.len() < MIN_LEANING_ROWS {
        return None;
    }
    let all = |is_beyond: fn(&PairedFrequency) -> bool| pairs.iter().all(is_beyond);
    let one_side = all(|pair| pair.ratio > 1.0) || all(|pair| pair.ratio < 1.0);
    let count = pairs.len() as f64;
    let mean = pairs.iter().map(|pair| pair.ratio).sum::<f64>() / count;
    let squares: f64 = pairs.iter().map(|pair| (pair.ratio - mean).powi(2)).sum();
    let variance: f64 = pairs.iter().map(|pair| pair.std.powi(2)).sum();
    let std = variance.sqrt() / count;
    if (mean - 1.0).abs() <= 2.0 * std {
        return None;
    }
    if !one_side {
        return one_sided_modes(table).map(CommonError::OneSided);
    }
    let spread = (squares / (count - 1.0)).sqrt();
    if spread <= MAX_SPREAD_OVER_MEAN_ERROR * (mean - 1.0).abs() {
        return Some(CommonError::Factor(rounded(mean * mean, 4)));
    }
    error_range(&pairs).map(CommonError::Range)
}

/// The modes of a model where the sign test rejects that their signs are by chance. A mode that
/// several tests have counts once, by the mean of its ratios.
fn one_sided_modes(table: &ComparisonTable) -> Option<OneSidedModes> {
    let ratio = |row: &Row| {
        let theory = row.theory.as_ref()?;
        let pairs = row.tests.iter().filter(|cell| cell.error_percent.is_some());
        let ratios: Vec<f64> = pairs
            .filter_map(|cell| Some(cell.hz? / theory.hz))
            .collect();
        (!ratios.is_empty()).then(|| ratios.iter().sum::<f64>() / ratios.len() as f64)
    };
    let ratios: Vec<f64> = table.rows.iter().filter_map(ratio).collect();
    let modes = ratios.len();
    let mean = ratios.iter().sum::<f64>() / modes.max(1) as f64 - 1.0;
    let test_is_lower = mean < 0.0;
    let on_side = |ratio: &&f64| (**ratio < 1.0) == test_is_lower;
    let count = ratios.iter().filter(on_side).count();
    (2.0 * probability_of_at_least(count, modes) <= MAX_PROBABILITY_OF_SIGNS).then(|| {
        OneSidedModes {
            test_is_lower,
            count,
            modes,
            mean_percent: rounded(100.0 * mean, 4),
        }
    })
}

/// Probability that at least so many of all signs are one of both, each as likely as the other.
fn probability_of_at_least(count: usize, all: usize) -> f64 {
    let mut term = 0.5_f64.powi(i32::try_from(all).unwrap_or(i32::MAX));
    let mut sum = if count == 0 { term } else { 0.0 };
    for k in 1..=all {
        term *= (all - k + 1) as f64 / k as f64;
        sum += if k >= count { term } else { 0.0 };
    }
    sum
}

fn error_range(pairs: &[PairedFrequency]) -> Option<ErrorRange> {
    let size = |pair: &PairedFrequency| (pair.ratio - 1.0).abs();
    let slope = rank_correlation(pairs, |pair| pair.theory_hz, size);
    let extreme = |key: &dyn Fn(&PairedFrequency) -> f64| {
        let by_key = |a: &&PairedFrequency, b: &&PairedFrequency| key(a).total_cmp(&key(b));
        pairs.iter().min_by(by_key).zip(pairs.iter().max_by(by_key))
    };
    let (lowest, highest) = extreme(&|pair| pair.theory_hz)?;
    let (smallest, largest) = extreme(&size)?;
    let is_end = |end, other| {
        size(end) > size(other) && size(end) >= MIN_END_OVER_LARGEST_ERROR * size(largest)
    };
    let (trend, first, last) = if slope >= MIN_RANK_CORRELATION && is_end(highest, lowest) {
        (ErrorTrend::Grows, lowest, highest)
    } else if slope <= -MIN_RANK_CORRELATION && is_end(lowest, highest) {
        (ErrorTrend::Falls, lowest, highest)
    } else {
        (ErrorTrend::Scatters, smallest, largest)
    };
    Some(ErrorRange {
        trend,
        test_is_lower: first.ratio < 1.0,
        first: first.label.to_owned(),
        first_percent: rounded(first.error_percent, 4),
        last: last.label.to_owned(),
        last_percent: rounded(last.error_percent, 4),
    })
}

/// Spearman's rank correlation of two values of the pairs.
fn rank_correlation(
    pairs: &[PairedFrequency],
    one: impl Fn(&PairedFrequency) -> f64,
    other: impl Fn(&PairedFrequency) -> f64,
) -> f64 {
    let ranks = |values: Vec<f64>| -> Vec<f64> {
        let rank = |value: &f64| {
            let below = values.iter().filter(|other| *other < value).count() as f64;
            let equal = values.iter().filter(|other| *other <= value).count() as f64;
            0.5 * (below + equal + 1.0)
        };
        values.iter().map(rank).collect()
    };
    let (one, other) = (
        ranks(pairs.iter().map(one).collect()),
        ranks(pairs.iter().map(other).collect()),
    );
    let mean = 0.5 * (pairs.len() as f64 + 1.0);
    let product = |a: &[f64], b: &[f64]| -> f64 {
        let terms = a.iter().zip(b).map(|(a, b)| (a - mean) * (b - mean));
        terms.sum()
    };
    let scale = (product(&one, &one) * product(&other, &other)).sqrt();
    product(&one, &other) / scale.max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlate::TheoryCell;

    fn table(pairs: &[(f64, f64)]) -> ComparisonTable {
        let cell = |theory_hz: f64, hz: f64| TestCell {
            test: "bar".to_owned(),
            modes: vec![1],
            hz: Some(hz),
            hz_std: Some(0.5),
            error_percent: Some(100.0 * (hz / theory_hz - 1.0)),
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
        let row = |(number, (theory, test)): (usize, &(f64, f64))| Row {
            label: format!("f{number}"),
            theory: Some(TheoryCell {
                modes: vec![1],
                hz: *theory,
            }),
            tests: vec![cell(*theory, *test)],
        };
        ComparisonTable {
            error_reference: ErrorReference::Theory,
            rows: (1..).zip(pairs).map(row).collect(),
            summary: Vec::new(),
            dofs_used: 3,
            footnotes: Vec::new(),
        }
    }

    #[test]
    fn a_common_frequency_factor_is_given_only_for_a_biased_model() {
        let leaning = overview(&table(&[(100.0, 97.5), (200.0, 196.0), (400.0, 394.0)]));
        let factor = ((0.975f64 + 0.98 + 0.985) / 3.0).powi(2);
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
            assert_eq!(overview(&table(pairs)).stiffness_factor, None);
        }
    }

    #[test]
    fn most_modes_on_one_side_are_a_lean_by_the_sign_test() {
        let lean = |below: usize, all: usize| {
            let pairs: Vec<(f64, f64)> = (0..all)
                .map(|number| {
                    let theory = 100.0 * (number + 1) as f64;
                    let ratio = if number < below { 0.97 } else { 1.01 };
                    (theory, ratio * theory)
                })
                .collect();
            overview(&table(&pairs)).one_sided
        };
        let found = lean(9, 10).unwrap();
        assert!(found.test_is_lower);
        assert_eq!((found.count, found.modes), (9, 10));
        assert!((found.mean_percent + 2.6).abs() < 1e-9, "{found:?}");
        assert_eq!(lean(8, 10), None);
        assert_eq!(lean(6, 7), None);
        // All on one side have a factor or a range.
        assert_eq!(lean(10, 10), None);
        assert!((probability_of_at_least(9, 10) - 11.0 / 1024.0).abs() < 1e-12);
    }

    /// The factor and the range of modes with these ratios of test to theory.
    fn range(ratios: &[f64]) -> (Option<f64>, Option<ErrorRange>) {
        let hz = |number: i32| 100.0 * f64::from(number);
        let pairs = (1..).zip(ratios);
        let pairs: Vec<(f64, f64)> = pairs
            .map(|(number, ratio)| (hz(number), hz(number) * ratio))
            .collect();
        let overview = overview(&table(&pairs));
        (overview.stiffness_factor, overview.error_range)
    }

    #[test]
    fn errors_that_rise_and_fall_have_no_trend() {
        let twin = [
            0.946, 0.839, 0.838, 0.909, 0.845, 0.871, 0.973, 0.987, 0.987, 0.999,
        ];
        let (_, found) = range(&twin);
        let found = found.unwrap();
        assert_eq!(found.trend, ErrorTrend::Scatters);
        assert_eq!((found.first.as_str(), found.last.as_str()), ("f10", "f3"));
        let mut reversed = twin;
        reversed.reverse();
        assert_eq!(range(&reversed).1.unwrap().trend, ErrorTrend::Scatters);
        let (_, nearly) = range(&[0.89, 0.88, 0.93, 0.95, 0.99]);
        assert_eq!(nearly.unwrap().trend, ErrorTrend::Falls);
    }

    #[test]
    fn errors_that_grow_with_frequency_have_no_common_factor() {
        let (factor, found) = range(&[0.99, 0.97, 0.93, 0.94, 0.88]);
        let found = found.unwrap();
        assert_eq!((factor, found.trend), (None, ErrorTrend::Grows));
        assert!(found.test_is_lower);
        assert_eq!((found.first.as_str(), found.last.as_str()), ("f1", "f5"));
        assert!((found.last_percent + 12.0).abs() < 1e-6, "{found:?}");
        let (_, falling) = range(&[1.12, 1.06, 1.05, 1.02]);
        assert_eq!(falling.unwrap().trend, ErrorTrend::Falls);
        let (_, scattered) = range(&[0.99, 0.9, 0.98, 0.91, 0.985]);
        let scattered = scattered.unwrap();
        assert_eq!(scattered.trend, ErrorTrend::Scatters);
        assert_eq!(
            (scattered.first.as_str(), scattered.last.as_str()),
            ("f1", "f2")
        );
        // A little scatter about a common error leaves the factor.
        let (factor, none) = range(&[0.966, 0.974, 0.969, 0.971]);
        assert!((factor.unwrap() - 0.97f64.powi(2)).abs() < 1e-3);
        assert_eq!(none, None);
    }
}
