//! Seeded changes of TOML and JSON inputs: each ends with a result or an error, never with a panic.
//!
//! Numbers get hostile values, lines are removed, repeated and exchanged, texts are replaced. The
//! number of a file is the seed of its changes; `MUTATED_FILES` states how many are tried of each
//! kind, `MUTATED_FIRST` the number of the first.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use modalign::axis::Band;
use modalign::io::{modes_from_json, selection_from_json};
use modalign::report::json::{comparison_from_json, report_from_json, update_from_json};
use modalign::report::{CompanionResults, Language, report_page};
use modalign::scene::{
    LimitedResult, LimitsUse, Scene, hammer_test, limits_from_toml, load_expected, load_model,
    load_synth, record,
};
use modalign::theory::ModeOptions;
use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::command::{root, succeed};
use crate::mutation::stated;

/// Mutations of each kind of input, unless `MUTATED_FILES` states another number.
const FILES: usize = 60;

/// An input that takes longer is a failure: some ten thousand times the time of one.
const MAX_TIME: Duration = Duration::from_secs(60);

/// Values that counts, sizes, masses, frequencies and names cannot have, or hardly.
const HOSTILE: &[&str] = &[
    "0",
    "-1",
    "1",
    "2",
    "-0.0",
    "1e308",
    "-1e308",
    "5e-324",
    "1e-308",
    "1e16",
    "1e-16",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551615",
    "4294967296",
    "1000000000",
    "100000",
    "inf",
    "nan",
    "-inf",
    "null",
    "true",
    "[]",
    "{}",
    "\"\"",
    "\"x\"",
    "0.5",
    "1e300",
];

/// An input with its changes.
fn mutated(text: &str, random: &mut ChaCha8Rng) -> String {
    let mut text = text.to_owned();
    for _ in 0..random.random_range(1..=3) {
        text = match random.random_range(0..10) {
            0..=5 => with_hostile_number(&text, random),
            6 => with_changed_lines(&text, random),
            7 => with_hostile_text(&text, random),
            8 => {
                let cut = random.random_range(0..=text.len());
                let cut = (cut..=text.len()).find(|at| text.is_char_boundary(*at));
                text[..cut.unwrap_or(0)].to_owned()
            }
            _ => {
                let mut characters: Vec<char> = text.chars().collect();
                if let Some(at) = (0..characters.len()).collect::<Vec<_>>().choose(random) {
                    characters[*at] = char::from(random.random_range(32..127_u8));
                }
                characters.into_iter().collect()
            }
        };
    }
    text
}

fn with_hostile_number(text: &str, random: &mut ChaCha8Rng) -> String {
    let is_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | 'e' | '+');
    let mut tokens = Vec::new();
    let mut start = None;
    for (at, c) in text.char_indices().chain([(text.len(), ' ')]) {
        match (start, is_number(c)) {
            (None, true) if c.is_ascii_digit() || c == '-' => start = Some(at),
            (Some(first), false) => {
                tokens.push(first..at);
                start = None;
            }
            _ => {}
        }
    }
    let Some(token) = tokens.choose(random) else {
        return text.to_owned();
    };
    let value = HOSTILE.choose(random).expect("there are some");
    [&text[..token.start], value, &text[token.end..]].concat()
}

fn with_changed_lines(text: &str, random: &mut ChaCha8Rng) -> String {
    let mut lines: Vec<&str> = text.lines().collect();
    if lines.is_empty() {
        return String::new();
    }
    let (one, other) = (
        random.random_range(0..lines.len()),
        random.random_range(0..lines.len()),
    );
    match random.random_range(0..3) {
        0 => drop(lines.remove(one)),
        1 => lines.insert(other, lines[one]),
        _ => lines.swap(one, other),
    }
    lines.join("\n")
}

fn with_hostile_text(text: &str, random: &mut ChaCha8Rng) -> String {
    let quotes: Vec<usize> = text.match_indices('"').map(|(at, _)| at).collect();
    let Some(pair) = quotes
        .chunks_exact(2)
        .collect::<Vec<_>>()
        .choose(random)
        .copied()
    else {
        return text.to_owned();
    };
    let long = "x".repeat(5000);
    let texts = [
        "",
        "\\u0000",
        "1:+Z",
        "../..",
        "ground",
        "-",
        "🦀",
        "kg",
        long.as_str(),
    ];
    let value = texts.choose(random).expect("there are some");
    [&text[..=pair[0]], value, &text[pair[1]..]].concat()
}

/// Reads and uses an input in a folder where the files lie that it names.
type Use = fn(&str, &Path);

/// A kind of input.
struct Kind {
    name: &'static str,
    text: String,
    used: Use,
}

fn use_model(text: &str, folder: &Path) {
    let path = folder.join("mutated-model.toml");
    std::fs::write(&path, text).unwrap();
    if let Ok(model) = load_model(&path, &BTreeMap::new()) {
        let options = ModeOptions {
            band: Band::new(0.0, 3000.0).ok(),
            ..ModeOptions::default()
        };
        let _ = model.solve(&[], &options);
    }
}

fn use_spec(text: &str, folder: &Path) {
    let path = folder.join("mutated-synth.toml");
    std::fs::write(&path, text).unwrap();
    let Ok(spec) = load_synth(&path) else { return };
    // More samples take time and nothing else.
    if spec.record.samples > 1 << 14 || spec.averages > 10 {
        let _ = hammer_test(&spec, &path);
        return;
    }
    if let Ok(test) = hammer_test(&spec, &path) {
        let _ = record(&spec, &test, &path);
    }
}

fn use_scene(text: &str, folder: &Path) {
    std::fs::write(folder.join("scene.toml"), text).unwrap();
    let _ = Scene::load(folder);
}

fn use_expected(text: &str, folder: &Path) {
    let path = folder.join("expected.toml");
    std::fs::write(&path, text).unwrap();
    let _ = load_expected(&path);
}

fn use_limits(text: &str, _folder: &Path) {
    let used = LimitsUse {
        decided_by: &[LimitedResult::Comparison],
        result: "a comparison.json",
        expected: "limits on a comparison",
    };
    let _ = limits_from_toml(text, "limits.toml", used);
}

fn use_modes(text: &str, _folder: &Path) {
    let _ = modes_from_json(text, "modes.json");
}

fn use_comparison(text: &str, _folder: &Path) {
    if let Ok(file) = comparison_from_json(text) {
        let _ = file.check_summary();
    }
}

fn use_update(text: &str, _folder: &Path) {
    let _ = update_from_json(text);
}

fn use_report(text: &str, _folder: &Path) {
    if let Ok(report) = report_from_json(text, "report.json") {
        let _ = report_page(&report, &CompanionResults::default(), Language::English);
    }
}

fn use_selection(text: &str, _folder: &Path) {
    let _ = selection_from_json(text, "selection.json");
}

/// A body on springs, with every kind of property.
const LUMPED: &str = "schema = \"modalign-model/1\"\ntitle = \"x\"\n[[parameter]]\nname = \"k\"\nunit = \"N/m\"\nnominal = 2e6\nlower = 1e6\nupper = 4e6\nstatus = \"assumed\"\n[[body]]\nname = \"a\"\nat_m = [0.0, 0.0, 0.0]\nmass_kg = 2.0\ninertia_kg_m2 = [0.01, 0.01, 0.02]\nfree = [\"x\", \"y\", \"rz\"]\n[[body]]\nname = \"b\"\nat_m = [0.3, 0.0, 0.0]\nmass_kg = 1.0\ninertia_kg_m2 = [0.01, 0.01, 0.02]\nfree = [\"x\", \"z\"]\n[[point]]\nname = \"p\"\nbody = \"a\"\nat_m = [0.1, 0.05, 0.0]\n[[point]]\nname = \"q\"\nbody = \"b\"\nat_m = [0.2, 0.0, 0.0]\n[[spring]]\nname = \"s\"\nfrom = \"p\"\nto = \"q\"\ndirection = [1.0, 0.0, 0.0]\nparameter = \"k\"\n[[spring]]\nname = \"g\"\nfrom = \"q\"\nto = \"ground\"\ndirection = [0.0, 0.0, 1.0]\nstiffness_n_per_m = 1e5\n";

fn kinds() -> Vec<Kind> {
    let beam = root().join("measurements/free-free-beam");
    let read = |path: &Path| std::fs::read_to_string(path).unwrap();
    let text = |name: &str| read(&beam.join(name));
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let small = text("synth.toml").replace("samples = 32768", "samples = 2048");
    std::fs::write(folder.path().join("synth.toml"), &small).unwrap();
    for name in ["scene.toml", "model.toml", "expected.toml"] {
        std::fs::copy(beam.join(name), folder.path().join(name)).unwrap();
    }
    modalign_of(&["run", out, "-o", out]);
    let updated = folder.path().join("updated");
    succeed(["update", out, "-o", updated.to_str().unwrap()]);
    let result = |name: &str| read(&folder.path().join(name));
    let kind = |name, text, used: Use| Kind { name, text, used };
    let limits = "[limits]\nmin_mac = 0.9\nmax_missed = 0\nmax_frequency_error_percent = 5.0\n";
    let selection = "{\"schema\": \"modalign-selection/1\", \"poles\": [{\"frequency_hz\": 100.0, \"damping_ratio\": 0.01, \"order\": 8}]}";
    vec![
        kind("beam model", text("model.toml"), use_model),
        kind("lumped model", LUMPED.to_owned(), use_model),
        kind("synthetic test", small.clone(), use_spec),
        kind("scene", text("scene.toml"), use_scene),
        kind("expected", text("expected.toml"), use_expected),
        kind("limits", limits.to_owned(), use_limits),
        kind("modes", result("roving-hammer.modes.json"), use_modes),
        kind("comparison", result("comparison.json"), use_comparison),
        kind("update", result("updated/update.json"), use_update),
        kind("report", result("report.json"), use_report),
        kind("selection", selection.to_owned(), use_selection),
    ]
}

/// Runs the program, whatever the limits of the scene.
fn modalign_of(arguments: &[&str]) {
    let ran = crate::command::modalign(arguments);
    assert_ne!(ran.status.code(), Some(2), "{ran:?}");
}

#[test]
fn mutated_inputs_end_with_a_result_or_an_error() {
    let (first, files) = (stated("MUTATED_FIRST", 0), stated("MUTATED_FILES", FILES));
    let failures: Vec<String> = kinds()
        .iter()
        .flat_map(|kind| {
            let one = |number: usize| {
                let mut random = ChaCha8Rng::seed_from_u64(number as u64);
                let text = mutated(&kind.text, &mut random);
                let folder = tempfile::tempdir().unwrap();
                let begin = Instant::now();
                let used = catch_unwind(AssertUnwindSafe(|| (kind.used)(&text, folder.path())));
                let is_slow = begin.elapsed() > MAX_TIME;
                (used.is_err() || is_slow).then(|| {
                    let how = if is_slow { "slow" } else { "panic" };
                    format!("{} {number}: {how}", kind.name)
                })
            };
            let numbers = (first..first + files).into_par_iter();
            numbers.filter_map(one).collect::<Vec<_>>()
        })
        .collect();
    assert!(failures.is_empty(), "{failures:#?}");
}
