//! The mass line of a test, with the positions of its points from files and sensors of the scene.

use std::collections::BTreeMap;

use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::FrfSet;
use crate::frf::rigid_body::{PlacedSensor, Repair, RigidBody, rigid_body};
use crate::geometry::{Geometry, Sensor, Target, unit};

/// Findings on the mass line of a set: its mass, and the sensor that does not move with the body.
///
/// Nothing comes back where no points are placed, or no band has a mass line.
pub fn mass_line_findings(set: &FrfSet, geometry: &Geometry, sensors: &[Sensor]) -> Vec<Finding> {
    let set = &set.motions();
    let placed = placed(set, geometry, sensors);
    rigid_body(set, &placed, None).map_or_else(Vec::new, |body| findings(set, &body))
}

/// Positions and directions of the degrees of freedom of a set: a sensor of the scene at a point of
/// a body, else the node of the point along the axis of the degree of freedom.
fn placed(set: &FrfSet, geometry: &Geometry, sensors: &[Sensor]) -> BTreeMap<Dof, PlacedSensor> {
    let dofs = set.responses().into_iter().chain(set.references());
    let dofs = dofs.map(|dof| dof.positive().with_repeat(1));
    let at = |dof: Dof| {
        let of_scene = sensors.iter().find(|sensor| sensor.dof == dof);
        let placed = match of_scene.map(|sensor| &sensor.target) {
            Some(Target::BodyPoint {
                at_m, direction, ..
            }) => PlacedSensor {
                at_m: *at_m,
                direction: unit(*direction)?.into(),
            },
            Some(Target::Coordinate(_)) => return None,
            None => {
                let node = geometry
                    .nodes
                    .iter()
                    .find(|node| node.point == dof.point())?;
                // A local direction is not that of the name.
                let is_global = node.displacement_system.is_none();
                PlacedSensor {
                    at_m: node.at_m.into(),
                    direction: dof
                        .axis()
                        .unit_vector()
                        .filter(|_| is_global && !dof.axis().is_rotation())?,
                }
            }
        };
        Some((dof, placed))
    };
    dofs.filter_map(at).collect()
}

fn findings(set: &FrfSet, body: &RigidBody) -> Vec<Finding> {
    let mut findings = Vec::new();
    if let Some(fault) = &body.fault {
        // A roving hammer's hits are the rows of the motion.
        let is_hit = !set.responses().contains(&fault.dof);
        let dof = |wanted: bool| (is_hit == wanted).then(|| fault.dof.clone());
        let location = Location::Function {
            response: dof(false),
            reference: dof(true),
        };
        let finding = Finding::new(Severity::Warning, Code::SensorNotRigid, location);
        let what = match &fault.repair {
            Repair::Exchanged(one, other) => format!("{one} and {other} fit in each other's place"),
            repair => repair.to_string(),
        };
        findings.push(finding.value(fault.fall, "").detail(what));
    }
    if let Some(inertia) = &body.inertia {
        let finding = Finding::new(Severity::Info, Code::MassOfMassLine, Location::Whole);
        let [x, y, z] = inertia.centre_m;
        findings.push(finding.value(inertia.mass_kg, "kg").detail(format!(
            "standard deviation {:.1e} kg, centre of mass at ({x:.4}, {y:.4}, {z:.4}) m, from {:.1} to {:.1} Hz",
            inertia.mass_std_kg, body.band.lo_hz, body.band.hi_hz
        )));
    }
    findings
}
