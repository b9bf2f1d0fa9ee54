//! Configurations are states of one machine, each with its model and tests; parameters of the same
//! name are shared by their models.
//!
//! A parameter that is held in a configuration keeps the value of its model there. One that is
//! separate has another free value there, named `NAME (CONFIGURATION)`.

use std::ops::Range;

use crate::dof::Dof;
use crate::geometry::Sensor;
use crate::theory::{ParameterSpec, SystemDerivative, TheoreticalModel};

use super::model_state::ModelState;
use super::{FreeParameter, MeasuredModes, ParameterChoice, UpdateError, UpdateOptions};

/// A configuration of a machine: a model of it with its tests. Those of the first one are of the
/// model that is updated.
#[derive(Clone, Copy, Debug)]
pub struct Configuration<'a, 'b> {
    /// Name.
    pub name: &'b str,
    /// Model.
    pub model: &'a dyn TheoreticalModel,
    /// Values of its parameters.
    pub values: &'b [f64],
    /// Sensors on it.
    pub sensors: &'a [Sensor],
    /// Modes of its tests.
    pub measured: &'b [MeasuredModes<'b>],
    /// Parameters that keep the values of this model.
    pub held: &'b [String],
    /// Free parameters that have another value here than elsewhere.
    pub separate: &'b [String],
}

/// A configuration of an update problem.
#[derive(Clone, Debug)]
pub(super) struct Part<'a> {
    pub name: String,
    pub model: &'a dyn TheoreticalModel,
    pub sensors: &'a [Sensor],
    /// Values of all parameters of the model at the start.
    initial: Vec<f64>,
    /// Place of each free parameter among those of the model; `None` where it is not one of them.
    places: Vec<Option<usize>>,
    /// Its tests.
    pub tests: Range<usize>,
}

impl Part<'_> {
    /// The same part with some of the free parameters.
    pub fn with_free(&self, places: &[usize]) -> Self {
        Self {
            places: places.iter().map(|&j| self.places[j]).collect(),
            ..self.clone()
        }
    }

    /// The same part with a free parameter that it does not have.
    pub fn with_another(&self) -> Self {
        let mut places = self.places.clone();
        places.push(None);
        Self {
            places,
            ..self.clone()
        }
    }

    /// The same part with a free parameter of it in the place of the last one.
    pub fn with_separate(&self, j: usize) -> Self {
        let mut places = self.places.clone();
        let place = places[j].take();
        places.push(place);
        Self {
            places,
            ..self.clone()
        }
    }

    /// All parameters of the model for these values of the free ones.
    pub fn values(&self, free: &[f64]) -> Vec<f64> {
        let mut values = self.initial.clone();
        for (place, value) in self.places.iter().zip(free) {
            if let Some(place) = *place {
                values[place] = *value;
            }
        }
        values
    }

    /// Whether the model has a free parameter.
    pub fn has(&self, j: usize) -> bool {
        self.places[j].is_some()
    }

    /// Derivatives of the matrices by each free parameter; `None` for one that the model does not
    /// have.
    pub fn derivatives(
        &self,
        state: &ModelState,
    ) -> Result<Vec<Option<SystemDerivative>>, UpdateError> {
        let by = |place: &Option<usize>| {
            let by = place.map(|j| self.model.derivative(&state.values, j));
            Ok(by.transpose()?)
        };
        self.places.iter().map(by).collect()
    }

    /// The sensors of the model, each with its observation row at the start.
    pub fn observation_rows(&self) -> Result<Vec<(Dof, Vec<f64>)>, UpdateError> {
        let row = |sensor: &Sensor| {
            let row = self.model.observation_row(&self.initial, &sensor.target)?;
            Ok((sensor.dof.positive(), row))
        };
        self.sensors.iter().map(row).collect()
    }
}

/// The configurations with their tests numbered through, and the free parameters.
pub(super) fn parts_of<'a>(
    configurations: &[Configuration<'a, '_>],
    choices: &[ParameterChoice],
    options: &UpdateOptions,
) -> Result<(Vec<Part<'a>>, Vec<FreeParameter>), UpdateError> {
    let mut free = Vec::with_capacity(choices.len());
    // For each free parameter its name in the models, and the only configuration that has it.
    let mut names: Vec<(&str, Option<usize>)> = Vec::with_capacity(choices.len());
    for (number, choice) in choices.iter().enumerate() {
        let mut before = choices[..number].iter();
        if before.any(|other| other.name == choice.name) {
            return Err(unknown(configurations, &choice.name, "named twice"));
        }
        let has = |configuration: &&Configuration<'_, '_>| {
            shares(configuration, &choice.name) && position(configuration, &choice.name).is_some()
        };
        let mut separate = configurations.iter().flat_map(|other| other.separate);
        let first = match configurations.iter().find(has) {
            Some(first) => first,
            None if separate.any(|name| *name == choice.name) => continue,
            None => return Err(unknown(configurations, &choice.name, "there is none")),
        };
        names.push((&choice.name, None));
        let parameter = FreeParameter::new(first.model, first.values, choice, options)?;
        let is_of_base = first.name == configurations[0].name;
        free.push(FreeParameter {
            configuration: (!is_of_base).then(|| first.name.to_owned()),
            ..parameter
        });
    }
    for (c, configuration) in configurations.iter().enumerate() {
        for name in configuration.separate {
            let choice = choices.iter().find(|choice| choice.name == *name);
            let choice = choice.ok_or_else(|| UpdateError::Separate {
                name: name.clone(),
                configuration: configuration.name.to_owned(),
                free: choices.iter().map(|choice| choice.name.clone()).collect(),
            })?;
            let (model, values) = (configuration.model, configuration.values);
            let parameter = FreeParameter::new(model, values, choice, options)?;
            names.push((&choice.name, Some(c)));
            free.push(FreeParameter {
                name: format!("{name} ({})", configuration.name),
                configuration: Some(configuration.name.to_owned()),
                ..parameter
            });
        }
    }
    if free.is_empty() {
        return Err(UpdateError::NothingFree);
    }
    let mut first_test = 0;
    let mut parts = Vec::with_capacity(configurations.len());
    for (c, configuration) in configurations.iter().enumerate() {
        let place = |(name, only): &(&str, Option<usize>)| match only {
            Some(only) => position(configuration, name).filter(|_| *only == c),
            None => position(configuration, name).filter(|_| shares(configuration, name)),
        };
        let places: Vec<Option<usize>> = names.iter().map(place).collect();
        if configurations.len() > 1 && places.iter().all(Option::is_none) {
            return Err(UpdateError::NothingShared {
                configuration: configuration.name.to_owned(),
                free: choices.iter().map(|choice| choice.name.clone()).collect(),
            });
        }
        for (place, parameter) in places.iter().zip(&mut free) {
            let Some(place) = *place else {
                continue;
            };
            // The bounds of every model that has the parameter.
            let spec = &configuration.model.parameters()[place];
            parameter.lower = parameter.lower.max(spec.lower.unwrap_or(f64::NEG_INFINITY));
            parameter.upper = parameter.upper.min(spec.upper.unwrap_or(f64::INFINITY));
            let value = configuration.values[place];
            if (value - parameter.initial).abs() > MAX_SHARED_DIFFERENCE * parameter.initial.abs() {
                return Err(UpdateError::SharedValue {
                    name: parameter.name.clone(),
                    configuration: configuration.name.to_owned(),
                    got: value,
                    expected: parameter.initial,
                });
            }
        }
        let tests = first_test..first_test + configuration.measured.len();
        first_test = tests.end;
        parts.push(Part {
            name: configuration.name.to_owned(),
            model: configuration.model,
            sensors: configuration.sensors,
            initial: configuration.values.to_vec(),
            places,
            tests,
        });
    }
    Ok((parts, free))
}

/// Maximum relative difference of two writings of a value. Larger: a shared parameter has two
/// values. Smaller: rounding of a file's decimal figures is a difference. Test
/// `a_shared_parameter_has_one_value_at_the_start`.
const MAX_SHARED_DIFFERENCE: f64 = 1e-12;

/// Whether a parameter of this name follows the shared value in a configuration.
fn shares(configuration: &Configuration<'_, '_>, name: &str) -> bool {
    let is_named = |list: &[String]| list.iter().any(|other| other == name);
    !is_named(configuration.held) && !is_named(configuration.separate)
}

fn position(configuration: &Configuration<'_, '_>, name: &str) -> Option<usize> {
    let specs = configuration.model.parameters();
    specs.iter().position(|spec| spec.name == name)
}

fn unknown(
    configurations: &[Configuration<'_, '_>],
    name: &str,
    reason: &'static str,
) -> UpdateError {
    let specs = configurations
        .iter()
        .flat_map(|configuration| configuration.model.parameters());
    let mut known: Vec<String> = Vec::new();
    for ParameterSpec { name, .. } in specs {
        if !known.contains(name) {
            known.push(name.clone());
        }
    }
    UpdateError::Parameter {
        name: name.to_owned(),
        reason,
        known,
    }
}
