use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::fourier::ComplexPlan;
use crate::identify::noise::line_correlation::*;
use crate::identify::synthetic::{white_noise, windowed_noise};
use crate::linalg;

/// Spectra of noise that decays as `e^(−at)` over a record of `lines` samples: lines × FRFs.
fn decaying(lines: usize, functions: usize, at_end: f64) -> linalg::ComplexMatrix {
    let columns: Vec<Vec<Complex64>> = (0..functions as u64)
        .map(|f| windowed_noise(lines, at_end, 7 + f))
        .collect();
    linalg::complex_matrix(lines, functions, |k, f| columns[f][k])
}

#[test]
fn white_noise_has_no_correlation() {
    let noise: Vec<Vec<Complex64>> = (0..4).map(|f| white_noise(2000, 1.0, 3 + f)).collect();
    let rest = linalg::complex_matrix(2000, 4, |k, f| noise[f][k]);
    let rest = Residual::of_all(&rest);
    assert_eq!(
        LineCorrelation::from_residual(&rest),
        Some(LineCorrelation::WHITE)
    );
}

#[test]
fn noise_factor_under_an_exponential_window_is_that_of_theory() {
    let size_of = |noise: &linalg::ComplexMatrix| ((8192 * 6) as f64).sqrt() / noise.norm_l2();
    // a T; modes whose windowed decay rate is 3 a and 60 a.
    for at_end in [1.0, 4.0, 10.0] {
        let noise = decaying(8192, 6, at_end);
        let size = size_of(&noise);
        let rest = linalg::complex_matrix(8192, 6, |k, f| size * noise[(k, f)]);
        let estimated =
            LineCorrelation::from_residual(&Residual::of_all(&rest)).expect("lines enough");
        for ratio in [3.0, 60.0] {
            let (step, decay) = (std::f64::consts::TAU, ratio * at_end);
            // T = 1 s: factor 2aT ∫ e^(−2(σ+a)t) dt 2σ/(1 − e^(−2aT)), and with (1 − u)² for the
            // pole.
            let q: f64 = 1.0 + at_end / decay;
            let first = 2.0 * at_end / (1.0 - (-2.0 * at_end).exp());
            let amplitude = first / q;
            let pole = first * (1.0 / q - 2.0 / (q * q) + 2.0 / (q * q * q));
            let (a, p) = (
                estimated.amplitude_noise_factor(decay, step),
                estimated.pole_noise_factor(decay, step),
            );
            // A record that hardly decays has much of its correlation in lags below the limit, and
            // the noise of a mode far wider than the correlation consists of them.
            let bound = match (at_end < 4.0, at_end > 4.0) {
                (true, _) => 0.15,
                (_, true) => 0.2,
                _ => 0.1,
            };
            assert!(
                (a / amplitude - 1.0).abs() < bound,
                "{at_end} {ratio}: {a} {amplitude}"
            );
            assert!(
                (p / pole - 1.0).abs() < bound,
                "{at_end} {ratio}: {p} {pole}"
            );
            if at_end >= 4.0 {
                let exact = LineCorrelation::of_window(at_end, step, 8192);
                let (a, p) = (
                    exact.amplitude_noise_factor(decay, step),
                    exact.pole_noise_factor(decay, step),
                );
                assert!(
                    (a / amplitude - 1.0).abs() < 0.1,
                    "{at_end} {ratio}: {a} {amplitude}"
                );
                assert!((p / pole - 1.0).abs() < 0.1, "{at_end} {ratio}: {p} {pole}");
            }
        }
    }
}

#[test]
fn noise_decay_rate_is_estimated_and_smoothed_noise_has_none() {
    let decay_rate = |noise: linalg::ComplexMatrix| {
        let size = ((4096 * 4) as f64).sqrt() / noise.norm_l2();
        let rest = linalg::complex_matrix(4096, 4, |k, f| size * noise[(k, f)]);
        let estimated =
            LineCorrelation::from_residual(&Residual::of_all(&rest)).expect("lines enough");
        estimated.decay(std::f64::consts::TAU)
    };
    for at_end in [4.0, 10.0, 40.0] {
        let ratio = decay_rate(decaying(4096, 4, at_end)).expect("lines enough") / at_end;
        assert!((ratio - 1.0).abs() < 0.25, "{at_end}: {ratio}");
    }
    let white = decaying(4104, 4, 0.0);
    let mean = |k: usize, f: usize| (k..k + 8).map(|n| white[(n, f)]).sum();
    assert_eq!(decay_rate(linalg::complex_matrix(4096, 4, mean)), None);
}

#[test]
fn noise_factor_of_noise_in_a_quarter_of_the_record_is_that_of_theory() {
    // A quarter of 8192 samples: a mode that decays within it meets four times the mean power.
    let plan = ComplexPlan::inverse(8192);
    let columns: Vec<Vec<Complex64>> = (0..6)
        .map(|f| {
            let mut samples = white_noise(8192, 4.0 / 8192.0, 30 + f);
            samples[2048..].fill(Complex64::ZERO);
            plan.run(&mut samples, &mut plan.scratch());
            samples.reverse();
            samples
        })
        .collect();
    let rest = linalg::complex_matrix(8192, 6, |k, f| columns[f][k]);
    let estimated = LineCorrelation::from_residual(&Residual::of_all(&rest)).expect("lines enough");
    let factor = estimated.amplitude_noise_factor(60.0, std::f64::consts::TAU);
    assert!((factor / 4.0 - 1.0).abs() < 0.15, "{factor}");
}

#[test]
fn correlated_noise_is_separated_from_missing_modes() {
    let noise_correlation = |rest: linalg::ComplexMatrix| {
        let size = ((4096 * 4) as f64).sqrt() / rest.norm_l2();
        let rest = linalg::complex_matrix(4096, 4, |k, f| size * rest[(k, f)]);
        LineCorrelation::of_correlated_noise(&Residual::of_all(&rest))
    };
    let noise = decaying(4096, 4, 40.0);
    assert!(noise_correlation(noise.clone()).is_some());
    // Second differences estimate white noise, and noise under a window that leaves them large
    // enough.
    assert_eq!(noise_correlation(decaying(4096, 4, 0.0)), None);
    assert_eq!(noise_correlation(decaying(4096, 4, 2.0)), None);
    // One profile common to all FRFs, and a few modes.
    assert_eq!(
        noise_correlation(linalg::complex_matrix(4096, 4, |k, f| {
            (1.0 + f as f64) * noise[(k, 0)]
        })),
        None
    );
    let mode = |k: usize, n: usize| Complex64::new(20.0, k as f64 - 700.0 * n as f64).inv();
    let modes = |k: usize, f: usize| -> Complex64 {
        let term = |n: usize| (1.0 + (3 * n * n + 7 * f * n) as f64).sin() * mode(k, n);
        (0..6).map(term).sum()
    };
    assert_eq!(
        noise_correlation(linalg::complex_matrix(4096, 4, modes)),
        None
    );
}

#[test]
fn a_residual_above_the_noise_gives_no_correlation() {
    let rest = linalg::complex_matrix(400, 2, |k, _| Complex64::new(0.0, 0.1 * k as f64) - 40.0);
    assert_eq!(
        LineCorrelation::from_residual(&Residual::of_all(&rest)),
        None
    );
}

#[test]
fn correlation_follows_from_the_mean_product_of_phases() {
    for rho in [0.1, 0.5, 0.9] {
        let product = Complex64::from_polar(product_of_phases(rho), 0.7);
        let back = correlation(product);
        assert!(
            (back - Complex64::from_polar(rho, 0.7)).norm() < 1e-9,
            "{back}"
        );
    }
    // Four million pairs of correlation 1/2, computed elsewhere, gave 0.4061 with a standard
    // deviation of 0.0003.
    assert!((product_of_phases(0.5) - 0.406_298_886_460).abs() < 1e-11);
    assert!((product_of_phases(1.0) - 1.0).abs() < 0.01);
}

#[test]
fn a_steep_window_has_no_more_lags_than_lines() {
    assert_eq!(LineCorrelation::of_window(1e12, 1.0, 100).lags.len(), 100);
}

#[test]
fn frfs_differ_with_independent_noise_and_not_with_a_common_profile() {
    let differ = |noise: &linalg::ComplexMatrix| {
        let size = ((4096 * 4) as f64).sqrt() / noise.norm_l2();
        let rest = linalg::complex_matrix(4096, 4, |k, f| size * noise[(k, f)]);
        LineCorrelation::frfs_have_independent_noise(&Residual::of_all(&rest))
    };
    let independent = decaying(4096, 4, 100.0);
    assert!(differ(&independent));
    let common = windowed_noise(4096, 100.0, 1);
    let amplitude = |f: usize| [1.0, -0.6, 0.3, 1.4][f];
    let similar = linalg::complex_matrix(4096, 4, |k, f| amplitude(f) * common[k]);
    assert!(!differ(&similar));
    // The common noise is four fifths of the power of each FRF.
    let mixed = linalg::complex_matrix(4096, 4, |k, f| independent[(k, f)] + 2.0 * common[k]);
    assert!(!differ(&mixed));
}

#[test]
fn lags_that_are_summed_at_once_have_the_bits_of_those_summed_alone() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let series = [0, 3, 40, 301].map(|lines| -> Vec<Complex64> {
        let value = |_| match random.random_range(0..5) {
            0 => Complex64::ZERO,
            _ => Complex64::cis(random.random_range(0.0..std::f64::consts::TAU)),
        };
        (0..lines).map(value).collect()
    });
    let parts = series.each_ref().map(|phases| PhaseParts::new(phases));
    for first in (1..320).step_by(LAGS_AT_ONCE) {
        for (n, found) in sums_of_lags(&parts, first).into_iter().enumerate() {
            let (mut sum, mut squares) = (Complex64::ZERO, 0.0);
            for phases in &series {
                for (a, b) in phases.iter().zip(phases.iter().skip(first + n)) {
                    sum = sum + a * b.conj();
                    squares += a.norm_sqr() * b.norm_sqr();
                }
            }
            let bits =
                |(sum, squares): (Complex64, f64)| [sum.re, sum.im, squares].map(f64::to_bits);
            assert_eq!(bits(found), bits((sum, squares)), "{}", first + n);
        }
    }
}
