//! Modes of one half of a structure each are not merged as one mode that shifts between sensors.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::axis::FrequencyAxis;
use crate::dof::Dof;
use crate::finding::Code;
use crate::frf::{FrfSet, FunctionData};
use crate::identify::synthetic::{Measurement, Structure, white_noise};
use crate::identify::tests::seeds;

use crate::identify::run_variation::tests::{findings_of, found};

/// Two halves of six points: three pairs of modes, one of each half, a given number of half-power
/// bandwidths apart, with a small response in the other half.
fn halves(seed: u64, widths: f64, part: f64) -> (Structure, Measurement) {
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
        modes.push((hz, 2e-3, shape(1.0, part)));
        modes.push((hz * (1.0 + 4e-3 * widths), 2e-3, shape(-part, 1.0)));
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
            .map(|sensor| (sensor.clone(), hit.clone()))
            .collect::<Vec<_>>()
    };
    how.pairs = hits.iter().flat_map(of).collect();
    (Structure { modes }, how)
}

#[test]
#[ignore = "long: in release by .ci/run"]
fn modes_of_two_halves_are_not_merged() {
    for widths in [1.0, 1.5, 3.0] {
        for seed in seeds(4) {
            let (structure, how) = halves(seed, widths, 0.03);
            let model = found(&structure.measured(&how));
            assert!(
                findings_of(&model, Code::RunsMerged).is_empty(),
                "{widths} {seed}"
            );
            assert_eq!(model.modes.len(), structure.modes.len(), "{widths} {seed}");
        }
    }
}

/// Noise of equal variance in all FRFs, a given fraction of the largest value, without stated
/// variances.
fn in_common_noise(set: &FrfSet, part: f64, seed: u64) -> FrfSet {
    let functions = 0..set.len();
    let sizes = functions.clone().flat_map(|f| set.values(f));
    let variance = part * part * sizes.map(|v| v.norm_sqr()).fold(0.0, f64::max);
    let mut noisy = FrfSet::new(*set.axis());
    for f in functions {
        let noise = white_noise(set.axis().len, variance, 100 * seed + f as u64);
        let values = set.values(f).iter().zip(noise);
        let data = FunctionData {
            values: values.map(|(v, z)| v + z).collect(),
            ..FunctionData::default()
        };
        noisy.push(set.functions()[f].clone(), data).unwrap();
    }
    noisy
}

#[test]
fn modes_seen_by_half_of_the_runs_each_are_not_merged() {
    // In such noise most runs show only the mode of their half, as if one mode shifted between two
    // frequencies.
    for seed in seeds(6) {
        let (structure, how) = halves(seed, 1.0, 0.01);
        let how = Measurement {
            snr_db: None,
            ..how
        };
        let model = found(&in_common_noise(&structure.measured(&how), 3e-3, seed));
        assert!(findings_of(&model, Code::RunsMerged).is_empty(), "{seed}");
        let true_hz = structure.modes.iter().map(|mode| mode.0);
        assert_eq!(model.modes.len(), structure.modes.len(), "{seed}");
        for (mode, hz) in model.modes.iter().zip(true_hz) {
            let away = (mode.frequency_hz / hz - 1.0).abs();
            assert!(away < 1e-4, "{seed}: {away:e} of {hz}");
        }
    }
}
