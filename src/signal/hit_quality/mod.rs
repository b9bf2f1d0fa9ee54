//! Rules that decide whether a hit can be trusted: each looks at the samples of one hit, or at one
//! number per hit of a series.
//!
//! Every rule yields a [`Check`] with its value, its limit and an [`Outcome`], also when it passed,
//! so that each hit stays listed with the reason. What the noise does not let a rule decide is
//! [`Outcome::NotDecidable`], never passed. Nothing here removes a hit or changes a sample.
//!
//! | file | rules |
//! |---|---|
//! | `check` | none: [`Check`] and [`Outcome`] of all |
//! | `limits` | none: limits of all rules |
//! | `double_hit` | double hit: filter matched to the shape of the pulse |
//! | `overload` | clipped samples |
//! | `pretrigger` | pre-trigger signal, dead channel, sign |
//! | `decay` | amplitude at the end of the record; offset and drift |
//! | `force_bandwidth` | decrease of the force spectrum inside the band |
//! | `consistency` | level and FRF beside those of the other hits of the series |

mod check;
mod consistency;
mod decay;
mod double_hit;
mod force_bandwidth;
mod limits;
mod overload;
mod pretrigger;

#[cfg(test)]
mod double_hit_tests;
#[cfg(test)]
mod tests;

use crate::dof::Dof;

use super::{Extent, Pulse};

pub use check::{Check, Outcome, Rule};
pub use consistency::{assess_levels, inconsistent_hits};
pub use decay::{Drift, drift_of};
pub use double_hit::least_delay_samples;
pub use limits::HitQualityLimits;

/// The checks of a force, in this order.
const FORCE_RULES: [Rule; 7] = [
    Rule::DoubleHit,
    Rule::Overload,
    Rule::PreTrigger,
    Rule::RollOff,
    Rule::Dead,
    Rule::Sign,
    Rule::Drift,
];

/// The checks of a response, in this order.
const RESPONSE_RULES: [Rule; 5] = [
    Rule::Overload,
    Rule::PreTrigger,
    Rule::Decay,
    Rule::Dead,
    Rule::Drift,
];

/// The checks of a record that does not hold the pulse it is assessed with.
fn undecided(rules: &[Rule], dof: Option<&Dof>) -> Vec<Check> {
    let check = |rule: &Rule| Check {
        dof: dof.cloned(),
        ..Check::new(*rule, Outcome::NotDecidable)
    };
    rules.iter().map(check).collect()
}

/// Assesses the force of one hit: double hit, overload, pre-trigger, roll-off, dead channel, sign,
/// drift.
///
/// `force_n` are the samples before any window, `step_s` their spacing, `pulse` as
/// [`Pulse::locate`] finds it. `full_scale_n` is the range of the channel where it is known,
/// `band_end_hz` the highest frequency of interest. A pulse of another, longer record leaves all of
/// them not decidable.
pub fn assess_force(
    force_n: &[f64],
    step_s: f64,
    pulse: &Pulse,
    full_scale_n: Option<f64>,
    band_end_hz: f64,
    limits: &HitQualityLimits,
) -> Vec<Check> {
    if force_n.len() < pulse.end {
        return undecided(&FORCE_RULES, None);
    }
    vec![
        double_hit::double_hit(force_n, step_s, pulse, limits),
        overload::overload(force_n, &Extent::of(force_n), full_scale_n, limits),
        pretrigger::force_pre_trigger(force_n, pulse, limits),
        force_bandwidth::roll_off(force_n, step_s, pulse, band_end_hz, limits),
        pretrigger::dead_force(force_n, pulse),
        pretrigger::force_sign(pulse),
        decay::force_drift(force_n, step_s, pulse, limits),
    ]
}

/// One response of a hit, before any window.
#[derive(Clone, Copy, Debug)]
pub struct ResponseRecord<'a> {
    /// Samples, SI unit.
    pub samples: &'a [f64],
    /// Their spacing, s.
    pub step_s: f64,
    /// Where it measures.
    pub dof: &'a Dof,
    /// Range of the channel, SI unit, where it is known.
    pub full_scale: Option<f64>,
}

/// Assesses one response of a hit: overload, pre-trigger, decay, dead channel, drift. `pulse` is
/// that of the force.
///
/// A response that ends before the pulse does has all of them not decidable.
pub fn assess_response(
    record: &ResponseRecord<'_>,
    pulse: &Pulse,
    limits: &HitQualityLimits,
) -> Vec<Check> {
    if record.samples.len() < pulse.end {
        return undecided(&RESPONSE_RULES, Some(record.dof));
    }
    let checks = [
        overload::overload(
            record.samples,
            &Extent::of(record.samples),
            record.full_scale,
            limits,
        ),
        pretrigger::response_pre_trigger(record.samples, pulse, limits),
        decay::decay(record.samples, pulse, limits),
        pretrigger::dead_response(record.samples, pulse),
        decay::response_drift(record.samples, record.step_s, pulse, limits),
    ];
    let named = checks.into_iter().map(|check| Check {
        dof: Some(record.dof.clone()),
        ..check
    });
    named.collect()
}

/// The check of a clipped record, as the rule of [`assess_response`]; `None` for any
/// other.
pub fn overloaded(
    samples: &[f64],
    extent: &Extent,
    full_scale: Option<f64>,
    limits: &HitQualityLimits,
) -> Option<Check> {
    let check = overload::overload(samples, extent, full_scale, limits);
    (check.outcome == Outcome::Rejected).then_some(check)
}
