//! Deviations of what was measured: stated ones, assumed ones, and the floor that several tests
//! share.

use num_complex::Complex64;

use super::target::ShapeRows;
use super::test_models::{chain, free, measured, sensors, two_directions};
use super::*;
use crate::dof::Dof;
use crate::modal::ModeShape;

/// One spring, measured by some tests to 0.3 % with a floor of 0.4 %: the posterior deviation of
/// its stiffness.
fn std_of(tests: usize) -> f64 {
    let model = chain(&[100.0]);
    let test = measured(&model, &[100.0], 3e-3, false);
    let measured: Vec<MeasuredModes<'_>> =
        (0..tests).map(|_| MeasuredModes::new("t", &test)).collect();
    let options = UpdateOptions {
        frequency_floor: 4e-3,
        prior_std: 100.0,
        starts: 1,
        ..UpdateOptions::default()
    };
    let mut chosen = free(&["k1"]);
    chosen[0].lower = Some(1.0);
    let problem = UpdateProblem::new(&model, &[100.0], &chosen, &measured, &[], options).unwrap();
    let result = update(&problem).unwrap();
    result.parameters[0].std / result.parameters[0].updated
}

#[test]
fn tests_of_one_machine_share_the_error_of_its_model() {
    // A stiffness is known to twice the deviation of the frequency. That of the mean of k tests is
    // 0.3 % over sqrt(k); the model's 0.4 % is the same in all of them.
    for tests in [1, 2, 9] {
        let expected = 2.0 * (3e-3f64.powi(2) / tests as f64 + 4e-3f64.powi(2)).sqrt();
        let got = std_of(tests);
        assert!(
            (got / expected - 1.0).abs() < 1e-3,
            "{tests}: {got} {expected}"
        );
    }
}

#[test]
fn shapes_weigh_what_the_test_says_and_the_assumption_stands_in_where_it_says_nothing() {
    let start = [100.0, 200.0, 300.0];
    let model = chain(&start);
    let mut test = measured(&model, &start, 1e-4, true);
    // Deviations of the first mode alone, 1 % of each component; the second has none, the third not
    // of all.
    for (mode, count) in [(0, 3), (2, 2)] {
        let shape = test.modes[mode].shape.clone();
        let stds = shape
            .iter()
            .take(count)
            .map(|(dof, v)| (dof.clone(), 0.01 * v.norm()));
        test.modes[mode].shape_std = Some(stds.collect());
    }
    let sensors = sensors(&model, &start);
    let measured = [MeasuredModes::new("t", &test)];
    let options = UpdateOptions {
        shape_floor: Some(1e-9),
        assumed_shape_std: 0.07,
        ..UpdateOptions::default()
    };
    let problem =
        UpdateProblem::new(&model, &start, &free(&["k1"]), &measured, &sensors, options).unwrap();
    let weights: Vec<_> = problem
        .targets
        .iter()
        .map(|target| target.shape_weights)
        .collect();
    let (stated, assumed) = (Some(ShapeWeights::Test), Some(ShapeWeights::Assumed));
    assert_eq!(weights, [stated, assumed, assumed]);
    // Components over their deviations: 1 over 1 %, and of those of root mean square 1 over the
    // assumed 7 %.
    let sizes = |target: usize| -> Vec<f64> {
        let shapes = problem.targets[target].shapes.as_ref().unwrap();
        shapes.vectors[0].iter().map(|x| x.abs()).collect()
    };
    assert!(
        sizes(0).iter().all(|x| (x - 100.0).abs() < 1e-6),
        "{:?}",
        sizes(0)
    );
    let squares: f64 = sizes(1).iter().map(|x| x * x * 0.07 * 0.07).sum();
    assert!((squares - 3.0).abs() < 1e-9, "{squares}");
    let result = update(&problem).unwrap();
    let reported: Vec<_> = result
        .after
        .rows
        .iter()
        .map(|row| row.shape_weights)
        .collect();
    assert_eq!(reported, weights);
}

#[test]
fn a_symmetric_start_splits_to_the_side_that_the_shapes_say() {
    let start = [100.0, 100.0];
    let model = two_directions(start);
    let sensors = sensors(&model, &start);
    for truth in [[110.0, 130.0], [130.0, 110.0]] {
        let test = measured(&model, &truth, 1e-4, true);
        let measured = [MeasuredModes::new("t", &test)];
        let options = UpdateOptions {
            frequency_floor: 1e-4,
            prior_std: 1.0,
            starts: 1,
            ..UpdateOptions::default()
        };
        let chosen = free(&["kx", "ky"]);
        let problem =
            UpdateProblem::new(&model, &start, &chosen, &measured, &sensors, options).unwrap();
        let result = update(&problem).unwrap();
        for (parameter, truth) in result.parameters.iter().zip(truth) {
            assert!(
                (parameter.updated / truth - 1.0).abs() < 1e-6,
                "{parameter:?}"
            );
        }
    }
}

#[test]
fn directions_that_a_test_filled_with_zeros_take_no_part() {
    let start = [100.0, 200.0, 300.0];
    let model = chain(&start);
    let mut test = measured(&model, &start, 1e-4, true);
    let dofs: Vec<Dof> = test.modes[0]
        .shape
        .iter()
        .map(|(dof, _)| dof.clone())
        .collect();
    for mode in &mut test.modes {
        let values = mode.shape.iter().map(|(dof, value)| match *dof == dofs[0] {
            true => (dof.clone(), Complex64::ZERO),
            false => (dof.clone(), value),
        });
        mode.shape = ModeShape::new(values.collect::<Vec<_>>());
    }
    let sensors: Vec<(Dof, Vec<f64>)> = dofs.iter().map(|dof| (dof.clone(), vec![1.0])).collect();
    let rows = ShapeRows::new(&sensors, &test, &[], &UpdateOptions::default(), 0.0);
    let read: Vec<bool> = dofs.iter().map(|dof| rows.reads(dof)).collect();
    assert_eq!(read, [false, true, true]);
}
