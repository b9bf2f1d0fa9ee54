//! `modalign theory --modify` and `--target` as a user runs them: a modified beam, its uncertainty
//! beside an update, designs of the transmissions, and every fault of the request at once.

use serde_json::Value;

use crate::command::{fail, modalign, succeed};

const BEAM: &str = "measurements/free-free-beam";

fn parsed(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

#[test]
fn an_added_mass_lowers_each_mode_that_moves_at_its_point() {
    let json = parsed(&succeed([
        "theory",
        BEAM,
        "--modify",
        "mass:1=0.0264",
        "--json",
    ]));
    assert_eq!(json["schema"], "modalign-modification/1");
    let modes = json["modified"]["modes"].as_array().unwrap();
    let elastic: Vec<&Value> = modes
        .iter()
        .filter(|mode| number(&mode["before_hz"]) > 0.0)
        .collect();
    assert!(elastic.len() > 20);
    assert!(
        elastic
            .iter()
            .all(|mode| number(&mode["change_percent"]) < 0.0)
    );
    // The mass parameter of the model at the same place.
    let set = parsed(&succeed([
        "theory",
        BEAM,
        "--set",
        "sensor_mass=0.0264",
        "--json",
    ]));
    let set: Vec<f64> = set["modes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|mode| number(&mode["frequency_hz"]))
        .filter(|hz| *hz > 0.0)
        .collect();
    for (mode, expected) in elastic.iter().zip(set) {
        assert!(
            (number(&mode["after_hz"]) / expected - 1.0).abs() < 1e-9,
            "{mode}"
        );
    }
    let text = succeed(["theory", BEAM, "--modify", "mass:1=0.0264"]);
    assert!(text.contains("No uncertainty is known"), "{text}");
}

#[test]
fn a_modified_updated_model_has_the_interval_of_its_update() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    succeed(["update", BEAM, "-o", out.to_str().unwrap()]);
    let model = out.join("model.toml");
    let model = model.to_str().unwrap();
    let change = ["--modify", "bar.w5=1"];
    assert!(fail(["theory", model, change[0], change[1]]).contains("bar.w5"));
    let text = succeed(["theory", model, "--modify", "mass:bar.w5=0.05"]);
    assert!(text.contains("95 % interval of f after (Hz)"), "{text}");
    let json = |arguments: &[&str]| {
        let all = ["theory", model]
            .into_iter()
            .chain(arguments.iter().copied());
        parsed(&succeed(all.chain(["--json"])))
    };
    let found = json(&["--modify", "mass:bar.w5=0.05"]);
    let mode = &found["modified"]["modes"][1];
    let interval = &mode["interval_95_hz"];
    let (low, high) = (number(&interval[0]), number(&interval[1]));
    let after = number(&mode["after_hz"]);
    assert!(low < after && after < high && high / low < 1.01, "{mode}");
    // With one parameter set and the other one at the end of its interval, the end of that of f.
    let update = parsed(&std::fs::read_to_string(out.join("update.json")).unwrap());
    let modulus = &update["parameters"][0];
    assert_eq!(modulus["name"], "youngs_modulus");
    let alone = json(&["--modify", "sensor_mass=0.012"]);
    let alone = &alone["modified"]["modes"][1];
    let end = format!("youngs_modulus={}", number(&modulus["interval_95"][1]));
    let moved = json(&["--modify", "sensor_mass=0.012", "--modify", &end]);
    let upper = number(&alone["interval_95_hz"][1]);
    let expected = number(&moved["modified"]["modes"][1]["after_hz"]);
    assert!((upper / expected - 1.0).abs() < 1e-4, "{upper} {expected}");
    // Of another model the uncertainty is not used.
    let text = succeed([
        "theory",
        model,
        "--set",
        "sensor_mass=0.05",
        "--modify",
        "mass:bar.w5=1",
    ]);
    assert!(text.contains("is of another model"), "{text}");
    let update = out.join("update.json");
    let error = fail([
        "theory",
        BEAM,
        "--modify",
        "mass:1=0.1",
        "--uncertainty",
        update.to_str().unwrap(),
    ]);
    assert!(
        error.contains("name the updated model.toml as MODEL"),
        "{error}"
    );
}

#[test]
fn an_added_damper_has_the_damping_ratio_of_its_modes() {
    let json = parsed(&succeed([
        "theory",
        "cycloid-ball",
        "--modify",
        "damper:output:+Y=50",
        "--json",
    ]));
    let modes = json["modified"]["modes"].as_array().unwrap();
    let ratios: Vec<f64> = modes
        .iter()
        .filter_map(|mode| mode["damping_after"].as_f64())
        .collect();
    assert!(ratios.iter().any(|ratio| *ratio > 1e-4), "{ratios:?}");
    let unmoved = modes.iter().all(|mode| {
        mode["change_percent"]
            .as_f64()
            .is_none_or(|c| c.abs() < 1e-6)
    });
    assert!(unmoved, "a damper does not change undamped frequencies");
}

#[test]
fn a_design_is_ranked_and_its_values_solved_again_meet_the_target() {
    let arguments = [
        "theory",
        "torsional-planetary",
        "--target",
        "f1 > 1800",
        "--target",
        "f2 < 2200",
    ];
    let json = parsed(&succeed(arguments.into_iter().chain(["--json"])));
    let design = &json["design"];
    assert_eq!(design["met"], true);
    let combined = &design["combined"];
    let single = design["single"].as_array().unwrap();
    assert!(
        single
            .iter()
            .all(|one| one["met"] == false || number(&one["cost"]) >= number(&combined["cost"]))
    );
    let set = combined["parameters"]
        .as_array()
        .unwrap()
        .iter()
        .map(|parameter| {
            format!(
                "{}={}",
                parameter["name"].as_str().unwrap(),
                number(&parameter["value"])
            )
        });
    let set: Vec<String> = set.flat_map(|set| ["--set".to_owned(), set]).collect();
    let all = ["theory", "torsional-planetary", "--json"].map(str::to_owned);
    let again = parsed(&succeed(all.into_iter().chain(set)));
    let again = again["modes"].as_array().unwrap();
    let found = |hz: f64| {
        again
            .iter()
            .any(|mode| (number(&mode["frequency_hz"]) / hz - 1.0).abs() < 1e-9)
    };
    for mode in combined["modes"].as_array().unwrap() {
        let hz = number(&mode["after_hz"]);
        assert!(hz == 0.0 || found(hz), "{mode}");
    }
    assert!(found(1800.0));
}

#[test]
fn a_target_out_of_reach_has_exit_code_1_and_says_how_near_it_comes() {
    let output = modalign([
        "theory",
        "torsional-planetary",
        "--target",
        "f1 > 1800",
        "--free",
        "k_s",
    ]);
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8(output.stdout).unwrap();
    for part in [
        "cannot be met within the bounds",
        "not met",
        "k_s = 1e9 (+100.00 %)",
    ] {
        assert!(text.contains(part), "{part}:\n{text}");
    }
    let wider = [
        "theory",
        "torsional-planetary",
        "--target",
        "f1 > 1800",
        "--free",
        "k_s",
        "--within",
        "m_c=5:9",
    ];
    assert!(succeed(wider).contains("m_c = "));
}

#[test]
fn all_faults_of_changes_and_of_targets_are_listed_at_once() {
    let error = fail([
        "theory",
        "torsional-planetary",
        "--modify",
        "mas:ring:+S=1",
        "--modify",
        "mass:rim=1",
        "--modify",
        "spring:sun:+S,sun:+S=1e6",
        "--modify",
        "damper:ring:+S=-1",
        "--modify",
        "k_z*=2",
        "--modify",
        "m_c=-1",
    ]);
    for part in [
        "got `mas:ring:+S=1`, expected mass:POINT=KG",
        "got `rim`, expected a point or degree of freedom of the model: carrier:+S",
        "expected two that move differently",
        "damper:ring:+S=-1: got -1",
        "got parameter `k_z`",
        "parameter `m_c`: got -1",
    ] {
        assert!(error.contains(part), "{part}:\n{error}");
    }
    let error = fail([
        "theory",
        "torsional-planetary",
        "--target",
        "f9 > 100",
        "--target",
        "f1 is 100",
        "--target",
        "f1 > -3",
        "--target",
        "f1 outside 20:10",
        "--free",
        "k_q",
        "--within",
        "q=1:2",
    ]);
    for part in [
        "got `f9`, expected a mode of the model: f1 to f4",
        "got `f1 is 100`, expected \"f3 > 2600\"",
        "expected a frequency above 0 Hz",
        "got 20:10",
        "--free: k_q: got `k_q`, expected a parameter of the model: m_c",
        "--within: q",
    ] {
        assert!(error.contains(part), "{part}:\n{error}");
    }
    let error = fail(["theory", "cycloid-ball", "--modify", "ball_count=9"]);
    assert!(error.contains("a number of parts"), "{error}");
}
