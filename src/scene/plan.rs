//! The plan of a scene has resolved paths and options, checked before data are read.

use std::path::{Path, PathBuf};

use crate::axis::Band;
use crate::correlate::{CorrelateError, PairOptions};
use crate::frf::{EstimateOptions, Estimator, Excitation, HammerOptions, ResponseWindow};
use crate::geometry::{Geometry, Node, Sensor};
use crate::identify::{IdentifyError, IdentifyOptions};
use crate::signal::{ForceWindow, Offset};

use super::SceneError;
use super::configuration_tables::check_configurations;
use super::error::value_error;
use super::expected::{Expected, published_results};
use super::faults::{Faults, Soundness, parse_checked};
use super::file_faults::collect_file_faults;
use super::limits::{LimitedResult, Limits, LimitsUse};
use super::model::sensors;
use super::model_name::{first_root, named_model};
use super::placement::{PlacementPlan, placement_plans};
use super::test_plan::{TestPlan, test_plan};
use super::toml_text::{check_schema, read_text, stated_schema};
use super::typed::{
    ConfigurationTable, FrfTable, IdentifyTable, ModelTable, PointTable, ReportTableTable,
    SCENE_SCHEMA, SceneFile, UpdateTable,
};
use super::update_options::check_update;

/// The flank of a force window as a fraction of its hold.
const FLANK_OF_HOLD: f64 = 0.5;

/// A scene, ready to run.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Path of the `scene.toml`, for messages.
    pub path: String,
    /// The `scene.toml`.
    pub file: PathBuf,
    /// Its folder.
    pub folder: PathBuf,
    /// Title of the report.
    pub title: String,
    /// The comparison tables, each with its caption and the names of its tests.
    pub tables: Vec<ReportTableTable>,
    /// Number of the first elastic root in the comparison.
    pub first_root: usize,
    /// Band of the roots whose energy is printed.
    pub energies: Option<Band>,
    /// Tests in order.
    pub tests: Vec<TestPlan>,
    /// Sensors and hits on the model.
    pub sensors: Vec<Sensor>,
    /// Positions of points that neither a file nor a sensor states.
    pub points: Geometry,
    /// The model; a scene without one compares nothing.
    pub model: Option<ModelTable>,
    /// How recorded hits become FRFs, except for options that a test states.
    pub hammer: HammerOptions,
    /// Identification method.
    pub method: Option<String>,
    /// Highest model order.
    pub order: Option<usize>,
    /// Pairing.
    pub pair: PairOptions,
    /// Tests for which additional points are selected.
    pub placement: Vec<PlacementPlan>,
    /// Options of updating; `None` for a scene that states none.
    pub update: Option<UpdateTable>,
    /// States of the machine other than that of the model.
    pub configurations: Vec<ConfigurationTable>,
    /// Limits.
    pub limits: Limits,
    /// Published results; `None` for a scene without an `expected.toml`.
    pub expected: Option<Expected>,
    /// Format of every file, from the command line; detected from the content when `None`.
    pub format: Option<String>,
}

/// Schema of a scene of any version.
const SCENE_FAMILY: &str = "modalign-scene/";

impl Scene {
    /// Whether a path names a scene: a folder, a file `scene.toml`, or another TOML file with the
    /// schema of a scene.
    pub fn is_path(path: &Path) -> bool {
        let is_toml = path
            .extension()
            .is_some_and(|extension| extension == "toml");
        let states_schema =
            |text: &str| stated_schema(text).is_some_and(|schema| schema.starts_with(SCENE_FAMILY));
        path.is_dir()
            || path.file_name().is_some_and(|name| name == "scene.toml")
            || is_toml && read_text(path).is_ok_and(|text| states_schema(&text))
    }

    /// Uses the good part of every partly bad file of the scene.
    pub fn accept_partial_files(&mut self) {
        for test in &mut self.tests {
            test.partial = true;
        }
        if let Some(model) = &mut self.model {
            model.partial = true;
        }
    }

    /// Reads a scene from its folder or its `scene.toml`.
    ///
    /// # Errors
    /// [`SceneError`] with file, line and column, or the key that cannot be meant.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        let file = if path.is_dir() {
            path.join("scene.toml")
        } else {
            path.to_path_buf()
        };
        let name = file.display().to_string();
        if path.is_dir() && !file.exists() {
            let expected =
                "a folder with scene.toml; `modalign new DIR FILE...` drafts one from recordings";
            let (path, got) = (path.display().to_string(), "a folder without scene.toml");
            return Err(value_error(&path, "scene", got, expected));
        }
        if file.is_file() && file.extension().is_none_or(|extension| extension != "toml") {
            let expected = "a folder with scene.toml, or that file; `modalign new DIR FILE...` drafts one from recordings";
            return Err(value_error(
                &name,
                "scene",
                "a file of another kind",
                expected,
            ));
        }
        let check = |typed: SceneFile, soundness| Self::checked(typed, soundness, &file);
        parse_checked(&read_text(&file)?, &name, check)
    }

    /// The scene of a typed file; where it has a fault, those of the files that it names are
    /// collected too.
    fn checked(typed: SceneFile, soundness: Soundness, file: &Path) -> Result<Self, SceneError> {
        let name = file.display().to_string();
        let folder = file.parent().unwrap_or(Path::new(".")).to_path_buf();
        let mut faults = Faults::default();
        faults.take(check_schema(&typed.schema, SCENE_SCHEMA, &name));
        let plans = typed.test.iter();
        let plans: Vec<Option<TestPlan>> = plans
            .map(|test| faults.take(test_plan(test, &folder, &name)))
            .collect();
        let names: Vec<&str> = typed.test.iter().map(|test| test.name.as_str()).collect();
        faults.take(check_tests(&names, typed.model.is_some(), &name));
        let limits_use = limits_use(!names.is_empty(), typed.model.is_some());
        faults.take(typed.limits.check(limits_use, &name));
        for error in typed.pair.faults() {
            faults.add(match error {
                CorrelateError::Option {
                    name: option,
                    got,
                    expected,
                } => value_error(
                    &name,
                    &format!("[pair] {option}"),
                    &got.to_string(),
                    expected,
                ),
                other => other.into(),
            });
        }
        faults.take(check_method(&typed.identify, &name));
        if let Some(table) = &typed.model {
            faults.take(named_model(table, &folder, &name));
        }
        if let Some(update) = &typed.update {
            faults.take(check_update(update, &name));
        }
        faults.take(check_configurations(&typed, &folder, &name));
        let report = &typed.report;
        let tables = report_tables(report.table.clone(), report.caption.clone(), &names, &name);
        let tables = faults.take(tables);
        let sensors = faults
            .take(sensors(&typed.sensor, &name))
            .unwrap_or_default();
        if typed.model.is_none() && !typed.placement.is_empty() {
            let got = "a scene without [model]";
            faults.add(value_error(&name, "[[placement]]", got, "a [model]"));
        }
        let placement = placement_plans(typed.placement.clone(), &names, &sensors, &name);
        let placement = faults.take(placement);
        let points = faults.take(stated_points(&typed.point, &name));
        let hammer = faults.take(hammer_options(&typed.frf, &name));
        let energies = faults.take(energies_band(report.energies_to_hz, &name));
        let expected = faults.take(published_results(&folder));
        if !faults.is_empty() || soundness == Soundness::Repaired {
            collect_file_faults(&typed, &folder, &name, &sensors, &mut faults);
        }
        faults.into_result()?;
        Ok(Self {
            placement: placement.unwrap_or_default(),
            tests: plans.into_iter().flatten().collect(),
            sensors,
            points: points.unwrap_or_default(),
            hammer: hammer.unwrap_or_default(),
            pair: typed.pair,
            first_root: report
                .first_root
                .unwrap_or_else(|| first_root_of(typed.model.as_ref())),
            energies: energies.flatten(),
            tables: tables.unwrap_or_default(),
            title: typed.title,
            model: typed.model,
            method: typed.identify.method,
            order: typed.identify.order,
            update: typed.update,
            configurations: typed.configuration,
            limits: typed.limits,
            expected: expected.flatten(),
            format: None,
            path: name,
            file: file.to_path_buf(),
            folder,
        })
    }
}

/// Number of the first elastic root of a scene that states none.
fn first_root_of(model: Option<&ModelTable>) -> usize {
    let name = model.and_then(|model| model.name.as_ref());
    name.map_or(1, |name| first_root(Path::new(name)))
}

/// Checks the options of `[identify]` before any file is read.
fn check_method(table: &IdentifyTable, path: &str) -> Result<(), SceneError> {
    let mut options = IdentifyOptions::default();
    options.method = table.method.clone().unwrap_or(options.method);
    options.estimator.max_order = table.order;
    let checked = options.validate().map_err(|error| {
        let (got, expected) = (format!("{:?}", options.method), error.to_string());
        match error {
            IdentifyError::OptionOutOfRange { got, expected, .. } => {
                value_error(path, "[identify] order", &got.to_string(), expected)
            }
            _ => value_error(path, "[identify] method", &got, &expected),
        }
    });
    checked.map(|_| ())
}

/// From 0 Hz to the highest root whose energy is printed.
fn energies_band(highest_hz: Option<f64>, path: &str) -> Result<Option<Band>, SceneError> {
    let band = highest_hz.map(|hz| Band::new(0.0, hz)).transpose();
    band.map_err(|error| {
        let got = format!("{highest_hz:?}");
        value_error(path, "[report] energies_to_hz", &got, &error.to_string())
    })
}

/// The tables as stated, every test in at least one; else one table of all tests.
fn report_tables(
    stated: Vec<ReportTableTable>,
    caption: Option<String>,
    names: &[&str],
    path: &str,
) -> Result<Vec<ReportTableTable>, SceneError> {
    let names: Vec<String> = names.iter().map(ToString::to_string).collect();
    if stated.is_empty() {
        let caption = caption.unwrap_or_else(|| "Theory and test compared".to_owned());
        return Ok(vec![ReportTableTable {
            caption,
            tests: names,
            notes: Vec::new(),
        }]);
    }
    if caption.is_some() {
        let got = "`caption` beside [[report.table]]";
        return Err(value_error(path, "[report]", got, "one of them"));
    }
    let mut faults = Faults::default();
    let tests = "[[report.table]] tests";
    if stated.iter().any(|table| table.tests.is_empty()) {
        faults.add(value_error(path, tests, "none", "at least one test"));
    }
    let shown: Vec<&String> = stated.iter().flat_map(|table| &table.tests).collect();
    for name in shown.iter().filter(|name| !names.contains(**name)) {
        let got = format!("{name:?}");
        let expected = format!("one of the tests {}", names.join(", "));
        faults.add(value_error(path, tests, &got, &expected));
    }
    // A misspelt name leaves its test without a table.
    if faults.is_empty() {
        for name in names.iter().filter(|name| !shown.contains(name)) {
            let got = format!("no table with {name:?}");
            let expected = "every test in a table";
            faults.add(value_error(path, "[[report.table]]", &got, expected));
        }
    }
    faults.into_result().map(|()| stated)
}

/// The nodes of `[[point]]` tables.
fn stated_points(tables: &[PointTable], path: &str) -> Result<Geometry, SceneError> {
    let mut points = Geometry::default();
    let mut faults = Faults::default();
    for PointTable { name, at_m } in tables {
        let key = format!("[[point]] {name}");
        let mut refuse = |got: &str, expected: &str| {
            faults.add(value_error(path, &key, got, expected));
        };
        if at_m.iter().any(|x| !x.is_finite()) {
            refuse(&format!("at_m = {at_m:?}"), "finite positions");
        } else if points.node(name).is_some() {
            refuse("the same point twice", "each one once");
        } else {
            points.nodes.push(Node::new(name, (*at_m).into()));
        }
    }
    faults.into_result().map(|()| points)
}

fn check_tests(names: &[&str], model: bool, path: &str) -> Result<(), SceneError> {
    if names.is_empty() && !model {
        let expected = "at least one, or a [model] alone";
        return Err(value_error(path, "[[test]]", "no test", expected));
    }
    for (index, name) in names.iter().enumerate() {
        if names[..index].contains(name) {
            return Err(value_error(
                path,
                "[[test]] name",
                &format!("{name:?} twice"),
                "a distinct name for each test",
            ));
        }
    }
    Ok(())
}

/// Results of a scene that decide its limits.
fn limits_use(has_tests: bool, has_model: bool) -> LimitsUse<'static> {
    match (has_tests, has_model) {
        (true, true) => LimitsUse {
            decided_by: &[LimitedResult::Comparison, LimitedResult::Modes],
            result: "a scene with [[test]] and [model]",
            expected: "any limits",
        },
        (true, false) => LimitsUse {
            decided_by: &[LimitedResult::Modes],
            result: "a scene without [model]",
            expected: "a [model], or [[limits.mode]] alone or with max_extra",
        },
        (false, _) => LimitsUse {
            decided_by: &[],
            result: "a scene without [[test]]",
            expected: "a [[test]], or no limits",
        },
    }
}

fn hammer_options(table: &FrfTable, path: &str) -> Result<HammerOptions, SceneError> {
    let mut faults = Faults::default();
    let estimator = faults.take(match table.estimator.as_deref() {
        None => Ok(Estimator::H1),
        Some(name) => Estimator::from_name(name).ok_or_else(|| {
            value_error(
                path,
                "[frf] estimator",
                &format!("{name:?}"),
                "\"h1\", \"h2\" or \"hv\"",
            )
        }),
    });
    let excitation = faults.take(match table.excitation.as_deref() {
        None => Ok(Excitation::Hammer),
        Some(name) => Excitation::from_name(name).ok_or_else(|| {
            let got = format!("{name:?}");
            value_error(
                path,
                "[frf] excitation",
                &got,
                "\"hammer\", \"random\" or \"sine\"",
            )
        }),
    });
    let window = |got: &str| {
        let expected = "\"auto\" or \"none\", or a number as response_window_end";
        value_error(path, "[frf] response_window", got, expected)
    };
    let stated = (table.response_window.as_deref(), table.response_window_end);
    let response_window = faults.take(match stated {
        (None | Some("auto"), None) => Ok(ResponseWindow::Auto),
        (Some("none"), None) => Ok(ResponseWindow::Off),
        (None, Some(end)) => Ok(ResponseWindow::End(end)),
        (Some(name), None) => Err(window(&format!("{name:?}"))),
        (Some(_), Some(_)) => Err(window("response_window_end beside it")),
    });
    let mut check = |name: &str, value: Option<f64>, accepts: fn(f64) -> bool, expected: &str| {
        if let Some(got) = value.filter(|value| !(value.is_finite() && accepts(*value))) {
            let key = format!("[frf] {name}");
            faults.add(value_error(path, &key, &got.to_string(), expected));
        }
    };
    let (length, hold) = (table.block_length_s, table.force_window_s);
    check(
        "block_length_s",
        length,
        |value| value > 0.0,
        "a finite time above 0 s",
    );
    check(
        "force_window_s",
        hold,
        |value| value >= 0.0,
        "a finite time of 0 s or more",
    );
    let ratio = table.noise_ratio;
    check(
        "noise_ratio",
        ratio,
        |value| value > 0.0,
        "a finite number above 0",
    );
    let is_fraction = |value: f64| value > 0.0 && value < 1.0;
    let end = table.response_window_end;
    check(
        "response_window_end",
        end,
        is_fraction,
        "a fraction between 0 and 1",
    );
    let checked = estimator.zip(excitation).zip(response_window);
    let ((estimator, excitation), response_window) = faults.finish(checked)?;
    Ok(HammerOptions {
        excitation,
        block_length_s: table.block_length_s,
        estimate: EstimateOptions {
            estimator,
            force_window: table.force_window_s.map(force_window),
            noise_ratio: table.noise_ratio,
            offset: offset(table.remove_offset),
            ..EstimateOptions::default()
        },
        response_window,
        cut_pretrigger: table.cut_pretrigger,
        keep_all: table.keep_all,
        ..HammerOptions::default()
    })
}

/// Treatment of the mean before the hit.
pub fn offset(remove: Option<bool>) -> Offset {
    match remove {
        None => Offset::RemoveIfPretrigger,
        Some(true) => Offset::Remove,
        Some(false) => Offset::Keep,
    }
}

/// A force window that holds for this long after the pulse.
pub fn force_window(hold_s: f64) -> ForceWindow {
    ForceWindow {
        hold_s,
        flank_s: FLANK_OF_HOLD * hold_s,
    }
}
