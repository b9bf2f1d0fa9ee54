//! The damage of a part of a file has its error and the contents of the part.

use std::fmt;

use crate::finding::Severity;
use crate::io::{FunctionType, IoError};

/// A part of a file that cannot be read.
#[derive(Debug)]
pub struct Damage {
    /// The cause, with the position in the file.
    pub error: IoError,
    /// The contents of the part.
    pub part: Part,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.error.fmt(f)
    }
}

/// The contents of a part of a file, or its possible contents where its header is unreadable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Anything.
    Any,
    /// A record or function of unknown type.
    Function,
    /// A time record.
    Record,
    /// A frequency response function.
    Frf,
    /// A coherence, a variance, a spectrum or another function that modes are not computed from.
    Auxiliary,
    /// A mode shape.
    Mode,
    /// Nodes.
    Nodes,
    /// Coordinate systems.
    Systems,
    /// Units of the file; a value whose unit is lost with them is of unknown unit.
    Units,
    /// Trace lines, elements, groups, titles: no result depends on them.
    Other,
}

impl Part {
    /// The part that a function of a type is.
    pub fn of_function(function_type: FunctionType) -> Self {
        match function_type {
            FunctionType::Time => Part::Record,
            FunctionType::Frf => Part::Frf,
            FunctionType::Coherence | FunctionType::Variance | FunctionType::Other(_) => {
                Part::Auxiliary
            }
        }
    }

    /// The severity of the loss of the part.
    pub(in crate::io) fn severity(self) -> Severity {
        match self {
            Part::Auxiliary | Part::Other => Severity::Warning,
            _ => Severity::Error,
        }
    }
}
