//! One channel of one hit in SI units, its offset before the hit, and how the hit is framed: which
//! samples are transformed and under which weights.
//!
//! Without options all samples come out as they went in.

use std::ops::Range;

use crate::axis::TimeAxis;
use crate::record::{ChannelInfo, HitInfo, Samples};

use super::pulse::MIN_PRETRIGGER_SAMPLES;
use super::{
    ExponentialWindow, Extent, ForceWindow, ONSET_FRACTION, PretriggerNoise, Pulse, SignalError,
};

/// Treatment of the mean of a channel before the hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Offset {
    /// It stays.
    #[default]
    Keep,
    /// It is taken off; too few pre-trigger samples are an error.
    Remove,
    /// It is taken off where there are enough pre-trigger samples.
    RemoveIfPretrigger,
}

/// Treatment of every hit before its transform. The default is none.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Conditioning {
    /// Window of the force alone.
    pub force_window: Option<ForceWindow>,
    /// Window of force and responses.
    pub exponential: Option<ExponentialWindow>,
    /// Whether the mean before the hit is taken off each channel.
    pub offset: Offset,
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

/// Which samples of a hit are transformed, and under which weights.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Where the pulse is, in samples of the record.
    pub pulse: Pulse,
    /// Samples of the record that are transformed.
    pub range: Range<usize>,
    /// Weight of each of them in the force; `None` without a window.
    pub force_weights: Option<Vec<f64>>,
    /// Weight of each of them in the responses; `None` without a window.
    pub response_weights: Option<Vec<f64>>,
}

impl Frame {
    /// The frame of a hit whose samples `range` are transformed.
    pub fn new(
        axis: &TimeAxis,
        pulse: Pulse,
        range: Range<usize>,
        conditioning: &Conditioning,
    ) -> Self {
        let response_weights = conditioning
            .exponential
            .map(|window| window.weights(axis, &pulse)[range.clone()].to_vec());
        let force = conditioning
            .force_window
            .map(|window| window.weights(axis, &pulse)[range.clone()].to_vec());
        let force_weights = match (force, &response_weights) {
            (Some(force), Some(both)) => Some(force.iter().zip(both).map(|(a, b)| a * b).collect()),
            (force, both) => force.or_else(|| both.clone()),
        };
        Self {
            pulse,
            range,
            force_weights,
            response_weights,
        }
    }

    /// The framed samples of a whole record as they are transformed, `(x − offset) w`, in place of
    /// the record.
    pub fn apply(&self, record: &mut Vec<f64>, offset: f64, weights: Option<&[f64]>) {
        record.truncate(self.range.end);
        record.drain(..self.range.start);
        match weights {
            None if offset.abs() <= 0.0 => {}
            None => record.iter_mut().for_each(|x| *x -= offset),
            Some(weights) => {
                for (x, weight) in record.iter_mut().zip(weights) {
                    *x = (*x - offset) * weight;
                }
            }
        }
    }

    /// Sum of the squared weights: the energy of noise of unit variance under them.
    pub fn noise_gain(&self, weights: Option<&[f64]>) -> f64 {
        weights.map_or(self.range.len() as f64, |weights| {
            weights.iter().map(|w| w * w).sum()
        })
    }
}

/// Where the pulse of a force is.
///
/// # Errors
/// [`SignalError::NoPulse`] for a constant force.
pub fn locate_pulse(hit: &HitInfo, force_n: &[f64]) -> Result<Pulse, SignalError> {
    Pulse::locate(force_n, ONSET_FRACTION).ok_or_else(|| SignalError::NoPulse {
        origin: hit.origin.clone(),
        dof: hit.force.dof.clone(),
        got_n: force_n.first().copied().unwrap_or(0.0),
    })
}

/// The samples of one channel in SI units, in place of what `out` held; their extent.
///
/// # Errors
/// [`SignalError`] for a sample count that is not the hit's, a calibration factor or a sample that
/// is no finite number.
pub fn to_si(
    hit: &HitInfo,
    channel: &ChannelInfo,
    samples: &Samples,
    out: &mut Vec<f64>,
) -> Result<Extent, SignalError> {
    let (origin, dof) = (|| hit.origin.clone(), || channel.dof.clone());
    if samples.len() != hit.axis.len {
        return Err(SignalError::SampleCount {
            origin: origin(),
            dof: dof(),
            got: samples.len(),
            expected: hit.axis.len,
        });
    }
    let factor = channel.to_si;
    if !factor.is_finite() || factor.abs() <= 0.0 {
        return Err(SignalError::Calibration {
            origin: origin(),
            dof: dof(),
            got: factor,
        });
    }
    let extent = match samples {
        Samples::F32(values) => Extent::of_scaled(values, factor, out),
        Samples::F64(values) => Extent::of_scaled(values, factor, out),
    };
    // A sum is finite only if all samples are; an overflow of finite ones is decided one by one.
    let bad = if extent.sum.is_finite() {
        None
    } else {
        out.iter().position(|v| !v.is_finite())
    };
    match bad {
        None => Ok(extent),
        Some(sample) => Err(SignalError::NotFinite {
            origin: origin(),
            dof: dof(),
            sample,
            got: samples.iter().nth(sample).unwrap_or(f64::NAN),
        }),
    }
}

/// Mean and noise of a channel before the hit, and what is to be taken off it.
///
/// # Errors
/// [`SignalError::NoPreTrigger`] when the offset must be removed and cannot be measured.
pub fn pretrigger_offset(
    hit: &HitInfo,
    channel: &ChannelInfo,
    record: &[f64],
    pulse: &Pulse,
    offset: Offset,
) -> Result<(Option<PretriggerNoise>, f64), SignalError> {
    let pretrigger = PretriggerNoise::of(&record[pulse.pretrigger_samples()]);
    let taken = match (offset, &pretrigger) {
        (Offset::Keep, _) | (Offset::RemoveIfPretrigger, None) => 0.0,
        (_, Some(pretrigger)) => pretrigger.mean,
        (Offset::Remove, None) => {
            return Err(SignalError::NoPreTrigger {
                origin: hit.origin.clone(),
                dof: channel.dof.clone(),
                got: pulse.pretrigger_samples().len(),
                expected: MIN_PRETRIGGER_SAMPLES,
            });
        }
    };
    Ok((pretrigger, taken))
}

/// The fraction of the force that its window cuts off: `sqrt(Σ(1−w)²x² − σ²Σ(1−w)²)` over
/// `sqrt(Σx²)`, after the mean before the hit is subtracted; 0 where noise explains it.
pub fn cut_force_fraction(force_n: &[f64], window: &[f64], pretrigger: &PretriggerNoise) -> f64 {
    let (mut cut, mut noise, mut all) = (0.0, 0.0, 0.0);
    for (x, w) in force_n.iter().zip(window) {
        let (x, lost) = (x - pretrigger.mean, (1.0 - w) * (1.0 - w));
        cut += lost * x * x;
        noise += lost * pretrigger.variance;
        all += x * x;
    }
    // The variance of the noise is known from few samples: what three times as much explains is no
    // ringing.
    let beyond = if cut > 3.0 * noise { cut - noise } else { 0.0 };
    (beyond / all).sqrt()
}

/// The axis of a hit must have a step and samples.
///
/// # Errors
/// [`SignalError::TimeStep`] and [`SignalError::TooShort`].
pub fn check_axis(hit: &HitInfo) -> Result<(), SignalError> {
    if !(hit.axis.step_s > 0.0 && hit.axis.step_s.is_finite()) {
        return Err(SignalError::TimeStep {
            origin: hit.origin.clone(),
            got_s: hit.axis.step_s,
        });
    }
    if hit.axis.len < 2 {
        return Err(SignalError::TooShort {
            origin: hit.origin.clone(),
            got: hit.axis.len,
            expected: 2,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Quantity;

    fn hit() -> (HitInfo, Vec<f64>, Vec<f64>) {
        let channel = |quantity, to_si| ChannelInfo {
            dof: "1:+Z".parse().unwrap(),
            quantity,
            to_si,
            full_scale: None,
            delay_s: 0.0,
        };
        let axis = TimeAxis {
            start_s: 0.0,
            step_s: 0.1,
            len: 24,
        };
        let info = HitInfo {
            axis,
            force: channel(Quantity::Force, 2.0),
            responses: vec![channel(Quantity::Acceleration, 10.0)],
            origin: "test".to_owned(),
        };
        let mut force = vec![0.5; 24];
        force[14] = 10.5;
        (info, force, (0..24).map(f64::from).collect())
    }

    fn si(info: &HitInfo, channel: &ChannelInfo, samples: Vec<f64>) -> Vec<f64> {
        let mut out = Vec::new();
        to_si(info, channel, &Samples::F64(samples), &mut out).unwrap();
        out
    }

    #[test]
    fn without_options_the_samples_are_the_si_samples() {
        let (info, force, response) = hit();
        let pulse = locate_pulse(&info, &si(&info, &info.force, force)).unwrap();
        assert_eq!(pulse.pretrigger_samples(), 0..12);
        let response = si(&info, &info.responses[0], response);
        let frame = Frame::new(&info.axis, pulse, 0..24, &Conditioning::default());
        let mut out = response.clone();
        frame.apply(&mut out, 0.0, None);
        assert_eq!(out, response);
        assert!((frame.noise_gain(None) - 24.0).abs() < 1e-15);
    }

    #[test]
    fn the_offset_before_the_hit_is_removed_before_the_windows() {
        let conditioning = Conditioning {
            force_window: Some(ForceWindow {
                hold_s: 0.0,
                flank_s: 0.0,
            }),
            exponential: Some(ExponentialWindow { decay_rad_s: 2.0 }),
            offset: Offset::Remove,
        };
        let (info, force, response) = hit();
        let force = si(&info, &info.force, force);
        let pulse = locate_pulse(&info, &force).unwrap();
        let frame = Frame::new(&info.axis, pulse, 4..24, &conditioning);
        let (_, offset) =
            pretrigger_offset(&info, &info.force, &force, &pulse, Offset::Remove).unwrap();
        let mut out = force.clone();
        frame.apply(&mut out, offset, frame.force_weights.as_deref());
        assert!((out[10] - 20.0).abs() < 1e-12);
        let rest = out.iter().map(|v| v.abs()).sum::<f64>() - 20.0;
        assert!(rest.abs() < 1e-12);
        // The mean of 0, 10, ..., 110 is 55; sample 19 lies 0.5 s after the hit.
        let response = si(&info, &info.responses[0], response);
        let channel = &info.responses[0];
        let (_, offset) =
            pretrigger_offset(&info, channel, &response, &pulse, Offset::Remove).unwrap();
        let mut out = response.clone();
        frame.apply(&mut out, offset, frame.response_weights.as_deref());
        let expected = (190.0 - 55.0) * (-1f64).exp();
        assert!((out[15] - expected).abs() < 1e-11);
    }

    #[test]
    fn bad_hits_are_errors_with_their_cause() {
        let (info, force, _) = hit();
        let with = |change: fn(&mut HitInfo), samples: Vec<f64>| {
            let mut info = info.clone();
            change(&mut info);
            let mut out = Vec::new();
            check_axis(&info)?;
            to_si(&info, &info.force, &Samples::F64(samples), &mut out)?;
            locate_pulse(&info, &out)
        };
        let run = |change: fn(&mut HitInfo)| with(change, force.clone()).unwrap_err();
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
            run(|h| h.force.to_si = 0.0),
            SignalError::Calibration { .. }
        ));
        let constant = with(|_| {}, vec![1.0; 24]).unwrap_err();
        assert!(matches!(constant, SignalError::NoPulse { .. }));
        let mut bad = force.clone();
        bad[7] = f64::NAN;
        let not_finite = with(|_| {}, bad).unwrap_err();
        assert!(matches!(
            not_finite,
            SignalError::NotFinite { sample: 7, .. }
        ));
        let mut large = vec![0.0; 24];
        large[3..7].fill(1.7e308 / 2.0);
        assert!(with(|_| {}, large).is_ok(), "finite samples, infinite sum");
    }

    #[test]
    fn an_offset_without_pretrigger_samples_is_an_error_or_stays() {
        let (info, _, _) = hit();
        let mut force = vec![0.0; 24];
        force[9] = 1.0;
        let pulse = locate_pulse(&info, &force).unwrap();
        let of = |offset| pretrigger_offset(&info, &info.force, &force, &pulse, offset);
        let error = of(Offset::Remove).unwrap_err();
        assert!(
            matches!(error, SignalError::NoPreTrigger { got: 7, .. }),
            "{error}"
        );
        assert_eq!(of(Offset::RemoveIfPretrigger).unwrap(), (None, 0.0));
    }
}
