//! Dataset 2414, analysis data: modes at nodes. Data of other analyses or on elements are passed
//! over.
//!
//! | record | columns | fields |
//! |---|---|---|
//! | 1 | I10 | label |
//! | 2 | A80 | name |
//! | 3 | I10 | location: 1 at nodes |
//! | 4 to 8 | A80 | ID lines, as in dataset 55 |
//! | 9 | 6 I10 | as record 6 of dataset 55 |
//! | 10, 11 | 8 I10, 2 I10 | integers of the analysis, not used |
//! | 12 | 6 E13.5 | time, frequency in Hz, eigenvalue, modal mass, viscous and hysteretic damping ratio |
//! | 13 | 6 E13.5 | Re λ, Im λ in rad/s, modal A, modal B |
//! | 14, 15 | I10, 6 E13.5 | node and its values, repeated |

use super::mode_note::ModeNote;
use super::node_data::{Definition, no_root, node_values, two_rows_of_parameters};
use super::{RawMode, Root, titles};
use crate::io::formats::uff::fields::records::Records;
use crate::io::formats::uff::fields::{FieldError, Line};

/// Reads the mode, or the number of the analysis that it is not; `first` is the dataset's first
/// line, for messages.
pub(in crate::io::formats::uff) fn mode(
    lines: &[Line],
    first: &Line,
) -> Result<Result<RawMode, i64>, FieldError> {
    let mut records = Records::new(lines, first);
    records.line("label of dataset 2414")?;
    let mut id_lines = vec![records.line("name of dataset 2414")?];
    let (_, location) = records.integer_row("location of dataset 2414")?;
    for _ in 0..5 {
        id_lines.push(records.line("ID lines of dataset 2414")?);
    }
    let definition = Definition::read(records.filled("record 9 of dataset 2414")?)?;
    if location != [1] || !definition.is_mode() {
        return Ok(Err(definition.analysis));
    }
    records.filled("record 10 of dataset 2414")?;
    records.filled("record 11 of dataset 2414")?;
    let parameters = two_rows_of_parameters(&mut records)?;
    let (reals, [one, two]) = (parameters.numbers, parameters.stated);
    let (root, stated) = match definition.analysis {
        2 if one < 2 => (None, one),
        2 => (Root::normal(&[reals[1], reals[3], reals[4], reals[5]]), one),
        _ => (Root::complex(&reals[6..6 + two]), two),
    };
    let root = root.ok_or_else(|| no_root(parameters.at, stated))?;
    let (nodes, values) = node_values(&mut records, definition)?;
    Ok(Ok(RawMode {
        at: first.at,
        title: titles(&id_lines),
        note: ModeNote::from_lines(&id_lines),
        root,
        definition,
        nodes,
        values,
    }))
}
