//! Errors of an update state what was given, what was expected, and for which parameter or mode.

use crate::correlate::CorrelateError;
use crate::linalg::LinalgError;
use crate::theory::TheoryError;

use super::mode_mark::measured_mode;

/// Maximum number of parameters that an error lists.
const MAX_LISTED_NAMES: usize = 12;

/// The names, of many the first and the number of the others.
fn first_names(names: &[String]) -> String {
    let further = names.len().saturating_sub(MAX_LISTED_NAMES);
    let first = names.iter().take(MAX_LISTED_NAMES).cloned();
    let further = (further > 0).then(|| format!("{further} more"));
    first.chain(further).collect::<Vec<_>>().join(", ")
}

/// Why a model cannot be updated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UpdateError {
    /// An option outside its range.
    #[error("update option {name}: got {got}, expected {expected}")]
    Option {
        /// The option.
        name: &'static str,
        /// As given.
        got: f64,
        /// The accepted values.
        expected: &'static str,
    },
    /// A parameter that the model does not have, or that is named twice.
    #[error(
        "update parameter {name:?}: {reason}; the model has {}",
        first_names(known)
    )]
    Parameter {
        /// As given.
        name: String,
        /// The fault.
        reason: &'static str,
        /// Those of the model.
        known: Vec<String>,
    },
    /// A parameter whose prior does not follow from its value and bounds.
    #[error(
        "update parameter {name:?}: no default prior for a value of {initial} without two bounds; expected a stated one"
    )]
    NoPrior {
        /// Its name.
        name: String,
        /// Where it starts.
        initial: f64,
    },
    /// Bounds that do not hold the start, or a prior without width.
    #[error(
        "update parameter {name:?}: start {initial} with bounds {lower} to {upper}, expected it between them"
    )]
    Bounds {
        /// Its name.
        name: String,
        /// Where it starts.
        initial: f64,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// A prior deviation that is not above 0, or of logarithms for a value that is not.
    #[error(
        "update parameter {name:?}: prior deviation {got} around {initial}, expected a finite one above 0, and a start above 0 for a log-normal prior"
    )]
    PriorDeviation {
        /// Its name.
        name: String,
        /// The deviation.
        got: f64,
        /// Where it starts.
        initial: f64,
    },
    /// A shared parameter with two values.
    #[error(
        "update parameter {name:?}: {got} in the configuration {configuration:?} and {expected} in the one before, expected one value, or the parameter in `separate` or `parameters` of the configuration"
    )]
    SharedValue {
        /// The parameter.
        name: String,
        /// The configuration.
        configuration: String,
        /// Its value there.
        got: f64,
        /// The value of the configuration before.
        expected: f64,
    },
    /// A parameter that is separate but not free.
    #[error(
        "configuration {configuration:?} separate: got {name:?}, expected a free parameter: {}",
        first_names(free)
    )]
    Separate {
        /// The parameter.
        name: String,
        /// The configuration.
        configuration: String,
        /// The free ones.
        free: Vec<String>,
    },
    /// A configuration whose model has none of the free parameters.
    #[error(
        "configuration {configuration:?}: its model has no free parameter, expected one of {}, with the same name as in the other models",
        first_names(free)
    )]
    NothingShared {
        /// The configuration.
        configuration: String,
        /// The free parameters.
        free: Vec<String>,
    },
    /// No parameter to change.
    #[error("no parameter is free, expected at least one")]
    NothingFree,
    /// No mode of any test has a partner in the model.
    #[error(
        "none of {modes} test modes pairs with a mode of the model, expected at least one: `modalign run` shows both; check the dimensions and support of the model and the positions and directions of the sensors, or allow larger errors with max_frequency_error of [pair]"
    )]
    NothingPaired {
        /// Test modes.
        modes: usize,
    },
    /// A frequency without any uncertainty.
    #[error(
        "{}: neither the test nor frequency_floor states an uncertainty of its frequency, expected one above 0",
        measured_mode(label)
    )]
    NoUncertainty {
        /// The mode.
        label: String,
    },
    /// A mode without shapes, which has no modal dynamic residual.
    #[error(
        "{}: modal dynamic residuals need a shape at two or more sensors of the model, and shape_floor above 0; this mode has none (sensors with the opposite sign of the model are left out)",
        measured_mode(label)
    )]
    NoShapes {
        /// The mode.
        label: String,
    },
    /// No FRF that can be compared.
    #[error(
        "no FRF has both ends at sensors of the model, lines in the band and an uncertainty, expected at least one for residuals of FRFs (FRFs at sensors with the opposite sign of the model are left out)"
    )]
    NoFrfs,
    /// An FRF whose noise is not known.
    #[error(
        "residuals of FRFs: the function {response}/{reference} has no variance, expected one: from two hits or more, or from coherence and the number of averages"
    )]
    NoVariance {
        /// Its response.
        response: String,
        /// Its reference.
        reference: String,
    },
    /// FRFs of a test none of whose modes has a damping ratio.
    #[error(
        "residuals of FRFs: no mode of test {} that is paired has a damping ratio, expected one",
        test + 1
    )]
    NoDamping {
        /// Index of the test.
        test: usize,
    },
    /// A derivative of the residuals that is not a finite number.
    #[error(
        "update parameter {name:?}: at {value} the residuals have no finite derivative by it, expected one; bounds may keep it away from there"
    )]
    Derivative {
        /// The parameter.
        name: String,
        /// Its value there.
        value: f64,
    },
    /// The model.
    #[error(transparent)]
    Theory(#[from] TheoryError),
    /// Pairing.
    #[error(transparent)]
    Correlate(#[from] CorrelateError),
    /// A decomposition.
    #[error(transparent)]
    Linalg(#[from] LinalgError),
}
