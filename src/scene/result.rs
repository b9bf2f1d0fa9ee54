//! Results of a scene and of each of its tests.

use crate::correlate::{ComparisonTable, Pairing};
use crate::finding::{Code, Finding};
use crate::frf::{FrfSet, HitReport};
use crate::geometry::Geometry;
use crate::identify::PoleAtOrder;
use crate::io::modes_to_json;
use crate::modal::ModalModel;

use super::expected::ExpectedResult;
use super::limits::LimitCheck;
use super::model::Theory;
use super::placement::PlacedTest;
use super::recording::SyntheticRecording;

/// What one test came to.
#[derive(Clone, Debug, Default)]
pub struct TestResult {
    /// Name.
    pub name: String,
    /// Its FRFs, one set per axis; none for a test of finished modes.
    pub frfs: Vec<FrfSet>,
    /// Its hits with what the rules said of them.
    pub hits: Vec<HitReport>,
    /// Its modes.
    pub modes: ModalModel,
    /// Poles of all model orders, where the method has orders.
    pub stabilization: Vec<PoleAtOrder>,
    /// Nodes and lines of its files.
    pub geometry: Geometry,
    /// The recording, when it is synthetic.
    pub recording: Option<SyntheticRecording>,
    /// Whether part of the input was bad and left out.
    pub partly_bad: bool,
}

impl TestResult {
    /// The modes as `modes.json`.
    pub fn modes_json(&self) -> String {
        modes_to_json(&self.modes, None)
    }

    /// Whether it was computed from a model instead of measured.
    pub fn is_synthetic(&self) -> bool {
        let mut findings = self.modes.findings.iter();
        findings.any(|finding| finding.code == Code::Synthetic)
    }
}

/// What a scene came to.
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
