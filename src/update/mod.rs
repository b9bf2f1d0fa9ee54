//! Updating fits parameters of a model to a test and reports which of them the data determine.
//!
//! An [`UpdateProblem`] holds the model, its free parameters with their bounds and priors, and what
//! was measured: natural frequencies and shapes, each with its uncertainty. Every free parameter is
//! a number `z` of its prior deviations from where it starts; the objective is `sum r^2 + sum z^2`
//! over residuals that are divided by their deviations. This module must not read a file, identify
//! modes or print.

mod alternatives;
mod bounded;
mod configuration;
mod contribution;
mod design;
mod dynamic;
mod error;
mod evaluate;
mod findings;
mod frfs;
mod history;
mod identifiability;
mod mode_mark;
mod mode_tracking;
mod model_error;
mod model_state;
mod options;
mod parameter;
mod parameter_subsets;
mod prediction;
mod problem;
mod projection;
mod residual;
mod residual_selection;
mod result;
mod scatter;
mod shape_continuation;
mod solve;
mod target;
mod target_shapes;
mod trust_region;

#[cfg(test)]
mod configuration_tests;
#[cfg(test)]
mod cycloid_tests;
#[cfg(test)]
mod design_tests;
#[cfg(test)]
mod dynamic_tests;
#[cfg(test)]
mod frfs_tests;
#[cfg(test)]
mod parameter_subsets_tests;
#[cfg(test)]
mod problem_tests;
#[cfg(test)]
mod result_tests;
#[cfg(test)]
mod solve_tests;
#[cfg(test)]
mod test_models;
#[cfg(test)]
mod weights_tests;

pub use alternatives::{Alternative, Separation};
pub use configuration::Configuration;
pub use contribution::{Contradiction, Contribution};
pub use design::{Design, DesignMode, FrequencyTarget, Goal, Proposal, design, design_parameters};
pub use error::UpdateError;
pub use evaluate::{Evaluation, uncertainties_over_errors};
pub use history::{Iteration, PairingChange, StopReason};
pub use identifiability::{
    Combination, Identifiability, MAX_POSTERIOR_OVER_PRIOR, ParameterVerdict,
};
pub use mode_mark::measured_mode;
pub use mode_tracking::RootPair;
pub use model_error::{ModelError, ResidualKind, UnpredictedMode};
pub use model_state::ModelState;
pub use options::{Residuals, UpdateOptions};
pub use parameter::{FreeParameter, ParameterChoice, Prior};
pub use parameter_subsets::{
    Explanation, LeftOutPrediction, SubsetFit, check_always, explain, single_parameter_fits,
};
pub use prediction::{ParameterUncertainty, frequency_interval_95};
pub use problem::UpdateProblem;
pub use result::{
    Fit, FitRow, FrfCount, OtherOptimum, Starts, UpdateResult, UpdatedParameter, update,
};
pub use scatter::Scatter;
pub use solve::{MultiStart, solve, solve_from_starts};
pub use target::{MeasuredModes, ReversedSensors, ShapeWeights, Target};
pub use trust_region::Solution;
