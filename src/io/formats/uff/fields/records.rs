//! Records of a text dataset one after the other, where a record may be wrapped over several lines.
//! No dataset's meaning.
//!
//! Nothing is reserved for a count that a file states: numbers are taken row by row, as far as
//! there are rows.

use super::{FieldError, Line, Numbers, Position, columns, data_row, integer, words};

/// Columns of a whole number.
const INTEGER_COLUMNS: usize = 10;

/// The lines of a dataset that are not read yet.
pub(in crate::io::formats::uff) struct Records<'a> {
    lines: &'a [Line],
    /// Where the line before starts, for messages when there is no further one.
    at: Position,
}

impl<'a> Records<'a> {
    /// All `lines` of a dataset whose first line, with its number, is `first`.
    pub fn new(lines: &'a [Line], first: &Line) -> Self {
        Self {
            lines,
            at: first.at,
        }
    }

    /// The next line, whatever is in it.
    pub fn line(&mut self, what: &'static str) -> Result<&'a Line, FieldError> {
        let Some((line, rest)) = self.lines.split_first() else {
            return Err(FieldError {
                at: self.at,
                what,
                got: "the end of the dataset".to_owned(),
                expected: "another line".to_owned(),
            });
        };
        self.lines = rest;
        self.at = line.at;
        Ok(line)
    }

    /// The next line that is not blank, without taking it.
    pub fn peek(&mut self) -> Option<&'a Line> {
        while let Some((line, rest)) = self.lines.split_first() {
            if !line.bytes.trim_ascii().is_empty() {
                return Some(line);
            }
            self.lines = rest;
        }
        None
    }

    /// The next line that is not blank.
    pub fn filled(&mut self, what: &'static str) -> Result<&'a Line, FieldError> {
        self.peek();
        self.line(what)
    }

    /// The whole numbers of the next line that is not blank.
    pub fn integer_row(&mut self, what: &'static str) -> Result<(&'a Line, Vec<i64>), FieldError> {
        let line = self.filled(what)?;
        let row = integer_row(line)
            .ok_or_else(|| FieldError::line(line, what, "whole numbers in columns of 10"))?;
        Ok((line, row))
    }

    /// `count` whole numbers over as many lines as they take; the last line may be filled up with
    /// zeros.
    pub fn integers(&mut self, count: usize, what: &'static str) -> Result<Vec<i64>, FieldError> {
        let mut numbers = Vec::new();
        while numbers.len() < count {
            let (line, row) = self.integer_row(what)?;
            numbers.extend(row);
            if numbers.iter().skip(count).any(|filler| *filler != 0) {
                return Err(FieldError::line(line, what, &format!("{count} numbers")));
            }
        }
        numbers.truncate(count);
        Ok(numbers)
    }

    /// Adds `count` numbers of `width` columns to `out`, over as many lines as they take; all of
    /// them finite.
    pub fn numbers(
        &mut self,
        count: usize,
        width: usize,
        what: &'static str,
        out: &mut Vec<f64>,
    ) -> Result<(), FieldError> {
        let wanted = out.len().saturating_add(count);
        while out.len() < wanted {
            let line = self.number_row(width, what, out)?;
            if out.len() > wanted {
                return Err(FieldError::line(line, what, &format!("{count} numbers")));
            }
        }
        Ok(())
    }

    /// Adds the numbers of the next line that is not blank to `out`; all of them finite.
    pub fn number_row(
        &mut self,
        width: usize,
        what: &'static str,
        out: &mut Vec<f64>,
    ) -> Result<&'a Line, FieldError> {
        let line = self.filled(what)?;
        let mut row = Numbers::default();
        let read = data_row(&line.bytes, width, &mut row);
        if read.is_err() || !row.values.iter().all(|value| value.is_finite()) {
            let expected = format!("numbers in columns of {width}");
            return Err(FieldError::line(line, what, &expected));
        }
        out.append(&mut row.values);
        Ok(line)
    }
}

/// The whole numbers of a line: by words, else by columns of 10, where fields touch.
pub(in crate::io::formats::uff) fn integer_row(line: &Line) -> Option<Vec<i64>> {
    let parse = |fields: Vec<&[u8]>| fields.into_iter().map(integer).collect::<Option<Vec<_>>>();
    parse(words(&line.bytes)).or_else(|| {
        let widths = vec![INTEGER_COLUMNS; line.bytes.len().div_ceil(INTEGER_COLUMNS)];
        let fields = columns(&line.bytes, &widths);
        parse(fields.into_iter().filter(|f| !f.is_empty()).collect())
    })
}

/// Whether a line is nothing but one whole number without sign, as the label of a node is.
pub(in crate::io::formats::uff) fn is_label(line: &Line) -> bool {
    let label = line.bytes.trim_ascii();
    !label.is_empty() && label.iter().all(u8::is_ascii_digit)
}
