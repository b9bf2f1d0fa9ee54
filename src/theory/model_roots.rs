//! The distinct roots of a model collect the modes of one frequency, with the mean distribution of
//! their kinetic and strain energy.

use std::collections::BTreeMap;

use crate::linalg::{RealMatrix, sort_descending_by};

use super::{TheoreticalModel, TheoryModes};

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
        sort_descending_by(&mut kinds, |kind| kind.1);
        kinds
    }
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
