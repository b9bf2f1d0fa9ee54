//! Seeded changes of bytes damage files; a reader must meet its guarantees on every damaged file.
//!
//! A reader may refuse a damaged file or read its intact part. It must not panic, and it must not
//! ask for more memory than a small multiple of the file: a few bytes can say that a terabyte
//! follows.

use std::io::{Cursor, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};

use modalign::io::{
    Block, ColumnName, ColumnRole, FORMATS, Format, Hints, Source, TableColumn, TableSpec,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::seeds;

/// Largest memory of a reader over the size of the file ...
const MAX_MEMORY_OVER_FILE_SIZE: u64 = 64;

/// ... in addition to this number of bytes.
const MAX_ADDITIONAL_BYTES: u64 = 4 << 20;

/// Samples in a block that is read at once.
const BLOCK: usize = 4096;

/// A reader with its test files.
pub struct Reader {
    /// Name of the format.
    pub name: &'static str,
    /// Whole files of it.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// What a scene says of them.
    pub spec: fn() -> TableSpec,
}

/// Every reader, a line each; a table and an array are read as a scene describes them too.
#[rustfmt::skip]
pub const READERS: &[Reader] = &[
    Reader { name: "uff", seeds: seeds::uff, spec: TableSpec::default },
    Reader { name: "hdf5", seeds: seeds::hdf5, spec: TableSpec::default },
    Reader { name: "hdf5", seeds: seeds::hdf5_of_h5py, spec: chunks },
    Reader { name: "hdf5", seeds: seeds::hdf5_of_matlab, spec: matlab_arrays },
    Reader { name: "hdf5", seeds: seeds::hdf5_of_links, spec: linked },
    Reader { name: "modes", seeds: seeds::modes, spec: TableSpec::default },
    Reader { name: "modes-csv", seeds: seeds::modes_csv, spec: TableSpec::default },
    Reader { name: "npy", seeds: seeds::npy, spec: first_column },
    Reader { name: "npy", seeds: seeds::structured_npy, spec: field },
    Reader { name: "npz", seeds: seeds::npz, spec: TableSpec::default },
    Reader { name: "matlab4", seeds: seeds::matlab4, spec: second_column },
    Reader { name: "matlab5", seeds: seeds::matlab5, spec: TableSpec::default },
    Reader { name: "matlab5", seeds: seeds::matlab_array, spec: second_column },
    Reader { name: "pulse", seeds: seeds::pulse, spec: TableSpec::default },
    Reader { name: "signalcalc", seeds: seeds::signalcalc, spec: TableSpec::default },
    Reader { name: "table", seeds: seeds::table, spec: TableSpec::default },
    Reader { name: "table", seeds: seeds::plain_table, spec: acceleration },
    Reader { name: "table", seeds: seeds::complex_table, spec: complex_column },
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

/// Results of many damaged files.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outcome {
    /// Files.
    pub files: usize,
    /// Those that opened.
    pub opened: usize,
}

/// Tries a reader on `files` damaged files; the number of a file is all that makes it.
pub fn survives(reader: &Reader, files: usize) -> Outcome {
    let seeds = (reader.seeds)();
    let spec = (reader.spec)();
    assert!(!seeds.is_empty(), "{}", reader.name);
    let format = FORMATS
        .iter()
        .copied()
        .find(|format| format.name() == reader.name);
    let format = format.unwrap_or_else(|| panic!("no format {}", reader.name));
    for (number, seed) in seeds.iter().enumerate() {
        let whole = attempt(format, &spec, seed.clone());
        assert!(whole.opened, "{}: seed {number} opens", reader.name);
    }
    let opened = (0..files).into_par_iter().filter(|&number| {
        let bytes = damaged(&seeds[number % seeds.len()], number);
        let most = MAX_MEMORY_OVER_FILE_SIZE * bytes.len() as u64 + MAX_ADDITIONAL_BYTES;
        let end = attempt(format, &spec, bytes);
        assert!(
            !end.panicked,
            "{}: file {number} makes the reader panic",
            reader.name
        );
        assert!(
            end.peak <= most,
            "{}: file {number} takes {} bytes, expected at most {most}",
            reader.name,
            end.peak
        );
        end.opened
    });
    Outcome {
        files,
        opened: opened.count(),
    }
}

struct End {
    opened: bool,
    panicked: bool,
    peak: u64,
}

fn attempt(format: &dyn Format, spec: &TableSpec, bytes: Vec<u8>) -> End {
    let hints = Hints {
        path: "damaged".to_owned(),
        table: Some(spec.clone()),
    };
    let mut end = End {
        opened: false,
        panicked: false,
        peak: 0,
    };
    let info = allocation_counter::measure(|| {
        let read = AssertUnwindSafe(|| {
            let source = format.open(Box::new(Cursor::new(bytes)), &hints);
            source.map(|mut source| read_all(source.as_mut())).is_ok()
        });
        match catch_unwind(read) {
            Ok(opened) => end.opened = opened,
            Err(_) => end.panicked = true,
        }
    });
    end.peak = info.bytes_max;
    end
}

/// Reads every sample and abscissa that there is.
fn read_all(source: &mut dyn Source) {
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

/// The seed with one to five changes.
fn damaged(seed: &[u8], number: usize) -> Vec<u8> {
    let mut rng = ChaCha8Rng::seed_from_u64(number as u64);
    let mut bytes = seed.to_vec();
    for _ in 0..rng.random_range(1..6) {
        if bytes.is_empty() {
            bytes.push(rng.random());
        }
        change(&mut bytes, &mut rng);
    }
    bytes
}

fn change(bytes: &mut Vec<u8>, rng: &mut ChaCha8Rng) {
    let at = rng.random_range(0..bytes.len());
    let end = (at + rng.random_range(1..100)).min(bytes.len());
    match rng.random_range(0..10) {
        0 => bytes[at] = rng.random(),
        1 => bytes[at] ^= 1 << rng.random_range(0..8),
        2 => drop(bytes.splice(
            at..at,
            (0..rng.random_range(1..9)).map(|_| rng.random::<u8>()),
        )),
        3 => drop(bytes.drain(at..end)),
        4 => {
            let copy = bytes[at..end].to_vec();
            let to = rng.random_range(0..bytes.len());
            drop(bytes.splice(to..to, copy));
        }
        5 => {
            let part = end - at;
            let other = rng.random_range(0..=bytes.len() - part);
            for i in 0..part {
                bytes.swap(at + i, other + i);
            }
        }
        // The half that is kept is the longer one more often than not.
        6 => bytes.truncate(at.max(rng.random_range(0..bytes.len()))),
        7 => bytes[at..end].fill(rng.random_range(b'0'..=b'9')),
        8 => bytes[at..end].fill(0xff),
        _ => overwrite(&mut bytes[at..], rng),
    }
}

/// Puts a number there that is large for its width.
fn overwrite(bytes: &mut [u8], rng: &mut ChaCha8Rng) {
    let width = [2, 4, 8][rng.random_range(0..3)];
    let value = u64::MAX >> rng.random_range(0..63) >> (64 - 8 * width);
    let value = value.wrapping_sub(rng.random_range(0..2));
    let mut number = value.to_le_bytes()[..width].to_vec();
    if rng.random() {
        number.reverse();
    }
    let width = width.min(bytes.len());
    bytes[..width].copy_from_slice(&number[..width]);
}

/// A file that is kept packed.
pub fn unpacked(packed: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut unpacked = flate2::read::GzDecoder::new(packed);
    unpacked.read_to_end(&mut bytes).unwrap();
    bytes
}
