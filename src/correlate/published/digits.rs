//! The digits of a printed number give its rounding.

/// Digits of a printed number, which say which numbers round to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Digits {
    /// Number of digits after the point.
    Decimals(usize),
    /// Number of significant digits, as in `2.512e9`.
    Significant(usize),
}

impl Digits {
    /// Whether a value rounds to the printed one; at a tie to either side.
    pub fn round_to(self, value: f64, printed: f64) -> bool {
        let half_digit = match self {
            Digits::Decimals(decimals) => 0.5 * power(decimals),
            Digits::Significant(digits) => {
                let magnitude = printed.abs().log10().floor();
                if !magnitude.is_finite() {
                    return value == 0.0;
                }
                0.5 * 10f64.powf(magnitude + 1.0) * power(digits)
            }
        };
        let rounding = 4.0 * f64::EPSILON * value.abs().max(printed.abs());
        (value - printed).abs() <= half_digit + rounding
    }

    /// The number with these digits.
    pub fn text(self, value: f64) -> String {
        match self {
            Digits::Decimals(decimals) => format!("{value:.decimals$}"),
            Digits::Significant(digits) => {
                let after = digits.saturating_sub(1);
                format!("{value:.after$e}")
            }
        }
    }

    /// With more digits.
    pub fn finer(self, more: usize) -> Self {
        match self {
            Digits::Decimals(decimals) => Digits::Decimals(decimals + more),
            Digits::Significant(digits) => Digits::Significant(digits + more),
        }
    }
}

/// Ten to minus this.
fn power(digits: usize) -> f64 {
    10f64.powi(-i32::try_from(digits).unwrap_or(i32::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_rounds_to_its_printed_digits() {
        let four = Digits::Significant(4);
        assert!(four.round_to(2.512238e9, 2.512e9));
        assert!(four.round_to(3.108191e10, 3.108e10));
        assert!(!four.round_to(2.502804e9, 2.512e9));
        assert!(!four.round_to(2.5126e9, 2.512e9));
        assert!(four.round_to(9.9996, 10.0) && four.round_to(0.0, 0.0));
        assert!(!four.round_to(1e-9, 0.0));
        assert!(Digits::Decimals(2).round_to(1671.427105, 1671.43));
        assert!(!Digits::Decimals(2).round_to(2088.007554, 2088.00));
        assert_eq!(four.text(2.512238e9), "2.512e9");
        assert_eq!(four.finer(2).text(2.512238e9), "2.51224e9");
        assert_eq!(Digits::Decimals(1).finer(2).text(7.52), "7.520");
    }
}
