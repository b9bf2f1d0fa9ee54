//! The matrices of a model in the form in which it is solved: full or sparse.

use crate::linalg::{RealMatrix, real_matrix};

use super::eigen::sizes;
use super::sparse::{SparseDerivative, SparseSystem, modes_of_sparse};
use super::{
    ModeOptions, SystemDerivative, SystemMatrices, TheoreticalModel, TheoryError, TheoryModes,
    modes_of_matrices,
};

/// Matrices of a model with some values.
pub(super) enum System {
    Full(SystemMatrices),
    Sparse(SparseSystem),
}

impl System {
    pub fn of(model: &dyn TheoreticalModel, values: &[f64]) -> Result<Self, TheoryError> {
        Ok(match model.sparse(values)? {
            Some(system) => System::Sparse(system),
            None => System::Full(model.assemble(values)?),
        })
    }

    pub fn is_sparse(&self) -> bool {
        matches!(self, System::Sparse(_))
    }

    /// The modes that the options ask for; of a sparse system the lowest without any.
    pub fn modes(&self, options: &ModeOptions) -> Result<TheoryModes, TheoryError> {
        match self {
            System::Full(matrices) => modes_of_matrices(matrices, options),
            System::Sparse(system) => modes_of_sparse(system, options),
        }
    }

    /// `M X`.
    pub fn mass(&self, x: &RealMatrix) -> RealMatrix {
        match self {
            System::Full(matrices) => &matrices.mass * x,
            System::Sparse(system) => system.mass.multiply(x),
        }
    }

    /// `K X`.
    pub fn stiffness(&self, x: &RealMatrix) -> RealMatrix {
        match self {
            System::Full(matrices) => &matrices.stiffness * x,
            System::Sparse(system) => system.stiffness.multiply(x),
        }
    }

    /// `|K| |x|` of one column, entries without their signs.
    pub fn stiffness_terms(&self, x: &RealMatrix) -> RealMatrix {
        match self {
            System::Full(matrices) => sizes(&matrices.stiffness) * sizes(x),
            System::Sparse(system) => {
                let mut terms = real_matrix(x.nrows(), 1, |_, _| 0.0);
                for (i, j, k) in system.stiffness.entries() {
                    terms[(i, 0)] += (k * x[(j, 0)]).abs();
                }
                terms
            }
        }
    }
}

/// Derivatives of the matrices of a model by one parameter.
pub(super) enum SystemSlope {
    Full(SystemDerivative),
    Sparse(SparseDerivative),
}

impl SystemSlope {
    pub fn of(model: &dyn TheoreticalModel, values: &[f64], j: usize) -> Result<Self, TheoryError> {
        Ok(match model.sparse_derivative(values, j)? {
            Some(by) => SystemSlope::Sparse(by),
            None => SystemSlope::Full(model.derivative(values, j)?),
        })
    }

    /// `dM X` and `dK X`.
    pub fn products(&self, x: &RealMatrix) -> [RealMatrix; 2] {
        match self {
            SystemSlope::Full(by) => [&by.mass * x, &by.stiffness * x],
            SystemSlope::Sparse(by) => [by.mass.multiply(x), by.stiffness.multiply(x)],
        }
    }
}
