//! `automac.json` and `frf-correlation.json`, and measures beside a comparison.

use serde_json::{Value, json};

use crate::correlate::measures::{AutoMac, FrfCorrelation, Measures, ReversedSensor};

/// The schema text of modes against themselves.
pub const AUTO_MAC_SCHEMA: &str = "modalign-automac/1";

/// The schema text of FRFs against FRFs.
pub const FRF_CORRELATION_SCHEMA: &str = "modalign-frf-correlation/1";

/// Modes of several tests against themselves, ending in a newline.
pub fn auto_macs_to_json(tests: &[(String, AutoMac)]) -> String {
    text(&json!({ "schema": AUTO_MAC_SCHEMA, "tests": named(tests) }))
}

/// FRFs of several tests against those of one theory, ending in a newline.
pub fn frf_correlations_to_json(tests: &[(String, FrfCorrelation)]) -> String {
    text(&json!({ "schema": FRF_CORRELATION_SCHEMA, "tests": named(tests) }))
}

/// The measures of every test, as `measures` of `comparison.json` holds them.
pub(super) fn measures_value(tests: &[(String, Measures)]) -> Value {
    named(tests)
}

/// The reversed sensors of the tests that have some, as `reversed_sensors` of `comparison.json`
/// holds them.
pub(super) fn reversed_value(tests: &[(String, Vec<ReversedSensor>)]) -> Option<Value> {
    let some = tests.iter().filter(|(_, sensors)| !sensors.is_empty());
    let objects = some.map(|(name, sensors)| json!({ "test": name, "sensors": sensors }));
    let objects: Vec<Value> = objects.collect();
    (!objects.is_empty()).then(|| objects.into())
}

/// An object for each test, with its name as `test`.
fn named<T: serde::Serialize>(tests: &[(String, T)]) -> Value {
    let object = |(name, measures): &(String, T)| {
        let mut value =
            serde_json::to_value(measures).expect("plain data has no key that is not text");
        value["test"] = Value::from(name.as_str());
        value
    };
    tests.iter().map(object).collect()
}

fn text(value: &Value) -> String {
    let text = serde_json::to_string_pretty(value);
    text.expect("plain data has no key that is not text") + "\n"
}
