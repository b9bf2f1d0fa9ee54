//! Changes of the structure of a file: lengths, counts, offsets, links, numbers and lines of text.
//!
//! The fields are found by their values, so that every format has them: whole numbers that do not
//! exceed the size of the file in bytes, and numbers of digits in text.

use std::ops::Range;

use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Marks of universal files and spellings of no number.
const INSERTED: [&[u8]; 16] = [
    b"\n    -1\n",
    b"    -1    -1\n",
    b"    -1\x1a\0\r    58\r",
    b"\n    -1\n    58\n",
    b"\n    -1\n  2414\n",
    b"\n    -1\n    58b     1     2          11          16\n",
    b" -1.#IND nan( 1.#",
    b"nan(ind)",
    b"1.#QNAN",
    b"\xef\xbb\xbf",
    b"\xff\xfe",
    b"\x1a",
    b"\r",
    b"\0",
    b"\"",
    b"/./a/../..",
];

/// Texts in place of a number.
const NUMBERS: [&[u8]; 16] = [
    b"0",
    b"-1",
    b"1",
    b"2147483647",
    b"2147483648",
    b"4294967295",
    b"9223372036854775807",
    b"18446744073709551616",
    b"999999999999999999999999",
    b"1e308",
    b"-1e-308",
    b"1e99999",
    b"NaN",
    b"-inf",
    b"-1.#IND",
    b"1.#QNAN",
];

/// Changes one field or line.
pub fn change_structure(bytes: &mut Vec<u8>, rng: &mut ChaCha8Rng) {
    let text = bytes.iter().filter(|byte| byte.is_ascii_graphic()).count() * 2 > bytes.len();
    match (text, rng.random_range(0..8)) {
        (_, 0) => {
            let at = rng.random_range(0..=bytes.len());
            let inserted = INSERTED[rng.random_range(0..INSERTED.len())];
            drop(bytes.splice(at..at, inserted.iter().copied()));
        }
        (true, 1 | 2) => change_lines(bytes, rng),
        (true, 3..=6) => change_number(bytes, rng),
        _ => change_field(bytes, rng),
    }
}

/// Replaces a whole number that may be a length, a count, an offset or a link.
fn change_field(bytes: &mut [u8], rng: &mut ChaCha8Rng) {
    let Some(field) = random_field(bytes, rng) else {
        return;
    };
    let value = field.read(bytes);
    let size = bytes.len() as u64;
    let hostile = match rng.random_range(0..12) {
        0 => 0,
        1 => value.wrapping_sub(1),
        2 => value.wrapping_add(1),
        3 => value.wrapping_mul(2),
        4 => size,
        5 => size.wrapping_sub(field.at as u64),
        // A link to itself, or to what is around it.
        6 => (field.at as u64).wrapping_sub(rng.random_range(0..64)),
        7 => u64::MAX,
        8 => u64::MAX >> 1,
        9 => u64::MAX >> rng.random_range(0..63),
        // The value of another field: links that meet or go in circles.
        _ => random_field(bytes, rng).map_or(1, |other| other.read(bytes)),
    };
    field.write(bytes, hostile);
}

#[derive(Clone, Copy)]
struct Field {
    at: usize,
    width: usize,
    big_endian: bool,
}

impl Field {
    fn read(self, bytes: &[u8]) -> u64 {
        let bytes = bytes[self.at..self.at + self.width].iter();
        let add = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
        match self.big_endian {
            true => bytes.fold(0, add),
            false => bytes.rev().fold(0, add),
        }
    }

    fn write(self, bytes: &mut [u8], value: u64) {
        let mut number = value.to_le_bytes()[..self.width].to_vec();
        if self.big_endian {
            number.reverse();
        }
        bytes[self.at..self.at + self.width].copy_from_slice(&number);
    }
}

/// Tries of a place that holds no such number; most places hold samples.
const TRIES: usize = 64;

fn random_field(bytes: &[u8], rng: &mut ChaCha8Rng) -> Option<Field> {
    (0..TRIES).find_map(|_| {
        let width = [1, 2, 4, 8][rng.random_range(0..4)];
        let at = rng.random_range(0..bytes.len().checked_sub(width - 1).filter(|n| *n > 0)?);
        let field = Field {
            at,
            width,
            big_endian: rng.random_range(0..4) == 0,
        };
        let value = field.read(bytes);
        (value > 0 && value <= bytes.len() as u64).then_some(field)
    })
}

/// The token around a place that begins like a number.
fn random_number(bytes: &[u8], rng: &mut ChaCha8Rng) -> Option<Range<usize>> {
    let is_part = |byte: &u8| byte.is_ascii_digit() || b"+-.eE".contains(byte);
    (0..TRIES).find_map(|_| {
        let at = rng.random_range(0..bytes.len().max(1));
        bytes.get(at).filter(|byte| byte.is_ascii_digit())?;
        let before = bytes[..at].iter().rev().take_while(|byte| is_part(byte));
        let behind = bytes[at..].iter().take_while(|byte| is_part(byte));
        Some(at - before.count()..at + behind.count())
    })
}

/// Replaces a number of a text, in fields of fixed width mostly without moving what follows.
fn change_number(bytes: &mut Vec<u8>, rng: &mut ChaCha8Rng) {
    let Some(place) = random_number(bytes, rng) else {
        return;
    };
    let number = match rng.random_range(0..4) {
        0 => random_number(bytes, rng).map_or(Vec::new(), |other| bytes[other].to_vec()),
        _ => NUMBERS[rng.random_range(0..NUMBERS.len())].to_vec(),
    };
    let end = place.end;
    // A number is aligned to the right, and blanks before it make room.
    let blanks = bytes[..place.start].iter().rev();
    let blanks = blanks.take_while(|byte| **byte == b' ').count();
    let room = (place.len() + blanks).min(number.len().max(place.len()));
    let width = match rng.random() {
        true => room,
        false => place.len(),
    };
    let mut padded = vec![b' '; width.saturating_sub(number.len())];
    padded.extend(number);
    drop(bytes.splice(end - width..end, padded));
}

/// Removes, repeats, swaps, joins or cuts lines.
fn change_lines(bytes: &mut Vec<u8>, rng: &mut ChaCha8Rng) {
    let ends = |byte: &u8| *byte == b'\n' || *byte == b'\r';
    let mut lines: Vec<Vec<u8>> = bytes.split_inclusive(ends).map(<[u8]>::to_vec).collect();
    if lines.is_empty() {
        return;
    }
    let (line, other) = (
        rng.random_range(0..lines.len()),
        rng.random_range(0..lines.len()),
    );
    match rng.random_range(0..6) {
        0 => drop(lines.remove(line)),
        1 => lines.insert(other, lines[line].clone()),
        2 => lines.swap(line, other),
        3 => drop(lines[line].pop()),
        4 => lines[line].retain(|byte| *byte != b' '),
        _ => {
            let many = vec![lines[line].clone(); rng.random_range(2..40)];
            drop(lines.splice(line..line, many));
        }
    }
    *bytes = lines.concat();
}
