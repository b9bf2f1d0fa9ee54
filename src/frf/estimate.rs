//! An FRF set is estimated from hits: each (response, excitation point) pair is averaged over its
//! hits.
//!
//! Roving hammer and roving accelerometer are the same thing here. Degrees of freedom keep the
//! signs of their sensors and the samples are taken as they are. It does not choose hits: what
//! comes in is averaged.
//!
//! Point after point the forces are transformed and kept; then response after response its records
//! are read from all hits, one at a time, transformed and summed, so that nothing larger than the
//! forces of one point, a record of each thread and the finished functions is held.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use crate::axis::{Band, TimeAxis};
use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::fourier::ForwardPlan;
use crate::record::{Hit, HitInfo, InMemory, Recording, Samples};

use crate::signal::lane_count;

use super::force::{ForceHit, TransformRange, read_force};
use super::frf_estimation::{
    EstimatedFrf, Estimation, PointHits, RecordIndex, ResponseRecords, SharedRecording, Workspace,
    force_power,
};
use super::preconditions::check;
use super::selection::Selection;
use super::truncation::{QuarterEnergies, truncation_finding};
use super::usable_band::ForcePower;
use super::variance::independent_lines;
use super::{EstimateOptions, FrfError, FrfSet, Truncation};

/// FRFs with what the records say of them.
#[derive(Clone, Debug)]
pub struct Estimated {
    /// The functions.
    pub set: FrfSet,
    /// How wrong each is because its records end: see [`Truncation`].
    pub truncation: BTreeMap<(Dof, Dof), Truncation>,
}

/// Estimates the FRF of every (response, excitation point) pair of hits in memory:
/// [`estimate_recording`] of all of them.
///
/// # Errors
/// As [`estimate_recording`].
pub fn estimate(hits: &[Hit], options: &EstimateOptions) -> Result<FrfSet, FrfError> {
    let all = Selection::all(hits.len());
    Ok(estimate_recording(&mut InMemory::new(hits), &all, options)?.set)
}

/// The valid band of hits in memory, see [`super::FrfSet::valid_band`].
///
/// # Errors
/// As [`super::estimate()`]; [`FrfError::BandEmpty`] when less than two lines are left.
pub fn usable_band(hits: &[Hit], options: &EstimateOptions) -> Result<Band, FrfError> {
    let set = estimate(hits, options)?;
    set.valid_band.ok_or(FrfError::BandEmpty {
        lo_hz: set.axis().hz(1),
        hi_hz: 0.0,
    })
}

/// The limit of the truncation error of each function, from its record: see [`Truncation`].
///
/// # Errors
/// As [`estimate_recording`].
pub fn truncation_bounds(
    hits: &[Hit],
    options: &EstimateOptions,
) -> Result<BTreeMap<(Dof, Dof), Truncation>, FrfError> {
    let all = Selection::all(hits.len());
    Ok(estimate_recording(&mut InMemory::new(hits), &all, options)?.truncation)
}

/// Estimates the FRF of every (response, excitation point) pair of the selected hits, ordered by
/// response and reference.
///
/// Over the hits of a pair, with unscaled one-sided spectra F and X: `Gff = Σ|F|²`, `Gxx = Σ|X|²`,
/// `Gfx = ΣF* X`;
///
/// - `H1 = Gfx / Gff`, unbiased for noise on the response;
/// - `H2 = Gxx / Gfx*`, unbiased for noise on the force;
/// - `Hv = [b + sqrt(b² + 4κ|Gfx|²)] / (2 Gfx*)`, `b = Gxx - κ Gff`, total least squares for noise
///   on both with the power ratio κ = response / force; κ → ∞ is H1, κ → 0 is H2. Without a stated
///   ratio κ comes from the variances before the hits, each times the energy of its window and
///   averaged over the hits; it carries the units of both channels, so that Hv does not depend on
///   them.
///
/// Coherence is there from two hits on; the variance says how many degrees of freedom it has
/// ([`super::Function::variance_dof`]). A response that is exactly 0 in every hit at a line gives 0
/// there; a line that no hit excites is an error. Findings: [`Code::CoherenceAbsent`] (its value is
/// the number of functions with one hit), [`Code::NoiseRatioFromRecord`] of each function, and
/// [`Code::Truncated`] or [`Code::TruncationNotDecidable`]. The result does not depend on the
/// number of threads.
///
/// # Errors
/// [`FrfError`] for options out of range, no hits, hits of different axes, channels of a wrong
/// quantity, a response that is twice in a hit, samples that cannot be read or used, an unknown
/// noise ratio of Hv, and a line without value.
///
/// # Reference
/// Bendat and Piersol (2010), Random Data, 4th ed., chapter 6; Rocklin, Crowley and Vold (1985), A
/// comparison of H1, H2 and Hv frequency response functions, IMAC 3.
pub fn estimate_recording(
    recording: &mut dyn Recording,
    selection: &Selection,
    options: &EstimateOptions,
) -> Result<Estimated, FrfError> {
    let chosen = selection.hits.as_slice();
    let infos: Vec<HitInfo> = recording.hits().to_vec();
    let hits: Vec<&HitInfo> = chosen.iter().map(|hit| &infos[*hit]).collect();
    check(&hits, options)?;
    let extent = TransformRange::new(recording, chosen, options)?;
    let plan = ForwardPlan::new(extent.len);
    let axis = TimeAxis {
        len: extent.len,
        ..hits[0].axis
    };
    let mut power = ForcePower::new(axis);
    let mut cuts: Vec<(usize, f64)> = Vec::new();
    let mut finished = Vec::new();
    let groups = hits_by_reference(&infos, chosen);
    let mut explained = (groups.len() > 1).then(ExplainedPower::default);
    for (reference, members) in groups {
        let forces = read_forces(recording, &infos, &members, &extent, &plan, options)?;
        for (force, hit) in forces.iter().zip(&members) {
            power.add(&force.spectrum, force.noise);
            cuts.extend(force.cut.map(|cut| (*hit, cut)));
        }
        let weights = forces[0].frame.response_weights.clone();
        let estimation = Estimation {
            group: PointHits {
                reference,
                numbers: &members,
                hits: members.iter().map(|hit| &infos[*hit]).collect(),
                power: force_power(
                    forces.iter().map(|force| force.spectrum.as_slice()),
                    plan.lines(),
                ),
                forces,
            },
            plan: &plan,
            pooled_lines: independent_lines(weights.as_deref()),
            selection,
            several_references: explained.is_some(),
            options,
        };
        let group_frfs = estimate_functions(recording, &estimation, &mut explained)?;
        finished.extend(group_frfs);
    }
    let mut estimated = collect_set(finished, &power, &cuts, options)?;
    estimated.set.multiple_coherence = explained.map(ExplainedPower::coherence).unwrap_or_default();
    Ok(estimated)
}

/// Power of each response over all references, and the part of it that they explain.
#[derive(Default)]
struct ExplainedPower {
    responses: BTreeMap<Dof, ResponsePowers>,
}

#[derive(Default)]
struct ResponsePowers {
    all: Vec<f64>,
    explained: Vec<f64>,
    references: usize,
}

impl ExplainedPower {
    /// Adds a function; one without coherence explains all of itself and says nothing, so it is
    /// left out.
    fn add(&mut self, frf: &EstimatedFrf) {
        let Some(coherence) = &frf.data.coherence else {
            return;
        };
        let powers = self.responses.entry(frf.function.response.clone());
        let powers = powers.or_default();
        powers.all.resize(coherence.len(), 0.0);
        powers.explained.resize(coherence.len(), 0.0);
        powers.references += 1;
        let lines = coherence.iter().zip(&frf.response_power);
        let sums = powers.all.iter_mut().zip(&mut powers.explained);
        for ((all, explained), (coherence, power)) in sums.zip(lines) {
            *all += power;
            *explained += coherence * power;
        }
    }

    /// Of the responses with several references.
    fn coherence(self) -> BTreeMap<Dof, Vec<f64>> {
        let several = self.responses.into_iter();
        let several = several.filter(|(_, powers)| powers.references > 1);
        let of = |powers: ResponsePowers| {
            let lines = powers.explained.iter().zip(&powers.all);
            lines
                .map(|(explained, all)| if *all > 0.0 { explained / all } else { 0.0 })
                .collect()
        };
        several.map(|(dof, powers)| (dof, of(powers))).collect()
    }
}

/// The chosen hits of each excitation point, in order.
fn hits_by_reference<'a>(infos: &'a [HitInfo], chosen: &[usize]) -> BTreeMap<&'a Dof, Vec<usize>> {
    let mut groups: BTreeMap<&Dof, Vec<usize>> = BTreeMap::new();
    for hit in chosen {
        groups.entry(&infos[*hit].force.dof).or_default().push(*hit);
    }
    groups
}

/// The forces of these hits; the first bad hit in order is the error.
fn read_forces(
    recording: &mut dyn Recording,
    infos: &[HitInfo],
    hits: &[usize],
    extent: &TransformRange,
    plan: &ForwardPlan,
    options: &EstimateOptions,
) -> Result<Vec<ForceHit>, FrfError> {
    let mut scratch = plan.scratch();
    let mut samples = Samples::F64(Vec::new());
    let conditioning = options.conditioning();
    let force = |hit: &usize| {
        read_force(recording, *hit, &mut samples)?;
        let range = extent.range(*hit);
        ForceHit::new(
            &infos[*hit],
            &samples,
            range,
            &conditioning,
            plan,
            &mut scratch,
        )
    };
    hits.iter().map(force).collect()
}

/// Functions that are finished before what their references explain is added up.
const FRFS_PER_BLOCK: usize = 64;

/// Every function of an excitation point.
fn estimate_functions(
    recording: &mut dyn Recording,
    estimation: &Estimation,
    explained: &mut Option<ExplainedPower>,
) -> Result<Vec<EstimatedFrf>, FrfError> {
    let by_response = records_by_response(&estimation.group);
    let recording = SharedRecording::new(recording);
    let spare: Mutex<Vec<Workspace>> = Mutex::default();
    let spare = || spare.lock().unwrap_or_else(PoisonError::into_inner);
    let estimate = |records: &ResponseRecords| {
        let used_work = spare().pop();
        let mut work = used_work.unwrap_or_else(|| Workspace::new(estimation.plan));
        let done = estimation.estimate_from_records(records, &recording, &mut work);
        spare().push(work);
        done
    };
    let mut finished = Vec::with_capacity(by_response.len());
    for block in by_response.chunks(FRFS_PER_BLOCK) {
        // Each takes long: no thread takes several at once.
        let done: Vec<_> = block.par_iter().with_max_len(1).map(estimate).collect();
        for frf in done {
            let mut frf = frf?;
            if let Some(explained) = explained {
                explained.add(&frf);
            }
            frf.response_power = Vec::new();
            finished.push(frf);
        }
    }
    Ok(finished)
}

/// The records of each response at one excitation point, in order of the responses.
fn records_by_response(group: &PointHits) -> Vec<ResponseRecords> {
    let mut by_response: Vec<ResponseRecords> = Vec::new();
    let mut numbers: HashMap<&Dof, usize> = HashMap::new();
    for (hit_number, hit) in group.hits.iter().enumerate() {
        for (response_number, response) in hit.responses.iter().enumerate() {
            let number = *numbers.entry(&response.dof).or_insert_with(|| {
                by_response.push(ResponseRecords {
                    response: response.dof.clone(),
                    indices: Vec::new(),
                });
                by_response.len() - 1
            });
            by_response[number].indices.push(RecordIndex {
                hit: hit_number,
                response: response_number,
            });
        }
    }
    by_response.sort_unstable_by(|a, b| a.response.cmp(&b.response));
    by_response
}

/// The set of all functions with its findings.
fn collect_set(
    mut finished: Vec<EstimatedFrf>,
    power: &ForcePower,
    cuts: &[(usize, f64)],
    options: &EstimateOptions,
) -> Result<Estimated, FrfError> {
    let key = |frf: &EstimatedFrf| {
        (
            frf.function.response.clone(),
            frf.function.reference.clone(),
        )
    };
    finished.sort_by_cached_key(key);
    let mut set = FrfSet::new(power.axis().spectrum_axis());
    set.added_damping_rad_s = options.exponential.map_or(0.0, |w| w.decay_rad_s);
    set.record_duration_s = Some(power.axis().duration_s());
    set.valid_band = power.valid_band().ok();
    set.excited_band = power.excited_band().ok();
    let mut truncation = BTreeMap::new();
    let mut single = 0;
    for frf in finished {
        let bound = frf
            .energies
            .map_or(Truncation::NOT_DECIDABLE, |e: QuarterEnergies| {
                e.truncation()
            });
        truncation.insert(key(&frf), bound);
        single += usize::from(frf.function.averages == Some(1));
        set.findings.extend(frf.findings);
        set.push(frf.function, frf.data)?;
    }
    set.findings.extend(coherence_absent_finding(single));
    set.findings.extend(force_window_finding(cuts));
    let low = low_coherence_finding(&set);
    set.findings.extend(low);
    set.findings.push(truncation_finding(&truncation));
    Ok(Estimated { set, truncation })
}

/// Median coherence over the valid band below which a set says so.
const MIN_MEDIAN_COHERENCE: f64 = 0.9;

/// One finding for the function of lowest median coherence over the valid band.
pub(super) fn low_coherence_finding(set: &FrfSet) -> Option<Finding> {
    let lines = set.axis().lines(&set.valid_band?);
    let median = |index: usize| {
        let values = &set.coherence(index)?[lines.clone()];
        let middle = values.len() / 2;
        // Only what is too low is sought out.
        let low = lane_count(values, |coherence| coherence < MIN_MEDIAN_COHERENCE);
        (middle < low).then(|| {
            let mut values = values.to_vec();
            *values.select_nth_unstable_by(middle, f64::total_cmp).1
        })
    };
    let medians = (0..set.len()).filter_map(|index| Some((index, median(index)?)));
    let (index, worst) = medians.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let function = &set.functions()[index];
    let location = Location::Function {
        response: Some(function.response.clone()),
        reference: Some(function.reference.clone()),
    };
    let finding = Finding::new(Severity::Warning, Code::LowCoherence, location);
    Some(finding.value(worst, "").limit(MIN_MEDIAN_COHERENCE))
}

/// Largest part of the force that its window may cut off.
const MAX_CUT_FORCE_FRACTION: f64 = 0.01;

/// One finding for the hit of which the force window cuts off most.
fn force_window_finding(cuts: &[(usize, f64)]) -> Option<Finding> {
    let (index, cut) = cuts.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let finding = Finding::new(
        Severity::Warning,
        Code::ForceWindowCuts,
        Location::Hit(index + 1),
    );
    (*cut > MAX_CUT_FORCE_FRACTION).then(|| finding.value(*cut, "").limit(MAX_CUT_FORCE_FRACTION))
}

fn coherence_absent_finding(functions: usize) -> Option<Finding> {
    (functions > 0).then(|| {
        Finding::new(Severity::Warning, Code::CoherenceAbsent, Location::Whole)
            .value(functions as f64, "functions")
    })
}
