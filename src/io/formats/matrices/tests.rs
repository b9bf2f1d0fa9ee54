//! Matrices from files of every kind, and what is said of damaged ones.

use std::io::{Cursor, Write};
use std::path::PathBuf;

use hdf5_pure::FileBuilder;

use super::{matrix_market, read_matrix};
use crate::io::{IoError, MatrixEntries};

fn market(text: &str) -> Result<MatrixEntries, IoError> {
    matrix_market::read(Cursor::new(text), "k.mtx")
}

/// The matrix of entries in row-major order.
fn full(matrix: &MatrixEntries) -> Vec<f64> {
    let mut full = vec![0.0; matrix.rows * matrix.columns];
    for (row, column, value) in &matrix.entries {
        full[row * matrix.columns + column] += value;
    }
    full
}

#[test]
fn every_kind_of_matrix_market_file_is_read() {
    let cases: [(&str, &[f64]); 7] = [
        (
            "%%MatrixMarket matrix coordinate real general\n% a remark\n\n2 2 3\n1 1 2.5\n2 1 -1D0\n% in between\n2 1 0.5\n",
            &[2.5, 0.0, -0.5, 0.0],
        ),
        (
            "%%MatrixMarket matrix coordinate integer symmetric\r\n2 2 2\r\n1 1 4\r\n2 1 -3\r\n",
            &[4.0, -3.0, -3.0, 0.0],
        ),
        (
            "%%matrixmarket MATRIX Coordinate Double Skew-Symmetric\n2 2 1\n2 1 3",
            &[0.0, -3.0, 3.0, 0.0],
        ),
        (
            "%%MatrixMarket matrix array real general\n2 2\n1\n2\n3\n4\n\n",
            &[1.0, 3.0, 2.0, 4.0],
        ),
        (
            "%%MatrixMarket matrix array real symmetric\n2 2\n1\n2\n4\n",
            &[1.0, 2.0, 2.0, 4.0],
        ),
        (
            "%%MatrixMarket matrix array integer skew-symmetric\n2 2\n5\n",
            &[0.0, -5.0, 5.0, 0.0],
        ),
        (
            "%%MatrixMarket matrix coordinate real general\n2 2 0\n",
            &[0.0; 4],
        ),
    ];
    for (text, expected) in cases {
        let matrix = market(text).expect("the text is a matrix");
        assert_eq!((matrix.rows, matrix.columns), (2, 2));
        assert_eq!(full(&matrix), expected, "{text}");
    }
}

#[test]
fn damage_of_a_matrix_market_file_is_named_with_its_line() {
    let head = "%%MatrixMarket matrix coordinate real symmetric\n% remark\n2 2 2\n1 1 4\n";
    let cases = [
        (
            "%%MatrixMarket matrix coordinate pattern general\n1 1 1\n1 1\n".to_owned(),
            1,
        ),
        (
            "%%MatrixMarket matrix coordinate complex general\n".to_owned(),
            1,
        ),
        (
            "%%MatrixMarket matrix coordinate real hermitian\n".to_owned(),
            1,
        ),
        ("%%MatrixMarket vector array real general\n".to_owned(), 1),
        (
            "%%MatrixMarket matrix array real general\n2 2 2\n".to_owned(),
            2,
        ),
        (
            "%%MatrixMarket matrix array real symmetric\n2 3\n".to_owned(),
            2,
        ),
        (
            "%%MatrixMarket matrix array real general\n1 1\nnan\n".to_owned(),
            3,
        ),
        (head.to_owned() + "3 1 1.0\n", 5),
        (head.to_owned() + "0 1 1.0\n", 5),
        (head.to_owned() + "1 2 1.0\n", 5),
        (head.to_owned() + "2 1\n", 5),
        (head.to_owned() + "2 1 x\n", 5),
        (head.to_owned(), 5),
        (head.to_owned() + "2 1 1.0\n2 2 1.0\n", 6),
    ];
    for (text, expected) in cases {
        let error = market(&text).unwrap_err();
        assert!(
            matches!(&error, IoError::Text { line, path, .. } if *line == expected && path == "k.mtx"),
            "{text}: {error}"
        );
    }
}

/// A folder with one file.
fn file(name: &str, bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder can be made");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("a file can be written");
    (folder, path)
}

/// An array as NumPy writes it.
fn npy(description: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let text =
        format!("{{'descr': '{description}', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes.extend(data);
    bytes
}

fn doubles(values: &[f64]) -> Vec<u8> {
    let data: Vec<u8> = values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    npy("<f8", &format!("({},)", values.len()), &data)
}

fn integers(values: &[i32]) -> Vec<u8> {
    let data: Vec<u8> = values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    npy("<i4", &format!("({},)", values.len()), &data)
}

fn npz(members: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default();
    for (name, bytes) in members {
        archive
            .start_file(format!("{name}.npy"), options)
            .expect("an archive in memory");
        archive.write_all(bytes).expect("an archive in memory");
    }
    archive.finish().expect("an archive in memory").into_inner()
}

/// [1 0 2; 0 0 3] as scipy.sparse writes it.
fn scipy(prefix: &str, format: &str) -> Vec<u8> {
    let name = |part: &str| format!("{prefix}{part}");
    let (first, second, values) = match format {
        "csr" => (
            ("indices", vec![0, 2, 2]),
            ("indptr", vec![0, 2, 3]),
            [1.0, 2.0, 3.0],
        ),
        "csc" => (
            ("indices", vec![0, 0, 1]),
            ("indptr", vec![0, 1, 1, 3]),
            [1.0, 2.0, 3.0],
        ),
        _ => (
            ("row", vec![1, 0, 0]),
            ("col", vec![2, 2, 0]),
            [3.0, 2.0, 1.0],
        ),
    };
    let names = [first.0, second.0, "format", "shape", "data"].map(name);
    let arrays = [
        integers(&first.1),
        integers(&second.1),
        npy("|S3", "()", format.as_bytes()),
        integers(&[2, 3]),
        doubles(&values),
    ];
    let members: Vec<(&str, Vec<u8>)> = names.iter().map(String::as_str).zip(arrays).collect();
    npz(&members)
}

#[test]
fn sparse_matrices_of_scipy_are_read_in_every_layout() {
    for format in ["csr", "csc", "coo"] {
        for (prefix, name) in [("", None), ("K/", Some("K")), ("K/", Some("/K"))] {
            let (_folder, path) = file("k.npz", &scipy(prefix, format));
            let matrix = read_matrix(&path, name).expect("the file holds the matrix");
            assert_eq!((matrix.rows, matrix.columns), (2, 3), "{format}");
            assert_eq!(full(&matrix), [1.0, 0.0, 2.0, 0.0, 0.0, 3.0], "{format}");
        }
    }
    let members = [
        ("data", doubles(&[1.0, 2.0])),
        ("indices", integers(&[0, 1])),
        ("indptr", integers(&[0, 1, 2])),
        ("shape", integers(&[2, 2])),
        ("format", npy("|S3", "()", b"bsr")),
    ];
    let (_folder, path) = file("k.npz", &npz(&members));
    let error = read_matrix(&path, None).unwrap_err().to_string();
    assert!(
        error.contains("\"bsr\"") && error.contains("csr, csc or coo"),
        "{error}"
    );
}

#[test]
fn inconsistent_sparse_arrays_are_refused() {
    let broken: [(&[i32], [i32; 3], f64); 6] = [
        (&[0, 2], [0, 2, 3], 3.0),
        (&[0, 2, 2], [0, 3, 2], 3.0),
        (&[0, 2, 2], [0, 2, 2], 3.0),
        (&[0, 3, 2], [0, 2, 3], 3.0),
        (&[0, -1, 2], [0, 2, 3], 3.0),
        (&[0, 2, 2], [0, 2, 3], f64::NAN),
    ];
    for (indices, indptr, last) in broken {
        let members = [
            ("data", doubles(&[1.0, 2.0, last])),
            ("indices", integers(indices)),
            ("indptr", integers(&indptr)),
            ("shape", integers(&[2, 3])),
        ];
        let (_folder, path) = file("k.npz", &npz(&members));
        let error = read_matrix(&path, None).unwrap_err();
        assert!(
            matches!(error, IoError::Grouping { .. }),
            "{indices:?} {indptr:?}"
        );
    }
}

#[test]
fn arrays_are_found_by_name_and_the_only_one_without() {
    let full_matrix = |values: &[f64]| {
        let data: Vec<u8> = values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        npy("<f8", "(2, 2)", &data)
    };
    let (_folder, path) = file(
        "one.npz",
        &npz(&[("K", full_matrix(&[1.0, 2.0, 0.0, 4.0]))]),
    );
    let matrix = read_matrix(&path, None).expect("the file holds the matrix");
    assert_eq!(matrix.entries, [(0, 0, 1.0), (0, 1, 2.0), (1, 1, 4.0)]);
    let two = [("K", full_matrix(&[1.0; 4])), ("M", full_matrix(&[2.0; 4]))];
    let (_folder, path) = file("two.npz", &npz(&two));
    assert_eq!(
        full(&read_matrix(&path, Some("M")).expect("the file holds the matrix")),
        [2.0; 4]
    );
    for name in [None, Some("C")] {
        let error = read_matrix(&path, name).unwrap_err().to_string();
        assert!(error.contains("K (2 x 2 f64), M (2 x 2 f64)"), "{error}");
    }
    let (_folder, path) = file("v.npy", &doubles(&[1.0, 2.0]));
    let error = read_matrix(&path, Some("v")).unwrap_err().to_string();
    assert!(
        error.contains("shape [2]") && error.contains("two dimensions"),
        "{error}"
    );
    let (_folder, path) = file(
        "k.npz",
        &npz(&[("K", full_matrix(&[1.0, f64::INFINITY, 0.0, 1.0]))]),
    );
    let error = read_matrix(&path, None).unwrap_err().to_string();
    assert!(error.contains("inf at row 0, column 1"), "{error}");
    let (_folder, path) = file("k.txt", b"1 2\n3 4\n");
    let error = read_matrix(&path, None).unwrap_err();
    assert!(matches!(error, IoError::UnknownFormat { .. }), "{error}");
}

#[test]
fn datasets_and_sparse_groups_of_hdf5_are_read() {
    let mut builder = FileBuilder::new();
    let data = builder.create_dataset("M");
    data.with_f64_data(&[2.0, 0.0, 0.0, 3.0])
        .with_shape(&[2, 2]);
    // Columns (5, -1) and (-1, 6) as MATLAB 7.3 keeps a sparse matrix.
    let mut group = builder.create_group("K");
    let data = group.create_dataset("data");
    data.with_f64_data(&[5.0, -1.0, -1.0, 6.0]).with_shape(&[4]);
    let data = group.create_dataset("ir");
    data.with_f64_data(&[0.0, 1.0, 0.0, 1.0]).with_shape(&[4]);
    let data = group.create_dataset("jc");
    data.with_f64_data(&[0.0, 2.0, 4.0]).with_shape(&[3]);
    builder.add_group(group.finish());
    let (_folder, path) = file("model.h5", &builder.finish().expect("a file in memory"));
    let mass = read_matrix(&path, Some("/M")).expect("the file holds the matrix");
    assert_eq!(mass.entries, [(0, 0, 2.0), (1, 1, 3.0)]);
    let stiffness = read_matrix(&path, Some("K")).expect("the file holds the matrix");
    assert_eq!(full(&stiffness), [5.0, -1.0, -1.0, 6.0]);
}

#[test]
fn a_matrix_market_file_is_known_by_its_head() {
    let text = b"%%MatrixMarket matrix array real general\n1 2\n3\n4\n";
    let (_folder, path) = file("k.dat", text);
    let matrix = read_matrix(&path, None).expect("the file holds the matrix");
    assert_eq!((matrix.rows, matrix.columns), (1, 2));
    assert_eq!(full(&matrix), [3.0, 4.0]);
    let error = read_matrix(&path.with_extension("gone"), None).unwrap_err();
    assert!(matches!(error, IoError::System { action: "open", .. }));
}
