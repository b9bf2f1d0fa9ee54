//! Smoothing over frequency lines leaves one pole for each mode; close modes of other shapes stay.

use num_complex::Complex64;

use crate::axis::FrequencyAxis;
use crate::finding::Code;
use crate::frf::{FrfSet, Function, FunctionData};
use crate::identify::{IdentifyOptions, identify};
use crate::modal::{ModalModel, Pole};
use crate::quantity::FrfKind;

const POINTS: usize = 6;

/// Weights of the lines around each that smoothing sums: none, a mean over three lines, Hann.
const ONE: [f64; 1] = [1.0];
const MEAN: [f64; 3] = [1.0 / 3.0; 3];
const HANN: [f64; 3] = [0.25, 0.5, 0.25];

/// Receptances at six points of modes with these frequencies, damping ratios and shapes, each value
/// the weighted mean of some lines.
fn measured(modes: &[(f64, f64, [f64; POINTS])], weights: &[f64]) -> FrfSet {
    let axis = FrequencyAxis {
        start_hz: 20.0,
        step_hz: 0.05,
        len: 1600,
    };
    let mut set = FrfSet::new(axis);
    let half = (weights.len() / 2) as f64;
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
            let lines = weights.iter().enumerate();
            lines
                .map(|(n, weight)| weight * exact(axis.rad_s(k) + (n as f64 - half) * step))
                .sum()
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
    let model = identified(&measured(&modes, &MEAN));
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
    for weights in [MEAN, HANN] {
        let model = identified(&measured(&modes, &weights));
        let hz: Vec<f64> = model.modes.iter().map(|mode| mode.frequency_hz).collect();
        assert_eq!(hz.len(), 2, "{weights:?}: {hz:?}");
        let mut findings = model.findings.iter();
        assert!(findings.any(|finding| finding.code == Code::PolesMerged));
    }
}

#[test]
fn two_modes_of_one_shape_stay() {
    // 1.5 lines apart, as smoothing leaves poles, but the second has half of the residue.
    let unequal = (40.075, FIRST.map(|v| 0.7 * v));
    // Equal residues, 1.2 and 1.9 lines apart.
    for (hz, shape) in [unequal, (40.06, FIRST), (40.095, FIRST)] {
        let modes = [(40.0, 0.005, FIRST), (hz, 0.005, shape)];
        let model = identified(&measured(&modes, &ONE));
        assert_eq!(model.modes.len(), 2, "{hz}");
    }
}

#[test]
fn close_modes_of_different_shapes_are_not_merged() {
    // A tenth of a half-power bandwidth apart.
    let model = identified(&measured(
        &[(40.0, 0.005, FIRST), (40.04, 0.005, SECOND)],
        &ONE,
    ));
    assert_eq!(model.modes.len(), 2);
    assert!(
        model
            .findings
            .iter()
            .all(|finding| finding.code != Code::PolesMerged)
    );
}
