//! Dataset 164, units of the file.
//!
//! | line | columns | fields |
//! |---|---|---|
//! | 1 | I10 A20 I10 | unit code, description, temperature mode (none of them used: the factors say it) |
//! | 2 | 3 D25.17 | factors of length, force and temperature |
//! | 3 | D25.17 | temperature offset (not used) |
//!
//! A factor is the number of file units in one SI unit: **SI value = file value / factor** (foot
//! and pound-force: 3.28084 and 0.224809; millimetre: 1000). There is no factor of time: it is
//! always in seconds.

use super::fields::{FieldError, Line, finite, numeric_record};
use crate::quantity::Quantity;

/// Factors of a file's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Units {
    /// File units of length in one metre.
    pub length: f64,
    /// File units of force in one newton.
    pub force: f64,
}

impl Units {
    /// SI value = this factor × file value, of forces and motions.
    pub fn to_si(self, quantity: Quantity) -> Option<f64> {
        match quantity {
            Quantity::Force => Some(1.0 / self.force),
            Quantity::Displacement | Quantity::Velocity | Quantity::Acceleration => {
                Some(1.0 / self.length)
            }
            Quantity::Other(_) => None,
        }
    }
}

/// Reads the factors; `first` is the dataset's first line, for messages.
pub(super) fn units(lines: &[Line], first: &Line) -> Result<Units, FieldError> {
    let positive = |field: &[u8]| finite(field).filter(|factor| *factor > 0.0);
    let parse = |fields: &[&[u8]]| {
        Some(Units {
            length: positive(fields[0])?,
            force: positive(fields[1])?,
        })
    };
    let refuse = |line: &Line| {
        FieldError::line(
            line,
            "factors of dataset 164",
            "positive factors of length, force and temperature",
        )
    };
    match lines {
        [_, factors, ..] => {
            numeric_record(&factors.bytes, &[25, 25, 25], parse).ok_or_else(|| refuse(factors))
        }
        _ => Err(refuse(lines.first().unwrap_or(first))),
    }
}
