//! Poles in the e^{+iωt} convention.

use std::f64::consts::TAU;

use num_complex::Complex64;

/// A pole `lambda = -zeta omega_n + i omega_n sqrt(1 - zeta^2)`, rad/s, with the positive imaginary
/// part kept.
///
/// ```
/// use modalign::modal::Pole;
/// let pole = Pole::from_frequency(100.0, 0.02);
/// assert!((pole.natural_frequency_hz() - 100.0).abs() < 1e-12);
/// assert!((pole.damping_ratio() - 0.02).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pole {
    /// λ, rad/s.
    pub lambda: Complex64,
}

impl Pole {
    /// The pole of a natural frequency in Hz and a damping ratio below one.
    pub fn from_frequency(natural_hz: f64, damping_ratio: f64) -> Self {
        let omega = TAU * natural_hz;
        let zeta = damping_ratio;
        Self {
            lambda: Complex64::new(-zeta * omega, omega * (1.0 - zeta * zeta).max(0.0).sqrt()),
        }
    }

    /// Natural frequency |λ|/2π, Hz.
    pub fn natural_frequency_hz(&self) -> f64 {
        self.lambda.norm() / TAU
    }

    /// Damped frequency Im λ/2π, Hz.
    pub fn damped_frequency_hz(&self) -> f64 {
        self.lambda.im / TAU
    }

    /// Damping ratio −Re λ/|λ|, a fraction; 0 for a pole at the origin.
    pub fn damping_ratio(&self) -> f64 {
        let norm = self.lambda.norm();
        if norm > 0.0 {
            -self.lambda.re / norm
        } else {
            0.0
        }
    }

    /// Half-power bandwidth 2ζf, Hz.
    pub fn half_power_width_hz(&self) -> f64 {
        2.0 * self.damping_ratio() * self.natural_frequency_hz()
    }

    /// The pole without an added decay rate (that of an exponential window), rad/s.
    pub fn without_added_damping(&self, added_damping_rad_s: f64) -> Self {
        Self {
            lambda: self.lambda + added_damping_rad_s,
        }
    }
}
