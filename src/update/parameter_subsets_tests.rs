//! Which single change explains a misfit: a chain with one spring changed.

use super::test_models::{chain, free, measured, sensors};
use super::*;

#[test]
fn the_changed_spring_is_proposed_and_predicts_held_out_modes() {
    let start = [100.0, 200.0, 300.0, 150.0];
    let model = chain(&start);
    let test = measured(&model, &[100.0, 200.0, 420.0, 150.0], 1e-3, false);
    let measured = [MeasuredModes::new("t", &test)];
    let sensors = sensors(&model, &start);
    let options = UpdateOptions {
        starts: 3,
        ..UpdateOptions::default()
    };
    let chosen = free(&["k1", "k2", "k3", "k4"]);
    let problem =
        UpdateProblem::new(&model, &start, &chosen, &measured, &sensors, options).unwrap();
    let found = explain(&problem, &[]).unwrap();
    assert_eq!(found.single.len(), 4);
    assert_eq!(found.pairs.len(), 6);
    assert_eq!(found.proposed.parameters, ["k3"]);
    assert!(found.proposed.explains() && !found.none.explains());
    assert!((found.proposed.values[0] / 420.0 - 1.0).abs() < 0.01);
    assert!(!found.single[1].explains());
    // A second parameter costs more than it gains.
    assert!(found.pairs[0].bic > found.proposed.bic);
    assert_eq!(found.left_out_predictions.len(), 4);
    for row in &found.left_out_predictions {
        assert!(row.after_percent.abs() < 0.1, "{row:?}");
    }
    for always in [vec!["k9"], vec!["k1", "k1"]] {
        let names: Vec<String> = always.iter().map(|&name| name.to_owned()).collect();
        assert!(check_always(&problem, &names).is_err(), "{always:?}");
        assert!(explain(&problem, &names).is_err(), "{always:?}");
    }
    assert_eq!(check_always(&problem, &["k1".to_owned()]), Ok(()));
}

#[test]
fn a_change_far_outside_the_prior_is_found_as_large_as_it_is() {
    // 30 % more of one stiffness, to which the prior gives 2 %: an update is pulled back, what
    // explains the misfit is not.
    let (start, truth) = ([100.0, 200.0], [100.0, 260.0]);
    let model = chain(&start);
    let test = measured(&model, &truth, 1e-2, false);
    let measured = [MeasuredModes::new("t", &test)];
    let options = UpdateOptions {
        frequency_floor: 0.0,
        prior_std: 0.02,
        starts: 1,
        ..UpdateOptions::default()
    };
    let chosen = free(&["k1", "k2"]);
    let problem = UpdateProblem::new(&model, &start, &chosen, &measured, &[], options).unwrap();
    let pulled = update(&problem).unwrap();
    assert!(pulled.parameters[1].updated < 250.0);
    let found = single_parameter_fits(&problem, &[]).unwrap();
    assert_eq!(found[0].parameters, ["k2"]);
    // The prior's rows weigh a thousandth: a pull of 13 deviations is one of 1e-6 of that.
    assert!((found[0].values[0] / 260.0 - 1.0).abs() < 1e-4, "{found:?}");
    assert!(found[0].fit.chi_square < 1e-6);
    // BIC of one parameter and two residuals.
    let bic = found[0].fit.chi_square + 2.0f64.ln();
    assert!((found[0].bic - bic).abs() < 1e-12);
}
