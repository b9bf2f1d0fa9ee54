//! Products of large complex matrices.

use std::borrow::Cow;
use std::ops::Range;

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Mat, MatMut};
use num_complex::Complex64;
use rayon::prelude::*;

use super::{ComplexMatrix, ComplexView};

/// Columns of a product that one thread forms.
const COLUMNS_PER_BLOCK: usize = 48;

/// `B − A C`, some columns of it at a time in the caller's pool.
pub fn subtract_product(b: ComplexView<'_>, a: &ComplexMatrix, c: &ComplexMatrix) -> ComplexMatrix {
    let mut whole = Mat::zeros(b.nrows(), b.ncols());
    let of_block = |(number, mut block): (usize, MatMut<'_, Complex64>)| {
        let (first, count) = (number * COLUMNS_PER_BLOCK, block.ncols());
        block.copy_from(b.subcols(first, count));
        faer::linalg::matmul::matmul(
            block.as_mut(),
            faer::Accum::Add,
            a.as_ref(),
            c.subcols(first, count),
            -Complex64::ONE,
            faer::Par::Seq,
        );
    };
    let blocks = column_blocks(&mut whole);
    blocks.into_par_iter().enumerate().for_each(of_block);
    whole
}

/// Copies some rows of a column.
pub type Fill<'a> = dyn Fn(usize, Range<usize>, &mut [Complex64]) + Sync + 'a;
/// Converts some rows of a column, and appends them.
pub type Append<'a, T> = dyn Fn(usize, Range<usize>, &[Complex64], &mut Vec<T>) + Sync + 'a;

/// `A C` on some rows.
pub struct RowProduct<'a> {
    /// The rows.
    pub rows: Range<usize>,
    /// Rows × inner dimension.
    pub a: ComplexMatrix,
    /// Inner dimension × columns.
    pub c: Cow<'a, ComplexMatrix>,
}

/// `B − A C` with products that differ from rows to rows. `fill` copies the rows of a column of B,
/// `append` converts those of the difference; some columns at a time in the caller's pool.
pub fn subtract_row_products<T: Send>(
    columns: usize,
    products: &[RowProduct<'_>],
    fill: &Fill<'_>,
    append: &Append<'_, T>,
) -> Vec<Vec<T>> {
    let rows = products.iter().map(|product| product.rows.len()).sum();
    let of_block = |number: usize| {
        let first = number * COLUMNS_PER_BLOCK;
        let count = COLUMNS_PER_BLOCK.min(columns - first);
        let mut converted: Vec<Vec<T>> = (0..count).map(|_| Vec::with_capacity(rows)).collect();
        for RowProduct { rows, a, c } in products {
            let mut block = Mat::zeros(rows.len(), count);
            let fill =
                |column: usize, entries: &mut [Complex64]| fill(column, rows.clone(), entries);
            for_each_block_column(first, block.as_mut(), &fill);
            faer::linalg::matmul::matmul(
                block.as_mut(),
                faer::Accum::Add,
                a.as_ref(),
                c.subcols(first, count),
                -Complex64::ONE,
                faer::Par::Seq,
            );
            for (place, converted) in converted.iter_mut().enumerate() {
                append(
                    first + place,
                    rows.clone(),
                    block.col_as_slice(place),
                    converted,
                );
            }
        }
        converted
    };
    let blocks = (0..columns.div_ceil(COLUMNS_PER_BLOCK)).into_par_iter();
    let blocks: Vec<Vec<Vec<T>>> = blocks.map(of_block).collect();
    blocks.into_iter().flatten().collect()
}

/// A part of a difference of matrices, `B − A C`.
pub struct StackedPart<'a> {
    /// The matrix that is reduced.
    pub b: &'a ComplexMatrix,
    /// Rows × inner dimension.
    pub a: ComplexMatrix,
}

/// `B − A C` of parts with a common C, below each other; some columns at a time in the caller's
/// pool.
pub fn stacked_difference(parts: &[StackedPart<'_>], c: &ComplexMatrix) -> ComplexMatrix {
    let rows = parts.iter().map(|part| part.b.nrows()).sum();
    let mut whole = Mat::zeros(rows, c.ncols());
    let of_block = |(number, mut block): (usize, MatMut<'_, Complex64>)| {
        let (first, count) = (number * COLUMNS_PER_BLOCK, block.ncols());
        let mut start = 0;
        for StackedPart { b, a } in parts {
            let mut part = block.as_mut().subrows_mut(start, b.nrows());
            part.copy_from(b.subcols(first, count));
            faer::linalg::matmul::matmul(
                part,
                faer::Accum::Add,
                a.as_ref(),
                c.subcols(first, count),
                -Complex64::ONE,
                faer::Par::Seq,
            );
            start += b.nrows();
        }
    };
    let blocks = column_blocks(&mut whole);
    blocks.into_par_iter().enumerate().for_each(of_block);
    whole
}

/// Does something to every column, with its number, in the caller's pool.
pub fn for_each_column(matrix: &mut ComplexMatrix, then: impl Fn(usize, &mut [Complex64]) + Sync) {
    let of_block =
        |(number, block)| for_each_block_column(number * COLUMNS_PER_BLOCK, block, &then);
    let blocks = column_blocks(matrix);
    blocks.into_par_iter().enumerate().for_each(of_block);
}

fn column_blocks(matrix: &mut ComplexMatrix) -> Vec<MatMut<'_, Complex64>> {
    let mut blocks = Vec::new();
    let mut left = matrix.as_mut();
    while left.ncols() > 0 {
        let count = COLUMNS_PER_BLOCK.min(left.ncols());
        let (block, others) = left.split_at_col_mut(count);
        blocks.push(block);
        left = others;
    }
    blocks
}

fn for_each_block_column(
    first: usize,
    block: MatMut<'_, Complex64>,
    then: &(impl Fn(usize, &mut [Complex64]) + ?Sized),
) {
    for (place, column) in block.col_iter_mut().enumerate() {
        let entries = column.try_as_col_major_mut();
        let entries = entries.expect("columns of an owned matrix are contiguous");
        then(first + place, entries.as_slice_mut());
    }
}

/// `Aᴴ B`, some columns of B at a time in the caller's pool.
pub fn adjoint_product(a: &ComplexMatrix, b: ComplexView<'_>) -> ComplexMatrix {
    adjoint_product_of_blocks(a, b.ncols(), |first, count| {
        a.adjoint() * b.subcols(first, count)
    })
}

/// As [`adjoint_product`], with a B whose columns are filled by their numbers.
pub fn adjoint_product_from(
    a: &ComplexMatrix,
    columns: usize,
    fill: &(dyn Fn(usize, &mut [Complex64]) + Sync),
) -> ComplexMatrix {
    adjoint_product_of_blocks(a, columns, |first, count| {
        let mut block = Mat::zeros(a.nrows(), count);
        for_each_block_column(first, block.as_mut(), fill);
        a.adjoint() * block
    })
}

fn adjoint_product_of_blocks(
    a: &ComplexMatrix,
    columns: usize,
    product: impl Fn(usize, usize) -> ComplexMatrix + Sync,
) -> ComplexMatrix {
    let parts: Vec<ComplexMatrix> = (0..columns.div_ceil(COLUMNS_PER_BLOCK))
        .into_par_iter()
        .map(|part| {
            let first = part * COLUMNS_PER_BLOCK;
            product(first, COLUMNS_PER_BLOCK.min(columns - first))
        })
        .collect();
    Mat::from_fn(a.ncols(), columns, |i, j| {
        parts[j / COLUMNS_PER_BLOCK][(i, j % COLUMNS_PER_BLOCK)]
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
                let expected = if i >= j {
                    whole[(i, j)]
                } else {
                    Complex64::ZERO
                };
                assert!((sum[(i, j)] - Complex64::I - expected).norm() < 1e-12);
            }
        }
    }
}
