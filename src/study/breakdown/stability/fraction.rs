//! Rational fractions in the Laplace domain, in powers and in orthogonal polynomials.
//!
//! `Σ_k |N(x_k) − H_k D(x_k)|²` over the lines, `x = iω/ω_max`, the highest coefficient of `D` one,
//! all coefficients real: rows of the real and of the imaginary parts.

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix};

use super::modes::{LINES, Modes, TOP_HZ};
use super::problem::{Problem, Rounded, normal_equations, roots, single};

const TOP_RAD_S: f64 = std::f64::consts::TAU * TOP_HZ;

/// Lines `x` and receptances there, in units of their largest.
fn lines(modes: &Modes, rounded: Rounded) -> (Vec<Complex64>, Vec<Complex64>) {
    let x = |k: usize| Complex64::new(0.0, (k + 1) as f64 / LINES as f64);
    let x: Vec<Complex64> = (0..LINES).map(x).collect();
    let value = |x: &Complex64| modes.sum(|pole, a| a / (TOP_RAD_S * x - pole));
    let values: Vec<Complex64> = x.iter().map(value).collect();
    let largest = values.iter().map(|h| h.norm()).fold(0.0, f64::max);
    let scaled = values.iter().map(|h| h / largest);
    let values = match rounded {
        Rounded::Nothing => scaled.collect(),
        _ => scaled.map(single).collect(),
    };
    (x, values)
}

/// Normal equations of numerator columns and `−H` times denominator columns, the last of which goes
/// to the right-hand side.
fn equations(
    numerator: &[Vec<Complex64>],
    denominator: &[Vec<Complex64>],
    values: &[Complex64],
) -> (ComplexMatrix, Vec<Complex64>) {
    let order = denominator.len() - 1;
    let part = |i: usize, value: Complex64| match i < values.len() {
        true => Complex64::from(value.re),
        false => Complex64::from(value.im),
    };
    let columns = numerator.len() + order;
    let rows = linalg::complex_matrix(2 * values.len(), columns, |i, j| {
        let k = i % values.len();
        let value = match j.checked_sub(numerator.len()) {
            None => numerator[j][k],
            Some(j) => -values[k] * denominator[j][k],
        };
        part(i, value)
    });
    let right = |i: usize| {
        let k = i % values.len();
        part(i, values[k] * denominator[order][k])
    };
    let right: Vec<Complex64> = (0..2 * values.len()).map(right).collect();
    normal_equations(&rows, &right)
}

/// Powers of `iω/ω_max`: the ordinary form.
pub fn powers(modes: &Modes, rounded: Rounded) -> Problem {
    let order = modes.order();
    let (x, values) = lines(modes, rounded);
    let column = |j: usize| x.iter().map(|x| x.powu(j as u32)).collect();
    let columns: Vec<Vec<Complex64>> = (0..=order).map(column).collect();
    let (matrix, right) = equations(&columns[..order], &columns, &values);
    let poles = move |solution: &[Complex64]| {
        let mut coefficients = solution[order..].to_vec();
        coefficients.push(Complex64::ONE);
        let found = roots(&coefficients)?;
        Some(found.into_iter().map(|x| TOP_RAD_S * x).collect())
    };
    Problem::new(matrix, right, rounded, Box::new(poles))
}

/// Polynomials orthonormal on the lines and their conjugates: the numerator's as they are, the
/// denominator's under `|H|²`.
pub fn orthogonal(modes: &Modes, rounded: Rounded) -> Problem {
    let order = modes.order();
    let (x, values) = lines(modes, rounded);
    let plain = Basis::new(&x, &vec![1.0; x.len()], order - 1);
    let weight: Vec<f64> = values.iter().map(|h| h.norm()).collect();
    let weighted = Basis::new(&x, &weight, order);
    let unweighted_columns: Vec<Vec<Complex64>> = weighted
        .columns
        .iter()
        .map(|c| unweighted(c, &weight))
        .collect();
    let (matrix, right) = equations(&plain.columns, &unweighted_columns, &values);
    let poles = move |solution: &[Complex64]| {
        let mut coefficients = solution[order..].to_vec();
        coefficients.push(Complex64::ONE);
        let found = weighted.roots(&coefficients)?;
        Some(found.into_iter().map(|x| TOP_RAD_S * x).collect())
    };
    Problem::new(matrix, right, rounded, Box::new(poles))
}

fn unweighted(column: &[Complex64], weight: &[f64]) -> Vec<Complex64> {
    column.iter().zip(weight).map(|(c, w)| c / w).collect()
}

/// Polynomials with real coefficients, orthonormal over the lines and their conjugates.
///
/// Forsythe (1957), J. SIAM 5(2): on points symmetric about zero `x φ_j = a_j φ_{j+1} − a_{j−1}
/// φ_{j−1}`; orthogonalised against all before, twice, as rounding asks for.
struct Basis {
    columns: Vec<Vec<Complex64>>,
    /// `x φ_j = Σ_i h_ji φ_i`.
    recurrence: Vec<Vec<f64>>,
}

impl Basis {
    fn new(x: &[Complex64], weight: &[f64], degree: usize) -> Self {
        let first = weight.iter().map(|w| Complex64::from(*w)).collect();
        let mut columns = vec![normalised(first).0];
        let mut recurrence = Vec::with_capacity(degree);
        for j in 0..degree {
            let mut next: Vec<Complex64> = columns[j].iter().zip(x).map(|(v, x)| v * x).collect();
            let mut factors = vec![0.0; j + 1];
            for _ in 0..2 {
                for (column, factor) in columns.iter().zip(&mut factors) {
                    // Of a line and its conjugate.
                    let products = column.iter().zip(&next).map(|(a, b)| (a.conj() * b).re);
                    let dot = products.sum::<f64>();
                    next.iter_mut().zip(column).for_each(|(v, a)| *v -= dot * a);
                    *factor += dot;
                }
            }
            let (next, norm) = normalised(next);
            factors.push(norm);
            columns.push(next);
            recurrence.push(factors);
        }
        Self {
            columns,
            recurrence,
        }
    }

    /// Roots of `Σ d_j φ_j`: eigenvalues of the recurrence with its last row changed.
    fn roots(&self, coefficients: &[Complex64]) -> Option<Vec<Complex64>> {
        let order = coefficients.len() - 1;
        let comrade = linalg::complex_matrix(order, order, |j, i| {
            let term = self.recurrence[j].get(i).copied().unwrap_or(0.0);
            let over = if j + 1 == order {
                self.recurrence[j][order] * coefficients[i] / coefficients[order]
            } else {
                Complex64::ZERO
            };
            term - over
        });
        linalg::complex_eigenvalues(&comrade).ok()
    }
}

fn normalised(mut values: Vec<Complex64>) -> (Vec<Complex64>, f64) {
    let norm = values.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
    values.iter_mut().for_each(|v| *v /= norm);
    (values, norm)
}
