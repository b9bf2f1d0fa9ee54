//! The file's bytes as the HDF5 reader asks for them, with a limit on how many.
//!
//! A few bytes of a damaged file can name the same large object many times over. The reader keeps
//! what it read, so a limit on the bytes that it may read is a limit on the memory and the time
//! that it takes.

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
    /// Bytes that stand in place of those of the file, with the position of the first.
    replaced: Vec<(u64, Vec<u8>)>,
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
            replaced: Vec::new(),
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

    /// Gives the reader these bytes, each from a position on, in place of those of the file.
    pub fn replace(&self, replaced: Vec<(u64, Vec<u8>)>) {
        let mut shared = self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        shared.replaced = replaced;
    }
}

impl Shared {
    /// Puts the replaced bytes into those that were read from `offset` on.
    fn put_replaced(&self, offset: u64, out: &mut [u8]) {
        let end = offset + out.len() as u64;
        for (start, bytes) in &self.replaced {
            let first = offset.max(*start);
            let last = end.min(start + bytes.len() as u64);
            if first < last {
                let from = (first - start) as usize..(last - start) as usize;
                let to = (first - offset) as usize..(last - offset) as usize;
                out[to].copy_from_slice(&bytes[from]);
            }
        }
    }

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
        self.put_replaced(offset, out);
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
