//! The next step after `run` and `update` follows from the worst finding: an update is advised only
//! where pairs exist and neither a sensor nor a support is in doubt.

use crate::correlate::{ComparisonTable, Row, Status, TestCell, mean_ratio};
use crate::finding::{Code, Finding, Location, Severity};
use crate::printable::{counted, listed};
use crate::report::table::significant;
use crate::scene::{Limits, Scene, SceneResult, SceneUpdate};
use crate::update::{ParameterVerdict, UpdatedParameter};

use super::agreement::{MIN_MAC, has_high_mac};
use super::frequency_ratio::frequency_ratio;

/// Maximum number of modes that agree by shape alone that a step names.
const MAX_NAMED_MATCHES: usize = 4;

/// Maximum number of parameters that a step names.
const MAX_NAMED_PARAMETERS: usize = 4;

/// The next step for the scene of this path; `None` where the model has no parameter to update.
pub fn next_step(path: &str, scene: &Scene, result: &SceneResult) -> Option<String> {
    let file = &scene.path;
    let of_model = &result.theory.modes.findings;
    let is_example = of_model
        .iter()
        .any(|finding| finding.code == Code::ExampleValues);
    if is_example {
        return Some(example_step());
    }
    let Some(table) = &result.table else {
        return Some(step_without_comparison(scene, result));
    };
    let findings = result.findings_by_test();
    let warnings = || {
        let all = findings.iter().flat_map(|(_, findings)| findings);
        all.filter(|finding| finding.severity > Severity::Info)
    };
    let first = |code: Code| warnings().find(|finding| finding.code == code);
    if table.summary.iter().all(|test| test.paired == 0) {
        return Some(step_without_pairs(file, result, first(Code::SensorUnmoved)));
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
            "Next, before an update: at_m of [[sensor]] in {file}, of which several are one ({explained})."
        ));
    }
    if let Some(finding) = first(Code::SensorNotRigid) {
        let (sensor, explained) = (sensor_name(finding), explained(finding.code));
        return Some(format!(
            "Next, before an update: check {sensor} in {file} ({explained})."
        ));
    }
    let of_support = [Code::SupportDiffers, Code::ModelSupportContradicted];
    if let Some(finding) = of_support.into_iter().find_map(first) {
        let explained = explained(finding.code);
        let supports = finding.detail.as_deref().unwrap_or_default();
        let supports = supports.split(';').next().unwrap_or_default();
        return Some(format!(
            "Next, before an update: correct the support that is wrong ({supports}): support in [test.state] of {file}, or the springs to ground of the model ({explained})."
        ));
    }
    if table.summary.iter().all(|test| test.paired_by_shape == 0) {
        return Some(by_frequency_step(path, result));
    }
    if let Some(step) = doubtful_pairs_step(file, table) {
        return Some(step);
    }
    let can_update = !result.theory.parameters.is_empty();
    can_update.then(|| {
        format!("Next, the parameters that bring the model to the test: modalign update {path}.")
    })
}

/// The step of a scene without a test, without a model, or without modes.
fn step_without_comparison(scene: &Scene, result: &SceneResult) -> String {
    let file = &scene.path;
    if result.tests.is_empty() {
        let table = scene.model.as_ref();
        let named = table.and_then(|model| model.name.clone());
        let model = named.unwrap_or_else(|| match table.and_then(|model| model.file.as_ref()) {
            Some(model) => scene.folder.join(model).display().to_string(),
            None => "MODEL".to_owned(),
        });
        return format!("Next, a test: modalign new DIR FILE... --model {model}.");
    }
    if result.tests.iter().all(|test| test.modes.modes.is_empty()) {
        return format!(
            "Next, as no modes were found: band_hz of [[test]], then method and order of [identify] in {file}; check units and coherence."
        );
    }
    format!(
        "Next, a model to compare with: [model] in {file}, or modalign new NEW-DIR FILE... --model beam (or lumped) --points FILE."
    )
}

/// The step where no mode of a test has a partner.
fn step_without_pairs(file: &str, result: &SceneResult, unmoved: Option<&Finding>) -> String {
    if let Some(matches) = shape_matches_step(result) {
        return matches;
    }
    if let Some(finding) = unmoved {
        let (sensor, explained) = (sensor_name(finding), explained(finding.code));
        return format!(
            "Next, as no mode is paired: the model does not move at {sensor}: [[sensor]] in {file}, or free directions of the model ({explained})."
        );
    }
    if frequency_ratio(result).is_some_and(|ratio| ratio.is_of_a_unit()) {
        return "Next, as no mode is paired: the units of the values in the model (m, kg, N, Pa; density in kg/m3)."
            .to_owned();
    }
    let mut assumptions = result.theory.assumptions.iter();
    if let Some(guess) = assumptions.find(|assumption| assumption.is_guess) {
        return format!(
            "Next, as no mode is paired: {} of {}, a guess of the draft: state from_m and to_m in the model; then points and directions of [[sensor]] in {file}.",
            guess.statement, guess.about
        );
    }
    format!(
        "Next, as no mode is paired: model, its support, and points and directions of [[sensor]] in {file}."
    )
}

/// The step after an update that fits, of a scene at this path: the check of its result, for which
/// a scene without limits states them first.
pub fn step_to_check(folder: &str, path: &str, scene: &Scene) -> String {
    let file = &scene.path;
    match scene.limits == Limits::default() {
        true => format!(
            "Next, limits that the updated model has to meet: [limits] in {file}; then modalign check {folder}/comparison-after.json --against {path}."
        ),
        false => format!(
            "Next, whether the updated model meets the limits: modalign check {folder}/comparison-after.json --against {path}."
        ),
    }
}

/// The next step after an update that does not fit or determines no parameter; `None` after others.
pub fn step_after_update(update: &SceneUpdate) -> Option<String> {
    let has = |code: Code| {
        update
            .findings
            .iter()
            .any(|(_, finding)| finding.code == code)
    };
    if has(Code::ExampleValues) {
        return Some(example_step());
    }
    let result = &update.result;
    if !result.stop_reason.converged() {
        let text = "Next, as the update did not converge: fewer parameters or tighter bounds in [update], or a higher max_iterations.";
        return Some(text.to_owned());
    }
    if let Some(found) = &result.contradiction {
        return Some(format!(
            "Next, as the configurations disagree: modify, parameters, tests and preload of {}; if {} does differ there, list it in separate.",
            found.configuration, found.parameter
        ));
    }
    if has(Code::SupportDiffers) {
        let code = explained(Code::SupportDiffers);
        return Some(format!(
            "Next, as supports of test and model differ: correct the wrong one ({code})."
        ));
    }
    let at_bound = |parameter: &&UpdatedParameter| parameter.verdict == ParameterVerdict::AtBound;
    let at_bound = result.parameters.iter().find(at_bound);
    if let Some(parameter) = at_bound.filter(|_| !result.fits()) {
        return Some(format!(
            "Next, as {} is at its bound and the model does not fit: wider bounds of it, if they are possible; else what the form of the model neglects.",
            parameter.name
        ));
    }
    if !result.fits() {
        let not_freed = update.not_freed();
        let trials = match (&update.explanation, result.parameters.len()) {
            (Some(_), _) => "the single changes: --full".to_owned(),
            // Of many, names are no advice.
            _ if (1..=MAX_NAMED_PARAMETERS).contains(&not_freed.len()) => {
                let names = listed(&not_freed);
                format!("parameters that the update does not free: {names}")
            }
            // A single change would be the update itself.
            (None, 1) => {
                "a further [[parameter]], such as a mass at a sensor or the stiffness of a support"
                    .to_owned()
            }
            (None, _) => "single changes of it (explain = true in [update])".to_owned(),
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

/// The step where pairs that an update can rely on do not outnumber the ambiguous ones and those of
/// low MAC.
fn doubtful_pairs_step(file: &str, table: &ComparisonTable) -> Option<String> {
    let cells = || table.rows.iter().flat_map(|row| &row.tests);
    let count = |is: &dyn Fn(&&TestCell) -> bool| cells().filter(is).count();
    let ambiguous = count(&|cell| cell.status == Status::Ambiguous);
    let reliable = count(&|cell| cell.status == Status::Paired && has_high_mac(cell));
    let low = count(&|cell| cell.status == Status::Paired && !has_high_mac(cell));
    let pairs = ambiguous + reliable + low;
    if reliable > ambiguous + low || pairs == 0 {
        return None;
    }
    let pairs = counted(pairs, "pair");
    Some(match ambiguous >= low {
        true => format!(
            "Next, before an update: {ambiguous} of {pairs} ambiguous: hits or sensors at more points or in more directions, and the frame and positions of [[sensor]] in {file}."
        ),
        false => format!(
            "Next, before an update: {low} of {pairs} without a MAC of {MIN_MAC}: the frame, positions and directions of [[sensor]] in {file}, then more points."
        ),
    })
}

/// The step where every pair is by frequency alone.
fn by_frequency_step(path: &str, result: &SceneResult) -> String {
    match result.theory.parameters.is_empty() {
        true => "Next, as all pairs are by frequency alone: mode shapes at more points, which confirm the pairs by MAC."
            .to_owned(),
        false => format!(
            "Next, as all pairs are by frequency alone: mode shapes at more points, which confirm the pairs by MAC. An update of frequencies alone: modalign update {path}."
        ),
    }
}

/// The modes whose shapes agree though no mode is paired, with the ratio of their frequencies.
fn shape_matches_step(result: &SceneResult) -> Option<String> {
    let table = result.table.as_ref()?;
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

#[cfg(test)]
mod tests {
    use crate::report::Language;

    #[test]
    fn every_next_step_is_said_in_chinese() {
        let source = include_str!("next_step.rs");
        let code = source.split("#[cfg(test)]").next().unwrap();
        let steps: Vec<&str> = code
            .split('"')
            .filter(|text| text.starts_with("Next, "))
            .collect();
        assert!(steps.len() >= 12, "{steps:?}");
        for step in steps {
            let chinese = Language::Chinese.translated_text(step.to_owned());
            assert!(chinese.starts_with("下一步"), "{step}: {chinese}");
        }
    }
}
