//! `modalign study speed-accuracy`: how fast and exact every method is.

use crate::error::Error;
use crate::report::{
    CsvText, Renderer, figure_files, json, speed_accuracy_blocks, speed_accuracy_figures,
    speed_accuracy_screen, speed_accuracy_table, times_table,
};
use crate::study::{SpeedAccuracy, speed_accuracy};

use super::meter::ProcessMeter;
use super::outcome::Outcome;
use super::output::Output;
use super::scene_reading::{SceneReading, load_scene_and_study, report_damage};
use super::study_args::SpeedAccuracyArgs;

/// The verb in a manifest.
const VERB: &str = "study speed-accuracy";

/// Where the rest of the result is.
const REST: &str = "Recommendations and the Pareto front: --full.";
/// The option that writes files.
const FILES: &str = "All rows, times and figures: -o DIR.";

/// Runs the study; exit code 1 when part of the files was bad.
pub fn study(
    args: &SpeedAccuracyArgs,
    reading: SceneReading,
    output: &mut Output,
) -> Result<Outcome, Error> {
    let (scene, spec) = load_scene_and_study(&args.path, reading)?;
    let mut options = spec.speed_accuracy;
    options.draws = args.draws.unwrap_or(options.draws);
    if let Some(folder) = &args.output {
        output.open_results(folder, Some(VERB))?;
    }
    let result = speed_accuracy(&scene, &options, &ProcessMeter, output.observer())?;
    if args.output.is_some() {
        output.add_results(VERB, files(&result, args.png));
    }
    output.add_result(
        |width| speed_accuracy_screen(&result, width),
        || speed_accuracy_blocks(&result),
    );
    output.add_rest_of_study(REST, Some(FILES).filter(|_| args.output.is_none()));
    output.add_json(|| json::speed_accuracy_to_json(&result));
    Ok(Outcome::missed_if(report_damage(&scene, output)?))
}

/// Measured times are in separate files, so that `speed-accuracy.csv` has the same bytes on every
/// run.
fn files(result: &SpeedAccuracy, png: bool) -> Vec<(String, Vec<u8>)> {
    let texts = [
        (
            "speed-accuracy.csv",
            CsvText.render(&[speed_accuracy_table(result)]),
        ),
        (
            "speed-accuracy-times.csv",
            CsvText.render(&[times_table(result)]),
        ),
        ("speed-accuracy.json", json::speed_accuracy_to_json(result)),
    ];
    let texts = texts.map(|(name, text)| (name.to_owned(), text.into_bytes()));
    let figures = figure_files(speed_accuracy_figures(result), png);
    texts.into_iter().chain(figures).collect()
}
