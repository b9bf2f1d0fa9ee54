//! One pole is fitted to a mobility around one resonance, with its standard deviations.

use std::ops::Range;

use num_complex::Complex64;

use crate::linalg;

/// Gauss-Newton turns at most; from the first estimate three or four are enough at 20 dB.
const TURNS: usize = 12;
/// A change of the pole that ends the turns, in half widths of the fitted lines.
const SETTLED: f64 = 1e-9;
/// Complex unknowns of the model.
const UNKNOWNS: usize = 4;

/// A single resonance of one function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LocalPole {
    /// Pole on the axis of the data (an added damping is in it), rad/s.
    pub lambda: Complex64,
    /// Variance of its imaginary part, (rad/s)².
    pub frequency_variance: f64,
    /// Residue of the mobility, m/(N s²).
    pub residue: Complex64,
    /// Variance of its phase, rad².
    pub phase_variance: f64,
    /// Other modes at the resonance over the maximum of the peak.
    pub background: f64,
}

/// Lines, values and variances around a resonance.
pub(super) struct ResonanceLines<'a> {
    pub omega: &'a [f64],
    pub values: &'a [Complex64],
    pub variance: &'a [f64],
}

impl<'a> ResonanceLines<'a> {
    /// The part of whole functions in a range of lines.
    pub fn of(
        lines: Range<usize>,
        omega: &'a [f64],
        values: &'a [Complex64],
        variance: &'a [f64],
    ) -> Self {
        Self {
            omega: &omega[lines.clone()],
            values: &values[lines.clone()],
            variance: &variance[lines],
        }
    }

    /// Least squares of `Y = R/(iω − λ) + C + D iω`: other modes are a constant and a slope.
    ///
    /// The first λ comes from the equation times `(iω − λ)`, which is linear in it; Gauss-Newton
    /// then minimises the error of Y itself. Variances follow from the stated ones to first order,
    /// `var(λ) = Σ|g|²v/(|R|²(Σ|g|²)²)` with `g` the part of `1/(iω − λ)²` that the other columns
    /// do not explain, and are raised where the misfit is larger than they say. `None` when the
    /// lines are too few, or the pole leaves them or is not stable.
    pub fn fit(&self) -> Option<LocalPole> {
        let n = self.omega.len();
        if n < 2 * UNKNOWNS {
            return None;
        }
        let centre = 0.5 * (self.omega[0] + self.omega[n - 1]);
        let scale = 0.5 * (self.omega[n - 1] - self.omega[0]);
        let z: Vec<Complex64> = (self.omega.iter())
            .map(|w| Complex64::new(0.0, (w - centre) / scale))
            .collect();
        let mut pole = first_pole(&z, self.values);
        for _ in 0..TURNS {
            let x = solve(&columns(&z, pole, &[0, 1, 2, 3]), self.values);
            let change = x[3] / x[0];
            pole += change;
            if !within(pole) || change.norm() < SETTLED {
                break;
            }
        }
        within(pole).then(|| self.result(&z, pole, centre, scale))
    }

    fn result(&self, z: &[Complex64], pole: Complex64, centre: f64, scale: f64) -> LocalPole {
        let x = solve(&columns(z, pole, &[0, 1, 2]), self.values);
        let residue = x[0];
        let misfit = norm_sqr(&residual(z, pole, &[0, 1, 2], self.values));
        let mean = self.variance.iter().sum::<f64>() / z.len() as f64;
        let found = misfit / (z.len() - UNKNOWNS) as f64;
        let raise = if found > mean { found / mean } else { 1.0 };
        let spread = |term: usize, others: &[usize]| {
            let column: Vec<Complex64> = z.iter().map(|z| column(*z, pole, term)).collect();
            let g = residual(z, pole, others, &column);
            let pairs = g.iter().zip(self.variance);
            let noise: f64 = match raise.is_finite() {
                true => pairs.map(|(g, v)| g.norm_sqr() * v * raise).sum(),
                false => pairs.map(|(g, _)| g.norm_sqr() * found).sum(),
            };
            // Half of a circular variance lies along one direction.
            0.5 * noise / (norm_sqr(&g).powi(2) * residue.norm_sqr())
        };
        let around = x[1] + x[2] * Complex64::new(0.0, pole.im);
        LocalPole {
            lambda: scale * pole + Complex64::new(0.0, centre),
            frequency_variance: scale * scale * spread(3, &[0, 1, 2]),
            residue: scale * residue,
            phase_variance: spread(0, &[1, 2, 3]),
            background: around.norm() * pole.re.abs() / residue.norm(),
        }
    }
}

/// Stable and inside the lines.
fn within(pole: Complex64) -> bool {
    pole.re < 0.0 && pole.re > -1.0 && pole.im.abs() < 1.0
}

/// λ of `zY = λY + c₀ + c₁z + c₂z²`.
fn first_pole(z: &[Complex64], values: &[Complex64]) -> Complex64 {
    let columns = linalg::complex_matrix(z.len(), UNKNOWNS, |i, j| match j {
        0 => values[i],
        _ => z[i].powi(j as i32 - 1),
    });
    let right: Vec<Complex64> = z.iter().zip(values).map(|(z, y)| z * y).collect();
    solve(&columns, &right)[0]
}

/// The functions of the model: `1/(z − p)`, 1, `z`, and the derivative `1/(z − p)²`.
fn column(z: Complex64, pole: Complex64, which: usize) -> Complex64 {
    match which {
        0 => 1.0 / (z - pole),
        1 => Complex64::ONE,
        2 => z,
        _ => 1.0 / ((z - pole) * (z - pole)),
    }
}

fn columns(z: &[Complex64], pole: Complex64, which: &[usize]) -> linalg::ComplexMatrix {
    linalg::complex_matrix(z.len(), which.len(), |i, j| column(z[i], pole, which[j]))
}

fn solve(columns: &linalg::ComplexMatrix, right: &[Complex64]) -> Vec<Complex64> {
    let right = linalg::complex_matrix(right.len(), 1, |i, _| right[i]);
    let x = linalg::least_squares(columns, &right)
        .unwrap_or_else(|_| linalg::not_a_number(columns.ncols(), 1));
    (0..columns.ncols()).map(|j| x[(j, 0)]).collect()
}

/// The residual of a fit of some columns.
fn residual(
    z: &[Complex64],
    pole: Complex64,
    which: &[usize],
    right: &[Complex64],
) -> Vec<Complex64> {
    let x = solve(&columns(z, pole, which), right);
    let explained = |z: &Complex64| -> Complex64 {
        let terms = which.iter().zip(&x);
        terms.map(|(j, x)| x * column(*z, pole, *j)).sum()
    };
    z.iter().zip(right).map(|(z, y)| y - explained(z)).collect()
}

fn norm_sqr(values: &[Complex64]) -> f64 {
    values.iter().map(Complex64::norm_sqr).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    const LAMBDA: Complex64 = Complex64::new(-3.0, 500.0);
    const RESIDUE: Complex64 = Complex64::new(1.2, 0.4);

    fn axis() -> Vec<f64> {
        (0..31).map(|k| 491.0 + 0.6 * f64::from(k)).collect()
    }

    fn value(omega: f64) -> Complex64 {
        let s = Complex64::new(0.0, omega);
        RESIDUE / (s - LAMBDA) + Complex64::new(0.03, -0.05) + 1e-4 * s
    }

    #[test]
    fn one_pole_with_its_surroundings_is_found_exactly() {
        let omega = axis();
        let values: Vec<Complex64> = omega.iter().map(|w| value(*w)).collect();
        let window = ResonanceLines {
            omega: &omega,
            values: &values,
            variance: &vec![0.0; 31],
        };
        let fit = window.fit().unwrap();
        assert!((fit.lambda - LAMBDA).norm() < 1e-8, "{fit:?}");
        assert!((fit.residue - RESIDUE).norm() < 1e-8);
        let around = Complex64::new(0.03, -0.05) + 1e-4 * Complex64::new(0.0, 500.0);
        assert!((fit.background - around.norm() * 3.0 / RESIDUE.norm()).abs() < 1e-7);
    }

    /// 400 draws know a variance to 7 % (one standard deviation), so 4.2 of those are 30 %.
    #[test]
    fn stated_variances_are_those_of_the_scatter() {
        let omega = axis();
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let (mut frequency, mut phase, mut stated) = (0.0, 0.0, (0.0, 0.0));
        let v = |omega: f64| 2e-5 * (1.0 + 20.0 * value(omega).norm_sqr());
        let variance: Vec<f64> = omega.iter().map(|w| v(*w)).collect();
        for _ in 0..400 {
            let mut noisy = |w: &f64| {
                let normal = Normal::new(0.0, (0.5 * v(*w)).sqrt()).unwrap();
                let noise = Complex64::new(normal.sample(&mut random), normal.sample(&mut random));
                value(*w) + noise
            };
            let values: Vec<Complex64> = omega.iter().map(&mut noisy).collect();
            let window = ResonanceLines {
                omega: &omega,
                values: &values,
                variance: &variance,
            };
            let fit = window.fit().unwrap();
            frequency += (fit.lambda.im - LAMBDA.im).powi(2) / 400.0;
            phase += (fit.residue / RESIDUE).arg().powi(2) / 400.0;
            stated.0 += fit.frequency_variance / 400.0;
            stated.1 += fit.phase_variance / 400.0;
        }
        // A misfit above the stated noise raises the variance, never lowers it: a mean of a few
        // percent too much.
        assert!(
            (0.75..1.45).contains(&(stated.0 / frequency)),
            "{}",
            stated.0 / frequency
        );
        assert!(
            (0.75..1.45).contains(&(stated.1 / phase)),
            "{}",
            stated.1 / phase
        );
    }
}
