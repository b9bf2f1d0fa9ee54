//! Placement selects the minimum number of excitation and response points that show all roots that
//! any of the candidates can show.
//!
//! A root of m modes with unit modal masses has the strengths `G = Φ_R Φ_Hᵀ` at the responses R and
//! hits H. As many of its modes are seen as G, eliminated with complete pivoting over the pairs
//! that are measured, has pivots that stand over the noise: for a single root, that is its best
//! pair, for a repeated one the independent looks at it. Points are added one by one, each time the
//! one that shows most; where no single one shows more, a hit and a sensor together.

use std::f64::consts::TAU;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::axis::Band;
use crate::dof::Dof;
use crate::frf::FrfSet;
use crate::modal::ModalModel;

use super::observability::{NotJudged, Sight};
use super::placement_candidates::{Added, AllPoints, Candidates, NewPoints, Row, Target, squared};
use super::subspace::orthonormal;

/// Points to add to a test.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Points in the order in which they are worth adding.
    pub steps: Vec<Step>,
    /// The elastic roots of the band, ascending.
    pub roots: Vec<PlannedRoot>,
    /// The points that can be hit, those first that show most with the sensors there are.
    pub ranking: Vec<RankedHit>,
}

/// One or two points that are added together.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// To hit.
    pub hit: Option<Dof>,
    /// To carry a sensor.
    pub sensor: Option<Dof>,
    /// Indices into [`Placement::roots`], and how many modes of each are seen beside those before.
    pub shown: Vec<(usize, usize)>,
}

/// Detectability of one root by a test and its additions.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedRoot {
    /// Indices of its modes.
    pub modes: Vec<usize>,
    /// Natural frequency, Hz.
    pub hz: f64,
    /// Modes that the test sees.
    pub seen: usize,
    /// Modes seen with all points that were added.
    pub planned: usize,
    /// Peak over noise with every point there is, dB: of the last mode when so many are seen, else
    /// of the next; `None` where no other moves.
    pub peak_over_noise_db: Option<f64>,
    /// Whether every point that can be hit stands still in it, and every that can carry a sensor.
    pub still: [bool; 2],
}

/// Value of an excitation point with the present sensors.
#[derive(Clone, Debug, PartialEq)]
pub struct RankedHit {
    /// Where.
    pub dof: Dof,
    /// Modes of the band that this point alone shows.
    pub shown: usize,
    /// Mean over the roots of its driving-point residue `φ²/(2 ω m)`, as a part of the largest such
    /// mean.
    pub driving_point_residue: f64,
    /// Effective independence: what of its row of the mode matrix no other point that can be hit
    /// has, 0 to 1; `None` where there are no more points than independent rows.
    pub independence: Option<f64>,
}

/// Points that a test should have in addition to its points, so that all roots of a band are seen
/// that any of the candidates can show.
///
/// A pair of a new hit is one with every sensor, a pair of a new sensor one with every hit: points
/// that were hit before are hit again. The noise at a new pair is that of the test's functions at
/// the root: the median over those with the same response, or over all, each beside the peak in its
/// quantity. A mode is seen when its pivot is 10 dB above the noise, and all pairs together
/// determine its frequency to a quarter of the distance to the next root, as in
/// [`observability`](fn@super::observability).
///
/// Without a band all elastic roots count.
///
/// # Errors
/// [`NotJudged`] where masses, damping or noise are not known.
///
/// # Reference
/// Kammer (1991), Journal of Guidance, Control, and Dynamics 14, eq. 11 (effective independence);
/// Ewins (2000), Modal Testing, 2nd ed. (driving-point residues).
pub fn placement(
    theory: &ModalModel,
    test: &ModalModel,
    frfs: &[FrfSet],
    band: Option<Band>,
    candidates: &Candidates,
) -> Result<Placement, NotJudged> {
    let sight = Sight::new(theory, test, frfs);
    let all = AllPoints::new(frfs, candidates);
    let targets = (0..sight.roots.len())
        .filter(|r| band.is_none_or(|band| band.contains(sight.roots[*r].hz)))
        .map(|r| Target::new(&sight, r, &all))
        .collect::<Result<Vec<_>, _>>()?;
    let nothing = Added::default();
    let mut added = nothing.clone();
    let mut steps = Vec::new();
    while let Some((points, shown)) = next(&targets, &all, &added) {
        added.add(&points);
        steps.push(Step {
            hit: points.hit.map(|at| all.hits[at].clone()),
            sensor: points.sensor.map(|at| all.responses[at].clone()),
            shown,
        });
    }
    let everything = Added {
        hits: all.new_hits.clone(),
        sensors: all.new_sensors.clone(),
    };
    let planned_root = |target: &Target<'_>| {
        let planned = target.seen(&all, &added);
        PlannedRoot {
            modes: target.root.modes.clone(),
            hz: target.root.hz,
            seen: target.seen(&all, &nothing),
            planned,
            peak_over_noise_db: target.peak_db(&all, &everything, planned),
            still: [still(&target.by_hit), still(&target.by_response)],
        }
    };
    Ok(Placement {
        roots: targets.par_iter().map(planned_root).collect(),
        steps,
        ranking: ranking(&targets, &all),
    })
}

fn still(rows: &[Row]) -> bool {
    rows.iter().flatten().all(|row| squared(row) == 0.0)
}

type Shown = Vec<(usize, usize)>;

/// The points that show most beside those there are.
fn next(targets: &[Target<'_>], all: &AllPoints, added: &Added) -> Option<(NewPoints, Shown)> {
    let hit = |at: &usize| NewPoints {
        hit: Some(*at),
        sensor: None,
    };
    let sensor = |at: &usize| NewPoints {
        hit: None,
        sensor: Some(*at),
    };
    let single: Vec<NewPoints> = (all.new_hits.iter().map(hit))
        .chain(all.new_sensors.iter().map(sensor))
        .collect();
    best(targets, all, added, single).or_else(|| {
        let both = targets
            .iter()
            .filter_map(|target| target.best_pair(all, added));
        best(targets, all, added, both.collect())
    })
}

/// The step that shows most modes, and of those the first that shows them best.
fn best(
    targets: &[Target<'_>],
    all: &AllPoints,
    added: &Added,
    steps: Vec<NewPoints>,
) -> Option<(NewPoints, Shown)> {
    let before: Vec<usize> = targets
        .iter()
        .map(|target| target.seen(all, added))
        .collect();
    let judged = |step: &NewPoints| {
        let mut with = added.clone();
        with.add(step);
        let (mut shown, mut weakest) = (Vec::new(), f64::INFINITY);
        for (number, (target, before)) in targets.iter().zip(&before).enumerate() {
            if *before == target.root.modes.len() {
                continue;
            }
            let ratios = target.ratios(all, &with);
            if ratios.len() > *before {
                shown.push((number, ratios.len() - before));
                weakest = ratios.iter().copied().fold(weakest, f64::min);
            }
        }
        let gain: usize = shown.iter().map(|(_, modes)| modes).sum();
        (gain, weakest, (*step, shown))
    };
    let judged: Vec<_> = steps.par_iter().map(judged).collect();
    let best = judged
        .into_iter()
        .filter(|judgement| judgement.0 > 0)
        .reduce(|a, b| {
            let order = (a.0.cmp(&b.0)).then(a.1.total_cmp(&b.1));
            if order.is_lt() { b } else { a }
        });
    best.map(|(_, _, found)| found)
}

fn ranking(targets: &[Target<'_>], all: &AllPoints) -> Vec<RankedHit> {
    let residue = |at: usize| -> f64 {
        let of = |target: &Target<'_>| {
            let row = target.by_hit[at].as_ref()?;
            Some(squared(row) / (2.0 * TAU * target.root.hz))
        };
        targets.iter().filter_map(of).sum()
    };
    let largest = all.to_hit.iter().map(|at| residue(*at)).fold(0.0, f64::max);
    let independence = independence(targets, &all.to_hit);
    let ranked = all
        .to_hit
        .iter()
        .enumerate()
        .map(|(number, &at)| RankedHit {
            dof: all.hits[at].clone(),
            shown: targets
                .iter()
                .map(|target| target.seen_alone(all, at))
                .sum(),
            driving_point_residue: match largest > 0.0 {
                true => residue(at) / largest,
                false => 0.0,
            },
            independence: independence.as_ref().map(|parts| parts[number]),
        });
    let mut ranked: Vec<RankedHit> = ranked.collect();
    ranked.sort_by(|a, b| {
        let by_residue = b.driving_point_residue.total_cmp(&a.driving_point_residue);
        b.shown.cmp(&a.shown).then(by_residue)
    });
    ranked
}

/// Diagonal of the projector on the columns of the mode matrix; `None` where that is the identity.
fn independence(targets: &[Target<'_>], hits: &[usize]) -> Option<Vec<f64>> {
    let columns = targets.iter().flat_map(|target| {
        (0..target.root.modes.len()).map(move |mode| {
            let value = |at: &usize| target.by_hit[*at].as_ref().map(|row| row[mode]);
            let values = hits.iter().map(|at| value(at).unwrap_or_default());
            values.collect::<Vec<Complex64>>()
        })
    });
    let columns: Vec<Vec<Complex64>> = columns.collect();
    let basis = orthonormal(&columns);
    let part = |i: usize| basis.iter().map(|q| q[i].norm_sqr()).sum();
    (hits.len() > basis.len()).then(|| (0..hits.len()).map(part).collect())
}
