//! The page writes numbers with the digits that their standard deviation supports.

/// Whether a number is written without a power of ten.
fn is_plain(size: f64) -> bool {
    size == 0.0 || (1e-3..1e5).contains(&size)
}

/// Power of ten of the second digit of a standard deviation.
fn second_digit_power(std: f64) -> i32 {
    let text = format!("{std:.1e}");
    let power = text
        .split('e')
        .nth(1)
        .and_then(|exponent| exponent.parse().ok());
    power.map_or(0, |exponent: i32| exponent - 1)
}

/// A standard deviation with two digits.
pub(super) fn two_digits(std: f64) -> String {
    match is_plain(std) && std < 100.0 {
        true => format!("{std:.*}", (-second_digit_power(std)).max(0) as usize),
        false => format!("{std:.1e}"),
    }
}

/// A value down to the second digit of its standard deviation.
pub(super) fn round_to_std(value: f64, std: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let last = second_digit_power(std);
    if is_plain(value.abs()) && last <= 0 {
        return format!("{value:.*}", (-last).min(12) as usize);
    }
    let first = value.abs().log10().floor() as i32;
    format!("{value:.*e}", (first - last).clamp(0, 12) as usize)
}

/// A number with four digits, with a power of ten where that is shorter.
pub(super) fn four_digits(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        return "0".to_owned();
    }
    if !is_plain(size) {
        return format!("{value:.3e}");
    }
    let decimals = 3 - size.log10().floor() as i32;
    format!("{value:.*}", decimals.clamp(0, 6) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        for (value, expected) in [
            (0.0, "0"),
            (1.0, "1.000"),
            (123.456, "123.5"),
            (-2.1e11, "-2.100e11"),
            (5e-4, "5.000e-4"),
        ] {
            assert_eq!(four_digits(value), expected);
        }
    }

    #[test]
    fn values_end_at_the_second_digit_of_their_standard_deviation() {
        for (value, std, expected) in [
            (1.23456, 0.0234, "1.235 ± 0.023"),
            (123.456, 2.34, "123.5 ± 2.3"),
            (1.23456e7, 2.34e4, "1.2346e7 ± 2.3e4"),
            (-0.5, 0.0996, "-0.50 ± 0.10"),
            (0.0, 0.0011, "0 ± 0.0011"),
        ] {
            let text = format!("{} ± {}", round_to_std(value, std), two_digits(std));
            assert_eq!(text, expected);
        }
    }
}
