//! The stated variance of an FRF agrees with its scatter, and its intervals with their degrees of
//! freedom.

use modalign::dof::Dof;
use modalign::frf::{EstimateOptions, estimate};
use modalign::modal::{ModalModel, Mode, ModeShape, Scaling};
use modalign::quantity::Quantity;
use modalign::record::{Channel, Hit, Samples};
use modalign::signal::ExponentialWindow;
use modalign::synth::{Faults, HammerTest, LowPassOptions, Noise, Pulse, Truth, roving_hammer};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Tests for each number of hits: with some 800 lines each, 80,000 intervals of the real and of the
/// imaginary part.
const TESTS: u64 = 100;

/// Noise of the response channels over the rms of a record at the nominal hit, and of the force
/// over its peak: 40 and 80 dB. The noise of a sensor does not depend on the force: it is the same
/// in every hit.
const RESPONSE_NOISE: f64 = 1e-2;
const FORCE_NOISE: f64 = 1e-4;

/// Three modes and an anti-alias filter, without noise.
fn test(hits: usize, seed: u64) -> HammerTest {
    let dofs: Vec<Dof> = ["1:+Z", "2:+Z"].map(|dof| dof.parse().unwrap()).to_vec();
    let modes = [(110.0, 1.0, 0.8), (260.0, -0.7, 1.1), (415.0, 0.9, 0.4)];
    let modes = modes.map(|(hz, first, second)| {
        let shape = ModeShape::new([
            (dofs[0].clone(), f64::into(first)),
            (dofs[1].clone(), f64::into(second)),
        ]);
        Mode::new(hz, Some(0.01), shape, Scaling::UnitModalMass)
    });
    let model = ModalModel {
        modes: modes.to_vec(),
        ..ModalModel::default()
    };
    HammerTest {
        truth: Truth::from_real_shapes(&model, &dofs, &dofs[..1]).unwrap(),
        hits: roving_hammer(&dofs[..1], &dofs),
        averages_per_point: hits,
        sampling_rate_hz: 2048.0,
        samples: 4096,
        pretrigger_s: 0.05,
        quantity: Quantity::Acceleration,
        pulse: Pulse {
            peak_n: 100.0,
            peak_spread: 0.3,
            duration_s: 2e-3,
            duration_spread: 0.1,
        },
        filter: LowPassOptions::default(),
        noise: Noise::default(),
        faults: Faults::default(),
        seed,
    }
}

/// The hits with the noise of their channels, from a separate random generator.
fn with_noise(hits: &[Hit], seed: u64) -> Vec<Hit> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut noisy = |channel: &Channel, rms: f64| {
        let samples = channel.samples.to_f64();
        let mut drawn = || -> f64 { StandardNormal.sample(&mut random) };
        Channel {
            samples: Samples::F64(samples.iter().map(|x| x + rms * drawn()).collect()),
            ..channel.clone()
        }
    };
    let rms = |channel: &Channel| {
        let samples = channel.samples.to_f64();
        (samples.iter().map(|x| x * x).sum::<f64>() / samples.len() as f64).sqrt()
    };
    let levels: Vec<f64> = hits[0].responses.iter().map(rms).collect();
    let mut hit = |clean: &Hit| {
        let responses = clean.responses.iter().zip(&levels);
        Hit {
            force: noisy(&clean.force, 100.0 * FORCE_NOISE),
            responses: responses
                .map(|(channel, level)| noisy(channel, RESPONSE_NOISE * level))
                .collect(),
            ..clean.clone()
        }
    };
    hits.iter().map(&mut hit).collect()
}

/// Sums over lines and tests.
#[derive(Clone, Copy, Default)]
struct Sums {
    stated: f64,
    observed: f64,
    inside: usize,
    intervals: usize,
}

impl Sums {
    fn add(self, other: Sums) -> Sums {
        Sums {
            stated: self.stated + other.stated,
            observed: self.observed + other.observed,
            inside: self.inside + other.inside,
            intervals: self.intervals + other.intervals,
        }
    }
}

/// One noisy test against the same hits without noise.
fn compare(hits: usize, seed: u64, options: &EstimateOptions) -> Sums {
    let hits = test(hits, seed).generate().unwrap();
    let noisy = estimate(&with_noise(&hits, seed), options).unwrap();
    let clean = estimate(&hits, options).unwrap();
    let lines = noisy.axis().lines(&noisy.valid_band.unwrap());
    let mut sums = Sums::default();
    for index in 0..noisy.len() {
        let freedom = noisy.functions()[index].variance_dof.unwrap();
        let quantile = StudentsT::new(0.0, 1.0, freedom)
            .unwrap()
            .inverse_cdf(0.975);
        for line in lines.clone() {
            let variance = noisy.variance(index).unwrap()[line];
            let error = noisy.values(index)[line] - clean.values(index)[line];
            sums.stated += variance;
            sums.observed += error.norm_sqr();
            // Each of the real and the imaginary part has half the variance.
            let half = quantile * (0.5 * variance).sqrt();
            sums.inside += usize::from(error.re.abs() < half) + usize::from(error.im.abs() < half);
            sums.intervals += 2;
        }
    }
    sums
}

#[test]
fn the_stated_variance_is_the_scatter_and_its_intervals_cover() {
    let windowed = EstimateOptions {
        exponential: Some(ExponentialWindow { decay_rad_s: 3.0 }),
        cut_pretrigger: true,
        ..EstimateOptions::default()
    };
    for (name, options) in [
        ("no window", EstimateOptions::default()),
        ("exponential", windowed),
    ] {
        for hits in [3, 5, 10] {
            let sums = (0..TESTS)
                .into_par_iter()
                .map(|seed| compare(hits, 1000 * hits as u64 + seed, &options))
                .collect::<Vec<_>>();
            let sums = sums.into_iter().fold(Sums::default(), Sums::add);
            let ratio = sums.stated / sums.observed;
            let covered = 100.0 * sums.inside as f64 / sums.intervals as f64;
            println!(
                "{name}, {hits} hits: stated over observed variance {ratio:.4}; 95 % intervals cover {covered:.2} % of {}",
                sums.intervals
            );
            assert!((0.95..=1.05).contains(&ratio), "{name} {hits}: {ratio}");
            assert!((94.0..=96.0).contains(&covered), "{name} {hits}: {covered}");
        }
    }
}
