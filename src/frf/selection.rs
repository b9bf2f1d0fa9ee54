//! A selection names the hits that are averaged.

use std::collections::BTreeSet;

use crate::signal::HitQualityLimits;

/// Which hits are averaged.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Their numbers, from 0.
    pub hits: Vec<usize>,
    /// Limits by which a single clipped response is left out of its function; `None` keeps all.
    pub overloads: Option<HitQualityLimits>,
    /// Hits of which no response is left out, from 0.
    pub accepted: BTreeSet<usize>,
}

impl Selection {
    /// So many hits from the first on, all of them as they are.
    pub fn all(count: usize) -> Self {
        Self {
            hits: (0..count).collect(),
            overloads: None,
            accepted: BTreeSet::new(),
        }
    }
}
