//! A scene drafted from exported files: their headers fill in what they state, and the draft marks
//! the lines that the user has to fill in.

use crate::printable::counted;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use crate::axis::Band;
use crate::dof::Dof;
use crate::geometry::{Geometry, Node};
use crate::io::{Catalog, Entry, EntryAxis, FunctionType};
use crate::quantity::{Quantity, is_uncalibrated_response};

use super::draft_columns::{TableContent, arrays_text, has_same_columns};
use super::draft_file::{Content, DraftFile, StatedUnits, file_text, unit_line};
use super::draft_unused::{UnusedStatement, unused_statements};
use super::model_draft::PointLine;
use super::toml_text::{FILL_IN, quoted};
use super::typed::SCENE_SCHEMA;

/// Statements of the user in addition to the files.
#[derive(Clone, Copy, Debug, Default)]
pub struct DraftPlan<'a> {
    /// Title of the scene.
    pub title: &'a str,
    /// Points in addition to those of the files.
    pub geometry: Option<&'a Geometry>,
    /// The model.
    pub model: Option<&'a DraftModel>,
    /// Band in which modes are searched.
    pub band: Option<Band>,
}

/// The model of a drafted scene.
#[derive(Clone, Debug)]
pub struct DraftModel {
    /// `name = "..."` or `file = "..."`.
    pub line: String,
    /// Its bodies.
    pub bodies: Vec<String>,
    /// Whether its file says where the sensors are.
    pub has_sensors: bool,
    /// Whether it is a drafted beam, which runs along the points of the test.
    pub is_drafted_beam: bool,
}

/// A drafted scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Draft {
    /// Text of `scene.toml`.
    pub scene: String,
    /// Lines of it that have to be filled in.
    pub open_lines: usize,
    /// Points of sensors and hits that have no position although others have one.
    pub points_without_position: Vec<String>,
    /// The line of the points, for the model of a beam.
    pub line: Option<PointLine>,
    /// Statements of the user that it does not use.
    pub unused: Vec<UnusedStatement>,
}

/// Drafts the `scene.toml` of files that were exported together: recordings are one test, FRFs one,
/// finished modes one for each file, tables of the same columns one.
pub fn draft_scene(files: &[DraftFile], plan: &DraftPlan) -> Draft {
    let mut text = format!(
        "# Drafted by `modalign new` from the headers of exported files. A line with \"{FILL_IN}\" is what they do not state:\n\
         # `run` stops at the first one and says what belongs there. Lines behind # are what may be added.\n\
         schema = \"{SCENE_SCHEMA}\"\n\
         title = {}\n",
        quoted(plan.title)
    );
    let mut dofs = BTreeSet::new();
    for (index, group) in group_files(files).iter().enumerate() {
        let (content, files) = group;
        text += &test_text(*content, files, index, plan.band, &mut dofs);
    }
    let unused = unused_statements(&text, files);
    let mut geometry = plan.geometry.cloned().unwrap_or_default();
    files
        .iter()
        .for_each(|file| geometry.add(&file.catalog.geometry));
    let line = PointLine::of(&dofs, &geometry);
    text += &model_text(plan.model, line.as_ref());
    text += &sensors_text(&dofs, &geometry, plan);
    let has_hits = files
        .iter()
        .any(|file| match TableContent::of(file.catalog) {
            Some(table) => !table.is_functions,
            None => Content::of(file.catalog) == Content::Records,
        });
    text += if has_hits { HIT_TABLES } else { "" };
    text += OPTIONAL_TABLES;
    let is_open = |line: &&str| !line.starts_with('#') && line.contains(FILL_IN);
    let open_lines = text.lines().filter(is_open).count();
    let points: BTreeSet<&str> = dofs.iter().map(Dof::point).collect();
    let without_position = points
        .into_iter()
        .filter(|point| geometry.node(point).is_none());
    Draft {
        scene: text,
        open_lines,
        line,
        unused,
        points_without_position: match plan.model {
            _ if geometry.nodes.is_empty() => Vec::new(),
            Some(model) if model.has_sensors => Vec::new(),
            _ => without_position.map(str::to_owned).collect(),
        },
    }
}

/// Files that make one test, in the order of their first one.
fn group_files<'a>(files: &'a [DraftFile<'a>]) -> Vec<(Content, Vec<&'a DraftFile<'a>>)> {
    let mut groups: Vec<(Content, Vec<&DraftFile>)> = Vec::new();
    for file in files {
        let content = Content::of(file.catalog);
        let joins = |(kind, first): &(Content, Vec<&DraftFile>)| {
            let alike = || has_same_columns(first[0].catalog, file.catalog);
            *kind == content && content != Content::Modes && (content != Content::Arrays || alike())
        };
        match groups.iter_mut().find(|group| joins(group)) {
            Some((_, files)) => files.push(file),
            None => groups.push((content, vec![file])),
        }
    }
    groups
}

fn test_text(
    content: Content,
    files: &[&DraftFile],
    index: usize,
    band: Option<Band>,
    dofs: &mut BTreeSet<Dof>,
) -> String {
    let band = match band {
        Some(band) => format!("band_hz = [{:?}, {:?}]\n", band.lo_hz, band.hi_hz),
        None => {
            "# band_hz = [20.0, 400.0]   # search this band; all that was measured when left out\n"
                .to_owned()
        }
    };
    let number = match index {
        0 => String::new(),
        index => format!(" {}", index + 1),
    };
    let partial = match files.iter().any(|file| file.partial) {
        true => "partial = true   # part of a file is damaged: its good part is used\n",
        false => "",
    };
    let head = |name: &str| {
        format!(
            "\n[[test]]\nname = \"{name}{number}\"\n{}{partial}{band}",
            files_line(files)
        )
    };
    match content {
        Content::Records => head("hammer test") + &records_text(files, dofs),
        Content::Functions => head("FRFs") + &functions_text(files, dofs),
        Content::Arrays => head("hammer test") + &arrays_text(files, dofs),
        Content::Modes => {
            let shapes = files[0].catalog.modes.iter().map(|entry| &entry.mode.shape);
            dofs.extend(shapes.flat_map(|shape| shape.iter().map(|(dof, _)| dof.positive())));
            let count = files[0].catalog.modes.len();
            let path = quoted(files[0].path);
            format!(
                "\n[[test]]\nname = \"modes{number}\"\nmodes = {path}   # {count} finished modes\n{partial}{band}"
            )
        }
        Content::Nothing => {
            let paths: Vec<&str> = files.iter().map(|file| file.path).collect();
            format!(
                "\n# Neither records nor functions nor modes: {}\n",
                paths.join(", ")
            )
        }
    }
}

fn files_line(files: &[&DraftFile]) -> String {
    let paths: Vec<String> = files.iter().map(|file| quoted(file.path)).collect();
    match paths.as_slice() {
        [only] => format!("files = [{only}]\n"),
        all => format!("files = [\n    {},\n]\n", all.join(",\n    ")),
    }
}

/// What the headers say of recorded hits, and the records whose unit, point or hit point they leave
/// open.
fn records_text(files: &[&DraftFile], dofs: &mut BTreeSet<Dof>) -> String {
    let times = || entries_of_type(files, FunctionType::Time);
    let forces = times()
        .filter(|entry| entry.quantity == Some(Quantity::Force))
        .count();
    let mut text = format!(
        "# The headers state: {} time records, {forces} of them forces",
        times().count()
    );
    if let Some(entry) = times().next() {
        text += &axis_text(entry);
    }
    text.push('\n');
    dofs.extend(
        times()
            .filter_map(|entry| entry.response.as_ref())
            .map(Dof::positive),
    );
    dofs.extend(
        times()
            .filter_map(|entry| entry.reference.as_ref())
            .map(Dof::positive),
    );
    text +=
        "# hits = \"files\"           # each file is one hit; \"trigger\": continuous records\n";
    for (number, what) in open_records(files, dofs) {
        let _ = write!(
            text,
            "[[test.channel]]\ncolumn = {number}   # number of the record within its hit\n{what}"
        );
    }
    for file in files.iter().filter(|file| lacks_hit_point(file.catalog)) {
        text += &file_text(file, false, true, dofs);
    }
    text
}

/// Missing statements of records, by their number within their hit.
fn open_records(files: &[&DraftFile], dofs: &mut BTreeSet<Dof>) -> BTreeMap<usize, String> {
    let mut open = BTreeMap::new();
    for file in files {
        let mut hits: BTreeMap<(i64, i64), Vec<&Entry>> = BTreeMap::new();
        for entry in entries_of_type(std::slice::from_ref(file), FunctionType::Time) {
            let id = &entry.identification;
            let hit = hits.entry((id.version, id.load_case)).or_default();
            hit.push(entry);
        }
        for hit in hits.values() {
            let stated = file.response().filter(|_| has_one_unnamed(hit));
            for (number, entry) in (1..).zip(hit) {
                let lines = record_text(entry, stated, file.units);
                if !lines.is_empty() {
                    open.entry(number).or_insert(lines);
                }
            }
            dofs.extend(stated.map(Dof::positive));
        }
    }
    open
}

/// Whether a record is, or may be, a response and names no sensor.
fn is_unnamed(entry: &Entry) -> bool {
    entry.response.is_none() && entry.quantity != Some(Quantity::Force)
}

/// Whether one record of a hit alone is a response that names no sensor; one without a unit is a
/// response where another record is the force.
fn has_one_unnamed(hit: &[&Entry]) -> bool {
    let has_force = hit
        .iter()
        .any(|entry| entry.quantity == Some(Quantity::Force));
    let mut unnamed = hit.iter().filter(|entry| is_unnamed(entry));
    match (unnamed.next(), unnamed.next()) {
        (Some(only), None) => has_force || only.quantity.is_some(),
        _ => false,
    }
}

/// The lines of a record in its hit: unit and sensor, where they are open.
fn record_text(entry: &Entry, stated: Option<&Dof>, units: StatedUnits<'_>) -> String {
    let mut lines = String::new();
    if entry.quantity.is_none() || entry.to_si.is_none() {
        let label = entry.unit_label.as_str();
        let accepted =
            format!("N for the force, m/s2, g, m/s or m for a response; the header says {label:?}");
        // A record without a quantity may be the force as well.
        let unit = units
            .response
            .filter(|_| entry.response.is_some() && entry.reference.is_some());
        lines += &unit_line(unit, &accepted);
    }
    if is_unnamed(entry) {
        let _ = match stated {
            Some(dof) => writeln!(lines, "dof = \"{dof}\""),
            None => writeln!(
                lines,
                "dof = \"{FILL_IN}\"   # point and direction of this sensor (or of the hit), such as 1:+Z"
            ),
        };
    }
    lines
}

/// Whether a file with a force names no hit point: neither its force record nor a reference of the
/// responses.
fn lacks_hit_point(catalog: &Catalog) -> bool {
    let is_force = |entry: &&Entry| entry.quantity == Some(Quantity::Force);
    let mut forces = catalog.entries.iter().filter(is_force);
    let mut responses = catalog.entries.iter().filter(|entry| !is_force(entry));
    forces.any(|entry| entry.response.is_none()) && responses.any(|entry| entry.reference.is_none())
}

/// Statements of the headers on FRFs, and the units and points that they do not state.
fn functions_text(files: &[&DraftFile], dofs: &mut BTreeSet<Dof>) -> String {
    let frfs = || entries_of_type(files, FunctionType::Frf);
    let mut text = format!("# The headers state: {}", counted(frfs().count(), "FRF"));
    if let Some(entry) = frfs().next() {
        text += &axis_text(entry);
    }
    text.push('\n');
    let pairs = files.iter().flat_map(|file| pairs_of(file));
    let points = pairs.flat_map(|(response, reference)| [response, reference]);
    dofs.extend(points.flatten().map(|dof| dof.positive()));
    let averaged = frfs().any(|entry| entry.note.averages.is_some());
    if entries_of_type(files, FunctionType::Coherence)
        .next()
        .is_some()
        && !averaged
    {
        text += "# averages = 3              # hits behind each coherence, which the files do not state; 3 is assumed without it\n";
    }
    let unknown = |entry: &Entry| {
        entry.quantity.is_none() || entry.denominator.is_none() || entry.to_si.is_none()
    };
    let (uncalibrated, others): (Vec<&DraftFile>, Vec<&DraftFile>) =
        files.iter().partition(|file| is_uncalibrated(file.catalog));
    let entry = entries_of_type(&others, FunctionType::Frf).find(|entry| unknown(entry));
    if let Some(entry) = entry {
        let label = entry.unit_label.as_str();
        let accepted = format!(
            "of the FRFs that state none: (m/s2)/N, (m/s)/N or m/N; the header says {label:?}"
        );
        text += "[[test.channel]]\ncolumn = 1\n";
        text += &unit_line(files[0].units.frf, &accepted);
    }
    text += &uncalibrated_text(&uncalibrated);
    for file in files {
        let of_file = || entries_of_type(std::slice::from_ref(file), FunctionType::Frf);
        let response = of_file().any(|frf| {
            frf.response.is_none() || frf.response_is_channel && file.response().is_some()
        });
        let is_stated = file.reference.is_some() || has_pair_of_another(file, files);
        let reference =
            of_file().any(|frf| frf.reference.is_none() || frf.reference_is_channel && is_stated);
        if response || reference {
            text += &file_text(file, response, reference, dofs);
        }
    }
    text
}

/// Whether all FRFs of a file are voltages over force.
fn is_uncalibrated(catalog: &Catalog) -> bool {
    let entries = catalog.entries.iter();
    let mut frfs = entries.filter(|entry| entry.function_type == FunctionType::Frf);
    frfs.all(|entry| is_uncalibrated_response(&entry.unit_label))
}

/// The unit of FRFs without calibration, for each of their responses: a unit without a response is
/// not used for FRFs that state another quantity.
fn uncalibrated_text(files: &[&DraftFile]) -> String {
    let pairs = files.iter().flat_map(|file| pairs_of(file));
    let responses: BTreeSet<Option<Dof>> = pairs
        .map(|(response, _)| response.map(|dof| dof.positive()))
        .collect();
    let mut text = String::new();
    for (number, response) in (1..).zip(&responses) {
        let dof = match response {
            Some(dof) => dof.to_string(),
            None => FILL_IN.to_owned(),
        };
        let _ = write!(
            text,
            "[[test.channel]]\ncolumn = {number}\ndof = \"{dof}\"   # a response of the {} without calibration (V/N)\n",
            counted(files.len(), "file")
        );
        text += &unit_line(files[0].units.frf, "of the FRFs: (m/s2)/N, (m/s)/N or m/N");
        text += "# scale = 1.0   # the calibration of this sensor, such as 98.1 (m/s2)/V\n";
    }
    text
}

/// Response and reference of each FRF of a file, with the stated points.
fn pairs_of(file: &DraftFile) -> Vec<(Option<Dof>, Option<Dof>)> {
    let entries = file.catalog.entries.iter();
    let frfs = entries.filter(|entry| entry.function_type == FunctionType::Frf);
    let pair = |frf: &Entry| {
        let response = frf.response_point(file.response());
        (response, frf.reference_point(file.reference))
    };
    frfs.map(pair).collect()
}

/// Whether another file has an FRF of the same response and reference.
fn has_pair_of_another(file: &DraftFile, files: &[&DraftFile]) -> bool {
    let pairs = pairs_of(file);
    let mut others = files.iter().filter(|other| !std::ptr::eq(**other, file));
    others.any(|other| pairs_of(other).iter().any(|pair| pairs.contains(pair)))
}

fn model_text(model: Option<&DraftModel>, line: Option<&PointLine>) -> String {
    match model {
        Some(model) => {
            let guess = match line.filter(|_| model.is_drafted_beam) {
                Some(_) => {
                    "   # its length is a guess, the distance of the outermost points: state from_m and to_m there"
                }
                None => "",
            };
            format!("\n[model]\n{}{guess}\n", model.line)
        }
        None => "\n# The model that the test is compared with:\n\
                 # [model]\n\
                 # file = \"model.toml\"      # or a file of finished modes (.json, .csv, .unv)\n\
                 # name = \"cycloid-ball\"    # or a built-in model\n"
            .to_owned(),
    }
}

/// Where sensors and hits are: positions from the geometry of the files; remarks while there is no
/// model that has bodies. Points that the user has stated serve the figures of shapes even then.
fn sensors_text(dofs: &BTreeSet<Dof>, geometry: &Geometry, plan: &DraftPlan) -> String {
    let model = plan.model;
    let needs_sensors = |model: &DraftModel| !model.has_sensors && !model.bodies.is_empty();
    if let (Some(points), false) = (plan.geometry, model.is_some_and(needs_sensors)) {
        return points_text(dofs, points);
    }
    if model.is_some_and(|model| !needs_sensors(model)) {
        return String::new();
    }
    let remark = if model.is_none() { "# " } else { "" };
    let mut text = "\n# Where sensors and hits are, for the model and the figures of shapes: a point of a body in the model's frame, or a `coordinate` of the model.\n".to_owned();
    if dofs.is_empty() {
        text += "# [[sensor]]\n# dof = \"1:+Z\"\n# body = \"\"   # a body of the model\n# at_m = [0.0, 0.0, 0.0]\n";
    }
    for dof in dofs {
        let _ = write!(text, "{remark}[[sensor]]\n{remark}dof = \"{dof}\"\n");
        let body = match model.map(|model| model.bodies.as_slice()) {
            Some([only]) => format!("body = {}", quoted(only)),
            Some(all) => format!("body = \"{FILL_IN}\"   # one of {}", all.join(", ")),
            None => "body = \"\"   # a body of the model".to_owned(),
        };
        let place = match geometry.node(dof.point()) {
            Some(node) => position_line(node),
            None if model.is_some() => {
                format!("at_m = \"{FILL_IN}\"   # {dof}: [x, y, z] in metres, without quotes")
            }
            None => "at_m = [0.0, 0.0, 0.0]".to_owned(),
        };
        let _ = write!(text, "{remark}{body}\n{remark}{place}\n");
    }
    text
}

fn position_line(node: &Node) -> String {
    let [x, y, z] = [0, 1, 2].map(|axis| node.at_m[axis]);
    format!("at_m = [{x:?}, {y:?}, {z:?}]")
}

/// The stated positions of the points, for a scene whose model needs no sensors.
fn points_text(dofs: &BTreeSet<Dof>, points: &Geometry) -> String {
    let mut text = "\n# Where the points are, for the figures of shapes.\n".to_owned();
    let names: BTreeSet<&str> = dofs.iter().map(Dof::point).collect();
    for name in names {
        let _ = match points.node(name) {
            Some(node) => writeln!(
                text,
                "[[point]]\nname = {}\n{}",
                quoted(name),
                position_line(node)
            ),
            None => writeln!(text, "# {name}: the list has no such point"),
        };
    }
    text
}

const HIT_TABLES: &str = "
# [frf]
# force_window_s = 0.02      # hold the force this long after its pulse; its noise counts without it
";

const OPTIONAL_TABLES: &str = "
# [identify]
# method = \"ml\"             # the default; `modalign identify --help` has the others

# [pair]
# max_frequency_error = 0.2  # a fraction: pairs further apart are not considered
# min_mac = 0.5

# What `update` frees: the stiffnesses of the model when left out.
# [update]
# parameters = []
# prior_std = 0.3            # known to 30 % beforehand
# frequency_floor = 0.001    # 0.1 % that no parameter mends

# These decide the exit code of `run`, and of `check`.
# [limits]
# max_frequency_error_percent = 5.0
# min_mac = 0.9
# max_missed = 0
";

fn entries_of_type<'a>(
    files: &'a [&DraftFile<'a>],
    wanted: FunctionType,
) -> impl Iterator<Item = &'a Entry> {
    let entries = files.iter().flat_map(|file| &file.catalog.entries);
    entries.filter(move |entry| entry.function_type == wanted)
}

fn axis_text(entry: &Entry) -> String {
    match entry.axis {
        EntryAxis::Time(axis) => format!(
            ", {} samples at {} Hz each",
            axis.len,
            axis.sampling_rate_hz()
        ),
        EntryAxis::Frequency(axis) => format!(", {} lines by {} Hz each", axis.len, axis.step_hz),
        EntryAxis::General(axis) => format!(", {} values each", axis.len),
    }
}
