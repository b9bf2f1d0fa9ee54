//! A MATLAB file as a container of arrays.

use std::ops::Range;

use crate::io::formats::arrays::store::bytes::{RecentArrays, Window};
use crate::io::formats::arrays::store::{ArrayStore, Elements, NamedArray, outside};
use crate::io::{ArrayInfo, IoError, MatrixEntries, ReadSeek};

use super::bytes::Bytes;
use super::elements::Reader;
use super::header::HEADER;
use super::list::{Content, Listing, Part, list};
use super::values;

/// An opened file.
pub(super) struct Matlab5Store {
    bytes: Bytes,
    big_endian: bool,
    listing: Listing,
    recent: RecentArrays,
}

/// Lists what a file holds.
pub(super) fn open(
    input: Box<dyn ReadSeek>,
    big_endian: bool,
    path: &str,
) -> Result<Matlab5Store, IoError> {
    let mut bytes = Bytes::new(input, path)?;
    let listing = list(&mut bytes, HEADER as u64, big_endian);
    Ok(Matlab5Store {
        recent: RecentArrays::new(bytes.length),
        bytes,
        big_endian,
        listing,
    })
}

impl Matlab5Store {
    /// The reader of a part whose bytes agree with their check sum.
    fn reader(&mut self, index: usize) -> Result<(Reader<'_>, Part), IoError> {
        let part = self.listing.parts[index];
        self.bytes.check(part.storage)?;
        let reader = Reader {
            bytes: &mut self.bytes,
            storage: part.storage,
            big_endian: self.big_endian,
        };
        Ok((reader, part))
    }
}

impl ArrayStore for Matlab5Store {
    fn list(&self) -> &[ArrayInfo] {
        &self.listing.infos
    }

    fn can_read(&self, index: usize) -> bool {
        self.listing.parts[index].content != Content::Unread
    }

    fn bytes(&self, index: usize) -> u64 {
        self.listing.parts[index].bytes
    }

    fn file_bytes(&self) -> u64 {
        self.bytes.length
    }

    fn take_damage(&mut self) -> Vec<IoError> {
        std::mem::take(&mut self.listing.damage)
    }

    fn read(&mut self, index: usize) -> Result<NamedArray, IoError> {
        let (mut reader, part) = self.reader(index)?;
        let (shape, elements) = values::read(&mut reader, &part)?;
        Ok(NamedArray {
            name: self.listing.infos[index].name.clone(),
            shape,
            elements,
        })
    }

    fn read_sparse(&mut self, index: usize) -> Result<Option<MatrixEntries>, IoError> {
        let (mut reader, part) = self.reader(index)?;
        values::read_sparse(&mut reader, &part)
    }

    fn read_part(&mut self, index: usize, range: Range<usize>) -> Result<Elements, IoError> {
        if values::in_one_piece(&self.listing.parts[index], &self.listing.infos[index].shape) {
            let (mut reader, part) = self.reader(index)?;
            return values::read_range(&mut reader, &part, range);
        }
        // Elements of a row lie apart, so that a part costs as much as the whole.
        let mut recent = std::mem::take(&mut self.recent);
        let read = || {
            let elements = self.read(index)?.elements;
            Ok(Window { start: 0, elements })
        };
        let part = recent.part(index, range.clone(), read);
        self.recent = recent;
        part?.ok_or_else(|| outside(&self.listing.infos[index].name, &range))
    }
}
