//! Measures between two vectors on the same, already matched degrees of freedom.

use num_complex::Complex64;

use crate::linalg::{ComplexMatrix, adjoint_product};

fn inner(a: &[Complex64], b: &[Complex64]) -> Complex64 {
    a.iter().zip(b).map(|(x, y)| x.conj() * y).sum()
}

/// Modal assurance criterion of two vectors whose components belong to the same degrees of freedom
/// in the same order.
///
/// `|a^H b|^2 / ((a^H a)(b^H b))`, in `[0, 1]`, unchanged by complex scaling. `None` when a vector
/// is zero or the lengths differ.
///
/// ```
/// use num_complex::Complex64;
/// let a = [Complex64::new(1.0, 0.0), Complex64::new(1.0, 0.0)];
/// let b = [Complex64::new(0.0, 2.0), Complex64::new(0.0, 0.0)];
/// assert!((modalign::modal::mac(&a, &b).unwrap() - 0.5).abs() < 1e-15);
/// ```
///
/// # Reference
/// Allemang and Brown (1982), A correlation coefficient for modal vector analysis, IMAC 1.
pub fn mac(a: &[Complex64], b: &[Complex64]) -> Option<f64> {
    let norms = inner(a, a).re * inner(b, b).re;
    (a.len() == b.len() && norms > 0.0).then(|| (inner(a, b).norm_sqr() / norms).min(1.0))
}

/// [`mac`] of every column of `rows` with every column of `columns`, from one product of matrices;
/// `None` where a column is zero. Both have the same degrees of freedom as rows.
///
/// ```
/// use modalign::linalg::complex_matrix;
/// use modalign::modal::mac_matrix;
/// let shapes = complex_matrix(3, 2, |dof, mode| ((dof + 1).pow(mode as u32) as f64).into());
/// let macs = mac_matrix(&shapes, &shapes);
/// assert!((macs[0][1].unwrap() - 36.0 / (3.0 * 14.0)).abs() < 1e-15);
/// ```
pub fn mac_matrix(rows: &ComplexMatrix, columns: &ComplexMatrix) -> Vec<Vec<Option<f64>>> {
    let squares = |of: &ComplexMatrix| -> Vec<f64> {
        let column = |c: usize| (0..of.nrows()).map(|p| of[(p, c)].norm_sqr()).sum();
        (0..of.ncols()).map(column).collect()
    };
    let (a, b) = (squares(rows), squares(columns));
    let products = adjoint_product(rows, columns.as_ref());
    let value = |i: usize, j: usize| {
        let known = a[i] > 0.0 && b[j] > 0.0;
        known.then(|| (products[(i, j)].norm_sqr() / a[i] / b[j]).min(1.0))
    };
    let row = |i: usize| (0..b.len()).map(|j| value(i, j)).collect();
    (0..a.len()).map(row).collect()
}

/// Modal scale factor of `a` to `b`: the complex `s` that makes `|s a - b|` smallest, `a^H b / a^H
/// a`. `None` when `a` is zero or the lengths differ.
///
/// # Reference
/// Allemang (2003), The modal assurance criterion: twenty years of use and abuse, Sound and
/// Vibration 37(8), eq. 2.
pub fn modal_scale_factor(a: &[Complex64], b: &[Complex64]) -> Option<Complex64> {
    let norm = inner(a, a).re;
    (a.len() == b.len() && norm > 0.0).then(|| inner(a, b) / norm)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn values_of_the_matrix_are_those_of_its_pairs_of_columns() {
        let of = |modes: usize, shift: f64| {
            crate::linalg::complex_matrix(5, modes, |dof, mode| {
                let angle = (1 + dof) as f64 * (mode as f64 + shift);
                Complex64::new((1.0 + mode as f64) * angle.cos(), angle.sin())
            })
        };
        let (a, b) = (of(3, 0.3), of(4, 1.7));
        let column = |of: &ComplexMatrix, c: usize| -> Vec<Complex64> {
            (0..5).map(|dof| of[(dof, c)]).collect()
        };
        for (i, row) in mac_matrix(&a, &b).iter().enumerate() {
            assert_eq!(row.len(), 4);
            for (j, value) in row.iter().enumerate() {
                let expected = mac(&column(&a, i), &column(&b, j)).unwrap();
                assert!((value.unwrap() - expected).abs() < 1e-14, "{i} {j}");
            }
        }
    }

    proptest! {
        #[test]
        fn mac_is_bounded_and_blind_to_complex_scale(
            parts in proptest::collection::vec((-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64), 2..9),
            scale in (0.1..10.0f64, -3.0..3.0f64),
        ) {
            let a: Vec<_> = parts.iter().map(|p| Complex64::new(p.0 + 2.0, p.1)).collect();
            let b: Vec<_> = parts.iter().map(|p| Complex64::new(p.2, p.3 + 2.0)).collect();
            let turned: Vec<_> = b.iter().map(|v| v * Complex64::from_polar(scale.0, scale.1)).collect();
            let value = mac(&a, &b).unwrap();
            prop_assert!((0.0..=1.0).contains(&value));
            prop_assert!((mac(&a, &turned).unwrap() - value).abs() < 1e-12);
            prop_assert!((mac(&a, &a).unwrap() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn scale_factor_recovers_the_factor() {
        let a = [Complex64::new(1.0, 2.0), Complex64::new(-3.0, 0.5)];
        let s = Complex64::new(0.2, -4.0);
        let b = a.map(|v| v * s);
        assert!((modal_scale_factor(&a, &b).unwrap() - s).norm() < 1e-14);
    }
}
