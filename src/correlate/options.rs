//! Pairing options hold the values of `[pair]` of a scene.

use serde::{Deserialize, Serialize};

use super::CorrelateError;

/// Reference of the relative frequency error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ErrorReference {
    /// (test − theory)/theory.
    #[default]
    Theory,
    /// (theory − test)/test.
    Test,
}

impl ErrorReference {
    /// The name in a scene and in `comparison.json`.
    pub fn name(self) -> &'static str {
        match self {
            ErrorReference::Theory => "theory",
            ErrorReference::Test => "test",
        }
    }

    /// The reference of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        let all = [ErrorReference::Theory, ErrorReference::Test];
        all.into_iter().find(|option| option.name() == name)
    }

    /// The signed frequency error as a fraction.
    pub fn error(self, test_hz: f64, theory_hz: f64) -> f64 {
        match self {
            ErrorReference::Theory => (test_hz - theory_hz) / theory_hz,
            ErrorReference::Test => (theory_hz - test_hz) / test_hz,
        }
    }
}

/// Options of pairing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PairOptions {
    /// Largest difference of the frequencies of a pair, a fraction of the theory's.
    pub max_frequency_error: f64,
    /// Smallest MAC of a pair, from 0 to below 1; a root that holds 0.6 of it of a mixed shape is a
    /// partner too, and ambiguous.
    pub min_mac: f64,
    /// A second partner whose cost is within this of the first makes a pair ambiguous. At the
    /// default gates 0.05 is 0.04 of a shape, or half of `max_frequency_error`; with frequencies
    /// alone, a part of `max_frequency_error`.
    pub ambiguous_margin: f64,
    /// Fewer common degrees of freedom than this are a finding.
    pub min_dofs: usize,
    /// Length by which rotations (rad) are multiplied where they meet translations in one MAC, m.
    pub rotation_length_m: Option<f64>,
    /// Reference of the relative frequency error.
    pub error_reference: ErrorReference,
}

impl Default for PairOptions {
    /// Gates of 20 % in frequency and 0.5 in MAC, an ambiguity margin of 0.05, 4 degrees of
    /// freedom, no length.
    fn default() -> Self {
        Self {
            max_frequency_error: 0.2,
            min_mac: 0.5,
            ambiguous_margin: 0.05,
            min_dofs: 4,
            rotation_length_m: None,
            error_reference: ErrorReference::Theory,
        }
    }
}

impl PairOptions {
    /// Checks every option.
    ///
    /// # Errors
    /// [`CorrelateError::Option`].
    pub fn validate(&self) -> Result<(), CorrelateError> {
        self.faults().into_iter().next().map_or(Ok(()), Err)
    }

    /// Every option that is out of its range.
    pub fn faults(&self) -> Vec<CorrelateError> {
        let positive = |value: f64| value.is_finite() && value > 0.0;
        let length = self.rotation_length_m.unwrap_or(1.0);
        let checks = [
            (
                "max_frequency_error",
                self.max_frequency_error,
                positive(self.max_frequency_error),
                "a fraction above 0",
            ),
            (
                "min_mac",
                self.min_mac,
                (0.0..1.0).contains(&self.min_mac),
                "0 to below 1",
            ),
            (
                "ambiguous_margin",
                self.ambiguous_margin,
                (0.0..=1.0).contains(&self.ambiguous_margin),
                "0 to 1",
            ),
            (
                "rotation_length_m",
                length,
                positive(length),
                "a finite length above 0 m",
            ),
        ];
        let wrong = checks.into_iter().filter(|(_, _, good, _)| !good);
        let fault = |(name, got, _, expected)| CorrelateError::Option {
            name,
            got,
            expected,
        };
        wrong.map(fault).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_error_references_have_their_sign_and_denominator() {
        assert!((ErrorReference::Theory.error(110.0, 100.0) - 0.1).abs() < 1e-15);
        assert!((ErrorReference::Test.error(125.0, 100.0) + 0.2).abs() < 1e-15);
    }

    #[test]
    fn the_defaults_hold_and_each_option_out_of_range_is_named() {
        assert_eq!(PairOptions::default().validate(), Ok(()));
        type Change = fn(&mut PairOptions);
        let bad: [(&str, Change); 5] = [
            ("max_frequency_error", |o| o.max_frequency_error = 0.0),
            ("max_frequency_error", |o| o.max_frequency_error = f64::NAN),
            ("min_mac", |o| o.min_mac = 1.0),
            ("ambiguous_margin", |o| o.ambiguous_margin = -0.1),
            ("rotation_length_m", |o| o.rotation_length_m = Some(-1.0)),
        ];
        for (expected, change) in bad {
            let mut options = PairOptions::default();
            change(&mut options);
            let error = options.validate().unwrap_err();
            assert!(matches!(error, CorrelateError::Option { name, .. } if name == expected));
        }
    }

    #[test]
    fn a_scene_may_state_some_options_and_no_unknown_ones() {
        let options: PairOptions =
            toml::from_str("min_mac = 0.8\nerror_reference = 'test'").unwrap();
        assert_eq!(
            (options.min_mac.to_bits(), options.min_dofs),
            (0.8f64.to_bits(), 4)
        );
        assert_eq!(options.error_reference, ErrorReference::Test);
        assert!(toml::from_str::<PairOptions>("mac = 0.8").is_err());
    }
}
