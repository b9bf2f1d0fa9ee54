//! Orthogonality of shapes through a mass matrix that has been reduced to the sensors.

use num_complex::Complex64;
use serde::Serialize;

use crate::dof::Dof;
use crate::linalg::{RealMatrix, real_matrix};
use crate::modal::{ModalModel, ModeShape};
use crate::theory::{SystemMatrices, guyan, serep_expansion};

use super::super::pairing::without_rounding;
use super::super::roots::elastic_modes;
use super::super::{CorrelateError, DofMap};
use super::ModeName;

/// How a mass matrix is brought to the sensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Reduction {
    /// Static: the other coordinates follow without inertia (Guyan 1965). Each sensor must read one coordinate.
    Guyan,
    /// Through modes of the model (SEREP, O'Callahan, Avitabile and Riemer 1989), for sensors of any direction.
    Serep,
}

impl Reduction {
    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Reduction::Guyan => "guyan",
            Reduction::Serep => "serep",
        }
    }

    /// The reduction of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        let all = [Reduction::Guyan, Reduction::Serep];
        all.into_iter().find(|own| own.name() == name)
    }
}

/// A sensor as a row of the model: reading = `row` · coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorRow {
    /// As the theory names it, with the sign that the row has.
    pub dof: Dof,
    /// One number for each coordinate.
    pub row: Vec<f64>,
}

/// A model's mass matrix at sensors, and what all its coordinates do when the sensors read given values.
#[derive(Clone, Debug)]
pub struct ReducedMass {
    /// How it was reduced.
    pub reduction: Reduction,
    /// The sensors, as the theory names them.
    pub dofs: Vec<Dof>,
    /// `T^T M T`.
    pub mass: RealMatrix,
    /// `T`: coordinates (rows) from readings (columns).
    pub expansion: RealMatrix,
    /// Modes of a SEREP reduction.
    pub modes: Option<usize>,
}

/// The mass matrix of a model at sensors: `T^T M T`, the test-analysis model.
///
/// `modes` are those that SEREP keeps, one in each column, mass-normalised or not; Guyan does not look at them.
///
/// # Errors
/// [`CorrelateError::NotACoordinate`] for Guyan where a sensor reads more than one coordinate, or two read the same;
/// [`CorrelateError::Reduction`] with the model's reason.
///
/// # Reference
/// Guyan (1965), AIAA Journal 3, 380; O'Callahan, Avitabile and Riemer (1989), IMAC 7, 29.
pub fn reduced_mass(
    matrices: &SystemMatrices,
    sensors: &[SensorRow],
    reduction: Reduction,
    modes: &RealMatrix,
) -> Result<ReducedMass, CorrelateError> {
    let reason = |source| CorrelateError::Reduction(Box::new(source));
    let expansion = match reduction {
        Reduction::Guyan => {
            let kept = read_coordinates(sensors)?;
            let at: Vec<usize> = kept.iter().map(|own| own.0).collect();
            let static_expansion = guyan(matrices, &at).map_err(reason)?.expansion;
            real_matrix(static_expansion.nrows(), kept.len(), |i, a| {
                static_expansion[(i, a)] / kept[a].1
            })
        }
        Reduction::Serep => {
            let rows: Vec<Vec<f64>> = sensors.iter().map(|own| own.row.clone()).collect();
            serep_expansion(modes, &rows).map_err(reason)?
        }
    };
    Ok(ReducedMass {
        reduction,
        dofs: sensors.iter().map(|own| own.dof.clone()).collect(),
        mass: expansion.transpose() * (&matrices.mass * &expansion),
        expansion,
        modes: (reduction == Reduction::Serep).then_some(modes.ncols()),
    })
}

/// The one coordinate of each sensor and its factor.
fn read_coordinates(sensors: &[SensorRow]) -> Result<Vec<(usize, f64)>, CorrelateError> {
    let mut kept: Vec<(usize, f64)> = Vec::new();
    for sensor in sensors {
        let mut read = sensor.row.iter().enumerate().filter(|own| *own.1 != 0.0);
        match (read.next(), read.next()) {
            (Some((at, factor)), None) if kept.iter().all(|own| own.0 != at) => {
                kept.push((at, *factor));
            }
            _ => {
                let dof = sensor.dof.clone();
                return Err(CorrelateError::NotACoordinate { dof });
            }
        }
    }
    Ok(kept)
}

/// Shapes through a mass matrix `M` at the sensors. Values are magnitudes of `φ_i^H M φ_j`, each shape scaled so that
/// `φ^H M φ = 1`, so that the matrices of one set have a diagonal of 1.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Orthogonality {
    /// How the mass matrix was reduced.
    pub reduction: Reduction,
    /// Modes of a SEREP reduction.
    pub reduction_modes: Option<usize>,
    /// Test modes above 0 Hz with a value at every sensor.
    pub test: Vec<ModeName>,
    /// Theory modes that were asked for with a value at every sensor.
    pub theory: Vec<ModeName>,
    /// Test with test; `None` for a shape without modal mass.
    pub self_test: Vec<Vec<Option<f64>>>,
    /// Theory with theory.
    pub self_theory: Vec<Vec<Option<f64>>>,
    /// Test (rows) with theory (columns).
    pub cross: Vec<Vec<Option<f64>>>,
    /// Degrees of freedom used.
    pub dofs: usize,
}

/// Degrees of freedom of a map at which every mode of both models that has a shape at all has a value: where a mass matrix
/// can be reduced to, as the theory names them.
pub fn orthogonality_dofs(test: &ModalModel, theory: &ModalModel, map: &DofMap) -> Vec<Dof> {
    fn everywhere(model: &ModalModel, dof: &Dof) -> bool {
        let shapes = model.modes.iter().map(|mode| &mode.shape);
        let mut with_shape = shapes.filter(|shape| !shape.is_empty());
        with_shape.all(|shape| shape.get(dof).is_some())
    }
    let both = map
        .pairs
        .iter()
        .filter(|pair| everywhere(test, &pair.test) && everywhere(theory, &pair.theory));
    both.map(|pair| pair.theory.clone()).collect()
}

/// Self- and cross-orthogonality of a test and a theory at the sensors of a reduced mass matrix.
///
/// The sensors of the mass must be named as the map names the theory's side. `columns` are the indices of the theory's modes
/// to look at: with SEREP those that it keeps, because the reduced mass says nothing of any other; modes at 0 Hz are left out.
///
/// # Errors
/// [`CorrelateError::NotACoordinate`] for a sensor that the map does not have.
pub fn orthogonality(
    (test, theory): (&ModalModel, &ModalModel),
    map: &DofMap,
    reduced: &ReducedMass,
    columns: &[usize],
) -> Result<Orthogonality, CorrelateError> {
    let pair = |dof: &Dof| {
        let mut pairs = map.pairs.iter();
        let found = pairs.find(|pair| pair.theory == *dof);
        found.ok_or_else(|| CorrelateError::NotACoordinate { dof: dof.clone() })
    };
    let pairs: Vec<_> = reduced.dofs.iter().map(pair).collect::<Result<_, _>>()?;
    let test_value = |shape: &ModeShape| -> Option<Vec<Complex64>> {
        let own = pairs.iter();
        own.map(|pair| shape.get(&pair.test).map(|v| v * pair.sign))
            .collect()
    };
    let theory_value =
        |shape: &ModeShape| pairs.iter().map(|pair| shape.get(&pair.theory)).collect();
    let rows = elastic_modes(test);
    let mut columns: Vec<usize> = columns.to_vec();
    columns.retain(|&j| theory.modes[j].frequency_hz > 0.0);
    columns.sort_unstable();
    let of_test = Scaled::all((test, &rows), &reduced.mass, test_value);
    let of_theory = Scaled::all((theory, &columns), &reduced.mass, theory_value);
    Ok(Orthogonality {
        reduction: reduced.reduction,
        reduction_modes: reduced.modes,
        self_test: Scaled::products(&of_test, &of_test),
        self_theory: Scaled::products(&of_theory, &of_theory),
        cross: Scaled::products(&of_test, &of_theory),
        test: of_test.iter().map(|own| own.name).collect(),
        theory: of_theory.iter().map(|own| own.name).collect(),
        dofs: pairs.len(),
    })
}

/// A shape and its product with the mass matrix.
struct Scaled {
    name: ModeName,
    shape: Vec<Complex64>,
    momentum: Vec<Complex64>,
    /// `φ^H M φ`, where that is positive.
    modal_mass: Option<f64>,
}

impl Scaled {
    fn all(
        (model, modes): (&ModalModel, &[usize]),
        mass: &RealMatrix,
        value: impl Fn(&ModeShape) -> Option<Vec<Complex64>>,
    ) -> Vec<Self> {
        let names = ModeName::all(model);
        let kept: Vec<(ModeName, Vec<Complex64>)> = modes
            .iter()
            .filter_map(|&i| Some((names[i], value(&model.modes[i].shape)?)))
            .collect();
        let options = kept
            .iter()
            .map(|(_, shape)| shape.iter().copied().map(Some));
        let cleared = without_rounding(options.map(Iterator::collect).collect());
        let shapes = cleared.into_iter().map(|own| own.into_iter().flatten());
        let scaled = |(name, shape): (ModeName, Vec<Complex64>)| {
            let momentum: Vec<Complex64> = (0..shape.len())
                .map(|i| (0..shape.len()).map(|j| shape[j] * mass[(i, j)]).sum())
                .collect();
            let modal_mass = inner(&shape, &momentum).re;
            Self {
                name,
                modal_mass: (modal_mass > 0.0).then_some(modal_mass),
                momentum,
                shape,
            }
        };
        let names = kept.iter().map(|(name, _)| *name);
        names
            .zip(shapes.map(Iterator::collect))
            .map(scaled)
            .collect()
    }

    fn products(rows: &[Self], columns: &[Self]) -> Vec<Vec<Option<f64>>> {
        let product = |a: &Self, b: &Self| {
            let masses = a.modal_mass? * b.modal_mass?;
            Some(inner(&a.shape, &b.momentum).norm() / masses.sqrt())
        };
        let row = |a: &Self| columns.iter().map(|b| product(a, b)).collect();
        rows.iter().map(row).collect()
    }
}

fn inner(a: &[Complex64], b: &[Complex64]) -> Complex64 {
    a.iter().zip(b).map(|(x, y)| x.conj() * y).sum()
}

#[cfg(test)]
mod tests {
    use super::super::models::{dof, model};
    use super::*;
    use crate::modal::{Mode, Scaling};
    use crate::theory::{Coordinate, ModeOptions, Motion, modes_of_matrices};

    /// Masses 1, 2, 3, ... kg in a row on springs of 1, 2, 3, ... kN/m, the first to ground.
    fn chain(n: usize) -> SystemMatrices {
        let spring = |i: usize| 1000.0 * (1 + i) as f64;
        let coordinate = |i: usize| Coordinate {
            name: format!("x{i}"),
            body: format!("m{i}"),
            motion: Motion::Translation,
            axis: [0.0, 0.0, 1.0],
            at_m: [0.0; 3],
        };
        SystemMatrices {
            mass: real_matrix(n, n, |i, j| if i == j { (1 + i) as f64 } else { 0.0 }),
            damping: None,
            stiffness: real_matrix(n, n, |i, j| match i.abs_diff(j) {
                0 => spring(i) + if i + 1 < n { spring(i + 1) } else { 0.0 },
                1 => -spring(i.max(j)),
                _ => 0.0,
            }),
            coordinates: (0..n).map(coordinate).collect(),
            springs: Vec::new(),
        }
    }

    /// Sensors on coordinates, the reading multiplied by a factor.
    fn sensors(n: usize, at: &[(usize, f64)]) -> Vec<SensorRow> {
        let sensor = |&(k, factor): &(usize, f64)| SensorRow {
            dof: dof(k + 1),
            row: (0..n).map(|i| if i == k { factor } else { 0.0 }).collect(),
        };
        at.iter().map(sensor).collect()
    }

    /// Modes of the whole model at these sensors.
    fn readings(matrices: &SystemMatrices, sensors: &[SensorRow]) -> (ModalModel, RealMatrix) {
        let solved = modes_of_matrices(matrices, &ModeOptions::default()).unwrap();
        let mode = |j: usize| {
            let value = |own: &SensorRow| {
                let terms = own.row.iter().enumerate();
                let reading: f64 = terms.map(|(i, b)| b * solved.vectors[(i, j)]).sum();
                (own.dof.clone(), Complex64::from(reading))
            };
            let shape = ModeShape::new(sensors.iter().map(value));
            let hz = solved.omega_rad_s[j] / std::f64::consts::TAU;
            Mode::new(hz, None, shape, Scaling::UnitModalMass)
        };
        let modes = (0..solved.omega_rad_s.len()).map(mode).collect();
        let own = ModalModel {
            modes,
            ..ModalModel::default()
        };
        (own, solved.vectors)
    }

    fn first(vectors: &RealMatrix, count: usize) -> RealMatrix {
        real_matrix(vectors.nrows(), count, |i, j| vectors[(i, j)])
    }

    fn own(test: &ModalModel, theory: &ModalModel, reduced: &ReducedMass) -> Orthogonality {
        let map = DofMap::of_models(test, theory);
        let names = orthogonality_dofs(test, theory, &map);
        assert_eq!(names, reduced.dofs);
        let columns: Vec<usize> = (0..theory.modes.len()).collect();
        orthogonality((test, theory), &map, reduced, &columns).unwrap()
    }

    #[test]
    fn with_all_coordinates_modes_are_orthogonal_and_a_mixture_has_its_cosine() {
        let matrices = chain(4);
        // Readings in other units: the mass follows them.
        let sensors = sensors(4, &[(0, 1.0), (1, 1000.0), (2, -1.0), (3, 1.0)]);
        let (theory, vectors) = readings(&matrices, &sensors);
        let reduced = reduced_mass(&matrices, &sensors, Reduction::Guyan, &vectors).unwrap();
        let mut test = theory.clone();
        // 0.8 of mode 1 and 0.6i of mode 2, both of unit modal mass.
        let mixed = theory.modes[0]
            .shape
            .iter()
            .zip(theory.modes[1].shape.iter());
        let mixed =
            mixed.map(|((dof, a), (_, b))| (dof.clone(), 0.8 * a + Complex64::new(0.0, 0.6) * b));
        test.modes[0].shape = ModeShape::new(mixed.collect::<Vec<_>>()).scaled(3.0.into());
        let found = own(&test, &theory, &reduced);
        let near = |got: Option<f64>, expected: f64| {
            assert!(
                (got.unwrap() - expected).abs() < 1e-12,
                "{got:?} {expected}"
            );
        };
        near(found.cross[0][0], 0.8);
        near(found.cross[0][1], 0.6);
        near(found.cross[2][2], 1.0);
        near(found.cross[2][0], 0.0);
        near(found.self_test[0][1], 0.6);
        near(found.self_theory[0][1], 0.0);
        assert_eq!((found.dofs, found.reduction_modes), (4, None));
    }

    #[test]
    fn serep_keeps_its_modes_orthogonal_at_few_sensors_and_guyan_nearly() {
        let matrices = chain(8);
        let sensors = sensors(8, &[(1, 1.0), (4, 1.0), (7, 1.0)]);
        let (theory, vectors) = readings(&matrices, &sensors);
        let kept = first(&vectors, 3);
        let serep = reduced_mass(&matrices, &sensors, Reduction::Serep, &kept).unwrap();
        let found = own(&theory, &theory, &serep);
        assert_eq!(found.reduction_modes, Some(3));
        let guyan = reduced_mass(&matrices, &sensors, Reduction::Guyan, &kept).unwrap();
        let near = own(&theory, &theory, &guyan);
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let expected = f64::from(u8::from(i == j));
            let (exact, bounded) = (found.cross[i][j].unwrap(), near.cross[i][j].unwrap());
            assert!((exact - expected).abs() < 1e-10, "{i} {j} {exact}");
            // The masses between the sensors of a static reduction do not follow the third mode.
            assert!((bounded - expected).abs() < 0.3, "{i} {j} {bounded}");
        }
        assert!(near.cross[0][1].unwrap() > 1e-6);
    }

    #[test]
    fn a_sensor_of_two_coordinates_is_for_serep() {
        let matrices = chain(3);
        let mut rows = sensors(3, &[(0, 1.0), (1, 1.0)]);
        rows[0].row[2] = 0.5;
        let (_, vectors) = readings(&matrices, &rows);
        let error = reduced_mass(&matrices, &rows, Reduction::Guyan, &vectors).unwrap_err();
        assert_eq!(error, CorrelateError::NotACoordinate { dof: dof(1) });
        let kept = first(&vectors, 2);
        assert!(reduced_mass(&matrices, &rows, Reduction::Serep, &kept).is_ok());
        let error = reduced_mass(&matrices, &rows, Reduction::Serep, &vectors).unwrap_err();
        assert!(matches!(error, CorrelateError::Reduction(_)), "{error}");
    }

    #[test]
    fn modes_at_0_hz_and_columns_that_nobody_asked_for_are_left_out() {
        let matrices = chain(3);
        let rows = sensors(3, &[(0, 1.0), (1, 1.0), (2, 1.0)]);
        let (theory, vectors) = readings(&matrices, &rows);
        let reduced = reduced_mass(&matrices, &rows, Reduction::Guyan, &vectors).unwrap();
        let mut test = theory.clone();
        test.modes[0].frequency_hz = 0.0;
        let map = DofMap::of_models(&test, &theory);
        let found = orthogonality((&test, &theory), &map, &reduced, &[2, 1]).unwrap();
        let numbers = |own: &[ModeName]| -> Vec<usize> { own.iter().map(|own| own.mode).collect() };
        assert_eq!(
            (numbers(&found.test), numbers(&found.theory)),
            (vec![2, 3], vec![2, 3])
        );
        assert!((found.cross[1][1].unwrap() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn sensors_without_a_value_in_one_mode_are_not_reduced_to() {
        let mut test = model(&[(10.0, &[1.0, 2.0, 3.0]), (20.0, &[1.0, 2.0])]);
        let theory = model(&[(10.0, &[1.0, 2.0, 3.0])]);
        let map = DofMap::of_models(&test, &theory);
        assert_eq!(orthogonality_dofs(&test, &theory, &map), [dof(1), dof(2)]);
        test.modes.pop();
        assert_eq!(orthogonality_dofs(&test, &theory, &map).len(), 3);
    }
}
