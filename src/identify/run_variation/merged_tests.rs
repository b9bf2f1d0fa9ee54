//! Alignment and merging of modes with given shifts between runs.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::identify::estimator::Candidate;
use crate::modal::Pole;

use crate::identify::data::line_shape::LineShape;
use crate::identify::run_variation::run_means::RunMean;
use crate::identify::run_variation::{
    RunShifts, ShiftDecision, ShiftedMode, independently_shifted,
};

#[test]
fn an_frf_is_aligned_from_the_pole_of_its_run_to_the_mean() {
    let mean = Complex64::new(-0.7, 60.0);
    let shifts = vec![Complex64::new(0.02, -0.4), Complex64::new(-0.03, 0.9)];
    let mode = ShiftedMode {
        lambda: mean,
        scatter: 0.6,
        decay_std: 0.0,
        stds: vec![0.1; 2],
        residues: vec![Complex64::new(1.0, -2.0), Complex64::new(-0.5, 3.0)],
        shifts: shifts.clone(),
    };
    let shape = LineShape::EXACT;
    for (f, run) in [(0, 1), (1, 0)] {
        let a = mode.residues[f];
        for omega in [58.0, 60.3, 61.0] {
            let with = |lambda: Complex64| {
                let pole = |lambda: Complex64| shape.pole(omega, lambda);
                a * pole(lambda) + a.conj() * pole(lambda.conj())
            };
            let aligned = with(mean + shifts[run]) + mode.correction(shape, f, run, omega);
            assert!((aligned - with(mean)).norm() < 1e-12, "{f} {omega}");
        }
    }
}

#[test]
fn a_mode_is_stated_at_its_mean_over_the_runs() {
    let lambda = Complex64::new(-0.01, 1.0) * TAU * 50.0;
    let candidate = Candidate {
        frequency_std_hz: Some(0.003),
        damping_std: Some(1e-4),
        ..Candidate::new(Pole { lambda })
    };
    let moved = RunShifts::default();
    assert_eq!(moved.merged(candidate.clone(), None, 0.0), candidate);
    let mean = RunMean {
        shift: TAU * 0.2,
        std: TAU * 0.04,
        scatter: TAU * 0.1,
        decay_std: TAU * 50.0 * 3e-5,
    };
    let merged = moved.merged(candidate.clone(), Some(mean), TAU * 0.03);
    assert!((merged.pole.damped_frequency_hz() - 50.2).abs() < 1e-12);
    assert!((merged.frequency_std_hz.unwrap() - 0.05).abs() < 1e-15);
    // The decay rates scatter less than the fit states, the mean frequency by 0.04 of 50 Hz.
    let ratio = merged.pole.damping_ratio();
    let expected = 1e-4f64.hypot(ratio * 0.04 / 50.0);
    assert!((merged.damping_std.unwrap() - expected).abs() < 1e-8);
    // A fit without deviation leaves that of the mean frequency alone.
    let exact = Candidate {
        damping_std: Some(0.0),
        ..candidate.clone()
    };
    let still = RunMean {
        decay_std: 0.0,
        ..mean
    };
    let by_frequency = moved.merged(exact, Some(still), 0.0).damping_std.unwrap();
    let expected = ratio * 0.04 / 50.0f64.hypot(0.5);
    assert!((by_frequency / expected - 1.0).abs() < 1e-9);
    let mean = RunMean {
        decay_std: TAU * 50.0 * 3e-4,
        ..mean
    };
    let scattered = moved.merged(candidate, Some(mean), 0.0);
    let expected = 3e-4f64.hypot(ratio * 0.04 / 50.0);
    assert!((scattered.damping_std.unwrap() - expected).abs() < 1e-7);
}

/// A decision for a mode with these shifts of five runs.
fn decision(shifts: [f64; 5], group: usize, is_conclusive: bool) -> ShiftDecision {
    ShiftDecision {
        mode: ShiftedMode {
            lambda: Complex64::new(-1.0, 100.0),
            scatter: 1.0,
            decay_std: 0.0,
            shifts: shifts.map(|shift| Complex64::new(0.0, shift)).to_vec(),
            stds: vec![0.1; 5],
            residues: vec![Complex64::ONE; 5],
        },
        is_conclusive,
        was_shifted: false,
        group,
        gain: 1.0,
    }
}

#[test]
fn modes_without_a_common_cause_shift_where_nearly_all_are_conclusive() {
    let all = [
        decision([1.0, -1.0, 2.0, 0.0, -2.0], 0, true),
        decision([1.0, 1.0, -1.0, -1.0, 0.0], 1, true),
        decision([-2.0, 2.0, 0.0, 2.0, -2.0], 2, true),
        decision([0.0, 2.0, 1.0, -2.0, -1.0], 3, false),
    ];
    let groups = |decisions: &[ShiftDecision], decided: usize| {
        let modes = independently_shifted(&decisions.iter().collect::<Vec<_>>(), decided);
        modes.map(|modes| modes.iter().map(|mode| mode.group).collect::<Vec<usize>>())
    };
    assert_eq!(groups(&all, 4), Some(vec![0, 1, 2]));
    // Too few of the decided resonances, and too few modes.
    assert_eq!(groups(&all, 5), None);
    assert_eq!(groups(&all[1..], 2), None);
}

#[test]
fn a_mode_that_does_not_shift_with_the_others_is_excluded() {
    let decision = |shifts, group| decision(shifts, group, true);
    // The last two are one resonance, with one unshifted mode.
    let all = [
        decision([1.0, -1.0, 2.0, 0.0, -2.0], 0),
        decision([1.1, -0.9, 2.2, 0.0, -2.1], 1),
        decision([2.0, 2.0, -2.0, -2.0, 0.0], 2),
        decision([0.5, -0.6, 1.0, 0.1, -1.0], 3),
        decision([0.5, -0.6, 1.0, 0.1, -1.0], 4),
        decision([0.0; 5], 4),
    ];
    let moved = RunShifts {
        runs: (0..5).map(|run| vec![run]).collect(),
        ..RunShifts::default()
    };
    let taken = moved.modes_with_common_cause(all.iter().collect());
    let groups: Vec<usize> = taken.iter().map(|decision| decision.group).collect();
    assert_eq!(groups, [0, 1, 3]);
    // One resonance has no other to agree with.
    assert!(
        moved
            .modes_with_common_cause(all[4..].iter().collect())
            .is_empty()
    );
}
