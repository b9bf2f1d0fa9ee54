//! Damaged files: what is lost is said with its place, and the rest still opens.

use super::file_builder::{
    Form, PATH, all, binary_58, dataset, doubles, header, open, singles, text_58,
};
use crate::finding::{Code, Location, Severity};
use crate::io::{Block, IoError, Source};

/// A good dataset that must survive whatever stands before it.
fn survivor() -> Vec<u8> {
    let mut head = header(2, 1);
    head[0] = "survivor".to_owned();
    text_58(&head, &["4.5"], "\n")
}

fn survives(source: &mut dyn Source) {
    let last = source.catalog().entries.len() - 1;
    let entry = &source.catalog().entries[last];
    assert_eq!(entry.identification.lines[0], "survivor");
    assert_eq!(all(source, last).unwrap(), Block::F64(vec![4.5]));
}

fn text_error(error: &IoError) -> (u64, &'static str, &str) {
    match error {
        IoError::Text {
            line, what, got, ..
        } => (*line, *what, got.as_str()),
        other => panic!("expected a line, got {other:?}"),
    }
}

#[test]
fn a_bad_header_field_is_placed_by_its_line() {
    for (index, text, what, line) in [
        (
            5,
            "    1         0    x         7 NONE              12  -3",
            "function record (6) of dataset 58",
            8,
        ),
        (
            6,
            "         2        1O         1  0.00000E+00  1.95313E-05",
            "data form record (7) of dataset 58",
            9,
        ),
        (
            6,
            "         7         1         1  0.00000E+00  1.95313E-05",
            "data type of dataset 58",
            9,
        ),
        (
            6,
            "         2         1         2  0.00000E+00  0.00000E+00",
            "abscissa spacing of dataset 58",
            9,
        ),
        (
            6,
            "         2         2         1  0.00000E+00  0.00000E+00",
            "abscissa step of dataset 58",
            9,
        ),
        (
            6,
            "         2 999999999         1  0.00000E+00  1.95313E-05",
            "number of points of dataset 58",
            14,
        ),
        (8, "acceleration", "axis record (8 to 10) of dataset 58", 11),
    ] {
        let mut head = header(2, 1);
        head[index] = text.to_owned();
        let mut file = text_58(&head, &["1.0 2.0"], "\n");
        file.extend(survivor());
        let mut source = open(file).unwrap();
        let catalog = source.catalog();
        assert_eq!(catalog.damage.len(), 1, "{text}: {:?}", catalog.damage);
        let (at, found, _) = text_error(&catalog.damage[0].error);
        assert_eq!((at, found), (line, what), "{text}");
        let bad = &catalog.findings[0];
        assert_eq!(
            (bad.code, bad.severity),
            (Code::BadDataset, Severity::Error)
        );
        let location = Location::File {
            path: PATH.to_owned(),
            line: Some(line),
            byte: None,
        };
        assert_eq!(bad.location, location);
        survives(source.as_mut());
    }
}

#[test]
fn bad_numbers_of_a_text_block_are_placed_when_they_are_read() {
    for (rows, line, what, got) in [
        (
            vec!["1.0 2.0", "3.0 4,0"],
            15,
            "sample of dataset 58",
            "4,0",
        ),
        (
            vec!["1.0 2.0", "3.0"],
            16,
            "number of numbers of dataset 58",
            "3",
        ),
        (
            vec!["1.0 2.0", "3.0 4.0", "5.0"],
            16,
            "number of numbers of dataset 58",
            "5 or more",
        ),
        (
            vec!["1.0 2.0 3.0 4.0 0.0 9.0"],
            14,
            "number of numbers of dataset 58",
            "6 or more",
        ),
        (
            vec!["1.0 2.0 3.0 4.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0"],
            14,
            "number of numbers of dataset 58",
            "11 or more",
        ),
    ] {
        let mut file = text_58(&header(2, 4), &rows, "\n");
        file.extend(survivor());
        let mut source = open(file).unwrap();
        assert_eq!(source.catalog().damage.len(), 0);
        let error = all(source.as_mut(), 0).unwrap_err();
        assert_eq!(text_error(&error), (line, what, got), "{rows:?}");
        survives(source.as_mut());
    }
}

#[test]
fn a_truncated_block_is_placed_by_its_byte() {
    let whole = binary_58(
        &header(4, 100),
        &doubles(&[1.0; 100], true),
        Form::default(),
    );
    let good = survivor();
    for lost in [9 + 1, 9 + 400, 9 + 800] {
        let mut file = good.clone();
        file.extend(&whole[..whole.len() - lost]);
        let bytes = file.len() as u64;
        let mut source = open(file).unwrap();
        let catalog = source.catalog();
        assert_eq!((catalog.entries.len(), catalog.damage.len()), (1, 1));
        let IoError::Truncated {
            byte,
            what,
            got,
            expected,
            ..
        } = &catalog.damage[0].error
        else {
            panic!("{:?}", catalog.damage)
        };
        assert_eq!(*byte, bytes);
        assert_eq!(*what, "a binary block of dataset 58b");
        assert_eq!(*got, format!("{} bytes", 809 - lost));
        assert_eq!(expected, "100 points of 8 bytes");
        survives(source.as_mut());
    }
}

#[test]
fn every_truncated_file_opens_or_reports_its_end() {
    let mut file = dataset(&["   151", "Machine"], "\n");
    let first = text_58(&header(2, 2), &["  1.0  2.0"], "\n");
    file.extend(&first);
    let complete = file.len();
    file.extend(binary_58(
        &header(2, 2),
        &singles(&[1.0, 2.0], true),
        Form::default(),
    ));
    for cut in complete + 90..file.len() {
        let source = open(file[..cut].to_vec()).unwrap();
        let catalog = source.catalog();
        // Without its delimiter a block whose bytes are all there is whole.
        let whole = file.len() - cut <= 9;
        let partly_closed = whole && file.len() - cut < 9;
        let damage: Vec<&IoError> = catalog
            .damage
            .iter()
            .map(|damaged| &damaged.error)
            .collect();
        match &damage[..] {
            [] => assert_eq!((catalog.entries.len(), whole), (2, true), "{cut}"),
            [IoError::Truncated { byte, .. }] => {
                assert_eq!((*byte, catalog.entries.len()), (cut as u64, 1), "{cut}");
            }
            [IoError::Binary { .. }] => assert!(partly_closed, "{cut}"),
            other => panic!("{cut}: {other:?}"),
        }
    }
    for cut in 60..complete - 7 {
        let source = open(file[..cut].to_vec()).unwrap();
        let catalog = source.catalog();
        assert_eq!(catalog.entries.len(), 0, "{cut}");
        assert_eq!(catalog.title, ["Machine"]);
    }
}

#[test]
fn datasets_after_a_block_of_wrong_length_are_read() {
    let block = singles(&[1.0, 2.0, 3.0, 4.0], true);
    for points in [3, 5, 400, u64::from(u32::MAX), 9_999_999_999] {
        for count_error in [2, 3] {
            let form = Form {
                count_error,
                ..Form::default()
            };
            let mut file = binary_58(&header(2, points), &block, form);
            file.extend(survivor());
            let mut source = open(file).unwrap();
            assert_eq!(source.catalog().entries.len(), 1, "{points}");
            assert_eq!(
                source.catalog().damage.len(),
                1,
                "{points}: {:?}",
                source.catalog().damage
            );
            survives(source.as_mut());
        }
    }
}

#[test]
fn datasets_after_a_bad_binary_header_are_read() {
    let block = b"\n    -1\n    -1\n-1\n-1\n-1\n-1\n-1\n-1";
    for count_error in [0, 3] {
        for index in [5, 6, 7, 8] {
            let mut head = header(2, 8);
            head[index] = "nothing".to_owned();
            let form = Form {
                count_error,
                ..Form::default()
            };
            let mut file = binary_58(&head, block, form);
            file.extend(survivor());
            let mut source = open(file).unwrap();
            assert_eq!(
                source.catalog().damage.len(),
                1,
                "{:?}",
                source.catalog().damage
            );
            survives(source.as_mut());
        }
    }
    let mut vax = binary_58(&header(2, 1), &singles(&[1.0], true), Form::default());
    let float_format = 7 + 18;
    assert_eq!(vax[float_format], b'2');
    vax[float_format] = b'1';
    vax.extend(survivor());
    let mut source = open(vax).unwrap();
    assert_eq!(
        text_error(&source.catalog().damage[0].error).1,
        "binary dataset 58"
    );
    survives(source.as_mut());
}

#[test]
fn missing_and_doubled_delimiters_are_survived() {
    let one = text_58(&header(2, 1), &["1.0"], "\n");
    let mut doubled = b"    -1\n".to_vec();
    doubled.extend(&one);
    doubled.extend(b"\n\n");
    doubled.extend(survivor());
    doubled.extend(b"    -1\n");
    let mut source = open(doubled).unwrap();
    assert_eq!(
        (
            source.catalog().entries.len(),
            source.catalog().damage.len()
        ),
        (2, 0)
    );
    survives(source.as_mut());
    // The closing delimiter of the first is missing: the next opening one is taken as what it is.
    let mut missing = one[..one.len() - 7].to_vec();
    missing.extend(&one);
    missing.extend(survivor());
    let mut source = open(missing).unwrap();
    let catalog = source.catalog();
    assert_eq!((catalog.entries.len(), catalog.damage.len()), (3, 0));
    let finding = catalog.findings.iter().find(|f| f.code == Code::NotClosed);
    let location = Location::File {
        path: PATH.to_owned(),
        line: Some(15),
        byte: None,
    };
    assert_eq!(finding.map(|finding| &finding.location), Some(&location));
    survives(source.as_mut());
}

#[test]
fn a_text_without_its_last_delimiter_is_whole_when_its_last_line_is() {
    let whole = text_58(&header(2, 2), &["1.0 2.5"], "\n");
    for (lost, entries) in [(0, 1), (1, 1), (2, 1), (3, 1), (7, 1), (8, 0), (12, 0)] {
        let mut file = survivor();
        file.extend(&whole[..whole.len() - lost]);
        let mut source = open(file).unwrap();
        let catalog = source.catalog();
        assert_eq!(catalog.entries.len(), 1 + entries, "{lost}");
        assert_eq!(catalog.damage.len(), 1 - entries, "{lost}");
        let reported = catalog.findings.iter().any(|f| f.code == Code::NotClosed);
        assert_eq!(reported, entries == 1 && lost > 1, "{lost}");
        if entries == 1 {
            assert_eq!(all(source.as_mut(), 1).unwrap(), Block::F64(vec![1.0, 2.5]));
        }
    }
}

#[test]
fn a_byte_count_overrides_a_wrong_point_count() {
    let block = singles(&[1.0, 2.0, 3.0, 4.0], true);
    for (points, entries) in [(0, 1), (3, 1), (5, 1), (2, 0), (1, 0)] {
        let mut file = binary_58(&header(2, points), &block, Form::default());
        file.extend(survivor());
        let mut source = open(file).unwrap();
        let catalog = source.catalog();
        assert_eq!(
            (catalog.entries.len(), catalog.damage.len()),
            (1 + entries, 1 - entries)
        );
        if entries == 1 {
            let finding = &catalog.findings[0];
            assert_eq!(finding.code, Code::PointCountWrong);
            assert_eq!(
                (finding.value, finding.limit),
                (Some(points as f64), Some(4.0))
            );
            let values = Block::F32(vec![1.0, 2.0, 3.0, 4.0]);
            assert_eq!(all(source.as_mut(), 0).unwrap(), values);
        }
        survives(source.as_mut());
    }
}

#[test]
fn bad_datasets_of_other_numbers_are_placed() {
    for (lines, line, what) in [
        (
            vec![
                "    15",
                "         1         0         0         1  1.0  2.0",
            ],
            3,
            "node of dataset 15",
        ),
        (
            vec![
                "    15",
                "         0         0         0         1  1.0  2.0  3.0",
            ],
            3,
            "node label",
        ),
        (
            vec!["  2411", "         4         1         0         1"],
            3,
            "node of dataset 2411",
        ),
        (
            vec![
                "  2411",
                "         4         1         0         1",
                "1.0 2.0 x",
            ],
            4,
            "coordinates of dataset 2411",
        ),
        (
            vec!["   164", "         1", "  0.0 1.0 1.0"],
            4,
            "factors of dataset 164",
        ),
        (vec!["   164"], 2, "factors of dataset 164"),
        (
            vec!["    82", "1 2 8", "Frame", "1 -2"],
            5,
            "entries of dataset 82",
        ),
        (vec!["    82"], 2, "trace line of dataset 82"),
        (
            vec!["    15", "1 0 0 1 1. 2. 3.", "1 0 0 1 1. 2. 4."],
            4,
            "second position of a node",
        ),
    ] {
        let mut file = dataset(&lines, "\n");
        file.extend(survivor());
        let mut source = open(file).unwrap();
        let (at, found, _) = text_error(&source.catalog().damage[0].error);
        assert_eq!((at, found), (line, what), "{lines:?}");
        assert_eq!(source.catalog().damage.len(), 1);
        survives(source.as_mut());
    }
}

#[test]
fn behind_a_binary_block_places_are_bytes() {
    let mut file = binary_58(&header(2, 1), &singles(&[1.0], true), Form::default());
    let start = file.len() as u64;
    file.extend(dataset(&["    15", "one"], "\n"));
    let source = open(file).unwrap();
    let IoError::Binary { byte, got, .. } = &source.catalog().damage[0].error else {
        panic!("{:?}", source.catalog().damage)
    };
    assert_eq!((*byte, got.as_str()), (start + 7 + 7, "one"));
    assert_eq!(source.catalog().entries[0].line, Some(2));
}

#[test]
fn files_of_other_formats_are_errors() {
    for (bytes, line) in [
        ("", 1),
        ("1 2 3\n4 5 6\n", 1),
        ("\n\ntime\n-1\n", 3),
        ("    -1\n", 1),
    ] {
        let error = open(bytes.as_bytes().to_vec()).err().unwrap();
        assert_eq!(text_error(&error).0, line, "{bytes}");
        assert!(error.to_string().starts_with(PATH));
    }
}
