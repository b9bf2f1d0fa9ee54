//! `modalign frf --watch FOLDER`: what to repeat before you leave, kept current while recordings of
//! a test arrive in a folder.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use crate::error::Error;
use crate::frf::{BeforeYouLeave, HammerOptions, evaluate_test};
use crate::io::HitGrouping;
use crate::printable::counted;
use crate::report::{Block, before_you_leave_blocks, before_you_leave_screen, json};
use crate::scene::{TestState, leaving_list, test_rigid_body};

use super::args::FrfArgs;
use super::frf::{
    argument_error, check_arguments, hit_grouping, ingest_recordings, no_records, options,
};
use super::outcome::Outcome;
use super::output::Output;

/// Time between two looks at the folder. A file is read when it is the same in two of them.
const POLL_INTERVAL: Duration = Duration::from_millis(250);

/// Watches a folder until an interrupt. The recordings of all its files are one test; a file that
/// cannot be used is named with the reason, and tried again when a file changes.
pub fn watch(
    args: &FrfArgs,
    folder: &Path,
    format: Option<&str>,
    output: &mut Output,
) -> Result<Outcome, Error> {
    let test = WatchedTest {
        args,
        grouping: hit_grouping(args)?,
        options: options(args, None)?,
        format,
    };
    check_arguments(args, false)?;
    output.end_progress();
    output.end_regularly_at_interrupt();
    let mut watched = Watched::default();
    let mut last = list(folder)?;
    show(folder, &[], &watched, output)?;
    loop {
        std::thread::sleep(POLL_INTERVAL);
        let current = list(folder)?;
        let is_settled = |(path, stamp): &(&PathBuf, &Stamp)| last.get(*path) == Some(stamp);
        let settled = current.iter().filter(is_settled);
        let settled: Listing = settled
            .map(|(path, stamp)| (path.clone(), *stamp))
            .collect();
        let changed = watched.changed_paths(&settled, &current);
        if !changed.is_empty() {
            watched.update(&changed, settled, &test);
            show(folder, &changed, &watched, output)?;
        }
        last = current;
    }
}

/// Size and time of a file.
#[derive(Clone, Copy, PartialEq)]
struct Stamp {
    bytes: u64,
    modified: Option<SystemTime>,
}

/// The files of a folder.
type Listing = BTreeMap<PathBuf, Stamp>;

/// The files of a folder but hidden ones, which are those of programs.
fn list(folder: &Path) -> Result<Listing, Error> {
    let unreadable = |error: std::io::Error| {
        let got = format!("{}: {error}", folder.display());
        argument_error("--watch", &got, "a folder that can be read")
    };
    let entries = std::fs::read_dir(folder).map_err(unreadable)?;
    let file = |entry: std::fs::DirEntry| {
        let path = entry.path();
        // A file may be gone since it was listed.
        let data = std::fs::metadata(&path)
            .ok()
            .filter(|data| data.is_file())?;
        let is_hidden = entry.file_name().to_string_lossy().starts_with('.');
        let stamp = Stamp {
            bytes: data.len(),
            modified: data.modified().ok(),
        };
        (!is_hidden).then_some((path, stamp))
    };
    Ok(entries.flatten().filter_map(file).collect())
}

/// Files in the order in which they were written, those of one time by name. Hits are numbered in
/// this order, and drift compares the first hits at a point with the last, which names such as
/// `hit9.uff` and `hit10.uff` would turn.
fn in_order_of_time(paths: &BTreeSet<PathBuf>, stamps: &Listing) -> Vec<PathBuf> {
    let mut ordered: Vec<PathBuf> = paths.iter().cloned().collect();
    ordered.sort_by_key(|path| stamps.get(path).and_then(|stamp| stamp.modified));
    ordered
}

/// The number of hits of a test, and what to repeat.
struct Evaluated {
    hits: usize,
    list: BeforeYouLeave,
}

/// How the files of a test are read and evaluated.
struct WatchedTest<'a> {
    args: &'a FrfArgs,
    grouping: HitGrouping,
    options: HammerOptions,
    format: Option<&'a str>,
}

impl WatchedTest<'_> {
    fn evaluate(&self, paths: &[PathBuf]) -> Result<Evaluated, Error> {
        let data = ingest_recordings(self.args, paths, self.grouping, self.format)?;
        let mut recording = data.recording.ok_or_else(|| no_records(false))?;
        let result = evaluate_test(recording.as_mut(), &self.options)?;
        let body = test_rigid_body(&result.estimated.set, &data.geometry, &[]);
        Ok(Evaluated {
            hits: result.hits.len(),
            list: leaving_list(&result, body.as_ref(), &TestState::default()),
        })
    }
}

/// The files that were read, and their result.
#[derive(Default)]
struct Watched {
    /// Every file that was tried.
    known: Listing,
    used: BTreeSet<PathBuf>,
    /// Files that cannot be used, with the reason.
    refused: BTreeMap<PathBuf, String>,
    hits: usize,
    list: Option<BeforeYouLeave>,
}

impl Watched {
    /// Settled files that are new or differ, and files that are gone.
    fn changed_paths(&self, settled: &Listing, current: &Listing) -> Vec<PathBuf> {
        let mut changed: Vec<PathBuf> = settled
            .iter()
            .filter(|(path, stamp)| self.known.get(*path) != Some(stamp))
            .map(|(path, _)| path.clone())
            .collect();
        let gone = self
            .known
            .keys()
            .filter(|path| !current.contains_key(*path));
        changed.extend(gone.cloned());
        changed
    }

    fn update(&mut self, changed: &[PathBuf], settled: Listing, test: &WatchedTest) {
        let is_lost = |path: &&PathBuf| !settled.contains_key(*path) || changed.contains(path);
        let begins_anew = self.used.iter().any(|path| is_lost(&path));
        if begins_anew {
            self.used.clear();
            self.list = None;
            self.hits = 0;
        }
        self.known = settled;
        self.refused.clear();
        let others = self.known.keys().filter(|path| !self.used.contains(*path));
        let (new, earlier): (Vec<PathBuf>, Vec<PathBuf>) = others
            .cloned()
            .partition(|path| begins_anew || changed.contains(path));
        // Channels in separate files make hits together only.
        let all = [new.as_slice(), earlier.as_slice()].concat();
        if self.try_to_use(&all, test).is_err() {
            self.use_what_fits(&new, test);
            self.use_what_fits(&earlier, test);
        }
    }

    /// Uses these files in addition to the others, all of them or none.
    fn try_to_use(&mut self, paths: &[PathBuf], test: &WatchedTest) -> Result<(), Error> {
        let mut all = self.used.clone();
        all.extend(paths.iter().cloned());
        if all.is_empty() || paths.is_empty() {
            return Ok(());
        }
        let result = test.evaluate(&in_order_of_time(&all, &self.known))?;
        self.used = all;
        self.hits = result.hits;
        self.list = Some(result.list);
        Ok(())
    }

    /// Uses all of these files that fit the others; a test of many good files is evaluated few
    /// times, because halves of them are tried.
    fn use_what_fits(&mut self, paths: &[PathBuf], test: &WatchedTest) {
        match (self.try_to_use(paths, test), paths) {
            (Ok(()), _) => (),
            (Err(error), [only]) => {
                self.refused.insert(only.clone(), error.to_string());
            }
            (Err(_), _) => {
                let (first, second) = paths.split_at(paths.len() / 2);
                self.use_what_fits(first, test);
                self.use_what_fits(second, test);
            }
        }
    }
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().display().to_string()
}

/// Prints the list with the files that made it.
fn show(
    folder: &Path,
    changed: &[PathBuf],
    watched: &Watched,
    output: &mut Output,
) -> Result<(), Error> {
    let counts = format!(
        "{} with {}",
        counted(watched.used.len(), "file"),
        counted(watched.hits, "hit")
    );
    let names: Vec<String> = changed.iter().map(|path| name(path)).collect();
    let mut lines = vec![match names.as_slice() {
        [] => format!("Watching {} until Ctrl-C.", folder.display()),
        [first] => format!("{first}: {counts}."),
        [first, others @ ..] => format!("{first} and {} more: {counts}.", others.len()),
    }];
    let refused = watched.refused.iter();
    lines.extend(refused.map(|(path, reason)| format!("Not used: {}: {reason}.", name(path))));
    let head = Block::Text(lines.join("\n"));
    let list = watched.list.as_ref();
    output.add_result(
        |_| {
            let list = list.map(before_you_leave_screen);
            [head.clone()].into_iter().chain(list).collect()
        },
        || {
            let list = list.map(before_you_leave_blocks).unwrap_or_default();
            [head.clone()].into_iter().chain(list).collect()
        },
    );
    output.add_json(|| {
        let refused = watched.refused.iter();
        let refused = refused
            .map(|(path, reason)| serde_json::json!({ "file": name(path), "reason": reason }));
        let used = in_order_of_time(&watched.used, &watched.known);
        let used: Vec<String> = used.iter().map(|path| name(path)).collect();
        serde_json::json!({
            "schema": "modalign-watch/1",
            "changed": names,
            "used": used,
            "not_used": refused.collect::<Vec<_>>(),
            "hits": watched.hits,
            "before_you_leave": list.map(json::before_you_leave_value),
        })
        .to_string()
    });
    output.show()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_in_the_order_of_time_and_then_of_name() {
        let stamp = |seconds: Option<u64>| Stamp {
            bytes: 1,
            modified: seconds.map(|s| SystemTime::UNIX_EPOCH + Duration::from_secs(s)),
        };
        let stamps: Listing = [
            ("hit10.uff", Some(30)),
            ("hit9.uff", Some(20)),
            ("b.uff", Some(10)),
            ("a.uff", Some(10)),
            ("unknown.uff", None),
        ]
        .map(|(name, seconds)| (PathBuf::from(name), stamp(seconds)))
        .into();
        let paths = stamps.keys().cloned().collect();
        let ordered = in_order_of_time(&paths, &stamps);
        let names: Vec<String> = ordered.iter().map(|path| name(path)).collect();
        assert_eq!(
            names,
            ["unknown.uff", "a.uff", "b.uff", "hit9.uff", "hit10.uff"]
        );
    }
}
