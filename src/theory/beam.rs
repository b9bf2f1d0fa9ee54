//! Euler-Bernoulli beams with point masses and springs to ground, by cubic Hermite elements with
//! consistent mass.
//!
//! Several beams may stand in one model; they do not touch one another. A mass, a spring, a sensor
//! or a hit may be anywhere on a beam: the interpolation of the element carries it, so that nothing
//! is snapped to a node.
//!
//! # Reference
//! Przemieniecki (1968), Theory of Matrix Structural Analysis, chapters 5 and 11.

use crate::geometry::Target;
use crate::linalg::{RealMatrix, real_matrix};

use super::beam_line::{
    BeamLine, BeamPlacement, BeamPoint, check_element_count, find_line, find_point,
};
use super::description::{BeamDescription, BeamFile, SCHEMA, Value, distinct};
use super::dual::Values;
use super::faults::Faults;
use super::parameter::{check_values, nominal_values};
use super::property::{Property, Sign};
use super::rigid::coordinate_index;
use super::{
    Assumption, Coordinate, ParameterSpec, ParameterStatus, Support, SystemDerivative,
    SystemMatrices, TheoreticalModel, TheoryError, hermite,
};

/// A model of beams, made from a [`BeamFile`].
#[derive(Clone, Debug)]
pub struct BeamModel {
    file: BeamFile,
    lines: Vec<BeamLine>,
    masses: Vec<BeamPoint>,
    springs: Vec<BeamPoint>,
    coordinates: Vec<Coordinate>,
}

impl BeamModel {
    /// The model of a file. All its numbers are checked here with the nominal values.
    ///
    /// # Errors
    /// [`TheoryError::Schema`], [`TheoryError::Duplicate`], [`TheoryError::UnknownParameter`],
    /// [`TheoryError::OutOfBounds`], [`TheoryError::PropertyOutOfRange`],
    /// [`TheoryError::ZeroDirection`], [`TheoryError::DeflectionNotAcross`],
    /// [`TheoryError::UnknownBody`], [`TheoryError::PointOutside`], [`TheoryError::NoStiffness`].
    pub fn new(file: BeamFile) -> Result<Self, TheoryError> {
        let mut faults = Faults::default();
        faults.take(check_file(&file));
        let mut coordinates = Vec::new();
        let mut lines = Vec::new();
        let elements = file.beams.iter().map(|beam| beam.elements);
        check_element_count(&file.title, elements.fold(0, usize::saturating_add))?;
        for beam in &file.beams {
            lines.extend(faults.take(BeamLine::new(beam, &mut coordinates)));
        }
        // A beam whose geometry is wrong is known by its name all the same.
        let is_without_line = |name: &str| {
            let is_known = file.beams.iter().any(|beam| beam.name == name);
            is_known && lines.iter().all(|line| !line.is_named(name))
        };
        let mut find = |part: String, beam: &str, at_m| match is_without_line(beam) {
            true => None,
            false => faults.take(find_point(&lines, &part, beam, at_m)),
        };
        let masses = file.point_masses.iter();
        let masses: Vec<BeamPoint> = masses
            .filter_map(|m| find(m.label(), &m.beam, m.at_m))
            .collect();
        let springs = file.springs.iter();
        let springs: Vec<BeamPoint> = springs
            .filter_map(|s| find(s.label(), &s.beam, s.at_m))
            .collect();
        check_properties(&file, &mut faults);
        faults.into_result()?;
        let model = Self {
            masses,
            springs,
            file,
            lines,
            coordinates,
        };
        model.assemble(&nominal_values(model.parameters()))?;
        Ok(model)
    }

    /// M and K, or their derivatives by the parameter of `values`: both are sums of what is taken
    /// out of each number.
    fn sum(&self, values: &Values<'_>) -> Result<SystemMatrices, TheoryError> {
        let mut matrices = self.sum_without_springs(values)?;
        self.add_springs(&mut matrices, values)?;
        Ok(matrices)
    }

    /// The same without the springs to ground.
    fn sum_without_springs(&self, values: &Values<'_>) -> Result<SystemMatrices, TheoryError> {
        check_values(self.name(), self.parameters(), values.values)?;
        let n = self.coordinates.len();
        let mut matrices = SystemMatrices {
            mass: real_matrix(n, n, |_, _| 0.0),
            damping: None,
            stiffness: real_matrix(n, n, |_, _| 0.0),
            coordinates: self.coordinates.clone(),
            springs: Vec::new(),
        };
        self.add_beams(&mut matrices, values)?;
        self.add_masses(&mut matrices, values)?;
        Ok(matrices)
    }

    fn values<'a>(&'a self, values: &'a [f64], by: Option<usize>) -> Values<'a> {
        let specs = &self.file.parameters;
        Values { specs, values, by }
    }

    fn add_beams(
        &self,
        matrices: &mut SystemMatrices,
        values: &Values<'_>,
    ) -> Result<(), TheoryError> {
        for (line, beam) in self.lines.iter().zip(&self.file.beams) {
            let part = beam.label();
            let get = |name, value, sign| {
                let part = &part;
                Property {
                    part,
                    name,
                    value,
                    sign,
                }
                .dual(values)
            };
            let above_0 = Sign::Positive;
            let bending = get("youngs_modulus_pa", &beam.youngs_modulus_pa, above_0)?
                * get("second_moment_m4", &beam.second_moment_m4, above_0)?;
            let density = get(
                "density_kg_per_m3",
                &beam.density_kg_per_m3,
                Sign::NotNegative,
            )?;
            let mass_per_length = density * get("area_m2", &beam.area_m2, above_0)?;
            let h = line.length_m / line.elements as f64;
            let stiffness = hermite::stiffness(values.part(bending), h);
            let mass = hermite::mass(values.part(mass_per_length), h);
            for element in 0..line.elements {
                let columns = line.element_columns(element);
                add_element(&mut matrices.stiffness, columns, &stiffness);
                add_element(&mut matrices.mass, columns, &mass);
            }
        }
        Ok(())
    }

    fn add_masses(
        &self,
        matrices: &mut SystemMatrices,
        values: &Values<'_>,
    ) -> Result<(), TheoryError> {
        let sign = Sign::NotNegative;
        for (point, mass) in self.masses.iter().zip(&self.file.point_masses) {
            let part = &mass.label();
            let (name, value) = ("mass_kg", &mass.mass_kg);
            let kg = Property {
                part,
                name,
                value,
                sign,
            }
            .dual(values)?;
            add_outer(
                &mut matrices.mass,
                point.columns,
                point.deflection,
                values.part(kg),
            );
            if let Some(value) = &mass.rotary_inertia_kg_m2 {
                let name = "rotary_inertia_kg_m2";
                let inertia = Property {
                    part,
                    name,
                    value,
                    sign,
                }
                .dual(values)?;
                add_outer(
                    &mut matrices.mass,
                    point.columns,
                    point.rotation,
                    values.part(inertia),
                );
            }
        }
        Ok(())
    }

    fn add_springs(
        &self,
        matrices: &mut SystemMatrices,
        values: &Values<'_>,
    ) -> Result<(), TheoryError> {
        let sign = Sign::NotNegative;
        for (point, spring) in self.springs.iter().zip(&self.file.springs) {
            let part = &spring.label();
            let directions = [
                (
                    "stiffness_n_per_m",
                    &spring.stiffness_n_per_m,
                    point.deflection,
                ),
                (
                    "stiffness_nm_per_rad",
                    &spring.stiffness_nm_per_rad,
                    point.rotation,
                ),
            ];
            for (name, value, row) in directions {
                let Some(value) = value else { continue };
                let k = Property {
                    part,
                    name,
                    value,
                    sign,
                }
                .dual(values)?;
                add_outer(&mut matrices.stiffness, point.columns, row, values.part(k));
            }
        }
        Ok(())
    }
}

impl TheoreticalModel for BeamModel {
    fn name(&self) -> &str {
        &self.file.title
    }

    fn parameters(&self) -> &[ParameterSpec] {
        &self.file.parameters
    }

    fn assemble(&self, values: &[f64]) -> Result<SystemMatrices, TheoryError> {
        self.sum(&self.values(values, None))
    }

    fn derivative(&self, values: &[f64], j: usize) -> Result<SystemDerivative, TheoryError> {
        let sum = self.sum(&self.values(values, Some(j)))?;
        Ok(SystemDerivative {
            mass: sum.mass,
            damping: None,
            stiffness: sum.stiffness,
        })
    }

    fn support(&self) -> Option<Support> {
        self.file.support
    }

    fn stiffness_without_ground(&self, values: &[f64]) -> Result<Option<RealMatrix>, TheoryError> {
        let matrices = self.sum_without_springs(&self.values(values, None))?;
        Ok(Some(matrices.stiffness))
    }

    /// A point counts at the foot of its perpendicular on the beam's axis, and its direction by the
    /// cosine to the deflection: a sensor across the plane of bending reads 0.
    fn observation_row(&self, _values: &[f64], target: &Target) -> Result<Vec<f64>, TheoryError> {
        let mut row = vec![0.0; self.coordinates.len()];
        match target {
            Target::Coordinate(name) => row[coordinate_index(&self.coordinates, name)?] = 1.0,
            Target::BodyPoint {
                body,
                at_m,
                direction,
            } => {
                let line = find_line(&self.lines, "sensor", body)?;
                let cosine = line.cosine("sensor", *direction)?;
                let point = line.point("sensor", *at_m)?;
                for (column, weight) in point.columns.iter().zip(point.deflection) {
                    if let Some(column) = column {
                        row[*column] += cosine * weight;
                    }
                }
            }
        }
        Ok(row)
    }

    fn beam_placement(&self, target: &Target) -> Option<BeamPlacement> {
        let Target::BodyPoint {
            body,
            at_m,
            direction,
        } = target
        else {
            return None;
        };
        let line = find_line(&self.lines, "sensor", body).ok()?;
        line.placement(*at_m, *direction)
    }

    fn assumptions(&self) -> Vec<Assumption> {
        let statements = [
            "bending in one plane by the Euler-Bernoulli theory: no shear deformation and no rotary inertia of the section",
            "masses, springs and sensors act on the axis of the beam",
            "the material does not damp; damping is given by mode",
        ];
        let of_beam = |beam: &BeamDescription| {
            let mut all = Assumption::all(&beam.label(), statements);
            let ends = (beam.ends_status == ParameterStatus::Assumed).then(|| Assumption {
                about: beam.label(),
                statement: "ends and length",
                is_guess: true,
            });
            all.extend(ends);
            all
        };
        self.file.beams.iter().flat_map(of_beam).collect()
    }
}

/// Collects the faults of the numbers of beams, masses and springs at the nominal values.
fn check_properties(file: &BeamFile, faults: &mut Faults<TheoryError>) {
    let nominal = nominal_values(&file.parameters);
    let mut check = |part: &str, name, value: Option<&Value>, sign| {
        let property = value.map(|value| Property {
            part,
            name,
            value,
            sign,
        });
        property.map(|property| faults.take(property.resolve(&file.parameters, &nominal)));
    };
    let (above_0, from_0) = (Sign::Positive, Sign::NotNegative);
    for beam in &file.beams {
        let part = &beam.label();
        check(
            part,
            "youngs_modulus_pa",
            Some(&beam.youngs_modulus_pa),
            above_0,
        );
        check(
            part,
            "second_moment_m4",
            Some(&beam.second_moment_m4),
            above_0,
        );
        check(
            part,
            "density_kg_per_m3",
            Some(&beam.density_kg_per_m3),
            from_0,
        );
        check(part, "area_m2", Some(&beam.area_m2), above_0);
    }
    for mass in &file.point_masses {
        let part = &mass.label();
        check(part, "mass_kg", Some(&mass.mass_kg), from_0);
        let inertia = mass.rotary_inertia_kg_m2.as_ref();
        check(part, "rotary_inertia_kg_m2", inertia, from_0);
    }
    for spring in &file.springs {
        let part = &spring.label();
        let (along, about) = (&spring.stiffness_n_per_m, &spring.stiffness_nm_per_rad);
        check(part, "stiffness_n_per_m", along.as_ref(), from_0);
        check(part, "stiffness_nm_per_rad", about.as_ref(), from_0);
    }
}

/// Everything that can be checked before geometry is made of it.
fn check_file(file: &BeamFile) -> Result<(), TheoryError> {
    let mut faults = Faults::default();
    if file.schema != SCHEMA {
        faults.add(TheoryError::Schema {
            got: file.schema.clone(),
            expected: SCHEMA,
        });
    }
    faults.take(distinct(
        "parameter",
        file.parameters.iter().map(|p| &p.name),
    ));
    faults.take(distinct("beam", file.beams.iter().map(|b| &b.name)));
    faults.take(distinct(
        "point mass",
        file.point_masses.iter().map(|m| &m.name),
    ));
    faults.take(distinct("spring", file.springs.iter().map(|s| &s.name)));
    for spring in &file.springs {
        if spring.stiffness_n_per_m.is_none() && spring.stiffness_nm_per_rad.is_none() {
            faults.add(TheoryError::NoStiffness {
                part: spring.label(),
                expected: "stiffness_n_per_m, stiffness_nm_per_rad or both",
            });
        }
    }
    faults.take(check_values(
        &file.title,
        &file.parameters,
        &nominal_values(&file.parameters),
    ));
    faults.into_result()
}

fn add_element(
    matrix: &mut RealMatrix,
    columns: [Option<usize>; 4],
    element: &hermite::ElementMatrix,
) {
    for (i, row) in columns.iter().enumerate() {
        for (j, column) in columns.iter().enumerate() {
            if let (Some(row), Some(column)) = (row, column) {
                matrix[(*row, *column)] += element[i][j];
            }
        }
    }
}

/// Adds `factor * row row^T`.
fn add_outer(matrix: &mut RealMatrix, columns: [Option<usize>; 4], row: [f64; 4], factor: f64) {
    let element = std::array::from_fn(|i| std::array::from_fn(|j| factor * row[i] * row[j]));
    add_element(matrix, columns, &element);
}
