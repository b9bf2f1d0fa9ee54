//! Dataset 15, nodes, one line each.
//!
//! | columns | field |
//! |---|---|
//! | I10 | label |
//! | I10 | definition coordinate system, 0 (or 1, unless it is described) for the global one |
//! | I10 | displacement coordinate system |
//! | I10 | colour, not used |
//! | 3 E13.5 | coordinates in file units of length |

use super::nodes::{RawNode, printed};
use crate::io::formats::uff::fields::{FieldError, Line, integer, integer_or_zero, numeric_record};

/// Reads the nodes.
pub(in crate::io::formats::uff) fn nodes(lines: &[Line]) -> Result<Vec<RawNode>, FieldError> {
    lines
        .iter()
        .filter(|line| !line.bytes.trim_ascii().is_empty())
        .map(node)
        .collect()
}

fn node(line: &Line) -> Result<RawNode, FieldError> {
    let parse = |fields: &[&[u8]]| {
        let coordinates = printed(&fields[4..])?;
        Some((
            integer(fields[0])?,
            [integer_or_zero(fields[1])?, integer_or_zero(fields[2])?],
            coordinates,
        ))
    };
    let (label, systems, coordinates) =
        numeric_record(&line.bytes, &[10, 10, 10, 10, 13, 13, 13], parse).ok_or_else(|| {
            FieldError::line(
                line,
                "node of dataset 15",
                "label, two coordinate systems, colour, x, y, z",
            )
        })?;
    RawNode::new(line, label, systems, coordinates)
}
