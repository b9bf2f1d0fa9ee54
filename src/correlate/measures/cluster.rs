//! Clusters compare close modes as subspaces, because their single shapes may be any mixture.

use serde::Serialize;

use crate::linalg::sort_ascending_by;
use crate::modal::ModalModel;

use super::super::model_roots::elastic_modes;
use super::super::shapes::Shapes;
use super::super::subspace::principal_angles_deg;
use super::super::{CorrelateError, Pair, Pairing};
use super::mac_matrix::ModeName;

/// Maximum spacing of neighbouring modes of a cluster, as a fraction of the higher frequency.
pub const CLUSTER_WIDTH: f64 = 0.02;

/// Maximum spacing of the lowest and the highest mode of a cluster, as a fraction of the higher
/// frequency.
pub const CLUSTER_SPAN: f64 = 0.05;

/// Close or repeated modes of a theory against the test modes paired with them, as subspaces.
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
    /// Expected `mean_mac` of random directions: modes of the larger subspace over degrees of
    /// freedom.
    pub random_mac: Option<f64>,
    /// Degrees of freedom used.
    pub dofs: usize,
}

/// The clusters of a theory with test modes paired with them, in ascending frequency: repeated
/// roots, and roots of which neighbours lie within [`CLUSTER_WIDTH`] and all within
/// [`CLUSTER_SPAN`], in frequency or in that of their test modes.
///
/// # Errors
/// [`CorrelateError::Linalg`].
///
/// # Reference
/// Björck and Golub (1973), Numerical methods for computing angles between linear subspaces, Math.
/// Comp. 27.
pub(super) fn clusters(
    test: &ModalModel,
    theory: &ModalModel,
    shapes: &Shapes,
    pairing: &Pairing,
) -> Result<Vec<ClusterMac>, CorrelateError> {
    let paired = PairedModels {
        test,
        theory,
        pairing,
    };
    let mut modes = elastic_modes(theory);
    sort_ascending_by(&mut modes, |&j| theory.modes[j].frequency_hz);
    let mut clusters: Vec<Vec<usize>> = Vec::new();
    for j in modes {
        match clusters.last_mut() {
            Some(cluster) if paired.is_in_cluster(cluster, j) => cluster.push(j),
            _ => clusters.push(vec![j]),
        }
    }
    let several = clusters.iter().filter(|cluster| cluster.len() > 1);
    let compared = several.map(|cluster| paired.cluster_mac(cluster, shapes));
    let compared: Result<Vec<Option<ClusterMac>>, _> = compared.collect();
    Ok(compared?.into_iter().flatten().collect())
}

/// A test and a theory with their pairing.
struct PairedModels<'a> {
    test: &'a ModalModel,
    theory: &'a ModalModel,
    pairing: &'a Pairing,
}

impl PairedModels<'_> {
    /// Whether the next theory mode belongs to a cluster.
    fn is_in_cluster(&self, cluster: &[usize], next: usize) -> bool {
        let (first, last) = (cluster[0], cluster[cluster.len() - 1]);
        self.have_same_root(last, next)
            || self.are_close(last, next, CLUSTER_WIDTH)
                && self.are_close(first, next, CLUSTER_SPAN)
    }

    /// Whether two theory modes have the same repeated root.
    fn have_same_root(&self, a: usize, b: usize) -> bool {
        let group = self.theory.modes[a].group;
        group.is_some() && group == self.theory.modes[b].group
    }

    /// Whether the frequencies of two theory modes, or of test modes that are paired with them,
    /// differ by no more than this fraction of the higher one.
    fn are_close(&self, a: usize, b: usize, fraction: f64) -> bool {
        let close = |x: f64, y: f64| (x - y).abs() <= fraction * x.max(y);
        let theory_hz = |j: usize| self.theory.modes[j].frequency_hz;
        if close(theory_hz(a), theory_hz(b)) {
            return true;
        }
        let test_hz = |i: &usize| self.test.modes[*i].frequency_hz;
        let (of_a, of_b) = (self.partners(&[a]), self.partners(&[b]));
        of_a.iter()
            .any(|i| of_b.iter().any(|j| close(test_hz(i), test_hz(j))))
    }

    /// Test modes paired with any of some theory modes, ascending.
    fn partners(&self, theory: &[usize]) -> Vec<usize> {
        let of_cluster = |pair: &&Pair| pair.theory.iter().any(|j| theory.contains(j));
        let found = self.pairing.pairs.iter().filter(of_cluster);
        let mut tests: Vec<usize> = found
            .flat_map(|pair| pair.partners.iter().map(|partner| partner.test))
            .collect();
        tests.sort_unstable();
        tests
    }

    /// A cluster against the test modes paired with it; `None` where there are none.
    fn cluster_mac(
        &self,
        cluster: &[usize],
        shapes: &Shapes,
    ) -> Result<Option<ClusterMac>, CorrelateError> {
        let tests = self.partners(cluster);
        if tests.is_empty() {
            return Ok(None);
        }
        let [of_test, of_theory] = shapes.common_values(&tests, cluster);
        let dofs = of_test[0].len();
        let modes = tests.len().max(cluster.len());
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
            theory: names(self.theory, cluster),
            test: names(self.test, &tests),
            space_mac: largest.map(|sine| 1.0 - sine),
            mean_mac: largest.map(|_| mean),
            random_mac: largest.map(|_| modes as f64 / dofs as f64),
            angles_deg: largest.map(|_| angles),
            dofs,
        }))
    }
}
