//! Sparse models of which few motions carry mass, and massless motions that stiffness does not
//! hold, against closed forms.

use super::condensation_tests::{Entries, errors, massless_beam, solve, sparse, spring, system};
use super::*;

const LENGTH_M: f64 = 0.9;
const BENDING_N_M2: f64 = 2.06e11 * 1.7e-9;

fn lowest(system: &SparseSystem, count: Option<usize>) -> Result<TheoryModes, TheoryError> {
    let options = ModeOptions {
        count,
        ..ModeOptions::default()
    };
    modes_of_sparse(system, &options)
}

/// Largest part of its value that rounding of the stiffness may change an omega² by, as stated;
/// 2e-6 where none is.
fn stated_rounding(modes: &TheoryModes) -> f64 {
    let findings = modes.model.findings.iter();
    let mut stated =
        findings.filter(|finding| finding.code == crate::finding::Code::StiffnessRounding);
    2.0 * stated
        .next()
        .and_then(|finding| finding.value)
        .unwrap_or(1e-6)
}

#[test]
fn one_mass_at_the_end_of_a_fine_mesh_has_its_closed_form() {
    // omega^2 = 3 EI/(m L^3) is 1e-9 of K_ii/M_ii with 800 elements.
    let expected = 3.0 * BENDING_N_M2 / (3.0 * LENGTH_M.powi(3));
    for elements in [100, 800] {
        let model = massless_beam(elements, [End::Clamped, End::Free], &[(LENGTH_M, 3.0)]);
        let solved = lowest(&sparse(&model.assemble(&[]).unwrap()), None).unwrap();
        assert_eq!((solved.rigid, solved.omega_rad_s.len()), (0, 1));
        let error = (solved.omega_rad_s[0].powi(2) / expected - 1.0).abs();
        assert!(error < stated_rounding(&solved), "{elements}: {error:e}");
    }
}

#[test]
fn a_free_fine_mesh_with_three_masses_has_two_rigid_modes_and_its_closed_form() {
    // Ends 2 kg each, middle 5 kg: 48 EI/L^3 between the middle and the ends.
    let masses = [(0.0, 2.0), (0.5 * LENGTH_M, 5.0), (LENGTH_M, 2.0)];
    let expected = 48.0 * BENDING_N_M2 / LENGTH_M.powi(3) * (1.0 / 5.0 + 1.0 / 4.0);
    for elements in [100, 800] {
        let model = massless_beam(elements, [End::Free, End::Free], &masses);
        let system = sparse(&model.assemble(&[]).unwrap());
        for count in [None, Some(1), Some(2), Some(3)] {
            let solved = lowest(&system, count).unwrap();
            let found = count.unwrap_or(3);
            assert_eq!(
                (solved.rigid, solved.omega_rad_s.len()),
                (found.min(2), found)
            );
            if found == 3 {
                let error = (solved.omega_rad_s[2].powi(2) / expected - 1.0).abs();
                assert!(error < stated_rounding(&solved), "{elements}: {error:e}");
            }
        }
    }
}

/// Masses of 1 kg, each on a stiff spring to a massless node that a soft spring of 1 to 2 N/m
/// holds.
fn soft_supports(masses: usize, stiff: f64) -> SystemMatrices {
    let mut stiffness = Entries::new();
    for i in 0..masses {
        stiffness.extend(spring(2 * i, 2 * i + 1, stiff));
        stiffness.push((2 * i + 1, 2 * i + 1, soft(i, masses)));
    }
    let mass = (0..masses).map(|i| (2 * i, 2 * i, 1.0)).collect();
    system(2 * masses, &mass, &stiffness)
}

fn soft(i: usize, masses: usize) -> f64 {
    1.0 + i as f64 / masses as f64
}

#[test]
fn modes_far_below_the_stiffness_of_their_coordinates_are_found() {
    // omega^2 is 1e-10 of K_ii/M_ii. Beyond `few_masses::MAX_MASSIVE_MOTIONS` the count of modes
    // ends in an error of its factor.
    for masses in [10, 200] {
        let solved = lowest(&sparse(&soft_supports(masses, 1e10)), Some(8)).unwrap();
        assert_eq!((solved.rigid, solved.omega_rad_s.len()), (0, 8));
        for (i, omega) in solved.omega_rad_s.iter().enumerate() {
            let error = omega.powi(2) / soft(i, masses) - 1.0;
            assert!(
                error.abs() < stated_rounding(&solved),
                "{masses} {i}: {error:e}"
            );
        }
    }
}

#[test]
fn a_band_of_a_model_with_few_masses_holds_the_modes_below_its_end() {
    let system = sparse(&soft_supports(20, 1e4));
    let exact: Vec<f64> = solve(&soft_supports(20, 1e4)).omega_rad_s;
    let hi_hz = 0.5 * (exact[6] + exact[7]) / std::f64::consts::TAU;
    let options = ModeOptions {
        band: Some(crate::axis::Band::new(0.0, hi_hz).unwrap()),
        ..ModeOptions::default()
    };
    let solved = modes_of_sparse(&system, &options).unwrap();
    assert_eq!(solved.omega_rad_s.len(), 7);
    for (a, b) in solved.omega_rad_s.iter().zip(&exact) {
        assert!((a / b - 1.0).abs() < 1e-10, "{a} {b}");
    }
}

#[test]
fn negative_springs_on_massless_coordinates_are_named() {
    // Mass, 100 N/m, node with -300 N/m to ground, 100 N/m, mass; a chain of massless nodes beside
    // it is at rest.
    let mut stiffness: Entries = spring(0, 1, 100.0).to_vec();
    stiffness.extend(spring(1, 2, 100.0));
    stiffness.push((1, 1, -300.0));
    stiffness.extend(spring(2, 3, 7.0));
    stiffness.extend((3..40).flat_map(|i| spring(i, i + 1, 1.0 + i as f64)));
    for error in errors(&system(41, &vec![(0, 0, 1.0), (2, 2, 1.0)], &stiffness)) {
        let TheoryError::Mass(MassError::Unstable {
            coordinates,
            motions,
        }) = &error
        else {
            panic!("{error}");
        };
        assert_eq!(
            (*motions, coordinates.as_slice()),
            (1, ["2:+X".to_owned()].as_slice())
        );
        let text = error.to_string();
        let start =
            "got 1 motions without mass and with negative stiffness, of the coordinates `2:+X`";
        assert!(text.starts_with(start), "{text}");
    }
    // Less than the other springs of the node: the motion is held, with 100 + 100 - 150 N/m.
    stiffness[8] = (1, 1, -150.0);
    // K_c = [100 - 200, -200; -200, 100 - 200] is not stable: the modes say so, not the massless
    // node.
    for error in errors(&system(41, &vec![(0, 0, 1.0), (2, 2, 1.0)], &stiffness)) {
        assert!(
            matches!(error, TheoryError::NegativeStiffness { .. }),
            "{error}"
        );
    }
}

/// `omega` of point masses on a clamped beam without mass, from the compliance `x^2 (3 y - x)/(6
/// EI)` at y of a force at `x < y`.
fn exact_clamped(masses: &[(f64, f64)]) -> Vec<f64> {
    let compliance = |i: usize, j: usize| {
        let (x, y) = (masses[i].0.min(masses[j].0), masses[i].0.max(masses[j].0));
        x * x * (3.0 * y - x) / (6.0 * BENDING_N_M2) * (masses[i].1 * masses[j].1).sqrt()
    };
    let n = masses.len();
    let values = crate::linalg::symmetric_eigen(&crate::linalg::real_matrix(n, n, compliance));
    let values = values.unwrap().values;
    values.iter().rev().map(|value| value.powf(-0.5)).collect()
}

#[test]
fn masses_off_their_nodes_by_rounding_have_the_modes_of_masses_there() {
    // Twelve masses on a clamped beam of 120 elements, on the nodes and beside them: the mass
    // of a neighbouring coordinate is the sixth power of the offset.
    for off_m in [
        0.0, 1e-16, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1e-5, 1e-4, 1e-3,
    ] {
        let at = |i: usize| (LENGTH_M / 12.0 * i as f64 - off_m, 0.1 * i as f64);
        let masses: Vec<(f64, f64)> = (1..=12).map(at).collect();
        let exact = exact_clamped(&masses);
        let model = massless_beam(120, [End::Clamped, End::Free], &masses);
        let matrices = model.assemble(&[]).unwrap();
        for solved in [solve(&matrices), lowest(&sparse(&matrices), None).unwrap()] {
            assert_eq!(solved.omega_rad_s.len(), 12, "{off_m:e}");
            for (a, b) in solved.omega_rad_s.iter().zip(&exact).take(4) {
                assert!((a / b - 1.0).abs() < 1e-6, "{off_m:e}: {a} {b}");
            }
        }
    }
}

#[test]
fn a_small_mass_beside_a_large_one_within_one_element_is_kept() {
    // 1 kg at the end and 1e-9 kg at the middle of the last of two elements: rows and columns of
    // one block, of rank 2.
    let masses = [(0.5 * LENGTH_M + 0.2, 1e-9), (LENGTH_M, 1.0)];
    let model = massless_beam(2, [End::Clamped, End::Free], &masses);
    let matrices = model.assemble(&[]).unwrap();
    let heavy = exact_clamped(&masses)[0];
    let solved = solve(&matrices);
    assert_eq!(solved.omega_rad_s.len(), 2);
    assert!((solved.omega_rad_s[0] / heavy - 1.0).abs() < 1e-6);
}
