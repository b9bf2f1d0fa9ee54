//! Placement selects the minimum number of excitation and response points that detect all roots
//! that any candidates can detect.
//!
//! A root of m modes with unit modal masses has the strengths `G = Φ_R Φ_Hᵀ` at the responses R and
//! hits H. The number of its detected modes is the number of pivots of G above the noise, with
//! complete pivoting over the measured pairs: the best pair of a single root, the independent pairs
//! of a repeated one. Points are added one by one, each time the one that detects most; where no
//! single one detects more, a hit and a sensor together.

use std::f64::consts::TAU;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::axis::Band;
use crate::dof::Dof;
use crate::frf::FrfSet;
use crate::modal::ModalModel;

use super::observability::{NotAssessed, ObservabilityModel};
use super::placement_candidates::{
    AddedPoints, AllPoints, Candidates, NewPoints, ShapeRow, TargetRoot, squared_length,
};
use super::subspace::orthonormal;

/// Points to add to a test.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Points, the most useful first.
    pub steps: Vec<Step>,
    /// The elastic roots of the band, ascending.
    pub roots: Vec<PlannedRoot>,
    /// The candidate excitation points, those first that detect most with the present sensors.
    pub ranking: Vec<RankedHit>,
}

/// A point, or an excitation point and a sensor, to be added.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Excitation point.
    pub hit: Option<Dof>,
    /// Sensor.
    pub sensor: Option<Dof>,
    /// Indices into [`Placement::roots`], each with the number of modes that the step adds.
    pub shown: Vec<(usize, usize)>,
}

/// Detectability of one root by a test and its additions.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedRoot {
    /// Indices of its modes.
    pub modes: Vec<usize>,
    /// Natural frequency, Hz.
    pub hz: f64,
    /// Number of modes that the test detects.
    pub seen: usize,
    /// Number of modes detected with all added points.
    pub planned: usize,
    /// Peak over noise with all candidates, dB, of the first mode that is not detected, else of the
    /// last; `None` where the points have nodes of it.
    pub peak_over_noise_db: Option<f64>,
    /// Whether all excitation points are at nodes of the root, and whether all sensors are.
    pub at_nodes: [bool; 2],
}

/// Value of an excitation point with the present sensors.
#[derive(Clone, Debug, PartialEq)]
pub struct RankedHit {
    /// The point.
    pub dof: Dof,
    /// Number of modes of the band that this point alone detects.
    pub shown: usize,
    /// Mean over the roots of its driving-point residue `φ²/(2 ω m)`, over the largest such mean.
    pub driving_point_residue: f64,
    /// Effective independence: the part of its row of the mode matrix that the rows of the other
    /// candidates do not contain, 0 to 1; `None` where there are no more points than independent
    /// rows.
    pub independence: Option<f64>,
}

/// Points that a test should have in addition, so that it detects all roots of a band that any
/// candidates can detect.
///
/// A new hit makes a pair with every sensor, a new sensor one with every hit: points that were hit
/// before are hit again. The noise of a new pair is that of the test's FRFs at the root: the median
/// over those with the same response, or over all, each relative to the peak in its quantity. A
/// mode is detected when its pivot is 10 dB above the noise, and all pairs together determine its
/// frequency to a quarter of the distance to the next root, as in
/// [`observability`](fn@super::observability).
///
/// Without a band all elastic roots count.
///
/// # Errors
/// [`NotAssessed`] where masses, damping or noise are not known.
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
) -> Result<Placement, NotAssessed> {
    let model = ObservabilityModel::new(theory, test, frfs);
    let all = AllPoints::new(frfs, candidates);
    let targets = (0..model.roots.len())
        .filter(|r| band.is_none_or(|band| band.contains(model.roots[*r].hz)))
        .map(|r| TargetRoot::new(&model, r, &all))
        .collect::<Result<Vec<_>, _>>()?;
    let none_added = AddedPoints::default();
    let mut added = none_added.clone();
    let mut steps = Vec::new();
    while let Some((points, shown)) = next(&targets, &all, &added) {
        added.add(&points);
        steps.push(Step {
            hit: points.hit.map(|at| all.hits[at].clone()),
            sensor: points.sensor.map(|at| all.responses[at].clone()),
            shown,
        });
    }
    let all_added = AddedPoints {
        hits: all.new_hits.clone(),
        sensors: all.new_sensors.clone(),
    };
    let planned_root = |target: &TargetRoot<'_>| {
        let planned = target.seen(&all, &added);
        PlannedRoot {
            modes: target.root.modes.clone(),
            hz: target.root.hz,
            seen: target.seen(&all, &none_added),
            planned,
            peak_over_noise_db: target.peak_db(&all, &all_added, planned),
            at_nodes: [
                are_at_nodes(&target.by_hit),
                are_at_nodes(&target.by_response),
            ],
        }
    };
    Ok(Placement {
        roots: targets.par_iter().map(planned_root).collect(),
        steps,
        ranking: ranking(&targets, &all),
    })
}

fn are_at_nodes(rows: &[ShapeRow]) -> bool {
    rows.iter().flatten().all(|row| squared_length(row) == 0.0)
}

type Shown = Vec<(usize, usize)>;

/// The next points to add, with the modes that they add.
fn next(
    targets: &[TargetRoot<'_>],
    all: &AllPoints,
    added: &AddedPoints,
) -> Option<(NewPoints, Shown)> {
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

/// The step that adds most modes, and of those the first with the highest lowest peak.
fn best(
    targets: &[TargetRoot<'_>],
    all: &AllPoints,
    added: &AddedPoints,
    steps: Vec<NewPoints>,
) -> Option<(NewPoints, Shown)> {
    let before: Vec<usize> = targets
        .iter()
        .map(|target| target.seen(all, added))
        .collect();
    let rated = |step: &NewPoints| {
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
    let rated: Vec<_> = steps.par_iter().map(rated).collect();
    let best = rated
        .into_iter()
        .filter(|(gain, _, _)| *gain > 0)
        .reduce(|a, b| {
            let order = (a.0.cmp(&b.0)).then(a.1.total_cmp(&b.1));
            if order.is_lt() { b } else { a }
        });
    best.map(|(_, _, found)| found)
}

fn ranking(targets: &[TargetRoot<'_>], all: &AllPoints) -> Vec<RankedHit> {
    let residue = |at: usize| -> f64 {
        let of = |target: &TargetRoot<'_>| {
            let row = target.by_hit[at].as_ref()?;
            Some(squared_length(row) / (2.0 * TAU * target.root.hz))
        };
        targets.iter().filter_map(of).sum()
    };
    let largest = all
        .hit_candidates
        .iter()
        .map(|at| residue(*at))
        .fold(0.0, f64::max);
    let independence = independence(targets, &all.hit_candidates);
    let ranked = all
        .hit_candidates
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
fn independence(targets: &[TargetRoot<'_>], hits: &[usize]) -> Option<Vec<f64>> {
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
