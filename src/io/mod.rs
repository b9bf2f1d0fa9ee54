//! Files in and out. Readers stream: [`Format::open`] scans headers into a [`Catalog`]; samples are
//! read when asked for.
//!
//! This stage knows types only: it never estimates, windows or identifies. It is one of the three
//! places that touch files (the others are `scene` and `cli`).

mod array;
mod assign;
mod catalog;
mod coherence;
mod damage;
mod error;
mod files;
mod format;
mod frfs;
mod function_type;
mod hdf5;
mod hit_file;
mod hit_groups;
mod hits;
pub mod layout;
mod matlab5;
mod matrix;
mod matrix_entries;
mod matrix_market;
mod memory;
mod modes_csv;
mod modes_format;
mod modes_json;
mod need;
mod not_carried;
mod note;
mod number;
mod numpy;
mod other_quantity;
mod sample_range;
mod selection_json;
mod sources;
mod stated_window;
mod table_spec;
mod text;
mod uff;

#[cfg(test)]
mod frfs_tests;
#[cfg(test)]
mod hits_tests;
#[cfg(test)]
mod matrix_tests;
#[cfg(test)]
mod modes_csv_tests;

pub use crate::frf::Window;
pub use catalog::{
    ArrayInfo, Catalog, Domain, Entry, EntryAxis, GeneralAxis, Identification, ModeEntry,
    SampleFormat,
};
pub use damage::{Damage, Part};
pub use error::IoError;
pub use files::{
    NewFile, TEMPORARY_PREFIX, bytes_for_path, detect, format_of, open_bytes, open_path,
    sha256_hex, sha256_of_bytes, writable_extensions, write_all_new, write_all_whole,
    write_atomically, write_path,
};
pub use format::{
    Block, Confidence, Encoding, Format, Hints, Precision, ReadSeek, Source, WriteOptions,
    WriteSeek,
};
pub use frfs::frf_sets;
pub use function_type::FunctionType;
pub use hdf5::Hdf5;
pub use hit_file::{ChannelOverride, HitFile, HitGrouping};
pub use hits::{FileRecording, HitSet, group_hits};
pub use matlab5::Matlab5;
pub use matrix::read_matrix;
pub use matrix_entries::MatrixEntries;
pub use memory::{MemorySource, Merged};
pub use modes_csv::ModesCsv;
pub use modes_format::{ModesJson, modes_of, modes_source};
pub use modes_json::{MODES_SCHEMA, modes_from_json, modes_to_json};
pub use need::{Need, check_damage};
pub use note::FunctionNote;
pub use numpy::{Npy, Npz};
pub use selection_json::{SELECTION_SCHEMA, read_selection, selection_from_json};
pub use sources::{FrfSource, frf_source, hit_source};
pub use table_spec::{ColumnName, ColumnRole, Delimiter, Dimension, TableColumn, TableSpec};
pub use text::{Pulse, SignalCalc, Table};
pub use uff::{FileLabel, Uff, write_frfs, write_time_records};

/// Every format that can be read; the content decides which one a file has.
pub const FORMATS: &[&dyn Format] = &[
    &Uff,
    &Hdf5,
    &ModesJson,
    &Npy,
    &Npz,
    &Matlab5,
    &Pulse,
    &SignalCalc,
    &ModesCsv,
    &Table,
];
