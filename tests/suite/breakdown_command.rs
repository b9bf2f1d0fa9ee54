//! `modalign study breakdown`: the same bytes for any number of threads, for a run that goes on,
//! and for parts that are joined.

use std::path::Path;

use crate::command::{assert_has_sentences, fail, modalign_in, root, succeed, write};

const SPEC: &str = r#"
schema = "modalign-study/1"
[breakdown]
seed = 5
draws = 4
refine = 1
methods = ["peak", "line"]
modes = "modes.json"
stability = { highest_order = 6 }
case = { lines = 120 }
[[breakdown.slice]]
x = { factor = "separation", lo = 0.5, hi = 8.0, count = 3, scale = "log" }
y = { factor = "damping", lo = 0.005, hi = 0.05, count = 2, scale = "log" }
[[breakdown.slice]]
x = { factor = "hits", lo = 1, hi = 3 }
y = { factor = "force_noise", lo = 20.0, hi = 60.0, count = 2 }
"#;

const MODES: &str = r#"{"schema": "modalign-modes/1", "producer": "a test", "inputs": [], "references": ["1:+Z"], "modes": [
{"frequency_hz": 100.0, "damping_ratio": 0.01, "shape": {"1:+Z": [1.0, 0.0]}},
{"frequency_hz": 110.0, "damping_ratio": 0.01, "shape": {"1:+Z": [1.0, 0.0]}}], "findings": []}"#;

fn study(folder: &Path, out: &str, more: &[&str]) -> String {
    let path = |name: &str| folder.join(name).display().to_string();
    let mut words = vec![
        "study".to_owned(),
        "breakdown".to_owned(),
        path("study.toml"),
        "--full".to_owned(),
    ];
    words.extend(["-o".to_owned(), path(out)]);
    words.extend(more.iter().map(|word| (*word).to_owned()));
    succeed(words)
}

/// The files of a result that no clock decides.
fn bytes(folder: &Path, out: &str) -> Vec<Vec<u8>> {
    let names = [
        "breakdown.csv",
        "stability.csv",
        "damping-separation.svg",
        "force_noise-hits.svg",
        "stability.svg",
    ];
    let read = |name: &str| std::fs::read(folder.join(out).join(name)).unwrap();
    names.map(read).into()
}

#[test]
fn any_threads_a_resumed_run_and_merged_parts_give_the_same_bytes() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    write(folder, &[("study.toml", SPEC), ("modes.json", MODES)]);
    let printed = study(folder, "one", &["--threads", "1"]);
    for slice in ["damping-separation", "force_noise-hits"] {
        assert!(
            printed.contains(&format!("Where methods fail: {slice}")),
            "{printed}"
        );
    }
    let path = |name: &str| folder.join(name).display().to_string();
    let screen = succeed([
        "study",
        "breakdown",
        &path("study.toml"),
        "-o",
        &path("one"),
    ]);
    crate::screen::assert_fits(&screen, 40, 100, "study breakdown");
    let (spec, out) = (path("study.toml"), path("one"));
    let chinese = ["study", "breakdown", &spec, "-o", &out];
    let chinese = succeed(chinese.into_iter().chain(["--lang", "zh"]));
    assert_eq!(
        crate::screen::english_words(&chinese, &[out]),
        None,
        "{chinese}"
    );
    let verdict = screen.lines().nth(3).unwrap();
    assert!(
        verdict.starts_with("Use ") || verdict.starts_with("No method meets"),
        "{screen}"
    );
    let json = crate::command::json(&folder.join("one/breakdown.json"));
    assert_has_sentences(&printed, &json, &["verdict"]);
    #[cfg(target_os = "linux")]
    {
        let [spec, out] = ["study.toml", "one"].map(path);
        let line =
            format!("stty cols 80 rows 40; modalign study breakdown {spec} -o {out} 2>/dev/null");
        let screen = crate::manners::on_a_terminal(&line, &[("NO_COLOR", "1")]);
        crate::screen::assert_fits(&screen.replace('\r', ""), 40, 80, "study breakdown");
    }
    assert!(
        printed.contains("Where methods fail: damping-separation"),
        "{printed}"
    );
    assert!(printed.contains("mode 1 (100.0 Hz)"), "{printed}");
    let expected = bytes(folder, "one");
    study(folder, "two", &["--threads", "2"]);
    assert_eq!(bytes(folder, "two"), expected);
    // The first part alone, as if the run had ended there; then all of it in the same folder.
    let first = study(folder, "on", &["--cells", "1/2"]);
    assert!(first.contains("part 1 of 2: damping-separation"), "{first}");
    assert!(!folder.join("on/breakdown.csv").exists());
    let rest = study(folder, "on", &[]);
    assert!(
        rest.contains("damping-separation: found finished"),
        "{rest}"
    );
    assert_eq!(bytes(folder, "on"), expected);
    study(folder, "a", &["--cells", "1/2"]);
    study(folder, "b", &["--cells", "2/2"]);
    let parts = ["a", "b"].map(|name| folder.join(name).display().to_string());
    study(folder, "joined", &["--merge", &parts[0], &parts[1]]);
    assert_eq!(bytes(folder, "joined"), expected);
    // Another spec: joining refuses the parts, computing begins anew and says so.
    write(
        folder,
        &[("study.toml", &SPEC.replace("seed = 5", "seed = 6"))],
    );
    let words = [
        "study",
        "breakdown",
        &path("study.toml"),
        "-o",
        &path("refused"),
        "--merge",
        &parts[0],
        &parts[1],
    ];
    let error = fail(words);
    assert!(error.contains("cells of another spec"), "{error}");
    let again = study(folder, "on", &[]);
    assert!(again.contains("computed again"), "{again}");
    assert_ne!(bytes(folder, "on")[0], expected[0]);
}

#[test]
fn specs_of_the_scenes_can_be_meant() {
    for scene in ["free-free-beam", "cycloid-ball"] {
        let path = root().join("measurements").join(scene).join("study.toml");
        let text = std::fs::read_to_string(&path).unwrap();
        let file = modalign::study::parse_study(&text, "study.toml").unwrap();
        let plan = file.breakdown.plan().unwrap();
        assert!(plan.slices.len() >= 3, "{scene}");
    }
}

#[test]
fn invalid_values_of_a_spec_are_reported() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("study.toml").display().to_string();
    for (text, part) in [
        (
            SPEC.replace("\"peak\"", "\"peek\""),
            "breakdown.methods: got peek",
        ),
        (
            SPEC.replace("count = 3", "cuont = 3"),
            "did you mean `count`?",
        ),
        (SPEC.replace("study/1", "study/9"), "schema"),
    ] {
        write(place.path(), &[("study.toml", &text)]);
        let error = fail(["study", "breakdown", &path]);
        assert!(error.contains(part), "{error}");
    }
    let error = fail(["study", "breakdown", &path, "-o", "x", "--cells", "3/2"]);
    assert!(error.contains("I from 1 to N"), "{error}");
}

#[test]
fn the_scene_beside_a_spec_in_the_current_folder_is_read_before_slices_are_computed() {
    let place = tempfile::tempdir().unwrap();
    let spec = SPEC.replace("modes = \"modes.json\"\n", "");
    let scene = "schema = \"modalign-scene/9\"\ntitle = \"x\"\n";
    write(
        place.path(),
        &[("study.toml", &spec), ("scene.toml", scene)],
    );
    for path in ["study.toml", "."] {
        let ran = modalign_in(place.path(), ["study", "breakdown", path, "-o", "out"]);
        let error = String::from_utf8_lossy(&ran.stderr);
        assert!(
            error.contains("got \"modalign-scene/9\""),
            "{path}: {error}"
        );
        // Before the first slice is computed.
        assert!(!place.path().join("out").exists(), "{path}");
    }
    // The modes that a spec names, too.
    write(
        place.path(),
        &[("study.toml", SPEC), ("modes.json", "{\"schema\": 1}")],
    );
    let words = ["study", "breakdown", "study.toml", "-o", "out"];
    let ran = modalign_in(place.path(), words);
    assert_eq!(ran.status.code(), Some(2), "{ran:?}");
    assert!(!place.path().join("out").exists());
}
