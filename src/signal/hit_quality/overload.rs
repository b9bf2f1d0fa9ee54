//! Overload: clipped samples; samples within the jitter of the converter's last bits count.
//!
//! The clipping level is the full scale, where the channel states it: an amplifier that saturates
//! below it is then not detected. Otherwise it is the extreme of the record, of either sign, if the
//! samples pile up on it. Under a smooth top the depth below the extreme grows with the square of
//! the distance, so that of the samples less than Kδ deep a fraction of `1/√K` is less than δ deep;
//! noise and quantised tops have a smaller fraction, whereas a clipped signal leaves the clipping
//! level at its full slope. The count is compared with the binomial distribution of that fraction,
//! for K from 5 on doubled up to half the height.

use statrs::distribution::{Binomial, DiscreteCDF};

use super::super::Extent;
use super::HitQualityLimits;
use super::check::{Check, Outcome, Rule};
use super::pretrigger::converter_step;

/// Depth below the clipping level, in steps, at which a sample counts as clipped: a jitter of ±2
/// codes spreads over 4, and half a step for rounding.
const CLIP_DEPTH_STEPS: f64 = 4.5;
/// Minimum of this depth, relative to the range: samples that went through single precision are on
/// no clean raster.
const MIN_CLIP_DEPTH_OVER_RANGE: f64 = 1e-6;
/// Samples from the start of the record that show the step of the converter, together with as many
/// of the upper half of each side.
const STEP_SAMPLES: usize = 1024;
/// Samples from the start of the record by which the step is bounded at a glance.
const STEP_BOUND_SAMPLES: usize = 64;
/// Gap of two samples, relative to the range, that holds a step: above the rounding (see
/// [`converter_step`]) between as many samples as show the step.
const MIN_STEP_OVER_RANGE: f64 = 4e-6;
/// The smallest K: samples within five depths.
const MIN_COUNTED_DEPTHS: f64 = 5.0;
/// Chance of as many samples on the extreme under a top of random depths. Three clipped samples
/// of a 12-bit converter with one in the upper half of the height beside them are at 0.0018 (K =
/// 160); smooth tops are more even than random ones and stay far above.
const FALSE_ALARM_PROBABILITY: f64 = 2e-3;

/// Samples that are passed over together when none of them is in the upper half.
const SAMPLES_PER_BLOCK: usize = 64;

/// Fraction of the range below an extreme that contains the clipped samples: the jitter of a
/// converter of 12 bits.
const CLIP_SEARCH_OVER_RANGE: f64 = 2.5e-3;

/// The rule; the value is the number of clipped samples. A record with too few samples near its
/// extremes has passed at a glance. `extent` is that of the samples.
pub(super) fn overload(
    samples: &[f64],
    extent: &Extent,
    full_scale: Option<f64>,
    limits: &HitQualityLimits,
) -> Check {
    let fewest = limits.overload_samples;
    let count = match full_scale {
        Some(clip_level) => count_at_full_scale(samples, extent, clip_level.abs(), fewest),
        None => count_at_extremes(samples, extent, fewest),
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

fn count_at_full_scale(samples: &[f64], extent: &Extent, clip_level: f64, fewest: usize) -> usize {
    let near = clip_level - CLIP_SEARCH_OVER_RANGE * extent.range();
    if extent.hi.max(-extent.lo) < near || extent.count_beyond(samples, -near, near) < fewest {
        return 0;
    }
    let depth = clip_depth(&samples[..samples.len().min(STEP_SAMPLES)], extent);
    let lowest = clip_level - depth;
    extent.count_beyond(samples, -lowest, lowest)
}

fn count_at_extremes(samples: &[f64], extent: &Extent, fewest: usize) -> usize {
    let depth_of_search = CLIP_SEARCH_OVER_RANGE * extent.range();
    let few_within =
        |depth: f64| extent.count_beyond(samples, extent.lo + depth, extent.hi - depth) < fewest;
    // Most records have few samples even where clipping is looked for, and counting them is faster
    // than the depth.
    if extent.range() <= 0.0
        || few_within(depth_of_search)
        || few_within(max_clip_depth(samples, extent).min(depth_of_search))
    {
        return 0;
    }
    let (high, low) = (extent.hi - depth_of_search, extent.lo + depth_of_search);
    let crowded = [
        (1.0, extent.count_beyond(samples, f64::NEG_INFINITY, high)),
        (-1.0, extent.count_beyond(samples, low, f64::INFINITY)),
    ];
    let crowded = crowded.iter().filter(|(_, count)| *count >= fewest);
    let sides: Vec<UpperHalf> = crowded
        .filter_map(|(sign, _)| UpperHalf::of(samples, *sign, extent))
        .collect();
    if sides.is_empty() {
        return 0;
    }
    let mut few = samples[..samples.len().min(STEP_SAMPLES)].to_vec();
    for side in &sides {
        few.extend(side.samples().take(STEP_SAMPLES));
    }
    let depth = clip_depth(&few, extent);
    let counts = sides.iter().map(|side| side.count_clipped(depth));
    counts.max().unwrap_or(0)
}

/// An upper bound of [`clip_depth`], by which most records pass at a glance; infinite where the
/// first samples give none.
///
/// Two samples a step or more apart bound the step. Others may lie between them in steps that count
/// as rounding, in all less than [`MIN_STEP_OVER_RANGE`].
fn max_clip_depth(samples: &[f64], extent: &Extent) -> f64 {
    let mut first = [0.0; STEP_BOUND_SAMPLES];
    let first = &mut first[..samples.len().min(STEP_BOUND_SAMPLES)];
    first.copy_from_slice(&samples[..first.len()]);
    first.sort_unstable_by(f64::total_cmp);
    let gaps = first.windows(2).map(|pair| pair[1] - pair[0]);
    let sure = gaps.filter(|gap| *gap > MIN_STEP_OVER_RANGE * extent.range());
    let step = sure.fold(f64::INFINITY, f64::min);
    (CLIP_DEPTH_STEPS * step).max(MIN_CLIP_DEPTH_OVER_RANGE * extent.range())
}

/// Depth at which a sample counts as clipped, from a few samples.
fn clip_depth(few: &[f64], extent: &Extent) -> f64 {
    (CLIP_DEPTH_STEPS * converter_step(few)).max(MIN_CLIP_DEPTH_OVER_RANGE * extent.range())
}

/// The upper half of one side of a record.
struct UpperHalf {
    /// 1 or -1.
    sign: f64,
    /// The extreme times the sign.
    highest: f64,
    /// How far each sample is below the extreme.
    below: Vec<f64>,
    /// From the mean to the extreme.
    height: f64,
}

impl UpperHalf {
    /// Of the positive or the negative side; `None` where that is but the level of a pulse of the
    /// other.
    fn of(samples: &[f64], sign: f64, extent: &Extent) -> Option<Self> {
        let highest = (sign * extent.hi).max(sign * extent.lo);
        let height = highest - sign * extent.sum / samples.len() as f64;
        // An extreme less than half as far from the mean as the other is none.
        if height < 0.5 * (extent.range() - height) {
            return None;
        }
        let near = |x: &&f64| highest - sign * **x <= 0.5 * height;
        let any = |piece: &&[f64]| piece.iter().fold(false, |any, x| any | near(&x));
        let below = samples
            .chunks(SAMPLES_PER_BLOCK)
            .filter(any)
            .flatten()
            .filter(near);
        let below = below.map(|x| highest - sign * x).collect();
        Some(Self {
            sign,
            highest,
            below,
            height,
        })
    }

    fn samples(&self) -> impl Iterator<Item = f64> {
        self.below
            .iter()
            .map(|below| self.sign * (self.highest - below))
    }

    /// Samples within `depth` of the extreme, 0 where they do not pile up.
    fn count_clipped(&self, depth: f64) -> usize {
        if self.height <= 2.0 * MIN_COUNTED_DEPTHS * depth {
            return 0;
        }
        let octaves = (0.5 * self.height / (MIN_COUNTED_DEPTHS * depth))
            .log2()
            .floor();
        // By octaves of the depth beyond K = 5.
        let mut by_octave = vec![0usize; octaves as usize + 1];
        for below in &self.below {
            let octave = (below / (MIN_COUNTED_DEPTHS * depth))
                .max(1.0)
                .log2()
                .ceil();
            if let Some(count) = by_octave.get_mut(octave as usize) {
                *count += 1;
            }
        }
        let on = self.below.iter().filter(|below| **below <= depth).count();
        let mut within = 0;
        let mut octaves = by_octave.iter().zip(0..);
        let is_clipped = octaves.any(|(count, octave)| {
            within += count;
            pile_up_probability(on, within, MIN_COUNTED_DEPTHS * 2f64.powi(octave))
                < FALSE_ALARM_PROBABILITY
        });
        if is_clipped { on } else { 0 }
    }
}

/// Probability that `on` or more of `all` samples are within one depth when each is with `1/√K`.
fn pile_up_probability(on: usize, all: usize, depths: f64) -> f64 {
    let share = Binomial::new(depths.sqrt().recip(), all as u64);
    // A share between 0 and 1 is always a distribution; without one nothing is proved.
    share.map_or(1.0, |binomial| binomial.sf(on.saturating_sub(1) as u64))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sine of 1.3 over a little noise, in steps of a converter, clipped at `clip_level`.
    fn record(step: f64, noise: f64, clip_level: f64) -> Vec<f64> {
        let value = |n: u32| {
            let random = (f64::from(n) * 12.9898).sin() * 43_758.545_3;
            let rings = if n < 1100 {
                0.0
            } else {
                1.3 * (0.05 * f64::from(n)).sin()
            };
            let sample = rings + noise * (random - random.floor() - 0.5);
            (sample.clamp(-clip_level, clip_level) / step).round() * step
        };
        (0..8192).map(value).collect()
    }

    #[test]
    fn the_bound_at_a_glance_is_never_below_the_depth() {
        let mut bounds = 0;
        for step in [1e-2, 3e-4, 1e-6, 1e-9, 1e-12] {
            for noise in [0.0, 1e-9, 1e-7, 1e-5, 1e-3, 0.1] {
                let samples = record(step, noise, 10.0);
                let extent = Extent::of(&samples);
                let bound = max_clip_depth(&samples, &extent);
                bounds += usize::from(bound.is_finite());
                for few in [STEP_SAMPLES, 3 * STEP_SAMPLES] {
                    let depth = clip_depth(&samples[..few], &extent);
                    assert!(bound >= depth, "{step} {noise}: {bound} {depth}");
                }
            }
        }
        // Wherever the noise is well above the step or the gaps that count.
        assert!(bounds >= 8, "{bounds}");
    }

    #[test]
    fn samples_that_pass_the_quick_check_are_no_overload() {
        for step in [1e-3, 1e-5, 1e-7] {
            for noise in [1e-5, 1e-3, 1e-2] {
                let assess = |clip_level| {
                    let samples = record(step, noise, clip_level);
                    let limits = HitQualityLimits::default();
                    overload(&samples, &Extent::of(&samples), None, &limits).outcome
                };
                assert_eq!(assess(1.2), Outcome::Rejected, "{step} {noise}");
                assert_eq!(assess(10.0), Outcome::Passed, "{step} {noise}");
            }
        }
    }
}
