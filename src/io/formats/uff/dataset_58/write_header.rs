//! Dataset 58 written: the header lines in their columns, and rows of numbers as text (field table:
//! `dataset_58`).

use std::io::{self, Write};

use super::Characteristic;
use super::dof_fields::DofFields;
use super::entry_header::FunctionHeader;
use crate::io::SampleFormat;
use crate::io::formats::uff::fields::fixed_columns::{fortran, twelve_columns};

/// Digits behind the point of a number of single precision as text.
pub(super) const SINGLE_DIGITS: usize = 5;

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
pub(in crate::io::formats::uff) fn header_lines(header: &FunctionHeader) -> String {
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
    let none = [twelve_columns(0.0), twelve_columns(0.0)];
    let [start, step] = header.spacing.as_ref().unwrap_or(&none);
    out.push_str(&format!(
        "{:>10}{:>10}{:>10}{start:>13}{step:>13}{:>13}\n",
        data_type(header.format),
        header.points,
        i32::from(header.spacing.is_some()),
        twelve_columns(0.0)
    ));
    out.push_str(&characteristic(&header.abscissa));
    out.push_str(&characteristic(&header.numerator));
    out.push_str(&characteristic(&header.denominator));
    out.push_str(&characteristic(&Characteristic {
        code: 0,
        unit: String::new(),
    }));
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

fn characteristic(field: &Characteristic) -> String {
    let label = match field.code {
        8 => "Displacement",
        11 => "Velocity",
        12 => "Acceleration",
        13 => "Excitation force",
        17 => "Time",
        18 => "Frequency",
        _ => "NONE",
    };
    let unit = if field.unit.is_empty() {
        "NONE"
    } else {
        &field.unit
    };
    let code = field.code;
    format!(
        "{code:>10}{:>5}{:>5}{:>5} {label:<20} {unit:<20}\n",
        0, 0, 0
    )
}

/// Everything of a dataset with a binary block, little endian, that stands before its `bytes`
/// bytes.
pub(super) fn binary_head(header: &FunctionHeader, bytes: u64) -> String {
    format!(
        "    -1\n    58b{:>6}{:>6}{:>12}{bytes:>12}{:>6}{:>6}{:>12}{:>12}\n{}",
        1,
        2,
        11,
        0,
        0,
        0,
        0,
        header_lines(header)
    )
}

/// Everything of a dataset of numbers as text that stands before its numbers.
pub(super) fn text_head(header: &FunctionHeader) -> String {
    format!("    -1\n    58\n{}", header_lines(header))
}

/// Rows of numbers as text, in the columns of the format: 6 E13.5 or 4 E20.12 to a row, and where
/// an abscissa stands before each value 6 E13.5, 2 (E13.5, E20.12) or E13.5, 2 E20.12.
pub(super) struct TextRows {
    format: SampleFormat,
    uneven: bool,
    column: usize,
    out: String,
}

impl TextRows {
    pub fn new(format: SampleFormat, uneven: bool) -> Self {
        Self {
            format,
            uneven,
            column: 0,
            out: String::new(),
        }
    }

    /// Adds an abscissa.
    pub fn abscissa(&mut self, value: f64) {
        self.field(&twelve_columns(value), 13);
    }

    /// Adds a number of a value.
    pub fn number(&mut self, value: f64) {
        match self.format {
            SampleFormat::RealF32 | SampleFormat::ComplexF32 => {
                self.field(&fortran(value, SINGLE_DIGITS), 13);
            }
            _ => self.field(&fortran(value, 12), 20),
        }
    }

    fn field(&mut self, text: &str, width: usize) {
        use std::fmt::Write;
        // A number that fills its columns begins with a sign, which parts it from the one before.
        let _ = write!(self.out, "{text:>width$}");
        self.column += 1;
        if self.column == self.columns() {
            self.end_row();
        }
    }

    fn columns(&self) -> usize {
        match (self.format, self.uneven) {
            (SampleFormat::RealF32 | SampleFormat::ComplexF32, _) => 6,
            (SampleFormat::ComplexF64, true) => 3,
            _ => 4,
        }
    }

    fn end_row(&mut self) {
        self.out.push('\n');
        self.column = 0;
    }

    /// Writes the rows that there are.
    pub fn write(&mut self, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(self.out.as_bytes())?;
        self.out.clear();
        Ok(())
    }

    /// Ends the last row and writes.
    pub fn finish(mut self, out: &mut dyn Write) -> io::Result<()> {
        if self.column > 0 {
            self.end_row();
        }
        self.write(out)
    }
}
