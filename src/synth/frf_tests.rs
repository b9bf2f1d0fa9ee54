//! End to end: H1 = X/F of one clean hit against the true FRF, over the lines a test would use
//! (force within 20 dB of its maximum, up to 0.4 of the sampling rate, not 0 Hz).
//!
//! The remaining error is that of truncation. The part of a mode after the record's end is
//! `e^((lambda - i w) T)` of its term `lambda^2 A/(i w - lambda)`, so that the error is e^-n of the
//! sum of these magnitudes, n the slowest mode's time constants in the record. Against the terms as
//! they stand in an accelerance, `(i w)^2 A/(i w - lambda)`, the same error is `(f_r/f)^2` larger:
//! below its lowest mode a held structure hardly accelerates, and a truncated record says little
//! there.

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::HammerTest;
use super::test_systems::{clean_test, free, truth};
use crate::fourier::ForwardPlan;
use crate::quantity::FrfKind;
use crate::record::Channel;

/// One line of one response.
struct Line {
    hz: f64,
    error: f64,
    /// Sum of `|lambda^2 A/(s - lambda)|` over the poles, plus |D|.
    residue_envelope: f64,
    /// Sum of `|s^2 A/(s - lambda)|` over the poles, plus |D|.
    accelerance_envelope: f64,
    value: f64,
}

fn line(test: &HammerTest, response: &Channel, hz: f64, h1: Complex64) -> Line {
    let s = Complex64::new(0.0, TAU * hz);
    let pair = test.truth.pair(&response.dof, &test.hits[0].hit).unwrap();
    let exact = pair.transfer(s, FrfKind::Accelerance);
    let envelope = |factor: fn(Complex64, Complex64) -> Complex64| {
        let both = |(pole, residue): &(Complex64, Complex64)| {
            (residue / (s - pole)).norm() + (residue.conj() / (s - pole.conj())).norm()
        };
        let terms = pair
            .modes
            .iter()
            .map(|m| both(m) * factor(s, m.0).norm_sqr());
        terms.sum::<f64>() + pair.rigid_per_kg.abs()
    };
    Line {
        hz,
        error: (h1 - exact).norm(),
        residue_envelope: envelope(|_, pole| pole),
        accelerance_envelope: envelope(|s, _| s),
        value: exact.norm(),
    }
}

/// The lines of each response of the first hit.
fn h1_lines(test: &HammerTest) -> Vec<Vec<Line>> {
    let hit = test.generate_hit(0).unwrap();
    let plan = ForwardPlan::new(test.samples);
    let axis = hit.axis.spectrum_axis();
    let force = plan.transform(&hit.force.si());
    let largest = force.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let usable: Vec<usize> = (1..axis.len)
        .filter(|k| axis.hz(*k) <= 0.4 * test.sampling_rate_hz && force[*k].norm() >= 0.1 * largest)
        .collect();
    let responses = hit.responses.iter().map(|response| {
        let spectrum = plan.transform(&response.si());
        let lines = usable.iter();
        lines
            .map(|k| line(test, response, axis.hz(*k), spectrum[*k] / force[*k]))
            .collect()
    });
    responses.collect()
}

/// Largest ratio over lines and responses.
fn worst(lines: &[Vec<Line>], ratio: impl Fn(&Line) -> f64) -> f64 {
    lines.iter().flatten().map(ratio).fold(0.0, f64::max)
}

/// Largest error over the largest value of the same response.
fn worst_of_peak(lines: &[Vec<Line>]) -> f64 {
    let of_peak = |response: &Vec<Line>| {
        let peak = response.iter().map(|l| l.value).fold(0.0, f64::max);
        response.iter().map(|l| l.error / peak).fold(0.0, f64::max)
    };
    lines.iter().map(of_peak).fold(0.0, f64::max)
}

const LOWEST_HZ: f64 = 100.0;
const CONTACTS_S: [f64; 2] = [3e-4, 1e-3];

/// Three modes of which the lowest, the slowest too, passes `n` time constants after the hit;
/// `above` adds one beyond the filter.
fn ringing(n: f64, above_hz: Option<f64>) -> HammerTest {
    let zeta = |hz: f64, n: f64| n / (TAU * hz * 0.99);
    let mut modes = vec![
        (LOWEST_HZ, zeta(LOWEST_HZ, n), 0.8),
        (310.0, zeta(310.0, 1.5 * n), -1.1),
        (760.0, zeta(760.0, 2.5 * n), 0.6),
    ];
    modes.extend(above_hz.map(|hz| (hz, 0.005, 0.9)));
    clean_test(truth(&modes))
}

/// The test with each contact time and several positions of the pulse between two samples.
fn variants(test: &HammerTest) -> Vec<HammerTest> {
    let mut all = Vec::new();
    for duration_s in CONTACTS_S {
        for seed in 0..4 {
            let mut variant = HammerTest {
                seed,
                ..test.clone()
            };
            variant.pulse.duration_s = duration_s;
            all.push(variant);
        }
    }
    all
}

#[test]
fn h1_of_a_held_structure_is_true_to_the_truncation() {
    for (n, bound) in [(6.0, 3e-3), (9.5, 1e-4)] {
        let truncation = f64::exp(-n);
        for test in variants(&ringing(n, None)) {
            let lines = h1_lines(&test);
            let got = worst(&lines, |l| l.error / l.residue_envelope);
            assert!(
                got < bound && got > 0.8 * truncation,
                "{n}: {got:e} {:?}",
                test.pulse
            );
            assert!(worst_of_peak(&lines) < truncation, "{n}");
            // Terms as they stand in an accelerance: (f_r/f)^2 more below the lowest mode.
            let scaled = worst(&lines, |l| {
                l.error / l.accelerance_envelope * (l.hz / LOWEST_HZ).powi(2).min(1.0)
            });
            assert!(scaled < 1.5 * truncation, "{n}: {scaled:e}");
        }
    }
}

#[test]
fn h1_of_a_free_structure_with_a_mode_above_the_filter_is_true_too() {
    for (n, bound) in [(6.0, 3e-3), (9.5, 1e-4)] {
        for above_hz in [2500.0, 2870.0] {
            let held = ringing(n, Some(above_hz));
            for test in variants(&HammerTest {
                truth: free(held.truth.clone()),
                ..held
            }) {
                let lines = h1_lines(&test);
                let got = worst(&lines, |l| l.error / l.residue_envelope);
                assert!(got < bound, "{n} {above_hz}: {got:e}");
                // A free body accelerates down to 0 Hz, so the plain envelope serves at every line.
                let got = worst(&lines, |l| l.error / l.accelerance_envelope);
                assert!(got < 1.6 * f64::exp(-n), "{n} {above_hz}: {got:e}");
            }
        }
    }
}

/// With 14 and with 20 time constants the error falls on as e^-n; only aliasing through a filter of
/// low order holds it up.
#[test]
fn beyond_the_truncation_only_the_filter_order_limits() {
    for n in [14.0, 20.0] {
        let mut test = ringing(n, None);
        test.pulse.duration_s = CONTACTS_S[0];
        let mut error = |order| {
            test.filter.order = order;
            worst(&h1_lines(&test), |l| l.error / l.residue_envelope) / f64::exp(-n)
        };
        let steep = error(24);
        assert!(steep > 0.8 && steep < 1.2, "{n}: {steep}");
        assert!(error(8) > 100.0);
    }
}
