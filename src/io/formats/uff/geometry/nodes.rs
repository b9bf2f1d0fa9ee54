//! A node as datasets 15, 781 and 2411 give it, before units and coordinate systems.

use crate::io::formats::uff::fields::{FieldError, Line, Position, finite, half_unit};

/// A node in file units, in the coordinate system of its definition.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::io::formats::uff) struct RawNode {
    pub at: Position,
    pub label: i64,
    /// Label of the coordinate system of the position, 0 for the global frame.
    pub definition: i64,
    /// Label of the coordinate system of displacements, 0 for the global frame.
    pub displacement: i64,
    pub coordinates: [f64; 3],
    /// Half a unit of the last printed digit of each coordinate.
    pub half_units: [f64; 3],
}

impl RawNode {
    /// Checks the label; `systems` are those of definition and displacement, `fields` the printed
    /// coordinates.
    pub fn new(
        line: &Line,
        label: i64,
        [definition, displacement]: [i64; 2],
        fields: Printed,
    ) -> Result<Self, FieldError> {
        if label <= 0 {
            return Err(FieldError::line(line, "node label", "a positive number"));
        }
        Ok(Self {
            at: line.at,
            label,
            definition,
            displacement,
            coordinates: fields.map(|field| field.0),
            half_units: fields.map(|field| field.1),
        })
    }

    /// Whether the coordinates of another node of this label may be the same numbers, printed with
    /// fewer or more digits.
    pub fn has_coordinates_of(&self, other: &Self) -> bool {
        (0..3).all(|i| {
            let (a, b) = (self.coordinates[i], other.coordinates[i]);
            let coarser = self.half_units[i].max(other.half_units[i]);
            // The rounding of the last digit itself must not lose a value on its edge.
            (a - b).abs() <= coarser * (1.0 + 1e-6)
        })
    }

    /// Whether the coordinates were printed with more digits than those of another.
    pub fn is_finer(&self, other: &Self) -> bool {
        let all = |node: &Self| node.half_units.iter().sum::<f64>();
        all(self) < all(other)
    }
}

/// Coordinates, each with half a unit of its last printed digit.
pub(super) type Printed = [(f64, f64); 3];

/// Reads the three fields of coordinates.
pub(in crate::io::formats::uff) fn printed(fields: &[&[u8]]) -> Option<Printed> {
    let number = |field: &[u8]| Some((finite(field)?, half_unit(field).unwrap_or(0.0)));
    Some([number(fields[0])?, number(fields[1])?, number(fields[2])?])
}
