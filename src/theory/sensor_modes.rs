//! Sensors of a test observe the modes of a model with given parameter values.

use std::collections::BTreeSet;

use num_complex::Complex64;

use crate::finding::{Code, Finding, Location, Severity};
use crate::geometry::{Sensor, Target};
use crate::linalg::RealMatrix;
use crate::modal::{ModeShape, modal_phase_collinearity};

use super::eigen::{ModeOptions, TheoryModes};
use super::energy::part_shares;
use super::system::System;
use super::{ParameterStatus, TheoreticalModel, TheoryError};

/// Modes of a model with these parameter values at these sensors.
///
/// Parameters whose status is assumed come back as findings of the modal model.
///
/// # Errors
/// Those of [`TheoreticalModel::assemble`], [`TheoreticalModel::observation_row`] and
/// [`modes_of_matrices`](super::modes_of_matrices); [`TheoryError::RotationAtPoint`],
/// [`TheoryError::Duplicate`] for a sensor given twice.
pub fn modes(
    model: &dyn TheoreticalModel,
    values: &[f64],
    sensors: &[Sensor],
    options: &ModeOptions,
) -> Result<TheoryModes, TheoryError> {
    check_sensors(sensors)?;
    let rows = sensors
        .iter()
        .map(|sensor| Ok(nonzeros(&model.observation_row(values, &sensor.target)?)))
        .collect::<Result<Vec<_>, TheoryError>>()?;
    let mut result = System::of(model, values)?.modes(options)?;
    let parts = model.stiffness_parts(values)?;
    if !parts.is_empty() {
        result.strain_shares = part_shares(&parts, &result.vectors);
    }
    state_damping(model, options, &mut result);
    for (j, mode) in result.model.modes.iter_mut().enumerate() {
        mode.shape = observe(&result.vectors, j, sensors, &rows);
        let values: Vec<Complex64> = mode.shape.iter().map(|(_, value)| value).collect();
        mode.mpc = modal_phase_collinearity(&values);
    }
    let assumed = model.parameters().iter().zip(values);
    let assumed = assumed.filter(|(spec, _)| spec.status == ParameterStatus::Assumed);
    result.model.findings.extend(assumed.map(|(spec, value)| {
        let location = Location::Parameter(spec.name.clone());
        Finding::new(Severity::Info, Code::Assumption, location).value(*value, &spec.unit)
    }));
    Ok(result)
}

/// Damping ratios that the model states mode by mode stand for those of its matrices.
fn state_damping(model: &dyn TheoreticalModel, options: &ModeOptions, result: &mut TheoryModes) {
    if options.damping_ratio.is_some() {
        return;
    }
    let numbers = result.numbers.iter();
    for (mode, number) in result.model.modes.iter_mut().zip(numbers) {
        let stated = number.and_then(|elastic| model.stated_damping(elastic));
        mode.damping_ratio = stated.or(mode.damping_ratio);
    }
}

/// The entries of an observation row that are not zero, with their places.
fn nonzeros(row: &[f64]) -> Vec<(usize, f64)> {
    let entries = row.iter().copied().enumerate();
    entries.filter(|(_, b)| b.abs() > 0.0).collect()
}

fn observe(
    vectors: &RealMatrix,
    j: usize,
    sensors: &[Sensor],
    rows: &[Vec<(usize, f64)>],
) -> ModeShape {
    let reading = |row: &Vec<(usize, f64)>| -> f64 {
        let products = row.iter().map(|&(i, b)| b * vectors[(i, j)]);
        products.sum()
    };
    let pairs = sensors.iter().zip(rows);
    ModeShape::new(pairs.map(|(sensor, row)| (sensor.dof.positive(), reading(row).into())))
}

pub(super) fn check_sensors(sensors: &[Sensor]) -> Result<(), TheoryError> {
    let mut seen = BTreeSet::new();
    for sensor in sensors {
        let at_point = matches!(sensor.target, Target::BodyPoint { .. });
        if at_point && sensor.dof.axis().is_rotation() {
            let dof = sensor.dof.clone();
            return Err(TheoryError::RotationAtPoint { dof });
        }
        if !seen.insert(sensor.dof.positive()) {
            return Err(TheoryError::Duplicate {
                what: "sensor",
                name: sensor.dof.positive().to_string(),
            });
        }
    }
    Ok(())
}
