//! Words that the sentences of several studies share.

pub(super) use crate::printable::counted;

/// `a, b and c`.
pub(super) fn listed<T: AsRef<str>>(all: &[T]) -> String {
    let all: Vec<&str> = all.iter().map(AsRef::as_ref).collect();
    match all.split_last() {
        None => String::new(),
        Some((last, [])) => (*last).to_owned(),
        Some((last, others)) => format!("{} and {last}", others.join(", ")),
    }
}

/// Two significant digits, without an exponent: `0.00085`, `1.7`, `120`.
pub(super) fn two_digits(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let rounded: f64 = format!("{value:.1e}").parse().unwrap_or(value);
    let decimals = 1 - rounded.abs().log10().floor() as i32;
    format!("{rounded:.*}", decimals.max(0) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_two_digits() {
        for (value, text) in [
            (8.54e-4, "0.00085"),
            (1.72, "1.7"),
            (123.0, "120"),
            (0.999, "1.0"),
            (0.0, "0"),
        ] {
            assert_eq!(two_digits(value), text);
        }
    }
}
