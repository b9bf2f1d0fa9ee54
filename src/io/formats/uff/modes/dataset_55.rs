//! Dataset 55, data at nodes: modes. Data of other analyses are passed over.
//!
//! | record | columns | fields |
//! |---|---|---|
//! | 1 to 5 | A80 | ID lines, `NONE` for nothing; one that starts with `modalign` is a [`ModeNote`] |
//! | 6 | 6 I10 | model, analysis, characteristic, quantity, data type, values per node (`node_data`) |
//! | 7 | 8 I10 | number of integers and of reals that follow, load case, mode number (not used) |
//! | 8 | 6 E13.5 | normal mode: frequency in Hz, modal mass, viscous and hysteretic damping ratio |
//! | 8 | 6 E13.5 | complex eigenvalue: Re λ, Im λ in rad/s, modal A, modal B, each with real and imaginary part |
//! | 9 | I10 | node |
//! | 10 | 6 E13.5 | its values; records 9 and 10 are repeated |
//!
//! Text behind `FREQUENCY` in an ID line is not read: it is the damped frequency where Testlab
//! wrote it.

use super::mode_note::ModeNote;
use super::node_data::{Definition, no_root, node_values, real_parameters};
use super::{RawMode, Root, titles};
use crate::io::formats::uff::fields::records::Records;
use crate::io::formats::uff::fields::{FieldError, Line};

/// Most numbers of record 7 or 8; the format has 10 and 12.
const MAX_PARAMETERS: i64 = 1_000;

/// Reads the mode, or the number of the analysis that it is not; `first` is the dataset's first
/// line, for messages.
pub(in crate::io::formats::uff) fn mode(
    lines: &[Line],
    first: &Line,
) -> Result<Result<RawMode, i64>, FieldError> {
    let mut records = Records::new(lines, first);
    let mut id_lines = Vec::new();
    for _ in 0..5 {
        id_lines.push(records.line("ID lines of dataset 55")?);
    }
    let definition = Definition::read(records.filled("record 6 of dataset 55")?)?;
    if !definition.is_mode() {
        return Ok(Err(definition.analysis));
    }
    let (head, reals) = parameter_head(&mut records)?;
    let reals = real_parameters(&mut records, reals)?;
    let root = match definition.analysis {
        2 => Root::normal(&reals),
        _ => Root::complex(&reals),
    };
    let root = root.ok_or_else(|| no_root(head, reals.len()))?;
    let (nodes, values) = node_values(&mut records, definition)?;
    Ok(Ok(RawMode {
        at: first.at,
        title: titles(&id_lines),
        note: ModeNote::from_lines(&id_lines),
        root,
        damping_field: 0.0,
        definition,
        nodes,
        values,
    }))
}

/// Passes over the integers of record 7 and gives it with the number of reals.
fn parameter_head<'a>(records: &mut Records<'a>) -> Result<(&'a Line, usize), FieldError> {
    let what = "record 7 of dataset 55";
    let (head, row) = records.integer_row(what)?;
    let refuse = || FieldError::line(head, what, "numbers of integers and of reals");
    let count = |i: usize| {
        row.get(i)
            .filter(|count| (0..=MAX_PARAMETERS).contains(*count))
    };
    let (Some(integers), Some(reals)) = (count(0), count(1)) else {
        return Err(refuse());
    };
    let integers = usize::try_from(*integers).map_err(|_| refuse())?;
    // Trailing integers may be missing; more than eight stand on a second line.
    if integers + 2 > 8 && row.len() == 8 {
        records.integer_row(what)?;
    }
    let reals = usize::try_from(*reals).map_err(|_| refuse())?;
    Ok((head, reals))
}
