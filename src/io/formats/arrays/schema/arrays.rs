//! Texts, numbers and whole numbers become named arrays.

use crate::io::formats::arrays::store::{Elements, NamedArray};
use crate::io::{IoError, Precision};

/// The text of the array `schema`.
pub(super) const SCHEMA: &str = "modalign-frf/1";

/// Takes arrays one after the other.
pub(super) type Put<'a> = dyn FnMut(NamedArray) -> Result<(), IoError> + 'a;

/// Options of the writers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Wanted {
    /// Whether arrays of samples are filled, or empty because their names alone are wanted.
    pub samples: bool,
    /// Width of the samples; as stored when not stated.
    pub precision: Option<Precision>,
}

/// One text.
pub(super) fn text(name: &str, value: &str) -> NamedArray {
    texts(name, &[], vec![value.to_owned()])
}

/// Texts of a shape.
pub(super) fn texts(name: &str, shape: &[usize], values: Vec<String>) -> NamedArray {
    NamedArray {
        name: name.to_owned(),
        shape: shape.to_vec(),
        elements: Elements::Text(values),
    }
}

/// Numbers of a shape.
pub(super) fn numbers(name: &str, shape: &[usize], values: Vec<f64>) -> NamedArray {
    NamedArray {
        name: name.to_owned(),
        shape: shape.to_vec(),
        elements: Elements::F64(values),
    }
}

/// Whole numbers as doubles, and how many of them a double cannot hold.
pub(super) fn whole_numbers(values: impl Iterator<Item = i64>) -> (Vec<f64>, usize) {
    let mut inexact = 0;
    let values = values.map(|value| {
        inexact += usize::from(whole(value as f64) != Some(value));
        value as f64
    });
    (values.collect(), inexact)
}

/// Largest whole number up to which a double holds every one, 2^53.
const LARGEST_EXACT: f64 = 9_007_199_254_740_992.0;

/// The whole number that a double holds.
pub(super) fn whole(value: f64) -> Option<i64> {
    (value.fract() == 0.0 && value.abs() <= LARGEST_EXACT).then_some(value as i64)
}
