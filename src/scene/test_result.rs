//! The result of a test holds its FRFs, its hits and its modes.

use crate::finding::Code;
use crate::frf::{BeforeYouLeave, FrfSet, HitReport};
use crate::geometry::Geometry;
use crate::identify::PoleAtOrder;
use crate::io::modes_to_json;
use crate::modal::ModalModel;

use super::recording::SyntheticRecording;
use super::test_state::TestState;

/// Result of one test.
#[derive(Clone, Debug, Default)]
pub struct TestResult {
    /// Name.
    pub name: String,
    /// Support, loads and date, as the scene states them.
    pub state: TestState,
    /// Its FRFs, one set per axis; none for a test of modes from a file.
    pub frfs: Vec<FrfSet>,
    /// Its hits with their checks.
    pub hits: Vec<HitReport>,
    /// What to repeat before the structure is gone; `None` without recordings.
    pub before_you_leave: Option<BeforeYouLeave>,
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
