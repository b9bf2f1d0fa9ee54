//! Update options hold the values of `[update]` of a scene.

use serde::{Deserialize, Serialize};

use crate::correlate::PairOptions;

use super::UpdateError;

/// Measured quantity that is compared with the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Residuals {
    /// Frequencies and shapes of its modes.
    Modes,
    /// Unbalanced forces of its modes in the equations of motion.
    ModalDynamic,
    /// Real and imaginary parts of its FRFs, from where the modes end.
    FrfComplex,
    /// Logarithms of the magnitudes of its FRFs, from where the modes end.
    FrfLogMagnitude,
}

impl Residuals {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::Modes,
        Self::ModalDynamic,
        Self::FrfComplex,
        Self::FrfLogMagnitude,
    ];

    /// The name in scenes and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Modes => "modes",
            Self::ModalDynamic => "modal-dynamic",
            Self::FrfComplex => "frf-complex",
            Self::FrfLogMagnitude => "frf-log-magnitude",
        }
    }

    /// The kind of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// Whether FRFs are compared.
    pub fn of_frfs(self) -> bool {
        matches!(self, Self::FrfComplex | Self::FrfLogMagnitude)
    }
}

/// Maximum number of starts. Larger: the list of starts alone fills the memory. Smaller: rough
/// objectives of many parameters get too few.
const MAX_STARTS: usize = 10_000;
/// Maximum number of iterations from one start, far above those of any descent that converges.
const MAX_ITERATIONS: usize = 100_000;

/// Options of updating.
#[derive(Clone, Debug, PartialEq)]
pub struct UpdateOptions {
    /// Measured quantity that is compared with the model.
    pub residuals: Residuals,
    /// Standard deviation of every frequency of the model in addition to the test's, a fraction:
    /// its error that no parameter corrects. 0 for a model as exact as the test.
    pub frequency_floor: f64,
    /// The same of every shape component, as a part of the root mean square of the shape's
    /// components; `None` leaves shapes out of the objective (they still pair and follow modes).
    pub shape_floor: Option<f64>,
    /// Whether the scatter of the frequencies between tests of one configuration, as between
    /// reassemblies, is added to the standard deviations of each test.
    pub scatter_between_tests: bool,
    /// Standard deviation of a shape component for which the test states none, as such a part.
    pub assumed_shape_std: f64,
    /// The same as the floors of every value of an FRF, a fraction of its magnitude: for the
    /// damping, which is not updated, and the calibration. These are errors of whole functions, and
    /// count as independent at every line: where they are more than the noise, posterior deviations
    /// are too small.
    pub frf_floor: f64,
    /// Largest number of compared lines of a function, evenly thinned.
    pub frf_lines: usize,
    /// Prior deviation of a parameter for which none is stated: of its logarithm, or of its value
    /// as a part of it.
    pub prior_std: f64,
    /// Number of starts; the first one is the initial model.
    pub starts: usize,
    /// Seed of the others.
    pub seed: u64,
    /// Largest number of iterations from one start.
    pub max_iterations: usize,
    /// How modes are paired at every start.
    pub pair: PairOptions,
}

impl Default for UpdateOptions {
    /// Modes; floors of 0.1 % in frequency, 2 % in shape and FRFs (to which sensors are
    /// calibrated), 5 % for shapes without deviations, 400 lines, priors of 30 %, 20 starts of at
    /// most 100 iterations.
    fn default() -> Self {
        Self {
            residuals: Residuals::Modes,
            frequency_floor: 1e-3,
            scatter_between_tests: false,
            shape_floor: Some(0.02),
            assumed_shape_std: 0.05,
            frf_floor: 0.02,
            frf_lines: 400,
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
        self.faults().into_iter().next().map_or(Ok(()), Err)
    }

    /// Every option outside its range, those of pairing aside.
    pub fn faults(&self) -> Vec<UpdateError> {
        let positive = |value: f64| value.is_finite() && value > 0.0;
        let floor = self.shape_floor.unwrap_or(1.0);
        let checks = [
            (
                "frequency_floor",
                self.frequency_floor,
                (0.0..1.0).contains(&self.frequency_floor),
                "a fraction from 0 to below 1, such as 0.001 for 0.1 %",
            ),
            ("shape_floor", floor, positive(floor), "a fraction above 0"),
            (
                "assumed_shape_std",
                self.assumed_shape_std,
                positive(self.assumed_shape_std),
                "a fraction above 0",
            ),
            (
                "frf_floor",
                self.frf_floor,
                (0.0..1.0).contains(&self.frf_floor),
                "a fraction from 0 to below 1",
            ),
            (
                "frf_lines",
                self.frf_lines as f64,
                self.frf_lines > 0,
                "at least one",
            ),
            (
                "prior_std",
                self.prior_std,
                positive(self.prior_std),
                "a number above 0",
            ),
            (
                "starts",
                self.starts as f64,
                (1..=MAX_STARTS).contains(&self.starts),
                "1 to 10000",
            ),
            (
                "max_iterations",
                self.max_iterations as f64,
                (1..=MAX_ITERATIONS).contains(&self.max_iterations),
                "1 to 100000",
            ),
        ];
        let faulty = checks.into_iter().filter(|(_, _, good, _)| !good);
        faulty
            .map(|(name, got, _, expected)| UpdateError::Option {
                name,
                got,
                expected,
            })
            .collect()
    }
}
