//! Tables of modes: written and read again, and what is wrong with one.

use std::io::Cursor;

use num_complex::Complex64;
use proptest::prelude::*;

use super::ModesCsv;
use crate::dof::Dof;
use crate::io::{
    Confidence, Format, Hints, IoError, Source, Table, WriteOptions, detect, modal_model_of,
    modes_source,
};
use crate::modal::{ModalModel, Mode, ModeShape, Scaling};

/// The modes, or the first that is wrong.
fn read(text: &str) -> Result<Vec<Mode>, String> {
    let source = source(text).map_err(|error| error.to_string())?;
    match source.catalog().damage.first() {
        Some(error) => Err(error.to_string()),
        None => Ok(modal_model_of(source.catalog(), Vec::new()).modes),
    }
}

fn source(text: &str) -> Result<Box<dyn Source>, IoError> {
    let hints = Hints {
        path: "m.csv".to_owned(),
        table: None,
    };
    let input = Box::new(Cursor::new(text.as_bytes().to_vec()));
    ModesCsv.open(input, &hints)
}

#[test]
fn good_rows_are_read_despite_a_bad_row() {
    let text = "frequency_hz,damping_ratio,1:+Z\n10,0.01,1\n11,x,1\n12,0.01,-1\n";
    let found = source(text).unwrap();
    let modes = modal_model_of(found.catalog(), Vec::new()).modes;
    let hz: Vec<f64> = modes.iter().map(|mode| mode.frequency_hz).collect();
    assert_eq!(hz, [10.0, 12.0]);
    assert_eq!(found.catalog().findings.len(), 1);
    let error = found.catalog().damage[0].to_string();
    assert!(
        error.starts_with("m.csv:3: damping_ratio: got \"x\""),
        "{error}"
    );
    assert!(source("frequency_hz,damping_ratio,1:+Z\n11,x,1\n").is_err());
}

fn written(modes: &[Mode]) -> (String, Vec<crate::Finding>) {
    let model = ModalModel {
        modes: modes.to_vec(),
        ..ModalModel::default()
    };
    let mut bytes = Cursor::new(Vec::new());
    let mut source = modes_source(&model, "");
    assert!(ModesCsv.takes(&source.catalog) && Table.takes(&source.catalog));
    let lost = ModesCsv
        .write(&mut bytes, &mut source, &WriteOptions::default())
        .unwrap();
    (String::from_utf8(bytes.into_inner()).unwrap(), lost)
}

fn dof(text: &str) -> Dof {
    text.parse().unwrap()
}

proptest! {
    #[test]
    fn modes_come_back_to_the_bit(
        f in 0.0..1e5f64,
        zeta in proptest::option::of(1e-6..0.5f64),
        parts in proptest::collection::vec((-1e3..1e3f64, -1e-9..1e9f64), 3),
        real in any::<bool>(),
        group in proptest::option::of(any::<u32>()),
        mass in proptest::option::of(1e-9..1e9f64),
        scaling in 0..3usize,
    ) {
        let names = ["1:+X", "case.2:-RZ", "10:+S"];
        let value = |(re, im): &(f64, f64)| Complex64::new(*re, if real { 0.0 } else { *im });
        let all = names.iter().zip(&parts).map(|(name, part)| (dof(name), value(part)));
        let scaling = [Scaling::UnitModalMass, Scaling::UnitMax, Scaling::Unknown][scaling];
        let first = Mode {
            group,
            modal_mass_kg: mass,
            frequency_std_hz: mass,
            damping_std: zeta,
            ..Mode::new(f, zeta, ModeShape::new(all.clone()), scaling)
        };
        // The second one was not measured everywhere.
        let second = Mode::new(f + 1.0, None, ModeShape::new(all.take(2)), Scaling::Unknown);
        let modes = [first, second];
        let (text, lost) = written(&modes);
        prop_assert!(lost.is_empty());
        prop_assert_eq!(ModesCsv.detect(text.as_bytes()), Confidence::Certain);
        prop_assert_eq!(read(&text).unwrap(), modes);
    }
}

#[test]
fn a_hand_written_table_is_read_with_remarks_other_delimiters_and_empty_cells() {
    for delimiter in [",", ";", "\t"] {
        let text = "# from the report\n\nfrequency_hz, damping_ratio ,1:+Z re,1:+Z im,2:-Z\r\n31.5,,1,-2,\r\n# the lower one\n12.25, 0.004,0,1e-3,-0.5\n";
        let text = format!("\u{feff}{}", text.replace(',', delimiter));
        assert_eq!(
            detect(text.as_bytes(), "m.csv").unwrap().name(),
            "modes-csv"
        );
        let [low, high] = &read(&text).unwrap()[..] else {
            panic!("{text}")
        };
        assert_eq!((low.frequency_hz, low.damping_ratio), (12.25, Some(0.004)));
        assert_eq!(low.shape.get(&dof("2:-Z")), Some(Complex64::new(-0.5, 0.0)));
        assert_eq!((high.frequency_hz, high.damping_ratio), (31.5, None));
        assert_eq!(
            high.shape.get(&dof("1:+Z")),
            Some(Complex64::new(1.0, -2.0))
        );
        assert_eq!(high.shape.len(), 1, "an empty cell is no zero");
    }
    let frfs = "frequency_hz,1:+Z\n1,2\n";
    assert_eq!(detect(frfs.as_bytes(), "m.csv").unwrap().name(), "table");
}

#[test]
fn errors_of_a_modes_table_have_the_line() {
    let head = "frequency_hz,damping_ratio,group,scaling,1:+X\n";
    for (text, expected) in [
        ("frequency,damping_ratio\n".to_owned(), "m.csv:1: heading"),
        (format!("{head}1,0.1,,,1,7\n"), "m.csv:2: row"),
        (
            format!("{head}1,0.1,,,1\n2,0.1,,,x\n"),
            "m.csv:3: shape: got \"x\"",
        ),
        (format!("{head}-1,0.1,,,1\n"), "frequency of 0 Hz or more"),
        (format!("{head},0.1,,,1\n"), "frequency of 0 Hz or more"),
        (format!("{head}1,inf,,,1\n"), "damping_ratio: got \"inf\""),
        (format!("{head}1,0.1,1.5,,1\n"), "group: got \"1.5\""),
        (
            format!("{head}1,0.1,,mass,1\n"),
            "unit-modal-mass, unit-max or unknown",
        ),
        (head.replace("group", "grup"), "column: got \"grup\""),
        (head.replace("group", "1:+X"), "each column once"),
        (head.replace("group", "2:+X re"), "2:+X re and 2:+X im"),
        (
            head.replace("group,scaling", "1:+X re,1:+X im"),
            "1:+X, or 1:+X re",
        ),
    ] {
        let error = read(&text).unwrap_err().to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    }
}

/// The error of the reader for a refused text.
fn refusal(text: &str) -> String {
    read(text).unwrap_err()
}

#[test]
fn half_a_complex_value_is_refused_and_an_empty_one_is_missing() {
    let head = "frequency_hz,damping_ratio,1:+Z re,1:+Z im,2:+Z\n";
    for (row, alone) in [("10,0.01,1,,2", "re"), ("10,0.01,,1,2", "im")] {
        let error = refusal(&format!("{head}9,0.01,1,0,2\n{row}\n"));
        let expected = format!("m.csv:3: shape: got \"1:+Z {alone} alone\"");
        assert!(error.contains(&expected), "{error}");
    }
    let mode = &read(&format!("{head}10,0.01,,,2\n")).unwrap()[0];
    assert_eq!(
        mode.shape,
        ModeShape::new([(dof("2:+Z"), Complex64::new(2.0, 0.0))])
    );
}

#[test]
fn remarks_blank_lines_and_rows_of_empty_cells_are_skipped_and_counted() {
    let skipped = "# r\n \t# r, s\n\n  \n,,,\n\"\", ,,\n";
    for end in ["\n", "\r\n", "\r"] {
        let text = |last: &str| {
            let head = "frequency_hz,damping_ratio,1:+Z,2:+Z";
            let text = format!("{skipped}{head}\n{skipped}10,,1,2\n{skipped}{last}\n{skipped}   ");
            text.replace('\n', end)
        };
        let good = text("20,,2,1");
        let hints = Hints {
            path: "m.csv".to_owned(),
            table: None,
        };
        assert_eq!(ModesCsv.detect(good.as_bytes()), Confidence::Certain);
        let input = Box::new(Cursor::new(good.into_bytes()));
        let source = ModesCsv.open(input, &hints).unwrap();
        let modes = source.catalog().modes.iter();
        let lines: Vec<_> = modes
            .map(|entry| (entry.line, entry.mode.frequency_hz))
            .collect();
        // Six lines are skipped before the heading and before each of the two rows.
        assert_eq!(lines, [(Some(14), 10.0), (Some(21), 20.0)]);
        for (last, what) in [
            ("20,,x,1", "shape"),
            ("20,,1", "row"),
            ("x,,1,1", "frequency_hz"),
        ] {
            let error = refusal(&text(last));
            assert!(
                error.starts_with(&format!("m.csv:21: {what}: got")),
                "{error}"
            );
        }
    }
    let error = refusal("frequency_hz,damping_ratio,1,2\n# r\n# r\n\n10,x,1,2\n");
    assert!(error.starts_with("m.csv:1: column: got \"1\""), "{error}");
    let error = refusal("frequency_hz,damping_ratio,1:+Z,2:+Z\n# r\n# r\n\n10,x,1,2\n");
    assert!(
        error.starts_with("m.csv:5: damping_ratio: got \"x\""),
        "{error}"
    );
}

#[test]
fn cells_may_stand_in_quotation_marks() {
    let text = "\"frequency_hz\";\"damping_ratio\";\"1:+Z\"\n\"10\";\"\";\" 2\"\n";
    assert_eq!(ModesCsv.detect(text.as_bytes()), Confidence::Certain);
    let mode = &read(text).unwrap()[0];
    assert_eq!((mode.frequency_hz, mode.damping_ratio), (10.0, None));
    assert_eq!(mode.shape.get(&dof("1:+Z")), Some(Complex64::new(2.0, 0.0)));
}

#[test]
fn impossible_deviations_masses_and_signs_are_refused_in_reading_and_writing() {
    let head = "frequency_hz,damping_ratio,frequency_std_hz,damping_std,modal_mass_kg\n";
    for (row, expected) in [
        (
            "1,,-0.1,,",
            "frequency_std_hz: got \"-0.1\", expected a number of 0 or more",
        ),
        (
            "1,,,-1e-9,",
            "damping_std: got \"-1e-9\", expected a number of 0 or more",
        ),
        (
            "1,,,,-2",
            "modal_mass_kg: got \"-2\", expected a number above 0",
        ),
        (
            "1,,,,0",
            "modal_mass_kg: got \"0\", expected a number above 0",
        ),
    ] {
        let error = refusal(&format!("{head}1,,0,0,1e-9\n{row}\n"));
        assert!(
            error.starts_with(&format!("m.csv:3: {expected}")),
            "{error}"
        );
    }
    for names in ["1:+Z,1:-Z", "1:+Z re,1:+Z im,1:-Z"] {
        let error = refusal(&format!("\nfrequency_hz,damping_ratio,{names}\n"));
        let expected = "m.csv:2: column: got \"1:-Z\", expected one sign";
        assert!(error.starts_with(expected), "{error}");
    }
    // Another measurement there is another degree of freedom.
    assert!(read("frequency_hz,damping_ratio,1:+Z,1:-Z#2\n1,,1,2\n").is_ok());

    let shape = |name: &str| ModeShape::new([(dof(name), Complex64::new(1.0, 0.0))]);
    let mode = |name: &str| Mode::new(1.0, None, shape(name), Scaling::Unknown);
    let light = Mode {
        modal_mass_kg: Some(-1.0),
        ..mode("1:+Z")
    };
    for (modes, what) in [
        (vec![light], "modal_mass_kg"),
        (vec![mode("1:+Z"), mode("1:-Z")], "column"),
    ] {
        let model = ModalModel {
            modes,
            ..ModalModel::default()
        };
        let mut source = modes_source(&model, "");
        let mut bytes = Cursor::new(Vec::new());
        let error = ModesCsv.write(&mut bytes, &mut source, &WriteOptions::default());
        let error = error.unwrap_err();
        assert!(
            matches!(&error, IoError::Unwritable { what: unwritable, .. } if *unwritable == what),
            "{error}"
        );
        assert!(bytes.into_inner().is_empty(), "{what}");
    }
}

#[test]
fn a_heading_alone_holds_no_modes_and_is_named_with_its_line() {
    let error = refusal("# r\n\nfrequency_hz,damping_ratio,1:+X\n,,\n# r\n");
    assert!(
        error.starts_with("m.csv:3: modes: got \"a heading alone\""),
        "{error}"
    );
    let error = refusal("# r\n\nfrequency,damping_ratio\n1,2\n");
    assert!(
        error.starts_with("m.csv:3: heading: got \"frequency,"),
        "{error}"
    );
    let error = refusal("# r\n\nfrequency_hz,damping_ratio,grup\n1,2,3\n");
    assert!(
        error.starts_with("m.csv:3: column: got \"grup\""),
        "{error}"
    );
}

#[test]
fn properties_that_a_table_cannot_hold_are_reported() {
    let mut mode = Mode::new(1.0, None, ModeShape::default(), Scaling::Unknown);
    mode.residues
        .insert((dof("1:+X"), dof("2:+X")), Complex64::i());
    mode.order = Some(12);
    mode.damping_bias = Some(1e-4);
    mode.shape_std = Some([(dof("1:+X"), 0.1)].into());
    let (text, lost) = written(&[mode]);
    assert_eq!(text, "frequency_hz,damping_ratio\n1,\n");
    let said: Vec<String> = lost.iter().map(ToString::to_string).collect();
    for what in [
        "residues",
        "deviations of shapes",
        "methods and orders",
        "biases",
    ] {
        assert!(
            said.iter().any(|place| place.contains(what)),
            "{what}: {said:?}"
        );
    }
}

#[test]
fn damping_in_percent_is_divided_by_a_hundred_unless_it_is_stated_as_fractions() {
    let open = |text: &str| {
        let input = Box::new(std::io::Cursor::new(text.as_bytes().to_vec()));
        let hints = crate::io::Hints {
            path: "m.csv".to_owned(),
            ..crate::io::Hints::default()
        };
        let source = ModesCsv.open(input, &hints).unwrap();
        let catalog = source.catalog();
        let ratios: Vec<Option<f64>> = catalog.modes.iter().map(|e| e.mode.damping_ratio).collect();
        let findings: Vec<String> = catalog
            .findings
            .iter()
            .map(|f| format!("{} at {}", f.code.name(), f.location))
            .collect();
        (ratios, findings)
    };
    let head = "frequency_hz,damping_ratio,1:+Z\n";
    let (ratios, findings) = open(&format!("{head}10,1.5,1\n20,0.5,1\n"));
    assert_eq!(ratios, [Some(0.015), Some(0.005)]);
    assert_eq!(findings, ["damping-in-percent at m.csv:2"]);
    let (ratios, findings) = open(&format!("{head}10,,1\n20,-0.01,1\n30,0.01,1\n"));
    assert_eq!(ratios, [None, Some(-0.01), Some(0.01)]);
    assert_eq!(findings, ["negative-damping at m.csv:3"]);
    // A table that modalign wrote comes back as it was.
    let shape = ModeShape::new([(dof("1:+Z"), Complex64::new(1.0, 0.0))]);
    let modes = [Mode::new(10.0, Some(1.5), shape, Scaling::Unknown)];
    let (text, _) = written(&modes);
    assert_eq!(open(&text), (vec![Some(1.5)], Vec::new()));
}

#[test]
fn modes_are_read_in_every_coding_and_with_decimal_commas() {
    let text = "frequency_hz,damping_ratio,1:+Z,2:+Z\n20.5,0.01,1,-0.5\n55,0.008,NaN,nan(ind)\n";
    let marked = format!("\u{feff}{text}");
    let utf_16 = |turn: fn(u16) -> [u8; 2]| marked.encode_utf16().flat_map(turn).collect();
    let texts: [Vec<u8>; 8] = [
        text.replace("frequency_hz,damping", "Frequency_Hz,Damping")
            .into_bytes(),
        text.replace('-', "\u{2212}").into_bytes(),
        marked.replace('\n', "\r").into_bytes(),
        utf_16(u16::to_le_bytes),
        utf_16(u16::to_be_bytes),
        format!("{text}\u{1a}").into_bytes(),
        text.replace(',', ";").replace('.', ",").into_bytes(),
        text.replace(',', "\t").replace('.', ",").into_bytes(),
    ];
    for bytes in texts {
        assert_eq!(ModesCsv.detect(&bytes), Confidence::Certain);
        let input = Box::new(std::io::Cursor::new(bytes));
        let source = ModesCsv.open(input, &crate::io::Hints::default()).unwrap();
        let modes = &source.catalog().modes;
        let [low, high] = [0, 1].map(|index| &modes[index].mode);
        assert_eq!((low.frequency_hz, high.damping_ratio), (20.5, Some(0.008)));
        assert_eq!(low.shape.get(&dof("2:+Z")), Some(Complex64::new(-0.5, 0.0)));
        assert_eq!(high.shape.len(), 0, "what is no number is not known");
    }
}

#[test]
fn a_column_that_numbers_or_names_the_modes_is_passed_over() {
    for text in [
        "Mode,frequency_hz\n1,12.25\nf2,31.5\n",
        "frequency_hz,mode no.\n12.25,1\n31.5,2\n",
        "#;f [Hz];damping_ratio\n1;12,25;0,01\n2;31,5;0,02\n",
        "No\tFrequency [Hz]\tModes\n1\t12.25\tbending\n2\t31.5\ttorsion\n",
        "# modes of a beam\nNr.,f_hz,damping_ratio,1:+Z\n1,12.25,0.01,1\n2,31.5,0.01,-1\n",
    ] {
        let certain = detect(text.as_bytes(), "m.csv").unwrap();
        assert_eq!(certain.name(), "modes-csv", "{text}");
        let hz: Vec<f64> = read(text).unwrap().iter().map(|m| m.frequency_hz).collect();
        assert_eq!(hz, [12.25, 31.5], "{text}");
    }
    // A remark stays one, and numbers alone are no modes.
    let modes = read("# f [Hz], of a beam\nfrequency_hz\n12.25\n").unwrap();
    assert_eq!(modes.len(), 1);
    assert!(read("mode,no\n1,2\n").is_err());
}
