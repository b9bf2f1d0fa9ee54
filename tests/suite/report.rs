//! The HTML report is written with a run, built again from its folder, and its data select poles.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use serde_json::Value;

use crate::command::{fail, json, modalign, root, shared_folder, succeed, write};

/// The beam's scene run into a folder that stays unchanged, and its page.
fn beam() -> (&'static Path, &'static str) {
    static RUN: OnceLock<(PathBuf, String)> = OnceLock::new();
    let (folder, page) = RUN.get_or_init(|| {
        let out = shared_folder("report");
        let folder = out.to_str().unwrap();
        succeed(["run", "measurements/free-free-beam", "-q", "-o", folder]);
        let page = std::fs::read_to_string(out.join("report.html")).unwrap();
        (out, page)
    });
    (folder, page)
}

/// The data of a page.
fn data(page: &str) -> Value {
    let start = "<script type=\"application/json\" id=\"data\">";
    let (_, rest) = page.split_once(start).unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    let all = value.as_array().unwrap().iter();
    all.filter_map(Value::as_f64).collect()
}

#[test]
fn a_run_writes_a_page_with_everything_in_it() {
    let (out, page) = beam();
    assert!(page.len() < 3_000_000, "{} bytes", page.len());
    for part in [
        "6 of 6 modes of the model in the band have a partner",
        "All 6 stated limits are met.",
        "<figcaption>Summary</figcaption>",
        "id=\"tab-poles\"",
        "Seed of roving hammer",
    ] {
        assert!(page.contains(part), "{part}");
    }
    let at = |part: &str| page.find(part).unwrap();
    let order = [
        "verdict good",
        "rms frequency error",
        "Recommended changes",
        "data-draw=\"errors\"",
    ];
    assert!(
        order.is_sorted_by_key(|part| at(part)),
        "what matters first"
    );
    assert!(
        !page.contains("id=\"tab-energies\""),
        "all is in the one bar"
    );
    let hash = modalign::io::sha256_hex(
        &crate::command::root().join("measurements/free-free-beam/scene.toml"),
    );
    assert!(page.contains(&hash.unwrap()));
    let test = &data(page)["figures"]["tests"][0];
    let curves = test["frfs"]["curves"].as_array().unwrap();
    assert_eq!(curves.len(), 11);
    assert_eq!(test["circles"].as_array().unwrap().len(), 6);
    assert_eq!(test["mac"]["pairs"].as_array().unwrap().len(), 6);
    let figures: Vec<String> = std::fs::read_dir(out.join("figures"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    // Eleven functions, six circles, stabilisation, MAC, shapes, errors, energies.
    assert_eq!(figures.len(), 22, "{figures:?}");
}

#[test]
fn curves_of_the_page_show_the_fit_and_its_circles_the_damping() {
    let (_, page) = beam();
    let test = &data(page)["figures"]["tests"][0];
    for curve in test["frfs"]["curves"].as_array().unwrap() {
        let (measured, fit) = (
            &curve["magnitude"],
            curve["fit_magnitude"].as_array().unwrap(),
        );
        let measured = numbers(measured);
        let largest = measured.iter().copied().fold(0.0, f64::max);
        // What two residual terms leave of the mode right above the band, 2 % of the peak.
        for (value, fit) in measured.iter().zip(fit) {
            let Some(fit) = fit.as_f64() else { continue };
            assert!(
                (value - fit).abs() < 0.03 * largest,
                "{value} {fit} of {largest}"
            );
        }
        assert!(
            numbers(&curve["phase_deg"])
                .iter()
                .all(|phase| phase.abs() <= 180.0)
        );
        assert!(
            numbers(&curve["coherence"])
                .iter()
                .all(|value| (0.0..=1.0).contains(value))
        );
    }
    for (circle, mode) in test["circles"]
        .as_array()
        .unwrap()
        .iter()
        .zip(test["modes"].as_array().unwrap())
    {
        let surface: Vec<f64> = circle["damping"]
            .as_array()
            .unwrap()
            .iter()
            .flat_map(numbers)
            .collect();
        let mean = surface.iter().sum::<f64>() / surface.len() as f64;
        let known =
            mode["damping_ratio"].as_f64().unwrap() + circle["window_damping"].as_f64().unwrap();
        // The surface rests on one function, the mode's ratio on all.
        assert!((mean / known - 1.0).abs() < 0.03, "{mean} {known}");
        assert!(
            (circle["resonance_hz"].as_f64().unwrap() / mode["hz"].as_f64().unwrap() - 1.0).abs()
                < 1e-4
        );
    }
}

#[test]
#[cfg(not(feature = "png"))]
fn png_without_its_feature_is_an_error_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out");
    let written = output.to_str().unwrap();
    let scene = "measurements/free-free-beam";
    for arguments in [
        vec!["run", scene, "-o", written, "--png"],
        vec!["update", scene, "-o", written, "--png"],
        vec!["report", written, "--png"],
        vec!["study", "order", scene, "-o", written, "--png"],
        vec!["study", "breakdown", scene, "-o", written, "--png"],
    ] {
        let error = fail(arguments);
        assert!(
            error.contains("cargo install --path . --features png"),
            "{error}"
        );
        assert!(!output.exists());
    }
}

#[test]
fn a_report_is_built_again_as_it_was_and_in_the_other_language() {
    let (run, page) = beam();
    let out = tempfile::tempdir().unwrap();
    std::fs::copy(run.join("report.json"), out.path().join("report.json")).unwrap();
    let folder = out.path().to_str().unwrap();
    let path = out.path().join("report.html");
    let printed = succeed(["report", folder]);
    assert_eq!(printed.trim(), path.to_str().unwrap());
    assert_eq!(std::fs::read_to_string(&path).unwrap(), page);
    let figures = |extension: &str| {
        let all = std::fs::read_dir(out.path().join("figures")).unwrap();
        let paths = all.map(|entry| entry.unwrap().path());
        let with_extension =
            paths.filter(|path| path.extension().is_some_and(|found| found == extension));
        with_extension
            .map(|path| path.with_extension(""))
            .collect::<BTreeSet<_>>()
    };
    assert_eq!((figures("svg").len(), figures("png").len()), (22, 0));
    succeed(["report", folder, "--lang", "zh"]);
    let chinese = std::fs::read_to_string(&path).unwrap();
    for part in [
        "<html lang=\"zh\">",
        "频带内 6 / 6 阶模型模态已配对",
        "<th scope=\"col\">阶次</th>",
        "稳定图",
        modalign::finding::Code::Synthetic.chinese_sentence(),
        modalign::finding::Code::Synthetic.chinese_explanation(),
    ] {
        assert!(chinese.contains(part), "{part}");
    }
    let update = r#"{"parameters": [{"name": "youngs_modulus", "unit": "Pa", "initial": 2.1e11, "updated": 2.05e11, "std": 1e8, "verdict": "identified"}], "history": []}"#;
    write(out.path(), &[("update.json", update)]);
    succeed(["report", folder]);
    let updated = std::fs::read_to_string(&path).unwrap();
    assert!(
        updated.contains("id=\"tab-update\"")
            && updated.contains("youngs_modulus: 2.1000e11 → 2.0500e11 ± 1.0e8")
    );
}

/// Studies of a few draws.
const STUDY: &str = r#"
schema = "modalign-study/1"
[speed_accuracy]
estimators = []
record_shares = []
orders = []
snr_db = [40.0, 60.0]
draws = 1
repeats = 1
[breakdown]
draws = 2
refine = 0
methods = ["circle", "peak"]
stability = { highest_order = 4 }
[[breakdown.slice]]
x = { factor = "damping", lo = 0.001, hi = 0.1, count = 3, scale = "log" }
y = { factor = "noise", lo = 10.0, hi = 70.0, count = 2 }
"#;

#[test]
fn studies_in_the_folder_of_a_run_are_on_its_page() {
    let place = tempfile::tempdir().unwrap();
    let beam = root().join("measurements/free-free-beam");
    let text = |name: &str| std::fs::read_to_string(beam.join(name)).unwrap();
    let spec = text("synth.toml").replace("samples = 32768", "samples = 4096");
    // Four of the six modes, the fewest of which some can be outside the band of a twin.
    let scene = text("scene.toml").replace("band_hz = [60.0, 3200.0]", "band_hz = [60.0, 1600.0]");
    let files = [
        ("scene.toml", scene),
        ("model.toml", text("model.toml")),
        ("synth.toml", spec),
        ("study.toml", STUDY.to_owned()),
    ];
    let files = files.each_ref().map(|(name, text)| (*name, text.as_str()));
    write(place.path(), &files);
    let scene = place.path().to_str().unwrap();
    let folder = place.path().join("out");
    let out = folder.to_str().unwrap();
    let page = || {
        succeed(["report", out]);
        std::fs::read_to_string(folder.join("report.html")).unwrap()
    };
    modalign(["run", scene, "-o", out]);
    assert!(!page().contains("tab-methods"));
    succeed(["study", "speed-accuracy", scene, "-o", out]);
    succeed(["study", "breakdown", scene, "-o", out]);
    for name in ["speed-accuracy-times.csv", "breakdown-times.csv"] {
        assert!(
            folder.join(name).exists(),
            "no study writes over the other's {name}"
        );
    }
    let whole = page();
    let studies = &data(&whole)["studies"];
    let [rows, times] = ["rows", "times"].map(|key| studies["speed"][key].as_array().unwrap());
    // Seven methods on the data, and on the twin in three conditions at two levels.
    assert_eq!(rows.len(), 7 + 7 * 3 * 2);
    assert!(times.iter().any(|row| row["cpu_s"].as_f64().unwrap() > 0.0));
    let slice = &studies["breakdown"]["slices"][0];
    assert_eq!(slice["methods"], serde_json::json!(["circle", "peak"]));
    let inside = slice["points"].as_array().unwrap().len() as u64;
    assert_eq!(
        inside + slice["outside"].as_u64().unwrap(),
        4,
        "modes of the bar"
    );
    assert_eq!(studies["breakdown"]["courses"].as_array().unwrap().len(), 4);
    for part in [
        "id=\"tab-methods\"",
        "<figcaption>roving hammer: Pareto front of time and error</figcaption>",
        "<figcaption>Where methods fail: noise-damping</figcaption>",
        "In white noise from 40 to 60 dB",
    ] {
        assert!(whole.contains(part), "{part}");
    }
    // `run` into the same folder shows them as well, and an update beside them changes nothing in
    // them.
    modalign(["run", scene, "-o", out]);
    let again = std::fs::read_to_string(folder.join("report.html")).unwrap();
    assert_eq!(data(&again)["studies"], *studies);
    // The data have changed since: another seed.
    let path = place.path().join("synth.toml");
    let spec = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, format!("{}\n", spec.replace("seed = ", "seed = 1"))).unwrap();
    modalign(["run", scene, "-o", out]);
    let other = page();
    assert!(data(&other)["studies"].as_object().unwrap().is_empty());
    for name in ["speed-accuracy.json", "breakdown.json"] {
        assert!(other.contains(&format!("The study in {name}")), "{name}");
        let path = folder.join(name);
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.replacen("/1\"", "/9\"", 1)).unwrap();
        let message = fail(["report", out]);
        assert!(
            message.contains(name) && message.contains("/9"),
            "{message}"
        );
        std::fs::write(&path, text).unwrap();
    }
}

#[test]
fn a_folder_without_a_report_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let message = fail(["report", folder.path().to_str().unwrap()]);
    assert!(message.contains("report.json"), "{message}");
    write(
        folder.path(),
        &[("report.json", r#"{"schema": "modalign-modes/1"}"#)],
    );
    let message = fail(["report", folder.path().to_str().unwrap()]);
    assert!(message.contains("report.json:1"), "{message}");
}

#[test]
fn poles_of_the_page_are_a_selection_that_identify_takes() {
    let (run, page) = beam();
    let out = tempfile::tempdir().unwrap();
    let test = &data(page)["figures"]["tests"][0];
    let diagram = &test["stabilization"];
    let (order, hz, damping) = (
        numbers(&diagram["order"]),
        numbers(&diagram["hz"]),
        numbers(&diagram["damping"]),
    );
    let status = numbers(&diagram["status"]);
    let truth = json(&run.join("roving-hammer.truth.modes.json"));
    let wanted = truth["modes"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|mode| mode["frequency_hz"].as_f64());
    let wanted: Vec<f64> = wanted.filter(|hz| (60.0..3200.0).contains(hz)).collect();
    let mut poles = Vec::new();
    for wanted in &wanted {
        let chosen = (0..hz.len()).filter(|k| status[*k] > 1.5);
        let nearest = chosen
            .min_by(|a, b| (hz[*a] - wanted).abs().total_cmp(&(hz[*b] - wanted).abs()))
            .unwrap();
        poles.push(format!(
            r#"{{"frequency_hz": {}, "damping_ratio": {}, "order": {}}}"#,
            hz[nearest], damping[nearest], order[nearest]
        ));
    }
    let text = format!(
        r#"{{"schema": "modalign-selection/1", "poles": [{}]}}"#,
        poles.join(", ")
    );
    write(out.path(), &[("selection.json", &text)]);
    let path = |folder: &Path, name: &str| folder.join(name).to_str().unwrap().to_owned();
    let frfs = path(run, test["frf_file"].as_str().unwrap());
    let (selection, modes) = (
        path(out.path(), "selection.json"),
        path(out.path(), "modes.json"),
    );
    let method = diagram["method"].as_str().unwrap();
    succeed([
        "identify",
        &frfs,
        "--method",
        method,
        "--band",
        "60:3200",
        "--selection",
        &selection,
        "-o",
        &modes,
    ]);
    let found = json(Path::new(&modes));
    let found = found["modes"].as_array().unwrap();
    assert_eq!((found.len(), wanted.len()), (6, 6));
    for (mode, wanted) in found.iter().zip(wanted) {
        let off = mode["frequency_hz"].as_f64().unwrap() / wanted - 1.0;
        assert!(off.abs() < 1e-4, "{off} at {wanted} Hz");
    }
}

#[test]
fn correlate_writes_a_page_too() {
    let (run, _) = beam();
    let out = tempfile::tempdir().unwrap();
    let path = |folder: &Path, name: &str| folder.join(name).to_str().unwrap().to_owned();
    let (modes, table) = (
        path(run, "roving-hammer.modes.json"),
        path(out.path(), "table.html"),
    );
    succeed([
        "correlate",
        "--test",
        &modes,
        "--theory",
        "measurements/free-free-beam",
        "-o",
        &table,
    ]);
    let page = std::fs::read_to_string(&table).unwrap();
    assert!(
        page.starts_with("<!doctype html>")
            && page.contains("<span class=\"chip good\">paired</span>")
    );
}
