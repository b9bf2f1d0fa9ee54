//! The next step after `run` and `update` follows from the worst finding: an update is advised only
//! where pairs exist and neither a sensor nor a support is in doubt.

use crate::correlate::{Row, mean_ratio};
use crate::finding::{Code, Finding, Location, Severity};
use crate::report::table::significant;
use crate::scene::{SceneResult, SceneUpdate};
use crate::update::{ParameterVerdict, UpdatedParameter};

/// Maximum number of modes that agree by shape alone that a step names.
const MAX_NAMED_MATCHES: usize = 4;

/// The next steps for the scene of this path; `None` where no test is compared with a model whose
/// values are those of the structure, or the model has no parameter to update.
pub fn next_step(scene: &str, result: &SceneResult) -> Option<String> {
    let of_model = &result.theory.modes.findings;
    let is_example = of_model
        .iter()
        .any(|finding| finding.code == Code::ExampleValues);
    let matches = shape_matches_step(result);
    if is_example {
        let steps = [Some(example_step()), matches];
        return Some(steps.into_iter().flatten().collect::<Vec<_>>().join("\n"));
    }
    let table = result.table.as_ref()?;
    let findings = result.findings_by_test();
    let warnings = || {
        let all = findings.iter().flat_map(|(_, findings)| findings);
        all.filter(|finding| finding.severity > Severity::Info)
    };
    let has = |code: Code| warnings().any(|finding| finding.code == code);
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
        return Some(matches.unwrap_or_else(|| text.to_owned()));
    }
    // Two sensors of two tests may well stand at one point.
    let dofs = table.summary.iter().map(|test| test.dofs_used).max();
    let most = dofs.unwrap_or(0) as f64;
    let are_one = |finding: &Finding| {
        let count = finding
            .value
            .filter(|count| most > 0.0 && 2.0 * count >= most);
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
    if table.summary.iter().all(|test| test.paired_by_shape == 0) {
        return Some(by_frequency_step(scene, result));
    }
    let can_update = !result.theory.parameters.is_empty();
    can_update.then(|| {
        format!("Next, the parameters that bring the model to the test: modalign update {scene}.")
    })
}

/// The next step after an update that does not fit or determines no parameter; `None` after others.
pub fn step_after_update(update: &SceneUpdate) -> Option<String> {
    let has = |code: Code| update.findings.iter().any(|finding| finding.code == code);
    if has(Code::ExampleValues) {
        return Some(example_step());
    }
    let result = &update.result;
    if !result.stop_reason.converged() {
        let text = "Next, as the update did not converge: fewer parameters or tighter bounds in [update], or a higher max_iterations.";
        return Some(text.to_owned());
    }
    if !result.fits() {
        let trials = match update.explanation {
            Some(_) => "the single changes above",
            None => "single changes of it (explain = true in [update])",
        };
        return Some(format!(
            "Next, as the updated model does not fit: support, positions and directions of sensors, and what the form of the model neglects; {trials}."
        ));
    }
    let is_identified =
        |parameter: &UpdatedParameter| parameter.verdict == ParameterVerdict::Identified;
    let identified = result.parameters.iter().any(is_identified);
    (!identified).then(|| {
        "Next, as the test determines no parameter: more modes or points, parameters that its modes depend on, or prior_std in [[update.parameter]]."
            .to_owned()
    })
}

fn explained(code: Code) -> String {
    format!("--explain {}", code.name())
}

fn example_step() -> String {
    let explained = explained(Code::ExampleValues);
    format!(
        "Next, before anything else: the values of the structure in model.toml, whose values are those of an example ({explained})."
    )
}

/// The step where every pair is by frequency alone.
fn by_frequency_step(scene: &str, result: &SceneResult) -> String {
    let update = match result.theory.parameters.is_empty() {
        true => String::new(),
        false => format!(" An update of frequencies alone: modalign update {scene}."),
    };
    format!(
        "Next, as all pairs are by frequency alone: mode shapes at more points, which confirm the pairs by MAC.{update}"
    )
}

/// The modes whose shapes agree though no mode is paired, with the ratio of their frequencies.
fn shape_matches_step(result: &SceneResult) -> Option<String> {
    let table = result.table.as_ref()?;
    if table.summary.iter().any(|test| test.paired > 0) {
        return None;
    }
    let mut pairings = result.pairings.iter();
    let matches = pairings
        .find_map(|pairing| Some(&pairing.by_shape_alone).filter(|matches| !matches.is_empty()))?;
    let ratio = mean_ratio(matches)?;
    let roots: Vec<&Row> = table
        .rows
        .iter()
        .filter(|row| row.theory.is_some())
        .collect();
    let named = matches.iter().take(MAX_NAMED_MATCHES).map(|one| {
        let label = roots
            .get(one.root)
            .map_or("a mode", |row| row.label.as_str());
        let (hz, mac) = (significant(one.test_hz, 5), one.mac);
        format!("{hz} Hz is {label} (MAC {mac:.3})")
    });
    let named: Vec<String> = named.collect();
    let ratio = significant(ratio, 3);
    Some(format!(
        "Next, as no mode is paired: by shape alone, test {}. Frequencies of the test are {ratio} times those of the model: check its dimensions and material.",
        named.join(", ")
    ))
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
