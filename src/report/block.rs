//! A report consists of headings, paragraphs, tables and findings.

use serde::{Deserialize, Serialize};

use crate::finding::Finding;

use super::{Language, Table};

/// One piece of a report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Block {
    /// A heading.
    Heading(String),
    /// A paragraph.
    Text(String),
    /// A table.
    Table(Table),
    /// Findings on the data.
    Findings {
        /// In the order of the report.
        findings: Vec<Finding>,
        /// The language of their sentences.
        language: Language,
    },
}
