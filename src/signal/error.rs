//! Errors state why a hit cannot be conditioned.

use crate::dof::Dof;

/// A hit or an option that the signal stage cannot use.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SignalError {
    /// A time step that is not positive and finite.
    #[error("{origin}: got a time step of {got_s} s, expected a positive finite one")]
    TimeStep {
        /// Origin of the hit.
        origin: String,
        /// Got, s.
        got_s: f64,
    },
    /// A record too short to transform.
    #[error("{origin}: got {got} samples, expected at least {expected}")]
    TooShort {
        /// Origin of the hit.
        origin: String,
        /// Got.
        got: usize,
        /// Expected at least.
        expected: usize,
    },
    /// A channel whose samples are not as many as the time axis says.
    #[error(
        "{origin}, channel {dof}: got {got} samples, expected {expected} (the time axis of the hit)"
    )]
    SampleCount {
        /// Origin of the hit.
        origin: String,
        /// Channel.
        dof: Dof,
        /// Got.
        got: usize,
        /// Expected.
        expected: usize,
    },
    /// A factor to SI that is zero or not finite.
    #[error("{origin}, channel {dof}: got factor to SI {got}, expected a finite one other than 0")]
    Calibration {
        /// Origin of the hit.
        origin: String,
        /// Channel.
        dof: Dof,
        /// Got.
        got: f64,
    },
    /// A sample that is not a number.
    #[error("{origin}, channel {dof}: got {got} at sample {sample}, expected a finite number")]
    NotFinite {
        /// Origin of the hit.
        origin: String,
        /// Channel.
        dof: Dof,
        /// Sample, from 0.
        sample: usize,
        /// Got, as stored.
        got: f64,
    },
    /// A force that never leaves its level.
    #[error("{origin}, force {dof}: got a constant force of {got_n} N, expected a pulse")]
    NoPulse {
        /// Origin of the hit.
        origin: String,
        /// Hit point.
        dof: Dof,
        /// The constant, N.
        got_n: f64,
    },
    /// A continuous record in which nothing stands above the trigger level.
    #[error(
        "got a largest force of {largest_n} N from its level over noise of {noise_n} N, expected a pulse above the trigger level of {level_n} N"
    )]
    NoHit {
        /// The sample furthest from the level of the force, with its sign, N.
        largest_n: f64,
        /// Standard deviation of the noise, N.
        noise_n: f64,
        /// Trigger level, N.
        level_n: f64,
    },
    /// A sample of a continuous force record that is not a number.
    #[error("got a force of {got} N at sample {sample}, expected a finite number")]
    ForceNotFinite {
        /// Sample, from 0.
        sample: usize,
        /// Got.
        got: f64,
    },
    /// An offset that is to be removed but cannot be measured.
    #[error(
        "{origin}, channel {dof}: got {got} pre-trigger samples, expected at least {expected} to remove the offset"
    )]
    NoPreTrigger {
        /// Origin of the hit.
        origin: String,
        /// Channel.
        dof: Dof,
        /// Got.
        got: usize,
        /// Expected at least.
        expected: usize,
    },
    /// A window parameter outside its range.
    #[error("got {parameter} = {got} {unit}, expected {expected}")]
    WindowParameter {
        /// Name of the parameter.
        parameter: &'static str,
        /// Got.
        got: f64,
        /// Its unit, empty for a plain number.
        unit: &'static str,
        /// The accepted values.
        expected: &'static str,
    },
    /// A limit of the hit quality outside its range.
    #[error(
        "got limit {parameter} = {got}, expected a positive finite one (a probability below 1, a factor of 1 or more, a limit of rejection not below that of a note)"
    )]
    HitQualityLimit {
        /// Name of the limit.
        parameter: &'static str,
        /// Got.
        got: f64,
    },
}
