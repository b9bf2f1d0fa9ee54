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

use serde::{Deserialize, Serialize};

mod discrete;
mod fraction;
mod modes;
mod problem;

use modes::Modes;
use problem::{Problem, Rounded};

/// Orders of the study of numerical stability.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StabilityPlan {
    /// Highest order, from 2 in steps of 2.
    pub highest_order: usize,
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
pub struct StabilityCurve {
    /// Its name in the table above.
    pub method: String,
    /// In rising order.
    pub points: Vec<StabilityPoint>,
}

/// All methods.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stability {
    /// As in the table above.
    #[serde(rename = "courses")]
    pub curves: Vec<StabilityCurve>,
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
        let curve = |(name, method): &Method| {
            let orders = (2..=self.highest_order).step_by(2);
            StabilityCurve {
                method: (*name).to_owned(),
                points: orders.map(|order| point(order, *method)).collect(),
            }
        };
        Stability {
            curves: METHODS.iter().map(curve).collect(),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_has_the_poles_of_a_low_order() {
        for curve in (StabilityPlan { highest_order: 4 }).run().curves {
            let first = curve.points[0];
            let error = first.error.unwrap();
            assert!(error < 1e-6, "{}: {error:e}", curve.method);
            assert!(first.condition >= 1.0);
            let single = first.error_f32_matrix.unwrap();
            assert!(single > error, "{}: {single:e}", curve.method);
        }
    }

    /// Richardson and Formenti (1982): powers lose the digits that orthogonal polynomials keep.
    #[test]
    fn power_polynomials_lose_the_poles_that_orthogonal_ones_keep() {
        let all = StabilityPlan { highest_order: 20 }.run();
        let last = |name: &str| {
            let curve = all
                .curves
                .iter()
                .find(|curve| curve.method == name)
                .unwrap();
            curve.points[curve.points.len() - 1]
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
