//! Dataset 82, one trace line.
//!
//! | line | columns | fields |
//! |---|---|---|
//! | 1 | 3 I10 | number of the trace line, number of entries, colour |
//! | 2 | A80 | name |
//! | 3.. | 8 I10 | node labels, 0 lifts the pen; lines may be filled up with zeros that are not counted |

use std::io::{self, Write};

use super::dataset_2412::integer_rows;
use super::dataset_2420::name_line;
use crate::geometry::TraceLine;
use crate::io::formats::uff::fields::records::integer_row;
use crate::io::formats::uff::fields::{FieldError, Line, integer, numeric_record, text_or_none};

/// A trace line with the number of its entries.
pub(in crate::io::formats::uff) struct Traced {
    pub line: TraceLine,
    /// Number of entries as the header states it.
    pub stated: usize,
    /// Number of entries that are there, without those that fill up lines.
    pub found: usize,
}

/// Reads the trace line; `first` is the dataset's first line, for messages.
pub(in crate::io::formats::uff) fn trace_line(
    lines: &[Line],
    first: &Line,
) -> Result<Traced, FieldError> {
    let [head, name, rows @ ..] = lines else {
        let line = lines.first().unwrap_or(first);
        return Err(FieldError::line(line, "trace line of dataset 82", "a name"));
    };
    let stated = numeric_record(&head.bytes, &[10, 10, 10], |fields| integer(fields[1]))
        .and_then(|count| usize::try_from(count).ok())
        .ok_or_else(|| {
            FieldError::line(
                head,
                "trace line of dataset 82",
                "number, number of entries, colour",
            )
        })?;
    let rows = rows.iter().map(row_labels);
    let mut labels = without_filling(&rows.collect::<Result<Vec<_>, _>>()?, stated);
    let is_node = |label: &&i64| **label > 0;
    let found = match labels.iter().filter(is_node).count() {
        // Where zeros are not counted they lift the pen all the same.
        nodes if nodes == stated => stated,
        _ => {
            let found = labels.len();
            labels.truncate(stated);
            found
        }
    };
    let point = |label: &i64| (*label > 0).then(|| label.to_string());
    Ok(Traced {
        line: TraceLine {
            name: text_or_none(&name.bytes),
            points: labels.iter().map(point).collect(),
        },
        stated,
        found,
    })
}

/// The entries of all rows without the zeros that fill up the rows, where they are then as many as
/// stated; else without those that fill up the last ones.
fn without_filling(rows: &[Vec<i64>], stated: usize) -> Vec<i64> {
    let trimmed = |labels: &[i64], count: usize| {
        let filling = labels.iter().rev().take_while(|label| **label == 0).count();
        labels[..(labels.len() - filling).max(count.min(labels.len()))].to_vec()
    };
    let all = trimmed(&rows.concat(), stated);
    let filled: Vec<i64> = rows.iter().flat_map(|row| trimmed(row, 0)).collect();
    if all.len() != stated && filled.len() == stated {
        return filled;
    }
    all
}

fn row_labels(row: &Line) -> Result<Vec<i64>, FieldError> {
    integer_row(row)
        .filter(|labels| labels.iter().all(|label| *label >= 0))
        .ok_or_else(|| FieldError::line(row, "entries of dataset 82", "node labels or 0"))
}

/// Writes one trace line: its number, its name, and node labels with 0 where the pen is lifted.
pub(in crate::io::formats::uff) fn write(
    out: &mut dyn Write,
    number: usize,
    name: &str,
    labels: &[i64],
) -> io::Result<()> {
    let head = format!("{number:>10}{:>10}{:>10}\n", labels.len(), 8);
    let (name, rows) = (name_line(name), integer_rows(labels));
    let text = format!("    -1\n    82\n{head}{name}{rows}    -1\n");
    out.write_all(text.as_bytes())
}
