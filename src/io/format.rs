//! A format opens a file as a source, which lists its contents and reads samples on demand, and
//! writes sources.

use std::io::{Read, Seek, Write};
use std::ops::Range;

use num_complex::Complex64;

use crate::finding::Finding;
use crate::io::catalog::sample_range::{check_range, even_abscissa, uneven_without_values};
use crate::io::{Catalog, Damage, IoError, TableSpec};

/// A byte stream that can be read and sought.
pub trait ReadSeek: Read + Seek + Send {}
impl<T: Read + Seek + Send> ReadSeek for T {}

/// A byte stream that can be written and sought.
pub trait WriteSeek: Write + Seek {}
impl<T: Write + Seek> WriteSeek for T {}

/// How certainly bytes are of a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Confidence {
    /// Not this format.
    No,
    /// Could be: plain text that any table reader would take.
    Possible,
    /// The bytes carry the signature of the format.
    Certain,
}

/// The knowledge of the caller about a file beyond its bytes.
#[derive(Clone, Debug, Default)]
pub struct Hints {
    /// Path as given, for messages and findings.
    pub path: String,
    /// How to read a table of numbers, or arrays that do not say what they mean.
    pub table: Option<TableSpec>,
}

/// A file format that can be read.
pub trait Format: Sync {
    /// Name for `--format` and messages.
    fn name(&self) -> &'static str;

    /// Extensions under which it is written, in lower case; none where it is only read. Reading
    /// goes by content.
    fn written_extensions(&self) -> &'static [&'static str] {
        &[]
    }

    /// Whether the format is the one of its extension for what a catalogue lists; the first one
    /// that is writes it.
    fn takes(&self, _catalog: &Catalog) -> bool {
        true
    }

    /// Judges the first bytes of a file (up to 4 KiB).
    fn detect(&self, head: &[u8]) -> Confidence;

    /// Scans the headers of a file.
    ///
    /// # Errors
    /// [`IoError`] when nothing of the file can be used. A partly bad file opens, and its
    /// [`Catalog::damage`] says what is missing and where.
    fn open(&self, input: Box<dyn ReadSeek>, hints: &Hints) -> Result<Box<dyn Source>, IoError>;

    /// Writes everything that a source holds and the format can; what it cannot is left out with a
    /// finding of [`crate::finding::Code::NotCarried`].
    ///
    /// # Errors
    /// [`IoError::Unwritable`] for a value that the format has no place for although it holds the
    /// kind; reading errors of the source; [`IoError::System`] when writing fails.
    fn write(
        &self,
        _out: &mut dyn WriteSeek,
        _source: &mut dyn Source,
        options: &WriteOptions,
    ) -> Result<Vec<Finding>, IoError> {
        Err(IoError::Unwritable {
            path: options.path.clone(),
            what: "this format",
            got: self.name().to_owned(),
            expected: "a format that is written".to_owned(),
        })
    }
}

/// How a file is to be written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// Path, for messages.
    pub path: String,
    /// Numbers as bytes or text, where the format has both.
    pub encoding: Encoding,
    /// Width of the numbers; as stored when not stated.
    pub precision: Option<Precision>,
}

/// Width of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Precision {
    /// 32 bits, as measurement systems export.
    #[default]
    Single,
    /// 64 bits.
    Double,
}

/// How values are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Encoding {
    /// As bytes, to the bit.
    #[default]
    Binary,
    /// As text, 13 digits for 64 bits.
    Text,
}

/// An opened file: what is in it, and its samples on demand.
///
/// A format implements the first three methods, and [`Source::read_abscissa`] where it has uneven
/// axes. Callers use the others, which check the range and are not to be overridden.
pub trait Source: Send {
    /// The contents of the headers.
    fn catalog(&self) -> &Catalog;

    /// As [`Source::catalog`], to take its damage; the entries stay as they are.
    fn catalog_mut(&mut self) -> &mut Catalog;

    /// Reads samples `range` of entry `entry` into `block`, replacing what it held. Single
    /// precision stays single. The range lies inside the entry.
    ///
    /// # Errors
    /// [`IoError`] with the place when the bytes are not there or are not numbers.
    fn read_samples(
        &mut self,
        entry: usize,
        range: Range<usize>,
        block: &mut Block,
    ) -> Result<(), IoError>;

    /// Puts the abscissa of samples `range` of entry `entry`, whose axis is uneven, into `out`,
    /// replacing what it held, in s, Hz or the unit of the file. The range lies inside the entry.
    ///
    /// # Errors
    /// As [`Source::read_samples`]; [`IoError::NotStated`] where the file has no values.
    fn read_abscissa(
        &mut self,
        entry: usize,
        _range: Range<usize>,
        _out: &mut Vec<f64>,
    ) -> Result<(), IoError> {
        Err(uneven_without_values(self.catalog(), entry))
    }

    /// Takes what [`Catalog::damage`] holds, for a chain that stops at it.
    fn take_damage(&mut self) -> Vec<Damage> {
        std::mem::take(&mut self.catalog_mut().damage)
    }

    /// [`Source::read_samples`] of any range.
    ///
    /// # Errors
    /// As there; [`IoError::Binary`] for a range that is not inside an entry.
    fn read(
        &mut self,
        entry: usize,
        range: Range<usize>,
        block: &mut Block,
    ) -> Result<(), IoError> {
        check_range(self.catalog(), entry, &range)?;
        self.read_samples(entry, range, block)
    }

    /// The abscissa of samples `range` of entry `entry`, in s, Hz or the unit of the file.
    ///
    /// # Errors
    /// As [`Source::read_abscissa`]; [`IoError::Binary`] for a range that is not inside an entry.
    fn abscissa(
        &mut self,
        entry: usize,
        range: Range<usize>,
        out: &mut Vec<f64>,
    ) -> Result<(), IoError> {
        check_range(self.catalog(), entry, &range)?;
        if range.is_empty() {
            out.clear();
            return Ok(());
        }
        match self.catalog().entries[entry].axis.even() {
            Some(even) => {
                even_abscissa(even, range, out);
                Ok(())
            }
            None => self.read_abscissa(entry, range, out),
        }
    }
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
