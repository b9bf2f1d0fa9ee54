//! `update.json`, schema `modalign-update/1`.

use serde::Serialize;

use crate::scene::SceneUpdate;
use crate::theory::ParameterStatus;
use crate::update::{
    Change, Combination, Explanation, Fit, PairingChange, StopReason, UpdatedParameter, Verdict,
};

/// The schema of [`update_to_json`].
pub const UPDATE_SCHEMA: &str = "modalign-update/1";

#[derive(Serialize)]
struct UpdateFile<'a> {
    schema: &'static str,
    parameters: Vec<ParameterFile<'a>>,
    combinations: &'a [Combination],
    correlation: &'a [Vec<f64>],
    stop_reason: StopReason,
    starts: StartsFile,
    before: FitFile<'a>,
    after: FitFile<'a>,
    degrees_of_freedom: f64,
    reduced_chi_square: f64,
    fits: bool,
    left_out: Vec<LeftOutFile<'a>>,
    pairing_changes: &'a [PairingChange],
    history: Vec<IterationFile<'a>>,
    explanation: Option<ExplanationFile<'a>>,
    assumed: AssumedFile,
}

#[derive(Serialize)]
struct ParameterFile<'a> {
    name: &'a str,
    unit: &'a str,
    status: ParameterStatus,
    initial: f64,
    updated: f64,
    std: f64,
    interval_95: (f64, f64),
    prior_std: f64,
    posterior_over_prior: f64,
    lower: Option<f64>,
    upper: Option<f64>,
    verdict: Verdict,
    held: bool,
}

#[derive(Serialize)]
struct StartsFile {
    count: usize,
    reached: usize,
    failed: usize,
    seed: u64,
}

#[derive(Serialize)]
struct FitFile<'a> {
    paired: usize,
    chi_square: f64,
    data_count: usize,
    rms_percent: Option<f64>,
    largest_percent: Option<f64>,
    rows: Vec<RowFile<'a>>,
}

#[derive(Serialize)]
struct RowFile<'a> {
    label: &'a str,
    test_hz: f64,
    test_std_hz: f64,
    model_hz: Option<f64>,
    model_std_hz: Option<f64>,
    error_percent: Option<f64>,
    mac: Option<f64>,
}

#[derive(Serialize)]
struct LeftOutFile<'a> {
    label: &'a str,
    hz: f64,
}

#[derive(Serialize)]
struct IterationFile<'a> {
    objective: f64,
    chi_square: f64,
    radius: f64,
    accepted: bool,
    values: &'a [f64],
}

#[derive(Serialize)]
struct ExplanationFile<'a> {
    none: ChangeFile<'a>,
    single: Vec<ChangeFile<'a>>,
    pairs: Vec<ChangeFile<'a>>,
    proposed: ChangeFile<'a>,
    foretold: Vec<ForetoldFile<'a>>,
}

#[derive(Serialize)]
struct ChangeFile<'a> {
    parameters: &'a [String],
    values: &'a [f64],
    free: usize,
    chi_square: f64,
    bic: f64,
    rms_percent: Option<f64>,
    largest_percent: Option<f64>,
    explains: bool,
}

#[derive(Serialize)]
struct ForetoldFile<'a> {
    label: &'a str,
    before_percent: f64,
    after_percent: f64,
}

/// What the weights rest on beside the test.
#[derive(Serialize)]
struct AssumedFile {
    frequency_floor: f64,
    shape_floor: Option<f64>,
    prior_std: f64,
}

/// The text of an update, ending in a newline.
pub fn update_to_json(own: &SceneUpdate) -> String {
    let result = &own.result;
    let history = result.history.iter().map(|step| IterationFile {
        objective: step.objective,
        chi_square: step.chi_square,
        radius: step.radius,
        accepted: step.accepted,
        values: &step.values,
    });
    let left_out = result.left_out.iter();
    let file = UpdateFile {
        schema: UPDATE_SCHEMA,
        parameters: result.parameters.iter().map(parameter).collect(),
        combinations: &result.combinations,
        correlation: &result.correlation,
        stop_reason: result.stop_reason,
        starts: StartsFile {
            count: result.starts.count,
            reached: result.starts.reached,
            failed: result.starts.failed,
            seed: result.starts.seed,
        },
        before: fit(&result.before),
        after: fit(&result.after),
        degrees_of_freedom: result.degrees_of_freedom(),
        reduced_chi_square: result.reduced_chi_square(),
        fits: result.fits(),
        left_out: left_out
            .map(|(label, hz)| LeftOutFile { label, hz: *hz })
            .collect(),
        pairing_changes: &result.pairing_changes,
        history: history.collect(),
        explanation: own.explanation.as_ref().map(explanation),
        assumed: AssumedFile {
            frequency_floor: own.options.frequency_floor,
            shape_floor: own.options.shape_floor,
            prior_std: own.options.prior_std,
        },
    };
    let text = serde_json::to_string_pretty(&file).expect("plain data has no key that is not text");
    text + "\n"
}

fn parameter(own: &UpdatedParameter) -> ParameterFile<'_> {
    ParameterFile {
        name: &own.name,
        unit: &own.unit,
        status: own.status,
        initial: own.initial,
        updated: own.updated,
        std: own.std,
        interval_95: own.interval_95,
        prior_std: own.prior_std,
        posterior_over_prior: own.posterior_over_prior,
        lower: own.lower,
        upper: own.upper,
        verdict: own.verdict,
        held: own.held,
    }
}

fn fit(own: &Fit) -> FitFile<'_> {
    let row = own.rows.iter().map(|row| RowFile {
        label: &row.label,
        test_hz: row.test_hz,
        test_std_hz: row.test_std_hz,
        model_hz: row.model_hz,
        model_std_hz: row.model_std_hz,
        error_percent: row.error_percent,
        mac: row.mac,
    });
    FitFile {
        paired: own.paired(),
        chi_square: own.chi_square,
        data_count: own.data_count,
        rms_percent: own.rms_percent,
        largest_percent: own.largest_percent,
        rows: row.collect(),
    }
}

fn change(own: &Change) -> ChangeFile<'_> {
    ChangeFile {
        parameters: &own.parameters,
        values: &own.values,
        free: own.free,
        chi_square: own.fit.chi_square,
        bic: own.bic,
        rms_percent: own.fit.rms_percent,
        largest_percent: own.fit.largest_percent,
        explains: own.explains(),
    }
}

fn explanation(own: &Explanation) -> ExplanationFile<'_> {
    let foretold = own.foretold.iter().map(|row| ForetoldFile {
        label: &row.label,
        before_percent: row.before_percent,
        after_percent: row.after_percent,
    });
    ExplanationFile {
        none: change(&own.none),
        single: own.single.iter().map(change).collect(),
        pairs: own.pairs.iter().map(change).collect(),
        proposed: change(&own.proposed),
        foretold: foretold.collect(),
    }
}
