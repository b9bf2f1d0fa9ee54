//! NumPy arrays of a structured type, whose fields are arrays.

use std::io::{Cursor, Write};

use modalign::io::Dimension;
use num_complex::Complex64;
use zip::CompressionMethod;
use zip::write::SimpleFileOptions;

use super::containers::{arrays, findings, frf, inspected, values, values_of};

/// An `.npy` file.
pub fn npy(description: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header =
        format!("{{'descr': {description}, 'fortran_order': False, 'shape': {shape}, }}\n");
    let length = (header.len() as u16).to_le_bytes();
    [b"\x93NUMPY\x01\0", &length[..], header.as_bytes(), data].concat()
}

/// An `.npz` file of members, each its name and its bytes.
pub fn npz(method: CompressionMethod, members: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(method);
    for (name, bytes) in members {
        archive.start_file(*name, options).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// Three functions of four lines as `pyuff` reads them.
fn functions() -> Vec<u8> {
    let mut data = Vec::new();
    for function in 0..3_u8 {
        let number = f64::from(function);
        for line in 0..4_u8 {
            data.extend((5.0 + f64::from(line)).to_le_bytes());
        }
        for line in 0..4_u8 {
            data.extend((10.0 * number + f64::from(line)).to_le_bytes());
            data.extend((-number).to_le_bytes());
        }
        for letter in "ab".chars() {
            data.extend(u32::from(letter).to_le_bytes());
        }
        for (node, direction) in [(u64::from(function), 3), (7, -3_i8)] {
            data.extend(node.to_le_bytes());
            data.extend(direction.to_le_bytes());
        }
    }
    let description = "[('abscissa', '<f8', (4,)), ('ordinate', '<c16', (4,)), ('comment', '<U2'), \
                       ('coordinate', [('node', '<u8'), ('direction', '|i1')], (2,))]";
    npy(description, "(3,)", &data)
}

#[test]
fn fields_of_functions_are_arrays_of_an_archive_and_of_a_file() {
    for method in [CompressionMethod::Stored, CompressionMethod::Deflated] {
        let bytes = npz(method, &[("data.npy", &functions())]);
        let ran = inspected("frf.npz", &bytes);
        assert_eq!(ran.code, Some(0), "{ran:?}");
        let expected = [
            "data/abscissa (3 x 4 f64)",
            "data/ordinate (3 x 4 complex f64)",
            "data/comment (3 text)",
            "data/coordinate/node (3 x 2 u64)",
            "data/coordinate/direction (3 x 2 i8)",
        ];
        assert_eq!(arrays(&ran), expected);
        assert!(findings(&ran).is_empty(), "{ran:?}");
        let dimensions = Some(&[Dimension::Channel, Dimension::Sample][..]);
        let read = |column| values_of("frf.npz", &bytes, column, dimensions).unwrap();
        assert_eq!(read("data/abscissa:3"), [5.0, 6.0, 7.0, 8.0]);
        let ordinate = [10.0, 11.0, 12.0, 13.0].map(|re| Complex64::new(re, -1.0));
        let columns = ["data/abscissa:2", "data.ordinate:2"];
        let read_ordinate = frf("frf.npz", &bytes, columns[0], columns[1], dimensions);
        assert_eq!(read_ordinate, ordinate);
        assert_eq!(read("data/coordinate/direction:1"), [3.0, -3.0]);
    }
    let listed = arrays(&inspected("hammer.npy", &functions()));
    assert_eq!(listed[1], "hammer/ordinate (3 x 4 complex f64)");
}

#[test]
fn fields_of_single_values_are_columns_of_one_axis() {
    // Big-endian fields.
    let mut data = Vec::new();
    for line in 0..5_u8 {
        let number = f64::from(line);
        data.extend((20.0 + number).to_be_bytes());
        data.extend((number as f32).to_be_bytes());
        data.extend((-2.0_f32).to_be_bytes());
    }
    let bytes = npy("[('f', '>f8'), ('H', '>c8')]", "(5,)", &data);
    assert_eq!(
        arrays(&inspected("x.npy", &bytes)),
        ["x/f (5 f64)", "x/H (5 complex f32)"]
    );
    let expected: Vec<Complex64> = (0..5_u8)
        .map(|line| Complex64::new(f64::from(line), -2.0))
        .collect();
    assert_eq!(frf("x.npy", &bytes, "x/f", "x/H", None), expected);
}

#[test]
fn padded_and_inner_fields_are_read_and_dates_are_listed() {
    // As `align=True` writes it, with a date and a title.
    let description = "[('mark', '|u1'), ('', '|V7'), ('when', '<M8[ns]'), \
                       ('hit', [(('Force, N', 'force'), '<f8'), ('', '|V8')])]";
    let mut data = Vec::new();
    for row in 0..3_u8 {
        data.extend([row, 1, 2, 3, 4, 5, 6, 7]);
        data.extend([9; 8]);
        data.extend((0.5 * f64::from(row)).to_le_bytes());
        data.extend([8; 8]);
    }
    let bytes = npy(description, "(3, 1)", &data);
    let ran = inspected("hits.npy", &bytes);
    let expected = [
        "hits/mark (3 x 1 u8)",
        "hits/when (3 x 1 date)",
        "hits/hit/force (3 x 1 f64)",
    ];
    assert_eq!(arrays(&ran), expected);
    assert_eq!(findings(&ran), ["array-not-read"]);
    let read = |column| values("hits.npy", &bytes, column).unwrap();
    assert_eq!(read("hits/mark"), [0.0, 1.0, 2.0]);
    assert_eq!(read("hits/hit/force"), [0.0, 0.5, 1.0]);
}

#[test]
fn a_structured_array_that_is_cut_off_is_an_error() {
    let whole = functions();
    let cut = &whole[..whole.len() - 1];
    let error = values("x.npy", cut, "x/coordinate/node:1").unwrap_err();
    assert!(
        error.to_string().contains("the file ends inside"),
        "{error}"
    );
}
