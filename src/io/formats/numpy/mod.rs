//! NumPy files: one array (`.npy`) and a zip archive of them (`.npz`).
//!
//! Numbers of every width and byte order, in C and Fortran order, and fixed-width texts are read,
//! also as fields of structured arrays. Arrays of Python objects (pickles), dates and long doubles
//! are listed, not read. `.npz` is written in the schema of modalign, stored without compression,
//! so that a part of an array can be read alone.
//!
//! # Reference
//! NumPy documentation, `numpy.lib.format`, format versions 1.0 to 3.0.

mod header;
mod items;
mod literal;
mod npy;
mod npz;
mod record;
mod until_failed;

#[cfg(test)]
mod tests;

pub use npy::Npy;
pub use npz::Npz;

pub(in crate::io) use npy::open_npy;
pub(in crate::io) use npz::open_npz;
