//! `modalign update` of a scene with several configurations: a frame alone and with an added mass,
//! and its lower part.

use std::path::Path;

use modalign::linalg::{real_matrix, symmetric_modes};
use serde_json::Value;

use crate::command::{fail, succeed, write};
use crate::updating::{frame, modes_json};

/// Stiffnesses of the storeys of the true frame, N/m; the model has 1000 of each.
const TRUTH: [f64; 3] = [1200.0, 850.0, 1100.0];

/// Modes of a frame of these masses and stiffnesses, with deviations of 0.01 %.
fn storey_modes(masses: &[f64], stiffness: &[f64]) -> String {
    let n = masses.len();
    let k = real_matrix(n, n, |i, j| {
        let above = |i: usize| if i + 1 < n { stiffness[i + 1] } else { 0.0 };
        match i.abs_diff(j) {
            0 => stiffness[i] + above(i),
            1 => -stiffness[i.max(j)],
            _ => 0.0,
        }
    });
    let m = real_matrix(n, n, |i, j| if i == j { masses[i] } else { 0.0 });
    let solved = symmetric_modes(&k, &m).unwrap();
    let mode = |r: usize| {
        let hz = solved.omega_squared[r].sqrt() / std::f64::consts::TAU;
        let shape = (0..n).map(|i| solved.vectors[(i, r)]).collect();
        (hz, Some(1e-4 * hz), shape)
    };
    modes_json(&(0..n).map(mode).collect::<Vec<_>>())
}

/// A scene of the frame, with 2 kg on the second storey, and of its lower two storeys.
fn write_scene(folder: &Path, loaded: &[f64; 3], configurations: &str) {
    let whole = frame(3.0, &[1000.0; 3], (0.1, 10.0));
    let part = frame(3.0, &[1000.0; 2], (0.1, 10.0));
    let tests = ["whole", "loaded", "part"];
    let tests = tests.map(|name| format!("[[test]]\nname = {name:?}\nmodes = \"{name}.json\"\n"));
    let scene = format!(
        "schema = \"modalign-scene/1\"\ntitle = \"frame\"\n[model]\nfile = \"model.toml\"\n{}{configurations}",
        tests.concat()
    );
    let files = [
        ("model.toml", whole.as_str()),
        ("part.toml", &part),
        ("whole.json", &storey_modes(&[3.0; 3], &TRUTH)),
        ("loaded.json", &storey_modes(&[3.0, 5.0, 3.0], loaded)),
        ("part.json", &storey_modes(&[3.0; 2], &TRUTH[..2])),
        ("scene.toml", &scene),
    ];
    write(folder, &files);
}

const CONFIGURATIONS: &str = "[[configuration]]\nname = \"with mass\"\ntests = [\"loaded\"]\nmodify = [\"mass:2:+X=2.0\"]\n\
     [[configuration]]\nname = \"lower storeys\"\ntests = [\"part\"]\nmodel = \"part.toml\"\n";

/// What a command prints with `--json`.
fn json(arguments: &[&str]) -> Value {
    let text = succeed(arguments.iter().chain(&["--json"]));
    serde_json::from_str(&text).unwrap()
}

fn update(folder: &Path) -> Value {
    let scene = folder.join("scene.toml");
    json(&["update", scene.to_str().unwrap()])
}

fn updated(file: &Value, name: &str) -> f64 {
    let mut all = file["parameters"].as_array().unwrap().iter();
    let found = all.find(|parameter| parameter["name"] == name);
    found.unwrap()["updated"].as_f64().unwrap()
}

#[test]
fn configurations_update_the_stiffnesses_that_they_share() {
    let folder = tempfile::tempdir().unwrap();
    write_scene(folder.path(), &TRUTH, CONFIGURATIONS);
    let file = update(folder.path());
    for (j, truth) in TRUTH.iter().enumerate() {
        let value = updated(&file, &format!("k{}", j + 1));
        assert!((value / truth - 1.0).abs() < 1e-3, "{value} {truth}");
    }
    assert_eq!(file["fits"], true);
    assert_eq!(file["contradiction"], Value::Null);
    let contributions = file["configurations"].as_array().unwrap();
    let names: Vec<&str> = contributions
        .iter()
        .map(|one| one["configuration"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["base", "with mass", "lower storeys"]);
    let paired: Vec<u64> = contributions
        .iter()
        .map(|one| one["paired"].as_u64().unwrap())
        .collect();
    assert_eq!(paired, [3, 3, 2]);
    // The lower storeys do not have the third stiffness, and all together know more than each.
    assert_eq!(contributions[2]["std_alone"][2], Value::Null);
    for (j, parameter) in file["parameters"].as_array().unwrap().iter().enumerate() {
        let std = parameter["std"].as_f64().unwrap();
        for one in contributions {
            let alone = one["std_alone"][j].as_f64();
            assert!(alone.is_none_or(|alone| alone > std));
        }
    }
    // Each configuration has its comparisons, and the part its model.
    let out = folder.path().join("out");
    let scene = folder.path().join("scene.toml");
    let (out_name, scene) = (out.to_str().unwrap(), scene.to_str().unwrap());
    let screen = succeed(["update", scene, "-o", out_name]);
    assert!(
        screen.contains("Contribution of each configuration"),
        "{screen}"
    );
    for name in [
        "with-mass.comparison-after.json",
        "lower-storeys.model.toml",
    ] {
        assert!(out.join(name).is_file(), "{name}");
    }
    assert!(!out.join("with-mass.model.toml").exists());
}

#[test]
fn a_run_compares_the_tests_of_one_configuration_with_its_model() {
    let folder = tempfile::tempdir().unwrap();
    write_scene(folder.path(), &TRUTH, CONFIGURATIONS);
    let scene = folder.path().join("scene.toml");
    let scene = scene.to_str().unwrap();
    let base = succeed(["run", scene]);
    let others =
        "Not compared here: --configuration \"with mass\", --configuration \"lower storeys\".";
    assert!(base.replace('\n', " ").contains(others), "{base}");
    assert!(!base.contains("loaded"), "{base}");
    let of = |name: &str| json(&["run", scene, "--configuration", name]);
    for (name, modes) in [("with mass", 3), ("lower storeys", 2)] {
        let rows = of(name)["rows"].as_array().unwrap().len();
        assert_eq!(rows, modes, "{name}");
    }
    let message = fail(["run", scene, "--configuration", "loaded"]);
    let expected = "got \"loaded\", expected one of base, with mass, lower storeys";
    assert!(message.contains(expected), "{message}");
}

#[test]
fn a_stiffness_that_differs_in_one_configuration_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let loaded = [TRUTH[0], 0.9 * TRUTH[1], TRUTH[2]];
    write_scene(folder.path(), &loaded, CONFIGURATIONS);
    let file = update(folder.path());
    let found = &file["contradiction"];
    assert_eq!(
        (&found["parameter"], &found["configuration"]),
        (&"k2".into(), &"with mass".into())
    );
    let there = found["there"].as_f64().unwrap();
    assert!((there / loaded[1] - 1.0).abs() < 0.01, "{found}");
    let scene = folder.path().join("scene.toml");
    let scene = scene.to_str().unwrap();
    let screen = succeed(["update", scene]).replace('\n', " ");
    assert!(
        screen.contains("Configurations disagree: k2 = 765"),
        "{screen}"
    );
    assert!(!screen.contains("  identified"), "{screen}");
    let chinese = succeed(["update", scene, "--lang", "zh"]);
    assert!(chinese.contains("各构型不一致：k2 = 765"), "{chinese}");
    // Listed as separate it has both values.
    let separate = CONFIGURATIONS.replace("modify", "separate = [\"k2\"]\nmodify");
    write_scene(folder.path(), &loaded, &separate);
    let file = update(folder.path());
    assert_eq!(file["contradiction"], Value::Null);
    assert!((updated(&file, "k2") / TRUTH[1] - 1.0).abs() < 1e-3);
    assert!((updated(&file, "k2 (with mass)") / loaded[1] - 1.0).abs() < 1e-3);
}

#[test]
fn a_part_with_an_added_mass_has_its_sensors_and_its_updated_model() {
    let folder = tempfile::tempdir().unwrap();
    let part = "[[configuration]]\nname = \"lower storeys\"\ntests = [\"part\"]\nmodel = \"part.toml\"\n\
                modify = [\"mass:2:+X=2.0\"]\n[update]\ntests = [\"whole\", \"part\"]\n";
    write_scene(folder.path(), &TRUTH, part);
    let loaded = storey_modes(&[3.0, 5.0], &TRUTH[..2]);
    // A sensor of the scene on a storey that the part does not have.
    let scene_file = folder.path().join("scene.toml");
    let scene = std::fs::read_to_string(&scene_file).unwrap()
        + "[[sensor]]\ndof = \"7:+X\"\nbody = \"b3\"\nat_m = [0.0, 0.0, 0.0]\n";
    let files = [("part.json", loaded.as_str()), ("scene.toml", &scene)];
    write(folder.path(), &files);
    let out = folder.path().join("out");
    succeed([
        "update",
        scene_file.to_str().unwrap(),
        "-o",
        out.to_str().unwrap(),
    ]);
    let text = std::fs::read_to_string(out.join("lower-storeys.model.toml")).unwrap();
    let model: toml::Table = text.parse().unwrap();
    let parameters = model["parameter"].as_array().unwrap();
    for (parameter, truth) in parameters.iter().zip(TRUTH) {
        let value = parameter["nominal"].as_float().unwrap();
        assert!((value / truth - 1.0).abs() < 1e-3, "{parameter}");
    }
    assert_eq!(parameters.len(), 2);
    // The model of the configuration can be solved alone.
    let scene = scene_file.to_str().unwrap();
    let modes = json(&["theory", scene, "--configuration", "lower storeys"]);
    assert_eq!(modes["modes"].as_array().unwrap().len(), 2);
}

#[test]
fn an_invalid_configuration_is_refused_with_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |configurations: &str| {
        write_scene(folder.path(), &TRUTH, configurations);
        let scene = folder.path().join("scene.toml");
        fail(["update", scene.to_str().unwrap()])
    };
    let table = |keys: &str| format!("[[configuration]]\n{keys}\n");
    let both = table("name = \"base\"\ntests = [\"lost\"]") + &table("name = \"a\"\ntests = []");
    let message = refused(&both);
    for expected in [
        "got \"base\", expected a name other than base",
        "got \"lost\", expected one of the tests whole, loaded, part",
        "[[configuration]] \"a\" tests: got none, expected at least one test",
    ] {
        assert!(message.contains(expected), "{message}");
    }
    let cases = [
        (
            "name = \"a\"\ntests = [\"whole\", \"loaded\", \"part\"]",
            "got every test in a configuration",
        ),
        (
            "name = \"a\"\ntests = [\"loaded\"]\nmodify = [\"mass:9=1\"]",
            "[[configuration]] \"a\" modify: mass:9=1: got `9`",
        ),
        (
            "name = \"a\"\ntests = [\"loaded\"]\nseparate = [\"k9\"]",
            "separate: got \"k9\", expected a free parameter: k1, k2, k3",
        ),
        (
            "name = \"a\"\ntests = [\"loaded\"]\nparameters = { k9 = 1.0 }",
            "k9",
        ),
        (
            "name = \"a\"\ntests = [\"loaded\"]\nparameters = { k2 = 900.0 }\nseparate = [\"k2\"]",
            "separate: got \"k2\" in `parameters`, too",
        ),
        (
            "name = \"a\"\ntests = [\"loaded\"]\nparameters = { k1 = 900.0, k2 = 900.0, k3 = 900.0 }",
            "its model has no free parameter",
        ),
        (
            "name = \"a\"\ntests = [\"loaded\"]\nmodel = \"lost.toml\"",
            "lost.toml",
        ),
    ];
    for (keys, expected) in cases {
        let message = refused(&table(keys));
        assert!(message.contains(expected), "{keys}: {message}");
    }
    // A part whose file has another value of a shared parameter.
    write_scene(folder.path(), &TRUTH, CONFIGURATIONS);
    let part = std::fs::read_to_string(folder.path().join("part.toml")).unwrap();
    let part = part.replacen("nominal = 1000.0", "nominal = 1100.0", 1);
    write(folder.path(), &[("part.toml", part.as_str())]);
    let scene = folder.path().join("scene.toml");
    let message = fail(["update", scene.to_str().unwrap()]);
    let expected = "1100 in the configuration \"lower storeys\" and 1000 in the one before";
    assert!(message.contains(expected), "{message}");
}
