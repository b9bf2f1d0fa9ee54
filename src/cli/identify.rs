//! `modalign identify`: FRFs to modes.

use crate::error::Error;
use crate::identify::IdentifyOptions;
use crate::io::{modes_to_json, sha256_hex};
use crate::modal::InputFile;
use crate::report::modes_block;
use crate::scene::{FilePlan, IngestOptions, SceneError, identify_sets, ingest_files};

use super::Outcome;
use super::args::IdentifyArgs;
use super::output::{MODES, Output, check_extension, write_modes};

/// Prints the modes; writes them with `-o`. Exit code 1 when part of the input was bad and left out.
pub fn identify(
    args: &IdentifyArgs,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    check_extension(args.output.as_deref(), MODES)?;
    let files: Vec<FilePlan> = args
        .inputs
        .iter()
        .map(|path| FilePlan::bare(path))
        .collect();
    let data = ingest_files(
        &files,
        &IngestOptions {
            partial: args.partial,
            format,
            averages: args.averages,
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
    let defaults = IdentifyOptions::default();
    let options = IdentifyOptions {
        method: args.method.clone().unwrap_or(defaults.method.clone()),
        band: args.band,
        references: (!args.reference.is_empty()).then(|| args.reference.clone()),
        ..defaults
    };
    let name = args.inputs[0].display().to_string();
    let mut modes = identify_sets(&data.frfs, &options, &name)?;
    modes.findings.splice(0..0, data.findings);
    modes.inputs = args
        .inputs
        .iter()
        .map(|path| input(path))
        .collect::<Result<_, SceneError>>()?;
    let json = modes_to_json(&modes, None);
    if let Some(path) = &args.output {
        // The directions are those of the functions; no system turns them once more.
        let mut geometry = data.geometry.clone();
        for node in &mut geometry.nodes {
            node.displacement_system = None;
        }
        let lost = write_modes(path, &modes, &geometry, &json)?;
        output.findings(&lost);
    }
    output.blocks(&[modes_block(&name, &modes)]);
    output.json(|| json);
    output.findings(&modes.findings);
    Ok(Outcome::missed_if(data.partly_bad))
}

fn input(path: &std::path::Path) -> Result<InputFile, SceneError> {
    Ok(InputFile {
        path: path.display().to_string(),
        sha256: sha256_hex(path)?,
    })
}
