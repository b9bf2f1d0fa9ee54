//! A model as a scene, a spec or the command line names it: read, built, solved at the sensors.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use crate::geometry::Sensor;
use crate::io::modes_from_json;
use crate::modal::ModalModel;
use crate::theory::{
    Assumption, BeamFile, BeamModel, ModeOptions, ParameterSpec, SCHEMA, TheoreticalModel, modes,
    override_values,
};

use super::SceneError;
use super::toml_text::{parse, read_text};
use super::typed::{ModelTable, SensorTable};

/// A model that can be solved, with the values of its parameters.
#[derive(Debug)]
pub struct LoadedModel {
    /// Path as given.
    pub path: String,
    /// The model.
    pub model: Box<dyn TheoreticalModel>,
    /// Sensors that the model file itself names.
    pub sensors: Vec<Sensor>,
    /// Parameter values, in the model's order.
    pub values: Vec<f64>,
}

/// The theory's side of a comparison.
#[derive(Clone, Debug, Default)]
pub struct Theory {
    /// Its modes at the sensors.
    pub modes: ModalModel,
    /// Parameters with the values used.
    pub parameters: Vec<(ParameterSpec, f64)>,
    /// What the model takes for granted.
    pub assumptions: Vec<Assumption>,
}

/// The one key that says which kind of model a file holds.
#[derive(Deserialize)]
struct KindOnly {
    kind: String,
}

/// `[[sensor]]` of a model file, whatever its kind.
#[derive(Deserialize)]
struct SensorsOnly {
    #[serde(default)]
    sensor: Vec<SensorTable>,
}

/// Reads a `model.toml` and sets parameters by name.
///
/// # Errors
/// [`SceneError`] with file, line and column, or the model's own reason.
pub fn load_model(
    path: &Path,
    overrides: &BTreeMap<String, f64>,
) -> Result<LoadedModel, SceneError> {
    let name = path.display().to_string();
    let text = read_text(path)?;
    let model = match parse::<KindOnly>(&text, &name)?.kind.as_str() {
        "beam" => beam_model(parse::<BeamFile>(&text, &name)?, &name)?,
        other => {
            return Err(value_error(
                &name,
                "kind",
                &format!("{other:?}"),
                "\"beam\"",
            ));
        }
    };
    let tables = parse::<SensorsOnly>(&text, &name)?.sensor;
    let values = override_values(model.name(), model.parameters(), overrides)?;
    Ok(LoadedModel {
        sensors: sensors(&tables, &name)?,
        path: name,
        model: Box::new(model),
        values,
    })
}

fn beam_model(file: BeamFile, path: &str) -> Result<BeamModel, SceneError> {
    check_schema(&file.schema, SCHEMA, path)?;
    Ok(BeamModel::new(file)?)
}

/// Sensors as meant.
///
/// # Errors
/// [`SceneError::Value`] for a sensor that names neither or both of a body's point and a coordinate, or is named twice.
pub fn sensors(tables: &[SensorTable], path: &str) -> Result<Vec<Sensor>, SceneError> {
    let mut found: Vec<Sensor> = Vec::with_capacity(tables.len());
    for table in tables {
        let key = format!("[[sensor]] {}", table.dof);
        let sensor = table.sensor().ok_or_else(|| {
            value_error(
                path,
                &key,
                "another combination",
                "`body` and `at_m` (and `direction` for a scalar), or `coordinate`",
            )
        })?;
        if found.iter().any(|other| other.dof == sensor.dof) {
            return Err(value_error(
                path,
                &key,
                "the same degree of freedom twice",
                "each one once",
            ));
        }
        found.push(sensor);
    }
    Ok(found)
}

impl LoadedModel {
    /// Solves the model at the sensors.
    ///
    /// # Errors
    /// The model's own reasons.
    pub fn solve(&self, sensors: &[Sensor], options: &ModeOptions) -> Result<Theory, SceneError> {
        let solved = modes(self.model.as_ref(), &self.values, sensors, options)?;
        let parameters = self
            .model
            .parameters()
            .iter()
            .cloned()
            .zip(self.values.iter().copied())
            .collect();
        Ok(Theory {
            modes: solved.model,
            parameters,
            assumptions: self.model.assumptions(),
        })
    }
}

/// The theory that a `[model]` table means: a model file solved at the sensors, or finished modes.
///
/// # Errors
/// [`SceneError`] when it names neither or both, a name that is not built in, or a file that cannot be used.
pub fn theory(
    table: &ModelTable,
    folder: &Path,
    path: &str,
    sensors: &[Sensor],
    options: &ModeOptions,
) -> Result<Theory, SceneError> {
    let file = model_file(table, path)?;
    let full = folder.join(file);
    if full
        .extension()
        .is_some_and(|extension| extension == "json")
    {
        let text = read_text(&full)?;
        let modes = modes_from_json(&text, &full.display().to_string())?;
        return Ok(Theory {
            modes,
            ..Theory::default()
        });
    }
    let model = load_model(&full, &table.parameters)?;
    let all: Vec<Sensor> = model
        .sensors
        .iter()
        .filter(|own| !sensors.iter().any(|s| s.dof == own.dof))
        .chain(sensors)
        .cloned()
        .collect();
    model.solve(&all, options)
}

/// The file that a `[model]` table names.
///
/// # Errors
/// [`SceneError::Value`] when it names none, or a built-in model, of which there is none yet.
pub fn model_file<'a>(table: &'a ModelTable, path: &str) -> Result<&'a str, SceneError> {
    match (&table.name, &table.file) {
        (None, Some(file)) => Ok(file),
        (Some(name), _) => Err(value_error(
            path,
            "[model] name",
            &format!("{name:?}"),
            "`file` with a model.toml or a modes.json (no model is built in yet)",
        )),
        (None, None) => Err(value_error(
            path,
            "[model]",
            "no `file`",
            "`file` with a model.toml or a modes.json",
        )),
    }
}

/// Checks the `schema` key of a file.
///
/// # Errors
/// [`SceneError::Value`] for another one.
pub fn check_schema(got: &str, expected: &str, path: &str) -> Result<(), SceneError> {
    if got == expected {
        Ok(())
    } else {
        Err(value_error(
            path,
            "schema",
            &format!("{got:?}"),
            &format!("{expected:?}"),
        ))
    }
}

pub(super) fn value_error(path: &str, key: &str, got: &str, expected: &str) -> SceneError {
    SceneError::Value {
        path: path.to_owned(),
        key: key.to_owned(),
        got: got.to_owned(),
        expected: expected.to_owned(),
    }
}
