//! MATLAB files of version 4 (`save -v4`, also of Octave and scipy), which are only read.
//!
//! A file is a row of matrices without a header before them, each a header of 20 bytes, a name and
//! the numbers column by column, real parts before imaginary ones. Numbers of every precision in
//! both byte orders, texts and sparse matrices that fit are read. Arrays keep MATLAB's shape, so
//! that a vector has two dimensions; texts lose theirs.
//!
//! # Reference
//! MathWorks, MAT-File Format, chapter 2 (Level 4 MAT-File Format).

mod header;
mod store;

#[cfg(test)]
mod tests;

use crate::io::formats::arrays::source::open_arrays;
use crate::io::formats::arrays::store::ArrayStore;
use crate::io::{Confidence, Format, Hints, IoError, ReadSeek, Source};
use header::Header;

/// MATLAB file of version 4.
pub struct Matlab4;

impl Format for Matlab4 {
    fn name(&self) -> &'static str {
        "matlab4"
    }

    fn detect(&self, head: &[u8]) -> Confidence {
        match Header::parse(head) {
            Ok(_) => Confidence::Certain,
            Err(_) => Confidence::No,
        }
    }

    fn open(&self, input: Box<dyn ReadSeek>, hints: &Hints) -> Result<Box<dyn Source>, IoError> {
        open_arrays("matlab4", open_store(input, &hints.path)?, hints)
    }
}

/// The matrices of a file.
///
/// # Errors
/// As [`Format::open`].
pub(in crate::io) fn open_store(
    input: Box<dyn ReadSeek>,
    path: &str,
) -> Result<Box<dyn ArrayStore>, IoError> {
    Ok(Box::new(store::open(input, path)?))
}
