//! PULSE and SignalCalc exports and plain tables of real measurements, from private recordings
//! where they are present.

use std::io::Write;
use std::path::PathBuf;

use num_complex::Complex64;
use serde_json::Value;

use super::vendor_tests::{complex, whole};
use crate::frf::Estimator;
use crate::io::*;
use crate::quantity::Quantity;

fn shared_data() -> Option<PathBuf> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let places = ["../shared/data", "../../shared/data"];
    let found = places
        .iter()
        .map(|place| root.join(place))
        .find(|place| place.is_dir());
    if found.is_none() {
        let _ = std::io::stderr().write_all(b"skipped: no reference data\n");
    }
    found
}

fn expected(data: &std::path::Path) -> Value {
    let text = std::fs::read_to_string(data.join("expected.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn recording(data: &std::path::Path, name: &str, table: Option<TableSpec>) -> Box<dyn Source> {
    let hints = Hints {
        path: name.to_owned(),
        table,
    };
    let source = open_path(&data.join(name), &hints, None).unwrap();
    assert!(
        source.catalog().damage.is_empty(),
        "{:?}",
        source.catalog().damage
    );
    source
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// The value whose key begins so, and the numbers behind that beginning, parted by `_`.
fn keyed<'a>(values: &'a Value, start: &str) -> (Vec<usize>, &'a Value) {
    let mut all = values.as_object().unwrap().iter();
    let found = all.find_map(|(key, value)| Some((key.strip_prefix(start)?, value)));
    let (numbers, value) = found.unwrap_or_else(|| panic!("no key {start}"));
    let numbers = numbers.split('_').map(|text| text.parse().unwrap());
    (numbers.collect(), value)
}

/// The value of a pair `[re, im]` to the digits of the list.
fn assert_near(got: Complex64, pair: &Value) {
    let wanted = Complex64::new(number(&pair[0]), number(&pair[1]));
    assert!(
        (got - wanted).norm() <= 1e-6 * wanted.norm(),
        "{got} {wanted}"
    );
}

#[test]
fn fifteen_recordings_of_a_blade_are_read() {
    let Some(data) = shared_data() else { return };
    let expected = expected(&data);
    let files = expected.as_object().unwrap().iter();
    let files: Vec<_> = files
        .filter(|(name, _)| name.starts_with("pulse-blade/"))
        .collect();
    assert_eq!(files.len(), 15);
    for (name, wanted) in files {
        let mut source = recording(&data, name, None);
        let entry = source.catalog().entries[0].clone();
        assert_eq!(entry.len() as u64, wanted["n"].as_u64().unwrap());
        assert_eq!(entry.unit_label, wanted["unit"].as_str().unwrap());
        assert_eq!(entry.to_si.is_some(), entry.unit_label != "V/N");
        assert!(entry.note.averages.is_some() && entry.note.estimator == Some(Estimator::H1));
        let EntryAxis::Frequency(axis) = entry.axis else {
            panic!()
        };
        assert_eq!(axis.step_hz.to_bits(), number(&wanted["df"]).to_bits());
        assert_eq!(
            axis.hz(axis.len - 1).to_bits(),
            number(&wanted["fmax"]).to_bits()
        );
        let values = complex(source.as_mut(), 0);
        assert_near(values[0], &wanted["first2"][0]);
        assert_near(values[1], &wanted["first2"][1]);
        let (_, peak) = keyed(wanted, "peak_near_");
        let line = axis.nearest(number(&peak[0])).unwrap();
        assert_near(values[line], &peak[1]);
    }
}

#[test]
fn nine_recordings_of_a_beam_are_read() {
    let Some(data) = shared_data() else { return };
    let wanted = expected(&data)["modelab-beam"].clone();
    for file in 1..=wanted["n_files"].as_u64().unwrap() {
        let mut source = recording(&data, &format!("modelab-beam/Hxysv{file:05}.txt"), None);
        let entry = source.catalog().entries[0].clone();
        assert_eq!(entry.function_type, FunctionType::Frf);
        assert_eq!(
            (entry.quantity, entry.to_si),
            (Some(Quantity::Acceleration), Some(1.0))
        );
        // The channels of this test were not placed.
        assert_eq!((&entry.response, &entry.reference), (&None, &None));
        let EntryAxis::Frequency(axis) = entry.axis else {
            panic!()
        };
        assert_eq!(axis.len as u64, wanted["n_lines"].as_u64().unwrap());
        assert_eq!(axis.step_hz.to_bits(), number(&wanted["df"]).to_bits());
        assert_eq!(
            axis.hz(axis.len - 1).to_bits(),
            number(&wanted["fmax"]).to_bits()
        );
        let values = complex(source.as_mut(), 0);
        if file == 1 {
            for (value, pair) in values
                .iter()
                .zip(wanted["file1_first3"].as_array().unwrap())
            {
                assert_near(*value, pair);
            }
        }
        let marked = format!("file{file}_index_");
        let keys = wanted.as_object().unwrap();
        if keys.keys().any(|key| key.starts_with(&marked)) {
            let (indices, pair) = keyed(&wanted, &marked);
            assert_near(values[indices[0]], &pair[1]);
        }
    }
}

/// Columns 1 to 3 of a file of the milling tool, read in these roles without a word on how they are
/// separated.
fn tool(data: &std::path::Path, name: &str, roles: [ColumnRole; 3]) -> Box<dyn Source> {
    let columns = roles
        .into_iter()
        .enumerate()
        .map(|(index, role)| TableColumn {
            column: ColumnName::Number(index + 1),
            role,
            scale: 1.0,
        });
    let spec = TableSpec {
        columns: columns.collect(),
        ..TableSpec::default()
    };
    recording(data, name, Some(spec))
}

#[test]
fn six_recordings_of_a_milling_tool_are_read() {
    let Some(data) = shared_data() else { return };
    let expected = expected(&data);
    let hit = "cutpro-tool/Point1_Channel1_CH1.txt";
    let roles = [
        ColumnRole::Time,
        ColumnRole::Force {
            dof: None,
            unit: "N".parse().unwrap(),
        },
        ColumnRole::Response {
            dof: None,
            unit: "m/s2".parse().unwrap(),
        },
    ];
    let mut source = tool(&data, hit, roles);
    let wanted = &expected[hit];
    let EntryAxis::Time(axis) = source.catalog().entries[0].axis else {
        panic!()
    };
    assert_eq!(axis.len as u64, wanted["shape"][0].as_u64().unwrap());
    // The printed times have seven digits.
    assert!((axis.sampling_rate_hz() / number(&wanted["fs_hz"]) - 1.0).abs() < 1e-6);
    let (Block::F64(force), Block::F64(response)) =
        (whole(source.as_mut(), 0), whole(source.as_mut(), 1))
    else {
        panic!()
    };
    let near = |got: f64, wanted: &Value| {
        let wanted = number(wanted);
        assert!(
            (got - wanted).abs() <= 1e-6 * wanted.abs(),
            "{got} {wanted}"
        );
    };
    let largest = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    near(largest(&force), &wanted["force_peak"]);
    near(
        force[wanted["force_peak_index"].as_u64().unwrap() as usize],
        &wanted["force_peak"],
    );
    near(largest(&response), &wanted["resp_max"]);
    near(
        response.iter().copied().fold(f64::INFINITY, f64::min),
        &wanted["resp_min"],
    );
    near(force[1], &wanted["rows_first2"][1][1]);
    for point in 1..=5 {
        let name = format!("cutpro-tool/Point_{point}_Channel_1_CH1.txt");
        let unit: crate::quantity::FrfUnit = "m/N".parse().unwrap();
        let roles = [
            ColumnRole::Frequency,
            ColumnRole::Real { dof: None, unit },
            ColumnRole::Imaginary { dof: None, unit },
        ];
        let mut source = tool(&data, &name, roles);
        let wanted = &expected[&name];
        let EntryAxis::Frequency(axis) = source.catalog().entries[0].axis else {
            panic!()
        };
        assert_eq!(axis.len as u64, wanted["shape"][0].as_u64().unwrap());
        assert_eq!(axis.step_hz.to_bits(), number(&wanted["df"]).to_bits());
        let values = complex(source.as_mut(), 0);
        let (places, parts) = keyed(wanted, "im_um_per_N_at_");
        let parts = parts.as_array().unwrap();
        assert!(places.len() == parts.len() && !parts.is_empty());
        for (hz, part) in places.into_iter().zip(parts) {
            let line = axis.nearest(hz as f64).unwrap();
            near(1e6 * values[line].im, part);
        }
    }
}
