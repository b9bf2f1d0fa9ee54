//! Random, burst random and sine excitation: records are cut into blocks, and the spectra of force
//! and response are averaged over them (Welch 1967).
//!
//! A burst that ends within its record, with the response to it, needs no window and has no
//! leakage: each record is a block. Steady excitation has blocks with Hann windows that overlap by
//! half; their FRFs are too low at resonances narrower than the window's lines, and the set states
//! the window, so that identification fits poles with the line shape of that leakage.

use std::collections::BTreeMap;
use std::sync::Arc;

use num_complex::Complex64;

use crate::axis::TimeAxis;
use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::fourier::ForwardPlan;
use crate::record::{ChannelPlace, ChannelSegment, HitInfo, Recording, Samples};
use crate::signal::to_si;

use super::coherence::coherence;
use super::consistency::check_set;
use super::estimate::{Estimated, low_coherence_finding};
use super::force::fast_transform_length;
use super::frf_estimation::{FailedLine, advance, force_power};
use super::hammer_test::HammerTestResult;
use super::peaks::clear_peaks;
use super::preconditions::{check, kind_of};
use super::spectra_sums::Sums;
use super::usable_band::ForcePower;
use super::variance::{Averaged, NoisePowers, independent_lines, variances};
use super::{
    EstimateOptions, Estimator, FrfError, FrfSet, Function, FunctionData, HammerOptions, Window,
};

/// Blocks that steady excitation is cut into where no length is stated. Fewer: the variance has few
/// degrees of freedom. More: blocks are shorter, and leakage is larger.
const BLOCKS: f64 = 16.0;
/// Fewest samples of a block.
const MIN_BLOCK_SAMPLES: usize = 32;
/// Part of a record at each end that is compared with the whole. Smaller: a generator that was
/// switched off before the recording makes a burst. Larger: a burst over most of its record is
/// none.
const END_PART: f64 = 0.05;
/// Largest root mean square of a force at the end of its record over that of the whole where it is
/// a burst. Larger: steady noise passes, by chance, at some of its ends. Smaller: the noise of a
/// force cell makes a burst steady (`burst_random_frfs_are_exact_within_their_variance`).
const MAX_QUIET: f64 = 0.1;
/// Largest root mean square of a response at the end of a record, beyond that at its start, over
/// that of the whole: that much leaks.
const MAX_LEFT: f64 = 0.02;
/// Squared correlation of neighbouring blocks under Hann windows that overlap by half, `(Σ w_n
/// w_{n+L/2} / Σ w²)² = 1/36`.
const OVERLAP_CORRELATION: f64 = 1.0 / 36.0;
/// Relative change of a peak by blocks of half the length that is reported.
const MAX_LEAKAGE: f64 = 0.05;
/// Height of a peak over the median of its function at which leakage is looked at, as power.
const PEAK_OVER_MEDIAN: f64 = 10.0;

/// FRFs of a test with steady or burst excitation; it has no hits.
///
/// # Errors
/// [`FrfError`] as of a hammer test; [`FrfError::BlockLength`] for a block that is too short or
/// longer than a record.
pub(super) fn evaluate_shaker_test(
    recording: &mut dyn Recording,
    options: &HammerOptions,
) -> Result<HammerTestResult, FrfError> {
    let infos: Vec<HitInfo> = recording.hits().to_vec();
    check(&infos.iter().collect::<Vec<_>>(), &options.estimate)?;
    let is_burst = infos.len() > 1 && is_burst(recording, &infos[0])?;
    let blocks = Blocks::new(&infos, is_burst, options.block_length_s)?;
    let mut averaged = average(recording, &infos, &blocks, &options.estimate)?;
    let leakage = match blocks.half() {
        Some(half) => {
            let half = average(recording, &infos, &half, &options.estimate)?;
            leakage_finding(&averaged.set, &half.set, blocks.len)
        }
        None => cut_off_finding(recording, &infos[0])?,
    };
    let checks = check_set(&averaged.set);
    let findings = &mut averaged.set.findings;
    findings.extend(leakage);
    findings.extend(checks);
    let usable = averaged.set.valid_band.ok_or(FrfError::BandEmpty {
        lo_hz: averaged.set.axis().hz(1),
        hi_hz: 0.0,
    })?;
    Ok(HammerTestResult {
        estimated: averaged,
        hits: Vec::new(),
        usable,
        estimate: options.estimate,
        drift: None,
    })
}

/// How records are cut.
struct Blocks {
    /// Samples of a block.
    len: usize,
    /// Samples from the start of one to that of the next.
    hop: usize,
    /// Weights of the samples; none for a burst.
    weights: Option<Vec<f64>>,
}

impl Blocks {
    fn new(infos: &[HitInfo], is_burst: bool, length_s: Option<f64>) -> Result<Self, FrfError> {
        let axis = infos[0].axis;
        let is_whole = |s: f64| (s / axis.duration_s() - 1.0).abs() < 0.01;
        if is_burst && length_s.is_none_or(is_whole) {
            return Ok(Self {
                len: axis.len,
                hop: axis.len,
                weights: None,
            });
        }
        let by_reference = infos.iter().fold(BTreeMap::new(), |mut records, info| {
            *records.entry(&info.force.dof).or_insert(0.0) += 1.0;
            records
        });
        let records = by_reference.values().copied().fold(f64::INFINITY, f64::min);
        let default = 2.0 * axis.len as f64 / (BLOCKS / records + 1.0);
        let samples = length_s.map_or(default.min(axis.len as f64), |s| s / axis.step_s);
        let len = samples.round();
        if !(len >= MIN_BLOCK_SAMPLES as f64 && len <= axis.len as f64) {
            return Err(FrfError::BlockLength {
                got_s: len * axis.step_s,
                shortest_s: MIN_BLOCK_SAMPLES as f64 * axis.step_s,
                longest_s: axis.duration_s(),
            });
        }
        let len = match length_s {
            Some(_) => len as usize,
            None => fast_transform_length(len as usize),
        };
        Ok(Self {
            len,
            hop: len.div_ceil(2),
            weights: Some(hann(len)),
        })
    }

    /// Blocks of the same lines whose window is half as long; `None` without a window.
    fn half(&self) -> Option<Self> {
        self.weights.as_ref().map(|_| {
            let mut weights = hann(self.len / 2);
            weights.resize(self.len, 0.0);
            Self {
                len: self.len,
                hop: self.hop,
                weights: Some(weights),
            }
        })
    }

    /// First samples of the blocks of a record.
    fn starts(&self, record: usize) -> impl Iterator<Item = usize> {
        (0..=record - self.len).step_by(self.hop)
    }

    /// Number of independent averages that so many blocks are worth.
    fn independent(&self, blocks: usize) -> usize {
        let blocks = blocks as f64;
        let alike = match self.weights {
            Some(_) => 2.0 * OVERLAP_CORRELATION * (blocks - 1.0) / blocks,
            None => 0.0,
        };
        (blocks / (1.0 + alike)).floor().max(1.0) as usize
    }
}

fn hann(len: usize) -> Vec<f64> {
    let weight = |n: usize| {
        (std::f64::consts::PI * (n as f64 + 0.5) / len as f64)
            .sin()
            .powi(2)
    };
    (0..len).map(weight).collect()
}

/// Root mean squares of a record at its start and its end, over that of the whole.
struct Ends {
    start: f64,
    end: f64,
}

impl Ends {
    fn of(values: &[f64]) -> Self {
        let ends = ((END_PART * values.len() as f64) as usize).max(1);
        let rms = |values: &[f64]| {
            (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
        };
        let whole = rms(values).max(f64::MIN_POSITIVE);
        Self {
            start: rms(&values[..ends]) / whole,
            end: rms(&values[values.len() - ends..]) / whole,
        }
    }
}

/// Whether the force of the first record ends within it.
fn is_burst(recording: &mut dyn Recording, info: &HitInfo) -> Result<bool, FrfError> {
    let force = Ends::of(&read(recording, info, 0, ChannelPlace::Force)?);
    Ok(force.end <= MAX_QUIET)
}

/// The finding of responses of the first record that have not decayed when it ends.
fn cut_off_finding(
    recording: &mut dyn Recording,
    info: &HitInfo,
) -> Result<Option<Finding>, FrfError> {
    let mut largest: f64 = 0.0;
    for number in 0..info.responses.len() {
        let response = Ends::of(&read(recording, info, 0, ChannelPlace::Response(number))?);
        // A start that is as loud is the tail of the burst before, or noise.
        let is_noise_small = response.start < 0.5 * response.end;
        let noise = if is_noise_small { response.start } else { 0.0 };
        largest = largest.max((response.end * response.end - noise * noise).sqrt());
    }
    let finding = Finding::new(Severity::Warning, Code::BlockLeakage, Location::Whole);
    let finding = finding.value(largest, "").limit(MAX_LEFT);
    let detail = "the responses to the burst have not decayed when the record ends";
    Ok((largest > MAX_LEFT).then(|| finding.detail(detail.to_owned())))
}

/// The samples of a channel in SI units, without their mean.
fn read(
    recording: &mut dyn Recording,
    info: &HitInfo,
    record: usize,
    channel: ChannelPlace,
) -> Result<Vec<f64>, FrfError> {
    let (mut samples, mut values) = (Samples::F64(Vec::new()), Vec::new());
    let segment = ChannelSegment {
        hit: record,
        channel,
        samples: 0..info.axis.len,
    };
    recording.read(&segment, &mut samples)?;
    to_si(info, info.channel(channel), &samples, &mut values)?;
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter_mut().for_each(|value| *value -= mean);
    Ok(values)
}

/// FRFs averaged over all blocks.
fn average(
    recording: &mut dyn Recording,
    infos: &[HitInfo],
    blocks: &Blocks,
    options: &EstimateOptions,
) -> Result<Estimated, FrfError> {
    let averaging = Averaging {
        blocks,
        plan: ForwardPlan::new(blocks.len),
        options,
    };
    let axis = TimeAxis {
        len: blocks.len,
        ..infos[0].axis
    };
    let mut power = ForcePower::new(axis);
    let mut by_reference: BTreeMap<&Dof, Vec<usize>> = BTreeMap::new();
    for (record, info) in infos.iter().enumerate() {
        by_reference
            .entry(&info.force.dof)
            .or_default()
            .push(record);
    }
    let mut set = FrfSet::new(axis.spectrum_axis());
    for (reference, records) in by_reference {
        let mut forces = Vec::with_capacity(records.len());
        for &record in &records {
            let values = read(recording, &infos[record], record, ChannelPlace::Force)?;
            let spectra = averaging.spectra(&values, 0.0);
            spectra
                .iter()
                .for_each(|spectrum| power.add(spectrum, None));
            forces.push(RecordSpectra { record, spectra });
        }
        let mut responses: BTreeMap<&Dof, Vec<(usize, usize)>> = BTreeMap::new();
        for (place, force) in forces.iter().enumerate() {
            let channels = infos[force.record].responses.iter().enumerate();
            for (number, channel) in channels {
                responses
                    .entry(&channel.dof)
                    .or_default()
                    .push((place, number));
            }
        }
        for (response, places) in responses {
            let pair = (response.clone(), reference.clone());
            let (function, data) = averaging.frf(recording, infos, &forces, &places, pair)?;
            set.push(function, data)?;
        }
    }
    set.record_duration_s = Some(axis.duration_s());
    set.window = blocks.weights.as_ref().map(|_| Window::HannBroad);
    set.valid_band = power.covered_band().ok();
    set.excited_band = set.valid_band;
    let low = low_coherence_finding(&set);
    set.findings.extend(low);
    Ok(Estimated {
        set,
        truncation: BTreeMap::new(),
    })
}

/// Spectra of the force of a record, one per block.
struct RecordSpectra {
    record: usize,
    spectra: Vec<Vec<Complex64>>,
}

struct Averaging<'a> {
    blocks: &'a Blocks,
    plan: ForwardPlan,
    options: &'a EstimateOptions,
}

impl Averaging<'_> {
    /// The spectra of the blocks of a record that starts so late.
    fn spectra(&self, values: &[f64], delay_s_over_step: f64) -> Vec<Vec<Complex64>> {
        let mut scratch = self.plan.scratch();
        let delay = delay_s_over_step / self.blocks.len as f64;
        let spectrum = |start: usize| {
            let block = &values[start..start + self.blocks.len];
            let mut block = block.to_vec();
            if let Some(weights) = &self.blocks.weights {
                let weighted = block.iter_mut().zip(weights);
                weighted.for_each(|(value, weight)| *value *= weight);
            }
            let mut lines = vec![Complex64::ZERO; self.plan.lines()];
            self.plan.run(&mut block, &mut lines, &mut scratch);
            advance(&mut lines, delay);
            lines
        };
        self.blocks.starts(values.len()).map(spectrum).collect()
    }

    /// One FRF from the records that have its response, by their place among the forces and the
    /// number of the response there.
    fn frf(
        &self,
        recording: &mut dyn Recording,
        infos: &[HitInfo],
        forces: &[RecordSpectra],
        places: &[(usize, usize)],
        (response, reference): (Dof, Dof),
    ) -> Result<(Function, FunctionData), FrfError> {
        let mut sums = Sums::default();
        sums.clear(self.plan.lines());
        let mut used = Vec::new();
        for &(place, number) in places {
            let (force, info) = (&forces[place], &infos[forces[place].record]);
            let channel = ChannelPlace::Response(number);
            let values = read(recording, info, force.record, channel)?;
            let delay = info.responses[number].delay_s / info.axis.step_s;
            let spectra = self.spectra(&values, delay);
            let pairs = force.spectra.iter().zip(&spectra);
            let pairs: Vec<_> = pairs.map(|(f, x)| (f.as_slice(), x.as_slice())).collect();
            sums.add(&pairs);
            used.extend(force.spectra.iter());
        }
        sums.gff = power_of(&used, self.plan.lines());
        let first = &infos[forces[places[0].0].record];
        let kappa = match (self.options.estimator, self.options.noise_ratio) {
            (Estimator::Hv, None) => {
                return Err(FrfError::NoiseUnknown {
                    response,
                    reference,
                    response_noise: None,
                    force_noise: None,
                });
            }
            (_, ratio) => ratio.unwrap_or_default(),
        };
        let values = sums.estimates(self.options.estimator, kappa);
        let values = values.map_err(|(line, error)| {
            let frequency_hz = line as f64 / (self.blocks.len as f64 * first.axis.step_s);
            let pair = (response.clone(), reference.clone());
            let failed = FailedLine { line, frequency_hz };
            failed.error(error, self.options.estimator, pair)
        })?;
        let averages = self.blocks.independent(used.len());
        let coherence = (averages > 1).then(|| sums.each(coherence));
        let averaged = Averaged {
            sums: &sums,
            values: &values,
            is_h1: self.options.estimator == Estimator::H1,
            coherence: coherence.as_deref().unwrap_or_default(),
            averages,
        };
        let no_noise = NoisePowers {
            response: None,
            force: None,
            samples: 0,
        };
        let pooled_lines = independent_lines(self.blocks.weights.as_deref());
        let variances = variances(&averaged, pooled_lines, &no_noise);
        let function = Function {
            kind: kind_of(first, &first.responses[places[0].1])?,
            response,
            reference,
            averages: u32::try_from(averages).ok(),
            estimator: Some(self.options.estimator),
            variance_dof: variances.as_ref().map(|of| of.degrees_of_freedom),
        };
        let data = FunctionData {
            coherence,
            variance: variances.map(|of| of.values),
            values,
        };
        Ok((function, data))
    }
}

/// `Σ|F|²` of each line.
fn power_of(spectra: &[&Vec<Complex64>], lines: usize) -> Arc<[f64]> {
    force_power(spectra.iter().map(|spectrum| spectrum.as_slice()), lines)
}

/// Bias of the peak of a mode of decay rate σ by Hann windows of length T: the expectation of H1 is
/// the impulse response times the autocorrelation of the window,
/// `R(u) = ((1 − u)(2 + cos 2πu) + 3 sin(2πu)/2π)/3`, u = t/T.
fn bias(decays: f64) -> f64 {
    const STEPS: usize = 400;
    let term = |step: usize| {
        let u = (step as f64 + 0.5) / STEPS as f64;
        let turn = std::f64::consts::TAU * u;
        let window =
            ((1.0 - u) * (2.0 + turn.cos()) + 3.0 * turn.sin() / std::f64::consts::TAU) / 3.0;
        (1.0 - window) * (-decays * u).exp() / STEPS as f64
    };
    decays * (0..STEPS).map(term).sum::<f64>() + (-decays).exp()
}

/// The bias of a peak that blocks of half the length lower by this part of it.
fn bias_of_change(change: f64) -> f64 {
    let of = |decays: f64| (bias(0.5 * decays) - bias(decays)) / (1.0 - bias(decays));
    let (mut short, mut long) = (0.5, 1e3);
    if change <= of(long) {
        return change;
    }
    // The change falls with the length.
    for _ in 0..60 {
        let middle = f64::sqrt(short * long);
        if of(middle) > change {
            short = middle;
        } else {
            long = middle;
        }
    }
    bias(long)
}

/// The largest bias of a peak by leakage, from its change by blocks of half the length beyond its
/// noise.
fn leakage_finding(set: &FrfSet, half: &FrfSet, block: usize) -> Option<Finding> {
    let lines = set.axis().lines(&set.valid_band?);
    let of_function = |i: usize| {
        let power: Vec<f64> = set.values(i)[lines.clone()]
            .iter()
            .map(Complex64::norm_sqr)
            .collect();
        let mut sorted = power.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let floor = PEAK_OVER_MEDIAN * sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
        let change = |line: usize| {
            let k = lines.start + line;
            let (whole, half) = (set.values(i)[k], half.values(i)[k]);
            let noise = set.variance(i).map_or(0.0, |variance| variance[k].sqrt());
            bias_of_change((whole.norm() - half.norm() - 2.0 * noise).max(0.0) / whole.norm())
        };
        let peaks = clear_peaks(&power, &vec![floor; power.len()], 0.0);
        peaks
            .iter()
            .map(|peak| change(peak.line))
            .fold(0.0, f64::max)
    };
    let changes = (0..set.len()).map(of_function);
    let largest = changes.fold(0.0, f64::max);
    let finding = Finding::new(Severity::Warning, Code::BlockLeakage, Location::Whole);
    let finding = finding.value(largest, "").limit(MAX_LEAKAGE);
    let detail = format!("blocks of {block} samples");
    (largest > MAX_LEAKAGE).then(|| finding.detail(detail))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bias_of_a_peak_follows_from_its_change() {
        for (decays, expected) in [(30.0, 0.014), (15.0, 0.051), (8.0, 0.139), (4.0, 0.32)] {
            assert!(
                (bias(decays) / expected - 1.0).abs() < 0.05,
                "{}",
                bias(decays)
            );
            let change = (bias(0.5 * decays) - bias(decays)) / (1.0 - bias(decays));
            assert!((bias_of_change(change) / bias(decays) - 1.0).abs() < 1e-6);
        }
    }
}
