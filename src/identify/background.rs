//! What lies outside a window of lines, as functions of frequency that every function may hold in any mixture.
//!
//! Constant and slope follow what is farther from the window than the window is long. Where the window ends with the data, modes
//! outside can be as near as they like and nobody sees them: poles that crowd towards that end follow them, at distances from the
//! end that double from line to line and as far from the axis (rational approximation with clustered poles converges
//! exponentially in their number: Gopal and Trefethen 2019, SIAM J. Numer. Anal. 57(5)).

use std::ops::Range;

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix};

/// Nearest pole, lines beyond the end.
const NEAREST: f64 = 1.5;
/// Ratio of distances.
const RATIO: f64 = 2.0;
/// Farthest pole, in lengths of the window.
const FARTHEST: f64 = 1.0;

/// Lines for each pole, fewest.
const FEWEST_LINES_EACH: usize = 3;

/// The background of a window.
#[derive(Clone, Debug)]
pub(super) struct Background {
    poles: Vec<Complex64>,
}

impl Background {
    /// For lines of a band that has `omega` in all, with poles for what is just outside of it or without.
    pub fn new(omega: &[f64], lines: &Range<usize>, outside: bool) -> Self {
        let step = omega[1] - omega[0];
        // Few lines cannot tell many poles.
        let most = lines.len() / FEWEST_LINES_EACH;
        let length = FARTHEST * lines.len() as f64 * step;
        let mut poles = Vec::new();
        let mut distance = NEAREST * step;
        while outside && distance < length && poles.len() + 2 <= most {
            if lines.start == 0 {
                poles.push(Complex64::new(-distance, omega[0] - distance));
            }
            if lines.end == omega.len() {
                poles.push(Complex64::new(-distance, omega[omega.len() - 1] + distance));
            }
            distance *= RATIO;
        }
        Self { poles }
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        2 + self.poles.len()
    }

    /// Column at a line of the window.
    pub fn value(&self, column: usize, omega: &[f64], k: usize) -> Complex64 {
        let (first, last) = (omega[0], omega[omega.len() - 1]);
        match column {
            0 => Complex64::ONE,
            1 => Complex64::from((2.0 * omega[k] - first - last) / (last - first)),
            _ => {
                let pole = self.poles[column - 2];
                pole.re.abs() / (Complex64::new(0.0, omega[k]) - pole)
            }
        }
    }

    /// Orthonormal columns over a course of noise.
    pub fn basis(&self, omega: &[f64], course: &[f64]) -> ComplexMatrix {
        let columns = linalg::complex_matrix(omega.len(), self.columns(), |k, c| {
            self.value(c, omega, k) / course[k]
        });
        linalg::thin_qr(&columns).q
    }
}
