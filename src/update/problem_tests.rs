//! Residuals against closed forms, derivatives against differences.

use crate::linalg::SparseMatrix;
use crate::modal::{ModalModel, Mode, ModeShape, Scaling};
use crate::theory::{
    ExternalMatrices, ExternalModel, MatrixSet, ParameterSpec, ParameterStatus, TheoreticalModel,
    built_in, nominal_values,
};

use super::test_models::{against_differences, chain, free, measured, sensors};
use super::*;

/// Rotations count by a length of 0.1 m beside translations.
fn options() -> UpdateOptions {
    let mut options = UpdateOptions::default();
    options.pair.rotation_length_m = Some(0.1);
    options
}

#[test]
fn residuals_of_one_spring_are_those_of_the_square_root_of_its_stiffness() {
    let model = chain(&[100.0]);
    let test = measured(&model, &[121.0], 0.003, false);
    let measured = [MeasuredModes::new("t", &test)];
    let options = UpdateOptions {
        frequency_floor: 0.004,
        ..options()
    };
    let problem =
        UpdateProblem::new(&model, &[100.0], &free(&["k1"]), &measured, &[], options).unwrap();
    // Deviation of 0.3 % and floor of 0.4 %: 0.5 %; the model is at 10/11 of the test.
    let at = problem.start(&[0.0]).unwrap();
    assert!((at.residual[0] + (1.0 / 11.0) / 0.005).abs() < 1e-9);
    // A log-normal prior of 30 %: 21 % more stiffness is ln(1.21)/0.3 of it.
    let z = 1.21f64.ln() / 0.3;
    let at = problem.start(&[z]).unwrap();
    assert!(at.chi_square() < 1e-18 && (at.objective() - z * z).abs() < 1e-12);
    // d ln f/dz = 0.15.
    let jacobian = problem.jacobian(&at).unwrap();
    assert!((jacobian[(0, 0)] - 0.15 / 0.005).abs() < 1e-9);
    assert!((jacobian[(1, 0)] - 1.0).abs() < 1e-15);
}

#[test]
fn a_shape_residual_squared_is_one_minus_mac_over_its_variance() {
    let values = [100.0, 200.0, 300.0];
    let model = chain(&values);
    let sensors = sensors(&model, &values);
    let test = measured(&model, &[140.0, 150.0, 330.0], 0.001, true);
    let measured = [MeasuredModes::new("t", &test)];
    let chosen = free(&["k1", "k2", "k3"]);
    let new = |options| UpdateProblem::new(&model, &values, &chosen, &measured, &sensors, options);
    let with = new(options()).unwrap();
    let without = new(UpdateOptions {
        shape_floor: None,
        ..options()
    });
    let without = without.unwrap();
    let (a, b) = (
        with.start(&[0.0; 3]).unwrap(),
        without.start(&[0.0; 3]).unwrap(),
    );
    let macs = with.fits(&a).into_iter().map(|fit| fit.unwrap().1.unwrap());
    // Three components of root mean square 1 with the assumed 5 % and a floor of 2 %.
    let expected: f64 = macs.map(|mac| 3.0 * (1.0 - mac) / 0.0029).sum();
    assert!(expected > 10.0);
    assert!((a.chi_square() - b.chi_square() - expected).abs() < 1e-9 * expected);
    assert_eq!((with.data_count(&a), without.data_count(&b)), (9, 3));
}

#[test]
fn derivatives_are_those_of_differences_with_shapes_of_every_machine() {
    for (name, chosen) in [
        (
            "cycloid-ball/D",
            vec!["m_3", "k_03y", "trochoid_ratio", "pin_circle_radius", "k_a"],
        ),
        ("spider-reducer", vec![]),
        (
            "torsional-planetary",
            vec!["m_c", "m_r", "m_s", "k_r", "k_s"],
        ),
    ] {
        let model = built_in(name).unwrap();
        let values = nominal_values(model.parameters());
        let all: Vec<&str> = model.parameters().iter().map(|p| p.name.as_str()).collect();
        let chosen = if chosen.is_empty() {
            all[..6].to_vec()
        } else {
            chosen
        };
        let test = measured(model.as_ref(), &values, 0.001, true);
        let sensors = sensors(model.as_ref(), &values);
        let measured = [MeasuredModes::new("t", &test)];
        let chosen = free(&chosen);
        let new = UpdateProblem::new(
            model.as_ref(),
            &values,
            &chosen,
            &measured,
            &sensors,
            options(),
        );
        let z = vec![0.1; chosen.len()];
        let worst = against_differences(&new.unwrap(), &z);
        // A step of 1e-4 leaves rounding of about 1e-12/1e-4 of residuals of some hundred.
        assert!(worst < 1e-5, "{name}: {worst}");
    }
}

#[test]
fn a_repeated_root_is_compared_by_its_mean_and_its_splits() {
    // Three planet modes of one root.
    let model = built_in("torsional-planetary").unwrap();
    let values = nominal_values(model.parameters());
    let mut test = measured(model.as_ref(), &values, 0.001, false);
    let root = test.modes[1].frequency_hz;
    for (mode, split) in test.modes[1..4].iter_mut().zip([0.01, 0.0, 0.02]) {
        mode.frequency_hz = root * (1.0 + split);
    }
    let options = UpdateOptions {
        frequency_floor: 0.0,
        ..options()
    };
    let chosen = free(&["m_p"]);
    let chi_square = |test: &ModalModel| {
        let measured = [MeasuredModes::new("t", test)];
        let new = UpdateProblem::new(
            model.as_ref(),
            &values,
            &chosen,
            &measured,
            &[],
            options.clone(),
        );
        let problem = new.unwrap();
        let at = problem.start(&[0.0]).unwrap();
        let sizes: Vec<usize> = at
            .root_pairs
            .iter()
            .map(|root_pair| root_pair.targets.len())
            .collect();
        (at.chi_square(), sizes)
    };
    // Each is (1 - s)/0.001 of a deviation off, s = 1, 1.01, 1.02; mean and splits have the same
    // sum of squares.
    let (chi, sizes) = chi_square(&test);
    assert!((chi - 500.0).abs() < 1e-6, "{chi}");
    assert_eq!(sizes, [1, 3, 1, 1]);
    // Two of the three: their mean alone, 0.005 or 5 deviations of one off, squared and twice.
    let mut two = test.clone();
    two.modes.remove(3);
    let (chi, sizes) = chi_square(&two);
    assert!((chi - 50.0).abs() < 1e-6, "{chi}");
    assert_eq!(sizes, [1, 2, 1, 1]);
    // A group of one number is one frequency, compared with the mean of the root.
    for mode in &mut test.modes[1..4] {
        mode.group = Some(7);
        mode.frequency_hz = 1.02 * root;
    }
    let (chi, sizes) = chi_square(&test);
    assert!((chi - 400.0).abs() < 1e-6, "{chi}");
    assert_eq!(sizes, [1, 1, 1, 1]);
}

#[test]
fn unpaired_modes_are_left_out_and_no_pair_at_all_is_an_error() {
    let model = chain(&[100.0]);
    let mut test = measured(&model, &[100.0], 0.001, false);
    let mut far = test.modes[0].clone();
    far.frequency_hz *= 3.0;
    test.modes.push(far);
    let with_shapes = [MeasuredModes::new("t", &test)];
    let problem = UpdateProblem::new(
        &model,
        &[100.0],
        &free(&["k1"]),
        &with_shapes,
        &[],
        options(),
    )
    .unwrap();
    assert_eq!((problem.targets.len(), problem.left_out.len()), (1, 1));
    let alone = ModalModel {
        modes: vec![test.modes[1].clone()],
        ..ModalModel::default()
    };
    let measured = [MeasuredModes::new("t", &alone)];
    let error = UpdateProblem::new(&model, &[100.0], &free(&["k1"]), &measured, &[], options());
    assert!(matches!(
        error,
        Err(UpdateError::NothingPaired { modes: 1 })
    ));
}

#[test]
fn a_measured_mode_that_loses_its_partner_costs_more_than_any_partner_leaves() {
    let values = [100.0, 200.0, 300.0];
    let model = chain(&values);
    let sensors = sensors(&model, &values);
    let test = measured(&model, &values, 0.003, true);
    let measured = [MeasuredModes::new("t", &test)];
    let options = UpdateOptions {
        frequency_floor: 0.004,
        ..options()
    };
    let chosen = free(&["k1", "k2", "k3"]);
    let new = UpdateProblem::new(&model, &values, &chosen, &measured, &sensors, options);
    let problem = new.unwrap();
    let at = problem.start(&[0.0; 3]).unwrap();
    let with_all = problem.data_count(&at);
    let mut root_pairs = at.root_pairs.clone();
    root_pairs.remove(1);
    let lost = problem.at_root_pairs(&[0.0; 3], root_pairs).unwrap();
    // A frequency off by all of itself at 0.5 %; three components of root mean square 1 at the
    // assumed 5 % and a floor of 2 %.
    let expected = 1.0 / 0.005f64.powi(2) + 3.0 / 0.0029;
    let cost = lost.chi_square() - at.chi_square();
    assert!((cost / expected - 1.0).abs() < 1e-9, "{cost}");
    assert_eq!(problem.data_count(&lost), with_all);
    assert!(problem.fits(&lost)[1].is_none());
    // They do not depend on a parameter.
    let jacobian = problem.jacobian(&lost).unwrap();
    let rows = lost.data_rows - 4..lost.data_rows;
    for row in rows {
        assert!((0..3).all(|j| jacobian[(row, j)].abs() < f64::MIN_POSITIVE));
    }
}

#[test]
fn a_start_pairs_nothing_beyond_half_and_twice_the_frequency() {
    let values = [100.0, 200.0, 300.0];
    let model = chain(&values);
    let sensors = sensors(&model, &values);
    let test = measured(&model, &values, 0.001, true);
    let measured = [MeasuredModes::new("t", &test)];
    let chosen = free(&["k1", "k2", "k3"]);
    let new = UpdateProblem::new(&model, &values, &chosen, &measured, &sensors, options());
    let problem = new.unwrap();
    let paired = |stiffer: f64| {
        let z = stiffer.ln() / 0.3;
        problem.start(&[z; 3]).unwrap().root_pairs.len()
    };
    // All springs alike leave the shapes as they are; frequencies go with the square root.
    for (stiffer, expected) in [(1.9, 3), (3.9, 3), (4.1, 0), (9.0, 0), (1.0 / 4.1, 0)] {
        assert_eq!(paired(stiffer), expected, "{stiffer}");
    }
}

#[test]
fn parameters_that_cannot_be_meant_are_named() {
    let model = chain(&[100.0]);
    let test = measured(&model, &[100.0], 0.001, false);
    let sets = [MeasuredModes::new("t", &test)];
    let new = |choices: &[ParameterChoice], options| {
        UpdateProblem::new(&model, &[100.0], choices, &sets, &[], options).unwrap_err()
    };
    assert!(matches!(new(&[], options()), UpdateError::NothingFree));
    assert!(matches!(
        new(&free(&["k9"]), options()),
        UpdateError::Parameter { name, .. } if name == "k9"
    ));
    assert!(matches!(
        new(&free(&["k1", "k1"]), options()),
        UpdateError::Parameter { .. }
    ));
    let choice = |change: fn(&mut ParameterChoice)| {
        let mut choices = free(&["k1"]);
        change(&mut choices[0]);
        choices
    };
    let above = choice(|parameter| parameter.lower = Some(101.0));
    assert!(matches!(new(&above, options()), UpdateError::Bounds { .. }));
    let flat = choice(|parameter| parameter.prior = Some(Prior::Normal { std: 0.0 }));
    assert!(matches!(
        new(&flat, options()),
        UpdateError::PriorDeviation { .. }
    ));
    // A stated deviation keeps the kind of the default.
    let narrow = choice(|parameter| parameter.prior_std = Some(0.1));
    let problem = UpdateProblem::new(&model, &[100.0], &narrow, &sets, &[], options()).unwrap();
    assert_eq!(problem.free[0].prior, Prior::LogNormal { std: 0.1 });
    let flat = choice(|parameter| parameter.prior_std = Some(-0.1));
    assert!(matches!(
        new(&flat, options()),
        UpdateError::PriorDeviation { .. }
    ));
    let bad = UpdateOptions {
        frequency_floor: f64::NAN,
        ..options()
    };
    assert!(matches!(
        new(&free(&["k1"]), bad),
        UpdateError::Option {
            name: "frequency_floor",
            ..
        }
    ));
    let mut silent = test.clone();
    silent.modes[0].frequency_std_hz = None;
    let measured = [MeasuredModes::new("t", &silent)];
    let exact = UpdateOptions {
        frequency_floor: 0.0,
        ..options()
    };
    let error = UpdateProblem::new(&model, &[100.0], &free(&["k1"]), &measured, &[], exact);
    assert!(matches!(error, Err(UpdateError::NoUncertainty { .. })));
}

/// Oscillators of 1 kg at 10, 20, 30 ... Hz, whose stiffnesses one parameter scales: more than are
/// solved with full matrices.
fn oscillators() -> ExternalModel {
    let size = 1100;
    let diagonal = |value: &dyn Fn(usize) -> f64| {
        let entries: Vec<_> = (0..size).map(|i| (i, i, value(i))).collect();
        SparseMatrix::from_entries(size, &entries).ok()
    };
    let stiffness = |i: usize| (std::f64::consts::TAU * 10.0 * (i + 1) as f64).powi(2);
    let scaled = MatrixSet {
        stiffness: diagonal(&stiffness),
        ..MatrixSet::default()
    };
    let model = ExternalModel::new(ExternalMatrices {
        title: "oscillators".to_owned(),
        dofs: (1..=size)
            .map(|i| format!("{i}:+X").parse().unwrap())
            .collect(),
        fixed: MatrixSet {
            mass: diagonal(&|_| 1.0),
            ..MatrixSet::default()
        },
        parameters: vec![ParameterSpec {
            name: "k".to_owned(),
            unit: "1".to_owned(),
            nominal: 1.0,
            lower: Some(0.5),
            upper: Some(2.0),
            status: ParameterStatus::Assumed,
            whole: false,
        }],
        groups: vec![("k".to_owned(), scaled)],
        ..ExternalMatrices::default()
    });
    model.unwrap()
}

#[test]
fn of_a_sparse_model_all_roots_that_the_test_can_have_are_seen() {
    let model = oscillators();
    assert!(model.sparse(&[1.0]).unwrap().is_some());
    let mode = |hz: f64| Mode {
        frequency_std_hz: Some(0.001 * hz),
        ..Mode::new(hz, None, ModeShape::default(), Scaling::Unknown)
    };
    // The 12th, the 45th and the 80th root, 0.2 % off: thirty are solved where no band is stated.
    let test = ModalModel {
        modes: [120.24, 450.9, 801.6].map(mode).to_vec(),
        ..ModalModel::default()
    };
    let measured = [MeasuredModes::new("t", &test)];
    let problem =
        UpdateProblem::new(&model, &[1.0], &free(&["k"]), &measured, &[], options()).unwrap();
    assert_eq!(problem.left_out, []);
    let labels: Vec<&str> = problem
        .targets
        .iter()
        .map(|target| target.label.as_str())
        .collect();
    assert_eq!(labels, ["t f1", "t f2", "t f3"]);
    let root_pairs = problem
        .root_pairs(&[vec![1.0]], &problem.options.pair)
        .unwrap();
    let modes: Vec<&[usize]> = root_pairs
        .iter()
        .map(|root_pair| root_pair.modes.as_slice())
        .collect();
    assert_eq!(modes, [[11], [44], [79]]);
}
