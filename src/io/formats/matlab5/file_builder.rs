//! MATLAB files from scratch, in either byte order, for tests.

use std::io::Write;

use super::header::{BIG_ENDIAN, HEADER, LITTLE_ENDIAN};

/// Builds elements in one byte order.
#[derive(Clone, Copy, Debug)]
pub struct Builder {
    /// Most significant byte first.
    pub big_endian: bool,
}

impl Builder {
    /// Little-endian bytes of a number in this builder's order.
    pub fn turned<const N: usize>(self, mut bytes: [u8; N]) -> [u8; N] {
        if self.big_endian {
            bytes.reverse();
        }
        bytes
    }

    fn word(self, value: u32) -> [u8; 4] {
        self.turned(value.to_le_bytes())
    }

    /// A data element with its tag and padding.
    pub fn element(self, kind: u32, bytes: &[u8]) -> Vec<u8> {
        let mut element = [self.word(kind), self.word(bytes.len() as u32)].concat();
        element.extend(bytes);
        element.resize(element.len().next_multiple_of(8), 0);
        element
    }

    /// A data element of up to four bytes in its tag.
    pub fn small(self, kind: u32, bytes: &[u8]) -> Vec<u8> {
        let mut element = self.word(kind | (bytes.len() as u32) << 16).to_vec();
        element.extend(bytes);
        element.resize(8, 0);
        element
    }

    /// 32-bit numbers as an element.
    pub fn words(self, kind: u32, values: &[u32]) -> Vec<u8> {
        let bytes: Vec<u8> = values.iter().flat_map(|value| self.word(*value)).collect();
        self.element(kind, &bytes)
    }

    /// A matrix of class and flags; `content` follows its name.
    pub fn matrix(self, class: u32, shape: &[u32], name: &str, content: &[Vec<u8>]) -> Vec<u8> {
        let head = [
            self.words(6, &[class, 0]),
            self.words(5, shape),
            match name.len() {
                1..=4 => self.small(1, name.as_bytes()),
                _ => self.element(1, name.as_bytes()),
            },
        ];
        let content = [head.concat(), content.concat()].concat();
        self.element(14, &content)
    }

    /// A matrix of doubles.
    pub fn doubles(self, shape: &[u32], name: &str, values: &[f64]) -> Vec<u8> {
        let bytes: Vec<u8> = values
            .iter()
            .flat_map(|value| self.turned(value.to_le_bytes()))
            .collect();
        self.matrix(6, shape, name, &[self.element(9, &bytes)])
    }

    /// A text in UTF-16.
    pub fn text(self, name: &str, text: &str) -> Vec<u8> {
        let units: Vec<u8> = text
            .encode_utf16()
            .flat_map(|unit| self.turned(unit.to_le_bytes()))
            .collect();
        let shape = [1, units.len() as u32 / 2];
        self.matrix(4, &shape, name, &[self.element(4, &units)])
    }

    /// A struct; `fields` are matrices without name, those of one element after the other.
    pub fn structure(
        self,
        shape: &[u32],
        name: &str,
        names: &[&str],
        fields: &[Vec<u8>],
    ) -> Vec<u8> {
        let mut field_names = Vec::new();
        for field in names {
            field_names.extend(field.bytes());
            field_names.resize(field_names.len().next_multiple_of(8), 0);
        }
        let content = [
            self.small(5, &self.word(8)),
            self.element(1, &field_names),
            fields.concat(),
        ];
        self.matrix(2, shape, name, &content)
    }

    /// An element, deflated.
    pub fn deflated(self, element: &[u8]) -> Vec<u8> {
        let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(element).unwrap();
        let bytes = encoder.finish().unwrap();
        [
            self.word(15).to_vec(),
            self.word(bytes.len() as u32).to_vec(),
            bytes,
        ]
        .concat()
    }

    /// A whole file.
    pub fn file(self, elements: &[Vec<u8>]) -> Vec<u8> {
        let mut file = b"any text at all".to_vec();
        file.resize(HEADER - 12, b' ');
        file.resize(HEADER - 4, 0);
        file.extend(if self.big_endian {
            BIG_ENDIAN
        } else {
            LITTLE_ENDIAN
        });
        file.extend(elements.concat());
        file
    }
}

/// One of each byte order.
pub const BOTH: [Builder; 2] = [Builder { big_endian: false }, Builder { big_endian: true }];
