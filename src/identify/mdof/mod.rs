//! Multi-degree-of-freedom methods of rising model order: RFP, LSCE, polyreference LSCF.
//!
//! Each method gives the poles of all orders. Poles that recur over orders are candidates, and
//! their residues follow by linear least squares.
//!
//! Terms: *stable pole*, a pole that recurs over model orders within tolerances; *pole track*, the
//! poles of rising orders that continue each other.

pub(in crate::identify) mod estimator;
pub(in crate::identify) mod lsce;
pub(in crate::identify) mod lscf;
#[cfg(test)]
mod lscf_tests;
pub(in crate::identify) mod normal_equations;
pub(in crate::identify) mod peak_columns;
pub(in crate::identify) mod plscf;
pub(in crate::identify) mod pole_tracks;
pub(in crate::identify) mod rfp;
pub(in crate::identify) mod stabilization;
pub(in crate::identify) mod z_plane;
