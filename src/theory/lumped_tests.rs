//! The lumped model against closed forms, and errors of model files.

use std::f64::consts::TAU;

use super::{LumpedFile, LumpedModel, ModeOptions, TheoreticalModel, TheoryError, modes};
use crate::theory::parameter::nominal_values;

fn model(text: &str) -> Result<LumpedModel, TheoryError> {
    LumpedModel::new(toml::from_str::<LumpedFile>(text).unwrap())
}

fn omega(text: &str) -> Vec<f64> {
    let model = model(text).unwrap();
    let values = nominal_values(model.parameters());
    modes(&model, &values, &[], &ModeOptions::default())
        .unwrap()
        .omega_rad_s
}

/// A rigid bar of 2 kg on two springs, one at each end: bounce and pitch.
const BAR: &str = r#"
    title = "bar on two springs"
    [[body]]
    name = "bar"
    at_m = [1.0, 0.0, 0.0]
    mass_kg = 2.0
    inertia_kg_m2 = 0.5
    free = ["y", "rz"]
    [[point]]
    name = "left"
    body = "bar"
    at_m = [0.4, 0.0, 0.0]
    [[point]]
    name = "right"
    body = "bar"
    at_m = [1.9, 0.0, 0.0]
    [[spring]]
    name = "left"
    from = "left"
    to = "ground"
    direction = [0.0, 1.0, 0.0]
    stiffness_n_per_m = 3000.0
    [[spring]]
    name = "right"
    from = "ground"
    to = "right"
    direction = [0.0, -1.0, 0.0]
    stiffness_n_per_m = 5000.0
"#;

#[test]
fn a_bar_on_two_springs_has_the_roots_of_its_two_by_two_problem() {
    // Arms -0.6 m and 0.9 m: K = [k1 + k2, -0.6 k1 + 0.9 k2; ., 0.36 k1 + 0.81 k2], M = diag(2,
    // 0.5).
    let (a, b, c) = (8000.0 / 2.0, 2700.0 / 1.0, 5130.0 / 0.5);
    let mean: f64 = 0.5 * (a + c);
    let root = (0.25f64 * (a - c) * (a - c) + b * b).sqrt();
    let found = omega(BAR);
    for (found, squared) in found.iter().zip([mean - root, mean + root]) {
        assert!((found - squared.sqrt()).abs() < 1e-9 * found);
    }
}

#[test]
fn a_spring_between_bodies_acts_along_the_line_of_its_points_and_against_rotation() {
    // Two free discs of 1 kg and 3 kg along x, tied by 1200 N/m; about x by 20 N m/rad with 0.2 and
    // 0.6 kg m2.
    let text = r#"
        [[parameter]]
        name = "tie"
        unit = "N/m"
        nominal = 1200.0
        status = "assumed"
        [[body]]
        name = "a"
        mass_kg = 1.0
        inertia_kg_m2 = [0.2, 9.0, 9.0]
        free = ["x", "rx"]
        [[body]]
        name = "b"
        mass_kg = 3.0
        inertia_kg_m2 = 0.6
        free = ["x", "rx"]
        [[point]]
        name = "on a"
        body = "a"
        at_m = [0.1, 0.0, 0.0]
        [[point]]
        name = "on b"
        body = "b"
        at_m = [0.7, 0.0, 0.0]
        [[spring]]
        name = "tie"
        from = "on a"
        to = "on b"
        parameter = "tie"
        [[spring]]
        name = "shaft"
        from = "on a"
        to = "on b"
        direction = [2.0, 0.0, 0.0]
        stiffness_nm_per_rad = 20.0
    "#;
    let found = omega(text);
    assert_eq!(found.iter().filter(|w| **w == 0.0).count(), 2);
    // omega^2 = k (1/m1 + 1/m2).
    let twist = (20.0f64 * (1.0 / 0.2 + 1.0 / 0.6)).sqrt();
    let stretch = (1200.0f64 * (1.0 + 1.0 / 3.0)).sqrt();
    assert!((found[2] - twist).abs() < 1e-10 * twist);
    assert!((found[3] - stretch).abs() < 1e-10 * stretch);
}

#[test]
fn a_free_block_on_three_springs_in_space_keeps_three_rigid_modes() {
    // Held along x, y, z at its centre: it turns freely about all three axes.
    let spring = |axis: &str, direction: &str| {
        format!(
            "[[spring]]\nname = \"{axis}\"\nfrom = \"centre\"\nto = \"ground\"\ndirection = {direction}\nstiffness_n_per_m = 4e4\n"
        )
    };
    let text = format!(
        "[[body]]\nname = \"block\"\nmass_kg = 4.0\ninertia_kg_m2 = [0.1, 0.2, 0.3]\nfree = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n\
         [[point]]\nname = \"centre\"\nbody = \"block\"\nat_m = [0.0, 0.0, 0.0]\n{}{}{}",
        spring("x", "[1, 0, 0]"),
        spring("y", "[0, 1, 0]"),
        spring("z", "[0, 0, 1]")
    );
    let found = omega(&text);
    assert_eq!(&found[..3], [0.0; 3]);
    for w in &found[3..] {
        assert!((w / TAU - 100.0 / TAU).abs() < 1e-9, "{w}");
    }
}

#[test]
fn a_parameter_must_have_the_unit_of_its_property() {
    let with = |unit: &str| {
        let parameter = format!(
            "[[parameter]]\nname = \"k\"\nunit = \"{unit}\"\nnominal = 3.0\nstatus = \"assumed\"\n[[body]]"
        );
        let text = BAR.replacen("[[body]]", &parameter, 1);
        model(&text.replacen("stiffness_n_per_m = 3000.0", "parameter = \"k\"", 1))
    };
    assert!(with("N/m").is_ok());
    let error = with("N/mm").unwrap_err();
    assert!(
        matches!(
            &error,
            TheoryError::ParameterUnit {
                expected: "N/m",
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn errors_of_a_model_file_are_reported() {
    let error = |from: &str, to: &str| model(&BAR.replacen(from, to, 1)).unwrap_err();
    let unknown = error("from = \"left\"", "from = \"lefft\"");
    assert!(
        matches!(&unknown, TheoryError::UnknownPoint { nearest: Some(n), .. } if n == "left"),
        "{unknown}"
    );
    let missing = error("inertia_kg_m2 = 0.5", "");
    assert!(
        matches!(
            &missing,
            TheoryError::MissingProperty {
                property: "inertia_kg_m2",
                needed_for: "rz",
                ..
            }
        ),
        "{missing}"
    );
    let body = error("body = \"bar\"", "body = \"ba\"");
    assert!(matches!(body, TheoryError::UnknownBody { .. }), "{body}");
    let stiffness = error("stiffness_n_per_m = 3000.0", "");
    assert!(matches!(stiffness, TheoryError::NoStiffness { .. }));
    let both = error(
        "stiffness_n_per_m = 3000.0",
        "stiffness_n_per_m = 1.0\nparameter = \"k\"",
    );
    assert!(matches!(both, TheoryError::NoStiffness { .. }));
    let negative = error("mass_kg = 2.0", "mass_kg = -2.0");
    assert!(matches!(negative, TheoryError::PropertyOutOfRange { .. }));
    let line = error("direction = [0.0, 1.0, 0.0]", "");
    assert!(matches!(line, TheoryError::NoDirection { .. }), "{line}");
    let across = error("direction = [0.0, 1.0, 0.0]", "direction = [0.0, 0.0, 1.0]");
    assert!(
        matches!(across, TheoryError::NothingMoves { .. }),
        "{across}"
    );
    let twice = error("free = [\"y\", \"rz\"]", "free = [\"y\", \"y\"]");
    assert!(matches!(
        twice,
        TheoryError::Duplicate {
            what: "coordinate",
            ..
        }
    ));
    let held = error("free = [\"y\", \"rz\"]", "free = []");
    assert!(matches!(held, TheoryError::PropertyOutOfRange { .. }));
    let schema = error("title", "schema = \"modalign-model/9\"\ntitle");
    assert!(matches!(schema, TheoryError::Schema { .. }));
}
