//! The location of a finding: a file position, a hit, a function, a mode or a parameter.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::dof::Dof;

use super::format_hz;

/// Location of a finding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Location {
    /// The whole test or result.
    Whole,
    /// A position in a file.
    File {
        /// Path as given.
        path: String,
        /// Line (from 1), for text.
        line: Option<u64>,
        /// Byte offset (from 0), for binary data.
        byte: Option<u64>,
    },
    /// A hit, by its number from 1.
    Hit(usize),
    /// A response of a hit.
    HitChannel {
        /// Number of the hit, from 1.
        hit: usize,
        /// Response degree of freedom.
        dof: Dof,
    },
    /// A channel or a function by its response and, for FRFs, its reference.
    Function {
        /// Response degree of freedom.
        response: Option<Dof>,
        /// Reference (hit) degree of freedom.
        reference: Option<Dof>,
    },
    /// A group of sensors, by its name.
    Sensors(String),
    /// A mode, by its frequency in Hz.
    Mode(f64),
    /// A model or option parameter, by name.
    Parameter(String),
    /// A derived quantity of a model, by its name.
    Quantity(String),
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Location::Whole => f.write_str("whole test"),
            Location::File { path, line, byte } => {
                f.write_str(path)?;
                line.map_or(Ok(()), |n| write!(f, ":{n}"))?;
                byte.map_or(Ok(()), |n| write!(f, " at byte {n}"))
            }
            Location::Hit(n) => write!(f, "hit {n}"),
            Location::HitChannel { hit, dof } => write!(f, "hit {hit} {dof}"),
            Location::Function {
                response,
                reference,
            } => {
                let name = |dof: &Option<Dof>| {
                    dof.as_ref()
                        .map_or_else(|| "?".to_owned(), ToString::to_string)
                };
                match reference {
                    Some(_) => write!(f, "{}|{}", name(response), name(reference)),
                    None => write!(f, "channel {}", name(response)),
                }
            }
            Location::Sensors(group) => write!(f, "sensors of {group}"),
            Location::Mode(hz) => write!(f, "mode at {}", format_hz(*hz)),
            Location::Parameter(name) => write!(f, "parameter {name}"),
            Location::Quantity(name) => write!(f, "quantity {name}"),
        }
    }
}
