//! Maximum likelihood identification refines the initial poles of LSCF, tests them and adds missing
//! ones.
//!
//! The passes add poles where the residual has peaks, split close poles, reduce the out-of-band
//! terms and estimate the noise anew. The head of `estimator` lists them; `pole_model` holds the
//! poles and their tests.
//!
//! Term: *trial pole*, a pole that is kept if the likelihood rises enough.

pub(in crate::identify) mod amplitude_dependence;
pub(in crate::identify) mod close_pole_test;
pub(in crate::identify) mod estimator;
pub(in crate::identify) mod leakage;
pub(in crate::identify) mod out_of_band;
pub(in crate::identify) mod residual_peaks;
pub(in crate::identify) mod trial_poles;
