//! Lines of a file with their place, and jumps over binary blocks. Knows no dataset.

use std::io::{self, ErrorKind, Read, Seek, SeekFrom};

use super::delimiter::{is_delimiter, second_delimiter, without_padding};
use super::{Position, dataset_number};

/// Bytes read at once behind a jump, where a delimiter and a header are expected; each further read
/// takes twice as many.
const FIRST_BYTES: usize = 1 << 12;
/// Most bytes read at once.
const MAX_BLOCK_BYTES: usize = 1 << 18;
/// A line of a header has 80 characters. Of a longer line no more than this is kept, so that a file
/// without any line end is not taken into memory; it is passed over as the one line that it is.
const LONGEST_LINE_BYTES: usize = 1 << 16;
/// Longest padding behind a last binary block without a delimiter: a disk cluster. Longer padding
/// would take more memory to look at; with less a file that was filled up to a cluster is damaged
/// (`the_end_of_file_mark_of_dos_is_no_damage`).
const MAX_PADDING_BYTES: u64 = 1 << 16;
/// Enough for some line ends, a delimiter and the number of a dataset, both padded to 80 columns,
/// and their line ends.
const DELIMITER_WINDOW_BYTES: usize = 256;

/// Reads lines and knows where it is.
pub(in crate::io::formats::uff) struct LineReader<R> {
    input: R,
    /// Bytes around `at`; the input stands behind them.
    buffer: Vec<u8>,
    /// Where in the buffer `at` is.
    used: usize,
    next_read: usize,
    at: Position,
    end: u64,
    line_end: u8,
}

impl<R: Read + Seek> LineReader<R> {
    /// At the start of a file.
    pub fn new(mut input: R) -> io::Result<Self> {
        let end = input.seek(SeekFrom::End(0))?;
        input.seek(SeekFrom::Start(0))?;
        Ok(Self {
            input,
            buffer: Vec::new(),
            used: 0,
            next_read: FIRST_BYTES,
            at: Position {
                line: Some(1),
                byte: 0,
            },
            end,
            line_end: b'\n',
        })
    }

    /// The byte that ends the lines here.
    pub fn line_end(&self) -> u8 {
        self.line_end
    }

    /// Where the next line starts.
    pub fn position(&self) -> Position {
        self.at
    }

    /// The length of the file.
    pub fn end(&self) -> u64 {
        self.end
    }

    /// The bytes in memory from here on.
    fn unread(&self) -> &[u8] {
        &self.buffer[self.used..]
    }

    /// Reads on; nothing changes at the end of the file.
    fn fill(&mut self) -> io::Result<()> {
        self.buffer.drain(..self.used);
        self.used = 0;
        let before = self.buffer.len();
        self.buffer.resize(before + self.next_read, 0);
        let count = loop {
            match self.input.read(&mut self.buffer[before..]) {
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                other => break other,
            }
        };
        self.buffer.truncate(before + *count.as_ref().unwrap_or(&0));
        self.next_read = (2 * self.next_read).min(MAX_BLOCK_BYTES);
        count.map(|_| ())
    }

    /// Reads one line without its end into `line`; `None` at the end.
    pub fn read_line(&mut self, line: &mut Vec<u8>) -> io::Result<Option<Position>> {
        line.clear();
        let at = self.at;
        loop {
            if self.unread().is_empty() {
                self.fill()?;
            }
            let unread = &self.buffer[self.used..];
            if unread.is_empty() {
                break;
            }
            let end = memchr::memchr(self.line_end, unread);
            let text = &unread[..end.unwrap_or(unread.len())];
            let room = LONGEST_LINE_BYTES.saturating_sub(line.len());
            line.extend_from_slice(&text[..text.len().min(room)]);
            let taken = text.len() + usize::from(end.is_some());
            self.used += taken;
            self.at.byte += taken as u64;
            if end.is_some() {
                self.at.line = at.line.map(|n| n + 1);
                break;
            }
        }
        if self.at.byte == at.byte {
            return Ok(None);
        }
        while line.last() == Some(&b'\r') {
            line.pop();
        }
        Ok(Some(at))
    }

    /// As [`LineReader::read_line`], where the second of two delimiters on one line is a line. The
    /// second one must open a dataset, for they could be numbers.
    pub fn read_line_of_dataset(&mut self, line: &mut Vec<u8>) -> io::Result<Option<Position>> {
        let read = self.read_line(line)?;
        if let (Some(at), Some(second)) = (read, second_delimiter(line))
            && self.is_before_dataset_number()?
        {
            line.truncate(second);
            let byte = at.byte + second as u64;
            self.go_to(Position { byte, ..at })?;
        }
        Ok(read)
    }

    /// Whether the next line that is not blank is the number of a dataset, or there is none.
    fn is_before_dataset_number(&mut self) -> io::Result<bool> {
        let window = self.window(DELIMITER_WINDOW_BYTES)?;
        let mut lines = window.split(|byte| matches!(byte, b'\r' | b'\n'));
        let next = lines.find(|line| !without_padding(line).is_empty());
        Ok(next.is_none_or(|line| dataset_number(line).is_some()))
    }

    /// Takes the line end of the delimiter that stands here before the number of a dataset: LF, or
    /// CR alone as old Macintosh systems write it. Without both the line end stays as it is.
    pub fn adapt_line_end(&mut self) -> io::Result<()> {
        let window = self.window(DELIMITER_WINDOW_BYTES)?;
        let is_end = |byte: &u8| matches!(byte, b'\r' | b'\n');
        let text = window.split_inclusive(is_end);
        let mut lines = text.skip_while(|line| without_padding(line).is_empty());
        let Some(delimiter) = lines.next().filter(|line| is_delimiter(line)) else {
            return Ok(());
        };
        // CR CR LF is what a text conversion makes of CR LF.
        let mut line_end = delimiter.last().copied();
        let mut next = lines.next();
        while let (Some(b'\r'), Some(b"\r" | b"\n")) = (line_end, next) {
            line_end = next.and_then(|line| line.last().copied());
            next = lines.next();
        }
        let is_numbered = next.is_some_and(|line| dataset_number(line).is_some());
        if let (Some(line_end @ (b'\r' | b'\n')), true) = (line_end, is_numbered) {
            self.line_end = line_end;
        }
        Ok(())
    }

    /// The bytes in memory from here on, as many as asked for where the file has them.
    fn window(&mut self, bytes: usize) -> io::Result<&[u8]> {
        while self.unread().len() < bytes {
            let before = self.unread().len();
            self.fill()?;
            if self.unread().len() == before {
                break;
            }
        }
        let unread = self.unread();
        Ok(&unread[..unread.len().min(bytes)])
    }

    /// The bytes from `byte` on, as many as asked for where the file has them. Leaves the reader
    /// anywhere.
    pub fn bytes_at(&mut self, byte: u64, bytes: usize) -> io::Result<&[u8]> {
        self.jump_to(byte)?;
        self.window(bytes)
    }

    /// Goes to a position. What is already in memory is not read again.
    pub fn go_to(&mut self, at: Position) -> io::Result<()> {
        let first = self.at.byte - self.used as u64;
        match usize::try_from(i128::from(at.byte) - i128::from(first)) {
            Ok(used) if used <= self.buffer.len() => self.used = used,
            _ => self.seek(at.byte)?,
        }
        self.at = at;
        Ok(())
    }

    fn seek(&mut self, byte: u64) -> io::Result<()> {
        self.input.seek(SeekFrom::Start(byte))?;
        self.buffer.clear();
        (self.used, self.next_read) = (0, FIRST_BYTES);
        Ok(())
    }

    /// Goes to a byte behind a binary block, from where on lines are not counted.
    pub fn jump_to(&mut self, byte: u64) -> io::Result<()> {
        self.go_to(Position { line: None, byte })
    }

    /// Where the delimiter starts when one stands at `byte`, directly or behind line ends. Leaves
    /// the reader anywhere.
    ///
    /// Directly behind a block it must have its four blanks, for a byte further on it still looks
    /// like one; `loose` takes it without them.
    pub fn delimiter_at(&mut self, byte: u64, loose: bool) -> io::Result<Option<u64>> {
        if byte >= self.end {
            return Ok(None);
        }
        let window = self.bytes_at(byte, DELIMITER_WINDOW_BYTES)?;
        let is_end = |byte: &u8| matches!(byte, b'\r' | b'\n');
        // CR CR LF is what a text conversion makes of CR LF.
        let skipped = window
            .iter()
            .take(3)
            .take_while(|byte| is_end(byte))
            .count();
        let mut lines = window[skipped..].split(is_end);
        let line = lines.next().unwrap_or_default();
        let line = &line[..second_delimiter(line).unwrap_or(line.len())];
        let placed = loose || skipped > 0 || line.starts_with(b"    ");
        Ok((placed && is_delimiter(line)).then_some(byte + skipped as u64))
    }

    /// Whether nothing but padding stands from `byte` on. Leaves the reader anywhere.
    pub fn is_padding_to_end(&mut self, byte: u64) -> io::Result<bool> {
        if byte >= self.end || self.end - byte > MAX_PADDING_BYTES {
            return Ok(false);
        }
        let bytes = (self.end - byte) as usize;
        Ok(without_padding(self.bytes_at(byte, bytes)?).is_empty())
    }

    /// Lends the stream to read samples, and goes back to where it was.
    pub fn with_input<T>(&mut self, read: impl FnOnce(&mut R) -> T) -> io::Result<T> {
        let result = read(&mut self.input);
        self.seek(self.at.byte)?;
        Ok(result)
    }

    /// The bare stream, for samples.
    pub fn into_input(self) -> R {
        self.input
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    fn lines(bytes: Vec<u8>) -> Vec<(u64, usize)> {
        let mut reader = LineReader::new(Cursor::new(bytes)).unwrap();
        let (mut line, mut all) = (Vec::new(), Vec::new());
        while let Some(at) = reader.read_line(&mut line).unwrap() {
            all.push((at.byte, line.len()));
        }
        all
    }

    #[test]
    fn lines_of_any_length_and_ending_are_split() {
        assert_eq!(
            lines(b"a\nbc\r\n\r\r\nd".to_vec()),
            [(0, 1), (2, 2), (6, 0), (9, 1)]
        );
        assert_eq!(lines(Vec::new()), []);
        for len in [
            FIRST_BYTES - 1,
            FIRST_BYTES,
            LONGEST_LINE_BYTES,
            3 * MAX_BLOCK_BYTES,
        ] {
            let mut bytes = vec![b'7'; len];
            bytes.extend(b"\nnext\n");
            let kept = len.min(LONGEST_LINE_BYTES);
            assert_eq!(lines(bytes), [(0, kept), (len as u64 + 1, 4)]);
        }
    }

    #[test]
    fn the_line_end_is_that_of_the_next_delimiter() {
        for (text, line_end) in [
            ("    -1\n    58\n", b'\n'),
            ("    -1\r\n    58\r\n", b'\n'),
            ("    -1\r\r\n    58\r\r\n", b'\n'),
            ("    -1\r    58\r", b'\r'),
            (
                "\r\r\u{feff}    -1  \r    58b     1     2          11\r",
                b'\r',
            ),
            ("    -1\rtext\r", b'\n'),
            ("title\r    -1\r    58\r", b'\n'),
            ("", b'\n'),
        ] {
            let mut reader = LineReader::new(Cursor::new(text.as_bytes())).unwrap();
            reader.adapt_line_end().unwrap();
            assert_eq!(reader.line_end(), line_end, "{text:?}");
        }
    }

    #[test]
    fn joined_delimiters_are_two_lines_at_their_bytes() {
        let mut reader = LineReader::new(Cursor::new(b"x\n    -1    -1\n    58\n")).unwrap();
        let (mut line, mut all) = (Vec::new(), Vec::new());
        while let Some(at) = reader.read_line_of_dataset(&mut line).unwrap() {
            all.push((at.byte, at.line, String::from_utf8(line.clone()).unwrap()));
        }
        let expected = [
            (0, Some(1), "x"),
            (2, Some(2), "    -1"),
            (8, Some(2), "    -1"),
            (15, Some(3), "    58"),
        ];
        assert_eq!(
            all,
            expected.map(|(byte, line, text)| (byte, line, text.to_owned()))
        );
    }

    #[test]
    fn jumps_come_back_to_their_line() {
        let mut text = Vec::new();
        for number in 0..2_000 {
            text.extend(format!("{number:>9}\n").into_bytes());
        }
        let mut reader = LineReader::new(Cursor::new(text)).unwrap();
        let mut line = Vec::new();
        for number in [1_999_u64, 3, 4, 1_000, 0, 1_500, 1_499] {
            reader.jump_to(number * 10).unwrap();
            reader.read_line(&mut line).unwrap();
            assert_eq!(line, format!("{number:>9}").into_bytes());
            reader
                .with_input(|input| input.seek(SeekFrom::Start(7)).map(|_| ()))
                .unwrap()
                .unwrap();
            let at = reader.position();
            assert_eq!((at.byte, at.line), (number * 10 + 10, None));
        }
        assert_eq!(reader.delimiter_at(30_000, true).unwrap(), None);
    }
}
