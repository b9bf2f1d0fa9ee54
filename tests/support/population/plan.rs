//! A drawn structure becomes a hammer test: which modes, which points, how long and how fast it is
//! recorded.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;

use modalign::dof::Dof;
use modalign::modal::{ModalModel, Mode, ModeShape, Scaling};
use modalign::quantity::Quantity;
use modalign::synth::{
    Faults, HammerTest, LowPassOptions, Noise, Pulse, SynthError, Truth, roving_hammer,
};

use super::error::PopulationError;
use super::span::{Ends, KeyedSpan, MAX_COUNT, Span};
use super::structure::{DrawnMode, MAX_MODES, Shapes, Structure};

/// Records are a multiple of this many samples, so that their length has small factors.
const SAMPLE_STEP: usize = 256;

/// `[test]`: how every structure is tested.
///
/// Every point is hit as often as `averages` says while all responses are recorded as acceleration;
/// the references are response points too, so that each has its driving point.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TestSpec {
    /// Number of elastic roots, from the lowest; fewer where a structure has fewer or the record
    /// would be too long.
    pub modes: Span,
    /// Number of hit points.
    pub references: Span,
    /// Number of response points; fewer where a structure has fewer.
    pub responses: Span,
    /// Hits at each point.
    pub averages: Span,
    /// Peak of the force over the rms of its noise, dB, uniform; left out, the force is clean.
    pub force_snr_db: Option<Span>,
    /// Rms of each response over the record over the rms of its noise, dB, uniform; left out,
    /// responses are clean.
    pub response_snr_db: Option<Span>,
    /// Record after the pre-trigger in time constants of the slowest mode, uniform.
    pub time_constants: Span,
    /// Part of the record that lies before the hit, uniform.
    pub pretrigger_share: Span,
    /// Highest mode over 0.4 of the sampling rate, uniform.
    pub highest_over_edge: Span,
    /// Highest mode times the contact time, uniform: 1.25 puts it 17 dB under the spectrum of the
    /// force at 0 Hz.
    pub highest_times_contact: Span,
    /// Most samples of a record.
    pub most_samples: usize,
}

impl TestSpec {
    pub(super) fn spans(&self) -> Vec<KeyedSpan> {
        let snr = [
            ("force_snr_db", self.force_snr_db),
            ("response_snr_db", self.response_snr_db),
        ];
        let snr = snr
            .into_iter()
            .filter_map(|(key, span)| Some((key, span?, Ends::Finite)));
        let most = Span::from([self.most_samples as f64; 2]);
        let mut stated = vec![
            ("modes", self.modes, Ends::Whole(1, MAX_COUNT)),
            ("modes", self.modes, Ends::Between(1.0, MAX_MODES as f64)),
            ("references", self.references, Ends::Whole(1, MAX_COUNT)),
            ("responses", self.responses, Ends::Whole(1, MAX_COUNT)),
            ("averages", self.averages, Ends::Whole(1, MAX_COUNT)),
            ("time_constants", self.time_constants, Ends::Positive),
            (
                "pretrigger_share",
                self.pretrigger_share,
                Ends::Between(0.0, 0.5),
            ),
            ("highest_over_edge", self.highest_over_edge, Ends::Share),
            (
                "highest_times_contact",
                self.highest_times_contact,
                Ends::Positive,
            ),
            ("most_samples", most, Ends::Whole(SAMPLE_STEP, 1_000_000)),
        ];
        stated.extend(snr);
        stated
    }

    /// The test of a structure.
    ///
    /// # Errors
    /// [`PopulationError::RecordTooLong`], and those of [`HammerTest::validate`].
    pub(super) fn plan(
        &self,
        structure: &Structure,
        random: &mut ChaCha8Rng,
    ) -> Result<(HammerTest, Vec<DrawnMode>), PopulationError> {
        let record = self.record(random);
        let wanted = self.modes.whole(random);
        let modes = record.fitting(&structure.modes, wanted, self.most_samples)?;
        let hits = self.references.whole(random);
        let places = self.places(structure, hits, random);
        let responses: Vec<Dof> = places.responses.iter().map(|&i| dof(i)).collect();
        let hits: Vec<Dof> = places.hits.iter().map(|&i| dof(i)).collect();
        let highest_hz = highest_hz(&modes);
        let sampling_rate_hz = record.sampling_rate_hz(highest_hz);
        let samples = record.samples(&modes);
        let noise = Noise {
            force_snr_db: self.force_snr_db.map(|span| span.uniform(random)),
            response_snr_db: self.response_snr_db.map(|span| span.uniform(random)),
        };
        let test = HammerTest {
            truth: truth(&modes, structure.shapes, &places)?,
            hits: roving_hammer(&hits, &responses),
            averages_per_point: self.averages.whole(random),
            sampling_rate_hz,
            samples,
            pretrigger_s: record.pretrigger_share * samples as f64 / sampling_rate_hz,
            quantity: Quantity::Acceleration,
            pulse: Pulse {
                peak_n: 100.0,
                peak_spread: 0.3,
                duration_s: self.highest_times_contact.uniform(random) / highest_hz,
                duration_spread: 0.1,
            },
            filter: LowPassOptions::default(),
            noise,
            faults: Faults::default(),
            seed: random.random(),
        };
        test.validate()?;
        Ok((test, modes))
    }

    fn record(&self, random: &mut ChaCha8Rng) -> Record {
        Record {
            time_constants: self.time_constants.uniform(random),
            pretrigger_share: self.pretrigger_share.uniform(random),
            highest_over_edge: self.highest_over_edge.uniform(random),
        }
    }

    /// Responses spread over the structure, one from each of as many equal stretches of its points;
    /// hits among them.
    fn places(&self, structure: &Structure, hits: usize, random: &mut ChaCha8Rng) -> Places {
        let points = structure.points();
        let count = self.responses.whole(random).min(points);
        let mut responses: Vec<usize> = (0..count)
            .map(|k| random.random_range(k * points / count..(k + 1) * points / count))
            .collect();
        if let Some(reference) = structure.reference {
            let stretch = responses.iter().rposition(|&i| i <= reference).unwrap_or(0);
            responses[stretch] = reference;
        }
        let mut free: Vec<usize> = responses.clone();
        free.retain(|&i| structure.reference != Some(i));
        let mut chosen: Vec<usize> = structure.reference.into_iter().collect();
        while chosen.len() < hits && !free.is_empty() {
            chosen.push(free.swap_remove(random.random_range(0..free.len())));
        }
        Places {
            responses,
            hits: chosen,
        }
    }
}

/// Points by number, from 0.
struct Places {
    responses: Vec<usize>,
    hits: Vec<usize>,
}

struct Record {
    time_constants: f64,
    pretrigger_share: f64,
    highest_over_edge: f64,
}

impl Record {
    /// The rate at which the highest mode lies at its share of 0.4 of it.
    fn sampling_rate_hz(&self, highest_hz: f64) -> f64 {
        highest_hz / (0.4 * self.highest_over_edge)
    }

    fn samples(&self, modes: &[DrawnMode]) -> usize {
        let decay = |mode: &DrawnMode| Some(TAU * mode.frequency_hz * mode.damping_ratio?);
        let slowest = modes.iter().filter_map(decay).fold(f64::INFINITY, f64::min);
        let record_s = self.time_constants / slowest / (1.0 - self.pretrigger_share);
        let samples = record_s * self.sampling_rate_hz(highest_hz(modes));
        // Longer than any record may be, and far from overflow.
        let steps = (samples / SAMPLE_STEP as f64).ceil().min(1e12);
        steps as usize * SAMPLE_STEP
    }

    /// The rigid-body modes and the lowest elastic roots, at most as many as wanted, whose record
    /// is short enough.
    fn fitting(
        &self,
        modes: &[DrawnMode],
        wanted: usize,
        most_samples: usize,
    ) -> Result<Vec<DrawnMode>, PopulationError> {
        let mut sorted = modes.to_vec();
        sorted.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        let same = |a: &DrawnMode, b: &DrawnMode| {
            a.group.is_some() && a.group == b.group || a.pair.is_some() && a.pair == b.pair
        };
        let rigid = sorted.partition_point(|mode| mode.damping_ratio.is_none());
        let mut roots: Vec<&[DrawnMode]> = sorted[rigid..].chunk_by(same).collect();
        roots.truncate(wanted);
        loop {
            let kept: Vec<DrawnMode> = [&sorted[..rigid]]
                .into_iter()
                .chain(roots.iter().copied())
                .flatten()
                .cloned()
                .collect();
            let got = self.samples(&kept);
            if got <= most_samples && !roots.is_empty() {
                return Ok(kept);
            }
            if roots.len() <= 1 {
                return Err(PopulationError::RecordTooLong {
                    got,
                    expected: most_samples,
                });
            }
            roots.pop();
        }
    }
}

fn highest_hz(modes: &[DrawnMode]) -> f64 {
    modes
        .iter()
        .map(|mode| mode.frequency_hz)
        .fold(0.0, f64::max)
}

/// The degree of freedom of a point.
pub(super) fn dof(point: usize) -> Dof {
    Dof::from_node(point as i64 + 1, 3).expect("a number above 0 is a point")
}

fn truth(modes: &[DrawnMode], shapes: Shapes, places: &Places) -> Result<Truth, SynthError> {
    let model = ModalModel {
        modes: modes
            .iter()
            .map(|mode| at_places(mode, shapes, places))
            .collect(),
        ..ModalModel::default()
    };
    let dofs = |points: &[usize]| points.iter().map(|&i| dof(i)).collect::<Vec<_>>();
    match shapes {
        Shapes::Real => {
            Truth::from_real_shapes(&model, &dofs(&places.responses), &dofs(&places.hits))
        }
        Shapes::Complex => Ok(Truth {
            model,
            rigid_accelerance: BTreeMap::new(),
        }),
    }
}

fn at_places(drawn: &DrawnMode, shapes: Shapes, places: &Places) -> Mode {
    let all = places.responses.iter().chain(&places.hits);
    let shape = ModeShape::new(all.map(|&i| (dof(i), drawn.shape[i])));
    let scaling = match shapes {
        Shapes::Real => Scaling::UnitModalMass,
        Shapes::Complex => Scaling::Unknown,
    };
    let mut mode = Mode {
        group: drawn.group,
        ..Mode::new(drawn.frequency_hz, drawn.damping_ratio, shape, scaling)
    };
    if shapes == Shapes::Complex {
        for (&r, &h) in places
            .responses
            .iter()
            .flat_map(|r| places.hits.iter().map(move |h| (r, h)))
        {
            mode.residues
                .insert((dof(r), dof(h)), drawn.shape[r] * drawn.shape[h]);
        }
    }
    mode
}
