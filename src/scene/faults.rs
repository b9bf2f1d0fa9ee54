//! Faults of a scene and of the files that it names are collected, so that one run names all.

use serde::de::DeserializeOwned;

use crate::theory::{Fault, TheoryError};

use super::error::SceneError;
use super::places::located;
use super::toml_faults::SUBSTITUTE_TEXT;
use super::toml_text::parse_repaired;

pub(super) use crate::theory::Faults;

impl Fault for SceneError {
    fn split(self) -> Vec<Self> {
        match self {
            SceneError::Several { faults } => faults.into_iter().flat_map(Fault::split).collect(),
            // One with further faults says so and stays whole.
            SceneError::Toml {
                path,
                faults,
                all_found: true,
            } if faults.len() > 1 => {
                let alone = |fault| SceneError::Toml {
                    path: path.clone(),
                    faults: vec![fault],
                    all_found: true,
                };
                faults.into_iter().map(alone).collect()
            }
            single => vec![single],
        }
    }

    fn several(faults: Vec<Self>) -> Self {
        SceneError::Several { faults }
    }
}

impl Faults<SceneError> {
    /// The value that was checked.
    ///
    /// # Errors
    /// The faults, where there is one or no value.
    pub fn finish<T>(self, value: Option<T>) -> Result<T, SceneError> {
        let none = SceneError::Several { faults: Vec::new() };
        self.into_result().and_then(|()| value.ok_or(none))
    }

    /// The faults with their places in a file, those of the file first, by line.
    pub fn located(self, file: &str, text: &str) -> Self {
        let faults = self.0.into_iter();
        let mut faults: Vec<SceneError> = faults.map(|fault| located(fault, file, text)).collect();
        let line = |fault: &SceneError| match fault {
            SceneError::Toml { path, faults, .. } if path == file => {
                faults.first().map_or(0, |fault| fault.line)
            }
            SceneError::Value { path, place, .. }
            | SceneError::Model { path, place, .. }
            | SceneError::NotStated {
                scene: path, place, ..
            } if path == file => place.as_ref().map_or(0, |place| place.line),
            _ => usize::MAX,
        };
        faults.sort_by_key(line);
        Faults(faults)
    }
}

/// Whether a value that is checked is that of its file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Soundness {
    /// It is.
    Sound,
    /// The file has faults, the places of which were repaired for further checks.
    Repaired,
}

/// What a check makes of a parsed file. Where the file has faults, those that the check finds in
/// its other parts are named with them.
///
/// # Errors
/// The faults with their places.
pub(super) fn parse_checked<T: DeserializeOwned, M>(
    text: &str,
    path: &str,
    check: impl FnOnce(T, Soundness) -> Result<M, SceneError>,
) -> Result<M, SceneError> {
    let mut faults = Faults::default();
    let faulty = match parse_repaired(text, path) {
        Ok(value) => {
            let checked = faults.take(check(value, Soundness::Sound));
            return faults.located(path, text).finish(checked);
        }
        Err(faulty) => faulty,
    };
    faults.add(faulty.error);
    if let Some(repaired) = faulty.repaired {
        let mut further = Faults::default();
        further.take(check(repaired, Soundness::Repaired));
        let further = further.located(path, text);
        let repairs = Repairs {
            path,
            text,
            substituted_lines: faulty.substituted_lines,
            misspelt_keys: faulty.misspelt_keys,
        };
        let is_sound = |fault: &SceneError| repairs.leave(fault);
        let sound = further.0.into_iter().filter(is_sound);
        sound.for_each(|fault| faults.add(fault));
    }
    faults.located(path, text).finish(None)
}

/// Whether a fault is about the value of one key, whatever the others of its table are: a parameter
/// that is not declared, a number outside its range.
fn is_of_one_key(fault: &SceneError) -> bool {
    match fault {
        SceneError::Model { source, .. } => matches!(
            **source,
            TheoryError::UnknownParameter { .. }
                | TheoryError::PropertyOutOfRange { .. }
                | TheoryError::Duplicate { .. }
        ),
        SceneError::Value { key, .. } => key.starts_with("[pair] "),
        _ => false,
    }
}

/// The repairs of a file.
struct Repairs<'a> {
    path: &'a str,
    text: &'a str,
    substituted_lines: Vec<usize>,
    misspelt_keys: Vec<(usize, String)>,
}

impl Repairs<'_> {
    /// Whether a fault of the repaired file is one of the file itself: it names no repaired part,
    /// its table has none or decides nothing about it, and it is not about a key that is misspelt
    /// there.
    fn leave(&self, fault: &SceneError) -> bool {
        let message = fault.to_string();
        let (path, place) = match fault {
            SceneError::Value { path, place, .. } | SceneError::Model { path, place, .. } => {
                (path.as_str(), place.as_deref())
            }
            _ => return !message.contains(SUBSTITUTE_TEXT),
        };
        if message.contains(SUBSTITUTE_TEXT) || path != self.path {
            return !message.contains(SUBSTITUTE_TEXT);
        }
        place.is_some_and(|place| {
            let is_same_table = |line: usize| self.head(line) == self.head(place.line);
            if is_of_one_key(fault) && !self.substituted_lines.contains(&place.line) {
                return true;
            }
            let mut substituted = self.substituted_lines.iter();
            let mut misspelt = self.misspelt_keys.iter();
            !substituted.any(|line| is_same_table(*line))
                && !misspelt.any(|(line, key)| is_same_table(*line) && message.contains(key))
        })
    }

    /// The line of the head of the table to which a line belongs; `None` above the first.
    fn head(&self, line: usize) -> Option<usize> {
        let lines: Vec<&str> = self.text.lines().take(line).collect();
        // A row of an array begins with a number or a text.
        let is_name = |c: char| c.is_alphabetic() || c == '_';
        let is_head = |line: &&str| {
            let name = line.trim_start();
            name.starts_with('[') && name.trim_start_matches('[').starts_with(is_name)
        };
        lines.iter().rposition(is_head)
    }
}
