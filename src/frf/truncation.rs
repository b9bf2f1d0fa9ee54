//! Truncation error of H, because the record ends before the response has decayed, estimated from
//! the record itself.
//!
//! One mode of decay rate σ rings as `e^{λt}`, λ = -σ + iω_d. Transformed over a duration `T` from
//! the hit instead of for ever, its part of H is multiplied by `1 - e^{(λ - iω)T}`, at every line:
//! a relative error of `e^{-σT}`. The energy of that mode falls by `e^{-2σT/4}` from one quarter of
//! the duration to the next, so that `(E_{q+1} / E_q)² = e^{-σT}`.
//!
//! A record holds several modes. If their energies add, log E is convex in time and the last fall
//! is the slowest. If two of them beat, a single fall may be too fast (the last quarter in a node
//! of the beat); then an earlier one is too slow. The bound is therefore `(max_q E_{q+1}/E_q)²`
//! over the three falls: for one mode the truth, to 4ζ of itself by where in their cycle the
//! quarters begin; for modes that do not beat the last fall; for two equal modes with at least one
//! beat in the record not below 0.55 of the truth (and far above it when the beat is about as long
//! as two quarters; a bound may be). It holds for the modes that fill the last quarter; a slower
//! one that is hidden under them is found by the check of each identified mode's time constants.
//!
//! The noise before the hit is taken off each quarter, and what is constant in a quarter (an
//! offset) does not count.

use std::collections::BTreeMap;

use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::signal::{lane_moments, lane_sum, lane_sum_of_pairs};

/// The limit of the bound: six time constants in the record, `e^-6` = 2.5e-3.
pub const TRUNCATION_LIMIT: f64 = 0.002_478_752_176_666_358_5;

/// The last quarter must have this many times the energy of the noise before the hit.
///
/// Noise alone would then have to be measured wrong by a factor of three to be taken for a
/// response.
const MIN_ENERGY_OVER_NOISE: f64 = 3.0;

/// Shortest quarter, in samples, that has an energy to speak of.
const MIN_QUARTER_SAMPLES: usize = 8;

/// Limits of the truncation error of one function, from its record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truncation {
    /// Relative error of H near resonance, `e^{-σT}`, at most 1; `None` when the tail of the record
    /// is noise, empty or too short.
    pub bound: Option<f64>,
    /// Time constants of the slowest decay in the record, `-ln(bound)`.
    pub time_constants: Option<f64>,
}

impl Truncation {
    /// No estimate is possible.
    pub const NOT_DECIDABLE: Truncation = Truncation {
        bound: None,
        time_constants: None,
    };
}

/// Energies of the four quarters from the hit to the end of the record, summed over hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct QuarterEnergies {
    /// Of the response as transformed, less what is constant in a quarter.
    signal: [f64; 4],
    /// Of the channel's noise under the same window; `None` without pre-trigger samples.
    noise: Option<[f64; 4]>,
}

impl QuarterEnergies {
    /// Of a response as transformed; `onset` is where its hit begins, `weights` the window, `noise`
    /// the variance of the channel before the hit. `None` when a quarter is too short.
    pub fn of(
        samples: &[f64],
        onset: usize,
        weights: Option<&[f64]>,
        noise: Option<f64>,
    ) -> Option<Self> {
        let len = samples.len();
        let quarter = len.checked_sub(onset)? / 4;
        if quarter < MIN_QUARTER_SAMPLES {
            return None;
        }
        let mut signal = [0.0; 4];
        let mut window = [quarter as f64; 4];
        for q in 0..4 {
            let begin = len - (4 - q) * quarter;
            let samples = &samples[begin..begin + quarter];
            match weights {
                None => signal[q] = energy_about_mean(samples),
                Some(weights) => {
                    let weights = &weights[begin..begin + quarter];
                    window[q] = lane_sum(weights, |w| w * w);
                    signal[q] = energy_without_offset(samples, weights);
                }
            }
        }
        Some(Self {
            signal,
            noise: noise.map(|variance| window.map(|w| w * variance)),
        })
    }

    /// The sum over hits; noise stays known only where it is known of every hit.
    pub fn sum(energies: impl IntoIterator<Item = Option<Self>>) -> Option<Self> {
        let add = |a: [f64; 4], b: [f64; 4]| std::array::from_fn(|q| a[q] + b[q]);
        let mut energies = energies.into_iter();
        let first = energies.next()??;
        energies.try_fold(first, |sum, next| {
            let next = next?;
            Some(Self {
                signal: add(sum.signal, next.signal),
                noise: sum.noise.zip(next.noise).map(|(a, b)| add(a, b)),
            })
        })
    }

    /// The bound. Without known noise none is taken off: noise only slows the fall, so that the
    /// bound still holds.
    pub fn truncation(&self) -> Truncation {
        let noise = self.noise.unwrap_or([0.0; 4]);
        let decided = self.signal[3] > 0.0 && self.signal[3] >= MIN_ENERGY_OVER_NOISE * noise[3];
        let net: [f64; 4] = std::array::from_fn(|q| self.signal[q] - noise[q]);
        if !decided || net.iter().any(|e| *e <= 0.0) {
            return Truncation::NOT_DECIDABLE;
        }
        let slowest = net.windows(2).map(|e| e[1] / e[0]).fold(0.0, f64::max);
        let bound = (slowest * slowest).min(1.0);
        Truncation {
            bound: Some(bound),
            time_constants: Some(-bound.ln()),
        }
    }
}

/// `Σ(x - c)²` with the mean `c`, in one pass about the first sample, so that an offset costs no
/// digits.
fn energy_about_mean(samples: &[f64]) -> f64 {
    let first = samples.first().copied().unwrap_or(0.0);
    let (sum, squares) = lane_moments(samples, first);
    (squares - sum * sum / samples.len() as f64).max(0.0)
}

/// `Σ(x - c w)²` with the constant `c` under the window `w` that makes it least.
fn energy_without_offset(samples: &[f64], weights: &[f64]) -> f64 {
    let window = lane_sum(weights, |w| w * w);
    let offset = if window > 0.0 {
        lane_sum_of_pairs(samples, weights, |x, w| x * w) / window
    } else {
        0.0
    };
    lane_sum_of_pairs(samples, weights, |x, w| (x - offset * w) * (x - offset * w))
}

/// The one finding of a set: its worst bound, or that none can be estimated.
pub(super) fn truncation_finding(bounds: &BTreeMap<(Dof, Dof), Truncation>) -> Finding {
    let worst = bounds
        .iter()
        .filter_map(|(pair, truncation)| Some((pair, truncation.bound?)))
        .fold(
            None,
            |worst: Option<(&(Dof, Dof), f64)>, (pair, bound)| match worst {
                Some((_, other)) if other >= bound => worst,
                _ => Some((pair, bound)),
            },
        );
    let Some(((response, reference), bound)) = worst else {
        return Finding::new(
            Severity::Info,
            Code::TruncationNotDecidable,
            Location::Whole,
        );
    };
    let severity = if bound > TRUNCATION_LIMIT {
        Severity::Warning
    } else {
        Severity::Info
    };
    let location = Location::Function {
        response: Some(response.clone()),
        reference: Some(reference.clone()),
    };
    Finding::new(severity, Code::Truncated, location)
        .value(bound, "")
        .limit(TRUNCATION_LIMIT)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn energies(signal: [f64; 4], noise: Option<[f64; 4]>) -> QuarterEnergies {
        QuarterEnergies { signal, noise }
    }

    #[test]
    fn the_limit_is_six_time_constants() {
        assert!((TRUNCATION_LIMIT / (-6f64).exp() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn one_decay_gives_its_time_constants_with_and_without_noise() {
        for n in [1.0, 6.0, 9.5] {
            let quarters: [f64; 4] = std::array::from_fn(|q| (-n * q as f64 / 2.0).exp());
            let floor = 0.3 * quarters[3];
            let noisy = energies(quarters.map(|e| e + floor), Some([floor; 4]));
            for e in [energies(quarters, None), noisy] {
                let got = e.truncation();
                assert!((got.time_constants.expect("a decay") - n).abs() < 1e-12);
                assert!((got.bound.expect("a decay") / (-n).exp() - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn decay_is_undecidable_from_a_tail_of_noise_or_zeros() {
        let noise = Some([1.0; 4]);
        assert_eq!(
            energies([90.0, 20.0, 9.0, 2.99], noise).truncation().bound,
            None
        );
        assert!(
            energies([90.0, 20.0, 9.0, 3.01], noise)
                .truncation()
                .bound
                .is_some()
        );
        assert_eq!(
            energies([9.0, 0.0, 0.0, 0.0], None).truncation().bound,
            None
        );
        let growing = energies([1.0, 1.0, 1.0, 2.0], None).truncation();
        assert_eq!(
            (growing.bound, growing.time_constants),
            (Some(1.0), Some(-0.0))
        );
    }

    #[test]
    fn two_beating_modes_are_not_taken_for_a_faster_decay() {
        let steps = 400;
        let n = 6.0;
        for beats in [1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.5, 7.0] {
            for phase in 0..16 {
                let mut signal = [0.0; 4];
                for i in 0..steps {
                    let t = (i as f64 + 0.5) / steps as f64;
                    let beat = (TAU * (beats * t + f64::from(phase) / 16.0)).cos();
                    signal[4 * i / steps] += (-2.0 * n * t).exp() * (2.0 + 2.0 * beat);
                }
                let bound = energies(signal, None).truncation().bound.expect("a decay");
                assert!(
                    bound > 0.55 * f64::exp(-n),
                    "{beats} beats, phase {phase}: {bound}"
                );
            }
        }
    }

    #[test]
    fn energies_of_hits_add_and_one_unknown_noise_makes_the_sum_unknown() {
        let a = energies([4.0, 3.0, 2.0, 1.0], Some([0.1; 4]));
        let b = energies([40.0, 30.0, 20.0, 10.0], None);
        let sum = QuarterEnergies::sum([Some(a), Some(a)]).expect("energies of both");
        let expected = energies([8.0, 6.0, 4.0, 2.0], Some([0.2; 4]));
        assert_eq!(sum, expected);
        assert_eq!(
            QuarterEnergies::sum([Some(a), Some(b)])
                .expect("energies of both")
                .noise,
            None
        );
        assert_eq!(QuarterEnergies::sum([Some(a), None]), None);
        assert_eq!(QuarterEnergies::sum([]), None);
    }

    #[test]
    fn an_offset_under_the_window_has_no_energy() {
        let weights: Vec<f64> = (0..50).map(|n| (-0.05 * f64::from(n)).exp()).collect();
        let samples: Vec<f64> = weights.iter().map(|w| 7.0 * w).collect();
        assert!(energy_without_offset(&samples, &weights) < 1e-25);
        let wave = |n: usize| (TAU * n as f64 / 10.0).sin();
        let offset_wave: Vec<f64> = (0..50).map(|n| 3.0 + wave(n)).collect();
        assert!((energy_without_offset(&offset_wave, &[1.0; 50]) - 25.0).abs() < 1e-12);
        assert!((energy_about_mean(&offset_wave) - 25.0).abs() < 1e-12);
    }

    #[test]
    fn the_finding_names_the_worst_function() {
        let dof = |text: &str| text.parse::<Dof>().expect("a degree of freedom");
        let truncation = |bound: Option<f64>| Truncation {
            bound,
            time_constants: bound.map(|b| -b.ln()),
        };
        let pair = |r: &str| (dof(r), dof("9:+Z"));
        let mut bounds = BTreeMap::from([(pair("1:+Z"), truncation(None))]);
        let none = truncation_finding(&bounds);
        assert_eq!(
            (none.code, none.severity, none.value),
            (Code::TruncationNotDecidable, Severity::Info, None)
        );
        bounds.insert(pair("2:+Z"), truncation(Some(1e-4)));
        assert_eq!(truncation_finding(&bounds).severity, Severity::Info);
        bounds.insert(pair("3:+Z"), truncation(Some(0.1)));
        bounds.insert(pair("4:+Z"), truncation(Some(0.01)));
        let worst = truncation_finding(&bounds);
        assert_eq!(
            (worst.code, worst.severity),
            (Code::Truncated, Severity::Warning)
        );
        assert_eq!(worst.value, Some(0.1));
        assert_eq!(worst.location.to_string(), "3:+Z|9:+Z");
    }
}
