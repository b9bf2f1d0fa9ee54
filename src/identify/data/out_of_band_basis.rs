//! What lies outside a window of lines, as functions of frequency that every function may hold in
//! any mixture.
//!
//! Constant and slope follow what is farther from the window than the window is long. Where the
//! window ends with the data, modes outside can be as near as they like and nobody sees them: poles
//! that crowd towards that end follow them, at distances from the end that double from line to line
//! and as far from the axis (rational approximation with clustered poles converges exponentially in
//! their number: Gopal and Trefethen 2019, SIAM J. Numer. Anal. 57(5)).

use std::ops::Range;

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix, ThinQr};

/// Nearest pole, lines beyond the end.
const NEAREST: f64 = 1.5;
/// Ratio of distances.
const RATIO: f64 = 2.0;
/// Farthest pole, in lengths of the window.
const FARTHEST: f64 = 1.0;

/// Columns of every window: constant and slope.
pub(in crate::identify) const EVERYWHERE: usize = 2;
/// Lines for each pole, fewest.
const FEWEST_LINES_EACH: usize = 3;

/// What is known of the modes outside the lines of a band.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) enum Outside {
    /// Nothing: they may lie anywhere.
    Anywhere,
    /// What they put into the lines goes along these courses; none where the data show no such
    /// modes.
    Courses(Vec<Course>),
}

/// What modes outside put into the lines, as far as all functions share it.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct Course {
    /// One value per line.
    pub values: Vec<Complex64>,
    /// How much of it each function holds, over its noise: a vector of length 1.
    pub shares: Vec<Complex64>,
}

/// The background of a window.
#[derive(Clone, Debug)]
pub(in crate::identify) struct Background<'a> {
    poles: Vec<Complex64>,
    /// Courses on the lines of the window.
    courses: Vec<&'a [Complex64]>,
}

impl<'a> Background<'a> {
    /// For lines of a band that has `omega` in all. What lies outside counts where the window ends
    /// with the band.
    pub fn new(omega: &[f64], lines: &Range<usize>, outside: &'a Outside) -> Self {
        let (below, above) = (lines.start == 0, lines.end == omega.len());
        match outside {
            Outside::Anywhere => Self {
                poles: clustered(omega, lines, (below, above)),
                courses: Vec::new(),
            },
            Outside::Courses(courses) => {
                let own = courses.iter().filter(|_| below || above);
                Self {
                    poles: Vec::new(),
                    courses: own.map(|course| &course.values[lines.clone()]).collect(),
                }
            }
        }
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        EVERYWHERE + self.poles.len() + self.courses.len()
    }

    /// Column at a line of the window.
    pub fn value(&self, column: usize, omega: &[f64], k: usize) -> Complex64 {
        let (first, last) = (omega[0], omega[omega.len() - 1]);
        match column {
            0 => Complex64::ONE,
            1 => Complex64::from((2.0 * omega[k] - first - last) / (last - first)),
            _ => match self.poles.get(column - EVERYWHERE) {
                Some(pole) => pole.re.abs() / (Complex64::new(0.0, omega[k]) - pole),
                None => self.courses[column - EVERYWHERE - self.poles.len()][k],
            },
        }
    }

    /// Orthonormal columns over a course of noise.
    pub fn basis(&self, omega: &[f64], course: &[f64]) -> ComplexMatrix {
        let columns = linalg::complex_matrix(omega.len(), self.columns(), |k, c| {
            self.value(c, omega, k) / course[k]
        });
        ThinQr::or_not_a_number(&columns).q
    }
}

/// Poles that crowd towards the ends of a window that are the band's.
fn clustered(omega: &[f64], lines: &Range<usize>, (below, above): (bool, bool)) -> Vec<Complex64> {
    let step = omega[1] - omega[0];
    // Few lines cannot tell many poles.
    let most = lines.len() / FEWEST_LINES_EACH;
    let length = FARTHEST * lines.len() as f64 * step;
    let mut poles = Vec::new();
    let mut distance = NEAREST * step;
    while distance < length && poles.len() + EVERYWHERE <= most {
        if below {
            poles.push(Complex64::new(-distance, omega[0] - distance));
        }
        if above {
            poles.push(Complex64::new(-distance, omega[omega.len() - 1] + distance));
        }
        distance *= RATIO;
    }
    poles
}
