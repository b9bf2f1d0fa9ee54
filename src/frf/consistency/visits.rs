//! Drift over a test: natural frequency and residue of isolated resonances at one excitation point,
//! from its first hits and from those after other points were hit.

use std::collections::BTreeMap;

use num_complex::Complex64;

use super::channel_delay::fit_lines;
use super::mass_loading::SummedFrfs;
use super::mobility::Mobilities;
use super::repeatability::LIMIT;
use crate::dof::Dof;
use crate::frf::FrfSet;
use crate::frf::local_pole::{LocalPole, ResonanceLines};

/// Standard deviations of a change that is a drift: one of 1.7 million by chance, with variances of
/// few degrees of freedom one of thousands. Smaller: noise drifts (`noise_is_no_drift`).
const MIN_CHANGE_STDS: f64 = 5.0;

/// Changes from the first hits at an excitation point to the last ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Drift {
    /// The excitation point.
    pub reference: Dof,
    /// Numbers of its first hits.
    pub first_hits: Vec<usize>,
    /// Numbers of its last hits, after hits at other points.
    pub last_hits: Vec<usize>,
    /// Isolated resonances that both show, by frequency.
    pub resonances: Vec<ResonanceDrift>,
}

/// Change of one resonance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResonanceDrift {
    /// Natural frequency of the first hits, Hz.
    pub hz: f64,
    /// Relative change of the frequency.
    pub frequency: Change,
    /// Relative change of the magnitude of the residue.
    pub amplitude: Change,
}

/// A relative change with its standard deviation and its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// The change.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
    /// Its limit: the one of consequence, or that of the standard deviation.
    pub limit: f64,
}

impl Change {
    fn new(value: f64, std: f64, limit: f64) -> Self {
        let limit = limit.max(MIN_CHANGE_STDS * std);
        Self { value, std, limit }
    }

    /// Whether it is above its limit.
    pub fn is_drift(&self) -> bool {
        self.value.abs() > self.limit
    }
}

/// The change of every isolated resonance of the averaged functions.
///
/// A pole is fitted to each function of the first and of the last hits; changes are weighted means
/// over the functions. The limit is that of repeated measurements, 5 %: of the residue, and of the
/// FRF at a half-power point, which a shift of `d` half-power bandwidths changes by `√2 d`.
pub(in crate::frf) fn resonance_drifts(
    averaged: &FrfSet,
    mut first: FrfSet,
    mut last: FrfSet,
) -> Vec<ResonanceDrift> {
    (first.valid_band, last.valid_band) = (averaged.valid_band, averaged.valid_band);
    let all = [averaged, &first, &last].map(Mobilities::new);
    let [Some(averaged), Some(first), Some(last)] = all else {
        return Vec::new();
    };
    let step_rad_s = averaged.omega[1] - averaged.omega[0];
    let drift = |peak: &crate::frf::peaks::Peak| {
        let lines = fit_lines(peak, averaged.omega.len())?;
        let range = [averaged.omega[lines.start], averaged.omega[lines.end - 1]];
        let last = poles(&last, range);
        let before = poles(&first, range).into_iter();
        let both = before.filter_map(|(dof, before)| Some([before, *last.get(&dof)?]));
        drift(&both.collect::<Vec<_>>(), peak.width() * step_rad_s)
    };
    let peaks = SummedFrfs::new(&averaged).isolated_peaks();
    peaks.iter().filter_map(drift).collect()
}

/// The pole in a range of angular frequency in each function, by its response.
fn poles(data: &Mobilities, range: [f64; 2]) -> BTreeMap<Dof, LocalPole> {
    let start = data.omega.partition_point(|omega| *omega < range[0]);
    let end = data.omega.partition_point(|omega| *omega <= range[1]);
    let functions = data.functions().iter().enumerate();
    let fitted = functions.filter_map(|(i, function)| {
        let (values, variance) = (data.values(i), data.variance(i));
        let lines = ResonanceLines::of(start..end, &data.omega, &values, &variance);
        let response = function.response.without_sign_and_repeat();
        Some((response, lines.fit()?))
    });
    fitted.collect()
}

/// Weighted means over the functions; `None` without one.
fn drift(poles: &[[LocalPole; 2]], width_rad_s: f64) -> Option<ResonanceDrift> {
    let omega = poles.first()?[0].lambda.im;
    let frequencies = poles.iter().map(|[first, last]| {
        let variance = first.frequency_variance + last.frequency_variance;
        (last.lambda.im - first.lambda.im, variance)
    });
    let amplitudes = poles.iter().map(|[first, last]| {
        let size = |residue: Complex64| residue.norm();
        let change = size(last.residue) / size(first.residue) - 1.0;
        // A circular variance is as large along the residue as across it.
        (change, first.phase_variance + last.phase_variance)
    });
    let (shift, shift_std) = weighted_mean(frequencies);
    let (amplitude, amplitude_std) = weighted_mean(amplitudes);
    let shift_limit = LIMIT * width_rad_s / std::f64::consts::SQRT_2;
    Some(ResonanceDrift {
        hz: omega / std::f64::consts::TAU,
        frequency: Change::new(shift / omega, shift_std / omega, shift_limit / omega),
        amplitude: Change::new(amplitude, amplitude_std, LIMIT),
    })
}

/// Mean by one over the variance, and its standard deviation.
fn weighted_mean(pairs: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    let (sum, weights) = pairs.fold((0.0, 0.0), |(sum, weights), (value, variance)| {
        let weight = 1.0 / variance.max(f64::MIN_POSITIVE);
        (sum + weight * value, weights + weight)
    });
    (sum / weights, weights.sqrt().recip())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::Band;
    use crate::frf::consistency::synthetic::{Beam, add_noise, scaled};

    /// Between the resonances at 62 and 390 Hz and the ends of the axis, where noise is large.
    const BAND_HZ: [f64; 2] = [30.0, 480.0];
    const PAIRS: [(&str, &str); 2] = [("1:+Z", "1:+Z"), ("2:+Z", "1:+Z")];

    fn drifts(last: &FrfSet, snr_db: f64, seed: u64) -> Vec<ResonanceDrift> {
        let mut sets = [Beam::default().set(&PAIRS), last.clone()];
        for (set, seed) in sets.iter_mut().zip(2 * seed..) {
            add_noise(set, snr_db, seed);
        }
        let [first, last] = sets;
        let mut averaged = first.clone();
        averaged.valid_band = Some(Band::new(BAND_HZ[0], BAND_HZ[1]).unwrap());
        resonance_drifts(&averaged, first, last)
    }

    #[test]
    fn a_shift_and_a_gain_are_drifts_with_their_figures() {
        let beam = Beam {
            shift: [1.0, 0.998, 1.0, 1.0, 1.0],
            ..Beam::default()
        };
        let found = drifts(&beam.set(&PAIRS), 40.0, 1);
        assert_eq!(found.len(), 5, "{found:?}");
        for (mode, drift) in found.iter().enumerate() {
            assert_eq!(drift.frequency.is_drift(), mode == 1, "{drift:?}");
            assert!(!drift.amplitude.is_drift(), "{drift:?}");
        }
        assert!((found[1].frequency.value + 0.002).abs() < 1e-4);
        // 5 % of the FRF at a half-power point: 0.035 of the bandwidth of 2 · 0.8 %.
        assert!((found[1].frequency.limit / (0.05 * 0.016 / f64::sqrt(2.0)) - 1.0).abs() < 0.1);
        let set = Beam::default().set(&PAIRS);
        let louder = scaled(&scaled(&set, 0, 1.08), 1, 1.08);
        for drift in drifts(&louder, 60.0, 2) {
            assert!(drift.amplitude.is_drift(), "{drift:?}");
            assert!((drift.amplitude.value - 0.08).abs() < 0.01, "{drift:?}");
        }
        let less = scaled(&scaled(&set, 0, 1.03), 1, 1.03);
        let found = drifts(&less, 60.0, 3);
        assert!(found.iter().all(|drift| !drift.amplitude.is_drift()));
    }

    #[test]
    fn noise_is_no_drift() {
        let set = Beam::default().set(&PAIRS);
        let mut beyond = 0;
        for seed in 0..60 {
            for drift in drifts(&set, 20.0, 10 + seed) {
                for change in [drift.frequency, drift.amplitude] {
                    assert!(!change.is_drift(), "{seed}: {drift:?}");
                    beyond += usize::from(change.value.abs() > 2.5 * change.std);
                }
            }
        }
        assert!(beyond > 0, "a limit of half as many deviations fails");
    }
}
