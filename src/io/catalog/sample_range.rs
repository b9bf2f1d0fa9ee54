//! A range of samples lies inside its entry; the even axis of the entry gives its abscissa.

use std::ops::Range;

use crate::io::{Catalog, Entry, IoError};

/// An entry that is there and a range inside it.
///
/// # Errors
/// [`IoError::Binary`] for any other.
pub(in crate::io) fn check_range(
    catalog: &Catalog,
    entry: usize,
    range: &Range<usize>,
) -> Result<(), IoError> {
    let len = catalog.entries.get(entry).map(Entry::len);
    if len.is_some_and(|len| range.start <= range.end && range.end <= len) {
        return Ok(());
    }
    Err(IoError::Binary {
        path: catalog.path.clone(),
        byte: 0,
        what: "range of samples asked for",
        got: format!("{range:?} of entry {entry}"),
        expected: match len {
            Some(len) => format!("at most {len} samples"),
            None => format!("one of {} entries", catalog.entries.len()),
        },
    })
}

/// Values of an even abscissa with this first value and spacing, in s, Hz or the unit of the file.
pub(in crate::io) fn even_abscissa(
    (start, step): (f64, f64),
    range: Range<usize>,
    out: &mut Vec<f64>,
) {
    out.clear();
    out.extend(range.map(|i| start + i as f64 * step));
}

/// The error for an uneven axis whose values the file does not have.
pub(in crate::io) fn uneven_without_values(catalog: &Catalog, entry: usize) -> IoError {
    IoError::NotStated {
        path: catalog.path.clone(),
        what: format!("the abscissa of function {}", entry + 1),
        expected: "a value for each sample".to_owned(),
    }
}
