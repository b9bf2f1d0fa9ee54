//! `.npy`: one array. It has no name in the file, so it takes the file's.

use std::io::{Read, SeekFrom};
use std::path::Path;

use crate::io::formats::arrays::source::open_arrays;
use crate::io::formats::arrays::store::bytes::{count, to_row_major};
use crate::io::formats::arrays::store::{ArrayStore, Elements, NamedArray};
use crate::io::{ArrayInfo, Confidence, Format, Hints, IoError, ReadSeek, Source};

use super::header::{Header, MAGIC};

/// NumPy file of one array.
pub struct Npy;

impl Format for Npy {
    fn name(&self) -> &'static str {
        "npy"
    }

    fn detect(&self, head: &[u8]) -> Confidence {
        if head.starts_with(MAGIC) {
            Confidence::Certain
        } else {
            Confidence::No
        }
    }

    fn open(&self, input: Box<dyn ReadSeek>, hints: &Hints) -> Result<Box<dyn Source>, IoError> {
        open_arrays("npy", open_npy(input, &hints.path)?, hints)
    }
}

/// The array of a file under the file's name.
///
/// # Errors
/// As [`Format::open`].
pub(in crate::io) fn open_npy(
    mut input: Box<dyn ReadSeek>,
    path: &str,
) -> Result<Box<dyn ArrayStore>, IoError> {
    let header = Header::read(&mut input, path)?;
    let name = Path::new(path).file_stem();
    let name = name.map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let bytes = input.seek(SeekFrom::End(0));
    let bytes = bytes.map_err(|source| IoError::System {
        path: path.to_owned(),
        action: "read",
        source,
    })?;
    Ok(Box::new(NpyStore {
        list: vec![header.info(name)],
        input,
        header,
        bytes,
        path: path.to_owned(),
    }))
}

impl Header {
    /// The entry of the list of arrays.
    pub fn info(&self, name: String) -> ArrayInfo {
        ArrayInfo {
            name,
            shape: self.shape.clone(),
            kind: self.item.kind(),
        }
    }

    /// Bytes that the elements take, as the header says.
    pub fn bytes(&self) -> u64 {
        let lengths = self.shape.iter().map(|len| *len as u64);
        let size = self.item.size().unwrap_or(0) as u64;
        lengths.fold(size, u64::saturating_mul)
    }

    /// Bytes of an element and the number of elements, when `available` bytes hold them.
    ///
    /// # Errors
    /// [`IoError::Truncated`] when they do not; [`IoError::Grouping`] for a type that is not read.
    pub fn checked_size(&self, available: u64, path: &str) -> Result<(usize, usize), IoError> {
        let unread = || IoError::Grouping {
            path: path.to_owned(),
            what: "reading an array",
            got: self.item.kind(),
            expected: "numbers or texts".to_owned(),
        };
        let size = self.item.size().ok_or_else(unread)?;
        let elements = count(&self.shape);
        let needed = elements.and_then(|count| count.checked_mul(size));
        match elements.zip(needed) {
            Some((count, needed)) if needed as u64 <= available => Ok((size, count)),
            _ => Err(IoError::Truncated {
                path: path.to_owned(),
                byte: self.data.saturating_add(available),
                what: "an array",
                got: format!("{available} bytes"),
                expected: format!("shape {:?} of {size} bytes", self.shape),
            }),
        }
    }

    /// The array whose elements `input` is at. Memory grows with what is read, not with what the
    /// header promises.
    ///
    /// # Errors
    /// As [`Header::checked_size`], and what `input` returns.
    pub fn read_elements(
        &self,
        input: impl Read,
        available: u64,
        path: &str,
    ) -> Result<Elements, IoError> {
        let (size, count) = self.checked_size(available, path)?;
        let bytes = read_bytes(input, size * count, self.data, path)?;
        let elements = self.item.decode(&bytes);
        if self.fortran {
            Ok(to_row_major(elements, &self.shape))
        } else {
            Ok(elements)
        }
    }
}

/// Exactly `count` bytes.
pub(super) fn read_bytes(
    input: impl Read,
    count: usize,
    at: u64,
    path: &str,
) -> Result<Vec<u8>, IoError> {
    let mut bytes = Vec::new();
    let read = input.take(count as u64).read_to_end(&mut bytes);
    read.map_err(|source| IoError::System {
        path: path.to_owned(),
        action: "read an array of",
        source,
    })?;
    if bytes.len() == count {
        return Ok(bytes);
    }
    Err(IoError::Truncated {
        path: path.to_owned(),
        byte: at + bytes.len() as u64,
        what: "an array",
        got: format!("{} bytes", bytes.len()),
        expected: format!("{count} bytes"),
    })
}

struct NpyStore {
    input: Box<dyn ReadSeek>,
    header: Header,
    /// Length of the file.
    bytes: u64,
    list: Vec<ArrayInfo>,
    path: String,
}

impl NpyStore {
    fn available(&self) -> u64 {
        self.bytes.saturating_sub(self.header.data)
    }
}

fn seek(input: &mut dyn ReadSeek, byte: u64, path: &str) -> Result<(), IoError> {
    let sought = input.seek(SeekFrom::Start(byte));
    sought.map(drop).map_err(|source| IoError::System {
        path: path.to_owned(),
        action: "read",
        source,
    })
}

impl ArrayStore for NpyStore {
    fn list(&self) -> &[ArrayInfo] {
        &self.list
    }

    fn can_read(&self, _index: usize) -> bool {
        self.header.item.size().is_some()
    }

    fn bytes(&self, _index: usize) -> u64 {
        self.header.bytes()
    }

    fn read(&mut self, index: usize) -> Result<NamedArray, IoError> {
        let available = self.available();
        seek(self.input.as_mut(), self.header.data, &self.path)?;
        let elements = self
            .header
            .read_elements(&mut self.input, available, &self.path)?;
        Ok(NamedArray {
            name: self.list[index].name.clone(),
            shape: self.header.shape.clone(),
            elements,
        })
    }
}
