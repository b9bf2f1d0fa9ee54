//! The test plan states excitation points, responses, averages and channels; every argument is
//! checked.

use std::collections::BTreeSet;

use crate::dof::Dof;
use crate::quantity::{FrfKind, Quantity};

use super::SynthError;
use super::channel::{Noise, Offsets, Quantisation};
use super::filter::{LowPass, LowPassOptions};
use super::pulse::Pulse;
use super::truth::{TrueFrf, Truth, checked_pole};

/// A pole of the structure nearer than this to one of the filter, relative to the latter, is
/// refused: the two partial fractions grow like the inverse distance and cancel, and would leave
/// fewer than 12 digits.
const MIN_RELATIVE_POLE_DISTANCE: f64 = 1e-4;

/// Largest number of samples of a test, which are all in memory.
const MAX_TEST_SAMPLES: f64 = 1e9;

/// One hit point with the responses that are sampled with it.
#[derive(Clone, Debug, PartialEq)]
pub struct HitPlan {
    /// Where the hammer hits; the sign is the direction of the push, which the force channel
    /// records as positive.
    pub hit: Dof,
    /// The responses, in the order of the channels.
    pub responses: Vec<Dof>,
}

/// The plan of a roving hammer: every point is hit, the same sensors measure.
pub fn roving_hammer(hits: &[Dof], responses: &[Dof]) -> Vec<HitPlan> {
    let plan = |hit: &Dof| HitPlan {
        hit: hit.clone(),
        responses: responses.to_vec(),
    };
    hits.iter().map(plan).collect()
}

/// The plan of a roving accelerometer: one point is hit, the sensors move from set to set.
pub fn roving_accelerometer(hit: &Dof, sets: &[Vec<Dof>]) -> Vec<HitPlan> {
    let plan = |responses: &Vec<Dof>| HitPlan {
        hit: hit.clone(),
        responses: responses.clone(),
    };
    sets.iter().map(plan).collect()
}

/// A second contact of the hammer (double hit): the pulse again, later and smaller.
#[derive(Clone, Debug, PartialEq)]
pub struct SecondContact {
    /// From the start of the first contact to the start of the second, s.
    pub delay_s: f64,
    /// Peak of the second over peak of the first, above 0.
    pub ratio: f64,
    /// Which hits of the test have it, from 0 in generation order.
    pub hits: BTreeSet<usize>,
}

/// The faults of a test; the default is none.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Faults {
    /// Constants on the channels.
    pub offsets: Offsets,
    /// Double hits.
    pub second_contact: Option<SecondContact>,
    /// A converter with few bits or a full scale that clips.
    pub quantisation: Option<Quantisation>,
}

/// A synthetic hammer test as stated. Nothing physical has a default.
///
/// Hit `i` (from 0) is average `i % averages_per_point` of plan entry `i / averages_per_point`. The
/// record starts at time 0 and the pulse begins inside the sample interval after `pretrigger_s`.
/// Random numbers are drawn from a separate generator for each (seed, plan entry, average,
/// channel), so that a sample depends neither on the number of threads nor on what else is
/// generated.
#[derive(Clone, Debug, PartialEq)]
pub struct HammerTest {
    /// Truth of the structure.
    pub truth: Truth,
    /// Hit points in order, see [`roving_hammer`] and [`roving_accelerometer`].
    pub hits: Vec<HitPlan>,
    /// Hits at each point, 1 or more.
    pub averages_per_point: usize,
    /// Samples per second.
    pub sampling_rate_hz: f64,
    /// Samples of a record.
    pub samples: usize,
    /// Time before the hit in every record, s.
    pub pretrigger_s: f64,
    /// The quantity of the response channels.
    pub quantity: Quantity,
    /// The hammer.
    pub pulse: Pulse,
    /// The anti-alias filter of all channels.
    pub filter: LowPassOptions,
    /// Noise after the filter.
    pub noise: Noise,
    /// Faults after the noise (the second contact is a true force and comes before the filter).
    pub faults: Faults,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// A plan that has been checked, with what the checks found on the way.
pub(super) struct Checked {
    pub kind: FrfKind,
    pub filter: LowPass,
    /// By plan entry, then response.
    pub pairs: Vec<Vec<TrueFrf>>,
}

struct Range {
    name: &'static str,
    got: f64,
    inside: bool,
    expected: &'static str,
    unit: &'static str,
}

impl HammerTest {
    /// Number of hits, points times averages.
    pub fn hit_count(&self) -> usize {
        self.hits.len() * self.averages_per_point
    }

    /// Record length, s.
    pub fn record_s(&self) -> f64 {
        self.samples as f64 / self.sampling_rate_hz
    }

    /// Samples of all channels of all hits.
    fn total_samples(&self) -> f64 {
        let channels: usize = self.hits.iter().map(|plan| 1 + plan.responses.len()).sum();
        channels as f64 * self.averages_per_point as f64 * self.samples as f64
    }

    /// Checks every argument.
    ///
    /// # Errors
    /// [`SynthError`]: a number outside its range, an empty plan, a pair or mode that the truth
    /// does not hold, a force that may last beyond the record, a filter below the lowest mode or
    /// with a pole on one of the structure's, a free body without acceleration.
    pub fn validate(&self) -> Result<(), SynthError> {
        self.check().map(|_| ())
    }

    pub(super) fn check(&self) -> Result<Checked, SynthError> {
        self.check_numbers()?;
        let filter = LowPass::new(&self.filter, self.sampling_rate_hz)?;
        self.check_force_fits()?;
        self.check_plan()?;
        let kind = self.check_truth(&filter)?;
        let pairs = self.hits.iter().map(|plan| {
            let responses = plan.responses.iter();
            responses.map(|r| self.truth.pair(r, &plan.hit)).collect()
        });
        Ok(Checked {
            kind,
            pairs: pairs.collect::<Result<_, _>>()?,
            filter,
        })
    }

    fn check_numbers(&self) -> Result<(), SynthError> {
        let mut ranges = self.stated_ranges();
        ranges.extend(self.noise_ranges());
        ranges.extend(self.fault_ranges());
        match ranges.into_iter().find(|range| !range.inside) {
            None => Ok(()),
            Some(range) => Err(SynthError::OutOfRange {
                name: range.name,
                got: range.got,
                expected: range.expected,
                unit: range.unit,
            }),
        }
    }

    fn stated_ranges(&self) -> Vec<Range> {
        let pulse = &self.pulse;
        vec![
            positive("sampling rate", self.sampling_rate_hz, "Hz"),
            Range {
                name: "samples of the whole test",
                got: self.total_samples(),
                inside: self.total_samples() <= MAX_TEST_SAMPLES,
                expected: "at most 1e9 (8 GB in memory)",
                unit: "",
            },
            Range {
                name: "samples of a record",
                got: self.samples as f64,
                inside: self.samples >= 2,
                expected: "2 or more",
                unit: "",
            },
            Range {
                name: "pre-trigger",
                got: self.pretrigger_s,
                inside: self.pretrigger_s >= 0.0 && self.pretrigger_s < self.record_s(),
                expected: "0 or more and below the record length",
                unit: "s",
            },
            positive("peak force", pulse.peak_n, "N"),
            spread("spread of the peak force", pulse.peak_spread),
            positive("contact time", pulse.duration_s, "s"),
            spread("spread of the contact time", pulse.duration_spread),
        ]
    }

    fn noise_ranges(&self) -> Vec<Range> {
        let ratio = |name, got: Option<f64>| {
            got.map(|db| Range {
                name,
                got: db,
                inside: db.abs() <= 400.0,
                expected: "-400 to 400",
                unit: "dB",
            })
        };
        let force = ratio(
            "signal-to-noise ratio of the force",
            self.noise.force_snr_db,
        );
        let response = ratio(
            "signal-to-noise ratio of the response",
            self.noise.response_snr_db,
        );
        force.into_iter().chain(response).collect()
    }

    fn fault_ranges(&self) -> Vec<Range> {
        let offsets = &self.faults.offsets;
        let unit = self.quantity.si_unit();
        let mut ranges = vec![
            finite("offset of the force", offsets.force_n, "N"),
            finite("offset of the response", offsets.response, unit),
        ];
        if let Some(second) = &self.faults.second_contact {
            ranges.push(positive("delay of the second contact", second.delay_s, "s"));
            ranges.push(positive(
                "peak ratio of the second contact",
                second.ratio,
                "",
            ));
        }
        if let Some(converter) = &self.faults.quantisation {
            let (force, response) = (converter.force_full_scale_n, converter.response_full_scale);
            ranges.push(positive("full scale of the force", force, "N"));
            ranges.push(positive("full scale of the response", response, unit));
            ranges.push(Range {
                name: "bits of the converter",
                got: f64::from(converter.bits),
                inside: (2..=32).contains(&converter.bits),
                expected: "2 to 32",
                unit: "",
            });
        }
        ranges
    }

    fn check_force_fits(&self) -> Result<(), SynthError> {
        let delay_s = self
            .faults
            .second_contact
            .as_ref()
            .map_or(0.0, |s| s.delay_s);
        let contact_s = self.pulse.duration_s * (1.0 + self.pulse.duration_spread);
        let got_s = self.pretrigger_s + 1.0 / self.sampling_rate_hz + delay_s + contact_s;
        let expected_s = self.record_s();
        if got_s > expected_s {
            return Err(SynthError::PulseOutsideRecord { got_s, expected_s });
        }
        Ok(())
    }

    fn check_plan(&self) -> Result<(), SynthError> {
        let empty = |what| Err(SynthError::EmptyPlan { what });
        if self.hits.is_empty() {
            return empty("hit points");
        }
        if self.averages_per_point == 0 {
            return empty("averages per point");
        }
        for plan in &self.hits {
            if plan.responses.is_empty() {
                return empty("responses of a hit");
            }
            let mut seen = BTreeSet::new();
            if let Some(response) = plan.responses.iter().find(|r| !seen.insert(*r)) {
                return Err(SynthError::DuplicateResponse {
                    hit: plan.hit.clone(),
                    response: response.clone(),
                });
            }
        }
        let second = self.faults.second_contact.as_ref();
        match second.and_then(|s| s.hits.last()) {
            Some(&got) if got >= self.hit_count() => Err(SynthError::HitIndex {
                got,
                expected: self.hit_count(),
            }),
            _ => Ok(()),
        }
    }

    fn check_truth(&self, filter: &LowPass) -> Result<FrfKind, SynthError> {
        let quantity = self.quantity;
        let kind = FrfKind::from_response(quantity).ok_or(SynthError::NotAResponse { quantity })?;
        let modes = &self.truth.model.modes;
        let free = !self.truth.rigid_accelerance.is_empty();
        if free && kind != FrfKind::Accelerance {
            return Err(SynthError::FreeBodyDrifts { quantity });
        }
        if modes.is_empty() && !free {
            return Err(SynthError::EmptyTruth);
        }
        let mut lowest_mode_hz = f64::INFINITY;
        for (i, mode) in modes.iter().enumerate() {
            let lambda = checked_pole(mode, i + 1)?;
            let distances = filter
                .poles_rad_s
                .iter()
                .map(|q| (lambda - q).norm() / q.norm());
            let got = distances.fold(f64::INFINITY, f64::min);
            if got < MIN_RELATIVE_POLE_DISTANCE {
                return Err(SynthError::PoleOnFilterPole {
                    mode: i + 1,
                    got,
                    expected: MIN_RELATIVE_POLE_DISTANCE,
                });
            }
            lowest_mode_hz = lowest_mode_hz.min(mode.frequency_hz);
        }
        // A free body is worth sampling even when all its modes lie above the filter.
        if !free && lowest_mode_hz >= filter.edge_hz {
            return Err(SynthError::SamplingTooLow {
                edge_hz: filter.edge_hz,
                lowest_mode_hz,
            });
        }
        Ok(kind)
    }
}

fn positive(name: &'static str, got: f64, unit: &'static str) -> Range {
    Range {
        name,
        got,
        inside: got > 0.0 && got.is_finite(),
        expected: "above 0",
        unit,
    }
}

fn finite(name: &'static str, got: f64, unit: &'static str) -> Range {
    Range {
        name,
        got,
        inside: got.is_finite(),
        expected: "a finite number",
        unit,
    }
}

fn spread(name: &'static str, got: f64) -> Range {
    Range {
        name,
        got,
        inside: (0.0..1.0).contains(&got),
        expected: "0 up to below 1",
        unit: "",
    }
}
