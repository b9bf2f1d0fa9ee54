//! `modalign convert`: between any two formats that can hold the data.

use std::path::PathBuf;

use crate::error::Error;
use crate::finding::Finding;
use crate::io::{
    Catalog, Encoding, Hints, Merged, Precision, Source, WriteOptions, bytes_for_path, is_stream,
    open_bytes, open_path, writable_extensions, write_path,
};
use crate::report::Block;
use crate::scene::{Scene, TestSource, open_test};

use super::args::ConvertArgs;
use super::outcome::Outcome;
use super::output::{Output, check_extension};
use super::targets::{check_targets, input_files, targets};

/// Writes what the inputs hold; says what could not be carried. Exit code 1 when part of an input
/// was bad and left out.
pub fn convert(
    args: &ConvertArgs,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    check_extension(Some(&args.output), &writable_extensions())?;
    let read: Vec<PathBuf> = args
        .inputs
        .iter()
        .flat_map(|input| input_files(input))
        .collect();
    check_targets(&targets([("-o", Some(&args.output))]), &read)?;
    let mut merged = sources(args, format)?;
    merged.leave_out_unreadable();
    let catalog = merged.catalog();
    check_content(catalog)?;
    let findings = catalog.findings.clone();
    let damage: Vec<String> = catalog.damage.iter().map(ToString::to_string).collect();
    let options = WriteOptions {
        encoding: if args.text {
            Encoding::Text
        } else {
            Encoding::Binary
        },
        precision: precision(args),
        ..WriteOptions::default()
    };
    let writing = output.guard_writing();
    // The summary describes the file as it is read again.
    let hints = Hints {
        path: args.output.display().to_string(),
        table: None,
    };
    let (written, lost) = if is_stream(&args.output) {
        let (bytes, lost) = bytes_for_path(&args.output, &mut merged, options)?;
        output.add_file(&args.output, bytes.clone());
        (open_bytes(bytes, &hints)?, lost)
    } else {
        let lost = write_path(&args.output, &mut merged, options)?;
        (open_path(&args.output, &hints, None)?, lost)
    };
    drop(writing);
    output.add_blocks(vec![Block::Text(summary(written.catalog(), &damage))]);
    let findings = [findings, lost].concat();
    let json = summary_json(written.catalog(), &damage, &findings);
    output.add_json(|| format!("{json:#}"));
    output.add_findings(&findings);
    Ok(Outcome::missed_if(!damage.is_empty()))
}

fn precision(args: &ConvertArgs) -> Option<Precision> {
    match (args.single, args.double) {
        (true, _) => Some(Precision::Single),
        (_, true) => Some(Precision::Double),
        _ => None,
    }
}

/// The inputs opened as one: the files of a scene's first test as it describes them, or files as
/// they are.
fn sources(args: &ConvertArgs, format: Option<&str>) -> Result<Merged, Error> {
    if let [only] = args.inputs.as_slice()
        && Scene::is_path(only)
    {
        let scene = Scene::load(only)?;
        let first = scene.tests.first().map(|test| &test.source);
        let Some(TestSource::Files { files, typed, .. }) = first else {
            return Err(Error::Argument {
                argument: "INPUT",
                got: scene.path.clone(),
                expected: "files, or a scene whose first test has `files`".to_owned(),
            });
        };
        return Ok(open_test(files, typed, format, &scene.path)?);
    }
    let opened = args.inputs.iter().map(|path| {
        let hints = Hints {
            path: path.display().to_string(),
            table: None,
        };
        open_path(path, &hints, format)
    });
    Ok(Merged::new(opened.collect::<Result<_, _>>()?))
}

/// Something must be there that can be written; arrays without a meaning are not.
fn check_content(catalog: &Catalog) -> Result<(), Error> {
    if catalog.entries.len() + catalog.modes.len() + catalog.geometry.len() > 0 {
        return Ok(());
    }
    if let Some(first) = catalog.damage.first() {
        return Err(Error::Argument {
            argument: "INPUT",
            got: format!("a file without a good part ({first})"),
            expected: "records, functions, modes or geometry".to_owned(),
        });
    }
    let got = match catalog.arrays.len() {
        0 => format!("{} without any content", catalog.path),
        count => format!("{} with {count} arrays of unknown meaning", catalog.path),
    };
    Err(Error::Argument {
        argument: "INPUT",
        got,
        expected:
            "records, functions, modes or geometry; say what arrays and columns are with [[test.channel]] in a scene"
                .to_owned(),
    })
}

fn summary(written: &Catalog, damage: &[String]) -> String {
    let geometry = &written.geometry;
    let counts = [
        (written.entries.len(), "records and functions"),
        (written.modes.len(), "modes"),
        (geometry.nodes.len(), "nodes"),
        (geometry.lines.len(), "trace lines"),
        (geometry.elements.len(), "elements"),
    ];
    let held: Vec<String> = counts
        .iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| format!("{count} {what}"))
        .collect();
    let mut lines = vec![format!("{}: {}", written.path, held.join(", "))];
    if !damage.is_empty() {
        lines.push(format!("{} bad parts left out:", damage.len()));
        lines.extend(damage.iter().cloned());
    }
    lines.join("\n")
}

fn summary_json(written: &Catalog, damage: &[String], findings: &[Finding]) -> serde_json::Value {
    serde_json::json!({
        "schema": "modalign-convert/1",
        "output": written.path,
        "format": written.format,
        "entries": written.entries.len(),
        "modes": written.modes.len(),
        "nodes": written.geometry.nodes.len(),
        "damage": damage,
        "findings": findings,
    })
}
