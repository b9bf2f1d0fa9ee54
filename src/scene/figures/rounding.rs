//! Rounding gives the numbers of figures the resolution of a screen.

/// A number rounded to significant digits.
pub(super) fn rounded(value: f64, digits: usize) -> f64 {
    let text = format!("{value:.*e}", digits - 1);
    text.parse().unwrap_or(value)
}

/// A number rounded to decimals.
pub(super) fn to_decimals(value: f64, decimals: i32) -> f64 {
    let scale = 10f64.powi(decimals);
    (value * scale).round() / scale
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_and_stay_what_they_are() {
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-15 * b.abs();
        assert!(near(rounded(1.234_567e-9, 4), 1.235e-9));
        assert!(near(rounded(-98_765.0, 3), -98_800.0));
        assert!(near(rounded(0.0, 3), 0.0) && rounded(f64::NAN, 3).is_nan());
        assert!(near(to_decimals(-0.123_4, 2), -0.12));
    }
}
