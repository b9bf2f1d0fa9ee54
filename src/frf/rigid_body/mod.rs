//! Between the modes of a soft suspension and its first elastic one a structure moves as a rigid
//! body: its FRFs are its mass line, and its sensors must agree with it.
//!
//! | file | what |
//! |---|---|
//! | `mass_line` | the accelerance of the rigid body in each FRF, with the band that shows it |
//! | `rows` | sensors as rows of a rigid-body motion, and the motion that fits them |
//! | `sensor_faults`, `repair` | the sensor that does not fit, and what would make it fit |
//! | `inertia` | mass, centre of mass and inertia tensor from hits at several points |
//!
//! # Reference
//! Okubo and Furusawa (1986), Measurement of rigid body properties for dynamic analysis, IMAC 4;
//! Almeida, Urgueira and Maia (2007), Identification of rigid body properties from vibration
//! measurements, Journal of Sound and Vibration 299.

mod inertia;
mod mass_line;
mod repair;
mod rows;
mod sensor_faults;
#[cfg(test)]
mod synthetic;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use crate::axis::Band;
use crate::dof::Dof;

use super::FrfSet;
pub use inertia::Inertia;
use mass_line::MassLines;
pub use repair::Repair;
pub use rows::PlacedSensor;
use rows::Rows;
pub use sensor_faults::SensorFault;

/// The rigid-body behaviour of a test.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidBody {
    /// Lines of the mass line.
    pub band: Band,
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
        misfit,
        inertia: inertia::fit(&repaired).filter(|_| misfit <= MAX_MISFIT),
        fault,
    })
}
