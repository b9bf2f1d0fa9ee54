//! The findings of tests and their comparisons of an update, each with the name of its test.

use crate::finding::{Code, Finding};

use super::test_result::TestResult;

/// Findings of the comparison with the model at the start that bear on the update: the updated
/// model may have adapted to what they name.
const CODES_AT_START: [Code; 5] = [
    Code::ReversedSensor,
    Code::ReversedGroup,
    Code::FrequenciesExchanged,
    Code::PointsReversed,
    Code::CommonFactor,
];

/// The findings of tests and of their comparisons with the model after an update, and those of
/// [`CODES_AT_START`] before it.
pub(super) fn comparison_findings(
    tests: &[TestResult],
    before: Vec<(String, Vec<Finding>)>,
    after: Vec<(String, Vec<Finding>)>,
) -> Vec<(String, Finding)> {
    let of_tests = tests
        .iter()
        .map(|test| (test.name.clone(), test.modes.findings.clone()));
    let mut findings = with_test_names(of_tests.chain(after));
    let at_start = with_test_names(before).into_iter();
    let at_start = at_start.filter(|(_, finding)| CODES_AT_START.contains(&finding.code));
    let is_new = |(test, finding): &(String, Finding)| {
        let key = (test, finding.code, &finding.location);
        let mut others = findings.iter();
        !others.any(|(test, other)| (test, other.code, &other.location) == key)
    };
    let new: Vec<(String, Finding)> = at_start.filter(is_new).collect();
    findings.extend(new);
    findings
}

/// Each finding with the name of its test.
pub(super) fn with_test_names(
    by_test: impl IntoIterator<Item = (String, Vec<Finding>)>,
) -> Vec<(String, Finding)> {
    let named = |(test, findings): (String, Vec<Finding>)| {
        let findings = findings.into_iter();
        findings.map(move |finding| (test.clone(), finding))
    };
    by_test.into_iter().flat_map(named).collect()
}
