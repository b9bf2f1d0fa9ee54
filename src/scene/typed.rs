//! `scene.toml` as typed: its tables and keys, with nothing decided yet.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;

use crate::correlate::PairOptions;
use crate::dof::Dof;
use crate::geometry::{Sensor, Target};

use super::limits::Limits;
use super::test_state::TestState;

/// The schema text of a scene.
pub const SCENE_SCHEMA: &str = "modalign-scene/1";

/// A whole scene.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// `modalign-scene/1`.
    pub schema: String,
    /// Title of the report.
    pub title: String,
    /// Tests, in the order of the table's columns.
    #[serde(default)]
    pub test: Vec<TestTable>,
    /// Sensors and hits on the model's bodies.
    #[serde(default)]
    pub sensor: Vec<SensorTable>,
    /// Positions of points that neither a file nor a sensor states.
    #[serde(default)]
    pub point: Vec<PointTable>,
    /// The theoretical model.
    pub model: Option<ModelTable>,
    /// Options of FRF estimation.
    #[serde(default)]
    pub frf: FrfTable,
    /// Options of identification.
    #[serde(default)]
    pub identify: IdentifyTable,
    /// Options of pairing.
    #[serde(default)]
    pub pair: PairOptions,
    /// Tests that more points are wanted for.
    #[serde(default)]
    pub placement: Vec<PlacementTable>,
    /// Options of updating.
    pub update: Option<UpdateTable>,
    /// States of the machine other than that of the model.
    #[serde(default)]
    pub configuration: Vec<ConfigurationTable>,
    /// Options of the report.
    #[serde(default)]
    pub report: ReportTable,
    /// Limits that decide the exit code.
    #[serde(default)]
    pub limits: Limits,
}

/// Points that a test could measure in addition.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlacementTable {
    /// Name of the test.
    pub test: String,
    /// Sensors of the scene that can be hit: degrees of freedom, or their beginning with a `*`.
    #[serde(default = "every_point")]
    pub hits: Vec<String>,
    /// Sensors of the scene that a test can put there.
    #[serde(default = "every_point")]
    pub sensors: Vec<String>,
    /// Largest AutoMAC between modes of different roots at the fewest sensors.
    #[serde(default = "customary_auto_mac")]
    pub max_auto_mac: f64,
}

/// The customary limit of an AutoMAC outside its diagonal.
fn customary_auto_mac() -> f64 {
    0.1
}

fn every_point() -> Vec<String> {
    vec!["*".to_owned()]
}

/// One test.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TestTable {
    /// Name, as in the table's head.
    pub name: String,
    /// Recordings or FRFs, relative to the scene.
    #[serde(default)]
    pub files: Vec<String>,
    /// A synthetic test's spec, relative to the scene.
    pub synth: Option<String>,
    /// Finished modes (`modes.json`), relative to the scene.
    pub modes: Option<String>,
    /// How hits are grouped: `records` (default), `files`, or `trigger` for continuous records.
    pub hits: Option<String>,
    /// Trigger that cuts hits from continuous records; estimated from the records where not stated.
    #[serde(default)]
    pub trigger: TriggerTable,
    /// Numbers, from 1, of hits that are used regardless of their checks.
    #[serde(default)]
    pub accept: BTreeSet<usize>,
    /// Numbers, from 1, of hits that are rejected regardless of their checks.
    #[serde(default)]
    pub reject: BTreeSet<usize>,
    /// Band of identification, `[lo, hi]` in Hz.
    pub band_hz: Option<[f64; 2]>,
    /// Support, loads and date of the test.
    #[serde(default)]
    pub state: TestState,
    /// Whether the good part of a partly bad file is used.
    #[serde(default)]
    pub partial: bool,
    /// Samples per second, for tables without a time column.
    pub sampling_rate_hz: Option<f64>,
    /// `comma`, `semicolon`, `tab` or `blank`, for tables; judged by the content when not stated.
    pub delimiter: Option<String>,
    /// Meaning of the dimensions of an array, slowest first: `hit`, `channel`, `sample`; rows are
    /// samples and columns are channels when not stated.
    pub dimensions: Option<Vec<String>>,
    /// Number of averages of FRFs whose file does not say it.
    pub averages: Option<u32>,
    /// Window of the records of FRFs whose file does not state it, as
    /// [`Window::from_name`](crate::frf::Window::from_name) takes it.
    pub window: Option<String>,
    /// Lines that are passed over before the heading is looked for, for tables.
    #[serde(default)]
    pub skip_lines: usize,
    /// Meaning of the columns or records, where the file does not state it.
    #[serde(default)]
    pub channel: Vec<ChannelTable>,
    /// Contents of single files, where the files do not state them.
    #[serde(default)]
    pub file: Vec<FileTable>,
}

/// `[test.trigger]`.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TriggerTable {
    /// Distance of the force from its level that begins a hit, N.
    pub level_n: Option<f64>,
    /// Time before the hit that belongs to it, s.
    pub pretrigger_s: Option<f64>,
    /// Length of the record of each hit, s.
    pub length_s: Option<f64>,
}

/// A column by heading or number.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged, expecting = "expected a number from 1 or a heading")]
pub enum ColumnKey {
    /// Number from 1.
    Number(usize),
    /// Heading.
    Heading(String),
}

impl std::fmt::Display for ColumnKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            ColumnKey::Number(number) => write!(f, "{number}"),
            ColumnKey::Heading(heading) => write!(f, "{heading:?}"),
        }
    }
}

/// Meaning of one column of a table, or of one record of a file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChannelTable {
    /// Heading or number from 1 (for a universal file, the record's number within its hit).
    pub column: ColumnKey,
    /// `time`, `frequency`, `force`, `response`, `real`, `imaginary`, `complex`, `magnitude`,
    /// `phase` or `coherence`.
    pub role: Option<String>,
    /// Degree of freedom that it measures.
    pub dof: Option<Dof>,
    /// Quantity, checked against the unit.
    pub quantity: Option<String>,
    /// Unit of the numbers.
    pub unit: Option<String>,
    /// Calibration factor, 1 when not stated.
    pub scale: Option<f64>,
    /// Largest magnitude that the converter can hold, in the stated unit.
    pub full_scale: Option<f64>,
}

/// The scene's statement on the degrees of freedom of one file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileTable {
    /// Path as in `files`.
    pub path: String,
    /// Response.
    pub response: Option<Dof>,
    /// Reference (hit point).
    pub reference: Option<Dof>,
}

/// Position of a point, for the figures of shapes and for files.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointTable {
    /// Name as in the degrees of freedom of the test.
    pub name: String,
    /// Its position.
    pub at_m: [f64; 3],
}

/// A sensor or hit on a body of the model.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorTable {
    /// Degree of freedom as the test names it, on its positive axis.
    pub dof: Dof,
    /// Body of the model.
    pub body: Option<String>,
    /// Position in the model's frame.
    pub at_m: Option<[f64; 3]>,
    /// Direction of the axis in the model's frame; the axis itself when not stated.
    pub direction: Option<[f64; 3]>,
    /// A coordinate of the model, instead of body and position.
    pub coordinate: Option<String>,
}

impl SensorTable {
    /// The sensor that is meant; `None` when it names both a coordinate and a body, or neither in
    /// full.
    pub fn sensor(&self) -> Option<Sensor> {
        let target = match (&self.coordinate, &self.body, self.at_m) {
            (Some(name), None, None) => Target::Coordinate(name.clone()),
            (None, Some(body), Some(at_m)) => {
                let direction = self.direction.or_else(|| self.dof.axis().unit_vector())?;
                Target::BodyPoint {
                    body: body.clone(),
                    at_m,
                    direction,
                }
            }
            _ => return None,
        };
        Some(Sensor {
            dof: self.dof.positive(),
            target,
        })
    }
}

/// `[[configuration]]`: tests of the machine in another state than that of the model.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConfigurationTable {
    /// Name.
    pub name: String,
    /// Names of its tests.
    pub tests: Vec<String>,
    /// Another model: a built-in name, or a `model.toml` relative to the scene.
    pub model: Option<String>,
    /// Values of parameters that differ.
    #[serde(default)]
    pub parameters: BTreeMap<String, f64>,
    /// Parts that are added, as `theory --modify` states them.
    #[serde(default)]
    pub modify: Vec<String>,
    /// Free parameters that have another value than in the other configurations.
    #[serde(default)]
    pub separate: Vec<String>,
}

/// Parts that are added to the model of a configuration.
#[derive(Clone, Debug)]
pub struct AddedParts {
    /// Name of the configuration.
    pub configuration: String,
    /// The parts, as stated.
    pub modify: Vec<String>,
    /// Sensors of the scene, to which they are added.
    pub sensors: Vec<Sensor>,
}

/// The model, and values of its parameters.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelTable {
    /// A built-in model.
    pub name: Option<String>,
    /// A `model.toml` relative to the scene, or a `modes.json` of a model.
    pub file: Option<String>,
    /// Values by parameter name; nominal where not stated.
    #[serde(default)]
    pub parameters: BTreeMap<String, f64>,
    /// Whether the good part of a partly bad file of modes is sufficient.
    #[serde(default)]
    pub partial: bool,
    /// Parts that a configuration adds.
    #[serde(skip)]
    pub added: Option<AddedParts>,
}

/// `[frf]`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrfTable {
    /// `h1` (default), `h2` or `hv`.
    pub estimator: Option<String>,
    /// `hammer` (default), `random` or `sine`.
    pub excitation: Option<String>,
    /// Length of the blocks of random and sine excitation, s.
    pub block_length_s: Option<f64>,
    /// Length of the force window after the pulse, s.
    pub force_window_s: Option<f64>,
    /// `auto` (default: an exponential window where the responses have not decayed when the record
    /// ends) or `none`.
    pub response_window: Option<String>,
    /// Value of the exponential window at the record's end (a fraction, e.g. 0.01).
    pub response_window_end: Option<f64>,
    /// Whether what lies before the pulse of each hit is left out; with an exponential window alone
    /// when not stated.
    pub cut_pretrigger: Option<bool>,
    /// Response over force noise variance for `hv`, SI units.
    pub noise_ratio: Option<f64>,
    /// Whether the mean before the hit is removed from every channel; where it can be measured when
    /// not stated.
    pub remove_offset: Option<bool>,
    /// Assess the hits, but use all that `reject` does not name.
    #[serde(default)]
    pub keep_all: bool,
}

/// `[identify]`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IdentifyTable {
    /// `auto` (default), or the name of one of [`crate::identify::ESTIMATORS`].
    pub method: Option<String>,
    /// Highest model order, for a method that has one.
    pub order: Option<usize>,
}

/// `[report]`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReportTable {
    /// Caption of the comparison table.
    pub caption: Option<String>,
    /// Number of the first elastic root in the comparison, as a paper counts it; 1 when not stated.
    pub first_root: Option<usize>,
    /// The energy of the model's roots up to this frequency is printed; none when not stated.
    pub energies_to_hz: Option<f64>,
    /// Tables by the names of their tests; one table of all tests when not stated.
    #[serde(default)]
    pub table: Vec<ReportTableTable>,
}

/// `[[report.table]]`: one comparison table of some of the tests.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReportTableTable {
    /// Caption.
    pub caption: String,
    /// Names of its tests, in the order of their columns.
    pub tests: Vec<String>,
    /// Sentences to stand under it.
    #[serde(default)]
    pub notes: Vec<String>,
}

/// `[update]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct UpdateTable {
    /// Names of the parameters that may change; the stiffnesses of the model when neither this nor
    /// `[[update.parameter]]` is stated. Masses and geometry change only where they are named.
    pub parameters: Vec<String>,
    /// Parameters with an individual prior or bounds.
    pub parameter: Vec<UpdateParameterTable>,
    /// Names of the tests that count; all when not stated, none beside `published`.
    pub tests: Option<Vec<String>>,
    /// Whether the published natural frequencies of `expected.toml` count, those apart from which a
    /// parameter was inferred.
    pub published: bool,
    /// Modes in this band alone count, `[lo, hi]` in Hz; the others are checked against the result.
    pub band_hz: Option<[f64; 2]>,
    /// Whether modes of doubtful quality count.
    pub doubtful_modes: bool,
    /// What is compared: `modes` (not stated), `modal-dynamic`, `frf-complex` or
    /// `frf-log-magnitude`.
    pub residuals: Option<String>,
    /// Deviation of every frequency that the model is granted, a fraction.
    pub frequency_floor: Option<f64>,
    /// Whether the scatter between tests of one configuration is added to their deviations.
    pub scatter_between_tests: bool,
    /// Model error of shape components, as a part of their root mean square.
    pub shape_floor: Option<f64>,
    /// Deviation of shape components for which the test states none, as such a part.
    pub assumed_shape_std: Option<f64>,
    /// Deviation of every value of an FRF that the model is granted, a fraction of its magnitude.
    pub frf_floor: Option<f64>,
    /// Most lines of an FRF that count.
    pub frf_lines: Option<usize>,
    /// Whether shapes count (they do when not stated); they pair and follow modes all the same.
    pub shapes: Option<bool>,
    /// Prior deviation of parameters that state none, as a part of their value.
    pub prior_std: Option<f64>,
    /// Number of starts.
    pub starts: Option<usize>,
    /// Seed of the starts.
    pub seed: Option<u64>,
    /// Largest number of iterations from one start.
    pub max_iterations: Option<usize>,
    /// Whether single changes are tried.
    pub explain: bool,
    /// Parameters that are free in every one of those trials; with `explain` alone.
    pub always: Vec<String>,
}

/// `[[update.parameter]]`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UpdateParameterTable {
    /// Name in the model.
    pub name: String,
    /// `log-normal` or `normal`; by its value and bounds when not stated, whether `prior_std` is
    /// stated or not.
    pub prior: Option<String>,
    /// Prior deviation as a part of the value; for a value of 0 it is a quarter of the range
    /// between the bounds.
    pub prior_std: Option<f64>,
    /// Lower bound, in the parameter's unit.
    pub lower: Option<f64>,
    /// Upper bound.
    pub upper: Option<f64>,
}
