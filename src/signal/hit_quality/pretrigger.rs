//! Samples before the hit show ringing, dead channels and a reversed force, and give the noise of
//! each channel.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::super::pulse::MIN_PRETRIGGER_SAMPLES;
use super::super::{PretriggerNoise, Pulse};
use super::HitQualityLimits;
use super::check::{Check, Outcome, Rule, compare_with_limit};

/// Longest lag of the autocorrelation, samples: a ringing of up to 100 samples a period shows in
/// it.
const MAX_LAG_SAMPLES: usize = 50;
/// Linear-phase filters answer a pulse before it comes; so many samples before the onset are not
/// assessed.
const PRECURSOR_SAMPLES: usize = 32;
/// Probability with which white noise passes for ringing: one in 10,000 channels.
const RINGING_FALSE_ALARM_PROBABILITY: f64 = 1e-4;
/// Standard deviations of a variance ratio that count as above the noise: below one in 10,000 for 8
/// samples and more.
pub(super) const MAX_VARIANCE_RATIO_STDS: f64 = 5.0;

/// Deviation of noise in which up to a tenth of the samples are something else.
///
/// Root of the mean square of the 90 % smallest, over that of a Gaussian cut there: `1 - 2 q
/// φ(q)/0.9 = 0.6229`, `q = 1.6449`.
pub(super) fn trimmed_deviation(samples: impl Iterator<Item = f64>) -> f64 {
    let mut squares: Vec<f64> = samples.map(|x| x * x).collect();
    let kept = squares.len() * 9 / 10;
    if kept == 0 {
        return 0.0;
    }
    squares.select_nth_unstable_by(kept, f64::total_cmp);
    (squares[..kept].iter().sum::<f64>() / kept as f64 / 0.6229).sqrt()
}

/// Step of the converter: the least distance of two different samples; 0 for a constant.
///
/// Samples that are on no raster give a distance that is small against their noise and then does
/// not matter.
pub(super) fn converter_step(samples: &[f64]) -> f64 {
    let mut sorted = samples.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let range = sorted
        .last()
        .zip(sorted.first())
        .map_or(0.0, |(a, b)| a - b);
    // Equal codes times a factor differ by rounding alone.
    let rounding = 1e-9 * range;
    let steps = sorted.windows(2).map(|pair| pair[1] - pair[0]);
    let least = steps.filter(|step| *step > rounding).min_by(f64::total_cmp);
    least.unwrap_or(0.0)
}

/// Rms of the force before the hit over the peak.
pub(super) fn force_pre_trigger(
    force_n: &[f64],
    pulse: &Pulse,
    limits: &HitQualityLimits,
) -> Check {
    let limit = limits.force_pre_trigger;
    match PretriggerNoise::of(&force_n[pulse.pretrigger_samples()]) {
        Some(pretrigger) => {
            let value = pretrigger.variance.sqrt() / pulse.height_n.abs();
            let outcome = compare_with_limit(value, limit, Outcome::Noted);
            Check::new(Rule::PreTrigger, outcome).value(value, limit, "")
        }
        None => Check::new(Rule::PreTrigger, Outcome::NotDecidable),
    }
}

/// Ringing before the hit over the response just after it: by how much it bends H in the worst
/// phase.
///
/// The power of what is autocorrelated before the hit is `sqrt(2 (mean r_k² - s⁴/n))` over lags k
/// up to n/4: a sine of power P has `r_k = P cos(ωk)`, white noise `E r_k² = s⁴/n`. Its root over
/// the rms of as many samples after the onset is the value; both decay alike. What white noise
/// explains ([`RINGING_FALSE_ALARM_PROBABILITY`]) has passed, where the limit could have been seen.
///
/// # Reference
/// Box and Pierce (1970), J. Amer. Statist. Assoc. 65, eq. 1.3 (`n Σ r_k²/r_0²` is chi squared).
pub(super) fn response_pre_trigger(
    response: &[f64],
    pulse: &Pulse,
    limits: &HitQualityLimits,
) -> Check {
    let end = pulse.pretrigger_samples().end;
    let pretrigger = &response[..end - PRECURSOR_SAMPLES.min(end / 4)];
    let after = &response[pulse.onset..(pulse.onset + pretrigger.len()).min(response.len())];
    if pretrigger.len() < 2 * MIN_PRETRIGGER_SAMPLES || after.is_empty() {
        return Check::new(Rule::PreTrigger, Outcome::NotDecidable);
    }
    let ringing = Ringing::of(pretrigger);
    let level = rms_about(after, ringing.mean).max(f64::MIN_POSITIVE);
    let value = ringing.power.sqrt() / level;
    let outcome = if ringing.significant && value > limits.ringing_rejected {
        Outcome::Rejected
    } else if ringing.significant && value > limits.ringing_noted {
        Outcome::Noted
    } else if ringing.least_power.sqrt() / level > limits.ringing_rejected {
        Outcome::NotDecidable
    } else {
        Outcome::Passed
    };
    let limit = match outcome {
        Outcome::Noted => limits.ringing_noted,
        _ => limits.ringing_rejected,
    };
    Check::new(Rule::PreTrigger, outcome).value(value, limit, "")
}

struct Ringing {
    mean: f64,
    power: f64,
    /// The minimum power that is detected in the noise.
    least_power: f64,
    significant: bool,
}

impl Ringing {
    fn of(pretrigger: &[f64]) -> Self {
        let n = pretrigger.len() as f64;
        let mean = pretrigger.iter().sum::<f64>() / n;
        let lags = (pretrigger.len() / 4).min(MAX_LAG_SAMPLES);
        let covariance = |lag: usize| {
            let pairs = pretrigger.iter().zip(&pretrigger[lag..]);
            pairs.map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>() / n
        };
        let noise = covariance(0).powi(2) / n;
        let square = (1..=lags).map(|k| covariance(k).powi(2)).sum::<f64>() / lags as f64;
        // Infallible for one lag and more; without a distribution nothing is detected.
        let quantile = ChiSquared::new(lags as f64).map_or(f64::INFINITY, |chi| {
            chi.inverse_cdf(1.0 - RINGING_FALSE_ALARM_PROBABILITY) / lags as f64
        });
        Self {
            mean,
            power: (2.0 * (square - noise).max(0.0)).sqrt(),
            least_power: (2.0 * noise * (quantile - 1.0)).sqrt(),
            significant: square > noise * quantile,
        }
    }
}

pub(super) fn rms_about(samples: &[f64], mean: f64) -> f64 {
    let sum: f64 = samples.iter().map(|x| (x - mean).powi(2)).sum();
    (sum / samples.len().max(1) as f64).sqrt()
}

/// A force whose peak is no more than noise: `|height| / σ` against `sqrt(2 ln N) + 2`, two above
/// what N samples reach.
pub(super) fn dead_force(force_n: &[f64], pulse: &Pulse) -> Check {
    let Some(pretrigger) = PretriggerNoise::of(&force_n[pulse.pretrigger_samples()]) else {
        return Check::new(Rule::Dead, Outcome::NotDecidable);
    };
    let limit = (2.0 * (force_n.len() as f64).ln()).sqrt() + 2.0;
    let noise = pretrigger.variance.sqrt();
    if noise <= 0.0 {
        return Check::new(Rule::Dead, Outcome::Passed);
    }
    let value = pulse.height_n.abs() / noise;
    let outcome = if value > limit {
        Outcome::Passed
    } else {
        Outcome::Rejected
    };
    Check::new(Rule::Dead, outcome).value(value, limit, "")
}

/// A response that is constant, or nowhere above its pre-trigger noise.
///
/// The value is the largest rms of a sixteenth of the record after the onset over that before the
/// hit; the limit is what the scatter of both explains, `sqrt(1 + 5 sqrt(2/n + 2/m))`.
pub(super) fn dead_response(response: &[f64], pulse: &Pulse) -> Check {
    let constant = response.iter().all(|x| (x - response[0]).abs() <= 0.0);
    if constant {
        return Check::new(Rule::Dead, Outcome::Rejected);
    }
    let Some(pretrigger) = PretriggerNoise::of(&response[pulse.pretrigger_samples()]) else {
        return Check::new(Rule::Dead, Outcome::NotDecidable);
    };
    if pretrigger.variance <= 0.0 {
        return Check::new(Rule::Dead, Outcome::Passed);
    }
    let after = &response[pulse.onset..];
    let part = (after.len() / 16).max(MIN_PRETRIGGER_SAMPLES);
    if after.len() < part {
        return Check::new(Rule::Dead, Outcome::NotDecidable);
    }
    let levels = after
        .chunks_exact(part)
        .map(|x| rms_about(x, pretrigger.mean));
    let value = levels.fold(0.0, f64::max) / pretrigger.variance.sqrt();
    let scatter = (2.0 / pretrigger.samples as f64 + 2.0 / part as f64).sqrt();
    let limit = (1.0 + MAX_VARIANCE_RATIO_STDS * scatter).sqrt();
    let outcome = if value > limit {
        Outcome::Passed
    } else {
        Outcome::Rejected
    };
    Check::new(Rule::Dead, outcome).value(value, limit, "")
}

/// A pulse of negative height, noted: a sensor or a direction is turned.
pub(super) fn force_sign(pulse: &Pulse) -> Check {
    let outcome = if pulse.height_n < 0.0 {
        Outcome::Noted
    } else {
        Outcome::Passed
    };
    Check::new(Rule::Sign, outcome).value(pulse.height_n, 0.0, "N")
}
