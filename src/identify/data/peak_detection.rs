//! Search for resonances: local maxima of the indicator that are peaks, not noise.
//!
//! A maximum becomes a peak when
//! 1. it is the highest point within its half-power band: in both directions the power falls to
//!    half before it rises above the maximum, at least on one side; on the other side the band may
//!    end, or a higher line may follow, but only at a larger distance;
//! 2. it exceeds the noise. With the FRFs whitened by their variances, the deviation of the vector
//!    of all `n` FRFs at the maximum from the straight line between its two flank lines has, for
//!    noise on a smooth background, a power that is chi-squared with `2n` degrees of freedom. The
//!    limit is its quantile at `1 − p/N` for the stated false-alarm probability `p` in the whole
//!    band of `N` lines (Bonferroni). This is valid on any straight background, so that noise on
//!    the skirt of a resonance 60 dB above it does not pass. Where a higher line ends one flank,
//!    the dip before it must exceed the noise as well: on a curved background, as at an
//!    antiresonance, the flank lines of a noise maximum are distant and off any straight line;
//! 3. it is stable: the values run clockwise with frequency, which is what a pole with positive
//!    damping does.
//!
//! A peak must also be fitted later by the method, or its phase must change between its half-power
//! points as that of a resonance does ([`reject_background_maxima`]).
//!
//! A maximum that exceeds the noise and fails another criterion is rejected with a finding; noise
//! is rejected without one.

use std::f64::consts::TAU;

use num_complex::Complex64;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::detection_spectrum::DetectionSpectrum;
use crate::identify::data::half_power::half_power;
use crate::identify::data::line_noise::LineNoise;

/// Minimum phase change between the half-power points, over that of a resonance: noise or a
/// neighbour may hide most of it. Before an antiresonance the phase changes in the other direction.
pub(in crate::identify) const MIN_PHASE_CHANGE_RATIO: f64 = 0.2;

/// End of the search from a maximum to one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) enum PeakFlank {
    /// First line below half power.
    Half(usize),
    /// A line above the maximum comes first.
    Higher {
        /// First line above the maximum.
        line: usize,
        /// Lowest line before it.
        valley: usize,
    },
    /// The band ends first.
    Edge(usize),
}

impl PeakFlank {
    /// The line that the maximum is compared with.
    fn foot(self) -> usize {
        match self {
            PeakFlank::Half(line) | PeakFlank::Edge(line) => line,
            PeakFlank::Higher { valley, .. } => valley,
        }
    }

    /// Lines between the maximum and the end of the search.
    fn distance(self, top: usize) -> usize {
        match self {
            PeakFlank::Half(line) | PeakFlank::Edge(line) | PeakFlank::Higher { line, .. } => {
                line.abs_diff(top)
            }
        }
    }
}

/// A maximum of the indicator with its flanks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) struct Peak {
    /// Line of the maximum.
    pub line: usize,
    /// Towards lower frequencies.
    pub left: PeakFlank,
    /// Towards higher frequencies.
    pub right: PeakFlank,
    /// Indicator at the maximum.
    pub power: f64,
}

/// Reason why a maximum above the noise is no peak.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) enum PeakRejection {
    /// A higher line inside the half-power band: power at the maximum over power in the valley, at
    /// least 2 expected.
    NotHighest(f64),
    /// Not fitted, with a phase change below [`MIN_PHASE_CHANGE_RATIO`] of that of a resonance.
    NotTurning(f64),
    /// Anticlockwise: relative area of the triangle of the three lines, more than 0 expected.
    Unstable(f64),
}

/// Result of the search, in ascending frequency.
#[derive(Debug, Default)]
pub(in crate::identify) struct DetectedPeaks {
    /// Resonances.
    pub peaks: Vec<Peak>,
    /// Rejected maxima above the noise.
    pub dropped: Vec<(Peak, PeakRejection)>,
}

impl DetectedPeaks {
    /// The peaks and the maxima whose values run anticlockwise, in ascending frequency: with less
    /// than a line in its half-power band, the direction of a resonance is undetermined.
    pub fn of_any_direction(&self) -> Vec<Peak> {
        let is_anticlockwise =
            |rejection: &PeakRejection| matches!(rejection, PeakRejection::Unstable(_));
        let dropped = self.dropped.iter();
        let anticlockwise = dropped.filter(|(_, rejection)| is_anticlockwise(rejection));
        let anticlockwise = anticlockwise.map(|(peak, _)| *peak);
        let mut peaks: Vec<Peak> = self.peaks.iter().copied().chain(anticlockwise).collect();
        peaks.sort_by_key(|peak| peak.line);
        peaks
    }
}

/// Searches the indicator for peaks above the noise of the FRFs, at a false-alarm probability for
/// the whole band.
pub(in crate::identify) fn search(
    frfs: &BandFrfs,
    noise: &[LineNoise],
    indicator: &DetectionSpectrum,
    false_alarm: f64,
) -> DetectedPeaks {
    let limit = noise_limit(frfs.functions(), frfs.lines(), false_alarm);
    let mut found = DetectedPeaks::default();
    for line in 1..frfs.lines() - 1 {
        let Some(peak) = maximum_at(&indicator.power, line) else {
            continue;
        };
        match rejection_reason(frfs, indicator, &peak) {
            _ if deviation(frfs, noise, &peak) <= limit => {}
            None | Some(PeakRejection::NotHighest(_))
                if !exceeds_its_valley(frfs, noise, indicator, &peak, limit) => {}
            None => found.peaks.push(peak),
            Some(drop) => found.dropped.push((peak, drop)),
        }
    }
    found
}

/// Rejects the peaks in which no resonance could be fitted and whose phase does not change as that
/// of one: maxima of the background, such as that between a minimum and an antiresonance. Returns
/// whether there were any.
pub(in crate::identify) fn reject_background_maxima(
    found: &mut DetectedPeaks,
    frfs: &BandFrfs,
    indicator: &DetectionSpectrum,
    fitted: impl Fn(usize) -> bool,
) -> bool {
    let peaks = std::mem::take(&mut found.peaks);
    let before = peaks.len();
    for (mode, peak) in peaks.into_iter().enumerate() {
        let turn = relative_phase_change(frfs, indicator, &peak);
        if fitted(mode) || turn >= MIN_PHASE_CHANGE_RATIO {
            found.peaks.push(peak);
        } else {
            found.dropped.push((peak, PeakRejection::NotTurning(turn)));
        }
    }
    found.dropped.sort_by_key(|(peak, _)| peak.line);
    found.peaks.len() < before
}

/// Clockwise angle between the half-power points that exist, or between one and the maximum, over
/// that of a resonance: 45 degrees on either side.
fn relative_phase_change(frfs: &BandFrfs, indicator: &DetectionSpectrum, peak: &Peak) -> f64 {
    let foot = |flank: PeakFlank| match flank {
        PeakFlank::Half(line) => (line, 1.0),
        _ => (peak.line, 0.0),
    };
    let ((low, left), (high, right)) = (foot(peak.left), foot(peak.right));
    let term = |(f, weight): (usize, &f64)| {
        weight * frfs.values.at(f, low).conj() * frfs.values.at(f, high)
    };
    let sum: Complex64 = indicator.weights.iter().enumerate().map(term).sum();
    let sides: f64 = left + right;
    -sum.arg() / (sides.max(1.0) * std::f64::consts::FRAC_PI_4)
}

/// Quantile of chi-squared with `2n` degrees of freedom at `1 − p/N`.
pub(in crate::identify) fn noise_limit(functions: usize, lines: usize, false_alarm: f64) -> f64 {
    let tail_probability = (false_alarm / lines as f64).clamp(1e-14, 0.5);
    ChiSquared::new(2.0 * functions as f64)
        .expect("degrees of freedom are positive")
        .inverse_cdf(1.0 - tail_probability)
}

fn maximum_at(power: &[f64], line: usize) -> Option<Peak> {
    let top = power[line];
    (top > 0.0 && top >= power[line - 1] && top > power[line + 1]).then(|| Peak {
        line,
        left: flank(power, top, (0..line).rev()),
        right: flank(power, top, line + 1..power.len()),
        power: top,
    })
}

fn flank(power: &[f64], top: f64, outwards: impl Iterator<Item = usize>) -> PeakFlank {
    let mut valley = (f64::INFINITY, 0);
    let mut last = 0;
    for line in outwards {
        if power[line] > top {
            return PeakFlank::Higher {
                line,
                valley: valley.1,
            };
        }
        if power[line] < 0.5 * top {
            return PeakFlank::Half(line);
        }
        if power[line] < valley.0 {
            valley = (power[line], line);
        }
        last = line;
    }
    PeakFlank::Edge(last)
}

/// Weight of the left foot in the straight line between the feet, at the maximum.
fn left_weight(peak: &Peak) -> f64 {
    let (left, right) = (peak.left.foot(), peak.right.foot());
    (right - peak.line) as f64 / (right - left) as f64
}

/// Squared deviation from the line between the feet over the variance of its noise, summed over
/// FRFs; for noise on a straight line chi-squared with two degrees of freedom for every FRF.
fn deviation(frfs: &BandFrfs, noise: &[LineNoise], peak: &Peak) -> f64 {
    let (left, top, right) = (peak.left.foot(), peak.line, peak.right.foot());
    let weight_of_left = left_weight(peak);
    let term = |(f, noise): (usize, &LineNoise)| {
        let h = |line| frfs.values.at(f, line);
        let between = weight_of_left * h(left) + (1.0 - weight_of_left) * h(right);
        let variance = noise.variance(top)
            + weight_of_left * weight_of_left * noise.variance(left)
            + (1.0 - weight_of_left).powi(2) * noise.variance(right);
        2.0 * (h(top) - between).norm_sqr() / variance
    };
    noise.iter().enumerate().map(term).sum()
}

/// Lowest line before a higher one.
fn valley(peak: &Peak) -> Option<usize> {
    [peak.left, peak.right]
        .into_iter()
        .find_map(|flank| match flank {
            PeakFlank::Higher { valley, .. } => Some(valley),
            _ => None,
        })
}

/// Whether the dip before a higher line exceeds the noise; true without a higher line.
fn exceeds_its_valley(
    frfs: &BandFrfs,
    noise: &[LineNoise],
    indicator: &DetectionSpectrum,
    peak: &Peak,
    limit: f64,
) -> bool {
    valley(peak).is_none() || dip(frfs, noise, indicator, peak) > limit
}

/// Squared difference of the root of the indicator at the maximum and in the valley before the
/// higher line, over its variance `Σ w²ω⁴|R|²v / S`. On the flank of a resonance the phase changes
/// as well, without a peak: only the magnitude counts here.
fn dip(frfs: &BandFrfs, noise: &[LineNoise], indicator: &DetectionSpectrum, peak: &Peak) -> f64 {
    let Some(valley) = valley(peak) else {
        return 0.0;
    };
    let line = peak.line;
    let term = |f: usize| {
        let weighted = indicator.weights[f] * frfs.omega[line].powi(2);
        weighted * weighted * frfs.values.at(f, line).norm_sqr() * noise[f].variance(line)
    };
    let variance: f64 = (0..frfs.functions()).map(term).sum::<f64>() / peak.power;
    let difference = peak.power.sqrt() - indicator.power[valley].sqrt();
    difference * difference / variance
}

fn rejection_reason(
    frfs: &BandFrfs,
    indicator: &DetectionSpectrum,
    peak: &Peak,
) -> Option<PeakRejection> {
    if !is_highest_in_its_band(peak) {
        let lowest = valley(peak).map_or(peak.power, |line| indicator.power[line]);
        return Some(PeakRejection::NotHighest(peak.power / lowest));
    }
    let turn = clockwise_area(frfs, indicator, peak);
    (turn <= 0.0).then_some(PeakRejection::Unstable(turn))
}

fn is_highest_in_its_band(peak: &Peak) -> bool {
    let distance = |flank: PeakFlank| flank.distance(peak.line);
    match (peak.left, peak.right) {
        (PeakFlank::Half(_), PeakFlank::Half(_) | PeakFlank::Edge(_))
        | (PeakFlank::Edge(_), PeakFlank::Half(_)) => true,
        (PeakFlank::Half(_), other) => distance(other) > distance(peak.left),
        (other, PeakFlank::Half(_)) => distance(other) > distance(peak.right),
        _ => false,
    }
}

/// Twice the clockwise area of the triangles left foot, maximum, right foot over the sum of the
/// products of their sides at the maximum; positive for positive damping, whatever constant is
/// added to the resonance.
fn clockwise_area(frfs: &BandFrfs, indicator: &DetectionSpectrum, peak: &Peak) -> f64 {
    let (left, top, right) = (peak.left.foot(), peak.line, peak.right.foot());
    let (mut area, mut sides) = (0.0, 0.0);
    for (f, weight) in indicator.weights.iter().enumerate() {
        let h = |line| frfs.values.at(f, line);
        let (rise, fall) = (h(top) - h(left), h(right) - h(top));
        area -= weight * (rise.conj() * fall).im;
        sides += weight * rise.norm() * fall.norm();
    }
    if sides > 0.0 { area / sides } else { 0.0 }
}

/// First estimate of a pole, rad/s, from the lines of the indicator around its peak: frequency by a
/// parabola, decay rate from the nearer half-power point; within the valleys to the neighbouring
/// maxima.
pub(in crate::identify) fn first_pole(
    frfs: &BandFrfs,
    indicator: &DetectionSpectrum,
    found: &DetectedPeaks,
    peak: &Peak,
) -> Complex64 {
    let maxima = found
        .peaks
        .iter()
        .chain(found.dropped.iter().map(|(other, _)| other));
    let (mut first, mut end) = (0, frfs.lines());
    for other in maxima.map(|other| other.line) {
        if other < peak.line {
            first = first.max(lowest_line(&indicator.power, other..peak.line));
        } else if other > peak.line {
            end = end.min(lowest_line(&indicator.power, peak.line + 1..other + 1) + 1);
        }
    }
    let (omega, power) = (&frfs.omega[first..end], &indicator.power[first..end]);
    let side = (peak.line - first).min(end - 1 - peak.line).max(1);
    half_power(omega, power, peak.line - first).map_or_else(
        || Complex64::new(-0.5 * side as f64 * frfs.step, frfs.omega[peak.line]),
        |fit| Complex64::new(-fit.narrower_rad_s(), fit.omega_rad_s),
    )
}

fn lowest_line(power: &[f64], lines: std::ops::Range<usize>) -> usize {
    let start = lines.start;
    lines
        .min_by(|a, b| power[*a].total_cmp(&power[*b]))
        .unwrap_or(start)
}

/// Frequency of a line, Hz.
pub(in crate::identify) fn hz(frfs: &BandFrfs, line: usize) -> f64 {
    frfs.omega[line] / TAU
}
