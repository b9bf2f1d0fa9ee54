//! Coherence and relative standard deviation of functions at their resonances.

use num_complex::Complex64;

use super::mobility::Mobilities;
use crate::frf::FrfSet;
use crate::frf::peaks::clear_peaks;

/// Power of a resonance over the median of its function, 15 dB. Larger: fewer resonances are
/// assessed. Smaller: a mode near its node is, whose low coherence no further hit raises
/// (`resonances_have_the_standard_deviation_of_their_noise`).
const MIN_PEAK_OVER_MEDIAN: f64 = 30.0;
/// Power of a resonance over the variance of its function, 10 dB. Larger: a coherence of three hits
/// below 0.9 is never seen where noise lowers it. Smaller: noise at low frequencies, where that of
/// the mobility is large, has such peaks (`noise_has_no_resonance`).
const MIN_PEAK_OVER_NOISE: f64 = 10.0;
/// Lines between the half-power points of a resonance.
const MIN_LINES_PER_BANDWIDTH: f64 = 3.0;

/// A function at one of its resonances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::frf) struct Resonance {
    /// Number of the function in the set.
    pub function: usize,
    pub hz: f64,
    /// Coherence between the half-power points, weighted by the power of the mobility.
    pub coherence: Option<f64>,
    /// Standard deviation of the magnitude there over the magnitude: half of the variance of the
    /// FRF lies along it.
    pub relative_std: f64,
}

/// Every function of a set at its resonances.
pub(in crate::frf) fn resonances(set: &FrfSet) -> Vec<Resonance> {
    let Some(data) = Mobilities::new(set) else {
        return Vec::new();
    };
    let functions = 0..data.functions().len();
    functions
        .flat_map(|function| of_function(set, &data, function))
        .collect()
}

fn of_function(set: &FrfSet, data: &Mobilities, function: usize) -> Vec<Resonance> {
    let power: Vec<f64> = (data.values(function).iter())
        .map(Complex64::norm_sqr)
        .collect();
    let mut sorted = power.clone();
    let middle = sorted.len() / 2;
    let median = *sorted.select_nth_unstable_by(middle, f64::total_cmp).1;
    let over_noise = |noise: &f64| MIN_PEAK_OVER_NOISE * noise;
    let floor: Vec<f64> = (data.noise(function).iter())
        .map(|noise| over_noise(noise).max(MIN_PEAK_OVER_MEDIAN * median))
        .collect();
    let variance = data.variance(function);
    let first_line = data.lines().start;
    let coherence = set.coherence(function);
    let resonance = |inside: std::ops::Range<usize>, line: usize| {
        let energy: f64 = power[inside.clone()].iter().sum();
        let weighted = |coherence: &[f64]| {
            let lines = inside.clone();
            let weighted = lines.map(|k| power[k] * coherence[first_line + k]);
            weighted.sum::<f64>() / energy
        };
        Resonance {
            function,
            hz: set.axis().hz(first_line + line),
            coherence: coherence.map(weighted),
            relative_std: (0.5 * variance[inside.clone()].iter().sum::<f64>() / energy).sqrt(),
        }
    };
    let peaks = clear_peaks(&power, &floor, MIN_LINES_PER_BANDWIDTH);
    let peaks = peaks.iter();
    peaks
        .map(|peak| resonance(peak.inside(), peak.line))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::Band;
    use crate::frf::consistency::synthetic::{Beam, add_noise};

    #[test]
    fn resonances_have_the_standard_deviation_of_their_noise() {
        let mut set = Beam::default().set(&[("1:+Z", "1:+Z")]);
        add_noise(&mut set, 40.0, 1);
        set.valid_band = Some(Band::new(30.0, 480.0).unwrap());
        let found = resonances(&set);
        // The point is near a node of the mode at 310 Hz.
        assert_eq!(found.len(), 4, "{found:?}");
        for (resonance, hz) in found.iter().zip([62.0, 121.0, 205.0, 390.0]) {
            assert!((resonance.hz - hz).abs() < 0.3, "{resonance:?}");
            let line = (resonance.hz / set.axis().step_hz).round() as usize;
            let at_peak =
                (0.5 * set.variance(0).unwrap()[line]).sqrt() / set.values(0)[line].norm();
            let ratio = resonance.relative_std / at_peak;
            // Between the half-power points the power is 0.79 of that of the peak.
            assert!((0.6..2.0).contains(&ratio), "{resonance:?}");
        }
    }

    #[test]
    fn noise_has_no_resonance() {
        for seed in 0..40 {
            let mut set = Beam::default().set(&[("1:+Z", "1:+Z"), ("2:+Z", "1:+Z")]);
            add_noise(&mut set, -40.0, seed);
            assert_eq!(resonances(&set), []);
        }
    }
}
