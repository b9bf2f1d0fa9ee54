//! Every sample at once against theory: the discrete transform of a record that has wholly decayed
//! is, by Poisson's sum, the continuous spectrum with its aliases. That spectrum is a product of
//! transfer functions, not a sum of exponentials, so that poles, coefficients, the closed forms in
//! time and the block recursion are all on trial.

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::test_systems::{clean_test, free, truth};
use super::{HammerTest, SecondContact};
use crate::dof::Dof;
use crate::fourier::ForwardPlan;
use crate::quantity::{FrfKind, Quantity};

/// Spectrum of a channel as sampled: `rate sum_j X(s + 2 pi i j rate)`, the response being `None`
/// for the force.
fn aliased(test: &HammerTest, response: Option<&Dof>, line: usize) -> Complex64 {
    let pulses = test.pulses(0).unwrap();
    let filter = test.low_pass().unwrap();
    let kind = FrfKind::from_response(test.quantity).unwrap();
    let spectrum = |s: Complex64| {
        let force: Complex64 = pulses.iter().map(|p| p.transform(s)).sum();
        let structure = response.map_or(Complex64::ONE, |r| {
            let hit = &test.hits[0].hit;
            test.truth.transfer(r, hit, kind, s).unwrap()
        });
        force * filter.transfer(s) * structure
    };
    let rate = test.sampling_rate_hz;
    let alias = |j: i32| {
        let hz = rate * (line as f64 / test.samples as f64 + f64::from(j));
        spectrum(Complex64::new(0.0, TAU * hz))
    };
    rate * (-16..=16).map(alias).sum::<Complex64>()
}

/// Largest error over every seventh line relative to the largest line, of the force and of each
/// response.
fn worst_errors(test: &HammerTest) -> Vec<f64> {
    let hit = test.generate_hit(0).unwrap();
    let responses = hit.responses.iter().map(|c| (c, Some(&c.dof)));
    let channels = std::iter::once((&hit.force, None)).chain(responses);
    let worst = channels.map(|(channel, response)| {
        let lines = ForwardPlan::new(test.samples).transform(&channel.si());
        let scale = lines.iter().map(|v| v.norm()).fold(0.0, f64::max);
        let errors = (1..lines.len())
            .step_by(7)
            .map(|k| (lines[k] - aliased(test, response, k)).norm() / scale);
        errors.fold(0.0, f64::max)
    });
    worst.collect()
}

/// Decay within the second of the record by more than e^-45; the last mode is above the sampling
/// rate's half.
const MODES: [(f64, f64, f64); 3] = [(90.0, 0.08, 0.7), (410.0, 0.03, -1.2), (2900.0, 0.01, 0.4)];

#[test]
fn every_kind_of_response_has_the_aliased_spectrum_of_theory() {
    for quantity in [
        Quantity::Displacement,
        Quantity::Velocity,
        Quantity::Acceleration,
    ] {
        let test = HammerTest {
            quantity,
            ..clean_test(truth(&MODES))
        };
        for worst in worst_errors(&test) {
            assert!(worst < 1e-13, "{quantity}: {worst:e}");
        }
    }
}

#[test]
fn a_free_body_behind_an_odd_filter_hit_twice_has_it_too() {
    let mut test = clean_test(free(truth(&MODES)));
    test.filter.order = 9;
    test.faults.second_contact = Some(SecondContact {
        delay_s: 4.3e-3,
        ratio: 0.4,
        hits: [0].into(),
    });
    for worst in worst_errors(&test) {
        assert!(worst < 1e-13, "{worst:e}");
    }
}
