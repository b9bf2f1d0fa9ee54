//! Files in and out. Readers stream: [`Format::open`] scans headers into a [`Catalog`]; samples are
//! read when asked for.
//!
//! | folder or file | what it holds |
//! |---|---|
//! | `error` | why a file cannot be read or written |
//! | `catalog` | what the headers of a file state, the same for every format |
//! | `format` | the traits [`Format`] and [`Source`] |
//! | `memory` | sources in memory |
//! | `columns` | columns of numbers whose meaning a scene states |
//! | `convert` | entries of catalogues as hits, FRF sets and modal models |
//! | `formats` | the file formats, and [`FORMATS`], the list of them |
//! | `open`, `input` | files opened by their content when they are read |
//! | `write`, `results` | files written whole or not at all, and folders of them with a manifest |
//!
//! This stage knows types only: it never estimates, windows or identifies. It is one of the three
//! places that touch files (the others are `scene` and `cli`).

mod catalog;
mod columns;
mod convert;
mod error;
mod format;
mod formats;
mod input;
mod memory;
mod open;
mod results;
mod write;

pub use crate::frf::Window;
pub use catalog::{
    ArrayInfo, Catalog, Damage, Domain, Entry, EntryAxis, FunctionMetadata, FunctionType,
    GeneralAxis, Identification, ModeEntry, Part, SampleFormat,
};
pub use columns::{ColumnName, ColumnRole, Delimiter, Dimension, TableColumn, TableSpec};
pub use convert::{
    ChannelOverride, FileRecording, HitFile, HitGrouping, HitSet, Need, StatedFrfUnit,
    check_damage, check_stated_points, frf_sets, group_hits, modal_model_of,
};
pub use error::IoError;
pub use format::{
    Block, Confidence, Encoding, Format, Hints, Precision, ReadSeek, Source, WriteOptions,
    WriteSeek,
};
pub use formats::arrays::schema as array_schema;
pub use formats::{
    FORMATS, FileLabel, Hdf5, MODES_SCHEMA, Matlab4, Matlab5, MatrixEntries, ModesCsv, ModesJson,
    Npy, Npz, Pulse, SELECTION_SCHEMA, SignalCalc, Table, Uff, modes_from_json, modes_to_json,
    read_matrix, read_selection, selection_from_json, write_frfs, write_time_records,
};
pub use input::{read_input, read_input_part};
pub use memory::{FrfSource, MemorySource, Merged, frf_source, hit_source, modes_source};
pub use open::{detect, format_of, open_bytes, open_path, sha256_hex, sha256_of_bytes};
pub use results::{
    MANIFEST_SCHEMA, ResultFile, ResultsFolder, check_result, check_results, forget_result,
};
pub use write::{
    NewFile, bytes_for_path, is_stream, open_file_number, remove_unfinished, resolved_target,
    writable_extensions, write_all_new, write_all_whole, write_atomically, write_path,
};
