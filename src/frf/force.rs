//! The force of one hit is prepared: position of its pulse, transformed samples, spectrum and
//! noise.

use std::ops::Range;

use num_complex::Complex64;

use crate::fourier::{ForwardPlan, Scratch};
use crate::record::{ChannelPlace, ChannelSegment, HitInfo, Recording, Samples};
use crate::signal::{
    Conditioning, Frame, cut_force_fraction, locate_pulse, pretrigger_offset, to_si,
};

use super::{EstimateOptions, FrfError};

/// The stored data of the force of one hit.
pub(super) struct ForceHit {
    pub frame: Frame,
    pub spectrum: Vec<Complex64>,
    /// The fraction that the force window cuts off.
    pub cut: Option<f64>,
    /// Expected energy of the force's noise under its window: per line of the spectrum, that is its
    /// power too.
    pub noise: Option<f64>,
}

impl ForceHit {
    /// Of the stored samples; `range` is what is transformed, all where it is `None`.
    pub fn new(
        hit: &HitInfo,
        samples: &Samples,
        range: Option<Range<usize>>,
        conditioning: &Conditioning,
        plan: &ForwardPlan,
        scratch: &mut Scratch,
    ) -> Result<Self, FrfError> {
        let mut force = Vec::new();
        to_si(hit, &hit.force, samples, &mut force)?;
        let pulse = locate_pulse(hit, &force)?;
        let (pretrigger, offset) =
            pretrigger_offset(hit, &hit.force, &force, &pulse, conditioning.offset)?;
        let window = conditioning
            .force_window
            .map(|window| window.weights(&hit.axis, &pulse));
        let cut = window.zip(pretrigger);
        let cut = cut.map(|(window, pretrigger)| cut_force_fraction(&force, &window, &pretrigger));
        let range = range.unwrap_or(0..hit.axis.len);
        let frame = Frame::new(&hit.axis, pulse, range, conditioning);
        let weights = frame.force_weights.as_deref();
        frame.apply(&mut force, offset, weights);
        let mut spectrum = vec![Complex64::ZERO; plan.lines()];
        plan.run(&mut force, &mut spectrum, scratch);
        Ok(Self {
            cut,
            noise: pretrigger
                .map(|pretrigger| pretrigger.variance * frame.noise_gain(weights))
                .filter(|noise| *noise > 0.0),
            frame,
            spectrum,
        })
    }
}

/// Fewest response samples after the pulse: four quarters of eight.
const MIN_RESPONSE_SAMPLES: usize = 32;

/// Which samples of each hit are transformed.
pub(super) struct TransformRange {
    /// Number of samples.
    pub len: usize,
    /// Where they begin in each hit; `None` where all are taken.
    starts: Option<Vec<usize>>,
}

impl TransformRange {
    /// All samples; or those from the pulse on, as many as every chosen hit has (and a transform
    /// takes without effort).
    pub fn new(
        recording: &mut dyn Recording,
        chosen: &[usize],
        options: &EstimateOptions,
    ) -> Result<Self, FrfError> {
        let whole = recording.hits()[chosen[0]].axis.len;
        if !options.cut_pretrigger {
            return Ok(Self {
                len: whole,
                starts: None,
            });
        }
        let mut starts = vec![0; recording.hits().len()];
        let (mut samples, mut force) = (Samples::F64(Vec::new()), Vec::new());
        let mut len = whole;
        let mut ends = vec![0; recording.hits().len()];
        for &hit in chosen {
            read_force(recording, hit, &mut samples)?;
            let info = &recording.hits()[hit];
            to_si(info, &info.force, &samples, &mut force)?;
            let pulse = locate_pulse(info, &force)?;
            (starts[hit], ends[hit]) = (pulse.pretrigger_samples().end, pulse.end);
            len = len.min(whole - starts[hit]);
        }
        len = fast_transform_length(len);
        // One pulse at the end of its record would leave no response of the others.
        if let Some(late) = chosen
            .iter()
            .find(|hit| starts[**hit] + len < ends[**hit] + MIN_RESPONSE_SAMPLES)
        {
            return Err(FrfError::PulseAtEnd {
                origin: recording.hits()[*late].origin.clone(),
                got: len,
                expected: ends[*late] - starts[*late] + MIN_RESPONSE_SAMPLES,
            });
        }
        Ok(Self {
            len,
            starts: Some(starts),
        })
    }

    /// The samples of this hit; `None` for all.
    pub fn range(&self, hit: usize) -> Option<Range<usize>> {
        let starts = self.starts.as_ref()?;
        Some(starts[hit]..starts[hit] + self.len)
    }
}

/// The largest even number of the form 2^a 3^b 5^c 7^d that is not larger; a small number as it is.
pub(super) fn fast_transform_length(len: usize) -> usize {
    let is_smooth = |len: usize| {
        let mut rest = len;
        for prime in [2, 3, 5, 7] {
            while rest.is_multiple_of(prime) {
                rest /= prime;
            }
        }
        rest == 1 && len.is_multiple_of(2)
    };
    let found = (1..=len).rev().find(|len| is_smooth(*len));
    found.unwrap_or(len)
}

/// Reads the whole force of a hit.
pub(super) fn read_force(
    recording: &mut dyn Recording,
    hit: usize,
    samples: &mut Samples,
) -> Result<(), FrfError> {
    let segment = ChannelSegment {
        hit,
        channel: ChannelPlace::Force,
        samples: 0..recording.hits()[hit].axis.len,
    };
    Ok(recording.read(&segment, samples)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transform_of_a_smooth_length_is_not_much_shorter() {
        assert_eq!(fast_transform_length(96_000), 96_000);
        assert_eq!(fast_transform_length(65_535), 64_800); // 2^5 3^4 5^2
        assert_eq!((fast_transform_length(2), fast_transform_length(1)), (2, 1));
        for len in 200..20_000 {
            assert!(
                fast_transform_length(len) as f64 > 0.93 * len as f64,
                "{len}"
            );
        }
    }
}
