//! Reductions against closed forms.

use crate::linalg::{RealMatrix, real_matrix};

use super::*;

/// A chain of unit masses on springs of these stiffnesses, the first and the last to ground.
fn chain(springs: &[f64]) -> SystemMatrices {
    let n = springs.len() - 1;
    let coordinate = |i: usize| Coordinate {
        name: format!("x{i}"),
        body: format!("m{i}"),
        motion: Motion::Translation,
        axis: [1.0, 0.0, 0.0],
        at_m: [0.0; 3],
    };
    SystemMatrices {
        mass: real_matrix(n, n, |i, j| f64::from(u8::from(i == j))),
        damping: Some(real_matrix(n, n, |i, j| {
            f64::from(u8::from(i == j)) * (1 + i) as f64
        })),
        stiffness: real_matrix(n, n, |i, j| match i.abs_diff(j) {
            0 => springs[i] + springs[i + 1],
            1 => -springs[i.max(j)],
            _ => 0.0,
        }),
        coordinates: (0..n).map(coordinate).collect(),
        springs: Vec::new(),
    }
}

fn solved(matrices: &SystemMatrices) -> TheoryModes {
    modes_of_matrices(matrices, &ModeOptions::default()).unwrap()
}

fn first(modes: &RealMatrix, count: usize) -> RealMatrix {
    real_matrix(modes.nrows(), count, |i, j| modes[(i, j)])
}

#[test]
fn a_mass_between_springs_follows_by_statics() {
    // x2 = k2/(k2 + k3) x1; its springs stand in series, its mass and damper count by the square.
    let reduced = guyan(&chain(&[1.0, 2.0, 6.0]), &[0]).unwrap();
    let follow = 0.25;
    let m = &reduced.matrices;
    assert!((reduced.expansion[(1, 0)] - follow).abs() < 1e-15);
    assert!((m.stiffness[(0, 0)] - (1.0 + 2.0 * 6.0 / 8.0)).abs() < 1e-14);
    assert!((m.mass[(0, 0)] - (1.0 + follow * follow)).abs() < 1e-15);
    assert!((m.damping.as_ref().unwrap()[(0, 0)] - (1.0 + 2.0 * follow * follow)).abs() < 1e-15);
    assert_eq!(m.coordinates[0].name, "x0");
}

#[test]
fn static_reduction_bounds_the_frequencies_from_above() {
    let full = chain(&[3.0, 1.0, 4.0, 1.0, 5.0, 9.0, 2.0]);
    let reduced = guyan(&full, &[4, 1]).unwrap();
    let (reduced_modes, exact) = (solved(&reduced.matrices), solved(&full));
    for (omega, exact) in reduced_modes.omega_rad_s.iter().zip(&exact.omega_rad_s) {
        assert!(omega > exact && *omega < 1.3 * exact, "{omega} {exact}");
    }
    // Kept whole, nothing changes.
    let whole = guyan(&full, &[0, 1, 2, 3, 4, 5]).unwrap();
    assert_eq!(whole.matrices.stiffness, full.stiffness);
}

#[test]
fn serep_keeps_the_modes_exactly_and_gives_them_back_from_readings() {
    let full = chain(&[3.0, 1.0, 4.0, 1.0, 5.0, 9.0, 2.0]);
    let exact = solved(&full);
    let modes = first(&exact.vectors, 3);
    let kept = [5, 0, 2];
    let reduced = serep(&full, &modes, &kept).unwrap();
    let reduced_modes = solved(&reduced.matrices);
    for (omega, exact) in reduced_modes.omega_rad_s.iter().zip(&exact.omega_rad_s) {
        assert!((omega / exact - 1.0).abs() < 1e-12, "{omega} {exact}");
    }
    let read = real_matrix(3, 3, |i, j| modes[(kept[i], j)]);
    let back = &reduced.expansion * &read;
    for (i, j) in (0..6).flat_map(|i| (0..3).map(move |j| (i, j))) {
        assert!((back[(i, j)] - modes[(i, j)]).abs() < 1e-13);
    }
    // More readings than modes: a sum of modes still comes back.
    let row = |at: usize| (0..6).map(|i| f64::from(u8::from(i == at))).collect();
    let rows: Vec<Vec<f64>> = [0, 2, 3, 5].map(row).to_vec();
    let expansion = serep_expansion(&modes, &rows).unwrap();
    let motion = |i: usize| 2.0 * modes[(i, 0)] - modes[(i, 2)];
    let read = real_matrix(4, 1, |i, _| motion([0, 2, 3, 5][i]));
    let back = &expansion * &read;
    (0..6).for_each(|i| assert!((back[(i, 0)] - motion(i)).abs() < 1e-13));
}

#[test]
fn unusable_coordinates_and_readings_are_reported() {
    let full = chain(&[1.0, 1.0, 1.0]);
    for kept in [&[] as &[usize], &[0, 0], &[2]] {
        let error = guyan(&full, kept).unwrap_err();
        assert!(matches!(
            error,
            TheoryError::KeptCoordinates { size: 2, .. }
        ));
    }
    // Without springs beyond the first mass the others are not held.
    let error = guyan(&chain(&[1.0, 0.0, 1.0, 0.0]), &[0]).unwrap_err();
    assert!(matches!(error, TheoryError::Linalg(_)), "{error}");
    let modes = solved(&full).vectors;
    let same = vec![vec![1.0, 0.0]; 2];
    let error = serep_expansion(&modes, &same).unwrap_err();
    assert!(matches!(
        error,
        TheoryError::IndistinctModes {
            modes: 2,
            readings: 2,
            ..
        }
    ));
    let error = serep_expansion(&modes, &same[..1]).unwrap_err();
    assert!(matches!(
        error,
        TheoryError::MatrixSize {
            got_rows: 1,
            expected: 2,
            ..
        }
    ));
}
