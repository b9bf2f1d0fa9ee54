//! `.npy`: one array. It has no name in the file, so it takes the file's; the fields of a
//! structured one are listed as `name/field`.

use std::io::{Read, SeekFrom};
use std::path::Path;

use crate::io::formats::arrays::source::open_arrays;
use crate::io::formats::arrays::store::bytes::{count, groups_to_row_major};
use crate::io::formats::arrays::store::{ArrayStore, Elements, NamedArray};
use crate::io::{ArrayInfo, Confidence, Format, Hints, IoError, ReadSeek, Source};

use super::header::{Header, MAGIC};
use super::record::Column;

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
        list: header.infos(&name),
        input,
        header,
        bytes,
        path: path.to_owned(),
    }))
}

/// Records are read in blocks of about so many bytes, so that one field of many takes the memory of
/// its elements alone; much less makes many small reads.
const BLOCK_BYTES: usize = 1 << 20;

impl Header {
    /// The entries of the list of arrays, one for each column.
    pub fn infos(&self, name: &str) -> Vec<ArrayInfo> {
        let columns = self.record.columns.iter();
        let info = |column: &Column| ArrayInfo {
            name: match column.name.as_str() {
                "" => name.to_owned(),
                field => format!("{name}/{field}"),
            },
            shape: self.column_shape(column),
            kind: column.item.kind(),
        };
        columns.map(info).collect()
    }

    /// Lengths of a column.
    pub fn column_shape(&self, column: &Column) -> Vec<usize> {
        self.shape.iter().copied().chain(column.lengths()).collect()
    }

    /// Bytes that the elements of a column take, as the header says.
    pub fn bytes(&self, column: usize) -> u64 {
        let column = &self.record.columns[column];
        let lengths = self.column_shape(column);
        let size = column.item.size().unwrap_or(0) as u64;
        let multiply = |bytes: u64, length: usize| bytes.saturating_mul(length as u64);
        lengths.into_iter().fold(size, multiply)
    }

    /// Bytes of an element and the number of elements, when `available` bytes hold them.
    ///
    /// # Errors
    /// [`IoError::Truncated`] when they do not; [`IoError::Grouping`] for a type that is not read.
    pub fn checked_size(
        &self,
        column: usize,
        available: u64,
        path: &str,
    ) -> Result<(usize, usize), IoError> {
        let readable = self.record.is_readable(column);
        let size = self.record.size.filter(|_| readable);
        let size = size.ok_or_else(|| IoError::Grouping {
            path: path.to_owned(),
            what: "reading an array",
            got: self.record.columns[column].item.kind(),
            expected: "numbers or texts".to_owned(),
        })?;
        let elements = count(&self.shape);
        // The lengths that a field adds can be counted, too.
        let all = count(&self.column_shape(&self.record.columns[column]));
        let needed = all.and(elements).and_then(|count| count.checked_mul(size));
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

    /// The column of the array whose elements `input` is at. Memory grows with what is read, not
    /// with what the header promises.
    ///
    /// # Errors
    /// As [`Header::checked_size`], and what `input` returns.
    pub fn read_column(
        &self,
        column: usize,
        mut input: impl Read,
        available: u64,
        path: &str,
    ) -> Result<Elements, IoError> {
        let (size, records) = self.checked_size(column, available, path)?;
        let column = &self.record.columns[column];
        // Only lengths with a 0 among them cannot be counted: the others fit in the element.
        let lengths: Vec<usize> = column.lengths().collect();
        let group = count(&lengths).unwrap_or(0);
        let bytes = match group {
            0 => Vec::new(),
            _ if self.record.is_plain() => read_bytes(input, size * records, self.data, path)?,
            _ => {
                let mut bytes = Vec::new();
                let block = (BLOCK_BYTES / size).max(1);
                for start in (0..records).step_by(block) {
                    let at = self.data + (start * size) as u64;
                    let length = block.min(records - start) * size;
                    let read = read_bytes(&mut input, length, at, path)?;
                    for record in read.chunks_exact(size) {
                        column.append(record, &mut bytes);
                    }
                }
                bytes
            }
        };
        let elements = column.item.decode(&bytes);
        if self.fortran {
            Ok(groups_to_row_major(elements, &self.shape, group))
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

    fn can_read(&self, index: usize) -> bool {
        self.header.record.is_readable(index)
    }

    fn bytes(&self, index: usize) -> u64 {
        self.header.bytes(index)
    }

    fn file_bytes(&self) -> u64 {
        self.bytes
    }

    fn read(&mut self, index: usize) -> Result<NamedArray, IoError> {
        let available = self.available();
        seek(self.input.as_mut(), self.header.data, &self.path)?;
        let elements = self
            .header
            .read_column(index, &mut self.input, available, &self.path)?;
        let info = &self.list[index];
        Ok(NamedArray {
            name: info.name.clone(),
            shape: info.shape.clone(),
            elements,
        })
    }
}
