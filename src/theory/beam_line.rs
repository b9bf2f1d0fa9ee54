//! The geometry of one beam: positions of its nodes, their free coordinates, and points between
//! them.
//!
//! Nothing here has mass or stiffness.

use crate::linalg::Vector3;

use super::description::{BeamDescription, End};
use super::rigid::unit_direction;
use super::{Coordinate, Motion, TheoryError, hermite};

/// Maximum number of elements of a model: dense matrices of more coordinates exceed the memory of a
/// desktop computer.
const MAX_ELEMENTS: usize = 2000;

/// Checks the elements of a beam, or of all beams of a model.
pub(super) fn check_element_count(part: &str, elements: usize) -> Result<(), TheoryError> {
    if elements <= MAX_ELEMENTS {
        return Ok(());
    }
    Err(TheoryError::PropertyOutOfRange {
        part: part.to_owned(),
        property: "elements",
        got: elements as f64,
        expected: "at most 2000: matrices are dense, and 40 elements give four modes to 1e-5",
    })
}

/// How far beyond an end a point may lie and still be at the end, as a share of the length:
/// rounding of coordinates.
const END_TOLERANCE: f64 = 1e-9;
/// Largest cosine between deflection and axis that still counts as a right angle: three written
/// decimals of a direction.
const ACROSS_TOLERANCE: f64 = 1e-3;

/// The geometry of one beam and the model columns of its nodes' (w, theta); `None` where it is
/// held.
#[derive(Clone, Debug)]
pub(super) struct BeamLine {
    name: String,
    origin: Vector3,
    tangent: Vector3,
    deflection: Vector3,
    pub length_m: f64,
    pub elements: usize,
    columns: Vec<Option<usize>>,
}

/// A point on a beam: the columns of its element, and its deflection and rotation by them.
#[derive(Clone, Debug)]
pub(super) struct BeamPoint {
    pub columns: [Option<usize>; 4],
    pub deflection: [f64; 4],
    pub rotation: [f64; 4],
}

/// How a sensor or hit lies to the beam on which it sits.
#[derive(Clone, Debug, PartialEq)]
pub struct BeamPlacement {
    /// The beam.
    pub beam: String,
    /// Distance from its axis, m.
    pub offset_m: f64,
    /// Length of the beam, m.
    pub length_m: f64,
    /// Direction in which it bends.
    pub deflection: [f64; 3],
    /// Cosine between the direction of the sensor and that.
    pub cosine: f64,
}

impl BeamLine {
    /// Checks the geometry of a beam and appends its free coordinates to the model's.
    pub fn new(beam: &BeamDescription, all: &mut Vec<Coordinate>) -> Result<Self, TheoryError> {
        let label = beam.label();
        let out_of_range = |property, got, expected| TheoryError::PropertyOutOfRange {
            part: label.clone(),
            property,
            got,
            expected,
        };
        let (origin, end) = (Vector3::from(beam.from_m), Vector3::from(beam.to_m));
        let length_m = (end - origin).norm();
        if !(length_m.is_finite() && length_m > 0.0) {
            return Err(out_of_range(
                "length in m",
                length_m,
                "a finite number above 0",
            ));
        }
        if beam.elements == 0 {
            return Err(out_of_range("elements", 0.0, "1 or more"));
        }
        check_element_count(&label, beam.elements)?;
        let tangent = (end - origin) / length_m;
        let given = unit_direction(&label, beam.deflection)?;
        let cosine = given.dot(&tangent);
        if cosine.abs() > ACROSS_TOLERANCE {
            return Err(TheoryError::DeflectionNotAcross {
                beam: beam.name.clone(),
                got_deg: cosine.acos().to_degrees(),
            });
        }
        let mut line = Self {
            name: beam.name.clone(),
            origin,
            tangent,
            deflection: (given - tangent * cosine).normalize(),
            length_m,
            elements: beam.elements,
            columns: Vec::new(),
        };
        for node in 0..=beam.elements {
            line.add_node(node, line.end_at(node, beam), all);
        }
        Ok(line)
    }

    /// Cosine between a direction and the deflection.
    pub fn cosine(&self, used_by: &str, direction: [f64; 3]) -> Result<f64, TheoryError> {
        Ok(unit_direction(used_by, direction)?.dot(&self.deflection))
    }

    pub fn is_named(&self, name: &str) -> bool {
        self.name == name
    }

    /// How a point and a direction lie to the beam; `None` for a direction of no length.
    pub fn placement(&self, at_m: [f64; 3], direction: [f64; 3]) -> Option<BeamPlacement> {
        let from_origin = Vector3::from(at_m) - self.origin;
        let across = from_origin - self.tangent * from_origin.dot(&self.tangent);
        Some(BeamPlacement {
            beam: self.name.clone(),
            offset_m: across.norm(),
            length_m: self.length_m,
            deflection: self.deflection.into(),
            cosine: self.cosine("sensor", direction).ok()?,
        })
    }

    fn end_at(&self, node: usize, beam: &BeamDescription) -> End {
        if node == 0 {
            beam.start
        } else if node == self.elements {
            beam.end
        } else {
            End::Free
        }
    }

    /// Coordinates `NAME.wN` and `NAME.thetaN` of a node, nodes numbered from 0, as far as its end
    /// lets them move.
    fn add_node(&mut self, node: usize, end: End, all: &mut Vec<Coordinate>) {
        let x_m = self.length_m * node as f64 / self.elements as f64;
        let at_m = (self.origin + self.tangent * x_m).into();
        let motions = [
            ("w", Motion::Translation, self.deflection, end == End::Free),
            (
                "theta",
                Motion::Rotation,
                self.tangent.cross(&self.deflection),
                end != End::Clamped,
            ),
        ];
        for (letter, motion, axis, moves) in motions {
            self.columns.push(moves.then_some(all.len()));
            if moves {
                all.push(Coordinate {
                    name: format!("{}.{letter}{node}", self.name),
                    body: self.name.clone(),
                    motion,
                    axis: axis.into(),
                    at_m,
                });
            }
        }
    }

    pub fn element_columns(&self, element: usize) -> [Option<usize>; 4] {
        std::array::from_fn(|i| self.columns[2 * element + i])
    }

    pub fn point(&self, used_by: &str, at_m: [f64; 3]) -> Result<BeamPoint, TheoryError> {
        let got_m = (Vector3::from(at_m) - self.origin).dot(&self.tangent);
        let slack_m = END_TOLERANCE * self.length_m;
        if !(got_m >= -slack_m && got_m <= self.length_m + slack_m) {
            return Err(TheoryError::PointOutside {
                used_by: used_by.to_owned(),
                body: self.name.clone(),
                got_m,
                length_m: self.length_m,
            });
        }
        let h = self.length_m / self.elements as f64;
        let position = (got_m / h).clamp(0.0, self.elements as f64);
        let element = (position as usize).min(self.elements - 1);
        let xi = position - element as f64;
        Ok(BeamPoint {
            columns: self.element_columns(element),
            deflection: hermite::deflection(xi, h),
            rotation: hermite::slope(xi, h),
        })
    }
}

pub(super) fn find_line<'a>(
    lines: &'a [BeamLine],
    used_by: &str,
    name: &str,
) -> Result<&'a BeamLine, TheoryError> {
    lines.iter().find(|line| line.name == name).ok_or_else(|| {
        let known = lines.iter().map(|line| line.name.clone());
        TheoryError::unknown_body(used_by, name, known.collect())
    })
}

pub(super) fn find_point(
    lines: &[BeamLine],
    used_by: &str,
    beam: &str,
    at_m: [f64; 3],
) -> Result<BeamPoint, TheoryError> {
    find_line(lines, used_by, beam)?.point(used_by, at_m)
}
