//! Modes in universal files: inspected, compared, and tied to a model whose points have other
//! names.

use std::path::Path;

use crate::command::{fail, json, root, shared_data, succeed, write};

const LMS: &str = "lms-testlab-modes/OOP_inb_new_attach_0_30Hz_no euler.unv";

fn close(got: &serde_json::Value, expected: &serde_json::Value, relative: f64) -> bool {
    let (got, expected) = (got.as_f64().unwrap(), expected.as_f64().unwrap());
    (got - expected).abs() <= relative * expected.abs()
}

#[test]
fn the_modes_of_a_commercial_system_have_their_natural_frequencies() {
    let Some(data) = shared_data() else { return };
    let expected = json(&data.join("expected.json"))[LMS].clone();
    let text = succeed(["inspect", data.join(LMS).to_str().unwrap(), "--json"]);
    let inspected: serde_json::Value = serde_json::from_str(&text).unwrap();
    let file = &inspected["files"][0];
    let modes = file["modes"].as_array().unwrap();
    assert_eq!(modes.len() as u64, expected["n_modes"].as_u64().unwrap());
    for (number, mode) in modes.iter().enumerate() {
        let pole = &expected["eigenvalue"][number];
        assert!(
            close(
                &mode["frequency_hz"],
                &expected["undamped_hz"][number],
                5e-6
            ),
            "{mode}"
        );
        for part in 0..2 {
            assert!(
                close(&mode["pole_rad_s"][part], &pole[part], 1e-5),
                "{mode}"
            );
        }
        let header = expected["header_damping"][number].as_f64().unwrap();
        let damping = mode["damping_ratio"].as_f64().unwrap();
        assert!((damping - header).abs() < 6e-7, "{damping} {header}");
    }
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("modes.json");
    succeed([
        "convert",
        data.join(LMS).to_str().unwrap(),
        "-o",
        out.to_str().unwrap(),
    ]);
    let written = json(&out);
    assert_eq!(written["schema"], "modalign-modes/1");
    for (node, values) in expected["mode1_first_node_in_file"].as_object().unwrap() {
        for (axis, value) in ["X", "Y", "Z"].iter().zip(values.as_array().unwrap()) {
            let got = &written["modes"][0]["shape"][format!("{node}:+{axis}")];
            let missing = got.is_null() && value[0] == 0.0 && value[1] == 0.0;
            assert!(missing || got == value, "{node} {axis}: {got} {value}");
        }
    }
    let there = data.join(LMS);
    let there = there.to_str().unwrap();
    let table = succeed([
        "correlate",
        "--test",
        there,
        "--theory",
        out.to_str().unwrap(),
        "--json",
    ]);
    let table: serde_json::Value = serde_json::from_str(&table).unwrap();
    let rows = table["rows"].as_array().unwrap();
    assert_eq!(rows.len(), modes.len());
    for row in rows {
        let mac = row["tests"][0]["mac"].as_f64().unwrap();
        assert!((mac - 1.0).abs() < 1e-9, "{row}");
    }
}

/// Two modes at three points as a universal file with nodes, its labels counted from `first`.
fn universal(first: i64, sign: f64) -> String {
    let nodes: Vec<(i64, [f64; 3])> = (0..3)
        .map(|k| (first + k, [0.1 * k as f64, 0.0, 0.0]))
        .collect();
    let modes = [(50.0, [1.0, 2.0, 3.0]), (90.0, [1.0, -1.0, 0.5])];
    let modes = modes.map(|(hz, shape)| (hz, shape.map(|v| [0.0, 0.0, sign * v]).to_vec()));
    universal_file(&nodes, &modes)
}

/// Nodes (label, position) and real modes (Hz, displacements at the nodes in their order) as a
/// universal file.
pub fn universal_file(nodes: &[(i64, [f64; 3])], modes: &[(f64, Vec<[f64; 3]>)]) -> String {
    let mut text = String::from("    -1\n   164\n         1SI                          2\n");
    text += "  1.00000000000000000D+00  1.00000000000000000D+00  1.00000000000000000D+00\n";
    text += "  0.00000000000000000D+00\n    -1\n    -1\n  2411\n";
    for (label, [x, y, z]) in nodes {
        text += &format!("{label:>10}         0         0         0\n");
        text += &format!("{x:25.16E}{y:25.16E}{z:25.16E}\n");
    }
    text += "    -1\n";
    for (number, (hz, shape)) in modes.iter().enumerate() {
        text += "    -1\n    55\nNONE\nNONE\nNONE\nNONE\nNONE\n";
        text += "         1         2         2         8         2         3\n";
        text += &format!("         2         4         1{:>10}\n", number + 1);
        text += &format!("{hz:13.5E}{:13.5E}{:13.5E}{:13.5E}\n", 1.0, 0.01, 0.0);
        for ((label, _), [x, y, z]) in nodes.iter().zip(shape) {
            text += &format!("{label:>10}\n");
            text += &format!("{x:13.5E}{y:13.5E}{z:13.5E}\n");
        }
        text += "    -1\n";
    }
    text
}

fn macs(arguments: &[&str]) -> Vec<f64> {
    let table = succeed([arguments, &["--json"]].concat());
    let table: serde_json::Value = serde_json::from_str(&table).unwrap();
    let rows = table["rows"].as_array().unwrap();
    rows.iter()
        .map(|row| row["tests"][0]["mac"].as_f64().unwrap())
        .collect()
}

fn both(folder: &Path) -> [String; 2] {
    let files = [
        ("test.unv", universal(1, 1.0)),
        ("theory.uff", universal(101, -1.0)),
    ];
    write(
        folder,
        &files.each_ref().map(|(name, text)| (*name, text.as_str())),
    );
    files.map(|(name, _)| folder.join(name).to_str().unwrap().to_owned())
}

#[test]
fn points_of_other_names_meet_by_nearest_node_or_by_a_list() {
    let folder = tempfile::tempdir().unwrap();
    let [test, theory] = both(folder.path());
    let files = ["correlate", "--test", &test, "--theory", &theory];
    let nearest = macs(&[&files[..], &["--nearest-node", "0.01"]].concat());
    assert_eq!(nearest.len(), 2);
    assert!(
        nearest.iter().all(|mac| (mac - 1.0).abs() < 1e-9),
        "{nearest:?}"
    );
    let list = folder.path().join("map.csv");
    std::fs::write(
        &list,
        "test,theory\n1:+Z,101:+Z\n2:+Z,102:+Z\n3:+Z,103:-Z\n",
    )
    .unwrap();
    let by_list = ["--dof-map", list.to_str().unwrap(), "--min-mac", "0"];
    let listed = macs(&[&files[..], &by_list].concat());
    // The third sensor is said to point the other way: (1 + 4 - 9)^2/14^2 and (1 + 1 -
    // 0.25)^2/2.25^2.
    assert_eq!(listed.len(), 2);
    for (mac, expected) in listed.iter().zip([16.0 / 196.0, 3.0625 / 5.0625]) {
        assert!((mac - expected).abs() < 1e-9, "{mac} {expected}");
    }
    let said = fail(files);
    assert!(
        said.contains("--dof-map") && said.contains("101:"),
        "{said}"
    );
}

#[test]
fn a_list_that_is_none_and_points_without_a_place_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let [test, theory] = both(folder.path());
    let list = folder.path().join("map.csv");
    std::fs::write(&list, "test,theory\n1:+Z;101:+Z\n").unwrap();
    let files = ["correlate", "--test", &test, "--theory", &theory];
    let said = fail([&files[..], &["--dof-map", list.to_str().unwrap()]].concat());
    assert!(
        said.contains("map.csv") && said.contains("line 2"),
        "{said}"
    );
    let modes = folder.path().join("modes.json");
    succeed(["convert", &test, "-o", modes.to_str().unwrap()]);
    let without = [
        "correlate",
        "--test",
        modes.to_str().unwrap(),
        "--theory",
        &theory,
    ];
    let said = fail([&without[..], &["--nearest-node", "0.01"]].concat());
    assert!(
        said.contains("--nearest-node") && said.contains("modes.json"),
        "{said}"
    );
}

#[test]
fn a_recorded_function_is_no_mode() {
    let file = root().join("tests/reference/exchange.uff");
    let said = fail([
        "correlate",
        "--test",
        "no-such.unv",
        "--theory",
        file.to_str().unwrap(),
    ]);
    assert!(said.contains("no-such.unv"), "{said}");
}

/// Two modes at two nodes as datasets 2414.
fn dataset_2414() -> String {
    let mut text = String::from("    -1\n   164\n         1SI                          2\n");
    text += "  1.00000000000000000D+00  1.00000000000000000D+00  1.00000000000000000D+00\n";
    text += "  0.00000000000000000D+00\n    -1\n";
    for (number, hz, values) in [(1, 50.0, [1.0, 0.5]), (2, 90.0, [1.0, -2.0])] {
        text += &format!("    -1\n  2414\n{number:>10}\nshaker\n         1\n");
        text += &"NONE\n".repeat(5);
        text += "         1         2         2         8         2         3\n";
        text += &format!(
            "{:>10}{:>10}{:>10}{:>10}{:>10}{number:>10}{:>10}{:>10}\n",
            0, 0, 0, 0, 0, 0, 0
        );
        text += &format!("{:>10}{:>10}\n", 0, 0);
        text += &format!(
            "{:13.5E}{hz:13.5E}{:13.5E}{:13.5E}{:13.5E}{:13.5E}\n",
            0.0, 0.0, 1.0, 0.01, 0.0
        );
        text += &format!("{:13.5E}\n", 0.0);
        for (node, value) in (1..).zip(values) {
            text += &format!("{node:>10}\n{:13.5E}{:13.5E}{value:13.5E}\n", 0.0, 0.0);
        }
        text += "    -1\n";
    }
    text
}

#[test]
fn modes_alone_are_a_theory_from_datasets_2414_and_from_a_table() {
    let folder = tempfile::tempdir().unwrap();
    let table = "frequency_hz;damping_ratio;1:+Z;2:+Z\n51;0.02;-2;-1\n88;;0.5;-1\n";
    let unv = dataset_2414();
    write(folder.path(), &[("model.unv", &unv), ("test.csv", table)]);
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (model, test) = (path("model.unv"), path("test.csv"));
    for (file, expected) in [
        (&model, ["50.000 ", "90.000 ", "1.0000"]),
        (&test, ["51.000 ", "88.000 ", "2.0000"]),
    ] {
        let text = succeed(["theory", file.as_str()]);
        for part in expected {
            assert!(text.contains(part), "{part}:\n{text}");
        }
    }
    // The same shapes in other scales.
    for files in [[&test, &model], [&model, &test]] {
        let macs = macs(&["correlate", "--test", files[0], "--theory", files[1]]);
        assert_eq!(macs.len(), 2);
        assert!(macs.iter().all(|mac| (mac - 1.0).abs() < 1e-12), "{macs:?}");
    }
    // To a universal file and back nothing changes but how a number is printed.
    let (there, back) = (path("there.unv"), path("back.csv"));
    succeed(["convert", &test, "-o", &there]);
    succeed(["convert", &there, "-o", &back]);
    let again = std::fs::read_to_string(&back).unwrap();
    let rows: Vec<Vec<&str>> = again
        .lines()
        .map(|line| line.split(',').collect())
        .collect();
    let column = |name: &str| rows[0].iter().position(|heading| *heading == name).unwrap();
    let number = |row: usize, name: &str| rows[row][column(name)].parse::<f64>().unwrap();
    for (row, hz, shape) in [(1, 51.0, [-2.0, -1.0]), (2, 88.0, [0.5, -1.0])] {
        assert!(
            (number(row, "frequency_hz") / hz - 1.0).abs() < 1e-12,
            "{again}"
        );
        for (name, value) in ["1:+Z", "2:+Z"].into_iter().zip(shape) {
            assert!((number(row, name) - value).abs() < 1e-5, "{again}");
        }
    }
    assert!((number(1, "damping_ratio") - 0.02).abs() < 1e-6, "{again}");
}
