//! Between the modes of a soft suspension and its first elastic one a structure moves as a rigid
//! body: its FRFs are its mass line, and its sensors must agree with it.
//!
//! | file | what |
//! |---|---|
//! | `mass_line` | the accelerance of the rigid body in each FRF, with the band that shows it |
//! | `rows` | sensors as rows of a rigid-body motion, and the motion that fits them |
//! | `sensor_faults`, `repair` | the sensor that does not fit, and what would make it fit |
//! | `inertia` | mass, centre of mass and inertia tensor from hits at several points |
//! | `moving_bodies` | the sensors of one body of several, in the lowest modes |
//! | `stated_mass` | a stated mass against that of the mass line |
//!
//! # Reference
//! Okubo and Furusawa (1986), Measurement of rigid body properties for dynamic analysis, IMAC 4;
//! Almeida, Urgueira and Maia (2007), Identification of rigid body properties from vibration
//! measurements, Journal of Sound and Vibration 299.

mod inertia;
mod mass_line;
mod moving_bodies;
mod repair;
mod rows;
mod sensor_faults;
mod stated_mass;
#[cfg(test)]
mod synthetic;
#[cfg(test)]
mod synthetic_bodies;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use crate::axis::Band;
use crate::dof::Dof;

use super::FrfSet;
pub use inertia::Inertia;
use mass_line::MassLines;
pub use mass_line::SuspensionModes;
pub use moving_bodies::{MovingBody, rigid_in_modes};
pub use repair::Repair;
pub use rows::PlacedSensor;
use rows::Rows;
pub use sensor_faults::SensorFault;
pub use stated_mass::MassComparison;

/// The rigid-body behaviour of a test.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidBody {
    /// Lines of the mass line.
    pub band: Band,
    /// Number of sensors whose motions are compared.
    pub sensors: usize,
    /// The sensor that does not fit, if one alone explains all that does not fit.
    pub fault: Option<SensorFault>,
    /// Sum of squares of what does not fit, over its degrees of freedom, without the fault. Errors
    /// of half a percent, as calibrations and positions have, count as noise.
    pub misfit: f64,
    /// Mass, centre and inertia, where the hits determine them.
    pub inertia: Option<Inertia>,
}

/// Largest misfit beside which a mass is shown: sensors that do not move as one body have none.
const MAX_MISFIT: f64 = 4.0;

/// Fits the motion of a rigid body to the mass lines of a set.
///
/// `placed` has position and direction of degrees of freedom by their positive name; others are not
/// used. `band` is that of the mass line, found in the FRFs where it is not stated. `None` where no
/// band has a mass line, or too few sensors are placed.
pub fn rigid_body(
    set: &FrfSet,
    placed: &BTreeMap<Dof, PlacedSensor>,
    band: Option<Band>,
) -> Option<RigidBody> {
    let MassLines { band, lines } = match band {
        Some(band) => mass_line::stated_mass_lines(set, band),
        None => mass_line::find_mass_lines(set),
    }?;
    let rows = Rows::new(set, placed, &lines)?;
    let fault = sensor_faults::find(&rows);
    let repaired = fault
        .as_ref()
        .map_or_else(|| rows.clone(), |fault| rows.repaired(&fault.repair));
    let misfit = repaired.misfit()?;
    Some(RigidBody {
        band,
        sensors: rows.sensors.len(),
        misfit,
        inertia: inertia::fit(&repaired).filter(|_| misfit <= MAX_MISFIT),
        fault,
    })
}

/// Frequency of a peak over a stated highest rigid-body mode up to which it is that mode. Larger,
/// at 2: an elastic mode near a stiff suspension is taken for its rigid-body mode. Smaller, at 1:
/// the rigid-body mode, stated with two digits, is taken for elastic
/// (`peaks_beside_the_mass_line_are_the_modes_of_the_suspension_and_the_first_elastic_one`).
const MAX_OVER_STATED: f64 = 1.1;

/// The modes on both sides of the mass line, from the clear peaks of the mean accelerance.
pub fn suspension_modes(set: &FrfSet, stated_hz: Option<f64>) -> SuspensionModes {
    match stated_hz {
        Some(stated_hz) => {
            let peaks = mass_line::peaks_hz(set).unwrap_or_default();
            let is_elastic = |hz: &f64| *hz > MAX_OVER_STATED * stated_hz;
            SuspensionModes {
                rigid_body_hz: stated_hz.into(),
                elastic_hz: peaks.into_iter().find(is_elastic),
            }
        }
        None => mass_line::find_suspension_modes(set),
    }
}
