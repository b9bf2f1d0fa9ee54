//! `modalign study order`: the modes, orders, methods and parameters that a scene needs.

use crate::error::Error;
use crate::report::{
    CsvText, Markdown, Renderer, figure_files, json, order_blocks, order_figures, order_screen,
    order_table,
};
use crate::study::order;

use super::outcome::Outcome;
use super::output::Output;
use super::scene_reading::{SceneReading, load_scene_and_study, report_damage};
use super::study_args::OrderArgs;

/// The verb in a manifest.
const VERB: &str = "study order";

/// Where the rest of the result is.
const REST: &str = "Reasons, and each mode with each method: --full.";
/// The option that writes files.
const FILES: &str = "With figures and files: -o DIR.";

/// Asks what the scene needs. Exit code 1 when a test could not be asked or part of its files was
/// bad.
pub fn needs(
    args: &OrderArgs,
    reading: SceneReading,
    output: &mut Output,
) -> Result<Outcome, Error> {
    let (scene, spec) = load_scene_and_study(&args.path, reading)?;
    if let Some(folder) = &args.output {
        output.open_results(folder, Some(VERB))?;
    }
    let analysis = order(&scene, &spec.order, output.observer())?;
    let blocks = order_blocks(&analysis);
    if args.output.is_some() {
        let texts = [
            ("order.md", Markdown.render(&blocks)),
            ("order.csv", CsvText.render(&[order_table(&analysis)])),
            ("order.json", json::order_to_json(&analysis)),
        ];
        let texts = texts.map(|(name, text)| (name.to_owned(), text.into_bytes()));
        output.add_results(VERB, texts.into());
        output.add_results(VERB, figure_files(order_figures(&analysis), args.png));
    }
    output.add_result(|width| order_screen(&analysis, width), || blocks);
    output.add_rest_of_study(REST, Some(FILES).filter(|_| args.output.is_none()));
    output.add_json(|| json::order_to_json(&analysis));
    let is_bad = report_damage(&scene, output)?;
    Ok(Outcome::missed_if(is_bad || !analysis.failed.is_empty()))
}
