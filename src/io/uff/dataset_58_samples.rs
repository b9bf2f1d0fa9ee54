//! Samples of dataset 58: a range of a binary block by seeking, or the numbers of a text block.

use std::io::{self, SeekFrom};
use std::ops::Range;

use num_complex::Complex64;

use super::fields::{FieldError, Position, data_row};
use super::lines::LineReader;
use crate::io::{Block, IoError, ReadSeek, SampleFormat};

/// Bytes taken from the file at once; a multiple of the largest value's 16 bytes.
const CHUNK_BYTES: usize = 1 << 20;

/// Where the samples of an entry are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Samples {
    Binary(BinaryBlock),
    Text(TextBlock),
}

/// A block of bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct BinaryBlock {
    pub byte: u64,
    pub little_endian: bool,
    pub format: SampleFormat,
}

/// Lines of numbers up to the delimiter at byte `end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TextBlock {
    pub at: Position,
    pub end: u64,
    pub format: SampleFormat,
    pub points: u64,
}

/// Bytes of one value.
pub(super) fn value_bytes(format: SampleFormat) -> u64 {
    match format {
        SampleFormat::RealF32 => 4,
        SampleFormat::RealF64 | SampleFormat::ComplexF32 => 8,
        SampleFormat::ComplexF64 => 16,
    }
}

/// Numbers of one value: a real one, or real and imaginary part.
pub(super) fn numbers_per_value(format: SampleFormat) -> u64 {
    match format {
        SampleFormat::RealF32 | SampleFormat::RealF64 => 1,
        SampleFormat::ComplexF32 | SampleFormat::ComplexF64 => 2,
    }
}

/// Reads values `range` of a binary block.
pub(super) fn read_binary(
    input: &mut dyn ReadSeek,
    from: &BinaryBlock,
    range: Range<usize>,
    block: &mut Block,
) -> io::Result<()> {
    let size = value_bytes(from.format) as usize;
    let mut left = range.len() * size;
    empty(block, from.format);
    input.seek(SeekFrom::Start(from.byte + (range.start * size) as u64))?;
    let mut buffer = vec![0; left.min(CHUNK_BYTES)];
    while left > 0 {
        let chunk = &mut buffer[..left.min(CHUNK_BYTES)];
        input.read_exact(chunk)?;
        decode(chunk, from, block);
        left -= chunk.len();
    }
    Ok(())
}

/// Empties a block, keeping its memory when it already has the right kind.
fn empty(block: &mut Block, format: SampleFormat) {
    match (&mut *block, format) {
        (Block::F32(values), SampleFormat::RealF32) => values.clear(),
        (Block::F64(values), SampleFormat::RealF64) => values.clear(),
        (Block::Complex(values), SampleFormat::ComplexF32 | SampleFormat::ComplexF64) => {
            values.clear();
        }
        (_, SampleFormat::RealF32) => *block = Block::F32(Vec::new()),
        (_, SampleFormat::RealF64) => *block = Block::F64(Vec::new()),
        _ => *block = Block::Complex(Vec::new()),
    }
}

fn decode(bytes: &[u8], from: &BinaryBlock, block: &mut Block) {
    let little = from.little_endian;
    match block {
        Block::F32(values) => values.extend(singles(bytes, little)),
        Block::F64(values) => values.extend(doubles(bytes, little)),
        Block::Complex(values) if from.format == SampleFormat::ComplexF32 => {
            let numbers: Vec<f64> = singles(bytes, little).map(f64::from).collect();
            values.extend(pairs(&numbers));
        }
        Block::Complex(values) => {
            let numbers: Vec<f64> = doubles(bytes, little).collect();
            values.extend(pairs(&numbers));
        }
    }
}

fn singles(bytes: &[u8], little: bool) -> impl Iterator<Item = f32> + '_ {
    let decode = if little {
        f32::from_le_bytes
    } else {
        f32::from_be_bytes
    };
    bytes.as_chunks::<4>().0.iter().map(move |b| decode(*b))
}

fn doubles(bytes: &[u8], little: bool) -> impl Iterator<Item = f64> + '_ {
    let decode = if little {
        f64::from_le_bytes
    } else {
        f64::from_be_bytes
    };
    bytes.as_chunks::<8>().0.iter().map(move |b| decode(*b))
}

fn pairs(numbers: &[f64]) -> impl Iterator<Item = Complex64> + '_ {
    let pairs = numbers.as_chunks::<2>().0.iter();
    pairs.map(|[re, im]| Complex64::new(*re, *im))
}

/// Copies values `range` of a text block that [`read_text`] has read.
pub(super) fn copy_text(
    numbers: &[f64],
    format: SampleFormat,
    range: Range<usize>,
    block: &mut Block,
) {
    let per_value = numbers_per_value(format) as usize;
    let part = &numbers[range.start * per_value..range.end * per_value];
    let kind = match per_value {
        1 => SampleFormat::RealF64,
        _ => SampleFormat::ComplexF64,
    };
    empty(block, kind);
    match block {
        Block::Complex(values) => values.extend(pairs(part)),
        Block::F64(values) => values.extend_from_slice(part),
        Block::F32(_) => {}
    }
}

/// Reads all numbers of a text block; numbers too many stay behind the others when they merely fill the last row.
///
/// # Errors
/// [`IoError`] with the line of a text that is not a number, or of the end when there are too few or too many.
pub(super) fn read_text(
    input: &mut dyn ReadSeek,
    from: &TextBlock,
    path: &str,
) -> Result<Vec<f64>, IoError> {
    let wanted = (from.points * numbers_per_value(from.format)) as usize;
    let width = match from.format {
        SampleFormat::RealF32 | SampleFormat::ComplexF32 => 13,
        SampleFormat::RealF64 | SampleFormat::ComplexF64 => 20,
    };
    let system = |source| IoError::System {
        path: path.to_owned(),
        action: "read",
        source,
    };
    let mut lines = LineReader::between(input, from.at, from.end).map_err(system)?;
    let mut numbers = Vec::with_capacity(wanted);
    let (mut line, mut complete) = (Vec::new(), wanted == 0);
    while let Some(at) = lines.read_line(&mut line).map_err(system)? {
        let before = numbers.len();
        data_row(&line, width, &mut numbers).map_err(|got| {
            let expected = "a number".to_owned();
            let what = "sample of dataset 58";
            FieldError {
                at,
                what,
                got,
                expected,
            }
            .in_file(path)
        })?;
        if complete && numbers.len() > before {
            return Err(
                wrong_count(at, wanted, format!("{} or more", numbers.len())).in_file(path),
            );
        }
        complete = numbers.len() >= wanted;
    }
    if numbers.len() < wanted {
        let got = numbers.len().to_string();
        return Err(wrong_count(lines.position(), wanted, got).in_file(path));
    }
    Ok(numbers)
}

fn wrong_count(at: Position, wanted: usize, got: String) -> FieldError {
    FieldError {
        at,
        what: "number of numbers of dataset 58",
        got,
        expected: format!("{wanted} (from the number of points)"),
    }
}
