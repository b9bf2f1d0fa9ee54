//! Spurious poles above the noise are removed, the weakest first, with a refit after each; a pole
//! that the data miss is restored.

use crate::identify::data::model_pole::ModelPole;
use crate::identify::fit::block_descent::{Convergence, mark_unconverged};
use crate::identify::pole_model::PoleModel;
use crate::identify::pole_model::acceptance::{MAX_POLE_STD_OVER_DECAY_RATE, remove_or_reduce};
use crate::identify::pole_model::findings::{DropReason, Dropped};
use crate::identify::pole_model::pole_metrics::{
    Rejection, RejectionPolicy, phases_scatter, rejection_reason, residual_chi_square,
};
use crate::linalg::sort_ascending_by;

/// Maximum rounds of rejection.
const MAX_REJECTION_ROUNDS: usize = 30;
/// Minimum number of poles with a reason for rejection (and a tenth of all poles) at which the
/// model misfits the data.
const MIN_REJECTIONS_MISFIT: usize = 2;
/// One in this number of rejected poles is removed at once where phases scatter.
const REMOVE_ONE_IN: usize = 3;
/// Factor by which the reduced chi-square rises without a pole, above which the pole is needed.
const MIN_CHI_SQUARE_INCREASE: f64 = 10.0;
/// Separation from a removed pole, in sums of half-power bandwidths, below which poles are tested
/// again without it.
const RETEST_BANDWIDTHS: f64 = 2.0;

impl PoleModel {
    /// Removes spurious poles above the noise, the weakest first: see [`rejection_reason`].
    ///
    /// Where the model fits the data, poles are flagged once, with all poles in the model: without
    /// one of them the others fit the data less. Where the model misfits the data at several poles,
    /// all poles are tested again in each round. Where phases scatter, a part of the rejected poles
    /// is removed at a time, as the contribution of the remaining ones rises, and the residual
    /// counts as noise.
    pub fn reject_spurious_poles(&mut self) {
        let rejection_reasons = self.rejection_reasons();
        let policy = if phases_scatter(&self.poles, &self.pole_metrics()) {
            RejectionPolicy::ScatteredPhases
        } else if self.model_misses_data(&rejection_reasons) {
            RejectionPolicy::Strict
        } else {
            RejectionPolicy::Standard
        };
        for (pole, rejection) in self.poles.iter_mut().zip(rejection_reasons) {
            pole.suspect = policy != RejectionPolicy::Standard || rejection.is_some();
        }
        for _ in 0..MAX_REJECTION_ROUNDS {
            let pole_metrics = self.pole_metrics();
            let rejected = |j: usize| {
                let rejection = rejection_reason(&self.poles, &pole_metrics, j, policy)?;
                self.poles[j].suspect.then_some((j, rejection))
            };
            let mut order: Vec<(usize, Rejection)> =
                (0..self.poles.len()).filter_map(rejected).collect();
            sort_ascending_by(&mut order, |(j, _)| pole_metrics[*j].contribution);
            let mut rejected: Vec<(usize, Rejection)> = Vec::new();
            for (j, rejection) in order {
                let leans = |(other, _): &(usize, Rejection)| {
                    self.poles[j].separation(&self.poles[*other]) < RETEST_BANDWIDTHS
                };
                if !rejected.iter().any(leans) {
                    rejected.push((j, rejection));
                }
            }
            if rejected.is_empty() {
                break;
            }
            if policy == RejectionPolicy::ScatteredPhases {
                self.scattered.get_or_insert(self.poles.len());
                rejected.truncate(rejected.len().div_ceil(REMOVE_ONE_IN));
            }
            let removed: Vec<(ModelPole, f64)> = rejected
                .iter()
                .map(|(j, _)| (self.poles[*j].clone(), pole_metrics[*j].reduced_chi_square))
                .collect();
            for (j, rejection) in rejected {
                self.apply(remove_or_reduce(
                    &self.poles,
                    j,
                    DropReason::Rejected(rejection),
                ));
            }
            self.poles.retain(|pole| !pole.parts.is_empty());
            mark_unconverged(&mut self.poles);
            self.refine_and_prune(Convergence::Coarse);
            if policy == RejectionPolicy::ScatteredPhases {
                self.data.noise.count_misfit_as_noise();
                self.reestimate_noise_and_prune();
            } else {
                self.reinstate_needed(&removed);
            }
        }
        if self.run_shifts.any() {
            self.drop_undetermined();
        }
    }

    /// Removes poles that are undetermined when misfit counts as noise, as the residual of aligned
    /// runs exceeds the noise, and that lie beside another pole: an isolated one is no part of a
    /// mode that shifts.
    fn drop_undetermined(&mut self) {
        let pole_metrics = self.pole_metrics();
        let ratio = |j: usize| {
            let pole = &self.poles[j];
            pole.quality.pole_std * pole_metrics[j].inflation() / pole.decay()
        };
        let ratios = (0..self.poles.len()).map(|j| (j, ratio(j)));
        let has_neighbour = |j: usize| {
            let mut others = (0..self.poles.len()).filter(|i| *i != j);
            others.any(|i| self.poles[j].separation(&self.poles[i]) < RETEST_BANDWIDTHS)
        };
        let undetermined: Vec<(usize, f64)> = ratios
            .filter(|(j, ratio)| *ratio >= MAX_POLE_STD_OVER_DECAY_RATE && has_neighbour(*j))
            .collect();
        if undetermined.is_empty() {
            return;
        }
        for (j, ratio) in undetermined {
            self.apply(remove_or_reduce(
                &self.poles,
                j,
                DropReason::PoleUndetermined(ratio),
            ));
        }
        self.poles.retain(|pole| !pole.parts.is_empty());
        mark_unconverged(&mut self.poles);
        self.refine_and_prune(Convergence::Coarse);
    }

    /// Reinstates, for good, single isolated poles without which the misfit rises far: two poles in
    /// one resonance fit any response that one does not.
    fn reinstate_needed(&mut self, removed: &[(ModelPole, f64)]) {
        let described = self.data.predict(&self.poles);
        let needed = |(pole, before): &&(ModelPole, f64)| {
            let is_isolated = self.poles.iter().all(|other| pole.separation(other) > 1.0);
            let now = residual_chi_square(&self.data, &described, pole);
            pole.multiplicity() == 1
                && is_isolated
                && now > MIN_CHI_SQUARE_INCREASE * before.max(1.0)
        };
        let needed: Vec<ModelPole> = removed
            .iter()
            .filter(needed)
            .map(|(pole, _)| pole.clone())
            .collect();
        if needed.is_empty() {
            return;
        }
        let back = |dropped: &Dropped| needed.iter().any(|pole| pole.lambda == dropped.lambda);
        self.dropped.retain(|dropped| !back(dropped));
        self.poles.extend(needed.into_iter().map(|pole| ModelPole {
            suspect: false,
            ..pole
        }));
        mark_unconverged(&mut self.poles);
        self.refine_and_prune(Convergence::Coarse);
    }

    pub fn rejection_reasons(&self) -> Vec<Option<Rejection>> {
        let pole_metrics = self.pole_metrics();
        (0..self.poles.len())
            .map(|j| rejection_reason(&self.poles, &pole_metrics, j, RejectionPolicy::Standard))
            .collect()
    }

    /// Whether several poles have a reason for rejection by misfit, or the phases of many poles
    /// scatter.
    pub fn model_misses_data(&self, rejection_reasons: &[Option<Rejection>]) -> bool {
        let misses = rejection_reasons
            .iter()
            .flatten()
            .filter(|rejection| rejection.is_misfit());
        misses.count() >= MIN_REJECTIONS_MISFIT.max(self.poles.len() / 10)
            || phases_scatter(&self.poles, &self.pole_metrics())
    }
}
