//! Models of matrices from files, through the same door as every other model.

use std::collections::BTreeMap;
use std::path::Path;

use crate::theory::ModeOptions;

use super::{SceneError, load_model};

const MODEL: &str = r#"
    schema = "modalign-model/1"
    kind = "matrices"
    title = "two masses"

    [matrices]
    dofs = ["1:+X", "2:+X"]
    mass = { file = "m.mtx" }
    stiffness = "k.mtx"

    [[matrices.group]]
    parameter = "coupling"
    stiffness = "k1.mtx"

    [[parameter]]
    name = "coupling"
    unit = "-"
    nominal = 1.0
    lower = 0.1
    status = "assumed"

    [damping]
    mass_per_s = 2.0
"#;

/// The model with some of its text changed, in a folder with its matrices.
fn written(changes: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut model = MODEL.to_owned();
    for (from, to) in changes {
        assert!(model.contains(from), "{from}");
        model = model.replace(from, to);
    }
    let head = "%%MatrixMarket matrix coordinate real symmetric\n";
    for (name, text) in [
        ("model.toml", model),
        ("m.mtx", format!("{head}2 2 2\n1 1 2.0\n2 2 2.0\n")),
        ("k.mtx", format!("{head}2 2 2\n1 1 50.0\n2 2 50.0\n")),
        (
            "k1.mtx",
            format!("{head}2 2 3\n1 1 75.0\n2 1 -75.0\n2 2 75.0\n"),
        ),
        ("three.mtx", format!("{head}3 3 1\n1 1 1.0\n")),
        ("bad.mtx", format!("{head}2 2 1\n1 3 1.0\n")),
        (
            "dofs.txt",
            "# the chain\n1:+X, 2:+X # in order\n".to_owned(),
        ),
        ("wrong.txt", "1:+X\n2:+Q\n".to_owned()),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn loaded(folder: &Path, values: &[(&str, f64)]) -> Result<super::LoadedModel, SceneError> {
    let named = values
        .iter()
        .map(|(name, value)| ((*name).to_owned(), *value));
    load_model(
        &folder.join("model.toml"),
        &named.collect::<BTreeMap<_, _>>(),
    )
}

#[test]
fn matrices_are_solved_at_their_degrees_of_freedom_with_damping_and_sensitivities() {
    for changes in [
        &[] as &[(&str, &str)],
        &[
            ("[\"1:+X\", \"2:+X\"]", "\"dofs.txt\""),
            ("kind = \"matrices\"", ""),
        ],
    ] {
        let folder = written(changes);
        let model = loaded(folder.path(), &[("coupling", 2.0)]).unwrap();
        let theory = model
            .solve(&model.sensors, &ModeOptions::default())
            .unwrap();
        // Both masses together on 50 N/m each: 5 rad/s; against each other with 2 x 75 N/m, twice:
        // 50 + 2 x 150 over 2.
        let omega: Vec<f64> = theory.roots.iter().map(|root| root.omega_rad_s).collect();
        assert!((omega[0] - 5.0).abs() < 1e-12 && (omega[1] - 175f64.sqrt()).abs() < 1e-12);
        let mode = &theory.modes.modes[1];
        assert!((mode.damping_ratio.unwrap() - 1.0 / omega[1]).abs() < 1e-12);
        let names: Vec<String> = mode.shape.iter().map(|(dof, _)| dof.to_string()).collect();
        assert_eq!(names, ["1:+X", "2:+X"]);
        let found = model.sensitivities(None).unwrap();
        assert!(found[0].branches[0][0].abs() < 1e-10);
        assert!((found[1].branches[0][0] - 75.0).abs() < 1e-10);
    }
}

#[test]
fn errors_are_reported_with_file_and_key() {
    for (from, to, expected) in [
        ("mass =", "mas =", "did you mean `mass`?"),
        ("{ file =", "{ flie =", "did you mean `file`?"),
        (
            "stiffness = \"k1.mtx\"",
            "stifness = \"k1.mtx\"",
            "did you mean `stiffness`?",
        ),
        (
            "stiffness = \"k1.mtx\"",
            "",
            "got no matrix, expected mass, damping or stiffness",
        ),
        ("mass_per_s", "mass_per_sec", "did you mean `mass_per_s`?"),
        ("\"k.mtx\"", "7", "a path, or { file = PATH, name = NAME }"),
        (
            "\"k.mtx\"",
            "\"three.mtx\"",
            "[matrices] stiffness: got 3 x 3 in",
        ),
        (
            "\"k.mtx\"",
            "\"bad.mtx\"",
            "bad.mtx:3: entry: got \"1 3 1.0\", expected a row from 1 to 2",
        ),
        ("\"k.mtx\"", "\"gone.mtx\"", "gone.mtx: cannot open"),
        (
            "parameter = \"coupling\"",
            "parameter = \"couplng\"",
            "did you mean `coupling`?",
        ),
        (
            "[\"1:+X\", \"2:+X\"]",
            "\"wrong.txt\"",
            "wrong.txt:2: degree of freedom: got \"2:+Q\"",
        ),
        ("\"2:+X\"", "\"2:+Q\"", "degree of freedom `2:+Q`"),
        (
            "\"matrices\"",
            "\"matrix\"",
            "\"lumped\", \"beam\" or \"matrices\"",
        ),
        ("modalign-model/1", "modalign-model/9", "modalign-model/9"),
    ] {
        let folder = written(&[(from, to)]);
        let error = loaded(folder.path(), &[]).unwrap_err().to_string();
        assert!(error.contains(expected), "{to}: {error}");
        assert!(
            error.contains(&folder.path().display().to_string()),
            "{error}"
        );
    }
}
