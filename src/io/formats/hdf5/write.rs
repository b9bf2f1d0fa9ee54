//! Writing: modalign's schema of arrays as groups and datasets.
//!
//! Datasets are contiguous and not compressed, texts are UTF-8 of fixed length padded with zeros,
//! and the structure is that of HDF5 1.8, so that h5py and MATLAB (`h5read`) of any age read the
//! file. The numbers are those of the arrays, to the bit. The file is put together in memory.

use std::collections::BTreeMap;

use hdf5_pure::{DatasetBuilder, FileBuilder, FormatError, GroupBuilder, LibVer};

use crate::finding::Finding;
use crate::io::formats::arrays::schema;
use crate::io::formats::arrays::store::{Elements, NamedArray};
use crate::io::{IoError, Source, WriteOptions, WriteSeek};

/// Writes what a source holds.
///
/// # Errors
/// Errors of the source; [`IoError::System`] when writing fails.
pub(super) fn write(
    out: &mut dyn WriteSeek,
    source: &mut dyn Source,
    options: &WriteOptions,
) -> Result<Vec<Finding>, IoError> {
    let mut file = FileBuilder::new();
    file.with_libver_bounds(LibVer::Earliest, LibVer::V18);
    let mut groups: BTreeMap<String, GroupBuilder> = BTreeMap::new();
    let mut put = |array: NamedArray| {
        let filled = match array.name.split_once('/') {
            None => fill(file.create_dataset(&array.name), &array),
            Some((group, name)) => {
                let known = groups.entry(group.to_owned());
                let group = known.or_insert_with(|| file.create_group(group));
                fill(group.create_dataset(name), &array)
            }
        };
        filled.map_err(|error| unwritable(&options.path, &array.name, &error.to_string()))
    };
    let findings = schema::write_with_schema(source, options.precision, &mut put)?;
    for group in groups.into_values() {
        file.add_group(group.finish());
    }
    match file.finish_to(out) {
        Ok(()) => Ok(findings),
        Err(hdf5_pure::Error::Io(source)) => Err(IoError::System {
            path: options.path.clone(),
            action: "write",
            source,
        }),
        Err(error) => Err(unwritable(&options.path, "the file", &error.to_string())),
    }
}

fn fill(dataset: &mut DatasetBuilder, array: &NamedArray) -> Result<(), FormatError> {
    let shape: Vec<u64> = array.shape.iter().map(|&length| length as u64).collect();
    match &array.elements {
        Elements::F32(values) => dataset.with_f32_data(values),
        Elements::F64(values) => dataset.with_f64_data(values),
        Elements::Complex(values) => {
            let pairs: Vec<(f64, f64)> = values.iter().map(|value| (value.re, value.im)).collect();
            dataset.with_complex64_data(&pairs)
        }
        Elements::Text(values) => {
            let texts: Vec<&str> = values.iter().map(String::as_str).collect();
            dataset.with_strings(&texts)?
        }
    };
    dataset.with_shape(&shape);
    Ok(())
}

fn unwritable(path: &str, name: &str, got: &str) -> IoError {
    IoError::Unwritable {
        path: path.to_owned(),
        what: "an HDF5 dataset",
        got: format!("{name}: {got}"),
        expected: "numbers or texts of a shape that HDF5 holds".to_owned(),
    }
}
