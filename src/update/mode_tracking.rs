//! Mode tracking pairs measured modes with modes of the model at the start and follows them by
//! shape.

use crate::correlate::{PairOptions, assign, highest_rigid_hz, pair};
use crate::linalg::RealMatrix;
use crate::modal::ModalModel;
use crate::theory::TheoryModes;

use super::target_shapes::TargetShapes;
use super::{Target, UpdateError};

/// Shares below this are not looked at when modes are followed.
const NO_SHARE: f64 = 1e-3;

/// Size of a shape at the sensors, over that of the largest in its link, that is rounding.
const UNSEEN: f64 = 1e-6;

/// Measured roots that meet one root of the model.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Link {
    /// Indices of the targets, ascending in frequency.
    pub targets: Vec<usize>,
    /// Indices, ascending, of the modes of the model; several where they are one repeated root at
    /// the start.
    pub modes: Vec<usize>,
}

/// A test as pairing sees it: the modes of its targets alone.
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

    /// Links to a model: by [`pair`] where there are shapes, else by frequency.
    pub fn links(
        &self,
        theory: &ModalModel,
        targets: &[Target],
        options: &PairOptions,
    ) -> Result<Vec<Link>, UpdateError> {
        let shaped = self.modes.modes.iter().any(|mode| !mode.shape.is_empty());
        let mut links = if shaped {
            self.by_shape(theory, options)?
        } else {
            self.by_frequency(theory, targets, options.max_frequency_error)
        };
        for link in &mut links {
            link.targets
                .sort_by(|&a, &b| targets[a].hz.total_cmp(&targets[b].hz));
        }
        links.sort();
        Ok(links)
    }

    fn by_shape(
        &self,
        theory: &ModalModel,
        options: &PairOptions,
    ) -> Result<Vec<Link>, UpdateError> {
        let pairing = pair(&self.modes, theory, options)?;
        let mut links: Vec<Link> = Vec::new();
        for found in pairing.pairs {
            let mut targets: Vec<usize> =
                found.partners.iter().map(|p| self.target[p.test]).collect();
            targets.dedup();
            let shares = |link: &Link| link.targets.iter().any(|t| targets.contains(t));
            match links.iter_mut().find(|link| shares(link)) {
                Some(link) => {
                    link.modes.extend(found.theory);
                    link.modes.sort_unstable();
                    targets.retain(|t| !link.targets.contains(t));
                    link.targets.extend(targets);
                }
                None => links.push(Link {
                    targets,
                    modes: found.theory,
                }),
            }
        }
        Ok(links)
    }

    /// Without shapes: the assignment with the smallest sum of `ln^2(f_model/f_test)` inside the
    /// gate, a root of stated multiplicity to roots of that multiplicity alone.
    fn by_frequency(&self, theory: &ModalModel, targets: &[Target], gate: f64) -> Vec<Link> {
        let mut measured = self.target.clone();
        measured.dedup();
        let rigid_hz = highest_rigid_hz(theory);
        let elastic = |modes: &Vec<usize>| theory.modes[modes[0]].frequency_hz > rigid_hz;
        let roots: Vec<Vec<usize>> = theory.roots().into_iter().filter(elastic).collect();
        let states_groups = measured.iter().any(|&t| targets[t].modes.len() > 1);
        // A root takes as many measured ones as it has modes where the list does not say which
        // belong together.
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
        let link = |(r, modes): (usize, &Vec<usize>)| {
            let pairs = measured.iter().zip(&chosen);
            let here = pairs.filter(|(_, root)| **root == Some(r));
            Link {
                targets: here.map(|(&t, _)| t).collect(),
                modes: modes.clone(),
            }
        };
        let links = roots.iter().enumerate().map(link);
        links.filter(|link| !link.targets.is_empty()).collect()
    }
}

/// The same links with all modes of every repeated root of which they hold some: part of one has
/// neither shapes nor derivatives. Links of one test that meet in a root become one.
pub(super) fn with_whole_roots(
    links: Vec<Link>,
    targets: &[Target],
    modes: &TheoryModes,
) -> Vec<Link> {
    let bits = |k: usize| modes.omega_rad_s[k].to_bits();
    let test = |link: &Link| link.targets.first().map(|&t| targets[t].test);
    let mut whole: Vec<Link> = Vec::with_capacity(links.len());
    for mut link in links {
        let members: Vec<u64> = link.modes.iter().map(|&k| bits(k)).collect();
        let all = (0..modes.omega_rad_s.len()).filter(|&k| members.contains(&bits(k)));
        link.modes = all.collect();
        let meets = |other: &Link, link: &Link| {
            test(other) == test(link) && other.modes.iter().any(|k| link.modes.contains(k))
        };
        while let Some(place) = whole.iter().position(|other| meets(other, &link)) {
            let other = whole.remove(place);
            link.modes.extend(other.modes);
            link.targets.extend(other.targets);
        }
        link.modes.sort_unstable();
        link.modes.dedup();
        link.targets
            .sort_by(|&a, &b| targets[a].hz.total_cmp(&targets[b].hz));
        whole.push(link);
    }
    whole.sort();
    whole
}

/// The same links without modes that no sensor of their targets reads, where others are read: those
/// came with a root that is one no more.
pub(super) fn without_unseen(
    mut links: Vec<Link>,
    targets: &[Target],
    modes: &TheoryModes,
) -> Vec<Link> {
    for link in links.iter_mut().filter(|link| link.modes.len() > 1) {
        let shapes = link.targets.iter();
        let shapes: Vec<_> = shapes.filter_map(|&t| targets[t].shapes.as_ref()).collect();
        let squared = |k: usize| -> f64 {
            let of = |rows: &&TargetShapes| (&rows.rows * modes.vectors.col(k)).squared_norm_l2();
            shapes.iter().map(of).sum()
        };
        let most = link.modes.iter().map(|&k| squared(k)).fold(0.0, f64::max);
        if most > 0.0 {
            link.modes.retain(|&k| squared(k) > UNSEEN * UNSEEN * most);
        }
    }
    links
}

/// The same links after the modes of the model have changed: every mode goes where most of its
/// shape goes, `(phi^T M phi')^2` with `M` the mass matrix of before, of a repeated root the share
/// inside its subspace; all modes together, so that none is taken twice.
pub(super) fn follow(
    links: &[Link],
    before: &TheoryModes,
    mass: &RealMatrix,
    after: &TheoryModes,
) -> Vec<Link> {
    let mut followed: Vec<(usize, &[usize])> = Vec::new();
    for link in links {
        for &mode in &link.modes {
            if !followed.iter().any(|(known, _)| *known == mode) {
                followed.push((mode, &link.modes));
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
    let cost = |share: &f64| (*share > NO_SHARE).then_some((1.0 - share).max(0.0));
    let costs: Vec<Vec<Option<f64>>> = shares
        .iter()
        .map(|row| row.iter().map(cost).collect())
        .collect();
    let chosen = assign(&costs, 1.0);
    let new = |mode: usize| {
        let place = followed.iter().position(|(known, _)| *known == mode);
        place.and_then(|place| chosen[place]).unwrap_or(mode)
    };
    let link = |link: &Link| {
        let mut modes: Vec<usize> = link.modes.iter().map(|&mode| new(mode)).collect();
        modes.sort_unstable();
        Link {
            targets: link.targets.clone(),
            modes,
        }
    };
    links.iter().map(link).collect()
}
