//! modalign's schema as a MATLAB file: one struct for each group, not compressed, little endian.

use std::io::SeekFrom;

use crate::finding::Finding;
use crate::io::formats::arrays::schema;
use crate::io::formats::arrays::store::bytes::{self, to_row_major};
use crate::io::formats::arrays::store::{Elements, NamedArray};
use crate::io::{IoError, Source, WriteOptions, WriteSeek};

use super::elements::{CELL, CHAR, COMPLEX, DOUBLE, MATRIX, SINGLE, STRUCT, UTF8};
use super::header::{HEADER, LITTLE_ENDIAN};

/// Element types that are written.
const INT8: u32 = 1;
const UINT16: u32 = 4;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const FLOAT: u32 = 7;
const FLOAT64: u32 = 9;

/// Bytes of a field name with its closing zero; a name of MATLAB has 63 characters at most.
const FIELD_NAME: usize = 64;

/// MATLAB reads no larger variable in this version of the format.
const LARGEST: u64 = i32::MAX as u64;

/// Writes everything that a source holds.
pub(super) fn write(
    out: &mut dyn WriteSeek,
    source: &mut dyn Source,
    options: &WriteOptions,
) -> Result<Vec<Finding>, IoError> {
    let mut file = File {
        out,
        path: &options.path,
        names: schema::array_names(source, options.precision)?,
        open: None,
    };
    file.header()?;
    let mut put = |array: NamedArray| file.put(array);
    let findings = schema::write_with_schema(source, options.precision, &mut put)?;
    file.close()?;
    Ok(findings)
}

/// A struct that is being written: its name, where its byte count stands, and the bytes after that.
struct OpenStruct {
    name: String,
    count_at: u64,
    count: u64,
}

struct File<'a> {
    out: &'a mut dyn WriteSeek,
    path: &'a str,
    /// Names of all arrays to come, so that a struct can begin with those of its fields.
    names: Vec<String>,
    open: Option<OpenStruct>,
}

fn system(path: &str) -> impl Fn(std::io::Error) -> IoError {
    move |source| IoError::System {
        path: path.to_owned(),
        action: "write",
        source,
    }
}

impl File<'_> {
    fn bytes(&mut self, bytes: &[u8]) -> Result<(), IoError> {
        self.out.write_all(bytes).map_err(system(self.path))
    }

    fn header(&mut self) -> Result<(), IoError> {
        // MATLAB looks for the first words; the rest is free.
        let text = concat!(
            "MATLAB 5.0 MAT-file, written by modalign ",
            env!("CARGO_PKG_VERSION")
        );
        let mut header = text.as_bytes().to_vec();
        header.resize(HEADER - 12, b' ');
        header.resize(HEADER - 4, 0);
        header.extend(LITTLE_ENDIAN);
        self.bytes(&header)
    }

    fn put(&mut self, array: NamedArray) -> Result<(), IoError> {
        let Some((group, field)) = array.name.split_once('/') else {
            self.close()?;
            let matrix = matrix(&array.name, &array);
            return self.variable(&array.name, &matrix);
        };
        let (group, field) = (group.to_owned(), field.to_owned());
        if self.open.as_ref().is_none_or(|open| open.name != group) {
            self.close()?;
            self.begin(group.clone())?;
        }
        let matrix = matrix("", &array);
        let count = self.open.as_ref().map_or(0, |open| open.count) + matrix.len() as u64;
        self.check_size(count, &format!("{group}.{field}"))?;
        if let Some(open) = &mut self.open {
            open.count = count;
        }
        self.bytes(&matrix)
    }

    fn variable(&mut self, name: &str, matrix: &[u8]) -> Result<(), IoError> {
        self.check_size(matrix.len() as u64, name)?;
        self.bytes(matrix)
    }

    fn check_size(&self, count: u64, name: &str) -> Result<(), IoError> {
        if count <= LARGEST {
            return Ok(());
        }
        Err(IoError::Unwritable {
            path: self.path.to_owned(),
            what: "a MATLAB variable of version 5",
            got: format!("{name} of {count} bytes or more"),
            expected: format!("{LARGEST} bytes or fewer; .h5 and .npz hold more"),
        })
    }

    /// Begins the struct of a group with the names of its fields; its byte count is put in when it
    /// ends.
    fn begin(&mut self, group: String) -> Result<(), IoError> {
        let prefix = format!("{group}/");
        let fields = self
            .names
            .iter()
            .filter_map(|name| name.strip_prefix(&prefix));
        let mut names = Vec::new();
        for field in fields {
            names.extend(field.bytes().take(FIELD_NAME - 1));
            names.resize(names.len().next_multiple_of(FIELD_NAME), 0);
        }
        let mut content = head(STRUCT, &[1, 1], &group);
        push_element(&mut content, INT32, &(FIELD_NAME as u32).to_le_bytes());
        push_element(&mut content, INT8, &names);
        let start = self.out.stream_position().map_err(system(self.path))?;
        self.bytes(&MATRIX.to_le_bytes())?;
        self.bytes(&[0; 4])?;
        self.bytes(&content)?;
        self.open = Some(OpenStruct {
            name: group,
            count_at: start + 4,
            count: content.len() as u64,
        });
        Ok(())
    }

    /// Ends the struct that is open, if one is.
    fn close(&mut self) -> Result<(), IoError> {
        let Some(open) = self.open.take() else {
            return Ok(());
        };
        let count = (open.count as u32).to_le_bytes();
        let mut patch = || {
            let end = self.out.stream_position()?;
            self.out.seek(SeekFrom::Start(open.count_at))?;
            self.out.write_all(&count)?;
            self.out.seek(SeekFrom::Start(end)).map(drop)
        };
        patch().map_err(system(self.path))
    }
}

/// Flags, dimensions and name of a matrix.
fn head(class: u8, shape: &[usize], name: &str) -> Vec<u8> {
    head_with(u32::from(class), shape, name)
}

fn head_with(flags: u32, shape: &[usize], name: &str) -> Vec<u8> {
    let mut content = Vec::new();
    let flags = [flags.to_le_bytes(), [0; 4]].concat();
    push_element(&mut content, UINT32, &flags);
    let lengths = shape
        .iter()
        .flat_map(|length| (*length as u32).to_le_bytes());
    push_element(&mut content, INT32, &lengths.collect::<Vec<u8>>());
    push_element(&mut content, INT8, name.as_bytes());
    content
}

/// Adds an element, padded to eight bytes; up to four bytes stand in the tag.
fn push_element(out: &mut Vec<u8>, kind: u32, bytes: &[u8]) {
    if (1..=4).contains(&bytes.len()) {
        out.extend((kind | (bytes.len() as u32) << 16).to_le_bytes());
    } else {
        out.extend(kind.to_le_bytes());
        out.extend((bytes.len() as u32).to_le_bytes());
    }
    out.extend(bytes);
    out.resize(out.len().next_multiple_of(8), 0);
}

/// A whole matrix element.
fn wrap(content: &[u8]) -> Vec<u8> {
    let mut element = Vec::with_capacity(content.len() + 8);
    element.extend(MATRIX.to_le_bytes());
    element.extend((content.len() as u32).to_le_bytes());
    element.extend(content);
    element
}

/// Two lengths or more: n values are n x 1.
fn matlab_shape(shape: &[usize]) -> Vec<usize> {
    match shape {
        [] => vec![1, 1],
        [length] => vec![*length, 1],
        several => several.to_vec(),
    }
}

fn matrix(name: &str, array: &NamedArray) -> Vec<u8> {
    let shape = matlab_shape(&array.shape);
    let reversed: Vec<usize> = shape.iter().rev().copied().collect();
    let content = match &array.elements {
        Elements::Text(texts) if array.shape.is_empty() => {
            return char_array(name, texts.first().map_or("", String::as_str));
        }
        Elements::Text(_) => {
            let mut content = head(CELL, &shape, name);
            if let Elements::Text(texts) = to_row_major(array.elements.clone(), &reversed) {
                texts
                    .iter()
                    .for_each(|text| content.extend(char_array("", text)));
            }
            content
        }
        numbers => number_matrix(name, &shape, to_row_major(numbers.clone(), &reversed)),
    };
    wrap(&content)
}

/// Content of a matrix of numbers that are in column-major order already.
fn number_matrix(name: &str, shape: &[usize], numbers: Elements) -> Vec<u8> {
    let doubles = |values: &mut dyn Iterator<Item = f64>| -> Vec<u8> {
        values.flat_map(f64::to_le_bytes).collect()
    };
    match numbers {
        Elements::F32(values) => {
            let mut content = head(SINGLE, shape, name);
            let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
            push_element(&mut content, FLOAT, &bytes);
            content
        }
        Elements::Complex(values) => {
            let mut content = head_with(u32::from(DOUBLE) | COMPLEX, shape, name);
            push_element(
                &mut content,
                FLOAT64,
                &doubles(&mut values.iter().map(|v| v.re)),
            );
            push_element(
                &mut content,
                FLOAT64,
                &doubles(&mut values.iter().map(|v| v.im)),
            );
            content
        }
        numbers => {
            let mut content = head(DOUBLE, shape, name);
            let values = bytes::doubles(numbers);
            push_element(&mut content, FLOAT64, &doubles(&mut values.into_iter()));
            content
        }
    }
}

/// A text as a char array of one row: as 16-bit numbers, as MATLAB writes it, or in UTF-8 beyond
/// ASCII, as `scipy.io.savemat` does, which takes the lower half alone of 16-bit numbers.
fn char_array(name: &str, text: &str) -> Vec<u8> {
    let length = text.chars().count();
    let mut content = head(CHAR, &[usize::from(length > 0), length], name);
    if text.is_ascii() {
        let units: Vec<u8> = text.bytes().flat_map(|byte| [byte, 0]).collect();
        push_element(&mut content, UINT16, &units);
    } else {
        push_element(&mut content, UTF8, text.as_bytes());
    }
    wrap(&content)
}
