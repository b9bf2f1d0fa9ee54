//! Whether a column of printed or computed abscissae is evenly spaced.

use super::{RowLines, row_error};
use crate::io::IoError;

/// Abscissae that were computed lie within this fraction of the spacing of their places.
const MAX_COMPUTED_ERROR_STEPS: f64 = 1e-6;

/// No rounding moves an abscissa by more than this fraction of the spacing.
const MAX_ROUNDING_STEPS: f64 = 0.5;

/// Start and spacing of an even column: (last − first)/(n − 1), because a printed spacing is
/// rounded.
///
/// Every value lies as near to its grid point as the rounding of the value and of both ends allows
/// (half a unit of the last printed digit each), or as single precision keeps it, and never half a
/// spacing off.
pub(in crate::io) fn even_axis(
    values: &[f64],
    scale: f64,
    what: &'static str,
    lines: &RowLines,
    path: &str,
) -> Result<(f64, f64), IoError> {
    let n = values.len();
    let error = |row, got, expected| row_error(path, lines, row, what, got, expected);
    if n < 2 {
        return Err(error(0, format!("{n} rows"), "two rows or more".to_owned()));
    }
    let step = (values[n - 1] - values[0]) / (n - 1) as f64;
    if !(step * scale > 0.0 && step.is_finite()) {
        return Err(error(
            n - 1,
            format!("{} after {}", values[n - 1], values[0]),
            "ascending values".to_owned(),
        ));
    }
    let place = |row: usize| values[0] + row as f64 * step;
    let most = MAX_ROUNDING_STEPS * step.abs();
    let off = |distance: f64| distance.is_nan() || distance.abs() > most;
    if let Some(row) = (1..n).find(|row| off(values[*row] - values[row - 1] - step)) {
        let got = format!("{} after {}", values[row], values[row - 1]);
        return Err(error(
            row,
            got,
            format!("steps of {step}; is a row missing?"),
        ));
    }
    match first_uneven_row(values, step, most) {
        Some(row) => Err(error(
            row,
            values[row].to_string(),
            format!("{} (evenly spaced by {step})", place(row)),
        )),
        None => Ok((scale * values[0], scale * step)),
    }
}

/// The first value farther from its place than its rounding explains, or than `most`.
fn first_uneven_row(values: &[f64], step: f64, most: f64) -> Option<usize> {
    let distance = |row: usize| (values[row] - (values[0] + row as f64 * step)).abs();
    let largest = values
        .iter()
        .fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let precision = (MAX_COMPUTED_ERROR_STEPS * step.abs()).max(f64::from(f32::EPSILON) * largest);
    let near = |distance: f64, tolerance: f64| distance <= tolerance.min(most);
    if (0..values.len()).all(|row| near(distance(row), precision)) {
        return None;
    }
    let printed = PrintedPrecision::of(values);
    let last = values.len() - 1;
    let ends = [values[0], values[last]].map(|value| printed.unit(value));
    (0..values.len()).find(|row| {
        let along = *row as f64 / last as f64;
        let of_ends = (1.0 - along) * ends[0] + along * ends[1];
        // The last digit of a decimal is itself rounded to a double.
        let rounding =
            0.5 * (printed.unit(values[*row]) + of_ends) * (1.0 + MAX_COMPUTED_ERROR_STEPS);
        !near(distance(*row), precision.max(rounding))
    })
}

/// How finely a column of numbers is printed: with so many decimals, or with so many significant
/// digits.
struct PrintedPrecision {
    /// Power of ten of the last digit of the finest number.
    last_power: i32,
    /// Most significant digits of a number.
    digits: i32,
}

impl PrintedPrecision {
    fn of(values: &[f64]) -> Self {
        let (mut last_power, mut digits) = (i32::MAX, 1);
        for value in values.iter().filter(|value| value.abs() > 0.0) {
            let (first, count) = first_power_and_digits(*value);
            last_power = last_power.min(first + 1 - count);
            digits = digits.max(count);
        }
        Self { last_power, digits }
    }

    /// One unit of the last printed digit of a value.
    fn unit(&self, value: f64) -> f64 {
        let significant = match value.abs() > 0.0 {
            true => first_power_and_digits(value).0 + 1 - self.digits,
            false => i32::MIN,
        };
        10f64.powi(self.last_power.max(significant))
    }
}

/// Power of ten of the first digit of a number, and its count of digits without zeros at the end.
fn first_power_and_digits(value: f64) -> (i32, i32) {
    let text = format!("{:e}", value.abs());
    let (mantissa, power) = text.split_once('e').unwrap_or((&text, "0"));
    let digits = mantissa.bytes().filter(u8::is_ascii_digit).count();
    (power.parse().unwrap_or(0), digits as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn even(values: &[f64]) -> Result<(f64, f64), String> {
        let found = even_axis(values, 1.0, "time", &RowLines::default(), "t.csv");
        found.map_err(|error| error.to_string())
    }

    fn printed(step: f64, count: usize, text: impl Fn(f64) -> String) -> Vec<f64> {
        let values = (0..count).map(|row| text(row as f64 * step).parse().unwrap());
        values.collect()
    }

    #[test]
    fn uneven_frequencies_are_not_made_even() {
        let error = even(&[100.0, 101.3, 102.1, 103.4, 104.0]).unwrap_err();
        assert_eq!(
            error,
            "t.csv: time: got 101.3 (row 2), expected 101 (evenly spaced by 1)"
        );
        assert!(even(&[0.0, 1.0, 2.001, 3.0]).is_ok(), "one unit of 0.001");
        assert!(even(&[0.0, 1.001, 2.003, 3.0]).is_err());
        assert!(even(&[0.0, 1.0, 3.0, 4.0, 5.0]).is_err());
    }

    #[test]
    fn rounded_and_computed_abscissae_are_even() {
        let step = 1.0 / 51_200.0;
        let fixed = printed(step, 4, |value| format!("{value:.6}"));
        assert_eq!(fixed[2].to_bits(), 0.000039_f64.to_bits());
        assert!(even(&fixed).is_ok());
        for text in [
            |value: f64| format!("{value:.6}"),
            |value: f64| format!("{value:.6e}"),
            |value: f64| format!("{value:.5e}"),
            |value: f64| format!("{value}"),
            |value: f64| f64::from(value as f32).to_string(),
        ] {
            let values = printed(step, 20_000, text);
            let (_, found) = even(&values).unwrap();
            assert!((found / step - 1.0).abs() < 1e-5, "{found}");
        }
        assert!(even(&printed(0.7, 500, |value| (value + 0.35).to_string())).is_ok());
    }
}
