//! Dataset 2412, elements.
//!
//! | line | columns | fields |
//! |---|---|---|
//! | 1 | 6 I10 | label, descriptor, physical property, material, colour, number of nodes |
//! | 2 | 3 I10 | beams (descriptors 11, 21 to 24) alone: orientation node, cross sections of the ends; not used |
//! | 3.. | 8 I10 | node labels |

use std::io::{self, Write};

use crate::geometry::Element;
use crate::io::formats::uff::fields::records::Records;
use crate::io::formats::uff::fields::{FieldError, Line};

/// Reads the elements; `first` is the dataset's first line, for messages.
pub(in crate::io::formats::uff) fn elements(
    lines: &[Line],
    first: &Line,
) -> Result<Vec<Element>, FieldError> {
    let mut records = Records::new(lines, first);
    let mut elements = Vec::new();
    while records.peek().is_some() {
        elements.push(element(&mut records)?);
    }
    Ok(elements)
}

/// Whether an element of this descriptor is a beam, which has an additional line.
fn is_beam(descriptor: i64) -> bool {
    matches!(descriptor, 11 | 21..=24)
}

fn element(records: &mut Records<'_>) -> Result<Element, FieldError> {
    let what = "element of dataset 2412";
    let (head, fields) = records.integer_row(what)?;
    let refuse = || {
        let expected = "label, descriptor, two properties, colour, number of nodes";
        FieldError::line(head, what, expected)
    };
    let [label, descriptor, _, _, _, count] = fields[..] else {
        return Err(refuse());
    };
    let count = usize::try_from(count).ok().filter(|count| *count > 0);
    let count = count.ok_or_else(refuse)?;
    if is_beam(descriptor) {
        records.filled("beam line of dataset 2412")?;
    }
    let nodes = records.integers(count, "nodes of an element of dataset 2412")?;
    if nodes.iter().any(|node| *node < 0) {
        return Err(refuse());
    }
    Ok(Element {
        label,
        descriptor,
        points: nodes.iter().map(i64::to_string).collect(),
    })
}

/// Writes elements whose points are the node labels beside them.
pub(in crate::io::formats::uff) fn write(
    out: &mut dyn Write,
    elements: &[(&Element, Vec<i64>)],
) -> io::Result<()> {
    let mut text = String::from("    -1\n  2412\n");
    for (element, nodes) in elements {
        let (label, descriptor) = (element.label, element.descriptor);
        text.push_str(&integer_rows(&[
            label,
            descriptor,
            1,
            1,
            8,
            nodes.len() as i64,
        ]));
        if is_beam(descriptor) {
            text.push_str(&integer_rows(&[0, 1, 1]));
        }
        text.push_str(&integer_rows(nodes));
    }
    text.push_str("    -1\n");
    out.write_all(text.as_bytes())
}

/// Lines of 8 I10.
pub(super) fn integer_rows(numbers: &[i64]) -> String {
    let mut text = String::new();
    for row in numbers.chunks(8) {
        text.extend(row.iter().map(|number| format!("{number:>10}")));
        text.push('\n');
    }
    text
}
