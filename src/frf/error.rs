//! Errors state why FRFs cannot be estimated, converted or synthesised.

use crate::dof::Dof;
use crate::quantity::Quantity;
use crate::record::ReadError;
use crate::signal::SignalError;

use super::SetError;

/// A failure of the FRF stage.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FrfError {
    /// Nothing to estimate from.
    #[error("got 0 hits, expected at least 1")]
    NoHits,
    /// A hit without a response.
    #[error("{origin}: got 0 responses, expected at least 1")]
    NoResponse {
        /// Origin of the hit.
        origin: String,
    },
    /// One hit could not be conditioned.
    #[error(transparent)]
    Signal(#[from] SignalError),
    /// Forces of a hammer test without a pulse.
    #[error(
        "{origin}: got a force above a quarter of its peak in {got:.2} of the record, expected a pulse of a hammer, at most {expected}; for random or sine excitation state --excitation random or sine (`excitation` in [frf])"
    )]
    NoPulse {
        /// Origin of the first record.
        origin: String,
        /// Part of the record, the smallest of all records.
        got: f64,
        /// Largest part of a pulse.
        expected: f64,
    },
    /// A block of continuous excitation of an impossible length.
    #[error("got a block of {got_s} s, expected {shortest_s} to {longest_s} s")]
    BlockLength {
        /// Length, got, s.
        got_s: f64,
        /// Shortest, s.
        shortest_s: f64,
        /// A whole record, s.
        longest_s: f64,
    },
    /// A record that is over before its response begins, once all are cut to one length.
    #[error(
        "{origin}: got {got} samples from the hit to the end of the shortest record, expected at least {expected}; reject the hit that comes late in its record, or state cut_pretrigger = false"
    )]
    PulseAtEnd {
        /// Origin of the hit.
        origin: String,
        /// Samples, got.
        got: usize,
        /// Samples, expected.
        expected: usize,
    },
    /// A hit that the user names and that is not there.
    #[error("got hit {got} to accept or reject, expected 1 to {expected}")]
    HitNumber {
        /// Number, got.
        got: usize,
        /// Number of hits.
        expected: usize,
    },
    /// A hit that is both to be used and not.
    #[error("got hit {got} to accept and to reject, expected one of them")]
    HitInBoth {
        /// Number.
        got: usize,
    },
    /// Samples that could not be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A function that the set refuses.
    #[error(transparent)]
    Set(#[from] SetError),
    /// Hits of different length or sampling.
    #[error(
        "{origin}: got {got_len} samples of {got_step_s} s, expected {expected_len} of {expected_step_s} s as in {first}"
    )]
    AxisMismatch {
        /// Origin of the hit.
        origin: String,
        /// Samples, got.
        got_len: usize,
        /// Step, got, s.
        got_step_s: f64,
        /// Samples, expected.
        expected_len: usize,
        /// Step, expected, s.
        expected_step_s: f64,
        /// Origin of the first hit.
        first: String,
    },
    /// A reference that is not a force.
    #[error("{origin}, force channel {dof}: got {got} ({}), expected force (N)", got.si_unit())]
    NotAForce {
        /// Origin of the hit.
        origin: String,
        /// Hit point.
        dof: Dof,
        /// Got.
        got: Quantity,
    },
    /// A response of a quantity that has no FRF kind.
    #[error(
        "{origin}, response {dof}: got {got} ({}), expected displacement, velocity or acceleration",
        got.si_unit()
    )]
    NotAResponse {
        /// Origin of the hit.
        origin: String,
        /// Response.
        dof: Dof,
        /// Got.
        got: Quantity,
    },
    /// A response that changes its quantity from hit to hit.
    #[error("{origin}, response {dof}: got {got}, expected {expected} as in the hits before it")]
    QuantityMismatch {
        /// Origin of the hit.
        origin: String,
        /// Response.
        dof: Dof,
        /// Got.
        got: Quantity,
        /// Expected.
        expected: Quantity,
    },
    /// Two channels of one hit at one degree of freedom.
    #[error("{origin}: response {dof} is there twice; name repeated measurements #2, #3, ...")]
    DuplicateResponse {
        /// Origin of the hit.
        origin: String,
        /// Response.
        dof: Dof,
    },
    /// A stated noise ratio out of range.
    #[error(
        "got noise ratio {got} (response over force, SI units squared), expected a positive finite number"
    )]
    NoiseRatio {
        /// Got.
        got: f64,
    },
    /// Hv without a noise ratio.
    #[error(
        "Hv of {response}|{reference}: got noise before the hit of {response_noise:?} (response, SI squared) and {force_noise:?} (force, N squared), expected both positive; state the noise ratio"
    )]
    NoiseUnknown {
        /// Response.
        response: Dof,
        /// Reference.
        reference: Dof,
        /// Noise energy of the response in the windowed record; `None` without pre-trigger samples.
        response_noise: Option<f64>,
        /// The same of the force.
        force_noise: Option<f64>,
    },
    /// A line at which no hit excites.
    #[error(
        "{response}|{reference} at {frequency_hz} Hz (line {line}): got a force spectrum of 0 N s, expected the hits to excite every line"
    )]
    NoForce {
        /// Response.
        response: Dof,
        /// Reference.
        reference: Dof,
        /// Line, from 0.
        line: usize,
        /// Its frequency.
        frequency_hz: f64,
    },
    /// A line at which H2 or Hv is infinite.
    #[error(
        "{estimator} of {response}|{reference} at {frequency_hz} Hz (line {line}): got a cross spectrum of 0, expected force and response to be correlated; use H1"
    )]
    NotCorrelated {
        /// Estimator.
        estimator: &'static str,
        /// Response.
        response: Dof,
        /// Reference.
        reference: Dof,
        /// Line, from 0.
        line: usize,
        /// Its frequency.
        frequency_hz: f64,
    },
    /// No line above 0 Hz to call a band.
    #[error(
        "got a usable band of {lo_hz} to {hi_hz} Hz, expected at least two lines; the force excites none"
    )]
    BandEmpty {
        /// First line above 0.
        lo_hz: f64,
        /// Last usable line.
        hi_hz: f64,
    },
    /// A stated band in which the force excites nothing.
    #[error(
        "got the band {got_lo_hz} to {got_hi_hz} Hz (`band_hz`), expected one with lines that the force excites, {lo_hz} to {hi_hz} Hz"
    )]
    BandNotExcited {
        /// Lower end of the stated band.
        got_lo_hz: f64,
        /// Its upper end.
        got_hi_hz: f64,
        /// First line that the force excites.
        lo_hz: f64,
        /// Last such line.
        hi_hz: f64,
    },
    /// A frequency axis that is none.
    #[error(
        "got a frequency axis of {len} lines from {start_hz} Hz in steps of {step_hz} Hz, expected a start of 0 or more and a positive finite step"
    )]
    Axis {
        /// First line.
        start_hz: f64,
        /// Spacing.
        step_hz: f64,
        /// Lines.
        len: usize,
    },
    /// An added damping out of range.
    #[error("got added damping {got_rad_s} rad/s, expected 0 or more, finite")]
    AddedDamping {
        /// Got.
        got_rad_s: f64,
    },
    /// A mode without damping, which is no pole.
    #[error(
        "mode at {frequency_hz} Hz: got no damping ratio, expected one (a fraction) to synthesise from"
    )]
    DampingUnknown {
        /// Natural frequency.
        frequency_hz: f64,
    },
    /// A mode without the residue that is asked for.
    #[error("mode at {frequency_hz} Hz: got no residue of {response}|{reference}, expected one")]
    ResidueMissing {
        /// Natural frequency.
        frequency_hz: f64,
        /// Response.
        response: Dof,
        /// Reference.
        reference: Dof,
    },
    /// A pole on the line at which H is asked for.
    #[error(
        "mode at {pole_hz} Hz: got a pole on the line at {line_hz} Hz, expected it off the axis; H is infinite there"
    )]
    PoleOnLine {
        /// Natural frequency of the pole.
        pole_hz: f64,
        /// Line.
        line_hz: f64,
    },
}
