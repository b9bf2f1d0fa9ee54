//! Files that `inspect` and `new` leave out beside others that hold test data.

use std::path::Path;

use serde_json::{Value, json};

use crate::io::IoError;

/// A file that could not be opened as test data.
pub(super) struct LeftOut<'a> {
    pub(super) path: &'a Path,
    pub(super) error: IoError,
}

impl LeftOut<'_> {
    /// Whether the file may be test data that are lost: damaged, empty, or without numbers under
    /// the extension of a file that was read. A picture or notes beside the data are not.
    pub(super) fn may_hold_data(&self, read: &[&Path]) -> bool {
        match &self.error {
            IoError::NoNumbers { got, .. } => {
                *got == IoError::EMPTY_FILE
                    || read.iter().any(|path| has_same_extension(path, self.path))
            }
            error => !error.is_no_measurement(),
        }
    }

    /// The line for the screen.
    pub(super) fn text(&self, read: &[&Path]) -> String {
        match &self.error {
            IoError::NoNumbers { .. } if self.may_hold_data(read) => {
                format!(
                    "not used: {}; if it should contain data, export it again",
                    self.error
                )
            }
            IoError::UnknownFormat { .. } => {
                format!("not used: {}: of unknown format", self.path.display())
            }
            error if error.is_no_measurement() => format!("not used: {error}"),
            error => format!("not read: {error}"),
        }
    }

    pub(super) fn json(&self) -> Value {
        json!({ "path": self.path.display().to_string(), "error": self.error.to_string() })
    }
}

fn has_same_extension(a: &Path, b: &Path) -> bool {
    match (a.extension(), b.extension()) {
        (Some(a), Some(b)) => a.eq_ignore_ascii_case(b),
        (a, b) => a == b,
    }
}
