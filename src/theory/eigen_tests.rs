//! Rigid-body modes, repeated roots, normalisation, options and residues.

use num_complex::Complex64;

use crate::axis::Band;
use crate::dof::Dof;
use crate::geometry::Target;
use crate::linalg::real_matrix;

use super::beam_modes_tests::{bar, modes_of, sensors};
use super::condensation_tests::system;
use super::*;

const LENGTH_M: f64 = 0.9;
const BEAM_KG: f64 = 7830.0 * 2.4e-4 * LENGTH_M;

fn assert_mass_orthonormal(matrices: &SystemMatrices, result: &TheoryModes) {
    let product = result.vectors.transpose() * &matrices.mass * &result.vectors;
    for (i, j) in (0..product.nrows()).flat_map(|i| (0..product.ncols()).map(move |j| (i, j))) {
        let expected = if i == j { 1.0 } else { 0.0 };
        assert!((product[(i, j)] - expected).abs() < 1e-9, "{i} {j}");
    }
}

#[test]
fn a_free_bar_has_two_rigid_modes_translation_and_turn_about_its_centre() {
    let model = BeamModel::new(bar(40, End::Free, End::Free)).unwrap();
    let positions = [0.0, 0.3, LENGTH_M];
    let result = modes(&model, &[], &sensors(&positions), &ModeOptions::default()).unwrap();
    assert_eq!(result.rigid, 2);
    assert_mass_orthonormal(&model.assemble(&[]).unwrap(), &result);
    for mode in &result.model.modes[..2] {
        assert_eq!(mode.frequency_hz.to_bits(), 0, "exactly 0 Hz");
        assert_eq!((mode.group, mode.damping_ratio), (Some(1), None));
    }
    // The two highest are edge modes of the elements at the two ends, alike to rounding: a true
    // repeated root.
    let resolved = &result.model.modes[2..80];
    assert!(resolved.iter().all(|mode| mode.group.is_none()));
    for (i, x) in positions.iter().enumerate() {
        let read = |j: usize| result.model.modes[j].shape.iter().nth(i).unwrap().1.re;
        let turn = (12.0 / BEAM_KG).sqrt() * (x / LENGTH_M - 0.5);
        assert!((read(0) - BEAM_KG.powf(-0.5)).abs() < 1e-7, "{}", read(0));
        assert!((read(1) - turn).abs() < 1e-7, "{} {turn}", read(1));
    }
}

#[test]
fn soft_slings_are_not_rigid_body_modes() {
    let mut file = bar(40, End::Free, End::Free);
    for x in [0.2, 0.7] {
        file.springs.push(SpringDescription {
            name: format!("sling {x}"),
            beam: "bar".to_owned(),
            at_m: super::beam_modes_tests::at(x),
            stiffness_n_per_m: Some(Value::Number(30.0)),
            stiffness_nm_per_rad: None,
        });
    }
    let result = modes_of(file, &[]);
    assert_eq!(result.rigid, 0);
    let bounce = 60.0 / BEAM_KG;
    let close = |omega: &f64| (omega * omega / bounce - 1.0).abs() < 0.02;
    assert!(
        result.omega_rad_s[..2].iter().any(close),
        "{:?}",
        &result.omega_rad_s[..2]
    );
}

#[test]
fn two_equal_bars_give_repeated_roots_each_with_one_bar_at_rest() {
    let mut file = bar(12, End::Free, End::Free);
    let mut other = file.beams[0].clone();
    other.name = "other".to_owned();
    file.beams.push(other);
    let model = BeamModel::new(file).unwrap();
    let result = modes(&model, &[], &[], &ModeOptions::default()).unwrap();
    assert_eq!(result.rigid, 4);
    assert_mass_orthonormal(&model.assemble(&[]).unwrap(), &result);
    let half = result.coordinates.len() / 2;
    let energy = |j: usize, rows: std::ops::Range<usize>| -> f64 {
        rows.map(|i| result.vectors[(i, j)].powi(2)).sum()
    };
    for j in 4..12 {
        let mode = &result.model.modes[j];
        assert_eq!(mode.group, Some(j as u32 / 2));
        assert_eq!(
            mode.frequency_hz.to_bits(),
            result.model.modes[j ^ 1].frequency_hz.to_bits()
        );
        let (first, second) = (energy(j, 0..half), energy(j, half..2 * half));
        let resting = if j % 2 == 0 {
            second / first
        } else {
            first / second
        };
        assert!(resting < 1e-20, "{j}: {resting:e}");
    }
}

#[test]
fn the_largest_component_is_positive() {
    let result = modes_of(bar(9, End::Clamped, End::Free), &[]);
    for j in 0..result.vectors.ncols() {
        let column = (0..result.vectors.nrows()).map(|i| result.vectors[(i, j)]);
        let largest = column.max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap();
        assert!(largest > 0.0, "mode {j}");
    }
}

#[test]
fn band_and_count_select_the_lowest_modes_inside() {
    let model = BeamModel::new(bar(10, End::Free, End::Free)).unwrap();
    let all = modes(&model, &[], &[], &ModeOptions::default()).unwrap();
    let hz = |result: &TheoryModes| -> Vec<f64> {
        result
            .model
            .modes
            .iter()
            .map(|mode| mode.frequency_hz)
            .collect()
    };
    let expected = hz(&all);
    let band = Band::new(1.0, expected[4]).unwrap();
    let select = |band, count| {
        let options = ModeOptions {
            band,
            count,
            damping_ratio: Some(0.01),
        };
        modes(&model, &[], &[], &options).unwrap()
    };
    let inside = select(Some(band), None);
    assert_eq!((hz(&inside), inside.rigid), (expected[2..5].to_vec(), 0));
    assert_eq!(inside.vectors.ncols(), 3);
    assert!((inside.vectors[(0, 1)] - all.vectors[(0, 3)]).abs() < 1e-15);
    let first = select(None, Some(3));
    assert_eq!((hz(&first), first.rigid), (expected[..3].to_vec(), 2));
    assert_eq!(first.model.modes[2].damping_ratio, Some(0.01));
}

#[test]
fn impossible_requests_are_refused() {
    let model = BeamModel::new(bar(4, End::Free, End::Free)).unwrap();
    let ask = |sensors: &[crate::geometry::Sensor], damping_ratio| {
        let options = ModeOptions {
            damping_ratio,
            ..ModeOptions::default()
        };
        modes(&model, &[], sensors, &options).unwrap_err()
    };
    assert_eq!(ask(&[], Some(1.0)), TheoryError::DampingRatio { got: 1.0 });
    let mut twice = sensors(&[0.1, 0.2]);
    twice[1].dof = "1:-Z".parse().unwrap();
    assert!(matches!(
        ask(&twice, None),
        TheoryError::Duplicate { what: "sensor", .. }
    ));
    let mut turning = sensors(&[0.1]);
    turning[0].dof = "1:+RY".parse().unwrap();
    assert!(matches!(
        ask(&turning, None),
        TheoryError::RotationAtPoint { .. }
    ));
    turning[0].target = Target::Coordinate("bar.theta1".to_owned());
    assert!(modes(&model, &[], &turning, &ModeOptions::default()).is_ok());

    let mut matrices = model.assemble(&[]).unwrap();
    let solve = |m: &SystemMatrices| modes_of_matrices(m, &ModeOptions::default()).unwrap_err();
    matrices.stiffness[(0, 1)] += 1.0;
    assert!(matches!(
        solve(&matrices),
        TheoryError::MatrixEntry {
            row: 1,
            column: 0,
            ..
        }
    ));
    matrices.stiffness = real_matrix(3, 10, |_, _| 0.0);
    assert!(matches!(
        solve(&matrices),
        TheoryError::MatrixSize {
            got_rows: 3,
            expected: 10,
            ..
        }
    ));
    matrices.stiffness = real_matrix(10, 10, |i, j| if i == j { -1.0 } else { 0.0 });
    assert!(matches!(
        solve(&matrices),
        TheoryError::NegativeStiffness { .. }
    ));
}

/// The bar with `C = factor K`, for which damping ratios are `factor omega / 2`.
fn proportional(elements: usize, start: End, factor: f64) -> SystemMatrices {
    let model = BeamModel::new(bar(elements, start, End::Free)).unwrap();
    let mut matrices = model.assemble(&[]).unwrap();
    let n = matrices.coordinates.len();
    matrices.damping = Some(real_matrix(n, n, |i, j| {
        factor * matrices.stiffness[(i, j)]
    }));
    matrices
}

#[test]
fn a_proportional_damping_matrix_gives_its_damping_ratios() {
    let result = modes_of_matrices(&proportional(4, End::Free, 1e-6), &ModeOptions::default());
    let result = result.unwrap();
    for (mode, omega) in result.model.modes.iter().zip(&result.omega_rad_s).skip(2) {
        assert!((mode.damping_ratio.unwrap() / (0.5e-6 * omega) - 1.0).abs() < 1e-9);
    }
}

#[test]
fn residues_rebuild_the_direct_solution_of_the_equations_of_motion() {
    let factor = 1e-6;
    for start in [End::Free, End::Clamped] {
        let matrices = proportional(3, start, factor);
        let mut file = bar(3, start, End::Free);
        file.title = "residues".to_owned();
        let model = BeamModel::new(file).unwrap();
        let places = sensors(&[0.25, 0.83]);
        let result = modes(&model, &[], &places, &ModeOptions::default()).unwrap();
        let ratios: Vec<f64> = result.omega_rad_s[result.rigid..]
            .iter()
            .map(|omega| 0.5 * factor * omega)
            .collect();
        let (response, hit): (Dof, Dof) = ("2:-Z".parse().unwrap(), "1:+Z".parse().unwrap());
        let parts = residues(&result, &ratios, &[(response, hit)])
            .unwrap()
            .remove(0);
        let rows: Vec<Vec<f64>> = places
            .iter()
            .map(|s| model.observation_row(&[], &s.target).unwrap())
            .collect();
        let lowest = result.omega_rad_s[result.rigid];
        for omega in [0.3 * lowest, lowest, 2.7 * lowest] {
            let s = Complex64::I * omega;
            let modal: Complex64 = parts
                .elastic
                .iter()
                .map(|(pole, a)| a / (s - pole.lambda) + a.conj() / (s - pole.lambda.conj()))
                .sum();
            let modal = modal + parts.rigid_body_accelerance_per_kg / (s * s);
            let direct = direct_receptance(&matrices, s, &rows[1..], &rows[..1]).unwrap();
            let direct = -direct[(0, 0)];
            assert!(
                (modal - direct).norm() < 1e-8 * direct.norm(),
                "{modal} {direct}"
            );
        }
    }
}

#[test]
fn residues_need_a_ratio_for_each_elastic_mode_and_a_known_sensor() {
    let result = modes_of(bar(2, End::Free, End::Free), &sensors(&[0.1]));
    let pair = |text: &str| (text.parse().unwrap(), "1:+Z".parse().unwrap());
    let count = residues(&result, &[0.01; 6], &[pair("1:+Z")]).unwrap_err();
    assert_eq!(
        count,
        TheoryError::DampingCount {
            got: 6,
            expected: 4
        }
    );
    let ratio = residues(&result, &[0.01, 0.01, -0.1, 0.0], &[]).unwrap_err();
    assert_eq!(ratio, TheoryError::DampingRatio { got: -0.1 });
    let unknown = residues(&result, &[0.01; 4], &[pair("9:+Z")]).unwrap_err();
    assert!(matches!(unknown, TheoryError::NotObserved { .. }));
}

#[test]
fn close_roots_share_a_group_and_keep_their_frequencies() {
    // Two 1e-8 of the frequency apart; two equal but for rounding, and a third 1e-8 away.
    let squared = [1.0, 1.0 + 2e-8, 4.0, 4.0 * (1.0 + 4e-16), 4.0 + 8e-8, 9.0].map(|x| 1e6 * x);
    let n = squared.len();
    let (mass, stiffness): (Vec<_>, Vec<_>) =
        (0..n).map(|i| ((i, i, 1.0), (i, i, squared[i]))).unzip();
    let matrices = system(n, &mass, &stiffness);
    let result = modes_of_matrices(&matrices, &ModeOptions::default()).unwrap();
    let groups: Vec<Option<u32>> = result.model.modes.iter().map(|mode| mode.group).collect();
    assert_eq!(groups, [Some(1), Some(1), Some(2), Some(2), Some(2), None]);
    for (omega, squared) in result.omega_rad_s.iter().zip(squared) {
        assert!((omega / squared.sqrt() - 1.0).abs() < 1e-12, "{omega}");
    }
    let bits = |j: usize| result.omega_rad_s[j].to_bits();
    assert_eq!(bits(2), bits(3));
}
