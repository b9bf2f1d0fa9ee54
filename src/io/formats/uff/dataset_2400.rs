//! Dataset 2400, the head of a model. Of its six lines (identification, name, part number, status,
//! dates, switches) the name alone is read: it is the title of a file that has no dataset 151.

use super::fields::{Line, text_or_none};

/// The name; empty where there is none.
pub(super) fn name(lines: &[Line]) -> String {
    lines
        .get(1)
        .map_or_else(String::new, |line| text_or_none(&line.bytes))
}
