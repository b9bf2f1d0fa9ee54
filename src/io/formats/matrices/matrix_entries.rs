//! A sparse matrix lists its entries that are not zero.

/// A matrix as its entries that are not zero.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MatrixEntries {
    /// Rows.
    pub rows: usize,
    /// Columns.
    pub columns: usize,
    /// Row and column, from 0, and value; entries of one place add up.
    pub entries: Vec<(usize, usize, f64)>,
}
