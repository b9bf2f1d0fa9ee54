//! The Cramér-Rao bound limits the variance of poles estimated from FRFs in white noise of known
//! variance.
//!
//! All parameters of the model `H_oi = s^d [Σ_r ψ_or L_ri/(s − λ_r) + conj. + C_oi + D_oi/s²]` at
//! `s = iω` are unknown: poles, shapes `ψ`, participation factors `L` (with one reference: the
//! residues), and a lower and an upper residual of every FRF. All columns of the Jacobian matrix
//! are combinations of `s^d`, `s^(d−2)` and of `s^d/(s − λ)`, `s^d/(s − λ)²` with their conjugate
//! partners. One QR decomposition of these terms compresses every FRF to one row per term. The rows
//! of the lower and upper residuals come first; dropping these rows eliminates the residuals.
//! Shapes are eliminated in the same way output by output, then the participation factors. The
//! remaining triangle `R` belongs to the poles: their covariance is `(RᵀR)⁻¹`.
//!
//! # Reference
//! Kay (1993), Fundamentals of statistical signal processing: estimation theory, section 3.9
//! (Gaussian noise).

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::linalg::{ComplexMatrix, ThinQr, complex_matrix, inverse_upper, thin_qr};

use super::system::TrueMode;

/// Frequency lines and noise variances of FRFs.
#[derive(Clone, Copy, Debug)]
pub struct NoisyLines<'a> {
    /// Angular frequencies, rad/s; those of 0 and below are left out.
    pub omega: &'a [f64],
    /// 0, 1, 2 for receptance, mobility, accelerance.
    pub order: i32,
    /// `E|z|²` of the function of every response and reference, reference by reference.
    pub variances: &'a [f64],
}

/// Minimum standard deviations of an unbiased estimate of a pole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoleBound {
    /// Of the natural frequency, Hz.
    pub frequency_hz: f64,
    /// Of the damping ratio.
    pub damping: f64,
}

/// Bound of a pole that the data do not determine.
const UNBOUNDED: PoleBound = PoleBound {
    frequency_hz: f64::INFINITY,
    damping: f64::INFINITY,
};

/// The bound of every mode, all of them estimated together; infinite where the FRFs do not
/// determine the pole.
pub fn pole_bounds(modes: &[&TrueMode], lines: &NoisyLines) -> Vec<PoleBound> {
    let Some(first) = modes.first() else {
        return Vec::new();
    };
    let Some(basis) = Basis::new(modes, lines) else {
        return vec![UNBOUNDED; modes.len()];
    };
    let (n, inputs) = (modes.len(), first.participation.len());
    let globals = 2 * n * inputs;
    let mut whole = complex_matrix(0, globals, |_, _| Complex64::ZERO);
    for output in 0..first.shape.len() {
        let block = basis.output(modes, lines, output);
        let stacked = |block: ThinQr| stacked(&whole, &lower_block(&block.r, 2 * n, globals));
        let Ok(triangle) = thin_qr(&block).and_then(|block| thin_qr(&stacked(block))) else {
            return vec![UNBOUNDED; modes.len()];
        };
        whole = triangle.r;
    }
    let triangle = lower_block(&whole, globals - 2 * n, 2 * n);
    let inverse = inverse_upper(&triangle);
    // The columns of the poles are derivatives by parts of the decay rate.
    let covariance = |a: usize, b: usize, scale: f64| -> f64 {
        let product = (0..2 * n).map(|k| inverse[(a, k)] * inverse[(b, k)]);
        product.sum::<Complex64>().re * scale * scale
    };
    let deviation = |(r, mode): (usize, &&TrueMode)| {
        let lambda = mode.pole.lambda;
        let element = |a: usize, b: usize| covariance(2 * r + a, 2 * r + b, lambda.re);
        propagated(lambda, [element(0, 0), element(0, 1), element(1, 1)])
    };
    modes.iter().enumerate().map(deviation).collect()
}

/// Deviations of `|λ|/2π` and `−Re λ/|λ|` from the covariance (xx, xy, yy) of the parts of `λ`.
fn propagated(lambda: Complex64, [xx, xy, yy]: [f64; 3]) -> PoleBound {
    let (x, y, size) = (lambda.re, lambda.im, lambda.norm());
    let deviation = |dx: f64, dy: f64| {
        let variance = dx * dx * xx + 2.0 * dx * dy * xy + dy * dy * yy;
        if variance > 0.0 {
            variance.sqrt()
        } else {
            f64::INFINITY
        }
    };
    PoleBound {
        frequency_hz: deviation(x / size, y / size) / TAU,
        damping: deviation(-y * y / size.powi(3), x * y / size.powi(3)),
    }
}

/// The terms of which all columns are combinations, as columns of a triangle without the rows of
/// the lower and upper residuals.
struct Basis {
    rows: usize,
    triangle: ComplexMatrix,
}

impl Basis {
    /// `None` where there are fewer lines than terms.
    fn new(modes: &[&TrueMode], lines: &NoisyLines) -> Option<Self> {
        let columns = 2 + 4 * modes.len();
        let omega: Vec<f64> = lines.omega.iter().copied().filter(|o| *o > 0.0).collect();
        if omega.len() < columns {
            return None;
        }
        let scale = omega[omega.len() / 2];
        let values = complex_matrix(omega.len(), columns, |k, c| {
            let s = Complex64::new(0.0, omega[k]);
            let term = match c {
                0 => Complex64::ONE,
                1 => (scale / s).powi(2),
                _ => {
                    let lambda = modes[(c - 2) / 4].pole.lambda;
                    let decay = -lambda.re;
                    let side = [lambda, lambda.conj()][(c - 2) % 2];
                    (decay / (s - side)).powi(1 + ((c - 2) % 4 / 2) as i32)
                }
            };
            term * (s / scale).powi(lines.order) * scale.powi(lines.order)
        });
        let triangle = thin_qr(&values).ok()?.r;
        Some(Self {
            rows: columns - 2,
            triangle: lower_rows(&triangle, 2),
        })
    }

    /// All columns of one output: shapes, then participation, then poles.
    fn output(&self, modes: &[&TrueMode], lines: &NoisyLines, output: usize) -> ComplexMatrix {
        let (n, inputs) = (modes.len(), modes[0].participation.len());
        let columns = 2 * n + 2 * n * inputs;
        let mut block = complex_matrix(2 * self.rows * inputs, columns, |_, _| Complex64::ZERO);
        for (r, mode) in modes.iter().enumerate() {
            let fixed = strongest(&mode.participation);
            let mut free = 0;
            for (input, participation) in mode.participation.iter().enumerate() {
                let variance = lines.variances[input * mode.shape.len() + output];
                let weight = (2.0 / variance).sqrt();
                let (shape, decay) = (mode.shape[output], -mode.pole.lambda.re);
                let first = 2 * self.rows * input;
                let mut put = |column: usize, factor: Complex64, power: usize| {
                    let term = 2 + 4 * r + 2 * (power - 1);
                    self.put(&mut block, first, column, term, factor * weight);
                };
                put(2 * r, participation / decay, 1);
                if input != fixed {
                    let position = 2 * n + 2 * ((inputs - 1) * r + free);
                    put(position, shape / decay, 1);
                    free += 1;
                }
                // By parts of the decay rate: d/dλ times the decay rate.
                put(2 * n * inputs + 2 * r, shape * participation / decay, 2);
            }
        }
        block
    }

    /// Two real columns, by the real and the imaginary part of the parameter that multiplies
    /// `factor`: `a u + a* v` and `i a u − i a* v` with the columns `u` and `v` of a term and of
    /// its conjugate.
    fn put(
        &self,
        block: &mut ComplexMatrix,
        first_row: usize,
        column: usize,
        term: usize,
        factor: Complex64,
    ) {
        for part in 0..2 {
            let a = if part == 0 {
                factor
            } else {
                factor * Complex64::I
            };
            for row in 0..self.rows {
                let value =
                    a * self.triangle[(row, term)] + a.conj() * self.triangle[(row, term + 1)];
                block[(first_row + 2 * row, column + part)] = value.re.into();
                block[(first_row + 2 * row + 1, column + part)] = value.im.into();
            }
        }
    }
}

fn strongest(values: &[Complex64]) -> usize {
    let order = |a: &usize, b: &usize| values[*a].norm().total_cmp(&values[*b].norm());
    (0..values.len()).max_by(order).unwrap_or(0)
}

fn lower_rows(matrix: &ComplexMatrix, first: usize) -> ComplexMatrix {
    complex_matrix(matrix.nrows() - first, matrix.ncols(), |i, j| {
        matrix[(first + i, j)]
    })
}

/// The square block of a triangle from a row and column on.
fn lower_block(triangle: &ComplexMatrix, first: usize, size: usize) -> ComplexMatrix {
    complex_matrix(size, size, |i, j| triangle[(first + i, first + j)])
}

fn stacked(upper: &ComplexMatrix, lower: &ComplexMatrix) -> ComplexMatrix {
    let rows = upper.nrows();
    complex_matrix(rows + lower.nrows(), upper.ncols(), |i, j| match i < rows {
        true => upper[(i, j)],
        false => lower[(i - rows, j)],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::Pole;

    /// A lone mode far from both ends of the lines: the decay rate and the damped frequency have
    /// the variance `2 σ³ dω / (π Σ_p |R_p|²/v_p)` each (here `σ = 1`), `v` the variance of a
    /// complex value.
    #[test]
    fn the_bound_of_a_lone_mode_is_the_closed_form() {
        let lambda = Complex64::new(-1.0, 900.0);
        let step = 0.05;
        let omega: Vec<f64> = (0..8001).map(|k| 700.0 + step * k as f64).collect();
        let mode = TrueMode {
            pole: Pole { lambda },
            shape: vec![Complex64::new(1.0, 0.2), Complex64::new(-0.4, 0.1)],
            participation: vec![Complex64::new(0.3, 0.0), Complex64::new(0.0, -0.7)],
        };
        let pairs = [(0, 0), (1, 0), (0, 1), (1, 1)];
        let variances = pairs.map(|(o, i)| 1e-4 * (1 + o + 2 * i) as f64);
        let lines = NoisyLines {
            omega: &omega,
            order: 0,
            variances: &variances,
        };
        let power = pairs.iter().zip(variances);
        let power = power.map(|(&(o, i), v)| mode.residue(o, i).norm_sqr() / v);
        let over: f64 = power.sum();
        let expected = (2.0 * step / (std::f64::consts::PI * over)).sqrt();
        let bound = pole_bounds(&[&mode], &lines)[0];
        // The residuals and the missing lines beyond the band cost a little: twice the ratio of the
        // half-power width to their range.
        let frequency = bound.frequency_hz * TAU / expected;
        let damping = bound.damping * lambda.norm() / expected;
        assert!(frequency > 1.0 && frequency < 1.02, "{frequency}");
        assert!(damping > 1.0 && damping < 1.02, "{damping}");
    }
}
