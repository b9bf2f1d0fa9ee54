//! The study of numerical stability computes the digits that a method loses in f64 and f32 as its
//! order rises.
//!
//! Half as many modes as the order are spread evenly over a band, so that the order is exactly that
//! of the data; without noise every error is rounding. The data of each method are of the form in
//! which its model is exact:
//!
//! | name | data | unknowns | matrix |
//! |---|---|---|---|
//! | `rfp, powers` | receptance at lines of the band | real coefficients of both polynomials in powers of `iω/ω_max` | normal equations |
//! | `rfp, orthogonal` | the same | those of polynomials orthonormal on the lines, the denominator's under `\|H\|²` | normal equations |
//! | `lsce` | samples of the impulse response | real coefficients of the recurrence | normal equations |
//! | `lscf` | z-transform of those samples at lines of the band | complex coefficients of the denominator, the numerator eliminated | normal equations |
//!
//! Digits lost are `log₁₀` of the condition number of the matrix. The error
//! of the poles is the largest distance of a true pole to the nearest found one over its half-power
//! bandwidth. It is given with all in f64, with the data rounded to f32, and with the data and the
//! matrix rounded to f32 before the solution in f64. A program that also solves in f32 loses at
//! least as many digits as the last.
//!
//! References: Richardson and Formenti (1982), IMAC 1 (orthogonal polynomials in place of powers);
//! Brown et al. (1979), SAE 790221; Guillaume et al. (2003), IMAC 21.

use std::f64::consts::TAU;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::linalg::{self, ComplexMatrix};

mod discrete;
mod fraction;

/// What is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StabilityPlan {
    /// Highest order, from 2 in steps of 2.
    pub highest_order: usize,
}

/// What was rounded to f32.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rounded {
    Nothing,
    Data,
    DataAndMatrix,
}

/// One method at one order.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StabilityPoint {
    /// Order, twice the modes.
    pub order: usize,
    /// Condition number of the matrix, limited to 1e17: larger numbers are round-off in f64.
    pub condition: f64,
    /// Largest error of a pole in half-power widths, all in f64; `None` where the matrix cannot be
    /// solved.
    pub error: Option<f64>,
    /// With the data rounded to f32.
    pub error_f32_data: Option<f64>,
    /// With data and matrix rounded to f32.
    pub error_f32_matrix: Option<f64>,
}

/// One method over its orders.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StabilityCourse {
    /// Its name in the table above.
    pub method: String,
    /// In rising order.
    pub points: Vec<StabilityPoint>,
}

/// All methods.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stability {
    /// As in the table above.
    pub courses: Vec<StabilityCourse>,
}

/// Band over which the modes are spread, Hz.
const BAND_HZ: (f64, f64) = (50.0, 450.0);
/// Highest line, and half the sampling rate.
const TOP_HZ: f64 = 500.0;
const DAMPING: f64 = 0.01;
const LINES: usize = 400;
const SAMPLES: usize = 1200;
/// Condition numbers beyond this are round-off in f64.
const MAX_CONDITION: f64 = 1e17;

/// Poles of a solution, rad/s; `None` where it has none.
type Poles = dyn Fn(&[Complex64]) -> Option<Vec<Complex64>>;

/// Normal equations of one method: matrix, right-hand side, and the poles of a solution.
struct Problem {
    matrix: ComplexMatrix,
    right: Vec<Complex64>,
    poles: Box<Poles>,
}

/// A method by its name.
type Method = (&'static str, fn(&Modes, Rounded) -> Problem);

const METHODS: [Method; 4] = [
    ("rfp, powers", fraction::powers),
    ("rfp, orthogonal", fraction::orthogonal),
    ("lsce", discrete::exponentials),
    ("lscf", discrete::complex_frequency),
];

impl StabilityPlan {
    /// All methods at all orders.
    pub fn run(&self) -> Stability {
        let course = |(name, method): &Method| {
            let orders = (2..=self.highest_order).step_by(2);
            StabilityCourse {
                method: (*name).to_owned(),
                points: orders.map(|order| point(order, *method)).collect(),
            }
        };
        Stability {
            courses: METHODS.iter().map(course).collect(),
        }
    }
}

impl StabilityPoint {
    /// `log₁₀` of the condition number.
    pub fn digits_lost(&self) -> f64 {
        self.condition.log10()
    }
}

fn point(order: usize, method: fn(&Modes, Rounded) -> Problem) -> StabilityPoint {
    let modes = Modes::new(order / 2);
    let error = |rounded: Rounded| {
        let problem = method(&modes, rounded);
        let poles = (problem.poles)(&problem.solved()?)?;
        Some(modes.error(&poles)).filter(|error| error.is_finite())
    };
    StabilityPoint {
        order,
        condition: method(&modes, Rounded::Nothing).condition(),
        error: error(Rounded::Nothing),
        error_f32_data: error(Rounded::Data),
        error_f32_matrix: error(Rounded::DataAndMatrix),
    }
}

impl Problem {
    fn new(
        mut matrix: ComplexMatrix,
        mut right: Vec<Complex64>,
        rounded: Rounded,
        poles: Box<Poles>,
    ) -> Self {
        if rounded == Rounded::DataAndMatrix {
            let (rows, columns) = (matrix.nrows(), matrix.ncols());
            matrix = linalg::complex_matrix(rows, columns, |i, j| single(matrix[(i, j)]));
            right.iter_mut().for_each(|value| *value = single(*value));
        }
        Self {
            matrix,
            right,
            poles,
        }
    }

    fn condition(&self) -> f64 {
        let Ok(values) = linalg::singular_values(&self.matrix) else {
            return MAX_CONDITION;
        };
        let (largest, least) = values.iter().fold((0.0, f64::INFINITY), |(a, b), value| {
            (f64::max(a, *value), f64::min(b, *value))
        });
        (largest / least).min(MAX_CONDITION)
    }

    fn solved(&self) -> Option<Vec<Complex64>> {
        let right = linalg::complex_matrix(self.right.len(), 1, |i, _| self.right[i]);
        let solution = linalg::least_squares(&self.matrix, &right).ok()?;
        let values: Vec<Complex64> = (0..solution.nrows()).map(|i| solution[(i, 0)]).collect();
        values
            .iter()
            .all(|value| value.is_finite())
            .then_some(values)
    }
}

fn single(value: Complex64) -> Complex64 {
    Complex64::new(f64::from(value.re as f32), f64::from(value.im as f32))
}

/// The modes of one order.
struct Modes {
    poles: Vec<Complex64>,
    residues: Vec<Complex64>,
}

impl Modes {
    fn new(count: usize) -> Self {
        let fraction = |r: usize| (r as f64 + 0.5) / count as f64;
        let pole = |r: usize| {
            let omega = TAU * (BAND_HZ.0 + fraction(r) * (BAND_HZ.1 - BAND_HZ.0));
            Complex64::new(-DAMPING * omega, omega * (1.0 - DAMPING * DAMPING).sqrt())
        };
        let poles: Vec<Complex64> = (0..count).map(pole).collect();
        // Driving-point residues, all modes of the same height at their peak.
        let residue = |lambda: &Complex64| Complex64::new(0.0, lambda.re / TAU);
        Self {
            residues: poles.iter().map(residue).collect(),
            poles,
        }
    }

    fn order(&self) -> usize {
        2 * self.poles.len()
    }

    /// Sum over modes and conjugates.
    fn sum(&self, term: impl Fn(Complex64, Complex64) -> Complex64) -> Complex64 {
        let pairs = self.poles.iter().zip(&self.residues);
        pairs
            .map(|(pole, a)| term(*pole, *a) + term(pole.conj(), a.conj()))
            .sum()
    }

    /// Largest distance of a pole to the nearest found one, half-power widths.
    fn error(&self, found: &[Complex64]) -> f64 {
        let of_pole = |pole: &Complex64| {
            let distances = found.iter().map(|found_pole| (found_pole - pole).norm());
            distances.fold(f64::INFINITY, f64::min) / (-2.0 * pole.re)
        };
        self.poles.iter().map(of_pole).fold(0.0, f64::max)
    }
}

/// Roots of `Σ c_j x^j` by its companion matrix; `None` where they cannot be computed.
fn roots(coefficients: &[Complex64]) -> Option<Vec<Complex64>> {
    let order = coefficients.len() - 1;
    let leading = coefficients[order];
    let companion = linalg::complex_matrix(order, order, |i, j| {
        let last = if i + 1 == order {
            -coefficients[j] / leading
        } else {
            Complex64::ZERO
        };
        let next = if j == i + 1 {
            Complex64::ONE
        } else {
            Complex64::ZERO
        };
        last + next
    });
    let finite = coefficients.iter().all(|c| (c / leading).is_finite());
    finite.then(|| linalg::complex_eigenvalues(&companion).ok())?
}

/// `AᴴA` and `Aᴴb`.
fn normal_equations(rows: &ComplexMatrix, right: &[Complex64]) -> (ComplexMatrix, Vec<Complex64>) {
    let right = linalg::complex_matrix(right.len(), 1, |i, _| right[i]);
    let products = rows.adjoint() * &right;
    let matrix = rows.adjoint() * rows;
    let products = (0..products.nrows()).map(|i| products[(i, 0)]).collect();
    (matrix, products)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_has_the_poles_of_a_low_order() {
        for course in (StabilityPlan { highest_order: 4 }).run().courses {
            let first = course.points[0];
            let error = first.error.unwrap();
            assert!(error < 1e-6, "{}: {error:e}", course.method);
            assert!(first.condition >= 1.0);
            let single = first.error_f32_matrix.unwrap();
            assert!(single > error, "{}: {single:e}", course.method);
        }
    }

    /// Richardson and Formenti (1982): powers lose the digits that orthogonal polynomials keep.
    #[test]
    fn power_polynomials_lose_the_poles_that_orthogonal_ones_keep() {
        let all = StabilityPlan { highest_order: 20 }.run();
        let last = |name: &str| {
            let course = all
                .courses
                .iter()
                .find(|course| course.method == name)
                .unwrap();
            course.points[course.points.len() - 1]
        };
        let (powers, orthogonal) = (last("rfp, powers"), last("rfp, orthogonal"));
        assert!(
            powers.condition > 1e6 * orthogonal.condition,
            "{powers:?} {orthogonal:?}"
        );
        assert!(powers.error.is_none_or(|error| error > 0.1));
        assert!(orthogonal.error.unwrap() < 1e-3, "{orthogonal:?}");
    }
}
