//! A test's files to hits or FRFs: opened, judged whole or partly bad, grouped.

use std::path::Path;

use crate::finding::{Code, Finding, Place, Severity};
use crate::frf::FrfSet;
use crate::io::{
    ChannelOverride, Entry, FunctionType, Hints, HitFile, HitGrouping, Source, format_of, frf_sets,
    group_hits, has_time_records, open_bytes, open_path,
};
use crate::quantity::{FrfUnit, Unit};
use crate::record::{Hit, Role};

use super::SceneError;
use super::columns::table_spec;
use super::model::value_error;
use super::plan::FilePlan;
use super::typed::{ChannelTable, ColumnKey, TestTable};

/// Name of the format whose channels the scene describes column by column.
const TABLE: &str = "table";

/// What a test's files hold.
#[derive(Clone, Debug, Default)]
pub struct Ingested {
    /// Hits, for recordings.
    pub hits: Vec<Hit>,
    /// FRFs, for files that hold no time records.
    pub frfs: Vec<FrfSet>,
    /// Findings of reading.
    pub findings: Vec<Finding>,
    /// Whether part of a file was bad and left out.
    pub partly_bad: bool,
}

/// How a test's files are to be read.
#[derive(Clone, Copy, Debug, Default)]
pub struct IngestOptions<'a> {
    /// How hits are told apart.
    pub hits: HitGrouping,
    /// The test as typed: what its channels are, where the files do not say.
    pub typed: Option<&'a TestTable>,
    /// Whether the good part of a partly bad file will do.
    pub partial: bool,
    /// Format of every file, instead of judging by content.
    pub format: Option<&'a str>,
    /// Path of the scene, for messages.
    pub scene: &'a str,
}

/// Reads the files of a test.
///
/// # Errors
/// [`SceneError`]: what cannot be read, with its place; the first damage of a partly bad file, unless its good part will do.
pub fn ingest_files(files: &[FilePlan], options: &IngestOptions) -> Result<Ingested, SceneError> {
    let opened = files.iter().map(|file| open(file, options));
    collect(opened.collect::<Result<Vec<_>, SceneError>>()?, options)
}

fn open(file: &FilePlan, options: &IngestOptions) -> Result<HitFile, SceneError> {
    let frf_unit = options
        .typed
        .and_then(|test| stated_frf_unit(&test.channel));
    let format = format_of(&file.path, options.format)?;
    let described = options
        .typed
        .filter(|test| format.name() == TABLE && !test.channel.is_empty());
    let table = described
        .map(|test| table_spec(test, options.scene))
        .transpose()?;
    let hints = Hints {
        path: file.path.display().to_string(),
        table,
    };
    Ok(HitFile {
        source: open_path(&file.path, &hints, Some(format.name()))?,
        response: file.response.clone(),
        reference: file.reference.clone(),
        frf_unit,
    })
}

/// A unit such as (m/s2)/N is that of every FRF that does not state its own.
fn stated_frf_unit(channels: &[ChannelTable]) -> Option<FrfUnit> {
    channels
        .iter()
        .find_map(|channel| channel.unit.as_deref()?.parse().ok())
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
    collect(
        vec![HitFile {
            source,
            response: None,
            reference: None,
            frf_unit: None,
        }],
        &IngestOptions::default(),
    )
}

fn collect(mut files: Vec<HitFile>, options: &IngestOptions) -> Result<Ingested, SceneError> {
    let mut data = Ingested::default();
    for file in &mut files {
        data.partly_bad |= judge(file.source.as_mut(), options.partial)?;
        data.findings
            .extend(file.source.catalog().findings.iter().cloned());
    }
    if files
        .iter()
        .any(|file| has_time_records(file.source.as_ref()))
    {
        let overrides = overrides_of(&files, options)?;
        data.findings.extend(passed_over(&files));
        let set = group_hits(&mut files, options.hits, &overrides)?;
        data.hits = set.hits;
        data.findings.extend(set.findings);
    } else {
        data.frfs = frf_sets(&mut files)?;
    }
    Ok(data)
}

/// What the scene says of records; the channels of a table were named when it was opened.
fn overrides_of(
    files: &[HitFile],
    options: &IngestOptions,
) -> Result<Vec<ChannelOverride>, SceneError> {
    let Some(test) = options.typed.filter(|test| !test.channel.is_empty()) else {
        return Ok(Vec::new());
    };
    let tables = files
        .iter()
        .filter(|file| file.source.catalog().format == TABLE)
        .count();
    match tables {
        0 => overrides(&test.channel, options.scene),
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

/// FRFs beside time records are not used: the hits are.
fn passed_over(files: &[HitFile]) -> Option<Finding> {
    let is_frf = |entry: &&Entry| entry.function_type == FunctionType::Frf;
    let count: usize = files
        .iter()
        .map(|file| file.source.catalog().entries.iter().filter(is_frf).count())
        .sum();
    let finding = Finding::new(Severity::Info, Code::FunctionsPassedOver, Place::Whole);
    (count > 0).then(|| finding.value(count as f64, "functions"))
}

/// Whether part of the file is bad; an error unless its good part will do.
fn judge(source: &mut dyn Source, partial: bool) -> Result<bool, SceneError> {
    let damaged = !source.catalog().damage.is_empty();
    match source.take_damage().into_iter().next() {
        Some(first) if !partial => Err(first.into()),
        _ => Ok(damaged),
    }
}

/// `[[test.channel]]` for files that are no tables: `column` is the number of the record within its hit.
fn overrides(channels: &[ChannelTable], path: &str) -> Result<Vec<ChannelOverride>, SceneError> {
    channels
        .iter()
        .map(|channel| channel_override(channel, path))
        .collect()
}

fn channel_override(channel: &ChannelTable, path: &str) -> Result<ChannelOverride, SceneError> {
    let key = |name: &str| format!("[[test.channel]] {} {name}", channel.column);
    let number = match &channel.column {
        ColumnKey::Number(number) if *number > 0 => *number,
        other => {
            return Err(value_error(
                path,
                "[[test.channel]] column",
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
        .map(str::parse)
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
        scale: channel.scale,
    })
}

impl FilePlan {
    /// A file of which nothing is stated.
    pub fn bare(path: &Path) -> Self {
        Self {
            path: path.to_path_buf(),
            response: None,
            reference: None,
        }
    }
}
