//! Maximum likelihood identification refines the initial poles of LSCF, tests them and adds missing
//! ones.
//!
//! The passes add poles where the residual has peaks, split close poles, reject spurious poles,
//! reduce the out-of-band terms and estimate the noise anew. The head of `estimator` lists them.
//! This module uses all modules of `identify` below it and `run_variation`; `modes` builds mode
//! shapes from its result.
//!
//! Terms: *spurious pole*, a pole of the mathematical model that is no mode of the structure;
//! *modal contribution*, the fraction of the response energy near a pole that this pole explains;
//! *trial pole*, a pole that is kept if the likelihood rises enough.

pub(in crate::identify) mod acceptance;
pub(in crate::identify) mod amplitude_dependence;
pub(in crate::identify) mod close_pole_test;
pub(in crate::identify) mod estimator;
pub(in crate::identify) mod findings;
pub(in crate::identify) mod leakage;
pub(in crate::identify) mod misfit;
pub(in crate::identify) mod multiplicity;
pub(in crate::identify) mod narrower_bands;
pub(in crate::identify) mod out_of_band;
pub(in crate::identify) mod pole_metrics;
pub(in crate::identify) mod residual_peaks;
pub(in crate::identify) mod spurious_poles;
pub(in crate::identify) mod trial_poles;
