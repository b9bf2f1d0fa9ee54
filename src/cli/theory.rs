//! `modalign theory`: natural frequencies and shapes of a model.

use std::collections::BTreeMap;

use crate::error::Error;
use crate::io::modes_to_json;
use crate::report::json::{details_to_json, response_to_json, sweeps_to_json};
use crate::report::{
    Block, details_blocks, energies_block, parameters_block, quantities_block, response_blocks,
    roots_block, sensitivities_block, simplest_details_block, sweep_blocks, theory_block,
};
use crate::scene::{
    LoadedModel, ModelTable, Scene, SceneError, Theory, load_model, table_model,
    theory as scene_theory,
};
use crate::theory::ModeOptions;

use super::Outcome;
use super::args::TheoryArgs;
use super::output::{MODES, Output, check_extension, write_modes};

/// Prints the modes; writes them with `-o`.
pub fn theory(args: &TheoryArgs, output: &mut Output) -> Result<Outcome, Error> {
    check_extension(args.output.as_deref(), MODES)?;
    let result = solve(args)?;
    let json = modes_to_json(&result.modes, None);
    if let Some(path) = &args.output {
        let lost = write_modes(path, &result.modes, &result.geometry, &json)?;
        output.findings(&lost);
    }
    let mut blocks: Vec<Block> = parameters_block(&result.parameters).into_iter().collect();
    let name = args.model.display();
    blocks.push(if result.roots.is_empty() {
        theory_block(&format!("Modes of {name}"), &result.modes)
    } else {
        roots_block(&format!("Roots of {name}"), &result.roots, args.band)
    });
    if args.energies {
        let caption = format!("Energy of the roots of {name}");
        blocks.extend(energies_block(&caption, &result.roots, args.band));
    }
    let special = match model(args)? {
        Some(model) => analyses(args, &model, &result, &mut blocks)?,
        None => None,
    };
    output.blocks(&blocks);
    output.json(|| special.unwrap_or(json));
    output.findings(&result.modes.findings);
    Ok(Outcome::Done)
}

/// What was asked of a model beside its modes, as blocks; its JSON where it has one of its own.
fn analyses(
    args: &TheoryArgs,
    model: &LoadedModel,
    result: &Theory,
    blocks: &mut Vec<Block>,
) -> Result<Option<String>, SceneError> {
    let name = &args.model.display().to_string();
    let mut special = None;
    if args.sensitivities {
        let caption = format!("Sensitivities of the roots of {name}");
        let found = model.sensitivities(args.band)?;
        let block = sensitivities_block(&caption, &result.parameters, &found, args.band);
        blocks.push(block);
    }
    if args.quantities {
        blocks.extend(quantities_block(name, &model.quantities()?));
    }
    let within = args.compare.map(|percent| 0.01 * percent);
    if args.response || within.is_some() && model.model.nonlinear().is_some() {
        let found = model.response()?;
        blocks.extend(response_blocks(name, &found));
        blocks.extend(within.map(|within| simplest_details_block(name, &found, within)));
        special = Some(response_to_json(&found));
    } else if let Some(within) = within {
        let found = model.compare_details()?;
        blocks.extend(details_blocks(name, &found, within));
        special = Some(details_to_json(&found, within));
    }
    let mut sweeps = Vec::new();
    for (parameter, range) in &args.sweep {
        let swept = model.sweep(parameter, *range)?;
        blocks.extend(sweep_blocks(name, &swept, args.band));
        sweeps.push(swept);
    }
    let swept = !sweeps.is_empty();
    Ok(special.or_else(|| swept.then(|| sweeps_to_json(&sweeps))))
}

/// The model file itself, or the model of a scene at the scene's sensors.
fn solve(args: &TheoryArgs) -> Result<Theory, SceneError> {
    let options = ModeOptions {
        band: args.band,
        ..ModeOptions::default()
    };
    if !Scene::is_path(&args.model) {
        let model = load_model(&args.model, &settings(args))?;
        return model.solve(&model.sensors, &options);
    }
    let (scene, table) = scene_table(args)?;
    scene_theory(&table, &scene.folder, &scene.path, &scene.sensors, &options)
}

/// The model with its parameters; `None` for finished modes.
fn model(args: &TheoryArgs) -> Result<Option<LoadedModel>, SceneError> {
    if Scene::is_path(&args.model) {
        let (scene, table) = scene_table(args)?;
        return table_model(&table, &scene.folder, &scene.path);
    }
    load_model(&args.model, &settings(args)).map(Some)
}

fn settings(args: &TheoryArgs) -> BTreeMap<String, f64> {
    args.settings.iter().cloned().collect()
}

/// A scene and its model with the parameters that were set.
fn scene_table(args: &TheoryArgs) -> Result<(Scene, ModelTable), SceneError> {
    let scene = Scene::load(&args.model)?;
    let mut table = scene.model.clone().unwrap_or_default();
    table.parameters.extend(settings(args));
    Ok((scene, table))
}
