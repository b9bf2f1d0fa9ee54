//! Tables of numbers: CSV and its kin, described by the scene because they do not describe themselves.

use std::io::Read;
use std::ops::Range;

use num_complex::Complex64;

use crate::axis::{FrequencyAxis, TimeAxis};
use crate::dof::Dof;
use crate::quantity::{FrfUnit, Quantity, Unit};
use crate::record::Role;

use super::table_columns::{Columns, read_columns};
use super::{
    Block, Catalog, ColumnRole, Confidence, Entry, EntryAxis, Format, FunctionType, Hints,
    Identification, IoError, ReadSeek, SampleFormat, Source, TableSpec,
};

/// Abscissae count as even when each lies within this fraction of the spacing of its place.
const EVENNESS: f64 = 0.5;

/// A stated sampling rate and a time column may differ by this fraction.
const RATE_AGREEMENT: f64 = 1e-3;

/// Text tables: separated by comma, semicolon, tabulator or blanks.
pub struct Table;

impl Format for Table {
    fn name(&self) -> &'static str {
        "table"
    }

    fn detect(&self, head: &[u8]) -> Confidence {
        let text = |byte: &u8| matches!(byte, b'\t' | b'\n' | b'\r' | 0x20..=0x7e | 0x80..=0xff);
        if head.iter().all(text) {
            Confidence::Possible
        } else {
            Confidence::No
        }
    }

    fn open(
        &self,
        mut input: Box<dyn ReadSeek>,
        hints: &Hints,
    ) -> Result<Box<dyn Source>, IoError> {
        let mut bytes = Vec::new();
        input
            .read_to_end(&mut bytes)
            .map_err(|source| IoError::System {
                path: hints.path.clone(),
                action: "read",
                source,
            })?;
        let Some(spec) = hints.table.as_ref().filter(|spec| !spec.columns.is_empty()) else {
            return Err(IoError::NotStated {
                path: hints.path.clone(),
                what: "what the columns of this table are".to_owned(),
                expected: "[[test.channel]] with column, role and unit in a scene".to_owned(),
            });
        };
        let columns = read_columns(&bytes, spec, &hints.path)?;
        let (entries, blocks) = entries(spec, columns, &hints.path)?;
        let catalog = Catalog {
            format: "table",
            path: hints.path.clone(),
            entries,
            ..Catalog::default()
        };
        Ok(Box::new(TableSource { catalog, blocks }))
    }
}

struct TableSource {
    catalog: Catalog,
    blocks: Vec<Block>,
}

impl Source for TableSource {
    fn catalog(&self) -> &Catalog {
        &self.catalog
    }

    fn take_damage(&mut self) -> Vec<IoError> {
        std::mem::take(&mut self.catalog.damage)
    }

    fn read(
        &mut self,
        entry: usize,
        range: Range<usize>,
        block: &mut Block,
    ) -> Result<(), IoError> {
        let stored = &self.blocks[entry];
        let len = self.catalog.entries[entry].len();
        if range.end > len {
            return Err(IoError::Binary {
                path: self.catalog.path.clone(),
                byte: 0,
                what: "range of samples",
                got: format!("{} to {}", range.start, range.end),
                expected: format!("up to {len}"),
            });
        }
        *block = match stored {
            Block::F32(values) => Block::F32(values[range].to_vec()),
            Block::F64(values) => Block::F64(values[range].to_vec()),
            Block::Complex(values) => Block::Complex(values[range].to_vec()),
        };
        Ok(())
    }
}

fn entries(
    spec: &TableSpec,
    columns: Columns,
    path: &str,
) -> Result<(Vec<Entry>, Vec<Block>), IoError> {
    let is_frf = spec.columns.iter().any(|column| {
        matches!(
            column.role,
            ColumnRole::Real { .. } | ColumnRole::Imaginary { .. }
        )
    });
    if is_frf {
        frf_entries(spec, &columns, path)
    } else {
        time_entries(spec, columns, path)
    }
}

/// What all entries of a table have in common.
fn entry(function_type: FunctionType, axis: EntryAxis, format: SampleFormat, line: u64) -> Entry {
    Entry {
        function_type,
        identification: Identification::default(),
        response: None,
        reference: None,
        quantity: None,
        denominator: None,
        to_si: None,
        unit_label: String::new(),
        role: None,
        axis,
        format,
        line: Some(line),
        byte: None,
    }
}

fn time_entries(
    spec: &TableSpec,
    columns: Columns,
    path: &str,
) -> Result<(Vec<Entry>, Vec<Block>), IoError> {
    let axis = EntryAxis::Time(time_axis(spec, &columns, path)?);
    let base = entry(
        FunctionType::Time,
        axis,
        SampleFormat::RealF64,
        columns.lines[0],
    );
    let (mut entries, mut blocks) = (Vec::new(), Vec::new());
    for (column, values) in spec.columns.iter().zip(columns.values) {
        let (role, dof, unit) = match &column.role {
            ColumnRole::Force { dof, unit } => (Role::Force, dof.clone(), unit),
            ColumnRole::Response { dof, unit } => (Role::Response, dof.clone(), unit),
            _ => continue,
        };
        entries.push(time_entry(&base, role, dof, *unit, column.scale));
        blocks.push(Block::F64(values));
    }
    Ok((entries, blocks))
}

fn time_entry(base: &Entry, role: Role, dof: Option<Dof>, unit: Unit, scale: f64) -> Entry {
    Entry {
        role: Some(role),
        response: dof,
        quantity: Some(unit.quantity),
        to_si: Some(scale * unit.to_si),
        unit_label: unit.name.to_owned(),
        ..base.clone()
    }
}

fn column_of<'a>(
    spec: &TableSpec,
    columns: &'a Columns,
    is: impl Fn(&ColumnRole) -> bool,
) -> Option<(f64, &'a [f64])> {
    let index = spec.columns.iter().position(|column| is(&column.role))?;
    Some((spec.columns[index].scale, &columns.values[index]))
}

fn time_axis(spec: &TableSpec, columns: &Columns, path: &str) -> Result<TimeAxis, IoError> {
    let stated = spec.sampling_rate_hz.map(|rate| 1.0 / rate);
    let (start_s, step_s) = match column_of(spec, columns, |role| *role == ColumnRole::Time) {
        Some((scale, times)) => even_axis(times, scale, "time", columns, path)?,
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
    match stated.filter(|step| (step - step_s).abs() > RATE_AGREEMENT * step) {
        Some(step) => Err(IoError::Text {
            path: path.to_owned(),
            line: columns.lines[0],
            what: "spacing of the time column",
            got: format!("{step_s} s"),
            expected: format!("{step} s (sampling_rate_hz of the scene)"),
        }),
        None => Ok(TimeAxis {
            start_s,
            step_s: stated.unwrap_or(step_s),
            len: columns.rows,
        }),
    }
}

/// Start and spacing of an even column: (last − first)/(n − 1), because a printed spacing is rounded.
fn even_axis(
    values: &[f64],
    scale: f64,
    what: &'static str,
    columns: &Columns,
    path: &str,
) -> Result<(f64, f64), IoError> {
    let n = values.len();
    let error = |row: usize, got: String, expected: String| IoError::Text {
        path: path.to_owned(),
        line: columns.lines[row],
        what,
        got,
        expected,
    };
    if n < 2 {
        return Err(error(0, format!("{n} rows"), "two rows or more".to_owned()));
    }
    let step = (values[n - 1] - values[0]) / (n - 1) as f64;
    if step.is_nan() || step * scale <= 0.0 {
        return Err(error(
            n - 1,
            format!("{} after {}", values[n - 1], values[0]),
            "ascending values".to_owned(),
        ));
    }
    let place = |row: usize| values[0] + row as f64 * step;
    let gap = |row: usize| values[row] - values[row - 1];
    if let Some(row) = (1..n).find(|row| (gap(*row) - step).abs() > EVENNESS * step) {
        let got = format!("{} after {}", values[row], values[row - 1]);
        return Err(error(
            row,
            got,
            format!("steps of {step}; is a row missing?"),
        ));
    }
    match (0..n).find(|row| (values[*row] - place(*row)).abs() > EVENNESS * step) {
        Some(row) => Err(error(
            row,
            values[row].to_string(),
            format!("{} (evenly spaced by {step})", place(row)),
        )),
        None => Ok((scale * values[0], scale * step)),
    }
}

fn frf_entries(
    spec: &TableSpec,
    columns: &Columns,
    path: &str,
) -> Result<(Vec<Entry>, Vec<Block>), IoError> {
    let (scale, hz) =
        column_of(spec, columns, |role| *role == ColumnRole::Frequency).ok_or_else(|| {
            IoError::NotStated {
                path: path.to_owned(),
                what: "the frequency axis".to_owned(),
                expected: "a column with role = \"frequency\"".to_owned(),
            }
        })?;
    let (start_hz, step_hz) = even_axis(hz, scale, "frequency", columns, path)?;
    let axis = EntryAxis::Frequency(FrequencyAxis {
        start_hz,
        step_hz,
        len: columns.rows,
    });
    let base = entry(
        FunctionType::Frf,
        axis,
        SampleFormat::ComplexF64,
        columns.lines[0],
    );
    let (mut entries, mut blocks) = (Vec::new(), Vec::new());
    for (index, column) in spec.columns.iter().enumerate() {
        let ColumnRole::Real { dof, unit } = &column.role else {
            continue;
        };
        let imaginary = imaginary_of(spec, dof, unit, path)?;
        let parts = columns.values[index].iter().zip(&columns.values[imaginary]);
        let factors = (column.scale, spec.columns[imaginary].scale);
        blocks.push(Block::Complex(
            parts
                .map(|(re, im)| Complex64::new(factors.0 * re, factors.1 * im))
                .collect(),
        ));
        entries.push(Entry {
            response: dof.clone(),
            quantity: Some(unit.kind.response_quantity()),
            denominator: Some(Quantity::Force),
            to_si: Some(unit.to_si),
            unit_label: format!("{} x {}", unit.to_si, unit.kind.si_unit()),
            ..base.clone()
        });
    }
    Ok((entries, blocks))
}

fn imaginary_of(
    spec: &TableSpec,
    wanted: &Option<Dof>,
    kind: &FrfUnit,
    path: &str,
) -> Result<usize, IoError> {
    let fits = |role: &ColumnRole| matches!(role, ColumnRole::Imaginary { dof, unit } if dof == wanted && unit == kind);
    spec.columns
        .iter()
        .position(|column| fits(&column.role))
        .ok_or_else(|| IoError::NotStated {
            path: path.to_owned(),
            what: "the imaginary part of an FRF".to_owned(),
            expected:
                "a column with role = \"imaginary\" and the same dof and unit as the real part"
                    .to_owned(),
        })
}
