//! Dataset 82, one trace line.
//!
//! | line | columns | fields |
//! |---|---|---|
//! | 1 | 3 I10 | number of the trace line, number of entries, colour |
//! | 2 | A80 | name |
//! | 3.. | 8 I10 | node labels, 0 lifts the pen; the last line may be filled up with zeros |

use std::io::{self, Write};

use super::dataset_2412::integer_rows;
use super::dataset_2420::name_line;
use super::fields::{FieldError, Line, integer, numeric_record, text_or_none};
use super::records::integer_row;
use crate::geometry::TraceLine;

/// Reads the trace line; `first` is the dataset's first line, for messages.
pub(super) fn trace_line(lines: &[Line], first: &Line) -> Result<TraceLine, FieldError> {
    let [head, name, rows @ ..] = lines else {
        let line = lines.first().unwrap_or(first);
        return Err(FieldError::line(line, "trace line of dataset 82", "a name"));
    };
    let count = numeric_record(&head.bytes, &[10, 10, 10], |fields| integer(fields[1]))
        .and_then(|count| usize::try_from(count).ok())
        .ok_or_else(|| {
            FieldError::line(
                head,
                "trace line of dataset 82",
                "number, number of entries, colour",
            )
        })?;
    let mut labels = Vec::new();
    for row in rows {
        labels.extend(row_labels(row)?);
    }
    if labels.len() < count || labels[count..].iter().any(|label| *label != 0) {
        return Err(FieldError {
            at: head.at,
            what: "number of entries of dataset 82",
            got: labels.len().to_string(),
            expected: count.to_string(),
        });
    }
    labels.truncate(count);
    Ok(TraceLine {
        name: text_or_none(&name.bytes),
        points: labels
            .iter()
            .map(|label| (*label > 0).then(|| label.to_string()))
            .collect(),
    })
}

fn row_labels(row: &Line) -> Result<Vec<i64>, FieldError> {
    integer_row(row)
        .filter(|labels| labels.iter().all(|label| *label >= 0))
        .ok_or_else(|| FieldError::line(row, "entries of dataset 82", "node labels or 0"))
}

/// Writes one trace line: its number, its name, and node labels with 0 where the pen is lifted.
pub(super) fn write(
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
