//! The noise of a window as the fit weights it: a level per function and a course over the lines.

use std::ops::Range;

use super::receptance::Receptances;

/// Variance of function f at line k of the window: `level_f² course_k²`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Profile {
    /// Root of the mean variance of each function, m/N.
    pub level: Vec<f64>,
    /// Relative course over the lines of the window; its square has the mean 1.
    pub course: Vec<f64>,
}

impl Profile {
    /// Of the lines of a window.
    pub fn new(data: &Receptances, lines: Range<usize>) -> Self {
        let level: Vec<f64> = (0..data.functions())
            .map(|f| data.mean_variance(f, lines.clone()).sqrt())
            .collect();
        let mut squares = vec![0.0; lines.len()];
        for (variance, level) in data.variance.iter().zip(&level) {
            for (sum, v) in squares.iter_mut().zip(&variance[lines.clone()]) {
                *sum += v / (level * level * data.functions() as f64);
            }
        }
        let course = squares.into_iter().map(f64::sqrt).collect();
        Self { level, course }
    }
}
