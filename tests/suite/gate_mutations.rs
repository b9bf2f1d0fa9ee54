//! Mutations of results, limits and baselines, through `check`: 120 and more that must fail, each
//! a value that is wrong or missing, and 40 that must pass.

use std::path::Path;

use serde_json::{Value, json};

use crate::command::{json as read_json, modalign, root, succeed, write};

const MODES: &str = "roving-hammer.modes.json";
const COMPARISON: &str = "comparison.json";
const UPDATE: &str = "update.json";

/// A change of a result.
struct Mutation {
    file: &'static str,
    /// What is changed, for messages.
    name: String,
    change: Box<dyn Fn(&mut Value)>,
}

/// Sets a place of a file, by its JSON pointer.
fn set(file: &'static str, pointer: &str, value: impl Fn(&Value) -> Value + 'static) -> Mutation {
    let place = pointer.to_owned();
    Mutation {
        file,
        name: pointer.to_owned(),
        change: Box::new(move |result| {
            let at = result.pointer_mut(&place);
            let at = at.unwrap_or_else(|| panic!("{place} is in the file"));
            *at = value(at);
        }),
    }
}

fn change(file: &'static str, name: &str, change: impl Fn(&mut Value) + 'static) -> Mutation {
    Mutation {
        file,
        name: name.to_owned(),
        change: Box::new(change),
    }
}

fn times(factor: f64) -> impl Fn(&Value) -> Value {
    move |value| json!(factor * value.as_f64().unwrap())
}

fn constant(value: Value) -> impl Fn(&Value) -> Value {
    move |_| value.clone()
}

/// Every number below a place, multiplied.
fn scaled(value: &mut Value, factor: f64) {
    match value {
        Value::Number(number) => *value = json!(factor * number.as_f64().unwrap()),
        Value::Array(values) => values.iter_mut().for_each(|value| scaled(value, factor)),
        Value::Object(values) => values.values_mut().for_each(|value| scaled(value, factor)),
        _ => {}
    }
}

fn modes(result: &mut Value) -> impl Iterator<Item = &mut Value> {
    result["modes"].as_array_mut().unwrap().iter_mut()
}

/// Mutations of the numbers that every mode has.
fn mode_mutations() -> Vec<Mutation> {
    let mut all = Vec::new();
    for number in 0..6 {
        let at = |key: &str| format!("/modes/{number}/{key}");
        for factor in [1.01, 0.99] {
            all.push(change(
                MODES,
                &format!("frequency and pole {factor}"),
                move |result| {
                    let mode = &mut result["modes"][number];
                    scaled(&mut mode["frequency_hz"], factor);
                    scaled(&mut mode["pole_rad_s"], factor);
                },
            ));
        }
        all.push(change(MODES, "damping and no pole", move |result| {
            let mode = &mut result["modes"][number];
            scaled(&mut mode["damping_ratio"], 1.5);
            mode["pole_rad_s"] = Value::Null;
        }));
        all.push(set(MODES, &at("frequency_hz"), times(1.001)));
        all.push(set(MODES, &at("frequency_std_hz"), constant(json!(100.0))));
        all.push(set(MODES, &at("frequency_std_hz"), constant(json!(-1.0))));
        all.push(set(MODES, &at("damping_std"), constant(json!(1.0))));
        all.push(set(MODES, &at("damping_std"), constant(Value::Null)));
        all.push(change(MODES, "residues", move |result| {
            scaled(&mut result["modes"][number]["residues"], 2.0);
        }));
        all.push(set(MODES, &at("modal_mass_kg"), times(2.0)));
        all.push(set(
            MODES,
            &at("shape"),
            constant(json!({"1:+Z": [1.0, 0.0]})),
        ));
    }
    all.extend([
        set(MODES, "/modes", constant(json!([]))),
        change(MODES, "a mode less", |result| {
            result["modes"].as_array_mut().unwrap().remove(3);
        }),
        change(MODES, "a mode twice", |result| {
            let mode = result["modes"][2].clone();
            result["modes"].as_array_mut().unwrap().push(mode);
        }),
        change(MODES, "all frequencies", |result| {
            for mode in modes(result) {
                scaled(&mut mode["frequency_hz"], 1.002);
                scaled(&mut mode["pole_rad_s"], 1.002);
            }
        }),
        change(MODES, "all residues reversed", |result| {
            modes(result).for_each(|mode| scaled(&mut mode["residues"], -1.0));
        }),
        change(MODES, "no residues", |result| {
            modes(result).for_each(|mode| mode["residues"] = json!({}));
        }),
        change(MODES, "all shapes doubled", |result| {
            modes(result).for_each(|mode| scaled(&mut mode["shape"], 2.0));
        }),
        change(MODES, "a component reversed", |result| {
            scaled(&mut result["modes"][1]["shape"]["5:+Z"], -1.0);
        }),
        set(MODES, "/modes/0/shape/1:+Z/0", constant(json!(1e300))),
        set(MODES, "/modes/0/scaling", constant(json!("unknown"))),
        set(MODES, "/modes/0/mpc", constant(json!(-1.0))),
        set(MODES, "/schema", constant(json!("modalign-modes/9"))),
    ]);
    all
}

fn comparison_mutations() -> Vec<Mutation> {
    let mut all = Vec::new();
    for row in [0, 5] {
        let cell = |key: &str| format!("/rows/{row}/tests/0/{key}");
        for (key, value) in [
            ("hz", json!(1.0)),
            ("hz", Value::Null),
            ("hz_std", json!(1e3)),
            ("hz_std", json!(-1.0)),
            ("hz_std", Value::Null),
            ("error_percent", json!(10.0)),
            ("error_percent", Value::Null),
            ("damping_ratio", json!(0.5)),
            ("damping_std", json!(1e3)),
            ("mac", json!(0.1)),
            ("mac", Value::Null),
            ("status", json!("ambiguous")),
            ("status", json!("missed-unexpected")),
            ("status", json!("wonderful")),
            ("basis", json!("hope")),
            ("test", json!("another")),
        ] {
            all.push(set(COMPARISON, &cell(key), constant(value)));
        }
        all.push(set(
            COMPARISON,
            &format!("/rows/{row}/theory/hz"),
            times(1.0001),
        ));
    }
    for (key, value) in [
        ("missed", json!(1)),
        ("ambiguous", json!(2)),
        ("extra", json!(1)),
        ("max_error_percent", json!(0.1)),
        ("rms_error_percent", json!(0.1)),
        ("mean_error_percent", Value::Null),
        ("min_mac", json!(1.0)),
    ] {
        all.push(set(
            COMPARISON,
            &format!("/summary/tests/0/{key}"),
            constant(value),
        ));
    }
    all.extend([
        set(COMPARISON, "/rows", constant(json!([]))),
        set(COMPARISON, "/summary/tests", constant(json!([]))),
        set(COMPARISON, "/error_reference", constant(json!("other"))),
        change(COMPARISON, "a row less", |result| {
            result["rows"].as_array_mut().unwrap().pop();
        }),
        change(COMPARISON, "a row twice", |result| {
            let row = result["rows"][0].clone();
            result["rows"].as_array_mut().unwrap().push(row);
        }),
        set(
            COMPARISON,
            "/schema",
            constant(json!("modalign-comparison/0")),
        ),
    ]);
    all
}

fn update_mutations() -> Vec<Mutation> {
    let mut all = Vec::new();
    for number in 0..2 {
        let at = |key: &str| format!("/parameters/{number}/{key}");
        for (key, value) in [
            ("updated", json!(1e300)),
            ("std", json!(0.0)),
            ("std", json!(1e15)),
            ("verdict", json!("at bound")),
            ("unit", json!("furlong")),
            ("prior_std", json!(1e3)),
            ("initial", json!(7.0)),
            ("upper", json!(1e20)),
            ("name", json!("another")),
        ] {
            all.push(set(UPDATE, &at(key), constant(value)));
        }
    }
    for (place, value) in [
        ("/stop_reason", json!("diverged")),
        ("/fits", json!(false)),
        ("/reduced_chi_square", json!(1e6)),
        ("/reduced_chi_square", json!(0.0)),
        ("/degrees_of_freedom", json!(10.0)),
        ("/residuals", json!("frfs")),
        ("/after/paired", json!(5)),
        ("/after/chi_square", json!(1e6)),
        ("/after/rms_percent", json!(0.0)),
        ("/after/largest_percent", json!(50.0)),
        ("/after/rows/1/model_hz", json!(1.0)),
        ("/after/rows/1/test_hz", json!(1.0)),
        ("/after/rows/1/error_percent", json!(9.0)),
        ("/after/rows/1/mac", json!(0.5)),
        ("/after/rows", json!([])),
        ("/assumed/frequency_floor", json!(0.1)),
        ("/parameters", json!([])),
    ] {
        all.push(set(UPDATE, place, constant(value)));
    }
    all
}

/// Limits that the results miss, that cannot be meant, or that are about another kind of result.
const FAILING_LIMITS: &[(&str, &str)] = &[
    (COMPARISON, "max_frequency_error_percent = 3.0"),
    (COMPARISON, "min_mac = 0.995"),
    (COMPARISON, "min_paired = 7"),
    (COMPARISON, "max_frequency_error_percent = inf"),
    (COMPARISON, "max_frequency_error_percent = nan"),
    (COMPARISON, "max_frequency_error_percent = -5"),
    (COMPARISON, "min_mac = -0.5"),
    (COMPARISON, "min_mac = 95"),
    (COMPARISON, "max_missed = -1"),
    (COMPARISON, "min_mca = 0.9"),
    (COMPARISON, ""),
    (
        COMPARISON,
        "[[limits.mode]]\nfrequency_hz = 143.2\nmax_frequency_error_percent = 1",
    ),
    (
        MODES,
        "[[limits.mode]]\nfrequency_hz = 150\nmax_frequency_error_percent = 1",
    ),
    (
        MODES,
        "[[limits.mode]]\nfrequency_hz = 143.2\nmax_frequency_error_percent = inf",
    ),
    (
        MODES,
        "[[limits.mode]]\nfrequency_hz = 143.2\nmax_frequency_error_percent = 1\ndamping_ratio = 0.004",
    ),
    (
        MODES,
        "[[limits.mode]]\nfrequency_hz = 143.2\nmax_frequency_error_percent = 1\nmax_damping_error_percent = 4",
    ),
    (MODES, "min_paired = 6"),
    (UPDATE, "min_paired = 6"),
];

/// Results of the beam and of its update.
fn results(folder: &Path) {
    let beam = root().join("measurements/free-free-beam");
    let out = folder.to_str().unwrap();
    succeed(["run", beam.to_str().unwrap(), "-o", out]);
    succeed(["update", beam.to_str().unwrap(), "-o", out]);
    // Results without the manifest of their folder, which holds for the folder alone.
    std::fs::create_dir(folder.join("now")).unwrap();
    std::fs::create_dir(folder.join("before")).unwrap();
    for name in [MODES, COMPARISON, UPDATE] {
        std::fs::copy(folder.join(name), folder.join("before").join(name)).unwrap();
    }
}

/// Writes limits, of modes or under `[limits]`.
fn write_limits(folder: &Path, limits: &str) {
    let head = if limits.starts_with("[[") {
        ""
    } else {
        "[limits]\n"
    };
    write(folder, &[("limits.toml", &format!("{head}{limits}\n"))]);
}

/// The exit code of a mutated result against its baseline.
fn code(folder: &Path, name: &str, result: &Value, against: &str, more: &[&str]) -> i32 {
    let now = folder.join("now").join(name);
    std::fs::write(&now, result.to_string()).unwrap();
    let against = folder.join(against);
    let arguments = [
        "check",
        now.to_str().unwrap(),
        "--against",
        against.to_str().unwrap(),
    ];
    let output = modalign(arguments.iter().chain(more));
    output.status.code().expect("an exit code")
}

#[test]
fn wrong_results_and_limits_fail() {
    let folder = tempfile::tempdir().unwrap();
    results(folder.path());
    let before = |name: &str| folder.path().join("before").join(name);
    let all = [mode_mutations(), comparison_mutations(), update_mutations()];
    let mut passed = Vec::new();
    let mut count = 0;
    for mutation in all.iter().flatten() {
        let mut result = read_json(&before(mutation.file));
        (mutation.change)(&mut result);
        let against = format!("before/{}", mutation.file);
        match code(folder.path(), mutation.file, &result, &against, &[]) {
            1 | 2 => count += 1,
            _ => passed.push(format!("{} {}", mutation.file, mutation.name)),
        }
    }
    for (name, limits) in FAILING_LIMITS {
        write_limits(folder.path(), limits);
        match code(
            folder.path(),
            name,
            &read_json(&before(name)),
            "limits.toml",
            &[],
        ) {
            1 | 2 => count += 1,
            _ => passed.push(format!("{name} {limits}")),
        }
    }
    // A baseline that lost what the result has.
    for mutation in [
        change(MODES, "a mode less in the baseline", |result| {
            result["modes"].as_array_mut().unwrap().remove(0);
        }),
        change(COMPARISON, "a row less in the baseline", |result| {
            result["rows"].as_array_mut().unwrap().remove(0);
        }),
        change(UPDATE, "a parameter less in the baseline", |result| {
            result["parameters"].as_array_mut().unwrap().remove(0);
        }),
    ] {
        let now = read_json(&before(mutation.file));
        let mut baseline = now.clone();
        (mutation.change)(&mut baseline);
        write(folder.path(), &[("baseline.json", &baseline.to_string())]);
        match code(folder.path(), mutation.file, &now, "baseline.json", &[]) {
            1 | 2 => count += 1,
            _ => passed.push(mutation.name),
        }
    }
    assert!(passed.is_empty(), "{passed:#?}");
    assert!(count >= 120, "{count}");
}

/// Changes that lie within the deviations, or change no value.
fn passing_mutations() -> Vec<Mutation> {
    let mut all = Vec::new();
    for number in 0..6 {
        for deviations in [-1.0, 1.0] {
            all.push(change(
                MODES,
                "a deviation of the frequency",
                move |result| {
                    let mode = &mut result["modes"][number];
                    let std = mode["frequency_std_hz"].as_f64().unwrap();
                    let hz = mode["frequency_hz"].as_f64().unwrap();
                    let factor = 1.0 + deviations * std / hz;
                    scaled(&mut mode["frequency_hz"], factor);
                    scaled(&mut mode["pole_rad_s"], factor);
                },
            ));
        }
        all.push(change(MODES, "twice the deviation", move |result| {
            scaled(&mut result["modes"][number]["frequency_std_hz"], 2.0);
        }));
        all.push(change(MODES, "residues by 2 %", move |result| {
            scaled(&mut result["modes"][number]["residues"], 1.02);
        }));
    }
    for file in [MODES, COMPARISON, UPDATE] {
        all.push(change(file, "nothing", |_| {}));
        all.push(change(file, "a key that is not known", |result| {
            result["a key of a later version"] = json!({"x": [1, null]});
        }));
        all.push(change(file, "rounding", |result| {
            let text = result.to_string();
            *result = serde_json::from_str(&text).unwrap();
        }));
    }
    all.push(set(MODES, "/producer", constant(json!("another program"))));
    all.push(set(MODES, "/findings", constant(json!([]))));
    all.push(change(MODES, "modes in another order", |result| {
        result["modes"].as_array_mut().unwrap().reverse();
    }));
    all.push(change(COMPARISON, "rows in another order", |result| {
        result["rows"].as_array_mut().unwrap().reverse();
    }));
    all.push(change(UPDATE, "parameters in another order", |result| {
        result["parameters"].as_array_mut().unwrap().reverse();
    }));
    all.push(change(UPDATE, "half a deviation", |result| {
        let parameter = &mut result["parameters"][0];
        let value = parameter["updated"].as_f64().unwrap();
        parameter["updated"] = json!(value + 0.5 * parameter["std"].as_f64().unwrap());
    }));
    all
}

#[test]
fn results_within_their_deviations_pass() {
    let folder = tempfile::tempdir().unwrap();
    results(folder.path());
    let before = |name: &str| folder.path().join("before").join(name);
    let mut failed = Vec::new();
    let mut count = 0;
    for mutation in passing_mutations() {
        let mut result = read_json(&before(mutation.file));
        (mutation.change)(&mut result);
        let against = format!("before/{}", mutation.file);
        match code(folder.path(), mutation.file, &result, &against, &[]) {
            0 => count += 1,
            _ => failed.push(format!("{} {}", mutation.file, mutation.name)),
        }
    }
    for (name, limits) in [
        (COMPARISON, "max_frequency_error_percent = 3.1"),
        (
            COMPARISON,
            "min_mac = 0.99\nmin_paired = 6\nmax_missed = 0\nmax_extra = 0",
        ),
        (
            MODES,
            "[[limits.mode]]\nfrequency_hz = 143.2\nmax_frequency_error_percent = 0.1",
        ),
    ] {
        write_limits(folder.path(), limits);
        for threads in ["1", "3"] {
            let more = ["--threads", threads];
            match code(
                folder.path(),
                name,
                &read_json(&before(name)),
                "limits.toml",
                &more,
            ) {
                0 => count += 1,
                _ => failed.push(format!("{name} {limits}")),
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
    assert!(count >= 40, "{count}");
}
