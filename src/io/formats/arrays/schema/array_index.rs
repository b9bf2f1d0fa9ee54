//! Arrays of a store by name, with their sizes checked before anything is read.

use std::collections::BTreeMap;

use crate::io::IoError;
use crate::io::formats::arrays::store::bytes::count;
use crate::io::formats::arrays::store::{ArrayStore, Elements};

use super::arrays::whole;

/// Lengths other than 1.
fn lengths(shape: &[usize]) -> impl Iterator<Item = usize> {
    shape.iter().copied().filter(|len| *len != 1)
}

/// Whether two shapes are the same but for lengths of 1, which a container may add (n x 1 in
/// MATLAB) or drop. Elements in row-major order are then the same too.
pub(super) fn same_shape(shape: &[usize], other: &[usize]) -> bool {
    lengths(shape).eq(lengths(other))
}

/// The arrays of a store by name.
pub(super) struct ArrayIndex<'a> {
    store: &'a mut dyn ArrayStore,
    /// Place in the store's list, for each name.
    places: BTreeMap<String, usize>,
    path: &'a str,
}

impl<'a> ArrayIndex<'a> {
    /// The arrays of `store`; of two with one name the first.
    pub fn new(store: &'a mut dyn ArrayStore, path: &'a str) -> Self {
        let mut places = BTreeMap::new();
        for (index, info) in store.list().iter().enumerate() {
            places.entry(info.name.clone()).or_insert(index);
        }
        Self {
            store,
            places,
            path,
        }
    }

    /// Path of the file, for messages.
    pub fn path(&self) -> &'a str {
        self.path
    }

    /// Bytes of the file.
    pub fn file_bytes(&self) -> u64 {
        self.store.file_bytes()
    }

    /// Names of all arrays, in alphabetical order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.places.keys().map(String::as_str)
    }

    /// Place of an array in the store's list.
    pub fn place(&self, name: &str) -> Option<usize> {
        self.places.get(name).copied()
    }

    /// Lengths of an array.
    pub fn shape(&self, name: &str) -> Option<&[usize]> {
        Some(&self.store.list()[self.place(name)?].shape)
    }

    /// An error about an array.
    pub fn error(
        &self,
        name: &str,
        got: impl std::fmt::Display,
        expected: impl Into<String>,
    ) -> IoError {
        IoError::Grouping {
            path: self.path.to_owned(),
            what: "reading layout modalign-frf/1",
            got: format!("{name}: {got}"),
            expected: expected.into(),
        }
    }

    fn elements(
        &mut self,
        name: &str,
        shape: Option<&[usize]>,
    ) -> Result<Option<Elements>, IoError> {
        let Some(place) = self.place(name) else {
            return Ok(None);
        };
        let info = &self.store.list()[place];
        let elements_in_shape = count(&info.shape);
        // What holds no element cannot be mixed up, and programs differ in how they store it.
        let right = match shape {
            Some(shape) => {
                same_shape(&info.shape, shape)
                    || (elements_in_shape == Some(0) && count(shape) == Some(0))
            }
            None => lengths(&info.shape).count() <= 1 || elements_in_shape == Some(0),
        };
        if !right {
            let got = format!("shape {:?}", info.shape);
            let expected = match shape {
                Some(shape) => format!("shape {shape:?}"),
                None => "values in one row".to_owned(),
            };
            return Err(self.error(name, got, expected));
        }
        let elements = self.store.read(place)?.elements;
        if elements_in_shape != Some(elements.len()) {
            let got = format!("{} values", elements.len());
            return Err(self.error(name, got, "as many as its shape says"));
        }
        Ok(Some(elements))
    }

    /// Numbers of an array of the stated shape, of one row where none is stated; `None` when it is
    /// not there.
    pub fn numbers(
        &mut self,
        name: &str,
        shape: Option<&[usize]>,
    ) -> Result<Option<Vec<f64>>, IoError> {
        match self.elements(name, shape)? {
            None => Ok(None),
            Some(Elements::F64(values)) => Ok(Some(values)),
            Some(Elements::F32(values)) => Ok(Some(values.into_iter().map(f64::from).collect())),
            Some(Elements::Complex(_)) => Err(self.error(name, "complex numbers", "real numbers")),
            Some(Elements::Text(_)) => Err(self.error(name, "text", "numbers")),
        }
    }

    /// Texts of an array, as [`ArrayIndex::numbers`].
    pub fn texts(
        &mut self,
        name: &str,
        shape: Option<&[usize]>,
    ) -> Result<Option<Vec<String>>, IoError> {
        match self.elements(name, shape)? {
            None => Ok(None),
            Some(Elements::Text(values)) => Ok(Some(values)),
            // What holds no element may have lost its kind.
            Some(other) if other.len() == 0 => Ok(Some(Vec::new())),
            Some(_) => Err(self.error(name, "numbers", "text")),
        }
    }

    /// One number.
    pub fn number(&mut self, name: &str) -> Result<Option<f64>, IoError> {
        let values = self.numbers(name, Some(&[]))?;
        Ok(values.and_then(|values| values.first().copied()))
    }

    /// Most bytes that an array takes when it is read.
    pub fn bytes(&self, name: &str) -> Option<u64> {
        Some(self.store.bytes(self.place(name)?))
    }

    /// One text.
    pub fn text(&mut self, name: &str) -> Result<Option<String>, IoError> {
        let values = self.texts(name, Some(&[]))?;
        Ok(values.and_then(|values| values.into_iter().next()))
    }

    /// Numbers that must be there.
    pub fn needed_numbers(
        &mut self,
        name: &str,
        shape: Option<&[usize]>,
    ) -> Result<Vec<f64>, IoError> {
        let values = self.numbers(name, shape)?;
        values.ok_or_else(|| self.error(name, "nothing", "an array of numbers"))
    }

    /// Texts that must be there.
    pub fn needed_texts(
        &mut self,
        name: &str,
        shape: Option<&[usize]>,
    ) -> Result<Vec<String>, IoError> {
        let values = self.texts(name, shape)?;
        values.ok_or_else(|| self.error(name, "nothing", "an array of texts"))
    }

    /// Whole numbers that must be there.
    pub fn needed_whole(
        &mut self,
        name: &str,
        shape: Option<&[usize]>,
    ) -> Result<Vec<i64>, IoError> {
        let values = self.needed_numbers(name, shape)?;
        let values = values
            .into_iter()
            .map(|value| whole(value).ok_or_else(|| self.error(name, value, "whole numbers")));
        values.collect()
    }
}
