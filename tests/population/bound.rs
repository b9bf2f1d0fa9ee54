//! The Cramér-Rao bound of poles from FRFs in white noise of known variance.
//!
//! Of the model `H_oi = s^d [Σ_r ψ_or L_ri/(s − λ_r) + conj. + C_oi + D_oi/s²]` at `s = iω` all is unknown: poles, shapes
//! `ψ`, participation `L` (of one reference: the residues), and a lower and an upper residual of every function. All columns
//! of the Jacobian matrix are combinations of `s^d`, `s^(d−2)` and of `s^d/(s − λ)`, `s^d/(s − λ)²` with their conjugate
//! partners; one QR decomposition of these makes of every function as many rows as there are such terms, and those of the
//! residuals come first, so that leaving their rows out leaves them out of everything else. Shapes go output by output in
//! the same way, participation at the end, and what is left is the triangle `R` of the poles: covariance `(RᵀR)⁻¹`.

use std::f64::consts::TAU;

use modalign::linalg::{ComplexMatrix, complex_matrix, inverse_upper, thin_qr};
use num_complex::Complex64;

/// A mode as the bound sees it.
pub struct Term {
    pub lambda: Complex64,
    /// `ψ`, by output.
    pub shape: Vec<Complex64>,
    /// `L`, by input.
    pub participation: Vec<Complex64>,
}

/// Lines and noise.
pub struct Noise<'a> {
    /// Angular frequencies, rad/s.
    pub omega: &'a [f64],
    /// 0, 1, 2 for receptance, mobility, accelerance.
    pub order: i32,
    /// E|z|² of the function of an output and an input.
    pub variance: &'a dyn Fn(usize, usize) -> f64,
}

/// Least standard deviations of what an unbiased estimate says of a pole.
#[derive(Clone, Copy, Debug)]
pub struct Deviation {
    pub frequency_hz: f64,
    pub damping: f64,
}

/// The bound of every term; infinite where the functions do not tell the pole.
pub fn deviations(terms: &[Term], noise: &Noise) -> Vec<Deviation> {
    let basis = Basis::new(terms, noise);
    let (n, inputs) = (terms.len(), terms[0].participation.len());
    let globals = 2 * n * inputs;
    let mut whole: Option<ComplexMatrix> = None;
    for output in 0..terms[0].shape.len() {
        let block = basis.output(terms, noise, output);
        let left = lower_block(&thin_qr(&block).r, 2 * n, globals);
        whole = Some(match whole {
            None => left,
            Some(before) => thin_qr(&stacked(&before, &left)).r,
        });
    }
    let triangle = lower_block(&whole.expect("a term has outputs"), globals - 2 * n, 2 * n);
    let inverse = inverse_upper(&triangle);
    // The columns of the poles are derivatives by parts of the decay rate.
    let covariance = |a: usize, b: usize, scale: f64| -> f64 {
        let product = (0..2 * n).map(|k| inverse[(a, k)] * inverse[(b, k)]);
        product.sum::<Complex64>().re * scale * scale
    };
    let deviation = |r: usize| {
        let lambda = terms[r].lambda;
        let own = |a: usize, b: usize| covariance(2 * r + a, 2 * r + b, lambda.re);
        propagated(lambda, [own(0, 0), own(0, 1), own(1, 1)])
    };
    (0..n).map(deviation).collect()
}

/// Deviations of `|λ|/2π` and `−Re λ/|λ|` from the covariance (xx, xy, yy) of the parts of `λ`.
fn propagated(lambda: Complex64, [xx, xy, yy]: [f64; 3]) -> Deviation {
    let (x, y, size) = (lambda.re, lambda.im, lambda.norm());
    let deviation = |dx: f64, dy: f64| {
        let variance = dx * dx * xx + 2.0 * dx * dy * xy + dy * dy * yy;
        if variance > 0.0 {
            variance.sqrt()
        } else {
            f64::INFINITY
        }
    };
    Deviation {
        frequency_hz: deviation(x / size, y / size) / TAU,
        damping: deviation(-y * y / size.powi(3), x * y / size.powi(3)),
    }
}

/// The terms that all columns are made of, as columns of a triangle without the rows of the residuals.
struct Basis {
    rows: usize,
    triangle: ComplexMatrix,
}

impl Basis {
    fn new(terms: &[Term], noise: &Noise) -> Self {
        let columns = 2 + 4 * terms.len();
        let values = complex_matrix(noise.omega.len(), columns, |k, c| {
            let s = Complex64::new(0.0, noise.omega[k]);
            let scale = noise.omega[noise.omega.len() / 2];
            let term = match c {
                0 => Complex64::ONE,
                1 => (scale / s).powi(2),
                _ => {
                    let lambda = terms[(c - 2) / 4].lambda;
                    let decay = -lambda.re;
                    let side = [lambda, lambda.conj()][(c - 2) % 2];
                    (decay / (s - side)).powi(1 + ((c - 2) % 4 / 2) as i32)
                }
            };
            term * (s / scale).powi(noise.order) * scale.powi(noise.order)
        });
        let triangle = thin_qr(&values).r;
        Self {
            rows: columns - 2,
            triangle: lower_rows(&triangle, 2),
        }
    }

    /// All columns of one output: shapes, then participation, then poles.
    fn output(&self, terms: &[Term], noise: &Noise, output: usize) -> ComplexMatrix {
        let (n, inputs) = (terms.len(), terms[0].participation.len());
        let columns = 2 * n + 2 * n * inputs;
        let mut block = complex_matrix(2 * self.rows * inputs, columns, |_, _| Complex64::ZERO);
        for (r, term) in terms.iter().enumerate() {
            let fixed = strongest(&term.participation);
            let mut free = 0;
            for (input, participation) in term.participation.iter().enumerate() {
                let weight = (2.0 / (noise.variance)(output, input)).sqrt();
                let (shape, decay) = (term.shape[output], -term.lambda.re);
                let first = 2 * self.rows * input;
                let mut put = |column: usize, factor: Complex64, power: usize| {
                    self.put(&mut block, (first, column), (r, power, factor * weight));
                };
                put(2 * r, participation / decay, 1);
                if input != fixed {
                    let place = 2 * n + 2 * ((inputs - 1) * r + free);
                    put(place, shape / decay, 1);
                    free += 1;
                }
                // By parts of the decay rate: d/dλ times the decay rate.
                put(2 * n * inputs + 2 * r, shape * participation / decay, 2);
            }
        }
        block
    }

    /// Two real columns, by the real and the imaginary part of what multiplies `factor`: `a u + a* v` and `i a u − i a* v`.
    fn put(
        &self,
        block: &mut ComplexMatrix,
        (first, column): (usize, usize),
        (r, power, factor): (usize, usize, Complex64),
    ) {
        let term = 2 + 4 * r + 2 * (power - 1);
        for part in 0..2 {
            let a = if part == 0 {
                factor
            } else {
                factor * Complex64::I
            };
            for row in 0..self.rows {
                let value =
                    a * self.triangle[(row, term)] + a.conj() * self.triangle[(row, term + 1)];
                block[(first + 2 * row, column + part)] = value.re.into();
                block[(first + 2 * row + 1, column + part)] = value.im.into();
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

/// A lone mode far from both ends of the lines: the decay rate and the damped frequency have the variance
/// `2 σ³ dω / (π Σ_p |R_p|²/v_p)` each (here `σ = 1`), `v` the variance of a complex value.
#[test]
fn the_bound_of_a_lone_mode_is_the_closed_form() {
    let lambda = Complex64::new(-1.0, 900.0);
    let step = 0.05;
    let omega: Vec<f64> = (0..8001).map(|k| 700.0 + step * k as f64).collect();
    let shape = vec![Complex64::new(1.0, 0.2), Complex64::new(-0.4, 0.1)];
    let participation = vec![Complex64::new(0.3, 0.0), Complex64::new(0.0, -0.7)];
    let variance = |o: usize, i: usize| 1e-4 * (1 + o + 2 * i) as f64;
    let noise = Noise {
        omega: &omega,
        order: 0,
        variance: &variance,
    };
    let pairs = [(0, 0), (0, 1), (1, 0), (1, 1)];
    let power =
        |&(o, i): &(usize, usize)| (shape[o] * participation[i]).norm_sqr() / variance(o, i);
    let over: f64 = pairs.iter().map(power).sum();
    let expected = (2.0 * step / (std::f64::consts::PI * over)).sqrt();
    let terms = [Term {
        lambda,
        shape: shape.clone(),
        participation: participation.clone(),
    }];
    let bound = deviations(&terms, &noise)[0];
    // The residuals and what lies beyond the lines cost a little: twice the ratio of the half-power width to their range.
    let frequency = bound.frequency_hz * TAU / expected;
    let damping = bound.damping * lambda.norm() / expected;
    assert!(frequency > 1.0 && frequency < 1.02, "{frequency}");
    assert!(damping > 1.0 && damping < 1.02, "{damping}");
}
