//! Windows of a hammer test. A window is placed by the pulse and knows nothing of the samples.
//!
//! A force window keeps the pulse and silences the noise after it. An exponential window lets the
//! response decay within the record; it multiplies force and response alike, so that `H` is the
//! true one at `s = iω + a`: every pole λ appears at λ - a, exactly. That added damping `a` travels
//! with the FRF set (its `added_damping_rad_s`) and is taken out of the poles, never out of the
//! functions.

use std::f64::consts::PI;

use crate::axis::TimeAxis;

use super::{Pulse, SignalError};

/// Flat from `hold_s` before the pulse to `hold_s` after it, with half a cosine from and to zero
/// over `flank_s` on both sides.
///
/// Everything beyond the flanks is zero. A force with an offset keeps it inside the window alone,
/// which adds a rectangle to the pulse: remove the offset first ([`super::Offset`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceWindow {
    /// Guard between the pulse and either flank, s; the one before the pulse is longer by the
    /// pulse's rise time, because it begins below the threshold that finds it.
    pub hold_s: f64,
    /// Length of each cosine flank, s; 0 for rectangular ends.
    pub flank_s: f64,
}

impl ForceWindow {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`SignalError::WindowParameter`] when one is negative or not finite.
    pub fn validate(&self) -> Result<(), SignalError> {
        not_negative("hold_s of the force window", self.hold_s)?;
        not_negative("flank_s of the force window", self.flank_s)
    }

    /// Weight of every sample: `1` up to `hold_s` away from the pulse, then `(1 + cos(π τ / flank))
    /// / 2`, then `0`, with `τ` counted from the end of the hold.
    pub fn weights(&self, axis: &TimeAxis, pulse: &Pulse) -> Vec<f64> {
        let first = pulse.onset as f64 - (pulse.peak - pulse.onset) as f64;
        let last = pulse.end.saturating_sub(1) as f64;
        (0..axis.len)
            .map(|n| {
                let away = (n as f64 - last).max(first - n as f64);
                self.weight(away * axis.step_s - self.hold_s, axis.step_s)
            })
            .collect()
    }

    /// Weight at this time beyond the hold.
    fn weight(&self, beyond_s: f64, step_s: f64) -> f64 {
        if beyond_s <= 1e-9 * step_s {
            1.0
        } else if beyond_s < self.flank_s {
            0.5 * (1.0 + (PI * beyond_s / self.flank_s).cos())
        } else {
            0.0
        }
    }
}

/// `w(t) = exp(-a (t - t_hit))` from the onset of the pulse on, 1 before it; for force and response
/// alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExponentialWindow {
    /// Decay rate `a`, rad/s: what it adds to the decay rate of every pole.
    pub decay_rad_s: f64,
}

impl ExponentialWindow {
    /// The window that has fallen to `end_value` (such as 0.01) `stretch_s` after the hit: `a =
    /// -ln(end_value) / stretch_s`.
    ///
    /// # Errors
    /// [`SignalError::WindowParameter`] unless `0 < end_value < 1` and `stretch_s` is positive and
    /// finite.
    pub fn from_end_value(end_value: f64, stretch_s: f64) -> Result<Self, SignalError> {
        if !(end_value > 0.0 && end_value < 1.0) {
            return Err(SignalError::WindowParameter {
                parameter: "end value of the exponential window",
                got: end_value,
                unit: "",
                expected: "a fraction between 0 and 1",
            });
        }
        positive("stretch of the exponential window", stretch_s, "s")?;
        Ok(Self {
            decay_rad_s: -end_value.ln() / stretch_s,
        })
    }

    /// Checks the decay rate.
    ///
    /// # Errors
    /// [`SignalError::WindowParameter`] when it is not positive and finite.
    pub fn validate(&self) -> Result<(), SignalError> {
        positive(
            "decay_rad_s of the exponential window",
            self.decay_rad_s,
            "rad/s",
        )
    }

    /// Weight of every sample.
    pub fn weights(&self, axis: &TimeAxis, pulse: &Pulse) -> Vec<f64> {
        let per_sample = self.decay_rad_s * axis.step_s;
        (0..axis.len)
            .map(|n| (-per_sample * n.saturating_sub(pulse.onset) as f64).exp())
            .collect()
    }
}

fn not_negative(parameter: &'static str, got: f64) -> Result<(), SignalError> {
    if got >= 0.0 && got.is_finite() {
        return Ok(());
    }
    Err(SignalError::WindowParameter {
        parameter,
        got,
        unit: "s",
        expected: "0 or more, finite",
    })
}

fn positive(parameter: &'static str, got: f64, unit: &'static str) -> Result<(), SignalError> {
    if got > 0.0 && got.is_finite() {
        return Ok(());
    }
    Err(SignalError::WindowParameter {
        parameter,
        got,
        unit,
        expected: "more than 0, finite",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXIS: TimeAxis = TimeAxis {
        start_s: -0.02,
        step_s: 0.01,
        len: 12,
    };
    const PULSE: Pulse = Pulse {
        onset: 2,
        peak: 3,
        end: 5,
        level_n: 0.0,
        height_n: 1.0,
    };

    #[test]
    fn the_force_window_holds_falls_and_is_zero() {
        let window = ForceWindow {
            hold_s: 0.02,
            flank_s: 0.04,
        };
        let half = 0.5 / 2f64.sqrt();
        let expected = [
            1.0,
            1.0,
            1.0,
            1.0,
            1.0,
            1.0,
            1.0,
            0.5 + half,
            0.5,
            0.5 - half,
            0.0,
            0.0,
        ];
        for (weight, expected) in window.weights(&AXIS, &PULSE).iter().zip(expected) {
            assert!((weight - expected).abs() < 1e-12, "{weight} {expected}");
        }
    }

    #[test]
    fn without_a_flank_the_force_window_is_a_rectangle() {
        let window = ForceWindow {
            hold_s: 0.0,
            flank_s: 0.0,
        };
        let weights = window.weights(&AXIS, &PULSE);
        // The rise of one sample before the onset at 2 belongs to the pulse.
        for (n, weight) in weights.iter().enumerate() {
            let expected = f64::from((1..5).contains(&n));
            assert!((weight - expected).abs() < 1e-15, "{n}");
        }
    }

    #[test]
    fn the_exponential_window_starts_at_the_hit_and_ends_at_its_value() {
        let window = ExponentialWindow::from_end_value(0.01, 0.09).unwrap();
        let weights = window.weights(&AXIS, &PULSE);
        assert!(weights[..=2].iter().all(|w| (w - 1.0).abs() < 1e-15));
        assert!((weights[11] - 0.01).abs() < 1e-14);
        assert!((weights[3] - 0.01f64.powf(1.0 / 9.0)).abs() < 1e-14);
    }

    #[test]
    fn parameters_outside_their_range_are_errors() {
        for (hold_s, flank_s) in [(-1.0, 0.0), (0.0, f64::NAN), (f64::INFINITY, 0.0)] {
            assert!(ForceWindow { hold_s, flank_s }.validate().is_err());
        }
        for (end, stretch) in [(0.0, 1.0), (1.0, 1.0), (f64::NAN, 1.0), (0.1, 0.0)] {
            assert!(ExponentialWindow::from_end_value(end, stretch).is_err());
        }
        assert!(ExponentialWindow { decay_rad_s: -1.0 }.validate().is_err());
    }
}
