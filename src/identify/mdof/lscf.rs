//! Poles of the polyreference LSCF over rising orders: the seeds of the maximum likelihood fit, and
//! the `lscf` method's own.
//!
//! Low modes of a wide band lie close together on its scale: its lower quarter has an estimate of
//! its own, and a quarter of that.

use std::ops::Range;

use num_complex::Complex64;

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::frf_matrix::Sides;
use crate::identify::data::peak_detection::Found;
use crate::identify::error::IdentifyError;
use crate::identify::mdof::normal_equations::Transforms;
use crate::identify::mdof::plscf::Lscf;
use crate::identify::mdof::pole_tracks::{FEWEST_ORDERS, Table};
use crate::identify::mdof::stabilization::{MultiModeMethod, Part};

/// Poles of the highest order: so many for each peak that is seen, and beyond.
const POLES_PER_PEAK: usize = 5;
const POLES_BEYOND: usize = 30;
/// Bounds of their number.
const POLES: Range<usize> = 36..160;
/// A band whose ends differ by this factor has its lower part looked at by itself: so much of its
/// lines, if these are enough, and so much more of what lies beside the seam.
const WIDE: f64 = 8.0;
const PART: usize = 4;
const FEWEST_LINES: usize = 100;
const OVERLAP: f64 = 0.02;
/// Lines for each order, fewest.
const LINES_PER_ORDER: usize = 3;

/// The polyreference LSCF.
pub(in crate::identify) struct LeastSquaresComplexFrequency {
    /// Highest order, where it is not chosen by the number of peaks.
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

    fn parts(
        &self,
        (data, sides): (&Receptances, &Sides),
        (found, known): (&Found, &[Complex64]),
    ) -> Result<Vec<Part>, IdentifyError> {
        split(data, |end| {
            let top = highest_order((end, found), sides.inputs, self.max_order);
            Lscf::new(&Transforms::new(data, sides, (0..end, top, known)))?.tables()
        })
    }
}

/// Highest order of an estimate from the lines below one: as stated, or by the number of peaks.
pub(in crate::identify) fn highest_order(
    (end, found): (usize, &Found),
    inputs: usize,
    stated: Option<usize>,
) -> usize {
    let peaks = found.peaks.iter().filter(|peak| peak.line < end).count();
    let poles = (POLES_PER_PEAK * peaks + POLES_BEYOND).clamp(POLES.start, POLES.end);
    let most = end / LINES_PER_ORDER;
    match stated {
        Some(top) => top.min(most).max(1),
        None => (poles / inputs).min(most).max(FEWEST_ORDERS + 1),
    }
}

/// Estimates from all lines and, in a wide band, from its lower part, and from the lower part of
/// that.
pub(in crate::identify) fn split(
    data: &Receptances,
    tables_below: impl Fn(usize) -> Result<Vec<Table>, IdentifyError>,
) -> Result<Vec<Part>, IdentifyError> {
    let mut parts = Vec::new();
    let (mut end, mut highest) = (data.lines(), f64::INFINITY);
    loop {
        let part = end / PART;
        let wide = data.omega[end - 1] > WIDE * data.omega[0];
        let split = wide && part >= FEWEST_LINES;
        let lowest = if split { data.omega[part] } else { 0.0 };
        // A part without any response has no poles.
        let silent = |own: &[Complex64]| own[..end].iter().all(|v| *v == Complex64::ZERO);
        let tables = match data.values.iter().all(silent) {
            true => Vec::new(),
            false => tables_below(end)?,
        };
        parts.push(Part {
            from_rad_s: (1.0 - OVERLAP) * lowest,
            to_rad_s: highest,
            tables,
        });
        if !split {
            return Ok(parts);
        }
        end = part;
        highest = data.omega[end] * (1.0 + OVERLAP);
    }
}
