//! HDF5 files, and MATLAB files of version 7.3, which are HDF5 files with a header of 512 bytes.
//!
//! | stored | read as |
//! |---|---|
//! | integers of up to 64 bits, floating point numbers of up to 128 bits, enumerations, bool | real numbers; 32-bit floats stay 32-bit |
//! | compounds `{r, i}` (h5py), `{real, imag}` (MATLAB), `{re, im}` | complex numbers |
//! | texts of fixed and variable length | texts |
//! | arrays of MATLAB | row by row, with MATLAB's lengths |
//! | characters of MATLAB | a text for each row |
//! | cells of MATLAB | `name{1}`, `name{2}`, ... |
//! | groups, structures of MATLAB | `group/dataset` |
//!
//! Integers beyond 2^53 lose digits. The file is not read into memory: structure and values are
//! read when they are asked for. Soft links are followed; one that leads nowhere, and a link to
//! another file, is a finding.
//!
//! The reader is `hdf5-pure`. It does not know data layout version 5 (HDF5 2.0 with
//! `libver="latest"`), chunks in a version 2 B-tree (two unlimited dimensions, HDF5 1.10 or later),
//! the complex datatype of HDF5 2.0, virtual datasets and filters such as szip and blosc: such a
//! dataset is damage, the others are read. The feature `libhdf5` reads these too.

mod element;
mod item;
#[cfg(feature = "libhdf5")]
mod libhdf5;
mod links;
mod list;
mod present;
mod store;
mod stream;
mod write;

#[cfg(test)]
mod format_tests;
#[cfg(test)]
mod link_tests;
#[cfg(test)]
mod reference_tests;
#[cfg(test)]
mod store_tests;

use std::io::{Read, Seek, SeekFrom};

use crate::finding::Finding;
use crate::io::formats::arrays::source::open_arrays;
use crate::io::{Confidence, Format, Hints, IoError, ReadSeek, Source, WriteOptions, WriteSeek};
use store::Hdf5Store;
use stream::Stream;

/// HDF5 and MATLAB 7.3.
pub struct Hdf5;

/// The first bytes of an HDF5 file, after a header of its user's.
const SIGNATURE: [u8; 8] = *b"\x89HDF\r\n\x1a\n";

/// Where the signature may stand.
const SIGNATURE_AT: [usize; 4] = [0, 512, 1024, 2048];

/// How the header of a MATLAB file of version 7.3 begins.
const MATLAB_HEADER: &[u8] = b"MATLAB 7.3 MAT-file";

impl Format for Hdf5 {
    fn name(&self) -> &'static str {
        "hdf5"
    }

    fn written_extensions(&self) -> &'static [&'static str] {
        &["h5", "hdf5"]
    }

    fn detect(&self, head: &[u8]) -> Confidence {
        let marked = |at: &usize| {
            head.get(*at..)
                .is_some_and(|rest| rest.starts_with(&SIGNATURE))
        };
        if SIGNATURE_AT.iter().any(marked) {
            Confidence::Certain
        } else {
            Confidence::No
        }
    }

    fn open(&self, input: Box<dyn ReadSeek>, hints: &Hints) -> Result<Box<dyn Source>, IoError> {
        open_arrays("hdf5", Box::new(open_store(input, &hints.path)?), hints)
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

/// The arrays of an HDF5 file.
///
/// # Errors
/// [`IoError`] when its superblock cannot be read.
pub(in crate::io) fn open_store(
    mut input: Box<dyn ReadSeek>,
    path: &str,
) -> Result<Hdf5Store, IoError> {
    let system = |source| IoError::System {
        path: path.to_owned(),
        action: "read",
        source,
    };
    let mut head = Vec::with_capacity(MATLAB_HEADER.len());
    let header_length = MATLAB_HEADER.len() as u64;
    input.seek(SeekFrom::Start(0)).map_err(system)?;
    let mut header = input.by_ref().take(header_length);
    header.read_to_end(&mut head).map_err(system)?;
    let stream = Stream::new(input).map_err(system)?;
    let listing = list::list(&stream, head == MATLAB_HEADER, path)?;
    Ok(Hdf5Store::new(path.to_owned(), stream, listing))
}
