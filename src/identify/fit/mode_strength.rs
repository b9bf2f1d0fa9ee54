//! The strength of the modes of a pole is a likelihood ratio: twice the log-likelihood that the
//! fit loses without them, over the noise of all outputs.
//!
//! Output o has the shape values ψ_o of the modes of a pole, with covariance V_o. Removing a
//! combination a of the modes reduces the log-likelihood by `Σ_o |aᴴψ_o|²/(aᴴV_o a)`, twice which
//! is the strength of a. Independent combinations are the eigenvectors of the pencil `Σ w ψψᴴ`, `Σ
//! w V`; the weights `w = det(V)^(−1/m)` give outputs of different noise the same weight, whatever
//! the basis of the modes.

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix, sort_ascending_by};

/// Shapes of the modes of a pole, by outputs of one covariance.
pub(in crate::identify) struct Strength {
    modes: usize,
    /// Covariance, and shapes of the modes by output.
    outputs: Vec<(ComplexMatrix, ComplexMatrix)>,
    /// Strength of all modes together, `Σ 2 ψᴴ V⁻¹ ψ`, and the largest of its terms.
    sum: f64,
    largest: f64,
}

/// The independent combinations of the modes of a pole, the weakest first.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::identify) struct Strengths {
    /// Strength of each; none where they are not estimated.
    pub values: Vec<f64>,
    /// Factors of the modes in each combination.
    pub combinations: Vec<Vec<Complex64>>,
    /// Strength of all modes at the strongest output.
    pub largest: f64,
}

impl Strength {
    /// Of a pole of `modes` modes, before any output is added.
    pub fn none(modes: usize) -> Self {
        Self {
            modes,
            outputs: Vec::new(),
            sum: 0.0,
            largest: 0.0,
        }
    }

    /// Adds outputs of one covariance with their shapes, modes × outputs.
    pub fn add(&mut self, covariance: ComplexMatrix, shapes: ComplexMatrix) {
        let Some(precision) = linalg::inverse_hermitian(&covariance) else {
            return;
        };
        let whitened = precision * &shapes;
        for o in 0..shapes.ncols() {
            let value: Complex64 = (0..self.modes)
                .map(|a| shapes[(a, o)].conj() * whitened[(a, o)])
                .sum();
            self.sum += 2.0 * value.re;
            self.largest = self.largest.max(2.0 * value.re);
        }
        self.outputs.push((covariance, shapes));
    }

    /// Adds outputs of one variance with their shapes, for a single mode.
    pub fn add_single(&mut self, variance: f64, shapes: impl Iterator<Item = Complex64>) {
        if !(variance > 0.0 && variance.is_finite()) {
            return;
        }
        for shape in shapes {
            let value = 2.0 * (shape.norm_sqr() / variance);
            self.sum += value;
            self.largest = self.largest.max(value);
        }
    }

    /// Adds the outputs of another sum.
    pub fn merge(&mut self, other: Self) {
        self.outputs.extend(other.outputs);
        self.sum += other.sum;
        self.largest = self.largest.max(other.largest);
    }

    /// The strengths with their combinations.
    pub fn values(&self) -> Strengths {
        let single = Strengths {
            values: vec![self.sum],
            combinations: vec![vec![Complex64::ONE]],
            largest: self.largest,
        };
        let several = || self.combined_strengths().unwrap_or_default();
        if self.modes == 1 {
            single
        } else {
            Strengths {
                largest: self.largest,
                ..several()
            }
        }
    }

    fn combined_strengths(&self) -> Option<Strengths> {
        let zero = || linalg::complex_matrix(self.modes, self.modes, |_, _| Complex64::ZERO);
        let (mut power, mut noise) = (zero(), zero());
        for (covariance, shapes) in &self.outputs {
            let Some(weight) = equal_weight(covariance) else {
                continue;
            };
            power += (shapes * shapes.adjoint()) * weight;
            noise += covariance * (weight * shapes.ncols() as f64);
        }
        // Columns of L⁻ᴴ U are the combinations a, those of L U their independent components.
        let lower = linalg::cholesky(&noise).ok()?;
        let half = linalg::solve_lower(&lower, &power);
        let whitened = linalg::solve_lower(&lower, &half.adjoint().to_owned());
        let svd = linalg::singular_vectors(&whitened).ok()?;
        let tests = linalg::solve_lower_adjoint(&lower, &svd.left);
        let components = &lower * &svd.left;
        let column = |matrix: &ComplexMatrix, k: usize| -> Vec<Complex64> {
            (0..self.modes).map(|i| matrix[(i, k)]).collect()
        };
        let mut order: Vec<(f64, Vec<Complex64>)> = (0..self.modes)
            .map(|k| {
                (
                    self.combination_strength(&column(&tests, k)),
                    column(&components, k),
                )
            })
            .collect();
        sort_ascending_by(&mut order, |entry| entry.0);
        let (values, combinations) = order.into_iter().unzip();
        Some(Strengths {
            values,
            combinations,
            largest: 0.0,
        })
    }

    /// `Σ 2 |aᴴψ|²/(aᴴVa)`.
    fn combination_strength(&self, a: &[Complex64]) -> f64 {
        let row = linalg::complex_matrix(1, a.len(), |_, i| a[i].conj());
        let of = |(covariance, shapes): &(ComplexMatrix, ComplexMatrix)| {
            let noise = (&row * covariance * row.adjoint())[(0, 0)].re;
            2.0 * (&row * shapes).squared_norm_l2() / noise
        };
        self.outputs.iter().map(of).sum()
    }
}

/// `det(V)^(−1/m)`.
fn equal_weight(covariance: &ComplexMatrix) -> Option<f64> {
    let lower = linalg::cholesky(covariance).ok()?;
    let modes = lower.nrows();
    let log = (0..modes).map(|i| lower[(i, i)].re.ln()).sum::<f64>();
    Some((-2.0 * log / modes as f64).exp())
}

#[cfg(test)]
mod tests {
    use crate::identify::fit::mode_strength::*;

    /// Two modes at ten outputs, the second with alternating signs.
    fn shapes() -> ComplexMatrix {
        linalg::complex_matrix(2, 10, |mode, o| match mode {
            0 => Complex64::from(3.0),
            _ => Complex64::from(if o % 2 == 0 { 1.0 } else { -1.0 }),
        })
    }

    fn scaled_identity(scale: f64) -> ComplexMatrix {
        linalg::complex_matrix(2, 2, |i, j| {
            Complex64::from(if i == j { scale } else { 0.0 })
        })
    }

    #[test]
    fn outputs_of_high_noise_do_not_reduce_the_strength_of_the_others() {
        let mut strength = Strength::none(2);
        strength.add(scaled_identity(1.0), shapes());
        // Equal components of both modes, a hundredth of the noise.
        let noisy = linalg::complex_matrix(2, 10, |_, _| Complex64::from(100.0));
        strength.add(scaled_identity(1e8), noisy);
        let strengths = strength.values();
        // 2 Σ|ψ|²/V.
        for (value, expected) in strengths.values.iter().zip([20.0, 180.0]) {
            assert!((value / expected - 1.0).abs() < 1e-3, "{value} {expected}");
        }
        assert!((strengths.largest - 20.0).abs() < 1e-9);
        let [weakest, strongest] = &strengths.combinations[..] else {
            panic!("two combinations");
        };
        assert!(weakest[0].norm() < 1e-3 * weakest[1].norm());
        assert!(strongest[1].norm() < 1e-3 * strongest[0].norm());
    }

    #[test]
    fn strengths_do_not_depend_on_the_basis_of_the_modes() {
        let basis = linalg::complex_matrix(2, 2, |i, j| {
            Complex64::new([[2.0, 1.0], [-0.5, 3.0]][i][j], 0.25 * i as f64)
        });
        let mut strength = Strength::none(2);
        for scale in [1.0, 1e8] {
            let covariance = &basis * scaled_identity(scale) * basis.adjoint();
            strength.add(covariance, &basis * shapes());
        }
        for (value, expected) in strength.values().values.iter().zip([20.0, 180.0]) {
            assert!((value / expected - 1.0).abs() < 1e-6, "{value} {expected}");
        }
    }
}
