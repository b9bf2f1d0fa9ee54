//! Tables against hand-made text, and against private recordings where they are present.

use std::io::Write;
use std::path::PathBuf;

use num_complex::Complex64;

use crate::io::*;

fn unit<T: std::str::FromStr>(text: &str) -> T
where
    T::Err: std::fmt::Debug,
{
    text.parse().expect("a text of its type")
}

fn column(name: ColumnName, role: ColumnRole) -> TableColumn {
    TableColumn {
        column: name,
        role,
        scale: 1.0,
    }
}

fn heading(name: &str) -> ColumnName {
    ColumnName::Heading(name.to_owned())
}

fn hammer_spec() -> TableSpec {
    TableSpec {
        sampling_rate_hz: Some(48_000.0),
        columns: vec![
            column(
                heading("force"),
                ColumnRole::Force {
                    dof: Some(unit("1:+Z")),
                    unit: unit("N"),
                },
            ),
            column(
                heading("acceleration"),
                ColumnRole::Response {
                    dof: Some(unit("2:+Z")),
                    unit: unit("m/s2"),
                },
            ),
        ],
        ..TableSpec::default()
    }
}

fn open(text: &str, spec: TableSpec) -> Result<Box<dyn Source>, IoError> {
    let hints = Hints {
        path: "t.csv".to_owned(),
        table: Some(spec),
    };
    open_bytes(text.as_bytes().to_vec(), &hints)
}

fn message(text: &str, spec: TableSpec) -> String {
    match open(text, spec) {
        Err(error) => error.to_string(),
        Ok(mut source) => source.take_damage()[0].to_string(),
    }
}

fn samples(source: &mut dyn Source, entry: usize) -> Vec<f64> {
    let mut block = Block::F64(Vec::new());
    source
        .read(entry, 0..source.catalog().entries[entry].len(), &mut block)
        .expect("the samples of the entry");
    match block {
        Block::F64(values) => values,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_table_without_time_column_takes_the_stated_rate() {
    let mut source = open(
        "force,other,acceleration\r\n1,9,2\r\n3,9,\"4\"\r\n",
        hammer_spec(),
    )
    .expect("a table of this description");
    assert_eq!(samples(source.as_mut(), 0), [1.0, 3.0]);
    assert_eq!(samples(source.as_mut(), 1), [2.0, 4.0]);
    let entries = &source.catalog().entries;
    assert_eq!(entries[0].role, Some(crate::record::Role::Force));
    let EntryAxis::Time(axis) = entries[1].axis else {
        panic!()
    };
    assert!((axis.sampling_rate_hz() - 48_000.0).abs() < 1e-9 && axis.len == 2);
}

#[test]
fn the_unit_of_a_record_gives_its_scale() {
    let mut spec = hammer_spec();
    spec.columns[0].scale = 0.5;
    let source = open("force,acceleration\n1,2\n3,4\n", spec).expect("a table");
    let of = |entry: &Entry| (entry.unit_label.clone(), entry.to_si);
    let found: Vec<_> = source.catalog().entries.iter().map(of).collect();
    let expected = [("0.5 x N", 0.5), ("m/s2", 1.0)];
    assert_eq!(
        found,
        expected.map(|(text, to_si)| (text.to_owned(), Some(to_si)))
    );
}

#[test]
fn a_rounded_time_column_gives_the_spacing_over_the_whole_record() {
    let mut spec = hammer_spec();
    spec.sampling_rate_hz = None;
    spec.columns.push(column(heading("t"), ColumnRole::Time));
    let text = "t,force,acceleration\n0.0,1,1\n0.3,1,1\n0.7,1,1\n1.0,1,1\n";
    let source = open(text, spec.clone()).expect("a table");
    let EntryAxis::Time(axis) = source.catalog().entries[0].axis else {
        panic!()
    };
    assert!((axis.step_s - 1.0 / 3.0).abs() < 1e-15);
    let uneven = text.replace("0.7", "0.4");
    assert_eq!(
        message(&uneven.replace("0.3", "0.1"), spec),
        "t.csv:3: time: got \"0.1 after 0\", expected steps of 0.3333333333333333; is a row missing?"
    );
}

#[test]
fn errors_of_a_table_have_line_got_and_expected() {
    assert_eq!(
        message("force,accel\n1,2\n", hammer_spec()),
        "t.csv:1: got columns force, accel, expected a column \"acceleration\" ([[test.channel]] column)"
    );
    assert_eq!(
        message("force,acceleration\n1,2\n3,x4\n", hammer_spec()),
        "t.csv:3: number: got \"x4\", expected a finite number in column 2"
    );
    assert_eq!(
        message("force,acceleration\n1,2\n3\n", hammer_spec()),
        "t.csv:3: number: got \"1 column\", expected a finite number in column 2"
    );
    assert_eq!(
        message("force,acceleration\n1,2\n3,nan\n", hammer_spec()),
        "t.csv:3: number: got \"nan\", expected a finite number in column 2"
    );
    let unstated = TableSpec {
        sampling_rate_hz: None,
        ..hammer_spec()
    };
    assert!(
        message("force,acceleration\n1,2\n", unstated).contains("the sampling rate is not stated")
    );
    assert!(
        message("force,acceleration\n", hammer_spec()).contains("got text without rows of numbers")
    );
}

#[test]
fn an_frf_table_has_its_axis_unit_and_words() {
    let frf_unit: crate::quantity::FrfUnit = unit("(mm/s2)/N");
    let spec = TableSpec {
        delimiter: Some(Delimiter::Blank),
        skip_lines: 1,
        columns: vec![
            column(ColumnName::Number(1), ColumnRole::Frequency),
            column(
                ColumnName::Number(2),
                ColumnRole::Real {
                    dof: None,
                    unit: frf_unit,
                },
            ),
            column(
                ColumnName::Number(3),
                ColumnRole::Imaginary {
                    dof: None,
                    unit: frf_unit,
                },
            ),
        ],
        ..TableSpec::default()
    };
    let hints = Hints {
        path: "f.txt".to_owned(),
        table: Some(spec),
    };
    let source =
        open_bytes(b"Hz (m/s\xb2)/N\n0.0 1 -2\n0.5\t3  4\n".to_vec(), &hints).expect("a table");
    let mut files = [HitFile {
        response: Some(unit("10:-X")),
        reference: Some(unit("1:+X")),
        ..HitFile::new(source)
    }];
    let sets = frf_sets(&mut files).expect("FRFs of one axis");
    assert_eq!((sets.len(), sets[0].axis().step_hz), (1, 0.5));
    assert!((sets[0].values(0)[0] - Complex64::new(1e-3, -2e-3)).norm() < 1e-18);
    assert_eq!(sets[0].functions()[0].response.to_string(), "10:-X");
}

fn shared_data() -> Option<PathBuf> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let found = ["../shared/data", "../../shared/data"]
        .iter()
        .map(|place| root.join(place))
        .find(|place| place.is_dir());
    if found.is_none() {
        let _ = std::io::stderr().write_all(b"skipped: no reference data\n");
    }
    found
}

#[test]
fn five_single_hits_of_a_plate_are_read_and_grouped() {
    let Some(folder) = shared_data() else { return };
    let expected: serde_json::Value = serde_json::from_str(
        &std::fs::read_to_string(folder.join("expected.json"))
            .expect("the file of expected values"),
    )
    .expect("JSON");
    let peaks: Vec<f64> = serde_json::from_value(expected["tonewood-plate1"]["force_peak"].clone())
        .expect("numbers of the plate");
    for (index, peak) in peaks.iter().enumerate() {
        let path = folder.join(format!("tonewood-plate1/plate_1_frf_{}.csv", index + 1));
        let hints = Hints {
            path: path.display().to_string(),
            table: Some(hammer_spec()),
        };
        let source = open_path(&path, &hints, None).expect("a table");
        let mut set =
            group_hits(vec![HitFile::new(source)], HitGrouping::Files, &[]).expect("one hit");
        let hits = crate::record::collect(&mut set.recording).expect("samples of the hit");
        assert_eq!((hits.len(), hits[0].axis.len), (1, 96_000));
        let largest = hits[0].force.si().into_iter().fold(0.0, f64::max);
        assert!((largest - peak).abs() < 1e-6, "{largest} {peak}");
    }
}
