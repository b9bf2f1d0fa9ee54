//! A table has columns of text or numbers, which each renderer writes with its digits.

use serde::{Deserialize, Serialize};

use crate::printable::printable_cell;

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
/// The last printed digit of a value is at least this part of it.
const FINEST_RELATIVE_DIGIT: f64 = 1e-5;
/// The same of a damping ratio, which is known less well.
const FINEST_DAMPING_DIGIT: f64 = 1e-4;
/// Digits of a number that is rounded to that part of it.
const MAX_DIGITS: usize = 5;
/// Decimals of a 0 beside values that have few; with more it prints as `0`.
const MAX_DECIMALS_OF_ZERO: usize = 3;
/// Normalised deviations beyond this are all the same to a reader.
const LARGEST_NORMALISED: f64 = 1000.0;

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
    /// A measure of correlation up to 1, which prints as 1 only where it is 1, rounding aside.
    Correlation {
        /// The value.
        value: f64,
        /// Digits after the point in rendered text; CSV keeps them all.
        decimals: usize,
    },
    /// A deviation over its standard deviation, in one decimal and with its sign; beyond a thousand
    /// only that is said.
    Normalised(f64),
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

    /// A value with the decimals of two digits of its standard deviation, but none finer than
    /// 0.001 % of the value; without a standard deviation with as many as that allows.
    pub fn measured(value: Option<f64>, std: Option<f64>) -> Self {
        let decimals = value.map_or(0, |value| measured_decimals(value, std));
        Cell::number(value, decimals)
    }

    /// A damping ratio as [`Cell::measured`], but none finer than 0.01 % of the value.
    pub fn damping(value: Option<f64>, std: Option<f64>) -> Self {
        let finest = |value: f64| decimals_not_finer_than(FINEST_DAMPING_DIGIT * value.abs());
        let decimals = value.map_or(0, |value| measured_decimals(value, std).min(finest(value)));
        Cell::number(value, decimals)
    }

    /// The cell with no digit finer than 0.001 % of its value; also a decimal number that is text.
    pub(super) fn without_fine_digits(self, is_number: bool) -> Self {
        match self {
            Cell::Number {
                value,
                decimals,
                signed,
            } => Cell::Number {
                value,
                decimals: match value == 0.0 {
                    true if decimals > MAX_DECIMALS_OF_ZERO => 0,
                    true => decimals,
                    false => decimals.min(measured_decimals(value, None)),
                },
                signed,
            },
            Cell::Text(text) if is_number && text.contains('.') => match text.parse::<f64>() {
                Ok(value) if digit_count(&text) > MAX_DIGITS => {
                    Cell::Text(significant(value, MAX_DIGITS))
                }
                _ => Cell::Text(text),
            },
            other => other,
        }
    }

    /// A MAC, an MPC or a coherence, or missing.
    pub fn mac(value: Option<f64>, decimals: usize) -> Self {
        value.map_or(Cell::Missing, |value| Cell::Correlation { value, decimals })
    }

    /// The text for people, with a dash for what is missing.
    pub fn display(&self) -> String {
        match self {
            Cell::Text(text) => printable_cell(text).into_owned(),
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
            Cell::Correlation { value, decimals } => {
                let largest_below_one = 1.0 - 0.1_f64.powi(*decimals as i32);
                let shown = match *value < 1.0 - ROUNDING_OF_ONE {
                    true => value.min(largest_below_one),
                    false => *value,
                };
                Cell::number(Some(shown), *decimals).display()
            }
            Cell::Normalised(value) if value.abs() > LARGEST_NORMALISED => {
                let (relation, sign) = if *value > 0.0 { (">", "") } else { ("<", "-") };
                format!("{relation} {sign}{LARGEST_NORMALISED}")
            }
            Cell::Normalised(value) => Cell::signed(Some(*value), 1).display(),
            Cell::Missing => "—".to_owned(),
        }
    }

    /// The text for programs: full precision, empty for what is missing.
    pub fn exact(&self) -> String {
        match self {
            Cell::Text(text) => text.clone(),
            Cell::Number { value, .. }
            | Cell::Correlation { value, .. }
            | Cell::Normalised(value) => value.to_string(),
            Cell::Missing => String::new(),
        }
    }
}

/// Largest rounding of a correlation of a shape with itself.
const ROUNDING_OF_ONE: f64 = 1e-12;

/// Number of digits of a number in text without leading zeros and exponent.
fn digit_count(text: &str) -> usize {
    let mantissa = text.split(['e', 'E']).next().unwrap_or_default();
    let mantissa = mantissa.trim_start_matches(['-', '+', '0', '.']);
    mantissa.chars().filter(char::is_ascii_digit).count()
}

/// Decimals at which a digit counts `resolution` or more.
fn decimals_not_finer_than(resolution: f64) -> usize {
    (-resolution.log10()).floor().clamp(0.0, 17.0) as usize
}

fn measured_decimals(value: f64, std: Option<f64>) -> usize {
    if value == 0.0 {
        return 0;
    }
    let finest = decimals_not_finer_than(FINEST_RELATIVE_DIGIT * value.abs());
    let of_std = std
        .filter(|std| *std > 0.0 && std.is_finite())
        .map(|std| (1.0 - std.log10().floor()).max(0.0) as usize);
    of_std.map_or(finest, |of_std| of_std.min(finest))
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
    /// The table without the columns of which no row has a value.
    pub(super) fn without_missing_columns(&self) -> Self {
        let mut table = self.clone();
        let is_missing = |cell: &Cell| match cell {
            Cell::Missing => true,
            Cell::Text(text) => text.trim().is_empty(),
            _ => false,
        };
        for index in (1..table.columns.len()).rev() {
            let is_empty = |row: &Vec<Cell>| row.get(index).is_none_or(is_missing);
            if !table.rows.is_empty() && table.rows.iter().all(is_empty) {
                table.columns.remove(index);
                for row in table.rows.iter_mut().filter(|row| row.len() > index) {
                    row.remove(index);
                }
            }
        }
        table
    }
}

impl Table {
    /// The same table with this many digits after the point of every number.
    pub fn with_decimals(mut self, wanted: usize) -> Self {
        for cell in self.rows.iter_mut().flatten() {
            if let Cell::Number { decimals, .. } | Cell::Correlation { decimals, .. } = cell {
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
    fn a_number_on_a_screen_has_no_digit_finer_than_a_hundred_thousandth() {
        for (value, decimals, expected) in [
            (1403.9634, 4, "1404.0"),
            (0.062826, 6, "0.062826"),
            (0.201531, 6, "0.20153"),
            (1e-9, 6, "0.000000"),
            (0.0, 6, "0"),
            (0.0, 1, "0.0"),
            (7293.9, 1, "7293.9"),
        ] {
            let cell = Cell::number(Some(value), decimals).without_fine_digits(true);
            assert_eq!(cell.display(), expected);
        }
        for (text, is_number, expected) in [
            ("2.378993130496427", true, "2.379"),
            ("3.800333e-10", true, "3.8003e-10"),
            ("138949549", true, "138949549"),
            ("0.000123", true, "0.000123"),
            ("1.2345678", false, "1.2345678"),
            ("version 1.2345678", true, "version 1.2345678"),
        ] {
            let cell = Cell::text(text).without_fine_digits(is_number);
            assert_eq!(cell.display(), expected);
        }
    }

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
    fn value_has_two_digits_of_its_std_and_none_below_a_hundred_thousandth() {
        for (value, std, expected) in [
            (5690.771, Some(0.0011), "5690.8"),
            (1419.3512, Some(2.4), "1419.4"),
            (1419.3512, Some(24.0), "1419"),
            (12.345678, Some(0.0123), "12.346"),
            (12.345678, None, "12.346"),
            (1000.0, None, "1000.00"),
            (0.1002, Some(0.0004), "0.10020"),
            (0.0, None, "0"),
        ] {
            assert_eq!(Cell::measured(Some(value), std).display(), expected);
        }
        assert_eq!(Cell::measured(None, Some(1.0)), Cell::Missing);
    }

    #[test]
    fn mac_below_one_is_not_printed_as_one() {
        let of_itself = 1.0 - 3.0 * f64::EPSILON;
        for (mac, expected) in [
            (0.9995, "0.999"),
            (0.99999, "0.999"),
            (of_itself, "1.000"),
            (1.0, "1.000"),
        ] {
            assert_eq!(Cell::mac(Some(mac), 3).display(), expected);
        }
        assert_eq!(Cell::mac(Some(0.8766), 3).display(), "0.877");
        assert_eq!(Cell::mac(Some(0.99999), 3).exact(), "0.99999");
    }

    #[test]
    fn normalised_deviation_beyond_a_thousand_says_only_that() {
        for (value, expected) in [
            (718_251.4, "> 1000"),
            (-312_111.0, "< -1000"),
            (1000.0, "+1000.0"),
            (-3.94, "-3.9"),
        ] {
            assert_eq!(Cell::Normalised(value).display(), expected);
        }
        assert_eq!(Cell::Normalised(-312_111.5).exact(), "-312111.5");
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

    #[test]
    fn columns_without_a_value_are_left_out() {
        let table = Table {
            columns: ["mode", "MPC", "remark", "f (Hz)"]
                .map(Column::text)
                .to_vec(),
            rows: vec![
                vec![
                    Cell::text("1"),
                    Cell::Missing,
                    Cell::text(""),
                    Cell::Missing,
                ],
                vec![
                    Cell::text("2"),
                    Cell::Missing,
                    Cell::text(" "),
                    Cell::count(3),
                ],
            ],
            ..Table::default()
        };
        let shown = table.without_missing_columns();
        let heads: Vec<&str> = shown.columns.iter().map(|c| c.head.as_str()).collect();
        assert_eq!(heads, ["mode", "f (Hz)"]);
        assert!(shown.rows.iter().all(|row| row.len() == 2));
        let empty = Table {
            rows: Vec::new(),
            ..table
        };
        assert_eq!(empty.without_missing_columns().columns.len(), 4);
    }
}
