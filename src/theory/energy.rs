//! Kinetic energy of modes divides among the coordinates, strain energy among springs or parts of
//! the stiffness matrix.

use crate::linalg::RealMatrix;

use super::{Spring, StiffnessPart};

/// Share of the strain energy of a mode (column) in the springs, or the parts of the stiffness
/// matrix, of one name (row).
#[derive(Clone, Debug)]
pub struct StrainShares {
    /// The names, each once, in the order of the springs or parts.
    pub names: Vec<String>,
    /// The shares; a column adds up to 1, or is 0 where nothing is strained.
    pub shares: RealMatrix,
}

/// `k (b^T phi)^2` of every spring in every mode over its sum. Rounding strains a rigid-body mode a
/// little, by which its shares mean nothing.
pub(super) fn strain_shares(springs: &[Spring], vectors: &RealMatrix) -> StrainShares {
    shares(
        springs,
        vectors,
        |spring| &spring.name,
        |spring, phi| {
            let parts = spring.row.iter().zip(phi);
            let stretch: f64 = parts.map(|(part, moved)| part * moved).sum();
            spring.stiffness * stretch * stretch
        },
    )
}

/// `theta_j phi^T K_j phi` of every part of the stiffness matrix in every mode over its sum, which
/// is `phi^T K phi`.
pub(super) fn part_shares(parts: &[StiffnessPart<'_>], vectors: &RealMatrix) -> StrainShares {
    shares(
        parts,
        vectors,
        |part| part.name,
        |part, phi| part.factor * part.matrix.quadratic_form(phi).value,
    )
}

/// Share of the energy of all items of one name in each mode.
fn shares<T>(
    all: &[T],
    vectors: &RealMatrix,
    name: impl Fn(&T) -> &str,
    energy: impl Fn(&T, &[f64]) -> f64,
) -> StrainShares {
    let mut names: Vec<String> = Vec::new();
    let mut rows = Vec::with_capacity(all.len());
    for item in all {
        let index = names.iter().position(|listed| listed == name(item));
        rows.push(index.unwrap_or(names.len()));
        if index.is_none() {
            names.push(name(item).to_owned());
        }
    }
    let mut shares = crate::linalg::real_matrix(names.len(), vectors.ncols(), |_, _| 0.0);
    for j in 0..vectors.ncols() {
        let phi: Vec<f64> = vectors.col(j).iter().copied().collect();
        for (item, &row) in all.iter().zip(&rows) {
            shares[(row, j)] += energy(item, &phi);
        }
        let total: f64 = (0..names.len()).map(|i| shares[(i, j)]).sum();
        if total > 0.0 {
            (0..names.len()).for_each(|i| shares[(i, j)] /= total);
        }
    }
    StrainShares { names, shares }
}

/// `phi_i (M phi)_i` of every coordinate (row) in every mode (column) of unit modal mass, from
/// `moved = M Phi`; each column adds up to 1.
pub(super) fn kinetic_shares(moved: &RealMatrix, vectors: &RealMatrix) -> RealMatrix {
    crate::linalg::real_matrix(vectors.nrows(), vectors.ncols(), |i, j| {
        vectors[(i, j)] * moved[(i, j)]
    })
}
