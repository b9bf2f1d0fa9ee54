//! Arrays of a container as `inspect` lists them, and values of one as a scene names it.

use std::path::Path;

use modalign::io::{
    Block, ColumnName, ColumnRole, Dimension, Hints, IoError, TableColumn, TableSpec, open_bytes,
};
use num_complex::Complex64;

use super::universal_file::{OneFile, Ran, on_file};

/// `inspect FILE --json` of these bytes.
pub fn inspected(name: &'static str, bytes: &[u8]) -> Ran {
    inspected_at(&OneFile::new(name, bytes).path())
}

/// `inspect FILE --json`.
pub fn inspected_at(path: &Path) -> Ran {
    on_file("inspect", path, &["--json"])
}

/// Each listed array as `name (2 x 3 f64)`.
pub fn arrays(ran: &Ran) -> Vec<String> {
    let json = ran.json();
    let arrays = json["files"][0]["arrays"].as_array().unwrap().iter();
    let described = arrays.map(|array| {
        let shape = array["shape"].as_array().unwrap().iter();
        let shape: Vec<String> = shape.map(ToString::to_string).collect();
        let (name, kind) = (&array["name"], &array["kind"]);
        let text = format!("{name} ({} {kind})", shape.join(" x "));
        text.replace('"', "").replace("( ", "(")
    });
    described.collect()
}

/// Codes of the findings of the file.
pub fn findings(ran: &Ran) -> Vec<String> {
    let json = ran.json();
    let findings = json["files"][0]["findings"].as_array().unwrap().iter();
    let codes = findings.map(|finding| finding["code"].as_str().unwrap().to_owned());
    codes.collect()
}

/// The values of one column, read as a record at 1 Hz.
pub fn values(name: &str, bytes: &[u8], column: &str) -> Result<Vec<f64>, IoError> {
    values_of(name, bytes, column, None)
}

/// [`values`] of an array with these dimensions.
pub fn values_of(
    name: &str,
    bytes: &[u8],
    column: &str,
    dimensions: Option<&[Dimension]>,
) -> Result<Vec<f64>, IoError> {
    let (dof, unit) = ("1:+Z".parse().ok(), "m/s^2".parse().unwrap());
    let record = ColumnRole::Response { dof, unit };
    Ok(match read(name, bytes, &[(column, record)], dimensions)? {
        Block::F32(values) => values.into_iter().map(f64::from).collect(),
        Block::F64(values) => values,
        Block::Complex(_) => panic!("a record is real"),
    })
}

/// The values of one column, read as an FRF over another.
pub fn frf(
    name: &str,
    bytes: &[u8],
    frequency: &str,
    column: &str,
    dimensions: Option<&[Dimension]>,
) -> Vec<Complex64> {
    let (dof, unit) = ("1:+Z".parse().ok(), "(m/s2)/N".parse().unwrap());
    let columns = [
        (frequency, ColumnRole::Frequency),
        (column, ColumnRole::Complex { dof, unit }),
    ];
    match read(name, bytes, &columns, dimensions) {
        Ok(Block::Complex(values)) => values,
        other => panic!("{other:?}"),
    }
}

/// The first function of columns with these roles.
fn read(
    name: &str,
    bytes: &[u8],
    columns: &[(&str, ColumnRole)],
    dimensions: Option<&[Dimension]>,
) -> Result<Block, IoError> {
    let columns = columns.iter().map(|(column, role)| TableColumn {
        column: ColumnName::Heading((*column).to_owned()),
        role: role.clone(),
        scale: 1.0,
    });
    let is_record = columns.len() == 1;
    let hints = Hints {
        path: name.to_owned(),
        table: Some(TableSpec {
            dimensions: dimensions.map(<[Dimension]>::to_vec),
            sampling_rate_hz: is_record.then_some(1.0),
            columns: columns.collect(),
            ..TableSpec::default()
        }),
    };
    let mut source = open_bytes(bytes.to_vec(), &hints)?;
    let length = source.catalog().entries[0].len();
    let mut block = Block::F64(Vec::new());
    source.read(0, 0..length, &mut block)?;
    Ok(block)
}
