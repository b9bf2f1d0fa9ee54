//! The options of `[update]`, checked before any file is read.

use crate::axis::Band;
use crate::theory::ParameterSpec;
use crate::update::{Residuals, UpdateError, UpdateOptions};

use super::SceneError;
use super::error::value_error;
use super::faults::Faults;
use super::typed::UpdateTable;

/// Checks the options of `[update]`.
///
/// # Errors
/// [`SceneError::Value`] for each option that is not valid or has no effect.
pub(super) fn check_update(stated: &UpdateTable, path: &str) -> Result<(), SceneError> {
    let mut faults = Faults::default();
    faults.take(check_effect(stated, path));
    faults.take(update_band(stated, path));
    faults.take(residuals(stated, path));
    for error in stated_options(stated).faults() {
        faults.add(match error {
            UpdateError::Option {
                name,
                got,
                expected,
            } => value_error(
                path,
                &format!("[update] {name}"),
                &got.to_string(),
                expected,
            ),
            other => other.into(),
        });
    }
    faults.into_result()
}

/// The options that are stated, and the defaults of the others; residuals and pairing aside.
pub(super) fn stated_options(stated: &UpdateTable) -> UpdateOptions {
    let default = UpdateOptions::default();
    let floor = stated.shape_floor.or(default.shape_floor);
    let stated_or = |stated: Option<f64>, default: f64| stated.unwrap_or(default);
    UpdateOptions {
        assumed_shape_std: stated_or(stated.assumed_shape_std, default.assumed_shape_std),
        frf_floor: stated_or(stated.frf_floor, default.frf_floor),
        frf_lines: stated.frf_lines.unwrap_or(default.frf_lines),
        scatter_between_tests: stated.scatter_between_tests,
        frequency_floor: stated_or(stated.frequency_floor, default.frequency_floor),
        shape_floor: floor.filter(|_| stated.shapes != Some(false)),
        prior_std: stated_or(stated.prior_std, default.prior_std),
        starts: stated.starts.unwrap_or(default.starts),
        seed: stated.seed.unwrap_or(default.seed),
        max_iterations: stated.max_iterations.unwrap_or(default.max_iterations),
        ..default
    }
}

/// Checks that the model has every parameter that `[update]` names.
///
/// # Errors
/// [`SceneError::Value`] for each other one.
pub(super) fn check_parameter_names(
    stated: &UpdateTable,
    parameters: &[ParameterSpec],
    path: &str,
) -> Result<(), SceneError> {
    let mut faults = Faults::default();
    let known: Vec<&str> = parameters.iter().map(|spec| spec.name.as_str()).collect();
    let of_tables = stated.parameter.iter();
    let of_tables = of_tables.map(|table| {
        (
            format!("[[update.parameter]] {:?}", table.name),
            &table.name,
        )
    });
    let listed = stated.parameters.iter();
    let listed = listed.map(|name| ("[update] parameters".to_owned(), name));
    for (key, name) in of_tables.chain(listed) {
        if !known.contains(&name.as_str()) {
            let expected = format!("a parameter of the model: {}", known.join(", "));
            faults.add(value_error(path, &key, &format!("{name:?}"), &expected));
        }
    }
    faults.into_result()
}

/// Checks that every stated option has an effect.
fn check_effect(stated: &UpdateTable, path: &str) -> Result<(), SceneError> {
    let mut faults = Faults::default();
    let mut refuse = |key: &str, got: &str, expected: &str| {
        faults.add(value_error(path, &format!("[update] {key}"), got, expected));
    };
    if !stated.always.is_empty() && !stated.explain {
        let got = stated.always.join(", ");
        let expected = "explain = true beside it, the trials that it is for";
        refuse("always", &got, expected);
    }
    let of_frfs = |name: &String| Residuals::from_name(name).is_some_and(Residuals::of_frfs);
    let of_frfs = stated.residuals.as_ref().filter(|name| of_frfs(name));
    if let Some(name) = of_frfs.filter(|_| stated.explain) {
        let expected = "residuals of modes beside it, by which its trials are ranked";
        refuse("explain", &format!("true beside {name:?}"), expected);
    }
    if of_frfs.is_none() {
        let floor = stated.frf_floor.map(|floor| ("frf_floor", floor));
        let lines = stated.frf_lines.map(|lines| ("frf_lines", lines as f64));
        for (key, got) in floor.into_iter().chain(lines) {
            let expected = "residuals of FRFs beside it, the only ones to which it applies";
            refuse(key, &got.to_string(), expected);
        }
    }
    if let Some(floor) = stated.shape_floor.filter(|_| stated.shapes == Some(false)) {
        let expected = "no shape_floor beside shapes = false";
        refuse("shape_floor", &floor.to_string(), expected);
    }
    faults.into_result()
}

/// The stated band.
///
/// # Errors
/// [`SceneError::Value`] for one without width.
pub(super) fn update_band(stated: &UpdateTable, path: &str) -> Result<Option<Band>, SceneError> {
    let band = stated.band_hz.map(|[lo, hi]| Band::new(lo, hi)).transpose();
    band.map_err(|error| {
        let got = format!("{:?}", stated.band_hz.unwrap_or_default());
        value_error(path, "[update] band_hz", &got, &error.to_string())
    })
}

/// The compared quantities.
///
/// # Errors
/// [`SceneError::Value`] for an unknown name.
pub(super) fn residuals(stated: &UpdateTable, path: &str) -> Result<Residuals, SceneError> {
    let Some(name) = &stated.residuals else {
        return Ok(Residuals::Modes);
    };
    Residuals::from_name(name).ok_or_else(|| {
        let known = Residuals::ALL.map(Residuals::name).join(", ");
        let (got, expected) = (format!("{name:?}"), format!("one of {known}"));
        value_error(path, "[update] residuals", &got, &expected)
    })
}
