//! Hammer records are conditioned for FRF estimation: pulse location, pre-trigger noise, hit
//! quality, windows.
//!
//! Holds what is done to one hit alone, and how far a hit can be trusted. It must not hold an FRF
//! that is kept, or a mode: that is the FRF stage.

mod conditioning;
mod error;
mod hit_quality;
mod impact_detection;
mod pulse;
mod simd_sums;
mod window;

pub use conditioning::{
    Conditioning, Frame, Offset, check_axis, cut_force_fraction, locate_pulse, pretrigger_offset,
    to_si,
};
pub use error::SignalError;
pub use hit_quality::{
    Check, Drift, HitQualityLimits, Outcome, ResponseRecord, Rule, assess_force, assess_levels,
    assess_response, drift_of, inconsistent_hits, least_delay_samples, overloaded,
};
pub use impact_detection::{Segment, Segments, TriggerOptions, segments};
pub use pulse::{ONSET_FRACTION, PretriggerNoise, Pulse};
pub use simd_sums::{Extent, lane_count, lane_moments, lane_sum, lane_sum_of_pairs};
pub use window::{ExponentialWindow, ForceWindow};
