//! Orthogonality through reduced mass matrices of chains of masses.

use num_complex::Complex64;
use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::super::subspace::subspace_mac;
use super::super::{CorrelateError, DofMap};
use super::models::{dof, model};
use super::{
    ModeName, Orthogonality, ReducedMass, Reduction, SensorRow, orthogonality, orthogonality_dofs,
    reduced_mass, serep_modes,
};
use crate::dof::Dof;
use crate::linalg::{RealMatrix, real_matrix};
use crate::modal::{ModalModel, Mode, ModeShape, Scaling};
use crate::theory::{Coordinate, ModeOptions, Motion, SystemMatrices, modes_of_matrices};

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
        let value = |sensor: &SensorRow| {
            let terms = sensor.row.iter().enumerate();
            let reading: f64 = terms.map(|(i, b)| b * solved.vectors[(i, j)]).sum();
            (sensor.dof.clone(), Complex64::from(reading))
        };
        let shape = ModeShape::new(sensors.iter().map(value));
        let hz = solved.omega_rad_s[j] / std::f64::consts::TAU;
        Mode::new(hz, None, shape, Scaling::UnitModalMass)
    };
    let modes = (0..solved.omega_rad_s.len()).map(mode).collect();
    let model = ModalModel {
        modes,
        ..ModalModel::default()
    };
    (model, solved.vectors)
}

fn first(vectors: &RealMatrix, count: usize) -> RealMatrix {
    real_matrix(vectors.nrows(), count, |i, j| vectors[(i, j)])
}

fn orthogonality_of(
    test: &ModalModel,
    theory: &ModalModel,
    reduced: &ReducedMass,
) -> Orthogonality {
    let map = DofMap::of_models(test, theory);
    let names = orthogonality_dofs(test, theory, &map);
    assert_eq!(names, reduced.dofs);
    let columns: Vec<usize> = (0..theory.modes.len()).collect();
    orthogonality(test, theory, &map, reduced, &columns).unwrap()
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
    let found = orthogonality_of(&test, &theory, &reduced);
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
    let found = orthogonality_of(&theory, &theory, &serep);
    assert_eq!(found.reduction_modes, Some(3));
    let guyan = reduced_mass(&matrices, &sensors, Reduction::Guyan, &kept).unwrap();
    let near = orthogonality_of(&theory, &theory, &guyan);
    for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
        let expected = f64::from(u8::from(i == j));
        let (exact, bounded) = (found.cross[i][j].unwrap(), near.cross[i][j].unwrap());
        assert!((exact - expected).abs() < 1e-10, "{i} {j} {exact}");
        // The masses between the sensors of a static reduction do not follow the third mode.
        assert!((bounded - expected).abs() < 0.3, "{i} {j} {bounded}");
    }
    assert!(near.cross[0][1].unwrap() > 1e-6);
}

/// `a` times one shape and `b` times another.
fn sum((a, x): (f64, &ModeShape), (b, y): (f64, &ModeShape)) -> ModeShape {
    let both = x.iter().zip(y.iter());
    ModeShape::new(both.map(|((dof, x), (_, y))| (dof.clone(), a * x + b * y)))
}

#[test]
fn serep_and_guyan_detect_shape_errors_and_serep_reports_the_part_outside() {
    let matrices = chain(4);
    let sensors = sensors(4, &[(0, 1.0), (1, 1.0), (2, 1.0), (3, 1.0)]);
    let (theory, vectors) = readings(&matrices, &sensors);
    let shape = |j: usize| &theory.modes[j].shape;
    let mut test = theory.clone();
    test.modes.truncate(2);
    for n in 0..2 {
        test.modes[n].shape = sum((0.85, shape(n)), (0.53, shape(2)));
    }
    let map = DofMap::of_models(&test, &theory);
    let names: Vec<Dof> = sensors.iter().map(|sensor| sensor.dof.clone()).collect();
    let of = |reduction: Reduction, kept: &[usize]| {
        let modes = real_matrix(4, kept.len(), |i, j| vectors[(i, kept[j])]);
        let reduced = reduced_mass(&matrices, &sensors, reduction, &modes).unwrap();
        orthogonality(&test, &theory, &map, &reduced, kept).unwrap()
    };
    let kept = serep_modes(&theory, &names, &[0, 1]).kept;
    assert_eq!(kept, [0, 1, 2, 3]);
    let (serep, guyan) = (of(Reduction::Serep, &kept), of(Reduction::Guyan, &kept));
    // With all coordinates measured both are exact; modes of unit modal mass.
    let squared = 0.85f64 * 0.85 + 0.53 * 0.53;
    for result in [&serep, &guyan] {
        assert!((result.cross[0][0].unwrap() - 0.85 / squared.sqrt()).abs() < 1e-9);
        assert!((result.cross[0][1].unwrap()).abs() < 1e-9);
        assert!((result.self_test[0][1].unwrap() - 0.53 * 0.53 / squared).abs() < 1e-9);
    }
    assert!(serep.outside.iter().all(|part| part.unwrap() < 1e-9));
    assert!(serep.findings().is_empty());
    assert_eq!(guyan.outside, [None, None]);
    // Through the paired modes alone much of what is wrong lies outside, and that is said.
    let paired = of(Reduction::Serep, &[0, 1]);
    let expected = |n: usize| {
        let values =
            |shape: &ModeShape| -> Vec<Complex64> { shape.iter().map(|(_, v)| v).collect() };
        let span = [values(shape(0)), values(shape(1))];
        1.0 - subspace_mac(&values(&test.modes[n].shape), &span).unwrap()
    };
    for n in 0..2 {
        assert!((paired.outside[n].unwrap() - expected(n)).abs() < 1e-12);
    }
    assert!(expected(0) > 0.05 && expected(1) > 0.05, "{paired:?}");
    let findings = paired.findings();
    assert_eq!(findings.len(), 2);
    assert_eq!(findings[0].value, paired.outside[0]);
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
fn rigid_body_modes_and_unrequested_columns_are_left_out() {
    let matrices = chain(3);
    let rows = sensors(3, &[(0, 1.0), (1, 1.0), (2, 1.0)]);
    let (theory, vectors) = readings(&matrices, &rows);
    let reduced = reduced_mass(&matrices, &rows, Reduction::Guyan, &vectors).unwrap();
    let mut test = theory.clone();
    test.modes[0].frequency_hz = 0.0;
    let map = DofMap::of_models(&test, &theory);
    let found = orthogonality(&test, &theory, &map, &reduced, &[2, 1]).unwrap();
    let numbers =
        |names: &[ModeName]| -> Vec<usize> { names.iter().map(|name| name.mode).collect() };
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

#[test]
fn errors_of_shapes_hardly_lower_the_cross_orthogonality() {
    // A chain of 40 masses with 14 sensors at drawn places; 14 modes are paired.
    let matrices = chain(40);
    for seed in 0..8 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut places: Vec<usize> = (0..40).collect();
        places.shuffle(&mut random);
        let at: Vec<(usize, f64)> = places[..14].iter().map(|place| (*place, 1.0)).collect();
        let sensors = sensors(40, &at);
        let (mut theory, vectors) = readings(&matrices, &sensors);
        theory.modes.truncate(20);
        // Errors of 6 % of the shape: a MAC of 0.996.
        let mut test = theory.clone();
        test.modes.truncate(14);
        for mode in &mut test.modes {
            let values: Vec<(Dof, Complex64)> = mode
                .shape
                .iter()
                .map(|(dof, value)| (dof.clone(), value))
                .collect();
            let squares: f64 = values.iter().map(|(_, value)| value.norm_sqr()).sum();
            let error = 0.063 * (squares / 14.0).sqrt();
            let mut noise = || error * 3f64.sqrt() * random.random_range(-1.0..1.0);
            mode.shape = ModeShape::new(values.into_iter().map(|(dof, v)| (dof, v + noise())));
        }
        let map = DofMap::of_models(&test, &theory);
        let names = orthogonality_dofs(&test, &theory, &map);
        let sensors: Vec<SensorRow> = (names.iter())
            .map(|dof| {
                sensors
                    .iter()
                    .find(|sensor| sensor.dof == *dof)
                    .unwrap()
                    .clone()
            })
            .collect();
        let paired: Vec<usize> = (0..14).collect();
        let cross = |kept: &[usize]| {
            let modes = real_matrix(40, kept.len(), |i, j| vectors[(i, kept[j])]);
            let reduced = reduced_mass(&matrices, &sensors, Reduction::Serep, &modes).unwrap();
            let found = orthogonality(&test, &theory, &map, &reduced, kept).unwrap();
            let of_pairs = kept.iter().enumerate();
            let values = of_pairs.filter_map(|(j, mode)| *found.cross.get(*mode)?.get(j)?);
            values.fold(1.0, f64::min)
        };
        let selection = serep_modes(&theory, &names, &paired);
        assert!(selection.condition_number <= 10.0, "{selection:?}");
        assert!(selection.kept.len() >= 6, "{selection:?}");
        let (all, kept) = (cross(&paired), cross(&selection.kept));
        assert!(
            kept > 0.9 && kept > all + 0.1,
            "{seed}: {kept} {all} {selection:?}"
        );
    }
}
