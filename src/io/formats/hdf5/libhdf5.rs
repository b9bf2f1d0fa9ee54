//! Datasets that the default reader cannot read, through the library of The HDF Group.
//!
//! The library opens the file by its path, so that bytes that are not a file stay unread. Numbers
//! and complex numbers are read; texts are not.

use hdf5_metno::types::TypeDescriptor;
use hdf5_metno::{Dataset, Error, File, H5Type};
use num_complex::Complex64;

use super::element::Content;
use super::item::{Item, bytes_of};
use crate::io::formats::arrays::store::Elements;

/// Deflate makes at most so many bytes of one.
const MAX_EXPANSION_RATIO: u64 = 1032;

/// Complex numbers of h5py, and of the HDF5 complex type.
#[derive(Clone, Copy, H5Type)]
#[repr(C)]
struct Pair {
    r: f64,
    i: f64,
}

/// Complex numbers of MATLAB. The library matches members by their names and leaves those that it
/// does not find unchanged, so that each spelling needs a separate type.
#[derive(Clone, Copy, H5Type)]
#[repr(C)]
struct MatlabPair {
    real: f64,
    imag: f64,
}

/// The elements in stored order, or why they cannot be read.
pub(super) fn read(path: &str, item: &Item) -> Result<Elements, String> {
    let name = item.path.as_deref().unwrap_or_default();
    read_dataset(path, name, item).map_err(|error| format!("libhdf5: {error}"))
}

fn read_dataset(path: &str, name: &str, item: &Item) -> Result<Elements, Error> {
    let dataset = File::open(path)?.dataset(name)?;
    let needed = bytes_of(&item.stored, item.stride).unwrap_or(usize::MAX) as u64;
    let most = dataset.storage_size().saturating_mul(MAX_EXPANSION_RATIO);
    if needed > most.saturating_add(1 << 16) || dataset.shape() != item.stored {
        let got = format!("{needed} bytes of shape {:?}", item.stored);
        return Err(Error::from(format!("{got} do not fit what the file holds")));
    }
    match &item.content {
        Content::Single(_) => Ok(Elements::F32(dataset.read_raw()?)),
        Content::Real(_) => Ok(Elements::F64(dataset.read_raw()?)),
        Content::Complex(..) | Content::NativeComplex => complex(&dataset),
        _ => Err(Error::from("numbers are read, other elements are not")),
    }
}

fn complex(dataset: &Dataset) -> Result<Elements, Error> {
    let matlab = match dataset.dtype()?.to_descriptor() {
        Ok(TypeDescriptor::Compound(compound)) => {
            compound.fields.iter().any(|field| field.name == "real")
        }
        _ => false,
    };
    Ok(Elements::Complex(if matlab {
        let pairs = dataset.read_raw::<MatlabPair>()?;
        let value = |pair: &MatlabPair| Complex64::new(pair.real, pair.imag);
        pairs.iter().map(value).collect()
    } else {
        let pairs = dataset.read_raw::<Pair>()?;
        let value = |pair: &Pair| Complex64::new(pair.r, pair.i);
        pairs.iter().map(value).collect()
    }))
}
