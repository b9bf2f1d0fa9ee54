//! The pieces a report is made of.

use serde::{Deserialize, Serialize};

use crate::finding::Finding;

use super::Language;

/// Where a column's text stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Align {
    /// At the left, for text.
    Left,
    /// At the right, for numbers.
    Right,
}

/// Head of a column.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Column {
    /// Heading, with the unit.
    pub head: String,
    /// Alignment.
    pub align: Align,
}

impl Column {
    /// A column of numbers.
    pub fn number(head: impl Into<String>) -> Self {
        Self {
            head: head.into(),
            align: Align::Right,
        }
    }

    /// A column of text.
    pub fn text(head: impl Into<String>) -> Self {
        Self {
            head: head.into(),
            align: Align::Left,
        }
    }
}

/// One field of a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Cell {
    /// Text as it is.
    Text(String),
    /// A number with fixed decimals.
    Number {
        /// The value.
        value: f64,
        /// Digits after the point in rendered text; CSV keeps them all.
        decimals: usize,
        /// Whether a positive value carries its sign.
        signed: bool,
    },
    /// Not known: a dash for people, an empty field for programs.
    Missing,
}

impl Cell {
    /// Text.
    pub fn text(text: impl Into<String>) -> Self {
        Cell::Text(text.into())
    }

    /// A number, or missing.
    pub fn number(value: Option<f64>, decimals: usize) -> Self {
        value.map_or(Cell::Missing, |value| Cell::Number {
            value,
            decimals,
            signed: false,
        })
    }

    /// A number that always carries its sign, or missing.
    pub fn signed(value: Option<f64>, decimals: usize) -> Self {
        value.map_or(Cell::Missing, |value| Cell::Number {
            value,
            decimals,
            signed: true,
        })
    }

    /// The text for people, with a dash for what is missing.
    pub fn display(&self) -> String {
        match self {
            Cell::Text(text) => text.clone(),
            Cell::Number {
                value,
                decimals,
                signed: false,
            } => format!("{value:.decimals$}"),
            Cell::Number {
                value,
                decimals,
                signed: true,
            } => format!("{value:+.decimals$}"),
            Cell::Missing => "—".to_owned(),
        }
    }

    /// The text for programs: full precision, empty for what is missing.
    pub fn exact(&self) -> String {
        match self {
            Cell::Text(text) => text.clone(),
            Cell::Number { value, .. } => value.to_string(),
            Cell::Missing => String::new(),
        }
    }
}

/// A table with its caption and footnotes.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Table {
    /// Caption.
    pub caption: String,
    /// Heads.
    pub columns: Vec<Column>,
    /// Fields, each row as long as `columns`.
    pub rows: Vec<Vec<Cell>>,
    /// Lines under the table.
    pub footnotes: Vec<String>,
}

/// One piece of a report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Block {
    /// A heading.
    Heading(String),
    /// A paragraph.
    Text(String),
    /// A table.
    Table(Table),
    /// What the data said.
    Findings {
        /// In the order in which they are told.
        findings: Vec<Finding>,
        /// The language of their sentences.
        language: Language,
    },
}

impl Table {
    /// The same table with this many digits after the point of every number.
    pub fn with_decimals(mut self, wanted: usize) -> Self {
        for cell in self.rows.iter_mut().flatten() {
            if let Cell::Number { decimals, .. } = cell {
                *decimals = wanted;
            }
        }
        self
    }
}
