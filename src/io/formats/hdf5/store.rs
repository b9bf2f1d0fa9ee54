//! Reading the elements of datasets.

use std::collections::HashMap;
use std::ops::Range;

use bytemuck::cast_slice_mut;
use hdf5_pure::{Dataset, FormatError, Layout, Source, VlenStringReadOptions};

use super::element::Content;
use super::item::{Item, Presentation, bytes_of, newer_format};
use super::list::{Listing, refused, unreadable};
use super::present::{row_major, texts_of_rows};
use super::stream::Stream;
use crate::finding::Finding;
use crate::io::formats::arrays::store::bytes::{RecentArrays, Window};
use crate::io::formats::arrays::store::{ArrayStore, Elements, NamedArray, outside};
use crate::io::{ArrayInfo, IoError};

/// Deflate makes at most so many bytes of one.
const MAX_EXPANSION_RATIO: u64 = 1032;

/// Reading a dataset reads at most so many times the file's length: texts are looked up in their
/// heap one by one.
const MAX_READS_OVER_LENGTH: u64 = 64;

/// Rows are read in windows of about so many bytes.
const WINDOW: usize = 1 << 20;

/// An opened HDF5 file.
pub(in crate::io) struct Hdf5Store {
    path: String,
    stream: Stream,
    listing: Listing,
    /// The elements that were read last, for callers that read arrays part by part.
    recent: RecentArrays,
    /// For each array the end of the part that was read last.
    read_to: HashMap<usize, usize>,
}

impl Hdf5Store {
    pub(super) fn new(path: String, stream: Stream, listing: Listing) -> Self {
        Self {
            path,
            recent: RecentArrays::new(stream.bytes()),
            stream,
            listing,
            read_to: HashMap::new(),
        }
    }

    fn error(&self, index: usize, got: String) -> IoError {
        unreadable(&self.path, &self.listing.infos[index].name, got)
    }

    fn reader_error(&self, index: usize, error: &hdf5_pure::Error) -> IoError {
        match newer_format(error) {
            Some(got) => refused(&self.path, &self.listing.infos[index].name, &got),
            None => self.error(index, error.to_string()),
        }
    }

    /// Refuses a dataset whose size its bytes in the file cannot make.
    fn check_size(&mut self, index: usize) -> Result<(), IoError> {
        if self.listing.items[index].size_checked {
            return Ok(());
        }
        let item = &self.listing.items[index];
        let needed = bytes_of(&item.stored, item.stride).unwrap_or(usize::MAX) as u64;
        let held = held_bytes(&item.dataset, item.stride, self.stream.bytes());
        let held = held.map_err(|error| self.reader_error(index, &error))?;
        // Chunks that were never written hold the fill value and take no place; as many again may
        // be missing.
        let most = held
            .saturating_mul(2)
            .saturating_add(self.stream.bytes())
            .saturating_add(1 << 16);
        if needed > most {
            let shape = &item.stored;
            let got = format!(
                "{needed} bytes of shape {shape:?}, which the {held} bytes that the file holds of it cannot fill"
            );
            return Err(self.error(index, got));
        }
        self.listing.items[index].size_checked = true;
        Ok(())
    }

    /// Rows `rows` of the first stored length, in stored order.
    fn rows(&self, index: usize, rows: Range<usize>) -> Result<Elements, IoError> {
        let item = &self.listing.items[index];
        let (count, per_row) = rows_of(item);
        let empty = item.content.empty(rows.len() * per_row);
        let mut elements = empty.ok_or_else(|| self.no_numbers(index))?;
        if item.content == Content::VariableText {
            return self.variable_texts(index, count * per_row);
        }
        // A length of 0 beside a huge one makes rows without bytes, which would be read for years.
        if per_row == 0 {
            return Ok(elements);
        }
        let window = window_rows(item, per_row);
        let mut start = rows.start;
        while start < rows.end {
            let end = rows.end.min((start / window + 1) * window);
            let bytes = item
                .dataset
                .read_raw_rows(start as u64, (end - start) as u64);
            let bytes = bytes.map_err(|error| self.reader_error(index, &error))?;
            item.content.append(&bytes, item.stride, &mut elements);
            start = end;
        }
        if elements.len() != rows.len() * per_row {
            let got = format!(
                "{} elements for the shape {:?}",
                elements.len(),
                item.stored
            );
            return Err(self.error(index, got));
        }
        Ok(elements)
    }

    fn variable_texts(&self, index: usize, count: usize) -> Result<Elements, IoError> {
        let most = usize::try_from(self.stream.bytes().saturating_mul(4)).unwrap_or(usize::MAX);
        let options = VlenStringReadOptions::new()
            .with_max_elements(count)
            .with_max_payload_bytes(most);
        let texts = self.listing.items[index].dataset.read_vlen_strings(options);
        let texts = texts.map_err(|error| self.reader_error(index, &error))?;
        if texts.len() != count {
            let got = format!("{} texts, expected {count}", texts.len());
            return Err(self.error(index, got));
        }
        Ok(Elements::Text(texts))
    }

    fn no_numbers(&self, index: usize) -> IoError {
        let info = &self.listing.infos[index];
        IoError::Grouping {
            path: self.path.clone(),
            what: "reading HDF5",
            got: format!("{}: {}", info.name, info.kind),
            expected: "numbers or texts".to_owned(),
        }
    }

    /// The whole array in the order in which it is presented.
    fn whole(&mut self, index: usize) -> Result<Elements, IoError> {
        let item = &self.listing.items[index];
        if let Some(got) = &item.refusal {
            return self.read_otherwise(index, got);
        }
        if item.presentation == Presentation::Empty && item.is_readable() {
            return Ok(match (item.kind.as_str(), item.content.empty(0)) {
                ("text", _) | (_, None) => Elements::Text(Vec::new()),
                (_, Some(elements)) => elements,
            });
        }
        self.stream.allow(MAX_READS_OVER_LENGTH);
        self.check_size(index)?;
        let item = &self.listing.items[index];
        let (rows, _) = rows_of(item);
        let elements = self.rows(index, 0..rows)?;
        match item.presentation {
            Presentation::AsStored | Presentation::Empty => Ok(elements),
            Presentation::ColumnMajor => Ok(row_major(elements, &item.stored)),
            Presentation::Characters => {
                texts_of_rows(&elements, &item.stored).ok_or_else(|| self.no_numbers(index))
            }
        }
    }

    #[cfg(feature = "libhdf5")]
    fn read_otherwise(&self, index: usize, _got: &str) -> Result<Elements, IoError> {
        let item = &self.listing.items[index];
        let elements =
            super::libhdf5::read(&self.path, item).map_err(|error| self.error(index, error))?;
        match item.presentation {
            Presentation::ColumnMajor => Ok(row_major(elements, &item.stored)),
            _ => Ok(elements),
        }
    }

    #[cfg(not(feature = "libhdf5"))]
    fn read_otherwise(&self, index: usize, got: &str) -> Result<Elements, IoError> {
        Err(refused(&self.path, &self.listing.infos[index].name, got))
    }

    /// Byte and number of the elements of an array that stands in the file as it is in memory: one
    /// block of numbers of single precision.
    fn singles_at(&self, index: usize) -> Result<Option<(u64, usize)>, IoError> {
        let item = &self.listing.items[index];
        let as_in_memory = item.content.is_native_single(item.stride)
            && item.presentation == Presentation::AsStored
            && item.refusal.is_none();
        if !as_in_memory {
            return Ok(None);
        }
        let layout = item.dataset.layout();
        let count: usize = item.stored.iter().product();
        Ok(
            match layout.map_err(|error| self.reader_error(index, &error))? {
                Layout::Contiguous {
                    address: Some(address),
                    size,
                } if size == (count * size_of::<f32>()) as u64 => Some((address, count)),
                _ => None,
            },
        )
    }

    /// Reads what holds elements `range`, so that the next part is likely to be there.
    fn window(&mut self, index: usize, range: &Range<usize>) -> Result<Window, IoError> {
        let item = &self.listing.items[index];
        let by_rows = item.refusal.is_none()
            && item.content != Content::VariableText
            && (item.presentation == Presentation::AsStored
                || item.presentation == Presentation::ColumnMajor
                    && item.stored.iter().filter(|&&length| length != 1).count() <= 1);
        let (rows, per_row) = rows_of(item);
        if !by_rows || per_row == 0 {
            return Ok(Window {
                start: 0,
                elements: self.whole(index)?,
            });
        }
        // The limit holds for each pass over an array, however many parts it is read in.
        let before = self.read_to.insert(index, range.end);
        if before.is_none_or(|before| range.start < before) {
            self.stream.allow(MAX_READS_OVER_LENGTH);
        }
        self.check_size(index)?;
        let step = chunk_rows(&self.listing.items[index].dataset);
        let first = range.start / per_row / step * step;
        let last = range.end.div_ceil(per_row).div_ceil(step) * step;
        Ok(Window {
            start: first * per_row,
            elements: self.rows(index, first..last.min(rows))?,
        })
    }
}

/// Number of rows (the first stored length) and elements of each.
fn rows_of(item: &Item) -> (usize, usize) {
    let rows = item.stored.first().copied().unwrap_or(1);
    let rest = item.stored.get(1..).unwrap_or_default();
    (rows, rest.iter().product())
}

/// Chunks are decoded whole, so that rows are read by chunks.
fn chunk_rows(dataset: &Dataset) -> usize {
    let chunk = dataset.chunk_shape().ok().flatten();
    let rows = chunk.and_then(|lengths| usize::try_from(*lengths.first()?).ok());
    rows.unwrap_or(1).max(1)
}

fn window_rows(item: &Item, per_row: usize) -> usize {
    let step = chunk_rows(&item.dataset);
    let row_bytes = per_row.saturating_mul(item.stride).max(1);
    let chunks = WINDOW / row_bytes.saturating_mul(step).max(1);
    step.saturating_mul(chunks.max(1))
}

/// What is wrong with a chunk of `whole` bytes of which the file can fill `most`: the reader adds
/// its place and its lengths without a test, and goes through all of its rows.
fn chunk_error(offset: &[u64], shape: &[u64], whole: u64, most: u64) -> Option<String> {
    let is_inside = |(start, length): (&u64, &u64)| {
        let end = start.checked_add(*length);
        end.is_some_and(|end| end <= i64::MAX as u64)
    };
    if !offset.iter().zip(shape).all(is_inside) {
        return Some(format!("a chunk of {shape:?} elements at {offset:?}"));
    }
    (whole > most).then(|| {
        format!(
            "a chunk of {shape:?} elements, {whole} bytes, of which the file holds at most {most}"
        )
    })
}

/// Most bytes that what the file holds of a dataset can decode to.
fn held_bytes(dataset: &Dataset, stride: usize, file: u64) -> Result<u64, hdf5_pure::Error> {
    let chunk_shape = match dataset.layout()? {
        Layout::Compact { size } => return Ok(size),
        Layout::Contiguous { address, size } => {
            return Ok(address.map_or(0, |_| size.min(file)));
        }
        Layout::Chunked { chunk_shape, .. } => chunk_shape,
        _ => return Ok(0),
    };
    let lengths = chunk_shape.iter().copied();
    let whole = lengths.fold(stride as u64, u64::saturating_mul);
    let expansion = match dataset.filters().as_slice() {
        [] => 1,
        _ => MAX_EXPANSION_RATIO,
    };
    let chunks = dataset.chunks()?;
    // The reader would ask for the memory of a chunk before it sees that the file ends inside it.
    let outside = chunks.iter().find(|chunk| {
        let end = chunk.address.checked_add(chunk.storage_size);
        end.is_none_or(|end| end > file)
    });
    if let Some(chunk) = outside {
        let error = format!(
            "the file of {file} bytes ends inside a chunk of {} bytes at byte {}",
            chunk.storage_size, chunk.address
        );
        return Err(hdf5_pure::Error::Format(FormatError::ChunkedReadError(
            error,
        )));
    }
    let unusable = chunks.iter().find_map(|chunk| {
        let most = chunk.storage_size.saturating_mul(MAX_EXPANSION_RATIO);
        chunk_error(&chunk.offset, &chunk_shape, whole, most)
    });
    if let Some(error) = unusable {
        return Err(hdf5_pure::Error::Format(FormatError::ChunkedReadError(
            error,
        )));
    }
    let held = chunks.iter().map(|chunk| {
        let most = chunk.storage_size.min(file).saturating_mul(expansion);
        most.min(whole)
    });
    let all = held.fold(0, u64::saturating_add);
    Ok(all.min(file.saturating_mul(expansion)))
}

impl ArrayStore for Hdf5Store {
    fn list(&self) -> &[ArrayInfo] {
        &self.listing.infos
    }

    fn can_read(&self, index: usize) -> bool {
        self.listing.items[index].is_readable()
    }

    fn bytes(&self, index: usize) -> u64 {
        let item = &self.listing.items[index];
        bytes_of(&item.stored, item.stride).map_or(u64::MAX, |bytes| bytes as u64)
    }

    fn file_bytes(&self) -> u64 {
        self.stream.bytes()
    }

    fn take_damage(&mut self) -> Vec<IoError> {
        std::mem::take(&mut self.listing.damage)
    }

    fn take_findings(&mut self) -> Vec<Finding> {
        std::mem::take(&mut self.listing.findings)
    }

    fn read(&mut self, index: usize) -> Result<NamedArray, IoError> {
        let elements = self.whole(index)?;
        let info = &self.listing.infos[index];
        Ok(NamedArray {
            name: info.name.clone(),
            shape: info.shape.clone(),
            elements,
        })
    }

    fn read_singles(
        &mut self,
        index: usize,
        range: Range<usize>,
        values: &mut Vec<f32>,
    ) -> Result<bool, IoError> {
        let Some((address, count)) = self.singles_at(index)? else {
            return Ok(false);
        };
        if range.start > range.end || range.end > count {
            return Err(outside(&self.listing.infos[index].name, &range));
        }
        self.check_size(index)?;
        values.resize(range.len(), 0.0);
        self.stream.allow(MAX_READS_OVER_LENGTH);
        let byte = address.saturating_add((range.start * size_of::<f32>()) as u64);
        let read = self.stream.read_at(byte, cast_slice_mut(values));
        read.map_err(|error| self.error(index, error.to_string()))?;
        Ok(true)
    }

    fn read_part(&mut self, index: usize, range: Range<usize>) -> Result<Elements, IoError> {
        let mut recent = std::mem::take(&mut self.recent);
        let part = recent.part(index, range.clone(), || self.window(index, &range));
        self.recent = recent;
        part?.ok_or_else(|| outside(&self.listing.infos[index].name, &range))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_out_of_range_and_larger_than_the_file_are_named() {
        assert_eq!(chunk_error(&[8, 0], &[4, 2], 64, 64), None);
        for offset in [[u64::MAX - 1, 0], [0, u64::MAX >> 1]] {
            let error = chunk_error(&offset, &[4, 2], 64, 64);
            assert!(error.is_some_and(|error| error.contains(&offset[0].to_string())));
        }
        let error = chunk_error(&[0, 0], &[1 << 40, 1], 8 << 40, 64 * MAX_EXPANSION_RATIO);
        assert!(error.is_some_and(|error| error.contains("66048")));
    }
}
