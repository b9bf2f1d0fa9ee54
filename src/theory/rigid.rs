//! Rigid bodies on massless springs: displacement of a point with the motion of its body, and the
//! matrices that follow.
//!
//! The velocity of a point p of a body with centre c is `v + w x (p - c)`; a spring stretches by
//! the difference of the velocities of its two ends along its direction. All motions are small, all
//! directions are those of the model's frame.

use std::collections::BTreeSet;

use crate::dof::{Axis, Dof};
use crate::geometry::{self, Sensor, Target};
use crate::linalg::{Vector3, real_matrix};

use super::nearest_name::nearest_name;
use super::{Coordinate, Motion, Spring, SystemMatrices, TheoryError};

/// The bodies of a model and how they may move.
#[derive(Clone, Debug, Default)]
pub(super) struct RigidBodies {
    /// Every body, those that do not move included.
    pub names: Vec<String>,
    /// The coordinates; those of one body stand together.
    pub coordinates: Vec<Coordinate>,
}

/// A point of a body, or of the ground.
#[derive(Clone, Copy, Debug)]
pub(super) struct Attachment<'a> {
    pub body: Option<&'a str>,
    pub at_m: [f64; 3],
}

impl RigidBodies {
    /// Adds a body with its freedoms: the name of each coordinate, its motion, its axis.
    pub fn add(
        &mut self,
        body: String,
        at_m: [f64; 3],
        free: impl IntoIterator<Item = (String, Motion, [f64; 3])>,
    ) {
        let coordinate = |(name, motion, axis)| Coordinate {
            name,
            body: body.clone(),
            motion,
            axis,
            at_m,
        };
        self.coordinates.extend(free.into_iter().map(coordinate));
        self.names.push(body);
    }

    /// Displacement of a point of a body along a direction, per unit of each coordinate.
    pub fn point_row(
        &self,
        used_by: &str,
        body: &str,
        at_m: [f64; 3],
        direction: [f64; 3],
    ) -> Result<Vec<f64>, TheoryError> {
        self.check_body(used_by, body)?;
        self.check_radius(used_by, body)?;
        let direction = unit_direction(used_by, direction)?;
        let reading = |coordinate: &Coordinate| {
            let axis = Vector3::from(coordinate.axis);
            let moved = match coordinate.motion {
                Motion::Translation | Motion::Arc => axis,
                Motion::Rotation => {
                    axis.cross(&(Vector3::from(at_m) - Vector3::from(coordinate.at_m)))
                }
            };
            moved.dot(&direction)
        };
        Ok(self.row(body, reading))
    }

    /// Rotation of a body about a direction, per unit of each coordinate.
    pub fn rotation_row(
        &self,
        used_by: &str,
        body: &str,
        direction: [f64; 3],
    ) -> Result<Vec<f64>, TheoryError> {
        self.check_body(used_by, body)?;
        self.check_radius(used_by, body)?;
        let direction = unit_direction(used_by, direction)?;
        let reading = |coordinate: &Coordinate| match coordinate.motion {
            Motion::Translation | Motion::Arc => 0.0,
            Motion::Rotation => Vector3::from(coordinate.axis).dot(&direction),
        };
        Ok(self.row(body, reading))
    }

    /// Stretch of a spring between two points along a direction, per unit of each coordinate.
    pub fn stretch_row(
        &self,
        used_by: &str,
        (from, to): (Attachment<'_>, Attachment<'_>),
        direction: [f64; 3],
    ) -> Result<Vec<f64>, TheoryError> {
        self.difference((from, to), |end| match end.body {
            Some(body) => self.point_row(used_by, body, end.at_m, direction).map(Some),
            None => Ok(None),
        })
    }

    /// Twist of a spring between two bodies about a direction, per unit of each coordinate.
    pub fn twist_row(
        &self,
        used_by: &str,
        (from, to): (Attachment<'_>, Attachment<'_>),
        direction: [f64; 3],
    ) -> Result<Vec<f64>, TheoryError> {
        self.difference((from, to), |end| match end.body {
            Some(body) => self.rotation_row(used_by, body, direction).map(Some),
            None => Ok(None),
        })
    }

    /// The row of a sensor or a hit.
    pub fn observation_row(&self, target: &Target) -> Result<Vec<f64>, TheoryError> {
        match target {
            Target::BodyPoint {
                body,
                at_m,
                direction,
            } => self.point_row("sensor", body, *at_m, *direction),
            Target::Coordinate(name) => {
                let mut row = vec![0.0; self.coordinates.len()];
                row[coordinate_index(&self.coordinates, name)?] = 1.0;
                Ok(row)
            }
        }
    }

    /// `M = diag(inertia)`, `K = sum k b b^T` over the springs.
    pub fn matrices(&self, inertia: &[f64], springs: Vec<Spring>) -> SystemMatrices {
        let n = self.coordinates.len();
        let mut stiffness = real_matrix(n, n, |_, _| 0.0);
        for spring in &springs {
            let moved: Vec<usize> = (0..n).filter(|&i| spring.row[i] != 0.0).collect();
            for (&i, &j) in moved.iter().flat_map(|i| moved.iter().map(move |j| (i, j))) {
                stiffness[(i, j)] += spring.stiffness * spring.row[i] * spring.row[j];
            }
        }
        SystemMatrices {
            mass: real_matrix(n, n, |i, j| if i == j { inertia[i] } else { 0.0 }),
            damping: None,
            stiffness,
            coordinates: self.coordinates.clone(),
            springs,
        }
    }

    fn row(&self, body: &str, reading: impl Fn(&Coordinate) -> f64) -> Vec<f64> {
        let of_body = |coordinate: &Coordinate| {
            if coordinate.body == body {
                reading(coordinate)
            } else {
                0.0
            }
        };
        self.coordinates.iter().map(of_body).collect()
    }

    /// Row of the second end minus that of the first.
    fn difference(
        &self,
        (from, to): (Attachment<'_>, Attachment<'_>),
        row: impl Fn(Attachment<'_>) -> Result<Option<Vec<f64>>, TheoryError>,
    ) -> Result<Vec<f64>, TheoryError> {
        let mut difference = vec![0.0; self.coordinates.len()];
        for (end, sign) in [(from, -1.0), (to, 1.0)] {
            for (total, part) in difference.iter_mut().zip(row(end)?.unwrap_or_default()) {
                *total += sign * part;
            }
        }
        Ok(difference)
    }

    /// A coordinate that is a radius times an angle says nothing of a point of its body, nor of its
    /// angle.
    fn check_radius(&self, used_by: &str, body: &str) -> Result<(), TheoryError> {
        let mut coordinates_of_body = self.coordinates.iter().filter(|c| c.body == body);
        match coordinates_of_body.find(|c| c.motion == Motion::Arc) {
            None => Ok(()),
            Some(coordinate) => Err(TheoryError::NoRadius {
                used_by: used_by.to_owned(),
                body: body.to_owned(),
                coordinate: coordinate.name.clone(),
            }),
        }
    }

    /// Checks that the body exists.
    pub fn check_body(&self, used_by: &str, body: &str) -> Result<(), TheoryError> {
        if self.names.iter().any(|name| name == body) {
            return Ok(());
        }
        Err(TheoryError::unknown_body(used_by, body, self.names.clone()))
    }
}

/// The unit vector of a stated direction.
pub(super) fn unit_direction(used_by: &str, got: [f64; 3]) -> Result<Vector3, TheoryError> {
    let unit = geometry::unit(got).filter(|unit| unit.iter().all(|c| c.is_finite()));
    unit.ok_or_else(|| TheoryError::ZeroDirection {
        used_by: used_by.to_owned(),
        got,
    })
}

/// The index of a coordinate.
pub(super) fn coordinate_index(
    coordinates: &[Coordinate],
    name: &str,
) -> Result<usize, TheoryError> {
    coordinates
        .iter()
        .position(|c| c.name == name)
        .ok_or_else(|| TheoryError::UnknownCoordinate {
            got: name.to_owned(),
            nearest: nearest_name(name, coordinates.iter().map(|c| c.name.as_str())),
            count: coordinates.len(),
        })
}

/// A sensor on every coordinate, named after its body and axis (`output:+Y`); none for a model
/// whose coordinates these do not name, such as the nodes of a beam. A displacement along a circle
/// is a scalar (`sun:+S`).
pub fn coordinate_sensors(coordinates: &[Coordinate]) -> Vec<Sensor> {
    let sensor = |coordinate: &Coordinate| {
        Some(Sensor {
            dof: Dof::new(&coordinate.body, axis(coordinate)?, false).ok()?,
            target: Target::Coordinate(coordinate.name.clone()),
        })
    };
    let sensors: Option<Vec<Sensor>> = coordinates.iter().map(sensor).collect();
    let distinct = |sensors: &Vec<Sensor>| {
        let dofs: BTreeSet<&Dof> = sensors.iter().map(|sensor| &sensor.dof).collect();
        dofs.len() == sensors.len()
    };
    sensors.filter(distinct).unwrap_or_default()
}

/// The positive axis along or about which a coordinate moves.
fn axis(coordinate: &Coordinate) -> Option<Axis> {
    let all = match coordinate.motion {
        Motion::Arc => return Some(Axis::S),
        Motion::Translation => [Axis::X, Axis::Y, Axis::Z],
        Motion::Rotation => [Axis::RX, Axis::RY, Axis::RZ],
    };
    all.into_iter()
        .find(|axis| axis.unit_vector() == Some(coordinate.axis))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disc() -> RigidBodies {
        let coordinate = |name: &str, motion, axis| Coordinate {
            name: name.to_owned(),
            body: "disc".to_owned(),
            motion,
            axis,
            at_m: [1.0, 2.0, 0.0],
        };
        RigidBodies {
            names: vec!["disc".to_owned(), "housing".to_owned()],
            coordinates: vec![
                coordinate("x", Motion::Translation, [1.0, 0.0, 0.0]),
                coordinate("y", Motion::Translation, [0.0, 1.0, 0.0]),
                coordinate("rz", Motion::Rotation, [0.0, 0.0, 1.0]),
            ],
        }
    }

    #[test]
    fn a_point_moves_with_its_body_and_turns_about_its_centre() {
        // 3 m along +x of the centre, a positive turn about z moves the point along +y.
        let row = disc()
            .point_row("sensor", "disc", [4.0, 2.0, 5.0], [0.0, 2.0, 0.0])
            .unwrap();
        assert_eq!(row, [0.0, 1.0, 3.0]);
        let row = disc()
            .point_row("sensor", "disc", [1.0, 2.5, 0.0], [1.0, 0.0, 0.0])
            .unwrap();
        assert_eq!(row, [1.0, 0.0, -0.5]);
        assert_eq!(
            disc()
                .rotation_row("sensor", "disc", [0.0, 0.0, -4.0])
                .unwrap(),
            [0.0, 0.0, -1.0]
        );
    }

    #[test]
    fn a_spring_stretches_by_the_difference_of_its_ends() {
        let end = |body, at_m| Attachment { body, at_m };
        let (ground, rim) = (end(None, [0.0; 3]), end(Some("disc"), [1.0, 0.0, 0.0]));
        let housing = end(Some("housing"), [9.0, 9.0, 0.0]);
        let x = [1.0, 0.0, 0.0];
        let row = |ends| disc().stretch_row("spring", ends, x).unwrap();
        assert_eq!(row((ground, rim)), [1.0, 0.0, 2.0]);
        assert_eq!(row((rim, ground)), [-1.0, 0.0, -2.0]);
        assert_eq!(row((rim, housing)), [-1.0, 0.0, -2.0]);
        let k = disc().matrices(
            &[2.0, 2.0, 3.0],
            vec![Spring {
                name: "support".to_owned(),
                row: row((ground, rim)),
                stiffness: 10.0,
            }],
        );
        assert_eq!(k.stiffness[(0, 2)].to_bits(), 20f64.to_bits());
        assert_eq!(k.stiffness[(2, 2)].to_bits(), 40f64.to_bits());
        assert_eq!(k.mass[(2, 2)].to_bits(), 3f64.to_bits());
    }

    #[test]
    fn an_unknown_body_and_a_zero_direction_are_named() {
        let error = disc().point_row("sensor", "disk", [0.0; 3], [1.0, 0.0, 0.0]);
        assert!(
            matches!(error, Err(TheoryError::UnknownBody { nearest: Some(n), .. }) if n == "disc")
        );
        let error = disc().point_row("sensor", "disc", [0.0; 3], [0.0; 3]);
        assert!(matches!(error, Err(TheoryError::ZeroDirection { .. })));
    }
}
