//! `convert`: every format brings the numbers back, other programs read them, and the good part of
//! a bad file is delivered.

use std::path::{Path, PathBuf};

use modalign::io::sha256_hex;

use crate::command::{fail, modalign, root, succeed};

/// A universal file as text with time records, an uneven one, FRFs, coherence, nodes, a trace line
/// and modes; made from formulas by the script beside it.
fn source() -> PathBuf {
    root().join("tests/reference/exchange.uff")
}

fn convert(input: &Path, output: &Path, flags: &[&str]) {
    let (input, output) = (input.to_str().unwrap(), output.to_str().unwrap());
    let arguments = ["convert", input, "-o", output];
    succeed(arguments.iter().chain(flags));
}

#[test]
fn a_detour_through_any_format_that_holds_everything_changes_no_byte() {
    let folder = tempfile::tempdir().unwrap();
    let direct = folder.path().join("direct.uff");
    convert(&source(), &direct, &[]);
    let expected = std::fs::read(&direct).unwrap();
    for (name, flags) in [
        ("over.uff", [].as_slice()),
        ("over.text.unv", ["--text"].as_slice()),
        ("over.h5", &[]),
        ("over.mat", &[]),
        ("over.npz", &[]),
    ] {
        let (over, back) = (folder.path().join(name), folder.path().join("back.uff"));
        convert(&source(), &over, flags);
        convert(&over, &back, &[]);
        let got = std::fs::read(&back).unwrap();
        let first = got.iter().zip(&expected).position(|(a, b)| a != b);
        assert!(
            got == expected,
            "{name}: {} and {} bytes, first difference at {first:?}",
            got.len(),
            expected.len()
        );
    }
}

/// The files of `exchange.txt` with the flags that make them.
const PROVEN: [(&str, &[&str]); 6] = [
    ("exchange.binary.uff", &[]),
    ("exchange.text.uff", &["--text"]),
    ("exchange.h5", &[]),
    ("exchange.mat", &[]),
    ("exchange.npz", &[]),
    ("exchange.csv", &[]),
];

#[test]
fn files_are_written_byte_for_byte_as_other_programs_have_read_them() {
    let stored = std::fs::read_to_string(root().join("tests/reference/exchange.txt")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for (name, flags) in PROVEN {
        let path = folder.path().join(name);
        let arguments = [
            "convert",
            "tests/reference/exchange.uff",
            "-o",
            path.to_str().unwrap(),
        ];
        succeed(arguments.iter().chain(flags));
        let line = stored
            .lines()
            .find(|line| line.contains(&format!(" {name} ")));
        let line = line.unwrap_or_else(|| panic!("{name} is not in exchange.txt"));
        let fingerprint = sha256_hex(&path).unwrap();
        assert!(
            line.starts_with(&fingerprint) && line.contains(": equal: "),
            "{name}: got {fingerprint}; if the writer was changed on purpose, run tests/reference/exchange.py again"
        );
    }
}

#[test]
fn losses_of_an_output_format_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.csv");
    let input = source();
    let output = modalign([
        "convert",
        input.to_str().unwrap(),
        "-o",
        path.to_str().unwrap(),
    ]);
    assert_eq!(output.status.code(), Some(0));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("[not-carried]"), "{said}");
}

#[test]
fn the_good_part_of_a_bad_file_is_delivered_with_exit_code_1() {
    let folder = tempfile::tempdir().unwrap();
    let (bad, good) = (
        folder.path().join("bad.uff"),
        folder.path().join("good.uff"),
    );
    let text = std::fs::read_to_string(source()).unwrap();
    // One number of the first record is none any more.
    let at = text.find("-1.56250E+00").unwrap();
    std::fs::write(&bad, text.replacen("-1.56250E+00", "-1.56x50E+00", 1)).unwrap();
    let line = text[..at].lines().count();
    let arguments = [
        "convert",
        "--partial",
        bad.to_str().unwrap(),
        "-o",
        good.to_str().unwrap(),
    ];
    let output = modalign(arguments);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("1 bad parts left out"), "{said}");
    let inspected = succeed(["inspect", good.to_str().unwrap(), "--json"]);
    let inspected: serde_json::Value = serde_json::from_str(&inspected).unwrap();
    assert_eq!(
        inspected["files"][0]["entries"].as_array().unwrap().len(),
        5
    );
    let json = modalign(arguments.iter().chain(&["--json"]));
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    let damage = json["damage"][0].as_str().unwrap();
    assert!(damage.contains(&format!("bad.uff:{line}:")), "{damage}");
}

#[test]
fn an_output_of_unknown_extension_and_an_input_without_content_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("out.xyz");
    let input = source();
    let said = fail([
        "convert",
        input.to_str().unwrap(),
        "-o",
        target.to_str().unwrap(),
    ]);
    assert!(said.contains("out.xyz") && said.contains(".h5"), "{said}");
    let table = folder.path().join("numbers.csv");
    std::fs::write(&table, "a,b\n1,2\n3,4\n").unwrap();
    let target = folder.path().join("out.uff");
    let said = fail([
        "convert",
        table.to_str().unwrap(),
        "-o",
        target.to_str().unwrap(),
    ]);
    assert!(said.contains("[[test.channel]]"), "{said}");
    assert!(!target.exists());
}
