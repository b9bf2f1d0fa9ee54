//! Findings on damaged or incomplete files of the tests of a scene.

use crate::finding::{Finding, Severity};

use super::run::{load_finished_modes, test_data};
use super::{Scene, SceneError, TestPlan, TestSource};

/// Findings on the bad parts of the files of a test.
///
/// # Errors
/// [`SceneError`] for files that cannot be read, and for partly bad ones where the test does not
/// use their good part.
pub fn damage(scene: &Scene, test: &TestPlan) -> Result<Vec<Finding>, SceneError> {
    let (findings, partly_bad) = match &test.source {
        TestSource::Synth(_) => (Vec::new(), false),
        TestSource::Modes(path) => {
            let loaded = load_finished_modes(test, path)?;
            (loaded.modes.findings, loaded.partly_bad)
        }
        TestSource::Files { .. } => {
            let ingested = test_data(scene, test)?.ingested;
            (ingested.findings, ingested.partly_bad)
        }
    };
    Ok(match partly_bad {
        true => lost_part_findings(&findings),
        false => Vec::new(),
    })
}

/// The findings on the missing parts of a partly bad file.
pub fn lost_part_findings(findings: &[Finding]) -> Vec<Finding> {
    let is_lost = |finding: &&Finding| finding.severity == Severity::Error;
    findings.iter().filter(is_lost).cloned().collect()
}
