//! The header of an `.npy` array: a Python dictionary with three keys, read without a Python
//! parser.

use std::io::{ErrorKind, Read};

use crate::io::IoError;

use super::record::Record;

/// The first bytes of an `.npy` file.
pub(super) const MAGIC: &[u8] = b"\x93NUMPY";

/// Longest header that is read, bytes; the default limit of NumPy is 10,000 characters.
const LONGEST: u32 = 1 << 20;

/// Most dimensions that NumPy arrays have.
const MAX_DIMENSIONS: usize = 64;

/// The header of an array.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Header {
    /// Bytes from the magic to the first element.
    pub data: u64,
    /// The type of the elements.
    pub record: Record,
    /// Whether the first index runs fastest.
    pub fortran: bool,
    /// Lengths, as printed.
    pub shape: Vec<usize>,
}

impl Header {
    /// Reads the header at the start of `input`.
    ///
    /// # Errors
    /// [`IoError::Binary`], [`IoError::Truncated`] and [`IoError::System`].
    pub fn read(mut input: impl Read, path: &str) -> Result<Self, IoError> {
        let mut fixed = [0; 10];
        fill(&mut input, &mut fixed, 0, path)?;
        if !fixed.starts_with(MAGIC) {
            return Err(bad(
                path,
                "magic bytes",
                format!("{:02x?}", &fixed[..6]),
                "\\x93NUMPY",
            ));
        }
        let mut start = 10;
        let length = match fixed[6] {
            1 => u32::from(u16::from_le_bytes([fixed[8], fixed[9]])),
            2 | 3 => {
                let mut rest = [0; 2];
                fill(&mut input, &mut rest, 10, path)?;
                start = 12;
                u32::from_le_bytes([fixed[8], fixed[9], rest[0], rest[1]])
            }
            other => return Err(bad(path, "format version", other.to_string(), "1, 2 or 3")),
        };
        if length > LONGEST {
            return Err(bad(
                path,
                "header length",
                length.to_string(),
                "1 MiB or less",
            ));
        }
        let mut text = vec![0; length as usize];
        fill(&mut input, &mut text, start, path)?;
        let data = start + u64::from(length);
        parse(&String::from_utf8_lossy(&text), data, path)
    }
}

fn fill(input: &mut impl Read, bytes: &mut [u8], at: u64, path: &str) -> Result<(), IoError> {
    input
        .read_exact(bytes)
        .map_err(|source| match source.kind() {
            ErrorKind::UnexpectedEof => IoError::Truncated {
                path: path.to_owned(),
                byte: at,
                what: "the header of an array",
                got: "fewer bytes".to_owned(),
                expected: format!("{} bytes", bytes.len()),
            },
            _ => IoError::System {
                path: path.to_owned(),
                action: "read the header of an array in",
                source,
            },
        })
}

fn bad(path: &str, what: &'static str, got: String, expected: &str) -> IoError {
    IoError::Binary {
        path: path.to_owned(),
        byte: 0,
        what,
        got,
        expected: expected.to_owned(),
    }
}

fn parse(text: &str, data: u64, path: &str) -> Result<Header, IoError> {
    let entries = entries(text);
    let value = |key: &str| {
        let entry = entries.iter().find(|(name, _)| *name == key);
        entry.map(|(_, value)| *value).ok_or_else(|| {
            let shown: String = text.trim_end().chars().take(100).collect();
            bad(
                path,
                "header",
                shown,
                "a dictionary with descr, fortran_order and shape",
            )
        })
    };
    let fortran = match value("fortran_order")? {
        "True" => true,
        "False" => false,
        other => {
            return Err(bad(
                path,
                "fortran_order",
                other.to_owned(),
                "True or False",
            ));
        }
    };
    let lengths = value("shape")?;
    let shape = shape(lengths);
    let shape =
        shape.ok_or_else(|| bad(path, "shape", lengths.to_owned(), "a tuple of lengths"))?;
    Ok(Header {
        data,
        record: Record::from_description(value("descr")?),
        fortran,
        shape,
    })
}

/// Keys and the text of their values. Nesting and quoted text are counted, not understood.
fn entries(text: &str) -> Vec<(&str, &str)> {
    let inner = text.trim().trim_start_matches('{');
    let (mut depth, mut quote, mut start, mut escaped) = (0_usize, None, 0, false);
    let mut parts = Vec::new();
    for (place, c) in inner.char_indices() {
        if std::mem::take(&mut escaped) {
            continue;
        }
        match (quote, c) {
            (Some(_), '\\') => escaped = true,
            (Some(open), c) if c == open => quote = None,
            (Some(_), _) => {}
            (None, '\'' | '"') => quote = Some(c),
            (None, '(' | '[' | '{') => depth += 1,
            (None, ',' | '}') if depth == 0 => {
                parts.push(&inner[start..place]);
                start = place + 1;
            }
            (None, ')' | ']' | '}') => depth = depth.saturating_sub(1),
            _ => {}
        }
    }
    let pairs = parts.into_iter().filter_map(|part| part.split_once(':'));
    pairs
        .map(|(key, value)| (key.trim().trim_matches(['\'', '"']), value.trim()))
        .collect()
}

/// Lengths of `(3, 4)`, `(3,)` or `()`; Python 2 wrote `3L`.
fn shape(text: &str) -> Option<Vec<usize>> {
    let inner = text.strip_prefix('(')?.strip_suffix(')')?;
    let lengths = inner
        .split(',')
        .map(str::trim)
        .filter(|length| !length.is_empty());
    let lengths: Option<Vec<usize>> = lengths
        .map(|length| length.trim_end_matches('L').parse().ok())
        .collect();
    lengths.filter(|lengths| lengths.len() <= MAX_DIMENSIONS)
}

/// The header of a written array, padded to 64 bytes: format version 1.0, C order. Its text is
/// ASCII and short.
pub(super) fn written(description: &str, shape: &[usize]) -> Vec<u8> {
    let lengths: String = shape.iter().map(|length| format!("{length}, ")).collect();
    let lengths = match shape {
        [length] => format!("{length},"),
        _ => lengths.trim_end_matches(", ").to_owned(),
    };
    let mut text =
        format!("{{'descr': '{description}', 'fortran_order': False, 'shape': ({lengths}), }}");
    while !(MAGIC.len() + 4 + text.len() + 1).is_multiple_of(64) {
        text.push(' ');
    }
    text.push('\n');
    let mut bytes = MAGIC.to_vec();
    bytes.extend([1, 0]);
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes
}
