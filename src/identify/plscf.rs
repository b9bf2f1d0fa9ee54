//! Polyreference least-squares complex frequency domain estimator (the family of PolyMAX): poles and participation factors
//! from a right matrix fraction in `z`.
//!
//! The receptances of output o over all inputs are modelled as `H_o(z) = B_o(z) A(z)⁻¹`, `B_o = Σ b_oj z^j` (a row),
//! `A = Σ A_j z^j` (a square matrix of the number of inputs, shared by all outputs), `z = e^{i(ω − ω_0)T}`. The equation error
//! `w_o(k) [H_o(k) A(z_k) − B_o(z_k)]` is linear in all coefficients. Its normal equations hold
//! `R_o = Σ w² z̄^i z^j`, `S_o = −Σ w² z̄^i z^j H_o`, `T_o = Σ w² z̄^i z^j H_o^H H_o`, all of Toeplitz structure, so that one
//! transform of `w²`, `w² H` and `w² H^H H` gives them. The numerators are eliminated, `M = Σ_o (T_o − S_o^H R_o⁻¹ S_o)`, and
//! with `A_0 = I` the other coefficients follow from a positive definite system. Numerators keep the highest order for all
//! orders of the denominator, which makes the systems of lower orders leading blocks of the highest: one Cholesky factor serves
//! them all.
//!
//! *Choices.* The coefficients are complex: a band of lines knows nothing of the conjugate poles, and of the poles of a complex
//! denominator all lie in the band. The band takes [`ARC`] of the circle, so that its two ends are not neighbours and what lies
//! outside the band can be followed by poles in the rest of the circle. With the *lowest* coefficient fixed the poles of noise
//! come out unstable and those of modes stable (Cauberghe et al. 2005). A pole goes back by `λ = iω_0 + ln(z)/T`: the shift is
//! undone before a natural frequency is formed.
//!
//! *Limit.* These are normal equations: what is below `√ε ≈ 1e-8` of the largest response is lost. The estimate is not
//! consistent (noise is on the regressors): it starts a refinement (`refine`), and as a method of its own says how far it is off (`multi`).
//!
//! References: Guillaume, Verboven, Vanlanduit, Van der Auweraer and Peeters (2003), A poly-reference implementation of the
//! least-squares complex frequency-domain estimator, IMAC 21; Cauberghe, Guillaume, Verboven, Vanlanduit and Parloo (2005), On
//! the influence of the parameter constraint on the stability of the poles and the discrimination capabilities of the
//! stabilisation diagrams, MSSP 19(5).

use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::fourier::ComplexPlan;
use crate::linalg::{self, ComplexMatrix, LinalgError};

use super::IdentifyError;
use super::receptance::Receptances;
use super::sides::Sides;
use super::stabilization::rising_orders;
use super::stable::{GlobalPole, Table};

/// Share of the circle that the lines of the band take.
const ARC: f64 = 0.8;
/// What is added to the diagonals, relative to their mean, so that data without noise have a solution: rounding of sums at
/// first, and no more than what the normal equations lose anyway.
const RIDGE: f64 = 1e-15;
const MOST_RIDGE: f64 = 1e-9;

/// Error of the model relative to the response, squared: strong resonances far above the noise would leave nothing of weak ones in
/// the normal equations. Once poles are known, weak ones have been found.
const MODEL: f64 = 1e-6;
const MODEL_OF_KNOWN: f64 = 1e-10;

/// The reduced normal equations at the highest order.
pub(super) struct Lscf {
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
pub(super) struct Plane {
    /// First line, rad/s.
    pub omega_0: f64,
    /// T, s.
    pub step_s: f64,
}

/// Points of the circle for so many lines, and more than a number.
pub(super) fn circle(lines: usize, least: usize) -> usize {
    let circle = (lines as f64 / ARC).ceil() as usize;
    circle.max(least).next_multiple_of(64)
}

impl Lscf {
    /// Builds the equations of some lines up to an order; `sides` must be complete. Every line is weighted by one over what the
    /// denominator of known poles, rad/s, makes of its noise.
    ///
    /// # Errors
    /// [`LinalgError::NotConverged`] when the equations are not positive definite.
    pub fn new(
        data: &Receptances,
        sides: &Sides,
        (lines, order, known): (Range<usize>, usize, &[Complex64]),
    ) -> Result<Self, LinalgError> {
        let circle = circle(lines.len(), 2 * order + 2);
        let plan = ComplexPlan::inverse(circle);
        let step_s = std::f64::consts::TAU / (circle as f64 * data.step);
        let model = if known.is_empty() {
            MODEL
        } else {
            MODEL_OF_KNOWN
        };
        let course = course(&data.omega[lines.clone()], step_s, known);
        let inputs = sides.inputs;
        let parts: Vec<Result<(ComplexMatrix, f64), LinalgError>> = sides
            .outputs
            .par_iter()
            .map(|output| reduced(data, output, (&plan, &lines, (&course, model), order)))
            .collect();
        let size = (order + 1) * inputs;
        let mut sum = linalg::complex_matrix(size, size, |_, _| Complex64::ZERO);
        let mut scale = 0.0;
        for part in parts {
            let (own, own_scale) = part?;
            sum += own;
            scale += own_scale;
        }
        let plane = Plane {
            omega_0: data.omega[lines.start],
            step_s,
        };
        Self::of_reduced(&sum, (inputs, order), (scale, plane))
    }

    /// The denominators of reduced normal equations `M` of the coefficients `A_0` to `A_n`, square matrices of the number of inputs, made
    /// from numbers of a scale.
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
        let tables: Vec<Result<Table, IdentifyError>> = rising_orders(self.order)
            .into_par_iter()
            .map(|order| Ok((order, self.poles(order)?)))
            .collect();
        tables.into_iter().collect()
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
        // With A_0 = I the reversed polynomial is monic: its companion matrix has the eigenvalues 1/z.
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
    /// The branch of the logarithm that puts the pole around the band: the gap of the circle is shared by both sides.
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

/// `1/Π |z − z_r|²` at every line over the known poles among the lines: the noise of an equation is that of its line times the
/// denominator (Sanathanan and Koerner 1963, IEEE Trans. Automatic Control 8(1)).
fn course(omega: &[f64], step_s: f64, known: &[Complex64]) -> Vec<f64> {
    let z = |s: Complex64| ((s - Complex64::new(0.0, omega[0])) * step_s).exp();
    let inside = |pole: &&Complex64| pole.im > omega[0] && pole.im < omega[omega.len() - 1];
    let known: Vec<Complex64> = known.iter().filter(inside).map(|pole| z(*pole)).collect();
    let at = |w: &f64| {
        let own = z(Complex64::new(0.0, *w));
        let factors = known.iter().map(|pole| (own - pole).norm_sqr());
        factors.product::<f64>().recip()
    };
    omega.iter().map(at).collect()
}

/// Cholesky factor with the least ridge that gives one; `scale` is that of the numbers that the matrix was made from.
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

/// Participation factors of a pole: the left vector of `A(z)` for its smallest singular value, `Lᵀ A(z) = 0`.
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

/// `T − Sᴴ R⁻¹ S` of one output, and the mean of the diagonal of T.
fn reduced(
    data: &Receptances,
    output: &[(usize, usize)],
    (plan, lines, (course, model), order): (&ComplexPlan, &Range<usize>, (&[f64], f64), usize),
) -> Result<(ComplexMatrix, f64), LinalgError> {
    let m = output.len();
    let functions: Vec<&[Complex64]> = output
        .iter()
        .map(|(_, f)| &data.values[*f][lines.clone()])
        .collect();
    // One weight per line and output: the mean precision of its functions, which no resonance exceeds by more than the error of the model allows.
    let weight = |k: usize| {
        let power = functions.iter().map(|h| h[k].norm_sqr()).sum::<f64>() / m as f64;
        let precision =
            |(_, f): &(usize, usize)| 1.0 / (data.variance[*f][lines.start + k] + model * power);
        course[k] * output.iter().map(precision).sum::<f64>() / m as f64
    };
    let weights: Vec<f64> = (0..lines.len()).map(weight).collect();
    let mut scratch = plan.scratch();
    let mut lags = |value: &dyn Fn(usize) -> Complex64| {
        let mut line: Vec<Complex64> = (0..lines.len()).map(|k| weights[k] * value(k)).collect();
        line.resize(plan.len(), Complex64::ZERO);
        plan.run(&mut line, &mut scratch);
        line
    };
    let circle = plan.len();
    // Entry (i, j) of a Toeplitz block is the transform at j - i.
    let at = |lags: &[Complex64], i: usize, j: usize| lags[(circle + j - i) % circle];
    let plain = lags(&|_| Complex64::ONE);
    let r = linalg::complex_matrix(order + 1, order + 1, |i, j| at(&plain, i, j));
    let s_lags: Vec<Vec<Complex64>> = functions.iter().map(|h| lags(&|k| h[k])).collect();
    let s = linalg::complex_matrix(order + 1, (order + 1) * m, |i, column| {
        at(&s_lags[column % m], i, column / m)
    });
    let mut t_lags = Vec::with_capacity(m * m);
    for p in &functions {
        for q in &functions {
            t_lags.push(lags(&|k| p[k].conj() * q[k]));
        }
    }
    let t = linalg::complex_matrix((order + 1) * m, (order + 1) * m, |row, column| {
        at(&t_lags[(row % m) * m + column % m], row / m, column / m)
    });
    let half = linalg::solve_lower(&factor(&r, plain[0].re)?, &s);
    let scale = (0..m).map(|p| t[(p, p)].re).sum::<f64>() / m as f64;
    Ok((t - half.adjoint() * &half, scale))
}
