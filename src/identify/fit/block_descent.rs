//! Maximum likelihood refinement of all poles of a band: block descent, with sweeps over blocks of
//! overlapping poles until every pole has converged.
//!
//! A pole is fitted on the lines within [`FIT_BAND_BANDWIDTHS`] half-power bandwidths: with free
//! constant and slope this costs a tenth of its information against an infinite band (9.9 % for an
//! isolated pole in the middle; more where the data end within the lines). Poles that overlap share
//! a block. The shapes of all others on its lines are fitted with it, and their poles too where
//! their skirts matter; the contribution of poles farther away is subtracted. Blocks are
//! independent within a sweep, so that they run in parallel.

use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::linalg::{self, ComplexMatrix, sort_ascending_by};

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::model_pole::{FitState, ModelPole, PoleQuality, combined};
use crate::identify::fit::compressed_band::{CompressedBand, KnownResponse};
use crate::identify::fit::fit_data::FitData;
use crate::identify::fit::gauss_newton::{Block, FitContext, Fitted, Unknown, fit};

/// Half length of the lines of a block, half-power bandwidths.
const FIT_BAND_BANDWIDTHS: f64 = 20.0;
/// Minimum number of lines on either side of a pole.
const MIN_SIDE_LINES: usize = 24;
/// Maximum distance of a pole from the lines, half-power bandwidths.
const MAX_BEYOND_BANDWIDTHS: f64 = 1.0;
/// Maximum separation of poles that one block fits, sums of their half-power bandwidths.
const MAX_BLOCK_SEPARATION: f64 = 1.0;
/// Maximum separation of a core pole from a member whose pole is free, sums of their half-power
/// bandwidths.
const MAX_FREE_SEPARATION: f64 = 4.0;
/// Maximum length of the lines of a merged block, over the longer one of its groups.
const MAX_MERGED_LENGTH_RATIO: f64 = 1.5;
/// Maximum number of unknowns of the poles that a merged block updates: the work of a step rises
/// with their third power.
/// With 120 modes at three references a fit takes three times as long without this limit; with a
/// third of it, fits of overlapping poles of recordings take up to four times as long.
const MAX_MERGED_UNKNOWNS: usize = 60;
/// Maximum number of members of a block, the poles that it updates aside. A pole as wide as the
/// band is near all others: those that are not among the nearest count as known in its block.
/// Larger: with such a pole among 125 others a step takes 0.2 s. Smaller: overlapping poles that
/// move together take more sweeps. Test: `a_wide_pole_is_fitted_with_its_nearest_neighbours`.
const MAX_MEMBERS: usize = 40;
/// Maximum number of steps of each block in a sweep.
const MAX_STEPS: usize = 3;
/// Maximum number of sweeps, and of those of a trial.
const MAX_SWEEPS: usize = 40;
const MAX_TRIAL_SWEEPS: usize = 4;
/// Number of poles above which a coarse refinement ends after fewer sweeps, though some poles still
/// iterate, so that those that are noise can be removed: they move for long, and with them all
/// poles of their blocks. Larger: with 120 modes and 7 such poles the fit takes longer
/// (`tests/bench/identify.rs` has 120). Smaller: where shifts between runs are imitated by further
/// poles, 20 or so, these are tested before they have settled.
pub(in crate::identify) const MANY_POLES: usize = 60;
const MAX_SWEEPS_OF_MANY: usize = 8;
/// Step over its standard deviation below which a pole has converged.
const CONVERGED_STEP_STDS: f64 = 1e-2;
/// The same while poles may still be removed.
const COARSE_STEP_STDS: f64 = 0.1;
/// Step, in decay rates and of participation factors, below which a pole has always converged: far
/// below any standard deviation, near rounding for data without noise.
const CONVERGED_STEP_DECAY_RATES: f64 = 1e-10;

/// Convergence level of a refinement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::identify) enum Convergence {
    /// Residues alone: the poles are fixed.
    Residues,
    /// Sufficient to compare the residual with that of another line shape.
    Trial,
    /// Sufficient to decide which poles are kept.
    Coarse,
    /// Sufficient to assess the residual.
    ResidualTest,
    /// Full convergence.
    Fine,
}

/// Refines all poles to the maximum of the likelihood and returns them in ascending frequency.
/// Poles that leave the range `limits`, rad/s, or become unstable are removed.
///
/// A block is fitted while one of its members iterates; after all have converged, every block is
/// fitted once more, with the final values of distant poles. Compressed bands are kept for the next
/// refinement.
pub(in crate::identify) fn refine(
    data: &FitData,
    frf_matrix: &FrfMatrix,
    windows: &mut Vec<CompressedBand>,
    mut roots: Vec<ModelPole>,
    limits: [f64; 2],
    stop: Convergence,
) -> Vec<ModelPole> {
    let mut is_final = false;
    let mut plan: Option<Vec<Task>> = None;
    let out_of_band_fit = data.out_of_band_fit();
    let mut out_of_band_coordinates: Option<ComplexMatrix> = None;
    let (mut sweep, mut next) = (0, 0);
    let mut lost = false;
    windows.retain(|window| window.is_of(data));
    let last = match stop {
        Convergence::Trial => MAX_TRIAL_SWEEPS,
        Convergence::Coarse if roots.len() > MANY_POLES => MAX_SWEEPS_OF_MANY,
        _ => MAX_SWEEPS,
    };
    for round in 1..=last {
        // The last fit of a block determines its variances.
        is_final |= round == last;
        let fresh = roots
            .iter()
            .any(|root| matches!(root.progress, FitState::Fresh(_)));
        // Blocks keep their lines while poles iterate, so that both cannot drift together.
        let mut tasks = plan.take().unwrap_or_else(|| {
            sort_ascending_by(&mut roots, |root| root.lambda.im);
            tasks(windows, blocks(&data.frfs, windows, &roots, fresh))
        });
        let iterates = |root: &usize| roots[*root].progress != FitState::Settled;
        let mut active: Vec<&mut Task> = tasks
            .iter_mut()
            .filter(|task| is_final || task.block.members.iter().any(iterates))
            .collect();
        let steps = if fresh || stop == Convergence::Residues {
            0
        } else {
            MAX_STEPS
        };
        // Out-of-band terms change little from sweep to sweep, and are computed again before the
        // last fit of all blocks.
        if lost || !fresh && (is_final || sweep == next) {
            out_of_band_coordinates = Some(out_of_band_fit.residual_coordinates(&roots));
            next = 2 * sweep + 1;
        }
        lost &= fresh;
        sweep += usize::from(!fresh);
        let coordinates = out_of_band_coordinates.as_ref();
        let around = FitContext {
            data,
            frf_matrix,
            poles: &roots,
            known: &KnownResponse::new(&roots, data.frfs.functions(), coordinates),
            needs_shape_stds: is_final && matches!(stop, Convergence::Fine | Convergence::Residues),
        };
        let fitted: Vec<Fitted> = active
            .par_iter_mut()
            .map(|task| fit(&around, &task.block, &mut task.window, steps))
            .collect();
        for (task, fitted) in active.iter().zip(&fitted) {
            update_poles(&mut roots, &task.block, fitted, stop);
        }
        let before = roots.len();
        let is_shown =
            |root: &ModelPole| stop == Convergence::Residues || is_visible(&data.frfs, root);
        roots.retain(|root| is_in_range(root, limits) && is_shown(root));
        if roots.len() < before {
            // The residues of the others and the out-of-band terms were fitted together with the
            // removed pole, which may have been large and wide.
            roots.iter_mut().for_each(ModelPole::refresh);
            lost = true;
        }
        if roots.len() < before || fresh {
            windows.extend(tasks.into_iter().filter_map(|task| task.window));
        } else {
            plan = Some(tasks);
        }
        let converged = roots.iter().all(|root| root.progress == FitState::Settled);
        if converged && is_final {
            break;
        }
        is_final = converged;
    }
    let kept = plan.into_iter().flatten();
    windows.extend(kept.filter_map(|task| task.window));
    sort_ascending_by(&mut roots, |root| root.lambda.im);
    roots.par_iter_mut().for_each(|root| {
        root.quality.pole_std =
            root.quality.pole_bound * data.noise.pole_noise_factor(&data.frfs, root).sqrt();
        root.quality.amplitude_noise_factor = data.noise.amplitude_noise_factor(&data.frfs, root);
    });
    roots
}

/// A block with its compressed band, where there is one.
struct Task {
    block: Block,
    window: Option<CompressedBand>,
}

/// Assigns compressed bands to the blocks with the same lines; the others are discarded.
fn tasks(windows: &mut Vec<CompressedBand>, blocks: Vec<Block>) -> Vec<Task> {
    let mut kept = std::mem::take(windows);
    let task = |block: Block| {
        let index = kept.iter().position(|band| *band.lines() == block.lines);
        let window = index.map(|index| kept.swap_remove(index));
        Task { block, window }
    };
    blocks.into_iter().map(task).collect()
}

/// Marks converged poles as iterating: a removed or added pole changes the residual of all others.
pub(in crate::identify) fn mark_unconverged(roots: &mut [ModelPole]) {
    for root in roots {
        if root.progress == FitState::Settled {
            root.progress = FitState::Moving;
        }
    }
}

fn is_in_range(root: &ModelPole, [lo, hi]: [f64; 2]) -> bool {
    let lambda = root.lambda;
    lambda.is_finite() && lambda.re < 0.0 && lambda.im > lo && lambda.im < hi
}

/// Whether a pole lies among the lines or so near that its resonance is visible on them. Farther
/// poles belong to the out-of-band terms: their residues would be differences of large numbers.
fn is_visible(frfs: &BandFrfs, root: &ModelPole) -> bool {
    frfs.beyond(root.lambda.im) < MAX_BEYOND_BANDWIDTHS * root.width()
}

/// Updates the core poles of a block from its fit.
fn update_poles(roots: &mut [ModelPole], block: &Block, fitted: &Fitted, stop: Convergence) {
    let misfit_factor = fitted.misfit.max(1.0).sqrt();
    let max_step_stds = match stop {
        Convergence::Trial | Convergence::Coarse | Convergence::Residues => {
            COARSE_STEP_STDS * misfit_factor
        }
        Convergence::ResidualTest => CONVERGED_STEP_STDS * misfit_factor,
        Convergence::Fine => CONVERGED_STEP_STDS,
    };
    let deviations = unknown_stds(fitted);
    for &member in &block.core {
        let root = &mut roots[block.members[member]];
        let before = root.clone();
        *root = fitted.members[member].clone();
        let decay = root.decay().abs();
        let strengths = fitted.strengths[member].clone();
        // A fit of the residues alone does not change the standard deviation of the pole.
        let mut bound = before.quality.pole_bound / decay;
        let mut converged = true;
        let mut offset = Complex64::ZERO;
        for (unknown, step) in fitted.unknowns.iter().zip(&fitted.next) {
            if *unknown == Unknown::Pole(member) {
                offset = decay * step;
            }
        }
        for (unknown, deviation) in fitted.unknowns.iter().zip(&deviations) {
            let change = match *unknown {
                Unknown::Pole(j) if j == member => {
                    bound = *deviation;
                    (root.lambda - before.lambda).norm() / decay
                }
                Unknown::Factor(j, part, input) if j == member => {
                    (root.parts[part][input] - before.parts[part][input]).norm()
                }
                _ => continue,
            };
            converged &=
                change <= CONVERGED_STEP_DECAY_RATES || change <= max_step_stds * deviation;
        }
        root.quality = PoleQuality {
            pole_bound: bound * decay,
            pole_std: before.quality.pole_std,
            offset,
            bias: None,
            combinations: combined(&root.parts, &strengths.combinations),
            strengths: strengths.values,
            largest: strengths.largest,
            amplitude_noise_factor: before.quality.amplitude_noise_factor,
        };
        root.choose_pivots();
        root.progress = match before.progress {
            FitState::Fresh(count) if count > 1 => FitState::Fresh(count - 1),
            FitState::Fresh(_) => FitState::Moving,
            _ if converged => FitState::Settled,
            _ => FitState::Moving,
        };
    }
}

/// Cramér-Rao standard deviation of real and imaginary part of each unknown, poles in decay rates;
/// infinite where it is undetermined.
fn unknown_stds(step: &Fitted) -> Vec<f64> {
    let inverse = (!step.unknowns.is_empty())
        .then(|| linalg::inverse_hermitian_raised(&step.information))
        .flatten();
    let deviation = |index: usize| match &inverse {
        Some(inverse) if inverse[(index, index)].re > 0.0 => {
            (0.5 * inverse[(index, index)].re).sqrt()
        }
        _ => f64::INFINITY,
    };
    (0..step.unknowns.len()).map(deviation).collect()
}

/// The blocks of poles in ascending frequency.
fn blocks(
    frfs: &BandFrfs,
    windows: &[CompressedBand],
    roots: &[ModelPole],
    linear: bool,
) -> Vec<Block> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (number, root) in roots.iter().enumerate() {
        let near = |other: &usize| root.separation(&roots[*other]) < MAX_BLOCK_SEPARATION;
        // Wide poles may overlap one that is not their neighbour.
        let (mut overlapping, others): (Vec<_>, Vec<_>) =
            groups.into_iter().partition(|group| group.iter().any(near));
        groups = others;
        let mut merged: Vec<usize> = overlapping.drain(..).flatten().collect();
        merged.push(number);
        groups.push(merged);
    }
    groups.iter_mut().for_each(|group| group.sort_unstable());
    groups.sort();
    let groups = merge_groups(frfs, roots, groups);
    groups
        .iter()
        .map(|core| block(frfs, windows, roots, core, linear))
        .collect()
}

/// Merges groups on nearly the same lines: one block converges in fewer sweeps than two.
fn merge_groups(frfs: &BandFrfs, roots: &[ModelPole], groups: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
    let lines = |group: &[usize]| window(frfs, group.iter().map(|j| &roots[*j])).len();
    let unknowns = |j: &usize| 1 + roots[*j].multiplicity() * roots[*j].free_inputs().count();
    let mut merged: Vec<Vec<usize>> = Vec::new();
    for group in groups {
        if let Some(last) = merged.last_mut() {
            let longest = lines(last).max(lines(&group));
            let both = [last.as_slice(), &group].concat();
            let few = both.iter().map(unknowns).sum::<usize>() <= MAX_MERGED_UNKNOWNS;
            if few && lines(&both) as f64 <= MAX_MERGED_LENGTH_RATIO * longest as f64 {
                *last = both;
                continue;
            }
        }
        merged.push(group);
    }
    merged
}

fn block(
    frfs: &BandFrfs,
    windows: &[CompressedBand],
    roots: &[ModelPole],
    core: &[usize],
    linear: bool,
) -> Block {
    let lines = window(frfs, core.iter().map(|j| &roots[*j]));
    let (lo, hi) = (frfs.omega[lines.start], frfs.omega[lines.end - 1]);
    let inside = |root: &ModelPole| {
        let skirt = root.width().max(2.0 * frfs.step);
        root.lambda.im > lo - skirt && root.lambda.im < hi + skirt
    };
    let is_core = |j: &usize| core.contains(j);
    let separation = |j: &usize| match is_core(j) {
        true => -1.0,
        false => {
            let from = |root: &usize| roots[*root].separation(&roots[*j]);
            core.iter().map(from).fold(f64::INFINITY, f64::min)
        }
    };
    let on_lines = (0..roots.len()).filter(|j| is_core(j) || inside(&roots[*j]));
    let mut members: Vec<(usize, f64)> = on_lines.map(|j| (j, separation(&j))).collect();
    sort_ascending_by(&mut members, |(_, separation)| *separation);
    members.truncate(MAX_MEMBERS.max(core.len()));
    // Members as they are numbered, and whether each is near the core.
    members.sort_unstable_by_key(|(j, _)| *j);
    let indices = |wanted: &dyn Fn(&(usize, f64)) -> bool| -> Vec<usize> {
        (0..members.len())
            .filter(|index| wanted(&members[*index]))
            .collect()
    };
    let free = indices(&|(_, separation)| *separation < MAX_FREE_SEPARATION);
    let core = indices(&|(j, _)| is_core(j));
    let members: Vec<usize> = members.iter().map(|(j, _)| *j).collect();
    let lines = extend_lines(frfs, lines, members.len());
    let kept = windows
        .iter()
        .find(|window| window.covers(&lines, frfs.lines()));
    Block {
        lines: kept.map_or(lines, |window| window.lines().clone()),
        members,
        free: if linear { Vec::new() } else { free },
        core,
    }
}

/// Lines within the fit bands of some poles.
pub(in crate::identify) fn window<'a>(
    frfs: &BandFrfs,
    roots: impl Iterator<Item = &'a ModelPole>,
) -> Range<usize> {
    let (mut start, mut end) = (frfs.lines(), 0);
    for root in roots {
        let side = (FIT_BAND_BANDWIDTHS * root.width() / frfs.step).ceil() as usize;
        let side = side.max(MIN_SIDE_LINES).min(frfs.lines());
        let top = ((root.lambda.im - frfs.omega[0]) / frfs.step).round();
        let top = (top.max(0.0) as usize).min(frfs.lines() - 1);
        start = start.min(top.saturating_sub(side));
        end = end.max((top + side + 1).min(frfs.lines()));
    }
    start..end
}

/// Extends the lines of a block so that its members have fewer unknowns than lines.
fn extend_lines(frfs: &BandFrfs, lines: Range<usize>, members: usize) -> Range<usize> {
    let wanted = 4 * members + 40;
    let missing = wanted.saturating_sub(lines.len()).div_ceil(2);
    let start = lines.start.saturating_sub(missing);
    start..(lines.end + missing).min(frfs.lines())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::{Band, FrequencyAxis};
    use crate::identify::synthetic::{Measurement, Structure};
    use crate::modal::Pole;

    #[test]
    fn a_wide_pole_is_fitted_with_its_nearest_neighbours() {
        let axis = FrequencyAxis {
            start_hz: 80.0,
            step_hz: 0.1,
            len: 401,
        };
        let structure = Structure {
            modes: vec![(100.0, 0.01, vec![1.0])],
        };
        let set = structure.measured(&Measurement::of_sensors(1, axis));
        let data = FitData::guarded(&set, Band::new(80.0, 120.0).unwrap()).unwrap();
        let participation = [1.0, 0.5, 0.3].map(Complex64::from);
        let pole = |hz: f64, zeta: f64| {
            ModelPole::single(Pole::from_frequency(hz, zeta).lambda, &participation, 1)
        };
        // Its lines are all, its bandwidth is 4 Hz, and the others are 0.66 Hz apart.
        let mut roots: Vec<ModelPole> = (0..60)
            .map(|j| pole(80.3 + 0.66 * f64::from(j), 5e-4))
            .chain([pole(100.0, 0.02)])
            .collect();
        sort_ascending_by(&mut roots, |root| root.lambda.im);
        let widths: Vec<f64> = roots.iter().map(ModelPole::width).collect();
        let wide = (0..roots.len())
            .max_by(|a, b| widths[*a].total_cmp(&widths[*b]))
            .unwrap();
        let blocks = blocks(&data.frfs, &[], &roots, false);
        let updated = |block: &Block| -> Vec<usize> {
            block
                .core
                .iter()
                .map(|index| block.members[*index])
                .collect()
        };
        // Each pole is updated by one block.
        let mut all: Vec<usize> = blocks.iter().flat_map(updated).collect();
        all.sort_unstable();
        assert_eq!(all, (0..roots.len()).collect::<Vec<_>>());
        let block = blocks
            .iter()
            .find(|block| updated(block).contains(&wide))
            .unwrap();
        assert_eq!(block.members.len(), MAX_MEMBERS);
        assert!(block.members.is_sorted());
        // Those left out are farther from the core than every member.
        let core = updated(block);
        let separation = |j: &usize| {
            let from = |root: &usize| roots[*root].separation(&roots[*j]);
            core.iter().map(from).fold(f64::INFINITY, f64::min)
        };
        let is_member = |j: &usize| block.members.contains(j);
        let (members, others): (Vec<usize>, Vec<usize>) = (0..roots.len()).partition(is_member);
        let farthest = members.iter().map(separation).fold(0.0, f64::max);
        assert!(others.iter().all(|j| separation(j) >= farthest));
        // The free ones are those near the core, the core among them.
        assert!(
            core.iter()
                .all(|j| block.free.iter().any(|index| block.members[*index] == *j))
        );
    }
}
