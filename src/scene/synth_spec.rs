//! The spec of a synthetic hammer test as typed, and the test it means.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use crate::dof::Dof;

use super::typed::{ModelTable, SensorTable};

/// The schema text of a spec.
pub const SYNTH_SCHEMA: &str = "modalign-synth/1";

/// A synthetic hammer test as typed.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SynthFile {
    /// `modalign-synth/1`.
    pub schema: String,
    /// Title, written into the recording.
    pub title: String,
    /// Seed of everything drawn.
    pub seed: u64,
    /// The machine that is recorded.
    pub truth: TruthTable,
    /// Sensors and hits on the truth's bodies.
    #[serde(default)]
    pub sensor: Vec<SensorTable>,
    /// Sampling.
    pub record: RecordTable,
    /// The hammer's pulse.
    pub pulse: PulseTable,
    /// The anti-alias filter.
    #[serde(default)]
    pub filter: FilterTable,
    /// Noise; clean when left out.
    #[serde(default)]
    pub noise: NoiseTable,
    /// Hits at each point.
    pub averages: usize,
    /// Which points are hit and which respond.
    pub hit: Vec<HitTable>,
}

/// `[truth]`: a model with changed parameters and, where stated, other frequencies; or finished
/// modes.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TruthTable {
    /// A built-in model.
    pub name: Option<String>,
    /// A `model.toml`, relative to the spec.
    pub file: Option<String>,
    /// Parameter values that differ from the nominal ones.
    #[serde(default)]
    pub parameters: BTreeMap<String, f64>,
    /// A `modes.json` with damping and residues, relative to the spec, instead of a model.
    pub modes: Option<String>,
    /// Damping ratio of every elastic mode of a model.
    pub damping_ratio: Option<f64>,
    /// Highest mode of a model that takes part, Hz; every mode when not stated.
    pub highest_hz: Option<f64>,
    /// Roots of a model that are there, at stated frequencies; every root at that of the model when
    /// none is stated.
    #[serde(default)]
    pub mode: Vec<TruthModeTable>,
}

/// `[[truth.mode]]`: a root of the model at another frequency.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TruthModeTable {
    /// Number of the root among the elastic roots of the model, from 1; a repeated root counts
    /// once.
    pub root: usize,
    /// Its frequency in the recording, Hz.
    pub frequency_hz: f64,
    /// Shape at the sensors and hits for unit modal mass (1 kg), instead of that of the model: one
    /// mode, whatever the multiplicity of the root.
    #[serde(default)]
    pub shape: BTreeMap<Dof, f64>,
}

impl TruthTable {
    /// The model and, after a colon, what was changed in it.
    pub fn source(&self) -> String {
        let model = [&self.modes, &self.file, &self.name].into_iter().flatten();
        let model = model.map(String::as_str).next().unwrap_or("a model");
        let names = self.parameters.keys().map(String::as_str);
        let frequencies = (!self.mode.is_empty()).then_some("natural frequencies");
        let changed: Vec<&str> = names.chain(frequencies).collect();
        match changed.is_empty() {
            true => model.to_owned(),
            false => format!("{model}: {} changed", changed.join(", ")),
        }
    }

    /// The model part, as a scene would state it.
    pub fn model(&self) -> ModelTable {
        ModelTable {
            name: self.name.clone(),
            file: self.file.clone(),
            parameters: self.parameters.clone(),
            partial: false,
            added: None,
        }
    }
}

/// `[record]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordTable {
    /// Samples per second.
    pub sampling_rate_hz: f64,
    /// Samples per record.
    pub samples: usize,
    /// Time before the hit, s.
    pub pretrigger_s: f64,
    /// `acceleration`, `velocity` or `displacement`.
    pub response: String,
    /// `single` (default, as measurement systems export) or `double` precision in the file.
    pub precision: Option<String>,
}

/// `[pulse]`: a half sine.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PulseTable {
    /// Duration, s.
    pub duration_s: f64,
    /// Relative standard deviation of the duration from hit to hit.
    #[serde(default)]
    pub duration_spread: f64,
    /// Peak force, N.
    pub peak_n: f64,
    /// Relative standard deviation of the peak from hit to hit.
    #[serde(default)]
    pub peak_spread: f64,
}

/// `[filter]`: Chebyshev type I low-pass, the same on every channel.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FilterTable {
    /// Even order.
    pub order: Option<usize>,
    /// Passband ripple, dB.
    pub ripple_db: Option<f64>,
    /// Passband edge as a fraction of the sampling rate.
    pub edge: Option<f64>,
}

/// `[noise]`: white, by signal-to-noise ratio; a channel without one is clean.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseTable {
    /// Peak force over rms noise, dB.
    pub force_snr_db: Option<f64>,
    /// Rms response over rms noise, dB.
    pub response_snr_db: Option<f64>,
}

/// `[[hit]]`: every point of `dofs` is hit while `responses` are recorded.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HitTable {
    /// Hit points.
    pub dofs: Vec<Dof>,
    /// Responses recorded together.
    pub responses: Vec<Dof>,
}

/// The folder that relative paths in a file refer to.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new("."))
}
