//! `.npz`: a zip archive of `.npy` arrays, each a member whose name without `.npy` is the array's;
//! the fields of a structured array are listed as `name/field`.
//!
//! The check sum of a member covers all of it, so that a member is read to its end before a part of
//! it is used.

use std::collections::BTreeSet;
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::sync::Arc;

use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use super::until_failed::UntilFailed;
use crate::finding::Finding;
use crate::io::formats::arrays::schema;
use crate::io::formats::arrays::source::open_arrays;
use crate::io::formats::arrays::store::bytes::{RecentArrays, Window};
use crate::io::formats::arrays::store::{ArrayStore, Elements, NamedArray, outside};
use crate::io::{
    ArrayInfo, Confidence, Format, Hints, IoError, ReadSeek, Source, WriteOptions, WriteSeek,
};

use super::header::{Header, written};
use super::items::{description, encode};
use super::npy::read_bytes;

/// The first bytes of a zip archive with members.
const ZIP_MAGIC: &[u8] = b"PK\x03\x04";

/// Where the length of a member's name stands, and where the name begins.
const NAME_LENGTH: usize = 26;
const NAME: usize = 30;

/// Deflate expands at most so many times.
const DEFLATE_EXPANSION: u64 = 1032;

/// Headers of all arrays take at most so many times the file, and 1 MiB: many members can share one
/// header, and blanks deflate well. Larger: 10,000 members that share a header of 500 kB take 5 GB.
/// Smaller than 1: small arrays are refused (`headers_are_read_to_a_limit`).
const MAX_HEADERS_OVER_FILE: u64 = 16;
const MAX_ADDITIONAL_HEADER_BYTES: u64 = 1 << 20;

/// Members of this size need the 64-bit fields of a zip archive.
const LARGE: usize = 0xffff_0000;

/// NumPy archive of named arrays.
pub struct Npz;

impl Format for Npz {
    fn name(&self) -> &'static str {
        "npz"
    }

    fn written_extensions(&self) -> &'static [&'static str] {
        &["npz"]
    }

    /// Certain for an archive whose first members are an array, or have an array behind them.
    fn detect(&self, head: &[u8]) -> Confidence {
        let starts = memchr::memmem::find_iter(head, ZIP_MAGIC);
        let is_array = |member: &[u8]| {
            let length = member.get(NAME_LENGTH..NAME_LENGTH + 2);
            let length = length.map_or(0, |bytes| {
                usize::from(u16::from_le_bytes([bytes[0], bytes[1]]))
            });
            let name = member.get(NAME..NAME + length).unwrap_or_default();
            name.ends_with(b".npy")
        };
        let mut members = starts.map(|start| &head[start..]);
        if head.starts_with(ZIP_MAGIC) && members.any(is_array) {
            Confidence::Certain
        } else {
            Confidence::No
        }
    }

    fn open(&self, input: Box<dyn ReadSeek>, hints: &Hints) -> Result<Box<dyn Source>, IoError> {
        open_arrays("npz", open_npz(input, &hints.path)?, hints)
    }

    fn write(
        &self,
        out: &mut dyn WriteSeek,
        source: &mut dyn Source,
        options: &WriteOptions,
    ) -> Result<Vec<Finding>, IoError> {
        let mut archive = ZipWriter::new(UntilFailed::new(out));
        let mut put = |array: NamedArray| {
            let member = write_member(&mut archive, &array);
            member.map_err(|source| IoError::System {
                path: options.path.clone(),
                action: "write",
                source,
            })
        };
        let findings = schema::write_with_schema(source, options.precision, &mut put)?;
        let finished = archive.finish().map_err(std::io::Error::from);
        finished
            .and_then(UntilFailed::end)
            .map_err(|source| IoError::System {
                path: options.path.clone(),
                action: "write",
                source,
            })?;
        Ok(findings)
    }
}

/// The arrays of an archive.
///
/// # Errors
/// As [`Format::open`].
pub(in crate::io) fn open_npz(
    input: Box<dyn ReadSeek>,
    path: &str,
) -> Result<Box<dyn ArrayStore>, IoError> {
    Ok(Box::new(NpzStore::open(input, path)?))
}

fn write_member<W: Write + Seek>(
    archive: &mut ZipWriter<W>,
    array: &NamedArray,
) -> std::io::Result<()> {
    let bytes = encode(&array.elements);
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::DEFAULT)
        .large_file(bytes.len() >= LARGE);
    archive.start_file(format!("{}.npy", array.name), options)?;
    archive.write_all(&written(&description(&array.elements), &array.shape))?;
    archive.write_all(&bytes)
}

/// An array of the archive, or a member of another kind.
struct Listed {
    /// The place of its member in the archive.
    member: usize,
    /// First byte of the member in the file.
    at: u64,
    /// `None` for a member that is not an array.
    header: Option<Arc<Header>>,
    /// Its column of the header.
    column: usize,
    stored: bool,
    /// Most bytes that its elements can have.
    available: u64,
}

struct NpzStore {
    /// Length of the file.
    length: u64,
    /// Bytes of headers that may still be read.
    header_bytes: u64,
    archive: ZipArchive<Box<dyn ReadSeek>>,
    arrays: Vec<Listed>,
    list: Vec<ArrayInfo>,
    damage: Vec<IoError>,
    path: String,
    recent: RecentArrays,
    /// Members whose check sum was found right.
    checked: BTreeSet<usize>,
}

fn zip_error(path: &str) -> impl Fn(ZipError) -> IoError {
    move |error| match error {
        ZipError::Io(source) => IoError::System {
            path: path.to_owned(),
            action: "read",
            source,
        },
        other => IoError::Binary {
            path: path.to_owned(),
            byte: 0,
            what: "zip archive",
            got: other.to_string(),
            expected: "members that are stored or deflated".to_owned(),
        },
    }
}

/// The error of a member whose bytes are not those that were written, at the member's place; other
/// errors as they are.
fn member_error(at: u64, error: IoError) -> IoError {
    match error {
        IoError::System { path, source, .. }
            if matches!(
                source.kind(),
                ErrorKind::InvalidData | ErrorKind::InvalidInput
            ) =>
        {
            IoError::Binary {
                path,
                byte: at,
                what: "member of the zip archive",
                got: source.to_string(),
                expected: "the bytes of its check sum: copy or export the file anew".to_owned(),
            }
        }
        other => other,
    }
}

impl NpzStore {
    fn open(mut input: Box<dyn ReadSeek>, path: &str) -> Result<Self, IoError> {
        let length = input.seek(SeekFrom::End(0));
        let length = length.map_err(|source| IoError::System {
            path: path.to_owned(),
            action: "read",
            source,
        })?;
        let archive = ZipArchive::new(input).map_err(zip_error(path))?;
        let header_bytes = length.saturating_mul(MAX_HEADERS_OVER_FILE);
        let mut store = Self {
            length,
            header_bytes: header_bytes.saturating_add(MAX_ADDITIONAL_HEADER_BYTES),
            archive,
            arrays: Vec::new(),
            list: Vec::new(),
            damage: Vec::new(),
            path: path.to_owned(),
            recent: RecentArrays::new(length),
            checked: BTreeSet::new(),
        };
        for index in 0..store.archive.len() {
            if let Err(error) = store.list_member(index) {
                store.damage.push(error);
            }
            if store.header_bytes == 0 {
                break;
            }
        }
        Ok(store)
    }

    fn list_member(&mut self, index: usize) -> Result<(), IoError> {
        let error = zip_error(&self.path);
        let mut file = self.archive.by_index(index).map_err(&error)?;
        let name = file.name().map_err(&error)?.into_owned();
        let stored = file.compression() == CompressionMethod::Stored;
        let at = file.header_start();
        let most = file.compressed_size().saturating_mul(DEFLATE_EXPANSION);
        let size = file.size().min(most);
        let Some(array) = name.strip_suffix(".npy") else {
            self.arrays.push(Listed {
                member: index,
                at,
                header: None,
                column: 0,
                stored,
                available: size,
            });
            self.list.push(ArrayInfo {
                name,
                shape: Vec::new(),
                kind: "file".to_owned(),
            });
            return Ok(());
        };
        let place = format!("{}({name})", self.path);
        let header = Header::read(&mut file, &place).map_err(|error| member_error(at, error))?;
        let left = self.header_bytes.checked_sub(header.data);
        self.header_bytes = left.unwrap_or(0);
        if left.is_none() {
            return Err(IoError::Binary {
                path: self.path.clone(),
                byte: at,
                what: "headers of arrays",
                got: "the same bytes in many members, or many that expand".to_owned(),
                expected: "fewer bytes in a file of this size".to_owned(),
            });
        }
        let header = Arc::new(header);
        for (column, info) in header.infos(array).into_iter().enumerate() {
            self.arrays.push(Listed {
                member: index,
                at,
                header: Some(Arc::clone(&header)),
                column,
                stored,
                available: size.saturating_sub(header.data),
            });
            self.list.push(info);
        }
        Ok(())
    }

    /// Header of array `index` and the path for messages.
    fn header(&self, index: usize) -> Result<(Arc<Header>, String), IoError> {
        let path = format!("{}({})", self.path, self.list[index].name);
        match &self.arrays[index].header {
            Some(header) => Ok((Arc::clone(header), path)),
            None => Err(IoError::Grouping {
                path,
                what: "reading an array",
                got: "a file of another kind".to_owned(),
                expected: "an .npy member".to_owned(),
            }),
        }
    }

    fn read_stored(&mut self, index: usize, range: Range<usize>) -> Result<Elements, IoError> {
        let (header, path) = self.header(index)?;
        self.check_member(index, &path)?;
        let listed = &self.arrays[index];
        let (size, count) = header.checked_size(listed.column, listed.available, &path)?;
        if range.start > range.end || range.end > count {
            return Err(outside(&self.list[index].name, &range));
        }
        let mut file = self
            .archive
            .by_index_seek(listed.member)
            .map_err(zip_error(&path))?;
        let first = header.data + (range.start * size) as u64;
        file.seek(SeekFrom::Start(first))
            .map_err(|source| IoError::System {
                path: path.clone(),
                action: "read",
                source,
            })?;
        let bytes = read_bytes(file, range.len() * size, first, &path)?;
        Ok(header.record.columns[listed.column].item.decode(&bytes))
    }

    /// Reads the member of an array to its end, where the archive's check sum is compared, unless
    /// that was done.
    fn check_member(&mut self, index: usize, path: &str) -> Result<(), IoError> {
        let listed = &self.arrays[index];
        if self.checked.contains(&listed.member) {
            return Ok(());
        }
        let file = self.archive.by_index(listed.member);
        let mut file = file.map_err(zip_error(path))?;
        finish(&mut file, path).map_err(|error| member_error(listed.at, error))?;
        self.checked.insert(listed.member);
        Ok(())
    }
}

impl ArrayStore for NpzStore {
    fn list(&self) -> &[ArrayInfo] {
        &self.list
    }

    fn can_read(&self, index: usize) -> bool {
        let Listed { header, column, .. } = &self.arrays[index];
        let record = header.as_ref().map(|header| &header.record);
        record.is_some_and(|record| record.is_readable(*column))
    }

    fn bytes(&self, index: usize) -> u64 {
        let Listed { header, column, .. } = &self.arrays[index];
        header.as_ref().map_or(0, |header| header.bytes(*column))
    }

    fn file_bytes(&self) -> u64 {
        self.length
    }

    fn take_damage(&mut self) -> Vec<IoError> {
        std::mem::take(&mut self.damage)
    }

    fn read(&mut self, index: usize) -> Result<NamedArray, IoError> {
        let (header, path) = self.header(index)?;
        let listed = &self.arrays[index];
        let error = zip_error(&path);
        let mut file = self.archive.by_index(listed.member).map_err(error)?;
        let elements = read_bytes(&mut file, header.data as usize, 0, &path)
            .and_then(|_| header.read_column(listed.column, &mut file, listed.available, &path))
            .and_then(|elements| finish(&mut file, &path).map(|()| elements));
        let elements = elements.map_err(|error| member_error(listed.at, error))?;
        self.checked.insert(listed.member);
        let info = &self.list[index];
        Ok(NamedArray {
            name: info.name.clone(),
            shape: info.shape.clone(),
            elements,
        })
    }

    fn read_part(&mut self, index: usize, range: Range<usize>) -> Result<Elements, IoError> {
        let listed = &self.arrays[index];
        let header = listed.header.as_ref();
        let in_order = header.is_some_and(|header| !header.fortran && header.record.is_plain());
        if listed.stored && in_order {
            return self.read_stored(index, range);
        }
        let mut recent = std::mem::take(&mut self.recent);
        let read = || {
            let elements = self.read(index)?.elements;
            Ok(Window { start: 0, elements })
        };
        let part = recent.part(index, range.clone(), read);
        self.recent = recent;
        part?.ok_or_else(|| outside(&self.list[index].name, &range))
    }
}

/// Reads to the end, where the archive's check sum is compared.
fn finish(file: &mut impl Read, path: &str) -> Result<(), IoError> {
    let copied = std::io::copy(file, &mut std::io::sink());
    copied.map(drop).map_err(|source| IoError::System {
        path: path.to_owned(),
        action: "read to its end",
        source,
    })
}
