//! Text files in blocks of whole lines, whatever their encoding and line ends.
//!
//! UTF-8 and Latin-1 pass as bytes, a byte order mark left away; UTF-16 (as spreadsheets and
//! LabVIEW export it) becomes UTF-8. A line ends with LF or CR LF, or with CR in a file without LF.
//! NUL and Ctrl-Z at the end of the file are left away.

use std::io::{Read, SeekFrom};

use crate::io::formats::text_coding::{decoded, decoded_head};
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
    pub fn new(mut input: Box<dyn ReadSeek>, path: &str) -> Result<Self, IoError> {
        let file_len = input.seek(SeekFrom::End(0));
        let file_len = file_len.map_err(|source| system(path, source))?;
        let input = decoded(input).map_err(|source| system(path, source))?;
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
        if self.ended {
            self.filled = without_end_padding(&self.buffer[..self.filled]).len();
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

/// Text without the NUL and Ctrl-Z that DOS programs leave at the end of a file, and without the
/// blanks behind them.
fn without_end_padding(text: &[u8]) -> &[u8] {
    let is_padding = |byte: &u8| matches!(byte, 0 | 0x1a);
    let is_text = |byte: &u8| !is_padding(byte) && !byte.is_ascii_whitespace();
    let text_end = text.iter().rposition(is_text).map_or(0, |last| last + 1);
    let padding = text[text_end..].iter().position(is_padding);
    padding.map_or(text, |at| &text[..text_end + at])
}

fn line_end_of(head: &[u8]) -> u8 {
    let has = |byte| memchr::memchr(byte, head).is_some();
    if !has(b'\n') && has(b'\r') {
        b'\r'
    } else {
        b'\n'
    }
}

/// The first lines of a file of which these are the first bytes; empty ones where there are fewer.
pub(super) fn first_lines<const COUNT: usize>(head: &[u8]) -> [Vec<u8>; COUNT] {
    let text = decoded_head(head);
    let mut lines = lines(&text, line_end_of(&text));
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

/// Whether the first bytes of a file are text: UTF-8, Latin-1, or UTF-16. The characters that
/// format a text or colour it on a terminal (BEL to FF, ESC) belong to one; they are shown as
/// escapes.
pub(super) fn is_text(head: &[u8]) -> bool {
    let is_text = |byte: &u8| matches!(byte, 0x07..=b'\r' | 0x1b | 0x20..=0x7e | 0x80..=0xff);
    let head = decoded_head(head);
    // Only behind a line is padding the end of a text.
    let text = without_end_padding(&head);
    let is_line = text.iter().any(|byte| matches!(byte, b'\n' | b'\r'));
    let text = if is_line { text } else { &head };
    text.iter().all(is_text)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

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
        assert!(is_text(b"a\n1\n\x1a") && is_text(b"a\n1\n\0\0\0"));
        assert!(is_text(b"force,\x1b[31maccel\x1b[0m\n1,2\n") && is_text(b"a\x0c\n1\n"));
        assert!(!is_text(b"force\x01,a\n1,2\n"));
        assert!(!is_text(b"a\0\0") && !is_text(b"a\n\x1a1\n") && !is_text(b"\0\0"));
        for end in ["\u{1a}", "\n\0\0", "\u{1a}\u{1a}", "\r\n\u{1a}\r\n"] {
            let padded = format!("1,2\n3,4{end}");
            assert_eq!(whole(padded.as_bytes()).0.trim_ascii(), b"1,2\n3,4");
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
