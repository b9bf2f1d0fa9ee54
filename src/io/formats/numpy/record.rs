//! The elements of an array as records: of one item, or of the fields of a structured type.
//!
//! | type (`descr`) | fields |
//! |---|---|
//! | `'<f8'` | none: the array itself |
//! | `[('x', '<f8'), ('y', '<c16', (3,))]` | `x`, `y`; `y` has one dimension more than the array |
//! | `[('point', [('node', '<i4'), ('axis', '\|i1')])]` | `point/node`, `point/axis` |
//! | `[('a', '\|i1'), ('', '\|V7'), ('b', '<f8')]` | `a`, `b`; the bytes without a name are padding |
//! | `{'names': ..., 'formats': ..., 'offsets': ..., 'itemsize': ...}` | as named, at their offsets |

use super::items::Item;
use super::literal::Literal;

/// Names and lengths of all fields take at most so many times the bytes of their description, and
/// 64 KiB. With more, a long name around many fields takes far more memory than the file; with less
/// than 2, a struct of short names in a long one is refused (`names_of_fields_cannot_be_repeated`).
const MAX_NAMES_OVER_DESCRIPTION: usize = 16;
const MIN_NAMES_BYTES: usize = 1 << 16;

/// The elements of an array.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Record {
    /// Bytes of one element; `None` for a type whose bytes are not known.
    pub size: Option<usize>,
    /// At least one; the only one of an array without fields has no name.
    pub columns: Vec<Column>,
}

/// A field of the elements.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Column {
    /// Names of the fields that lead to it, separated by `/`; empty for the array itself.
    pub name: String,
    /// Its type.
    pub item: Item,
    /// First byte in the element.
    offset: usize,
    /// Lengths that a field with a shape adds, slowest first.
    repeats: Vec<Repeat>,
}

/// A dimension inside an element.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Repeat {
    length: usize,
    /// Bytes from one to the next.
    stride: usize,
}

impl Record {
    /// From the text of `descr`. A type that cannot be laid out is one unread column.
    pub fn from_description(text: &str) -> Self {
        let Some(literal) = Literal::parse(text) else {
            return Self::unread();
        };
        let most = text.len().saturating_mul(MAX_NAMES_OVER_DESCRIPTION);
        let mut layout = Layout {
            columns: Vec::new(),
            name_bytes: most.saturating_add(MIN_NAMES_BYTES),
        };
        let size = layout.add(&literal, Column::unread());
        match (&literal, size) {
            (_, Some(size)) if !layout.columns.is_empty() => Self {
                size: Some(size),
                columns: layout.columns,
            },
            // A single type whose width is not known keeps its name.
            (Literal::Text(_), None) => Self {
                size: None,
                columns: layout.columns,
            },
            _ => Self::unread(),
        }
    }

    fn unread() -> Self {
        Self {
            size: None,
            columns: vec![Column::unread()],
        }
    }

    /// Whether the elements of a column can be read.
    pub fn is_readable(&self, column: usize) -> bool {
        self.size.is_some() && self.columns[column].item.size().is_some()
    }

    /// Whether the elements are those of one column, so that they stand one after the other.
    pub fn is_plain(&self) -> bool {
        let column = &self.columns[0];
        column.repeats.is_empty() && column.item.size() == self.size && self.columns.len() == 1
    }
}

impl Column {
    /// The array itself, of a type that is not understood.
    fn unread() -> Self {
        Self {
            name: String::new(),
            item: Item::Other("struct", None),
            offset: 0,
            repeats: Vec::new(),
        }
    }

    /// Lengths that it has in addition to those of the array.
    pub fn lengths(&self) -> impl Iterator<Item = usize> {
        self.repeats.iter().map(|repeat| repeat.length)
    }

    /// Appends its bytes of one element.
    pub fn append(&self, element: &[u8], bytes: &mut Vec<u8>) {
        let size = self.item.size().unwrap_or(0);
        append(&element[self.offset..], &self.repeats, size, bytes);
    }
}

/// Appends the items of `size` bytes that the dimensions lead to.
fn append(element: &[u8], repeats: &[Repeat], size: usize, bytes: &mut Vec<u8>) {
    match repeats.split_first() {
        None => bytes.extend_from_slice(&element[..size]),
        Some((first, others)) => {
            for place in 0..first.length {
                append(&element[place * first.stride..], others, size, bytes);
            }
        }
    }
}

/// The columns so far.
struct Layout {
    columns: Vec<Column>,
    /// Bytes of names and lengths that may still be made.
    name_bytes: usize,
}

impl Layout {
    /// Adds the columns of a type that begins where `whole` does; its bytes, where it has a layout
    /// that is understood.
    fn add(&mut self, literal: &Literal, whole: Column) -> Option<usize> {
        match literal {
            Literal::Text(code) => {
                let item = Item::from_code(code);
                let size = item.stored_bytes();
                let added = whole.name.len() + size_of_val(whole.repeats.as_slice());
                self.name_bytes = self.name_bytes.checked_sub(added)?;
                self.columns.push(Column { item, ..whole });
                size
            }
            Literal::Tuple(parts) => match parts.as_slice() {
                [base, shape] => self.add_repeated(base, shape, whole),
                _ => None,
            },
            Literal::List(fields) => self.add_fields(fields, &whole),
            Literal::Dictionary(_) => self.add_placed_fields(literal, &whole),
            Literal::Number(_) => None,
        }
    }

    /// Adds a type with a shape.
    fn add_repeated(&mut self, base: &Literal, shape: &Literal, whole: Column) -> Option<usize> {
        let lengths: Vec<usize> = match shape {
            Literal::Number(length) => vec![*length],
            _ => {
                let lengths = shape.values()?.iter().map(Literal::number);
                lengths.collect::<Option<_>>()?
            }
        };
        // The columns are added without the new dimensions, whose strides need their size.
        let first = self.columns.len();
        let outer = whole.repeats.len();
        let size = self.add(base, whole)?;
        let mut repeats = Vec::with_capacity(lengths.len());
        let mut stride = size;
        for length in lengths.into_iter().rev() {
            repeats.push(Repeat { length, stride });
            stride = stride.checked_mul(length)?;
        }
        repeats.reverse();
        let added = self.columns.len().saturating_sub(first);
        let added = added.checked_mul(size_of_val(repeats.as_slice()))?;
        self.name_bytes = self.name_bytes.checked_sub(added)?;
        for column in &mut self.columns[first..] {
            column.repeats.splice(outer..outer, repeats.iter().copied());
        }
        Some(stride)
    }

    /// Adds fields that follow each other.
    fn add_fields(&mut self, fields: &[Literal], whole: &Column) -> Option<usize> {
        let mut size: usize = 0;
        for (number, field) in fields.iter().enumerate() {
            let Literal::Tuple(parts) = field else {
                return None;
            };
            let (name, of_type, shape) = match parts.as_slice() {
                [name, of_type] => (name, of_type, None),
                [name, of_type, shape] => (name, of_type, Some(shape)),
                _ => return None,
            };
            let first = self.columns.len();
            let field = Field {
                name: field_name(name)?,
                number,
                of_type,
                shape,
                offset: size,
            };
            let added = self.add_field(&field, whole)?;
            let mut columns = self.columns[first..].iter();
            let is_padding = field.name.is_empty()
                && columns.all(|column| matches!(column.item, Item::Other("bytes", _)));
            if is_padding {
                self.columns.truncate(first);
            }
            size = size.checked_add(added)?;
        }
        Some(size)
    }

    /// Adds fields at stated offsets.
    fn add_placed_fields(&mut self, literal: &Literal, whole: &Column) -> Option<usize> {
        let names = literal.value("names")?.values()?;
        let formats = literal.value("formats")?.values()?;
        let offsets = literal.value("offsets")?.values()?;
        let size = literal.value("itemsize")?.number()?;
        if names.len() != formats.len() || names.len() != offsets.len() {
            return None;
        }
        let fields = names.iter().zip(formats).zip(offsets);
        for (number, ((name, of_type), offset)) in fields.enumerate() {
            let field = Field {
                name: field_name(name)?,
                number,
                of_type,
                shape: None,
                offset: offset.number()?,
            };
            let added = self.add_field(&field, whole)?;
            let end = field.offset.checked_add(added);
            end.filter(|end| *end <= size)?;
        }
        Some(size)
    }

    /// Adds a field of `whole`; its bytes.
    fn add_field(&mut self, field: &Field, whole: &Column) -> Option<usize> {
        // NumPy calls fields without a name `f0`, `f1` and so on.
        let name = match field.name {
            "" => format!("f{}", field.number),
            name => name.to_owned(),
        };
        let name = match whole.name.as_str() {
            "" => name,
            outer => {
                self.name_bytes.checked_sub(outer.len() + name.len())?;
                format!("{outer}/{name}")
            }
        };
        let column = Column {
            name,
            offset: whole.offset.checked_add(field.offset)?,
            repeats: whole.repeats.clone(),
            ..Column::unread()
        };
        match field.shape {
            Some(shape) => self.add_repeated(field.of_type, shape, column),
            None => self.add(field.of_type, column),
        }
    }
}

/// A field as its description states it.
struct Field<'a> {
    name: &'a str,
    /// Its number from 0.
    number: usize,
    of_type: &'a Literal,
    shape: Option<&'a Literal>,
    /// First byte in the structure that holds it.
    offset: usize,
}

/// The name of a field, which may stand behind a title.
fn field_name(name: &Literal) -> Option<&str> {
    match name {
        Literal::Text(name) => Some(name),
        Literal::Tuple(names) => match names.as_slice() {
            [_, Literal::Text(name)] => Some(name),
            _ => None,
        },
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(record: &Record) -> Vec<&str> {
        let columns = record.columns.iter();
        columns.map(|column| column.name.as_str()).collect()
    }

    /// Bytes that a column takes of one element whose bytes are 0, 1, 2 and so on.
    fn bytes(record: &Record, column: usize) -> Vec<u8> {
        let element: Vec<u8> = (0..record.size.unwrap() as u8).collect();
        let mut bytes = Vec::new();
        record.columns[column].append(&element, &mut bytes);
        bytes
    }

    #[test]
    fn fields_of_fields_with_shapes_are_found_in_the_element() {
        let text =
            "[('a', '|i1'), ('s', [('p', '>i2'), ('q', '|u1', (2, 1))], (2,)), ('b', '<i2')]";
        let record = Record::from_description(text);
        assert_eq!(record.size, Some(11));
        assert_eq!(names(&record), ["a", "s/p", "s/q", "b"]);
        let lengths: Vec<usize> = record.columns[2].lengths().collect();
        assert_eq!(lengths, [2, 2, 1]);
        assert_eq!(bytes(&record, 1), [1, 2, 5, 6]);
        assert_eq!(bytes(&record, 2), [3, 4, 7, 8]);
        assert_eq!(bytes(&record, 3), [9, 10]);
    }

    #[test]
    fn padding_and_titles_are_no_fields() {
        let text = "[('a', '|i1'), ('', '|V3'), (('a title', 'b'), '<i4'), ('', '|V8')]";
        let record = Record::from_description(text);
        assert_eq!((record.size, names(&record)), (Some(16), vec!["a", "b"]));
        assert_eq!(bytes(&record, 1), [4, 5, 6, 7]);
        let text =
            "{'names': ['x', 'y'], 'formats': ['<i2', '|i1'], 'offsets': [4, 0], 'itemsize': 8}";
        let record = Record::from_description(text);
        assert_eq!((record.size, names(&record)), (Some(8), vec!["x", "y"]));
        assert_eq!(bytes(&record, 0), [4, 5]);
    }

    #[test]
    fn a_type_without_a_layout_is_one_unread_column() {
        for text in [
            "[('a', '|O'), ('b', '<f8')]",
            "[]",
            "[('a',)]",
            "[('a', '<f8', ('x',))]",
            "[('a', '<f8', (4611686018427387904, 4))]",
            "{'names': ['x'], 'formats': ['<f8'], 'offsets': [1], 'itemsize': 8}",
            "{'names': ['x']}",
            "3",
            "",
        ] {
            let record = Record::from_description(text);
            assert!(!record.is_readable(0), "{text}");
            assert_eq!(record.columns.len(), 1, "{text}");
            assert_eq!(record.columns[0].item.kind(), "struct", "{text}");
        }
    }

    #[test]
    fn names_of_fields_cannot_be_repeated() {
        let fields = "('f', '|i1'), ".repeat(20_000);
        let long = "n".repeat(200_000);
        let record = Record::from_description(&format!("[('{long}', [{fields}])]"));
        assert!(!record.is_readable(0));
        let record = Record::from_description(&format!("[('a long name', [{fields}])]"));
        assert_eq!(record.columns.len(), 20_000);
    }
}
