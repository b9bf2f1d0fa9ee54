//! Dataset 151, the head of a file: seven lines of text (model name, description, program that made it, date made, date
//! saved, program that wrote the file, date written). All are kept as title lines; none carries a number that is used.

use super::fields::{Line, text_or_none};

/// The lines, trimmed, without empty ones and `NONE`.
pub(super) fn title(lines: &[Line]) -> Vec<String> {
    lines
        .iter()
        .map(|line| text_or_none(&line.bytes))
        .filter(|text| !text.is_empty())
        .collect()
}
