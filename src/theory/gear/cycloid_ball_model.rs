//! The cycloid ball transmission supplies matrices, classes of motion and the quantities of its
//! paper as a [`TheoreticalModel`].

use crate::geometry::Target;
use crate::theory::parameter::{check_derivable, check_values};
use crate::theory::{
    Assumption, Coordinate, ModelQuantity, Motion, ParameterSpec, Support, SystemDerivative,
    SystemMatrices, TheoreticalModel, TheoryError,
};

use super::cycloid_ball::{BALLS, CycloidBall, PIN_BALLS};
use super::cycloid_studies::study_quantities;

/// Share of the kinetic energy below which a group of coordinates counts as stationary: far above
/// rounding.
const MIN_MOVING_ENERGY_SHARE: f64 = 1e-12;
/// A share above which one body has the motion for itself.
const ALONE: f64 = 0.99;

impl TheoreticalModel for CycloidBall {
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
        check_derivable(&self.parameters[j])?;
        Ok(self.machine(&self.values(values, Some(j))).derivative())
    }

    fn observation_row(&self, values: &[f64], target: &Target) -> Result<Vec<f64>, TheoryError> {
        check_values(&self.name, &self.parameters, values)?;
        let balls = self.values(values, None).get(BALLS).value;
        self.bodies(balls).observation_row(target)
    }

    fn mode_class(&self, omega_rad_s: f64, shares: &[f64]) -> Option<&'static str> {
        // Eleven coordinates of the discs, one of each pin ball, two of each reduction ball.
        let balls = shares.len().saturating_sub(11 + PIN_BALLS) / 2;
        let coordinates = self.bodies(balls as f64).coordinates;
        let share = |of: &dyn Fn(&Coordinate) -> bool| -> f64 {
            let all = coordinates.iter().zip(shares);
            all.filter(|(coordinate, _)| of(coordinate))
                .map(|(_, share)| share)
                .sum()
        };
        let on = |body: &'static str| move |c: &Coordinate| c.body.starts_with(body);
        let along = |name: &'static str| move |c: &Coordinate| c.name == name;
        if omega_rad_s <= 0.0 {
            return Some("free motion");
        }
        if share(&on("ball-")) > 1.0 - MIN_MOVING_ENERGY_SHARE {
            return Some("output still: reduction balls");
        }
        if share(&on("pin-ball-")) > 1.0 - MIN_MOVING_ENERGY_SHARE {
            return Some("output still: pin balls");
        }
        if share(&along("u1")) > ALONE {
            return Some("x and torsion, output nearly still: centre disc turns");
        }
        let turning = share(&|c: &Coordinate| c.motion == Motion::Rotation);
        Some(
            match (
                share(&along("y5")) > MIN_MOVING_ENERGY_SHARE,
                turning > MIN_MOVING_ENERGY_SHARE,
            ) {
                (true, false) => "translation in y, nothing turns",
                (false, true) => "x and torsion, output turns",
                _ => "coupled",
            },
        )
    }

    fn small_bodies(&self) -> &'static [&'static str] {
        &["ball", "pin-ball"]
    }

    fn quantities(&self, values: &[f64]) -> Result<Vec<ModelQuantity>, TheoryError> {
        study_quantities(self, values)
    }

    fn support(&self) -> Option<Support> {
        Some(Support::Fixed)
    }

    fn assumptions(&self) -> Vec<Assumption> {
        let statements = [
            "plane motion, rigid bodies on massless springs, no gyroscopic terms, no damping",
            "geometry inferred from the pitch point, ball circle of radius Z2 e/K; the paper does not print it",
            "the contact force's arm on the centre disc is that of the planet disc, as in the paper ((Z2 - 1) e would be right)",
        ];
        Assumption::all(&self.name, statements)
    }
}
