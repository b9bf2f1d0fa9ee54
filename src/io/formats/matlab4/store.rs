//! A MATLAB file of version 4 as a container of arrays.

use std::io::{Read, SeekFrom};
use std::ops::Range;

use num_complex::Complex64;

use crate::io::formats::arrays::store::bytes::{
    RecentArrays, Window, decode, doubles, to_row_major,
};
use crate::io::formats::arrays::store::{ArrayStore, Elements, NamedArray, outside};
use crate::io::{ArrayInfo, IoError, MatrixEntries, ReadSeek};

use super::header::{Header, Kind, MAX_NAME_BYTES, Machine, NUMBERS_BYTES};

/// A sparse matrix is read when the full one takes no more memory than this many times the file:
/// as for version 5, so that a few entries do not ask for all the memory.
const MAX_FULL_OVER_FILE: u64 = 16;

/// A matrix of the file.
#[derive(Clone)]
struct Matrix {
    header: Header,
    big_endian: bool,
    /// First byte of its numbers in the file.
    data: u64,
    /// Lengths of the array that it is; of a sparse one those of the full one.
    shape: Vec<usize>,
}

/// An opened file.
pub(super) struct Matlab4Store {
    input: Box<dyn ReadSeek>,
    /// Length of the file.
    length: u64,
    path: String,
    matrices: Vec<Matrix>,
    list: Vec<ArrayInfo>,
    damage: Vec<IoError>,
    recent: RecentArrays,
}

/// Lists the matrices of a file up to the first that is damaged: where the next one begins follows
/// from the counts before it.
///
/// # Errors
/// [`IoError::Binary`] when the file does not begin with a matrix of numbers that are read;
/// [`IoError::System`].
pub(super) fn open(mut input: Box<dyn ReadSeek>, path: &str) -> Result<Matlab4Store, IoError> {
    let length = input.seek(SeekFrom::End(0));
    let length = length.map_err(|source| system(path, source))?;
    let mut store = Matlab4Store {
        input,
        length,
        path: path.to_owned(),
        matrices: Vec::new(),
        list: Vec::new(),
        damage: Vec::new(),
        recent: RecentArrays::new(length),
    };
    let mut at = 0;
    while at < length {
        match store.list_matrix(at) {
            Ok(next) => at = next,
            Err(error @ IoError::Binary { .. }) if at == 0 => return Err(error),
            Err(error) => {
                store.damage.push(error);
                break;
            }
        }
    }
    Ok(store)
}

fn system(path: &str, source: std::io::Error) -> IoError {
    IoError::System {
        path: path.to_owned(),
        action: "read",
        source,
    }
}

impl Matlab4Store {
    fn binary(&self, byte: u64, what: &'static str, got: String, expected: String) -> IoError {
        IoError::Binary {
            path: self.path.clone(),
            byte,
            what,
            got,
            expected,
        }
    }

    /// `count` bytes from byte `at` of the file, which holds them.
    fn bytes(&mut self, at: u64, count: usize) -> Result<Vec<u8>, IoError> {
        let mut bytes = vec![0; count];
        let sought = self.input.seek(SeekFrom::Start(at));
        sought
            .and_then(|_| self.input.read_exact(&mut bytes))
            .map_err(|source| system(&self.path, source))?;
        Ok(bytes)
    }

    /// Lists the matrix at byte `at`; where the next one begins.
    fn list_matrix(&mut self, at: u64) -> Result<u64, IoError> {
        let left = self.length - at;
        let head = left.min((NUMBERS_BYTES + MAX_NAME_BYTES) as u64);
        let head = self.bytes(at, head as usize)?;
        if head.len() < NUMBERS_BYTES {
            let got = format!("{left} bytes");
            return Err(self.truncated(got, "a header of 20 bytes".to_owned()));
        }
        let header = Header::parse(&head)
            .map_err(|wrong| self.binary(at, wrong.what, wrong.got, wrong.expected.to_owned()))?;
        let big_endian = match header.machine {
            Machine::Ieee { big_endian } => big_endian,
            Machine::Other(name) => {
                let expected = "IEEE numbers: load the file in MATLAB, and save it with save -v7";
                let got = format!("{name} numbers");
                return Err(self.binary(at, "numbers of a matrix", got, expected.to_owned()));
            }
        };
        let data = at + header.bytes();
        let content = header.content_bytes().unwrap_or(u64::MAX);
        let end = data.checked_add(content).filter(|end| *end <= self.length);
        let end = end.ok_or_else(|| {
            let got = format!("{} bytes", self.length.saturating_sub(data));
            let lengths = format!("{} x {}", header.rows, header.columns);
            self.truncated(
                got,
                format!("{content} bytes ({lengths} {})", kind(&header)),
            )
        })?;
        let mut matrix = Matrix {
            shape: vec![header.rows, header.columns],
            header,
            big_endian,
            data,
        };
        if matrix.header.kind == Kind::Sparse {
            matrix.shape = self.sparse_shape(&matrix)?;
        }
        self.list.push(ArrayInfo {
            name: matrix.header.name.clone(),
            shape: match matrix.header.kind {
                Kind::Text => text_shape(&matrix.header),
                _ => matrix.shape.clone(),
            },
            kind: kind(&matrix.header),
        });
        self.matrices.push(matrix);
        Ok(end)
    }

    fn truncated(&self, got: String, expected: String) -> IoError {
        IoError::Truncated {
            path: self.path.clone(),
            byte: self.length,
            what: "a matrix",
            got,
            expected,
        }
    }

    /// The size of a sparse matrix, which stands in its last row.
    fn sparse_shape(&mut self, matrix: &Matrix) -> Result<Vec<usize>, IoError> {
        let header = &matrix.header;
        let columns = 3..=4;
        let last = header.rows.checked_sub(1);
        let last = last.filter(|_| columns.contains(&header.columns) && !header.complex);
        let last = last.ok_or_else(|| {
            let got = format!("{} x {} numbers", header.rows, header.columns);
            let expected = "rows of 3 numbers, or of 4 where they are complex".to_owned();
            self.binary(matrix.data, "sparse matrix", got, expected)
        })?;
        let lengths = [
            self.numbers(matrix, last..last + 1)?,
            self.numbers(matrix, header.rows + last..header.rows + last + 1)?,
        ];
        let lengths = lengths.concat();
        let is_length = |length: &f64| length.fract() == 0.0 && (0.0..2e9).contains(length);
        if !lengths.iter().all(is_length) {
            let expected = "whole numbers below 2,000,000,000".to_owned();
            let got = format!("{lengths:?}");
            return Err(self.binary(matrix.data, "size of a sparse matrix", got, expected));
        }
        Ok(lengths.into_iter().map(|length| length as usize).collect())
    }

    /// Numbers `range` of a matrix, which lie inside, in the order of the file.
    fn elements(&mut self, matrix: &Matrix, range: Range<usize>) -> Result<Elements, IoError> {
        let size = matrix.header.number.size();
        let at = matrix.data + (range.start * size) as u64;
        let bytes = self.bytes(at, range.len() * size)?;
        Ok(decode(&bytes, matrix.header.number, matrix.big_endian))
    }

    /// [`Self::elements`] in double precision.
    fn numbers(&mut self, matrix: &Matrix, range: Range<usize>) -> Result<Vec<f64>, IoError> {
        self.elements(matrix, range).map(doubles)
    }

    /// Elements `range` of a full matrix, column after column.
    fn full(&mut self, matrix: &Matrix, range: Range<usize>) -> Result<Elements, IoError> {
        if !matrix.header.complex {
            return self.elements(matrix, range);
        }
        let count = matrix.header.rows * matrix.header.columns;
        let imaginary = range.start + count..range.end + count;
        let real = self.numbers(matrix, range)?;
        let imaginary = self.numbers(matrix, imaginary)?;
        let pairs = real.into_iter().zip(imaginary);
        let values = pairs.map(|(re, im)| Complex64::new(re, im));
        Ok(Elements::Complex(values.collect()))
    }

    /// A text for each row, without the blanks that fill it to the length of the others.
    fn texts(&mut self, matrix: &Matrix) -> Result<Elements, IoError> {
        let (rows, columns) = (matrix.header.rows, matrix.header.columns);
        if rows * columns == 0 {
            return Ok(Elements::Text(vec![String::new()]));
        }
        let codes = self.numbers(matrix, 0..rows * columns)?;
        // A code that no character has is cast to one, or replaced by a mark.
        let character =
            |code: f64| char::from_u32(code as u32).unwrap_or(char::REPLACEMENT_CHARACTER);
        let text = |row: usize| -> String {
            let codes = codes[row..].iter().step_by(rows);
            codes.map(|code| character(*code)).collect()
        };
        let texts = (0..rows).map(|row| match rows {
            1 => text(row),
            _ => text(row).trim_end_matches(' ').to_owned(),
        });
        Ok(Elements::Text(texts.collect()))
    }

    /// Gives row, column (from 0), real and imaginary part of every entry of a sparse matrix.
    fn for_each_entry(
        &mut self,
        matrix: &Matrix,
        mut take: impl FnMut(usize, usize, Complex64),
    ) -> Result<(), IoError> {
        let (rows, columns) = (matrix.header.rows, matrix.header.columns);
        let numbers = self.numbers(matrix, 0..rows * columns)?;
        let number = |row: usize, column: usize| numbers[column * rows + row];
        let place = |number: f64, length: usize| {
            let inside = number.fract() == 0.0 && number >= 1.0 && number <= length as f64;
            inside.then(|| number as usize - 1)
        };
        for entry in 0..rows - 1 {
            let (row, column) = (number(entry, 0), number(entry, 1));
            let places = place(row, matrix.shape[0]).zip(place(column, matrix.shape[1]));
            let (row, column) = places.ok_or_else(|| {
                let got = format!("row {row}, column {column}");
                let expected = format!("inside {:?}", matrix.shape);
                self.binary(matrix.data, "entry of a sparse matrix", got, expected)
            })?;
            let imaginary = if columns > 3 { number(entry, 3) } else { 0.0 };
            take(row, column, Complex64::new(number(entry, 2), imaginary));
        }
        Ok(())
    }

    /// A sparse matrix made full, row by row.
    fn filled(&mut self, matrix: &Matrix) -> Result<Elements, IoError> {
        let width = matrix.shape[1];
        let mut full = vec![Complex64::default(); matrix.shape[0] * width];
        // Entries of one place add up.
        self.for_each_entry(matrix, |row, column, value| {
            full[row * width + column] += value;
        })?;
        Ok(match matrix.header.columns {
            3 => Elements::F64(full.into_iter().map(|value| value.re).collect()),
            _ => Elements::Complex(full),
        })
    }
}

/// The name for lists of arrays.
fn kind(header: &Header) -> String {
    match header.kind {
        Kind::Text => "text".to_owned(),
        Kind::Sparse => "sparse".to_owned(),
        Kind::Full if header.complex => format!("complex {}", header.number.name()),
        Kind::Full => header.number.name().to_owned(),
    }
}

/// Shape of the texts of a matrix, one for each row.
fn text_shape(header: &Header) -> Vec<usize> {
    match header.rows {
        rows if rows > 1 && header.columns > 0 => vec![rows],
        _ => Vec::new(),
    }
}

impl ArrayStore for Matlab4Store {
    fn list(&self) -> &[ArrayInfo] {
        &self.list
    }

    fn can_read(&self, index: usize) -> bool {
        let matrix = &self.matrices[index];
        let count = (matrix.shape[0] as u64).saturating_mul(matrix.shape[1] as u64);
        let full = count.saturating_mul(size_of::<Complex64>() as u64);
        matrix.header.kind != Kind::Sparse || full <= self.length.saturating_mul(MAX_FULL_OVER_FILE)
    }

    fn bytes(&self, index: usize) -> u64 {
        self.matrices[index].header.content_bytes().unwrap_or(0)
    }

    fn file_bytes(&self) -> u64 {
        self.length
    }

    fn take_damage(&mut self) -> Vec<IoError> {
        std::mem::take(&mut self.damage)
    }

    fn read(&mut self, index: usize) -> Result<NamedArray, IoError> {
        if !self.can_read(index) {
            let at = self.matrices[index].data;
            let got = format!("a full matrix of {:?}", self.matrices[index].shape);
            let expected = "one that the file could fill".to_owned();
            return Err(self.binary(at, "sparse matrix", got, expected));
        }
        let matrix = self.matrices[index].clone();
        let elements = match matrix.header.kind {
            Kind::Text => self.texts(&matrix)?,
            Kind::Sparse => self.filled(&matrix)?,
            Kind::Full => {
                let count = matrix.header.rows * matrix.header.columns;
                to_row_major(self.full(&matrix, 0..count)?, &matrix.shape)
            }
        };
        let info = &self.list[index];
        Ok(NamedArray {
            name: info.name.clone(),
            shape: info.shape.clone(),
            elements,
        })
    }

    fn read_sparse(&mut self, index: usize) -> Result<Option<MatrixEntries>, IoError> {
        let matrix = self.matrices[index].clone();
        if matrix.header.kind != Kind::Sparse {
            return Ok(None);
        }
        if matrix.header.columns > 3 {
            let got = "complex numbers".to_owned();
            let expected = "real ones".to_owned();
            return Err(self.binary(matrix.data, "sparse matrix", got, expected));
        }
        let mut entries = Vec::new();
        self.for_each_entry(&matrix, |row, column, value| {
            entries.push((row, column, value.re));
        })?;
        Ok(Some(MatrixEntries {
            rows: matrix.shape[0],
            columns: matrix.shape[1],
            entries,
        }))
    }

    fn read_part(&mut self, index: usize, range: Range<usize>) -> Result<Elements, IoError> {
        let header = &self.matrices[index].header;
        let count = header.rows * header.columns;
        let is_vector = header.rows == 1 || header.columns == 1;
        if header.kind == Kind::Full && is_vector {
            if range.start > range.end || range.end > count {
                return Err(outside(&self.list[index].name, &range));
            }
            let matrix = self.matrices[index].clone();
            return self.full(&matrix, range);
        }
        // Elements of a row lie apart, so that a part costs as much as the whole.
        let mut recent = std::mem::take(&mut self.recent);
        let read = || {
            let elements = self.read(index)?.elements;
            Ok(Window { start: 0, elements })
        };
        let part = recent.part(index, range.clone(), read);
        self.recent = recent;
        part?.ok_or_else(|| outside(&self.list[index].name, &range))
    }
}
