//! `update.json`, schema `modalign-update/1`, holds an update of a model to tests.

use serde::{Deserialize, Serialize};

use crate::scene::SceneUpdate;
use crate::theory::ParameterStatus;
use crate::update::{
    Alternative, Combination, Contradiction, Contribution, Explanation, Fit, Iteration, ModelError,
    OtherOptimum, PairingChange, ParameterVerdict, Residuals, ReversedSensors, Scatter,
    ShapeWeights, Starts, StopReason, SubsetFit, UnpredictedMode, UpdatedParameter,
};

use super::comparison::{JsonError, parsed};
use super::schema::json_text;

/// The schema of [`update_to_json`].
pub const UPDATE_SCHEMA: &str = "modalign-update/1";

/// The file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UpdateFile {
    /// [`UPDATE_SCHEMA`].
    pub schema: String,
    /// The residual that the update minimises; frequencies and shapes where the file has none.
    #[serde(default = "of_modes")]
    pub residuals: Residuals,
    /// The free parameters.
    pub parameters: Vec<UpdatedParameterFile>,
    /// Identifiable combinations of the parameters, the best determined first.
    pub combinations: Vec<Combination>,
    /// Correlation of the posterior errors of the free parameters.
    pub correlation: Vec<Vec<f64>>,
    /// Stop reason of the best start.
    pub stop_reason: StopReason,
    /// Results of the starts.
    pub starts: StartsFile,
    /// The model before the update.
    pub before: FitFile,
    /// The model after the update.
    pub after: FitFile,
    /// Residuals less the combinations of parameters that they determine.
    pub degrees_of_freedom: f64,
    /// Chi-square per degree of freedom.
    pub reduced_chi_square: f64,
    /// Whether noise alone explains that value.
    pub fits: bool,
    /// Model error of each kind of residuals.
    #[serde(default)]
    pub model_errors: Vec<ModelError>,
    /// Modes that the others do not predict.
    #[serde(default)]
    pub unpredicted: Vec<UnpredictedMode>,
    /// What each configuration contributes; none where there is one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub configurations: Vec<Contribution>,
    /// The shared parameter that contradicts most between configurations.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contradiction: Option<Contradiction>,
    /// Scatter of the frequencies between tests of one configuration, where it was requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scatter: Option<Scatter>,
    /// Other optima of about the same objective, with the values of the free parameters.
    #[serde(default)]
    pub alternatives: Vec<Alternative>,
    /// Measured modes without a partner at the start.
    pub left_out: Vec<LeftOutFile>,
    /// Sign-reversed sensors, whose values were not used.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reversed_sensors: Vec<ReversedSensors>,
    /// Measured modes whose model partner changed during the iterations.
    pub pairing_changes: Vec<PairingChange>,
    /// Every step.
    pub history: Vec<IterationFile>,
    /// Changes of parameters that explain the misfit, if requested.
    pub explanation: Option<ExplanationFile>,
    /// Assumed standard deviations, in addition to those of the test.
    pub assumed: AssumedFile,
}

fn of_modes() -> Residuals {
    Residuals::Modes
}

/// A parameter before and after, as [`UpdatedParameter`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UpdatedParameterFile {
    /// Name.
    pub name: String,
    /// The configuration that has it, where the base does not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub configuration: Option<String>,
    /// Unit.
    pub unit: String,
    /// Source of the value in the model.
    pub status: ParameterStatus,
    /// Initial value.
    pub initial: f64,
    /// Updated value.
    pub updated: f64,
    /// Posterior standard deviation.
    pub std: f64,
    /// 95 % interval.
    pub interval_95: (f64, f64),
    /// Prior standard deviation.
    pub prior_std: f64,
    /// Posterior over prior standard deviation on the scale of the prior.
    pub posterior_over_prior: f64,
    /// Lower bound; `null` without one.
    pub lower: Option<f64>,
    /// Upper bound; `null` without one.
    pub upper: Option<f64>,
    /// Whether the data identify it.
    pub verdict: ParameterVerdict,
    /// Whether it was held at its initial value.
    pub held: bool,
}

/// Results of the starts, as [`Starts`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StartsFile {
    /// Number of starts.
    pub count: usize,
    /// Number of starts that converged to the best optimum.
    pub reached: usize,
    /// Number of starts whose model could not be built or solved.
    pub failed: usize,
    /// Seed.
    pub seed: u64,
    /// The other optima, lowest objective first.
    #[serde(default)]
    pub others: Vec<OtherOptimumFile>,
}

/// Another optimum, as [`OtherOptimum`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OtherOptimumFile {
    /// Objective.
    pub objective: f64,
    /// Number of starts that converged to it.
    pub count: usize,
    /// Values of the free parameters.
    pub values: Vec<f64>,
}

/// Comparison of the model with all targets, as [`Fit`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FitFile {
    /// Roots that have a partner in the model.
    pub paired: usize,
    /// `sum r^2` of the data.
    pub chi_square: f64,
    /// Number of residuals that carry information.
    pub data_count: usize,
    /// Root mean square of the frequency errors, percent.
    pub rms_percent: Option<f64>,
    /// The largest of them in magnitude, percent.
    pub largest_percent: Option<f64>,
    /// One row for each measured root.
    pub rows: Vec<FitRowFile>,
}

/// Comparison of a measured mode with the model, as [`FitRow`](crate::update::FitRow).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FitRowFile {
    /// Label of the measured root.
    pub label: String,
    /// Measured frequency, Hz.
    pub test_hz: f64,
    /// Standard deviation that divides its residual, Hz.
    pub test_std_hz: f64,
    /// Frequency of the model; `null` without a partner.
    pub model_hz: Option<f64>,
    /// Standard deviation of the model frequency by the uncertainty of the parameters, Hz.
    pub model_std_hz: Option<f64>,
    /// Error of frequency, percent.
    pub error_percent: Option<f64>,
    /// Weighted MAC.
    pub mac: Option<f64>,
    /// Source of the standard deviations of its shape; `null` where shapes are not used.
    #[serde(default)]
    pub shape_weights: Option<ShapeWeights>,
}

/// A measured mode without a partner.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeftOutFile {
    /// Label of the measured root.
    pub label: String,
    /// Frequency, Hz.
    pub hz: f64,
}

/// A step, as [`Iteration`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct IterationFile {
    /// Objective after it: data and prior.
    pub objective: f64,
    /// `sum r^2` of the data.
    pub chi_square: f64,
    /// Trust-region radius of the next step.
    pub radius: f64,
    /// Whether it was taken.
    pub accepted: bool,
    /// Values of the free parameters after it.
    pub values: Vec<f64>,
}

/// Changes of parameters that explain the misfit, as [`Explanation`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExplanationFile {
    /// With the always free parameters alone, or nothing.
    pub none: ChangeFile,
    /// Each parameter alone, smallest remaining error first.
    pub single: Vec<ChangeFile>,
    /// Pairs among the best of them.
    pub pairs: Vec<ChangeFile>,
    /// The set that is proposed.
    pub proposed: ChangeFile,
    /// Leave-one-out check of that set.
    #[serde(rename = "foretold")]
    pub predictions: Vec<PredictionFile>,
}

/// One set of parameters freed, as [`SubsetFit`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChangeFile {
    /// Names; those that are always free are not among them.
    pub parameters: Vec<String>,
    /// Values of the free parameters after it.
    pub values: Vec<f64>,
    /// Number of parameters that were free in all.
    pub free: usize,
    /// `sum r^2` of the data.
    pub chi_square: f64,
    /// `chi^2 + k ln N`.
    pub bic: f64,
    /// Root mean square of the frequency errors, percent.
    pub rms_percent: Option<f64>,
    /// The largest of them in magnitude, percent.
    pub largest_percent: Option<f64>,
    /// Whether the residual is down to its uncertainty.
    pub explains: bool,
}

/// Prediction of a mode by the model that was updated without it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PredictionFile {
    /// Label of the measured root.
    pub label: String,
    /// Error of the model before the update, percent.
    pub before_percent: f64,
    /// Error of the model updated without it, percent.
    pub after_percent: f64,
}

/// Assumed standard deviations; `null` where they have no effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AssumedFile {
    /// Model error of every frequency, a fraction.
    pub frequency_floor: f64,
    /// Model error of shape components, a fraction; `null` where shapes are not used.
    pub shape_floor: Option<f64>,
    /// Deviation of shape components for which the test states none; `null` where it states all.
    #[serde(default)]
    pub shape_std: Option<f64>,
    /// Deviation of every value of an FRF; `null` where FRFs are not compared.
    #[serde(default)]
    pub frf_floor: Option<f64>,
    /// Prior deviation.
    pub prior_std: f64,
}

/// Reads `update.json`.
///
/// # Errors
/// [`JsonError`] with line and column, or the schema that was found.
pub fn update_from_json(text: &str) -> Result<UpdateFile, JsonError> {
    let file: UpdateFile = parsed(text)?;
    if file.schema == UPDATE_SCHEMA {
        return Ok(file);
    }
    Err(JsonError::Schema {
        got: file.schema,
        expected: UPDATE_SCHEMA,
    })
}

/// The text of an update, ending in a newline.
pub fn update_to_json(scene_update: &SceneUpdate) -> String {
    json_text(&update_file(scene_update))
}

/// An update as it stands in the file.
pub fn update_file(scene_update: &SceneUpdate) -> UpdateFile {
    let result = &scene_update.result;
    let left_out = result.left_out.iter();
    let left_out = left_out.map(|(label, hz)| LeftOutFile {
        label: label.clone(),
        hz: *hz,
    });
    UpdateFile {
        schema: UPDATE_SCHEMA.to_owned(),
        residuals: scene_update.options.residuals,
        parameters: result.parameters.iter().map(parameter).collect(),
        combinations: result.combinations.clone(),
        correlation: result.correlation.clone(),
        stop_reason: result.stop_reason,
        starts: starts(&result.starts),
        before: fit(&result.before),
        after: fit(&result.after),
        degrees_of_freedom: result.degrees_of_freedom(),
        reduced_chi_square: result.reduced_chi_square(),
        fits: result.fits(),
        model_errors: result.model_errors.clone(),
        unpredicted: result.unpredicted.clone(),
        configurations: result.contributions.clone(),
        contradiction: result.contradiction.clone(),
        scatter: result.scatter,
        alternatives: result.alternatives.clone(),
        left_out: left_out.collect(),
        reversed_sensors: result.reversed.clone(),
        pairing_changes: result.pairing_changes.clone(),
        history: result.history.iter().map(iteration).collect(),
        explanation: scene_update.explanation.as_ref().map(explanation),
        assumed: assumed(scene_update),
    }
}

fn starts(starts: &Starts) -> StartsFile {
    let other = |optimum: &OtherOptimum| OtherOptimumFile {
        objective: optimum.objective,
        count: optimum.count,
        values: optimum.values.clone(),
    };
    StartsFile {
        count: starts.count,
        reached: starts.reached,
        failed: starts.failed,
        seed: starts.seed,
        others: starts.others.iter().map(other).collect(),
    }
}

fn assumed(scene_update: &SceneUpdate) -> AssumedFile {
    let options = &scene_update.options;
    let rows = scene_update.result.after.rows.iter();
    let counts = rows.filter(|row| row.shape_weights == Some(ShapeWeights::Assumed));
    let frf_floor = options.residuals.of_frfs().then_some(options.frf_floor);
    AssumedFile {
        frequency_floor: options.frequency_floor,
        shape_floor: options.shape_floor,
        shape_std: (counts.count() > 0).then_some(options.assumed_shape_std),
        frf_floor,
        prior_std: options.prior_std,
    }
}

fn iteration(step: &Iteration) -> IterationFile {
    IterationFile {
        objective: step.objective,
        chi_square: step.chi_square,
        radius: step.radius,
        accepted: step.accepted,
        values: step.values.clone(),
    }
}

fn parameter(parameter: &UpdatedParameter) -> UpdatedParameterFile {
    UpdatedParameterFile {
        name: parameter.name.clone(),
        configuration: parameter.configuration.clone(),
        unit: parameter.unit.clone(),
        status: parameter.status,
        initial: parameter.initial,
        updated: parameter.updated,
        std: parameter.std,
        interval_95: parameter.interval_95,
        prior_std: parameter.prior_std,
        posterior_over_prior: parameter.posterior_over_prior,
        lower: parameter.lower,
        upper: parameter.upper,
        verdict: parameter.verdict,
        held: parameter.held,
    }
}

fn fit(fit: &Fit) -> FitFile {
    let row = fit.rows.iter().map(|row| FitRowFile {
        label: row.label.clone(),
        test_hz: row.test_hz,
        test_std_hz: row.test_std_hz,
        model_hz: row.model_hz,
        model_std_hz: row.model_std_hz,
        error_percent: row.error_percent,
        mac: row.mac,
        shape_weights: row.shape_weights,
    });
    FitFile {
        paired: fit.paired(),
        chi_square: fit.chi_square,
        data_count: fit.data_count,
        rms_percent: fit.rms_percent,
        largest_percent: fit.largest_percent,
        rows: row.collect(),
    }
}

fn change(change: &SubsetFit) -> ChangeFile {
    ChangeFile {
        parameters: change.parameters.clone(),
        values: change.values.clone(),
        free: change.free,
        chi_square: change.fit.chi_square,
        bic: change.bic,
        rms_percent: change.fit.rms_percent,
        largest_percent: change.fit.largest_percent,
        explains: change.explains(),
    }
}

fn explanation(explanation: &Explanation) -> ExplanationFile {
    let predictions = explanation
        .left_out_predictions
        .iter()
        .map(|row| PredictionFile {
            label: row.label.clone(),
            before_percent: row.before_percent,
            after_percent: row.after_percent,
        });
    ExplanationFile {
        none: change(&explanation.none),
        single: explanation.single.iter().map(change).collect(),
        pairs: explanation.pairs.iter().map(change).collect(),
        proposed: change(&explanation.proposed),
        predictions: predictions.collect(),
    }
}
