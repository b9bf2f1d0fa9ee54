//! Methods in the z-domain: complex exponentials of samples, and the complex frequency domain of
//! their transform.

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix};

use super::modes::{LINES, Modes, SAMPLES, TOP_HZ};
use super::problem::{Problem, Rounded, normal_equations, roots, single};

const STEP_S: f64 = 0.5 / TOP_HZ;

fn poles_of(roots: Vec<Complex64>) -> Vec<Complex64> {
    roots.into_iter().map(|z| z.ln() / STEP_S).collect()
}

fn kept(values: Vec<Complex64>, rounded: Rounded) -> Vec<Complex64> {
    let largest = values.iter().map(|h| h.norm()).fold(0.0, f64::max);
    let scaled = values.iter().map(|h| h / largest);
    match rounded {
        Rounded::Nothing => scaled.collect(),
        _ => scaled.map(single).collect(),
    }
}

/// `h_{m+n} = −Σ_j c_j h_{m+j}` over the samples: the least-squares complex exponential.
pub fn exponentials(modes: &Modes, rounded: Rounded) -> Problem {
    let order = modes.order();
    let sample = |m: usize| modes.sum(|pole, a| a * (pole * STEP_S * m as f64).exp());
    let samples = kept((0..SAMPLES).map(sample).collect(), rounded);
    let rows = SAMPLES - order;
    let hankel = linalg::complex_matrix(rows, order, |m, j| samples[m + j]);
    let right: Vec<Complex64> = (0..rows).map(|m| -samples[m + order]).collect();
    let (matrix, right) = normal_equations(&hankel, &right);
    let poles = |solution: &[Complex64]| {
        let mut coefficients = solution.to_vec();
        coefficients.push(Complex64::ONE);
        roots(&coefficients).map(poles_of)
    };
    Problem::new(matrix, right, rounded, Box::new(poles))
}

/// `H(z) A(z) = B(z)` at lines of the band from 0 on, `H(z) = Σ a z/(z − e^{λT})`, `A_n = 1`; the
/// numerator eliminated from the normal equations, `M = T − Sᴴ R⁻¹ S`.
pub fn complex_frequency(modes: &Modes, rounded: Rounded) -> Problem {
    let order = modes.order();
    let z = |k: usize| Complex64::from_polar(1.0, std::f64::consts::PI * k as f64 / LINES as f64);
    let z: Vec<Complex64> = (0..LINES).map(z).collect();
    let value = |z: &Complex64| modes.sum(|pole, a| a * z / (z - (pole * STEP_S).exp()));
    let values = kept(z.iter().map(value).collect(), rounded);
    let power = |k: usize, j: usize| z[k].powu(j as u32);
    let numerator = linalg::complex_matrix(LINES, order + 1, power);
    let denominator = linalg::complex_matrix(LINES, order + 1, |k, j| values[k] * power(k, j));
    let r = numerator.adjoint() * &numerator;
    let s = numerator.adjoint() * &denominator;
    let t = denominator.adjoint() * &denominator;
    let solved = linalg::least_squares(&r, &s);
    let solved = solved.unwrap_or_else(|_| linalg::not_a_number(r.ncols(), s.ncols()));
    let reduced: ComplexMatrix = t - s.adjoint() * solved;
    let matrix = linalg::complex_matrix(order, order, |i, j| reduced[(i, j)]);
    let right = (0..order).map(|i| -reduced[(i, order)]).collect();
    let poles = |solution: &[Complex64]| {
        let mut coefficients = solution.to_vec();
        coefficients.push(Complex64::ONE);
        roots(&coefficients).map(poles_of)
    };
    Problem::new(matrix, right, rounded, Box::new(poles))
}
