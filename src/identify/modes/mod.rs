//! Modes are formed from the poles of any method: shapes and modal scale from residues, the modes
//! of repeated poles, and the selection by the user.
//!
//! Term: *rank-one term*, one summand of the residue matrix of a repeated pole.

pub(in crate::identify) mod modal_model;
pub(in crate::identify) mod pole_selection;
#[cfg(test)]
mod pole_selection_tests;
pub(in crate::identify) mod quality;
pub(in crate::identify) mod rank_one_terms;
#[cfg(test)]
mod rank_one_terms_tests;
pub(in crate::identify) mod shape;
#[cfg(test)]
mod shape_tests;
