//! Hammer records before they are FRFs: where the pulse is, what the channels do before it,
//! windows.
//!
//! Holds what is done to one hit alone, and how far a hit can be trusted. It must not hold an FRF
//! that is kept, or a mode: that is the FRF stage.

mod condition;
mod error;
mod judge;
mod lanes;
mod pulse;
mod segment;
mod window;

pub use condition::{Conditioning, Frame, Offset, check_axis, force_cut, locate, offset_of, to_si};
pub use error::SignalError;
pub use judge::{
    Check, Drift, JudgeLimits, Outcome, ResponseRecord, Rule, drift_of, judge_force, judge_levels,
    judge_response, least_delay_samples, odd_one_out, overloaded,
};
pub use lanes::{Extent, lane_count, lane_moments, lane_sum, lane_sum_of_pairs};
pub use pulse::{ONSET_FRACTION, PreTrigger, Pulse};
pub use segment::{Segment, Segments, TriggerOptions, segments};
pub use window::{ExponentialWindow, ForceWindow};
