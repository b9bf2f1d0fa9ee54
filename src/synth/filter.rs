//! The analogue anti-alias low-pass that force and responses share, with its poles and partial
//! fractions.
//!
//! It holds no sampling: the filter acts on the continuous signals. Being the same on every channel
//! it cancels in an FRF.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;

use super::SynthError;

/// Shape of the filter's magnitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilterKind {
    /// Chebyshev type I: equal ripple in the pass band, monotonic above it.
    ChebyshevI,
}

impl FilterKind {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            FilterKind::ChebyshevI => "chebyshev-1",
        }
    }
}

/// The filter as stated, its edge as a fraction of the sampling rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPassOptions {
    /// Number of poles, 2 to 24.
    pub order: usize,
    /// Ripple of the pass band, dB, above 0 and up to 3.
    pub ripple_db: f64,
    /// Edge of the pass band over the sampling rate, above 0 and below 0.5.
    pub edge_over_sampling_rate: f64,
}

impl Default for LowPassOptions {
    /// Order 16, 0.1 dB, 0.4 of the sampling rate: 111 dB down at 0.6 of the sampling rate, where
    /// aliases into the pass band begin.
    fn default() -> Self {
        Self {
            order: 16,
            ripple_db: 0.1,
            edge_over_sampling_rate: 0.4,
        }
    }
}

/// A Chebyshev type I low-pass in Hz, as the file of a synthetic test states it.
///
/// `H(s) = prod_k -q_k / (s - q_k)`, so that the gain at 0 Hz is exactly 1. With `epsilon^2 =
/// 10^(ripple/10) - 1` and `T_n` the Chebyshev polynomial, `|H(i w)|^2 = g / (1 + epsilon^2
/// T_n(w/w_edge)^2)`, `g = 1 + epsilon^2` for an even order (the pass band then lies between 0 and
/// +ripple) and `g = 1` for an odd one (between -ripple and 0).
///
/// # Reference
/// Parks and Burrus (1987), Digital Filter Design, section 7.2.2 (Chebyshev I: poles in closed
/// form).
#[derive(Clone, Debug, PartialEq)]
pub struct LowPass {
    /// Shape of the magnitude.
    pub kind: FilterKind,
    /// Number of poles.
    pub order: usize,
    /// Ripple of the pass band, dB.
    pub ripple_db: f64,
    /// Edge of the pass band, Hz.
    pub edge_hz: f64,
    /// All poles, rad/s, by falling imaginary part.
    pub poles_rad_s: Vec<Complex64>,
}

/// One term `B / (s - q)` of the partial fractions; a term above the real axis stands for its
/// conjugate too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fraction {
    /// q, rad/s, imaginary part not negative.
    pub pole: Complex64,
    /// B, rad/s.
    pub residue: Complex64,
}

impl LowPass {
    /// The filter for a sampling rate.
    ///
    /// # Errors
    /// [`SynthError::OutOfRange`] for an option outside its range or a sampling rate that is not
    /// positive.
    pub fn new(options: &LowPassOptions, sampling_rate_hz: f64) -> Result<Self, SynthError> {
        check(options, sampling_rate_hz)?;
        let edge_hz = options.edge_over_sampling_rate * sampling_rate_hz;
        Ok(Self {
            kind: FilterKind::ChebyshevI,
            order: options.order,
            ripple_db: options.ripple_db,
            edge_hz,
            poles_rad_s: chebyshev_poles(options.order, options.ripple_db, TAU * edge_hz),
        })
    }

    /// The transfer function at a complex frequency s, rad/s; 1 at s = 0.
    pub fn transfer(&self, s: Complex64) -> Complex64 {
        self.poles_rad_s.iter().map(|q| -q / (s - q)).product()
    }

    /// Partial fractions: `B_k = -q_k prod_{j != k} -q_j / (q_k - q_j)`, for the poles on and above
    /// the real axis.
    pub(super) fn fractions(&self) -> Vec<Fraction> {
        let poles = &self.poles_rad_s;
        let residue = |k: usize| {
            let others = (0..poles.len()).filter(|j| *j != k);
            -poles[k]
                * others
                    .map(|j| -poles[j] / (poles[k] - poles[j]))
                    .product::<Complex64>()
        };
        (0..self.order.div_ceil(2))
            .map(|k| Fraction {
                pole: poles[k],
                residue: residue(k),
            })
            .collect()
    }
}

fn check(options: &LowPassOptions, sampling_rate_hz: f64) -> Result<(), SynthError> {
    let error = |name, got, expected, unit| {
        Err(SynthError::OutOfRange {
            name,
            got,
            expected,
            unit,
        })
    };
    let (ripple, edge) = (options.ripple_db, options.edge_over_sampling_rate);
    if !(sampling_rate_hz > 0.0 && sampling_rate_hz.is_finite()) {
        return error("sampling rate", sampling_rate_hz, "above 0", "Hz");
    }
    if !(2..=24).contains(&options.order) {
        return error("filter order", options.order as f64, "2 to 24", "");
    }
    if !(ripple > 0.0 && ripple <= 3.0) {
        return error("filter ripple", ripple, "above 0 and up to 3", "dB");
    }
    if !(edge > 0.0 && edge < 0.5) {
        let expected = "above 0 and below 0.5 of the sampling rate";
        return error("filter edge over sampling rate", edge, expected, "");
    }
    Ok(())
}

/// `q_k = w_edge (-sinh(mu) sin(theta_k) + i cosh(mu) cos(theta_k))`, `mu = asinh(1/epsilon)/n`,
/// `theta_k = pi (2k-1)/(2n)`.
fn chebyshev_poles(order: usize, ripple_db: f64, edge_rad_s: f64) -> Vec<Complex64> {
    let n = order as f64;
    let epsilon = (10f64.powf(ripple_db / 10.0) - 1.0).sqrt();
    let mu = (1.0 / epsilon).asinh() / n;
    (0..order)
        .map(|k| {
            let theta = PI * (2 * k + 1) as f64 / (2.0 * n);
            // The middle pole of an odd order is real; cos(pi/2) in floating point is not quite 0.
            let imaginary = if 2 * k + 1 == order {
                0.0
            } else {
                mu.cosh() * theta.cos()
            };
            edge_rad_s * Complex64::new(-mu.sinh() * theta.sin(), imaginary)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE_HZ: f64 = 4096.0;

    fn filter(order: usize) -> LowPass {
        let options = LowPassOptions {
            order,
            ..LowPassOptions::default()
        };
        LowPass::new(&options, RATE_HZ).unwrap()
    }

    fn decibel(filter: &LowPass, over_rate: f64) -> f64 {
        let s = Complex64::new(0.0, TAU * over_rate * RATE_HZ);
        20.0 * filter.transfer(s).norm().log10()
    }

    fn pass_band_extremes(filter: &LowPass) -> (f64, f64) {
        let levels = (0..=4000).map(|i| decibel(filter, 0.4 * f64::from(i) / 4000.0));
        levels.fold((f64::MAX, f64::MIN), |(lo, hi), v| (lo.min(v), hi.max(v)))
    }

    #[test]
    fn the_pass_band_ripples_by_exactly_the_stated_ripple_from_unity_at_zero() {
        for (order, lo, hi) in [(16, 0.0, 0.1), (15, -0.1, 0.0)] {
            let (lowest, highest) = pass_band_extremes(&filter(order));
            assert!(
                (lowest - lo).abs() < 1e-4 && (highest - hi).abs() < 1e-4,
                "{order}: {lowest} {highest}"
            );
            assert!(decibel(&filter(order), 0.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_magnitude_is_the_chebyshev_polynomial() {
        let f = filter(16);
        let epsilon_squared = 10f64.powf(0.01) - 1.0;
        for (over_rate, x) in [(0.6f64, 1.5f64), (0.48, 1.2), (0.8, 2.0)] {
            let polynomial = (16.0 * x.acosh()).cosh();
            let closed = 10.0
                * ((1.0 + epsilon_squared) / (1.0 + epsilon_squared * polynomial.powi(2))).log10();
            let got = decibel(&f, over_rate);
            assert!((got - closed).abs() < 1e-9, "{over_rate}: {got} {closed}");
        }
        assert!(decibel(&f, 0.6) < -100.0);
    }

    #[test]
    fn partial_fractions_sum_to_the_product() {
        for order in [2, 7, 16, 24] {
            let f = filter(order);
            for i in 0..=60 {
                let s = Complex64::new(0.0, TAU * RATE_HZ * f64::from(i) / 60.0);
                let terms = f.fractions().into_iter().map(|t| {
                    let mirror = if t.pole.im > 0.0 {
                        t.residue.conj() / (s - t.pole.conj())
                    } else {
                        Complex64::ZERO
                    };
                    t.residue / (s - t.pole) + mirror
                });
                let sum: Complex64 = terms.sum();
                assert!((sum - f.transfer(s)).norm() < 1e-12, "order {order}");
            }
        }
    }

    #[test]
    fn an_option_outside_its_range_is_refused() {
        let good = LowPassOptions::default();
        let bad = [
            LowPassOptions { order: 1, ..good },
            LowPassOptions {
                ripple_db: 0.0,
                ..good
            },
            LowPassOptions {
                edge_over_sampling_rate: 0.5,
                ..good
            },
        ];
        for options in bad {
            assert!(matches!(
                LowPass::new(&options, RATE_HZ),
                Err(SynthError::OutOfRange { .. })
            ));
        }
        assert!(LowPass::new(&good, f64::NAN).is_err());
    }
}
