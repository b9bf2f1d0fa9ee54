//! `modalign theory --modify` and `--target`: modes of a modified model, and the changes that reach
//! stated natural frequencies.

use std::path::Path;

use crate::error::Error;
use crate::report::json::{self, UpdateFile, update_from_json};
use crate::report::{Block, DesignResult, ModifiedModes, design_blocks, modification_block};
use crate::scene::{
    BeforeChanges, LoadedModel, ModelKind, Scene, SceneError, StatedDesign, model_kind, read_text,
};
use crate::theory::{ModeOptions, RootState, mode_changes, model_roots, modes};
use crate::update::{ParameterUncertainty, design};

use super::args::TheoryArgs;

/// Largest relative difference of a value from the updated one that counts as the same.
const SAME_VALUE: f64 = 1e-6;

/// Blocks and JSON of a modification and a design.
pub struct WhatIf {
    /// The tables.
    pub blocks: Vec<Block>,
    /// The text.
    pub json: String,
    /// Whether a target is not met.
    pub is_missed: bool,
}

/// The modes before and after the stated changes, and the changes for the stated targets; `None`
/// where neither is requested.
pub fn what_if(
    args: &TheoryArgs,
    loaded: &LoadedModel,
    before: &BeforeChanges,
    scene: &Option<Box<Scene>>,
    first_root: usize,
) -> Result<Option<WhatIf>, Error> {
    if args.modify.is_empty() && args.target.is_empty() {
        return Ok(None);
    }
    let name = &args.model.display().to_string();
    let mut blocks = Vec::new();
    let model = loaded.model.as_ref();
    let changes = match args.modify.is_empty() {
        true => None,
        false => Some(mode_changes(
            model,
            &before.values,
            &loaded.values,
            args.band,
        )?),
    };
    let mut modes_result = None;
    if let Some(changes) = &changes {
        let (relative_stds, uncertainty) = match uncertainty(args, loaded, before)? {
            Ok((known, text)) => {
                let after: Vec<&RootState> = changes
                    .modes
                    .iter()
                    .flat_map(|c| c.after.as_ref())
                    .collect();
                let stds = known
                    .relative_stds(model, &loaded.values, &before.factors, &after)
                    .map_err(SceneError::from)?;
                let mut stds = stds.into_iter();
                let all = changes.modes.iter();
                let each = all.map(|c| c.after.as_ref().and_then(|_| stds.next()).unwrap_or(0.0));
                (Some(each.collect()), text)
            }
            Err(text) => (None, text),
        };
        let result = ModifiedModes {
            changes: &args.modify,
            modes: changes,
            relative_stds,
            uncertainty,
            first_root,
            band: args.band,
        };
        blocks.push(modification_block(name, &result));
        modes_result = Some(result);
    }
    let mut is_missed = false;
    let json = if args.target.is_empty() {
        json::modification_to_json(modes_result.as_ref(), None)
    } else {
        let all = modes(model, &loaded.values, &[], &ModeOptions::default())?;
        let roots = model_roots(model, &all);
        let (targets, free) = loaded.design(&StatedDesign {
            targets: &args.target,
            roots: &roots,
            first_root,
            update: scene.as_ref().and_then(|scene| scene.update.as_ref()),
            path: scene.as_ref().map_or("", |scene| scene.path.as_str()),
            names: &args.free,
            bounds: &args.within,
        })?;
        let found = design(model, &loaded.values, &free, &targets, args.band);
        let found = found.map_err(SceneError::from)?;
        let result = DesignResult {
            targets: &args.target,
            free: &free,
            design: &found,
            by_prior: scene.as_ref().is_some_and(|scene| scene.update.is_some()),
            first_root,
            band: args.band,
        };
        is_missed = !found.combined.is_met;
        blocks.extend(design_blocks(name, &result));
        json::modification_to_json(modes_result.as_ref(), Some(&result))
    };
    Ok(Some(WhatIf {
        blocks,
        json,
        is_missed,
    }))
}

/// The uncertainty with a text of its source, or a text that there is none.
type Known = Result<(ParameterUncertainty, String), String>;

/// The uncertainty of the stated file; else of `update.json` beside a model file.
fn uncertainty(
    args: &TheoryArgs,
    loaded: &LoadedModel,
    before: &BeforeChanges,
) -> Result<Known, Error> {
    let beside = args.model.parent().map(|folder| folder.join("update.json"));
    let beside = beside.filter(|path| model_kind(&args.model) == ModelKind::File && path.is_file());
    let Some(path) = args.uncertainty.as_ref().or(beside.as_ref()) else {
        let text = "No uncertainty is known: no update.json beside the model; --uncertainty FILE.";
        return Ok(Err(text.to_owned()));
    };
    let file = read_update(path)?;
    let known = ParameterUncertainty {
        names: file.parameters.iter().map(|p| p.name.clone()).collect(),
        values: file.parameters.iter().map(|p| p.updated).collect(),
        std: file.parameters.iter().map(|p| p.std).collect(),
        correlation: file.correlation,
    };
    // A parameter of another configuration is not one of this model.
    let shared = file.parameters.iter().map(|p| p.configuration.is_none());
    let known = known.of(&shared.collect::<Vec<_>>());
    let specs = loaded.model.parameters().iter();
    let before: Vec<(&str, f64)> = specs
        .zip(&before.values)
        .map(|(spec, value)| (spec.name.as_str(), *value))
        .collect();
    let other = known
        .names
        .iter()
        .zip(&known.values)
        .find_map(|(name, updated)| {
            let found = before.iter().find(|(known, _)| known == name);
            match found {
                None => Some(format!("no parameter `{name}`")),
                Some((_, value)) => ((value - updated).abs() > SAME_VALUE * updated.abs())
                    .then(|| format!("{name} = {value}, updated {updated}")),
            }
        });
    let shown = path.display();
    match other {
        None if file.fits => Ok(Ok((
            known,
            format!("95 % interval: of first order, by the updated parameters of {shown}."),
        ))),
        None => Ok(Ok((
            known,
            format!(
                "95 % interval: by {shown}, whose misfit remains (chi²/ν {:.1}): it is too narrow.",
                file.reduced_chi_square
            ),
        ))),
        Some(difference) if args.uncertainty.is_some() => Err(Error::Argument {
            argument: "--uncertainty",
            got: format!("{shown} for a model with {difference}"),
            expected: "the update.json of this model: name the updated model.toml as MODEL"
                .to_owned(),
        }),
        Some(difference) => Ok(Err(format!(
            "No uncertainty is known: {shown} is of another model ({difference})."
        ))),
    }
}

fn read_update(path: &Path) -> Result<UpdateFile, Error> {
    let text = read_text(path).map_err(Error::Io)?;
    update_from_json(&text).map_err(|error| Error::Argument {
        argument: "--uncertainty",
        got: format!("{}: {error}", path.display()),
        expected: "the update.json of `modalign update -o`".to_owned(),
    })
}
