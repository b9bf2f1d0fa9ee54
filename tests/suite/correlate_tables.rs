//! `modalign correlate` writes its tables as files, every verb in the chosen language, and missed
//! modes of unknown observability.

use std::path::Path;

use serde_json::Value;

use crate::command::{fail, json, succeed, write};
use crate::updating::{frame, modes_json};

fn text(path: &Path) -> String {
    path.to_str().unwrap().to_owned()
}

/// Modes of two shapes, of which the second test turns the second.
fn two_tests(folder: &Path) -> [String; 2] {
    let modes = |second: [f64; 3]| {
        modes_json(&[
            (10.0, None, vec![1.0, 1.0, 0.0]),
            (20.0, None, second.to_vec()),
        ])
    };
    let (a, b) = (modes([1.0, -1.0, 0.0]), modes([1.0, 0.0, 0.0]));
    write(folder, &[("a.json", &a), ("b.json", &b)]);
    ["a.json", "b.json"].map(|name| text(&folder.join(name)))
}

#[test]
fn several_tests_against_themselves_are_a_csv_file_each() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = two_tests(folder.path());
    let out = folder.path().join("auto.csv");
    succeed(["correlate", "--test", &a, "--test", &b, "-o", &text(&out)]);
    assert!(!out.exists());
    let of = |number: usize| {
        let file = folder.path().join(format!("auto-{number}.csv"));
        std::fs::read_to_string(file).unwrap()
    };
    assert!(
        !of(1).contains("0.5") && of(2).contains("0.5"),
        "{} {}",
        of(1),
        of(2)
    );
    succeed(["correlate", "--test", &b, "-o", &text(&out)]);
    assert_eq!(std::fs::read_to_string(&out).unwrap(), of(2));
}

#[test]
fn numbered_files_are_never_what_is_read_and_keep_their_extension() {
    let folder = tempfile::tempdir().unwrap();
    let [a, _] = two_tests(folder.path());
    let modes = "frequency_hz,damping_ratio,1:+X,2:+X\n10,,1,1\n20,,1,-1\n";
    write(folder.path(), &[("x-2.csv", modes)]);
    let (read, out) = (folder.path().join("x-2.csv"), folder.path().join("x.csv"));
    let error = fail([
        "correlate",
        "--test",
        &a,
        "--test",
        &text(&read),
        "-o",
        &text(&out),
    ]);
    assert!(error.contains("x-2.csv, which is read"), "{error}");
    assert!(!folder.path().join("x-1.csv").exists());
    assert_eq!(std::fs::read_to_string(&read).unwrap(), modes);
    let typed = text(&folder.path().join("y.CSV"));
    succeed([
        "correlate",
        "--test",
        &a,
        "--test",
        &text(&read),
        "-o",
        &typed,
    ]);
    assert!(folder.path().join("y-2.CSV").exists());
}

#[test]
fn the_language_is_that_of_every_verb() {
    let folder = tempfile::tempdir().unwrap();
    write(
        folder.path(),
        &[("model.toml", &frame(1.0, &[1.0e4; 3], (0.1, 10.0)))],
    );
    let model = text(&folder.path().join("model.toml"));
    let (english, chinese) = (
        succeed(["theory", &model, "--full"]),
        succeed(["theory", &model, "--full", "--lang", "zh"]),
    );
    assert!(english.contains("value"), "{english}");
    assert!(
        chinese.contains("数值") && !chinese.contains("value"),
        "{chinese}"
    );
}

#[test]
fn a_missed_mode_of_unknown_observability_is_reported_as_such() {
    let folder = tempfile::tempdir().unwrap();
    write(
        folder.path(),
        &[("model.toml", &frame(1.0, &[1.0e4; 3], (0.1, 10.0)))],
    );
    let at = |name: &str| text(&folder.path().join(name));
    let (model, modes) = (at("model.toml"), at("modes.json"));
    succeed(["theory", &model, "-o", &modes]);
    let mut first = json(Path::new(&modes));
    first["modes"].as_array_mut().unwrap().truncate(1);
    write(folder.path(), &[("modes.json", &first.to_string())]);
    let arguments = ["correlate", "--test", &modes, "--theory", &model];
    let printed = succeed(arguments);
    assert!(printed.contains("observability unknown"), "{printed}");
    let full = succeed(arguments.into_iter().chain(["--full"]));
    assert!(full.contains("unmatched, observability unknown"), "{full}");
    let table: Value =
        serde_json::from_str(&succeed(arguments.into_iter().chain(["--json"]))).unwrap();
    let rows = table["rows"].as_array().unwrap();
    let missed = |row: &&Value| row["tests"][0]["status"] == "missed-unexpected";
    let missed: Vec<&Value> = rows.iter().filter(missed).collect();
    assert!(!missed.is_empty(), "{table}");
    for row in &missed {
        assert_eq!(row["tests"][0]["judged"], Value::Bool(false), "{row}");
    }
    assert_eq!(table["summary"]["tests"][0]["not_judged"], missed.len());
}
