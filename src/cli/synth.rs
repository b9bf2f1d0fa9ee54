//! `modalign synth`: a synthetic hammer test with its truth.

use crate::error::Error;
use crate::printable::counted;
use crate::report::{Block, theory_block};
use crate::scene::{hammer_test, load_synth, record};

use super::args::SynthArgs;
use super::outcome::Outcome;
use super::output::{Output, check_extension};
use super::targets::{check_targets, targets};

/// Writes `FILE`, and its truth as `FILE` with the extension `.modes.json`.
pub fn synth(args: &SynthArgs, output: &mut Output) -> Result<Outcome, Error> {
    check_extension(Some(&args.output), &["uff", "unv"])?;
    let spec = load_synth(&args.spec)?;
    let test = hammer_test(&spec, &args.spec)?;
    let recording = record(&spec, &test, &args.spec)?;
    let truth = args.output.with_extension("modes.json");
    let written = targets([("-o", Some(&truth)), ("-o", Some(&args.output))]);
    check_targets(&written, std::slice::from_ref(&args.spec))?;
    output.add_file(&truth, recording.truth_json.clone());
    output.add_file(&args.output, recording.uff.clone());
    let summary = format!(
        "{} of {} samples at {} Hz: {}; truth: {}",
        counted(test.hit_count(), "synthetic hit"),
        test.samples,
        test.sampling_rate_hz,
        args.output.display(),
        truth.display()
    );
    output.add_blocks(vec![
        Block::Text(summary),
        theory_block("Truth of the synthetic test", &recording.truth),
    ]);
    output.add_json(|| recording.truth_json.clone());
    Ok(Outcome::Done)
}
