//! Findings on sensors and hits of a model: those at which it does not move, those off the axis of
//! their beam, and those of one position and direction.

use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::geometry::{Geometry, Node, Sensor, Target, unit};
use crate::linalg::Vector3;
use crate::theory::{BeamPlacement, TheoreticalModel, TheoryError};

/// Maximum distance of a sensor from the axis of its beam over the length of the beam. Larger, at
/// 0.5: a sensor of another part passes. Smaller, at 0.02: sensors on the surface of a beam of
/// usual depth are reported. Test `sensors_off_a_beam_and_across_its_bending_are_named_with_keys`.
const MAX_OFFSET_OVER_LENGTH: f64 = 0.1;
/// Maximum cosine of a direction to the one in which a beam deflects, below which it counts as
/// across: three written decimals of a direction.
const MAX_COSINE_ACROSS: f64 = 1e-3;
/// Minimum cosine of two directions that count as one, for the same reason.
const MIN_COSINE_OF_ONE_DIRECTION: f64 = 1.0 - 1e-6;
/// Maximum distance of two sensors at one position, m: written to a thousandth of a millimetre.
const MAX_DISTANCE_OF_ONE_POSITION_M: f64 = 1e-6;
/// Maximum number of sensors that a detail names.
const MAX_NAMED_SENSORS: usize = 8;

/// The sensors at which the model does not move, whatever its modes.
///
/// # Errors
/// The error of a sensor that has no place in the model.
pub(super) fn unmoved_sensors<'s>(
    model: &dyn TheoreticalModel,
    values: &[f64],
    sensors: &'s [Sensor],
) -> Result<Vec<&'s Sensor>, TheoryError> {
    let mut unmoved = Vec::new();
    for sensor in sensors {
        let row = model.observation_row(values, &sensor.target)?;
        if is_across(model, sensor) || row.iter().all(|value| value.abs() <= 0.0) {
            unmoved.push(sensor);
        }
    }
    Ok(unmoved)
}

fn is_across(model: &dyn TheoreticalModel, sensor: &Sensor) -> bool {
    let placement = model.beam_placement(&sensor.target);
    placement.is_some_and(|beam| beam.cosine.abs() <= MAX_COSINE_ACROSS)
}

/// The findings on the sensors of a model.
///
/// # Errors
/// As [`unmoved_sensors`].
pub(super) fn sensor_findings(
    model: &dyn TheoreticalModel,
    values: &[f64],
    sensors: &[Sensor],
) -> Result<Vec<Finding>, TheoryError> {
    let unmoved = unmoved_sensors(model, values, sensors)?.into_iter();
    let mut findings: Vec<Finding> = unmoved
        .map(|sensor| unmoved_finding(model, sensor))
        .collect();
    findings.extend(sensors.iter().filter_map(|sensor| off_axis(model, sensor)));
    findings.extend(shared_positions(sensors));
    Ok(findings)
}

fn at_sensor(code: Code, dof: &Dof) -> Finding {
    let location = Location::Function {
        response: Some(dof.clone()),
        reference: None,
    };
    Finding::new(Severity::Warning, code, location)
}

fn unmoved_finding(model: &dyn TheoreticalModel, sensor: &Sensor) -> Finding {
    let finding = at_sensor(Code::SensorUnmoved, &sensor.dof);
    let beam = model.beam_placement(&sensor.target);
    match (&sensor.target, beam) {
        (Target::BodyPoint { direction, .. }, Some(beam)) if is_across(model, sensor) => finding
            .detail(format!(
                "direction {}, `deflection` of beam {:?} {}",
                vector_text(*direction),
                beam.beam,
                vector_text(beam.deflection)
            )),
        (Target::BodyPoint { body, .. }, _) => {
            finding.detail(format!("body {body:?} is held there"))
        }
        (Target::Coordinate(_), _) => finding,
    }
}

/// A sensor beside its beam.
fn off_axis(model: &dyn TheoreticalModel, sensor: &Sensor) -> Option<Finding> {
    let BeamPlacement {
        beam,
        offset_m,
        length_m,
        ..
    } = model.beam_placement(&sensor.target)?;
    let limit = MAX_OFFSET_OVER_LENGTH * length_m;
    let finding = at_sensor(Code::SensorOffBeam, &sensor.dof);
    let keys = format!("`at_m` of the sensor, `from_m` and `to_m` of beam {beam:?}");
    (offset_m > limit).then(|| finding.value(offset_m, "m").limit(limit).detail(keys))
}

fn vector_text(vector: [f64; 3]) -> String {
    let [x, y, z] = vector.map(|value| (value * 1e3).round() / 1e3 + 0.0);
    format!("[{x}, {y}, {z}]")
}

/// A finding for each position and direction that several sensors have.
fn shared_positions(sensors: &[Sensor]) -> Vec<Finding> {
    let mut groups: Vec<Vec<&Sensor>> = Vec::new();
    for sensor in sensors {
        let group = groups.iter_mut();
        match group
            .into_iter()
            .find(|group| is_one_position(group[0], sensor))
        {
            Some(group) => group.push(sensor),
            None => groups.push(vec![sensor]),
        }
    }
    let of_group = |group: Vec<&Sensor>| {
        let names: Vec<String> = group.iter().map(|sensor| sensor.dof.to_string()).collect();
        let place = match &group[0].target {
            Target::BodyPoint { body, at_m, .. } => {
                format!("body {body:?}, at_m = {}", vector_text(*at_m))
            }
            Target::Coordinate(name) => format!("coordinate {name:?}"),
        };
        let detail = format!("{}: {place}", named(&names));
        let finding = Finding::new(
            Severity::Warning,
            Code::SensorsAtOnePosition,
            Location::Whole,
        );
        finding.value(names.len() as f64, "").detail(detail)
    };
    let groups = groups.into_iter().filter(|group| group.len() > 1);
    groups.map(of_group).collect()
}

/// A finding for each position that several stated points have.
pub(super) fn shared_points(points: &Geometry) -> Vec<Finding> {
    let mut groups: Vec<Vec<&Node>> = Vec::new();
    for node in &points.nodes {
        let is_one = |group: &&mut Vec<&Node>| {
            (group[0].at_m - node.at_m).norm() <= MAX_DISTANCE_OF_ONE_POSITION_M
        };
        match groups.iter_mut().find(is_one) {
            Some(group) => group.push(node),
            None => groups.push(vec![node]),
        }
    }
    let of_group = |group: Vec<&Node>| {
        let names: Vec<String> = group.iter().map(|node| node.point.clone()).collect();
        let place = vector_text(group[0].at_m.into());
        let detail = format!("points {}: at_m = {place}", named(&names));
        let finding = Finding::new(
            Severity::Warning,
            Code::PointsAtOnePosition,
            Location::Whole,
        );
        finding.value(names.len() as f64, "").detail(detail)
    };
    let groups = groups.into_iter().filter(|group| group.len() > 1);
    groups.map(of_group).collect()
}

/// The names, of many the first.
pub(super) fn named(names: &[String]) -> String {
    let further = names.len().saturating_sub(MAX_NAMED_SENSORS);
    let first = names.iter().take(MAX_NAMED_SENSORS).cloned();
    let further = (further > 0).then(|| format!("{further} more"));
    first.chain(further).collect::<Vec<_>>().join(", ")
}

fn is_one_position(a: &Sensor, b: &Sensor) -> bool {
    match (&a.target, &b.target) {
        (Target::Coordinate(a), Target::Coordinate(b)) => a == b,
        (
            Target::BodyPoint {
                body,
                at_m,
                direction,
            },
            Target::BodyPoint {
                body: other_body,
                at_m: other_at_m,
                direction: other_direction,
            },
        ) => {
            let distance = (Vector3::from(*at_m) - Vector3::from(*other_at_m)).norm();
            let directions = unit(*direction).zip(unit(*other_direction));
            let cosine = directions.map_or(0.0, |(a, b)| a.dot(&b));
            body == other_body
                && distance <= MAX_DISTANCE_OF_ONE_POSITION_M
                && cosine >= MIN_COSINE_OF_ONE_DIRECTION
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::ModelDraft;

    fn sensor(number: usize, at_m: [f64; 3], direction: [f64; 3]) -> Sensor {
        Sensor {
            dof: format!("{number}:+Z").parse().unwrap(),
            target: Target::BodyPoint {
                body: "beam".to_owned(),
                at_m,
                direction,
            },
        }
    }

    fn found(sensors: &[Sensor]) -> Vec<Finding> {
        let beam = ModelDraft::at(Path::new("beam")).unwrap().load().unwrap();
        sensor_findings(beam.model.as_ref(), &beam.values, sensors).unwrap()
    }

    #[test]
    fn sensors_off_a_beam_and_across_its_bending_are_named_with_keys() {
        let (x, z) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        assert_eq!(
            found(&[
                sensor(1, [0.0, 0.015, 0.0], z),
                sensor(2, [1.0, 0.0, 0.0], [0.0, 0.7, 0.7])
            ]),
            []
        );
        let all = found(&[sensor(1, [0.5, 0.0, 0.0], x), sensor(2, [0.5, 1.2, 0.0], z)]);
        let codes: Vec<Code> = all.iter().map(|finding| finding.code).collect();
        assert_eq!(codes, [Code::SensorUnmoved, Code::SensorOffBeam]);
        let detail = |finding: &Finding| finding.detail.clone().unwrap();
        assert!(detail(&all[0]).contains("direction [1, 0, 0], `deflection`"));
        assert!(detail(&all[1]).contains("`from_m` and `to_m`"));
        assert_eq!((all[1].value, all[1].limit), (Some(1.2), Some(0.1)));
    }

    #[test]
    fn points_of_one_position_are_named_together() {
        let node = |name: &str, x: f64| Node::new(name, Vector3::new(x, 0.0, 0.0));
        let points = Geometry {
            nodes: vec![node("1", 0.0), node("2", 0.1), node("3", 0.0)],
            ..Geometry::default()
        };
        let all = shared_points(&points);
        assert_eq!(all.len(), 1);
        assert_eq!(
            all[0].detail.as_deref(),
            Some("points 1, 3: at_m = [0, 0, 0]")
        );
    }

    #[test]
    fn sensors_of_one_position_and_direction_are_named_together() {
        let z = [0.0, 0.0, 1.0];
        let copied: Vec<Sensor> = (1..=11).map(|n| sensor(n, [0.1, 0.0, 0.0], z)).collect();
        let all = found(&copied);
        assert_eq!(all.len(), 1);
        assert_eq!(all[0].code, Code::SensorsAtOnePosition);
        assert_eq!(all[0].value, Some(11.0));
        let detail = all[0].detail.clone().unwrap();
        assert!(detail.starts_with("1:+Z, 2:+Z, 3:+Z"), "{detail}");
        assert!(detail.contains("3 more: body \"beam\""), "{detail}");
        let apart: Vec<Sensor> = (1..=9)
            .map(|n| sensor(n, [0.1 * f64::from(n as u8), 0.0, 0.0], z))
            .collect();
        assert_eq!(found(&apart), []);
    }
}
