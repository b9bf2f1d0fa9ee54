//! Files in and out. Readers stream: [`Format::open`] scans headers into a [`Catalog`]; samples are read when asked for.
//!
//! This stage knows types only: it never estimates, windows or identifies. It is one of the three places that touch
//! files (the others are `scene` and `cli`).

mod catalog;
mod error;
mod files;
mod frfs;
mod hits;
mod modes_json;
mod table;
mod table_columns;
mod table_spec;
mod uff;

#[cfg(test)]
mod hits_tests;
#[cfg(test)]
mod table_tests;

pub use catalog::{Catalog, Entry, EntryAxis, FunctionType, Identification, SampleFormat};
pub use error::IoError;
pub use files::{
    detect, format_of, open_bytes, open_path, sha256_hex, sha256_of_bytes, write_atomically,
    write_whole,
};
pub use frfs::{FunctionNote, frf_sets};
pub use hits::{ChannelOverride, HitFile, HitGrouping, HitSet, group_hits, has_time_records};
pub use modes_json::{MODES_SCHEMA, modes_from_json, modes_to_json};
pub use table::Table;
pub use table_spec::{ColumnName, ColumnRole, Delimiter, TableColumn, TableSpec};
pub use uff::{Encoding, FileLabel, Precision, Uff, write_frfs, write_time_records};

use std::io::{Read, Seek};
use std::ops::Range;

use num_complex::Complex64;

/// A byte stream that can be read and sought.
pub trait ReadSeek: Read + Seek + Send {}
impl<T: Read + Seek + Send> ReadSeek for T {}

/// How sure a format is that bytes are its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Confidence {
    /// Not this format.
    No,
    /// Could be: plain text that any table reader would take.
    Possible,
    /// The format's own mark is there.
    Certain,
}

/// What the caller knows of a file beyond its bytes.
#[derive(Clone, Debug, Default)]
pub struct Hints {
    /// Path as given, for messages and findings.
    pub path: String,
    /// How to read a table of numbers; needed by text tables alone.
    pub table: Option<TableSpec>,
}

/// A file format that can be read.
pub trait Format: Sync {
    /// Name for `--format` and messages.
    fn name(&self) -> &'static str;

    /// Judges the first bytes of a file (up to 4 KiB).
    fn detect(&self, head: &[u8]) -> Confidence;

    /// Scans the headers of a file.
    ///
    /// # Errors
    /// [`IoError`] when nothing of the file can be used. A partly bad file opens, and its
    /// [`Catalog::damage`] says what is missing and where.
    fn open(&self, input: Box<dyn ReadSeek>, hints: &Hints) -> Result<Box<dyn Source>, IoError>;
}

/// An opened file: what is in it, and its samples on demand.
pub trait Source: Send {
    /// What the headers say.
    fn catalog(&self) -> &Catalog;

    /// Takes what [`Catalog::damage`] holds, for a chain that stops at it.
    fn take_damage(&mut self) -> Vec<IoError>;

    /// Reads samples `range` of entry `entry` into `block`, replacing what it held. Single precision stays single.
    ///
    /// # Errors
    /// [`IoError`] with the place when the bytes are not there or are not numbers.
    fn read(&mut self, entry: usize, range: Range<usize>, block: &mut Block)
    -> Result<(), IoError>;
}

/// Samples of one entry as the file stores them.
#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    /// Real, single precision.
    F32(Vec<f32>),
    /// Real, double precision.
    F64(Vec<f64>),
    /// Complex.
    Complex(Vec<Complex64>),
}

/// Every format that can be read; the content decides which one a file has.
pub const FORMATS: &[&dyn Format] = &[&Uff, &Table];
