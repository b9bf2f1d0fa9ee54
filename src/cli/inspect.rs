//! `modalign inspect`: the contents of files, from their headers.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::json;

use crate::dof::Dof;
use crate::error::Error;
use crate::geometry::Geometry;
use crate::io::{
    ArrayInfo, Catalog, Domain, Entry, EntryAxis, FunctionType, Hints, ModeEntry, SampleFormat,
    open_path,
};
use crate::printable::counted;
use crate::report::{Block, Cell, Column, Renderer, Table, Terminal, abridged};
use crate::scene::{ColumnHeading, ColumnHeadings, column_headings};

use super::args::InspectArgs;
use super::left_out::{LeftOut, Reason};
use super::outcome::Outcome;
use super::output::Output;

/// Lists every file; exit code 1 when part of one is damaged or one of several cannot be read. A
/// file that holds no data of a test is named beside others.
/// Numbers written as text are not read, and so not judged.
pub fn inspect(
    args: &InspectArgs,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    let (mut files, mut damaged) = (Vec::new(), false);
    let (mut catalogs, mut left_out) = (Vec::new(), Vec::new());
    let mut read: Vec<&Path> = Vec::new();
    for path in &args.files {
        let hints = Hints {
            path: path.display().to_string(),
            ..Hints::default()
        };
        let mut source = match open_path(path, &hints, format) {
            Ok(source) => source,
            // An unreadable file does not hide the others.
            Err(error) if args.files.len() > 1 => {
                let reason = Reason::Error(error);
                let file = LeftOut { path, reason };
                files.push(file.json());
                left_out.push(file);
                continue;
            }
            Err(error) => return Err(error.into()),
        };
        let catalog = std::mem::take(source.catalog_mut());
        damaged |= !catalog.damage.is_empty();
        if output.wants_json() {
            files.push(catalog_json(&catalog));
        }
        catalogs.push(catalog);
        read.push(path);
    }
    let is_complete = !left_out.iter().any(|file| file.may_hold_data(&read));
    let listed = match output.wants_all() {
        true => left_out.len(),
        false => left_out.len().min(MAX_SCREEN_LEFT_OUT),
    };
    let further = left_out.len() - listed;
    let lines = left_out.iter().take(listed).map(|file| file.text(&read));
    let further =
        (further > 0).then(|| format!("{} not used: --full.", counted(further, "further file")));
    output.add_blocks(lines.chain(further).map(Block::Text).collect());
    let first = left_out.into_iter().next().map(|file| file.reason);
    if let (true, Some(Reason::Error(error))) = (catalogs.is_empty(), first) {
        return Err(error.into());
    }
    let groups = alike(&catalogs);
    let full = || catalogs.iter().flat_map(blocks).collect();
    output.add_result(|width| screen_of_all(&groups, width), full);
    for catalog in groups.iter().flatten() {
        output.add_findings(&catalog.findings);
    }
    if let Some(note) = next_step(&catalogs) {
        output.add_closing(vec![note], None);
    }
    output.add_json(|| {
        let result = json!({ "schema": "modalign-inspect/1", "files": files });
        format!("{result:#}")
    });
    Ok(Outcome::missed_if(damaged || !is_complete))
}

/// Catalogs in their order, those together that the screen shows alike: files without damage whose
/// records and functions differ in their points alone, or whose arrays are the same. Titles and the
/// name of an only array are those of one file.
fn alike(catalogs: &[Catalog]) -> Vec<Vec<&Catalog>> {
    let contents = |catalog: &Catalog| {
        let kinds: BTreeSet<_> = catalog.entries.iter().map(kind).collect();
        let array = |array: &ArrayInfo| {
            let name = match catalog.arrays.len() {
                1 => String::new(),
                _ => array.name.clone(),
            };
            (name, array.shape.clone(), array.kind.clone())
        };
        let arrays: Vec<_> = catalog.arrays.iter().map(array).collect();
        let nodes = geometry_text(&catalog.geometry);
        (catalog.format, nodes, kinds, arrays)
    };
    let mut groups: Vec<(_, Vec<&Catalog>)> = Vec::new();
    for catalog in catalogs {
        let held = contents(catalog);
        let is_whole = |catalog: &Catalog| catalog.modes.is_empty() && catalog.damage.is_empty();
        let joins = |group: &[&Catalog]| is_whole(catalog) && is_whole(group[0]);
        match groups
            .iter_mut()
            .find(|(other, group)| joins(group) && *other == held)
        {
            Some((_, group)) => group.push(catalog),
            None => groups.push((held, vec![catalog])),
        }
    }
    groups.into_iter().map(|(_, group)| group).collect()
}

/// What a row of the screen's table states beside the points: type, quantity, unit and axis.
fn kind(entry: &Entry) -> (String, String, String, String) {
    (
        type_name(entry.function_type),
        entry.quantity.map_or(String::new(), |q| q.to_string()),
        entry.unit_label.clone(),
        axis_text(entry.axis),
    )
}

/// What the files do not state, and the command that takes them further.
fn next_step(catalogs: &[Catalog]) -> Option<String> {
    let entries = || catalogs.iter().flat_map(|catalog| &catalog.entries);
    let is_frf = |entry: &&Entry| entry.function_type == FunctionType::Frf;
    let is_record = |entry: &&Entry| entry.function_type == FunctionType::Time;
    let is_test = |entry: &&Entry| is_frf(entry) || is_record(entry);
    let holds_arrays = |file: &Catalog| !file.arrays.is_empty() && file.entries.is_empty();
    let arrays = catalogs.iter().any(holds_arrays);
    if !arrays && !entries().any(|entry| is_test(&entry)) {
        let has_modes = catalogs.iter().any(|catalog| !catalog.modes.is_empty());
        return has_modes.then(|| {
            "Next: modalign correlate --test FILE --theory MODEL, or modalign new DIR FILE..."
                .to_owned()
        });
    }
    let of_arrays = catalogs.iter().filter(|file| holds_arrays(file));
    let columns: Vec<Option<ColumnHeading>> =
        of_arrays.flat_map(column_headings).flatten().collect();
    let unnamed = columns.iter().filter(|column| column.is_none()).count();
    let has = |roles: &[&str]| {
        let mut known = columns.iter().flatten();
        unnamed > 0 || known.any(|column| roles.contains(&column.role))
    };
    let has_frf_column = columns
        .iter()
        .flatten()
        .any(|column| FRF_ROLES.contains(&column.role));
    let mut options = Vec::new();
    let mut missing = |what: &'static str, option: &'static str, is_missing: bool| {
        if is_missing {
            options.push((what, option));
        }
    };
    missing(
        "the response of functions or records",
        "--response DOF",
        has(&["response"])
            || has_frf_column
            || entries().any(|entry| is_test(&entry) && entry.response.is_none()),
    );
    missing(
        "the reference of FRFs",
        "--reference DOF",
        unnamed > 0
            || has_frf_column
            || entries().any(|entry| is_frf(&entry) && entry.reference.is_none()),
    );
    missing(
        "the excitation point",
        "--reference DOF",
        has(&["force"]) && !has_frf_column && unnamed == 0,
    );
    let lacks_unit =
        |column: &Option<ColumnHeading>| column.as_ref().is_none_or(|c| c.lacks_unit());
    missing(
        "units",
        "--unit UNIT",
        columns.iter().any(lacks_unit)
            || entries().any(|entry| is_test(&entry) && entry.unit_label.is_empty()),
    );
    missing(
        "the sampling rate",
        "--sampling-rate HZ",
        arrays && !has_frf_column && !columns.iter().flatten().any(|column| column.is_axis()),
    );
    let mut text = String::new();
    if unnamed > 0 {
        text += &format!(
            "The names of {} do not state the contents: state `role` in the scene.\n",
            counted(unnamed, "column")
        );
    }
    let (names, flags): (Vec<&str>, Vec<&str>) = options.into_iter().unzip();
    if !names.is_empty() {
        text += &format!("Not stated: {}.\n", names.join(", "));
    }
    let mut given = BTreeSet::new();
    let flags = flags.into_iter().filter(|flag| given.insert(*flag));
    let flags: String = flags.map(|flag| format!(" {flag}")).collect();
    text += &channels_text(entries().filter(is_test));
    if flags.contains(" DOF") {
        text += "DOF: point and direction, such as 1:+Z";
        text += match catalogs.len() {
            1 => ".\n",
            _ => "; one for all files, or one for each (1:+Z,2:+Z).\n",
        };
    }
    Some(text + &format!("Next: modalign new DIR FILE...{flags}"))
}

/// Roles of columns that hold FRFs.
const FRF_ROLES: [&str; 4] = ["real", "imaginary", "complex", "magnitude"];

/// The channels that stand in the place of points, and the options that name the points.
fn channels_text<'e>(entries: impl Iterator<Item = &'e Entry>) -> String {
    let (mut responses, mut references) = (BTreeSet::new(), BTreeSet::new());
    for entry in entries {
        responses.extend(
            entry
                .response
                .as_ref()
                .filter(|_| entry.response_is_channel),
        );
        references.extend(
            entry
                .reference
                .as_ref()
                .filter(|_| entry.reference_is_channel),
        );
    }
    let text = |what: &str, channels: &BTreeSet<&Dof>, option: &str| {
        let names = dofs_text(channels.iter().copied());
        match channels.len() {
            0 => String::new(),
            1 => format!("A channel, no point: the {what} {names} ({option} names the point).\n"),
            // An option of `new` replaces one channel of a file.
            _ => format!("Channels, no points: the {what}s {names}.\n"),
        }
    };
    text("response", &responses, "--response DOF")
        + &text("reference", &references, "--reference DOF")
}

fn blocks(catalog: &Catalog) -> Vec<Block> {
    let mut blocks = head_blocks(catalog);
    if !catalog.entries.is_empty() {
        blocks.push(Block::Table(entry_table(&catalog.entries)));
    }
    blocks.extend(array_blocks(catalog));
    for damage in &catalog.damage {
        blocks.push(Block::Text(format!("damaged: {damage}")));
    }
    blocks
}

/// The blocks before records, functions, arrays and damage.
fn head_blocks(catalog: &Catalog) -> Vec<Block> {
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
    blocks
}

/// The arrays of a catalogue, behind its records and functions.
fn array_blocks(catalog: &Catalog) -> Option<Block> {
    (!catalog.arrays.is_empty()).then(|| Block::Table(array_table(catalog)))
}

/// Maximum number of damaged parts on the screen.
const MAX_SCREEN_DAMAGE: usize = 5;

/// Lines of the screen without the files that are not used and the next step.
const MAX_SCREEN_LINES: usize = 24;
/// Maximum number of files that are not used and have a line on the screen.
const MAX_SCREEN_LEFT_OUT: usize = 2;
/// Maximum number of kinds of files in a table of all.
const MAX_SCREEN_KINDS: usize = 16;

/// All files, those alike together; where they have no room, in a table with a row for each kind.
fn screen_of_all(groups: &[Vec<&Catalog>], width: usize) -> Vec<Block> {
    let all: Vec<Block> = groups
        .iter()
        .flat_map(|group| screen(group, width))
        .collect();
    let terminal = Terminal { width: Some(width) };
    let fits = |blocks: &Vec<Block>| terminal.render(blocks).lines().count() <= MAX_SCREEN_LINES;
    if groups.len() < 2 || fits(&all) {
        return all;
    }
    let table = |kinds| abridged(vec![Block::Table(files_table(groups, kinds))], width);
    let tables = (1..=MAX_SCREEN_KINDS).rev().map(table);
    tables.into_iter().find(fits).unwrap_or_else(|| table(1))
}

/// A row for each kind of files, of as many kinds.
fn files_table(groups: &[Vec<&Catalog>], kinds: usize) -> Table {
    let row = |group: &Vec<&Catalog>| {
        let name = |catalog: &Catalog| {
            let name = Path::new(&catalog.path).file_name().unwrap_or_default();
            name.to_string_lossy().into_owned()
        };
        let names = match group.as_slice() {
            [first, .., last] => format!("{} to {}", name(first), name(last)),
            _ => name(group[0]),
        };
        vec![
            Cell::text(group.len().to_string()),
            Cell::text(names),
            Cell::text(group[0].format),
            Cell::text(contents_text(group)),
        ]
    };
    let further: usize = groups.iter().skip(kinds).map(Vec::len).sum();
    let further = (further > 0).then(|| format!("{}: --full.", counted(further, "further file")));
    Table {
        caption: counted(groups.iter().map(Vec::len).sum(), "file"),
        columns: vec![
            Column::number("count"),
            Column::text("names"),
            Column::text("format"),
            Column::text("contents"),
        ],
        rows: groups.iter().take(kinds).map(row).collect(),
        footnotes: further.into_iter().collect(),
    }
}

/// The contents of files that are alike, in counts.
fn contents_text(group: &[&Catalog]) -> String {
    let mut types: Vec<(FunctionType, usize)> = Vec::new();
    for entry in group.iter().flat_map(|catalog| &catalog.entries) {
        match types
            .iter_mut()
            .find(|(other, _)| *other == entry.function_type)
        {
            Some((_, count)) => *count += 1,
            None => types.push((entry.function_type, 1)),
        }
    }
    let types = types.iter();
    let mut parts: Vec<String> = types
        .map(|(of, count)| format!("{}: {count}", type_name(*of)))
        .collect();
    let sum = |of: fn(&Catalog) -> usize| group.iter().map(|catalog| of(catalog)).sum::<usize>();
    let others = [
        (sum(|catalog| catalog.modes.len()), "mode"),
        (sum(|catalog| catalog.arrays.len()), "array"),
        (sum(|catalog| catalog.geometry.nodes.len()), "node"),
        (sum(|catalog| catalog.damage.len()), "damaged part"),
    ];
    let others = others.into_iter().filter(|(count, _)| *count > 0);
    parts.extend(others.map(|(count, what)| counted(count, what)));
    parts.join(", ")
}

/// The contents of files that are alike, in counts: records and functions by kind, and the first
/// modes and arrays.
fn screen(group: &[&Catalog], width: usize) -> Vec<Block> {
    let catalog = group[0];
    let mut blocks = head_blocks(catalog);
    if let [first, .., last] = group {
        blocks[0] = Block::Heading(format!(
            "{} files alike, {} to {} ({})",
            group.len(),
            first.path,
            last.path,
            first.format
        ));
        if group.iter().any(|catalog| catalog.title != first.title) {
            let is_title = |block: &Block| *block != Block::Text(first.title.join(" / "));
            blocks.retain(is_title);
        }
    }
    let entries: Vec<&Entry> = group.iter().flat_map(|catalog| &catalog.entries).collect();
    if !entries.is_empty() {
        blocks.push(Block::Table(kind_table(&entries)));
    }
    blocks.extend(array_blocks(catalog));
    let damage = catalog.damage.iter().take(MAX_SCREEN_DAMAGE);
    blocks.extend(damage.map(|damage| Block::Text(format!("damaged: {damage}"))));
    let further = catalog.damage.len().saturating_sub(MAX_SCREEN_DAMAGE);
    if further > 0 {
        blocks.push(Block::Text(format!(
            "{further} further damaged parts: --full."
        )));
    }
    abridged(blocks, width)
}

/// Records and functions that differ in their points alone, in one row: how many, of which points
/// and directions, in which unit and on which axis.
fn kind_table(entries: &[&Entry]) -> Table {
    let mut kinds: Vec<(&Entry, Vec<&Entry>)> = Vec::new();
    for &entry in entries {
        let is_same = |other: &Entry| kind(other) == kind(entry);
        match kinds.iter_mut().find(|(first, _)| is_same(first)) {
            Some((_, all)) => all.push(entry),
            None => kinds.push((entry, vec![entry])),
        }
    }
    let row = |(first, all): &(&Entry, Vec<&Entry>)| {
        let text = |text: String| match text.is_empty() {
            true => Cell::Missing,
            false => Cell::text(text),
        };
        let responses = all.iter().filter_map(|entry| entry.response.as_ref());
        let references = all.iter().filter_map(|entry| entry.reference.as_ref());
        vec![
            Cell::text(all.len().to_string()),
            Cell::text(type_name(first.function_type)),
            text(dofs_text(responses)),
            text(dofs_text(references)),
            text(first.quantity.map_or(String::new(), |q| q.to_string())),
            text(first.unit_label.clone()),
            Cell::text(axis_text(first.axis)),
        ]
    };
    let texts = [
        "type",
        "responses",
        "references",
        "quantity",
        "unit",
        "axis",
    ];
    let columns = std::iter::once(Column::number("count")).chain(texts.map(Column::text));
    Table {
        caption: format!("Records and functions: {}", entries.len()),
        columns: columns.collect(),
        rows: kinds.iter().map(row).collect(),
        footnotes: Vec::new(),
    }
}

/// Maximum number of degrees of freedom that are named, not counted.
const MAX_NAMED_DOFS: usize = 3;

/// A few degrees of freedom by name, many as `64 points, +X +Y +Z`.
fn dofs_text<'d>(dofs: impl Iterator<Item = &'d Dof>) -> String {
    let dofs: BTreeSet<&Dof> = dofs.collect();
    if dofs.len() <= MAX_NAMED_DOFS {
        let names: Vec<String> = dofs.iter().map(ToString::to_string).collect();
        return names.join(" ");
    }
    let points: BTreeSet<&str> = dofs.iter().map(|dof| dof.point()).collect();
    let direction = |dof: &&Dof| {
        let name = dof.to_string();
        name.rsplit_once(':')
            .map_or(String::new(), |(_, direction)| direction.to_owned())
    };
    let directions: BTreeSet<String> = dofs.iter().map(direction).collect();
    let directions: Vec<&str> = directions.iter().map(String::as_str).collect();
    match points.len() {
        1 => format!("1 point, {}", directions.join(" ")),
        count => format!("{count} points, {}", directions.join(" ")),
    }
}

/// The contents of the geometry, when it has any.
fn geometry_text(geometry: &Geometry) -> Option<String> {
    let counts = [
        (geometry.nodes.len(), "node"),
        (geometry.lines.len(), "trace line"),
        (geometry.elements.len(), "element"),
        (geometry.systems.len(), "coordinate system"),
        (geometry.groups.len(), "group"),
    ];
    let held: Vec<String> = counts
        .iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| counted(*count, what))
        .collect();
    (!held.is_empty()).then(|| format!("geometry: {}", held.join(", ")))
}

fn mode_table(modes: &[ModeEntry]) -> Table {
    let row = |(index, entry): (usize, &ModeEntry)| {
        let mode = &entry.mode;
        let points: BTreeSet<&str> = mode.shape.iter().map(|(dof, _)| dof.point()).collect();
        let number = |value: Option<f64>| {
            let text = value.map(|value| round(value).to_string());
            let decimals = text.and_then(|text| Some(text.split_once('.')?.1.len()));
            Cell::number(value, decimals.unwrap_or(0))
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
        caption: counted(modes.len(), "mode"),
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

fn array_table(catalog: &Catalog) -> Table {
    let arrays = &catalog.arrays;
    let headings = column_headings(catalog);
    let row = |((index, array), headings): ((usize, &ArrayInfo), &ColumnHeadings)| {
        let lengths: Vec<String> = array.shape.iter().map(ToString::to_string).collect();
        vec![
            Cell::text((index + 1).to_string()),
            Cell::text(array.name.clone()),
            Cell::text(lengths.join(" x ")),
            Cell::text(array.kind.clone()),
            heading_text(headings).map_or(Cell::Missing, Cell::Text),
        ]
    };
    Table {
        caption: counted(arrays.len(), "array"),
        columns: vec![
            Column::number("no."),
            Column::text("name"),
            Column::text("shape"),
            Column::text("kind"),
            Column::text("by name"),
        ],
        rows: arrays.iter().enumerate().zip(&headings).map(row).collect(),
        footnotes: Vec::new(),
    }
}

/// The roles of an array's columns by its name, and their unit; `None` without any.
fn heading_text(columns: &[Option<ColumnHeading>]) -> Option<String> {
    let mut parts: Vec<String> = Vec::new();
    for column in columns.iter().flatten() {
        let unit = match (&column.unit, column.lacks_unit()) {
            (Some(unit), _) => Some(unit.as_str()),
            (None, true) => Some("unit not stated"),
            (None, false) => None,
        };
        let role = match column.role {
            "time" => "time axis",
            "frequency" => "frequency axis",
            role => role,
        };
        for part in [Some(role), unit].into_iter().flatten() {
            if !parts.iter().any(|known| known == part) {
                parts.push(part.to_owned());
            }
        }
    }
    (!parts.is_empty()).then(|| parts.join(", "))
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
            "{} s at {} Hz",
            round(axis.duration_s()),
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
    let headings = column_headings(catalog);
    let arrays = catalog.arrays.iter().zip(&headings);
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
        "arrays": arrays.map(|(array, headings)| array_json(array, headings)).collect::<Vec<_>>(),
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

fn array_json(array: &ArrayInfo, headings: &[Option<ColumnHeading>]) -> serde_json::Value {
    let column = |column: &Option<ColumnHeading>| {
        column
            .as_ref()
            .map(|column| json!({ "role": column.role, "unit": column.unit }))
    };
    json!({
        "name": array.name,
        "shape": array.shape,
        "kind": array.kind,
        "columns": headings.iter().map(column).collect::<Vec<_>>(),
    })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::FrequencyAxis;

    #[test]
    fn the_next_command_has_each_option_once() {
        let axis = FrequencyAxis {
            start_hz: 0.0,
            step_hz: 1.0,
            len: 8,
        };
        let axis = EntryAxis::Frequency(axis);
        let frf = Entry::new(FunctionType::Frf, axis, SampleFormat::ComplexF64);
        let frfs = Catalog {
            entries: vec![frf],
            ..Catalog::default()
        };
        let array = |name: &str| ArrayInfo {
            name: name.to_owned(),
            shape: vec![8],
            kind: "f64".to_owned(),
        };
        let names = ["time [s]", "force [N]", "acceleration [m/s2]"];
        let table = Catalog {
            arrays: names.map(array).into(),
            ..Catalog::default()
        };
        let text = next_step(&[frfs, table]).unwrap();
        assert!(
            text.contains("the reference of FRFs, the excitation point"),
            "{text}"
        );
        assert_eq!(text.matches("--reference DOF").count(), 1, "{text}");
    }
}
