//! Damping, FRFs, reduction, sensitivities and sweeps of a chain with massless nodes.

use num_complex::Complex64;

use crate::linalg::{RealMatrix, SparseMatrix, real_matrix};

use super::condensation_tests::{Entries, MASS, SPRINGS, alternating, both, errors, solve, spring};
use super::massless::without_zeros;
use super::*;

/// The alternating chain with `C = alpha M + beta K`.
fn proportional(masses: usize, [alpha, beta]: [f64; 2]) -> SystemMatrices {
    let mut matrices = alternating(masses, false);
    let n = matrices.coordinates.len();
    matrices.damping = Some(real_matrix(n, n, |i, j| {
        alpha * matrices.mass[(i, j)] + beta * matrices.stiffness[(i, j)]
    }));
    matrices
}

#[test]
fn damping_proportional_to_mass_and_stiffness_leaves_the_condensation_exact() {
    let [alpha, beta] = [0.7, 3e-5];
    for masses in [3, 200] {
        for solved in both(&proportional(masses, [alpha, beta]), 10) {
            for (mode, omega) in solved.model.modes.iter().zip(&solved.omega_rad_s) {
                let ratio = 0.5 * (alpha / omega + beta * omega);
                assert!(
                    (mode.damping_ratio.expect("the model has damping") / ratio - 1.0).abs() < 1e-9
                );
            }
        }
    }
    let masses = 4;
    let damped =
        damped_modes(&proportional(masses, [alpha, beta])).expect("damping is proportional");
    let undamped = solve(&alternating(masses, false));
    assert_eq!((damped.vectors.nrows(), damped.poles_rad_s.len()), (9, 4));
    for (pole, omega) in damped.poles_rad_s.iter().zip(&undamped.omega_rad_s) {
        assert!((pole.norm() / omega - 1.0).abs() < 1e-12);
        assert!((pole.re / (-0.5 * (alpha + beta * omega * omega)) - 1.0).abs() < 1e-10);
    }
}

#[test]
fn a_damped_massless_coordinate_is_named() {
    let mut matrices = alternating(5, false);
    let n = matrices.coordinates.len();
    // A damper of 1e-9 N s/m at a massless node is more than rounding of those at the masses.
    for damper in [1e3, 1e-3] {
        matrices.damping = Some(real_matrix(n, n, |i, j| match (i, j) {
            (6, 6) => damper,
            (3, 3) => 10.0,
            _ => 0.0,
        }));
        for error in errors(&matrices) {
            let coordinates = vec!["7:+X".to_owned()];
            assert_eq!(error, TheoryError::Mass(MassError::Damped { coordinates }));
        }
        assert!(damped_modes(&matrices).is_err());
    }
}

#[test]
fn modes_and_static_compliance_together_are_the_frf_straight_from_the_matrices() {
    let mut matrices = alternating(5, false);
    let n = matrices.coordinates.len();
    // Dampers at two masses: the modes are complex.
    matrices.damping = Some(real_matrix(n, n, |i, j| match (i, j) {
        (1, 1) => 40.0,
        (5, 5) => 90.0,
        _ => 0.0,
    }));
    let damped = damped_modes(&matrices).expect("no damping acts on massless motions");
    let condensation = solve(&matrices)
        .condensation
        .expect("there are massless motions");
    assert_eq!(condensation.massless(), 6);
    let unit = |i: usize| {
        (0..n)
            .map(|k| f64::from(u8::from(k == i)))
            .collect::<Vec<f64>>()
    };
    let rows: Vec<Vec<f64>> = (0..n).map(unit).collect();
    let s = Complex64::new(0.0, 190.0);
    let direct = direct_receptance(&matrices, s, &rows, &rows).expect("s is no pole");
    let identity = real_matrix(n, n, |i, j| f64::from(u8::from(i == j)));
    let compliance = condensation
        .relax(&identity)
        .expect("stiffness holds massless motions");
    let largest = (0..n).map(|i| direct[(i, i)].norm()).fold(0.0, f64::max);
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let modal: Complex64 = (0..damped.poles_rad_s.len())
            .map(|r| {
                let (pole, phi) = (damped.poles_rad_s[r], |i| damped.vectors[(i, r)]);
                let residue = phi(i) * phi(j);
                residue / (s - pole) + residue.conj() / (s - pole.conj())
            })
            .sum();
        let whole = modal + compliance[(i, j)];
        assert!((whole - direct[(i, j)]).norm() < 1e-12 * largest, "{i} {j}");
    }
}

#[test]
fn reduction_to_the_coordinates_with_mass_keeps_every_frequency() {
    let matrices = alternating(6, false);
    let whole = solve(&matrices);
    let massive: Vec<usize> = (0..6).map(|i| 2 * i + 1).collect();
    for reduction in [
        guyan(&matrices, &massive).expect("the rest is held"),
        serep(&matrices, &whole.vectors, &massive).expect("as many modes as coordinates"),
    ] {
        let reduced = solve(&reduction.matrices);
        for (a, b) in reduced.omega_rad_s.iter().zip(&whole.omega_rad_s) {
            assert!((a / b - 1.0).abs() < 1e-10, "{a} {b}");
        }
        let shapes = &reduction.expansion * &reduced.vectors;
        for (i, j) in (0..13).flat_map(|i| (0..6).map(move |j| (i, j))) {
            assert!((shapes[(i, j)] - whole.vectors[(i, j)]).abs() < 1e-9);
        }
    }
    // Guyan to massless coordinates as well loses their mass.
    let kept: Vec<usize> = (0..13).collect();
    let same = solve(&guyan(&matrices, &kept).expect("the rest is held").matrices);
    assert_eq!(same.omega_rad_s.len(), 6);
}

/// The alternating chain with parameters: `into` scales every spring into a node, `mass` every
/// mass, `added` is a mass at the third coordinate, which has none at 0.
fn parameterised(masses: usize) -> ExternalModel {
    let matrices = alternating(masses, false);
    let size = matrices.coordinates.len();
    let springs = |which: usize| {
        let mut entries: Entries = (1..size)
            .filter(|i| i % 2 == which)
            .flat_map(|i| spring(i - 1, i, SPRINGS[which]))
            .collect();
        let end = if which == 0 { 0 } else { size - 1 };
        entries.push((end, end, SPRINGS[which]));
        SparseMatrix::from_entries(size, &entries).ok()
    };
    let parameter = |name: &str, nominal: f64| ParameterSpec {
        name: name.to_owned(),
        unit: "-".to_owned(),
        nominal,
        lower: Some(0.0),
        upper: Some(10.0),
        status: ParameterStatus::Printed,
        whole: false,
    };
    let group = |mass, stiffness| MatrixSet {
        mass,
        damping: None,
        stiffness,
    };
    let added = SparseMatrix::from_entries(size, &[(2, 2, 1.0)]).ok();
    ExternalModel::new(ExternalMatrices {
        title: "chain".to_owned(),
        dofs: (1..=size)
            .map(|i| format!("{i}:+X").parse().expect("a point and a direction"))
            .collect(),
        fixed: group(None, springs(1)),
        parameters: vec![
            parameter("into", 1.3),
            parameter("mass", 0.8),
            parameter("added", 0.0),
        ],
        groups: vec![
            ("into".to_owned(), group(None, springs(0))),
            (
                "mass".to_owned(),
                group(without_zeros(&matrices.mass).ok(), None),
            ),
            ("added".to_owned(), group(added, None)),
        ],
        damping: StatedDamping::default(),
        support: None,
    })
    .unwrap()
}

#[test]
fn sensitivities_and_shape_derivatives_are_those_of_differences() {
    let model = parameterised(6);
    let values = nominal_values(model.parameters());
    let at = |j: usize, value: f64| {
        let mut values = values.clone();
        values[j] = value;
        solve(&model.assemble(&values).expect("valid values"))
    };
    let base = at(0, values[0]);
    let roots = model_roots(&model, &base);
    let found = model_sensitivities(&model, &values, &base, &roots).expect("simple roots");
    for j in 0..3 {
        // `added` stands at its bound of 0: differences to one side, to the same order.
        let steps: &[(f64, f64)] = match j {
            2 => &[
                (0.0, -25.0 / 12.0),
                (1.0, 4.0),
                (2.0, -3.0),
                (3.0, 4.0 / 3.0),
                (4.0, -0.25),
            ],
            _ => &[
                (-2.0, 1.0 / 12.0),
                (-1.0, -2.0 / 3.0),
                (1.0, 2.0 / 3.0),
                (2.0, -1.0 / 12.0),
            ],
        };
        let h = 1e-3;
        let moved: Vec<(TheoryModes, f64)> = steps
            .iter()
            .map(|(step, weight)| (at(j, values[j] + step * h), weight / h))
            .collect();
        let by = model.derivative(&values, j).expect("j is a parameter");
        let each: Vec<Vec<usize>> = (0..6).map(|r| vec![r]).collect();
        let each: Vec<&[usize]> = each.iter().map(Vec::as_slice).collect();
        let derivatives = mode_derivatives(&base, &each, &by).expect("simple roots");
        for r in 0..6 {
            let sum = |of: &dyn Fn(&TheoryModes) -> f64| -> f64 {
                moved
                    .iter()
                    .map(|(solution, weight)| weight * of(solution))
                    .sum()
            };
            let lambda = base.omega_rad_s[r].powi(2);
            let slope = sum(&|at| at.omega_rad_s[r].powi(2));
            let sensitivity = found[r].mean(j).expect("j is a parameter");
            assert!(
                (sensitivity - slope).abs() < 1e-8 * lambda,
                "{j} {r}: {sensitivity} {slope}"
            );
            assert!((derivatives[r].projected[(0, 0)] / sensitivity - 1.0).abs() < 1e-10);
            // The derivative of the shape less its part along the shape, -phi (phi^T dM phi)/2.
            let moved_mass: RealMatrix = &by.mass * &base.vectors;
            let along: f64 = (0..13)
                .map(|i| base.vectors[(i, r)] * moved_mass[(i, r)])
                .sum();
            for i in 0..13 {
                let slope = sum(&|sensitivity| {
                    sensitivity.vectors[(i, r)] * sensitivity.vectors[(1, r)].signum()
                });
                let sign = base.vectors[(1, r)].signum();
                let expected = sign * slope + 0.5 * along * base.vectors[(i, r)];
                let derivative = derivatives[r].vectors[(i, 0)];
                assert!(
                    (derivative - expected).abs() < 1e-7,
                    "{j} {r} {i}: {derivative} {expected}"
                );
            }
        }
    }
}

#[test]
fn a_sweep_of_a_chain_with_massless_nodes_follows_its_closed_form() {
    let model = parameterised(4);
    let range = SweepRange {
        lower: 0.5,
        upper: 2.0,
        count: 4,
    };
    let values = nominal_values(model.parameters());
    let found = sweep(&model, &values, "into", range, None).expect("a valid range");
    assert_eq!(found.loci.len(), 4);
    for (k, value) in found.values.iter().enumerate() {
        let springs = SPRINGS[0] * value * SPRINGS[1] / (SPRINGS[0] * value + SPRINGS[1]);
        let angle = 0.5 * std::f64::consts::PI / 5.0;
        let exact = 2.0 * (springs / (0.8 * MASS)).sqrt() * angle.sin();
        let omega = found.loci[0].omega_rad_s[k].expect("the root is followed");
        assert!((omega / exact - 1.0).abs() < 1e-12, "{omega} {exact}");
    }
}
