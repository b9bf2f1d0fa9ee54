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
//!
//! The eigenvalue of a normal mode is ω² in (rad/s)². Writers fill some of these fields alone:
//! where the frequency of a normal mode is 0, it follows from ω², else from λ; where λ of a complex
//! mode is 0, frequency and damping ratio replace it.

use std::f64::consts::TAU;

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
    let stated = match definition.analysis {
        2 => one,
        _ => two,
    };
    let root = root(definition.analysis, &reals, [one, two]);
    let root = root.ok_or_else(|| no_root(parameters.at, stated))?;
    let (nodes, values) = node_values(&mut records, definition)?;
    Ok(Ok(RawMode {
        at: first.at,
        title: titles(&id_lines),
        note: ModeNote::from_lines(&id_lines),
        root,
        damping_field: reals[4],
        definition,
        nodes,
        values,
    }))
}

/// The pole from the twelve numbers of records 12 and 13, of which the first `stated` of either are
/// stated; `None` where neither a frequency nor an eigenvalue is.
fn root(analysis: i64, reals: &[f64], stated: [usize; 2]) -> Option<Root> {
    let squared = reals[2].max(0.0).sqrt() / TAU;
    let frequency_hz = if reals[1] == 0.0 { squared } else { reals[1] };
    let normal = Root::normal(&[frequency_hz, reals[3], reals[4], reals[5]]);
    let normal = normal.filter(|_| stated[0] >= 2);
    let complex = Root::complex(&reals[6..6 + stated[1]]);
    let [first, second] = match analysis {
        2 => [normal, complex],
        _ => [complex, normal],
    };
    let vibrates = |root: &Root| root.frequency_hz() > 0.0;
    first.filter(vibrates).or(second.filter(vibrates)).or(first)
}
