//! Lines of a file with their place, and jumps over binary blocks. Knows no dataset.

use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};

use super::fields::{Position, is_delimiter};

const BUFFER_BYTES: usize = 1 << 17;
/// A line of a universal file has 80 characters; what has no end after this many bytes is cut, so that a file without
/// any line end is not taken into memory.
const LONGEST_LINE_BYTES: u64 = 1 << 16;
/// Enough for a line end, a delimiter padded to 80 columns and its line end.
const DELIMITER_WINDOW_BYTES: u64 = 128;

/// Reads lines and knows where it is.
pub(super) struct LineReader<R> {
    input: BufReader<R>,
    at: Position,
    end: u64,
}

impl<R: Read + Seek> LineReader<R> {
    /// At the start of a file.
    pub fn new(mut input: R) -> io::Result<Self> {
        let end = input.seek(SeekFrom::End(0))?;
        let start = Position {
            line: Some(1),
            byte: 0,
        };
        Self::between(input, start, end)
    }

    /// From a position to byte `end`.
    pub fn between(mut input: R, at: Position, end: u64) -> io::Result<Self> {
        input.seek(SeekFrom::Start(at.byte))?;
        let input = BufReader::with_capacity(BUFFER_BYTES, input);
        Ok(Self { input, at, end })
    }

    /// Where the next line starts.
    pub fn position(&self) -> Position {
        self.at
    }

    /// Where reading ends: the length of the file, or the end that was given.
    pub fn end(&self) -> u64 {
        self.end
    }

    /// Reads one line without its end into `line`; `None` at the end.
    pub fn read_line(&mut self, line: &mut Vec<u8>) -> io::Result<Option<Position>> {
        line.clear();
        let at = self.at;
        let most = LONGEST_LINE_BYTES.min(self.end.saturating_sub(at.byte));
        let count = (&mut self.input).take(most).read_until(b'\n', line)?;
        if count == 0 {
            return Ok(None);
        }
        self.at.byte += count as u64;
        if line.last() == Some(&b'\n') {
            self.at.line = at.line.map(|n| n + 1);
            line.pop();
        }
        if line.last() == Some(&b'\r') {
            line.pop();
        }
        Ok(Some(at))
    }

    /// Goes to a position that was read before. What is already in memory is not read again.
    pub fn go_to(&mut self, at: Position) -> io::Result<()> {
        let forward = i128::from(at.byte) - i128::from(self.at.byte);
        match i64::try_from(forward) {
            Ok(forward) => self.input.seek_relative(forward)?,
            Err(_) => drop(self.input.seek(SeekFrom::Start(at.byte))?),
        }
        self.at = at;
        Ok(())
    }

    /// Goes to a byte behind a binary block, from where on lines are not counted.
    pub fn jump_to(&mut self, byte: u64) -> io::Result<()> {
        self.go_to(Position { line: None, byte })
    }

    /// Where the delimiter starts when one stands at `byte`, directly or behind one line end. Leaves the reader anywhere.
    ///
    /// Directly behind a block it must have its four blanks, for a byte further on it still looks like one; `loose` takes
    /// it without them.
    pub fn delimiter_at(&mut self, byte: u64, loose: bool) -> io::Result<Option<u64>> {
        if byte >= self.end {
            return Ok(None);
        }
        self.jump_to(byte)?;
        let mut window = Vec::new();
        (&mut self.input)
            .take(DELIMITER_WINDOW_BYTES)
            .read_to_end(&mut window)?;
        self.at.byte += window.len() as u64;
        let behind_end = window
            .strip_prefix(b"\r\n")
            .or(window.strip_prefix(b"\n"))
            .unwrap_or(&window);
        let line = behind_end.split(|b| *b == b'\n').next().unwrap_or_default();
        let skipped = (window.len() - behind_end.len()) as u64;
        let placed = loose || skipped > 0 || line.starts_with(b"    ");
        Ok((placed && is_delimiter(line)).then_some(byte + skipped))
    }

    /// The bare stream, for samples.
    pub fn into_input(self) -> R {
        self.input.into_inner()
    }
}
