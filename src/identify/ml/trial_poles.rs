//! The test of trial poles, at residual peaks and as close pairs, refits with them and keeps those
//! that lower the residual enough.

use num_complex::Complex64;

use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::residual::Residual;
use crate::identify::fit::block_descent::{Convergence, mark_unconverged};
use crate::identify::fit::detection_threshold::upper_quantile;
use crate::identify::ml::close_pole_test::close_pair_candidates;
use crate::identify::ml::residual_peaks::residual_peak_poles;
use crate::identify::noise::line_correlation::LineCorrelation;
use crate::identify::pole_model::PoleModel;
use crate::identify::pole_model::acceptance::{PoleEdit, remove_or_reduce};
use crate::identify::pole_model::findings::{DropReason, Dropped};

/// Minimum of the limit of trial poles in one search; the limit is a quarter of the number of
/// poles. More trial poles would mean misfit rather than missing modes.
const MIN_TRIAL_POLES: usize = 4;
/// Factor by which a search must lower the residual energy; below it, trial poles with a reason for
/// rejection are removed.
pub(in crate::identify) const MIN_RESIDUAL_GAIN: f64 = 2.0;
/// Minimum separation of a close pair, half-power bandwidths: a single pole that shifts as much
/// from FRF to FRF, by the mass of a sensor or between hits, has the same residual.
const MIN_SEPARATION_BANDWIDTHS: f64 = 0.04;

/// Standard deviation over decay rate below which a pole is well determined.
const MAX_STD_WELL_DETERMINED: f64 = 0.05;
/// One in this number of the other poles is removed at once.
const REMOVE_ONE_IN: usize = 4;

impl PoleModel {
    /// Detects noise that is correlated between frequency lines
    /// (`NoiseModel::detect_correlated_noise`). Poles that were fitted to such noise are removed,
    /// the least determined first, and the noise is estimated again with their contribution; the
    /// search finds modes among them again. Where the residual without these poles is no noise, all
    /// changes are undone.
    pub fn detect_correlated_noise(&mut self) -> bool {
        let before = self.snapshot_with_noise();
        if !self.data.detect_correlated_noise(&mut self.residual()) {
            return false;
        }
        self.reestimate_noise_and_prune();
        loop {
            if !LineCorrelation::frfs_have_independent_noise(&self.residual()) {
                self.restore(before);
                self.refine_and_prune(Convergence::ResidualTest);
                return false;
            }
            let relative_std = |pole: &ModelPole| pole.quality.pole_std / pole.decay();
            let mut undetermined_stds: Vec<f64> = self.poles.iter().map(relative_std).collect();
            undetermined_stds.retain(|ratio| *ratio >= MAX_STD_WELL_DETERMINED);
            undetermined_stds.sort_by(f64::total_cmp);
            let Some(limit) = undetermined_stds
                .get(undetermined_stds.len() * (REMOVE_ONE_IN - 1) / REMOVE_ONE_IN)
            else {
                return true;
            };
            let (kept, removed): (Vec<ModelPole>, Vec<ModelPole>) = std::mem::take(&mut self.poles)
                .into_iter()
                .partition(|pole| relative_std(pole) < *limit);
            self.dropped.extend(removed.iter().map(|pole| Dropped {
                lambda: pole.lambda,
                reason: DropReason::PoleUndetermined(pole.quality.pole_std / pole.decay()),
            }));
            // The other pole of a close pair is a single pole again.
            self.poles = kept
                .into_iter()
                .map(|pole| ModelPole { pair: None, ..pole })
                .collect();
            self.reestimate_noise_and_prune();
        }
    }

    /// Tries poles where the residual exceeds the noise. Returns the factor by which the residual
    /// energy fell, `None` when no trial pole was kept.
    pub fn search(&mut self) -> Option<f64> {
        let false_alarm_probability = self.options.false_alarm_probability;
        let residual = self.residual();
        let found = residual_peak_poles(
            &self.data,
            &self.frf_matrix,
            &self.poles,
            &residual,
            false_alarm_probability,
            self.max_trial_poles(),
        );
        if found.is_empty() {
            return self.split_close_pairs(&residual);
        }
        self.try_poles(found, &residual)
            .or_else(|| self.split_close_pairs(&self.residual()))
    }

    /// Whether the residual exceeds the noise: in a segment of lines, or as a close pair.
    pub fn has_unexplained_residual(&self) -> bool {
        let (data, frf_matrix, poles) = (&self.data, &self.frf_matrix, &self.poles);
        let (residual, probability) = (self.residual(), self.options.false_alarm_probability);
        let peaks = residual_peak_poles(data, frf_matrix, poles, &residual, probability, 1);
        !peaks.is_empty()
            || !close_pair_candidates(data, frf_matrix, poles, &residual, probability).is_empty()
    }

    fn max_trial_poles(&self) -> usize {
        (self.poles.len() / 4).max(MIN_TRIAL_POLES)
    }

    fn modes(&self) -> usize {
        self.poles.iter().map(ModelPole::multiplicity).sum()
    }

    /// As [`Self::search`], with given trial poles, from the residual without them.
    fn try_poles(&mut self, found: Vec<ModelPole>, residual: &Residual) -> Option<f64> {
        let (before, modes) = (self.snapshot(), self.modes());
        self.poles.extend(found.into_iter().map(|pole| ModelPole {
            suspect: true,
            ..pole
        }));
        mark_unconverged(&mut self.poles);
        self.refine_and_prune(Convergence::Coarse);
        let gain = |fit: &Self| residual.energy() / fit.residual().energy();
        let mut now = gain(self);
        if now < MIN_RESIDUAL_GAIN && self.reject_trial_poles() {
            self.refine_and_prune(Convergence::Coarse);
            now = if self.modes() > modes {
                gain(self)
            } else {
                0.0
            };
        }
        if now < 1.0 {
            // Trial poles displaced other poles, or none of them was kept.
            self.restore(before);
            return None;
        }
        for pole in &mut self.poles {
            pole.suspect = false;
        }
        (self.modes() > modes).then_some(now)
    }

    /// Splits poles that stand for a close pair. Returns the factor by which the residual energy
    /// fell, `None` when no pole was split.
    ///
    /// Two poles closer than the standard deviation of their distance can still be separated from
    /// one pole by the residual: a second pole must lower it by more than its number of unknowns
    /// does in noise.
    fn split_close_pairs(&mut self, residual: &Residual) -> Option<f64> {
        let false_alarm_probability = self.options.false_alarm_probability;
        let found = close_pair_candidates(
            &self.data,
            &self.frf_matrix,
            &self.poles,
            residual,
            false_alarm_probability,
        );
        let lambdas: Vec<Complex64> = self.poles.iter().map(|pole| pole.lambda).collect();
        let false_alarm_probability = false_alarm_probability / lambdas.len().max(1) as f64;
        let (first, most) = (self.residual_energy(residual), self.max_trial_poles());
        let mut residual_energy = first;
        for (index, second) in found.into_iter().take(most) {
            let distance = |pole: &ModelPole| (pole.lambda - lambdas[index]).norm();
            let free = |j: &usize| self.poles[*j].pair.is_none();
            let nearest = (0..self.poles.len())
                .filter(free)
                .min_by(|a, b| distance(&self.poles[*a]).total_cmp(&distance(&self.poles[*b])));
            // Other poles may have moved to its location since.
            let near = |j: &usize| distance(&self.poles[*j]) < self.poles[*j].decay();
            let Some(j) = nearest.filter(near) else {
                continue;
            };
            let before = self.snapshot();
            match self.try_close_pair(j, second, residual_energy, false_alarm_probability) {
                Some(now) => residual_energy = now,
                None => self.restore(before),
            }
        }
        (residual_energy < first).then_some(first / residual_energy)
    }

    /// Residual energy with a second pole near one; `None` where it does not fall enough, or where
    /// the second pole is no mode.
    fn try_close_pair(
        &mut self,
        j: usize,
        second: ModelPole,
        residual_energy: f64,
        false_alarm_probability: f64,
    ) -> Option<f64> {
        let pairs = self.poles.iter().filter_map(|pole| pole.pair);
        let pair = Some(pairs.max().map_or(0, |last| last + 1));
        let modes = self.modes();
        let decay = second.decay();
        self.poles[j].pair = pair;
        self.poles.push(ModelPole {
            suspect: true,
            pair,
            ..second
        });
        self.refine_and_prune(Convergence::ResidualTest);
        let members: Vec<&ModelPole> = self.poles.iter().filter(|pole| pole.pair == pair).collect();
        let [a, b] = members[..] else { return None };
        let apart = (a.lambda - b.lambda).norm() / a.width().min(b.width());
        let now = self.residual_energy(&self.residual());
        let unknowns = 2 * (self.frf_matrix.outputs.len() + self.frf_matrix.inputs);
        let correlation_factor = self
            .data
            .noise
            .line_correlation
            .amplitude_noise_factor(decay, self.data.frfs.step);
        let enough = correlation_factor * upper_quantile(unknowns as f64, false_alarm_probability);
        if apart < MIN_SEPARATION_BANDWIDTHS
            || 2.0 * (residual_energy - now) <= enough
            || self.modes() <= modes
        {
            return None;
        }
        if self.reject_trial_poles() {
            return None;
        }
        self.poles.iter_mut().for_each(|pole| pole.suspect = false);
        Some(now)
    }

    /// Residual energy over the noise, without the force noise that FRFs have in common.
    fn residual_energy(&self, residual: &Residual) -> f64 {
        let energies = self
            .data
            .noise
            .noise_weighted_energy_by_line(&self.data.frfs, residual);
        energies.iter().sum()
    }

    /// Removes trial poles with a reason for rejection. Returns whether there were any.
    fn reject_trial_poles(&mut self) -> bool {
        let rejection_reasons = self.rejection_reasons();
        let changes: Vec<PoleEdit> = (0..self.poles.len())
            .filter(|j| self.poles[*j].suspect)
            .filter_map(|j| {
                Some(remove_or_reduce(
                    &self.poles,
                    j,
                    DropReason::Rejected(rejection_reasons[j]?),
                ))
            })
            .collect();
        for change in &changes {
            self.apply(*change);
        }
        self.poles.retain(|pole| !pole.parts.is_empty());
        mark_unconverged(&mut self.poles);
        !changes.is_empty()
    }
}
