//! What a verb prints fits a screen, and `--full` prints all that its JSON has.

use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::OnceLock;

use serde_json::Value;

use crate::command::{json, modalign, shared_folder, succeed};

/// Files of a synthetic test on the free-free beam, made by the verbs that are tested.
struct Files {
    folder: PathBuf,
}

impl Files {
    fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    fn made() -> &'static Files {
        static FILES: OnceLock<Files> = OnceLock::new();
        FILES.get_or_init(|| {
            let folder = shared_folder("screen");
            let files = Files { folder };
            let path = |name: &str| files.path(name).display().to_string();
            let (hits, frfs, modes) = (path("hits.uff"), path("frfs.uff"), path("modes.json"));
            let out = path("out");
            succeed(["synth", &format!("{BEAM}/synth.toml"), "-o", &hits]);
            succeed(["frf", &hits, "-o", &frfs]);
            succeed(["identify", &frfs, "-o", &modes]);
            succeed(["run", BEAM, "-o", &out]);
            succeed(["update", BEAM, "-o", &out]);
            files
        })
    }
}

const BEAM: &str = "measurements/free-free-beam";
const BEAM_MODEL: &str = "measurements/free-free-beam/model.toml";

/// A command on an example for each verb; `{}` is the folder of the files.
const EXAMPLES: &[&[&str]] = &[
    &["run", BEAM],
    HELICAL,
    &["run", "measurements/torsional-planetary"],
    &["inspect", "{}/hits.uff"],
    &["inspect", "{}/frfs.uff", "{}/modes.json"],
    &["convert", "{}/hits.uff", "-o", "{}/hits.h5"],
    &["frf", "{}/hits.uff"],
    &["frf", "{}/hits.uff", "--reject", "2,3,5"],
    &["identify", "{}/frfs.uff"],
    &["identify", "{}/frfs.uff", "--method", "circle"],
    &["theory", "cycloid-ball"],
    &["theory", "cycloid-ball/A", "--band", "0:2000", "--energies"],
    &["theory", "cycloid-ball", "--sensitivities"],
    &["theory", "torsional-planetary", "--quantities"],
    &["theory", "cycloid-ball", "--quantities"],
    &["theory", "torsional-planetary", "--sweep", "k_s=1e8:1e9:8"],
    &["theory", "helical-planetary", "--compare"],
    &["theory", BEAM, "--modify", "mass:3=0.05"],
    &["theory", "torsional-planetary", "--target", "f1 > 1800"],
    &["theory", BEAM_MODEL],
    &["theory", "{}/modes.json"],
    &[
        "correlate",
        "--test",
        "{}/out/roving-hammer.modes.json",
        "--theory",
        BEAM,
    ],
    &[
        "correlate",
        "--test",
        "{}/out/roving-hammer.modes.json",
        "--theory",
        BEAM,
        "--measures",
    ],
    &["correlate", "--test", "{}/modes.json"],
    &[
        "correlate",
        "--test",
        "{}/frfs.uff",
        "--theory",
        "{}/frfs.uff",
    ],
    &["update", BEAM],
    &[
        "synth",
        "measurements/free-free-beam/synth.toml",
        "-o",
        "{}/again.uff",
    ],
    &[
        "check",
        "{}/out/comparison.json",
        "--against",
        "measurements/free-free-beam/scene.toml",
    ],
    &[
        "check",
        "{}/out/update.json",
        "--against",
        "{}/out/update.json",
    ],
    &["report", "{}/out"],
    &["new", "{}/scene", "{}/frfs.uff", "--model", BEAM_MODEL],
];

fn arguments(example: &[&str], folder: &Path) -> Vec<String> {
    let folder = folder.display().to_string();
    example
        .iter()
        .map(|part| part.replace("{}", &folder))
        .collect()
}

/// Asserts that a text has at most these lines of these characters.
pub fn assert_fits(text: &str, lines: usize, characters: usize, what: &str) {
    let count = text.lines().count();
    assert!(
        count <= lines,
        "{what}: {count} lines, expected at most {lines}\n{text}"
    );
    for line in text.lines() {
        let width = line.chars().count();
        assert!(width <= characters, "{what}: {width} characters\n{line}");
    }
}

const HELICAL: &[&str] = &["run", "measurements/helical-planetary"];

/// What the run of the helical gear printed, and its folder, once for the whole suite.
pub fn helical_run() -> (Output, PathBuf) {
    static RUN: OnceLock<(Output, PathBuf)> = OnceLock::new();
    let run = || {
        let folder = shared_folder("helical-planetary");
        let written = ["-o".to_owned(), folder.display().to_string()];
        let words = HELICAL.iter().map(|word| (*word).to_owned());
        (modalign(words.chain(written)), folder)
    };
    RUN.get_or_init(run).clone()
}

#[test]
fn every_verb_prints_at_most_one_screen_of_its_example() {
    let files = Files::made();
    for example in EXAMPLES {
        let output = match *example == HELICAL {
            true => helical_run().0,
            false => modalign(arguments(example, &files.folder)),
        };
        let what = example.join(" ");
        let text = String::from_utf8(output.stdout).unwrap();
        let findings = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{what}: {findings}");
        assert_fits(&text, 40, 100, &what);
        assert_fits(&findings, 12, 200, &what);
        assert!(!text.trim().is_empty(), "{what}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_screen_of_eighty_columns_is_not_exceeded() {
    let files = Files::made();
    for example in EXAMPLES
        .iter()
        .filter(|example| !["convert", "synth", "new"].contains(&example[0]))
    {
        // An unquoted `>` would be a redirection.
        let arguments = arguments(example, &files.folder).into_iter();
        let quoted = arguments.map(|argument| format!("'{argument}'"));
        let arguments = quoted.collect::<Vec<_>>().join(" ");
        let line = format!("stty cols 80 rows 40; modalign {arguments} 2>/dev/null");
        let text = crate::manners::on_a_terminal(&line, &[("NO_COLOR", "1")]);
        let text = text.replace('\r', "");
        // Paths of temporary folders are as long as they are.
        let text = text.replace(&files.folder.display().to_string(), "");
        assert_fits(&text, 46, 80, &arguments);
    }
}

#[test]
fn columns_state_the_width_of_a_piped_screen_and_omitted_columns_are_named() {
    let output = std::process::Command::new(crate::command::program())
        .current_dir(crate::command::root())
        .env("COLUMNS", "72")
        .args(["run", BEAM])
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert_fits(&text, 60, 72, "run");
    assert!(
        text.contains("further columns (") && text.contains("damping (%)"),
        "{text}"
    );
}

#[test]
fn many_assumed_parameters_are_counted() {
    let screen = String::from_utf8(helical_run().0.stdout).unwrap();
    assert!(
        screen.contains("11 parameters (m_c, j_c, m_s, j_s, 7 more)"),
        "{screen}"
    );
}

#[test]
fn both_mac_of_an_update_say_which_they_are() {
    let (text, ..) = full_and_json(&["update", BEAM]);
    let table = &text[text.find("Modes used in the update").unwrap()..];
    let head = table.lines().take(4).collect::<Vec<_>>().join("\n");
    assert!(
        head.contains("MAC before") && head.contains("MAC after"),
        "{head}"
    );
    let page = std::fs::read_to_string(Files::made().path("out/report.html")).unwrap();
    assert!(page.contains("MAC before") && page.contains("MAC after"));
}

#[test]
fn whether_it_is_a_mode_stands_beside_uncertain_values_and_the_band_edge_is_named() {
    let circle = ["identify", "{}/frfs.uff", "--method", "circle"];
    let text = succeed(arguments(&circle, &Files::made().folder));
    let row = row(&text, "5");
    assert!(row.contains("yes") && row.contains("damping"), "{text}");
    assert!(text.contains("uncertain: its values to check"), "{text}");
    let edge = [&circle[..], &["--band", "142.8:600"]].concat();
    let text = succeed(arguments(&edge, &Files::made().folder));
    assert!(
        text.contains("Near the edge of the band: 143.19 Hz. Widen the band"),
        "{text}"
    );
}

/// Text of `--full` and JSON of the same command.
fn full_and_json(example: &[&str]) -> (String, String, Value) {
    let files = Files::made();
    let mut wanted = arguments(example, &files.folder);
    wanted.push("--full".to_owned());
    let output = modalign(&wanted);
    let text = String::from_utf8(output.stdout).unwrap();
    let findings = String::from_utf8(output.stderr).unwrap();
    *wanted.last_mut().unwrap() = "--json".to_owned();
    let json = serde_json::from_str(&succeed(&wanted)).unwrap();
    (text, findings, json)
}

/// A list of the JSON that has entries.
fn list<'v>(value: &'v Value, key: &str) -> &'v [Value] {
    let list = value[key]
        .as_array()
        .unwrap_or_else(|| panic!("{key}: {value}"));
    assert!(!list.is_empty(), "{key}");
    list
}

/// Asserts that a line of the table has a number of the JSON, `null` aside, in these decimals.
fn assert_number(line: &str, object: &Value, key: &str, scale: f64, decimals: usize) {
    let value = object.get(key).unwrap_or_else(|| panic!("{key}: {object}"));
    if let Some(value) = value.as_f64() {
        let printed = format!("{:.decimals$}", scale * value);
        assert!(
            line.contains(&printed),
            "{key}: {printed} is missing in\n{line}"
        );
    }
}

/// The line of a table that begins with a label.
fn row<'t>(text: &'t str, label: &str) -> &'t str {
    let mut lines = text.lines();
    let row = lines.find(|line| line.split_whitespace().next() == Some(label));
    row.unwrap_or_else(|| panic!("{label} is missing in\n{text}"))
}

#[test]
fn full_output_has_every_mode_and_finding_of_the_json() {
    let (text, findings, json) = full_and_json(&["identify", "{}/frfs.uff", "--method", "circle"]);
    let modes = list(&json, "modes");
    assert!(modes.len() >= 6);
    for (number, mode) in (1..).zip(modes) {
        let row = row(&text, &number.to_string());
        assert_number(row, mode, "frequency_hz", 1.0, 3);
        assert_number(row, mode, "damping_ratio", 100.0, 4);
        assert_number(row, mode, "mean_phase_rad", 180.0 / std::f64::consts::PI, 1);
    }
    for finding in list(&json, "findings") {
        let code = format!("[{}]", finding["code"].as_str().unwrap());
        let of_code = |finding: &&Value| format!("[{}]", finding["code"].as_str().unwrap()) == code;
        let count = list(&json, "findings").iter().filter(of_code).count();
        assert_eq!(
            findings.matches(&code).count(),
            count,
            "{code} in\n{findings}"
        );
    }
}

/// Asserts that the comparison table of a text has every row of a JSON.
fn assert_has_rows(text: &str, json: &Value) {
    let comparison = &text[text.find("chance level").unwrap()..];
    for row in list(json, "rows") {
        let cells = list(row, "tests");
        if cells.iter().all(|cell| cell["status"] == "outside-band") {
            continue;
        }
        let line = self::row(comparison, row["label"].as_str().unwrap());
        assert_number(line, &row["theory"], "hz", 1.0, 2);
        for cell in cells {
            assert_number(line, cell, "hz", 1.0, 2);
            assert_number(line, cell, "mac", 1.0, 4);
            assert_number(line, cell, "error_percent", 1.0, 3);
        }
    }
}

#[test]
fn full_output_has_every_row_of_the_comparison() {
    let (text, _, json) = full_and_json(&["run", BEAM]);
    assert_has_rows(&text, &json);
    for limit in list(&json, "limits") {
        assert!(text.contains(limit["what"].as_str().unwrap()), "{limit}");
    }
    let modes = "{}/out/roving-hammer.modes.json";
    let (text, _, json) = full_and_json(&["correlate", "--test", modes, "--theory", BEAM]);
    assert_has_rows(&text, &json);
}

#[test]
fn full_output_has_every_root_record_function_and_parameter() {
    let (text, _, json) = full_and_json(&["theory", BEAM_MODEL]);
    for mode in list(&json, "modes") {
        assert_number(&text, mode, "frequency_hz", 1.0, 6);
    }
    let (text, _, json) = full_and_json(&["inspect", "{}/hits.uff"]);
    let entries = list(&json["files"][0], "entries");
    assert_eq!(entries.len(), 66);
    let rows = text.lines().filter(|line| line.contains("s at 8192 Hz"));
    assert_eq!(rows.count(), entries.len());
    let (text, _, json) = full_and_json(&["frf", "{}/hits.uff"]);
    let (hits, functions) = (list(&json, "hits"), list(&json, "functions"));
    assert!(!hits.is_empty() && !functions.is_empty());
    let used = text.lines().filter(|line| line.contains("  used"));
    assert_eq!(used.count(), hits.len());
    let rows = text.lines().filter(|line| line.contains("accelerance"));
    assert_eq!(rows.count(), functions.len());
    let section = &text[text.find("Before you leave").unwrap()..];
    let items = list(&json, "before_you_leave");
    assert_eq!(items.len(), 5);
    for point in list(&items[0], "points") {
        let line = row(section, point["reference"].as_str().unwrap());
        assert_number(line, &point["resonance"], "frequency_hz", 1.0, 2);
        assert_number(line, &point["resonance"], "relative_std", 100.0, 3);
    }
    let (text, _, json) = full_and_json(&["update", BEAM]);
    for parameter in list(&json, "parameters") {
        assert!(text.contains(parameter["name"].as_str().unwrap()));
        assert!(text.contains(parameter["verdict"].as_str().unwrap()));
    }
    let checked = [
        "check",
        "{}/out/comparison.json",
        "--against",
        "{}/out/comparison.json",
    ];
    let (text, _, json) = full_and_json(&checked);
    for check in list(&json, "checks") {
        assert!(text.contains(check["what"].as_str().unwrap()), "{check}");
    }
}

#[test]
fn a_missed_limit_is_the_first_line_of_the_verdict() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["scene.toml", "model.toml", "synth.toml", "expected.toml"] {
        let from = crate::command::root().join(BEAM).join(name);
        std::fs::copy(from, folder.path().join(name)).unwrap();
    }
    let scene = folder.path().join("scene.toml");
    let text = std::fs::read_to_string(&scene).unwrap();
    let limit = text
        .lines()
        .find(|line| line.starts_with("max_frequency_error_percent"));
    let stricter = text.replace(limit.unwrap(), "max_frequency_error_percent = 0.5");
    std::fs::write(&scene, stricter).unwrap();
    let output = modalign(["run".as_ref(), folder.path().as_os_str()]);
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8(output.stdout).unwrap();
    let verdict: String = text.lines().skip(3).take(2).collect();
    assert!(
        verdict.starts_with("Limits of the scene: 1 of 6 MISSED ("),
        "{text}"
    );
    assert!(verdict.contains("(at most0.5)"), "{text}");
    let json = json(&{
        let out = folder.path().join("out");
        let arguments = [
            "run".as_ref(),
            folder.path().as_os_str(),
            "-o".as_ref(),
            out.as_os_str(),
        ];
        assert_eq!(modalign(arguments).status.code(), Some(1));
        out.join("comparison.json")
    });
    let missed = list(&json, "limits")
        .iter()
        .filter(|limit| limit["met"] == false);
    assert_eq!(missed.count(), 1);
}

#[test]
fn modes_of_a_model_have_the_labels_of_the_comparison() {
    for (scene, label, hz) in [
        (BEAM, "f1", "147.68"),
        (BEAM, "f6", "2752.5"),
        // The paper counts the root at 0 Hz.
        ("measurements/cycloid-ball", "f2", "1436.9"),
    ] {
        let text = succeed(["theory", scene]);
        assert!(row(&text, label).contains(hz), "{scene}: {text}");
        assert!(text.contains("rigid body"), "{text}");
    }
}

#[test]
fn many_files_of_many_kinds_fit_a_screen() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let mut names = Vec::new();
    for kind in 0..30_usize {
        // As many modes, and as many values in a column, as no other kind of file.
        let modes: String = (0..=kind)
            .map(|i| format!("{},0.01,1.0\n", 10 + i))
            .collect();
        let rows: String = (0..20 + kind)
            .map(|i| format!("{i},{},1\n", i % 7))
            .collect();
        for (name, text) in [
            (
                format!("m{kind}.csv"),
                format!("frequency_hz,damping_ratio,1:+Z\n{modes}"),
            ),
            (format!("t{kind}.txt"), rows.clone()),
            (format!("u{kind}.txt"), rows),
            (format!("n{kind}.md"), "notes\n".to_owned()),
        ] {
            std::fs::write(path(&name), text).unwrap();
            names.push(path(&name));
        }
    }
    let all = |more: &[&str]| {
        let names = names.iter().map(String::as_str);
        let output = modalign(
            ["inspect"]
                .into_iter()
                .chain(names)
                .chain(more.iter().copied()),
        );
        String::from_utf8(output.stdout).unwrap()
    };
    let screen = all(&[]);
    assert!(screen.lines().count() <= 40, "{screen}");
    // Files of one kind are in one row.
    assert!(
        screen.contains("t0.txt to u0.txt") && screen.contains("90 files"),
        "{screen}"
    );
    assert!(screen.contains("further files: --full"), "{screen}");
    let full = all(&["--full"]);
    for name in &names {
        assert!(full.contains(name.as_str()), "{name}");
    }
    // A few kinds are shown in full.
    let few = modalign(["inspect", &names[0], &names[1], &names[2]]);
    let few = String::from_utf8(few.stdout).unwrap();
    assert!(
        few.contains("2 files alike") && few.contains("shape"),
        "{few}"
    );
}

/// The texts of a scene, which no language changes: titles, names and statements.
fn scene_texts(folder: &str) -> Vec<String> {
    fn collect(value: &toml::Value, texts: &mut Vec<String>) {
        match value {
            toml::Value::String(text) => texts.push(text.clone()),
            toml::Value::Array(all) => all.iter().for_each(|one| collect(one, texts)),
            toml::Value::Table(table) => table.values().for_each(|one| collect(one, texts)),
            _ => (),
        }
    }
    let mut texts = Vec::new();
    for file in ["scene.toml", "expected.toml"] {
        let path = crate::command::root().join(folder).join(file);
        let text = std::fs::read_to_string(path).unwrap_or_default();
        let table: toml::Table = text.parse().unwrap();
        collect(&toml::Value::Table(table), &mut texts);
    }
    texts.retain(|text| text.contains(' '));
    texts.sort_by_key(|text| std::cmp::Reverse(text.len()));
    texts
}

/// The first three English words in a row, where the texts of the scene are left out.
pub fn english_words(printed: &str, of_scene: &[String]) -> Option<String> {
    let lines = printed.lines().map(|line| {
        let texts = of_scene.iter();
        texts.fold(line.to_owned(), |line, text| line.replace(text, "0"))
    });
    let is_word = |word: &str| {
        let word = word.trim_end_matches(['.', ':', ';', ',']);
        word.len() > 1 && word.chars().all(|c| c.is_ascii_lowercase())
    };
    lines.into_iter().find_map(|line| {
        // Two blanks part the columns of a table.
        let words: Vec<&str> = line.split(' ').collect();
        let mut runs = words.windows(3);
        let run = runs.find(|run| {
            let inner = run[..2].iter();
            run.iter().all(|word| is_word(word)) && inner.copied().all(|word| !word.ends_with(','))
        });
        run.map(|run| format!("{} in {line}", run.join(" ")))
    })
}

#[test]
fn a_chinese_screen_has_no_english_sentence() {
    let known = english_words("已配对 (paired by frequency alone.)", &[]);
    assert!(known.is_none() && english_words("a: paired by frequency.", &[]).is_some());
    // Short records are enough for the sentences of a run. One start of an update is enough for its
    // sentences, but not for those on other optima.
    let folder = tempfile::tempdir().unwrap();
    let shorter = folder.path().join("shorter");
    std::fs::create_dir(&shorter).unwrap();
    let files = std::fs::read_dir(crate::command::root().join("measurements/cycloid-ball"));
    for file in files.unwrap() {
        let path = file.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        let text = match path.file_name().and_then(|name| name.to_str()) {
            Some("virtual-discs.toml") => text.replace("samples = 131072", "samples = 32768"),
            Some("virtual-discs-and-balls.toml") => {
                text.replace("samples = 32768", "samples = 8192")
            }
            Some("scene.toml") => text
                .replace("[update]\n", "[update]\nstarts = 1\n")
                .replace("[500.0, 9750.0]", "[500.0, 9300.0]"),
            _ => text,
        };
        std::fs::write(shorter.join(path.file_name().unwrap()), text).unwrap();
    }
    let shorter = shorter.display().to_string();
    for [verb, folder, texts] in [
        ["run", BEAM, BEAM],
        ["update", BEAM, BEAM],
        ["run", &shorter, "measurements/cycloid-ball"],
        ["update", &shorter, "measurements/cycloid-ball"],
    ] {
        let output = modalign([verb, folder, "--lang", "zh"]);
        let of_scene = scene_texts(texts);
        for stream in [output.stdout, output.stderr] {
            let text = String::from_utf8(stream).unwrap();
            let found = english_words(&text, &of_scene);
            assert!(!text.contains("error: "), "{verb} {folder}\n{text}");
            assert_eq!(found, None, "{verb} {folder}\n{text}");
            for gap in ["： ", "。 ", " 。", " ，"] {
                assert!(!text.contains(gap), "{gap:?} in\n{text}");
            }
        }
    }
}

#[test]
fn every_verb_prints_its_screen_in_chinese() {
    let files = Files::made();
    // Texts of publications are in their language.
    let is_tested = |example: &&&[&str]| {
        !["run", "report"].contains(&example[0]) && !example.contains(&"--quantities")
    };
    let of_scene = scene_texts(BEAM);
    let more: [&[&str]; 2] = [
        &["new", "{}/scene", "{}/hits.uff", "--model", "beam"],
        &["study", "order", BEAM],
    ];
    for example in EXAMPLES.iter().filter(is_tested).chain(&more) {
        let mut arguments = arguments(example, &files.folder);
        if example[0] == "new" {
            let name = format!("zh-{}", example[2].replace("{}/", ""));
            arguments[1] = files.path(&name).display().to_string();
        }
        arguments.extend(["--lang", "zh"].map(str::to_owned));
        let text = succeed(&arguments).replace(&files.folder.display().to_string(), "");
        let found = english_words(&text, &of_scene);
        assert_eq!(found, None, "{arguments:?}\n{text}");
    }
}

#[test]
fn no_number_on_a_screen_has_more_than_five_significant_digits_behind_a_point() {
    let files = Files::made();
    let is_tested = |example: &&&[&str]| !["run", "new", "report"].contains(&example[0]);
    for example in EXAMPLES.iter().filter(is_tested) {
        let text = succeed(arguments(example, &files.folder));
        for word in text.split_whitespace() {
            let mantissa = word.split('e').next().unwrap_or_default();
            if word.parse::<f64>().is_err() || !mantissa.contains('.') {
                continue;
            }
            let digits = mantissa.trim_start_matches(['+', '-', '0', '.']);
            let count = digits.chars().filter(char::is_ascii_digit).count();
            assert!(count <= 5, "{word} in {example:?}\n{text}");
        }
    }
}

#[test]
fn an_update_says_on_which_tests_and_how_many_hits_it_rests() {
    let screen = succeed(["update", BEAM]);
    let line = "\nFitted: roving hammer. Hits: all 33 used.\n";
    assert!(screen.contains(line), "{screen}");
}

#[test]
fn shapes_of_one_degree_of_freedom_are_not_compared() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.json").display().to_string();
    let modes = [(53.0, None, vec![1.0]), (146.0, None, vec![1.0])];
    std::fs::write(&path, crate::updating::modes_json(&modes)).unwrap();
    let screen = succeed(["correlate", "--test", &path]);
    assert!(
        screen.contains("shapes of one degree of freedom cannot be compared"),
        "{screen}"
    );
    assert!(
        !screen.contains("Duplicates") && !screen.contains('—'),
        "{screen}"
    );
}
