//! Dataset 18, coordinate systems by three points each.
//!
//! | line | columns | fields |
//! |---|---|---|
//! | 1 | 5 I10 | label, type (0 Cartesian, 1 cylindrical, 2 spherical), label of the reference system, colour, method (1) |
//! | 2 | A40 | name |
//! | 3, 4 | 6 E13.5 | origin, a point on the +x axis, a point on the +xz plane, each in coordinates of the reference system |

use super::systems::{Placement, RawSystem, kind};
use crate::io::formats::uff::fields::records::Records;
use crate::io::formats::uff::fields::{FieldError, Line, text_or_none};

/// Reads the systems; `first` is the dataset's first line, for messages.
pub(in crate::io::formats::uff) fn systems(
    lines: &[Line],
    first: &Line,
) -> Result<Vec<RawSystem>, FieldError> {
    let mut records = Records::new(lines, first);
    let mut systems = Vec::new();
    while records.peek().is_some() {
        systems.push(system(&mut records)?);
    }
    Ok(systems)
}

fn system(records: &mut Records<'_>) -> Result<RawSystem, FieldError> {
    let (head, fields) = records.integer_row("coordinate system of dataset 18")?;
    let field = |i: usize| fields.get(i).copied().unwrap_or(0);
    let refuse =
        |expected: &str| FieldError::line(head, "coordinate system of dataset 18", expected);
    if !matches!(field(4), 0 | 1) {
        return Err(refuse("method 1: origin, +x axis, +xz plane"));
    }
    let kind = kind(field(1)).ok_or_else(|| refuse("type 0, 1 or 2"))?;
    let name = text_or_none(&records.line("name of a coordinate system")?.bytes);
    let mut numbers = Vec::new();
    records.numbers(9, 13, "points of a coordinate system", &mut numbers)?;
    let point = |i: usize| [numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]];
    let placement = Placement::Points {
        reference: field(2),
        points: [point(0), point(1), point(2)],
    };
    RawSystem::new(head, field(0), name, kind, placement)
}
