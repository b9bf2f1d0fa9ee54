//! The dialect of a table is detected from its first block: separator, decimal mark, headings,
//! first row of numbers.
//!
//! Every notation is tried. The notation with the longest run of rows of numbers is used; notations
//! that read the same numbers are equal; where two read different numbers, as `1,5` alone in a
//! line, the scene must state the notation.

use super::encoding::{self, text_of};
use super::fields::{Cell, Notation, fields, is_passed_over, row_of};
use crate::io::{ColumnName, Delimiter, IoError, TableSpec};
use crate::printable::counted;
use crate::quantity::{FrfUnit, Unit};

/// Every notation, the one to prefer among equals first.
const NOTATIONS: [Notation; 8] = [
    notation(Delimiter::Tab, b'.'),
    notation(Delimiter::Tab, b','),
    notation(Delimiter::Semicolon, b'.'),
    notation(Delimiter::Semicolon, b','),
    notation(Delimiter::Comma, b'.'),
    // Quoted fields: "1,5","2,5".
    notation(Delimiter::Comma, b','),
    notation(Delimiter::Blank, b'.'),
    notation(Delimiter::Blank, b','),
];

const fn notation(delimiter: Delimiter, decimal: u8) -> Notation {
    Notation { delimiter, decimal }
}

/// Rows that make a beginning: fewer may be numbers in the header.
const MIN_FIRST_ROWS: usize = 3;

/// Bytes that settle the dialect where one notation alone makes a beginning in them; else the whole
/// block is looked at.
const DETECTION_BYTES: usize = 1 << 17;

/// Most columns: as many as a spreadsheet has.
pub(super) const MAX_COLUMNS: usize = 16_384;

/// The error of a line with more columns.
pub(super) fn too_wide(path: &str, line: u64, width: usize) -> IoError {
    IoError::Text {
        path: path.to_owned(),
        line,
        what: "columns of a table",
        got: counted(width, "column"),
        expected: format!("at most {MAX_COLUMNS}"),
    }
}

/// The values of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum ColumnKind {
    /// Dates, times of day or nothing.
    Other,
    /// Real numbers.
    Real,
    /// Complex numbers, some of which may be written as real ones.
    Complex,
}

impl ColumnKind {
    fn of(cell: Cell) -> Self {
        match cell {
            Cell::Other => ColumnKind::Other,
            Cell::Real(_) => ColumnKind::Real,
            Cell::Complex(_) => ColumnKind::Complex,
        }
    }
}

/// How a table is laid out.
#[derive(Debug)]
pub(super) struct Dialect {
    /// How its numbers are written.
    pub notation: Notation,
    /// Lines before the first row of numbers.
    pub lines_before: usize,
    /// Number of columns.
    pub width: usize,
    /// For each column whether the first row has a number there, and any row a complex one.
    pub kinds: Vec<ColumnKind>,
    /// Headings, as many as columns or none; headings named in a scene may be of another number.
    pub headings: Vec<String>,
    /// Units below the headings; empty where there is no such row.
    pub units: Vec<String>,
    /// Line (from 1) of the headings.
    pub heading_line: Option<u64>,
    /// Line (from 1) directly above the numbers, blank ones left away, and how many texts stand
    /// there.
    pub above: Option<(u64, usize)>,
    /// Line (from 1) of the units.
    pub units_line: Option<u64>,
}

/// A run of rows of numbers as one notation reads it.
#[derive(Debug)]
struct Reading {
    notation: Notation,
    /// Line, from 0, of its first row.
    start: usize,
    width: usize,
    rows: usize,
    kinds: Vec<ColumnKind>,
    /// Bits of the numbers, real and imaginary part.
    values: Vec<Option<[u64; 2]>>,
}

fn bits(cell: &Cell) -> Option<[u64; 2]> {
    match cell {
        Cell::Other => None,
        Cell::Real(value) => Some([value.to_bits(), 0]),
        Cell::Complex(value) => Some([value.re.to_bits(), value.im.to_bits()]),
    }
}

impl Reading {
    fn same_numbers(&self, other: &Reading) -> bool {
        (self.start, self.width) == (other.start, other.width) && self.values == other.values
    }

    /// Whether the other breaks off earlier; one column in itself says little, for `1,5` and `1;5`
    /// are no numbers.
    fn is_longer_than(&self, other: &Reading) -> bool {
        self.rows > other.rows && (self.width > 1 || other.width == 1)
    }
}

/// Judges the first block of a table.
///
/// # Errors
/// [`IoError::NoNumbers`]; [`IoError::NotStated`] when several notations
/// read different ones; [`IoError::MissingColumn`] when the scene names a heading that is not
/// there.
pub(super) fn detect_dialect(
    block: &[u8],
    line_end: u8,
    spec: Option<&TableSpec>,
    path: &str,
) -> Result<Dialect, IoError> {
    let head = memchr::memchr(line_end, &block[DETECTION_BYTES.min(block.len())..]);
    let head = &block[..head.map_or(block.len(), |end| DETECTION_BYTES + end + 1)];
    let mut lines: Vec<&[u8]> = encoding::lines(head, line_end).collect();
    let skipped = spec.map_or(0, |spec| spec.skip_lines);
    let stated = spec.and_then(|spec| spec.delimiter);
    let names = spec.map_or_else(Vec::new, stated_headings);
    let tried = NOTATIONS
        .iter()
        .filter(|notation| stated.is_none_or(|delimiter| notation.delimiter == delimiter));
    let read = |lines: &[&[u8]]| -> Vec<Reading> {
        let readings = tried
            .clone()
            .filter_map(|notation| longest_run(lines, skipped, *notation));
        readings.collect()
    };
    let mut readings = read(&lines);
    let begun = readings
        .iter()
        .filter(|reading| reading.rows >= MIN_FIRST_ROWS)
        .count();
    if begun != 1 && head.len() < block.len() {
        lines = encoding::lines(block, line_end).collect();
        readings = read(&lines);
    }
    if readings.is_empty() {
        return Err(IoError::NoNumbers {
            path: path.to_owned(),
            line: 1 + skipped as u64,
            got: match block.is_empty() {
                true => IoError::EMPTY_FILE,
                false => "text without rows of numbers",
            },
            separators: match stated {
                Some(delimiter) => delimiter.name().to_owned(),
                None => "comma, semicolon, tab or blank".to_owned(),
            },
        });
    }
    let chosen = choose_reading(
        &readings,
        &lines[skipped.min(lines.len())..],
        spec,
        &names,
        path,
    )?;
    if chosen.width > MAX_COLUMNS {
        return Err(too_wide(path, chosen.start as u64 + 1, chosen.width));
    }
    with_headings(chosen, &lines, skipped, &names, path)
}

/// The headings that a scene names.
fn stated_headings(spec: &TableSpec) -> Vec<&str> {
    let columns = spec.columns.iter();
    columns
        .filter_map(|column| match &column.column {
            ColumnName::Heading(name) => Some(name.as_str()),
            ColumnName::Number(_) => None,
        })
        .collect()
}

/// The first run of rows that makes a beginning, or the longest one; as far as it goes.
fn longest_run(lines: &[&[u8]], skipped: usize, notation: Notation) -> Option<Reading> {
    let mut best: Option<Reading> = None;
    let mut run: Option<Reading> = None;
    let mut row = Vec::new();
    let longer = |best: Option<Reading>, run: Option<Reading>| match (best, run) {
        (Some(best), Some(run)) if best.rows >= run.rows => Some(best),
        (best, run) => run.or(best),
    };
    for (index, line) in lines.iter().enumerate().skip(skipped) {
        if is_passed_over(line) {
            continue;
        }
        let is_row = row_of(line, notation, &mut row);
        if let Some(block) = run
            .as_mut()
            .filter(|block| is_row && block.width == row.len())
        {
            block.rows += 1;
            block.values.extend(row.iter().map(bits));
            for (kind, cell) in block.kinds.iter_mut().zip(&row) {
                if *kind == ColumnKind::Real {
                    *kind = ColumnKind::of(*cell).max(*kind);
                }
            }
            continue;
        }
        if run
            .as_ref()
            .is_some_and(|block| block.rows >= MIN_FIRST_ROWS)
        {
            return run;
        }
        best = longer(best, run.take());
        run = is_row.then(|| Reading {
            notation,
            start: index,
            width: row.len(),
            rows: 1,
            kinds: row.iter().map(|cell| ColumnKind::of(*cell)).collect(),
            values: row.iter().map(bits).collect(),
        });
    }
    longer(best, run)
}

/// The reading that is meant.
fn choose_reading<'a>(
    readings: &'a [Reading],
    lines: &[&[u8]],
    spec: Option<&TableSpec>,
    names: &[&str],
    path: &str,
) -> Result<&'a Reading, IoError> {
    let unbeaten = readings
        .iter()
        .filter(|reading| !readings.iter().any(|other| other.is_longer_than(reading)));
    let mut left: Vec<&Reading> = Vec::new();
    for reading in unbeaten {
        if !left.iter().any(|other| other.same_numbers(reading)) {
            left.push(reading);
        }
    }
    let skipped = spec.map_or(0, |spec| spec.skip_lines);
    let header = |reading: &Reading| &lines[..reading.start - skipped];
    // What the scene names must be there.
    let last = spec.map_or(0, largest_column_number);
    let fits = |reading: &&&Reading| {
        reading.width >= last
            && line_with_headings(header(reading), reading.notation, names).is_some()
    };
    let fitting: Vec<&Reading> = left.iter().filter(fits).copied().collect();
    if !fitting.is_empty() {
        left = fitting;
    }
    if left.len() > 1 {
        let headed: Vec<&Reading> = left
            .iter()
            .filter(|reading| is_headed(reading, header(reading)))
            .copied()
            .collect();
        if headed.len() == 1 {
            left = headed;
        }
    }
    // A decimal comma in one column could be two columns of whole numbers, more or less of them in
    // each row.
    let settled = |reading: &Reading| {
        reading.width > 1
            || reading.notation.decimal == b'.'
            || spec.is_some_and(|spec| spec.delimiter.is_some())
    };
    match left.as_slice() {
        [reading] if settled(reading) => Ok(reading),
        several => Err(ambiguous_separator(several, path)),
    }
}

/// Whether the line above the numbers has a heading for each of several columns; a heading that is
/// a unit belongs to the one before it (`Force, N`).
fn is_headed(reading: &Reading, header: &[&[u8]]) -> bool {
    let above = header
        .iter()
        .rev()
        .find(|line| !line.trim_ascii().is_empty());
    let headings = above.map_or_else(Vec::new, |line| headings(line, reading.notation));
    reading.width > 1
        && headings.len() == reading.width
        && !headings.iter().any(|heading| is_unit(heading))
}

fn largest_column_number(spec: &TableSpec) -> usize {
    let number = |column: &ColumnName| match column {
        ColumnName::Number(number) => *number,
        ColumnName::Heading(_) => 0,
    };
    let numbers = spec.columns.iter().map(|column| number(&column.column));
    numbers.max().unwrap_or(0)
}

fn ambiguous_separator(readings: &[&Reading], path: &str) -> IoError {
    let one = |reading: &&Reading| {
        let mark = if reading.notation.decimal == b',' {
            "decimal comma"
        } else {
            "decimal point"
        };
        let columns = if reading.width == 1 {
            "one column".to_owned()
        } else {
            format!(
                "{} columns separated by {}",
                reading.width,
                reading.notation.delimiter.name()
            )
        };
        format!("{columns} with {mark}")
    };
    let candidates: Vec<String> = readings.iter().map(one).collect();
    IoError::NotStated {
        path: path.to_owned(),
        what: format!("what separates the columns ({})", candidates.join(", or ")),
        expected: "`delimiter` in [[test]]: comma, semicolon, tab or blank (for one column with decimal comma: semicolon)"
            .to_owned(),
    }
}

/// Headings of a line: without comment mark, and with what stands in brackets joined to what is
/// before it.
fn headings(line: &[u8], notation: Notation) -> Vec<String> {
    let line = line.trim_ascii_start();
    let line = line
        .strip_prefix(b"#")
        .or(line.strip_prefix(b"%"))
        .unwrap_or(line);
    let found = fields(line, notation.delimiter).into_iter().map(text_of);
    if notation.delimiter != Delimiter::Blank {
        return found.collect();
    }
    let mut joined: Vec<String> = Vec::new();
    for word in found {
        match joined.last_mut() {
            Some(before) if word.starts_with(['[', '(']) => *before = format!("{before} {word}"),
            _ => joined.push(word),
        }
    }
    joined
}

/// Places of the headings that a scene may mean by a name: the whole heading, or else all but its
/// unit.
pub(super) fn columns_with_heading(headings: &[String], name: &str) -> Vec<usize> {
    let with = |same: &dyn Fn(&str) -> bool| -> Vec<usize> {
        let places = headings.iter().enumerate();
        let found = places.filter(|(_, heading)| same(heading));
        found.map(|(place, _)| place).collect()
    };
    let whole = with(&|heading| heading == name);
    if whole.is_empty() {
        with(&|heading| without_unit(heading) == name)
    } else {
        whole
    }
}

/// A heading without the unit in brackets behind it.
fn without_unit(heading: &str) -> &str {
    split_unit(heading).map_or(heading, |(name, _)| name)
}

/// A heading and the unit in brackets behind it, with its brackets.
pub(super) fn split_unit(heading: &str) -> Option<(&str, &str)> {
    let opens = |at: &usize| heading[*at..].trim_start().starts_with(['[', '(']);
    let blank = heading.rfind([' ', '\t']).filter(opens);
    let at = blank.or_else(|| heading.find(['[', '(']))?;
    let closed = heading.ends_with([']', ')']) && at > 0;
    closed.then(|| (heading[..at].trim_end(), heading[at..].trim_start()))
}

/// The lowest line that has every heading of a scene, by its place among the lines.
fn line_with_headings(header: &[&[u8]], notation: Notation, names: &[&str]) -> Option<usize> {
    header
        .iter()
        .rposition(|line| {
            let headings = headings(line, notation);
            !headings.is_empty()
                && names
                    .iter()
                    .all(|name| !columns_with_heading(&headings, name).is_empty())
        })
        .or_else(|| names.is_empty().then_some(0))
}

/// The dialect with the headings that belong to the chosen reading.
fn with_headings(
    reading: &Reading,
    lines: &[&[u8]],
    skipped: usize,
    names: &[&str],
    path: &str,
) -> Result<Dialect, IoError> {
    let of = |index: usize| headings(lines[index], reading.notation);
    let mut dialect = Dialect {
        notation: reading.notation,
        lines_before: reading.start,
        width: reading.width,
        kinds: reading.kinds.clone(),
        headings: Vec::new(),
        units: Vec::new(),
        heading_line: None,
        above: None,
        units_line: None,
    };
    let header = &lines[skipped..reading.start];
    let above = (skipped..reading.start).rev();
    let above = above.filter(|index| !lines[*index].trim_ascii().is_empty());
    let texts = |index: usize| (index as u64 + 1, of(index).len());
    dialect.above = above.clone().next().map(texts);
    let mut fitting = above
        .clone()
        .filter(|index| of(*index).len() == reading.width);
    let (first, second) = (fitting.next(), fitting.next());
    let is_units = |index: &usize| of(*index).iter().all(|text| is_unit(text));
    let mut units = first.filter(is_units).filter(|_| second.is_some());
    let found = if !names.is_empty() {
        let named =
            line_with_headings(header, reading.notation, names).map(|index| skipped + index);
        let nearest = first
            .or(above.clone().next())
            .map(|index| (index, of(index)));
        Some(named.ok_or_else(|| missing_column(nearest, names, path))?)
    } else if units.is_some() {
        second
    } else {
        first
    };
    // A scene may name what stands in the row of units, or above other rows.
    units = units.filter(|units| found.is_some_and(|headings| headings < *units));
    if let Some(index) = units {
        dialect.units = of(index);
        dialect.units_line = Some(index as u64 + 1);
    }
    if let Some(index) = found {
        dialect.headings = of(index);
        dialect.heading_line = Some(index as u64 + 1);
    }
    Ok(dialect)
}

fn missing_column(nearest: Option<(usize, Vec<String>)>, names: &[&str], path: &str) -> IoError {
    let (index, headings) = nearest.unwrap_or_default();
    let absent = names
        .iter()
        .find(|name| columns_with_heading(&headings, name).is_empty());
    IoError::MissingColumn {
        path: path.to_owned(),
        line: index as u64 + 1,
        got: headings.join(", "),
        expected: absent.map_or_else(String::new, |name| (*name).to_owned()),
    }
}

/// Units that only axes and signals have.
const OTHER_UNITS: [&str; 18] = [
    "s", "ms", "us", "min", "Hz", "kHz", "rad/s", "rpm", "1/min", "deg", "\u{b0}", "rad", "V",
    "mV", "Pa", "%", "-", "1",
];

/// A unit without the brackets around it.
pub(super) fn bare_unit(text: &str) -> &str {
    let inside = |open, close| text.strip_prefix(open)?.strip_suffix(close);
    inside('[', ']').or(inside('(', ')')).unwrap_or(text)
}

/// Whether a text is a unit alone, in brackets or not.
fn is_unit(text: &str) -> bool {
    let text = text.trim();
    let bare = bare_unit(text);
    OTHER_UNITS.contains(&bare)
        || [bare, text]
            .iter()
            .any(|text| text.parse::<Unit>().is_ok() || text.parse::<FrfUnit>().is_ok())
}
