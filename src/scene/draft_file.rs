//! A drafted scene names each exported file and the points that the file leaves open.

use std::collections::BTreeSet;
use std::fmt::Write;

use crate::dof::Dof;
use crate::io::{Catalog, FunctionType};

use super::toml_text::{FILL_IN, quoted};

/// One exported file.
#[derive(Clone, Copy, Debug)]
pub struct DraftFile<'a> {
    /// Its path as the scene is to name it.
    pub path: &'a str,
    /// Contents of its headers.
    pub catalog: &'a Catalog,
    /// The response of records and FRFs that do not name one; several for the columns of a table.
    pub responses: &'a [Dof],
    /// The excitation point of records and FRFs that do not name one.
    pub reference: Option<&'a Dof>,
    /// Units that it does not state.
    pub units: StatedUnits<'a>,
    /// Samples per second of a table without a time column.
    pub sampling_rate_hz: Option<f64>,
    /// Whether part of it is bad, and its good part is sufficient.
    pub partial: bool,
}

impl<'a> DraftFile<'a> {
    /// The response of the whole file.
    pub(super) fn response(&self) -> Option<&'a Dof> {
        match self.responses {
            [response] => Some(response),
            _ => None,
        }
    }
}

/// Units that the user states for files without them.
#[derive(Clone, Copy, Debug, Default)]
pub struct StatedUnits<'a> {
    /// Of forces.
    pub force: Option<&'a str>,
    /// Of responses.
    pub response: Option<&'a str>,
    /// Of FRFs.
    pub frf: Option<&'a str>,
}

/// Role of a file in a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Content {
    /// Recorded hits.
    Records,
    /// FRFs, perhaps with coherence.
    Functions,
    /// Finished modes.
    Modes,
    /// Columns or arrays whose meaning the file does not say.
    Arrays,
    /// No test data, such as geometry only.
    Nothing,
}

impl Content {
    pub(super) fn of(catalog: &Catalog) -> Self {
        let holds = |wanted| {
            catalog
                .entries
                .iter()
                .any(|entry| entry.function_type == wanted)
        };
        match catalog {
            _ if holds(FunctionType::Time) => Content::Records,
            _ if holds(FunctionType::Frf) => Content::Functions,
            file if !file.modes.is_empty() => Content::Modes,
            file if !file.arrays.is_empty() => Content::Arrays,
            _ => Content::Nothing,
        }
    }
}

/// `unit = "N"`, or the line to be filled in with the accepted units.
pub(super) fn unit_line(stated: Option<&str>, accepted: &str) -> String {
    match stated {
        Some(unit) => format!("unit = {}\n", quoted(unit)),
        None => format!("unit = \"{FILL_IN}\"   # {accepted}\n"),
    }
}

/// `[[test.file]]` with the points that a file leaves open.
pub(super) fn file_text(
    file: &DraftFile,
    response: bool,
    reference: bool,
    dofs: &mut BTreeSet<Dof>,
) -> String {
    let mut text = format!("[[test.file]]\npath = {}\n", quoted(file.path));
    let points = [
        (
            response,
            "response",
            file.response(),
            "point and direction of the sensor, such as 1:+Z",
        ),
        (
            reference,
            "reference",
            file.reference,
            "the hit point, such as 2:+Z",
        ),
    ];
    for (_, key, stated, what) in points.iter().filter(|point| point.0) {
        let _ = match stated {
            Some(dof) => writeln!(text, "{key} = \"{dof}\""),
            None => writeln!(text, "{key} = \"{FILL_IN}\"   # {what}"),
        };
        dofs.extend(stated.map(Dof::positive));
    }
    text
}
