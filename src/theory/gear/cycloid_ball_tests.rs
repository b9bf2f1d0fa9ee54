//! Roots, multiplicities, energies and motions of the cycloid ball transmission. Roots against
//! another program's (`tests/reference/cycloid_ball.py`); energies and studies against an
//! independent derivation, to its printed digits.

use crate::geometry::Target;
use crate::theory::parameter::nominal_values;
use crate::theory::{
    CycloidBall, ModeOptions, ModelRoot, TheoreticalModel, TheoryError, TheoryModes, model_roots,
    modes, override_values,
};

fn solved(model: &CycloidBall, values: &[f64]) -> TheoryModes {
    modes(model, values, &[], &ModeOptions::default()).unwrap()
}

fn roots(model: &CycloidBall) -> Vec<ModelRoot> {
    let values = nominal_values(model.parameters());
    model_roots(model, &solved(model, &values))
}

/// Set B with another number of reduction balls.
fn with_balls(balls: f64) -> (CycloidBall, Vec<f64>) {
    let model = CycloidBall::new("B").unwrap();
    let values = override_values(
        model.name(),
        model.parameters(),
        &[("ball_count".to_owned(), balls)].into(),
    );
    (model, values.unwrap())
}

/// All 37 angular frequencies of a set, rad/s, from the printed matrix by
/// `tests/reference/cycloid_ball.py`.
fn reference(set: &str) -> Vec<f64> {
    let lines = include_str!("../../../tests/reference/cycloid_ball.txt").lines();
    let numbers = lines.filter_map(|line| line.strip_prefix(set)?.strip_prefix(' '));
    numbers.map(|number| number.parse().unwrap()).collect()
}

#[test]
fn roots_and_multiplicities_of_every_set_are_the_reference() {
    for set in ["A", "B", "C", "D"] {
        let found = roots(&CycloidBall::new(set).unwrap());
        let multiplicities: Vec<usize> = found.iter().map(|root| root.modes.len()).collect();
        let mut wanted = vec![1; 17];
        (wanted[0], wanted[5], wanted[11]) = (11, 4, 8);
        assert_eq!(multiplicities, wanted, "set {set}");
        let all = found.iter();
        let all = all.flat_map(|root| vec![root.omega_rad_s; root.modes.len()]);
        let expected = reference(set);
        assert_eq!(expected.len(), 37);
        for (omega, expected) in all.zip(expected) {
            // Two solvers, each good to some units in the last place of the largest root.
            assert!(
                (omega - expected).abs() <= 1e-8 + 1e-11 * expected,
                "set {set}: {omega} and {expected}"
            );
        }
    }
}

#[test]
fn the_energies_of_set_b_are_where_the_reference_has_them() {
    let found = roots(&CycloidBall::new("B").unwrap());
    let share = |number: usize, kind: &str| -> f64 {
        let root = &found[number - 1];
        let all = root.energy_by_kind().into_iter();
        all.filter(|(body, _)| body == kind).map(|(_, s)| s).sum()
    };
    for (number, kind, expected) in [
        (2, "pin-ball", 0.2405),
        (4, "pin-ball", 0.1428),
        (4, "planet-disc", 0.1414),
        (5, "output", 0.5965),
        (5, "pin-ball", 0.2134),
        (6, "pin-ball", 1.0),
        (7, "pin-ball", 0.5065),
        (7, "output", 0.3295),
        (9, "centre-disc", 0.3982),
        (9, "input", 0.3954),
        (10, "ball", 0.6368),
        (11, "ball", 0.6907),
        (12, "ball", 1.0),
        (13, "output", 0.4191),
        (14, "pin-ball", 0.1749),
        (15, "planet-disc", 0.6850),
        (15, "ball", 0.1477),
        (16, "ball", 0.1438),
    ] {
        let got = share(number, kind);
        assert!(
            (got - expected).abs() <= 5.1e-5,
            "root {number}, {kind}: {got}"
        );
    }
    // Single coordinates.
    let model = CycloidBall::new("B").unwrap();
    let modes = solved(&model, &nominal_values(model.parameters()));
    let of = |number: usize, name: &str| {
        let i = modes
            .coordinates
            .iter()
            .position(|c| c.name == name)
            .unwrap();
        modes.kinetic_shares[(i, found[number - 1].modes[0])]
    };
    for (number, name, expected) in [
        (2, "u0", 0.6230),
        (3, "x0", 0.3319),
        (8, "x1", 0.5494),
        (13, "u5", 0.4191),
        (14, "x3", 0.1699),
        (16, "u3", 0.4420),
        (17, "u1", 0.9987),
    ] {
        let got = of(number, name);
        assert!(
            (got - expected).abs() <= 5.1e-5,
            "root {number}, {name}: {got}"
        );
    }
    for root in &found {
        let sum: f64 = root.kinetic_energy.iter().map(|(_, s)| s).sum();
        assert!((sum - 1.0).abs() < 1e-12);
    }
}

#[test]
fn classes_follow_the_two_groups_into_which_the_problem_splits() {
    let found = roots(&CycloidBall::new("B").unwrap());
    let class = |number: usize| found[number - 1].class.clone().unwrap();
    for number in [4, 5, 7, 9, 11, 15] {
        assert_eq!(class(number), "translation in y, nothing turns");
    }
    for number in [2, 3, 8, 10, 13, 14, 16] {
        assert_eq!(class(number), "x and torsion, output turns");
    }
    assert_eq!(class(1), "free motion");
    assert_eq!(class(6), "output still: pin balls");
    assert_eq!(class(12), "output still: reduction balls");
    assert!(class(17).contains("centre disc turns"));
}

#[test]
fn the_zero_modes_are_ten_rolling_balls_and_the_mechanism() {
    let model = CycloidBall::new("B").unwrap();
    let values = nominal_values(model.parameters());
    let matrices = model.assemble(&values).unwrap();
    let value = |name: &str| {
        let at = model.parameters().iter().position(|p| p.name == name);
        values[at.unwrap()]
    };
    let (e, radius) = (value("half_eccentricity"), value("pin_circle_radius"));
    let turn = 2.0 / 11.0;
    let motion: Vec<f64> = matrices
        .coordinates
        .iter()
        .map(|c| match c.name.as_str() {
            "u0" => 1.0,
            "x3" => -2.0 * e,
            "u3" | "u5" => turn,
            name => name.strip_prefix("y4_").map_or(0.0, |number| {
                let j: f64 = number.parse().unwrap();
                turn * radius * (std::f64::consts::TAU * (j - 1.0) / 6.0).sin()
            }),
        })
        .collect();
    let n = motion.len();
    for i in 0..n {
        let terms: Vec<f64> = (0..n)
            .map(|j| matrices.stiffness[(i, j)] * motion[j])
            .collect();
        let magnitude: f64 = terms.iter().map(|t| t.abs()).sum();
        let force: f64 = terms.iter().sum();
        assert!(
            force.abs() <= 40.0 * f64::EPSILON * magnitude,
            "row {i}: {force}"
        );
    }
    // A ball along its groove, at a right angle to its normal, deforms nothing either.
    let rolling = solved(&model, &values);
    assert_eq!(rolling.rigid, 11);
}

#[test]
fn more_balls_add_zero_and_ball_roots_and_no_others() {
    // The fourth number is the third single root in rad/s.
    for (balls, zero, ball, third) in [(8, 9, 6, 13920.975), (12, 13, 10, 13613.763)] {
        let (model, values) = with_balls(f64::from(balls));
        let found = model_roots(&model, &solved(&model, &values));
        let multiple: Vec<usize> = found
            .iter()
            .map(|root| root.modes.len())
            .filter(|&m| m > 1)
            .collect();
        assert_eq!(multiple, [zero, 4, ball]);
        assert_eq!(
            found.iter().filter(|root| root.modes.len() == 1).count(),
            14
        );
        assert!((found[2].omega_rad_s - third).abs() < 6e-4);
    }
}

#[test]
fn the_mode_that_jumps_meets_its_neighbour_where_the_reference_has_it() {
    // Set B over k03y: root 14 rises, and is constant above 3.19e7 N/m; an exact crossing, no
    // veering.
    let model = CycloidBall::new("B").unwrap();
    let at = model.parameters().iter().position(|p| p.name == "k_03y");
    let fourteenth = |k: f64| {
        let mut values = nominal_values(model.parameters());
        values[at.unwrap()] = k;
        model_roots(&model, &solved(&model, &values))[13].omega_rad_s
    };
    for (k, expected) in [
        (1e7, 62236.562),
        (2e7, 63583.833),
        (3e7, 65161.803),
        (3.192962e7, 65492.213),
        (4e7, 65492.213),
        (9e7, 65492.213),
    ] {
        let got = fourteenth(k);
        assert!((got - expected).abs() < 2e-3, "{k}: {got}");
    }
}

#[test]
fn a_sensor_reads_the_disc_on_which_it_sits() {
    let model = CycloidBall::new("B").unwrap();
    let target = Target::BodyPoint {
        body: "planet-disc".to_owned(),
        at_m: [0.02, 2.4e-3, 0.0],
        direction: [0.0, 1.0, 0.0],
    };
    let values = nominal_values(model.parameters());
    let row = model.observation_row(&values, &target).unwrap();
    let matrices = model.assemble(&values).unwrap();
    for (value, coordinate) in row.iter().zip(&matrices.coordinates) {
        let expected = match coordinate.name.as_str() {
            "y3" => 1.0,
            "u3" => 0.02,
            _ => 0.0,
        };
        assert!((value - expected).abs() < 1e-15, "{}", coordinate.name);
    }
}

#[test]
fn the_number_of_balls_is_whole_has_no_derivative_and_moves_the_sensors_with_it() {
    let (model, values) = with_balls(12.0);
    let j = model
        .parameters()
        .iter()
        .position(|p| p.name == "ball_count");
    let j = j.unwrap();
    for (bad, whole) in [(10.5, false), (3.0, true), (41.0, true)] {
        let mut values = values.clone();
        values[j] = bad;
        let error = model.assemble(&values).unwrap_err();
        let expected = match error {
            TheoryError::NotWhole { ref name, got } => {
                !whole && name == "ball_count" && got.to_bits() == bad.to_bits()
            }
            TheoryError::OutOfBounds { ref name, .. } => whole && name == "ball_count",
            _ => false,
        };
        assert!(expected, "{error}");
    }
    let error = model.derivative(&values, j).unwrap_err();
    assert!(matches!(error, TheoryError::NoDerivative { name } if name == "ball_count"));
    // Ball 12 is there, on its circle of radius Z2 e/K about (0, e), and reads its coordinate
    // alone.
    let matrices = model.assemble(&values).unwrap();
    assert_eq!(matrices.coordinates.len(), 11 + 2 * 12 + 6);
    let last = matrices.coordinates.iter().position(|c| c.name == "y2_12");
    let last = last.unwrap();
    let [x, y, _] = matrices.coordinates[last].at_m;
    assert!((x.hypot(y - 1.2e-3) - 12.0 * 4e-3).abs() < 1e-15);
    let target = Target::BodyPoint {
        body: "ball-12".to_owned(),
        at_m: [0.0; 3],
        direction: [0.0, 1.0, 0.0],
    };
    let row = model.observation_row(&values, &target).unwrap();
    let mut expected = vec![0.0; matrices.coordinates.len()];
    expected[last] = 1.0;
    assert_eq!(row, expected);
    let nominal = nominal_values(model.parameters());
    assert!(model.observation_row(&nominal, &target).is_err());
}

#[test]
fn contact_angles_follow_from_the_printed_roots_of_balls_alone() {
    let model = CycloidBall::new("B").unwrap();
    for (name, expected) in [
        ("cos2_beta", 0.565350409),
        ("cos2_beta_1", 0.497692110),
        ("cos2_beta_2", 0.497692110),
    ] {
        let spec = model.parameters().iter().find(|spec| spec.name == name);
        // Half a unit of the last printed digit.
        assert!((spec.unwrap().nominal - expected).abs() < 6e-10, "{name}");
    }
}
