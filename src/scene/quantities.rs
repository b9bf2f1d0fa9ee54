//! The quantities of the models that claims name, and a check that they are there.

use std::collections::BTreeMap;
use std::path::Path;

use crate::correlate::published::{Claim, ModelQuantities, QuantityClaim, Statement};

use super::SceneError;
use super::error::value_error;
use super::model::{LoadedModel, load_model, table_model};
use super::model_name::is_built_in;
use super::plan::Scene;

/// Quantities of every model that a claim names, each model once, in the order of the claims.
///
/// # Errors
/// [`SceneError::Value`] for a claim about a quantity or a built-in model that is not there; the
/// model's error.
pub(super) fn quantities(
    scene: &Scene,
    claims: &[Claim],
) -> Result<Vec<ModelQuantities>, SceneError> {
    let mut found: Vec<ModelQuantities> = Vec::new();
    for claim in claims {
        let Statement::Quantity(stated) = &claim.statement else {
            continue;
        };
        if !found.iter().any(|other| other.model == stated.model) {
            let model = model_of(scene, claim, stated)?;
            found.push(ModelQuantities {
                model: stated.model.clone(),
                quantities: model.quantities()?,
            });
        }
        let known = found.iter().filter(|other| other.model == stated.model);
        let known: Vec<&str> = known
            .flat_map(|other| other.quantities.iter().map(|quantity| quantity.name))
            .collect();
        if !known.contains(&stated.quantity.as_str()) {
            let (got, expected) = (
                format!("{:?}", stated.quantity),
                format!("one of {known:?}"),
            );
            return Err(error(claim, "quantity", &got, &expected));
        }
    }
    Ok(found)
}

fn model_of(
    scene: &Scene,
    claim: &Claim,
    stated: &QuantityClaim,
) -> Result<LoadedModel, SceneError> {
    if let Some(name) = &stated.model {
        let name = Path::new(name);
        if !is_built_in(name) {
            let got = format!("{:?}", name.display());
            return Err(error(claim, "model", &got, "the name of a built-in model"));
        }
        return load_model(name, &BTreeMap::new());
    }
    let model = match &scene.model {
        Some(table) => table_model(table, &scene.folder, &scene.path)?,
        None => None,
    };
    model.ok_or_else(|| {
        let got = "a quantity of the scene's model";
        error(
            claim,
            "quantity",
            got,
            "a [model] in the scene that is no file of modes, or `model`",
        )
    })
}

fn error(claim: &Claim, key: &str, got: &str, expected: &str) -> SceneError {
    let key = format!("[[claim]] {:?} {key}", claim.text);
    value_error("expected.toml", &key, got, expected)
}
