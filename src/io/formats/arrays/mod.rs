//! Named arrays, the content of HDF5, MATLAB and NumPy files.
//!
//! A store lists and reads the arrays of one file. The schema gives names and shapes to records,
//! FRFs, geometry and modes. A source reads the arrays of a store by the schema, by a scene's
//! description, by the names of a measurement system (`signalcalc`), or lists them without a
//! meaning. Nothing here knows the bytes of a file.

pub(in crate::io) mod limited;
pub mod schema;
mod signalcalc;
pub(in crate::io) mod source;
pub(in crate::io) mod store;

#[cfg(test)]
mod recording_tests;
