//! Numbers and texts of a matrix.

use std::ops::Range;

use num_complex::Complex64;

use crate::io::formats::arrays::store::Elements;
use crate::io::formats::arrays::store::bytes::{decode, doubles, to_row_major};
use crate::io::{IoError, MatrixEntries};

use super::bytes::Storage;
use super::elements::{Element, Matrix, Reader, SINGLE, SPARSE, UTF8, UTF16, UTF32};
use super::list::{Content, Part, is_one_text, text_shape};

/// Reads a part of a file to its shape and elements in row-major order.
pub(super) fn read(reader: &mut Reader, part: &Part) -> Result<(Vec<usize>, Elements), IoError> {
    let matrix = reader.matrix(part.position, part.end)?;
    match part.content {
        Content::Numbers => {
            let elements = numbers(reader, &matrix, 0..matrix.count)?;
            let elements = to_row_major(elements, &matrix.shape);
            Ok((matrix.shape, elements))
        }
        Content::Sparse => {
            let elements = sparse(reader, &matrix)?;
            Ok((matrix.shape, elements))
        }
        Content::Text => {
            let mut budget = text_budget(reader);
            let rows = texts(reader, &matrix, &mut budget)?;
            Ok((text_shape(&matrix), Elements::Text(rows)))
        }
        Content::TextCells => {
            let elements = to_row_major(cells(reader, &matrix)?, &matrix.shape);
            Ok((matrix.shape, elements))
        }
        Content::Unread => {
            let got = format!("class {}", matrix.class);
            Err(reader.error(part.position, "reading an array", got, "numbers or texts"))
        }
    }
}

/// Whether any part of an array can be read separately: its numbers are contiguous and not
/// compressed.
pub(super) fn in_one_piece(part: &Part, shape: &[usize]) -> bool {
    part.content == Content::Numbers
        && matches!(part.storage, Storage::Plain(_))
        && shape.iter().filter(|len| **len != 1).count() <= 1
}

/// Elements `range` of an array [`in_one_piece`].
pub(super) fn read_range(
    reader: &mut Reader,
    part: &Part,
    range: Range<usize>,
) -> Result<Elements, IoError> {
    let matrix = reader.matrix(part.position, part.end)?;
    if range.start > range.end || range.end > matrix.count {
        let (got, expected) = (matrix.count, format!("elements {range:?}"));
        return Err(reader.error(part.position, "elements of an array", got, expected));
    }
    numbers(reader, &matrix, range)
}

/// Elements `range`, which lies inside, as they follow each other in the file.
fn numbers(reader: &mut Reader, matrix: &Matrix, range: Range<usize>) -> Result<Elements, IoError> {
    // Nothing needs no element.
    if range.is_empty() {
        return Ok(match (matrix.class, matrix.complex) {
            (SINGLE, false) => Elements::F32(Vec::new()),
            (_, false) => Elements::F64(Vec::new()),
            (_, true) => Elements::Complex(Vec::new()),
        });
    }
    let real = reader.element(matrix.content, matrix.end)?;
    if matrix.complex {
        let imaginary = reader.element(real.next, matrix.end)?;
        let re = doubles(counted(reader, &real, matrix.count, &range)?);
        let im = doubles(counted(reader, &imaginary, matrix.count, &range)?);
        let pairs = re.into_iter().zip(im);
        return Ok(Elements::Complex(
            pairs.map(|(re, im)| Complex64::new(re, im)).collect(),
        ));
    }
    let elements = counted(reader, &real, matrix.count, &range)?;
    Ok(match (matrix.class, elements) {
        (SINGLE, Elements::F64(values)) => {
            Elements::F32(values.into_iter().map(|value| value as f32).collect())
        }
        (SINGLE, elements) => elements,
        (_, elements) => Elements::F64(doubles(elements)),
    })
}

/// Numbers `range` of an element, which has as many as stated, in whatever width MATLAB chose to
/// store them.
fn counted(
    reader: &mut Reader,
    element: &Element,
    count: usize,
    range: &Range<usize>,
) -> Result<Elements, IoError> {
    let number = reader.number_of(element)?;
    if count.checked_mul(number.size()) != Some(element.size) {
        let got = format!("{} bytes of {}", element.size, number.name());
        return Err(reader.error(
            element.data,
            "data of an array",
            got,
            format!("{count} numbers"),
        ));
    }
    let size = number.size();
    let bytes = reader.content_part(element, range.start * size..range.end * size)?;
    Ok(decode(&bytes, number, reader.big_endian))
}

/// The entries of a real sparse matrix, however large the full one were; `None` for an array of
/// another kind.
pub(super) fn read_sparse(
    reader: &mut Reader,
    part: &Part,
) -> Result<Option<MatrixEntries>, IoError> {
    let matrix = reader.matrix(part.position, part.end)?;
    if matrix.class != SPARSE || matrix.shape.len() != 2 {
        return Ok(None);
    }
    if matrix.complex {
        return Err(reader.error(
            part.position,
            "sparse matrix",
            "complex numbers",
            "real ones",
        ));
    }
    let rows_element = reader.element(matrix.content, matrix.end)?;
    let columns_element = reader.element(rows_element.next, matrix.end)?;
    let real = reader.element(columns_element.next, matrix.end)?;
    let rows = reader.numbers(&rows_element)?;
    let starts = reader.numbers(&columns_element)?;
    let values = reader.numbers(&real)?;
    let value = |place: usize| values.get(place).copied();
    let mut entries = Vec::new();
    for_each_entry(
        reader,
        &matrix,
        &rows,
        &starts,
        value,
        |row, column, value| {
            entries.push((row, column, value));
        },
    )?;
    Ok(Some(MatrixEntries {
        rows: matrix.shape[0],
        columns: matrix.shape[1],
        entries,
    }))
}

/// A sparse matrix made full, in row-major order. Row indices and values are listed column after
/// column, and where each column begins.
fn sparse(reader: &mut Reader, matrix: &Matrix) -> Result<Elements, IoError> {
    let rows_element = reader.element(matrix.content, matrix.end)?;
    let columns_element = reader.element(rows_element.next, matrix.end)?;
    let real = reader.element(columns_element.next, matrix.end)?;
    let (rows, starts) = (
        reader.numbers(&rows_element)?,
        reader.numbers(&columns_element)?,
    );
    let re = reader.numbers(&real)?;
    if matrix.complex {
        let imaginary = reader.element(real.next, matrix.end)?;
        let im = reader.numbers(&imaginary)?;
        let value = |place: usize| Some(Complex64::new(*re.get(place)?, *im.get(place)?));
        let full = filled(reader, matrix, &rows, &starts, value)?;
        return Ok(Elements::Complex(full));
    }
    let value = |place: usize| re.get(place).copied();
    let full = filled(reader, matrix, &rows, &starts, value)?;
    Ok(Elements::F64(full))
}

/// The full matrix of a sparse one; `value` gives the values in the order of their row indices.
fn filled<T: Copy + Default>(
    reader: &Reader,
    matrix: &Matrix,
    rows: &[f64],
    starts: &[f64],
    value: impl Fn(usize) -> Option<T>,
) -> Result<Vec<T>, IoError> {
    let width = matrix.shape[1];
    let mut full = vec![T::default(); matrix.count];
    for_each_entry(reader, matrix, rows, starts, value, |row, column, value| {
        full[row * width + column] = value;
    })?;
    Ok(full)
}

/// Gives every entry of a sparse matrix with its place to `take`.
fn for_each_entry<T>(
    reader: &Reader,
    matrix: &Matrix,
    rows: &[f64],
    starts: &[f64],
    value: impl Fn(usize) -> Option<T>,
    mut take: impl FnMut(usize, usize, T),
) -> Result<(), IoError> {
    let (height, width) = (matrix.shape[0], matrix.shape[1]);
    let wrong = || {
        let got = "places outside it, or without a value";
        let expected = "a row inside and a value for each";
        reader.error(matrix.content, "indices of a sparse matrix", got, expected)
    };
    for column in 0..width {
        let limits = starts.get(column).zip(starts.get(column + 1));
        let ascending = limits.filter(|(first, end)| first <= end);
        let (first, end) = ascending.ok_or_else(wrong)?;
        // Places are not negative: a cast from NaN or below zero gives 0.
        for place in *first as usize..*end as usize {
            let row = rows.get(place).map(|row| *row as usize);
            let row = row.filter(|row| *row < height);
            let (row, value) = row.zip(value(place)).ok_or_else(wrong)?;
            take(row, column, value);
        }
    }
    Ok(())
}

/// The texts of one array take at most so many bytes for each byte of the file, and 1 MiB: blanks
/// deflate well.
const TEXT_EXPANSION: u64 = 8;

/// Memory of a text in addition to its characters.
const TEXT_BYTES: u64 = size_of::<String>() as u64;

/// Bytes that the texts of an array of this file may take.
fn text_budget(reader: &Reader) -> u64 {
    let most = reader.bytes.length.saturating_mul(TEXT_EXPANSION);
    most.saturating_add(1 << 20)
}

/// Texts of a char array, one for each row; blanks that fill a row to the width of the others are
/// taken off.
fn texts(reader: &mut Reader, matrix: &Matrix, budget: &mut u64) -> Result<Vec<String>, IoError> {
    let rows = text_shape(matrix).first().copied().unwrap_or(1);
    if matrix.count == 0 {
        return Ok(vec![String::new()]);
    }
    let element = reader.element(matrix.content, matrix.end)?;
    let needed = (rows as u64).saturating_mul(TEXT_BYTES);
    let needed = needed.saturating_add(element.size as u64);
    *budget = budget.checked_sub(needed).ok_or_else(|| {
        let expected = format!("{} or fewer in a file of this size", text_budget(reader));
        reader.error(element.data, "bytes of texts", needed, expected)
    })?;
    let bytes = reader.content(&element)?;
    let code = Code::of(&element, reader)?;
    if rows == 1 {
        return Ok(vec![code.text(&bytes)]);
    }
    let units = code.units(&bytes);
    if units.len() != matrix.count {
        let (got, expected) = (units.len(), format!("{} characters", matrix.count));
        return Err(reader.error(element.data, "characters of an array", got, expected));
    }
    let row = |row: usize| {
        let row_units = units[row..].iter().step_by(rows).copied();
        code.characters(row_units).trim_end_matches(' ').to_owned()
    };
    Ok((0..rows).map(row).collect())
}

fn cells(reader: &mut Reader, matrix: &Matrix) -> Result<Elements, IoError> {
    let mut budget = text_budget(reader);
    let mut all = Vec::new();
    let mut position = matrix.content;
    for _ in 0..matrix.count {
        let cell = reader.matrix(position, matrix.end)?;
        if !is_one_text(&cell) {
            return Err(reader.error(position, "cell", format!("class {}", cell.class), "a text"));
        }
        all.extend(texts(reader, &cell, &mut budget)?);
        position = cell.end;
    }
    Ok(Elements::Text(all))
}

/// How characters are stored.
#[derive(Clone, Copy)]
enum Code {
    Latin1,
    Utf8,
    Utf16(bool),
    Utf32(bool),
}

impl Code {
    fn of(element: &Element, reader: &Reader) -> Result<Self, IoError> {
        match element.kind {
            1 | 2 => Ok(Code::Latin1),
            UTF8 => Ok(Code::Utf8),
            3 | 4 | UTF16 => Ok(Code::Utf16(reader.big_endian)),
            5 | 6 | UTF32 => Ok(Code::Utf32(reader.big_endian)),
            other => Err(reader.error(element.data, "type of a data element", other, "characters")),
        }
    }

    /// One number for each character as MATLAB counts them.
    fn units(self, bytes: &[u8]) -> Vec<u32> {
        match self {
            Code::Latin1 => bytes.iter().map(|byte| u32::from(*byte)).collect(),
            Code::Utf8 => String::from_utf8_lossy(bytes)
                .chars()
                .map(u32::from)
                .collect(),
            Code::Utf16(big_endian) => utf16(bytes, big_endian).collect(),
            Code::Utf32(big_endian) => utf32(bytes, big_endian).collect(),
        }
    }

    fn characters(self, units: impl Iterator<Item = u32>) -> String {
        let or_mark = |c: Option<char>| c.unwrap_or(char::REPLACEMENT_CHARACTER);
        match self {
            Code::Utf16(_) => char::decode_utf16(units.map(|unit| unit as u16))
                .map(|c| or_mark(c.ok()))
                .collect(),
            _ => units.map(|unit| or_mark(char::from_u32(unit))).collect(),
        }
    }

    fn text(self, bytes: &[u8]) -> String {
        match self {
            Code::Latin1 => bytes.iter().map(|byte| char::from(*byte)).collect(),
            Code::Utf8 => String::from_utf8_lossy(bytes).into_owned(),
            Code::Utf16(big_endian) => self.characters(utf16(bytes, big_endian)),
            Code::Utf32(big_endian) => self.characters(utf32(bytes, big_endian)),
        }
    }
}

fn utf16(bytes: &[u8], big_endian: bool) -> impl Iterator<Item = u32> {
    let (pairs, _) = bytes.as_chunks::<2>();
    pairs.iter().map(move |pair| match big_endian {
        true => u32::from(u16::from_be_bytes(*pair)),
        false => u32::from(u16::from_le_bytes(*pair)),
    })
}

fn utf32(bytes: &[u8], big_endian: bool) -> impl Iterator<Item = u32> {
    let (words, _) = bytes.as_chunks::<4>();
    words.iter().map(move |word| match big_endian {
        true => u32::from_be_bytes(*word),
        false => u32::from_le_bytes(*word),
    })
}
