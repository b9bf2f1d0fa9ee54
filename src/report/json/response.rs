//! Time responses are written with the schema `modalign-response/1`.

use serde::Serialize;

use crate::theory::{DetailResponse, ResponseSignal, TimeResponse};

use super::schema::json_text;

/// The schema of [`response_to_json`].
pub const RESPONSE_SCHEMA: &str = "modalign-response/1";

#[derive(Serialize)]
struct ResponseFile<'a> {
    schema: &'static str,
    excitation_hz: f64,
    settling_periods: usize,
    #[serde(rename = "told_periods")]
    recorded_periods: usize,
    details: Vec<DetailFile<'a>>,
}

#[derive(Serialize)]
struct DetailFile<'a> {
    detail: &'a str,
    coordinates: usize,
    evaluations_per_period: usize,
    functions_per_evaluation: usize,
    signals: Vec<SignalFile<'a>>,
}

#[derive(Serialize)]
struct SignalFile<'a> {
    name: &'a str,
    unit: &'a str,
    meaning: &'a str,
    mean: f64,
    rms: f64,
    std: f64,
    largest: f64,
    least: f64,
    /// Distance from the last detail, relative to it; null where that has no such signal.
    distance_from_last: Option<f64>,
    harmonics: &'a [f64],
}

/// The text of a response, ending in a newline. Samples are left out.
pub fn response_to_json(response: &TimeResponse) -> String {
    let last = response.details.last().map_or("", |detail| detail.detail);
    let distance = |detail: &DetailResponse, signal: &'_ ResponseSignal| {
        response.difference(signal.name, detail.detail, last)
    };
    let details = response.details.iter().map(|detail| DetailFile {
        detail: detail.detail,
        coordinates: detail.coordinates,
        evaluations_per_period: detail.evaluations_per_period,
        functions_per_evaluation: detail.functions_per_evaluation,
        signals: detail
            .signals
            .iter()
            .map(|signal| SignalFile {
                name: signal.name,
                unit: signal.unit,
                meaning: signal.meaning,
                mean: signal.mean(),
                rms: signal.rms(),
                std: signal.deviation(),
                largest: signal.largest(),
                least: signal.least(),
                distance_from_last: distance(detail, signal),
                harmonics: &signal.harmonics,
            })
            .collect(),
    });
    let file = ResponseFile {
        schema: RESPONSE_SCHEMA,
        excitation_hz: response.excitation_hz,
        settling_periods: response.span.settling_periods,
        recorded_periods: response.span.recorded_periods,
        details: details.collect(),
    };
    json_text(&file)
}
