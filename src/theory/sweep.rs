//! Natural frequencies of a model over one of its parameters: modes are tracked by shape, and
//! crossings and veerings of their loci are located.
//!
//! Values are added between the requested ones where the shapes need them (`sweep_track`); where
//! two loci meet or come nearest is then found between the samples (`sweep_events`).
//!
//! # Reference
//! Perkins and Mote (1986), Comments on curve veering in eigenvalue problems, Journal of Sound and
//! Vibration 106, 451; du Bois, Adhikari and Lieven (2011), On the quantification of eigenvalue
//! curve veering: a veering index, Journal of Applied Mechanics 78, 041007.

use std::f64::consts::TAU;

use crate::axis::Band;

use super::parameter::{check_values, index_of};
use super::sparse::DEFAULT_MODES;
use super::sweep_events::{LocusEvent, events};
use super::sweep_track::{ModeTrack, ModeTracker, Sample};
use super::{
    ModeOptions, ModelRoot, ParameterSpec, TheoreticalModel, TheoryError, model_roots, modes,
};

/// Maximum number of values of a sweep: more than a figure has dots.
const MAX_SWEEP_VALUES: usize = 10_000;
/// From this ratio of its ends a range is divided into equal ratios.
const GEOMETRIC_FROM: f64 = 10.0;

/// Values of a parameter in a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepRange {
    /// The first value.
    pub lower: f64,
    /// The last value.
    pub upper: f64,
    /// Number of values, ends included; at least 2.
    pub count: usize,
}

impl SweepRange {
    /// Whether the values stand in equal ratios: from a range of a factor of 10 above 0 on.
    pub fn is_geometric(&self) -> bool {
        self.lower > 0.0 && self.upper >= GEOMETRIC_FROM * self.lower
    }

    /// The values, ascending: in equal ratios where the range is wide, else in equal steps.
    pub fn values(&self) -> Vec<f64> {
        let last = self.count - 1;
        let inner = |i: usize| {
            let part = i as f64 / last as f64;
            if self.is_geometric() {
                self.lower * (self.upper / self.lower).powf(part)
            } else {
                self.lower + part * (self.upper - self.lower)
            }
        };
        let value = |i| match i {
            0 => self.lower,
            _ if i == last => self.upper,
            _ => inner(i),
        };
        (0..self.count).map(value).collect()
    }

    /// The values of a number of parts: whole numbers in equal steps, however wide the range.
    fn whole_values(&self, parameter: &str) -> Result<Vec<f64>, TheoryError> {
        let step = (self.upper - self.lower) / (self.count - 1) as f64;
        if self.lower.fract() == 0.0 && step.fract() == 0.0 {
            let value = |i: usize| self.lower + i as f64 * step;
            return Ok((0..self.count).map(value).collect());
        }
        Err(TheoryError::SweepNotWhole {
            parameter: parameter.to_owned(),
            lower: self.lower,
            upper: self.upper,
            count: self.count,
        })
    }

    fn check(&self, parameter: &str) -> Result<(), TheoryError> {
        let ascending = self.lower.is_finite() && self.upper.is_finite() && self.lower < self.upper;
        if ascending && (2..=MAX_SWEEP_VALUES).contains(&self.count) {
            return Ok(());
        }
        Err(TheoryError::SweepRange {
            parameter: parameter.to_owned(),
            lower: self.lower,
            upper: self.upper,
            count: self.count,
            most: MAX_SWEEP_VALUES,
        })
    }
}

/// A root through a sweep, with all modes that share it.
#[derive(Clone, Debug, PartialEq)]
pub struct Locus {
    /// Number of modes that share it at each value: the same number at all, where they are tracked
    /// by their shapes.
    pub multiplicity: Vec<usize>,
    /// Angular frequency at each value, rad/s; `None` where the model has fewer roots, over a
    /// number of parts alone.
    pub omega_rad_s: Vec<Option<f64>>,
    /// Class of the motion at the first value, in the words of the model.
    pub class: Option<String>,
}

/// A model swept over one parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// The parameter.
    pub parameter: ParameterSpec,
    /// Its values.
    pub values: Vec<f64>,
    /// The loci, in the order of their frequencies at the first value.
    pub loci: Vec<Locus>,
    /// Crossings and veerings in the order of their places.
    pub events: Vec<LocusEvent>,
    /// Eigenproblems solved.
    pub solved: usize,
    /// Whether the loci are tracked by their shapes. Not over a number of parts, by which the
    /// coordinates change: there a locus is the root of one number, counted from the lowest, and no
    /// event is reported.
    pub followed: bool,
}

/// Sweeps a parameter of a model, by its name, over a range, the other parameters at `values`.
///
/// Modes at neighbouring values belong together by their shapes: the share of one in the other,
/// weighted by the mass, must be 0.9 at least, or values between are taken. Modes of one root are
/// followed as a subspace. Loci that change their order are held to cross only once the shapes next
/// to the meeting point say so; roots nearer than a millionth of their frequency count as one
/// there, so that a veering narrower than this is called a crossing. Over a number of parts
/// ([`ParameterSpec::whole`]) the roots are numbered instead.
///
/// All modes are followed; of a model that is solved sparse as many as it takes for those up to the
/// end of the band, or for the lowest thirty without a band, to be among them at every value. Such
/// modes as come from above make it more.
///
/// # Errors
/// [`TheoryError::UnknownParameter`]; [`TheoryError::SweepRange`]; [`TheoryError::SweepNotWhole`];
/// [`TheoryError::NotFollowed`] where shapes do not go over
/// into each other however near the values; those of the model.
pub fn sweep(
    model: &dyn TheoreticalModel,
    values: &[f64],
    parameter: &str,
    range: SweepRange,
    band: Option<Band>,
) -> Result<Sweep, TheoryError> {
    let specs = model.parameters();
    check_values(model.name(), specs, values)?;
    let j = index_of("sweep", specs, parameter)?;
    let parameter = &specs[j];
    range.check(&parameter.name)?;
    for end in [range.lower, range.upper] {
        let mut values = values.to_vec();
        values[j] = end;
        check_values(model.name(), specs, &values)?;
    }
    if parameter.whole {
        return numbered(model, values, j, range.whole_values(&parameter.name)?);
    }
    let grid = range.values();
    let lowest = band.and_then(|band| Band::new(0.0, band.hi_hz).ok());
    let tracker = ModeTracker::new(model, values, j, lowest);
    let track = track_lowest_modes(&tracker, &grid, lowest)?;
    let families = track.families();
    Ok(Sweep {
        events: events(&tracker, &track, &families)?,
        loci: loci(model, &track, &families, &grid),
        parameter: parameter.clone(),
        values: grid,
        solved: tracker.solved(),
        followed: true,
    })
}

/// The modes that lie in the band at the first value, or the lowest, with so many above them that
/// none comes in unseen.
fn track_lowest_modes(
    tracker: &ModeTracker<'_>,
    grid: &[f64],
    lowest: Option<Band>,
) -> Result<ModeTrack, TheoryError> {
    let unseen = |sample: &Sample| {
        let stranger = sample.strangers_rad_s.first();
        stranger.is_some_and(|&omega| match lowest {
            Some(band) => band.contains(omega / TAU),
            None => sample.omega_rad_s.iter().filter(|w| **w <= omega).count() < DEFAULT_MODES,
        })
    };
    let mut options = ModeOptions {
        band: lowest,
        ..ModeOptions::default()
    };
    loop {
        let track = tracker.track(grid, &options)?;
        if !track.samples.iter().any(unseen) {
            return Ok(track);
        }
        let count = track.samples[0].omega_rad_s.len();
        options = ModeOptions {
            count: Some(count + count / 2 + 1),
            ..ModeOptions::default()
        };
    }
}

/// The distinct roots at each value of a number of parts, by their number.
fn numbered(
    model: &dyn TheoreticalModel,
    values: &[f64],
    j: usize,
    grid: Vec<f64>,
) -> Result<Sweep, TheoryError> {
    let at = |value: &f64| {
        let mut values = values.to_vec();
        values[j] = *value;
        let solved = modes(model, &values, &[], &ModeOptions::default())?;
        Ok(model_roots(model, &solved))
    };
    let roots: Vec<Vec<ModelRoot>> = grid.iter().map(at).collect::<Result<_, TheoryError>>()?;
    let count = roots.iter().map(Vec::len).max().unwrap_or(0);
    let locus = |number: usize| Locus {
        multiplicity: roots
            .iter()
            .map(|roots_at_value| {
                roots_at_value
                    .get(number)
                    .map_or(0, |root| root.modes.len())
            })
            .collect(),
        omega_rad_s: roots
            .iter()
            .map(|roots_at_value| roots_at_value.get(number).map(|root| root.omega_rad_s))
            .collect(),
        class: roots[0].get(number).and_then(|root| root.class.clone()),
    };
    Ok(Sweep {
        parameter: model.parameters()[j].clone(),
        loci: (0..count).map(locus).collect(),
        events: Vec::new(),
        solved: grid.len(),
        values: grid,
        followed: false,
    })
}

fn loci(
    model: &dyn TheoreticalModel,
    track: &ModeTrack,
    families: &[Vec<usize>],
    grid: &[f64],
) -> Vec<Locus> {
    let samples = grid.iter().filter_map(|value| track.at(*value));
    let samples: Vec<_> = samples.collect();
    let locus = |family: &Vec<usize>| Locus {
        multiplicity: vec![family.len(); samples.len()],
        omega_rad_s: samples
            .iter()
            .map(|sample| Some(sample.omega_rad_s[family[0]]))
            .collect(),
        class: model
            .mode_class(
                samples[0].omega_rad_s[family[0]],
                &samples[0].kinetic_shares(family),
            )
            .map(str::to_owned),
    };
    families.iter().map(locus).collect()
}
