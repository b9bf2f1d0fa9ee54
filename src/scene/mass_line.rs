//! Rigid bodies of a test, with the positions of its points from files and sensors of the scene:
//! its mass line, and the bodies of its model in the lowest modes.

use std::collections::BTreeMap;

use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::rigid_body::{
    MIN_FALL, MassComparison, PlacedSensor, Repair, RigidBody, SensorFault, neighbouring_peaks,
    rigid_body, rigid_in_modes,
};
use crate::frf::{
    BeforeYouLeave, CheckItem, FrfSet, HammerTestResult, MassLineCheck, SupportCheck,
    before_you_leave,
};
use crate::geometry::{Geometry, Sensor, Target, unit};
use crate::modal::ModalModel;
use crate::printable::counted;
use crate::theory::Support;

use super::supports::MAX_RIGID_BODY_OVER_ELASTIC;
use super::test_state::TestState;

/// The rigid-body behaviour of a set between suspension and first elastic mode.
///
/// `None` where no points are placed, or no band has a mass line.
pub fn test_rigid_body(set: &FrfSet, geometry: &Geometry, sensors: &[Sensor]) -> Option<RigidBody> {
    let set = &set.motions();
    rigid_body(set, &placed(set, geometry, sensors))
}

/// Findings on the mass line of a set: its mass, a stated mass that differs, and the sensors that
/// do not move as a rigid body.
pub fn mass_line_findings(set: &FrfSet, body: &RigidBody, state: &TestState) -> Vec<Finding> {
    findings(&set.motions(), body, state.mass_kg)
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
            response: Some(fault.dof.clone()),
            reference: None,
        };
        let is_same =
            |known: &Finding| known.code == Code::SensorNotRigid && known.location == location;
        let detail = format!(
            "body {body}, its {} lowest modes up to {:.2} Hz: {}",
            moving.modes, moving.highest_hz, fault.repair
        );
        let is_known = modes.findings.iter().any(is_same);
        (!is_known).then(|| fault_finding(&fault, location, &detail))
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
/// `body` is that of the FRFs, and `state` that of the test as a scene states it.
pub fn leaving_list(
    result: &HammerTestResult,
    body: Option<&RigidBody>,
    state: &TestState,
) -> BeforeYouLeave {
    let mut list = before_you_leave(result);
    let check = MassLineCheck {
        body: body.cloned(),
        stated_kg: state.mass_kg,
    };
    let is_suspended = state.support == Some(Support::Suspended);
    if body.is_some() || is_suspended || state.mass_kg.is_some() {
        list.items.push(CheckItem::MassLine(Box::new(check)));
    }
    let set = &result.estimated.set.motions();
    let support = state
        .support
        .map(|support| support_check(set, support, state));
    list.items.extend(support.map(CheckItem::Support));
    list
}

fn support_check(set: &FrfSet, support: Support, state: &TestState) -> SupportCheck {
    let limit = (support == Support::Suspended).then_some(MAX_RIGID_BODY_OVER_ELASTIC);
    let stated_hz = state.highest_rigid_body_hz;
    let peaks = match support {
        Support::Fixed => None,
        Support::Suspended | Support::Mounted => Some(neighbouring_peaks(set, stated_hz)),
    };
    SupportCheck {
        support: support.name(),
        rigid_body_hz: peaks.and(stated_hz),
        peak_below_hz: peaks.and_then(|peaks| peaks.below_hz),
        elastic_hz: peaks.and_then(|peaks| peaks.above_hz),
        limit,
    }
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
        findings.push(fault_finding(fault, location, &fault.repair.to_string()));
    }
    if !body.is_rigid() {
        let finding = Finding::new(Severity::Warning, Code::SensorsNotRigid, Location::Whole);
        let finding = finding
            .value(body.misfit.value, "")
            .limit(body.misfit.limit);
        findings.push(finding.detail(format!(
            "{}, from {:.1} to {:.1} Hz",
            counted(body.sensors, "sensor"),
            body.band.lo_hz,
            body.band.hi_hz
        )));
    }
    let precaution = body.fault.as_ref().map_or_else(String::new, |fault| {
        format!(", {}; the FRFs are unchanged", fault.repair.precaution())
    });
    if let Ok(inertia) = &body.inertia {
        let finding = Finding::new(Severity::Info, Code::MassOfMassLine, Location::Whole);
        let [x, y, z] = inertia.centre_m;
        findings.push(finding.value(inertia.mass_kg, "kg").detail(format!(
            "standard deviation {:.1e} kg, centre of mass at ({x:.4}, {y:.4}, {z:.4}) m, from {:.1} to {:.1} Hz{precaution}",
            inertia.mass_std_kg, body.band.lo_hz, body.band.hi_hz
        )));
        let mass = stated_kg.map(|stated_kg| MassComparison::new(inertia, stated_kg));
        findings.extend(mass.filter(MassComparison::differs).map(|mass| {
            let finding = Finding::new(Severity::Warning, Code::MassDiffers, Location::Whole);
            let finding = finding
                .value(100.0 * mass.difference(), "%")
                .limit(100.0 * mass.limit);
            finding.detail(format!(
                "mass line {:.3} ± {:.3} kg{precaution}; mass_kg of [test.state] {} kg; if the stated mass is right, the FRFs are {:.3} ± {:.3} times what they should be",
                mass.found_kg, mass.std_kg, mass.stated_kg, mass.gain(), mass.gain_std()
            ))
        }));
    }
    findings
}

/// A sensor that does not move with its rigid body, with the fall of the sum of squares by its
/// repair.
fn fault_finding(fault: &SensorFault, location: Location, detail: &str) -> Finding {
    let advice = match fault.repair {
        Repair::Exchanged(..) => "; check whether their cables or names are exchanged",
        _ => "",
    };
    Finding::new(Severity::Warning, Code::SensorNotRigid, location)
        .value(fault.fall, "")
        .limit(MIN_FALL)
        .detail(format!(
            "{detail}; value and limit: fall of the sum of squares{advice}"
        ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::Band;
    use crate::frf::rigid_body::{Inertia, Misfit, NoMass};
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

    fn hung_body() -> RigidBody {
        RigidBody {
            band: Band::new(10.0, 40.0).unwrap(),
            sensors: 12,
            fault: None,
            misfit: Misfit {
                value: 1.0,
                limit: 4.0,
            },
            inertia: Ok(Inertia {
                mass_kg: 20.0,
                mass_std_kg: 0.05,
                centre_m: [0.0; 3],
                centre_std_m: [0.0; 3],
                tensor_kg_m2: [0.0; 6],
            }),
        }
    }

    #[test]
    fn stated_mass_that_differs_is_reported_with_the_gain() {
        let body = hung_body();
        let codes = |stated_kg| -> Vec<Finding> {
            let all = findings(&empty_set(), &body, stated_kg).into_iter();
            all.filter(|finding| finding.code == Code::MassDiffers)
                .collect()
        };
        assert_eq!(codes(None), []);
        assert_eq!(codes(Some(20.5)), []);
        let found = codes(Some(16.0));
        assert_eq!(found[0].value, Some(25.0));
        assert!((found[0].limit.unwrap() - 3.95).abs() < 0.01);
        let detail = found[0].detail.as_deref().unwrap();
        let expected = "if the stated mass is right, the FRFs are 0.800 ± 0.002 times";
        assert!(
            detail.contains("mass_kg") && detail.contains(expected),
            "{detail}"
        );
        // Both are in the list before the structure is gone.
        let check = |stated_kg| MassLineCheck {
            body: Some(body.clone()),
            stated_kg,
        };
        assert!(check(Some(16.0)).is_wrong() && !check(Some(20.5)).is_wrong());
    }

    #[test]
    fn mass_from_a_repaired_sensor_is_reported_with_the_repair() {
        let dof: Dof = "6:+Y".parse().unwrap();
        let body = |repair: Repair| RigidBody {
            fault: Some(SensorFault {
                dof: repair.dof().clone(),
                repair,
                fall: 4e5,
            }),
            ..hung_body()
        };
        let found = findings(&empty_set(), &body(Repair::Sign(dof.clone())), Some(20.0));
        let codes: Vec<Code> = found.iter().map(|finding| finding.code).collect();
        assert_eq!(codes, [Code::SensorNotRigid, Code::MassOfMassLine]);
        assert_eq!((found[0].value, found[0].limit), (Some(4e5), Some(30.0)));
        let detail = |finding: &Finding| finding.detail.clone().unwrap();
        assert!(detail(&found[0]).contains("fall of the sum of squares"));
        let mass = detail(&found[1]);
        assert!(
            mass.ends_with("with 6:+Y repaired; the FRFs are unchanged"),
            "{mass}"
        );
        let exchanged = body(Repair::Exchanged(dof, "7:+Y".parse().unwrap()));
        let found = findings(&empty_set(), &exchanged, None);
        assert!(detail(&found[0]).ends_with("cables or names are exchanged"));
        assert!(detail(&found[1]).contains("with 6:+Y and 7:+Y repaired"));
    }

    #[test]
    fn sensors_that_are_no_rigid_body_are_reported_with_misfit_and_limit() {
        let body = RigidBody {
            misfit: Misfit {
                value: 900.0,
                limit: 4.0,
            },
            inertia: Err(NoMass::SensorsNotRigid),
            ..hung_body()
        };
        let found = findings(&empty_set(), &body, Some(20.0));
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].code, Code::SensorsNotRigid);
        assert_eq!((found[0].value, found[0].limit), (Some(900.0), Some(4.0)));
        let stated_kg = Some(20.0);
        let check = MassLineCheck {
            body: Some(body),
            stated_kg,
        };
        assert!(check.is_wrong() && !check.is_tested());
    }

    fn empty_set() -> FrfSet {
        FrfSet::new(crate::axis::FrequencyAxis {
            start_hz: 0.0,
            step_hz: 1.0,
            len: 2,
        })
    }
}
