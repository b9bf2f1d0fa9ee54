//! `modalign identify`: FRFs to modes.

use std::path::{Path, PathBuf};

use crate::error::Error;
use crate::finding::Code;
use crate::identify::{ESTIMATORS, IdentifyOptions, MethodOptions};
use crate::io::{is_stream, modes_to_json, read_selection, sha256_hex};
use crate::modal::InputFile;
use crate::report::{
    Block, CsvText, INDICATOR_DEFINITIONS, Renderer, indicators_block, modes_block, modes_screen,
    stabilization_block,
};
use crate::scene::{
    FilePlan, IngestOptions, SceneError, TestState, add_file_dofs, identify_sets,
    indicators_of_sets, ingest_files, mass_line_findings, test_rigid_body,
};

use super::args::IdentifyArgs;
use super::new_steps::shell_quoted;
use super::outcome::Outcome;
use super::output::{MODES_EXTENSIONS, Output, check_extension};
use super::targets::{check_targets, targets};

/// What to try where there are no modes.
const ADVICE: &str = "Try another band (--band), method (--method) or a higher order (--order); check units and coherence with inspect.";

/// Prints the modes; writes them with `-o`. Exit code 1 when part of the input was bad and left
/// out, a chosen pole was not found, or there is no mode.
pub fn identify(
    args: &IdentifyArgs,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    check_extension(args.output.as_deref(), MODES_EXTENSIONS)?;
    check_extension(args.stabilization.as_deref(), &["csv"])?;
    check_extension(args.indicators.as_deref(), &["csv"])?;
    let written = targets([
        ("-o", args.output.as_ref()),
        ("--stabilization", args.stabilization.as_ref()),
        ("--indicators", args.indicators.as_ref()),
    ]);
    let read: Vec<PathBuf> = args.inputs.iter().chain(&args.selection).cloned().collect();
    check_targets(&written, &read)?;
    let name = args.inputs[0].display().to_string();
    let options = options(args)?;
    check_order(args, &options, &name)?;
    let files: Vec<FilePlan> = args
        .inputs
        .iter()
        .map(|path| FilePlan::without_points(path))
        .collect();
    let data = ingest_files(
        &files,
        &IngestOptions {
            partial: args.partial,
            frfs_first: true,
            format,
            averages: args.averages,
            window: args.window,
            frf_unit: args.unit,
            ..IngestOptions::default()
        },
    )?;
    if let Some(recording) = &data.recording {
        let got = format!("{} recorded hits", recording.hits().len());
        let expected = "FRFs; make them with `modalign frf`".to_owned();
        return Err(Error::Argument {
            argument: "FRF",
            got,
            expected,
        });
    }
    let identified = identify_sets(&data.frfs, &options, &name)?;
    let mut modes = identified.model;
    let inputs = args.inputs.iter().map(|path| input(path));
    modes.inputs = add_file_dofs(inputs.collect::<Result<_, SceneError>>()?, &data);
    modes.findings.splice(0..0, data.findings);
    let mass_lines = data.frfs.iter().flat_map(|set| {
        let body = test_rigid_body(set, &data.geometry, &[]);
        body.map_or_else(Vec::new, |body| {
            mass_line_findings(set, &body, &TestState::default())
        })
    });
    modes.findings.extend(mass_lines);
    let json = modes_to_json(&modes, None);
    if let Some(path) = &args.output {
        // The directions are those of the functions; no system turns them once more.
        let mut geometry = data.geometry.clone();
        for node in &mut geometry.nodes {
            node.displacement_system = None;
        }
        output.add_modes(path, &modes, &geometry, &json)?;
    }
    output.add_result(
        |width| modes_screen(&name, &modes, ADVICE, width),
        || vec![modes_block(&name, &modes)],
    );
    let rest = match args.output {
        Some(_) => "All columns and notes: --full.",
        None => "All columns and notes: --full; modes with shapes to a file: -o modes.json.",
    };
    let file = args.output.as_deref().filter(|path| !is_stream(path));
    let next = file.filter(|_| !modes.modes.is_empty()).map(|path| {
        let test = shell_quoted(path);
        format!("Next: modalign correlate --test {test} --theory MODEL.")
    });
    output.add_closing(next.into_iter().collect(), Some(rest));
    if let Some(path) = &args.stabilization {
        let poles = stabilization_block(&name, &identified.stabilization);
        output.add_file(path, CsvText.render(&[poles]));
    }
    if let Some(path) = &args.indicators {
        let indicators = indicators_of_sets(&data.frfs, &options, &name)?;
        output.add_file(
            path,
            CsvText.render(&[indicators_block(&name, &indicators)]),
        );
        output.add_blocks(vec![Block::Text(INDICATOR_DEFINITIONS.to_owned())]);
    }
    output.add_json(|| json);
    output.add_findings(&modes.findings);
    let has = |code| modes.findings.iter().any(|finding| finding.code == code);
    let partly_bad = data.partly_bad || has(Code::ValueNotFinite);
    let is_missed = partly_bad || has(Code::SelectionMissed) || modes.modes.is_empty();
    Ok(Outcome::missed_if(is_missed))
}

fn options(args: &IdentifyArgs) -> Result<IdentifyOptions, Error> {
    let defaults = IdentifyOptions::default();
    let selection = args.selection.as_deref().map(read_selection);
    Ok(IdentifyOptions {
        method: args.method.clone().unwrap_or(defaults.method),
        band: args.band,
        references: (!args.reference.is_empty()).then(|| args.reference.clone()),
        partial: args.partial,
        selection: selection.transpose()?,
        estimator: MethodOptions {
            max_order: args.order,
            ..defaults.estimator
        },
    })
}

/// A listing of all model orders is for methods that have some.
fn check_order(args: &IdentifyArgs, options: &IdentifyOptions, name: &str) -> Result<(), Error> {
    let method = options.validate().map_err(|source| SceneError::Identify {
        test: name.to_owned(),
        source: Box::new(source),
    })?;
    if args.stabilization.is_none() || method.has_order {
        return Ok(());
    }
    let with_order = ESTIMATORS.iter().filter(|entry| entry.has_order);
    let names: Vec<&str> = with_order.map(|entry| entry.name).collect();
    Err(Error::Argument {
        argument: "--stabilization",
        got: format!("method {}", method.name),
        expected: format!("a method with model orders: {}", names.join(" ")),
    })
}

fn input(path: &Path) -> Result<InputFile, SceneError> {
    Ok(InputFile {
        path: path.display().to_string(),
        sha256: sha256_hex(path)?,
        dofs: Vec::new(),
    })
}
