//! From hits to an FRF set: every (response, hit point) pair averaged over the hits that hold it.
//!
//! Roving hammer and roving accelerometer are the same thing here. Degrees of freedom keep the signs of their
//! sensors and the samples are taken as they are. It does not choose hits: what comes in is averaged.

use std::collections::{BTreeMap, BTreeSet};

use num_complex::Complex64;
use rayon::prelude::*;

use crate::dof::Dof;
use crate::finding::{Code, Finding, Place, Severity};
use crate::fourier::ForwardPlan;
use crate::quantity::{FrfKind, Quantity};
use crate::record::Hit;
use crate::signal::{
    ConditionedChannel, Conditioning, ExponentialWindow, ForceWindow, HitSpectra, SignalError,
    condition, hit_spectra,
};

use super::coherence::coherence;
use super::sums::{LineError, LineSums};
use super::truncation::{QuarterEnergies, truncation_finding};
use super::usable::{band_of, excited_band_of};
use super::variance::variance;
use super::{Estimator, FrfError, FrfSet, Function, FunctionData, Truncation};

/// How hits become FRFs. The default is H1 of the records as they are: no window, no offset removed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimateOptions {
    /// Estimator of every function.
    pub estimator: Estimator,
    /// Window of the force alone.
    pub force_window: Option<ForceWindow>,
    /// Window of force and responses; its decay rate becomes [`FrfSet::added_damping_rad_s`].
    pub exponential: Option<ExponentialWindow>,
    /// Noise power in the response spectrum over that in the force spectrum, SI units squared, for Hv.
    /// `None` takes it from the samples before each hit.
    pub noise_ratio: Option<f64>,
    /// Take the mean before the hit off each channel.
    pub remove_offset: bool,
}

impl Default for EstimateOptions {
    fn default() -> Self {
        Self {
            estimator: Estimator::H1,
            force_window: None,
            exponential: None,
            noise_ratio: None,
            remove_offset: false,
        }
    }
}

impl EstimateOptions {
    /// Checks the windows and the noise ratio.
    ///
    /// # Errors
    /// [`FrfError::Signal`] for a window; [`FrfError::NoiseRatio`] unless it is positive and finite.
    pub fn validate(&self) -> Result<(), FrfError> {
        self.conditioning().validate()?;
        match self.noise_ratio {
            Some(got) if !(got > 0.0 && got.is_finite()) => Err(FrfError::NoiseRatio { got }),
            _ => Ok(()),
        }
    }

    /// The part that is done to each hit alone.
    pub fn conditioning(&self) -> Conditioning {
        Conditioning {
            force_window: self.force_window,
            exponential: self.exponential,
            remove_offset: self.remove_offset,
        }
    }
}

/// Estimates the FRF of every (response, hit point) pair, ordered by response and reference.
///
/// Over the hits of a pair, with unscaled one-sided spectra F and X: `Gff = Σ|F|²`, `Gxx = Σ|X|²`, `Gfx = ΣF* X`;
///
/// - `H1 = Gfx / Gff`, unbiased for noise on the response;
/// - `H2 = Gxx / Gfx*`, unbiased for noise on the force;
/// - `Hv = [b + sqrt(b² + 4κ|Gfx|²)] / (2 Gfx*)`, `b = Gxx - κ Gff`, total least squares for noise on both with
///   the power ratio κ = response / force; κ → ∞ is H1, κ → 0 is H2. Without a stated ratio κ comes from the
///   variances before the hits, each times the energy of its window and averaged over the hits; it carries the
///   units of both channels, so that Hv does not depend on them.
///
/// Coherence and variance are there from two hits on. A response that is exactly 0 in every hit at a line gives 0
/// there; a line that no hit excites is an error. Findings: [`Code::CoherenceAbsent`] (its value is the number of
/// functions with one hit), [`Code::NoiseRatioFromRecord`] of each function, and [`Code::Truncated`] or
/// [`Code::TruncationNotDecidable`]. The result does not depend on the number of threads.
///
/// # Errors
/// [`FrfError`] for options out of range, no hits, hits of different axes, channels of a wrong quantity, a response
/// that is twice in a hit, a hit that cannot be conditioned, an unknown noise ratio of Hv, and a line without value.
///
/// # Reference
/// Bendat and Piersol (2010), Random Data, 4th ed., chapter 6; Rocklin, Crowley and Vold (1985), A comparison of
/// H1, H2 and Hv frequency response functions, IMAC 3.
pub fn estimate(hits: &[Hit], options: &EstimateOptions) -> Result<FrfSet, FrfError> {
    check(hits, options)?;
    let analyses = analyse(hits, options)?;
    let pairs: Vec<_> = pairs(hits).into_iter().collect();
    let functions: Vec<Result<_, FrfError>> = pairs
        .par_iter()
        .map(|(pair, members)| {
            Pair {
                pair,
                members,
                hits,
                analyses: &analyses,
            }
            .function(options)
        })
        .collect();
    let mut set = FrfSet::new(hits[0].axis.spectrum_axis());
    set.added_damping_rad_s = options.exponential.map_or(0.0, |w| w.decay_rad_s);
    set.record_duration_s = Some(hits[0].axis.duration_s());
    set.valid_band = band_of(&analyses, &hits[0].axis).ok();
    set.excited_band = excited_band_of(&analyses, &hits[0].axis).ok();
    for function in functions {
        let (function, data, finding) = function?;
        set.push(function, data)?;
        set.findings.extend(finding);
    }
    let single = pairs.iter().filter(|(_, members)| members.len() == 1);
    set.findings.extend(coherence_absent(single.count()));
    set.findings.extend(force_window_cuts(&analyses));
    let low = low_coherence(&set);
    set.findings.extend(low);
    set.findings
        .push(truncation_finding(&bounds(&pairs, &analyses)));
    Ok(set)
}

/// What each record says of the truncation error of its function: see [`Truncation`].
///
/// # Errors
/// As [`estimate`], except those of single lines.
pub fn truncation_bounds(
    hits: &[Hit],
    options: &EstimateOptions,
) -> Result<BTreeMap<(Dof, Dof), Truncation>, FrfError> {
    check(hits, options)?;
    let pairs: Vec<_> = pairs(hits).into_iter().collect();
    Ok(bounds(&pairs, &analyse(hits, options)?))
}

/// What is kept of one hit: its spectra, and of each channel the noise energy and the fall of the energy.
pub(super) struct HitAnalysis {
    pub spectra: HitSpectra,
    force_cut: Option<f64>,
    force_noise: Option<f64>,
    response_noise: Vec<Option<f64>>,
    quarters: Vec<Option<QuarterEnergies>>,
}

/// Conditions and transforms every hit once, on all threads; the first bad hit in order is the error.
pub(super) fn analyse(
    hits: &[Hit],
    options: &EstimateOptions,
) -> Result<Vec<HitAnalysis>, FrfError> {
    let plan = ForwardPlan::new(hits[0].axis.len);
    let conditioning = options.conditioning();
    let analyses: Vec<Result<_, SignalError>> = hits
        .par_iter()
        .map_init(
            || plan.scratch(),
            |scratch, hit| {
                let hit = condition(hit, &conditioning)?;
                let responses = 0..hit.responses.len();
                Ok(HitAnalysis {
                    spectra: hit_spectra(&hit, &plan, scratch),
                    force_cut: hit.force_cut,
                    force_noise: noise_energy(&hit.force, &hit.force_weights),
                    response_noise: hit
                        .responses
                        .iter()
                        .map(|channel| noise_energy(channel, &hit.response_weights))
                        .collect(),
                    quarters: responses.map(|r| QuarterEnergies::of(&hit, r)).collect(),
                })
            },
        )
        .collect();
    Ok(analyses.into_iter().collect::<Result<_, _>>()?)
}

/// Median coherence over the valid band below which a set says so.
const LOW_COHERENCE: f64 = 0.9;

/// One finding for the function of lowest median coherence over the valid band.
fn low_coherence(set: &FrfSet) -> Option<Finding> {
    let lines = set.axis().lines(&set.valid_band?);
    let median = |index: usize| {
        let mut values = set.coherence(index)?[lines.clone()].to_vec();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied()
    };
    let medians = (0..set.len()).filter_map(|index| Some((index, median(index)?)));
    let (index, worst) = medians.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let function = &set.functions()[index];
    let place = Place::Function {
        response: Some(function.response.clone()),
        reference: Some(function.reference.clone()),
    };
    let finding = Finding::new(Severity::Warning, Code::LowCoherence, place);
    (worst < LOW_COHERENCE).then(|| finding.value(worst, "").limit(LOW_COHERENCE))
}

/// Largest part of the force that its window may cut off.
const MOST_CUT: f64 = 0.01;

/// One finding for the hit of which the force window cuts off most.
fn force_window_cuts(analyses: &[HitAnalysis]) -> Option<Finding> {
    let cuts = analyses
        .iter()
        .enumerate()
        .filter_map(|(index, hit)| Some((index, hit.force_cut?)));
    let (index, cut) = cuts.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let finding = Finding::new(
        Severity::Warning,
        Code::ForceWindowCuts,
        Place::Hit(index + 1),
    );
    (cut > MOST_CUT).then(|| finding.value(cut, "").limit(MOST_CUT))
}

/// Expected energy of a channel's noise under its window: per line of the spectrum, that is its power too.
fn noise_energy(channel: &ConditionedChannel, weights: &[f64]) -> Option<f64> {
    let window: f64 = weights.iter().map(|w| w * w).sum();
    channel.pre_trigger.map(|quiet| quiet.variance * window)
}

/// Hit and response numbers of every (response, reference) pair.
type Members = Vec<(usize, usize)>;

fn pairs(hits: &[Hit]) -> BTreeMap<(Dof, Dof), Members> {
    let mut pairs: BTreeMap<(Dof, Dof), Members> = BTreeMap::new();
    for (h, hit) in hits.iter().enumerate() {
        for (r, response) in hit.responses.iter().enumerate() {
            let pair = (response.dof.clone(), hit.force.dof.clone());
            pairs.entry(pair).or_default().push((h, r));
        }
    }
    pairs
}

fn bounds(
    pairs: &[((Dof, Dof), Members)],
    analyses: &[HitAnalysis],
) -> BTreeMap<(Dof, Dof), Truncation> {
    let of = |members: &Members| {
        let quarters = members.iter().map(|(h, r)| analyses[*h].quarters[*r]);
        QuarterEnergies::sum(quarters).map_or(Truncation::NOT_DECIDABLE, |e| e.truncation())
    };
    pairs
        .iter()
        .map(|(pair, members)| (pair.clone(), of(members)))
        .collect()
}

/// One pair with what its hits gave.
struct Pair<'a> {
    pair: &'a (Dof, Dof),
    members: &'a Members,
    hits: &'a [Hit],
    analyses: &'a [HitAnalysis],
}

impl Pair<'_> {
    fn function(
        &self,
        options: &EstimateOptions,
    ) -> Result<(Function, FunctionData, Option<Finding>), FrfError> {
        let (kappa, finding) = self.noise_ratio(options)?;
        let sums = self.sums();
        let estimate = |(line, sums): (usize, &LineSums)| {
            sums.estimate(options.estimator, kappa)
                .map_err(|error| self.line_error(error, line, options.estimator))
        };
        let values: Vec<Complex64> = sums
            .iter()
            .enumerate()
            .map(estimate)
            .collect::<Result<_, _>>()?;
        let n = self.members.len();
        let (h, r) = self.members[0];
        let function = Function {
            response: self.pair.0.clone(),
            reference: self.pair.1.clone(),
            kind: response_kind(&self.hits[h], r)?,
            averages: u32::try_from(n).ok(),
            estimator: Some(options.estimator),
        };
        let data = FunctionData {
            coherence: (n > 1).then(|| sums.iter().map(coherence).collect()),
            variance: sums
                .iter()
                .zip(&values)
                .map(|(sums, value)| variance(sums, *value, n))
                .collect(),
            values,
        };
        Ok((function, data, finding))
    }

    fn sums(&self) -> Vec<LineSums> {
        let lines = self.analyses[0].spectra.force.len();
        let mut sums = vec![LineSums::default(); lines];
        for &(h, r) in self.members {
            let HitSpectra { force, responses } = &self.analyses[h].spectra;
            let lines = force.iter().zip(&responses[r]);
            sums.iter_mut()
                .zip(lines)
                .for_each(|(sum, (f, x))| sum.add(*f, *x));
        }
        sums
    }

    /// The ratio of Hv with the finding that says where it came from; 0 and nothing for H1 and H2, which do not use it.
    fn noise_ratio(&self, options: &EstimateOptions) -> Result<(f64, Option<Finding>), FrfError> {
        match (options.estimator, options.noise_ratio) {
            (Estimator::H1 | Estimator::H2, _) => return Ok((0.0, None)),
            (Estimator::Hv, Some(stated)) => return Ok((stated, None)),
            (Estimator::Hv, None) => {}
        }
        let of = |&(h, r): &(usize, usize)| self.analyses[h].response_noise[r];
        let response_noise = mean(self.members.iter().filter_map(of));
        let force = self
            .members
            .iter()
            .map(|(h, _)| self.analyses[*h].force_noise);
        let force_noise = mean(force.flatten());
        let (response, reference) = self.pair.clone();
        let ratio = response_noise.zip(force_noise).map(|(x, f)| x / f);
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
                response_noise,
                force_noise,
            }),
        }
    }

    fn line_error(&self, error: LineError, line: usize, estimator: Estimator) -> FrfError {
        let (response, reference) = self.pair.clone();
        let frequency_hz = self.hits[0].axis.spectrum_axis().hz(line);
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

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let values: Vec<f64> = values.collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn coherence_absent(functions: usize) -> Option<Finding> {
    (functions > 0).then(|| {
        Finding::new(Severity::Warning, Code::CoherenceAbsent, Place::Whole)
            .value(functions as f64, "functions")
    })
}

fn response_kind(hit: &Hit, response: usize) -> Result<FrfKind, FrfError> {
    let channel = &hit.responses[response];
    FrfKind::from_response(channel.quantity).ok_or_else(|| FrfError::NotAResponse {
        origin: hit.origin.clone(),
        dof: channel.dof.clone(),
        got: channel.quantity,
    })
}

/// All argument checks of this stage that need more than one hit.
pub(super) fn check(hits: &[Hit], options: &EstimateOptions) -> Result<(), FrfError> {
    options.validate()?;
    let first = hits.first().ok_or(FrfError::NoHits)?;
    let mut quantities = BTreeMap::new();
    for hit in hits {
        check_axis(hit, first)?;
        if hit.force.quantity != Quantity::Force {
            return Err(FrfError::NotAForce {
                origin: hit.origin.clone(),
                dof: hit.force.dof.clone(),
                got: hit.force.quantity,
            });
        }
        if hit.responses.is_empty() {
            return Err(FrfError::NoResponse {
                origin: hit.origin.clone(),
            });
        }
        check_responses(hit, &mut quantities)?;
    }
    Ok(())
}

/// One axis for all: as many samples, and steps that differ by less than a thousandth of a sample over the record.
fn check_axis(hit: &Hit, first: &Hit) -> Result<(), FrfError> {
    let drift = (hit.axis.step_s - first.axis.step_s).abs() * hit.axis.len as f64;
    // A step that is not a number does not differ here: the signal stage tells it.
    let differs = drift > 1e-3 * first.axis.step_s.abs();
    if hit.axis.len == first.axis.len && !differs {
        return Ok(());
    }
    Err(FrfError::AxisMismatch {
        origin: hit.origin.clone(),
        got_len: hit.axis.len,
        got_step_s: hit.axis.step_s,
        expected_len: first.axis.len,
        expected_step_s: first.axis.step_s,
        first: first.origin.clone(),
    })
}

fn check_responses<'a>(
    hit: &'a Hit,
    quantities: &mut BTreeMap<&'a Dof, Quantity>,
) -> Result<(), FrfError> {
    let mut seen = BTreeSet::new();
    for (r, channel) in hit.responses.iter().enumerate() {
        response_kind(hit, r)?;
        let (origin, dof) = (hit.origin.clone(), channel.dof.clone());
        if !seen.insert(&channel.dof) {
            return Err(FrfError::DuplicateResponse { origin, dof });
        }
        let expected = *quantities.entry(&channel.dof).or_insert(channel.quantity);
        if expected != channel.quantity {
            return Err(FrfError::QuantityMismatch {
                origin,
                dof,
                got: channel.quantity,
                expected,
            });
        }
    }
    Ok(())
}
