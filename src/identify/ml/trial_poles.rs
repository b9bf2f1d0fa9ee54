//! Roots that a fit tries where it leaves over more than noise.

use num_complex::Complex64;

use crate::identify::data::model_pole::Root;
use crate::identify::data::residual::Rest;
use crate::identify::fit::block_descent::{Stop, unsettle};
use crate::identify::fit::detection_threshold::upper_quantile;
use crate::identify::ml::acceptance::{Change, less};
use crate::identify::ml::close_pole_test::roots_to_double;
use crate::identify::ml::estimator::Fit;
use crate::identify::ml::findings::{Dropped, Reason};
use crate::identify::ml::residual_peaks::roots_to_try;
use crate::identify::noise::line_correlation::Correlation;

/// Roots that a search may try at once: a quarter of those that are there, and so many at least.
/// More would mean that the model misses the data, not that modes are missing.
const FEWEST_TRIED: usize = 4;
/// Factor by which a search must lessen what is left over where it leaves doubts.
pub(in crate::identify) const WORTHWHILE: f64 = 2.0;
/// Least distance of two roots that one is doubled into, half-power widths: a pole that moves so
/// far from function to function, by the mass of a sensor or from hit to hit, leaves over the same.
const LEAST_APART: f64 = 0.04;

/// A pole is well known, in decay rates.
const WELL_KNOWN: f64 = 0.05;
/// One in so many of the others goes at once.
const GO_AT_ONCE: usize = 4;

impl Fit {
    /// Whether what is left over is noise that lines share
    /// ([`Receptances::lines_share_noise`](crate::identify::data::band_frfs::Receptances::lines_share_noise)).
    /// Roots that were fitted to what is now noise go, the least known first, and the noise has
    /// back what they took; what stands out all the same, the search finds. Where what is left over
    /// without them is no noise any more, nothing of that holds.
    pub fn lines_share_noise(&mut self) -> bool {
        let (noise, roots, drops_before) =
            (self.data.noise(), self.roots.clone(), self.dropped.len());
        if !self.data.lines_share_noise(&mut self.rest()) {
            return false;
        }
        self.judge_by_noise();
        loop {
            if !Correlation::functions_differ(&self.rest()) {
                self.data.set_noise(noise);
                self.roots = roots;
                self.dropped.truncate(drops_before);
                self.settle(Stop::Judging);
                return false;
            }
            let unknown = |root: &Root| root.quality.pole_std / root.decay();
            let mut doubtful: Vec<f64> = self.roots.iter().map(unknown).collect();
            doubtful.retain(|ratio| *ratio >= WELL_KNOWN);
            doubtful.sort_by(f64::total_cmp);
            let Some(limit) = doubtful.get(doubtful.len() * (GO_AT_ONCE - 1) / GO_AT_ONCE) else {
                return true;
            };
            let (known, unknown): (Vec<Root>, Vec<Root>) = std::mem::take(&mut self.roots)
                .into_iter()
                .partition(|root| unknown(root) < *limit);
            self.dropped.extend(unknown.iter().map(|root| Dropped {
                lambda: root.lambda,
                reason: Reason::Unknown(root.quality.pole_std / root.decay()),
            }));
            // Of two that one was doubled into, the other is free again.
            self.roots = known
                .into_iter()
                .map(|root| Root { pair: None, ..root })
                .collect();
            self.judge_by_noise();
        }
    }

    /// Tries roots where the fit leaves over what noise does not explain; by what factor that
    /// became less, `None` when none stayed.
    pub fn search(&mut self) -> Option<f64> {
        let chance = self.options.false_alarm_probability;
        let rest = self.rest();
        let frfs = (&self.data, &self.sides);
        let found = roots_to_try(frfs, &self.roots, &rest, (chance, self.most_tried()));
        if found.is_empty() {
            return self.double(&rest);
        }
        self.try_roots(found, &rest)
            .or_else(|| self.double(&self.rest()))
    }

    /// Whether what the fit leaves over is more than noise: in some stretch, or of a double pole.
    pub fn leaves_more_than_noise(&self) -> bool {
        let chance = self.options.false_alarm_probability;
        let (frfs, rest) = ((&self.data, &self.sides), self.rest());
        !roots_to_try(frfs, &self.roots, &rest, (chance, 1)).is_empty()
            || !roots_to_double(frfs, &self.roots, &rest, chance).is_empty()
    }

    fn most_tried(&self) -> usize {
        (self.roots.len() / 4).max(FEWEST_TRIED)
    }

    fn modes(&self) -> usize {
        self.roots.iter().map(Root::multiplicity).sum()
    }

    /// As [`Self::search`], with these roots, from what is left over without them.
    fn try_roots(&mut self, found: Vec<Root>, rest: &Rest) -> Option<f64> {
        let (before, modes, drops_before) = (self.roots.clone(), self.modes(), self.dropped.len());
        self.roots.extend(found.into_iter().map(|root| Root {
            suspect: true,
            ..root
        }));
        unsettle(&mut self.roots);
        self.settle(Stop::Coarse);
        let gain = |fit: &Self| rest.energy() / fit.rest().energy();
        let mut now = gain(self);
        if now < WORTHWHILE && self.drop_doubtful_tries() {
            self.settle(Stop::Coarse);
            now = if self.modes() > modes {
                gain(self)
            } else {
                0.0
            };
        }
        if now < 1.0 {
            // New roots drove others away, or none of them stayed.
            self.roots = before;
            self.dropped.truncate(drops_before);
            return None;
        }
        for root in &mut self.roots {
            root.suspect = false;
        }
        (self.modes() > modes).then_some(now)
    }

    /// Doubles roots that stand for two; by what factor what is left over became less, `None` when
    /// none did.
    ///
    /// Two poles that lie closer together than their distance is known to may be told from one all
    /// the same: by what one leaves over, which must become less by more than so many unknowns make
    /// of noise.
    fn double(&mut self, rest: &Rest) -> Option<f64> {
        let chance = self.options.false_alarm_probability;
        let frfs = (&self.data, &self.sides);
        let found = roots_to_double(frfs, &self.roots, rest, chance);
        let lambdas: Vec<Complex64> = self.roots.iter().map(|root| root.lambda).collect();
        let chance = chance / lambdas.len().max(1) as f64;
        let (first, most) = (self.left(rest), self.most_tried());
        let mut left = first;
        for (index, second) in found.into_iter().take(most) {
            let distance = |root: &Root| (root.lambda - lambdas[index]).norm();
            let free = |j: &usize| self.roots[*j].pair.is_none();
            let nearest = (0..self.roots.len())
                .filter(free)
                .min_by(|a, b| distance(&self.roots[*a]).total_cmp(&distance(&self.roots[*b])));
            // Others that moved since may have taken its place.
            let near = |j: &usize| distance(&self.roots[*j]) < self.roots[*j].decay();
            let Some(j) = nearest.filter(near) else {
                continue;
            };
            let (before, drops_before) = (self.roots.clone(), self.dropped.len());
            match self.doubled((j, second), (left, chance)) {
                Some(now) => left = now,
                None => {
                    self.roots = before;
                    self.dropped.truncate(drops_before);
                }
            }
        }
        (left < first).then_some(first / left)
    }

    /// What is left over with a second root beside one; `None` where that is not worth it, or not a
    /// mode.
    fn doubled(&mut self, (j, second): (usize, Root), (left, chance): (f64, f64)) -> Option<f64> {
        let pairs = self.roots.iter().filter_map(|root| root.pair);
        let pair = Some(pairs.max().map_or(0, |last| last + 1));
        let modes = self.modes();
        let decay = second.decay();
        self.roots[j].pair = pair;
        self.roots.push(Root {
            suspect: true,
            pair,
            ..second
        });
        self.settle(Stop::Judging);
        let members: Vec<&Root> = self.roots.iter().filter(|root| root.pair == pair).collect();
        let [a, b] = members[..] else { return None };
        let apart = (a.lambda - b.lambda).norm() / a.width().min(b.width());
        let now = self.left(&self.rest());
        let unknowns = 2 * (self.sides.outputs.len() + self.sides.inputs);
        let alike = self.data.correlation.of_amplitude(decay, self.data.step);
        let enough = alike * upper_quantile(unknowns as f64, chance);
        if apart < LEAST_APART || 2.0 * (left - now) <= enough || self.modes() <= modes {
            return None;
        }
        if self.drop_doubtful_tries() {
            return None;
        }
        self.roots.iter_mut().for_each(|root| root.suspect = false);
        Some(now)
    }

    /// Energy of what is left over, over the noise, as far as functions do not share it.
    fn left(&self, rest: &Rest) -> f64 {
        let held = self.data.shared.held_by_line(&self.data, rest);
        held.iter().sum()
    }

    /// Takes modes that a search tried out again where something speaks against them; whether there
    /// were any.
    fn drop_doubtful_tries(&mut self) -> bool {
        let doubts = self.doubts();
        let changes: Vec<Change> = (0..self.roots.len())
            .filter(|j| self.roots[*j].suspect)
            .filter_map(|j| Some(less(&self.roots, j, Reason::Doubt(doubts[j]?))))
            .collect();
        for change in &changes {
            self.apply(*change);
        }
        self.roots.retain(|root| !root.parts.is_empty());
        unsettle(&mut self.roots);
        !changes.is_empty()
    }
}
