//! MAC of test modes and the roots near them in frequency, under signs of the sensors, and the
//! pairs that these give.

use num_complex::Complex64;

use super::super::candidates::FREQUENCY_WEIGHT;
use super::super::chance::{ChanceLevel, ChanceSetting, effective_dof_fraction};
use super::super::model_roots::{Root, elastic_modes, elastic_roots};
use super::super::shapes::{MIN_SHAPE_DOFS, Shapes};
use super::super::subspace::orthonormal;
use super::super::{PairOptions, assign};
use crate::modal::ModalModel;

/// A root within the frequency gate of a test mode. Values are 0 where either has none.
pub(super) struct Near {
    root: usize,
    /// `|f_test − f_theory|/f_theory` over the gate.
    offset: f64,
    /// Test shape, of unit length.
    test: Vec<Complex64>,
    /// Orthonormal basis of the shapes of the root.
    basis: Vec<Vec<Complex64>>,
    /// Degrees of freedom in common.
    dofs: usize,
    /// Chance level of the MAC, which does not depend on signs.
    level: f64,
}

/// All test modes with the roots near them.
pub(super) struct Overlaps {
    rows: Vec<Vec<Near>>,
    /// The root of each column of the assignment: a repeated root has as many as modes.
    columns: Vec<usize>,
}

/// Pairs of the test modes: for each the index of its root among those near it.
#[derive(Clone, Debug, Default)]
pub(super) struct TrialPairing {
    pub cost: f64,
    /// Sum of the MAC of all pairs.
    pub mac: f64,
    pub near: Vec<Option<usize>>,
}

/// Overlaps `qᴴ S ψ` of every test mode with the basis of every root near it, under the signs `S`.
pub(super) struct Signed {
    pub signs: Vec<f64>,
    overlaps: Vec<Vec<Vec<Complex64>>>,
}

/// Shapes of a pair under some signs: the unit test shape and its projection on the root, scaled to
/// unit length; their inner product is real and positive.
pub(super) struct PairView {
    pub values: Vec<(Complex64, Complex64)>,
    pub dofs: usize,
    pub mac: f64,
    pub level: f64,
}

impl Overlaps {
    pub(super) fn new(
        test: &ModalModel,
        theory: &ModalModel,
        shapes: &Shapes,
        options: &PairOptions,
    ) -> Self {
        let roots = elastic_roots(theory);
        let effective_fraction = effective_dof_fraction(&shapes.of_roots(&roots));
        let offset =
            |hz: f64, root: &Root| (hz - root.hz).abs() / root.hz / options.max_frequency_error;
        let row = |i: usize| {
            let hz = test.modes[i].frequency_hz;
            let near = roots.iter().enumerate();
            let near: Vec<(usize, &Root)> =
                near.filter(|(_, root)| offset(hz, root) <= 1.0).collect();
            let rank = |limit: f64| {
                near.iter()
                    .filter(|(_, root)| offset(hz, root) <= limit)
                    .count()
            };
            let of = |(r, root): &(usize, &Root)| {
                let offset = offset(hz, root);
                let setting = ChanceSetting {
                    dofs: shapes.distinct_count(shapes.common_dofs(&[i], &root.modes)),
                    effective_fraction,
                    roots: near.len(),
                    rank: rank(offset),
                    others_correlate: false,
                };
                Some(Near {
                    root: *r,
                    offset,
                    ..Near::new(shapes, i, &root.modes, &setting)?
                })
            };
            near.iter().filter_map(of).collect()
        };
        let columns = roots.iter().enumerate();
        let columns = columns.flat_map(|(r, root)| std::iter::repeat_n(r, root.modes.len()));
        Self {
            rows: elastic_modes(test).into_iter().map(row).collect(),
            columns: columns.collect(),
        }
    }

    /// Number of test modes with a root near them.
    pub(super) fn modes(&self) -> usize {
        self.rows.iter().filter(|row| !row.is_empty()).count()
    }

    pub(super) fn signed(&self, signs: Vec<f64>) -> Signed {
        let row = |row: &Vec<Near>| row.iter().map(|near| near.overlap(&signs)).collect();
        Signed {
            overlaps: self.rows.iter().map(row).collect(),
            signs,
        }
    }

    /// The pairs of smallest cost with the signs of more sensors changed.
    pub(super) fn choose(&self, signed: &Signed, members: &[usize]) -> TrialPairing {
        let macs = self.macs(signed, members);
        let row = |(row, macs): (&Vec<Near>, &Vec<f64>)| {
            let mut costs = vec![None; self.columns.len()];
            for (near, mac) in row.iter().zip(macs) {
                let first = self.columns.partition_point(|&root| root < near.root);
                let same = self.columns[first..]
                    .iter()
                    .take_while(|&&root| root == near.root);
                let count = same.count();
                costs[first..first + count].fill(Some(near.cost(*mac)));
            }
            costs
        };
        let costs: Vec<Vec<Option<f64>>> = self.rows.iter().zip(&macs).map(row).collect();
        let place = |(row, column): (&Vec<Near>, Option<usize>)| {
            let root = self.columns[column?];
            row.iter().position(|near| near.root == root)
        };
        let near = self
            .rows
            .iter()
            .zip(assign(&costs, 1.0))
            .map(place)
            .collect();
        self.trial_pairing(near, &macs)
    }

    /// The pairs as before with the signs of more sensors changed.
    pub(super) fn keep(
        &self,
        signed: &Signed,
        members: &[usize],
        before: &TrialPairing,
    ) -> TrialPairing {
        self.trial_pairing(before.near.clone(), &self.macs(signed, members))
    }

    fn trial_pairing(&self, near: Vec<Option<usize>>, macs: &[Vec<f64>]) -> TrialPairing {
        let (mut cost, mut mac) = (0.0, 0.0);
        for ((row, macs), near) in self.rows.iter().zip(macs).zip(&near) {
            cost += near.map_or(1.0, |n| row[n].cost(macs[n]));
            mac += near.map_or(0.0, |n| macs[n]);
        }
        TrialPairing { cost, mac, near }
    }

    fn macs(&self, signed: &Signed, members: &[usize]) -> Vec<Vec<f64>> {
        let of =
            |(near, overlap): (&Near, &Vec<Complex64>)| near.mac(overlap, &signed.signs, members);
        let row = |(row, overlaps): (&Vec<Near>, &Vec<Vec<Complex64>>)| {
            row.iter().zip(overlaps).map(of).collect()
        };
        self.rows.iter().zip(&signed.overlaps).map(row).collect()
    }

    /// The pairs under some signs.
    pub(super) fn views(&self, choice: &TrialPairing, signs: &[f64]) -> Vec<PairView> {
        let chosen = self.rows.iter().zip(&choice.near);
        let chosen = chosen.filter_map(|(row, near)| row.get((*near)?));
        chosen.filter_map(|near| near.view(signs)).collect()
    }
}

impl Near {
    /// `None` where fewer degrees of freedom than a MAC needs are in common, or one side does not
    /// move there.
    fn new(shapes: &Shapes, i: usize, root: &[usize], setting: &ChanceSetting) -> Option<Self> {
        let dofs = shapes.common_dofs(&[i], root);
        let [test, modes] = shapes.common_values(&[i], root);
        let length = test[0].iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
        let basis = orthonormal(&modes);
        if dofs.len() < MIN_SHAPE_DOFS || length <= 0.0 || basis.is_empty() {
            return None;
        }
        let level = ChanceLevel::new(&test[0], &modes, setting);
        let at_all_dofs = |values: &[Complex64], scale: f64| {
            let mut all = vec![Complex64::ZERO; shapes.test[i].len()];
            for (&d, value) in dofs.iter().zip(values) {
                all[d] = value * scale;
            }
            all
        };
        Some(Self {
            root: 0,
            offset: 0.0,
            test: at_all_dofs(&test[0], length.recip()),
            basis: basis
                .iter()
                .map(|column| at_all_dofs(column, 1.0))
                .collect(),
            dofs: dofs.len(),
            level: level.mac,
        })
    }

    fn cost(&self, mac: f64) -> f64 {
        FREQUENCY_WEIGHT * self.offset + (1.0 - FREQUENCY_WEIGHT) * (1.0 - mac)
    }

    fn overlap(&self, signs: &[f64]) -> Vec<Complex64> {
        let of = |basis: &Vec<Complex64>| {
            let terms = basis.iter().zip(&self.test).zip(signs);
            terms.map(|((q, psi), sign)| q.conj() * psi * *sign).sum()
        };
        self.basis.iter().map(of).collect()
    }

    /// MAC with the signs of `members` changed.
    fn mac(&self, overlap: &[Complex64], signs: &[f64], members: &[usize]) -> f64 {
        let of = |(basis, all): (&Vec<Complex64>, &Complex64)| {
            let term = |&d: &usize| basis[d].conj() * self.test[d] * signs[d];
            let changed: Complex64 = members.iter().map(term).sum();
            (all - 2.0 * changed).norm_sqr()
        };
        self.basis.iter().zip(overlap).map(of).sum::<f64>().min(1.0)
    }

    fn view(&self, signs: &[f64]) -> Option<PairView> {
        let overlap = self.overlap(signs);
        let mac: f64 = overlap.iter().map(Complex64::norm_sqr).sum();
        let length = mac.sqrt();
        let projection = |d: usize| -> Complex64 {
            let terms = self.basis.iter().zip(&overlap);
            terms.map(|(q, a)| q[d] * a).sum::<Complex64>() / length
        };
        let values = self.test.iter().zip(signs).enumerate();
        let values = values.map(|(d, (psi, sign))| (psi * *sign, projection(d)));
        (length > 0.0).then(|| PairView {
            values: values.collect(),
            dofs: self.dofs,
            mac: mac.min(1.0),
            level: self.level,
        })
    }
}
