//! Correlation measures are written to `automac.json`, `frf-correlation.json` and
//! `comparison.json`.

use serde_json::{Value, json};

use crate::correlate::measures::{AutoMac, FrfCorrelation, Measures, ReversedSensor};

use super::schema::json_text;

/// The schema of [`auto_macs_to_json`].
pub const AUTO_MAC_SCHEMA: &str = "modalign-automac/1";

/// The schema of [`frf_correlations_to_json`].
pub const FRF_CORRELATION_SCHEMA: &str = "modalign-frf-correlation/1";

/// The AutoMAC of several tests as JSON text, ending in a newline.
pub fn auto_macs_to_json(tests: &[(String, AutoMac)]) -> String {
    json_text(&json!({ "schema": AUTO_MAC_SCHEMA, "tests": objects_by_test(tests) }))
}

/// Correlation of the FRFs of several tests with those of a theory as JSON text, ending in a
/// newline.
pub fn frf_correlations_to_json(tests: &[(String, FrfCorrelation)]) -> String {
    json_text(&json!({ "schema": FRF_CORRELATION_SCHEMA, "tests": objects_by_test(tests) }))
}

/// The measures of every test, as `measures` of `comparison.json` holds them.
pub(super) fn measures_value(tests: &[(String, Measures)]) -> Value {
    objects_by_test(tests)
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
fn objects_by_test<T: serde::Serialize>(tests: &[(String, T)]) -> Value {
    let object = |(name, measures): &(String, T)| {
        let mut value =
            serde_json::to_value(measures).expect("plain data has no key that is not text");
        value["test"] = Value::from(name.as_str());
        value
    };
    tests.iter().map(object).collect()
}
