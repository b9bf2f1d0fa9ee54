//! `modalign frf`: recorded hits to FRFs.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::axis::Band;
use crate::error::Error;
use crate::frf::{
    BeforeYouLeave, EstimateOptions, Estimator, Excitation, FrfSet, HammerOptions,
    HammerTestResult, HitReport, ResponseWindow, evaluate_test,
};
use crate::geometry::Geometry;
use crate::io::{
    HitGrouping, Window, WriteOptions, bytes_for_path, frf_source, is_stream, write_path,
};
use crate::report::{before_you_leave_blocks, frf_block, hits_block, hits_screen, json};
use crate::scene::{
    FilePlan, IngestOptions, Ingested, Scene, TestSource, TestState, force_window, ingest_files,
    leaving_list, mass_line_findings, offset, test_rigid_body,
};

use crate::signal::{Offset, TriggerOptions};

use super::args::FrfArgs;
use super::new_steps::shell_quoted;
use super::outcome::Outcome;
use super::output::{FRF_EXTENSIONS, Output, check_extension};
use super::targets::{check_targets, input_files, targets};

/// Prints what was estimated; writes the FRFs with `-o`. Exit code 1 when part of the input was bad
/// and left out.
pub fn frf(args: &FrfArgs, format: Option<&str>, output: &mut Output) -> Result<Outcome, Error> {
    let grouping = hit_grouping(args)?;
    check_extension(args.output.as_deref(), FRF_EXTENSIONS)?;
    let read: Vec<PathBuf> = args
        .inputs
        .iter()
        .flat_map(|input| input_files(input))
        .collect();
    check_targets(&targets([("-o", args.output.as_ref())]), &read)?;
    let scene = load_scene(args)?;
    check_arguments(args, scene.is_some())?;
    let data = match &scene {
        Some(scene) => ingest_scene_files(args, scene, format)?,
        None => ingest_recordings(args, &args.inputs, grouping, format)?,
    };
    let options = options(args, scene.as_ref())?;
    let mut recording = data.recording.ok_or_else(|| no_records(scene.is_some()))?;
    let result = evaluate_test(recording.as_mut(), &options)?;
    let sensors = scene
        .as_ref()
        .map_or(&[][..], |scene| scene.sensors.as_slice());
    let test = scene.as_ref().and_then(|scene| scene.tests.first());
    let state = test.map_or_else(TestState::default, |test| test.state.clone());
    let mut geometry = data.geometry.clone();
    geometry.add(
        &scene
            .as_ref()
            .map_or_else(Geometry::default, |scene| scene.points.clone()),
    );
    let body = test_rigid_body(&result.estimated.set, &geometry, sensors);
    let list = leaving_list(&result, body.as_ref(), &state);
    let HammerTestResult {
        estimated,
        hits,
        usable,
        estimate,
        ..
    } = result;
    let set = estimated.set;
    if let Some(path) = &args.output {
        let mut source = frf_source(&set, "FRFs");
        source.catalog.geometry = data.geometry.clone();
        let window = set.window.or(record_window(&estimate));
        for entry in &mut source.catalog.entries {
            entry.note.window = window;
        }
        let options = WriteOptions::default();
        let lost = if is_stream(path) {
            let (bytes, lost) = bytes_for_path(path, &mut source, options)?;
            output.add_file(path, bytes);
            lost
        } else {
            let _writing = output.guard_writing();
            write_path(path, &mut source, options)?
        };
        output.add_findings(&lost);
    }
    output.add_result(
        |width| hits_screen(&hits, &set, usable, &list, width),
        || {
            let tables = [hits_block("Hits", &hits), frf_block(&set, usable, &hits)];
            tables
                .into_iter()
                .chain(before_you_leave_blocks(&list))
                .collect()
        },
    );
    let rest = match args.output {
        Some(_) => "All hits and FRFs: --full.",
        None => "All hits and FRFs: --full; FRFs to a file: -o FILE.",
    };
    let file = args.output.as_deref().filter(|path| !is_stream(path));
    let next = file.map(|path| format!("Next: modalign identify {}.", shell_quoted(path)));
    output.add_closing(next.into_iter().collect(), Some(rest));
    output.add_json(|| set_json(&set, usable, &hits, &list));
    output.add_findings(&data.findings);
    output.add_findings(&set.findings);
    if let Some(body) = &body {
        output.add_findings(&mass_line_findings(&set, body, &state));
    }
    Ok(Outcome::missed_if(data.partly_bad))
}

/// The scene that the only input is, if it is one.
fn load_scene(args: &FrfArgs) -> Result<Option<Scene>, Error> {
    let [only] = args.inputs.as_slice() else {
        return Ok(None);
    };
    Ok(if Scene::is_path(only) {
        Some(Scene::load(only)?)
    } else {
        None
    })
}

/// The files of a scene's first test, as the scene describes them.
fn ingest_scene_files(
    args: &FrfArgs,
    scene: &Scene,
    format: Option<&str>,
) -> Result<Ingested, Error> {
    let without_files = || {
        let expected = "recordings, or a scene whose first test has `files`";
        argument_error("INPUT", &scene.path, expected)
    };
    let test = scene.tests.first().ok_or_else(without_files)?;
    let TestSource::Files {
        files,
        hits,
        trigger,
        typed,
    } = &test.source
    else {
        return Err(without_files());
    };
    let partial = args.partial || test.partial;
    Ok(ingest_files(
        files,
        &IngestOptions {
            hits: *hits,
            trigger: *trigger,
            typed: Some(typed),
            partial,
            frfs_first: false,
            format,
            scene: &scene.path,
            ..IngestOptions::default()
        },
    )?)
}

/// How the arguments group records into hits.
pub(super) fn hit_grouping(args: &FrfArgs) -> Result<HitGrouping, Error> {
    match args.hits.as_deref() {
        None => Ok(HitGrouping::Auto),
        Some(name) => HitGrouping::from_name(name)
            .ok_or_else(|| argument_error("--hits", name, "records, files or trigger")),
    }
}

/// Recordings as the arguments describe them.
pub(super) fn ingest_recordings(
    args: &FrfArgs,
    paths: &[PathBuf],
    grouping: HitGrouping,
    format: Option<&str>,
) -> Result<Ingested, Error> {
    let plan = |path: &Path| FilePlan {
        reference: args.reference.clone(),
        ..FilePlan::without_points(path)
    };
    let plans: Vec<FilePlan> = paths.iter().map(|path| plan(path)).collect();
    let options = IngestOptions {
        hits: grouping,
        trigger: TriggerOptions {
            level_n: args.trigger_level,
            pretrigger_s: args.pretrigger,
            length_s: args.hit_length,
        },
        partial: args.partial,
        format,
        record_units: &args.unit,
        ..IngestOptions::default()
    };
    Ok(ingest_files(&plans, &options)?)
}

/// The window of the records, as files name it.
fn record_window(options: &EstimateOptions) -> Option<Window> {
    match (options.force_window, options.exponential) {
        (None, None) => None,
        (Some(_), None) => Some(Window::Force),
        (None, Some(_)) => Some(Window::Exponential),
        (Some(_), Some(_)) => Some(Window::ForceAndExponential),
    }
}

/// The error of files without time records.
pub(super) fn no_records(has_scene: bool) -> Error {
    match has_scene {
        true => argument_error(
            "INPUT",
            "a scene whose files hold no time records",
            "recorded hits; `modalign run` identifies FRFs of a scene",
        ),
        false => argument_error(
            "INPUT",
            "files whose headers describe no time records",
            "recorded hits; a scene states what columns hold: `modalign new DIR FILE...` drafts one",
        ),
    }
}

/// Options of the command line, else of the scene, else the defaults.
pub(super) fn options(args: &FrfArgs, scene: Option<&Scene>) -> Result<HammerOptions, Error> {
    let default = HammerOptions {
        estimate: EstimateOptions {
            offset: offset(None),
            ..EstimateOptions::default()
        },
        ..HammerOptions::default()
    };
    let test = scene.and_then(|scene| Some((scene, scene.tests.first()?)));
    let base = test.map_or(default, |(scene, test)| test.hammer_options(&scene.hammer));
    let estimator = match args.estimator.as_deref() {
        None => base.estimate.estimator,
        Some(name) => Estimator::from_name(name)
            .ok_or_else(|| argument_error("--estimator", name, "h1, h2 or hv"))?,
    };
    let excitation = match args.excitation.as_deref() {
        None => base.excitation,
        Some(name) => Excitation::from_name(name)
            .ok_or_else(|| argument_error("--excitation", name, "hammer, random or sine"))?,
    };
    if args.block_length.is_some() && excitation == Excitation::Hammer {
        let got = "excitation by a hammer";
        let expected = "--excitation random or sine";
        return Err(argument_error("--block-length", got, expected));
    }
    let scene_options = base.estimate;
    Ok(HammerOptions {
        estimate: EstimateOptions {
            estimator,
            force_window: args
                .force_window
                .map(force_window)
                .or(scene_options.force_window),
            noise_ratio: args.noise_ratio.or(scene_options.noise_ratio),
            offset: if args.remove_offset {
                Offset::Remove
            } else {
                scene_options.offset
            },
            ..scene_options
        },
        excitation,
        block_length_s: args.block_length.or(base.block_length_s),
        response_window: match args.response_window.as_deref() {
            None => base.response_window,
            Some(text) => response_window(text)?,
        },
        // The command line precedes the scene.
        accept: merge_hit_numbers(&base.accept, &args.accept, &args.reject),
        reject: merge_hit_numbers(&base.reject, &args.reject, &args.accept),
        keep_all: base.keep_all || args.keep_all,
        ..base
    })
}

/// The hit numbers of a scene and of the command line, without those of the opposite option.
fn merge_hit_numbers(scene: &BTreeSet<usize>, added: &[usize], other: &[usize]) -> BTreeSet<usize> {
    let kept = scene.iter().filter(|number| !other.contains(number));
    kept.chain(added).copied().collect()
}

/// Rejects options that a scene states, and options of the trigger without it.
pub(super) fn check_arguments(args: &FrfArgs, of_scene: bool) -> Result<(), Error> {
    let stated = [
        ("--hits", args.hits.is_some()),
        ("--reference", args.reference.is_some()),
        ("--unit", !args.unit.is_empty()),
        ("--trigger-level", args.trigger_level.is_some()),
        ("--pretrigger", args.pretrigger.is_some()),
        ("--hit-length", args.hit_length.is_some()),
    ];
    let by_trigger = args.hits.as_deref() == Some("trigger");
    let mut stated = stated.into_iter().filter(|(_, is_stated)| *is_stated);
    if of_scene {
        return match stated.next() {
            None => Ok(()),
            Some((name, _)) => Err(argument_error(
                name,
                "a scene",
                "recordings; a scene states it in [[test]]",
            )),
        };
    }
    match stated
        .find(|(name, _)| !by_trigger && !["--hits", "--reference", "--unit"].contains(name))
    {
        None => Ok(()),
        Some((name, _)) => Err(argument_error(name, "no trigger", "--hits trigger")),
    }
}

fn response_window(text: &str) -> Result<ResponseWindow, Error> {
    let expected = "auto, none, or the value at the record's end, such as 0.01";
    match (text, text.parse()) {
        ("auto", _) => Ok(ResponseWindow::Auto),
        ("none", _) => Ok(ResponseWindow::Off),
        (_, Ok(end)) => Ok(ResponseWindow::End(end)),
        _ => Err(argument_error("--response-window", text, expected)),
    }
}

pub(super) fn argument_error(argument: &'static str, got: &str, expected: &str) -> Error {
    Error::Argument {
        argument,
        got: got.to_owned(),
        expected: expected.to_owned(),
    }
}

fn set_json(set: &FrfSet, usable: Band, hits: &[HitReport], list: &BeforeYouLeave) -> String {
    let axis = set.axis();
    let functions: Vec<_> = set
        .functions()
        .iter()
        .map(|function| {
            serde_json::json!({ "response": function.response, "reference": function.reference, "kind": function.kind,
                "averages": function.averages, "estimator": function.estimator.map(Estimator::name),
                "variance_degrees_of_freedom": function.variance_dof })
        })
        .collect();
    let result = serde_json::json!({
        "schema": "modalign-frf-summary/1",
        "axis": { "start_hz": axis.start_hz, "step_hz": axis.step_hz, "lines": axis.len },
        "usable_band_hz": [usable.lo_hz, usable.hi_hz],
        "added_damping_rad_s": set.added_damping_rad_s,
        "functions": functions,
        "hits": json::hits_value(hits),
        "before_you_leave": json::before_you_leave_value(list),
        "findings": set.findings,
    });
    format!("{result:#}")
}
