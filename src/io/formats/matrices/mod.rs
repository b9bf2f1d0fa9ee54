//! One real matrix of a file: Matrix Market, or an array of MATLAB, HDF5, NPZ and NPY, full or
//! sparse.
//!
//! | file | full | sparse |
//! |---|---|---|
//! | Matrix Market | `array` | `coordinate` |
//! | MATLAB 4 and 5 | a variable | a sparse variable |
//! | HDF5, MATLAB 7.3 | a dataset | a group of `data`, `ir`, `jc` (MATLAB), or as in NPZ |
//! | NPZ | an array | `data`, `indices`, `indptr`, `shape`, `format` (csr, csc) or `data`, `row`, `col`, `shape` (coo), which is what scipy.sparse writes; below a name where one is given |
//!
//! A sparse group without a shape is square; without a format its entries are those of rows (csr).

pub(super) mod matrix_entries;
mod matrix_market;
#[cfg(test)]
mod tests;

use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use super::arrays::limited::Limited;
use super::arrays::source::{describe_arrays, same_name};
use super::arrays::store::{ArrayStore, Elements, NamedArray};
use super::{hdf5, matlab4, matlab5, numpy};
use crate::io::input::open_input;
use crate::io::open::content_kind;
use crate::io::{IoError, ReadSeek, detect};
use matrix_entries::MatrixEntries;

/// Bytes by which a file is known.
const DETECTION_BYTES: u64 = 4096;

/// Reads a matrix from a file, by its name where the file has names; an unnamed one is the only
/// matrix of the file.
///
/// # Errors
/// [`IoError`] with line or byte for damage; [`IoError::UnknownFormat`]; [`IoError::Grouping`] for
/// a name that is not there or holds no real matrix.
pub fn read_matrix(path: &Path, name: Option<&str>) -> Result<MatrixEntries, IoError> {
    let shown = path.display().to_string();
    let system = |action| {
        let path = shown.clone();
        move |source| IoError::System {
            path,
            action,
            source,
        }
    };
    let mut file = open_input(path).map_err(system("open"))?;
    let mut head = Vec::new();
    file.by_ref()
        .take(DETECTION_BYTES)
        .read_to_end(&mut head)
        .map_err(system("read"))?;
    file.seek(SeekFrom::Start(0)).map_err(system("read"))?;
    let input = BufReader::new(file);
    let mark = head.get(..matrix_market::MARK.len());
    if mark.is_some_and(|mark| mark.eq_ignore_ascii_case(matrix_market::MARK)) {
        return matrix_market::read(input, &shown);
    }
    let store = open_store(Box::new(input), &head, &shown)?;
    matrix_of(&mut Limited::new(store, &shown), name, &shown)
}

fn open_store(
    input: Box<dyn ReadSeek>,
    head: &[u8],
    path: &str,
) -> Result<Box<dyn ArrayStore>, IoError> {
    Ok(
        match detect(head, path).map_or("", |format| format.name()) {
            "hdf5" => Box::new(hdf5::open_store(input, path)?),
            "matlab4" => matlab4::open_store(input, path)?,
            "matlab5" => matlab5::open_store(input, path)?,
            "npz" => numpy::open_npz(input, path)?,
            "npy" => numpy::open_npy(input, path)?,
            _ => {
                return Err(IoError::UnknownFormat {
                    path: path.to_owned(),
                    got: content_kind(head),
                    known: "Matrix Market, matlab4, matlab5, hdf5, npz and npy (for a matrix)"
                        .to_owned(),
                });
            }
        },
    )
}

/// The matrix of a name in a container.
fn matrix_of(
    store: &mut dyn ArrayStore,
    name: Option<&str>,
    path: &str,
) -> Result<MatrixEntries, IoError> {
    let matrix = match name {
        Some(name) => match find_array(store, name) {
            Some(index) => Some(whole(store, index, path)?),
            None => sparse_group(store, name, path)?,
        },
        None => match (sparse_group(store, "", path)?, only_matrix(store)) {
            (Some(matrix), _) => Some(matrix),
            (None, Some(index)) => Some(whole(store, index, path)?),
            (None, None) => None,
        },
    };
    // What is asked for may be what is damaged.
    matrix.ok_or_else(|| match store.take_damage().into_iter().next() {
        Some(damage) => damage,
        None => {
            let expected = name.map_or("one matrix, or its name".to_owned(), |name| {
                format!("an array, or a sparse group, `{name}`")
            });
            not_a_matrix(path, describe_arrays(store), &expected)
        }
    })
}

fn not_a_matrix(path: &str, got: String, expected: &str) -> IoError {
    IoError::Grouping {
        path: path.to_owned(),
        what: "reading a matrix",
        got,
        expected: expected.to_owned(),
    }
}

fn find_array(store: &dyn ArrayStore, name: &str) -> Option<usize> {
    let name = name.trim_start_matches('/');
    let mut list = store.list().iter();
    list.position(|info| same_name(&info.name, name))
}

fn only_matrix(store: &dyn ArrayStore) -> Option<usize> {
    let list = store.list().iter().enumerate();
    let mut matrices = list.filter(|(_, info)| info.shape.len() == 2 && info.kind != "text");
    let first = matrices.next()?.0;
    matrices.next().is_none().then_some(first)
}

/// An array as a matrix, sparse where the file keeps it so.
fn whole(store: &mut dyn ArrayStore, index: usize, path: &str) -> Result<MatrixEntries, IoError> {
    if let Some(sparse) = store.read_sparse(index)? {
        return Ok(sparse);
    }
    let array = store.read(index)?;
    let [rows, columns] = array.shape[..] else {
        let got = format!("{} of shape {:?}", array.name, array.shape);
        return Err(not_a_matrix(path, got, "two dimensions"));
    };
    let name = array.name.clone();
    let values = doubles(array, path)?;
    let mut entries = Vec::new();
    for (place, value) in values.into_iter().enumerate() {
        let (row, column) = (place / columns, place % columns);
        if !value.is_finite() {
            let got = format!("{value} at row {row}, column {column} (from 0) of {name}");
            return Err(not_a_matrix(path, got, "finite numbers"));
        }
        if value.abs() > 0.0 {
            entries.push((row, column, value));
        }
    }
    Ok(MatrixEntries {
        rows,
        columns,
        entries,
    })
}

/// Real numbers of an array.
fn doubles(array: NamedArray, path: &str) -> Result<Vec<f64>, IoError> {
    let kind = match array.elements {
        Elements::F64(values) => return Ok(values),
        Elements::F32(values) => return Ok(values.into_iter().map(f64::from).collect()),
        Elements::Complex(_) => "complex numbers",
        Elements::Text(_) => "texts",
    };
    let got = format!("{kind} in {}", array.name);
    Err(not_a_matrix(path, got, "real numbers"))
}

/// A sparse matrix that is kept as several arrays below one name; `None` where they are not there.
fn sparse_group(
    store: &mut dyn ArrayStore,
    name: &str,
    path: &str,
) -> Result<Option<MatrixEntries>, IoError> {
    let prefix = name.trim_matches('/');
    let place = |store: &dyn ArrayStore, part: &str| match prefix {
        "" => find_array(store, part),
        _ => find_array(store, &format!("{prefix}/{part}")),
    };
    let mut read = |part: &str| -> Result<Option<Vec<f64>>, IoError> {
        let index = place(store, part);
        let array = index.map(|index| store.read(index)).transpose()?;
        array.map(|array| doubles(array, path)).transpose()
    };
    let Some(values) = read("data")? else {
        return Ok(None);
    };
    let shape = read("shape")?;
    let (index, starts, by_column) = match (read("ir")?, read("jc")?) {
        (Some(rows), Some(starts)) => (rows, starts, true),
        _ => match (read("indices")?, read("indptr")?) {
            (Some(index), Some(starts)) => {
                let format = place(store, "format")
                    .map(|at| store.read(at))
                    .transpose()?;
                (index, starts, is_by_column(format, path)?)
            }
            _ => {
                let places = (read("row")?, read("col")?);
                return match (places, shape) {
                    ((Some(rows), Some(columns)), Some(shape)) => {
                        let triples = rows.into_iter().zip(columns).zip(values);
                        let triples = triples.map(|((row, column), value)| (row, column, value));
                        entries_inside_shape(&shape, triples.collect(), path).map(Some)
                    }
                    _ => Ok(None),
                };
            }
        },
    };
    let lines = starts.len().saturating_sub(1) as f64;
    let shape = shape.unwrap_or(vec![lines, lines]);
    let lines = shape.get(usize::from(by_column)).copied();
    let triples = compressed_entries(&index, &starts, &values)
        .filter(|_| lines == Some(starts.len() as f64 - 1.0))
        .ok_or_else(|| {
            let got = format!(
                "{} places, {} starts, {} values",
                index.len(),
                starts.len(),
                values.len()
            );
            not_a_matrix(
                path,
                got,
                "ascending starts, a place and a value for each entry",
            )
        })?;
    let turned = triples
        .into_iter()
        .map(|(line, place, value)| match by_column {
            true => (place, line, value),
            false => (line, place, value),
        });
    entries_inside_shape(&shape, turned.collect(), path).map(Some)
}

/// Whether scipy's `format` says that a matrix is compressed by columns.
fn is_by_column(format: Option<NamedArray>, path: &str) -> Result<bool, IoError> {
    let text = format.map(|array| match array.elements {
        Elements::Text(texts) => texts.first().cloned().unwrap_or_default(),
        _ => "no text".to_owned(),
    });
    match text.as_deref() {
        None | Some("csr") => Ok(false),
        Some("csc") => Ok(true),
        Some(other) => Err(not_a_matrix(
            path,
            format!("format {other:?}"),
            "csr, csc or coo",
        )),
    }
}

/// Line, place and value of compressed entries; `None` where the arrays do not go together.
fn compressed_entries(
    index: &[f64],
    starts: &[f64],
    values: &[f64],
) -> Option<Vec<(f64, f64, f64)>> {
    let mut entries = Vec::with_capacity(values.len().min(index.len()));
    let mut at = 0;
    for (line, ends) in starts.windows(2).enumerate() {
        // A cast from NaN or below zero gives 0.
        let (start, end) = (ends[0] as usize, ends[1] as usize);
        if start != at || end < start || end > values.len() || end > index.len() {
            return None;
        }
        entries.extend((start..end).map(|p| (line as f64, index[p], values[p])));
        at = end;
    }
    (at == values.len() && at == index.len()).then_some(entries)
}

/// Entries whose places are whole numbers inside the shape.
fn entries_inside_shape(
    shape: &[f64],
    entries: Vec<(f64, f64, f64)>,
    path: &str,
) -> Result<MatrixEntries, IoError> {
    let whole = |value: f64| (value >= 0.0 && value.fract() == 0.0).then_some(value as usize);
    let lengths: Option<Vec<usize>> = shape.iter().map(|length| whole(*length)).collect();
    let Some([rows, columns]) = lengths.as_deref() else {
        return Err(not_a_matrix(
            path,
            format!("shape {shape:?}"),
            "two lengths",
        ));
    };
    let place = |(i, j, value): (f64, f64, f64)| {
        let row = whole(i).filter(|row| row < rows);
        let column = whole(j).filter(|column| column < columns);
        let both = row.zip(column).filter(|_| value.is_finite());
        both.map(|(row, column)| (row, column, value))
            .ok_or_else(|| {
                let got = format!("{value} at row {i}, column {j} (from 0)");
                not_a_matrix(
                    path,
                    got,
                    &format!("finite numbers inside {rows} x {columns}"),
                )
            })
    };
    Ok(MatrixEntries {
        rows: *rows,
        columns: *columns,
        entries: entries.into_iter().map(place).collect::<Result<_, _>>()?,
    })
}
