//! The helical planetary gear with the 82 teeth in the ring that the paper prints, against the
//! reference: its natural frequencies by the energies of its motion, which know the ring's
//! radius, and its steady response.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::helical_mesh::Detail;
use super::helical_motion::{COORDINATES, Motion};
use super::helical_response::{printed_teeth_quantities, run};
use super::helical_response_tests::{ANGLES, near, nominal_motion};
use crate::linalg::{RealMatrix, real_matrix, symmetric_modes};
use crate::theory::parameter::{nominal_values, override_values};
use crate::theory::response::{ResponseSignal, ResponseSpan};
use crate::theory::{DetailResponse, HelicalPlanetary, TheoreticalModel};

/// Second derivatives of one of the energies by some entries of the state, at rest.
fn hessian(motion: &Motion, energy: usize, (first, step): (usize, f64)) -> RealMatrix {
    let at = |i: usize, j: usize, signs: [f64; 2]| {
        let mut state = vec![0.0; 2 * COORDINATES];
        state[first + i] += signs[0] * step;
        state[first + j] += signs[1] * step;
        motion.energy(0.0, &state)[energy]
    };
    real_matrix(COORDINATES, COORDINATES, |i, j| {
        let pairs = [[1.0, 1.0], [-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0]];
        let [a, b, c, d] = pairs.map(|signs| at(i, j, signs));
        (a + b - c - d) / (4.0 * step * step)
    })
}

/// Natural frequencies, Hz.
fn frequencies(motion: &Motion) -> Vec<f64> {
    // The carrier's rotation turns the meshes, so that steps are small; in the rates the energy is
    // quadratic.
    let stiffness = hessian(motion, 1, (0, 1e-5));
    let mass = hessian(motion, 0, (COORDINATES, 1.0));
    let modes = symmetric_modes(&stiffness, &mass).unwrap();
    let squares = modes.omega_squared.iter();
    squares.map(|square| square.max(0.0).sqrt() / TAU).collect()
}

#[test]
fn natural_frequencies_by_the_energies_are_the_reference_with_83_and_with_82_teeth() {
    let model = HelicalPlanetary::new("kb-1.5e8").unwrap();
    let changes = [("mesh_min", 4e8), ("mesh_max", 4e8)];
    let changes = changes.map(|(name, value)| (name.to_owned(), value));
    let values = override_values("gear", model.parameters(), &changes.into()).unwrap();
    let of = |detail| Motion::new(&model, &values, detail).unwrap();
    let mut turned = of(Detail::ExactAngle).with_ring_teeth(82.0);
    turned.detail = Detail::ConstantAngle;
    let tables = [
        (
            of(Detail::ConstantAngle),
            [
                0.0,
                779.455615,
                779.455615,
                1505.359242,
                1507.206365,
                1599.882536,
                1599.882536,
                1971.899527,
                2094.582783,
                2094.582783,
                3742.408653,
                4201.687093,
                4201.687093,
                4254.469399,
                4781.812398,
                6877.380953,
                6877.380953,
                10410.218501,
            ],
        ),
        (
            turned,
            [
                0.0,
                775.903838,
                775.903838,
                1489.553429,
                1499.435567,
                1596.486994,
                1596.486994,
                1984.774652,
                2094.935172,
                2094.935172,
                3713.673376,
                4194.671386,
                4194.671386,
                4250.916874,
                4806.594053,
                6882.744839,
                6882.744839,
                10411.496491,
            ],
        ),
        (
            of(Detail::ConstantAngle).with_ring_teeth(82.0),
            [
                0.0,
                779.455615,
                779.455615,
                1503.971243,
                1507.206365,
                1599.882536,
                1599.882536,
                1961.837010,
                2094.582783,
                2094.582783,
                3742.408653,
                4201.687093,
                4201.687093,
                4259.919494,
                4781.812398,
                6877.380953,
                6877.380953,
                10410.203343,
            ],
        ),
    ];
    for (motion, expected) in tables {
        let found = frequencies(&motion);
        assert!(found[0] < 1.0, "{found:?}");
        for (got, hz) in found[1..].iter().zip(&expected[1..]) {
            assert!((got / hz - 1.0).abs() < 1e-7, "{got} {hz}");
        }
    }
}

#[test]
fn the_steady_response_with_82_teeth_is_the_reference_and_the_suns_motion_comes_from_the_angle_at_rest()
 {
    let model = HelicalPlanetary::new("kb-1.5e8").unwrap();
    let of = |detail| nominal_motion(&model, detail).with_ring_teeth(82.0);
    let mut turned = of(Detail::ExactAngle);
    turned.detail = Detail::ConstantAngle;
    let motions: Vec<Motion> = ANGLES.map(of).into_iter().chain([turned]).collect();
    let responses: Vec<DetailResponse> = motions
        .par_iter()
        .map(|motion| run(motion, motion.equilibrium(), ResponseSpan::default(), 2000))
        .collect();
    let signal = |detail: usize, name: &str| responses[detail].signal(name).unwrap();
    for (detail, rms, std, largest, load, sun) in [
        (
            0,
            1.910380e-7,
            3.693542e-8,
            2.255715e-7,
            [0.94313, 1.04872],
            9.67012e-9,
        ),
        (
            1,
            1.910193e-7,
            3.689749e-8,
            2.257660e-7,
            [0.94172, 1.05159],
            1.10661e-8,
        ),
        (
            2,
            1.910193e-7,
            3.689749e-8,
            2.257666e-7,
            [0.94172, 1.05160],
            1.10683e-8,
        ),
    ] {
        let (mesh, share) = (signal(detail, "delta_sp1"), signal(detail, "load_sp1"));
        for (got, wanted) in [
            (mesh.rms(), rms),
            (mesh.deviation(), std),
            (mesh.largest(), largest),
            (signal(detail, "x_s").deviation(), sun),
        ] {
            assert!(
                (got / wanted - 1.0).abs() < 6e-6,
                "{detail}: {got:e} {wanted:e}"
            );
        }
        for (got, wanted) in [share.least(), share.largest()].iter().zip(load) {
            assert!((got - wanted).abs() < 6e-6, "{detail}: {got} {wanted}");
        }
        assert_eq!(mesh.lines_above(0.01), 18);
    }
    // Constant angle, but the ring's as the involutes have it at rest.
    let (mesh, sun) = (signal(3, "delta_sp1"), signal(3, "x_s"));
    assert_eq!(
        format!("{:.6e} {:.5e}", mesh.deviation(), sun.deviation()),
        "3.689749e-8 1.10706e-8"
    );
    near(
        mesh.difference(signal(2, "delta_sp1")).unwrap(),
        3.52e-6,
        &"turned",
    );
    for (detail, expected) in [
        (1, [2.077e-3, -1.027e-3, 8.621e-4, 1.444e-1]),
        (2, [2.080e-3, -1.027e-3, 8.648e-4, 1.446e-1]),
    ] {
        let ratio = |name: &str, figure: fn(&ResponseSignal) -> f64| {
            figure(signal(detail, name)) / figure(signal(0, name)) - 1.0
        };
        let got = [
            signal(detail, "delta_sp1")
                .difference(signal(0, "delta_sp1"))
                .unwrap(),
            ratio("delta_sp1", ResponseSignal::deviation),
            ratio("delta_sp1", ResponseSignal::largest),
            ratio("x_s", ResponseSignal::deviation),
        ];
        for (got, expected) in got.into_iter().zip(expected) {
            near(got, expected, &detail);
        }
    }
}

#[test]
fn printed_results_of_82_teeth_state_both_angles_at_rest() {
    let model = HelicalPlanetary::new("kb-1.5e8").unwrap();
    let values = nominal_values(model.parameters());
    // The text does not depend on how long the runs are.
    let span = ResponseSpan {
        settling_periods: 1,
        recorded_periods: 1,
        step_radians: 0.6,
    };
    for quantity in printed_teeth_quantities(&model, &values, span).unwrap() {
        for angle in [
            "varying angle (ring mesh at rest 23.40 deg)",
            "constant (20.65 deg)",
        ] {
            assert!(quantity.meaning.contains(angle), "{}", quantity.meaning);
        }
    }
}
