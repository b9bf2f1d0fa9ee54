//! [`StudyError`] states why a study fails.

use crate::frf::{FrfError, SetError};
use crate::identify::IdentifyError;
use crate::scene::SceneError;

use super::breakdown::BreakdownError;

/// Cause of a failed study.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// Functions that make no set.
    #[error(transparent)]
    Set(#[from] SetError),
    /// FRFs could not be estimated.
    #[error(transparent)]
    Frf(#[from] FrfError),
    /// The maximum-likelihood solution, the reference for other methods, could not be found.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// The scene or a spec.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A map of where methods fail.
    #[error(transparent)]
    Breakdown(#[from] BreakdownError),
    /// An invalid value.
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
