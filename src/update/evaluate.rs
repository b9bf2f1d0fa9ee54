//! An evaluation holds the model at one set of parameters: modes, links to the test, residuals.

use crate::theory::{SystemMatrices, TheoryModes};

use super::Link;

/// A residual is at its uncertainty when `chi^2` is no more than this many deviations `sqrt(2 nu)`
/// above `nu`.
const DEVIATIONS: f64 = 2.0;

/// The model at one point.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// The free parameters, each in its prior deviations from where it starts.
    pub z: Vec<f64>,
    /// All parameters of the model.
    pub values: Vec<f64>,
    /// Assignment of targets to modes.
    pub links: Vec<Link>,
    /// All modes of the model, without sensors.
    pub modes: TheoryModes,
    /// Residuals of the data, divided by their deviations; then `z`.
    pub residual: Vec<f64>,
    /// How many of them are of data.
    pub data_rows: usize,
    pub(super) matrices: SystemMatrices,
}

impl Evaluation {
    /// `sum r^2 + sum z^2`, which is made smallest.
    pub fn objective(&self) -> f64 {
        self.residual.iter().map(|r| r * r).sum()
    }

    /// `sum r^2` over the data.
    pub fn chi_square(&self) -> f64 {
        let data = &self.residual[..self.data_rows];
        data.iter().map(|r| r * r).sum()
    }
}

/// `nu + 2 sqrt(2 nu)`.
pub(super) fn largest_chi_square(nu: f64) -> f64 {
    nu + DEVIATIONS * (2.0 * nu).sqrt()
}
