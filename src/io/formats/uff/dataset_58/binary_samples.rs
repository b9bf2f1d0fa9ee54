//! Samples of dataset 58 as bytes: a range of a block, read straight into its numbers.

use std::io::{self, SeekFrom};
use std::ops::Range;

use bytemuck::{AnyBitPattern, NoUninit, cast_slice_mut};
use num_complex::Complex64;

use super::text_samples::TextBlock;
use super::value_width::value_bytes;
use crate::io::{Block, ReadSeek, SampleFormat};

/// Bytes taken from the file at once where they are not the numbers themselves.
const CHUNK_BYTES: usize = 1 << 16;

/// Where the samples of an entry are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::io::formats::uff) enum Samples {
    Binary(BinaryBlock),
    Text(TextBlock),
}

/// A block of bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::io::formats::uff) struct BinaryBlock {
    pub byte: u64,
    pub little_endian: bool,
    pub format: SampleFormat,
    /// Bytes of the abscissa before each value: 0, 4 or 8.
    pub abscissa_bytes: usize,
}

impl BinaryBlock {
    /// Bytes from one value to the next.
    pub fn stride(&self) -> usize {
        self.abscissa_bytes + value_bytes(self.format) as usize
    }

    /// Whether the bytes of a number stand in this machine's order.
    fn is_native(&self) -> bool {
        self.little_endian == cfg!(target_endian = "little")
    }
}

/// A stream of bytes and where it stands, so that reading on needs no search.
pub(in crate::io::formats::uff) struct Input {
    stream: Box<dyn ReadSeek>,
    at: Option<u64>,
}

impl Input {
    pub fn new(stream: Box<dyn ReadSeek>) -> Self {
        Self { stream, at: None }
    }

    /// The bare stream, for whoever moves it.
    pub fn anywhere(&mut self) -> &mut dyn ReadSeek {
        self.at = None;
        self.stream.as_mut()
    }
}

/// Bytes from a place on.
pub(in crate::io::formats::uff) trait ReadAt {
    /// Fills `bytes` from byte `from` on.
    fn read_at(&mut self, from: u64, bytes: &mut [u8]) -> io::Result<()>;
}

impl ReadAt for Input {
    fn read_at(&mut self, from: u64, bytes: &mut [u8]) -> io::Result<()> {
        if self.at.take() != Some(from) {
            self.stream.seek(SeekFrom::Start(from))?;
        }
        self.stream.read_exact(bytes)?;
        self.at = Some(from + bytes.len() as u64);
        Ok(())
    }
}

impl ReadAt for Box<dyn ReadSeek> {
    fn read_at(&mut self, from: u64, bytes: &mut [u8]) -> io::Result<()> {
        self.seek(SeekFrom::Start(from))?;
        self.read_exact(bytes)
    }
}

/// Reads values `range` of a binary block into `block`, whose memory is used again when it has the
/// right kind.
pub(in crate::io::formats::uff) fn read_binary(
    input: &mut Input,
    from: &BinaryBlock,
    range: Range<usize>,
    block: &mut Block,
) -> io::Result<()> {
    let len = range.len();
    match from.format {
        SampleFormat::RealF32 => {
            let mut values = singles(block);
            resize(&mut values, len);
            let read = read_ordinates(input, from, range, &mut values, f32::swapped);
            *block = Block::F32(values);
            read
        }
        SampleFormat::RealF64 => {
            let mut values = doubles(block);
            resize(&mut values, len);
            let read = read_ordinates(input, from, range, &mut values, f64::swapped);
            *block = Block::F64(values);
            read
        }
        SampleFormat::ComplexF64 => {
            let mut values = complex(block);
            resize(&mut values, len);
            let read = read_ordinates(input, from, range, &mut values, Complex64::swapped);
            *block = Block::Complex(values);
            read
        }
        SampleFormat::ComplexF32 => {
            let mut values = complex(block);
            values.clear();
            values.reserve(len);
            let mut pairs = vec![[0f32; 2]; len.min(CHUNK_BYTES / 8)];
            let mut at = range.start;
            while at < range.end {
                let count = pairs.len().min(range.end - at);
                let part = &mut pairs[..count];
                read_ordinates(input, from, at..at + count, part, <[f32; 2]>::swapped)?;
                values.extend(
                    part.iter()
                        .map(|[re, im]| Complex64::new((*re).into(), (*im).into())),
                );
                at += count;
            }
            *block = Block::Complex(values);
            Ok(())
        }
    }
}

fn singles(block: &mut Block) -> Vec<f32> {
    match block {
        Block::F32(values) => std::mem::take(values),
        _ => Vec::new(),
    }
}

fn doubles(block: &mut Block) -> Vec<f64> {
    match block {
        Block::F64(values) => std::mem::take(values),
        _ => Vec::new(),
    }
}

fn complex(block: &mut Block) -> Vec<Complex64> {
    match block {
        Block::Complex(values) => std::mem::take(values),
        _ => Vec::new(),
    }
}

/// Gives a vector its length; new memory comes as zeros from the system, without being written
/// first.
fn resize<T: Clone + Default>(values: &mut Vec<T>, len: usize) {
    if values.capacity() < len {
        *values = vec![T::default(); len];
    } else {
        values.resize(len, T::default());
    }
}

/// A number with its bytes in the opposite order.
trait Swapped {
    fn swapped(self) -> Self;
}

impl Swapped for f32 {
    fn swapped(self) -> Self {
        f32::from_bits(self.to_bits().swap_bytes())
    }
}

impl Swapped for f64 {
    fn swapped(self) -> Self {
        f64::from_bits(self.to_bits().swap_bytes())
    }
}

impl Swapped for Complex64 {
    fn swapped(self) -> Self {
        Complex64::new(self.re.swapped(), self.im.swapped())
    }
}

impl Swapped for [f32; 2] {
    fn swapped(self) -> Self {
        self.map(f32::swapped)
    }
}

/// Reads the ordinates of values `range`.
fn read_ordinates<T: NoUninit + AnyBitPattern>(
    input: &mut Input,
    from: &BinaryBlock,
    range: Range<usize>,
    values: &mut [T],
    swapped: impl Fn(T) -> T,
) -> io::Result<()> {
    if from.abscissa_bytes == 0 {
        let byte = from.byte + (range.start * from.stride()) as u64;
        input.read_at(byte, cast_slice_mut(values))?;
    } else {
        let mut values = values.iter_mut();
        each_pair(input, from, range, |pair| {
            if let Some(value) = values.next() {
                *value = bytemuck::pod_read_unaligned(&pair[from.abscissa_bytes..]);
            }
        })?;
    }
    if !from.is_native() {
        values_in_place(values, swapped);
    }
    Ok(())
}

fn values_in_place<T: Copy>(values: &mut [T], change: impl Fn(T) -> T) {
    for value in values {
        *value = change(*value);
    }
}

/// Reads the abscissae of values `range`.
pub(in crate::io::formats::uff) fn read_abscissa(
    input: &mut impl ReadAt,
    from: &BinaryBlock,
    range: Range<usize>,
    out: &mut Vec<f64>,
) -> io::Result<()> {
    out.clear();
    out.reserve(range.len());
    let little = from.little_endian;
    each_pair(input, from, range, |pair| {
        out.push(match (pair.first_chunk::<8>(), pair.first_chunk::<4>()) {
            (Some(bytes), _) if from.abscissa_bytes == 8 && little => f64::from_le_bytes(*bytes),
            (Some(bytes), _) if from.abscissa_bytes == 8 => f64::from_be_bytes(*bytes),
            (_, Some(bytes)) if little => f32::from_le_bytes(*bytes).into(),
            (_, Some(bytes)) => f32::from_be_bytes(*bytes).into(),
            _ => f64::NAN,
        });
    })
}

/// Goes through abscissa and value of values `range`.
fn each_pair(
    input: &mut impl ReadAt,
    from: &BinaryBlock,
    range: Range<usize>,
    mut take: impl FnMut(&[u8]),
) -> io::Result<()> {
    let stride = from.stride();
    let at_once = CHUNK_BYTES / stride;
    let mut bytes = vec![0; at_once.min(range.len()) * stride];
    let mut at = range.start;
    while at < range.end {
        let count = at_once.min(range.end - at);
        let part = &mut bytes[..count * stride];
        input.read_at(from.byte + (at * stride) as u64, part)?;
        part.chunks_exact(stride).for_each(&mut take);
        at += count;
    }
    Ok(())
}
