//! Every hit gets a report before the average: the rules of [`crate::signal`] assess its force and
//! up to four responses.
//!
//! Four responses show whether a hit was good; in a test with many sensors the others are read once
//! only, when they are transformed.

use std::collections::BTreeMap;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::fourier::{ForwardPlan, Scratch};
use crate::record::{ChannelPlace, ChannelSegment, HitInfo, Recording, Samples};
use crate::signal::{
    Check, HitQualityLimits, ONSET_FRACTION, Outcome, Pulse, ResponseRecord, Rule, assess_force,
    assess_levels, assess_response, inconsistent_hits, to_si,
};

use super::FrfError;
use super::hammer_options::HammerOptions;
use super::preconditions::check;

/// Responses of a hit that are assessed.
const MAX_ASSESSED_RESPONSES: usize = 4;

/// The responses of a hit that are assessed, of `count`: spread over the channels, as neighbours in
/// a file often sit side by side.
pub(super) fn assessed_responses(count: usize) -> impl Iterator<Item = usize> {
    let step = count.div_ceil(MAX_ASSESSED_RESPONSES);
    (0..count).step_by(step.max(1))
}

/// Hits that are read and assessed at a time.
const HITS_PER_BLOCK: usize = 8;

/// End of the band in which the force spectrum is assessed, as a fraction of the sampling rate;
/// anti-alias filters are flat up to about there.
const MAX_BAND_OVER_SAMPLING_RATE: f64 = 0.4;

/// One hit with what the rules say of it.
#[derive(Clone, Debug, PartialEq)]
pub struct HitReport {
    /// Number in the test, from 1.
    pub number: usize,
    /// Where it came from.
    pub origin: String,
    /// The excitation point.
    pub reference: Dof,
    /// Height of the pulse with its sign, N; `None` without a pulse, and for a rejected hit that
    /// cannot be read.
    pub peak_n: Option<f64>,
    /// First sample of the pulse.
    pub onset: usize,
    /// The result of each rule.
    pub checks: Vec<Check>,
    /// Whether it is averaged.
    pub used: bool,
    /// Whether the user decided that, not the rules.
    pub stated: bool,
}

impl HitReport {
    /// Whether a check leaves out the whole hit: a single response that is bad leaves out that
    /// response alone.
    pub(super) fn rejects(&self, check: &Check) -> bool {
        // What rings before the hit does so at every sensor.
        let of_hit = matches!(check.rule, Rule::InconsistentHit | Rule::PreTrigger);
        check.outcome == Outcome::Rejected && (check.dof.is_none() || of_hit)
    }

    /// A finding for each rule that the hit does not pass.
    pub(super) fn findings(&self) -> impl Iterator<Item = Finding> + '_ {
        let is_reported = |check: &&Check| match check.outcome {
            Outcome::Passed | Outcome::NotDecidable => false,
            // The window and the usable band are those of the whole test, which says so once.
            Outcome::Noted => !matches!(check.rule, Rule::Decay | Rule::RollOff),
            Outcome::Rejected => true,
        };
        self.checks
            .iter()
            .filter(is_reported)
            .map(|check| self.finding(check))
    }

    fn finding(&self, check: &Check) -> Finding {
        let severity = match check.outcome {
            Outcome::Rejected => Severity::Warning,
            _ => Severity::Info,
        };
        let location = match &check.dof {
            None => Location::Hit(self.number),
            Some(dof) => Location::HitChannel {
                hit: self.number,
                dof: dof.clone(),
            },
        };
        let mut finding = Finding::new(severity, code(check.rule), location);
        if let Some(value) = check.value {
            finding = finding.value(value, check.unit);
        }
        match check.limit {
            Some(limit) => finding.limit(limit),
            None => finding,
        }
    }
}

fn code(rule: Rule) -> Code {
    match rule {
        Rule::DoubleHit => Code::DoubleHit,
        Rule::Overload => Code::Overload,
        Rule::Level => Code::HitLevel,
        Rule::PreTrigger => Code::PreTriggerNotQuiet,
        Rule::Decay => Code::NotDecayed,
        Rule::RollOff => Code::ForceRollOff,
        Rule::Dead => Code::DeadChannel,
        Rule::Sign => Code::NegativeForce,
        Rule::Drift => Code::ChannelDrift,
        Rule::InconsistentHit => Code::InconsistentHit,
    }
}

/// The stored data of a hit until the series is checked.
struct AssessedHit {
    report: HitReport,
    /// Force, and the response of which FRFs are compared, at the lines of the assessed band.
    spectra: (Vec<Complex64>, Vec<Complex64>),
    /// That response.
    compared: Dof,
}

/// Tests every hit alone and against the others of its point.
///
/// # Errors
/// [`FrfError`] for hits that cannot be averaged, and for samples that cannot be read or used.
pub(super) fn assess_hits(
    recording: &mut dyn Recording,
    options: &HammerOptions,
) -> Result<Vec<HitReport>, FrfError> {
    let infos: Vec<HitInfo> = recording.hits().to_vec();
    // What the user rejects is not assessed: it may be what cannot be read.
    let wanted: Vec<usize> = (0..infos.len())
        .filter(|hit| !options.reject.contains(&(hit + 1)))
        .collect();
    let of_wanted: Vec<&HitInfo> = wanted.iter().map(|hit| &infos[*hit]).collect();
    check(&of_wanted, &options.estimate)?;
    let plan = ForwardPlan::new(of_wanted[0].axis.len);
    let kept = kept_lines(wanted.len());
    let mut assessed = Vec::with_capacity(wanted.len());
    for hits in wanted.chunks(HITS_PER_BLOCK) {
        let read: Vec<HitSamples> = hits
            .iter()
            .map(|hit| HitSamples::read(recording, *hit, &infos[*hit]))
            .collect::<Result<_, FrfError>>()?;
        let block: Vec<Result<AssessedHit, FrfError>> = read
            .par_iter()
            .map_init(
                || plan.scratch(),
                |scratch, read| {
                    read.assess(&infos[read.hit], &options.limits, kept, &plan, scratch)
                },
            )
            .collect();
        for hit in block {
            assessed.push(hit?);
        }
    }
    compare_hits(&mut assessed, &options.limits);
    let mut reports: Vec<HitReport> = assessed.into_iter().map(|hit| hit.report).collect();
    for hit in (0..infos.len()).filter(|hit| options.reject.contains(&(hit + 1))) {
        let pulse = force_pulse(recording, hit, &infos[hit]);
        reports.push(report(hit, &infos[hit], pulse.as_ref(), Vec::new()));
    }
    reports.sort_by_key(|report| report.number);
    Ok(reports)
}

/// The pulse of a hit that is not assessed; `None` where its force cannot be read or has none.
fn force_pulse(recording: &mut dyn Recording, hit: usize, info: &HitInfo) -> Option<Pulse> {
    let samples = read_channel(recording, hit, info, ChannelPlace::Force).ok()?;
    let mut force = Vec::new();
    to_si(info, &info.force, &samples, &mut force).ok()?;
    Pulse::locate(&force, ONSET_FRACTION)
}

fn read_channel(
    recording: &mut dyn Recording,
    hit: usize,
    info: &HitInfo,
    channel: ChannelPlace,
) -> Result<Samples, FrfError> {
    let mut samples = Samples::F32(Vec::new());
    let segment = ChannelSegment {
        hit,
        channel,
        samples: 0..info.axis.len,
    };
    recording.read(&segment, &mut samples)?;
    Ok(samples)
}

/// The samples of a hit that are assessed.
struct HitSamples {
    hit: usize,
    force: Samples,
    responses: Vec<(usize, Samples)>,
}

impl HitSamples {
    fn read(recording: &mut dyn Recording, hit: usize, info: &HitInfo) -> Result<Self, FrfError> {
        let mut read = |channel| read_channel(recording, hit, info, channel);
        let force = read(ChannelPlace::Force)?;
        let responses = assessed_responses(info.responses.len());
        let responses = responses.map(|r| Ok((r, read(ChannelPlace::Response(r))?)));
        Ok(Self {
            hit,
            force,
            responses: responses.collect::<Result<_, FrfError>>()?,
        })
    }

    fn assess(
        &self,
        info: &HitInfo,
        limits: &HitQualityLimits,
        kept: usize,
        plan: &ForwardPlan,
        scratch: &mut Scratch,
    ) -> Result<AssessedHit, FrfError> {
        let step_s = info.axis.step_s;
        let (mut force, mut response) = (Vec::new(), Vec::new());
        to_si(info, &info.force, &self.force, &mut force)?;
        let Some(pulse) = Pulse::locate(&force, ONSET_FRACTION) else {
            return Ok(self.without_pulse(info));
        };
        let band_end_hz = MAX_BAND_OVER_SAMPLING_RATE / step_s;
        let full_scale = info.force.full_scale;
        let mut checks = assess_force(&force, step_s, &pulse, full_scale, band_end_hz, limits);
        let mut compared: Option<(Dof, Vec<Complex64>)> = None;
        for (number, samples) in &self.responses {
            let channel = &info.responses[*number];
            to_si(info, channel, samples, &mut response)?;
            let record = ResponseRecord {
                samples: &response,
                step_s,
                dof: &channel.dof,
                full_scale: channel.full_scale,
            };
            checks.extend(assess_response(&record, &pulse, limits));
            // FRFs are compared at the first response: the same one in every hit of a point.
            if compared.is_none() {
                let lines = thinned_spectrum(&response, kept, plan, scratch);
                compared = Some((channel.dof.clone(), lines));
            }
        }
        let (compared, response) = compared.ok_or_else(|| FrfError::NoResponse {
            origin: info.origin.clone(),
        })?;
        let force = thinned_spectrum(&force, kept, plan, scratch);
        Ok(AssessedHit {
            report: report(self.hit, info, Some(&pulse), checks),
            spectra: (force, response),
            compared,
        })
    }
}

impl HitSamples {
    /// A constant force: no impact.
    fn without_pulse(&self, info: &HitInfo) -> AssessedHit {
        let check = Check::new(Rule::Dead, Outcome::Rejected);
        AssessedHit {
            report: report(self.hit, info, None, vec![check]),
            spectra: (Vec::new(), Vec::new()),
            compared: info.responses[0].dof.clone(),
        }
    }
}

fn report(hit: usize, info: &HitInfo, pulse: Option<&Pulse>, checks: Vec<Check>) -> HitReport {
    HitReport {
        number: hit + 1,
        origin: info.origin.clone(),
        reference: info.force.dof.clone(),
        peak_n: pulse.map(|pulse| pulse.height_n),
        onset: pulse.map_or(0, |pulse| pulse.onset),
        checks,
        used: true,
        stated: false,
    }
}

/// Maximum number of lines of a hit that are kept until all of its point are there, which is enough
/// to tell another point.
const MAX_KEPT_LINES: usize = 2048;
/// Minimum number of them in a series of many hits. Fewer: a resonance is a single line.
const MIN_KEPT_LINES: usize = 256;
/// Lines that are kept of all hits together, 17 MB. More: the memory follows the number of hits.
/// Fewer: those of a usual test of 250 hits are thinned.
const KEPT_LINES: usize = 1 << 19;

/// Lines that are kept of each of so many hits.
fn kept_lines(hits: usize) -> usize {
    (KEPT_LINES / hits.max(1)).clamp(MIN_KEPT_LINES, MAX_KEPT_LINES)
}

/// Spectrum of a whole record up to the end of the assessed band, without the line at 0 Hz; of many
/// lines an even choice.
fn thinned_spectrum(
    record: &[f64],
    kept: usize,
    plan: &ForwardPlan,
    scratch: &mut Scratch,
) -> Vec<Complex64> {
    let mut lines = vec![Complex64::ZERO; plan.lines()];
    plan.forward(record.iter().copied(), &mut lines, scratch);
    let end = (MAX_BAND_OVER_SAMPLING_RATE * plan.len() as f64) as usize;
    let end = end.max(2).min(lines.len());
    let step = (end - 1).div_ceil(kept).max(1);
    lines[1..end].iter().step_by(step).copied().collect()
}

/// Holds the hits of each point that stand by themselves against each other.
fn compare_hits(assessed: &mut [AssessedHit], limits: &HitQualityLimits) {
    let mut points: BTreeMap<(Dof, Dof), Vec<usize>> = BTreeMap::new();
    let stands = |hit: &AssessedHit| {
        !hit.report
            .checks
            .iter()
            .any(|check| hit.report.rejects(check))
    };
    for (index, hit) in assessed.iter().enumerate().filter(|(_, hit)| stands(hit)) {
        let key = (hit.report.reference.clone(), hit.compared.clone());
        points.entry(key).or_default().push(index);
    }
    for hits in points.values() {
        let peaks: Vec<f64> = hits
            .iter()
            .map(|hit| assessed[*hit].report.peak_n.unwrap_or(0.0))
            .collect();
        let forces: Vec<&[Complex64]> = hits
            .iter()
            .map(|hit| assessed[*hit].spectra.0.as_slice())
            .collect();
        let responses: Vec<&[Complex64]> = hits
            .iter()
            .map(|hit| assessed[*hit].spectra.1.as_slice())
            .collect();
        let levels = assess_levels(&peaks, limits);
        let odd = inconsistent_hits(&forces, &responses, limits);
        for (hit, check) in hits.iter().zip(levels) {
            assessed[*hit].report.checks.push(check);
        }
        for (hit, check) in hits.iter().zip(odd) {
            assessed[*hit].report.checks.push(check);
        }
    }
}
