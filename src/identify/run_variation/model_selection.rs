//! Model selection for run variation: the information criterion that compares common with
//! individual poles, and the scatter between runs.

use crate::identify::run_variation::pole_shift::Fitted;

/// Maximum number of bisections for the variance between runs.
const MAX_BISECTIONS: usize = 60;

/// Bayesian information criterion of models of the same runs.
pub(super) struct Criterion {
    /// Variance of the noise.
    pub noise: f64,
    /// Number of measured real values.
    pub numbers: f64,
    pub functions: usize,
    pub runs: usize,
}

impl Criterion {
    pub fn of(&self, residual_energy: f64, unknowns: usize) -> f64 {
        2.0 * residual_energy / self.noise + unknowns as f64 * self.numbers.ln()
    }

    /// Criterion of individual poles: residues, frequencies, and a straight line of the decay rates
    /// for each pole.
    pub fn of_runs(&self, fitted: &Fitted) -> f64 {
        let unknowns = 2 * self.functions + self.runs + 2;
        self.of(fitted.residual_energy, fitted.tracks.len() * unknowns)
    }

    /// Criterion of common poles: free residues in each FRF, and the poles.
    pub fn of_common_poles(&self, residual_energy: f64, count: usize) -> f64 {
        self.of(residual_energy, 2 * count * (self.functions + 1))
    }
}

/// Variance between runs, in addition to that of each run, at which the weighted scatter equals its
/// expected value (Paule and Mandel 1982); 0 where the variances of the runs explain their scatter.
pub(super) fn between_runs(values: &[f64], variances: &[f64]) -> f64 {
    let free = values.len() as f64 - 1.0;
    let scatter = |between: f64| {
        let weights: Vec<f64> = variances.iter().map(|v| 1.0 / (between + v)).collect();
        let pairs = || values.iter().zip(&weights);
        let mean = pairs().map(|(value, w)| w * value).sum::<f64>() / weights.iter().sum::<f64>();
        pairs()
            .map(|(value, w)| w * (value - mean).powi(2))
            .sum::<f64>()
    };
    if scatter(0.0) <= free {
        return 0.0;
    }
    // The scatter falls with the variance, to at most 1 at the variance of the values themselves.
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let (mut lo, mut hi) = (0.0, values.iter().map(|value| (value - mean).powi(2)).sum());
    for _ in 0..MAX_BISECTIONS {
        let middle = 0.5 * (lo + hi);
        if scatter(middle) > free {
            lo = middle;
        } else {
            hi = middle;
        }
    }
    0.5 * (lo + hi)
}

#[cfg(test)]
mod tests {
    use crate::identify::run_variation::model_selection::*;

    #[test]
    fn the_variance_between_runs_excludes_that_of_each_run() {
        // Equal variances: the sample variance less that of each.
        let values = [1.0, 3.0, 5.0, 7.0];
        let sample = 20.0 / 3.0;
        assert!((between_runs(&values, &[0.5; 4]) - (sample - 0.5)).abs() < 1e-12);
        assert!(between_runs(&values, &[10.0; 4]).abs() < 1e-12);
        // However unequal, where they are far less than the scatter.
        let unequal = between_runs(&values, &[1e-3, 1e-9, 1e-6, 1e-9]);
        assert!((unequal - sample).abs() < 1e-2, "{unequal}");
        // An undetermined run scatters as expected: the other runs have one degree of freedom too
        // many.
        let unknown = between_runs(&[1.0, 3.0, 5.0, 7.0, 1e3], &[0.5, 0.5, 0.5, 0.5, 1e12]);
        assert!((unknown - (20.0 / 4.0 - 0.5)).abs() < 1e-2, "{unknown}");
    }
}
