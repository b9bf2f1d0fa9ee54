//! Matrices and vectors are those of the matrix crates, under the names of this stage.

use faer::{Mat, c64};
use num_complex::Complex64;

/// Vector of three, for positions and directions.
pub type Vector3 = nalgebra::Vector3<f64>;
/// Matrix of three by three, for rotations.
pub type Matrix3 = nalgebra::Matrix3<f64>;
/// Dense real matrix.
pub type RealMatrix = Mat<f64>;
/// Dense complex matrix.
pub type ComplexMatrix = Mat<c64>;
/// Rows or columns of one.
pub type ComplexView<'a> = faer::MatRef<'a, c64>;

/// A matrix in the place of one that could not be computed.
pub fn not_a_number(rows: usize, columns: usize) -> ComplexMatrix {
    Mat::full(rows, columns, Complex64::new(f64::NAN, f64::NAN))
}

/// Complex matrix from a function of row and column.
pub fn complex_matrix(
    rows: usize,
    columns: usize,
    f: impl FnMut(usize, usize) -> Complex64,
) -> ComplexMatrix {
    Mat::from_fn(rows, columns, f)
}

/// Real matrix from a function of row and column.
pub fn real_matrix(rows: usize, columns: usize, f: impl FnMut(usize, usize) -> f64) -> RealMatrix {
    Mat::from_fn(rows, columns, f)
}
