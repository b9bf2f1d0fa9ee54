//! Files of Data Physics SignalCalc for MATLAB: FRFs by the names of arrays, with channels that
//! name no points.

use std::path::Path;

use num_complex::Complex64;

use super::inspected::inspect;
use super::universal_file::{
    FREQUENCY_HZ, OneFile, RESIDUES, Ran, even_lines, finds_the_mode, noisy_accelerance, on_file,
};
use crate::command::modalign;

const STANDARD_GRAVITY: f64 = 9.80665;

/// A data element of a MATLAB 5 file.
fn element(kind: u32, bytes: &[u8]) -> Vec<u8> {
    let mut element = [kind.to_le_bytes(), (bytes.len() as u32).to_le_bytes()].concat();
    element.extend(bytes);
    element.resize(element.len().next_multiple_of(8), 0);
    element
}

/// A matrix of two dimensions; the class holds the flags.
fn matrix(class: u32, shape: [usize; 2], name: &str, content: &[Vec<u8>]) -> Vec<u8> {
    let flags = [class.to_le_bytes(), [0; 4]].concat();
    let shape = shape.map(|len| (len as u32).to_le_bytes()).concat();
    let head = [
        element(6, &flags),
        element(5, &shape),
        element(1, name.as_bytes()),
    ];
    element(14, &[head.concat(), content.concat()].concat())
}

fn doubles(values: impl IntoIterator<Item = f64>) -> Vec<u8> {
    let bytes = values.into_iter().flat_map(f64::to_le_bytes);
    element(9, &bytes.collect::<Vec<u8>>())
}

/// A char array of one row for each text.
fn rows(name: &str, texts: &[String]) -> Vec<u8> {
    let width = texts.iter().map(String::len).max().unwrap_or(0);
    let at = |text: &String, column: usize| text.as_bytes().get(column).copied().unwrap_or(0);
    let columns = (0..width).flat_map(|column| texts.iter().map(move |text| at(text, column)));
    let units: Vec<u8> = columns.flat_map(|byte| [byte, 0]).collect();
    matrix(4, [texts.len(), width], name, &[element(4, &units)])
}

/// Frequencies and complex values, in g/N.
fn frf(name: &str, values: &[Complex64]) -> Vec<u8> {
    let lines = even_lines();
    let part = |of: fn(&Complex64) -> f64| values.iter().map(of).map(|v| v / STANDARD_GRAVITY);
    let real = doubles(lines.iter().copied().chain(part(|value| value.re)));
    let zeros = lines.iter().map(|_| 0.0);
    let imaginary = doubles(zeros.chain(part(|value| value.im)));
    matrix(6 | 0x800, [lines.len(), 2], name, &[real, imaginary])
}

fn real(name: &str, axis: &[f64], value: impl Fn(f64) -> f64) -> Vec<u8> {
    let values = axis.iter().map(|place| value(*place));
    let content = doubles(axis.iter().copied().chain(values));
    matrix(6, [axis.len(), 2], name, &[content])
}

/// A hammer at channel 1, accelerometers at channels 2 to 4 and the record of the last hit.
fn file(states_units: bool) -> Vec<u8> {
    let numbers = doubles([1.0, 2.0, 3.0, 4.0]);
    let texts = |texts: [&str; 4]| texts.map(str::to_owned);
    let mut arrays = vec![
        matrix(6, [4, 1], "ChanNum", &[numbers]),
        rows("ChanName", &texts(["I1", "I2", "I3", "I4"])),
    ];
    let mut described = Vec::new();
    for (residue, channel) in RESIDUES.iter().zip(2_u64..) {
        let values = noisy_accelerance(&even_lines(), *residue, channel);
        arrays.push(frf(&format!("H1_{channel}"), &values));
        arrays.push(real(&format!("C1_{channel}"), &even_lines(), |_| 0.999_99));
        described.extend([
            format!("Signal H1_{channel}"),
            "Real/Imag (g)(N)".to_owned(),
            format!("Signal C1_{channel}"),
            "Mag EU ".to_owned(),
        ]);
    }
    if states_units {
        arrays.push(rows("Unit", &texts(["N", "g", "g", "g"])));
        arrays.push(rows("DP_Info", &described));
    }
    let times: Vec<f64> = (0..512).map(|sample| f64::from(sample) / 128.0).collect();
    for channel in 1..=4 {
        arrays.push(real(&format!("X{channel}"), &times, |time| {
            (9.0 * time).sin() + 2.0
        }));
        arrays.push(real(&format!("W{channel}"), &times, |time| {
            (9.0 * time).sin() + 2.0
        }));
    }
    let mut file = b"MATLAB 5.0 MAT-file".to_vec();
    file.resize(124, b' ');
    file.extend([0, 1, b'I', b'M']);
    file.extend(arrays.concat());
    file
}

/// `new FOLDER FILES... OPTIONS...`.
fn new(folder: &Path, files: &[&Path], options: &[&str]) -> Ran {
    let files = files.iter().map(|file| file.to_str().unwrap());
    let files: Vec<&str> = files.chain(options.iter().copied()).collect();
    on_file("new", folder, &files)
}

fn scene_of(folder: &Path) -> String {
    std::fs::read_to_string(folder.join("scene.toml")).unwrap()
}

/// `run FOLDER` must find the mode alone.
fn run_finds_the_mode(folder: &Path) {
    let ran = on_file("run", folder, &["--json"]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let json = ran.json();
    let modes = json["modes"].as_array().unwrap();
    assert_eq!(modes.len(), 1, "{ran:?}");
    let frequency = modes[0]["frequency_hz"].as_f64().unwrap();
    assert!((frequency - FREQUENCY_HZ).abs() < 2e-3, "{frequency}");
}

#[test]
fn a_file_is_inspected_drafted_and_run_without_a_written_line() {
    let file = OneFile::new("DPsv00001.mat", file(true));
    let inspected = inspect(&file);
    assert_eq!(inspected.items("entries").len(), 6, "{inspected:?}");
    assert_eq!(inspected.count_of("last-hit-passed-over"), 1);
    let entry = &inspected.items("entries")[0];
    assert_eq!(
        (&entry["response"], &entry["reference"]),
        (&"I2:+S".into(), &"I1:+S".into())
    );
    finds_the_mode(&file.path(), &[]);
    // A channel is no open line of the draft below.
    let screen = on_file("inspect", &file.path(), &[]).out;
    assert!(!screen.contains("Not stated"), "{screen}");
    assert!(screen.contains("no point: the reference I1:+S"), "{screen}");
    let folder = file.folder().join("scene");
    let drafted = new(&folder, &[&file.path()], &[]);
    assert!(
        drafted.out.contains("nothing is left to fill in"),
        "{drafted:?}"
    );
    run_finds_the_mode(&folder);
}

#[test]
fn files_of_a_roving_test_need_their_points() {
    let first = OneFile::new("DPsv00001.mat", file(true));
    let second = first.folder().join("DPsv00002.mat");
    std::fs::write(&second, file(true)).unwrap();
    let files = [first.path(), second];
    let files: Vec<&Path> = files.iter().map(AsRef::as_ref).collect();
    let open = first.folder().join("open");
    let drafted = new(&open, &files, &[]);
    assert!(drafted.out.contains("--reference DOF"), "{drafted:?}");
    assert_eq!(
        scene_of(&open).matches("reference = \"FILL IN\"").count(),
        2
    );
    let stated = first.folder().join("stated");
    let drafted = new(&stated, &files, &["--reference", "1:+Z,2:+Z"]);
    assert!(
        drafted.out.contains("nothing is left to fill in"),
        "{drafted:?}"
    );
    let scene = scene_of(&stated);
    assert!(scene.contains("reference = \"2:+Z\""), "{scene}");
    run_finds_the_mode(&stated);
    let names = files.iter().map(|file| file.to_str().unwrap());
    let all = modalign(["identify", "--full"].into_iter().chain(names));
    let error = String::from_utf8(all.stderr).unwrap();
    assert!(error.contains("channels-repeated"), "{error}");
    let refused = new(
        &first.folder().join("none"),
        &files,
        &["--response", "1:+Z"],
    );
    assert_eq!(refused.code, Some(2), "{refused:?}");
    assert!(refused.error.contains("I2:+S, I3:+S, I4:+S"), "{refused:?}");
}

#[test]
fn a_missing_unit_is_asked_and_stated() {
    let file = OneFile::new("DPsv00001.mat", file(false));
    let open = file.folder().join("open");
    let drafted = new(&open, &[&file.path()], &[]);
    assert!(
        drafted.out.contains("1 line to be filled in"),
        "{drafted:?}"
    );
    assert!(scene_of(&open).contains("unit = \"FILL IN\""));
    let stated = file.folder().join("stated");
    let drafted = new(&stated, &[&file.path()], &["--unit", "g/N"]);
    assert!(
        drafted.out.contains("nothing is left to fill in"),
        "{drafted:?}"
    );
    run_finds_the_mode(&stated);
}

#[test]
fn columns_that_a_scene_describes_are_read_as_it_says() {
    let file = OneFile::new("DPsv00001.mat", file(true));
    let scene = "schema = \"modalign-scene/1\"\ntitle = \"t\"\n[[test]]\nname = \"t\"\n\
                 files = [\"DPsv00001.mat\"]\naverages = 5\n\
                 [[test.channel]]\ncolumn = \"H1_3:1\"\nrole = \"frequency\"\n\
                 [[test.channel]]\ncolumn = \"H1_3:2\"\nrole = \"complex\"\ndof = \"7:-X\"\n\
                 unit = \"g/N\"\n\
                 [[test.file]]\npath = \"DPsv00001.mat\"\nreference = \"1:+Z\"\n";
    std::fs::write(file.folder().join("scene.toml"), scene).unwrap();
    let frfs = file.folder().join("frfs.uff");
    let converted = on_file("convert", file.folder(), &["-o", frfs.to_str().unwrap()]);
    assert_eq!(converted.code, Some(0), "{converted:?}");
    let modes = finds_the_mode(&frfs, &[]).json();
    assert!(
        modes["modes"][0]["residues"]["7:-X|1:+Z"].is_array(),
        "{modes}"
    );
}
