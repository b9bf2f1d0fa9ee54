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

/// Values of an even abscissa, in s, Hz or the unit of the file.
///
/// # Errors
/// [`IoError::NotStated`] for an uneven one.
pub(in crate::io) fn even_abscissa(
    catalog: &Catalog,
    entry: usize,
    range: Range<usize>,
    out: &mut Vec<f64>,
) -> Result<(), IoError> {
    check_range(catalog, entry, &range)?;
    out.clear();
    if range.is_empty() {
        return Ok(());
    }
    let (start, step) = catalog.entries[entry]
        .axis
        .even()
        .ok_or_else(|| IoError::NotStated {
            path: catalog.path.clone(),
            what: format!("the abscissa of function {}", entry + 1),
            expected: "a value for each sample".to_owned(),
        })?;
    out.extend(range.map(|i| start + i as f64 * step));
    Ok(())
}
