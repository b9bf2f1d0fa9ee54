//! The next step after `run` follows from the worst finding: an update is advised only where pairs
//! exist and neither a sensor nor a support is in doubt.

use crate::finding::{Code, Finding, Location, Severity};
use crate::scene::SceneResult;

/// The next step for the scene of this path; `None` where no test is compared with a model, or the
/// model has no parameter to update.
pub fn next_step(scene: &str, result: &SceneResult) -> Option<String> {
    let table = result.table.as_ref()?;
    let findings = result.findings_by_test();
    let warnings = || {
        let all = findings.iter().flat_map(|(_, findings)| findings);
        all.filter(|finding| finding.severity > Severity::Info)
    };
    let has = |code: Code| warnings().any(|finding| finding.code == code);
    let explained = |code: Code| format!("--explain {}", code.name());
    let wrong_sensor = warnings().find(|finding| finding.code == Code::SensorNotRigid);
    if table.summary.iter().all(|test| test.paired == 0) {
        let text = match has(Code::SensorUnmoved) {
            true => {
                "Next, as no mode is paired: the positions and directions of [[sensor]] in the model."
            }
            false => {
                "Next, as no mode is paired: model, its support, and points and directions of [[sensor]]."
            }
        };
        return Some(text.to_owned());
    }
    // Two sensors of two tests may well stand at one point.
    let dofs = table.summary.iter().map(|test| test.dofs_used).max();
    let most = dofs.unwrap_or(0) as f64;
    let are_one = |finding: &Finding| {
        let count = finding.value.filter(|count| 2.0 * count >= most);
        finding.code == Code::SensorsAtOnePosition && count.is_some()
    };
    if warnings().any(are_one) {
        let explained = explained(Code::SensorsAtOnePosition);
        return Some(format!(
            "Next, before an update: the positions of [[sensor]], of which several are one ({explained})."
        ));
    }
    if let Some(finding) = wrong_sensor {
        let (sensor, explained) = (sensor_name(finding), explained(finding.code));
        return Some(format!(
            "Next, before an update: check {sensor} ({explained})."
        ));
    }
    let of_support = [Code::SupportDiffers, Code::ModelSupportContradicted];
    if let Some(code) = of_support.into_iter().find(|code| has(*code)) {
        let explained = explained(code);
        return Some(format!(
            "Next, before an update: one support for test and model ({explained})."
        ));
    }
    let can_update = !result.theory.parameters.is_empty();
    can_update.then(|| {
        format!("Next, the parameters that bring the model to the test: modalign update {scene}.")
    })
}

/// The sensor or hit that a finding is about.
fn sensor_name(finding: &Finding) -> String {
    match &finding.location {
        Location::Function {
            response: Some(dof),
            ..
        } => format!("sensor {dof}"),
        Location::Function {
            reference: Some(dof),
            ..
        } => format!("hit {dof}"),
        location => location.to_string(),
    }
}
