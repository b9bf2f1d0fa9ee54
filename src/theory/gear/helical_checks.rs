//! Numerical checks of the motion of the helical planetary gear: energy drift without losses, and
//! difference between two independent integrators.

use crate::theory::integrate::{ExtrapolatedMidpoint, Integrator, RungeKutta4};
use crate::theory::{ModelQuantity, TheoryError};

use super::HelicalPlanetary;
use super::helical_mesh::Detail;
use super::helical_motion::{COORDINATES, Motion};

/// Steps per mesh period of the coarse run without losses; the fine one has twice as many.
const COARSE: usize = 2000;
/// Mesh periods, and steps in each, over which the integrators are compared.
const PERIODS: usize = 10;
const RUNGE_KUTTA_STEPS: usize = 8000;
const MIDPOINT_STEPS: usize = 400;
/// Displacements off the equilibrium at the start, m, and the radius that makes rotations of them.
const SHAKEN_M: f64 = 2e-5;
const RADIUS_M: f64 = 0.05;

/// Integrates over whole mesh periods from 0.
pub(super) fn run(
    integrator: &mut dyn Integrator,
    motion: &Motion,
    periods: usize,
    steps: usize,
    state: &mut [f64],
) {
    let step_s = motion.mesh_period_s() / steps as f64;
    for step in 0..periods * steps {
        integrator.step(motion, step as f64 * step_s, step_s, state);
    }
}

/// The equilibrium with every coordinate displaced by up to 20 micrometres, by a fixed rule.
pub(super) fn shaken(motion: &Motion) -> Vec<f64> {
    let mut state = motion.equilibrium();
    for (i, value) in state.iter_mut().take(COORDINATES).enumerate() {
        let length = SHAKEN_M * (1.0 + 7.0 * i as f64).sin();
        *value += if i % 3 == 2 {
            length / RADIUS_M
        } else {
            length
        };
    }
    state
}

/// Change of the energy of a motion without losses over mesh periods, as a part of the strain
/// energy at the start.
pub(super) fn energy_drift(
    integrator: &mut dyn Integrator,
    motion: &Motion,
    periods: usize,
    steps: usize,
) -> f64 {
    let mut state = shaken(motion);
    let [kinetic, strain] = motion.energy(0.0, &state);
    run(integrator, motion, periods, steps, &mut state);
    let end_s = periods as f64 * motion.mesh_period_s();
    let [after, held] = motion.energy(end_s, &state);
    ((after - kinetic) + (held - strain)).abs() / strain
}

/// Both, with the exact angle.
pub(super) fn check_quantities(
    model: &HelicalPlanetary,
    values: &[f64],
) -> Result<Vec<ModelQuantity>, TheoryError> {
    let motion = Motion::new(model, values, Detail::ExactAngle)?;
    let free = motion.clone().conservative();
    let drift = |steps| energy_drift(&mut RungeKutta4::default(), &free, 1, steps);
    let order = (drift(COARSE) / drift(2 * COARSE)).log2();
    let end_s = PERIODS as f64 * motion.mesh_period_s();
    let deflection = |integrator: &mut dyn Integrator, steps| {
        let mut state = motion.equilibrium();
        run(integrator, &motion, PERIODS, steps, &mut state);
        motion.meshes(end_s, &state, 0)[0].compression_m
    };
    let one = deflection(&mut RungeKutta4::default(), RUNGE_KUTTA_STEPS);
    let other = deflection(&mut ExtrapolatedMidpoint::default(), MIDPOINT_STEPS);
    Ok(vec![
        ModelQuantity::new(
            "energy_drift_order",
            order,
            "",
            "order with which the energy of the motion without losses and with constant mesh stiffness drifts over the step of the Runge-Kutta method of order 4, exact angle",
        ),
        ModelQuantity::new(
            "integrators_apart",
            (one / other - 1.0).abs(),
            "",
            "distance of the sun mesh's deflection after 10 periods by the Runge-Kutta method and by an extrapolated midpoint rule of order 16, exact angle",
        ),
    ])
}
