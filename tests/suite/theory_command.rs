//! `modalign theory` computes modes of built-in models and of matrices, and reads finished modes.

use std::ffi::OsStr;

use serde_json::Value;

use crate::command::{fail, modalign, succeed, write};

fn parsed(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn a_scene_file_of_any_name_is_a_scene_for_every_verb() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "title = \"other\"\nschema = \"modalign-scene/1\"\n[model]\n\
                 name = \"torsional-planetary\"\n";
    let broken = "schema = \"modalign-scene/1\"\ntitle = \"t\"\n[modle]\n";
    let files = [
        ("table-2.toml", scene),
        ("broken.toml", broken),
        ("modes.csv", "frequency_hz\n1671.4\n"),
    ];
    write(folder.path(), &files);
    let path = |name: &str| folder.path().join(name).display().to_string();
    let of_scene = succeed(["theory", &path("table-2.toml"), "--json"]);
    assert_eq!(
        of_scene,
        succeed(["theory", "torsional-planetary", "--json"])
    );
    let (test, theory) = (path("modes.csv"), path("table-2.toml"));
    succeed(["correlate", "--test", &test, "--theory", &theory]);
    // A fault of a scene is one of a scene, not of a model.
    let error = fail(["theory", &path("broken.toml")]);
    assert!(
        error.contains("`modle`") && error.contains("`model`"),
        "{error}"
    );
}

#[test]
fn the_number_of_balls_is_swept_in_whole_numbers_and_has_no_sensitivity() {
    let text = succeed([
        "theory",
        "cycloid-ball",
        "--sweep",
        "ball_count=8:14:4",
        "--full",
    ]);
    for part in [
        "root 1, 9 11 13 15 modes (Hz)",
        "root 6, 4 modes (Hz)",
        "root 12, 6 8 10 12 modes (Hz)",
        // 13920.975 rad/s of the reference at 8 balls, 13765.426 at 10.
        "2215.59",
        "2190.83",
        "is an integer that changes the coordinates",
    ] {
        assert!(text.contains(part), "{part}:\n{text}");
    }
    assert!(!text.contains("Crossings and veerings"), "{text}");
    let sweep = "ball_count=8:14:4";
    let json = parsed(&succeed([
        "theory",
        "cycloid-ball",
        "--sweep",
        sweep,
        "--json",
    ]));
    let sweep = &json["sweeps"][0];
    assert_eq!(sweep["followed"], false);
    assert_eq!(sweep["loci"][0]["multiplicities"][3], 15);
    assert_eq!(sweep["loci"][1]["multiplicities"], Value::Null);
    for (sweep, expected) in [
        (
            "ball_count=8:14:5",
            "expected whole numbers in equal steps, such as 8:14:7",
        ),
        ("ball_count=8:50:2", "expected a finite value from 4 to 40"),
    ] {
        let error = fail(["theory", "cycloid-ball", "--sweep", sweep]);
        assert!(error.contains(expected), "{error}");
    }
    let error = fail(["theory", "cycloid-ball", "--set", "ball_count=9.5"]);
    assert!(
        error.contains("got 9.5, expected a whole number"),
        "{error}"
    );
    let text = succeed(["theory", "cycloid-ball", "--sensitivities", "--full"]);
    let rows: Vec<&str> = text
        .lines()
        .filter(|line| line.trim_start().starts_with("ball_count "))
        .collect();
    assert_eq!(rows.len(), 2, "{rows:?}");
    assert!(!rows[1].contains('0'), "{rows:?}");
    assert!(
        text.contains("an integer, which has no derivative"),
        "{text}"
    );
}

#[test]
fn the_number_of_balls_cannot_be_updated() {
    let folder = tempfile::tempdir().unwrap();
    let modes = folder.path().join("modes.json");
    succeed([
        "theory".as_ref(),
        "cycloid-ball".as_ref(),
        "-o".as_ref(),
        modes.as_os_str(),
    ]);
    let scene = r#"
        schema = "modalign-scene/1"
        title = "balls"
        [model]
        name = "cycloid-ball"
        [[test]]
        name = "itself"
        modes = "modes.json"
        [update]
        parameters = ["k_5y", "ball_count"]
    "#;
    write(folder.path(), &[("scene.toml", scene)]);
    let error = fail(["update".as_ref(), folder.path().as_os_str()]);
    let expected = "\"ball_count\": a number of parts, which is not updated";
    assert!(error.contains(expected), "{error}");
}

#[test]
fn finished_modes_are_printed_and_what_needs_a_model_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["modes.json", "modes.unv", "modes.csv"] {
        let path = folder.path().join(name);
        let made: [&OsStr; 4] = [
            "theory".as_ref(),
            "cycloid-ball".as_ref(),
            "-o".as_ref(),
            path.as_os_str(),
        ];
        succeed(made);
        let text = succeed(["theory".as_ref(), path.as_os_str(), "--full".as_ref()]);
        for part in ["1436.884387", "22666.034"] {
            assert!(text.contains(part), "{name} {part}:\n{text}");
        }
        let band: [&OsStr; 5] = [
            "theory".as_ref(),
            path.as_os_str(),
            "--band".as_ref(),
            "1000:2000".as_ref(),
            "--json".as_ref(),
        ];
        let inside = parsed(&succeed(band));
        assert_eq!(inside["modes"].as_array().unwrap().len(), 1, "{inside}");
        let flags: [&[&str]; 7] = [
            &["--set", "k_1x=1"],
            &["--energies"],
            &["--sensitivities"],
            &["--quantities"],
            &["--sweep", "k_1x=1:2:3"],
            &["--response"],
            &["--compare"],
        ];
        for flag in flags {
            let first = ["theory".as_ref(), path.as_os_str()];
            let error = fail(first.into_iter().chain(flag.iter().map(OsStr::new)));
            assert!(
                error.contains(flag[0]) && error.contains("finished modes"),
                "{error}"
            );
        }
        let same: [&OsStr; 8] = [
            "correlate".as_ref(),
            "--test".as_ref(),
            path.as_os_str(),
            "--theory".as_ref(),
            "cycloid-ball".as_ref(),
            "--rotation-length".as_ref(),
            "0.01".as_ref(),
            "--json".as_ref(),
        ];
        let table = parsed(&succeed(same));
        let paired = |row: &&Value| row["tests"][0]["status"] == "paired";
        let rows = table["rows"].as_array().unwrap();
        assert!(rows.iter().filter(paired).count() >= 14, "{name}");
    }
}

#[test]
fn json_has_the_requested_results_and_the_modes() {
    let asked = ["--energies", "--sensitivities", "--quantities", "--json"];
    let found = parsed(&succeed(
        ["theory", "torsional-planetary"].into_iter().chain(asked),
    ));
    assert_eq!(found["schema"], "modalign-modes/1");
    assert_eq!(found["modes"].as_array().unwrap().len(), 7);
    let theory_of_modes = &found["theory"];
    let k_r = theory_of_modes["parameters"]
        .as_array()
        .unwrap()
        .iter()
        .find(|parameter| parameter["name"] == "k_r");
    assert_eq!(k_r.unwrap()["value"], 5e8);
    let root = &theory_of_modes["energies"][2];
    assert_eq!(root["multiplicity"], 3);
    for kind in ["kinetic", "strain"] {
        let shares = root[kind].as_object().unwrap().values();
        let sum: f64 = shares.map(|share| share.as_f64().unwrap()).sum();
        assert!((sum - 1.0).abs() < 1e-12, "{kind} {sum}");
    }
    // The reference's derivative of the first elastic root by k_r, 2.6230511e-3 to its last digit.
    let slope = &theory_of_modes["sensitivities"][1]["by"]["k_r"]["branches_rad2_s2"][0];
    assert!(
        (slope.as_f64().unwrap() / 2.6230511e-3 - 1.0).abs() < 6e-8,
        "{slope}"
    );
    let planet = theory_of_modes["quantities"]
        .as_array()
        .unwrap()
        .iter()
        .find(|quantity| quantity["name"] == "planet_mode");
    assert!((planet.unwrap()["value"].as_f64().unwrap() / 2088.007554 - 1.0).abs() < 1e-9);
    let plain = parsed(&succeed(["theory", "torsional-planetary", "--json"]));
    assert_eq!(plain["theory"], Value::Null);
    let error = fail([
        "theory",
        "measurements/free-free-beam/model.toml",
        "--quantities",
    ]);
    assert!(error.contains("--quantities"), "{error}");
}

#[test]
fn a_number_that_needs_values_beyond_a_bound_is_left_out_and_said() {
    for (model, set, absent) in [
        ("spider-reducer", "k_i2=1.9e8", "k_i2_change_3"),
        ("torsional-planetary", "k_r=1e13", "mesh_energy_rate_error"),
    ] {
        let requested = ["--quantities", "--json", "--full"];
        let output = modalign(["theory", model, "--set", set].iter().chain(&requested));
        assert_eq!(output.status.code(), Some(0));
        let found = parsed(std::str::from_utf8(&output.stdout).unwrap());
        let all = found["theory"]["quantities"].as_array().unwrap();
        let quantity = all
            .iter()
            .find(|quantity| quantity["name"] == absent)
            .unwrap();
        assert_eq!(quantity["value"], Value::Null);
        assert!(all.iter().any(|quantity| quantity["value"].is_f64()));
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains(&format!("quantity {absent}: ")), "{said}");
        assert!(said.contains("[quantity-absent]"), "{said}");
    }
}

#[test]
fn sweeps_comparisons_and_energies_are_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("figure.svg");
    let file = path.to_str().unwrap();
    let draw = |options: &[&str]| {
        let arguments = ["theory", "cycloid-ball", "-o", file].into_iter();
        succeed(arguments.chain(options.iter().copied()));
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.ends_with("</svg>\n") && !text.contains("NaN"));
        text
    };
    // The mode jump of the paper is a crossing at 3.19e7 N/m; two loci veer.
    let swept = draw(&["--sweep", "k_03y=1e7:9e7:9", "--band", "0:12000"]);
    assert!(swept.contains("k_03y (10⁷ N/m)") && swept.contains("Natural frequency (Hz)"));
    assert_eq!(swept.matches("<circle").count(), 2 * 4);
    assert_eq!(
        swept.matches("fill=\"none\" stroke=\"#1b1b1b\"").count(),
        2 * 5
    );
    let compared = draw(&["--compare", "1", "--band", "0:12000"]);
    assert!(compared.contains("every body with its mass, 37 coordinates"));
    assert!(draw(&["--energies"]).contains("Fraction of the kinetic energy"));
    for options in [&[][..], &["--energies", "--compare"]] {
        let arguments = ["theory", "cycloid-ball", "-o", file].into_iter();
        let error = fail(arguments.chain(options.iter().copied()));
        assert!(
            error.contains("one of --sweep, --response, --compare and --energies"),
            "{error}"
        );
    }
}
