//! A mode whose natural frequency shifts between measurement runs.

use num_complex::Complex64;

use crate::identify::data::line_shape::LineShape;

/// Distance, half-power bandwidths, below which a pole may belong to a shifted mode.
pub(super) const MATCH_BANDWIDTHS: f64 = 1.0;
/// Step of a pole over the scatter below which it has converged.
const CONVERGED_SHIFT_OVER_SCATTER: f64 = 0.01;

/// One mode with an individual pole in every run.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct ShiftedMode {
    /// Mean of the runs, rad/s.
    pub lambda: Complex64,
    /// Standard deviation of the frequency between runs, rad/s.
    pub scatter: f64,
    /// Standard deviation of the decay rate at the mean, rad/s.
    pub decay_std: f64,
    /// Pole of each run less the mean, rad/s, shrunk by its variance.
    pub(super) shifts: Vec<Complex64>,
    /// Standard deviation of the frequency of each run by its noise, rad/s.
    pub(super) stds: Vec<f64>,
    /// Residue of each FRF, m/(N s).
    pub(super) residues: Vec<Complex64>,
}

impl ShiftedMode {
    /// Frequency of a run less the mean of all, and the sum of the squares of all.
    pub(super) fn centred_shift(&self, run: usize) -> (f64, f64) {
        let count = self.shifts.len() as f64;
        let mean = self.shifts.iter().map(|shift| shift.im).sum::<f64>() / count;
        let squares = self
            .shifts
            .iter()
            .map(|shift| (shift.im - mean).powi(2))
            .sum();
        (self.shifts[run].im - mean, squares)
    }

    /// Whether a pole lies in the resonance of the mode.
    pub(super) fn contains_pole(&self, lambda: Complex64) -> bool {
        (self.lambda.im - lambda.im).abs() < -2.0 * MATCH_BANDWIDTHS * self.lambda.re
    }

    /// Poles in each run.
    pub(super) fn poles(&self) -> Vec<Complex64> {
        self.shifts
            .iter()
            .map(|shift| self.lambda + shift)
            .collect()
    }

    /// Whether the step since `before` is below the limit.
    pub(super) fn is_converged(&self, before: &Self) -> bool {
        let near = |(now, then): (Complex64, Complex64)| {
            (now - then).norm() <= CONVERGED_SHIFT_OVER_SCATTER * self.scatter
        };
        self.poles().into_iter().zip(before.poles()).all(near)
    }

    /// Correction that aligns an FRF of a run from its individual pole to the mean, at one
    /// frequency, rad/s.
    pub(super) fn correction(
        &self,
        shape: LineShape,
        f: usize,
        run: usize,
        omega: f64,
    ) -> Complex64 {
        let pole = |lambda: Complex64| shape.pole(omega, lambda);
        let (a, lambda) = (self.residues[f], self.lambda);
        let run_pole = lambda + self.shifts[run];
        a * (pole(lambda) - pole(run_pole))
            + a.conj() * (pole(lambda.conj()) - pole(run_pole.conj()))
    }
}
