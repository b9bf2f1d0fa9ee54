//! The plan of a test names its data, its band and its hits.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

use glob::Pattern;

use crate::axis::Band;
use crate::dof::Dof;
use crate::frf::HammerOptions;
use crate::io::{HitGrouping, IoError};
use crate::signal::{SignalError, TriggerOptions};

use super::columns;
use super::error::{SceneError, value_error};
use super::faults::Faults;
use super::test_state::TestState;
use super::typed::{TestTable, TriggerTable};

/// One test, ready to run.
#[derive(Clone, Debug)]
pub struct TestPlan {
    /// Name.
    pub name: String,
    /// Source of its data.
    pub source: TestSource,
    /// Band of identification.
    pub band: Option<Band>,
    /// Support, loads and date.
    pub state: TestState,
    /// Whether the good part of a partly bad file is used.
    pub partial: bool,
    /// Numbers, from 1, of hits that are used regardless of their checks.
    pub accept: BTreeSet<usize>,
    /// Numbers, from 1, of hits that are rejected regardless of their checks.
    pub reject: BTreeSet<usize>,
}

/// Source of a test's data.
#[derive(Clone, Debug)]
pub enum TestSource {
    /// Recordings or FRFs.
    Files {
        /// The files, each with the points that the scene states.
        files: Vec<FilePlan>,
        /// How hits are grouped.
        hits: HitGrouping,
        /// How they are cut from continuous records.
        trigger: TriggerOptions,
        /// The `[[test]]` table, with the channels that the files do not state.
        typed: Box<TestTable>,
    },
    /// A synthetic test's spec.
    Synth(PathBuf),
    /// Finished modes.
    Modes(PathBuf),
}

/// One file with the points that the scene states.
#[derive(Clone, Debug)]
pub struct FilePlan {
    /// Path.
    pub path: PathBuf,
    /// Its response, where the scene states it.
    pub response: Option<Dof>,
    /// Its excitation point, where the scene states it.
    pub reference: Option<Dof>,
}

impl TestPlan {
    /// The options of the scene, replaced by those that this test states.
    pub fn hammer_options(&self, scene: &HammerOptions) -> HammerOptions {
        HammerOptions {
            accept: self.accept.clone(),
            reject: self.reject.clone(),
            ..scene.clone()
        }
    }
}

/// The plan of a `[[test]]`.
///
/// # Errors
/// [`SceneError::Value`] for a key that cannot be meant.
pub(super) fn test_plan(
    test: &TestTable,
    folder: &Path,
    path: &str,
) -> Result<TestPlan, SceneError> {
    let key = |name: &str| {
        format!("[[test]] {:?} {name}", test.name)
            .trim_end()
            .to_owned()
    };
    let mut faults = Faults::default();
    let band = test.band_hz.map(|[lo, hi]| Band::new(lo, hi)).transpose();
    let band = faults.take(band.map_err(|error| {
        value_error(
            path,
            &key("band_hz"),
            &format!("{:?}", test.band_hz.unwrap_or_default()),
            &error.to_string(),
        )
    }));
    faults.take(columns::window(test.window.as_deref(), path));
    let source = faults.take(test_source(test, folder, path));
    let state = faults.take(test.state.clone().checked(&test.name, path));
    let checked = band.zip(source).zip(state);
    let ((band, source), state) = faults.finish(checked)?;
    Ok(TestPlan {
        name: test.name.clone(),
        source,
        band,
        state,
        partial: test.partial,
        accept: test.accept.clone(),
        reject: test.reject.clone(),
    })
}

/// The source of the data of a `[[test]]`.
///
/// # Errors
/// As [`test_plan`].
pub(super) fn test_source(
    test: &TestTable,
    folder: &Path,
    path: &str,
) -> Result<TestSource, SceneError> {
    let key = format!("[[test]] {:?}", test.name);
    match (test.files.is_empty(), &test.synth, &test.modes) {
        (false, None, None) => files_source(test, folder, path),
        (true, synth, modes)
            if synth.is_some() != modes.is_some()
                && (describes_files(test) || (test.partial && synth.is_some())) =>
        {
            let got =
                "hits, partial, sampling_rate_hz, delimiter, skip_lines, window, channel or file";
            Err(value_error(path, &key, got, "these with `files` alone"))
        }
        (true, Some(spec), None) => Ok(TestSource::Synth(folder.join(spec))),
        (true, None, Some(modes)) => Ok(TestSource::Modes(folder.join(modes))),
        _ => Err(value_error(
            path,
            &key,
            "none or several of files, synth, modes",
            "exactly one of them",
        )),
    }
}

/// Whether a test states keys that only files need.
fn describes_files(test: &TestTable) -> bool {
    let table = test.sampling_rate_hz.is_some() || test.delimiter.is_some() || test.skip_lines > 0;
    table
        || test.window.is_some()
        || test.hits.is_some()
        || !test.channel.is_empty()
        || !test.file.is_empty()
}

fn files_source(test: &TestTable, folder: &Path, path: &str) -> Result<TestSource, SceneError> {
    let (files, mut faults) = listed_files(test, folder, path);
    let hits = match test.hits.as_deref() {
        None => Ok(HitGrouping::Auto),
        Some(name) => HitGrouping::from_name(name).ok_or_else(|| {
            let expected = "\"records\", \"files\" or \"trigger\"";
            value_error(path, "[[test]] hits", &format!("{name:?}"), expected)
        }),
    };
    let hits = faults.take(hits);
    let trigger = faults.take(trigger_options(&test.trigger, path));
    let (hits, trigger) = faults.finish(hits.zip(trigger))?;
    Ok(TestSource::Files {
        files,
        hits,
        trigger,
        typed: Box::new(test.clone()),
    })
}

/// `[test.trigger]`.
fn trigger_options(table: &TriggerTable, path: &str) -> Result<TriggerOptions, SceneError> {
    let options = TriggerOptions {
        level_n: table.level_n,
        pretrigger_s: table.pretrigger_s,
        length_s: table.length_s,
    };
    let none = TriggerOptions::default();
    let of_level = TriggerOptions {
        level_n: options.level_n,
        ..none
    };
    let of_times = TriggerOptions {
        level_n: None,
        ..options
    };
    let mut faults = Faults::default();
    for part in [of_level, of_times] {
        if let Err(SignalError::WindowParameter {
            parameter,
            got,
            expected,
            ..
        }) = part.validate()
        {
            let key = format!("[test.trigger] {parameter}");
            faults.add(value_error(path, &key, &got.to_string(), expected));
        }
    }
    faults.into_result().map(|()| options)
}

/// The files of a `[[test]]` as far as their list is right, and its faults.
pub(super) fn listed_files(
    test: &TestTable,
    folder: &Path,
    path: &str,
) -> (Vec<FilePlan>, Faults<SceneError>) {
    let mut faults = Faults::default();
    let mut files: Vec<FilePlan> = Vec::new();
    for pattern in &test.files {
        for found in faults
            .take(expand(folder, pattern, path))
            .into_iter()
            .flatten()
        {
            if files.iter().any(|file| file.path == found) {
                let got = format!("{} twice", found.display());
                faults.add(value_error(path, "[[test]] files", &got, "each file once"));
                continue;
            }
            let mut stated = test.file.iter();
            let stated = stated.find(|stated| folder.join(&stated.path) == found);
            files.push(FilePlan {
                path: found,
                response: stated.and_then(|stated| stated.response.clone()),
                reference: stated.and_then(|stated| stated.reference.clone()),
            });
        }
    }
    // A file of a pattern without a match is not listed for that reason alone.
    let stated_files = test.file.iter().filter(|_| faults.is_empty());
    for stated in stated_files.collect::<Vec<_>>() {
        let is_listed = |file: &FilePlan| file.path == folder.join(&stated.path);
        if !files.iter().any(is_listed) {
            let got = format!("{:?}", stated.path);
            let key = "[[test.file]] path";
            faults.add(value_error(path, key, &got, "one of the test's files"));
        }
    }
    (files, faults)
}

/// The files of one entry of `files`: itself, or the matches of its wildcards in order of name.
pub(super) fn expand(folder: &Path, pattern: &str, path: &str) -> Result<Vec<PathBuf>, SceneError> {
    if !pattern.contains(['*', '?', '[']) || folder.join(pattern).exists() {
        return Ok(vec![folder.join(pattern)]);
    }
    let mut files = vec![folder.to_owned()];
    for part in Path::new(pattern).components() {
        files = match part {
            Component::CurDir => files,
            Component::Normal(name) if name == "**" => {
                let found = files.iter().map(|folder| folders_within(folder));
                found.collect::<Result<Vec<_>, _>>()?.concat()
            }
            Component::Normal(name) => {
                let matches = Pattern::new(&name.to_string_lossy()).map_err(|error| {
                    value_error(
                        path,
                        "[[test]] files",
                        &format!("{pattern:?}"),
                        &format!("a wildcard pattern ({error})"),
                    )
                })?;
                let found = files.iter().map(|folder| entries(folder, Some(&matches)));
                found.collect::<Result<Vec<_>, _>>()?.concat()
            }
            other => files.iter().map(|folder| folder.join(other)).collect(),
        };
    }
    files.sort();
    if files.is_empty() {
        return Err(value_error(
            path,
            "[[test]] files",
            &format!("{pattern:?}, which matches no file"),
            "at least one file",
        ));
    }
    Ok(files)
}

/// The entries of a folder whose names match; none where it is no folder.
fn entries(folder: &Path, pattern: Option<&Pattern>) -> Result<Vec<PathBuf>, SceneError> {
    let read = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    if !read.is_dir() {
        return Ok(Vec::new());
    }
    let unreadable = |source| IoError::System {
        path: read.display().to_string(),
        action: "read",
        source,
    };
    let mut found = Vec::new();
    for entry in std::fs::read_dir(read).map_err(unreadable)? {
        let name = entry.map_err(unreadable)?.file_name();
        if pattern.is_none_or(|pattern| pattern.matches(&name.to_string_lossy())) {
            found.push(folder.join(name));
        }
    }
    Ok(found)
}

/// A folder and all folders within it, but those behind symbolic links.
fn folders_within(folder: &Path) -> Result<Vec<PathBuf>, SceneError> {
    let mut all = vec![folder.to_owned()];
    let mut next = 0;
    while let Some(folder) = all.get(next).cloned() {
        let is_folder = |path: &PathBuf| path.is_dir() && !path.is_symlink();
        all.extend(entries(&folder, None)?.into_iter().filter(is_folder));
        next += 1;
    }
    Ok(all)
}
