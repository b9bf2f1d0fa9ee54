//! The normal equations of a method give the condition number and the poles, rounded where asked.

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix};

/// What was rounded to f32.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounded {
    Nothing,
    Data,
    DataAndMatrix,
}

/// Condition numbers beyond this are round-off in f64.
const MAX_CONDITION: f64 = 1e17;

/// Poles of a solution, rad/s; `None` where it has none.
type Poles = dyn Fn(&[Complex64]) -> Option<Vec<Complex64>>;

/// Normal equations of one method: matrix, right-hand side, and the poles of a solution.
pub struct Problem {
    matrix: ComplexMatrix,
    right: Vec<Complex64>,
    pub(super) poles: Box<Poles>,
}

impl Problem {
    pub(super) fn new(
        mut matrix: ComplexMatrix,
        mut right: Vec<Complex64>,
        rounded: Rounded,
        poles: Box<Poles>,
    ) -> Self {
        if rounded == Rounded::DataAndMatrix {
            let (rows, columns) = (matrix.nrows(), matrix.ncols());
            matrix = linalg::complex_matrix(rows, columns, |i, j| single(matrix[(i, j)]));
            right.iter_mut().for_each(|value| *value = single(*value));
        }
        Self {
            matrix,
            right,
            poles,
        }
    }

    pub(super) fn condition(&self) -> f64 {
        let Ok(values) = linalg::singular_values(&self.matrix) else {
            return MAX_CONDITION;
        };
        let (largest, least) = values.iter().fold((0.0, f64::INFINITY), |(a, b), value| {
            (f64::max(a, *value), f64::min(b, *value))
        });
        (largest / least).min(MAX_CONDITION)
    }

    pub(super) fn solved(&self) -> Option<Vec<Complex64>> {
        let right = linalg::complex_matrix(self.right.len(), 1, |i, _| self.right[i]);
        let solution = linalg::least_squares(&self.matrix, &right).ok()?;
        let values: Vec<Complex64> = (0..solution.nrows()).map(|i| solution[(i, 0)]).collect();
        values
            .iter()
            .all(|value| value.is_finite())
            .then_some(values)
    }
}

pub(super) fn single(value: Complex64) -> Complex64 {
    Complex64::new(f64::from(value.re as f32), f64::from(value.im as f32))
}

/// Roots of `Σ c_j x^j` by its companion matrix; `None` where they cannot be computed.
pub(super) fn roots(coefficients: &[Complex64]) -> Option<Vec<Complex64>> {
    let order = coefficients.len() - 1;
    let leading = coefficients[order];
    let companion = linalg::complex_matrix(order, order, |i, j| {
        let last = if i + 1 == order {
            -coefficients[j] / leading
        } else {
            Complex64::ZERO
        };
        let next = if j == i + 1 {
            Complex64::ONE
        } else {
            Complex64::ZERO
        };
        last + next
    });
    let finite = coefficients.iter().all(|c| (c / leading).is_finite());
    finite.then(|| linalg::complex_eigenvalues(&companion).ok())?
}

/// `AᴴA` and `Aᴴb`.
pub(super) fn normal_equations(
    rows: &ComplexMatrix,
    right: &[Complex64],
) -> (ComplexMatrix, Vec<Complex64>) {
    let right = linalg::complex_matrix(right.len(), 1, |i, _| right[i]);
    let products = rows.adjoint() * &right;
    let matrix = rows.adjoint() * rows;
    let products = (0..products.nrows()).map(|i| products[(i, 0)]).collect();
    (matrix, products)
}
