//! Mode changes compare the modes of a model with two vectors of parameter values, tracked by their
//! shapes along the straight path between them.
//!
//! The path begins at its middle and leads to both ends, so that a repeated root at one end, or at
//! both, has the shapes into which it splits. A value above 0 at both ends changes in equal ratios.
//! A mode follows its locus through a veering, where its shape changes; the MAC shows it.

use crate::axis::Band;
use crate::geometry::Target;
use crate::linalg::{RealMatrix, real_matrix};

use super::sweep_track::{ModeTrack, ModeTracker, Sample};
use super::system::{System, SystemSlope};
use super::{
    Assumption, ModeOptions, ParameterSpec, SystemDerivative, SystemMatrices, TheoreticalModel,
    TheoryError, TheoryModes, modes,
};

/// Minimum share of a root's shapes in another one that is paired with it where tracking fails.
const MIN_SHARE: f64 = 0.5;
/// Of a sparse model the modes up to this multiple of the end of the band are tracked.
const BEYOND_BAND: f64 = 1.5;

/// The modes of a root at one end of the path.
#[derive(Clone, Debug)]
pub struct RootState {
    /// Number of the root at this end, counted from 0 for the lowest.
    pub root: usize,
    /// Angular frequency, rad/s.
    pub omega_rad_s: f64,
    /// Damping ratio of first order in the damping matrix; `None` without damping.
    pub damping_ratio: Option<f64>,
    /// Shapes of unit modal mass over the coordinates, one column for each mode.
    pub vectors: RealMatrix,
}

/// Modes that share a root at both ends.
#[derive(Clone, Debug)]
pub struct ModeChange {
    /// At the first values; `None` for a mode without a partner there.
    pub before: Option<RootState>,
    /// At the second values; `None` for a mode without a partner there.
    pub after: Option<RootState>,
    /// MAC between both with the first mass matrix as weight, of several modes the mean over them.
    pub mac: Option<f64>,
}

/// The modes of a model with two vectors of values.
#[derive(Clone, Debug)]
pub struct ModeChanges {
    /// The modes in the order of the first frequencies; then those that only the second values
    /// have.
    pub modes: Vec<ModeChange>,
    /// Whether the modes are tracked; otherwise they are paired by the MAC between the ends.
    pub tracked: bool,
}

/// The modes at both values; of a sparse model those in a band, or the lowest.
///
/// # Errors
/// Those of the model.
pub fn mode_changes(
    model: &dyn TheoreticalModel,
    before: &[f64],
    after: &[f64],
    band: Option<Band>,
) -> Result<ModeChanges, TheoryError> {
    let options = options(band);
    let [first, second] = [before, after].map(|values| modes(model, values, &[], &options));
    let ends = [first?, second?];
    let weight = System::of(model, before)?;
    match TrackedModes::new(model, before, after, band) {
        Ok(tracked) => Ok(ModeChanges {
            modes: tracked
                .roots()
                .into_iter()
                .map(|[mut first, mut second]| {
                    first.damping_ratio = damping_of_root(&ends[0], first.root);
                    second.damping_ratio = damping_of_root(&ends[1], second.root);
                    ModeChange {
                        mac: Some(share(&weight, &first.vectors, &second.vectors)),
                        before: Some(first),
                        after: Some(second),
                    }
                })
                .collect(),
            tracked: true,
        }),
        Err(TheoryError::NotFollowed { .. }) => Ok(ModeChanges {
            modes: paired_modes(&weight, &ends),
            tracked: false,
        }),
        Err(error) => Err(error),
    }
}

fn options(band: Option<Band>) -> ModeOptions {
    ModeOptions {
        band: band.and_then(|band| Band::new(0.0, BEYOND_BAND * band.hi_hz).ok()),
        ..ModeOptions::default()
    }
}

/// Derivatives of the angular frequency of each group of modes by parameters, the mean over its
/// modes, rad/s per unit of the parameter: one row for each group.
///
/// # Errors
/// Those of the model's derivative.
pub fn frequency_slopes(
    model: &dyn TheoreticalModel,
    values: &[f64],
    by: &[usize],
    groups: &[&RootState],
) -> Result<Vec<Vec<f64>>, TheoryError> {
    let mut slopes = vec![Vec::with_capacity(by.len()); groups.len()];
    for &j in by {
        let slope = SystemSlope::of(model, values, j)?;
        for (row, group) in slopes.iter_mut().zip(groups) {
            let [mass, stiffness] = slope.products(&group.vectors);
            let lambda = group.omega_rad_s.powi(2);
            let sum: f64 = all_places(&group.vectors)
                .map(|at| group.vectors[at] * (stiffness[at] - lambda * mass[at]))
                .sum();
            let mean = sum / group.vectors.ncols() as f64;
            row.push(match group.omega_rad_s > 0.0 {
                true => 0.5 * mean / group.omega_rad_s,
                false => 0.0,
            });
        }
    }
    Ok(slopes)
}

fn all_places(of: &RealMatrix) -> impl Iterator<Item = (usize, usize)> {
    let (rows, columns) = (of.nrows(), of.ncols());
    (0..columns).flat_map(move |k| (0..rows).map(move |i| (i, k)))
}

/// The modes of a model that are tracked from first values to others; of a sparse model those in a
/// band, or the lowest.
#[derive(Clone, Debug)]
pub struct TrackedModes {
    first_values: Vec<f64>,
    first: Sample,
    values: Vec<f64>,
    sample: Sample,
    band: Option<Band>,
    /// Modes whose crossings are separated from veerings; all without a list.
    watched: Option<Vec<usize>>,
}

impl TrackedModes {
    /// The modes tracked along the straight path.
    ///
    /// # Errors
    /// Those of the model; [`TheoryError::NotFollowed`].
    pub fn new(
        model: &dyn TheoreticalModel,
        before: &[f64],
        after: &[f64],
        band: Option<Band>,
    ) -> Result<Self, TheoryError> {
        let middle = between(before, after, 0.5);
        let to_end = |end: &[f64]| -> Result<Sample, TheoryError> {
            let path = ValuePath::new(model, &middle, end);
            let options = options(band);
            let tracker = ModeTracker::new(&path, &[0.0], 0, options.band);
            Ok(last(tracker.track(&[0.0, 1.0], &options)?))
        };
        Ok(Self {
            first_values: before.to_vec(),
            first: to_end(before)?,
            values: after.to_vec(),
            sample: to_end(after)?,
            band,
            watched: None,
        })
    }

    /// The same modes, tracked on with regard to these roots of the first values alone: others may
    /// change their order in a veering as in a crossing.
    pub fn watching(mut self, roots: &[usize]) -> Self {
        let modes = 0..self.first.root.len();
        let watched = modes.filter(|&mode| roots.contains(&self.first.root[mode]));
        self.watched = Some(watched.collect());
        self
    }

    /// The same modes tracked on to further values; from the first ones again where a root splits.
    ///
    /// # Errors
    /// As [`TrackedModes::new`].
    pub fn track_on(
        &self,
        model: &dyn TheoreticalModel,
        values: &[f64],
    ) -> Result<Self, TheoryError> {
        let path = ValuePath::new(model, &self.values, values);
        let tracker = ModeTracker::new(&path, &[0.0], 0, options(self.band).band);
        let tracker = tracker.watching(self.watched.as_deref());
        let mut from = self.sample.clone();
        from.value = 0.0;
        match tracker.track_from(from, &[0.0, 1.0]) {
            Ok(track) => Ok(Self {
                values: values.to_vec(),
                sample: last(track),
                ..self.clone()
            }),
            Err(TheoryError::NotFollowed { .. }) => {
                Self::new(model, &self.first_values, values, self.band)
            }
            Err(error) => Err(error),
        }
    }

    /// The modes that share their roots at both values, without damping, in the order of the first
    /// frequencies.
    pub fn roots(&self) -> Vec<[RootState; 2]> {
        let (from, to) = (&self.first, &self.sample);
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for mode in 0..from.root.len() {
            let key = |k: usize| (from.root[k], to.root[k]);
            match groups.iter_mut().find(|group| key(group[0]) == key(mode)) {
                Some(group) => group.push(mode),
                None => groups.push(vec![mode]),
            }
        }
        groups.sort_by_key(|group| (from.root[group[0]], to.root[group[0]]));
        let state = |sample: &Sample, group: &[usize]| RootState {
            root: sample.root[group[0]],
            omega_rad_s: sample.omega_rad_s[group[0]],
            damping_ratio: None,
            vectors: real_matrix(sample.vectors.nrows(), group.len(), |i, k| {
                sample.vectors[(i, group[k])]
            }),
        };
        let pair = |group: &Vec<usize>| [state(from, group), state(to, group)];
        groups.iter().map(pair).collect()
    }
}

/// The last sample of a track.
fn last(mut track: ModeTrack) -> Sample {
    track.samples.swap_remove(track.samples.len() - 1)
}

/// Each root after with the root before in which its shapes have the largest share.
fn paired_modes(weight: &System, ends: &[TheoryModes; 2]) -> Vec<ModeChange> {
    let states = |end: &TheoryModes| -> Vec<RootState> {
        let roots = end.model.roots().into_iter().enumerate();
        let state = |(root, group): (usize, Vec<usize>)| RootState {
            root,
            omega_rad_s: end.omega_rad_s[group[0]],
            damping_ratio: damping_of_root(end, root),
            vectors: real_matrix(end.vectors.nrows(), group.len(), |i, k| {
                end.vectors[(i, group[k])]
            }),
        };
        roots.map(state).collect()
    };
    let [first, second] = [states(&ends[0]), states(&ends[1])];
    let mut left: Vec<usize> = first.iter().map(|state| state.vectors.ncols()).collect();
    let mut changes = Vec::new();
    for after in second {
        let shares = first.iter().enumerate();
        let shares = shares.map(|(a, before)| (share(weight, &before.vectors, &after.vectors), a));
        let best = shares.max_by(|p, q| p.0.total_cmp(&q.0));
        let count = after.vectors.ncols();
        let best = best.filter(|(share, a)| *share >= MIN_SHARE && left[*a] >= count);
        if let Some((_, a)) = best {
            left[a] -= count;
        }
        changes.push(ModeChange {
            before: best.map(|(_, a)| first[a].clone()),
            after: Some(after),
            mac: best.map(|(share, _)| share),
        });
    }
    let alone = first.into_iter().zip(&left).filter(|(_, left)| **left > 0);
    changes.extend(alone.map(|(before, _)| ModeChange {
        before: Some(before),
        after: None,
        mac: None,
    }));
    let order = |change: &ModeChange| change.before.as_ref().map_or(usize::MAX, |b| b.root);
    changes.sort_by_key(order);
    changes
}

/// Mean share of the second shapes in the first ones.
fn share(weight: &System, first: &RealMatrix, second: &RealMatrix) -> f64 {
    let square = |x: &RealMatrix| -> Vec<f64> {
        let moved = weight.mass(x);
        let column = |k: usize| (0..x.nrows()).map(|i| x[(i, k)] * moved[(i, k)]).sum();
        (0..x.ncols()).map(column).collect()
    };
    let overlap = first.transpose() * weight.mass(second);
    let (a, b) = (square(first), square(second));
    let parts = all_places(&overlap).map(|at| overlap[at].powi(2) / (a[at.0] * b[at.1]));
    parts.sum::<f64>() / second.ncols() as f64
}

/// Mean damping ratio of the modes of a root.
fn damping_of_root(end: &TheoryModes, root: usize) -> Option<f64> {
    let roots = end.model.roots();
    let group = roots.get(root)?;
    let ratio = |mode: &usize| end.model.modes[*mode].damping_ratio;
    let ratios: Option<Vec<f64>> = group.iter().map(ratio).collect();
    ratios.map(|ratios| ratios.iter().sum::<f64>() / ratios.len() as f64)
}

/// Values at a part of the path.
fn between(from: &[f64], to: &[f64], part: f64) -> Vec<f64> {
    let value = |(&a, &b): (&f64, &f64)| match part {
        0.0 => a,
        1.0 => b,
        _ if a > 0.0 && b > 0.0 => a * (b / a).powf(part),
        _ => a + part * (b - a),
    };
    from.iter().zip(to).map(value).collect()
}

/// A model over the path between two vectors of values: its one parameter is the part of the path.
#[derive(Debug)]
struct ValuePath<'a> {
    model: &'a dyn TheoreticalModel,
    from: &'a [f64],
    to: &'a [f64],
    parameters: [ParameterSpec; 1],
}

impl<'a> ValuePath<'a> {
    fn new(model: &'a dyn TheoreticalModel, from: &'a [f64], to: &'a [f64]) -> Self {
        let part = ParameterSpec::fraction("part of the change");
        Self {
            model,
            from,
            to,
            parameters: [part],
        }
    }

    fn at(&self, values: &[f64]) -> Vec<f64> {
        between(self.from, self.to, values[0])
    }
}

impl TheoreticalModel for ValuePath<'_> {
    fn name(&self) -> &str {
        self.model.name()
    }

    fn parameters(&self) -> &[ParameterSpec] {
        &self.parameters
    }

    fn assemble(&self, values: &[f64]) -> Result<SystemMatrices, TheoryError> {
        self.model.assemble(&self.at(values))
    }

    fn observation_row(&self, values: &[f64], target: &Target) -> Result<Vec<f64>, TheoryError> {
        self.model.observation_row(&self.at(values), target)
    }

    fn derivative(&self, _: &[f64], _: usize) -> Result<SystemDerivative, TheoryError> {
        Err(TheoryError::NoDerivative {
            name: self.parameters[0].name.clone(),
        })
    }

    fn sparse(&self, values: &[f64]) -> Result<Option<super::SparseSystem>, TheoryError> {
        self.model.sparse(&self.at(values))
    }

    fn assumptions(&self) -> Vec<Assumption> {
        self.model.assumptions()
    }
}
