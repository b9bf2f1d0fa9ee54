//! Archives with a changed byte: the check sum of a member covers all of its values.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use modalign::io::IoError;
use zip::CompressionMethod;

use super::containers::{arrays, inspected, values};
use super::structured_arrays::{npy, npz};

fn doubles(values: &[f64]) -> Vec<u8> {
    values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect()
}

/// Numbers that deflate writes as they are.
fn numbers(first: f64) -> Vec<f64> {
    (0..40_u8)
        .map(|i| first * f64::from(i + 1).sqrt().sin())
        .collect()
}

/// A variable of doubles of a MATLAB file of version 5, deflated.
fn deflated(name: &str, values: &[f64]) -> Vec<u8> {
    let element = |kind: u32, bytes: &[u8]| {
        let mut element = [kind.to_le_bytes(), (bytes.len() as u32).to_le_bytes()].concat();
        element.extend(bytes);
        element.resize(element.len().next_multiple_of(8), 0);
        element
    };
    let word = |value: u32| value.to_le_bytes();
    let content = [
        element(6, &[word(6), word(0)].concat()),
        element(5, &[word(values.len() as u32), word(1)].concat()),
        element(1, name.as_bytes()),
        element(9, &doubles(values)),
    ];
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(&element(14, &content.concat())).unwrap();
    let bytes = encoder.finish().unwrap();
    [&word(15)[..], &word(bytes.len() as u32), &bytes].concat()
}

/// Changes each byte of `changed` in turn: the first array must be read as it was, or be an error
/// with a place in the file, and the second must be read.
fn a_changed_byte_is_no_other_value(
    name: &str,
    whole: &[u8],
    changed: std::ops::Range<usize>,
    first: &[f64],
) {
    assert_eq!(values(name, whole, "first").unwrap(), first);
    for place in changed {
        let mut bytes = whole.to_vec();
        bytes[place] ^= 0x10;
        let damage = match values(name, &bytes, "first") {
            Ok(read) => panic!("byte {place} is read as {read:?}"),
            Err(error) => error,
        };
        let is_located = matches!(damage, IoError::Binary { .. } | IoError::Truncated { .. });
        assert!(is_located, "byte {place}: {damage}");
        let second = values(name, &bytes, "second").unwrap();
        assert_eq!(second, numbers(2.0), "byte {place}");
    }
}

#[test]
fn a_changed_byte_of_an_archive_is_no_other_value() {
    let first = numbers(1.0);
    let member = |values: &[f64]| npy("'<f8'", "(40,)", &doubles(values));
    for method in [CompressionMethod::Stored, CompressionMethod::Deflated] {
        let members = [
            ("first.npy", &member(&first)[..]),
            ("second.npy", &member(&numbers(2.0))),
        ];
        let bytes = npz(method, &members);
        // The values lie before the header of the second member.
        let header = b"PK\x03\x04";
        let second = bytes.windows(4).skip(1).position(|w| w == header).unwrap() + 1;
        a_changed_byte_is_no_other_value("x.npz", &bytes, second - 300..second, &first);
    }
}

#[test]
fn a_changed_byte_of_a_deflated_variable_is_no_other_value() {
    let first = numbers(1.0);
    let mut bytes = b"MATLAB 5.0 MAT-file".to_vec();
    bytes.resize(124, b' ');
    bytes.extend(b"\0\x01IM");
    let variable = deflated("first", &first);
    let end = bytes.len() + variable.len();
    bytes.extend(variable);
    bytes.extend(deflated("second", &numbers(2.0)));
    a_changed_byte_is_no_other_value("x.mat", &bytes, end - 300..end, &first);
}

#[test]
fn an_archive_that_expands_a_thousand_times_is_listed() {
    // 16 MB of zeros in some 16 kB.
    let bytes = npz(
        CompressionMethod::Deflated,
        &[(
            "zeros.npy",
            &npy("'<f8'", "(2000000,)", &vec![0; 16_000_000]),
        )],
    );
    assert!(bytes.len() < 40_000, "{}", bytes.len());
    let ran = inspected("zeros.npz", &bytes);
    assert_eq!(arrays(&ran), ["zeros (2000000 f64)"]);
    // A shape that its bytes cannot fill is refused before memory is asked for.
    let member = npy("'<f8'", "(200000000000,)", &[0; 1000]);
    let bytes = npz(CompressionMethod::Deflated, &[("zeros.npy", &member)]);
    let error = values("zeros.npz", &bytes, "zeros").unwrap_err();
    assert!(matches!(error, IoError::Truncated { .. }), "{error}");
}
