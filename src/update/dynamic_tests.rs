//! Modal dynamic residuals: their size, their derivatives against differences, and round trips.

use crate::modal::{ModalModel, ModeShape};
use crate::theory::{built_in, nominal_values};

use super::test_models::{
    against_differences, chain, chain_of, free, measured, sensors, two_directions,
};
use super::*;

fn options() -> UpdateOptions {
    let mut options = UpdateOptions {
        residuals: Residuals::ModalDynamic,
        frequency_floor: 1e-4,
        starts: 1,
        prior_std: 1.0,
        ..UpdateOptions::default()
    };
    options.pair.rotation_length_m = Some(0.1);
    options
}

#[test]
fn a_frequency_that_is_off_leaves_its_error_over_its_deviation() {
    // Shapes as they are, frequencies 0.1 % too high with a deviation of 0.1 %; chi-square of one
    // for each mode.
    let start = [100.0, 200.0, 300.0];
    let model = chain(&start);
    let mut test = measured(&model, &start, 1e-3, true);
    test.modes
        .iter_mut()
        .for_each(|mode| mode.frequency_hz *= 1.001);
    let measured = [MeasuredModes::new("t", &test)];
    let sensors = sensors(&model, &start);
    let kind = UpdateOptions {
        frequency_floor: 0.0,
        ..options()
    };
    let problem =
        UpdateProblem::new(&model, &start, &free(&["k1"]), &measured, &sensors, kind).unwrap();
    let at = problem.start(&[0.0]).unwrap();
    // To first order in 0.1 %, and in what the shape's deviations let the motion give way.
    assert!(
        (at.chi_square() / 3.0 - 1.0).abs() < 5e-3,
        "{}",
        at.chi_square()
    );
    // Three shapes at three sensors.
    assert_eq!(problem.data_count(&at), 9);
}

#[test]
fn the_frequency_of_a_double_root_counts_once() {
    let start = [100.0, 100.0];
    let model = two_directions(start);
    let mut test = measured(&model, &start, 1e-3, true);
    for mode in &mut test.modes {
        mode.frequency_hz *= 1.001;
        mode.group = Some(1);
    }
    let measured = [MeasuredModes::new("t", &test)];
    let sensors = sensors(&model, &start);
    let kind = UpdateOptions {
        frequency_floor: 0.0,
        ..options()
    };
    let problem =
        UpdateProblem::new(&model, &start, &free(&["kx"]), &measured, &sensors, kind).unwrap();
    let at = problem.start(&[0.0]).unwrap();
    // As exact as for single roots.
    assert!((at.chi_square() - 1.0).abs() < 5e-3, "{}", at.chi_square());
    // Two shapes leave no residual at two sensors: the frequency alone is a datum.
    assert_eq!(problem.data_count(&at), 1);
}

#[test]
fn derivatives_are_those_of_differences_for_repeated_roots_too() {
    let model = built_in("torsional-planetary").unwrap();
    let start = nominal_values(model.parameters());
    let mut truth = start.clone();
    truth[4] *= 1.2;
    let test = measured(model.as_ref(), &truth, 1e-3, true);
    let measured = [MeasuredModes::new("t", &test)];
    let sensors = sensors(model.as_ref(), &start);
    let chosen = free(&["k_r", "k_s", "m_p"]);
    let problem = UpdateProblem::new(
        model.as_ref(),
        &start,
        &chosen,
        &measured,
        &sensors,
        options(),
    )
    .unwrap();
    let worst = against_differences(&problem, &[0.1, -0.1, 0.05]);
    assert!(worst < 1e-6, "{worst}");
}

#[test]
fn the_equations_of_motion_give_the_stiffnesses_back() {
    let (start, truth) = ([100.0, 200.0, 300.0], [130.0, 180.0, 310.0]);
    let model = chain(&start);
    let test = measured(&model, &truth, 1e-4, true);
    let measured = [MeasuredModes::new("t", &test)];
    let sensors = sensors(&model, &start);
    let chosen = free(&["k1", "k2", "k3"]);
    let problem =
        UpdateProblem::new(&model, &start, &chosen, &measured, &sensors, options()).unwrap();
    let result = update(&problem).unwrap();
    for (parameter, truth) in result.parameters.iter().zip(truth) {
        // The prior pulls by its square of the deviation.
        assert!(
            (parameter.updated / truth - 1.0).abs() < 1e-6,
            "{parameter:?}"
        );
        assert_eq!(parameter.verdict, ParameterVerdict::Identified);
    }
    // With frequencies and shapes the same stiffnesses are known about as well.
    let modal = UpdateOptions {
        residuals: Residuals::Modes,
        ..options()
    };
    let problem = UpdateProblem::new(&model, &start, &chosen, &measured, &sensors, modal).unwrap();
    let modal = update(&problem).unwrap();
    for (a, b) in result.parameters.iter().zip(&modal.parameters) {
        assert!((a.std / b.std - 1.0).abs() < 0.1, "{} {}", a.std, b.std);
    }
}

/// Springs on both sides of a massless node are separated by the shapes there: with modes and with
/// equations of motion.
#[test]
fn massless_nodes_follow_by_statics_in_residuals_and_their_derivatives() {
    let (start, truth) = ([100.0, 200.0, 300.0, 150.0], [130.0, 180.0, 310.0, 160.0]);
    let model = chain_of(&[0.0, 2.0, 0.0, 1.0], &start);
    let test = measured(&model, &truth, 1e-4, true);
    assert_eq!(test.modes.len(), 2);
    let measured = [MeasuredModes::new("t", &test)];
    let sensors = sensors(&model, &start);
    let chosen = free(&["k1", "k2", "k3", "k4"]);
    for residuals in [Residuals::ModalDynamic, Residuals::Modes] {
        let kind = UpdateOptions {
            residuals,
            ..options()
        };
        let problem =
            UpdateProblem::new(&model, &start, &chosen, &measured, &sensors, kind).unwrap();
        let worst = against_differences(&problem, &[0.1, -0.1, 0.05, 0.02]);
        assert!(worst < 1e-6, "{residuals:?}: {worst}");
        let result = update(&problem).unwrap();
        for (parameter, truth) in result.parameters.iter().zip(truth) {
            // The prior pulls by the square of its ratio to the posterior deviation, 0.5 % of the
            // largest.
            assert!(
                (parameter.updated / truth - 1.0).abs() < 5e-3,
                "{residuals:?} {parameter:?}"
            );
        }
    }
}

#[test]
fn a_mode_without_a_shape_is_refused() {
    let start = [100.0, 200.0];
    let model = chain(&start);
    let test: ModalModel = measured(&model, &start, 1e-3, false);
    assert!(
        test.modes
            .iter()
            .all(|mode| mode.shape == ModeShape::default())
    );
    let measured = [MeasuredModes::new("t", &test)];
    let sensors = sensors(&model, &start);
    let problem = UpdateProblem::new(
        &model,
        &start,
        &free(&["k1"]),
        &measured,
        &sensors,
        options(),
    );
    let label = "t f1".to_owned();
    assert_eq!(problem.unwrap_err(), UpdateError::NoShapes { label });
}
