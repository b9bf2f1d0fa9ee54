//! The spider reducer supplies matrices, classes of motion and the results of its paper as a
//! [`TheoreticalModel`].

use crate::geometry::Target;
use crate::theory::parameter::check_values;
use crate::theory::{
    Assumption, ModelQuantity, ParameterSpec, Support, SystemDerivative, SystemMatrices,
    TheoreticalModel, TheoryError,
};

use super::spider_reducer::SpiderReducer;
use super::spider_reducer_results::quantities;

/// Share of the kinetic energy below which a group of bodies counts as stationary: far above
/// rounding.
const MIN_MOVING_ENERGY_SHARE: f64 = 1e-9;

impl TheoreticalModel for SpiderReducer {
    fn name(&self) -> &str {
        "spider reducer HJW-18B"
    }

    fn parameters(&self) -> &[ParameterSpec] {
        &self.parameters
    }

    fn assemble(&self, values: &[f64]) -> Result<SystemMatrices, TheoryError> {
        check_values(self.name(), &self.parameters, values)?;
        Ok(self.machine(&self.values(values, None)).matrices())
    }

    fn derivative(&self, values: &[f64], j: usize) -> Result<SystemDerivative, TheoryError> {
        check_values(self.name(), &self.parameters, values)?;
        Ok(self.machine(&self.values(values, Some(j))).derivative())
    }

    fn observation_row(&self, _values: &[f64], target: &Target) -> Result<Vec<f64>, TheoryError> {
        self.bodies.observation_row(target)
    }

    fn mode_class(&self, _omega_rad_s: f64, shares: &[f64]) -> Option<&'static str> {
        let share = |start: &str| -> f64 {
            let all = self.bodies.coordinates.iter().zip(shares);
            let matching = all.filter(|(coordinate, _)| coordinate.body.starts_with(start));
            matching.map(|(_, share)| share).sum()
        };
        let subsystems = [
            ("output", "compound, output shaft leads"),
            ("input", "compound, input shaft leads"),
            ("shaft-", "compound, spider shafts lead"),
            ("gear-", "compound, spider gears lead"),
        ];
        if share("shaft-") > 1.0 - MIN_MOVING_ENERGY_SHARE {
            return Some("spider shafts alone, gears still");
        }
        let leading = subsystems
            .iter()
            .max_by(|a, b| share(a.0).total_cmp(&share(b.0)));
        leading.map(|(_, class)| *class)
    }

    fn quantities(&self, values: &[f64]) -> Result<Vec<ModelQuantity>, TheoryError> {
        quantities(self, values)
    }

    fn support(&self) -> Option<Support> {
        Some(Support::Fixed)
    }

    fn assumptions(&self) -> Vec<Assumption> {
        let statements = [
            "every mass, moment of inertia and station is assumed: the paper prints none; the spin inertia of the spider shafts and the rear bearing of the output are chosen so that the first and the ninth root are the printed 66.2 and 272.6 Hz",
            "rigid bodies on massless springs, bearings alike along x and y, mean mesh stiffness; no gyroscopic, centrifugal or preload terms, no damping",
            "the rotation of the input shaft is held, as in the paper",
        ];
        Assumption::all(self.name(), statements)
    }
}
