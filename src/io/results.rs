//! A folder of results has a manifest, which names the files of a run with their hashes.
//!
//! The manifest is written twice: before the first file is replaced, with a mark on each file that
//! will be, and without marks when all are in place. So a folder whose replacement was interrupted
//! is recognised.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::error::system;
use super::write::{FolderLock, PendingFiles, folder_of, remove_leftovers, write_atomically};
use super::{IoError, read_input, sha256_hex, sha256_of_bytes};

/// Schema of `manifest.json` in a folder of results.
pub const MANIFEST_SCHEMA: &str = "modalign-manifest/1";
/// What the schemas of all versions begin with.
const MANIFEST_SCHEMA_NAME: &str = "modalign-manifest/";

/// Name of the manifest in a folder of results.
const MANIFEST_FILE: &str = "manifest.json";

/// Digits of a hash in messages.
const SHOWN_DIGITS: usize = 12;

/// The files of a folder of results.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Manifest {
    schema: String,
    /// Version of the program.
    version: String,
    /// Hash of the names and hashes of all files.
    run: String,
    /// In order of name.
    files: Vec<ListedFile>,
}

/// A file of a manifest.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
struct ListedFile {
    /// Path from the folder, with `/`.
    name: String,
    sha256: String,
    /// The verb that makes the file.
    verb: String,
    /// Whether the file is being replaced or removed, or was when the program ended.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    unfinished: bool,
}

impl Manifest {
    fn of(mut files: Vec<ListedFile>) -> Self {
        files.sort();
        files.dedup();
        let lines = files.iter();
        let lines = lines.map(|file| format!("{} {} {}\n", file.sha256, file.verb, file.name));
        let lines: String = lines.collect();
        Self {
            schema: MANIFEST_SCHEMA.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            run: sha256_of_bytes(lines.as_bytes()),
            files,
        }
    }

    /// The manifest of a folder; `None` where it has none, or that of another program.
    fn read(folder: &Path) -> Result<Option<Self>, IoError> {
        let path = folder.join(MANIFEST_FILE);
        if std::fs::symlink_metadata(&path).is_err() {
            return Ok(None);
        }
        let shown = path.display().to_string();
        let bytes = read_input(&path).map_err(system(&shown, "read"))?;
        let error = |line, column, got| IoError::Json {
            path: shown.clone(),
            line,
            column,
            got,
            expected: "schema modalign-manifest/1; a damaged one may be removed, then run again",
        };
        // Web pages and packages have a file of this name, too.
        let is_ours = memchr::memmem::find(&bytes, MANIFEST_SCHEMA_NAME.as_bytes()).is_some();
        if !is_ours {
            return Ok(None);
        }
        let text = std::str::from_utf8(&bytes).map_err(|cause| {
            let sound = &bytes[..cause.valid_up_to()];
            let line_start = memchr::memrchr(b'\n', sound).map_or(0, |end| end + 1);
            let line = 1 + memchr::memchr_iter(b'\n', sound).count();
            let got = "a byte that is not UTF-8".to_owned();
            error(line, 1 + sound.len() - line_start, got)
        })?;
        let manifest: Self = serde_json::from_str(text)
            .map_err(|cause| error(cause.line(), cause.column(), cause.to_string()))?;
        match manifest.schema == MANIFEST_SCHEMA {
            true => Ok(Some(manifest)),
            false => Err(error(1, 1, format!("schema {:?}", manifest.schema))),
        }
    }

    fn write(&self, folder: &Path) -> Result<(), IoError> {
        let path = folder.join(MANIFEST_FILE);
        let shown = path.display().to_string();
        write_atomically(&path, |out| {
            let written = serde_json::to_writer_pretty(&mut *out, self);
            let ended = written.map_err(std::io::Error::from);
            ended
                .and_then(|()| out.write_all(b"\n"))
                .map_err(system(&shown, "write"))
        })
    }

    /// Checks that a file with this content is of the run that the manifest names.
    fn check(&self, folder: &Path, name: &str, content: &[u8]) -> Result<(), IoError> {
        let listed: Vec<&ListedFile> = self.files.iter().filter(|file| file.name == name).collect();
        let Some(first) = listed.first() else {
            return Ok(());
        };
        let error = |got: String, expected: &str| IoError::OtherRun {
            path: folder.join(name).display().to_string(),
            got,
            expected: format!(
                "{expected} that {MANIFEST_FILE} names: run `modalign {}` again",
                first.verb.escape_debug()
            ),
        };
        if listed.iter().any(|file| file.unfinished) {
            let got = "a file that was being replaced when its run was interrupted".to_owned();
            return Err(error(got, "one of a finished run"));
        }
        let sha256 = sha256_of_bytes(content);
        let digits = |sha256: &str| -> String { sha256.chars().take(SHOWN_DIGITS).collect() };
        let short = |sha256: &str| format!("{}…", digits(sha256).escape_debug());
        match first.sha256 == sha256 {
            true => Ok(()),
            false => {
                let expected = format!("{} of the run", short(&first.sha256));
                let got = format!("content with SHA-256 {}", short(&sha256));
                Err(error(got, &expected))
            }
        }
    }
}

/// Checks the content of a result. Where a manifest beside the result names it, it must be of the
/// run of the manifest.
///
/// # Errors
/// [`IoError::OtherRun`] for a file of another or an unfinished run, or one that was changed;
/// [`IoError::Json`] for a damaged manifest.
pub fn check_result(path: &Path, content: &[u8]) -> Result<(), IoError> {
    // A link to a result is checked by the manifest beside the result.
    let behind_links = path.canonicalize().ok();
    for path in std::iter::once(path).chain(behind_links.as_deref()) {
        let name = path.file_name().and_then(|name| name.to_str());
        if let (Some(name), Some(manifest)) = (name, Manifest::read(folder_of(path))?) {
            manifest.check(folder_of(path), name, content)?;
        }
    }
    Ok(())
}

/// Checks all JSON files of a folder of results that its manifest names.
///
/// # Errors
/// As [`check_result`]; [`IoError::OtherRun`] for one that is missing.
pub fn check_results(folder: &Path) -> Result<(), IoError> {
    let Some(manifest) = Manifest::read(folder)? else {
        return Ok(());
    };
    for file in manifest
        .files
        .iter()
        .filter(|file| file.name.ends_with(".json"))
    {
        let path = folder.join(&file.name);
        match read_input(&path) {
            Ok(content) => manifest.check(folder, &file.name, &content)?,
            Err(_) => {
                return Err(IoError::OtherRun {
                    path: path.display().to_string(),
                    got: "no file that can be read".to_owned(),
                    expected: format!(
                        "the one that {MANIFEST_FILE} names: run `modalign {}` again",
                        file.verb.escape_debug()
                    ),
                });
            }
        }
    }
    Ok(())
}

/// Removes a file from the manifest beside it, after a command wrote it alone: it is no longer of
/// the run that the manifest names.
///
/// # Errors
/// As [`ResultsFolder::write`].
pub fn forget_result(path: &Path) -> Result<(), IoError> {
    let folder = folder_of(path);
    let name = path.file_name().and_then(|name| name.to_str());
    let (Some(name), Some(manifest)) = (name, Manifest::read(folder)?) else {
        return Ok(());
    };
    let is_other = |file: &ListedFile| file.name != name;
    if manifest.files.iter().all(is_other) {
        return Ok(());
    }
    let kept = manifest.files.into_iter().filter(is_other).collect();
    Manifest::of(kept).write(folder)
}

/// A file of a folder of results.
pub struct ResultFile {
    /// Path from the folder, with `/`.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
    /// The verb that makes the file.
    pub verb: &'static str,
}

/// A folder of results, into which no other command writes meanwhile.
pub struct ResultsFolder {
    path: PathBuf,
    before: Manifest,
    _lock: FolderLock,
}

impl ResultsFolder {
    /// Makes the folder, locks it, and reads the manifest of what it holds.
    ///
    /// # Errors
    /// [`IoError::System`] when another command writes into it or it cannot be made;
    /// [`IoError::Json`] for another program's manifest.
    pub fn open(path: &Path) -> Result<Self, IoError> {
        let lock = FolderLock::take(path)?;
        let before = Manifest::read(path)?;
        let file = path.join(MANIFEST_FILE);
        if before.is_none() && std::fs::symlink_metadata(&file).is_ok() {
            let other = "it is the file of another program, expected another folder for results";
            let other = std::io::Error::other(other);
            return Err(system(&file.display().to_string(), "replace")(other));
        }
        Ok(Self {
            before: before.unwrap_or_default(),
            path: path.to_owned(),
            _lock: lock,
        })
    }

    /// Whether a manifest names the files that the folder held before.
    pub fn has_manifest(&self) -> bool {
        !self.before.schema.is_empty()
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the manifest names this file, so that a verb that replaces it removes it.
    pub fn names(&self, name: &str) -> bool {
        self.before.files.iter().any(|file| file.name == name)
    }

    /// Writes results and the manifest. The files of `replaced_verb` that are not among them are
    /// removed, if they are as the manifest names them.
    ///
    /// # Errors
    /// [`IoError::System`].
    pub fn write(&self, files: &[ResultFile], replaced_verb: Option<&str>) -> Result<(), IoError> {
        let mut pending = PendingFiles::default();
        let mut new = BTreeMap::new();
        for file in files {
            pending.add_bytes(&self.path.join(&file.name), &file.bytes)?;
            let listed = ListedFile {
                name: file.name.clone(),
                sha256: sha256_of_bytes(&file.bytes),
                verb: file.verb.to_owned(),
                unfinished: false,
            };
            new.insert(file.name.as_str(), listed);
        }
        let is_replaced = |file: &ListedFile| {
            new.contains_key(file.name.as_str()) || Some(file.verb.as_str()) == replaced_verb
        };
        let (old, kept): (Vec<ListedFile>, Vec<ListedFile>) =
            self.before.files.iter().cloned().partition(is_replaced);
        let marked = old.iter().chain(new.values()).map(|file| ListedFile {
            unfinished: true,
            ..file.clone()
        });
        Manifest::of(marked.chain(kept.iter().cloned()).collect()).write(&self.path)?;
        pending.place()?;
        for file in &old {
            if let Some(path) = self.inner_path(&file.name) {
                remove_leftovers(folder_of(&path));
                if !new.contains_key(file.name.as_str())
                    && sha256_hex(&path).is_ok_and(|sha256| sha256 == file.sha256)
                {
                    let shown = path.display().to_string();
                    std::fs::remove_file(&path).map_err(system(&shown, "remove"))?;
                }
            }
        }
        Manifest::of(new.into_values().chain(kept).collect()).write(&self.path)
    }

    /// The path of a regular file of the folder; `None` for a name that leads elsewhere.
    fn inner_path(&self, name: &str) -> Option<PathBuf> {
        let name = Path::new(name);
        let is_inside = |part| matches!(part, Component::Normal(_));
        if !name.components().all(is_inside) {
            return None;
        }
        let path = self.path.join(name);
        let data = std::fs::symlink_metadata(&path).ok()?;
        let folder = folder_of(&path).canonicalize().ok()?;
        let inside = folder.starts_with(self.path.canonicalize().ok()?);
        (inside && data.is_file()).then_some(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(name: &str, text: &str, verb: &'static str) -> ResultFile {
        ResultFile {
            name: name.to_owned(),
            bytes: text.as_bytes().to_vec(),
            verb,
        }
    }

    fn write(folder: &Path, files: &[ResultFile], verb: Option<&str>) {
        let results = ResultsFolder::open(folder).unwrap();
        results.write(files, verb).unwrap();
    }

    #[test]
    fn a_run_removes_the_files_of_the_earlier_run_alone() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let first = [
            file("a.txt", "a", "run"),
            file("figures/b.svg", "b", "run"),
            file("edited.txt", "c", "run"),
        ];
        write(folder, &first, Some("run"));
        write(
            folder,
            &[file("update.json", "u", "update")],
            Some("update"),
        );
        std::fs::write(folder.join("edited.txt"), "by hand").unwrap();
        std::fs::write(folder.join("notes.txt"), "by hand").unwrap();
        write(folder, &[file("a.txt", "new", "run")], Some("run"));
        assert!(!folder.join("figures/b.svg").exists());
        for kept in ["a.txt", "update.json", "edited.txt", "notes.txt"] {
            assert!(folder.join(kept).exists(), "{kept}");
        }
        assert!(check_result(&folder.join("a.txt"), b"new").is_ok());
        assert!(check_result(&folder.join("notes.txt"), b"any").is_ok());
        // A file that another command wrote alone.
        forget_result(&folder.join("update.json")).unwrap();
        assert!(check_result(&folder.join("update.json"), b"other").is_ok());
        let error = check_result(&folder.join("a.txt"), b"a").unwrap_err();
        let error = error.to_string();
        assert!(error.contains("a.txt: got content with SHA-256"), "{error}");
    }

    #[test]
    fn a_manifest_removes_no_file_outside_its_folder() {
        let folder = tempfile::tempdir().unwrap();
        let (inner, outer) = (folder.path().join("out"), folder.path().join("outer.txt"));
        std::fs::write(&outer, "x").unwrap();
        write(&inner, &[file("a.txt", "x", "run")], Some("run"));
        let path = inner.join(MANIFEST_FILE);
        let text = std::fs::read_to_string(&path).unwrap();
        for name in ["../outer.txt".to_owned(), outer.display().to_string()] {
            std::fs::write(&path, text.replace("a.txt", &name)).unwrap();
            write(&inner, &[], Some("run"));
            assert!(outer.exists(), "{name}");
        }
    }

    #[test]
    fn a_manifest_that_is_not_utf_8_is_refused_with_its_place() {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &[file("a.txt", "x", "run")], Some("run"));
        let path = folder.path().join(MANIFEST_FILE);
        let text = std::fs::read(&path).unwrap();
        let at = memchr::memmem::find(&text, b"a.txt").unwrap();
        let mut faulty = text.clone();
        faulty[at] = 0xe4;
        std::fs::write(&path, faulty).unwrap();
        let before = String::from_utf8(text[..at].to_vec()).unwrap();
        let line = before.lines().count();
        let column = 1 + before.lines().last().unwrap().len();
        let place = format!("{MANIFEST_FILE}:{line}:{column}: got a byte that is not UTF-8");
        let error = check_results(folder.path()).unwrap_err().to_string();
        assert!(error.contains(&place), "{error}");
        let opened = ResultsFolder::open(folder.path()).err();
        assert_eq!(opened.unwrap().to_string(), error);
    }

    #[test]
    fn a_folder_is_locked_until_its_command_has_ended() {
        let folder = tempfile::tempdir().unwrap();
        let new = folder.path().join("new/out");
        let first = ResultsFolder::open(&new).unwrap();
        let error = ResultsFolder::open(&new).err().unwrap().to_string();
        assert!(error.contains("another modalign"), "{error}");
        drop(first);
        assert!(!folder.path().join("new").exists());
    }
}
