//! The noise of a window as the fit weights it: a level per function and a course over the lines.

use std::ops::Range;

use rayon::prelude::*;

use crate::identify::data::band_frfs::Receptances;

/// Lines whose sums stay in the nearest cache.
const LINES_AT_ONCE: usize = 1024;

/// Variance of function f at line k of the window: `level_f² course_k²`.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct Profile {
    /// Root of the mean variance of each function, m/N.
    pub level: Vec<f64>,
    /// Relative course over the lines of the window; its square has the mean 1.
    pub course: Vec<f64>,
}

impl Profile {
    /// Of the lines of a window.
    pub fn new(data: &Receptances, lines: Range<usize>) -> Self {
        let mean: Vec<f64> = (0..data.functions())
            .into_par_iter()
            .map(|f| data.mean_variance(f, lines.clone()))
            .collect();
        let mut course = vec![0.0; lines.len()];
        let pieces = course.par_chunks_mut(LINES_AT_ONCE).enumerate();
        pieces.for_each(|(number, sums)| {
            let first = lines.start + number * LINES_AT_ONCE;
            for (variance, mean) in data.variance.iter().zip(&mean) {
                let part = (mean * data.functions() as f64).recip();
                let variance = &variance[first..first + sums.len()];
                for (sum, v) in sums.iter_mut().zip(variance) {
                    *sum += v * part;
                }
            }
            sums.iter_mut().for_each(|sum| *sum = sum.sqrt());
        });
        let level = mean.into_iter().map(f64::sqrt).collect();
        Self { level, course }
    }
}
