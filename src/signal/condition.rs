//! One hit in SI units with its pulse, its pre-trigger noise, and what was asked for: offset removal and windows.
//!
//! Without options the samples come out as they went in. The hit itself is never changed.

use crate::axis::TimeAxis;
use crate::record::{Channel, Hit};

use super::pulse::FEWEST_QUIET;
use super::{ExponentialWindow, ForceWindow, ONSET_FRACTION, PreTrigger, Pulse, SignalError};

/// What is done to every hit before it is transformed. The default is nothing.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Conditioning {
    /// Window of the force alone.
    pub force_window: Option<ForceWindow>,
    /// Window of force and responses.
    pub exponential: Option<ExponentialWindow>,
    /// Take the mean before the hit off each channel.
    pub remove_offset: bool,
}

impl Conditioning {
    /// Checks the windows.
    ///
    /// # Errors
    /// [`SignalError::WindowParameter`].
    pub fn validate(&self) -> Result<(), SignalError> {
        self.force_window.map_or(Ok(()), |w| w.validate())?;
        self.exponential.map_or(Ok(()), |w| w.validate())
    }
}

/// One channel after conditioning.
#[derive(Clone, Debug, PartialEq)]
pub struct ConditionedChannel {
    /// Samples in SI units, offset removed and windowed as asked.
    pub samples: Vec<f64>,
    /// Mean and noise before the hit, from the samples as they were; `None` for fewer than eight quiet samples.
    pub pre_trigger: Option<PreTrigger>,
}

/// One hit after conditioning.
#[derive(Clone, Debug, PartialEq)]
pub struct ConditionedHit {
    /// Common time axis.
    pub axis: TimeAxis,
    /// Where the pulse is.
    pub pulse: Pulse,
    /// Force, N.
    pub force: ConditionedChannel,
    /// Responses in the order of the hit.
    pub responses: Vec<ConditionedChannel>,
    /// What the force window cut off, rms beyond the noise over the rms of the force; `None` without a force window or
    /// without quiet samples.
    pub force_cut: Option<f64>,
    /// Window weight of every force sample (1 without windows).
    pub force_weights: Vec<f64>,
    /// Window weight of every response sample (1 without windows).
    pub response_weights: Vec<f64>,
}

/// Finds the pulse of a hit, measures the noise before it, removes offsets and applies windows as asked.
///
/// # Errors
/// [`SignalError`] for a bad time step, sample count, calibration factor or sample, a force without a pulse,
/// an offset that is to be removed but has fewer than eight quiet samples, and a window out of range.
pub fn condition(hit: &Hit, conditioning: &Conditioning) -> Result<ConditionedHit, SignalError> {
    check(hit, conditioning)?;
    let force = hit.force.si();
    let pulse = Pulse::locate(&force, ONSET_FRACTION).ok_or_else(|| SignalError::NoPulse {
        origin: hit.origin.clone(),
        dof: hit.force.dof.clone(),
        got_n: force[0],
    })?;
    let response_weights = conditioning.exponential.map_or_else(
        || vec![1.0; hit.axis.len],
        |window| window.weights(&hit.axis, &pulse),
    );
    let window = conditioning.force_window;
    let window = window.map(|window| window.weights(&hit.axis, &pulse));
    let quiet = PreTrigger::of(&force[pulse.quiet()]);
    let force_cut = window
        .as_ref()
        .zip(quiet)
        .map(|(window, quiet)| cut_off(&force, window, &quiet));
    let force_weights = match window {
        Some(window) => product(window, &response_weights),
        None => response_weights.clone(),
    };
    let prepare = |channel: &Channel, samples: Vec<f64>, weights: &[f64]| {
        let pre_trigger = PreTrigger::of(&samples[pulse.quiet()]);
        let offset = match pre_trigger {
            _ if !conditioning.remove_offset => 0.0,
            Some(quiet) => quiet.mean,
            None => return Err(no_pre_trigger(hit, channel, &pulse)),
        };
        let samples = samples.iter().zip(weights);
        Ok(ConditionedChannel {
            samples: samples.map(|(x, w)| (x - offset) * w).collect(),
            pre_trigger,
        })
    };
    Ok(ConditionedHit {
        axis: hit.axis,
        pulse,
        force: prepare(&hit.force, force, &force_weights)?,
        responses: hit
            .responses
            .iter()
            .map(|channel| prepare(channel, channel.si(), &response_weights))
            .collect::<Result<_, _>>()?,
        force_cut,
        force_weights,
        response_weights,
    })
}

/// `sqrt(Σ(1−w)²x² − σ²Σ(1−w)²)` over `sqrt(Σx²)`, the mean before the hit taken off; 0 where noise explains it all.
fn cut_off(force: &[f64], window: &[f64], quiet: &PreTrigger) -> f64 {
    let (mut cut, mut noise, mut all) = (0.0, 0.0, 0.0);
    for (x, w) in force.iter().zip(window) {
        let (x, lost) = (x - quiet.mean, (1.0 - w) * (1.0 - w));
        cut += lost * x * x;
        noise += lost * quiet.variance;
        all += x * x;
    }
    // The variance of the noise is known from few samples: what three times as much explains is no ringing.
    let beyond = if cut > 3.0 * noise { cut - noise } else { 0.0 };
    (beyond / all).sqrt()
}

fn product(mut a: Vec<f64>, b: &[f64]) -> Vec<f64> {
    a.iter_mut().zip(b).for_each(|(a, b)| *a *= b);
    a
}

fn no_pre_trigger(hit: &Hit, channel: &Channel, pulse: &Pulse) -> SignalError {
    SignalError::NoPreTrigger {
        origin: hit.origin.clone(),
        dof: channel.dof.clone(),
        got: pulse.quiet().len(),
        expected: FEWEST_QUIET,
    }
}

/// All argument checks of this stage.
fn check(hit: &Hit, conditioning: &Conditioning) -> Result<(), SignalError> {
    conditioning.validate()?;
    let origin = || hit.origin.clone();
    if !(hit.axis.step_s > 0.0 && hit.axis.step_s.is_finite()) {
        return Err(SignalError::TimeStep {
            origin: origin(),
            got_s: hit.axis.step_s,
        });
    }
    if hit.axis.len < 2 {
        return Err(SignalError::TooShort {
            origin: origin(),
            got: hit.axis.len,
            expected: 2,
        });
    }
    std::iter::once(&hit.force)
        .chain(&hit.responses)
        .try_for_each(|channel| check_channel(channel, hit))
}

fn check_channel(channel: &Channel, hit: &Hit) -> Result<(), SignalError> {
    let (origin, dof) = (hit.origin.clone(), channel.dof.clone());
    if channel.samples.len() != hit.axis.len {
        return Err(SignalError::SampleCount {
            origin,
            dof,
            got: channel.samples.len(),
            expected: hit.axis.len,
        });
    }
    if !channel.to_si.is_finite() || channel.to_si.abs() <= 0.0 {
        return Err(SignalError::Calibration {
            origin,
            dof,
            got: channel.to_si,
        });
    }
    let bad = channel
        .samples
        .iter()
        .enumerate()
        .find(|(_, v)| !(v * channel.to_si).is_finite());
    bad.map_or(Ok(()), |(sample, got)| {
        Err(SignalError::NotFinite {
            origin,
            dof,
            sample,
            got,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Quantity;
    use crate::record::{Role, Samples};

    fn channel(role: Role, quantity: Quantity, to_si: f64, samples: Vec<f64>) -> Channel {
        Channel {
            role,
            dof: "1:+Z".parse().unwrap(),
            quantity,
            to_si,
            samples: Samples::F64(samples),
        }
    }

    fn hit() -> Hit {
        let mut force = vec![0.5; 24];
        force[14] = 10.5;
        let response = (0..24).map(f64::from).collect();
        Hit {
            axis: TimeAxis {
                start_s: 0.0,
                step_s: 0.1,
                len: 24,
            },
            force: channel(Role::Force, Quantity::Force, 2.0, force),
            responses: vec![channel(
                Role::Response,
                Quantity::Acceleration,
                10.0,
                response,
            )],
            origin: "test".to_owned(),
        }
    }

    #[test]
    fn without_options_the_samples_are_the_si_samples() {
        let hit = hit();
        let out = condition(&hit, &Conditioning::default()).unwrap();
        assert_eq!(out.force.samples, hit.force.si());
        assert_eq!(out.responses[0].samples, hit.responses[0].si());
        assert_eq!(out.pulse.quiet(), 0..12);
    }

    #[test]
    fn the_offset_before_the_hit_is_removed_before_the_windows() {
        let conditioning = Conditioning {
            force_window: Some(ForceWindow {
                hold_s: 0.0,
                flank_s: 0.0,
            }),
            exponential: Some(ExponentialWindow { decay_rad_s: 2.0 }),
            remove_offset: true,
        };
        let out = condition(&hit(), &conditioning).unwrap();
        assert!((out.force.samples[14] - 20.0).abs() < 1e-12);
        let rest = out.force.samples.iter().map(|v| v.abs()).sum::<f64>() - 20.0;
        assert!(rest.abs() < 1e-12);
        // The mean of 0, 10, ..., 110 is 55; sample 19 lies 0.5 s after the hit.
        let expected = (190.0 - 55.0) * (-1f64).exp();
        assert!((out.responses[0].samples[19] - expected).abs() < 1e-11);
    }

    #[test]
    fn bad_hits_are_errors_that_say_what_is_wrong() {
        let run = |change: fn(&mut Hit)| {
            let mut hit = hit();
            change(&mut hit);
            condition(&hit, &Conditioning::default()).unwrap_err()
        };
        assert!(matches!(
            run(|h| h.axis.step_s = 0.0),
            SignalError::TimeStep { .. }
        ));
        assert!(matches!(
            run(|h| h.axis.len = 1),
            SignalError::TooShort { got: 1, .. }
        ));
        assert!(matches!(
            run(|h| h.axis.len = 23),
            SignalError::SampleCount {
                got: 24,
                expected: 23,
                ..
            }
        ));
        assert!(matches!(
            run(|h| h.responses[0].to_si = 0.0),
            SignalError::Calibration { .. }
        ));
        assert!(matches!(
            run(|h| h.force.samples = Samples::F32(vec![1.0; 24])),
            SignalError::NoPulse { .. }
        ));
        assert!(matches!(
            run(|h| {
                let mut bad = h.responses[0].samples.to_f64();
                bad[7] = f64::NAN;
                h.responses[0].samples = Samples::F64(bad);
            }),
            SignalError::NotFinite { sample: 7, .. }
        ));
    }

    #[test]
    fn an_offset_without_quiet_samples_is_an_error() {
        let mut hit = hit();
        let mut force = vec![0.0; 24];
        force[9] = 1.0;
        hit.force.samples = Samples::F64(force);
        let conditioning = Conditioning {
            remove_offset: true,
            ..Conditioning::default()
        };
        let error = condition(&hit, &conditioning).unwrap_err();
        assert!(
            matches!(error, SignalError::NoPreTrigger { got: 7, .. }),
            "{error}"
        );
    }
}
