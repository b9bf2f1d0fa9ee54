//! Tests of repeated poles: several references show all modes of a repeated pole, and a single mode
//! never becomes one.

use std::f64::consts::PI;

use num_complex::Complex64;

use crate::axis::FrequencyAxis;
use crate::dof::Dof;
use crate::finding::{Code, Severity};
use crate::identify::estimator::IdentifyOptions;
use crate::identify::identify;
use crate::identify::synthetic::{Measurement, Pair, Structure, close_pair, separated_modes};
use crate::identify::tests::seeds;
use crate::linalg::{self, ComplexMatrix};
use crate::modal::{ModalModel, Mode, Scaling};

const METHODS: [&str; 2] = ["peak", "circle"];
const REPEATED_POLE: (f64, f64) = (150.0, 0.01);

fn dof(point: usize) -> Dof {
    format!("{point}:+Z").parse().unwrap()
}

/// Cosine shapes on a line of points, orthogonal over the points.
fn wave(number: usize, points: usize) -> Vec<f64> {
    let value = |p: usize| (PI * number as f64 * (p as f64 + 0.5) / points as f64).cos();
    (0..points).map(value).collect()
}

/// A repeated pole of a multiplicity at 150 Hz between single modes at 60 Hz and 300 Hz.
fn ring(points: usize, multiplicity: usize) -> Structure {
    let repeated = (0..multiplicity).map(|j| (REPEATED_POLE.0, REPEATED_POLE.1, wave(j, points)));
    let mut modes: Vec<_> = repeated.collect();
    let shape = |phase: f64| (0..points).map(move |p| (phase * (p + 1) as f64).sin());
    modes.insert(0, (60.0, 0.015, shape(1.0).collect()));
    modes.push((300.0, 0.008, shape(2.1).collect()));
    Structure { modes }
}

fn grid(responses: &[usize], references: &[usize], snr_db: Option<f64>) -> Measurement {
    let axis = FrequencyAxis {
        start_hz: 0.0,
        step_hz: 0.2,
        len: 2001,
    };
    let pairs = responses
        .iter()
        .flat_map(|r| references.iter().map(|k| (dof(*r), dof(*k))));
    Measurement {
        pairs: pairs.collect(),
        snr_db,
        ..Measurement::of_sensors(1, axis)
    }
}

fn identified(structure: &Structure, how: &Measurement, method: &str) -> ModalModel {
    let options = IdentifyOptions {
        method: method.to_owned(),
        ..IdentifyOptions::default()
    };
    identify(&structure.measured(how), &options).unwrap()
}

fn codes(model: &ModalModel, code: Code) -> usize {
    model.findings.iter().filter(|f| f.code == code).count()
}

fn columns(rows: usize, shapes: &[Vec<Complex64>]) -> ComplexMatrix {
    linalg::complex_matrix(rows, shapes.len(), |i, j| shapes[j][i])
}

/// Sine of the largest principal angle of two spaces: the norm of the orthonormal basis of one
/// after projection off the other.
fn largest_angle(a: &[Vec<Complex64>], b: &[Vec<Complex64>]) -> f64 {
    let rows = a[0].len();
    let basis = |shapes| {
        linalg::singular_vectors(&columns(rows, shapes))
            .unwrap()
            .left
    };
    let (a, b) = (basis(a), basis(b));
    let outside = &b - &a * (a.adjoint() * &b);
    linalg::singular_values(&outside).unwrap()[0]
}

fn found_shapes(modes: &[&Mode]) -> Vec<Vec<Complex64>> {
    let values = |mode: &&Mode| mode.shape.iter().map(|(_, value)| value).collect();
    modes.iter().map(values).collect()
}

/// Shapes of the true modes of the repeated pole at the points of a shape.
fn true_shapes(structure: &Structure, mode: &Mode) -> Vec<Vec<Complex64>> {
    let repeated = structure
        .modes
        .iter()
        .filter(|m| (m.0 - REPEATED_POLE.0).abs() < 1e-9);
    let components = |shape: &Vec<f64>| {
        let value = |dof: &Dof| Complex64::from(shape[dof.node().unwrap() as usize - 1]);
        mode.shape.iter().map(|(dof, _)| value(dof)).collect()
    };
    repeated.map(|(_, _, shape)| components(shape)).collect()
}

/// The modes of the repeated pole: as many as stated, one group, one pole; the two single modes
/// have no group.
fn repeated_modes(model: &ModalModel, multiplicity: usize) -> Vec<&Mode> {
    assert_eq!(model.modes.len(), multiplicity + 2, "{:?}", model.findings);
    let modes: Vec<&Mode> = model.modes[1..=multiplicity].iter().collect();
    for mode in &modes {
        assert_eq!(mode.group, Some(1));
        assert_eq!(mode.pole(), modes[0].pole());
        assert!((mode.frequency_hz / REPEATED_POLE.0 - 1.0).abs() < 1e-4);
    }
    assert_eq!(model.modes[0].group, None);
    assert_eq!(model.modes[multiplicity + 1].group, None);
    assert_eq!(codes(model, Code::CloseModes), 0, "{:?}", model.findings);
    let repeated_pole_findings: Vec<_> = model
        .findings
        .iter()
        .filter(|f| f.code == Code::RepeatedRoot)
        .map(|f| (f.severity, f.value))
        .collect();
    assert_eq!(
        repeated_pole_findings,
        [(Severity::Info, Some(multiplicity as f64))]
    );
    modes
}

#[test]
fn repeated_pole_of_multiplicity_four_gives_four_modes_of_one_group() {
    let structure = ring(9, 4);
    let (responses, references) = ([1, 2, 3, 4, 5, 6, 7, 8, 9], [1, 2, 4, 5, 7, 9]);
    for method in METHODS {
        let how = grid(&responses, &references, None);
        let model = identified(&structure, &how, method);
        let modes = repeated_modes(&model, 4);
        let angle = largest_angle(&true_shapes(&structure, modes[0]), &found_shapes(&modes));
        assert!(angle < 1e-6, "{method} {angle:e}");
        for pair in &how.pairs {
            let sum: Complex64 = modes.iter().map(|mode| mode.residues[pair]).sum();
            let truth: Complex64 = (1..=4).map(|j| structure.residue(j, pair)).sum();
            // The largest residue of the modes is near 4/(2 ω_d).
            let error = (sum - truth).norm() * REPEATED_POLE.0 * PI;
            assert!(error < 1e-5, "{method} {error:e}");
        }
    }
}

#[test]
fn noise_at_sixty_decibels_rotates_the_space_of_four_shapes_little() {
    let structure = ring(9, 4);
    let (responses, references) = ([1, 2, 3, 4, 5, 6, 7, 8, 9], [1, 2, 4, 5, 7, 9]);
    for (method, variance_given) in [("peak", true), ("circle", true), ("circle", false)] {
        let how = Measurement {
            variance_given,
            ..grid(&responses, &references, Some(60.0))
        };
        let model = identified(&structure, &how, method);
        let modes = repeated_modes(&model, 4);
        let angle = largest_angle(&true_shapes(&structure, modes[0]), &found_shapes(&modes));
        assert!(angle < 5e-3, "{method} {angle:e}");
    }
}

#[test]
fn driving_points_give_all_modes_of_a_repeated_pole_unit_modal_mass() {
    let structure = ring(9, 4);
    let how = grid(&[1, 2, 3, 4, 5, 6, 7, 8, 9], &[1, 2, 4, 5, 7, 9], None);
    let model = identified(&structure, &how, "circle");
    let modes = repeated_modes(&model, 4);
    for mode in &modes {
        assert_eq!(mode.scaling, Scaling::UnitModalMass);
        assert_eq!(mode.modal_mass_kg, Some(1.0));
    }
    // Σ φ φᵀ is the same for every basis of unit modal masses.
    for (a, b) in (1..=9).flat_map(|a| (1..=9).map(move |b| (a, b))) {
        let component_product =
            |mode: &&Mode| mode.shape.get(&dof(a)).unwrap() * mode.shape.get(&dof(b)).unwrap();
        let found: Complex64 = modes.iter().map(component_product).sum();
        let truth: f64 = (0..4).map(|j| wave(j, 9)[a - 1] * wave(j, 9)[b - 1]).sum();
        assert!((found - truth).norm() < 1e-4, "{a} {b} {found} {truth}");
    }
    let without_driving_points = grid(&[1, 2, 3, 5, 6, 8], &[4, 7, 9, 10], None);
    let model = identified(&ring(10, 3), &without_driving_points, "circle");
    for mode in repeated_modes(&model, 3) {
        assert_eq!((mode.scaling, mode.modal_mass_kg), (Scaling::UnitMax, None));
        let (_, largest) = mode.shape.largest().unwrap();
        assert!((largest - 1.0).norm() < 1e-12);
    }
}

#[test]
fn ten_references_give_all_modes_of_multiplicity_eight() {
    let structure = ring(10, 8);
    let all: Vec<usize> = (1..=10).collect();
    for snr_db in [None, Some(60.0)] {
        let model = identified(&structure, &grid(&all, &all, snr_db), "circle");
        let modes = repeated_modes(&model, 8);
        let angle = largest_angle(&true_shapes(&structure, modes[0]), &found_shapes(&modes));
        let bound = if snr_db.is_some() { 5e-3 } else { 1e-6 };
        assert!(angle < bound, "{snr_db:?} {angle:e}");
    }
}

#[test]
fn two_references_give_two_of_four_modes_of_a_repeated_pole() {
    let structure = ring(9, 4);
    let how = grid(&[1, 2, 3, 4, 5, 6, 7, 8, 9], &[1, 4], None);
    let model = identified(&structure, &how, "circle");
    let modes = repeated_modes(&model, 2);
    let angle = largest_angle(&true_shapes(&structure, modes[0]), &found_shapes(&modes));
    assert!(angle < 1e-6, "{angle:e}");
}

#[test]
fn roving_hammer_gives_repeated_shapes_at_the_excitation_points() {
    let structure = ring(9, 3);
    let how = grid(&[2, 5, 9], &[1, 2, 3, 4, 5, 6, 7, 8, 9], None);
    let model = identified(&structure, &how, "circle");
    let modes = repeated_modes(&model, 3);
    assert!(modes.iter().all(|mode| mode.shape.len() == 9));
    let angle = largest_angle(&true_shapes(&structure, modes[0]), &found_shapes(&modes));
    assert!(angle < 1e-6, "{angle:e}");
}

#[test]
fn incomplete_frf_matrix_gives_one_mode_per_repeated_pole() {
    let structure = ring(9, 2);
    let all = [1, 2, 3, 4, 5, 6, 7, 8, 9];
    let mut incomplete = grid(&all, &[1, 4, 7], None);
    incomplete.pairs.pop();
    for how in [grid(&all, &[1], None), grid(&[1], &all, None), incomplete] {
        let model = identified(&structure, &how, "circle");
        assert_eq!(model.modes.len(), 3, "{:?}", model.findings);
        assert!(model.modes.iter().all(|mode| mode.group.is_none()));
        assert_eq!(codes(&model, Code::RepeatedRoot), 0);
    }
}

#[test]
fn noise_never_turns_a_single_mode_into_a_repeated_pole() {
    let mut judged = 0;
    for seed in seeds(200) {
        let random = separated_modes(seed).0.modes.into_iter();
        let poles = [(60.0, 0.015), REPEATED_POLE, (300.0, 0.008)].into_iter();
        let modes = poles.zip(random).map(|((hz, zeta), m)| (hz, zeta, m.2));
        let modes = modes.collect();
        let axis = FrequencyAxis {
            start_hz: 0.0,
            step_hz: 0.4,
            len: 1000,
        };
        let snr_db = 20.0 + 10.0 * (seed % 5) as f64;
        let how = Measurement {
            axis,
            seed,
            variance_given: seed % 3 > 0,
            ..grid(&[1, 2, 3, 4, 5], &[1, 3, 4], Some(snr_db))
        };
        let model = identified(&Structure { modes }, &how, METHODS[seed as usize % 2]);
        assert_eq!(codes(&model, Code::RepeatedRoot), 0, "{seed}");
        assert!(model.modes.iter().all(|mode| mode.group.is_none()));
        judged += model.modes.len();
    }
    assert!(2 * judged >= 5 * seeds(200).count(), "{judged}");
}

#[test]
fn modes_half_a_bandwidth_apart_are_close_not_repeated() {
    for (ratio, snr_db) in [
        (1.0, None),
        (0.5, None),
        (1.0, Some(60.0)),
        (0.5, Some(40.0)),
    ] {
        for (seed, method) in (0..3).flat_map(|seed| METHODS.map(|method| (seed, method))) {
            let pair = Pair {
                spacing_widths: 0.5,
                difference: None,
                ratio,
                lines_per_width: (6.0, 15.0),
            };
            let (structure, how) = close_pair(seed, pair);
            let how = Measurement {
                axis: how.axis,
                ..grid(&[1, 2, 3, 4, 5], &[1, 2, 3], snr_db)
            };
            let model = identified(&structure, &how, method);
            assert_eq!(codes(&model, Code::RepeatedRoot), 0, "{seed} {ratio}");
            assert!(codes(&model, Code::CloseModes) > 0, "{seed} {ratio}");
        }
    }
}
