//! Files that `inspect` and `new` leave out beside others that hold test data.

use std::fmt::{Display, Formatter};
use std::path::Path;

use serde_json::{Value, json};

use crate::io::IoError;
use crate::printable::counted;

use super::new_points::{POINTS_OPTION, may_hold_points};

/// A file that is not used as test data.
pub(super) struct LeftOut<'a> {
    pub(super) path: &'a Path,
    pub(super) reason: Reason,
}

/// The reason why a file is not used.
pub(super) enum Reason {
    /// It could not be opened as test data.
    Error(IoError),
    /// It has this number of columns, none with a known heading, beside files that state their
    /// contents: coordinates of points as a rule.
    Unnamed(usize),
}

impl LeftOut<'_> {
    /// Whether the file may be test data that are lost: damaged, empty, or without numbers under
    /// the extension of a file that was read. A picture or notes beside the data are not.
    pub(super) fn may_hold_data(&self, read: &[&Path]) -> bool {
        let error = match &self.reason {
            Reason::Error(error) => error,
            Reason::Unnamed(_) => return false,
        };
        match error {
            IoError::NoNumbers { got, .. } => {
                *got == IoError::EMPTY_FILE
                    || read.iter().any(|path| has_same_extension(path, self.path))
            }
            error => !error.is_no_measurement(),
        }
    }

    /// The line for the screen.
    pub(super) fn text(&self, read: &[&Path]) -> String {
        let path = self.path.display();
        let error = match &self.reason {
            Reason::Error(error) => error,
            Reason::Unnamed(_) => return format!("not used: {path}: {}", self.reason),
        };
        let points = match error {
            IoError::NoNumbers { .. } if may_hold_points(self.path) => {
                format!("; {POINTS_OPTION} with lines POINT,X,Y,Z")
            }
            _ => String::new(),
        };
        match error {
            IoError::NoNumbers { .. } if self.may_hold_data(read) => {
                format!("not used: {error}; if it should contain data, export it again{points}")
            }
            IoError::UnknownFormat { .. } => {
                format!("not used: {path}: of unknown format")
            }
            error if error.is_no_measurement() => format!("not used: {error}{points}"),
            error => format!("not read: {error}"),
        }
    }

    pub(super) fn json(&self) -> Value {
        json!({ "path": self.path.display().to_string(), "error": self.reason.to_string() })
    }
}

impl Display for Reason {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Reason::Error(error) => error.fmt(f),
            Reason::Unnamed(columns) => write!(
                f,
                "{} without a known heading beside files that state their contents; \
                 {POINTS_OPTION}",
                counted(*columns, "column")
            ),
        }
    }
}

fn has_same_extension(a: &Path, b: &Path) -> bool {
    match (a.extension(), b.extension()) {
        (Some(a), Some(b)) => a.eq_ignore_ascii_case(b),
        (a, b) => a == b,
    }
}
