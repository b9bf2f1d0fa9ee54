//! A model state holds the model of one configuration at one point: values, modes, matrices.

use crate::theory::{SystemMatrices, TheoryModes};

/// The model of one configuration at one point.
#[derive(Clone, Debug)]
pub struct ModelState {
    /// All parameters of the model.
    pub values: Vec<f64>,
    /// All its modes, without sensors.
    pub modes: TheoryModes,
    pub(super) matrices: SystemMatrices,
}
