//! Test with little noise, light damping and modes beyond both ends of the data: the out-of-band
//! terms must not bias the modes.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::axis::{Band, FrequencyAxis};
use crate::identify::estimator::IdentifyOptions;
use crate::identify::identify;
use crate::identify::synthetic::{Measurement, Structure};
use crate::identify::tests::seeds;

/// Six modes of 0.1 to 0.6 % between 55 and 480 Hz, one below and one above, at eight sensors with
/// two references.
fn lightly_damped(seed: u64) -> (Structure, Measurement) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut hz = vec![
        random.random_range(30.0..45.0),
        random.random_range(525.0..560.0),
    ];
    hz.extend((0..6).map(|n| 60.0 + 70.0 * f64::from(n) + random.random_range(0.0..50.0)));
    let mode = |hz: f64| {
        let damping = random.random_range(1e-3..6e-3);
        let shape: Vec<f64> = (0..8).map(|_| random.random_range(-1.0..1.0)).collect();
        (hz, damping, shape)
    };
    let modes: Vec<_> = hz.into_iter().map(mode).collect();
    let axis = FrequencyAxis {
        start_hz: 45.0,
        step_hz: 0.1,
        len: 4700,
    };
    let mut how = Measurement {
        snr_db: Some(84.0),
        variance_given: seed.is_multiple_of(2),
        seed,
        ..Measurement::of_sensors(8, axis)
    };
    let sensors = how.pairs.clone();
    let second = sensors
        .iter()
        .map(|pair| (pair.0.clone(), sensors[1].0.clone()));
    how.pairs.extend(second);
    (Structure { modes }, how)
}

#[test]
fn modes_far_above_the_noise_are_all_found_with_modes_beyond_the_data() {
    let options = IdentifyOptions {
        band: Some(Band {
            lo_hz: 50.0,
            hi_hz: 500.0,
        }),
        ..IdentifyOptions::default()
    };
    for seed in seeds(12) {
        let (structure, how) = lightly_damped(seed);
        let model = identify(&structure.measured(&how), &options).unwrap();
        let inside = structure
            .modes
            .iter()
            .filter(|mode| mode.0 > 50.0 && mode.0 < 500.0);
        let mut true_hz: Vec<f64> = inside.map(|mode| mode.0).collect();
        true_hz.sort_by(f64::total_cmp);
        let found_hz: Vec<f64> = model.modes.iter().map(|mode| mode.frequency_hz).collect();
        assert_eq!(
            found_hz.len(),
            true_hz.len(),
            "{seed}: {found_hz:?} {true_hz:?}"
        );
        for (mode, hz) in model.modes.iter().zip(true_hz) {
            let error_hz = (mode.frequency_hz - hz).abs();
            let std = mode.frequency_std_hz.unwrap();
            assert!(
                error_hz < 5.0 * std && std < 1e-4,
                "{seed}: {hz} {error_hz:e} {std:e}"
            );
        }
    }
}
