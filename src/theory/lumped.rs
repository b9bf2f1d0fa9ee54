//! The lumped model of a `model.toml`: rigid bodies, points, springs.

use crate::geometry::Target;

use super::description::{SCHEMA, Value, distinct};
use super::dual::Values;
use super::faults::Faults;
use super::lumped_description::{
    BodyDescription, Free, Inertia, LinkDescription, LumpedFile, PointDescription,
};
use super::nearest_name::nearest_name;
use super::parameter::{check_values, nominal_values};
use super::property::{Property, Sign};
use super::rigid::{Attachment, RigidBodies};
use super::{
    Assumption, Coordinate, Motion, ParameterSpec, Spring, Support, SystemDerivative,
    SystemMatrices, TheoreticalModel, TheoryError,
};

/// The name of what does not move.
const GROUND: &str = "ground";

/// From this number of coordinates a model is refused. Larger: a matrix takes more than 128 MB, and
/// an eigenproblem more than minutes. Smaller: 600 free bodies are refused.
const MAX_COORDINATES: usize = 4000;

/// A model of rigid bodies and springs, made from a [`LumpedFile`].
///
/// `M = diag(m, J)`, `K = sum k b b^T` with `b` the stretch (or twist) of a spring per unit of each
/// coordinate.
#[derive(Clone, Debug)]
pub struct LumpedModel {
    file: LumpedFile,
    bodies: RigidBodies,
    stiffnesses: Vec<Stiffness>,
}

/// The row of a spring and the number that its stiffness is.
#[derive(Clone, Debug)]
struct Stiffness {
    row: Vec<f64>,
    name: &'static str,
    value: Value,
}

impl LumpedModel {
    /// The model of a file. All its numbers are checked here with the nominal values.
    ///
    /// # Errors
    /// [`TheoryError::Schema`], [`TheoryError::Duplicate`], [`TheoryError::UnknownParameter`],
    /// [`TheoryError::OutOfBounds`], [`TheoryError::PropertyOutOfRange`],
    /// [`TheoryError::MissingProperty`], [`TheoryError::ZeroDirection`],
    /// [`TheoryError::UnknownBody`], [`TheoryError::UnknownPoint`], [`TheoryError::NoStiffness`].
    pub fn new(file: LumpedFile) -> Result<Self, TheoryError> {
        let mut faults = Faults::default();
        faults.take(check_file(&file));
        let bodies = RigidBodies {
            names: file.bodies.iter().map(|body| body.name.clone()).collect(),
            coordinates: file.bodies.iter().flat_map(coordinates).collect(),
        };
        // Rows of more coordinates would exceed the memory.
        if bodies.coordinates.len() >= MAX_COORDINATES {
            return faults
                .into_result()
                .and(Err(TheoryError::Several { faults: Vec::new() }));
        }
        for point in &file.points {
            let used_by = format!("point `{}`", point.name);
            faults.take(bodies.check_body(&used_by, &point.body));
        }
        let mut stiffnesses = Vec::new();
        // Where nothing may move, no spring is stretched, which the file says once.
        let springs = match bodies.coordinates.is_empty() {
            true => &[][..],
            false => &file.springs,
        };
        for spring in springs {
            let found = match stiffness(spring, &file.points, &bodies) {
                // The point of the spring says it.
                Err(TheoryError::UnknownBody { .. }) => None,
                result => faults.take(result),
            };
            stiffnesses.extend(found);
        }
        check_properties(&file, &mut faults);
        faults.into_result()?;
        let model = Self {
            stiffnesses,
            bodies,
            file,
        };
        model.assemble(&nominal_values(model.parameters()))?;
        Ok(model)
    }

    /// Mass or moment of inertia of every coordinate.
    fn inertia(&self, values: &Values<'_>) -> Result<Vec<f64>, TheoryError> {
        let mut inertia = Vec::with_capacity(self.bodies.coordinates.len());
        for body in &self.file.bodies {
            let part = &body.label();
            for &free in &body.free {
                let (name, value) = inertia_of(body, free);
                let value = value.ok_or_else(|| TheoryError::MissingProperty {
                    part: part.clone(),
                    property: name,
                    needed_for: free.name(),
                })?;
                let sign = Sign::NotNegative;
                let property = Property {
                    part,
                    name,
                    value,
                    sign,
                };
                inertia.push(values.part(property.dual(values)?));
            }
        }
        Ok(inertia)
    }

    /// M and K, or their derivatives by a parameter: both are sums, since no parameter moves a
    /// point.
    fn sum(&self, values: &[f64], by: Option<usize>) -> Result<SystemMatrices, TheoryError> {
        check_values(self.name(), self.parameters(), values)?;
        let specs = &self.file.parameters;
        let values = &Values { specs, values, by };
        let (inertia, springs) = (self.inertia(values)?, self.springs(values)?);
        Ok(self.bodies.matrices(&inertia, springs))
    }

    fn springs(&self, values: &Values<'_>) -> Result<Vec<Spring>, TheoryError> {
        let spring = |(stiffness, link): (&Stiffness, &LinkDescription)| {
            let property = Property {
                part: &link.label(),
                name: stiffness.name,
                value: &stiffness.value,
                sign: Sign::NotNegative,
            };
            Ok(Spring {
                name: link.name.clone(),
                row: stiffness.row.clone(),
                stiffness: values.part(property.dual(values)?),
            })
        };
        let pairs = self.stiffnesses.iter().zip(&self.file.springs);
        pairs.map(spring).collect()
    }
}

impl TheoreticalModel for LumpedModel {
    fn name(&self) -> &str {
        &self.file.title
    }

    fn parameters(&self) -> &[ParameterSpec] {
        &self.file.parameters
    }

    fn assemble(&self, values: &[f64]) -> Result<SystemMatrices, TheoryError> {
        self.sum(values, None)
    }

    fn derivative(&self, values: &[f64], j: usize) -> Result<SystemDerivative, TheoryError> {
        let sum = self.sum(values, Some(j))?;
        Ok(SystemDerivative {
            mass: sum.mass,
            damping: None,
            stiffness: sum.stiffness,
        })
    }

    fn support(&self) -> Option<Support> {
        self.file.support
    }

    /// A point need not lie on the body: it moves as if it were fixed to it.
    fn observation_row(&self, _values: &[f64], target: &Target) -> Result<Vec<f64>, TheoryError> {
        self.bodies.observation_row(target)
    }

    fn assumptions(&self) -> Vec<Assumption> {
        let statements = [
            "bodies are rigid, springs have no mass, and motions are small about the position drawn",
            "the axes of the model are the principal axes of inertia of every body",
            "a spring acts along its stated direction: where that is not the line between its ends, it holds the pair against turning as a guide would",
            "nothing damps; damping is given by mode",
        ];
        Assumption::all("lumped model", statements)
    }
}

/// Collects the faults of the numbers of bodies and springs at the nominal values.
fn check_properties(file: &LumpedFile, faults: &mut Faults<TheoryError>) {
    let nominal = nominal_values(&file.parameters);
    let mut check = |part: &str, name, value: Option<&Value>| {
        let property = value.map(|value| Property {
            part,
            name,
            value,
            sign: Sign::NotNegative,
        });
        property.map(|property| faults.take(property.resolve(&file.parameters, &nominal)));
    };
    for body in &file.bodies {
        let moving = body.free.iter().map(|&free| inertia_of(body, free));
        for (name, value) in moving {
            check(&body.label(), name, value);
        }
    }
    for spring in &file.springs {
        let named = spring.parameter.clone().map(Value::Parameter);
        let stated = [
            ("stiffness_n_per_m", spring.stiffness_n_per_m.as_ref()),
            ("stiffness_nm_per_rad", spring.stiffness_nm_per_rad.as_ref()),
            ("stiffness_n_per_m", named.as_ref()),
        ];
        let mut stated = stated.into_iter().filter(|(_, value)| value.is_some());
        // Of several it is unknown which is meant.
        if let (Some((name, value)), None) = (stated.next(), stated.next()) {
            check(&spring.label(), name, value);
        }
    }
    for body in &file.bodies {
        for &free in &body.free {
            if let (property, None) = inertia_of(body, free) {
                faults.add(TheoryError::MissingProperty {
                    part: body.label(),
                    property,
                    needed_for: free.name(),
                });
            }
        }
    }
}

fn coordinates(body: &BodyDescription) -> impl Iterator<Item = Coordinate> + '_ {
    body.free.iter().map(|free| Coordinate {
        name: format!("{}.{}", body.name, free.name()),
        body: body.name.clone(),
        motion: if free.axis().is_rotation() {
            Motion::Rotation
        } else {
            Motion::Translation
        },
        axis: free.axis().unit_vector().unwrap_or_default(),
        at_m: body.at_m,
    })
}

/// The property that resists one way of moving.
fn inertia_of(body: &BodyDescription, free: Free) -> (&'static str, Option<&Value>) {
    let about = match free {
        Free::X | Free::Y | Free::Z => return ("mass_kg", body.mass_kg.as_ref()),
        Free::Rx => 0,
        Free::Ry => 1,
        Free::Rz => 2,
    };
    let value = match &body.inertia_kg_m2 {
        Some(Inertia::One(value)) => Some(value),
        Some(Inertia::Three(values)) => Some(&values[about]),
        None => None,
    };
    ("inertia_kg_m2", value)
}

fn stiffness(
    link: &LinkDescription,
    points: &[PointDescription],
    bodies: &RigidBodies,
) -> Result<Stiffness, TheoryError> {
    let label = link.label();
    let mut faults = Faults::default();
    let from = faults.take(attachment(&link.from, &label, points));
    let to = faults.take(attachment(&link.to, &label, points));
    faults.into_result()?;
    let (Some(from), Some(to)) = (from, to) else {
        return Err(TheoryError::NothingMoves { part: label });
    };
    let line: [f64; 3] = std::array::from_fn(|i| to.at_m[i] - from.at_m[i]);
    if link.direction.is_none() && (from.body.is_none() || to.body.is_none()) {
        return Err(TheoryError::NoDirection { part: label });
    }
    let direction = link.direction.unwrap_or(line);
    let named = link.parameter.clone().map(Value::Parameter);
    let (name, value, twist) = match (&link.stiffness_n_per_m, &link.stiffness_nm_per_rad, named) {
        (Some(value), None, None) => ("stiffness_n_per_m", value.clone(), false),
        (None, Some(value), None) => ("stiffness_nm_per_rad", value.clone(), true),
        (None, None, Some(value)) => ("stiffness_n_per_m", value, false),
        _ => {
            return Err(TheoryError::NoStiffness {
                part: label,
                expected: "one of stiffness_n_per_m, stiffness_nm_per_rad and parameter",
            });
        }
    };
    let ends = (from, to);
    let row = if twist {
        bodies.twist_row(&label, ends, direction)?
    } else {
        bodies.stretch_row(&label, ends, direction)?
    };
    if row.iter().all(|part| part.abs() <= 0.0) {
        return Err(TheoryError::NothingMoves { part: label });
    }
    Ok(Stiffness { row, name, value })
}

fn attachment<'a>(
    name: &str,
    used_by: &str,
    points: &'a [PointDescription],
) -> Result<Attachment<'a>, TheoryError> {
    if name == GROUND {
        return Ok(Attachment {
            body: None,
            at_m: [0.0; 3],
        });
    }
    let point = points.iter().find(|point| point.name == name);
    let point = point.ok_or_else(|| TheoryError::UnknownPoint {
        got: name.to_owned(),
        used_by: used_by.to_owned(),
        nearest: nearest_name(name, points.iter().map(|point| point.name.as_str())),
    })?;
    Ok(Attachment {
        body: Some(&point.body),
        at_m: point.at_m,
    })
}

/// Everything that can be checked before geometry is made of it.
fn check_file(file: &LumpedFile) -> Result<(), TheoryError> {
    let mut faults = Faults::default();
    if let Some(got) = file.schema.as_ref().filter(|schema| *schema != SCHEMA) {
        faults.add(TheoryError::Schema {
            got: got.clone(),
            expected: SCHEMA,
        });
    }
    faults.take(distinct(
        "parameter",
        file.parameters.iter().map(|p| &p.name),
    ));
    faults.take(distinct("body", file.bodies.iter().map(|b| &b.name)));
    faults.take(distinct("point", file.points.iter().map(|p| &p.name)));
    if file.points.iter().any(|point| point.name == GROUND) {
        faults.add(TheoryError::Duplicate {
            what: "point",
            name: GROUND.to_owned(),
        });
    }
    faults.take(distinct("spring", file.springs.iter().map(|s| &s.name)));
    for body in &file.bodies {
        let free = body.free.iter();
        let names: Vec<String> = free
            .map(|free| format!("{}.{}", body.name, free.name()))
            .collect();
        faults.take(distinct("coordinate", names.iter()));
    }
    let coordinates: usize = file.bodies.iter().map(|body| body.free.len()).sum();
    let expected = match coordinates {
        0 => Some("at least one body that may move"),
        MAX_COORDINATES.. => {
            Some("fewer than 4000, as its matrices are dense: a larger model has [matrices]")
        }
        _ => None,
    };
    if let Some(expected) = expected {
        faults.add(TheoryError::PropertyOutOfRange {
            part: file.title.clone(),
            property: "number of coordinates",
            got: coordinates as f64,
            expected,
        });
    }
    faults.take(check_values(
        &file.title,
        &file.parameters,
        &nominal_values(&file.parameters),
    ));
    faults.into_result()
}
