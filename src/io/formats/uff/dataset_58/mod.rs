//! Dataset 58, a function at a degree of freedom: its header, from lines to fields. No I/O, and no
//! unit or axis is judged here (`meaning` does that); `binary_samples` and `text_samples` read the
//! values, and `byte_order` judges whether bytes have the stated order. `entry_header`,
//! `write_header` and `write_values` write an entry.
//!
//! The dataset's first line is `58` alone for text, or for a binary block (columns in Fortran terms
//! I6 A1 I6 I6 I12 I12):
//!
//! | field | meaning |
//! |---|---|
//! | `58b` | number and mark |
//! | byte order | 1 little endian, 2 big endian |
//! | float format | 2 IEEE 754; 1 (VAX) and 3 (IBM) are refused |
//! | text lines | number of header lines that follow, 11 |
//! | bytes | length of the block, often wrong |
//!
//! Header lines:
//!
//! | line | columns | fields |
//! |---|---|---|
//! | 1-5 | 80 A | ID lines, `NONE` for nothing |
//! | 6 | I5 I10 I5 I10, then twice 1X A10 I10 I4 | function type, function number, version, load case; response name, node, direction; reference name, node, direction |
//! | 7 | 3 I10, 3 E13.5 | data type (2, 4 real of 32 and 64 bits; 5, 6 complex of them), points, spacing (1 even, 0 uneven), first abscissa, its step, z |
//! | 8 | I10 3 I5, twice 1X A20 | abscissa: data type (17 time, 18 frequency), exponents of length, force and temperature, label, unit |
//! | 9 | as 8 | ordinate numerator: 8 displacement, 9 reaction force, 11 velocity, 12 acceleration, 13 excitation force, ... |
//! | 10 | as 8 | ordinate denominator |
//! | 11 | as 8 | z axis, not used |
//!
//! Then the values, one after the other, real part before imaginary part: as text 6 E13.5 to a line
//! for 32 bits and 4 E20.12 for 64 bits, or as bytes without any line end. An uneven abscissa
//! stands before each value: in text as E13.5 whatever the width of the values, as bytes of 32
//! bits, or of 64 bits where the values have them (the format's description says 32 bits always,
//! what is written is 64).

pub(super) mod axis;
pub(super) mod binary_samples;
pub(super) mod byte_order;
pub(super) mod dof_fields;
pub(super) mod entry_header;
pub(super) mod meaning;
pub(super) mod text_samples;
pub(super) mod value_width;
mod write_header;
pub(super) mod write_values;

use super::fields::{
    FieldError, Line, Position, column, columns, finite, half_unit, integer, integer_or_zero,
    numeric_record, text, text_or_none, words,
};
use crate::io::{Identification, SampleFormat};
use dof_fields::DofFields;

/// Header lines behind the dataset's first line.
pub(super) const HEADER_LINES: usize = 11;
/// More header lines than this are not believed.
const MAX_HEADER_LINES: i64 = 99;

/// The contents of the first line of a binary dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct BinaryLine {
    pub little_endian: bool,
    pub header_lines: usize,
    pub stated_bytes: u64,
}

/// The parts of a binary dataset as its first line states them, whatever it says of byte order and
/// float format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct BinaryExtent {
    pub header_lines: usize,
    pub stated_bytes: u64,
}

/// Characteristics of an abscissa or ordinate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Characteristic {
    /// Specific data type.
    pub code: i64,
    /// Unit text, `NONE` made empty.
    pub unit: String,
}

/// Start and step of an even abscissa as printed, each with half a unit of its last digit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spacing {
    pub start: f64,
    pub step: f64,
    pub start_half_unit: Option<f64>,
    pub step_half_unit: Option<f64>,
}

/// The fields of a header.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub at: Position,
    pub identification: Identification,
    pub function_type: i32,
    pub response: DofFields,
    pub reference: DofFields,
    pub format: SampleFormat,
    pub points: u64,
    /// Start and step of an even abscissa; `None` where an abscissa stands before each value.
    pub spacing: Option<Spacing>,
    /// Line of record 7, for messages.
    pub spacing_at: Position,
    /// Line of record 8, for messages.
    pub abscissa_at: Position,
    pub abscissa: Characteristic,
    pub numerator: Characteristic,
    pub denominator: Characteristic,
}

/// Reads the first line of a binary dataset.
pub(super) fn binary_line(line: &Line) -> Result<BinaryLine, FieldError> {
    let refuse = |expected: &str| FieldError::line(line, "binary dataset 58", expected);
    let numbers: Option<Vec<i64>> = binary_numbers(line).into_iter().collect();
    let numbers = numbers
        .ok_or_else(|| refuse("58b, byte order, float format, number of text lines, byte count"))?;
    if !matches!(numbers[0], 1 | 2) {
        return Err(refuse("byte order 1 (little endian) or 2 (big endian)"));
    }
    if numbers[1] != 2 {
        return Err(refuse("float format 2 (IEEE 754); 1 is VAX, 3 is IBM"));
    }
    let header_lines = match numbers[2] {
        0 => HEADER_LINES as i64,
        lines => lines,
    };
    if !(HEADER_LINES as i64..=MAX_HEADER_LINES).contains(&header_lines) {
        return Err(refuse("11 text lines"));
    }
    Ok(BinaryLine {
        little_endian: numbers[0] == 1,
        header_lines: header_lines as usize,
        stated_bytes: u64::try_from(numbers[3]).unwrap_or(0),
    })
}

/// Byte order, float format, number of text lines and byte count of the first line of a binary
/// dataset, each where it is a number.
fn binary_numbers(line: &Line) -> [Option<i64>; 4] {
    let words = words(&line.bytes);
    let by_columns = columns(&line.bytes, &[7, 6, 6, 12, 12]);
    // A byte count that fills its columns touches the number before it.
    let plain = |lines: &&[u8]| integer(lines).is_some_and(|n| n <= MAX_HEADER_LINES);
    let by_words = words.len() >= 5 && words.get(3).is_some_and(plain);
    let fields = if by_words { words } else { by_columns };
    std::array::from_fn(|index| integer(fields[index + 1]))
}

/// The parts of a binary dataset; eleven lines and no bytes where the first line states none that
/// can be believed.
pub(super) fn binary_extent(line: &Line) -> BinaryExtent {
    let [_, _, header_lines, stated_bytes] = binary_numbers(line);
    let believed =
        header_lines.filter(|count| (HEADER_LINES as i64..=MAX_HEADER_LINES).contains(count));
    BinaryExtent {
        header_lines: believed.map_or(HEADER_LINES, |count| count as usize),
        stated_bytes: stated_bytes.map_or(0, |bytes| u64::try_from(bytes).unwrap_or(0)),
    }
}

/// Reads the header from its (at least eleven) lines; `at` is where the dataset's first line
/// starts.
pub(super) fn header(at: Position, lines: &[Line]) -> Result<Header, FieldError> {
    let record_6 = function_record(&lines[5])?;
    let record_7 = spacing_record(&lines[6])?;
    Ok(Header {
        at,
        identification: Identification {
            version: record_6.version,
            load_case: record_6.load_case,
            lines: std::array::from_fn(|i| text_or_none(&lines[i].bytes)),
        },
        function_type: record_6.function_type,
        response: record_6.response,
        reference: record_6.reference,
        format: record_7.format,
        points: record_7.points,
        spacing: record_7.spacing,
        spacing_at: lines[6].at,
        abscissa_at: lines[7].at,
        abscissa: characteristic(&lines[7])?,
        numerator: characteristic(&lines[8])?,
        denominator: characteristic(&lines[9])?,
    })
}

struct FunctionRecord {
    function_type: i32,
    version: i64,
    load_case: i64,
    response: DofFields,
    reference: DofFields,
}

/// Record 6 by columns where no column's edge cuts a word, else by words (each name one word).
fn function_record(line: &Line) -> Result<FunctionRecord, FieldError> {
    const WIDTHS: [usize; 12] = [5, 10, 5, 10, 1, 10, 10, 4, 1, 10, 10, 4];
    /// Where a column ends, and the width of the next; 0 where a blank column stands at the edge.
    const EDGES: [(usize, usize); 11] = [
        (5, 10),
        (15, 5),
        (20, 10),
        (30, 0),
        (31, 0),
        (41, 10),
        (51, 4),
        (55, 0),
        (56, 0),
        (66, 10),
        (76, 4),
    ];
    let by_columns: Vec<&[u8]> = columns(&line.bytes, &WIDTHS)
        .into_iter()
        .enumerate()
        .filter_map(|(i, field)| (i != 4 && i != 8).then_some(field))
        .collect();
    let by_words = words(&line.bytes);
    let cuts = EDGES.iter().filter(|edge| cuts_a_word(&line.bytes, edge.0));
    let from_columns = || function_fields(&by_columns);
    let from_words = || {
        (by_words.len() == by_columns.len())
            .then(|| function_fields(&by_words))
            .flatten()
    };
    let record = if cuts.clone().next().is_none() {
        from_columns().or_else(from_words)
    } else {
        // Two fields may touch where the right one fills its columns.
        let touching = cuts
            .clone()
            .all(|edge| is_full(&line.bytes, edge.0, edge.1));
        from_words().or_else(|| touching.then(from_columns).flatten())
    };
    record.ok_or_else(|| {
        let expected = "function type, number, version, load case, then name, node and direction (-6 to 6) of \
                        response and reference";
        FieldError::line(line, "function record (6) of dataset 58", expected)
    })
}

/// The function type that record 6 states.
pub(super) fn function_type(line: &Line) -> Option<i32> {
    Some(function_record(line).ok()?.function_type)
}

fn cuts_a_word(bytes: &[u8], edge: usize) -> bool {
    let blank = |at: usize| bytes.get(at).is_none_or(u8::is_ascii_whitespace);
    !blank(edge - 1) && !blank(edge)
}

fn is_full(bytes: &[u8], start: usize, width: usize) -> bool {
    let field = column(bytes, start, width);
    width > 0 && field.len() == width && !field.iter().any(u8::is_ascii_whitespace)
}

fn function_fields(fields: &[&[u8]]) -> Option<FunctionRecord> {
    // The function's number is not used, but it must be one for the fields to be the right ones.
    integer_or_zero(fields[1])?;
    Some(FunctionRecord {
        function_type: i32::try_from(integer(fields[0])?).ok()?,
        version: integer_or_zero(fields[2])?,
        load_case: integer_or_zero(fields[3])?,
        response: dof_fields(&fields[4..7])?,
        reference: dof_fields(&fields[7..10])?,
    })
}

fn dof_fields(fields: &[&[u8]]) -> Option<DofFields> {
    let direction = i32::try_from(integer_or_zero(fields[2])?).ok()?;
    Some(DofFields {
        name: text_or_none(fields[0]),
        node: integer_or_zero(fields[1])?,
        direction: (-6..=6).contains(&direction).then_some(direction)?,
    })
}

/// Record 7.
pub(super) struct SpacingRecord {
    pub format: SampleFormat,
    pub points: u64,
    pub spacing: Option<Spacing>,
}

/// Reads record 7.
pub(super) fn spacing_record(line: &Line) -> Result<SpacingRecord, FieldError> {
    const WIDTHS: [usize; 6] = [10, 10, 10, 13, 13, 13];
    let refuse = |what, expected| FieldError::line(line, what, expected);
    let (integers, as_printed) =
        numeric_record(&line.bytes, &WIDTHS, spacing_fields).ok_or_else(|| {
            refuse(
                "data form record (7) of dataset 58",
                "data type, number of points, spacing, first abscissa, step, z value",
            )
        })?;
    let [data_type, points, even] = integers;
    let format = sample_format(data_type).ok_or_else(|| {
        refuse(
            "data type of dataset 58",
            "2, 4 (real of 32, 64 bits), 5 or 6 (complex)",
        )
    })?;
    let points = u64::try_from(points)
        .map_err(|_| refuse("number of points of dataset 58", "0 or more points"))?;
    let spacing = match even {
        0 => None,
        1 => Some(as_printed),
        _ => {
            return Err(refuse(
                "abscissa spacing of dataset 58",
                "0 (uneven) or 1 (even)",
            ));
        }
    };
    Ok(SpacingRecord {
        format,
        points,
        spacing,
    })
}

fn spacing_fields(fields: &[&[u8]]) -> Option<([i64; 3], Spacing)> {
    let integers = [
        integer(fields[0])?,
        integer(fields[1])?,
        integer(fields[2])?,
    ];
    // An uneven abscissa needs neither start nor step.
    let number = |field: &[u8]| match integers[2] {
        0 if field.is_empty() => Some(0.0),
        _ => finite(field),
    };
    let spacing = Spacing {
        start: number(fields[3])?,
        step: number(fields[4])?,
        start_half_unit: half_unit(fields[3]),
        step_half_unit: half_unit(fields[4]),
    };
    Some((integers, spacing))
}

fn sample_format(data_type: i64) -> Option<SampleFormat> {
    match data_type {
        2 => Some(SampleFormat::RealF32),
        4 => Some(SampleFormat::RealF64),
        5 => Some(SampleFormat::ComplexF32),
        6 => Some(SampleFormat::ComplexF64),
        _ => None,
    }
}

/// Records 8 to 10: by columns where the blank columns are blank, else four numbers and two texts
/// parted by two blanks.
fn characteristic(line: &Line) -> Result<Characteristic, FieldError> {
    let bytes = &line.bytes;
    let code = integer(column(bytes, 0, 10));
    let label = column(bytes, 26, 20).trim_ascii();
    let unit = column(bytes, 47, 20);
    let blank = |at: usize| bytes.get(at).is_none_or(u8::is_ascii_whitespace);
    let in_place = blank(25) && blank(46) && !cuts_a_word(bytes, 10);
    let swallowed = unit.trim_ascii().is_empty() && label.windows(2).any(|pair| pair == b"  ");
    match code {
        Some(code) if in_place && !swallowed => Ok(Characteristic {
            code,
            unit: text_or_none(unit),
        }),
        _ => loose_characteristic(bytes).ok_or_else(|| {
            FieldError::line(
                line,
                "axis record (8 to 10) of dataset 58",
                "data type, three exponents, label, unit",
            )
        }),
    }
}

fn loose_characteristic(bytes: &[u8]) -> Option<Characteristic> {
    let first = words(bytes);
    let code = integer(first.first()?)?;
    let numbers = first
        .iter()
        .take(4)
        .take_while(|word| integer(word).is_some())
        .count();
    // Words keep no distance, so the texts are cut from the line behind the last number.
    let mut rest = bytes;
    for word in &first[..numbers] {
        rest = &rest.trim_ascii_start()[word.len()..];
    }
    let rest = text(rest);
    let mut texts = rest.split("  ").map(str::trim).filter(|t| !t.is_empty());
    let (label, unit) = (texts.next().unwrap_or_default(), texts.next());
    let unit = match unit {
        Some(unit) => unit,
        None => label.split_once(' ').map_or("", |(_, unit)| unit.trim()),
    };
    Some(Characteristic {
        code,
        unit: text_or_none(unit.as_bytes()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(text: &str) -> Line {
        Line {
            at: Position {
                line: Some(8),
                byte: 100,
            },
            bytes: text.as_bytes().to_vec(),
        }
    }

    #[test]
    fn record_6_is_read_by_columns_and_off_them() {
        for text in [
            "    1         0    3         7 NONE              12  -3 NONE               4   1",
            "  1   0  3   7 NONE 12 -3 NONE 4 1",
            "     1         0    3          7 NONE              12   -3 NONE               4    1",
            "    1         0    3         7                   12  -3                    4   1",
        ] {
            let got = function_record(&line(text)).unwrap_or_else(|e| panic!("{text}: {e:?}"));
            assert_eq!(
                (got.function_type, got.version, got.load_case),
                (1, 3, 7),
                "{text}"
            );
            assert_eq!(
                (got.response.node, got.response.direction),
                (12, -3),
                "{text}"
            );
            assert_eq!(
                (got.reference.node, got.reference.direction),
                (4, 1),
                "{text}"
            );
        }
        let short = function_record(&line(
            "    1         0    3         7 Mic number1234567890   3",
        ))
        .unwrap();
        assert_eq!(short.response.name, "Mic number");
        assert_eq!(short.response.node, 1_234_567_890);
        assert_eq!(short.reference, DofFields::none());
        assert!(
            function_record(&line(
                "    1         0    3         7 NONE              12  13"
            ))
            .is_err()
        );
        let shifted = "    1         0    3         7 Mic 01   1234567890   3";
        assert!(function_record(&line(shifted)).is_err());
    }

    #[test]
    fn record_7_is_read_with_every_exponent() {
        for text in [
            "         6      1001         1   0.0000e+00   5.0000e-05   0.0000e+00",
            "         6      1001         1 0.00000E+000 5.00000E-005 0.00000E+000",
            "6 1001 1 0 0.00005 0",
            "         6      1001         1  0.00000D+00  5.00000D-05",
            "         6      1001         1-0.000000E+00 5.000000E-05-0.000000E+00",
        ] {
            let got = spacing_record(&line(text)).unwrap_or_else(|e| panic!("{text}: {e:?}"));
            let spacing = got.spacing.unwrap();
            assert_eq!(
                (got.format, got.points, spacing.start.abs().to_bits()),
                (SampleFormat::ComplexF64, 1001, 0)
            );
            assert!((spacing.step - 5e-5).abs() < 1e-18, "{text}");
        }
        for (text, what) in [
            (
                "         3      1001         1  0.00000D+00  5.00000D-05",
                "data type of dataset 58",
            ),
            (
                "         2        -1         1  0.00000D+00  5.00000D-05",
                "number of points of dataset 58",
            ),
            (
                "         2      1001         2  0.00000D+00  5.00000D-05",
                "abscissa spacing of dataset 58",
            ),
            (
                "         2      1001         1  0.00000D+00          NaN",
                "data form record (7) of dataset 58",
            ),
        ] {
            assert_eq!(spacing_record(&line(text)).err().unwrap().what, what);
        }
        for uneven in ["         4      1001         0", "4 1001 0 0. 0. 0."] {
            assert_eq!(spacing_record(&line(uneven)).ok().unwrap().spacing, None);
        }
    }

    #[test]
    fn units_are_found_on_and_off_their_columns() {
        for text in [
            "        12    0    0    0 Acceleration         m/s2                ",
            "       12    0    0    0 Acceleration         m/s2",
            "12 0 0 0 Acceleration  m/s2",
            "12 0 0 0 Acceleration m/s2",
            "        12    0    0    0 Peak acceleration    m/s2",
        ] {
            let got = characteristic(&line(text)).unwrap();
            assert_eq!((got.code, got.unit.as_str()), (12, "m/s2"), "{text}");
        }
        let touching =
            characteristic(&line("        12    0    0    0 NONE                 NONE")).unwrap();
        assert_eq!((touching.code, touching.unit.as_str()), (12, ""));
        assert!(characteristic(&line("   Acceleration")).is_err());
    }

    #[test]
    fn the_binary_line_is_checked() {
        let good = binary_line(&line(
            "    58b     2     2          11      123456     0     0           0           0",
        ))
        .unwrap();
        let expected = BinaryLine {
            little_endian: false,
            header_lines: 11,
            stated_bytes: 123_456,
        };
        assert_eq!(good, expected);
        for text in [
            "    58b     3     2          11      123456",
            "    58b     1     1          11      123456",
            "    58b     1     2           5      123456",
            "    58b     1     2",
        ] {
            assert!(binary_line(&line(text)).is_err(), "{text}");
        }
    }
}
