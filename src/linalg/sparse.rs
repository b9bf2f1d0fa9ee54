//! Square sparse matrices keep the entries that are not zero.

use faer::Mat;

use super::compensated::{CompensatedSum, QuadraticForm, quotient};
use super::vectorised::vectorised;
use super::{LinalgError, RealMatrix, real_matrix};

/// Square matrix of which the entries that are not zero are kept, column after column with
/// ascending rows.
#[derive(Clone, Debug, PartialEq)]
pub struct SparseMatrix {
    size: usize,
    /// Where each column begins in `rows` and `values`, and where the last ends.
    starts: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<f64>,
}

impl SparseMatrix {
    /// The matrix of entries `(row, column, value)`; those of one place add up.
    ///
    /// # Errors
    /// [`LinalgError::OutsideMatrix`].
    pub fn from_entries(size: usize, entries: &[(usize, usize, f64)]) -> Result<Self, LinalgError> {
        let outside = entries.iter().find(|(i, j, _)| *i >= size || *j >= size);
        if let Some(&(row, column, _)) = outside {
            return Err(LinalgError::OutsideMatrix { row, column, size });
        }
        let mut starts = vec![0; size + 1];
        entries.iter().for_each(|(_, j, _)| starts[j + 1] += 1);
        (0..size).for_each(|j| starts[j + 1] += starts[j]);
        let mut next = starts.clone();
        let mut placed = vec![(0, 0.0); entries.len()];
        for &(i, j, value) in entries {
            placed[next[j]] = (i, value);
            next[j] += 1;
        }
        let mut matrix = Self {
            size,
            starts: Vec::with_capacity(size + 1),
            rows: Vec::with_capacity(entries.len()),
            values: Vec::with_capacity(entries.len()),
        };
        for j in 0..size {
            matrix.starts.push(matrix.rows.len());
            let column = &mut placed[starts[j]..starts[j + 1]];
            // Stable, so that entries of one place add up in the order given.
            column.sort_by_key(|(row, _)| *row);
            matrix.push_column(column);
        }
        matrix.starts.push(matrix.rows.len());
        Ok(matrix)
    }

    fn push_column(&mut self, column: &[(usize, f64)]) {
        let first = self.rows.len();
        for &(row, value) in column {
            match self.rows[first..].last() {
                Some(last) if *last == row => *self.values.last_mut().expect("has a row") += value,
                _ => {
                    self.rows.push(row);
                    self.values.push(value);
                }
            }
        }
    }

    /// `sum factor A` of matrices of one size; entries that stay at zero are kept.
    ///
    /// # Errors
    /// [`LinalgError::OutsideMatrix`] when one of them is larger than `size`.
    pub fn weighted_sum(size: usize, terms: &[(f64, &Self)]) -> Result<Self, LinalgError> {
        let scaled = terms
            .iter()
            .flat_map(|(factor, a)| a.entries().map(move |(i, j, v)| (i, j, factor * v)));
        Self::from_entries(size, &scaled.collect::<Vec<_>>())
    }

    /// Number of rows and of columns.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Number of entries that are kept.
    pub fn entry_count(&self) -> usize {
        self.values.len()
    }

    /// The entries, column after column.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        let column = |j: usize| (self.starts[j]..self.starts[j + 1]).map(move |p| (p, j));
        let places = (0..self.size).flat_map(column);
        places.map(|(p, j)| (self.rows[p], j, self.values[p]))
    }

    /// The entry at a place, 0 where none is kept.
    pub fn get(&self, row: usize, column: usize) -> f64 {
        let stored = self.starts[column]..self.starts[column + 1];
        let found = self.rows[stored.clone()].binary_search(&row);
        found.map_or(0.0, |at| self.values[stored.start + at])
    }

    /// `A X`.
    pub fn multiply(&self, x: &RealMatrix) -> RealMatrix {
        let mut product = Mat::zeros(self.size, x.ncols());
        for column in 0..x.ncols() {
            let product_column = product.col_mut(column);
            let product_column = product_column
                .try_as_col_major_mut()
                .expect("a matrix of columns");
            self.add_product(x.col(column).iter(), product_column.as_slice_mut());
        }
        product
    }

    fn add_product<'a>(&self, x: impl Iterator<Item = &'a f64>, out: &mut [f64]) {
        for (ends, factor) in self.starts.windows(2).zip(x) {
            let stored = ends[0]..ends[1];
            for (row, value) in self.rows[stored.clone()].iter().zip(&self.values[stored]) {
                out[*row] += value * factor;
            }
        }
    }

    /// `A X`, each entry summed in twice the working precision.
    pub fn multiply_compensated(&self, x: &RealMatrix) -> RealMatrix {
        vectorised(
            #[inline(always)]
            || {
                let mut product = Mat::zeros(self.size, x.ncols());
                let mut sums = vec![CompensatedSum::default(); self.size];
                for column in 0..x.ncols() {
                    sums.fill(CompensatedSum::default());
                    for (ends, &factor) in self.starts.windows(2).zip(x.col_as_slice(column)) {
                        let places = ends[0]..ends[1];
                        for (&row, &entry) in
                            self.rows[places.clone()].iter().zip(&self.values[places])
                        {
                            sums[row].add_product(entry, factor);
                        }
                    }
                    for (row, sum) in sums.iter().enumerate() {
                        product[(row, column)] = sum.value();
                    }
                }
                product
            },
        )
    }

    /// `x^T A x`.
    pub fn quadratic_form(&self, x: &[f64]) -> QuadraticForm {
        vectorised(
            #[inline(always)]
            || {
                let mut form = QuadraticForm::default();
                let mut value = CompensatedSum::default();
                for (ends, &factor) in self.starts.windows(2).zip(x) {
                    let mut product = CompensatedSum::default();
                    let column = ends[0]..ends[1];
                    for (&row, &entry) in self.rows[column.clone()].iter().zip(&self.values[column])
                    {
                        product.add_product(entry, x[row]);
                        form.magnitude += (entry * x[row] * factor).abs();
                    }
                    for part in product.parts() {
                        value.add_product(part, factor);
                    }
                }
                form.value = value.value();
                form
            },
        )
    }

    /// The same matrix with its zeros.
    pub fn to_dense(&self) -> RealMatrix {
        let mut dense = real_matrix(self.size, self.size, |_, _| 0.0);
        for (i, j, value) in self.entries() {
            dense[(i, j)] = value;
        }
        dense
    }
}

/// The entries of a column from the diagonal down.
pub(super) fn lower_column(
    a: &SparseMatrix,
    column: usize,
) -> impl Iterator<Item = (usize, f64)> + '_ {
    let stored = a.starts[column]..a.starts[column + 1];
    let pairs = stored.map(|p| (a.rows[p], a.values[p]));
    pairs.filter(move |(row, _)| *row >= column)
}

/// [`rayleigh_quotients`](super::rayleigh_quotients) of one vector with sparse matrices.
pub fn sparse_rayleigh_quotient(
    stiffness: &SparseMatrix,
    mass: &SparseMatrix,
    x: &[f64],
) -> (f64, f64) {
    quotient(stiffness.quadratic_form(x), mass.quadratic_form(x))
}
