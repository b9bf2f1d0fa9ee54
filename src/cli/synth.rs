//! `modalign synth`: a synthetic hammer test, its truth beside it.

use std::path::Path;

use crate::error::Error;
use crate::io::write_all_whole;
use crate::report::{Block, theory_block};
use crate::scene::{hammer_test, load_synth, record};

use super::Outcome;
use super::args::SynthArgs;

use super::output::{Output, check_extension};

/// Writes `FILE` and, beside it, `FILE` with the extension `.modes.json`.
pub fn synth(args: &SynthArgs, output: &mut Output) -> Result<Outcome, Error> {
    check_extension(Some(&args.output), &["uff", "unv"])?;
    let spec = load_synth(&args.spec)?;
    let test = hammer_test(&spec, &args.spec)?;
    let recording = record(&spec, &test, &args.spec)?;
    let truth = args.output.with_extension("modes.json");
    let name = |path: &Path| {
        path.file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned()
    };
    let folder = args.output.parent().unwrap_or(Path::new(""));
    let files = [
        (name(&truth), recording.truth_json.clone().into_bytes()),
        (name(&args.output), recording.uff.clone()),
    ];
    let writing = output.writing();
    write_all_whole(folder, &files)?;
    drop(writing);
    let summary = format!(
        "{} synthetic hits of {} samples at {} Hz: {}; truth: {}",
        test.hit_count(),
        test.samples,
        test.sampling_rate_hz,
        args.output.display(),
        truth.display()
    );
    output.blocks(&[
        Block::Text(summary),
        theory_block("Truth of the synthetic test", &recording.truth),
    ]);
    output.json(|| recording.truth_json.clone());
    Ok(Outcome::Done)
}
