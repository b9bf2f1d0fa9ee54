//! Tests of the merging of the poles of one mode that varied within the runs.

use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::axis::FrequencyAxis;
use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::FrfSet;
use crate::identify::estimator::{Candidate, PoleTable};
use crate::identify::run_variation::within_runs::merge_varying_modes;
use crate::identify::synthetic::{Measurement, Structure};
use crate::modal::Pole;

/// Sensors, each a run.
const SENSORS: usize = 12;
/// Decay rate of all poles: a half-power bandwidth of 2 rad/s.
const DECAY: f64 = 1.0;

fn set() -> FrfSet {
    let axis = FrequencyAxis {
        start_hz: 1.0,
        step_hz: 1.0,
        len: 2,
    };
    Structure { modes: Vec::new() }.measured(&Measurement::of_sensors(SENSORS, axis))
}

/// Residues of a mode.
fn mode(random: &mut ChaCha8Rng) -> Vec<Complex64> {
    let value = |random: &mut ChaCha8Rng| {
        let size = random.random_range(0.3..1.0);
        if random.random_bool(0.5) { size } else { -size }
    };
    (0..SENSORS)
        .map(|_| Complex64::new(0.0, value(random)))
        .collect()
}

fn candidate(omega: f64, residues: Vec<Complex64>) -> Candidate {
    Candidate {
        residues: Some(residues),
        frequency_std_hz: Some(1e-6),
        damping_std: Some(1e-6),
        ..Candidate::new(Pole {
            lambda: Complex64::new(-DECAY, omega),
        })
    }
}

/// Three poles at a distance in bandwidths, with shares of the mode that differ from run to run,
/// and the mean frequency over the runs.
fn varying(random: &mut ChaCha8Rng, omega: f64, bandwidths: f64) -> (Vec<Candidate>, f64) {
    let residues = mode(random);
    let shares: Vec<[f64; 3]> = (0..SENSORS)
        .map(|_| {
            let raw: [f64; 3] = std::array::from_fn(|_| random.random_range(0.1..1.0));
            raw.map(|share| share / raw.iter().sum::<f64>())
        })
        .collect();
    let at = |j: usize| omega + (j as f64 - 1.0) * bandwidths * 2.0 * DECAY;
    let pole = |j: usize| {
        let parts = residues.iter().zip(&shares);
        candidate(at(j), parts.map(|(a, shares)| a * shares[j]).collect())
    };
    let mean = |shares: &[f64; 3]| (0..3).map(|j| shares[j] * at(j)).sum::<f64>();
    let mean = shares.iter().map(mean).sum::<f64>() / SENSORS as f64;
    ((0..3).map(pole).collect(), mean)
}

fn merged(candidates: Vec<Candidate>) -> PoleTable {
    let mut table = PoleTable {
        candidates,
        ..PoleTable::default()
    };
    merge_varying_modes(&set(), &mut table);
    table
}

#[test]
fn a_mode_that_varied_within_the_runs_is_one_at_the_mean_over_the_runs() {
    let (mut holding, mut intervals) = (0, 0);
    for seed in 0..50 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let varied: Vec<(Vec<Candidate>, f64)> = [100.0, 200.0, 300.0]
            .map(|omega| varying(&mut random, omega, 0.1))
            .into();
        let alone = candidate(400.0, mode(&mut random));
        let mut all: Vec<Candidate> = varied.iter().flat_map(|(poles, _)| poles.clone()).collect();
        all.push(alone.clone());
        let table = merged(all);
        assert_eq!(table.candidates.len(), 4, "{seed}");
        assert_eq!(table.candidates[3], alone);
        for (found, (poles, mean)) in table.candidates.iter().zip(&varied) {
            let residues = found.residues.as_ref().unwrap();
            for (f, residue) in residues.iter().enumerate() {
                let sum: Complex64 = poles
                    .iter()
                    .map(|pole| pole.residues.as_ref().unwrap()[f])
                    .sum();
                assert!((residue - sum).norm() < 1e-12);
            }
            let (error, std) = (found.pole.lambda.im - mean, found.frequency_std_hz.unwrap());
            let std = std * std::f64::consts::TAU;
            // The scatter of the runs over the root of their number.
            assert!((0.005..0.05).contains(&std), "{seed}: {std}");
            assert!(error.abs() < 1e-3 * std, "{seed}: {error} of {std}");
            assert!((found.pole.lambda.re + DECAY).abs() < 1e-12);
            assert_eq!(found.damping_std, None);
            // The mean of the runs against that of all hits that there could be.
            let expected = poles[1].pole.lambda.im;
            holding += i32::from((found.pole.lambda.im - expected).abs() < 1.96 * std);
            intervals += 1;
        }
        let codes: Vec<Code> = table.findings.iter().map(|finding| finding.code).collect();
        assert_eq!(codes, [Code::VariesWithinRuns; 3]);
    }
    let share = f64::from(holding) / f64::from(intervals);
    assert!((0.9..0.99).contains(&share), "{share}");
}

#[test]
fn findings_of_merged_poles_go_and_those_of_other_modes_stay() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut candidates: Vec<Candidate> = [100.0, 200.0, 300.0]
        .into_iter()
        .flat_map(|omega| varying(&mut random, omega, 0.1).0)
        .collect();
    candidates.push(candidate(400.0, mode(&mut random)));
    let findings: Vec<Finding> = candidates
        .iter()
        .map(|candidate| {
            let hz = candidate.pole.natural_frequency_hz();
            Finding::new(Severity::Warning, Code::FewLines, Location::Mode(hz))
        })
        .collect();
    let last = findings[9].clone();
    let mut table = PoleTable {
        candidates,
        findings,
        ..PoleTable::default()
    };
    merge_varying_modes(&set(), &mut table);
    assert_eq!(table.findings[0], last);
    assert_eq!(table.findings.len(), 4);
}

#[test]
fn poles_that_may_be_separate_modes_stay() {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let poles = |random: &mut ChaCha8Rng, varied: usize, bandwidths: f64, alone: usize| {
        let varied =
            (0..varied).flat_map(|n| varying(random, 100.0 * (n + 1) as f64, bandwidths).0);
        let mut all: Vec<Candidate> = varied.collect();
        for n in 0..alone {
            all.push(candidate(2000.0 + 100.0 * n as f64, mode(random)));
        }
        all
    };
    for (varied, bandwidths, alone, modes) in [
        (3, 0.1, 3, 6),
        // Two poles more than modes, or the smaller part of the modes.
        (2, 0.1, 0, 2),
        (1, 0.1, 0, 3),
        (3, 0.1, 4, 13),
        // Far from each other.
        (3, 1.6, 0, 9),
    ] {
        let found = merged(poles(&mut random, varied, bandwidths, alone));
        assert_eq!(
            found.candidates.len(),
            modes,
            "{varied} {bandwidths} {alone}"
        );
    }
    // Pairs of modes with separate shapes.
    for _ in 0..200 {
        let pairs: Vec<Candidate> = (0..6)
            .map(|n| {
                let omega = 100.0 * f64::from(n / 2 + 1) + 0.1 * f64::from(n % 2);
                candidate(omega, mode(&mut random))
            })
            .collect();
        assert_eq!(merged(pairs).candidates.len(), 6);
    }
}

/// Three pairs of poles with the shares of the first pole in each FRF.
fn pairs(random: &mut ChaCha8Rng, share: impl Fn(usize) -> f64) -> Vec<Candidate> {
    let pair = |omega: f64| {
        let residues = mode(random);
        let part = |of_second: bool| {
            let shares = (0..SENSORS).map(|f| {
                let first = share(f);
                if of_second { 1.0 - first } else { first }
            });
            residues
                .iter()
                .zip(shares)
                .map(|(a, share)| a * share)
                .collect()
        };
        [
            candidate(omega, part(false)),
            candidate(omega + 0.5, part(true)),
        ]
    };
    [100.0, 200.0, 300.0].into_iter().flat_map(pair).collect()
}

#[test]
fn a_run_slightly_beyond_the_poles_belongs_to_the_mode() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let outlying = |share: f64| move |f: usize| if f.is_multiple_of(4) { share } else { 0.6 };
    let found = merged(pairs(&mut random, outlying(1.15)));
    assert_eq!(found.candidates.len(), 3);
    // Shares of 0.6 and 0.4 in poles 0.5 rad/s apart.
    let same = merged(pairs(&mut random, |_| 0.6));
    let spread_hz = 0.5 * 0.24f64.sqrt() / std::f64::consts::TAU;
    assert!((same.findings[0].value.unwrap() / spread_hz - 1.0).abs() < 1e-9);
    let far = merged(pairs(&mut random, outlying(1.5)));
    assert_eq!(far.candidates.len(), 6);
}

#[test]
fn local_modes_of_separate_sensors_stay() {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let local = merged(pairs(&mut random, |f| {
        if f < SENSORS / 2 { 0.93 } else { 0.07 }
    }));
    assert_eq!(local.candidates.len(), 6);
}
