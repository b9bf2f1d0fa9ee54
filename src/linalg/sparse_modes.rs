//! Sparse modes hold the lowest eigenvalues and vectors of a sparse pair, with their count.

use super::RealMatrix;

/// Lowest eigenvalues and vectors of `K phi = omega^2 M phi`, none missing.
#[derive(Clone, Debug)]
pub struct SparseModes {
    /// Eigenvalues omega², ascending, (rad/s)².
    pub omega_squared: Vec<f64>,
    /// Mass-normalised vectors, one per column.
    pub vectors: RealMatrix,
    /// Bound of the change of each omega² by rounding of the entries of K, `eps |phi|^T |K| |phi|`,
    /// (rad/s)².
    pub rounding: Vec<f64>,
    /// The limit below which the eigenvalues were counted, (rad/s)²; `None` where these are all
    /// there are.
    pub counted_below: Option<f64>,
    /// Vectors to which the shifted and inverted pair was applied.
    pub solves: usize,
}
