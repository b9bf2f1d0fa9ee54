//! The helical planetary gear supplies matrices, classes of motion and the results of its paper as
//! a [`TheoreticalModel`].

use crate::geometry::Target;
use crate::theory::parameter::check_values;
use crate::theory::{
    Assumption, ModelQuantity, Motion, Nonlinear, ParameterSpec, Support, SystemDerivative,
    SystemMatrices, TheoreticalModel, TheoryError,
};

use super::helical_planetary::HelicalPlanetary;
use super::helical_response::response_quantities;

/// Share of the kinetic energy below which a body counts as stationary: far above the rounding of
/// repeated roots.
const MIN_MOVING_ENERGY_SHARE: f64 = 1e-9;

impl TheoreticalModel for HelicalPlanetary {
    fn name(&self) -> &str {
        &self.name
    }

    fn parameters(&self) -> &[ParameterSpec] {
        &self.parameters
    }

    fn assemble(&self, values: &[f64]) -> Result<SystemMatrices, TheoryError> {
        check_values(&self.name, &self.parameters, values)?;
        Ok(self.machine(&self.values(values, None)).matrices())
    }

    fn derivative(&self, values: &[f64], j: usize) -> Result<SystemDerivative, TheoryError> {
        check_values(&self.name, &self.parameters, values)?;
        Ok(self.machine(&self.values(values, Some(j))).derivative())
    }

    fn observation_row(&self, _values: &[f64], target: &Target) -> Result<Vec<f64>, TheoryError> {
        self.bodies.observation_row(target)
    }

    fn mode_class(&self, omega_rad_s: f64, shares: &[f64]) -> Option<&'static str> {
        if omega_rad_s <= 0.0 {
            return Some("free motion");
        }
        let all = || self.bodies.coordinates.iter().zip(shares);
        let central = |motion: Motion| -> f64 {
            all()
                .filter(|(coordinate, _)| {
                    coordinate.motion == motion && !coordinate.body.starts_with("planet-")
                })
                .map(|(_, share)| share)
                .sum()
        };
        let (moves, turns) = (central(Motion::Translation), central(Motion::Rotation));
        Some(
            match (
                moves > MIN_MOVING_ENERGY_SHARE,
                turns > MIN_MOVING_ENERGY_SHARE,
            ) {
                (false, false) => "planet mode: carrier and sun still",
                (true, false) => "translational mode: carrier and sun do not turn",
                (false, true) => "rotational mode: carrier and sun turn in place",
                (true, true) => "coupled",
            },
        )
    }

    fn quantities(&self, values: &[f64]) -> Result<Vec<ModelQuantity>, TheoryError> {
        response_quantities(self, values)
    }

    fn nonlinear(&self) -> Option<&dyn Nonlinear> {
        Some(self)
    }

    fn support(&self) -> Option<Support> {
        Some(Support::Fixed)
    }

    fn assumptions(&self) -> Vec<Assumption> {
        let statements = [
            "plane motion of rigid bodies: no axial or tilting motion of the helical gears, no backlash",
            "natural frequencies at rest, with both mesh stiffnesses at the middle of the printed range",
            "ring of 83 teeth for the printed 82, which neither is coaxial nor lets four planets be assembled; input torque 40/4.952 N m for the printed 9.65, which would accelerate the carrier by 71 rad/s2",
            "face width, bores, the carrier's disc, the wave of the mesh stiffness and the damping are not printed",
        ];
        Assumption::all(&self.name, statements)
    }
}
