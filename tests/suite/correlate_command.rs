//! `modalign correlate` beside its table: measures, a set of modes against itself, FRFs against
//! FRFs, and two real recordings against published results.

use std::path::Path;

use serde_json::Value;

use crate::command::{fail, json, modalign, shared_data, succeed, write};
use crate::hit_command::{SPEC, TRUTH};
use crate::mode_files::universal_file;
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
fn measures_are_below_the_table_and_in_its_json() {
    let folder = tempfile::tempdir().unwrap();
    let (model, modes) = three_storeys(folder.path());
    let arguments = ["correlate", "--test", &modes, "--theory", &model];
    let printed =
        succeed(
            arguments
                .into_iter()
                .chain(["--measures", "--orthogonality", "guyan", "--full"]),
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
    let of_pair = &whole["measures"][0];
    assert_eq!(of_pair["test"], modes.as_str());
    for i in 0..3 {
        assert!((number(&of_pair["mac"]["mac"][i][i]) - 1.0).abs() < 1e-12);
        assert!((number(&of_pair["orthogonality"]["cross"][i][i]) - 1.0).abs() < 1e-9);
        assert!((number(&of_pair["coordinates"][i]["comac"]) - 1.0).abs() < 1e-12);
        assert!((number(&of_pair["scale_factors"][i]["magnitude"]) - 1.0).abs() < 1e-9);
    }
    assert!(number(&of_pair["orthogonality"]["cross"][0][1]) < 1e-9);
    // Shapes of equal masses are at right angles as they are.
    assert!(number(&of_pair["mac"]["mac"][0][1]) < 1e-12);
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
fn a_single_test_is_compared_with_itself() {
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
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(printed["schema"], "modalign-automac/1");
    let found = printed["tests"][0]["duplicates"].as_array().unwrap();
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
    let printed: Value = serde_json::from_str(&run(&["--json", "--band", "20:400"])).unwrap();
    assert_eq!(printed["schema"], "modalign-frf-correlation/1");
    let test = &printed["tests"][0];
    assert_eq!(
        test["lines"].as_array().unwrap().len() + 1,
        lines.lines().count()
    );
    for function in test["functions"].as_array().unwrap() {
        // H1 and H2 of one recording differ by its coherence.
        let frac = number(&function["frac"]);
        assert!(frac > 0.99 && frac < 1.0, "{frac}");
    }
    let error = fail(both.iter().map(String::as_str).chain(["--measures"]));
    assert!(error.contains("modes on both sides"), "{error}");
}

#[test]
fn options_that_need_a_theory_are_refused_without_one() {
    for given in [
        &["--band", "20:400"][..],
        &["--lines", "lines.csv"],
        &["--dof-map", "map.csv"],
        &["--nearest-node", "0.01"],
        &["--nearest-node", "0.01", "--align"],
        &["--max-frequency-error", "0.1"],
        &["--min-mac", "0.5"],
        &["--error-reference", "test"],
    ] {
        let error = fail(["correlate", "--test", "modes.json"].iter().chain(given));
        assert!(error.contains("--theory"), "{given:?}: {error}");
    }
}

const LMS: &str = "lms-testlab-modes/OOP_inb_new_attach_0_30Hz_no euler.unv";

#[test]
fn near_duplicates_of_a_ground_vibration_test_are_flagged() {
    let Some(data) = shared_data() else { return };
    let expected = json(&data.join("expected.json"))[LMS].clone();
    let file = text(&data.join(LMS));
    let output = modalign(["correlate", "--test", &file, "--json"]);
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    let test = &printed["tests"][0];
    let mac = |i: usize, j: usize| number(&test["matrix"]["mac"][i - 1][j - 1]);
    // As printed, to half of their last digit.
    assert!((mac(1, 2) - number(&expected["automac_12"])).abs() < 5e-9);
    assert!((mac(1, 3) - number(&expected["automac_13"])).abs() < 5e-8);
    assert!((mac(14, 15) - number(&expected["automac_max_offdiag"])).abs() < 5e-8);
    let duplicates = test["duplicates"].as_array().unwrap();
    let flagged = |a: usize, b: usize| {
        duplicates
            .iter()
            .any(|pair| pair["first"]["mode"] == a && pair["second"]["mode"] == b)
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
        let of_all = &table["measures"][0]["mac"]["mac"][i][i];
        // One is computed from a product of all shapes, the other from the pair alone.
        assert!((number(of_all) - number(&cell["mac"])).abs() < 1e-14);
    }
}

#[test]
fn the_help_names_every_method_and_format() {
    // The help wraps its lines.
    let help = succeed(["identify", "--help"]);
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    let methods = modalign::identify::ESTIMATORS
        .iter()
        .map(|entry| entry.name);
    let methods = methods.collect::<Vec<_>>().join(", ");
    assert!(help.contains(&format!("one of {methods};")), "{help}");
    let formats = modalign::io::FORMATS.iter().map(|format| format.name());
    let formats = formats.collect::<Vec<_>>().join(", ");
    assert!(help.contains(&format!("({formats})")), "{help}");
}

#[test]
fn the_help_of_every_verb_has_an_example() {
    let help = succeed(["--help"]);
    let verbs = help
        .lines()
        .skip_while(|line| !line.starts_with("Commands:"))
        .skip(1);
    let verbs = verbs.take_while(|line| line.starts_with("  "));
    // The text of a verb goes on in lines that begin farther in.
    let first = verbs.filter(|line| !line.starts_with("   "));
    let verbs: Vec<&str> = first
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

/// Two motions of a bracket, as displacements of its points.
fn motions(points: &[[f64; 3]]) -> [(f64, Vec<[f64; 3]>); 3] {
    let of = |motion: fn(&[f64; 3]) -> [f64; 3]| points.iter().map(motion).collect();
    [
        (50.0, of(|[x, y, _]| [0.0, x * y, x * x])),
        (90.0, of(|[x, y, _]| [y * y, -x, 0.3 - x * x])),
        (130.0, of(|[x, y, z]| [z - y, 0.2 * x, *y])),
    ]
}

/// A bracket as the theory has it, and turned by a quarter about z and by 30 degrees about the new
/// y, in millimetres.
fn bracket(folder: &Path) -> [String; 2] {
    let mut points: Vec<[f64; 3]> = (0..7).map(|i| [0.2 * f64::from(i), 0.0, 0.0]).collect();
    points.extend((1..5).map(|i| [0.0, 0.15 * f64::from(i), 0.05 * f64::from(i)]));
    let (sin, cos) = 30f64.to_radians().sin_cos();
    let turn = |[x, y, z]: [f64; 3]| [-cos * y + sin * z, x, sin * y + cos * z];
    let place = |at: [f64; 3]| {
        let [x, y, z] = turn(at);
        [1e3 * (x + 2.0), 1e3 * (y - 1.0), 1e3 * z]
    };
    let nodes = |first: i64, at: &dyn Fn([f64; 3]) -> [f64; 3]| -> Vec<(i64, [f64; 3])> {
        (first..).zip(&points).map(|(n, p)| (n, at(*p))).collect()
    };
    let modes = motions(&points);
    let turned = |(hz, shape): &(f64, Vec<[f64; 3]>)| {
        // Sensor 4 is mounted the other way round.
        let shape = shape.iter().enumerate();
        let value = |(i, v): (usize, &[f64; 3])| turn(*v).map(|v| if i == 3 { -v } else { v });
        (*hz, shape.map(value).collect())
    };
    let test: Vec<_> = modes.iter().map(turned).collect();
    let files = [
        ("test.unv", universal_file(&nodes(1, &place), &test)),
        ("theory.unv", universal_file(&nodes(101, &|p| p), &modes)),
    ];
    write(
        folder,
        &files.each_ref().map(|(name, text)| (*name, text.as_str())),
    );
    files.map(|(name, _)| text(&folder.join(name)))
}

#[test]
fn a_test_in_another_frame_is_aligned_and_its_reversed_sensor_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let [test, theory] = bracket(folder.path());
    let files = ["correlate", "--test", &test, "--theory", &theory];
    let run = |more: &[&str]| -> (Value, String) {
        let arguments = files
            .into_iter()
            .chain(["--nearest-node", "0.002", "--json"]);
        let output = modalign(arguments.chain(more.iter().copied()));
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{error}");
        (serde_json::from_slice(&output.stdout).unwrap(), error)
    };
    let macs = |table: &Value| -> Vec<f64> {
        let rows = table["rows"].as_array().unwrap().iter();
        rows.map(|row| number(&row["tests"][0]["mac"])).collect()
    };
    let (table, error) = run(&["--align"]);
    let frame = &table["alignment"];
    assert!((number(&frame["scale"]) - 1e-3).abs() < 1e-9, "{frame}");
    assert!(
        number(&frame["largest_m"]) < 1e-9 && frame["known"] == false,
        "{frame}"
    );
    assert!(
        error.contains("nodes-aligned") && error.contains("reversed-sensor"),
        "{error}"
    );
    let sensors = table["reversed_sensors"][0]["sensors"].as_array().unwrap();
    assert!(!sensors.is_empty());
    for sensor in sensors {
        assert!(
            sensor["dof"].as_str().unwrap().starts_with("4:"),
            "{sensor}"
        );
    }
    // Turned, nothing is left between them but small components at sensor 4 that cost less than a
    // finding.
    let (whole, _) = run(&["--align", "--turn-reversed"]);
    let (as_is, better) = (macs(&table), macs(&whole));
    assert_eq!(better.len(), 3);
    assert!(better.iter().all(|mac| *mac > 0.97), "{better:?}");
    assert!(
        as_is.iter().sum::<f64>() < better.iter().sum::<f64>() - 0.05,
        "{as_is:?}"
    );
    // With known partners the same frame.
    let list: String = (1..=11)
        .map(|n| format!("{n}:+Z,{}:+Z\n", n + 100))
        .collect();
    write(folder.path(), &[("points.csv", &list)]);
    let (known, _) = run(&["--align", &text(&folder.path().join("points.csv"))]);
    assert_eq!(known["alignment"]["known"], true);
    assert!((number(&known["alignment"]["scale"]) - 1e-3).abs() < 1e-9);
    // Wrong partners leave points farther off than the tolerance.
    let list = "1:+Z,101:+Z\n2:+Z,107:+Z\n7:+Z,102:+Z\n11:+Z,111:+Z\n";
    write(folder.path(), &[("wrong.csv", list)]);
    let wrong = text(&folder.path().join("wrong.csv"));
    let more = ["--nearest-node", "0.002", "--align", &wrong];
    let error = fail(files.into_iter().chain(more));
    assert!(error.contains("rotation, translation and scale"), "{error}");
}

#[test]
fn match_of_no_sensor_is_an_error_that_names_distances_or_names() {
    let folder = tempfile::tempdir().unwrap();
    let [test, theory] = bracket(folder.path());
    let files = ["correlate", "--test", &test, "--theory", &theory];
    // The test is in millimetres, as its file does not say.
    let error = fail(files.into_iter().chain(["--nearest-node", "0.002"]));
    for part in ["of 33 test sensors", "2.000e-3 m", "millimetres", "--align"] {
        assert!(error.contains(part), "{part}: {error}");
    }
    write(folder.path(), &[("map.csv", "1:+Z,901:+Z\n2:+Z,902:+Z\n")]);
    let map = text(&folder.path().join("map.csv"));
    let error = fail(files.into_iter().chain(["--dof-map", &map]));
    assert!(error.contains("901, 902"), "{error}");
}

#[test]
fn caption_digits_and_language_are_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let model = frame(1.0, &[1.0e4; 3], (0.1, 10.0));
    let root = |n: f64| 2.0 * (n * std::f64::consts::PI / 14.0).sin() * 100.0;
    let hz = |n: f64| root(n) / std::f64::consts::TAU;
    // The first mode of three masses on three springs, 0.1 Hz too high, known to 0.05 Hz.
    let shape: Vec<f64> = (1..=3)
        .map(|i| (f64::from(i) * std::f64::consts::PI / 7.0).sin())
        .collect();
    let modes = modes_json(&[(hz(1.0) + 0.1, Some(0.05), shape)]);
    write(
        folder.path(),
        &[("model.toml", &model), ("modes.json", &modes)],
    );
    let at = |name: &str| text(&folder.path().join(name));
    let (test, theory) = (at("modes.json"), at("model.toml"));
    let files = ["correlate", "--test", &test, "--theory", &theory, "--full"];
    let run = |more: &[&str]| succeed(files.into_iter().chain(more.iter().copied()));
    let printed = run(&[
        "--caption",
        "Frame, table 3",
        "--digits",
        "1",
        "--lang",
        "zh",
    ]);
    assert!(printed.starts_with("Frame, table 3\n"), "{printed}");
    for heading in ["阶次", "(试验−理论)/标准差", "汇总", "已配对"] {
        assert!(printed.contains(heading), "{heading}: {printed}");
    }
    assert!(
        printed.contains(" +2.0 ") && printed.contains(" 1.0 "),
        "{printed}"
    );
    // A CSV is for programs: its heads are those of every day, and its numbers whole.
    let csv = at("table.csv");
    run(&["--digits", "1", "--lang", "zh", "-o", &csv]);
    let lines = std::fs::read_to_string(&csv).unwrap();
    assert!(
        lines.contains("normalised deviation") && lines.contains("paired"),
        "{lines}"
    );
    let printed = run(&["--caption", "Summary", "--lang", "zh"]);
    assert!(printed.starts_with("Summary\n"), "{printed}");
    let english = run(&[]);
    assert!(
        english.starts_with("Theory and test compared\n"),
        "{english}"
    );
    assert!(english.contains("normalised deviation"), "{english}");
    let table: Value = serde_json::from_str(&run(&["--json"])).unwrap();
    let cell = &table["rows"][0]["tests"][0];
    assert!(
        (number(&cell["normalised_error"]) - 2.0).abs() < 1e-6,
        "{cell}"
    );
    let error = fail(files.into_iter().chain(["--lang", "de"]));
    assert!(error.contains("en or zh"), "{error}");
}

#[test]
fn shapes_of_two_storeys_expand_to_all_three() {
    let folder = tempfile::tempdir().unwrap();
    let (model, modes) = three_storeys(folder.path());
    let whole = json(Path::new(&modes));
    let mut part = whole.clone();
    let two = part["modes"].as_array_mut().unwrap();
    two.truncate(2);
    for mode in two {
        mode["shape"].as_object_mut().unwrap().remove("2:+X");
    }
    let part = serde_json::to_string(&part).unwrap();
    write(folder.path(), &[("part.json", &part)]);
    let (part, out) = (
        text(&folder.path().join("part.json")),
        folder.path().join("all.json"),
    );
    let files = ["correlate", "--test", &part, "--theory", &model, "--expand"];
    succeed(files.into_iter().chain([text(&out).as_str()]));
    let all = json(&out);
    assert_eq!(all["modes"].as_array().unwrap().len(), 2);
    for (n, mode) in all["modes"].as_array().unwrap().iter().enumerate() {
        for i in 1..=3 {
            // Two modes at two storeys come back through SEREP at the third.
            let got = number(&mode["shape"][format!("b{i}:+X")][0]);
            let expected = number(&whole["modes"][n]["shape"][format!("{i}:+X")][0]);
            assert!(
                (got - expected).abs() < 1e-9,
                "mode {n}, storey {i}: {got} {expected}"
            );
        }
    }
}
