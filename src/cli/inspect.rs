//! `modalign inspect`: the contents of files, from their headers.

use std::collections::BTreeSet;

use serde_json::json;

use crate::error::Error;
use crate::geometry::Geometry;
use crate::io::{
    ArrayInfo, Catalog, Domain, Entry, EntryAxis, FunctionType, Hints, ModeEntry, SampleFormat,
    open_path,
};
use crate::report::{Block, Cell, Column, Table};

use super::args::InspectArgs;
use super::outcome::Outcome;
use super::output::Output;

/// Lists every file; exit code 1 when part of one is damaged or one of several cannot be read.
/// Numbers written as text are not read, and so not judged.
pub fn inspect(
    args: &InspectArgs,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    let (mut files, mut damaged) = (Vec::new(), false);
    let (mut opened, mut first_error) = (0, None);
    for path in &args.files {
        let hints = Hints {
            path: path.display().to_string(),
            ..Hints::default()
        };
        let source = match open_path(path, &hints, format) {
            Ok(source) => source,
            // An unreadable file does not hide the others.
            Err(error) if args.files.len() > 1 => {
                output.add_blocks(&[Block::Text(format!("not read: {error}"))]);
                files.push(json!({ "path": hints.path, "error": error.to_string() }));
                first_error.get_or_insert(error);
                continue;
            }
            Err(error) => return Err(error.into()),
        };
        opened += 1;
        let catalog = source.catalog();
        output.add_blocks(&blocks(catalog));
        output.add_findings(&catalog.findings);
        damaged |= !catalog.damage.is_empty();
        if output.wants_json() {
            files.push(catalog_json(catalog));
        }
    }
    if let (0, Some(error)) = (opened, first_error.take()) {
        return Err(error.into());
    }
    output.add_json(|| {
        let result = json!({ "schema": "modalign-inspect/1", "files": files });
        format!("{result:#}")
    });
    Ok(Outcome::missed_if(damaged || opened < args.files.len()))
}

fn blocks(catalog: &Catalog) -> Vec<Block> {
    let mut blocks = vec![Block::Heading(format!(
        "{} ({})",
        catalog.path, catalog.format
    ))];
    if !catalog.title.is_empty() {
        blocks.push(Block::Text(catalog.title.join(" / ")));
    }
    blocks.extend(geometry_text(&catalog.geometry).map(Block::Text));
    if !catalog.modes.is_empty() {
        blocks.push(Block::Table(mode_table(&catalog.modes)));
    }
    if !catalog.arrays.is_empty() {
        blocks.push(Block::Table(array_table(&catalog.arrays)));
    }
    if !catalog.entries.is_empty() {
        blocks.push(Block::Table(entry_table(&catalog.entries)));
    }
    for damage in &catalog.damage {
        blocks.push(Block::Text(format!("damaged: {damage}")));
    }
    blocks
}

/// The contents of the geometry, when it has any.
fn geometry_text(geometry: &Geometry) -> Option<String> {
    let counts = [
        (geometry.nodes.len(), "nodes"),
        (geometry.lines.len(), "trace lines"),
        (geometry.elements.len(), "elements"),
        (geometry.systems.len(), "coordinate systems"),
        (geometry.groups.len(), "groups"),
    ];
    let held: Vec<String> = counts
        .iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| format!("{count} {what}"))
        .collect();
    (!held.is_empty()).then(|| format!("geometry: {}", held.join(", ")))
}

fn mode_table(modes: &[ModeEntry]) -> Table {
    let row = |(index, entry): (usize, &ModeEntry)| {
        let mode = &entry.mode;
        let points: BTreeSet<&str> = mode.shape.iter().map(|(dof, _)| dof.point()).collect();
        let number = |value: Option<f64>| {
            value.map_or(Cell::Missing, |value| Cell::text(round(value).to_string()))
        };
        vec![
            Cell::text((index + 1).to_string()),
            number(Some(mode.frequency_hz)),
            number(mode.damping_ratio.map(|ratio| 100.0 * ratio)),
            number(mode.modal_mass_kg),
            Cell::text(points.len().to_string()),
            Cell::text(mode.shape.len().to_string()),
            Cell::text(entry.title.first().cloned().unwrap_or_default()),
        ]
    };
    Table {
        caption: format!("{} modes", modes.len()),
        columns: vec![
            Column::number("no."),
            Column::number("frequency [Hz]"),
            Column::number("damping [%]"),
            Column::number("modal mass [kg]"),
            Column::number("points"),
            Column::number("values"),
            Column::text("title"),
        ],
        rows: modes.iter().enumerate().map(row).collect(),
        footnotes: Vec::new(),
    }
}

fn array_table(arrays: &[ArrayInfo]) -> Table {
    let row = |(index, array): (usize, &ArrayInfo)| {
        let lengths: Vec<String> = array.shape.iter().map(ToString::to_string).collect();
        vec![
            Cell::text((index + 1).to_string()),
            Cell::text(array.name.clone()),
            Cell::text(lengths.join(" x ")),
            Cell::text(array.kind.clone()),
        ]
    };
    Table {
        caption: format!("{} arrays", arrays.len()),
        columns: vec![
            Column::number("no."),
            Column::text("name"),
            Column::text("shape"),
            Column::text("kind"),
        ],
        rows: arrays.iter().enumerate().map(row).collect(),
        footnotes: Vec::new(),
    }
}

fn entry_table(entries: &[Entry]) -> Table {
    let heads = [
        "type",
        "response",
        "reference",
        "quantity",
        "unit",
        "values",
        "stored",
        "axis",
        "version",
        "load case",
    ];
    let row = |(index, entry): (usize, &Entry)| {
        let text = |value: Option<String>| value.map_or(Cell::Missing, Cell::Text);
        let mut cells = vec![
            Cell::text((index + 1).to_string()),
            Cell::text(type_name(entry.function_type)),
        ];
        cells.push(text(entry.response.as_ref().map(ToString::to_string)));
        cells.push(text(entry.reference.as_ref().map(ToString::to_string)));
        cells.push(text(entry.quantity.map(|q| q.to_string())));
        cells.push(text(
            Some(entry.unit_label.clone()).filter(|label| !label.is_empty()),
        ));
        cells.push(Cell::text(entry.len().to_string()));
        cells.push(Cell::text(stored_name(entry.format)));
        cells.push(Cell::text(axis_text(entry.axis)));
        cells.push(Cell::text(entry.identification.version.to_string()));
        cells.push(Cell::text(entry.identification.load_case.to_string()));
        cells
    };
    Table {
        caption: format!("Records and functions: {}", entries.len()),
        columns: std::iter::once(Column::number("no."))
            .chain(heads.map(Column::text))
            .collect(),
        rows: entries.iter().enumerate().map(row).collect(),
        footnotes: Vec::new(),
    }
}

fn type_name(function_type: FunctionType) -> String {
    match function_type {
        FunctionType::Frf => "FRF".to_owned(),
        other => other.name().replace('-', " "),
    }
}

fn stored_name(format: SampleFormat) -> &'static str {
    match format {
        SampleFormat::RealF32 => "f32",
        SampleFormat::RealF64 => "f64",
        SampleFormat::ComplexF32 => "complex f32",
        SampleFormat::ComplexF64 => "complex f64",
    }
}

fn axis_text(axis: EntryAxis) -> String {
    match axis {
        EntryAxis::Time(axis) => format!(
            "{:.6} s at {} Hz",
            axis.duration_s(),
            round(axis.sampling_rate_hz())
        ),
        EntryAxis::Frequency(axis) => format!(
            "{} to {} Hz by {}",
            round(axis.start_hz),
            round(axis.hz(axis.len.saturating_sub(1))),
            round(axis.step_hz)
        ),
        EntryAxis::General(axis) => match axis.even {
            Some((start, step)) => format!("from {} by {}", round(start), round(step)),
            None => "uneven".to_owned(),
        },
    }
}

/// Nine significant digits, without trailing zeros.
fn round(value: f64) -> f64 {
    format!("{value:.8e}").parse().unwrap_or(value)
}

fn catalog_json(catalog: &Catalog) -> serde_json::Value {
    json!({
        "path": catalog.path,
        "format": catalog.format,
        "title": catalog.title,
        "nodes": catalog.geometry.nodes.len(),
        "trace_lines": catalog.geometry.lines.len(),
        "elements": catalog.geometry.elements.len(),
        "coordinate_systems": catalog.geometry.systems.len(),
        "groups": catalog.geometry.groups.len(),
        "modes": catalog.modes.iter().map(mode_json).collect::<Vec<_>>(),
        "arrays": catalog.arrays.iter().map(array_json).collect::<Vec<_>>(),
        "entries": catalog.entries.iter().map(entry_json).collect::<Vec<_>>(),
        "damage": catalog.damage.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "findings": catalog.findings,
    })
}

fn mode_json(entry: &ModeEntry) -> serde_json::Value {
    let mode = &entry.mode;
    let parts = |value: num_complex::Complex64| [value.re, value.im];
    json!({
        "frequency_hz": mode.frequency_hz,
        "damping_ratio": mode.damping_ratio,
        "pole_rad_s": mode.pole().map(|pole| parts(pole.lambda)),
        "modal_mass_kg": mode.modal_mass_kg,
        "modal_a": entry.modal_a.map(parts),
        "modal_b": entry.modal_b.map(parts),
        "values": mode.shape.len(),
        "title": entry.title,
    })
}

fn array_json(array: &ArrayInfo) -> serde_json::Value {
    json!({ "name": array.name, "shape": array.shape, "kind": array.kind })
}

fn entry_json(entry: &Entry) -> serde_json::Value {
    let domain = match entry.axis.domain() {
        Domain::Time => "time_s".to_owned(),
        Domain::Frequency => "frequency_hz".to_owned(),
        Domain::Other(code) => format!("data-type-{code}"),
    };
    let (start, step) = entry.axis.even().unzip();
    json!({
        "function_type": entry.function_type.code(),
        "function": entry.function_type.name(),
        "response": entry.response,
        "reference": entry.reference,
        "quantity": entry.quantity,
        "denominator": entry.denominator,
        "unit": entry.unit_label,
        "to_si": entry.to_si,
        "values": entry.len(),
        "stored": stored_name(entry.format),
        "axis": { "domain": domain, "start": start, "step": step },
        "averages": entry.note.averages,
        "version": entry.identification.version,
        "load_case": entry.identification.load_case,
        "id_lines": entry.identification.lines,
    })
}
