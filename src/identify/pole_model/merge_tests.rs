//! Smoothing over frequency lines leaves one pole for each mode; close modes of other shapes stay.

use num_complex::Complex64;

use crate::axis::FrequencyAxis;
use crate::finding::Code;
use crate::frf::{FrfSet, Function, FunctionData};
use crate::identify::{IdentifyOptions, identify};
use crate::modal::{ModalModel, Pole};
use crate::quantity::FrfKind;

const POINTS: usize = 6;

/// Receptances at six points of modes with these frequencies, damping ratios and shapes, each value
/// the mean of so many lines.
fn measured(modes: &[(f64, f64, [f64; POINTS])], smoothed_lines: usize) -> FrfSet {
    let axis = FrequencyAxis {
        start_hz: 20.0,
        step_hz: 0.05,
        len: 1600,
    };
    let mut set = FrfSet::new(axis);
    let half = (smoothed_lines / 2) as f64;
    for point in 0..POINTS {
        let exact = |omega: f64| -> Complex64 {
            let s = Complex64::new(0.0, omega);
            let term = |(hz, damping, shape): &(f64, f64, [f64; POINTS])| {
                let lambda = Pole::from_frequency(*hz, *damping).lambda;
                let residue = Complex64::new(0.0, -shape[point] * shape[0]);
                residue / (s - lambda) + residue.conj() / (s - lambda.conj())
            };
            modes.iter().map(term).sum()
        };
        let value = |k: usize| -> Complex64 {
            let step = std::f64::consts::TAU * axis.step_hz;
            let lines = (0..smoothed_lines).map(|n| (n as f64 - half) * step);
            lines
                .map(|shift| exact(axis.rad_s(k) + shift))
                .sum::<Complex64>()
                / smoothed_lines as f64
        };
        let noise = |k: usize| {
            let phase = (k * k * (point + 3)) as f64 * 0.7;
            Complex64::from_polar(1e-4, phase)
        };
        let dof = |point: usize| format!("{}:+Z", point + 1).parse().unwrap();
        let function = Function {
            response: dof(point),
            reference: dof(0),
            kind: FrfKind::Receptance,
            averages: None,
            estimator: None,
            variance_dof: None,
        };
        let values = (0..axis.len).map(|k| value(k) + noise(k)).collect();
        set.push(
            function,
            FunctionData {
                values,
                ..FunctionData::default()
            },
        )
        .unwrap();
    }
    set
}

const FIRST: [f64; POINTS] = [1.0, 0.7, -0.4, 0.5, -0.9, 0.2];
const SECOND: [f64; POINTS] = [0.8, -0.6, 0.9, 0.3, 0.1, -0.7];

fn identified(set: &FrfSet) -> ModalModel {
    identify(set, &IdentifyOptions::default()).unwrap()
}

#[test]
fn modes_of_frfs_smoothed_over_three_lines_are_found_once() {
    let modes = [(40.0, 0.005, FIRST), (70.0, 0.004, SECOND)];
    let model = identified(&measured(&modes, 3));
    let hz: Vec<f64> = model.modes.iter().map(|mode| mode.frequency_hz).collect();
    assert_eq!(hz.len(), 2, "{hz:?}");
    for (found, (expected, ..)) in hz.iter().zip(modes) {
        assert!((found - expected).abs() < 0.01, "{hz:?}");
    }
    let merged = model
        .findings
        .iter()
        .filter(|finding| finding.code == Code::PolesMerged);
    assert_eq!(merged.count(), 2);
}

#[test]
fn a_single_mode_of_smoothed_frfs_is_found_once() {
    // The wide mode needs no second pole.
    let modes = [(40.0, 0.005, FIRST), (70.0, 0.03, SECOND)];
    let model = identified(&measured(&modes, 3));
    let hz: Vec<f64> = model.modes.iter().map(|mode| mode.frequency_hz).collect();
    assert_eq!(hz.len(), 2, "{hz:?}");
    let mut findings = model.findings.iter();
    assert!(findings.any(|finding| finding.code == Code::PolesMerged));
    // The sum of the two poles is the mode, so that a weak one far away keeps its shape.
    let modes = [(40.0, 0.005, FIRST), (70.0, 0.03, SECOND.map(|v| 0.1 * v))];
    let model = identified(&measured(&modes, 3));
    let mpc: Vec<Option<f64>> = model.modes.iter().map(|mode| mode.mpc).collect();
    assert!(mpc.iter().all(|mpc| *mpc > Some(0.99)), "{mpc:?}");
}

#[test]
fn two_modes_of_one_shape_stay() {
    // 1.5 lines apart, as smoothing leaves poles, but the second has half of the residue.
    let modes = [
        (40.0, 0.005, FIRST),
        (40.075, 0.005, FIRST.map(|v| 0.7 * v)),
    ];
    let model = identified(&measured(&modes, 1));
    assert_eq!(model.modes.len(), 2);
}

#[test]
fn close_modes_of_different_shapes_are_not_merged() {
    // A tenth of a half-power bandwidth apart.
    let model = identified(&measured(
        &[(40.0, 0.005, FIRST), (40.04, 0.005, SECOND)],
        1,
    ));
    assert_eq!(model.modes.len(), 2);
    assert!(
        model
            .findings
            .iter()
            .all(|finding| finding.code != Code::PolesMerged)
    );
}
