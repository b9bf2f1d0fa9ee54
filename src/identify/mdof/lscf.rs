//! The polyreference LSCF gives poles over rising orders: those of the `lscf` method, and the
//! initial poles of the maximum likelihood fit.
//!
//! Low modes of a wide band lie close together on its scale. A separate estimate therefore covers
//! its lower quarter, and another one the lower quarter of that.

use std::ops::Range;

use num_complex::Complex64;

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::peak_detection::DetectedPeaks;
use crate::identify::error::IdentifyError;
use crate::identify::fit::fit_data::FitData;
use crate::identify::mdof::normal_equations::Transforms;
use crate::identify::mdof::plscf::Lscf;
use crate::identify::mdof::pole_tracks::{MIN_TRACK_ORDERS, OrderPoles};
use crate::identify::mdof::stabilization::{BandSegment, MultiModeMethod};

/// Poles of the highest order: a number for each detected peak, and additional ones.
const POLES_PER_PEAK: usize = 5;
const ADDITIONAL_POLES: usize = 30;
/// Limits of their number, and the fewest for each peak: of 120 modes at three references an
/// estimate of 160 poles gave 68, of 360 poles all, in a second. Peaks of noise may be more: the
/// work rises with the third power.
const TOTAL_POLES: Range<usize> = 36..160;
const MIN_POLES_PER_PEAK: usize = 3;
const MAX_TOTAL_POLES: usize = 480;
/// A band whose ends differ by more than this factor has a separate estimate of its lower segment:
/// one over the divisor of its lines, if these are enough, overlapping at the boundary by a
/// fraction of the frequency.
const MIN_WIDE_BAND_RATIO: f64 = 8.0;
const LOWER_SEGMENT_DIVISOR: usize = 4;
const MIN_SEGMENT_LINES: usize = 100;
const OVERLAP_FRACTION: f64 = 0.02;
/// Minimum number of lines per order.
const MIN_LINES_PER_ORDER: usize = 3;

/// The polyreference LSCF.
pub(in crate::identify) struct LeastSquaresComplexFrequency {
    /// Highest order; without it the number of peaks determines it.
    pub max_order: Option<usize>,
}

impl MultiModeMethod for LeastSquaresComplexFrequency {
    fn name(&self) -> &'static str {
        "lscf"
    }

    fn gives_participation(&self) -> bool {
        true
    }

    fn weights_lines(&self) -> bool {
        true
    }

    fn segments(
        &self,
        data: &FitData,
        frf_matrix: &FrfMatrix,
        found: &DetectedPeaks,
        weight_poles: &[Complex64],
    ) -> Result<Vec<BandSegment>, IdentifyError> {
        split_band(&data.frfs, |end| {
            let top = highest_order(end, found, frf_matrix.inputs, self.max_order);
            Lscf::new(&Transforms::new(
                data,
                frf_matrix,
                0..end,
                top,
                weight_poles,
            ))?
            .tables()
        })
    }
}

/// Highest order of an estimate from the lines below `end`: as stated, or by the number of peaks.
pub(in crate::identify) fn highest_order(
    end: usize,
    found: &DetectedPeaks,
    inputs: usize,
    stated: Option<usize>,
) -> usize {
    let peaks = found.peaks.iter().filter(|peak| peak.line < end).count();
    let poles = total_poles(peaks);
    let max_order = end / MIN_LINES_PER_ORDER;
    match stated {
        Some(top) => top.min(max_order).max(1),
        None => (poles / inputs).min(max_order).max(MIN_TRACK_ORDERS + 1),
    }
}

/// Poles of the highest order for a number of peaks.
fn total_poles(peaks: usize) -> usize {
    let most = (MIN_POLES_PER_PEAK * peaks).clamp(TOTAL_POLES.end, MAX_TOTAL_POLES);
    (POLES_PER_PEAK * peaks + ADDITIONAL_POLES).clamp(TOTAL_POLES.start, most)
}

/// Estimates from all lines and, in a wide band, from its lower segment, and from the lower segment
/// of that.
pub(in crate::identify) fn split_band(
    data: &BandFrfs,
    tables_below: impl Fn(usize) -> Result<Vec<OrderPoles>, IdentifyError>,
) -> Result<Vec<BandSegment>, IdentifyError> {
    let mut segments = Vec::new();
    let (mut end, mut highest) = (data.lines(), f64::INFINITY);
    loop {
        let lower_end = end / LOWER_SEGMENT_DIVISOR;
        let wide = data.omega[end - 1] > MIN_WIDE_BAND_RATIO * data.omega[0];
        let has_lower_segment = wide && lower_end >= MIN_SEGMENT_LINES;
        let lowest = if has_lower_segment {
            data.omega[lower_end]
        } else {
            0.0
        };
        // A segment without any response has no poles.
        let is_zero = |f: usize| (0..end).all(|k| data.values.at(f, k) == Complex64::ZERO);
        let tables = match (0..data.functions()).all(is_zero) {
            true => Vec::new(),
            false => tables_below(end)?,
        };
        segments.push(BandSegment {
            from_rad_s: (1.0 - OVERLAP_FRACTION) * lowest,
            to_rad_s: highest,
            tables,
        });
        if !has_lower_segment {
            return Ok(segments);
        }
        end = lower_end;
        highest = data.omega[end] * (1.0 + OVERLAP_FRACTION);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_peak_has_three_poles_at_least_up_to_a_limit() {
        assert_eq!([0, 10, 26, 50].map(total_poles), [36, 80, 160, 160]);
        assert_eq!([60, 120, 1000].map(total_poles), [180, 360, 480]);
    }
}
