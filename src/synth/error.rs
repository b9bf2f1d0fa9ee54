//! Errors state why a synthetic test cannot be computed.

use crate::dof::Dof;
use crate::quantity::Quantity;

/// An error of a truth or a test plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SynthError {
    /// A number outside its range.
    #[error("{name}: got {got} {unit}, expected {expected}")]
    OutOfRange {
        /// Which argument.
        name: &'static str,
        /// As given.
        got: f64,
        /// Its range.
        expected: &'static str,
        /// Its unit; empty for a plain number.
        unit: &'static str,
    },
    /// A property of a mode that is missing or outside its range.
    #[error("mode {mode}: got {name} {got:?} {unit}, expected {expected}")]
    Mode {
        /// Its number in the model, from 1.
        mode: usize,
        /// Which property.
        name: &'static str,
        /// As given; `None` when it is missing.
        got: Option<f64>,
        /// Its range.
        expected: &'static str,
        /// Its unit; empty for a plain number.
        unit: &'static str,
    },
    /// A mode without a residue at a pair of the plan.
    #[error(
        "mode {mode} at {frequency_hz} Hz: got no residue for {response}|{hit}, expected one in m/(N s)"
    )]
    MissingResidue {
        /// Its number in the model, from 1.
        mode: usize,
        /// Its natural frequency.
        frequency_hz: f64,
        /// Response of the pair.
        response: Dof,
        /// Hit of the pair.
        hit: Dof,
    },
    /// A mode shape without a degree of freedom of the plan.
    #[error("mode {mode}: got no shape component at {dof}, expected one")]
    MissingShape {
        /// Its number in the model, from 1.
        mode: usize,
        /// The degree of freedom.
        dof: Dof,
    },
    /// A free body without its rigid-body term at a pair of the plan.
    #[error("got no rigid-body accelerance for {response}|{hit}, expected one in 1/kg")]
    MissingRigidBody {
        /// Response of the pair.
        response: Dof,
        /// Hit of the pair.
        hit: Dof,
    },
    /// A response that does not stay bounded.
    #[error(
        "got {quantity} responses of a free body, expected acceleration: after a hit it drifts away"
    )]
    FreeBodyDrifts {
        /// The quantity asked for.
        quantity: Quantity,
    },
    /// A response quantity that is no response.
    #[error("got {quantity} as the response, expected displacement, velocity or acceleration")]
    NotAResponse {
        /// The quantity asked for.
        quantity: Quantity,
    },
    /// Neither a mode nor a rigid-body term.
    #[error("got a truth with 0 modes and no rigid-body accelerance, expected one of them")]
    EmptyTruth,
    /// A plan without a hit, or a hit without a response.
    #[error("test plan: got 0 {what}, expected 1 or more")]
    EmptyPlan {
        /// Hit points, responses, averages.
        what: &'static str,
    },
    /// A response that is listed twice for one hit.
    #[error("hit {hit}: got response {response} twice, expected each once (name repeats #2, #3)")]
    DuplicateResponse {
        /// The hit.
        hit: Dof,
        /// The response.
        response: Dof,
    },
    /// A hit index beyond the plan.
    #[error("got hit index {got}, expected less than {expected} (the hits of the plan)")]
    HitIndex {
        /// As given, from 0.
        got: usize,
        /// Number of hits of the plan.
        expected: usize,
    },
    /// A force that does not end inside the record.
    #[error("the force may last until {got_s} s, expected at most {expected_s} s (the record)")]
    PulseOutsideRecord {
        /// Latest end that can be drawn.
        got_s: f64,
        /// Record length.
        expected_s: f64,
    },
    /// A filter that lets no mode through.
    #[error(
        "filter edge: got {edge_hz} Hz, expected above the lowest mode at {lowest_mode_hz} Hz; raise the sampling rate"
    )]
    SamplingTooLow {
        /// Pass-band edge of the filter.
        edge_hz: f64,
        /// Lowest natural frequency.
        lowest_mode_hz: f64,
    },
    /// A mode whose pole is a filter pole: the partial fractions lose their digits.
    #[error(
        "mode {mode}: got a relative distance {got} to a pole of the filter, expected at least {expected}; move the filter's edge"
    )]
    PoleOnFilterPole {
        /// Its number in the model, from 1.
        mode: usize,
        /// |lambda − q| / |q|.
        got: f64,
        /// The least distance.
        expected: f64,
    },
}
