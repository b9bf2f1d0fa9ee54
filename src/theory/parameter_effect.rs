//! Which matrices of a model a parameter changes.

use crate::linalg::{RealMatrix, SparseMatrix};

use super::system::SystemSlope;
use super::{TheoreticalModel, TheoryError};

/// Units of lengths, areas, second moments and angles.
const GEOMETRY_UNITS: [&str; 16] = [
    "m", "mm", "cm", "in", "ft", "m2", "m^2", "m²", "m4", "m^4", "m⁴", "mm4", "mm^4", "rad", "deg",
    "°",
];

/// Whether parameter `j` is a stiffness: it changes the stiffness matrix and not the mass matrix.
/// A length, an area or an angle that does is geometry.
///
/// # Errors
/// Those of the model's derivative.
pub fn is_stiffness(
    model: &dyn TheoreticalModel,
    values: &[f64],
    j: usize,
) -> Result<bool, TheoryError> {
    let spec = &model.parameters()[j];
    if spec.whole || GEOMETRY_UNITS.contains(&spec.unit.trim()) {
        return Ok(false);
    }
    let is_dense_zero = |matrix: &RealMatrix| matrix.norm_max() == 0.0;
    let is_sparse_zero = |matrix: &SparseMatrix| matrix.entries().all(|(_, _, value)| value == 0.0);
    let [is_mass_unchanged, is_stiffness_unchanged] = match SystemSlope::of(model, values, j)? {
        SystemSlope::Full(by) => [&by.mass, &by.stiffness].map(is_dense_zero),
        SystemSlope::Sparse(by) => [&by.mass, &by.stiffness].map(is_sparse_zero),
    };
    Ok(is_mass_unchanged && !is_stiffness_unchanged)
}
