//! A drafted scene names each exported file and the points that the file leaves open.

use std::collections::BTreeSet;
use std::fmt::Write;

use crate::dof::Dof;
use crate::io::Catalog;

use super::toml_text::{FILL_IN, quoted};

/// One exported file.
#[derive(Clone, Copy, Debug)]
pub struct DraftFile<'a> {
    /// Its path as the scene is to name it.
    pub path: &'a str,
    /// Contents of its headers.
    pub catalog: &'a Catalog,
    /// The response of records and FRFs that do not name one.
    pub response: Option<&'a Dof>,
    /// The excitation point of records and FRFs that do not name one.
    pub reference: Option<&'a Dof>,
    /// Whether part of it is bad, and its good part is sufficient.
    pub partial: bool,
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
            file.response,
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
