//! The z-plane: frequency lines of a band on an arc of the unit circle, and poles back from it.

use num_complex::Complex64;

/// Fraction of the circle that the lines of the band take.
const BAND_ARC_FRACTION: f64 = 0.8;

/// Mapping `z = e^{(λ − iω_0)T}` of frequency lines to the unit circle.
#[derive(Clone, Copy, Debug)]
pub(in crate::identify) struct ZPlane {
    /// First line, rad/s.
    pub omega_0: f64,
    /// T, s.
    pub step_s: f64,
}

/// Number of points of the circle for a number of lines, with a minimum.
pub(in crate::identify) fn circle_points(lines: usize, min_points: usize) -> usize {
    let points = (lines as f64 / BAND_ARC_FRACTION).ceil() as usize;
    points.max(min_points).next_multiple_of(64)
}

impl ZPlane {
    /// The branch of the logarithm that puts the pole around the band: the gap of the circle is
    /// shared by both sides.
    pub fn unwrapped(&self, lambda: Complex64) -> Complex64 {
        let turn = std::f64::consts::TAU / self.step_s;
        let lowest = self.omega_0 - 0.5 * (1.0 - BAND_ARC_FRACTION) * turn;
        let mut lambda = lambda;
        while lambda.im < lowest {
            lambda.im += turn;
        }
        while lambda.im >= lowest + turn {
            lambda.im -= turn;
        }
        lambda
    }
}
