//! Structures and plans that the tests of this stage share.

use num_complex::Complex64;

use crate::dof::Dof;
use crate::modal::{ModalModel, Mode, ModeShape, Pole, Scaling};
use crate::quantity::Quantity;

use super::{Faults, HammerTest, LowPassOptions, Noise, Pulse, Truth, roving_hammer};

pub fn dof(text: &str) -> Dof {
    text.parse().unwrap()
}

/// Modes of 1 kg modal mass each, driven at `1:+Z` and seen at `1:+Z` and `2:+Z`, with the sign of
/// their shape at the latter.
pub fn truth(modes: &[(f64, f64, f64)]) -> Truth {
    let mode = |&(hz, zeta, far): &(f64, f64, f64)| {
        let shape = ModeShape::new([(dof("1:+Z"), 1.0.into()), (dof("2:+Z"), far.into())]);
        let omega_d = Pole::from_frequency(hz, zeta).lambda.im;
        let mut mode = Mode::new(hz, Some(zeta), shape, Scaling::UnitModalMass);
        for (response, product) in [("1:+Z", 1.0), ("2:+Z", far)] {
            let residue = Complex64::new(0.0, -product / (2.0 * omega_d));
            mode.residues.insert((dof(response), dof("1:+Z")), residue);
        }
        mode
    };
    Truth {
        model: ModalModel {
            modes: modes.iter().map(mode).collect(),
            ..ModalModel::default()
        },
        ..Truth::default()
    }
}

/// One clean hit at `1:+Z` with two responses, 4096 samples at 4096 Hz.
pub fn clean_test(truth: Truth) -> HammerTest {
    HammerTest {
        truth,
        hits: roving_hammer(&[dof("1:+Z")], &[dof("1:+Z"), dof("2:+Z")]),
        averages_per_point: 1,
        sampling_rate_hz: 4096.0,
        samples: 4096,
        pretrigger_s: 0.01,
        quantity: Quantity::Acceleration,
        pulse: Pulse {
            peak_n: 200.0,
            peak_spread: 0.2,
            duration_s: 1e-3,
            duration_spread: 0.1,
        },
        filter: LowPassOptions::default(),
        noise: Noise::default(),
        faults: Faults::default(),
        seed: 7,
    }
}

/// The same structure without a support.
pub fn free(truth: Truth) -> Truth {
    let rigid = [("1:+Z", 0.5), ("2:+Z", -0.3)];
    Truth {
        rigid_accelerance: rigid.map(|(r, d)| ((dof(r), dof("1:+Z")), d)).into(),
        ..truth
    }
}
