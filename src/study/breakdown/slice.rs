//! A slice draws its cells, runs every method in each, and halves cells at the contour of a method.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::identify::{IdentifyOptions, identify};
use crate::scene::Observer;
use crate::study::Meter;
use crate::synth::SynthError;

use super::draw::{Draw, draw_random};
use super::failure_mode::{FAILURE_MODES, first_failure};
use super::{Axis, Case, FailureMode, Field, Grid, Node, StatedError, wilson_interval};

/// Smallest success rate inside a contour: fraction of the draws in which a method meets the stated
/// error.
pub const MIN_SUCCESS_RATE: f64 = 0.95;

/// A method with a lower success rate in its first draws runs no further draws of a cell: a method
/// at 95 % falls below it once in 10⁹ cells.
const MIN_FIRST_SUCCESS_RATE: f64 = 0.5;
const FIRST_DRAWS: usize = 16;

/// A checked slice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slice {
    /// Its name, also that of its files.
    pub name: String,
    /// First axis.
    pub x: Axis,
    /// Second axis.
    pub y: Axis,
    /// Parameters that the slice does not vary.
    pub case: Case,
    /// Names of the methods.
    pub methods: Vec<String>,
    /// Largest errors that count as success.
    pub stated: StatedError,
    /// Draws for each cell.
    pub draws: u32,
    /// Halvings of cells near a contour.
    pub refine: u32,
    /// Seed of all slices.
    pub seed: u64,
}

/// Successes and failures of a method in a cell.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SuccessCount {
    /// Draws.
    pub draws: u32,
    /// Draws in which the method met the stated error.
    pub good: u32,
    /// Draws with each of [`FAILURE_MODES`].
    #[serde(rename = "symptoms")]
    pub failures: Vec<u32>,
}

impl SuccessCount {
    fn new(failures: &[Option<FailureMode>]) -> Self {
        let mut by_mode = vec![0; FAILURE_MODES.len()];
        for failure in failures.iter().flatten() {
            by_mode[failure.index()] += 1;
        }
        let failed: u32 = by_mode.iter().sum();
        let draws = failures.len() as u32;
        Self {
            draws,
            good: draws - failed,
            failures: by_mode,
        }
    }

    /// Fraction of the draws in which the method meets the stated error.
    pub fn success_rate(&self) -> f64 {
        f64::from(self.good) / f64::from(self.draws.max(1))
    }

    /// Whether the success rate is [`MIN_SUCCESS_RATE`] or more.
    pub fn is_inside(&self) -> bool {
        self.success_rate() >= MIN_SUCCESS_RATE
    }
}

/// A cell of a slice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// Its node in the finest grid.
    pub node: Node,
    /// Value of the first axis.
    pub x: f64,
    /// Value of the second axis.
    pub y: f64,
    /// By method; `None` for a method for which the cell was not added.
    pub counts: Vec<Option<SuccessCount>>,
}

/// A finished slice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SliceResult {
    /// The slice.
    pub slice: Slice,
    /// Its cells by column, then row.
    pub cells: Vec<Cell>,
}

/// Processor time of a method in a slice.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MethodTime {
    /// The method.
    pub method: String,
    /// Identifications.
    pub draws: u32,
    /// Their processor time; `None` where it is not measured.
    pub cpu_s: Option<f64>,
}

/// Success rate that a field shows: as counted, or an end of its confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SuccessRate {
    /// Successes over draws.
    Counted,
    /// Lower end of its interval: inside its contour the method succeeds with 97.5 % confidence.
    Lower,
    /// Upper end: outside its contour the method fails with 97.5 % confidence.
    Upper,
}

impl Slice {
    /// The grid of its cells.
    pub fn grid(&self) -> Grid {
        Grid {
            x: self.x,
            y: self.y,
            levels: self.refine,
        }
    }

    /// Whether its draws are hammer tests.
    pub fn needs_test(&self) -> bool {
        let recorded = self.x.factor.needs_test() || self.y.factor.needs_test();
        recorded || self.case.window_end.is_some() || self.case.bits.is_some()
    }

    fn case_at(&self, x: f64, y: f64) -> Case {
        let case = self.case.clone();
        case.with(self.x.factor, x).with(self.y.factor, y)
    }

    /// Draws all cells.
    ///
    /// # Errors
    /// [`SynthError`] where a cell's case cannot be drawn.
    pub fn run(
        &self,
        observer: &dyn Observer,
        meter: &dyn Meter,
    ) -> Result<(SliceResult, Vec<MethodTime>), SynthError> {
        let grid = self.grid();
        let mut run = SliceRun::new(self, meter);
        let all = vec![true; self.methods.len()];
        let base: Wanted = grid
            .base_nodes()
            .into_iter()
            .map(|n| (n, all.clone()))
            .collect();
        run.draw(&base, 0, observer)?;
        for level in 1..=self.refine {
            let wanted = run.wanted(level);
            run.draw(&wanted, level, observer)?;
        }
        Ok(run.finish())
    }
}

/// Nodes with the methods that are tried there.
type Wanted = BTreeMap<Node, Vec<bool>>;

/// The state of a running slice.
struct SliceRun<'a> {
    slice: &'a Slice,
    grid: Grid,
    meter: &'a dyn Meter,
    counts: BTreeMap<Node, Vec<Option<SuccessCount>>>,
    times: Vec<MethodTime>,
}

impl<'a> SliceRun<'a> {
    fn new(slice: &'a Slice, meter: &'a dyn Meter) -> Self {
        let time = |method: &String| MethodTime {
            method: method.clone(),
            ..MethodTime::default()
        };
        Self {
            slice,
            grid: slice.grid(),
            meter,
            counts: BTreeMap::new(),
            times: slice.methods.iter().map(time).collect(),
        }
    }

    /// The nodes of a halving, each with the methods whose contour it is near.
    fn wanted(&self, level: u32) -> Wanted {
        let methods = self.slice.methods.len();
        let mut wanted = Wanted::new();
        for method in 0..methods {
            let cells = self.counts.iter();
            let inside = cells.filter_map(|(node, counts)| {
                let count = counts[method].as_ref()?;
                Some((*node, count.is_inside()))
            });
            let nodes: BTreeSet<Node> = self.grid.nodes_of_halving(level, &inside.collect());
            for node in nodes {
                wanted.entry(node).or_insert(vec![false; methods])[method] = true;
            }
        }
        wanted
    }

    fn draw(
        &mut self,
        wanted: &Wanted,
        level: u32,
        observer: &dyn Observer,
    ) -> Result<(), SynthError> {
        let what = match level {
            0 => self.slice.name.clone(),
            _ => format!(
                "{}, halved {level} of {}",
                self.slice.name, self.slice.refine
            ),
        };
        for (number, (node, methods)) in wanted.iter().enumerate() {
            observer.step(&what, number + 1, wanted.len());
            let new_counts = self.cell(*node, methods)?;
            let counts = self
                .counts
                .entry(*node)
                .or_insert(vec![None; methods.len()]);
            for (count, new) in counts.iter_mut().zip(new_counts) {
                *count = new.or(count.take());
            }
        }
        Ok(())
    }

    /// All draws of a cell, then all draws with one method after another: the time of a method
    /// contains no work of another.
    fn cell(
        &mut self,
        node: Node,
        methods: &[bool],
    ) -> Result<Vec<Option<SuccessCount>>, SynthError> {
        let slice = self.slice;
        let (x, y) = self.grid.values(node);
        let case = slice.case_at(x, y);
        let coordinates = [(slice.x.factor, x), (slice.y.factor, y)];
        let needs_test = slice.needs_test();
        let one = |number: u32| {
            let random = draw_random(slice.seed, coordinates, number);
            match needs_test {
                true => Draw::from_test(&case, random),
                false => Draw::from_frfs(&case, random),
            }
        };
        let draws: Result<Vec<Draw>, SynthError> =
            (0..slice.draws).into_par_iter().map(one).collect();
        let draws = draws?;
        let of_method = |(index, wanted): (usize, &bool)| {
            wanted.then(|| self.count_successes(index, case.order, &draws))
        };
        Ok(methods.iter().enumerate().map(of_method).collect())
    }

    fn count_successes(
        &mut self,
        index: usize,
        order: Option<usize>,
        draws: &[Draw],
    ) -> SuccessCount {
        let name = &self.slice.methods[index];
        let stated = &self.slice.stated;
        let mut failures: Vec<Option<FailureMode>> = Vec::new();
        let (first, later) = draws.split_at(FIRST_DRAWS.min(draws.len()));
        let cost = self.meter.measure(&mut || {
            let of = |draw: &Draw| failure(draw, name, order, stated);
            failures = first.par_iter().map(of).collect();
            if SuccessCount::new(&failures).success_rate() >= MIN_FIRST_SUCCESS_RATE {
                failures.par_extend(later.par_iter().map(of));
            }
        });
        let time = &mut self.times[index];
        time.draws += failures.len() as u32;
        time.cpu_s = cost
            .cpu_s
            .map(|seconds| seconds + time.cpu_s.unwrap_or(0.0));
        SuccessCount::new(&failures)
    }

    fn finish(self) -> (SliceResult, Vec<MethodTime>) {
        let cell = |(node, counts): (Node, Vec<Option<SuccessCount>>)| {
            let (x, y) = self.grid.values(node);
            Cell { node, x, y, counts }
        };
        let result = SliceResult {
            slice: self.slice.clone(),
            cells: self.counts.into_iter().map(cell).collect(),
        };
        (result, self.times)
    }
}

/// Failure mode of a method in a draw; `None` for a success.
fn failure(
    draw: &Draw,
    method: &str,
    order: Option<usize>,
    stated: &StatedError,
) -> Option<FailureMode> {
    let Ok(set) = &draw.set else {
        return Some(FailureMode::NoAnswer);
    };
    let mut options = IdentifyOptions {
        method: method.to_owned(),
        band: Some(draw.band),
        ..IdentifyOptions::default()
    };
    options.estimator.max_order = order;
    match identify(set, &options) {
        Err(_) => Some(FailureMode::NoAnswer),
        Ok(found) => first_failure(&draw.truth, &found, &draw.responses, stated),
    }
}

impl SliceResult {
    /// Success rate of a method on the finest grid.
    pub fn field(&self, method: usize, rate: SuccessRate) -> Field {
        let value = |count: &SuccessCount| match rate {
            SuccessRate::Counted => count.success_rate(),
            SuccessRate::Lower => wilson_interval(count.good, count.draws).0,
            SuccessRate::Upper => wilson_interval(count.good, count.draws).1,
        };
        let cells = self.cells.iter();
        let values = cells.filter_map(|cell| {
            let count = cell.counts[method].as_ref()?;
            Some((cell.node, value(count)))
        });
        self.slice.grid().interpolate(&values.collect())
    }

    /// Most frequent failure mode of a method, and its share of the failed draws. Failures count
    /// just outside the contour, in cells where at least half of the draws succeed; without such
    /// cells, all failures count.
    pub fn most_frequent_failure(&self, method: usize) -> Option<(FailureMode, f64)> {
        let counts = || {
            let cells = self.cells.iter();
            cells.filter_map(|cell| cell.counts[method].as_ref())
        };
        let near = sum(counts().filter(|count| !count.is_inside() && count.success_rate() >= 0.5));
        let failures = match near.iter().sum::<u32>() {
            0 => sum(counts()),
            _ => near,
        };
        let all: u32 = failures.iter().sum();
        // Of equally frequent failure modes the first.
        let most_frequent = (0..failures.len())
            .rev()
            .max_by_key(|index| failures[*index])?;
        (all > 0).then(|| {
            (
                FAILURE_MODES[most_frequent],
                f64::from(failures[most_frequent]) / f64::from(all),
            )
        })
    }

    /// Draws of all its methods.
    pub fn draws(&self) -> u64 {
        let counts = self
            .cells
            .iter()
            .flat_map(|cell| cell.counts.iter().flatten());
        counts.map(|count| u64::from(count.draws)).sum()
    }
}

fn sum<'a>(counts: impl Iterator<Item = &'a SuccessCount>) -> Vec<u32> {
    let mut total = vec![0; FAILURE_MODES.len()];
    for count in counts {
        for (all, draws) in total.iter_mut().zip(&count.failures) {
            *all += draws;
        }
    }
    total
}
