//! Receptances on the lines of a band, which share the measured values with the FRF set.
//!
//! FRFs of many points take most of the memory of an identification, and are held once: receptances
//! are the set's values themselves, or computed from mobilities and accelerances where they are
//! read.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix, RowProduct};

/// Values of one FRF.
#[derive(Clone)]
pub(in crate::identify) struct MeasuredValues {
    /// As measured, on all lines of the set.
    pub measured: Arc<Vec<Complex64>>,
    /// The first line of the band in the set.
    pub first: usize,
    /// Factors of the lines of the band; `None` for a receptance.
    pub factors: Option<Arc<Vec<Complex64>>>,
}

/// Receptances of a band by FRF.
pub(in crate::identify) struct FrfValues {
    frfs: Vec<MeasuredValues>,
    lines: usize,
}

impl FrfValues {
    /// Values on a number of lines.
    pub fn new(frfs: Vec<MeasuredValues>, lines: usize) -> Self {
        Self { frfs, lines }
    }

    /// Some of the FRFs, by their numbers.
    pub fn sample(&self, functions: &[usize]) -> Self {
        let frfs = functions.iter().map(|f| self.frfs[*f].clone());
        Self::new(frfs.collect(), self.lines)
    }

    /// Number of FRFs.
    pub fn functions(&self) -> usize {
        self.frfs.len()
    }

    /// Receptance of an FRF at a line.
    #[inline]
    pub fn at(&self, function: usize, line: usize) -> Complex64 {
        let frf = &self.frfs[function];
        let measured = frf.measured[frf.first..][..self.lines][line];
        match &frf.factors {
            Some(factors) => factors[line] * measured,
            None => measured,
        }
    }

    /// Receptances of an FRF on a range of lines.
    pub fn of(&self, function: usize, lines: Range<usize>) -> Cow<'_, [Complex64]> {
        let frf = &self.frfs[function];
        let measured = &frf.measured[frf.first..][..self.lines][lines.clone()];
        match &frf.factors {
            Some(factors) => {
                let pairs = factors[lines].iter().zip(measured);
                Cow::Owned(pairs.map(|(factor, measured)| factor * measured).collect())
            }
            None => Cow::Borrowed(measured),
        }
    }

    /// Receptances of an FRF on all lines.
    pub fn all_of(&self, function: usize) -> Cow<'_, [Complex64]> {
        self.of(function, 0..self.lines)
    }

    /// Replaces the receptances of an FRF.
    pub fn set(&mut self, function: usize, values: Vec<Complex64>) {
        self.frfs[function] = MeasuredValues {
            measured: Arc::new(values),
            first: 0,
            factors: None,
        };
    }

    /// `Aᴴ H` of the receptances H on a range of lines, lines × FRFs.
    pub fn adjoint_product(&self, a: &ComplexMatrix, lines: Range<usize>) -> ComplexMatrix {
        let fill = |f: usize, column: &mut [Complex64]| self.copy(f, lines.clone(), column);
        linalg::adjoint_product_from(a, self.functions(), &fill)
    }

    /// `H − A C` of the receptances H, with products on ranges of lines; `append` converts the
    /// difference of an FRF on each range.
    pub fn subtract_products<T: Send>(
        &self,
        products: &[RowProduct<'_>],
        append: impl Fn(usize, Range<usize>, &[Complex64], &mut Vec<T>) + Sync,
    ) -> Vec<Vec<T>> {
        let fill = |f: usize, lines: Range<usize>, column: &mut [Complex64]| {
            self.copy(f, lines, column);
        };
        linalg::subtract_row_products(self.functions(), products, &fill, &append)
    }

    fn copy(&self, function: usize, lines: Range<usize>, column: &mut [Complex64]) {
        column.copy_from_slice(&self.of(function, lines));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mobilities_are_read_as_receptances() {
        let measured = Arc::new((0..5).map(|k| Complex64::new(f64::from(k), 1.0)).collect());
        let factors: Vec<Complex64> = (0..3).map(|k| Complex64::new(0.0, -f64::from(k))).collect();
        let frf = |factors| MeasuredValues {
            measured: Arc::clone(&measured),
            first: 2,
            factors,
        };
        let frfs = vec![frf(None), frf(Some(Arc::new(factors.clone())))];
        let mut values = FrfValues::new(frfs, 3);
        let expected = |f: usize, k: usize| match f {
            0 => measured[2 + k],
            _ => factors[k] * measured[2 + k],
        };
        let a = linalg::complex_matrix(2, 1, |k, _| Complex64::new(1.0, k as f64));
        let c = linalg::complex_matrix(1, 2, |_, f| Complex64::new(0.5, f as f64));
        let along = values.adjoint_product(&a, 1..3);
        let product = RowProduct {
            rows: 1..3,
            a: a.clone(),
            c: Cow::Borrowed(&c),
        };
        let copy = |_, _, rest: &[Complex64], all: &mut Vec<Complex64>| all.extend_from_slice(rest);
        let rest = values.subtract_products(&[product], copy);
        for f in 0..2 {
            for k in 0..3 {
                assert_eq!(values.at(f, k), expected(f, k));
                assert_eq!(values.all_of(f)[k], expected(f, k));
            }
            let product: Complex64 = (1..3).map(|k| a[(k - 1, 0)].conj() * expected(f, k)).sum();
            assert!((along[(0, f)] - product).norm() < 1e-14);
            for k in 1..3 {
                let remaining = expected(f, k) - a[(k - 1, 0)] * c[(0, f)];
                assert!((rest[f][k - 1] - remaining).norm() < 1e-14);
            }
        }
        values.set(1, vec![Complex64::ONE; 3]);
        assert_eq!(values.sample(&[1]).at(0, 2), Complex64::ONE);
    }
}
