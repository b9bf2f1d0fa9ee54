//! Whether several tests of one machine in one state find the same frequencies.
//!
//! A model can agree with a test no better than its tests with each other: a difference between
//! them bounds what an error of the model, or a parameter updated to one of them, is worth.

use crate::correlate::{ComparisonTable, Status};
use crate::finding::{Code, Finding, Location, Severity};
use crate::printable::counted;

use super::test_result::TestResult;
use super::test_state::TestState;

/// Maximum difference of a frequency between tests, a fraction of it, and in standard deviations
/// of the identification.
///
/// Larger than 7 %: the columns of the cycloid ball transmission pass, whose hit points "differ
/// little". Smaller than 0.3 %: a test repeated with another sensor is one that disagrees. Test:
/// `tests_disagree_beyond_one_percent_and_their_deviations`.
const MAX_DIFFERENCE: f64 = 0.01;
const MAX_DIFFERENCE_STDS: f64 = 4.0;
/// Number of further modes that the detail lists.
const FURTHER_MODES: usize = 4;

/// A mode in two tests that differ most in its frequency.
struct Difference<'a> {
    label: &'a str,
    low: (&'a str, f64),
    high: (&'a str, f64),
}

impl Difference<'_> {
    fn fraction(&self) -> f64 {
        self.high.1 / self.low.1 - 1.0
    }
}

/// As [`test_disagreements`], of tests with their states.
pub(super) fn disagreements(
    tests: &[TestResult],
    table: &ComparisonTable,
) -> Vec<(String, Vec<Finding>)> {
    let states = tests.iter().map(|test| (&*test.name, &test.state));
    test_disagreements(&states.collect::<Vec<_>>(), table)
}

/// The finding on each group of tests with equal states whose frequencies differ, with the name of
/// the test that it is listed with, the last of the group. Doubtful modes do not count.
fn test_disagreements(
    states: &[(&str, &TestState)],
    table: &ComparisonTable,
) -> Vec<(String, Vec<Finding>)> {
    let mut groups: Vec<(TestState, Vec<&str>)> = Vec::new();
    for (name, state) in states {
        let undated = TestState {
            date: None,
            ..(*state).clone()
        };
        match groups.iter_mut().find(|(of_group, _)| *of_group == undated) {
            Some((_, names)) => names.push(name),
            None => groups.push((undated, vec![name])),
        }
    }
    let of_group = |(_, names): &(TestState, Vec<&str>)| {
        let finding = disagreement(names, table)?;
        Some(((*names.last()?).to_owned(), vec![finding]))
    };
    groups.iter().filter_map(of_group).collect()
}

fn disagreement(names: &[&str], table: &ComparisonTable) -> Option<Finding> {
    let mut differences: Vec<Difference> = table
        .rows
        .iter()
        .filter(|row| row.theory.is_some())
        .filter_map(|row| {
            let cells = row.tests.iter().filter(|cell| {
                names.contains(&cell.test.as_str())
                    && cell.status == Status::Paired
                    && cell.doubts.is_empty()
            });
            let mut found: Vec<(&str, f64, f64)> = cells
                .filter_map(|cell| Some((&*cell.test, cell.hz?, cell.hz_std.unwrap_or(0.0))))
                .collect();
            found.sort_by(|a, b| a.1.total_cmp(&b.1));
            let pairs = (0..found.len()).flat_map(|i| (i + 1..found.len()).map(move |j| (i, j)));
            let significant = pairs.filter_map(|(i, j)| {
                let (low, high) = (found[i], found[j]);
                let std_hz = low.2.hypot(high.2);
                let difference = Difference {
                    label: &row.label,
                    low: (low.0, low.1),
                    high: (high.0, high.1),
                };
                let is_significant = high.1 - low.1 > MAX_DIFFERENCE_STDS * std_hz;
                (is_significant && difference.fraction() > MAX_DIFFERENCE).then_some(difference)
            });
            significant.max_by(|a, b| a.fraction().total_cmp(&b.fraction()))
        })
        .collect();
    differences.sort_by(|a, b| b.fraction().total_cmp(&a.fraction()));
    let (largest, others) = differences.split_first()?;
    let percent = |difference: &Difference| 100.0 * difference.fraction();
    let ((low, low_hz), (high, high_hz)) = (largest.low, largest.high);
    let mut parts = vec![format!(
        "{}: {low_hz:.1} Hz in {low}, {high_hz:.1} Hz in {high}",
        largest.label
    )];
    let further = others.iter().take(FURTHER_MODES);
    parts.extend(
        further.map(|difference| format!("{} {:.1} %", difference.label, percent(difference))),
    );
    let left = others.len().saturating_sub(FURTHER_MODES);
    parts.extend((left > 0).then(|| format!("{} more", counted(left, "mode"))));
    let finding = Finding::new(Severity::Warning, Code::TestsDisagree, Location::Whole);
    let finding = finding
        .value(percent(largest), "%")
        .limit(100.0 * MAX_DIFFERENCE);
    Some(finding.detail(parts.join("; ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlate::{ErrorReference, Row, TestCell, TheoryCell};
    use crate::theory::Support;

    /// A table of one mode at 100 Hz in the model, found by each test at a frequency and standard
    /// deviation.
    fn table(found: &[(&str, f64, f64)]) -> ComparisonTable {
        let cell = |(test, hz, std): &(&str, f64, f64)| TestCell {
            test: (*test).to_owned(),
            modes: vec![1],
            hz: Some(*hz),
            hz_std: Some(*std),
            error_percent: None,
            error_hz: None,
            normalised_error: None,
            damping_ratio: None,
            damping_std: None,
            mac: None,
            basis: None,
            chance_level: None,
            uncorrelated: false,
            angles_deg: None,
            status: Status::Paired,
            doubts: Vec::new(),
            reasons: Vec::new(),
            observability: None,
        };
        ComparisonTable {
            error_reference: ErrorReference::Theory,
            rows: vec![Row {
                label: "f1".to_owned(),
                theory: Some(TheoryCell {
                    modes: vec![1],
                    hz: 100.0,
                }),
                tests: found.iter().map(cell).collect(),
            }],
            summary: Vec::new(),
            dofs_used: 0,
            footnotes: Vec::new(),
        }
    }

    fn found(states: &[(&str, &TestState)], modes: &[(&str, f64, f64)]) -> Vec<Finding> {
        let all = test_disagreements(states, &table(modes));
        all.into_iter().flat_map(|(_, findings)| findings).collect()
    }

    #[test]
    fn tests_disagree_beyond_one_percent_and_their_deviations() {
        let state = TestState::default();
        let two = [("a", &state), ("b", &state)];
        assert!(found(&two, &[("a", 100.0, 0.01), ("b", 100.3, 0.01)]).is_empty());
        assert!(found(&two, &[("a", 100.0, 1.0), ("b", 103.0, 1.0)]).is_empty());
        // Three and five standard deviations of the difference.
        assert!(found(&two, &[("a", 100.0, 1.0), ("b", 104.2, 1.0)]).is_empty());
        assert_eq!(
            found(&two, &[("a", 100.0, 0.5), ("b", 103.5, 0.5)]).len(),
            1
        );
        assert!(found(&two, &[("a", 100.0, 0.01), ("b", 100.9, 0.01)]).is_empty());
        assert_eq!(
            found(&two, &[("a", 100.0, 0.01), ("b", 101.1, 0.01)]).len(),
            1
        );
        // A third test whose frequency is uncertain hides no difference of the others.
        let three = [("a", &state), ("b", &state), ("c", &state)];
        let modes = [("a", 100.0, 0.01), ("b", 103.0, 0.01), ("c", 104.0, 2.0)];
        assert_eq!(found(&three, &modes).len(), 1);
        let differ = found(&two, &[("a", 103.0, 0.01), ("b", 100.0, 0.01)]);
        assert_eq!(differ.len(), 1);
        assert!((differ[0].value.unwrap() - 3.0).abs() < 1e-9);
        let detail = differ[0].detail.as_deref().unwrap();
        assert_eq!(detail, "f1: 100.0 Hz in b, 103.0 Hz in a");
    }

    #[test]
    fn tests_in_other_states_may_differ_and_their_dates_make_no_state() {
        let (hung, fixed) = (Support::Suspended, Support::Fixed);
        let state = |support, date: &str| TestState {
            support: Some(support),
            date: Some(date.to_owned()),
            ..TestState::default()
        };
        let modes = [("a", 100.0, 0.01), ("b", 103.0, 0.01)];
        let first = state(hung, "2026-01-01");
        let other = state(fixed, "2026-01-01");
        assert!(found(&[("a", &first), ("b", &other)], &modes).is_empty());
        let later = state(hung, "2026-02-01");
        assert_eq!(found(&[("a", &first), ("b", &later)], &modes).len(), 1);
    }
}
