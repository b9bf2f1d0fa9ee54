//! `check` compares results with a baseline: changes by noise pass, wrong values fail in their row,
//! and the JUnit file follows its schema.

use std::path::Path;

use serde_json::Value;

use crate::command::{fail, json, modalign, root, succeed, write};

/// Results of the beam in a folder: the recording of this seed, after changes to its spec.
fn results(folder: &Path, seed: u64, change: impl Fn(&str) -> String) {
    std::fs::create_dir_all(folder).unwrap();
    let beam = root().join("measurements/free-free-beam");
    let text = |name: &str| std::fs::read_to_string(beam.join(name)).unwrap();
    // A quarter of the record.
    let spec = text("synth.toml").replace("samples = 32768", "samples = 8192");
    let spec = spec.replace("seed = 20260101", &format!("seed = {seed}"));
    assert!(spec.contains(&format!("seed = {seed}")));
    let scene = text("scene.toml");
    write(
        folder,
        &[
            ("synth.toml", &change(&spec)),
            ("model.toml", &text("model.toml")),
            ("scene.toml", &scene),
        ],
    );
    let folder = folder.to_str().unwrap();
    succeed(["run", folder, "-o", folder]);
}

const MODES: &str = "roving-hammer.modes.json";
const COMPARISON: &str = "comparison.json";

/// Rows that fail in `check`; its exit code must agree with them.
fn missed(now: &Path, before: &Path, more: &[&str]) -> Vec<String> {
    let (now, before) = (now.to_str().unwrap(), before.to_str().unwrap());
    let output = modalign(
        ["check", now, "--against", before, "--json"]
            .iter()
            .chain(more),
    );
    let result: Value = serde_json::from_slice(&output.stdout).unwrap();
    let rows = result["rows"].as_array().unwrap().iter();
    let missed: Vec<String> = rows
        .filter(|row| row["met"] == false)
        .map(|row| row["row"].as_str().unwrap().to_owned())
        .collect();
    assert_eq!(
        output.status.code(),
        Some(i32::from(!missed.is_empty())),
        "{result:#}"
    );
    missed
}

#[test]
fn another_recording_of_the_same_machine_passes_and_a_changed_machine_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    results(&at("before"), 1, str::to_owned);
    // One in a hundred is refused at most: one of these four in one of 25 such series.
    let mut refused = 0;
    for seed in 2..6 {
        let folder_of_seed = at(&format!("seed-{seed}"));
        results(&folder_of_seed, seed, str::to_owned);
        let rows = [MODES, COMPARISON]
            .map(|name| missed(&folder_of_seed.join(name), &at("before").join(name), &[]));
        refused += usize::from(rows.iter().any(|rows| !rows.is_empty()));
    }
    assert_eq!(refused, 0);
    // 0.4 % of the stiffness are 0.2 % of every frequency.
    results(&at("softer"), 5, |spec| {
        spec.replace("2.04e11", "2.03184e11")
    });
    for name in [MODES, COMPARISON] {
        let rows = missed(&at("softer").join(name), &at("before").join(name), &[]);
        assert_eq!(rows.len(), 6, "{name}: {rows:?}");
        let loose = [
            "--frequency-percent",
            "0.5",
            "--damping-percent",
            "20",
            "--mac",
            "0.05",
        ];
        assert!(missed(&at("softer").join(name), &at("before").join(name), &loose).is_empty());
    }
}

/// The modes of a file after a change to them.
fn changed(path: &Path, change: impl Fn(&mut Vec<Value>)) -> String {
    let mut file = json(path);
    change(file["modes"].as_array_mut().unwrap());
    file.to_string()
}

#[test]
fn wrong_modes_are_reported_in_their_row() {
    let folder = tempfile::tempdir().unwrap();
    results(&folder.path().join("before"), 1, str::to_owned);
    results(&folder.path().join("now"), 2, str::to_owned);
    let (before, now) = (
        folder.path().join("before").join(MODES),
        folder.path().join("now").join(MODES),
    );
    let rows_after = |change: &dyn Fn(&mut Vec<Value>)| {
        let path = folder.path().join("changed.json");
        std::fs::write(&path, changed(&now, change)).unwrap();
        missed(&path, &before, &[])
    };
    let starts = |rows: &[String], names: &[&str]| {
        rows.len() == names.len()
            && rows
                .iter()
                .zip(names)
                .all(|(row, name)| row.starts_with(name))
    };
    let shifted = rows_after(&|modes| {
        let hz = modes[1]["frequency_hz"].as_f64().unwrap();
        modes[1]["frequency_hz"] = (1.002 * hz).into();
        modes[1]["pole_rad_s"] = Value::Null;
    });
    assert!(starts(&shifted, &["mode 2 at"]), "{shifted:?}");
    let lost = rows_after(&|modes| drop(modes.remove(3)));
    assert!(starts(&lost, &["mode 4 at"]), "{lost:?}");
    let swapped = rows_after(&|modes| {
        for key in ["shape", "shape_std"] {
            let first = modes[0][key].take();
            modes[0][key] = std::mem::replace(&mut modes[1][key], first);
        }
    });
    assert!(starts(&swapped, &["mode 1 at", "mode 2 at"]), "{swapped:?}");
    let sign = rows_after(&|modes| {
        for part in modes[2]["shape"]["11:+Z"].as_array_mut().unwrap() {
            *part = (-part.as_f64().unwrap()).into();
        }
    });
    assert!(starts(&sign, &["mode 3 at"]), "{sign:?}");
}

/// Makes errors and summary of a comparison those of its rows, as a result that is wrong in its
/// values states them.
fn made_consistent(file: &mut Value) {
    let rows = file["rows"].as_array_mut().unwrap();
    for row in rows.iter_mut() {
        let theory = row["theory"]["hz"].as_f64();
        for cell in row["tests"].as_array_mut().into_iter().flatten() {
            let pair = theory.zip(cell["hz"].as_f64());
            cell["error_hz"] = pair.map(|(theory, hz)| hz - theory).into();
            cell["error_percent"] = pair
                .map(|(theory, hz)| 100.0 * (hz - theory) / theory)
                .into();
        }
    }
    let cells: Vec<Value> = rows
        .iter()
        .flat_map(|row| row["tests"].as_array().into_iter().flatten().cloned())
        .collect();
    let mut names: Vec<&str> = cells
        .iter()
        .map(|cell| cell["test"].as_str().unwrap())
        .collect();
    names.sort_unstable();
    names.dedup();
    let template = file["summary"]["tests"][0].clone();
    let summary = names.iter().map(|name| {
        let of_test = || cells.iter().filter(|cell| cell["test"] == **name);
        let count = |status: &str| of_test().filter(|cell| cell["status"] == status).count();
        let sizes = |key: &str| -> Vec<f64> {
            of_test()
                .filter_map(|cell| Some(cell[key].as_f64()?.abs()))
                .collect()
        };
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let largest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
        let (hz, percent) = (sizes("error_hz"), sizes("error_percent"));
        let squares: Vec<f64> = percent.iter().map(|error| error * error).collect();
        let mut test = template.clone();
        test["test"] = (*name).into();
        test["paired"] = count("paired").into();
        test["paired_by_shape"] = count("paired").into();
        test["missed"] = count("missed-unexpected").into();
        test["max_error_hz"] = largest(&hz).into();
        test["mean_error_hz"] = mean(&hz).into();
        test["max_error_percent"] = largest(&percent).into();
        test["mean_error_percent"] = mean(&percent).into();
        test["rms_error_percent"] = mean(&squares).sqrt().into();
        test["min_mac"] = sizes("mac").into_iter().reduce(f64::min).into();
        test
    });
    file["summary"]["tests"] = summary.collect();
}

#[test]
fn wrong_comparisons_are_reported_in_their_row() {
    let folder = tempfile::tempdir().unwrap();
    results(folder.path(), 1, str::to_owned);
    let before = folder.path().join(COMPARISON);
    let rows_after = |change: &dyn Fn(&mut Vec<Value>)| {
        let mut file = json(&before);
        change(file["rows"].as_array_mut().unwrap());
        made_consistent(&mut file);
        let path = folder.path().join("changed.json");
        std::fs::write(&path, file.to_string()).unwrap();
        missed(&path, &before, &[])
    };
    assert!(rows_after(&|_| ()).is_empty());
    let lost = rows_after(&|rows| {
        for key in ["hz", "damping_ratio", "mac"] {
            rows[2]["tests"][0][key] = Value::Null;
        }
        rows[2]["tests"][0]["status"] = "missed-unexpected".into();
    });
    assert_eq!(lost, ["f3 roving hammer"]);
    let swapped = rows_after(&|rows| {
        let first = rows[0]["tests"].take();
        rows[0]["tests"] = std::mem::replace(&mut rows[1]["tests"], first);
    });
    assert_eq!(swapped, ["f1 roving hammer", "f2 roving hammer"]);
    let sign = rows_after(&|rows| {
        let mac = rows[4]["tests"][0]["mac"].as_f64().unwrap();
        // One of eleven equal components of the other sign.
        rows[4]["tests"][0]["mac"] = (mac * (9.0_f64 / 11.0).powi(2)).into();
    });
    assert_eq!(sign, ["f5 roving hammer"]);
    let theory = rows_after(&|rows| {
        let hz = rows[0]["theory"]["hz"].as_f64().unwrap();
        rows[0]["theory"]["hz"] = (hz * 1.0001).into();
    });
    assert_eq!(theory, ["f1 theory"]);
    let extra = rows_after(&|rows| {
        let mut row = rows[5].clone();
        row["label"] = "x1".into();
        rows.push(row);
    });
    assert_eq!(extra, ["x1"]);
    let second = rows_after(&|rows| {
        let mut field = rows[1]["tests"][0].clone();
        field["test"] = "shaker".into();
        rows[1]["tests"].as_array_mut().unwrap().push(field);
    });
    assert_eq!(second, ["f2 shaker"], "a test that the baseline has not");
}

#[test]
fn an_update_keeps_its_parameters_within_their_deviations() {
    let folder = tempfile::tempdir().unwrap();
    results(folder.path(), 1, str::to_owned);
    let (run, updated) = (folder.path(), folder.path().join("updated"));
    succeed([
        "update",
        run.to_str().unwrap(),
        "-o",
        updated.to_str().unwrap(),
    ]);
    let before = updated.join("update.json");
    let rows_after = |change: &dyn Fn(&mut Value)| {
        let mut file = json(&before);
        change(&mut file["parameters"][0]);
        let path = folder.path().join("changed.json");
        std::fs::write(&path, file.to_string()).unwrap();
        missed(&path, &before, &[])
    };
    let moved = |deviations: f64| {
        rows_after(&move |parameter| {
            let std = parameter["std"].as_f64().unwrap();
            parameter["updated"] =
                (parameter["updated"].as_f64().unwrap() + deviations * std).into();
        })
    };
    assert!(moved(0.0).is_empty() && moved(1.0).is_empty());
    // The deviation of a difference is 1.41 of one; 0.01 of two parameters is 2.81 of that.
    assert_eq!(moved(6.0), ["parameter youngs_modulus"]);
    let verdict =
        rows_after(&|parameter| parameter["verdict"] = "not supported by the data".into());
    assert_eq!(verdict, ["parameter youngs_modulus"]);
    // Values that the deviation would excuse.
    let uncertain = rows_after(&|parameter| {
        parameter["updated"] = (1.05 * parameter["updated"].as_f64().unwrap()).into();
        parameter["std"] = 1e12.into();
    });
    assert_eq!(uncertain, ["parameter youngs_modulus"]);
    let changed = folder.path().join("changed.json");
    for std in [0.0, -1.0] {
        let mut file = json(&before);
        file["parameters"][0]["std"] = std.into();
        std::fs::write(&changed, file.to_string()).unwrap();
        let paths = [&changed, &before].map(|path| path.to_str().unwrap());
        let error = fail(["check", paths[0], "--against", paths[1]]);
        assert!(error.contains("\"youngs_modulus\" std: got"), "{error}");
    }
    let fit_after = |key: &str, change: &dyn Fn(&Value) -> Value| {
        let mut file = json(&before);
        file[key] = change(&file[key]);
        let product = ["reduced_chi_square", "degrees_of_freedom"]
            .iter()
            .map(|key| file[*key].as_f64().unwrap())
            .product::<f64>();
        file["after"]["chi_square"] = product.into();
        std::fs::write(&changed, file.to_string()).unwrap();
        missed(&changed, &before, &[])
    };
    let times = |factor: f64| move |value: &Value| (factor * value.as_f64().unwrap()).into();
    assert!(fit_after("reduced_chi_square", &times(1.1)).is_empty());
    for (key, change) in [
        (
            "stop_reason",
            &(|_: &Value| "diverged".into()) as &dyn Fn(&Value) -> Value,
        ),
        ("stop_reason", &|_| "iteration-limit".into()),
        ("fits", &|fits| (!fits.as_bool().unwrap()).into()),
        ("reduced_chi_square", &|_| 1e6.into()),
        ("reduced_chi_square", &times(5.0)),
        ("reduced_chi_square", &|_| 0.into()),
        ("degrees_of_freedom", &times(0.9)),
        ("after", &|after| {
            let mut after = after.clone();
            after["paired"] = 5.into();
            after
        }),
    ] {
        assert_eq!(fit_after(key, change), ["fit"], "{key}");
    }
    let modes = folder.path().join(MODES);
    let paths = [&before, &modes].map(|path| path.to_str().unwrap());
    let error = fail(["check", paths[0], "--against", paths[1]]);
    assert!(error.contains("two results of the same kind"), "{error}");
}

#[test]
fn wrong_values_are_not_excused_by_their_deviations() {
    let folder = tempfile::tempdir().unwrap();
    results(folder.path(), 1, str::to_owned);
    let changed_rows = |name: &str, list: &str, change: &dyn Fn(&mut Value)| {
        let before = folder.path().join(name);
        let mut file = json(&before);
        change(&mut file[list]);
        if list == "rows" {
            made_consistent(&mut file);
        }
        let path = folder.path().join("changed.json");
        std::fs::write(&path, file.to_string()).unwrap();
        missed(&path, &before, &[])
    };
    let modes = |change: &dyn Fn(&mut Value)| {
        let rows = changed_rows(MODES, "modes", &|modes| change(&mut modes[1]));
        assert!(
            rows.len() == 1 && rows[0].starts_with("mode 2 at"),
            "{rows:?}"
        );
    };
    modes(&|mode| {
        mode["frequency_hz"] = (1.01 * mode["frequency_hz"].as_f64().unwrap()).into();
        mode["pole_rad_s"] = Value::Null;
        mode["frequency_std_hz"] = 1e12.into();
    });
    modes(&|mode| {
        mode["damping_ratio"] = (2.0 * mode["damping_ratio"].as_f64().unwrap()).into();
        mode["pole_rad_s"] = Value::Null;
        mode["damping_std"] = 1e3.into();
    });
    for key in ["frequency_std_hz", "damping_std"] {
        modes(&|mode| mode[key] = Value::Null);
    }
    let cells = |change: &dyn Fn(&mut Value)| {
        let rows = changed_rows(COMPARISON, "rows", &|rows| change(&mut rows[2]["tests"][0]));
        assert_eq!(rows, ["f3 roving hammer"]);
    };
    cells(&|cell| {
        cell["hz"] = (1.1 * cell["hz"].as_f64().unwrap()).into();
        cell["normalised_error"] = 1e-12.into();
    });
    cells(&|cell| {
        cell["damping_ratio"] = (2.0 * cell["damping_ratio"].as_f64().unwrap()).into();
        cell["damping_std"] = 1e3.into();
    });
    for key in ["hz_std", "damping_std"] {
        cells(&|cell| cell[key] = Value::Null);
        cells(&|cell| cell[key] = 1e3.into());
    }
    for (name, list, path) in [
        (MODES, "modes", "/1/frequency_std_hz"),
        (MODES, "modes", "/1/damping_std"),
        (COMPARISON, "rows", "/2/tests/0/hz_std"),
        (COMPARISON, "rows", "/2/tests/0/damping_std"),
    ] {
        let before = folder.path().join(name);
        let mut file = json(&before);
        *file[list].pointer_mut(path).unwrap() = (-1.0).into();
        let changed = folder.path().join("changed.json");
        std::fs::write(&changed, file.to_string()).unwrap();
        let error = fail([
            "check",
            changed.to_str().unwrap(),
            "--against",
            before.to_str().unwrap(),
        ]);
        let key = path
            .split('/')
            .find(|part| part.ends_with("_hz") || part.ends_with("_std"));
        assert!(
            error.contains(key.unwrap()) && error.contains("-1"),
            "{error}"
        );
    }
}

#[test]
fn a_summary_that_contradicts_its_rows_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    results(folder.path(), 1, str::to_owned);
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let refused = |change: &dyn Fn(&mut Value), part: &str| {
        let mut file = json(&folder.path().join(COMPARISON));
        change(&mut file);
        write(folder.path(), &[("changed.json", &file.to_string())]);
        let error = fail([
            "check",
            &path("changed.json"),
            "--against",
            &path("scene.toml"),
        ]);
        assert!(
            error.contains("changed.json: ") && error.contains(part),
            "{error}"
        );
    };
    let summary = "summary test \"roving hammer\"";
    refused(&|file| file["rows"] = serde_json::json!([]), summary);
    refused(
        &|file| drop(file["rows"].as_array_mut().unwrap().remove(2)),
        summary,
    );
    let cell = |key: &'static str, value: Value| {
        move |file: &mut Value| file["rows"][2]["tests"][0][key] = value.clone()
    };
    refused(&cell("mac", 0.1.into()), "min_mac");
    refused(
        &cell("error_percent", 10.0.into()),
        "rows \"f3\" test \"roving hammer\" error_percent",
    );
    refused(&cell("hz", 10.0.into()), "_percent");
    refused(&cell("error_percent", Value::Null), "error_percent");
    refused(&cell("status", "missed-unexpected".into()), summary);
    refused(&cell("status", "ambiguous".into()), summary);
    refused(&cell("test", "other".into()), "other");
    refused(
        &|file| file["summary"]["tests"][0]["missed"] = 1.into(),
        "missed: 1",
    );
    refused(
        &|file| file["summary"]["tests"] = serde_json::json!([]),
        "no test",
    );
    refused(
        &|file| {
            let row = file["rows"][0].clone();
            file["rows"].as_array_mut().unwrap().push(row);
        },
        "\"f1\" twice",
    );
}

#[test]
fn numbers_of_a_baseline_are_compared_or_listed() {
    let folder = tempfile::tempdir().unwrap();
    results(folder.path(), 1, str::to_owned);
    let listed = |name: &str| -> Vec<String> {
        let path = folder.path().join(name);
        let path = path.to_str().unwrap();
        let check = ["check", path, "--against", path];
        let result: Value =
            serde_json::from_str(&succeed(check.iter().chain(&["--json"]))).unwrap();
        let keys: Vec<String> = serde_json::from_value(result["not_compared"].clone()).unwrap();
        let text = succeed(check.iter().chain(&["--full"]));
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains(&keys.join(", ")), "{text}");
        keys
    };
    let modes = listed(MODES);
    for (key, is_listed) in [
        ("modes.residues", false),
        ("modes.modal_mass_kg", false),
        ("modes.mpc", true),
        ("modes.frequency_hz", false),
        ("modes.shape_std", false),
    ] {
        assert_eq!(
            modes.iter().any(|name| name == key),
            is_listed,
            "{key}: {modes:?}"
        );
    }
    let comparison = listed(COMPARISON);
    assert!(comparison.contains(&"summary".to_owned()), "{comparison:?}");
    assert!(
        comparison.contains(&"rows.theory.modes".to_owned()),
        "{comparison:?}"
    );
}

/// An element of an XML text.
struct Element {
    depth: usize,
    name: String,
    attributes: Vec<(String, String)>,
}

/// The elements of a well-formed XML text in their order.
fn elements(text: &str) -> Vec<Element> {
    let (mut found, mut open): (Vec<_>, Vec<String>) = (Vec::new(), Vec::new());
    let mut rest = text
        .strip_prefix("<?xml version=\"1.0\" encoding=\"UTF-8\"?>")
        .unwrap();
    while let Some(at) = rest.find('<') {
        assert!(!rest[..at].contains('>'), "{rest}");
        let (tag, after) = rest[at + 1..].split_once('>').unwrap();
        rest = after;
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(
                open.pop().as_deref(),
                Some(name),
                "every element is closed in its order"
            );
            continue;
        }
        let (body, closed) = tag
            .strip_suffix('/')
            .map_or((tag, false), |body| (body, true));
        let (name, mut list) = body.split_once(' ').unwrap_or((body, ""));
        let mut attributes = Vec::new();
        while let Some((key, value)) = list.trim_start().split_once("=\"") {
            let (value, after) = value.split_once('"').unwrap();
            attributes.push((key.to_owned(), value.to_owned()));
            list = after;
        }
        found.push(Element {
            depth: open.len(),
            name: name.to_owned(),
            attributes,
        });
        if !closed {
            open.push(name.to_owned());
        }
    }
    assert!(open.is_empty() && rest.trim().is_empty());
    found
}

/// Requirements of the schema of Ant's JUnit reports (JUnit.xsd): elements in their order,
/// attributes that must be there, and counts. `tests/reference/junit_schema.sh` holds a file
/// against the schema itself.
fn assert_junit(text: &str) -> (usize, usize) {
    let all = elements(text);
    let shape: Vec<(usize, &str)> = all
        .iter()
        .map(|element| (element.depth, element.name.as_str()))
        .collect();
    assert_eq!(
        shape[..4],
        [
            (0, "testsuites"),
            (1, "testsuite"),
            (2, "properties"),
            (3, "property")
        ]
    );
    assert_eq!(
        shape[shape.len() - 2..],
        [(2, "system-out"), (2, "system-err")]
    );
    let value = |index: usize, key: &str| {
        let Element {
            name, attributes, ..
        } = &all[index];
        let found = attributes.iter().find(|(name, _)| name == key);
        found
            .unwrap_or_else(|| panic!("{name} has no {key}"))
            .1
            .clone()
    };
    let (mut cases, mut failures) = (0, 0);
    for (index, element) in shape.iter().enumerate().take(all.len() - 2).skip(4) {
        match element {
            (2, "testcase") => {
                cases += 1;
                for key in ["name", "classname"] {
                    let text = value(index, key);
                    assert!(
                        !text.is_empty()
                            && text == text.split_whitespace().collect::<Vec<_>>().join(" "),
                        "xs:token"
                    );
                }
                value(index, "time").parse::<f64>().unwrap();
            }
            (3, "failure") => {
                failures += 1;
                assert!(!value(index, "type").is_empty() && !value(index, "message").is_empty());
            }
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(value(1, "tests"), cases.to_string());
    assert_eq!(value(1, "failures"), failures.to_string());
    assert_eq!(
        (value(1, "errors"), value(1, "id")),
        ("0".to_owned(), "0".to_owned())
    );
    value(1, "time").parse::<f64>().unwrap();
    for key in ["name", "hostname", "package"] {
        assert!(!value(1, key).is_empty());
    }
    let shape: String = value(1, "timestamp")
        .chars()
        .map(|c| if c.is_ascii_digit() { '0' } else { c })
        .collect();
    assert_eq!(shape, "0000-00-00T00:00:00");
    (cases, failures)
}

#[test]
fn the_junit_file_follows_its_schema_with_a_case_for_each_row() {
    let folder = tempfile::tempdir().unwrap();
    results(folder.path(), 1, str::to_owned);
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let file = changed(&folder.path().join(MODES), |modes| drop(modes.remove(0)));
    write(
        folder.path(),
        &[
            ("changed <&\"> x.json", &file),
            (
                "limits.toml",
                "[limits]\nmin_mac = 0.9\nmax_extra = 0\nmax_missed = 0\n",
            ),
        ],
    );
    let junit = path("check.xml");
    let report = |arguments: &[&str]| {
        modalign(
            ["check"]
                .iter()
                .chain(arguments)
                .chain(&["--junit", &junit]),
        );
        assert_junit(&std::fs::read_to_string(&junit).unwrap())
    };
    assert_eq!(report(&[&path(MODES), "--against", &path(MODES)]), (6, 0));
    assert_eq!(
        report(&[&path("changed <&\"> x.json"), "--against", &path(MODES)]),
        (6, 1)
    );
    assert_eq!(
        report(&[&path(COMPARISON), "--against", &path("limits.toml")]),
        (1, 0)
    );
}

#[test]
fn limits_that_cannot_be_meant_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    succeed([
        "theory",
        "measurements/free-free-beam",
        "-o",
        &path("modes.json"),
    ]);
    for (option, value) in [
        ("--false-refusals", "1"),
        ("--false-refusals", "0"),
        ("--mac", "0"),
        ("--frequency-percent", "x"),
    ] {
        let error = fail([
            "check",
            &path("modes.json"),
            "--against",
            &path("modes.json"),
            option,
            value,
        ]);
        assert!(error.contains(option) && error.contains(value), "{error}");
    }
}

#[test]
fn the_folder_of_results_is_answered_with_a_command_that_checks_them() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out").to_str().unwrap().to_owned();
    succeed(["run", "measurements/free-free-beam", "-o", &out]);
    let error = fail(["check", &out]);
    let command = error
        .split_once("`modalign ")
        .and_then(|(_, rest)| rest.split_once('`'))
        .map(|(command, _)| command)
        .unwrap_or_else(|| panic!("{error}"));
    assert!(
        command.ends_with("--against measurements/free-free-beam"),
        "{error}"
    );
    succeed(command.split(' '));
}
