//! Named arrays: what containers (HDF5, MATLAB, NumPy) hold, whatever their bytes look like.

pub(in crate::io) mod bytes;

use std::ops::Range;

use num_complex::Complex64;

use crate::finding::Finding;
use crate::io::{ArrayInfo, IoError, MatrixEntries};

/// Elements of an array in row-major order (the last index runs fastest).
#[derive(Clone, Debug, PartialEq)]
pub(in crate::io) enum Elements {
    /// Real, single precision.
    F32(Vec<f32>),
    /// Real, double precision; integers and logical values too.
    F64(Vec<f64>),
    /// Complex.
    Complex(Vec<Complex64>),
    /// Texts, one per element.
    Text(Vec<String>),
}

impl Elements {
    /// Number of elements.
    pub fn len(&self) -> usize {
        match self {
            Elements::F32(values) => values.len(),
            Elements::F64(values) => values.len(),
            Elements::Complex(values) => values.len(),
            Elements::Text(values) => values.len(),
        }
    }

    /// Elements `range`; `None` where it does not lie inside.
    pub fn part(&self, range: Range<usize>) -> Option<Self> {
        Some(match self {
            Elements::F32(values) => Elements::F32(values.get(range)?.to_vec()),
            Elements::F64(values) => Elements::F64(values.get(range)?.to_vec()),
            Elements::Complex(values) => Elements::Complex(values.get(range)?.to_vec()),
            Elements::Text(values) => Elements::Text(values.get(range)?.to_vec()),
        })
    }
}

/// An array with its name.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::io) struct NamedArray {
    /// Name, levels separated by `/`.
    pub name: String,
    /// Lengths, slowest first; empty for one value.
    pub shape: Vec<usize>,
    /// As many as the product of the shape.
    pub elements: Elements,
}

/// An error for a part of an array that its elements do not have.
pub(in crate::io) fn outside(name: &str, range: &Range<usize>) -> IoError {
    IoError::Grouping {
        path: name.to_owned(),
        what: "reading a part of an array",
        got: "fewer elements".to_owned(),
        expected: format!("elements {range:?}"),
    }
}

/// An opened container of arrays.
pub(in crate::io) trait ArrayStore: Send {
    /// Every array, cell and object of the file in file order; names have their levels separated by
    /// `/`. What cannot be read is listed too, with its kind.
    fn list(&self) -> &[ArrayInfo];

    /// Whether array `index` of the list holds numbers or texts that [`ArrayStore::read`] can give.
    fn can_read(&self, _index: usize) -> bool {
        true
    }

    /// Most bytes that the elements of array `index` take when they are read, as far as the list
    /// tells.
    fn bytes(&self, index: usize) -> u64;

    /// Bytes of the file, of which compressed arrays can make many more.
    fn file_bytes(&self) -> u64;

    /// Takes what is wrong with parts of the file that are not in the list.
    fn take_damage(&mut self) -> Vec<IoError> {
        Vec::new()
    }

    /// Takes what was found beside the list, such as links that lead to no array.
    fn take_findings(&mut self) -> Vec<Finding> {
        Vec::new()
    }

    /// Reads array `index` of the list.
    ///
    /// # Errors
    /// [`IoError`] with the array's name for a kind that holds no numbers or texts, for damage, and
    /// for a size that the file cannot hold.
    fn read(&mut self, index: usize) -> Result<NamedArray, IoError>;

    /// Reads array `index` as the entries of a sparse matrix, where the file keeps it so; else
    /// `None`.
    ///
    /// # Errors
    /// As [`ArrayStore::read`].
    fn read_sparse(&mut self, _index: usize) -> Result<Option<MatrixEntries>, IoError> {
        Ok(None)
    }

    /// Reads elements `range` (in row-major order) of array `index`; the whole array is read where
    /// the format cannot do with less.
    ///
    /// # Errors
    /// As [`ArrayStore::read`].
    fn read_part(&mut self, index: usize, range: Range<usize>) -> Result<Elements, IoError> {
        let array = self.read(index)?;
        let part = array.elements.part(range.clone());
        part.ok_or_else(|| outside(&array.name, &range))
    }

    /// Reads elements `range` of array `index` in place of what `values` held, where the file keeps
    /// them one after the other as numbers of single precision of this machine; else `false`, and
    /// [`ArrayStore::read_part`] has to be asked.
    ///
    /// # Errors
    /// As [`ArrayStore::read`].
    fn read_singles(
        &mut self,
        _index: usize,
        _range: Range<usize>,
        _values: &mut Vec<f32>,
    ) -> Result<bool, IoError> {
        Ok(false)
    }
}
