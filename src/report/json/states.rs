//! The states of the tests of a scene and the support of its model in `comparison.json`.

use serde_json::{Value, json};

use crate::scene::{SceneResult, TestResult};

/// The stated states of the tests, by name, and the support of the model; `None` where neither the
/// scene nor the model states one.
pub(super) fn states_value(result: &SceneResult) -> Option<Value> {
    let stated = result.tests.iter().filter(|test| !test.state.is_empty());
    let named = |test: &TestResult| {
        let mut value = json!({ "test": test.name });
        if let (Value::Object(all), Ok(Value::Object(state))) =
            (&mut value, serde_json::to_value(&test.state))
        {
            all.extend(state);
        }
        value
    };
    let tests: Vec<Value> = stated.map(named).collect();
    let support = result.theory.support;
    let is_stated = !tests.is_empty() || support.stated.is_some();
    is_stated.then(|| {
        json!({
            "tests": tests,
            "model": { "support": { "stated": support.stated, "derived": support.derived } },
        })
    })
}
