//! Hammer records before they are FRFs: where the pulse is, what the channels do before it, windows, spectra.
//!
//! Holds what is done to one hit alone. It must not hold anything that needs two hits, a response over a force,
//! or a mode: that is the FRF stage.

mod condition;
mod error;
mod pulse;
mod spectrum;
mod window;

pub use condition::{ConditionedChannel, ConditionedHit, Conditioning, condition};
pub use error::SignalError;
pub use pulse::{ONSET_FRACTION, PreTrigger, Pulse};
pub use spectrum::{HitSpectra, hit_spectra};
pub use window::{ExponentialWindow, ForceWindow};
