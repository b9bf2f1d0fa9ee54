//! Windows bias the damping of fitted poles little, for lightly damped modes in a record of one and
//! a half time constants.

use std::slice::from_ref;

use modalign::dof::Dof;
use modalign::frf::{EstimateOptions, FrfSet, HammerOptions, ResponseWindow, evaluate_hammer_test};
use modalign::linalg::{least_squares_real, real_matrix};
use modalign::modal::{ModalModel, Mode, ModeShape, Scaling};
use modalign::quantity::Quantity;
use modalign::record::InMemory;
use modalign::signal::Offset;
use modalign::synth::{Faults, HammerTest, LowPassOptions, Noise, Pulse, Truth, roving_hammer};
use num_complex::Complex64;
use rayon::prelude::*;

/// Frequencies, Hz, and damping: 0.1 to 0.2 %, all of one decay rate.
const MODES: [(f64, f64); 3] = [(200.0, 0.002), (290.0, 0.2 * 0.002 / 0.29), (400.0, 0.001)];
/// Time constants in a record.
const TIME_CONSTANTS: f64 = 1.5;
const RATE_HZ: f64 = 2048.0;
/// Tests that are drawn for each pre-trigger.
const TESTS: u64 = 24;

fn test(pretrigger: f64, seed: u64) -> HammerTest {
    let dof: Dof = "1:+Z".parse().unwrap();
    let modes = MODES.map(|(hz, damping)| {
        let shape = ModeShape::new([(dof.clone(), 1.0.into())]);
        Mode::new(hz, Some(damping), shape, Scaling::UnitModalMass)
    });
    let model = ModalModel {
        modes: modes.to_vec(),
        ..ModalModel::default()
    };
    let decay = MODES[0].1 * std::f64::consts::TAU * MODES[0].0;
    let samples = (RATE_HZ * TIME_CONSTANTS / decay).round() as usize;
    HammerTest {
        truth: Truth::from_real_shapes(&model, from_ref(&dof), from_ref(&dof)).unwrap(),
        hits: roving_hammer(from_ref(&dof), from_ref(&dof)),
        averages_per_point: 5,
        sampling_rate_hz: RATE_HZ,
        samples,
        pretrigger_s: pretrigger * samples as f64 / RATE_HZ,
        quantity: Quantity::Acceleration,
        pulse: Pulse {
            peak_n: 100.0,
            peak_spread: 0.2,
            duration_s: 1.5e-3,
            duration_spread: 0.1,
        },
        filter: LowPassOptions::default(),
        noise: Noise {
            force_snr_db: Some(60.0),
            response_snr_db: Some(60.0),
        },
        faults: Faults::default(),
        seed,
    }
}

/// Poles and residues of all modes at once, `H/s² = Σ A/(s − λ) + c₀ + c₁ s`, by Gauss-Newton from
/// the truth: an unbiased estimate.
fn poles(set: &FrfSet) -> Vec<Complex64> {
    let decay = set.added_damping_rad_s;
    let band = modalign::axis::Band::new(150.0, 450.0).unwrap();
    let lines: Vec<usize> = set.axis().lines(&band).collect();
    let scale = std::f64::consts::TAU * 300.0;
    let s = |line: usize| Complex64::new(0.0, set.axis().rad_s(line) / scale);
    let values: Vec<Complex64> = lines.iter().map(|line| set.values(0)[*line]).collect();
    let mut poles: Vec<Complex64> = MODES
        .iter()
        .map(|(hz, damping)| {
            let omega = std::f64::consts::TAU * hz;
            Complex64::new(
                -damping * omega - decay,
                omega * (1.0 - damping * damping).sqrt(),
            ) / scale
        })
        .collect();
    let mut residues: Option<Vec<Complex64>> = None;
    for _ in 0..8 {
        // Unknowns: residues of the poles and of their conjugates, two terms of the rest, and once
        // the residues are known the changes of the poles; each with its real and imaginary part.
        let columns = |line: usize| -> Vec<Complex64> {
            let at = s(line);
            let single = poles.iter().map(|pole| (at - pole).inv());
            let conjugate = poles.iter().map(|pole| (at - pole.conj()).inv());
            let rest = [Complex64::ONE, at];
            let change = poles.iter().zip(residues.iter().flatten());
            let change = change.map(|(pole, residue)| residue / ((at - pole) * (at - pole)));
            single.chain(conjugate).chain(rest).chain(change).collect()
        };
        let rows: Vec<Vec<Complex64>> = lines.iter().map(|line| columns(*line)).collect();
        let width = rows[0].len();
        let matrix = real_matrix(2 * rows.len(), 2 * width, |row, column| {
            let value = rows[row / 2][column / 2];
            let value = if column % 2 == 0 {
                value
            } else {
                value * Complex64::I
            };
            if row % 2 == 0 { value.re } else { value.im }
        });
        let data: Vec<f64> = values
            .iter()
            .flat_map(|value| [value.re, value.im])
            .collect();
        let solved = least_squares_real(&matrix, &data).unwrap();
        let unknown = |index: usize| Complex64::new(solved[2 * index], solved[2 * index + 1]);
        let count = poles.len();
        if residues.is_some() {
            for (index, pole) in poles.iter_mut().enumerate() {
                *pole += unknown(2 * count + 2 + index);
            }
        }
        residues = Some((0..count).map(unknown).collect());
    }
    poles.iter().map(|pole| pole * scale + decay).collect()
}

/// Mean relative error of the damping of each mode, %, over the tests.
fn bias(pretrigger: f64, options: &HammerOptions) -> Vec<f64> {
    let errors: Vec<Vec<f64>> = (0..TESTS)
        .into_par_iter()
        .map(|seed| {
            let hits = test(pretrigger, 77 + seed).generate().unwrap();
            let estimate = evaluate_hammer_test(&mut InMemory::new(&hits), options).unwrap();
            let poles = poles(&estimate.estimated.set);
            let errors = poles
                .iter()
                .zip(&MODES)
                .map(|(pole, (_, damping))| 100.0 * (-pole.re / pole.norm() / damping - 1.0));
            errors.collect()
        })
        .collect();
    (0..MODES.len())
        .map(|mode| errors.iter().map(|biases| biases[mode]).sum::<f64>() / TESTS as f64)
        .collect()
}

fn worst(errors: &[f64]) -> f64 {
    errors
        .iter()
        .fold(0.0, |worst: f64, bias| worst.max(bias.abs()))
}

#[test]
fn an_exponential_window_with_the_pretrigger_cut_leaves_the_damping_as_it_is() {
    let with = |response_window, cut_pretrigger| HammerOptions {
        response_window,
        cut_pretrigger,
        estimate: EstimateOptions {
            offset: Offset::RemoveIfPretrigger,
            ..EstimateOptions::default()
        },
        ..HammerOptions::default()
    };
    for pretrigger in [0.02, 0.10] {
        let default_bias = bias(pretrigger, &with(ResponseWindow::Auto, None));
        let uncut = bias(pretrigger, &with(ResponseWindow::Auto, Some(false)));
        let plain = bias(pretrigger, &with(ResponseWindow::Off, Some(false)));
        println!(
            "pre-trigger {:2.0} %: damping bias {:.3} % (window, cut), {:.3} % (window, uncut), {:.2} % (no window, uncut)",
            100.0 * pretrigger,
            worst(&default_bias),
            worst(&uncut),
            worst(&plain)
        );
        assert!(worst(&default_bias) < 0.3, "{default_bias:?}");
        // The check can fail: without the cut or the window the bias is there.
        assert!(worst(&plain) > worst(&default_bias), "{plain:?}");
    }
}
