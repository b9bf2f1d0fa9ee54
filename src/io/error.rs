//! Why a file cannot be read or written.

use std::io::ErrorKind;

use crate::dof::DofError;
use crate::quantity::UnitError;

/// A failure of reading or writing, with its place.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// The operating system refused.
    #[error("{path}: cannot {action}: {}", system_reason(source))]
    System {
        /// Path as given.
        path: String,
        /// The operation that failed (`open`, `read`, `write`, `rename`).
        action: &'static str,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A format that no reader takes.
    #[error("{path}: got {got}, expected one of {known}")]
    UnknownFormat {
        /// Path as given.
        path: String,
        /// Whether it is text, or the format as stated.
        got: String,
        /// Names of the formats.
        known: String,
    },
    /// Text without a row of numbers.
    #[error("{path}:{line}: got {got}, expected rows of numbers separated by {separators}")]
    NoNumbers {
        /// Path as given.
        path: String,
        /// First line from 1 that was searched.
        line: u64,
        /// What the file has instead.
        got: &'static str,
        /// The accepted separators.
        separators: String,
    },
    /// Several formats that are as sure of a file.
    #[error(
        "{path}: got a file that could be {candidates}, expected one format: state it with --format"
    )]
    Tie {
        /// Path as given.
        path: String,
        /// Names of the candidates.
        candidates: String,
    },
    /// Text that is not what the format puts there.
    #[error("{path}:{line}: {what}: got {got:?}, expected {expected}")]
    Text {
        /// Path as given.
        path: String,
        /// Line from 1.
        line: u64,
        /// Which field.
        what: &'static str,
        /// Text as found.
        got: String,
        /// The content that the format requires there.
        expected: String,
    },
    /// Bytes that are not what the format puts there.
    #[error("{path} at byte {byte}: {what}: got {got}, expected {expected}")]
    Binary {
        /// Path as given.
        path: String,
        /// Offset from 0.
        byte: u64,
        /// Which part.
        what: &'static str,
        /// The value in the file.
        got: String,
        /// The content that the format requires there.
        expected: String,
    },
    /// The file ends inside an entry.
    #[error("{path} at byte {byte}: the file ends inside {what}: got {got}, expected {expected}")]
    Truncated {
        /// Path as given.
        path: String,
        /// Where the file ends.
        byte: u64,
        /// Inside what.
        what: &'static str,
        /// How much was found.
        got: String,
        /// How much was expected.
        expected: String,
    },
    /// Contents for which the memory has no room.
    #[error("{path}: {what}: got {:.1} GB, expected an array for which the memory has room twice (--max-memory)", *bytes as f64 / 1e9)]
    Memory {
        /// Path as given.
        path: String,
        /// Which part.
        what: String,
        /// Its size.
        bytes: u64,
    },
    /// A column that a table does not have.
    #[error(
        "{path}:{line}: got columns {got}, expected a column {expected:?} ([[test.channel]] column)"
    )]
    MissingColumn {
        /// Path as given.
        path: String,
        /// Header line from 1.
        line: u64,
        /// The columns that are there.
        got: String,
        /// The column that the scene names.
        expected: String,
    },
    /// An array, or a column of one, that a file does not have.
    #[error("{path}: got {got}, expected an array {expected:?} ([[test.channel]] column)")]
    MissingArray {
        /// Path as given.
        path: String,
        /// The arrays that are there, or the columns of the one that is named.
        got: String,
        /// The name in the scene.
        expected: String,
    },
    /// A property that neither the file nor the scene states.
    #[error("{path}: {what} is not stated: expected {expected}")]
    NotStated {
        /// Path as given.
        path: String,
        /// The missing property (unit, sampling rate, excitation point, ...).
        what: String,
        /// Where it could be stated.
        expected: String,
    },
    /// Records that cannot make a hit.
    #[error("{path}: {what}: got {got}, expected {expected}")]
    Grouping {
        /// Path as given.
        path: String,
        /// The operation.
        what: &'static str,
        /// The value in the data.
        got: String,
        /// The requirement on a hit.
        expected: String,
    },
    /// A JSON file that does not follow its schema.
    #[error("{path}:{line}:{column}: got {got}, expected {expected}")]
    Json {
        /// Path as given.
        path: String,
        /// Line from 1.
        line: usize,
        /// Column from 1.
        column: usize,
        /// The reader's complaint.
        got: String,
        /// The schema.
        expected: &'static str,
    },
    /// A result that is not of the run that the manifest of its folder names.
    #[error("{path}: got {got}, expected {expected}")]
    OtherRun {
        /// Path as given.
        path: String,
        /// What the file holds.
        got: String,
        /// What the manifest names, with the verb that makes it.
        expected: String,
    },
    /// A unit that is not known.
    #[error("{path}: {source}")]
    Unit {
        /// Path as given.
        path: String,
        /// Which unit.
        source: UnitError,
    },
    /// A degree of freedom that cannot be named or written.
    #[error("{path}: {source}")]
    Dof {
        /// Path as given.
        path: String,
        /// Which one.
        source: DofError,
    },
    /// A value that the format cannot hold.
    #[error("{path}: cannot write {what}: got {got}, expected {expected}")]
    Unwritable {
        /// Path as given.
        path: String,
        /// The property to be written.
        what: &'static str,
        /// The given value.
        got: String,
        /// The values that the format can hold.
        expected: String,
    },
}

impl IoError {
    /// What [`IoError::NoNumbers`] got from a file without a byte.
    pub const EMPTY_FILE: &str = "an empty file";

    /// Whether the file is something other than test data, such as a picture or notes.
    pub fn is_no_measurement(&self) -> bool {
        matches!(
            self,
            IoError::UnknownFormat { .. } | IoError::NoNumbers { .. }
        )
    }

    /// Subject, got and expected, without the place in the file.
    pub fn without_place(&self) -> String {
        match self {
            IoError::Text {
                what,
                got,
                expected,
                ..
            } => format!("{what}: got {got:?}, expected {expected}"),
            IoError::Binary {
                what,
                got,
                expected,
                ..
            } => format!("{what}: got {got}, expected {expected}"),
            IoError::Truncated {
                what,
                got,
                expected,
                ..
            } => format!("the file ends inside {what}: got {got}, expected {expected}"),
            other => other.to_string(),
        }
    }
}

/// The reason of the operating system in plain words, without its number.
fn system_reason(source: &std::io::Error) -> String {
    match source.kind() {
        ErrorKind::NotFound => "there is no such file".to_owned(),
        ErrorKind::IsADirectory => "it is a folder, expected a file".to_owned(),
        ErrorKind::NotADirectory => "a part of its path is a file, expected a folder".to_owned(),
        _ => {
            let text = source.to_string();
            let reason = text.split_once(" (os error ").map(|(reason, _)| reason);
            reason.unwrap_or(&text).to_owned()
        }
    }
}

/// The error of an output that the operating system refuses.
pub(in crate::io) fn write_failed(path: &str, source: std::io::Error) -> IoError {
    IoError::System {
        path: path.to_owned(),
        action: "write",
        source,
    }
}

/// The error of an action on a path that the operating system refuses.
pub(in crate::io) fn system(
    path: &str,
    action: &'static str,
) -> impl FnOnce(std::io::Error) -> IoError {
    move |source| IoError::System {
        path: path.to_owned(),
        action,
        source,
    }
}
