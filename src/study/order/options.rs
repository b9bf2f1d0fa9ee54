//! What counts as enough.

use serde::Deserialize;

use super::super::StudyError;

/// `[order]` of a `study.toml`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OrderOptions {
    /// Names of the scene's tests; every test with data when none is named.
    pub tests: Vec<String>,
    /// A method is enough for a mode whose frequency it has within this much of the refined one,
    /// percent ...
    pub frequency_percent: f64,
    /// ... and whose damping ratio within this much, percent of itself.
    pub damping_percent: f64,
    /// A simpler theory is enough that has every natural frequency of the tests' bands within this
    /// much, percent.
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
