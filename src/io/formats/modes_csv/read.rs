//! A text is read as a table of modes, row by row.

use crate::printable::counted;
use std::collections::{BTreeMap, BTreeSet};

use num_complex::Complex64;

use super::column::{Column, NAMED, Part, named_column};
use crate::dof::Dof;
use crate::io::formats::number::field;
use crate::io::{IoError, ModeEntry};
use crate::modal::{Mode, ModeShape, Scaling};

/// The characters that part cells.
const DELIMITERS: [u8; 3] = [b',', b';', b'\t'];

/// The lines that hold something, each with its number from 1: no remarks and none whose cells are
/// all empty. A heading `#,frequency_hz` is no remark.
fn lines(bytes: &[u8]) -> impl Iterator<Item = (u64, &[u8])> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    // A text without line feeds may end its lines with carriage returns.
    let end = if bytes.contains(&b'\n') { b'\n' } else { b'\r' };
    let empty =
        |byte: &u8| byte.is_ascii_whitespace() || *byte == b'"' || DELIMITERS.contains(byte);
    let lines = (1..).zip(bytes.split(move |byte| *byte == end));
    lines.filter(move |(_, line)| !line.iter().all(empty) && !is_remark(line))
}

fn is_remark(line: &[u8]) -> bool {
    let Some(rest) = line.trim_ascii_start().strip_prefix(b"#") else {
        return false;
    };
    let mut cells = rest.split(|byte| DELIMITERS.contains(byte));
    let is_number_column = cells
        .next()
        .is_some_and(|cell| cell.trim_ascii().is_empty());
    let next = cells.next().map(String::from_utf8_lossy);
    let is_heading =
        next.is_some_and(|next| named_column(unquoted(next.trim())) == Some(Column::Frequency));
    !(is_number_column && is_heading)
}

/// The remark of a table whose damping ratios are fractions although they look like percent.
pub(super) const FRACTIONS: &str = "# damping ratios are fractions";

/// Whether a line of a table is the remark [`FRACTIONS`].
pub(super) fn states_fractions(bytes: &[u8]) -> bool {
    let lines = bytes.split(|byte| matches!(byte, b'\n' | b'\r'));
    lines
        .map(<[u8]>::trim_ascii)
        .any(|line| line == FRACTIONS.as_bytes())
}

/// The cells of a line without the blanks and quotation marks around them.
fn cells(line: &str, delimiter: char) -> Vec<&str> {
    line.split(delimiter).map(str::trim).map(unquoted).collect()
}

fn unquoted(cell: &str) -> &str {
    let quoted = cell
        .strip_prefix('"')
        .and_then(|opened| opened.strip_suffix('"'));
    quoted.map_or(cell, str::trim)
}

/// Parts no cells of a single column, in which a number may have a decimal comma.
const DELIMITER_OF_ONE_COLUMN: char = ';';

/// The number of the first line and what parts its cells, if it is the heading of a table of modes:
/// frequencies first, then damping ratios or properties alone; a column of numbers or names of the
/// modes may stand anywhere. A table of frequencies and degrees
/// of freedom may hold FRFs.
pub(super) fn heading(bytes: &[u8]) -> (u64, Option<char>) {
    let (number, line) = lines(bytes).next().unwrap_or((1, b""));
    let line = String::from_utf8_lossy(line);
    let delimiters = DELIMITERS.map(char::from).into_iter();
    let begins = |delimiter: &char| {
        let columns = cells(&line, *delimiter).into_iter().map(named_column);
        let columns = columns.filter(|column| *column != Some(Column::Number));
        let columns: Vec<Option<Column>> = columns.collect();
        match columns.as_slice() {
            [Some(Column::Frequency), Some(Column::Damping), ..] => true,
            [Some(Column::Frequency), others @ ..] => others.iter().all(Option::is_some),
            _ => false,
        }
    };
    if begins(&DELIMITER_OF_ONE_COLUMN) {
        return (number, Some(DELIMITER_OF_ONE_COLUMN));
    }
    let mut delimiters = delimiters.filter(begins);
    (number, delimiters.next())
}

/// Which numbers a column takes, and how an error says it.
type Range = (fn(f64) -> bool, &'static str);

const FINITE: Range = (|_| true, "a finite number or nothing");
const NOT_NEGATIVE: Range = (|value| value >= 0.0, "a number of 0 or more, or nothing");
const POSITIVE: Range = (|value| value > 0.0, "a number above 0, or nothing");
const FREQUENCY: Range = (|value| value >= 0.0, "a frequency of 0 Hz or more");

/// Where a text is wrong.
struct Reader<'a> {
    path: &'a str,
    line: u64,
    /// What parts the cells.
    delimiter: char,
}

impl Reader<'_> {
    fn error(&self, what: &'static str, got: &str, expected: &str) -> IoError {
        IoError::Text {
            path: self.path.to_owned(),
            line: self.line,
            what,
            got: got.to_owned(),
            expected: expected.to_owned(),
        }
    }

    fn text<'b>(&self, line: &'b [u8]) -> Result<&'b str, IoError> {
        let text = std::str::from_utf8(line);
        text.map_err(|_| self.error("row", &String::from_utf8_lossy(line), "UTF-8 text"))
    }

    fn column(&self, name: &str) -> Result<Column, IoError> {
        if let Some(column) = named_column(name) {
            return Ok(column);
        }
        let (dof, part) = match name.rsplit_once(' ') {
            Some((dof, "re")) => (dof, Part::Real),
            Some((dof, "im")) => (dof, Part::Imaginary),
            _ => (name, Part::Whole),
        };
        let dof = dof.trim().parse::<Dof>().map_err(|_| {
            let names: Vec<&str> = NAMED.iter().map(|(heading, _)| *heading).collect();
            let names = names.join(", ");
            let expected =
                format!("{names}, mode, or a degree of freedom such as 12:+Z, 12:+Z re, 12:+Z im");
            self.error("column", name, &expected)
        })?;
        Ok(Column::Shape(dof, part))
    }

    /// The columns, each once, a real part with its imaginary one, a degree of freedom with one
    /// sign.
    fn columns(&self, names: &[&str]) -> Result<Vec<Column>, IoError> {
        let columns = names.iter().map(|name| self.column(name));
        let columns: Vec<Column> = columns.collect::<Result<_, _>>()?;
        let all: BTreeSet<&Column> = columns.iter().collect();
        let mut seen = BTreeSet::new();
        for (column, name) in columns.iter().zip(names) {
            if *column != Column::Number && !seen.insert(column) {
                return Err(self.error("column", name, "each column once"));
            }
            let Column::Shape(dof, part) = column else {
                continue;
            };
            let has = |part: Part| all.contains(&Column::Shape(dof.clone(), part));
            let alone = match part {
                Part::Whole => !has(Part::Real) && !has(Part::Imaginary),
                Part::Real => has(Part::Imaginary),
                Part::Imaginary => has(Part::Real),
            };
            if !alone {
                let expected = format!("{dof}, or {dof} re and {dof} im");
                return Err(self.error("column", name, &expected));
            }
        }
        self.one_sign(&columns)?;
        Ok(columns)
    }

    /// The values of `1:-Z` are those of `1:+Z` turned: with both there would be two for one degree
    /// of freedom.
    fn one_sign(&self, columns: &[Column]) -> Result<(), IoError> {
        let mut signed: BTreeMap<Dof, &Dof> = BTreeMap::new();
        for column in columns {
            let Column::Shape(dof, _) = column else {
                continue;
            };
            let first = *signed.entry(dof.positive()).or_insert(dof);
            if first != dof {
                let expected = format!("one sign for a degree of freedom; {first} is there");
                return Err(self.error("column", &dof.to_string(), &expected));
            }
        }
        Ok(())
    }

    fn number(
        &self,
        what: &'static str,
        text: &str,
        (holds, expected): Range,
    ) -> Result<Option<f64>, IoError> {
        if text.is_empty() {
            return Ok(None);
        }
        // Word processors print a minus sign in place of a hyphen.
        let hyphened = text.replace('\u{2212}', "-");
        let digits = hyphened.as_bytes();
        let comma = (self.delimiter != ',').then(|| field(digits, b','));
        let value = field(digits, b'.').or(comma.flatten());
        if value.is_some_and(f64::is_nan) {
            return Ok(None);
        }
        let value = value.filter(|value| value.is_finite() && holds(*value));
        let value = value.ok_or_else(|| self.error(what, text, expected))?;
        Ok(Some(value))
    }

    fn row(&self, columns: &[Column], text: &[u8]) -> Result<Mode, IoError> {
        let row = cells(self.text(text)?, self.delimiter);
        if row.len() != columns.len() {
            let got = counted(row.len(), "cell");
            let expected = format!("{} as in the heading", columns.len());
            return Err(self.error("row", &got, &expected));
        }
        self.mode(columns, &row)
    }

    fn mode(&self, columns: &[Column], row: &[&str]) -> Result<Mode, IoError> {
        let shape = self.shape(columns, row)?;
        let mut mode = Mode::new(f64::NAN, None, shape, Scaling::Unknown);
        for (column, cell) in columns.iter().zip(row) {
            let number = |what, range| self.number(what, cell, range);
            match column {
                Column::Frequency => {
                    let frequency = number("frequency_hz", FREQUENCY)?;
                    mode.frequency_hz =
                        frequency.ok_or_else(|| self.error("frequency_hz", cell, FREQUENCY.1))?;
                }
                Column::Damping => mode.damping_ratio = number("damping_ratio", FINITE)?,
                Column::FrequencyStd => {
                    mode.frequency_std_hz = number("frequency_std_hz", NOT_NEGATIVE)?;
                }
                Column::DampingStd => mode.damping_std = number("damping_std", NOT_NEGATIVE)?,
                Column::ModalMass => mode.modal_mass_kg = number("modal_mass_kg", POSITIVE)?,
                Column::Group if cell.is_empty() => {}
                Column::Group => {
                    let group = cell.parse().ok();
                    let group = group.ok_or_else(|| self.error("group", cell, "a whole number"));
                    mode.group = Some(group?);
                }
                Column::Scaling if cell.is_empty() => {}
                Column::Scaling => {
                    let expected = "unit-modal-mass, unit-max or unknown";
                    let scaling = Scaling::from_name(cell);
                    mode.scaling = scaling.ok_or_else(|| self.error("scaling", cell, expected))?;
                }
                Column::Number | Column::Shape(..) => {}
            }
        }
        Ok(mode)
    }

    /// The shape, of the degrees of freedom whose values are known.
    fn shape(&self, columns: &[Column], row: &[&str]) -> Result<ModeShape, IoError> {
        let mut parts: BTreeMap<&Dof, (Option<f64>, Option<f64>)> = BTreeMap::new();
        for (column, cell) in columns.iter().zip(row) {
            let Column::Shape(dof, part) = column else {
                continue;
            };
            let value = self.number("shape", cell, FINITE)?;
            let components = parts.entry(dof).or_default();
            match part {
                Part::Whole => *components = (value, value.map(|_| 0.0)),
                Part::Real => components.0 = value,
                Part::Imaginary => components.1 = value,
            }
        }
        let mut shape = Vec::new();
        for (dof, components) in parts {
            match components {
                (Some(re), Some(im)) => shape.push((dof.clone(), Complex64::new(re, im))),
                (None, None) => {}
                (re, _) => {
                    let alone = if re.is_some() { "re" } else { "im" };
                    let got = format!("{dof} {alone} alone");
                    let expected = format!("{dof} re and {dof} im, both or none");
                    return Err(self.error("shape", &got, &expected));
                }
            }
        }
        Ok(ModeShape::new(shape))
    }
}

/// The modes of all rows that are right, and what is wrong with the others. Numbers without a
/// heading, one in a line, are frequencies.
pub(super) fn read(bytes: &[u8], path: &str) -> Result<(Vec<ModeEntry>, Vec<IoError>), IoError> {
    let (line, delimiter) = heading(bytes);
    let mut reader = Reader {
        path,
        line,
        delimiter: delimiter.unwrap_or(DELIMITER_OF_ONE_COLUMN),
    };
    let mut lines = lines(bytes).peekable();
    let first = lines.peek().map_or(&b""[..], |(_, text)| text);
    let text = String::from_utf8_lossy(first);
    let is_number = |text: &str| matches!(reader.number("", text, FREQUENCY), Ok(Some(_)));
    let columns = match delimiter {
        Some(delimiter) => {
            lines.next();
            reader.columns(&cells(reader.text(first)?, delimiter))?
        }
        None if is_number(text.trim()) => vec![Column::Frequency],
        None => {
            let expected = "frequency_hz alone, or first and then damping_ratio";
            return Err(reader.error("heading", text.trim(), expected));
        }
    };
    let (mut modes, mut damage) = (Vec::new(), Vec::new());
    for (line, text) in lines {
        reader.line = line;
        match reader.row(&columns, text) {
            Ok(mode) => modes.push(ModeEntry {
                line: Some(line),
                ..ModeEntry::new(mode)
            }),
            Err(error) => damage.push(error),
        }
    }
    if modes.is_empty() {
        let none = || reader.error("modes", "a heading alone", "a line for each mode");
        return Err(damage.into_iter().next().unwrap_or_else(none));
    }
    Ok((modes, damage))
}
