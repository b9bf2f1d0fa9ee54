//! Fields of a universal file line: columns, blank-separated words, numbers and text. No I/O, and
//! no dataset's meaning.
//!
//! Records are laid out in Fortran columns, but many writers miss them by one or leave trailing
//! fields away. A record of numbers alone is therefore first read by words, when there are as many
//! words as fields, and else by columns.

pub(super) mod delimiter;
pub(super) mod fixed_columns;
pub(super) mod lines;
pub(super) mod records;

use crate::io::IoError;
use crate::io::formats::number;

/// Where a line starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Position {
    /// Line from 1; `None` behind the first binary block, where lines are not counted.
    pub line: Option<u64>,
    /// Byte from 0.
    pub byte: u64,
}

/// One line without its end, and where it starts.
#[derive(Clone, Debug)]
pub(super) struct Line {
    pub at: Position,
    pub bytes: Vec<u8>,
}

/// A field that is not what the format puts there.
#[derive(Clone, Debug)]
pub(super) struct FieldError {
    pub at: Position,
    pub what: &'static str,
    pub got: String,
    pub expected: String,
}

impl FieldError {
    /// For a whole line that does not hold its record.
    pub fn line(line: &Line, what: &'static str, expected: &str) -> Self {
        Self {
            at: line.at,
            what,
            got: text(&line.bytes),
            expected: expected.to_owned(),
        }
    }

    /// As the error of this stage: by line where lines are counted, else by byte.
    pub fn in_file(self, path: &str) -> IoError {
        let path = path.to_owned();
        match self.at.line {
            Some(line) => IoError::Text {
                path,
                line,
                what: self.what,
                got: self.got,
                expected: self.expected,
            },
            None => IoError::Binary {
                path,
                byte: self.at.byte,
                what: self.what,
                got: self.got,
                expected: self.expected,
            },
        }
    }
}

/// Number of a dataset and whether it is binary, when a line is nothing but a dataset's first line
/// (`    58`, `   151`, or `    58b` with the description of its block behind it).
pub(super) fn dataset_number(bytes: &[u8]) -> Option<(u32, bool)> {
    let words = words(bytes);
    let first = words.first()?;
    let (digits, binary) = match first.strip_suffix(b"b").or(first.strip_suffix(b"B")) {
        Some(digits) => (digits, true),
        None => (*first, false),
    };
    let numeric = (1..=5).contains(&digits.len()) && digits.iter().all(u8::is_ascii_digit);
    let alone = binary || words.len() == 1;
    (numeric && alone).then(|| Some((integer(digits)? as u32, binary)))?
}

/// Text of a field without blanks around it. Bytes that are not UTF-8 are read as Latin-1, the code
/// of old systems.
pub(super) fn text(bytes: &[u8]) -> String {
    let mut out = String::with_capacity(bytes.len());
    for chunk in bytes.utf8_chunks() {
        out.push_str(chunk.valid());
        out.extend(chunk.invalid().iter().map(|byte| char::from(*byte)));
    }
    out.trim_matches(|c: char| c.is_whitespace() || c == '\0')
        .to_owned()
}

/// As [`text`], with the format's word for nothing, `NONE`, made empty.
pub(super) fn text_or_none(bytes: &[u8]) -> String {
    let text = text(bytes);
    if text == "NONE" { String::new() } else { text }
}

/// Words between blanks.
pub(super) fn words(bytes: &[u8]) -> Vec<&[u8]> {
    bytes
        .split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
        .collect()
}

/// Bytes `start .. start + width`, as far as the line goes.
pub(super) fn column(bytes: &[u8], start: usize, width: usize) -> &[u8] {
    let end = (start + width).min(bytes.len());
    &bytes[start.min(end)..end]
}

/// Consecutive columns, without blanks around them.
pub(super) fn columns<'a>(bytes: &'a [u8], widths: &[usize]) -> Vec<&'a [u8]> {
    let mut start = 0;
    let mut out = Vec::with_capacity(widths.len());
    for width in widths {
        out.push(column(bytes, start, *width).trim_ascii());
        start += width;
    }
    out
}

/// Reads a record of numbers: by words when every field has one, else by columns, where an empty
/// field is left to `parse`.
pub(super) fn numeric_record<T>(
    bytes: &[u8],
    widths: &[usize],
    parse: impl Fn(&[&[u8]]) -> Option<T>,
) -> Option<T> {
    let words = words(bytes);
    let by_words = (words.len() == widths.len()).then(|| parse(&words));
    by_words
        .flatten()
        .or_else(|| parse(&columns(bytes, widths)))
}

/// A whole number.
pub(super) fn integer(bytes: &[u8]) -> Option<i64> {
    std::str::from_utf8(bytes.trim_ascii()).ok()?.parse().ok()
}

/// A whole number, where an empty field means 0 as it does in Fortran.
pub(super) fn integer_or_zero(bytes: &[u8]) -> Option<i64> {
    if bytes.trim_ascii().is_empty() {
        Some(0)
    } else {
        integer(bytes)
    }
}

/// A number as Fortran writes it: `1.5`, `1.5E-05`, `1.5D-05`, `1.5E-005`, `1.5-105`. `NaN`, `Inf`
/// and what C libraries print for them are taken as such; digits that overflow are not a number.
pub(super) fn number(bytes: &[u8]) -> Option<f64> {
    number::fortran_field(bytes)
}

/// A finite number.
pub(super) fn finite(bytes: &[u8]) -> Option<f64> {
    number(bytes).filter(|value| value.is_finite())
}

/// Half a unit of the last printed digit: 5e-11 for `1.95313E-05`. `None` when it is not a number.
pub(super) fn half_unit(bytes: &[u8]) -> Option<f64> {
    finite(bytes)?;
    let plain = std::str::from_utf8(bytes.trim_ascii()).ok()?;
    let unsigned = plain.trim_start_matches(['+', '-']);
    let end = unsigned.find(['E', 'e', 'D', 'd', '+', '-']);
    let (mantissa, exponent) = unsigned.split_at(end.unwrap_or(unsigned.len()));
    let exponent = exponent.trim_start_matches(['E', 'e', 'D', 'd']);
    let exponent: i32 = if exponent.is_empty() {
        0
    } else {
        exponent.parse().ok()?
    };
    let decimals = mantissa.split_once('.').map_or(0, |(_, part)| part.len());
    let unit = 0.5 * 10f64.powi(exponent.checked_sub(i32::try_from(decimals).ok()?)?);
    unit.is_finite().then_some(unit)
}

/// Numbers of rows of data, and how exactly every `stride`-th of them was printed where that is
/// asked for.
#[derive(Debug, Default)]
pub(super) struct Numbers {
    pub values: Vec<f64>,
    /// Stride, and half a unit of the last printed digit of the numbers 0, stride, 2 stride, ...
    pub half_units: Option<(usize, Vec<f64>)>,
}

impl Numbers {
    #[inline]
    fn push(&mut self, value: f64, text: &[u8]) {
        if let Some((stride, half_units)) = &mut self.half_units
            && self.values.len().is_multiple_of(*stride)
        {
            half_units.push(half_unit(text).unwrap_or(0.0));
        }
        self.values.push(value);
    }

    fn truncate(&mut self, len: usize) {
        self.values.truncate(len);
        if let Some((stride, half_units)) = &mut self.half_units {
            half_units.truncate(len.div_ceil(*stride));
        }
    }
}

/// Adds the numbers of a row of data to `out`: parted by blanks or by their signs, else by columns
/// of `width`.
///
/// # Errors
/// The text that is not a number; `out` is then as it was.
pub(super) fn data_row(bytes: &[u8], width: usize, out: &mut Numbers) -> Result<(), String> {
    let before = out.values.len();
    let mut at = 0;
    while let Some(blanks) = bytes[at..].iter().position(|b| !b.is_ascii_whitespace()) {
        at += blanks;
        let found = number::fortran_prefix(&bytes[at..]).map(|(value, len)| (value, at + len));
        match found {
            Some((value, end)) if ends_number(bytes.get(end)) => {
                out.push(value, &bytes[at..end]);
                at = end;
            }
            _ => {
                out.truncate(before);
                return odd_row(bytes, width, out);
            }
        }
    }
    Ok(())
}

/// Whether a number may end before this byte: a blank, a sign that begins the next number, or
/// nothing.
#[inline]
fn ends_number(next: Option<&u8>) -> bool {
    next.is_none_or(|byte| byte.is_ascii_whitespace() || matches!(byte, b'+' | b'-'))
}

/// A row with `NaN` or another word for a value that is not finite, with numbers that touch without
/// a sign, or with text that is no number.
#[cold]
fn odd_row(bytes: &[u8], width: usize, out: &mut Numbers) -> Result<(), String> {
    let before = out.values.len();
    for word in words(bytes) {
        match number(word) {
            Some(value) => out.push(value, word),
            None if split_at_signs(word, out) => {}
            None => {
                out.truncate(before);
                return fixed_row(bytes, width, out).ok_or_else(|| text(word));
            }
        }
    }
    Ok(())
}

/// `1.5E+00-2.5E+00` as two numbers; changes nothing and says false when that is not what it is.
fn split_at_signs(word: &[u8], out: &mut Numbers) -> bool {
    let before = out.values.len();
    let mut at = 0;
    while at < word.len() {
        let rest = &word[at..];
        let found = number::non_finite_prefix(rest, b'.').or_else(|| number::fortran_prefix(rest));
        match found {
            Some((value, len)) if ends_number(word.get(at + len)) => {
                out.push(value, &word[at..at + len]);
                at += len;
            }
            _ => {
                out.truncate(before);
                return false;
            }
        }
    }
    true
}

/// Fields of a width stand to the right of their columns, so that a row of them is a multiple of it
/// long.
fn fixed_row(bytes: &[u8], width: usize, out: &mut Numbers) -> Option<()> {
    let row = bytes.trim_ascii_end();
    if !row.len().is_multiple_of(width) {
        return None;
    }
    let before = out.values.len();
    for field in row.chunks(width) {
        match number(field) {
            Some(value) => out.push(value, field),
            None => {
                out.truncate(before);
                return None;
            }
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_as_fortran_writes_them() {
        for (text, expected) in [
            ("1.5", 1.5_f64),
            ("-1.5D-05", -1.5e-5),
            ("5.00000E-005", 5e-5),
            (" +2.5e3 ", 2500.0),
            ("1.25-105", 1.25e-105),
            ("-1.+102", -1e102),
            ("5-105", 5e-105),
        ] {
            assert_eq!(
                number(text.as_bytes()).map(f64::to_bits),
                Some(expected.to_bits()),
                "{text}"
            );
        }
        for text in ["", "1.5x", "1E400", "--1", "1.5-2.5", "1 2", "-", "+105"] {
            assert_eq!(
                number(text.as_bytes()),
                if text == "+105" { Some(105.0) } else { None },
                "{text}"
            );
        }
        assert!(number(b"NaN").expect("a word for no number").is_nan());
    }

    #[test]
    fn half_a_unit_follows_digits_and_exponent() {
        for (text, expected) in [
            ("1.95313E-05", 5e-11),
            ("5.00000E-005", 5e-11),
            ("1.953125D-05", 5e-12),
            ("0.01", 5e-3),
            ("3", 0.5),
            ("-1.25-105", 5e-108),
        ] {
            let got = half_unit(text.as_bytes()).expect("a number");
            assert!((got / expected - 1.0).abs() < 1e-12, "{text}: {got}");
        }
        assert_eq!(half_unit(b"1.0E-99999999999"), None);
    }

    #[test]
    fn touching_fields_are_separated() {
        let row = |text: &str, width| {
            let mut out = Numbers {
                values: vec![7.0],
                half_units: None,
            };
            data_row(text.as_bytes(), width, &mut out).map(|()| out.values[1..].to_vec())
        };
        assert_eq!(
            row("-1.00000E-005-2.00000E+000 3.0", 13).expect("numbers alone"),
            [-1e-5, -2.0, 3.0]
        );
        assert_eq!(
            row("1.00000E+0002.00000E+000", 13).unwrap_err(),
            "1.00000E+0002.00000E+000"
        );
        assert_eq!(
            row(" 1.00000E+0002.000000E+000", 13).expect("numbers alone"),
            [1.0, 2.0]
        );
        assert_eq!(row("1.0 2.0 oops", 13).unwrap_err(), "oops");
        assert!(row("   ", 13).expect("numbers alone").is_empty());
        let odd = row("1.5E+00-2.5E+00 NaN", 13).expect("numbers alone");
        assert_eq!((&odd[..2], odd[2].is_nan()), (&[1.5, -2.5][..], true));
        let odd = row("1.#QNAN0E+00-1.#IND0E+00-inf+1.#INF 2.5-nan(ind)", 13);
        let odd = odd.expect("numbers and words for none");
        let is_nan: Vec<bool> = odd.iter().map(|value| value.is_nan()).collect();
        assert_eq!(is_nan, [true, true, false, false, false, true]);
        assert_eq!(&odd[2..5], [f64::NEG_INFINITY, f64::INFINITY, 2.5]);
    }

    #[test]
    fn dataset_lines_are_distinguished_from_others() {
        assert_eq!(dataset_number(b"    58   "), Some((58, false)));
        assert_eq!(dataset_number(b"    58b     1     2"), Some((58, true)));
        for line in ["", "58 1", "-1", "580000", "b", "58c"] {
            assert_eq!(dataset_number(line.as_bytes()), None, "{line}");
        }
    }

    #[test]
    fn latin_1_bytes_become_their_characters() {
        assert_eq!(text(b" m/s\xB2 \0"), "m/s²");
        assert_eq!(text("m/s²".as_bytes()), "m/s²");
        assert_eq!(text_or_none(b"NONE  "), "");
    }
}
