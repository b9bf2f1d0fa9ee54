//! Data Physics SignalCalc: functions exported as text.
//!
//! | line | content |
//! |---|---|
//! | `Units: Ratio` | how the values are scaled; a ratio is response over reference |
//! | `Ref Chan:Resp Chan` | degrees of freedom, reference first, such as `1+Z:12-X` |
//! | `Channel Name`, `Channel Comment` | texts of both channels |
//! | `Frequency  Real  Imaginary` | what the columns are |
//! | `Units:` | before the units of the columns: `Hz  (m/s²)(N)`, the second bracket below the first in a ratio |
//! | rows | numbers with tabulators between them, to the end of the file |

use num_complex::Complex64;

use super::columns::{Rows, read_rows};
use super::dialect::{MAX_COLUMNS, too_wide};
use super::dof_text::printed_dof;
use super::encoding::{TextBlocks, first_lines, lines, text_of};
use super::entries::{axis_of, new_source, report_uneven_axis, with_damage};
use super::fields::{Notation, RowShape, Slot, fields, row_of};
use super::header_syntax::{Abscissa, StatedUnit, unit_of};
use crate::dof::Dof;
use crate::io::{
    Block, Confidence, Delimiter, Domain, Entry, Format, FunctionType, Hints, IoError,
    MemorySource, ReadSeek, SampleFormat, Source,
};

/// Text export of Data Physics SignalCalc.
pub struct SignalCalc;

const NOTATION: Notation = Notation {
    delimiter: Delimiter::Tab,
    decimal: b'.',
};

/// The channels as the file describes them.
const CHANNELS: &str = "Ref Chan:Resp Chan";

impl Format for SignalCalc {
    fn name(&self) -> &'static str {
        "signalcalc"
    }

    fn detect(&self, head: &[u8]) -> Confidence {
        let lines = first_lines::<5>(head);
        let units = lines[0].starts_with(b"Units:");
        let mut others = lines[1..].iter();
        let channels = others.any(|line| line.starts_with(CHANNELS.as_bytes()));
        if units && channels {
            Confidence::Certain
        } else {
            Confidence::No
        }
    }

    fn open(&self, input: Box<dyn ReadSeek>, hints: &Hints) -> Result<Box<dyn Source>, IoError> {
        let path = hints.path.as_str();
        let mut text = TextBlocks::new(input, path)?;
        text.advance()?;
        let header = Header::of(
            &lines(text.block(), text.line_end()).collect::<Vec<_>>(),
            path,
        )?;
        for _ in 0..header.lines {
            text.next_line()?;
        }
        let width = header.columns.len();
        let shape = RowShape {
            notation: NOTATION,
            width,
            slots: (0..width).map(|index| Some(Slot::real(index))).collect(),
            any_value: false,
        };
        let mut rows =
            read_rows(&mut text, &shape, true, path)?.good(path, header.lines as u64 + 1)?;
        let damage = rows.damage.take();
        let mut source = new_source(self.name(), path);
        header.entries(rows, &mut source);
        Ok(Box::new(with_damage(source, damage)))
    }
}

/// The lines before the numbers.
#[derive(Debug, Default)]
struct Header {
    /// Lines before the numbers.
    lines: usize,
    /// Whether the values are ratios.
    ratio: bool,
    /// Reference and response of each function.
    channels: Vec<(Option<Dof>, Option<Dof>)>,
    /// Names and comments of the channels.
    notes: Vec<String>,
    /// The meaning of the columns.
    columns: Vec<String>,
    /// Their units; one for both parts of a complex function.
    units: Vec<String>,
}

impl Header {
    fn of(lines: &[&[u8]], path: &str) -> Result<Self, IoError> {
        let mut row = Vec::new();
        let mut header = Self::default();
        // The last line of words before the units, and whether the units are next.
        let (mut words, mut units_next) = (Vec::new(), false);
        for (index, line) in lines.iter().enumerate() {
            let texts: Vec<String> = fields(line, Delimiter::Tab)
                .into_iter()
                .map(text_of)
                .collect();
            let Some(first) = texts.first() else { continue };
            if texts.len() > MAX_COLUMNS {
                return Err(too_wide(path, index as u64 + 1, texts.len()));
            }
            if units_next {
                header.units = texts;
                units_next = false;
            } else if !header.columns.is_empty() && row_of(line, NOTATION, &mut row) {
                header.lines = index;
                return Ok(header);
            } else if first == "Units:" {
                header.columns = std::mem::take(&mut words);
                units_next = true;
            } else if let Some(kind) = first.strip_prefix("Units:") {
                header.ratio = kind.trim() == "Ratio";
            } else if first == CHANNELS {
                header.channels = texts[1..].iter().map(|text| channels_of(text)).collect();
            } else if first.starts_with("Channel ") {
                let said = texts[1..].iter().filter(|text| text.trim() != ":");
                let cut = |text: &String| text.chars().take(80).collect();
                header.notes.extend(said.map(cut));
            } else {
                words = texts;
            }
        }
        Err(IoError::Text {
            path: path.to_owned(),
            line: lines.len() as u64,
            what: "header of a SignalCalc export",
            got: "no rows of numbers behind it".to_owned(),
            expected: "names of the columns, `Units:`, units and numbers".to_owned(),
        })
    }

    /// Adds a function for each column of values, or for each pair of real and imaginary part.
    fn entries(&self, rows: Rows, source: &mut MemorySource) {
        let line = rows.lines.line(0);
        let mut columns = rows.columns.into_iter();
        let Some(first) = columns.next() else { return };
        let (axis, abscissa, label) = axis_of(&self.abscissa(), first);
        report_uneven_axis(&axis, line, source);
        let functions = self.functions();
        for (number, (name, complex)) in functions.iter().enumerate() {
            let Some(values) = columns.next() else { return };
            let (format, block) = if *complex {
                let parts = values.into_iter().zip(columns.next().unwrap_or_default());
                let values = parts.map(|(re, im)| Complex64::new(re, im)).collect();
                (SampleFormat::ComplexF64, Block::Complex(values))
            } else {
                (SampleFormat::RealF64, Block::F64(values))
            };
            let mut entry = Entry::new(self.function_type(name, *complex), axis, format);
            (entry.axis_label, entry.line) = (label.clone(), line);
            entry.to_si = (entry.function_type == FunctionType::Coherence).then_some(1.0);
            if let Some((reference, response)) =
                of_function(&self.channels, number, functions.len())
            {
                (entry.reference, entry.response) = (reference.clone(), response.clone());
            }
            for (line, note) in entry.identification.lines.iter_mut().zip(&self.notes) {
                line.clone_from(note);
            }
            let units = self.units.get(1..).unwrap_or_default();
            if let Some(unit) = of_function(units, number, functions.len()) {
                self.put_unit(&mut entry, unit);
            }
            source.push(entry, block, abscissa.clone());
        }
    }

    fn abscissa(&self) -> Abscissa {
        let label = self.units.first().cloned().unwrap_or_default();
        let domain = match label.to_ascii_lowercase().as_str() {
            "hz" => Domain::Frequency,
            "s" | "sec" => Domain::Time,
            _ => Domain::Other(0),
        };
        Abscissa {
            domain,
            uneven: false,
            label,
        }
    }

    /// Name of each function, and whether it has two columns.
    fn functions(&self) -> Vec<(&str, bool)> {
        let mut found: Vec<(&str, bool)> = Vec::new();
        for name in self.columns.iter().skip(1) {
            match found.last_mut() {
                Some((before, complex))
                    if *before == "Real" && !*complex && name == "Imaginary" =>
                {
                    *complex = true;
                }
                _ => found.push((name, false)),
            }
        }
        found
    }

    fn function_type(&self, name: &str, complex: bool) -> FunctionType {
        match self.abscissa().domain {
            Domain::Time => FunctionType::Time,
            Domain::Frequency if complex && self.ratio => FunctionType::Frf,
            Domain::Frequency if name.contains("Coherence") => FunctionType::Coherence,
            _ => FunctionType::Other(0),
        }
    }

    /// `(m/s²)(N)` is one over the other in a ratio; of other functions only a single unit is
    /// taken.
    fn put_unit(&self, entry: &mut Entry, text: &str) {
        let ratio = entry.function_type == FunctionType::Frf;
        let unit = if ratio {
            ratio_unit(text)
        } else {
            unit_of(text, entry.function_type)
        };
        text.clone_into(&mut entry.unit_label);
        if ratio || entry.function_type == FunctionType::Time {
            (entry.quantity, entry.denominator) = (unit.quantity, unit.denominator);
            entry.to_si = unit.to_si;
        }
    }
}

/// Unit of an FRF: `(m/s²)(N)` is one over the other.
pub(in crate::io::formats) fn ratio_unit(text: &str) -> StatedUnit {
    unit_of(&text.replacen(")(", ")/(", 1), FunctionType::Frf)
}

/// The item of a function in a list of the header, if the list has one item for each function.
fn of_function<T>(items: &[T], number: usize, functions: usize) -> Option<&T> {
    items.get(number).filter(|_| items.len() == functions)
}

/// Reference and response of `1+Z:12-X`.
fn channels_of(text: &str) -> (Option<Dof>, Option<Dof>) {
    let (reference, response) = text.split_once(':').unwrap_or(("", text));
    (printed_dof(reference), printed_dof(response))
}
