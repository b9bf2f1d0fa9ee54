//! One (response, hit point) pair: its records transformed, summed over hits and estimated.

use num_complex::Complex64;

use crate::dof::Dof;
use crate::finding::{Code, Finding, Place, Severity};
use crate::fourier::{ForwardPlan, Scratch};
use crate::record::{HitInfo, Samples};
use crate::signal::{Extent, offset_of, overloaded, to_si, vectorised};

use super::coherence::coherence;
use super::force::ForceHit;
use super::preconditions::kind_of;
use super::sums::{LineError, LineSums};
use super::truncation::QuarterEnergies;
use super::variance::{NoisePowers, variances};
use super::{EstimateOptions, Estimator, FrfError, Function, FunctionData, Selection};

/// The hits at one point, with their forces.
pub(super) struct Group<'a> {
    pub reference: &'a Dof,
    /// Their numbers in the recording, from 0.
    pub numbers: &'a [usize],
    pub hits: Vec<&'a HitInfo>,
    pub forces: Vec<ForceHit>,
    /// Power of all its forces.
    pub power: Vec<f64>,
}

/// `Σ|F|²` at every line.
pub(super) fn force_power<'a>(
    forces: impl IntoIterator<Item = &'a ForceHit>,
    lines: usize,
) -> Vec<f64> {
    let mut power = vec![0.0; lines];
    for force in forces {
        for (sum, f) in power.iter_mut().zip(&force.spectrum) {
            *sum += f.norm_sqr();
        }
    }
    power
}

/// One response and the hits of its group that hold it: number within the group, number of the response within the hit.
pub(super) struct Task {
    pub response: Dof,
    pub members: Vec<(usize, usize)>,
}

/// A finished function.
pub(super) struct Finished {
    pub function: Function,
    pub data: FunctionData,
    /// Power of the response at each line, summed over its hits.
    pub response_power: Vec<f64>,
    /// Of all its hits, for the bound on truncation.
    pub energies: Option<QuarterEnergies>,
    pub findings: Vec<Finding>,
}

/// Working memory of one thread.
pub(super) struct Work {
    scratch: Scratch,
    record: Vec<f64>,
    spectrum: Vec<Complex64>,
    gxx: Vec<f64>,
    gfx: Vec<Complex64>,
}

impl Work {
    pub fn new(plan: &ForwardPlan) -> Self {
        Self {
            scratch: plan.scratch(),
            record: Vec::new(),
            spectrum: vec![Complex64::ZERO; plan.lines()],
            gxx: Vec::new(),
            gfx: Vec::new(),
        }
    }

    fn clear(&mut self, lines: usize) {
        self.gxx.clear();
        self.gxx.resize(lines, 0.0);
        self.gfx.clear();
        self.gfx.resize(lines, Complex64::ZERO);
    }

    /// Adds the spectrum of a response to the sums, with that of its force.
    fn add(&mut self, force: &[Complex64]) {
        vectorised(
            #[inline(always)]
            || {
                let sums = self.gxx.iter_mut().zip(&mut self.gfx);
                let spectra = force.iter().zip(&self.spectrum);
                for ((gxx, gfx), (f, x)) in sums.zip(spectra) {
                    *gxx += x.re * x.re + x.im * x.im;
                    gfx.re += f.re * x.re + f.im * x.im;
                    gfx.im += f.re * x.im - f.im * x.re;
                }
            },
        );
    }

    /// The sums with the power of the force.
    fn sums(&self, force_power: &[f64]) -> Vec<LineSums> {
        let sums = force_power.iter().zip(&self.gxx).zip(&self.gfx);
        let line = |((gff, gxx), gfx): ((&f64, &f64), &Complex64)| LineSums {
            gff: *gff,
            gxx: *gxx,
            gfx: *gfx,
        };
        sums.map(line).collect()
    }
}

/// What the records of a function say besides their sums.
#[derive(Default)]
struct Totals {
    /// Numbers of the hits within the group.
    hits: Vec<usize>,
    energies: Vec<Option<QuarterEnergies>>,
    /// Expected energies of the noise under the window, per record.
    response_noise: Vec<f64>,
    force_noise: Vec<f64>,
    quiet_samples: usize,
}

impl Totals {
    fn noise_powers(&self) -> NoisePowers {
        let mean = |values: &[f64]| {
            (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
        };
        NoisePowers {
            response: mean(&self.response_noise),
            force: mean(&self.force_noise),
            samples: self.quiet_samples,
        }
    }
}

/// What all functions of a group share.
pub(super) struct Estimation<'a> {
    pub group: Group<'a>,
    pub plan: &'a ForwardPlan,
    pub selection: &'a Selection,
    /// Neighbouring lines that count as one each under the window.
    pub pooled_lines: f64,
    pub options: &'a EstimateOptions,
}

impl Estimation<'_> {
    /// Transforms and sums the records of a task, as they are stored and in the order of its members. Records that
    /// ran into the rail or hold nothing are left out, unless none would be left.
    pub fn finish(
        &self,
        task: &Task,
        records: &[Samples],
        work: &mut Work,
    ) -> Result<Finished, FrfError> {
        let mut totals = Totals::default();
        let mut findings = Vec::new();
        work.clear(self.plan.lines());
        for (member, samples) in task.members.iter().zip(records) {
            let extent = self.to_si(*member, samples, work)?;
            match self.unusable(*member, &work.record, &extent) {
                Some(finding) => findings.push(finding),
                None => self.add(*member, work, &mut totals)?,
            }
        }
        if totals.hits.is_empty() {
            findings = vec![self.none_left(task)];
            for (member, samples) in task.members.iter().zip(records) {
                self.to_si(*member, samples, work)?;
                self.add(*member, work, &mut totals)?;
            }
        }
        let sums = if totals.hits.len() == self.group.forces.len() {
            work.sums(&self.group.power)
        } else {
            let own = totals.hits.iter().map(|hit| &self.group.forces[*hit]);
            work.sums(&force_power(own, self.plan.lines()))
        };
        let finished = self.estimate(task, &sums, totals)?;
        findings.extend(finished.findings);
        Ok(Finished {
            findings,
            ..finished
        })
    }

    /// All records of a function are bad: they are used all the same.
    fn none_left(&self, task: &Task) -> Finding {
        let place = Place::Function {
            response: Some(task.response.clone()),
            reference: Some(self.group.reference.clone()),
        };
        let finding = Finding::new(Severity::Warning, Code::NoRecordPassed, place);
        finding.value(task.members.len() as f64, "hits")
    }

    fn to_si(
        &self,
        (h, r): (usize, usize),
        samples: &Samples,
        work: &mut Work,
    ) -> Result<Extent, FrfError> {
        let hit = self.group.hits[h];
        Ok(to_si(hit, &hit.responses[r], samples, &mut work.record)?)
    }

    /// The finding of a response of this extent that holds nothing, or ran into the rail.
    fn unusable(
        &self,
        (h, r): (usize, usize),
        record: &[f64],
        extent: &Extent,
    ) -> Option<Finding> {
        let number = self.group.numbers[h];
        let limits = self.selection.overloads.as_ref()?;
        if self.selection.accepted.contains(&number) {
            return None;
        }
        let channel = &self.group.hits[h].responses[r];
        let place = Place::HitChannel {
            hit: number + 1,
            dof: channel.dof.clone(),
        };
        if extent.range() <= 0.0 {
            return Some(Finding::new(Severity::Warning, Code::DeadChannel, place));
        }
        let check = overloaded(record, extent, channel.full_scale, limits)?;
        let finding = Finding::new(Severity::Warning, Code::Overload, place);
        Some(
            finding
                .value(check.value.unwrap_or_default(), check.unit)
                .limit(check.limit.unwrap_or_default()),
        )
    }

    /// Adds the record of one hit to the sums.
    fn add(
        &self,
        (h, r): (usize, usize),
        work: &mut Work,
        totals: &mut Totals,
    ) -> Result<(), FrfError> {
        let (hit, force) = (self.group.hits[h], &self.group.forces[h]);
        let (channel, frame) = (&hit.responses[r], &force.frame);
        let policy = self.options.offset;
        let (quiet, offset) = offset_of(hit, channel, &work.record, &frame.pulse, policy)?;
        let weights = frame.response_weights.as_deref();
        frame.apply(&mut work.record, offset, weights);
        let onset = frame.pulse.onset.saturating_sub(frame.range.start);
        let variance = quiet.map(|quiet| quiet.variance);
        let energies = QuarterEnergies::of(&work.record, onset, weights, variance);
        let (spectrum, scratch) = (&mut work.spectrum, &mut work.scratch);
        self.plan.run(&mut work.record, spectrum, scratch);
        work.add(&force.spectrum);
        totals.hits.push(h);
        totals.energies.push(energies);
        totals.force_noise.extend(force.noise);
        // Exact zeros before the hit are a gate, not the absence of noise.
        if let Some(quiet) = quiet.filter(|quiet| quiet.variance > 0.0) {
            let noise = quiet.variance * frame.noise_gain(weights);
            totals.response_noise.push(noise);
            totals.quiet_samples += quiet.samples;
        }
        Ok(())
    }

    fn estimate(
        &self,
        task: &Task,
        sums: &[LineSums],
        totals: Totals,
    ) -> Result<Finished, FrfError> {
        let estimator = self.options.estimator;
        let powers = &totals.noise_powers();
        let (kappa, finding) = self.noise_ratio(task, powers)?;
        let values: Vec<Complex64> = sums
            .iter()
            .enumerate()
            .map(|(line, sums)| {
                sums.estimate(estimator, kappa)
                    .map_err(|error| self.line_error(error, task, line))
            })
            .collect::<Result<_, _>>()?;
        let n = totals.hits.len();
        let (h, r) = task.members[0];
        let variances = variances(sums, &values, n, self.pooled_lines, powers);
        let function = Function {
            response: task.response.clone(),
            reference: self.group.reference.clone(),
            kind: kind_of(self.group.hits[h], &self.group.hits[h].responses[r])?,
            averages: u32::try_from(n).ok(),
            estimator: Some(estimator),
            variance_dof: variances.as_ref().map(|own| own.degrees_of_freedom),
        };
        let data = FunctionData {
            coherence: (n > 1).then(|| sums.iter().map(coherence).collect()),
            variance: variances.map(|own| own.values),
            values,
        };
        Ok(Finished {
            function,
            data,
            response_power: sums.iter().map(|sums| sums.gxx).collect(),
            energies: QuarterEnergies::sum(totals.energies),
            findings: finding.into_iter().collect(),
        })
    }

    /// The ratio of Hv with the finding that says where it came from; 0 and nothing for H1 and H2, which do not use it.
    fn noise_ratio(
        &self,
        task: &Task,
        powers: &NoisePowers,
    ) -> Result<(f64, Option<Finding>), FrfError> {
        match (self.options.estimator, self.options.noise_ratio) {
            (Estimator::H1 | Estimator::H2, _) => return Ok((0.0, None)),
            (Estimator::Hv, Some(stated)) => return Ok((stated, None)),
            (Estimator::Hv, None) => {}
        }
        let (response, reference) = (task.response.clone(), self.group.reference.clone());
        let ratio = powers.response.zip(powers.force).map(|(x, f)| x / f);
        match ratio.filter(|kappa| *kappa > 0.0 && kappa.is_finite()) {
            Some(kappa) => {
                let place = Place::Function {
                    response: Some(response),
                    reference: Some(reference),
                };
                let finding = Finding::new(Severity::Info, Code::NoiseRatioFromRecord, place);
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

    fn line_error(&self, error: LineError, task: &Task, line: usize) -> FrfError {
        let (response, reference) = (task.response.clone(), self.group.reference.clone());
        let step_s = self.group.hits[0].axis.step_s;
        let frequency_hz = line as f64 / (self.plan.len() as f64 * step_s);
        match error {
            LineError::NoForce => FrfError::NoForce {
                response,
                reference,
                line,
                frequency_hz,
            },
            LineError::NotCorrelated => FrfError::NotCorrelated {
                estimator: self.options.estimator.name(),
                response,
                reference,
                line,
                frequency_hz,
            },
        }
    }
}
