//! Modes that respond in half of the structure look as if one mode moved from sensor to sensor.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::axis::FrequencyAxis;
use crate::dof::Dof;
use crate::finding::Code;
use crate::identify::synthetic::{Measurement, Structure};

use super::tests::{found, told};

/// Two halves of six points: three families of a mode of each half, so many half-power widths apart, of which the other half has 3 %.
fn halves(seed: u64, widths: f64) -> (Structure, Measurement) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut modes = Vec::new();
    for hz in [20.0, 50.0, 75.0] {
        let mut value = || {
            let sign = if random.random_range(0..2) == 0 {
                1.0
            } else {
                -1.0
            };
            sign * random.random_range(0.3..1.0)
        };
        let half: Vec<f64> = (0..6).map(|_| value()).collect();
        let shape = |left: f64, right: f64| {
            let values = half
                .iter()
                .map(|v| left * v)
                .chain(half.iter().map(|v| right * v));
            values.collect()
        };
        modes.push((hz, 2e-3, shape(1.0, 0.03)));
        modes.push((hz * (1.0 + 4e-3 * widths), 2e-3, shape(-0.03, 1.0)));
    }
    let axis = FrequencyAxis {
        start_hz: 0.0,
        step_hz: 0.01,
        len: 9000,
    };
    let mut how = Measurement {
        snr_db: Some(40.0),
        seed,
        ..Measurement::of_sensors(12, axis)
    };
    let sensors: Vec<Dof> = how.pairs.iter().map(|pair| pair.0.clone()).collect();
    let hits = [0, 6].map(|hit| sensors[hit].clone());
    let of = |hit: &Dof| {
        sensors
            .iter()
            .map(|own| (own.clone(), hit.clone()))
            .collect::<Vec<_>>()
    };
    how.pairs = hits.iter().flat_map(of).collect();
    (Structure { modes }, how)
}

#[test]
fn modes_of_two_halves_are_no_modes_that_move() {
    for widths in [1.0, 1.5, 3.0] {
        for seed in 0..4 {
            let (structure, how) = halves(seed, widths);
            let model = found(&structure.measured(&how));
            assert!(told(&model, Code::RunsMerged).is_empty(), "{widths} {seed}");
            assert_eq!(model.modes.len(), structure.modes.len(), "{widths} {seed}");
        }
    }
}
