//! `modalign study speed-accuracy` gives the same numbers for any number of threads, the refined
//! method at its bound, and the known failures; `modalign study order` gives the known needs of the
//! beam.

use std::path::{Path, PathBuf};

use crate::command::{assert_has_sentences, fail, root, succeed, write};

/// A short recording of the beam, studied at three levels of noise.
const SPEC: &str = "schema = \"modalign-study/1\"\n[speed_accuracy]\nestimators = [\"h2\"]\nrecord_shares = [0.5]\n\
                    orders = []\nsnr_db = [30.0, 55.0, 80.0]\ndraws = 2\nrepeats = 1\n";
/// Two levels, for what the number of threads must not change.
const SHORT_SPEC: &str = "schema = \"modalign-study/1\"\n[speed_accuracy]\nestimators = [\"h2\"]\n\
                          record_shares = [0.5]\norders = []\nsnr_db = [30.0, 80.0]\ndraws = 2\nrepeats = 1\n";
/// Modes of the beam in the band.
const MODES: usize = 6;
/// Largest required rms error of the refined method over the bound, and the largest distance of an
/// rms of a few errors above it, in standard deviations.
const MAX_ERROR_OVER_BOUND: f64 = 1.2;
const SIGMAS: f64 = 4.0;

fn scene(folder: &Path) {
    scene_in_band(folder, "3200.0", SPEC);
}

/// The scene with another end of the band, Hz.
fn scene_in_band(folder: &Path, end_hz: &str, study: &str) {
    let source = root().join("measurements/free-free-beam");
    let text = |name: &str| std::fs::read_to_string(source.join(name)).unwrap();
    let spec = text("synth.toml").replace("samples = 32768", "samples = 4096");
    let files = [
        (
            "scene.toml",
            text("scene.toml")
                .replace("[60.0, 3200.0]", &format!("[60.0, {end_hz}]"))
                .replace("min_paired = 6", "min_paired = 3"),
        ),
        (
            "model.toml",
            text("model.toml").replace("elements = 60", "elements = 30"),
        ),
        ("synth.toml", spec),
        ("study.toml", study.to_owned()),
    ];
    write(
        folder,
        &files.each_ref().map(|(name, text)| (*name, text.as_str())),
    );
}

/// Rows of a CSV file by the heads of its columns.
struct Rows(Vec<std::collections::BTreeMap<String, String>>);

impl Rows {
    fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap();
        let mut lines = text
            .lines()
            .map(|line| line.replace("\"twin, ", "\"twin; ").replace('"', ""));
        let heads: Vec<String> = lines
            .next()
            .unwrap()
            .split(',')
            .map(str::to_owned)
            .collect();
        let row = |line: String| {
            let cells = line.split(',').map(str::to_owned);
            heads.iter().cloned().zip(cells).collect()
        };
        Self(lines.map(row).collect())
    }

    /// A column of the rows of one method on one kind of data, at one level or all.
    fn values(&self, (data, method): (&str, &str), snr_db: Option<&str>, column: &str) -> Vec<f64> {
        let rows = self.0.iter().filter(|row| {
            let level = snr_db.is_none_or(|level| row["snr_db"] == level);
            row["data"] == data && row["method"] == method && level
        });
        rows.filter_map(|row| row[column].parse().ok()).collect()
    }
}

/// Runs the study of speed and accuracy of a scene; its output folder and its screen.
fn study(place: &Path, threads: &str, more: &[&str]) -> (PathBuf, String) {
    let out = place.join(threads);
    let [place, name] = [place, &out].map(|path| path.to_str().unwrap());
    let arguments = [
        "study",
        "speed-accuracy",
        place,
        "-o",
        name,
        "--threads",
        threads,
    ];
    let screen = succeed(arguments.iter().chain(more));
    (out, screen)
}

#[test]
fn a_study_is_the_same_for_any_threads() {
    let folder = tempfile::tempdir().unwrap();
    scene_in_band(folder.path(), "1100.0", SHORT_SPEC);
    let ((one, screen), (two, full)) = (
        study(folder.path(), "1", &[]),
        study(folder.path(), "2", &["--full"]),
    );
    crate::screen::assert_fits(&screen, 40, 100, "study speed-accuracy");
    assert!(
        full.contains("Pareto front") && full.contains("Cramér-Rao bound"),
        "{full}"
    );
    let bytes = |folder: &Path| std::fs::read(folder.join("speed-accuracy.csv")).unwrap();
    assert_eq!(bytes(&one), bytes(&two));
    check_verdict(&screen, &full, &two, 3);
}

#[test]
fn a_study_shows_bound_and_failures() {
    let folder = tempfile::tempdir().unwrap();
    scene(folder.path());
    let (two, full) = study(folder.path(), "2", &["--full"]);
    check_verdict(&full, &full, &two, MODES);
    let stem = "speed-accuracy-roving-hammer";
    for name in [
        format!("{stem}-data.svg"),
        format!("{stem}-twin.svg"),
        format!("{stem}-bound.svg"),
    ] {
        let text = std::fs::read_to_string(two.join(&name)).unwrap();
        assert!(
            text.ends_with("</svg>\n") && !text.contains("NaN"),
            "{name}"
        );
    }
    let times = Rows::read(&two.join("speed-accuracy-times.csv"));
    assert!(
        times
            .values(("data", "ml"), None, "peak_bytes")
            .iter()
            .all(|bytes| *bytes > 1e5)
    );

    let rows = Rows::read(&two.join("speed-accuracy.csv"));
    let over = |data: &str, method: &str, level| {
        let ratios = rows.values((data, method), level, "frequency_over_bound");
        assert!(!ratios.is_empty(), "{data}, {method}");
        (ratios.iter().map(|ratio| ratio * ratio).sum::<f64>() / ratios.len() as f64).sqrt()
    };
    let errors = (3 * 2 * MODES) as f64;
    let most = MAX_ERROR_OVER_BOUND + SIGMAS / (2.0 * errors).sqrt();
    let refined = over("twin; white noise", "ml", None);
    assert!(refined < most, "{refined}");
    // A record of two time constants causes a truncation bias, which exceeds the noise at 80 dB.
    for method in ["circle", "line", "peak", "ml"] {
        let ended = over("twin; record ends early", method, Some("80"));
        assert!(ended > 10.0, "{method}: {ended}");
    }
    // The exponentials of a band's transform are those of its modes and of its edges.
    let exponentials = over("twin; white noise", "lsce", Some("80"));
    assert!(exponentials > 10.0, "{exponentials}");
    // On the data themselves every method finds the modes of the refined solution.
    let found = rows.values(("data", "circle"), None, "found");
    assert_eq!(found, [MODES as f64; 3]);
}

/// The verdict names the fastest of the methods whose errors are within the stated ones, and the
/// full output has the verdicts and recommendations of the JSON.
fn check_verdict(screen: &str, full: &str, folder: &Path, modes: usize) {
    let study = crate::command::json(&folder.join("speed-accuracy.json"));
    assert_has_sentences(full, &study, &["verdict", "lessons"]);
    let verdict = screen.split_whitespace().collect::<Vec<_>>().join(" ");
    let method = verdict.split("roving hammer: use ").nth(1).unwrap();
    let method = method.split([':', ' ']).next().unwrap();
    let rows = study["rows"].as_array().unwrap();
    let row = rows
        .iter()
        .find(|row| row["data"] == "data" && row["method"] == method);
    let row = row.unwrap();
    assert_eq!(
        (row["found"].as_f64(), row["spurious"].as_f64()),
        (Some(modes as f64), Some(0.0))
    );
    assert!(
        row["frequency_rms"]
            .as_f64()
            .is_none_or(|error| error < 1e-3),
        "{row}"
    );
}

#[test]
fn an_invalid_study_is_refused_with_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    scene(folder.path());
    let spec = folder.path().join("other.toml");
    let command = ["study", "speed-accuracy", spec.to_str().unwrap()];
    let with = |text: &str| {
        std::fs::write(&spec, SPEC.replace("draws = 2", text)).unwrap();
        fail(command)
    };
    assert!(with("drawn = 4").contains("did you mean `draws`?"));
    assert!(with("draws = 0").contains("[speed_accuracy] draws: got 0, expected 1 to 100000"));
    let unknown = with("tests = [\"other\"]");
    assert!(
        unknown.contains("got \"other\"") && unknown.contains("roving hammer"),
        "{unknown}"
    );
}

#[test]
fn needs_of_the_beam_do_not_depend_on_threads_and_are_on_its_page() {
    let folder = tempfile::tempdir().unwrap();
    scene_in_band(folder.path(), "2050.0", SPEC);
    let place = folder.path().to_str().unwrap();
    let out = |threads: &str, full: &[&str]| {
        let out = folder.path().join(threads);
        let name = out.to_str().unwrap();
        let arguments = ["study", "order", place, "-o", name, "--threads", threads];
        let text = succeed(arguments.iter().chain(full));
        let files = [
            "order.csv",
            "order.json",
            "order.md",
            "order-roving-hammer.svg",
        ];
        (
            text,
            files.map(|name| std::fs::read_to_string(out.join(name)).unwrap()),
        )
    };
    let ((screen, one), (text, two)) = (out("1", &[]), out("2", &["--full"]));
    assert_eq!(one, two);
    crate::screen::assert_fits(&screen, 40, 100, "study order");
    assert!(
        screen.contains("use peak, which is enough for all 5 observable modes."),
        "{screen}"
    );
    let [csv, json, page, figure] = one;
    assert!(text.contains("the data support 5 roots by BIC"), "{text}");
    assert!(page.contains("one mode at a time is enough for 5 of 5 observable modes"));
    assert!(csv.lines().count() > 6 && figure.contains("BIC above its minimum"));
    let study: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(study["schema"], "modalign-order/1");
    assert_has_sentences(&text, &study, &["verdict", "answers"]);
    let test = &study["tests"][0];
    assert_eq!(test["roots_by_bic"], 5);
    assert_eq!(study["parameters"]["needed"].as_array().unwrap().len(), 2);
    for method in test["orders"].as_array().unwrap() {
        let lowest = method["lowest"].as_u64().unwrap();
        assert!(
            lowest <= method["own"]["order"].as_u64().unwrap(),
            "{method}"
        );
    }
    // The page of a run shows it.
    let run = folder.path().join("run");
    let run = run.to_str().unwrap();
    succeed(["run", place, "-o", run]);
    std::fs::copy(
        folder.path().join("1/order.json"),
        folder.path().join("run/order.json"),
    )
    .unwrap();
    succeed(["report", run]);
    let page = std::fs::read_to_string(folder.path().join("run/report.html")).unwrap();
    assert!(page.contains("Required and unnecessary elements of this scene"));
    assert!(page.contains("the data support 5 roots by BIC"));
}

#[test]
fn a_spec_that_cannot_be_meant_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    scene(folder.path());
    let wrong = "schema = \"modalign-study/1\"\n[order]\ntheory_percent = -1.0\n";
    write(folder.path(), &[("study.toml", wrong)]);
    let text = fail(["study", "order", folder.path().to_str().unwrap()]);
    assert!(
        text.contains("[order] theory_percent: got -1, expected a number above 0"),
        "{text}"
    );
}
