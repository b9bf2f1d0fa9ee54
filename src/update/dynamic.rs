//! Modal dynamic residuals: what a measured mode leaves of the equations of motion.
//!
//! A measured shape `psi` at the sensors `B` and its `lambda = (2 pi f)^2` belong to some motion `u` of all coordinates. The
//! residual is what the best `u` leaves of
//!
//! ```text
//! [ W (K - lambda M) ]       [ 0   ]
//! [ S^-1 B           ] u  -  [ S^-1 psi ]
//! ```
//!
//! with the deviations `S` of the shape: the force that no motion near the measured shape does without, and the part of the
//! shape that no motion without force explains. `W = Phi0^T/(2 lambda sigma s)` with the modes `Phi0` of the model at the start
//! (the norm of `M0^-1`), the relative deviation `sigma` of the frequency, and the length `s` of `u` there, the root of the sum
//! of squares over the shapes of a repeated root, whose one frequency counts once; a root of the model that is off by `e`
//! leaves `e/sigma` in all. No mode of the model is asked for: repeated and crossing roots are no
//! matter, and nothing is expanded beforehand.
//!
//! # Reference
//! Friswell and Mottershead (1995), Finite Element Model Updating in Structural Dynamics, section 5.1 (equation error);
//! Ladevèze, Nedjar and Reynier (1994), AIAA Journal 32, 1485 (shape and force weighed together); Golub and Pereyra (1973),
//! SIAM J. Numer. Anal. 10, 413, equation 4.7 (derivative of a projection).

use crate::linalg::{RealMatrix, real_matrix};
use crate::theory::{SystemDerivative, SystemMatrices, TheoryModes};

use super::residual::{Projection, dot};
use super::target::TargetShapes;

/// What is fixed of a target.
#[derive(Clone, Debug)]
pub(super) struct DynamicTarget {
    lambda: f64,
    /// `W`.
    weight: RealMatrix,
}

impl DynamicTarget {
    /// Of a target whose shapes the modes `own` of the model are nearest to; `None` where these say nothing of its length.
    pub fn new(
        (hz, relative_std): (f64, f64),
        shapes: &TargetShapes,
        modes: &TheoryModes,
        own: &[usize],
    ) -> Option<Self> {
        let projection = Projection::of_modes(shapes, modes, own);
        let length = |v: &Vec<f64>| {
            let c = projection.coefficients(v);
            dot(&c, &c)
        };
        let lengths = shapes.vectors.iter().map(length).sum::<f64>();
        let lambda = (std::f64::consts::TAU * hz).powi(2);
        let factor = 1.0 / (2.0 * lambda * relative_std * lengths.sqrt());
        let n = modes.vectors.nrows();
        factor.is_finite().then(|| Self {
            lambda,
            weight: real_matrix(n, n, |i, j| factor * modes.vectors[(j, i)]),
        })
    }

    fn columns(&self, shapes: &TargetShapes, matrices: &SystemMatrices) -> Projection {
        let n = self.weight.nrows();
        let force = real_matrix(n, n, |i, j| {
            matrices.stiffness[(i, j)] - self.lambda * matrices.mass[(i, j)]
        });
        let force = &self.weight * &force;
        let d = shapes.rows.nrows();
        let column = |j: usize| {
            let top = (0..n).map(|i| force[(i, j)]);
            top.chain((0..d).map(|i| shapes.rows[(i, j)])).collect()
        };
        Projection::of_columns((0..n).map(column))
    }

    /// Zeros for the force, and the shape.
    fn measured(&self, vector: &[f64]) -> Vec<f64> {
        let zeros = vec![0.0; self.weight.nrows()];
        zeros.into_iter().chain(vector.iter().copied()).collect()
    }

    /// The residuals.
    pub fn values(&self, shapes: &TargetShapes, matrices: &SystemMatrices) -> Vec<f64> {
        let columns = self.columns(shapes, matrices);
        let vectors = shapes.vectors.iter();
        let rests = vectors.map(|v| columns.rest(&self.measured(v)));
        rests.flatten().collect()
    }

    /// Their derivatives by parameters, one column for each.
    pub fn derivatives(
        &self,
        shapes: &TargetShapes,
        matrices: &SystemMatrices,
        by: &[SystemDerivative],
    ) -> Vec<Vec<f64>> {
        let columns = self.columns(shapes, matrices);
        let (n, d) = (self.weight.nrows(), shapes.rows.nrows());
        let of = |by: &SystemDerivative| {
            let force = real_matrix(n, n, |i, j| {
                by.stiffness[(i, j)] - self.lambda * by.mass[(i, j)]
            });
            let force = &self.weight * &force;
            let change = real_matrix(n + d, n, |i, j| if i < n { force[(i, j)] } else { 0.0 });
            let vectors = shapes.vectors.iter();
            let own = vectors.flat_map(|v| columns.derivative(&self.measured(v), &change));
            own.collect()
        };
        by.iter().map(of).collect()
    }
}
