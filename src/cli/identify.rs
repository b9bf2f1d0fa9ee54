//! `modalign identify`: FRFs to modes.

use crate::error::Error;
use crate::identify::IdentifyOptions;
use crate::io::{modes_to_json, sha256_hex, write_whole};
use crate::modal::InputFile;
use crate::report::modes_block;
use crate::scene::{FilePlan, IngestOptions, SceneError, identify_sets, ingest_files};

use super::Outcome;
use super::args::IdentifyArgs;
use super::output::{Output, check_extension};

/// Prints the modes; writes them with `-o`. Exit code 1 when part of the input was bad and left out.
pub fn identify(
    args: &IdentifyArgs,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    check_extension(args.output.as_deref(), &["json"])?;
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
            ..IngestOptions::default()
        },
    )?;
    if !data.hits.is_empty() {
        let got = format!("{} recorded hits", data.hits.len());
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
        write_whole(path, &json)?;
    }
    output.blocks(&[modes_block(&name, &modes)]);
    output.json(&json);
    output.findings(&modes.findings);
    Ok(Outcome::missed_if(data.partly_bad))
}

fn input(path: &std::path::Path) -> Result<InputFile, SceneError> {
    Ok(InputFile {
        path: path.display().to_string(),
        sha256: sha256_hex(path)?,
    })
}
