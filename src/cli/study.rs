//! `modalign study`: one file per study.

use clap::{Args, Subcommand};

use crate::error::Error;

use super::Outcome;
use super::breakdown::{BreakdownArgs, breakdown};
use super::output::Output;
use super::speed_accuracy::{SpeedAccuracyArgs, study as speed_accuracy};

/// `study`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  modalign study speed-accuracy measurements/free-free-beam -o speed\n  modalign study breakdown measurements/free-free-beam -o fails"
)]
pub struct StudyArgs {
    /// What is studied.
    #[command(subcommand)]
    pub study: Study,
}

/// The studies.
#[derive(Debug, Subcommand)]
pub enum Study {
    /// Time and error of every method, order, FRF estimator and length of record, on a scene's data and on their synthetic twins.
    SpeedAccuracy(SpeedAccuracyArgs),
    /// Where every method fails: maps over noise, separation, damping, references and the like, with the contour of each method, what
    /// is seen beyond it, and the scene's own modes.
    Breakdown(BreakdownArgs),
}

/// Makes a study.
pub fn study(
    args: &StudyArgs,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    match &args.study {
        Study::SpeedAccuracy(args) => speed_accuracy(args, format, output),
        Study::Breakdown(args) => breakdown(args, format, output),
    }
}
