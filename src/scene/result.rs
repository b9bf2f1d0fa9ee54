//! The result of a scene holds its tests, its theory and their comparison.

use crate::correlate::{ComparisonTable, Pairing};
use crate::finding::Finding;

use super::expected::ExpectedResult;
use super::limits::LimitCheck;
use super::model::Theory;
use super::placement::PlacedTest;
use super::test_result::TestResult;

/// Result of a scene.
#[derive(Clone, Debug)]
pub struct SceneResult {
    /// Tests in order.
    pub tests: Vec<TestResult>,
    /// The model's side.
    pub theory: Theory,
    /// The comparison; `None` for a scene without a model or without a test.
    pub table: Option<ComparisonTable>,
    /// Findings of the pairing, by test.
    pub comparison_findings: Vec<(String, Vec<Finding>)>,
    /// The pairing of every test, in their order; none without a comparison.
    pub pairings: Vec<Pairing>,
    /// Points that tests should measure in addition.
    pub placements: Vec<PlacedTest>,
    /// Limits that the comparison was checked against.
    pub limits: Vec<LimitCheck>,
    /// Published results compared with the model and with one another; `None` for a scene without
    /// any.
    pub expected: Option<ExpectedResult>,
}

impl SceneResult {
    /// Whether part of the input was bad and left out.
    pub fn partly_bad(&self) -> bool {
        self.theory.partly_bad || self.tests.iter().any(|test| test.partly_bad)
    }

    /// Findings by the name of their test, which is empty in a scene of one test and for what
    /// belongs to none.
    pub fn findings_by_test(&self) -> Vec<(String, Vec<Finding>)> {
        let several = self.tests.len() > 1;
        let name = |test: &str| {
            if several {
                test.to_owned()
            } else {
                String::new()
            }
        };
        let mut all: Vec<(String, Vec<Finding>)> = Vec::new();
        for test in &self.tests {
            let paired = self.comparison_findings.iter();
            let paired = paired.filter(|(test_name, _)| *test_name == test.name);
            let findings = test.modes.findings.iter();
            let findings = findings.chain(paired.flat_map(|(_, findings)| findings));
            all.push((name(&test.name), findings.cloned().collect()));
        }
        all.push((String::new(), self.theory.modes.findings.clone()));
        all
    }
}
