//! Every reader of files with its seeds, and how changed bytes become a file of it.

use modalign::io::{Block, ColumnName, ColumnRole, Source, TableColumn, TableSpec};

use crate::packing::Packing;
use crate::seeds;

/// Samples in a block that is read at once.
const BLOCK: usize = 4096;

/// A reader with its test files.
pub struct Reader {
    /// Name of the format.
    pub name: &'static str,
    /// Whole files of it, before they are packed.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// How the changed bytes become a file.
    pub packing: Packing,
    /// What a scene says of them.
    pub spec: fn() -> TableSpec,
}

/// Every reader, a line each; a table and an array are read as a scene describes them too.
#[rustfmt::skip]
pub const READERS: &[Reader] = &[
    Reader { name: "uff", seeds: seeds::uff, packing: Packing::Plain, spec: TableSpec::default },
    Reader { name: "uff", seeds: seeds::joined_uff, packing: Packing::Plain, spec: TableSpec::default },
    Reader { name: "uff", seeds: seeds::text_uff, packing: Packing::Utf16LittleEndian, spec: TableSpec::default },
    Reader { name: "uff", seeds: seeds::text_uff, packing: Packing::Utf16BigEndian, spec: TableSpec::default },
    Reader { name: "hdf5", seeds: seeds::hdf5, packing: Packing::Plain, spec: TableSpec::default },
    Reader { name: "hdf5", seeds: seeds::hdf5, packing: Packing::Hdf5CheckSums, spec: TableSpec::default },
    Reader { name: "hdf5", seeds: seeds::hdf5_of_h5py, packing: Packing::Plain, spec: chunks },
    Reader { name: "hdf5", seeds: seeds::hdf5_of_matlab, packing: Packing::Plain, spec: matlab_arrays },
    Reader { name: "hdf5", seeds: seeds::hdf5_of_links, packing: Packing::Hdf5CheckSums, spec: linked },
    Reader { name: "hdf5", seeds: seeds::hdf5_of_links, packing: Packing::Hdf5CheckSums, spec: TableSpec::default },
    Reader { name: "modes", seeds: seeds::modes, packing: Packing::Plain, spec: TableSpec::default },
    Reader { name: "modes-csv", seeds: seeds::modes_csv, packing: Packing::Plain, spec: TableSpec::default },
    Reader { name: "npy", seeds: seeds::npy, packing: Packing::Plain, spec: first_column },
    Reader { name: "npy", seeds: seeds::structured_npy, packing: Packing::Plain, spec: field },
    Reader { name: "npz", seeds: seeds::npz, packing: Packing::Plain, spec: TableSpec::default },
    Reader { name: "npz", seeds: seeds::npz_members, packing: Packing::Npz, spec: member },
    Reader { name: "matlab4", seeds: seeds::matlab4, packing: Packing::Plain, spec: second_column },
    Reader { name: "matlab4", seeds: seeds::matlab4_signalcalc, packing: Packing::Plain, spec: TableSpec::default },
    Reader { name: "matlab5", seeds: seeds::matlab5, packing: Packing::Plain, spec: TableSpec::default },
    Reader { name: "matlab5", seeds: seeds::matlab_array, packing: Packing::Matlab5Deflated, spec: second_column },
    Reader { name: "matlab5", seeds: seeds::matlab_signalcalc, packing: Packing::Matlab5, spec: TableSpec::default },
    Reader { name: "matlab5", seeds: seeds::matlab_signalcalc, packing: Packing::Matlab5Deflated, spec: TableSpec::default },
    Reader { name: "matlab5", seeds: seeds::matlab_struct, packing: Packing::Matlab5Deflated, spec: struct_field },
    Reader { name: "pulse", seeds: seeds::pulse, packing: Packing::Plain, spec: TableSpec::default },
    Reader { name: "signalcalc", seeds: seeds::signalcalc, packing: Packing::Plain, spec: TableSpec::default },
    Reader { name: "table", seeds: seeds::table, packing: Packing::Plain, spec: TableSpec::default },
    Reader { name: "table", seeds: seeds::plain_table, packing: Packing::Plain, spec: acceleration },
    Reader { name: "table", seeds: seeds::complex_table, packing: Packing::Plain, spec: complex_column },
    Reader { name: "table", seeds: seeds::complex_table, packing: Packing::Utf16LittleEndian, spec: complex_column },
];

fn response(column: ColumnName) -> TableColumn {
    TableColumn {
        column,
        role: ColumnRole::Response {
            dof: "1:+Z".parse().ok(),
            unit: "m/s^2".parse().unwrap(),
        },
        scale: 1.0,
    }
}

/// The second column of `seeds::plain_table`.
fn acceleration() -> TableSpec {
    TableSpec {
        sampling_rate_hz: Some(1000.0),
        columns: vec![response(ColumnName::Heading("acceleration".to_owned()))],
        ..TableSpec::default()
    }
}

/// The FRF of `seeds::complex_table`.
fn complex_column() -> TableSpec {
    let column = |number, role| TableColumn {
        column: ColumnName::Number(number),
        role,
        scale: 1.0,
    };
    let frf = ColumnRole::Complex {
        dof: "1:+Z".parse().ok(),
        unit: "(m/s2)/N".parse().unwrap(),
    };
    TableSpec {
        columns: vec![column(1, ColumnRole::Frequency), column(2, frf)],
        ..TableSpec::default()
    }
}

fn columns(names: &[&str]) -> TableSpec {
    let columns = names
        .iter()
        .map(|name| response(ColumnName::Heading((*name).to_owned())));
    TableSpec {
        sampling_rate_hz: Some(1000.0),
        columns: columns.collect(),
        ..TableSpec::default()
    }
}

/// Compressed chunks of `seeds::hdf5_of_h5py`.
fn chunks() -> TableSpec {
    columns(&["run/chunks:2"])
}

/// Arrays of `seeds::hdf5_of_matlab`, which are turned.
fn matlab_arrays() -> TableSpec {
    columns(&["a:3", "s/H:1"])
}

/// A soft link of `seeds::hdf5_of_links` through another.
fn linked() -> TableSpec {
    columns(&["run/inner/through"])
}

/// A field of `seeds::structured_npy`, whose array has the name of the file.
fn field() -> TableSpec {
    columns(&["damaged/s/y:2"])
}

/// A nested field of an archive's member.
fn member() -> TableSpec {
    columns(&["run/s/y:2"])
}

/// A field of `seeds::matlab_struct`.
fn struct_field() -> TableSpec {
    columns(&["s(2)/b/c:1"])
}

/// The second column of `seeds::matlab_array` and `seeds::matlab4`.
fn second_column() -> TableSpec {
    columns(&["a:2"])
}

/// The first column of an array.
fn first_column() -> TableSpec {
    TableSpec {
        sampling_rate_hz: Some(1000.0),
        columns: vec![response(ColumnName::Number(1))],
        ..TableSpec::default()
    }
}

/// Reads every sample and abscissa that there is.
pub fn read_all(source: &mut dyn Source) {
    let mut block = Block::F64(Vec::new());
    let mut abscissa = Vec::new();
    for entry in 0..source.catalog().entries.len() {
        let len = source.catalog().entries[entry].len();
        for start in (0..len).step_by(BLOCK) {
            let range = start..len.min(start + BLOCK);
            let read = source.read(entry, range.clone(), &mut block);
            let along = source.abscissa(entry, range, &mut abscissa);
            if read.is_err() || along.is_err() {
                break;
            }
        }
    }
}
