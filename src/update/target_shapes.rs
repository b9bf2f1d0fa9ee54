//! The shapes of a target hold its measured vectors, and the rows that observe the model at the
//! same degrees of freedom.

use crate::linalg::{RealMatrix, real_matrix};

/// Shapes of a target at the degrees of freedom that test and model share, everything divided by
/// the deviations.
#[derive(Clone, Debug)]
pub(super) struct TargetShapes {
    /// One row for each degree of freedom, one column for each coordinate of the model.
    pub rows: RealMatrix,
    /// One vector for each mode.
    pub vectors: Vec<Vec<f64>>,
}

impl TargetShapes {
    /// With deviations divided by a factor.
    pub fn scaled(&self, factor: f64) -> Self {
        let (rows, vectors) = (&self.rows, self.vectors.iter());
        let scaled = |v: &Vec<f64>| v.iter().map(|x| factor * x).collect();
        Self {
            rows: real_matrix(rows.nrows(), rows.ncols(), |i, j| factor * rows[(i, j)]),
            vectors: vectors.map(scaled).collect(),
        }
    }
}
