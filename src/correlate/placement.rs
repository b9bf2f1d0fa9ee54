//! Where to hit or put a sensor next: the fewest points that show all roots that any of the given points can show.
//!
//! A root of m modes with unit modal masses has the strengths `G = Φ_R Φ_Hᵀ` at the responses R and hits H. As many of its modes are
//! seen as G, eliminated with complete pivoting, has pivots that stand over the noise: for a single root, that is its best pair, for a
//! repeated one the independent looks at it. Points are added one by one, each time the one that shows most; where no single one shows
//! more, a hit and a sensor together.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::axis::Band;
use crate::dof::Dof;
use crate::frf::FrfSet;
use crate::modal::ModalModel;

use super::observability::{
    LARGEST_STD_OF_SPACING, NotJudged, PEAK_OVER_NOISE_DB, Peak, STILL, Sight, over_root_mass,
};
use super::roots::Root;
use super::subspace::orthonormal;

/// Points that a test could have.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidates {
    /// Points that can be hit.
    pub hits: Vec<Dof>,
    /// Points that can carry a sensor.
    pub sensors: Vec<Dof>,
}

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

/// What a test and its additions see of one root.
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
    /// Peak over noise of the last mode that is seen, or else of the next, in dB, with every point that there is; `None` where none
    /// moves.
    pub peak_over_noise_db: Option<f64>,
    /// Peak over noise that is needed: 10 dB, or more where the next root is near.
    pub needed_db: f64,
    /// Whether every point that can be hit stands still in it, and every that can carry a sensor.
    pub still: [bool; 2],
}

/// What a hit at one point is worth with the sensors there are.
#[derive(Clone, Debug, PartialEq)]
pub struct RankedHit {
    /// Where.
    pub dof: Dof,
    /// Modes of the band that it shows by itself.
    pub shown: usize,
    /// Mean over the roots of its driving-point residue `φ²/(2 ω m)`, as a part of the largest such mean.
    pub driving_point_residue: f64,
    /// Effective independence: what of its row of the mode matrix no other point that can be hit has, 0 to 1.
    pub independence: f64,
}

/// Points that a test should have beside its own, so that all roots of a band are seen that any of the candidates can show.
///
/// The noise at a new pair is that of the test's functions at the root: the median over those with the same response, or over all.
/// A mode is seen when its pivot stands 10 dB over the noise and tells its frequency to a quarter of the distance to the next root, as
/// in [`observability`](fn@super::observability).
///
/// # Errors
/// [`NotJudged`] where masses, damping or noise are not known.
///
/// # Reference
/// Kammer (1991), Journal of Guidance, Control, and Dynamics 14, eq. 11 (effective independence); Ewins (2000), Modal Testing, 2nd ed.,
/// section 3.9 (driving-point residues).
pub fn placement(
    (theory, test, frfs): (&ModalModel, &ModalModel, &[FrfSet]),
    band: Band,
    candidates: &Candidates,
) -> Result<Placement, NotJudged> {
    let sight = Sight::new(theory, test, frfs);
    let own = Points::of_test(frfs);
    let all = own.with(candidates);
    let targets = (0..sight.roots().len())
        .filter(|r| band.contains(sight.roots()[*r].hz))
        .map(|r| Target::new((&sight, r), (theory, frfs), &all))
        .collect::<Result<Vec<_>, _>>()?;
    let ranking = ranking(&targets, &own, &candidates.hits);
    let seen = |points: &Points| {
        targets
            .iter()
            .map(|own| own.seen(points))
            .collect::<Vec<_>>()
    };
    let mut points = own.clone();
    let mut steps = Vec::new();
    while let Some(step) = next(&targets, &points, candidates) {
        points.add(&step);
        steps.push(step);
    }
    let roots = targets.iter().zip(seen(&own)).zip(seen(&points));
    let roots = roots.map(|((target, seen), planned)| PlannedRoot {
        modes: target.root.modes.clone(),
        hz: target.root.hz,
        seen,
        planned,
        peak_over_noise_db: target.peak_db(planned),
        needed_db: 10.0 * target.needed.log10(),
        still: [
            target.still(&target.by_hit, &candidates.hits),
            target.still(&target.by_response, &candidates.sensors),
        ],
    });
    Ok(Placement {
        roots: roots.collect(),
        steps,
        ranking,
    })
}

/// The points that show most beside those there are.
fn next(targets: &[Target<'_>], points: &Points, candidates: &Candidates) -> Option<Step> {
    let hits = candidates
        .hits
        .iter()
        .filter(|dof| !points.hits.contains(*dof));
    let sensors = candidates.sensors.iter();
    let sensors = sensors.filter(|dof| !points.responses.contains(*dof));
    let single = hits
        .map(Step::hit)
        .chain(sensors.map(Step::sensor))
        .collect::<Vec<_>>();
    best(targets, points, single).or_else(|| {
        let both = targets.iter().filter_map(|own| own.best_pair(points));
        best(targets, points, both.collect())
    })
}

/// The step that shows most modes, and of those the one that shows them best.
fn best(targets: &[Target<'_>], points: &Points, steps: Vec<Step>) -> Option<Step> {
    let before: Vec<usize> = targets.iter().map(|own| own.seen(points)).collect();
    let judged = steps.into_iter().filter_map(|mut step| {
        let mut with = points.clone();
        with.add(&step);
        let mut weakest = f64::INFINITY;
        for (number, (target, before)) in targets.iter().zip(&before).enumerate() {
            let ratios = target.ratios(&with);
            let seen = ratios.iter().filter(|ratio| **ratio >= 1.0).count();
            if seen > *before {
                step.shown.push((number, seen - before));
                weakest = weakest.min(ratios[seen - 1]);
            }
        }
        let gain: usize = step.shown.iter().map(|(_, modes)| modes).sum();
        (gain > 0).then_some((gain, weakest, step))
    });
    // The first of equally good ones.
    let best = judged.reduce(|a, b| {
        let order = (a.0.cmp(&b.0)).then(a.1.total_cmp(&b.1));
        if order.is_lt() { b } else { a }
    });
    best.map(|(_, _, step)| step)
}

fn ranking(targets: &[Target<'_>], own: &Points, hits: &[Dof]) -> Vec<RankedHit> {
    let residue = |dof: &Dof| {
        let of = |target: &Target<'_>| -> Option<f64> {
            let row = target.row(&target.by_hit, dof)?;
            Some(squared(row) / (2.0 * TAU * target.root.hz))
        };
        targets.iter().filter_map(of).sum::<f64>()
    };
    let largest = hits.iter().map(residue).fold(0.0, f64::max);
    let independence = independence(targets, hits);
    let ranked = hits.iter().zip(independence).map(|(dof, independence)| {
        let alone = Points {
            hits: BTreeSet::from([dof.clone()]),
            ..own.clone()
        };
        RankedHit {
            dof: dof.clone(),
            shown: targets.iter().map(|own| own.seen(&alone)).sum(),
            driving_point_residue: if largest > 0.0 {
                residue(dof) / largest
            } else {
                0.0
            },
            independence,
        }
    });
    let mut ranked: Vec<RankedHit> = ranked.collect();
    ranked.sort_by(|a, b| {
        let by_residue = b.driving_point_residue.total_cmp(&a.driving_point_residue);
        b.shown.cmp(&a.shown).then(by_residue)
    });
    ranked
}

/// Diagonal of the projector on the columns of the mode matrix.
fn independence(targets: &[Target<'_>], hits: &[Dof]) -> Vec<f64> {
    let columns = targets.iter().flat_map(|target| {
        (0..target.root.modes.len()).map(move |mode| {
            let value = |dof: &Dof| target.row(&target.by_hit, dof).map(|row| row[mode]);
            let values = hits.iter().map(|dof| value(dof).unwrap_or_default());
            values.collect::<Vec<Complex64>>()
        })
    });
    let columns: Vec<Vec<Complex64>> = columns.collect();
    let basis = orthonormal(&columns);
    let part = |i: usize| basis.iter().map(|q| q[i].norm_sqr()).sum();
    (0..hits.len()).map(part).collect()
}

/// Responses and hits.
#[derive(Clone, Debug)]
struct Points {
    responses: BTreeSet<Dof>,
    hits: BTreeSet<Dof>,
}

impl Points {
    fn of_test(frfs: &[FrfSet]) -> Self {
        let functions = || frfs.iter().flat_map(FrfSet::functions);
        Self {
            responses: functions().map(|own| own.response.clone()).collect(),
            hits: functions().map(|own| own.reference.clone()).collect(),
        }
    }

    fn with(&self, candidates: &Candidates) -> Self {
        let mut all = self.clone();
        all.responses.extend(candidates.sensors.iter().cloned());
        all.hits.extend(candidates.hits.iter().cloned());
        all
    }

    fn add(&mut self, step: &Step) {
        self.hits.extend(step.hit.clone());
        self.responses.extend(step.sensor.clone());
    }
}

impl Step {
    fn hit(dof: &Dof) -> Self {
        Self {
            hit: Some(dof.clone()),
            sensor: None,
            shown: Vec::new(),
        }
    }

    fn sensor(dof: &Dof) -> Self {
        Self {
            hit: None,
            sensor: Some(dof.clone()),
            shown: Vec::new(),
        }
    }
}

/// A root to be seen: its shapes over the square roots of modal masses, 1/√kg, at all points there are.
struct Target<'a> {
    root: &'a Root,
    /// Rows of shape values, times what a unit of strength rises over the noise of that response.
    by_response: Rows,
    by_hit: Rows,
    /// Power over noise that is needed.
    needed: f64,
    /// Strength over noise below which there is but rounding.
    rounding: f64,
}

type Rows = Vec<(Dof, Vec<Complex64>)>;

impl<'a> Target<'a> {
    fn new(
        (sight, r): (&'a Sight<'_>, usize),
        (theory, frfs): (&ModalModel, &[FrfSet]),
        all: &Points,
    ) -> Result<Self, NotJudged> {
        let root = &sight.roots()[r];
        let ratio = sight.damping(root).ok_or(NotJudged::DampingRatio)?.ratio;
        let set = frfs.first().ok_or(NotJudged::Variance)?;
        let peak = Peak::new(root.hz, ratio, set);
        let noise = |dof: &Dof| noise(&peak, frfs, dof).ok_or(NotJudged::Variance);
        let row = |dof: &Dof| -> Result<Option<Vec<Complex64>>, NotJudged> {
            let value = |j: &usize| over_root_mass(&theory.modes[*j], dof);
            let row = root.modes.iter().map(value);
            let row: Option<Vec<Complex64>> = row.collect::<Result<_, _>>()?;
            // What rounding leaves of a point that stands still is nothing.
            let limit = STILL * sight.largest(dof);
            Ok(row.map(|mut row| {
                if squared(&row).sqrt() <= limit {
                    row.fill(Complex64::ZERO);
                }
                row
            }))
        };
        let (mut by_hit, mut by_response) = (Vec::new(), Vec::new());
        for dof in &all.hits {
            by_hit.extend(row(dof)?.map(|row| (dof.clone(), row)));
        }
        for dof in &all.responses {
            let height = (peak.height_squared(set, 0, 1.0) / noise(dof)?).sqrt();
            let scaled = |row: Vec<Complex64>| row.iter().map(|value| value * height).collect();
            by_response.extend(row(dof)?.map(|row| (dof.clone(), scaled(row))));
        }
        let spacing = sight.spacing_hz(r).unwrap_or(f64::INFINITY);
        let told_apart =
            peak.variance_of_unit_peak() / (TAU * LARGEST_STD_OF_SPACING * spacing).powi(2);
        let largest = |rows: &Rows| rows.iter().map(|(_, row)| squared(row)).fold(0.0, f64::max);
        Ok(Self {
            needed: 10f64.powf(PEAK_OVER_NOISE_DB / 10.0).max(told_apart),
            rounding: STILL * (largest(&by_hit) * largest(&by_response)).sqrt(),
            root,
            by_response,
            by_hit,
        })
    }

    fn row<'r>(&self, rows: &'r Rows, dof: &Dof) -> Option<&'r [Complex64]> {
        let at = rows.binary_search_by(|(own, _)| own.cmp(dof)).ok()?;
        Some(&rows[at].1)
    }

    /// Strengths over the noise of all responses at all hits.
    fn strengths(&self) -> Vec<Vec<Complex64>> {
        let product = |a: &[Complex64], b: &[Complex64]| a.iter().zip(b).map(|(x, y)| x * y).sum();
        let of = |(_, response): &(Dof, Vec<Complex64>)| {
            let hits = self.by_hit.iter();
            hits.map(|(_, hit)| product(response, hit)).collect()
        };
        self.by_response.iter().map(of).collect()
    }

    fn is_at(&self, points: &Points, (response, hit): (usize, usize)) -> bool {
        points.responses.contains(&self.by_response[response].0)
            && points.hits.contains(&self.by_hit[hit].0)
    }

    /// Power over noise of every pivot at some points, over the power that is needed.
    fn ratios(&self, points: &Points) -> Vec<f64> {
        let mut strengths = self.strengths();
        let pivots = self.root.modes.iter().map_while(|_| {
            let (_, pivot) = eliminate(&mut strengths, |at| self.is_at(points, at))?;
            (pivot > self.rounding).then_some(pivot * pivot / self.needed)
        });
        pivots.collect()
    }

    fn seen(&self, points: &Points) -> usize {
        self.ratios(points)
            .iter()
            .filter(|ratio| **ratio >= 1.0)
            .count()
    }

    /// The response and the hit that show one mode more than some points do.
    fn best_pair(&self, points: &Points) -> Option<Step> {
        let seen = self.seen(points);
        if seen == self.root.modes.len() {
            return None;
        }
        let mut strengths = self.strengths();
        for _ in 0..seen {
            eliminate(&mut strengths, |at| self.is_at(points, at))?;
        }
        let ((response, hit), pivot) = eliminate(&mut strengths, |_| true)?;
        (pivot > self.rounding && pivot * pivot >= self.needed).then(|| Step {
            hit: Some(self.by_hit[hit].0.clone()),
            sensor: Some(self.by_response[response].0.clone()),
            shown: Vec::new(),
        })
    }

    /// Peak over noise with every point there is: of the last mode when so many are seen, else of the next.
    fn peak_db(&self, planned: usize) -> Option<f64> {
        let mut strengths = self.strengths();
        let wanted = (planned + 1).min(self.root.modes.len());
        let pivots = (0..wanted).map_while(|_| eliminate(&mut strengths, |_| true));
        let last = pivots.map(|(_, pivot)| pivot).nth(wanted - 1)?;
        (last > self.rounding).then(|| 20.0 * last.log10())
    }

    fn still(&self, rows: &Rows, points: &[Dof]) -> bool {
        let mut own = points.iter().filter_map(|dof| self.row(rows, dof));
        own.all(|row| squared(row) == 0.0)
    }
}

/// The largest of the allowed entries, with its place; what its row and column tell of the others is taken out of them.
fn eliminate(
    matrix: &mut [Vec<Complex64>],
    allowed: impl Fn((usize, usize)) -> bool,
) -> Option<((usize, usize), f64)> {
    let entries = matrix.iter().enumerate().flat_map(|(i, row)| {
        row.iter()
            .enumerate()
            .map(move |(j, value)| ((i, j), value.norm()))
    });
    let allowed = entries.filter(|(at, _)| allowed(*at));
    let (at, largest) = allowed.max_by(|a, b| a.1.total_cmp(&b.1))?;
    if largest <= 0.0 {
        return Some((at, 0.0));
    }
    let pivot_row = matrix[at.0].clone();
    let pivot = pivot_row[at.1];
    for row in matrix.iter_mut() {
        let factor = row[at.1] / pivot;
        row.iter_mut()
            .zip(&pivot_row)
            .for_each(|(value, own)| *value -= factor * own);
    }
    Some((at, largest))
}

/// Mean square of the noise at a response: the median over its functions, or over all.
fn noise(peak: &Peak, frfs: &[FrfSet], response: &Dof) -> Option<f64> {
    let of = |own: bool| {
        let functions = frfs
            .iter()
            .flat_map(|set| (0..set.len()).map(move |i| (set, i)));
        let functions =
            functions.filter(|(set, i)| !own || set.functions()[*i].response == *response);
        let mut levels: Vec<f64> = functions
            .filter_map(|(set, i)| peak.noise_squared(set, i))
            .collect();
        levels.sort_by(f64::total_cmp);
        levels.get(levels.len() / 2).copied()
    };
    of(true)
        .or_else(|| of(false))
        .map(|level| level.max(f64::MIN_POSITIVE))
}

fn squared(row: &[Complex64]) -> f64 {
    row.iter().map(Complex64::norm_sqr).sum()
}
