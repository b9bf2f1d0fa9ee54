//! Spectra of conditioned hits: one-sided, unscaled, every channel once, with a plan that all hits share.

use num_complex::Complex64;

use crate::fourier::{ForwardPlan, Scratch};

use super::{ConditionedChannel, ConditionedHit};

/// One-sided unscaled spectra of one hit, `X_k = sum_n x_n exp(-2 pi i k n / N)`.
#[derive(Clone, Debug, PartialEq)]
pub struct HitSpectra {
    /// Force, N.
    pub force: Vec<Complex64>,
    /// Responses in the order of the hit, SI units.
    pub responses: Vec<Vec<Complex64>>,
}

/// Spectra of one hit.
///
/// # Panics
/// When the plan is not for the length of the hit.
pub fn hit_spectra(hit: &ConditionedHit, plan: &ForwardPlan, scratch: &mut Scratch) -> HitSpectra {
    let mut transform = |channel: &ConditionedChannel| {
        let mut lines = vec![Complex64::ZERO; plan.lines()];
        plan.forward(channel.samples.iter().copied(), &mut lines, scratch);
        lines
    };
    HitSpectra {
        force: transform(&hit.force),
        responses: hit.responses.iter().map(&mut transform).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::TimeAxis;
    use crate::signal::Pulse;

    #[test]
    fn an_impulse_at_sample_three_has_a_flat_spectrum_with_its_delay() {
        let channel = |height: f64, place: usize| ConditionedChannel {
            samples: (0..10)
                .map(|n| if n == place { height } else { 0.0 })
                .collect(),
            pre_trigger: None,
        };
        let force = channel(1.0, 0);
        let hit = ConditionedHit {
            force_cut: None,
            axis: TimeAxis {
                start_s: 0.0,
                step_s: 1.0,
                len: 10,
            },
            pulse: Pulse::locate(&force.samples, 0.05).unwrap(),
            force,
            responses: vec![channel(2.0, 3), channel(-4.0, 1)],
            force_weights: vec![1.0; 10],
            response_weights: vec![1.0; 10],
        };
        let plan = ForwardPlan::new(10);
        let spectra = hit_spectra(&hit, &plan, &mut plan.scratch());
        for k in 0..6 {
            let delay = |n: f64| Complex64::cis(-std::f64::consts::TAU * k as f64 * n / 10.0);
            assert!((spectra.force[k] - 1.0).norm() < 1e-14);
            assert!((spectra.responses[0][k] - 2.0 * delay(3.0)).norm() < 1e-14);
            assert!((spectra.responses[1][k] + 4.0 * delay(1.0)).norm() < 1e-14);
        }
    }
}
