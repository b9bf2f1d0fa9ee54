//! `modalign study`: one file per study.

use crate::error::Error;

use super::breakdown::breakdown;
use super::order::needs;
use super::outcome::Outcome;
use super::output::Output;
use super::scene_reading::SceneReading;
use super::speed_accuracy::study as speed_accuracy;
use super::study_args::{Study, StudyArgs};

/// Makes a study.
pub fn study(
    args: &StudyArgs,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    let partial = args.partial;
    let reading = SceneReading { format, partial };
    match &args.study {
        Study::SpeedAccuracy(args) => speed_accuracy(args, reading, output),
        Study::Breakdown(args) => breakdown(args, reading, output),
        Study::Order(args) => needs(args, reading, output),
    }
}
