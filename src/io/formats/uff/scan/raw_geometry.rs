//! A universal file describes geometry and modes in file units, before they are placed.

use std::collections::BTreeSet;

use crate::io::formats::uff::geometry::nodes::RawNode;
use crate::io::formats::uff::geometry::systems::RawSystem;
use crate::io::formats::uff::modes::RawMode;

/// The collected geometry, in file units.
#[derive(Debug, Default)]
pub(super) struct RawGeometry {
    pub nodes: Vec<RawNode>,
    pub systems: Vec<RawSystem>,
    pub modes: Vec<RawMode>,
    pub model_name: String,
    /// Analysis types other than modes that were reported.
    pub passed_over: BTreeSet<i64>,
}
