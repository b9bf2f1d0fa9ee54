//! `modalign check`: a result against limits or a baseline.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::error::Error;
use crate::io::{MODES_SCHEMA, check_result, modes_from_json};
use crate::modal::ModalModel;
use crate::report::json::{
    COMPARISON_SCHEMA, ComparisonFile, JsonError, REPORT_FILE, TestFile, UPDATE_SCHEMA,
    comparison_from_json,
};
use crate::report::{regression_check_blocks, regression_check_screen};
use crate::scene::{
    Change, ChangeLimits, LimitCheck, LimitedResult, LimitsUse, MAX_MAC_CHANGE, Measure,
    RowVerdict, UncertainValue, check_changes, check_comparison, check_modes, limits_from_toml,
    mode_changes, percent, read_text, relative_change, std_change,
};

use super::args::CheckArgs;
use super::check_update::{self, UpdateResult, update_changes};
use super::junit::junit;
use super::not_compared::not_compared;
use super::outcome::Outcome;
use super::output::Output;
use super::targets::{check_targets, targets};

/// Largest change of a theory's frequency, percent: the same model gives the same roots up to
/// rounding.
const MAX_THEORY_CHANGE_PERCENT: f64 = 1e-4;

/// Name of the file of a scene.
const SCENE_FILE: &str = "scene.toml";

/// A result of any kind.
enum ResultFile {
    Comparison(ComparisonFile),
    Modes(ModalModel),
    Update(UpdateResult),
}

impl ResultFile {
    /// Keys whose values are compared with those of a baseline.
    fn compared_keys(&self) -> &'static [&'static str] {
        match self {
            ResultFile::Comparison(_) => &[
                "rows.theory.hz",
                "rows.tests.hz",
                "rows.tests.hz_std",
                "rows.tests.error_hz",
                "rows.tests.normalised_error",
                "rows.tests.damping_ratio",
                "rows.tests.damping_std",
                "rows.tests.mac",
            ],
            ResultFile::Modes(_) => &[
                "modes.frequency_hz",
                "modes.frequency_std_hz",
                "modes.frequency_bias_hz",
                "modes.damping_ratio",
                "modes.damping_std",
                "modes.damping_bias",
                "modes.pole_rad_s",
                "modes.shape",
                "modes.shape_std",
                "modes.residues",
                "modes.modal_mass_kg",
                "modes.scaling",
            ],
            ResultFile::Update(_) => check_update::COMPARED_KEYS,
        }
    }
}

/// Exit code 0 when every limit is met, 1 when one is missed.
pub fn check(args: &CheckArgs, output: &mut Output) -> Result<Outcome, Error> {
    let against = &baseline_path(args)?;
    let read = [args.result.clone(), against.clone()];
    check_targets(&targets([("--junit", args.junit.as_ref())]), &read)?;
    let (result, _) = read_result(&args.result)?;
    let is_json = against
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
    let (rows, not_compared) = if is_json {
        let (baseline, value) = read_result(against)?;
        let not_compared = not_compared(&value, baseline.compared_keys());
        (
            against_baseline(&result, &baseline, against, args)?,
            not_compared,
        )
    } else {
        (against_limits(&result, args, against)?, Vec::new())
    };
    if rows.is_empty() {
        return Err(Error::Argument {
            argument: "--against",
            got: format!("{}, which states no limit for this kind of result", against.display()),
            expected: "a TOML file with [limits] for this kind of result, or an earlier result of the same kind".to_owned(),
        });
    }
    if let Some(path) = &args.junit {
        let suite = args.result.display().to_string();
        let against = against.display().to_string();
        output.add_file(path, junit(&suite, &against, &rows));
    }
    output.add_result(
        |width| regression_check_screen(&rows, &not_compared, width),
        || regression_check_blocks(&rows, &not_compared),
    );
    output.add_json(|| checks_json(&rows, &not_compared));
    Ok(Outcome::missed_if(rows.iter().any(|row| !row.is_met())))
}

/// The limits or the baseline: of a folder its scene.
///
/// # Errors
/// [`Error::Argument`] with the usual command, where a scene stands in the place of the result, or
/// without `--against`.
fn baseline_path(args: &CheckArgs) -> Result<PathBuf, Error> {
    let result = &args.result;
    let (scene, is_toml) = (
        result.display(),
        result.extension().is_some_and(|e| e == "toml"),
    );
    if result.is_dir()
        && let Some(file) = first_result(result)
    {
        let file = file.display();
        let expected = match scene_of_results(result) {
            Some(scene) if states_limits(&scene) => {
                format!("one of its results: `modalign check {file} --against {scene}`")
            }
            scene => without_limits(&file.to_string(), scene),
        };
        return Err(Error::Argument {
            argument: "RESULT",
            got: format!("{scene}, the folder of results"),
            expected,
        });
    }
    if is_toml || result.is_dir() {
        return Err(Error::Argument {
            argument: "RESULT",
            got: format!("{scene}, which is no result of a command"),
            expected: format!(
                "a result: `modalign run {scene} -o DIR`, then `modalign check DIR/comparison.json --against {scene}`"
            ),
        });
    }
    let against = args.against.as_ref().ok_or_else(|| {
        let folder = result.parent().and_then(scene_of_results);
        let expected = match folder {
            Some(folder) if !states_limits(&folder) => {
                without_limits(&scene.to_string(), Some(folder))
            }
            _ => format!(
                "limits or a baseline: `modalign check {scene} --against SCENE`, or an earlier result of the same kind"
            ),
        };
        Error::Argument {
            argument: "--against",
            got: "none".to_owned(),
            expected,
        }
    })?;
    Ok(match against.is_dir() {
        true => against.join("scene.toml"),
        false => against.clone(),
    })
}

/// Whether the scene in a folder has a table of limits.
fn states_limits(folder: &str) -> bool {
    let text = read_text(&Path::new(folder).join(SCENE_FILE));
    let scene = text.ok().and_then(|text| text.parse::<toml::Table>().ok());
    scene.is_some_and(|scene| scene.contains_key("limits"))
}

/// What a result is checked against where no scene states limits.
fn without_limits(result: &str, scene: Option<String>) -> String {
    let file = scene.map_or_else(
        || "a TOML file".to_owned(),
        |scene| Path::new(&scene).join(SCENE_FILE).display().to_string(),
    );
    format!(
        "an earlier result as baseline: `modalign check {result} --against EARLIER.json` (a copy of it, kept before a change), or limits: [limits] with `min_mac = 0.9` in {file}"
    )
}

/// The first result in a folder: of a comparison, else of an update, else the first modes.
fn first_result(folder: &Path) -> Option<PathBuf> {
    let files = std::fs::read_dir(folder).ok()?.filter_map(Result::ok);
    let files = files.map(|file| file.file_name().to_string_lossy().into_owned());
    let rank = |name: &String| match name.as_str() {
        "comparison.json" => Some(0),
        "update.json" => Some(1),
        // The truth of a synthetic test is no result.
        name if name.ends_with(".truth.modes.json") => None,
        name if name.ends_with("modes.json") => Some(2),
        _ => None,
    };
    let ranked = files.filter_map(|name| Some((rank(&name)?, name)));
    ranked.min().map(|(_, name)| folder.join(name))
}

/// The folder of the scene that the report of a run names, else the folder above that has one.
fn scene_of_results(folder: &Path) -> Option<String> {
    let text = read_text(&folder.join(REPORT_FILE)).ok();
    let report = text.and_then(|text| serde_json::from_str::<Value>(&text).ok());
    let stated = report.as_ref().and_then(|report| {
        let files = report["provenance"]["stated"].as_array()?;
        let mut paths = files.iter().filter_map(|file| file["path"].as_str());
        paths
            .find(|path| path.ends_with(SCENE_FILE))
            .map(PathBuf::from)
    });
    let above = folder.parent().map(|parent| parent.join(SCENE_FILE));
    let mut scenes = stated.into_iter().chain(above);
    let scene = scenes.find(|scene| scene.is_file())?;
    let scene = scene
        .parent()
        .filter(|parent| !parent.as_os_str().is_empty());
    Some(scene.unwrap_or(Path::new(".")).display().to_string())
}

/// A result, with all values of its file.
fn read_result(path: &Path) -> Result<(ResultFile, Value), Error> {
    let (text, name) = (read_text(path)?, path.display().to_string());
    let value: Value = serde_json::from_str(&text)
        .map_err(|error| argument_error(&format!("{name}: {error}"), "JSON"))?;
    let schema = value.get("schema").and_then(Value::as_str);
    let result = match schema {
        Some(COMPARISON_SCHEMA) => comparison_from_json(&text)
            .map(ResultFile::Comparison)
            .map_err(|error| json_error(&name, error)),
        Some(MODES_SCHEMA) => Ok(ResultFile::Modes(modes_from_json(&text, &name)?)),
        Some(UPDATE_SCHEMA) => serde_json::from_str::<UpdateResult>(&text)
            .map_err(|error| error.to_string())
            .and_then(|update| update.check().map(|()| ResultFile::Update(update)))
            .map_err(|error| argument_error(&format!("{name}: {error}"), UPDATE_SCHEMA)),
        other => {
            let got = format!("{name} with schema {}", other.unwrap_or("none"));
            Err(argument_error(
                &got,
                &format!("{COMPARISON_SCHEMA}, {MODES_SCHEMA} or {UPDATE_SCHEMA}"),
            ))
        }
    };
    let result = result?;
    check_result(path, text.as_bytes())?;
    Ok((result, value))
}

fn argument_error(got: &str, expected: &str) -> Error {
    Error::Argument {
        argument: "result file",
        got: got.to_owned(),
        expected: expected.to_owned(),
    }
}

/// The error of a comparison.json of this name.
fn json_error(name: &str, error: JsonError) -> Error {
    match error {
        JsonError::Value { key, got, expected } => {
            argument_error(&format!("{name}: {key}: {got}"), &expected)
        }
        other => argument_error(&format!("{name}: {other}"), COMPARISON_SCHEMA),
    }
}

fn against_limits(
    result: &ResultFile,
    args: &CheckArgs,
    path: &Path,
) -> Result<Vec<RowVerdict>, Error> {
    let used = match result {
        ResultFile::Comparison(_) => LimitsUse {
            decided_by: &[LimitedResult::Comparison],
            result: "a comparison.json",
            expected: "limits on a comparison alone; state [[limits.mode]] in another file and check \
                       the modes.json of a test against it",
        },
        ResultFile::Modes(_) => LimitsUse {
            decided_by: &[LimitedResult::Modes],
            result: "a modes.json",
            expected: "[[limits.mode]] alone or with max_extra; state limits on a comparison in \
                       another file and check comparison.json against it",
        },
        ResultFile::Update(_) => LimitsUse {
            decided_by: &[],
            result: "an update.json",
            expected: "an earlier update.json",
        },
    };
    let limits = limits_from_toml(&read_text(path)?, &path.display().to_string(), used)?;
    let checks = match result {
        ResultFile::Comparison(file) => {
            check_summary(file, &args.result)?;
            check_comparison(&limits, &file.summary.tests)
        }
        ResultFile::Modes(model) => {
            let found: Vec<_> = model
                .modes
                .iter()
                .map(|mode| (mode.frequency_hz, mode.damping_ratio))
                .collect();
            check_modes(&limits, &found)
        }
        // No limit is about parameters.
        ResultFile::Update(_) => Vec::new(),
    };
    Ok(group_by_row(checks))
}

/// Checks that rows and summary of a comparison agree.
fn check_summary(file: &ComparisonFile, path: &Path) -> Result<(), Error> {
    let name = path.display().to_string();
    file.check_summary()
        .map_err(|error| json_error(&name, error))
}

/// `hammer: smallest MAC` is the check `smallest MAC` of the row `hammer`.
fn group_by_row(checks: Vec<LimitCheck>) -> Vec<RowVerdict> {
    let mut rows: Vec<RowVerdict> = Vec::new();
    for mut check in checks {
        let (row, what) = match check.what.rsplit_once(": ") {
            Some((row, what)) => (row.to_owned(), what.to_owned()),
            None => ("the whole".to_owned(), check.what),
        };
        check.what = what;
        match rows.iter_mut().find(|verdict| verdict.row == row) {
            Some(verdict) => verdict.checks.push(check),
            None => rows.push(RowVerdict {
                row,
                checks: vec![check],
            }),
        }
    }
    rows
}

fn against_baseline(
    now: &ResultFile,
    before: &ResultFile,
    before_path: &Path,
    args: &CheckArgs,
) -> Result<Vec<RowVerdict>, Error> {
    let limits = ChangeLimits {
        frequency_percent: args.frequency_percent,
        damping_percent: args.damping_percent,
        mac: args.mac,
        false_refusals: args.false_refusals,
        ..ChangeLimits::default()
    };
    let changes = match (now, before) {
        (ResultFile::Comparison(now), ResultFile::Comparison(before)) => {
            check_summary(now, &args.result)?;
            check_summary(before, before_path)?;
            comparison_changes(now, before, &limits)
        }
        (ResultFile::Modes(now), ResultFile::Modes(before)) => mode_changes(now, before, &limits),
        (ResultFile::Update(now), ResultFile::Update(before)) => update_changes(now, before),
        _ => {
            let got = format!(
                "{} and {}, results of two kinds",
                args.result.display(),
                before_path.display()
            );
            return Err(argument_error(&got, "two results of the same kind"));
        }
    };
    Ok(check_changes(&changes, limits.false_refusals))
}

/// Changes of every cell of the baseline's table; a row or test that only one side has is missed.
fn comparison_changes(
    now: &ComparisonFile,
    before: &ComparisonFile,
    limits: &ChangeLimits,
) -> Vec<Change> {
    let mut changes = Vec::new();
    for row in &before.rows {
        let current = now.rows.iter().find(|found| found.label == row.label);
        let theory = |hz: f64| {
            let new = current.and_then(|found| found.theory.as_ref());
            Measure::AtMost(
                new.map(|new| percent(new.hz, hz)),
                MAX_THEORY_CHANGE_PERCENT,
            )
        };
        changes.extend(row.theory.as_ref().map(|cell| Change {
            row: format!("{} theory", row.label),
            what: "frequency change (%)".to_owned(),
            measure: theory(cell.hz),
        }));
        for field in &row.tests {
            let same =
                current.and_then(|row| row.tests.iter().find(|test| test.test == field.test));
            let name = format!("{} {}", row.label, field.test);
            changes.extend(cell_changes(&name, same, field, limits));
        }
    }
    changes.extend(added_rows(now, before).into_iter().map(|row| Change {
        row,
        what: "in the baseline".to_owned(),
        measure: Measure::AtLeast(0.0, 1.0),
    }));
    changes
}

/// Names of rows, and of tests in rows, that the baseline does not have.
fn added_rows(now: &ComparisonFile, before: &ComparisonFile) -> Vec<String> {
    let mut names = Vec::new();
    for row in &now.rows {
        let Some(old) = before.rows.iter().find(|old| old.label == row.label) else {
            names.push(row.label.clone());
            continue;
        };
        let is_new = |test: &&TestFile| old.tests.iter().all(|old| old.test != test.test);
        let tests = row.tests.iter().filter(is_new);
        names.extend(tests.map(|test| format!("{} {}", row.label, test.test)));
    }
    names
}

/// A value of a cell, where it has one.
type ValueOf = fn(&TestFile) -> Option<UncertainValue>;

fn cell_changes(
    name: &str,
    now: Option<&TestFile>,
    before: &TestFile,
    limits: &ChangeLimits,
) -> Vec<Change> {
    let change = |what: &str, measure| Change {
        row: name.to_owned(),
        what: what.to_owned(),
        measure,
    };
    let changed = now.map(|now| f64::from(u8::from(now.status != before.status)));
    let mut changes = vec![change("status changed", Measure::AtMost(changed, 0.0))];
    changes.extend(frequency_of(before).map(|old| {
        let new = now.and_then(frequency_of);
        let measure = relative_change(new, old, limits.frequency());
        change("frequency change (%)", measure)
    }));
    changes.extend(damping_of(before).map(|old| {
        let new = now.and_then(damping_of);
        let measure = relative_change(new, old, limits.damping());
        change("damping change (%)", measure)
    }));
    let stds = [
        (
            "frequency std change (factor)",
            frequency_of as ValueOf,
            limits.frequency_floor,
        ),
        (
            "hz_std change (factor)",
            noise_frequency_of,
            limits.frequency_floor,
        ),
        (
            "damping std change (factor)",
            damping_of,
            limits.damping_floor,
        ),
    ];
    for (what, value_of, floor) in stds {
        let old = value_of(before);
        let measure = old.and_then(|old| std_change(now.and_then(value_of), old, floor));
        changes.extend(measure.map(|measure| change(what, measure)));
    }
    changes.extend(before.mac.map(|old| {
        let difference = now.and_then(|field| field.mac).map(|new| (new - old).abs());
        let limit = limits.mac.unwrap_or(MAX_MAC_CHANGE);
        change("MAC change", Measure::AtMost(difference, limit))
    }));
    changes
}

/// The frequency with its uncertainty: that of the normalised error, which includes the bias from
/// modes outside the band, else the standard deviation.
fn frequency_of(field: &TestFile) -> Option<UncertainValue> {
    let counted = field.error_hz.zip(field.normalised_error);
    let whole = counted
        .map(|(error, normalised)| (error / normalised).abs())
        .filter(|std| std.is_finite() && field.modes.len() == 1);
    Some(UncertainValue {
        value: field.hz?,
        std: whole.or(field.hz_std),
    })
}

/// The frequency with its standard deviation by noise alone.
fn noise_frequency_of(field: &TestFile) -> Option<UncertainValue> {
    Some(UncertainValue {
        value: field.hz?,
        std: field.hz_std,
    })
}

fn damping_of(field: &TestFile) -> Option<UncertainValue> {
    Some(UncertainValue {
        value: field.damping_ratio?,
        std: field.damping_std,
    })
}

fn checks_json(rows: &[RowVerdict], not_compared: &[String]) -> String {
    let check = |row: &RowVerdict, check: &LimitCheck| {
        serde_json::json!({ "row": row.row, "what": check.what, "value": check.value, "limit": check.limit,
            "bound": if check.upper { "upper" } else { "lower" }, "met": check.is_met() })
    };
    let checks: Vec<Value> = rows
        .iter()
        .flat_map(|row| row.checks.iter().map(move |limit| check(row, limit)))
        .collect();
    let missed = rows
        .iter()
        .flat_map(|row| &row.checks)
        .filter(|check| !check.is_met());
    let verdicts: Vec<Value> = rows
        .iter()
        .map(|row| serde_json::json!({ "row": row.row, "met": row.is_met() }))
        .collect();
    format!(
        "{:#}",
        serde_json::json!({ "schema": "modalign-check/1", "missed": missed.count(), "rows": verdicts, "checks": checks,
            "not_compared": not_compared })
    )
}
