//! Supports and states of tests and models: from `[test.state]` and the model to findings, tables
//! and JSON.

use std::f64::consts::TAU;
use std::path::Path;

use modalign::linalg::{real_matrix, symmetric_modes};
use modalign::theory::{BeamFile, BeamModel, ModeOptions, model_support, modes};
use serde_json::Value;

use crate::command::{fail, json, root, succeed, write};
use crate::updating::{frame, modes_json};

const MASS_KG: f64 = 2.0;
const STOREYS: usize = 4;
const BETWEEN_N_PER_M: f64 = 1e6;
const TO_GROUND_N_PER_M: f64 = 2e5;

/// Natural frequencies, Hz, and shapes of the frame with this stiffness to ground.
fn frame_modes(ground: f64) -> Vec<(f64, Vec<f64>)> {
    let spring = |i: usize| if i == 0 { ground } else { BETWEEN_N_PER_M };
    let stiffness = real_matrix(STOREYS, STOREYS, |i, j| match i.abs_diff(j) {
        0 if i + 1 == STOREYS => spring(i),
        0 => spring(i) + spring(i + 1),
        1 => -spring(i.max(j)),
        _ => 0.0,
    });
    let mass = real_matrix(STOREYS, STOREYS, |i, j| if i == j { MASS_KG } else { 0.0 });
    let solved = symmetric_modes(&stiffness, &mass).unwrap();
    let mode = |r: usize| {
        let shape = (0..STOREYS).map(|i| solved.vectors[(i, r)]).collect();
        (solved.omega_squared[r].max(0.0).sqrt() / TAU, shape)
    };
    (0..STOREYS).map(mode).collect()
}

/// A scene of a frame that two tests with these states measured while it hung.
fn hung_frame(folder: &Path, first: &str, second: &str, model: &str) {
    let mut stiffness = [BETWEEN_N_PER_M; STOREYS];
    stiffness[0] = TO_GROUND_N_PER_M;
    let model_text = frame(MASS_KG, &stiffness, (0.2, 5.0));
    let (schema, parts) = model_text.split_once('\n').unwrap();
    let elastic = frame_modes(0.0).split_off(1);
    let measured: Vec<_> = elastic
        .into_iter()
        .map(|(hz, shape)| (hz, None, shape))
        .collect();
    let scene = format!(
        "schema = \"modalign-scene/1\"\ntitle = \"frame\"\n[model]\nfile = \"model.toml\"\n\
         [[test]]\nname = \"loose\"\nmodes = \"modes.json\"\n[test.state]\n{first}\n\
         [[test]]\nname = \"tight\"\nmodes = \"modes.json\"\n[test.state]\n{second}\n"
    );
    write(
        folder,
        &[
            ("scene.toml", &scene),
            ("model.toml", &format!("{schema}\n{model}\n{parts}")),
            ("modes.json", &modes_json(&measured)),
        ],
    );
}

/// Findings of a code in the report of a run, each with the name of its test.
fn findings(report: &Value, code: &str) -> Vec<(String, Value)> {
    let by_test = report["findings"].as_array().unwrap().iter();
    let of_test = |entry: &Value| -> Vec<(String, Value)> {
        let test = entry[0].as_str().unwrap().to_owned();
        let all = entry[1].as_array().unwrap().iter();
        let wanted = all.filter(|finding| finding["code"] == code);
        wanted
            .map(|finding| (test.clone(), finding.clone()))
            .collect()
    };
    by_test.flat_map(of_test).collect()
}

#[test]
fn hung_test_of_a_held_model_is_reported_with_the_change_of_its_frequencies() {
    let folder = tempfile::tempdir().unwrap();
    let state = "support = \"suspended\"\npreload_n = 50.0";
    let other = "support = \"suspended\"\npreload_n = 200.0\nhighest_rigid_body_hz = 12.0\ndate = \"2026-03-31\"";
    hung_frame(folder.path(), state, other, "");
    let out = folder.path().join("out");
    let text = succeed([
        "run".as_ref(),
        folder.path().as_os_str(),
        "--full".as_ref(),
        "-o".as_ref(),
        out.as_os_str(),
    ]);
    let report = json(&out.join("report.json"));
    let differs = findings(&report, "support-differs");
    assert_eq!(differs.len(), 2);
    let (held, free) = (frame_modes(TO_GROUND_N_PER_M), frame_modes(0.0));
    let percent = 100.0 * (free[1].0 / held[1].0 - 1.0);
    for (_, finding) in &differs {
        let value = finding["value"].as_f64().unwrap();
        assert!((value - percent).abs() < 1e-6, "{finding} {percent}");
        let detail = finding["detail"].as_str().unwrap();
        assert!(
            detail.starts_with("test suspended, model fixed"),
            "{detail}"
        );
    }
    let stiff = findings(&report, "suspension-stiff");
    assert_eq!((stiff.len(), stiff[0].0.as_str()), (1, "tight"));
    for part in ["preload (N)", "2026-03-31", "by its stiffness matrix"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let states = &json(&out.join("comparison.json"))["states"];
    assert_eq!(states["tests"][1]["preload_n"], 200.0);
    assert_eq!(states["tests"][0]["date"], Value::Null);
    assert_eq!(states["model"]["support"]["stated"], Value::Null);
    assert_eq!(states["model"]["support"]["derived"], "fixed");
}

#[test]
fn support_that_the_matrices_contradict_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let state = "support = \"suspended\"";
    hung_frame(folder.path(), state, state, "support = \"suspended\"");
    let out = folder.path().join("out");
    succeed([
        "run".as_ref(),
        folder.path().as_os_str(),
        "-o".as_ref(),
        out.as_os_str(),
    ]);
    let report = json(&out.join("report.json"));
    assert!(findings(&report, "support-differs").is_empty());
    let contradicted = findings(&report, "model-support-contradicted");
    assert_eq!(contradicted.len(), 1);
    // All storeys on the spring to ground.
    let translation_hz = (TO_GROUND_N_PER_M / (STOREYS as f64 * MASS_KG)).sqrt() / TAU;
    let value = contradicted[0].1["value"].as_f64().unwrap();
    assert!((value - translation_hz).abs() < 1e-9, "{value}");
}

#[test]
fn impossible_state_and_support_are_refused_with_their_keys() {
    let folder = tempfile::tempdir().unwrap();
    for (state, model, named) in [
        ("support = \"hung\"", "", ["hung", "suspended"]),
        ("suport = \"fixed\"", "", ["suport", "support"]),
        ("date = \"31.3.2026\"", "", ["[test.state]", "2026-03-31"]),
        (
            "date = 2026-03-31",
            "",
            ["scene.toml:9", "got a date, expected a text in quotes"],
        ),
        ("preload_n = -1.0", "", ["preload_n", "0 N or more"]),
        ("", "support = \"held\"", ["model.toml:2", "mounted"]),
    ] {
        hung_frame(folder.path(), state, "", model);
        let message = fail(["run".as_ref(), folder.path().as_os_str()]);
        for part in named {
            assert!(message.contains(part), "{part}: {message}");
        }
    }
}

/// A foundation that is uniform along a bar adds its stiffness over mass to the square of every
/// frequency: the bias that the finding states.
#[test]
fn bias_of_a_stiff_suspension_is_that_of_the_model_with_its_springs() {
    let text = std::fs::read_to_string(root().join("measurements/free-free-beam/model.toml"));
    let text = text.unwrap();
    let elastic_hz = |springs: &str| {
        let file: BeamFile = toml::from_str(&format!("{text}\n{springs}")).unwrap();
        let model = BeamModel::new(file).unwrap();
        let values: Vec<f64> = [2.1e11, 0.0].into();
        let solved = modes(&model, &values, &[], &ModeOptions::default()).unwrap();
        let support = model_support(&model, &values).unwrap();
        let omega = solved
            .omega_rad_s
            .iter()
            .find(|omega| **omega > TAU * 100.0);
        (omega.unwrap() / TAU, support.translation_hz.unwrap())
    };
    let (free_hz, _) = elastic_hz("");
    let intervals = 20;
    let spring = |i: usize| {
        let end = i == 0 || i == intervals;
        let stiffness = 1.413 * (TAU * 0.1 * free_hz).powi(2) / intervals as f64;
        let stiffness = if end { 0.5 * stiffness } else { stiffness };
        let x = 0.6 * i as f64 / intervals as f64;
        format!(
            "[[spring]]\nname = \"s{i}\"\nbeam = \"bar\"\nat_m = [{x:?}, 0.0, 0.0]\nstiffness_n_per_m = {stiffness:?}\n"
        )
    };
    let springs: String = (0..=intervals).map(spring).collect();
    let (held_hz, rigid_body_hz) = elastic_hz(&springs);
    assert!((rigid_body_hz / (0.1 * free_hz) - 1.0).abs() < 1e-6);
    let bias = held_hz / free_hz - 1.0;
    assert!((bias / 0.005 - 1.0).abs() < 0.02, "{bias}");
}
