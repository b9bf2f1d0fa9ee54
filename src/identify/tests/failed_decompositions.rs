//! Tests of failed decompositions: the result is an error or correct modes, never a wrong number.

use crate::finding::{Code, Location};
use crate::identify::estimator::IdentifyOptions;
use crate::identify::identify;
use crate::identify::synthetic::{Structure, separated_modes};
use crate::identify::tests::seeds;
use crate::linalg::faults::with_failing;
use crate::modal::{ModalModel, Pole};

/// Maximum error of a pole over its magnitude: 1e-4 by noise at 50 dB, ten times as much for an
/// initial estimate without refinement.
const MAX_POLE_ERROR: f64 = 2e-3;
/// Number of calls that fail, each singly and with all calls after it; a quarter of them without
/// `ALL_DRAWS`.
const FAILED_CALLS: usize = 24;

/// Asserts that every value of every mode is finite and every pole that of a true mode, except for
/// modes that a finding reports as initial estimates.
fn assert_right(structure: &Structure, model: &ModalModel, what: &str) {
    let is_first_estimate = |hz: f64| {
        let is_at = |location: &Location| matches!(location, Location::Mode(at) if (at / hz - 1.0).abs() < 1e-6);
        let mut findings = model.findings.iter();
        findings.any(|finding| finding.code == Code::NotFitted && is_at(&finding.location))
    };
    for mode in model
        .modes
        .iter()
        .filter(|mode| !is_first_estimate(mode.frequency_hz))
    {
        let lambda = mode.pole().unwrap().lambda;
        let distance = |truth: &(f64, f64, Vec<f64>)| {
            let exact = Pole::from_frequency(truth.0, truth.1).lambda;
            (lambda - exact).norm() / exact.norm()
        };
        let nearest = structure
            .modes
            .iter()
            .map(distance)
            .fold(f64::INFINITY, f64::min);
        assert!(
            nearest < MAX_POLE_ERROR,
            "{what}: {} Hz, {nearest:e}",
            mode.frequency_hz
        );
        assert!(
            mode.shape.iter().all(|(_, value)| value.is_finite()),
            "{what}: shape"
        );
    }
}

#[test]
#[ignore = "long: in release by .ci/run"]
fn failed_decomposition_gives_an_error_or_correct_modes() {
    let (structure, mut how) = separated_modes(3);
    how.snr_db = Some(50.0);
    let set = structure.measured(&how);
    // All computation runs on this thread, where the calls are counted.
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .use_current_thread();
    let pool = pool.build().unwrap();
    let stride = FAILED_CALLS / seeds(FAILED_CALLS as u64).count();
    let parts: Vec<usize> = (0..FAILED_CALLS).step_by(stride).collect();
    for method in ["ml", "rfp", "circle"] {
        let options = IdentifyOptions {
            method: method.to_owned(),
            ..IdentifyOptions::default()
        };
        let run = || pool.install(|| identify(&set, &options));
        let (right, calls) = with_failing(0..0, run);
        let right = right.unwrap();
        assert_eq!(right.modes.len(), structure.modes.len());
        assert_right(&structure, &right, method);
        assert!(calls >= FAILED_CALLS, "{method}: {calls} decompositions");
        let mut changed = 0;
        for part in &parts {
            let first = calls * part / FAILED_CALLS;
            // One call, and all from there on.
            for end in [first + 1, usize::MAX] {
                let (result, _) = with_failing(first..end, run);
                changed += usize::from(result.as_ref().ok() != Some(&right));
                if let Ok(model) = result {
                    assert_right(&structure, &model, &format!("{method}, {first}..{end}"));
                }
            }
        }
        assert!(
            changed >= parts.len() / 2,
            "{method}: {changed} runs saw the failure"
        );
    }
}
