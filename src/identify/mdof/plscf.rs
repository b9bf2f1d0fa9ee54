//! Polyreference least-squares complex frequency domain estimator (the family of PolyMAX): poles
//! and participation factors from a right matrix fraction in `z`.
//!
//! The receptances of output o over all inputs are modelled as `H_o(z) = B_o(z) A(z)⁻¹`, `B_o = Σ
//! b_oj z^j` (a row), `A = Σ A_j z^j` (a square matrix of the number of inputs, shared by all
//! outputs), `z = e^{i(ω − ω_0)T}`. The equation error `w_o(k) [H_o(k) A(z_k) − B_o(z_k)]` is
//! linear in all coefficients. Its normal equations hold `R_o = Σ w² z̄^i z^j`, `S_o = −Σ w² z̄^i
//! z^j H_o`, `T_o = Σ w² z̄^i z^j H_o^H H_o`, all of Toeplitz structure, so that one transform of
//! `w²`, `w² H` and, summed over all outputs first, `w² H^H H` gives them
//! ([`transforms`](crate::identify::mdof::normal_equations)). The numerators are eliminated, `M = Σ_o (T_o − S_o^H R_o⁻¹
//! S_o)`, and with `A_0 = I` the other coefficients follow from a positive definite system.
//! Numerators keep the highest order for all orders of the denominator, which makes the systems of
//! lower orders leading blocks of the highest: one Cholesky factor serves them all.
//!
//! *Choices.* The coefficients are complex: a band of lines knows nothing of the conjugate poles,
//! and of the poles of a complex denominator all lie in the band. The band takes [`ARC`] of the
//! circle, so that its two ends are not neighbours and what lies outside the band can be followed
//! by poles in the rest of the circle. With the *lowest* coefficient fixed the poles of noise come
//! out unstable and those of modes stable (Cauberghe et al. 2005). A pole goes back by `λ = iω_0 +
//! ln(z)/T`: the shift is undone before a natural frequency is formed.
//!
//! *Limit.* These are normal equations: what is below `√ε ≈ 1e-8` of the largest response is lost.
//! The estimate is not consistent (noise is on the regressors): it starts a refinement (`refine`),
//! and as a method of its own says how far it is off (`multi`).
//!
//! References: Guillaume, Verboven, Vanlanduit, Van der Auweraer and Peeters (2003), A
//! poly-reference implementation of the least-squares complex frequency-domain estimator, IMAC 21;
//! Cauberghe, Guillaume, Verboven, Vanlanduit and Parloo (2005), On the influence of the parameter
//! constraint on the stability of the poles and the discrimination capabilities of the
//! stabilisation diagrams, MSSP 19(5).

use num_complex::Complex64;
use rayon::prelude::*;

use crate::linalg::{self, ComplexMatrix, LinalgError};

use crate::identify::error::IdentifyError;
use crate::identify::mdof::normal_equations::{Output, TOGETHER, Transforms};
use crate::identify::mdof::pole_tracks::{GlobalPole, Table};
use crate::identify::mdof::stabilization::rising_orders;

/// Share of the circle that the lines of the band take.
const ARC: f64 = 0.8;
/// What is added to the diagonals, relative to their mean, so that data without noise have a
/// solution: rounding of sums at first, and no more than what the normal equations lose anyway.
const RIDGE: f64 = 1e-15;
const MOST_RIDGE: f64 = 1e-9;

/// The reduced normal equations at the highest order.
pub(in crate::identify) struct Lscf {
    inputs: usize,
    order: usize,
    /// Lower Cholesky factor of the rows and columns of `A_1` to `A_n`.
    lower: ComplexMatrix,
    /// `L⁻¹` times the negative columns of `A_0`.
    right: ComplexMatrix,
    plane: Plane,
}

/// How `z = e^{(λ − iω_0)T}` lies over the lines.
#[derive(Clone, Copy, Debug)]
pub(in crate::identify) struct Plane {
    /// First line, rad/s.
    pub omega_0: f64,
    /// T, s.
    pub step_s: f64,
}

/// Points of the circle for so many lines, and more than a number.
pub(in crate::identify) fn circle(lines: usize, least: usize) -> usize {
    let circle = (lines as f64 / ARC).ceil() as usize;
    circle.max(least).next_multiple_of(64)
}

impl Lscf {
    /// The equations of transformed lines.
    ///
    /// # Errors
    /// [`LinalgError::NotPositiveDefinite`].
    pub fn new(of: &Transforms) -> Result<Self, LinalgError> {
        let (m, order) = (of.inputs, of.order);
        let size = (order + 1) * m;
        let zero = || linalg::complex_matrix(size, size, |_, _| Complex64::ZERO);
        let chunks: Vec<Result<ComplexMatrix, LinalgError>> = of
            .outputs
            .par_chunks(TOGETHER)
            .map(|outputs| {
                let mut explained = zero();
                for output in outputs {
                    linalg::add_square(&mut explained, &output.half(order)?);
                }
                Ok(explained)
            })
            .collect();
        let mut sum = zero();
        for chunk in chunks {
            sum -= chunk?;
        }
        for column in 0..size {
            for row in column..size {
                let lags = &of.products[(row % m) * m + column % m];
                sum[(row, column)] += lags.at(row / m, column / m);
            }
        }
        let diagonal = (0..m).map(|p| of.products[p * m + p].at(0, 0).re);
        let scale = diagonal.sum::<f64>() / m as f64;
        Self::of_reduced(&sum, (m, order), (scale, of.plane))
    }

    /// The denominators of reduced normal equations `M` of the coefficients `A_0` to `A_n`, square
    /// matrices of the number of inputs, made from numbers of a scale; its lower triangle is
    /// enough.
    ///
    /// # Errors
    /// [`LinalgError::NotPositiveDefinite`].
    pub fn of_reduced(
        sum: &ComplexMatrix,
        (inputs, order): (usize, usize),
        (scale, plane): (f64, Plane),
    ) -> Result<Self, LinalgError> {
        let free = order * inputs;
        let matrix = linalg::complex_matrix(free, free, |i, j| sum[(inputs + i, inputs + j)]);
        let lower = factor(&matrix, scale)?;
        let right = linalg::complex_matrix(free, inputs, |i, j| -sum[(inputs + i, j)]);
        let right = linalg::solve_lower(&lower, &right);
        Ok(Self {
            inputs,
            order,
            lower,
            right,
            plane,
        })
    }

    /// Stable poles by rising order.
    ///
    /// # Errors
    /// [`LinalgError::NotConverged`].
    pub fn tables(&self) -> Result<Vec<Table>, IdentifyError> {
        self.tables_of(&rising_orders(self.order))
    }

    /// Stable poles of some orders, none above the highest.
    ///
    /// # Errors
    /// [`LinalgError::NotConverged`].
    pub fn tables_of(&self, orders: &[usize]) -> Result<Vec<Table>, IdentifyError> {
        // The highest takes longest: first, so that no thread is left alone with it.
        let tables: Vec<Result<Table, IdentifyError>> = orders
            .par_iter()
            .rev()
            .with_max_len(1)
            .map(|order| Ok((*order, self.poles(*order)?)))
            .collect();
        tables.into_iter().rev().collect()
    }

    /// The stable poles of an order, in ascending frequency.
    ///
    /// # Errors
    /// [`LinalgError::NotConverged`].
    fn poles(&self, order: usize) -> Result<Vec<GlobalPole>, LinalgError> {
        let (m, n) = (self.inputs, order);
        let size = m * n;
        let block = linalg::complex_matrix(size, size, |i, j| self.lower[(i, j)]);
        let right = linalg::complex_matrix(size, m, |i, j| self.right[(i, j)]);
        // Block j - 1 is A_j; A_0 = I.
        let a = linalg::solve_lower_adjoint(&block, &right);
        // With A_0 = I the reversed polynomial is monic: its companion matrix has the eigenvalues
        // 1/z.
        let companion = linalg::complex_matrix(size, size, |i, j| {
            if i < m {
                // First block row: -A_1, ..., -A_n by blocks.
                -a[((j / m) * m + i, j % m)]
            } else if i - m == j {
                Complex64::ONE
            } else {
                Complex64::ZERO
            }
        });
        let inverses = linalg::complex_eigenvalues(&companion)?;
        let mut poles: Vec<GlobalPole> = inverses
            .into_iter()
            // Stable: |z| < 1.
            .filter(|inverse| inverse.norm() > 1.0 && inverse.is_finite())
            .map(|inverse| {
                let z = inverse.inv();
                let lambda = z.ln() / self.plane.step_s + Complex64::new(0.0, self.plane.omega_0);
                let participation = participation(&a, (m, n), z)?;
                Ok(GlobalPole {
                    lambda: self.plane.unwrapped(lambda),
                    participation,
                })
            })
            .collect::<Result<_, LinalgError>>()?;
        poles.sort_by(|p, q| p.lambda.im.total_cmp(&q.lambda.im));
        Ok(poles)
    }
}

impl Plane {
    /// The branch of the logarithm that puts the pole around the band: the gap of the circle is
    /// shared by both sides.
    fn unwrapped(&self, lambda: Complex64) -> Complex64 {
        let turn = std::f64::consts::TAU / self.step_s;
        let lowest = self.omega_0 - 0.5 * (1.0 - ARC) * turn;
        let mut lambda = lambda;
        while lambda.im < lowest {
            lambda.im += turn;
        }
        while lambda.im >= lowest + turn {
            lambda.im -= turn;
        }
        lambda
    }
}

/// Cholesky factor with the least ridge that gives one; `scale` is that of the numbers that the
/// matrix was made from.
fn factor(matrix: &ComplexMatrix, scale: f64) -> Result<ComplexMatrix, LinalgError> {
    let size = matrix.nrows();
    let mut ridge = RIDGE * size as f64;
    loop {
        let raised = linalg::complex_matrix(size, size, |i, j| {
            let own = if i == j { ridge * scale } else { 0.0 };
            matrix[(i, j)] + own
        });
        match linalg::cholesky(&raised) {
            Err(_) if ridge < MOST_RIDGE => ridge *= 10.0,
            result => return result,
        }
    }
}

/// Participation factors of a pole: the left vector of `A(z)` for its smallest singular value, `Lᵀ
/// A(z) = 0`.
fn participation(
    a: &ComplexMatrix,
    (m, n): (usize, usize),
    z: Complex64,
) -> Result<Vec<Complex64>, LinalgError> {
    if m == 1 {
        return Ok(vec![Complex64::ONE]);
    }
    let mut value = linalg::complex_matrix(m, m, |i, j| {
        if i == j {
            Complex64::ONE
        } else {
            Complex64::ZERO
        }
    });
    let mut power = Complex64::ONE;
    for block in 0..n {
        power *= z;
        for i in 0..m {
            for j in 0..m {
                value[(i, j)] += a[(block * m + i, j)] * power;
            }
        }
    }
    let svd = linalg::singular_vectors(&value)?;
    // uᴴ A = s vᴴ, so that Lᵀ = uᴴ.
    Ok((0..m).map(|i| svd.left[(i, m - 1)].conj()).collect())
}

impl Output {
    /// `L⁻¹ S` with the factor `R = L Lᴴ`.
    fn half(&self, order: usize) -> Result<ComplexMatrix, LinalgError> {
        let m = self.functions.len();
        let size = order + 1;
        let r = linalg::complex_matrix(size, size, |i, j| self.weight.at(i, j));
        let s = linalg::complex_matrix(size, size * m, |i, column| {
            self.functions[column % m].at(i, column / m)
        });
        let lower = factor(&r, self.weight.at(0, 0).re)?;
        Ok(linalg::solve_lower(&lower, &s))
    }
}
