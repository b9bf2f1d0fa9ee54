//! The torsional planetary gear supplies matrices, classes of motion and the results of its paper
//! as a [`TheoreticalModel`].

use crate::geometry::Target;
use crate::theory::parameter::check_values;
use crate::theory::{
    Assumption, ModelQuantity, ParameterSpec, Support, SystemDerivative, SystemMatrices,
    TheoreticalModel, TheoryError,
};

use super::torsional_planetary::TorsionalPlanetary;
use super::torsional_results::quantities;

/// Share of the kinetic energy below which a body counts as stationary: far above rounding.
const MIN_MOVING_ENERGY_SHARE: f64 = 1e-12;

impl TheoreticalModel for TorsionalPlanetary {
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

    /// A coordinate; a point of a body has no reading, since the radii are not known.
    fn observation_row(&self, _values: &[f64], target: &Target) -> Result<Vec<f64>, TheoryError> {
        self.bodies.observation_row(target)
    }

    fn mode_class(&self, omega_rad_s: f64, shares: &[f64]) -> Option<&'static str> {
        if omega_rad_s <= 0.0 {
            return Some("free motion");
        }
        let all = self.bodies.coordinates.iter().zip(shares);
        let planets = all.filter(|(coordinate, _)| coordinate.body.starts_with("planet-"));
        let planets: f64 = planets.map(|(_, share)| share).sum();
        Some(if planets > 1.0 - MIN_MOVING_ENERGY_SHARE {
            "planet mode: carrier, ring and sun still"
        } else {
            "rotational mode: planets alike"
        })
    }

    fn quantities(&self, values: &[f64]) -> Result<Vec<ModelQuantity>, TheoryError> {
        quantities(self, values)
    }

    fn support(&self) -> Option<Support> {
        Some(Support::Fixed)
    }

    fn assumptions(&self) -> Vec<Assumption> {
        let statements = [
            "torsion alone: no body is displaced; rigid bodies on massless springs, no gyroscopic terms, no damping",
            "the three printed rotational frequencies of table 2 need a carrier of 7.54 kg with the support of 1e9 N/m on it, and 4 planets; the printed 4.90 kg without the planets it carries (4 times 0.66 kg, not printed) misses by up to 18 %",
        ];
        Assumption::all(&self.name, statements)
    }
}
