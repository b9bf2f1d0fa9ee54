//! The scene of the beam finds its true modes, and a pair too close for a single-mode method is
//! reported.

use std::path::Path;

use serde_json::Value;

use crate::command::{json, modalign, root, succeed, write};

/// (frequency, damping) of every mode of a modes.json.
fn modes(file: &Value) -> Vec<(f64, f64)> {
    let of = |mode: &Value| {
        (
            mode["frequency_hz"].as_f64().unwrap(),
            mode["damping_ratio"].as_f64().unwrap(),
        )
    };
    file["modes"].as_array().unwrap().iter().map(of).collect()
}

fn run_scene(folder: &Path, out: &Path) -> (Value, Value, Value) {
    succeed(["run", folder.to_str().unwrap(), "-o", out.to_str().unwrap()]);
    let file = |name: &str| json(&out.join(name));
    (
        file("roving-hammer.modes.json"),
        file("roving-hammer.truth.modes.json"),
        file("comparison.json"),
    )
}

/// A copy of the scene with another identification method.
fn scene_with_method(folder: &Path, method: &str) {
    let source = root().join("measurements/free-free-beam");
    for name in ["scene.toml", "model.toml", "synth.toml"] {
        let text = std::fs::read_to_string(source.join(name)).unwrap();
        write(
            folder,
            &[(
                name,
                &text.replace("method = \"circle\"", &format!("method = \"{method}\"")),
            )],
        );
    }
}

#[test]
fn both_methods_find_the_truth_of_the_scene() {
    for (method, damping_percent) in [("circle", 3.0), ("peak", 10.0)] {
        let folder = tempfile::tempdir().unwrap();
        scene_with_method(folder.path(), method);
        let (found, truth, table) = run_scene(folder.path(), &folder.path().join("out"));
        assert!(found["modes"][0]["method"] == method);
        let in_band: Vec<_> = modes(&truth)
            .into_iter()
            .filter(|mode| (60.0..3200.0).contains(&mode.0))
            .collect();
        assert_eq!((modes(&found).len(), in_band.len()), (6, 6), "{method}");
        for (mode, wanted) in modes(&found).into_iter().zip(in_band) {
            let (frequency, damping) = (
                100.0 * (mode.0 / wanted.0 - 1.0),
                100.0 * (mode.1 / wanted.1 - 1.0),
            );
            assert!(
                frequency.abs() < 0.05,
                "{method} at {} Hz: {frequency} %",
                wanted.0
            );
            assert!(
                damping.abs() < damping_percent,
                "{method} at {} Hz: damping {damping} %",
                wanted.0
            );
        }
        assert_eq!(table["summary"]["tests"][0]["paired"], 6);
    }
}

#[test]
fn the_table_has_what_a_validation_section_prints() {
    let text = succeed(["run", "measurements/free-free-beam", "--full", "--quiet"]);
    for part in [
        "theory (Hz)",
        "test (Hz)",
        "(test−theory)/theory (%)",
        "damping (%)",
        "MAC",
        "chance level  basis  verdict",
        "Synthetic",
        "assumed",
    ] {
        assert!(text.contains(part), "{part}:\n{text}");
    }
    let model = json_text(&succeed([
        "theory",
        "measurements/free-free-beam/model.toml",
        "--json",
    ]));
    // Closed form: f = (beta L)^2/(2 pi L^2) sqrt(E I/(rho A)), beta L from Blevins (1979), table
    // 8-1.
    let beta_l: [f64; 6] = [
        4.73004074, 7.85320462, 10.9956078, 14.1371655, 17.2787597, 20.4203522,
    ];
    let wave = (2.1e11f64 * 2.5e-9 / (7850.0 * 3e-4)).sqrt();
    let path = root().join("measurements/free-free-beam/expected.toml");
    let expected = modalign::scene::load_expected(&path).unwrap();
    assert_eq!(expected.roots.len(), 7);
    for (index, beta_l) in beta_l.into_iter().enumerate() {
        let omega = beta_l.powi(2) / 0.36 * wave;
        let printed = expected.roots[index + 1].omega_rad_s;
        assert!((printed / omega - 1.0).abs() < 1e-8, "{printed} {omega}");
        let hz = model["modes"][index + 2]["frequency_hz"].as_f64().unwrap();
        let model_omega = std::f64::consts::TAU * hz;
        assert!(
            (model_omega / omega - 1.0).abs() < 1e-5,
            "mode {}: {model_omega} {omega}",
            index + 1
        );
    }
}

#[test]
fn a_run_prints_the_closed_form_beside_the_model_and_writes_it() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let beam = "measurements/free-free-beam";
    let text = succeed(["run", beam, "--full", "--quiet", "-o", out]);
    let (roots, tests) = (
        text.find("Published natural frequencies and the model")
            .unwrap(),
        text.find("Identified modes").unwrap(),
    );
    assert!(roots < tests, "the published table follows the heading");
    assert!(text.contains("bending, 7 nodes"), "{text}");
    // The whole model, not only the band of the test: 122 modes in more than a hundred roots.
    let above = text.split("above these: ").nth(1).unwrap();
    let above: usize = above.split(',').next().unwrap().parse().unwrap();
    assert!((100..120).contains(&above), "{above}");
    let csv = std::fs::read_to_string(folder.path().join("published-roots.csv")).unwrap();
    assert_eq!(
        csv.lines().filter(|line| line.contains("bar 1.00")).count(),
        7
    );
    let written = std::fs::read_to_string(folder.path().join("comparison.md")).unwrap();
    assert!(written.contains("Published natural frequencies and the model"));
}

fn json_text(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn every_format_holds_the_same_table() {
    let folder = tempfile::tempdir().unwrap();
    let (_, _, table) = run_scene(Path::new("measurements/free-free-beam"), folder.path());
    let text = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    for row in table["rows"].as_array().unwrap() {
        let hz = row["tests"][0]["hz"].as_f64().unwrap();
        for name in ["comparison.md", "comparison.txt"] {
            assert!(text(name).contains(&format!("{hz:.2}")), "{name} {hz}");
        }
        // LaTeX has the digits of the screen.
        let decimals = if hz < 1000.0 { 2 } else { 1 };
        let cell = format!(" & {hz:.decimals$} & ");
        assert!(text("comparison.tex").contains(&cell), "tex {hz}");
        assert!(text("comparison.csv").contains(&hz.to_string()), "csv {hz}");
    }
}

#[test]
fn the_same_scene_gives_the_same_bytes_for_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let beam = crate::command::short_beam(folder.path());
    let out = |name: &str| folder.path().join(name);
    for (name, threads) in [("one", "1"), ("three", "3")] {
        succeed([
            "run",
            &beam,
            "--threads",
            threads,
            "-o",
            out(name).to_str().unwrap(),
        ]);
    }
    for part in [".", "figures"] {
        let entries = std::fs::read_dir(out("one").join(part)).unwrap();
        for entry in entries.map(|entry| entry.unwrap()) {
            let name = entry.file_name();
            let bytes = |folder: &str| std::fs::read(out(folder).join(part).join(&name)).unwrap();
            assert!(
                entry.path().is_dir() || bytes("one") == bytes("three"),
                "{name:?}"
            );
        }
    }
}

/// Truth with two modes `spacing` half-power bandwidths apart near 200 Hz and a lone one at 400 Hz.
fn pair_truth(spacing: f64) -> String {
    let zeta = 0.01;
    let second = 200.0 * (1.0 + 2.0 * zeta * spacing);
    let shapes = [
        [1.0, 0.8, 0.3, -0.4, -0.9],
        [0.9, -0.2, -0.8, -0.5, 0.7],
        [0.7, -0.6, 0.5, -0.8, 0.9],
    ];
    let mode = |(hz, shape): (f64, [f64; 5])| {
        let points: Vec<String> = shape
            .iter()
            .enumerate()
            .map(|(i, v)| format!("\"{}:+Z\": [{v}, 0.0]", i + 1))
            .collect();
        format!(
            "{{\"frequency_hz\": {hz}, \"damping_ratio\": {zeta}, \"scaling\": \"unit-modal-mass\", \"modal_mass_kg\": 1.0, \"shape\": {{{}}}}}",
            points.join(", ")
        )
    };
    let all: Vec<String> = [200.0, second, 400.0]
        .into_iter()
        .zip(shapes)
        .map(mode)
        .collect();
    format!(
        "{{\"schema\": \"modalign-modes/1\", \"modes\": [{}]}}",
        all.join(", ")
    )
}

const PAIR_SPEC: &str = r#"
schema = "modalign-synth/1"
title = "A close pair"
seed = 7
averages = 3
[truth]
modes = "truth.json"
[record]
sampling_rate_hz = 2048
samples = 8192
pretrigger_s = 0.005
response = "acceleration"
[pulse]
duration_s = 1e-3
peak_n = 50
[noise]
force_snr_db = 60
response_snr_db = 60
[[hit]]
dofs = ["1:+Z", "2:+Z", "3:+Z", "4:+Z", "5:+Z"]
responses = ["1:+Z"]
"#;

#[test]
fn a_pair_too_close_for_one_mode_at_a_time_ends_in_a_finding() {
    for spacing in [0.3, 0.5, 1.0, 2.0] {
        let folder = tempfile::tempdir().unwrap();
        write(
            folder.path(),
            &[
                ("truth.json", &pair_truth(spacing)),
                ("spec.toml", PAIR_SPEC),
            ],
        );
        let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        succeed(["synth", &path("spec.toml"), "-o", &path("hits.uff")]);
        succeed([
            "frf",
            &path("hits.uff"),
            "--force-window",
            "0.05",
            "-o",
            &path("frf.uff"),
        ]);
        for method in ["peak", "circle"] {
            succeed([
                "identify",
                &path("frf.uff"),
                "--band",
                "100:500",
                "--method",
                method,
                "-o",
                &path("modes.json"),
            ]);
            let result = json(&folder.path().join("modes.json"));
            let findings = result["findings"].as_array().unwrap();
            let near = |finding: &&Value| {
                finding["place"]["mode"]
                    .as_f64()
                    .is_some_and(|hz| (hz - 200.0).abs() < 15.0)
            };
            let reported = findings
                .iter()
                .filter(near)
                .any(|finding| finding["code"] == "close-modes");
            assert!(reported, "{method} at {spacing}: {findings:#?}");
            let far = |finding: &Value| {
                finding["place"]["mode"]
                    .as_f64()
                    .is_some_and(|hz| (hz - 400.0).abs() < 4.0)
            };
            assert!(
                !findings
                    .iter()
                    .any(|f| far(f) && f["code"] == "close-modes"),
                "{method} at {spacing}: the lone mode"
            );
        }
    }
}

#[test]
fn standard_error_carries_findings_and_quiet_silences_them() {
    let loud = modalign(["run", "measurements/free-free-beam"]);
    assert!(String::from_utf8_lossy(&loud.stderr).contains("synthetic"));
    let quiet = modalign(["run", "measurements/free-free-beam", "--quiet"]);
    assert!(quiet.stderr.is_empty() && quiet.stdout == loud.stdout);
}
