//! The polyreference least-squares complex frequency domain estimator (the family of PolyMAX) gives
//! poles and participation factors from a right matrix fraction in `z`.
//!
//! The receptances of output o over all inputs are modelled as `H_o(z) = B_o(z) A(z)⁻¹`, `B_o = Σ
//! b_oj z^j` (a row), `A = Σ A_j z^j` (a square matrix of the number of inputs, shared by all
//! outputs), `z = e^{i(ω − ω_0)T}`. The equation error `w_o(k) [H_o(k) A(z_k) − B_o(z_k)]` is
//! linear in all coefficients. Its normal equations hold `R_o = Σ w² z̄^i z^j`, `S_o = −Σ w² z̄^i
//! z^j H_o`, `T_o = Σ w² z̄^i z^j H_o^H H_o`, all of Toeplitz structure, so that one transform of
//! `w²`, `w² H` and, summed over all outputs first, `w² H^H H` gives them
//! ([`normal_equations`](crate::identify::mdof::normal_equations)). The numerators are eliminated,
//! `M = Σ_o (T_o − S_o^H R_o⁻¹ S_o)`, and with `A_0 = I` the other coefficients follow from a
//! positive definite system.
//! Numerators keep the highest order for all orders of the denominator, which makes the systems of
//! lower orders leading blocks of the highest: one Cholesky factor serves them all.
//!
//! *Choices.* The coefficients are complex: a band of lines shows no conjugate poles, and all poles
//! of a complex denominator lie in the band. The band takes a part of the circle
//! ([`z_plane`](crate::identify::mdof::z_plane)), so that its two ends are not neighbours and poles
//! in the remaining arc can model the out-of-band terms. With the *lowest* coefficient fixed the
//! poles of noise come out unstable and those of modes stable (Cauberghe et al. 2005). A pole goes
//! back by `λ = iω_0 + ln(z)/T`: the shift is undone before a natural frequency is formed.
//!
//! *Limit.* As in all normal equations, contributions below `√ε ≈ 1e-8` of the largest response are
//! lost. The estimate is not consistent (the regressors carry noise): the maximum likelihood method
//! refines it, and the `lscf` method adds its distance from the maximum of the likelihood to the
//! standard deviations ([`estimator`](crate::identify::mdof::estimator)).
//!
//! References: Guillaume, Verboven, Vanlanduit, Van der Auweraer and Peeters (2003), A
//! poly-reference implementation of the least-squares complex frequency-domain estimator, IMAC 21;
//! Cauberghe, Guillaume, Verboven, Vanlanduit and Parloo (2005), On the influence of the parameter
//! constraint on the stability of the poles and the discrimination capabilities of the
//! stabilisation diagrams, MSSP 19(5).

use num_complex::Complex64;
use rayon::prelude::*;

use crate::linalg::{self, ComplexMatrix, LinalgError, sort_ascending_by};

use crate::identify::error::IdentifyError;
use crate::identify::mdof::normal_equations::{CHUNK_OUTPUTS, Output, Transforms};
use crate::identify::mdof::pole_tracks::{GlobalPole, OrderPoles};
use crate::identify::mdof::stabilization::rising_orders;
use crate::identify::mdof::z_plane::ZPlane;

/// Minimum and maximum ridge on the diagonals, relative to their mean, so that data without noise
/// have a solution: the round-off of the sums, and the precision that normal equations lose.
const MIN_RIDGE: f64 = 1e-15;
const MAX_RIDGE: f64 = 1e-9;

/// The reduced normal equations at the highest order.
pub(in crate::identify) struct Lscf {
    inputs: usize,
    order: usize,
    /// Lower Cholesky factor of the rows and columns of `A_1` to `A_n`.
    lower: ComplexMatrix,
    /// `L⁻¹` times the negative columns of `A_0`.
    right: ComplexMatrix,
    plane: ZPlane,
}

impl Lscf {
    /// The equations of transformed lines.
    ///
    /// # Errors
    /// [`LinalgError::NotPositiveDefinite`].
    pub fn new(transforms: &Transforms) -> Result<Self, LinalgError> {
        let (m, order) = (transforms.inputs, transforms.order);
        let size = (order + 1) * m;
        let zero = || linalg::complex_matrix(size, size, |_, _| Complex64::ZERO);
        let chunks: Vec<Result<ComplexMatrix, LinalgError>> = transforms
            .outputs
            .par_chunks(CHUNK_OUTPUTS)
            .map(|outputs| {
                let mut explained = zero();
                for output in outputs {
                    linalg::add_square(&mut explained, &output.reduced_factor(order)?);
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
                let lags = &transforms.products[(row % m) * m + column % m];
                sum[(row, column)] += lags.at(row / m, column / m);
            }
        }
        let diagonal = (0..m).map(|p| transforms.products[p * m + p].at(0, 0).re);
        let scale = diagonal.sum::<f64>() / m as f64;
        Self::of_reduced(&sum, m, order, scale, transforms.plane)
    }

    /// The denominators of reduced normal equations `M` of the coefficients `A_0` to `A_n`, square
    /// matrices of the number of inputs, made from numbers of a scale; its lower triangle is
    /// enough.
    ///
    /// # Errors
    /// [`LinalgError::NotPositiveDefinite`].
    pub fn of_reduced(
        sum: &ComplexMatrix,
        inputs: usize,
        order: usize,
        scale: f64,
        plane: ZPlane,
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
    pub fn tables(&self) -> Result<Vec<OrderPoles>, IdentifyError> {
        self.tables_of(&rising_orders(self.order))
    }

    /// Stable poles of some orders, none above the highest.
    ///
    /// # Errors
    /// [`LinalgError::NotConverged`].
    pub fn tables_of(&self, orders: &[usize]) -> Result<Vec<OrderPoles>, IdentifyError> {
        // The highest order takes longest: it is first, so that the other threads do not wait for
        // it.
        let tables: Vec<Result<OrderPoles, IdentifyError>> = orders
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
        let m = self.inputs;
        let size = m * order;
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
                let participation = participation(&a, z)?;
                Ok(GlobalPole {
                    lambda: self.plane.unwrapped(lambda),
                    participation,
                })
            })
            .collect::<Result<_, LinalgError>>()?;
        sort_ascending_by(&mut poles, |pole| pole.lambda.im);
        Ok(poles)
    }
}

/// Cholesky factor with the smallest ridge that gives one; `scale` is the scale of the numbers that
/// the matrix was formed from.
fn factor(matrix: &ComplexMatrix, scale: f64) -> Result<ComplexMatrix, LinalgError> {
    let size = matrix.nrows();
    let mut ridge = MIN_RIDGE * size as f64;
    loop {
        let raised = linalg::complex_matrix(size, size, |i, j| {
            let added = if i == j { ridge * scale } else { 0.0 };
            matrix[(i, j)] + added
        });
        match linalg::cholesky(&raised) {
            Err(_) if ridge < MAX_RIDGE => ridge *= 10.0,
            result => return result,
        }
    }
}

/// Participation factors of a pole from the blocks `A_1` to `A_n`: the left vector of `A(z)` for
/// its smallest singular value, `Lᵀ A(z) = 0`.
fn participation(a: &ComplexMatrix, z: Complex64) -> Result<Vec<Complex64>, LinalgError> {
    let m = a.ncols();
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
    for block in 0..a.nrows() / m {
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
    fn reduced_factor(&self, order: usize) -> Result<ComplexMatrix, LinalgError> {
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
