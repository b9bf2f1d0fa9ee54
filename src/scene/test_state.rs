//! The state of a structure during a test: its support, its loads and the date.

use serde::{Deserialize, Serialize};

use crate::theory::Support;

use super::SceneError;
use super::error::value_error;
use super::faults::Faults;

/// Absolute zero, °C.
const MIN_TEMPERATURE_C: f64 = -273.15;

/// `[test.state]`; what is not stated is unknown.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TestState {
    /// How the structure was held.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub support: Option<Support>,
    /// Highest rigid-body mode on the suspension or the mounts, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub highest_rigid_body_hz: Option<f64>,
    /// Mass of the structure as weighed, kg.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<f64>,
    /// Preload of its joints or bearings, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preload_n: Option<f64>,
    /// Static torque, N m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_nm: Option<f64>,
    /// Position of the shaft, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shaft_angle_deg: Option<f64>,
    /// Temperature, °C.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<f64>,
    /// Parts that were attached to it, such as a motor or a sensor with its mass.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub attached: Vec<String>,
    /// Date of the test, `YYYY-MM-DD`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
}

impl TestState {
    /// Whether nothing is stated.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The state of a test, its numbers and its date checked.
    ///
    /// # Errors
    /// [`SceneError::Value`] with the key.
    pub(super) fn checked(self, test: &str, path: &str) -> Result<Self, SceneError> {
        let mut faults = Faults::default();
        let mut refuse = |name: &str, got: &str, expected: &str| {
            let key = format!("[test.state] of {test:?}: {name}");
            faults.add(value_error(path, &key, got, expected));
        };
        let numbers = [
            (
                "highest_rigid_body_hz",
                self.highest_rigid_body_hz,
                f64::MIN_POSITIVE,
                "a frequency above 0 Hz",
            ),
            (
                "mass_kg",
                self.mass_kg,
                f64::MIN_POSITIVE,
                "a mass above 0 kg",
            ),
            ("preload_n", self.preload_n, 0.0, "a force of 0 N or more"),
            ("torque_nm", self.torque_nm, f64::MIN, "a finite torque"),
            (
                "shaft_angle_deg",
                self.shaft_angle_deg,
                f64::MIN,
                "a finite angle",
            ),
            (
                "temperature_c",
                self.temperature_c,
                MIN_TEMPERATURE_C,
                "-273.15 °C or more",
            ),
        ];
        for (name, value, minimum, expected) in numbers {
            if let Some(got) = value.filter(|x| !(x.is_finite() && *x >= minimum)) {
                refuse(name, &got.to_string(), expected);
            }
        }
        let has_rigid_body_modes =
            matches!(self.support, Some(Support::Suspended | Support::Mounted));
        if self.highest_rigid_body_hz.is_some() && !has_rigid_body_modes {
            let got = self.support.map_or("none", Support::name);
            let expected = "\"suspended\" or \"mounted\" beside highest_rigid_body_hz";
            refuse("support", got, expected);
        }
        if let Some(got) = self.attached.iter().find(|part| part.trim().is_empty()) {
            refuse("attached", &format!("{got:?}"), "a name for each part");
        }
        if let Some(got) = self.date.as_ref().filter(|date| !is_iso_date(date)) {
            let expected = "a date as \"2026-03-31\" (ISO 8601)";
            refuse("date", &format!("{got:?}"), expected);
        }
        faults.into_result().map(|()| self)
    }
}

/// Whether a text is a day of the Gregorian calendar, `YYYY-MM-DD`.
fn is_iso_date(text: &str) -> bool {
    let number = |range| -> Option<u32> {
        let digits: &str = text.get(range)?;
        let is_number = digits.bytes().all(|byte| byte.is_ascii_digit());
        is_number.then(|| digits.parse().ok()).flatten()
    };
    let bytes = text.as_bytes();
    let has_form = bytes.len() == 10 && bytes[4] == b'-' && bytes[7] == b'-';
    let (Some(year), Some(month), Some(day)) = (number(0..4), number(5..7), number(8..10)) else {
        return false;
    };
    let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let days = match month {
        2 if is_leap => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    };
    has_form && (1..=12).contains(&month) && (1..=days).contains(&day)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checked(text: &str) -> Result<TestState, String> {
        let state: TestState = toml::from_str(text).map_err(|error| error.to_string())?;
        let state = state.checked("hammer", "scene.toml");
        state.map_err(|error| error.to_string())
    }

    #[test]
    fn whole_state_is_read() {
        let state = checked(
            "support = \"suspended\"\nhighest_rigid_body_hz = 3.5\nmass_kg = 20.5\npreload_n = 200\n\
             torque_nm = -5.0\nshaft_angle_deg = 90\ntemperature_c = 21.5\n\
             attached = [\"motor\"]\ndate = \"2024-02-29\"",
        );
        let state = state.unwrap();
        assert_eq!(state.support, Some(Support::Suspended));
        assert_eq!(state.attached, ["motor"]);
        assert!(checked("").unwrap().is_empty());
    }

    #[test]
    fn impossible_value_is_refused_with_its_key() {
        for (text, named) in [
            ("support = \"hung\"", "suspended"),
            ("suport = \"fixed\"", "support"),
            (
                "support = \"suspended\"\nhighest_rigid_body_hz = -2.0",
                "[test.state] of \"hammer\": highest_rigid_body_hz: got -2",
            ),
            ("highest_rigid_body_hz = 2.0", "support: got none"),
            (
                "support = \"fixed\"\nhighest_rigid_body_hz = 2.0",
                "support: got fixed",
            ),
            ("mass_kg = 0.0", "mass_kg: got 0"),
            ("preload_n = -1.0", "preload_n: got -1"),
            ("torque_nm = nan", "torque_nm: got NaN"),
            ("shaft_angle_deg = inf", "shaft_angle_deg: got inf"),
            ("temperature_c = -300.0", "temperature_c: got -300"),
            ("attached = [\" \"]", "attached"),
            ("date = \"2023-02-29\"", "date: got \"2023-02-29\""),
            ("date = \"31.3.2026\"", "2026-03-31"),
            ("date = \"2026-+3-31\"", "2026-03-31"),
        ] {
            let message = checked(text).unwrap_err();
            assert!(message.contains(named), "{text}: {message}");
        }
    }
}
