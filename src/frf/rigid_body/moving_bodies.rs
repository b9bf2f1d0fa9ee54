//! Bodies of a machine on springs: below the first mode of a body its sensors move as a rigid body
//! in every mode of the machine.
//!
//! The real and the imaginary part of a mode shape at the sensors of one body are two motions of
//! that body, which are checked as the mass lines of two hits are.

use std::collections::BTreeMap;

use super::mass_line::MassLine;
use super::repair::Repair;
use super::rows::{Entry, Motion, PlacedSensor, Rows};
use super::sensor_faults::{SensorFault, find};
use crate::dof::Dof;
use crate::modal::Mode;

/// Fewest modes in which a body is rigid. Smaller, at 2: a body that bends in all modes has a
/// sensor named that takes most of the bending (`a_body_that_bends_has_no_sensor_named`). Larger,
/// at 8: machines with fewer modes below the first of the body are not checked
/// (`a_wrong_sensor_of_a_body_is_named_and_repaired`).
const MIN_MODES: usize = 3;
/// Counts of modes in a row in which a body is not rigid, after which more modes are not tried.
/// Smaller, at 1: of 20 wrong gains two are not seen
/// (`a_wrong_sensor_of_a_body_is_named_and_repaired`).
/// Larger, at 100: a body that bends is fitted for every count of modes
/// (`a_body_that_bends_is_fitted_three_times`).
const MAX_BENT_COUNTS: usize = 3;
/// Sensors beyond the motions that they see. Smaller, at 1: without the wrong sensor the others fit
/// any motion (`a_body_that_bends_has_no_sensor_named`). Larger, at 8: bodies with a dozen sensors
/// are not checked (`a_wrong_sensor_of_a_body_is_named_and_repaired`).
const MIN_SPARE_SENSORS: usize = 2;
/// Deviations of the sum of squares of what does not fit, over its freedom, from 1, up to which a
/// body is rigid, in each mode and in all. Larger, at 100: modes in which the body bends count as
/// rigid (`a_body_that_bends_has_no_sensor_named`). Smaller, at 1: sound modes are left out by
/// noise (`modes_of_rigid_bodies_are_all_used`).
const MAX_MISFIT_DEVIATIONS: f64 = 5.0;
/// Fall of the sum of squares by a repair in all modes but the one where it is largest. A wrong
/// sensor is wrong in every mode that moves it. Smaller, where the fall may be negative: a sensor
/// that bends in one mode is named (`a_body_that_bends_has_no_sensor_named`). Larger, at 300: gains
/// are not seen (`a_wrong_sensor_of_a_body_is_named_and_repaired`).
const MIN_FALL_OF_OTHER_MODES: f64 = 12.0;

/// A body that is rigid in the lowest modes of a machine.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingBody {
    /// Number of the lowest modes in which it is rigid.
    pub modes: usize,
    /// The highest of these, Hz.
    pub highest_hz: f64,
    /// The sensor that does not fit, if one alone explains all that does not fit.
    pub fault: Option<SensorFault>,
}

/// Fits the motion of a rigid body to the shapes of as many of the lowest modes as possible.
///
/// `placed` has position and direction of the sensors of one body by their positive name. Modes
/// without standard deviations of their shape are not used. `None` where the body is rigid in fewer
/// than three modes, or it has fewer than two sensors beyond the motions that they see.
pub fn rigid_in_modes(modes: &[Mode], placed: &BTreeMap<Dof, PlacedSensor>) -> Option<MovingBody> {
    let mut modes: Vec<&Mode> = modes
        .iter()
        .filter(|mode| mode.shape_std.is_some())
        .collect();
    modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    largest_rigid(modes.len(), |count| {
        let fault = rigid_motion(&modes[..count], placed)?.fault;
        Some(MovingBody {
            modes: count,
            highest_hz: modes[count - 1].frequency_hz,
            fault,
        })
    })
}

/// The body with the largest count of modes, from [`MIN_MODES`] up to `all`, in which it is rigid,
/// before [`MAX_BENT_COUNTS`] in a row in which it is not.
fn largest_rigid<T>(all: usize, mut rigid: impl FnMut(usize) -> Option<T>) -> Option<T> {
    let mut largest = None;
    let mut bent = 0;
    for count in MIN_MODES..=all {
        match rigid(count) {
            Some(body) => (largest, bent) = (Some(body), 0),
            None => bent += 1,
        }
        if bent == MAX_BENT_COUNTS {
            break;
        }
    }
    largest
}

/// Sensors that fit the motion of a rigid body, but for one.
struct RigidMotion {
    fault: Option<SensorFault>,
}

/// The motion in these modes, with the repair of one sensor where it needs one; a sensor that
/// nothing repairs may bend. `None` where sensors do not fit and no single fault explains it.
fn rigid_motion(modes: &[&Mode], placed: &BTreeMap<Dof, PlacedSensor>) -> Option<RigidMotion> {
    let is_measured = |dof: &Dof| {
        let mut shapes = modes.iter().map(|mode| &mode.shape);
        shapes.any(|shape| shape.along_positive(dof).is_some())
    };
    let sensors: Vec<(Dof, PlacedSensor)> = placed
        .iter()
        .filter(|(dof, _)| is_measured(dof))
        .map(|(dof, placed)| (dof.clone(), *placed))
        .collect();
    let of_sensor = |(dof, _): &(Dof, PlacedSensor)| -> Vec<Entry> {
        modes.iter().flat_map(|mode| entries(mode, dof)).collect()
    };
    let entries = sensors.iter().map(of_sensor).collect();
    let rows = Rows::of_entries(sensors, Vec::new(), entries)?;
    if rows.sensors.len() < rows.motions.ncols() + MIN_SPARE_SENSORS {
        return None;
    }
    let fault = find(&rows);
    let repaired = fault
        .as_ref()
        .map_or_else(|| rows.clone(), |fault| rows.repaired(&fault.repair));
    let motions = repaired.fit(&repaired.seen_rows(), &[])?;
    // Of two parts each; a fault that mends some modes and spoils others is none.
    let are_rigid = motions.chunks(2).all(is_rigid) && is_rigid(&motions);
    let as_stated = rows.fit(&rows.seen_rows(), &[])?;
    let falls = as_stated.chunks(2).zip(motions.chunks(2));
    let falls: Vec<f64> = falls
        .map(|(stated, mended)| misfit(stated) - misfit(mended))
        .collect();
    let largest = falls.iter().copied().fold(0.0, f64::max);
    let is_of_several_modes = falls.iter().sum::<f64>() - largest >= MIN_FALL_OF_OTHER_MODES;
    let is_explained = fault
        .as_ref()
        .is_none_or(|fault| is_of_several_modes && !matches!(fault.repair, Repair::LeftOut(_)));
    (are_rigid && is_explained).then_some(RigidMotion { fault })
}

fn misfit(motions: &[Motion]) -> f64 {
    motions.iter().map(|motion| motion.misfit).sum()
}

/// Whether what does not fit in some modes is noise.
fn is_rigid(motions: &[Motion]) -> bool {
    let freedom: f64 = motions.iter().map(|motion| motion.freedom).sum();
    misfit(motions) <= freedom + MAX_MISFIT_DEVIATIONS * (2.0 * freedom).sqrt()
}

/// Real and imaginary part of a shape at a sensor.
fn entries(mode: &Mode, dof: &Dof) -> [Entry; 2] {
    let std = mode.shape_std.as_ref();
    let std = std.and_then(|all| all.get(dof).or_else(|| all.get(&dof.opposite())));
    let value = mode.shape.along_positive(dof).zip(std);
    let entry = |value: f64, std: f64| MassLine {
        value,
        variance: std * std,
    };
    match value {
        Some((value, std)) => [value.re, value.im].map(|part| Some(entry(part, *std))),
        None => [None, None],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_that_bends_is_fitted_three_times() {
        let fits_up_to = |all: usize, is_rigid: &dyn Fn(usize) -> bool| {
            let mut fits = 0;
            let largest = largest_rigid(all, |count| {
                fits += 1;
                is_rigid(count).then_some(count)
            });
            (largest, fits)
        };
        assert_eq!(fits_up_to(200, &|_| false), (None, 3));
        assert_eq!(fits_up_to(200, &|count| count <= 10), (Some(10), 11));
        assert_eq!(fits_up_to(10, &|_| true), (Some(10), 8));
        // Noise in two counts ends nothing.
        assert_eq!(fits_up_to(10, &|count| count > 4), (Some(10), 8));
        assert_eq!(fits_up_to(2, &|_| true), (None, 0));
    }
}
