//! [`BreakdownError`] states why a breakdown map fails.

use crate::scene::SceneError;
use crate::synth::SynthError;

/// A breakdown map that cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BreakdownError {
    /// The spec as text.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A case that no draw can be made of.
    #[error("slice {slice}: {source}")]
    Synth {
        /// The slice.
        slice: String,
        /// What is wrong with it.
        source: Box<SynthError>,
    },
    /// An invalid value of the spec.
    #[error("{key}: got {got}, expected {expected}")]
    Value {
        /// The key, with its table.
        key: String,
        /// What was given.
        got: String,
        /// What would be accepted.
        expected: String,
    },
    /// A finished slice that was computed from another spec.
    #[error(
        "slice {slice}: got cells of another spec ({got}), expected those of this one ({expected}); repeat the options that it was computed with, such as --draws, or compute it again"
    )]
    OtherSpec {
        /// The slice.
        slice: String,
        /// First digits of the hash of the spec that the cells were computed from.
        got: String,
        /// First digits of the hash of this spec.
        expected: String,
    },
    /// A slice that no part of a batch has.
    #[error(
        "slice {slice}: got no finished cells in any of the folders, expected those of one --cells part"
    )]
    Unfinished {
        /// The slice.
        slice: String,
    },
    /// A store that cannot keep or give back.
    #[error("slice {slice}: {message}")]
    Store {
        /// The slice.
        slice: String,
        /// What the store said.
        message: String,
    },
}
