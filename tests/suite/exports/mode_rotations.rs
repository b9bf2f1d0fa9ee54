//! Modes with translations and rotations, without a length that scales the rotations.

use num_complex::Complex64;

use super::mode_builder::{ModeDataset, mode_file, rows, three};
use super::universal_file::{OneFile, Ran};
use crate::command::modalign;

const CODE: &str = "rotations-left-out";

fn correlate(arguments: &[&str]) -> Ran {
    let output = modalign(["correlate"].iter().chain(arguments));
    Ran {
        code: output.status.code(),
        out: String::from_utf8(output.stdout).unwrap(),
        error: String::from_utf8(output.stderr).unwrap(),
    }
}

/// Three modes of six values at a node; the rotations are a tenth of other directions.
fn six_dof() -> String {
    let six = |mode: usize| {
        let with_rotations = |(node, mut values): (i64, Vec<Complex64>)| {
            let rotations: Vec<Complex64> = values.iter().rev().map(|value| value * 0.1).collect();
            values.extend(rotations);
            (node, values)
        };
        rows(mode, |_, _| true)
            .into_iter()
            .map(with_rotations)
            .collect()
    };
    mode_file(&three(|mode| ModeDataset::normal(mode, six(mode))))
}

/// The autoMAC of the first test.
fn matrix(ran: &Ran) -> serde_json::Value {
    ran.json()["tests"][0]["matrix"].clone()
}

#[test]
fn a_model_of_six_dofs_is_compared_with_itself_by_its_translations() {
    let six = OneFile::new("six.uff", six_dof());
    let three = three(|mode| ModeDataset::normal(mode, rows(mode, |_, _| true)));
    let three = OneFile::new("three.uff", mode_file(&three));
    let [six, three] = [six.path(), three.path()];
    let [six, three] = [six.to_str().unwrap(), three.to_str().unwrap()];
    let ran = correlate(&["--test", six, "--json"]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert!(
        ran.error.contains(CODE) && ran.error.contains("(15)"),
        "{ran:?}"
    );
    assert_eq!(
        matrix(&ran),
        matrix(&correlate(&["--test", three, "--json"]))
    );
    let scaled = correlate(&["--test", six, "--rotation-length", "0.5", "--json"]);
    assert!(!scaled.error.contains(CODE), "{scaled:?}");
    assert_eq!(matrix(&scaled)["dofs"]["most"], 30);
}

#[test]
fn rotations_of_a_table_are_left_out_and_rotations_alone_are_compared() {
    let table =
        |heads: &str| format!("frequency_hz,damping_ratio,{heads}\n20,,1,2,3\n55,,3,-2,1\n");
    let mixed = OneFile::new("m.csv", table("1:+Z,2:+Z,2:+RX"));
    let ran = correlate(&["--test", mixed.path().to_str().unwrap(), "--json"]);
    assert!(ran.error.contains(CODE), "{ran:?}");
    assert_eq!(matrix(&ran)["dofs"]["most"], 2);
    let alone = OneFile::new("m.csv", table("1:+RZ,2:+RZ,3:+RX"));
    let ran = correlate(&["--test", alone.path().to_str().unwrap(), "--json"]);
    assert!(!ran.error.contains(CODE), "{ran:?}");
    assert_eq!(matrix(&ran)["dofs"]["most"], 3);
}

#[test]
fn two_models_of_six_dofs_need_the_flag_by_its_name() {
    let six = OneFile::new("six.uff", six_dof());
    let six = six.path();
    let six = six.to_str().unwrap();
    let ran = correlate(&["--test", six, "--theory", six]);
    assert_eq!(ran.code, Some(2), "{ran:?}");
    assert!(ran.error.contains("--rotation-length"), "{ran:?}");
}
