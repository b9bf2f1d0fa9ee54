//! The file's bytes as the HDF5 reader asks for them, with a limit on how many.
//!
//! A few bytes of a damaged file can name the same large object many times over. The reader keeps
//! what it read, so a limit on the bytes that it may read is a limit on the memory and the time
//! that it takes.

use std::collections::BTreeMap;
use std::io::SeekFrom;
use std::sync::{Arc, Mutex, PoisonError};

use hdf5_pure::{FormatError, Source};

use crate::io::ReadSeek;

/// A stream that several handles of the reader share.
#[derive(Clone)]
pub(super) struct Stream {
    shared: Arc<Mutex<Shared>>,
    len: u64,
}

struct Shared {
    input: Box<dyn ReadSeek>,
    /// Where the input stands; unknown after an error.
    position: Option<u64>,
    /// Bytes that may still be read.
    allowed: u64,
    /// Bytes that stand in place of those of the file.
    replaced: Replacements,
}

/// Bytes that stand in place of those of a file, by the position of the first. They do not overlap,
/// so that those of a range are found without a search of all.
#[derive(Debug, Default)]
pub(super) struct Replacements {
    parts: BTreeMap<u64, Vec<u8>>,
}

impl Replacements {
    /// Adds bytes from a position on, unless they overlap others: no two parts of an intact file
    /// do.
    pub fn add(&mut self, start: u64, bytes: Vec<u8>) {
        let end = start.saturating_add(bytes.len() as u64);
        if self.within(start, end).next().is_none() {
            self.parts.insert(start, bytes);
        }
    }

    /// The parts that have bytes from `start` up to `end`, last one first.
    fn within(&self, start: u64, end: u64) -> impl Iterator<Item = (u64, &[u8])> {
        let parts = self.parts.range(..end).rev();
        let parts = parts.map(|(at, bytes)| (*at, bytes.as_slice()));
        parts.take_while(move |(at, bytes)| at + bytes.len() as u64 > start)
    }

    /// Puts the bytes in place of those that were read from `offset` on; the number of parts that
    /// were looked at.
    fn put(&self, offset: u64, out: &mut [u8]) -> usize {
        let end = offset + out.len() as u64;
        let mut parts = 0;
        for (start, bytes) in self.within(offset, end) {
            parts += 1;
            let first = offset.max(start);
            let last = end.min(start + bytes.len() as u64);
            let from = (first - start) as usize..(last - start) as usize;
            let to = (first - offset) as usize..(last - offset) as usize;
            out[to].copy_from_slice(&bytes[from]);
        }
        parts
    }
}

impl Stream {
    /// The whole of `input`, of which nothing may be read yet.
    ///
    /// # Errors
    /// The error of the input when it is asked for its length.
    pub fn new(mut input: Box<dyn ReadSeek>) -> std::io::Result<Self> {
        let len = input.seek(SeekFrom::End(0))?;
        let shared = Shared {
            input,
            position: None,
            allowed: 0,
            replaced: Replacements::default(),
        };
        Ok(Self {
            shared: Arc::new(Mutex::new(shared)),
            len,
        })
    }

    /// Number of bytes of the file.
    pub fn bytes(&self) -> u64 {
        self.len
    }

    /// Allows `times` the file's length, and 1 MiB, to be read from now on.
    pub fn allow(&self, times: u64) {
        let mut shared = self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        shared.allowed = self.len.saturating_mul(times).saturating_add(1 << 20);
    }

    /// Gives the reader these bytes in place of those of the file.
    pub fn replace(&self, replaced: Replacements) {
        let mut shared = self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        shared.replaced = replaced;
    }
}

impl Shared {
    fn read_at(&mut self, offset: u64, out: &mut [u8]) -> std::io::Result<()> {
        let position = self.position.take();
        let step = position
            .and_then(|position| i64::try_from(i128::from(offset) - i128::from(position)).ok());
        match step {
            // A short way, so that a buffered input keeps its buffer.
            Some(step) => self.input.seek_relative(step)?,
            None => drop(self.input.seek(SeekFrom::Start(offset))?),
        }
        self.input.read_exact(out)?;
        self.replaced.put(offset, out);
        self.position = Some(offset + out.len() as u64);
        Ok(())
    }
}

impl Source for Stream {
    fn len(&self) -> u64 {
        self.len
    }

    fn read_at(&self, offset: u64, out: &mut [u8]) -> Result<(), FormatError> {
        let count = out.len() as u64;
        let end = offset.checked_add(count);
        if end.is_none_or(|end| end > self.len) {
            return Err(FormatError::UnexpectedEof {
                expected: usize::try_from(end.unwrap_or(u64::MAX)).unwrap_or(usize::MAX),
                available: usize::try_from(self.len).unwrap_or(usize::MAX),
            });
        }
        let mut shared = self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        let left = shared.allowed.checked_sub(count).ok_or_else(|| {
            FormatError::Source("its structure refers to the same bytes too many times".to_owned())
        })?;
        shared.allowed = left;
        let read = shared.read_at(offset, out);
        read.map_err(|error| FormatError::Source(error.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replaced_bytes_are_put_where_they_belong() {
        let mut replaced = Replacements::default();
        replaced.add(4, vec![1, 2, 3]);
        replaced.add(7, vec![4]);
        // They overlap the first.
        replaced.add(2, vec![9, 9, 9]);
        replaced.add(6, vec![9]);
        let read = |offset: u64, count: usize| {
            let mut out = vec![0; count];
            replaced.put(offset, &mut out);
            out
        };
        assert_eq!(read(0, 10), [0, 0, 0, 0, 1, 2, 3, 4, 0, 0]);
        assert_eq!(read(5, 2), [2, 3]);
        assert_eq!(read(8, 2), [0, 0]);
        assert_eq!(read(0, 4), [0; 4]);
    }

    #[test]
    fn only_parts_of_the_range_are_looked_at() {
        let mut replaced = Replacements::default();
        for part in 0..10_000 {
            replaced.add(100 * part, vec![1; 8]);
        }
        assert_eq!(replaced.put(500_000, &mut [0; 50]), 1);
        assert_eq!(replaced.put(500_050, &mut [0; 40]), 0);
        assert_eq!(replaced.put(499_950, &mut [0; 200]), 2);
    }
}
