//! Configurations with shared parameters: their joint information, what separates them, and
//! contradictions.

use crate::geometry::Sensor;
use crate::modal::ModalModel;
use crate::theory::{LumpedModel, ModeOptions, TheoreticalModel, modes};

use super::test_models::{against_differences, chain, chain_of, free, measured, sensors};
use super::*;

const START: [f64; 3] = [100.0, 200.0, 300.0];
/// Deviation of the frequencies.
const STD: f64 = 1e-3;

fn options() -> UpdateOptions {
    UpdateOptions {
        frequency_floor: 0.0,
        shape_floor: None,
        starts: 4,
        ..UpdateOptions::default()
    }
}

/// A chain alone and with 0.5 kg more at its end.
fn models() -> [LumpedModel; 2] {
    [chain(&START), chain_of(&[1.0, 1.0, 1.5], &START)]
}

/// What a configuration measures of a model with these stiffnesses, and its sensors.
struct Measured {
    test: ModalModel,
    sensors: Vec<Sensor>,
}

fn measured_of(models: &[LumpedModel; 2], truths: [&[f64]; 2], shapes: bool) -> Vec<Measured> {
    let pairs = models.iter().zip(truths);
    let of = |(model, truth): (&LumpedModel, &[f64])| Measured {
        test: measured(model, truth, STD, shapes),
        sensors: sensors(model, truth),
    };
    pairs.map(of).collect()
}

/// Runs a check on the problem of two configurations, the parameters of the second one separate or
/// held.
fn with_problem<T>(
    models: &[LumpedModel; 2],
    data: &[Measured],
    [held, separate]: [&[&str]; 2],
    options: UpdateOptions,
    check: impl FnOnce(UpdateProblem<'_>) -> T,
) -> Result<T, UpdateError> {
    let names = |names: &[&str]| names.iter().map(ToString::to_string).collect::<Vec<_>>();
    let (held, separate) = (names(held), names(separate));
    let sets: Vec<[MeasuredModes<'_>; 1]> = data
        .iter()
        .zip(["alone", "loaded"])
        .map(|(data, name)| [MeasuredModes::new(name, &data.test)])
        .collect();
    let configuration = |c: usize| Configuration {
        name: ["base", "with mass"][c],
        model: &models[c],
        values: &START,
        sensors: &data[c].sensors,
        measured: &sets[c],
        held: if c == 0 { &[] } else { &held },
        separate: if c == 0 { &[] } else { &separate },
    };
    let configurations = [configuration(0), configuration(1)];
    let chosen = free(&["k1", "k2", "k3"]);
    UpdateProblem::of_configurations(&configurations, &chosen, options).map(check)
}

/// `ln f` of the elastic modes.
fn logarithms(model: &dyn TheoreticalModel, values: &[f64]) -> Vec<f64> {
    let solved = modes(model, values, &[], &ModeOptions::default()).unwrap();
    let modes = solved.model.modes.iter();
    modes.map(|mode| mode.frequency_hz.ln()).collect()
}

#[test]
fn deviations_of_two_configurations_are_those_of_their_joint_information() {
    let models = models();
    let truth = [120.0, 180.0, 330.0];
    let data = measured_of(&models, [&truth, &truth], false);
    let result = with_problem(&models, &data, [&[], &[]], options(), |problem| {
        update(&problem).unwrap()
    });
    let result = result.unwrap();
    // Information by differences of ln f by ln k at the result, with priors of 0.3 in ln k.
    let at = [0, 1, 2].map(|j| result.parameters[j].updated);
    let mut information = [[0.0; 3]; 3];
    for (j, row) in information.iter_mut().enumerate() {
        row[j] = 0.3f64.powi(-2);
    }
    let mut alone = Vec::new();
    for model in &models {
        let slope = |j: usize| -> Vec<f64> {
            let moved = |h: f64| {
                let mut values = at;
                values[j] *= h.exp();
                logarithms(model, &values)
            };
            let (up, down) = (moved(1e-4), moved(-1e-4));
            up.iter().zip(&down).map(|(u, d)| (u - d) / 2e-4).collect()
        };
        let slopes: Vec<Vec<f64>> = (0..3).map(slope).collect();
        let mut part = [[0.0; 3]; 3];
        for i in 0..3 {
            part[i][i] = 0.3f64.powi(-2);
            for j in 0..3 {
                let pairs = slopes[i].iter().zip(&slopes[j]);
                let product = pairs.map(|(a, b)| a * b).sum::<f64>() / (STD * STD);
                information[i][j] += product;
                part[i][j] += product;
            }
        }
        alone.push(variances(&part));
    }
    let joint = variances(&information);
    for (j, parameter) in result.parameters.iter().enumerate() {
        let expected = joint[j].sqrt() * parameter.updated;
        assert!(
            (parameter.std / expected - 1.0).abs() < 2e-4,
            "{parameter:?} {expected}"
        );
        assert_eq!(parameter.verdict, ParameterVerdict::Identified);
        assert!((parameter.updated / truth[j] - 1.0).abs() < 1e-3);
        for (c, contribution) in result.contributions.iter().enumerate() {
            let expected = alone[c][j].sqrt() * parameter.updated;
            let got = contribution.std_alone[j].unwrap();
            assert!((got / expected - 1.0).abs() < 2e-4, "{got} {expected}");
        }
    }
    assert_eq!(result.contradiction, None);
}

/// Diagonal of the inverse of a symmetric matrix of three rows.
fn variances(a: &[[f64; 3]; 3]) -> [f64; 3] {
    let minor = |i: usize, j: usize| {
        let row = |skip: usize| (0..3).filter(move |k| *k != skip);
        let (r, c): (Vec<usize>, Vec<usize>) = (row(i).collect(), row(j).collect());
        a[r[0]][c[0]] * a[r[1]][c[1]] - a[r[0]][c[1]] * a[r[1]][c[0]]
    };
    let determinant = a[0][0] * minor(0, 0) - a[0][1] * minor(0, 1) + a[0][2] * minor(0, 2);
    [0, 1, 2].map(|j| minor(j, j) / determinant)
}

#[test]
fn a_stiffness_that_differs_between_configurations_is_named_with_its_values() {
    let models = models();
    let (base, other) = ([120.0, 180.0, 330.0], [120.0, 144.0, 330.0]);
    let data = measured_of(&models, [&base, &other], false);
    let result = with_problem(&models, &data, [&[], &[]], options(), |problem| {
        update(&problem).unwrap()
    });
    let result = result.unwrap();
    let found = result.contradiction.clone().unwrap();
    assert_eq!(
        (&*found.parameter, &*found.configuration),
        ("k2", "with mass")
    );
    assert!((found.there / 144.0 - 1.0).abs() < 0.01, "{found:?}");
    assert!((found.elsewhere / 180.0 - 1.0).abs() < 0.01, "{found:?}");
    let supported = |p: &UpdatedParameter| p.verdict != ParameterVerdict::NotSupported;
    assert!(!result.parameters.iter().any(supported));
    // Separate, it has both values and nothing contradicts.
    let result = with_problem(&models, &data, [&[], &["k2"]], options(), |problem| {
        update(&problem).unwrap()
    });
    let result = result.unwrap();
    assert_eq!(result.contradiction, None);
    let names: Vec<&str> = result.parameters.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["k1", "k2", "k3", "k2 (with mass)"]);
    for (parameter, truth) in result.parameters.iter().zip([120.0, 180.0, 330.0, 144.0]) {
        assert!(
            (parameter.updated / truth - 1.0).abs() < 1e-3,
            "{parameter:?}"
        );
        assert_eq!(parameter.verdict, ParameterVerdict::Identified);
    }
    assert!((result.configuration_values[0][1] / 180.0 - 1.0).abs() < 1e-3);
    assert!((result.configuration_values[1][1] / 144.0 - 1.0).abs() < 1e-3);
    // The uncertainty is that of the model of the base.
    assert_eq!(result.uncertainty().names, ["k1", "k2", "k3"]);
}

#[test]
fn a_held_parameter_keeps_the_value_of_its_configuration() {
    let models = models();
    let data = measured_of(&models, [&[120.0, 180.0, 300.0], &START], false);
    let held = ["k1", "k2"];
    let result = with_problem(&models, &data, [&held, &[]], options(), |problem| {
        update(&problem).unwrap()
    });
    let result = result.unwrap();
    assert_eq!(result.configuration_values[1][..2], START[..2]);
    assert!((result.values[0] / 120.0 - 1.0).abs() < 1e-3);
    assert_eq!(result.contributions[1].std_alone[..2], [None; 2]);
}

#[test]
fn two_configurations_of_one_model_are_two_tests_of_it() {
    let truth = [120.0, 180.0, 330.0];
    let models = [chain(&START), chain(&START)];
    let data = measured_of(&models, [&truth, &truth], true);
    let with_shapes = UpdateOptions {
        shape_floor: Some(1e-9),
        assumed_shape_std: 0.01,
        ..options()
    };
    let joint = with_problem(&models, &data, [&[], &[]], with_shapes.clone(), |problem| {
        update(&problem).unwrap()
    });
    let joint = joint.unwrap();
    let sets = [
        MeasuredModes::new("alone", &data[0].test),
        MeasuredModes::new("loaded", &data[1].test),
    ];
    let chosen = free(&["k1", "k2", "k3"]);
    let sensors = &data[0].sensors;
    let one = UpdateProblem::new(&models[0], &START, &chosen, &sets, sensors, with_shapes);
    let one = update(&one.unwrap()).unwrap();
    for (a, b) in joint.parameters.iter().zip(&one.parameters) {
        assert!((a.updated / b.updated - 1.0).abs() < 1e-9);
        assert!((a.std / b.std - 1.0).abs() < 1e-6, "{a:?} {b:?}");
    }
    assert_eq!(joint.after.data_count, one.after.data_count);
}

#[test]
fn derivatives_of_every_residual_of_two_configurations_are_those_of_differences() {
    let models = models();
    let truth = [115.0, 190.0, 320.0];
    let data = measured_of(&models, [&truth, &truth], true);
    for residuals in [Residuals::Modes, Residuals::ModalDynamic] {
        let of_kind = UpdateOptions {
            residuals,
            shape_floor: Some(0.02),
            frequency_floor: 1e-3,
            ..options()
        };
        let z = [0.1, -0.2, 0.15, 0.3];
        let worst = with_problem(&models, &data, [&["k3"], &["k2"]], of_kind, |problem| {
            against_differences(&problem, &z)
        });
        let worst = worst.unwrap();
        assert!(worst < 1e-6, "{residuals:?} {worst}");
    }
}

#[test]
fn a_shared_parameter_has_one_value_at_the_start() {
    let models = models();
    let data = measured_of(&models, [&START, &START], false);
    let sets = [MeasuredModes::new("t", &data[0].test)];
    let error = |k2: f64| {
        let other = [100.0, k2, 300.0];
        let configuration = |name, values, c: usize| Configuration {
            name,
            model: &models[c],
            values,
            sensors: &[],
            measured: &sets,
            held: &[],
            separate: &[],
        };
        let both = [
            configuration("base", &START, 0),
            configuration("loaded", &other, 1),
        ];
        UpdateProblem::of_configurations(&both, &free(&["k2"]), options()).err()
    };
    let expected = UpdateError::SharedValue {
        name: "k2".to_owned(),
        configuration: "loaded".to_owned(),
        got: 210.0,
        expected: 200.0,
    };
    assert_eq!(error(210.0), Some(expected));
    assert_eq!(error(200.0 * (1.0 + 1e-15)), None);
}

#[test]
fn a_separate_parameter_is_one_of_the_free_ones() {
    let models = models();
    let data = measured_of(&models, [&START, &START], false);
    let error = with_problem(&models, &data, [&[], &["k9"]], options(), |_| ()).unwrap_err();
    let expected =
        "configuration \"with mass\" separate: got \"k9\", expected a free parameter: k1, k2, k3";
    assert_eq!(error.to_string(), expected);
}

#[test]
fn scatter_between_reassemblies_enters_the_deviations() {
    let model = chain(&START);
    let mut tests = vec![measured(&model, &START, 1e-5, false); 3];
    // Factors of the three reassemblies for each mode, of a variance of 1e-4.
    let shifts = [[-0.01, 0.0, 0.01], [0.01, -0.01, 0.0], [0.0, 0.01, -0.01]];
    for (test, shifts) in tests.iter_mut().zip(shifts) {
        for (mode, shift) in test.modes.iter_mut().zip(shifts) {
            mode.frequency_hz *= f64::exp(shift);
        }
    }
    let names = ["a", "b", "c"];
    let sets: Vec<MeasuredModes<'_>> = names
        .iter()
        .zip(&tests)
        .map(|(name, test)| MeasuredModes::new(name, test))
        .collect();
    let result = |scatter_between_tests: bool| {
        let options = UpdateOptions {
            scatter_between_tests,
            ..options()
        };
        let chosen = free(&["k1", "k2", "k3"]);
        let problem = UpdateProblem::new(&model, &START, &chosen, &sets, &[], options);
        update(&problem.unwrap()).unwrap()
    };
    let with = result(true);
    let scatter = with.scatter.unwrap();
    assert_eq!(scatter.degrees_of_freedom, 6);
    assert!(
        (scatter.relative_std / 0.01 - 1.0).abs() < 0.01,
        "{scatter:?}"
    );
    assert!(with.fits());
    assert!(
        with.parameters
            .iter()
            .all(|p| p.verdict == ParameterVerdict::Identified)
    );
    let without = result(false);
    assert_eq!(without.scatter, None);
    assert!(!without.fits());
}
