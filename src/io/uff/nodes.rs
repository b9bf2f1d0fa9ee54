//! A node as datasets 15 and 2411 give it, before units.

use super::fields::{FieldError, Line, Position};
use crate::linalg::Vector3;

/// A node in file units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RawNode {
    pub at: Position,
    pub label: i64,
    pub coordinates: [f64; 3],
}

impl RawNode {
    /// Checks label and definition coordinate system. 0 and 1 are the global system; positions in another one would need
    /// datasets 18 or 2420, which are not read, and would be wrong without them.
    pub fn new(
        line: &Line,
        label: i64,
        system: i64,
        coordinates: [f64; 3],
    ) -> Result<Self, FieldError> {
        if label <= 0 {
            return Err(FieldError::line(line, "node label", "a positive number"));
        }
        if !matches!(system, 0 | 1) {
            return Err(FieldError::line(
                line,
                "coordinate system of a node",
                "0 or 1 (global); local coordinate systems are not read",
            ));
        }
        Ok(Self {
            at: line.at,
            label,
            coordinates,
        })
    }

    /// Position in metres, where `length` file units are one metre.
    pub fn at_m(&self, length: f64) -> Vector3 {
        Vector3::from(self.coordinates) / length
    }
}
