//! FRFs of a set inside a band, as receptances.
//!
//! This file converts all FRFs to receptances and checks the arguments of every estimator. A set
//! may carry the decay rate `a` of an exponential window: its values were sampled at `s = iω + a`,
//! so that mobility is `s X/F` and accelerance `s² X/F`. Dividing by the power of `s` gives `X/F =
//! Σ A/(iω − λ) + conj.` with `λ = λ_true − a`: an ordinary receptance whose poles carry the
//! window's damping. The other files of the stage work on that and do not depend on `a`.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

use num_complex::Complex64;

use crate::axis::Band;
use crate::frf::{FrfSet, Function};

use crate::identify::data::frf_values::{FrfValues, MeasuredValues};
use crate::identify::data::line_shape::LineShape;
use crate::identify::error::IdentifyError;

/// Guard lines on each side of a band, over the number of its lines.
const GUARD_LINES_RATIO: f64 = 0.05;
/// Minimum number of lines in a band that is searched.
const MIN_BAND_LINES: usize = 8;
/// Minimum number of lines on each side of a pole.
const MIN_LINES_PER_SIDE: usize = 3;

/// Receptances on the lines of a band.
pub(in crate::identify) struct BandFrfs {
    /// The lines, by their numbers in the set.
    pub lines_of_set: Range<usize>,
    /// Angular frequency of every line, rad/s.
    pub omega: Vec<f64>,
    /// Spacing of the lines, rad/s.
    pub step: f64,
    /// Line shape of a pole in these data.
    pub line_shape: LineShape,
    /// Line shape of leakage that may have biased poles fitted without it: of the stated window, or
    /// of an unstated one.
    pub leakage: Option<LineShape>,
    /// Values, m/N.
    pub values: FrfValues,
    /// Magnitude of measured values over receptances, one vector per FRF: noise is white in the
    /// measured quantity.
    pub measured_scale: Vec<Arc<Vec<f64>>>,
}

impl BandFrfs {
    /// The FRFs of a set on the lines of a band, except the line at 0 Hz.
    ///
    /// # Errors
    /// [`IdentifyError::NoFunctions`], [`IdentifyError::BandOutside`],
    /// [`IdentifyError::TooFewLines`], [`IdentifyError::OptionOutOfRange`] for an impossible added
    /// damping, [`IdentifyError::NotFinite`].
    pub fn new(set: &FrfSet, band: Band) -> Result<Self, IdentifyError> {
        let lines = checked_lines(set, band)?;
        Self::on_lines(set, lines)
    }

    /// As [`Self::new`], with guard lines on each side as far as the set has them.
    ///
    /// # Errors
    /// As [`Self::new`], for the band itself.
    pub fn guarded(set: &FrfSet, band: Band) -> Result<Self, IdentifyError> {
        let lines = checked_lines(set, band)?;
        // Values on guard lines may be invalid: then the band is used without them.
        Self::on_lines(set, add_guard_lines(set, &lines)).or_else(|_| Self::on_lines(set, lines))
    }

    fn on_lines(set: &FrfSet, lines: Range<usize>) -> Result<Self, IdentifyError> {
        let lines = trim_empty_ends(set, lines);
        for i in 0..set.len() {
            check_finite(set, i, lines.clone())?;
        }
        let omega: Vec<f64> = lines.clone().map(|k| set.axis().rad_s(k)).collect();
        let scales = Scales::new(set, &omega);
        let values = (0..set.len()).map(|i| MeasuredValues {
            measured: set.shared_values(i),
            first: lines.start,
            factors: scales.of(set, i).factors.clone(),
        });
        Ok(Self {
            step: std::f64::consts::TAU * set.axis().step_hz,
            line_shape: LineShape::EXACT,
            leakage: LineShape::possible_leakage(set),
            values: FrfValues::new(values.collect(), omega.len()),
            measured_scale: (0..set.len())
                .map(|i| Arc::clone(&scales.of(set, i).magnitudes))
                .collect(),
            lines_of_set: lines,
            omega,
        })
    }

    /// Some of the FRFs, by their numbers.
    pub fn sample(&self, functions: &[usize]) -> Self {
        let scale = |f: &usize| Arc::clone(&self.measured_scale[*f]);
        Self {
            lines_of_set: self.lines_of_set.clone(),
            omega: self.omega.clone(),
            step: self.step,
            line_shape: self.line_shape,
            leakage: self.leakage,
            values: self.values.sample(functions),
            measured_scale: functions.iter().map(scale).collect(),
        }
    }

    /// Number of FRFs.
    pub fn functions(&self) -> usize {
        self.values.functions()
    }

    /// Number of lines.
    pub fn lines(&self) -> usize {
        self.omega.len()
    }

    /// The line nearest to a pole.
    pub fn line_of(&self, lambda: Complex64) -> usize {
        let line = ((lambda.im - self.omega[0]) / self.step).round();
        (line.max(0.0) as usize).min(self.lines() - 1)
    }

    /// Lines within a number of half-power bandwidths of a pole, and a minimum on each side.
    pub fn lines_around(&self, lambda: Complex64, bandwidths: f64) -> std::ops::Range<usize> {
        let width = 2.0 * lambda.re.abs();
        let side = (bandwidths * width / self.step).round() as usize;
        let side = side.max(MIN_LINES_PER_SIDE);
        let line = self.line_of(lambda);
        line.saturating_sub(side)..(line + side + 1).min(self.lines())
    }

    /// Adds a correction to an FRF, a function of frequency in rad/s.
    pub fn correct(&mut self, function: usize, by: impl Fn(f64) -> Complex64) {
        let values = self.values.all_of(function);
        let values = values.iter().zip(&self.omega);
        let corrected = values.map(|(value, omega)| value + by(*omega)).collect();
        self.values.set(function, corrected);
    }

    /// Range of the lines, rad/s.
    pub fn range(&self) -> f64 {
        self.omega[self.lines() - 1] - self.omega[0]
    }

    /// Distance of a frequency from the range of the lines, rad/s; 0 inside.
    pub fn beyond(&self, omega: f64) -> f64 {
        let (first, last) = (self.omega[0], self.omega[self.lines() - 1]);
        (first - omega).max(omega - last).max(0.0)
    }
}

/// Scale of each order of derivative.
struct Scales(BTreeMap<i32, Scale>);

/// Measured values over receptances, by line.
struct Scale {
    /// Factors from measured values to receptances; `None` where these are measured.
    factors: Option<Arc<Vec<Complex64>>>,
    /// Magnitudes of the inverse.
    magnitudes: Arc<Vec<f64>>,
}

impl Scales {
    fn new(set: &FrfSet, omega: &[f64]) -> Self {
        let of_order = |order: i32| {
            let factor = |w: &f64| Complex64::new(set.added_damping_rad_s, *w).powi(-order);
            let factors: Vec<Complex64> = omega.iter().map(factor).collect();
            let magnitudes = factors.iter().map(|factor| factor.norm().recip());
            Scale {
                magnitudes: Arc::new(magnitudes.collect()),
                factors: (order != 0).then(|| Arc::new(factors)),
            }
        };
        let orders = set.functions().iter().map(derivative_order);
        let orders: BTreeSet<i32> = orders.collect();
        Self(orders.into_iter().map(|n| (n, of_order(n))).collect())
    }

    fn of(&self, set: &FrfSet, function: usize) -> &Scale {
        &self.0[&derivative_order(&set.functions()[function])]
    }
}

fn derivative_order(function: &Function) -> i32 {
    function.kind.derivative_order()
}

/// The whole usable band of a set: from its first line above 0 Hz to its last.
pub(in crate::identify) fn whole_band(set: &FrfSet) -> Option<Band> {
    let axis = set.axis();
    let first = (0..axis.len).find(|k| axis.hz(*k) > 0.0)?;
    Band::new(axis.hz(first), axis.hz(axis.len - 1)).ok()
}

/// The error of a set whose axis holds no band.
pub(in crate::identify) fn no_band_error(set: &FrfSet) -> IdentifyError {
    IdentifyError::TooFewLines {
        got: set.axis().len,
        expected: MIN_BAND_LINES,
    }
}

fn checked_lines(set: &FrfSet, band: Band) -> Result<Range<usize>, IdentifyError> {
    if set.is_empty() {
        return Err(IdentifyError::NoFunctions);
    }
    let added = set.added_damping_rad_s;
    if !(added >= 0.0 && added.is_finite()) {
        return Err(IdentifyError::OptionOutOfRange {
            name: "added damping of the set in rad/s",
            got: added,
            expected: "a finite number, 0 or more",
        });
    }
    let whole = whole_band(set).ok_or_else(|| no_band_error(set))?;
    let slack = 0.5 * set.axis().step_hz;
    let lower_reaches =
        band.lo_hz >= whole.lo_hz - slack || (band.lo_hz >= 0.0 && set.axis().start_hz <= 0.0);
    if !(lower_reaches && band.lo_hz < band.hi_hz && band.hi_hz <= whole.hi_hz + slack) {
        return Err(IdentifyError::BandOutside {
            got_lo_hz: band.lo_hz,
            got_hi_hz: band.hi_hz,
            lo_hz: whole.lo_hz,
            hi_hz: whole.hi_hz,
        });
    }
    let lines = set.axis().lines(&band);
    let first = lines.clone().find(|k| set.axis().hz(*k) > 0.0);
    let lines = first.unwrap_or(lines.end)..lines.end;
    if lines.len() < MIN_BAND_LINES {
        return Err(IdentifyError::TooFewLines {
            got: lines.len(),
            expected: MIN_BAND_LINES,
        });
    }
    Ok(lines)
}

/// Lines of a band with [`GUARD_LINES_RATIO`] of them more on each side, as far as the set has
/// them.
fn add_guard_lines(set: &FrfSet, lines: &Range<usize>) -> Range<usize> {
    let guard = (GUARD_LINES_RATIO * lines.len() as f64).ceil() as usize;
    let first = (0..lines.start).find(|k| set.axis().hz(*k) > 0.0);
    let start = lines.start.saturating_sub(guard);
    let end = (lines.end + guard).min(set.axis().len);
    start.max(first.unwrap_or(lines.start))..end
}

/// Lines of a band with its guard lines; empty where the band is invalid.
pub(in crate::identify) fn guarded_lines(set: &FrfSet, band: Band) -> Range<usize> {
    checked_lines(set, band).map_or(0..0, |lines| add_guard_lines(set, &lines))
}

/// Lines without those at either end where all FRFs are exactly 0, as a filter of the analyser
/// leaves them, or not finite: no resonance is identifiable there. All lines where too few would
/// remain.
fn trim_empty_ends(set: &FrfSet, lines: Range<usize>) -> Range<usize> {
    let empty = |value: Complex64| value == Complex64::ZERO || !value.is_finite();
    let blank = |k: usize| (0..set.len()).all(|i| empty(set.values(i)[k]));
    let start = lines.clone().find(|k| !blank(*k));
    let end = lines.clone().rev().find(|k| !blank(*k));
    match (start, end) {
        (Some(start), Some(last)) if last + 1 - start >= MIN_BAND_LINES => start..last + 1,
        _ => lines,
    }
}

/// Numbers of the FRFs with a value that is not finite in a band, with the frequency of the first
/// such value, Hz.
pub(in crate::identify) fn frfs_with_invalid_values(
    set: &FrfSet,
    band: Band,
) -> BTreeMap<usize, f64> {
    let lines = checked_lines(set, band).unwrap_or_default();
    let lines = trim_empty_ends(set, lines);
    let invalid_value = |i: usize| match check_finite(set, i, lines.clone()) {
        Err(IdentifyError::NotFinite { hz, .. }) => Some((i, hz)),
        _ => None,
    };
    (0..set.len()).filter_map(invalid_value).collect()
}

fn check_finite(set: &FrfSet, i: usize, lines: Range<usize>) -> Result<(), IdentifyError> {
    let values = set.values(i);
    let error = |k: usize, what, got| IdentifyError::NotFinite {
        response: set.functions()[i].response.clone(),
        reference: set.functions()[i].reference.clone(),
        hz: set.axis().hz(k),
        what,
        got,
    };
    if let Some(k) = lines.clone().find(|k| !values[*k].is_finite()) {
        return Err(error(k, "value", values[k].to_string()));
    }
    let overflows = |k: &usize| !values[*k].norm_sqr().is_finite();
    if let Some(k) = lines.clone().find(overflows) {
        return Err(error(k, "square of the value", format!("{:e}", values[k])));
    }
    let Some(variance) = set.variance(i) else {
        return Ok(());
    };
    let legal = |v: f64| v.is_finite() && v >= 0.0;
    match lines.clone().find(|k| !legal(variance[*k])) {
        Some(k) => Err(error(k, "variance of 0 or more", variance[k].to_string())),
        None => Ok(()),
    }
}
