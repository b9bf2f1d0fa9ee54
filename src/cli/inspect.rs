//! `modalign inspect`: what is in files, from their headers.

use serde_json::json;

use crate::error::Error;
use crate::io::{Catalog, Entry, EntryAxis, FunctionType, Hints, SampleFormat, open_path};
use crate::report::{Block, Cell, Column, Table};

use super::Outcome;
use super::args::InspectArgs;
use super::output::Output;

/// Lists every file; exit code 1 when part of one is damaged.
pub fn inspect(
    args: &InspectArgs,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    let (mut files, mut damaged) = (Vec::new(), false);
    for path in &args.files {
        let hints = Hints {
            path: path.display().to_string(),
            ..Hints::default()
        };
        let source = open_path(path, &hints, format)?;
        let catalog = source.catalog();
        output.blocks(&blocks(catalog));
        output.findings(&catalog.findings);
        damaged |= !catalog.damage.is_empty();
        files.push(catalog_json(catalog));
    }
    let result = json!({ "schema": "modalign-inspect/1", "files": files });
    output.json(&format!("{result:#}"));
    Ok(Outcome::missed_if(damaged))
}

fn blocks(catalog: &Catalog) -> Vec<Block> {
    let mut blocks = vec![Block::Heading(format!(
        "{} ({})",
        catalog.path, catalog.format
    ))];
    if !catalog.title.is_empty() {
        blocks.push(Block::Text(catalog.title.join(" / ")));
    }
    if !catalog.geometry.nodes.is_empty() {
        let (nodes, lines) = (catalog.geometry.nodes.len(), catalog.geometry.lines.len());
        blocks.push(Block::Text(format!(
            "geometry: {nodes} nodes, {lines} trace lines"
        )));
    }
    if !catalog.entries.is_empty() {
        blocks.push(Block::Table(entry_table(&catalog.entries)));
    }
    for damage in &catalog.damage {
        blocks.push(Block::Text(format!("damaged: {damage}")));
    }
    blocks
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
        caption: format!("{} records and functions", entries.len()),
        columns: std::iter::once(Column::number("no."))
            .chain(heads.map(Column::text))
            .collect(),
        rows: entries.iter().enumerate().map(row).collect(),
        footnotes: Vec::new(),
    }
}

fn type_name(function_type: FunctionType) -> String {
    match function_type {
        FunctionType::Time => "time".to_owned(),
        FunctionType::Frf => "FRF".to_owned(),
        FunctionType::Coherence => "coherence".to_owned(),
        FunctionType::Other(code) => format!("type {code}"),
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
        "entries": catalog.entries.iter().map(entry_json).collect::<Vec<_>>(),
        "damage": catalog.damage.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "findings": catalog.findings,
    })
}

fn entry_json(entry: &Entry) -> serde_json::Value {
    let (domain, start, step) = match entry.axis {
        EntryAxis::Time(axis) => ("time_s", axis.start_s, axis.step_s),
        EntryAxis::Frequency(axis) => ("frequency_hz", axis.start_hz, axis.step_hz),
    };
    json!({
        "function_type": entry.function_type.code(),
        "response": entry.response,
        "reference": entry.reference,
        "quantity": entry.quantity,
        "denominator": entry.denominator,
        "unit": entry.unit_label,
        "to_si": entry.to_si,
        "values": entry.len(),
        "stored": stored_name(entry.format),
        "axis": { "domain": domain, "start": start, "step": step },
        "version": entry.identification.version,
        "load_case": entry.identification.load_case,
        "id_lines": entry.identification.lines,
    })
}
