//! Tables of numbers: CSV and its kin. A scene describes the columns; the dialect is judged by the
//! content where the scene does not state it. A table that modalign wrote states everything in its
//! headings ([`super::header_syntax`]).
//!
//! A row that is no row of numbers is damage: the rows before it are read, the rest is not.

use super::columns::{Wanted, places, read_columns, table_rows};
use super::dialect::{ColumnKind, Dialect, detect_dialect};
use super::encoding::{TextBlocks, is_text};
use super::entries::{entries_of, new_source, with_damage};
use super::header_syntax::{Meaning, meanings};
use super::header_units::with_heading_units;
use crate::finding::Finding;
use crate::io::columns::entries_from_columns;
use crate::io::{
    ArrayInfo, Confidence, Format, Hints, IoError, MemorySource, ReadSeek, Source, TableSpec,
    WriteOptions, WriteSeek,
};

/// Text tables: separated by comma, semicolon, tabulator or blanks.
pub struct Table;

impl Format for Table {
    fn name(&self) -> &'static str {
        "table"
    }

    fn written_extensions(&self) -> &'static [&'static str] {
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
        let dialect = detect_dialect(text.block(), text.line_end(), spec, path)?;
        let source = match (spec, meanings(&dialect.headings)) {
            (Some(spec), _) => assigned(&mut text, &dialect, spec, path)?,
            (None, Some(meanings)) if !dialect.kinds.contains(&ColumnKind::Complex) => {
                described(&mut text, &dialect, &meanings, path)?
            }
            (None, _) => listed(&mut text, &dialect, path)?,
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
    dialect: &Dialect,
    spec: &TableSpec,
    path: &str,
) -> Result<MemorySource, IoError> {
    let places = places(spec, dialect, path)?;
    let spec = &with_heading_units(spec, dialect, &places, path)?;
    let (columns, damage) = read_columns(text, dialect, &places, path)?;
    match (
        entries_from_columns("table", spec, vec![columns], path),
        damage,
    ) {
        (Ok(source), damage) => Ok(with_damage(source, damage)),
        // Too few rows for an axis, because of the damage.
        (Err(_), Some(damage)) => Err(damage),
        (Err(error), None) => Err(error),
    }
}

/// The entries that the headings describe.
fn described(
    text: &mut TextBlocks,
    dialect: &Dialect,
    meanings: &[Meaning],
    path: &str,
) -> Result<MemorySource, IoError> {
    let all: Vec<usize> = (0..dialect.width).collect();
    let mut rows = table_rows(text, dialect, &all, Wanted::Any, path)?;
    let damage = rows.damage.take();
    let mut source = new_source("table", path);
    entries_of(rows, meanings, &mut source);
    Ok(with_damage(source, damage))
}

/// The columns by name alone.
fn listed(text: &mut TextBlocks, dialect: &Dialect, path: &str) -> Result<MemorySource, IoError> {
    let numeric: Vec<usize> = (0..dialect.width)
        .filter(|column| dialect.kinds[*column] != ColumnKind::Other)
        .collect();
    let rows = table_rows(text, dialect, &numeric, Wanted::Counted, path)?;
    let mut source = new_source("table", path);
    let columns = (0..dialect.width).map(|column| ArrayInfo {
        name: column_name(dialect, column),
        shape: vec![rows.rows],
        kind: match dialect.kinds[column] {
            ColumnKind::Other => "text",
            ColumnKind::Real => "f64",
            ColumnKind::Complex => "complex f64",
        }
        .to_owned(),
    });
    source.catalog.arrays = columns.collect();
    Ok(with_damage(source, rows.damage))
}

/// Its heading with the unit of the row below, or its number.
fn column_name(dialect: &Dialect, column: usize) -> String {
    let text = |texts: &[String]| {
        let found = texts.get(column).filter(|text| !text.is_empty());
        found.cloned()
    };
    match (text(&dialect.headings), text(&dialect.units)) {
        (Some(heading), Some(unit)) if unit.starts_with(['[', '(']) => format!("{heading} {unit}"),
        (Some(heading), Some(unit)) => format!("{heading} [{unit}]"),
        (Some(heading), None) => heading,
        (None, _) => format!("column {}", column + 1),
    }
}
