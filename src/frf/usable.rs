//! The band that the hammer excites and the anti-alias filter passes.

use crate::axis::{Band, TimeAxis};
use crate::record::Hit;

use super::estimate::{HitAnalysis, analyse, check};
use super::{EstimateOptions, FrfError};

/// Anti-alias filters are flat up to about this fraction of the sampling rate (1/2.56 = 0.39 in most analysers).
const FILTER_FRACTION: f64 = 0.4;

/// The force spectrum may fall this far below its maximum as a power ratio: 20 dB.
const LOWEST_POWER: f64 = 1e-2;

/// From the first line above 0 Hz to the lower of 0.4 of the sampling rate and the last line up to which the force
/// power, summed over all hits, stays within 20 dB of its maximum (without a gap, from the maximum upwards).
///
/// The maximum is sought above 0 Hz and below 0.4 of the sampling rate, so that an offset of the force does not count.
///
/// # Errors
/// As [`super::estimate`], except those of single lines; [`FrfError::BandEmpty`] when less than two lines are left.
pub fn usable_band(hits: &[Hit], options: &EstimateOptions) -> Result<Band, FrfError> {
    check(hits, options)?;
    band_of(&analyse(hits, options)?, &hits[0].axis)
}

/// The band from spectra that are already there.
pub(super) fn band_of(analyses: &[HitAnalysis], record: &TimeAxis) -> Result<Band, FrfError> {
    let end = FILTER_FRACTION * record.sampling_rate_hz() / record.spectrum_axis().step_hz;
    excited(analyses, record, (end + 1e-6).floor() as usize + 1)
}

/// The same up to half the sampling rate: how far the force itself excites, whatever the filter does there.
pub(super) fn excited_band_of(
    analyses: &[HitAnalysis],
    record: &TimeAxis,
) -> Result<Band, FrfError> {
    excited(analyses, record, record.spectrum_axis().len)
}

/// The lines below `end` that the force excites.
fn excited(analyses: &[HitAnalysis], record: &TimeAxis, end: usize) -> Result<Band, FrfError> {
    let axis = record.spectrum_axis();
    let power = |k: usize| -> f64 {
        let lines = analyses.iter().map(|hit| hit.spectra.force[k].norm_sqr());
        lines.sum()
    };
    let power: Vec<f64> = (0..end.min(axis.len)).map(power).collect();
    let maximum = (1..power.len())
        .rev()
        .max_by(|a, b| power[*a].total_cmp(&power[*b]))
        .unwrap_or(0);
    let excited = (maximum..power.len())
        .take_while(|k| power[*k] >= LOWEST_POWER * power[maximum])
        .last()
        .unwrap_or(0);
    let (lo_hz, hi_hz) = (axis.hz(1), axis.hz(excited));
    Band::new(lo_hz, hi_hz).map_err(|_| FrfError::BandEmpty { lo_hz, hi_hz })
}
