//! Dataset 2411, nodes in double precision, two lines each. Dataset 781, its forerunner, has the
//! same lines.
//!
//! | line | columns | fields |
//! |---|---|---|
//! | 1 | 4 I10 | label, definition coordinate system (0, or 1 unless it is described, for the global one), displacement coordinate system, colour |
//! | 2 | 3 D25.16 | coordinates in file units of length |

use std::io::{self, Write};

use super::dataset_2420::double_row;
use super::nodes::{RawNode, printed};
use crate::io::formats::uff::fields::{FieldError, Line, integer, integer_or_zero, numeric_record};
use crate::linalg::Vector3;

/// Reads the nodes.
pub(in crate::io::formats::uff) fn nodes(lines: &[Line]) -> Result<Vec<RawNode>, FieldError> {
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
    let (label, systems) = numeric_record(&head.bytes, &[10, 10, 10, 10], |fields| {
        let systems = [integer_or_zero(fields[1])?, integer_or_zero(fields[2])?];
        Some((integer(fields[0])?, systems))
    })
    .ok_or_else(|| {
        FieldError::line(
            head,
            "node of dataset 2411",
            "label, two coordinate systems, colour",
        )
    })?;
    let at = numeric_record(&coordinates.bytes, &[25, 25, 25], printed)
        .ok_or_else(|| FieldError::line(coordinates, "coordinates of dataset 2411", "x, y, z"))?;
    RawNode::new(head, label, systems, at)
}

/// Writes the nodes of `rows`: label, displacement coordinate system (0 for the global frame) and
/// position in m, in the global frame, with the 17 digits that bring every double back.
pub(in crate::io::formats::uff) fn write(
    out: &mut dyn Write,
    rows: &[(i64, i64, Vector3)],
) -> io::Result<()> {
    let mut text = String::from("    -1\n  2411\n");
    for (label, displacement, at_m) in rows {
        text.push_str(&format!(
            "{label:>10}{:>10}{displacement:>10}{:>10}\n",
            0, 8
        ));
        text.push_str(&double_row(at_m.as_slice()));
    }
    text.push_str("    -1\n");
    out.write_all(text.as_bytes())
}
