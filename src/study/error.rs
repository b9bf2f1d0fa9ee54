//! Why a study cannot be made.

use crate::frf::{FrfError, SetError};
use crate::identify::IdentifyError;
use crate::scene::SceneError;

use super::breakdown::BreakdownError;

/// A study that has no answer.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// Functions that make no set.
    #[error(transparent)]
    Set(#[from] SetError),
    /// FRFs could not be estimated.
    #[error(transparent)]
    Frf(#[from] FrfError),
    /// The refined solution, which others are held against, could not be found.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// The scene or a spec.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A map of where methods fail.
    #[error(transparent)]
    Breakdown(#[from] BreakdownError),
    /// A value that cannot be meant.
    #[error("{key}: got {got}, expected {expected}")]
    Value {
        /// The key, with its table.
        key: String,
        /// What was given.
        got: String,
        /// What would be accepted.
        expected: String,
    },
}
