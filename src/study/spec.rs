//! [`StudyFile`] holds `study.toml` as typed.

use std::path::PathBuf;

use serde::Deserialize;

use crate::scene::{SceneError, parse};

use super::breakdown::BreakdownTable;
use super::order::OrderOptions;
use super::speed_accuracy::SpeedAccuracyOptions;

/// The schema text of a spec.
pub const STUDY_SCHEMA: &str = "modalign-study/1";

/// A study as typed.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudyFile {
    /// `modalign-study/1`.
    pub schema: String,
    /// The scene's folder or file, relative to the spec; the folder of the spec without it.
    pub scene: Option<PathBuf>,
    /// `[breakdown]`.
    #[serde(default)]
    pub breakdown: BreakdownTable,
    /// `[order]`.
    #[serde(default)]
    pub order: OrderOptions,
    /// `[speed_accuracy]`.
    #[serde(default)]
    pub speed_accuracy: SpeedAccuracyOptions,
}

/// Reads a spec from its text.
///
/// # Errors
/// [`SceneError::Toml`] with file, line and column, for an unknown key with the nearest known one;
/// [`SceneError::Value`] for another schema.
pub fn parse_study(text: &str, path: &str) -> Result<StudyFile, SceneError> {
    let file: StudyFile = parse(text, path)?;
    if file.schema == STUDY_SCHEMA {
        return Ok(file);
    }
    Err(SceneError::Value {
        place: None,
        path: path.to_owned(),
        key: "schema".to_owned(),
        got: format!("{:?}", file.schema),
        expected: format!("{STUDY_SCHEMA:?}"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spec_is_read_and_an_unknown_key_names_the_nearest() {
        let text = "schema = \"modalign-study/1\"\n[speed_accuracy]\ndraws = 3\n";
        let file = parse_study(text, "study.toml").unwrap();
        assert_eq!(file.speed_accuracy.draws, 3);
        assert_eq!(
            file.speed_accuracy.repeats,
            SpeedAccuracyOptions::default().repeats
        );
        let wrong = parse_study(&text.replace("draws", "drawn"), "study.toml");
        let wrong = wrong.unwrap_err().to_string();
        assert!(
            wrong.starts_with("study.toml:3:1: got unknown key `drawn`"),
            "{wrong}"
        );
        assert!(wrong.ends_with("did you mean `draws`?"), "{wrong}");
        let other = parse_study("schema = \"modalign-scene/1\"", "study.toml");
        assert!(
            other
                .unwrap_err()
                .to_string()
                .contains("\"modalign-study/1\"")
        );
    }

    #[test]
    fn numbers_out_of_range_are_reported_with_their_key() {
        for (text, key) in [
            ("draws = 0", "draws"),
            ("snr_db = []", "snr_db"),
            ("snr_db = [60.0, 40.0]", "snr_db"),
            ("estimators = [\"h4\"]", "estimators"),
            ("record_shares = [1.5]", "record_shares"),
            ("orders = [2]", "orders"),
        ] {
            let text = format!("schema = \"modalign-study/1\"\n[speed_accuracy]\n{text}\n");
            let options = parse_study(&text, "study.toml").unwrap().speed_accuracy;
            let error = options.validate().unwrap_err().to_string();
            assert!(
                error.starts_with(&format!("[speed_accuracy] {key}: got ")),
                "{error}"
            );
        }
        assert!(SpeedAccuracyOptions::default().validate().is_ok());
    }
}
