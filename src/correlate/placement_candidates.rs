//! Pairs of present and candidate points have a strength over the noise for each root, and detect
//! as many of its modes as they have independent strengths.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::dof::Dof;
use crate::frf::FrfSet;

use super::model_roots::Root;
use super::observability::{
    MAX_FREQUENCY_STD_OVER_SPACING, MIN_PEAK_OVER_NOISE_DB, NODE_FRACTION_OF_LARGEST, NotAssessed,
    ObservabilityModel, Peak, mass_normalised_value,
};

/// Points that a test could have.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidates {
    /// Points that can be hit.
    pub hits: Vec<Dof>,
    /// Points that can carry a sensor.
    pub sensors: Vec<Dof>,
}

/// Points to be added together.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct NewPoints {
    pub hit: Option<usize>,
    pub sensor: Option<usize>,
}

/// Responses and hits of a test, then the candidates, on their positive axes.
#[derive(Clone, Debug)]
pub(super) struct AllPoints {
    pub responses: Vec<Dof>,
    pub hits: Vec<Dof>,
    /// Whether a pair was measured, by response and hit.
    measured: Vec<Vec<bool>>,
    /// Indices of the candidates that the test does not have.
    pub new_hits: Vec<usize>,
    pub new_sensors: Vec<usize>,
    /// Indices of all candidates that can be hit.
    pub hit_candidates: Vec<usize>,
}

impl AllPoints {
    pub fn new(frfs: &[FrfSet], candidates: &Candidates) -> Self {
        let functions = || frfs.iter().flat_map(FrfSet::functions);
        let pairs: BTreeSet<(Dof, Dof)> = functions()
            .map(|pair| (pair.response.positive(), pair.reference.positive()))
            .collect();
        let both = |measured: BTreeSet<Dof>, candidates: &[Dof]| {
            let measured: Vec<Dof> = measured.into_iter().collect();
            let new: BTreeSet<Dof> = candidates.iter().map(Dof::positive).collect();
            let new = new.into_iter().filter(|dof| !measured.contains(dof));
            let all: Vec<Dof> = measured.iter().cloned().chain(new).collect();
            ((measured.len()..all.len()).collect::<Vec<usize>>(), all)
        };
        let names =
            |of: fn(&(Dof, Dof)) -> &Dof| pairs.iter().map(|pair| of(pair).clone()).collect();
        let (new_sensors, responses) = both(names(|pair| &pair.0), &candidates.sensors);
        let (new_hits, hits) = both(names(|pair| &pair.1), &candidates.hits);
        let row = |response: &Dof| {
            let measured = |hit: &Dof| pairs.contains(&(response.clone(), hit.clone()));
            hits.iter().map(measured).collect()
        };
        let candidate: BTreeSet<Dof> = candidates.hits.iter().map(Dof::positive).collect();
        Self {
            measured: responses.iter().map(row).collect(),
            hit_candidates: (0..hits.len())
                .filter(|at| candidate.contains(&hits[*at]))
                .collect(),
            responses,
            hits,
            new_hits,
            new_sensors,
        }
    }

    /// Number of responses and of hits of the test.
    fn counts_of_test(&self) -> [usize; 2] {
        [
            self.responses.len() - self.new_sensors.len(),
            self.hits.len() - self.new_hits.len(),
        ]
    }
}

/// Indices of points that were added.
#[derive(Clone, Debug, Default)]
pub(super) struct AddedPoints {
    pub hits: Vec<usize>,
    pub sensors: Vec<usize>,
}

impl AddedPoints {
    pub fn add(&mut self, points: &NewPoints) {
        self.hits.extend(points.hit);
        self.sensors.extend(points.sensor);
    }
}

/// Mass-normalised values of the modes of a root at a point.
pub(super) type ShapeRow = Option<Vec<Complex64>>;

/// A root to be detected, with its mass-normalised shapes, 1/√kg, at all points.
pub(super) struct TargetRoot<'a> {
    pub root: &'a Root,
    /// Shape values, times the peak of a unit strength over the noise of that response.
    pub by_response: Vec<ShapeRow>,
    pub by_hit: Vec<ShapeRow>,
    /// Sum of the squared peaks over the noise that separates the root from the next.
    power_to_separate: f64,
    /// Strength over noise below which the values are rounding.
    rounding: f64,
}

impl<'a> TargetRoot<'a> {
    pub fn new(
        model: &'a ObservabilityModel<'_>,
        r: usize,
        all: &AllPoints,
    ) -> Result<Self, NotAssessed> {
        let root = &model.roots[r];
        let ratio = model.damping(root).ok_or(NotAssessed::DampingRatio)?.ratio;
        let first = model.frfs.first().ok_or(NotAssessed::Variance)?;
        let heights = PeakHeights::new(root.hz, ratio, model.frfs).ok_or(NotAssessed::Variance)?;
        let row = |dof: &Dof| -> Result<ShapeRow, NotAssessed> {
            let value = |j: &usize| mass_normalised_value(&model.theory.modes[*j], dof);
            let row = root.modes.iter().map(value);
            let row: ShapeRow = row.collect::<Result<_, _>>()?;
            // The values of a node are rounding.
            let limit = NODE_FRACTION_OF_LARGEST * model.largest(dof);
            Ok(row.map(|mut row| {
                if squared_length(&row).sqrt() <= limit {
                    row.fill(Complex64::ZERO);
                }
                row
            }))
        };
        let by_hit = all
            .hits
            .iter()
            .map(row)
            .collect::<Result<Vec<ShapeRow>, _>>()?;
        let scaled = |dof: &Dof| {
            let height = heights.at(dof).sqrt();
            let times =
                |values: Vec<Complex64>| values.iter().map(|value| value * height).collect();
            row(dof).map(|values| values.map(times))
        };
        let by_response = all.responses.iter().map(scaled);
        let by_response = by_response.collect::<Result<Vec<ShapeRow>, _>>()?;
        let spacing = model.spacing_hz(r).unwrap_or(f64::INFINITY);
        let unit = Peak::new(root.hz, ratio, first).variance_of_unit_peak();
        let largest = |rows: &[ShapeRow]| {
            rows.iter()
                .flatten()
                .map(|row| squared_length(row))
                .fold(0.0, f64::max)
        };
        Ok(Self {
            power_to_separate: unit / (TAU * MAX_FREQUENCY_STD_OVER_SPACING * spacing).powi(2),
            rounding: NODE_FRACTION_OF_LARGEST * (largest(&by_hit) * largest(&by_response)).sqrt(),
            root,
            by_response,
            by_hit,
        })
    }

    /// Strengths of the pairs of some responses and hits; `counts` says which are used.
    fn pair_strengths(
        &self,
        responses: Vec<usize>,
        hits: Vec<usize>,
        counts: impl Fn(usize, usize) -> bool,
    ) -> PairStrengths {
        let product = |(r, h): (usize, usize)| {
            let (response, hit) = (self.by_response[r].as_ref()?, self.by_hit[h].as_ref()?);
            Some(
                response
                    .iter()
                    .zip(hit)
                    .map(|(x, y)| x * y)
                    .sum::<Complex64>(),
            )
        };
        let row = |r: &usize| {
            hits.iter()
                .map(|h| product((*r, *h)).unwrap_or_default())
                .collect()
        };
        let known = |r: usize, h: usize| self.by_response[r].is_some() && self.by_hit[h].is_some();
        let counted = |r: &usize| {
            hits.iter()
                .map(|h| known(*r, *h) && counts(*r, *h))
                .collect()
        };
        PairStrengths {
            strengths: responses.iter().map(row).collect(),
            counted: responses.iter().map(counted).collect(),
            responses,
            hits,
        }
    }

    /// Strengths of the pairs of a test with added points.
    fn strengths_with(&self, all: &AllPoints, added: &AddedPoints) -> PairStrengths {
        let [responses, hits] = all.counts_of_test();
        let both =
            |measured: usize, new: &[usize]| (0..measured).chain(new.iter().copied()).collect();
        self.pair_strengths(
            both(responses, &added.sensors),
            both(hits, &added.hits),
            |r, h| r >= responses || h >= hits || all.measured[r][h],
        )
    }

    /// Squared pivots over the minimum, for each detected mode.
    fn detected_ratios(&self, mut strengths: PairStrengths) -> Vec<f64> {
        let ratios = self.root.modes.iter().map_while(|_| {
            let all = strengths.power();
            let (_, pivot) = strengths
                .eliminate()
                .filter(|(_, pivot)| *pivot > self.rounding)?;
            let needed = 10f64.powf(MIN_PEAK_OVER_NOISE_DB / 10.0);
            let ratio = (pivot * pivot / needed).min(all / self.power_to_separate);
            (ratio >= 1.0).then_some(ratio)
        });
        ratios.collect()
    }

    pub fn ratios(&self, all: &AllPoints, added: &AddedPoints) -> Vec<f64> {
        self.detected_ratios(self.strengths_with(all, added))
    }

    pub fn seen(&self, all: &AllPoints, added: &AddedPoints) -> usize {
        self.ratios(all, added).len()
    }

    /// Number of modes that a single hit detects with the test's sensors.
    pub fn seen_alone(&self, all: &AllPoints, hit: usize) -> usize {
        let [responses, _] = all.counts_of_test();
        let strengths = self.pair_strengths((0..responses).collect(), vec![hit], |_, _| true);
        self.detected_ratios(strengths).len()
    }

    /// The response and the hit that detect one mode more than the test with the added points.
    pub fn best_pair(&self, all: &AllPoints, added: &AddedPoints) -> Option<NewPoints> {
        let seen = self.seen(all, added);
        if seen == self.root.modes.len() {
            return None;
        }
        let counted = self.strengths_with(all, added);
        let mut strengths = self.pair_strengths(
            (0..all.responses.len()).collect(),
            (0..all.hits.len()).collect(),
            |r, h| counted.counts(r, h),
        );
        for _ in 0..seen {
            strengths.eliminate()?;
        }
        strengths.count_all();
        let ((response, hit), pivot) = strengths.eliminate()?;
        let [responses, hits] = all.counts_of_test();
        let new = |at: usize, measured: usize, added: &[usize]| {
            (at >= measured && !added.contains(&at)).then_some(at)
        };
        (pivot > self.rounding).then(|| NewPoints {
            hit: new(hit, hits, &added.hits),
            sensor: new(response, responses, &added.sensors),
        })
    }

    /// Peak over noise of the mode after the `planned` ones, or of the last, with all points.
    pub fn peak_db(
        &self,
        all: &AllPoints,
        everything: &AddedPoints,
        planned: usize,
    ) -> Option<f64> {
        let mut strengths = self.strengths_with(all, everything);
        let wanted = (planned + 1).min(self.root.modes.len());
        let pivots = (0..wanted).map_while(|_| strengths.eliminate());
        let last = pivots.map(|(_, pivot)| pivot).nth(wanted - 1)?;
        (last > self.rounding).then(|| 20.0 * last.log10())
    }
}

/// Strengths over noise of a root at pairs of points.
struct PairStrengths {
    responses: Vec<usize>,
    hits: Vec<usize>,
    strengths: Vec<Vec<Complex64>>,
    counted: Vec<Vec<bool>>,
}

impl PairStrengths {
    fn counts(&self, response: usize, hit: usize) -> bool {
        let row = self.responses.iter().position(|dof| *dof == response);
        let column = self.hits.iter().position(|dof| *dof == hit);
        row.zip(column).is_some_and(|(i, j)| self.counted[i][j])
    }

    fn count_all(&mut self) {
        self.counted.iter_mut().for_each(|row| row.fill(true));
    }

    /// The pairs that are used, with their strengths.
    fn entries(&self) -> impl Iterator<Item = ((usize, usize), f64)> + '_ {
        let row = |i: usize| {
            let entries = self.strengths[i].iter().zip(&self.counted[i]).enumerate();
            let entries = entries.filter(|(_, (_, counts))| **counts);
            entries.map(move |(j, (value, _))| ((i, j), value.norm()))
        };
        (0..self.strengths.len()).flat_map(row)
    }

    /// Sum of the squared strengths over noise.
    fn power(&self) -> f64 {
        self.entries()
            .map(|(_, strength)| strength * strength)
            .sum()
    }

    /// The largest used strength, with its response and hit; eliminates its row and column from the
    /// others.
    fn eliminate(&mut self) -> Option<((usize, usize), f64)> {
        let largest = self.entries().max_by(|a, b| a.1.total_cmp(&b.1));
        let ((i, j), largest) = largest.filter(|(_, strength)| *strength > 0.0)?;
        let pivot_row = self.strengths[i].clone();
        for row in &mut self.strengths {
            let factor = row[j] / pivot_row[j];
            row.iter_mut()
                .zip(&pivot_row)
                .for_each(|(value, other)| *value -= factor * other);
        }
        Some(((self.responses[i], self.hits[j]), largest))
    }
}

/// Squared peak of unit strength over the noise, by response.
struct PeakHeights {
    of_response: BTreeMap<Dof, Vec<f64>>,
    of_all: f64,
}

impl PeakHeights {
    /// `None` where no function has a variance at the root.
    fn new(hz: f64, damping_ratio: f64, frfs: &[FrfSet]) -> Option<Self> {
        let mut of_response: BTreeMap<Dof, Vec<f64>> = BTreeMap::new();
        for set in frfs {
            let peak = Peak::new(hz, damping_ratio, set);
            for (i, function) in set.functions().iter().enumerate() {
                let noise = peak
                    .noise_squared(set, i)
                    .map(|level| level.max(f64::MIN_POSITIVE));
                let height = noise.map(|noise| peak.height_squared(set, i, 1.0) / noise);
                of_response
                    .entry(function.response.positive())
                    .or_default()
                    .extend(height);
            }
        }
        let of_all = of_response.values().flatten().copied().collect();
        Some(Self {
            of_all: upper_median(of_all)?,
            of_response,
        })
    }

    fn at(&self, response: &Dof) -> f64 {
        let spectrum = self.of_response.get(response).cloned();
        spectrum.and_then(upper_median).unwrap_or(self.of_all)
    }
}

fn upper_median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

pub(super) fn squared_length(row: &[Complex64]) -> f64 {
    row.iter().map(Complex64::norm_sqr).sum()
}
