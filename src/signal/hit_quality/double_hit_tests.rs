//! A seeded sample of the population of `tests/population/hits.rs`, and the cases that a search for
//! second contacts is prone to.

use std::f64::consts::PI;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::*;
use crate::signal::ONSET_FRACTION;

const LEN: usize = 4096;
const ONSET: usize = 400;
const STEP_S: f64 = 1e-4;

/// A half sine from a place between samples, with the ringing of a filter after it.
fn contact(width: f64, start: f64, at: usize) -> f64 {
    let t = at as f64 - start;
    let body = if (0.0..width).contains(&t) {
        (PI * t / width).sin()
    } else {
        0.0
    };
    // At the end a slope of π/w stops: the filter's edge, 0.4 of the rate, answers with about this,
    // and forgets over 12 samples.
    let after = t - width;
    let ringing = if after > 0.0 {
        0.1 / width * (0.8 * PI * after).cos() * (-after / 12.0).exp()
    } else {
        0.0
    };
    body + ringing
}

struct Hit {
    force_n: Vec<f64>,
    /// `sqrt(Σp²)/σ` of the first contact.
    unit_detectability: f64,
}

fn hit(width: f64, snr_db: f64, second: Option<(f64, f64)>, random: &mut ChaCha8Rng) -> Hit {
    let start = ONSET as f64 + random.random::<f64>();
    let noise = 10f64.powf(-snr_db / 20.0);
    let drift: f64 = random.random_range(-0.02..0.02);
    let step = 4.0 / 2f64.powi(random.random_range(12..=24));
    let mut energy = 0.0;
    let sample = |k: usize| {
        let first = contact(width, start, k);
        energy += first * first;
        let second = second.map_or(0.0, |(r, delay)| r * contact(width, start + delay, k));
        let normal: f64 = random.sample(StandardNormal);
        let analogue = first + second + noise * normal + drift * (1.0 + k as f64 / LEN as f64);
        (analogue / step).round() * step
    };
    let force_n = (0..LEN).map(sample).collect();
    Hit {
        force_n,
        unit_detectability: energy.sqrt() / noise.hypot(step / 12f64.sqrt()),
    }
}

fn assess(force_n: &[f64]) -> Check {
    let pulse = Pulse::locate(force_n, ONSET_FRACTION).expect("a pulse");
    double_hit::double_hit(force_n, STEP_S, &pulse, &HitQualityLimits::default())
}

fn found(check: &Check) -> bool {
    matches!(check.outcome, Outcome::Noted | Outcome::Rejected)
}

const WIDTHS: [f64; 6] = [3.0, 5.0, 12.0, 40.0, 100.0, 200.0];

#[test]
fn clean_hits_raise_no_alarm() {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    for width in WIDTHS {
        for snr_db in [30.0, 45.0, 60.0, 80.0] {
            for _ in 0..8 {
                let hit = hit(width, snr_db, None, &mut random);
                let check = assess(&hit.force_n);
                assert!(!found(&check), "{width} {snr_db} {check:?}");
                let decidable = 0.1 * hit.unit_detectability;
                if !(6.5..9.5).contains(&decidable) {
                    let open = check.outcome == Outcome::NotDecidable;
                    assert_eq!(
                        open,
                        decidable < 8.0,
                        "{width} {snr_db} {decidable} {check:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn second_contacts_are_found_where_they_stand_out() {
    let mut random = ChaCha8Rng::seed_from_u64(12);
    let (mut there, mut seen) = (0, 0);
    for width in WIDTHS {
        for snr_db in [30.0, 50.0, 80.0] {
            for ratio in [0.03, 0.3, 0.9] {
                let delay = 1.6 * width + 20.0 + random.random_range(0.0..2000.0);
                let hit = hit(width, snr_db, Some((ratio, delay)), &mut random);
                let check = assess(&hit.force_n);
                if ratio * hit.unit_detectability < 10.0 {
                    continue;
                }
                there += 1;
                seen += usize::from(found(&check));
                // Three samples between two samples of the first: up to 5 % less.
                let error = 4.0 / hit.unit_detectability + 0.05 * ratio;
                assert!(
                    (check.value.expect("a second contact has a size") - ratio).abs() < error,
                    "{width} {snr_db} {ratio} {check:?}"
                );
                let at = check.at.expect("a second contact has a time") / STEP_S;
                assert!(
                    (at - delay).abs() < 3.0 + 0.1 * width,
                    "{width} {delay} {at}"
                );
                assert_eq!(check.outcome == Outcome::Rejected, ratio > 0.1, "{check:?}");
            }
        }
    }
    assert!(there > 35);
    assert_eq!(seen, there);
}

#[test]
fn an_earlier_and_smaller_contact_is_found_too() {
    let mut random = ChaCha8Rng::seed_from_u64(13);
    let mut force_n = hit(12.0, 60.0, None, &mut random).force_n;
    for (k, sample) in force_n.iter_mut().enumerate() {
        *sample += 0.2 * contact(12.0, 310.4, k);
    }
    let check = assess(&force_n);
    assert_eq!(check.outcome, Outcome::Rejected);
    assert!(
        (check.at.expect("a second contact has a time") / STEP_S + 90.0).abs() < 3.0,
        "{check:?}"
    );
}

#[test]
fn overlapping_contacts_are_detected_by_the_rise_between_them() {
    let mut random = ChaCha8Rng::seed_from_u64(14);
    for delay in [1.0, 1.2, 1.5] {
        let hit = hit(40.0, 60.0, Some((0.5, 40.0 * delay)), &mut random);
        let check = assess(&hit.force_n);
        assert_eq!(check.outcome, Outcome::Rejected, "{delay} {check:?}");
    }
}

#[test]
fn droop_hum_and_negative_pulses_raise_no_alarm() {
    let mut random = ChaCha8Rng::seed_from_u64(15);
    for width in WIDTHS {
        let hit = hit(width, 60.0, None, &mut random);
        let disturbed = |k: usize, f: f64| {
            let after = k as f64 - ONSET as f64 - width;
            // A coupled charge amplifier of 1000 samples: the pulse's area over its time constant.
            let droop = if after > 0.0 {
                -0.64 * width / 1000.0 * (-after / 1000.0).exp()
            } else {
                0.0
            };
            -(f + droop + 0.003 * (0.03 * k as f64).sin())
        };
        let force_n: Vec<f64> = hit
            .force_n
            .iter()
            .enumerate()
            .map(|(k, f)| disturbed(k, *f))
            .collect();
        let check = assess(&force_n);
        assert!(!found(&check), "{width} {check:?}");
    }
}
