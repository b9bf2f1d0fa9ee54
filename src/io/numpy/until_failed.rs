//! A writer that fails once: what is written after that goes nowhere.

use std::io::{Result, Seek, SeekFrom, Write};

/// Tells the first failure and takes everything behind it, so that an archive that is dropped for it does not fail again and say so
/// on standard error.
pub(super) struct UntilFailed<W> {
    inner: W,
    /// Place and end of what would be there, once writing has failed.
    failed: Option<(u64, u64)>,
}

impl<W: Write + Seek> UntilFailed<W> {
    pub fn new(inner: W) -> Self {
        Self {
            inner,
            failed: None,
        }
    }

    fn noted<T>(&mut self, result: Result<T>) -> Result<T> {
        if result.is_err() {
            let place = self.inner.stream_position().unwrap_or(0);
            self.failed = Some((place, place));
        }
        result
    }
}

impl<W: Write + Seek> Write for UntilFailed<W> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        if let Some((place, end)) = &mut self.failed {
            *place += bytes.len() as u64;
            *end = (*end).max(*place);
            return Ok(bytes.len());
        }
        let result = self.inner.write(bytes);
        self.noted(result)
    }

    fn flush(&mut self) -> Result<()> {
        if self.failed.is_some() {
            return Ok(());
        }
        let result = self.inner.flush();
        self.noted(result)
    }
}

impl<W: Write + Seek> Seek for UntilFailed<W> {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        if let Some((place, end)) = &mut self.failed {
            *place = match to {
                SeekFrom::Start(at) => at,
                SeekFrom::Current(by) => place.saturating_add_signed(by),
                SeekFrom::End(by) => end.saturating_add_signed(by),
            };
            *end = (*end).max(*place);
            return Ok(*place);
        }
        let result = self.inner.seek(to);
        self.noted(result)
    }
}
