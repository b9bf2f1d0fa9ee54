//! Configurations are states of a machine, each with its tests and its model: parts and assembly,
//! with and without an added mass, at several angles or preloads.

use std::path::Path;

use crate::geometry::Sensor;
use crate::theory::TheoryError;

use super::SceneError;
use super::configuration_tables::{BASE_CONFIGURATION, other_table};
use super::error::value_error;
use super::faults::Faults;
use super::model::{LoadedModel, table_model};
use super::model_name::first_root;
use super::plan::Scene;
use super::typed::{AddedParts, ConfigurationTable, ModelTable};

impl Scene {
    /// The configuration of a name, as a scene of its tests and its model.
    ///
    /// # Errors
    /// [`SceneError::Value`] for an unknown name; those of its model.
    pub fn configuration(&self, name: &str) -> Result<Self, SceneError> {
        let mut tables = self.configurations.iter();
        if let Some(table) = tables.find(|table| table.name == name) {
            return self.with_configuration(table);
        }
        if name == BASE_CONFIGURATION {
            return Ok(self.base());
        }
        let names = self.configurations.iter().map(|table| table.name.as_str());
        let names: Vec<&str> = [BASE_CONFIGURATION].into_iter().chain(names).collect();
        let expected = format!("one of {}", names.join(", "));
        let got = format!("{name:?}");
        Err(value_error(&self.path, "configuration", &got, &expected))
    }

    /// Every configuration with its name, the base first; a scene of one configuration alone has
    /// no others.
    ///
    /// # Errors
    /// Those of the models.
    pub fn all_configurations(&self) -> Result<Vec<(String, Self)>, SceneError> {
        let mut all = vec![(BASE_CONFIGURATION.to_owned(), self.base())];
        let mut faults = Faults::default();
        for table in &self.configurations {
            let scene = faults.take(self.with_configuration(table));
            all.extend(scene.map(|scene| (table.name.clone(), scene)));
        }
        faults.into_result().map(|()| all)
    }

    /// The base alone, without other configurations and what `[update]` states for all of them.
    pub fn base_alone(&self) -> Self {
        if self.configurations.is_empty() {
            return self.clone();
        }
        Self {
            configurations: Vec::new(),
            update: None,
            ..self.base()
        }
    }

    /// The scene of the tests that no other configuration names.
    pub fn base(&self) -> Self {
        let named = |test: &str| {
            let mut names = self.configurations.iter().flat_map(|table| &table.tests);
            names.any(|name| name == test)
        };
        self.with_tests(|test| !named(test))
    }

    fn with_configuration(&self, table: &ConfigurationTable) -> Result<Self, SceneError> {
        let mut scene = self.with_tests(|test| table.tests.iter().any(|name| name == test));
        scene.configurations.clear();
        scene.title = format!("{} ({})", self.title, table.name);
        // Limits of a mode state its frequency, which another state of the machine changes.
        scene.limits.mode.clear();
        scene.expected = None;
        // `[update]` may name parameters of other configurations.
        scene.update = None;
        let base = self.model.clone().unwrap_or_default();
        let mut model = match &table.model {
            None => base.clone(),
            Some(name) => {
                scene.first_root = first_root(Path::new(name));
                self.other_model(name, &base)?
            }
        };
        model.parameters.extend(table.parameters.clone());
        if table.model.is_some() {
            let loaded = table_model(&model, &self.folder, &self.path)?;
            scene.sensors = sensors_on(loaded.as_ref(), &self.sensors);
        }
        if !table.modify.is_empty() {
            model.added = Some(AddedParts {
                configuration: table.name.clone(),
                modify: table.modify.clone(),
                sensors: scene.sensors.clone(),
            });
        }
        scene.model = Some(model);
        Ok(scene)
    }

    /// Another model, with the values that the scene states for parameters of both.
    fn other_model(&self, name: &str, base: &ModelTable) -> Result<ModelTable, SceneError> {
        let mut table = other_table(name, base);
        let Some(model) = table_model(&table, &self.folder, &self.path)? else {
            return Ok(table);
        };
        let specs = model.model.parameters();
        let has = |name: &String| specs.iter().any(|spec| spec.name == *name);
        let stated = base.parameters.iter().filter(|(name, _)| has(name));
        table.parameters = stated.map(|(name, value)| (name.clone(), *value)).collect();
        Ok(table)
    }

    /// The same scene with some of its tests.
    fn with_tests(&self, is_kept: impl Fn(&str) -> bool) -> Self {
        let mut scene = self.clone();
        scene.tests.retain(|test| is_kept(&test.name));
        scene.placement.retain(|plan| is_kept(&plan.test));
        for table in &mut scene.tables {
            table.tests.retain(|test| is_kept(test));
        }
        scene.tables.retain(|table| !table.tests.is_empty());
        scene
    }
}

/// The sensors that are on parts of a model.
fn sensors_on(model: Option<&LoadedModel>, sensors: &[Sensor]) -> Vec<Sensor> {
    let is_on = |sensor: &&Sensor| {
        let row = model.map(|model| {
            let target = &sensor.target;
            model.model.observation_row(&model.values, target)
        });
        let unknown = TheoryError::is_of_unknown_part;
        !row.is_some_and(|row| row.is_err_and(|error| unknown(&error)))
    };
    sensors.iter().filter(is_on).cloned().collect()
}
