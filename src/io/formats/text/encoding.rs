//! Text files in blocks of whole lines, whatever their encoding and line ends.
//!
//! UTF-8 and Latin-1 pass as bytes, a byte order mark left away; UTF-16 (with its mark, as
//! spreadsheets and LabVIEW export it) becomes UTF-8. A line ends with LF or CR LF, or with CR in a
//! file without LF.

use std::io::{Cursor, Read, SeekFrom};

use crate::io::{IoError, ReadSeek};

/// Bytes of one block, enough for several threads; a longer line makes a longer block.
const BLOCK: usize = 1 << 22;

/// A text file, block by block.
pub(super) struct TextBlocks {
    input: Box<dyn Read>,
    path: String,
    file_len: u64,
    buffer: Vec<u8>,
    filled: usize,
    given: usize,
    /// Bytes of the block whose lines were taken.
    taken: usize,
    /// Lines taken.
    line: u64,
    ended: bool,
    line_end: Option<u8>,
}

impl TextBlocks {
    /// Starts at the beginning of the file, behind its byte order mark.
    ///
    /// # Errors
    /// [`IoError::System`] when it cannot be read.
    pub fn new(input: Box<dyn ReadSeek>, path: &str) -> Result<Self, IoError> {
        let (input, file_len) = decoded(input).map_err(|source| system(path, source))?;
        Ok(Self {
            input,
            path: path.to_owned(),
            file_len,
            buffer: Vec::new(),
            filled: 0,
            given: 0,
            taken: 0,
            line: 0,
            ended: false,
            line_end: None,
        })
    }

    /// Length of the file, bytes.
    pub fn file_len(&self) -> u64 {
        self.file_len
    }

    /// The byte that ends a line.
    pub fn line_end(&self) -> u8 {
        self.line_end.unwrap_or(b'\n')
    }

    /// Reads the next block, which ends with a line end or with the file; false at the end.
    ///
    /// # Errors
    /// [`IoError::System`] when the file cannot be read.
    pub fn advance(&mut self) -> Result<bool, IoError> {
        self.buffer.copy_within(self.given..self.filled, 0);
        self.filled -= self.given;
        (self.given, self.taken) = (0, 0);
        let mut searched = 0;
        loop {
            self.fill()?;
            let read = &self.buffer[..self.filled];
            let end = *self.line_end.get_or_insert_with(|| line_end_of(read));
            if self.ended {
                self.given = self.filled;
            } else if let Some(at) = memchr::memrchr(end, &read[searched..]) {
                self.given = searched + at + 1;
            } else {
                searched = self.filled;
                continue;
            }
            return Ok(self.given > 0);
        }
    }

    /// The block that was read last.
    pub fn block(&self) -> &[u8] {
        &self.buffer[..self.given]
    }

    /// The next line without its end, and its number from 1; `None` at the end of the file.
    ///
    /// # Errors
    /// [`IoError::System`] when the file cannot be read.
    pub fn next_line(&mut self) -> Result<Option<(u64, &[u8])>, IoError> {
        if self.taken == self.given && !self.advance()? {
            return Ok(None);
        }
        let rest = &self.buffer[self.taken..self.given];
        let end = memchr::memchr(self.line_end.unwrap_or(b'\n'), rest);
        self.taken += end.map_or(rest.len(), |end| end + 1);
        self.line += 1;
        let line = &rest[..end.unwrap_or(rest.len())];
        Ok(Some((self.line, line.strip_suffix(b"\r").unwrap_or(line))))
    }

    /// Lines that [`TextBlocks::next_line`] took.
    pub fn line(&self) -> u64 {
        self.line
    }

    /// The lines of the block that were not taken yet, in one piece; those of the next block where
    /// all were taken; `None` at the end of the file.
    ///
    /// # Errors
    /// [`IoError::System`] when the file cannot be read.
    pub fn rest_of_block(&mut self) -> Result<Option<&[u8]>, IoError> {
        if self.taken == self.given && !self.advance()? {
            return Ok(None);
        }
        let rest = &self.buffer[self.taken..self.given];
        self.taken = self.given;
        Ok(Some(rest))
    }

    /// Fills the buffer; where it is full already it becomes twice as long.
    fn fill(&mut self) -> Result<(), IoError> {
        if self.filled == self.buffer.len() {
            let first = usize::try_from(self.file_len).map_or(BLOCK, |len| len.min(BLOCK) + 1);
            let longer = (2 * self.filled).max(first);
            self.buffer.resize(longer, 0);
        }
        while !self.ended && self.filled < self.buffer.len() {
            match self.input.read(&mut self.buffer[self.filled..]) {
                Ok(0) => self.ended = true,
                Ok(count) => self.filled += count,
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                Err(source) => return Err(system(&self.path, source)),
            }
        }
        Ok(())
    }
}

fn system(path: &str, source: std::io::Error) -> IoError {
    IoError::System {
        path: path.to_owned(),
        action: "read",
        source,
    }
}

fn line_end_of(head: &[u8]) -> u8 {
    let has = |byte| memchr::memchr(byte, head).is_some();
    if !has(b'\n') && has(b'\r') {
        b'\r'
    } else {
        b'\n'
    }
}

/// A reader of the text behind the byte order mark, and the length of the file.
fn decoded(mut input: Box<dyn ReadSeek>) -> std::io::Result<(Box<dyn Read>, u64)> {
    let file_len = input.seek(SeekFrom::End(0))?;
    input.seek(SeekFrom::Start(0))?;
    let mut mark = Vec::with_capacity(3);
    input.by_ref().take(3).read_to_end(&mut mark)?;
    let (start, big_endian) = match mark.as_slice() {
        [0xef, 0xbb, 0xbf] => (3, None),
        [0xff, 0xfe, ..] => (2, Some(false)),
        [0xfe, 0xff, ..] => (2, Some(true)),
        _ => (0, None),
    };
    input.seek(SeekFrom::Start(start))?;
    Ok(match big_endian {
        None => (Box::new(input), file_len),
        Some(big_endian) => (Box::new(Utf16::new(input, big_endian)), file_len),
    })
}

/// UTF-16 read as UTF-8.
struct Utf16 {
    input: Box<dyn ReadSeek>,
    big_endian: bool,
    raw: Vec<u8>,
    text: Vec<u8>,
    given: usize,
}

impl Utf16 {
    fn new(input: Box<dyn ReadSeek>, big_endian: bool) -> Self {
        Self {
            input,
            big_endian,
            raw: Vec::new(),
            text: Vec::new(),
            given: 0,
        }
    }

    /// Decodes the next bytes; what is half a character waits for the rest.
    fn decode(&mut self) -> std::io::Result<()> {
        let waiting = self.raw.len();
        let piece = &mut self.input.by_ref().take(1 << 16);
        let ended = piece.read_to_end(&mut self.raw)? == 0;
        let unit = |pair: &[u8]| match self.big_endian {
            true => u16::from_be_bytes([pair[0], pair[1]]),
            false => u16::from_le_bytes([pair[0], pair[1]]),
        };
        let mut units: Vec<u16> = self.raw.chunks_exact(2).map(unit).collect();
        let half = units.last().is_some_and(|last| last & 0xfc00 == 0xd800);
        if half && !ended {
            units.pop();
        }
        self.raw.drain(..2 * units.len());
        if ended && waiting > 0 {
            self.raw.clear();
        }
        self.text.clear();
        self.given = 0;
        for character in char::decode_utf16(units) {
            let character = character.unwrap_or(char::REPLACEMENT_CHARACTER);
            let mut bytes = [0; 4];
            self.text
                .extend_from_slice(character.encode_utf8(&mut bytes).as_bytes());
        }
        Ok(())
    }
}

impl Read for Utf16 {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        if self.given == self.text.len() {
            self.decode()?;
        }
        let count = out.len().min(self.text.len() - self.given);
        out[..count].copy_from_slice(&self.text[self.given..self.given + count]);
        self.given += count;
        Ok(count)
    }
}

/// The first lines of a file of which these are the first bytes; empty ones where there are fewer.
pub(super) fn first_lines<const COUNT: usize>(head: &[u8]) -> [Vec<u8>; COUNT] {
    let mut text = Vec::new();
    // A head in memory is always read.
    let decoded = decoded(Box::new(Cursor::new(head.to_vec())));
    let read = decoded.and_then(|(mut input, _)| input.read_to_end(&mut text));
    let mut lines = lines(&text, line_end_of(&text)).filter(|_| read.is_ok());
    std::array::from_fn(|_| lines.next().unwrap_or_default().to_vec())
}

/// Lines of a block without their ends.
pub(super) fn lines(block: &[u8], line_end: u8) -> impl Iterator<Item = &[u8]> {
    let mut rest = Some(block.strip_suffix(&[line_end]).unwrap_or(block));
    std::iter::from_fn(move || {
        let here = rest?;
        let end = memchr::memchr(line_end, here);
        rest = end.map(|end| &here[end + 1..]);
        let line = &here[..end.unwrap_or(here.len())];
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    })
}

/// Text of bytes: UTF-8, or Latin-1 where they are not.
pub(super) fn text_of(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|byte| char::from(*byte)).collect(),
    }
}

/// Whether the first bytes of a file are text: UTF-8, Latin-1, or UTF-16 with its mark.
pub(super) fn is_text(head: &[u8]) -> bool {
    let text = |byte: &u8| matches!(byte, b'\t' | b'\n' | b'\r' | 0x20..=0x7e | 0x80..=0xff);
    let utf16 = |big_endian: bool| {
        head[2..].chunks_exact(2).all(|pair| {
            let (high, low) = if big_endian {
                (pair[0], pair[1])
            } else {
                (pair[1], pair[0])
            };
            high != 0 || text(&low)
        })
    };
    match head {
        [0xff, 0xfe, ..] => utf16(false),
        [0xfe, 0xff, ..] => utf16(true),
        _ => head.iter().all(text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn whole(bytes: &[u8]) -> (Vec<u8>, u8) {
        let mut blocks = TextBlocks::new(Box::new(Cursor::new(bytes.to_vec())), "t")
            .expect("text in memory can be read");
        let mut text = Vec::new();
        while blocks.advance().expect("text in memory can be read") {
            text.extend_from_slice(blocks.block());
        }
        (text, blocks.line_end())
    }

    #[test]
    fn every_encoding_gives_its_text() {
        assert_eq!(whole(b"\xef\xbb\xbfa\nb"), (b"a\nb".to_vec(), b'\n'));
        assert_eq!(whole(b"a\rb\r"), (b"a\rb\r".to_vec(), b'\r'));
        assert_eq!(whole(b""), (Vec::new(), b'\n'));
        let text = "m/s² µ \u{1f528}\r\n".repeat(20_000);
        for big_endian in [false, true] {
            let mark = if big_endian {
                [0xfe, 0xff]
            } else {
                [0xff, 0xfe]
            };
            let mut bytes = mark.to_vec();
            for unit in text.encode_utf16() {
                let pair = if big_endian {
                    unit.to_be_bytes()
                } else {
                    unit.to_le_bytes()
                };
                bytes.extend(pair);
            }
            assert!(is_text(&bytes[..4096]));
            assert_eq!(whole(&bytes).0, text.as_bytes());
        }
        // Half a character at the end of the file.
        assert_eq!(
            whole(&[0xff, 0xfe, b'a', 0, 0x00, 0xd8, 7]).0,
            "a\u{fffd}".as_bytes()
        );
        assert!(!is_text(&[0xff, 0xfe, 0, 0]) && !is_text(b"a\0b"));
    }

    #[test]
    fn a_block_holds_whole_lines_however_long_they_are() {
        let mut text = b"short\n".to_vec();
        text.extend(vec![b'x'; 3 * BLOCK]);
        text.extend(b"\nend");
        let mut blocks = TextBlocks::new(Box::new(Cursor::new(text.clone())), "t")
            .expect("text in memory can be read");
        let mut sizes = Vec::new();
        while blocks.advance().expect("text in memory can be read") {
            sizes.push(blocks.block().len());
        }
        assert_eq!(sizes, [6, text.len() - 6]);
    }

    #[test]
    fn lines_lose_their_ends_alone() {
        let of = |text: &'static [u8], end| lines(text, end).collect::<Vec<_>>();
        assert_eq!(of(b"a\r\n\nb\n", b'\n'), [&b"a"[..], b"", b"b"]);
        assert_eq!(of(b"a\rb", b'\r'), [&b"a"[..], b"b"]);
        assert_eq!(text_of(b"m/s\xb2"), "m/s²");
    }
}
