//! Updating as a scene means it: its tests or published frequencies, its model, `[update]`.

use crate::axis::Band;
use crate::correlate::ComparisonTable;
use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::FrfSet;
use crate::geometry::Sensor;
use crate::modal::{ModalModel, Mode, ModeShape, Scaling};
use crate::printable::counted;
use crate::theory::{MODIFICATION, ModeOptions, ParameterSpec, coordinate_sensors, is_stiffness};
use crate::update::{
    Configuration, Explanation, MeasuredModes, ParameterChoice, Prior, UpdateError, UpdateOptions,
    UpdateProblem, UpdateResult, check_always, explain, update,
};

use super::SceneError;
use super::configuration_tables::BASE_CONFIGURATION;
use super::error::value_error;
use super::expected::Expected;
use super::faults::Faults;
use super::file_faults::check_existence;
use super::model::{LoadedModel, OpenedModel, Theory, open_model};
use super::model_name::named_model;
use super::modes_file::is_modes_file;
use super::plan::Scene;
use super::run::{Comparison, NamedTest, compare_tests, run_test, theory_band};
use super::sensor_findings::{named, unmoved_sensors};
use super::supports::add_support_findings;
use super::test_agreement::disagreements;
use super::test_result::TestResult;
use super::toml_text::read_text;
use super::typed::{ModelTable, UpdateParameterTable, UpdateTable};
use super::update_findings::{comparison_findings, with_test_names};
use super::update_options::{residuals, stated_options, update_band};
use super::updated_model::{model_table_text, overrides_note, replace_nominal_values};

/// Name of the published frequencies among the tests.
const PUBLISHED: &str = "published";

/// Result of updating a scene's model.
#[derive(Clone, Debug)]
pub struct SceneUpdate {
    /// The tests of the base that counted.
    pub tests: Vec<TestResult>,
    /// The options, defaults included.
    pub options: UpdateOptions,
    /// The result.
    pub result: UpdateResult,
    /// The change that explains the misfit; `None` where it was not requested.
    pub explanation: Option<Explanation>,
    /// The configurations other than the base.
    pub configurations: Vec<ConfigurationUpdate>,
    /// The model before.
    pub theory_before: Theory,
    /// The model after.
    pub theory_after: Theory,
    /// The tests against the model before.
    pub before: ComparisonTable,
    /// The tests against the model after.
    pub after: ComparisonTable,
    /// The updated `model.toml`, or the `[model]` table of a scene for a model that has no such
    /// file.
    pub model_toml: String,
    /// Findings of the tests, the comparison and the update, each with the name of its test; empty
    /// where it has none or there is one test.
    pub findings: Vec<(String, Finding)>,
}

impl SceneUpdate {
    /// The tests of all configurations.
    pub fn all_tests(&self) -> impl Iterator<Item = &TestResult> + Clone {
        let others = self.configurations.iter().flat_map(|other| &other.tests);
        self.tests.iter().chain(others)
    }

    /// Names of the parameters of the model that could be free and are not.
    pub fn not_freed(&self) -> Vec<&str> {
        let freed = |name: &str| {
            let mut parameters = self.result.parameters.iter();
            parameters.any(|parameter| parameter.name == name)
        };
        let parameters = self.theory_before.parameters.iter();
        let specs = parameters.map(|(spec, _)| spec);
        let can_be_free = specs.filter(|spec| spec.name != MODIFICATION && !spec.whole);
        let names = can_be_free.map(|spec| spec.name.as_str());
        names.filter(|name| !freed(name)).collect()
    }

    /// The findings that bear on the update: those of the update and the comparison, and of the
    /// tests bad input, doubt about the verdict, and those on modes that the update uses.
    pub fn findings_on_update(&self) -> Vec<(String, Finding)> {
        let of_tests = |finding: &Finding| {
            let mut tests = self.all_tests();
            tests.any(|test| test.modes.findings.contains(finding))
        };
        let rows = &self.result.before.rows;
        let is_used = |hz: f64| {
            let mut used = rows.iter();
            used.any(|row| (row.test_hz - hz).abs() <= SAME_FREQUENCY * hz)
        };
        let bears = |(_, finding): &&(String, Finding)| {
            !of_tests(finding)
                || finding.severity == Severity::Error
                || Code::ON_THE_VERDICT.contains(&finding.code)
                || matches!(finding.location, Location::Mode(hz) if is_used(hz))
        };
        self.findings.iter().filter(bears).cloned().collect()
    }
}

/// Maximum relative difference of two writings of one frequency. Larger: findings on a close mode
/// are of this one. Smaller: rounding separates them. Test
/// `findings_of_an_update_are_those_that_bear_on_it`.
const SAME_FREQUENCY: f64 = 1e-9;

/// A configuration of a scene, ready to be updated.
struct LoadedConfiguration {
    name: String,
    scene: Scene,
    model: LoadedModel,
    sensors: Vec<Sensor>,
    tests: Vec<TestResult>,
    /// All that was measured.
    measured: Vec<Measured>,
    /// The part of it that counts.
    counted: Vec<Measured>,
    /// Whether the text of its model is another one than that of the base.
    has_text: bool,
    /// Parameters that keep the values of its model.
    held: Vec<String>,
    /// Free parameters that have another value than elsewhere.
    separate: Vec<String>,
}

/// A configuration other than the base before and after an update.
#[derive(Clone, Debug)]
pub struct ConfigurationUpdate {
    /// Name.
    pub name: String,
    /// Its tests that counted.
    pub tests: Vec<TestResult>,
    /// The model before.
    pub theory_before: Theory,
    /// The model after.
    pub theory_after: Theory,
    /// Its tests against the model before.
    pub before: ComparisonTable,
    /// Its tests against the model after.
    pub after: ComparisonTable,
    /// The updated model as text, where it is another one than that of the base.
    pub model_toml: Option<String>,
}

/// Updates the model of a scene; one without `[update]` with the defaults of all options. Tests of
/// several configurations update the parameters that their models share.
///
/// # Errors
/// [`SceneError`]: a scene without a model or without anything measured, options that have no
/// effect; those of the stages.
pub fn update_scene(scene: &Scene) -> Result<SceneUpdate, SceneError> {
    let stated = scene.update.clone().unwrap_or_default();
    let mut faults = Faults::default();
    faults.take(check_existence(scene.tests.iter().map(|test| &test.source)));
    faults.take(check_test_names(scene, &stated));
    let scenes = faults.take(scene.all_configurations());
    let base = || vec![(BASE_CONFIGURATION.to_owned(), scene.clone())];
    let scenes = scenes.unwrap_or_else(base);
    let opened = scenes.iter();
    let opened = opened.filter_map(|(_, configured)| faults.take(opened_model(configured)));
    let models: Vec<(LoadedModel, Vec<Sensor>)> = opened.collect();
    let band = faults.take(update_band(&stated, &scene.path));
    if !faults.is_empty() {
        let text = read_text(&scene.file).unwrap_or_default();
        faults = faults.located(&scene.path, &text);
    }
    let band = faults.finish(band)?;
    let mut all = Vec::with_capacity(scenes.len());
    for ((name, configured), (model, sensors)) in scenes.into_iter().zip(models) {
        let loaded = load(scene, &stated, name, configured, model, sensors)?;
        // The base has the parameters; another configuration without a test has nothing to say.
        if all.is_empty() || !loaded.measured.is_empty() {
            all.push(loaded);
        }
    }
    if all
        .iter()
        .all(|configuration| configuration.measured.is_empty())
    {
        let expected = "a [[test]], or published = true in [update]";
        let got = "nothing measured";
        return Err(value_error(&scene.path, "[update]", got, expected));
    }
    check_something_good(scene, &stated, band, &all)?;
    let (result, explanation) = updated(scene, &stated, &all)?;
    let mut outcomes = Vec::with_capacity(all.len());
    let mut findings = Vec::new();
    let measured = all.iter().map(|configuration| configuration.measured.len());
    let has_one_test = measured.sum::<usize>() == 1;
    let doubtful = all.iter().flat_map(|configuration| {
        doubtful_left_out(&configuration.measured, band, stated.doubtful_modes)
    });
    let doubtful: Vec<(String, Finding)> = doubtful.collect();
    for (configuration, values) in all.into_iter().zip(&result.configuration_values) {
        let outcome = compared(configuration, &stated, values)?;
        findings.extend(outcome.findings);
        // Configurations may have the same model.
        for finding in outcome.of_model {
            let finding = (String::new(), finding);
            if !findings.contains(&finding) {
                findings.push(finding);
            }
        }
        outcomes.push(outcome.update);
    }
    let of_update = result.findings().into_iter();
    findings.extend(of_update.map(|finding| (String::new(), finding)));
    findings.extend(doubtful);
    if has_one_test {
        findings.iter_mut().for_each(|(test, _)| test.clear());
    }
    let others = outcomes.split_off(1);
    let base = outcomes.remove(0);
    Ok(SceneUpdate {
        before: base.before,
        after: base.after,
        tests: base.tests,
        theory_before: base.theory_before,
        theory_after: base.theory_after,
        model_toml: base.model_toml.unwrap_or_default(),
        configurations: others,
        options: options(scene, &stated)?,
        result,
        explanation,
        findings,
    })
}

/// The model of a configuration with the sensors on it, checked before the long work on the tests.
fn opened_model(scene: &Scene) -> Result<(LoadedModel, Vec<Sensor>), SceneError> {
    let table = model_table_of(scene)?;
    let of_modes = || {
        let got = "a file of finished modes";
        value_error(&scene.path, "[model] file", got, "a model with parameters")
    };
    if is_modes_file(&named_model(table, &scene.folder, &scene.path)?) {
        return Err(of_modes());
    }
    let opened = open_model(table, &scene.folder, &scene.path, &scene.sensors)?;
    let OpenedModel::Model(model) = opened else {
        return Err(of_modes());
    };
    let sensors = sensors(&model, scene)?;
    check_moved_sensors(&model, &sensors, &scene.path)?;
    Ok((model, sensors))
}

fn model_table_of(scene: &Scene) -> Result<&ModelTable, SceneError> {
    let expected = "a model to update: `modalign new NEW-DIR FILE... --model beam` (or lumped, or a file), or [model] with `file` or `name`";
    let table = scene.model.as_ref();
    table.ok_or_else(|| value_error(&scene.path, "[model]", "no table", expected))
}

/// The tests of a configuration with what they measured.
fn load(
    whole: &Scene,
    stated: &UpdateTable,
    name: String,
    scene: Scene,
    model: LoadedModel,
    sensors: Vec<Sensor>,
) -> Result<LoadedConfiguration, SceneError> {
    let is_base = name == BASE_CONFIGURATION;
    let tests = counted_tests(&scene, stated, is_base)?;
    let measured = measured(&scene, stated, &tests, is_base)?;
    let band = update_band(stated, &scene.path)?;
    let counted = measured
        .iter()
        .map(|measured_modes| measured_modes.counted(band, stated.doubtful_modes))
        .collect();
    let mut tables = whole.configurations.iter();
    let table = tables.find(|table| table.name == name);
    Ok(LoadedConfiguration {
        held: table.map_or_else(Vec::new, |table| table.parameters.keys().cloned().collect()),
        separate: table.map_or_else(Vec::new, |table| table.separate.clone()),
        has_text: is_base || table.is_some_and(|table| table.model.is_some()),
        // Names tell configurations apart; a single one has none.
        name: match whole.configurations.is_empty() {
            true => String::new(),
            false => name,
        },
        scene,
        model,
        sensors,
        tests,
        measured,
        counted,
    })
}

/// Checks that a good mode counts, where there are any.
fn check_something_good(
    scene: &Scene,
    stated: &UpdateTable,
    band: Option<Band>,
    all: &[LoadedConfiguration],
) -> Result<(), SceneError> {
    let mut counted = all.iter().flat_map(|configuration| &configuration.counted);
    let has_doubtful = |configuration: &LoadedConfiguration| {
        let measured = &configuration.measured;
        !doubtful_left_out(measured, band, stated.doubtful_modes).is_empty()
    };
    if counted.all(|measured| measured.modes.modes.is_empty()) && all.iter().any(has_doubtful) {
        let expected = "good modes, or doubtful_modes = true";
        let got = "doubtful modes alone";
        return Err(value_error(&scene.path, "[update]", got, expected));
    }
    Ok(())
}

/// The update of the shared parameters, and its explanation where it is requested.
fn updated(
    scene: &Scene,
    stated: &UpdateTable,
    all: &[LoadedConfiguration],
) -> Result<(UpdateResult, Option<Explanation>), SceneError> {
    let measured: Vec<Vec<MeasuredModes<'_>>> = all
        .iter()
        .map(|configuration| {
            let counted = configuration.counted.iter();
            counted.map(Measured::as_measured_modes).collect()
        })
        .collect();
    let configurations = all.iter().zip(&measured);
    let configurations: Vec<Configuration<'_, '_>> = configurations
        .map(|(configuration, measured)| Configuration {
            name: &configuration.name,
            model: configuration.model.model.as_ref(),
            values: &configuration.model.values,
            sensors: &configuration.sensors,
            measured,
            held: &configuration.held,
            separate: &configuration.separate,
        })
        .collect();
    let models = all.iter().map(|configuration| ChoosableModel {
        model: &configuration.model,
        held: &configuration.held,
    });
    let choices = choices(stated, &models.collect::<Vec<_>>(), &scene.path)?;
    let options = options(scene, stated)?;
    let problem = UpdateProblem::of_configurations(&configurations, &choices, options);
    let problem = match problem {
        Err(error @ UpdateError::NothingPaired { .. }) => {
            return Err(nothing_paired(&all[0], error)?);
        }
        Err(
            error @ (UpdateError::SharedValue { .. }
            | UpdateError::Separate { .. }
            | UpdateError::NothingShared { .. }),
        ) => {
            let (got, expected) = ("parameters that do not agree", error.to_string());
            return Err(value_error(
                &scene.path,
                "[[configuration]]",
                got,
                &expected,
            ));
        }
        problem => problem?,
    };
    check_always(&problem, &stated.always)?;
    let result = update(&problem)?;
    let explanation = match stated.explain {
        true => Some(explain(&problem, &stated.always)?),
        false => None,
    };
    Ok((result, explanation))
}

/// The error of a model none of whose modes pairs, with its cause where that is known.
fn nothing_paired(
    base: &LoadedConfiguration,
    error: UpdateError,
) -> Result<SceneError, SceneError> {
    let scene = &base.scene;
    if let UpdateError::NothingPaired { modes } = error
        && base.model.example_values
    {
        let file = named_model(model_table_of(scene)?, &scene.folder, &scene.path)?;
        let modes = counted(modes, "test mode");
        let got = format!(
            "true: the values are those of an example, with which none of {modes} has a partner in the model"
        );
        let expected = "the dimensions, material and support of the structure in place of \
                        those of an example, and this line deleted";
        let file = file.display().to_string();
        return Ok(value_error(&file, "example_values", &got, expected));
    }
    let theory = base.model.solve(&base.sensors, &ModeOptions::default())?;
    let compared = compare_measured(scene, &base.measured, &base.tests, &theory)?;
    let findings = compared.findings.iter().flat_map(|(_, findings)| findings);
    let mut factors = findings.filter(|finding| finding.code == Code::CommonFactor);
    let Some(factor) = factors.next() else {
        return Ok(error.into());
    };
    let expected = "a model whose frequencies are those of the test within a factor of 2";
    let got = factor.to_string();
    Ok(value_error(&scene.path, "[model]", &got, expected))
}

/// A configuration before and after, with the findings of its tests and comparisons.
struct Compared {
    update: ConfigurationUpdate,
    /// Each with the name of its test.
    findings: Vec<(String, Finding)>,
    /// Warnings on the model.
    of_model: Vec<Finding>,
}

/// Compares the tests of a configuration with its model before and after.
fn compared(
    configuration: LoadedConfiguration,
    stated: &UpdateTable,
    values: &[f64],
) -> Result<Compared, SceneError> {
    let LoadedConfiguration {
        name,
        scene,
        model,
        sensors,
        tests,
        measured,
        has_text,
        ..
    } = configuration;
    let mode_options = ModeOptions {
        band: theory_band(&scene, &tests).filter(|_| !stated.published),
        ..ModeOptions::default()
    };
    let table = model_table_of(&scene)?;
    let model_toml = has_text.then(|| model_text(table, &model, &scene, values));
    let model_toml = model_toml.transpose()?;
    let theory_before = model.solve(&sensors, &mode_options)?;
    let updated = LoadedModel {
        values: values.to_vec(),
        ..model
    };
    let theory_after = updated.solve(&sensors, &mode_options)?;
    let compared = |theory: &Theory| compare_measured(&scene, &measured, &tests, theory);
    let (before, after) = (compared(&theory_before)?, compared(&theory_after)?);
    let mut findings = comparison_findings(&tests, before.findings, after.findings);
    let mut supported = theory_after.clone();
    let mut on_tests = Vec::new();
    let table = Some(&after.table);
    add_support_findings(&scene, &tests, &mut supported, table, &mut on_tests)?;
    // By the pairs of the model as it was, which `run` names too.
    let before_table = before.table.labelled_from(scene.first_root);
    on_tests.extend(disagreements(&tests, &before_table));
    findings.extend(with_test_names(on_tests));
    let of_model = supported.modes.findings.into_iter();
    let of_model = of_model.filter(|finding| finding.severity > Severity::Info);
    Ok(Compared {
        update: ConfigurationUpdate {
            before: before_table,
            after: after.table.labelled_from(scene.first_root),
            theory_before,
            theory_after,
            model_toml,
            name,
            tests,
        },
        findings,
        of_model: of_model.collect(),
    })
}

/// A finding for each doubtful mode that does not count, with the name of its test.
fn doubtful_left_out(
    measured: &[Measured],
    band: Option<Band>,
    counted: bool,
) -> Vec<(String, Finding)> {
    let modes = measured.iter().flat_map(|measured| {
        let modes = measured.modes.modes.iter();
        modes.map(|mode| (measured.name.as_str(), mode))
    });
    let inside =
        |(_, mode): &(&str, &Mode)| band.is_none_or(|band| band.contains(mode.frequency_hz));
    let doubtful = modes
        .filter(|(_, mode)| !counted && mode.is_doubtful())
        .filter(inside);
    let finding = |(test, mode): (&str, &Mode)| {
        let location = Location::Mode(mode.frequency_hz);
        let reasons = mode.quality.iter().flat_map(|quality| &quality.reasons);
        let codes = reasons.filter_map(|reason| Some(reason.split_once(':')?.0));
        let codes: Vec<&str> = codes.filter(|code| !code.contains(' ')).collect();
        let finding = Finding::new(Severity::Warning, Code::DoubtfulLeftOut, location);
        (test.to_owned(), finding.detail(codes.join(", ")))
    };
    doubtful.map(finding).collect()
}

/// Checks, before the long work on the tests, that the model moves at a sensor at least.
fn check_moved_sensors(
    model: &LoadedModel,
    sensors: &[Sensor],
    path: &str,
) -> Result<(), SceneError> {
    let unmoved = unmoved_sensors(model.model.as_ref(), &model.values, sensors)?;
    if sensors.is_empty() || unmoved.len() < sensors.len() {
        return Ok(());
    }
    let names: Vec<String> = unmoved.iter().map(|s| s.dof.to_string()).collect();
    let got = format!(
        "sensors at which the model does not move in their direction ({})",
        named(&names)
    );
    let expected = "directions of [[sensor]] in which the model moves (a beam along its \
                    `deflection`): without them no mode pairs and nothing can be updated";
    Err(value_error(path, "[[sensor]]", &got, expected))
}

/// Checks that `[update]` names tests of the scene.
fn check_test_names(scene: &Scene, stated: &UpdateTable) -> Result<(), SceneError> {
    let test_names: Vec<&str> = scene.tests.iter().map(|test| test.name.as_str()).collect();
    for name in stated.tests.iter().flatten() {
        if !test_names.contains(&name.as_str()) {
            let expected = format!("one of the tests {}", test_names.join(", "));
            let got = format!("{name:?}");
            return Err(value_error(&scene.path, "[update] tests", &got, &expected));
        }
    }
    Ok(())
}

/// The tests that `[update]` names; all of them where it names none, those of the base unless
/// published frequencies count.
fn counted_tests(
    scene: &Scene,
    stated: &UpdateTable,
    is_base: bool,
) -> Result<Vec<TestResult>, SceneError> {
    let counts = |name: &String| match &stated.tests {
        Some(names) => names.contains(name),
        None => !stated.published || !is_base,
    };
    let counted = scene.tests.iter().filter(|test| counts(&test.name));
    counted.map(|test| run_test(scene, test)).collect()
}

/// The modes of a test, or published frequencies.
#[derive(Clone)]
struct Measured {
    name: String,
    modes: ModalModel,
    /// Number of each mode in labels, which counts the modes outside the band too.
    numbers: Vec<usize>,
    frfs: Vec<FrfSet>,
}

impl Measured {
    fn of_test(test: &TestResult) -> Self {
        Self {
            name: test.name.clone(),
            modes: test.modes.clone(),
            numbers: (1..=test.modes.modes.len()).collect(),
            frfs: test.frfs.clone(),
        }
    }

    /// Published roots from which no parameter was inferred, numbered as the scene numbers the
    /// roots of its model.
    fn published(expected: &Expected, first_root: usize) -> Self {
        let mut collected = Self {
            name: PUBLISHED.to_owned(),
            modes: ModalModel::default(),
            numbers: Vec::new(),
            frfs: Vec::new(),
        };
        let elastic = expected.roots.iter().filter(|root| root.omega_rad_s > 0.0);
        for (number, root) in (first_root..).zip(elastic) {
            if root.calibrated {
                continue;
            }
            let hz = root.omega_rad_s / std::f64::consts::TAU;
            let hz = root.printed_hz.unwrap_or(hz);
            let mode = Mode {
                group: u32::try_from(number).ok().filter(|_| root.multiplicity > 1),
                ..Mode::new(hz, None, ModeShape::default(), Scaling::Unknown)
            };
            let modes = std::iter::repeat_n(mode, root.multiplicity);
            collected.modes.modes.extend(modes);
            let numbers = std::iter::repeat_n(number, root.multiplicity);
            collected.numbers.extend(numbers);
        }
        collected
    }

    /// The modes inside the band that are good, or all of them with the doubtful ones.
    fn counted(&self, band: Option<Band>, with_doubtful: bool) -> Self {
        let pairs = self.modes.modes.iter().zip(&self.numbers);
        let kept =
            pairs.filter(|(mode, _)| band.is_none_or(|band| band.contains(mode.frequency_hz)));
        let kept = kept.filter(|(mode, _)| with_doubtful || !mode.is_doubtful());
        let (modes, numbers) = kept.map(|(mode, number)| (mode.clone(), *number)).unzip();
        Self {
            name: self.name.clone(),
            modes: ModalModel {
                modes,
                band: band.or(self.modes.band),
                ..self.modes.clone()
            },
            numbers,
            frfs: self.frfs.clone(),
        }
    }

    fn as_measured_modes(&self) -> MeasuredModes<'_> {
        MeasuredModes {
            name: &self.name,
            modes: &self.modes,
            numbers: &self.numbers,
            frfs: &self.frfs,
        }
    }
}

/// Everything that was measured or published.
fn measured(
    scene: &Scene,
    stated: &UpdateTable,
    tests: &[TestResult],
    is_base: bool,
) -> Result<Vec<Measured>, SceneError> {
    let mut all: Vec<Measured> = tests.iter().map(Measured::of_test).collect();
    if stated.published && is_base {
        let expected = scene.expected.as_ref().ok_or_else(|| {
            let got = "no expected.toml beside the scene";
            value_error(&scene.path, "[update] published", got, "one with [[root]]")
        })?;
        all.push(Measured::published(expected, scene.first_root));
    }
    Ok(all)
}

/// The scene's sensors and the model's; without any, one on every coordinate.
fn sensors(model: &LoadedModel, scene: &Scene) -> Result<Vec<Sensor>, SceneError> {
    let model_sensors = model.sensors_with(&scene.sensors);
    if !model_sensors.is_empty() {
        return Ok(model_sensors);
    }
    let matrices = model.model.assemble(&model.values)?;
    Ok(coordinate_sensors(&matrices.coordinates))
}

fn options(scene: &Scene, stated: &UpdateTable) -> Result<UpdateOptions, SceneError> {
    Ok(UpdateOptions {
        residuals: residuals(stated, &scene.path)?,
        pair: scene.pair.clone(),
        ..stated_options(stated)
    })
}

/// A model with the parameters that keep their values.
#[derive(Clone, Copy)]
pub(super) struct ChoosableModel<'a> {
    pub model: &'a LoadedModel,
    pub held: &'a [String],
}

impl ChoosableModel<'_> {
    /// The parameters that may change, each with its index.
    fn parameters(&self) -> impl Iterator<Item = (usize, &ParameterSpec)> {
        let all = self.model.model.parameters().iter().enumerate();
        // The factor of added parts is no parameter of the structure.
        all.filter(|(_, spec)| spec.name != MODIFICATION && !self.held.contains(&spec.name))
    }
}

/// The parameters that are named; where none is, the stiffnesses of the models above 0.
pub(super) fn choices(
    stated: &UpdateTable,
    models: &[ChoosableModel<'_>],
    path: &str,
) -> Result<Vec<ParameterChoice>, SceneError> {
    let plain = |name: &str| ParameterChoice {
        name: name.to_owned(),
        ..ParameterChoice::default()
    };
    let mut all: Vec<ParameterChoice> = stated.parameters.iter().map(|n| plain(n)).collect();
    for table in &stated.parameter {
        all.push(choice(table, stated, models, path)?);
    }
    if all.is_empty() {
        for choosable in models {
            let LoadedModel { model, values, .. } = choosable.model;
            for (j, spec) in choosable.parameters() {
                let is_new = !all.iter().any(|choice| choice.name == spec.name);
                if is_new && values[j] > 0.0 && is_stiffness(model.as_ref(), values, j)? {
                    all.push(plain(&spec.name));
                }
            }
        }
    }
    if all.is_empty() {
        let expected = "names of parameters, because the model has no stiffness above 0";
        return Err(value_error(
            path,
            "[update] parameters",
            "nothing",
            expected,
        ));
    }
    Ok(all)
}

fn choice(
    table: &UpdateParameterTable,
    stated: &UpdateTable,
    models: &[ChoosableModel<'_>],
    path: &str,
) -> Result<ParameterChoice, SceneError> {
    let key = format!("[[update.parameter]] {:?} prior", table.name);
    let value = models.iter().find_map(|choosable| {
        let mut parameters = choosable.parameters();
        let (j, _) = parameters.find(|(_, spec)| spec.name == table.name)?;
        Some(choosable.model.values[j].abs())
    });
    let value = value.unwrap_or(0.0);
    let part = table.prior_std.or(stated.prior_std);
    let part = part.unwrap_or(UpdateOptions::default().prior_std);
    let prior = match table.prior.as_deref() {
        None => None,
        // No part of it is a width; the default is a normal one over the range.
        Some("normal") if value == 0.0 => None,
        Some("normal") => Some(Prior::Normal { std: part * value }),
        Some("log-normal") => Some(Prior::LogNormal { std: part }),
        Some(name) => {
            let expected = "\"log-normal\" or \"normal\"";
            return Err(value_error(path, &key, &format!("{name:?}"), expected));
        }
    };
    Ok(ParameterChoice {
        name: table.name.clone(),
        prior,
        prior_std: table.prior_std,
        lower: table.lower,
        upper: table.upper,
    })
}

/// Compares all measured modes with a model, those outside the band too.
fn compare_measured(
    scene: &Scene,
    measured: &[Measured],
    tests: &[TestResult],
    theory: &Theory,
) -> Result<Comparison, SceneError> {
    let named: Vec<NamedTest<'_>> = measured
        .iter()
        .map(|measured_modes| {
            let test = tests.iter().find(|test| test.name == measured_modes.name);
            NamedTest {
                name: &measured_modes.name,
                modes: &measured_modes.modes,
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
    // The factor of added parts, the last one, does not stand in the text.
    let specs: Vec<ParameterSpec> = model
        .model
        .parameters()
        .iter()
        .filter(|spec| spec.name != MODIFICATION)
        .cloned()
        .collect();
    let specs = specs.as_slice();
    let Some(file) = &named.file else {
        let name = named.name.clone().unwrap_or_default();
        return Ok(model_table_text("name", &name, specs, values));
    };
    let text = read_text(&named_model(named, &scene.folder, &scene.path)?)?;
    let replaced = replace_nominal_values(&text, specs, &model.values, values);
    let overrides = overrides_note(named.parameters.keys());
    Ok(replaced.map_or_else(
        || model_table_text("file", file, specs, values),
        |text| overrides + &text,
    ))
}
