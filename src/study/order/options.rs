//! [`OrderOptions`] states the errors below which a method or a theory is sufficient.

use serde::Deserialize;

use super::super::StudyError;

/// `[order]` of a `study.toml`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OrderOptions {
    /// Names of the scene's tests; every test with data when none is named.
    pub tests: Vec<String>,
    /// Largest frequency error of a sufficient method against the refined solution, percent.
    pub frequency_percent: f64,
    /// Largest damping error of a sufficient method, percent of the refined damping ratio.
    pub damping_percent: f64,
    /// Largest error of a sufficient simpler theory at any natural frequency in the bands of the
    /// tests, percent.
    pub theory_percent: f64,
}

impl Default for OrderOptions {
    fn default() -> Self {
        Self {
            tests: Vec::new(),
            frequency_percent: 0.1,
            damping_percent: 10.0,
            theory_percent: 1.0,
        }
    }
}

impl OrderOptions {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`StudyError::Value`] with the key.
    pub fn validate(&self) -> Result<(), StudyError> {
        let all = [
            ("frequency_percent", self.frequency_percent),
            ("damping_percent", self.damping_percent),
            ("theory_percent", self.theory_percent),
        ];
        let wrong = |(_, got): &(&str, f64)| !(got.is_finite() && *got > 0.0);
        match all.into_iter().find(wrong) {
            None => Ok(()),
            Some((key, got)) => Err(StudyError::Value {
                key: format!("[order] {key}"),
                got: got.to_string(),
                expected: "a number above 0".to_owned(),
            }),
        }
    }
}
