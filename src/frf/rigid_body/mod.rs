//! Between the modes of a soft suspension and its first elastic one a structure moves as a rigid
//! body: its FRFs are its mass line, and its sensors must agree with it.
//!
//! | file | what |
//! |---|---|
//! | `mass_line` | the accelerance of the rigid body in each FRF, with the band that shows it |
//! | `rows` | sensors as rows of a rigid-body motion, and the motion that fits them |
//! | `misfit` | how well the sensors fit, with its limit |
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
mod misfit;
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
pub use inertia::{Inertia, NoMass};
use mass_line::MassLines;
pub use mass_line::NeighbouringPeaks;
pub use misfit::Misfit;
pub use moving_bodies::{MovingBody, rigid_in_modes};
pub use repair::Repair;
pub use rows::PlacedSensor;
use rows::Rows;
pub use sensor_faults::{MIN_FALL, SensorFault};
pub use stated_mass::MassComparison;

/// The rigid-body behaviour of a test.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidBody {
    /// Lines of the mass line.
    pub band: Band,
    /// Number of sensors whose motions are compared.
    pub sensors: usize,
    /// The sensor that does not fit, if the others fit without its fault.
    pub fault: Option<SensorFault>,
    /// How well the sensors fit, without the fault.
    pub misfit: Misfit,
    /// Mass, centre and inertia, or why there are none.
    pub inertia: Result<Inertia, NoMass>,
}

impl RigidBody {
    /// Whether the sensors move as one rigid body, after the repair of a single one.
    pub fn is_rigid(&self) -> bool {
        self.misfit.is_small()
    }
}

/// Fits the motion of a rigid body to the mass lines of a set.
///
/// `placed` has position and direction of degrees of freedom by their positive name; others are not
/// used. `None` where no band has a mass line, or no more sensors are placed than the motions that
/// they see.
pub fn rigid_body(set: &FrfSet, placed: &BTreeMap<Dof, PlacedSensor>) -> Option<RigidBody> {
    let MassLines {
        band,
        lines,
        has_suspension,
    } = mass_line::find_mass_lines(set)?;
    let rows = Rows::new(set, placed, &lines)?;
    // With two faults the repair of one makes nothing fit.
    let repaired = |fault: SensorFault| {
        let repaired = rows.repaired(&fault.repair);
        let misfit = repaired.misfit().filter(Misfit::is_small)?;
        Some((repaired, misfit, Some(fault)))
    };
    let (repaired, misfit, fault) = match sensor_faults::find(&rows).and_then(repaired) {
        Some(found) => found,
        None => (rows.clone(), rows.misfit()?, None),
    };
    let inertia = match (misfit.is_small(), has_suspension) {
        (false, _) => Err(NoMass::SensorsNotRigid),
        (true, true) => Err(NoMass::SuspensionInBand),
        (true, false) => inertia::fit(&repaired),
    };
    Some(RigidBody {
        band,
        sensors: rows.sensors.len(),
        misfit,
        inertia,
        fault,
    })
}

/// Frequency of a peak over a stated highest rigid-body mode up to which it is that mode. Larger,
/// at 2: an elastic mode near a stiff suspension is taken for its rigid-body mode. Smaller, at 1:
/// the rigid-body mode, stated with two digits, is taken for elastic
/// (`peaks_beside_the_mass_line_are_found`).
const MAX_OVER_STATED: f64 = 1.1;

/// The clear peaks of the mean accelerance on both sides of the mass line; above a stated highest
/// rigid-body mode, the lowest one.
pub fn neighbouring_peaks(set: &FrfSet, stated_hz: Option<f64>) -> NeighbouringPeaks {
    match stated_hz {
        Some(stated_hz) => {
            let peaks = mass_line::peaks_hz(set).unwrap_or_default();
            let is_elastic = |hz: &f64| *hz > MAX_OVER_STATED * stated_hz;
            NeighbouringPeaks {
                below_hz: None,
                above_hz: peaks.into_iter().find(is_elastic),
            }
        }
        None => mass_line::find_neighbouring_peaks(set),
    }
}
