//! Results become files, whole or not at all, in the format that the extension of a path asks for.
//!
//! A file is written under a hidden name beside its target, synced, closed, and renamed when all
//! files of a command are written. The first one in a folder stays open with a lock, which shows
//! that its writer lives; the next writer removes the files of dead ones. A target that is no
//! regular file, such as a device or a pipe, is written into.

use std::collections::BTreeSet;
use std::fs::{DirEntry, File, Metadata, OpenOptions, TryLockError};
use std::io::{Cursor, Error, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::TempPath;

use super::error::system;
use super::input::open_input;
use super::{FORMATS, Format, IoError, Source, WriteOptions, WriteSeek};
use crate::finding::Finding;

/// How the name of a file begins that is not whole yet. Letters and digits follow, the same for all
/// files of a command in one folder, and after the first file `-1`, `-2` and so on.
const TEMPORARY_PREFIX: &str = ".modalign-";
/// Number of these letters and digits.
const TEMPORARY_LETTERS: usize = 6;

/// Maximum number of symbolic links from a name to its file, as Linux has it.
const MAX_LINKS: usize = 40;

/// What a command leaves nothing of: files that are not in place, and new folders that are empty.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn unfinished() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the files that this process has not finished, before it ends at an interrupt.
pub fn remove_unfinished() {
    // The list is not waited for: the thread that panicked may hold it.
    let Ok(paths) = UNFINISHED.try_lock() else {
        return;
    };
    // What is in a folder before the folder.
    for path in paths.iter().rev() {
        // The program ends: an error has no reader.
        let _ = std::fs::remove_file(path);
        let _ = std::fs::remove_dir(path);
    }
}

/// Removes from a folder what dead writers have left there.
pub(super) fn remove_leftovers(folder: &Path) {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let is_file = |entry: &DirEntry| entry.file_type().is_ok_and(|kind| kind.is_file());
    for entry in entries.filter(is_file) {
        let name = entry.file_name();
        let Some(first) = name.to_str().and_then(first_of_writer) else {
            continue;
        };
        // The lock of a living writer is refused. While it is held here, none begins. The first
        // file is renamed last, so that others without it are leftovers.
        let first = folder.join(first);
        if std::fs::symlink_metadata(&first).is_ok_and(|data| !data.is_file()) {
            continue;
        }
        let opened = File::open(first);
        let is_dead = match &opened {
            Ok(file) => file.try_lock().is_ok(),
            Err(error) => error.kind() == ErrorKind::NotFound,
        };
        if is_dead {
            // What cannot be removed stays: the command goes on without.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// The name of the first file of the writer of a temporary file; `None` for another file.
fn first_of_writer(name: &str) -> Option<&str> {
    let rest = name.strip_prefix(TEMPORARY_PREFIX)?;
    let (letters, number) = rest.split_once('-').unwrap_or((rest, "1"));
    let is_temporary = letters.len() == TEMPORARY_LETTERS
        && letters.bytes().all(|byte| byte.is_ascii_alphanumeric())
        && number.bytes().all(|byte| byte.is_ascii_digit());
    is_temporary.then(|| &name[..TEMPORARY_PREFIX.len() + TEMPORARY_LETTERS])
}

/// A new folder, and those above it, that are removed in the end if they are empty.
struct NewFolders(Vec<PathBuf>);

impl NewFolders {
    /// Makes a folder.
    fn make(folder: &Path) -> std::io::Result<Self> {
        let above = folder.ancestors().take_while(|folder| {
            let is_missing = || std::fs::symlink_metadata(folder).is_err();
            !folder.as_os_str().is_empty() && is_missing()
        });
        let made: Vec<PathBuf> = above.map(Path::to_path_buf).collect();
        unfinished().extend(made.iter().cloned());
        let folders = Self(made);
        std::fs::create_dir_all(folder)?;
        for made in &folders.0 {
            sync_folder(folder_of(made))?;
        }
        Ok(folders)
    }
}

impl Drop for NewFolders {
    fn drop(&mut self) {
        let mut unfinished = unfinished();
        for folder in &self.0 {
            let _ = std::fs::remove_dir(folder);
            unfinished.remove(folder);
        }
    }
}

/// The lock of a folder that one command at a time writes its results into.
pub struct FolderLock {
    _made: NewFolders,
    /// Locked as long as it is open; `None` where the system cannot lock folders.
    _folder: Option<File>,
}

impl FolderLock {
    /// Makes the folder and locks it. A folder that was made is removed with the lock if it is
    /// empty then.
    ///
    /// # Errors
    /// [`IoError::System`] when another command holds the lock or the folder cannot be made.
    pub fn take(folder: &Path) -> Result<Self, IoError> {
        let name = folder.display().to_string();
        let made = NewFolders::make(folder).map_err(system(&name, "create the folder"))?;
        let opened = File::open(folder).ok();
        let locked = opened.as_ref().map(File::try_lock);
        if let Some(Err(TryLockError::WouldBlock)) = locked {
            let other = "another modalign writes into this folder, expected one at a time";
            return Err(system(&name, "write")(Error::other(other)));
        }
        Ok(Self {
            _made: made,
            _folder: opened.filter(|_| matches!(locked, Some(Ok(())))),
        })
    }
}

/// A file that is not in place; it goes when it is dropped.
struct Temporary(PathBuf);

impl Temporary {
    fn at(path: PathBuf) -> Self {
        unfinished().insert(path.clone());
        Self(path)
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        // After a renaming there is none.
        let _ = std::fs::remove_file(&self.0);
        unfinished().remove(&self.0);
    }
}

/// The temporary files of a command in one folder.
struct FolderFiles {
    folder: PathBuf,
    _made: NewFolders,
    /// Path of the first one.
    first: PathBuf,
    /// Number of the others.
    others: usize,
    /// The first one, locked as long as it is open.
    _lock: File,
}

impl FolderFiles {
    /// Makes the first file beside a target.
    fn begin(target: &Path, replaces: bool) -> std::io::Result<(Self, Temporary, File)> {
        let folder = folder_of(target);
        let made = NewFolders::make(folder)?;
        remove_leftovers(folder);
        loop {
            let created = tempfile::Builder::new()
                .prefix(TEMPORARY_PREFIX)
                .rand_bytes(TEMPORARY_LETTERS)
                .make_in(folder, |path| create(path, replaces))?;
            let (file, path) = created.keep()?;
            let temporary = Temporary::at(path.clone());
            // Where files cannot be locked, none is taken for a leftover.
            let lock = file.try_clone()?;
            let _ = lock.lock();
            // Another writer may have taken it for one until it was locked.
            if !path.exists() {
                continue;
            }
            let files = Self {
                folder: folder.to_owned(),
                _made: made,
                first: path,
                others: 0,
                _lock: lock,
            };
            return Ok((files, temporary, file));
        }
    }

    /// Makes the next file.
    fn next(&mut self, replaces: bool) -> std::io::Result<(Temporary, File)> {
        self.others += 1;
        let mut path = self.first.clone().into_os_string();
        path.push(format!("-{}", self.others));
        let path = PathBuf::from(path);
        let file = create(&path, replaces)?;
        Ok((Temporary::at(path), file))
    }
}

/// The folder of a file.
pub(super) fn folder_of(path: &Path) -> &Path {
    let folder = path.parent();
    let named = folder.filter(|folder| !folder.as_os_str().is_empty());
    named.unwrap_or(Path::new("."))
}

/// The place behind the name of an output.
enum Target {
    /// A regular file, or none yet, behind all symbolic links.
    File {
        path: PathBuf,
        replaced: Option<Metadata>,
    },
    /// Anything else.
    Stream(Stream),
}

/// An output that is written into.
enum Stream {
    /// A file that the program was started with, by its number.
    Open(u32, PathBuf),
    /// A device, a pipe or a socket.
    Device(PathBuf),
}

impl Stream {
    fn write(&self, bytes: &[u8]) -> std::io::Result<()> {
        let mut options = OpenOptions::new();
        let opened = match self {
            Stream::Open(_, path) => options.append(true).open(path),
            Stream::Device(path) => options.write(true).open(path),
        };
        opened?.write_all(bytes)
    }
}

impl Target {
    fn of(path: &Path) -> std::io::Result<Self> {
        let mut path = path.to_owned();
        for _ in 0..=MAX_LINKS {
            if let Some(number) = number_of_open_file(&path) {
                return Ok(Target::Stream(Stream::Open(number, path)));
            }
            // An error of a path that leads nowhere comes when its folder is made.
            let data = std::fs::symlink_metadata(&path).ok();
            let kind = data.as_ref().map(Metadata::file_type);
            match kind {
                Some(kind) if kind.is_symlink() => {
                    path = folder_of(&path).join(std::fs::read_link(&path)?);
                }
                Some(kind) if kind.is_dir() => {
                    return Err(Error::other("it is a folder, expected a file"));
                }
                Some(kind) if !kind.is_file() => {
                    return Ok(Target::Stream(Stream::Device(path)));
                }
                _ => {
                    return Ok(Target::File {
                        path,
                        replaced: data,
                    });
                }
            }
        }
        Err(Error::other(
            "its symbolic links lead to no file, expected a file",
        ))
    }
}

/// The number of `/dev/fd/1`, behind which the file of standard output stands: a file that was
/// renamed to its name would not be the one that the program writes to.
fn number_of_open_file(path: &Path) -> Option<u32> {
    let number = path.file_name()?.to_str()?.parse().ok()?;
    let folder = folder_of(path).canonicalize().ok()?;
    let is_list = |list: &str| {
        Path::new(list)
            .canonicalize()
            .is_ok_and(|list| list == folder)
    };
    ["/dev/fd", "/proc/self/fd"]
        .into_iter()
        .any(is_list)
        .then_some(number)
}

/// The file that is written in the end for the name of an output: the name behind its symbolic
/// links; as it is where it leads to no regular file.
pub fn resolved_target(path: &Path) -> PathBuf {
    match Target::of(path) {
        Ok(Target::File { path, .. }) => {
            let folder = folder_of(&path).canonicalize();
            let name = path.file_name();
            match (folder, name) {
                (Ok(folder), Some(name)) => folder.join(name),
                _ => path,
            }
        }
        _ => path.to_owned(),
    }
}

/// Whether an output is no regular file, so that it cannot be read again.
pub fn is_stream(path: &Path) -> bool {
    matches!(Target::of(path), Ok(Target::Stream(_)))
}

/// The number of the file that the program was started with and that an output leads to: 1 for
/// standard output, 2 for standard error.
pub fn open_file_number(path: &Path) -> Option<u32> {
    match Target::of(path) {
        Ok(Target::Stream(Stream::Open(number, _))) => Some(number),
        _ => None,
    }
}

/// Files of a command that are written, but not in place yet.
#[derive(Default)]
pub(super) struct PendingFiles {
    files: Vec<PendingFile>,
    streams: Vec<(String, Stream, Vec<u8>)>,
    folders: Vec<FolderFiles>,
}

impl Drop for PendingFiles {
    fn drop(&mut self) {
        self.files.clear();
        // New folders within new folders first.
        while self.folders.pop().is_some() {}
    }
}

/// A file that is written, and its target.
struct PendingFile {
    shown: String,
    written: Temporary,
    target: PathBuf,
}

impl PendingFiles {
    /// Writes a file beside its target, or in memory for a target that is no regular file. Makes
    /// the folder of the target.
    ///
    /// # Errors
    /// [`IoError::System`], or what `content` returns.
    pub fn add(
        &mut self,
        path: &Path,
        content: impl FnOnce(&mut dyn WriteSeek) -> Result<(), IoError>,
    ) -> Result<(), IoError> {
        let shown = path.display().to_string();
        match Target::of(path).map_err(system(&shown, "write"))? {
            Target::File { path, replaced } => {
                let created = self.create_beside(&path, replaced.is_some());
                let (written, file) = created.map_err(system(&shown, "write"))?;
                let mut file = std::io::BufWriter::new(file);
                content(&mut file)?;
                let file = file.into_inner().map_err(|error| error.into_error());
                let finished = file.and_then(|file| {
                    if let Some(data) = &replaced {
                        keep_owner_and_permissions(&file, data)?;
                    }
                    file.sync_all()
                });
                finished.map_err(system(&shown, "write"))?;
                self.files.push(PendingFile {
                    shown,
                    written,
                    target: path,
                });
            }
            Target::Stream(stream) => {
                let mut bytes = Cursor::new(Vec::new());
                content(&mut bytes)?;
                self.streams.push((shown, stream, bytes.into_inner()));
            }
        }
        Ok(())
    }

    /// Writes bytes as [`PendingFiles::add`] does.
    pub fn add_bytes(&mut self, path: &Path, bytes: &[u8]) -> Result<(), IoError> {
        let shown = path.display().to_string();
        self.add(path, |out| {
            out.write_all(bytes).map_err(system(&shown, "write"))
        })
    }

    fn create_beside(
        &mut self,
        target: &Path,
        replaces: bool,
    ) -> std::io::Result<(Temporary, File)> {
        let folder = folder_of(target);
        match self.folders.iter_mut().find(|files| files.folder == folder) {
            Some(files) => files.next(replaces),
            None => {
                let (files, temporary, file) = FolderFiles::begin(target, replaces)?;
                self.folders.push(files);
                Ok((temporary, file))
            }
        }
    }

    /// Puts all files in place.
    ///
    /// # Errors
    /// [`IoError::System`].
    pub fn place(self) -> Result<(), IoError> {
        for (shown, stream, bytes) in &self.streams {
            stream.write(bytes).map_err(system(shown, "write"))?;
        }
        // The first one of a folder shows that the writer of the others lives.
        for file in self.files.iter().rev() {
            let renamed = std::fs::rename(&file.written.0, &file.target);
            renamed.map_err(system(&file.shown, "rename"))?;
        }
        self.sync_folders()
    }

    /// Puts all files in place if none of them exists; a failure leaves none of them.
    fn place_new(self) -> Result<(), IoError> {
        for (number, file) in self.files.iter().enumerate().rev() {
            let written = TempPath::try_from_path(&file.written.0);
            let placed = written.and_then(|written| Ok(written.persist_noclobber(&file.target)?));
            if let Err(error) = placed {
                for placed in &self.files[number + 1..] {
                    // The failure is reported.
                    let _ = std::fs::remove_file(&placed.target);
                }
                return Err(system(&file.shown, "create")(error));
            }
        }
        self.sync_folders()
    }

    fn sync_folders(&self) -> Result<(), IoError> {
        for files in &self.folders {
            let shown = files.folder.display().to_string();
            sync_folder(&files.folder).map_err(system(&shown, "sync"))?;
        }
        Ok(())
    }
}

/// Makes a file, for the user alone until it has the permissions of the one that it replaces.
#[cfg(unix)]
fn create(path: &Path, replaces: bool) -> std::io::Result<File> {
    use std::os::unix::fs::OpenOptionsExt;
    let mode = if replaces { 0o600 } else { 0o666 };
    let mut options = OpenOptions::new();
    options.write(true).create_new(true).mode(mode).open(path)
}

#[cfg(not(unix))]
fn create(path: &Path, _replaces: bool) -> std::io::Result<File> {
    OpenOptions::new().write(true).create_new(true).open(path)
}

/// Gives a file the permissions of another one, and its owner and group where the system permits.
#[cfg(unix)]
fn keep_owner_and_permissions(file: &File, replaced: &Metadata) -> std::io::Result<()> {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, fchown};
    let created = file.metadata()?;
    let (owner, group) = (replaced.uid(), replaced.gid());
    let mut mode = replaced.mode() & 0o777;
    let is_same = (owner, group) == (created.uid(), created.gid());
    if !is_same
        && fchown(file, Some(owner), Some(group)).is_err()
        && group != created.gid()
        && fchown(file, None, Some(group)).is_err()
    {
        // The members of another group may do what the group and all others might.
        mode &= 0o707 | (mode & 0o007) << 3;
    }
    file.set_permissions(std::fs::Permissions::from_mode(mode))
}

#[cfg(not(unix))]
fn keep_owner_and_permissions(file: &File, replaced: &Metadata) -> std::io::Result<()> {
    file.set_permissions(replaced.permissions())
}

/// Makes the names in a folder durable, where the system can.
fn sync_folder(folder: &Path) -> Result<(), Error> {
    // A folder that may be written into, but not read, cannot be opened, nor can one on Windows.
    let Ok(opened) = File::open(folder) else {
        return Ok(());
    };
    match opened.sync_all() {
        Err(error)
            if matches!(
                error.kind(),
                ErrorKind::InvalidInput | ErrorKind::Unsupported
            ) =>
        {
            Ok(())
        }
        other => other,
    }
}

/// Writes a file beside its name and renames it, so that a failure leaves nothing behind. Makes its
/// folder.
///
/// # Errors
/// [`IoError::System`], or what `content` returns.
pub fn write_atomically(
    path: &Path,
    content: impl FnOnce(&mut dyn WriteSeek) -> Result<(), IoError>,
) -> Result<(), IoError> {
    let mut files = PendingFiles::default();
    files.add(path, content)?;
    files.place()
}

/// Writes several files, each beside its name, and renames them when all are written: a failure
/// leaves every file as it was, unless a renaming fails behind others.
///
/// # Errors
/// [`IoError::System`].
pub fn write_all_whole(files: &[(PathBuf, Vec<u8>)]) -> Result<(), IoError> {
    let mut pending = PendingFiles::default();
    for (path, bytes) in files {
        pending.add_bytes(path, bytes)?;
    }
    pending.place()
}

/// Every extension that asks for a format that is written.
pub fn writable_extensions() -> Vec<&'static str> {
    let extensions = FORMATS
        .iter()
        .flat_map(|format| format.written_extensions());
    let mut all: Vec<&'static str> = extensions.copied().collect();
    let mut known = BTreeSet::new();
    all.retain(|extension| known.insert(*extension));
    all
}

/// Writes what a source holds in the format that the path's extension asks for, with
/// [`write_atomically`].
///
/// # Errors
/// [`IoError::Unwritable`] for an extension that no format has; as [`Format::write`].
pub fn write_path(
    path: &Path,
    source: &mut dyn Source,
    options: WriteOptions,
) -> Result<Vec<Finding>, IoError> {
    let (format, options) = format_for(path, source, options)?;
    let mut findings = Vec::new();
    write_atomically(path, |out| {
        findings = format.write(out, source, &options)?;
        Ok(())
    })?;
    Ok(findings)
}

/// The bytes that [`write_path`] would write, for a file that is put in place together with others.
///
/// # Errors
/// As [`write_path`].
pub fn bytes_for_path(
    path: &Path,
    source: &mut dyn Source,
    options: WriteOptions,
) -> Result<(Vec<u8>, Vec<Finding>), IoError> {
    let (format, options) = format_for(path, source, options)?;
    let mut bytes = std::io::Cursor::new(Vec::new());
    let findings = format.write(&mut bytes, source, &options)?;
    Ok((bytes.into_inner(), findings))
}

/// The format that a path's extension asks for, with the path in the options.
fn format_for(
    path: &Path,
    source: &dyn Source,
    options: WriteOptions,
) -> Result<(&'static dyn Format, WriteOptions), IoError> {
    let options = WriteOptions {
        path: path.display().to_string(),
        ..options
    };
    let extension = path.extension().and_then(|extension| extension.to_str());
    let extension = extension.unwrap_or("").to_lowercase();
    let of_extension =
        |format: &&&dyn Format| format.written_extensions().contains(&extension.as_str());
    let mut formats = FORMATS
        .iter()
        .copied()
        .filter(|format| of_extension(&format));
    let format = formats.find(|format| format.takes(source.catalog()));
    let format = format.ok_or_else(|| IoError::Unwritable {
        path: options.path.clone(),
        what: "a file of this extension",
        got: format!("{extension:?}"),
        expected: writable_extensions().join(", "),
    })?;
    Ok((format, options))
}

/// The contents of a new file.
#[derive(Clone, Copy, Debug)]
pub enum NewFile<'a> {
    /// This text.
    Text(&'a str),
    /// A copy of the file at this path.
    CopyOf(&'a Path),
}

/// Writes files of which none may be there, each beside its name, and renames them when all are
/// written. A failure leaves none of them, nor a folder that was made for them.
///
/// # Errors
/// [`IoError::System`], also when one of the files exists.
pub fn write_all_new(files: &[(PathBuf, NewFile)]) -> Result<(), IoError> {
    let mut pending = PendingFiles::default();
    for (path, content) in files {
        let shown = path.display().to_string();
        if std::fs::symlink_metadata(path).is_ok() {
            return Err(system(&shown, "create")(ErrorKind::AlreadyExists.into()));
        }
        pending.add(path, |out| match content {
            NewFile::Text(text) => out
                .write_all(text.as_bytes())
                .map_err(system(&shown, "write")),
            NewFile::CopyOf(from) => copy(from, out),
        })?;
    }
    pending.place_new()
}

fn copy(from: &Path, out: &mut dyn WriteSeek) -> Result<(), IoError> {
    let name = from.display().to_string();
    let mut file = open_input(from).map_err(system(&name, "copy"))?;
    std::io::copy(&mut file, out).map_err(system(&name, "copy"))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::{sha256_hex, sha256_of_bytes};

    #[test]
    fn a_failing_writer_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("result.json");
        let fail = |out: &mut dyn WriteSeek| {
            out.write_all(b"half").unwrap();
            Err(IoError::NotStated {
                path: String::new(),
                what: "unit".to_owned(),
                expected: String::new(),
            })
        };
        assert!(write_atomically(&path, fail).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn new_files_are_written_all_or_none_and_overwrite_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("there.txt"), "of an earlier day").unwrap();
        let (there, gone) = (path("there.txt"), path("gone.txt"));
        let first = (path("a/raw/first.txt"), NewFile::CopyOf(&there));
        for last in [
            (path("there.txt"), NewFile::Text("new")),
            (path("a/last.txt"), NewFile::CopyOf(&gone)),
        ] {
            assert!(write_all_new(&[first.clone(), last]).is_err());
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
            assert_eq!(std::fs::read(&there).unwrap(), b"of an earlier day");
        }
        let last = (path("a/last.txt"), NewFile::Text("new"));
        write_all_new(&[first, last]).unwrap();
        assert_eq!(std::fs::read(path("a/last.txt")).unwrap(), b"new");
        assert_eq!(
            std::fs::read(path("a/raw/first.txt")).unwrap(),
            b"of an earlier day"
        );
    }

    #[test]
    fn a_written_file_holds_its_text_and_its_known_fingerprint() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/abc.txt");
        write_all_whole(&[(path.clone(), b"abc".to_vec())]).unwrap();
        // FIPS 180-4, example of "abc".
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256_hex(&path).unwrap(), expected);
        assert_eq!(sha256_of_bytes(b"abc"), expected);
    }
}
