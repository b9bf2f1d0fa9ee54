//! Bytes of numeric arrays: widths, byte orders, and the two orders of elements.

use std::collections::VecDeque;
use std::ops::Range;

use num_complex::Complex64;

use super::Elements;
use crate::io::IoError;

/// How one real number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::io) enum NumberType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F16,
    F32,
    F64,
}

impl NumberType {
    /// Bytes of a number.
    pub fn size(self) -> usize {
        match self {
            NumberType::I8 | NumberType::U8 => 1,
            NumberType::I16 | NumberType::U16 | NumberType::F16 => 2,
            NumberType::I32 | NumberType::U32 | NumberType::F32 => 4,
            NumberType::I64 | NumberType::U64 | NumberType::F64 => 8,
        }
    }

    /// The name for lists of arrays.
    pub fn name(self) -> &'static str {
        match self {
            NumberType::I8 => "i8",
            NumberType::U8 => "u8",
            NumberType::I16 => "i16",
            NumberType::U16 => "u16",
            NumberType::I32 => "i32",
            NumberType::U32 => "u32",
            NumberType::I64 => "i64",
            NumberType::U64 => "u64",
            NumberType::F16 => "f16",
            NumberType::F32 => "f32",
            NumberType::F64 => "f64",
        }
    }
}

/// Decodes numbers of one width; bytes of a number that is cut off are passed over.
macro_rules! numbers {
    ($bytes:expr, $big_endian:expr, $stored:ty, $number:ty, $convert:expr) => {{
        const SIZE: usize = size_of::<$stored>();
        let (chunks, _) = $bytes.as_chunks::<SIZE>();
        let convert: fn($stored) -> $number = $convert;
        let values = chunks.iter().map(|chunk| match $big_endian {
            true => convert(<$stored>::from_be_bytes(*chunk)),
            false => convert(<$stored>::from_le_bytes(*chunk)),
        });
        values.collect()
    }};
}

/// Numbers of bytes: single precision stays single, everything else becomes double.
pub(in crate::io) fn decode(bytes: &[u8], number: NumberType, big_endian: bool) -> Elements {
    let doubles: Vec<f64> = match number {
        NumberType::F32 => {
            return Elements::F32(numbers!(bytes, big_endian, f32, f32, |v| v));
        }
        NumberType::F64 => numbers!(bytes, big_endian, f64, f64, |v| v),
        NumberType::F16 => numbers!(bytes, big_endian, u16, f64, half),
        NumberType::I8 => numbers!(bytes, big_endian, i8, f64, f64::from),
        NumberType::U8 => numbers!(bytes, big_endian, u8, f64, f64::from),
        NumberType::I16 => numbers!(bytes, big_endian, i16, f64, f64::from),
        NumberType::U16 => numbers!(bytes, big_endian, u16, f64, f64::from),
        NumberType::I32 => numbers!(bytes, big_endian, i32, f64, f64::from),
        NumberType::U32 => numbers!(bytes, big_endian, u32, f64, f64::from),
        NumberType::I64 => numbers!(bytes, big_endian, i64, f64, |v| v as f64),
        NumberType::U64 => numbers!(bytes, big_endian, u64, f64, |v| v as f64),
    };
    Elements::F64(doubles)
}

/// Complex numbers, each stored as real and imaginary part.
pub(in crate::io) fn decode_pairs(bytes: &[u8], part: NumberType, big_endian: bool) -> Elements {
    let parts = doubles(decode(bytes, part, big_endian));
    let (pairs, _) = parts.as_chunks::<2>();
    Elements::Complex(
        pairs
            .iter()
            .map(|[re, im]| Complex64::new(*re, *im))
            .collect(),
    )
}

/// Numbers in double precision; nothing for complex numbers and texts.
pub(in crate::io) fn doubles(elements: Elements) -> Vec<f64> {
    match elements {
        Elements::F64(values) => values,
        Elements::F32(values) => values.into_iter().map(f64::from).collect(),
        Elements::Complex(_) | Elements::Text(_) => Vec::new(),
    }
}

/// A number of 16 bits (IEEE 754 binary16): sign, 5 bits of exponent with bias 15, 10 bits of
/// fraction.
fn half(bits: u16) -> f64 {
    let fraction = f64::from(bits & 0x3ff) / 1024.0;
    let magnitude = match (bits >> 10) & 0x1f {
        0 => fraction * 2_f64.powi(-14),
        31 if bits & 0x3ff == 0 => f64::INFINITY,
        31 => f64::NAN,
        exponent => (1.0 + fraction) * 2_f64.powi(i32::from(exponent) - 15),
    };
    if bits & 0x8000 == 0 {
        magnitude
    } else {
        -magnitude
    }
}

/// Elements with the first index running fastest, turned so that the last one does. The other way
/// round with the shape reversed.
pub(in crate::io) fn to_row_major(elements: Elements, shape: &[usize]) -> Elements {
    groups_to_row_major(elements, shape, 1)
}

/// As [`to_row_major`] for groups of so many elements, which stay together.
pub(in crate::io) fn groups_to_row_major(
    elements: Elements,
    shape: &[usize],
    group: usize,
) -> Elements {
    if shape.iter().filter(|len| **len != 1).count() <= 1 {
        return elements;
    }
    match elements {
        Elements::F32(values) => Elements::F32(turned(&values, shape, group)),
        Elements::F64(values) => Elements::F64(turned(&values, shape, group)),
        Elements::Complex(values) => Elements::Complex(turned(&values, shape, group)),
        Elements::Text(values) => Elements::Text(turned(&values, shape, group)),
    }
}

fn turned<T: Clone>(values: &[T], shape: &[usize], group: usize) -> Vec<T> {
    let mut strides = Vec::with_capacity(shape.len());
    let mut stride = 1;
    for len in shape {
        strides.push(stride);
        stride *= len;
    }
    let mut index = vec![0; shape.len()];
    let mut place = 0;
    let mut out = Vec::with_capacity(values.len());
    for _ in 0..values.len().checked_div(group).unwrap_or(0) {
        out.extend_from_slice(&values[place * group..(place + 1) * group]);
        for dimension in (0..shape.len()).rev() {
            index[dimension] += 1;
            place += strides[dimension];
            if index[dimension] < shape[dimension] {
                break;
            }
            place -= strides[dimension] * shape[dimension];
            index[dimension] = 0;
        }
    }
    out
}

/// Number of elements of a shape, when it can be counted. The lengths beside a 0 must be countable,
/// too: callers multiply some of them.
pub(in crate::io) fn count(shape: &[usize]) -> Option<usize> {
    let product = |product: usize, len: &usize| product.checked_mul(*len);
    let others = shape.iter().filter(|len| **len > 0).try_fold(1, product)?;
    Some(if shape.contains(&0) { 0 } else { others })
}

/// Elements of an array from `start` on, in row-major order.
pub(in crate::io) struct Window {
    /// Place of the first one.
    pub start: usize,
    /// The elements.
    pub elements: Elements,
}

impl Window {
    fn part(&self, range: &Range<usize>) -> Option<Elements> {
        let start = range.start.checked_sub(self.start)?;
        self.elements
            .part(start..range.end.checked_sub(self.start)?)
    }
}

/// A cache of the parts read last of the arrays used last, for formats that cannot read part of an
/// array separately.
#[derive(Default)]
pub(in crate::io) struct RecentArrays {
    /// Arrays by their index; the one that was asked for last stands last.
    kept: VecDeque<(usize, Window)>,
    /// More than [`ALWAYS_KEPT`] are kept while all of them take no more bytes.
    most: usize,
}

/// So many arrays are kept whatever their size: real and imaginary part of the samples that are
/// being read.
const ALWAYS_KEPT: usize = 2;

/// All arrays that are kept take at most so many times the file's size, and 1 MiB.
const TIMES_KEPT: u64 = 4;

/// Bytes that elements take.
fn memory(elements: &Elements) -> usize {
    match elements {
        Elements::F32(values) => size_of_val(values.as_slice()),
        Elements::F64(values) => size_of_val(values.as_slice()),
        Elements::Complex(values) => size_of_val(values.as_slice()),
        Elements::Text(values) => {
            let characters = values.iter().map(String::len).sum::<usize>();
            size_of_val(values.as_slice()).saturating_add(characters)
        }
    }
}

impl RecentArrays {
    /// For arrays of a file of so many bytes.
    pub fn new(file_bytes: u64) -> Self {
        let most = file_bytes
            .saturating_mul(TIMES_KEPT)
            .saturating_add(1 << 20);
        Self {
            kept: VecDeque::new(),
            most: usize::try_from(most).unwrap_or(usize::MAX),
        }
    }

    /// Elements `range` of array `index`, which `read` reads where they are not there yet; `None`
    /// where it reads others.
    ///
    /// # Errors
    /// The error of `read`.
    pub fn part(
        &mut self,
        index: usize,
        range: Range<usize>,
        read: impl FnOnce() -> Result<Window, IoError>,
    ) -> Result<Option<Elements>, IoError> {
        let place = self.kept.iter().position(|(array, _)| *array == index);
        let known = place.and_then(|place| self.kept.remove(place));
        if let Some((_, window)) = known
            && let Some(part) = window.part(&range)
        {
            self.kept.push_back((index, window));
            return Ok(Some(part));
        }
        // Room is made before the next one is read.
        self.let_go(ALWAYS_KEPT - 1);
        let window = read()?;
        let part = window.part(&range);
        self.kept.push_back((index, window));
        self.let_go(ALWAYS_KEPT);
        Ok(part)
    }

    /// Lets those go that were not asked for the longest, until so many are left or all are small
    /// enough.
    fn let_go(&mut self, least: usize) {
        let sizes = self.kept.iter().map(|(_, window)| memory(&window.elements));
        let mut all = sizes.fold(0, usize::saturating_add);
        while self.kept.len() > least && all > self.most {
            if let Some((_, window)) = self.kept.pop_front() {
                all = all.saturating_sub(memory(&window.elements));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_byte_orders_of_every_width_are_read() {
        use NumberType::*;
        let values: [(NumberType, &[u8], f64); 10] = [
            (I8, &[0xfe], -2.0),
            (U8, &[0xfe], 254.0),
            (I16, &[0xff, 0xfe], -2.0),
            (U16, &[0xff, 0xfe], 65534.0),
            (I32, &[0xff, 0xff, 0xff, 0xfe], -2.0),
            (U32, &[0xff, 0xff, 0xff, 0xfe], 4294967294.0),
            (I64, &[0xff; 8], -1.0),
            (U64, &[0, 0, 0, 0, 0, 0, 1, 2], 258.0),
            (F16, &[0xc1, 0x00], -2.5),
            (F64, &[0xc0, 0x04, 0, 0, 0, 0, 0, 0], -2.5),
        ];
        for (number, bytes, expected) in values {
            let mut little = bytes.to_vec();
            little.reverse();
            assert_eq!(
                decode(bytes, number, true),
                Elements::F64(vec![expected]),
                "{number:?}"
            );
            assert_eq!(
                decode(&little, number, false),
                Elements::F64(vec![expected])
            );
            assert_eq!(number.size(), bytes.len());
        }
        let single = (-2.5_f32).to_be_bytes();
        assert_eq!(decode(&single, F32, true), Elements::F32(vec![-2.5]));
    }

    #[test]
    fn half_precision_has_small_numbers_and_infinities() {
        // IEEE 754: smallest subnormal 2^-24, largest 65504.
        assert_eq!(half(0x0001).to_bits(), 2_f64.powi(-24).to_bits());
        assert_eq!(half(0x7bff).to_bits(), 65504_f64.to_bits());
        assert_eq!(half(0xfc00).to_bits(), f64::NEG_INFINITY.to_bits());
        assert!(half(0x7e00).is_nan());
    }

    #[test]
    fn three_dimensions_are_turned_and_turned_back() {
        // Element [i, j, k] of shape 2 x 3 x 4 is 100 i + 10 j + k.
        let value = |i: usize, j: usize, k: usize| (100 * i + 10 * j + k) as f64;
        let mut column_major = Vec::new();
        for k in 0..4 {
            for j in 0..3 {
                column_major.extend((0..2).map(|i| value(i, j, k)));
            }
        }
        let mut row_major = Vec::new();
        for i in 0..2 {
            for j in 0..3 {
                row_major.extend((0..4).map(|k| value(i, j, k)));
            }
        }
        let turned = to_row_major(Elements::F64(column_major.clone()), &[2, 3, 4]);
        assert_eq!(turned, Elements::F64(row_major));
        assert_eq!(
            to_row_major(turned, &[4, 3, 2]),
            Elements::F64(column_major)
        );
    }

    #[test]
    fn lengths_beside_a_zero_are_counted() {
        let large = 1 << 40;
        assert_eq!(count(&[3, 4]), Some(12));
        assert_eq!(count(&[]), Some(1));
        assert_eq!(count(&[0, large]), Some(0));
        for shape in [[0, large, large], [large, 0, large], [large, large, 0]] {
            assert_eq!(count(&shape), None, "{shape:?}");
        }
    }

    #[test]
    fn three_small_arrays_are_cached_and_large_ones_are_not() {
        let mut recent = RecentArrays::new(0);
        let reads = std::cell::Cell::new(0);
        let mut ask = |index: usize, len: usize| {
            let read = || {
                reads.set(reads.get() + 1);
                Ok(Window {
                    start: 10,
                    elements: Elements::F64(vec![index as f64; len]),
                })
            };
            let part = recent.part(index, 11..13, read).unwrap();
            assert_eq!(part, Some(Elements::F64(vec![index as f64; 2])));
            reads.get()
        };
        let counts = [0, 1, 2, 0, 1, 2].map(|index| ask(index, 5));
        assert_eq!(counts, [1, 2, 3, 3, 3, 3]);
        let counts = [3, 4, 5, 5, 4, 3].map(|index| ask(index, 100_000));
        assert_eq!(counts, [4, 5, 6, 6, 6, 7], "two of 800 kB are kept");
        let read = || {
            Ok(Window {
                start: 1,
                elements: Elements::F64(vec![0.0; 2]),
            })
        };
        assert_eq!(recent.part(9, 0..2, read).unwrap(), None);
        let read = || {
            Ok(Window {
                start: 0,
                elements: Elements::F64(vec![0.0; 2]),
            })
        };
        assert_eq!(recent.part(10, 1..3, read).unwrap(), None);
    }
}
