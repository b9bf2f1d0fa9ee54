//! Entries of one abscissa to a table whose headings state everything ([`super::header_syntax`]).
//!
//! Numbers have as many digits as give the same double back, or the same single where singles are
//! stored.

use super::header_syntax::{abscissa_heading, entry_heading, same_axis, unit_text};
use crate::finding::Finding;
use crate::io::formats::dropped_content::DroppedContent;
use crate::io::{
    Block, Catalog, Entry, FunctionMetadata, FunctionType, IoError, Precision, SampleFormat,
    Source, WriteOptions, WriteSeek,
};

/// Rows that are read and written at a time.
const ROWS: usize = 4096;

/// One entry as columns.
struct Column {
    entry: usize,
    single: bool,
    complex: bool,
    block: Block,
}

/// Writes the entries that have the abscissa of the first one.
///
/// # Errors
/// As [`crate::io::Format::write`].
pub(super) fn write(
    out: &mut dyn WriteSeek,
    source: &mut dyn Source,
    options: &WriteOptions,
) -> Result<Vec<Finding>, IoError> {
    let chosen = on_first_abscissa(source)?;
    let Some(first) = chosen.first().copied() else {
        return Err(IoError::Unwritable {
            path: options.path.clone(),
            what: "a table",
            got: "no record and no function".to_owned(),
            expected: "one or more".to_owned(),
        });
    };
    let catalog = source.catalog();
    check_window(catalog, &chosen, options)?;
    let findings = dropped_content(catalog, &chosen);
    let mut columns: Vec<Column> = chosen
        .iter()
        .map(|entry| column(catalog, *entry, options.precision))
        .collect();
    let len = catalog.entries[first].len();
    let system = |source| IoError::System {
        path: options.path.clone(),
        action: "write",
        source,
    };
    let header = header(catalog, &columns);
    out.write_all(header.as_bytes()).map_err(system)?;
    let (mut abscissa, mut text) = (Vec::new(), Vec::new());
    for start in (0..len).step_by(ROWS) {
        let range = start..len.min(start + ROWS);
        source.abscissa(first, range.clone(), &mut abscissa)?;
        for column in &mut columns {
            source.read(column.entry, range.clone(), &mut column.block)?;
        }
        text.clear();
        for (row, value) in abscissa.iter().enumerate() {
            put(&mut text, *value, false);
            for column in &columns {
                column.put(&mut text, row);
            }
            text.push(b'\n');
        }
        out.write_all(&text).map_err(system)?;
    }
    Ok(findings)
}

/// Entries, in order, that have the abscissa of the first one.
fn on_first_abscissa(source: &mut dyn Source) -> Result<Vec<usize>, IoError> {
    let entries = &source.catalog().entries;
    let Some(first) = entries.first() else {
        return Ok(Vec::new());
    };
    let (len, even) = (first.len(), first.axis.even().is_some());
    let alike = |index: &usize| same_axis(&entries[0].axis, &entries[*index].axis);
    let alike: Vec<usize> = (0..entries.len()).filter(alike).collect();
    if even {
        return Ok(alike);
    }
    let (mut wanted, mut abscissa) = (Vec::new(), Vec::new());
    source.abscissa(0, 0..len, &mut wanted)?;
    let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    let mut same = Vec::new();
    for index in alike {
        source.abscissa(index, 0..len, &mut abscissa)?;
        if bits(&abscissa) == bits(&wanted) {
            same.push(index);
        }
    }
    Ok(same)
}

fn column(catalog: &Catalog, entry: usize, precision: Option<Precision>) -> Column {
    let format = catalog.entries[entry].format;
    let stored = matches!(format, SampleFormat::RealF32 | SampleFormat::ComplexF32);
    Column {
        entry,
        single: precision.map_or(stored, |wanted| wanted == Precision::Single),
        complex: matches!(format, SampleFormat::ComplexF32 | SampleFormat::ComplexF64),
        block: Block::F64(Vec::new()),
    }
}

impl Column {
    fn put(&self, text: &mut Vec<u8>, row: usize) {
        let parts = match &self.block {
            Block::F32(values) => [Some(f64::from(values[row])), None],
            Block::F64(values) => [Some(values[row]), None],
            Block::Complex(values) => [Some(values[row].re), Some(values[row].im)],
        };
        for value in parts.into_iter().flatten() {
            text.push(b',');
            put(text, value, self.single);
        }
    }
}

/// The shortest decimal text that gives the same number back.
fn put(text: &mut Vec<u8>, value: f64, single: bool) {
    use std::io::Write;
    // Writing into memory does not fail.
    let _ = if single {
        write!(text, "{:?}", value as f32)
    } else {
        write!(text, "{value:?}")
    };
}

fn header(catalog: &Catalog, columns: &[Column]) -> String {
    let mut headings = Vec::new();
    for column in columns {
        let entry = &catalog.entries[column.entry];
        if headings.is_empty() {
            headings.push(abscissa_heading(entry));
        }
        let unit = unit_text(entry).unwrap_or_default();
        let heading = entry_heading(entry, column.complex, &unit);
        if column.complex {
            headings.push(format!("re {heading}"));
            headings.push(format!("im {heading}"));
        } else {
            headings.push(heading);
        }
    }
    headings.join(",") + "\n"
}

/// Functions that carry the decay of a window would be read back as if the structure damped by so
/// much more.
fn check_window(
    catalog: &Catalog,
    chosen: &[usize],
    options: &WriteOptions,
) -> Result<(), IoError> {
    let entries = chosen.iter().map(|index| &catalog.entries[*index]);
    let windowed = entries.filter(|entry| entry.function_type == FunctionType::Frf);
    let mut decays = windowed.filter_map(|entry| entry.note.added_damping_rad_s);
    match decays.find(|decay| *decay > 0.0) {
        None => Ok(()),
        Some(decay) => Err(IoError::Unwritable {
            path: options.path.clone(),
            what: "a table",
            got: format!(
                "FRFs with the added damping of an exponential window, {decay} rad/s, for which a table has no place"
            ),
            expected: "FRFs without it (--response-window none), or .uff, .h5, .mat, .npz"
                .to_owned(),
        }),
    }
}

/// The properties that a table has no place for.
fn dropped_content(catalog: &Catalog, chosen: &[usize]) -> Vec<Finding> {
    let count = |lost: fn(&Entry) -> bool| {
        let lost = chosen
            .iter()
            .filter(|index| lost(&catalog.entries[**index]));
        lost.count()
    };
    let geometry = &catalog.geometry;
    let lost = [
        (
            "entries on other axes",
            catalog.entries.len() - chosen.len(),
        ),
        ("units", count(|entry| unit_text(entry).is_none())),
        (
            "roles",
            count(|entry| entry.role.is_some() && entry.function_type != FunctionType::Time),
        ),
        (
            "load cases",
            count(|entry| entry.identification.load_case != 0),
        ),
        (
            "identification lines",
            count(|entry| {
                entry
                    .identification
                    .lines
                    .iter()
                    .any(|line| !line.is_empty())
            }),
        ),
        (
            "windows of records",
            count(|entry| entry.note.window.is_some()),
        ),
        (
            "notes on functions",
            count(|entry| entry.note != FunctionMetadata::default()),
        ),
        ("modes", catalog.modes.len()),
        ("nodes", geometry.nodes.len()),
        ("trace lines", geometry.lines.len()),
        ("coordinate systems", geometry.systems.len()),
        ("elements", geometry.elements.len()),
        ("groups", geometry.groups.len()),
        ("arrays", catalog.arrays.len()),
        ("title lines", catalog.title.len()),
    ];
    let mut all = DroppedContent::default();
    for (what, count) in lost {
        all.add(what, count);
    }
    all.findings()
}
