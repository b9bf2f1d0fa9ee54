//! A store keeps finished slices, finds them in a resumed run, and merges the parts of a batch.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::scene::Observer;
use crate::study::Meter;

use super::BreakdownError;
use super::plan::{Plan, STABILITY};
use super::slice::{MethodTime, Slice, SliceResult};
use super::stability::{Stability, StabilityPlan};

/// Keeps finished slices by name. The library touches no file: the caller decides where they are
/// saved, and saves a text completely or not at all.
pub trait CellStore {
    /// The text saved under a name, if any.
    ///
    /// # Errors
    /// What went wrong, as a sentence.
    fn load(&self, name: &str) -> Result<Option<String>, String>;

    /// Saves a text under a name, in place of an earlier one.
    ///
    /// # Errors
    /// What went wrong, as a sentence.
    fn save(&self, name: &str, text: &str) -> Result<(), String>;
}

/// Which slices of a study are computed: part `number`, from 1, of `count`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its number, from 1.
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

    /// Whether a slice, numbered from 0, belongs to it.
    pub fn contains(&self, index: usize) -> bool {
        index % self.count == self.number - 1
    }
}

/// A saved result with the hash of its spec.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Saved<T> {
    schema: String,
    spec_sha256: String,
    result: T,
}

/// The schema text of a saved slice; a change of the random draws changes its number.
const SCHEMA: &str = "modalign-breakdown-slice/1";
const TIMES_SCHEMA: &str = "modalign-breakdown-times/1";

/// The results of a breakdown study.
#[derive(Clone, Debug, Default)]
pub struct BreakdownResults {
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

/// Computes the unfinished slices of a part of a study, and saves them.
///
/// # Errors
/// [`BreakdownError`] for a case that cannot be drawn, or of the store.
pub fn compute(
    plan: &Plan,
    part: Part,
    store: &dyn CellStore,
    observer: &dyn Observer,
    meter: &dyn Meter,
) -> Result<BreakdownResults, BreakdownError> {
    let mut finished = BreakdownResults::default();
    for (index, slice) in plan.slices.iter().enumerate() {
        if part.contains(index) {
            finished.compute_slice(slice, store, observer, meter)?;
        }
    }
    if let Some(stability) = plan.stability.filter(|_| part.contains(plan.slices.len())) {
        finished.compute_stability(stability, store, observer)?;
    }
    Ok(finished)
}

/// Copies the slices that the parts of a batch finished into one store.
///
/// # Errors
/// [`BreakdownError::OtherSpec`] for a slice of another spec, [`BreakdownError::Unfinished`] for
/// one that no part has.
pub fn merge(
    plan: &Plan,
    parts: &[&dyn CellStore],
    store: &dyn CellStore,
) -> Result<BreakdownResults, BreakdownError> {
    let mut finished = BreakdownResults::default();
    for slice in &plan.slices {
        let key = SliceKey::new(&slice.name, slice);
        let (result, from) = key.find::<SliceResult>(parts)?;
        key.save(&result, store)?;
        finished.slices.push(result);
        if let Some(times) = key.load_times(from)? {
            key.save_times(times, store)?;
        }
        finished.add_times(&key, store)?;
    }
    if let Some(stability) = plan.stability {
        let key = SliceKey::new(STABILITY, &stability);
        let (result, _) = key.find::<Stability>(parts)?;
        key.save(&result, store)?;
        finished.stability = Some(result);
    }
    Ok(finished)
}

impl BreakdownResults {
    fn compute_slice(
        &mut self,
        slice: &Slice,
        store: &dyn CellStore,
        observer: &dyn Observer,
        meter: &dyn Meter,
    ) -> Result<(), BreakdownError> {
        let key = SliceKey::new(&slice.name, slice);
        let result = match self.find_reusable(&key, store)? {
            Some(result) => result,
            None => {
                let run = slice.run(observer, meter);
                let (result, times) = run.map_err(|source| BreakdownError::Synth {
                    slice: slice.name.clone(),
                    source: Box::new(source),
                })?;
                key.save_times(times, store)?;
                key.save(&result, store)?;
                result
            }
        };
        self.slices.push(result);
        self.add_times(&key, store)
    }

    fn compute_stability(
        &mut self,
        plan: StabilityPlan,
        store: &dyn CellStore,
        observer: &dyn Observer,
    ) -> Result<(), BreakdownError> {
        let key = SliceKey::new(STABILITY, &plan);
        let result = match self.find_reusable(&key, store)? {
            Some(result) => result,
            None => {
                observer.step(STABILITY, 1, 1);
                let result = plan.run();
                key.save(&result, store)?;
                result
            }
        };
        self.stability = Some(result);
        Ok(())
    }

    /// A slice that the store has from this spec; one from another spec is listed as outdated.
    fn find_reusable<T: for<'a> Deserialize<'a>>(
        &mut self,
        key: &SliceKey<'_>,
        store: &dyn CellStore,
    ) -> Result<Option<T>, BreakdownError> {
        let Some(saved) = load::<T>(key.name, store)? else {
            return Ok(None);
        };
        if saved.spec_sha256 == key.spec_sha256 {
            self.reused.push(key.name.to_owned());
            return Ok(Some(saved.result));
        }
        self.outdated.push(key.name.to_owned());
        Ok(None)
    }

    fn add_times(
        &mut self,
        key: &SliceKey<'_>,
        store: &dyn CellStore,
    ) -> Result<(), BreakdownError> {
        let times = key.load_times(store)?;
        self.times
            .extend(times.map(|time| (key.name.to_owned(), time)));
        Ok(())
    }
}

/// Name of a slice and hash of the spec that it is computed from: a saved slice of another spec is
/// outdated.
struct SliceKey<'a> {
    name: &'a str,
    spec_sha256: String,
}

impl<'a> SliceKey<'a> {
    fn new(name: &'a str, spec: &impl Spec) -> Self {
        Self {
            name,
            spec_sha256: hash(spec),
        }
    }

    /// The slice in the first of several stores that has it from this spec, and that store.
    fn find<'b, T: for<'c> Deserialize<'c>>(
        &self,
        parts: &[&'b dyn CellStore],
    ) -> Result<(T, &'b dyn CellStore), BreakdownError> {
        let mut other = None;
        for part in parts {
            match load::<T>(self.name, *part)? {
                Some(saved) if saved.spec_sha256 == self.spec_sha256 => {
                    return Ok((saved.result, *part));
                }
                Some(saved) => other = Some(saved.spec_sha256),
                None => {}
            }
        }
        let slice = self.name.to_owned();
        Err(match other {
            Some(got) => BreakdownError::OtherSpec {
                slice,
                got: got.chars().take(12).collect(),
                expected: self.spec_sha256.chars().take(12).collect(),
            },
            None => BreakdownError::Unfinished { slice },
        })
    }

    fn save<T: Serialize + Clone>(
        &self,
        result: &T,
        store: &dyn CellStore,
    ) -> Result<(), BreakdownError> {
        let saved = Saved {
            schema: SCHEMA.to_owned(),
            spec_sha256: self.spec_sha256.clone(),
            result: result.clone(),
        };
        save(self.name, &saved, store)
    }

    fn save_times(
        &self,
        result: Vec<MethodTime>,
        store: &dyn CellStore,
    ) -> Result<(), BreakdownError> {
        let saved = Saved {
            schema: TIMES_SCHEMA.to_owned(),
            spec_sha256: self.spec_sha256.clone(),
            result,
        };
        save(&self.times_name(), &saved, store)
    }

    /// The measured times of the slice, where the store has them from this spec.
    fn load_times(&self, store: &dyn CellStore) -> Result<Option<Vec<MethodTime>>, BreakdownError> {
        let saved = load::<Vec<MethodTime>>(&self.times_name(), store)?;
        Ok(saved
            .filter(|saved| saved.spec_sha256 == self.spec_sha256)
            .map(|saved| saved.result))
    }

    fn times_name(&self) -> String {
        format!("{}.times", self.name)
    }
}

fn load<T: for<'a> Deserialize<'a>>(
    name: &str,
    store: &dyn CellStore,
) -> Result<Option<Saved<T>>, BreakdownError> {
    let failed = |message: String| BreakdownError::Store {
        slice: name.to_owned(),
        message,
    };
    let Some(text) = store.load(name).map_err(failed)? else {
        return Ok(None);
    };
    let saved = serde_json::from_str(&text);
    let saved = saved.map_err(|error| failed(format!("kept cells cannot be read: {error}")))?;
    Ok(Some(saved))
}

fn save<T: Serialize>(
    name: &str,
    saved: &Saved<T>,
    store: &dyn CellStore,
) -> Result<(), BreakdownError> {
    let text = serde_json::to_string(saved).map_err(|error| error.to_string());
    let result = text.and_then(|text| store.save(name, &(text + "\n")));
    result.map_err(|message| BreakdownError::Store {
        slice: name.to_owned(),
        message,
    })
}

/// Input of the computation of a slice; its hash covers the schema too, which numbers the way that
/// a slice is drawn.
trait Spec: Serialize {}
impl Spec for Slice {}
impl Spec for StabilityPlan {}

fn hash(spec: &impl Spec) -> String {
    let text = serde_json::to_string(spec).unwrap_or_default();
    let digest = Sha256::digest(format!("{SCHEMA}\n{text}").as_bytes());
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}
