//! Files of SignalCalc for MATLAB, made here: FRFs, coherences, points, units and windows.

use crate::finding::Code;
use crate::frf::Window;
use crate::io::{Entry, EntryAxis, FunctionType, HitFile, Source, check_stated_points, frf_sets};
use crate::io::{Hints, open_bytes};
use crate::quantity::Quantity;

use super::file_builder::Builder;

const BUILDER: Builder = Builder { big_endian: false };
const LINES: usize = 65;
const STEP_HZ: f64 = 0.5;
const SAMPLES: usize = 512;
const DECAY_RAD_S: f64 = 0.8;

/// A char array of these rows, filled with zero characters as SignalCalc does.
fn rows(name: &str, rows: &[&str]) -> Vec<u8> {
    let width = rows.iter().map(|row| row.len()).max().unwrap_or(0);
    let character = |row: &str, column: usize| row.as_bytes().get(column).copied().unwrap_or(0);
    let columns = (0..width).flat_map(|column| rows.iter().map(move |row| character(row, column)));
    let units: Vec<u8> = columns.flat_map(|byte| [byte, 0]).collect();
    let shape = [rows.len() as u32, width as u32];
    BUILDER.matrix(4, &shape, name, &[BUILDER.element(4, &units)])
}

fn doubles(values: &[f64]) -> Vec<u8> {
    let bytes: Vec<u8> = values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    BUILDER.element(9, &bytes)
}

fn frequencies() -> Vec<f64> {
    (0..LINES).map(|line| line as f64 * STEP_HZ).collect()
}

/// An FRF of `gain` + i `line`.
fn frf(name: &str, gain: f64) -> Vec<u8> {
    let real = [frequencies(), vec![gain; LINES]].concat();
    let lines = (0..LINES).map(|line| line as f64);
    let imaginary: Vec<f64> = std::iter::repeat_n(0.0, LINES).chain(lines).collect();
    let shape = [LINES as u32, 2];
    BUILDER.matrix(
        6 | 0x800,
        &shape,
        name,
        &[doubles(&real), doubles(&imaginary)],
    )
}

fn coherence(name: &str, value: f64) -> Vec<u8> {
    let values = [frequencies(), vec![value; LINES]].concat();
    BUILDER.doubles(&[LINES as u32, 2], name, &values)
}

/// A record of single precision, times a window.
fn record(name: &str, window: impl Fn(f64) -> f64) -> Vec<u8> {
    let times: Vec<f64> = (0..SAMPLES).map(|n| (n as f64 - 10.0) / 256.0).collect();
    let values = times.iter().map(|time| {
        let value = f64::from((40.0 * time).sin() as f32 + 0.2);
        f64::from((value * window(time - times[0])) as f32)
    });
    let values: Vec<f64> = times.iter().copied().chain(values).collect();
    BUILDER.doubles(&[SAMPLES as u32, 2], name, &values)
}

fn exponential(time_s: f64) -> f64 {
    (-DECAY_RAD_S * time_s).exp()
}

fn forced(time_s: f64) -> f64 {
    if time_s < 0.2 {
        exponential(time_s)
    } else {
        0.0
    }
}

fn channels(names: &[&str]) -> Vec<Vec<u8>> {
    let numbers: Vec<f64> = (1..=names.len()).map(|number| number as f64).collect();
    vec![
        BUILDER.doubles(&[names.len() as u32, 1], "ChanNum", &numbers),
        rows("ChanName", names),
    ]
}

fn open(elements: &[Vec<u8>]) -> Box<dyn Source> {
    let hints = Hints {
        path: "sv.mat".to_owned(),
        ..Hints::default()
    };
    open_bytes(BUILDER.file(elements), &hints).unwrap()
}

fn pairs(source: &dyn Source, wanted: FunctionType) -> Vec<String> {
    let entries = source.catalog().entries.iter();
    let entries = entries.filter(|entry| entry.function_type == wanted);
    let text = |entry: &Entry| {
        let dof = |dof: &Option<crate::dof::Dof>| dof.as_ref().unwrap().to_string();
        format!("{}|{}", dof(&entry.response), dof(&entry.reference))
    };
    entries.map(text).collect()
}

/// Two channels: hammer and accelerometer.
fn two_channels() -> Vec<Vec<u8>> {
    let mut elements = channels(&["I1", "I2"]);
    elements.push(rows("Unit", &["N", "g"]));
    elements.push(rows(
        "DP_Info",
        &["Signal C1_2", "Mag EU ", "Signal H1_2", "Real/Imag (g)(N)"],
    ));
    elements.push(record("X1", |_| 1.0));
    elements.push(record("W1", forced));
    // The coherence stands before its FRF.
    elements.push(coherence("C1_2", 0.75));
    elements.push(record("W2", exponential));
    elements.push(record("X2", |_| 1.0));
    elements.push(frf("H1_2", 3.0));
    elements
}

#[test]
fn frfs_and_coherences_are_entries_and_records_stay_arrays() {
    let source = open(&two_channels());
    let catalog = source.catalog();
    assert_eq!(pairs(source.as_ref(), FunctionType::Frf), ["I2:+S|I1:+S"]);
    assert_eq!(
        pairs(source.as_ref(), FunctionType::Coherence),
        ["I2:+S|I1:+S"]
    );
    let names: Vec<&str> = catalog
        .arrays
        .iter()
        .map(|array| array.name.as_str())
        .collect();
    assert_eq!(
        names,
        [
            "ChanNum", "ChanName", "Unit", "DP_Info", "X1", "W1", "W2", "X2"
        ]
    );
    let entry = &catalog.entries[1];
    let EntryAxis::Frequency(axis) = entry.axis else {
        panic!("{:?}", entry.axis)
    };
    assert_eq!(
        (axis.len, axis.step_hz.to_bits()),
        (LINES, STEP_HZ.to_bits())
    );
    assert_eq!(entry.quantity, Some(Quantity::Acceleration));
    assert_eq!(entry.denominator, Some(Quantity::Force));
    let passed_over = |code| catalog.findings.iter().filter(|f| f.code == code).count();
    assert_eq!(passed_over(Code::LastHitPassedOver), 1);
    let sets = frf_sets(&mut [HitFile::new(source)]).unwrap();
    let value = sets[0].values(0)[4] / 9.80665;
    assert!((value - num_complex::Complex64::new(3.0, 4.0)).norm() < 1e-12);
    assert!((sets[0].coherence(0).unwrap()[4] - 0.75).abs() < 1e-12);
}

#[test]
fn the_window_of_the_records_is_stated() {
    let note_of = |elements: &[Vec<u8>]| open(elements).catalog().entries[1].note.clone();
    let note = note_of(&two_channels());
    assert_eq!(note.window, Some(Window::ForceAndExponential));
    assert!((note.added_damping_rad_s.unwrap() / DECAY_RAD_S - 1.0).abs() < 1e-6);
    assert!((note.record_s.unwrap() - 2.0).abs() < 1e-12);
    let with = |name: &str, window: fn(f64) -> f64| {
        let mut elements = two_channels();
        elements[7] = record(name, window);
        note_of(&elements)
    };
    let none = with("W2", |_| 1.0);
    assert_eq!(
        (none.window, none.added_damping_rad_s),
        (Some(Window::Force), None)
    );
    let hann = with("W2", |time| {
        (std::f64::consts::PI * time / 2.0).sin().powi(2)
    });
    assert_eq!((hann.window, hann.added_damping_rad_s), (None, None));
    let missing = with("V2", exponential);
    assert_eq!((missing.window, missing.record_s), (None, None));
}

#[test]
fn functions_of_several_references_have_their_points_and_one_decay_rate() {
    let mut elements = Vec::new();
    for reference in 1..=3 {
        for response in [4, 5] {
            let gain = f64::from(10 * reference + response);
            elements.push(frf(&format!("H{reference}_{response}"), gain));
        }
    }
    for channel in 1..=5 {
        elements.push(record(&format!("X{channel}"), |_| f64::from(channel)));
        elements.push(record(&format!("W{channel}"), |t| {
            f64::from(channel) * exponential(t)
        }));
    }
    elements.extend(channels(&["1+X", "2 -Y", "wing.3:+Z", "4-Z", "tip"]));
    elements.push(rows("Unit", &["N", "N", "N", "m/s2", "g"]));
    let source = open(&elements);
    let expected = [
        "4:-Z|1:+X",
        "tip:+S|1:+X",
        "4:-Z|2:-Y",
        "tip:+S|2:-Y",
        "4:-Z|wing.3:+Z",
        "tip:+S|wing.3:+Z",
    ];
    assert_eq!(pairs(source.as_ref(), FunctionType::Frf), expected);
    let catalog = source.catalog();
    let channels = catalog
        .entries
        .iter()
        .map(|entry| entry.response_is_channel);
    assert_eq!(
        channels.collect::<Vec<_>>(),
        [false, true, false, true, false, true]
    );
    assert!(
        catalog
            .entries
            .iter()
            .all(|entry| !entry.reference_is_channel)
    );
    let stated = "9:+Z".parse().unwrap();
    assert!(check_stated_points(catalog, Some(&stated), None).is_ok());
    let sets = frf_sets(&mut [HitFile::new(source)]).unwrap();
    assert_eq!((sets.len(), sets[0].functions().len()), (1, 6));
    assert!((sets[0].values(3)[0].re - 25.0 * 9.80665).abs() < 1e-9);
}

#[test]
fn unusable_names_give_numbers_and_missing_units_stay_open() {
    for names in [&["hammer", "hammer"], &["hammer", ""], &["hammer", "a b"]] {
        let mut elements = channels(names);
        elements.push(frf("H1_2", 1.0));
        let source = open(&elements);
        assert_eq!(pairs(source.as_ref(), FunctionType::Frf), ["2:+S|1:+S"]);
        let entry = &source.catalog().entries[0];
        assert_eq!((entry.quantity, entry.to_si), (None, None));
    }
}

#[test]
fn a_point_stated_for_several_channels_is_an_error() {
    let mut elements = two_channels();
    elements.push(frf("H1_3", 1.0));
    let source = open(&elements);
    let stated = "9:+Z".parse().unwrap();
    assert!(check_stated_points(source.catalog(), None, Some(&stated)).is_ok());
    let error = check_stated_points(source.catalog(), Some(&stated), None).unwrap_err();
    assert!(
        error.to_string().contains("9:+Z for the channels"),
        "{error}"
    );
}

#[test]
fn files_of_the_same_channels_are_reported_unless_points_are_stated() {
    let files = |references: [Option<&str>; 2]| {
        let file = |reference: Option<&str>| HitFile {
            reference: reference.map(|text| text.parse().unwrap()),
            ..HitFile::new(open(&two_channels()))
        };
        frf_sets(&mut references.map(file)).unwrap().remove(0)
    };
    let is_reported = |set: &crate::FrfSet| {
        let mut findings = set.findings.iter();
        findings.any(|finding| finding.code == Code::ChannelsRepeated)
    };
    assert!(is_reported(&files([None, None])));
    let stated = files([Some("1:+Z"), Some("2:+Z")]);
    assert!(!is_reported(&stated));
    assert_eq!(stated.functions()[1].reference.to_string(), "2:+Z");
}

#[test]
fn names_alone_make_no_signalcalc_file() {
    let source = open(&[frf("H1_2", 1.0), coherence("C1_2", 0.5)]);
    assert!(source.catalog().entries.is_empty());
    assert_eq!(source.catalog().arrays.len(), 2);
}
