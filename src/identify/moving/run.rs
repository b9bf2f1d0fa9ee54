//! What one run says of a pole: a Gauss-Newton step from where it is, beside all else that is known there.

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix};

use super::pole;
use super::resonance::{Resonance, STILL};

/// Largest change of a decay rate over that of its frequency.
const STEEPEST: f64 = 0.5;

/// A straight line of decay over frequency.
pub(super) struct Line {
    pub middle: Complex64,
    pub slope: f64,
}

impl Line {
    /// Through poles, each by the weight of its run.
    pub fn through(poles: &[Complex64], steps: &[Step]) -> Self {
        let pairs = || poles.iter().zip(steps);
        let weights: f64 = steps.iter().map(|step| step.weight).sum();
        let middle = pairs().map(|(pole, step)| pole * step.weight);
        let middle = middle.sum::<Complex64>() / weights;
        let (mut cross, mut square) = (0.0, 0.0);
        for (pole, step) in pairs() {
            let from = pole - middle;
            cross += step.weight * from.re * from.im;
            square += step.weight * from.im * from.im;
        }
        // Shifts of rounding have no slope.
        let shifted = square > weights * (STILL * middle.re).powi(2);
        let slope = if shifted { cross / square } else { 0.0 };
        Self {
            middle,
            slope: slope.clamp(-STEEPEST, STEEPEST),
        }
    }

    pub fn at(&self, omega: f64) -> f64 {
        self.middle.re + self.slope * (omega - self.middle.im)
    }
}

/// The functions of a run around a resonance.
pub(super) struct Run<'a> {
    resonance: &'a Resonance<'a>,
    pub functions: &'a [usize],
    /// Orthonormal: background and other poles.
    others: ComplexMatrix,
    /// What those do not explain: lines × functions of the run.
    values: ComplexMatrix,
}

/// What functions say of a pole.
pub(super) struct Look {
    pub amplitudes: Vec<Complex64>,
    /// Of the course of the pole's derivative in what the pole leaves over.
    along: Vec<Complex64>,
    /// `|g|²` of that course.
    second: f64,
    /// `Σ|rest|²`.
    pub left: f64,
}

/// One Gauss-Newton step of a run.
pub(super) struct Step {
    pub change: Complex64,
    /// `Σ|A|²|g|²`: one over the variance of the change in noise of unit variance.
    pub weight: f64,
    pub look: Look,
}

impl Look {
    /// What the pole and the course of its derivative leave over.
    pub fn without_derivative(&self) -> f64 {
        let along: f64 = self.along.iter().map(Complex64::norm_sqr).sum();
        self.left - along / self.second
    }

    /// The change of the pole that some of the functions ask for, and its weight.
    pub fn change(&self, functions: impl Iterator<Item = usize>) -> (Complex64, f64) {
        let (mut change, mut squares) = (Complex64::ZERO, 0.0);
        for f in functions {
            change += self.amplitudes[f].conj() * self.along[f];
            squares += self.amplitudes[f].norm_sqr();
        }
        let weight = squares * self.second;
        if weight > 0.0 {
            (change / weight, weight)
        } else {
            (Complex64::ZERO, 0.0)
        }
    }
}

impl<'a> Run<'a> {
    pub fn new(
        resonance: &'a Resonance<'a>,
        (values, functions): (&ComplexMatrix, &'a [usize]),
        beside: &[Complex64],
    ) -> Self {
        let others = resonance.basis(beside);
        let values = linalg::complex_matrix(values.nrows(), functions.len(), |k, place| {
            values[(k, functions[place])]
        });
        Self {
            values: without(&others, &values),
            others,
            resonance,
            functions,
        }
    }

    /// From a pole towards the nearest that fits the run.
    pub fn step(&self, lambda: Complex64) -> Step {
        let look = self.look(lambda);
        let (change, weight) = look.change(0..self.functions.len());
        Step {
            change,
            weight,
            look,
        }
    }

    pub fn look(&self, lambda: Complex64) -> Look {
        let Resonance { omega, profile, .. } = self.resonance;
        let course = |power: i32| {
            let column = linalg::complex_matrix(omega.len(), 1, |k, _| {
                pole(omega[k], lambda).powi(power) / profile.course[k]
            });
            without(&self.others, &column)
        };
        let own = course(1);
        let norm = own.norm_l2();
        let own = linalg::complex_matrix(own.nrows(), 1, |k, _| own[(k, 0)] / norm);
        let second = without(&own, &course(2));
        let first = own.adjoint() * &self.values;
        let along = second.adjoint() * &self.values;
        let places = 0..self.functions.len();
        Look {
            amplitudes: places
                .clone()
                .map(|place| first[(0, place)] / norm)
                .collect(),
            along: places.map(|place| along[(0, place)]).collect(),
            second: second.squared_norm_l2(),
            left: self.values.squared_norm_l2() - first.squared_norm_l2(),
        }
    }
}

/// Columns less what an orthonormal basis explains of them.
pub(super) fn without(basis: &ComplexMatrix, columns: &ComplexMatrix) -> ComplexMatrix {
    columns - basis * (basis.adjoint() * columns)
}
