//! A decomposition that fails its check gives an error, or modes that are as right as without it; never a wrong number.

use super::synthetic::{Structure, separated_modes};
use super::{IdentifyOptions, identify};
use crate::linalg::faults::with_failing;
use crate::modal::{ModalModel, Pole};

/// Largest error of a pole over its magnitude: noise at 50 dB leaves 1e-4.
const POLE_ERROR: f64 = 2e-3;
/// Calls of which each fails once.
const FAILING: usize = 24;

/// Every number of every mode is one, and every pole that of a true mode.
fn assert_right(structure: &Structure, model: &ModalModel, what: &str) {
    for mode in &model.modes {
        let lambda = mode.pole().unwrap().lambda;
        let distance = |own: &(f64, f64, Vec<f64>)| {
            let exact = Pole::from_frequency(own.0, own.1).lambda;
            (lambda - exact).norm() / exact.norm()
        };
        let nearest = structure
            .modes
            .iter()
            .map(distance)
            .fold(f64::INFINITY, f64::min);
        assert!(
            nearest < POLE_ERROR,
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
fn a_failed_decomposition_gives_an_error_or_right_modes() {
    let (structure, mut how) = separated_modes(3);
    how.snr_db = Some(50.0);
    let set = structure.measured(&how);
    // Everything on this thread, where the calls are counted.
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .use_current_thread();
    let pool = pool.build().unwrap();
    for method in ["ml", "rfp", "circle"] {
        let options = IdentifyOptions {
            method: method.to_owned(),
            ..IdentifyOptions::default()
        };
        let run = || pool.install(|| identify(&set, &options));
        let (right, calls) = with_failing(0..0, run);
        let right = right.unwrap();
        assert_right(&structure, &right, method);
        for part in 0..FAILING {
            let first = calls * part / FAILING;
            for end in [first + 1, calls] {
                let (result, _) = with_failing(first..end, run);
                if let Ok(model) = result {
                    assert_right(&structure, &model, &format!("{method}, {first}..{end}"));
                }
            }
        }
    }
}
