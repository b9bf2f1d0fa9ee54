//! Tables of numbers: CSV and its kin. A scene describes the columns; the layout is judged by the
//! content where the scene does not state it. A table that modalign wrote states everything in its
//! headings ([`super::header_syntax`]).
//!
//! A row that is no row of numbers is damage: the rows before it are read, the rest is not.

use super::columns::{Wanted, places, read_columns, table_rows};
use super::dialect::{Layout, layout_of};
use super::encoding::{TextBlocks, is_text};
use super::entries::entries_of;
use super::header_syntax::{Meaning, meanings};
use super::header_units::with_heading_units;
use crate::finding::Finding;
use crate::io::columns::assign;
use crate::io::{
    ArrayInfo, Confidence, Format, Hints, IoError, MemorySource, Part, ReadSeek, Source, TableSpec,
    WriteOptions, WriteSeek,
};

/// Text tables: separated by comma, semicolon, tabulator or blanks.
pub struct Table;

impl Format for Table {
    fn name(&self) -> &'static str {
        "table"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["csv"]
    }

    fn detect(&self, head: &[u8]) -> Confidence {
        if is_text(head) {
            Confidence::Possible
        } else {
            Confidence::No
        }
    }

    fn open(&self, input: Box<dyn ReadSeek>, hints: &Hints) -> Result<Box<dyn Source>, IoError> {
        let path = hints.path.as_str();
        let mut text = TextBlocks::new(input, path)?;
        text.advance()?;
        let spec = hints.table.as_ref().filter(|spec| !spec.columns.is_empty());
        let layout = layout_of(text.block(), text.line_end(), spec, path)?;
        let source = match (spec, meanings(&layout.headings)) {
            (Some(spec), _) => assigned(&mut text, &layout, spec, path)?,
            (None, Some(meanings)) => described(&mut text, &layout, &meanings, path)?,
            (None, None) => listed(&mut text, &layout, path)?,
        };
        Ok(Box::new(source))
    }

    fn write(
        &self,
        out: &mut dyn WriteSeek,
        source: &mut dyn Source,
        options: &WriteOptions,
    ) -> Result<Vec<Finding>, IoError> {
        super::write::write(out, source, options)
    }
}

/// The columns that a scene describes.
fn assigned(
    text: &mut TextBlocks,
    layout: &Layout,
    spec: &TableSpec,
    path: &str,
) -> Result<MemorySource, IoError> {
    let places = places(spec, layout, path)?;
    let spec = &with_heading_units(spec, layout, &places, path)?;
    let (columns, damage) = read_columns(text, layout, &places, path)?;
    match (assign("table", spec, vec![columns], path), damage) {
        (Ok(source), damage) => Ok(with_damage(source, damage)),
        // Too few rows for an axis, because of the damage.
        (Err(_), Some(damage)) => Err(damage),
        (Err(error), None) => Err(error),
    }
}

/// The entries that the headings describe.
fn described(
    text: &mut TextBlocks,
    layout: &Layout,
    meanings: &[Meaning],
    path: &str,
) -> Result<MemorySource, IoError> {
    let all: Vec<usize> = (0..layout.width).collect();
    let mut rows = table_rows(text, layout, &all, Wanted::Any, path)?;
    let damage = rows.damage.take();
    let mut source = new_source("table", path);
    entries_of(rows, meanings, &mut source);
    Ok(with_damage(source, damage))
}

/// The columns by name alone.
fn listed(text: &mut TextBlocks, layout: &Layout, path: &str) -> Result<MemorySource, IoError> {
    let numeric: Vec<usize> = (0..layout.width)
        .filter(|column| layout.numeric[*column])
        .collect();
    let rows = table_rows(text, layout, &numeric, Wanted::Counted, path)?;
    let mut source = new_source("table", path);
    let columns = (0..layout.width).map(|column| ArrayInfo {
        name: column_name(layout, column),
        shape: vec![rows.rows],
        kind: if layout.numeric[column] {
            "f64"
        } else {
            "text"
        }
        .to_owned(),
    });
    source.catalog.arrays = columns.collect();
    Ok(with_damage(source, rows.damage))
}

/// Its heading with the unit of the row below, or its number.
fn column_name(layout: &Layout, column: usize) -> String {
    let text = |texts: &[String]| {
        let found = texts.get(column).filter(|text| !text.is_empty());
        found.cloned()
    };
    match (text(&layout.headings), text(&layout.units)) {
        (Some(heading), Some(unit)) if unit.starts_with(['[', '(']) => format!("{heading} {unit}"),
        (Some(heading), Some(unit)) => format!("{heading} [{unit}]"),
        (Some(heading), None) => heading,
        (None, _) => format!("column {}", column + 1),
    }
}

/// A source without entries.
pub(super) fn new_source(format: &'static str, path: &str) -> MemorySource {
    let mut source = MemorySource::default();
    (source.catalog.format, source.catalog.path) = (format, path.to_owned());
    source
}

/// A source that says what is bad in its file, where something is.
pub(super) fn with_damage(mut source: MemorySource, damage: Option<IoError>) -> MemorySource {
    if let Some(error) = damage {
        source.catalog.note_damage(error, Part::Function);
    }
    source
}
