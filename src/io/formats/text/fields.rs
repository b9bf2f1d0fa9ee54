//! One line of a table: its fields, and its numbers.

use crate::printable::counted;
use num_complex::Complex64;

use super::complex;
use crate::io::formats::number;
use crate::io::{Delimiter, IoError};

/// How a table writes its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Notation {
    /// Field separator.
    pub delimiter: Delimiter,
    /// Decimal mark.
    pub decimal: u8,
}

impl Delimiter {
    /// The byte that separates fields; `None` for runs of blanks.
    pub(super) fn byte(self) -> Option<u8> {
        match self {
            Delimiter::Comma => Some(b','),
            Delimiter::Semicolon => Some(b';'),
            Delimiter::Tab => Some(b'\t'),
            Delimiter::Blank => None,
        }
    }

    /// Its name in a scene.
    pub(super) fn name(self) -> &'static str {
        match self {
            Delimiter::Comma => "comma",
            Delimiter::Semicolon => "semicolon",
            Delimiter::Tab => "tab",
            Delimiter::Blank => "blank",
        }
    }
}

/// Whether a line holds nothing that is read: blanks alone, or a comment.
pub(super) fn is_passed_over(line: &[u8]) -> bool {
    matches!(line.trim_ascii_start().first(), None | Some(b'#' | b'%'))
}

/// Fields of a line, without the blanks and quotes around them and without empty fields at the end.
/// A quoted field and a complex number may hold the separator.
pub(super) fn fields(line: &[u8], delimiter: Delimiter) -> Vec<&[u8]> {
    let mut found: Vec<&[u8]> = Vec::new();
    let Some(separator) = delimiter.byte() else {
        let mut rest = line.trim_ascii();
        while !rest.is_empty() {
            let (word, behind) = rest.split_at(word_end(rest));
            found.push(unquoted(word));
            rest = behind.trim_ascii_start();
        }
        return found;
    };
    let mut rest = line;
    loop {
        let end = field_end(rest, separator);
        found.push(unquoted(&rest[..end]));
        match rest.get(end + 1..) {
            Some(behind) => rest = behind,
            None => break,
        }
    }
    while found.last().is_some_and(|field| field.is_empty()) {
        found.pop();
    }
    found
}

/// Where the word at the start of a text ends: at a blank, or behind a complex number with blanks
/// inside.
fn word_end(text: &[u8]) -> usize {
    let is_blank_at = |end: &usize| text.get(*end).is_none_or(u8::is_ascii_whitespace);
    let complex = complex_end(text).filter(is_blank_at);
    let blank = || text.iter().position(u8::is_ascii_whitespace);
    complex.or_else(blank).unwrap_or(text.len())
}

/// Where the complex number at the start of a text ends, whatever its decimal mark.
fn complex_end(text: &[u8]) -> Option<usize> {
    let read = complex::prefix(text, b'.').or_else(|| complex::prefix(text, b','));
    read.map(|(_, len)| len)
}

/// Where the first field ends: at the separator that stands in no quotes, or at the end of the
/// line.
fn field_end(line: &[u8], separator: u8) -> usize {
    let text = line.trim_ascii_start();
    if text.first() != Some(&b'"') {
        // `(1.0,2.0)`
        let is_open = text.first() == Some(&b'(');
        let complex = is_open.then(|| complex_end(text)).flatten();
        let start = complex.map_or(0, |len| line.len() - text.len() + len);
        let end = memchr::memchr(separator, &line[start..]);
        return end.map_or(line.len(), |end| start + end);
    }
    let mut inside = false;
    let end = line.iter().position(|byte| {
        inside ^= *byte == b'"';
        *byte == separator && !inside
    });
    end.unwrap_or(line.len())
}

fn unquoted(field: &[u8]) -> &[u8] {
    let field = field.trim_ascii();
    match field {
        [b'"', inner @ .., b'"'] => inner.trim_ascii(),
        _ => field,
    }
}

/// A date or a time of day: digits with at least one colon, or two of `-`, `/`, `.`, between them.
pub(super) fn is_stamp(field: &[u8]) -> bool {
    let count = |wanted: &[u8]| field.iter().filter(|byte| wanted.contains(byte)).count();
    let legal = |byte: &u8| byte.is_ascii_digit() || b":-/. TZ".contains(byte);
    field.first().is_some_and(u8::is_ascii_digit)
        && field.iter().all(legal)
        && (count(b":") > 0 || count(b"-/.") >= 2)
}

/// A field of a row of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Cell {
    /// A date, a time of day or an empty field between others.
    Other,
    /// A real number.
    Real(f64),
    /// A complex number.
    Complex(Complex64),
}

impl Cell {
    fn of(field: &[u8], decimal: u8) -> Option<Self> {
        let real = number::field(field, decimal).map(Cell::Real);
        real.or_else(|| complex::field(field, decimal).map(Cell::Complex))
    }
}

/// Numbers of a row into `row`. False for a line that is no row: without a number, or with any
/// text that is no date and no time of day.
pub(super) fn row_of(line: &[u8], notation: Notation, row: &mut Vec<Cell>) -> bool {
    row.clear();
    for field in fields(line, notation.delimiter) {
        let cell = Cell::of(field, notation.decimal);
        if cell.is_none() && !field.is_empty() && !is_stamp(field) {
            return false;
        }
        row.push(cell.unwrap_or(Cell::Other));
    }
    row.iter().any(|cell| *cell != Cell::Other)
}

/// Where the value of a column goes among the numbers of a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slot {
    /// Index of the real number, or of the real part.
    pub index: usize,
    /// Whether the column is complex; the imaginary part then follows the real one.
    pub is_complex: bool,
}

impl Slot {
    /// For a real number.
    pub fn real(index: usize) -> Self {
        Self {
            index,
            is_complex: false,
        }
    }

    /// Numbers of the column in a row.
    pub fn numbers(self) -> usize {
        1 + usize::from(self.is_complex)
    }
}

/// Which columns of a row are wanted, and how many columns there are.
#[derive(Clone, Debug)]
pub(super) struct RowShape {
    /// How the numbers are written.
    pub notation: Notation,
    /// Number of columns.
    pub width: usize,
    /// For each column where its value goes.
    pub slots: Vec<Option<Slot>>,
    /// Whether `NaN` and `inf` are values.
    pub any_value: bool,
}

impl RowShape {
    /// Numbers of a row.
    pub fn numbers(&self) -> usize {
        self.slots.iter().flatten().map(|slot| slot.numbers()).sum()
    }

    /// Reads the numbers of a line: its row, or nothing for a blank line or a comment.
    ///
    /// # Errors
    /// The fault of the line: subject, got, expected.
    pub fn read(&self, line: &[u8], row: &mut [f64]) -> Result<bool, RowFault> {
        if self.plain(line, b'\n', row) == Some(line.len()) {
            return Ok(true);
        }
        if is_passed_over(line) {
            return Ok(false);
        }
        self.careful(line, row).map(|()| true)
    }

    /// Reads a row that is written plainly, numbers and the separator alone, and says where its
    /// line ends in the text that begins with it, the line end included; `None` for anything else.
    pub fn plain(&self, text: &[u8], line_end: u8, row: &mut [f64]) -> Option<usize> {
        let separator = self.notation.delimiter.byte();
        let mut at = 0;
        for (column, slot) in self.slots.iter().enumerate() {
            at += blanks(&text[at..], separator);
            match slot {
                Some(slot) if slot.is_complex => {
                    let (value, len) = complex::prefix(&text[at..], self.notation.decimal)?;
                    [row[slot.index], row[slot.index + 1]] = [value.re, value.im];
                    at += len;
                }
                Some(slot) => {
                    let (value, len) = number::prefix(&text[at..], self.notation.decimal)?;
                    row[slot.index] = value;
                    at += len;
                }
                None if column == 0 && matches!(text.get(at), Some(b'#' | b'%')) => return None,
                None => at += passed_over(&text[at..], separator, line_end)?,
            }
            let gap = blanks(&text[at..], separator);
            at += gap;
            if column + 1 < self.width {
                match separator {
                    Some(separator) if text.get(at) == Some(&separator) => at += 1,
                    None if gap > 0 => {}
                    _ => return None,
                }
            }
        }
        let rest = &text[at..];
        let behind = rest.strip_prefix(b"\r").unwrap_or(rest);
        match behind.first() {
            None => Some(text.len()),
            Some(byte) if *byte == line_end => Some(text.len() - behind.len() + 1),
            // A lone CR that ends the line.
            Some(_) if rest.first() == Some(&line_end) => Some(at + 1),
            Some(_) => None,
        }
    }

    /// Reads a row in any of the ways that it can be written.
    fn careful(&self, line: &[u8], row: &mut [f64]) -> Result<(), RowFault> {
        let found = fields(line, self.notation.delimiter);
        if found.len() > self.width {
            return Err(RowFault {
                what: "fields of a row",
                got: format!("{} fields", found.len()),
                expected: format!("{}, as many as in the other rows", self.width),
            });
        }
        for (column, slot) in self.slots.iter().enumerate() {
            let Some(slot) = slot else { continue };
            let fault = |got: String| RowFault {
                what: "number",
                got,
                expected: match slot.is_complex {
                    true => format!("a finite complex number in column {}", column + 1),
                    false => format!("a finite number in column {}", column + 1),
                },
            };
            let field = found
                .get(column)
                .ok_or_else(|| fault(counted(found.len(), "column")))?;
            let value = match Cell::of(field, self.notation.decimal) {
                Some(Cell::Real(value)) => Some(Complex64::from(value)),
                Some(Cell::Complex(value)) if slot.is_complex => Some(value),
                _ => None,
            };
            let value = value.filter(|value| self.any_value || value.is_finite());
            let value = value.ok_or_else(|| fault(super::encoding::text_of(field)))?;
            row[slot.index] = value.re;
            if slot.is_complex {
                row[slot.index + 1] = value.im;
            }
        }
        let separators = self.notation.delimiter.byte();
        let raw = separators.map_or(found.len(), |byte| {
            1 + memchr::memchr_iter(byte, line).count()
        });
        if raw < self.width {
            return Err(RowFault {
                what: "fields of a row",
                got: format!("{raw} fields"),
                expected: format!("{}, as many as in the other rows", self.width),
            });
        }
        Ok(())
    }
}

/// The error of a row.
#[derive(Debug)]
pub(super) struct RowFault {
    what: &'static str,
    got: String,
    expected: String,
}

impl RowFault {
    /// The error at its line.
    pub fn at(self, path: &str, line: u64) -> IoError {
        IoError::Text {
            path: path.to_owned(),
            line,
            what: self.what,
            got: self.got,
            expected: self.expected,
        }
    }
}

/// Blanks before or behind a number, the separator not among them.
#[inline]
fn blanks(bytes: &[u8], separator: Option<u8>) -> usize {
    let blank = |byte: &u8| *byte == b' ' || (*byte == b'\t' && separator != Some(b'\t'));
    let mut count = 0;
    while bytes.get(count).is_some_and(blank) {
        count += 1;
    }
    count
}

/// Length of a field that is not wanted; `None` where a quote makes it a matter for the careful
/// way.
fn passed_over(text: &[u8], separator: Option<u8>, line_end: u8) -> Option<usize> {
    let end = match separator {
        Some(separator) => memchr::memchr2(separator, line_end, text),
        None => memchr::memchr3(b' ', b'\t', line_end, text),
    };
    let field = &text[..end.unwrap_or(text.len())];
    (!field.trim_ascii().is_empty() && !field.contains(&b'"')).then_some(field.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(delimiter: Delimiter, decimal: u8, slots: &[Option<usize>]) -> RowShape {
        RowShape {
            notation: Notation { delimiter, decimal },
            width: slots.len(),
            slots: slots.iter().map(|slot| slot.map(Slot::real)).collect(),
            any_value: false,
        }
    }

    #[test]
    fn quoted_fields_and_trailing_separators_are_understood() {
        let of = |line: &'static str, delimiter| fields(line.as_bytes(), delimiter);
        assert_eq!(
            of("\"a, b\" , c,, ", Delimiter::Comma),
            [&b"a, b"[..], b"c"]
        );
        assert_eq!(of(" 1 \t 2 ", Delimiter::Blank), [b"1", b"2"]);
        assert_eq!(of("1;;3;", Delimiter::Semicolon), [&b"1"[..], b"", b"3"]);
        assert_eq!(
            of("1 2 + 3i  (4+5j)", Delimiter::Blank),
            [&b"1"[..], b"2 + 3i", b"(4+5j)"]
        );
        assert_eq!(
            of("1, (2,3) ,4-5i", Delimiter::Comma),
            [&b"1"[..], b"(2,3)", b"4-5i"]
        );
        assert!(of("", Delimiter::Tab).is_empty());
    }

    #[test]
    fn dates_and_times_are_no_numbers_and_no_text() {
        for stamp in ["10:15:00.5", "2024-01-31", "31.12.2023 10:00"] {
            assert!(is_stamp(stamp.as_bytes()), "{stamp}");
        }
        for other in ["1.5", "x:1", "-1", "1-2", ""] {
            assert!(!is_stamp(other.as_bytes()), "{other}");
        }
    }

    #[test]
    fn a_plain_row_is_read_as_the_slow_way_reads_it() {
        let all = [Some(0), None, Some(1)];
        for (text, delimiter, decimal) in [
            ("1.5, x y,-2", Delimiter::Comma, b'.'),
            (" 1,5 ;7; -2 ", Delimiter::Semicolon, b','),
            ("1.5\t7\t-2", Delimiter::Tab, b'.'),
            ("  1.5 \t x   -2  ", Delimiter::Blank, b'.'),
        ] {
            let shape = shape(delimiter, decimal, &all);
            let (mut fast, mut slow) = ([0.0; 2], [0.0; 2]);
            for (end, line_end) in [("", b'\n'), ("\n7", b'\n'), ("\r\n", b'\n'), ("\r7", b'\r')] {
                let whole = format!("{text}{end}");
                let used = shape.plain(whole.as_bytes(), line_end, &mut fast);
                assert_eq!(used, Some(whole.trim_end_matches('7').len()), "{whole:?}");
            }
            shape.careful(text.as_bytes(), &mut slow).unwrap();
            assert_eq!(fast.map(f64::to_bits), [1.5f64, -2.0].map(f64::to_bits));
            assert_eq!(fast.map(f64::to_bits), slow.map(f64::to_bits));
        }
    }

    #[test]
    fn a_comment_is_no_row_even_if_its_first_field_is_unused() {
        let shape = shape(Delimiter::Comma, b'.', &[None, Some(0)]);
        let mut row = [0.0];
        assert!(!shape.read(b"# 1,2", &mut row).unwrap());
        assert_eq!(shape.plain(b"# 1,2\n3,4\n", b'\n', &mut row), None);
        assert_eq!(shape.plain(b"x\n3,4\n", b'\n', &mut row), None);
        assert_eq!(shape.plain(b"3,4\n5,6\n", b'\n', &mut row), Some(4));
    }

    #[test]
    fn a_row_too_short_too_long_or_no_number_is_named() {
        let shape = shape(Delimiter::Comma, b'.', &[Some(0), None]);
        let fault = |line: &str| {
            let mut row = [0.0];
            let read = shape.read(line.as_bytes(), &mut row);
            read.map_err(|fault| fault.got)
        };
        assert_eq!(fault("1").unwrap_err(), "1 fields");
        assert_eq!(fault("1,2,3").unwrap_err(), "3 fields");
        assert_eq!(fault("x,2").unwrap_err(), "x");
        assert_eq!(fault("nan,2").unwrap_err(), "nan");
        assert_eq!(fault(",2").unwrap_err(), "");
        assert!(fault("1,2,").unwrap() && fault("\"1\",").unwrap());
        assert!(!fault(" # note").unwrap() && !fault("  ").unwrap());
    }
}
