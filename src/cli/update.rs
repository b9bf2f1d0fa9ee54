//! `modalign update`: the model of a scene brought to its test.

use crate::error::Error;
use crate::io::write_whole;
use crate::report::{RENDERERS, json, update_blocks};
use crate::scene::{Scene, update_scene};

use super::Outcome;
use super::args::UpdateArgs;
use super::output::Output;

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
        write_whole(&folder.join("update.json"), json::update_to_json(&own))?;
        write_whole(&folder.join("model.toml"), &own.model_toml)?;
        for (name, table) in [("before", &own.before), ("after", &own.after)] {
            let text = json::comparison_to_json(table);
            write_whole(&folder.join(format!("comparison-{name}.json")), text)?;
        }
        // A reader of CSV expects one table; update.json has them all.
        for renderer in RENDERERS.iter().filter(|own| own.name() != "csv") {
            let name = format!("update.{}", renderer.extension());
            write_whole(&folder.join(name), renderer.render(&blocks))?;
        }
    }
    output.translated(&blocks);
    output.json(|| json::update_to_json(&own));
    output.findings(&own.findings);
    let partly_bad = own.tests.iter().any(|test| test.partly_bad);
    Ok(Outcome::missed_if(
        partly_bad || !own.result.stop_reason.converged(),
    ))
}
