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
/// A length, an area or an angle that does is geometry, and so is a ratio, but for the factor of a
/// group of matrices.
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
    let is_ratio = matches!(unit, "" | "-" | "1") && model.stiffness_parts(values)?.is_empty();
    if spec.whole || is_ratio || GEOMETRY_UNITS.contains(&unit) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::theory::{built_in, nominal_values};

    #[test]
    fn stiffnesses_of_the_transmissions_are_those_of_springs() {
        for name in [
            "cycloid-ball",
            "torsional-planetary",
            "spider-reducer",
            "helical-planetary",
        ] {
            let model = built_in(name).unwrap();
            let specs = model.parameters();
            let values = nominal_values(specs);
            let found =
                (0..specs.len()).filter(|j| is_stiffness(model.as_ref(), &values, *j).unwrap());
            let found: Vec<&str> = found.map(|j| specs[j].unit.as_str()).collect();
            assert!(!found.is_empty(), "{name}");
            assert!(
                found.iter().all(|unit| unit.starts_with('N')),
                "{name}: {found:?}"
            );
        }
        let model = built_in("cycloid-ball").unwrap();
        let values = nominal_values(model.parameters());
        for (j, spec) in model.parameters().iter().enumerate() {
            let expected = spec.name.starts_with("k_");
            assert_eq!(
                is_stiffness(model.as_ref(), &values, j).unwrap(),
                expected,
                "{}",
                spec.name
            );
        }
    }
}
