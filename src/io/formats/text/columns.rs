//! The rows of a table to columns of numbers. Line numbers in errors are those of the file.

use crate::printable::counted;
use rayon::prelude::*;

use num_complex::Complex64;

use super::dialect::{ColumnKind, Dialect, columns_with_heading};
use super::encoding::TextBlocks;
use super::fields::{RowFault, RowShape, Slot};
use crate::io::columns::{Columns, RowLines};
use crate::io::{Block, ColumnName, Delimiter, IoError, TableSpec};

/// Rows of numbers, as far as they are good.
#[derive(Debug, Default)]
pub(super) struct Rows {
    /// Values of the wanted columns, real and imaginary parts of a complex one as two; empty when
    /// they were only counted.
    pub columns: Vec<Vec<f64>>,
    /// Number of rows.
    pub rows: usize,
    /// Where they stand.
    pub lines: RowLines,
    /// The first row that is none; nothing behind it was read.
    pub damage: Option<IoError>,
}

impl Rows {
    /// The damage as an error where there is no good row; `first_line` is the
    /// line of the first row.
    ///
    /// # Errors
    /// [`IoError::Text`].
    pub fn good(mut self, path: &str, first_line: u64) -> Result<Self, IoError> {
        match self.damage.take_if(|_| self.rows == 0) {
            Some(error) => Err(error),
            None if self.rows == 0 => Err(IoError::Text {
                path: path.to_owned(),
                line: first_line,
                what: "rows of numbers",
                got: "none".to_owned(),
                expected: "at least one row".to_owned(),
            }),
            None => Ok(self),
        }
    }
}

/// The use of the wanted columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wanted {
    /// Their finite values.
    Finite,
    /// Their values, `NaN` and `inf` among them.
    Any,
    /// Their rows are counted, whatever the values.
    Counted,
}

/// Reads rows from the next line on until the file ends or a row is bad. Parts of a block are read
/// in parallel; the rows and the first bad one are the same for any number of threads.
///
/// # Errors
/// [`IoError::System`] when the file cannot be read.
pub(super) fn read_rows(
    text: &mut TextBlocks,
    shape: &RowShape,
    keep: bool,
    path: &str,
) -> Result<Rows, IoError> {
    let count = shape.numbers();
    let mut read = Rows {
        columns: vec![Vec::new(); if keep { count } else { 0 }],
        ..Rows::default()
    };
    let (file_len, line_end) = (text.file_len(), text.line_end());
    let mut line = text.line() + 1;
    while read.damage.is_none() {
        let Some(block) = text.rest_of_block()? else {
            break;
        };
        let pieces = pieces(block, line_end);
        let part = |piece: &&[u8]| Part::read(piece, line_end, shape, keep);
        let parts: Vec<Part> = pieces.par_iter().map(part).collect();
        if read.rows == 0 {
            let rows = parts.iter().map(|part| part.rows).sum();
            let expected = expected_rows(file_len, block.len(), rows);
            for column in &mut read.columns {
                column.reserve_exact(expected);
            }
        }
        line = read.add(parts, line, path);
    }
    Ok(read)
}

/// Bytes of a piece that one thread reads at a time.
const PIECE: usize = 1 << 17;

/// A block of lines in pieces of whole lines.
fn pieces(block: &[u8], line_end: u8) -> Vec<&[u8]> {
    let (mut pieces, mut rest) = (Vec::new(), block);
    while !rest.is_empty() {
        let least = PIECE.min(rest.len());
        let end = memchr::memchr(line_end, &rest[least..]);
        let (piece, behind) = rest.split_at(end.map_or(rest.len(), |end| least + end + 1));
        pieces.push(piece);
        rest = behind;
    }
    pieces
}

/// Rows of one piece.
struct Part {
    columns: Vec<Vec<f64>>,
    rows: usize,
    /// Lines of the rows, the piece's first one being 0.
    lines: RowLines,
    /// Lines of the piece.
    line_count: u64,
    /// The first row that is none, and its line.
    fault: Option<(u64, RowFault)>,
}

impl Part {
    fn read(piece: &[u8], line_end: u8, shape: &RowShape, keep: bool) -> Self {
        let count = shape.numbers();
        let mut row = vec![0.0; count];
        // The rows that the first line promises; a number with its separator has two bytes.
        let first = memchr::memchr(line_end, piece).unwrap_or(piece.len());
        let rows = piece.len() / (first + 1).max(2 * count) + 1;
        let kept = if keep { count } else { 0 };
        let mut part = Self {
            columns: (0..kept).map(|_| Vec::with_capacity(rows)).collect(),
            rows: 0,
            lines: RowLines::default(),
            line_count: 0,
            fault: None,
        };
        let mut rest = piece;
        while !rest.is_empty() {
            let number = part.line_count;
            part.line_count += 1;
            if let Some(used) = shape.plain(rest, line_end, &mut row) {
                rest = &rest[used..];
            } else {
                let end = memchr::memchr(line_end, rest);
                let line = &rest[..end.unwrap_or(rest.len())];
                rest = end.map_or(&[], |end| &rest[end + 1..]);
                match shape.read(line.strip_suffix(b"\r").unwrap_or(line), &mut row) {
                    Ok(true) => {}
                    Ok(false) => continue,
                    Err(fault) => {
                        part.fault = Some((number, fault));
                        break;
                    }
                }
            }
            part.lines.push(part.rows, number);
            for (column, value) in part.columns.iter_mut().zip(&row) {
                column.push(*value);
            }
            part.rows += 1;
        }
        part
    }
}

impl Rows {
    /// Adds the rows of pieces up to the first fault; the first line has this number. Gives that of
    /// the line behind them.
    fn add(&mut self, mut parts: Vec<Part>, mut line: u64, path: &str) -> u64 {
        let faulty = parts.iter().position(|part| part.fault.is_some());
        parts.truncate(faulty.map_or(parts.len(), |part| part + 1));
        self.columns
            .par_iter_mut()
            .enumerate()
            .for_each(|(number, column)| {
                for part in &parts {
                    column.extend_from_slice(&part.columns[number]);
                }
            });
        for part in parts {
            self.lines.append(&part.lines, self.rows, line);
            self.rows += part.rows;
            self.damage = part.fault.map(|(at, fault)| fault.at(path, line + at));
            line += part.line_count;
        }
        line
    }
}

/// Rows that the file is likely to have, 1 % more for shorter ones; a row has at least two bytes.
fn expected_rows(file_len: u64, bytes_of_rows: usize, rows: usize) -> usize {
    let mean = bytes_of_rows as f64 / rows.max(1) as f64;
    let expected = 1.01 * file_len as f64 / mean.max(2.0);
    expected as usize + 1
}

/// Reads all rows of a table that is laid out so.
///
/// # Errors
/// [`IoError`] when there is no good row, or the file cannot be read.
pub(super) fn table_rows(
    text: &mut TextBlocks,
    dialect: &Dialect,
    columns: &[usize],
    wanted: Wanted,
    path: &str,
) -> Result<Rows, IoError> {
    for _ in 0..dialect.lines_before {
        text.next_line()?;
    }
    let mut slots = vec![None; dialect.width];
    let mut index = 0;
    for column in columns {
        let is_complex = dialect.kinds[*column] == ColumnKind::Complex;
        let slot = Slot { index, is_complex };
        slots[*column] = Some(slot);
        index += slot.numbers();
    }
    let shape = RowShape {
        notation: dialect.notation,
        width: dialect.width,
        slots,
        any_value: wanted != Wanted::Finite,
    };
    read_rows(text, &shape, wanted != Wanted::Counted, path)?
        .good(path, dialect.lines_before as u64 + 1)
}

/// Reads the columns at these places; the damage, where there is one.
///
/// # Errors
/// [`IoError`] for no good row, and when the file cannot be read.
pub(super) fn read_columns(
    text: &mut TextBlocks,
    dialect: &Dialect,
    places: &[usize],
    path: &str,
) -> Result<(Columns, Option<IoError>), IoError> {
    // A column may be named twice; it is read once.
    let mut once = places.to_vec();
    once.sort_unstable();
    once.dedup();
    let Rows {
        columns,
        rows,
        lines,
        damage,
    } = table_rows(text, dialect, &once, Wanted::Finite, path)?;
    let mut parts = columns.into_iter();
    let mut columns: Vec<Option<Block>> = Vec::with_capacity(once.len());
    for column in &once {
        let real = parts.next().unwrap_or_default();
        columns.push(Some(match dialect.kinds[*column] {
            ColumnKind::Complex => {
                let pairs = real.into_iter().zip(parts.next().unwrap_or_default());
                Block::Complex(pairs.map(|(re, im)| Complex64::new(re, im)).collect())
            }
            _ => Block::F64(real),
        }));
    }
    let mut values = Vec::with_capacity(places.len());
    for (index, place) in places.iter().enumerate() {
        let slot = once.binary_search(place).unwrap_or_default();
        let again = places[index + 1..].contains(place);
        let column = if again {
            columns[slot].clone()
        } else {
            columns[slot].take()
        };
        values.push(column.unwrap_or(Block::F64(Vec::new())));
    }
    let columns = Columns {
        values,
        rows,
        lines,
    };
    Ok((columns, damage))
}

/// Where the columns of the spec stand.
///
/// # Errors
/// [`IoError`] for a column that is not there, for a heading that occurs twice, and for headings
/// that are not as many as the fields below them.
pub(super) fn places(
    spec: &TableSpec,
    dialect: &Dialect,
    path: &str,
) -> Result<Vec<usize>, IoError> {
    let line = dialect
        .heading_line
        .unwrap_or(dialect.lines_before as u64 + 1);
    let missing = |got: String, expected: String| IoError::MissingColumn {
        path: path.to_owned(),
        line,
        got,
        expected,
    };
    let named = |column: &ColumnName| matches!(column, ColumnName::Heading(_));
    let headings = dialect.headings.len();
    if spec.columns.iter().any(|column| named(&column.column)) && headings < dialect.width {
        // Decimal commas or another separator, not numbers to pass over.
        return Err(IoError::Text {
            path: path.to_owned(),
            line: dialect.lines_before as u64 + 1,
            what: "fields of a row",
            got: format!("{} fields", dialect.width),
            expected: format!("{headings}, as many as headings"),
        });
    }
    headings_fit(dialect, path)?;
    let place = |column: &ColumnName| {
        match column {
        ColumnName::Number(0) => Err(missing(
            dialect.headings.join(", "),
            "numbers from 1".to_owned(),
        )),
        ColumnName::Number(number) if *number > dialect.width => Err(IoError::Text {
            path: path.to_owned(),
            line: dialect.lines_before as u64 + 1,
            what: "number",
            got: counted(dialect.width, "column"),
            expected: format!("a finite number in column {number}"),
        }),
        ColumnName::Number(number) => Ok(number - 1),
        ColumnName::Heading(name) => match columns_with_heading(&dialect.headings, name).as_slice() {
            [place, ..] if *place >= dialect.width => {
                Err(missing(dialect.headings.join(", "), name.clone()))
            }
            [place] => Ok(*place),
            [] => Err(missing(dialect.headings.join(", "), name.clone())),
            [first, second, ..] => Err(IoError::Text {
                path: path.to_owned(),
                line,
                what: "headings",
                got: format!("{name} in columns {} and {}", first + 1, second + 1),
                expected: "one column of that name, or the number or the whole heading in [[test.channel]]"
                    .to_owned(),
            }),
        },
    }
    };
    spec.columns
        .iter()
        .map(|column| place(&column.column))
        .collect()
}

/// Texts directly above numbers that commas part are as many as the numbers, or some of the commas
/// are decimal ones.
fn headings_fit(dialect: &Dialect, path: &str) -> Result<(), IoError> {
    let by_comma = dialect.notation.delimiter == Delimiter::Comma;
    let above = dialect.above.filter(|_| by_comma);
    match above.filter(|(_, texts)| *texts != dialect.width) {
        Some((line, texts)) => Err(IoError::NotStated {
            path: path.to_owned(),
            what: format!(
                "what separates the columns (line {line} has {texts} fields and the numbers below it {})",
                dialect.width
            ),
            expected: format!(
                "`delimiter` in [[test]], or `skip_lines = {line}` where that line has no headings"
            ),
        }),
        None => Ok(()),
    }
}
