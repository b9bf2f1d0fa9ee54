//! Maximum likelihood refinement of all roots of a band: blocks of roots in their windows, swept
//! until nothing moves.
//!
//! A root is fitted on the lines within [`REACH`] half-power widths: with constant and slope left
//! free this costs a tenth of its information against a band without end (9.9 % for a pole alone in
//! the middle; more where the data end within the window). Roots that overlap share a block. All
//! others in the window have their shapes fitted with it, and poles too where their skirts matter;
//! what lies outside is subtracted as it is known. Blocks are independent within a sweep, so that
//! they run in parallel.

use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::linalg::{self, ComplexMatrix};

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::frf_matrix::Sides;
use crate::identify::data::model_pole::{Progress, Quality, Root, combined};
use crate::identify::data::residual::residues;
use crate::identify::fit::compressed_band::Window;
use crate::identify::fit::gauss_newton::{Block, Fitted, Surroundings, Unknown, fit};

/// Half of a window, half-power widths.
const REACH: f64 = 20.0;
/// Fewest lines on either side of a root.
const SIDE_LINES: usize = 24;
/// Half-power widths that a root may lie beyond the lines, at most.
const AT_MOST_BEYOND: f64 = 1.0;
/// Roots within so many sums of their half-power widths decide together.
const TOGETHER: f64 = 1.0;
/// Poles of members within so many sums of half-power widths of a core root move with it.
const MOVING: f64 = 4.0;
/// Groups of roots share a block when one window is so little longer than theirs.
const SAME_WINDOW: f64 = 1.5;
/// Steps of each block in a sweep.
const STEPS: usize = 3;
/// Most sweeps.
const SWEEPS: usize = 40;
/// A step below this part of its standard deviation does not count either.
const STILL_BY_BOUND: f64 = 1e-2;
/// The same while it is still open which roots stay.
const COARSE: f64 = 0.1;
/// Largest step that still counts, in decay rates and of participation factors: far below any
/// bound, near rounding for data without noise.
const STILL: f64 = 1e-10;

/// How far a refinement goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::identify) enum Stop {
    /// Residues alone: the poles stay where they are.
    Residues,
    /// Far enough to decide which roots stay.
    Coarse,
    /// Far enough to judge what is left over.
    Judging,
    /// To the end.
    Fine,
}

/// Moves all roots to the maximum of the likelihood and returns them in ascending frequency.
/// `limits` is where they may lie, rad/s; what leaves them, or becomes unstable, is gone.
///
/// A block is fitted while one of its members moves; when none does, all are fitted once more, for
/// what far roots changed. Windows are kept for the next refinement.
pub(in crate::identify) fn refine(
    (data, sides): (&Receptances, &Sides),
    windows: &mut Vec<Window>,
    mut roots: Vec<Root>,
    (limits, stop): ((f64, f64), Stop),
) -> Vec<Root> {
    let mut whole = false;
    let mut plan: Option<Vec<Task>> = None;
    let far = data.far();
    let mut beyond: Option<ComplexMatrix> = None;
    let (mut sweep, mut next) = (0, 0);
    let mut lost = false;
    windows.retain(|window| window.is_of(data));
    for round in 1..=SWEEPS {
        // Of the last look at a block its variances stay.
        whole |= round == SWEEPS;
        let fresh = roots
            .iter()
            .any(|root| matches!(root.progress, Progress::Fresh(_)));
        // Windows that followed every step would let the roots follow the windows.
        let mut tasks = plan.take().unwrap_or_else(|| {
            roots.sort_by(|a, b| a.lambda.im.total_cmp(&b.lambda.im));
            tasks(windows, blocks((data, windows), &roots, fresh))
        });
        let moving = |root: &usize| roots[*root].progress != Progress::Settled;
        let mut active: Vec<&mut Task> = tasks
            .iter_mut()
            .filter(|task| whole || task.block.members.iter().any(moving))
            .collect();
        let steps = if fresh || stop == Stop::Residues {
            0
        } else {
            STEPS
        };
        // What is far changes little from sweep to sweep, and the last look at all blocks has it
        // anew.
        if lost || !fresh && (whole || sweep == next) {
            beyond = Some(far.of_rest(&roots));
            next = 2 * sweep + 1;
        }
        lost &= fresh;
        sweep += usize::from(!fresh);
        let around = Surroundings {
            data,
            sides,
            roots: &roots,
            residues: &residues(&roots, data.functions()),
            far: beyond.as_ref(),
            last: whole && matches!(stop, Stop::Fine | Stop::Residues),
        };
        let fitted: Vec<Fitted> = active
            .par_iter_mut()
            .map(|task| fit(&around, &task.block, (&mut task.window, steps)))
            .collect();
        for (task, fitted) in active.iter().zip(&fitted) {
            take(&mut roots, (&task.block, fitted), stop);
        }
        let before = roots.len();
        let shown = |root: &Root| stop == Stop::Residues || shows(data, root);
        roots.retain(|root| stays(root, limits) && shown(root));
        if roots.len() < before {
            // The residues of the others, and what is far, were fitted beside what is gone, which
            // may have been large and wide.
            roots.iter_mut().for_each(Root::refresh);
            lost = true;
        }
        if roots.len() < before || fresh {
            windows.extend(tasks.into_iter().filter_map(|task| task.window));
        } else {
            plan = Some(tasks);
        }
        let settled = roots.iter().all(|root| root.progress == Progress::Settled);
        if settled && whole {
            break;
        }
        whole = settled;
    }
    let kept = plan.into_iter().flatten();
    windows.extend(kept.filter_map(|task| task.window));
    roots.sort_by(|a, b| a.lambda.im.total_cmp(&b.lambda.im));
    roots.par_iter_mut().for_each(|root| {
        root.quality.pole_std = root.quality.pole_bound * data.shared.of_pole(data, root).sqrt();
        root.quality.by_lines = data.shared.of_amplitude(data, root);
    });
    roots
}

/// A block with its window, where it has one.
struct Task {
    block: Block,
    window: Option<Window>,
}

/// Blocks with the windows that have their lines; the others are given up.
fn tasks(windows: &mut Vec<Window>, blocks: Vec<Block>) -> Vec<Task> {
    let mut kept = std::mem::take(windows);
    let task = |block: Block| {
        let own = kept.iter().position(|own| *own.lines() == block.lines);
        let window = own.map(|place| kept.swap_remove(place));
        Task { block, window }
    };
    blocks.into_iter().map(task).collect()
}

/// What was left out or put in changes what all others must explain.
pub(in crate::identify) fn unsettle(roots: &mut [Root]) {
    for root in roots {
        if root.progress == Progress::Settled {
            root.progress = Progress::Moving;
        }
    }
}

fn stays(root: &Root, (lo, hi): (f64, f64)) -> bool {
    let lambda = root.lambda;
    lambda.is_finite() && lambda.re < 0.0 && lambda.im > lo && lambda.im < hi
}

/// Whether a root lies among the lines or so near to them that they show its resonance. What is
/// farther away the background follows, and the residue of such a root would be a difference of
/// large numbers, of which every window has the skirt.
fn shows(data: &Receptances, root: &Root) -> bool {
    data.beyond(root.lambda.im) < AT_MOST_BEYOND * root.width()
}

/// Takes over the roots that a block decides.
fn take(roots: &mut [Root], (block, fitted): (&Block, &Fitted), stop: Stop) {
    let missed = fitted.misfit.max(1.0).sqrt();
    let by_bound = match stop {
        Stop::Coarse | Stop::Residues => COARSE * missed,
        Stop::Judging => STILL_BY_BOUND * missed,
        Stop::Fine => STILL_BY_BOUND,
    };
    let deviations = deviations(fitted);
    for &place in &block.core {
        let root = &mut roots[block.members[place]];
        let before = root.clone();
        *root = fitted.members[place].clone();
        let decay = root.decay().abs();
        let strengths = fitted.strengths[place].clone();
        // A fit of the residues alone says nothing new of the pole.
        let mut bound = before.quality.pole_bound / decay;
        let mut still = true;
        let mut offset = Complex64::ZERO;
        for (unknown, step) in fitted.unknowns.iter().zip(&fitted.next) {
            if *unknown == Unknown::Pole(place) {
                offset = decay * step;
            }
        }
        for (unknown, deviation) in fitted.unknowns.iter().zip(&deviations) {
            let moved = match *unknown {
                Unknown::Pole(j) if j == place => {
                    bound = *deviation;
                    (root.lambda - before.lambda).norm() / decay
                }
                Unknown::Factor(j, part, input) if j == place => {
                    (root.parts[part][input] - before.parts[part][input]).norm()
                }
                _ => continue,
            };
            still &= moved <= STILL || moved <= by_bound * deviation;
        }
        root.quality = Quality {
            pole_bound: bound * decay,
            pole_std: before.quality.pole_std,
            offset,
            bias: None,
            combinations: combined(&root.parts, &strengths.combinations),
            strengths: strengths.values,
            largest: strengths.largest,
            by_lines: before.quality.by_lines,
        };
        root.choose_pivots();
        root.progress = match before.progress {
            Progress::Fresh(count) if count > 1 => Progress::Fresh(count - 1),
            Progress::Fresh(_) => Progress::Moving,
            _ if still => Progress::Settled,
            _ => Progress::Moving,
        };
    }
}

/// Cramér-Rao deviation of real and imaginary part of each unknown, poles in decay rates; infinite
/// where it is not known.
fn deviations(step: &Fitted) -> Vec<f64> {
    let inverse = (!step.unknowns.is_empty())
        .then(|| linalg::inverse_hermitian_raised(&step.information))
        .flatten();
    let deviation = |place: usize| match &inverse {
        Some(inverse) if inverse[(place, place)].re > 0.0 => {
            (0.5 * inverse[(place, place)].re).sqrt()
        }
        _ => f64::INFINITY,
    };
    (0..step.unknowns.len()).map(deviation).collect()
}

/// The blocks of roots in ascending frequency.
fn blocks((data, windows): (&Receptances, &[Window]), roots: &[Root], linear: bool) -> Vec<Block> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (number, root) in roots.iter().enumerate() {
        let near = |other: &usize| apart(root, &roots[*other]) < TOGETHER;
        // Wide roots may overlap one that is not their neighbour.
        let (mut own, rest): (Vec<_>, Vec<_>) =
            groups.into_iter().partition(|group| group.iter().any(near));
        groups = rest;
        let mut merged: Vec<usize> = own.drain(..).flatten().collect();
        merged.push(number);
        groups.push(merged);
    }
    groups.iter_mut().for_each(|group| group.sort_unstable());
    groups.sort();
    let groups = merged(data, roots, groups);
    groups
        .iter()
        .map(|core| block((data, windows), roots, core, linear))
        .collect()
}

/// Groups whose windows are nearly the same decide together: that is less work than each alone.
fn merged(data: &Receptances, roots: &[Root], groups: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
    let lines = |group: &[usize]| window(data, group.iter().map(|j| &roots[*j])).len();
    let mut merged: Vec<Vec<usize>> = Vec::new();
    for group in groups {
        if let Some(last) = merged.last_mut() {
            let longest = lines(last).max(lines(&group));
            let both = [last.as_slice(), &group].concat();
            if lines(&both) as f64 <= SAME_WINDOW * longest as f64 {
                *last = both;
                continue;
            }
        }
        merged.push(group);
    }
    merged
}

/// Distance of two roots in sums of their half-power widths.
pub(in crate::identify) fn apart(a: &Root, b: &Root) -> f64 {
    (a.lambda.im - b.lambda.im).abs() / (a.width() + b.width())
}

fn block(
    (data, windows): (&Receptances, &[Window]),
    roots: &[Root],
    core: &[usize],
    linear: bool,
) -> Block {
    let lines = window(data, core.iter().map(|j| &roots[*j]));
    let (lo, hi) = (data.omega[lines.start], data.omega[lines.end - 1]);
    let inside = |root: &Root| {
        let skirt = root.width().max(2.0 * data.step);
        root.lambda.im > lo - skirt && root.lambda.im < hi + skirt
    };
    let members: Vec<usize> = (0..roots.len())
        .filter(|j| core.contains(j) || inside(&roots[*j]))
        .collect();
    let moving = |j: usize| {
        core.iter()
            .any(|own| apart(&roots[*own], &roots[j]) < MOVING)
    };
    let places = |wanted: &dyn Fn(usize) -> bool| -> Vec<usize> {
        (0..members.len())
            .filter(|place| wanted(members[*place]))
            .collect()
    };
    let (core, free) = (places(&|j| core.contains(&j)), places(&moving));
    let lines = enough(data, lines, members.len());
    let kept = windows
        .iter()
        .find(|window| window.covers(&lines, data.lines()));
    Block {
        lines: kept.map_or(lines, |window| window.lines().clone()),
        members,
        free: if linear { Vec::new() } else { free },
        core,
    }
}

/// Lines within reach of some roots.
pub(in crate::identify) fn window<'a>(
    data: &Receptances,
    roots: impl Iterator<Item = &'a Root>,
) -> Range<usize> {
    let (mut start, mut end) = (data.lines(), 0);
    for root in roots {
        let side = (REACH * root.width() / data.step).ceil() as usize;
        let side = side.max(SIDE_LINES).min(data.lines());
        let top = ((root.lambda.im - data.omega[0]) / data.step).round();
        let top = (top.max(0.0) as usize).min(data.lines() - 1);
        start = start.min(top.saturating_sub(side));
        end = end.max((top + side + 1).min(data.lines()));
    }
    start..end
}

/// More lines where the members have as many unknowns as there are lines.
fn enough(data: &Receptances, lines: Range<usize>, members: usize) -> Range<usize> {
    let wanted = 4 * members + 40;
    let missing = wanted.saturating_sub(lines.len()).div_ceil(2);
    let start = lines.start.saturating_sub(missing);
    start..(lines.end + missing).min(data.lines())
}
