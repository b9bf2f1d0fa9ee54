//! Errors of a scene, of a model file or of the spec of a synthetic test.

use std::path::Path;

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
    #[error("{path}{}: {key}: got {got}, expected {expected}", place_text(place.as_deref()))]
    Value {
        /// Path as given.
        path: String,
        /// Where the file has the key, as far as it does.
        place: Option<Box<Place>>,
        /// The key, with its table.
        key: String,
        /// The value as given.
        got: String,
        /// The accepted values.
        expected: String,
    },
    /// A property of a test's data that neither its files nor the scene states.
    #[error("{scene}{}: test {test:?}: {source}", place_text(place.as_deref()))]
    NotStated {
        /// Path of the scene.
        scene: String,
        /// Where the scene has the channel, else the test.
        place: Option<Box<Place>>,
        /// Name of the test.
        test: String,
        /// The file and the property.
        source: Box<IoError>,
    },
    /// Faults of a scene and of the files that it names.
    #[error("{}", several_lines(faults))]
    Several {
        /// The faults, two or more.
        faults: Vec<SceneError>,
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
    #[error("{path}{}: {source}", place_text(place.as_deref()))]
    Model {
        /// Path as given.
        path: String,
        /// Where the file has the part, as far as the error names one.
        place: Option<Box<Place>>,
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

/// A place in a text file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Line from 1.
    pub line: usize,
    /// Column from 1.
    pub column: usize,
}

/// `:3:1` behind a path.
fn place_text(place: Option<&Place>) -> String {
    place.map_or_else(String::new, |place| {
        format!(":{}:{}", place.line, place.column)
    })
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

/// The number of the faults, and a line for each.
fn several_lines(faults: &[SceneError]) -> String {
    let of_fault = |fault: &SceneError| match fault {
        SceneError::Toml { path, faults, .. } => {
            let alone = |fault: &TomlFault| fault_lines(path, std::slice::from_ref(fault), true);
            faults.iter().map(alone).collect()
        }
        other => vec![other.to_string()],
    };
    let groups = alike_faults(faults);
    let of_group = |group: &Vec<&SceneError>| match group.as_slice() {
        [first, others @ ..] if others.len() + 1 >= MIN_GROUPED_FAULTS => {
            vec![(group.len(), grouped_line(first, others))]
        }
        all => all
            .iter()
            .flat_map(|fault| of_fault(fault).into_iter().map(|line| (1, line)))
            .collect(),
    };
    let lines: Vec<(usize, String)> = groups.iter().flat_map(of_group).collect();
    let further: usize = lines
        .iter()
        .skip(MAX_LISTED_FAULTS)
        .map(|line| line.0)
        .sum();
    let further = (further > 0).then(|| format!("and {further} more"));
    let count: usize = lines.iter().map(|line| line.0).sum();
    let shown = lines.into_iter().take(MAX_LISTED_FAULTS).map(|line| line.1);
    // A hint stands on a separate line.
    let shown = shown.map(|line| line.replace('\n', "\n    "));
    let shown: Vec<String> = shown.chain(further).collect();
    let path = common_path(faults).map_or_else(String::new, |path| format!("{path}: "));
    format!("{path}{count} faults\n  {}", shown.join("\n  "))
}

/// Minimum number of faults of one cause that are one line. Smaller: faults that happen to be alike
/// lose their lines. Larger: a misspelt body of a model fills the message.
const MIN_GROUPED_FAULTS: usize = 4;

/// The faults, each with those of the same cause after it: a value that several tables of one kind
/// have, or files that are missing in one folder.
fn alike_faults(faults: &[SceneError]) -> Vec<Vec<&SceneError>> {
    let cause = |fault: &SceneError| match fault {
        SceneError::Value {
            path,
            key,
            got,
            expected,
            ..
        } => {
            let table = key.split(' ').next().unwrap_or_default();
            Some(format!("{path}\n{table}\n{got}\n{expected}"))
        }
        SceneError::Io(IoError::System { path, source, .. })
            if source.kind() == std::io::ErrorKind::NotFound =>
        {
            let folder = Path::new(path).parent()?;
            Some(folder.display().to_string())
        }
        _ => None,
    };
    let mut groups: Vec<(Option<String>, Vec<&SceneError>)> = Vec::new();
    for fault in faults {
        let cause = cause(fault);
        let is_same = |(known, _): &&mut (Option<String>, _)| cause.is_some() && *known == cause;
        match groups.iter_mut().find(is_same) {
            Some((_, group)) => group.push(fault),
            None => groups.push((cause, vec![fault])),
        }
    }
    groups.into_iter().map(|(_, group)| group).collect()
}

/// Maximum number of lines of a file that a group of faults lists.
const MAX_LISTED_LINES: usize = 3;

/// The first fault, and the number and first lines of the others of its cause.
fn grouped_line(first: &SceneError, others: &[&SceneError]) -> String {
    let lines = others.iter().filter_map(|fault| match fault {
        SceneError::Value { place, .. } => Some(place.as_ref()?.line.to_string()),
        _ => None,
    });
    let lines: Vec<String> = lines.take(MAX_LISTED_LINES).collect();
    let more = if others.len() > lines.len() {
        ", ..."
    } else {
        ""
    };
    let lines = match lines.is_empty() {
        true => String::new(),
        false => format!(": lines {}{more}", lines.join(", ")),
    };
    format!("{first} (and {} more like it{lines})", others.len())
}

/// The file of all faults, where it is one.
fn common_path(faults: &[SceneError]) -> Option<&str> {
    let mut paths = faults.iter().map(|fault| match fault {
        SceneError::Toml { path, .. }
        | SceneError::Value { path, .. }
        | SceneError::Model { path, .. } => Some(path.as_str()),
        _ => None,
    });
    let first = paths.next()??;
    paths.all(|path| path == Some(first)).then_some(first)
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
        place: None,
        key: key.to_owned(),
        got: got.to_owned(),
        expected: expected.to_owned(),
    }
}

/// The error of a model with the file that states it; several are a fault each.
pub(super) fn model_error(path: &str, source: TheoryError) -> SceneError {
    let of_file = |source: TheoryError| SceneError::Model {
        path: path.to_owned(),
        place: None,
        source: Box::new(source),
    };
    match source {
        TheoryError::Several { faults } => SceneError::Several {
            faults: faults.into_iter().map(of_file).collect(),
        },
        single => of_file(single),
    }
}
