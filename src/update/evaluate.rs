//! An evaluation holds the models at one set of parameters: modes, their pairs with measured roots,
//! residuals.

use super::{ModelState, RootPair};

/// Largest excess of `chi^2` over `nu` that noise explains, in standard deviations `sqrt(2 nu)`.
const MAX_CHI_SQUARE_STDS: f64 = 2.0;

/// The models at one point.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// The free parameters, each in its prior deviations from where it starts.
    pub z: Vec<f64>,
    /// Measured roots paired with roots of the models, those of each configuration together.
    pub root_pairs: Vec<RootPair>,
    /// The model of each configuration.
    pub states: Vec<ModelState>,
    /// Residuals of the data, divided by their deviations; then `z`.
    pub residual: Vec<f64>,
    /// Number of residuals of data.
    pub data_rows: usize,
}

impl Evaluation {
    /// All parameters of the model of the first configuration.
    pub fn values(&self) -> &[f64] {
        &self.states[0].values
    }

    /// `sum r^2 + sum z^2`, which the update minimises.
    pub fn objective(&self) -> f64 {
        self.residual.iter().map(|r| r * r).sum()
    }

    /// `sum r^2` over the data.
    pub fn chi_square(&self) -> f64 {
        let data = &self.residual[..self.data_rows];
        data.iter().map(|r| r * r).sum()
    }
}

/// Largest `chi^2` that noise explains: `nu + 2 sqrt(2 nu)`.
pub(super) fn max_chi_square(nu: f64) -> f64 {
    nu + MAX_CHI_SQUARE_STDS * (2.0 * nu).sqrt()
}
