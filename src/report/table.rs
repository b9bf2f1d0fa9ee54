//! A table has columns of text or numbers, which each renderer writes with its digits.

use serde::{Deserialize, Serialize};

/// Alignment of the text of a column.
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

/// Maximum decimals of a printed standard deviation.
const MAX_STD_DECIMALS: i32 = 9;

/// Content of one row in one column.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Cell {
    /// Text.
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
    /// No value: a dash for people, an empty field for programs.
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

    /// A number whose positive values carry a sign, too, or missing.
    pub fn signed(value: Option<f64>, decimals: usize) -> Self {
        value.map_or(Cell::Missing, |value| Cell::Number {
            value,
            decimals,
            signed: true,
        })
    }

    /// A count.
    pub fn count(value: usize) -> Self {
        Cell::number(Some(value as f64), 0)
    }

    /// A standard deviation, or missing; with more decimals where these leave fewer than two digits
    /// of it.
    pub fn std(value: Option<f64>, decimals: usize) -> Self {
        let two_digits = |std: f64| 1 - std.log10().floor() as i32;
        let wanted = value
            .filter(|std| *std > 0.0 && std.is_finite())
            .map_or(0, |std| two_digits(std).clamp(0, MAX_STD_DECIMALS) as usize);
        Cell::number(value, decimals.max(wanted))
    }

    /// The text for people, with a dash for what is missing.
    pub fn display(&self) -> String {
        match self {
            Cell::Text(text) => text.clone(),
            Cell::Number {
                value,
                decimals,
                signed: false,
            } => without_sign_of_zero(format!("{value:.decimals$}")),
            Cell::Number {
                value,
                decimals,
                signed: true,
            } => {
                let text = without_sign_of_zero(format!("{value:.decimals$}"));
                match *value > 0.0 && text.chars().any(|c| matches!(c, '1'..='9')) {
                    true => format!("+{text}"),
                    false => text,
                }
            }
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

/// Removes the sign of a number that rounds to zero: `-0.00` becomes `0.00`.
fn without_sign_of_zero(text: String) -> String {
    match text.strip_prefix('-') {
        Some(unsigned) if unsigned.chars().all(|c| matches!(c, '0' | '.')) => unsigned.to_owned(),
        _ => text,
    }
}

/// A number with at most `digits` significant digits and no trailing zeros; with a power of ten
/// below 0.001 and from a million.
pub(super) fn significant(value: f64, digits: usize) -> String {
    let rounded = format!("{value:.*e}", digits.max(1) - 1);
    let value = rounded.parse().unwrap_or(value);
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

/// A number with seven significant digits and its trailing zeros; with a power of ten below 0.0001
/// and from 10⁹.
pub(super) fn seven_digits(value: f64) -> String {
    let magnitude = value.abs().log10().floor();
    if value == 0.0 {
        return "0".to_owned();
    }
    if !(-4.0..9.0).contains(&magnitude) {
        return format!("{value:.6e}");
    }
    let decimals = (6.0 - magnitude).max(0.0) as usize;
    format!("{value:.decimals$}")
}

/// A table with its caption and footnotes.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Table {
    /// Caption.
    pub caption: String,
    /// Columns.
    pub columns: Vec<Column>,
    /// Cells, each row as long as `columns`.
    pub rows: Vec<Vec<Cell>>,
    /// Paragraphs under the table.
    pub footnotes: Vec<String>,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_standard_deviation_is_not_printed_as_zero() {
        for (std, expected) in [
            (Some(0.0), "0.000"),
            (Some(2.894e-4), "0.00029"),
            (Some(0.0346), "0.035"),
            (Some(1.5), "1.500"),
            (Some(1e-12), "0.000000000"),
            (None, "—"),
        ] {
            assert_eq!(Cell::std(std, 3).display(), expected);
        }
    }

    #[test]
    fn zero_is_printed_without_a_sign() {
        for (value, expected) in [(-0.04, "0.0"), (-0.06, "-0.1"), (0.04, "0.0")] {
            assert_eq!(Cell::number(Some(value), 1).display(), expected);
        }
        for (value, expected) in [
            (-0.04, "0.0"),
            (-0.06, "-0.1"),
            (0.04, "0.0"),
            (0.06, "+0.1"),
        ] {
            assert_eq!(Cell::signed(Some(value), 1).display(), expected);
        }
    }

    #[test]
    fn numbers_are_rounded_to_their_significant_digits() {
        for (value, digits, expected) in [
            (6.927526007451222e10, 7, "6.927526e10"),
            (7e10, 7, "7e10"),
            (0.25, 6, "0.25"),
            (300.0000001, 4, "300"),
            (-732.5666, 5, "-732.57"),
            (0.0, 4, "0"),
        ] {
            assert_eq!(significant(value, digits), expected);
        }
    }
}
