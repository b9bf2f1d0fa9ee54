//! Options of updating.

use crate::correlate::PairOptions;

use super::UpdateError;

/// Options of updating.
#[derive(Clone, Debug, PartialEq)]
pub struct UpdateOptions {
    /// Deviation of every frequency that the model itself is granted beside the test's, a fraction: what no value of its
    /// parameters mends. 0 trusts the model as far as the test.
    pub frequency_floor: f64,
    /// The same of every shape component, as a part of the root mean square of the shape's components; `None` leaves
    /// shapes out of the objective (they still pair and follow modes).
    pub shape_floor: Option<f64>,
    /// Prior deviation of a parameter for which none is stated: of its logarithm, or of its value as a part of it.
    pub prior_std: f64,
    /// Number of starts; the first one is the model as it stands.
    pub starts: usize,
    /// Seed of the others.
    pub seed: u64,
    /// Largest number of iterations from one start.
    pub max_iterations: usize,
    /// How modes are paired at every start.
    pub pair: PairOptions,
}

impl Default for UpdateOptions {
    /// Floors of 0.1 % in frequency and 5 % in shape, priors of 30 %, 20 starts of at most 100 iterations.
    fn default() -> Self {
        Self {
            frequency_floor: 1e-3,
            shape_floor: Some(0.05),
            prior_std: 0.3,
            starts: 20,
            seed: 1,
            max_iterations: 100,
            pair: PairOptions::default(),
        }
    }
}

impl UpdateOptions {
    /// Checks every option.
    ///
    /// # Errors
    /// [`UpdateError::Option`]; [`UpdateError::Correlate`] for those of pairing.
    pub fn validate(&self) -> Result<(), UpdateError> {
        self.pair.validate()?;
        let positive = |value: f64| value.is_finite() && value > 0.0;
        let floor = self.shape_floor.unwrap_or(1.0);
        let checks = [
            (
                "frequency_floor",
                self.frequency_floor,
                positive(self.frequency_floor) || self.frequency_floor == 0.0,
                "a fraction of 0 or more",
            ),
            ("shape_floor", floor, positive(floor), "a fraction above 0"),
            (
                "prior_std",
                self.prior_std,
                positive(self.prior_std),
                "a number above 0",
            ),
            (
                "starts",
                self.starts as f64,
                self.starts > 0,
                "at least one",
            ),
            (
                "max_iterations",
                self.max_iterations as f64,
                self.max_iterations > 0,
                "at least one",
            ),
        ];
        for (name, got, good, expected) in checks {
            if !good {
                return Err(UpdateError::Option {
                    name,
                    got,
                    expected,
                });
            }
        }
        Ok(())
    }
}
