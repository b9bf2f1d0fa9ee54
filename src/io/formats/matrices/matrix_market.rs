//! Matrix Market files: one real matrix as text, its entries by place (`coordinate`) or all of them
//! (`array`).
//!
//! | line | what it holds |
//! |---|---|
//! | 1 | `%%MatrixMarket matrix coordinate\|array real\|integer general\|symmetric\|skew-symmetric` |
//! | `%...` | comments |
//! | sizes | rows, columns and, of coordinates, the number of entries |
//! | entries | row and column from 1 and the value; of an array the value, column after column |
//!
//! Of a symmetric matrix the entries on and below the diagonal are there, of a skew one those
//! below. A pattern has no values and is refused, as are complex matrices. Entries of one place add
//! up.
//!
//! # Reference
//! Boisvert, Pozo and Remington (1996), The Matrix Market exchange formats, NISTIR 5935.

use std::io::BufRead;

use super::matrix_entries::MatrixEntries;
use crate::io::IoError;
use crate::io::formats::number;

/// The first characters of a file, in any case.
pub(super) const MARK: &[u8] = b"%%matrixmarket";

#[derive(Clone, Copy, PartialEq)]
enum Symmetry {
    General,
    Symmetric,
    Skew,
}

/// Reads a whole file.
///
/// # Errors
/// [`IoError::Text`] with the line; [`IoError::System`].
pub(super) fn read(input: impl BufRead, path: &str) -> Result<MatrixEntries, IoError> {
    let mut lines = Lines {
        input,
        path,
        number: 0,
        text: Vec::new(),
    };
    let (coordinates, symmetry) = lines.header()?;
    lines.next("size line")?;
    let sizes = lines.whole(if coordinates { 3 } else { 2 }, "size line")?;
    let mut found = MatrixEntries {
        rows: sizes[0],
        columns: sizes[1],
        entries: Vec::new(),
    };
    if symmetry != Symmetry::General && found.rows != found.columns {
        let expected = "as many rows as columns of a symmetric matrix";
        return Err(lines.error("size line", expected));
    }
    if coordinates {
        for _ in 0..sizes[2] {
            lines.next("entry")?;
            let (row, column, value) = lines.entry(&found)?;
            lines.push(&mut found, row, column, value, symmetry)?;
        }
    } else {
        for column in 0..found.columns {
            let first = match symmetry {
                Symmetry::General => 0,
                Symmetry::Symmetric => column,
                Symmetry::Skew => column + 1,
            };
            for row in first..found.rows {
                lines.next("value")?;
                let value = lines.value(&lines.fields(1, "value")?[0])?;
                lines.push(&mut found, row, column, value, symmetry)?;
            }
        }
    }
    lines.end()?;
    Ok(found)
}

/// The lines of a file that are not comments.
struct Lines<'a, R> {
    input: R,
    path: &'a str,
    /// Of the line in `text`, from 1.
    number: u64,
    text: Vec<u8>,
}

impl<R: BufRead> Lines<'_, R> {
    fn error(&self, what: &'static str, expected: &str) -> IoError {
        let text = String::from_utf8_lossy(&self.text);
        IoError::Text {
            path: self.path.to_owned(),
            line: self.number,
            what,
            got: text.trim_end().chars().take(60).collect(),
            expected: expected.to_owned(),
        }
    }

    /// The next line as it stands; `false` behind the last.
    fn read(&mut self) -> Result<bool, IoError> {
        self.text.clear();
        self.number += 1;
        let read = self.input.read_until(b'\n', &mut self.text);
        let read = read.map_err(|source| IoError::System {
            path: self.path.to_owned(),
            action: "read",
            source,
        })?;
        Ok(read > 0)
    }

    /// Goes to the next line that says something.
    fn next(&mut self, what: &'static str) -> Result<(), IoError> {
        while self.read()? {
            let text = self.text.trim_ascii();
            if !text.is_empty() && !text.starts_with(b"%") {
                return Ok(());
            }
        }
        Err(self.error(what, "another line; the file ends"))
    }

    /// Nothing but blank lines is left.
    fn end(&mut self) -> Result<(), IoError> {
        while self.read()? {
            let text = self.text.trim_ascii();
            if !text.is_empty() && !text.starts_with(b"%") {
                return Err(self.error("line behind the last entry", "the end of the file"));
            }
        }
        Ok(())
    }

    /// Whether entries have places, and which of them are there.
    fn header(&mut self) -> Result<(bool, Symmetry), IoError> {
        self.read()?;
        let text = String::from_utf8_lossy(&self.text).to_lowercase();
        let words: Vec<&str> = text.split_whitespace().collect();
        let [mark, "matrix", format, field, symmetry] = words[..] else {
            let expected = "%%MatrixMarket matrix FORMAT FIELD SYMMETRY";
            return Err(self.error("header", expected));
        };
        let coordinates = match format {
            "coordinate" => true,
            "array" => false,
            _ => return Err(self.error("header", "coordinate or array")),
        };
        if mark.as_bytes() != MARK || !matches!(field, "real" | "double" | "integer") {
            return Err(self.error("header", "%%MatrixMarket with a real or integer field"));
        }
        let symmetry = match symmetry {
            "general" => Symmetry::General,
            "symmetric" => Symmetry::Symmetric,
            "skew-symmetric" => Symmetry::Skew,
            _ => return Err(self.error("header", "general, symmetric or skew-symmetric")),
        };
        Ok((coordinates, symmetry))
    }

    fn fields(&self, count: usize, what: &'static str) -> Result<Vec<Vec<u8>>, IoError> {
        let words = self.text.split(u8::is_ascii_whitespace);
        let words: Vec<Vec<u8>> = words
            .filter(|word| !word.is_empty())
            .map(<[u8]>::to_vec)
            .collect();
        if words.len() == count {
            return Ok(words);
        }
        Err(self.error(what, &format!("{count} numbers")))
    }

    fn whole(&self, count: usize, what: &'static str) -> Result<Vec<usize>, IoError> {
        let parse = |word: &Vec<u8>| std::str::from_utf8(word).ok()?.parse().ok();
        let numbers: Option<Vec<usize>> = self.fields(count, what)?.iter().map(parse).collect();
        numbers.ok_or_else(|| self.error(what, &format!("{count} whole numbers")))
    }

    fn value(&self, word: &[u8]) -> Result<f64, IoError> {
        let value = number::fortran_field(word).filter(|value| value.is_finite());
        value.ok_or_else(|| self.error("value", "a finite number"))
    }

    fn entry(&self, found: &MatrixEntries) -> Result<(usize, usize, f64), IoError> {
        let words = self.fields(3, "entry")?;
        let index = |word: &[u8], most: usize| {
            let number: Option<usize> = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
            let inside = number.and_then(|number| number.checked_sub(1));
            inside.filter(|index| *index < most).ok_or_else(|| {
                let (rows, columns) = (found.rows, found.columns);
                self.error(
                    "entry",
                    &format!("a row from 1 to {rows} and a column from 1 to {columns}"),
                )
            })
        };
        let (row, column) = (
            index(&words[0], found.rows)?,
            index(&words[1], found.columns)?,
        );
        Ok((row, column, self.value(&words[2])?))
    }

    /// Keeps an entry with its mirror image.
    fn push(
        &self,
        found: &mut MatrixEntries,
        row: usize,
        column: usize,
        value: f64,
        symmetry: Symmetry,
    ) -> Result<(), IoError> {
        let (there, sign, expected) = match symmetry {
            Symmetry::General => (true, 0.0, ""),
            Symmetry::Symmetric => (row >= column, 1.0, "a place on or below the diagonal"),
            Symmetry::Skew => (row > column, -1.0, "a place below the diagonal"),
        };
        if !there {
            return Err(self.error("entry", expected));
        }
        found.entries.push((row, column, value));
        if symmetry != Symmetry::General && row != column {
            found.entries.push((column, row, sign * value));
        }
        Ok(())
    }
}
