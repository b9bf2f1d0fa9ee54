//! Overload: samples on the rail of the converter, jitter of its last bits included.
//!
//! With a known full scale the rail is there. Otherwise it is the extreme of the record, of either sign, if the
//! samples pile up on it. Under a smooth top the depth below the extreme grows with the square of the distance, so that of the
//! samples less than Kδ deep a share of `1/√K` is less than δ deep; noise and quantised tops have a smaller share, whereas a
//! clipped signal leaves the rail at its full slope. The count is held against the binomial distribution of that
//! share, for K from 5 on doubled up to half the height.

use statrs::distribution::{Binomial, DiscreteCDF};

use super::super::{lane_bounds, lane_sum};
use super::quiet::least_step;
use super::{Check, JudgeLimits, Outcome, Rule};

/// Depth of the rail in steps: a jitter of ±2 codes spreads over 4, and half a step for rounding.
const RAIL_STEPS: f64 = 4.5;
/// The rail is at least so deep, relative to the range: samples that went through single precision are on no clean raster.
const LEAST_DEPTH: f64 = 1e-6;
/// Samples from the start of the record that show the step of the converter, together with those in the upper half of a side.
const STEP_SAMPLES: usize = 4096;
/// The smallest K: samples within five depths.
const FIRST_DEPTHS: f64 = 5.0;
/// Chance of as many samples on the extreme under a top of random depths. Three samples on a rail of a 12-bit converter with one in
/// the upper half of the height beside them are at 0.0018 (K = 160); smooth tops are more even than random ones and stay far above.
const RAIL_CHANCE: f64 = 2e-3;

/// Part of the range below its end in which a clipped record has its samples: the jitter of a converter of 12 bits.
const NEAR_THE_END: f64 = 2.5e-3;

/// The rule; the value is the number of samples on the rail. A record with too few samples near its ends has passed at a
/// glance.
pub(super) fn overload(samples: &[f64], full_scale: Option<f64>, limits: &JudgeLimits) -> Check {
    let count = if near_the_ends(samples, full_scale) < limits.overload_samples {
        0
    } else {
        on_the_rail(samples, full_scale)
    };
    let outcome = if count >= limits.overload_samples {
        Outcome::Rejected
    } else if count > 0 && full_scale.is_some() {
        Outcome::Noted
    } else {
        Outcome::Passed
    };
    Check::new(Rule::Overload, outcome).value(
        count as f64,
        limits.overload_samples as f64,
        "samples",
    )
}

/// Samples near the rails, or near the extremes where the rails are not known.
fn near_the_ends(samples: &[f64], full_scale: Option<f64>) -> usize {
    let (lo, hi) = lane_bounds(samples);
    let depth = NEAR_THE_END * (hi - lo);
    let (low, high) = match full_scale {
        Some(rail) => (-rail.abs() + depth, rail.abs() - depth),
        None => (lo + depth, hi - depth),
    };
    samples.iter().filter(|x| **x >= high || **x <= low).count()
}

fn on_the_rail(samples: &[f64], full_scale: Option<f64>) -> usize {
    let (lo, hi) = lane_bounds(samples);
    if hi <= lo {
        return 0;
    }
    let depth = |mut upper: Vec<f64>| {
        upper.extend_from_slice(&samples[..samples.len().min(STEP_SAMPLES)]);
        (RAIL_STEPS * step_of(upper)).max(LEAST_DEPTH * (hi - lo))
    };
    if let Some(rail) = full_scale {
        let rail = rail.abs() - depth(Vec::new());
        return samples.iter().filter(|x| x.abs() >= rail).count();
    }
    let mean = lane_sum(samples, |x| x) / samples.len() as f64;
    let side = |sign: f64| {
        let highest = (sign * hi).max(sign * lo);
        let height = highest - sign * mean;
        // The other side of a pulse is its level: an extreme less than half as far from the mean as the other is none.
        if height < 0.5 * (hi - lo - height) {
            return 0;
        }
        let upper = samples.iter().copied();
        let upper: Vec<f64> = upper
            .filter(|x| highest - sign * x <= 0.5 * height)
            .collect();
        let depth = depth(upper.clone());
        let below = upper.iter().map(|x| highest - sign * x).collect();
        Upper { below, height }.piled_up(depth)
    };
    side(1.0).max(side(-1.0))
}

/// Least distance of two different samples of a few.
fn step_of(mut samples: Vec<f64>) -> f64 {
    samples.sort_unstable_by(f64::total_cmp);
    least_step(&samples)
}

/// The upper half of one side of a record.
struct Upper {
    /// How far each sample is below the extreme.
    below: Vec<f64>,
    /// From the mean to the extreme.
    height: f64,
}

impl Upper {
    /// Samples within `depth` of the extreme, 0 where they do not pile up.
    fn piled_up(&self, depth: f64) -> usize {
        if self.height <= 2.0 * FIRST_DEPTHS * depth {
            return 0;
        }
        let octaves = (0.5 * self.height / (FIRST_DEPTHS * depth)).log2().floor();
        // By octaves of the depth beyond K = 5.
        let mut by_octave = vec![0usize; octaves as usize + 1];
        for below in &self.below {
            let octave = (below / (FIRST_DEPTHS * depth)).max(1.0).log2().ceil();
            if let Some(count) = by_octave.get_mut(octave as usize) {
                *count += 1;
            }
        }
        let on = self.below.iter().filter(|below| **below <= depth).count();
        let mut within = 0;
        let mut octaves = by_octave.iter().zip(0..);
        let rail = octaves.any(|(count, octave)| {
            within += count;
            chance(on, within, FIRST_DEPTHS * 2f64.powi(octave)) < RAIL_CHANCE
        });
        if rail { on } else { 0 }
    }
}

/// Probability that `on` or more of `all` samples are within one depth when each is with `1/√K`.
fn chance(on: usize, all: usize, depths: f64) -> f64 {
    let share = Binomial::new(depths.sqrt().recip(), all as u64);
    // A share between 0 and 1 is always a distribution; without one nothing is proved.
    share.map_or(1.0, |binomial| binomial.sf(on.saturating_sub(1) as u64))
}
