//! The hammer pulse is located in a force record; mean and noise of a channel are estimated before
//! it.
//!
//! Works on one force in SI units. It does not assess the hit (double hits, overloads) and changes
//! no sample.

use std::ops::Range;

use super::lane_sum;

/// The force counts as a pulse where it is further from its level than this fraction of the peak.
///
/// Five percent stands well above the noise and the drift of a usable hammer channel (26 dB below
/// the peak).
pub const ONSET_FRACTION: f64 = 0.05;

/// Fewest pre-trigger samples that give a mean and a variance.
pub(super) const MIN_PRETRIGGER_SAMPLES: usize = 8;

/// The hammer pulse of one force record, as sample numbers from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// First sample of the pulse: walking back from the peak, the last one above the threshold.
    pub onset: usize,
    /// Sample of the largest distance from the level.
    pub peak: usize,
    /// First sample after the pulse that is below the threshold again (the record length when there
    /// is none).
    pub end: usize,
    /// Level of the force without the pulse: the median of the samples before the peak, N.
    pub level_n: f64,
    /// Force at the peak minus the level, with its sign, N.
    pub height_n: f64,
}

impl Pulse {
    /// Finds the pulse: the peak of `|f - level|`, then both ways to where that falls to `fraction`
    /// of the peak.
    ///
    /// The peak is sought about the median of the whole record, so that an offset does not hide a
    /// pulse of the other sign; the level is then the median before the peak (of the whole record
    /// when fewer than 8 samples lie before it). `fraction` is used as given, [`ONSET_FRACTION`] by
    /// the stages. `None` for a constant force.
    pub fn locate(force_n: &[f64], fraction: f64) -> Option<Self> {
        let middle = median(force_n)?;
        let peak = furthest_from(force_n, middle)?;
        let level_n = if peak >= MIN_PRETRIGGER_SAMPLES {
            median(&force_n[..peak])?
        } else {
            middle
        };
        let height_n = force_n[peak] - level_n;
        if height_n.abs() <= 0.0 {
            return None;
        }
        let above = |sample: &f64| (sample - level_n).abs() > fraction * height_n.abs();
        let before = force_n[..peak].iter().rev().take_while(|s| above(s));
        let after = force_n[peak + 1..].iter().take_while(|s| above(s));
        Some(Self {
            onset: peak - before.count(),
            peak,
            end: peak + 1 + after.count(),
            level_n,
            height_n,
        })
    }

    /// The pre-trigger samples: up to the onset less a guard of one rise
    /// time (onset to peak), at least two samples, because the pulse begins below the threshold.
    pub fn pretrigger_samples(&self) -> Range<usize> {
        0..self.onset.saturating_sub((self.peak - self.onset).max(2))
    }
}

/// Median by selection; the mean of the two middle values for an even count.
pub(super) fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    let half = sorted.len() / 2;
    if sorted.is_empty() {
        return None;
    }
    let even = sorted.len().is_multiple_of(2);
    let (lower, upper, _) = sorted.select_nth_unstable_by(half, f64::total_cmp);
    let upper = *upper;
    let below = lower.iter().copied().max_by(f64::total_cmp);
    Some(match below {
        Some(below) if even => 0.5 * (below + upper),
        _ => upper,
    })
}

/// The first sample furthest from a level.
fn furthest_from(values: &[f64], level: f64) -> Option<usize> {
    let distance = |i: &usize| (values[*i] - level).abs();
    (0..values.len())
        .rev()
        .max_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// Mean and variance of one channel before the hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PretriggerNoise {
    /// Number of pre-trigger samples.
    pub samples: usize,
    /// Their mean, SI unit of the channel.
    pub mean: f64,
    /// Their variance about the mean (divided by n - 1), SI unit squared: the noise of the channel.
    pub variance: f64,
}

impl PretriggerNoise {
    /// Of the pre-trigger samples of a channel; `None` for fewer than eight.
    ///
    /// Noise of a longer period than these samples shows in the mean, not in the variance.
    pub fn of(pretrigger: &[f64]) -> Option<Self> {
        if pretrigger.len() < MIN_PRETRIGGER_SAMPLES {
            return None;
        }
        let n = pretrigger.len() as f64;
        let mean = lane_sum(pretrigger, |v| v) / n;
        let variance = lane_sum(pretrigger, |v| (v - mean).powi(2)) / (n - 1.0);
        Some(Self {
            samples: pretrigger.len(),
            mean,
            variance,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(sign: f64, offset: f64) -> Vec<f64> {
        let shape = [0.02, 0.06, 0.5, 1.0, 0.4, 0.051, 0.049];
        let mut force = vec![offset; 40];
        for (place, value) in force[20..].iter_mut().zip(shape) {
            *place += sign * 100.0 * value;
        }
        force
    }

    #[test]
    fn onset_peak_and_end_are_at_their_samples() {
        for (sign, offset) in [(1.0, 0.0), (-1.0, 0.0), (-1.0, 300.0), (1.0, -7.0)] {
            let pulse = Pulse::locate(&triangle(sign, offset), ONSET_FRACTION).unwrap();
            assert_eq!((pulse.onset, pulse.peak, pulse.end), (21, 23, 26));
            assert_eq!(pulse.pretrigger_samples(), 0..19);
            assert!((pulse.level_n - offset).abs() < 1e-12);
            assert!((pulse.height_n - 100.0 * sign).abs() < 1e-12);
        }
    }

    #[test]
    fn a_record_may_begin_or_end_inside_the_pulse() {
        let pulse = Pulse::locate(&[5.0, 2.0, 0.0, 0.0, 0.0], ONSET_FRACTION).unwrap();
        assert_eq!((pulse.onset, pulse.peak, pulse.end), (0, 0, 2));
        assert_eq!(pulse.pretrigger_samples(), 0..0);
        let pulse = Pulse::locate(&[0.0, 0.0, 0.0, 0.0, 5.0], ONSET_FRACTION).unwrap();
        assert_eq!((pulse.onset, pulse.peak, pulse.end), (4, 4, 5));
    }

    #[test]
    fn a_constant_force_has_no_pulse() {
        assert_eq!(Pulse::locate(&[3.0; 10], ONSET_FRACTION), None);
        assert_eq!(Pulse::locate(&[], ONSET_FRACTION), None);
    }

    #[test]
    fn the_first_of_two_equal_peaks_is_taken() {
        let pulse = Pulse::locate(&[0.0, 4.0, 0.0, -4.0, 0.0], ONSET_FRACTION).unwrap();
        assert_eq!(pulse.peak, 1);
    }

    #[test]
    fn mean_and_variance_of_the_pre_trigger_samples() {
        let pretrigger: Vec<f64> = (1..=8).map(f64::from).collect();
        let noise = PretriggerNoise::of(&pretrigger).unwrap();
        assert!((noise.mean - 4.5).abs() < 1e-15 && (noise.variance - 6.0).abs() < 1e-14);
        assert_eq!(PretriggerNoise::of(&pretrigger[1..]), None);
    }
}
