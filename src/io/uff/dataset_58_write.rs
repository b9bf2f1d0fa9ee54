//! Dataset 58 written: the header lines in their columns, and samples as bytes or text (field table: `dataset_58`).

use std::io::{self, Write};

use super::dof_fields::DofFields;
use crate::io::SampleFormat;
use crate::quantity::Quantity;

/// Columns of a text line.
const LINE_COLUMNS: usize = 80;

/// What a header says.
pub(super) struct FunctionHeader {
    pub id_lines: [String; 5],
    pub function_type: i32,
    pub version: usize,
    pub load_case: i32,
    pub response: DofFields,
    pub reference: DofFields,
    pub format: SampleFormat,
    pub points: usize,
    pub abscissa: Abscissa,
    pub numerator: Ordinate,
    pub denominator: Ordinate,
}

/// An even abscissa.
pub(super) struct Abscissa {
    pub time: bool,
    pub start: f64,
    pub step: f64,
}

/// What an ordinate's numerator or denominator is; `None` for neither quantity nor unit.
pub(super) type Ordinate = Option<Quantity>;

/// Data type of record 7.
fn data_type(format: SampleFormat) -> i32 {
    match format {
        SampleFormat::RealF32 => 2,
        SampleFormat::RealF64 => 4,
        SampleFormat::ComplexF32 => 5,
        SampleFormat::ComplexF64 => 6,
    }
}

/// The lines between the dataset's first line and its samples.
pub(super) fn header_lines(header: &FunctionHeader) -> String {
    let mut out = String::new();
    for line in &header.id_lines {
        out.push_str(if line.is_empty() { "NONE" } else { line });
        out.push('\n');
    }
    out.push_str(&format!(
        "{:>5}{:>10}{:>5}{:>10}{}{}\n",
        header.function_type,
        0,
        header.version,
        header.load_case,
        dof_text(&header.response),
        dof_text(&header.reference)
    ));
    out.push_str(&format!(
        "{:>10}{:>10}{:>10}{:>13}{:>13}{:>13}\n",
        data_type(header.format),
        header.points,
        1,
        twelve_columns(header.abscissa.start),
        twelve_columns(header.abscissa.step),
        twelve_columns(0.0)
    ));
    out.push_str(&if header.abscissa.time {
        characteristic(17, "Time", "s")
    } else {
        characteristic(18, "Frequency", "Hz")
    });
    out.push_str(&ordinate(header.numerator));
    out.push_str(&ordinate(header.denominator));
    out.push_str(&characteristic(0, "NONE", "NONE"));
    out
}

fn dof_text(dof: &DofFields) -> String {
    let name = if dof.name.is_empty() {
        "NONE"
    } else {
        &dof.name
    };
    format!(" {name:<10}{:>10}{:>4}", dof.node, dof.direction)
}

fn characteristic(code: i32, label: &str, unit: &str) -> String {
    format!(
        "{code:>10}{:>5}{:>5}{:>5} {label:<20} {unit:<20}\n",
        0, 0, 0
    )
}

/// Specific data type and label of a quantity, in SI units.
fn ordinate(ordinate: Ordinate) -> String {
    match ordinate {
        None => characteristic(0, "NONE", "NONE"),
        Some(quantity) => {
            let (code, label) = match quantity {
                Quantity::Displacement => (8, "Displacement"),
                Quantity::Velocity => (11, "Velocity"),
                Quantity::Acceleration => (12, "Acceleration"),
                Quantity::Force => (13, "Excitation force"),
            };
            characteristic(code, label, quantity.si_unit())
        }
    }
}

/// A number in at most twelve columns, so that a blank stands before it in its thirteen: seven digits or, where sign or
/// exponent take columns, fewer.
fn twelve_columns(value: f64) -> String {
    let mut digits = 6;
    loop {
        let text = fortran(value, digits);
        if text.len() <= 12 || digits == 0 {
            return text;
        }
        digits -= 1;
    }
}

/// `1.500000E-05`: a sign and at least two digits in the exponent.
fn fortran(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$E}");
    match text.split_once('E') {
        Some((mantissa, exponent)) => {
            let (sign, exponent) = match exponent.strip_prefix('-') {
                Some(exponent) => ('-', exponent),
                None => ('+', exponent),
            };
            format!("{mantissa}E{sign}{exponent:0>2}")
        }
        None => text,
    }
}

/// Writes a dataset with a binary block, little endian; `bytes` are the samples.
pub(super) fn write_binary(
    out: &mut dyn Write,
    header: &FunctionHeader,
    bytes: &[u8],
) -> io::Result<()> {
    let first = format!(
        "    -1\n    58b{:>6}{:>6}{:>12}{:>12}{:>6}{:>6}{:>12}{:>12}\n",
        1,
        2,
        11,
        bytes.len(),
        0,
        0,
        0,
        0
    );
    out.write_all(first.as_bytes())?;
    out.write_all(header_lines(header).as_bytes())?;
    out.write_all(bytes)?;
    out.write_all(b"    -1\n")
}

/// Writes a dataset of 64-bit numbers as text, four of E20.12 to a line.
pub(super) fn write_text(
    out: &mut dyn Write,
    header: &FunctionHeader,
    numbers: &[f64],
) -> io::Result<()> {
    let mut text = String::from("    -1\n    58\n");
    text.push_str(&header_lines(header));
    for row in numbers.chunks(4) {
        for number in row {
            text.push_str(&format!("{:>20}", fortran(*number, 12)));
        }
        text.push('\n');
    }
    text.push_str("    -1\n");
    out.write_all(text.as_bytes())
}

/// A text that fits a line and is no delimiter: control characters become blanks, what is behind column 80 is cut.
pub(super) fn line_text(text: &str) -> String {
    let plain: String = text
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect();
    let mut plain = plain.trim();
    while plain.len() > LINE_COLUMNS {
        let last = plain.char_indices().next_back().map_or(0, |(at, _)| at);
        plain = plain[..last].trim_end();
    }
    if plain == "-1" {
        "(-1)".to_owned()
    } else {
        plain.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_fit_their_columns() {
        for (value, text) in [
            (1.0 / 51_200.0, "1.953125E-05"),
            (-0.05, "-5.00000E-02"),
            (0.0, "0.000000E+00"),
            (1e-120, "1.00000E-120"),
            (-1e300, "-1.0000E+300"),
            (f64::MIN_POSITIVE, "2.22507E-308"),
        ] {
            assert_eq!(twelve_columns(value), text);
        }
    }

    #[test]
    fn a_line_of_text_is_one_line_and_no_delimiter() {
        assert_eq!(line_text(" two\nlines\t"), "two lines");
        assert_eq!(line_text("-1"), "(-1)");
        assert_eq!(line_text(&"é".repeat(60)).len(), 80);
    }
}
