//! Sources of text formats, and the entries of columns whose headings state everything.

use num_complex::Complex64;

use super::columns::Rows;
use super::header_syntax::{Abscissa, HeadingMeaning, Meaning, Part};
use crate::axis::{FrequencyAxis, TimeAxis};
use crate::finding::{Code, Finding, Location, Severity};
use crate::io::columns::{RowLines, even_axis};
use crate::io::{
    Block, Domain, Entry, EntryAxis, GeneralAxis, IoError, MemorySource, Part as FilePart,
    SampleFormat,
};

/// A source without entries.
pub(super) fn new_source(format: &'static str, path: &str) -> MemorySource {
    let mut source = MemorySource::default();
    (source.catalog.format, source.catalog.path) = (format, path.to_owned());
    source
}

/// The source with the damage of its rows, if any: a damaged row concerns every function.
pub(super) fn with_damage(mut source: MemorySource, damage: Option<IoError>) -> MemorySource {
    if let Some(error) = damage {
        source.catalog.note_damage(error, FilePart::Function);
    }
    source
}

/// Adds the entries of the columns to the source.
pub(super) fn entries_of(rows: Rows, meanings: &[Meaning], source: &mut MemorySource) {
    let mut axis = None;
    let mut real = Vec::new();
    for (meaning, values) in meanings.iter().zip(rows.columns) {
        match meaning {
            Meaning::Abscissa(abscissa) => {
                let found = axis_of(abscissa, values);
                report_uneven_axis(&found.0, rows.lines.line(0), source);
                axis = Some(found);
            }
            Meaning::Values(Part::Real, _) => real = values,
            Meaning::Values(part, described) => {
                let Some((axis, abscissa, label)) = &axis else {
                    continue;
                };
                let (format, block) = match part {
                    Part::Imaginary => {
                        let parts = std::mem::take(&mut real).into_iter().zip(values);
                        let values = parts.map(|(re, im)| Complex64::new(re, im)).collect();
                        (SampleFormat::ComplexF64, Block::Complex(values))
                    }
                    _ => (SampleFormat::RealF64, Block::F64(values)),
                };
                let mut entry = entry_of(described, *axis, format);
                entry.axis_label.clone_from(label);
                entry.line = rows.lines.line(0);
                source.push(entry, block, abscissa.clone());
            }
        }
    }
}

fn entry_of(described: &HeadingMeaning, axis: EntryAxis, format: SampleFormat) -> Entry {
    let mut entry = Entry::new(described.function_type, axis, format);
    entry.identification.version = described.hit;
    entry.role = described.role;
    entry.response.clone_from(&described.response);
    entry.reference.clone_from(&described.reference);
    let unit = &described.unit;
    (entry.quantity, entry.denominator) = (unit.quantity, unit.denominator);
    entry.to_si = unit.to_si;
    entry.unit_label.clone_from(&unit.label);
    entry
}

/// The axis, its values where they are not even, and its unit.
pub(in crate::io::formats) fn axis_of(
    abscissa: &Abscissa,
    values: Vec<f64>,
) -> (EntryAxis, Vec<f64>, String) {
    let len = values.len();
    let even = if abscissa.uneven {
        None
    } else {
        exact_axis(&values)
    };
    let axis = match (abscissa.domain, even) {
        (Domain::Time, Some((start_s, step_s))) => EntryAxis::Time(TimeAxis {
            start_s,
            step_s,
            len,
        }),
        (Domain::Frequency, Some((start_hz, step_hz))) => EntryAxis::Frequency(FrequencyAxis {
            start_hz,
            step_hz,
            len,
        }),
        (domain, even) => EntryAxis::General(GeneralAxis { domain, even, len }),
    };
    let kept = if even.is_some() { Vec::new() } else { values };
    (axis, kept, abscissa.label.clone())
}

/// Says once that an abscissa of time or frequency in this file is not even, as functions need it.
pub(in crate::io::formats) fn report_uneven_axis(
    axis: &EntryAxis,
    line: Option<u64>,
    source: &mut MemorySource,
) {
    let EntryAxis::General(axis) = axis else {
        return;
    };
    let other = matches!(axis.domain, Domain::Other(_));
    let findings = &mut source.catalog.findings;
    let reported = findings
        .iter()
        .any(|finding| finding.code == Code::UnevenAxis);
    if other || axis.even.is_some() || axis.len < 2 || reported {
        return;
    }
    let location = Location::File {
        path: source.catalog.path.clone(),
        line,
        byte: None,
    };
    findings.push(Finding::new(Severity::Warning, Code::UnevenAxis, location));
}

/// Start and spacing of an even abscissa: a spacing that gives every value to the bit where there
/// is one, else the mean one.
fn exact_axis(values: &[f64]) -> Option<(f64, f64)> {
    let (start, mean) = even_axis(values, 1.0, "abscissa", &RowLines::default(), "").ok()?;
    let (below, above) = (mean.next_down(), mean.next_up());
    let whole_rate = 1.0 / (1.0 / mean).round();
    let spacings = [
        values[1] - start,
        mean,
        whole_rate,
        below,
        above,
        below.next_down(),
        above.next_up(),
    ];
    let gives = |step: f64| {
        let mut values = values.iter().enumerate();
        values.all(|(index, value)| (start + index as f64 * step).to_bits() == value.to_bits())
    };
    let exact = spacings.into_iter().find(|step| gives(*step));
    Some((start, exact.unwrap_or(mean)))
}
