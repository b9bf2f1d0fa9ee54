//! Sensitivities against differences extrapolated to a step of 0, for every parameter of every
//! built-in model; and against an independent computation for the torsional gear, to its printed
//! digits.

use crate::linalg::{RealMatrix, real_matrix, symmetric_modes};

use super::{
    BUILT_IN, BeamModel, LumpedModel, ModeOptions, ModelRoot, RootSensitivity, TheoreticalModel,
    TheoryModes, built_in, model_roots, modes, sensitivities, system_derivatives,
};
use crate::theory::parameter::nominal_values;

struct Solved {
    model: Box<dyn TheoreticalModel>,
    values: Vec<f64>,
    modes: TheoryModes,
    roots: Vec<ModelRoot>,
    sensitivities: Vec<RootSensitivity>,
}

fn solved(name: &str) -> Solved {
    let model = built_in(name).unwrap();
    let values = nominal_values(model.parameters());
    let modes = modes(model.as_ref(), &values, &[], &ModeOptions::default()).unwrap();
    let roots = model_roots(model.as_ref(), &modes);
    let derivatives = system_derivatives(model.as_ref(), &values).unwrap();
    Solved {
        sensitivities: sensitivities(&modes, &roots, &derivatives).unwrap(),
        model,
        values,
        modes,
        roots,
    }
}

impl Solved {
    fn index(&self, parameter: &str) -> usize {
        let mut all = self.model.parameters().iter();
        all.position(|spec| spec.name == parameter).unwrap()
    }
}

#[test]
fn sensitivities_of_the_torsional_gear_are_the_reference() {
    let gear = solved("torsional-planetary");
    let parameters = ["k_r", "k_s", "m_c", "m_r", "m_s", "m_p", "k_cu"];
    for (root, expected) in [
        (
            1,
            [
                "2.6230511e-3",
                "9.8361537e-5",
                "-1.2013727e7",
                "-1.0570356e7",
                "-1.1375608e7",
                "-1.1452782e5",
                "1.0892891e-1",
            ],
        ),
        (
            2,
            [
                "1.7211704e-1",
                "1.7211704e-1",
                "0.0000000e0",
                "0.0000000e0",
                "0.0000000e0",
                "-2.9624275e7",
                "0.0000000e0",
            ],
        ),
        (
            3,
            [
                "3.2664361e0",
                "2.2431752e-3",
                "-3.2191636e7",
                "-8.7782388e8",
                "-1.7300668e7",
                "-1.5404458e7",
                "1.9465196e-2",
            ],
        ),
        (
            4,
            [
                "8.2976269e-3",
                "1.4894063e1",
                "-3.1550485e7",
                "-4.9465195e5",
                "-2.5481528e10",
                "-1.4105289e7",
                "4.2318901e-3",
            ],
        ),
    ] {
        for (parameter, text) in parameters.iter().zip(expected) {
            let sensitivity = gear.sensitivities[root]
                .mean(gear.index(parameter))
                .unwrap();
            let wanted: f64 = text.parse().unwrap();
            // Half a unit of the last printed digit; still bodies are still to rounding.
            assert!(
                (sensitivity - wanted).abs() <= 6e-8 * wanted.abs() + 1e-12,
                "{root} {parameter}: {sensitivity} {text}"
            );
        }
    }
    // Every planet branch has the same derivative.
    let planet = &gear.sensitivities[2].branches[gear.index("m_p")];
    assert_eq!(planet.len(), 3);
    assert!((planet[2] / planet[0] - 1.0).abs() < 1e-12);
}

/// `d(A + B p)` of matrices by central differences at two steps, extrapolated: exact to h^4.
fn difference(at: impl Fn(f64) -> RealMatrix, step: f64) -> RealMatrix {
    let central = |h: f64| {
        let (up, down) = (at(h), at(-h));
        real_matrix(up.nrows(), up.ncols(), |i, j| {
            (up[(i, j)] - down[(i, j)]) / (2.0 * h)
        })
    };
    let (wide, narrow) = (central(step), central(0.5 * step));
    real_matrix(wide.nrows(), wide.ncols(), |i, j| {
        (4.0 * narrow[(i, j)] - wide[(i, j)]) / 3.0
    })
}

/// Every derivative of the matrices against differences, over every parameter.
fn check_derivatives(name: &str, model: &dyn TheoreticalModel) {
    let nominal = nominal_values(model.parameters());
    for (j, spec) in model.parameters().iter().enumerate() {
        if spec.whole {
            continue;
        }
        // A value of 0 may be on its bound: away from it.
        let base = if spec.nominal.abs() > 0.0 {
            spec.nominal
        } else {
            spec.upper.unwrap().min(1e6) * 1e-2
        };
        let mut values = nominal.clone();
        values[j] = base;
        let by = model.derivative(&values, j).unwrap();
        let step = 1e-3 * base.abs();
        let at = |pick: fn(super::SystemMatrices) -> RealMatrix| {
            let values = values.clone();
            move |h: f64| {
                let mut values = values.clone();
                values[j] = base + h;
                pick(model.assemble(&values).unwrap())
            }
        };
        let mut moved = 0.0f64;
        for (matrix, expected) in [
            (&by.stiffness, difference(at(|m| m.stiffness), step)),
            (&by.mass, difference(at(|m| m.mass), step)),
        ] {
            let all = || (0..matrix.nrows()).flat_map(|i| (0..matrix.nrows()).map(move |j| (i, j)));
            let largest = all().map(|at| expected[at].abs()).fold(0.0, f64::max);
            moved = moved.max(largest);
            for place in all() {
                assert!(
                    (matrix[place] - expected[place]).abs() <= 1e-8 * largest,
                    "{name} {} {place:?}: {} {}",
                    spec.name,
                    matrix[place],
                    expected[place]
                );
            }
        }
        assert!(by.damping.is_none(), "{name} has no damping matrix");
        if name.starts_with("file") {
            assert!(moved > 0.0, "{name} {} moves something", spec.name);
        }
    }
}

#[test]
fn derivatives_of_the_matrices_are_their_differences_for_every_parameter_of_every_built_in_model() {
    for model_set in BUILT_IN {
        for set in model_set.sets {
            let name = format!("{}/{set}", model_set.name);
            check_derivatives(&name, built_in(&name).unwrap().as_ref());
        }
    }
}

/// Parameters of a model file, each `name = (unit, value)`.
fn parameters(all: &[(&str, &str, f64)]) -> String {
    let table = |(name, unit, value): &(&str, &str, f64)| {
        format!(
            "[[parameter]]\nname = \"{name}\"\nunit = \"{unit}\"\nnominal = {value:?}\nlower = 0.0\nupper = 1e13\nstatus = \"assumed\"\n"
        )
    };
    all.iter().map(table).collect()
}

/// A block on springs with every kind of number that a lumped file can name: a mass for two bodies,
/// an inertia for one axis and for all, a stiffness along and about a direction, and one for two
/// springs.
const LUMPED: &str = r#"
    title = "block"
    [[body]]
    name = "block"
    at_m = [0.1, 0.2, 0.3]
    mass_kg = "mass"
    inertia_kg_m2 = ["roll", 0.02, "roll"]
    free = ["x", "y", "z", "rx", "ry", "rz"]
    [[body]]
    name = "rider"
    at_m = [0.4, 0.2, 0.5]
    mass_kg = "mass"
    inertia_kg_m2 = "round"
    free = ["y", "rx", "rz"]
    [[point]]
    name = "foot"
    body = "block"
    at_m = [0.3, -0.1, 0.0]
    [[point]]
    name = "saddle"
    body = "rider"
    at_m = [0.35, 0.4, 0.6]
    [[spring]]
    name = "leg"
    from = "foot"
    to = "ground"
    direction = [0.3, 0.8, -0.5]
    parameter = "mount"
    [[spring]]
    name = "seat"
    from = "foot"
    to = "saddle"
    stiffness_n_per_m = "mount"
    [[spring]]
    name = "hinge"
    from = "foot"
    to = "saddle"
    direction = [0.0, 0.6, 0.8]
    stiffness_nm_per_rad = "twist"
"#;

#[test]
fn derivatives_of_a_lumped_file_are_its_differences() {
    let parameters = parameters(&[
        ("mass", "kg", 3.0),
        ("roll", "kg m2", 0.05),
        ("round", "kg m2", 0.01),
        ("mount", "N/m", 2e5),
        ("twist", "N m/rad", 150.0),
    ]);
    let file = toml::from_str(&format!("{LUMPED}{parameters}")).unwrap();
    check_derivatives("file, lumped", &LumpedModel::new(file).unwrap());
}

/// Two beams of one material, a point mass with its rotary inertia and a spring in both directions.
const BEAMS: &str = r#"
    schema = "modalign-model/1"
    kind = "beam"
    title = "two beams"
    [[beam]]
    name = "shaft"
    from_m = [0.0, 0.0, 0.0]
    to_m = [0.5, 0.2, 0.0]
    deflection = [0.0, 0.0, 1.0]
    elements = 5
    start = "clamped"
    end = "free"
    youngs_modulus_pa = "modulus"
    density_kg_per_m3 = "density"
    area_m2 = "area"
    second_moment_m4 = "second_moment"
    [[beam]]
    name = "arm"
    from_m = [0.0, 1.0, 0.0]
    to_m = [0.3, 1.0, 0.0]
    deflection = [0.0, 0.0, 1.0]
    elements = 3
    start = "free"
    end = "pinned"
    youngs_modulus_pa = "modulus"
    density_kg_per_m3 = "density"
    area_m2 = 2e-4
    second_moment_m4 = "second_moment"
    [[point_mass]]
    name = "disc"
    beam = "shaft"
    at_m = [0.25, 0.1, 0.0]
    mass_kg = "disc"
    rotary_inertia_kg_m2 = "spin"
    [[spring]]
    name = "bearing"
    beam = "arm"
    at_m = [0.05, 1.0, 0.0]
    stiffness_n_per_m = "bearing"
    stiffness_nm_per_rad = "tilt"
"#;

#[test]
fn derivatives_of_a_beam_file_are_its_differences() {
    let parameters = parameters(&[
        ("modulus", "Pa", 2.1e11),
        ("density", "kg/m3", 7850.0),
        ("area", "m2", 3e-4),
        ("second_moment", "m4", 2.5e-9),
        ("disc", "kg", 0.7),
        ("spin", "kg m2", 2e-4),
        ("bearing", "N/m", 4e6),
        ("tilt", "N m/rad", 900.0),
    ]);
    let file = toml::from_str(&format!("{BEAMS}{parameters}")).unwrap();
    check_derivatives("file, beams", &BeamModel::new(file).unwrap());
}

/// All eigenvalues `omega^2` of a model, ascending, with one value changed.
fn eigenvalues(model: &dyn TheoreticalModel, values: &[f64], (j, value): (usize, f64)) -> Vec<f64> {
    let mut values = values.to_vec();
    values[j] = value;
    let matrices = model.assemble(&values).unwrap();
    symmetric_modes(&matrices.stiffness, &matrices.mass)
        .unwrap()
        .omega_squared
}

/// The largest scaled sensitivity `|p dlambda/dp|` of a root.
fn largest(sensitivity: &RootSensitivity, values: &[f64]) -> f64 {
    let scaled = values.iter().zip(&sensitivity.branches);
    let scaled = scaled.flat_map(|(p, all)| all.iter().map(move |by| (p * by).abs()));
    scaled.fold(0.0, f64::max)
}

#[test]
fn sensitivities_of_all_roots_are_extrapolated_differences_repeated_ones_by_branch_and_by_mean() {
    let mut repeated = 0;
    for name in [
        "cycloid-ball/B",
        "torsional-planetary/table-2",
        "torsional-planetary/carrier-fixed",
        "spider-reducer/paper",
        "helical-planetary",
    ] {
        let gear = solved(name);
        let model = gear.model.as_ref();
        for (j, &value) in gear.values.iter().enumerate() {
            // Where the value is 0 there is no scale: angles, and supports that may not be
            // negative.
            if value.abs() <= 0.0 || model.parameters()[j].whole {
                continue;
            }
            let step = 1e-4 * value.abs();
            let at = |h: f64| eigenvalues(model, &gear.values, (j, value + h));
            let [low, half_low, here, half_high, high] =
                [-step, -0.5 * step, 0.0, 0.5 * step, step].map(at);
            for (root, sensitivity) in gear.roots.iter().zip(&gear.sensitivities) {
                if root.omega_rad_s <= 0.0 {
                    continue;
                }
                let limit = 1e-6 * largest(sensitivity, &gear.values);
                let mean = |all: &[f64]| -> f64 {
                    root.modes.iter().map(|&i| all[i]).sum::<f64>() / root.modes.len() as f64
                };
                let central =
                    |up: &[f64], down: &[f64], h: f64| (mean(up) - mean(down)) / (2.0 * h);
                let wide = central(&high, &low, step);
                let narrow = central(&half_high, &half_low, 0.5 * step);
                let expected = value * (4.0 * narrow - wide) / 3.0;
                let got = value * sensitivity.mean(j).unwrap();
                let parameter = &model.parameters()[j].name;
                assert!(
                    (got - expected).abs() <= limit,
                    "{name} {parameter} {root:?}: {got} {expected}"
                );
                if root.modes.len() == 1 {
                    continue;
                }
                repeated += 1;
                for (branch, &i) in sensitivity.branches[j].iter().zip(&root.modes) {
                    let forward = |up: &[f64], h: f64| (up[i] - mean(&here)) / h;
                    let forward = 2.0 * forward(&half_high, 0.5 * step) - forward(&high, step);
                    let (got, expected) = (value.abs() * branch, value.abs() * forward);
                    assert!(
                        (got - expected).abs() <= limit,
                        "{name} {parameter} {root:?}: {got} {expected}"
                    );
                }
            }
        }
    }
    assert!(repeated > 100, "{repeated}");
}

#[test]
fn a_scaled_sensitivity_is_half_the_strain_share_of_its_spring() {
    let spider = solved("spider-reducer");
    let roots = spider.roots.iter().zip(&spider.sensitivities);
    for (root, sensitivity) in roots {
        for (name, share) in &root.strain_energy {
            let j = spider.index(name);
            let scaled = sensitivity.scaled(j, spider.values[j]).unwrap();
            assert!(
                (scaled - 0.5 * share).abs() < 1e-9,
                "{name}: {scaled} {share}"
            );
        }
    }
    assert_eq!(spider.modes.rigid, 0);
    let free = solved("torsional-planetary");
    assert_eq!(
        free.sensitivities[0].scaled(0, 1.0),
        None,
        "a root at 0 has no scale"
    );
    let balls = solved("cycloid-ball");
    let j = balls.index("ball_count");
    let elastic = balls.sensitivities.iter().skip(1);
    let mut elastic = elastic.map(|sensitivity| (sensitivity.mean(j), sensitivity.scaled(j, 10.0)));
    assert!(
        elastic.all(|means| means == (None, None)),
        "no derivative by a number of parts"
    );
}
