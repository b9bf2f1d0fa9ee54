//! Stated standard deviations of modes agree with their errors over whole hammer tests, with
//! default windows and with noise on force and responses.

use modalign::axis::Band;
use modalign::dof::Dof;
use modalign::frf::{HammerOptions, evaluate_hammer_test};
use modalign::identify::{IdentifyOptions, identify};
use modalign::modal::{ModalModel, Mode, ModeShape, Scaling};
use modalign::quantity::Quantity;
use modalign::record::InMemory;
use modalign::synth::{Faults, HammerTest, LowPassOptions, Noise, Pulse, Truth, roving_hammer};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

const TESTS: u64 = 60;
const MODES: usize = 4;
const SENSORS: usize = 6;

/// Parameters of a hammer test.
#[derive(Clone, Copy, Debug)]
struct Case {
    /// Length of a record in time constants of the slowest mode.
    time_constants: f64,
    hits: u32,
    response_snr_db: f64,
    force_snr_db: f64,
}

fn dof(point: usize) -> Dof {
    format!("{point}:+Z").parse().unwrap()
}

/// Four modes of 0.2 to 1 %, well apart, at six sensors for hits at the first.
fn drawn(case: Case, seed: u64) -> (HammerTest, Vec<(f64, f64)>) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut hz: f64 = random.random_range(40.0..80.0);
    let mut truth = Vec::new();
    let mut modes = Vec::new();
    for _ in 0..MODES {
        let damping = 10f64.powf(random.random_range(-2.7..-2.0));
        let value = |random: &mut ChaCha8Rng| {
            let sign = if random.random_bool(0.5) { 1.0 } else { -1.0 };
            sign * random.random_range(0.3..1.0)
        };
        let values = (1..=SENSORS).map(|p| (dof(p), value(&mut random).into()));
        let shape = ModeShape::new(values.collect::<Vec<_>>());
        modes.push(Mode::new(hz, Some(damping), shape, Scaling::UnitModalMass));
        truth.push((hz, damping));
        hz *= random.random_range(1.25..1.6);
    }
    let decay = |(hz, damping): &(f64, f64)| std::f64::consts::TAU * hz * damping;
    let slowest = truth.iter().map(decay).fold(f64::MAX, f64::min);
    let highest = truth[MODES - 1].0;
    let rate = 2.56 * 1.3 * highest;
    let samples = (case.time_constants / slowest * rate) as usize;
    let sensors: Vec<Dof> = (1..=SENSORS).map(dof).collect();
    let model = ModalModel {
        modes,
        ..ModalModel::default()
    };
    let test = HammerTest {
        truth: Truth::from_real_shapes(&model, &sensors, &sensors[..1]).unwrap(),
        hits: roving_hammer(&sensors[..1], &sensors),
        averages_per_point: case.hits as usize,
        sampling_rate_hz: rate,
        samples,
        pretrigger_s: 0.03 * samples as f64 / rate,
        quantity: Quantity::Acceleration,
        pulse: Pulse {
            peak_n: 100.0,
            peak_spread: 0.2,
            duration_s: 0.5 / highest,
            duration_spread: 0.1,
        },
        filter: LowPassOptions::default(),
        noise: Noise {
            force_snr_db: Some(case.force_snr_db),
            response_snr_db: Some(case.response_snr_db),
        },
        faults: Faults::default(),
        seed,
    };
    (test, truth)
}

/// Errors of frequency and damping of every mode over the deviations that it states.
fn errors(case: Case, seed: u64) -> Vec<f64> {
    let (test, truth) = drawn(case, seed);
    let hits = test.generate().unwrap();
    let estimate =
        evaluate_hammer_test(&mut InMemory::new(&hits), &HammerOptions::default()).unwrap();
    let options = IdentifyOptions {
        band: Some(Band::new(0.6 * truth[0].0, 1.2 * truth[MODES - 1].0).unwrap()),
        ..IdentifyOptions::default()
    };
    let model = identify(&estimate.estimated.set, &options).unwrap();
    assert_eq!(model.modes.len(), MODES, "{case:?} {seed}");
    let pairs = model.modes.iter().zip(&truth);
    let errors = pairs.flat_map(|(mode, (hz, damping))| {
        [
            (mode.frequency_hz - hz) / mode.frequency_std_hz.unwrap(),
            (mode.damping_ratio.unwrap() - damping) / mode.damping_std.unwrap(),
        ]
    });
    errors.collect()
}

#[test]
fn deviations_of_hammer_tests_are_those_of_their_errors() {
    let case = |time_constants, hits, response_snr_db, force_snr_db| Case {
        time_constants,
        hits,
        response_snr_db,
        force_snr_db,
    };
    // Noise of the force is most of it in those of 10 dB more, under a window in records of 1.5 and
    // 3 time constants.
    for case in [
        case(1.5, 8, 60.0, 70.0),
        case(1.5, 8, 60.0, 120.0),
        case(3.0, 5, 50.0, 60.0),
        case(8.0, 8, 60.0, 70.0),
    ] {
        let of_test = |seed: u64| errors(case, seed);
        let all: Vec<f64> = (0..TESTS).into_par_iter().flat_map(of_test).collect();
        let count = all.len() as f64;
        let square = all.iter().map(|z| z * z).sum::<f64>() / count;
        let within = all.iter().filter(|z| z.abs() < 1.96).count() as f64 / count;
        println!(
            "{case:?}: mean square over the stated one {square:.2}, within 95 %: {:.1} %",
            100.0 * within
        );
        // 480 values: their scatter around 1 is 6 %; the noise of the standard deviations adds to
        // it.
        assert!((0.75..1.35).contains(&square), "{case:?}: {square}");
        assert!(within > 0.91, "{case:?}: {within}");
    }
}
