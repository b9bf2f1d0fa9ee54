//! The support of a structure: how a test holds it, or how a model holds it.

use serde::{Deserialize, Serialize};

/// How a structure is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Support {
    /// Free, in soft slings or on soft foam: the rigid-body modes lie far below the elastic ones.
    Suspended,
    /// On a frame or a foundation that does not move.
    Fixed,
    /// On the mounts or the test rig of its operation, which are elastic.
    Mounted,
}

impl Support {
    /// The name as scenes and models state it.
    pub fn name(self) -> &'static str {
        match self {
            Support::Suspended => "suspended",
            Support::Fixed => "fixed",
            Support::Mounted => "mounted",
        }
    }
}
