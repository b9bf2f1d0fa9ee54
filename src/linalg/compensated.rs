//! Quadratic forms summed in twice the working precision.
//!
//! A natural frequency of a slender structure is the small difference of large terms: `phi^T K phi` of the first bending
//! mode of a beam of 500 elements is 1e-9 of the sum of the magnitudes of its terms. Error-free transformations of
//! products and sums keep the rounding of the evaluation out of it; what remains is the rounding of the entries of K.
//!
//! # Reference
//! Ogita, Rump and Oishi (2005), Accurate sum and dot product, SIAM J. Sci. Comput. 26, algorithm 5.3 (Dot2).

use faer::MatRef;

use super::vectorised::vectorised;
use super::{RealMatrix, SparseMatrix};

/// Columns of vectors that pass through one reading of the matrix.
const COLUMNS: usize = 4;

/// `x^T A x` with the size of its terms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct QuadraticForm {
    /// `sum A_ij x_i x_j`, as if summed in twice the working precision.
    pub value: f64,
    /// `sum |A_ij x_i x_j|`: times the unit roundoff it bounds the change of the value by rounding of the entries of A.
    pub magnitude: f64,
}

/// A sum carried as a leading part and the sum of what it rounded off.
#[derive(Clone, Copy, Default)]
pub(super) struct CompensatedSum {
    high: f64,
    low: f64,
}

impl CompensatedSum {
    /// Adds `a b`.
    #[inline(always)]
    pub fn add_product(&mut self, a: f64, b: f64) {
        let product = a * b;
        let product_error = a.mul_add(b, -product);
        let sum = self.high + product;
        let part = sum - self.high;
        let sum_error = (self.high - (sum - part)) + (product - part);
        self.high = sum;
        self.low += sum_error + product_error;
    }

    pub fn value(self) -> f64 {
        self.high + self.low
    }

    /// Its two parts.
    #[inline(always)]
    pub fn parts(self) -> [f64; 2] {
        [self.high, self.low]
    }
}

/// Sums of one row of `A x` for several vectors side by side.
#[derive(Clone, Copy, Default)]
struct RowSums {
    high: [f64; COLUMNS],
    low: [f64; COLUMNS],
    magnitude: [f64; COLUMNS],
}

/// `x_j^T A x_j` of every column `x_j` of a block; A is square.
pub fn quadratic_forms(a: MatRef<'_, f64>, block: MatRef<'_, f64>) -> Vec<QuadraticForm> {
    let nonzero: Vec<_> = (0..a.ncols()).map(|j| nonzero_rows(a, j)).collect();
    let mut forms = Vec::with_capacity(block.ncols());
    for first in (0..block.ncols()).step_by(COLUMNS) {
        let count = COLUMNS.min(block.ncols() - first);
        forms.extend(forms_of(a, &nonzero, block.subcols(first, count)));
    }
    forms
}

/// `phi^T K phi / phi^T M phi` of every column, with the bound of its change by rounding of the entries of K,
/// `eps |phi|^T |K| |phi| / phi^T M phi`.
pub fn rayleigh_quotients(
    stiffness: &RealMatrix,
    mass: &RealMatrix,
    vectors: &RealMatrix,
) -> Vec<(f64, f64)> {
    let strain = quadratic_forms(stiffness.as_ref(), vectors.as_ref());
    let kinetic = quadratic_forms(mass.as_ref(), vectors.as_ref());
    let pairs = strain.iter().zip(&kinetic);
    pairs
        .map(|(strain, kinetic)| quotient(*strain, *kinetic))
        .collect()
}

/// [`rayleigh_quotients`] of one vector with sparse matrices.
pub fn sparse_rayleigh_quotient(
    stiffness: &SparseMatrix,
    mass: &SparseMatrix,
    x: &[f64],
) -> (f64, f64) {
    quotient(stiffness.quadratic_form(x), mass.quadratic_form(x))
}

fn quotient(strain: QuadraticForm, kinetic: QuadraticForm) -> (f64, f64) {
    let rounding = f64::EPSILON * strain.magnitude / kinetic.value;
    (strain.value / kinetic.value, rounding)
}

/// Rows of a column from its first entry that is not zero to its last.
fn nonzero_rows(a: MatRef<'_, f64>, column: usize) -> std::ops::Range<usize> {
    let is_nonzero = |i: &usize| a[(*i, column)].abs() > 0.0;
    match (0..a.nrows()).find(is_nonzero) {
        Some(first) => first..(first..a.nrows()).rfind(is_nonzero).unwrap_or(first) + 1,
        None => 0..0,
    }
}

fn forms_of(
    a: MatRef<'_, f64>,
    nonzero: &[std::ops::Range<usize>],
    block: MatRef<'_, f64>,
) -> Vec<QuadraticForm> {
    let n = a.nrows();
    let mut sums = vec![RowSums::default(); n];
    for (column, rows) in nonzero.iter().enumerate() {
        let mut x = [0.0; COLUMNS];
        (0..block.ncols()).for_each(|j| x[j] = block[(column, j)]);
        let entries = a.col(column).subrows(rows.start, rows.len());
        let rows = &mut sums[rows.clone()];
        match entries.try_as_col_major() {
            Some(entries) => add_column(rows, entries.as_slice(), x),
            None => add_column(rows, &entries.iter().copied().collect::<Vec<_>>(), x),
        }
    }
    (0..block.ncols())
        .map(|j| {
            let mut form = QuadraticForm::default();
            let mut value = CompensatedSum::default();
            for (i, sums) in sums.iter().enumerate() {
                let x = block[(i, j)];
                value.add_product(sums.high[j], x);
                value.add_product(sums.low[j], x);
                form.magnitude += sums.magnitude[j] * x.abs();
            }
            form.value = value.value();
            form
        })
        .collect()
}

/// Adds a column of the matrix times one entry of each vector.
fn add_column(rows: &mut [RowSums], entries: &[f64], x: [f64; COLUMNS]) {
    vectorised(
        #[inline(always)]
        || {
            for (sums, &entry) in rows.iter_mut().zip(entries) {
                for (j, &x) in x.iter().enumerate() {
                    let mut sum = CompensatedSum {
                        high: sums.high[j],
                        low: sums.low[j],
                    };
                    sum.add_product(entry, x);
                    (sums.high[j], sums.low[j]) = (sum.high, sum.low);
                    sums.magnitude[j] += (entry * x).abs();
                }
            }
        },
    );
}

#[cfg(test)]
mod tests {
    use super::super::real_matrix;
    use super::*;

    #[test]
    fn terms_that_cancel_to_sixteen_digits_leave_the_exact_value() {
        // [1, 1] A [1, 1]^T of a spring of 1e16 between two coordinates with a spring of 1 to ground at the first.
        let a = real_matrix(2, 2, |i, j| match (i, j) {
            (0, 1) | (1, 0) => -1e16,
            (0, 0) => 1e16 + 2.0,
            _ => 1e16,
        });
        let x = real_matrix(2, 6, |_, j| 1.0 + j as f64);
        let forms = quadratic_forms(a.as_ref(), x.as_ref());
        for (j, form) in forms.iter().enumerate() {
            let square = (1.0 + j as f64).powi(2);
            assert_eq!(form.value.to_bits(), (2.0 * square).to_bits());
            assert!((form.magnitude / (4e16 * square) - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn columns_of_zeros_and_leading_zeros_are_skipped_without_a_trace() {
        let a = real_matrix(5, 5, |i, j| if i == 3 && j == 3 { 7.0 } else { 0.0 });
        let x = real_matrix(5, 1, |i, _| i as f64);
        let forms = quadratic_forms(a.as_ref(), x.as_ref());
        assert_eq!(forms[0].value.to_bits(), 63.0_f64.to_bits());
    }
}
