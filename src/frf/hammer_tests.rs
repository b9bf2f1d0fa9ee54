//! Whole hammer tests with faults: which hits are used, which window is chosen, what is said.

use std::collections::BTreeSet;

use crate::axis::TimeAxis;
use crate::dof::Dof;
use crate::finding::{Code, Location};
use crate::quantity::Quantity;
use crate::record::{Channel, Hit, InMemory, Role, Samples};

use super::*;

const STEP_S: f64 = 1e-4;
const LEN: usize = 8192;
const ONSET: usize = 400;

fn dof(text: &str) -> Dof {
    text.parse().unwrap()
}

/// Noise from a fixed sequence, about ±1.
fn noise(seed: usize, n: usize) -> f64 {
    let x = ((seed * 7919 + n) as f64 * 12.9898).sin() * 43_758.545_3;
    2.0 * (x - x.floor()) - 1.0
}

/// A half sine of 20 samples, and a mode of 300 Hz whose decay takes `time_constants` of the
/// record.
struct Made {
    seed: usize,
    at: &'static str,
    height: f64,
    /// A second contact: samples after the first one, and its height over the first one's.
    second: Option<(usize, f64)>,
    /// The response at which the converter clips.
    clip: f64,
    time_constants: f64,
}

impl Default for Made {
    fn default() -> Self {
        Self {
            seed: 1,
            at: "1:+Z",
            height: 100.0,
            second: None,
            clip: f64::INFINITY,
            time_constants: 12.0,
        }
    }
}

fn hit(made: &Made) -> Hit {
    let pulse = |n: i64| {
        let within = (0..20).contains(&n);
        let value = (std::f64::consts::PI * (n as f64 + 0.5) / 20.0).sin();
        if within { made.height * value } else { 0.0 }
    };
    let second = made.second.unwrap_or((0, 0.0));
    let force: Vec<f64> = (0..LEN)
        .map(|n| {
            let n = n as i64 - ONSET as i64;
            pulse(n) + second.1 * pulse(n - second.0 as i64)
        })
        .collect();
    let sigma = made.time_constants / ((LEN - ONSET) as f64 * STEP_S);
    let omega = std::f64::consts::TAU * 300.0;
    let mut response = vec![0.0; LEN];
    for (start, f) in force.iter().enumerate().filter(|(_, f)| **f > 0.0) {
        for (n, x) in response.iter_mut().enumerate().skip(start) {
            let t = (n - start) as f64 * STEP_S;
            *x += f * (-sigma * t).exp() * (omega * t).sin();
        }
    }
    let channel = |role, at: &str, quantity, samples: Vec<f64>, level: f64, number: usize| {
        let noisy = samples.iter().enumerate();
        let noisy = noisy.map(|(n, x)| x + level * noise(number + 10 * made.seed, n));
        let clipped = |x: f64| {
            if role == Role::Response {
                x.clamp(-made.clip, made.clip)
            } else {
                x
            }
        };
        Channel {
            role,
            dof: dof(at),
            quantity,
            to_si: 1.0,
            samples: Samples::F64(noisy.map(clipped).collect()),
        }
    };
    Hit {
        axis: TimeAxis {
            start_s: 0.0,
            step_s: STEP_S,
            len: LEN,
        },
        responses: vec![
            channel(
                Role::Response,
                "1:+Z",
                Quantity::Velocity,
                response.clone(),
                0.05,
                1,
            ),
            channel(
                Role::Response,
                "2:-Z",
                Quantity::Velocity,
                response,
                0.05,
                2,
            ),
        ],
        force: channel(Role::Force, made.at, Quantity::Force, force, 0.02, 3),
        origin: format!("hit {}", made.seed),
    }
}

fn hits(change: impl Fn(usize, &mut Made)) -> Vec<Hit> {
    let one = |number: usize| {
        let mut made = Made {
            seed: number,
            height: 100.0 + 7.0 * number as f64,
            ..Made::default()
        };
        change(number, &mut made);
        hit(&made)
    };
    (1..=5).map(one).collect()
}

fn run(hits: &[Hit], options: &HammerOptions) -> HammerTestResult {
    evaluate_hammer_test(&mut InMemory::new(hits), options).unwrap()
}

fn used(hammered: &HammerTestResult) -> Vec<usize> {
    let used = hammered.hits.iter().filter(|hit| hit.used);
    used.map(|hit| hit.number).collect()
}

fn numbers(list: &[usize]) -> BTreeSet<usize> {
    list.iter().copied().collect()
}

#[test]
fn clean_hits_are_used_as_they_are_and_without_a_window() {
    let hammered = run(&hits(|_, _| {}), &HammerOptions::default());
    assert_eq!(used(&hammered), [1, 2, 3, 4, 5]);
    let set = &hammered.estimated.set;
    assert!(set.added_damping_rad_s.abs() < 1e-300);
    assert_eq!(set.axis().len, LEN / 2 + 1);
    assert_eq!(
        set,
        &estimate(&hits(|_, _| {}), &EstimateOptions::default())
            .map(|mut hammered| {
                hammered.findings.clone_from(&set.findings);
                hammered
            })
            .unwrap()
    );
}

#[test]
fn a_double_hit_is_rejected_unless_the_user_accepts_it() {
    let double = hits(|number, made| {
        if number == 3 {
            made.second = Some((300, 0.4));
        }
    });
    let hammered = run(&double, &HammerOptions::default());
    assert_eq!(used(&hammered), [1, 2, 4, 5]);
    assert_eq!(hammered.estimated.set.functions()[0].averages, Some(4));
    let found = hammered
        .estimated
        .set
        .findings
        .iter()
        .find(|f| f.code == Code::DoubleHit);
    let found = found.unwrap();
    assert_eq!(found.location, Location::Hit(3));
    assert!((found.value.unwrap() - 0.4).abs() < 0.02, "{found:?}");
    let accepted = HammerOptions {
        accept: numbers(&[3]),
        reject: numbers(&[1]),
        ..HammerOptions::default()
    };
    let hammered = run(&double, &accepted);
    assert_eq!(used(&hammered), [2, 3, 4, 5]);
    assert!(hammered.hits[0].stated && hammered.hits[2].stated && !hammered.hits[1].stated);
    let all = HammerOptions {
        keep_all: true,
        ..HammerOptions::default()
    };
    assert_eq!(used(&run(&double, &all)), [1, 2, 3, 4, 5]);
}

#[test]
fn clipped_response_is_left_out_of_its_function_alone() {
    let clean = hits(|_, _| {});
    let mut clipped = clean.clone();
    clipped[1].responses[1] = hit(&Made {
        seed: 2,
        height: 114.0,
        clip: 400.0,
        ..Made::default()
    })
    .responses
    .remove(1);
    let hammered = run(&clipped, &HammerOptions::default());
    assert_eq!(used(&hammered), [1, 2, 3, 4, 5]);
    let averages: Vec<_> = hammered
        .estimated
        .set
        .functions()
        .iter()
        .map(|f| f.averages)
        .collect();
    assert_eq!(averages, [Some(5), Some(4)]);
    let overloads: Vec<_> = hammered
        .estimated
        .set
        .findings
        .iter()
        .filter(|f| f.code == Code::Overload)
        .collect();
    assert_eq!(overloads.len(), 1, "{overloads:?}");
    assert_eq!(
        overloads[0].location,
        Location::HitChannel {
            hit: 2,
            dof: dof("2:-Z")
        }
    );
}

#[test]
fn truncated_responses_get_one_exponential_window_and_records_from_the_hit() {
    let ringing = hits(|_, made| made.time_constants = 1.5);
    let hammered = run(&ringing, &HammerOptions::default());
    let set = &hammered.estimated.set;
    assert!(set.record_duration_s.unwrap() < (LEN - ONSET + 10) as f64 * STEP_S);
    let falls_to = (-set.added_damping_rad_s * set.record_duration_s.unwrap()).exp();
    assert!((falls_to / 0.01 - 1.0).abs() < 0.1, "{falls_to}");
    assert!(set.findings.iter().any(|f| f.code == Code::WindowAdded));
    let off = HammerOptions {
        response_window: ResponseWindow::Off,
        ..HammerOptions::default()
    };
    let plain = run(&ringing, &off);
    assert!(plain.estimated.set.added_damping_rad_s.abs() < 1e-300);
    assert_eq!(plain.estimated.set.axis().len, LEN / 2 + 1);
}

#[test]
fn an_excitation_point_without_accepted_hits_keeps_its_hits_and_is_reported() {
    let bad = hits(|number, made| {
        made.at = if number < 3 { "1:+Z" } else { "9:+X" };
        if number < 3 {
            made.second = Some((300, 0.5));
        }
    });
    let hammered = run(&bad, &HammerOptions::default());
    assert_eq!(used(&hammered), [1, 2, 3, 4, 5]);
    let reported = hammered
        .estimated
        .set
        .findings
        .iter()
        .find(|f| f.code == Code::NoHitPassed);
    assert_eq!(reported.unwrap().value, Some(2.0));
    // One of them named by the user: the other one goes.
    let stated = HammerOptions {
        accept: numbers(&[2]),
        ..HammerOptions::default()
    };
    assert_eq!(used(&run(&bad, &stated)), [2, 3, 4, 5]);
}

#[test]
fn a_rejected_hit_has_its_peak_force_and_an_unreadable_one_none() {
    let options = HammerOptions {
        reject: numbers(&[2]),
        ..HammerOptions::default()
    };
    let peaks = |hits: &[Hit], options: &HammerOptions| -> Vec<Option<f64>> {
        let result = evaluate_hammer_test(&mut InMemory::new(hits), options).unwrap();
        result.hits.iter().map(|hit| hit.peak_n).collect()
    };
    let sound = hits(|_, _| {});
    let all = peaks(&sound, &HammerOptions::default());
    assert!(all.iter().all(|peak| peak.is_some_and(|peak| peak > 1.0)));
    assert_eq!(peaks(&sound, &options), all);
    let mut bad = sound;
    bad[1].force.samples = Samples::F64(vec![f64::NAN; LEN]);
    let expected = [all[0], None, all[2], all[3], all[4]];
    assert_eq!(peaks(&bad, &options), expected);
}

#[test]
fn a_missing_hit_number_is_an_error() {
    let options = HammerOptions {
        reject: numbers(&[6]),
        ..HammerOptions::default()
    };
    let error = evaluate_hammer_test(&mut InMemory::new(&hits(|_, _| {})), &options).unwrap_err();
    assert_eq!(
        error,
        FrfError::HitNumber {
            got: 6,
            expected: 5
        }
    );
}

#[test]
fn threads_change_no_bit_and_several_references_have_a_multiple_coherence() {
    let two = hits(|number, made| made.at = if number < 3 { "1:+Z" } else { "9:+X" });
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        pool.install(|| run(&two, &HammerOptions::default()).estimated.set)
    };
    let set = with(1);
    assert_eq!(set, with(3));
    assert_eq!(set.len(), 4);
    let multiple = &set.multiple_coherence[&dof("1:+Z")];
    // Between the two ordinary ones, weighted by the power of the response.
    for line in [50, 123, 400] {
        let of = |reference: &str| {
            let pair = set
                .functions()
                .iter()
                .position(|f| f.response == dof("1:+Z") && f.reference == dof(reference));
            set.coherence(pair.unwrap()).unwrap()[line]
        };
        let (a, b) = (of("1:+Z"), of("9:+X"));
        let (low, high) = (a.min(b), a.max(b));
        assert!(
            low <= multiple[line] && multiple[line] <= high,
            "{low} {high} {}",
            multiple[line]
        );
    }
}
