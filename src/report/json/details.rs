//! Models of increasing detail are compared in files of the schema `modalign-details/1`.

use std::f64::consts::TAU;

use serde::Serialize;

use crate::theory::DetailComparison;

use super::schema::json_text;

/// The schema of [`details_to_json`].
pub const DETAILS_SCHEMA: &str = "modalign-details/1";

#[derive(Serialize)]
struct DetailsFile<'a> {
    schema: &'static str,
    within: f64,
    models: Vec<ModelFile<'a>>,
    roots: Vec<RootFile>,
}

#[derive(Serialize)]
struct ModelFile<'a> {
    name: &'a str,
    coordinates: usize,
    /// Relative to that of the whole model.
    cost: f64,
}

#[derive(Serialize)]
struct RootFile {
    frequency_hz: f64,
    multiplicity: usize,
    /// Relative error in each of the models; null for a model without such a mode.
    errors: Vec<Option<f64>>,
    /// Coordinates of the simplest model within the error.
    simplest_coordinates: Option<usize>,
}

/// The text of a comparison within a relative error, ending in a newline.
pub fn details_to_json(comparison: &DetailComparison, within: f64) -> String {
    let whole = comparison
        .models
        .last()
        .map_or(1, |model| model.coordinates);
    let models = comparison.models.iter().map(|model| ModelFile {
        name: &model.name,
        coordinates: model.coordinates,
        cost: model.cost(whole),
    });
    let roots = comparison
        .roots
        .iter()
        .enumerate()
        .map(|(i, root)| RootFile {
            frequency_hz: root.omega_rad_s / TAU,
            multiplicity: root.modes.len(),
            errors: (0..comparison.models.len())
                .map(|model| comparison.error(model, i))
                .collect(),
            simplest_coordinates: comparison
                .simplest(i, within)
                .map(|model| model.coordinates),
        });
    let file = DetailsFile {
        schema: DETAILS_SCHEMA,
        within,
        models: models.collect(),
        roots: roots.collect(),
    };
    json_text(&file)
}
