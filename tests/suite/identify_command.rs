//! `identify` with every method, with a choice of poles, with the poles of all orders, with
//! indicators.

use std::path::Path;

use modalign::identify::ESTIMATORS;
use serde_json::Value;

use crate::command::{fail, json, modalign, succeed, write};
use crate::hit_command::{SPEC, TRUTH};

fn text(path: &Path) -> String {
    path.to_str().unwrap().to_owned()
}

/// FRFs of a synthetic hammer test.
fn frfs(folder: &Path) -> String {
    write(folder, &[("truth.json", TRUTH), ("spec.toml", SPEC)]);
    let (hits, frfs) = (folder.join("hits.uff"), folder.join("frfs.h5"));
    succeed([
        "synth",
        &text(&folder.join("spec.toml")),
        "-o",
        &text(&hits),
    ]);
    succeed(["frf", &text(&hits), "-o", &text(&frfs)]);
    text(&frfs)
}

fn frequencies(modes: &Value) -> Vec<f64> {
    let modes = modes["modes"].as_array().unwrap().iter();
    modes
        .map(|mode| mode["frequency_hz"].as_f64().unwrap())
        .collect()
}

#[test]
fn every_method_finds_both_modes_of_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let frfs = frfs(folder.path());
    for method in ESTIMATORS.iter().map(|entry| entry.name) {
        let printed = succeed([
            "--json", "identify", &frfs, "--band", "20:400", "--method", method,
        ]);
        let printed: Value = serde_json::from_str(&printed).unwrap();
        let found = frequencies(&printed);
        assert_eq!(found.len(), 2, "{method} {found:?}");
        for (hz, truth) in found.iter().zip([60.0, 210.0]) {
            assert!((hz / truth - 1.0).abs() < 1e-3, "{method} {hz}");
        }
        let mode = &printed["modes"][0];
        assert!(mode["half_power_lines"].as_f64().unwrap() > 3.0);
        assert!(mode["mean_phase_deviation_rad"].as_f64().unwrap() < 0.05);
    }
}

#[test]
fn a_file_chooses_poles_and_tells_what_it_cannot_have() {
    let folder = tempfile::tempdir().unwrap();
    let frfs = frfs(folder.path());
    let chosen = r#"{"schema": "modalign-selection/1", "poles": [{"frequency_hz": 209.5}]}"#;
    let missed = r#"{"schema": "modalign-selection/1", "tolerance_hz": 1, "poles": [{"frequency_hz": 60.2}, {"frequency_hz": 120}]}"#;
    write(folder.path(), &[("a.json", chosen), ("b.json", missed)]);
    let out = folder.path().join("modes.json");
    let run = |method: &str, selection: &str| {
        let selection = text(&folder.path().join(selection));
        modalign([
            "identify",
            &frfs,
            "--band",
            "20:400",
            "--method",
            method,
            "--selection",
            &selection,
            "-o",
            &text(&out),
        ])
    };
    assert_eq!(run("lscf", "a.json").status.code(), Some(0));
    let found = frequencies(&json(&out));
    assert!(
        found.len() == 1 && (found[0] - 210.0).abs() < 0.2,
        "{found:?}"
    );
    // A method without orders offers its modes alone.
    let output = run("circle", "b.json");
    assert_eq!(output.status.code(), Some(1));
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(error.contains("selection-missed"), "{error}");
    assert_eq!(frequencies(&json(&out)).len(), 1);
}

#[test]
fn poles_of_all_orders_and_indicators_are_written_as_tables() {
    let folder = tempfile::tempdir().unwrap();
    let frfs = frfs(folder.path());
    let (poles, lines) = (
        folder.path().join("poles.csv"),
        folder.path().join("lines.csv"),
    );
    let printed = succeed([
        "identify",
        &frfs,
        "--band",
        "20:400",
        "--method",
        "lscf",
        "--order",
        "20",
        "--stabilization",
        &text(&poles),
        "--indicators",
        &text(&lines),
    ]);
    assert!(printed.contains("MvMIF: eigenvalues"), "{printed}");
    let poles = std::fs::read_to_string(poles).unwrap();
    assert!(poles.starts_with("order,f (Hz),damping (%),status"));
    let order = |line: &str| line.split(',').next().unwrap().parse::<usize>().unwrap();
    assert_eq!(poles.lines().skip(1).map(order).max(), Some(20));
    let chosen = poles.lines().filter(|line| line.ends_with(",chosen"));
    assert_eq!(chosen.count(), 2);
    let lines = std::fs::read_to_string(lines).unwrap();
    let head = "f (Hz),sum of FRFs (m/(N s)),NMIF,CMIF 1 (m/(N s)),MvMIF 1";
    assert_eq!(lines.lines().next(), Some(head));
    // 4 s of record: lines every 0.25 Hz, both ends of the band in.
    assert_eq!(lines.lines().count(), 1 + 4 * 380 + 1);
}

#[test]
fn options_that_a_method_lacks_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let frfs = frfs(folder.path());
    let poles = text(&folder.path().join("poles.csv"));
    let circle = ["identify", &frfs, "--method", "circle"];
    let error = fail(circle.into_iter().chain(["--order", "20"]));
    assert!(error.contains("lscf"), "{error}");
    let error = fail(circle.into_iter().chain(["--stabilization", &poles]));
    assert!(error.contains("--stabilization"), "{error}");
}

#[test]
fn windows_are_stated_by_name_and_another_name_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let frfs = frfs(folder.path());
    for name in ["none", "rectangular", "uniform", "hann", "flat-top"] {
        succeed(["identify", &frfs, "--window", name]);
    }
    let accepted = |error: &str| {
        let names = [
            "none",
            "rectangular",
            "uniform",
            "hann",
            "flat-top",
            "force",
        ];
        names.iter().all(|name| error.contains(name))
    };
    let error = fail(["identify", &frfs, "--window", "hamming"]);
    assert!(error.contains("hamming") && accepted(&error), "{error}");
    // A scene is refused before its files are looked for.
    let scene = |window: &str| {
        let toml = format!(
            "schema = \"modalign-scene/1\"\ntitle = \"t\"\n[[test]]\nname = \"a\"\nfiles = [\"absent.uff\"]\nwindow = {window:?}\n"
        );
        write(folder.path(), &[("scene.toml", &toml)]);
        fail(["run", &text(folder.path())])
    };
    let error = scene("hamming");
    assert!(error.contains("window") && accepted(&error), "{error}");
    assert!(scene("none").contains("absent.uff"));
}

#[test]
fn polymax_is_another_name_of_lscf() {
    let folder = tempfile::tempdir().unwrap();
    let frfs = frfs(folder.path());
    let modes = |method: &str| succeed(["identify", &frfs, "--method", method, "--json"]);
    assert_eq!(modes("polymax"), modes("lscf"));
}

#[test]
fn identifying_no_mode_is_exit_code_1_with_advice() {
    let folder = tempfile::tempdir().unwrap();
    let frfs = frfs(folder.path());
    let output = modalign(["identify", &frfs, "--band", "120:150", "--method", "peak"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(
        text.contains("no modes were found between 120 and 150 Hz"),
        "{text}"
    );
    assert!(text.contains("Try another band (--band)"), "{text}");
}

/// The true natural frequencies of the beam below the end of its band.
const BEAM_HZ: [f64; 6] = [143.209, 394.929, 774.528, 1280.829, 1914.051, 2674.309];

#[test]
fn units_that_files_lack_are_stated_by_an_option() {
    let folder = tempfile::tempdir().unwrap();
    let frfs = frfs(folder.path());
    let at = |name: &str| text(&folder.path().join(name));
    let expected =
        frequencies(&serde_json::from_str(&succeed(["identify", &frfs, "--json"])).unwrap());
    // Universal files of text, with an unknown quantity in the place of acceleration and force.
    let without_units = |text: &str| -> String {
        let line = |line: &str| {
            let is_quantity = ["        12    0", "        13    0"]
                .iter()
                .any(|code| line.starts_with(code));
            match is_quantity {
                true => "         0    0    0    0 NONE                 NONE",
                false => line,
            }
            .to_owned()
        };
        text.lines().map(line).collect::<Vec<_>>().join("\n") + "\n"
    };
    let beam = crate::command::root().join("measurements/free-free-beam");
    let spec = std::fs::read_to_string(beam.join("synth.toml")).unwrap();
    let model = std::fs::read_to_string(beam.join("model.toml")).unwrap();
    let spec = spec.replace("samples = 32768", "samples = 8192");
    write(
        folder.path(),
        &[("beam.toml", &spec), ("model.toml", &model)],
    );
    succeed(["synth", &at("beam.toml"), "-o", &at("beam.uff")]);
    for (from, to, verb, unit) in [
        (frfs.as_str(), "frfs.uff", "identify", "(m/s2)/N"),
        (at("beam.uff").as_str(), "hits-text.uff", "frf", "N,m/s2"),
    ] {
        succeed(["convert", from, "-o", &at(to), "--text"]);
        let bare = without_units(&std::fs::read_to_string(at(to)).unwrap());
        std::fs::write(at(to), bare).unwrap();
        let error = fail([verb, &at(to)]);
        let expected_words = if verb == "frf" {
            "force record"
        } else {
            "unit"
        };
        assert!(error.contains(expected_words), "{verb}: {error}");
        let out = at(&format!("{verb}.h5"));
        let modes = match verb {
            "frf" => {
                succeed([verb, &at(to), "--unit", unit, "-o", &out]);
                // Units that the file states stay.
                let (again, plain) = (at("again.h5"), at("plain.h5"));
                succeed([verb, from, "--unit", "lbf,g", "-o", &again]);
                succeed([verb, from, "-o", &plain]);
                assert_eq!(std::fs::read(again).unwrap(), std::fs::read(plain).unwrap());
                succeed(["identify", &out, "--json"])
            }
            _ => succeed([verb, &at(to), "--unit", unit, "--json"]),
        };
        let modes: Value = serde_json::from_str(&modes).unwrap();
        let expected = if verb == "frf" {
            &BEAM_HZ[..]
        } else {
            &expected
        };
        let found = frequencies(&modes);
        assert_eq!(found.len(), expected.len());
        for (hz, expected) in found.iter().zip(expected) {
            assert!((hz / expected - 1.0).abs() < 1e-4, "{hz} {expected}");
        }
    }
}
