//! Static condensation of coordinates without mass against closed forms, dense and sparse, and its
//! errors.

use crate::finding::Code;
use crate::linalg::{SparseMatrix, real_matrix, solve_definite};

use super::beam_modes_tests::{at, bar};
use super::massless::without_zeros;
use super::*;

pub(super) type Entries = Vec<(usize, usize, f64)>;

/// Matrices of coordinates `1:+X`, `2:+X`, ... from their entries.
pub(super) fn system(size: usize, mass: &Entries, stiffness: &Entries) -> SystemMatrices {
    let dense = |entries: &Entries| {
        SparseMatrix::from_entries(size, entries)
            .unwrap()
            .to_dense()
    };
    let coordinate = |i: usize| Coordinate {
        name: format!("{}:+X", i + 1),
        body: format!("{}", i + 1),
        motion: Motion::Translation,
        axis: [1.0, 0.0, 0.0],
        at_m: [0.0; 3],
    };
    SystemMatrices {
        mass: dense(mass),
        damping: None,
        stiffness: dense(stiffness),
        coordinates: (0..size).map(coordinate).collect(),
        springs: Vec::new(),
    }
}

/// A spring between two coordinates.
pub(super) fn spring(a: usize, b: usize, k: f64) -> [(usize, usize, f64); 4] {
    [(a, a, k), (b, b, k), (a, b, -k), (b, a, -k)]
}

pub(super) fn sparse(matrices: &SystemMatrices) -> SparseSystem {
    SparseSystem {
        mass: without_zeros(&matrices.mass).unwrap(),
        damping: matrices.damping.as_ref().map(|c| without_zeros(c).unwrap()),
        stiffness: without_zeros(&matrices.stiffness).unwrap(),
        coordinates: matrices.coordinates.clone(),
    }
}

pub(super) fn solve(matrices: &SystemMatrices) -> TheoryModes {
    modes_of_matrices(matrices, &ModeOptions::default()).unwrap()
}

/// Modes of full and of sparse matrices.
pub(super) fn both(matrices: &SystemMatrices, count: usize) -> [TheoryModes; 2] {
    let options = ModeOptions {
        count: Some(count),
        ..ModeOptions::default()
    };
    [
        modes_of_matrices(matrices, &options).unwrap(),
        modes_of_sparse(&sparse(matrices), &options).unwrap(),
    ]
}

pub(super) fn errors(matrices: &SystemMatrices) -> [TheoryError; 2] {
    let options = ModeOptions::default();
    [
        modes_of_matrices(matrices, &options).unwrap_err(),
        modes_of_sparse(&sparse(matrices), &options).unwrap_err(),
    ]
}

/// Masses of 3 kg with a massless node before each of them: springs of 4e5 N/m into the node and
/// 1e5 N/m out of it, between walls or free at both ends (then from the first mass to the last).
pub(super) const MASS: f64 = 3.0;
pub(super) const SPRINGS: [f64; 2] = [4e5, 1e5];

fn series() -> f64 {
    SPRINGS[0] * SPRINGS[1] / (SPRINGS[0] + SPRINGS[1])
}

pub(super) fn alternating(masses: usize, free: bool) -> SystemMatrices {
    let size = if free { 2 * masses - 1 } else { 2 * masses + 1 };
    let first = usize::from(!free);
    let mass = (0..masses).map(|i| (first + 2 * i, first + 2 * i, MASS));
    let between = (1..size).flat_map(|i| spring(i - 1, i, SPRINGS[(i + 1 - first) % 2]));
    let mut stiffness: Entries = between.collect();
    if !free {
        stiffness.extend([(0, 0, SPRINGS[0]), (size - 1, size - 1, SPRINGS[1])]);
    }
    system(size, &mass.collect(), &stiffness)
}

#[test]
fn a_mass_behind_two_springs_in_series_has_their_series_stiffness() {
    // Ground, 200 N/m, massless node, 300 N/m, 5 kg.
    let mut stiffness: Entries = spring(0, 1, 300.0).to_vec();
    stiffness.push((0, 0, 200.0));
    let matrices = system(2, &vec![(1, 1, 5.0)], &stiffness);
    for solved in both(&matrices, 2) {
        assert_eq!(solved.omega_rad_s.len(), 1);
        assert!((solved.omega_rad_s[0].powi(2) / (120.0 / 5.0) - 1.0).abs() < 1e-14);
        let (node, mass) = (solved.vectors[(0, 0)], solved.vectors[(1, 0)]);
        assert!((mass - 0.2f64.sqrt()).abs() < 1e-14);
        assert!((node / mass - 300.0 / 500.0).abs() < 1e-14, "{node} {mass}");
        assert_eq!(solved.kinetic_shares[(0, 0)].abs().to_bits(), 0);
        let said: Vec<_> = solved.model.findings.iter().collect();
        let condensed = said
            .iter()
            .find(|finding| finding.code == Code::MasslessCondensed);
        let condensed = condensed.unwrap();
        assert_eq!(condensed.value, Some(1.0));
        assert!(
            condensed.to_string().contains("1 of 2 coordinates"),
            "{condensed}"
        );
    }
}

#[test]
fn a_chain_of_alternate_massless_nodes_is_the_chain_of_its_series_springs() {
    let masses = 60;
    let matrices = alternating(masses, false);
    for solved in both(&matrices, 40) {
        assert!(solved.omega_rad_s.len() >= 40);
        for (j, omega) in solved.omega_rad_s.iter().enumerate() {
            let angle = 0.5 * std::f64::consts::PI * (j + 1) as f64 / (masses + 1) as f64;
            let exact = 2.0 * (series() / MASS).sqrt() * angle.sin();
            assert!((omega / exact - 1.0).abs() < 1e-12, "{j}: {omega} {exact}");
        }
        // A massless node divides the stretch of its two springs as their compliances: u_o = (k1
        // u_1 + k2 u_2)/(k1 + k2).
        for (node, j) in (1..masses).flat_map(|i| [(2 * i, 0), (2 * i, 7), (2 * i, 39)]) {
            let phi = |i: usize| solved.vectors[(i, j)];
            let weighed = SPRINGS[0] * phi(node - 1) + SPRINGS[1] * phi(node + 1);
            let expected = weighed / (SPRINGS[0] + SPRINGS[1]);
            assert!((phi(node) - expected).abs() < 1e-9, "{node} {j}");
        }
    }
    assert_eq!(solve(&matrices).omega_rad_s.len(), masses);
}

#[test]
fn all_finite_modes_of_a_small_sparse_model_are_found() {
    for free in [true, false] {
        let matrices = alternating(7, free);
        let full = solve(&matrices);
        let found = modes_of_sparse(&sparse(&matrices), &ModeOptions::default()).unwrap();
        assert_eq!(found.omega_rad_s.len(), 7);
        assert_eq!(found.rigid, usize::from(free));
        for (a, b) in full.omega_rad_s.iter().zip(&found.omega_rad_s) {
            assert!((a - b).abs() <= 1e-12 * b, "{a} {b}");
        }
    }
}

#[test]
fn a_free_chain_with_massless_nodes_has_a_rigid_body_mode_at_exactly_zero() {
    let masses = 30;
    let matrices = alternating(masses, true);
    for solved in both(&matrices, 20) {
        assert_eq!((solved.rigid, solved.omega_rad_s[0].to_bits()), (1, 0));
        for i in 0..2 * masses - 1 {
            let uniform = (MASS * masses as f64).sqrt().recip();
            assert!((solved.vectors[(i, 0)] - uniform).abs() < 1e-9);
        }
        for (j, omega) in solved.omega_rad_s.iter().enumerate().skip(1) {
            let angle = 0.5 * std::f64::consts::PI * j as f64 / masses as f64;
            let exact = 2.0 * (series() / MASS).sqrt() * angle.sin();
            assert!((omega / exact - 1.0).abs() < 1e-12, "{j}: {omega} {exact}");
        }
    }
}

/// A massless beam of `elements` with point masses at some places along it.
pub(super) fn massless_beam(elements: usize, ends: [End; 2], masses: &[(f64, f64)]) -> BeamModel {
    let mut file = bar(elements, ends[0], ends[1]);
    file.beams[0].density_kg_per_m3 = Value::Number(0.0);
    for (number, (x_m, kg)) in masses.iter().enumerate() {
        file.point_masses.push(PointMassDescription {
            name: format!("mass {number}"),
            beam: "bar".to_owned(),
            at_m: at(*x_m),
            mass_kg: Value::Number(*kg),
            rotary_inertia_kg_m2: None,
        });
    }
    BeamModel::new(file).unwrap()
}

#[test]
fn a_free_massless_beam_with_three_masses_has_two_rigid_modes_and_its_closed_form() {
    // Ends 2 kg each, middle 5 kg: 48 EI/L^3 between the middle and the ends.
    let model = massless_beam(
        6,
        [End::Free, End::Free],
        &[(0.0, 2.0), (0.45, 5.0), (0.9, 2.0)],
    );
    let matrices = model.assemble(&[]).unwrap();
    let expected = 48.0 * 2.06e11 * 1.7e-9 / 0.9f64.powi(3) * (1.0 / 5.0 + 1.0 / 4.0);
    for solved in both(&matrices, 5) {
        assert_eq!((solved.rigid, solved.omega_rad_s.len()), (2, 3));
        let found = solved.omega_rad_s[2].powi(2);
        assert!((found / expected - 1.0).abs() < 1e-11, "{found} {expected}");
    }
}

#[test]
fn a_mass_between_the_nodes_of_a_massless_beam_is_condensed_in_the_axes_of_its_null_space() {
    let (x_m, kg) = (0.52, 4.0);
    let model = massless_beam(5, [End::Clamped, End::Free], &[(x_m, kg)]);
    let matrices = model.assemble(&[]).unwrap();
    let target = crate::geometry::Target::BodyPoint {
        body: "bar".to_owned(),
        at_m: at(x_m),
        direction: [0.0, 0.0, 1.0],
    };
    let row = model.observation_row(&[], &target).unwrap();
    let force = real_matrix(row.len(), 1, |i, _| row[i]);
    let deflection = solve_definite(&matrices.stiffness, &force).unwrap();
    let compliance: f64 = row
        .iter()
        .enumerate()
        .map(|(i, b)| b * deflection[(i, 0)])
        .sum();
    for solved in both(&matrices, 3) {
        assert_eq!(solved.omega_rad_s.len(), 1);
        let found = solved.omega_rad_s[0].powi(2);
        assert!((found * kg * compliance - 1.0).abs() < 1e-10, "{found}");
        // The shape is the static deflection under the inertia force.
        let scale = (kg.sqrt() * compliance).recip();
        for i in 0..row.len() {
            let expected = scale * deflection[(i, 0)];
            let largest = scale * deflection[(row.len() - 2, 0)].abs();
            assert!(
                (solved.vectors[(i, 0)] - expected).abs() < 1e-9 * largest,
                "{i}"
            );
        }
        assert_eq!(solved.model.findings.last().unwrap().value, Some(9.0));
    }
}

#[test]
fn a_mass_off_its_node_without_rotary_inertia_is_condensed_in_the_axes_of_its_null_space() {
    // A mass on an arm r: M = m [[1, r], [r, r^2]] over deflection and rotation, springs at both:
    // the spring at the node k, the rotational one q, in series over the arm: 1/k_e = 1/k + r^2/q.
    // Arms at which r * r rounds.
    for r in [0.1, 0.3, 0.7, 1.0 / 3.0, 1e-3, 17.3] {
        let (m, k, q) = (2.7, 5e4, 80.0);
        let mass = vec![(0, 0, m), (0, 1, m * r), (1, 0, m * r), (1, 1, m * r * r)];
        let matrices = system(2, &mass, &vec![(0, 0, k), (1, 1, q)]);
        let expected = 1.0 / (m * (1.0 / k + r * r / q));
        for solved in both(&matrices, 2) {
            assert_eq!(solved.omega_rad_s.len(), 1, "{r}");
            assert!(
                (solved.omega_rad_s[0].powi(2) / expected - 1.0).abs() < 1e-12,
                "{r}"
            );
        }
    }
}

#[test]
fn a_body_of_the_model_file_may_lack_mass_or_inertia() {
    let text = |mass: &str, inertia: &str| {
        format!(
            r#"
        [[body]]
        name = "joint"
        at_m = [0.0, 0.0, 0.0]
        mass_kg = {mass}
        inertia_kg_m2 = {inertia}
        free = ["y", "rz"]
        [[body]]
        name = "block"
        at_m = [1.0, 0.0, 0.0]
        mass_kg = 2.0
        free = ["y"]
        [[point]]
        name = "arm"
        body = "joint"
        at_m = [0.5, 0.0, 0.0]
        [[point]]
        name = "centre"
        body = "joint"
        at_m = [0.0, 0.0, 0.0]
        [[point]]
        name = "block"
        body = "block"
        at_m = [1.0, 0.0, 0.0]
        [[spring]]
        name = "support"
        from = "centre"
        to = "ground"
        direction = [0.0, 1.0, 0.0]
        stiffness_n_per_m = 1000.0
        [[spring]]
        name = "hinge"
        from = "centre"
        to = "ground"
        direction = [0.0, 0.0, 1.0]
        stiffness_nm_per_rad = 50.0
        [[spring]]
        name = "link"
        from = "arm"
        to = "block"
        direction = [0.0, 1.0, 0.0]
        stiffness_n_per_m = 400.0
    "#
        )
    };
    let model = |text: String| LumpedModel::new(toml::from_str::<LumpedFile>(&text).unwrap());
    let model_with_mass = model(text("0.0", "0.0")).unwrap();
    let solved = modes(&model_with_mass, &[], &[], &ModeOptions::default()).unwrap();
    // Compliances in series: 1/1000 + 0.5^2/50 + 1/400.
    let expected = 1.0 / (2.0 * (1e-3 + 0.25 / 50.0 + 2.5e-3));
    assert_eq!(solved.omega_rad_s.len(), 1);
    assert!((solved.omega_rad_s[0].powi(2) / expected - 1.0).abs() < 1e-13);
    // Energy in series is as compliance; the block alone moves mass.
    let root = &model_roots(&model_with_mass, &solved)[0];
    for ((name, share), compliance) in root.strain_energy.iter().zip([1e-3, 5e-3, 2.5e-3]) {
        assert!(
            (share - compliance / 8.5e-3).abs() < 1e-13,
            "{name} {share}"
        );
    }
    assert_eq!(root.kinetic_energy[0].1.abs().to_bits(), 0);
    assert!((root.kinetic_energy[1].1 - 1.0).abs() < 1e-14);
    assert!(model(text("-1.0", "0.0")).is_err());
}

#[test]
fn unsupported_massless_coordinates_are_reported() {
    // Coordinate 3 has no stiffness; 4 and 5 hold each other alone.
    let mut stiffness: Entries = vec![(0, 0, 100.0)];
    stiffness.extend(spring(0, 1, 50.0));
    stiffness.extend(spring(3, 4, 7.0));
    for error in errors(&system(5, &vec![(0, 0, 1.0)], &stiffness)) {
        let TheoryError::Mass(MassError::Free {
            coordinates,
            motions,
        }) = &error
        else {
            panic!("{error}");
        };
        assert_eq!(*motions, 2);
        assert_eq!(coordinates, &["3:+X", "4:+X", "5:+X"]);
        assert!(
            error.to_string().starts_with(
                "got 2 motions without mass and without stiffness, of the coordinates `3:+X`"
            ),
            "{error}"
        );
    }
}

#[test]
fn a_mechanism_of_many_massless_nodes_is_seen_at_any_size_and_scale() {
    // A free chain of massless nodes beside a held mass, with springs of a wide range, and the same
    // chain held softly.
    for (nodes, unit) in [(3, 1.0), (40, 1e-9), (300, 1e12)] {
        let k = |i: usize| unit * 10f64.powi((i * 7 % 6) as i32) * (1.0 + 0.37 * i as f64);
        let between = (1..nodes).flat_map(|i| spring(i, i + 1, k(i)));
        let mut stiffness: Entries = vec![(0, 0, unit)];
        stiffness.extend(between);
        let mass = vec![(0, 0, 2.0)];
        for error in errors(&system(nodes + 1, &mass, &stiffness)) {
            let TheoryError::Mass(MassError::Free {
                coordinates,
                motions,
            }) = &error
            else {
                panic!("{nodes}: {error}");
            };
            assert_eq!((*motions, coordinates.len()), (1, nodes));
        }
        stiffness.extend(spring(0, nodes, 1e-3 * unit));
        let solved = solve(&system(nodes + 1, &mass, &stiffness));
        // Nothing pulls at the far end of the chain: it follows the mass, but for the rounding of
        // its stiff springs.
        let found = solved.omega_rad_s[0].powi(2);
        assert!((found / (0.5 * unit) - 1.0).abs() < 1e-5, "{nodes} {found}");
    }
}

#[test]
fn a_long_massless_beam_is_no_mechanism() {
    let model = massless_beam(300, [End::Clamped, End::Free], &[(0.9, 3.0)]);
    let solved = solve(&model.assemble(&[]).unwrap());
    let expected = 3.0 * 2.06e11 * 1.7e-9 / 0.9f64.powi(3) / 3.0;
    let found = solved.omega_rad_s[0].powi(2);
    // Rounding of the stiffness: eps times the fourth power of the number of elements.
    assert!((found / expected - 1.0).abs() < 1e-5, "{found} {expected}");
}

#[test]
fn a_mass_matrix_that_is_not_semidefinite_is_named() {
    let stiffness: Entries = (0..3).map(|i| (i, i, 100.0)).collect();
    let named = |mass: Entries| errors(&system(3, &mass, &stiffness));
    for error in named(vec![(0, 0, 1.0), (0, 1, 0.2), (1, 0, 0.2), (2, 2, 1.0)]) {
        assert!(
            matches!(&error, TheoryError::Mass(MassError::Indefinite { row, column, diagonal, .. })
                if row == "2:+X" && column == "1:+X" && diagonal.abs() == 0.0),
            "{error}"
        );
    }
    for error in named(vec![(0, 0, 1.0), (1, 1, -0.2)]) {
        let text = error.to_string();
        assert!(
            text.contains("got -0.2 at row `2:+X`, column `2:+X`"),
            "{text}"
        );
    }
    for error in named(vec![(0, 0, 1.0), (0, 1, 2.0), (1, 0, 2.0), (1, 1, 3.0)]) {
        assert!(
            matches!(&error, TheoryError::Mass(MassError::Negative { coordinates, .. })
                if coordinates == &["1:+X", "2:+X"]),
            "{error}"
        );
    }
    for error in named(Vec::new()) {
        assert_eq!(error, TheoryError::Mass(MassError::AllMassless { size: 3 }));
    }
    // The smallest number above 0, and masses on either side of the limit beside 4 kg, 6e-154 kg.
    for tiny in [5e-324, 5e-154] {
        for error in named(vec![(0, 0, 4.0), (1, 1, tiny), (2, 2, 1.0)]) {
            assert!(
                matches!(&error, TheoryError::Mass(MassError::Vanishing { coordinate, .. })
                    if coordinate == "2:+X"),
                "{error}"
            );
        }
    }
    let light = vec![(0, 0, 4.0), (1, 1, 7e-154), (2, 2, 1.0)];
    let omega = solve(&system(3, &light, &stiffness)).omega_rad_s;
    assert_eq!(omega.len(), 3);
    for (got, exact) in omega.iter().zip([5.0, 10.0]) {
        assert!((got / exact - 1.0).abs() < 1e-12, "{got}");
    }
}
