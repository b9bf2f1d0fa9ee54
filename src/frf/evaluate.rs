//! A recorded test becomes FRFs as its excitation asks: hits are judged and averaged, records of a
//! shaker are cut into blocks.

use crate::record::{ChannelPlace, ChannelSegment, HitInfo, Recording, Samples};

use super::FrfError;
use super::hammer_options::{Excitation, HammerOptions};
use super::hammer_test::{HammerTestResult, evaluate_hammer_test};
use super::shaker_test::evaluate_shaker_test;

/// Part of a record in which its force is above a quarter of its peak, above which it is no pulse.
/// Gaussian noise is there for a third of its time, a sine for five sixths. Larger: a burst over
/// half of its record is taken for a hit. Smaller: so is no pulse of a record as short as twenty
/// pulses (`records_of_a_shaker_are_no_hits`).
const MAX_PULSE_PART: f64 = 0.1;

/// Largest distance from its mean, over it, of a force that is constant but for rounding.
const ROUNDING: f64 = 1e-12;

/// FRFs of a recorded test.
///
/// # Errors
/// As [`evaluate_hammer_test`]; [`FrfError::NoPulse`] where no record of a hammer test has a pulse.
pub fn evaluate_test(
    recording: &mut dyn Recording,
    options: &HammerOptions,
) -> Result<HammerTestResult, FrfError> {
    if options.excitation == Excitation::Shaker {
        return evaluate_shaker_test(recording, options);
    }
    let infos: Vec<HitInfo> = recording.hits().to_vec();
    let mut smallest = f64::INFINITY;
    for (record, info) in infos.iter().enumerate() {
        smallest = smallest.min(high_part(recording, record, info)?);
        if smallest <= MAX_PULSE_PART {
            return evaluate_hammer_test(recording, options);
        }
    }
    match infos.first() {
        None => Err(FrfError::NoHits),
        Some(first) => Err(FrfError::NoPulse {
            origin: first.origin.clone(),
            got: smallest,
            expected: MAX_PULSE_PART,
        }),
    }
}

/// The part of a record in which its force is above a quarter of its peak; 0 where it is constant.
fn high_part(
    recording: &mut dyn Recording,
    record: usize,
    info: &HitInfo,
) -> Result<f64, FrfError> {
    let mut samples = Samples::F64(Vec::new());
    let segment = ChannelSegment {
        hit: record,
        channel: ChannelPlace::Force,
        samples: 0..info.axis.len,
    };
    recording.read(&segment, &mut samples)?;
    let count = samples.len().max(1) as f64;
    let mean = samples.iter().sum::<f64>() / count;
    let peak = samples
        .iter()
        .map(|value| (value - mean).abs())
        .fold(0.0, f64::max);
    if peak <= ROUNDING * mean.abs() {
        return Ok(0.0);
    }
    let high = samples
        .iter()
        .filter(|value| (value - mean).abs() > 0.25 * peak);
    Ok(high.count() as f64 / count)
}
