//! Files of real measurement systems, where the folder with them is there.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use num_complex::Complex64;

use super::file_builder::all;
use crate::finding::Code;
use crate::io::formats::uff::Uff;
use crate::io::{Block, EntryAxis, Format, FunctionType, Hints, Source};
use crate::quantity::Quantity;

/// Path of a recording; says so when there is none.
pub(super) fn recording(name: &str) -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let found = ["../shared/data", "../../shared/data"]
        .iter()
        .map(|folder| root.join(folder).join(name))
        .find(|path| path.exists());
    if found.is_none() {
        let _ = writeln!(std::io::stderr(), "skipped: no reference data");
    }
    found
}

pub(in crate::io::formats::uff) fn opened(name: &str) -> Option<Box<dyn Source>> {
    let path = recording(name)?;
    let hints = Hints {
        path: name.to_owned(),
        table: None,
    };
    let source = Uff
        .open(
            Box::new(File::open(path).expect("the recording is there")),
            &hints,
        )
        .expect("a universal file");
    assert!(
        source.catalog().damage.is_empty(),
        "{:?}",
        source.catalog().damage
    );
    Some(source)
}

pub(super) fn codes(source: &dyn Source) -> Vec<Code> {
    source.catalog().findings.iter().map(|f| f.code).collect()
}

/// Whether the sampling rate is restored to a whole number of samples per second.
fn has_whole_rate(source: &dyn Source, entry: usize) -> bool {
    match source.catalog().entries[entry].axis {
        EntryAxis::Time(axis) => axis.sampling_rate_hz().fract() == 0.0,
        _ => false,
    }
}

#[test]
fn a_text_file_and_its_binary_twin_agree() {
    let (Some(mut text), Some(mut binary)) = (
        opened("uff-formats/Sample_UFF58_ascii.uff"),
        opened("uff-formats/Sample_UFF58b_bin.uff"),
    ) else {
        return;
    };
    let Block::F64(a) = all(text.as_mut(), 0).expect("its numbers") else {
        panic!("text is read in double precision")
    };
    let Block::F32(b) = all(binary.as_mut(), 0).expect("its numbers") else {
        panic!("single precision stays single")
    };
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(&b) {
        assert!((a - f64::from(*b)).abs() <= 5e-7);
    }
    for source in [&text, &binary] {
        let entry = &source.catalog().entries[0];
        assert_eq!(
            (&entry.response, &entry.reference, entry.quantity),
            (&None, &None, None)
        );
        assert_eq!((entry.to_si, entry.unit_label.as_str()), (None, "Pa"));
        assert!(has_whole_rate(source.as_ref(), 0));
        assert_eq!(codes(source.as_ref()), [Code::SpacingRounded]);
    }
}

#[test]
fn records_with_a_line_end_behind_their_blocks_are_read() {
    let Some(mut source) = opened("uff-formats/MPSTD#Set001_2024_10_08_10_27_07.uff") else {
        return;
    };
    assert!(codes(source.as_ref()).is_empty());
    assert!(!source.catalog().entries.is_empty());
    for i in 0..source.catalog().entries.len() {
        let entry = &source.catalog().entries[i];
        assert!(entry.response.is_some() && entry.reference.is_none());
        assert_eq!(
            (entry.quantity, entry.to_si),
            (Some(Quantity::Acceleration), Some(1.0))
        );
        let len = entry.len();
        assert!(has_whole_rate(source.as_ref(), i));
        let Block::F32(values) = all(source.as_mut(), i).expect("its numbers") else {
            panic!("single precision stays single")
        };
        assert_eq!(values.len(), len);
    }
}

#[test]
fn complex_text_agrees_with_the_listed_values() {
    let Some(mut source) = opened("uff-formats/measurement.uff") else {
        return;
    };
    assert!(!source.catalog().entries.is_empty());
    for i in 0..source.catalog().entries.len() {
        let entry = source.catalog().entries[i].clone();
        assert_eq!(entry.function_type, FunctionType::Frf);
        assert!(entry.response.is_some() && entry.reference.is_some());
        let sides = (entry.quantity, entry.denominator, entry.to_si);
        assert_eq!(
            sides,
            (Some(Quantity::Acceleration), Some(Quantity::Force), None)
        );
        assert!(matches!(entry.axis, EntryAxis::Frequency(_)));
        let Block::Complex(values) = all(source.as_mut(), i).expect("its numbers") else {
            panic!("complex")
        };
        let path =
            recording(&format!("uff-formats/meas_point_{}.txt", i + 1)).expect("beside the others");
        let listed = std::fs::read_to_string(path).expect("text");
        // The first line of the list is the value at 0 Hz, which the file has as zero.
        assert_eq!(values.len(), listed.lines().count());
        for (value, line) in values.iter().zip(listed.lines()).skip(1) {
            let expected: Complex64 = line.trim_matches(['(', ')']).parse().expect("a number");
            assert!(
                (value - expected).norm() < 1e-11 * (1.0 + expected.norm()),
                "{line}"
            );
        }
    }
}

/// Words of the lines of a text file, another way to the same numbers.
fn word_lines(name: &str) -> Vec<Vec<String>> {
    let bytes = std::fs::read(recording(name).expect("the folder is there"))
        .expect("the recording is there");
    let text = String::from_utf8_lossy(&bytes).replace('D', "E");
    text.lines()
        .map(|line| line.split_whitespace().map(str::to_owned).collect())
        .collect()
}

fn numbers(words: &[String]) -> Vec<f64> {
    words
        .iter()
        .map(|word| word.parse().expect("a number"))
        .collect()
}

/// Numbers of a file with one function and nothing else: its fourteenth line up to the delimiter.
fn function_numbers(name: &str) -> Vec<f64> {
    let lines = word_lines(name);
    let rows = lines[13..].iter().take_while(|row| *row != &["-1"]);
    rows.flat_map(|row| numbers(row)).collect()
}

/// Lines of the first dataset of a number, without it.
fn dataset_lines(lines: &[Vec<String>], number: &str) -> Vec<Vec<String>> {
    let is_number = |i: &usize| lines[*i] == [number] && lines[*i - 1] == ["-1"];
    let Some(start) = (1..lines.len()).find(is_number) else {
        return Vec::new();
    };
    let rows = lines[start + 1..].iter();
    rows.take_while(|row| *row != &["-1"]).cloned().collect()
}

/// Label and coordinates in metres of every node of a file.
fn nodes(name: &str) -> Vec<(String, [f64; 3])> {
    let lines = word_lines(name);
    let units = dataset_lines(&lines, "164");
    let length = units.get(1).map_or(1.0, |row| numbers(row)[0]);
    let at_m = |words: &[String]| [0, 1, 2].map(|i| numbers(words)[i] / length);
    let single = dataset_lines(&lines, "15");
    let double = dataset_lines(&lines, "2411");
    let single = single.iter().map(|row| (row[0].clone(), at_m(&row[4..])));
    let double = double
        .chunks(2)
        .map(|rows| (rows[0][0].clone(), at_m(&rows[1])));
    single.chain(double).collect()
}

#[test]
fn a_header_in_latin_1_and_a_short_last_row_are_read() {
    let name = "uff-formats/non_ascii_header.uff";
    if let Some(mut source) = opened(name) {
        assert_eq!(codes(source.as_ref()), [Code::HeaderNotUtf8]);
        let entry = &source.catalog().entries[0];
        assert!(entry.unit_label.contains("m/s²") && entry.to_si == Some(1.0));
        let Block::Complex(values) = all(source.as_mut(), 0).expect("its numbers") else {
            panic!("complex")
        };
        let values: Vec<f64> = values.iter().flat_map(|h| [h.re, h.im]).collect();
        assert_eq!(values, function_numbers(name));
    }
    let name = "uff-formats/time-history-not-all-columns-filled.uff";
    if let Some(mut source) = opened(name) {
        let entry = &source.catalog().entries[0];
        let sides = (entry.quantity, entry.to_si);
        assert_eq!(sides, (Some(Quantity::Acceleration), Some(1.0)));
        assert!(has_whole_rate(source.as_ref(), 0));
        let Block::F64(values) = all(source.as_mut(), 0).expect("its numbers") else {
            panic!("real")
        };
        assert_eq!(values, function_numbers(name));
    }
}

#[test]
fn geometry_of_real_writers_is_read() {
    for name in [
        "uff-formats/TestLab 161 164 18 15 82.uff",
        "lms-testlab-modes/OOP_inb_new_attach_0_30Hz_no euler.unv",
        "uff-formats/heat_engine_housing.uff",
        "uff-formats/groups_test.uff",
        "uff-formats/mesh_Oros-modal_uff15_uff2412.uff",
    ] {
        let Some(source) = opened(name) else {
            return;
        };
        let geometry = &source.catalog().geometry;
        assert!(!geometry.nodes.is_empty(), "{name}");
        assert_eq!(geometry.nodes.len(), nodes(name).len(), "{name}");
        for (got, (label, at_m)) in geometry.nodes.iter().zip(nodes(name)) {
            assert_eq!(got.point, label, "{name}");
            for (got, expected) in got.at_m.iter().zip(at_m) {
                assert!((got - expected).abs() < 1e-15, "{name} {label}: {got}");
            }
        }
    }
}
