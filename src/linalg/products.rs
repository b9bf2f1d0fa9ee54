//! Products of large complex matrices.

use faer::Mat;
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use num_complex::Complex64;
use rayon::prelude::*;

use super::ComplexMatrix;

/// Columns of a product that one thread forms.
const COLUMNS: usize = 48;

/// `Aᴴ B`, some columns of B at a time in the caller's pool.
pub fn adjoint_product(a: &ComplexMatrix, b: &ComplexMatrix) -> ComplexMatrix {
    let parts: Vec<ComplexMatrix> = (0..b.ncols().div_ceil(COLUMNS))
        .into_par_iter()
        .map(|part| {
            let first = part * COLUMNS;
            a.adjoint() * b.subcols(first, COLUMNS.min(b.ncols() - first))
        })
        .collect();
    Mat::from_fn(a.ncols(), b.ncols(), |i, j| {
        parts[j / COLUMNS][(i, j % COLUMNS)]
    })
}

/// Adds the lower triangle of `Aᴴ A` to that of a sum, whose other triangle keeps what it has.
pub fn add_square(sum: &mut ComplexMatrix, a: &ComplexMatrix) {
    matmul(
        sum.as_mut(),
        BlockStructure::TriangularLower,
        faer::Accum::Add,
        a.adjoint(),
        BlockStructure::Rectangular,
        a.as_ref(),
        BlockStructure::Rectangular,
        Complex64::ONE,
        faer::Par::Seq,
    );
}

#[cfg(test)]
mod tests {
    use super::super::complex_matrix;
    use super::*;

    #[test]
    fn a_square_is_added_to_the_lower_triangle_alone() {
        let value = |r: usize, c: usize| Complex64::new(r as f64 - 1.5, (c * c) as f64 + r as f64);
        let a = complex_matrix(4, 3, value);
        let whole = a.adjoint() * &a;
        let mut sum = complex_matrix(3, 3, |_, _| Complex64::I);
        add_square(&mut sum, &a);
        for i in 0..3 {
            for j in 0..3 {
                let own = if i >= j {
                    whole[(i, j)]
                } else {
                    Complex64::ZERO
                };
                assert!((sum[(i, j)] - Complex64::I - own).norm() < 1e-12);
            }
        }
    }
}
