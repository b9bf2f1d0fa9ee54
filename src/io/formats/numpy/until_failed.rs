//! A writer that fails once: what is written after that goes nowhere.

use std::io::{Error, ErrorKind, Result, Seek, SeekFrom, Write};

/// Tells the first failure and takes everything behind it, so that an archive that is dropped for
/// it does not fail again and say so on standard error.
pub(super) struct UntilFailed<W> {
    inner: W,
    /// Where the next byte goes, and the farthest that one went: the inner writer cannot be asked
    /// once it has failed.
    place: u64,
    end: u64,
    failed: Option<Error>,
}

impl<W: Write + Seek> UntilFailed<W> {
    /// From the beginning of a writer.
    pub fn new(inner: W) -> Self {
        Self {
            inner,
            place: 0,
            end: 0,
            failed: None,
        }
    }

    /// The failure again, for callers that did not receive it.
    pub fn end(self) -> Result<()> {
        self.failed.map_or(Ok(()), Err)
    }

    /// Remembers a failure; an interrupted call is made again and is none.
    fn noted<T>(&mut self, result: Result<T>) -> Result<T> {
        if let Err(error) = &result
            && error.kind() != ErrorKind::Interrupted
        {
            self.failed = Some(again(error));
        }
        result
    }

    fn went_to(&mut self, place: u64) -> u64 {
        self.place = place;
        self.end = self.end.max(place);
        place
    }
}

/// The same error a second time.
fn again(error: &Error) -> Error {
    match error.raw_os_error() {
        Some(code) => Error::from_raw_os_error(code),
        None => Error::new(error.kind(), error.to_string()),
    }
}

impl<W: Write + Seek> Write for UntilFailed<W> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        let count = match self.failed {
            Some(_) => bytes.len(),
            None => {
                let written = self.inner.write(bytes);
                self.noted(written)?
            }
        };
        self.went_to(self.place + count as u64);
        Ok(count)
    }

    fn flush(&mut self) -> Result<()> {
        if self.failed.is_some() {
            return Ok(());
        }
        let flushed = self.inner.flush();
        self.noted(flushed)
    }
}

impl<W: Write + Seek> Seek for UntilFailed<W> {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        let place = match self.failed {
            Some(_) => match to {
                SeekFrom::Start(at) => at,
                SeekFrom::Current(by) => self.place.saturating_add_signed(by),
                SeekFrom::End(by) => self.end.saturating_add_signed(by),
            },
            None => {
                let sought = self.inner.seek(to);
                self.noted(sought)?
            }
        };
        Ok(self.went_to(place))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    /// Answers its writes with these failures, then as memory does.
    struct Faulty(Vec<ErrorKind>, Cursor<Vec<u8>>);

    impl Write for Faulty {
        fn write(&mut self, bytes: &[u8]) -> Result<usize> {
            match self.0.pop() {
                Some(kind) => Err(kind.into()),
                None => self.1.write(bytes),
            }
        }

        fn flush(&mut self) -> Result<()> {
            self.1.flush()
        }
    }

    impl Seek for Faulty {
        fn seek(&mut self, to: SeekFrom) -> Result<u64> {
            self.1.seek(to)
        }
    }

    fn faulty(kind: ErrorKind) -> UntilFailed<Faulty> {
        UntilFailed::new(Faulty(vec![kind], Cursor::default()))
    }

    #[test]
    fn an_interrupted_write_is_made_again() {
        let mut out = faulty(ErrorKind::Interrupted);
        out.write_all(b"abc").unwrap();
        assert_eq!(out.inner.1.get_ref(), b"abc");
        assert!(out.end().is_ok());
    }

    #[test]
    fn a_failure_is_returned_at_once_and_at_the_end() {
        let mut out = faulty(ErrorKind::StorageFull);
        let error = out.write_all(b"abc").unwrap_err();
        assert_eq!(error.kind(), ErrorKind::StorageFull);
        out.write_all(b"abcd").unwrap();
        assert_eq!(out.seek(SeekFrom::Current(-1)).unwrap(), 3);
        assert!(out.inner.1.get_ref().is_empty(), "nothing goes on");
        assert_eq!(out.end().unwrap_err().kind(), ErrorKind::StorageFull);
    }
}
