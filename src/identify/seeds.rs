//! Seeds of the maximum likelihood fit: poles that stay over the orders of the polyreference LSCF.
//!
//! Low modes of a wide band lie close together on its scale: its lower quarter has an estimate of its own, and a quarter of that.

use std::ops::Range;

use rayon::prelude::*;

use super::IdentifyError;
use super::plscf::{Lscf, LscfPole};
use super::pruning::WIDEST;
use super::receptance::Receptances;
use super::roots::{Root, resonates};
use super::search::Found;
use super::sides::Sides;
use super::stable::{self, Seed, distinct};

/// Poles of the highest order: so many for each peak that is seen, and beyond.
const POLES_PER_PEAK: usize = 5;
const POLES_BEYOND: usize = 30;
/// Bounds of their number.
const POLES: Range<usize> = 36..160;
/// Orders that are looked at.
const ORDERS: usize = 20;
/// A band whose ends differ by this factor has its lower part looked at by itself: so much of its lines, if these are enough, and so
/// much more of what lies beside the seam.
const WIDE: f64 = 8.0;
const PART: usize = 4;
const FEWEST_LINES: usize = 100;
const OVERLAP: f64 = 0.02;

/// Roots of one mode at the poles that stay; how high the orders go follows from the number of peaks. Poles must lie within limits,
/// rad/s.
pub(super) fn seeds(
    data: &Receptances,
    sides: &Sides,
    (found, limits): (&Found, (f64, f64)),
) -> Result<Vec<Root>, IdentifyError> {
    let mut all = Vec::new();
    let mut end = data.lines();
    loop {
        let part = end / PART;
        let wide = data.omega[end - 1] > WIDE * data.omega[0];
        let split = wide && part >= FEWEST_LINES;
        let lowest = if split { data.omega[part] } else { 0.0 };
        let own = seeds_below(data, sides, (end, found, limits))?;
        let above = |seed: &Seed| seed.pole.lambda.im > (1.0 - OVERLAP) * lowest;
        let below = |seed: &Seed| {
            end == data.lines() || seed.pole.lambda.im < data.omega[end] * (1.0 + OVERLAP)
        };
        all.extend(own.into_iter().filter(|seed| above(seed) && below(seed)));
        if !split {
            break;
        }
        end = part;
    }
    let functions = data.functions();
    let root = |seed: &Seed| Root::single(seed.pole.lambda, &seed.pole.participation, functions);
    Ok(distinct(all).iter().map(root).collect())
}

/// Poles that stay over the orders of an estimate from the lines below one.
fn seeds_below(
    data: &Receptances,
    sides: &Sides,
    (end, found, limits): (usize, &Found, (f64, f64)),
) -> Result<Vec<Seed>, IdentifyError> {
    let peaks = found.peaks.iter().filter(|peak| peak.line < end).count();
    let poles = (POLES_PER_PEAK * peaks + POLES_BEYOND).clamp(POLES.start, POLES.end);
    let top = (poles / sides.inputs).min(end / 3).max(4);
    let lscf = Lscf::new(data, sides, (0..end, top))?;
    let lowest = (lscf.order() / 6).max(2);
    let stride = (lscf.order() - lowest).div_ceil(ORDERS).max(1);
    let orders: Vec<usize> = (lowest..=lscf.order()).step_by(stride).collect();
    let tables: Vec<_> = orders
        .par_iter()
        .map(|order| Ok((*order, inside(data, lscf.poles(*order)?, limits))))
        .collect::<Vec<Result<_, IdentifyError>>>();
    let tables: Vec<(usize, Vec<LscfPole>)> = tables.into_iter().collect::<Result<_, _>>()?;
    Ok(stable::seeds(&tables, data.step))
}

fn inside(data: &Receptances, poles: Vec<LscfPole>, (lo, hi): (f64, f64)) -> Vec<LscfPole> {
    let widest = WIDEST * data.range();
    let keeps = |pole: &LscfPole| {
        let inside = pole.lambda.im > lo && pole.lambda.im < hi;
        inside && -2.0 * pole.lambda.re < widest && resonates(pole.lambda)
    };
    poles.into_iter().filter(keeps).collect()
}
