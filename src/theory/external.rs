//! A model of given matrices: sums of a fixed part and of named groups that parameters scale.
//!
//! `M = M_0 + sum theta_j M_j`, `K = K_0 + sum theta_j K_j`, `C = C_0 + sum theta_j C_j + alpha M +
//! beta K`, so that the derivative by a parameter is its group. Where the matrices come from is
//! not known here; they are in SI units.

use std::collections::BTreeMap;

use crate::dof::Dof;
use crate::geometry::{Sensor, Target};
use crate::linalg::SparseMatrix;

use super::description::distinct;
use super::eigen::check_damping_ratio;
use super::nearest_name::nearest_name;
use super::parameter::{check_values, index_of, nominal_values};
use super::sparse::{SparseDerivative, SparseSystem, check_symmetric};
use super::{
    Assumption, Coordinate, Motion, ParameterSpec, StiffnessPart, Support, SystemDerivative,
    SystemMatrices, TheoreticalModel, TheoryError,
};

/// Up to so many coordinates all modes are computed with full matrices: less than a second.
const DENSE_COORDINATES: usize = 1000;
/// Matrices with more than this part of their entries are not sparse.
const SPARSE_FILL: f64 = 0.1;
/// Full matrices of more coordinates are not made: 200 MB each.
const MAX_DENSE_COORDINATES: usize = 5000;
/// Name of the part of a stiffness matrix that no group scales.
const REST: &str = "rest";

/// The matrices of one group, or of the fixed part; what is not there is zero.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MatrixSet {
    /// Mass.
    pub mass: Option<SparseMatrix>,
    /// Viscous damping.
    pub damping: Option<SparseMatrix>,
    /// Stiffness.
    pub stiffness: Option<SparseMatrix>,
}

/// Damping that is stated beside the matrices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StatedDamping {
    /// `alpha` of `C = alpha M + beta K`, 1/s.
    pub mass_per_s: f64,
    /// `beta`, s.
    pub stiffness_s: f64,
    /// Damping ratios of the elastic modes from the lowest; it stands for what the matrices say of
    /// a mode.
    pub ratios: Vec<f64>,
}

/// Everything that makes a model of given matrices.
#[derive(Clone, Debug, Default)]
pub struct ExternalMatrices {
    /// Title of the model.
    pub title: String,
    /// Degree of freedom of every row and column; one against its axis is turned round.
    pub dofs: Vec<Dof>,
    /// The part that no parameter scales.
    pub fixed: MatrixSet,
    /// The parameters.
    pub parameters: Vec<ParameterSpec>,
    /// Groups with the name of the parameter that scales each.
    pub groups: Vec<(String, MatrixSet)>,
    /// Damping beside the matrices.
    pub damping: StatedDamping,
    /// How the structure is held; shown by the matrices where not stated.
    pub support: Option<Support>,
}

/// A model made from [`ExternalMatrices`].
#[derive(Clone, Debug)]
pub struct ExternalModel {
    matrices: ExternalMatrices,
    /// The parameter of each group.
    scaled_by: Vec<usize>,
    coordinates: Vec<Coordinate>,
    places: BTreeMap<String, usize>,
    sparse: bool,
}

/// Which matrix of a set.
type Part = fn(&MatrixSet) -> Option<&SparseMatrix>;
const MASS: Part = |set| set.mass.as_ref();
const DAMPING: Part = |set| set.damping.as_ref();
const STIFFNESS: Part = |set| set.stiffness.as_ref();

impl ExternalModel {
    /// The model of these matrices.
    ///
    /// # Errors
    /// [`TheoryError::NoCoordinates`], [`TheoryError::Duplicate`],
    /// [`TheoryError::UnknownParameter`], [`TheoryError::OutOfBounds`],
    /// [`TheoryError::MatrixSize`], [`TheoryError::MatrixEntry`], [`TheoryError::DampingRatio`],
    /// [`TheoryError::PropertyOutOfRange`].
    pub fn new(mut matrices: ExternalMatrices) -> Result<Self, TheoryError> {
        if matrices.dofs.is_empty() {
            return Err(TheoryError::NoCoordinates {
                model: matrices.title,
            });
        }
        let names: Vec<String> = matrices
            .dofs
            .iter()
            .map(|dof| dof.positive().to_string())
            .collect();
        distinct("degree of freedom", names.iter())?;
        distinct("parameter", matrices.parameters.iter().map(|p| &p.name))?;
        check_damping(&matrices.damping)?;
        let signs: Vec<f64> = matrices.dofs.iter().map(Dof::sign).collect();
        let groups = matrices.groups.iter_mut().map(|(_, set)| set);
        for set in groups.chain([&mut matrices.fixed]) {
            check_set(set, &signs)?;
        }
        let group_of = |(name, _): &(String, MatrixSet)| {
            index_of("group of matrices", &matrices.parameters, name)
        };
        let model = Self {
            scaled_by: matrices
                .groups
                .iter()
                .map(group_of)
                .collect::<Result<_, _>>()?,
            coordinates: matrices.dofs.iter().map(coordinate).collect(),
            places: names.into_iter().zip(0..).collect(),
            sparse: false,
            matrices,
        };
        let size = model.coordinates.len();
        let nominal = nominal_values(model.parameters());
        check_values(model.name(), model.parameters(), &nominal)?;
        let system = model.sum(&nominal, None)?;
        let entries = system
            .stiffness
            .entry_count()
            .max(system.mass.entry_count());
        let fill = entries as f64 / (size * size).max(1) as f64;
        Ok(Self {
            sparse: size > DENSE_COORDINATES && fill <= SPARSE_FILL,
            ..model
        })
    }

    /// A sensor on every coordinate, under the name of the coordinate.
    pub fn sensors(&self) -> Vec<Sensor> {
        let sensor = |dof: &Dof| Sensor {
            dof: dof.positive(),
            target: Target::Coordinate(dof.positive().to_string()),
        };
        self.matrices.dofs.iter().map(sensor).collect()
    }

    /// The matrices, or their derivatives by a parameter.
    fn sum(&self, values: &[f64], by: Option<usize>) -> Result<SparseSystem, TheoryError> {
        check_values(self.name(), self.parameters(), values)?;
        let mass = self.part(MASS, values, by)?;
        let stiffness = self.part(STIFFNESS, values, by)?;
        let StatedDamping {
            mass_per_s,
            stiffness_s,
            ..
        } = self.matrices.damping;
        let groups = self.matrices.groups.iter().map(|(_, set)| set);
        let mut sets = groups.chain([&self.matrices.fixed]);
        let damped = mass_per_s > 0.0 || stiffness_s > 0.0;
        let damping = if damped || sets.any(|set| set.damping.is_some()) {
            let stated_damping = self.part(DAMPING, values, by)?;
            let terms = [
                (1.0, &stated_damping),
                (mass_per_s, &mass),
                (stiffness_s, &stiffness),
            ];
            Some(SparseMatrix::weighted_sum(mass.size(), &terms)?)
        } else {
            None
        };
        Ok(SparseSystem {
            mass,
            damping,
            stiffness,
            coordinates: self.coordinates.clone(),
        })
    }

    fn part(
        &self,
        part: Part,
        values: &[f64],
        by: Option<usize>,
    ) -> Result<SparseMatrix, TheoryError> {
        let factor = |j: usize| match by {
            None => values[j],
            Some(by) => f64::from(u8::from(by == j)),
        };
        let fixed = if by.is_none() { 1.0 } else { 0.0 };
        let groups = self.scaled_by.iter().zip(&self.matrices.groups);
        let scaled = groups.filter_map(|(&j, (_, set))| Some((factor(j), part(set)?)));
        let base = part(&self.matrices.fixed).map(|matrix| (fixed, matrix));
        let terms = base.into_iter().chain(scaled);
        let terms: Vec<_> = terms.filter(|(factor, _)| factor.abs() > 0.0).collect();
        Ok(SparseMatrix::weighted_sum(self.coordinates.len(), &terms)?)
    }
}

impl TheoreticalModel for ExternalModel {
    fn name(&self) -> &str {
        &self.matrices.title
    }

    fn parameters(&self) -> &[ParameterSpec] {
        &self.matrices.parameters
    }

    fn assemble(&self, values: &[f64]) -> Result<SystemMatrices, TheoryError> {
        check_dense(self.coordinates.len())?;
        let sum = self.sum(values, None)?;
        Ok(SystemMatrices {
            mass: sum.mass.to_dense(),
            damping: sum.damping.map(|c| c.to_dense()),
            stiffness: sum.stiffness.to_dense(),
            coordinates: sum.coordinates,
            springs: Vec::new(),
        })
    }

    fn derivative(&self, values: &[f64], j: usize) -> Result<SystemDerivative, TheoryError> {
        check_dense(self.coordinates.len())?;
        let sum = self.sum(values, Some(j))?;
        Ok(SystemDerivative {
            mass: sum.mass.to_dense(),
            damping: sum.damping.map(|c| c.to_dense()),
            stiffness: sum.stiffness.to_dense(),
        })
    }

    fn sparse(&self, values: &[f64]) -> Result<Option<SparseSystem>, TheoryError> {
        self.sparse.then(|| self.sum(values, None)).transpose()
    }

    fn sparse_derivative(
        &self,
        values: &[f64],
        j: usize,
    ) -> Result<Option<SparseDerivative>, TheoryError> {
        if !self.sparse {
            return Ok(None);
        }
        let sum = self.sum(values, Some(j))?;
        Ok(Some(SparseDerivative {
            mass: sum.mass,
            stiffness: sum.stiffness,
        }))
    }

    /// The groups by their parameters, and what no group holds as `rest`.
    fn stiffness_parts(&self, values: &[f64]) -> Result<Vec<StiffnessPart<'_>>, TheoryError> {
        check_values(self.name(), self.parameters(), values)?;
        let groups = self.scaled_by.iter().zip(&self.matrices.groups);
        let mut parts: Vec<StiffnessPart<'_>> = groups
            .filter_map(|(&j, (name, set))| {
                Some(StiffnessPart {
                    name,
                    factor: values[j],
                    matrix: STIFFNESS(set)?,
                })
            })
            .collect();
        let rest = STIFFNESS(&self.matrices.fixed).filter(|_| !parts.is_empty());
        parts.extend(rest.map(|matrix| StiffnessPart {
            name: REST,
            factor: 1.0,
            matrix,
        }));
        Ok(parts)
    }

    /// A coordinate alone can be read: matrices do not say where a point is.
    fn observation_row(&self, _values: &[f64], target: &Target) -> Result<Vec<f64>, TheoryError> {
        let name = match target {
            Target::Coordinate(name) => name,
            Target::BodyPoint { body, .. } => {
                return Err(TheoryError::NoPositions { body: body.clone() });
            }
        };
        let index = self
            .places
            .get(name)
            .ok_or_else(|| TheoryError::UnknownCoordinate {
                got: name.clone(),
                nearest: nearest_name(name, self.places.keys().map(String::as_str)),
                count: self.places.len(),
            })?;
        let mut row = vec![0.0; self.coordinates.len()];
        row[*index] = 1.0;
        Ok(row)
    }

    fn stated_damping(&self, elastic: usize) -> Option<f64> {
        self.matrices.damping.ratios.get(elastic).copied()
    }

    fn support(&self) -> Option<Support> {
        self.matrices.support
    }

    fn assumptions(&self) -> Vec<Assumption> {
        let solved = if self.sparse {
            "more than 1000 coordinates and at most 10 % of the entries: the lowest modes alone are computed, from sparse matrices, and counted"
        } else {
            "1000 coordinates or fewer, or more than 10 % of the entries: all modes are computed, from full matrices"
        };
        Assumption::all(
            "matrices",
            ["the matrices are in SI units, and symmetric", solved],
        )
    }
}

fn coordinate(dof: &Dof) -> Coordinate {
    let axis = dof.axis();
    Coordinate {
        name: dof.positive().to_string(),
        body: dof.point().to_owned(),
        motion: match axis.unit_vector() {
            None => Motion::Arc,
            Some(_) if axis.is_rotation() => Motion::Rotation,
            Some(_) => Motion::Translation,
        },
        axis: axis.unit_vector().unwrap_or_default(),
        at_m: [0.0; 3],
    }
}

fn check_dense(size: usize) -> Result<(), TheoryError> {
    if size <= MAX_DENSE_COORDINATES {
        return Ok(());
    }
    Err(TheoryError::TooLarge {
        got: size,
        most: MAX_DENSE_COORDINATES,
    })
}

fn check_damping(damping: &StatedDamping) -> Result<(), TheoryError> {
    damping
        .ratios
        .iter()
        .try_for_each(|ratio| check_damping_ratio(*ratio))?;
    let factors = [
        ("mass_per_s", damping.mass_per_s),
        ("stiffness_s", damping.stiffness_s),
    ];
    for (property, got) in factors {
        if !(got.is_finite() && got >= 0.0) {
            return Err(TheoryError::PropertyOutOfRange {
                part: "damping".to_owned(),
                property,
                got,
                expected: "a finite number of 0 or more",
            });
        }
    }
    Ok(())
}

/// Checks the matrices of a set and turns rows and columns of negative degrees of freedom round.
fn check_set(set: &mut MatrixSet, signs: &[f64]) -> Result<(), TheoryError> {
    let parts = [
        ("mass", &mut set.mass),
        ("damping", &mut set.damping),
        ("stiffness", &mut set.stiffness),
    ];
    for (name, part) in parts {
        let Some(matrix) = part else { continue };
        check_symmetric(name, matrix, signs.len())?;
        if signs.iter().any(|sign| *sign < 0.0) {
            let turned = matrix
                .entries()
                .map(|(i, j, v)| (i, j, signs[i] * signs[j] * v));
            *matrix = SparseMatrix::from_entries(signs.len(), &turned.collect::<Vec<_>>())?;
        }
    }
    Ok(())
}
