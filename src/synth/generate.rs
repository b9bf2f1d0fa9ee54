//! Hits are computed from a checked plan: the response in closed form, then noise and faults, with
//! separate random numbers for each channel.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::axis::TimeAxis;
use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::modal::ModalModel;
use crate::quantity::Quantity;
use crate::record::{Channel, Hit, Role, Samples};

use super::SynthError;
use super::cascade::{Term, add_pulse, force_terms, response_terms};
use super::channel::{ChannelFaults, Converter, noise_rms, peak, rms};
use super::filter::LowPass;
use super::plan::HammerTest;
use super::pulse::HalfSine;

/// Numbers the random generators of one hit.
#[derive(Clone, Copy)]
enum Stream {
    Pulse,
    Force,
    Response(usize),
}

impl HammerTest {
    /// All hits in order, on the caller's threads.
    ///
    /// # Errors
    /// Those of [`HammerTest::validate`].
    pub fn generate(&self) -> Result<Vec<Hit>, SynthError> {
        let cascades = Cascades::new(self)?;
        let hits = (0..self.hit_count()).into_par_iter();
        Ok(hits.map(|i| cascades.hit(self, i)).collect())
    }

    /// Hit `i` alone, the same samples as in [`HammerTest::generate`].
    ///
    /// # Errors
    /// Those of [`HammerTest::validate`]; [`SynthError::HitIndex`] beyond the plan.
    pub fn generate_hit(&self, i: usize) -> Result<Hit, SynthError> {
        self.check_index(i)?;
        Ok(Cascades::new(self)?.hit(self, i))
    }

    /// The pulses of hit `i` before the filter: one, or two for a double hit.
    ///
    /// # Errors
    /// Those of [`HammerTest::validate`]; [`SynthError::HitIndex`] beyond the plan.
    pub fn pulses(&self, i: usize) -> Result<Vec<HalfSine>, SynthError> {
        self.check_index(i)?;
        self.validate()?;
        Ok(self.draw_pulses(i))
    }

    /// The anti-alias filter of all channels.
    ///
    /// # Errors
    /// [`SynthError::OutOfRange`] for a filter option or the sampling rate.
    pub fn low_pass(&self) -> Result<LowPass, SynthError> {
        LowPass::new(&self.filter, self.sampling_rate_hz)
    }

    /// The elastic modes of the truth with the hit points as references and the finding that all of
    /// it is synthetic.
    pub fn truth_model(&self) -> ModalModel {
        let mut model = self.truth.model.clone();
        model.producer = format!("modalign {} synth", env!("CARGO_PKG_VERSION"));
        model.references = self.hits.iter().map(|plan| plan.hit.clone()).collect();
        model.references.sort();
        model.references.dedup();
        model
            .modes
            .sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        if !model.findings.iter().any(|f| f.code == Code::Synthetic) {
            let finding = Finding::new(Severity::Info, Code::Synthetic, Location::Whole);
            model.findings.push(finding);
        }
        model
    }

    fn check_index(&self, i: usize) -> Result<(), SynthError> {
        let expected = self.hit_count();
        if i < expected {
            return Ok(());
        }
        Err(SynthError::HitIndex { got: i, expected })
    }

    fn draw_pulses(&self, i: usize) -> Vec<HalfSine> {
        let step_s = 1.0 / self.sampling_rate_hz;
        let mut random = self.random(i, Stream::Pulse);
        let first = self.pulse.draw(self.pretrigger_s, step_s, &mut random);
        let second = self.faults.second_contact.as_ref();
        let again = second.filter(|s| s.hits.contains(&i)).map(|s| HalfSine {
            start_s: first.start_s + s.delay_s,
            peak_n: first.peak_n * s.ratio,
            ..first
        });
        std::iter::once(first).chain(again).collect()
    }

    /// The generator of one stream of one hit: its 256-bit key is (seed, plan entry, average,
    /// channel).
    fn random(&self, i: usize, stream: Stream) -> ChaCha8Rng {
        let channel = match stream {
            Stream::Pulse => 0,
            Stream::Force => 1,
            Stream::Response(k) => 2 + k as u64,
        };
        let entry = (i / self.averages_per_point) as u64;
        let average = (i % self.averages_per_point) as u64;
        let mut key = [0; 32];
        for (bytes, word) in key
            .chunks_exact_mut(8)
            .zip([self.seed, entry, average, channel])
        {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        ChaCha8Rng::from_seed(key)
    }

    fn force_faults(&self, clean: &[f64]) -> ChannelFaults {
        ChannelFaults {
            noise_rms: noise_rms(peak(clean), self.noise.force_snr_db),
            offset: self.faults.offsets.force_n,
            converter: self.faults.quantisation.map(|q| Converter {
                bits: q.bits,
                full_scale: q.force_full_scale_n,
            }),
        }
    }

    fn response_faults(&self, clean: &[f64]) -> ChannelFaults {
        ChannelFaults {
            noise_rms: noise_rms(rms(clean), self.noise.response_snr_db),
            offset: self.faults.offsets.response,
            converter: self.faults.quantisation.map(|q| Converter {
                bits: q.bits,
                full_scale: q.response_full_scale,
            }),
        }
    }
}

/// The partial fractions of every channel of a checked plan.
struct Cascades {
    force: Vec<Term>,
    /// By plan entry, then response.
    responses: Vec<Vec<Vec<Term>>>,
}

impl Cascades {
    fn new(test: &HammerTest) -> Result<Self, SynthError> {
        let checked = test.check()?;
        let terms = |pair| response_terms(&checked.filter, pair, checked.kind);
        let entries = checked.pairs.iter();
        Ok(Self {
            force: force_terms(&checked.filter),
            responses: entries
                .map(|pairs| pairs.iter().map(terms).collect())
                .collect(),
        })
    }

    fn hit(&self, test: &HammerTest, i: usize) -> Hit {
        let entry = i / test.averages_per_point;
        let plan = &test.hits[entry];
        let pulses = test.draw_pulses(i);
        let clean = |terms: &[Term]| {
            let mut samples = vec![0.0; test.samples];
            for pulse in &pulses {
                add_pulse(&mut samples, terms, pulse, test.sampling_rate_hz);
            }
            samples
        };
        let mut force = clean(&self.force);
        let faults = test.force_faults(&force);
        faults.apply(&mut force, &mut test.random(i, Stream::Force));
        let responses = plan.responses.iter().zip(&self.responses[entry]);
        let responses = responses.enumerate().map(|(k, (dof, terms))| {
            let mut samples = clean(terms);
            let faults = test.response_faults(&samples);
            faults.apply(&mut samples, &mut test.random(i, Stream::Response(k)));
            channel(Role::Response, dof, test.quantity, samples)
        });
        Hit {
            axis: TimeAxis {
                start_s: 0.0,
                step_s: 1.0 / test.sampling_rate_hz,
                len: test.samples,
            },
            responses: responses.collect(),
            force: channel(Role::Force, &plan.hit, Quantity::Force, force),
            origin: format!("synthetic hit {} (seed {})", i + 1, test.seed),
        }
    }
}

fn channel(role: Role, dof: &Dof, quantity: Quantity, samples: Vec<f64>) -> Channel {
    Channel {
        role,
        dof: dof.clone(),
        quantity,
        to_si: 1.0,
        samples: Samples::F64(samples),
    }
}
