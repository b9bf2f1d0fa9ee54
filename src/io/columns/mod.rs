//! Columns of numbers that a scene describes become records and functions: the common end of text
//! tables and of arrays.
//!
//! A scene states the role of each column (time, force, response, a part of an FRF), its unit and
//! its DOF, because the file does not. Nothing here knows a file format or opens a path.

mod even_axis;
mod roles;
mod table_spec;

use std::borrow::Cow;

use num_complex::Complex64;

use crate::axis::{FrequencyAxis, TimeAxis};
use crate::dof::Dof;
use crate::quantity::{FrfUnit, Quantity, Unit};
use crate::record::Role;

use crate::io::{Block, Entry, EntryAxis, FunctionType, IoError, MemorySource, SampleFormat};

pub(in crate::io) use even_axis::even_axis;
pub(in crate::io) use roles::frf_unit_text;
pub use table_spec::{ColumnName, ColumnRole, Delimiter, Dimension, TableColumn, TableSpec};

use roles::check_roles;

/// A stated sampling rate and a time column may differ by this fraction.
const MAX_RATE_DIFFERENCE: f64 = 1e-3;

/// The wanted columns of one table, or of one hit of an array.
#[derive(Debug)]
pub(in crate::io) struct Columns {
    /// Values, in the order of the spec's columns, each of `rows` values.
    pub values: Vec<Block>,
    /// Rows of numbers.
    pub rows: usize,
    /// Where the rows stand in the file.
    pub lines: RowLines,
}

/// Line of every row of a text table; nothing for an array.
#[derive(Clone, Debug, Default)]
pub(in crate::io) struct RowLines {
    /// Row and line where a run of consecutive lines begins.
    runs: Vec<(usize, u64)>,
}

impl RowLines {
    /// Notes that `row` stands on `line` (from 1); rows come in order.
    pub fn push(&mut self, row: usize, line: u64) {
        let continues = self
            .runs
            .last()
            .is_some_and(|(first, at)| at + (row - first) as u64 == line);
        if !continues {
            self.runs.push((row, line));
        }
    }

    /// Adds the rows of another list behind the first `rows` rows, its line 0 being `line`.
    pub fn append(&mut self, other: &RowLines, rows: usize, line: u64) {
        for (row, start) in &other.runs {
            self.push(rows + row, line + start);
        }
    }

    /// The line of a row.
    pub fn line(&self, row: usize) -> Option<u64> {
        let run = self.runs.partition_point(|(first, _)| *first <= row);
        let (first, line) = self.runs.get(run.checked_sub(1)?)?;
        Some(line + (row - first) as u64)
    }
}

/// Makes records or functions of columns as the spec says. Of several sets of columns each is one
/// hit: its records carry the number of the set, from 1, as version.
///
/// # Errors
/// [`IoError`] for an axis that is missing, uneven or contradicts the spec, for an FRF without
/// imaginary part, and for columns that nothing uses or that could be taken for one another.
pub(in crate::io) fn entries_from_columns(
    format: &'static str,
    spec: &TableSpec,
    sets: Vec<Columns>,
    path: &str,
) -> Result<MemorySource, IoError> {
    let mut source = MemorySource::default();
    (source.catalog.format, source.catalog.path) = (format, path.to_owned());
    check_roles(spec, path)?;
    let several = sets.len() > 1;
    for (number, columns) in sets.into_iter().enumerate() {
        let first = source.catalog.entries.len();
        if is_frf(spec) {
            push_frf_entries(spec, &columns, path, &mut source)?;
        } else {
            push_time_entries(spec, columns, path, &mut source)?;
        }
        for entry in source.catalog.entries[first..]
            .iter_mut()
            .filter(|_| several)
        {
            entry.identification.version = number as i64 + 1;
        }
    }
    Ok(source)
}

fn is_frf(spec: &TableSpec) -> bool {
    let of_functions = |role: &ColumnRole| {
        !matches!(
            role,
            ColumnRole::Time | ColumnRole::Force { .. } | ColumnRole::Response { .. }
        )
    };
    spec.columns.iter().any(|column| of_functions(&column.role))
}

fn push_time_entries(
    spec: &TableSpec,
    columns: Columns,
    path: &str,
    source: &mut MemorySource,
) -> Result<(), IoError> {
    let axis = EntryAxis::Time(time_axis(spec, &columns, path)?);
    let line = columns.lines.line(0);
    for (column, values) in spec.columns.iter().zip(columns.values) {
        let (role, dof, unit) = match &column.role {
            ColumnRole::Force { dof, unit } => (Role::Force, dof.clone(), unit),
            ColumnRole::Response { dof, unit } => (Role::Response, dof.clone(), unit),
            _ => continue,
        };
        let format = match &values {
            Block::F32(_) => SampleFormat::RealF32,
            Block::F64(_) => SampleFormat::RealF64,
            Block::Complex(_) => return Err(complex_values_error(path, "a time record")),
        };
        let base = Entry::new(FunctionType::Time, axis, format);
        let entry = time_entry(Entry { line, ..base }, role, dof, *unit, column.scale);
        source.push(entry, values, Vec::new());
    }
    Ok(())
}

fn time_entry(base: Entry, role: Role, dof: Option<Dof>, unit: Unit, scale: f64) -> Entry {
    Entry {
        role: Some(role),
        response: dof,
        quantity: Some(unit.quantity),
        to_si: Some(scale * unit.to_si),
        unit_label: if scale.to_bits() == 1f64.to_bits() {
            unit.to_string()
        } else {
            format!("{scale} x {unit}")
        },
        ..base
    }
}

fn complex_values_error(path: &str, what: &'static str) -> IoError {
    IoError::Grouping {
        path: path.to_owned(),
        what,
        got: "complex values".to_owned(),
        expected: "real values".to_owned(),
    }
}

/// A factor, and the values that it belongs to.
type Scaled<'a> = (f64, Cow<'a, [f64]>);

/// Scale and values of the first column in a role; complex values whose imaginary part is 0 are
/// real.
fn column_with_role<'a>(
    spec: &TableSpec,
    columns: &'a Columns,
    role: &ColumnRole,
    path: &str,
) -> Result<Option<Scaled<'a>>, IoError> {
    let index = spec.columns.iter().position(|column| column.role == *role);
    index
        .map(|index| {
            let values = real_values(&columns.values[index]);
            let values = values.ok_or_else(|| complex_values_error(path, "an axis"))?;
            Ok((spec.columns[index].scale, values))
        })
        .transpose()
}

fn real_values(block: &Block) -> Option<Cow<'_, [f64]>> {
    match block {
        Block::F32(values) => Some(values.iter().map(|v| f64::from(*v)).collect()),
        Block::F64(values) => Some(Cow::Borrowed(values)),
        Block::Complex(values) => values
            .iter()
            .map(|v| (v.im.abs() <= f64::EPSILON * v.re.abs()).then_some(v.re))
            .collect(),
    }
}

fn time_axis(spec: &TableSpec, columns: &Columns, path: &str) -> Result<TimeAxis, IoError> {
    let stated = spec.sampling_rate_hz.map(|rate| 1.0 / rate);
    let (start_s, step_s) = match column_with_role(spec, columns, &ColumnRole::Time, path)? {
        Some((scale, times)) => {
            let scale = scale * spec.axis_to_si.unwrap_or(1.0);
            even_axis(&times, scale, "time", &columns.lines, path)?
        }
        None => {
            let step = stated.ok_or_else(|| IoError::NotStated {
                path: path.to_owned(),
                what: "the sampling rate".to_owned(),
                expected: "a column with role = \"time\", or sampling_rate_hz in [[test]]"
                    .to_owned(),
            })?;
            (0.0, step)
        }
    };
    match stated.filter(|step| (step - step_s).abs() > MAX_RATE_DIFFERENCE * step) {
        Some(step) => Err(row_error(
            path,
            &columns.lines,
            0,
            "spacing of the time column",
            format!("{step_s} s"),
            format!("{step} s (sampling_rate_hz of the scene)"),
        )),
        None => Ok(TimeAxis {
            start_s,
            step_s: stated.unwrap_or(step_s),
            len: columns.rows,
        }),
    }
}

/// An error at a row: by its line, or by its number from 1 in an array.
fn row_error(
    path: &str,
    lines: &RowLines,
    row: usize,
    what: &'static str,
    got: String,
    expected: String,
) -> IoError {
    match lines.line(row) {
        Some(line) => IoError::Text {
            path: path.to_owned(),
            line,
            what,
            got,
            expected,
        },
        None => IoError::Grouping {
            path: path.to_owned(),
            what,
            got: format!("{got} (row {})", row + 1),
            expected,
        },
    }
}

fn push_frf_entries(
    spec: &TableSpec,
    columns: &Columns,
    path: &str,
    source: &mut MemorySource,
) -> Result<(), IoError> {
    let (scale, hz) =
        column_with_role(spec, columns, &ColumnRole::Frequency, path)?.ok_or_else(|| {
            IoError::NotStated {
                path: path.to_owned(),
                what: "the frequency axis".to_owned(),
                expected: "a column with role = \"frequency\"".to_owned(),
            }
        })?;
    let scale = scale * spec.axis_to_si.unwrap_or(1.0);
    let (start_hz, step_hz) = even_axis(&hz, scale, "frequency", &columns.lines, path)?;
    let axis = EntryAxis::Frequency(FrequencyAxis {
        start_hz,
        step_hz,
        len: columns.rows,
    });
    let line = columns.lines.line(0);
    for (index, column) in spec.columns.iter().enumerate() {
        if let ColumnRole::Coherence { dof } = &column.role {
            let values = real_values(&columns.values[index])
                .ok_or_else(|| complex_values_error(path, "a coherence"))?;
            let base = Entry::new(FunctionType::Coherence, axis, SampleFormat::RealF64);
            let entry = Entry {
                response: dof.clone(),
                to_si: Some(1.0),
                line,
                ..base
            };
            let values = values.iter().map(|v| column.scale * v).collect();
            source.push(entry, Block::F64(values), Vec::new());
            continue;
        }
        let Some((dof, unit, values)) = frf_column(spec, columns, index, path)? else {
            continue;
        };
        let base = Entry::new(FunctionType::Frf, axis, SampleFormat::ComplexF64);
        let entry = Entry {
            response: dof,
            quantity: Some(unit.kind.response_quantity()),
            denominator: Some(Quantity::Force),
            to_si: Some(unit.to_si),
            unit_label: frf_unit_text(&unit),
            line,
            ..base
        };
        source.push(entry, Block::Complex(values), Vec::new());
    }
    Ok(())
}

type FrfColumn = (Option<Dof>, FrfUnit, Vec<Complex64>);

/// The FRF that begins with this column: complex, real part, or magnitude.
fn frf_column(
    spec: &TableSpec,
    columns: &Columns,
    index: usize,
    path: &str,
) -> Result<Option<FrfColumn>, IoError> {
    let column = &spec.columns[index];
    let part_values = || {
        real_values(&columns.values[index])
            .ok_or_else(|| complex_values_error(path, "part of an FRF"))
    };
    let (dof, unit, values) = match &column.role {
        ColumnRole::Complex { dof, unit } => {
            let values = match &columns.values[index] {
                Block::Complex(values) => values.iter().map(|v| v * column.scale).collect(),
                _ => {
                    return Err(IoError::Grouping {
                        path: path.to_owned(),
                        what: "reading an FRF",
                        got: "real values".to_owned(),
                        expected: "complex values, or roles real and imaginary".to_owned(),
                    });
                }
            };
            (dof, unit, values)
        }
        ColumnRole::Real { dof, unit } => {
            let wanted = ColumnRole::Imaginary {
                dof: dof.clone(),
                unit: *unit,
            };
            let (factor, imaginary) = partner_column(spec, columns, &wanted, path)?;
            let real_values = part_values()?;
            let parts = real_values.iter().zip(imaginary.iter());
            let values = parts.map(|(re, im)| Complex64::new(column.scale * re, factor * im));
            (dof, unit, values.collect())
        }
        ColumnRole::Magnitude { dof, unit } => {
            let wanted = ColumnRole::PhaseDegrees { dof: dof.clone() };
            let (factor, phase) = partner_column(spec, columns, &wanted, path)?;
            let magnitudes = part_values()?;
            let parts = magnitudes.iter().zip(phase.iter());
            let values = parts.map(|(magnitude, degrees)| {
                Complex64::from_polar(column.scale * magnitude, (factor * degrees).to_radians())
            });
            (dof, unit, values.collect())
        }
        _ => return Ok(None),
    };
    Ok(Some((dof.clone(), *unit, values)))
}

fn partner_column<'a>(
    spec: &TableSpec,
    columns: &'a Columns,
    wanted: &ColumnRole,
    path: &str,
) -> Result<Scaled<'a>, IoError> {
    column_with_role(spec, columns, wanted, path)?.ok_or_else(|| {
        let (what, expected) = match wanted {
            ColumnRole::PhaseDegrees { .. } => (
                "the phase of an FRF",
                "a column with role = \"phase\" and the same dof as the magnitude",
            ),
            _ => (
                "the imaginary part of an FRF",
                "a column with role = \"imaginary\" and the same dof and unit as the real part",
            ),
        };
        IoError::NotStated {
            path: path.to_owned(),
            what: what.to_owned(),
            expected: expected.to_owned(),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_of_a_row_is_known_past_gaps() {
        let mut lines = RowLines::default();
        for (row, line) in [(0, 3), (1, 4), (2, 7), (3, 8), (4, 20)] {
            lines.push(row, line);
        }
        let found: Vec<_> = (0..5).map(|row| lines.line(row).unwrap()).collect();
        assert_eq!(found, [3, 4, 7, 8, 20]);
        assert_eq!(lines.runs.len(), 3);
        assert_eq!(RowLines::default().line(0), None);
    }
}
