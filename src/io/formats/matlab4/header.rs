//! The header of a matrix: five whole numbers of 32 bits, and the name.
//!
//! The first number has the decimal digits MOPT: machine, 0, precision and type of the matrix. It
//! is small, so that it also shows the byte order.

use crate::io::formats::arrays::store::bytes::NumberType;

/// Bytes of the five numbers.
pub(super) const NUMBERS_BYTES: usize = 20;

/// Longest name with its closing zero. MATLAB writes 64 bytes at most and Octave more; without a
/// limit a wrong count would be read as a name (`other_bytes_are_not_taken_for_matrices`).
pub(super) const MAX_NAME_BYTES: usize = 256;

/// The content of a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Real or complex numbers.
    Full,
    /// Codes of characters.
    Text,
    /// A row of row number, column number and value for each entry, and one with the size.
    Sparse,
}

/// How the machine that wrote the file stored numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Machine {
    /// IEEE 754 and integers, least significant byte first or last.
    Ieee {
        /// Most significant byte first.
        big_endian: bool,
    },
    /// Numbers that are not read, by the name of their machine.
    Other(&'static str),
}

/// The header of a matrix with its name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub machine: Machine,
    pub number: NumberType,
    pub kind: Kind,
    pub rows: usize,
    pub columns: usize,
    pub complex: bool,
    pub name: String,
}

/// The field of a header that is wrong, and its value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct WrongField {
    pub what: &'static str,
    pub got: String,
    pub expected: &'static str,
}

fn wrong(what: &'static str, got: impl ToString, expected: &'static str) -> WrongField {
    WrongField {
        what,
        got: got.to_string(),
        expected,
    }
}

impl Header {
    /// The header at the start of `bytes`, which hold it whole.
    ///
    /// # Errors
    /// The first field that no matrix of version 4 has.
    pub fn parse(bytes: &[u8]) -> Result<Self, WrongField> {
        let (words, rest) = bytes.split_at_checked(NUMBERS_BYTES).ok_or_else(|| {
            wrong(
                "header of a matrix",
                format!("{} bytes", bytes.len()),
                "20 bytes",
            )
        })?;
        let (words, _) = words.as_chunks::<4>();
        let little = u32::from_le_bytes(words[0]);
        // Types of a little-endian machine are 0 to 52 and 2000 to 3052, of the others 1000 to 1052
        // and 4000 to 4052.
        let big_endian = little > 9999;
        let number = |word: usize| match big_endian {
            true => u32::from_be_bytes(words[word]),
            false => u32::from_le_bytes(words[word]),
        };
        let kind = number(0);
        let expected = "the digits MOPT of a matrix of version 4";
        let unknown = || wrong("type of a matrix", kind, expected);
        let machine = match (kind / 1000, big_endian) {
            (0, false) | (1, true) => Machine::Ieee { big_endian },
            (2, false) => Machine::Other("VAX D"),
            (3, false) => Machine::Other("VAX G"),
            (4, true) => Machine::Other("Cray"),
            _ => return Err(unknown()),
        };
        let stored = match kind / 10 % 100 {
            0 => NumberType::F64,
            1 => NumberType::F32,
            2 => NumberType::I32,
            3 => NumberType::I16,
            4 => NumberType::U16,
            5 => NumberType::U8,
            _ => return Err(unknown()),
        };
        let content = match kind % 10 {
            0 => Kind::Full,
            1 => Kind::Text,
            2 => Kind::Sparse,
            _ => return Err(unknown()),
        };
        let length = |word: usize| {
            let length = i32::try_from(number(word)).ok();
            let length = length.and_then(|length| usize::try_from(length).ok());
            length.ok_or_else(|| wrong("length of a matrix", number(word), "less than 2^31"))
        };
        let complex = match number(3) {
            0 => false,
            1 => true,
            other => return Err(wrong("mark of imaginary parts", other, "0 or 1")),
        };
        Ok(Self {
            machine,
            number: stored,
            kind: content,
            rows: length(1)?,
            columns: length(2)?,
            complex,
            name: name(rest, number(4))?,
        })
    }

    /// Bytes of the five numbers and the name.
    pub fn bytes(&self) -> u64 {
        (NUMBERS_BYTES + self.name.len() + 1) as u64
    }

    /// Bytes of all numbers; `None` above 2^64.
    pub fn content_bytes(&self) -> Option<u64> {
        let parts = if self.complex { 2 } else { 1 };
        let lengths = [self.columns, self.number.size(), parts];
        let multiply = |bytes: u64, length: usize| bytes.checked_mul(length as u64);
        lengths.into_iter().try_fold(self.rows as u64, multiply)
    }
}

/// The name at the start of `bytes`: a letter or `_`, then letters, digits and `_`, then a zero.
fn name(bytes: &[u8], length: u32) -> Result<String, WrongField> {
    let what = "length of the name of a matrix";
    let length = usize::try_from(length)
        .ok()
        .filter(|length| (2..=MAX_NAME_BYTES).contains(length))
        .ok_or_else(|| wrong(what, length, "2 to 256 bytes with the closing zero"))?;
    let text = bytes.get(..length).unwrap_or(bytes);
    let expected = "letters, digits and _, closed by a zero";
    let unusable = || {
        wrong(
            "name of a matrix",
            format!("{:?}", String::from_utf8_lossy(text)),
            expected,
        )
    };
    let characters = match text.split_last() {
        Some((0, characters)) if text.len() == length => characters,
        _ => return Err(unusable()),
    };
    let is_name = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
    if !characters.iter().all(is_name) || characters[0].is_ascii_digit() {
        return Err(unusable());
    }
    Ok(String::from_utf8_lossy(characters).into_owned())
}
