//! The samples of one channel get these faults after the filter, in this order: noise, offset,
//! quantisation.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// White Gaussian noise of each channel as a signal-to-noise ratio; `None` is a clean channel.
///
/// The rms of the noise is that of the clean signal divided by `10^(dB/20)`. A silent channel stays
/// silent.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Noise {
    /// Force: peak of the clean record over rms of the noise, dB.
    pub force_snr_db: Option<f64>,
    /// Response: rms of the clean record over rms of the noise, dB.
    pub response_snr_db: Option<f64>,
}

/// Constants added to every sample of a channel, in SI units.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Offsets {
    /// Added to the force, N.
    pub force_n: f64,
    /// Added to every response: m, m/s or m/s².
    pub response: f64,
}

/// A converter of `2^bits` codes from -full scale up to one step below +full scale; what lies
/// outside is clipped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantisation {
    /// Bits of the converter, 2 to 32.
    pub bits: u32,
    /// Full scale of the force, N.
    pub force_full_scale_n: f64,
    /// Full scale of every response: m, m/s or m/s².
    pub response_full_scale: f64,
}

/// The converter of one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Converter {
    pub bits: u32,
    pub full_scale: f64,
}

impl Converter {
    /// Value of one step, `2 full scale / 2^bits`.
    pub fn step(&self) -> f64 {
        self.full_scale / 2f64.powi(self.bits as i32 - 1)
    }

    fn convert(&self, value: f64) -> f64 {
        let codes = 2f64.powi(self.bits as i32 - 1);
        (value / self.step()).round().clamp(-codes, codes - 1.0) * self.step()
    }
}

/// The faults of the samples of one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ChannelFaults {
    /// Rms of the noise, in the unit of the samples; 0 for none.
    pub noise_rms: f64,
    pub offset: f64,
    pub converter: Option<Converter>,
}

impl ChannelFaults {
    pub fn apply(&self, samples: &mut [f64], random: &mut ChaCha8Rng) {
        for sample in samples {
            if self.noise_rms > 0.0 {
                let normal: f64 = random.sample(StandardNormal);
                *sample += self.noise_rms * normal;
            }
            *sample += self.offset;
            if let Some(converter) = &self.converter {
                *sample = converter.convert(*sample);
            }
        }
    }
}

/// Rms of the noise for a level of the signal and a ratio in dB; 0 when there is none.
pub(super) fn noise_rms(level: f64, snr_db: Option<f64>) -> f64 {
    snr_db.map_or(0.0, |db| level / 10f64.powf(db / 20.0))
}

/// Largest magnitude.
pub(super) fn peak(samples: &[f64]) -> f64 {
    samples.iter().fold(0.0, |largest, v| largest.max(v.abs()))
}

/// Root mean square over all samples; 0 for none.
pub(super) fn rms(samples: &[f64]) -> f64 {
    let sum: f64 = samples.iter().map(|v| v * v).sum();
    (sum / samples.len().max(1) as f64).sqrt()
}
