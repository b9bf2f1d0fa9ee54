//! A store keeps finished slices, finds them in a resumed run, and merges the parts of a batch.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::scene::Observer;
use crate::study::Meter;

use super::BreakdownError;
use super::plan::{Plan, STABILITY};
use super::slice::{MethodTime, Slice, SliceResult};
use super::stability::{Stability, StabilityPlan};

/// Keeps finished slices by name. The library touches no file: the caller decides where to keep
/// them, and keeps a text completely or not at all.
pub trait CellStore {
    /// The text kept under a name, if any.
    ///
    /// # Errors
    /// What went wrong, as a sentence.
    fn load(&self, name: &str) -> Result<Option<String>, String>;

    /// Keeps a text under a name, in place of an earlier one.
    ///
    /// # Errors
    /// What went wrong, as a sentence.
    fn keep(&self, name: &str, text: &str) -> Result<(), String>;
}

/// Which slices of a study are computed: part `number`, from 1, of `count`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// From 1.
    pub number: usize,
    /// Parts in all.
    pub count: usize,
}

impl Part {
    /// The whole study.
    pub const WHOLE: Self = Self {
        number: 1,
        count: 1,
    };

    /// Whether a slice, from 0, belongs to it.
    pub fn holds(&self, index: usize) -> bool {
        index % self.count == self.number - 1
    }
}

/// A kept result with the hash of its spec.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Kept<T> {
    schema: String,
    spec_sha256: String,
    result: T,
}

/// The schema text of a kept slice; a change of the random draws changes its number.
const SCHEMA: &str = "modalign-breakdown-slice/1";
const TIMES_SCHEMA: &str = "modalign-breakdown-times/1";

/// The results of a study.
#[derive(Clone, Debug, Default)]
pub struct Finished {
    /// Slices in the order of the plan.
    pub slices: Vec<SliceResult>,
    /// Numerical stability, where it was requested.
    pub stability: Option<Stability>,
    /// Time of each slice that was measured, by name.
    pub times: Vec<(String, Vec<MethodTime>)>,
    /// Slices that were found finished.
    pub reused: Vec<String>,
    /// Slices of another spec that were computed again.
    pub outdated: Vec<String>,
}

/// Computes the unfinished slices of a part of a study, and keeps them.
///
/// # Errors
/// [`BreakdownError`] for a case that cannot be drawn, or of the store.
pub fn compute(
    plan: &Plan,
    part: Part,
    store: &dyn CellStore,
    (observer, meter): (&dyn Observer, &dyn Meter),
) -> Result<Finished, BreakdownError> {
    let mut finished = Finished::default();
    for (index, slice) in plan.slices.iter().enumerate() {
        if part.holds(index) {
            finished.compute_slice(slice, store, (observer, meter))?;
        }
    }
    if let Some(stability) = plan.stability.filter(|_| part.holds(plan.slices.len())) {
        finished.compute_stability(stability, store, observer)?;
    }
    Ok(finished)
}

/// Puts the slices that the parts of a batch finished into one store.
///
/// # Errors
/// [`BreakdownError::OtherSpec`] for a slice of another spec, [`BreakdownError::Unfinished`] for
/// one that no part has.
pub fn merge(
    plan: &Plan,
    parts: &[&dyn CellStore],
    store: &dyn CellStore,
) -> Result<Finished, BreakdownError> {
    let mut finished = Finished::default();
    for slice in &plan.slices {
        let of_spec = (slice.name.as_str(), &*hash(slice));
        let (result, from) = found::<SliceResult>(of_spec, parts)?;
        keep(of_spec, &result, store)?;
        finished.slices.push(result);
        if let Some(times) = times_of(of_spec, from)? {
            keep_times(of_spec, times, store)?;
        }
        finished.add_times(of_spec, store)?;
    }
    if let Some(stability) = plan.stability {
        let of_spec = (STABILITY, &*hash(&stability));
        let (result, _) = found::<Stability>(of_spec, parts)?;
        keep(of_spec, &result, store)?;
        finished.stability = Some(result);
    }
    Ok(finished)
}

impl Finished {
    fn compute_slice(
        &mut self,
        slice: &Slice,
        store: &dyn CellStore,
        (observer, meter): (&dyn Observer, &dyn Meter),
    ) -> Result<(), BreakdownError> {
        let of_spec = (slice.name.as_str(), &*hash(slice));
        let result = match self.find_reusable(of_spec, store)? {
            Some(result) => result,
            None => {
                let run = slice.run(observer, meter);
                let (result, times) = run.map_err(|source| BreakdownError::Synth {
                    slice: slice.name.clone(),
                    source: Box::new(source),
                })?;
                keep_times(of_spec, times, store)?;
                keep(of_spec, &result, store)?;
                result
            }
        };
        self.slices.push(result);
        self.add_times(of_spec, store)
    }

    fn compute_stability(
        &mut self,
        plan: StabilityPlan,
        store: &dyn CellStore,
        observer: &dyn Observer,
    ) -> Result<(), BreakdownError> {
        let of_spec = (STABILITY, &*hash(&plan));
        let result = match self.find_reusable(of_spec, store)? {
            Some(result) => result,
            None => {
                observer.step(STABILITY, 1, 1);
                let result = plan.run();
                keep(of_spec, &result, store)?;
                result
            }
        };
        self.stability = Some(result);
        Ok(())
    }

    /// A slice that the store has from this spec; one from another is noted.
    fn find_reusable<T: for<'a> Deserialize<'a>>(
        &mut self,
        (name, spec): (&str, &str),
        store: &dyn CellStore,
    ) -> Result<Option<T>, BreakdownError> {
        let Some(kept) = loaded::<T>(name, store)? else {
            return Ok(None);
        };
        if kept.spec_sha256 == spec {
            self.reused.push(name.to_owned());
            return Ok(Some(kept.result));
        }
        self.outdated.push(name.to_owned());
        Ok(None)
    }

    fn add_times(
        &mut self,
        of_spec: (&str, &str),
        store: &dyn CellStore,
    ) -> Result<(), BreakdownError> {
        let times = times_of(of_spec, store)?;
        self.times
            .extend(times.map(|time| (of_spec.0.to_owned(), time)));
        Ok(())
    }
}

/// A slice of this spec in one of several stores, and where.
fn found<'a, T: for<'b> Deserialize<'b>>(
    (name, spec): (&str, &str),
    parts: &[&'a dyn CellStore],
) -> Result<(T, &'a dyn CellStore), BreakdownError> {
    let mut other = None;
    for part in parts {
        match loaded::<T>(name, *part)? {
            Some(kept) if kept.spec_sha256 == spec => return Ok((kept.result, *part)),
            Some(kept) => other = Some(kept.spec_sha256),
            None => {}
        }
    }
    let slice = name.to_owned();
    Err(match other {
        Some(got) => BreakdownError::OtherSpec {
            slice,
            got: got.chars().take(12).collect(),
            expected: spec.chars().take(12).collect(),
        },
        None => BreakdownError::Unfinished { slice },
    })
}

fn loaded<T: for<'a> Deserialize<'a>>(
    name: &str,
    store: &dyn CellStore,
) -> Result<Option<Kept<T>>, BreakdownError> {
    let failed = |message: String| BreakdownError::Store {
        slice: name.to_owned(),
        message,
    };
    let Some(text) = store.load(name).map_err(failed)? else {
        return Ok(None);
    };
    let kept = serde_json::from_str(&text);
    let kept = kept.map_err(|error| failed(format!("kept cells cannot be read: {error}")))?;
    Ok(Some(kept))
}

fn keep<T: Serialize + Clone>(
    (name, spec): (&str, &str),
    result: &T,
    store: &dyn CellStore,
) -> Result<(), BreakdownError> {
    let kept = Kept {
        schema: SCHEMA.to_owned(),
        spec_sha256: spec.to_owned(),
        result: result.clone(),
    };
    put(name, &kept, store)
}

fn put<T: Serialize>(
    name: &str,
    kept: &Kept<T>,
    store: &dyn CellStore,
) -> Result<(), BreakdownError> {
    let text = serde_json::to_string(kept).map_err(|error| error.to_string());
    let kept = text.and_then(|text| store.keep(name, &(text + "\n")));
    kept.map_err(|message| BreakdownError::Store {
        slice: name.to_owned(),
        message,
    })
}

fn times_name(name: &str) -> String {
    format!("{name}.times")
}

fn keep_times(
    (name, spec): (&str, &str),
    result: Vec<MethodTime>,
    store: &dyn CellStore,
) -> Result<(), BreakdownError> {
    let kept = Kept {
        schema: TIMES_SCHEMA.to_owned(),
        spec_sha256: spec.to_owned(),
        result,
    };
    put(&times_name(name), &kept, store)
}

/// The measured times of a slice, where they are known and of this spec.
fn times_of(
    (name, spec): (&str, &str),
    store: &dyn CellStore,
) -> Result<Option<Vec<MethodTime>>, BreakdownError> {
    let kept = loaded::<Vec<MethodTime>>(&times_name(name), store)?;
    Ok(kept
        .filter(|kept| kept.spec_sha256 == spec)
        .map(|kept| kept.result))
}

/// What a slice is computed from, and the way it is drawn.
trait Spec: Serialize {}
impl Spec for Slice {}
impl Spec for StabilityPlan {}

fn hash(spec: &impl Spec) -> String {
    let text = serde_json::to_string(spec).unwrap_or_default();
    let digest = Sha256::digest(format!("{SCHEMA}\n{text}").as_bytes());
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}
