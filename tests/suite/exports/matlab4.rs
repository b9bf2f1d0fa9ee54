//! MATLAB files of version 4, as `save -v4`, Octave and scipy write them.

use modalign::io::{Confidence, FORMATS};
use num_complex::Complex64;

use super::containers::{arrays, frf, inspected, values};

/// What the numbers of a matrix are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Full = 0,
    Text = 1,
    Sparse = 2,
}

/// A matrix of version 4.
#[derive(Clone, Debug)]
struct Matrix {
    /// IEEE numbers: 0 little endian, 1 big endian; 2 to 4 are VAX and Cray.
    machine: u32,
    /// 0 double, 1 single, 2 to 5 integers of 32, 16, 16 without sign and 8 without sign.
    precision: u32,
    kind: Kind,
    name: &'static str,
    rows: u32,
    columns: u32,
    /// Column after column.
    real: Vec<f64>,
    imaginary: Vec<f64>,
}

impl Matrix {
    fn new(name: &'static str, rows: u32, columns: u32, real: &[f64]) -> Self {
        Self {
            machine: 0,
            precision: 0,
            kind: Kind::Full,
            name,
            rows,
            columns,
            real: real.to_vec(),
            imaginary: Vec::new(),
        }
    }

    fn ordered<const N: usize>(&self, mut bytes: [u8; N]) -> Vec<u8> {
        if matches!(self.machine, 1 | 4) {
            bytes.reverse();
        }
        bytes.to_vec()
    }

    fn number(&self, value: f64) -> Vec<u8> {
        match self.precision {
            0 => self.ordered(value.to_le_bytes()),
            1 => self.ordered((value as f32).to_le_bytes()),
            2 => self.ordered((value as i32).to_le_bytes()),
            3 => self.ordered((value as i16).to_le_bytes()),
            4 => self.ordered((value as u16).to_le_bytes()),
            _ => vec![value as u8],
        }
    }

    fn bytes(&self) -> Vec<u8> {
        let name_bytes = self.name.len() as u32 + 1;
        let kind = self.machine * 1000 + self.precision * 10 + self.kind as u32;
        let is_complex = u32::from(!self.imaginary.is_empty());
        let header = [kind, self.rows, self.columns, is_complex, name_bytes];
        let header = header.map(|word| self.ordered(word.to_le_bytes())).concat();
        let numbers = self.real.iter().chain(&self.imaginary);
        let numbers: Vec<u8> = numbers.flat_map(|value| self.number(*value)).collect();
        [header, self.name.as_bytes().to_vec(), vec![0], numbers].concat()
    }
}

fn file(matrices: &[Matrix]) -> Vec<u8> {
    matrices.iter().flat_map(Matrix::bytes).collect()
}

#[test]
fn a_frequency_axis_and_a_complex_frf_are_read() {
    let lines = 141_u8;
    let frequency: Vec<f64> = (0..lines)
        .map(|line| 5.0 + 0.25 * f64::from(line))
        .collect();
    let real: Vec<f64> = (0..lines).map(|line| f64::from(line).sin()).collect();
    let imaginary: Vec<f64> = (0..lines).map(|line| f64::from(line).cos()).collect();
    for machine in [0, 1] {
        let mut axis = Matrix::new("f", lines.into(), 1, &frequency);
        let mut response = Matrix::new("H", lines.into(), 1, &real);
        response.imaginary = imaginary.clone();
        (axis.machine, response.machine) = (machine, machine);
        let bytes = file(&[axis, response]);
        let ran = inspected("frf.mat", &bytes);
        assert_eq!(ran.code, Some(0), "{ran:?}");
        assert_eq!(arrays(&ran), ["f (141 x 1 f64)", "H (141 x 1 complex f64)"]);
        let pairs = real.iter().zip(&imaginary);
        let expected: Vec<Complex64> = pairs.map(|(re, im)| Complex64::new(*re, *im)).collect();
        assert_eq!(frf("frf.mat", &bytes, "f", "H", None), expected);
        assert_eq!(values("frf.mat", &bytes, "f").unwrap(), frequency);
    }
}

#[test]
fn every_precision_is_read_in_both_byte_orders() {
    let kinds = ["f64", "f32", "i32", "i16", "u16", "u8"];
    for machine in [0, 1] {
        for (precision, kind) in kinds.iter().enumerate() {
            let mut matrix = Matrix::new("channels", 3, 2, &[1.0, 2.0, 3.0, 10.0, 20.0, 30.0]);
            matrix.machine = machine;
            matrix.precision = precision as u32;
            matrix.imaginary = vec![4.0, 5.0, 6.0, 7.0, 8.0, 9.0];
            let bytes = file(&[matrix, Matrix::new("f", 3, 1, &[1.0, 2.0, 3.0])]);
            let ran = inspected("channels.mat", &bytes);
            assert_eq!(arrays(&ran)[0], format!("channels (3 x 2 complex {kind})"));
            let second = frf("channels.mat", &bytes, "f", "channels:2", None);
            let pair = |re: f64, im: f64| Complex64::new(re, im);
            assert_eq!(second, [pair(10.0, 7.0), pair(20.0, 8.0), pair(30.0, 9.0)]);
        }
    }
}

#[test]
fn texts_and_sparse_matrices_stand_beside_numbers() {
    let codes: Vec<f64> = "rows of texts".bytes().map(f64::from).collect();
    let mut text = Matrix::new("title", 1, 13, &codes);
    text.kind = Kind::Text;
    // Rows, columns and values of two entries, then the size of the matrix.
    let triples = [2.0, 1.0, 3.0, 1.0, 2.0, 2.0, 7.5, -1.0, 0.0];
    let mut sparse = Matrix::new("K", 3, 3, &triples);
    sparse.kind = Kind::Sparse;
    let bytes = file(&[text, sparse, Matrix::new("x", 1, 2, &[1.0, 2.0])]);
    let ran = inspected("three.mat", &bytes);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let listed = ["title (text)", "K (3 x 2 sparse)", "x (1 x 2 f64)"];
    assert_eq!(arrays(&ran), listed);
    let second = values("three.mat", &bytes, "K:2").unwrap();
    assert_eq!(second, [-1.0, 0.0, 0.0]);
    assert_eq!(values("three.mat", &bytes, "x").unwrap(), [1.0, 2.0]);
}

#[test]
fn numbers_of_vax_and_cray_are_refused_with_the_remedy() {
    for (machine, named) in [(2, "VAX D"), (3, "VAX G"), (4, "Cray")] {
        let mut matrix = Matrix::new("x", 1, 2, &[1.0, 2.0]);
        matrix.machine = machine;
        let ran = inspected("old.mat", &file(&[matrix]));
        assert_eq!(ran.code, Some(2), "{ran:?}");
        assert!(ran.error.contains(named), "{ran:?}");
        assert!(ran.error.contains("save -v7"), "{ran:?}");
    }
}

#[test]
fn matrices_before_a_cut_are_read_and_the_cut_is_located() {
    let first = Matrix::new("first", 1, 2, &[1.0, 2.0]);
    let second = Matrix::new("second", 1, 3, &[1.0, 2.0, 3.0]);
    let bytes = file(&[first, second]);
    let ran = inspected("cut.mat", &bytes[..bytes.len() - 1]);
    assert_eq!(ran.code, Some(1), "{ran:?}");
    assert_eq!(arrays(&ran), ["first (1 x 2 f64)"]);
    let place = format!("at byte {}", bytes.len() - 1);
    assert!(ran.error.contains(&place), "{ran:?}");
}

#[test]
fn other_bytes_are_not_taken_for_matrices() {
    let format = FORMATS.iter().find(|format| format.name() == "matlab4");
    let format = format.unwrap();
    let whole = file(&[Matrix::new("name", 1, 1, &[1.0])]);
    assert_eq!(format.detect(&whole), Confidence::Certain);
    let mut no_name = whole.clone();
    no_name[20] = b'1';
    let mut no_end = whole.clone();
    no_end[24] = b'x';
    let mut imaginary = whole.clone();
    imaginary[12] = 2;
    let others: [&[u8]; 8] = [
        &[0; 64],
        &whole[..22],
        &no_name,
        &no_end,
        &imaginary,
        b"1.0 2.0 3.0\n4.0 5.0 6.0\n",
        b"MATLAB 5.0 MAT-file, Platform: GLNXA64",
        b"\x89HDF\r\n\x1a\n\0\0\0\0\0\x08\x08\0\x04\0\x10\0",
    ];
    for bytes in others {
        assert_eq!(format.detect(bytes), Confidence::No, "{bytes:?}");
    }
}
