//! Zeros that fill directions which were not measured, in files of mode shapes.

use std::path::Path;

use num_complex::Complex64;

use super::mode_builder::{
    FREQUENCIES_HZ, ModeDataset, NODES, Parameters, displacement, eigenvalue, mode_file, rows,
    three,
};
use super::universal_file::Ran;
use crate::command::{modalign, succeed, write};

const LEFT_OUT: &str = "unmeasured-left-out";
const KEPT: &str = "zero-in-model";

/// `correlate --test TEST --theory THEORY --json` of two files with these names and contents.
fn correlate(test: (&str, &str), theory: (&str, &str)) -> Ran {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[test, theory]);
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    ran(&["--test", &path(test.0), "--theory", &path(theory.0)])
}

fn ran(arguments: &[&str]) -> Ran {
    let output = modalign(
        ["correlate"]
            .iter()
            .chain(arguments)
            .chain(&["--json", "--full"]),
    );
    Ran {
        code: output.status.code(),
        out: String::from_utf8(output.stdout).unwrap(),
        error: String::from_utf8(output.stderr).unwrap(),
    }
}

fn macs(ran: &Ran) -> Vec<f64> {
    let json = ran.json();
    let rows = json["rows"].as_array().unwrap();
    let macs = rows.iter().map(|row| row["tests"][0]["mac"].as_f64());
    macs.collect::<Option<_>>()
        .unwrap_or_else(|| panic!("{ran:?}"))
}

/// Every MAC is 1, and `count` degrees of freedom were left out with a finding.
fn agrees_without(ran: &Ran, count: usize) {
    let macs = macs(ran);
    assert_eq!(macs.len(), 3, "{ran:?}");
    assert!(macs.iter().all(|mac| *mac > 1.0 - 1e-9), "{macs:?} {ran:?}");
    let finding = ran.error.lines().find(|line| line.contains(LEFT_OUT));
    let finding = finding.unwrap_or_else(|| panic!("{ran:?}"));
    assert!(finding.contains(&format!("({count})")), "{finding}");
}

fn says_nothing_of_zeros(ran: &Ran) {
    assert!(
        !ran.error.contains(LEFT_OUT) && !ran.error.contains(KEPT),
        "{ran:?}"
    );
}

/// A model that moves in every direction.
fn theory() -> String {
    let modes = three(|mode| {
        let mut normal = ModeDataset::normal(mode, rows(mode, |_, _| true));
        if let Parameters::Dataset55(reals) = &mut normal.parameters {
            reals[0] *= 1.02;
        }
        normal
    });
    mode_file(&modes)
}

#[test]
fn directions_filled_with_zeros_are_left_out_without_the_name_of_a_maker() {
    let test = three(|mode| ModeDataset::normal(mode, rows(mode, |_, axis| axis == 2)));
    let ran = correlate(("test.uff", &mode_file(&test)), ("theory.uff", &theory()));
    agrees_without(&ran, 10);
    assert_eq!(ran.code, Some(0), "{ran:?}");
}

#[test]
fn each_node_may_have_been_measured_in_another_direction() {
    let measured = |node: i64, axis: usize| node % 3 == axis as i64;
    let test = three(|mode| {
        let Complex64 { re, im } = eigenvalue(mode);
        ModeDataset::complex(mode, rows(mode, measured))
            .with_2414([0.0; 6], [re, im, 0.0, 0.0, 0.0, 0.0])
    });
    let ran = correlate(("test.uff", &mode_file(&test)), ("theory.uff", &theory()));
    agrees_without(&ran, 10);
}

/// The modes as a table with a 0 in each direction that was not measured.
fn table(is_measured: impl Fn(i64, usize) -> bool) -> String {
    let mut lines = vec!["frequency_hz,damping_ratio".to_owned()];
    for node in 1..=NODES {
        lines[0] += &format!(",{node}:+X,{node}:+Y,{node}:+Z");
    }
    for (mode, frequency) in FREQUENCIES_HZ.iter().enumerate() {
        let mut line = format!("{frequency},0.01");
        for node in 1..=NODES {
            for (axis, value) in displacement(mode, node).iter().enumerate() {
                line += &match is_measured(node, axis) {
                    true => format!(",{value:.5e}"),
                    false => ",0".to_owned(),
                };
            }
        }
        lines.push(line);
    }
    lines.join("\n") + "\n"
}

#[test]
fn zeros_of_a_table_and_of_what_it_is_converted_to_are_left_out() {
    let test = table(|_, axis| axis == 2);
    let theory = table(|_, _| true);
    agrees_without(&correlate(("test.csv", &test), ("theory.csv", &theory)), 10);
    let folder = tempfile::tempdir().unwrap();
    write(
        folder.path(),
        &[("test.csv", &test), ("theory.csv", &theory)],
    );
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    for name in [
        "modes.json",
        "modes.h5",
        "modes.npz",
        "modes.mat",
        "modes.uff",
    ] {
        succeed(["convert", &path("test.csv"), "-o", &path(name)]);
        let ran = ran(&["--test", &path(name), "--theory", &path("theory.csv")]);
        agrees_without(&ran, 10);
    }
}

#[test]
fn a_zero_in_one_mode_is_a_node_and_is_kept() {
    let with_node = |mode: usize| {
        let mut rows = rows(mode, |_, axis| axis == 2);
        if mode == 1 {
            rows[2].1[2] = Complex64::ZERO;
        }
        rows
    };
    let test = three(|mode| ModeDataset::normal(mode, with_node(mode)));
    let ran = correlate(("test.uff", &mode_file(&test)), ("theory.uff", &theory()));
    let macs = macs(&ran);
    assert!(macs[0] > 1.0 - 1e-9 && macs[2] > 1.0 - 1e-9, "{macs:?}");
    assert!(macs[1] < 1.0 - 1e-4, "the zero counts: {macs:?}");
    assert!(ran.error.contains(LEFT_OUT), "{ran:?}");
}

#[test]
fn a_clamped_model_is_not_brought_to_a_test_that_moves_there() {
    let clamped = three(|mode| ModeDataset::normal(mode, rows(mode, |node, _| node > 1)));
    let test = three(|mode| ModeDataset::normal(mode, rows(mode, |_, _| true)));
    let [clamped, test] = [mode_file(&clamped), mode_file(&test)];
    let ran = correlate(("test.uff", &test), ("theory.uff", &clamped));
    let macs = macs(&ran);
    assert!(macs.iter().any(|mac| *mac < 0.95), "{macs:?}");
    assert!(
        ran.error.contains(KEPT) && !ran.error.contains(LEFT_OUT),
        "{ran:?}"
    );
    // Both sides at rest there say nothing against each other.
    says_nothing_of_zeros(&correlate(("a.uff", &clamped), ("b.uff", &clamped)));
}

#[test]
fn zeros_of_a_computed_model_are_values_on_either_side() {
    // Modes that `theory` wrote are marked as computed: a clamp is no unmeasured sensor.
    let shape = |mode: usize, clamped: bool| {
        let value = |node: i64| match clamped && node == 1 {
            true => 0.0,
            false => displacement(mode, node)[2],
        };
        let values: Vec<String> = (1..=NODES)
            .map(|node| format!("\"{node}:+Z\": [{}, 0]", value(node)))
            .collect();
        let hz = FREQUENCIES_HZ[mode];
        let method = if clamped { "theory" } else { "circle" };
        format!(
            "{{\"frequency_hz\": {hz}, \"method\": \"{method}\", \"shape\": {{{}}}}}",
            values.join(", ")
        )
    };
    let file = |clamped: bool| {
        let modes: Vec<String> = (0..3).map(|mode| shape(mode, clamped)).collect();
        let modes = modes.join(", ");
        format!("{{\"schema\": \"modalign-modes/1\", \"modes\": [{modes}]}}")
    };
    let ran = correlate(("clamped.json", &file(true)), ("free.json", &file(false)));
    assert!(macs(&ran).iter().any(|mac| *mac < 0.95), "{ran:?}");
    assert!(!ran.error.contains(LEFT_OUT), "{ran:?}");
}

#[test]
fn one_mode_shows_an_unmeasured_direction_and_no_unmeasured_node() {
    let one = |is_measured: fn(i64, usize) -> bool| {
        mode_file(&[ModeDataset::normal(0, rows(0, is_measured))])
    };
    let theory = theory();
    let of_axis = correlate(
        ("test.uff", &one(|_, axis| axis == 2)),
        ("theory.uff", &theory),
    );
    let json = of_axis.json();
    let cell = &json["rows"][0]["tests"][0];
    assert!(cell["mac"].as_f64().unwrap() > 1.0 - 1e-9, "{of_axis:?}");
    assert!(of_axis.error.contains(LEFT_OUT));
    // A single zero of a direction that others were measured in may be a node of the mode.
    let of_node = correlate(
        ("test.uff", &one(|node, _| node != 2)),
        ("theory.uff", &theory),
    );
    let mac = of_node.json()["rows"][0]["tests"][0]["mac"].as_f64();
    assert!(mac.is_none_or(|mac| mac < 1.0 - 1e-4), "{of_node:?}");
    assert!(!of_node.error.contains(LEFT_OUT), "{of_node:?}");
}

#[test]
fn zeros_along_local_axes_are_left_out_where_these_are_a_turn_by_right_angles() {
    // Local x, y, z along global y, z, x, written with cosines of single precision.
    let systems = "    -1\n    18\n         5         0         0         8         1\nturned\n\
                   0. 0. 0. -4.37114e-08 1. 0.\n1. 0. -4.37114e-08\n    -1\n";
    let nodes: String = (1..=NODES)
        .map(|node| format!("{node:>10}         0         5         0 {node}. 0. 0.\n"))
        .collect();
    let nodes = format!("    -1\n    15\n{nodes}    -1\n");
    let turned = |mode: usize| {
        let global = rows(mode, |_, axis| axis == 2);
        let local = |values: Vec<Complex64>| vec![values[1], values[2], values[0]];
        global
            .into_iter()
            .map(|(node, values)| (node, local(values)))
            .collect()
    };
    let test = three(|mode| ModeDataset::normal(mode, turned(mode)));
    let test = mode_file(&test) + &nodes + systems;
    agrees_without(
        &correlate(("test.uff", &test), ("theory.uff", &theory())),
        10,
    );
}

#[test]
fn a_test_without_any_value_is_paired_by_frequency_with_a_finding() {
    let test = three(|mode| ModeDataset::normal(mode, rows(mode, |_, _| false)));
    let ran = correlate(("test.uff", &mode_file(&test)), ("theory.uff", &theory()));
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert!(ran.error.contains(LEFT_OUT), "{ran:?}");
    assert_eq!(ran.json()["rows"][0]["tests"][0]["basis"], "frequency");
}

#[test]
fn a_file_of_zeros_is_compared_with_itself_and_inspected_without_a_word_on_zeros() {
    let folder = tempfile::tempdir().unwrap();
    let test = three(|mode| ModeDataset::normal(mode, rows(mode, |_, axis| axis == 2)));
    write(folder.path(), &[("m.uff", &mode_file(&test))]);
    let path: &Path = &folder.path().join("m.uff");
    says_nothing_of_zeros(&ran(&["--test", path.to_str().unwrap()]));
}
