//! The modes of one order spread evenly over a band.

use std::f64::consts::TAU;

use num_complex::Complex64;

/// Band over which the modes are spread, Hz.
const BAND_HZ: (f64, f64) = (50.0, 450.0);
/// Highest line, and half the sampling rate.
pub(super) const TOP_HZ: f64 = 500.0;
const DAMPING: f64 = 0.01;
pub(super) const LINES: usize = 400;
pub(super) const SAMPLES: usize = 1200;

/// The modes of one order.
pub struct Modes {
    poles: Vec<Complex64>,
    residues: Vec<Complex64>,
}

impl Modes {
    pub(super) fn new(count: usize) -> Self {
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

    pub(super) fn order(&self) -> usize {
        2 * self.poles.len()
    }

    /// Sum over modes and conjugates.
    pub(super) fn sum(&self, term: impl Fn(Complex64, Complex64) -> Complex64) -> Complex64 {
        let pairs = self.poles.iter().zip(&self.residues);
        pairs
            .map(|(pole, a)| term(*pole, *a) + term(pole.conj(), a.conj()))
            .sum()
    }

    /// Largest distance of a pole to the nearest found one, half-power widths.
    pub(super) fn error(&self, found: &[Complex64]) -> f64 {
        let of_pole = |pole: &Complex64| {
            let distances = found.iter().map(|found_pole| (found_pole - pole).norm());
            distances.fold(f64::INFINITY, f64::min) / (-2.0 * pole.re)
        };
        self.poles.iter().map(of_pole).fold(0.0, f64::max)
    }
}
