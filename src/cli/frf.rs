//! `modalign frf`: recorded hits to FRFs.

use std::path::Path;

use crate::axis::Band;
use crate::error::Error;
use crate::frf::{EstimateOptions, Estimator, FrfSet};
use crate::io::{HitGrouping, WriteOptions, frf_source, write_path};
use crate::report::frf_block;
use crate::scene::{
    FilePlan, IngestOptions, Ingested, Scene, TestSource, estimate_hits, force_window,
    ingest_files, with_response_window,
};

use super::Outcome;
use super::args::FrfArgs;
use super::output::{FUNCTIONS, Output, check_extension};

/// Prints what was estimated; writes the FRFs with `-o`. Exit code 1 when part of the input was bad and left out.
pub fn frf(args: &FrfArgs, format: Option<&str>, output: &mut Output) -> Result<Outcome, Error> {
    let grouping = match args.hits.as_deref() {
        None => HitGrouping::Records,
        Some(name) => HitGrouping::from_name(name)
            .ok_or_else(|| argument("--hits", name, "records or files"))?,
    };
    check_extension(args.output.as_deref(), FUNCTIONS)?;
    let scene = scene(args)?;
    let data = match &scene {
        Some(scene) => scene_files(args, scene, format)?,
        None => files(args, grouping, format)?,
    };
    let options = options(args, scene.as_ref(), &data)?;
    let (set, usable) = estimate_hits(&data.hits, &options)?;
    if let Some(path) = &args.output {
        let mut source = frf_source(&set, "FRFs");
        source.catalog.geometry = data.geometry.clone();
        output.findings(&write_path(path, &mut source, WriteOptions::default())?);
    }
    output.blocks(&[frf_block(&set, usable, data.hits.len())]);
    output.json(&set_json(&set, usable));
    output.findings(&data.findings);
    output.findings(&set.findings);
    Ok(Outcome::missed_if(data.partly_bad))
}

/// The scene that the only input is, if it is one.
fn scene(args: &FrfArgs) -> Result<Option<Scene>, Error> {
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
fn scene_files(args: &FrfArgs, scene: &Scene, format: Option<&str>) -> Result<Ingested, Error> {
    let test = &scene.tests[0];
    let TestSource::Files { files, hits, typed } = &test.source else {
        return Err(argument(
            "INPUT",
            &scene.path,
            "recordings, or a scene whose first test has `files`",
        ));
    };
    let partial = args.partial || test.partial;
    recorded(ingest_files(
        files,
        &IngestOptions {
            hits: *hits,
            typed: Some(typed),
            partial,
            format,
            averages: None,
            scene: &scene.path,
        },
    )?)
}

fn files(args: &FrfArgs, grouping: HitGrouping, format: Option<&str>) -> Result<Ingested, Error> {
    let plan = |path: &Path| FilePlan {
        reference: args.reference.clone(),
        ..FilePlan::bare(path)
    };
    let plans: Vec<FilePlan> = args.inputs.iter().map(|path| plan(path)).collect();
    let options = IngestOptions {
        hits: grouping,
        partial: args.partial,
        format,
        ..IngestOptions::default()
    };
    recorded(ingest_files(&plans, &options)?)
}

fn recorded(data: Ingested) -> Result<Ingested, Error> {
    if data.hits.is_empty() {
        return Err(argument(
            "INPUT",
            "files without time records",
            "recorded hits",
        ));
    }
    Ok(data)
}

/// What the command line states, else the scene, else the defaults.
fn options(
    args: &FrfArgs,
    scene: Option<&Scene>,
    data: &Ingested,
) -> Result<EstimateOptions, Error> {
    let base = scene.map_or_else(EstimateOptions::default, |scene| scene.estimate);
    let estimator = match args.estimator.as_deref() {
        None => base.estimator,
        Some(name) => Estimator::from_name(name)
            .ok_or_else(|| argument("--estimator", name, "h1, h2 or hv"))?,
    };
    let stated = EstimateOptions {
        estimator,
        force_window: args.force_window.map(force_window).or(base.force_window),
        noise_ratio: args.noise_ratio.or(base.noise_ratio),
        remove_offset: args.remove_offset || base.remove_offset,
        ..base
    };
    let end = args
        .response_window
        .or(scene.and_then(|scene| scene.response_window_end));
    Ok(with_response_window(stated, end, &data.hits)?)
}

fn argument(argument: &'static str, got: &str, expected: &str) -> Error {
    Error::Argument {
        argument,
        got: got.to_owned(),
        expected: expected.to_owned(),
    }
}

fn set_json(set: &FrfSet, usable: Band) -> String {
    let axis = set.axis();
    let functions: Vec<_> = set
        .functions()
        .iter()
        .map(|function| {
            serde_json::json!({ "response": function.response, "reference": function.reference, "kind": function.kind,
                "averages": function.averages, "estimator": function.estimator.map(Estimator::name) })
        })
        .collect();
    let result = serde_json::json!({
        "schema": "modalign-frf-summary/1",
        "axis": { "start_hz": axis.start_hz, "step_hz": axis.step_hz, "lines": axis.len },
        "usable_band_hz": [usable.lo_hz, usable.hi_hz],
        "added_damping_rad_s": set.added_damping_rad_s,
        "functions": functions,
        "findings": set.findings,
    });
    format!("{result:#}")
}
