//! Every rule on records in closed form, beside `contact_tests`.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::*;
use crate::signal::ONSET_FRACTION;

const STEP_S: f64 = 1e-4;
const ONSET: usize = 200;
const LEN: usize = 4096;

fn noise(rms: f64, random: &mut ChaCha8Rng) -> f64 {
    let normal: f64 = random.sample(StandardNormal);
    rms * normal
}

fn half_sine(width: f64, at: usize) -> f64 {
    let t = at as f64 - ONSET as f64;
    if (0.0..width).contains(&t) {
        (PI * t / width).sin()
    } else {
        0.0
    }
}

fn force(width: f64, rms: f64, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..LEN)
        .map(|k| half_sine(width, k) + noise(rms, &mut random))
        .collect()
}

/// A decaying sine from the onset, `rate` and `omega` per sample.
fn response(rate: f64, omega: f64, rms: f64, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let ring = |k: usize| {
        let t = k as f64 - ONSET as f64;
        if t < 0.0 {
            0.0
        } else {
            (-rate * t).exp() * (omega * t).sin()
        }
    };
    (0..LEN)
        .map(|k| ring(k) + noise(rms, &mut random))
        .collect()
}

fn locate(samples: &[f64]) -> Pulse {
    Pulse::locate(samples, ONSET_FRACTION).expect("there is a pulse")
}

fn pulse() -> Pulse {
    locate(&force(12.0, 0.0, 0))
}

fn of(samples: &[f64], rule: Rule) -> Check {
    let dof = "3:-Z".parse().expect("a name of a degree of freedom");
    let record = ResponseRecord {
        samples,
        step_s: STEP_S,
        dof: &dof,
        full_scale: None,
    };
    let checks = assess_response(&record, &pulse(), &HitQualityLimits::default());
    assert!(checks.iter().all(|c| c.dof.as_ref() == Some(&dof)));
    checks
        .into_iter()
        .find(|c| c.rule == rule)
        .expect("every rule is assessed")
}

fn of_force(samples: &[f64], band_end_hz: f64, rule: Rule) -> Check {
    let limits = HitQualityLimits::default();
    let checks = assess_force(
        samples,
        STEP_S,
        &locate(samples),
        None,
        band_end_hz,
        &limits,
    );
    checks
        .into_iter()
        .find(|c| c.rule == rule)
        .expect("every rule is assessed")
}

fn quantised(samples: &[f64], step: f64) -> Vec<f64> {
    samples.iter().map(|x| (x / step).round() * step).collect()
}

#[test]
fn a_clipped_record_is_an_overload_with_and_without_jitter_and_of_either_sign() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let step = 1.0 / 2048.0;
    for sign in [1.0, -1.0] {
        for jitter in [0, 1, 2] {
            let clip = |x: &f64| {
                let code = (sign * x / step).round();
                let shake = f64::from(random.random_range(-jitter..=jitter));
                (if code.abs() >= 1600.0 {
                    code.signum() * (1600.0 + shake)
                } else {
                    code
                }) * step
            };
            let record: Vec<f64> = force(12.0, 1e-3, 1).iter().map(clip).collect();
            let check = of_force(&record, 100.0, Rule::Overload);
            assert_eq!(
                check.outcome,
                Outcome::Rejected,
                "{sign} {jitter} {check:?}"
            );
        }
    }
}

#[test]
fn a_coarsely_quantised_signal_with_a_flat_top_is_no_overload() {
    for width in [5.0, 12.0, 60.0, 200.0] {
        for steps in [20.0, 57.3, 300.0, 5000.0] {
            let record = quantised(&force(width, 0.0, 1), 1.0 / steps);
            let check = of_force(&record, 100.0, Rule::Overload);
            assert_eq!(check.outcome, Outcome::Passed, "{width} {steps} {check:?}");
            let sine: Vec<f64> = (0..LEN).map(|k| (k as f64 / width).sin()).collect();
            let check = of(&quantised(&sine, 1.0 / steps), Rule::Overload);
            assert_eq!(check.outcome, Outcome::Passed, "{width} {steps} {check:?}");
        }
    }
}

#[test]
fn a_known_full_scale_is_the_clipping_level() {
    let record = quantised(&force(12.0, 1e-4, 1), 1.0 / 4096.0);
    let limits = HitQualityLimits::default();
    let outcome = |full_scale| {
        let checks = assess_force(&record, STEP_S, &locate(&record), full_scale, 1.0, &limits);
        checks[1].outcome
    };
    assert_eq!(outcome(Some(1.5)), Outcome::Passed);
    assert_eq!(outcome(Some(0.9)), Outcome::Rejected);
    assert_eq!(outcome(None), Outcome::Passed);
}

#[test]
fn ringing_of_the_previous_hit_is_rejected_by_its_effect_on_the_frf() {
    let rms = 1e-3;
    let with = |amplitude: f64| {
        let mut samples = response(2e-3, 0.3, rms, 5);
        for (k, sample) in samples.iter_mut().enumerate() {
            *sample += amplitude * (0.3 * k as f64).cos() * (-2e-3 * k as f64).exp();
        }
        of(&samples, Rule::PreTrigger)
    };
    assert_eq!(with(0.0).outcome, Outcome::Passed);
    assert_eq!(with(0.05).outcome, Outcome::Noted);
    let check = with(0.3);
    assert_eq!(check.outcome, Outcome::Rejected);
    // Both decay alike over intervals of one length, so that the ratio is that of the amplitudes at
    // the start of either.
    assert!(
        (check.value.expect("the check has a value") - 0.3).abs() < 0.06,
        "{check:?}"
    );
    let noisy = of(&response(2e-3, 0.3, 1.0, 5), Rule::PreTrigger);
    assert_eq!(noisy.outcome, Outcome::NotDecidable);
}

#[test]
fn amplitude_at_the_end_excludes_the_noise() {
    // exp(-1e-3 * 3896) = 0.020 at the end; rms over the last eighth is that of its middle,
    // exp(-1e-3 * 3652).
    let check = of(&response(1e-3, 0.3, 1e-4, 5), Rule::Decay);
    assert_eq!(check.outcome, Outcome::Noted);
    let expected = (-1e-3f64 * 3652.0).exp();
    assert!(
        (check.value.expect("the check has a value") / expected - 1.0).abs() < 0.05,
        "{check:?}"
    );
    let decayed = of(&response(3e-3, 0.3, 1e-4, 5), Rule::Decay);
    assert_eq!(decayed.outcome, Outcome::Passed);
    let noisy = of(&response(3e-3, 0.3, 0.03, 5), Rule::Decay);
    assert_eq!(noisy.outcome, Outcome::NotDecidable);
}

#[test]
fn the_force_roll_off_of_a_half_sine_equals_its_transform() {
    // |cos(π f T)| / |1 - (2 f T)²| is -20 dB at f T = 1.2556, T = 1.2 ms.
    let duration_s = 12.0 * STEP_S;
    let at_20_db = {
        let level = |x: f64| ((PI * x).cos() / (1.0 - 4.0 * x * x)).abs();
        (1000..2000)
            .map(|k| f64::from(k) * 1e-3)
            .find(|x| level(*x) < 0.1)
            .unwrap()
    };
    let check = of_force(&force(12.0, 0.0, 1), 800.0, Rule::RollOff);
    assert_eq!(check.outcome, Outcome::Passed);
    let expected = at_20_db / duration_s;
    assert!(
        (check.at.expect("the check has a place") / expected - 1.0).abs() < 0.02,
        "{check:?} {expected}"
    );
    let wide = of_force(&force(12.0, 0.0, 1), 1.02 * expected, Rule::RollOff);
    assert_eq!(wide.outcome, Outcome::Noted);
}

#[test]
fn channels_without_signal_are_dead() {
    assert_eq!(of(&[0.2; LEN], Rule::Dead).outcome, Outcome::Rejected);
    assert_eq!(
        of(&response(2e-3, 0.3, 1e-2, 5), Rule::Dead).outcome,
        Outcome::Passed
    );
    for seed in 0..200 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let silent: Vec<f64> = (0..LEN).map(|_| noise(1.0, &mut random)).collect();
        assert_eq!(of(&silent, Rule::Dead).outcome, Outcome::Rejected, "{seed}");
    }
}

#[test]
fn a_sign_reversed_force_is_noted_with_its_peak() {
    let turned: Vec<f64> = force(12.0, 1e-4, 1).iter().map(|f| -f).collect();
    let check = of_force(&turned, 100.0, Rule::Sign);
    assert_eq!(check.outcome, Outcome::Noted);
    assert!(check.value.expect("the check has a value") < -0.99);
    assert_eq!(
        of_force(&force(12.0, 1e-4, 1), 100.0, Rule::Sign).outcome,
        Outcome::Passed
    );
}

#[test]
fn offset_and_drift_equal_their_synthetic_values() {
    let mut drifting = force(12.0, 1e-4, 1);
    for (k, sample) in drifting.iter_mut().enumerate() {
        *sample += 0.02 + 0.03 * (k as f64 - ONSET as f64) / LEN as f64;
    }
    let drift = drift_of(&drifting, STEP_S, &locate(&drifting)).expect("the record drifts");
    assert!((drift.offset - 0.02).abs() < 6.0 * drift.error, "{drift:?}");
    let slope = 0.03 / (LEN as f64 * STEP_S);
    assert!(
        (drift.slope_per_s / slope - 1.0).abs() < 6.0 * drift.error / 0.03,
        "{drift:?}"
    );
    assert_eq!(
        of_force(&drifting, 100.0, Rule::Drift).outcome,
        Outcome::Noted
    );
    assert_eq!(
        of_force(&force(12.0, 1e-4, 1), 100.0, Rule::Drift).outcome,
        Outcome::Passed
    );
}

#[test]
fn levels_are_compared_with_the_median() {
    let outcomes = |peaks: &[f64]| -> Vec<Outcome> {
        let checks = assess_levels(peaks, &HitQualityLimits::default());
        checks.iter().map(|c| c.outcome).collect()
    };
    use Outcome::{NotDecidable, Noted, Passed, Rejected};
    assert_eq!(
        outcomes(&[1.0, -1.1, 2.5, 0.9, 0.05]),
        [Passed, Passed, Noted, Passed, Rejected]
    );
    assert_eq!(outcomes(&[1.0, 30.0]), [NotDecidable; 2]);
    assert_eq!(outcomes(&[0.0; 3]), [NotDecidable; 3]);
}

/// Forces, and responses of one mode with the noise of a ratio in dB; `odd` has another shape by
/// this factor.
fn series(n: usize, snr_db: f64, odd: Option<(usize, f64)>, seed: u64) -> Vec<Outcome> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let h =
        |k: usize| 1.0 / Complex64::new(1.0 - (k as f64 / 50.0).powi(2), 0.02 * k as f64 / 50.0);
    let rms = (1..200).map(|k| h(k).norm_sqr()).sum::<f64>() / 200.0;
    let sigma = (0.5 * rms).sqrt() / 10f64.powf(snr_db / 20.0);
    let (mut force, mut response) = (Vec::new(), Vec::new());
    for hit in 0..n {
        let f = Complex64::cis(TAU * random.random::<f64>()) * random.random_range(0.5..1.5);
        let gain = odd.filter(|(i, _)| *i == hit).map_or(1.0, |(_, gain)| gain);
        force.push(vec![f; 200]);
        let mut line = |k| {
            gain * h(k) * f + Complex64::new(noise(sigma, &mut random), noise(sigma, &mut random))
        };
        response.push((0..200).map(&mut line).collect::<Vec<_>>());
    }
    let force: Vec<&[Complex64]> = force.iter().map(Vec::as_slice).collect();
    let response: Vec<&[Complex64]> = response.iter().map(Vec::as_slice).collect();
    let checks = inconsistent_hits(&force, &response, &HitQualityLimits::default());
    checks.iter().map(|c| c.outcome).collect()
}

#[test]
fn the_odd_hit_is_found_and_no_other_is_lost() {
    for seed in 0..20 {
        for n in [4, 5, 10] {
            let found = series(n, 30.0, Some((2, -1.0)), seed);
            let rejected = |(i, o): (usize, &Outcome)| (i == 2) == (*o == Outcome::Rejected);
            assert!(found.iter().enumerate().all(rejected), "{n} {found:?}");
            let good = series(n, 30.0, None, seed);
            assert!(good.iter().all(|o| *o == Outcome::Passed), "{n} {good:?}");
        }
        assert_eq!(
            series(3, 30.0, Some((2, -1.0)), seed),
            [Outcome::NotDecidable; 3]
        );
    }
}

#[test]
fn limits_out_of_range_are_errors_with_their_name() {
    assert!(HitQualityLimits::default().validate().is_ok());
    let default = HitQualityLimits::default;
    let bad = [
        (
            HitQualityLimits {
                decay: 0.0,
                ..default()
            },
            "decay",
        ),
        (
            HitQualityLimits {
                inconsistency_false_alarms: 1.0,
                ..default()
            },
            "inconsistency_false_alarms",
        ),
        (
            HitQualityLimits {
                double_hit_ratio: 0.001,
                ..default()
            },
            "double_hit_ratio",
        ),
        (
            HitQualityLimits {
                level_noted: f64::NAN,
                ..default()
            },
            "level_noted",
        ),
    ];
    for (limits, name) in bad {
        let text = limits.validate().unwrap_err().to_string();
        assert!(text.contains(name), "{text}");
    }
}

#[test]
fn a_record_without_pretrigger_samples_is_undecided_not_accepted() {
    let short = &force(12.0, 1e-3, 1)[ONSET + 2..ONSET + 60];
    for rule in [Rule::PreTrigger, Rule::Dead, Rule::Drift] {
        assert_eq!(
            of_force(short, 100.0, rule).outcome,
            Outcome::NotDecidable,
            "{rule:?}"
        );
    }
}

#[test]
fn a_record_shorter_than_its_pulse_is_undecided_in_every_rule() {
    let (limits, dof) = (
        HitQualityLimits::default(),
        "3:-Z".parse().expect("a name of a degree of freedom"),
    );
    let samples = response(2e-3, 0.3, 1e-2, 5);
    let record = |len: usize| ResponseRecord {
        samples: &samples[..len],
        step_s: STEP_S,
        dof: &dof,
        full_scale: None,
    };
    let rules = |checks: &[Check]| -> Vec<Rule> { checks.iter().map(|c| c.rule).collect() };
    let whole = assess_response(&record(LEN), &pulse(), &limits);
    let short = assess_response(&record(ONSET), &pulse(), &limits);
    assert_eq!(rules(&whole), rules(&short));
    assert!(
        short
            .iter()
            .all(|c| c.outcome == Outcome::NotDecidable && c.dof.is_some())
    );
    let force = force(12.0, 1e-3, 1);
    let whole = assess_force(&force, STEP_S, &pulse(), None, 100.0, &limits);
    let short = assess_force(&force[..ONSET], STEP_S, &pulse(), None, 100.0, &limits);
    assert_eq!(rules(&whole), rules(&short));
    assert!(short.iter().all(|c| c.outcome == Outcome::NotDecidable));
}
