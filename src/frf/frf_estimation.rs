//! One FRF is estimated: the records of a (response, excitation point) pair are transformed and
//! summed over hits.

use std::sync::{Arc, Mutex, PoisonError};

use num_complex::Complex64;

use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::fourier::{ForwardPlan, Scratch};
use crate::record::{ChannelPlace, ChannelSegment, HitInfo, ReadError, Recording, Samples};
use crate::signal::{Extent, overloaded, pretrigger_offset, to_si};

use super::coherence::coherence;
use super::force::ForceHit;
use super::preconditions::kind_of;
use super::selection::Selection;
use super::spectra_sums::{LineError, Sums};
use super::truncation::QuarterEnergies;
use super::variance::{Averaged, NoisePowers, variances};
use super::{EstimateOptions, Estimator, FrfError, Function, FunctionData};

/// The hits at one point, with their forces.
pub(super) struct PointHits<'a> {
    pub reference: &'a Dof,
    /// Their numbers in the recording, from 0.
    pub numbers: &'a [usize],
    pub hits: Vec<&'a HitInfo>,
    pub forces: Vec<ForceHit>,
    /// Power of all its forces.
    pub power: Arc<[f64]>,
}

/// `Σ|F|²` at every line.
pub(super) fn force_power<'a>(
    spectra: impl IntoIterator<Item = &'a [Complex64]>,
    lines: usize,
) -> Arc<[f64]> {
    let mut power = vec![0.0; lines];
    for spectrum in spectra {
        for (sum, f) in power.iter_mut().zip(spectrum) {
            *sum += f.norm_sqr();
        }
    }
    power.into()
}

/// One response and its records in the hits of a group.
pub(super) struct ResponseRecords {
    pub response: Dof,
    pub indices: Vec<RecordIndex>,
}

/// A record of a response.
#[derive(Clone, Copy)]
pub(super) struct RecordIndex {
    /// Number of the hit within its group.
    pub hit: usize,
    /// Number of the response within the hit.
    pub response: usize,
}

/// A recording that several threads read, one after the other.
pub(super) struct SharedRecording<'a>(Mutex<&'a mut dyn Recording>);

impl<'a> SharedRecording<'a> {
    pub fn new(recording: &'a mut dyn Recording) -> Self {
        Self(Mutex::new(recording))
    }

    fn read(&self, segment: &ChannelSegment, samples: &mut Samples) -> Result<(), ReadError> {
        let mut recording = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        recording.read(segment, samples)
    }
}

/// A finished function.
pub(super) struct EstimatedFrf {
    pub function: Function,
    pub data: FunctionData,
    /// Power of the response at each line, summed over its hits, where there are several
    /// references.
    pub response_power: Vec<f64>,
    /// Of all its hits, for the bound on truncation.
    pub energies: Option<QuarterEnergies>,
    pub findings: Vec<Finding>,
}

/// Working memory of one thread.
pub(super) struct Workspace {
    scratch: Scratch,
    samples: Samples,
    record: Vec<f64>,
    spectra: [Vec<Complex64>; SPECTRA_PER_PASS],
    /// Hits, by their numbers within the group, whose spectra are there and not yet summed.
    waiting: Vec<usize>,
    sums: Sums,
}

/// Hits whose spectra are summed in one pass: the sums are read and written once for all of them,
/// while more spectra than that would have left the cache before.
const SPECTRA_PER_PASS: usize = 2;

impl Workspace {
    pub fn new(plan: &ForwardPlan) -> Self {
        Self {
            scratch: plan.scratch(),
            samples: Samples::F32(Vec::new()),
            record: Vec::new(),
            spectra: std::array::from_fn(|_| vec![Complex64::ZERO; plan.lines()]),
            waiting: Vec::new(),
            sums: Sums::default(),
        }
    }

    fn clear(&mut self, lines: usize) {
        self.waiting.clear();
        self.sums.clear(lines);
    }

    /// Sums the spectra that wait.
    fn sum(&mut self, forces: &[ForceHit]) {
        let force = |hit: &usize| forces[*hit].spectrum.as_slice();
        let responses = self.spectra.iter().map(Vec::as_slice);
        let hits: Vec<_> = self.waiting.iter().map(force).zip(responses).collect();
        self.sums.add(&hits);
        self.waiting.clear();
    }
}

/// Properties of a function's records other than their sums.
#[derive(Default)]
struct RecordStatistics {
    /// Numbers of the hits within the group.
    hits: Vec<usize>,
    energies: Vec<Option<QuarterEnergies>>,
    /// Expected energies of the noise under the window, per record.
    response_noise: Vec<f64>,
    force_noise: Vec<f64>,
    pretrigger_samples: usize,
}

impl RecordStatistics {
    fn noise_powers(&self) -> NoisePowers {
        let mean = |values: &[f64]| {
            (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
        };
        NoisePowers {
            response: mean(&self.response_noise),
            force: mean(&self.force_noise),
            samples: self.pretrigger_samples,
        }
    }
}

/// Data common to all functions of a group.
pub(super) struct Estimation<'a> {
    pub group: PointHits<'a>,
    pub plan: &'a ForwardPlan,
    pub selection: &'a Selection,
    /// Whether there are other excitation points.
    pub several_references: bool,
    /// Neighbouring lines that count as one each under the window.
    pub pooled_lines: f64,
    pub options: &'a EstimateOptions,
}

impl Estimation<'_> {
    /// Estimates one FRF: its records are read, transformed and summed in their order. Overloaded
    /// and empty records are left out, unless none would be left.
    pub fn estimate_from_records(
        &self,
        records: &ResponseRecords,
        recording: &SharedRecording,
        work: &mut Workspace,
    ) -> Result<EstimatedFrf, FrfError> {
        let mut totals = RecordStatistics::default();
        let mut findings = Vec::new();
        work.clear(self.plan.lines());
        for index in &records.indices {
            let extent = self.read(*index, recording, work)?;
            match self.rejection(*index, &work.record, &extent) {
                Some(finding) => findings.push(finding),
                None => self.add(*index, work, &mut totals)?,
            }
        }
        if totals.hits.is_empty() {
            findings = vec![self.no_record_passed(records)];
            for index in &records.indices {
                self.read(*index, recording, work)?;
                self.add(*index, work, &mut totals)?;
            }
        }
        let forces = &self.group.forces;
        work.sum(forces);
        if totals.hits.len() == forces.len() {
            work.sums.gff = Arc::clone(&self.group.power);
        } else {
            let used_forces = totals
                .hits
                .iter()
                .map(|hit| forces[*hit].spectrum.as_slice());
            work.sums.gff = force_power(used_forces, self.plan.lines());
        }
        let finished = self.estimate(records, &work.sums, totals)?;
        findings.extend(finished.findings);
        Ok(EstimatedFrf {
            findings,
            ..finished
        })
    }

    /// All records of a function are bad: they are used all the same.
    fn no_record_passed(&self, records: &ResponseRecords) -> Finding {
        let location = Location::Function {
            response: Some(records.response.clone()),
            reference: Some(self.group.reference.clone()),
        };
        let finding = Finding::new(Severity::Warning, Code::NoRecordPassed, location);
        finding.value(records.indices.len() as f64, "hits")
    }

    /// Reads a record in SI units.
    fn read(
        &self,
        index: RecordIndex,
        recording: &SharedRecording,
        work: &mut Workspace,
    ) -> Result<Extent, FrfError> {
        let hit = self.group.hits[index.hit];
        let segment = ChannelSegment {
            hit: self.group.numbers[index.hit],
            channel: ChannelPlace::Response(index.response),
            samples: 0..hit.axis.len,
        };
        recording.read(&segment, &mut work.samples)?;
        let (channel, samples) = (&hit.responses[index.response], &work.samples);
        Ok(to_si(hit, channel, samples, &mut work.record)?)
    }

    /// The finding of a response that is constant or clipped; `extent` is its range of values.
    fn rejection(&self, index: RecordIndex, record: &[f64], extent: &Extent) -> Option<Finding> {
        let number = self.group.numbers[index.hit];
        let limits = self.selection.overloads.as_ref()?;
        if self.selection.accepted.contains(&number) {
            return None;
        }
        let channel = &self.group.hits[index.hit].responses[index.response];
        let location = Location::HitChannel {
            hit: number + 1,
            dof: channel.dof.clone(),
        };
        if extent.range() <= 0.0 {
            return Some(Finding::new(Severity::Warning, Code::DeadChannel, location));
        }
        let check = overloaded(record, extent, channel.full_scale, limits)?;
        let finding = Finding::new(Severity::Warning, Code::Overload, location);
        Some(
            finding
                .value(check.value.unwrap_or_default(), check.unit)
                .limit(check.limit.unwrap_or_default()),
        )
    }

    /// Adds the record of one hit to the sums.
    fn add(
        &self,
        index: RecordIndex,
        work: &mut Workspace,
        totals: &mut RecordStatistics,
    ) -> Result<(), FrfError> {
        let (hit, force) = (self.group.hits[index.hit], &self.group.forces[index.hit]);
        let (channel, frame) = (&hit.responses[index.response], &force.frame);
        let policy = self.options.offset;
        let (pretrigger, offset) =
            pretrigger_offset(hit, channel, &work.record, &frame.pulse, policy)?;
        let weights = frame.response_weights.as_deref();
        frame.apply(&mut work.record, offset, weights);
        let onset = frame.pulse.onset.saturating_sub(frame.range.start);
        let variance = pretrigger.map(|pretrigger| pretrigger.variance);
        let energies = QuarterEnergies::of(&work.record, onset, weights, variance);
        let spectrum = &mut work.spectra[work.waiting.len()];
        let scratch = &mut work.scratch;
        self.plan.run(&mut work.record, spectrum, scratch);
        advance(
            spectrum,
            channel.delay_s / (self.plan.len() as f64 * hit.axis.step_s),
        );
        work.waiting.push(index.hit);
        if work.waiting.len() == SPECTRA_PER_PASS {
            work.sum(&self.group.forces);
        }
        totals.hits.push(index.hit);
        totals.energies.push(energies);
        totals.force_noise.extend(force.noise);
        // Exact zeros before the hit are a gate, not the absence of noise.
        if let Some(pretrigger) = pretrigger.filter(|pretrigger| pretrigger.variance > 0.0) {
            let noise = pretrigger.variance * frame.noise_gain(weights);
            totals.response_noise.push(noise);
            totals.pretrigger_samples += pretrigger.samples;
        }
        Ok(())
    }

    fn estimate(
        &self,
        records: &ResponseRecords,
        sums: &Sums,
        totals: RecordStatistics,
    ) -> Result<EstimatedFrf, FrfError> {
        let estimator = self.options.estimator;
        let powers = &totals.noise_powers();
        let (kappa, finding) = self.noise_ratio(records, powers)?;
        let values = sums.estimates(estimator, kappa);
        let values = values.map_err(|(line, error)| self.line_error(error, records, line))?;
        let n = totals.hits.len();
        let first = records.indices[0];
        let first_hit = self.group.hits[first.hit];
        let coherence = (n > 1).then(|| sums.each(coherence));
        let averaged = Averaged {
            sums,
            values: &values,
            is_h1: estimator == Estimator::H1,
            coherence: coherence.as_deref().unwrap_or_default(),
            averages: n,
        };
        let variances = variances(&averaged, self.pooled_lines, powers);
        let function = Function {
            response: records.response.clone(),
            reference: self.group.reference.clone(),
            kind: kind_of(first_hit, &first_hit.responses[first.response])?,
            averages: u32::try_from(n).ok(),
            estimator: Some(estimator),
            variance_dof: variances
                .as_ref()
                .map(|estimated| estimated.degrees_of_freedom),
        };
        let data = FunctionData {
            coherence,
            variance: variances.map(|estimated| estimated.values),
            values,
        };
        Ok(EstimatedFrf {
            function,
            data,
            response_power: if self.several_references {
                sums.gxx.clone()
            } else {
                Vec::new()
            },
            energies: QuarterEnergies::sum(totals.energies),
            findings: finding.into_iter().collect(),
        })
    }

    /// The ratio of Hv with the finding that says where it came from; 0 and nothing for H1 and H2,
    /// which do not use it.
    fn noise_ratio(
        &self,
        records: &ResponseRecords,
        powers: &NoisePowers,
    ) -> Result<(f64, Option<Finding>), FrfError> {
        match (self.options.estimator, self.options.noise_ratio) {
            (Estimator::H1 | Estimator::H2, _) => return Ok((0.0, None)),
            (Estimator::Hv, Some(stated)) => return Ok((stated, None)),
            (Estimator::Hv, None) => {}
        }
        let (response, reference) = (records.response.clone(), self.group.reference.clone());
        let ratio = powers.response.zip(powers.force).map(|(x, f)| x / f);
        match ratio.filter(|kappa| *kappa > 0.0 && kappa.is_finite()) {
            Some(kappa) => {
                let location = Location::Function {
                    response: Some(response),
                    reference: Some(reference),
                };
                let finding = Finding::new(Severity::Info, Code::NoiseRatioFromRecord, location);
                Ok((kappa, Some(finding.value(kappa, ""))))
            }
            None => Err(FrfError::NoiseUnknown {
                response,
                reference,
                response_noise: powers.response,
                force_noise: powers.force,
            }),
        }
    }

    fn line_error(&self, error: LineError, records: &ResponseRecords, line: usize) -> FrfError {
        let pair = (records.response.clone(), self.group.reference.clone());
        let step_s = self.group.hits[0].axis.step_s;
        let frequency_hz = line as f64 / (self.plan.len() as f64 * step_s);
        let failed = FailedLine { line, frequency_hz };
        failed.error(error, self.options.estimator, pair)
    }
}

/// A line of an FRF that has no value.
pub(super) struct FailedLine {
    pub line: usize,
    pub frequency_hz: f64,
}

impl FailedLine {
    /// The error of the line, for the FRF of this response and reference.
    pub fn error(
        self,
        error: LineError,
        estimator: Estimator,
        (response, reference): (Dof, Dof),
    ) -> FrfError {
        let Self { line, frequency_hz } = self;
        match error {
            LineError::NoForce => FrfError::NoForce {
                response,
                reference,
                line,
                frequency_hz,
            },
            LineError::NotCorrelated => FrfError::NotCorrelated {
                estimator: estimator.name(),
                response,
                reference,
                line,
                frequency_hz,
            },
        }
    }
}

/// The spectrum of a record whose first sample lies this part of its length after that of the
/// force: `X_k exp(-2πi k delay)`.
pub(super) fn advance(spectrum: &mut [Complex64], delay: f64) {
    if delay.abs() > 0.0 {
        for (k, value) in spectrum.iter_mut().enumerate() {
            *value = *value * Complex64::cis(-std::f64::consts::TAU * k as f64 * delay);
        }
    }
}
