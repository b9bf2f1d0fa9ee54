//! Updating as a scene means it: its tests or published frequencies, its model, `[update]`.

use crate::axis::Band;
use crate::correlate::ComparisonTable;
use crate::finding::Finding;
use crate::geometry::Sensor;
use crate::modal::{ModalModel, Mode, ModeShape, Scaling};
use crate::theory::{ModeOptions, coordinate_sensors};
use crate::update::{
    Explanation, MeasuredModes, ParameterChoice, Prior, UpdateOptions, UpdateProblem, UpdateResult,
    explain, update,
};

use super::SceneError;
use super::chain::{Comparison, NamedTest, TestResult, compare_tests, run_test, theory_band};
use super::model::{LoadedModel, Theory, named_model, table_model, value_error};
use super::plan::Scene;
use super::toml_text::read_text;
use super::typed::{ModelTable, UpdateParameterTable, UpdateTable};
use super::updated_model::{replaced, table};

/// Name of the published frequencies beside the tests.
const PUBLISHED: &str = "published";

/// What updating a scene's model came to.
#[derive(Clone, Debug)]
pub struct SceneUpdate {
    /// The tests that counted.
    pub tests: Vec<TestResult>,
    /// The options, defaults included.
    pub options: UpdateOptions,
    /// The result.
    pub result: UpdateResult,
    /// Which change explains the misfit; `None` where it was not asked for.
    pub explanation: Option<Explanation>,
    /// The model before.
    pub theory_before: Theory,
    /// The model after.
    pub theory_after: Theory,
    /// The tests against the model before.
    pub before: ComparisonTable,
    /// The tests against the model after.
    pub after: ComparisonTable,
    /// The updated `model.toml`, or the `[model]` table of a scene for a model that has no such file.
    pub model_toml: String,
    /// What was said on the way.
    pub findings: Vec<Finding>,
}

/// Updates the model of a scene.
///
/// # Errors
/// [`SceneError`]: a scene without a model, without `[update]`, or without anything measured; those of the stages.
pub fn update_scene(scene: &Scene) -> Result<SceneUpdate, SceneError> {
    let stated = scene.update.clone().unwrap_or_default();
    let table = scene
        .model
        .as_ref()
        .ok_or_else(|| value_error(&scene.path, "[model]", "no table", "a model to update"))?;
    let model = table_model(table, &scene.folder, &scene.path)?.ok_or_else(|| {
        let got = "a file of finished modes";
        value_error(&scene.path, "[model] file", got, "a model with parameters")
    })?;
    let tests = counted_tests(scene, &stated)?;
    let measured = measured(scene, &stated, &tests)?;
    let sensors = sensors(&model, scene)?;
    let options = options(scene, &stated);
    let choices = choices(&stated, &model, &scene.path)?;
    let in_band: Vec<(String, ModalModel)> = measured
        .iter()
        .map(|(name, modes)| Ok((name.clone(), inside(modes, &stated, &scene.path)?)))
        .collect::<Result<_, SceneError>>()?;
    let own: Vec<MeasuredModes<'_>> = in_band
        .iter()
        .map(|(name, modes)| MeasuredModes { name, modes })
        .collect();
    let values = &model.values;
    let problem = UpdateProblem::new(
        model.model.as_ref(),
        values,
        &choices,
        &own,
        &sensors,
        options.clone(),
    )?;
    let result = update(&problem)?;
    let explanation = match stated.explain {
        true => Some(explain(&problem, &stated.always)?),
        false => None,
    };
    let model_toml = model_text(table, &model, scene, &result.values)?;
    let mode_options = ModeOptions {
        band: theory_band(scene, &tests).filter(|_| !stated.published),
        ..ModeOptions::default()
    };
    let theory_before = model.solve(&sensors, &mode_options)?;
    let updated = LoadedModel {
        values: result.values.clone(),
        ..model
    };
    let theory_after = updated.solve(&sensors, &mode_options)?;
    let compared = |theory: &Theory| compared(scene, &measured, &tests, theory);
    let (before, after) = (compared(&theory_before)?, compared(&theory_after)?);
    let mut findings: Vec<Finding> = tests
        .iter()
        .flat_map(|t| t.modes.findings.clone())
        .collect();
    findings.extend(after.findings.into_iter().flat_map(|(_, own)| own));
    findings.extend(result.findings());
    Ok(SceneUpdate {
        before: before.table.labelled_from(scene.first_root),
        after: after.table.labelled_from(scene.first_root),
        tests,
        options,
        result,
        explanation,
        theory_before,
        theory_after,
        model_toml,
        findings,
    })
}

/// The tests that `[update]` names; all of them where it names none and no published frequencies count.
fn counted_tests(scene: &Scene, stated: &UpdateTable) -> Result<Vec<TestResult>, SceneError> {
    let known: Vec<&str> = scene.tests.iter().map(|test| test.name.as_str()).collect();
    for name in stated.tests.iter().flatten() {
        if !known.contains(&name.as_str()) {
            let expected = format!("one of the tests {}", known.join(", "));
            let got = format!("{name:?}");
            return Err(value_error(&scene.path, "[update] tests", &got, &expected));
        }
    }
    let counts = |name: &String| match &stated.tests {
        Some(names) => names.contains(name),
        None => !stated.published,
    };
    let counted = scene.tests.iter().filter(|test| counts(&test.name));
    counted.map(|test| run_test(scene, test)).collect()
}

/// Names and modes of everything that was measured or published.
fn measured(
    scene: &Scene,
    stated: &UpdateTable,
    tests: &[TestResult],
) -> Result<Vec<(String, ModalModel)>, SceneError> {
    let own = tests
        .iter()
        .map(|test| (test.name.clone(), test.modes.clone()));
    let mut all: Vec<(String, ModalModel)> = own.collect();
    if stated.published {
        let expected = scene.expected.as_ref().ok_or_else(|| {
            let got = "no expected.toml beside the scene";
            value_error(&scene.path, "[update] published", got, "one with [[root]]")
        })?;
        let mut modes = ModalModel::default();
        let roots = expected.roots.iter().enumerate();
        for (number, root) in roots.filter(|(_, root)| !root.calibrated) {
            let hz = root.omega_rad_s / std::f64::consts::TAU;
            let mode = Mode {
                group: u32::try_from(number).ok().filter(|_| root.multiplicity > 1),
                ..Mode::new(
                    root.printed_hz.unwrap_or(hz),
                    None,
                    ModeShape::default(),
                    Scaling::Unknown,
                )
            };
            modes
                .modes
                .extend(std::iter::repeat_n(mode, root.multiplicity));
        }
        all.push((PUBLISHED.to_owned(), modes));
    }
    if all.is_empty() {
        let expected = "a [[test]], or published = true in [update]";
        return Err(value_error(
            &scene.path,
            "[update]",
            "nothing measured",
            expected,
        ));
    }
    Ok(all)
}

/// The modes inside the stated band.
fn inside(modes: &ModalModel, stated: &UpdateTable, path: &str) -> Result<ModalModel, SceneError> {
    let band = stated.band_hz.map(|[lo, hi]| Band::new(lo, hi)).transpose();
    let band = band.map_err(|error| {
        let got = format!("{:?}", stated.band_hz.unwrap_or_default());
        value_error(path, "[update] band_hz", &got, &error.to_string())
    })?;
    let mut own = modes.clone();
    own.modes
        .retain(|mode| band.is_none_or(|band| band.contains(mode.frequency_hz)));
    Ok(own)
}

/// The scene's sensors and the model's; without any, one on every coordinate.
fn sensors(model: &LoadedModel, scene: &Scene) -> Result<Vec<Sensor>, SceneError> {
    let own = model.sensors_with(&scene.sensors);
    if !own.is_empty() {
        return Ok(own);
    }
    let matrices = model.model.assemble(&model.values)?;
    Ok(coordinate_sensors(&matrices.coordinates))
}

fn options(scene: &Scene, stated: &UpdateTable) -> UpdateOptions {
    let default = UpdateOptions::default();
    let floor = stated.shape_floor.or(default.shape_floor);
    UpdateOptions {
        frequency_floor: stated.frequency_floor.unwrap_or(default.frequency_floor),
        shape_floor: floor.filter(|_| stated.shapes != Some(false)),
        prior_std: stated.prior_std.unwrap_or(default.prior_std),
        starts: stated.starts.unwrap_or(default.starts),
        seed: stated.seed.unwrap_or(default.seed),
        max_iterations: stated.max_iterations.unwrap_or(default.max_iterations),
        pair: scene.pair.clone(),
    }
}

/// The parameters that are named; where none is, all of the model above 0.
fn choices(
    stated: &UpdateTable,
    model: &LoadedModel,
    path: &str,
) -> Result<Vec<ParameterChoice>, SceneError> {
    let plain = |name: &str| ParameterChoice {
        name: name.to_owned(),
        ..ParameterChoice::default()
    };
    let mut all: Vec<ParameterChoice> = stated.parameters.iter().map(|n| plain(n)).collect();
    for table in &stated.parameter {
        all.push(choice(table, stated, model, path)?);
    }
    if all.is_empty() {
        let specs = model.model.parameters().iter().zip(&model.values);
        let above = specs.filter(|(_, value)| **value > 0.0);
        all.extend(above.map(|(spec, _)| plain(&spec.name)));
    }
    Ok(all)
}

fn choice(
    table: &UpdateParameterTable,
    stated: &UpdateTable,
    model: &LoadedModel,
    path: &str,
) -> Result<ParameterChoice, SceneError> {
    let key = format!("[[update.parameter]] {:?} prior", table.name);
    let specs = model.model.parameters().iter().zip(&model.values);
    let value = specs
        .filter(|(spec, _)| spec.name == table.name)
        .map(|(_, v)| v.abs())
        .next();
    let part = table.prior_std.or(stated.prior_std);
    let part = part.unwrap_or(UpdateOptions::default().prior_std);
    let prior = match table.prior.as_deref() {
        None if table.prior_std.is_none() => None,
        Some("normal") => Some(Prior::Normal {
            std: part * value.unwrap_or(0.0),
        }),
        None | Some("log-normal") => Some(Prior::LogNormal { std: part }),
        Some(name) => {
            let got = format!("{name:?}");
            return Err(value_error(
                path,
                &key,
                &got,
                "\"log-normal\" or \"normal\"",
            ));
        }
    };
    Ok(ParameterChoice {
        name: table.name.clone(),
        prior,
        lower: table.lower,
        upper: table.upper,
    })
}

/// All that was measured against a model: modes that did not count, too.
fn compared(
    scene: &Scene,
    measured: &[(String, ModalModel)],
    tests: &[TestResult],
    theory: &Theory,
) -> Result<Comparison, SceneError> {
    let named: Vec<NamedTest<'_>> = measured
        .iter()
        .map(|(name, modes)| {
            let test = tests.iter().find(|test| test.name == *name);
            NamedTest {
                name,
                modes,
                frfs: test.map_or(&[], |test| test.frfs.as_slice()),
            }
        })
        .collect();
    Ok(compare_tests(&theory.modes, &named, &scene.pair)?)
}

/// The updated model as text.
fn model_text(
    named: &ModelTable,
    model: &LoadedModel,
    scene: &Scene,
    values: &[f64],
) -> Result<String, SceneError> {
    let specs = model.model.parameters();
    let Some(file) = &named.file else {
        let name = named.name.clone().unwrap_or_default();
        return Ok(table("name", &name, specs, values));
    };
    let text = read_text(&named_model(named, &scene.folder, &scene.path)?)?;
    Ok(replaced(&text, specs, values).unwrap_or_else(|| table("file", file, specs, values)))
}
