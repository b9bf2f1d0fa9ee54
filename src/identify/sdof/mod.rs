//! Single-degree-of-freedom methods: peak-picking, circle fit, line fit, one resonance at a time.
//!
//! A peak of the detection spectrum gives initial values; each method refines them and states its
//! scatter over FRFs. These methods have no model order and use none of the multi-degree-of-freedom
//! methods.
//!
//! Term: *damping surface*, damping estimates over all pairs of lines on both sides of the
//! resonance.

pub(in crate::identify) mod circle_detail;
pub(in crate::identify) mod circle_fit;
pub(in crate::identify) mod estimator;
pub(in crate::identify) mod findings;
pub(in crate::identify) mod line_fit;
pub(in crate::identify) mod peak_picking;
pub(in crate::identify) mod repeated_poles;
#[cfg(test)]
mod repeated_poles_tests;
pub(in crate::identify) mod single_mode_method;
pub(in crate::identify) mod single_mode_test;
#[cfg(test)]
mod single_mode_test_tests;
pub(in crate::identify) mod weighted_mean;
