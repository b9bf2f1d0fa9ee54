//! The results of the study list errors and cost of every method by test.

use crate::modal::InputFile;

use super::super::{DetectionCounts, Method};
use super::condition::Condition;
use super::options::SpeedAccuracyOptions;

/// Cost of repeated runs of one identification.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timing {
    /// Warm runs, one that is not counted before them.
    pub repeats: usize,
    /// Median processor time, s.
    pub median_s: Option<f64>,
    /// Longest less shortest, s; a single run has none.
    pub spread_s: Option<f64>,
    /// Most memory taken at once by a run, bytes.
    pub peak_bytes: Option<u64>,
}

/// A method on the measured data of a test.
#[derive(Clone, Debug, PartialEq)]
pub struct DataRow {
    /// FRF estimator; `None` for a test whose files hold FRFs.
    pub estimator: Option<&'static str>,
    /// Distance of the lines, Hz.
    pub step_hz: f64,
    /// Method and order.
    pub method: Method,
    /// Whether the row is the refined solution, of any order, which has no error against itself.
    pub is_reference: bool,
    /// Errors against the refined solution.
    pub counts: DetectionCounts,
    /// Whether the method reports peaks with several modes, which it cannot separate.
    pub has_close_modes: bool,
    /// Cost of the identification.
    pub timing: Timing,
    /// Whether it is on the [front](super::pareto_front) of processor time and frequency error
    /// among all rows of its test.
    pub on_front: bool,
}

/// A method on the twin.
#[derive(Clone, Debug, PartialEq)]
pub struct TwinRow {
    /// Condition of the twin.
    pub condition: Condition,
    /// Noise.
    pub snr_db: f64,
    /// Method.
    pub method: Method,
    /// Errors against the truth, over all draws.
    pub counts: DetectionCounts,
}

/// Cost of a method on the twin in white noise, at the middle level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwinCost {
    /// Method.
    pub method: Method,
    /// Cost of one identification.
    pub timing: Timing,
    /// Whether it is on the [front](super::pareto_front) of processor time and frequency error at
    /// that level.
    pub on_front: bool,
}

/// Lower limits of the processor time of any method.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpeedLimits {
    /// Processor time of one forward transform of every function, s.
    pub transform_s: Option<f64>,
    /// Processor time of reading every value of the band once, s.
    pub pass_s: Option<f64>,
}

/// The results of a test.
#[derive(Clone, Debug, PartialEq)]
pub struct TestStudy {
    /// Its name.
    pub name: String,
    /// Its files or its recording.
    pub inputs: Vec<InputFile>,
    /// Functions and lines of the band, of the whole records.
    pub functions: usize,
    /// Lines of the band.
    pub lines: usize,
    /// Modes of the refined solution.
    pub refined_modes: usize,
    /// Rms stated deviation of the refined frequencies, relative.
    pub frequency_std: Option<f64>,
    /// Rms stated deviation of the refined damping ratios, relative.
    pub damping_std: Option<f64>,
    /// Whether the twin is of the recording's truth, and not of the refined modes.
    pub twin_of_truth: bool,
    /// Modes of the twin in the band.
    pub twin_modes: usize,
    /// Distance of its lines in white noise, Hz.
    pub twin_step_hz: f64,
    /// Methods on its measured data.
    pub data: Vec<DataRow>,
    /// Methods on its twin.
    pub twin: Vec<TwinRow>,
    /// Cost of each method on the twin.
    pub twin_costs: Vec<TwinCost>,
    /// Lower limits of processor time on the data and on the twin.
    pub limits: [SpeedLimits; 2],
    /// Comparisons that were not possible, and why.
    pub notes: Vec<String>,
}

impl TestStudy {
    /// The row of a method on the twin, at a level.
    pub fn twin_row(&self, condition: Condition, snr_db: f64, method: Method) -> Option<&TwinRow> {
        let mut rows = self.twin.iter();
        rows.find(|row| {
            let same_level = row.snr_db.total_cmp(&snr_db).is_eq();
            row.condition == condition && same_level && row.method == method
        })
    }
}

/// Speed against accuracy of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SpeedAccuracy {
    /// Title of the scene.
    pub title: String,
    /// Varied quantities.
    pub options: SpeedAccuracyOptions,
    /// Its tests.
    pub tests: Vec<TestStudy>,
}
