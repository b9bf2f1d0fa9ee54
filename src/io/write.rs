//! Results become files, whole or not at all, in the format that the extension of a path asks for.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::error::system;
use super::{FORMATS, Format, IoError, Source, WriteOptions, WriteSeek};
use crate::finding::Finding;

/// Writes a file beside its name and renames it, so that a failure leaves nothing behind. Makes its
/// folder.
///
/// # Errors
/// [`IoError::System`], or what `content` returns.
pub fn write_atomically(
    path: &Path,
    content: impl FnOnce(&mut dyn WriteSeek) -> Result<(), IoError>,
) -> Result<(), IoError> {
    rename_into_place(write_temporary(path, content)?, path)
}

/// How the name of a file begins that is not whole yet.
pub const TEMPORARY_PREFIX: &str = ".modalign-";

/// A temporary file beside a path, written whole; it goes when it is dropped.
fn write_temporary(
    path: &Path,
    content: impl FnOnce(&mut dyn WriteSeek) -> Result<(), IoError>,
) -> Result<tempfile::NamedTempFile, IoError> {
    let name = path.display().to_string();
    if path.is_dir() {
        let is_folder = std::io::Error::other("it is a folder, expected a file");
        return Err(system(&name, "write")(is_folder));
    }
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(system(&name, "create the folder for it"))?;
    let mut builder = tempfile::Builder::new();
    let mut temporary = with_default_permissions(&mut builder)
        .prefix(TEMPORARY_PREFIX)
        .tempfile_in(folder)
        .map_err(system(&name, "write"))?;
    let mut buffered = std::io::BufWriter::new(temporary.as_file_mut());
    content(&mut buffered)?;
    buffered.flush().map_err(system(&name, "write"))?;
    drop(buffered);
    Ok(temporary)
}

fn rename_into_place(temporary: tempfile::NamedTempFile, path: &Path) -> Result<(), IoError> {
    let renamed = temporary.persist(path);
    renamed.map_err(|error| system(&path.display().to_string(), "rename")(error.error))?;
    Ok(())
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

/// A temporary file is private; a result is as readable as any other new file.
#[cfg(unix)]
fn with_default_permissions<'a, 'b, 'c>(
    builder: &'a mut tempfile::Builder<'b, 'c>,
) -> &'a mut tempfile::Builder<'b, 'c> {
    use std::os::unix::fs::PermissionsExt;
    builder.permissions(std::fs::Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
fn with_default_permissions<'a, 'b, 'c>(
    builder: &'a mut tempfile::Builder<'b, 'c>,
) -> &'a mut tempfile::Builder<'b, 'c> {
    builder
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
    let parents = files.iter().flat_map(|(path, _)| path.ancestors().skip(1));
    let missing: BTreeSet<PathBuf> = parents
        .filter(|folder| !folder.as_os_str().is_empty() && !folder.exists())
        .map(Path::to_path_buf)
        .collect();
    let mut placed = Vec::new();
    let result = place_new_files(files, &mut placed);
    if result.is_err() {
        // The failure is reported. A path that cannot be removed, or that holds other files by
        // now, stays.
        for path in placed {
            let _ = std::fs::remove_file(path);
        }
        // Folders within folders first.
        for folder in missing.iter().rev() {
            let _ = std::fs::remove_dir(folder);
        }
    }
    result
}

fn place_new_files<'a>(
    files: &'a [(PathBuf, NewFile)],
    placed: &mut Vec<&'a Path>,
) -> Result<(), IoError> {
    let mut written = Vec::with_capacity(files.len());
    for (path, content) in files {
        let shown = path.display().to_string();
        let temporary = write_temporary(path, |out| match content {
            NewFile::Text(text) => out
                .write_all(text.as_bytes())
                .map_err(system(&shown, "write")),
            NewFile::CopyOf(from) => copy(from, out),
        })?;
        written.push((path, temporary));
    }
    for (path, temporary) in written {
        let renamed = temporary.persist_noclobber(path);
        renamed.map_err(|error| system(&path.display().to_string(), "create")(error.error))?;
        placed.push(path);
    }
    Ok(())
}

fn copy(from: &Path, out: &mut dyn WriteSeek) -> Result<(), IoError> {
    let name = from.display().to_string();
    let mut file = File::open(from).map_err(system(&name, "copy"))?;
    std::io::copy(&mut file, out).map_err(system(&name, "copy"))?;
    Ok(())
}

/// Writes several files, each beside its name, and renames them when all are written: a failure
/// leaves every file that was there as it was.
///
/// # Errors
/// [`IoError::System`].
pub fn write_all_whole(files: &[(PathBuf, Vec<u8>)]) -> Result<(), IoError> {
    let mut written = Vec::with_capacity(files.len());
    for (path, bytes) in files {
        let shown = path.display().to_string();
        let temporary = write_temporary(path, |out| {
            out.write_all(bytes).map_err(system(&shown, "write"))
        })?;
        written.push((path, temporary));
    }
    for (path, temporary) in written {
        rename_into_place(temporary, path)?;
    }
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
