//! `selection.json`, schema `modalign-selection/1`: a person's choice of poles as a file.
//!
//! ```json
//! {
//!   "schema": "modalign-selection/1",
//!   "tolerance_hz": 0.5,
//!   "poles": [
//!     {"frequency_hz": 143.2, "damping_ratio": 0.004, "order": 24},
//!     {"frequency_hz": 210.8}
//!   ]
//! }
//! ```
//!
//! | key | meaning |
//! |---|---|
//! | `frequency_hz` | natural frequency, as the table of modes or the listing of `--stabilization` shows it |
//! | `damping_ratio` | a fraction, may be left out: tells poles of one frequency apart |
//! | `order` | model order at which the pole is to be taken, may be left out: any |
//! | `tolerance_hz` | farthest that the method's pole may lie from the frequency, may be left out: 1 % of the frequency |
//!
//! Unknown keys are an error.

use std::path::Path;

use serde::Deserialize;

use crate::modal::{PoleSelection, SelectedPole};

use crate::io::error::system;
use crate::io::{IoError, read_input};

/// The schema text.
pub const SELECTION_SCHEMA: &str = "modalign-selection/1";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SelectionFile {
    schema: String,
    tolerance_hz: Option<f64>,
    poles: Vec<SelectedJson>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SelectedJson {
    frequency_hz: f64,
    damping_ratio: Option<f64>,
    order: Option<usize>,
}

/// Reads a choice of poles from a file.
///
/// # Errors
/// [`IoError::System`] when it cannot be read; [`IoError::Json`] with line and column, or with the
/// pole whose value is impossible.
pub fn read_selection(path: &Path) -> Result<PoleSelection, IoError> {
    let name = path.display().to_string();
    let read = read_input(path).and_then(|bytes| {
        let invalid = |error| std::io::Error::new(std::io::ErrorKind::InvalidData, error);
        String::from_utf8(bytes).map_err(invalid)
    });
    selection_from_json(&read.map_err(system(&name, "read"))?, &name)
}

/// Reads a choice of poles.
///
/// # Errors
/// As [`read_selection`].
pub fn selection_from_json(text: &str, path: &str) -> Result<PoleSelection, IoError> {
    let error = |line, column, got| IoError::Json {
        path: path.to_owned(),
        line,
        column,
        got,
        expected: "schema modalign-selection/1",
    };
    let file: SelectionFile =
        serde_json::from_str(text).map_err(|e| error(e.line(), e.column(), e.to_string()))?;
    if file.schema != SELECTION_SCHEMA {
        return Err(error(1, 1, format!("schema {:?}", file.schema)));
    }
    if file.poles.is_empty() {
        return Err(error(1, 1, "no pole".to_owned()));
    }
    if let Some(got) = file.tolerance_hz.filter(|value| *value <= 0.0) {
        return Err(error(1, 1, format!("tolerance_hz {got}")));
    }
    let numbered = file.poles.into_iter().enumerate();
    let poles = numbered.map(|(index, pole)| {
        selected(pole).map_err(|got| error(1, 1, format!("pole {}: {got}", index + 1)))
    });
    Ok(PoleSelection {
        poles: poles.collect::<Result<_, _>>()?,
        tolerance_hz: file.tolerance_hz,
    })
}

fn selected(pole: SelectedJson) -> Result<SelectedPole, String> {
    if pole.frequency_hz <= 0.0 {
        let got = pole.frequency_hz;
        return Err(format!("frequency_hz {got}, expected more than 0"));
    }
    let possible = |zeta: &f64| *zeta > 0.0 && *zeta < 1.0;
    if let Some(got) = pole.damping_ratio.filter(|zeta| !possible(zeta)) {
        return Err(format!(
            "damping_ratio {got}, expected a fraction between 0 and 1"
        ));
    }
    Ok(SelectedPole {
        frequency_hz: pole.frequency_hz,
        damping_ratio: pole.damping_ratio,
        order: pole.order,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn selected_poles_are_read_with_missing_fields() {
        let text = r#"{"schema": "modalign-selection/1", "poles": [{"frequency_hz": 143.2, "damping_ratio": 0.004, "order": 24}, {"frequency_hz": 210.8}]}"#;
        let selection = selection_from_json(text, "s.json").unwrap();
        assert_eq!(selection.poles[0].order, Some(24));
        assert_eq!(selection.poles[0].damping_ratio, Some(0.004));
        let second = selection.poles[1];
        assert_eq!((second.damping_ratio, second.order), (None, None));
        assert!((selection.tolerance_of(&second) - 2.108).abs() < 1e-12);
    }

    #[test]
    fn invalid_pole_selections_are_refused_with_their_position() {
        let message = |text: &str| {
            let error = selection_from_json(text, "s.json").unwrap_err();
            error.to_string()
        };
        let with = |poles: &str, more: &str| {
            message(&format!(
                r#"{{"schema": "modalign-selection/1", "poles": [{poles}]{more}}}"#
            ))
        };
        assert!(message(r#"{"schema": "modalign-modes/1", "poles": []}"#).contains("modes/1"));
        assert!(with("", "").contains("no pole"));
        assert!(with(r#"{"frequency_hz": -1}"#, "").contains("pole 1: frequency_hz -1"));
        let damped = with(r#"{"frequency_hz": 1, "damping_ratio": 2}"#, "");
        assert!(damped.contains("damping_ratio 2"), "{damped}");
        assert!(with(r#"{"hz": 1}"#, "").contains("unknown field"));
        assert!(
            with(r#"{"frequency_hz": 1}"#, r#", "tolerance_hz": 0"#).contains("tolerance_hz 0")
        );
        assert!(message("{").starts_with("s.json:1:1"), "{}", message("{"));
    }
}
