//! Samples of dataset 58 as text: the numbers between a header and the delimiter.

use std::io::{self, ErrorKind, SeekFrom};
use std::ops::Range;

use bytemuck::cast_slice;

use super::value_width::numbers_per_value;
use crate::io::formats::uff::fields::{FieldError, Numbers, Position, data_row};
use crate::io::{Block, IoError, ReadSeek, SampleFormat};

/// Bytes taken from the file at once, and the longest row that is read as a whole.
const CHUNK_BYTES: usize = 1 << 20;
/// Columns of a row.
const ROW_COLUMNS: usize = 80;

/// Lines of numbers up to the delimiter at byte `end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::io::formats::uff) struct TextBlock {
    pub at: Position,
    pub end: u64,
    pub format: SampleFormat,
    pub points: u64,
    /// Whether an abscissa stands before each value.
    pub uneven: bool,
    /// The byte that ends a line.
    pub line_end: u8,
}

impl TextBlock {
    /// Numbers from one value to the next.
    pub fn stride(&self) -> u64 {
        numbers_per_value(self.format) + u64::from(self.uneven)
    }
}

/// Copies values `range` of a text block that [`read_text`] has read.
pub(in crate::io::formats::uff) fn copy_text(
    numbers: &[f64],
    from: &TextBlock,
    range: Range<usize>,
    block: &mut Block,
) {
    let stride = from.stride() as usize;
    let part = &numbers[range.start * stride..range.end * stride];
    let pairs = || {
        part.chunks_exact(stride)
            .map(|pair| &pair[usize::from(from.uneven)..])
    };
    match (numbers_per_value(from.format), &mut *block) {
        (1, Block::F64(values)) => {
            values.clear();
            if from.uneven {
                values.extend(pairs().map(|pair| pair[0]));
            } else {
                values.extend_from_slice(part);
            }
        }
        (1, _) => {
            *block = Block::F64(Vec::new());
            copy_text(numbers, from, range, block);
        }
        (_, Block::Complex(values)) => {
            values.clear();
            if from.uneven {
                values.extend(pairs().map(|pair| num_complex::Complex64::new(pair[0], pair[1])));
            } else {
                values.extend_from_slice(cast_slice(part));
            }
        }
        _ => {
            *block = Block::Complex(Vec::new());
            copy_text(numbers, from, range, block);
        }
    }
}

/// Copies the abscissae of values `range` of an uneven text block.
pub(in crate::io::formats::uff) fn copy_abscissa(
    numbers: &[f64],
    from: &TextBlock,
    range: Range<usize>,
    out: &mut Vec<f64>,
) {
    let stride = from.stride() as usize;
    let part = &numbers[range.start * stride..range.end * stride];
    out.clear();
    out.extend(part.chunks_exact(stride).map(|pair| pair[0]));
}

/// Reads all numbers of a text block; zeros that merely fill the last row stay behind the others.
/// With `printed` the result includes the printed precision of the abscissae.
///
/// # Errors
/// [`IoError`] with the line of a text that is not a number, or of the end when there are too few
/// or too many.
pub(in crate::io::formats::uff) fn read_text(
    input: &mut dyn ReadSeek,
    from: &TextBlock,
    printed: bool,
    path: &str,
) -> Result<Numbers, IoError> {
    let wanted = (from.points * from.stride()) as usize;
    let mut rows = Rows {
        at: from.at,
        width: match from.format {
            SampleFormat::RealF32 | SampleFormat::ComplexF32 => 13,
            SampleFormat::RealF64 | SampleFormat::ComplexF64 => 20,
        },
        wanted,
        numbers: Numbers {
            values: Vec::with_capacity(wanted),
            half_units: printed.then(|| (from.stride() as usize, Vec::new())),
        },
        within_row: false,
        line_end: from.line_end,
    };
    let system = |source| IoError::System {
        path: path.to_owned(),
        action: "read",
        source,
    };
    input.seek(SeekFrom::Start(from.at.byte)).map_err(system)?;
    let mut left = from.end - from.at.byte;
    let mut buffer = vec![0; CHUNK_BYTES.min(left as usize)];
    let mut kept = 0;
    while left > 0 {
        let room = (buffer.len() - kept).min(usize::try_from(left).unwrap_or(usize::MAX));
        let count = read_some(input, &mut buffer[kept..kept + room]).map_err(system)?;
        left = if count == 0 { 0 } else { left - count as u64 };
        let filled = kept + count;
        let whole = match left {
            0 => filled,
            _ => whole_rows(&buffer[..filled], from.line_end, filled == buffer.len()),
        };
        let taken = rows.take(&buffer[..whole]);
        taken.map_err(|error| error.in_file(path))?;
        buffer.copy_within(whole..filled, 0);
        kept = filled - whole;
    }
    rows.finish().map_err(|error| error.in_file(path))
}

fn read_some(input: &mut dyn ReadSeek, bytes: &mut [u8]) -> io::Result<usize> {
    loop {
        match input.read(bytes) {
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            other => return other,
        }
    }
}

/// How many of the bytes are whole rows; where a row is longer than all of them, how many are whole
/// numbers; all, where a number is.
fn whole_rows(bytes: &[u8], line_end: u8, full: bool) -> usize {
    let row = memchr::memrchr(line_end, bytes).map(|at| at + 1);
    match row {
        Some(end) => end,
        None if full => {
            let blank = bytes.iter().rposition(u8::is_ascii_whitespace);
            blank.map_or(bytes.len(), |at| at + 1)
        }
        None => 0,
    }
}

/// Rows of numbers on the way.
struct Rows {
    at: Position,
    width: usize,
    wanted: usize,
    numbers: Numbers,
    /// Whether what was read last is the first part of a row.
    within_row: bool,
    line_end: u8,
}

impl Rows {
    /// Reads rows, the last one of which may go on.
    fn take(&mut self, bytes: &[u8]) -> Result<(), FieldError> {
        let mut start = 0;
        while start < bytes.len() {
            let end = memchr::memchr(self.line_end, &bytes[start..]).map(|at| start + at + 1);
            let row = &bytes[start..end.unwrap_or(bytes.len())];
            self.row(row)?;
            self.at.byte += row.len() as u64;
            if end.is_some() {
                self.at.line = self.at.line.map(|line| line + 1);
            }
            start += row.len();
        }
        Ok(())
    }

    fn row(&mut self, row: &[u8]) -> Result<(), FieldError> {
        let before = self.numbers.values.len();
        data_row(row, self.width, &mut self.numbers).map_err(|got| FieldError {
            at: self.at,
            what: "sample of dataset 58",
            got,
            expected: "a number".to_owned(),
        })?;
        let count = self.numbers.values.len();
        // Zeros behind the last number may fill its row, however the row came in parts; another row
        // is no filler.
        let surplus = count.saturating_sub(self.wanted);
        let new_row = before >= self.wanted && !self.within_row;
        let filler = surplus < ROW_COLUMNS / self.width
            && self.numbers.values[count - surplus..]
                .iter()
                .all(|value| *value == 0.0);
        if surplus > 0 && count > before && (new_row || !filler) {
            return Err(self.wrong_count(format!("{count} or more")));
        }
        self.within_row = !row.ends_with(&[self.line_end]);
        Ok(())
    }

    fn finish(self) -> Result<Numbers, FieldError> {
        let count = self.numbers.values.len();
        if count < self.wanted {
            return Err(self.wrong_count(count.to_string()));
        }
        Ok(self.numbers)
    }

    fn wrong_count(&self, got: String) -> FieldError {
        FieldError {
            at: self.at,
            what: "number of numbers of dataset 58",
            got,
            expected: format!("{} (from the number of points)", self.wanted),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether four numbers are read from parts of their rows.
    fn read(parts: &[&str]) -> bool {
        let mut rows = Rows {
            at: Position {
                line: None,
                byte: 0,
            },
            width: 13,
            wanted: 4,
            numbers: Numbers::default(),
            within_row: false,
            line_end: b'\n',
        };
        parts.iter().all(|part| rows.take(part.as_bytes()).is_ok()) && rows.finish().is_ok()
    }

    #[test]
    fn zeros_fill_the_last_row_wherever_it_is_parted() {
        for parts in [
            &["1. 2. 3. 4. 0. 0.\n"][..],
            &["1. 2. 3. 4. ", "0. ", "0.\n"],
            &["1. 2.\n3. ", "4. 0. 0. 0.\n", "\n"],
        ] {
            assert!(read(parts), "{parts:?}");
        }
        for parts in [
            &["1. 2. 3. 4. 0. 5.\n"][..],
            &["1. 2. 3. 4. ", "0. ", "5.\n"],
            &["1. 2. 3. 4. ", "NaN\n"],
            &["1. 2. 3. 4.\n", "0.\n"],
            &["1. 2. 3. 4. 0. 0. 0.", " 0. 0. 0.\n"],
            &["1. 2. 3.\n"],
        ] {
            assert!(!read(parts), "{parts:?}");
        }
    }
}
