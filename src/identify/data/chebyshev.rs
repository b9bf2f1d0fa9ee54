//! Chebyshev polynomials represent smooth functions of frequency on a range of lines.
//!
//! A function is found from its values at the Chebyshev nodes. For a pole at three half-lengths
//! from the middle of the range the error falls by ρ = 3 + √8 with each degree (Trefethen 2013,
//! Approximation Theory and Approximation Practice, theorem 8.2).

use std::f64::consts::PI;

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix};

/// Polynomials on a range of frequencies.
pub(in crate::identify) struct Chebyshev {
    /// Middle and half length, rad/s.
    middle: f64,
    half_length: f64,
    count: usize,
}

impl Chebyshev {
    /// A number of polynomials on a range of a middle and a half length, rad/s.
    pub fn new(middle: f64, half_length: f64, count: usize) -> Self {
        Self {
            middle,
            half_length,
            count,
        }
    }

    /// Angles of frequencies on the range, whose cosines are their positions from −1 to 1.
    pub fn angles(&self, omega: &[f64]) -> Vec<f64> {
        let position = |omega: &f64| (omega - self.middle) / self.half_length;
        let angle = |omega: &f64| position(omega).clamp(-1.0, 1.0).acos();
        omega.iter().map(angle).collect()
    }

    /// The polynomial of a degree at an angle.
    pub fn value(degree: usize, angle: f64) -> Complex64 {
        Complex64::from((degree as f64 * angle).cos())
    }

    /// Frequencies of the nodes, rad/s.
    pub fn nodes(&self) -> Vec<f64> {
        let node = |i: usize| self.middle + self.half_length * self.angle(i).cos();
        (0..self.count).map(node).collect()
    }

    /// Coefficients of the polynomials from values at the nodes, polynomials × nodes: `(2 −
    /// δ_n0)/count T_n(x_i)`.
    pub fn coefficients(&self) -> ComplexMatrix {
        linalg::complex_matrix(self.count, self.count, |n, i| {
            let factor = if n == 0 { 1.0 } else { 2.0 };
            Complex64::from(factor / self.count as f64 * (n as f64 * self.angle(i)).cos())
        })
    }

    fn angle(&self, node: usize) -> f64 {
        PI * (node as f64 + 0.5) / self.count as f64
    }
}
