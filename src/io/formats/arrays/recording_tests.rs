//! Containers of arrays as real measurement systems write them, where the folder with them is
//! there.

use std::io::Write;
use std::path::{Path, PathBuf};

use num_complex::Complex64;
use serde_json::Value;

use crate::io::{
    Block, ColumnName, ColumnRole, Dimension, EntryAxis, FunctionType, Hints, Source, TableColumn,
    TableSpec, Window, open_path,
};

/// The folder of recordings; says so when there is none.
fn recordings() -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = ["../shared/data", "../../shared/data"];
    let found = folders
        .map(|folder| root.join(folder))
        .into_iter()
        .find(|path| path.exists());
    if found.is_none() {
        let _ = writeln!(std::io::stderr(), "skipped: no reference data");
    }
    found
}

/// The stated properties of a recording.
fn expected(folder: &Path, name: &str) -> Value {
    let text = std::fs::read_to_string(folder.join("expected.json")).unwrap();
    let all: Value = serde_json::from_str(&text).unwrap();
    all[name].clone()
}

fn column(name: &str, role: ColumnRole) -> TableColumn {
    let column = match name.parse() {
        Ok(number) => ColumnName::Number(number),
        Err(_) => ColumnName::Heading(name.to_owned()),
    };
    TableColumn {
        column,
        role,
        scale: 1.0,
    }
}

fn open(folder: &Path, name: &str, spec: Option<TableSpec>) -> Box<dyn Source> {
    let hints = Hints {
        path: name.to_owned(),
        table: spec,
    };
    let source = open_path(&folder.join(name), &hints, None).unwrap();
    assert!(
        source.catalog().damage.is_empty(),
        "{:?}",
        source.catalog().damage
    );
    source
}

fn response(name: &str) -> TableColumn {
    let role = ColumnRole::Response {
        dof: None,
        unit: "g".parse().unwrap(),
    };
    column(name, role)
}

fn complex(name: &str, point: &str) -> TableColumn {
    let role = ColumnRole::Complex {
        dof: Some(point.parse().unwrap()),
        unit: "(g)/N".parse().unwrap(),
    };
    column(name, role)
}

fn spec(columns: Vec<TableColumn>) -> TableSpec {
    TableSpec {
        columns,
        ..TableSpec::default()
    }
}

fn samples(source: &mut dyn Source, entry: usize) -> Block {
    let len = source.catalog().entries[entry].len();
    let mut block = Block::F64(Vec::new());
    source.read(entry, 0..len, &mut block).unwrap();
    block
}

fn complex_samples(source: &mut dyn Source, entry: usize) -> Vec<Complex64> {
    match samples(source, entry) {
        Block::Complex(values) => values,
        other => panic!("complex: {other:?}"),
    }
}

/// Listed with seven digits.
fn assert_listed(got: f64, listed: &Value) {
    let listed = listed.as_f64().unwrap();
    assert!(
        (got - listed).abs() <= 5.1e-7 * listed.abs() + 1e-15,
        "{got} against {listed}"
    );
}

fn assert_pair(got: Complex64, listed: &Value) {
    assert_listed(got.re, &listed[0]);
    assert_listed(got.im, &listed[1]);
}

fn frequency_axis(source: &dyn Source, entry: usize) -> (f64, f64, usize) {
    match source.catalog().entries[entry].axis {
        EntryAxis::Frequency(axis) => (axis.start_hz, axis.step_hz, axis.len),
        other => panic!("frequency: {other:?}"),
    }
}

#[test]
fn a_beam_whose_frequencies_are_stored_complex_is_read() {
    let Some(folder) = recordings() else { return };
    for name in [
        "beam10-dasp/20201016_01_01.mat",
        "beam10-dasp/20201016_01_10.mat",
    ] {
        let listed = expected(&folder, name);
        let variable = listed["var"].as_str().unwrap();
        let columns = vec![
            column(&format!("{variable}:1"), ColumnRole::Frequency),
            complex(&format!("{variable}:2"), "8:+Z"),
        ];
        let mut source = open(&folder, name, Some(spec(columns)));
        let lines = listed["n"].as_u64().unwrap() as usize;
        let axis = frequency_axis(source.as_ref(), 0);
        assert_eq!((axis.0.to_bits(), axis.2), (0, lines));
        assert_listed(axis.1, &listed["df"]);
        let values = complex_samples(source.as_mut(), 0);
        for (line, pair) in listed["first3"].as_array().unwrap().iter().enumerate() {
            assert_pair(values[line], pair);
        }
        let mut fields = listed.as_object().unwrap().iter();
        let (line, pair) = fields
            .find_map(|(name, pair)| Some((name.strip_prefix("idx_")?, pair)))
            .unwrap();
        let line: usize = line.parse().unwrap();
        assert_pair(values[line], &pair[1]);
        assert_listed(line as f64 * axis.1, &pair[0]);
    }
}

#[test]
fn an_analyser_file_is_listed_and_its_functions_are_read() {
    let Some(folder) = recordings() else { return };
    let name = "signalcalc-aircraft/DPsv00001.mat";
    let listed = expected(&folder, name);
    let all = open(&folder, name, None);
    let arrays = &all.catalog().arrays;
    let kind_of = |name: &str| {
        let info = arrays.iter().find(|info| info.name == name).unwrap();
        (info.kind.clone(), info.shape.clone())
    };
    let lines = listed["n_lines"].as_u64().unwrap() as usize;
    assert_eq!(kind_of("G1_2"), ("complex f64".to_owned(), vec![lines, 2]));
    assert_eq!(kind_of("Unit"), ("text".to_owned(), vec![4]));
    for channel in 2..=4 {
        let columns = vec![
            column(&format!("C1_{channel}:1"), ColumnRole::Frequency),
            complex(&format!("H1_{channel}:2"), "2:+Z"),
            column(
                &format!("C1_{channel}:2"),
                ColumnRole::Coherence { dof: None },
            ),
            complex(&format!("G1_{channel}:2"), "3:+Z"),
        ];
        let mut source = open(&folder, name, Some(spec(columns)));
        let axis = frequency_axis(source.as_ref(), 0);
        assert_eq!(axis.2, lines);
        assert_listed(axis.1, &listed["df"]);
        let h1 = complex_samples(source.as_mut(), 0);
        let pairs = &listed[format!("H1_{channel}_idx_0_1_150")];
        for (place, line) in [0, 1, 150].into_iter().enumerate() {
            assert_pair(h1[line], &pairs[place]);
        }
        let Block::F64(coherence) = samples(source.as_mut(), 1) else {
            panic!("coherence is real")
        };
        assert_listed(coherence[150], &listed[format!("C1_{channel}_idx150")]);
        assert_spectra(&folder, name, channel, &h1, &listed);
    }
}

#[test]
fn the_functions_of_an_analyser_file_are_entries() {
    let Some(folder) = recordings() else { return };
    let name = "signalcalc-aircraft/DPsv00001.mat";
    let listed = expected(&folder, name);
    let mut source = open(&folder, name, None);
    let catalog = source.catalog();
    let frfs: Vec<usize> = (0..catalog.entries.len())
        .filter(|entry| catalog.entries[*entry].function_type == FunctionType::Frf)
        .collect();
    assert_eq!((catalog.entries.len(), frfs.len()), (6, 3));
    for (entry, channel) in frfs.into_iter().zip(2..) {
        let frf = source.catalog().entries[entry].clone();
        let points = [&frf.response, &frf.reference].map(|dof| dof.as_ref().unwrap().to_string());
        assert_eq!(points, [format!("I{channel}:+S"), "I1:+S".to_owned()]);
        assert_eq!(frf.to_si, Some(9.80665));
        assert_eq!(frf.note.window, Some(Window::ForceAndExponential));
        // A time constant of nine tenths of the record.
        let decay_rad_s = frf.note.added_damping_rad_s.unwrap();
        assert!(
            (decay_rad_s * 0.9 * 16.0 - 1.0).abs() < 1e-6,
            "{decay_rad_s}"
        );
        let axis = frequency_axis(source.as_ref(), entry);
        assert_listed(axis.1, &listed["df"]);
        let h1 = complex_samples(source.as_mut(), entry);
        let pairs = &listed[format!("H1_{channel}_idx_0_1_150")];
        for (place, line) in [0, 1, 150].into_iter().enumerate() {
            assert_pair(h1[line], &pairs[place]);
        }
        assert_spectra(&folder, name, channel, &h1, &listed);
    }
}

/// H1 is 2 G1k / G11², because the stored spectrum of the force is an rms value.
fn assert_spectra(folder: &Path, name: &str, channel: usize, h1: &[Complex64], listed: &Value) {
    let columns = vec![
        column(&format!("C1_{channel}:1"), ColumnRole::Frequency),
        complex(&format!("G1_{channel}:2"), "3:+Z"),
        column("G1_1:2", ColumnRole::Coherence { dof: None }),
    ];
    let mut source = open(folder, name, Some(spec(columns)));
    let cross = complex_samples(source.as_mut(), 0);
    let Block::F64(auto) = samples(source.as_mut(), 1) else {
        panic!("an auto spectrum is real")
    };
    let lines = h1.iter().zip(cross.iter().zip(&auto));
    let errors = lines.map(|(h1, (cross, auto))| (2.0 * cross / (auto * auto) - h1).norm());
    let highest = h1.iter().map(|h1| h1.norm()).fold(0.0, f64::max);
    let largest = errors.fold(0.0, f64::max) / highest;
    let bound = listed[format!("max_rel_err_2G_over_G11sq_{channel}")]
        .as_f64()
        .unwrap();
    assert!(largest <= 1.01 * bound, "{largest} against {bound}");
}

#[test]
fn the_last_hit_of_an_analyser_file_is_read() {
    let Some(folder) = recordings() else { return };
    let name = "signalcalc-aircraft/DPsv00001.mat";
    let listed = expected(&folder, name);
    let force = ColumnRole::Force {
        dof: None,
        unit: "N".parse().unwrap(),
    };
    let columns = vec![
        column("X1:1", ColumnRole::Time),
        column("X1:2", force),
        response("X2:2"),
    ];
    let mut source = open(&folder, name, Some(spec(columns)));
    let EntryAxis::Time(axis) = source.catalog().entries[0].axis else {
        panic!("time")
    };
    assert_eq!(axis.len as u64, listed["n_time"].as_u64().unwrap());
    assert_listed(axis.start_s, &listed["t0"]);
    assert_listed(axis.step_s, &listed["dt"]);
    let Block::F64(force) = samples(source.as_mut(), 0) else {
        panic!("a force is real")
    };
    assert_listed(
        force.iter().copied().fold(0.0, f64::max),
        &listed["force_peak"],
    );
}

#[test]
fn hits_of_a_three_dimensional_array_are_read() {
    let Some(folder) = recordings() else { return };
    for name in ["F1", "F2", "F3"] {
        let name = format!("dewesoft-hammer/{name}.npy");
        let listed = expected(&folder, &name);
        let mut spec = spec(vec![response("1"), response("4")]);
        spec.dimensions = Some(vec![Dimension::Hit, Dimension::Channel, Dimension::Sample]);
        spec.sampling_rate_hz = listed["fs_hz"].as_f64();
        let mut source = open(&folder, &name, Some(spec));
        let shape: Vec<usize> = serde_json::from_value(listed["shape"].clone()).unwrap();
        assert_eq!(source.catalog().entries.len(), 2 * shape[0]);
        for hit in 0..shape[0] {
            let Block::F64(force) = samples(source.as_mut(), 2 * hit) else {
                panic!("a force is real")
            };
            assert_eq!(force.len(), shape[2]);
            let peak = (0..force.len())
                .max_by(|a, b| force[*a].total_cmp(&force[*b]))
                .unwrap();
            assert_eq!(Some(peak as u64), listed["force_peak_index"][hit].as_u64());
            assert_listed(force[peak], &listed["force_peak"][hit]);
        }
    }
}

#[test]
fn frequencies_and_shapes_of_a_frame_are_listed() {
    let Some(folder) = recordings() else { return };
    let source = open(&folder, "fourstory-updating/FourStoryStructure.mat", None);
    let listed = source.catalog().arrays.iter();
    let listed: Vec<_> = listed
        .map(|info| (info.name.as_str(), info.shape.as_slice()))
        .collect();
    let shapes: [&[usize]; 2] = [&[4, 1], &[4, 4]];
    assert_eq!(
        listed,
        [("test_frequency", shapes[0]), ("test_mode", shapes[1])]
    );
}
