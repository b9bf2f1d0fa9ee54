//! The limits of all rules, each with its reason.

use super::super::{ONSET_FRACTION, SignalError};

/// Limits of the rules. Ratios are fractions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HitQualityLimits {
    /// Second over first contact from which a hit is rejected.
    pub double_hit_ratio: f64,
    /// Second over first contact from which it is noted.
    pub double_hit_noted: f64,
    /// Detectability below which a contact of `double_hit_ratio` cannot be decided.
    pub least_detectability: f64,
    /// False alarms of the search for a second contact, per hit in white noise.
    pub double_hit_false_alarms: f64,
    /// Minimum number of clipped samples of an overload.
    pub overload_samples: usize,
    /// Peak over median of the series, or its inverse, from which a hit is noted.
    pub level_noted: f64,
    /// The same, from which it is rejected.
    pub level_rejected: f64,
    /// Rms of the force before the hit over the peak.
    pub force_pre_trigger: f64,
    /// Ringing before the hit over the response after it, from which it is noted.
    pub ringing_noted: f64,
    /// The same, from which it is rejected.
    pub ringing_rejected: f64,
    /// Amplitude at the end of the record over the maximum.
    pub decay: f64,
    /// Fall of the force spectrum inside the band, dB.
    pub roll_off_db: f64,
    /// Largest excursion of offset and drift over the peak.
    pub drift: f64,
    /// False alarms of the test for an inconsistent hit, per series.
    pub inconsistency_false_alarms: f64,
    /// Least relative difference of an FRF that is rejected as inconsistent.
    pub inconsistent_difference: f64,
}

impl Default for HitQualityLimits {
    fn default() -> Self {
        Self {
            double_hit_ratio: 0.1, // 1 + r e^(-iωτ) bends the spectrum by -0.9 to +0.8 dB, and a window that cuts it biases H by 10 %
            double_hit_noted: 0.01, // bends it by 0.09 dB, no more than the usual 1 % of a calibration; filter ringing stays below
            least_detectability: 8.0, // 5 standard deviations of threshold and 3 of margin: found with 99.8 %
            double_hit_false_alarms: 5e-4, // a quarter of the 0.2 % allowed: estimated noise and clipped tails need the rest
            overload_samples: 3,           // one or two samples at the extreme are met by chance
            level_noted: 2.0, // 6 dB: where amplitude-dependent stiffness and damping begin to show in practice
            level_rejected: 10.0, // H1 weighs by |F|²: 1 % of the average or all of it, and 20 dB of noise
            force_pre_trigger: ONSET_FRACTION, // above it the pulse cannot be placed
            ringing_noted: 0.01,  // 1 % of H, 0.09 dB
            ringing_rejected: 0.1, // 10 % of H in the worst phase, 0.9 dB
            decay: 0.01, // truncation leaks 1 % of the amplitude: the usual rule for an exponential window
            roll_off_db: 20.0, // below it noise counts ten times as much as at the maximum
            drift: 0.01, // what a rectangle of 1 % adds to the lowest lines
            inconsistency_false_alarms: 1e-4, // one good hit in 10,000 series
            inconsistent_difference: 0.2, // 14 dB below the FRF; another point or direction differs by about its whole
        }
    }
}

impl HitQualityLimits {
    /// Checks the limits.
    ///
    /// # Errors
    /// [`SignalError::HitQualityLimit`] for a limit that is not positive and finite, a probability
    /// of 1 or more, a factor of a level that is not above 1, and a limit of rejection below that
    /// of a note.
    pub fn validate(&self) -> Result<(), SignalError> {
        let positive = |got: f64| got > 0.0 && got.is_finite();
        let probability = |got: f64| positive(got) && got < 1.0;
        let at_least = |got: f64, least: f64| got.is_finite() && got >= least;
        let rows = [
            row("double_hit_noted", self.double_hit_noted, positive),
            row("double_hit_ratio", self.double_hit_ratio, |v| {
                at_least(v, self.double_hit_noted)
            }),
            row("least_detectability", self.least_detectability, positive),
            row(
                "double_hit_false_alarms",
                self.double_hit_false_alarms,
                probability,
            ),
            row("overload_samples", self.overload_samples as f64, |v| {
                at_least(v, 2.0)
            }),
            row("level_noted", self.level_noted, |v| at_least(v, 1.0)),
            row("level_rejected", self.level_rejected, |v| {
                at_least(v, self.level_noted)
            }),
            row("force_pre_trigger", self.force_pre_trigger, positive),
            row("ringing_noted", self.ringing_noted, positive),
            row("ringing_rejected", self.ringing_rejected, |v| {
                at_least(v, self.ringing_noted)
            }),
            row("decay", self.decay, positive),
            row("roll_off_db", self.roll_off_db, positive),
            row("drift", self.drift, positive),
            row(
                "inconsistency_false_alarms",
                self.inconsistency_false_alarms,
                probability,
            ),
            row(
                "inconsistent_difference",
                self.inconsistent_difference,
                positive,
            ),
        ];
        let bad = rows.into_iter().find(|(_, _, inside)| !inside);
        bad.map_or(Ok(()), |(parameter, got, _)| {
            Err(SignalError::HitQualityLimit { parameter, got })
        })
    }
}

fn row(name: &'static str, got: f64, inside: impl Fn(f64) -> bool) -> (&'static str, f64, bool) {
    (name, got, inside(got))
}
