//! Noise of the FRFs: variance by FRF and line, the part common to a reference, correlation
//! between lines.
//!
//! Variances come with the data or are estimated from the residual of a fit. This room knows the
//! FRFs and residuals of `data`; it knows no method.
//!
//! Terms: *response noise*, noise of the output channel; *force noise*, noise of the input channel,
//! common to all FRFs of a reference; *line correlation*, correlation of noise between frequency
//! lines.

pub(in crate::identify) mod band_profile;
pub(in crate::identify) mod data_variance;
pub(in crate::identify) mod force_noise;
pub(in crate::identify) mod line_correlation;
pub(in crate::identify) mod model;
mod noise_factors;
pub(in crate::identify) mod residual_variance;
pub(in crate::identify) mod variance_model;
