//! Roots that are no modes although they are above the noise: they go, weakest first.

use crate::identify::data::model_pole::Root;
use crate::identify::fit::block_descent::{Stop, apart, unsettle};
use crate::identify::ml::acceptance::{KNOWN, less};
use crate::identify::ml::estimator::Fit;
use crate::identify::ml::findings::{Dropped, Reason};
use crate::identify::ml::pole_metrics::{Doubt, Scrutiny, doubt, missed, phases_scatter};

/// Rounds of dropping what is doubtful.
const DOUBTS: usize = 30;
/// Doubtful roots, and a tenth of all roots, from which on the model misses the data.
const SEVERAL: usize = 2;
/// One in so many doubtful roots goes at once where phases scatter.
const GO_AT_ONCE: usize = 3;
/// Factor of what the model misses from which on a dropped root is needed.
const NEEDED: f64 = 10.0;
/// Roots within so many sums of half-power widths of a dropped one are judged again without it.
const LEANING: f64 = 2.0;

impl Fit {
    /// Drops, weakest first, what is no mode although it is above the noise: see [`doubt`].
    ///
    /// Where the model describes the data, suspects are told once, with all roots in: without one
    /// of them the others explain the data less. Where it misses them in several places, everything
    /// is looked at again each time. Where phases scatter, part of the doubtful go at a time, as
    /// those that are left explain more then, and what they leave over counts as noise.
    pub fn doubt(&mut self) {
        let doubts = self.doubts();
        let scrutiny = if phases_scatter(&self.roots, &self.standings()) {
            Scrutiny::Scattered
        } else if self.misses_data(&doubts) {
            Scrutiny::Strict
        } else {
            Scrutiny::Mild
        };
        for (root, doubt) in self.roots.iter_mut().zip(doubts) {
            root.suspect = scrutiny != Scrutiny::Mild || doubt.is_some();
        }
        for _ in 0..DOUBTS {
            let standings = self.standings();
            let doubted = |j: usize| {
                let doubt = doubt(&self.roots, &standings, (j, scrutiny))?;
                self.roots[j].suspect.then_some((j, doubt))
            };
            let mut order: Vec<(usize, Doubt)> =
                (0..self.roots.len()).filter_map(doubted).collect();
            order.sort_by(|a, b| standings[a.0].share.total_cmp(&standings[b.0].share));
            let mut chosen: Vec<(usize, Doubt)> = Vec::new();
            for (j, doubt) in order {
                let leans = |(other, _): &(usize, Doubt)| {
                    apart(&self.roots[j], &self.roots[*other]) < LEANING
                };
                if !chosen.iter().any(leans) {
                    chosen.push((j, doubt));
                }
            }
            if chosen.is_empty() {
                break;
            }
            if scrutiny == Scrutiny::Scattered {
                self.scattered.get_or_insert(self.roots.len());
                chosen.truncate(chosen.len().div_ceil(GO_AT_ONCE));
            }
            let tried: Vec<(Root, f64)> = chosen
                .iter()
                .map(|(j, _)| (self.roots[*j].clone(), standings[*j].misfit))
                .collect();
            for (j, doubt) in chosen {
                self.apply(less(&self.roots, j, Reason::Doubt(doubt)));
            }
            self.roots.retain(|root| !root.parts.is_empty());
            unsettle(&mut self.roots);
            self.settle(Stop::Coarse);
            if scrutiny == Scrutiny::Scattered {
                self.data.count_misfit_as_noise();
                self.judge_by_noise();
            } else {
                self.restore(&tried);
            }
        }
        if self.moved.any() {
            self.drop_unknown();
        }
    }

    /// Drops roots whose poles are not known beside what the model misses: runs that were brought
    /// together leave over more than noise.
    fn drop_unknown(&mut self) {
        let standings = self.standings();
        let part = |j: usize| {
            let root = &self.roots[j];
            root.quality.pole_std * standings[j].inflation() / root.decay()
        };
        let parts = (0..self.roots.len()).map(|j| (j, part(j)));
        let unknown: Vec<(usize, f64)> = parts.filter(|(_, part)| *part >= KNOWN).collect();
        if unknown.is_empty() {
            return;
        }
        for (j, part) in unknown {
            self.apply(less(&self.roots, j, Reason::Unknown(part)));
        }
        self.roots.retain(|root| !root.parts.is_empty());
        unsettle(&mut self.roots);
        self.settle(Stop::Coarse);
    }

    /// Takes back, for good, single roots without which the model misses far more of the data than
    /// with them, away from others: two roots in one resonance explain what one does not, whatever
    /// made it.
    fn restore(&mut self, tried: &[(Root, f64)]) {
        let described = self.data.far().beside(&self.data, &self.roots);
        let needed = |(root, before): &&(Root, f64)| {
            let away = self.roots.iter().all(|other| apart(root, other) > 1.0);
            let now = missed(&self.data, &described, root);
            root.multiplicity() == 1 && away && now > NEEDED * before.max(1.0)
        };
        let needed: Vec<Root> = tried
            .iter()
            .filter(needed)
            .map(|(root, _)| root.clone())
            .collect();
        if needed.is_empty() {
            return;
        }
        let back = |dropped: &Dropped| needed.iter().any(|root| root.lambda == dropped.lambda);
        self.dropped.retain(|dropped| !back(dropped));
        self.roots.extend(needed.into_iter().map(|root| Root {
            suspect: false,
            ..root
        }));
        unsettle(&mut self.roots);
        self.settle(Stop::Coarse);
    }

    pub fn doubts(&self) -> Vec<Option<Doubt>> {
        let standings = self.standings();
        (0..self.roots.len())
            .map(|j| doubt(&self.roots, &standings, (j, Scrutiny::Mild)))
            .collect()
    }

    /// Whether roots are doubtful in several places because the model misses the data, or many are
    /// no modes of the structure that the strongest belong to.
    pub fn misses_data(&self, doubts: &[Option<Doubt>]) -> bool {
        let misses = doubts.iter().flatten().filter(|doubt| doubt.is_misfit());
        misses.count() >= SEVERAL.max(self.roots.len() / 10)
            || phases_scatter(&self.roots, &self.standings())
    }
}
