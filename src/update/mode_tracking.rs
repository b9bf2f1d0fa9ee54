//! Mode tracking pairs measured modes with modes of the model at the start and follows them by
//! shape.

use crate::correlate::{PairOptions, assign, highest_rigid_hz, pair};
use crate::linalg::{RealMatrix, sort_ascending_by};
use crate::modal::ModalModel;
use crate::theory::TheoryModes;

use super::model_state::ModelState;
use super::target_shapes::TargetShapes;
use super::{Target, UpdateError};

/// Smallest share of a shape in a new mode by which a mode is followed to it.
const MIN_TRACKED_SHARE: f64 = 1e-3;

/// Size of a shape at the sensors, over that of the largest of its root, that is round-off.
const ROUND_OFF_SHAPE_RATIO: f64 = 1e-6;

/// Measured roots of a test that are paired with one root of the model.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct RootPair {
    /// Index of the configuration.
    pub configuration: usize,
    /// Indices of the targets, ascending in frequency.
    pub targets: Vec<usize>,
    /// Indices, ascending, of the modes of the model; several where they are one repeated root at
    /// the start.
    pub modes: Vec<usize>,
}

/// The modes of the targets of one test, which take part in the pairing.
#[derive(Clone, Debug)]
pub(super) struct PairedModes {
    /// The modes.
    pub modes: ModalModel,
    /// The target of each.
    pub target: Vec<usize>,
}

impl PairedModes {
    /// Those of the targets of one test.
    pub fn new(test: usize, model: &ModalModel, targets: &[Target]) -> Self {
        let mut found = Self {
            modes: ModalModel {
                modes: Vec::new(),
                ..model.clone()
            },
            target: Vec::new(),
        };
        for (t, target) in targets.iter().enumerate().filter(|(_, t)| t.test == test) {
            for &i in &target.modes {
                found.modes.modes.push(model.modes[i].clone());
                found.target.push(t);
            }
        }
        found
    }

    /// Whether any of its modes has a shape.
    pub fn has_shapes(&self) -> bool {
        self.modes.modes.iter().any(|mode| !mode.shape.is_empty())
    }

    /// Pairs with the roots of a model: by [`pair`] where there are shapes, else by frequency.
    pub fn root_pairs(
        &self,
        configuration: usize,
        theory: &ModalModel,
        targets: &[Target],
        options: &PairOptions,
    ) -> Result<Vec<RootPair>, UpdateError> {
        let mut root_pairs = if self.has_shapes() {
            self.by_shape(theory, options)?
        } else {
            self.by_frequency(theory, targets, options.max_frequency_error)
        };
        for root_pair in &mut root_pairs {
            root_pair.configuration = configuration;
            sort_ascending_by(&mut root_pair.targets, |&target| targets[target].hz);
        }
        root_pairs.sort();
        Ok(root_pairs)
    }

    fn by_shape(
        &self,
        theory: &ModalModel,
        options: &PairOptions,
    ) -> Result<Vec<RootPair>, UpdateError> {
        let pairing = pair(&self.modes, theory, options)?;
        let mut root_pairs: Vec<RootPair> = Vec::new();
        for found in pairing.pairs {
            let mut targets: Vec<usize> =
                found.partners.iter().map(|p| self.target[p.test]).collect();
            targets.dedup();
            let shares =
                |root_pair: &RootPair| root_pair.targets.iter().any(|t| targets.contains(t));
            match root_pairs.iter_mut().find(|root_pair| shares(root_pair)) {
                Some(root_pair) => {
                    root_pair.modes.extend(found.theory);
                    root_pair.modes.sort_unstable();
                    targets.retain(|t| !root_pair.targets.contains(t));
                    root_pair.targets.extend(targets);
                }
                None => root_pairs.push(RootPair {
                    configuration: 0,
                    targets,
                    modes: found.theory,
                }),
            }
        }
        Ok(root_pairs)
    }

    /// Without shapes: the assignment with the smallest sum of `ln^2(f_model/f_test)` inside the
    /// gate, a root of stated multiplicity to roots of that multiplicity alone.
    fn by_frequency(&self, theory: &ModalModel, targets: &[Target], gate: f64) -> Vec<RootPair> {
        let mut measured = self.target.clone();
        measured.dedup();
        let rigid_hz = highest_rigid_hz(theory);
        let elastic = |modes: &Vec<usize>| theory.modes[modes[0]].frequency_hz > rigid_hz;
        let roots: Vec<Vec<usize>> = theory.roots().into_iter().filter(elastic).collect();
        let states_groups = measured.iter().any(|&t| targets[t].modes.len() > 1);
        // Where the list does not group its modes by root, a root is paired with as many measured
        // ones as it has modes.
        let places = |r: usize| if states_groups { 1 } else { roots[r].len() };
        let columns: Vec<usize> = (0..roots.len())
            .flat_map(|r| std::iter::repeat_n(r, places(r)))
            .collect();
        let cost = |t: usize, root: &[usize]| {
            let target = &targets[t];
            let fits = !states_groups || target.modes.len() == root.len();
            let distance = (theory.modes[root[0]].frequency_hz / target.hz).ln() / gate.ln_1p();
            Some(distance * distance).filter(|cost| fits && *cost <= 1.0)
        };
        let row = |&t: &usize| columns.iter().map(|&r| cost(t, &roots[r])).collect();
        let costs: Vec<Vec<Option<f64>>> = measured.iter().map(row).collect();
        let chosen: Vec<Option<usize>> = assign(&costs, 1.0)
            .into_iter()
            .map(|column| column.map(|c| columns[c]))
            .collect();
        let root_pair = |(r, modes): (usize, &Vec<usize>)| {
            let pairs = measured.iter().zip(&chosen);
            let here = pairs.filter(|(_, root)| **root == Some(r));
            RootPair {
                configuration: 0,
                targets: here.map(|(&t, _)| t).collect(),
                modes: modes.clone(),
            }
        };
        let root_pairs = roots.iter().enumerate().map(root_pair);
        root_pairs
            .filter(|root_pair| !root_pair.targets.is_empty())
            .collect()
    }
}

/// The same root pairs with all modes of every repeated root of which they hold some: part of a
/// repeated root has neither shapes nor derivatives. Pairs of one test with one root are joined.
pub(super) fn with_whole_roots(
    root_pairs: Vec<RootPair>,
    targets: &[Target],
    states: &[ModelState],
) -> Vec<RootPair> {
    let test = |root_pair: &RootPair| root_pair.targets.first().map(|&t| targets[t].test);
    let mut whole: Vec<RootPair> = Vec::with_capacity(root_pairs.len());
    for mut root_pair in root_pairs {
        let modes = &states[root_pair.configuration].modes;
        let bits = |k: usize| modes.omega_rad_s[k].to_bits();
        let members: Vec<u64> = root_pair.modes.iter().map(|&k| bits(k)).collect();
        let all = (0..modes.omega_rad_s.len()).filter(|&k| members.contains(&bits(k)));
        root_pair.modes = all.collect();
        let meets = |other: &RootPair, root_pair: &RootPair| {
            test(other) == test(root_pair)
                && other.modes.iter().any(|k| root_pair.modes.contains(k))
        };
        while let Some(place) = whole.iter().position(|other| meets(other, &root_pair)) {
            let other = whole.remove(place);
            root_pair.modes.extend(other.modes);
            root_pair.targets.extend(other.targets);
        }
        root_pair.modes.sort_unstable();
        root_pair.modes.dedup();
        sort_ascending_by(&mut root_pair.targets, |&target| targets[target].hz);
        whole.push(root_pair);
    }
    whole.sort();
    whole
}

/// The same root pairs without modes that no sensor of their targets reads, where others are read:
/// they belonged to a repeated root that has split.
pub(super) fn without_unseen(
    mut root_pairs: Vec<RootPair>,
    targets: &[Target],
    states: &[ModelState],
) -> Vec<RootPair> {
    for root_pair in root_pairs
        .iter_mut()
        .filter(|root_pair| root_pair.modes.len() > 1)
    {
        let modes = &states[root_pair.configuration].modes;
        let shapes = root_pair.targets.iter();
        let shapes: Vec<_> = shapes.filter_map(|&t| targets[t].shapes.as_ref()).collect();
        let squared = |k: usize| -> f64 {
            let of = |rows: &&TargetShapes| (&rows.rows * modes.vectors.col(k)).squared_norm_l2();
            shapes.iter().map(of).sum()
        };
        let most = root_pair
            .modes
            .iter()
            .map(|&k| squared(k))
            .fold(0.0, f64::max);
        if most > 0.0 {
            root_pair
                .modes
                .retain(|&k| squared(k) > ROUND_OFF_SHAPE_RATIO * ROUND_OFF_SHAPE_RATIO * most);
        }
    }
    root_pairs
}

/// The same root pairs after the modes of the model have changed. Every mode is followed to the
/// mode with the largest share of its shape, `(phi^T M phi')^2` with `M` the mass matrix of before,
/// of a repeated root the share inside its subspace. All modes are assigned together, so that none
/// is assigned twice.
pub(super) fn follow(
    root_pairs: &[RootPair],
    before: &TheoryModes,
    mass: &RealMatrix,
    after: &TheoryModes,
) -> Vec<RootPair> {
    let mut followed: Vec<(usize, &[usize])> = Vec::new();
    for root_pair in root_pairs {
        for &mode in &root_pair.modes {
            if !followed.iter().any(|(known, _)| *known == mode) {
                followed.push((mode, &root_pair.modes));
            }
        }
    }
    let moved = mass * &after.vectors;
    let n = moved.nrows();
    let product = |i0: usize, k: usize| -> f64 {
        let parts = (0..n).map(|i| before.vectors[(i, i0)] * moved[(i, k)]);
        parts.sum()
    };
    let share = |cluster: &[usize], k: usize| -> f64 {
        cluster.iter().map(|&i0| product(i0, k).powi(2)).sum()
    };
    let count = after.omega_rad_s.len();
    let shares: Vec<Vec<f64>> = followed
        .iter()
        .map(|(_, cluster)| (0..count).map(|k| share(cluster, k)).collect())
        .collect();
    let cost = |share: &f64| (*share > MIN_TRACKED_SHARE).then_some((1.0 - share).max(0.0));
    let costs: Vec<Vec<Option<f64>>> = shares
        .iter()
        .map(|row| row.iter().map(cost).collect())
        .collect();
    let chosen = assign(&costs, 1.0);
    let new = |mode: usize| {
        let place = followed.iter().position(|(known, _)| *known == mode);
        place.and_then(|place| chosen[place]).unwrap_or(mode)
    };
    let root_pair = |root_pair: &RootPair| {
        let mut modes: Vec<usize> = root_pair.modes.iter().map(|&mode| new(mode)).collect();
        modes.sort_unstable();
        RootPair {
            modes,
            ..root_pair.clone()
        }
    };
    root_pairs.iter().map(root_pair).collect()
}
