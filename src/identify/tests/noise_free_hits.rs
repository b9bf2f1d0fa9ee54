//! FRFs of single hits without noise: what a model of few poles leaves is not noise but the smooth
//! contribution of aliases, and no mode may be lost to it.

use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::axis::{Band, FrequencyAxis};
use crate::frf::{FrfSet, Function, FunctionData};
use crate::identify::estimator::IdentifyOptions;
use crate::identify::identify;
use crate::identify::tests::seeds;
use crate::modal::Pole;
use crate::quantity::FrfKind;

/// Sampling rate, Hz, and samples.
const RATE_HZ: f64 = 2048.0;
const SAMPLES: usize = 4096;

/// Natural frequency, damping ratio and shape of each mode.
type Modes = Vec<(f64, f64, Vec<f64>)>;

/// Three to six modes below 0.3 of the sampling rate, at least 6 % apart, at 2 to 5 sensors.
fn drawn(random: &mut ChaCha8Rng) -> Modes {
    let count = random.random_range(3..=6);
    let sensors = random.random_range(2..=5);
    let mut frequencies: Vec<f64> = (0..count)
        .map(|_| random.random_range(0.04..0.22) * RATE_HZ)
        .collect();
    frequencies.sort_by(f64::total_cmp);
    for mode in 1..count {
        frequencies[mode] = frequencies[mode].max(1.06 * frequencies[mode - 1]);
    }
    let mut component = || {
        let size = random.random_range(0.3..1.5);
        if random.random_bool(0.5) { size } else { -size }
    };
    let shapes: Vec<Vec<f64>> = (0..count)
        .map(|_| (0..sensors).map(|_| component()).collect())
        .collect();
    let modes = frequencies.into_iter().zip(shapes);
    modes
        .map(|(hz, shape)| (hz, random.random_range(0.003..0.02), shape))
        .collect()
}

/// Mobilities of a hit at the first sensor: the transform of the sampled impulse response
/// `2 Re A e^{λt}`, `Δt A/(1 − e^{(λ − iω)Δt})` and its conjugate term.
fn sampled(modes: &Modes) -> FrfSet {
    let axis = FrequencyAxis {
        start_hz: 0.0,
        step_hz: RATE_HZ / SAMPLES as f64,
        len: SAMPLES / 2 + 1,
    };
    let step_s = 1.0 / RATE_HZ;
    let mut set = FrfSet::new(axis);
    for sensor in 0..modes[0].2.len() {
        let value = |k: usize| {
            let omega = Complex64::new(0.0, axis.rad_s(k));
            let term = |amplitude: Complex64, lambda: Complex64| {
                step_s * amplitude / (1.0 - ((lambda - omega) * step_s).exp())
            };
            let of_mode = |(hz, zeta, shape): &(f64, f64, Vec<f64>)| {
                let lambda = Pole::from_frequency(*hz, *zeta).lambda;
                let amplitude = Complex64::new(0.5, -0.5 * lambda.re / lambda.im);
                let terms = term(amplitude, lambda) + term(amplitude.conj(), lambda.conj());
                shape[sensor] * shape[0] * terms
            };
            modes.iter().map(of_mode).sum()
        };
        let function = Function {
            response: format!("{}:+Z", sensor + 1).parse().unwrap(),
            reference: "1:+Z".parse().unwrap(),
            kind: FrfKind::Mobility,
            averages: None,
            estimator: None,
            variance_dof: None,
        };
        let data = FunctionData {
            values: (0..axis.len).map(value).collect(),
            coherence: None,
            variance: None,
        };
        set.push(function, data).unwrap();
    }
    set
}

/// Asserts that the modes, and no others, are found within a tenth of a half-width.
fn assert_all_found(modes: &Modes, what: &str) {
    let options = IdentifyOptions {
        band: Some(Band::new(1.0, 0.34 * RATE_HZ).unwrap()),
        ..IdentifyOptions::default()
    };
    let found = identify(&sampled(modes), &options).unwrap().modes;
    let found: Vec<f64> = found.iter().map(|mode| mode.frequency_hz).collect();
    assert_eq!(found.len(), modes.len(), "{what}: {found:?} {modes:?}");
    for ((hz, zeta, _), found) in modes.iter().zip(&found) {
        assert!((found - hz).abs() < 0.1 * zeta * hz, "{what}: {found} {hz}");
    }
}

#[test]
#[ignore = "long: in release by .ci/run"]
fn a_noise_free_hit_shows_all_modes() {
    for draw in seeds(64) {
        let modes = drawn(&mut ChaCha8Rng::seed_from_u64(draw));
        assert_all_found(&modes, &draw.to_string());
    }
}

#[test]
fn aliases_near_the_band_edge_draw_no_pole_away() {
    // A third of the sampling rate: aliases are larger than in the draws.
    let modes = vec![
        (477.341, 0.00367, vec![-1.4608, 1.6019]),
        (533.549, 0.01720, vec![1.2005, 1.5688]),
        (672.610, 0.01144, vec![0.3913, 1.2014]),
    ];
    assert_all_found(&modes, "near the edge");
}
