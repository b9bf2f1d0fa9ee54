//! A store whose arrays are read only where the memory has room for them.
//!
//! A compressed file of 10 MB can hold an array of 10 GB. Room is asked of the allocator before the
//! array is read, because a failed allocation in the middle ends the program.

use std::ops::Range;

use super::store::{ArrayStore, Elements, NamedArray};
use crate::finding::Finding;
use crate::io::{ArrayInfo, IoError, MatrixEntries};

/// Room for each byte of an array: the bytes of the file and the elements made from them stand in
/// memory at once.
const COPIES: u64 = 2;

/// Maximum number of bytes that deflate makes of one.
const MAX_EXPANSION: u64 = 1032;

/// Smallest array for which room is asked. Larger, at 1 GiB: an array beyond a limit of 500 MB ends
/// the program (`arrays_beyond_the_memory_are_named_before_they_are_read`). Smaller, at 1 MiB:
/// small damaged files that claim to unpack to 20 MB take that room for a moment before they are
/// refused (`readers_survive_damaged_files`).
const MIN_CHECKED_BYTES: u64 = 32 << 20;

/// A store behind the check.
pub(in crate::io) struct Limited {
    store: Box<dyn ArrayStore>,
    path: String,
}

impl Limited {
    /// The store of a file.
    pub fn new(store: Box<dyn ArrayStore>, path: &str) -> Self {
        let path = path.to_owned();
        Self { store, path }
    }

    fn check(&self, index: usize, bytes: u64) -> Result<(), IoError> {
        // What the file cannot hold, its reader refuses.
        let most = self.store.file_bytes().saturating_mul(MAX_EXPANSION);
        let is_checked = (MIN_CHECKED_BYTES..=most).contains(&bytes);
        if !is_checked || has_room(bytes.saturating_mul(COPIES)) {
            return Ok(());
        }
        Err(IoError::Memory {
            path: self.path.clone(),
            what: format!("array {:?}", self.store.list()[index].name),
            bytes,
        })
    }

    /// Bytes of one element of array `index`.
    fn element_bytes(&self, index: usize) -> u64 {
        let lengths = self.store.list()[index].shape.iter();
        let count = lengths.fold(1_u64, |count, &length| count.saturating_mul(length as u64));
        self.store.bytes(index).div_ceil(count.max(1))
    }
}

/// Whether the allocator has so many bytes.
fn has_room(bytes: u64) -> bool {
    let bytes = usize::try_from(bytes).ok();
    bytes.is_some_and(|bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok())
}

impl ArrayStore for Limited {
    fn list(&self) -> &[ArrayInfo] {
        self.store.list()
    }

    fn can_read(&self, index: usize) -> bool {
        self.store.can_read(index)
    }

    fn bytes(&self, index: usize) -> u64 {
        self.store.bytes(index)
    }

    fn file_bytes(&self) -> u64 {
        self.store.file_bytes()
    }

    fn take_damage(&mut self) -> Vec<IoError> {
        self.store.take_damage()
    }

    fn take_findings(&mut self) -> Vec<Finding> {
        self.store.take_findings()
    }

    fn read(&mut self, index: usize) -> Result<NamedArray, IoError> {
        self.check(index, self.store.bytes(index))?;
        self.store.read(index)
    }

    fn read_sparse(&mut self, index: usize) -> Result<Option<MatrixEntries>, IoError> {
        self.check(index, self.store.bytes(index))?;
        self.store.read_sparse(index)
    }

    fn read_part(&mut self, index: usize, range: Range<usize>) -> Result<Elements, IoError> {
        let bytes = self.element_bytes(index).saturating_mul(range.len() as u64);
        self.check(index, bytes)?;
        self.store.read_part(index, range)
    }

    fn read_singles(
        &mut self,
        index: usize,
        range: Range<usize>,
        values: &mut Vec<f32>,
    ) -> Result<bool, IoError> {
        let bytes = self.element_bytes(index).saturating_mul(range.len() as u64);
        self.check(index, bytes)?;
        self.store.read_singles(index, range, values)
    }
}
