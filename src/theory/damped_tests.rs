use num_complex::Complex64;

use super::*;
use crate::linalg::real_matrix;

/// Masses in a row, each tied to the next and both ends to ground.
struct Chain {
    mass_kg: Vec<f64>,
    stiffness_n_per_m: Vec<f64>,
    damping: RealMatrix,
}

impl Chain {
    fn new(mass_kg: &[f64], stiffness_n_per_m: &[f64]) -> Self {
        Self {
            mass_kg: mass_kg.to_vec(),
            stiffness_n_per_m: stiffness_n_per_m.to_vec(),
            damping: real_matrix(mass_kg.len(), mass_kg.len(), |_, _| 0.0),
        }
    }

    fn matrices(&self) -> SystemMatrices {
        let (n, k) = (self.mass_kg.len(), &self.stiffness_n_per_m);
        let coordinate = |i: usize| Coordinate {
            name: format!("x{i}"),
            body: format!("mass {i}"),
            motion: Motion::Translation,
            axis: [1.0, 0.0, 0.0],
            at_m: [i as f64, 0.0, 0.0],
        };
        SystemMatrices {
            mass: real_matrix(n, n, |i, j| if i == j { self.mass_kg[i] } else { 0.0 }),
            damping: Some(self.damping.clone()),
            stiffness: real_matrix(n, n, |i, j| match i.abs_diff(j) {
                0 => k[i] + k[i + 1],
                1 => -k[i.max(j)],
                _ => 0.0,
            }),
            coordinates: (0..n).map(coordinate).collect(),
            springs: Vec::new(),
        }
    }
}

fn uneven() -> Chain {
    Chain::new(&[1.0, 2.5, 0.7, 1.3, 0.9], &[3e5, 2e5, 5e5, 1e5, 4e5, 2e5])
}

/// `(M s^2 + C s + K)^-1`, column by column.
fn direct(matrices: &SystemMatrices, s: Complex64) -> crate::linalg::ComplexMatrix {
    let n = matrices.coordinates.len();
    let unit = |i: usize| (0..n).map(|j| f64::from(u8::from(i == j))).collect();
    let identity: Vec<Vec<f64>> = (0..n).map(unit).collect();
    direct_receptance(matrices, s, &identity, &identity).unwrap()
}

fn assert_receptance(matrices: &SystemMatrices) {
    let modes = damped_modes(matrices).unwrap();
    let n = matrices.coordinates.len();
    assert_eq!(modes.poles_rad_s.len(), n);
    for s in [
        (0.0, 0.0),
        (0.0, 300.0),
        (-5.0, 911.0),
        (20.0, 450.0),
        (0.0, 3000.0),
    ] {
        let s = Complex64::new(s.0, s.1);
        let expected = direct(matrices, s);
        let largest = (0..n).map(|i| expected[(i, i)].norm()).fold(0.0, f64::max);
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let term = |r: usize| {
                let lambda = modes.poles_rad_s[r];
                let a = modes.vectors[(i, r)] * modes.vectors[(j, r)];
                a / (s - lambda) + a.conj() / (s - lambda.conj())
            };
            let got: Complex64 = (0..n).map(term).sum();
            let error = (got - expected[(i, j)]).norm() / largest;
            assert!(error < 1e-10, "{i} {j} at {s}: {error:e}");
        }
    }
}

#[test]
fn the_poles_of_a_chain_with_one_damper_give_the_inverse_of_its_dynamic_stiffness() {
    let mut chain = uneven();
    chain.damping[(1, 1)] = 60.0;
    assert_receptance(&chain.matrices());
    let mut tied = uneven();
    for (i, j, sign) in [(2, 2, 1.0), (3, 3, 1.0), (2, 3, -1.0), (3, 2, -1.0)] {
        tied.damping[(i, j)] = sign * 90.0;
    }
    assert_receptance(&tied.matrices());
    let modes = damped_modes(&tied.matrices()).unwrap();
    assert!(
        modes
            .poles_rad_s
            .windows(2)
            .all(|p| p[0].norm() < p[1].norm())
    );
    assert!(modes.poles_rad_s.iter().all(|p| p.im > 0.0 && p.re < 0.0));
    // A discrete damper turns the phases: no common factor makes this shape real.
    let parts: Vec<Complex64> = (0..5).map(|i| modes.vectors[(i, 2)]).collect();
    assert!(crate::modal::modal_phase_collinearity(&parts).unwrap() < 0.9999);
}

#[test]
fn proportional_damping_gives_back_its_ratio() {
    let mut chain = uneven();
    let undamped = modes_of_matrices(&chain.matrices(), &ModeOptions::default()).unwrap();
    let (alpha, beta) = (3.0, 2e-5);
    let matrices = chain.matrices();
    chain.damping = real_matrix(5, 5, |i, j| {
        alpha * matrices.mass[(i, j)] + beta * matrices.stiffness[(i, j)]
    });
    let modes = damped_modes(&chain.matrices()).unwrap();
    for (lambda, omega) in modes.poles_rad_s.iter().zip(undamped.omega_rad_s) {
        let zeta = 0.5 * (alpha / omega + beta * omega);
        assert!((lambda.norm() / omega - 1.0).abs() < 1e-12);
        assert!((-lambda.re / lambda.norm() / zeta - 1.0).abs() < 1e-9);
    }
}

/// A ring of equal masses on equal springs, each also tied to ground: every root but the first and
/// last is double.
fn ring(n: usize) -> SystemMatrices {
    let line = Chain::new(&vec![1.5; n], &vec![2e5; n + 1]).matrices();
    let mut stiffness = line.stiffness;
    for i in 0..n {
        stiffness[(i, i)] += 1e5;
    }
    stiffness[(0, n - 1)] -= 2e5;
    stiffness[(n - 1, 0)] -= 2e5;
    let damping = real_matrix(n, n, |i, j| {
        4.0 * f64::from(u8::from(i == j)) + 1e-5 * stiffness[(i, j)]
    });
    SystemMatrices {
        stiffness,
        damping: Some(damping),
        ..line
    }
}

#[test]
fn repeated_roots_still_give_the_inverse_and_are_equal() {
    for n in [4, 7, 8] {
        let matrices = ring(n);
        assert_receptance(&matrices);
        let modes = damped_modes(&matrices).unwrap();
        let pairs = modes.groups.iter().flatten().count() / 2;
        assert_eq!(pairs, (n - 1) / 2, "{:?}", modes.groups);
        for j in 1..n {
            let same = modes.groups[j].is_some() && modes.groups[j] == modes.groups[j - 1];
            let gap = (modes.poles_rad_s[j] - modes.poles_rad_s[j - 1]).norm();
            assert_eq!(same, gap <= 0.0, "{j}");
        }
    }
}

#[test]
fn two_equal_oscillators_with_a_damper_each_are_one_double_root() {
    let mut chain = Chain::new(&[2.0, 2.0], &[8e4, 0.0, 8e4]);
    chain.damping = real_matrix(2, 2, |i, j| 12.0 * f64::from(u8::from(i == j)));
    assert_receptance(&chain.matrices());
    let modes = damped_modes(&chain.matrices()).unwrap();
    assert_eq!(modes.groups, [Some(1), Some(1)]);
}

#[test]
fn equal_roots_are_found_among_others_of_the_same_size() {
    // Four equal oscillators, not tied to one another: |lambda| is omega for all, and two dampers
    // are equal.
    let mut four = Chain::new(&[1.0; 4], &[0.0; 5]);
    let dampers = [12.0, 20.0, 12.0, 16.0];
    four.damping = real_matrix(4, 4, |i, j| if i == j { dampers[i] } else { 0.0 });
    let mut matrices = four.matrices();
    matrices.stiffness = real_matrix(4, 4, |i, j| if i == j { 1e4 } else { 0.0 });
    let modes = damped_modes(&matrices).unwrap();
    let repeated = modes.groups.iter().filter(|group| group.is_some()).count();
    assert_eq!(repeated, 2);
    assert_receptance(&matrices);
}

#[test]
fn free_overdamped_and_defective_models_are_errors() {
    let free = Chain::new(&[1.0, 1.0], &[0.0, 1e4, 0.0]);
    let error = damped_modes(&free.matrices()).unwrap_err();
    assert_eq!(error, TheoryError::RigidBody { got: 1 });

    let mut creeping = Chain::new(&[1.0], &[5e3, 5e3]);
    creeping.damping[(0, 0)] = 250.0;
    // s^2 + 250 s + 1e4 = (s + 50)(s + 200).
    match damped_modes(&creeping.matrices()).unwrap_err() {
        TheoryError::Overdamped { got_rad_s } => assert!((got_rad_s + 50.0).abs() < 1e-9),
        other => panic!("{other}"),
    }

    // (s^2 + 20 s + 10100)(s^2 + 10000) - 1000^2 = (s^2 + 10 s + 10000)^2: both pairs of roots
    // meet, in one shape.
    let mut meeting = Chain::new(&[1.0, 1.0], &[9.1e3, 1e3, 9e3]);
    meeting.damping[(0, 0)] = 20.0;
    let error = damped_modes(&meeting.matrices());
    assert!(
        matches!(error, Err(TheoryError::DefectiveRoot { .. })),
        "{error:?}"
    );
}
