//! Weighted nonlinear least squares of poles, participation factors and residues, with covariances.
//!
//! Residues and out-of-band terms are linear and are eliminated (variable projection, Golub and
//! Pereyra 1973); poles and participation factors take Gauss-Newton steps. This room knows the FRFs
//! and the noise; it does not decide which poles are modes.
//!
//! Terms: *compressed band*, the lines of a band projected on a few functions of frequency around
//! stated poles; *detection threshold*, the value that noise alone exceeds with the stated
//! false-alarm probability.

mod band_segment;
pub(in crate::identify) mod block_descent;
pub(in crate::identify) mod compressed_band;
#[cfg(test)]
mod compressed_band_tests;
pub(in crate::identify) mod detection_threshold;
pub(in crate::identify) mod fit_data;
pub(in crate::identify) mod gauss_newton;
pub(in crate::identify) mod mode_strength;
pub(in crate::identify) mod pole_covariance;
pub(in crate::identify) mod residues;
pub(in crate::identify) mod shape_covariance;
pub(in crate::identify) mod shape_solution;
pub(in crate::identify) mod variable_projection;
