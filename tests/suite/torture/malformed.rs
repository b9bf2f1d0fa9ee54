//! Bad files: where the error must be placed, and that the good function behind or before it is
//! delivered.

use super::build::{
    Binary, binary, changed, doubles, header, lines, rows, singles, survivor, text, uneven,
};
use super::{converted, deliver};

/// A bad dataset at the start of a file, and how its error must begin behind the path.
fn cases() -> Vec<(&'static str, Vec<u8>, &'static str)> {
    let one = ["1.0"];
    let form = Binary::default();
    let with = |line, record: &str| text(&changed(header("test", 4, 1), line, record), &one, "\n");
    let four = singles(&[1.0, 2.0, 3.0, 4.0], true);
    let head = |points| header("test", 2, points);
    let float = |float| Binary { float, ..form };
    let order = |order| Binary { order, ..form };
    let counted = |count| Binary {
        count: Some(count),
        ..form
    };
    let marked = b"\n    -1\n  -1\n-1\n";
    vec![
        (
            "a letter in the version",
            with(6, "    1         0    x         1 NONE              12  -3"),
            ":8: function record",
        ),
        (
            "a direction of 13",
            with(6, "    1         0    1         1 NONE              12  13"),
            ":8: function record",
        ),
        ("an empty record 6", with(6, ""), ":8: function record"),
        ("data type 3", rows(3, 1, &one), ":9: data type"),
        ("data type 0", rows(0, 1, &one), ":9: data type"),
        (
            "a letter in the points",
            with(
                7,
                "         4        1O         1  0.00000E+00  1.00000E-03",
            ),
            ":9: data form record",
        ),
        (
            "points below zero",
            rows(4, -5, &one),
            ":9: number of points",
        ),
        (
            "a spacing of 2",
            with(7, "4 1 2 0.0 1.0 0.0"),
            ":9: abscissa spacing",
        ),
        (
            "a step that is no number",
            with(7, "4 1 1 0.0 NaN 0.0"),
            ":9: data form record",
        ),
        (
            "a step that overflows",
            with(7, "4 1 1 0.0 1.0E+999 0.0"),
            ":9: data form record",
        ),
        (
            "several points at one place",
            with(7, "4 2 1 0.0 0.0 0.0"),
            ":9: abscissa step",
        ),
        (
            "an axis record without a type",
            with(9, "acceleration"),
            ":11: axis record",
        ),
        (
            "a number with a comma",
            rows(4, 2, &["1.0 2,0"]),
            ":14: sample",
        ),
        (
            "a word among numbers",
            rows(4, 2, &["1.0", "oops"]),
            ":15: sample",
        ),
        (
            "a number that overflows",
            rows(4, 1, &["1.0E+400"]),
            ":14: sample",
        ),
        (
            "too few numbers",
            rows(4, 3, &["1.0 2.0"]),
            ":15: number of numbers",
        ),
        (
            "too many rows",
            rows(4, 1, &["1.0", "2.0"]),
            ":15: number of numbers",
        ),
        (
            "more points than bytes",
            rows(4, 999_999_999, &one),
            ":14: number of points",
        ),
        ("points that overflow", rows(6, i64::MAX, &one), ":"),
        (
            "uneven with a number too few",
            text(&uneven(4, 2, 19, "rpm"), &["1.0 2.0 3.0"], "\n"),
            ":15: number of numbers",
        ),
        (
            "uneven with a word",
            text(&uneven(2, 1, 17, "s"), &["1.0 x"], "\n"),
            ":14: sample",
        ),
        (
            "a header cut by a delimiter",
            lines(&["    -1", "    58", "test", "    -1"], "\n"),
            ":",
        ),
        (
            "VAX numbers",
            binary(&head(4), &four, float(1)),
            ":2: binary dataset 58",
        ),
        (
            "IBM numbers",
            binary(&head(4), &four, float(3)),
            ":2: binary dataset 58",
        ),
        (
            "byte order 3",
            binary(&head(4), &four, order(3)),
            ":2: binary dataset 58",
        ),
        (
            "a binary line cut short",
            lines(&["    -1", "    58b     1", "    -1"], "\n"),
            ":2: binary dataset 58",
        ),
        (
            "a block and count that disagree",
            binary(&head(5), &four, counted(7)),
            " at byte ",
        ),
        (
            "a width that is wrong",
            binary(&header("test", 4, 2), &singles(&[1.0; 2], true), form),
            " at byte ",
        ),
        (
            "points beyond the file",
            binary(&head(9_999_999_999), &four, counted(3)),
            " at byte ",
        ),
        (
            "delimiters in a block of wrong length",
            binary(&head(7), marked, counted(2)),
            " at byte ",
        ),
        (
            "a bad binary header",
            binary(&changed(head(4), 7, "nothing"), &four, form),
            ":9: data form record",
        ),
        (
            "a bad binary header and count",
            binary(&changed(head(4), 9, "nothing"), &four, counted(3)),
            ":11: axis record",
        ),
        (
            "uneven bytes of a wrong length",
            binary(
                &uneven(4, 3, 17, "s"),
                &doubles(&[1.0; 5], true),
                counted(1),
            ),
            " at byte ",
        ),
        (
            "a node of two coordinates",
            lines(&["    -1", "    15", "1 0 0 1 1. 2.", "    -1"], "\n"),
            ":3: ",
        ),
        (
            "units of zero",
            lines(&["    -1", "   164", "1", "0. 1. 1.", "    -1"], "\n"),
            ":4: factors",
        ),
    ]
}

#[test]
fn each_error_has_its_place_and_the_rest_is_delivered() {
    let cases = cases();
    assert!(cases.len() >= 30, "{}", cases.len());
    for (what, bad, place) in cases {
        let bytes = [bad, survivor()].concat();
        let (written, code) = converted(&bytes);
        let (delivered, errors) = deliver(bytes);
        assert!(!errors.is_empty(), "{what}");
        assert_eq!((code, &written), (Some(1), &delivered), "{what}");
        let expected = format!("torture.uff{place}");
        assert!(errors[0].starts_with(&expected), "{what}: {}", errors[0]);
        let last = delivered
            .last()
            .unwrap_or_else(|| panic!("{what}: {errors:?}"));
        assert_eq!(
            (last.name.as_str(), last.values.as_slice()),
            ("survivor", &[4.5, -2.0][..]),
            "{what}"
        );
    }
}

#[test]
fn a_cut_anywhere_delivers_what_is_whole() {
    let block = binary(
        &header("bytes", 4, 3),
        &doubles(&[1.0, 2.0, 3.0], true),
        Binary::default(),
    );
    let numbers = text(&header("numbers", 4, 3), &["1.0 2.0", "3.25"], "\n");
    for (name, values, cut_part) in [
        ("bytes", [1.0, 2.0, 3.0], block),
        ("numbers", [1.0, 2.0, 3.25], numbers),
    ] {
        for cut in 1..cut_part.len() {
            let (delivered, errors) = deliver([survivor(), cut_part[..cut].to_vec()].concat());
            assert_eq!(delivered[0].name, "survivor", "{cut}");
            for function in &delivered[1..] {
                assert_eq!(
                    (function.name.as_str(), function.values.as_slice()),
                    (name, &values[..]),
                    "{cut}"
                );
            }
            // Before the dataset's number nothing is lost.
            let begun = cut >= b"    -1\n    5".len();
            assert!(
                !begun || delivered.len() + errors.len() >= 2,
                "{cut}: {errors:?}"
            );
        }
    }
}

#[test]
fn a_file_of_another_format_delivers_nothing() {
    for bytes in [
        "    -1\n    58\n",
        "    -1\n    58b     1     2          11          16\n",
    ] {
        let (delivered, errors) = deliver(bytes.as_bytes().to_vec());
        assert_eq!(delivered.len(), 0, "{bytes}");
        assert_eq!(errors.len(), 1, "{errors:?}");
    }
}
