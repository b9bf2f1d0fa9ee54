//! Findings on damaged or incomplete files of the tests of a scene.

use crate::finding::{Finding, Severity};

use super::run::{finished_modes, test_data};
use super::{Scene, SceneError, TestPlan, TestSource};

/// Findings on the bad parts of the files of a test; none where all were sound.
///
/// # Errors
/// [`SceneError`] for files that cannot be read, or that are partly bad where the test does not go
/// on with their good part.
pub fn damage(scene: &Scene, test: &TestPlan) -> Result<Vec<Finding>, SceneError> {
    let (findings, partly_bad) = match &test.source {
        TestSource::Synth(_) => (Vec::new(), false),
        TestSource::Modes(path) => {
            let loaded = finished_modes(test, path)?;
            (loaded.modes.findings, loaded.partly_bad)
        }
        TestSource::Files { .. } => {
            let ingested = test_data(scene, test)?.ingested;
            (ingested.findings, ingested.partly_bad)
        }
    };
    Ok(match partly_bad {
        true => lost_parts(&findings),
        false => Vec::new(),
    })
}

/// The findings on what was left out of a partly bad file.
pub fn lost_parts(findings: &[Finding]) -> Vec<Finding> {
    let is_lost = |finding: &&Finding| finding.severity == Severity::Error;
    findings.iter().filter(is_lost).cloned().collect()
}
