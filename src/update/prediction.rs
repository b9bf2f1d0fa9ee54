//! Predicted frequencies of an updated model have the uncertainty of its updated parameters.

use crate::theory::{RootState, TheoreticalModel, frequency_slopes};

use super::identifiability::TWO_SIDED_95;
use super::{UpdateError, UpdateResult};

/// The uncertain parameters of an updated model.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterUncertainty {
    /// Names.
    pub names: Vec<String>,
    /// Updated values.
    pub values: Vec<f64>,
    /// Posterior standard deviations.
    pub std: Vec<f64>,
    /// Correlation of the posterior errors.
    pub correlation: Vec<Vec<f64>>,
}

impl UpdateResult {
    /// The uncertainty of the updated parameters of the first configuration.
    pub fn uncertainty(&self) -> ParameterUncertainty {
        let all = self.parameters.iter();
        let shared: Vec<bool> = all.clone().map(|p| p.configuration.is_none()).collect();
        let all = ParameterUncertainty {
            names: all.clone().map(|p| p.name.clone()).collect(),
            values: all.clone().map(|p| p.updated).collect(),
            std: all.map(|p| p.std).collect(),
            correlation: self.correlation.clone(),
        };
        all.of(&shared)
    }
}

impl ParameterUncertainty {
    /// The uncertainty of some of the parameters.
    pub fn of(&self, chosen: &[bool]) -> Self {
        let places: Vec<usize> = (0..chosen.len()).filter(|&j| chosen[j]).collect();
        let numbers = |all: &[f64]| places.iter().map(|&j| all[j]).collect::<Vec<f64>>();
        Self {
            names: places.iter().map(|&j| self.names[j].clone()).collect(),
            values: numbers(&self.values),
            std: numbers(&self.std),
            correlation: places
                .iter()
                .map(|&i| numbers(&self.correlation[i]))
                .collect(),
        }
    }

    /// Relative standard deviation of the frequency of each root of a model with these values,
    /// `sqrt(g^T C g)/f` with the derivatives `g` of the frequency by the updated values. `factors`
    /// are the changes of the model's values per change of the updated values: 1 for a value that
    /// is not modified, 0 for one that is set.
    ///
    /// # Errors
    /// [`UpdateError::Theory`]; [`UpdateError::Parameter`] for a parameter that the model does not
    /// have.
    pub fn relative_stds(
        &self,
        model: &dyn TheoreticalModel,
        values: &[f64],
        factors: &[f64],
        roots: &[&RootState],
    ) -> Result<Vec<f64>, UpdateError> {
        let specs = model.parameters();
        let index = |name: &String| {
            let found = specs.iter().position(|spec| spec.name == *name);
            found.ok_or_else(|| UpdateError::Parameter {
                name: name.clone(),
                reason: "there is none",
                known: specs.iter().map(|spec| spec.name.clone()).collect(),
            })
        };
        let by: Vec<usize> = self.names.iter().map(index).collect::<Result<_, _>>()?;
        let slopes = frequency_slopes(model, values, &by, roots)?;
        let n = by.len();
        let std = |(slopes, root): (&Vec<f64>, &&RootState)| {
            let g: Vec<f64> = (0..n)
                .map(|j| slopes[j] * factors[by[j]] * self.std[j])
                .collect();
            let row = |i: usize| (0..n).map(|j| self.correlation[i][j] * g[j]).sum::<f64>();
            let variance: f64 = (0..n).map(|i| g[i] * row(i)).sum();
            match root.omega_rad_s > 0.0 {
                true => variance.max(0.0).sqrt() / root.omega_rad_s,
                false => 0.0,
            }
        };
        Ok(slopes.iter().zip(roots).map(std).collect())
    }
}

/// The 95 % interval of a frequency with this relative standard deviation; of its logarithm, so
/// that both ends are above 0.
pub fn frequency_interval_95(hz: f64, relative_std: f64) -> (f64, f64) {
    let factor = (TWO_SIDED_95 * relative_std).exp();
    (hz / factor, hz * factor)
}
