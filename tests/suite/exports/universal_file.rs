//! Universal files of one mode at 20 Hz with 1 % damping, changed by each test in one place.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use num_complex::Complex64;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::command::{modalign, write};

/// Natural frequency of the mode, Hz.
pub const FREQUENCY_HZ: f64 = 20.0;
/// Its damping ratio.
pub const DAMPING: f64 = 0.01;
/// Lines from 5 to 40 Hz, 0.25 Hz apart.
pub const LINES: usize = 141;
/// Standard deviation of the noise of each part of an accelerance, (m/s²)/N.
const NOISE: f64 = 1e-4;

/// An end of a function: `NONE 12 -3` is 12:-Z.
#[derive(Clone, Debug)]
pub struct Point {
    pub name: String,
    pub node: i64,
    pub direction: i32,
}

/// What a header says of an axis: specific data type, exponents, label and unit.
#[derive(Clone, Debug)]
pub struct AxisLabel {
    pub data_type: i32,
    pub exponents: [i32; 3],
    pub label: String,
    pub unit: String,
}

/// Values of a function.
#[derive(Clone, Debug)]
pub enum Values {
    Real(Vec<f64>),
    Complex(Vec<Complex64>),
}

/// A function of dataset 58 as text.
#[derive(Clone, Debug)]
pub struct Function {
    pub id_lines: [String; 5],
    pub function_type: i32,
    pub version: i64,
    pub load_case: i64,
    pub response: Point,
    pub reference: Point,
    /// First abscissa and spacing.
    pub axis: (f64, f64),
    /// The abscissae, where they are written beside the values.
    pub uneven: Option<Vec<f64>>,
    pub abscissa: AxisLabel,
    pub ordinate: AxisLabel,
    pub denominator: AxisLabel,
    pub values: Values,
}

impl Point {
    pub fn new(node: i64, direction: i32) -> Self {
        Self {
            name: "NONE".to_owned(),
            node,
            direction,
        }
    }
}

impl AxisLabel {
    pub fn new(data_type: i32, label: &str, unit: &str) -> Self {
        Self {
            data_type,
            exponents: [0; 3],
            label: label.to_owned(),
            unit: unit.to_owned(),
        }
    }

    fn line(&self) -> String {
        let [length, force, temperature] = self.exponents;
        format!(
            "{:>10}{length:>5}{force:>5}{temperature:>5} {:<20} {:<20}",
            self.data_type, self.label, self.unit
        )
    }
}

impl Function {
    /// An accelerance at this node from a hit at 1:+Z.
    pub fn accelerance(node: i64, values: Vec<Complex64>) -> Self {
        Self {
            id_lines: std::array::from_fn(|_| "NONE".to_owned()),
            function_type: 4,
            version: 0,
            load_case: 0,
            response: Point::new(node, 3),
            reference: Point::new(1, 3),
            axis: (5.0, 0.25),
            uneven: None,
            abscissa: AxisLabel::new(18, "Frequency", "Hz"),
            ordinate: AxisLabel::new(12, "Acceleration", "m/s2"),
            denominator: AxisLabel::new(13, "Excit Force", "N"),
            values: Values::Complex(values),
        }
    }

    /// A time record at this node, 256 Hz unless changed; the force is one of data type 13.
    pub fn record(node: i64, is_force: bool, values: Vec<f64>) -> Self {
        let ordinate = match is_force {
            true => AxisLabel::new(13, "Excit Force", "N"),
            false => AxisLabel::new(12, "Acceleration", "m/s2"),
        };
        Self {
            function_type: 1,
            version: 1,
            axis: (0.0, 1.0 / 256.0),
            abscissa: AxisLabel::new(17, "Time", "s"),
            ordinate,
            denominator: AxisLabel::new(0, "NONE", "NONE"),
            values: Values::Real(values),
            ..Self::accelerance(node, Vec::new())
        }
    }

    /// The lines between the delimiters, these too.
    pub fn lines(&self) -> Vec<String> {
        let (is_complex, numbers) = match &self.values {
            Values::Real(values) => (false, values.iter().map(|value| vec![*value]).collect()),
            Values::Complex(values) => {
                let parts = values.iter().map(|value| vec![value.re, value.im]);
                (true, parts.collect::<Vec<_>>())
            }
        };
        let (even, (start, step)) = match self.uneven {
            Some(_) => (0, (0.0, 0.0)),
            None => (1, self.axis),
        };
        let mut lines = vec!["    -1".to_owned(), "    58".to_owned()];
        lines.extend(self.id_lines.iter().map(|line| format!("{line:<80}")));
        let end = |point: &Point| {
            let name = &point.name;
            format!("{name:<10}{:>10}{:>4}", point.node, point.direction)
        };
        lines.push(format!(
            "{:>5}{:>10}{:>5}{:>10} {} {}",
            self.function_type,
            0,
            self.version,
            self.load_case,
            end(&self.response),
            end(&self.reference)
        ));
        let kind = if is_complex { 5 } else { 2 };
        let count = numbers.len();
        lines.push(format!(
            "{kind:>10}{count:>10}{even:>10}{start:>13.5E}{step:>13.5E}{:>13.5E}",
            0.0
        ));
        lines.push(self.abscissa.line());
        lines.push(self.ordinate.line());
        lines.push(self.denominator.line());
        lines.push(AxisLabel::new(0, "NONE", "NONE").line());
        let abscissae = self.uneven.clone().unwrap_or_default();
        let flat: Vec<String> = numbers
            .iter()
            .enumerate()
            .flat_map(|(line, parts)| abscissae.get(line).into_iter().chain(parts))
            .map(|number| printed(*number))
            .collect();
        lines.extend(flat.chunks(6).map(<[String]>::concat));
        lines.push("    -1".to_owned());
        lines
    }

    pub fn text(&self) -> String {
        self.lines().join("\n") + "\n"
    }
}

/// A number of 13 columns, `-1.23457E-02`, as C and Fortran print it.
pub fn printed(number: f64) -> String {
    let text = format!("{number:.5E}");
    let (mantissa, exponent) = text.split_once('E').unwrap();
    let exponent: i32 = exponent.parse().unwrap();
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{:>13}", format!("{mantissa}E{sign}{:02}", exponent.abs()))
}

/// The accelerance of the mode at a frequency, for a residue.
pub fn accelerance_at(frequency_hz: f64, residue: f64) -> Complex64 {
    let (omega, natural) = (TAU * frequency_hz, TAU * FREQUENCY_HZ);
    let stiffness = Complex64::new(
        natural * natural - omega * omega,
        2.0 * DAMPING * natural * omega,
    );
    -omega * omega * residue / stiffness
}

/// An accelerance on these lines with noise.
pub fn noisy_accelerance(frequencies_hz: &[f64], residue: f64, seed: u64) -> Vec<Complex64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut noise = || NOISE * Distribution::<f64>::sample(&StandardNormal, &mut random);
    let values = frequencies_hz.iter().map(|frequency_hz| {
        accelerance_at(*frequency_hz, residue) + Complex64::new(noise(), noise())
    });
    values.collect()
}

/// 5 to 40 Hz by 0.25 Hz.
pub fn even_lines() -> Vec<f64> {
    (0..LINES).map(|line| 5.0 + 0.25 * line as f64).collect()
}

/// Residues of nodes 1, 2 and 3.
pub const RESIDUES: [f64; 3] = [1.0, 0.5, -0.75];

/// Three accelerances of the mode.
pub fn accelerances() -> Vec<Function> {
    let numbered = RESIDUES.iter().zip(1_i64..);
    numbered
        .map(|(residue, node)| {
            let seed = node.unsigned_abs();
            let values = noisy_accelerance(&even_lines(), *residue, seed);
            Function::accelerance(node, values)
        })
        .collect()
}

/// The file of functions.
pub fn file_of(functions: &[Function]) -> String {
    functions.iter().map(Function::text).collect()
}

/// A folder with one file.
pub struct OneFile {
    folder: tempfile::TempDir,
    name: &'static str,
}

impl OneFile {
    pub fn new(name: &'static str, bytes: impl AsRef<[u8]>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(name), bytes).unwrap();
        Self { folder, name }
    }

    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    pub fn path(&self) -> PathBuf {
        self.folder.path().join(self.name)
    }
}

/// The result of a run.
#[derive(Debug)]
pub struct Ran {
    pub code: Option<i32>,
    pub out: String,
    pub error: String,
}

impl Ran {
    /// Standard output as JSON.
    pub fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.out).unwrap_or_else(|error| panic!("{error}: {self:?}"))
    }

    /// The sentences of the findings of a JSON, one text.
    pub fn findings(&self) -> String {
        self.json()["findings"].to_string()
    }
}

/// The program on a file: `verb FILE options...`.
pub fn on_file(verb: &str, file: &Path, options: &[&str]) -> Ran {
    let file = file.to_str().unwrap();
    let arguments = [verb, file].into_iter().chain(options.iter().copied());
    let output = modalign(arguments);
    Ran {
        code: output.status.code(),
        out: String::from_utf8(output.stdout).unwrap(),
        error: String::from_utf8(output.stderr).unwrap(),
    }
}

/// `identify FILE --json` must find the mode alone; the run, for its findings.
pub fn finds_the_mode(file: &Path, options: &[&str]) -> Ran {
    let all: Vec<&str> = ["--json"].iter().chain(options).copied().collect();
    let ran = on_file("identify", file, &all);
    assert!(matches!(ran.code, Some(0 | 1)), "{ran:?}");
    let json = ran.json();
    let modes = json["modes"].as_array().unwrap();
    assert_eq!(modes.len(), 1, "{ran:?}");
    let frequency = modes[0]["frequency_hz"].as_f64().unwrap();
    let damping = modes[0]["damping_ratio"].as_f64().unwrap();
    assert!((frequency - FREQUENCY_HZ).abs() < 2e-3, "{frequency}");
    assert!((damping - DAMPING).abs() < 1e-4, "{damping}");
    ran
}

/// The modes that `run --full` writes for the test `t` of a scene beside a file, and all output.
pub fn modes_of_run(file: &OneFile, scene: &str) -> (serde_json::Value, String) {
    write(file.folder(), &[("scene.toml", scene)]);
    let out = file.folder().join("out");
    let options = ["--full", "-o", out.to_str().unwrap()];
    let ran = on_file("run", file.folder(), &options);
    assert!(matches!(ran.code, Some(0 | 1)), "{ran:?}");
    let modes = crate::command::json(&out.join("t.modes.json"));
    (modes, ran.out + &ran.error)
}
