//! [`SpeedAccuracyOptions`] states the varied quantities and the number of draws.

use serde::Deserialize;

use crate::frf::Estimator;
use crate::identify::{MAX_ORDER, MIN_HIGHEST_ORDER};

use super::super::StudyError;

/// Maximum number of draws: the quantiles of an error do not improve beyond it.
const MAX_DRAWS: usize = 100_000;

/// `[speed_accuracy]` of a `study.toml`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SpeedAccuracyOptions {
    /// Names of the scene's tests; every test with data when none is named.
    pub tests: Vec<String>,
    /// FRF estimators in addition to that of the scene: `h1`, `h2`, `hv`.
    pub estimators: Vec<String>,
    /// Lengths of record in addition to the whole, as fractions of it.
    pub record_shares: Vec<f64>,
    /// Highest model orders in addition to the choice of each method, on the FRFs of the scene.
    pub orders: Vec<usize>,
    /// Noise on the twin: rms of a function over the band over the rms noise of a line, dB,
    /// ascending.
    pub snr_db: Vec<f64>,
    /// Draws of the noise at each level.
    pub draws: usize,
    /// End of the twin's short records, in time constants `1/(ζω)` of its slowest mode.
    pub record_time_constants: f64,
    /// Lines that the twin has at least for each half-power width of its narrowest mode, where its
    /// test has more; all of the test's lines without it.
    pub lines_per_width: Option<f64>,
    /// Timed runs of each identification, after one that is not counted.
    pub repeats: usize,
    /// Largest error of a frequency of an accurate method, %.
    pub frequency_percent: f64,
    /// Largest error of a damping ratio of an accurate method, %.
    pub damping_percent: f64,
    /// Seed of the draws.
    pub seed: u64,
}

impl Default for SpeedAccuracyOptions {
    fn default() -> Self {
        Self {
            tests: Vec::new(),
            estimators: vec!["h1".to_owned(), "h2".to_owned(), "hv".to_owned()],
            record_shares: vec![0.5],
            orders: vec![16, 32],
            snr_db: vec![30.0, 40.0, 50.0, 60.0, 70.0, 80.0],
            draws: 4,
            record_time_constants: 2.0,
            lines_per_width: None,
            repeats: 3,
            frequency_percent: 0.1,
            damping_percent: 10.0,
            seed: 1,
        }
    }
}

impl SpeedAccuracyOptions {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`StudyError::Value`] with the key.
    pub fn validate(&self) -> Result<(), StudyError> {
        let share = |fraction: &f64| *fraction > 0.0 && *fraction < 1.0;
        let finite = |number: &f64| number.is_finite();
        let ascending = self.snr_db.windows(2).all(|pair| pair[0] < pair[1]);
        let levels = !self.snr_db.is_empty() && self.snr_db.iter().all(finite) && ascending;
        let known = |name: &String| Estimator::from_name(name).is_some();
        let positive = |number: f64| number > 0.0 && number.is_finite();
        let constants = self.record_time_constants;
        let dense = self.lines_per_width.unwrap_or(1.0);
        let checks = [
            (
                "estimators",
                self.estimators.iter().all(known),
                format!("{:?}", self.estimators),
                "names among h1, h2, hv",
            ),
            (
                "record_shares",
                self.record_shares.iter().all(share),
                format!("{:?}", self.record_shares),
                "shares between 0 and 1",
            ),
            (
                "orders",
                self.orders
                    .iter()
                    .all(|order| (MIN_HIGHEST_ORDER..=MAX_ORDER).contains(order)),
                format!("{:?}", self.orders),
                "orders of 4 to 500",
            ),
            (
                "snr_db",
                levels,
                format!("{:?}", self.snr_db),
                "one level or more, in ascending order",
            ),
            (
                "draws",
                (1..=MAX_DRAWS).contains(&self.draws),
                self.draws.to_string(),
                "1 to 100000",
            ),
            (
                "record_time_constants",
                positive(constants),
                constants.to_string(),
                "a number above 0",
            ),
            (
                "lines_per_width",
                positive(dense),
                dense.to_string(),
                "a number above 0",
            ),
            (
                "frequency_percent",
                positive(self.frequency_percent),
                self.frequency_percent.to_string(),
                "a number above 0",
            ),
            (
                "damping_percent",
                positive(self.damping_percent),
                self.damping_percent.to_string(),
                "a number above 0",
            ),
            (
                "repeats",
                self.repeats > 0,
                self.repeats.to_string(),
                "1 or more",
            ),
        ];
        match checks.into_iter().find(|(_, holds, _, _)| !holds) {
            None => Ok(()),
            Some((key, _, got, expected)) => Err(StudyError::Value {
                key: format!("[speed_accuracy] {key}"),
                got,
                expected: expected.to_owned(),
            }),
        }
    }

    /// Noise at which methods are timed and compared by cost: that in the middle, dB.
    pub fn middle_snr_db(&self) -> f64 {
        self.snr_db[self.snr_db.len() / 2]
    }
}
