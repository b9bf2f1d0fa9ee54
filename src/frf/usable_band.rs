//! The band that the hammer excites and the anti-alias filter passes.

use num_complex::Complex64;

use crate::axis::{Band, TimeAxis};

use super::{FrfError, FrfSet};

/// Anti-alias filters are flat up to about this fraction of the sampling rate (1/2.56 = 0.39 in
/// most analysers).
const MAX_BAND_OVER_SAMPLING_RATE: f64 = 0.4;

/// The force spectrum may fall this far below its maximum as a power ratio: 20 dB.
const MIN_POWER_OVER_MAXIMUM: f64 = 1e-2;

/// Lines of a running median: hum and drift fill less than half of them.
const MEDIAN_LINES: usize = 9;

/// Power of the force at every line, summed over hits.
pub(super) struct ForcePower {
    record: TimeAxis,
    lines: Vec<f64>,
    /// Noise of the force at each line.
    noise: f64,
}

impl ForcePower {
    /// Of no hit yet; the axis is that of what is transformed.
    pub fn new(record: TimeAxis) -> Self {
        Self {
            record,
            lines: vec![0.0; record.spectrum_axis().len],
            noise: 0.0,
        }
    }

    /// The axis of what is transformed.
    pub fn axis(&self) -> &TimeAxis {
        &self.record
    }

    /// Adds a hit; `noise` is the expected power of its noise at a line.
    pub fn add(&mut self, force: &[Complex64], noise: Option<f64>) {
        self.noise += noise.unwrap_or(0.0);
        for (power, force) in self.lines.iter_mut().zip(force) {
            *power += force.norm_sqr();
        }
    }

    /// From the first line above 0 Hz to the lower of 0.4 of the sampling rate and the last line up
    /// to which the force power, summed over all hits, stays within 20 dB of its maximum (without a
    /// gap, from the maximum upwards).
    ///
    /// The power is the median over nine lines, less that of the noise before the hit, so that
    /// neither hum nor a drift of the force sets the maximum, nor noise keeps the band open. The
    /// maximum is sought above 0 Hz and below 0.4 of the sampling rate, so that an offset does not
    /// count.
    ///
    /// # Errors
    /// [`FrfError::BandEmpty`] when less than two lines are left.
    pub fn valid_band(&self) -> Result<Band, FrfError> {
        let step_hz = self.record.spectrum_axis().step_hz;
        let end = MAX_BAND_OVER_SAMPLING_RATE * self.record.sampling_rate_hz() / step_hz;
        self.excited_below((end + 1e-6).floor() as usize + 1)
    }

    /// The same up to half the sampling rate: how far the force itself excites, whatever the filter
    /// does there.
    ///
    /// # Errors
    /// As [`ForcePower::valid_band`].
    pub fn excited_band(&self) -> Result<Band, FrfError> {
        self.excited_below(self.lines.len())
    }

    /// From the first to the last line above 0 Hz and below 0.4 of the sampling rate whose power is
    /// within 20 dB of that which a tenth of the lines exceed. The force of a shaker drops at
    /// resonances: lines between may be lower.
    ///
    /// # Errors
    /// As [`ForcePower::valid_band`].
    pub fn covered_band(&self) -> Result<Band, FrfError> {
        let axis = self.record.spectrum_axis();
        let end = MAX_BAND_OVER_SAMPLING_RATE * self.record.sampling_rate_hz() / axis.step_hz;
        let end = ((end + 1e-6).floor() as usize + 1).min(self.lines.len());
        let power = self.median_power(end);
        let mut sorted = power.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let level = sorted.get(9 * sorted.len() / 10).copied().unwrap_or(0.0);
        let is_covered = |k: &usize| power[*k] > 0.0 && power[*k] >= MIN_POWER_OVER_MAXIMUM * level;
        let first = (1..power.len()).find(is_covered).unwrap_or(0);
        let last = (1..power.len()).rev().find(is_covered).unwrap_or(0);
        let (lo_hz, hi_hz) = (axis.hz(first), axis.hz(last));
        Band::new(lo_hz, hi_hz).map_err(|_| FrfError::BandEmpty { lo_hz, hi_hz })
    }

    /// Median over the neighbours of each line up to `end`, 0 Hz left out, less the noise.
    fn median_power(&self, end: usize) -> Vec<f64> {
        let median = |line: usize| {
            let reach = (MEDIAN_LINES / 2)
                .min(line.saturating_sub(1))
                .min(end - 1 - line);
            let mut near = [0.0; MEDIAN_LINES];
            let near = &mut near[..2 * reach + 1];
            near.copy_from_slice(&self.lines[line - reach..=line + reach]);
            near.sort_unstable_by(f64::total_cmp);
            (near[reach] - self.noise).max(0.0)
        };
        (0..end)
            .map(|line| if line == 0 { 0.0 } else { median(line) })
            .collect()
    }

    /// The lines below `end` that the force excites.
    fn excited_below(&self, end: usize) -> Result<Band, FrfError> {
        let axis = self.record.spectrum_axis();
        let power = self.median_power(end.min(self.lines.len()));
        let maximum = (1..power.len())
            .rev()
            .max_by(|a, b| power[*a].total_cmp(&power[*b]))
            .unwrap_or(0);
        let excited = (maximum..power.len())
            .take_while(|k| power[*k] > 0.0 && power[*k] >= MIN_POWER_OVER_MAXIMUM * power[maximum])
            .last()
            .unwrap_or(0);
        let (lo_hz, hi_hz) = (axis.hz(1), axis.hz(excited));
        Band::new(lo_hz, hi_hz).map_err(|_| FrfError::BandEmpty { lo_hz, hi_hz })
    }
}

/// The part of a band that the force excites; `usable` stands where that is unknown.
///
/// # Errors
/// [`FrfError::BandNotExcited`] where the force excites none of it.
pub fn excited_part(set: &FrfSet, wanted: Band, usable: Band) -> Result<Band, FrfError> {
    let excited = set.excited_band.unwrap_or(usable);
    let part = wanted.intersection(&excited);
    part.ok_or(FrfError::BandNotExcited {
        got_lo_hz: wanted.lo_hz,
        got_hi_hz: wanted.hi_hz,
        lo_hz: excited.lo_hz,
        hi_hz: excited.hi_hz,
    })
}
