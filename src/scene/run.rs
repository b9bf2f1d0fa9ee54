//! Files or a synthetic recording become hits, FRFs and modes; the model becomes modes; both become
//! the comparison table.

use std::collections::BTreeSet;
use std::path::Path;

use crate::axis::Band;
use crate::correlate::{
    ComparisonTable, CorrelateError, DofMap, PairOptions, PairedTest, Pairing, compare, pair,
};
use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::{FrfError, FrfSet, evaluate_test, excited_part};
use crate::identify::{
    Identification, IdentifyOptions, Indicators, PoleAtOrder, PoleStatus, assess, identification,
    indicators,
};
use crate::io::{sha256_hex, sha256_of_bytes};
use crate::modal::{InputFile, ModalModel, Mode};
use crate::theory::{ModeOptions, ModelRoot, Support};

use super::SceneError;
use super::expected::ExpectedResult;
use super::faults::Faults;
use super::file_faults::{check_existence, collect_source_faults};
use super::ingest::{IngestOptions, Ingested, ingest_bytes, ingest_files};
use super::limits::{LimitCheck, check_comparison, check_modes};
use super::mass_line::{body_findings, leaving_list, mass_line_findings, test_rigid_body};
use super::model::{OpenedModel, Theory, open_model, table_model};
use super::modes_file::{LoadedModes, ModesOptions, load_modes};
use super::observer::Observer;
use super::placement::placed_tests;
use super::plan::Scene;
use super::quantities::quantities;
use super::recording::{SyntheticRecording, hammer_test, load_synth, record};
use super::result::SceneResult;
use super::sensor_findings::shared_points;
use super::supports::{add_support_findings, suspension_findings};
use super::test_agreement::disagreements;
use super::test_plan::{TestPlan, TestSource};
use super::test_result::TestResult;
use super::toml_text::read_text;
use super::update_options::check_parameter_names;

/// Maximum number of rejected columns that a result without modes lists.
const MAX_REJECTED_COLUMNS: usize = 3;

/// Runs a scene without an observer.
///
/// # Errors
/// As [`run_observed`].
pub fn run(scene: &Scene) -> Result<SceneResult, SceneError> {
    run_observed(scene, &())
}

/// Runs a scene; the observer gets a step for every test, for the model and for the comparison.
///
/// # Errors
/// [`SceneError`], with the name of the test where one test fails.
pub fn run_observed(scene: &Scene, observer: &dyn Observer) -> Result<SceneResult, SceneError> {
    let steps = scene.tests.len() + 2 * usize::from(scene.model.is_some());
    let step = |what: &str, number| observer.step(what, number, steps);
    let model = check_named_files(scene)?;
    let one = |(test, number): (&TestPlan, _)| {
        step(&test.name, number);
        run_test(scene, test)
    };
    let tests = scene.tests.iter().zip(1..).map(one);
    let tests = tests.collect::<Result<Vec<_>, _>>();
    let tests = tests.map_err(|error| with_source_faults(scene, error))?;
    let limits = tests.iter().flat_map(|test| mode_limits(scene, test));
    let mut limits: Vec<LimitCheck> = limits.collect();
    let Some(model) = model else {
        return tests_only_result(scene, tests, limits);
    };
    step("model", tests.len() + 1);
    let options = ModeOptions {
        band: theory_band(scene, &tests),
        ..ModeOptions::default()
    };
    let mut theory = model.theory(&scene.sensors, &options)?;
    let named: Vec<NamedTest> = tests
        .iter()
        .map(|test| NamedTest {
            name: &test.name,
            modes: &test.modes,
            frfs: &test.frfs,
        })
        .collect();
    step("comparison", steps);
    let comparison = match named.is_empty() {
        true => None,
        false => Some(compare_tests(&theory.modes, &named, &scene.pair)?),
    };
    let (table, mut comparison_findings, pairings) =
        comparison.map_or((None, Vec::new(), Vec::new()), |comparison| {
            let table = comparison.table.labelled_from(scene.first_root);
            (Some(table), comparison.findings, comparison.pairings)
        });
    add_support_findings(
        scene,
        &tests,
        &mut theory,
        table.as_ref(),
        &mut comparison_findings,
    )?;
    let between_tests = table.iter().flat_map(|table| disagreements(&tests, table));
    comparison_findings.extend(between_tests);
    limits.extend(
        table
            .iter()
            .flat_map(|table| check_comparison(&scene.limits, &table.summary)),
    );
    Ok(SceneResult {
        placements: placed_tests(&scene.placement, &tests, &theory.modes),
        tests,
        limits,
        expected: compare_published(scene, model_roots(&theory), theory.support.support())?,
        theory,
        comparison_findings,
        pairings,
        table,
    })
}

/// The model. Faults of the files that the scene names are reported before the long work on the
/// tests, all at once where there is one.
fn check_named_files(scene: &Scene) -> Result<Option<OpenedModel>, SceneError> {
    let mut faults = Faults::default();
    let sources = || scene.tests.iter().map(|test| &test.source);
    faults.take(check_existence(sources()));
    let open = |table| open_model(table, &scene.folder, &scene.path, &scene.sensors);
    let model = scene.model.as_ref().map(open).transpose();
    let model = faults.take(model.and_then(|model| check_parameters(scene, model)));
    for source in sources() {
        if let TestSource::Synth(path) = source {
            faults.take(load_synth(path));
        }
    }
    if !faults.is_empty() {
        for test in &scene.tests {
            collect_source_faults(&test.source, test.partial, &scene.path, &mut faults);
        }
        let text = read_text(&scene.file).unwrap_or_default();
        faults = faults.located(&scene.path, &text);
    }
    faults.finish(model)
}

/// An error of a test with the faults of the specs of all synthetic ones and, where the scene
/// describes the data wrongly, of the channels of all tests.
fn with_source_faults(scene: &Scene, error: SceneError) -> SceneError {
    let is_of_scene = matches!(
        error,
        SceneError::Value { .. } | SceneError::NotStated { .. } | SceneError::Several { .. }
    );
    let mut faults = Faults::default();
    for test in &scene.tests {
        if is_of_scene || matches!(test.source, TestSource::Synth(_)) {
            collect_source_faults(&test.source, test.partial, &scene.path, &mut faults);
        }
    }
    let text = error.to_string();
    let has_error = faults.0.iter().any(|fault| fault.to_string() == text);
    if !is_of_scene && !has_error {
        return error;
    }
    let mut all = Faults::default();
    all.add(error);
    faults.0.into_iter().for_each(|fault| all.add(fault));
    let text = read_text(&scene.file).unwrap_or_default();
    let Err(error) = all.located(&scene.path, &text).into_result() else {
        unreachable!("the error is one of the faults");
    };
    error
}

/// The model, checked to have every parameter that `[update]` names.
fn check_parameters(
    scene: &Scene,
    model: Option<OpenedModel>,
) -> Result<Option<OpenedModel>, SceneError> {
    if let (Some(update), Some(OpenedModel::Model(model))) = (&scene.update, &model) {
        let mut parameters = model.model.parameters().to_vec();
        for table in &scene.configurations {
            let other = scene.configuration(&table.name)?;
            let other = other.model.as_ref();
            let other = other.map(|table| table_model(table, &scene.folder, &scene.path));
            if let Some(other) = other.transpose()?.flatten() {
                parameters.extend(other.model.parameters().iter().cloned());
            }
        }
        check_parameter_names(update, &parameters, &scene.path)?;
    }
    Ok(model)
}

/// The published results, if there are any, compared with the model.
fn compare_published(
    scene: &Scene,
    roots: Option<&[ModelRoot]>,
    support: Option<Support>,
) -> Result<Option<ExpectedResult>, SceneError> {
    let Some(expected) = &scene.expected else {
        return Ok(None);
    };
    let quantities = quantities(scene, &expected.claims)?;
    Ok(Some(expected.compare(roots, quantities, support)))
}

/// Checks one test against `[[limits.mode]]`.
fn mode_limits(scene: &Scene, test: &TestResult) -> Vec<LimitCheck> {
    let found: Vec<_> = test
        .modes
        .modes
        .iter()
        .map(|mode| (mode.frequency_hz, mode.damping_ratio))
        .collect();
    let named = |check: LimitCheck| LimitCheck {
        what: format!("{}: {}", test.name, check.what),
        ..check
    };
    check_modes(&scene.limits, &found)
        .into_iter()
        .map(named)
        .collect()
}

/// A scene without a model ends with the modes of its tests.
fn tests_only_result(
    scene: &Scene,
    tests: Vec<TestResult>,
    limits: Vec<LimitCheck>,
) -> Result<SceneResult, SceneError> {
    Ok(SceneResult {
        tests,
        limits,
        placements: Vec::new(),
        expected: compare_published(scene, None, None)?,
        theory: Theory::default(),
        table: None,
        comparison_findings: Vec::new(),
        pairings: Vec::new(),
    })
}

/// From 0 Hz to beyond the highest band searched, by the frequency gate of the pairing.
pub(super) fn theory_band(scene: &Scene, tests: &[TestResult]) -> Option<Band> {
    let highest = tests
        .iter()
        .map(|test| test.modes.band.map(|band| band.hi_hz))
        .collect::<Option<Vec<_>>>()?;
    let hi_hz =
        highest.into_iter().fold(0.0, f64::max) / (1.0 - scene.pair.max_frequency_error.min(0.5));
    Band::new(0.0, hi_hz).ok()
}

pub(super) fn run_test(scene: &Scene, test: &TestPlan) -> Result<TestResult, SceneError> {
    let mut result = match &test.source {
        TestSource::Modes(path) => load_finished_modes(test, path)?,
        _ => {
            let data = test_data(scene, test)?;
            TestResult {
                recording: data.recording,
                ..identify_test(scene, test, data.ingested, data.inputs)?
            }
        }
    };
    result.geometry.add(&scene.points);
    let suspension = suspension_findings(&result.state, &result.modes);
    result.modes.findings.extend(suspension);
    let not_rigid = body_findings(&result.modes, &scene.sensors);
    result.modes.findings.extend(not_rigid);
    result.modes.findings.extend(shared_points(&scene.points));
    Ok(result)
}

/// Data of a test.
#[derive(Default)]
pub struct TestData {
    /// Its hits or FRFs; neither for a test of modes from a file.
    pub ingested: Ingested,
    /// Files that they come from.
    pub inputs: Vec<InputFile>,
    /// The recording, when it is synthetic.
    pub recording: Option<SyntheticRecording>,
}

/// Reads the files of a test, or computes its synthetic recording.
///
/// # Errors
/// [`SceneError`] for files that cannot be read and tests that cannot be computed.
pub fn test_data(scene: &Scene, test: &TestPlan) -> Result<TestData, SceneError> {
    match &test.source {
        TestSource::Modes(_) => Ok(TestData::default()),
        TestSource::Synth(path) => {
            let spec = load_synth(path)?;
            let recording = record(&spec, &hammer_test(&spec, path)?, path)?;
            let name = format!("{} (synthetic recording)", path.display());
            let input = InputFile {
                path: name.clone(),
                sha256: sha256_of_bytes(&recording.uff),
                dofs: Vec::new(),
            };
            let mut ingested = ingest_bytes(recording.uff.clone(), &name)?;
            let finding = Finding::new(Severity::Info, Code::Synthetic, Location::Whole);
            ingested.findings.push(finding.detail(spec.truth.source()));
            Ok(TestData {
                ingested,
                inputs: vec![input],
                recording: Some(recording),
            })
        }
        TestSource::Files {
            files,
            hits,
            trigger,
            typed,
        } => {
            let mut faults = Faults::default();
            let inputs = files.iter();
            let inputs: Vec<InputFile> = inputs
                .filter_map(|file| faults.take(input_file(&file.path)))
                .collect();
            faults.into_result()?;
            let (typed, partial) = (Some(typed.as_ref()), test.partial);
            let options = IngestOptions {
                hits: *hits,
                trigger: *trigger,
                typed,
                partial,
                frfs_first: false,
                format: scene.format.as_deref(),
                scene: &scene.path,
                ..IngestOptions::default()
            };
            let ingested = ingest_files(files, &options)?;
            Ok(TestData {
                inputs: add_file_dofs(inputs, &ingested),
                ingested,
                recording: None,
            })
        }
    }
}

/// The files, each with the degrees of freedom that no other file has.
pub(crate) fn add_file_dofs(mut inputs: Vec<InputFile>, ingested: &Ingested) -> Vec<InputFile> {
    for (input, dofs) in inputs.iter_mut().zip(&ingested.dofs_of_files) {
        input.dofs.clone_from(dofs);
    }
    inputs
}

fn input_file(path: &Path) -> Result<InputFile, SceneError> {
    Ok(InputFile {
        path: path.display().to_string(),
        sha256: sha256_hex(path)?,
        dofs: Vec::new(),
    })
}

pub(super) fn load_finished_modes(test: &TestPlan, path: &Path) -> Result<TestResult, SceneError> {
    let options = ModesOptions {
        partial: test.partial,
        ..ModesOptions::default()
    };
    let LoadedModes {
        mut modes,
        geometry,
        partly_bad,
    } = load_modes(path, &options)?;
    modes.band = test.band.or(modes.band);
    Ok(TestResult {
        name: test.name.clone(),
        state: test.state.clone(),
        modes,
        geometry,
        partly_bad,
        ..TestResult::default()
    })
}

fn identify_test(
    scene: &Scene,
    test: &TestPlan,
    data: Ingested,
    inputs: Vec<InputFile>,
) -> Result<TestResult, SceneError> {
    let of_test = |source: FrfError| SceneError::Frf {
        test: test.name.clone(),
        source: Box::new(source),
    };
    let mut findings = data.findings;
    let (mut hits, mut list) = (Vec::new(), None);
    let mut geometry = data.geometry.clone();
    geometry.add(&scene.points);
    let rigid_body = |set: &FrfSet| test_rigid_body(set, &geometry, &scene.sensors);
    let (frfs, body, band) = match data.recording {
        None => {
            let body = match data.frfs.as_slice() {
                [set] => rigid_body(set),
                _ => None,
            };
            (data.frfs, body, test.band)
        }
        Some(mut recording) => {
            let options = test.hammer_options(&scene.hammer);
            let hammer_result = evaluate_test(recording.as_mut(), &options).map_err(of_test)?;
            let body = rigid_body(&hammer_result.estimated.set);
            list = Some(leaving_list(&hammer_result, body.as_ref(), &test.state));
            let set = hammer_result.estimated.set;
            let band = search_band(&set, hammer_result.usable, test.band, &mut findings)
                .map_err(of_test)?;
            hits = hammer_result.hits;
            (vec![set], body, Some(band))
        }
    };
    if let (Some(body), [set]) = (&body, frfs.as_slice()) {
        findings.extend(mass_line_findings(set, body, &test.state));
    }
    let mut options = IdentifyOptions {
        band,
        partial: test.partial,
        ..IdentifyOptions::default()
    };
    options.method = scene.method.clone().unwrap_or(options.method);
    options.estimator.max_order = scene.order;
    let identified = identify_sets(&frfs, &options, &test.name)?;
    let mut modes = identified.model;
    findings.append(&mut modes.findings);
    modes.findings = findings;
    modes.inputs = inputs;
    let left_out = |finding: &Finding| finding.code == Code::ValueNotFinite;
    let partly_bad = data.partly_bad || modes.findings.iter().any(left_out);
    Ok(TestResult {
        name: test.name.clone(),
        state: test.state.clone(),
        frfs,
        hits,
        before_you_leave: list,
        modes,
        stabilization: identified.stabilization,
        geometry: data.geometry,
        recording: None,
        partly_bad,
    })
}

/// The requested band as far as the force excites it, else the usable band; adds a finding where it
/// is narrower than the requested one.
fn search_band(
    set: &FrfSet,
    usable: Band,
    wanted: Option<Band>,
    findings: &mut Vec<Finding>,
) -> Result<Band, FrfError> {
    let Some(wanted) = wanted else {
        findings.push(band_limited_finding(usable));
        return Ok(usable);
    };
    let band = excited_part(set, wanted, usable)?;
    if wanted.hi_hz > band.hi_hz {
        findings.push(band_limited_finding(band));
    }
    Ok(band)
}

fn band_limited_finding(band: Band) -> Finding {
    Finding::new(Severity::Info, Code::BandLimited, Location::Whole).value(band.hi_hz, "Hz")
}

/// A warning for each mode above the valid band.
fn modes_above_valid_band(modes: &ModalModel, valid: Option<Band>) -> Vec<Finding> {
    let Some(valid) = valid else {
        return Vec::new();
    };
    let frequencies = modes.modes.iter().map(|mode| mode.frequency_hz);
    let warning = |hz: f64| {
        Finding::new(Severity::Warning, Code::AboveValidBand, Location::Mode(hz))
            .value(hz, "Hz")
            .limit(valid.hi_hz)
    };
    frequencies
        .filter(|hz| *hz > valid.hi_hz)
        .map(warning)
        .collect()
}

/// The roots of a model; `None` for modes from a file.
fn model_roots(theory: &Theory) -> Option<&[ModelRoot]> {
    (!theory.roots.is_empty()).then_some(theory.roots.as_slice())
}

/// Modes of the FRFs of one test, in the band of the options or else in the valid band of the set.
///
/// # Errors
/// [`SceneError::Axes`] unless all functions have one axis; [`SceneError::Identify`] with the
/// test's name.
pub fn identify_sets(
    sets: &[FrfSet],
    options: &IdentifyOptions,
    test: &str,
) -> Result<Identification, SceneError> {
    let set = single_set(sets, test)?;
    let mut identification_result =
        identification(set, options).map_err(|source| SceneError::Identify {
            test: test.to_owned(),
            source: Box::new(source),
        })?;
    let model = &mut identification_result.model;
    if model.modes.is_empty() {
        let finding = Finding::new(Severity::Warning, Code::NoModeFound, Location::Whole);
        let rejected = rejected_columns(&identification_result.stabilization);
        model.findings.push(match rejected.is_empty() {
            true => finding,
            false => finding.detail(format!("rejected stable poles: {}", rejected.join(", "))),
        });
    }
    let outside = modes_above_valid_band(model, set.valid_band);
    model.findings.extend(outside);
    let is_of_force = |finding: &Finding| finding.code == Code::ForceLevelDependent;
    let (of_force, mut findings): (Vec<Finding>, Vec<Finding>) =
        set.findings.iter().cloned().partition(is_of_force);
    let at_mode = |finding| at_nearest_mode(finding, &model.modes);
    let of_force: Vec<Finding> = of_force.into_iter().map(at_mode).collect();
    model.findings.extend(of_force);
    assess(model);
    findings.append(&mut model.findings);
    model.findings = findings;
    Ok(identification_result)
}

/// Half-power bandwidths within which a resonance of the FRFs is an identified mode.
const MAX_DISTANCE_BANDWIDTHS: f64 = 1.0;

/// A finding about a resonance of the FRFs, at the identified mode there.
fn at_nearest_mode(finding: Finding, modes: &[Mode]) -> Finding {
    let Location::Mode(hz) = finding.location else {
        return finding;
    };
    let distance = |mode: &&Mode| (mode.frequency_hz - hz).abs();
    let nearest = modes
        .iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let is_there = |mode: &&Mode| {
        let width = 2.0 * mode.damping_ratio.unwrap_or(0.0) * mode.frequency_hz;
        distance(mode) <= MAX_DISTANCE_BANDWIDTHS * width
    };
    match nearest.filter(is_there) {
        Some(mode) => Finding {
            location: Location::Mode(mode.frequency_hz),
            ..finding
        },
        None => finding,
    }
}

/// The columns of stable poles of a stabilization diagram without modes, those over the most orders
/// first: frequency, damping and number of orders.
fn rejected_columns(poles: &[PoleAtOrder]) -> Vec<String> {
    let mut columns: Vec<Vec<&PoleAtOrder>> = Vec::new();
    for point in poles
        .iter()
        .filter(|point| point.status == PoleStatus::Stable)
    {
        let lambda = point.pole.lambda;
        let is_same = |column: &&mut Vec<&PoleAtOrder>| {
            (column[0].pole.lambda - lambda).norm() < lambda.re.abs()
        };
        match columns.iter_mut().find(is_same) {
            Some(column) => column.push(point),
            None => columns.push(vec![point]),
        }
    }
    columns.sort_by_key(|column| std::cmp::Reverse(column.len()));
    let text = |column: &Vec<&PoleAtOrder>| {
        let pole = column[column.len() / 2].pole;
        let percent = 100.0 * pole.damping_ratio();
        let (hz, orders) = (pole.natural_frequency_hz(), column.len());
        format!("{hz:.2} Hz, {percent:.2} % ({orders} orders)")
    };
    columns
        .iter()
        .take(MAX_REJECTED_COLUMNS)
        .map(text)
        .collect()
}

/// Mode indicator functions of the FRFs of one test.
///
/// # Errors
/// As [`identify_sets`].
pub fn indicators_of_sets(
    sets: &[FrfSet],
    options: &IdentifyOptions,
    test: &str,
) -> Result<Indicators, SceneError> {
    indicators(single_set(sets, test)?, options).map_err(|source| SceneError::Identify {
        test: test.to_owned(),
        source: Box::new(source),
    })
}

fn single_set<'a>(sets: &'a [FrfSet], test: &str) -> Result<&'a FrfSet, SceneError> {
    match sets {
        [set] => Ok(set),
        _ => Err(SceneError::Axes {
            test: test.to_owned(),
            got: sets.len(),
        }),
    }
}

/// The comparison table with the findings of the pairing.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The table.
    pub table: ComparisonTable,
    /// Findings of every pairing, by test.
    pub findings: Vec<(String, Vec<Finding>)>,
    /// The pairing of every test, in their order.
    pub pairings: Vec<Pairing>,
}

/// A test to be compared.
#[derive(Clone, Copy, Debug)]
pub struct NamedTest<'a> {
    /// Name, as it heads its columns.
    pub name: &'a str,
    /// Its modes.
    pub modes: &'a ModalModel,
    /// Its FRFs; empty when there are none.
    pub frfs: &'a [FrfSet],
}

/// Pairs each named test with the theory and makes the table.
///
/// # Errors
/// [`CorrelateError`].
pub fn compare_tests(
    theory: &ModalModel,
    tests: &[NamedTest<'_>],
    options: &PairOptions,
) -> Result<Comparison, CorrelateError> {
    let pairings = tests
        .iter()
        .map(|test| pair(test.modes, theory, options))
        .collect::<Result<Vec<Pairing>, _>>()?;
    let paired: Vec<PairedTest> = tests
        .iter()
        .zip(&pairings)
        .map(|(test, pairing)| PairedTest {
            name: test.name,
            model: test.modes,
            pairing,
            frfs: test.frfs,
        })
        .collect();
    let table = compare(theory, &paired, options)?;
    let findings = tests.iter().zip(&pairings);
    let findings = findings
        .map(|(test, pairing)| {
            let without = functions_without_partner(theory, test.frfs, &pairing.map);
            let all = pairing.findings.iter().cloned().chain(without);
            (test.name.to_owned(), all.collect())
        })
        .collect();
    Ok(Comparison {
        table,
        findings,
        pairings,
    })
}

/// A finding for each response and reference of the FRFs of a test that the theory lacks, though it
/// has shapes, and that the map of the shapes does not name: without it the observability is
/// unknown.
fn functions_without_partner(theory: &ModalModel, frfs: &[FrfSet], map: &DofMap) -> Vec<Finding> {
    let of_theory = theory.modes.iter().flat_map(|mode| mode.shape.iter());
    let of_theory: BTreeSet<Dof> = of_theory.map(|(dof, _)| dof.positive()).collect();
    let named: BTreeSet<Dof> = map.test_alone.iter().map(Dof::positive).collect();
    let is_missing =
        |dof: &Dof| !of_theory.contains(&dof.positive()) && !named.contains(&dof.positive());
    let functions = || frfs.iter().flat_map(FrfSet::functions);
    let responses: BTreeSet<&Dof> = functions().map(|function| &function.response).collect();
    let references: BTreeSet<&Dof> = functions().map(|function| &function.reference).collect();
    let responses = responses.into_iter().map(|dof| (Some(dof.clone()), None));
    let references = references.into_iter().map(|dof| (None, Some(dof.clone())));
    let finding = |(response, reference): (Option<Dof>, Option<Dof>)| {
        let location = Location::Function {
            response,
            reference,
        };
        Finding::new(Severity::Warning, Code::DofWithoutPartner, location)
    };
    let all = responses.chain(references).filter(|(response, reference)| {
        let dof = response.as_ref().or(reference.as_ref());
        !of_theory.is_empty() && dof.is_some_and(is_missing)
    });
    all.map(finding).collect()
}
