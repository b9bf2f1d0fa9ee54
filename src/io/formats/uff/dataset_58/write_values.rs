//! Values of dataset 58 from a source to a file: block by block, in the width and encoding that is
//! asked for.

use std::io::Write;

use bytemuck::cast_slice;
use num_complex::Complex64;

use super::entry_header::FunctionHeader;
use super::value_width::{numbers_per_value, value_bytes};
use super::write_header::{SINGLE_DIGITS, TextRows, binary_head, text_head};
use crate::io::error::write_failed;
use crate::io::formats::dropped_content::DroppedContent;
use crate::io::formats::uff::fields::finite;
use crate::io::formats::uff::fields::fixed_columns::{fortran, twelve_columns};
use crate::io::{Block, Encoding, IoError, Precision, SampleFormat, Source, WriteOptions};

/// Values taken from the source at once.
const VALUES_AT_ONCE: usize = 1 << 16;

/// The format of values in a file, when a precision is asked for.
pub(in crate::io::formats::uff) fn written_format(
    format: SampleFormat,
    precision: Option<Precision>,
) -> SampleFormat {
    let complex = numbers_per_value(format) == 2;
    match (precision, complex) {
        (None, _) => format,
        (Some(Precision::Single), false) => SampleFormat::RealF32,
        (Some(Precision::Single), true) => SampleFormat::ComplexF32,
        (Some(Precision::Double), false) => SampleFormat::RealF64,
        (Some(Precision::Double), true) => SampleFormat::ComplexF64,
    }
}

/// A dataset that is to be written.
pub(in crate::io::formats::uff) struct Target<'a> {
    header: FunctionHeader,
    /// The factor of the values.
    factor: f64,
    options: &'a WriteOptions,
}

impl<'a> Target<'a> {
    pub fn new(header: FunctionHeader, factor: f64, options: &'a WriteOptions) -> Self {
        Self {
            header,
            factor,
            options,
        }
    }

    /// Writes the dataset with the values of an entry and counts it where its text loses digits.
    pub fn write(
        mut self,
        out: &mut dyn Write,
        source: &mut dyn Source,
        entry: usize,
        lost: &mut DroppedContent,
    ) -> Result<(), IoError> {
        let abscissa = self.abscissa(source, entry)?;
        let is_text = self.options.encoding == Encoding::Text;
        let rounded = |value: &f64| !reads_back(&twelve_columns(*value), *value);
        let cut = is_text && abscissa.iter().flatten().any(rounded);
        lost.add("digits of uneven abscissae", usize::from(cut));
        let mut digits_lost = false;
        let failed = |source| write_failed(&self.options.path, source);
        let mut rows = TextRows::new(self.header.format, abscissa.is_some());
        let head = match self.options.encoding {
            Encoding::Text => text_head(&self.header),
            Encoding::Binary => {
                let value = value_bytes(self.header.format);
                let stride = value + abscissa.as_ref().map_or(0, |_| self.number_bytes());
                binary_head(&self.header, stride * self.header.points as u64)
            }
        };
        out.write_all(head.as_bytes()).map_err(failed)?;
        let mut block = Block::F64(Vec::new());
        for start in (0..self.header.points).step_by(VALUES_AT_ONCE) {
            let range = start..self.header.points.min(start + VALUES_AT_ONCE);
            source.read(entry, range.clone(), &mut block)?;
            if let Some(bytes) = self.as_stored(&block) {
                out.write_all(bytes).map_err(failed)?;
                continue;
            }
            let numbers = self.numbers(&block)?;
            let abscissa = abscissa.as_ref().map(|all| &all[range]);
            match self.options.encoding {
                Encoding::Text => {
                    digits_lost |= !digits_lost && self.loses_digits(&numbers);
                    self.add_rows(&mut rows, &numbers, abscissa);
                    rows.write(out).map_err(failed)?;
                }
                Encoding::Binary => out
                    .write_all(&self.bytes(&numbers, abscissa))
                    .map_err(failed)?,
            }
        }
        lost.add(
            "digits of single-precision values",
            usize::from(digits_lost),
        );
        match self.options.encoding {
            Encoding::Text => rows.finish(out).map_err(failed)?,
            Encoding::Binary => {}
        }
        out.write_all(b"    -1\n").map_err(failed)
    }

    /// The values of an uneven abscissa. Where single precision does not hold them, all numbers of
    /// a binary block get 64 bits.
    fn abscissa(
        &mut self,
        source: &mut dyn Source,
        entry: usize,
    ) -> Result<Option<Vec<f64>>, IoError> {
        if self.header.spacing.is_some() {
            return Ok(None);
        }
        let mut values = Vec::new();
        if self.header.points > 0 {
            source.abscissa(entry, 0..self.header.points, &mut values)?;
        }
        let single = |value: &f64| f64::from(*value as f32).to_bits() == value.to_bits();
        if self.options.encoding == Encoding::Binary && !values.iter().all(single) {
            self.header.format = written_format(self.header.format, Some(Precision::Double));
        }
        Ok(Some(values))
    }

    fn is_single(&self) -> bool {
        matches!(
            self.header.format,
            SampleFormat::RealF32 | SampleFormat::ComplexF32
        )
    }

    fn number_bytes(&self) -> u64 {
        if self.is_single() { 4 } else { 8 }
    }

    /// The bytes of values that are written as they are.
    fn as_stored<'b>(&self, block: &'b Block) -> Option<&'b [u8]> {
        let changed = (self.factor - 1.0).abs() > 0.0 || self.options.encoding == Encoding::Text;
        if changed || self.header.spacing.is_none() || cfg!(target_endian = "big") {
            return None;
        }
        match (block, self.header.format) {
            (Block::F32(values), SampleFormat::RealF32) => Some(cast_slice(values)),
            (Block::F64(values), SampleFormat::RealF64) => Some(cast_slice(values)),
            (Block::Complex(values), SampleFormat::ComplexF64) => Some(cast_slice(values)),
            _ => None,
        }
    }

    /// Values as written: numbers one after the other.
    fn numbers(&self, block: &Block) -> Result<Vec<f64>, IoError> {
        let parts = |values: &[Complex64]| values.iter().flat_map(|v| [v.re, v.im]).collect();
        let mut numbers: Vec<f64> = match block {
            Block::F32(values) => values.iter().copied().map(f64::from).collect(),
            Block::F64(values) => values.clone(),
            Block::Complex(values) => parts(values),
        };
        if (self.factor - 1.0).abs() > 0.0 {
            numbers.iter_mut().for_each(|number| *number *= self.factor);
        }
        let overflows = |number: &&f64| number.is_finite() && (**number as f32).is_infinite();
        match numbers.iter().find(overflows).filter(|_| self.is_single()) {
            None => Ok(numbers),
            Some(number) => Err(IoError::Unwritable {
                path: self.options.path.clone(),
                what: "sample",
                got: format!("{number:e}"),
                expected: "at most 3.4e38 in single precision".to_owned(),
            }),
        }
    }

    /// Whether the text of a value of single precision is not read as that value.
    fn loses_digits(&self, numbers: &[f64]) -> bool {
        let single = |value: f64| f64::from(value as f32);
        let kept = |value: &f64| {
            let read = finite(fortran(single(*value), SINGLE_DIGITS).as_bytes());
            read.is_none_or(|read| (read as f32).to_bits() == (*value as f32).to_bits())
        };
        self.is_single() && !numbers.iter().all(kept)
    }

    fn add_rows(&self, rows: &mut TextRows, numbers: &[f64], abscissa: Option<&[f64]>) {
        let per_value = numbers_per_value(self.header.format) as usize;
        for (i, value) in numbers.chunks_exact(per_value).enumerate() {
            if let Some(abscissa) = abscissa {
                rows.abscissa(abscissa[i]);
            }
            value.iter().for_each(|number| rows.number(*number));
        }
    }

    fn bytes(&self, numbers: &[f64], abscissa: Option<&[f64]>) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(numbers.len() * self.number_bytes() as usize);
        let single = self.is_single();
        let mut add = |number: f64| match single {
            true => bytes.extend((number as f32).to_le_bytes()),
            false => bytes.extend(number.to_le_bytes()),
        };
        let per_value = numbers_per_value(self.header.format) as usize;
        for (i, value) in numbers.chunks_exact(per_value).enumerate() {
            if let Some(abscissa) = abscissa {
                add(abscissa[i]);
            }
            value.iter().for_each(|number| add(*number));
        }
        bytes
    }
}

/// Whether a text is read as exactly this number; numbers that are not finite have special texts.
fn reads_back(text: &str, value: f64) -> bool {
    finite(text.as_bytes()).is_none_or(|read| read.to_bits() == value.to_bits())
}
