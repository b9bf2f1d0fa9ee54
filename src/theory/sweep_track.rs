//! Mode tracking by shape from one value of a parameter to the next.

use std::cell::Cell;
use std::f64::consts::TAU;

use crate::axis::Band;
use crate::linalg::{RealMatrix, real_matrix, symmetric_eigen};

use super::system::{System, SystemSlope};
use super::{ModeOptions, TheoreticalModel, TheoryError};

/// Maximum memory of the shapes at all values of a sweep, bytes. Larger: half the memory of a small
/// machine. Smaller: 2,000 values of a beam of 60 elements are refused.
const MAX_SWEEP_BYTES: usize = 2 << 30;
/// The least share of a shape in the root that it goes over into: a rotation by 18 degrees from one
/// value to the next.
const SAME_SHAPE: f64 = 0.9;
/// Values nearer than this part of their interval's ends are not divided further: a thousand times
/// the rounding.
const NEAREST_VALUES: f64 = 1e-13;
/// Steps to a zero between two values; bisection alone would need 52.
const ZERO_STEPS: usize = 80;
/// Of a sparse model the modes up to this multiple of the highest followed frequency are computed
/// at the next value, among which the followed ones are sought; one that goes beyond is met again
/// at a value nearer by.
const HEADROOM: f64 = 1.25;
/// As many modes where all that are followed are at 0, and no band has an end.
const BESIDE_RIGID: usize = 8;

/// The modes at one value of the parameter, each in its place in the order of the first value.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    pub value: f64,
    pub omega_rad_s: Vec<f64>,
    /// One column per mode, of unit modal mass.
    pub vectors: RealMatrix,
    /// Index of the root of each mode at this value.
    pub root: Vec<usize>,
    /// Frequencies of modes that were computed and are not followed, ascending.
    pub strangers_rad_s: Vec<f64>,
    /// `M Phi` and `K Phi`.
    moved: RealMatrix,
    forces: RealMatrix,
}

impl Sample {
    /// Distance of two modes, rad/s, with its sign; exactly 0 for modes of one root.
    pub fn distance(&self, a: usize, b: usize) -> f64 {
        if self.root[a] == self.root[b] {
            return 0.0;
        }
        self.omega_rad_s[b] - self.omega_rad_s[a]
    }

    /// Distance of the Rayleigh quotients of two shapes, (rad/s)²: tells modes of one root apart,
    /// whose frequency is the mean of the root, by shapes that were followed from where they were
    /// apart.
    fn quotient_distance(&self, a: usize, b: usize) -> f64 {
        let quotient = |mode: usize| -> f64 {
            let parts = (0..self.vectors.nrows()).map(|i| (i, mode));
            parts.map(|at| self.vectors[at] * self.forces[at]).sum()
        };
        quotient(b) - quotient(a)
    }

    /// Share of every coordinate in the kinetic energy, mean over some modes.
    pub fn kinetic_shares(&self, modes: &[usize]) -> Vec<f64> {
        let share = |i: usize| {
            let parts = modes
                .iter()
                .map(|&k| self.vectors[(i, k)] * self.moved[(i, k)]);
            parts.sum::<f64>() / modes.len() as f64
        };
        (0..self.moved.nrows()).map(share).collect()
    }
}

/// Two modes that change their order.
#[derive(Clone, Debug)]
pub(super) struct Meeting {
    /// The one that is lower before first.
    pub modes: [usize; 2],
    /// Last values on both sides at which they are apart.
    pub between: [f64; 2],
    /// Parameter value at which they meet.
    pub place: f64,
}

/// The samples of a sweep, ascending, and where modes change their order.
#[derive(Clone, Debug)]
pub(super) struct ModeTrack {
    pub samples: Vec<Sample>,
    pub meetings: Vec<Meeting>,
}

impl ModeTrack {
    /// The sample at exactly this value.
    pub fn at(&self, value: f64) -> Option<&Sample> {
        let place = self
            .samples
            .binary_search_by(|sample| sample.value.total_cmp(&value));
        place.ok().map(|i| &self.samples[i])
    }

    /// Modes that share one root at every value, in the order of the first one.
    pub fn families(&self) -> Vec<Vec<usize>> {
        let mut families: Vec<Vec<usize>> = Vec::new();
        for mode in 0..self.samples[0].omega_rad_s.len() {
            let together = |family_mode: usize| {
                self.samples
                    .iter()
                    .all(|s| s.root[family_mode] == s.root[mode])
            };
            match families.iter_mut().find(|family| together(family[0])) {
                Some(family) => family.push(mode),
                None => families.push(vec![mode]),
            }
        }
        families
    }
}

/// Solves a model at values of one parameter and follows its modes.
pub(super) struct ModeTracker<'a> {
    model: &'a dyn TheoreticalModel,
    values: &'a [f64],
    j: usize,
    band: Option<Band>,
    /// Modes whose crossings are separated from veerings; all without a list.
    watched: Option<&'a [usize]>,
    solved: Cell<usize>,
}

impl<'a> ModeTracker<'a> {
    /// Of a sparse model all modes up to the end of the band are seen at every value, followed or
    /// not.
    pub fn new(
        model: &'a dyn TheoreticalModel,
        values: &'a [f64],
        j: usize,
        band: Option<Band>,
    ) -> Self {
        let solved = Cell::new(0);
        Self {
            model,
            values,
            j,
            band,
            watched: None,
            solved,
        }
    }

    /// Separates crossings from veerings for these modes alone, at less cost.
    pub fn watching(self, watched: Option<&'a [usize]>) -> Self {
        Self { watched, ..self }
    }

    /// Number of eigenproblems solved.
    pub fn solved(&self) -> usize {
        self.solved.get()
    }

    fn values_at(&self, value: f64) -> Vec<f64> {
        let mut values = self.values.to_vec();
        values[self.j] = value;
        values
    }

    /// All modes at a value; of a sparse system those that the options ask for.
    fn solve(
        &self,
        system: &System,
        value: f64,
        options: &ModeOptions,
    ) -> Result<Sample, TheoryError> {
        self.solved.set(self.solved.get() + 1);
        let all = ModeOptions::default();
        let modes = system.modes(if system.is_sparse() { options } else { &all })?;
        let mut root = vec![0; modes.omega_rad_s.len()];
        for (number, modes_of_root) in modes.model.roots().into_iter().enumerate() {
            modes_of_root
                .into_iter()
                .for_each(|mode| root[mode] = number);
        }
        Ok(Sample {
            value,
            omega_rad_s: modes.omega_rad_s,
            root,
            strangers_rad_s: Vec::new(),
            moved: system.mass(&modes.vectors),
            forces: system.stiffness(&modes.vectors),
            vectors: modes.vectors,
        })
    }

    /// `phi_a^T (dK/dp - lambda dM/dp) phi_b` of all modes of a sample, lambda the mean of both.
    pub fn couplings(&self, sample: &Sample) -> Result<RealMatrix, TheoryError> {
        let by = SystemSlope::of(self.model, &self.values_at(sample.value), self.j)?;
        let phi = &sample.vectors;
        let [mass, stiffness] = by.products(phi).map(|product| phi.transpose() * product);
        let lambda = |a: usize| sample.omega_rad_s[a].powi(2);
        let n = phi.ncols();
        Ok(real_matrix(n, n, |a, b| {
            stiffness[(a, b)] - 0.5 * (lambda(a) + lambda(b)) * mass[(a, b)]
        }))
    }

    /// The modes among which those of a sample nearby are to be found, where not all are computed,
    /// and all up to the end of the band, so that one that comes into it from above is seen.
    fn near(&self, from: &Sample) -> ModeOptions {
        let highest = from.omega_rad_s.iter().copied().fold(0.0, f64::max);
        let end_hz = self.band.map_or(0.0, |band| band.hi_hz);
        let band = Band::new(0.0, end_hz.max(HEADROOM * highest / TAU)).ok();
        let count = from.omega_rad_s.len() + BESIDE_RIGID;
        ModeOptions {
            count: band.is_none().then_some(count),
            band,
            damping_ratio: None,
        }
    }

    /// The modes at a value in the order of a sample nearby; `None` where their shapes do not tell
    /// it.
    pub fn track_to(&self, from: &Sample, value: f64) -> Result<Option<Sample>, TheoryError> {
        let system = System::of(self.model, &self.values_at(value))?;
        let found = self.solve(&system, value, &self.near(from))?;
        let seen = system.mass(&from.vectors);
        let overlap = seen.transpose() * &found.vectors;
        let square = |mode: usize| -> f64 {
            let parts = (0..seen.nrows()).map(|i| (i, mode));
            parts.map(|at| from.vectors[at] * seen[at]).sum()
        };
        let squares: Vec<f64> = (0..seen.ncols()).map(square).collect();
        let Some(root_of_mode) = roots_of_modes(&overlap, &squares, &found.root) else {
            return Ok(None);
        };
        let mut parts: Vec<Vec<(usize, f64)>> = vec![Vec::new(); root_of_mode.len()];
        let mut strangers_rad_s = Vec::new();
        for root in 0..found.root.iter().max().map_or(0, |last| last + 1) {
            let modes: Vec<usize> = (0..root_of_mode.len())
                .filter(|&mode| root_of_mode[mode] == root)
                .collect();
            let columns: Vec<usize> = (0..found.root.len())
                .filter(|&column| found.root[column] == root)
                .collect();
            let strangers = &columns[modes.len()..];
            strangers_rad_s.extend(strangers.iter().map(|&column| found.omega_rad_s[column]));
            let rotation = nearest_rotation(&real_matrix(modes.len(), columns.len(), |t, c| {
                overlap[(modes[t], columns[c])]
            }))?;
            for (t, &mode) in modes.iter().enumerate() {
                let factors = columns.iter().enumerate();
                parts[mode].extend(factors.map(|(c, &column)| (column, rotation[(t, c)])));
            }
        }
        let turned = |all: &RealMatrix| {
            real_matrix(all.nrows(), root_of_mode.len(), |i, mode| {
                let parts = parts[mode].iter();
                parts
                    .map(|&(column, factor)| all[(i, column)] * factor)
                    .sum()
            })
        };
        Ok(Some(Sample {
            value,
            omega_rad_s: parts
                .iter()
                .map(|column| found.omega_rad_s[column[0].0])
                .collect(),
            strangers_rad_s,
            vectors: turned(&found.vectors),
            moved: turned(&found.moved),
            forces: turned(&found.forces),
            root: root_of_mode,
        }))
    }

    /// The modes through all values of a grid; of a sparse model those that the options ask for at
    /// the first value.
    pub fn track(&self, grid: &[f64], options: &ModeOptions) -> Result<ModeTrack, TheoryError> {
        let system = System::of(self.model, &self.values_at(grid[0]))?;
        self.track_from(self.solve(&system, grid[0], options)?, grid)
    }

    /// The modes of a sample at the first value of a grid through all of its values.
    pub fn track_from(&self, first: Sample, grid: &[f64]) -> Result<ModeTrack, TheoryError> {
        self.check_count(grid, &first)?;
        let mut track = ModeTrack {
            samples: vec![first],
            meetings: Vec::new(),
        };
        let mut targets: Vec<f64> = grid[1..].iter().rev().copied().collect();
        while let Some(&target) = targets.last() {
            let from = &track.samples[track.samples.len() - 1];
            match self.step(&track, from, target)? {
                Step::Taken(sample, meetings) => {
                    track.samples.push(*sample);
                    track.meetings.extend(meetings);
                    targets.pop();
                }
                Step::Divided(value) => {
                    let apart = value - from.value > NEAREST_VALUES * value.abs()
                        && target - value > NEAREST_VALUES * value.abs();
                    if !apart {
                        return Err(TheoryError::NotFollowed {
                            parameter: self.model.parameters()[self.j].name.clone(),
                            lower: from.value,
                            upper: target,
                        });
                    }
                    targets.push(value);
                }
            }
        }
        Ok(track)
    }

    /// Checks that the memory has room for the shapes at all values.
    fn check_count(&self, grid: &[f64], first: &Sample) -> Result<(), TheoryError> {
        let matrices = [&first.vectors, &first.moved, &first.forces];
        let elements = matrices.map(|matrix| matrix.nrows() * matrix.ncols());
        let bytes = elements.iter().sum::<usize>() * size_of::<f64>();
        let most = MAX_SWEEP_BYTES / bytes.max(1);
        if grid.len() <= most {
            return Ok(());
        }
        Err(TheoryError::SweepRange {
            parameter: self.model.parameters()[self.j].name.clone(),
            lower: grid[0],
            upper: grid[grid.len() - 1],
            count: grid.len(),
            most,
        })
    }

    fn step(&self, track: &ModeTrack, from: &Sample, target: f64) -> Result<Step, TheoryError> {
        let middle = 0.5 * (from.value + target);
        let Some(to) = self.track_to(from, target)? else {
            return Ok(Step::Divided(middle));
        };
        let mut meetings: Vec<Meeting> = Vec::new();
        let mut seen: Vec<[usize; 4]> = Vec::new();
        for (a, b) in pairs(to.root.len()) {
            let is_watched = |mode| self.watched.is_none_or(|modes| modes.contains(mode));
            if ![a, b].iter().any(is_watched) {
                continue;
            }
            let Some(before) = track.samples.iter().rev().find(|s| s.root[a] != s.root[b]) else {
                continue;
            };
            if before.distance(a, b) * to.distance(a, b) >= 0.0 {
                continue;
            }
            let modes = if before.distance(a, b) > 0.0 {
                [a, b]
            } else {
                [b, a]
            };
            // Modes that share their roots on both sides meet the same others at the same place.
            let key = [before.root[a], before.root[b], to.root[a], to.root[b]];
            if let Some(same) = seen.iter().position(|known_key| *known_key == key) {
                meetings.push(Meeting {
                    modes,
                    ..meetings[same].clone()
                });
                seen.push(key);
                continue;
            }
            match self.meeting(before, &to, modes)? {
                Ok(place) => {
                    let between = [before.value, target];
                    meetings.push(Meeting {
                        modes,
                        between,
                        place,
                    });
                    seen.push(key);
                }
                // The shapes mix on the way: no crossing, or not these two alone.
                Err(value) if value > from.value => return Ok(Step::Divided(value)),
                Err(_) => return Ok(Step::Divided(middle)),
            }
        }
        Ok(Step::Taken(Box::new(to), meetings))
    }

    /// Where two modes meet between two samples; the value at which their shapes cannot be
    /// separated from others.
    fn meeting(
        &self,
        before: &Sample,
        after: &Sample,
        [a, b]: [usize; 2],
    ) -> Result<Result<f64, f64>, TheoryError> {
        let ends = [before, after].map(|sample| (sample.value, sample.quotient_distance(a, b)));
        zero_between(ends, |value| {
            let sample = self.track_to(before, value)?;
            Ok(sample.map(|sample| sample.quotient_distance(a, b)))
        })
    }
}

/// Outcome of a step.
enum Step {
    Taken(Box<Sample>, Vec<Meeting>),
    /// The step was too long: this value between has to be solved first.
    Divided(f64),
}

/// All pairs of `n` things.
pub(super) fn pairs(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |a| (a + 1..n).map(move |b| (a, b)))
}

/// Zero of a function between two values at which it has opposite signs, by the Illinois rule; the
/// value at which it has none, if it meets such a one. Ends at a function value of exactly 0, or
/// when the values are neighbours.
///
/// # Reference
/// Dowell and Jarratt (1971), A modified regula falsi method, BIT 11, 168.
pub(super) fn zero_between<E>(
    [mut low, mut high]: [(f64, f64); 2],
    at: impl Fn(f64) -> Result<Option<f64>, E>,
) -> Result<Result<f64, f64>, E> {
    let mut place = low.0;
    for step in 0..ZERO_STEPS {
        let straight = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let inside = straight > low.0.min(high.0) && straight < low.0.max(high.0);
        // Every fourth step halves, so that a kink cannot hold the rule up.
        place = if inside && step % 4 != 3 {
            straight
        } else {
            0.5 * (low.0 + high.0)
        };
        if (high.0 - low.0).abs() <= NEAREST_VALUES * place.abs() {
            break;
        }
        let Some(found) = at(place)? else {
            return Ok(Err(place));
        };
        if found.abs() <= 0.0 {
            break;
        }
        if found * high.1 < 0.0 {
            low = high;
        } else {
            low.1 *= 0.5;
        }
        high = (place, found);
    }
    Ok(Ok(place))
}

/// The root that each mode (row) goes over into: the one that has most of it, of its square `phi^T
/// M phi`. `None` where there is none, or a root would get more modes than it has.
fn roots_of_modes(overlap: &RealMatrix, squares: &[f64], root: &[usize]) -> Option<Vec<usize>> {
    let n = root.len();
    let mut left = vec![0usize; n];
    root.iter().for_each(|&number| left[number] += 1);
    let mut roots = Vec::with_capacity(squares.len());
    for (mode, square) in squares.iter().enumerate() {
        let mut shares = vec![0.0; n];
        (0..n).for_each(|column| shares[root[column]] += overlap[(mode, column)].powi(2));
        let found = shares
            .iter()
            .position(|share| *share >= SAME_SHAPE * square)?;
        left[found] = left[found].checked_sub(1)?;
        roots.push(found);
    }
    Some(roots)
}

/// The matrix of orthonormal rows nearest to one whose rows nearly are so, `(A A^T)^(-1/2) A`; a
/// rotation for a square one.
///
/// # Reference
/// Higham (1986), Computing the polar decomposition, SIAM Journal on Scientific and Statistical
/// Computing 7, 1160.
fn nearest_rotation(a: &RealMatrix) -> Result<RealMatrix, TheoryError> {
    let m = a.nrows();
    if m == 1 && a.ncols() == 1 {
        return Ok(real_matrix(1, 1, |_, _| a[(0, 0)].signum()));
    }
    let gram = a * a.transpose();
    let symmetric = real_matrix(m, m, |i, k| 0.5 * (gram[(i, k)] + gram[(k, i)]));
    let gram_eigen = symmetric_eigen(&symmetric)?;
    let scaled = real_matrix(m, m, |i, k| {
        gram_eigen.vectors[(i, k)] / gram_eigen.values[k].sqrt()
    });
    Ok(scaled * (gram_eigen.vectors.transpose() * a))
}
