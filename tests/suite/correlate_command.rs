//! `modalign correlate` beside its table: measures, a set of modes against itself, FRFs against FRFs, and two real recordings
//! against what is known of them.

use std::path::Path;

use serde_json::Value;

use crate::command::{fail, json, modalign, shared_data, succeed, write};
use crate::hit_command::{SPEC, TRUTH};
use crate::updating::{four_storeys, frame, modes_json};

fn text(path: &Path) -> String {
    path.to_str().unwrap().to_owned()
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is a number"))
}

/// A frame of three storeys of 1 kg and its modes as the model has them, as files.
fn three_storeys(folder: &Path) -> (String, String) {
    let model = frame(1.0, &[1.0e4; 3], (0.1, 10.0));
    write(folder, &[("model.toml", &model)]);
    let (model, modes) = (text(&folder.join("model.toml")), folder.join("modes.json"));
    succeed(["theory", &model, "-o", &text(&modes)]);
    (model, text(&modes))
}

#[test]
fn measures_stand_below_the_table_and_in_its_json() {
    let folder = tempfile::tempdir().unwrap();
    let (model, modes) = three_storeys(folder.path());
    let arguments = ["correlate", "--test", &modes, "--theory", &model];
    let printed = succeed(
        arguments
            .into_iter()
            .chain(["--measures", "--orthogonality", "guyan"]),
    );
    for heading in [
        "MAC of ",
        "MAC over both frequencies (FMAC)",
        "Modal scale factors from theory to ",
        "(COMAC)",
        "AutoMAC of the theory at the sensors",
        "Cross-orthogonality",
        "Self-orthogonality",
    ] {
        assert!(printed.contains(heading), "{heading} is missing: {printed}");
    }
    assert!(printed.contains("Allemang and Brown 1982); 3 degrees of freedom."));
    let plain: Value =
        serde_json::from_str(&succeed(arguments.into_iter().chain(["--json"]))).unwrap();
    assert!(plain.get("measures").is_none());
    let more = ["--json", "--measures", "--orthogonality", "serep"];
    let whole: Value = serde_json::from_str(&succeed(arguments.into_iter().chain(more))).unwrap();
    assert_eq!(plain["rows"], whole["rows"]);
    let own = &whole["measures"][0];
    assert_eq!(own["test"], modes.as_str());
    for i in 0..3 {
        assert!((number(&own["mac"]["mac"][i][i]) - 1.0).abs() < 1e-12);
        assert!((number(&own["orthogonality"]["cross"][i][i]) - 1.0).abs() < 1e-9);
        assert!((number(&own["coordinates"][i]["comac"]) - 1.0).abs() < 1e-12);
        assert!((number(&own["scale_factors"][i]["magnitude"]) - 1.0).abs() < 1e-9);
    }
    assert!(number(&own["orthogonality"]["cross"][0][1]) < 1e-9);
    // Shapes of equal masses are at right angles as they are.
    assert!(number(&own["mac"]["mac"][0][1]) < 1e-12);
}

#[test]
fn finished_modes_have_no_mass_matrix() {
    let folder = tempfile::tempdir().unwrap();
    let (model, modes) = three_storeys(folder.path());
    let arguments = ["correlate", "--test", &modes, "--theory"];
    let error = fail(
        arguments
            .into_iter()
            .chain([modes.as_str(), "--orthogonality", "guyan"]),
    );
    assert!(error.contains("no mass matrix"), "{error}");
    let error = fail(
        arguments
            .into_iter()
            .chain([model.as_str(), "--orthogonality", "irs"]),
    );
    assert!(error.contains("guyan or serep"), "{error}");
}

#[test]
fn a_test_alone_is_held_against_itself() {
    let folder = tempfile::tempdir().unwrap();
    let shape = |last: f64| vec![1.0, 2.0, last];
    let modes = modes_json(&[
        (100.0, None, shape(3.0)),
        (101.0, None, shape(3.1)),
        (150.0, None, shape(-3.0)),
    ]);
    write(folder.path(), &[("modes.json", &modes)]);
    let modes = text(&folder.path().join("modes.json"));
    let output = modalign(["correlate", "--test", &modes, "--json"]);
    assert_eq!(output.status.code(), Some(0));
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(
        error.contains("duplicate-modes") && error.contains("101.00 Hz"),
        "{error}"
    );
    let own: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(own["schema"], "modalign-automac/1");
    let found = own["tests"][0]["duplicates"].as_array().unwrap();
    assert_eq!(found.len(), 1);
    assert_eq!(
        (&found[0]["first"]["mode"], &found[0]["second"]["mode"]),
        (&1.into(), &2.into())
    );
    let error = fail(["correlate", "--test", &modes, "--measures"]);
    assert!(error.contains("--theory"), "{error}");
}

#[test]
fn frfs_are_compared_by_function_and_by_line() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[("truth.json", TRUTH), ("spec.toml", SPEC)]);
    let at = |name: &str| text(&folder.path().join(name));
    succeed(["synth", &at("spec.toml"), "-o", &at("hits.uff")]);
    succeed(["frf", &at("hits.uff"), "-o", &at("h1.h5")]);
    succeed([
        "frf",
        &at("hits.uff"),
        "--estimator",
        "h2",
        "-o",
        &at("h2.uff"),
    ]);
    let both = [
        "correlate",
        "--test",
        &at("h1.h5"),
        "--theory",
        &at("h2.uff"),
    ]
    .map(str::to_owned);
    let run = |more: &[&str]| succeed(both.iter().map(String::as_str).chain(more.iter().copied()));
    let printed = run(&["--band", "20:400", "--lines", &at("lines.csv")]);
    assert!(printed.contains("FRAC = ") && printed.contains("Zang, Grafe and Imregun 2001"));
    let lines = std::fs::read_to_string(at("lines.csv")).unwrap();
    assert_eq!(lines.lines().next(), Some("f (Hz),shape,amplitude"));
    let own: Value = serde_json::from_str(&run(&["--json", "--band", "20:400"])).unwrap();
    assert_eq!(own["schema"], "modalign-frf-correlation/1");
    let own = &own["tests"][0];
    assert_eq!(
        own["lines"].as_array().unwrap().len() + 1,
        lines.lines().count()
    );
    for function in own["functions"].as_array().unwrap() {
        // H1 and H2 of one recording differ by its coherence.
        let frac = number(&function["frac"]);
        assert!(frac > 0.99 && frac < 1.0, "{frac}");
    }
    let error = fail(both.iter().map(String::as_str).chain(["--measures"]));
    assert!(error.contains("modes on both sides"), "{error}");
}

const LMS: &str = "lms-testlab-modes/OOP_inb_new_attach_0_30Hz_no euler.unv";

#[test]
fn near_duplicates_of_a_ground_vibration_test_are_flagged() {
    let Some(data) = shared_data() else { return };
    let expected = json(&data.join("expected.json"))[LMS].clone();
    let file = text(&data.join(LMS));
    let output = modalign(["correlate", "--test", &file, "--json"]);
    let own: Value = serde_json::from_slice(&output.stdout).unwrap();
    let own = &own["tests"][0];
    let mac = |i: usize, j: usize| number(&own["matrix"]["mac"][i - 1][j - 1]);
    // As printed, to half of their last digit.
    assert!((mac(1, 2) - number(&expected["automac_12"])).abs() < 5e-9);
    assert!((mac(1, 3) - number(&expected["automac_13"])).abs() < 5e-8);
    assert!((mac(14, 15) - number(&expected["automac_max_offdiag"])).abs() < 5e-8);
    let duplicates = own["duplicates"].as_array().unwrap();
    let flagged = |a: usize, b: usize| {
        duplicates
            .iter()
            .any(|own| own["first"]["mode"] == a && own["second"]["mode"] == b)
    };
    assert!(flagged(14, 15), "{duplicates:?}");
    let above = (1..=16).flat_map(|i| (i + 1..=16).map(move |j| (i, j)));
    let above: Vec<_> = above.filter(|&(i, j)| mac(i, j) >= 0.9).collect();
    assert!(duplicates.len() <= above.len());
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(error.contains("duplicate-modes"), "{error}");
}

#[test]
fn the_four_storey_frame_starts_with_its_published_errors_and_shapes() {
    let Some(data) = shared_data() else { return };
    let (hz, shapes) = four_storeys(&data.join("fourstory-updating/FourStoryStructure.mat"));
    // Storey masses of 12.060 kip over 386.088 in/s2, stiffnesses of 10 kip/in.
    let (kip, inch) = (4448.2216152605, 0.0254);
    let (mass, stiffness) = (12.060 / 386.088 * kip / inch, 10.0 * kip / inch);
    let model = frame(mass, &[stiffness; 4], (0.05, 2.0));
    let modes: Vec<_> = hz
        .iter()
        .zip(shapes)
        .map(|(&hz, shape)| (hz, None, shape))
        .collect();
    let folder = tempfile::tempdir().unwrap();
    write(
        folder.path(),
        &[("model.toml", &model), ("modes.json", &modes_json(&modes))],
    );
    let at = |name: &str| text(&folder.path().join(name));
    let table = succeed([
        "correlate",
        "--test",
        &at("modes.json"),
        "--theory",
        &at("model.toml"),
        "--error-reference",
        "test",
        "--measures",
        "--json",
    ]);
    let table: Value = serde_json::from_str(&table).unwrap();
    // Published to 5 digits (MAC), 5 decimals (Hz) and one decimal (percent).
    let mac = [0.99792, 0.95233, 0.73599, 0.70307];
    let theory_hz = [0.98899, 2.84767, 4.36288, 5.35187];
    let percent = [12.0, 3.6, 1.5, -3.2];
    for i in 0..4 {
        let row = &table["rows"][i];
        let cell = &row["tests"][0];
        assert_eq!(cell["modes"][0], i + 1);
        assert!((number(&row["theory"]["hz"]) - theory_hz[i]).abs() < 5e-6 + 1e-12);
        assert!(
            (number(&cell["mac"]) - mac[i]).abs() < 5e-6 + 1e-12,
            "{cell}"
        );
        assert!(
            (number(&cell["error_percent"]) - percent[i]).abs() < 0.05 + 1e-12,
            "{cell}"
        );
        let own = &table["measures"][0]["mac"]["mac"][i][i];
        assert_eq!(own, &cell["mac"]);
    }
}

#[test]
fn the_help_of_every_verb_has_an_example() {
    let help = succeed(["--help"]);
    let verbs = help
        .lines()
        .skip_while(|line| !line.starts_with("Commands:"))
        .skip(1);
    let verbs = verbs.take_while(|line| line.starts_with("  "));
    let verbs: Vec<&str> = verbs
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert!(
        verbs.contains(&"correlate") && verbs.len() >= 10,
        "{verbs:?}"
    );
    for verb in verbs.iter().filter(|verb| **verb != "help") {
        let help = succeed([verb, "--help"]);
        let example = help.split("Example").nth(1).unwrap_or_default();
        assert!(
            example.contains(&format!("modalign {verb} ")),
            "{verb}: {help}"
        );
    }
}
