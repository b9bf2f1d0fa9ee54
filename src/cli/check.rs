//! `modalign check`: a result against limits or a baseline.

use std::path::Path;

use serde_json::Value;

use crate::error::Error;
use crate::io::{MODES_SCHEMA, modes_from_json, write_whole};
use crate::modal::{ModalModel, Mode, mac};
use crate::report::json::{COMPARISON_SCHEMA, ComparisonFile, TestFile, comparison_from_json};
use crate::report::limits_block;
use crate::scene::{
    LimitCheck, Limits, LimitsFile, ModeLimit, judge_comparison, judge_modes, parse, percent,
    read_text,
};

use super::Outcome;
use super::args::CheckArgs;
use super::output::Output;

/// A result of either kind.
enum ResultFile {
    Comparison(ComparisonFile),
    Modes(ModalModel),
}

/// Exit code 0 when every limit is met, 1 when one is missed.
pub fn check(args: &CheckArgs, output: &mut Output) -> Result<Outcome, Error> {
    let result = read_result(&args.result)?;
    let is_json = args
        .against
        .extension()
        .is_some_and(|extension| extension == "json");
    let checks = if is_json {
        against_baseline(&result, &read_result(&args.against)?, args)?
    } else {
        against_limits(&result, &args.against)?
    };
    if checks.is_empty() {
        return Err(Error::Argument {
            argument: "--against",
            got: format!("{}, which states no limit that this result can be held against", args.against.display()),
            expected: "a TOML file with [limits] for this kind of result, or an earlier result of the same kind".to_owned(),
        });
    }
    if let Some(path) = &args.junit {
        write_whole(path, junit(&checks))?;
    }
    output.blocks(&limits_block(&checks).into_iter().collect::<Vec<_>>());
    output.json(|| checks_json(&checks));
    Ok(Outcome::missed_if(checks.iter().any(|check| !check.met())))
}

fn read_result(path: &Path) -> Result<ResultFile, Error> {
    let (text, name) = (read_text(path)?, path.display().to_string());
    let schema = serde_json::from_str::<Value>(&text)
        .ok()
        .and_then(|value| value.get("schema")?.as_str().map(str::to_owned));
    match schema.as_deref() {
        Some(COMPARISON_SCHEMA) => comparison_from_json(&text)
            .map(ResultFile::Comparison)
            .map_err(|error| argument_error(&format!("{name}: {error}"), COMPARISON_SCHEMA)),
        Some(MODES_SCHEMA) => Ok(ResultFile::Modes(modes_from_json(&text, &name)?)),
        other => {
            let got = format!("{name} with schema {}", other.unwrap_or("none"));
            Err(argument_error(
                &got,
                &format!("{COMPARISON_SCHEMA} or {MODES_SCHEMA}"),
            ))
        }
    }
}

fn argument_error(got: &str, expected: &str) -> Error {
    Error::Argument {
        argument: "result file",
        got: got.to_owned(),
        expected: expected.to_owned(),
    }
}

fn against_limits(result: &ResultFile, path: &Path) -> Result<Vec<LimitCheck>, Error> {
    let limits = parse::<LimitsFile>(&read_text(path)?, &path.display().to_string())?.limits;
    Ok(match result {
        ResultFile::Comparison(file) => judge_comparison(&limits, &file.summary.tests),
        ResultFile::Modes(model) => {
            let found: Vec<_> = model
                .modes
                .iter()
                .map(|mode| (mode.frequency_hz, mode.damping_ratio))
                .collect();
            judge_modes(&limits, &found)
        }
    })
}

fn against_baseline(
    now: &ResultFile,
    before: &ResultFile,
    args: &CheckArgs,
) -> Result<Vec<LimitCheck>, Error> {
    match (now, before) {
        (ResultFile::Comparison(now), ResultFile::Comparison(before)) => {
            Ok(comparison_changes(now, before, args))
        }
        (ResultFile::Modes(now), ResultFile::Modes(before)) => Ok(modes_changes(now, before, args)),
        _ => Err(argument_error(
            "a comparison and modes",
            "two results of the same kind",
        )),
    }
}

/// Every field of the baseline's table against the same field now; a row or test that is gone misses its limits.
fn comparison_changes(
    now: &ComparisonFile,
    before: &ComparisonFile,
    args: &CheckArgs,
) -> Vec<LimitCheck> {
    let mut checks = Vec::new();
    for row in &before.rows {
        let own = now.rows.iter().find(|own| own.label == row.label);
        for field in &row.tests {
            let same = own.and_then(|own| own.tests.iter().find(|own| own.test == field.test));
            checks.extend(field_changes(
                &format!("{} {}", row.label, field.test),
                same,
                field,
                args,
            ));
        }
    }
    let rows = now.rows.len() as f64 - before.rows.len() as f64;
    checks.push(LimitCheck {
        what: "rows added".to_owned(),
        value: Some(rows),
        limit: 0.0,
        upper: true,
    });
    checks
}

fn field_changes(
    name: &str,
    now: Option<&TestFile>,
    before: &TestFile,
    args: &CheckArgs,
) -> Vec<LimitCheck> {
    let relative = |now: Option<f64>, before: f64| now.map(|now| percent(now, before));
    let check = |what: &str, value, limit| LimitCheck {
        what: format!("{name}: {what}"),
        value,
        limit,
        upper: true,
    };
    let changed = now.map(|now| f64::from(u8::from(now.status != before.status)));
    let mut checks = vec![check("status changed", changed, 0.0)];
    checks.extend(before.hz.map(|hz| {
        check(
            "frequency change (%)",
            relative(now.and_then(|n| n.hz), hz),
            args.frequency_percent,
        )
    }));
    let damping = before.damping_ratio;
    checks.extend(damping.map(|zeta| {
        check(
            "damping change (%)",
            relative(now.and_then(|n| n.damping_ratio), zeta),
            args.damping_percent,
        )
    }));
    let difference = |old: f64| now.and_then(|n| n.mac).map(|new| (new - old).abs());
    checks.extend(
        before
            .mac
            .map(|old| check("MAC change", difference(old), args.mac)),
    );
    checks
}

/// Every mode of the baseline must be there, in frequency, damping and shape, and no other.
fn modes_changes(now: &ModalModel, before: &ModalModel, args: &CheckArgs) -> Vec<LimitCheck> {
    let mode_limit = |mode: &Mode| ModeLimit {
        frequency_hz: mode.frequency_hz,
        max_frequency_error_percent: args.frequency_percent,
        damping_ratio: mode.damping_ratio,
        max_damping_error_percent: Some(args.damping_percent),
    };
    let limits = Limits {
        mode: before.modes.iter().map(mode_limit).collect(),
        max_extra: Some(0),
        ..Limits::default()
    };
    let found: Vec<_> = now
        .modes
        .iter()
        .map(|mode| (mode.frequency_hz, mode.damping_ratio))
        .collect();
    let mut checks = judge_modes(&limits, &found);
    checks.extend(
        before
            .modes
            .iter()
            .filter(|mode| !mode.shape.is_empty())
            .map(|mode| shape_check(now, mode, args)),
    );
    checks
}

/// 1 − MAC of a baseline mode with its best partner among the modes within the frequency limit.
fn shape_check(now: &ModalModel, before: &Mode, args: &CheckArgs) -> LimitCheck {
    let near =
        |mode: &&Mode| percent(mode.frequency_hz, before.frequency_hz) <= args.frequency_percent;
    let mac_with = |mode: &Mode| {
        let pairs = before
            .shape
            .iter()
            .filter_map(|(dof, old)| Some((old * dof.sign(), mode.shape.along_positive(dof)?)));
        let (old, new): (Vec<_>, Vec<_>) = pairs.unzip();
        mac(&old, &new)
    };
    let best = now
        .modes
        .iter()
        .filter(near)
        .filter_map(mac_with)
        .reduce(f64::max);
    LimitCheck {
        what: format!("mode at {} Hz: 1 - MAC", before.frequency_hz),
        value: best.map(|mac| 1.0 - mac),
        limit: args.mac,
        upper: true,
    }
}

fn checks_json(checks: &[LimitCheck]) -> String {
    let row = |check: &LimitCheck| {
        serde_json::json!({ "what": check.what, "value": check.value, "limit": check.limit,
            "bound": if check.upper { "upper" } else { "lower" }, "met": check.met() })
    };
    let missed = checks.iter().filter(|check| !check.met()).count();
    let rows: Vec<Value> = checks.iter().map(row).collect();
    format!(
        "{:#}",
        serde_json::json!({ "schema": "modalign-check/1", "missed": missed, "checks": rows })
    )
}

fn junit(checks: &[LimitCheck]) -> String {
    let escape = |text: &str| {
        text.replace('&', "&amp;")
            .replace('<', "&lt;")
            .replace('>', "&gt;")
            .replace('"', "&quot;")
    };
    let missed = checks.iter().filter(|check| !check.met()).count();
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"modalign check\" tests=\"{}\" failures=\"{missed}\">\n",
        checks.len()
    );
    for check in checks {
        text += &format!("  <testcase name=\"{}\"", escape(&check.what));
        if check.met() {
            text += "/>\n";
        } else {
            let value = check
                .value
                .map_or_else(|| "nothing".to_owned(), |value| value.to_string());
            let relation = if check.upper { "at most" } else { "at least" };
            text += &format!(
                "><failure message=\"got {value}, expected {relation} {}\"/></testcase>\n",
                check.limit
            );
        }
    }
    text + "</testsuite>\n"
}
