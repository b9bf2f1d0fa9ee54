//! Inputs are opened when they are read, so that a test of hundreds of files needs few handles.
//!
//! A pipe is read once and kept in memory, because formats are detected and read separately. A
//! device is refused.

use std::collections::{BTreeMap, VecDeque};
use std::fs::{File, Metadata};
use std::io::{Cursor, Error, Read, Result, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use super::ReadSeek;

/// Maximum number of inputs that are open at a time. Larger: little is left of the 64 handles that
/// the tests of `writing` allow. Smaller: files that are read in turn are opened again each time.
const MAX_OPEN_INPUTS: usize = 16;

/// The name that other programs give to standard input.
const STANDARD_INPUT: &str = "-";

/// The handle of an input; `None` while it is closed.
type Handle = Mutex<Option<File>>;

/// The inputs that are open, the earliest first.
static OPEN_INPUTS: Mutex<VecDeque<Weak<Handle>>> = Mutex::new(VecDeque::new());

/// The contents of the pipes that were read.
static PIPES: Mutex<BTreeMap<PathBuf, PipeContents>> = Mutex::new(BTreeMap::new());

/// Opens a file or a pipe.
pub(super) fn open_input(path: &Path) -> Result<Box<dyn ReadSeek>> {
    if path == Path::new(STANDARD_INPUT) && !path.exists() {
        return Err(Error::other(
            "there is no file of this name; standard input is /dev/stdin",
        ));
    }
    let data = std::fs::metadata(path)?;
    if data.is_file() {
        return Ok(Box::new(FileInput::open(path)?));
    }
    if data.is_dir() {
        return Err(Error::other("it is a folder, expected a file"));
    }
    if is_device(&data) {
        return Err(Error::other("it is a device, expected a file or a pipe"));
    }
    Ok(Box::new(Cursor::new(pipe_contents(path, u64::MAX)?)))
}

/// Reads a file or a pipe.
///
/// # Errors
/// What the system refuses; a folder; a device.
pub fn read_input(path: &Path) -> Result<Vec<u8>> {
    read_input_part(path, u64::MAX)
}

/// Reads so many bytes of a file or a pipe, or all that it has.
///
/// # Errors
/// As [`read_input`].
pub fn read_input_part(path: &Path, count: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    match is_pipe(path) {
        true => bytes.extend_from_slice(pipe_contents(path, count)?.as_ref()),
        false => drop(open_input(path)?.take(count).read_to_end(&mut bytes)?),
    }
    Ok(bytes)
}

#[cfg(unix)]
fn is_device(data: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    data.file_type().is_char_device() || data.file_type().is_block_device()
}

#[cfg(not(unix))]
fn is_device(_data: &Metadata) -> bool {
    false
}

/// Whether a path leads to something that can be read once.
fn is_pipe(path: &Path) -> bool {
    let data = std::fs::metadata(path);
    data.is_ok_and(|data| !data.is_file() && !data.is_dir() && !is_device(&data))
}

/// The contents of a pipe.
#[derive(Clone)]
struct PipeContents(Arc<Vec<u8>>);

impl AsRef<[u8]> for PipeContents {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

/// What a pipe gives, at most so many bytes; kept where it is all.
fn pipe_contents(path: &Path, count: u64) -> Result<PipeContents> {
    let known = locked(&PIPES).get(path).cloned();
    if let Some(contents) = known {
        return Ok(contents);
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(count).read_to_end(&mut bytes)?;
    let is_whole = (bytes.len() as u64) < count;
    let contents = PipeContents(Arc::new(bytes));
    if is_whole {
        locked(&PIPES).insert(path.to_owned(), contents.clone());
    }
    Ok(contents)
}

/// The value behind a lock, also after a panic of its holder.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file that is closed while many others are read, and opened again.
struct FileInput {
    path: PathBuf,
    /// As it was opened first.
    stamp: Option<Stamp>,
    position: u64,
    handle: Arc<Handle>,
}

/// Length and time of a file, which show a change while the file was closed. Its number on the disk
/// is another at each opening on some file systems of a network.
type Stamp = [u64; 3];

#[cfg(unix)]
fn stamp_of(data: &Metadata) -> Stamp {
    use std::os::unix::fs::MetadataExt;
    let (seconds, nanoseconds) = (data.mtime(), data.mtime_nsec());
    let time = [seconds.cast_unsigned(), nanoseconds.cast_unsigned()];
    [data.len(), time[0], time[1]]
}

#[cfg(not(unix))]
fn stamp_of(data: &Metadata) -> Stamp {
    [data.len(), 0, 0]
}

impl FileInput {
    fn open(path: &Path) -> Result<Self> {
        let mut input = Self {
            path: path.to_owned(),
            stamp: None,
            position: 0,
            handle: Arc::default(),
        };
        // A file that may not be read is refused here.
        input.use_file(|_| Ok(()))?;
        Ok(input)
    }

    /// Acts on the file, which stands at the position.
    fn use_file<T>(&mut self, action: impl FnOnce(&mut File) -> Result<T>) -> Result<T> {
        let mut handle = locked(&self.handle);
        let file = match handle.take() {
            Some(file) => handle.insert(file),
            None => {
                let mut file = File::open(&self.path)?;
                let stamp = stamp_of(&file.metadata()?);
                if *self.stamp.get_or_insert(stamp) != stamp {
                    return Err(Error::other("the file changed while it was read"));
                }
                file.seek(SeekFrom::Start(self.position))?;
                close_the_earliest(&self.handle);
                handle.insert(file)
            }
        };
        action(file)
    }
}

/// Adds a handle to the open ones; closes the earliest of too many, but one in use.
fn close_the_earliest(opened: &Arc<Handle>) {
    let mut open = locked(&OPEN_INPUTS);
    open.retain(|handle| handle.strong_count() > 0);
    open.push_back(Arc::downgrade(opened));
    while open.len() > MAX_OPEN_INPUTS {
        let Some(earliest) = open.pop_front().and_then(|handle| handle.upgrade()) else {
            continue;
        };
        match earliest.try_lock() {
            Ok(mut handle) => *handle = None,
            Err(_) => {
                open.push_back(Arc::downgrade(&earliest));
                break;
            }
        };
    }
}

impl Read for FileInput {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let count = self.use_file(|file| file.read(buffer))?;
        self.position += count as u64;
        Ok(count)
    }
}

impl Seek for FileInput {
    fn seek(&mut self, position: SeekFrom) -> Result<u64> {
        self.position = self.use_file(|file| file.seek(position))?;
        Ok(self.position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_were_closed_in_between_are_read_on() {
        let folder = tempfile::tempdir().unwrap();
        let count = 3 * MAX_OPEN_INPUTS;
        let mut inputs = Vec::new();
        for number in 0..count {
            let path = folder.path().join(number.to_string());
            std::fs::write(&path, format!("{number:04}{number:04}")).unwrap();
            inputs.push(open_input(&path).unwrap());
        }
        for _ in 0..2 {
            for (number, input) in inputs.iter_mut().enumerate() {
                let mut part = [0; 4];
                input.read_exact(&mut part).unwrap();
                assert_eq!(part, format!("{number:04}").as_bytes());
            }
        }
        std::fs::write(folder.path().join("0"), "another length").unwrap();
        let last = inputs.len() - 1;
        inputs[last].seek(SeekFrom::Start(0)).unwrap();
        let error = inputs[0].read(&mut [0; 4]).unwrap_err();
        assert!(error.to_string().contains("changed"), "{error}");
    }
}
