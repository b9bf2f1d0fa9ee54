//! Dataset 151, the head of a file: seven lines of text (model name, description, program that made
//! it, date made, date saved, program that wrote the file, date written). All are kept as title
//! lines, except modalign as the name of the program that wrote the file.

use super::fields::{Line, text_or_none};

/// The lines, trimmed, without empty ones and `NONE`.
pub(super) fn title(lines: &[Line]) -> Vec<String> {
    let numbered = lines
        .iter()
        .map(|line| text_or_none(&line.bytes))
        .enumerate();
    let says_nothing =
        |(i, text): &(usize, String)| text.is_empty() || (*i == 5 && text == "modalign");
    let said = numbered.filter(|line| !says_nothing(line));
    said.map(|(_, text)| text).collect()
}
