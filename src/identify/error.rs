//! Errors stop an identification; observations on the data are findings, not errors.

use crate::dof::Dof;
use crate::linalg::LinalgError;

/// Cause that stops an identification.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// An unknown method.
    #[error("got identification method `{got}`, expected one of {}", known.join(" "))]
    UnknownMethod {
        /// As given.
        got: String,
        /// Names of all methods.
        known: Vec<&'static str>,
    },
    /// A model order for a method without one.
    #[error(
        "got a model order for method `{got}`, expected one of {}",
        known.join(" ")
    )]
    NoOrder {
        /// The method.
        got: &'static str,
        /// Methods with a model order.
        known: Vec<&'static str>,
    },
    /// A number outside its range.
    #[error("got {name} = {got}, expected {expected}")]
    OptionOutOfRange {
        /// Name of the option.
        name: &'static str,
        /// As given.
        got: f64,
        /// Accepted range.
        expected: &'static str,
    },
    /// A band that is not inside the data.
    #[error(
        "got band {got_lo_hz} to {got_hi_hz} Hz (--band, or `band_hz` of a scene), expected a band inside the data, {lo_hz} to {hi_hz} Hz"
    )]
    BandOutside {
        /// Lower edge as given, Hz.
        got_lo_hz: f64,
        /// Upper edge as given, Hz.
        got_hi_hz: f64,
        /// Lowest frequency of the data above zero, Hz.
        lo_hz: f64,
        /// Highest frequency of the data, Hz.
        hi_hz: f64,
    },
    /// A set without functions.
    #[error("got a set of 0 functions, expected at least 1")]
    NoFunctions,
    /// A reference that no FRF has.
    #[error(
        "got reference {got}, expected one of the set's references: {}",
        join(known)
    )]
    UnknownReference {
        /// As given.
        got: Dof,
        /// References of the set.
        known: Vec<Dof>,
    },
    /// A band with too few lines for a resonance.
    #[error("got {got} frequency lines in the band, expected at least {expected}")]
    TooFewLines {
        /// Lines in the band.
        got: usize,
        /// Minimum number of lines.
        expected: usize,
    },
    /// A value that is not finite.
    #[error("{response}|{reference} at {hz} Hz: got {got}, expected a finite {what}")]
    NotFinite {
        /// Response.
        response: Dof,
        /// Reference.
        reference: Dof,
        /// Frequency of the line, Hz.
        hz: f64,
        /// Checked quantity: value or variance.
        what: &'static str,
        /// As found.
        got: String,
    },
    /// A matrix problem without a solution.
    #[error(transparent)]
    Linalg(#[from] LinalgError),
}

fn join(dofs: &[Dof]) -> String {
    let names: Vec<String> = dofs.iter().map(ToString::to_string).collect();
    names.join(" ")
}
