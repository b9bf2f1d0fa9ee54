//! Tables of modes: written and read again, and what is wrong with one.

use std::io::Cursor;

use num_complex::Complex64;
use proptest::prelude::*;

use super::modes_csv::ModesCsv;
use super::{
    Confidence, Format, Hints, IoError, Table, WriteOptions, detect, modes_of, modes_source,
};
use crate::dof::Dof;
use crate::modal::{ModalModel, Mode, ModeShape, Scaling};

fn read(text: &str) -> Result<Vec<Mode>, IoError> {
    let hints = Hints {
        path: "m.csv".to_owned(),
        table: None,
    };
    let input = Box::new(Cursor::new(text.as_bytes().to_vec()));
    let source = ModesCsv.open(input, &hints)?;
    Ok(modes_of(source.catalog(), Vec::new()).modes)
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
        let all = names.iter().zip(&parts).map(|(name, own)| (dof(name), value(own)));
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
fn what_is_wrong_is_named_with_its_line() {
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
    assert!(read(head).unwrap().is_empty());
}

#[test]
fn what_a_table_cannot_hold_is_said() {
    let mut mode = Mode::new(1.0, None, ModeShape::default(), Scaling::Unknown);
    mode.residues
        .insert((dof("1:+X"), dof("2:+X")), Complex64::i());
    mode.order = Some(12);
    mode.shape_std = Some([(dof("1:+X"), 0.1)].into());
    let (text, lost) = written(&[mode]);
    assert_eq!(text, "frequency_hz,damping_ratio\n1,\n");
    let said: Vec<String> = lost.iter().map(ToString::to_string).collect();
    for what in ["residues", "deviations of shapes", "methods and orders"] {
        assert!(
            said.iter().any(|own| own.contains(what)),
            "{what}: {said:?}"
        );
    }
}
