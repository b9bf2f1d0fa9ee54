//! Modes of pairs whose omega² span more decades than one shift separates.

use super::*;

type Entries = Vec<(usize, usize, f64)>;

/// Springs of a chain between two walls, one more than coordinates.
fn chain(springs: &[f64]) -> Entries {
    let n = springs.len() - 1;
    let diagonal = (0..n).map(|i| (i, i, springs[i] + springs[i + 1]));
    let beside = (1..n).flat_map(|i| [(i, i - 1, -springs[i]), (i - 1, i, -springs[i])]);
    diagonal.chain(beside).collect()
}

/// Square of the second difference on `n` points, supported at the far end.
fn bending(n: usize) -> Entries {
    let value = |i: usize, j: usize| match i.abs_diff(j) {
        0 => 6.0,
        1 => -4.0,
        2 => 1.0,
        _ => 0.0,
    };
    let pairs = (0..n).flat_map(|i| (i.saturating_sub(2)..(i + 3).min(n)).map(move |j| (i, j)));
    pairs.map(|(i, j)| (i, j, value(i, j))).collect()
}

fn matrices(stiffness: &Entries, masses: &[f64]) -> [SparseMatrix; 2] {
    let n = masses.len();
    let mass: Entries = (0..n).map(|i| (i, i, masses[i])).collect();
    [stiffness, &mass].map(|entries| SparseMatrix::from_entries(n, entries).unwrap())
}

/// The lowest omega² of full and of sparse matrices.
fn lowest(stiffness: &Entries, masses: &[f64], count: usize) -> [Vec<f64>; 2] {
    let [k, m] = matrices(stiffness, masses);
    let dense = symmetric_modes(&k.to_dense(), &m.to_dense()).unwrap();
    let sparse = sparse_modes(&k, &m, Wanted::Lowest(count), masses.len()).unwrap();
    [dense.omega_squared, sparse.omega_squared].map(|values| values[..count].to_vec())
}

fn assert_equal(got: &[f64], exact: &[f64], tolerance: f64, what: &str) {
    for (j, (got, exact)) in got.iter().zip(exact).enumerate() {
        assert!(
            (got / exact - 1.0).abs() < tolerance,
            "{what}: {j}: {got} for {exact}"
        );
    }
}

#[test]
fn modes_beside_tiny_masses_are_those_without_them() {
    let (n, light) = (25, 12);
    let mut springs = vec![1e5; n];
    springs[light] = 0.5e5;
    // The light mass follows its neighbours: its two springs are one of half the stiffness.
    let condensed = lowest(&chain(&springs), &vec![1.0; n - 1], 20);
    for tiny in [1e-14, 1e-20, 1e-24, 1e-30, 1e-80, 1e-150] {
        let mut masses = vec![1.0; n];
        masses[light] = tiny;
        for got in lowest(&chain(&vec![1e5; n + 1]), &masses, 20) {
            assert_equal(&got, &condensed[0], 1e-11, &format!("{tiny:e} kg"));
        }
    }
}

#[test]
fn modes_beside_rigid_springs_are_those_of_fixed_coordinates() {
    let n = 60;
    let fixed = lowest(&bending(n - 1), &vec![1.0; n - 1], 10);
    for rigid in [1e14, 1e16, 1e18, 1e20, 1e26] {
        let mut stiffness = bending(n);
        stiffness.push((0, 0, rigid));
        for got in lowest(&stiffness, &vec![1.0; n], 10) {
            assert_equal(&got, &fixed[0], 1e-9, &format!("{rigid:e} N/m"));
        }
    }
}

#[test]
fn modes_of_masses_over_many_decades_are_all_separated() {
    let n = 8;
    let mass = |i: usize| 10f64.powi(-6 * i as i32);
    let masses: Vec<f64> = (0..n).map(mass).collect();
    // Heavier masses stand still, lighter ones follow by statics.
    let exact = |i: usize| (1.0 + 1.0 / (n - i) as f64) / mass(i);
    let exact: Vec<f64> = (0..n).map(exact).collect();
    let stiffness = chain(&vec![1.0; n + 1]);
    let [k, m] = matrices(&stiffness, &masses);
    let all = symmetric_modes(&k.to_dense(), &m.to_dense()).unwrap();
    assert_equal(&all.omega_squared, &exact, 1e-5, "1e-6 of the mass before");
    for got in lowest(&stiffness, &masses, 2) {
        assert_equal(&got, &exact, 1e-5, "1e-6 of the mass before");
    }
    // Block Lanczos has one shift at a time: an error, or right.
    if let Ok(sparse) = sparse_modes(&k, &m, Wanted::Lowest(n), n) {
        assert_equal(&sparse.omega_squared, &exact, 1e-5, "sparse");
    }
}

/// Omega² of a free chain of equal masses and springs, `4 k/m sin²(j pi/2n)`, from the first
/// elastic mode.
fn of_free_chain(n: usize, stiffness: f64) -> Vec<f64> {
    let angle = |j: usize| 0.5 * std::f64::consts::PI * j as f64 / n as f64;
    (1..n)
        .map(|j| 4.0 * stiffness * angle(j).sin().powi(2))
        .collect()
}

#[test]
fn rigid_body_modes_beside_a_tiny_mass_pass_their_checks() {
    for n in [5, 40, 150] {
        for tiny in [1e-14, 1e-20, 1e-40, 1e-150] {
            // A tiny mass on the last one: it moves with it.
            let mut springs = vec![1e5; n + 2];
            (springs[0], springs[n + 1]) = (0.0, 0.0);
            let mut masses = vec![1.0; n + 1];
            masses[n] = tiny;
            let [dense, sparse] = lowest(&chain(&springs), &masses, 4);
            let exact = of_free_chain(n, 1e5);
            for got in [dense, sparse] {
                assert_equal(&got[1..], &exact, 1e-9, &format!("{n} masses, {tiny:e} kg"));
            }
        }
    }
}

#[test]
fn softly_supported_chains_are_exact() {
    for n in [10, 60, 200] {
        for support in [1e-4, 1e-6] {
            let mut springs = vec![1e5; n + 1];
            (springs[0], springs[n]) = (support, 0.0);
            let exact = of_free_chain(n, 1e5);
            for got in lowest(&chain(&springs), &vec![1.0; n], 8) {
                // The chain moves as one body, but for the support over the springs; rounding of K
                // is 1.5e-11 N/m.
                let tolerance = 1e-6 + 1.5e-11 / support;
                let what = format!("{n} masses, {support:e} N/m");
                assert_equal(&got[..1], &[support / n as f64], tolerance, &what);
                assert_equal(&got[1..], &exact, 1e-6, &what);
            }
        }
    }
}
