//! The error of the crate has one variant per stage. Each stage returns the error of its module;
//! callers that run several stages use this one.

use crate::correlate::CorrelateError;
use crate::frf::FrfError;
use crate::identify::IdentifyError;
use crate::io::IoError;
use crate::scene::SceneError;
use crate::study::StudyError;
use crate::synth::SynthError;
use crate::theory::TheoryError;

/// A failure of any stage.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Reading or writing a file.
    #[error(transparent)]
    Io(#[from] IoError),
    /// Estimating FRFs.
    #[error(transparent)]
    Frf(#[from] FrfError),
    /// Identifying modes.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// The theoretical model.
    #[error(transparent)]
    Theory(#[from] TheoryError),
    /// Comparing test and theory.
    #[error(transparent)]
    Correlate(#[from] CorrelateError),
    /// A synthetic test.
    #[error(transparent)]
    Synth(#[from] SynthError),
    /// A scene, or a stage that it ran.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A study of methods.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// Standard output.
    #[error("standard output: {0}")]
    Output(#[source] std::io::Error),
    /// An argument of the command line that a stage cannot take.
    #[error("{argument}: got {got}, expected {expected}")]
    Argument {
        /// Which argument.
        argument: &'static str,
        /// What was given.
        got: String,
        /// What would be accepted.
        expected: String,
    },
}

impl Error {
    /// Whether the reader of standard output has gone away, which is no failure.
    pub fn is_broken_pipe(&self) -> bool {
        matches!(self, Error::Output(source) if source.kind() == std::io::ErrorKind::BrokenPipe)
    }
}
