//! The study of models finds the simplest theory and the fewest parameters sufficient for a scene.

use std::f64::consts::TAU;

use crate::scene::{Scene, SceneError, table_model, update_scene};
use crate::theory::{TheoryError, simplest_detail};
use crate::update::{ParameterVerdict, Residuals};

use super::OrderOptions;

/// The simplest theory.
#[derive(Clone, Debug, PartialEq)]
pub enum TheoryNeeds {
    /// A model in which small bodies can be massless.
    Coordinates {
        /// Name of the model.
        model: String,
        /// The end of the tests' bands, Hz; every root of the model counts without one.
        up_to_hz: Option<f64>,
        /// Roots that count.
        roots: usize,
        /// The simplest model that has them all.
        simplest: String,
        /// Its coordinates.
        needed: usize,
        /// Those of the whole model.
        whole: usize,
    },
    /// A model with responses in growing detail.
    Details {
        /// Name of the model.
        model: String,
        /// Each signal with its simplest sufficient detail.
        signals: Vec<(String, Option<String>)>,
        /// The most detailed.
        whole: String,
    },
}

/// The fewest parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterNeeds {
    /// Parameters that may change.
    pub free: Vec<String>,
    /// The smallest set that explains the misfit, or the set of the smallest BIC.
    pub needed: Vec<String>,
    /// Parameters that the tests do not determine.
    pub not_supported: Vec<String>,
    /// `χ²` with none of them changed, with the needed ones, and with all.
    pub chi_square: [f64; 3],
    /// Residuals.
    pub data: usize,
    /// Whether the needed parameters reduce the misfit to its uncertainty.
    pub explains: bool,
}

/// The simplest theory of a scene's model up to the end of its tests' bands, or why the scene has
/// none.
pub(super) fn theory(
    scene: &Scene,
    up_to_hz: Option<f64>,
    options: &OrderOptions,
) -> Result<Result<TheoryNeeds, String>, SceneError> {
    let none = |reason: &str| Ok(Err(reason.to_owned()));
    let Some(table) = &scene.model else {
        return none("the scene has no model");
    };
    let Some(model) = table_model(table, &scene.folder, &scene.path)? else {
        return none("the model is a file of finished modes");
    };
    let name = model.model.name().to_owned();
    let within = 0.01 * options.theory_percent;
    if model.model.nonlinear().is_some() {
        let response = model.response()?;
        let Some(last) = response.details.last() else {
            return none("the model has no detail");
        };
        let signals = last.signals.iter().map(|signal| {
            let found = simplest_detail(&response, signal.name, within);
            (signal.name.to_owned(), found.map(str::to_owned))
        });
        return Ok(Ok(TheoryNeeds::Details {
            model: name,
            signals: signals.collect(),
            whole: last.detail.to_owned(),
        }));
    }
    let compared = match model.compare_details() {
        Err(SceneError::Theory(TheoryError::NoSimplerModel { .. })) => {
            return none(
                "the model has no small bodies whose mass may be neglected, and no response over time",
            );
        }
        other => other?,
    };
    let up_to = up_to_hz.map_or(f64::INFINITY, |hz| TAU * hz);
    let counted = compared
        .roots
        .iter()
        .filter(|root| root.omega_rad_s <= up_to);
    let Some(whole) = compared.models.last() else {
        return none("the model has no roots");
    };
    let simplest = compared.simplest_up_to(up_to, within).unwrap_or(whole);
    Ok(Ok(TheoryNeeds::Coordinates {
        model: name,
        up_to_hz,
        roots: counted.count(),
        simplest: simplest.name.clone(),
        needed: simplest.coordinates,
        whole: whole.coordinates,
    }))
}

/// The fewest parameters of a scene with `[update]`, or why they were not determined.
pub(super) fn parameters(scene: &Scene) -> Result<Result<ParameterNeeds, String>, SceneError> {
    let mut scene = scene.clone();
    let Some(table) = scene.update.as_mut() else {
        return Ok(Err(
            "the scene has no [update], which says what may change".to_owned()
        ));
    };
    let of_frfs = |name: &String| Residuals::from_name(name).is_some_and(Residuals::of_frfs);
    if table.residuals.as_ref().is_some_and(of_frfs) {
        let reason = "[update] compares FRFs; only a comparison of modes shows which are needed";
        return Ok(Err(reason.to_owned()));
    }
    table.explain = true;
    let always = table.always.clone();
    let update = update_scene(&scene)?;
    let Some(explained) = update.explanation else {
        return Ok(Err("no parameter could be tried".to_owned()));
    };
    let parameters = &update.result.parameters;
    let names = |keep: &dyn Fn(&ParameterVerdict) -> bool| {
        let kept = parameters
            .iter()
            .filter(|parameter| keep(&parameter.verdict));
        kept.map(|parameter| parameter.name.clone())
            .collect::<Vec<_>>()
    };
    Ok(Ok(ParameterNeeds {
        free: names(&|_| true),
        needed: [always, explained.proposed.parameters.clone()].concat(),
        not_supported: names(&|verdict| *verdict == ParameterVerdict::NotSupported),
        chi_square: [
            update.result.before.chi_square,
            explained.proposed.fit.chi_square,
            update.result.after.chi_square,
        ],
        data: explained.proposed.fit.data_count,
        explains: explained.proposed.explains(),
    }))
}
