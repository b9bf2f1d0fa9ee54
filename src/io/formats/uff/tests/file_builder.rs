//! Universal files built from bytes, for tests.

use std::io::Cursor;

use crate::io::formats::uff::Uff;
use crate::io::{Block, Format, Hints, IoError, Source};

/// Path that the tests expect in messages.
pub(super) const PATH: &str = "built.uff";

/// How a built file is written.
#[derive(Clone, Copy, Debug)]
pub(super) struct Form {
    pub newline: &'static str,
    /// Line ends between a binary block and its delimiter.
    pub newline_behind_block: bool,
    pub little_endian: bool,
    /// What the byte count says beyond the truth.
    pub count_error: i64,
}

impl Default for Form {
    fn default() -> Self {
        Self {
            newline: "\n",
            newline_behind_block: false,
            little_endian: true,
            count_error: 0,
        }
    }
}

/// The eleven header lines of an acceleration record at 12:-Z from a hit at 4:+X, 51.2 kHz, hit 3.
pub(in crate::io::formats::uff) fn header(data_type: i32, points: u64) -> Vec<String> {
    [
        "title".to_owned(),
        "NONE".to_owned(),
        "NONE".to_owned(),
        "NONE".to_owned(),
        "NONE".to_owned(),
        "    1         0    3         7 NONE              12  -3 NONE               4   1"
            .to_owned(),
        format!("{data_type:>10}{points:>10}         1  0.00000E+00  1.95313E-05  0.00000E+00"),
        "        17    0    0    0 Time                 s                   ".to_owned(),
        "        12    0    0    0 Acceleration         g                   ".to_owned(),
        "         0    0    0    0 NONE                 NONE                ".to_owned(),
        "         0    0    0    0 NONE                 NONE                ".to_owned(),
    ]
    .to_vec()
}

/// Lines between delimiters.
pub(in crate::io::formats::uff) fn dataset(lines: &[&str], newline: &str) -> Vec<u8> {
    let mut all = vec!["    -1"];
    all.extend(lines);
    all.push("    -1");
    all.iter()
        .flat_map(|line| [line.as_bytes(), newline.as_bytes()].concat())
        .collect()
}

/// A dataset 58 as text.
pub(in crate::io::formats::uff) fn text_58(
    header: &[String],
    rows: &[&str],
    newline: &str,
) -> Vec<u8> {
    let mut lines = vec!["    58"];
    lines.extend(header.iter().map(String::as_str));
    lines.extend(rows);
    dataset(&lines, newline)
}

/// A dataset 58b around a block.
pub(super) fn binary_58(header: &[String], block: &[u8], form: Form) -> Vec<u8> {
    let order = if form.little_endian { 1 } else { 2 };
    let count = block.len() as i64 + form.count_error;
    let first = format!(
        "    58b{order:>6}     2          11{count:>12}     0     0           0           0"
    );
    let mut lines = vec!["    -1".to_owned(), first];
    lines.extend_from_slice(header);
    let mut bytes: Vec<u8> = lines
        .iter()
        .flat_map(|line| [line.as_bytes(), form.newline.as_bytes()].concat())
        .collect();
    bytes.extend_from_slice(block);
    if form.newline_behind_block {
        bytes.extend_from_slice(form.newline.as_bytes());
    }
    bytes.extend_from_slice(b"    -1  ");
    bytes.extend_from_slice(form.newline.as_bytes());
    bytes
}

/// Single-precision numbers as bytes.
pub(in crate::io::formats::uff) fn singles(values: &[f32], little: bool) -> Vec<u8> {
    let bytes = |v: &f32| {
        if little {
            v.to_le_bytes()
        } else {
            v.to_be_bytes()
        }
    };
    values.iter().flat_map(bytes).collect()
}

/// Double-precision numbers as bytes.
pub(in crate::io::formats::uff) fn doubles(values: &[f64], little: bool) -> Vec<u8> {
    let bytes = |v: &f64| {
        if little {
            v.to_le_bytes()
        } else {
            v.to_be_bytes()
        }
    };
    values.iter().flat_map(bytes).collect()
}

/// Opens bytes as a universal file.
pub(in crate::io::formats::uff) fn open(bytes: Vec<u8>) -> Result<Box<dyn Source>, IoError> {
    let hints = Hints {
        path: PATH.to_owned(),
        table: None,
    };
    Uff.open(Box::new(Cursor::new(bytes)), &hints)
}

/// All samples of an entry.
pub(in crate::io::formats::uff) fn all(
    source: &mut dyn Source,
    entry: usize,
) -> Result<Block, IoError> {
    let len = source.catalog().entries[entry].len();
    let mut block = Block::F64(vec![7.0]);
    source.read(entry, 0..len, &mut block)?;
    Ok(block)
}
