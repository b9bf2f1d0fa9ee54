//! Dataset 2420, coordinate systems of a part by their transformation.
//!
//! | line | columns | fields |
//! |---|---|---|
//! | 1 | I10 | part |
//! | 2 | A80 | name of the part |
//! | 3 | 3 I10 | label, type (0 Cartesian, 1 cylindrical, 2 spherical), colour |
//! | 4 | A80 | name |
//! | 5 to 8 | 3 D25.16 | unit vectors of the x, y and z axes, origin, in the part's frame, which is the global one |
//!
//! Lines 3 to 8 are repeated.

use std::io::{self, Write};

use super::systems::{Placement, RawSystem, code, kind};
use crate::geometry::CoordinateSystem;
use crate::io::formats::uff::fields::fixed_columns::{fortran, line_text};
use crate::io::formats::uff::fields::records::Records;
use crate::io::formats::uff::fields::{FieldError, Line, text_or_none};

/// Reads the systems; `first` is the dataset's first line, for messages.
pub(in crate::io::formats::uff) fn systems(
    lines: &[Line],
    first: &Line,
) -> Result<Vec<RawSystem>, FieldError> {
    let mut records = Records::new(lines, first);
    records.line("part of dataset 2420")?;
    records.line("name of the part")?;
    let mut systems = Vec::new();
    while records.peek().is_some() {
        systems.push(system(&mut records)?);
    }
    Ok(systems)
}

fn system(records: &mut Records<'_>) -> Result<RawSystem, FieldError> {
    let (head, fields) = records.integer_row("coordinate system of dataset 2420")?;
    let kind = kind(fields.get(1).copied().unwrap_or(0)).ok_or_else(|| {
        FieldError::line(head, "coordinate system of dataset 2420", "type 0, 1 or 2")
    })?;
    let name = text_or_none(&records.line("name of a coordinate system")?.bytes);
    let mut numbers = Vec::new();
    records.numbers(
        12,
        25,
        "transformation of a coordinate system",
        &mut numbers,
    )?;
    let row = |i: usize| [numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]];
    let placement = Placement::Matrix {
        axes: [row(0), row(1), row(2)],
        origin: row(3),
    };
    RawSystem::new(head, fields[0], name, kind, placement)
}

/// Writes the systems, in m, as part 1.
pub(in crate::io::formats::uff) fn write(
    out: &mut dyn Write,
    systems: &[&CoordinateSystem],
) -> io::Result<()> {
    let mut text = format!("    -1\n  2420\n{:>10}\nNONE\n", 1);
    for system in systems {
        text.push_str(&format!(
            "{:>10}{:>10}{:>10}\n",
            system.label,
            code(system.kind),
            8
        ));
        text.push_str(&name_line(&system.name));
        for row in system.axes.iter().chain([&system.origin_m]) {
            text.push_str(&double_row(row.as_slice()));
        }
    }
    text.push_str("    -1\n");
    out.write_all(text.as_bytes())
}

/// A line with a name, `NONE` where there is none.
pub(super) fn name_line(name: &str) -> String {
    let name = line_text(name);
    format!("{}\n", if name.is_empty() { "NONE" } else { &name })
}

/// A row of D25.16: 17 digits, which bring every double back.
pub(super) fn double_row(values: &[f64]) -> String {
    let fields = values
        .iter()
        .map(|value| format!("{:>25}", fortran(*value, 16).replace('E', "D")));
    fields.chain(["\n".to_owned()]).collect()
}
