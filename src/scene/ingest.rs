//! A test's files are opened, checked for damage, and grouped into hits or FRFs.

use std::collections::BTreeSet;
use std::path::Path;

use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::{FrfSet, Window, check_functions, usable_set};
use crate::geometry::{Geometry, Node};
use crate::io::{
    Catalog, ChannelOverride, Entry, FileRecording, FunctionType, Hints, HitFile, HitGrouping,
    IoError, Merged, Need, StatedFrfUnit, check_damage, check_stated_points, format_of, frf_sets,
    group_hits, open_bytes, open_path,
};
use crate::quantity::{FrfUnit, Unit};
use crate::record::{Recording, Role};
use crate::signal::TriggerOptions;

use super::SceneError;
use super::columns::{channel_key, table_spec, window};
use super::draft_columns::TableContent;
use super::error::value_error;
use super::faults::Faults;
use super::file_dofs::dofs_of_files;
use super::modes_file::held;
use super::places::{key_place, located};
use super::test_plan::FilePlan;
use super::toml_text::read_text;
use super::trigger::{cut_hits, is_continuous};
use super::typed::{ChannelTable, ColumnKey, TestTable};

/// Name of the format whose channels the scene describes column by column.
const TABLE_FORMAT: &str = "table";

/// Formats whose channels the scene describes: tables, and files of arrays.
const DESCRIBED_FORMATS: [&str; 6] = [TABLE_FORMAT, "npy", "npz", "matlab4", "matlab5", "hdf5"];

/// Text exports with self-describing headers, unless the scene describes their columns.
const TEXT_EXPORTS: [&str; 2] = ["pulse", "signalcalc"];

/// Roles of columns only; `force` and `response` are roles of records too.
const COLUMN_ROLES: [&str; 8] = [
    "time",
    "frequency",
    "real",
    "imaginary",
    "complex",
    "magnitude",
    "phase",
    "coherence",
];

/// Contents of a test's files.
#[derive(Default)]
pub struct Ingested {
    /// The hits, for recordings; their samples are still in the files.
    pub recording: Option<Box<dyn Recording>>,
    /// FRFs, for files that hold no time records.
    pub frfs: Vec<FrfSet>,
    /// Nodes and trace lines of the files.
    pub geometry: Geometry,
    /// For each of several files the degrees of freedom that no other file has.
    pub dofs_of_files: Vec<Vec<Dof>>,
    /// Findings of reading.
    pub findings: Vec<Finding>,
    /// Whether part of a file was bad and left out.
    pub partly_bad: bool,
}

/// How a test's files are to be read.
#[derive(Clone, Copy, Debug, Default)]
pub struct IngestOptions<'a> {
    /// How hits are grouped.
    pub hits: HitGrouping,
    /// How hits are cut from continuous records.
    pub trigger: TriggerOptions,
    /// The `[[test]]` table, with the channels that the files do not state.
    pub typed: Option<&'a TestTable>,
    /// Whether the good part of a partly bad file is used.
    pub partial: bool,
    /// Whether FRFs of the files are used where they also hold time records.
    pub frfs_first: bool,
    /// Format of every file; detected from the content when `None`.
    pub format: Option<&'a str>,
    /// Number of averages of FRFs that do not state it; precedes the scene's.
    pub averages: Option<u32>,
    /// Window of FRFs that do not state it; precedes the scene's.
    pub window: Option<Window>,
    /// Unit of FRFs that do not state theirs; the scene's precedes it, and that of a header.
    pub frf_unit: Option<FrfUnit>,
    /// Units of the records of a hit in their order, where no scene describes them.
    pub record_units: &'a [Unit],
    /// Path of the scene, for messages.
    pub scene: &'a str,
}

/// Reads the files of a test.
///
/// # Errors
/// [`SceneError`] for a file that cannot be read, with the location, and for the first damage of a
/// partly bad file, unless its good part is used.
pub fn ingest_files(files: &[FilePlan], options: &IngestOptions) -> Result<Ingested, SceneError> {
    let opened = files.iter().map(|file| open(file, options));
    let opened = opened.collect::<Result<Vec<_>, SceneError>>();
    let data = opened.and_then(|opened| collect_data(opened, options));
    data.map_err(|error| options.located(error))
}

impl IngestOptions<'_> {
    /// An error of the data with its place in the scene, where one describes them.
    fn located(&self, error: SceneError) -> SceneError {
        let Some(test) = self.typed.filter(|_| !self.scene.is_empty()) else {
            return error;
        };
        let text = read_text(Path::new(self.scene)).unwrap_or_default();
        match error {
            SceneError::Io(source @ IoError::NotStated { .. }) => SceneError::NotStated {
                place: key_place(&text, &lacking_key(test, &source), "").map(Box::new),
                scene: self.scene.to_owned(),
                test: test.name.clone(),
                source: Box::new(source),
            },
            other => located(other, self.scene, &text),
        }
    }
}

/// The key of the first channel that lacks the point that is not stated, else that of the test.
fn lacking_key(test: &TestTable, error: &IoError) -> String {
    let of_test = format!("[[test]] {:?}", test.name);
    let IoError::NotStated { what, .. } = error else {
        return of_test;
    };
    let roles: &[&str] = match what {
        what if what.starts_with("the hit point") => &["force"],
        what if what.starts_with("the response point") => {
            &["response", "real", "complex", "magnitude"]
        }
        _ => &[],
    };
    let lacks = |channel: &&ChannelTable| {
        let role = channel.role.as_deref();
        channel.dof.is_none() && role.is_some_and(|role| roles.contains(&role))
    };
    let channel = test.channel.iter().find(lacks);
    channel.map_or(of_test, |channel| {
        channel_key(&test.name, &channel.column.to_string(), "dof")
    })
}

/// Opens the files of a test for their faults alone.
///
/// # Errors
/// All faults of [`ingest_files`] that opening shows.
pub(super) fn check_files(files: &[FilePlan], options: &IngestOptions) -> Result<(), SceneError> {
    let mut faults = Faults::default();
    for file in files {
        faults.take(open(file, options).map_err(|error| options.located(error)));
    }
    faults.into_result()
}

fn open(file: &FilePlan, options: &IngestOptions) -> Result<HitFile, SceneError> {
    let format = format_of(&file.path, options.format)?;
    let as_table = options.format.is_none()
        && TEXT_EXPORTS.contains(&format.name())
        && options.typed.is_some_and(describes_columns);
    let format = if as_table {
        TABLE_FORMAT
    } else {
        format.name()
    };
    let described = options.typed.filter(|test| {
        DESCRIBED_FORMATS.contains(&format) && !test.channel.is_empty() && !states_frf_unit(test)
    });
    let table = described
        .map(|test| table_spec(test, options.scene))
        .transpose()?;
    let hints = Hints {
        path: file.path.display().to_string(),
        table,
    };
    // Described columns have the units of the scene.
    let of_scene = options.typed.filter(|_| hints.table.is_none());
    let of_scene = of_scene.map(|test| stated_frf_units(&test.channel));
    let mut source = open_path(&file.path, &hints, Some(format))?;
    check_stated_points(
        source.catalog(),
        file.response.as_ref(),
        file.reference.as_ref(),
    )?;
    if options.partial {
        let mut merged = Merged::new(vec![source]);
        merged.leave_out_unreadable();
        source = Box::new(merged);
    }
    Ok(HitFile {
        source,
        response: file.response.clone(),
        reference: file.reference.clone(),
        frf_units: of_scene.unwrap_or_default(),
        missing_frf_unit: options.frf_unit,
        averages: options
            .averages
            .or(options.typed.and_then(|test| test.averages)),
        window: match (options.window, options.typed) {
            (None, Some(test)) => window(test.window.as_deref(), options.scene)?,
            (window, _) => window,
        },
        partial: options.partial,
    })
}

/// Opens the files of a test as the scene describes them, as one source.
///
/// # Errors
/// As [`ingest_files`].
pub fn open_test(
    files: &[FilePlan],
    typed: &TestTable,
    format: Option<&str>,
    scene: &str,
) -> Result<Merged, SceneError> {
    let options = IngestOptions {
        typed: Some(typed),
        format,
        scene,
        ..IngestOptions::default()
    };
    let opened = files.iter().map(|file| {
        let source = open(file, &options)?.source;
        if typed.channel.is_empty() || DESCRIBED_FORMATS.contains(&source.catalog().format) {
            return Ok(source);
        }
        let got = format!(
            "{}, whose headers describe its records",
            file.path.display()
        );
        let expected = "tables or arrays in a scene with channels; give the name of this file";
        Err(value_error(scene, "[[test.channel]]", &got, expected))
    });
    let mut merged = Merged::new(opened.collect::<Result<_, SceneError>>()?);
    for (number, file) in files.iter().enumerate() {
        merged.state_points(number, file.response.as_ref(), file.reference.as_ref());
    }
    Ok(merged)
}

/// Whether the scene describes the columns of a text: a channel has a role that no record has.
fn describes_columns(test: &TestTable) -> bool {
    let roles = test
        .channel
        .iter()
        .filter_map(|channel| channel.role.as_deref());
    roles.into_iter().any(|role| COLUMN_ROLES.contains(&role))
}

/// Whether the scene states nothing but the unit of FRFs whose file describes them: no channel has
/// a role.
fn states_frf_unit(test: &TestTable) -> bool {
    let has_role = test.channel.iter().any(|channel| channel.role.is_some());
    !has_role && !stated_frf_units(&test.channel).is_empty()
}

/// Units of FRFs, such as (m/s2)/N or Pa/N, times their calibration.
fn stated_frf_units(channels: &[ChannelTable]) -> Vec<StatedFrfUnit> {
    let stated = channels.iter().filter_map(|channel| {
        let unit = FrfUnit::of_any_response(channel.unit.as_deref()?).ok()?;
        Some(StatedFrfUnit {
            response: channel.dof.as_ref().map(Dof::positive),
            unit: FrfUnit {
                to_si: unit.to_si * channel.scale.unwrap_or(1.0),
                ..unit
            },
        })
    });
    stated.collect()
}

/// Reads bytes as if they were the one file of a test.
///
/// # Errors
/// As [`ingest_files`].
pub fn ingest_bytes(bytes: Vec<u8>, name: &str) -> Result<Ingested, SceneError> {
    let source = open_bytes(
        bytes,
        &Hints {
            path: name.to_owned(),
            table: None,
        },
    )?;
    collect_data(vec![HitFile::new(source)], &IngestOptions::default())
}

fn collect_data(mut files: Vec<HitFile>, options: &IngestOptions) -> Result<Ingested, SceneError> {
    let mut data = Ingested::default();
    let of_type = |wanted| count(&files, |entry| entry.function_type == wanted);
    let (records, frfs) = (of_type(FunctionType::Time), of_type(FunctionType::Frf));
    let from_records = records > 0 && (frfs == 0 || has_recorded_hits(&files, options));
    let need = match from_records {
        true => Need::Records,
        false => Need::Frfs,
    };
    for file in &mut files {
        data.partly_bad |= check_damage(file.source.as_mut(), &[need], options.partial)?;
        let catalog = file.source.catalog();
        data.findings.extend(catalog.findings.iter().cloned());
        data.geometry.add(&catalog.geometry);
        data.findings.extend(local_directions(catalog));
    }
    data.dofs_of_files = dofs_of_files(&files);
    if from_records {
        let overrides = overrides_of(&files, options)?;
        data.findings.extend(unused_data_finding(
            frfs,
            Code::FunctionsPassedOver,
            "functions",
        ));
        let mut set = group_hits(files, options.hits, &overrides)?;
        if let Some(typed) = options.typed.filter(|_| overrides.is_empty()) {
            state_full_scales(&mut set.recording, &typed.channel);
        }
        data.findings.extend(set.findings);
        let mut recording: Box<dyn Recording> = Box::new(set.recording);
        let by_trigger = match options.hits {
            HitGrouping::Trigger => true,
            HitGrouping::Auto => is_continuous(recording.as_mut(), &options.trigger),
            HitGrouping::Records | HitGrouping::Files => false,
        };
        if by_trigger {
            if options.hits == HitGrouping::Auto {
                let finding = Finding::new(Severity::Warning, Code::CutByTrigger, Location::Whole);
                data.findings.push(finding);
            }
            let (hits, findings) =
                cut_hits(recording, &options.trigger).map_err(|error| SceneError::Frf {
                    test: "hits by trigger".to_owned(),
                    source: Box::new(error),
                })?;
            data.findings.extend(findings);
            recording = Box::new(hits);
        }
        data.recording = Some(recording);
    } else {
        data.findings.extend(unused_data_finding(
            records,
            Code::RecordsPassedOver,
            "records",
        ));
        data.frfs = usable_set(frf_sets(&mut files)?).into_iter().collect();
        let unnamed = columns_alone(&files, options.frfs_first);
        if let (true, Some(unnamed)) = (data.frfs.is_empty(), unnamed) {
            return Err(unnamed.into());
        }
        for set in &data.frfs {
            data.findings.extend(check_functions(set));
            data.partly_bad |= set.findings.iter().any(is_lost);
        }
    }
    Ok(data)
}

/// The error of the first file with columns or arrays, where no file states what it holds. Of FRFs
/// alone it names the headings, else what time records need as well.
fn columns_alone(files: &[HitFile], frfs_alone: bool) -> Option<IoError> {
    let catalogs = || files.iter().map(|file| file.source.catalog());
    if catalogs().any(|catalog| !catalog.entries.is_empty() || !catalog.modes.is_empty()) {
        return None;
    }
    let catalog = catalogs().find(|catalog| !catalog.arrays.is_empty())?;
    if !frfs_alone && !TableContent::of(catalog).is_some_and(|table| table.is_functions) {
        return Some(IoError::NotStated {
            path: catalog.path.clone(),
            what: format!("the meaning of time records ({})", held(catalog)),
            expected: "sampling rate or time column, the column of the force with unit and hit \
                       point, and those of the responses with unit and DOF"
                .to_owned(),
        });
    }
    Some(IoError::NotStated {
        path: catalog.path.clone(),
        what: format!("an FRF ({})", held(catalog)),
        expected: "FRFs; in a table the headings `frequency [Hz]`, then \
                   `re 1:+Z|2:+Z [(m/s2)/N]` and `im 1:+Z|2:+Z [(m/s2)/N]` for each response and \
                   reference. For other headings a scene states what the columns hold: \
                   `modalign new FOLDER FILE...`"
            .to_owned(),
    })
}

/// Whether a finding of reading FRFs reports a damaged or an unusable part of a file.
fn is_lost(finding: &Finding) -> bool {
    match finding.code {
        Code::BadDataset => true,
        Code::FunctionLeftOut => finding.severity == Severity::Error,
        _ => false,
    }
}

/// Whether the time records of files with FRFs are used as hits: where one is a force, unless the
/// FRFs are requested.
fn has_recorded_hits(files: &[HitFile], options: &IngestOptions) -> bool {
    let is_force = |entry: &Entry| entry.function_type == FunctionType::Time && entry.is_force();
    let is_described = options.typed.is_some_and(|typed| !typed.channel.is_empty());
    !options.frfs_first && (is_described || count(files, is_force) > 0)
}

/// Number of the entries of files for which something holds.
fn count(files: &[HitFile], holds: impl Fn(&Entry) -> bool) -> usize {
    let entries = files.iter().flat_map(|file| &file.source.catalog().entries);
    entries.filter(|entry| holds(entry)).count()
}

/// The ranges of converters that a scene states for the columns of tables; their units were checked
/// when they were opened.
fn state_full_scales(recording: &mut FileRecording, channels: &[ChannelTable]) {
    for channel in channels {
        let unit = channel
            .unit
            .as_deref()
            .and_then(|unit| unit.parse::<Unit>().ok());
        let Some((full_scale, unit)) = channel.full_scale.zip(unit) else {
            continue;
        };
        let role = match channel.role.as_deref() {
            Some("force") => Role::Force,
            Some("response") => Role::Response,
            _ => continue,
        };
        recording.state_full_scale(role, channel.dof.as_ref(), full_scale * unit.to_si);
    }
}

/// Sensors and hits of records and FRFs at nodes whose displacement system is turned against the
/// global frame.
fn local_directions(catalog: &Catalog) -> Option<Finding> {
    let geometry = &catalog.geometry;
    let is_turned = |node: &&Node| {
        let system = node
            .displacement_system
            .and_then(|label| geometry.system(label));
        system.is_some_and(|system| !system.is_aligned())
    };
    let turned: BTreeSet<&str> = geometry
        .nodes
        .iter()
        .filter(is_turned)
        .map(|node| node.point.as_str())
        .collect();
    let dofs = catalog
        .entries
        .iter()
        .flat_map(|entry| [&entry.response, &entry.reference]);
    let local: BTreeSet<&Dof> = dofs
        .flatten()
        .filter(|dof| turned.contains(dof.point()))
        .collect();
    let location = Location::File {
        path: catalog.path.clone(),
        line: None,
        byte: None,
    };
    let finding = Finding::new(Severity::Warning, Code::LocalDirections, location);
    (!local.is_empty()).then(|| finding.value(local.len() as f64, ""))
}

/// The scene's statements on records; those on the columns of tables are used when a table is
/// opened.
fn overrides_of(
    files: &[HitFile],
    options: &IngestOptions,
) -> Result<Vec<ChannelOverride>, SceneError> {
    let Some(test) = options.typed.filter(|test| !test.channel.is_empty()) else {
        let units = (1..).zip(options.record_units);
        let of_unit = |(number, unit): (usize, &Unit)| ChannelOverride {
            missing_unit: Some(*unit),
            ..ChannelOverride::of_record(number)
        };
        return Ok(units.map(of_unit).collect());
    };
    let tables = files
        .iter()
        .filter(|file| DESCRIBED_FORMATS.contains(&file.source.catalog().format))
        .count();
    match tables {
        0 => overrides(test, options.scene),
        all if all == files.len() => Ok(Vec::new()),
        _ => {
            let got = "tables and other files in one test";
            Err(value_error(
                options.scene,
                "[[test.channel]]",
                got,
                "a test for each",
            ))
        }
    }
}

/// The finding on records or functions that are not used.
fn unused_data_finding(count: usize, code: Code, unit: &str) -> Option<Finding> {
    let finding = Finding::new(Severity::Info, code, Location::Whole);
    (count > 0).then(|| finding.value(count as f64, unit))
}

/// `[[test.channel]]` for files that are no tables: `column` is the number of the record within its
/// hit.
fn overrides(test: &TestTable, path: &str) -> Result<Vec<ChannelOverride>, SceneError> {
    let channels = test.channel.iter();
    channels
        .map(|channel| channel_override(channel, &test.name, path))
        .collect()
}

fn channel_override(
    channel: &ChannelTable,
    test: &str,
    path: &str,
) -> Result<ChannelOverride, SceneError> {
    let key = |name: &str| channel_key(test, &channel.column.to_string(), name);
    let number = match &channel.column {
        ColumnKey::Number(number) if *number > 0 => *number,
        other => {
            return Err(value_error(
                path,
                &key("column"),
                &other.to_string(),
                "the record's number within its hit, from 1",
            ));
        }
    };
    let role = match channel.role.as_deref() {
        None => None,
        Some("force") => Some(Role::Force),
        Some("response") => Some(Role::Response),
        Some(other) => {
            return Err(value_error(
                path,
                &key("role"),
                &format!("{other:?}"),
                "force or response (for a file that is no table)",
            ));
        }
    };
    let unit: Option<Unit> = channel
        .unit
        .as_deref()
        .map(Unit::of_any_quantity)
        .transpose()
        .map_err(|error: crate::quantity::UnitError| {
            value_error(
                path,
                &key("unit"),
                &format!("{:?}", error.got),
                &error.to_string(),
            )
        })?;
    let unlike = channel
        .quantity
        .as_deref()
        .zip(unit)
        .filter(|(name, unit)| *name != unit.quantity.to_string());
    if let Some((name, unit)) = unlike {
        return Err(value_error(
            path,
            &key("quantity"),
            &format!("{name:?}"),
            &unit.quantity.to_string(),
        ));
    }
    if channel
        .scale
        .is_some_and(|scale| !scale.is_finite() || scale == 0.0)
    {
        return Err(value_error(
            path,
            &key("scale"),
            "0 or no number",
            "a finite number other than 0",
        ));
    }
    Ok(ChannelOverride {
        number,
        role,
        dof: channel.dof.clone(),
        unit,
        missing_unit: None,
        scale: channel.scale,
        full_scale: channel.full_scale,
    })
}

impl FilePlan {
    /// A file without stated points.
    pub fn without_points(path: &Path) -> Self {
        Self {
            path: path.to_path_buf(),
            response: None,
            reference: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::{WriteOptions, frf_source, write_path};

    const EXPORT: &str = "Units: Ratio\r\nRef Chan:Resp Chan\t3+Z:4-Z\r\nChannel Name\t : \r\n\r\nFrequency\tReal\tImaginary\r\n\r\n\
                          Units:\r\nHz\t(m/s2)(N)\t\r\n0.0\t1.5\t0.5\r\n0.5\t2.5\t-0.5\r\n";

    fn read(channels: &str) -> FrfSet {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("h.txt");
        std::fs::write(&path, EXPORT).unwrap();
        let text = format!("name = \"t\"\n{channels}");
        let typed: TestTable = toml::from_str(&text).unwrap();
        let options = IngestOptions {
            typed: Some(&typed),
            ..IngestOptions::default()
        };
        let file = FilePlan {
            path,
            response: "2:+X".parse().ok(),
            reference: "1:+X".parse().ok(),
        };
        ingest_files(&[file], &options).unwrap().frfs.remove(0)
    }

    #[test]
    fn the_window_of_the_file_precedes_the_option_and_this_the_scene() {
        let folder = tempfile::tempdir().unwrap();
        let read = |(file, option, scene): (Option<Window>, Option<Window>, Option<&str>)| {
            let mut set = read("");
            set.window = file;
            let path = folder.path().join("h.h5");
            let mut source = frf_source(&set, "FRFs");
            write_path(&path, &mut source, WriteOptions::default()).unwrap();
            let window = scene.map_or_else(String::new, |name| format!("window = {name:?}"));
            let typed: TestTable = toml::from_str(&format!("name = \"t\"\n{window}")).unwrap();
            let options = IngestOptions {
                typed: Some(&typed),
                window: option,
                ..IngestOptions::default()
            };
            let sets = ingest_files(&[FilePlan::without_points(&path)], &options).unwrap();
            sets.frfs[0].window
        };
        let (hann, flat) = (Some(Window::HannNarrow), Some(Window::FlatTop));
        let none = Some(Window::Rectangular);
        assert_eq!(read((None, None, None)), None);
        assert_eq!(read((None, None, Some("rectangular"))), none);
        assert_eq!(read((None, flat, Some("none"))), flat);
        assert_eq!(read((hann, flat, Some("none"))), hann);
        assert_eq!(read((none, flat, None)), none);
    }

    #[test]
    fn columns_that_a_scene_describes_are_read_as_such() {
        let ingested = read("");
        assert_eq!(ingested.functions()[0].response.to_string(), "4:-Z");
        let described = read(
            "[[channel]]\ncolumn = 1\nrole = \"frequency\"\n[[channel]]\ncolumn = 3\nrole = \"real\"\nunit = \"g/N\"\n\
             [[channel]]\ncolumn = 2\nrole = \"imaginary\"\nunit = \"g/N\"\n",
        );
        assert_eq!(described.functions()[0].response.to_string(), "2:+X");
        let value = described.values(0)[1] / 9.80665;
        assert!((value - num_complex::Complex64::new(-0.5, 2.5)).norm() < 1e-12);
    }
}
