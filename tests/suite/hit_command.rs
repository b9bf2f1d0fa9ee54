//! `frf` reports every hit, in recordings with bad hits and in continuous recordings.

use std::path::Path;

use modalign::axis::TimeAxis;
use modalign::io::{WriteOptions, hit_source, write_path};
use modalign::record::{Channel, Hit, Samples};
use modalign::scene::{hammer_test, load_synth};
use modalign::synth::SecondContact;
use serde_json::Value;

use crate::command::{fail, succeed, write};

pub const SPEC: &str = r#"schema = "modalign-synth/1"
title = "two masses"
seed = 5
averages = 5
truth = { modes = "truth.json" }
record = { sampling_rate_hz = 2048, samples = 8192, pretrigger_s = 0.1, response = "acceleration" }
pulse = { duration_s = 2e-3, peak_n = 100, peak_spread = 0.2 }
noise = { force_snr_db = 70, response_snr_db = 60 }
[[hit]]
dofs = ["1:+Z"]
responses = ["1:+Z", "2:+Z"]
"#;
pub const TRUTH: &str = r#"{"schema": "modalign-modes/1", "modes": [
{"frequency_hz": 60.0, "damping_ratio": 0.01, "modal_mass_kg": 2.0, "shape": {"1:+Z": [1, 0], "2:+Z": [0.7, 0]}},
{"frequency_hz": 210.0, "damping_ratio": 0.01, "modal_mass_kg": 2.0, "shape": {"1:+Z": [0.8, 0], "2:+Z": [-1, 0]}}]}"#;

/// The hits of the spec; the third one touches twice where it is asked for.
fn hits(folder: &Path, double: bool) -> Vec<Hit> {
    write(folder, &[("truth.json", TRUTH), ("spec.toml", SPEC)]);
    let path = folder.join("spec.toml");
    let mut test = hammer_test(&load_synth(&path).unwrap(), &path).unwrap();
    test.faults.second_contact = double.then(|| SecondContact {
        delay_s: 0.02,
        ratio: 0.4,
        hits: [2].into(),
    });
    test.generate().unwrap()
}

fn summary(arguments: &[&str]) -> Value {
    serde_json::from_str(&succeed(arguments)).unwrap()
}

fn used(summary: &Value) -> Vec<bool> {
    let hits = summary["hits"].as_array().unwrap().iter();
    hits.map(|hit| hit["used"].as_bool().unwrap()).collect()
}

#[test]
fn a_double_hit_is_listed_with_its_numbers_left_out_and_taken_back_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("hits.uff");
    let mut source = hit_source(&hits(folder.path(), true), "double");
    write_path(&input, &mut source, WriteOptions::default()).unwrap();
    let input = input.to_str().unwrap();
    let printed = summary(&["--json", "frf", input]);
    assert_eq!(used(&printed), [true, true, false, true, true]);
    assert_eq!(printed["functions"][0]["averages"], 4);
    let third = &printed["hits"][2];
    let checks = third["checks"].as_array().unwrap();
    let double = checks
        .iter()
        .find(|check| check["rule"] == "double-hit")
        .unwrap();
    assert_eq!(
        (&third["hit"], &double["outcome"]),
        (&3.into(), &"rejected".into())
    );
    let ratio = double["value"].as_f64().unwrap();
    assert!((ratio - 0.4).abs() < 0.02, "{ratio}");
    assert!((double["at"].as_f64().unwrap() - 0.02).abs() < 1e-3);
    // Every rule of every hit is there, passed or not.
    let rules = |hit: &Value| hit["checks"].as_array().unwrap().len();
    assert!(
        printed["hits"]
            .as_array()
            .unwrap()
            .iter()
            .all(|hit| rules(hit) >= 15)
    );
    let table = succeed(["frf", input]);
    assert!(table.contains("rejected  double-hit 0.4"), "{table}");
    let stated = summary(&["--json", "frf", input, "--accept", "3", "--reject", "1,2"]);
    assert_eq!(used(&stated), [false, false, true, true, true]);
    assert_eq!(stated["hits"][0]["decided_by"], "user");
    let all = summary(&["--json", "frf", input, "--keep-all"]);
    assert_eq!(all["functions"][0]["averages"], 5);
    let error = fail(["frf", input, "--reject", "6"]);
    assert!(
        error.contains("got hit 6 to accept or reject, expected 1 to 5"),
        "{error}"
    );
}

/// All hits one after the other in one record.
fn continuous(hits: &[Hit]) -> Hit {
    let join = |channel: fn(&Hit) -> &Channel| {
        let samples = hits.iter().flat_map(|hit| channel(hit).samples.to_f64());
        Channel {
            samples: Samples::F64(samples.collect()),
            ..channel(&hits[0]).clone()
        }
    };
    Hit {
        axis: TimeAxis {
            len: hits.iter().map(|hit| hit.axis.len).sum(),
            ..hits[0].axis
        },
        force: join(|hit| &hit.force),
        responses: vec![join(|hit| &hit.responses[0]), join(|hit| &hit.responses[1])],
        origin: String::new(),
    }
}

#[test]
fn hits_are_cut_out_of_a_continuous_recording() {
    let folder = tempfile::tempdir().unwrap();
    let hits = hits(folder.path(), false);
    let input = folder.path().join("long.h5");
    let mut source = hit_source(&[continuous(&hits)], "long");
    write_path(&input, &mut source, WriteOptions::default()).unwrap();
    let input = input.to_str().unwrap();
    let printed = summary(&[
        "--json",
        "frf",
        input,
        "--hits",
        "trigger",
        "--pretrigger",
        "0.05",
    ]);
    assert_eq!(used(&printed), [true; 5]);
    assert_eq!(printed["functions"][1]["averages"], 5);
    let lines = printed["axis"]["lines"].as_u64().unwrap();
    // The last hit has 8192 samples less the half of its pre-trigger that is not asked for.
    assert!((4030..=4050).contains(&lines), "{lines}");
    let origin = printed["hits"][1]["origin"].as_str().unwrap();
    assert!(
        origin.ends_with(" s") && origin.contains("record 1 at 4.0"),
        "{origin}"
    );
    let short = [
        "--json",
        "frf",
        input,
        "--hits",
        "trigger",
        "--hit-length",
        "2",
    ];
    assert_eq!(summary(&short)["axis"]["lines"], 2049);
    let error = fail(["frf", input, "--hits", "trigger", "--trigger-level", "1e6"]);
    assert!(error.contains("1000000"), "{error}");
}

#[test]
fn a_scene_states_the_same_as_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let mut source = hit_source(&hits(folder.path(), true), "double");
    write_path(
        &folder.path().join("hits.uff"),
        &mut source,
        WriteOptions::default(),
    )
    .unwrap();
    let scene = |test: &str, frf: &str| {
        let text = format!(
            "schema = \"modalign-scene/1\"\ntitle = \"t\"\n[[test]]\nname = \"t\"\nfiles = [\"hits.uff\"]\n{test}\n[frf]\n{frf}\n"
        );
        write(folder.path(), &[("scene.toml", &text)]);
        folder.path().join("scene.toml")
    };
    let plain = scene("accept = [3]\nreject = [1]", "response_window_end = 0.05");
    let printed = summary(&["--json", "frf", plain.to_str().unwrap()]);
    assert_eq!(used(&printed), [false, true, true, true, true]);
    assert!(printed["added_damping_rad_s"].as_f64().unwrap() > 0.7);
    let path = scene("", "response_window = \"sometimes\"");
    let error = fail(["frf", path.to_str().unwrap()]);
    assert!(
        error.contains("response_window") && error.contains("\"auto\""),
        "{error}"
    );
}
