//! Layouts of tables that programs write, from text made here.

use crate::finding::{Code, Severity};
use crate::io::*;

fn inspected(bytes: &[u8]) -> Result<Box<dyn Source>, IoError> {
    let hints = Hints {
        path: "t.txt".to_owned(),
        table: None,
    };
    open_bytes(bytes.to_vec(), &hints)
}

/// Names and rows of the columns.
fn columns(bytes: &[u8]) -> Vec<(String, usize)> {
    let source = inspected(bytes).unwrap_or_else(|error| panic!("{error}"));
    let catalog = source.catalog();
    assert!(catalog.damage.is_empty(), "{:?}", catalog.damage);
    let of = |array: &ArrayInfo| (array.name.clone(), array.shape[0]);
    catalog.arrays.iter().map(of).collect()
}

fn names(bytes: &[u8]) -> Vec<String> {
    columns(bytes).into_iter().map(|(name, _)| name).collect()
}

fn error(bytes: &[u8]) -> String {
    inspected(bytes).err().expect("an error").to_string()
}

/// Values of the columns of these numbers, read as records with a stated rate.
fn values(bytes: &[u8], numbers: &[usize]) -> Vec<Vec<f64>> {
    let role = || ColumnRole::Response {
        dof: None,
        unit: "m/s2".parse().unwrap(),
    };
    let column = |number: &usize| TableColumn {
        column: ColumnName::Number(*number),
        role: role(),
        scale: 1.0,
    };
    let spec = TableSpec {
        sampling_rate_hz: Some(100.0),
        columns: numbers.iter().map(column).collect(),
        ..TableSpec::default()
    };
    let hints = Hints {
        path: "t.txt".to_owned(),
        table: Some(spec),
    };
    let mut source = open_bytes(bytes.to_vec(), &hints).unwrap_or_else(|error| panic!("{error}"));
    assert!(source.catalog().damage.is_empty());
    let mut all = Vec::new();
    for entry in 0..numbers.len() {
        let mut block = Block::F64(Vec::new());
        let len = source.catalog().entries[entry].len();
        source.read(entry, 0..len, &mut block).unwrap();
        let Block::F64(values) = block else { panic!() };
        all.push(values);
    }
    all
}

#[test]
fn every_separator_and_decimal_mark_is_found() {
    let expected = [vec![0.5, -1.5, 1e-3], vec![2.0, 3.25, 4.0]];
    for text in [
        "0.5,2\n-1.5,3.25\n1e-3,4\n",
        "0.5;2\n-1.5;3.25\n1e-3;4\n",
        "0,5;2\n-1,5;3,25\n1e-3;4\n",
        "0.5\t2\n-1.5\t3.25\n1e-3\t4\n",
        "0,5\t2\n-1,5\t3,25\n1e-3\t4\n",
        "  0.5   2\n -1.5 3.25\n 1e-3\t4  \n",
        "0,5 2,0\n-1,5 3,25\n0,001 4,0\n",
        "\"0,5\",\"2\"\n\"-1,5\",\"3,25\"\n\"0,001\",4\n",
        "0.5,2,\r\n-1.5,3.25,\r\n1e-3,4,\r\n",
        "0.5,2\r-1.5,3.25\r1e-3,4",
        "\u{feff}0.5, 2\n# between\n\n-1.5, 3.25\n  1D-3, 4",
        "Made by a logger\nrate;48000\nt;a\n0,5;2\n-1,5;3,25\n1e-3;4\n",
    ] {
        assert_eq!(values(text.as_bytes(), &[1, 2]), expected, "{text:?}");
    }
}

#[test]
fn headings_and_units_are_those_above_the_numbers() {
    for (text, expected) in [
        (
            "time (s),Force [N]\n0.0,1.5\n0.1,2.5\n",
            ["time (s)", "Force [N]"],
        ),
        (
            "Recorder 7\n\nt;F\ns;N\n0,0;1,5\n0,1;2,5\n",
            ["t [s]", "F [N]"],
        ),
        ("t\ta\n(s)\t(m/s^2)\n0.0\t1.5\n", ["t (s)", "a (m/s^2)"]),
        (
            "Time [s]   acc_1 (m/s^2)\n 0.0 1.5\n",
            ["Time [s]", "acc_1 (m/s^2)"],
        ),
        ("# time force\n0.0 1.5\n0.1 2.5\n", ["time", "force"]),
        (
            "\"Frequency, Hz\",\"|H|\"\n0.0,1.5\n",
            ["Frequency, Hz", "|H|"],
        ),
        ("0.0,1.5\n0.1,2.5\n", ["column 1", "column 2"]),
        ("force,acceleration\n0,1\n", ["force", "acceleration"]),
    ] {
        assert_eq!(names(text.as_bytes()), expected, "{text:?}");
    }
    // Latin-1, and a clock in the first column.
    let text = b"clock,a (m/s\xb2)\n10:00:00,1.5\n10:00:01,2.5\n";
    assert_eq!(
        columns(text),
        [("clock".to_owned(), 2), ("a (m/s²)".to_owned(), 2)]
    );
    let source = inspected(text).unwrap();
    assert_eq!(source.catalog().arrays[0].kind, "text");
}

#[test]
fn utf_16_is_read_as_text() {
    let text = "Zeit [s]\tBeschl. [m/s²]\r\n0,0\t1,5\r\n0,1\t2,5\r\n";
    let mut bytes = vec![0xff, 0xfe];
    bytes.extend(text.encode_utf16().flat_map(u16::to_le_bytes));
    assert_eq!(names(&bytes), ["Zeit [s]", "Beschl. [m/s²]"]);
    assert_eq!(values(&bytes, &[2]), [[1.5, 2.5]]);
}

#[test]
fn ambiguous_numbers_are_an_error() {
    let text = error(b"1,5\n2,5\n3,5\n");
    assert_eq!(
        text,
        "t.txt: what separates the columns (one column with decimal comma, or 2 columns separated by comma with \
         decimal point) is not stated: expected `delimiter` in [[test]]: comma, semicolon, tab or blank (for one \
         column with decimal comma: semicolon)"
    );
    // The unit behind a heading is no heading of a second column.
    assert!(error(b"Force,N\n1,5\n2,5\n").contains("what separates the columns"));
    // More rows of one column do not show that the comma is decimal.
    assert!(error(b"1,5\n2\n3\n4\n").contains("what separates the columns"));
    // One row that no decimal comma explains settles it.
    assert_eq!(columns(b"0,0\n0,0\n0,0\n1.5,2\n").len(), 2);
    assert!(error(b"no numbers\nat all\n").contains("got text without rows of numbers"));
    assert!(error(b"").contains("got an empty file, expected rows of numbers"));
}

#[test]
fn a_stated_separator_rules() {
    let spec = |delimiter, number| TableSpec {
        delimiter: Some(delimiter),
        sampling_rate_hz: Some(10.0),
        columns: vec![TableColumn {
            column: ColumnName::Number(number),
            role: ColumnRole::Response {
                dof: None,
                unit: "m".parse().unwrap(),
            },
            scale: 1.0,
        }],
        ..TableSpec::default()
    };
    let first = |delimiter, number| {
        let hints = Hints {
            path: "t.txt".to_owned(),
            table: Some(spec(delimiter, number)),
        };
        let mut source = open_bytes(b"1,5\n2,5\n".to_vec(), &hints)?;
        let mut block = Block::F64(Vec::new());
        source.read(0, 0..2, &mut block)?;
        Ok::<_, IoError>(block)
    };
    assert_eq!(
        first(Delimiter::Semicolon, 1).unwrap(),
        Block::F64(vec![1.5, 2.5])
    );
    assert_eq!(
        first(Delimiter::Comma, 2).unwrap(),
        Block::F64(vec![5.0, 5.0])
    );
    let text = first(Delimiter::Semicolon, 2).unwrap_err().to_string();
    assert!(text.contains("got \"1 column\""), "{text}");
}

#[test]
fn rows_before_a_bad_one_are_the_good_part() {
    for (text, rows, line, got) in [
        ("t,a\n0.0,1.5\n0.1,2.5\n0.2,x\n0.3,4.5\n", 2, 4, "x"),
        ("0.0,1.5\n0.1,2.5\n0.2,3.5\n0.3,", 3, 4, "1 column"),
        ("0.0,1.5\n0.1,2.5\n0.2,3.5\n0.3,1,7\n", 3, 4, "3 fields"),
        (
            "0.0,1.5\n0.1,2.5\n0.2,3.5\n\nend of data\n",
            3,
            5,
            "end of data",
        ),
    ] {
        let source = inspected(text.as_bytes()).unwrap();
        let catalog = source.catalog();
        assert_eq!(catalog.arrays[1].shape, [rows], "{text:?}");
        let damage = catalog.damage[0].to_string();
        assert!(
            damage.starts_with(&format!("t.txt:{line}: ")) && damage.contains(got),
            "{damage}"
        );
        let finding = &catalog.findings[0];
        assert_eq!(
            (finding.code, finding.severity),
            (Code::BadDataset, Severity::Error)
        );
    }
}

#[test]
fn a_bad_row_far_behind_the_first_block_is_named_by_its_line() {
    let mut text = String::from("t,a\n");
    for row in 0..200_000 {
        text += &format!("{row}.5,1.25\n");
    }
    text += "200000.5,1.2.5\n";
    let source = inspected(text.as_bytes()).unwrap();
    assert_eq!(source.catalog().arrays[0].shape, [200_000]);
    let damage = source.catalog().damage[0].to_string();
    assert!(
        damage.starts_with("t.txt:200002: number: got \"1.2.5\""),
        "{damage}"
    );
}

/// The error of reading these columns as records of a stated rate.
fn refused(bytes: &[u8], columns: &[ColumnName], skip_lines: usize) -> Option<String> {
    let column = |name: &ColumnName| TableColumn {
        column: name.clone(),
        role: ColumnRole::Response {
            dof: None,
            unit: "m/s2".parse().unwrap(),
        },
        scale: 1.0,
    };
    let hints = Hints {
        path: "t.csv".to_owned(),
        table: Some(TableSpec {
            skip_lines,
            sampling_rate_hz: Some(10.0),
            columns: columns.iter().map(column).collect(),
            ..TableSpec::default()
        }),
    };
    let opened = open_bytes(bytes.to_vec(), &hints);
    opened.err().map(|error| error.to_string())
}

#[test]
fn an_ambiguous_heading_is_an_error() {
    let named = |name: &str| [ColumnName::Heading(name.to_owned())];
    let rows = "0,1.5,2.5\n1,2.5,3.5\n";
    for (headings, name, known) in [
        ("time,acc,acc", "acc", false),
        ("time,acc [m/s2],acc [mm/s2]", "acc", false),
        ("time,acc [m/s2],acc [mm/s2]", "acc [m/s2]", true),
        ("time,acc,acc [mm/s2]", "acc", true),
    ] {
        let error = refused(format!("{headings}\n{rows}").as_bytes(), &named(name), 0);
        let expected = "t.csv:1: headings: got \"acc in columns 2 and 3\", expected one column of that name, or the \
                        number or the whole heading in [[test.channel]]";
        assert_eq!(error, (!known).then(|| expected.to_owned()), "{headings}");
    }
}

#[test]
fn fewer_headings_than_fields_are_asked_for_columns_by_number_too() {
    let two = [ColumnName::Number(1), ColumnName::Number(2)];
    let text = b"time,force\n0,001,1,5\n0,002,2,5\n0,003,3,5\n";
    let error = refused(text, &two, 0).unwrap();
    assert_eq!(
        error,
        "t.csv: what separates the columns (line 1 has 2 fields and the numbers below it 4) is not stated: expected \
         `delimiter` in [[test]], or `skip_lines = 1` where that line has no headings"
    );
    assert_eq!(refused(text, &two, 1), None);
    // Other separators are no decimal mark.
    assert_eq!(
        refused(b"time force\n0.001 1 5\n0.002 2 5\n", &two, 0),
        None
    );
}
