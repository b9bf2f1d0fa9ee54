//! Stated changes of a model (`mass:3=0.05`, `k_a*=1.1`) and targets of its natural frequencies
//! (`f3 > 2600`) are read as the command line states them.

use crate::axis::Band;
use crate::dof::{Axis, Dof};
use crate::geometry::{Sensor, Target};
use crate::theory::{
    AddedKind, Addition, Coordinate, ModelRoot, ModifiedModel, TheoreticalModel,
    coordinate_sensors, override_values,
};
use crate::update::{
    FreeParameter, FrequencyTarget, Goal, ParameterChoice, UpdateOptions, design_parameters,
};

use super::error::{SceneError, value_error};
use super::faults::Faults;
use super::model::LoadedModel;
use super::typed::UpdateTable;
use super::update::{ChoosableModel, choices};

/// Syntax of a change.
const CHANGES: &str = "mass:POINT=KG, mass:DOF=KG, spring:DOF=N/m, spring:DOF,DOF=N/m, \
                       damper:DOF=Ns/m, damper:DOF,DOF=Ns/m, NAME=VALUE or NAME*=FACTOR";
/// Syntax of a target.
const TARGETS: &str =
    "\"f3 > 2600\", \"f3 < 2600\", \"f3 = 2600\" or \"f3 outside 2400:2600\" in Hz";
/// Maximum number of names that an error lists.
const MAX_LISTED: usize = 12;

/// A model with stated changes.
#[derive(Debug)]
pub struct ModifiedScene {
    /// The model after the changes.
    pub model: LoadedModel,
    /// Its values before them.
    pub before: BeforeChanges,
}

/// The values of a modified model before its changes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BeforeChanges {
    /// The values, in the order of the modified model.
    pub values: Vec<f64>,
    /// Change of each value after per change of the value before: 1, a stated factor, or 0 of a
    /// value that is set.
    pub factors: Vec<f64>,
}

/// A stated bound of a parameter in a design.
#[derive(Clone, Debug, PartialEq)]
pub struct StatedBounds {
    /// Parameter.
    pub name: String,
    /// Smallest value.
    pub lower: f64,
    /// Largest value.
    pub upper: f64,
}

/// A design as the command line and a scene state it.
#[derive(Clone, Copy, Debug)]
pub struct StatedDesign<'a> {
    /// Targets of natural frequencies.
    pub targets: &'a [String],
    /// Roots of the model, whose numbers the targets name.
    pub roots: &'a [ModelRoot],
    /// Number of the first elastic root in labels.
    pub first_root: usize,
    /// `[update]` of the scene, as far as there is one.
    pub update: Option<&'a UpdateTable>,
    /// Path of the scene.
    pub path: &'a str,
    /// Parameters that may change.
    pub names: &'a [String],
    /// Bounds.
    pub bounds: &'a [StatedBounds],
}

impl LoadedModel {
    /// The model with stated changes, in their order.
    ///
    /// # Errors
    /// [`SceneError::Value`] for each change that cannot be read, or names a point, a coordinate or
    /// a parameter that the model does not have.
    pub fn modified(self, changes: &[String]) -> Result<ModifiedScene, SceneError> {
        self.modified_as("--modify", changes)
    }

    /// The same, with errors that state where the changes stand.
    pub(super) fn modified_as(
        self,
        place: &str,
        changes: &[String],
    ) -> Result<ModifiedScene, SceneError> {
        let motions = Motions::of(&self)?;
        let mut faults = Faults::default();
        let mut values = self.values.clone();
        let mut factors = vec![1.0; values.len()];
        let mut additions = Vec::new();
        for change in changes {
            let error = |(got, expected): Fault| value_error(place, change, &got, &expected);
            match read_change(change) {
                Err(fault) => faults.add(error(fault)),
                Ok(Change::Added(kind, ends, amount)) => {
                    let rows = motions.rows(kind, ends).map_err(error);
                    additions.extend(
                        faults
                            .take(rows)
                            .map(|rows| Addition { kind, rows, amount }),
                    );
                }
                Ok(Change::Value {
                    name,
                    amount,
                    is_factor,
                }) => {
                    let specs = self.model.parameters();
                    let index = specs.iter().position(|spec| spec.name == name);
                    let value = index.map_or(amount, |j| match is_factor {
                        true => values[j] * amount,
                        false => amount,
                    });
                    let stated = [(name.to_owned(), value)].into();
                    faults.take(
                        override_values(self.model.name(), specs, &stated)
                            .map_err(SceneError::from),
                    );
                    let Some(j) = index else { continue };
                    if specs[j].whole {
                        let got = "a number of parts, which changes the coordinates".to_owned();
                        let expected = "--set for it, before and after".to_owned();
                        faults.add(error((got, expected)));
                    }
                    values[j] = value;
                    factors[j] = if is_factor { factors[j] * amount } else { 0.0 };
                }
            }
        }
        faults.into_result()?;
        let mut before = self.values.clone();
        let model: Box<dyn TheoreticalModel> = match additions.is_empty() {
            true => self.model,
            false => {
                before.push(0.0);
                values.push(1.0);
                factors.push(0.0);
                Box::new(ModifiedModel::new(self.model, additions)?)
            }
        };
        let model = LoadedModel {
            model,
            values,
            ..self
        };
        let before = BeforeChanges {
            values: before,
            factors,
        };
        Ok(ModifiedScene { model, before })
    }

    /// The targets and the parameters of a stated design.
    ///
    /// # Errors
    /// [`SceneError::Value`] for each target that cannot be read or names a mode that the model
    /// does not have, and for each parameter that it does not have; those of a free parameter.
    pub fn design(
        &self,
        stated: &StatedDesign<'_>,
    ) -> Result<(Vec<FrequencyTarget>, Vec<FreeParameter>), SceneError> {
        let mut faults = Faults::default();
        let targets = faults.take(frequency_targets(stated));
        let free = faults.take(self.free_parameters(stated));
        faults.finish(targets.zip(free))
    }

    /// The named parameters; else those of `[update]`, else the stiffnesses; and those with stated
    /// bounds.
    fn free_parameters(&self, stated: &StatedDesign<'_>) -> Result<Vec<FreeParameter>, SceneError> {
        let mut faults = Faults::default();
        let specs = self.model.parameters();
        let bounded = stated.bounds.iter().map(|bounds| &bounds.name);
        let within = bounded.clone().map(|name| ("--within", name));
        for (option, name) in stated
            .names
            .iter()
            .map(|name| ("--free", name))
            .chain(within)
        {
            if !specs.iter().any(|spec| spec.name == *name) {
                let known = specs.iter().map(|spec| spec.name.as_str());
                let expected = format!("a parameter of the model: {}", listed(known));
                faults.add(value_error(option, name, &format!("`{name}`"), &expected));
            }
        }
        faults.into_result()?;
        let table = stated.update.cloned().unwrap_or_default();
        let model = ChoosableModel {
            model: self,
            held: &[],
        };
        let mut all = choices(&table, &[model], stated.path)?;
        if !stated.names.is_empty() {
            all.retain(|choice| stated.names.contains(&choice.name));
        }
        for name in stated.names.iter().chain(bounded) {
            if !all.iter().any(|choice| choice.name == *name) {
                all.push(ParameterChoice {
                    name: name.clone(),
                    ..ParameterChoice::default()
                });
            }
        }
        for bounds in stated.bounds {
            let choice = all.iter_mut().find(|choice| choice.name == bounds.name);
            if let Some(choice) = choice {
                choice.lower = Some(bounds.lower);
                choice.upper = Some(bounds.upper);
            }
        }
        let default = UpdateOptions::default().prior_std;
        let std = stated
            .update
            .map_or(1.0, |table| table.prior_std.unwrap_or(default));
        Ok(design_parameters(
            self.model.as_ref(),
            &self.values,
            &all,
            std,
        )?)
    }
}

/// The targets, by the labels of the table of modes.
fn frequency_targets(stated: &StatedDesign<'_>) -> Result<Vec<FrequencyTarget>, SceneError> {
    let rigid = stated
        .roots
        .iter()
        .filter(|root| root.omega_rad_s <= 0.0)
        .count();
    let first = stated.first_root;
    let last = first + stated.roots.len() - rigid;
    let mut faults = Faults::default();
    let mut targets = Vec::new();
    for text in stated.targets {
        let found = read_target(text).and_then(|(number, goal)| {
            let names = format!("a mode of the model: f{first} to f{}", last.max(1) - 1);
            let known = (first..last).contains(&number);
            let target = known.then(|| FrequencyTarget {
                root: rigid + number - first,
                goal,
            });
            target.ok_or((format!("`f{number}`"), names))
        });
        let found = found.map_err(|(got, expected)| value_error("--target", text, &got, &expected));
        targets.extend(faults.take(found));
    }
    faults.into_result().map(|()| targets)
}

/// Got and expected.
type Fault = (String, String);

/// A change as it is stated.
enum Change<'a> {
    Added(AddedKind, &'a str, f64),
    Value {
        name: &'a str,
        amount: f64,
        is_factor: bool,
    },
}

fn read_change(text: &str) -> Result<Change<'_>, Fault> {
    let unknown = || (format!("`{text}`"), CHANGES.to_owned());
    let (left, amount) = text.rsplit_once('=').ok_or_else(unknown)?;
    let amount: f64 = number(amount)?;
    let kinds = [
        ("mass", AddedKind::Mass),
        ("spring", AddedKind::Spring),
        ("damper", AddedKind::Damper),
    ];
    let Some((word, ends)) = left.split_once(':') else {
        let (name, is_factor) = match left.strip_suffix('*') {
            Some(name) => (name.trim(), true),
            None => (left.trim(), false),
        };
        return match name.is_empty() {
            true => Err(unknown()),
            false => Ok(Change::Value {
                name,
                amount,
                is_factor,
            }),
        };
    };
    let kind = kinds.iter().find(|(name, _)| *name == word.trim());
    let (_, kind) = kind.ok_or_else(unknown)?;
    match amount == 0.0 || *kind == AddedKind::Damper && amount < 0.0 {
        true => Err((
            amount.to_string(),
            format!("a {word} that is not 0, and no negative damper"),
        )),
        false => Ok(Change::Added(*kind, ends.trim(), amount)),
    }
}

fn number(text: &str) -> Result<f64, Fault> {
    let value = text.trim().parse::<f64>().ok();
    let value = value.filter(|value| value.is_finite());
    value.ok_or_else(|| (format!("`{}`", text.trim()), "a number".to_owned()))
}

/// Number in the label of a mode, and goal.
fn read_target(text: &str) -> Result<(usize, Goal), Fault> {
    let unknown = || (format!("`{text}`"), TARGETS.to_owned());
    let words = ["outside", ">", "<", "="];
    let split = words
        .iter()
        .find_map(|word| Some((*word, text.split_once(word)?)));
    let (word, (label, goal)) = split.ok_or_else(unknown)?;
    let label = label
        .trim()
        .strip_prefix('f')
        .and_then(|number| number.parse().ok());
    let label: usize = label.ok_or_else(unknown)?;
    if word == "outside" {
        let (lower, upper) = goal.split_once(':').ok_or_else(unknown)?;
        let band = Band::new(number(lower)?, number(upper)?);
        let band = band.map_err(|error| (goal.trim().to_owned(), error.to_string()))?;
        return Ok((label, Goal::Outside(band)));
    }
    let hz = number(goal.strip_prefix('=').unwrap_or(goal))?;
    if hz <= 0.0 {
        return Err((hz.to_string(), "a frequency above 0 Hz".to_owned()));
    }
    let goal = match word {
        ">" => Goal::Above(hz),
        "<" => Goal::Below(hz),
        _ => Goal::Equal(hz),
    };
    Ok((label, goal))
}

/// The motions of a model that a part can be added to.
struct Motions<'a> {
    model: &'a LoadedModel,
    sensors: Vec<Sensor>,
    coordinates: Vec<Coordinate>,
}

impl<'a> Motions<'a> {
    fn of(model: &'a LoadedModel) -> Result<Self, SceneError> {
        let coordinates = match model.model.sparse(&model.values)? {
            Some(system) => system.coordinates,
            None => model.model.assemble(&model.values)?.coordinates,
        };
        let mut sensors = model.sensors.clone();
        for sensor in coordinate_sensors(&coordinates) {
            if !sensors.iter().any(|known| known.dof == sensor.dof) {
                sensors.push(sensor);
            }
        }
        Ok(Self {
            model,
            sensors,
            coordinates,
        })
    }

    /// The rows of a part: of a mass at a point one for each direction.
    fn rows(&self, kind: AddedKind, ends: &str) -> Result<Vec<Vec<f64>>, Fault> {
        let ends: Vec<&str> = ends.split(',').map(str::trim).collect();
        match ends[..] {
            [point] if kind == AddedKind::Mass && self.has_point(point) => self.point_rows(point),
            [end] => Ok(vec![self.row(end)?]),
            [a, b] if kind != AddedKind::Mass => {
                let (first, second) = (self.row(a)?, self.row(b)?);
                let row: Vec<f64> = first.iter().zip(second).map(|(a, b)| a - b).collect();
                match row.iter().all(|entry| *entry == 0.0) {
                    true => Err((
                        format!("`{a}` and `{b}`"),
                        "two that move differently".to_owned(),
                    )),
                    false => Ok(vec![row]),
                }
            }
            _ => Err((ends.join(","), CHANGES.to_owned())),
        }
    }

    fn has_point(&self, point: &str) -> bool {
        self.sensors
            .iter()
            .any(|sensor| sensor.dof.point() == point)
    }

    /// The translations of a point.
    fn point_rows(&self, point: &str) -> Result<Vec<Vec<f64>>, Fault> {
        let at_point = self
            .sensors
            .iter()
            .filter(|sensor| sensor.dof.point() == point);
        let mut targets: Vec<Target> = Vec::new();
        for sensor in at_point {
            match &sensor.target {
                Target::BodyPoint { body, at_m, .. } => {
                    let along = |axis: Axis| Target::BodyPoint {
                        body: body.clone(),
                        at_m: *at_m,
                        direction: axis.unit_vector().unwrap_or_default(),
                    };
                    targets = [Axis::X, Axis::Y, Axis::Z].map(along).to_vec();
                    break;
                }
                target if !sensor.dof.axis().is_rotation() => targets.push(target.clone()),
                _ => {}
            }
        }
        let rows: Result<Vec<Vec<f64>>, Fault> =
            targets.iter().map(|t| self.of_target(t)).collect();
        let mut rows = rows?;
        rows.retain(|row| row.iter().any(|entry| *entry != 0.0));
        match rows.is_empty() {
            true => Err((
                format!("point `{point}`"),
                "a point that the model moves".to_owned(),
            )),
            false => Ok(rows),
        }
    }

    /// The row of a degree of freedom with its sign, or of a coordinate.
    fn row(&self, name: &str) -> Result<Vec<f64>, Fault> {
        let row = match name.parse::<Dof>() {
            Ok(dof) => {
                let sign = if dof.is_negative() { -1.0 } else { 1.0 };
                let row = self.of_target(&self.target(&dof)?)?;
                row.iter().map(|entry| sign * entry).collect()
            }
            Err(_) => {
                let known = self.coordinates.iter().any(|c| c.name == name);
                known.then_some(()).ok_or_else(|| self.unknown(name))?;
                self.of_target(&Target::Coordinate(name.to_owned()))?
            }
        };
        match row.iter().all(|entry: &f64| *entry == 0.0) {
            true => Err((
                format!("`{name}`"),
                "a direction in which the model moves".to_owned(),
            )),
            false => Ok(row),
        }
    }

    /// The target of a sensor, or of another direction at its point.
    fn target(&self, dof: &Dof) -> Result<Target, Fault> {
        let positive = dof.positive();
        let same = self.sensors.iter().find(|sensor| sensor.dof == positive);
        if let Some(sensor) = same {
            return Ok(sensor.target.clone());
        }
        let at_point = self
            .sensors
            .iter()
            .filter(|sensor| sensor.dof.point() == dof.point());
        let mut turned = at_point.filter_map(|sensor| match &sensor.target {
            Target::BodyPoint { body, at_m, .. } if !dof.axis().is_rotation() => {
                Some(Target::BodyPoint {
                    body: body.clone(),
                    at_m: *at_m,
                    direction: dof.axis().unit_vector()?,
                })
            }
            _ => None,
        });
        turned.next().ok_or_else(|| self.unknown(&dof.to_string()))
    }

    fn of_target(&self, target: &Target) -> Result<Vec<f64>, Fault> {
        let row = self.model.model.observation_row(&self.model.values, target);
        row.map_err(|error| (error.to_string(), "a motion of the model".to_owned()))
    }

    fn unknown(&self, name: &str) -> Fault {
        let dofs: Vec<String> = self.sensors.iter().map(|s| s.dof.to_string()).collect();
        let all = dofs.iter().map(String::as_str);
        let all = all.chain(self.coordinates.iter().map(|c| c.name.as_str()));
        let expected = format!("a point or degree of freedom of the model: {}", listed(all));
        (format!("`{name}`"), expected)
    }
}

/// The first names, and the number of the others.
fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let mut all: Vec<&str> = Vec::new();
    names.for_each(|name| {
        if !all.contains(&name) {
            all.push(name);
        }
    });
    let more = all.len().saturating_sub(MAX_LISTED);
    let shown = all[..all.len() - more].join(", ");
    match more {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}
