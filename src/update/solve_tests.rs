//! The solver on problems with known answers.

use crate::theory::{built_in, nominal_values, override_values};

use super::test_models::{chain, free, measured, sensors, two_directions};
use super::*;

/// A test without noise of which everything is trusted nearly without a prior.
fn exact(starts: usize) -> UpdateOptions {
    UpdateOptions {
        frequency_floor: 1e-4,
        starts,
        prior_std: 1.0,
        ..UpdateOptions::default()
    }
}

#[test]
fn a_chain_gets_its_stiffnesses_back_from_every_start() {
    let truth = [130.0, 180.0, 310.0];
    let start = [100.0, 200.0, 300.0];
    let model = chain(&start);
    let test = measured(&model, &truth, 1e-4, true);
    let sensors = sensors(&model, &start);
    let measured = [MeasuredModes::new("t", &test)];
    let chosen = free(&["k1", "k2", "k3"]);
    let problem = UpdateProblem::new(&model, &start, &chosen, &measured, &sensors, exact(8))
        .expect("parameters of the model");
    let found = solve_from_starts(&problem).expect("every start is in bounds");
    assert!(found.best.stop_reason.converged());
    for (got, truth) in found.best.at.values().iter().zip(truth) {
        // The prior pulls by (deviation/prior)^2 of the distance: about (2e-4)^2.
        assert!((got / truth - 1.0).abs() < 1e-6, "{got} {truth}");
    }
    // Objectives fall from step to step, and few steps are needed from the model as it stands.
    let history = solve(&problem, &[0.0; 3])
        .expect("the start is in bounds")
        .history;
    assert!((3..15).contains(&history.len()), "{}", history.len());
    assert!(history.windows(2).all(|w| w[1].objective <= w[0].objective));
    // The same from a pool of one thread, bit for bit.
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("threads start");
    let alone = pool.install(|| solve_from_starts(&problem).expect("every start is in bounds"));
    assert_eq!(alone.objectives, found.objectives);
    assert_eq!(alone.ends, found.ends);
}

#[test]
fn two_directions_that_become_one_repeated_root_are_both_found() {
    let start = [90.0, 125.0];
    let model = two_directions(start);
    let sensors = sensors(&model, &start);
    for shapes in [true, false] {
        let test = measured(&model, &[110.0, 110.0], 1e-4, shapes);
        let measured = [MeasuredModes::new("t", &test)];
        let chosen = free(&["kx", "ky"]);
        let problem = UpdateProblem::new(&model, &start, &chosen, &measured, &sensors, exact(1))
            .expect("parameters of the model");
        let found = update(&problem).expect("the start is in bounds");
        assert!(found.stop_reason.converged());
        for parameter in &found.parameters {
            // Roots nearer than 1e-6 are one, so that their stiffnesses may differ by 2e-6.
            assert!(
                (parameter.updated / 110.0 - 1.0).abs() < 3e-6,
                "{parameter:?}"
            );
            // Either frequency is known to sqrt(2) 1e-4, so either stiffness to twice that; the
            // prior is wide.
            let expected = 2.0 * 2.0f64.sqrt() * 1e-4;
            assert!(
                (parameter.std / parameter.updated / expected - 1.0).abs() < 1e-3,
                "{parameter:?}"
            );
            assert_eq!(parameter.verdict, ParameterVerdict::Identified);
        }
    }
}

#[test]
fn a_parameter_stays_at_its_bound_when_the_test_pulls_beyond() {
    let model = chain(&[100.0]);
    let test = measured(&model, &[139.0], 1e-3, false);
    let measured = [MeasuredModes::new("t", &test)];
    let mut chosen = free(&["k1"]);
    chosen[0].upper = Some(125.0);
    let problem = UpdateProblem::new(&model, &[100.0], &chosen, &measured, &[], exact(1))
        .expect("parameters of the model");
    let found = solve(&problem, &[0.0]).expect("the start is in bounds");
    assert!(
        (found.at.values()[0] - 125.0).abs() < 1e-9,
        "{}",
        found.at.values()[0]
    );
    assert!(found.stop_reason.converged());
}

#[test]
fn crossing_roots_are_tracked_and_the_change_of_order_is_reported() {
    // Planet modes and a rotational mode of the torsional gear with a fixed carrier cross at k_r =
    // 4.308891e7.
    let model = built_in("torsional-planetary/carrier-fixed").expect("a built-in model");
    let specs = model.parameters();
    let at = |k_r: f64| {
        override_values("gear", specs, &[("k_r".to_owned(), k_r)].into())
            .expect("the gear has a k_r")
    };
    let (start, truth) = (at(5.0e7), at(3.7e7));
    let sensors = sensors(model.as_ref(), &start);
    let test = measured(model.as_ref(), &truth, 1e-4, true);
    let measured = [MeasuredModes::new("t", &test)];
    let options = exact(1);
    let chosen = free(&["k_r"]);
    let problem = UpdateProblem::new(
        model.as_ref(),
        &start,
        &chosen,
        &measured,
        &sensors,
        options,
    )
    .expect("parameters of the model");
    let found = solve(&problem, &[0.0]).expect("the start is in bounds");
    let k_r = found.at.values()[problem.free[0].index];
    assert!((k_r / 3.7e7 - 1.0).abs() < 1e-6, "{k_r}");
    assert!(found.pairing_changes.iter().any(|change| change.followed));
}

#[test]
fn the_masses_of_the_torsional_gear_follow_from_its_printed_frequencies() {
    // Table 2 of Wang et al. (2005), 4 planets: three rotational roots and the planet modes (3 of
    // one root).
    let model = built_in("torsional-planetary").expect("a built-in model");
    let mut start = nominal_values(model.parameters());
    for (spec, value) in model.parameters().iter().zip(&mut start) {
        // The carrier as printed, without its planets.
        if spec.name == "m_c" {
            *value = 4.90;
        }
    }
    let mut test = crate::modal::ModalModel::default();
    for (hz, count) in [(1671.43, 1), (2088.00, 3), (6472.35, 1), (13742.19, 1)] {
        let group = (count > 1).then_some(1);
        let shape = crate::modal::ModeShape::default();
        let mode = crate::modal::Mode {
            group,
            ..crate::modal::Mode::new(hz, None, shape, crate::modal::Scaling::Unknown)
        };
        test.modes.extend(std::iter::repeat_n(mode, count));
    }
    let measured = [MeasuredModes::new("table 2", &test)];
    let options = UpdateOptions {
        frequency_floor: 1e-6,
        ..exact(10)
    };
    let chosen = free(&["m_c", "m_r", "m_s", "m_p"]);
    let new = UpdateProblem::new(model.as_ref(), &start, &chosen, &measured, &[], options);
    let problem = new.expect("parameters of the model");
    let found = solve_from_starts(&problem).expect("every start is in bounds");
    let values: Vec<f64> = problem
        .free
        .iter()
        .map(|parameter| found.best.at.values()[parameter.index])
        .collect();
    // As an independent computation found them to 4 digits; the planets' 5.81 from 2088.00 printed
    // with 6.
    for (got, expected) in values.iter().zip([7.54, 1.50, 0.28, 5.81]) {
        assert!((got - expected).abs() < 0.0005, "{values:?}");
    }
}
