//! Rigid bodies of a test, with the positions of its points from files and sensors of the scene:
//! its mass line, and the bodies of its model in the lowest modes.

use std::collections::BTreeMap;

use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::rigid_body::{
    MassComparison, PlacedSensor, RigidBody, rigid_body, rigid_in_modes, suspension_modes,
};
use crate::frf::{
    BeforeYouLeave, CheckItem, FrfSet, HammerTestResult, MassLineCheck, SupportCheck,
    before_you_leave,
};
use crate::geometry::{Geometry, Sensor, Target, unit};
use crate::modal::ModalModel;
use crate::theory::Support;

use super::supports::MAX_RIGID_BODY_OVER_ELASTIC;
use super::test_state::TestState;

/// Findings on the mass line of a set: its mass, a stated mass that differs, and the sensor that
/// does not move with the body.
///
/// Nothing comes back where no points are placed, or no band has a mass line.
pub fn mass_line_findings(
    set: &FrfSet,
    geometry: &Geometry,
    sensors: &[Sensor],
    state: &TestState,
) -> Vec<Finding> {
    let set = &set.motions();
    let placed = placed(set, geometry, sensors);
    let body = rigid_body(set, &placed, None);
    body.map_or_else(Vec::new, |body| findings(set, &body, state.mass_kg))
}

/// The sensors that do not move with their body of the model in the lowest modes, in which the body
/// is rigid. A sensor that the findings of the test name already is not repeated.
pub(super) fn body_findings(modes: &ModalModel, sensors: &[Sensor]) -> Vec<Finding> {
    let mut bodies: BTreeMap<&str, BTreeMap<Dof, PlacedSensor>> = BTreeMap::new();
    for sensor in sensors {
        if let Target::BodyPoint { body, .. } = &sensor.target
            && let Some(placed) = placed_on_body(&sensor.target)
        {
            bodies
                .entry(body)
                .or_default()
                .insert(sensor.dof.clone(), placed);
        }
    }
    let of_body = |(body, placed): (&str, BTreeMap<Dof, PlacedSensor>)| {
        let moving = rigid_in_modes(&modes.modes, &placed)?;
        let fault = moving.fault?;
        let location = Location::Function {
            response: Some(fault.dof),
            reference: None,
        };
        let is_same =
            |known: &Finding| known.code == Code::SensorNotRigid && known.location == location;
        let detail = format!(
            "body {body}, its {} lowest modes up to {:.2} Hz: {}",
            moving.modes, moving.highest_hz, fault.repair
        );
        let is_known = modes.findings.iter().any(is_same);
        let finding = Finding::new(Severity::Warning, Code::SensorNotRigid, location);
        (!is_known).then(|| finding.value(fault.fall, "").detail(detail))
    };
    bodies.into_iter().filter_map(of_body).collect()
}

/// Position and unit direction of a sensor at a point of a body.
fn placed_on_body(target: &Target) -> Option<PlacedSensor> {
    match target {
        Target::BodyPoint {
            at_m, direction, ..
        } => Some(PlacedSensor {
            at_m: *at_m,
            direction: unit(*direction)?.into(),
        }),
        Target::Coordinate(_) => None,
    }
}

/// The list of what to repeat before the structure is gone, with its mass line and its support.
///
/// `state` is that of the test, as a scene states it.
pub fn leaving_list(
    result: &HammerTestResult,
    geometry: &Geometry,
    sensors: &[Sensor],
    state: &TestState,
) -> BeforeYouLeave {
    let mut list = before_you_leave(result);
    let set = &result.estimated.set.motions();
    let body = rigid_body(set, &placed(set, geometry, sensors), None);
    let mass = body.as_ref().and_then(|body| compared(body, state.mass_kg));
    let check = body.map(|body| Box::new(MassLineCheck { body, mass }));
    let is_suspended = state.support == Some(Support::Suspended);
    if check.is_some() || is_suspended || state.mass_kg.is_some() {
        list.items.push(CheckItem::MassLine(check));
    }
    let support = state
        .support
        .map(|support| support_check(set, support, state));
    list.items.extend(support.map(CheckItem::Support));
    list
}

fn support_check(set: &FrfSet, support: Support, state: &TestState) -> SupportCheck {
    let limit = (support == Support::Suspended).then_some(MAX_RIGID_BODY_OVER_ELASTIC);
    let modes = match support {
        Support::Fixed => None,
        Support::Suspended | Support::Mounted => {
            Some(suspension_modes(set, state.highest_rigid_body_hz))
        }
    };
    SupportCheck {
        support: support.name(),
        rigid_body_hz: modes.and_then(|modes| modes.rigid_body_hz),
        elastic_hz: modes.and_then(|modes| modes.elastic_hz),
        limit,
    }
}

fn compared(body: &RigidBody, stated_kg: Option<f64>) -> Option<MassComparison> {
    Some(MassComparison::new(body.inertia.as_ref()?, stated_kg?))
}

/// Positions and directions of the degrees of freedom of a set: a sensor of the scene at a point of
/// a body, else the node of the point along the axis of the degree of freedom.
fn placed(set: &FrfSet, geometry: &Geometry, sensors: &[Sensor]) -> BTreeMap<Dof, PlacedSensor> {
    let dofs = set.responses().into_iter().chain(set.references());
    let dofs = dofs.map(|dof| dof.positive().with_repeat(1));
    let at = |dof: Dof| {
        let of_scene = sensors.iter().find(|sensor| sensor.dof == dof);
        let placed = match of_scene.map(|sensor| &sensor.target) {
            Some(target) => placed_on_body(target)?,
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

fn findings(set: &FrfSet, body: &RigidBody, stated_kg: Option<f64>) -> Vec<Finding> {
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
        let detail = fault.repair.to_string();
        findings.push(finding.value(fault.fall, "").detail(detail));
    }
    if let Some(inertia) = &body.inertia {
        let finding = Finding::new(Severity::Info, Code::MassOfMassLine, Location::Whole);
        let [x, y, z] = inertia.centre_m;
        findings.push(finding.value(inertia.mass_kg, "kg").detail(format!(
            "standard deviation {:.1e} kg, centre of mass at ({x:.4}, {y:.4}, {z:.4}) m, from {:.1} to {:.1} Hz",
            inertia.mass_std_kg, body.band.lo_hz, body.band.hi_hz
        )));
    }
    if let Some(mass) = compared(body, stated_kg).filter(MassComparison::differs) {
        let finding = Finding::new(Severity::Warning, Code::MassDiffers, Location::Whole);
        let finding = finding
            .value(100.0 * mass.difference(), "%")
            .limit(100.0 * mass.limit);
        findings.push(finding.detail(format!(
            "mass line {:.3} ± {:.3} kg, mass_kg of [test.state] {} kg; all FRFs are {:.3} times what they should be",
            mass.found_kg, mass.std_kg, mass.stated_kg, mass.gain()
        )));
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::Band;
    use crate::frf::FrfSet;
    use crate::frf::rigid_body::Inertia;
    use crate::modal::{Mode, ModeShape, Scaling};
    use num_complex::Complex64;

    #[test]
    fn sensor_that_does_not_move_with_its_body_is_named_with_it() {
        let at = |k: usize| {
            let angle = 2.4 * k as f64;
            [
                0.4 * angle.cos(),
                0.3 * angle.sin(),
                [-0.2, 0.15, 0.25][k % 3],
            ]
        };
        let direction = |k: usize| std::array::from_fn(|axis| f64::from(u8::from(axis == k % 3)));
        let dof = |k: usize| -> Dof { format!("{k}:+X").parse().unwrap() };
        let sensor = |k: usize| Sensor {
            dof: dof(k),
            target: Target::BodyPoint {
                body: "housing".to_owned(),
                at_m: at(k),
                direction: direction(k),
            },
        };
        let sensors: Vec<Sensor> = (1..=12).map(sensor).collect();
        let mode = |number: usize, wrong: f64| {
            let motion: [f64; 6] = std::array::from_fn(|a| ((a + 2) * number) as f64 * 0.7);
            let motion = motion.map(f64::sin);
            let value = |k: usize| {
                let ([x, y, z], d) = (at(k), direction(k));
                let [vx, vy, vz, wx, wy, wz] = motion;
                let v = [
                    vx + wy * z - wz * y,
                    vy + wz * x - wx * z,
                    vz + wx * y - wy * x,
                ];
                let along: f64 = v.iter().zip(d).map(|(v, d)| v * d).sum();
                let factor = if k == 7 { wrong } else { 1.0 };
                (dof(k), Complex64::from(factor * along))
            };
            Mode {
                shape_std: Some((1..=12).map(|k| (dof(k), 0.01)).collect()),
                ..Mode::new(
                    10.0 * number as f64,
                    None,
                    ModeShape::new((1..=12).map(value)),
                    Scaling::Unknown,
                )
            }
        };
        let found = |wrong: f64| {
            let modes = ModalModel {
                modes: (1..=4).map(|number| mode(number, wrong)).collect(),
                ..ModalModel::default()
            };
            body_findings(&modes, &sensors)
        };
        assert_eq!(found(1.0), []);
        let reversed = found(-1.0);
        assert_eq!(reversed.len(), 1);
        let detail = reversed[0].detail.as_deref().unwrap();
        assert!(
            detail.contains("housing") && detail.contains("other sign"),
            "{detail}"
        );
        assert!(detail.contains("4 lowest modes up to 40.00 Hz"), "{detail}");
    }

    #[test]
    fn stated_mass_that_differs_is_reported_with_the_gain() {
        let body = RigidBody {
            band: Band::new(10.0, 40.0).unwrap(),
            sensors: 12,
            fault: None,
            misfit: 1.0,
            inertia: Some(Inertia {
                mass_kg: 20.0,
                mass_std_kg: 0.05,
                centre_m: [0.0; 3],
                centre_std_m: [0.0; 3],
                tensor_kg_m2: [0.0; 6],
            }),
        };
        let axis = crate::axis::FrequencyAxis {
            start_hz: 0.0,
            step_hz: 1.0,
            len: 2,
        };
        let codes = |stated_kg| -> Vec<Finding> {
            let all = findings(&FrfSet::new(axis), &body, stated_kg).into_iter();
            all.filter(|finding| finding.code == Code::MassDiffers)
                .collect()
        };
        assert_eq!(codes(None), []);
        assert_eq!(codes(Some(20.5)), []);
        let found = codes(Some(16.0));
        assert_eq!(found[0].value, Some(25.0));
        assert!((found[0].limit.unwrap() - 3.95).abs() < 0.01);
        let detail = found[0].detail.as_deref().unwrap();
        assert!(
            detail.contains("mass_kg") && detail.contains("0.800 times"),
            "{detail}"
        );
        // Both are in the list before the structure is gone.
        let mass = compared(&body, Some(16.0));
        assert!(!MassLineCheck { body, mass }.is_right());
    }
}
