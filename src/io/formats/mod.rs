//! File formats: a folder or file for each, and what several of them need.
//!
//! A format implements [`Format`] and stands in [`FORMATS`]. Universal files (`uff`) and text
//! tables (`text`) hold records and FRFs entry by entry. HDF5, MATLAB and NumPy files hold named
//! arrays: each lists and reads them as an `arrays::store`, and [`arrays::schema`] gives them their
//! meaning. A new text format is a
//! file of `text`, such as `signalcalc`. A matrix file and a pole selection are no measurements:
//! `matrices` and `selection_json` read them directly and are not in [`FORMATS`].
//!
//! A format reads and writes the stream that it is given. It may use the catalogue, sources in
//! memory, scene-described columns and `convert`, never a scene or a path.

pub mod arrays;
mod damping_ratios;
mod dropped_content;
mod hdf5;
mod matlab4;
mod matlab5;
mod matrices;
mod modes_csv;
mod modes_json;
mod number;
mod numpy;
mod selection_json;
mod text;
mod text_coding;
mod uff;

use super::Format;

pub use hdf5::Hdf5;
pub use matlab4::Matlab4;
pub use matlab5::Matlab5;
pub use matrices::matrix_entries::MatrixEntries;
pub use matrices::read_matrix;
pub use modes_csv::ModesCsv;
pub use modes_json::ModesJson;
pub use modes_json::schema::{MODES_SCHEMA, modes_from_json, modes_to_json};
pub use numpy::{Npy, Npz};
pub use selection_json::{SELECTION_SCHEMA, read_selection, selection_from_json};
pub use text::{Pulse, SignalCalc, Table};
pub use uff::{FileLabel, Uff, write_frfs, write_time_records};

/// Every format that can be read; the content decides which one a file has. A text export that
/// states its channels is also in `TEXT_EXPORTS` of `scene/ingest`.
pub const FORMATS: &[&dyn Format] = &[
    &Uff,
    &Hdf5,
    &ModesJson,
    &Npy,
    &Npz,
    &Matlab5,
    &Matlab4,
    &Pulse,
    &SignalCalc,
    &ModesCsv,
    &Table,
];
