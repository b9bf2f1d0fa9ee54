//! Which matrices of a model a parameter changes.

use crate::linalg::{RealMatrix, SparseMatrix};

use super::system::SystemSlope;
use super::{TheoreticalModel, TheoryError};

/// Whether parameter `j` is a stiffness: it changes the stiffness matrix and not the mass matrix,
/// and its unit is that of a stiffness, of a modulus, or none. A length or an angle that changes
/// the stiffness matrix is geometry.
///
/// # Errors
/// Those of the model's derivative.
pub fn is_stiffness(
    model: &dyn TheoreticalModel,
    values: &[f64],
    j: usize,
) -> Result<bool, TheoryError> {
    let spec = &model.parameters()[j];
    let unit = spec.unit.trim();
    let is_elastic = unit.contains('N') || unit.contains("Pa") || matches!(unit, "" | "-" | "1");
    if spec.whole || !is_elastic {
        return Ok(false);
    }
    let dense = |matrix: &RealMatrix| {
        let places = (0..matrix.ncols()).flat_map(|k| (0..matrix.nrows()).map(move |i| (i, k)));
        places.map(|place| matrix[place]).all(|value| value == 0.0)
    };
    let sparse = |matrix: &SparseMatrix| matrix.entries().all(|(_, _, value)| value == 0.0);
    let [is_mass_unchanged, is_stiffness_unchanged] = match SystemSlope::of(model, values, j)? {
        SystemSlope::Full(by) => [dense(&by.mass), dense(&by.stiffness)],
        SystemSlope::Sparse(by) => [sparse(&by.mass), sparse(&by.stiffness)],
    };
    Ok(is_mass_unchanged && !is_stiffness_unchanged)
}
