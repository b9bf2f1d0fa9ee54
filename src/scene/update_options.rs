//! The options of `[update]`, checked before any file is read.

use crate::axis::Band;
use crate::theory::ParameterSpec;
use crate::update::Residuals;

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
    faults.into_result()
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
