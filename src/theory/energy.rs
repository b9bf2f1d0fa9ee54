//! The distinct roots of a model, and the distribution of their kinetic and strain energy.

use std::collections::BTreeMap;

use crate::linalg::RealMatrix;

use super::{Spring, StiffnessPart, TheoreticalModel, TheoryModes};

/// One root of a model with all modes that share it.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelRoot {
    /// Indices, from 0, of its modes in the list of the modes; as many as its multiplicity.
    pub modes: Vec<usize>,
    /// Angular frequency, rad/s; 0 for the rigid-body modes.
    pub omega_rad_s: f64,
    /// Share of the kinetic energy in each body, bodies in the order of the model; the shares add
    /// up to 1. For a repeated root the mean over its modes, which does not depend on the basis.
    pub kinetic_energy: Vec<(String, f64)>,
    /// Share of the strain energy in the springs, or the parts of the stiffness matrix, of each
    /// name, in the order of the model; the shares add up to 1. Of a repeated root the mean over
    /// its modes. Empty for a root at 0 and for a model without springs or named parts.
    pub strain_energy: Vec<(String, f64)>,
    /// Class of the motion, in the words of the model; `None` for a model that has no such
    /// words.
    pub class: Option<String>,
}

impl ModelRoot {
    /// The kinetic energy with bodies that differ only in their number (`ball-1`, `ball-2`, ...)
    /// taken together under their common name, largest share first.
    pub fn energy_by_kind(&self) -> Vec<(String, f64)> {
        let mut kinds: Vec<(String, f64)> = Vec::new();
        for (body, share) in &self.kinetic_energy {
            let kind = body
                .rsplit_once('-')
                .filter(|(_, number)| number.parse::<u32>().is_ok())
                .map_or(body.as_str(), |(kind, _)| kind);
            match kinds.iter_mut().find(|(known, _)| known == kind) {
                Some((_, total)) => *total += share,
                None => kinds.push((kind.to_owned(), *share)),
            }
        }
        kinds.sort_by(|a, b| b.1.total_cmp(&a.1));
        kinds
    }
}

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

/// The distinct roots in ascending order; modes of one group number are one root.
pub fn model_roots(model: &dyn TheoreticalModel, modes: &TheoryModes) -> Vec<ModelRoot> {
    let root = |modes_of_root: Vec<usize>| {
        let omega_rad_s = modes.omega_rad_s[modes_of_root[0]];
        let shares = mean_shares(&modes.kinetic_shares, &modes_of_root);
        let strain = &modes.strain_shares;
        let strained = (omega_rad_s > 0.0).then(|| {
            let means = mean_shares(&strain.shares, &modes_of_root).into_iter();
            strain.names.iter().cloned().zip(means).collect()
        });
        ModelRoot {
            omega_rad_s,
            kinetic_energy: by_body(modes, &shares),
            strain_energy: strained.unwrap_or_default(),
            class: model.mode_class(omega_rad_s, &shares).map(str::to_owned),
            modes: modes_of_root,
        }
    };
    modes.model.roots().into_iter().map(root).collect()
}

/// `phi_i (M phi)_i` of every coordinate (row) in every mode (column) of unit modal mass, from
/// `moved = M Phi`; each column adds up to 1.
pub(super) fn kinetic_shares(moved: &RealMatrix, vectors: &RealMatrix) -> RealMatrix {
    crate::linalg::real_matrix(vectors.nrows(), vectors.ncols(), |i, j| {
        vectors[(i, j)] * moved[(i, j)]
    })
}

/// Each row's mean over the modes of a root.
fn mean_shares(shares: &RealMatrix, modes: &[usize]) -> Vec<f64> {
    let mean = |i: usize| modes.iter().map(|&j| shares[(i, j)]).sum::<f64>() / modes.len() as f64;
    (0..shares.nrows()).map(mean).collect()
}

fn by_body(modes: &TheoryModes, shares: &[f64]) -> Vec<(String, f64)> {
    let mut bodies: Vec<(String, f64)> = Vec::new();
    let mut index_of_body: BTreeMap<&str, usize> = BTreeMap::new();
    for (coordinate, share) in modes.coordinates.iter().zip(shares) {
        let body_index = *index_of_body
            .entry(&coordinate.body)
            .or_insert(bodies.len());
        if body_index == bodies.len() {
            bodies.push((coordinate.body.clone(), 0.0));
        }
        bodies[body_index].1 += share;
    }
    bodies
}
