//! Noise, faults and the independence of every channel's random numbers.

use super::channel::{peak, rms};
use super::test_systems::{clean_test, dof, truth};
use super::{HammerTest, Noise, Quantisation, SecondContact, SynthError, roving_accelerometer};
use crate::finding::Code;
use crate::record::{Channel, Hit};

fn test() -> HammerTest {
    HammerTest {
        samples: 16384,
        averages_per_point: 3,
        ..clean_test(truth(&[(100.0, 0.01, 0.8), (340.0, 0.006, -1.0)]))
    }
}

fn noisy() -> HammerTest {
    HammerTest {
        noise: Noise {
            force_snr_db: Some(60.0),
            response_snr_db: Some(30.0),
        },
        ..test()
    }
}

fn channels(hit: &Hit) -> Vec<&Channel> {
    std::iter::once(&hit.force).chain(&hit.responses).collect()
}

fn difference(a: &Channel, b: &Channel) -> Vec<f64> {
    a.si().iter().zip(b.si()).map(|(a, b)| a - b).collect()
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let product: f64 = a.iter().zip(b).map(|(x, y)| x * y).sum();
    product / (a.len() as f64 * rms(a) * rms(b))
}

/// Noise of every channel of every hit.
fn noises(test: &HammerTest) -> Vec<Vec<f64>> {
    let clean = HammerTest {
        noise: Noise::default(),
        ..test.clone()
    };
    let pairs = test.generate().expect("a test as planned").into_iter();
    let pairs = pairs.zip(clean.generate().expect("a test as planned"));
    pairs
        .flat_map(|(noisy, clean)| {
            let both = channels(&noisy).into_iter().zip(channels(&clean));
            both.map(|(a, b)| difference(a, b)).collect::<Vec<_>>()
        })
        .collect()
}

#[test]
fn the_noise_has_its_stated_level_and_is_white_and_gaussian() {
    let n = 16384f64;
    let clean = test().generate().expect("a test as planned");
    let levels = clean.iter().flat_map(|hit| {
        let responses = hit.responses.iter().map(|c| rms(&c.si()) / 10f64.powf(1.5));
        std::iter::once(peak(&hit.force.si()) / 1e3)
            .chain(responses)
            .collect::<Vec<_>>()
    });
    let all = noises(&noisy());
    assert_eq!(all.len(), 9);
    for (noise, level) in all.iter().zip(levels) {
        // Five standard deviations of each statistic of n normal numbers.
        assert!((rms(noise) / level - 1.0).abs() < 5.0 / (2.0 * n).sqrt());
        assert!((noise.iter().sum::<f64>() / n / level).abs() < 5.0 / n.sqrt());
        assert!(correlation(&noise[1..], &noise[..noise.len() - 1]).abs() < 5.0 / n.sqrt());
        let fourth: f64 = noise.iter().map(|v| (v / level).powi(4)).sum::<f64>() / n;
        assert!((fourth - 3.0).abs() < 5.0 * (96.0 / n).sqrt(), "{fourth}");
    }
    for i in 0..all.len() {
        for j in 0..i {
            let shared = correlation(&all[i], &all[j]);
            assert!(shared.abs() < 5.0 / n.sqrt(), "{i} {j}: {shared}");
        }
    }
}

#[test]
fn samples_are_independent_of_threads_and_other_channels() {
    let test = noisy();
    let hits = test.generate().expect("a test as planned");
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a pool of threads");
        assert_eq!(
            pool.install(|| test.generate()).expect("a test as planned"),
            hits
        );
    }
    let mut fewer = HammerTest {
        averages_per_point: 2,
        ..test.clone()
    };
    fewer.hits[0].responses.pop();
    let hit = fewer.generate_hit(1).expect("a planned hit");
    assert_eq!(hit.force, hits[1].force);
    assert_eq!(hit.responses[0], hits[1].responses[0]);
    let other = HammerTest { seed: 8, ..test };
    assert_ne!(
        other.generate_hit(0).expect("a planned hit").force.samples,
        hits[0].force.samples
    );
}

#[test]
fn a_double_hit_is_the_pulse_again_later_and_smaller() {
    let delay = 40;
    let mut double = test();
    double.faults.second_contact = Some(SecondContact {
        delay_s: delay as f64 / double.sampling_rate_hz,
        ratio: 0.35,
        hits: [1].into(),
    });
    let (single, double) = (
        test().generate().expect("a test as planned"),
        double.generate().expect("a test as planned"),
    );
    assert_eq!(single[0], double[0]);
    assert_eq!(single[2], double[2]);
    for (one, two) in channels(&single[1]).into_iter().zip(channels(&double[1])) {
        let (one, two) = (one.si(), two.si());
        for n in 0..one.len() {
            let again = if n >= delay {
                0.35 * one[n - delay]
            } else {
                0.0
            };
            assert!((two[n] - one[n] - again).abs() < 1e-12 * peak(&one));
        }
    }
}

#[test]
fn offsets_shift_and_a_converter_rounds_and_clips() {
    let clean = test().generate_hit(0).expect("a planned hit");
    let mut faulty = noisy();
    faulty.noise = Noise::default();
    faulty.faults.offsets.force_n = 1.5;
    faulty.faults.offsets.response = -0.25;
    let shifted = faulty.generate_hit(0).expect("a planned hit");
    for (channel, offset) in channels(&clean).into_iter().zip([1.5, -0.25, -0.25]) {
        let shifted = channels(&shifted)
            .into_iter()
            .find(|c| c.dof == channel.dof && c.role == channel.role);
        let error = difference(shifted.expect("the same channel"), channel);
        assert!(error.iter().all(|v| (v - offset).abs() < 1e-12));
    }
    let full_scale = 0.5 * peak(&clean.responses[0].si());
    faulty.faults.quantisation = Some(Quantisation {
        bits: 12,
        force_full_scale_n: 1000.0,
        response_full_scale: full_scale,
    });
    let coarse = faulty.generate_hit(0).expect("a planned hit");
    let pairs = channels(&coarse).into_iter().zip(channels(&shifted));
    for ((got, exact), scale) in pairs.zip([1000.0, full_scale, full_scale]) {
        let step = scale / 2048.0;
        for (got, exact) in got.si().into_iter().zip(exact.si()) {
            let inside = exact.clamp(-scale, scale - step);
            assert!((got - inside).abs() <= 0.5 * step * (1.0 + 1e-12));
            assert!((got / step - (got / step).round()).abs() < 1e-9);
        }
    }
    let clipped = coarse.responses[0].si();
    assert!((clipped.iter().fold(f64::MAX, |a, b| a.min(*b)) + full_scale).abs() < 1e-12);
}

#[test]
fn the_sign_of_a_hit_is_its_push_and_the_sign_of_a_sensor_its_reading() {
    let plan = roving_accelerometer(&dof("1:+Z"), &[vec![dof("1:+Z")], vec![dof("2:-Z")]]);
    let mut test = HammerTest {
        hits: plan,
        ..test()
    };
    let pushed = test.generate().expect("a test as planned");
    for plan in &mut test.hits {
        plan.hit = dof("1:-Z");
    }
    let pulled = test.generate().expect("a test as planned");
    let mut positive = test.clone();
    positive.hits[1].responses = vec![dof("2:+Z")];
    let positive = positive.generate().expect("a test as planned");
    for i in 0..6 {
        assert_eq!(pulled[i].force.samples, pushed[i].force.samples);
        assert!(pulled[i].force.si().iter().fold(0.0, |a: f64, b| a.max(*b)) > 100.0);
        let negated: Vec<f64> = pushed[i].responses[0].si().iter().map(|v| -v).collect();
        assert_eq!(pulled[i].responses[0].si(), negated);
    }
    let negated: Vec<f64> = pulled[3].responses[0].si().iter().map(|v| -v).collect();
    assert_eq!(positive[3].responses[0].si(), negated);
    assert_eq!(pulled[3].responses[0].dof, dof("2:-Z"));
}

#[test]
fn the_truth_is_written_as_synthetic_with_its_references() {
    let test = test();
    let model = test.truth_model();
    assert_eq!(model.references, [dof("1:+Z")]);
    assert_eq!(model.modes, test.truth.model.modes);
    let codes: Vec<Code> = model.findings.iter().map(|f| f.code).collect();
    assert_eq!(codes, [Code::Synthetic]);
    assert_eq!(
        test.generate_hit(3).unwrap_err(),
        SynthError::HitIndex {
            got: 3,
            expected: 3
        }
    );
}
