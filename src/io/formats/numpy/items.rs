//! Elements of NumPy arrays: their types, and bytes to elements and back.

use crate::io::formats::arrays::store::Elements;
use crate::io::formats::arrays::store::bytes::{NumberType, decode, decode_pairs};

/// The type of an element.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Item {
    /// A truth value, 0 or 1.
    Bool,
    /// A real number.
    Number(NumberType, bool),
    /// A complex number whose parts are of this type.
    Complex(NumberType, bool),
    /// This many bytes of text, padded with zeros.
    Bytes(usize),
    /// This many code points of 32 bits, padded with zeros.
    Unicode(usize, bool),
    /// Anything else, by its name, and its bytes where they are known.
    Other(&'static str, Option<usize>),
}

impl Item {
    /// From the code of a type without fields, such as `<f8`.
    pub fn from_code(text: &str) -> Self {
        use NumberType::{F16, F32, F64, I8, I16, I32, I64, U8, U16, U32, U64};
        let big_endian = text.starts_with('>');
        let code = text.trim_start_matches(['<', '>', '|', '=']);
        let number = match code {
            "b1" | "?" => return Item::Bool,
            "c8" => return Item::Complex(F32, big_endian),
            "c16" => return Item::Complex(F64, big_endian),
            "i1" => I8,
            "u1" => U8,
            "i2" => I16,
            "u2" => U16,
            "i4" => I32,
            "u4" => U32,
            "i8" => I64,
            "u8" => U64,
            "f2" => F16,
            "f4" => F32,
            "f8" => F64,
            other => return Self::other(other, big_endian),
        };
        Item::Number(number, big_endian)
    }

    fn other(code: &str, big_endian: bool) -> Self {
        let mut characters = code.chars();
        let (kind, width) = (characters.next(), characters.as_str().parse().ok());
        match (kind, width) {
            (Some('S' | 'a'), Some(width)) => Item::Bytes(width),
            (Some('U'), Some(width)) => Item::Unicode(width, big_endian),
            (Some('O'), _) => Item::Other("object", None),
            // The unit stands behind the width: `M8[ns]`.
            (Some('m' | 'M'), _) => Item::Other("date", Some(8)),
            (Some('V'), width) => Item::Other("bytes", width),
            (Some('f' | 'c'), width) => Item::Other("long double", width),
            _ => Item::Other("unknown", None),
        }
    }

    /// The name for lists of arrays.
    pub fn kind(&self) -> String {
        match self {
            Item::Bool => "bool".to_owned(),
            Item::Number(number, _) => number.name().to_owned(),
            Item::Complex(part, _) => format!("complex {}", part.name()),
            Item::Bytes(_) | Item::Unicode(..) => "text".to_owned(),
            Item::Other(name, _) => (*name).to_owned(),
        }
    }

    /// Bytes of an element; `None` for what is not read, and for texts without width (as many as
    /// one likes would fit).
    pub fn size(&self) -> Option<usize> {
        match self {
            Item::Other(..) => None,
            _ => self.stored_bytes().filter(|size| *size > 0),
        }
    }

    /// Bytes of an element in the file, read or not, where they are known.
    pub fn stored_bytes(&self) -> Option<usize> {
        match self {
            Item::Bool => Some(1),
            Item::Number(number, _) => Some(number.size()),
            Item::Complex(part, _) => Some(2 * part.size()),
            Item::Bytes(width) => Some(*width),
            Item::Unicode(width, _) => width.checked_mul(4),
            Item::Other(_, bytes) => *bytes,
        }
    }

    /// Elements of bytes.
    pub fn decode(&self, bytes: &[u8]) -> Elements {
        let texts = |width: usize, read: &dyn Fn(&[u8]) -> String| {
            Elements::Text(bytes.chunks_exact(width.max(1)).map(read).collect())
        };
        match self {
            Item::Bool => decode(bytes, NumberType::U8, false),
            Item::Number(number, big_endian) => decode(bytes, *number, *big_endian),
            Item::Complex(part, big_endian) => decode_pairs(bytes, *part, *big_endian),
            Item::Bytes(width) => texts(*width, &|text| {
                let text = String::from_utf8_lossy(text);
                text.trim_end_matches('\0').to_owned()
            }),
            Item::Unicode(width, big_endian) => texts(4 * width, &|text| {
                let (points, _) = text.as_chunks::<4>();
                let points = points.iter().map(|point| match big_endian {
                    true => u32::from_be_bytes(*point),
                    false => u32::from_le_bytes(*point),
                });
                let text = points.map(|p| char::from_u32(p).unwrap_or(char::REPLACEMENT_CHARACTER));
                text.collect::<String>().trim_end_matches('\0').to_owned()
            }),
            Item::Other(..) => Elements::F64(Vec::new()),
        }
    }
}

/// `descr` of elements and a function that gives the bytes of all of them, piece by piece.
pub(super) fn description(elements: &Elements) -> String {
    match elements {
        Elements::F32(_) => "<f4".to_owned(),
        Elements::F64(_) => "<f8".to_owned(),
        Elements::Complex(_) => "<c16".to_owned(),
        Elements::Text(texts) => format!("<U{}", width(texts)),
    }
}

/// Code points of the longest text, at least one.
fn width(texts: &[String]) -> usize {
    texts
        .iter()
        .map(|text| text.chars().count())
        .max()
        .unwrap_or(0)
        .max(1)
}

/// Bytes of elements, little endian, texts padded with zeros.
pub(super) fn encode(elements: &Elements) -> Vec<u8> {
    match elements {
        Elements::F32(values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
        Elements::F64(values) => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
        Elements::Complex(values) => {
            let parts = values.iter().flat_map(|v| [v.re, v.im]);
            parts.flat_map(f64::to_le_bytes).collect()
        }
        Elements::Text(texts) => {
            let width = width(texts);
            let padded = |text: &String| {
                let points: Vec<u32> = text.chars().map(u32::from).collect();
                let padding = width - points.len();
                points.into_iter().chain(std::iter::repeat_n(0, padding))
            };
            texts
                .iter()
                .flat_map(padded)
                .flat_map(u32::to_le_bytes)
                .collect()
        }
    }
}
