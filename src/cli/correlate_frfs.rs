//! `modalign correlate` of FRFs: functions of tests against those of a theory, or of another test.

use std::path::Path;

use crate::correlate::measures::frf_correlation;
use crate::error::Error;
use crate::frf::FrfSet;
use crate::report::{CsvText, Renderer, frf_correlation_blocks, frf_lines_block, json};
use crate::scene::{FilePlan, IngestOptions, ingest_files};

use super::args::CorrelateArgs;
use super::correlation_output::{CorrelationOutput, print};
use super::outcome::Outcome;
use super::output::{Output, check_extension};
use super::scene_reading::SceneReading;
use super::targets::check_correlate_targets;

/// Prints FRAC of every function and the criteria over frequency; writes them with `-o`, those of
/// every line with `--lines`.
pub fn correlate_frfs(
    args: &CorrelateArgs,
    theory: &Path,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    check_arguments(args)?;
    check_correlate_targets(args, true)?;
    let partial = args.partial;
    let mut partly_bad = false;
    let mut read = |path: &Path| -> Result<FrfSet, Error> {
        let reading = SceneReading { format, partial };
        let (set, bad) = read_frfs(path, reading, output)?;
        partly_bad |= bad;
        Ok(set)
    };
    let other = read(theory)?;
    let second = theory.display().to_string();
    let (mut tests, mut lines, mut all) = (Vec::new(), Vec::new(), Vec::new());
    for path in &args.test {
        let name = path.display().to_string();
        let correlation = frf_correlation(&read(path)?, &other, args.band)?;
        tests.push(frf_correlation_blocks(&name, &second, &correlation));
        lines.push(frf_lines_block(&name, &second, &correlation));
        all.push((name, correlation));
    }
    if let Some(path) = &args.lines {
        output.add_file(path, CsvText.render(&lines));
    }
    let json = json::frf_correlations_to_json(&all);
    print(args, CorrelationOutput::of_tests(tests, json), None, output);
    Ok(Outcome::missed_if(partly_bad))
}

/// Refuses options that apply to modes only.
fn check_arguments(args: &CorrelateArgs) -> Result<(), Error> {
    check_extension(args.lines.as_deref(), &["csv"])?;
    let given = [
        ("--measures", args.measures),
        ("--expand", args.expand.is_some()),
        ("--orthogonality", args.orthogonality.is_some()),
        ("--dof-map", args.dof_map.is_some()),
        ("--nearest-node", args.nearest_node.is_some()),
        ("--turn-reversed", args.turn_reversed),
        ("--rotation-length", args.rotation_length.is_some()),
        ("--min-mac", args.min_mac.is_some()),
        ("--max-frequency-error", args.max_frequency_error.is_some()),
        ("--error-reference", args.error_reference.is_some()),
    ];
    match given.into_iter().find(|(_, given)| *given) {
        None => Ok(()),
        Some((argument, _)) => Err(Error::Argument {
            argument,
            got: "FRFs".to_owned(),
            expected: "modes on both sides".to_owned(),
        }),
    }
}

/// The FRFs of a file, on one axis, and whether part of it was bad.
fn read_frfs(
    path: &Path,
    reading: SceneReading,
    output: &mut Output,
) -> Result<(FrfSet, bool), Error> {
    let options = IngestOptions {
        format: reading.format,
        partial: reading.partial,
        frfs_first: true,
        ..IngestOptions::default()
    };
    let data = ingest_files(&[FilePlan::without_points(path)], &options)?;
    output.add_findings(&data.findings);
    let count = data.frfs.len();
    let mut sets = data.frfs.into_iter();
    match (sets.next(), sets.next(), data.recording) {
        (Some(set), None, None) => {
            output.add_findings(&set.findings);
            Ok((set, data.partly_bad))
        }
        (_, _, recording) => Err(Error::Argument {
            argument: "--test, --theory",
            got: match recording {
                Some(recording) => {
                    format!(
                        "{}, with {} recorded hits",
                        path.display(),
                        recording.hits().len()
                    )
                }
                None => format!("{}, with FRFs on {count} axes", path.display()),
            },
            expected: "FRFs on one axis on both sides; make them with `modalign frf`".to_owned(),
        }),
    }
}
