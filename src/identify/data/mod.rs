//! FRFs of a band, the model that is fitted to them, and their residual.
//!
//! This room holds the input of every method: receptances on the lines of the band and its guard
//! lines, the FRF matrix with outputs and inputs, poles with participation factors and residues,
//! the basis of the out-of-band terms. A method begins with
//! [`band_frfs::BandFrfs`]. This room knows no noise model, no method and no mode.
//!
//! Terms: *outputs × inputs*, the FRF matrix with the smaller side as input; *out-of-band terms*,
//! the contribution of modes outside the band; *line shape*, `1/(iω − λ)` or its mean under a
//! window; *half-power points*, the frequencies at which the power is half of that of a peak.

pub(in crate::identify) mod band_frfs;
pub(in crate::identify) mod chebyshev;
pub(in crate::identify) mod detection_spectrum;
pub(in crate::identify) mod frf_matrix;
pub(in crate::identify) mod frf_values;
pub(in crate::identify) mod half_power;
pub(in crate::identify) mod line_noise;
pub(in crate::identify) mod line_shape;
pub(in crate::identify) mod model_pole;
pub(in crate::identify) mod other_responses;
pub(in crate::identify) mod out_of_band_basis;
pub(in crate::identify) mod outlier_lines;
pub(in crate::identify) mod peak_detection;
pub(in crate::identify) mod prepare;
pub(in crate::identify) mod residual;
#[cfg(test)]
pub(in crate::identify) mod steady_random;
#[cfg(test)]
mod steady_random_tests;
