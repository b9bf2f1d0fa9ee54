//! Dataset 82, one trace line.
//!
//! | line | columns | fields |
//! |---|---|---|
//! | 1 | 3 I10 | number of the trace line, number of entries, colour |
//! | 2 | A80 | name |
//! | 3.. | 8 I10 | node labels, 0 lifts the pen; the last line may be filled up with zeros |

use super::fields::{FieldError, Line, columns, integer, numeric_record, text_or_none, words};
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
    let parse = |fields: &[&[u8]]| -> Option<Vec<i64>> {
        fields
            .iter()
            .map(|field| integer(field).filter(|label| *label >= 0))
            .collect()
    };
    let by_columns = || {
        let fields = columns(&row.bytes, &[10; 8]);
        let filled: Vec<&[u8]> = fields.into_iter().filter(|f| !f.is_empty()).collect();
        parse(&filled)
    };
    parse(&words(&row.bytes))
        .or_else(by_columns)
        .ok_or_else(|| FieldError::line(row, "entries of dataset 82", "node labels or 0"))
}
