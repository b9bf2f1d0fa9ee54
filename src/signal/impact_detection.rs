//! Cutting the hits out of one continuous force record by trigger.
//!
//! It finds where hits are; it does not assess them and changes no sample. A second contact of the
//! hammer stays within the record of its hit.

use std::ops::Range;

use super::SignalError;
use super::pulse::{ONSET_FRACTION, median};

/// Samples over which the level of the force is one median: twenty times the longest usual pulse
/// (200 samples), so that a pulse moves the median by less than a tenth of the noise.
const LEVEL_SAMPLES: usize = 4096;
/// Standard deviation of Gaussian noise over its median absolute deviation, `1/Φ⁻¹(3/4)`.
const STD_OVER_MEDIAN: f64 = 1.482_602_218_505_602;
/// Expected crossings of the trigger level by Gaussian noise alone, over the whole record.
const EXPECTED_FALSE_CROSSINGS: f64 = 1e-3;
/// Noise deviations above which a sample still belongs to a pulse while walking back to its onset:
/// one sample of noise in 740 is as far up, and the walk takes no more than a few.
const MIN_ONSET_STDS: f64 = 3.0;
/// Contacts closer than this are one hit: a hammer is not swung ten times a second, and it bounces
/// within that time.
const MIN_HIT_DISTANCE_S: f64 = 0.1;
/// Contacts closer than this share of the median distance are one hit: a hundred times less than
/// between steady hits.
const BOUNCE_OVER_MEDIAN_DISTANCE: f64 = 0.05;
/// Share of a record that comes before its pulse.
const PRETRIGGER_OVER_LENGTH: f64 = 0.02;
/// Fewest samples before the pulse: twice what a mean and a variance need, less the guard of a rise
/// time.
const MIN_PRETRIGGER_SAMPLES: usize = 16;

const POSITIVE: Accepted = Accepted {
    expected: "a positive finite number",
    above: 0.0,
    below: f64::INFINITY,
};

/// How hits are cut from a continuous record. What is `None` comes from the record.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct TriggerOptions {
    /// Distance of the force from its level that begins a hit, N.
    pub level_n: Option<f64>,
    /// Time before the onset that belongs to the hit, s.
    pub pretrigger_s: Option<f64>,
    /// Length of the record of each hit, pre-trigger included, s.
    pub length_s: Option<f64>,
}

impl TriggerOptions {
    /// Checks the options.
    ///
    /// # Errors
    /// [`SignalError::WindowParameter`] for a level or length that is not positive, a pre-trigger
    /// below zero or not shorter than the length.
    pub fn validate(&self) -> Result<(), SignalError> {
        let longest = self.length_s.unwrap_or(f64::INFINITY);
        check_parameter("level_n", self.level_n, "N", POSITIVE)?;
        check_parameter("length_s", self.length_s, "s", POSITIVE)?;
        // The interval is open, so that its lower end lies below the 0 that is accepted.
        let pretrigger = Accepted {
            expected: "0 or more, less than the length",
            above: -f64::MIN_POSITIVE,
            below: longest,
        };
        check_parameter("pretrigger_s", self.pretrigger_s, "s", pretrigger)
    }
}

/// The open interval of the accepted values of a parameter.
#[derive(Clone, Copy)]
struct Accepted {
    /// The interval in words, for the error.
    expected: &'static str,
    above: f64,
    below: f64,
}

/// A stated value must lie in its interval.
fn check_parameter(
    parameter: &'static str,
    value: Option<f64>,
    unit: &'static str,
    accepted: Accepted,
) -> Result<(), SignalError> {
    match value.filter(|v| !(*v > accepted.above && *v < accepted.below)) {
        None => Ok(()),
        Some(got) => Err(SignalError::WindowParameter {
            parameter,
            got,
            unit,
            expected: accepted.expected,
        }),
    }
}

/// The record of one hit within the continuous one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Its samples.
    pub range: Range<usize>,
    /// First sample of its pulse, of the continuous record.
    pub onset: usize,
}

/// The hits of a continuous record, all of one length.
#[derive(Clone, Debug, PartialEq)]
pub struct Segments {
    /// Hits in order of time.
    pub segments: Vec<Segment>,
    /// Hits left out because the recording ends before their record does.
    pub cut_off: usize,
    /// Hits left out because the recording begins less than the pre-trigger before them.
    pub too_early: usize,
    /// Distance from the level of the force that began a hit, N; negative when the pulses are.
    pub level_n: f64,
    /// Noise of the force: 1.4826 times its median absolute deviation, N.
    pub noise_n: f64,
}

/// Cuts the hits from a continuous force record.
///
/// The force is taken from a running median (offset, drift). Pulses have the sign of the largest
/// sample. The trigger level is stated, or the larger of 5 % of the largest pulse (a hit ten times
/// weaker stands at twice the level; cross-talk and the ringing of filters are below it) and `σ√(2
/// ln(N/0.001))`, which Gaussian noise of `N` samples reaches less than once in a thousand records.
/// Contacts less than 0.1 s or 5 % of the median distance after the one before belong to its hit;
/// with a stated length, all within the record of the hit before. Without a stated length the
/// length is the smallest distance of two hits, or the samples after the last hit where that uses
/// more of the recording than leaving the last hit out. The pre-trigger is stated, or 2 % of the
/// length, at least 16 samples, but no more than lies between a hit and the contact before it.
///
/// # Errors
/// [`SignalError::WindowParameter`] for an option or time step out of range, a length of less than
/// two samples or beyond the record, and a pre-trigger that reaches back into the contact before;
/// [`SignalError::ForceNotFinite`]; [`SignalError::NoHit`] when nothing stands above the trigger
/// level.
pub fn segments(
    force_n: &[f64],
    step_s: f64,
    options: &TriggerOptions,
) -> Result<Segments, SignalError> {
    check_arguments(force_n, step_s, options)?;
    let trigger = Trigger::new(force_n, options.level_n)?;
    let contacts = trigger.contacts();
    let samples = |s: f64| (s / step_s).round() as usize;
    let length = options.length_s.map(samples);
    let hits = match length {
        Some(length) => group_contacts(&contacts, |hit, contact, _| contact - hit < length),
        None => group_by_distance(&contacts, samples(MIN_HIT_DISTANCE_S)),
    };
    let plan = HitPositions {
        quiet: min_quiet_samples(&contacts, &hits),
        hits: hits.iter().map(|hit| contacts[hit.start].start).collect(),
        end: force_n.len(),
    };
    let stated = options.pretrigger_s.map(samples);
    let length = length.unwrap_or_else(|| plan.common_length(stated));
    let pretrigger = plan.pretrigger(length, stated, step_s)?;
    Ok(plan.cut(length, pretrigger, &trigger))
}

/// All argument checks.
fn check_arguments(
    force_n: &[f64],
    step_s: f64,
    options: &TriggerOptions,
) -> Result<(), SignalError> {
    options.validate()?;
    check_parameter("step_s", Some(step_s), "s", POSITIVE)?;
    let longest = (force_n.len() as f64 + 0.5) * step_s;
    let length = Accepted {
        expected: "two samples or more, no more than the recording",
        above: 1.5 * step_s,
        below: longest,
    };
    check_parameter("length_s", options.length_s, "s", length)?;
    match force_n.iter().position(|v| !v.is_finite()) {
        Some(sample) => Err(SignalError::ForceNotFinite {
            sample,
            got: force_n[sample],
        }),
        None => Ok(()),
    }
}

/// The force without its level, turned so that pulses are positive, and the level that begins one.
struct Trigger {
    force: Vec<f64>,
    sign: f64,
    noise_n: f64,
    level_n: f64,
}

impl Trigger {
    fn new(force_n: &[f64], level_n: Option<f64>) -> Result<Self, SignalError> {
        let mut force = without_level(force_n);
        let extreme = force
            .iter()
            .copied()
            .max_by(|a, b| a.abs().total_cmp(&b.abs()));
        let largest_n = extreme.unwrap_or(0.0);
        let sign = 1f64.copysign(largest_n);
        let distances: Vec<f64> = force.iter().map(|f| f.abs()).collect();
        let noise_n = STD_OVER_MEDIAN * median(&distances).unwrap_or(0.0);
        let crossings = (force.len().max(1) as f64 / EXPECTED_FALSE_CROSSINGS).ln();
        let of_noise = noise_n * (2.0 * crossings).sqrt();
        let level = level_n.unwrap_or((ONSET_FRACTION * largest_n.abs()).max(of_noise));
        if largest_n.abs() <= level {
            return Err(SignalError::NoHit {
                largest_n,
                noise_n,
                level_n: level,
            });
        }
        force.iter_mut().for_each(|f| *f *= sign);
        Ok(Self {
            force,
            sign,
            noise_n,
            level_n: level,
        })
    }

    /// Contacts: intervals above the level, each from its onset to its last sample above the level,
    /// in order.
    fn contacts(&self) -> Vec<Range<usize>> {
        let mut contacts = Vec::new();
        let mut sample = 0;
        while sample < self.force.len() {
            let above = self.force[sample..]
                .iter()
                .take_while(|f| **f > self.level_n);
            let end = sample + above.count();
            if end > sample {
                let before = contacts.last().map_or(0, |last: &Range<usize>| last.end);
                contacts.push(self.onset(before, sample..end)..end);
            }
            sample = end + 1;
        }
        contacts
    }

    /// Walking back from where the level is crossed, the last sample above 5 % of the peak and
    /// above the noise, not before the end of the contact before.
    fn onset(&self, before: usize, above: Range<usize>) -> usize {
        let peak = self.force[above.clone()]
            .iter()
            .copied()
            .fold(0.0, f64::max);
        let least = (ONSET_FRACTION * peak).max(MIN_ONSET_STDS * self.noise_n);
        let rise = self.force[before..above.start].iter().rev();
        above.start - rise.take_while(|f| **f > least).count()
    }
}

/// The force less the medians of blocks, interpolated linearly between their middles and continued
/// to the ends.
fn without_level(force_n: &[f64]) -> Vec<f64> {
    let blocks = (force_n.len() / LEVEL_SAMPLES).max(1);
    let length = force_n.len().div_ceil(blocks).max(1);
    let levels: Vec<f64> = force_n.chunks(length).filter_map(median).collect();
    let level = |sample: usize| {
        let position = (sample as f64 + 0.5) / length as f64 - 0.5;
        let last = levels.len() - 1;
        let left = (position.max(0.0) as usize).min(last.saturating_sub(1));
        let share = position - left as f64;
        levels[left] + share * (levels[(left + 1).min(last)] - levels[left])
    };
    let samples = force_n.iter().enumerate();
    samples.map(|(sample, f)| f - level(sample)).collect()
}

/// Hits as ranges of contacts: a contact belongs to the hit before when `same(onset of the hit,
/// onset of the contact, onset of the contact before)`.
fn group_contacts(
    contacts: &[Range<usize>],
    same: impl Fn(usize, usize, usize) -> bool,
) -> Vec<Range<usize>> {
    let mut hits: Vec<Range<usize>> = Vec::new();
    for (i, contact) in contacts.iter().enumerate() {
        match hits.last_mut() {
            Some(hit)
                if same(
                    contacts[hit.start].start,
                    contact.start,
                    contacts[i - 1].start,
                ) =>
            {
                hit.end = i + 1;
            }
            _ => hits.push(i..i + 1),
        }
    }
    hits
}

/// Hits without a stated length: contacts `closest` apart are one, then those much closer than the
/// median distance.
fn group_by_distance(contacts: &[Range<usize>], closest: usize) -> Vec<Range<usize>> {
    let near =
        |limit: usize| group_contacts(contacts, move |_, contact, before| contact - before < limit);
    let hits = near(closest);
    let onset = |hit: &Range<usize>| contacts[hit.start].start as f64;
    let distances: Vec<f64> = hits
        .windows(2)
        .map(|w| onset(&w[1]) - onset(&w[0]))
        .collect();
    let limit = BOUNCE_OVER_MEDIAN_DISTANCE * median(&distances).unwrap_or(0.0);
    near(closest.max(limit as usize))
}

/// Fewest samples between a hit and the contact before it; `None` for a single hit.
fn min_quiet_samples(contacts: &[Range<usize>], hits: &[Range<usize>]) -> Option<usize> {
    let first = hits.iter().skip(1).map(|hit| hit.start);
    first.map(|c| contacts[c].start - contacts[c - 1].end).min()
}

/// Positions of the hits, from which length and pre-trigger follow.
struct HitPositions {
    /// Onsets of the hits.
    hits: Vec<usize>,
    quiet: Option<usize>,
    end: usize,
}

impl HitPositions {
    /// The smallest distance of two hits, or the samples after the last hit, where all hits of that
    /// length are more samples than all but the last of the other.
    fn common_length(&self, pretrigger: Option<usize>) -> usize {
        let left = self.end - self.hits.last().copied().unwrap_or(self.end);
        let pretrigger = pretrigger.unwrap_or_else(|| {
            let share = PRETRIGGER_OVER_LENGTH / (1.0 - PRETRIGGER_OVER_LENGTH);
            self.limited_pretrigger((share * left as f64) as usize)
        });
        let rest = left + pretrigger;
        let distances = self.hits.windows(2).map(|w| w[1] - w[0]);
        let n = self.hits.len();
        match distances.min() {
            Some(distance) if rest >= distance || n * rest < (n - 1) * distance => distance,
            _ => rest.min(self.end),
        }
    }

    /// Not less than the fewest samples, not more than lie between two hits.
    fn limited_pretrigger(&self, share: usize) -> usize {
        share
            .max(MIN_PRETRIGGER_SAMPLES)
            .min(self.quiet.unwrap_or(usize::MAX))
    }

    fn pretrigger(
        &self,
        length: usize,
        stated: Option<usize>,
        step_s: f64,
    ) -> Result<usize, SignalError> {
        let share = (PRETRIGGER_OVER_LENGTH * length as f64).round() as usize;
        let pretrigger = stated.unwrap_or_else(|| self.limited_pretrigger(share).min(length - 1));
        if pretrigger >= length || self.quiet.is_some_and(|quiet| pretrigger > quiet) {
            return Err(SignalError::WindowParameter {
                parameter: "pretrigger_s",
                got: pretrigger as f64 * step_s,
                unit: "s",
                expected: "less than the length, not back into the contact before",
            });
        }
        Ok(pretrigger)
    }

    /// Every hit whose record lies within the recording.
    fn cut(&self, length: usize, pretrigger: usize, trigger: &Trigger) -> Segments {
        let (early, rest) = self
            .hits
            .split_at(self.hits.partition_point(|onset| *onset < pretrigger));
        let inside = rest.partition_point(|onset| onset - pretrigger + length <= self.end);
        let segment = |onset: &usize| Segment {
            range: onset - pretrigger..onset - pretrigger + length,
            onset: *onset,
        };
        Segments {
            segments: rest[..inside].iter().map(segment).collect(),
            cut_off: rest.len() - inside,
            too_early: early.len(),
            level_n: trigger.sign * trigger.level_n,
            noise_n: trigger.noise_n,
        }
    }
}

#[cfg(test)]
#[path = "impact_detection_tests.rs"]
mod tests;
