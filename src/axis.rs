//! Evenly spaced time and frequency axes, and bands. No axis has a default spacing.

use serde::{Deserialize, Serialize};

/// A closed frequency band in Hz, `lo_hz <= hi_hz`, both finite and not negative.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Band {
    /// Lower edge.
    pub lo_hz: f64,
    /// Upper edge.
    pub hi_hz: f64,
}

/// Why two numbers are not a band.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("got band {lo_hz} to {hi_hz} Hz, expected 0 <= lower edge < upper edge, both finite")]
pub struct BandError {
    /// Lower edge as given.
    pub lo_hz: f64,
    /// Upper edge as given.
    pub hi_hz: f64,
}

impl Band {
    /// A band from its edges.
    ///
    /// # Errors
    /// [`BandError`] when an edge is negative or not finite, or the edges are out of order.
    pub fn new(lo_hz: f64, hi_hz: f64) -> Result<Self, BandError> {
        if lo_hz >= 0.0 && lo_hz < hi_hz && hi_hz.is_finite() {
            Ok(Self { lo_hz, hi_hz })
        } else {
            Err(BandError { lo_hz, hi_hz })
        }
    }

    /// Whether a frequency lies inside, edges included.
    pub fn contains(&self, frequency_hz: f64) -> bool {
        frequency_hz >= self.lo_hz && frequency_hz <= self.hi_hz
    }

    /// The common part of two bands, when there is one.
    pub fn intersection(&self, other: &Band) -> Option<Band> {
        Band::new(self.lo_hz.max(other.lo_hz), self.hi_hz.min(other.hi_hz)).ok()
    }

    /// Upper minus lower edge.
    pub fn width_hz(&self) -> f64 {
        self.hi_hz - self.lo_hz
    }
}

/// Evenly spaced time axis: sample `i` lies at `start_s + i * step_s`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeAxis {
    /// Time of the first sample.
    pub start_s: f64,
    /// Spacing, positive.
    pub step_s: f64,
    /// Number of samples.
    pub len: usize,
}

impl TimeAxis {
    /// Samples per second.
    pub fn sampling_rate_hz(&self) -> f64 {
        1.0 / self.step_s
    }

    /// Record length `len * step_s`.
    pub fn duration_s(&self) -> f64 {
        self.len as f64 * self.step_s
    }

    /// The frequency axis of the one-sided discrete Fourier transform of a whole record.
    pub fn spectrum_axis(&self) -> FrequencyAxis {
        FrequencyAxis {
            start_hz: 0.0,
            step_hz: 1.0 / self.duration_s(),
            len: self.len / 2 + 1,
        }
    }
}

/// Evenly spaced frequency axis: line `k` lies at `start_hz + k * step_hz`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrequencyAxis {
    /// Frequency of the first line.
    pub start_hz: f64,
    /// Spacing, positive.
    pub step_hz: f64,
    /// Number of lines.
    pub len: usize,
}

impl FrequencyAxis {
    /// Frequency of line `k`, Hz.
    pub fn hz(&self, k: usize) -> f64 {
        self.start_hz + k as f64 * self.step_hz
    }

    /// Angular frequency of line `k`, rad/s.
    pub fn rad_s(&self, k: usize) -> f64 {
        std::f64::consts::TAU * self.hz(k)
    }

    /// The lines inside a band, edges included within a millionth of the spacing.
    pub fn lines(&self, band: &Band) -> std::ops::Range<usize> {
        let position = |hz: f64| (hz - self.start_hz) / self.step_hz;
        let first = (position(band.lo_hz) - 1e-6).ceil().max(0.0) as usize;
        let end = ((position(band.hi_hz) + 1e-6).floor() + 1.0).max(0.0) as usize;
        let end = end.min(self.len);
        first.min(end)..end
    }

    /// The line nearest to a frequency, when it lies within half a spacing of the axis.
    pub fn nearest(&self, frequency_hz: f64) -> Option<usize> {
        let k = ((frequency_hz - self.start_hz) / self.step_hz).round();
        (k >= 0.0 && k < self.len as f64).then_some(k as usize)
    }

    /// From the first to the last line; `None` for fewer than two lines.
    pub fn band(&self) -> Option<Band> {
        (self.len >= 2).then(|| Band {
            lo_hz: self.start_hz,
            hi_hz: self.hz(self.len - 1),
        })
    }

    /// Whether two axes have the same lines: same count, spacing and start within 1e-9 of the span.
    pub fn same_lines(&self, other: &FrequencyAxis) -> bool {
        let span = self.step_hz * self.len as f64;
        self.len == other.len
            && (self.start_hz - other.start_hz).abs() <= 1e-9 * span
            && (self.step_hz - other.step_hz).abs() * self.len as f64 <= 1e-9 * span
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_a_band_include_both_edges() {
        let axis = FrequencyAxis {
            start_hz: 0.0,
            step_hz: 0.1,
            len: 101,
        };
        assert_eq!(axis.lines(&Band::new(0.3, 0.7).unwrap()), 3..8);
        assert_eq!(axis.lines(&Band::new(9.95, 20.0).unwrap()), 100..101);
        assert_eq!(axis.lines(&Band::new(11.0, 20.0).unwrap()).len(), 0);
    }

    #[test]
    fn a_band_needs_ordered_finite_edges() {
        for (lo, hi) in [
            (2.0, 1.0),
            (-1.0, 1.0),
            (0.0, f64::INFINITY),
            (f64::NAN, 1.0),
        ] {
            assert!(Band::new(lo, hi).is_err());
        }
    }
}
