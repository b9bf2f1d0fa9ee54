//! The force bandwidth check measures how far the spectrum of the pulse falls within the band.

use crate::fourier::ForwardPlan;

use super::super::Pulse;
use super::HitQualityLimits;
use super::check::{Check, Outcome, Rule, compare_with_limit};

/// Frequency lines per 1/length of the pulse: the frequency where the spectrum crosses a level is
/// found to 1/16 of 1/length.
const ZERO_PADDING: usize = 16;
/// Shortest transform.
const MIN_TRANSFORM_SAMPLES: usize = 1024;

/// The deepest fall of the pulse's spectrum inside the band below its maximum, dB, and in `at`
/// where it first passes the limit, Hz.
///
/// The spectrum is that of the pulse alone, from half its length before the onset to as much after
/// its end, the level taken off: noise and later contacts are not in it.
pub(super) fn roll_off(
    force_n: &[f64],
    step_s: f64,
    pulse: &Pulse,
    band_end_hz: f64,
    limits: &HitQualityLimits,
) -> Check {
    let half = (pulse.end - pulse.onset).div_ceil(2);
    let first = pulse.onset.saturating_sub(half);
    let last = (pulse.end + half).min(force_n.len());
    let len = ((last - first) * ZERO_PADDING)
        .max(MIN_TRANSFORM_SAMPLES)
        .next_power_of_two();
    let pulse_force = force_n[first..last].iter().map(|f| f - pulse.level_n);
    let mut samples: Vec<f64> = pulse_force.collect();
    samples.resize(len, 0.0);
    let power: Vec<f64> = ForwardPlan::new(len)
        .transform(&samples)
        .iter()
        .map(|line| line.norm_sqr())
        .collect();
    let hz = |k: usize| k as f64 / (len as f64 * step_s);
    let maximum = power.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let fall_db = |k: usize| -10.0 * (power[k].max(f64::MIN_POSITIVE) / maximum).log10();
    let band = (0..power.len()).take_while(|k| hz(*k) <= band_end_hz);
    let limit = limits.roll_off_db;
    let deepest = band.map(fall_db).fold(0.0, f64::max);
    let passes = (0..power.len()).find(|k| fall_db(*k) > limit);
    Check {
        at: passes.map(hz),
        ..Check::new(
            Rule::RollOff,
            compare_with_limit(deepest, limit, Outcome::Noted),
        )
        .value(deepest, limit, "dB")
    }
}
