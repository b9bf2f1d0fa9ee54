//! Powers of two that bring a matrix to entries of order one.
//!
//! Two kernels of faer 0.24.4 are not invariant to scale: divide and conquer of symmetric matrices
//! of more than 128 coordinates (it deflates below `8 eps max(|d|, |z|)`, where `z` is of order one
//! whatever the matrix is) and the eigenvectors of general real matrices (wrong from entries of
//! 1e-15 down). LAPACK scales before both. A power of two changes no digit of any entry.

use faer::traits::ComplexField;
use faer::{Mat, MatRef};

use super::RealMatrix;

/// Power of two that brings the largest entry into `[1, 2)`, 1 for a matrix of zeros.
pub(super) fn power_of_two<T: ComplexField<Real = f64>>(a: MatRef<'_, T>) -> f64 {
    match a.norm_max() {
        largest if largest > 0.0 && largest.is_finite() => exact_reciprocal(largest),
        _ => 1.0,
    }
}

/// Power of four that brings the largest entry into `[1, 4)`: its root changes no digit either.
pub(super) fn power_of_four<T: ComplexField<Real = f64>>(a: MatRef<'_, T>) -> f64 {
    let factor = power_of_two(a);
    let exponent = (factor.to_bits() >> 52) as i64 - 1023;
    if exponent % 2 == 0 {
        factor
    } else {
        2.0 * factor
    }
}

/// `2^-floor(log2 x)` of a normal number, as near as a normal number comes to it.
pub(super) fn exact_reciprocal(x: f64) -> f64 {
    let exponent = (x.to_bits() >> 52) as i64 - 1023;
    f64::from_bits(((1023 - exponent).clamp(1, 2046) as u64) << 52)
}

/// Every entry times a factor.
pub(super) fn scaled(a: &RealMatrix, factor: f64) -> RealMatrix {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * factor)
}

#[cfg(test)]
mod tests {
    use super::super::real_matrix;
    use super::*;

    #[test]
    fn largest_entry_is_brought_between_one_and_two_by_a_power_of_two() {
        for x in [1e-300, 3.7e-150, 0.75, 1.0, 2.0, 1e9, -4.2e15, 1e150, 1e300] {
            let factor =
                power_of_two(real_matrix(2, 2, |i, j| if i > j { x } else { 0.1 * x }).as_ref());
            let scaled = (x * factor).abs();
            assert!((1.0..2.0).contains(&scaled), "{x}: {scaled}");
            let even = power_of_four(real_matrix(1, 1, |_, _| x).as_ref());
            assert!((1.0..4.0).contains(&(x * even).abs()), "{x}: {even}");
            assert_eq!((even.sqrt().powi(2)).to_bits(), even.to_bits());
            assert_eq!(factor.to_bits() & ((1 << 52) - 1), 0);
        }
        let zero = power_of_two(real_matrix(2, 2, |_, _| 0.0).as_ref());
        assert_eq!(zero.to_bits(), 1.0_f64.to_bits());
    }
}
