//! `check` and the scene's limits: exit 0 when met, 1 when missed, 2 on an error.

use crate::command::{fail, modalign, root, succeed, write};

fn code(arguments: &[&str]) -> i32 {
    modalign(arguments).status.code().unwrap()
}

#[test]
fn a_scene_whose_limit_is_missed_ends_with_exit_code_1_and_its_table() {
    let folder = tempfile::tempdir().unwrap();
    let source = root().join("measurements/free-free-beam");
    for name in ["scene.toml", "model.toml", "synth.toml"] {
        let text = std::fs::read_to_string(source.join(name)).unwrap();
        write(
            folder.path(),
            &[(
                name,
                &text.replace(
                    "max_frequency_error_percent = 5.0",
                    "max_frequency_error_percent = 2.0",
                ),
            )],
        );
    }
    let output = modalign(["run", folder.path().to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stdout).contains("MISSED"));
}

#[test]
fn results_are_checked_against_limits_and_baselines() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    succeed([
        "run",
        "measurements/free-free-beam",
        "-o",
        folder.path().to_str().unwrap(),
    ]);
    let (comparison, modes) = (path("comparison.json"), path("roving-hammer.modes.json"));
    write(
        folder.path(),
        &[
            (
                "met.toml",
                "[limits]\nmax_frequency_error_percent = 3.1\nmin_mac = 0.98\nmax_missed = 0\n",
            ),
            (
                "missed.toml",
                "[limits]\nmax_frequency_error_percent = 3.0\n",
            ),
            ("typo.toml", "[limits]\nmin_mca = 0.9\n"),
            (
                "mode.toml",
                "[limits]\n[[limits.mode]]\nfrequency_hz = 143.209\nmax_frequency_error_percent = 0.01\ndamping_ratio = 0.004\nmax_damping_error_percent = 3\n",
            ),
            (
                "other-mode.toml",
                "[limits]\n[[limits.mode]]\nfrequency_hz = 150\nmax_frequency_error_percent = 0.01\n",
            ),
        ],
    );
    assert_eq!(
        code(&["check", &comparison, "--against", &path("met.toml")]),
        0
    );
    assert_eq!(
        code(&["check", &comparison, "--against", &path("missed.toml")]),
        1
    );
    assert_eq!(code(&["check", &modes, "--against", &path("mode.toml")]), 0);
    assert_eq!(
        code(&["check", &modes, "--against", &path("other-mode.toml")]),
        1
    );
    assert!(
        fail(["check", &comparison, "--against", &path("typo.toml")])
            .contains("did you mean `min_mac`?")
    );
    assert_eq!(
        code(&[
            "check",
            &comparison,
            "--against",
            "measurements/free-free-beam/scene.toml"
        ]),
        0
    );
    assert_eq!(code(&["check", &comparison, "--against", &comparison]), 0);
    assert_eq!(code(&["check", &modes, "--against", &modes]), 0);
    assert!(
        fail(["check", &modes, "--against", &comparison]).contains("two results of the same kind")
    );
    let changed = std::fs::read_to_string(&modes).unwrap().replacen(
        "\"frequency_hz\": 143.2",
        "\"frequency_hz\": 143.4",
        1,
    );
    let changed = changed.replacen("\"pole_rad_s\": [", "\"was\": [", 1);
    write(folder.path(), &[("changed.json", &changed)]);
    let junit = path("junit.xml");
    assert_eq!(
        code(&[
            "check",
            &path("changed.json"),
            "--against",
            &modes,
            "--junit",
            &junit
        ]),
        1
    );
    let report = std::fs::read_to_string(&junit).unwrap();
    assert!(
        report.contains("<failure") && report.contains("mode 1 at 143.2"),
        "{report}"
    );
}

#[test]
fn theory_and_test_modes_are_compared_without_a_scene() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    succeed([
        "run",
        "measurements/free-free-beam",
        "-o",
        folder.path().to_str().unwrap(),
    ]);
    succeed([
        "theory",
        "measurements/free-free-beam",
        "--band",
        "0:3200",
        "-o",
        &path("theory.json"),
    ]);
    let arguments = [
        "correlate",
        "--test",
        &path("roving-hammer.modes.json"),
        "--theory",
        &path("theory.json"),
    ];
    let text = succeed(arguments.iter().copied().chain(["--full"]));
    let rows = text
        .lines()
        .filter(|line| line.trim_end().ends_with("  paired"));
    assert_eq!(rows.count(), 6, "{text}");
    assert!(text.contains("6 paired: 6 by shape"), "{text}");
    succeed(arguments.iter().copied().chain(["-o", &path("table.tex")]));
    assert!(
        std::fs::read_to_string(path("table.tex"))
            .unwrap()
            .contains("\\toprule")
    );
    assert!(
        fail(arguments.iter().copied().chain(["-o", &path("table.doc")]))
            .contains(".md or .csv or .tex or .txt or .html or .json")
    );
}

/// The beam's scene after a change to its text, in a folder with its model and recording.
fn beam(folder: &std::path::Path, change: impl Fn(&str) -> String) -> String {
    let source = root().join("measurements/free-free-beam");
    let text = |name: &str| std::fs::read_to_string(source.join(name)).unwrap();
    let scene = change(&text("scene.toml"));
    write(
        folder,
        &[
            ("scene.toml", &scene),
            ("model.toml", &text("model.toml")),
            ("synth.toml", &text("synth.toml")),
        ],
    );
    folder.to_str().unwrap().to_owned()
}

/// The text without the lines from the head of a table to the head of the next one.
fn without_table(text: &str, head: &str) -> String {
    let (before, table) = text.split_once(&format!("\n{head}\n")).unwrap();
    let end = table.find("\n[").unwrap();
    format!("{before}\n{}", &table[end + 1..])
}

#[test]
fn limits_of_a_scene_without_its_test_or_its_model_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |change: &dyn Fn(&str) -> String, parts: &[&str]| {
        let error = fail(["run", &beam(folder.path(), change)]);
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    };
    let without_test = |text: &str| {
        let text = without_table(text, "[[test]]");
        without_table(&text, "[test.state]")
    };
    let limits = [
        "[limits] min_mac",
        "[limits] max_missed",
        "without [[test]]",
    ];
    refused(&without_test, &limits);
    let mode = "\n[[limits.mode]]\nfrequency_hz = 143\nmax_frequency_error_percent = 1\n\n[pair]\n";
    let mode_alone = |text: &str| {
        let text = without_table(&without_test(text), "[limits]");
        text.replace("\n[pair]\n", mode)
    };
    refused(&mode_alone, &["[[limits.mode]]", "without [[test]]"]);
    let without_model = |text: &str| without_table(text, "[model]");
    refused(&without_model, &["[limits] min_mac", "without [model]"]);
    let extra_alone = |text: &str| {
        let text = without_table(&without_model(text), "[limits]");
        text.replace("\n[pair]\n", "\n[limits]\nmax_extra = 0\n\n[pair]\n")
    };
    refused(&extra_alone, &["[limits] max_extra", "without [model]"]);
    let infinite = |text: &str| text.replace("percent = 5.0", "percent = inf");
    refused(
        &infinite,
        &["[limits] max_frequency_error_percent", "got inf"],
    );
}

#[test]
fn published_results_without_content_are_an_error_and_a_template_is_none() {
    let folder = tempfile::tempdir().unwrap();
    let scene = beam(folder.path(), |text| {
        let text = without_table(text, "[[test]]");
        let text = without_table(&text, "[test.state]");
        without_table(&text, "[limits]")
    });
    let source =
        "schema = \"modalign-expected/1\"\n[source]\nauthors = \"A\"\npaper = \"B\"\nyear = 2000\n";
    for (text, part) in [
        ("", "schema"),
        ("\n \n\t\n", "schema"),
        (source, "[[root]]"),
        (&format!("{source}[comparison]\ntests = []\n"), "[[root]]"),
    ] {
        write(folder.path(), &[("expected.toml", text)]);
        let error = fail(["run", &scene]);
        assert!(
            error.contains("expected.toml") && error.contains(part),
            "{text:?}: {error}"
        );
    }
    write(folder.path(), &[("expected.toml", "\n# [[root]]\n\n")]);
    succeed(["run", &scene]);
    #[cfg(unix)]
    {
        let path = folder.path().join("expected.toml");
        std::fs::remove_file(&path).unwrap();
        std::os::unix::fs::symlink(folder.path().join("absent.toml"), &path).unwrap();
        let error = fail(["run", &scene]);
        assert!(error.contains("expected.toml"), "{error}");
    }
}
