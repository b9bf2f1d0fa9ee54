//! Amplitude of a response at the end of the record, and the offset and drift of a channel.

use super::super::pulse::MIN_PRETRIGGER_SAMPLES;
use super::super::{PretriggerNoise, Pulse};
use super::HitQualityLimits;
use super::check::{Check, Outcome, Rule, compare_with_limit};
use super::pretrigger::{MAX_VARIANCE_RATIO_STDS, rms_about};

/// The last part of the record by which its end is assessed, and the first and last by which its
/// drift is: an eighth.
const RECORD_END_DIVISOR: usize = 8;
/// Standard deviations of a drift that count: one in 10^6 by chance.
const MIN_DRIFT_STDS: f64 = 5.0;

/// Amplitude at the end over the maximum: `sqrt(2 (s_end² - σ²)) / max|x|`, s_end the rms of the
/// last eighth.
///
/// σ² is the variance before the hit. Where `s_end² - σ²` is within the scatter of both variances,
/// the value is the largest amplitude that this scatter can hide, and the rule decides only when it
/// is below the limit.
pub(super) fn decay(response: &[f64], pulse: &Pulse, limits: &HitQualityLimits) -> Check {
    let limit = limits.decay;
    let after = &response[pulse.onset..];
    let last = &after[after.len() - after.len() / RECORD_END_DIVISOR..];
    let pretrigger = PretriggerNoise::of(&response[pulse.pretrigger_samples()]);
    let (Some(pretrigger), true) = (pretrigger, last.len() >= MIN_PRETRIGGER_SAMPLES) else {
        return Check::new(Rule::Decay, Outcome::NotDecidable);
    };
    let largest = after.iter().map(|x| (x - pretrigger.mean).abs());
    let largest = largest.fold(f64::MIN_POSITIVE, f64::max);
    let mean = last.iter().sum::<f64>() / last.len() as f64;
    let power = rms_about(last, mean).powi(2);
    let scatter = (2.0 / pretrigger.samples as f64 + 2.0 / last.len() as f64).sqrt();
    let hidden = MAX_VARIANCE_RATIO_STDS * scatter * pretrigger.variance;
    let left = |power: f64| (2.0 * power).sqrt() / largest;
    let above_noise = power - pretrigger.variance > hidden;
    let value = left(if above_noise {
        power - pretrigger.variance
    } else {
        hidden
    });
    let otherwise = if above_noise {
        Outcome::Noted
    } else {
        Outcome::NotDecidable
    };
    Check::new(Rule::Decay, compare_with_limit(value, limit, otherwise)).value(value, limit, "")
}

/// A straight line under a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// At the onset of the hit, SI unit of the channel.
    pub offset: f64,
    /// Slope, SI unit of the channel per second.
    pub slope_per_s: f64,
    /// Standard error of the difference between the end and the start that the slope stands for, SI
    /// unit of the channel.
    pub error: f64,
}

/// Offset and drift of a channel from its mean before the hit and that of the last eighth of the
/// record.
///
/// `None` for fewer than eight samples in either. The line to take off is `offset + slope_per_s
/// (t - t_onset)`. A response that still rings at the end leaves of its amplitude A about `A/(ω
/// T/8)` in the mean.
pub fn drift_of(samples: &[f64], step_s: f64, pulse: &Pulse) -> Option<Drift> {
    let pretrigger = PretriggerNoise::of(samples.get(pulse.pretrigger_samples())?)?;
    let part = samples.len().saturating_sub(pulse.end) / RECORD_END_DIVISOR;
    let last = PretriggerNoise::of(&samples[samples.len() - part..])?;
    let middle = |start: usize, count: usize| start as f64 + 0.5 * (count as f64 - 1.0);
    let from = middle(0, pretrigger.samples);
    let to = middle(samples.len() - part, part);
    let slope = (last.mean - pretrigger.mean) / (to - from);
    let error = (pretrigger.variance / pretrigger.samples as f64
        + last.variance / last.samples as f64)
        .sqrt();
    Some(Drift {
        offset: pretrigger.mean + slope * (pulse.onset as f64 - from),
        slope_per_s: slope / step_s,
        error,
    })
}

/// The larger end of the line over the peak.
fn assess_drift(samples: &[f64], step_s: f64, pulse: &Pulse, peak: f64, limit: f64) -> Check {
    let Some(drift) = drift_of(samples, step_s, pulse) else {
        return Check::new(Rule::Drift, Outcome::NotDecidable);
    };
    let at =
        |sample: f64| drift.offset + drift.slope_per_s * step_s * (sample - pulse.onset as f64);
    let excursion = at(0.0).abs().max(at(samples.len() as f64).abs());
    let value = excursion / peak.max(f64::MIN_POSITIVE);
    let sure = excursion > MIN_DRIFT_STDS * drift.error;
    let otherwise = if sure {
        Outcome::Noted
    } else {
        Outcome::NotDecidable
    };
    Check::new(Rule::Drift, compare_with_limit(value, limit, otherwise)).value(value, limit, "")
}

/// Offset and drift of the force over its peak.
pub(super) fn force_drift(
    force_n: &[f64],
    step_s: f64,
    pulse: &Pulse,
    limits: &HitQualityLimits,
) -> Check {
    assess_drift(force_n, step_s, pulse, pulse.height_n.abs(), limits.drift)
}

/// Offset and drift of a response over its largest value.
pub(super) fn response_drift(
    response: &[f64],
    step_s: f64,
    pulse: &Pulse,
    limits: &HitQualityLimits,
) -> Check {
    let offset = PretriggerNoise::of(&response[pulse.pretrigger_samples()])
        .map_or(0.0, |pretrigger| pretrigger.mean);
    let peak = response.iter().map(|x| (x - offset).abs());
    let peak = peak.fold(0.0, f64::max);
    assess_drift(response, step_s, pulse, peak, limits.drift)
}
