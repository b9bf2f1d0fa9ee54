//! The text of a table to columns of numbers. Line numbers in errors are those of the file.

use super::{ColumnName, Delimiter, IoError, TableSpec};

/// The wanted columns of a table.
#[derive(Debug)]
pub(super) struct Columns {
    /// Values, in the order of the spec's columns.
    pub values: Vec<Vec<f64>>,
    /// Rows of numbers.
    pub rows: usize,
    /// Line (from 1) of every row of numbers.
    pub lines: Vec<u64>,
}

/// A line of the file with its number from 1.
type Line<'a> = (u64, std::borrow::Cow<'a, str>);

/// Reads the columns that the spec names.
pub(super) fn read_columns(bytes: &[u8], spec: &TableSpec, path: &str) -> Result<Columns, IoError> {
    let mut lines = lines(bytes)
        .skip(spec.skip_lines)
        .filter(|(_, text)| !text.trim().is_empty());
    let named = spec
        .columns
        .iter()
        .any(|column| matches!(column.column, ColumnName::Heading(_)));
    let header = if named { lines.next() } else { None };
    let indices = column_indices(spec, header.as_ref(), path)?;
    let most = header
        .as_ref()
        .map(|(_, text)| fields(text, spec.delimiter).len());
    let mut numbers = Vec::new();
    let mut values = vec![Vec::new(); indices.len()];
    for (number, text) in lines {
        let fields = fields(&text, spec.delimiter);
        check_width(&fields, most, number, path)?;
        numbers.push(number);
        for (&index, column) in indices.iter().zip(&mut values) {
            column.push(number_in(&fields, index, number, path)?);
        }
    }
    let rows = values.first().map_or(0, Vec::len);
    if rows == 0 {
        return Err(IoError::Text {
            path: path.to_owned(),
            line: 1 + spec.skip_lines as u64,
            what: "rows of numbers",
            got: "none".to_owned(),
            expected: "at least one row after the heading".to_owned(),
        });
    }
    Ok(Columns {
        values,
        rows,
        lines: numbers,
    })
}

/// More fields than headings are decimal commas or another delimiter, not numbers to pass over.
fn check_width(
    fields: &[String],
    most: Option<usize>,
    line: u64,
    path: &str,
) -> Result<(), IoError> {
    match most.filter(|most| fields.len() > *most) {
        None => Ok(()),
        Some(most) => Err(IoError::Text {
            path: path.to_owned(),
            line,
            what: "fields of a row",
            got: format!("{} fields", fields.len()),
            expected: format!("{most}, as many as headings"),
        }),
    }
}

fn lines(bytes: &[u8]) -> impl Iterator<Item = Line<'_>> {
    let numbered = bytes.split(|byte| *byte == b'\n').enumerate();
    numbered.map(|(index, line)| {
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        (index as u64 + 1, String::from_utf8_lossy(line))
    })
}

/// Fields of one line, trimmed; quoted fields may hold the delimiter.
fn fields(text: &str, delimiter: Delimiter) -> Vec<String> {
    let byte = match delimiter {
        Delimiter::Blank => return text.split_whitespace().map(str::to_owned).collect(),
        Delimiter::Comma => b',',
        Delimiter::Semicolon => b';',
        Delimiter::Tab => b'\t',
    };
    if !text.contains('"') {
        return text
            .split(char::from(byte))
            .map(|field| field.trim().to_owned())
            .collect();
    }
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(byte)
        .has_headers(false)
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let record = reader.records().next().and_then(Result::ok);
    record.map_or_else(Vec::new, |record| {
        record.iter().map(str::to_owned).collect()
    })
}

fn column_indices(
    spec: &TableSpec,
    header: Option<&Line>,
    path: &str,
) -> Result<Vec<usize>, IoError> {
    let headings = header.map_or_else(Vec::new, |(_, text)| fields(text, spec.delimiter));
    let line = header.map_or(1 + spec.skip_lines as u64, |(number, _)| *number);
    let index = |column: &ColumnName| match column {
        ColumnName::Number(0) => Err((headings.join(", "), "numbers from 1".to_owned())),
        ColumnName::Number(number) => Ok(number - 1),
        ColumnName::Heading(name) => {
            let found = headings
                .iter()
                .position(|heading| heading.trim_start_matches('\u{feff}') == name);
            found.ok_or_else(|| (headings.join(", "), name.clone()))
        }
    };
    let missing = |(got, expected)| IoError::MissingColumn {
        path: path.to_owned(),
        line,
        got,
        expected,
    };
    spec.columns
        .iter()
        .map(|column| index(&column.column).map_err(missing))
        .collect()
}

fn number_in(fields: &[String], index: usize, line: u64, path: &str) -> Result<f64, IoError> {
    let error = |got: String| IoError::Text {
        path: path.to_owned(),
        line,
        what: "number",
        got,
        expected: format!("a finite number in column {}", index + 1),
    };
    let field = fields
        .get(index)
        .ok_or_else(|| error(format!("{} columns", fields.len())))?;
    let value = field.parse::<f64>().ok().filter(|value| value.is_finite());
    value.ok_or_else(|| error(field.clone()))
}
