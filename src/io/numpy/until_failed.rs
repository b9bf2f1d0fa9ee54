//! A writer that fails once: what is written after that goes nowhere.

use std::io::{Result, Seek, SeekFrom, Write};

/// Tells the first failure and takes everything behind it, so that an archive that is dropped for it does not fail again and say so
/// on standard error.
pub(super) struct UntilFailed<W> {
    inner: W,
    /// Where the next byte goes, and the farthest that one went: the inner writer cannot be asked once it has failed.
    place: u64,
    end: u64,
    failed: bool,
}

impl<W: Write + Seek> UntilFailed<W> {
    /// From the beginning of a writer.
    pub fn new(inner: W) -> Self {
        Self {
            inner,
            place: 0,
            end: 0,
            failed: false,
        }
    }

    fn went_to(&mut self, place: u64) -> u64 {
        self.place = place;
        self.end = self.end.max(place);
        place
    }
}

impl<W: Write + Seek> Write for UntilFailed<W> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        let result = match self.failed {
            true => Ok(bytes.len()),
            false => self.inner.write(bytes),
        };
        self.failed |= result.is_err();
        if let Ok(count) = result {
            self.went_to(self.place + count as u64);
        }
        result
    }

    fn flush(&mut self) -> Result<()> {
        let result = match self.failed {
            true => Ok(()),
            false => self.inner.flush(),
        };
        self.failed |= result.is_err();
        result
    }
}

impl<W: Write + Seek> Seek for UntilFailed<W> {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        let sink = match to {
            SeekFrom::Start(at) => at,
            SeekFrom::Current(by) => self.place.saturating_add_signed(by),
            SeekFrom::End(by) => self.end.saturating_add_signed(by),
        };
        let result = match self.failed {
            true => Ok(sink),
            false => self.inner.seek(to),
        };
        self.failed |= result.is_err();
        result.map(|place| self.went_to(place))
    }
}
