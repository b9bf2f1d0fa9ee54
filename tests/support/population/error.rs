//! Errors state why a member of a population cannot be drawn.

use modalign::synth::SynthError;
use modalign::theory::TheoryError;

/// An error of a population or of one of its members.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PopulationError {
    /// A population of another schema.
    #[error("population: got schema `{got}`, expected `{expected}`")]
    Schema {
        /// As written.
        got: String,
        /// The versions that are read.
        expected: &'static str,
    },
    /// A range from which nothing can be drawn.
    #[error("population, {part}: got {key} from {got_lo} to {got_hi}, expected {expected}")]
    Range {
        /// The test, or which member.
        part: String,
        /// The key.
        key: &'static str,
        /// Lower end.
        got_lo: f64,
        /// Upper end.
        got_hi: f64,
        /// The accepted values.
        expected: String,
    },
    /// A member that the population does not have.
    #[error(
        "population: got member {got_number} of kind {got_kind} (from 0), expected one of {counts:?} members"
    )]
    NoSuchMember {
        /// Kind, from 0.
        got_kind: usize,
        /// Member of the kind, from 0.
        got_number: usize,
        /// How many members each kind has.
        counts: Vec<usize>,
    },
    /// A drawn structure whose lowest root alone needs too long a record.
    #[error(
        "population: got a record of {got} samples, expected at most {expected}; allow more damping or more samples"
    )]
    RecordTooLong {
        /// Samples that the lowest root needs.
        got: usize,
        /// Largest number of samples.
        expected: usize,
    },
    /// A drawn structure that cannot be solved.
    #[error(transparent)]
    Theory(#[from] TheoryError),
    /// A drawn test that cannot be recorded.
    #[error(transparent)]
    Synth(#[from] SynthError),
}
