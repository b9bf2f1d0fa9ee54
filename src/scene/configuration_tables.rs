//! The `[[configuration]]` tables of a scene, checked before any model is read.

use std::collections::BTreeMap;
use std::path::Path;

use super::SceneError;
use super::error::value_error;
use super::faults::Faults;
use super::model_name::{is_built_in, named_model};
use super::typed::{ModelTable, SceneFile};

/// Name of the configuration that the model of the scene describes, of all tests that no other one
/// names.
pub const BASE_CONFIGURATION: &str = "base";

/// The `[model]` of another model than that of the base.
pub(super) fn other_table(name: &str, base: &ModelTable) -> ModelTable {
    let built_in = is_built_in(Path::new(name));
    ModelTable {
        name: built_in.then(|| name.to_owned()),
        file: (!built_in).then(|| name.to_owned()),
        parameters: BTreeMap::new(),
        partial: base.partial,
        added: None,
    }
}

/// Checks the configurations of a scene.
///
/// # Errors
/// [`SceneError::Value`] for each name that is not new, each test that is unknown or in two
/// configurations, and each model that is not named rightly.
pub(super) fn check_configurations(
    typed: &SceneFile,
    folder: &Path,
    path: &str,
) -> Result<(), SceneError> {
    let mut faults = Faults::default();
    let tests: Vec<&str> = typed.test.iter().map(|test| test.name.as_str()).collect();
    let mut known = vec![BASE_CONFIGURATION];
    let mut taken: Vec<&str> = Vec::new();
    for table in &typed.configuration {
        let place = format!("[[configuration]] {:?}", table.name);
        let mut refuse = |key: &str, got: &str, expected: &str| {
            let what = format!("{place} {key}");
            faults.add(value_error(path, &what, got, expected));
        };
        if table.name.trim().is_empty() || known.contains(&table.name.as_str()) {
            let expected = format!("a name other than {}", known.join(", "));
            refuse("name", &format!("{:?}", table.name), &expected);
        }
        known.push(&table.name);
        if table.tests.is_empty() {
            refuse("tests", "none", "at least one test");
        }
        for test in &table.tests {
            if !tests.contains(&test.as_str()) {
                let expected = format!("one of the tests {}", tests.join(", "));
                refuse("tests", &format!("{test:?}"), &expected);
            } else if taken.contains(&test.as_str()) {
                let expected = "each test in one configuration";
                refuse("tests", &format!("{test:?} twice"), expected);
            }
            taken.push(test);
        }
        for (number, name) in table.separate.iter().enumerate() {
            if table.separate[..number].contains(name) {
                refuse(
                    "separate",
                    &format!("{name:?} twice"),
                    "each parameter once",
                );
            }
            if table.parameters.contains_key(name) {
                let got = format!("{name:?} in `parameters`, too");
                refuse("separate", &got, "a parameter in one of them");
            }
        }
        if let Some(name) = &table.model {
            let model = other_table(name, &ModelTable::default());
            faults.take(named_model(&model, folder, path));
        }
    }
    let has_base_test = tests.iter().any(|test| !taken.contains(test))
        || typed.update.as_ref().is_some_and(|update| update.published);
    if !typed.configuration.is_empty() && typed.model.is_none() {
        let got = "a scene without [model]";
        faults.add(value_error(path, "[[configuration]]", got, "a [model]"));
    } else if !typed.configuration.is_empty() && faults.is_empty() && !has_base_test {
        let expected = "a test of the model of the scene, which no [[configuration]] names";
        let got = "every test in a configuration";
        faults.add(value_error(path, "[[configuration]]", got, expected));
    }
    faults.into_result()
}
