//! The language of headings and findings.

use serde::{Deserialize, Serialize};

use crate::finding::{Code, Finding, Severity};

/// A language of headings and findings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Language {
    /// English.
    #[default]
    English,
    /// Simplified Chinese.
    Chinese,
}

impl Language {
    /// The language of this code: `en` or `zh`.
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "en" => Some(Language::English),
            "zh" => Some(Language::Chinese),
            _ => None,
        }
    }

    /// The sentence of a finding.
    pub fn finding(self, finding: &Finding) -> String {
        match self {
            Language::English => finding.to_string(),
            Language::Chinese => finding.chinese(),
        }
    }

    /// The sentence of a code, without location and numbers.
    pub fn sentence(self, code: Code) -> &'static str {
        match self {
            Language::English => code.sentence(),
            Language::Chinese => code.chinese_sentence(),
        }
    }

    /// Cause, consequence and remedy of a code.
    pub fn explanation(self, code: Code) -> &'static str {
        match self {
            Language::English => code.explanation(),
            Language::Chinese => code.chinese_explanation(),
        }
    }

    /// The name of a severity.
    pub fn severity(self, severity: Severity) -> String {
        match self {
            Language::English => severity.to_string(),
            Language::Chinese => severity.chinese().to_owned(),
        }
    }
}
