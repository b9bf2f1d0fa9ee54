//! A matched filter with the shape of the measured pulse detects second contacts of the hammer
//! (double hits) in the rest of the force record.
//!
//! The first contact is the template: its samples from two before the onset to two after the end,
//! noise and filter ringing included. The rest of the record, offset and slow drift taken off, is
//! correlated with it,
//!
//! `r_k = Σ x_{k+i} p_i / Σ p_i²`,
//!
//! which is the ratio of a contact at k to the first. In white noise of deviation σ its deviation
//! is `s = σ/sqrt(Σp²)`, and a contact of ratio r has the detectability `d' = r/s`. Found is what
//! exceeds `z s`, z from the number of places and the false alarms allowed. Noise that is not white
//! raises s to the scatter of r itself.
//!
//! A contact is separate from the first when its samples begin after the ringing of the filter:
//! `length/2`, at least 8 samples, after the end of the pulse. For a Chebyshev filter of 16 poles
//! or a Butterworth of 8, edge at 0.4 of the sampling rate, and half sines of 3 to 200 samples what
//! rings later is below 0.002 of the pulse in r; of still shorter ones it is not, so that within 64
//! samples of those a contact counts from a twentieth on. Nearer contacts are found where the force
//! rises again inside the pulse, for pulses of ten samples and more (shorter ones ring as high),
//! see [`least_delay_samples`].
//!
//! # Reference
//! Kay (1998), Fundamentals of Statistical Signal Processing II: Detection Theory, section 4.3
//! (matched filter, d').

use std::ops::Range;

use statrs::distribution::{ContinuousCDF, Normal};

use crate::linalg::vectorised;

use super::super::Pulse;
use super::HitQualityLimits;
use super::check::{Check, Outcome, Rule};
use super::pretrigger::{converter_step, trimmed_deviation};

/// Samples on both sides of the pulse that belong to it: the foot below the onset threshold.
const PULSE_FOOT_SAMPLES: usize = 2;
/// Fewest samples after the pulse in which a steep filter rings above 0.002 of it, see the head.
const MIN_GUARD_SAMPLES: usize = 8;
/// A pulse of less area over height, samples, is hardly more than the response of the filter
/// itself: a half sine of three samples has 1.9, an impulse behind a filter with its edge at 0.4 of
/// the sampling rate 1.25.
const MIN_AREA_OVER_HEIGHT_SAMPLES: f64 = 1.6;
/// The filter rings for so many samples above 0.002 of such a short pulse.
const RINGING_SAMPLES: usize = 64;
/// Beyond the guard samples, the filter rings nowhere above this fraction of a short pulse.
const MAX_RINGING_RATIO: f64 = 0.05;
/// Samples of the pulse after decimation: a half sine keeps all but 0.1 % of its d'.
const TEMPLATE_SAMPLES: usize = 32;
/// The drift is a mean over this many pulse lengths: a contact inside loses 2 % of its d'.
const BASELINE_LENGTHS: usize = 40;
/// Relative deviation of a scale from the median of n magnitudes, times sqrt(n), for Gaussian
/// values.
const MEDIAN_SCALE_SPREAD: f64 = 1.17;
/// Shortest pulse, between its half heights, that does not ring as high as a tenth of it: 9 samples
/// of a half sine.
const MIN_RISE_WIDTH_SAMPLES: usize = 6;
/// Standard deviations of a single difference that no pair of samples of a pulse reaches by chance.
const MIN_RISE_STDS: f64 = 6.0;

/// The least delay, onset to onset in samples, from which the matched filter sees a second contact:
/// the length of the pulse, half of it again (at least 8 samples) for its ringing, and the foot of
/// the second.
pub fn least_delay_samples(pulse: &Pulse) -> usize {
    pulse.end - pulse.onset + guard_samples(pulse) + PULSE_FOOT_SAMPLES
}

fn guard_samples(pulse: &Pulse) -> usize {
    ((pulse.end - pulse.onset) / 2).max(MIN_GUARD_SAMPLES)
}

/// A second contact: how high, where, how clear.
#[derive(Clone, Copy, Debug)]
struct Contact {
    ratio: f64,
    /// Onset to onset, samples.
    delay: f64,
    detectability: f64,
}

/// The rule.
pub(super) fn double_hit(
    force_n: &[f64],
    step_s: f64,
    pulse: &Pulse,
    limits: &HitQualityLimits,
) -> Check {
    let Some((rest, search)) = search_twice(force_n, pulse) else {
        return Check::new(Rule::DoubleHit, Outcome::NotDecidable);
    };
    let least = search.threshold(limits.double_hit_false_alarms);
    let rings = ringing_delays(force_n, pulse);
    let clear = |c: &Contact| {
        c.detectability >= least
            && c.ratio * pulse.height_n.abs() >= rest.converter_step
            && !(c.ratio < MAX_RINGING_RATIO && rings.contains(&c.delay))
    };
    let separate = search.clearest_contact();
    let near = rest
        .second_rise(pulse, limits.double_hit_ratio)
        .map(|near| Contact {
            detectability: near.ratio / search.scale,
            ..near
        });
    let found = separate.into_iter().filter(clear).chain(near);
    let found = found.max_by(|a, b| a.ratio.total_cmp(&b.ratio));
    let check = |outcome, value: f64| {
        let limit = match outcome {
            Outcome::Noted => limits.double_hit_noted,
            _ => limits.double_hit_ratio,
        };
        Check::new(Rule::DoubleHit, outcome).value(value, limit, "")
    };
    match found {
        Some(contact) => Check {
            at: Some(contact.delay * step_s),
            detectability: Some(contact.detectability),
            ..check(outcome_of_contact(contact.ratio, limits), contact.ratio)
        },
        None => Check {
            detectability: Some(limits.double_hit_ratio / search.scale),
            ..check(
                outcome_without_contact(&search, &rest, pulse, limits),
                separate.map_or(0.0, |c| c.ratio),
            )
        },
    }
}

/// Delays at which what follows a pulse may be the ringing of the filter; none for a pulse that is
/// longer than its response.
fn ringing_delays(force_n: &[f64], pulse: &Pulse) -> Range<f64> {
    let samples = &force_n[pulse.onset..pulse.end];
    let area: f64 = samples.iter().map(|f| f - pulse.level_n).sum();
    let end = if area / pulse.height_n < MIN_AREA_OVER_HEIGHT_SAMPLES {
        (samples.len() + RINGING_SAMPLES) as f64
    } else {
        0.0
    };
    0.0..end
}

/// Looks twice: a high contact pulls the level of the whole record, so that the second look leaves
/// the place of the first out of it.
fn search_twice(force_n: &[f64], pulse: &Pulse) -> Option<(ForceAfterImpact, ContactSearch)> {
    let first = MatchedFilter::new(&LevelFree::new(force_n, pulse, 0..0), pulse)?;
    let delay = first.places[first.clearest()?].delay;
    let onset = (pulse.onset as f64 + delay).max(0.0) as usize;
    let place = onset.saturating_sub(PULSE_FOOT_SAMPLES)
        ..onset + pulse.end - pulse.onset + guard_samples(pulse);
    let rest = ForceAfterImpact::new(force_n, LevelFree::new(force_n, pulse, place));
    let search = ContactSearch::new(&rest, pulse)?;
    Some((rest, search))
}

fn outcome_of_contact(ratio: f64, limits: &HitQualityLimits) -> Outcome {
    if ratio >= limits.double_hit_ratio {
        Outcome::Rejected
    } else if ratio >= limits.double_hit_noted {
        Outcome::Noted
    } else {
        Outcome::Passed
    }
}

/// Passed when a contact of the limit's ratio would have been seen.
fn outcome_without_contact(
    search: &ContactSearch,
    rest: &ForceAfterImpact,
    pulse: &Pulse,
    limits: &HitQualityLimits,
) -> Outcome {
    let ratio = limits.double_hit_ratio;
    let seen = ratio / search.scale >= limits.least_detectability
        && ratio * pulse.height_n.abs() >= rest.converter_step;
    if seen {
        Outcome::Passed
    } else {
        Outcome::NotDecidable
    }
}

/// The force turned to positive pulses, without offset and slow drift.
struct LevelFree {
    force_n: Vec<f64>,
    /// First sample and first sample after what belongs to the first contact.
    first_contact: (usize, usize),
}

impl LevelFree {
    /// The samples of `place` are left out of the level.
    fn new(force_n: &[f64], pulse: &Pulse, place: Range<usize>) -> Self {
        let first_contact = (
            pulse.onset.saturating_sub(guard_samples(pulse)),
            (pulse.end + guard_samples(pulse)).min(force_n.len()),
        );
        let sign = pulse.height_n.signum();
        let half = BASELINE_LENGTHS / 2 * (pulse.end - pulse.onset);
        let sides = RecordSides {
            len: force_n.len(),
            first_contact,
            place,
        };
        let mut force_n: Vec<f64> = force_n.iter().map(|f| sign * f).collect();
        sides.take_slope_off(&mut force_n);
        sides.take_level_off(&mut force_n, half);
        Self {
            force_n,
            first_contact,
        }
    }
}

/// The record after the first contact, with its noise.
struct ForceAfterImpact {
    level_free: LevelFree,
    noise_n: f64,
    converter_step: f64,
}

impl ForceAfterImpact {
    fn new(force_n: &[f64], level_free: LevelFree) -> Self {
        let (first, end) = level_free.first_contact;
        let quiet = level_free.force_n[..first].iter();
        let quiet = quiet.chain(&level_free.force_n[end..]);
        let converter_step = converter_step(force_n);
        // Rounding has the variance of a uniform error of one step, also where it hides the noise.
        let noise_n = trimmed_deviation(quiet.copied()).max(converter_step / 12f64.sqrt());
        Self {
            level_free,
            noise_n,
            converter_step,
        }
    }

    /// The highest place after a valley on either side of the peak, nearer than the matched filter
    /// looks.
    fn second_rise(&self, pulse: &Pulse, ratio: f64) -> Option<Contact> {
        let LevelFree {
            force_n,
            first_contact,
        } = &self.level_free;
        let height = force_n[pulse.peak];
        // At half its height: the ringing of a filter lengthens the foot of a short pulse, not its
        // middle.
        let high = |k: &usize| force_n[*k] / height > 0.5;
        let before = (first_contact.0..pulse.peak).rev().take_while(high).count();
        let after = (pulse.peak..first_contact.1).take_while(high).count();
        if before + after < MIN_RISE_WIDTH_SAMPLES {
            return None;
        }
        let least = ratio * height + MIN_RISE_STDS * self.noise_n;
        let later = highest_rise(pulse.peak..first_contact.1, force_n, least);
        let earlier = highest_rise((first_contact.0..pulse.peak).rev(), force_n, least);
        let found = later.into_iter().chain(earlier);
        let place = found.max_by(|a, b| force_n[*a].total_cmp(&force_n[*b]))?;
        Some(Contact {
            ratio: force_n[place] / height,
            delay: place as f64 - pulse.peak as f64,
            detectability: 0.0,
        })
    }
}

/// The highest place that stands `least` above the lowest before it on the way, and above zero by
/// as much.
fn highest_rise(way: impl Iterator<Item = usize>, samples: &[f64], least: f64) -> Option<usize> {
    let (mut lowest, mut best): (f64, Option<usize>) = (f64::INFINITY, None);
    for k in way {
        lowest = lowest.min(samples[k]);
        let high = samples[k] - lowest.max(0.0) >= least;
        if high && best.is_none_or(|b| samples[k] > samples[b]) {
            best = Some(k);
        }
    }
    best
}

/// The samples before and after the first contact, less those of a place that is not level.
struct RecordSides {
    len: usize,
    first_contact: (usize, usize),
    place: Range<usize>,
}

impl RecordSides {
    fn sides(&self) -> [Range<usize>; 2] {
        [0..self.first_contact.0, self.first_contact.1..self.len]
    }

    fn is_level(&self, k: usize) -> bool {
        !self.place.contains(&k)
    }

    /// Takes the common slope of both sides off all samples; between them the level may step, as a
    /// coupled amplifier makes it.
    fn take_slope_off(&self, samples: &mut [f64]) {
        let (mut cross, mut square) = (0.0, 0.0);
        for side in self.sides() {
            let level: Vec<usize> = side.filter(|k| self.is_level(*k)).collect();
            let count = level.len().max(1) as f64;
            let middle = level.iter().map(|k| *k as f64).sum::<f64>() / count;
            let mean = level.iter().map(|k| samples[*k]).sum::<f64>() / count;
            for k in level {
                let from_middle = k as f64 - middle;
                cross += from_middle * (samples[k] - mean);
                square += from_middle * from_middle;
            }
        }
        if square > 0.0 {
            let slope = cross / square;
            let each = samples.iter_mut().enumerate();
            each.for_each(|(k, sample)| *sample -= slope * k as f64);
        }
    }

    /// Takes the mean over `half` samples to each side off every sample, never across the pulse;
    /// there the mean of its two ends.
    fn take_level_off(&self, samples: &mut [f64], half: usize) {
        let mut level = vec![0.0; samples.len()];
        for side in self.sides() {
            let means = self.running_means(samples, side.clone(), half);
            level[side].copy_from_slice(&means);
        }
        let ends = [
            self.first_contact.0.checked_sub(1),
            Some(self.first_contact.1),
        ];
        let ends = ends.iter().flatten().filter_map(|k| level.get(*k));
        let between = ends.clone().sum::<f64>() / ends.count().max(1) as f64;
        level[self.first_contact.0..self.first_contact.1].fill(between);
        samples.iter_mut().zip(&level).for_each(|(x, l)| *x -= l);
    }

    fn running_means(&self, samples: &[f64], side: Range<usize>, half: usize) -> Vec<f64> {
        let mut sums = vec![(0.0, 0usize)];
        let (mut sum, mut count) = (0.0, 0);
        for k in side.clone() {
            if self.is_level(k) {
                (sum, count) = (sum + samples[k], count + 1);
            }
            sums.push((sum, count));
        }
        let mean = |k: usize| {
            let (lo, hi) = (
                sums[k.saturating_sub(half)],
                sums[(k + half + 1).min(side.len())],
            );
            (hi.0 - lo.0) / (hi.1 - lo.1).max(1) as f64
        };
        (0..side.len()).map(mean).collect()
    }
}

/// Output of the matched filter where the template would begin.
#[derive(Clone, Copy)]
struct FilterOutput {
    ratio: f64,
    /// Samples after the first contact.
    delay: f64,
    /// Deviation of the ratio over that with a known level: few samples beside a contact know the
    /// level badly.
    spread: f64,
}

/// The matched filter over the record after the first contact.
struct MatchedFilter {
    places: Vec<FilterOutput>,
    /// `Σp²` of the template.
    energy: f64,
    decimation: f64,
}

impl MatchedFilter {
    fn new(level_free: &LevelFree, pulse: &Pulse) -> Option<Self> {
        let decimation = ((pulse.end - pulse.onset) / TEMPLATE_SAMPLES).max(1);
        let LevelFree {
            force_n,
            first_contact,
        } = level_free;
        let first = pulse.onset.saturating_sub(PULSE_FOOT_SAMPLES);
        let template = decimate(
            &force_n[first..(pulse.end + PULSE_FOOT_SAMPLES).min(force_n.len())],
            decimation,
        );
        let energy: f64 = template.iter().map(|p| p * p).sum();
        let sum: f64 = template.iter().sum();
        let mut places = Vec::new();
        for (start, end) in [(0, first_contact.0), (first_contact.1, force_n.len())] {
            let segment = decimate(&force_n[start..end], decimation);
            let beside = segment.len().saturating_sub(template.len()).max(1) as f64;
            let spread = (1.0 + sum * sum / (energy * beside)).sqrt();
            let products = template_products(&segment, &template).into_iter();
            places.extend(products.enumerate().map(|(k, product)| FilterOutput {
                ratio: product / energy,
                delay: (start + k * decimation) as f64 - first as f64,
                spread,
            }));
        }
        (!places.is_empty() && energy > 0.0).then_some(Self {
            places,
            energy,
            decimation: decimation as f64,
        })
    }

    /// The place of the clearest ratio.
    fn clearest(&self) -> Option<usize> {
        let clear = |k: &usize| self.places[*k].ratio / self.places[*k].spread;
        (0..self.places.len()).max_by(|a, b| clear(a).total_cmp(&clear(b)))
    }

    /// Top of the parabola through a place and its neighbours; the place itself at the end of a
    /// segment.
    fn interpolated_ratio(&self, best: usize) -> f64 {
        let here = self.places[best];
        let neighbours = self.places.get(best.wrapping_sub(1));
        let Some((before, after)) = neighbours.zip(self.places.get(best + 1)) else {
            return here.ratio;
        };
        let bend = 2.0 * here.ratio - before.ratio - after.ratio;
        // Two steps of the decimation, or else the first contact lies between.
        if bend <= 0.0 || after.delay - before.delay > 2.5 * self.decimation {
            return here.ratio;
        }
        here.ratio + (after.ratio - before.ratio).powi(2) / (8.0 * bend)
    }
}

/// The matched filter with the scatter of its output.
struct ContactSearch {
    filter: MatchedFilter,
    /// Standard deviation of the ratio.
    scale: f64,
}

impl ContactSearch {
    fn new(rest: &ForceAfterImpact, pulse: &Pulse) -> Option<Self> {
        let filter = MatchedFilter::new(&rest.level_free, pulse)?;
        let white = rest.noise_n / (filter.decimation * filter.energy).sqrt();
        let length = (pulse.end - pulse.onset) as f64;
        let independent = filter.places.len() as f64 * filter.decimation / length;
        let scatter = median_deviation(&filter.places)
            / (1.0 + 2.0 * MEDIAN_SCALE_SPREAD / independent.sqrt());
        let scale = white.max(scatter).max(f64::MIN_POSITIVE);
        Some(Self { filter, scale })
    }

    /// Standard deviations that white noise exceeds anywhere with this probability.
    fn threshold(&self, false_alarms: f64) -> f64 {
        -Normal::standard().inverse_cdf(false_alarms / self.filter.places.len() as f64)
    }

    /// The clearest ratio, between places by a parabola.
    fn clearest_contact(&self) -> Option<Contact> {
        let best = self.filter.clearest()?;
        let FilterOutput { delay, spread, .. } = self.filter.places[best];
        let ratio = self.filter.interpolated_ratio(best);
        Some(Contact {
            ratio,
            delay,
            detectability: ratio / (self.scale * spread),
        })
    }
}

/// Means of `by` neighbouring samples; a rest is left out.
fn decimate(samples: &[f64], by: usize) -> Vec<f64> {
    let blocks = samples.chunks_exact(by);
    blocks.map(|b| b.iter().sum::<f64>() / by as f64).collect()
}

/// Places whose products are summed together, in the nearest cache.
const PRODUCTS_PER_BLOCK: usize = 512;

/// `Σ x_(k+i) p_i` at every place k where the whole template fits.
fn template_products(samples: &[f64], template: &[f64]) -> Vec<f64> {
    let places = (samples.len() + 1).saturating_sub(template.len());
    let mut sums = vec![0.0; places];
    for (piece, sums) in sums.chunks_mut(PRODUCTS_PER_BLOCK).enumerate() {
        let samples = &samples[piece * PRODUCTS_PER_BLOCK..];
        vectorised(
            #[inline(always)]
            || {
                for (i, p) in template.iter().enumerate() {
                    let samples = &samples[i..i + sums.len()];
                    let each = sums.iter_mut().zip(samples);
                    each.for_each(|(sum, x)| *sum += x * p);
                }
            },
        );
    }
    sums
}

/// 1.4826 times the median magnitude: the deviation of Gaussian values about 0.
fn median_deviation(places: &[FilterOutput]) -> f64 {
    let mut sizes: Vec<f64> = places.iter().map(|place| place.ratio.abs()).collect();
    let half = sizes.len() / 2;
    1.4826 * *sizes.select_nth_unstable_by(half, f64::total_cmp).1
}
