//! Brüel & Kjær PULSE LabShop: a function exported as text.
//!
//! The header is `Key:<tab>value` on each line; blank lines stand where a key has no value, and
//! `Header Size` does not count the lines about the slice. So the numbers are found by their form:
//! index, abscissa, and one value or two (`Data Type` `Real` or `Complex`), separated by
//! tabulators, with the decimal mark of `Decimal Symbol`. `X-Axis size` says how many there are;
//! several slices (`Z-Axis size`) follow one another, each behind its header lines. Tags stand
//! behind the numbers.

use crate::printable::counted;
use std::collections::BTreeMap;

use num_complex::Complex64;

use super::dof_text::printed_dof;
use super::encoding::{TextBlocks, first_lines, text_of};
use super::entries::{axis_of, new_source, report_uneven_axis};
use super::fields::{Notation, RowShape, Slot};
use super::header_syntax::{Abscissa, unit_of};
use crate::axis::{FrequencyAxis, TimeAxis};
use crate::frf::Estimator;
use crate::io::formats::number;
use crate::io::{
    Block, Confidence, Delimiter, Domain, Entry, EntryAxis, Format, FunctionType, GeneralAxis,
    Hints, IoError, MemorySource, Part, ReadSeek, SampleFormat, Source,
};

/// Text export of Brüel & Kjær PULSE LabShop.
pub struct Pulse;

/// Most keys, characters of a value, and slices that are read; a file with more is no export.
const MAX_KEYS: usize = 1000;
const MAX_TEXT_CHARACTERS: usize = 200;
const MAX_SLICES: usize = 10_000;

/// Values of the header by key.
type Keys = BTreeMap<String, String>;

impl Format for Pulse {
    fn name(&self) -> &'static str {
        "pulse"
    }

    fn detect(&self, head: &[u8]) -> Confidence {
        let lines = first_lines::<5>(head);
        let size = lines[0].starts_with(b"Header Size:");
        let mut others = lines[1..].iter();
        let version = others.any(|line| line.starts_with(b"Pulse Version:"));
        if size && version {
            Confidence::Certain
        } else {
            Confidence::No
        }
    }

    fn open(&self, input: Box<dyn ReadSeek>, hints: &Hints) -> Result<Box<dyn Source>, IoError> {
        let path = hints.path.as_str();
        let mut text = TextBlocks::new(input, path)?;
        let export = Export::read(&mut text, path)?;
        let mut source = new_source(self.name(), path);
        let several = export.slices.len() > 1;
        for (index, slice) in export.slices.into_iter().enumerate() {
            let mut entry = entry_of(&export.keys, slice, &mut source, path);
            if several {
                entry.0.identification.version = index as i64 + 1;
            }
            source.push(entry.0, entry.1, entry.2);
        }
        for error in export.damage {
            source.catalog.note_damage(error, Part::Function);
        }
        Ok(Box::new(source))
    }
}

/// One slice of numbers.
#[derive(Debug, Default)]
struct Slice {
    line: u64,
    last_line: u64,
    abscissa: Vec<f64>,
    real: Vec<f64>,
    imaginary: Vec<f64>,
}

/// Keys and numbers of a file.
#[derive(Debug, Default)]
struct Export {
    keys: Keys,
    slices: Vec<Slice>,
    /// Whether there are more slices than are read.
    more: bool,
    damage: Vec<IoError>,
}

impl Export {
    fn read(text: &mut TextBlocks, path: &str) -> Result<Self, IoError> {
        let mut export = Self::default();
        let mut shape = None;
        let mut row = [0.0; 4];
        // Whether rows go on in the last slice.
        let (mut open, mut last) = (false, 0);
        while let Some((number, line)) = text.next_line()? {
            last = number;
            if let Some((key, value)) = key_of(line) {
                export.end_slice(&mut open, number, path);
                // What is said first holds; tags of later slices do not replace it.
                if export.keys.len() < MAX_KEYS {
                    export.keys.entry(key).or_insert(value);
                }
                shape = None;
                continue;
            }
            let shape = shape.get_or_insert_with(|| shape_of(&export.keys));
            match shape.read(line, &mut row[..shape.width]) {
                Ok(true) => export.push(&row, number, &mut open, path),
                Ok(false) => {}
                Err(fault) if open => {
                    open = false;
                    export.damage.push(fault.at(path, number));
                }
                Err(_) => {}
            }
        }
        export.end_slice(&mut open, last, path);
        if export.more {
            export.damage.push(IoError::Text {
                path: path.to_owned(),
                line: last,
                what: "slices of a PULSE export",
                got: format!("more than {MAX_SLICES}"),
                expected: format!("at most {MAX_SLICES}"),
            });
        }
        if export.slices.is_empty() {
            return Err(IoError::Text {
                path: path.to_owned(),
                line: last.max(1),
                what: "numbers of a PULSE export",
                got: "none".to_owned(),
                expected: format!("rows of {} numbers", shape_of(&export.keys).width),
            });
        }
        Ok(export)
    }

    /// Adds a row; index 1 begins a slice, and an index that does not follow the one before it
    /// breaks it off. A row of a slice that broke off is passed over.
    fn push(&mut self, row: &[f64; 4], line: u64, open: &mut bool, path: &str) {
        let is = |index: usize| row[0].to_bits() == (index as f64).to_bits();
        self.more |= !*open && is(1) && self.slices.len() == MAX_SLICES;
        if !*open && is(1) && self.slices.len() < MAX_SLICES {
            *open = true;
            self.slices.push(Slice {
                line,
                ..Slice::default()
            });
        }
        let Some(slice) = self.slices.last_mut().filter(|_| *open) else {
            return;
        };
        let index = slice.real.len() + 1;
        if !is(index) {
            *open = false;
            self.damage.push(IoError::Text {
                path: path.to_owned(),
                line,
                what: "index of a row",
                got: row[0].to_string(),
                expected: index.to_string(),
            });
            return;
        }
        slice.last_line = line;
        slice.abscissa.push(row[1]);
        slice.real.push(row[2]);
        slice.imaginary.push(row[3]);
    }

    /// Ends the slice that rows went on in: as many as stated.
    fn end_slice(&mut self, open: &mut bool, line: u64, path: &str) {
        if !std::mem::take(open) {
            return;
        }
        let stated = number_of(&self.keys, "X-Axis size");
        let found = self.slices.last().map_or(0, |slice| slice.real.len());
        if stated.is_some_and(|stated| stated.to_bits() != (found as f64).to_bits()) {
            self.damage.push(IoError::Text {
                path: path.to_owned(),
                line,
                what: "rows of numbers",
                got: counted(found, "row"),
                expected: format!("{} (X-Axis size)", stated.unwrap_or_default()),
            });
        }
    }
}

/// Key and value of a header line: the text up to the colon, and the first text behind it.
fn key_of(line: &[u8]) -> Option<(String, String)> {
    let mut texts = line.split(|byte| *byte == b'\t');
    let first = text_of(texts.next()?.trim_ascii());
    // A tag prints its unit behind the colon: `AverageNumber: []`.
    let (key, _) = first.split_once(':')?;
    let value = texts.map(<[u8]>::trim_ascii).find(|text| !text.is_empty());
    let value = value.map(text_of).unwrap_or_default();
    let cut = |text: &str| text.chars().take(MAX_TEXT_CHARACTERS).collect();
    Some((cut(key.trim()), cut(&value)))
}

fn shape_of(keys: &Keys) -> RowShape {
    let width = if is_complex(keys) { 4 } else { 3 };
    RowShape {
        notation: Notation {
            delimiter: Delimiter::Tab,
            decimal: decimal_of(keys),
        },
        width,
        slots: (0..width).map(|index| Some(Slot::real(index))).collect(),
        any_value: false,
    }
}

fn is_complex(keys: &Keys) -> bool {
    keys.get("Data Type").is_some_and(|kind| kind == "Complex")
}

fn decimal_of(keys: &Keys) -> u8 {
    match keys.get("Decimal Symbol").map(String::as_str) {
        Some(",") => b',',
        _ => b'.',
    }
}

fn number_of(keys: &Keys, key: &str) -> Option<f64> {
    let value = number::field(keys.get(key)?.as_bytes(), decimal_of(keys))?;
    value.is_finite().then_some(value)
}

fn entry_of(
    keys: &Keys,
    slice: Slice,
    source: &mut MemorySource,
    path: &str,
) -> (Entry, Block, Vec<f64>) {
    let (line, last_line) = (slice.line, slice.last_line);
    let last = slice.abscissa.last().copied();
    let (axis, abscissa, label) = axis(keys, slice.abscissa);
    report_uneven_axis(&axis, Some(line), source);
    if let Some(error) = contradiction(&axis, last, last_line, path) {
        source.catalog.note_damage(error, Part::Function);
    }
    let (format, block) = if is_complex(keys) {
        let parts = slice.real.into_iter().zip(slice.imaginary);
        let values = parts.map(|(re, im)| Complex64::new(re, im)).collect();
        (SampleFormat::ComplexF64, Block::Complex(values))
    } else {
        (SampleFormat::RealF64, Block::F64(slice.real))
    };
    let mut entry = Entry::new(function_type(keys), axis, format);
    (entry.axis_label, entry.line) = (label, Some(line));
    put_unit(&mut entry, keys);
    put_names(&mut entry, keys);
    (entry, block, abscissa)
}

/// The axis as the header states it; a logarithmic one, or one without spacing, by its values.
fn axis(keys: &Keys, values: Vec<f64>) -> (EntryAxis, Vec<f64>, String) {
    let label = keys.get("X-Axis unit").cloned().unwrap_or_default();
    let domain = match label.as_str() {
        "Hz" => Domain::Frequency,
        "s" => Domain::Time,
        _ => Domain::Other(0),
    };
    let linear = keys.get("X-Axis type").is_some_and(|kind| kind == "Linear");
    let first = number_of(keys, "X-Axis first value");
    let step = number_of(keys, "X-Axis delta").filter(|step| *step > 0.0);
    let Some((start, step)) = first.zip(step).filter(|_| linear) else {
        let abscissa = Abscissa {
            domain,
            uneven: !linear,
            label,
        };
        return axis_of(&abscissa, values);
    };
    let len = values.len();
    let axis = match domain {
        Domain::Frequency => EntryAxis::Frequency(FrequencyAxis {
            start_hz: start,
            step_hz: step,
            len,
        }),
        Domain::Time => EntryAxis::Time(TimeAxis {
            start_s: start,
            step_s: step,
            len,
        }),
        domain @ Domain::Other(_) => EntryAxis::General(GeneralAxis {
            domain,
            even: Some((start, step)),
            len,
        }),
    };
    (axis, Vec::new(), label)
}

/// The last printed value of an even axis lies where the header puts it.
fn contradiction(axis: &EntryAxis, last: Option<f64>, line: u64, path: &str) -> Option<IoError> {
    let ((start, step), last) = axis.even().zip(last)?;
    let len = match axis {
        EntryAxis::Time(axis) => axis.len,
        EntryAxis::Frequency(axis) => axis.len,
        EntryAxis::General(axis) => axis.len,
    };
    let place = start + (len - 1) as f64 * step;
    ((last - place).abs() > 0.5 * step).then(|| IoError::Text {
        path: path.to_owned(),
        line,
        what: "abscissa",
        got: last.to_string(),
        expected: format!("{place} (X-Axis first value and delta)"),
    })
}

fn function_type(keys: &Keys) -> FunctionType {
    match keys.get("Function").map(String::as_str) {
        Some("Frequency Response") => FunctionType::Frf,
        Some("Coherence") => FunctionType::Coherence,
        Some("Autospectrum") => FunctionType::Other(2),
        Some("Cross-spectrum" | "Cross Spectrum" | "Crossspectrum") => FunctionType::Other(3),
        Some("Time" | "Time History" | "Recorder") => FunctionType::Time,
        _ => FunctionType::Other(0),
    }
}

/// Units of a record or an FRF; a text such as `V/N` stays a text.
fn put_unit(entry: &mut Entry, keys: &Keys) {
    entry.unit_label = keys.get("AmplitudeUnit").cloned().unwrap_or_default();
    match entry.function_type {
        FunctionType::Frf | FunctionType::Time => {
            let unit = unit_of(&entry.unit_label, entry.function_type);
            (entry.quantity, entry.denominator) = (unit.quantity, unit.denominator);
            entry.to_si = unit.to_si;
        }
        FunctionType::Coherence => entry.to_si = Some(1.0),
        _ => {}
    }
}

/// Points, names and how the function was made.
fn put_names(entry: &mut Entry, keys: &Keys) {
    let text = |key: &str| keys.get(key).cloned().unwrap_or_default();
    entry.response = printed_dof(&text("Signal"));
    entry.reference = printed_dof(&text("Ref_Signal"));
    let names = [text("Signal"), text("Ref_Signal")];
    let names: Vec<&str> = names
        .iter()
        .map(String::as_str)
        .filter(|name| !name.is_empty())
        .collect();
    let lines = &mut entry.identification.lines;
    lines[0] = text("Title");
    lines[1] = names.join(" | ");
    lines[2] = format!("{} {}", text("Date"), text("Time"))
        .trim()
        .to_owned();
    let title = text("Title");
    let estimators = [("H1(", Estimator::H1), ("H2(", Estimator::H2)];
    if entry.function_type == FunctionType::Frf {
        let named = estimators.iter().find(|(mark, _)| title.contains(mark));
        entry.note.estimator = named.map(|(_, estimator)| *estimator);
    }
    let averages = number_of(keys, "AverageNumber");
    let whole = averages.filter(|n| *n >= 1.0 && *n <= f64::from(u32::MAX) && n.fract() == 0.0);
    entry.note.averages = whole.map(|n| n as u32);
    let record = number_of(keys, "RecordLength").filter(|length| *length > 0.0);
    entry.note.record_s = record;
}
