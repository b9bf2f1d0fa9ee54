//! A model that a scene, a spec or the command line names is read, built and solved at the sensors.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::axis::Band;
use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::geometry::{Geometry, Node, Sensor, Target};
use crate::linalg::{RealMatrix, SparseMatrix};
use crate::modal::ModalModel;
use crate::theory::{
    Assumption, BeamFile, BeamModel, DetailComparison, LumpedFile, LumpedModel, ModeOptions,
    ModelQuantity, ModelRoot, ModelSupport, ParameterSpec, ReleasedMode, ResponseSpan,
    RootSensitivity, Sweep, SweepRange, TheoreticalModel, TheoryError, TheoryModes, TimeResponse,
    built_in, compare_details, coordinate_sensors, damped_model, model_roots, model_sensitivities,
    model_support, modes, override_values, released_modes, sweep,
};

use super::error::{SceneError, model_error, value_error};
use super::faults::{Faults, parse_checked};
use super::matrices::matrix_model;
use super::model_name::{is_built_in, named_model};
use super::modes_file::{LoadedModes, ModesOptions, is_modes_file, load_modes};
use super::sensor_findings::sensor_findings;
use super::toml_text::{parse, read_text};
use super::typed::{ModelTable, SensorTable};

/// A model that can be solved, with the values of its parameters.
#[derive(Debug)]
pub struct LoadedModel {
    /// The model.
    pub model: Box<dyn TheoreticalModel>,
    /// Sensors that the model file names; none for a built-in model.
    pub sensors: Vec<Sensor>,
    /// Parameter values, in the model's order.
    pub values: Vec<f64>,
    /// Parameters of a model file that no part of the model uses.
    pub unused: Vec<String>,
    /// Whether the model file says that its values are those of an example.
    pub example_values: bool,
}

/// The theory's side of a comparison.
#[derive(Clone, Debug, Default)]
pub struct Theory {
    /// Its modes at the sensors.
    pub modes: ModalModel,
    /// Parameters with the values used.
    pub parameters: Vec<(ParameterSpec, f64)>,
    /// Assumptions of the model.
    pub assumptions: Vec<Assumption>,
    /// Positions of the points, as far as the file or the sensors state them.
    pub geometry: Geometry,
    /// Distinct roots of the whole model, whatever band or number of `modes` was asked for; the
    /// indices in them count all its modes. None for finished modes.
    pub roots: Vec<ModelRoot>,
    /// How the model is held; nothing is known of finished modes.
    pub support: ModelSupport,
    /// Whether part of a file of finished modes was bad and left out.
    pub partly_bad: bool,
}

impl From<LoadedModes> for Theory {
    fn from(loaded: LoadedModes) -> Self {
        Self {
            modes: loaded.modes,
            geometry: loaded.geometry,
            partly_bad: loaded.partly_bad,
            ..Self::default()
        }
    }
}

/// The keys that state the kind of a model file, or show it where it is not stated.
#[derive(Deserialize)]
struct KindKeys {
    kind: Option<String>,
    matrices: Option<IgnoredAny>,
    beam: Option<IgnoredAny>,
    body: Option<IgnoredAny>,
}

impl KindKeys {
    /// The kind that is stated, or that of the parts; `None` where neither is, as in lumped models.
    fn kind(self) -> Option<String> {
        let shown = match (self.matrices, self.beam, self.body) {
            (Some(_), ..) => Some("matrices"),
            (None, Some(_), None) => Some("beam"),
            _ => None,
        };
        self.kind.or_else(|| shown.map(str::to_owned))
    }
}

/// The key that says that the values of a model file are those of an example; the model itself
/// checks its type.
#[derive(Default, Deserialize)]
struct ExampleKey {
    #[serde(default)]
    example_values: bool,
}

/// `[[sensor]]` tables of a model file of any kind.
#[derive(Default, Deserialize)]
struct SensorTables {
    #[serde(default)]
    sensor: Vec<SensorTable>,
}

/// The model of a built-in name (`cycloid-ball`, `cycloid-ball/D`) or of a `model.toml`, its
/// parameters set by name.
///
/// # Errors
/// [`SceneError`] with file, line and column, or the error of the model.
pub fn load_model(
    name: &Path,
    overrides: &BTreeMap<String, f64>,
) -> Result<LoadedModel, SceneError> {
    if is_built_in(name) {
        return with_parameters(
            built_in(&name.display().to_string())?,
            Vec::new(),
            overrides,
        );
    }
    model_of_text(&read_text(name)?, name, overrides)
}

/// The model of the text of a `model.toml` with this name.
pub(super) fn model_of_text(
    text: &str,
    name: &Path,
    overrides: &BTreeMap<String, f64>,
) -> Result<LoadedModel, SceneError> {
    let path = name.display().to_string();
    let kind = parse::<KindKeys>(text, &path)?.kind();
    let mut faults = Faults::default();
    let tables = faults.take(parse::<SensorTables>(text, &path));
    let tables = tables.unwrap_or_default().sensor;
    let sensors_of_file = faults.take(sensors(&tables, &path)).unwrap_or_default();
    let model = faults.take(model_of_kind(kind.as_deref(), text, name));
    let (model, sensors_of_matrices) = faults.located(&path, text).finish(model)?;
    let sensors = match sensors_of_file.is_empty() {
        true => sensors_of_matrices,
        false => sensors_of_file,
    };
    let mut loaded = with_parameters(model, sensors, overrides)?;
    loaded.unused = unused_parameters(loaded.model.as_ref(), &loaded.values);
    loaded.example_values = parse::<ExampleKey>(text, &path)?.example_values;
    Ok(loaded)
}

/// The model of a kind, with the sensors that matrices have.
type ModelOfKind = (Box<dyn TheoreticalModel>, Vec<Sensor>);

fn model_of_kind(kind: Option<&str>, text: &str, name: &Path) -> Result<ModelOfKind, SceneError> {
    let path = name.display().to_string();
    Ok(match kind {
        Some("matrices") => {
            let folder = name.parent().unwrap_or(Path::new(""));
            let model = matrix_model(text, &path, folder)?;
            let sensors = model.sensors();
            (Box::new(model), sensors)
        }
        Some("beam") => {
            let beam = |file: BeamFile, _| {
                let model = BeamModel::new(file);
                model.map_err(|source| model_error(&path, source))
            };
            (Box::new(parse_checked(text, &path, beam)?), Vec::new())
        }
        Some("lumped") | None => {
            let lumped = |file: LumpedFile, _| {
                let model = LumpedModel::new(file);
                model.map_err(|source| model_error(&path, source))
            };
            (Box::new(parse_checked(text, &path, lumped)?), Vec::new())
        }
        Some(other) => {
            let got = format!("{other:?}");
            let expected = "\"lumped\", \"beam\" or \"matrices\"";
            return Err(value_error(&path, "kind", &got, expected));
        }
    })
}

/// The parameters on which neither mass, damping nor stiffness depends. A part of a model file has
/// a parameter as a factor, so that one derivative shows its use. None for a sparse model with a
/// damping matrix.
fn unused_parameters(model: &dyn TheoreticalModel, values: &[f64]) -> Vec<String> {
    let is_zero = |matrix: &RealMatrix| matrix.norm_max() == 0.0;
    let is_unused = |j: usize| match model.sparse_derivative(values, j) {
        // The derivative of sparse matrices has no damping.
        Ok(Some(_)) if has_sparse_damping(model, values) => false,
        Ok(Some(by)) => [by.mass, by.stiffness]
            .iter()
            .flat_map(SparseMatrix::entries)
            .all(|(_, _, value)| value == 0.0),
        Ok(None) => model.derivative(values, j).is_ok_and(|by| {
            let matrices = [Some(&by.mass), by.damping.as_ref(), Some(&by.stiffness)];
            matrices.into_iter().flatten().all(is_zero)
        }),
        // Solving the model reports the error.
        Err(_) => false,
    };
    let specs = model.parameters().iter().enumerate();
    let unused = specs.filter(|(j, _)| is_unused(*j));
    unused.map(|(_, spec)| spec.name.clone()).collect()
}

fn has_sparse_damping(model: &dyn TheoreticalModel, values: &[f64]) -> bool {
    let system = model.sparse(values);
    system.is_ok_and(|system| system.is_some_and(|system| system.damping.is_some()))
}

fn with_parameters(
    model: Box<dyn TheoreticalModel>,
    sensors: Vec<Sensor>,
    overrides: &BTreeMap<String, f64>,
) -> Result<LoadedModel, SceneError> {
    let values = override_values(model.name(), model.parameters(), overrides)?;
    Ok(LoadedModel {
        sensors,
        model,
        values,
        unused: Vec::new(),
        example_values: false,
    })
}

/// The sensors of `[[sensor]]` tables.
///
/// # Errors
/// [`SceneError::Value`] for a sensor that names neither or both of a body's point and a
/// coordinate, or is named twice.
pub fn sensors(tables: &[SensorTable], path: &str) -> Result<Vec<Sensor>, SceneError> {
    let mut found: Vec<Sensor> = Vec::with_capacity(tables.len());
    let mut faults = Faults::default();
    for table in tables {
        let key = format!("[[sensor]] {}", table.dof);
        let Some(sensor) = table.sensor() else {
            let expected = "`body` and `at_m` (and `direction` for a scalar), or `coordinate`";
            faults.add(value_error(path, &key, "another combination", expected));
            continue;
        };
        if found.iter().any(|other| other.dof == sensor.dof) {
            let got = "the same degree of freedom twice";
            faults.add(value_error(path, &key, got, "each one once"));
            continue;
        }
        found.push(sensor);
    }
    faults.into_result().map(|()| found)
}

impl LoadedModel {
    /// Solves the model at the sensors; without any at its coordinates, as far as body and axis
    /// name them.
    ///
    /// # Errors
    /// The error of the model.
    pub fn solve(&self, sensors: &[Sensor], options: &ModeOptions) -> Result<Theory, SceneError> {
        let default_sensors = match sensors {
            [] => coordinate_sensors(&self.model.assemble(&self.values)?.coordinates),
            _ => Vec::new(),
        };
        let sensors = if sensors.is_empty() {
            &default_sensors
        } else {
            sensors
        };
        let mut solved = modes(self.model.as_ref(), &self.values, sensors, options)?;
        let unused = self.unused.iter().map(|name| {
            let location = Location::Parameter(name.clone());
            Finding::new(Severity::Warning, Code::ParameterUnused, location)
        });
        solved.model.findings.extend(unused);
        if self.example_values {
            let finding = Finding::new(Severity::Warning, Code::ExampleValues, Location::Whole);
            solved.model.findings.push(finding);
        }
        if default_sensors.is_empty() {
            let of_sensors = sensor_findings(self.model.as_ref(), &self.values, sensors)?;
            solved.model.findings.extend(of_sensors);
        }
        let parameters = self
            .model
            .parameters()
            .iter()
            .cloned()
            .zip(self.values.iter().copied())
            .collect();
        Ok(Theory {
            roots: self.roots(&solved, options)?,
            modes: solved.model,
            geometry: sensor_nodes(sensors),
            parameters,
            assumptions: self.model.assumptions(),
            support: model_support(self.model.as_ref(), &self.values)?,
            partly_bad: false,
        })
    }

    /// Modes with the damping matrix as it is at sensors, those of the coordinates where there are
    /// none.
    ///
    /// # Errors
    /// [`SceneError::Theory`] with those of [`damped_model`].
    pub fn solve_damped(
        &self,
        sensors: &[Sensor],
        band: Option<Band>,
    ) -> Result<ModalModel, SceneError> {
        let all_sensors = match sensors {
            [] => coordinate_sensors(&self.model.assemble(&self.values)?.coordinates),
            _ => sensors.to_vec(),
        };
        Ok(damped_model(
            self.model.as_ref(),
            &self.values,
            &all_sensors,
            band,
        )?)
    }

    /// The model file's sensors and those of a scene, which replace equal ones of the model file.
    pub fn sensors_with(&self, sensors: &[Sensor]) -> Vec<Sensor> {
        let sensors_of_model = self.sensors.iter();
        let unreplaced =
            sensors_of_model.filter(|sensor| !sensors.iter().any(|s| s.dof == sensor.dof));
        unreplaced.chain(sensors).cloned().collect()
    }

    /// The quantities that the model's theory gives in addition to its roots.
    ///
    /// # Errors
    /// The error of the model.
    pub fn quantities(&self) -> Result<Vec<ModelQuantity>, SceneError> {
        Ok(self.model.quantities(&self.values)?)
    }

    /// The roots of the whole model with their sensitivities to its parameters; of a sparse model
    /// the roots inside a band, or the lowest.
    ///
    /// # Errors
    /// The error of the model.
    pub fn sensitivities(&self, band: Option<Band>) -> Result<Vec<RootSensitivity>, SceneError> {
        let model = self.model.as_ref();
        let sparse = self.is_sparse()?;
        let options = ModeOptions {
            band: band.filter(|_| sparse),
            ..ModeOptions::default()
        };
        let solved = modes(model, &self.values, &[], &options)?;
        let roots = model_roots(model, &solved);
        Ok(model_sensitivities(model, &self.values, &solved, &roots)?)
    }

    /// The elastic modes with their frequencies without the stiffness to ground; `None` where that
    /// stiffness is unknown.
    ///
    /// # Errors
    /// The error of the model.
    pub fn released_modes(&self) -> Result<Option<Vec<ReleasedMode>>, SceneError> {
        Ok(released_modes(self.model.as_ref(), &self.values)?)
    }

    /// The model against simpler ones without the mass of its small bodies.
    ///
    /// # Errors
    /// The error of the model.
    pub fn compare_details(&self) -> Result<DetailComparison, SceneError> {
        Ok(compare_details(self.model.as_ref(), &self.values)?)
    }

    /// The steady response over time in growing detail.
    ///
    /// # Errors
    /// [`SceneError::Value`] for a model that is its matrices alone; the error of the model.
    pub fn response(&self) -> Result<TimeResponse, SceneError> {
        let nonlinear = self.model.nonlinear().ok_or_else(|| {
            let got = "a model that is its matrices alone";
            value_error(
                self.model.name(),
                "response",
                got,
                "a model with equations of motion: helical-planetary",
            )
        })?;
        Ok(nonlinear.response(&self.values, ResponseSpan::default())?)
    }

    /// The roots followed over a range of a parameter, by its name; of a sparse model those up to a
    /// band's end, or the lowest.
    ///
    /// # Errors
    /// The error of the model.
    pub fn sweep(
        &self,
        parameter: &str,
        range: SweepRange,
        band: Option<Band>,
    ) -> Result<Sweep, SceneError> {
        let model = self.model.as_ref();
        Ok(sweep(model, &self.values, parameter, range, band)?)
    }

    /// Whether only the lowest modes can be computed.
    fn is_sparse(&self) -> Result<bool, SceneError> {
        Ok(self.model.sparse(&self.values)?.is_some())
    }

    /// The roots of the whole model, solved again when the options kept part of its modes; of a
    /// sparse one those of the modes that were computed.
    fn roots(
        &self,
        solved: &TheoryModes,
        options: &ModeOptions,
    ) -> Result<Vec<ModelRoot>, SceneError> {
        let whole = options.band.is_none() && options.count.is_none();
        if whole || self.is_sparse()? {
            return Ok(model_roots(self.model.as_ref(), solved));
        }
        let all = ModeOptions {
            band: None,
            count: None,
            ..options.clone()
        };
        let whole = modes(self.model.as_ref(), &self.values, &[], &all)?;
        Ok(model_roots(self.model.as_ref(), &whole))
    }
}

/// The points of sensors that sit on bodies.
fn sensor_nodes(sensors: &[Sensor]) -> Geometry {
    let mut geometry = Geometry::default();
    for sensor in sensors {
        if let Target::BodyPoint { at_m, .. } = &sensor.target
            && geometry.node(sensor.dof.point()).is_none()
        {
            let node = Node::new(sensor.dof.point(), (*at_m).into());
            geometry.nodes.push(node);
        }
    }
    geometry
}

/// The theory that a `[model]` table means: a built-in model or a model file solved at the sensors,
/// or finished modes.
///
/// # Errors
/// [`SceneError`] when it names neither or both, a name that is not built in, or a file that cannot
/// be used.
pub fn theory(
    table: &ModelTable,
    folder: &Path,
    path: &str,
    sensors: &[Sensor],
    options: &ModeOptions,
) -> Result<Theory, SceneError> {
    open_model(table, folder, path, sensors)?.theory(sensors, options)
}

/// A model that a `[model]` table means, read and checked.
#[derive(Debug)]
pub(super) enum OpenedModel {
    /// A built-in model or a model file.
    Model(LoadedModel),
    /// Finished modes.
    Modes(LoadedModes),
}

impl OpenedModel {
    /// The model solved at the sensors, or its finished modes.
    ///
    /// # Errors
    /// The error of the model.
    pub(super) fn theory(
        self,
        sensors: &[Sensor],
        options: &ModeOptions,
    ) -> Result<Theory, SceneError> {
        match self {
            OpenedModel::Model(model) => model.solve(&model.sensors_with(sensors), options),
            OpenedModel::Modes(modes) => Ok(modes.into()),
        }
    }
}

/// Reads the model of a `[model]` table and checks that it has a place for every sensor.
///
/// # Errors
/// As [`theory`].
pub(super) fn open_model(
    table: &ModelTable,
    folder: &Path,
    path: &str,
    sensors: &[Sensor],
) -> Result<OpenedModel, SceneError> {
    let model = table_model(table, folder, path);
    let model = model.map_err(|error| with_body_faults(error, table, folder, path, sensors))?;
    let Some(model) = model else {
        let options = ModesOptions {
            partial: table.partial,
            ..ModesOptions::default()
        };
        let modes = load_modes(&named_model(table, folder, path)?, &options)?;
        return Ok(OpenedModel::Modes(modes));
    };
    let mut faults = Faults::default();
    for sensor in model.sensors_with(sensors) {
        let row = model.model.observation_row(&model.values, &sensor.target);
        let is_of_scene = sensors.iter().any(|other| other.dof == sensor.dof);
        let of_sensor = |error: TheoryError| match is_of_scene {
            true => sensor_error(path, &sensor.dof, error),
            false => error.into(),
        };
        faults.take(row.map_err(of_sensor));
    }
    faults.into_result().map(|()| OpenedModel::Model(model))
}

/// The error of a model with those of the sensors on bodies that its file does not name.
fn with_body_faults(
    error: SceneError,
    table: &ModelTable,
    folder: &Path,
    path: &str,
    sensors: &[Sensor],
) -> SceneError {
    let file = named_model(table, folder, path);
    let text = file.ok().and_then(|file| read_text(&file).ok());
    let bodies = text.and_then(|text| named_bodies(&text));
    let Some(bodies) = bodies else {
        return error;
    };
    let mut faults = Faults::default();
    faults.add(error);
    for sensor in sensors {
        if let Target::BodyPoint { body, .. } = &sensor.target
            && !bodies.contains(body)
        {
            let unknown = TheoryError::unknown_body("sensor", body, bodies.clone());
            faults.add(sensor_error(path, &sensor.dof, unknown));
        }
    }
    let Err(error) = faults.into_result() else {
        unreachable!("the error of the model is one of the faults");
    };
    error
}

/// Keys of the lists of a model file of bodies or beams.
const LISTS: [&str; 7] = [
    "parameter",
    "body",
    "beam",
    "point",
    "point_mass",
    "spring",
    "sensor",
];

/// The names of the bodies or beams of a model file; `None` where one has none, there are none, or
/// a list of another key may hold them.
fn named_bodies(text: &str) -> Option<Vec<String>> {
    let file: toml::Table = text.parse().ok()?;
    let is_misspelt =
        |(key, value): (&String, &toml::Value)| value.is_array() && !LISTS.contains(&key.as_str());
    if file.iter().any(is_misspelt) {
        return None;
    }
    let parts = ["body", "beam"]
        .into_iter()
        .filter_map(|key| file.get(key)?.as_array());
    let name = |part: &toml::Value| Some(part.get("name")?.as_str()?.to_owned());
    let names: Option<Vec<String>> = parts.flatten().map(name).collect();
    names.filter(|names| !names.is_empty())
}

/// The error of a sensor without a place in the model, with its key in the scene.
fn sensor_error(path: &str, dof: &Dof, error: TheoryError) -> SceneError {
    let text = error.to_string();
    let parts = text.strip_prefix("sensor: got ");
    match parts.and_then(|parts| parts.split_once(", expected ")) {
        Some((got, expected)) => value_error(path, &format!("[[sensor]] {dof}"), got, expected),
        None => error.into(),
    }
}

/// The model that a `[model]` table means with its parameters; `None` for finished modes.
///
/// # Errors
/// As [`theory`].
pub fn table_model(
    table: &ModelTable,
    folder: &Path,
    path: &str,
) -> Result<Option<LoadedModel>, SceneError> {
    let named = named_model(table, folder, path)?;
    if is_modes_file(&named) {
        return Ok(None);
    }
    let model = load_model(&named, &table.parameters)?;
    let Some(added) = &table.added else {
        return Ok(Some(model));
    };
    let sensors = model.sensors_with(&added.sensors);
    let place = format!("{path}: [[configuration]] {:?} modify", added.configuration);
    let modified = LoadedModel { sensors, ..model }.modified_as(&place, &added.modify)?;
    Ok(Some(modified.model))
}
