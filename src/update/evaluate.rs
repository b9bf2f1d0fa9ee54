//! An evaluation holds the models at one set of parameters: modes, their pairs with measured roots,
//! residuals.

use statrs::distribution::{ChiSquared, ContinuousCDF};

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

/// Largest `chi^2/nu` at which the stated uncertainties are said to exceed the errors, by two.
/// Larger, at 0.8: said of an update whose residuals are noise. Smaller, at 0.01: not said where
/// they are nine times the errors. Test `uncertainties_that_exceed_the_errors_are_named`.
const MAX_SMALL_REDUCED_CHI_SQUARE: f64 = 0.25;
/// Probability that noise of the stated uncertainties leaves so small a `chi^2`.
const PROBABILITY_OF_SMALL_CHI_SQUARE: f64 = 1e-3;

/// Stated uncertainties over the errors, `sqrt(nu/chi^2)`, where `chi^2` is so small that noise of
/// these uncertainties would hardly leave it.
pub fn uncertainties_over_errors(chi_square: f64, degrees_of_freedom: f64) -> Option<f64> {
    let noise = ChiSquared::new(degrees_of_freedom).ok()?;
    let is_small = chi_square < MAX_SMALL_REDUCED_CHI_SQUARE * degrees_of_freedom
        && noise.cdf(chi_square) < PROBABILITY_OF_SMALL_CHI_SQUARE;
    (chi_square > 0.0 && is_small).then(|| (degrees_of_freedom / chi_square).sqrt())
}

/// Largest `chi^2` that noise explains: `nu + 2 sqrt(2 nu)`.
pub(super) fn max_chi_square(nu: f64) -> f64 {
    nu + MAX_CHI_SQUARE_STDS * (2.0 * nu).sqrt()
}
