//! What the data can tell: verdicts, combinations, deviations against closed forms; an ill-posed
//! case.

use crate::correlate::ErrorReference;
use crate::correlate::measures::reverse_sensors;
use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::linalg::real_matrix;

use super::result::Judged;
use super::test_models::{chain, free, measured, sensors};
use super::*;

fn options() -> UpdateOptions {
    UpdateOptions {
        starts: 3,
        ..UpdateOptions::default()
    }
}

#[test]
fn the_posterior_deviation_of_one_spring_is_that_of_its_frequency_twice() {
    let model = chain(&[100.0]);
    let test = measured(&model, &[121.0], 0.003, false);
    let measured = [MeasuredModes::new("t", &test)];
    let options = UpdateOptions {
        frequency_floor: 0.004,
        ..options()
    };
    let problem =
        UpdateProblem::new(&model, &[100.0], &free(&["k1"]), &measured, &[], options).unwrap();
    let found = update(&problem).unwrap();
    let k = &found.parameters[0];
    assert_eq!((k.verdict, k.held), (ParameterVerdict::Identified, false));
    // f is known to 0.5 %, so k to 1 %; with the prior of 30 % in parallel 1/sqrt(1/0.01^2 +
    // 1/0.3^2).
    let expected = (1.0f64 / 1e-4 + 1.0 / 0.09).sqrt().recip();
    assert!((k.std / k.updated - expected).abs() < 1e-3 * expected);
    let row = &found.after.rows[0];
    let hz_std = row.model_std_hz.unwrap() / row.model_hz.unwrap();
    assert!((hz_std - 0.5 * expected).abs() < 1e-3 * expected);
    assert!((k.interval_95.0 / k.updated).ln() + 1.96 * expected < 1e-4);
    assert_eq!((found.starts.count, found.starts.reached), (3, 3));
    assert!(found.before.largest_percent.unwrap() > 9.0);
    assert!(found.after.largest_percent.unwrap() < 0.05);
}

#[test]
fn a_parameter_that_no_residual_depends_on_is_named_and_stays_where_it_was() {
    // The test has the first mode of a chain whose last spring is all but rigid.
    let start = [100.0, 100.0, 1e9];
    let model = chain(&start);
    let mut test = measured(&model, &[130.0, 100.0, 1e9], 1e-3, false);
    test.modes.truncate(2);
    let measured = [MeasuredModes::new("t", &test)];
    let chosen = free(&["k1", "k3", "k2"]);
    let sensors = sensors(&model, &start);
    let problem =
        UpdateProblem::new(&model, &start, &chosen, &measured, &sensors, options()).unwrap();
    let found = update(&problem).unwrap();
    let verdicts: Vec<ParameterVerdict> = found.parameters.iter().map(|p| p.verdict).collect();
    use ParameterVerdict::{Identified, NotSupported};
    assert_eq!(verdicts, [Identified, NotSupported, Identified]);
    let unseen = &found.parameters[1];
    assert!(unseen.held);
    assert_eq!(unseen.updated.to_bits(), unseen.initial.to_bits());
    assert!((unseen.std / unseen.prior_std - 1.0).abs() < 1e-6);
    assert!((found.parameters[0].updated / 130.0 - 1.0).abs() < 0.01);
}

#[test]
fn parameters_that_the_data_know_only_together_are_named_with_their_combination() {
    // One mode of two springs: their combination is known, their ratio is not.
    let start = [100.0, 100.0];
    let model = chain(&start);
    let mut test = measured(&model, &[120.0, 120.0], 1e-3, false);
    test.modes.truncate(1);
    let measured = [MeasuredModes::new("t", &test)];
    let sensors = sensors(&model, &start);
    let chosen = free(&["k1", "k2"]);
    let problem =
        UpdateProblem::new(&model, &start, &chosen, &measured, &sensors, options()).unwrap();
    let found = update(&problem).unwrap();
    let [known, unknown] = &found.combinations[..] else {
        panic!("two combinations: {:?}", found.combinations)
    };
    assert!(known.known && known.posterior_over_prior < 0.02 && known.parts.len() == 2);
    assert!(!unknown.known && (unknown.posterior_over_prior - 1.0).abs() < 1e-12);
    assert!(
        unknown.text.contains("not determined by the data"),
        "{}",
        unknown.text
    );
    // k2 hardly moves the first mode, but both are seen; only k1, which has the larger effect, is
    // determined beyond the prior.
    assert!(
        found
            .parameters
            .iter()
            .all(|p| !p.held && p.verdict != ParameterVerdict::AtBound)
    );
    assert!(
        found
            .parameters
            .iter()
            .any(|p| p.verdict == ParameterVerdict::NotSupported)
    );
    assert!(found.after.largest_percent.unwrap() < 0.1);
    assert!(found.correlation[0][1] < 0.0);
}

#[test]
fn a_misfit_that_remains_is_a_warning_however_small_the_deviations() {
    // A chain of three equal springs scaled by one of them cannot have frequencies of other ratios.
    let start = [100.0, 100.0, 100.0];
    let model = chain(&start);
    let sensors = sensors(&model, &start);
    let result = |truth: &[f64]| {
        let test = measured(&model, truth, 1e-3, false);
        let measured = [MeasuredModes::new("t", &test)];
        let chosen = free(&["k1"]);
        let new = UpdateProblem::new(&model, &start, &chosen, &measured, &sensors, options());
        update(&new.unwrap()).unwrap()
    };
    let misfit_finding = |result: &UpdateResult| {
        let findings = result.findings();
        let found = findings.iter().find(|f| f.code == Code::MisfitRemains);
        found.map(|f| (f.severity, f.value))
    };
    let wrong = result(&[100.0, 130.0, 100.0]);
    assert_eq!(wrong.parameters[0].verdict, ParameterVerdict::NotSupported);
    // Three frequencies less the one stiffness that they determine.
    assert!((wrong.degrees_of_freedom() - 2.0).abs() < 1e-3);
    let expected = wrong.after.chi_square / wrong.degrees_of_freedom();
    assert!(expected > 10.0, "{expected}");
    assert_eq!(
        misfit_finding(&wrong),
        Some((Severity::Warning, Some(expected)))
    );
    let right = result(&[130.0, 100.0, 100.0]);
    assert!(right.fits() && misfit_finding(&right).is_none());
}

#[test]
fn where_nothing_is_seen_there_is_no_history_of_a_discarded_optimum() {
    // The only mode that was measured is far below what the last spring moves.
    let start = [100.0, 1e9];
    let model = chain(&start);
    let mut test = measured(&model, &[130.0, 1e9], 1e-3, false);
    test.modes.truncate(1);
    let measured = [MeasuredModes::new("t", &test)];
    let sensors = sensors(&model, &start);
    let chosen = free(&["k2"]);
    let problem =
        UpdateProblem::new(&model, &start, &chosen, &measured, &sensors, options()).unwrap();
    let found = update(&problem).unwrap();
    assert!(found.parameters[0].held);
    assert_eq!(found.stop_reason, StopReason::NothingSeen);
    assert!(found.history.is_empty() && found.pairing_changes.is_empty());
    assert!(
        found
            .values
            .iter()
            .zip(start)
            .all(|(a, b)| a.to_bits() == b.to_bits())
    );
}

#[test]
fn labels_are_the_numbers_that_were_given_and_errors_have_the_stated_reference() {
    let values = [100.0, 200.0];
    let model = chain(&values);
    let test = measured(&model, &[121.0, 242.0], 1e-3, false);
    let measured = [MeasuredModes {
        numbers: &[4, 7],
        ..MeasuredModes::new("t", &test)
    }];
    let sensors = sensors(&model, &values);
    for (reference, expected) in [
        (ErrorReference::Theory, 10.0),
        (ErrorReference::Test, -100.0 / 11.0),
    ] {
        let mut options = options();
        options.pair.error_reference = reference;
        let chosen = free(&["k1", "k2"]);
        let new = UpdateProblem::new(&model, &values, &chosen, &measured, &sensors, options);
        let rows = update(&new.unwrap()).unwrap().before.rows;
        let labels: Vec<&str> = rows.iter().map(|row| row.label.as_str()).collect();
        assert_eq!(labels, ["t f4", "t f7"]);
        for row in rows {
            assert!(
                (row.error_percent.unwrap() - expected).abs() < 1e-9,
                "{row:?}"
            );
        }
    }
}

#[test]
fn a_measured_mode_without_a_partner_is_named_in_the_findings() {
    let model = chain(&[100.0, 200.0]);
    let values = [100.0, 200.0];
    let sensors = sensors(&model, &values);
    let test = measured(&model, &[104.0, 200.0], 1e-3, true);
    let measured = [MeasuredModes::new("t", &test)];
    let chosen = free(&["k1"]);
    let new = UpdateProblem::new(&model, &values, &chosen, &measured, &sensors, options());
    let mut found = update(&new.unwrap()).unwrap();
    let lost = |result: &UpdateResult| {
        let findings = result.findings().into_iter();
        let places = findings.filter(|f| f.code == Code::PartnerLost);
        places.map(|f| f.location).collect::<Vec<_>>()
    };
    assert_eq!((found.after.paired(), lost(&found)), (2, Vec::new()));
    found.after.rows[1].model_hz = None;
    let expected = vec![Location::Mode(test.modes[1].frequency_hz)];
    assert_eq!((found.after.paired(), lost(&found)), (1, expected));
}

#[test]
fn values_of_reversed_sensors_take_no_part() {
    let start = [100.0; 10];
    let model = chain(&start);
    let mut truth = start;
    truth[3] = 140.0;
    truth[7] = 75.0;
    let sensors = sensors(&model, &start);
    let updated = |dofs: &[&str]| {
        let dofs: Vec<Dof> = dofs.iter().map(|dof| dof.parse().unwrap()).collect();
        let test = reverse_sensors(&measured(&model, &truth, 1e-2, true), &dofs);
        let measured = [MeasuredModes::new("t", &test)];
        let chosen = free(&["k4", "k8"]);
        let new = UpdateProblem::new(&model, &start, &chosen, &measured, &sensors, options());
        update(&new.unwrap()).unwrap()
    };
    let as_measured = updated(&[]);
    let is_left_out = |finding: &Finding| finding.code == Code::ReversedLeftOut;
    assert!(!as_measured.findings().iter().any(is_left_out));
    let reversed = updated(&["m3:+X", "m6:+X"]);
    let findings = reversed.findings();
    let left_out = findings
        .iter()
        .find(|finding| is_left_out(finding))
        .unwrap();
    assert_eq!(left_out.value, Some(2.0));
    assert_eq!(left_out.detail.as_deref(), Some("t: m3:+X, m6:+X"));
    assert!(reversed.after.data_count < as_measured.after.data_count);
    for (parameter, truth) in reversed.parameters.iter().zip([140.0, 75.0]) {
        assert!(
            (parameter.updated / truth - 1.0).abs() < 0.01,
            "{parameter:?}"
        );
    }
}

#[test]
fn covariance_of_a_known_sensitivity_is_its_closed_form() {
    let model = chain(&[100.0, 200.0]);
    let values = [100.0, 200.0];
    let test = measured(&model, &values, 1e-3, false);
    let measured = [MeasuredModes::new("t", &test)];
    let chosen = free(&["k1", "k2"]);
    let new = UpdateProblem::new(&model, &values, &chosen, &measured, &[], options());
    let free = new.unwrap().free;
    // J = (3, 4): the direction (0.6, 0.8) has s = 5, the other one none.
    let jacobian = real_matrix(1, 2, |_, j| if j == 0 { 3.0 } else { 4.0 });
    let known = Identifiability::new(&jacobian, &free).unwrap();
    let left = 1.0 / 26.0;
    let expected = [0.36 * left + 0.64, 0.64 * left + 0.36];
    for (ratio, expected) in known.ratio.iter().zip(expected) {
        assert!((ratio * ratio - expected).abs() < 1e-14);
    }
    assert!((known.ratio_alone[0] - 0.1f64.sqrt()).abs() < 1e-15);
    assert!((known.covariance[(0, 1)] - 0.48 * (left - 1.0)).abs() < 1e-14);
    assert_eq!(known.combinations[0].parts[0].0, "k2");
    assert!((known.combinations[0].parts[0].1 - 0.8).abs() < 1e-14);
    let judged = |model_error, is_ambiguous| Judged {
        known: &known,
        kept: &[0, 1],
        ratio: &known.ratio,
        is_supported: true,
        model_error,
        ambiguous: vec![is_ambiguous; 2],
    };
    assert!(known.seen(0) && judged(None, false).verdict(1, true) == ParameterVerdict::AtBound);
    assert_eq!(
        judged(None, false).verdict(0, false),
        ParameterVerdict::NotSupported
    );
    let jacobian = real_matrix(2, 2, |i, j| if i == j { 10.0 } else { 0.0 });
    let known = Identifiability::new(&jacobian, &free).unwrap();
    let verdict = |model_error, is_ambiguous| {
        let judged = Judged {
            known: &known,
            ratio: &known.ratio,
            ..judged(model_error, is_ambiguous)
        };
        judged.verdict(0, false)
    };
    assert_eq!(verdict(None, false), ParameterVerdict::Identified);
    assert_eq!(verdict(None, true), ParameterVerdict::Ambiguous);
    assert_eq!(
        verdict(Some(5.0), false),
        ParameterVerdict::IdentifiedWithinModelError
    );
    assert_eq!(verdict(Some(2.0), false), ParameterVerdict::NotSupported);
}

#[test]
fn a_mode_of_the_mount_is_left_out_where_the_update_fits_only_without_it() {
    let start = [100.0; 3];
    let model = chain(&start);
    let result = |third: f64| {
        let mut test = measured(&model, &[120.0, 100.0, 100.0], 1e-3, false);
        // The third mode of the model was not measured; what was is a quarter below it.
        test.modes[2].frequency_hz *= third;
        let modes = [MeasuredModes::new("t", &test)];
        let chosen = free(&["k1"]);
        let new = UpdateProblem::new(&model, &start, &chosen, &modes, &[], options());
        update(&new.unwrap()).unwrap()
    };
    let whole = result(1.0);
    assert!(whole.fits() && whole.left_out.is_empty());
    let part = result(0.75);
    assert!(part.fits(), "{:?}", part.model_errors);
    assert_eq!(part.left_out.len(), 1);
    assert_eq!(part.left_out[0].0, "t f3");
    assert!((part.parameters[0].updated / 120.0 - 1.0).abs() < 1e-3);
}

#[test]
fn one_of_many_starts_at_the_lowest_optimum_identifies_nothing() {
    let start = [100.0, 200.0, 300.0];
    let model = chain(&start);
    let test = measured(&model, &start, 1e-3, false);
    let modes = [MeasuredModes::new("t", &test)];
    // The first start is the truth; one iteration leads no other one there.
    let result = |starts: usize| {
        let options = UpdateOptions {
            starts,
            max_iterations: 1,
            ..UpdateOptions::default()
        };
        let free = free(&["k1", "k2", "k3"]);
        update(&UpdateProblem::new(&model, &start, &free, &modes, &[], options).unwrap()).unwrap()
    };
    let verdicts = |result: &UpdateResult| -> Vec<ParameterVerdict> {
        let parameters = result.parameters.iter();
        parameters.map(|parameter| parameter.verdict).collect()
    };
    let of_many = result(6);
    assert_eq!((of_many.starts.count, of_many.starts.reached), (6, 1));
    assert!(of_many.starts.is_scattered());
    assert_eq!(verdicts(&of_many), [ParameterVerdict::NotSupported; 3]);
    let of_few = result(4);
    assert_eq!(of_few.starts.reached, 1);
    assert_eq!(verdicts(&of_few), [ParameterVerdict::Identified; 3]);
}

#[test]
fn uncertainties_that_exceed_the_errors_are_named() {
    let ratio = uncertainties_over_errors(0.9486, 64.0).unwrap();
    assert!((ratio - 8.21).abs() < 0.01, "{ratio}");
    assert!(uncertainties_over_errors(64.0 / 81.0, 64.0).is_some());
    assert!(uncertainties_over_errors(0.8 * 64.0, 64.0).is_none());
    // Of two residuals noise often leaves as little.
    assert!(uncertainties_over_errors(0.2, 2.0).is_none());
    assert!(uncertainties_over_errors(0.0, 64.0).is_none());
}
