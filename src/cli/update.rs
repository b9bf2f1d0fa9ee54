//! `modalign update`: the model of a scene brought to its test.

use crate::error::Error;
use crate::io::write_all_whole;
use crate::report::{RENDERERS, json, update_blocks};
use crate::scene::{Scene, update_scene};

use super::Outcome;
use super::args::UpdateArgs;
use super::output::Output;
use super::report::rebuild;

/// Updates the scene's model; exit code 1 when it did not converge or part of the input was bad.
pub fn update(
    args: &UpdateArgs,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    let mut scene = Scene::load(&args.scene)?;
    scene.format = format.map(str::to_owned);
    for test in &mut scene.tests {
        test.partial |= args.partial;
    }
    let own = update_scene(&scene)?;
    let blocks = output
        .language()
        .translated(update_blocks(&scene.title, &own));
    if let Some(folder) = &args.output {
        let mut files = vec![
            ("update.json".to_owned(), json::update_to_json(&own)),
            ("model.toml".to_owned(), own.model_toml.clone()),
        ];
        for (name, table) in [("before", &own.before), ("after", &own.after)] {
            files.push((
                format!("comparison-{name}.json"),
                json::comparison_to_json(table),
            ));
        }
        // A reader of CSV expects one table; update.json has them all.
        for renderer in RENDERERS.iter().filter(|own| own.name() != "csv") {
            files.push((
                format!("update.{}", renderer.extension()),
                renderer.render(&blocks),
            ));
        }
        let files: Vec<(String, Vec<u8>)> = files
            .into_iter()
            .map(|(name, text)| (name, text.into_bytes()))
            .collect();
        let _writing = output.writing();
        write_all_whole(folder, &files)?;
        rebuild(folder, output.language())?;
    }
    output.translated(&blocks);
    output.json(|| json::update_to_json(&own));
    output.findings(&own.findings);
    let partly_bad = own.tests.iter().any(|test| test.partly_bad);
    Ok(Outcome::missed_if(
        partly_bad || !own.result.stop_reason.converged(),
    ))
}
