//! Modal dynamic residuals are the unbalanced forces of a measured mode in the equations of motion.
//!
//! A measured shape `psi` at the sensors `B` and its `lambda = (2 pi f)^2` belong to some motion
//! `u` of all coordinates. The residual is what the best `u` leaves of
//!
//! ```text
//! [ W (K - lambda M) ]       [ 0   ]
//! [ S^-1 B           ] u  -  [ S^-1 psi ]
//! ```
//!
//! with the deviations `S` of the shape: the force that no motion near the measured shape does
//! without, and the part of the shape that no motion without force explains. `W = Phi0^T/(2 lambda
//! sigma s)` with the modes `Phi0` of the model at the start (the norm of `M0^-1`), the relative
//! deviation `sigma` of the frequency, and the length `s` of `u` there, the root of the sum of
//! squares over the shapes of a repeated root, whose one frequency counts once; a root of the model
//! that is off by `e` leaves `e/sigma` in all. Motions without mass follow the others by statics,
//! `u = T u_a` ([`Condensation`]): a force on them is infinitely large in the norm of `M0^-1`. No
//! mode of the model is computed: repeated and crossing roots need no treatment, and no shape is
//! expanded beforehand.
//!
//! # Reference
//! Friswell and Mottershead (1995), Finite Element Model Updating in Structural Dynamics, section
//! 5.1 (equation error); Ladevèze, Nedjar and Reynier (1994), AIAA Journal 32, 1485 (shape and
//! force weighed together); Golub and Pereyra (1973), SIAM J. Numer. Anal. 10, 413, equation 4.7
//! (derivative of a projection).

use crate::linalg::{RealMatrix, real_matrix};
use crate::theory::{Condensation, SystemDerivative, SystemMatrices, TheoryModes};

use super::UpdateError;
use super::projection::{Projection, dot};
use super::target_shapes::TargetShapes;

/// Constant data of a target.
#[derive(Clone, Debug)]
pub(super) struct DynamicTarget {
    lambda: f64,
    /// `W`.
    weight: RealMatrix,
}

impl DynamicTarget {
    /// From frequency and shapes of a target, and the modes `nearest` of the model that are nearest
    /// to them; `None` where these modes give the motion no length.
    pub fn new(
        hz: f64,
        relative_std: f64,
        shapes: &TargetShapes,
        modes: &TheoryModes,
        nearest: &[usize],
    ) -> Option<Self> {
        let projection = Projection::of_modes(shapes, modes, nearest);
        let length = |v: &Vec<f64>| {
            let c = projection.coefficients(v);
            dot(&c, &c)
        };
        let lengths = shapes.vectors.iter().map(length).sum::<f64>();
        let lambda = (std::f64::consts::TAU * hz).powi(2);
        let factor = 1.0 / (2.0 * lambda * relative_std * lengths.sqrt());
        let (n, m) = (modes.vectors.nrows(), modes.vectors.ncols());
        factor.is_finite().then(|| Self {
            lambda,
            weight: real_matrix(m, n, |i, j| factor * modes.vectors[(j, i)]),
        })
    }

    /// Number of residuals.
    pub fn len(&self, shapes: &TargetShapes) -> usize {
        shapes.vectors.len() * (self.weight.nrows() + shapes.rows.nrows())
    }

    /// `W (K - lambda M)`.
    fn forces(&self, stiffness: &RealMatrix, mass: &RealMatrix) -> RealMatrix {
        let n = self.weight.ncols();
        let force = real_matrix(n, n, |i, j| stiffness[(i, j)] - self.lambda * mass[(i, j)]);
        &self.weight * &force
    }

    /// Forces over readings, of all coordinates.
    fn equations(&self, shapes: &TargetShapes, matrices: &SystemMatrices) -> RealMatrix {
        let force = self.forces(&matrices.stiffness, &matrices.mass);
        let (m, n, d) = (force.nrows(), force.ncols(), shapes.rows.nrows());
        real_matrix(m + d, n, |i, j| {
            if i < m {
                force[(i, j)]
            } else {
                shapes.rows[(i - m, j)]
            }
        })
    }

    /// Zeros for the force, and the shape.
    fn measured(&self, vector: &[f64]) -> Vec<f64> {
        let zeros = vec![0.0; self.weight.nrows()];
        zeros.into_iter().chain(vector.iter().copied()).collect()
    }

    /// The residuals.
    ///
    /// # Errors
    /// [`UpdateError::Theory`] where motions without mass cannot be condensed.
    pub fn values(
        &self,
        shapes: &TargetShapes,
        matrices: &SystemMatrices,
        condensation: Option<&Condensation>,
    ) -> Result<Vec<f64>, UpdateError> {
        let mut equations = self.equations(shapes, matrices);
        if let Some(reduction) = condensation {
            equations = equations * reduction.expansion(&matrices.stiffness)?;
        }
        let columns = projection(&equations);
        let vectors = shapes.vectors.iter();
        let residuals = vectors.map(|v| columns.residual(&self.measured(v)));
        Ok(residuals.flatten().collect())
    }

    /// Their derivatives by parameters, one column for each: with `dT = -G dK T` of motions without
    /// mass.
    ///
    /// # Errors
    /// As [`DynamicTarget::values`].
    pub fn derivatives(
        &self,
        shapes: &TargetShapes,
        matrices: &SystemMatrices,
        condensation: Option<&Condensation>,
        by: &[SystemDerivative],
    ) -> Result<Vec<Vec<f64>>, UpdateError> {
        let whole = self.equations(shapes, matrices);
        let expansion = condensation.map(|reduction| reduction.expansion(&matrices.stiffness));
        let expansion = expansion.transpose()?;
        let columns = match &expansion {
            Some(basis) => projection(&(&whole * basis)),
            None => projection(&whole),
        };
        let of = |by: &SystemDerivative| {
            let force = self.forces(&by.stiffness, &by.mass);
            let mut change = real_matrix(whole.nrows(), whole.ncols(), |i, j| {
                if i < force.nrows() {
                    force[(i, j)]
                } else {
                    0.0
                }
            });
            if let Some((reduction, t)) = condensation.zip(expansion.as_ref()) {
                change = change * t - &whole * reduction.relax(&(&by.stiffness * t))?;
            }
            let vectors = shapes.vectors.iter();
            let slopes = vectors.flat_map(|v| columns.derivative(&self.measured(v), &change));
            Ok(slopes.collect())
        };
        by.iter().map(of).collect()
    }
}

fn projection(columns: &RealMatrix) -> Projection {
    let column = |j: usize| columns.col(j).iter().copied().collect();
    Projection::of_columns((0..columns.ncols()).map(column))
}
