//! Dataset 2411, nodes in double precision, two lines each.
//!
//! | line | columns | fields |
//! |---|---|---|
//! | 1 | 4 I10 | label, definition coordinate system (0 or 1 for the global one), displacement coordinate system, colour |
//! | 2 | 3 D25.16 | coordinates in file units of length |

use super::fields::{FieldError, Line, finite, integer, integer_or_zero, numeric_record};
use super::nodes::RawNode;

/// Reads the nodes.
pub(super) fn nodes(lines: &[Line]) -> Result<Vec<RawNode>, FieldError> {
    let lines: Vec<&Line> = lines
        .iter()
        .filter(|line| !line.bytes.trim_ascii().is_empty())
        .collect();
    lines
        .chunks(2)
        .map(|pair| match pair {
            [head, coordinates] => node(head, coordinates),
            _ => Err(FieldError::line(
                pair[0],
                "node of dataset 2411",
                "a second line with x, y, z",
            )),
        })
        .collect()
}

fn node(head: &Line, coordinates: &Line) -> Result<RawNode, FieldError> {
    let (label, system) = numeric_record(&head.bytes, &[10, 10, 10, 10], |fields| {
        Some((integer(fields[0])?, integer_or_zero(fields[1])?))
    })
    .ok_or_else(|| {
        FieldError::line(
            head,
            "node of dataset 2411",
            "label, two coordinate systems, colour",
        )
    })?;
    let at = numeric_record(&coordinates.bytes, &[25, 25, 25], |fields| {
        Some([finite(fields[0])?, finite(fields[1])?, finite(fields[2])?])
    })
    .ok_or_else(|| FieldError::line(coordinates, "coordinates of dataset 2411", "x, y, z"))?;
    RawNode::new(head, label, system, at)
}
