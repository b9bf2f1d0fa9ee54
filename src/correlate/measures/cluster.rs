//! Clusters compare close modes as subspaces, because their single shapes may be any mixture.

use serde::Serialize;

use crate::modal::ModalModel;

use super::super::model_roots::elastic_modes;
use super::super::shapes::Shapes;
use super::super::subspace::principal_angles_deg;
use super::super::{CorrelateError, Pair, Pairing};
use super::mac_matrix::ModeName;

/// Neighbouring modes nearer than this part of the higher frequency are one cluster.
pub const CLUSTER_WIDTH: f64 = 0.02;

/// All modes of a cluster lie within this part of the higher frequency, however many stand between.
pub const CLUSTER_SPAN: f64 = 0.05;

/// Close or repeated modes of a theory against the test modes that met them, as subspaces.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClusterMac {
    /// The theory's modes, by frequency.
    pub theory: Vec<ModeName>,
    /// The test's modes that are paired with them.
    pub test: Vec<ModeName>,
    /// Principal angles between both subspaces, ascending, degrees; `None` where one side's modes
    /// are more than half as many as the degrees of freedom: most of any space is then in that
    /// subspace.
    pub angles_deg: Option<Vec<f64>>,
    /// `1 − sin θ` of the largest principal angle `θ`, 0 to 1: the criterion of Vinze, Allemang and
    /// Phillips (Developing a correlation criterion (SpaceMAC) for repeated and pseudo-repeated
    /// modes, IMAC), who take the smallest angle. That one vanishes as soon as a single direction
    /// is shared.
    pub space_mac: Option<f64>,
    /// Mean of `cos² θ`: the mean MAC of the test's modes with the subspace, were their shapes at
    /// right angles.
    pub mean_mac: Option<f64>,
    /// What `mean_mac` is on average for directions drawn at random: modes of the larger subspace
    /// over degrees of freedom.
    pub random_mac: Option<f64>,
    /// Degrees of freedom used.
    pub dofs: usize,
}

/// The clusters of a theory that a test met, in ascending frequency: roots one after the other that
/// lie within [`CLUSTER_WIDTH`], and all of them within [`CLUSTER_SPAN`], or whose test modes do,
/// and repeated roots.
///
/// # Errors
/// [`CorrelateError::Linalg`].
///
/// # Reference
/// Björck and Golub (1973), Numerical methods for computing angles between linear subspaces, Math.
/// Comp. 27.
pub(super) fn clusters(
    (test, theory): (&ModalModel, &ModalModel),
    shapes: &Shapes,
    pairing: &Pairing,
) -> Result<Vec<ClusterMac>, CorrelateError> {
    let mut modes = elastic_modes(theory);
    modes.sort_by(|&a, &b| {
        let hz = |j: usize| theory.modes[j].frequency_hz;
        hz(a).total_cmp(&hz(b))
    });
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for j in modes {
        match groups.last_mut() {
            Some(group) if joined((test, theory), pairing, (group, j)) => group.push(j),
            _ => groups.push(vec![j]),
        }
    }
    let several = groups.iter().filter(|group| group.len() > 1);
    let found = several.map(|group| cluster((test, theory), shapes, (group, pairing)));
    let found: Result<Vec<Option<ClusterMac>>, _> = found.collect();
    Ok(found?.into_iter().flatten().collect())
}

/// Whether the next theory mode belongs to a cluster.
fn joined(
    models: (&ModalModel, &ModalModel),
    pairing: &Pairing,
    (group, next): (&[usize], usize),
) -> bool {
    let (first, last) = (group[0], group[group.len() - 1]);
    let near = |other: usize, part: f64| within(models, pairing, (other, next), part);
    same_root(models.1, last, next) || near(last, CLUSTER_WIDTH) && near(first, CLUSTER_SPAN)
}

/// Whether two theory modes are of one repeated root.
fn same_root(theory: &ModalModel, a: usize, b: usize) -> bool {
    let group = theory.modes[a].group;
    group.is_some() && group == theory.modes[b].group
}

/// Whether two theory modes, or test modes that are paired with them, lie within a part of the
/// higher frequency.
fn within(
    (test, theory): (&ModalModel, &ModalModel),
    pairing: &Pairing,
    (a, b): (usize, usize),
    part: f64,
) -> bool {
    let near = |x: f64, y: f64| (x - y).abs() <= part * x.max(y);
    if near(theory.modes[a].frequency_hz, theory.modes[b].frequency_hz) {
        return true;
    }
    let hz = |i: &usize| test.modes[*i].frequency_hz;
    let (of_a, of_b) = (partners(pairing, &[a]), partners(pairing, &[b]));
    of_a.iter().any(|i| of_b.iter().any(|j| near(hz(i), hz(j))))
}

/// Test modes paired with any of some theory modes, ascending.
fn partners(pairing: &Pairing, theory: &[usize]) -> Vec<usize> {
    let of_cluster = |pair: &&Pair| pair.theory.iter().any(|j| theory.contains(j));
    let found = pairing.pairs.iter().filter(of_cluster);
    let mut tests: Vec<usize> = found
        .flat_map(|pair| pair.partners.iter().map(|partner| partner.test))
        .collect();
    tests.sort_unstable();
    tests
}

fn cluster(
    (test, theory): (&ModalModel, &ModalModel),
    shapes: &Shapes,
    (group, pairing): (&[usize], &Pairing),
) -> Result<Option<ClusterMac>, CorrelateError> {
    let tests = partners(pairing, group);
    if tests.is_empty() {
        return Ok(None);
    }
    let [of_test, of_theory] = shapes.common(&tests, group);
    let dofs = of_test[0].len();
    let modes = tests.len().max(group.len());
    let angles = if 2 * modes <= dofs {
        principal_angles_deg(&of_test, &of_theory)?
    } else {
        Vec::new()
    };
    let cosines = angles.iter().map(|angle| angle.to_radians().cos().powi(2));
    let mean = cosines.sum::<f64>() / angles.len() as f64;
    let names = |model: &ModalModel, modes: &[usize]| {
        let all = ModeName::all(model);
        modes.iter().map(|&i| all[i]).collect()
    };
    let largest = angles.last().map(|angle| angle.to_radians().sin());
    Ok(Some(ClusterMac {
        theory: names(theory, group),
        test: names(test, &tests),
        space_mac: largest.map(|sine| 1.0 - sine),
        mean_mac: largest.map(|_| mean),
        random_mac: largest.map(|_| modes as f64 / dofs as f64),
        angles_deg: largest.map(|_| angles),
        dofs,
    }))
}
