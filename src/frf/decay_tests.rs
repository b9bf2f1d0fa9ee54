//! A sampled system whose H is known exactly: the truncation error against its bound, and the
//! exponential window.
//!
//! The response to force samples `f_j` is `x_n = Σ_j f_j Σ_m 2 Re(A_m z_m^(n-j))`, `z = e^(λ dt)`,
//! so that over an endless record `H(ω) = Σ_m A_m / (1 - z_m e^(-iω dt)) + conj.`, without any
//! discretisation error.

use num_complex::Complex64;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::*;
use crate::axis::{Band, TimeAxis};
use crate::finding::{Code, Severity};
use crate::linalg::{complex_matrix, least_squares};
use crate::modal::Pole;
use crate::quantity::Quantity;
use crate::record::{Channel, Hit, Role, Samples};
use crate::signal::ExponentialWindow;

const STEP_S: f64 = 1e-3;
const LEN: usize = 8192;

/// A pole at `hz` that decays by `e^-n` from the hit at sample `start` to the end of the record,
/// and its amplitude.
fn mode(hz: f64, time_constants: f64, start: usize, amplitude: Complex64) -> Mode {
    let sigma = time_constants / ((LEN - start) as f64 * STEP_S);
    Mode {
        lambda: Complex64::new(-sigma, std::f64::consts::TAU * hz),
        amplitude,
    }
}

#[derive(Clone, Copy)]
struct Mode {
    lambda: Complex64,
    amplitude: Complex64,
}

impl Mode {
    fn at(&self, omega: f64) -> Complex64 {
        let turn = Complex64::cis(-omega * STEP_S);
        let z = (self.lambda * STEP_S).exp();
        self.amplitude / (1.0 - z * turn) + self.amplitude.conj() / (1.0 - z.conj() * turn)
    }
}

fn hit(modes: &[Mode], force: &[f64], start: usize, noise: f64) -> Hit {
    let mut samples = vec![0.0; LEN];
    for (j, f) in force.iter().enumerate() {
        for mode in modes {
            for (n, sample) in samples[start + j..].iter_mut().enumerate() {
                let z = (mode.lambda * STEP_S * n as f64).exp();
                *sample += f * 2.0 * (mode.amplitude * z).re;
            }
        }
    }
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    for sample in &mut samples {
        let draw: f64 = StandardNormal.sample(&mut rng);
        *sample += noise * draw;
    }
    let mut pulse = vec![0.0; LEN];
    pulse[start..start + force.len()].copy_from_slice(force);
    let channel = |role, quantity, samples| Channel {
        role,
        dof: "1:+Z".parse().unwrap(),
        quantity,
        to_si: 1.0,
        samples: Samples::F64(samples),
    };
    Hit {
        axis: TimeAxis {
            start_s: 0.0,
            step_s: STEP_S,
            len: LEN,
        },
        force: channel(Role::Force, Quantity::Force, pulse),
        responses: vec![channel(Role::Response, Quantity::Displacement, samples)],
        origin: "sampled system".to_owned(),
    }
}

fn bound(hit: &Hit, options: &EstimateOptions) -> Option<f64> {
    let bounds = truncation_bounds(std::slice::from_ref(hit), options).unwrap();
    bounds.into_values().next().unwrap().bound
}

/// Largest relative error of the estimate within a band.
fn worst_error(set: &FrfSet, modes: &[Mode], lo_hz: f64, hi_hz: f64) -> f64 {
    let lines = set.axis().lines(&Band::new(lo_hz, hi_hz).unwrap());
    lines
        .map(|k| {
            let truth: Complex64 = modes.iter().map(|m| m.at(set.axis().rad_s(k))).sum();
            (set.values(0)[k] - truth).norm() / truth.norm()
        })
        .fold(0.0, f64::max)
}

#[test]
fn the_bound_is_the_truncation_error() {
    for n in [2.0, 6.0, 9.5] {
        let mode = mode(60.0, n, 64, Complex64::new(0.2, -0.9));
        let hit = hit(&[mode], &[1.0, 3.0, 1.0], 64, 0.0);
        let set = estimate(std::slice::from_ref(&hit), &EstimateOptions::default()).unwrap();
        let error = worst_error(&set, &[mode], 59.8, 60.2);
        let bound = bound(&hit, &EstimateOptions::default()).unwrap();
        let truth = f64::exp(-n);
        // The conjugate term and the length of the pulse make up to 0.6 %.
        assert!((error / truth - 1.0).abs() < 0.01, "{n}: {error} {truth}");
        // Where in its cycle the response is at the edges of a quarter: ζ of each energy, two of
        // them, squared.
        let ripple = 4.0
            * Pole {
                lambda: mode.lambda,
            }
            .damping_ratio();
        assert!(
            (bound / truth - 1.0).abs() < ripple,
            "{n}: {bound} {truth} {ripple}"
        );
        assert!(error < (1.01 + ripple) * bound);
        let finding = set.findings.last().unwrap();
        assert_eq!(
            (finding.code, finding.value),
            (Code::Truncated, Some(bound))
        );
        let expected = if n < 6.0 {
            Severity::Warning
        } else {
            Severity::Info
        };
        // At n = 6 the bound lies on the limit itself.
        assert!((n - 6.0).abs() < 0.1 || finding.severity == expected);
    }
}

#[test]
fn a_weak_slow_mode_under_a_strong_fast_one_sets_the_bound() {
    let fast = mode(150.0, 25.0, 64, Complex64::new(0.0, -10.0));
    let slow = mode(40.0, 5.0, 64, Complex64::new(0.0, -0.5));
    let hit = hit(&[fast, slow], &[1.0], 64, 0.0);
    let set = estimate(std::slice::from_ref(&hit), &EstimateOptions::default()).unwrap();
    let bound = bound(&hit, &EstimateOptions::default()).unwrap();
    let error = worst_error(&set, &[fast, slow], 39.95, 40.05);
    assert!((bound / f64::exp(-5.0) - 1.0).abs() < 0.01, "{bound}");
    // The fast mode adds 2 % to H there, but no error.
    assert!((error / bound - 1.0).abs() < 0.03, "{error} {bound}");
}

#[test]
fn noise_is_taken_off_until_it_fills_the_tail() {
    let mode = mode(60.0, 5.0, 512, Complex64::new(0.0, -0.5));
    // The last quarter of the response has a mean square of 0.5 e^(-10) (e^2.5 - 1) / 2.5 = 1.0e-4.
    let quiet = hit(&[mode], &[1.0], 512, 4e-3);
    let quiet = bound(&quiet, &EstimateOptions::default()).unwrap();
    assert!((quiet / f64::exp(-5.0) - 1.0).abs() < 0.1, "{quiet}");
    let loud = hit(&[mode], &[1.0], 512, 1.2e-2);
    assert_eq!(bound(&loud, &EstimateOptions::default()), None);
}

#[test]
fn an_exponential_window_shifts_the_pole_by_its_decay_rate_exactly() {
    // Without a pre-trigger every line sees the same truncation factor: the estimate stays rational
    // with exact poles.
    let mode = mode(60.0, 2.0, 0, Complex64::new(0.3, -0.8));
    let window = ExponentialWindow::from_end_value(0.01, LEN as f64 * STEP_S).unwrap();
    let options = EstimateOptions {
        exponential: Some(window),
        ..EstimateOptions::default()
    };
    let hit = hit(&[mode], &[1.0], 0, 0.0);
    let set = estimate(std::slice::from_ref(&hit), &options).unwrap();
    assert!((set.added_damping_rad_s / window.decay_rad_s - 1.0).abs() < 1e-15);
    let pole = rational_pole(&set, 55.0, 65.0);
    let shifted = mode.lambda - window.decay_rad_s;
    assert!((pole.lambda - shifted).norm() < 1e-7 * window.decay_rad_s);
    let freed = pole.without_added_damping(set.added_damping_rad_s);
    assert!((freed.lambda - mode.lambda).norm() < 1e-7 * window.decay_rad_s);
}

#[test]
fn an_exponential_window_lowers_the_bound_by_its_end_value() {
    let mode = mode(60.0, 3.0, 64, Complex64::new(0.0, -0.5));
    let hit = hit(&[mode], &[1.0], 64, 0.0);
    let stretch_s = (LEN - 64) as f64 * STEP_S;
    let options = EstimateOptions {
        exponential: Some(ExponentialWindow::from_end_value(0.02, stretch_s).unwrap()),
        ..EstimateOptions::default()
    };
    let bound = bound(&hit, &options).unwrap();
    assert!(
        (bound / (0.02 * f64::exp(-3.0)) - 1.0).abs() < 0.005,
        "{bound}"
    );
    let set = estimate(std::slice::from_ref(&hit), &options).unwrap();
    let mut damped = mode;
    damped.lambda -= set.added_damping_rad_s;
    let error = worst_error(&set, &[damped], 59.8, 60.2);
    assert!(
        error < 1.01 * bound && error > 0.98 * bound,
        "{error} {bound}"
    );
}

#[test]
fn an_offset_is_no_slow_decay() {
    let mode = mode(60.0, 6.0, 64, Complex64::new(0.0, -0.5));
    let mut hit = hit(&[mode], &[1.0], 64, 0.0);
    let raised = hit.responses[0].samples.iter().map(|v| v + 3.0).collect();
    hit.responses[0].samples = Samples::F64(raised);
    let bound = bound(&hit, &EstimateOptions::default()).unwrap();
    assert!((bound / f64::exp(-6.0) - 1.0).abs() < 0.005, "{bound}");
}

/// The pole of `H = (b0 + b1 u) / (1 + a1 u + a2 u²)`, `u = e^(-iω dt)`, linear least squares over
/// a band.
fn rational_pole(set: &FrfSet, lo_hz: f64, hi_hz: f64) -> Pole {
    let lines: Vec<usize> = set
        .axis()
        .lines(&Band::new(lo_hz, hi_hz).unwrap())
        .collect();
    let u = |row: usize| Complex64::cis(-set.axis().rad_s(lines[row]) * STEP_S);
    let h = |row: usize| set.values(0)[lines[row]];
    let a = complex_matrix(lines.len(), 4, |row, column| match column {
        0 => Complex64::ONE,
        1 => u(row),
        2 => -u(row) * h(row),
        _ => -u(row) * u(row) * h(row),
    });
    let b = complex_matrix(lines.len(), 1, |row, _| h(row));
    let x = least_squares(&a, &b).unwrap();
    let (a1, a2) = (x[(2, 0)], x[(3, 0)]);
    let roots = [1.0, -1.0].map(|sign| 0.5 * (-a1 + sign * (a1 * a1 - 4.0 * a2).sqrt()));
    let upper = roots.into_iter().max_by(|a, b| a.im.total_cmp(&b.im));
    Pole {
        lambda: upper.unwrap().ln() / STEP_S,
    }
}
