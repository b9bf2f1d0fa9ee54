//! MATLAB files of version 5 (MATLAB 5 to 7, `save -v6` and `-v7`), read and written without
//! MATLAB.
//!
//! A file is a header of 128 bytes and data elements, each a tag (type and byte count) and its
//! bytes; a variable is a matrix element, plain or deflated. Both byte orders are read. Every
//! variable, field and cell is listed: fields as `name/field`, elements of a struct array as
//! `name(2)/field`, cells as `name{3}`. Numbers of all classes, complex and logical ones, texts,
//! cells of texts and sparse matrices that fit are read; objects, function handles and opaque data
//! are listed only. Arrays keep MATLAB's shape, so that a vector has two dimensions; texts lose
//! theirs.
//!
//! Written files hold the schema of modalign as structs (`frf.re`), texts as char and cells of
//! char, not compressed, so that a variable can be read without what is before it. Files of version
//! 7.3 are HDF5.
//!
//! # Reference
//! MathWorks, MAT-File Format, chapter 1 (Level 5 MAT-File Format).

mod bytes;
mod elements;
mod header;
mod list;
mod store;
mod values;
mod write;

#[cfg(test)]
mod damage_tests;
#[cfg(test)]
mod file_builder;
#[cfg(test)]
mod signalcalc_tests;
#[cfg(test)]
mod tests;
use std::io::SeekFrom;

use crate::finding::Finding;

use crate::io::formats::arrays::source::open_arrays;
use crate::io::formats::arrays::store::ArrayStore;
use crate::io::{Confidence, Format, Hints, IoError, ReadSeek, Source, WriteOptions, WriteSeek};
use header::{BIG_ENDIAN, HEADER, LITTLE_ENDIAN};

/// MATLAB file of version 5.
pub struct Matlab5;

impl Format for Matlab5 {
    fn name(&self) -> &'static str {
        "matlab5"
    }

    fn written_extensions(&self) -> &'static [&'static str] {
        &["mat"]
    }

    fn detect(&self, head: &[u8]) -> Confidence {
        match head.get(HEADER - 4..HEADER) {
            Some(LITTLE_ENDIAN | BIG_ENDIAN) => Confidence::Certain,
            _ => Confidence::No,
        }
    }

    fn open(&self, input: Box<dyn ReadSeek>, hints: &Hints) -> Result<Box<dyn Source>, IoError> {
        open_arrays("matlab5", open_store(input, &hints.path)?, hints)
    }

    fn write(
        &self,
        out: &mut dyn WriteSeek,
        source: &mut dyn Source,
        options: &WriteOptions,
    ) -> Result<Vec<Finding>, IoError> {
        write::write(out, source, options)
    }
}

/// The variables of a file.
///
/// # Errors
/// As [`Format::open`].
pub(in crate::io) fn open_store(
    mut input: Box<dyn ReadSeek>,
    path: &str,
) -> Result<Box<dyn ArrayStore>, IoError> {
    let system = |source| IoError::System {
        path: path.to_owned(),
        action: "read",
        source,
    };
    let mut header = [0; HEADER];
    input.seek(SeekFrom::Start(0)).map_err(system)?;
    input.read_exact(&mut header).map_err(system)?;
    let mark = &header[HEADER - 4..];
    if mark != LITTLE_ENDIAN && mark != BIG_ENDIAN {
        return Err(IoError::Binary {
            path: path.to_owned(),
            byte: HEADER as u64 - 4,
            what: "version and byte order",
            got: format!("{mark:02x?}"),
            expected: "version 1 and IM, or MI in a big-endian file (version 2 is HDF5)".to_owned(),
        });
    }
    let store = store::open(input, mark == BIG_ENDIAN, path)?;
    Ok(Box::new(store))
}
