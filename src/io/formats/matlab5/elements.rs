//! Data elements and the header of a matrix.

use crate::io::IoError;
use crate::io::formats::arrays::store::bytes::{NumberType, count, decode, doubles};

use super::bytes::{Bytes, Storage};

/// Element types that are not numbers.
pub(super) const MATRIX: u32 = 14;
pub(super) const COMPRESSED: u32 = 15;
pub(super) const UTF8: u32 = 16;
pub(super) const UTF16: u32 = 17;
pub(super) const UTF32: u32 = 18;

/// Matrix classes.
pub(super) const CELL: u8 = 1;
pub(super) const STRUCT: u8 = 2;
pub(super) const OBJECT: u8 = 3;
pub(super) const CHAR: u8 = 4;
pub(super) const SPARSE: u8 = 5;
pub(super) const DOUBLE: u8 = 6;
pub(super) const SINGLE: u8 = 7;
pub(super) const FUNCTION: u8 = 16;
pub(super) const OPAQUE: u8 = 17;

/// Bits of the array flags.
pub(super) const COMPLEX: u32 = 0x0800;
const LOGICAL: u32 = 0x0200;

/// Most dimensions and longest name that are believed.
const MAX_DIMENSIONS: usize = 64;
pub(super) const LONGEST_NAME: usize = 4096;

/// Type of the numbers of an element.
pub(super) fn number_type(kind: u32) -> Option<NumberType> {
    Some(match kind {
        1 => NumberType::I8,
        2 => NumberType::U8,
        3 => NumberType::I16,
        4 => NumberType::U16,
        5 => NumberType::I32,
        6 => NumberType::U32,
        7 => NumberType::F32,
        9 => NumberType::F64,
        12 => NumberType::I64,
        13 => NumberType::U64,
        _ => return None,
    })
}

/// A data element of a variable.
#[derive(Clone, Copy, Debug)]
pub(super) struct Element {
    /// Its type.
    pub kind: u32,
    /// Where its bytes begin within the variable, and how many there are.
    pub data: u64,
    pub size: usize,
    /// Where the next element begins.
    pub next: u64,
}

/// Header of a matrix.
#[derive(Clone, Debug)]
pub(super) struct Matrix {
    /// Its class; 0 for a matrix element without content, which is an empty array.
    pub class: u8,
    pub complex: bool,
    pub logical: bool,
    /// Lengths, as MATLAB prints them; empty for opaque data.
    pub shape: Vec<usize>,
    /// Number of elements.
    pub count: usize,
    pub name: String,
    /// Where what the class makes of it begins, and where the matrix ends.
    pub content: u64,
    pub end: u64,
}

/// A variable that is being read.
pub(super) struct Reader<'a> {
    pub bytes: &'a mut Bytes,
    pub storage: Storage,
    pub big_endian: bool,
}

impl Reader<'_> {
    /// An error at a position of the variable; of a deflated one the place is where it begins in
    /// the file.
    pub fn error(
        &self,
        position: u64,
        what: &'static str,
        got: impl ToString,
        expected: impl ToString,
    ) -> IoError {
        let byte = match self.storage {
            Storage::Plain(at) => at + position,
            Storage::Deflated(at, _) => at,
        };
        IoError::Binary {
            path: self.bytes.path().to_owned(),
            byte,
            what,
            got: got.to_string(),
            expected: expected.to_string(),
        }
    }

    fn number(&self, bytes: [u8; 4]) -> u32 {
        match self.big_endian {
            true => u32::from_be_bytes(bytes),
            false => u32::from_le_bytes(bytes),
        }
    }

    /// The element at a position; it lies before `end`.
    pub fn element(&mut self, position: u64, end: u64) -> Result<Element, IoError> {
        if end.saturating_sub(position) < 8 {
            let got = format!("{} bytes", end.saturating_sub(position));
            return Err(self.error(position, "data element", got, "a tag of 8 bytes"));
        }
        let mut tag = [0; 8];
        self.bytes.read(self.storage, position, &mut tag)?;
        let [a, b, c, d, e, f, g, h] = tag;
        let (first, second) = (self.number([a, b, c, d]), self.number([e, f, g, h]));
        // Up to four bytes stand in the tag itself, with their count in the upper half of the type.
        let small = first >> 16;
        if small > 0 {
            if small > 4 {
                return Err(self.error(position, "small data element", small, "4 bytes or fewer"));
            }
            return Ok(Element {
                kind: first & 0xffff,
                data: position + 4,
                size: small as usize,
                next: position + 8,
            });
        }
        let data = position + 8;
        if u64::from(second) > end - data {
            let expected = format!("{} or fewer", end - data);
            return Err(self.error(position, "byte count of a data element", second, expected));
        }
        let next = data + u64::from(second).next_multiple_of(8);
        Ok(Element {
            kind: first,
            data,
            size: second as usize,
            // Some writers leave out the padding of the last element.
            next: next.min(end),
        })
    }

    /// Bytes of an element.
    pub fn content(&mut self, element: &Element) -> Result<Vec<u8>, IoError> {
        self.bytes
            .read_vec(self.storage, element.data, element.size)
    }

    /// Bytes `range` of an element, which lie inside.
    pub fn content_part(
        &mut self,
        element: &Element,
        range: std::ops::Range<usize>,
    ) -> Result<Vec<u8>, IoError> {
        let first = element.data + range.start as u64;
        self.bytes.read_vec(self.storage, first, range.len())
    }

    /// Numbers of an element, single precision made double.
    pub fn numbers(&mut self, element: &Element) -> Result<Vec<f64>, IoError> {
        let number = self.number_of(element)?;
        let bytes = self.content(element)?;
        Ok(doubles(decode(&bytes, number, self.big_endian)))
    }

    /// Type of the numbers of an element.
    pub fn number_of(&self, element: &Element) -> Result<NumberType, IoError> {
        let number = number_type(element.kind);
        number.ok_or_else(|| {
            self.error(
                element.data,
                "type of a data element",
                element.kind,
                "numbers",
            )
        })
    }

    /// Text of an element, without the zeros behind it.
    pub fn name(&mut self, element: &Element) -> Result<String, IoError> {
        if element.size > LONGEST_NAME {
            return Err(self.error(element.data, "length of a name", element.size, LONGEST_NAME));
        }
        let bytes = self.content(element)?;
        let text = bytes.split(|byte| *byte == 0).next().unwrap_or_default();
        Ok(String::from_utf8_lossy(text).into_owned())
    }

    /// The matrix at a position; it lies before `end`.
    pub fn matrix(&mut self, position: u64, end: u64) -> Result<Matrix, IoError> {
        let whole = self.element(position, end)?;
        if whole.kind != MATRIX {
            return Err(self.error(
                position,
                "type of a data element",
                whole.kind,
                "14, a matrix",
            ));
        }
        // A nested matrix ends where its count says, padded or not.
        let end = whole.data + whole.size as u64;
        if whole.size == 0 {
            return Ok(Matrix {
                class: 0,
                complex: false,
                logical: false,
                shape: vec![0, 0],
                count: 0,
                name: String::new(),
                content: end,
                end,
            });
        }
        let flags = self.element(whole.data, end)?;
        if flags.size != 8 {
            return Err(self.error(flags.data, "size of array flags", flags.size, "8 bytes"));
        }
        let mut word = [0; 4];
        self.bytes.read(self.storage, flags.data, &mut word)?;
        let word = self.number(word);
        let class = (word & 0xff) as u8;
        let mut next = flags.next;
        let mut shape = Vec::new();
        if class != OPAQUE {
            let lengths = self.element(next, end)?;
            shape = self.shape(&lengths)?;
            next = lengths.next;
        }
        let elements = count(&shape);
        let count = elements.ok_or_else(|| {
            self.error(
                position,
                "dimensions",
                format!("{shape:?}"),
                "fewer elements",
            )
        })?;
        let name = self.element(next, end)?;
        Ok(Matrix {
            class,
            complex: word & COMPLEX != 0,
            logical: word & LOGICAL != 0,
            shape,
            count,
            name: self.name(&name)?,
            content: name.next,
            end,
        })
    }

    fn shape(&mut self, element: &Element) -> Result<Vec<usize>, IoError> {
        if element.kind != 5 || element.size > 4 * MAX_DIMENSIONS {
            let got = format!("type {} of {} bytes", element.kind, element.size);
            return Err(self.error(element.data, "dimensions", got, "a few 32-bit numbers"));
        }
        let lengths = self.numbers(element)?;
        let length = |length: f64| {
            let error = || self.error(element.data, "dimension", length, "0 or more");
            if length >= 0.0 {
                Ok(length as usize)
            } else {
                Err(error())
            }
        };
        lengths.into_iter().map(length).collect()
    }
}
