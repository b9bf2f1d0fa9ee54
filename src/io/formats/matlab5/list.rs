//! Which variables, fields and cells a file has: a walk over the headers.

use std::ops::Range;

use crate::io::formats::arrays::store::bytes::NumberType;
use crate::io::{ArrayInfo, IoError};

use super::bytes::{Bytes, DEFLATE_EXPANSION, Storage};
use super::elements::{
    CELL, CHAR, COMPRESSED, DOUBLE, FUNCTION, LONGEST_NAME, MATRIX, Matrix, OBJECT, OPAQUE, Reader,
    SINGLE, SPARSE, STRUCT,
};

/// Structs and cells within each other.
const MAX_NESTING: usize = 32;

/// A sparse matrix is read when the full one takes no more memory than this many times the file.
const SPARSE_EXPANSION: u64 = 16;

/// So many parts are listed for each file, and one more for every four bytes of it.
const MIN_PART_LIMIT: u64 = 1024;

/// Bytes of all names together: at most so many times the file, and 1 MiB. A field name is repeated
/// for every element.
const NAMES_EXPANSION: u64 = 16;

/// The content of a part of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Content {
    /// Real or complex numbers.
    Numbers,
    /// Texts of a char array, one for each row.
    Text,
    /// A cell array that holds texts alone.
    TextCells,
    /// A sparse matrix that fits.
    Sparse,
    /// Unread content.
    Unread,
}

/// A part of the file: a variable, or a field or cell of one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub storage: Storage,
    /// Where its matrix begins within the variable, and before what it ends.
    pub position: u64,
    pub end: u64,
    pub content: Content,
    /// Most bytes that its elements take in the file, inflated.
    pub bytes: u64,
}

/// Everything that is found in a file.
#[derive(Default)]
pub(super) struct Listing {
    pub parts: Vec<Part>,
    pub infos: Vec<ArrayInfo>,
    pub damage: Vec<IoError>,
}

/// Lists the variables from byte `start` on. What follows damage is listed where it can be found.
pub(super) fn list(bytes: &mut Bytes, start: u64, big_endian: bool) -> Listing {
    let mut listing = Listing::default();
    let most = MIN_PART_LIMIT + bytes.length / 4;
    let mut name_bytes = bytes.length.saturating_mul(NAMES_EXPANSION) + (1 << 20);
    let mut at = start;
    while at < bytes.length {
        let length = bytes.length - at;
        let mut reader = Reader {
            bytes,
            storage: Storage::Plain(at),
            big_endian,
        };
        let element = match reader.element(0, length) {
            Ok(element) => element,
            Err(error) => {
                listing.damage.push(truncated(&reader, length, error));
                break;
            }
        };
        let size = element.size as u64;
        let end = match element.kind {
            COMPRESSED => {
                reader.storage = Storage::Deflated(at + element.data, size);
                size.saturating_mul(DEFLATE_EXPANSION)
            }
            _ => element.data + size,
        };
        let mut walk = Walk {
            reader,
            listing: &mut listing,
            most,
            name_bytes: &mut name_bytes,
        };
        let walked = match element.kind {
            MATRIX | COMPRESSED => walk.part(0, end, None, 0).map(drop),
            other => {
                let expected = "a matrix (14) or a compressed one (15)";
                Err(walk
                    .reader
                    .error(0, "type of a data element", other, expected))
            }
        };
        listing.damage.extend(walked.err());
        // A compressed variable is not padded.
        at += match element.kind {
            COMPRESSED => element.data + size,
            _ => element.data + size.next_multiple_of(8),
        };
    }
    listing
}

/// A count that leads past the end of the file says that the file is cut off.
fn truncated(reader: &Reader, length: u64, error: IoError) -> IoError {
    match error {
        IoError::Binary {
            path, byte, got, ..
        } => IoError::Truncated {
            path,
            byte: reader.bytes.length,
            what: "a variable",
            got: format!("{length} bytes from byte {byte}"),
            expected: format!("a tag and as many bytes as it says ({got})"),
        },
        other => other,
    }
}

struct Walk<'a, 'b> {
    reader: Reader<'a>,
    listing: &'b mut Listing,
    /// Most parts that are listed.
    most: u64,
    /// Bytes of names that may still be made.
    name_bytes: &'b mut u64,
}

impl Walk<'_, '_> {
    /// Lists the matrix at a position under `name`, or under the name in the file where none is
    /// given.
    fn part(
        &mut self,
        position: u64,
        end: u64,
        name: Option<String>,
        depth: usize,
    ) -> Result<Matrix, IoError> {
        if depth > MAX_NESTING {
            let expected = format!("{MAX_NESTING} levels or fewer");
            return Err(self.reader.error(
                position,
                "structs and cells within each other",
                "more",
                expected,
            ));
        }
        let matrix = self.reader.matrix(position, end)?;
        let mut name = name.unwrap_or_else(|| matrix.name.clone());
        if name.is_empty() {
            "(without name)".clone_into(&mut name);
        }
        let place = position..end;
        match matrix.class {
            STRUCT => self.list_fields(&matrix, &name, place, depth)?,
            CELL => self.list_cells(&matrix, &name, place, depth)?,
            SPARSE if self.sparse_fits(&matrix) => {
                self.push_part(name, &matrix, "sparse", place, Content::Sparse)?;
            }
            CHAR => self.push_part(name, &matrix, "text", place, Content::Text)?,
            class => {
                let number = number_class(class);
                let content = match number {
                    Some(_) => Content::Numbers,
                    None => Content::Unread,
                };
                let kind = kind(&matrix, number);
                self.push_part(name, &matrix, &kind, place, content)?;
            }
        }
        Ok(matrix)
    }

    fn sparse_fits(&self, matrix: &Matrix) -> bool {
        let most = self.reader.bytes.length.saturating_mul(SPARSE_EXPANSION);
        let size = if matrix.complex { 16 } else { 8 };
        matrix.shape.len() == 2 && (matrix.count as u64).saturating_mul(size) <= most
    }

    fn push_part(
        &mut self,
        name: String,
        matrix: &Matrix,
        kind: &str,
        place: Range<u64>,
        content: Content,
    ) -> Result<(), IoError> {
        if self.listing.parts.len() as u64 >= self.most {
            let expected = format!("{} or fewer in a file of this size", self.most);
            return Err(self.reader.error(
                place.start,
                "variables, fields and cells",
                "more",
                expected,
            ));
        }
        let left = self.name_bytes.checked_sub(name.len() as u64);
        *self.name_bytes = left.ok_or_else(|| {
            let expected = "fewer in a file of this size";
            self.reader
                .error(place.start, "bytes of names", "more", expected)
        })?;
        self.listing.parts.push(Part {
            storage: self.reader.storage,
            position: place.start,
            end: place.end,
            content,
            bytes: matrix.end.saturating_sub(matrix.content),
        });
        let shape = match content {
            Content::Text => text_shape(matrix),
            _ => matrix.shape.clone(),
        };
        self.listing.infos.push(ArrayInfo {
            name,
            shape,
            kind: kind.to_owned(),
        });
        Ok(())
    }

    fn list_cells(
        &mut self,
        matrix: &Matrix,
        name: &str,
        place: Range<u64>,
        depth: usize,
    ) -> Result<(), IoError> {
        let first = self.listing.parts.len();
        let mut position = matrix.content;
        let mut texts_alone = true;
        for number in 1..=matrix.count {
            let cell = self.part(
                position,
                matrix.end,
                Some(format!("{name}{{{number}}}")),
                depth + 1,
            )?;
            texts_alone &= is_one_text(&cell);
            position = cell.end;
        }
        if !texts_alone {
            return Ok(());
        }
        let names = self.listing.infos.drain(first..);
        *self.name_bytes += names.map(|info| info.name.len() as u64).sum::<u64>();
        self.listing.parts.truncate(first);
        self.push_part(name.to_owned(), matrix, "text", place, Content::TextCells)
    }

    fn list_fields(
        &mut self,
        matrix: &Matrix,
        name: &str,
        place: Range<u64>,
        depth: usize,
    ) -> Result<(), IoError> {
        let (names, mut position) = self.field_names(matrix)?;
        if names.is_empty() || matrix.count == 0 {
            return self.push_part(name.to_owned(), matrix, "struct", place, Content::Unread);
        }
        for number in 1..=matrix.count {
            for field in &names {
                let path = match matrix.count {
                    1 => format!("{name}/{field}"),
                    _ => format!("{name}({number})/{field}"),
                };
                position = self.part(position, matrix.end, Some(path), depth + 1)?.end;
            }
        }
        Ok(())
    }

    /// Names of the fields, and where the first field begins.
    fn field_names(&mut self, matrix: &Matrix) -> Result<(Vec<String>, u64), IoError> {
        let reader = &mut self.reader;
        let width = reader.element(matrix.content, matrix.end)?;
        let widths = match width.size {
            4 => reader.numbers(&width)?,
            _ => Vec::new(),
        };
        let names = reader.element(width.next, matrix.end)?;
        if names.size == 0 {
            return Ok((Vec::new(), names.next));
        }
        let most = LONGEST_NAME as f64;
        let width = widths.first().copied();
        let usable = width.filter(|width| (1.0..=most).contains(width));
        let width = usable.ok_or_else(|| {
            let got = width.map_or("none".to_owned(), |width| width.to_string());
            let expected = format!("1 to {LONGEST_NAME}");
            reader.error(matrix.content, "length of field names", got, expected)
        })?;
        let count = names.size as u64 / width as u64;
        if count > self.most || names.size as u64 > *self.name_bytes {
            let expected = "fewer in a file of this size";
            return Err(reader.error(names.data, "fields of a struct", count, expected));
        }
        let bytes = reader.content(&names)?;
        let texts = bytes.chunks_exact(width as usize).map(|name| {
            let text = name.split(|byte| *byte == 0).next().unwrap_or_default();
            String::from_utf8_lossy(text).into_owned()
        });
        Ok((texts.collect(), names.next))
    }
}

/// Shape of the texts of a char array, one for each row.
pub(super) fn text_shape(matrix: &Matrix) -> Vec<usize> {
    match matrix.shape.first() {
        Some(rows) if *rows > 1 && matrix.count > 0 => vec![*rows],
        _ => Vec::new(),
    }
}

/// Whether a cell holds a text of one row, or an empty one.
pub(super) fn is_one_text(matrix: &Matrix) -> bool {
    matrix.class == CHAR && (matrix.count == 0 || matrix.shape.first() == Some(&1))
}

/// Numbers of a matrix class.
pub(super) fn number_class(class: u8) -> Option<NumberType> {
    Some(match class {
        0 | DOUBLE => NumberType::F64,
        SINGLE => NumberType::F32,
        8 => NumberType::I8,
        9 => NumberType::U8,
        10 => NumberType::I16,
        11 => NumberType::U16,
        12 => NumberType::I32,
        13 => NumberType::U32,
        14 => NumberType::I64,
        15 => NumberType::U64,
        _ => return None,
    })
}

fn kind(matrix: &Matrix, number: Option<NumberType>) -> String {
    match (matrix.class, number) {
        (_, Some(_)) if matrix.logical => "bool".to_owned(),
        (_, Some(number)) if matrix.complex => format!("complex {}", number.name()),
        (_, Some(number)) => number.name().to_owned(),
        (SPARSE, _) => "sparse".to_owned(),
        (OBJECT, _) => "object".to_owned(),
        (FUNCTION, _) => "function".to_owned(),
        (OPAQUE, _) => "opaque".to_owned(),
        (class, _) => format!("class {class}"),
    }
}
