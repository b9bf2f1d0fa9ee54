//! Variants of the nominal spider reducer, to the digits of the reference: derived geometry, the
//! calibration, unequal shafts over a crank turn, a free input shaft, and FRFs.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::dof::Dof;
use crate::geometry::{Sensor, Target};
use crate::linalg::{RealMatrix, real_matrix, symmetric_modes};
use crate::theory::parameter::{nominal_values, override_values};
use crate::theory::residues::residues;
use crate::theory::{
    Coordinate, ModeOptions, Motion, SpiderReducer, Spring, SystemMatrices, TheoreticalModel,
    TheoryModes, modes, modes_of_matrices,
};

/// Crank positions over one turn; both ends of every range are among them.
const POSITIONS: usize = 48;

fn paper() -> SpiderReducer {
    SpiderReducer::new("paper").expect("the set is built in")
}

fn values(model: &SpiderReducer, changes: &[(&str, f64)]) -> Vec<f64> {
    let changes = changes.iter().map(|(name, v)| ((*name).to_owned(), *v));
    override_values("reducer", model.parameters(), &changes.collect())
        .expect("the names are parameters")
}

fn nominal(name: &str) -> f64 {
    let model = paper();
    let parameter = model.parameters().iter().find(|spec| spec.name == name);
    parameter.expect("the name is a parameter").nominal
}

fn printed(value: f64, text: &str) {
    let decimals = text.split('.').nth(1).map_or(0, str::len);
    assert_eq!(format!("{value:.decimals$}"), text);
}

fn frequencies(modes: &TheoryModes) -> Vec<f64> {
    modes.omega_rad_s.iter().map(|omega| omega / TAU).collect()
}

/// The stiffness matrix of springs.
fn sprung(springs: &[Spring], n: usize) -> RealMatrix {
    real_matrix(n, n, |i, j| {
        let parts = springs.iter();
        parts
            .map(|spring| spring.stiffness * spring.row[i] * spring.row[j])
            .sum()
    })
}

#[test]
fn eccentricity_and_base_radii_are_the_reference() {
    for (name, expected) in [
        ("eccentricity", 3.1105082651614966e-3),
        ("ring_base_radius", 0.13813481525552854),
        ("gear_base_radius", 0.13531573739317082),
    ] {
        assert!((nominal(name) / expected - 1.0).abs() < 1e-15, "{name}");
    }
}

#[test]
fn the_calibrated_values_give_both_printed_frequencies() {
    let model = paper();
    let exact = values(
        &model,
        &[("j_sz", 1.7205043380e-4), ("z_o2", -0.1209034998)],
    );
    let hz = frequencies(
        &modes(&model, &exact, &[], &ModeOptions::default()).expect("the model has modes"),
    );
    printed(hz[0], "66.200000");
    printed(hz[8], "272.600000");
    // Those of the model are these, rounded.
    assert_eq!(
        format!("{:.4e}", 1.7205043380e-4),
        format!("{:.4e}", nominal("j_sz"))
    );
    printed(nominal("z_o2"), "-0.1209");
}

#[test]
fn the_machine_is_held_with_the_least_stiffness_of_the_reference() {
    let model = paper();
    let matrices = model
        .assemble(&nominal_values(model.parameters()))
        .expect("nominal values are legal");
    let unit = real_matrix(35, 35, |i, j| f64::from(u8::from(i == j)));
    let least = symmetric_modes(&matrices.stiffness, &unit).expect("the matrices are symmetric");
    printed(least.omega_squared[0], "103.75");
}

#[test]
fn the_output_swings_in_mode_3() {
    let model = paper();
    let solved = modes(&model, &values(&model, &[]), &[], &ModeOptions::default())
        .expect("the model has modes");
    for (names, text) in [
        (&["box", "boy"][..], "63.6415"),
        (&["xo", "yo"], "3.7971"),
        (&["boz"], "0.0594"),
    ] {
        let all = solved.coordinates.iter().enumerate();
        let named = all.filter(|(_, coordinate)| names.contains(&coordinate.name.as_str()));
        let share: f64 = named.map(|(i, _)| solved.kinetic_shares[(i, 2)]).sum();
        printed(100.0 * share, text);
    }
}

#[test]
fn unequal_shafts_move_the_frequencies_over_a_turn_of_the_crank() {
    let model = paper();
    let mut least = [f64::MAX; 9];
    let mut largest = [0.0f64; 9];
    for position in 0..POSITIONS {
        let angle = TAU * position as f64 / POSITIONS as f64;
        let mut matrices = model
            .assemble(&values(&model, &[("crank_angle", angle)]))
            .unwrap();
        let coordinates = &matrices.coordinates;
        // The housing bearings of shafts 1 and 3.
        for spring in &mut matrices.springs {
            let mut parts = spring.row.iter().zip(coordinates);
            let softer = parts.any(|(part, coordinate)| {
                part.abs() > 0.0 && matches!(coordinate.body.as_str(), "shaft-1" | "shaft-3")
            });
            if softer && matches!(spring.name.as_str(), "k_s1" | "k_s2") {
                spring.stiffness *= 0.8;
            }
        }
        matrices.stiffness = sprung(&matrices.springs, 35);
        let hz = frequencies(
            &modes_of_matrices(&matrices, &ModeOptions::default()).expect("the model has modes"),
        );
        for i in 0..9 {
            least[i] = least[i].min(hz[i]);
            largest[i] = largest[i].max(hz[i]);
        }
    }
    for (found_hz, expected) in [
        (
            least,
            [
                "66.1314", "88.5019", "113.8024", "155.7590", "183.2824", "186.2200", "231.2263",
                "268.1285", "270.3242",
            ],
        ),
        (
            largest,
            [
                "66.1315", "88.5613", "114.6891", "155.7925", "183.3484", "186.2204", "232.1268",
                "270.3241", "272.6003",
            ],
        ),
    ] {
        for (hz, text) in found_hz.into_iter().zip(expected) {
            printed(hz, text);
        }
    }
}

/// The machine with the input's rotation as a further coordinate, the last one, which moves both
/// eccentrics.
fn with_free_input() -> SystemMatrices {
    let model = paper();
    let held = model
        .assemble(&nominal_values(model.parameters()))
        .expect("nominal values are legal");
    let (e, n) = (nominal("eccentricity"), held.coordinates.len() + 1);
    let mut springs = held.springs.clone();
    for spring in &mut springs {
        // At a crank angle of 0 the eccentrics are at +e and -e along x, and move along y.
        let reads = |name: &str| {
            let at = held
                .coordinates
                .iter()
                .position(|coordinate| coordinate.name == name);
            spring.row[at.expect("the coordinate is the model's")].abs() > 0.0
        };
        let part = match (spring.name.as_str(), reads("yp1"), reads("yp2")) {
            ("k_a", true, _) => -e,
            ("k_a", _, true) => e,
            _ => 0.0,
        };
        spring.row.push(part);
    }
    let mut coordinates = held.coordinates.clone();
    coordinates.push(Coordinate {
        name: "biz".to_owned(),
        body: "input".to_owned(),
        motion: Motion::Rotation,
        axis: [0.0, 0.0, 1.0],
        at_m: [0.0; 3],
    });
    // A solid shaft of 27.5 mm radius.
    let spin = 0.5 * nominal("m_i") * 0.0275f64.powi(2);
    SystemMatrices {
        mass: real_matrix(n, n, |i, j| match (i == j, i + 1 == n) {
            (true, true) => spin,
            (true, false) => held.mass[(i, i)],
            (false, _) => 0.0,
        }),
        damping: None,
        stiffness: sprung(&springs, n),
        coordinates,
        springs,
    }
}

#[test]
fn with_its_input_free_the_machine_turns_by_the_transmission_ratio() {
    let free = with_free_input();
    let solved = modes_of_matrices(&free, &ModeOptions::default()).expect("the model has modes");
    assert_eq!(solved.rigid, 1);
    let output = free
        .coordinates
        .iter()
        .position(|coordinate| coordinate.name == "boz");
    let ratio = solved.vectors[(35, 0)]
        / solved.vectors[(output.expect("the coordinate is the model's"), 0)];
    assert!((ratio / 49.0 - 1.0).abs() < 1e-8, "{ratio}");
    let expected = [
        "0.0000", "66.2508", "104.6092", "118.2163", "160.7186", "183.8804", "186.3990",
        "235.9928", "272.6003", "272.6003", "279.6706",
    ];
    for (hz, text) in frequencies(&solved).into_iter().zip(expected) {
        printed(hz, text);
    }
}

#[test]
fn accelerances_with_two_percent_of_damping_are_the_reference() {
    let model = paper();
    let input_m = nominal("z_o3") - nominal("a_2") + nominal("a_1");
    let sensor = |dof: &str, body: &str, z: f64| Sensor {
        dof: dof.parse().expect("a name of a degree of freedom"),
        target: Target::BodyPoint {
            body: body.to_owned(),
            at_m: [0.0, 0.0, z],
            direction: [1.0, 0.0, 0.0],
        },
    };
    // The front bearing of the input, which is hit, and the rear one of the output.
    let sensors = [
        sensor("1:+X", "input", input_m),
        sensor("2:+X", "output", nominal("z_o2")),
    ];
    let options = ModeOptions::default();
    let solved =
        modes(&model, &values(&model, &[]), &sensors, &options).expect("the model has modes");
    let dof = |text: &str| -> Dof { text.parse().expect("a name of a degree of freedom") };
    let pairs = ["1:+X", "2:+X"].map(|response| (dof(response), dof("1:+X")));
    let parts = residues(&solved, &[0.02; 35], &pairs).expect("sensors are the model\'s");
    for (hz, expected) in [
        (20.0, ["1.24492663e-3", "1.70556863e-5"]),
        (66.2, ["1.90766670e-2", "1.91127167e-2"]),
        (100.0, ["3.29053157e-2", "3.76220855e-3"]),
        (150.0, ["9.34393702e-2", "1.33470802e-2"]),
        (200.0, ["2.05752994e-1", "5.97063895e-2"]),
        (250.0, ["7.30955873e-1", "2.28644774e-2"]),
        (272.6, ["2.61181284e0", "4.84899078e-2"]),
        (400.0, ["6.35609438e-1", "1.72020467e-2"]),
    ] {
        let s = Complex64::new(0.0, TAU * hz);
        for (pair, text) in parts.iter().zip(expected) {
            let terms = pair.elastic.iter().map(|(pole, residue)| {
                residue / (s - pole.lambda) + residue.conj() / (s - pole.lambda.conj())
            });
            let receptance: Complex64 = terms.sum();
            assert_eq!(format!("{:.8e}", (s * s * receptance).norm()), text);
        }
    }
}
