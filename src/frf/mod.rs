//! Frequency response functions: estimation from hits, coherence and variance, conversion and synthesis.
//!
//! | type or function | what |
//! |---|---|
//! | [`FrfSet`] | functions on one axis with coherence and variance |
//! | [`estimate`] | hits to a set: H1, H2, Hv (Bendat and Piersol 2010; Rocklin, Crowley and Vold 1985) |
//! | [`truncation_bounds`] | how wrong H is because the record ends, from the record itself |
//! | [`usable_band`] | where the force excites and the anti-alias filter is open |
//! | [`convert`] | receptance, mobility and accelerance into each other |
//! | [`synthesise`] | poles and residues to a set |
//!
//! Values are SI in the kind that the function states. It identifies no mode and reads no file.

mod coherence;
mod convert;
mod error;
mod estimate;
mod set;
mod sums;
mod synthesise;
mod truncation;
mod usable;
mod variance;

#[cfg(test)]
mod decay_tests;
#[cfg(test)]
mod estimate_tests;
#[cfg(test)]
mod recording_tests;

pub use convert::convert;
pub use error::FrfError;
pub use estimate::{EstimateOptions, estimate, truncation_bounds};
pub use set::{Estimator, FrfSet, Function, FunctionData, SetError};
pub use synthesise::{Residues, modal_terms, synthesise};
pub use truncation::{TRUNCATION_LIMIT, Truncation};
pub use usable::usable_band;
