//! Errors of a scene, of a model file or of the spec of a synthetic test.

use crate::correlate::CorrelateError;
use crate::frf::FrfError;
use crate::identify::IdentifyError;
use crate::io::IoError;
use crate::synth::SynthError;
use crate::theory::TheoryError;
use crate::update::UpdateError;

/// A failure of reading a scene or of a stage that it runs.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// TOML that does not parse or does not follow its schema.
    #[error("{}", fault_lines(path, faults, *all_found))]
    Toml {
        /// Path as given.
        path: String,
        /// Its faults, by place.
        faults: Vec<TomlFault>,
        /// Whether there are no others.
        all_found: bool,
    },
    /// A line of a drafted file that is not filled in yet.
    #[error(
        "{path}:{line}: {key} is to be filled in: {expected}{}",
        further_lines(others)
    )]
    Unfilled {
        /// Path as given.
        path: String,
        /// Line from 1.
        line: usize,
        /// Its key.
        key: String,
        /// The value that belongs there.
        expected: String,
        /// Further lines like it.
        others: Vec<usize>,
    },
    /// A value that parses but is not valid.
    #[error("{path}: {key}: got {got}, expected {expected}")]
    Value {
        /// Path as given.
        path: String,
        /// The key, with its table.
        key: String,
        /// The value as given.
        got: String,
        /// The accepted values.
        expected: String,
    },
    /// FRF estimation failed.
    #[error("test {test:?}: {source}")]
    Frf {
        /// Name of the test.
        test: String,
        /// The stage's reason.
        source: Box<FrfError>,
    },
    /// Identification failed.
    #[error("test {test:?}: {source}")]
    Identify {
        /// Name of the test.
        test: String,
        /// The stage's reason.
        source: Box<IdentifyError>,
    },
    /// Functions on different axes, or none.
    #[error("test {test:?}: got {}, expected FRFs on one axis", axes_text(*got))]
    Axes {
        /// Name of the test.
        test: String,
        /// Number of axes.
        got: usize,
    },
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] IoError),
    /// A model file that is not valid.
    #[error("{path}: {source}")]
    Model {
        /// Path as given.
        path: String,
        /// The model's reason.
        source: Box<TheoryError>,
    },
    /// The model failed.
    #[error(transparent)]
    Theory(#[from] TheoryError),
    /// The comparison failed.
    #[error(transparent)]
    Correlate(#[from] CorrelateError),
    /// The update failed.
    #[error(transparent)]
    Update(#[from] UpdateError),
    /// The synthetic test failed.
    #[error(transparent)]
    Synth(#[from] SynthError),
}

/// A fault of a TOML file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TomlFault {
    /// Line from 1.
    pub line: usize,
    /// Column from 1.
    pub column: usize,
    /// The text found, the accepted ones, and the nearest known key where an unknown one was
    /// given.
    pub message: String,
}

/// Maximum number of faults that a message lists.
const MAX_LISTED_FAULTS: usize = 20;

/// `scene.toml:3:1: got ...`; of several faults a line each, below their number.
fn fault_lines(path: &str, faults: &[TomlFault], all_found: bool) -> String {
    let line = |fault: &TomlFault| {
        let TomlFault {
            line,
            column,
            message,
        } = fault;
        format!("{path}:{line}:{column}: {message}")
    };
    match faults {
        [only] => line(only),
        _ => {
            let lines = faults.iter().take(MAX_LISTED_FAULTS).map(line);
            // A hint stands on a separate line.
            let lines = lines.map(|line| line.replace('\n', "\n    "));
            let further = faults.len().saturating_sub(MAX_LISTED_FAULTS);
            let further = (further > 0).then(|| format!("and {further} more"));
            let lines: Vec<String> = lines.chain(further).collect();
            let least = if all_found { "" } else { "at least " };
            format!(
                "{path}: {least}{} faults\n  {}",
                faults.len(),
                lines.join("\n  ")
            )
        }
    }
}

fn axes_text(count: usize) -> String {
    match count {
        0 => "no FRFs (what columns and arrays hold that say nothing of themselves is stated by [[test.channel]] of a scene)"
            .to_owned(),
        _ => format!("functions on {count} frequency axes"),
    }
}

fn further_lines(lines: &[usize]) -> String {
    let numbers: Vec<String> = lines.iter().map(ToString::to_string).collect();
    match numbers.len() {
        0 => String::new(),
        1 => format!(" (line {} as well)", numbers[0]),
        _ => format!(" (lines {} as well)", numbers.join(", ")),
    }
}

/// The error of a key, with the value got and the accepted ones; of a message with both,
/// `expected` is its second part.
pub(super) fn value_error(path: &str, key: &str, got: &str, expected: &str) -> SceneError {
    let second_part = expected
        .strip_prefix("got ")
        .and_then(|text| text.split_once(", expected "));
    let expected = second_part.map_or(expected, |(_, expected)| expected);
    SceneError::Value {
        path: path.to_owned(),
        key: key.to_owned(),
        got: got.to_owned(),
        expected: expected.to_owned(),
    }
}

/// The error of a model with the file that states it.
pub(super) fn model_error(path: &str, source: TheoryError) -> SceneError {
    SceneError::Model {
        path: path.to_owned(),
        source: Box::new(source),
    }
}
