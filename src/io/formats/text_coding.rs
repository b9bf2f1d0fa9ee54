//! The coding of a text file: UTF-8 or Latin-1, with or without a byte order mark, or UTF-16.
//!
//! UTF-8 and Latin-1 pass as bytes; UTF-16 becomes UTF-8.

use std::borrow::Cow;
use std::io::{Cursor, Read, Seek, SeekFrom};

use encoding_rs::{Decoder, Encoding, UTF_16BE, UTF_16LE};

use crate::io::{IoError, ReadSeek};

/// Bytes of UTF-16 that are decoded at once.
const PIECE_BYTES: u64 = 1 << 16;
/// Units of UTF-16 that show the coding of a file without a mark. With fewer a file of two or three
/// small numbers of 16 bits would be text; with more a table of one short row would be none
/// (`utf_16_without_mark_is_recognised_by_its_zeros`).
const MIN_UNITS: usize = 4;

/// The coding of a text.
struct Coding {
    /// Bytes of the byte order mark.
    mark_bytes: usize,
    /// The UTF-16 that it is in.
    utf_16: Option<&'static Encoding>,
}

impl Coding {
    fn of(head: &[u8]) -> Self {
        let (mark_bytes, utf_16) = match head {
            [0xef, 0xbb, 0xbf, ..] => (3, None),
            [0xff, 0xfe, ..] => (2, Some(UTF_16LE)),
            [0xfe, 0xff, ..] => (2, Some(UTF_16BE)),
            _ if is_utf_16(head, u16::from_le_bytes) => (0, Some(UTF_16LE)),
            _ if is_utf_16(head, u16::from_be_bytes) => (0, Some(UTF_16BE)),
            _ => (0, None),
        };
        Self { mark_bytes, utf_16 }
    }
}

/// Whether bytes without a mark are text of UTF-16 in this byte order: it begins with two ASCII
/// characters, half of it or more is ASCII, and no control character stands in it.
fn is_utf_16(head: &[u8], unit: impl Fn([u8; 2]) -> u16) -> bool {
    let (pairs, _) = head.as_chunks::<2>();
    let is_ascii = |pair: &[u8; 2]| matches!(unit(*pair), 9 | 10 | 13 | 0x1a | 0x20..=0x7e);
    let is_control = |pair: &[u8; 2]| unit(*pair) < 0x80 && !is_ascii(pair);
    pairs.len() >= MIN_UNITS
        && pairs[..2].iter().all(is_ascii)
        && 2 * pairs.iter().filter(|pair| is_ascii(pair)).count() >= pairs.len()
        && !pairs.iter().any(is_control)
}

/// The first bytes of a file as UTF-8 or Latin-1, without a byte order mark.
pub(in crate::io::formats) fn decoded_head(head: &[u8]) -> Cow<'_, [u8]> {
    let coding = Coding::of(head);
    let text = &head[coding.mark_bytes..];
    match coding.utf_16 {
        None => Cow::Borrowed(text),
        Some(encoding) => {
            let (text, _) = encoding.decode_without_bom_handling(text);
            Cow::Owned(text.into_owned().into_bytes())
        }
    }
}

/// The first bytes of a file that show its coding; the file then stands at its start.
fn coding_of(input: &mut dyn ReadSeek) -> std::io::Result<Coding> {
    let mut head = Vec::new();
    input.seek(SeekFrom::Start(0))?;
    input.take(4096).read_to_end(&mut head)?;
    input.seek(SeekFrom::Start(0))?;
    Ok(Coding::of(&head))
}

/// A reader of the text behind the byte order mark.
pub(in crate::io::formats) fn decoded(
    mut input: Box<dyn ReadSeek>,
) -> std::io::Result<Box<dyn Read>> {
    let coding = coding_of(input.as_mut())?;
    input.seek(SeekFrom::Start(coding.mark_bytes as u64))?;
    Ok(match coding.utf_16 {
        None => Box::new(input),
        Some(encoding) => Box::new(Utf16::new(input, encoding)),
    })
}

/// The whole text as UTF-8 or Latin-1, without byte order mark and without the zeros and Ctrl-Z
/// that DOS programs leave at the end.
///
/// # Errors
/// [`IoError::System`] when it cannot be read.
pub(in crate::io::formats) fn decoded_bytes(
    input: Box<dyn ReadSeek>,
    path: &str,
) -> Result<Vec<u8>, IoError> {
    let mut text = Vec::new();
    let read = decoded(input).and_then(|mut input| input.read_to_end(&mut text));
    read.map_err(|source| IoError::System {
        path: path.to_owned(),
        action: "read",
        source,
    })?;
    let is_padding = |byte: &u8| matches!(byte, 0 | 0x1a) || byte.is_ascii_whitespace();
    let end = text.iter().rposition(|byte| !is_padding(byte));
    text.truncate(end.map_or(0, |end| end + 1));
    Ok(text)
}

/// A file in UTF-16 as one of UTF-8 in memory; every other file unchanged.
pub(in crate::io::formats) fn without_utf_16(
    mut input: Box<dyn ReadSeek>,
) -> std::io::Result<Box<dyn ReadSeek>> {
    if coding_of(input.as_mut())?.utf_16.is_none() {
        return Ok(input);
    }
    let mut text = Vec::new();
    decoded(input)?.read_to_end(&mut text)?;
    Ok(Box::new(Cursor::new(text)))
}

/// UTF-16 read as UTF-8; half a character becomes the replacement character.
struct Utf16 {
    input: Box<dyn ReadSeek>,
    decoder: Decoder,
    raw: Vec<u8>,
    text: Vec<u8>,
    given: usize,
    ended: bool,
}

impl Utf16 {
    fn new(input: Box<dyn ReadSeek>, encoding: &'static Encoding) -> Self {
        Self {
            input,
            decoder: encoding.new_decoder_without_bom_handling(),
            raw: Vec::new(),
            text: Vec::new(),
            given: 0,
            ended: false,
        }
    }

    /// Decodes the next bytes.
    fn decode(&mut self) -> std::io::Result<()> {
        self.raw.clear();
        self.ended = self
            .input
            .by_ref()
            .take(PIECE_BYTES)
            .read_to_end(&mut self.raw)?
            == 0;
        let room = self.decoder.max_utf8_buffer_length(self.raw.len());
        self.text.resize(room.unwrap_or_default(), 0);
        let (_, _, written, _) = self
            .decoder
            .decode_to_utf8(&self.raw, &mut self.text, self.ended);
        self.text.truncate(written);
        self.given = 0;
        Ok(())
    }
}

impl Read for Utf16 {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        while self.given == self.text.len() && !self.ended {
            self.decode()?;
        }
        let count = out.len().min(self.text.len() - self.given);
        out[..count].copy_from_slice(&self.text[self.given..self.given + count]);
        self.given += count;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn is_in_utf_16(head: &[u8]) -> bool {
        Coding::of(head).utf_16.is_some()
    }

    fn units(text: &str) -> Vec<u8> {
        text.encode_utf16().flat_map(u16::to_le_bytes).collect()
    }

    #[test]
    fn utf_16_without_mark_is_recognised_by_its_zeros() {
        for text in [
            "1 2\n",
            "    -1\n    58\n",
            "f, \u{4e2d}\u{6587}\n1,2\n3,4\n",
        ] {
            assert!(is_in_utf_16(&units(text)), "{text}");
            assert_eq!(*decoded_head(&units(text)), *text.as_bytes(), "{text}");
        }
        for bytes in [
            b"1 2\n3 4\n".to_vec(),
            b"    -1\n    58\n".to_vec(),
            vec![1, 0, 2, 0, 3, 0, 4, 0],
            units("12\u{0}45"),
            vec![0x20; 40],
        ] {
            assert!(!is_in_utf_16(&bytes), "{bytes:?}");
        }
    }

    proptest! {
        #[test]
        fn every_byte_sequence_is_decoded_to_at_most_three_halves_of_its_length(
            bytes in proptest::collection::vec(any::<u8>(), 0..300),
            mark in 0usize..4,
        ) {
            let marks: [&[u8]; 4] = [b"", b"\xff\xfe", b"\xfe\xff", b"\xef\xbb\xbf"];
            let file = [marks[mark], &bytes].concat();
            let mut text = Vec::new();
            let mut reader = decoded(Box::new(Cursor::new(file.clone()))).expect("bytes in memory");
            reader.read_to_end(&mut text).expect("bytes in memory");
            prop_assert!(2 * text.len() <= 3 * (file.len() + 1));
        }
    }
}
